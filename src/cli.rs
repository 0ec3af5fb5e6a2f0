//! The command line: its arguments, and the functions that carry them out.

mod check;
mod convert;
mod exr;
mod info;
mod inspect;
mod measure;
mod model_info;
mod render;
mod report;
mod smooth;

use std::path::{Path, PathBuf};

use crate::io::Error;
use clap::{Args, Parser, Subcommand, ValueEnum};
use freeform_surface::inspect::NewtonTrims;
use freeform_surface::{
    Alpha, Backend, CreaseAngle, Method, Normals, Samples, Scene, Smoothing, TessLevel,
    Tessellation, Tolerance,
};

use exr::AovFile;
use render::{BatchArguments, Painter, Times};
use report::{ReportFormat, Topic};

use crate::io::input::{LoadArguments, PictureArguments, ShadingArguments, crease_angle};
use crate::io::output::Output;
use crate::io::say;
use crate::view::{self, ViewArguments};

/// Renders trimmed Bézier surfaces with OpenGL tessellation, without a display.
///
/// Without a command it renders the default scene.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render scene files to PNG pictures.
    Render(RenderArguments),
    /// Measure how far pictures of scenes are from their Bézier surfaces, pixel by pixel; meshes are
    /// left out.
    Measure(MeasureArguments),
    /// Write a CAD model (STEP, IGES, BREP) as a model of the project's own format, which needs no CAD program.
    Convert(ConvertArguments),
    /// Measure how the faces of a CAD model meet along their edges: gaps, angles and jumps of curvature.
    ///
    /// The first line has the number of edges of each class: G2 (the same curvature), G1 (the same tangent planes), G0
    /// (they touch), non-manifold (more than two faces), open (one face), gap. The second line has the limits. Then
    /// follow the edges, the worst of each class first, with the largest gap between the two faces and distance off the
    /// edge's curve, the largest angle between outward normals, the largest difference of the curvatures across the
    /// edge (1/unit, and in percent of the larger one), and where the value that decides is largest.
    Inspect(InspectArguments),
    /// Smooth a triangle mesh: every step cuts each triangle into nine.
    Smooth(SmoothArguments),
    /// Measure speed against error of both methods on this machine, and write a page about it.
    Report(ReportArguments),
    /// Show a scene in a window and edit it.
    View(ViewArguments),
    /// Print what a CAD model consists of, or the OpenGL driver and the limits that the program relies on.
    Info(InfoArguments),
}

#[derive(Debug, Args)]
struct RenderArguments {
    /// Scene files: .toml, .bpt for bare Bézier patches, or .obj for meshes and free-form surfaces; "-" reads the text
    /// of a scene of any of these kinds from standard input. Or folders: all scenes in them. Many pictures are shared
    /// out among processes.
    #[arg(required_unless_present = "list", value_name = "SCENE")]
    scenes: Vec<PathBuf>,

    #[command(flatten)]
    batch: BatchArguments,

    #[command(flatten)]
    load: LoadArguments,

    /// The picture's file; a folder if there are several pictures; "-" for standard output. Without it, each
    /// picture is named after its scene and written to the current folder.
    #[arg(short, long, value_name = "OUT.png")]
    output: Option<PathBuf>,

    /// Size of the picture in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1000x600", value_parser = resolution)]
    resolution: (u32, u32),

    #[command(flatten)]
    style: LookArguments,

    /// Smoothing of meshes: none, pn or phong, instead of the scene's.
    #[arg(long, value_name = "METHOD", value_parser = smoothing)]
    smoothing: Option<Smoothing>,

    /// Write the values at the centre of each pixel as 32-bit floats: uv (u, v and the number of the patch),
    /// position and normal (in world space), depth (along the view axis), or face (of a CAD model: the number of the
    /// face, its number among the faces in all places, the number of the model), or curvature (Gaussian, mean, and the
    /// principal one of larger magnitude). May be given several times; works
    /// with one scene only.
    #[arg(long, value_name = "KIND=FILE.exr")]
    aov: Vec<AovFile>,

    /// Samples per pixel, 1 to 256 in powers of two, instead of the scene's. If the driver supports fewer, each
    /// sample is drawn in a pass of its own.
    #[arg(long, value_name = "N", value_parser = samples, allow_negative_numbers = true)]
    samples: Option<Samples>,

    /// Draw lines instead of filled triangles; "--wireframe=false" if the scene asks for lines.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    wireframe: Option<bool>,

    #[command(flatten)]
    picture: PictureArguments,

    /// Leave out the scale that a picture of curvature or draft has in its corner.
    #[arg(long)]
    no_scale: bool,

    /// Show the control points as blue squares; "--control-points=false" hides them.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    control_points: Option<bool>,

    /// Where the OpenGL context comes from: auto, egl or osmesa.
    #[arg(long, value_name = "BACKEND", default_value_t)]
    backend: Backend,

    /// Print how long each step took, and which elements of a mesh are left out or are treated as borders.
    /// The frame is drawn twice to separate the compilation of shaders from the drawing.
    #[arg(short, long)]
    verbose: bool,
}

/// Settings of both methods; they override the scene's.
#[derive(Debug, Args)]
struct LookArguments {
    /// Method for trims and normals: exact (correct at every sample) or thesis, instead of the scene's.
    #[arg(long, value_name = "METHOD", value_parser = method)]
    method: Option<Method>,

    /// Tessellation level, 1 to 64, instead of the scene's level or tolerance.
    #[arg(long, value_name = "N", value_parser = level, allow_negative_numbers = true)]
    level: Option<TessLevel>,

    /// The largest distance from the surface on the screen, in pixels, 0.01 to 100, instead of the
    /// scene's level or tolerance.
    #[arg(long, value_name = "PX", value_parser = tolerance, allow_negative_numbers = true,
          conflicts_with = "level")]
    tolerance: Option<Tolerance>,

    /// Where normals are evaluated: vertex or pixel, instead of the scene's.
    #[arg(long, value_name = "WHERE", value_parser = normals)]
    normals: Option<Normals>,
}

#[derive(Debug, Args)]
struct MeasureArguments {
    /// Scene files: .toml, or .bpt for bare Bézier patches; "-" reads one from standard input.
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,

    #[command(flatten)]
    load: LoadArguments,

    /// Size of the picture in pixels.
    #[arg(long, value_name = "WIDTHxHEIGHT", default_value = "1000x600", value_parser = resolution)]
    resolution: (u32, u32),

    #[command(flatten)]
    style: LookArguments,

    #[command(flatten)]
    shading: ShadingArguments,

    /// Measure this many random views instead of the scene's own. They alternate between far away, inside, very
    /// near and grazing.
    #[arg(long, value_name = "N", default_value_t = 0)]
    views: u64,

    /// Measure close-ups instead: --views random points of edges that the faces of a CAD model share, each in the
    /// middle of a picture that shows 1/N of the framed height, from a random direction.
    #[arg(long, value_name = "N", value_parser = zoom)]
    zoom: Option<f64>,

    /// Seed of the random views: the same seed gives the same views.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,

    /// A line of text, or one JSON object per line.
    #[arg(long, value_name = "FORMAT", default_value = "line")]
    format: Format,

    /// Where the OpenGL context comes from: auto, egl or osmesa.
    #[arg(long, value_name = "BACKEND", default_value_t)]
    backend: Backend,
}

/// The format of the measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A line of text.
    Line,
    /// One JSON object per line.
    Json,
}

impl LookArguments {
    /// Changes the settings of a scene.
    ///
    /// # Errors
    /// The thesis' method is requested and cannot cut one of the loops.
    fn apply(&self, scene: &mut Scene, path: &Path) -> Result<(), Error> {
        let settings = &mut scene.settings;
        settings.method = self.method.unwrap_or(settings.method);
        if let Some(level) = self.level {
            settings.tessellation = Tessellation::Level(level);
        } else if let Some(tolerance) = self.tolerance {
            settings.tessellation = Tessellation::Within(tolerance);
        }
        settings.normals = self.normals.unwrap_or(settings.normals);
        if scene.settings.method == Method::Thesis {
            for surface in &scene.surfaces {
                NewtonTrims::of(&surface.trims)
                    .map_err(|error| Error::file("draw", path, error))?;
            }
        }
        Ok(())
    }
}

#[derive(Debug, Args)]
struct ReportArguments {
    /// The folder for index.html, report.json and a .csv file for each section.
    #[arg(long, value_name = "DIR", default_value = "report")]
    out: PathBuf,

    /// Measure fewer and smaller pictures; this takes about a minute.
    #[arg(long)]
    quick: bool,

    /// Measure only this section; may be given several times.
    #[arg(long, value_name = "SECTION")]
    only: Vec<Topic>,

    /// A CAD model to measure in the section of models beside the project's own; may be given several times. STEP,
    /// IGES and BREP files are also meshed by OCCT and shown by F3D, where these are installed.
    #[arg(long = "model", value_name = "FILE")]
    models: Vec<PathBuf>,

    /// Write a page and its data, or only the data to standard output.
    #[arg(long, value_name = "FORMAT", default_value = "html")]
    format: ReportFormat,

    /// The project's folder of scenes.
    #[arg(long, value_name = "DIR", default_value_os_t = report::default_resources())]
    resources: PathBuf,

    /// Where the OpenGL context comes from: auto, egl or osmesa.
    #[arg(long, value_name = "BACKEND", default_value_t)]
    backend: Backend,
}

#[derive(Debug, Args)]
struct ConvertArguments {
    /// The model: .step, .iges, .brep or .ffm.
    #[arg(value_name = "IN")]
    input: PathBuf,

    #[command(flatten)]
    load: LoadArguments,

    /// The file to write; "-" for standard output.
    #[arg(short, long, value_name = "OUT.ffm")]
    output: PathBuf,
}

#[derive(Debug, Args)]
struct InspectArguments {
    /// The model: .step, .iges, .brep or .ffm.
    #[arg(value_name = "MODEL")]
    file: PathBuf,

    #[command(flatten)]
    load: LoadArguments,

    /// A table for people, or all edges as one JSON object.
    #[arg(long, value_name = "FORMAT", default_value = "table")]
    format: InspectFormat,

    /// List all edges in the table, not only the 20 worst ones.
    #[arg(long)]
    all: bool,
}

/// The formats of `freeform inspect`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum InspectFormat {
    /// A table.
    Table,
    /// A JSON object.
    Json,
}

#[derive(Debug, Args)]
struct SmoothArguments {
    /// The mesh, a Wavefront OBJ file.
    #[arg(value_name = "IN.obj")]
    input: PathBuf,

    /// The smooth surfaces on which the new points lie: pn (curved PN triangles) or phong (Phong tessellation).
    #[arg(long, value_name = "METHOD")]
    method: SmoothMethod,

    /// How far Phong tessellation moves points towards the tangent planes, 0 to 1; 0.75 by default.
    #[arg(long, value_name = "A", value_parser = alpha, allow_negative_numbers = true)]
    alpha: Option<Alpha>,

    /// Number of smoothing steps, 1 to 8.
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true,
          value_parser = clap::value_parser!(u32).range(1..=8))]
    steps: u32,

    /// Where normals are missing: an edge stays a crease if the angle between its triangles, 0 to 180, is
    /// larger than this; 30 by default.
    #[arg(long, value_name = "D", value_parser = crease_angle, allow_negative_numbers = true)]
    crease_degrees: Option<CreaseAngle>,

    /// The file to write; "-" for standard output.
    #[arg(short, long, value_name = "OUT.obj")]
    output: PathBuf,
}

/// The methods of `freeform smooth`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SmoothMethod {
    /// Curved PN triangles.
    Pn,
    /// Phong tessellation.
    Phong,
}

#[derive(Debug, Args)]
struct InfoArguments {
    /// A CAD model: its faces, edges, size, and what was repaired or left out. Without a file: the driver.
    #[arg(value_name = "MODEL", conflicts_with_all = ["check", "backend"])]
    file: Option<PathBuf>,

    #[command(flatten)]
    load: LoadArguments,

    /// Where the OpenGL context comes from: auto, egl or osmesa.
    #[arg(long, value_name = "BACKEND", default_value_t)]
    backend: Backend,

    /// Draw patches, trims and a mesh with known results, and report in one line whether this driver draws them
    /// correctly; the exit status is 1 if not.
    #[arg(long)]
    check: bool,
}

fn resolution(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.parse().ok().filter(|pixels| *pixels > 0);
    text.split_once('x')
        .and_then(|(width, height)| Some((side(width)?, side(height)?)))
        .ok_or_else(|| "expected WIDTHxHEIGHT, two whole numbers above 0".into())
}

fn method(text: &str) -> Result<Method, String> {
    text.parse().map_err(|_| "expected exact or thesis".into())
}

fn smoothing(text: &str) -> Result<Smoothing, String> {
    match text {
        "none" => Ok(Smoothing::None),
        "pn" => Ok(Smoothing::Pn),
        "phong" => Ok(Smoothing::Phong(Alpha::default())),
        _ => Err("expected none, pn or phong".into()),
    }
}

fn samples(text: &str) -> Result<Samples, String> {
    text.parse()
        .ok()
        .and_then(|samples| Samples::new(samples).ok())
        .ok_or_else(|| "expected 1, 2, 4, 8, 16, 32, 64, 128 or 256".into())
}

fn normals(text: &str) -> Result<Normals, String> {
    text.parse().map_err(|_| "expected vertex or pixel".into())
}

fn tolerance(text: &str) -> Result<Tolerance, String> {
    text.parse()
        .ok()
        .and_then(|tolerance| Tolerance::new(tolerance).ok())
        .ok_or_else(|| "expected a number of pixels from 0.01 to 100".into())
}

fn zoom(text: &str) -> Result<f64, String> {
    let zoom = text.parse().ok().filter(|zoom| (1.0..=1e9).contains(zoom));
    zoom.ok_or_else(|| "expected a number from 1 to 1e9".into())
}

fn alpha(text: &str) -> Result<Alpha, String> {
    text.parse()
        .ok()
        .and_then(|alpha| Alpha::new(alpha).ok())
        .ok_or_else(|| "expected a number from 0 to 1".into())
}

fn level(text: &str) -> Result<TessLevel, String> {
    text.parse()
        .ok()
        .and_then(|level| TessLevel::new(level).ok())
        .ok_or_else(|| "expected a whole number from 1 to 64".into())
}

impl Arguments {
    /// Whether details are printed.
    pub(crate) fn verbose(&self) -> bool {
        matches!(&self.command, Some(Command::Render(arguments)) if arguments.verbose)
    }

    /// Reads the command line. Wrong usage prints one line to standard error and exits with status 2.
    pub(crate) fn read() -> Self {
        Self::try_parse().unwrap_or_else(|error| {
            if !error.use_stderr() {
                error.exit();
            }
            // The first paragraph states the error; the other paragraphs show the usage.
            let text = error.to_string();
            let what: Vec<&str> =
                text.lines().map(str::trim).take_while(|line| !line.is_empty()).collect();
            let what = what.join(" ");
            let what = what.strip_prefix("error: ").unwrap_or(&what);
            eprintln!("freeform: {what}; see freeform --help");
            std::process::exit(2);
        })
    }
}

/// Carries out the command of the arguments.
///
/// # Errors
/// One error for each scene that failed; the other scenes are still drawn.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Vec<Error>> {
    match &arguments.command {
        None => default_scene().map_err(|error| vec![error]),
        Some(Command::Render(arguments)) => render::run(arguments).map_err(|error| vec![error]),
        Some(Command::Measure(arguments)) => measure::all(arguments),
        Some(Command::Convert(arguments)) => convert::run(arguments).map_err(|error| vec![error]),
        Some(Command::Inspect(arguments)) => inspect::run(arguments).map_err(|error| vec![error]),
        Some(Command::Smooth(arguments)) => smooth::run(arguments).map_err(|error| vec![error]),
        Some(Command::Report(arguments)) => report::run(arguments).map_err(|error| vec![error]),
        Some(Command::View(arguments)) => view::run(arguments).map_err(|error| vec![error]),
        Some(Command::Info(InfoArguments { file, load, backend, check })) => match file {
            Some(file) => model_info::print(file, &load.options()),
            None if *check => info::print_check(*backend),
            None => info::print(*backend),
        }
        .map_err(|error| vec![error]),
    }
}

fn default_scene() -> Result<(), Error> {
    let output = Output::File("freeform.png".into());
    let mut painter = Painter::new(Backend::Auto, (1000, 600), false)?;
    painter.render(&Scene::listing16(), &output, &mut Times::default(), || {})?;
    say("wrote freeform.png: a trimmed Bézier surface, 1000 × 600 pixels, rendered on")?;
    say(painter.driver())?;
    // Under `cargo run`, the program is not on the search path.
    let freeform =
        if std::env::var_os("CARGO").is_some() { "cargo run --release --" } else { "freeform" };
    say("\nNext:")?;
    if Path::new("resources/scenes/thesis").is_dir() {
        say(format_args!(
            "  {freeform} render resources/scenes/gallery/*.toml -o out/  lettering, a gear, lace"
        ))?;
        say(format_args!(
            "  {freeform} render resources/scenes/thesis/*.toml -o out/   the figures of the thesis"
        ))?;
        say(format_args!(
            "  {freeform} render resources/surfaces/teapot.bpt            the Utah teapot"
        ))?;
    }
    say(format_args!(
        "  {freeform} render --help                                   levels, wireframe, sizes"
    ))?;
    Ok(())
}
