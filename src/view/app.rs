//! Handles the window's events one after the other, and draws a frame when something has changed.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::io::{Error, Result};
use freeform_surface::Scene;
use glam::dvec2;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::keyboard::ModifiersState;
use winit::window::WindowId;

use super::action::Action;
use super::gl::GlWindow;
use super::loading::Loading;
use super::overlay::Overlay;
use super::panel::Drawn;
use super::screen::Screen;
use super::shading::ScaleView;
use super::state::{Message, Request, State};
use super::watch::Watch;
use super::{ViewArguments, files, input, panel};
use crate::io::input::{LoadArguments, PictureArguments};
use crate::io::output::{Output, replace};
use crate::io::scale;

/// A file and a hash of its contents.
#[derive(Debug, PartialEq)]
struct Contents {
    file: PathBuf,
    /// The hash of its bytes; `None` if it cannot be read.
    hash: Option<u64>,
}

impl Contents {
    fn of(file: PathBuf) -> Self {
        let hash = std::fs::read(&file).ok().map(|bytes| {
            let mut hasher = DefaultHasher::new();
            bytes.hash(&mut hasher);
            hasher.finish()
        });
        Self { file, hash }
    }
}

/// The time that a changed file must stay unchanged before it is read, because editors write in several steps.
const REST: Duration = Duration::from_millis(100);
/// How long the window waits for the first scene before it opens without it.
const AT_FIRST: Duration = Duration::from_millis(500);
/// The time between looks whether a scene is read.
const POLL: Duration = Duration::from_millis(30);

/// Shows a window until it is closed.
///
/// # Errors
/// The scene cannot be read, or there is no window system or no OpenGL 4.5.
pub(super) fn run(arguments: &ViewArguments) -> Result<()> {
    let mut loading = None;
    let mut scene = match &arguments.scene {
        None => Scene::listing16(),
        Some(path) => {
            let reading = Loading::start(arguments.load, path)?;
            match reading.wait(AT_FIRST) {
                Some(scene) => scene?,
                // The window opens empty.
                None => {
                    loading = Some((reading, Then::OpenFirst));
                    Scene::default()
                }
            }
        }
    };
    arguments.picture.apply(&mut scene.settings)?;
    let no_display = |error: winit::error::EventLoopError| {
        // The text before the last colon names a line of winit's source.
        let error = error.to_string();
        let reason = error.rsplit(": ").next().unwrap_or_default();
        let what = format!("no display ({reason}); freeform render draws without one");
        Error::Window(what)
    };
    let events = EventLoop::<Changed>::with_user_event().build().map_err(no_display)?;
    let mut app = App {
        state: State::new(scene, arguments.scene.clone()),
        window: None,
        error: None,
        modifiers: ModifiersState::default(),
        last_turn: None,
        saved: None,
        proxy: arguments.watch.then(|| events.create_proxy()),
        watch: None,
        load: arguments.load,
        picture: arguments.picture,
        read: Vec::new(),
        loading,
        poll_at: Some(Instant::now()),
        reload_at: None,
        frame_at: None,
        frames: 0,
    };
    app.watch();
    events.run_app(&mut app).map_err(no_display)?;
    app.error.map_or(Ok(()), Err)
}

/// What happens with a scene when it is read.
enum Then {
    /// It is the first one: without it there is no window.
    OpenFirst,
    /// It is shown.
    Open,
    /// It is shown; if it cannot be read, the first of these that can.
    OpenOneOf(Vec<PathBuf>),
    /// It replaces the scene that is shown; the camera stays.
    Reload,
}

/// The scene's file changed on the disk.
#[derive(Debug)]
struct Changed;

/// The window and the objects that belong to it.
struct Shown {
    // Fields are dropped in this order: OpenGL objects before the context.
    scale: ScaleView,
    overlay: Overlay,
    screen: Screen,
    gl: GlWindow,
    title: String,
}

impl Shown {
    fn new(events: &ActiveEventLoop) -> Result<Self> {
        let gl = GlWindow::new(events, "freeform")?;
        let overlay = Overlay::new(events, gl.gl(), gl.window())?;
        let (scale, screen) = (ScaleView::default(), Screen::new(gl.gl())?);
        Ok(Self { scale, overlay, screen, gl, title: String::new() })
    }
}

struct App {
    state: State,
    window: Option<Shown>,
    /// The reason why there is no window.
    error: Option<Error>,
    modifiers: ModifiersState,
    /// The time at which the turntable last turned.
    last_turn: Option<Instant>,
    /// The file to which the scene was saved.
    saved: Option<PathBuf>,
    /// Reports changed files to the event loop, if they are watched.
    proxy: Option<EventLoopProxy<Changed>>,
    watch: Option<Watch>,
    /// Options for reading scenes.
    load: LoadArguments,
    picture: PictureArguments,
    /// The contents of the scene's files when they were last read.
    read: Vec<Contents>,
    /// The scene that is being read.
    loading: Option<(Loading, Then)>,
    /// The time at which to look whether it is read.
    poll_at: Option<Instant>,
    /// The time at which the changed file will be read.
    reload_at: Option<Instant>,
    /// The time of the next frame of the panel.
    frame_at: Option<Instant>,
    frames: u64,
}

impl ApplicationHandler<Changed> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.window.is_some() {
            return;
        }
        match Shown::new(events) {
            Ok(shown) => {
                let size = shown.gl.window().inner_size();
                self.state.resize(size.width, size.height);
                shown.gl.window().request_redraw();
                self.window = Some(shown);
            }
            Err(error) => {
                self.error = Some(error);
                events.exit();
            }
        }
    }

    fn new_events(&mut self, events: &ActiveEventLoop, cause: StartCause) {
        if !matches!(cause, StartCause::ResumeTimeReached { .. }) {
            return;
        }
        let now = Instant::now();
        let is_due = |time: &mut Option<Instant>| time.take_if(|then| *then <= now).is_some();
        if is_due(&mut self.reload_at) {
            self.reload();
            self.redraw();
        }
        if is_due(&mut self.poll_at) {
            self.poll(events);
        }
        if is_due(&mut self.frame_at) {
            self.redraw();
        }
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        if self.loading.is_some() && self.poll_at.is_none() {
            self.poll_at = Some(Instant::now() + POLL);
        }
        let times = [self.frame_at, self.reload_at, self.poll_at];
        events.set_control_flow(match times.into_iter().flatten().min() {
            Some(then) => ControlFlow::WaitUntil(then),
            None => ControlFlow::Wait,
        });
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => self.draw(),
            WindowEvent::Resized(size) => {
                if let Some(shown) = &self.window {
                    shown.gl.resize();
                }
                self.state.resize(size.width, size.height);
                self.hand_on(&event);
            }
            WindowEvent::DroppedFile(ref path) => {
                self.start(path, Then::Open);
                // The panel learns from this event that no file hovers over it any more.
                self.hand_on(&event);
            }
            WindowEvent::KeyboardInput { event: ref key, is_synthetic, .. } => {
                if self.window.as_ref().is_some_and(|shown| shown.overlay.wants_keys()) {
                    self.state.note_press();
                    self.hand_on(&event);
                } else if key.state == ElementState::Pressed && !is_synthetic {
                    let action = input::chord(&key.logical_key, self.modifiers)
                        .and_then(Action::of)
                        .filter(|action| !key.repeat || action.repeats());
                    if let Some(action) = action {
                        self.act(events, action);
                    }
                }
            }
            WindowEvent::ModifiersChanged(modifiers) => {
                self.modifiers = modifiers.state();
                self.hand_on(&event);
            }
            WindowEvent::CursorMoved { .. }
            | WindowEvent::CursorLeft { .. }
            | WindowEvent::MouseInput { .. }
            | WindowEvent::MouseWheel { .. } => self.mouse(&event),
            WindowEvent::Destroyed | WindowEvent::Moved(_) => {}
            _ => self.hand_on(&event),
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, _: Changed) {
        self.reload_at = Some(Instant::now() + REST);
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The window is dropped while the window system still exists.
        self.window = None;
    }
}

impl App {
    fn redraw(&self) {
        if let Some(shown) = &self.window {
            shown.gl.window().request_redraw();
        }
    }

    /// Passes an event to the panel, which may have to be redrawn for it.
    fn hand_on(&mut self, event: &WindowEvent) {
        if let Some(shown) = &mut self.window {
            shown.overlay.take(shown.gl.window(), event);
            shown.gl.window().request_redraw();
        }
    }

    fn act(&mut self, events: &ActiveEventLoop, action: Action) {
        self.state.note_press();
        match self.state.apply(action) {
            None => {}
            Some(Request::Quit) => events.exit(),
            Some(Request::Leave) => match self.loading.take() {
                Some((loading, _)) => {
                    let message = format!("{} is abandoned", loading.path().display());
                    self.state.message = Some(Message::Done(message));
                    self.state.progress = None;
                }
                None => events.exit(),
            },
            Some(Request::NextScene) => self.open_next(),
            Some(Request::Screenshot) => self.screenshot(),
            Some(Request::Save) => self.save(),
        }
        self.redraw();
    }

    /// Passes the mouse's events to the panel if the cursor is over it, and otherwise to the picture.
    fn mouse(&mut self, event: &WindowEvent) {
        let Some(shown) = &mut self.window else { return };
        let place = match event {
            WindowEvent::CursorMoved { position, .. } => dvec2(position.x, position.y),
            _ => self.state.pointer.place(),
        };
        let (over, show) = shown.overlay.is_over(place.x, place.y);
        shown.overlay.take(shown.gl.window(), event);
        let for_panel = over && !self.state.pointer.is_busy();
        let changed = match *event {
            WindowEvent::CursorMoved { .. } => self.state.move_to(place, !for_panel),
            WindowEvent::CursorLeft { .. } => self.state.leave(),
            WindowEvent::MouseInput { state, button, .. } => {
                match (input::button(button), state) {
                    (Some(button), ElementState::Pressed) if !for_panel => {
                        self.state.press_button(button, self.modifiers.shift_key());
                    }
                    (Some(button), ElementState::Released) => self.state.release_button(button),
                    _ => self.state.note_press(),
                }
                true
            }
            WindowEvent::MouseWheel { delta, .. } if !for_panel => {
                self.state.turn_wheel(input::wheel_steps(delta));
                true
            }
            _ => false,
        };
        if changed || show {
            shown.gl.window().request_redraw();
        }
    }

    /// Begins to read a scene, and abandons the one that is being read.
    fn start(&mut self, path: &Path, then: Then) {
        self.state.progress = None;
        let loading = Loading::start(self.load, path);
        self.loading = self.state.report(loading).map(|loading| (loading, then));
    }

    /// Begins to read the next scene of the folder that can be read.
    fn open_next(&mut self) {
        let next = files::next_scenes(self.state.file().map(PathBuf::as_path));
        if let Some(next) = self.state.report(next) {
            self.start_one_of(next);
        }
    }

    fn start_one_of(&mut self, mut paths: Vec<PathBuf>) {
        if !paths.is_empty() {
            let first = paths.remove(0);
            self.start(&first, Then::OpenOneOf(paths));
        }
    }

    /// Shows the scene that is being read if it is complete, and otherwise how far it is. If it cannot be read, the
    /// current scene stays.
    fn poll(&mut self, events: &ActiveEventLoop) {
        let Some((loading, _)) = &self.loading else { return };
        let Some(result) = loading.wait(Duration::ZERO) else {
            let progress = loading.progress();
            if progress != self.state.progress {
                self.state.progress = progress;
                self.redraw();
            }
            return;
        };
        let Some((loading, then)) = self.loading.take() else { return };
        let result = result.and_then(|mut scene| {
            self.picture.apply(&mut scene.settings)?;
            Ok(scene)
        });
        self.state.progress = None;
        self.redraw();
        match (result, then) {
            (Ok(scene), Then::Reload) => {
                self.state.reload(scene);
                // The scene may name other files now.
                self.watch();
            }
            (Ok(scene), _) => {
                self.state.open(scene, Some(loading.path().to_owned()));
                self.saved = None;
                self.watch();
            }
            (Err(error), Then::OpenFirst) => {
                self.error = Some(error);
                events.exit();
            }
            (Err(error), then) => {
                self.state.report::<()>(Err(error));
                if let Then::OpenOneOf(others) = then {
                    self.start_one_of(others);
                }
            }
        }
    }

    /// Watches the files of the scene, if this was requested.
    fn watch(&mut self) {
        self.watch = None;
        if let (Some(proxy), Some(file)) = (&self.proxy, self.state.file()) {
            let mut files = self.state.scene().files.clone();
            files.push(file.clone());
            self.read = files.into_iter().map(Contents::of).collect();
            let files = self.read.iter().map(|contents| contents.file.as_path());
            let proxy = proxy.clone();
            // Sending fails only if the event loop has ended.
            let watch = Watch::new(files, move || drop(proxy.send_event(Changed)));
            self.watch = self.state.report(watch);
        }
    }

    /// Begins to read the scene's files again, unless another scene is being read. If they cannot be read, the scene
    /// stays as it was.
    fn reload(&mut self) {
        let Some(path) = self.state.file().cloned() else { return };
        if !matches!(self.loading, None | Some((_, Then::Reload))) {
            return;
        }
        // A file whose contents are the same has not changed. Files that cannot be read are reported.
        let read: Vec<Contents> =
            self.read.iter().map(|contents| Contents::of(contents.file.clone())).collect();
        let same = read == self.read && read.iter().all(|contents| contents.hash.is_some());
        self.read = read;
        if !same {
            self.start(&path, Then::Reload);
        }
    }

    /// Writes the scene beside its file: under a new name the first time, and to that file again later.
    fn save(&mut self) {
        let file = self.state.file().map(PathBuf::as_path);
        let new = self.saved.is_none();
        let path = match &self.saved {
            Some(path) => Ok(path.clone()),
            None => files::new_file(file, "edited-", "toml"),
        };
        let written = path.and_then(|path| {
            write_scene(&self.state.saved_scene(), &path).inspect_err(|_| {
                if new {
                    // The file is empty: it only reserved the name.
                    let _ = std::fs::remove_file(&path);
                }
            })?;
            Ok(path)
        });
        if let Some(path) = self.state.report(written) {
            self.state.message = Some(Message::Done(format!("wrote {}", path.display())));
            self.saved = Some(path);
        }
    }

    fn screenshot(&mut self) {
        let Some(shown) = &mut self.window else { return };
        let written =
            shown.screen.bring_and_draw(&mut self.state).map_err(Error::from).and_then(|()| {
                let mut image = shown.screen.picture(&self.state)?;
                if let Some(analysis) = self.state.scene().settings.shown_analysis() {
                    scale::draw(&mut image, &analysis, shown.screen.curvature_limit(&self.state));
                }
                let path = files::new_file(self.state.file().map(PathBuf::as_path), "", "png")?;
                Output::File(path.clone()).write(&image).inspect_err(|_| {
                    // The file is empty: it only reserved the name.
                    let _ = std::fs::remove_file(&path);
                })?;
                Ok(path)
            });
        if let Some(path) = self.state.report(written) {
            self.state.message = Some(Message::Done(format!("wrote {}", path.display())));
        }
    }

    fn draw(&mut self) {
        self.turn();
        let Some(shown) = &self.window else { return };
        let size = shown.gl.window().inner_size();
        if size.width == 0 || size.height == 0 {
            // The window is minimised; nothing is drawn until it is restored.
            self.frame_at = None;
            return;
        }
        let Some(shown) = &mut self.window else { return };
        let start = Instant::now();
        let mut draws = false;
        // Edits in the panel are visible in the same frame.
        let mut again = Duration::MAX;
        for _ in 0..2 {
            if self.state.changed() || shown.screen.is_unfinished(&self.state) {
                draws = true;
                shown.gl.reset();
                let drawn = shown.screen.bring_and_draw(&mut self.state);
                self.state.report(drawn);
            }
            shown.gl.begin();
            shown.screen.show();
            let drawn = Drawn {
                stats: shown.screen.stats(),
                ms: shown.screen.ms(),
                curvature_limit: shown.screen.curvature_limit(&self.state),
            };
            again = shown.overlay.paint(shown.gl.window(), |context| {
                shown.scale.paint(context, &self.state, drawn.curvature_limit);
                panel::show(context, &mut self.state, &drawn)
            });
            if !self.state.changed() {
                break;
            }
        }
        let (stats, ms) = (shown.screen.stats(), shown.screen.ms());
        let swapped = shown.gl.swap();
        self.state.report(swapped);
        let title = self.state.title(&stats, ms);
        if title != shown.title {
            shown.gl.window().set_title(&title);
            shown.title = title;
        }
        self.frames += 1;
        log::debug!(
            "frame {}: {} in {:.1} ms",
            self.frames,
            if draws { "picture" } else { "panel" },
            start.elapsed().as_secs_f64() * 1e3,
        );
        for error in shown.gl.take_errors() {
            log::error!("OpenGL: {error}");
            self.state.message = Some(Message::Error(format!("OpenGL: {error}")));
        }
        if self.state.turntable || self.state.changed() || again.is_zero() {
            self.redraw();
        }
        self.frame_at = Instant::now().checked_add(again).filter(|_| !again.is_zero());
    }

    /// Advances the turntable by the time since the last frame.
    fn turn(&mut self) {
        let now = Instant::now();
        let last = self.last_turn.replace(now).filter(|_| self.state.turntable);
        if let Some(last) = last {
            // After a long frame, the turntable turns by at most a tenth of a second.
            self.state.advance((now - last).as_secs_f64().min(0.1));
        }
    }
}

/// Writes a scene and the files that it needs beside it.
fn write_scene(scene: &Scene, path: &Path) -> Result<()> {
    let written = scene.to_toml(path)?;
    let text = (path.to_owned(), written.text.into_bytes());
    for (path, bytes) in written.files.into_iter().chain([text]) {
        replace(&path, |file| file.write_all(&bytes))
            .map_err(|error| Error::file("write", path, error))?;
    }
    Ok(())
}
