//! `freeform render`: draws scenes into pictures, and reports the time of each step.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::io::{Error, Result};
use freeform_surface::{
    AovKind, Backend, FloatTarget, Frame, FrameStats, Headless, Image, Offscreen, PreparedScene,
    Scene, Tessellation,
};

use indicatif::{ProgressBar, ProgressStyle};

use super::RenderArguments;
use super::exr::AovFile;
use crate::io::output::Output;
use crate::io::{say, scale};

/// Renders every scene to its output.
///
/// # Errors
/// One for each scene that failed; the others are still written.
pub(super) fn all(arguments: &RenderArguments, outputs: &[Output]) -> Result<(), Vec<Error>> {
    AovFile::check(&arguments.aov, arguments.scenes.len()).map_err(|error| vec![error])?;
    let mut job = Job::new(arguments.backend, arguments.resolution).map_err(|error| vec![error])?;
    job.verbose = arguments.verbose;
    job.with_scale = !arguments.no_scale;
    let scenes: Vec<_> =
        arguments.scenes.iter().map(|path| (path, Loaded::read(path, arguments))).collect();
    let loaded = || scenes.iter().filter_map(|(_, loaded)| loaded.as_ref().ok());
    // No picture may overwrite a file that any of the scenes was read from.
    let sources: Vec<PathBuf> =
        loaded().flat_map(|loaded| loaded.scene.files.iter().cloned()).collect();
    let drawings: u64 = loaded().map(|loaded| job.drawings(&loaded.scene)).sum();
    // Without a terminal, indicatif draws nothing.
    let bar = if drawings > 1 && !arguments.verbose {
        ProgressBar::new(drawings)
    } else {
        ProgressBar::hidden()
    };
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    let mut errors = Vec::new();
    for ((path, loaded), output) in scenes.into_iter().zip(outputs) {
        bar.set_message(path.display().to_string());
        let done = loaded.and_then(|loaded| {
            output.check_keeps(&sources)?;
            job.load = loaded.time;
            arguments.aov.iter().try_for_each(|file| file.check_keeps(&sources))?;
            job.render(&loaded.scene, output, &bar)?;
            job.write_aovs(&loaded.scene, &arguments.aov)
        });
        match done {
            Ok(()) if *output == Output::Standard => {}
            Ok(()) => errors.extend(bar.suspend(|| say(format_args!("wrote {output}"))).err()),
            Err(error) => errors.push(error),
        }
    }
    bar.finish_and_clear();
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

/// A scene, and the time that it took to read.
struct Loaded {
    scene: Scene,
    time: Duration,
}

impl Loaded {
    /// Reads a scene; options on the command line override its settings.
    fn read(path: &Path, arguments: &RenderArguments) -> Result<Self> {
        let start = Instant::now();
        let mut scene = arguments.load.load(path)?;
        arguments.style.apply(&mut scene, path)?;
        if let Some(smoothing) = arguments.smoothing {
            scene.meshes.iter_mut().for_each(|mesh| mesh.set_smoothing(smoothing));
        }
        let settings = &mut scene.settings;
        settings.samples = arguments.samples.unwrap_or(settings.samples);
        settings.wireframe = arguments.wireframe.unwrap_or(settings.wireframe);
        settings.control_points = arguments.control_points.unwrap_or(settings.control_points);
        arguments.picture.apply(settings)?;
        Ok(Self { scene, time: start.elapsed() })
    }
}

/// The times of the steps of one picture.
#[derive(Debug, Default)]
struct Times {
    load: Duration,
    upload: Duration,
    first_frame: Duration,
    frame: Duration,
    picture: Duration,
    write: Duration,
    stats: FrameStats,
}

/// Draws one scene after the other.
pub(super) struct Job {
    offscreen: Offscreen,
    start_up: Duration,
    set_up: Duration,
    load: Duration,
    verbose: bool,
    /// Whether pictures of analyses have a scale.
    with_scale: bool,
}

impl Job {
    pub(super) fn new(backend: Backend, (width, height): (u32, u32)) -> Result<Self> {
        let start = Instant::now();
        let context = Headless::new(backend)?;
        let start_up = start.elapsed();
        let start = Instant::now();
        let offscreen = Offscreen::in_context(context, width, height)?;
        let set_up = start.elapsed();
        Ok(Self {
            offscreen,
            start_up,
            set_up,
            load: Duration::ZERO,
            verbose: false,
            with_scale: true,
        })
    }

    /// The driver's renderer and version.
    pub(super) fn driver(&self) -> String {
        self.offscreen.context().info().to_string()
    }

    /// Draws a scene and writes its picture.
    pub(super) fn render(
        &mut self,
        scene: &Scene,
        output: &Output,
        bar: &ProgressBar,
    ) -> Result<()> {
        let mut times = Times { load: self.load, ..Times::default() };
        let image = self.draw(scene, &mut times, bar)?;
        let start = Instant::now();
        output.write(&image)?;
        times.write = start.elapsed();
        if let (Some(error), Tessellation::Within(tolerance)) =
            (times.stats.unmet, scene.settings.tessellation)
        {
            let wanted = tolerance.pixels();
            bar.suspend(|| {
                eprintln!("freeform: {output}: tolerance {wanted} px not met, up to {error:.2} px");
            });
        }
        if self.verbose {
            self.print(&times);
        }
        Ok(())
    }

    /// Writes the AOVs of a scene.
    fn write_aovs(&mut self, scene: &Scene, files: &[AovFile]) -> Result<()> {
        if files.is_empty() {
            return Ok(());
        }
        let (width, height) = self.offscreen.target().size();
        let frame = Frame::of(scene, (width, height));
        let renderer = self.offscreen.renderer_mut();
        let with_curvature = files.iter().any(|file| file.kind == AovKind::Curvature);
        let target = if with_curvature {
            FloatTarget::for_aovs_and_curvature(renderer, (width, height))?
        } else {
            FloatTarget::for_aovs(renderer, (width, height))?
        };
        let aovs = PreparedScene::new(renderer, scene)?.aovs(renderer, &target, &frame)?;
        self.offscreen.check_complaints(|| format!("AOVs of {width}x{height} pixels"))?;
        files.iter().try_for_each(|file| file.write(&aovs))
    }

    /// The number of passes for one picture of a scene.
    fn drawings(&self, scene: &Scene) -> u64 {
        let samples = scene.settings.samples.get();
        let max = u32::try_from(self.offscreen.context().info().max_samples).unwrap_or(0);
        if samples <= max { 1 } else { samples.into() }
    }

    fn draw(&mut self, scene: &Scene, times: &mut Times, bar: &ProgressBar) -> Result<Image> {
        let start = Instant::now();
        let frame = Frame::of(scene, self.offscreen.target().size());
        self.offscreen.set_samples(frame.settings.samples)?;
        let mut prepared = PreparedScene::new(self.offscreen.renderer(), scene)?;
        self.offscreen.context().gl().finish();
        times.upload = start.elapsed();

        if self.verbose {
            self.offscreen.target().bind();
            for time in [&mut times.first_frame, &mut times.frame] {
                let start = Instant::now();
                let _ = prepared.draw(self.offscreen.renderer_mut(), &frame)?;
                self.offscreen.context().gl().finish();
                *time = start.elapsed();
            }
        }
        let start = Instant::now();
        let mut image = self.offscreen.picture(&mut prepared, &frame, |_, _| bar.inc(1))?;
        times.picture = start.elapsed();
        if let Some(analysis) = frame.settings.shown_analysis().filter(|_| self.with_scale) {
            scale::draw(&mut image, &analysis, prepared.curvature_limit(&analysis));
        }
        times.stats = prepared.stats();
        Ok(image)
    }

    fn print(&self, times: &Times) {
        let FrameStats { patches, culled, triangles, draws, largest_bound, .. } = times.stats;
        let compilation = times.first_frame.saturating_sub(times.frame);
        let own = self.set_up + times.load + times.upload + times.picture + times.write;
        eprintln!("{}", self.driver());
        eprintln!("patches {} drawn, {culled} culled", patches - culled);
        eprintln!("triangles {triangles}, draws {draws}");
        if let Some(bound) = largest_bound {
            eprintln!("at most {bound:.3} px from the surface");
        }
        for (part, time) in [
            ("driver start-up", self.start_up),
            ("shader compilation", compilation),
            ("the program's own part", own),
            ("  set up the target", self.set_up),
            ("  read the scene", times.load),
            ("  frame and upload", times.upload),
            ("  draw and read back", times.picture),
            ("  write the picture", times.write),
            ("one frame", times.frame),
        ] {
            eprintln!("{part:24} {:8.1} ms", time.as_secs_f64() * 1e3);
        }
    }
}
