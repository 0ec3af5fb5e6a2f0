//! Reads STEP, IGES and BREP files by a helper program, `freeform-occt`, which writes them as models.

use std::ffi::{OsStr, OsString};
use std::io::{BufRead as _, BufReader, Read};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use crate::error::{Cause, Error, Result};

/// The extensions of the files that the helper reads.
const EXTENSIONS: [&str; 7] = ["step", "stp", "p21", "iges", "igs", "brep", "brp"];

/// The environment variable that names the helper.
const VARIABLE: &str = "FREEFORM_OCCT";

/// A helper's output beyond this size is refused, so that a wrong program cannot exhaust the memory.
const MAX_MODEL_BYTES: u64 = 1 << 30;

/// Longer lines of the helper's log are cut.
const MAX_LINE_BYTES: u64 = 4096;

/// Longer time limits are as good as none.
const MAX_LIMIT: Duration = Duration::from_secs(365 * 24 * 3600);

/// The longest time between calls of the caller's function.
const BETWEEN_CALLS: Duration = Duration::from_millis(100);

/// The error if the caller's function ends the reading.
pub(crate) const ENDED: &str = "the reading was ended";

/// How long to wait before asking again whether the helper has ended.
const PAUSE: Duration = Duration::from_millis(2);

/// How STEP, IGES and BREP files are imported.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImportOptions {
    /// The helper program. `None` looks for it: the environment variable `FREEFORM_OCCT`; the folder of the running
    /// program; `cad/build` beside Cargo's target folder; the folders of `PATH`.
    pub helper: Option<PathBuf>,
    /// The longest time that reading a file may take.
    pub limit: Duration,
}

impl Default for ImportOptions {
    /// The helper is looked for and may take two minutes.
    fn default() -> Self {
        Self { helper: None, limit: Duration::from_secs(120) }
    }
}

/// Whether a file's extension is that of a STEP, IGES or BREP file.
#[must_use]
pub fn is_cad_file(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    EXTENSIONS.contains(&extension.as_str())
}

/// Reads a STEP, IGES or BREP file. Returns it as the text of a model. `progress` is called with a number from 0 to 1,
/// several times a second, and may end the reading; what the helper has to say goes to the log.
///
/// # Errors
/// A file that cannot be read; a helper that is not found, crashes, takes too long or writes no model; `progress` ends
/// the reading.
pub fn import(
    path: &Path,
    options: &ImportOptions,
    progress: impl FnMut(f64) -> ControlFlow<()>,
) -> Result<String> {
    let helper = options.helper.clone().or_else(find_helper);
    run(path, helper.as_deref(), options.limit, progress)
        .map_err(|cause| Error::file("read", path, cause))
}

/// The helper program that [`ImportOptions::helper`] describes, if it is there.
#[must_use]
pub fn find_helper() -> Option<PathBuf> {
    if let Some(helper) = std::env::var_os(VARIABLE).filter(|helper| !helper.is_empty()) {
        return Some(helper.into());
    }
    let program = std::env::current_exe().ok();
    places(program.as_deref(), std::env::var_os("PATH")).into_iter().find(|place| place.is_file())
}

/// Where the helper may be, for a running program and the folders of `PATH`.
fn places(program: Option<&Path>, search: Option<OsString>) -> Vec<PathBuf> {
    let name = format!("freeform-occt{}", std::env::consts::EXE_SUFFIX);
    let folder = program.and_then(Path::parent);
    let mut folders: Vec<PathBuf> = folder.map(Path::to_owned).into_iter().collect();
    // Cargo puts programs into folders of its target folder, which is that of the sources.
    let target = folder.into_iter().flat_map(Path::ancestors);
    let target = target.filter(|folder| folder.file_name() == Some(OsStr::new("target")));
    folders.extend(target.filter_map(Path::parent).map(|sources| sources.join("cad/build")));
    folders.extend(search.iter().flat_map(std::env::split_paths));
    folders.into_iter().map(|folder| folder.join(&name)).collect()
}

/// What the helper has written.
enum Output {
    /// All of its standard output.
    Model(std::io::Result<Vec<u8>>),
    /// A line on standard error.
    Line(String),
}

/// A process that ends with this value.
struct Helper(Child);

impl Drop for Helper {
    fn drop(&mut self) {
        // It fails if the process has ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn run(
    path: &Path,
    helper: Option<&Path>,
    limit: Duration,
    progress: impl FnMut(f64) -> ControlFlow<()>,
) -> Result<String, Cause> {
    if !std::fs::metadata(path)?.is_file() {
        return Err("it is not a file".into());
    }
    let helper = helper.ok_or(
        "the program freeform-occt, which reads STEP, IGES and BREP files, is not found; run: sh setup.sh cad",
    )?;
    let child = Command::new(helper)
        .arg(path)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("{} cannot be started: {error}", helper.display()))?;
    let mut helper = Helper(child);
    let deadline = Instant::now() + limit.min(MAX_LIMIT);
    let too_long = || format!("it is not read within the time limit of {} s", limit.as_secs_f64());

    let (sender, outputs) = channel();
    if let Some(stdout) = helper.0.stdout.take() {
        let sender = sender.clone();
        std::thread::spawn(move || send_model(stdout, &sender));
    }
    if let Some(stderr) = helper.0.stderr.take() {
        std::thread::spawn(move || send_lines(stderr, &sender));
    }
    let (model, last_line) = match collect(path, &outputs, deadline, progress) {
        Collected::All(model, last_line) => (model?, last_line),
        Collected::TooLong => return Err(too_long().into()),
        Collected::Ended => return Err(ENDED.into()),
    };
    if model.len() as u64 > MAX_MODEL_BYTES {
        return Err(format!("its model has more than {MAX_MODEL_BYTES} bytes").into());
    }
    let status = loop {
        match helper.0.try_wait()? {
            Some(status) => break status,
            None if Instant::now() >= deadline => return Err(too_long().into()),
            None => std::thread::sleep(PAUSE),
        }
    };
    if !status.success() {
        return Err(failure(status, &last_line).into());
    }
    checked(model)
}

/// What was taken from the helper.
enum Collected {
    /// The model, and the last line that is not progress.
    All(std::io::Result<Vec<u8>>, String),
    /// It was not complete in time.
    TooLong,
    /// The caller does not want it any more.
    Ended,
}

/// Takes what the helper writes, until it writes no more.
fn collect(
    path: &Path,
    outputs: &Receiver<Output>,
    deadline: Instant,
    mut progress: impl FnMut(f64) -> ControlFlow<()>,
) -> Collected {
    let mut model = Ok(Vec::new());
    let mut last_line = String::new();
    let mut share = 0.0;
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        match outputs.recv_timeout(left.min(BETWEEN_CALLS)) {
            Ok(Output::Model(bytes)) => model = bytes,
            Ok(Output::Line(line)) => {
                if let Some(percent) = line.strip_prefix("progress ") {
                    if let Ok(percent) = percent.parse::<u8>() {
                        share = f64::from(percent.min(100)) / 100.0;
                        if progress(share).is_break() {
                            return Collected::Ended;
                        }
                    }
                    continue;
                }
                if let Some(warning) = line.strip_prefix("warning: ") {
                    log::warn!("{}: {warning}", path.display());
                } else if !line.starts_with("error: ") {
                    log::info!("{}: {line}", path.display());
                }
                last_line = line;
            }
            Err(RecvTimeoutError::Timeout) if left <= BETWEEN_CALLS => return Collected::TooLong,
            Err(RecvTimeoutError::Timeout) => {
                if progress(share).is_break() {
                    return Collected::Ended;
                }
            }
            Err(RecvTimeoutError::Disconnected) => return Collected::All(model, last_line),
        }
    }
}

// A receiver that is gone has given up; sending then fails, which ends the thread.

fn send_model(stdout: impl Read, to: &Sender<Output>) {
    let mut bytes = Vec::new();
    let result = stdout.take(MAX_MODEL_BYTES + 1).read_to_end(&mut bytes);
    let _ = to.send(Output::Model(result.map(|_| bytes)));
}

fn send_lines(stderr: impl Read, to: &Sender<Output>) {
    let mut stderr = BufReader::new(stderr);
    let mut bytes = Vec::new();
    while stderr
        .by_ref()
        .take(MAX_LINE_BYTES)
        .read_until(b'\n', &mut bytes)
        .is_ok_and(|read| read > 0)
    {
        let line = String::from_utf8_lossy(&bytes).trim_end().to_owned();
        bytes.clear();
        if to.send(Output::Line(line)).is_err() {
            break;
        }
    }
}

/// What to say of a helper that failed.
fn failure(status: ExitStatus, last_line: &str) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("the program freeform-occt crashed on it (signal {signal})");
    }
    match last_line.strip_prefix("error: ") {
        Some(reason) => reason.to_owned(),
        None => {
            format!("the program freeform-occt failed ({status}) {last_line}").trim_end().to_owned()
        }
    }
}

/// The text of a model that is complete.
fn checked(model: Vec<u8>) -> Result<String, Cause> {
    let is_model = |text: &String| {
        text.starts_with("freeform-model ")
            && text.split_ascii_whitespace().next_back() == Some("end")
    };
    String::from_utf8(model)
        .ok()
        .filter(is_model)
        .ok_or_else(|| "the program freeform-occt wrote no complete model".into())
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Imports a file with the shell as the helper, so that the file says what the helper does.
    fn import_script(script: &str, limit: Duration) -> (Result<String>, Vec<f64>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.step");
        std::fs::write(&path, script).unwrap();
        let options = ImportOptions { helper: Some("/bin/sh".into()), limit };
        let mut progress = Vec::new();
        let result = import(&path, &options, |part| {
            if progress.last() != Some(&part) {
                progress.push(part);
            }
            ControlFlow::Continue(())
        });
        // Before the helper says anything, the share is 0.
        progress.retain(|part| *part > 0.0);
        (result, progress)
    }

    /// The message of the error after the file's name.
    fn error_of(script: &str) -> String {
        let (result, _) = import_script(script, Duration::from_secs(60));
        let message = result.unwrap_err().to_string();
        assert_eq!(message.lines().count(), 1, "{message}");
        message.split_once("part.step: ").unwrap().1.to_owned()
    }

    #[test]
    fn a_model_is_returned_whole() {
        let script = "echo progress 40 >&2; echo freeform-model 1; echo 'warning: a face' >&2; \
                      echo progress 100 >&2; echo end";
        let (result, progress) = import_script(script, Duration::from_secs(60));
        assert_eq!(result.unwrap(), "freeform-model 1\nend\n");
        assert_eq!(progress, [0.4, 1.0]);
    }

    #[test]
    fn the_last_error_of_the_helper_is_reported() {
        assert_eq!(
            error_of("echo freeform-model 1; echo 'error: it is empty' >&2; exit 1"),
            "it is empty"
        );
        let message = error_of("echo oops >&2; exit 3");
        assert_eq!(message, "the program freeform-occt failed (exit status: 3) oops");
    }

    #[test]
    fn a_crash_is_an_error() {
        let message = error_of("echo freeform-model 1; echo end; kill -SEGV $$");
        assert_eq!(message, "the program freeform-occt crashed on it (signal 11)");
    }

    #[test]
    fn output_that_is_no_complete_model_is_an_error() {
        for script in [
            "",
            "echo freeform-model 1",
            "echo hello; echo end",
            "printf 'freeform-model \\377 end'",
        ] {
            assert_eq!(
                error_of(script),
                "the program freeform-occt wrote no complete model",
                "{script}"
            );
        }
    }

    #[test]
    fn a_helper_that_hangs_is_ended() {
        // The second one closes its outputs before.
        for script in ["exec sleep 60", "exec >&- 2>&-; exec sleep 60"] {
            let (result, _) = import_script(script, Duration::from_millis(200));
            let message = result.unwrap_err().to_string();
            assert!(
                message.ends_with("it is not read within the time limit of 0.2 s"),
                "{message}"
            );
        }
    }

    #[test]
    fn a_reading_that_is_not_wanted_any_more_ends_its_helper() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.step");
        std::fs::write(&path, format!("echo $$ > {}/id; exec sleep 60", folder.path().display()))
            .unwrap();
        let options =
            ImportOptions { helper: Some("/bin/sh".into()), limit: Duration::from_secs(60) };
        let mut calls = 0;
        let error = import(&path, &options, |_| {
            calls += 1;
            if calls < 3 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        })
        .unwrap_err();
        assert!(error.to_string().ends_with(ENDED), "{error}");
        let id = std::fs::read_to_string(folder.path().join("id")).unwrap();
        assert!(!Path::new("/proc").join(id.trim()).exists(), "the helper is gone");
    }

    #[test]
    fn a_missing_helper_is_an_error_that_says_what_to_run() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let error =
            run(file.path(), None, Duration::ZERO, |_| ControlFlow::Continue(())).unwrap_err();
        assert!(error.to_string().ends_with("is not found; run: sh setup.sh cad"), "{error}");
        let error = run(file.path(), Some(Path::new("/no/helper")), Duration::ZERO, |_| {
            ControlFlow::Continue(())
        })
        .unwrap_err();
        assert!(error.to_string().starts_with("/no/helper cannot be started: "), "{error}");
    }

    #[test]
    fn a_missing_file_or_a_folder_is_reported_first() {
        for path in ["/no/part.step", "/"] {
            let error = run(Path::new(path), None, Duration::ZERO, |_| ControlFlow::Continue(()))
                .unwrap_err();
            assert!(!error.to_string().contains("setup.sh"), "{error}");
        }
    }

    #[test]
    fn the_helper_is_looked_for_beside_the_program_and_its_sources_and_on_the_path() {
        let program = Path::new("/home/a/target/release/deps/freeform");
        let search = std::env::join_paths(["/usr/bin", "/opt"]).unwrap();
        let expected = [
            "/home/a/target/release/deps/freeform-occt",
            "/home/a/cad/build/freeform-occt",
            "/usr/bin/freeform-occt",
            "/opt/freeform-occt",
        ];
        assert_eq!(places(Some(program), Some(search)), expected.map(PathBuf::from));
    }

    #[test]
    fn cad_files_are_known_by_their_extension() {
        assert!(is_cad_file(Path::new("a.b/Part.STEP")) && is_cad_file(Path::new("x.igs")));
        assert!(!is_cad_file(Path::new("step")) && !is_cad_file(Path::new("a.toml")));
    }
}
