//! Runs the program on a display of its own, sends it keys, and reads its pictures.

use std::io::{BufRead, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use freeform_surface::Image;
use tempfile::TempDir;

/// If no frame is drawn for this time, drawing is complete.
const STILL: Duration = Duration::from_millis(250);
/// The time limit of every step, also on a slow machine.
const LONG: Duration = Duration::from_secs(60);

/// The program's window on a screen that no other program has.
pub(crate) struct Screen {
    server: Child,
    program: Child,
    display: String,
    /// The folder in which the server keeps its pixels.
    folder: TempDir,
    window: String,
    frames: Arc<AtomicU64>,
    /// The number of files that are being read.
    reading: Arc<AtomicU64>,
    waits_for_files: bool,
    log: Arc<Mutex<String>>,
    size: (u32, u32),
}

impl Screen {
    /// Starts a server and the program in it, and waits until its window is drawn.
    pub(crate) fn start(arguments: &[&str]) -> Self {
        Self::start_by(arguments, None)
    }

    /// Starts the program with another program that reads STEP files, and never waits for the latter.
    pub(crate) fn start_with_helper(arguments: &[&str], helper: &Path) -> Self {
        Self::start_by(arguments, Some(helper))
    }

    fn start_by(arguments: &[&str], helper: Option<&Path>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut server = Command::new("Xvfb")
            .args([
                "-displayfd",
                "1",
                "-screen",
                "0",
                "1000x600x24",
                "-nocursor",
                "-nolisten",
                "tcp",
                "-fbdir",
            ])
            .arg(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb, which setup.sh installs");
        let mut number = String::new();
        BufReader::new(server.stdout.as_mut().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        let mut program = Command::new(env!("CARGO_BIN_EXE_freeform"))
            .arg("view")
            .args(arguments)
            .current_dir(folder.path())
            .env("DISPLAY", &display)
            .env_remove("WAYLAND_DISPLAY")
            .env_remove("WAYLAND_SOCKET")
            .env("LIBGL_ALWAYS_SOFTWARE", "1")
            .envs(helper.map(|helper| ("FREEFORM_OCCT", helper)))
            .env("RUST_LOG", "warn,freeform=debug")
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let [frames, reading] = [0, 0].map(|start| Arc::new(AtomicU64::new(start)));
        let log = Arc::new(Mutex::new(String::new()));
        let errors = program.stderr.take().unwrap();
        std::thread::spawn({
            let (frames, reading) = (Arc::clone(&frames), Arc::clone(&reading));
            let log = Arc::clone(&log);
            move || {
                for line in BufReader::new(errors).lines().map_while(Result::ok) {
                    if line.contains("debug: frame ") {
                        frames.fetch_add(1, Ordering::SeqCst);
                    } else if line.contains("debug: reading ") {
                        reading.fetch_add(1, Ordering::SeqCst);
                    } else if line.contains("debug: ended reading ") {
                        reading.fetch_sub(1, Ordering::SeqCst);
                    } else {
                        let mut log = log.lock().unwrap();
                        log.push_str(&line);
                        log.push('\n');
                    }
                }
            }
        });
        let size = (1000, 600);
        let window = String::new();
        let waits_for_files = helper.is_none();
        let mut screen = Self {
            server,
            program,
            display,
            folder,
            window,
            frames,
            reading,
            waits_for_files,
            log,
            size,
        };
        let start = Instant::now();
        while screen.frames() == 0 {
            assert!(start.elapsed() < LONG, "no frame: {}", screen.log());
            std::thread::sleep(Duration::from_millis(20));
        }
        screen.rest();
        let found = screen.xdotool(&["search", "--onlyvisible", "--name", "triangles"]);
        screen.window = found.trim().to_owned();
        let window = screen.window.clone();
        // Without a window manager, the window must be given the keyboard focus.
        screen.xdotool(&["mousemove", "500", "590", "windowfocus", &window]);
        screen.rest();
        screen
    }

    fn xdotool(&self, arguments: &[&str]) -> String {
        let output = Command::new("xdotool")
            .args(arguments)
            .env("DISPLAY", &self.display)
            .output()
            .expect("xdotool, which setup.sh installs");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "xdotool {arguments:?}: {error}{}", self.log());
        String::from_utf8(output.stdout).unwrap()
    }

    /// The program's output, except for its lines about frames and files.
    pub(crate) fn log(&self) -> String {
        self.log.lock().unwrap().clone()
    }

    /// Waits until nothing is read or drawn any more.
    pub(crate) fn rest(&self) {
        assert!(self.rests_within(LONG), "it never rests: {}", self.log());
        assert_eq!(self.log(), "", "errors and warnings");
    }

    /// Waits until nothing is read or drawn any more, but not longer than `limit`; returns false if it still is.
    pub(crate) fn rests_within(&self, limit: Duration) -> bool {
        let start = Instant::now();
        let mut last = (self.frames(), Instant::now());
        while last.1.elapsed() < STILL {
            if start.elapsed() > limit {
                return false;
            }
            std::thread::sleep(Duration::from_millis(10));
            let frames = self.frames();
            let is_reading = self.waits_for_files && self.reading.load(Ordering::SeqCst) > 0;
            if frames != last.0 || is_reading {
                last = (frames, Instant::now());
            }
        }
        true
    }

    /// Presses keys one after the other.
    pub(crate) fn keys(&mut self, keys: &[&str]) {
        for key in keys {
            let before = self.frames();
            self.xdotool(&["key", key]);
            if *key == "space" {
                std::thread::sleep(STILL);
                continue;
            }
            self.wait_for_frame(before, key);
            self.rest();
        }
    }

    fn wait_for_frame(&self, before: u64, what: &str) {
        let start = Instant::now();
        while self.frames() == before {
            assert!(start.elapsed() < LONG, "no frame after {what}: {}", self.log());
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Moves or presses the mouse.
    pub(crate) fn mouse(&mut self, arguments: &[&str]) {
        self.xdotool(arguments);
        self.rest();
    }

    /// Moves or presses the mouse, and waits for the new frame that this causes.
    pub(crate) fn mouse_draws(&mut self, arguments: &[&str]) {
        let before = self.frames();
        self.xdotool(arguments);
        self.wait_for_frame(before, "the mouse");
        self.rest();
    }

    /// Performs many actions without waiting between them; `script` has lines as `xdotool` reads them from a
    /// file.
    pub(crate) fn rush(&mut self, script: &str) {
        let path = self.folder.path().join("script");
        std::fs::write(&path, script).unwrap();
        self.xdotool(&[path.to_str().unwrap()]);
    }

    /// Drops a file on the window.
    pub(crate) fn drop_file(&mut self, path: &Path) {
        let before = self.frames();
        let window = self.window.parse().expect("a window's number");
        crate::drop::drop_file(&self.display, window, path, [500, 300]);
        self.wait_for_frame(before, "a dropped file");
        self.rest();
    }

    /// Removes the window from the screen, as minimising does, and restores it.
    pub(crate) fn hide_and_show(&mut self) {
        let window = self.window.clone();
        self.xdotool(&["windowunmap", "--sync", &window]);
        std::thread::sleep(STILL);
        self.xdotool(&["windowmap", "--sync", &window, "windowfocus", &window]);
        self.rest();
    }

    /// Gives the window another size.
    pub(crate) fn resize(&mut self, width: &str, height: &str) {
        let before = self.frames();
        let window = self.window.clone();
        self.xdotool(&["windowsize", &window, width, height]);
        self.wait_for_frame(before, "another size");
        self.rest();
    }

    pub(crate) fn title(&self) -> String {
        self.xdotool(&["getwindowname", &self.window]).trim().to_owned()
    }

    /// Waits until the picture fulfils a condition.
    pub(crate) fn wait_for(&self, what: &str, condition: impl Fn(&Image) -> bool) {
        let start = Instant::now();
        while !condition(&self.picture()) {
            assert!(start.elapsed() < LONG, "{what} never comes: {}", self.log());
            std::thread::sleep(Duration::from_millis(20));
        }
        self.rest();
    }

    /// The number of frames that the program has drawn.
    pub(crate) fn frames(&self) -> u64 {
        self.frames.load(Ordering::SeqCst)
    }

    /// The CPU time of the program's threads.
    pub(crate) fn cpu(&self) -> Duration {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.program.id())).unwrap();
        // The name may contain spaces; the times are the 14th and 15th fields.
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
        let ticks: u64 = fields[11].parse::<u64>().unwrap() + fields[12].parse::<u64>().unwrap();
        Duration::from_millis(10 * ticks)
    }

    /// The picture on the screen.
    pub(crate) fn picture(&self) -> Image {
        let path: PathBuf = self.folder.path().join("Xvfb_screen0");
        let mut bytes = Vec::new();
        std::fs::File::open(path).unwrap().read_to_end(&mut bytes).unwrap();
        // An X window dump: big-endian words, some of which give the offset of the pixels.
        let word = |i: usize| u32::from_be_bytes(bytes[4 * i..4 * i + 4].try_into().unwrap());
        let (width, height, row) = (word(4), word(5), word(12) as usize);
        assert_eq!((width, height, word(11)), (self.size.0, self.size.1, 32));
        let first = word(0) as usize + 12 * word(19) as usize;
        Image::from_fn(width, height, |x, y| {
            let at = first + y as usize * row + 4 * x as usize;
            image::Rgba([bytes[at + 2], bytes[at + 1], bytes[at], 255])
        })
    }

    /// Ends the program with a key; it must exit successfully.
    pub(crate) fn quit(mut self, key: &str) {
        self.xdotool(&["key", key]);
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.program.try_wait().unwrap() {
                break status;
            }
            assert!(start.elapsed() < LONG, "it does not end: {}", self.log());
            std::thread::sleep(Duration::from_millis(10));
        };
        assert!(status.success(), "{status}: {}", self.log());
        assert_eq!(self.log(), "", "errors and warnings");
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        // Either process may have ended already.
        let _ = self.program.kill();
        let _ = self.program.wait();
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
