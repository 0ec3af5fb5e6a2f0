//! A scene as plain data, which the parsers create and both renderers draw.

mod analysis;
mod bpt;
mod cad;
mod document;
mod file;
mod joined;
mod model;
mod obj;
mod settings;
mod surface;
mod svg;
mod tables;
mod texture;
mod write;

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use glam::{DMat4, DQuat, DVec3, dvec2, dvec3};

use crate::bezier::{Degree, bounding_box};
use crate::camera::{Camera, CameraPath, Lens, Turntable, ViewProjection};
use crate::error::Result;
use crate::mesh::{CreaseAngle, Smoothing};
use crate::model::Model;
use crate::trim::Circle;

pub use analysis::{
    Analysis, AnalysisChange, AnalysisKind, CurvatureKind, CurvatureLimit, Direction, Draft,
    DraftLimit, ScaleColors, StripeCount, Stripes,
};
pub use cad::{CadModel, FaceOfModel};
use file::{BYTE_ORDER_MARK, check_is_file, extension, read_text, unreadable};
pub(crate) use joined::joined;
pub use model::{Material, MeshModel};
pub(crate) use settings::CONTROL_POINT_PX;
pub use settings::{
    EdgeColor, Edges, IsolineCount, Isolines, Light, LineWidth, Method, Normals, RenderSettings,
    Samples, TessLevel, Tessellation, Tolerance, UpAxis,
};
pub use surface::{Cull, Paint, Shading, Surface, default_control_points};
pub(crate) use surface::{check_transform, first_alike};
pub use texture::load_texture;
pub use write::SceneText;

/// A picture that is laid over the domain of a surface; its first row is v = 1.
pub type Image = image::RgbaImage;

/// Options of the caller that override those of the scene's file.
#[derive(Debug, Clone, Copy)]
pub struct LoadOptions {
    /// The angle beyond which an edge is a crease, for computing normals that meshes lack.
    pub crease: Option<CreaseAngle>,
    /// The axis that is vertical when the scene is framed.
    pub up: Option<UpAxis>,
    /// How long the reader of STEP, IGES and BREP files may take.
    pub import_limit: Duration,
    /// Is called while a CAD model is read, with a share from 0 to 1: 1 means that the file is read, and that the edges
    /// of the faces come next. It may end the reading.
    pub progress: Option<fn(f64) -> ControlFlow<()>>,
}

impl Default for LoadOptions {
    /// Nothing is overridden; two minutes for the reader of CAD files.
    fn default() -> Self {
        Self { crease: None, up: None, import_limit: Duration::from_secs(120), progress: None }
    }
}

/// From where a scene without a camera is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Viewpoint {
    /// From the front, as [`Camera::framing`].
    #[default]
    Front,
    /// As [`Camera::isometric`]: for CAD models.
    Isometric,
}

/// Surfaces, how they are drawn, and the camera that sees them.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Every file that the scene was read from: its own file, and the files of patches, meshes, SVG trims and
    /// pictures.
    pub files: Vec<PathBuf>,
    /// The camera; without one the scene is framed.
    pub camera: Option<Camera>,
    /// How the camera moves, for pictures of several times; its lens is that of [`Scene::camera`].
    pub camera_path: Option<CameraPath>,
    /// From where it is seen if it is framed.
    pub viewpoint: Viewpoint,
    /// The axis that is vertical when the scene is framed.
    pub up: DVec3,
    /// How it is drawn.
    pub settings: RenderSettings,
    /// The surfaces, in the order of drawing.
    pub surfaces: Vec<Surface>,
    /// The meshes, which are drawn after the surfaces.
    pub meshes: Vec<MeshModel>,
    /// The CAD models; their faces are among the surfaces.
    pub models: Vec<CadModel>,
}

impl Default for Scene {
    /// An empty scene, framed with y upright, drawn by the exact method within half a pixel.
    fn default() -> Self {
        Self {
            files: Vec::new(),
            camera: None,
            camera_path: None,
            viewpoint: Viewpoint::default(),
            up: DVec3::Y,
            settings: RenderSettings::default(),
            surfaces: Vec::new(),
            meshes: Vec::new(),
            models: Vec::new(),
        }
    }
}

impl Scene {
    /// Reads a `.toml`, `.bpt` or `.obj` file, or a CAD model: `.ffm`, and by a program of its own, STEP, IGES and BREP
    /// files.
    ///
    /// # Errors
    /// A file that cannot be read, is of another kind, or does not describe a scene; with the line.
    pub fn load(path: &Path) -> Result<Self> {
        Self::load_with(path, &LoadOptions::default())
    }

    /// Reads a file as [`Scene::load`]; the options override the file.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_with(path: &Path, options: &LoadOptions) -> Result<Self> {
        let mut scene = match extension(path).as_str() {
            "toml" => document::parse(&read_text(path)?, path, options)?,
            "bpt" => Self::from_bpt(&read_text(path)?, path)?,
            "obj" => Self::of_obj(path, options)?,
            _ if CadModel::is_file_of_one(path) => {
                Self::from_model(Model::load(path, options)?, path)?
            }
            // A missing file, or a folder, is reported first.
            other => {
                return Err(check_is_file(path).err().unwrap_or_else(|| {
                    let reason = format!(
                        "a scene is a .toml, .bpt, .obj, .ffm, .step, .iges or .brep file, not \"{other}\""
                    );
                    unreadable(path, reason)
                }));
            }
        };
        scene.up = options.up.map_or(scene.up, UpAxis::direction);
        Ok(scene)
    }

    /// Parses the text of a scene. The beginning of the text decides its format: a `.bpt` file begins with a number, an
    /// `.obj` file with one of its keywords, a `.ffm` file with `freeform-model`. Files that it names are found
    /// relative to the folder of `name`, which also stands in the errors; a bare word means the current folder.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn from_text(text: &str, name: &Path, options: &LoadOptions) -> Result<Self> {
        let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
        let mut scene = if text.trim_start().starts_with(|first: char| first.is_ascii_digit()) {
            Self::from_bpt(text, name)?
        } else if Model::is_text_of_one(text) {
            Self::from_model(Model::from_text(text, name)?, name)?
        } else if obj::is_obj(text) {
            let crease = options.crease.unwrap_or_default();
            Self::with_obj(obj::parse(text, name, crease, Smoothing::None)?, name)
        } else {
            document::parse(text, name, options)?
        };
        scene.files.retain(|file| file != name);
        scene.up = options.up.map_or(scene.up, UpAxis::direction);
        Ok(scene)
    }

    /// Parses the text of a `.toml` scene; files that it names are found relative to the folder of `path`, which also
    /// appears in error messages.
    ///
    /// # Errors
    /// Text that does not describe a scene, a file in it that cannot be read; with the line.
    pub fn from_toml(text: &str, path: &Path) -> Result<Self> {
        document::parse(text, path, &LoadOptions::default())
    }

    /// Parses the text of a `.bpt` file: a framed scene with z upright. `path` appears in error messages.
    ///
    /// # Errors
    /// Text that is not a list of Bézier patches; with the line.
    pub fn from_bpt(text: &str, path: &Path) -> Result<Self> {
        let surfaces = bpt::parse(text, path)?;
        Ok(Self { surfaces, up: DVec3::Z, ..Self::empty(path) })
    }

    /// The scene of listing 16: the default surface with its four inner points raised, a round hole
    /// and bricks.
    ///
    /// # Panics
    /// Never: its contents are fixed.
    #[must_use]
    pub fn listing16() -> Self {
        let mut points = default_control_points();
        for index in [5, 6, 9, 10] {
            points[index].y = 0.5;
        }
        let mut surface =
            Surface::new(Degree::CUBIC, points).expect("the default control points make one patch");
        surface.transform = DMat4::from_translation(dvec3(0.0, 1.0, 0.0));
        surface.paint = Paint::Texture(Arc::new(texture::brick()));
        let hole = Circle::new(dvec2(0.5, 0.5), 0.2).expect("a fixed circle");
        surface.trims.circles.push(hole);
        let settings = RenderSettings { light: Light::Thesis, ..RenderSettings::default() };
        Self { surfaces: vec![surface], settings, ..Self::default() }
    }

    /// The surfaces and the mesh of a file, without smoothing; the mesh's normals are interpolated.
    fn of_obj(path: &Path, options: &LoadOptions) -> Result<Self> {
        let crease = options.crease.unwrap_or_default();
        Ok(Self::with_obj(obj::load(path, crease, Smoothing::None)?, path))
    }

    fn with_obj(obj::ObjScene { surfaces, model, files }: obj::ObjScene, path: &Path) -> Self {
        let meshes = model.into_iter().collect();
        Self { files, surfaces, meshes, ..Self::empty(path) }
    }

    /// A CAD model alone: z upright, seen isometrically. `path` is the file that it was read from; a model made in code
    /// may have any name.
    ///
    /// # Errors
    /// A model without any face that can be drawn.
    pub fn from_model(model: Model, path: &Path) -> Result<Self> {
        let (model, surfaces) = CadModel::new(model, path, 0, DMat4::IDENTITY, None)?;
        let (up, viewpoint) = (DVec3::Z, Viewpoint::Isometric);
        Ok(Self { models: vec![model], surfaces, up, viewpoint, ..Self::empty(path) })
    }

    /// An empty scene for a file.
    fn empty(path: &Path) -> Self {
        Self { files: vec![path.to_owned()], ..Self::default() }
    }

    /// The matrices of the scene's camera, or of the one that frames it, for a picture of `width` × `height` pixels.
    #[must_use]
    pub fn projection(&self, width: u32, height: u32) -> ViewProjection {
        let aspect = f64::from(width) / f64::from(height);
        let points = self.surfaces.iter().flat_map(Surface::world_points);
        let points = points.chain(self.meshes.iter().flat_map(MeshModel::world_hull));
        self.camera.unwrap_or_else(|| self.framed(aspect)).projection(points, aspect)
    }

    /// A camera that sees the whole scene, for pictures of `aspect` (width over height).
    #[must_use]
    pub fn framed(&self, aspect: f64) -> Camera {
        let points = self.shown_points();
        let points = points.iter().copied();
        match self.viewpoint {
            Viewpoint::Front => Camera::framing(points, self.up, aspect),
            Viewpoint::Isometric => Camera::isometric(points, self.up, aspect),
        }
    }

    /// A camera that looks the same way and sees the whole scene.
    #[must_use]
    pub fn fitted(&self, camera: &Camera, aspect: f64) -> Camera {
        camera.fitted(self.shown_points().iter().copied(), aspect)
    }

    /// The camera of a frame of [`Scene::camera_path`]; `None` without a path.
    ///
    /// # Errors
    /// As [`CameraPath::at`].
    pub fn camera_at(&self, time: f64) -> Result<Option<Camera>> {
        let lens = self.camera.map_or(Lens::default(), |camera| camera.lens());
        self.camera_path.as_ref().map(|path| path.at(time, lens)).transpose()
    }

    /// A camera that goes around the scene, for pictures of `aspect` (width over height). `axis` is one of the axes of
    /// world space. The scene's own camera goes around its target. Without one, the camera goes around the middle of the
    /// scene, and the whole scene stays in the picture during the turn.
    #[must_use]
    pub fn turntable(&self, axis: DVec3, aspect: f64) -> Turntable {
        // Points between these angles leave the scene's circle by less than the margin of a framed picture.
        const ANGLES: u32 = 24;
        if let Some(start) = self.camera {
            return Turntable { start, center: start.target(), axis };
        }
        let points = self.shown_points();
        let [min, max] = bounding_box(points.iter().copied());
        let center =
            if min.is_finite() && max.is_finite() { 0.5 * (min + max) } else { DVec3::ZERO };
        let turned = (0..ANGLES).flat_map(|number| {
            let angle = std::f64::consts::TAU * f64::from(number) / f64::from(ANGLES);
            let turn = DQuat::from_axis_angle(axis, angle);
            points.iter().map(move |point| center + turn * (*point - center))
        });
        let turned: Vec<DVec3> = turned.collect();
        let start = self.framed(aspect).fitted(turned.iter().copied(), aspect);
        Turntable { start, center, axis }
    }

    /// Points in world space that show the extent of the scene. A camera is fitted to them in several steps, so they are
    /// computed once.
    fn shown_points(&self) -> Vec<DVec3> {
        // If there are few patches, each needs many samples to show its shape; if there are many, each needs few.
        const SAMPLES: usize = 4_000;
        let surfaces = self.surfaces.iter().filter(|surface| !surface.hidden);
        let patches: usize = surfaces.clone().map(|surface| surface.patches().len()).sum();
        let side = (SAMPLES / patches.max(1)).isqrt().clamp(2, 17);
        let points = surfaces.clone().flat_map(move |surface| surface.samples(side));
        let control_points = surfaces.flat_map(Surface::world_points);
        let shown = if self.settings.control_points { usize::MAX } else { 0 };
        points
            .chain(self.meshes.iter().flat_map(MeshModel::samples))
            .chain(control_points.take(shown))
            .collect()
    }
}
