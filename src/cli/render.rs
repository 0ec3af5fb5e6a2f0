//! `freeform render`: one scene is drawn by the program itself, many by workers.

mod arguments;
mod batch;
mod inputs;
mod log;
mod messages;
mod painter;
mod plan;
mod pool;
mod progress;
mod record;
mod worker;

use std::path::Path;
use std::time::Instant;

use crate::io::{Error, Result, input, say};
use indicatif::{ProgressBar, ProgressStyle};

use super::RenderArguments;
use super::exr::AovFile;
use crate::io::output::Output;

pub(super) use arguments::BatchArguments;
pub(super) use painter::{Painter, Times};

/// Renders every scene to its output.
///
/// # Errors
/// The scene failed, or several of many.
pub(super) fn run(arguments: &RenderArguments) -> Result<()> {
    if arguments.batch.worker {
        return worker::serve(arguments);
    }
    input::check(&arguments.scenes)?;
    match &arguments.scenes[..] {
        [scene] if !arguments.batch.is_used() && !scene.is_dir() => one(scene, arguments),
        _ if !arguments.aov.is_empty() => {
            Err(Error::invalid("--aov", "given for many pictures", "one scene and its picture"))
        }
        _ => batch::run(arguments),
    }
}

/// Renders a scene.
fn one(path: &Path, arguments: &RenderArguments) -> Result<()> {
    let output = Output::of_one(path, arguments.output.as_deref())?;
    AovFile::check(&arguments.aov)?;
    let mut painter = Painter::new(arguments.backend, arguments.resolution, arguments.verbose)?;
    painter.with_scale = !arguments.no_scale;
    let start = Instant::now();
    let mut scene = arguments.load.load(path)?;
    painter::override_settings(&mut scene, path, arguments)?;
    let mut times = Times { load: start.elapsed(), ..Times::default() };
    output.check_keeps(&scene.files)?;
    arguments.aov.iter().try_for_each(|file| file.check_keeps(&scene.files))?;
    let bar = bar_of(painter.passes(&scene), arguments);
    painter.render(&scene, &output, &mut times, || bar.inc(1))?;
    bar.finish_and_clear();
    if let Some(warning) = painter::unmet_tolerance(&output, &scene, &times.stats) {
        eprintln!("freeform: {warning}");
    }
    painter.print_details(&times);
    painter.write_aovs(&scene, &arguments.aov)?;
    if output == Output::Standard { Ok(()) } else { say(format_args!("wrote {output}")) }
}

/// A bar for the passes of a picture. Without a terminal, indicatif draws nothing.
fn bar_of(passes: u64, arguments: &RenderArguments) -> ProgressBar {
    if passes == 1 || arguments.verbose {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(passes);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    bar
}
