//! A worker: draws what its standard input asks for, one line each, and answers each with a line on standard output.

use std::io::{BufRead as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant, SystemTime};

use crate::io::output::{Output, encode, replace};
use crate::io::{Error, Result};
use freeform_surface::{Frame, FrameStats, LoadOptions, PreparedScene, Scene, Turntable};

use super::arguments::Axis;
use super::messages::{Milliseconds, Reply, Report, Status, Task};
use super::painter::{
    Painter, Times, frame_text, override_settings, settings_text, unmet_tolerance,
};
use super::record::{Digests, Record};
use super::{BatchArguments, RenderArguments};

/// Answers the tasks of standard input until it ends.
///
/// # Errors
/// An answer cannot be written: nobody waits for it.
pub(super) fn serve(arguments: &RenderArguments) -> Result<()> {
    let mut worker = match Worker::new(arguments) {
        Ok(worker) => worker,
        Err(error) => return answer(&Reply::Refused(error.to_string())),
    };
    answer(&Reply::Ready)?;
    let is_busy = Arc::new(AtomicBool::new(false));
    for task in tasks(Arc::clone(&is_busy)) {
        let reply = worker.carry_out(&task);
        // Once it is answered, the next task may begin.
        is_busy.store(false, Ordering::SeqCst);
        answer(&reply)?;
    }
    Ok(())
}

fn answer(reply: &Reply) -> Result<()> {
    let fail = |error: std::io::Error| Error::file("write", "standard output", error);
    let mut line = serde_json::to_vec(reply).map_err(|error| fail(error.into()))?;
    line.push(b'\n');
    let mut out = std::io::stdout().lock();
    out.write_all(&line).and_then(|()| out.flush()).map_err(fail)
}

/// The tasks of standard input, read on a thread of its own: if it ends within a task, the program that asked was
/// killed, and nobody waits for the picture, which may take for ever.
fn tasks(is_busy: Arc<AtomicBool>) -> Receiver<Task> {
    let (sender, tasks) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            let Ok(task) = serde_json::from_str(&line) else { break };
            is_busy.store(true, Ordering::SeqCst);
            if sender.send(task).is_err() {
                return;
            }
        }
        if is_busy.load(Ordering::SeqCst) {
            end_at_once();
        }
    });
    tasks
}

/// Ends this process and those that it has started, such as the reader of CAD files. (`exit` would wait for the driver's
/// threads.)
fn end_at_once() {
    #[cfg(unix)]
    let _ = rustix::process::kill_process_group(
        rustix::process::getpid(),
        rustix::process::Signal::KILL,
    );
    std::process::abort();
}

struct Worker<'a> {
    /// The scene of the last frame of a moving camera.
    loaded: Option<Loaded>,
    arguments: &'a RenderArguments,
    options: LoadOptions,
    settings: String,
    painter: Painter,
    /// Of the files of the last scene.
    digests: Digests,
    last_input: PathBuf,
}

impl<'a> Worker<'a> {
    fn new(arguments: &'a RenderArguments) -> Result<Self> {
        let mut painter = Painter::new(arguments.backend, arguments.resolution, arguments.verbose)?;
        painter.with_scale = !arguments.no_scale;
        Ok(Self {
            loaded: None,
            arguments,
            // Several workers cannot share one line of the terminal.
            options: LoadOptions { progress: None, ..arguments.load.options() },
            settings: settings_text(arguments),
            painter,
            digests: Digests::default(),
            last_input: PathBuf::new(),
        })
    }

    fn carry_out(&mut self, task: &Task) -> Reply {
        match task {
            Task::Survey(input) => {
                let scene = Scene::load_with(input, &self.options);
                Reply::Files(scene.map_or_else(|_| Vec::new(), |scene| scene.files))
            }
            Task::Draw { input, output, frame } => {
                if self.last_input != *input {
                    self.digests.clear();
                    self.last_input.clone_from(input);
                }
                Reply::Done(self.picture(input, output, *frame).unwrap_or_else(Report::failed))
            }
        }
    }

    fn picture(&mut self, input: &Path, output: &Path, frame: Option<u32>) -> Result<Report> {
        let mut settings = self.settings.clone();
        if let Some(frame) = frame {
            settings = format!("{settings} {}", frame_text(frame, &self.arguments.batch));
        }
        if self.arguments.batch.resume && Record::holds(input, output, &settings, &mut self.digests)
        {
            return Ok(Report::of(Status::Kept));
        }
        forget_peak_memory();
        let mut times = Times::default();
        // Frames of one scene mostly follow each other.
        let known = self.loaded.take().filter(|loaded| loaded.input == input);
        let mut loaded = match known {
            Some(loaded) => loaded,
            None => self.load(input, &mut times)?,
        };
        let target = Output::File(output.to_owned());
        target.check_keeps(&loaded.scene.files)?;
        if let Some(frame) = frame {
            loaded.move_camera(frame, &self.arguments.batch, self.painter.size())?;
        }
        let Loaded { scene, prepared, start, .. } = &mut loaded;
        let view = Frame::of(scene, self.painter.size());
        let image = self.painter.draw(prepared, &view, &mut times, || {})?;

        let clock = Instant::now();
        let bytes = encode(&image).map_err(|error| Error::file("write", output, error))?;
        let digests = &mut self.digests;
        let record = Record::new(input, &scene.files, *start, settings, &bytes, digests)?;
        // The record comes first: the other way round, a picture without a record might be somebody else's.
        if let Some(record) = record {
            record.write(output)?;
        }
        replace(output, |file| file.write_all(&bytes))
            .map_err(|error| Error::file("write", output, error))?;
        times.write = clock.elapsed();
        self.painter.print_details(&times);
        let FrameStats { triangles, largest_bound, .. } = times.stats;
        let report = Report {
            warning: unmet_tolerance(&target, scene, &times.stats),
            ms: Some(milliseconds(&times)),
            triangles: Some(triangles),
            largest_bound,
            peak_memory: peak_memory(),
            ..Report::of(Status::Made)
        };
        self.loaded = frame.map(|_| loaded);
        Ok(report)
    }

    fn load(&mut self, input: &Path, times: &mut Times) -> Result<Loaded> {
        let (start, clock) = (SystemTime::now(), Instant::now());
        let mut scene = Scene::load_with(input, &self.options)?;
        override_settings(&mut scene, input, self.arguments)?;
        times.load = clock.elapsed();
        let prepared = self.painter.upload(&scene, times)?;
        Ok(Loaded { input: input.to_owned(), scene, prepared, start, turntable: None })
    }
}

/// A scene that is ready to be drawn.
struct Loaded {
    input: PathBuf,
    scene: Scene,
    prepared: PreparedScene,
    /// When it began to be read.
    start: SystemTime,
    /// Made of the scene's own camera for the first frame.
    turntable: Option<Turntable>,
}

impl Loaded {
    /// Gives the scene the camera of a frame.
    fn move_camera(
        &mut self,
        frame: u32,
        batch: &BatchArguments,
        (width, height): (u32, u32),
    ) -> Result<()> {
        let camera = match batch.turntable {
            Some(frames) => {
                let axis = batch.axis.map_or(self.scene.up, Axis::direction);
                let aspect = f64::from(width) / f64::from(height);
                let table =
                    self.turntable.get_or_insert_with(|| self.scene.turntable(axis, aspect));
                Some(table.at((f64::from(frame) - 1.0) / f64::from(frames)))
            }
            None => {
                let place = || format!("{}, frame {frame}", self.input.display());
                self.scene.camera_at(frame.into()).map_err(|error| error.within(place()))?
            }
        };
        if camera.is_none() {
            let name = format!("--frames for {}", self.input.display());
            let expected = "--turntable, or a scene with [[camera_key]]";
            return Err(Error::invalid(name, "without a moving camera", expected));
        }
        self.scene.camera = camera;
        Ok(())
    }
}

fn milliseconds(times: &Times) -> Milliseconds {
    // Microseconds are enough.
    let ms = |time: Duration| (time.as_secs_f64() * 1e6).round() / 1e3;
    Milliseconds {
        read: ms(times.load),
        upload: ms(times.upload),
        draw: ms(times.picture),
        write: ms(times.write),
    }
}

/// Linux counts the peak from here on. Where it cannot, the peak is that of the process so far.
fn forget_peak_memory() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

/// The most memory that the process had, in bytes, where the system tells.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix(" kB")?.parse().ok()?;
    Some(kibibytes * 1024)
}
