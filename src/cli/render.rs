//! `freeform render`: scenes into pictures, and where the time went.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use freeform_surface::gpu::{self, Framebuffer};
use freeform_surface::{
    Backend, Error, Frame, Headless, Image, PreparedScene, Renderer, Result, Scene,
};
use indicatif::{ProgressBar, ProgressStyle};

use super::output::Output;
use super::{RenderArguments, say};

/// Renders every scene to its output.
///
/// # Errors
/// One for each scene that failed; the others are written all the same.
pub(super) fn all(arguments: &RenderArguments, outputs: &[Output]) -> Result<(), Vec<Error>> {
    let mut job = Job::new(arguments.backend, arguments.resolution).map_err(|error| vec![error])?;
    job.verbose = arguments.verbose;
    // Without a terminal indicatif draws nothing.
    let bar = if outputs.len() > 1 && !arguments.verbose {
        ProgressBar::new(outputs.len() as u64)
    } else {
        ProgressBar::hidden()
    };
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {msg}") {
        bar.set_style(style);
    }
    let mut errors = Vec::new();
    let scenes: Vec<_> =
        arguments.scenes.iter().map(|path| (path, Loaded::read(path, arguments))).collect();
    // No picture may take the place of what any of the scenes was read from.
    let sources: Vec<PathBuf> = scenes
        .iter()
        .filter_map(|(_, loaded)| loaded.as_ref().ok())
        .flat_map(|loaded| loaded.scene.files.iter().cloned())
        .collect();
    for ((path, loaded), output) in scenes.into_iter().zip(outputs) {
        bar.set_message(path.display().to_string());
        let done = loaded.and_then(|loaded| {
            output.check_keeps(&sources)?;
            job.load = loaded.time;
            job.render(&loaded.scene, output)
        });
        match done {
            Ok(()) if *output == Output::Standard => {}
            Ok(()) => errors.extend(bar.suspend(|| say(format_args!("wrote {output}"))).err()),
            Err(error) => errors.push(error),
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

/// A scene, and how long it took to read.
struct Loaded {
    scene: Scene,
    time: Duration,
}

impl Loaded {
    /// Reads a scene; what the command line says wins.
    fn read(path: &Path, arguments: &RenderArguments) -> Result<Self> {
        let start = Instant::now();
        let mut scene = Scene::load(path)?;
        let settings = &mut scene.settings;
        settings.level = arguments.level.unwrap_or(settings.level);
        settings.wireframe = arguments.wireframe.unwrap_or(settings.wireframe);
        settings.control_points = arguments.control_points.unwrap_or(settings.control_points);
        Ok(Self { scene, time: start.elapsed() })
    }
}

/// How long the parts of one picture took.
#[derive(Debug, Default)]
struct Times {
    load: Duration,
    upload: Duration,
    first_draw: Duration,
    draw: Duration,
    read: Duration,
    write: Duration,
}

/// A context and a target that one scene after the other is drawn into.
pub(super) struct Job {
    // The order matters: OpenGL objects go before the context.
    target: Framebuffer,
    renderer: Renderer,
    context: Headless,
    start_up: Duration,
    set_up: Duration,
    load: Duration,
    verbose: bool,
}

impl Job {
    pub(super) fn new(backend: Backend, (width, height): (u32, u32)) -> Result<Self> {
        let start = Instant::now();
        let context = Headless::new(backend)?;
        let start_up = start.elapsed();
        let start = Instant::now();
        let target = Framebuffer::new(context.gl(), width, height)?;
        let renderer = Renderer::new(context.gl())?;
        Ok(Self {
            target,
            renderer,
            context,
            start_up,
            set_up: start.elapsed(),
            load: Duration::ZERO,
            verbose: false,
        })
    }

    /// Renderer and version of the driver.
    pub(super) fn driver(&self) -> String {
        let info = self.context.info();
        format!("{}, OpenGL {}", info.renderer, info.version)
    }

    /// Draws a scene and writes its picture.
    pub(super) fn render(&mut self, scene: &Scene, output: &Output) -> Result<()> {
        let mut times = Times { load: self.load, ..Times::default() };
        let image = self.draw(scene, &mut times)?;
        let start = Instant::now();
        output.write(&image)?;
        times.write = start.elapsed();
        if self.verbose {
            self.print(scene, &times);
        }
        Ok(())
    }

    fn draw(&mut self, scene: &Scene, times: &mut Times) -> Result<Image> {
        let start = Instant::now();
        let (width, height) = self.target.size();
        let frame = Frame { projection: scene.projection(width, height), settings: scene.settings };
        let gl = self.context.gl();
        // What an earlier picture left behind is not this one's fault.
        let _ = self.context.debug_log().take_errors();
        let mut prepared = PreparedScene::new(&self.renderer, scene)?;
        gpu::finish(gl);
        times.upload = start.elapsed();

        self.target.bind();
        let start = Instant::now();
        prepared.draw(&mut self.renderer, &frame)?;
        gpu::finish(gl);
        times.first_draw = start.elapsed();
        if self.verbose {
            let start = Instant::now();
            prepared.draw(&mut self.renderer, &frame)?;
            gpu::finish(gl);
            times.draw = start.elapsed();
        }

        let start = Instant::now();
        let image = self.target.read();
        times.read = start.elapsed();
        let complaints = self.context.debug_log().take_errors();
        if !complaints.is_empty() {
            return Err(Error::Driver {
                what: format!("a picture of {width}x{height} pixels"),
                reason: complaints.join("; "),
            });
        }
        Ok(image)
    }

    fn print(&self, scene: &Scene, times: &Times) {
        let patches: usize = scene.surfaces.iter().map(|surface| surface.patches().len()).sum();
        let level = u64::from(scene.settings.level.get());
        let compilation = times.first_draw.saturating_sub(times.draw);
        let own = self.set_up + times.load + times.upload + times.draw + times.read + times.write;
        eprintln!("{}", self.driver());
        eprintln!("patches {patches}, triangles {}", 2 * level * level * patches as u64);
        for (part, time) in [
            ("driver start-up", self.start_up),
            ("shader compilation", compilation),
            ("the program's own part", own),
            ("  set up the target", self.set_up),
            ("  read the scene", times.load),
            ("  frame and upload", times.upload),
            ("  draw", times.draw),
            ("  read the pixels back", times.read),
            ("  write the picture", times.write),
        ] {
            eprintln!("{part:24} {:8.1} ms", time.as_secs_f64() * 1e3);
        }
    }
}
