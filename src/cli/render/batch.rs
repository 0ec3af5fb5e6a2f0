//! Many pictures: shares them out among workers, says what became of each, and goes on after failures.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::io::{Error, Result, say};
use freeform_surface::{Backend, Headless};

use super::RenderArguments;
use super::log::Log;
use super::messages::{Reply, Report, Status, Task};
use super::plan::Picture;
use super::pool::{Pool, cores};
use super::progress::Progress;
use super::{inputs, plan, record};

/// Renders all pictures that the arguments ask for.
///
/// # Errors
/// Wrong arguments, no driver; or some pictures failed, which were named before.
pub(super) fn run(arguments: &RenderArguments) -> Result<()> {
    let batch = &arguments.batch;
    let mut pictures = plan::pictures(inputs::gather(arguments)?, arguments)?;
    let log = batch.log.as_deref().map(Log::open).transpose()?;
    let jobs = default_jobs(arguments.backend)?;
    let pool = Pool::new(batch.jobs.map_or(jobs, Into::into), batch.timeout)?;
    protect_sources(&mut pictures, &pool);

    let mut run = Run { progress: Progress::new(pictures.len()), log, counts: [0; 3], error: None };
    let (faulty, pictures): (Vec<_>, Vec<_>) =
        pictures.into_iter().partition(|picture| picture.fault.is_some());
    for picture in &faulty {
        run.finish(picture, &Report::failed(picture.fault.as_deref().unwrap_or_default()));
    }
    let tasks: Vec<Task> = pictures.iter().map(Picture::task).collect();
    pool.run(&tasks, |number, reply| {
        let picture = &pictures[number];
        let report = match reply {
            Ok(Reply::Done(report)) => report,
            Ok(_) => Report::failed("the worker has misunderstood the task"),
            Err(reason) => {
                plan::sweep_all([picture]);
                Report::failed(format!("cannot render {}: {reason}", picture.input.display()))
            }
        };
        run.finish(picture, &report);
    });
    // Workers of a killed run may still have been writing when this one began.
    plan::sweep_all(&pictures);
    run.summarise()
}

/// The number of workers that use a machine well.
fn default_jobs(backend: Backend) -> Result<usize> {
    let is_software = Headless::new(backend)?.info().is_software();
    Ok(if is_software { cores() } else { 1 })
}

/// Refuses pictures that would overwrite a file that a scene is read from. Only files that exist and have no record can
/// be such files; mostly there are none, and then no scene is read for this.
fn protect_sources(pictures: &mut [Picture], pool: &Pool) {
    let places: Vec<Option<PathBuf>> = pictures
        .iter()
        .map(|picture| {
            let place = picture.output.canonicalize().ok();
            place.filter(|_| !record::exists(&picture.output))
        })
        .collect();
    if places.iter().all(Option::is_none) {
        return;
    }
    let refers = |path: &Path| {
        let extension = path.extension().unwrap_or_default();
        ["toml", "obj"].iter().any(|name| extension.eq_ignore_ascii_case(name))
    };
    let inputs = pictures.iter().map(|picture| &picture.input).filter(|input| refers(input));
    // A scene may have many frames.
    let inputs: HashSet<&PathBuf> = inputs.collect();
    let tasks: Vec<Task> = inputs.into_iter().cloned().map(Task::Survey).collect();
    let mut sources = HashSet::new();
    pool.run(&tasks, |_, reply| {
        if let Ok(Reply::Files(files)) = reply {
            sources.extend(files.iter().filter_map(|file| file.canonicalize().ok()));
        }
    });
    for (picture, place) in pictures.iter_mut().zip(places) {
        if place.is_some_and(|place| sources.contains(&place)) {
            let name = format!("{}, which a scene is read from", picture.output.display());
            let error = Error::invalid("output", name, "another file: see --output");
            picture.fault.get_or_insert(error.to_string());
        }
    }
}

/// What became of the pictures so far.
struct Run {
    progress: Progress,
    log: Option<Log>,
    /// Made, kept, failed.
    counts: [usize; 3],
    /// The first error of writing about pictures.
    error: Option<Error>,
}

impl Run {
    fn finish(&mut self, picture: &Picture, report: &Report) {
        let output = picture.output.display();
        self.counts[report.status as usize] += 1;
        let logged = self.log.as_mut().map_or(Ok(()), |log| log.add(picture, report));
        let said = self.progress.print(|| {
            for text in [&report.warning, &report.error].into_iter().flatten() {
                eprintln!("freeform: {text}");
            }
            match report.status {
                Status::Made => say(format_args!("wrote {output}")),
                Status::Kept => say(format_args!("kept {output}")),
                Status::Failed => Ok(()),
            }
        });
        if let Err(error) = logged.and(said) {
            self.error.get_or_insert(error);
        }
        self.progress.step();
    }

    fn summarise(self) -> Result<()> {
        let [made, kept, failed] = self.counts;
        let total: usize = self.counts.iter().sum();
        let seconds = self.progress.finish().as_secs_f64();
        say(format_args!(
            "{total} pictures in {seconds:.1} s, {:.1} a second: {made} made, {kept} kept, {failed} failed",
            total as f64 / seconds
        ))?;
        match self.error {
            Some(error) => Err(error),
            None if failed > 0 => Err(Error::Pictures { failed, total }),
            None => Ok(()),
        }
    }
}
