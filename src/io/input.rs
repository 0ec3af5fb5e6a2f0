//! The sources of scenes: files, or standard input.

use std::io::{IsTerminal as _, Read as _};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::{Error, Result};
use clap::Args;
use freeform_surface::{
    Analysis, AnalysisChange, AnalysisKind, Cause, CreaseAngle, CurvatureKind, CurvatureLimit,
    Direction, DraftLimit, EdgeColor, Edges, IsolineCount, Isolines, Light, LoadOptions, Method,
    RenderSettings, Scene, StripeCount, UpAxis,
};

/// The name of standard input on the command line.
const STANDARD: &str = "-";
/// Standard input with more bytes than this is refused, as a file is.
const MAX_BYTES: u64 = 64 << 20;

/// Options for reading scenes; they override the scenes' own values.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct LoadArguments {
    /// Up axis for scenes without a camera: y or z. Otherwise it is the scene's, or z if the scene consists
    /// only of patches of .bpt files, or y.
    #[arg(long, value_name = "AXIS", value_parser = up_axis)]
    up: Option<UpAxis>,

    /// Where a mesh's file has no normals: an edge stays a crease if the angle between its triangles, 0 to 180,
    /// is larger than this. It replaces the scene's angle, which is 30 by default.
    #[arg(long, value_name = "D", value_parser = crease_angle, allow_negative_numbers = true)]
    crease_degrees: Option<CreaseAngle>,

    /// How long the reader of STEP, IGES and BREP files may take, in seconds.
    #[arg(long, value_name = "S", default_value_t = 120)]
    import_timeout: u64,
}

/// Lines on surfaces and their light; these override the scenes' own settings.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct PictureArguments {
    /// Draw the edges of CAD models as lines, as the scene says or else nearly black; "--edges=false" if the scene asks
    /// for them.
    #[arg(long, num_args = 0..=1, require_equals = true, default_missing_value = "true")]
    edges: Option<bool>,

    /// Draw the edges of CAD models, smooth ones too, each in the colour of its class: continuity (gap, open,
    /// non-manifold, G0, G1 or G2, as "freeform inspect" finds it).
    #[arg(long, value_name = "WHAT", value_parser = edge_color)]
    color: Option<EdgeColor>,

    /// Draw so many lines of equal u, and as many of equal v, on each surface, face of a CAD model or Bézier patch, 1
    /// to 1000, as the scene says or else narrow and dark; 0 if the scene asks for them.
    #[arg(long, value_name = "N", value_parser = isolines, allow_negative_numbers = true)]
    isolines: Option<Count>,

    /// The light, instead of the scene's: studio (lamps that move with the camera; nothing is black or clipped) or
    /// thesis (the thesis' two lamps, above and below the origin).
    #[arg(long, value_name = "LIGHT", value_parser = light)]
    light: Option<Light>,

    #[command(flatten)]
    shading: ShadingArguments,
}

/// What is shown in place of light and colour; this overrides the scenes' own settings.
#[derive(Debug, Clone, Copy, Args)]
pub(crate) struct ShadingArguments {
    /// Show the shape of surfaces in place of their light and colour, from the true surface at each pixel: zebra (a striped
    /// environment, mirrored), isophotes (stripes of equal angle to a direction), curvature or draft (the angle to a
    /// direction of pull); none if the scene asks for one.
    #[arg(long, value_name = "KIND", value_parser = shading)]
    shading: Option<Shown>,

    /// The number of stripes of zebra or isophotes, 1 to 1000.
    #[arg(long, value_name = "N", value_parser = stripes, requires = "shading", allow_negative_numbers = true)]
    stripes: Option<StripeCount>,

    /// The axis of zebra's environment or the direction of isophotes, otherwise what is upright in the picture; the
    /// direction of the pull of draft, otherwise z.
    #[arg(long, value_name = "X,Y,Z", value_parser = direction, requires = "shading", allow_hyphen_values = true)]
    direction: Option<Direction>,

    /// Which curvature is shown: gaussian, mean or largest (the principal one of larger magnitude).
    #[arg(long, value_name = "WHICH", value_parser = curvature, requires = "shading")]
    curvature: Option<CurvatureKind>,

    /// The curvature at the end of the scale, in 1/unit, or for the Gaussian one 1/unit²; otherwise it suits the scene.
    #[arg(long, value_name = "LIMIT", value_parser = limit, requires = "shading", allow_negative_numbers = true)]
    limit: Option<CurvatureLimit>,

    /// The draft angle at the end of the scale in degrees, otherwise 10.
    #[arg(long, value_name = "D", value_parser = limit_degrees, requires = "shading", allow_negative_numbers = true)]
    limit_degrees: Option<DraftLimit>,
}

/// The kind of an analysis; `None`: none.
type Shown = Option<AnalysisKind>;

/// The number of isolines; `None`: none.
type Count = Option<IsolineCount>;

impl ShadingArguments {
    /// Changes the settings of a scene.
    ///
    /// # Errors
    /// Settings that the kind of shading does not have, or of none.
    pub(crate) fn apply(self, settings: &mut RenderSettings) -> Result<()> {
        if let Some(shown) = self.shading {
            let is_own = |own: &Analysis| Some(own.kind()) == shown;
            let own = settings.analysis.filter(is_own);
            settings.analysis = own.or(shown.map(AnalysisKind::with_defaults));
        }
        let Self { stripes, direction, curvature, limit, limit_degrees, .. } = self;
        let change = AnalysisChange { stripes, direction, curvature, limit, limit_degrees };
        match &mut settings.analysis {
            Some(analysis) => *analysis = analysis.changed(&change)?,
            None if change == AnalysisChange::default() => {}
            None => {
                let found = "none, with settings of a shading";
                return Err(Error::invalid("--shading", found, "a kind that has them"));
            }
        }
        Ok(())
    }

    /// Refuses a shading that was asked for if the settings do not show it.
    ///
    /// # Errors
    /// The thesis' method, which has none.
    pub(crate) fn check_shown(self, settings: &RenderSettings) -> Result<()> {
        let is_asked = self.shading.is_some_and(|shading| shading.is_some());
        if is_asked && settings.method == Method::Thesis {
            let found = "given with the thesis' method";
            return Err(Error::invalid("--shading", found, "the exact method: --method exact"));
        }
        Ok(())
    }
}

impl PictureArguments {
    /// Refuses a shading that was asked for if the settings do not show it.
    ///
    /// # Errors
    /// As [`ShadingArguments::check_shown`].
    pub(crate) fn check_shown(self, settings: &RenderSettings) -> Result<()> {
        self.shading.check_shown(settings)
    }

    /// Changes the settings of a scene.
    ///
    /// # Errors
    /// As [`ShadingArguments::apply`].
    pub(crate) fn apply(self, settings: &mut RenderSettings) -> Result<()> {
        if let Some(shown) = self.edges {
            settings.edges = shown.then(|| settings.edges.unwrap_or_default());
        }
        if let Some(color) = self.color {
            settings.edges = Some(Edges { color, ..settings.edges.unwrap_or_default() });
        }
        if let Some(count) = self.isolines {
            let own = settings.isolines.unwrap_or_default();
            settings.isolines = count.map(|count| Isolines { count, ..own });
        }
        settings.light = self.light.unwrap_or(settings.light);
        self.shading.apply(settings)
    }
}

fn shading(text: &str) -> Result<Shown, String> {
    match text {
        "none" => Ok(None),
        _ => text
            .parse()
            .map(Some)
            .map_err(|_| "expected zebra, isophotes, curvature, draft or none".into()),
    }
}

fn stripes(text: &str) -> Result<StripeCount, String> {
    (text.parse().ok().and_then(|count| StripeCount::new(count).ok()))
        .ok_or_else(|| "expected a whole number from 1 to 1000".into())
}

fn direction(text: &str) -> Result<Direction, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let numbers: Option<[f64; 3]> = numbers.ok().and_then(|numbers| numbers.try_into().ok());
    (numbers.and_then(|numbers| Direction::new(numbers.into()).ok()))
        .ok_or_else(|| "expected X,Y,Z, three numbers that are not all 0".into())
}

fn curvature(text: &str) -> Result<CurvatureKind, String> {
    text.parse().map_err(|_| "expected gaussian, mean or largest".into())
}

fn limit(text: &str) -> Result<CurvatureLimit, String> {
    (text.parse().ok().and_then(|limit| CurvatureLimit::new(limit).ok()))
        .ok_or_else(|| "expected a number from 1e-30 to 1e30".into())
}

fn limit_degrees(text: &str) -> Result<DraftLimit, String> {
    (text.parse().ok().and_then(|degrees| DraftLimit::new(degrees).ok()))
        .ok_or_else(|| "expected a number of degrees from 0.001 to 90".into())
}

fn edge_color(text: &str) -> Result<EdgeColor, String> {
    text.parse().map_err(|_| "expected continuity".into())
}

fn light(text: &str) -> Result<Light, String> {
    text.parse().map_err(|_| "expected studio or thesis".into())
}

fn isolines(text: &str) -> Result<Count, String> {
    text.parse()
        .ok()
        .and_then(|count| IsolineCount::or_none(count).ok())
        .ok_or_else(|| "expected a whole number from 0 to 1000".into())
}

fn up_axis(text: &str) -> Result<UpAxis, String> {
    text.parse().map_err(|_| "expected y or z".into())
}

pub(crate) fn crease_angle(text: &str) -> Result<CreaseAngle, String> {
    text.parse()
        .ok()
        .and_then(|degrees| CreaseAngle::new(degrees).ok())
        .ok_or_else(|| "expected a number of degrees from 0 to 180".into())
}

impl LoadArguments {
    /// The same for the library.
    pub(crate) fn options(self) -> LoadOptions {
        LoadOptions {
            crease: self.crease_degrees,
            up: self.up,
            import_limit: Duration::from_secs(self.import_timeout),
            progress: std::io::stderr().is_terminal().then_some(show),
        }
    }

    /// Reads the scene of a file, or of standard input.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub(crate) fn load(self, path: &Path) -> Result<Scene> {
        Self::read(path, &self.options())
    }

    /// Reads a scene as [`LoadArguments::load`], and reports the progress as [`LoadOptions::progress`] says.
    ///
    /// # Errors
    /// As [`Scene::load`], and `note` ends the reading.
    pub(crate) fn load_noting(
        self,
        path: &Path,
        note: fn(f64) -> ControlFlow<()>,
    ) -> Result<Scene> {
        Self::read(path, &LoadOptions { progress: Some(note), ..self.options() })
    }

    fn read(path: &Path, options: &LoadOptions) -> Result<Scene> {
        if !is_standard(path) {
            return Ok(Scene::load_with(path, options)?);
        }
        let name = Path::new("standard input");
        let fail = |cause: Cause| Error::file("read", name, cause);
        let mut bytes = Vec::new();
        std::io::stdin()
            .lock()
            .take(MAX_BYTES + 1)
            .read_to_end(&mut bytes)
            .map_err(|error| fail(error.into()))?;
        if bytes.len() as u64 > MAX_BYTES {
            return Err(fail(format!("it has more than {MAX_BYTES} bytes").into()));
        }
        let text = String::from_utf8(bytes).map_err(|_| fail("it is not text".into()))?;
        if text.trim().is_empty() {
            return Err(fail("it is empty".into()));
        }
        Ok(Scene::from_text(&text, name, options)?)
    }
}

/// Shows how much of a CAD file is read, in a line of the terminal that is empty afterwards.
fn show(share: f64) -> ControlFlow<()> {
    if share < 1.0 {
        eprint!("\rreading: {:.0} %", 100.0 * share);
    } else {
        eprint!("\r\x1b[K");
    }
    ControlFlow::Continue(())
}

/// Whether a scene comes from standard input.
pub(crate) fn is_standard(path: &Path) -> bool {
    path == Path::new(STANDARD)
}

/// Refuses to read standard input for two scenes.
///
/// # Errors
/// Two scenes are `-`.
pub(crate) fn check(scenes: &[PathBuf]) -> Result<()> {
    match scenes.iter().filter(|scene| is_standard(scene)).count() {
        0 | 1 => Ok(()),
        count => {
            Err(Error::invalid("scenes", format!("\"-\" {count} times"), "standard input once"))
        }
    }
}
