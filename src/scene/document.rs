//! `.toml` scenes: the text's tables, checked and turned into a [`Scene`]. Every fault names its line.

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat4, DVec2, DVec3, DVec4, EulerRot};
use serde::Deserialize;
use serde::de::{Deserializer, SeqAccess, Visitor};
use toml::Spanned;

use super::{
    Image, Paint, RenderSettings, Scene, Shading, Surface, TessLevel, bpt, default_control_points,
    line_of, load_texture, read_text,
};
use crate::bezier::{MAX_COORDINATE, check_coordinates};
use crate::camera::Lens;
use crate::{
    Camera, Circle, Degree, Ellipse, Error, Interval, Newton, NewtonTrims, Result, Segment,
    TrimLoop,
};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    camera: Option<Spanned<CameraTable>>,
    render: Option<Spanned<RenderTable>>,
    #[serde(default)]
    surface: Vec<Spanned<SurfaceTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraTable {
    eye: DVec3Value,
    target: DVec3Value,
    #[serde(default = "upright")]
    up: DVec3Value,
    fov_y_degrees: Option<f64>,
    orthographic_height: Option<f64>,
}

type DVec3Value = [f64; 3];

const fn upright() -> DVec3Value {
    [0.0, 1.0, 0.0]
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct RenderTable {
    background: Option<Spanned<[f32; 4]>>,
    /// Only one method so far; the key is there so that a scene can say which it was made for.
    #[serde(rename = "method")]
    _method: Option<Method>,
    level: Option<Spanned<i64>>,
    wireframe: bool,
    control_points: bool,
    newton: Option<Spanned<NewtonTable>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum Method {
    Thesis,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct NewtonTable {
    iterations: Option<u32>,
    epsilon: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SurfaceTable {
    control_points: Option<Spanned<ControlPoints>>,
    file: Option<Spanned<String>>,
    texture: Option<Spanned<String>>,
    color: Option<Spanned<[f32; 3]>>,
    #[serde(default)]
    shading: ShadingName,
    translate: Option<DVec3Value>,
    rotate_degrees: Option<DVec3Value>,
    scale: Option<f64>,
    #[serde(default)]
    trim: Vec<Spanned<TrimTable>>,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum ShadingName {
    #[default]
    Phong,
    Texture,
    Flat,
    Normals,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase", deny_unknown_fields)]
enum TrimTable {
    Circle { center: [f64; 2], radius: f64 },
    Interval { u: [f64; 2], v: [f64; 2] },
    Ellipse { center: [f64; 2], radii: [f64; 2] },
    Loop(Vec<Vec<[f64; 2]>>),
}

/// `"default"`, or points of three or four numbers.
enum ControlPoints {
    Default,
    Points(Vec<DVec4>),
}

impl<'de> Deserialize<'de> for ControlPoints {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PointsVisitor;
        impl<'de> Visitor<'de> for PointsVisitor {
            type Value = ControlPoints;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("16 or 25 points [x, y, z] or [x, y, z, weight], or \"default\"")
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Self::Value, E> {
                match text {
                    "default" => Ok(ControlPoints::Default),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(text), &self)),
                }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut points = Vec::new();
                while let Some(ControlPoint(point)) = seq.next_element()? {
                    points.push(point);
                }
                Ok(ControlPoints::Points(points))
            }
        }
        deserializer.deserialize_any(PointsVisitor)
    }
}

/// One point; the weight is 1 where it is not given.
struct ControlPoint(DVec4);

impl<'de> Deserialize<'de> for ControlPoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PointVisitor;
        impl<'de> Visitor<'de> for PointVisitor {
            type Value = ControlPoint;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a point [x, y, z] or [x, y, z, weight]")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut point = DVec4::W;
                let mut count = 0;
                while let Some(value) = seq.next_element()? {
                    if count < 4 {
                        point[count] = value;
                    }
                    count += 1;
                }
                if matches!(count, 3 | 4) {
                    Ok(ControlPoint(point))
                } else {
                    Err(serde::de::Error::invalid_length(count, &self))
                }
            }
        }
        deserializer.deserialize_seq(PointVisitor)
    }
}

/// The most bytes of one `[[surface]]` with its trims. The toml crate takes up to 250 times as much
/// memory; a control net that is larger has its place in a .bpt file.
const MAX_SURFACE_BYTES: usize = 256 << 10;

/// Parses a scene; `path` is for the errors and for the folder of the files it names.
///
/// Each `[[surface]]` is parsed by itself, so that the memory grows with the largest of them and not
/// with the file.
pub(super) fn parse(text: &str, path: &Path) -> Result<Scene> {
    let files = vec![path.to_owned()];
    let mut builder = Builder { text, path, chunk: 0, textures: HashMap::new(), files };
    let mut camera = None;
    let mut settings = None;
    let mut surfaces = Vec::new();
    for chunk in chunks(text) {
        builder.chunk = chunk.start;
        let document = builder.document(&text[chunk])?;
        builder.once("camera", &mut camera, document.camera, camera_of)?;
        builder.once("render", &mut settings, document.render, settings_of)?;
        for table in document.surface {
            surfaces.extend(builder.surfaces(table)?);
        }
    }
    if surfaces.is_empty() {
        let nothing = Error::invalid("scene", "empty", "at least one [[surface]]");
        builder.chunk = 0;
        return Err(builder.at(0, nothing));
    }
    let settings = settings.unwrap_or_default();
    Ok(Scene { files: builder.files, camera, up: DVec3::Y, settings, surfaces })
}

/// The text before the first line `[[surface]]`, then from each such line to the next.
fn chunks(text: &str) -> Vec<Range<usize>> {
    let mut starts = vec![0];
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let header = line.split('#').next().unwrap_or_default().trim();
        if offset > 0 && header == "[[surface]]" {
            starts.push(offset);
        }
        offset += line.len();
    }
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    std::iter::zip(starts.iter().copied(), ends).map(|(start, end)| start..end).collect()
}

struct Builder<'a> {
    text: &'a str,
    path: &'a Path,
    /// Where the part begins that is parsed now; spans count from there.
    chunk: usize,
    textures: HashMap<PathBuf, Arc<Image>>,
    files: Vec<PathBuf>,
}

impl Builder<'_> {
    /// An error at the line of a byte of the chunk.
    fn at(&self, offset: usize, error: impl ToString) -> Error {
        Error::Scene {
            path: self.path.to_owned(),
            line: line_of(self.text, self.chunk + offset),
            message: error.to_string().trim().replace(char::is_control, " "),
        }
    }

    /// Checks a value, giving a fault the line where the value stands.
    fn check<T, U>(&self, value: Spanned<T>, check: impl FnOnce(T) -> Result<U>) -> Result<U> {
        let start = value.span().start;
        check(value.into_inner()).map_err(|error| self.at(start, error))
    }

    fn document(&self, chunk: &str) -> Result<Document> {
        let size = chunk.len();
        if size > MAX_SURFACE_BYTES {
            return Err(self.at(
                0,
                format!(
                    "{size} bytes up to the next [[surface]]; expected at most \
                     {MAX_SURFACE_BYTES}: a large control net belongs in a .bpt file"
                ),
            ));
        }
        toml::from_str(chunk)
            .map_err(|error| self.at(error.span().map_or(0, |span| span.start), error.message()))
    }

    /// Takes a table that a scene has at most once.
    fn once<T, U>(
        &self,
        name: &str,
        place: &mut Option<U>,
        table: Option<Spanned<T>>,
        convert: impl FnOnce(&Self, T) -> Result<U>,
    ) -> Result<()> {
        let Some(table) = table else { return Ok(()) };
        let start = table.span().start;
        if place.is_some() {
            return Err(self.at(start, format!("a second [{name}]; expected one, in one piece")));
        }
        *place = Some(convert(self, table.into_inner()).map_err(|error| match error {
            Error::Scene { .. } => error,
            other => self.at(start, other),
        })?);
        Ok(())
    }

    fn beside_scene(&self, file: &str) -> PathBuf {
        self.path.parent().unwrap_or_else(|| Path::new("")).join(file)
    }

    /// The surface of one table; several if its file holds patches of two degrees.
    fn surfaces(&mut self, table: Spanned<SurfaceTable>) -> Result<Vec<Surface>> {
        let start = table.span().start;
        let table = table.into_inner();
        let mut surfaces = match (table.control_points, table.file) {
            (Some(points), None) => vec![self.check(points, surface_of_points)?],
            (None, Some(file)) => {
                let path = self.beside_scene(file.get_ref());
                let surfaces = self.check(file, |_| bpt::parse(&read_text(&path)?, &path))?;
                self.files.push(path);
                surfaces
            }
            _ => {
                let choice = Error::invalid(
                    "surface",
                    "without one source of points",
                    "either control_points or file",
                );
                return Err(self.at(start, choice));
            }
        };
        let paint = self.paint(table.texture, table.color, table.shading)?;
        let transform = transform(table.translate, table.rotate_degrees, table.scale)
            .map_err(|error| self.at(start, error))?;
        for surface in &mut surfaces {
            surface.transform = transform;
            surface.paint = paint.clone();
            surface.shading = match table.shading {
                ShadingName::Phong => Shading::Phong,
                ShadingName::Texture | ShadingName::Flat => Shading::Unlit,
                ShadingName::Normals => Shading::Normals,
            };
        }
        let mut loop_places = Vec::new();
        for trim in table.trim {
            if matches!(trim.get_ref(), TrimTable::Loop(_)) {
                loop_places.push(trim.span().start);
            }
            self.check(trim, |trim| {
                surfaces.iter_mut().try_for_each(|surface| add_trim(&trim, surface))
            })?;
        }
        for surface in &surfaces {
            NewtonTrims::sorted(&surface.trims.loops)
                .map_err(|(to_blame, error)| self.at(loop_places[to_blame], error))?;
        }
        Ok(surfaces)
    }

    fn paint(
        &mut self,
        texture: Option<Spanned<String>>,
        color: Option<Spanned<[f32; 3]>>,
        shading: ShadingName,
    ) -> Result<Paint> {
        match (texture, color) {
            (None, None) => Ok(Paint::default()),
            (None, Some(color)) => {
                self.check(color, |rgb| unit_range("color", rgb)).map(Paint::Color)
            }
            (Some(texture), None) if shading != ShadingName::Flat => {
                let path = self.beside_scene(texture.get_ref());
                if let Some(image) = self.textures.get(&path) {
                    return Ok(Paint::Texture(Arc::clone(image)));
                }
                let image = Arc::new(self.check(texture, |_| load_texture(&path))?);
                self.textures.insert(path.clone(), Arc::clone(&image));
                self.files.push(path);
                Ok(Paint::Texture(image))
            }
            (Some(texture), _) => self.check(texture, |name| {
                Err(Error::invalid(
                    "texture",
                    format!("\"{name}\" beside color or shading = \"flat\""),
                    "either a texture or a color; flat takes a color",
                ))
            }),
        }
    }
}

fn settings_of(builder: &Builder<'_>, table: RenderTable) -> Result<RenderSettings> {
    let mut settings = RenderSettings {
        wireframe: table.wireframe,
        control_points: table.control_points,
        ..RenderSettings::default()
    };
    if let Some(background) = table.background {
        settings.background = builder.check(background, |rgba| unit_range("background", rgba))?;
    }
    if let Some(level) = table.level {
        settings.level = builder.check(level, TessLevel::new)?;
    }
    if let Some(newton) = table.newton {
        settings.newton = builder.check(newton, |table| {
            let default = Newton::default();
            Newton::new(
                table.iterations.unwrap_or(default.iterations()),
                table.epsilon.unwrap_or(default.epsilon()),
            )
        })?;
    }
    Ok(settings)
}

fn camera_of(_: &Builder<'_>, table: CameraTable) -> Result<Camera> {
    let lens = match (table.fov_y_degrees, table.orthographic_height) {
        (fov, None) => Lens::Perspective { fov_y_radians: fov.unwrap_or(45.0).to_radians() },
        (None, Some(height)) => Lens::Orthographic { height },
        (Some(_), Some(_)) => {
            return Err(Error::invalid(
                "camera",
                "given fov_y_degrees and orthographic_height",
                "one of them",
            ));
        }
    };
    Camera::new(table.eye.into(), table.target.into(), table.up.into(), lens)
}

fn surface_of_points(points: ControlPoints) -> Result<Surface> {
    let points = match points {
        ControlPoints::Default => default_control_points(),
        ControlPoints::Points(points) => points,
    };
    Surface::new(Degree::from_point_count(points.len())?, points)
}

fn unit_range<const N: usize>(name: &str, values: [f32; N]) -> Result<[f32; N]> {
    if values.iter().all(|value| (0.0..=1.0).contains(value)) {
        Ok(values)
    } else {
        Err(Error::invalid(name, format!("{values:?}"), "numbers from 0 to 1"))
    }
}

/// Scale first, then the rotations about x, y and z, then the translation.
fn transform(
    translate: Option<DVec3Value>,
    rotate_degrees: Option<DVec3Value>,
    scale: Option<f64>,
) -> Result<DMat4> {
    let translate = DVec3::from(translate.unwrap_or_default());
    let rotate = DVec3::from(rotate_degrees.unwrap_or_default());
    let scale = scale.unwrap_or(1.0);
    for (name, vector) in [("translate", translate), ("rotate_degrees", rotate)] {
        check_coordinates(name, vector)?;
    }
    if !(1.0 / MAX_COORDINATE..=MAX_COORDINATE).contains(&scale.abs()) {
        return Err(Error::invalid("scale", scale, "a number other than 0, of size 1e-15 to 1e15"));
    }
    let radians = rotate.map(f64::to_radians);
    Ok(DMat4::from_translation(translate)
        * DMat4::from_euler(EulerRot::ZYX, radians.z, radians.y, radians.x)
        * DMat4::from_scale(DVec3::splat(scale)))
}

fn add_trim(trim: &TrimTable, surface: &mut Surface) -> Result<()> {
    let trims = &mut surface.trims;
    match trim {
        TrimTable::Circle { center, radius } => {
            trims.circles.push(Circle::new(DVec2::from(*center), *radius)?);
        }
        TrimTable::Interval { u, v } => {
            trims.intervals.push(Interval::new(DVec2::from(*u), DVec2::from(*v))?);
        }
        TrimTable::Ellipse { center, radii } => {
            trims.ellipses.push(Ellipse::new(DVec2::from(*center), DVec2::from(*radii))?);
        }
        TrimTable::Loop(segments) => {
            let segments = segments.iter().map(|points| {
                let points: Vec<DVec2> = points.iter().map(|point| DVec2::from(*point)).collect();
                Segment::new(&points)
            });
            trims.loops.push(TrimLoop::new(segments.collect::<Result<_>>()?)?);
        }
    }
    Ok(())
}
