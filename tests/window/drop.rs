//! Drops files on a window as a file manager does (the XDND protocol, version 5).

use std::path::Path;
use std::time::{Duration, Instant};

use x11rb::connection::Connection as _;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ClientMessageEvent, ConnectionExt as _, CreateWindowAux, EventMask, PropMode,
    SELECTION_NOTIFY_EVENT, SelectionNotifyEvent, WindowClass,
};
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// The time limit for a window to accept a dropped file.
const LONG: Duration = Duration::from_secs(60);

/// Drops a file on a window, at a place on the screen.
pub(super) fn drop_file(display: &str, window: u32, path: &Path, [x, y]: [u32; 2]) {
    let (x11, screen) = RustConnection::connect(Some(display)).unwrap();
    let root = x11.setup().roots[screen].root;
    let own = x11.generate_id().unwrap();
    let aux = CreateWindowAux::new();
    x11.create_window(0, own, root, 0, 0, 1, 1, 0, WindowClass::INPUT_ONLY, 0, &aux).unwrap();
    let atom = |name: &str| x11.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom;
    let uris = atom("text/uri-list");
    let send = |name: &str, data: [u32; 5]| {
        let message = ClientMessageEvent::new(32, window, atom(name), data);
        x11.send_event(false, window, EventMask::NO_EVENT, message).unwrap();
        x11.flush().unwrap();
    };
    x11.set_selection_owner(own, atom("XdndSelection"), 0_u32).unwrap();
    send("XdndEnter", [own, 5 << 24, uris, 0, 0]);
    send("XdndPosition", [own, 0, x << 16 | y, 0, atom("XdndActionCopy")]);
    let (status, finished) = (atom("XdndStatus"), atom("XdndFinished"));
    let start = Instant::now();
    let mut is_accepted = false;
    loop {
        assert!(start.elapsed() < LONG, "the window does not take {}", path.display());
        match x11.poll_for_event().unwrap() {
            Some(Event::SelectionRequest(asked)) => {
                let text = format!("file://{}\r\n", path.display());
                let (to, property) = (asked.requestor, asked.property);
                x11.change_property8(PropMode::REPLACE, to, property, uris, text.as_bytes())
                    .unwrap();
                let answer = SelectionNotifyEvent {
                    response_type: SELECTION_NOTIFY_EVENT,
                    sequence: 0,
                    time: asked.time,
                    requestor: to,
                    selection: asked.selection,
                    target: asked.target,
                    property,
                };
                x11.send_event(false, to, EventMask::NO_EVENT, answer).unwrap();
                x11.flush().unwrap();
            }
            Some(Event::ClientMessage(message)) if message.type_ == status && !is_accepted => {
                is_accepted = true;
                assert_eq!(message.data.as_data32()[1] & 1, 1, "{} is refused", path.display());
                send("XdndDrop", [own, 0, 0, 0, 0]);
            }
            Some(Event::ClientMessage(message)) if message.type_ == finished => return,
            Some(_) => {}
            None => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}
