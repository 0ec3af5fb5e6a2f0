//! Worker processes: each carries out one task after the other. One that dies or takes too long costs its task, and
//! another one takes its place.

use std::ffi::OsString;
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use super::messages::{Reply, Task};
use crate::io::{Error, Result};

/// A worker that takes longer than this to start has failed.
const START_LIMIT: Duration = Duration::from_secs(120);

/// The number of threads of Mesa's software driver, beside the program's own thread.
const THREADS: &str = "LP_NUM_THREADS";

/// How workers are started, how many, and how long each may take for a task.
#[derive(Debug)]
pub(super) struct Pool {
    program: PathBuf,
    arguments: Vec<OsString>,
    jobs: usize,
    limit: Option<Duration>,
    /// Fewer threads for the driver of each worker, if there are several workers.
    driver_threads: Option<usize>,
}

impl Pool {
    /// Workers are this program with the same arguments, and so with the same options.
    ///
    /// # Errors
    /// The program's own file is unknown.
    pub(super) fn new(jobs: usize, limit: Option<Duration>) -> Result<Self> {
        let program =
            std::env::current_exe().map_err(|error| Error::file("find", "the program", error))?;
        let mut arguments: Vec<OsString> = std::env::args_os().skip(1).collect();
        arguments.insert(1, "--worker".into());
        // Workers that have a core each lose a tenth of the time to threads that take turns on it.
        let share = cores() / jobs;
        let driver_threads = (jobs > 1).then_some(if share > 1 { share } else { 0 });
        Ok(Self { program, arguments, jobs, limit, driver_threads })
    }

    /// Carries out all tasks. `done` is called with the number of each finished task and its reply, or with the reason
    /// why there is none.
    pub(super) fn run(&self, tasks: &[Task], mut done: impl FnMut(usize, Result<Reply, String>)) {
        let next = AtomicUsize::new(0);
        let (sender, replies) = channel();
        std::thread::scope(|scope| {
            for _ in 0..self.jobs.min(tasks.len()) {
                let (sender, next) = (sender.clone(), &next);
                scope.spawn(move || {
                    let mut worker = None;
                    loop {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        let Some(task) = tasks.get(number) else { break };
                        if sender.send((number, self.ask(&mut worker, task))).is_err() {
                            break;
                        }
                    }
                });
            }
            drop(sender);
            for (number, reply) in replies {
                done(number, reply);
            }
        });
    }

    /// Asks a worker, or a new one if there is none. Afterwards there is one only if it has answered.
    fn ask(&self, worker: &mut Option<Worker>, task: &Task) -> Result<Reply, String> {
        let mut asked = match worker.take() {
            Some(worker) => worker,
            None => Worker::start(self)?,
        };
        let reply = asked.ask(task, self.limit)?;
        *worker = Some(asked);
        Ok(reply)
    }
}

/// The number of cores of the processor that the program may use.
pub(super) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// A process that ends with this value, and with it the processes that it has started: it leads a group of its own.
struct Worker {
    process: Child,
    is_waited_for: bool,
    input: ChildStdin,
    replies: Receiver<Reply>,
}

impl Drop for Worker {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

impl Worker {
    /// Ends the process, unless it has ended, and those that it has started. None of them holds anything that has to be
    /// put away.
    fn end(&mut self) -> std::io::Result<ExitStatus> {
        if !self.is_waited_for {
            #[cfg(unix)]
            let _ = rustix::process::kill_process_group(
                rustix::process::Pid::from_child(&self.process),
                rustix::process::Signal::KILL,
            );
            let _ = self.process.kill();
            // From now on, its number may be another process's.
            self.is_waited_for = true;
        }
        self.process.wait()
    }

    fn start(pool: &Pool) -> Result<Self, String> {
        let mut command = Command::new(&pool.program);
        if let Some(threads) = pool.driver_threads.filter(|_| std::env::var_os(THREADS).is_none()) {
            command.env(THREADS, threads.to_string());
        }
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut process = command
            .args(&pool.arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| {
                format!("the worker {} did not start: {error}", pool.program.display())
            })?;
        let input = process.stdin.take().expect("it is piped");
        let output = process.stdout.take().expect("it is piped");
        let (sender, replies) = channel();
        std::thread::spawn(move || {
            for line in BufReader::new(output).lines().map_while(Result::ok) {
                let Ok(reply) = serde_json::from_str(&line) else { break };
                if sender.send(reply).is_err() {
                    break;
                }
            }
        });
        let mut worker = Self { process, is_waited_for: false, input, replies };
        match worker.reply(Some(START_LIMIT))? {
            Reply::Refused(reason) => Err(reason),
            _ => Ok(worker),
        }
    }

    fn ask(&mut self, task: &Task, limit: Option<Duration>) -> Result<Reply, String> {
        let mut line = serde_json::to_vec(task).map_err(|error| error.to_string())?;
        line.push(b'\n');
        // If the worker has died, there is no reply either.
        let _ = self.input.write_all(&line);
        self.reply(limit)
    }

    fn reply(&mut self, limit: Option<Duration>) -> Result<Reply, String> {
        let reply = match limit {
            Some(limit) => self.replies.recv_timeout(limit),
            None => self.replies.recv().map_err(|_| RecvTimeoutError::Disconnected),
        };
        reply.map_err(|error| match (error, limit) {
            (RecvTimeoutError::Timeout, Some(limit)) => {
                format!("it was not finished within {} s", limit.as_secs_f64())
            }
            _ => {
                // A worker that talks nonsense may still run.
                self.end().map_or_else(|error| error.to_string(), ended)
            }
        })
    }
}

/// How a worker has ended.
fn ended(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return format!("the process that drew it was killed by signal {signal}");
    }
    format!("the process that drew it ended ({status})")
}
