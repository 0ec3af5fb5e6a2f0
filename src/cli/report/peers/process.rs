//! Other programs, which are run with a time limit.

use std::collections::HashMap;
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Programs that take longer are ended.
const LIMIT: Duration = Duration::from_secs(180);
/// The time between two questions whether a program has ended.
const PAUSE: Duration = Duration::from_millis(2);

/// What a program did.
#[derive(Debug)]
pub(in crate::cli::report) struct Ended {
    /// Its lines of a name and a number.
    pub(in crate::cli::report) values: HashMap<String, f64>,
    /// From its start to its end.
    pub(in crate::cli::report) time: Duration,
    /// The most memory that it was seen to hold, in bytes. Only Linux tells.
    pub(in crate::cli::report) memory: Option<u64>,
}

impl Ended {
    /// A number that the program must have written.
    pub(in crate::cli::report) fn value(&self, name: &str) -> Result<f64, String> {
        self.values.get(name).copied().ok_or_else(|| format!("it does not write {name}"))
    }
}

/// Runs a program to its end. The error is a text for a note.
pub(in crate::cli::report) fn run(command: &mut Command) -> Result<Ended, String> {
    run_within(command, LIMIT)
}

fn run_within(command: &mut Command, limit: Duration) -> Result<Ended, String> {
    let start = Instant::now();
    let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = child.map_err(|error| error.to_string())?;
    let (stdout, stderr) = (child.stdout.take(), child.stderr.take());
    std::thread::scope(|scope| {
        let output = scope.spawn(|| text_of(stdout));
        let complaints = scope.spawn(|| text_of(stderr));
        let ended = wait(&mut child, start, limit);
        let (output, complaints) =
            (output.join().unwrap_or_default(), complaints.join().unwrap_or_default());
        let (is_well, memory) = ended?;
        let time = start.elapsed();
        if !is_well {
            let last = complaints.lines().rfind(|line| !line.trim().is_empty());
            return Err(last.unwrap_or("it fails without a word").trim().to_owned());
        }
        let value = |line: &str| {
            let (name, number) = line.split_once(' ')?;
            Some((name.to_owned(), number.parse().ok()?))
        };
        Ok(Ended { values: output.lines().filter_map(value).collect(), time, memory })
    })
}

/// The output of a program; what is no text is left out.
fn text_of(pipe: Option<impl Read>) -> String {
    let mut bytes = Vec::new();
    // What is read before an error counts.
    let _ = pipe.map(|mut pipe| pipe.read_to_end(&mut bytes));
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Waits for the end. Returns whether the program ended well, and the most memory that it was seen to hold.
fn wait(child: &mut Child, start: Instant, limit: Duration) -> Result<(bool, Option<u64>), String> {
    let mut memory = None;
    loop {
        // The file is empty of memory once the program has ended.
        memory = peak(&format!("/proc/{}/status", child.id())).or(memory);
        match child.try_wait() {
            Ok(Some(status)) => return Ok((status.success(), memory)),
            Ok(None) if start.elapsed() < limit => std::thread::sleep(PAUSE),
            Ok(None) => {
                // It fails if the program has just ended.
                let _ = child.kill();
                let _ = child.wait();
                return Err(format!("it takes longer than {} s", limit.as_secs()));
            }
            Err(error) => return Err(error.to_string()),
        }
    }
}

/// The peak memory, in bytes, that a process' `status` file in `/proc` states.
pub(in crate::cli::report) fn peak(status: &str) -> Option<u64> {
    let status = std::fs::read_to_string(status).ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024 * kilobytes)
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn numbers_time_and_memory_are_returned() {
        let ended = run(&mut shell("echo load 1.5; echo Loading 3; echo b; sleep 0.1")).unwrap();
        assert_eq!((ended.value("load"), ended.value("Loading")), (Ok(1.5), Ok(3.0)));
        assert!(ended.value("b").is_err());
        assert!(ended.time >= Duration::from_millis(100), "{:?}", ended.time);
        assert!(ended.memory.is_some_and(|bytes| bytes > 100_000), "{:?}", ended.memory);
    }

    #[test]
    fn failures_are_told_by_their_last_line() {
        assert_eq!(run(&mut shell("echo a >&2; echo why >&2; exit 3")).unwrap_err(), "why");
        assert!(run(&mut Command::new("/no/program")).is_err());
    }

    #[test]
    fn a_program_that_hangs_is_ended() {
        let start = Instant::now();
        let error = run_within(shell("exec sleep 60").arg(""), Duration::from_millis(50));
        assert!(error.is_err() && start.elapsed() < Duration::from_secs(30));
    }
}
