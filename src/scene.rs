//! A scene as plain data: what the parsers make and both renderers take.

mod bpt;
mod document;
mod model;
mod obj;
mod tables;
mod texture;
mod write;

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4, dvec2, dvec3};

use crate::bezier::check_control_point;
use crate::camera::Projection;
use crate::{
    Camera, Circle, CreaseAngle, Degree, Error, Mesh, Newton, Patch, Result, Smoothing, Trims,
};

pub use model::MeshModel;
pub use texture::load_texture;
pub use write::SceneText;

/// A picture that is laid over the domain of a surface; its first row is v = 1.
pub type Image = image::RgbaImage;

/// Scene files beyond this size are refused, so that a wrong file cannot eat the memory.
const MAX_FILE_BYTES: u64 = 64 << 20;

/// Surfaces, how they are drawn, and the camera that sees them.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Every file that it was read from: its own, those of patches and of pictures.
    pub files: Vec<PathBuf>,
    /// The camera; without one the scene is framed from the front.
    pub camera: Option<Camera>,
    /// The axis that stands upright when the scene is framed.
    pub up: DVec3,
    /// How it is drawn.
    pub settings: RenderSettings,
    /// What is drawn, in this order.
    pub surfaces: Vec<Surface>,
    /// What is drawn after the surfaces.
    pub meshes: Vec<MeshModel>,
}

/// How a scene is drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RenderSettings {
    /// Red, green, blue and alpha where nothing is drawn, each 0 … 1.
    pub background: [f32; 4],
    /// Whose trims and normals the surfaces have.
    pub method: Method,
    /// Samples a pixel.
    pub samples: Samples,
    /// How finely patches are cut.
    pub tessellation: Tessellation,
    /// Where the exact method evaluates normals.
    pub normals: Normals,
    /// Lines instead of filled triangles.
    pub wireframe: bool,
    /// The lines are the report's red, whatever the surface looks like.
    pub red_lines: bool,
    /// Control points as blue squares on top.
    pub control_points: bool,
    /// How the thesis' trimming iterates.
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
            wireframe: false,
            red_lines: false,
            control_points: false,
            newton: Newton::default(),
        }
    }
}

/// Whose trims and normals a picture has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Method {
    /// The ported one: trims by Newton's method, the listings' normals, with their limits.
    Thesis,
    /// Trims that are right at every sample, true normals.
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

/// How many parts an edge of a patch is cut into: a whole number from 1 to 64, the most that OpenGL
/// asks of every driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TessLevel(u32);

impl TessLevel {
    /// The highest level.
    pub const MAX: Self = Self(64);

    /// The lowest: patches and triangles stay as they are.
    pub const ONE: Self = Self(1);

    /// A level from a number that may be none.
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
    /// 32, twice what the thesis calls the least for a detailed surface.
    fn default() -> Self {
        Self(32)
    }
}

/// The largest distance on the screen between what is drawn and the surface, in pixels: from 0.01 to
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
    /// As finely as it takes, edge by edge. The thesis' method has no such thing; it draws
    /// [`TessLevel::default`].
    Within(Tolerance),
    /// At one level everywhere.
    Level(TessLevel),
}

impl Tessellation {
    /// The one level, of the thesis' method in any case.
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

/// Which sides of a surface need not be drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Cull {
    /// Both are drawn.
    #[default]
    None,
    /// Of a closed surface, patches that wholly show their back are left out: the side from which u
    /// and v turn clockwise. By the exact method alone.
    Back,
}

/// How many samples of a pixel are averaged: a power of two from 1 to 256.
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

/// What a surface's points look like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Shading {
    /// The thesis' Phong model with its two lights.
    #[default]
    Phong,
    /// The picture or colour alone, as in the report.
    Unlit,
    /// The view-space normal n as the colour (n + 1) / 2.
    Normals,
}

/// Colour of a surface before lighting.
#[derive(Debug, Clone, PartialEq)]
pub enum Paint {
    /// Red, green and blue, each 0 … 1.
    Color([f32; 3]),
    /// A picture over the domain, its alpha ignored; surfaces may share it.
    Texture(Arc<Image>),
}

impl Default for Paint {
    fn default() -> Self {
        Self::Color([0.8, 0.8, 0.8])
    }
}

/// One or more patches of one degree that share transform, paint and trims. Every patch has its own
/// domain [0, 1]², so every patch is painted and trimmed alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    degree: Degree,
    control_points: Arc<Vec<DVec4>>,
    /// Model space to world space.
    pub transform: DMat4,
    /// Colour before lighting.
    pub paint: Paint,
    /// Lighting.
    pub shading: Shading,
    /// What is cut out.
    pub trims: Trims,
    /// What need not be drawn.
    pub cull: Cull,
}

impl Surface {
    /// Patches of 16 or 25 control points (x, y, z, weight), patch after patch.
    ///
    /// # Errors
    /// No point, a number that is no multiple of the patch size, a point that is not finite, a
    /// weight that is not above 0; points count from 0.
    pub fn new(degree: Degree, control_points: Vec<DVec4>) -> Result<Self> {
        if control_points.is_empty() || !control_points.len().is_multiple_of(degree.points()) {
            return Err(Error::invalid(
                "number of control points",
                control_points.len(),
                format!("{} for each patch", degree.points()),
            ));
        }
        for (index, point) in control_points.iter().enumerate() {
            check_control_point(*point, index)?;
        }
        Ok(Self {
            degree,
            control_points: Arc::new(control_points),
            transform: DMat4::IDENTITY,
            paint: Paint::default(),
            shading: Shading::default(),
            trims: Trims::default(),
            cull: Cull::default(),
        })
    }

    /// The degree of all patches.
    #[must_use]
    pub const fn degree(&self) -> Degree {
        self.degree
    }

    /// The control points of all patches.
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        &self.control_points
    }

    /// Moves one control point; `index` counts through all patches.
    ///
    /// # Errors
    /// An index out of range, a point that is not finite, a weight that is not above 0. The surface
    /// stays as it was.
    pub fn set_control_point(&mut self, point: DVec4, index: usize) -> Result<()> {
        let count = self.control_points.len();
        if index >= count {
            return Err(Error::invalid(
                "index of a control point",
                index,
                format!("0 to {}", count - 1),
            ));
        }
        check_control_point(point, index)?;
        Arc::make_mut(&mut self.control_points)[index] = point;
        Ok(())
    }

    /// The patches in order.
    pub fn patches(&self) -> impl ExactSizeIterator<Item = Patch<'_>> + '_ {
        self.control_points
            .chunks_exact(self.degree.points())
            .map(|points| Patch::new(self.degree, points))
    }

    /// Points of the surface in world space, `side` × `side` of each patch.
    fn samples(&self, side: usize) -> impl Iterator<Item = DVec3> + Clone + '_ {
        let at = move |i: usize| i as f64 / (side - 1) as f64;
        self.control_points
            .chunks_exact(self.degree.points())
            .flat_map(move |points| (0..side * side).map(move |i| (points, i)))
            .map(move |(points, i)| {
                let patch = Patch::new(self.degree, points);
                let point = patch.at(at(i % side), at(i / side)).position;
                self.transform.transform_point3(point)
            })
    }

    /// Control points in world space, without their weights. The surface lies in their hull.
    pub fn world_points(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.control_points.iter().map(|point| self.transform.transform_point3(point.truncate()))
    }
}

/// The 16 control points of a new surface: the grid of listing 16, flat in y = 0, row by row from
/// the front (z = 0.5) to the back, every row from left to right.
#[must_use]
pub fn default_control_points() -> Vec<DVec4> {
    const PLACES: [f64; 4] = [-0.5, -0.17, 0.17, 0.5];
    PLACES
        .iter()
        .rev()
        .flat_map(|z| PLACES.iter().map(move |x| DVec4::new(*x, 0.0, *z, 1.0)))
        .collect()
}

impl Scene {
    /// Reads a `.toml`, `.bpt` or `.obj` file.
    ///
    /// # Errors
    /// A file that cannot be read, is of another kind, or does not describe a scene; with the line.
    pub fn load(path: &Path) -> Result<Self> {
        match extension(path).as_str() {
            "toml" => Self::from_toml(&read_text(path)?, path),
            "bpt" => Self::from_bpt(&read_text(path)?, path),
            "obj" => Self::of_mesh(Mesh::load_obj(path, CreaseAngle::default())?, path),
            // What is not there or no file at all is said first.
            other => Err(check_is_file(path).err().unwrap_or_else(|| {
                let reason = format!("a scene is a .toml, .bpt or .obj file, not \"{other}\"");
                unreadable(path, reason)
            })),
        }
    }

    /// Parses the text of a `.toml` scene; files it names are found relative to the folder of
    /// `path`, which also stands in the errors.
    ///
    /// # Errors
    /// Text that does not describe a scene, a file in it that cannot be read; with the line.
    pub fn from_toml(text: &str, path: &Path) -> Result<Self> {
        document::parse(text, path)
    }

    /// Parses the text of a `.bpt` file: a framed scene with z upright. `path` stands in the errors.
    ///
    /// # Errors
    /// Text that is no list of Bézier patches of degree 3 or 4; with the line.
    pub fn from_bpt(text: &str, path: &Path) -> Result<Self> {
        bpt::parse(text, path).map(|surfaces| Self::of_patches(surfaces, path))
    }

    /// The scene of listing 16: the default surface with its four inner points raised, a round hole
    /// and bricks.
    ///
    /// # Panics
    /// Never: what it is made of is fixed.
    #[must_use]
    pub fn listing16() -> Self {
        let mut surface = Surface::new(Degree::Cubic, default_control_points())
            .expect("the default control points make one patch");
        for index in [5, 6, 9, 10] {
            Arc::make_mut(&mut surface.control_points)[index].y = 0.5;
        }
        surface.transform = DMat4::from_translation(dvec3(0.0, 1.0, 0.0));
        surface.paint = Paint::Texture(Arc::new(texture::brick()));
        let hole = Circle::new(dvec2(0.5, 0.5), 0.2).expect("a fixed circle");
        surface.trims.circles.push(hole);
        Self {
            files: Vec::new(),
            camera: None,
            up: DVec3::Y,
            settings: RenderSettings::default(),
            surfaces: vec![surface],
            meshes: Vec::new(),
        }
    }

    /// A mesh as it is, its normals interpolated: what the file says.
    fn of_mesh(mesh: Mesh, path: &Path) -> Result<Self> {
        let model =
            MeshModel::new(mesh, Smoothing::None).map_err(|error| unreadable(path, error))?;
        Ok(Self { up: DVec3::Y, meshes: vec![model], ..Self::of_patches(Vec::new(), path) })
    }

    fn of_patches(surfaces: Vec<Surface>, path: &Path) -> Self {
        Self {
            files: vec![path.to_owned()],
            camera: None,
            up: DVec3::Z,
            settings: RenderSettings::default(),
            surfaces,
            meshes: Vec::new(),
        }
    }

    /// The matrices of a picture of so many pixels.
    #[must_use]
    pub fn projection(&self, width: u32, height: u32) -> Projection {
        let aspect = f64::from(width) / f64::from(height);
        let points = self.surfaces.iter().flat_map(Surface::world_points);
        let points = points.chain(self.meshes.iter().flat_map(MeshModel::world_hull));
        self.camera.unwrap_or_else(|| self.framed(aspect)).projection(points, aspect)
    }

    /// A camera that sees the whole scene, for pictures of `aspect` (width over height).
    #[must_use]
    pub fn framed(&self, aspect: f64) -> Camera {
        Camera::framing(self.shown_points(), self.up, aspect)
    }

    /// A camera that looks the same way and sees the whole scene.
    #[must_use]
    pub fn fitted(&self, camera: &Camera, aspect: f64) -> Camera {
        camera.fitted(self.shown_points(), aspect)
    }

    /// Points in world space that tell how large the scene is.
    fn shown_points(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        // Few patches need many samples to show their shape, many patches few.
        const SAMPLES: usize = 4_000;
        let patches: usize = self.surfaces.iter().map(|surface| surface.patches().len()).sum();
        let side = (SAMPLES / patches.max(1)).isqrt().clamp(2, 17);
        let points = self.surfaces.iter().flat_map(move |surface| surface.samples(side));
        let control_points = self.surfaces.iter().flat_map(Surface::world_points);
        let shown = if self.settings.control_points { usize::MAX } else { 0 };
        points
            .chain(self.meshes.iter().flat_map(MeshModel::samples))
            .chain(control_points.take(shown))
    }
}

/// The extension in lower case, without the dot.
fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

fn unreadable(path: &Path, reason: impl ToString) -> Error {
    Error::File { action: "read", path: path.to_owned(), reason: reason.to_string() }
}

fn check_is_file(path: &Path) -> Result<()> {
    let metadata = std::fs::metadata(path).map_err(|error| unreadable(path, error))?;
    if metadata.is_dir() {
        Err(unreadable(path, "it is a folder, expected a file"))
    } else if !metadata.is_file() {
        Err(unreadable(path, "it is a pipe or a device, expected a file"))
    } else {
        Ok(())
    }
}

/// The text of a scene file, refused by name if it is no file, too large, empty or no UTF-8.
fn read_text(path: &Path) -> Result<String> {
    let fail = |reason: String| unreadable(path, reason);
    check_is_file(path)?;
    let mut bytes = Vec::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(MAX_FILE_BYTES + 1).read_to_end(&mut bytes))
        .map_err(|error| unreadable(path, error))?;
    if bytes.len() as u64 > MAX_FILE_BYTES {
        return Err(fail(format!("it has more than {MAX_FILE_BYTES} bytes")));
    }
    let mut text = String::from_utf8(bytes).map_err(|error| {
        fail(format!("it is not text (byte {})", error.utf8_error().valid_up_to()))
    })?;
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    if text.trim().is_empty() {
        return Err(fail("it is empty".into()));
    }
    Ok(text)
}

/// The line, from 1, of a byte offset.
fn line_of(text: &str, offset: usize) -> usize {
    1 + text.as_bytes()[..offset.min(text.len())].iter().filter(|byte| **byte == b'\n').count()
}
