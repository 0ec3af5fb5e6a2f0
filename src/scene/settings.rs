//! How a scene is drawn.

use glam::DVec3;

use super::Analysis;
use crate::error::{Error, Result};
use crate::thesis::newton::Newton;

/// Side of the square that shows a control point, in pixels.
pub(crate) const CONTROL_POINT_PX: f32 = 7.0;

/// How a scene is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSettings {
    /// Red, green, blue and alpha where nothing is drawn, each 0 … 1.
    pub background: [f32; 4],
    /// The method that decides trims and normals.
    pub method: Method,
    /// Samples per pixel.
    pub samples: Samples,
    /// How finely patches are tessellated.
    pub tessellation: Tessellation,
    /// Where the exact method evaluates normals.
    pub normals: Normals,
    /// The light on surfaces and meshes.
    pub light: Light,
    /// Lines instead of filled triangles.
    pub wireframe: bool,
    /// Lines have the report's red instead of the surface's colour.
    pub red_lines: bool,
    /// Control points as blue squares on top.
    pub control_points: bool,
    /// Lines along the edges of CAD models, by the exact method.
    pub edges: Option<Edges>,
    /// Lines of equal u and of equal v on surfaces, by the exact method. Wireframes have none.
    pub isolines: Option<Isolines>,
    /// What is shown in place of the surfaces' and meshes' own shading, by the exact method. Scenes call it `shading`.
    pub analysis: Option<Analysis>,
    /// When Newton's method stops, for the thesis' method.
    pub newton: Newton,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            background: [0.2, 0.2, 0.25, 1.0],
            method: Method::default(),
            samples: Samples::default(),
            tessellation: Tessellation::default(),
            normals: Normals::default(),
            light: Light::default(),
            wireframe: false,
            red_lines: false,
            control_points: false,
            edges: None,
            isolines: None,
            analysis: None,
            newton: Newton::default(),
        }
    }
}

impl RenderSettings {
    /// The analysis that a picture shows: only the exact method has one, and red wireframes have none.
    #[must_use]
    pub fn shown_analysis(&self) -> Option<Analysis> {
        let is_red = self.wireframe && self.red_lines;
        self.analysis.filter(|_| self.method == Method::Exact && !is_red)
    }
}

/// The method that decides trims and normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Method {
    /// The thesis' method: trims by Newton's method and the listings' normals, with their limits.
    Thesis,
    /// The exact method: trims that are right at every sample, and true normals.
    #[default]
    Exact,
}

impl std::str::FromStr for Method {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        match name {
            "thesis" => Ok(Self::Thesis),
            "exact" => Ok(Self::Exact),
            _ => Err(Error::invalid("method", format!("\"{name}\""), "\"exact\" or \"thesis\"")),
        }
    }
}

/// The number of segments of each edge of a patch: an integer from 1 to 64, the maximum that OpenGL
/// guarantees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TessLevel(u32);

impl TessLevel {
    /// The highest level.
    pub const MAX: Self = Self(64);

    /// The lowest level: patches and triangles are not subdivided.
    pub const ONE: Self = Self(1);

    /// A level from an integer.
    ///
    /// # Errors
    /// Anything outside 1 … 64.
    pub fn new(level: i64) -> Result<Self> {
        match u32::try_from(level) {
            Ok(level @ 1..=64) => Ok(Self(level)),
            _ => Err(Error::invalid("level", level, "a whole number from 1 to 64")),
        }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

impl Default for TessLevel {
    /// 32, twice the minimum that the thesis recommends for a detailed surface.
    fn default() -> Self {
        Self(32)
    }
}

/// The largest distance on the screen between the triangles and the surface, in pixels: from 0.01 to
/// 100.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Tolerance(f64);

impl Tolerance {
    /// A tolerance in pixels.
    ///
    /// # Errors
    /// Anything outside 0.01 … 100.
    pub fn new(pixels: f64) -> Result<Self> {
        if (0.01..=100.0).contains(&pixels) {
            Ok(Self(pixels))
        } else {
            Err(Error::invalid("tolerance", pixels, "a number of pixels from 0.01 to 100"))
        }
    }

    /// The number of pixels.
    #[must_use]
    pub const fn pixels(self) -> f64 {
        self.0
    }
}

impl Default for Tolerance {
    /// Half a pixel.
    fn default() -> Self {
        Self(0.5)
    }
}

/// How finely patches are cut into triangles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tessellation {
    /// Each edge as finely as the tolerance needs. The thesis' method does not support this; it draws
    /// [`TessLevel::default`].
    Within(Tolerance),
    /// At one level everywhere.
    Level(TessLevel),
}

impl Tessellation {
    /// The level, or the level that the thesis' method draws within a tolerance.
    #[must_use]
    pub fn level(self) -> TessLevel {
        match self {
            Self::Within(_) => TessLevel::default(),
            Self::Level(level) => level,
        }
    }
}

impl Default for Tessellation {
    fn default() -> Self {
        Self::Within(Tolerance::default())
    }
}

/// Where the exact method evaluates normals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Normals {
    /// At the vertices of triangles; between them they are interpolated.
    #[default]
    Vertex,
    /// At every pixel: highlights do not depend on the triangles.
    Pixel,
}

impl std::str::FromStr for Normals {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        match name {
            "vertex" => Ok(Self::Vertex),
            "pixel" => Ok(Self::Pixel),
            _ => Err(Error::invalid("normals", format!("\"{name}\""), "\"vertex\" or \"pixel\"")),
        }
    }
}

/// How the edges of CAD models are drawn: those of one face, those of two faces at an angle, but no seam, where a face
/// meets itself. With [`EdgeColor::Continuity`], all edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edges {
    /// The width of the lines.
    pub width: LineWidth,
    /// Their colours.
    pub color: EdgeColor,
    /// Whether edges of two faces with the same tangent planes are drawn too
    /// ([`SMOOTH_DEGREES`](crate::model::SMOOTH_DEGREES)).
    pub smooth: bool,
}

impl Default for Edges {
    /// Nearly black, without smooth edges.
    fn default() -> Self {
        let color = EdgeColor::Rgb([0.05, 0.05, 0.08]);
        Self { width: LineWidth::default(), color, smooth: false }
    }
}

/// The colours of edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EdgeColor {
    /// Red, green and blue of all edges, each 0 … 1.
    Rgb([f32; 3]),
    /// Each edge has the colour of its class ([`Continuity::color`](crate::model::Continuity::color)). All edges that
    /// have a class are drawn, smooth ones and seams too. The classes are found when such a picture is first drawn.
    Continuity,
}

impl std::str::FromStr for EdgeColor {
    type Err = Error;

    /// A name: "continuity".
    fn from_str(name: &str) -> Result<Self> {
        match name {
            "continuity" => Ok(Self::Continuity),
            _ => {
                let expected = "[red, green, blue] or \"continuity\"";
                Err(Error::invalid("color", format!("\"{name}\""), expected))
            }
        }
    }
}

/// How lines of equal u and of equal v are drawn. They are at equal steps of the parameters of a NURBS surface, of a
/// face of a CAD model, or of each Bézier patch, the first and the last one half a step from the ends of the domain. So
/// the steps go on across the seam of a closed surface, and from patch to patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Isolines {
    /// Lines of equal u, and as many of equal v.
    pub count: IsolineCount,
    /// The width of the lines.
    pub width: LineWidth,
    /// Red, green and blue, each 0 … 1.
    pub color: [f32; 3],
}

impl Default for Isolines {
    /// Narrower and a little lighter than edges.
    fn default() -> Self {
        Self { count: IsolineCount::default(), width: LineWidth(1.0), color: [0.15, 0.15, 0.2] }
    }
}

/// The number of isolines along each direction of a surface: from 1 to 1000.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct IsolineCount(u32);

impl IsolineCount {
    /// The largest number.
    pub const MAX: Self = Self(1000);

    /// A number of lines.
    ///
    /// # Errors
    /// Anything outside 1 … 1000.
    pub fn new(count: i64) -> Result<Self> {
        match u32::try_from(count) {
            Ok(count @ 1..=1000) => Ok(Self(count)),
            _ => Err(Error::invalid("number of isolines", count, "a whole number from 1 to 1000")),
        }
    }

    /// A number of lines, or `None` for 0.
    ///
    /// # Errors
    /// Anything outside 0 … 1000.
    pub fn or_none(count: i64) -> Result<Option<Self>> {
        match count {
            0 => Ok(None),
            _ => Self::new(count).map(Some).map_err(|_| {
                Error::invalid("number of isolines", count, "a whole number from 0 to 1000")
            }),
        }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

impl Default for IsolineCount {
    /// Eight.
    fn default() -> Self {
        Self(8)
    }
}

/// The width of a line in pixels: from 0.1 to 100.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct LineWidth(f64);

impl LineWidth {
    /// A width in pixels.
    ///
    /// # Errors
    /// Anything outside 0.1 … 100.
    pub fn new(pixels: f64) -> Result<Self> {
        if (0.1..=100.0).contains(&pixels) {
            Ok(Self(pixels))
        } else {
            Err(Error::invalid("width", pixels, "a number of pixels from 0.1 to 100"))
        }
    }

    /// The number of pixels.
    #[must_use]
    pub const fn pixels(self) -> f64 {
        self.0
    }
}

impl Default for LineWidth {
    /// One and a half pixels.
    fn default() -> Self {
        Self(1.5)
    }
}

/// The light that surfaces and meshes with [`Shading::Phong`](super::Shading::Phong) are in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Light {
    /// Three lamps that move with the camera and a hemisphere, the same for any model, size and camera. Both sides of a
    /// surface are lit alike, no face is black, and nothing is clipped. Colours and textures are sRGB, the light is
    /// added up in linear values, and the picture is sRGB.
    #[default]
    Studio,
    /// The thesis' two lamps, 10 units above and below the world's origin, at y = 10 and y = −10, and Phong's model.
    /// Colours are added up as they are, without regard to sRGB, and clipped at 1.
    Thesis,
}

impl Light {
    /// All lights.
    pub const ALL: [Self; 2] = [Self::Studio, Self::Thesis];

    /// The name in scenes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Studio => "studio",
            Self::Thesis => "thesis",
        }
    }
}

impl std::str::FromStr for Light {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let expected = "\"studio\" or \"thesis\"";
        (Self::ALL.into_iter().find(|light| light.name() == name))
            .ok_or_else(|| Error::invalid("light", format!("\"{name}\""), expected))
    }
}

/// Samples that are averaged per pixel: a power of two from 1 to 256.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Samples(u32);

impl Samples {
    /// A number of samples.
    ///
    /// # Errors
    /// Anything but 1, 2, 4, … 256.
    pub fn new(samples: i64) -> Result<Self> {
        match u32::try_from(samples) {
            Ok(samples @ 1..=256) if samples.is_power_of_two() => Ok(Self(samples)),
            _ => Err(Error::invalid("samples", samples, "1, 2, 4, 8, 16, 32, 64, 128 or 256")),
        }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

impl Default for Samples {
    /// One, at the pixel's centre.
    fn default() -> Self {
        Self(1)
    }
}

/// The axis that is vertical in the picture of a scene without a camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum UpAxis {
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

impl UpAxis {
    /// The axis as a vector.
    #[must_use]
    pub const fn direction(self) -> DVec3 {
        match self {
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}

impl std::str::FromStr for UpAxis {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        match name {
            "y" => Ok(Self::Y),
            "z" => Ok(Self::Z),
            _ => Err(Error::invalid("up", format!("\"{name}\""), "\"y\" or \"z\"")),
        }
    }
}
