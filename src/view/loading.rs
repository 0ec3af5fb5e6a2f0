//! Reads scenes on a thread of its own, so that the window stays alive.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

use freeform_surface::Scene;

use crate::io::input::LoadArguments;
use crate::io::{Error, Result};

/// How long a scene is read before its progress is shown.
const QUICK: Duration = Duration::from_millis(200);
/// The stack of the reading thread, as large as that of a program's first thread.
const STACK_BYTES: usize = 8 << 20;

/// What the reading thread and the window tell each other.
#[derive(Debug, Default)]
struct Shared {
    /// How much of a CAD model is read, in percent.
    percent: AtomicU8,
    abandoned: AtomicBool,
}

thread_local! {
    /// That of the file that this thread reads.
    static OWN: RefCell<Arc<Shared>> = RefCell::default();
}

/// Notes how far this thread has read, and ends the reading if it was abandoned.
fn note(share: f64) -> ControlFlow<()> {
    OWN.with_borrow(|own| {
        own.percent.store((100.0 * share) as u8, Ordering::Relaxed);
        match own.abandoned.load(Ordering::Relaxed) {
            false => ControlFlow::Continue(()),
            true => ControlFlow::Break(()),
        }
    })
}

/// A scene that is being read. It is abandoned when this value is dropped.
#[derive(Debug)]
pub(crate) struct Loading {
    path: PathBuf,
    start: Instant,
    shared: Arc<Shared>,
    result: Receiver<Result<Scene>>,
}

impl Loading {
    /// Begins to read a scene.
    ///
    /// # Errors
    /// The system has no thread.
    pub(crate) fn start(load: LoadArguments, path: &Path) -> Result<Self> {
        let shared = Arc::new(Shared::default());
        let (sender, result) = channel();
        let work = {
            let (shared, path) = (Arc::clone(&shared), path.to_owned());
            move || {
                OWN.set(shared);
                // An abandoned scene has no receiver.
                let _ = sender.send(load.load_noting(&path, note));
            }
        };
        std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn(work)
            .map_err(|error| Error::file("read", path, error))?;
        log::debug!("reading {}", path.display());
        Ok(Self { path: path.to_owned(), start: Instant::now(), shared, result })
    }

    /// The file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The scene, or why it cannot be read; `None` if it is not complete within `limit`.
    pub(crate) fn wait(&self, limit: Duration) -> Option<Result<Scene>> {
        match self.result.recv_timeout(limit) {
            Ok(result) => Some(result),
            Err(RecvTimeoutError::Timeout) => None,
            Err(RecvTimeoutError::Disconnected) => {
                Some(Err(Error::file("read", &self.path, "its reader has failed")))
            }
        }
    }

    /// How far the reading is, for the user; `None` if it has just begun.
    pub(crate) fn progress(&self) -> Option<String> {
        if self.start.elapsed() < QUICK {
            return None;
        }
        let name = self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy();
        Some(match self.shared.percent.load(Ordering::Relaxed) {
            0 => format!("reading {name} …"),
            percent @ 1..=99 => format!("reading {name}: {percent} %"),
            _ => format!("reading {name}: projecting edges"),
        })
    }
}

impl Drop for Loading {
    fn drop(&mut self) {
        self.shared.abandoned.store(true, Ordering::Relaxed);
        log::debug!("ended reading {}", self.path.display());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Arguments {
        #[command(flatten)]
        load: LoadArguments,
    }

    fn start(path: &Path) -> Loading {
        Loading::start(Arguments::parse_from(["freeform"]).load, path).unwrap()
    }

    fn resource(name: &str) -> PathBuf {
        Path::new(env!("CARGO_MANIFEST_DIR")).join("resources").join(name)
    }

    #[test]
    fn scenes_and_errors_come_from_the_thread() {
        let limit = Duration::from_secs(60);
        let loading = start(&resource("models/flange.ffm"));
        let scene = loading.wait(limit).unwrap().unwrap();
        assert_eq!((scene.models.len(), loading.path()), (1, &*resource("models/flange.ffm")));
        assert_eq!(loading.shared.percent.load(Ordering::Relaxed), 100);
        let error = start(&resource("models/none.ffm")).wait(limit).unwrap().unwrap_err();
        assert!(error.to_string().contains("none.ffm"), "{error}");
    }

    #[test]
    fn an_abandoned_reading_ends_soon() {
        let shared = Arc::new(Shared::default());
        OWN.set(Arc::clone(&shared));
        assert_eq!(note(0.43), ControlFlow::Continue(()));
        let loading = Loading {
            path: "a/part.step".into(),
            start: Instant::now().checked_sub(QUICK).unwrap(),
            shared: Arc::clone(&shared),
            result: channel().1,
        };
        assert_eq!(loading.progress().unwrap(), "reading part.step: 43 %");
        assert_eq!(note(1.0), ControlFlow::Continue(()));
        assert_eq!(loading.progress().unwrap(), "reading part.step: projecting edges");
        drop(loading);
        assert_eq!(note(1.0), ControlFlow::Break(()));
    }
}
