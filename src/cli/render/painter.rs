//! Draws scenes into pictures, and measures the time of each step.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::io::Result;
use freeform_surface::{
    AovKind, Backend, FloatTarget, Frame, FrameStats, Headless, Image, LoadOptions, Offscreen,
    PreparedScene, Scene, Tessellation,
};

use super::{BatchArguments, RenderArguments};
use crate::cli::exr::AovFile;
use crate::io::output::Output;
use crate::io::scale;

/// Options on the command line override the settings of a scene.
///
/// # Errors
/// The thesis' method is requested and cannot cut one of the loops; settings that the kind of shading does not have.
pub(super) fn override_settings(
    scene: &mut Scene,
    path: &Path,
    arguments: &RenderArguments,
) -> Result<()> {
    arguments.style.apply(scene, path)?;
    if let Some(smoothing) = arguments.smoothing {
        scene.meshes.iter_mut().for_each(|mesh| mesh.set_smoothing(smoothing));
    }
    let settings = &mut scene.settings;
    settings.samples = arguments.samples.unwrap_or(settings.samples);
    settings.wireframe = arguments.wireframe.unwrap_or(settings.wireframe);
    settings.control_points = arguments.control_points.unwrap_or(settings.control_points);
    arguments.picture.apply(settings)?;
    arguments.picture.check_shown(settings)
}

/// Everything on the command line that changes pictures, as a text.
pub(super) fn settings_text(arguments: &RenderArguments) -> String {
    let RenderArguments {
        resolution,
        style,
        smoothing,
        samples,
        wireframe,
        picture,
        no_scale,
        control_points,
        load,
        ..
    } = arguments;
    let LoadOptions { up, crease, .. } = load.options();
    format!(
        "{resolution:?} {up:?} {crease:?} {style:?} {smoothing:?} {samples:?} {wireframe:?} \
         {control_points:?} {picture:?} {no_scale:?}"
    )
}

/// What on the command line changes the picture of a frame of a moving camera, as a text.
pub(super) fn frame_text(frame: u32, batch: &BatchArguments) -> String {
    match batch.turntable {
        Some(frames) => format!("turntable {frame}/{frames} {:?}", batch.axis),
        None => format!("frame {frame}"),
    }
}

/// The times of the steps of one picture.
#[derive(Debug, Default)]
pub(in crate::cli) struct Times {
    pub(super) load: Duration,
    pub(super) upload: Duration,
    pub(super) first_frame: Duration,
    pub(super) frame: Duration,
    pub(super) picture: Duration,
    pub(super) write: Duration,
    pub(super) stats: FrameStats,
}

/// Draws one scene after the other, in one context with one set of programs.
pub(in crate::cli) struct Painter {
    offscreen: Offscreen,
    start_up: Duration,
    set_up: Duration,
    verbose: bool,
    /// Whether pictures of analyses have a scale.
    pub(super) with_scale: bool,
}

impl Painter {
    pub(in crate::cli) fn new(
        backend: Backend,
        (width, height): (u32, u32),
        verbose: bool,
    ) -> Result<Self> {
        let start = Instant::now();
        let context = Headless::new(backend)?;
        let start_up = start.elapsed();
        let start = Instant::now();
        let offscreen = Offscreen::in_context(context, width, height)?;
        let set_up = start.elapsed();
        Ok(Self { offscreen, start_up, set_up, verbose, with_scale: true })
    }

    /// The driver's renderer and version.
    pub(in crate::cli) fn driver(&self) -> String {
        self.offscreen.context().info().to_string()
    }

    /// Width and height of the pictures in pixels.
    pub(super) fn size(&self) -> (u32, u32) {
        self.offscreen.target().size()
    }

    /// Draws a scene and writes its picture. `progress` is called after each pass.
    pub(in crate::cli) fn render(
        &mut self,
        scene: &Scene,
        output: &Output,
        times: &mut Times,
        progress: impl FnMut(),
    ) -> Result<()> {
        let mut prepared = self.upload(scene, times)?;
        let image = self.draw(&mut prepared, &Frame::of(scene, self.size()), times, progress)?;
        let start = Instant::now();
        output.write(&image)?;
        times.write = start.elapsed();
        Ok(())
    }

    /// Writes the AOVs of a scene.
    pub(super) fn write_aovs(&mut self, scene: &Scene, files: &[AovFile]) -> Result<()> {
        if files.is_empty() {
            return Ok(());
        }
        let (width, height) = self.size();
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
    pub(super) fn passes(&self, scene: &Scene) -> u64 {
        let samples = scene.settings.samples.get();
        let max = u32::try_from(self.offscreen.context().info().max_samples).unwrap_or(0);
        if samples <= max { 1 } else { samples.into() }
    }

    /// Uploads a scene.
    pub(super) fn upload(&mut self, scene: &Scene, times: &mut Times) -> Result<PreparedScene> {
        let start = Instant::now();
        self.offscreen.set_samples(scene.settings.samples)?;
        let prepared = PreparedScene::new(self.offscreen.renderer(), scene)?;
        self.offscreen.context().gl().finish();
        times.upload = start.elapsed();
        Ok(prepared)
    }

    /// The picture of a frame. `progress` is called after each pass.
    pub(super) fn draw(
        &mut self,
        prepared: &mut PreparedScene,
        frame: &Frame,
        times: &mut Times,
        mut progress: impl FnMut(),
    ) -> Result<Image> {
        if self.verbose {
            self.offscreen.target().bind();
            for time in [&mut times.first_frame, &mut times.frame] {
                let start = Instant::now();
                let _ = prepared.draw(self.offscreen.renderer_mut(), frame)?;
                self.offscreen.context().gl().finish();
                *time = start.elapsed();
            }
        }
        let start = Instant::now();
        let mut image = self.offscreen.picture(prepared, frame, |_, _| progress())?;
        times.picture = start.elapsed();
        if let Some(analysis) = frame.settings.shown_analysis().filter(|_| self.with_scale) {
            scale::draw(&mut image, &analysis, prepared.curvature_limit(&analysis));
        }
        times.stats = prepared.stats();
        Ok(image)
    }

    /// Prints the times of a picture to standard error, if details are asked for.
    pub(super) fn print_details(&self, times: &Times) {
        if !self.verbose {
            return;
        }
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

/// What to say of a picture whose tolerance is not met.
pub(super) fn unmet_tolerance(
    output: &impl std::fmt::Display,
    scene: &Scene,
    stats: &FrameStats,
) -> Option<String> {
    let (Some(error), Tessellation::Within(tolerance)) = (stats.unmet, scene.settings.tessellation)
    else {
        return None;
    };
    let wanted = tolerance.pixels();
    Some(format!("{output}: tolerance {wanted} px not met, up to {error:.2} px"))
}
