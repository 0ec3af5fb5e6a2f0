//! `.toml` scenes: the text's tables, checked and turned into a [`Scene`]. Every error names its line.

mod models;
mod stage;
mod trims;

use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4, EulerRot};
use toml::Spanned;

use super::file::{extension, line_of, read_text, unreadable};
use super::surface::check_transform;
use super::tables::{
    CameraKeyTable, CameraTable, ControlPoints, CullName, DVec3Value, Document, KeepName,
    MeshTable, ShadingName, SmoothingName, SurfaceTable,
};
use super::{
    Cull, Image, LoadOptions, MeshModel, Method, Paint, Scene, Surface, TessLevel, UpAxis,
    Viewpoint, bpt, default_control_points, load_texture, obj,
};
use crate::bezier::{Degree, MAX_COORDINATE, NurbsSurface, check_coordinates};
use crate::camera::{Camera, CameraKey, CameraPath, Lens};
use crate::error::{Error, Result};
use crate::mesh::{Alpha, CreaseAngle, Smoothing};
use crate::trim::{Keep, Trims};
use stage::{Stage, stage_of};
use trims::{PlacedTrims, TrimPlaces};

/// The maximum number of bytes of one `[[surface]]` with its trims. Of each string, only the first `MAX_STRING_BYTES`
/// bytes count. The toml crate takes up to 250 times as much memory. A larger control net belongs in a .bpt or .obj
/// file, a long trim in a `path`.
const MAX_SURFACE_BYTES: usize = 256 << 10;
const MAX_STRING_BYTES: usize = 64;
/// The maximum number of control points of the Bézier patches of a NURBS surface: 32 MiB.
pub(super) const MAX_PATCH_POINTS: usize = 1 << 20;

/// Parses a scene; `path` appears in error messages, and files that the scene names are found relative to its folder.
///
/// Each `[[surface]]` is parsed separately, so that the memory grows with the largest of them and not
/// with the file.
pub(super) fn parse(text: &str, path: &Path, options: &LoadOptions) -> Result<Scene> {
    let files = vec![path.to_owned()];
    let mut builder =
        Builder { text, path, options, chunk: 0, textures: HashMap::new(), files, from_files: 0 };
    let mut camera = None;
    let mut stage = None;
    let mut surfaces = Vec::new();
    let mut meshes = Vec::new();
    let mut models = Vec::new();
    let mut trim_places = Vec::new();
    let mut keys = Vec::new();
    for chunk in chunks(text) {
        builder.chunk = chunk.start;
        let document = builder.document(&text[chunk])?;
        builder.once("camera", &mut camera, document.camera, camera_of)?;
        for table in document.camera_key {
            let before = keys.last().map_or(f64::NEG_INFINITY, |key: &CameraKey| key.time);
            keys.push(builder.check(table, |table| camera_key_of(&table, before))?);
        }
        builder.once("render", &mut stage, document.render, stage_of)?;
        for table in document.surface {
            let (new, places) = builder.surfaces(table)?;
            trim_places.extend(new.iter().map(|_| places.clone()));
            surfaces.extend(new);
        }
        for table in document.mesh {
            meshes.push(builder.mesh(table)?);
        }
        for table in document.model {
            let (model, faces) = builder.model(table, models.len())?;
            trim_places.extend(faces.iter().map(|_| TrimPlaces::of_surface(builder.chunk)));
            surfaces.extend(faces);
            models.push(model);
        }
    }
    if surfaces.is_empty() && meshes.is_empty() {
        let nothing =
            Error::invalid("scene", "empty", "at least one [[surface]], [[mesh]] or [[model]]");
        builder.chunk = 0;
        return Err(builder.at(0, nothing));
    }
    let Stage { settings, up } = stage.unwrap_or_default();
    // A scene of nothing but `.bpt` files and CAD models is oriented as these files are on their own.
    let of_files = meshes.is_empty() && surfaces.len() == builder.from_files;
    let of_models = meshes.is_empty() && surfaces.iter().all(|surface| surface.face.is_some());
    let viewpoint = if of_models { Viewpoint::Isometric } else { Viewpoint::Front };
    let up = up.unwrap_or(if of_files { UpAxis::Z } else { UpAxis::Y }).direction();
    if settings.method == Method::Thesis {
        builder.chunk = 0;
        for (surface, places) in std::iter::zip(&surfaces, &trim_places) {
            builder.check_for_thesis(surface, places)?;
        }
    }
    let camera_path = (!keys.is_empty()).then(|| CameraPath::new(keys)).transpose()?;
    let files = builder.files;
    let mut scene =
        Scene { files, camera, camera_path, viewpoint, up, settings, surfaces, meshes, models };
    if let Some(path) = scene.camera_path.as_ref().filter(|_| camera.is_none()) {
        scene.camera = Some(path.at(f64::NEG_INFINITY, Lens::default())?);
    }
    Ok(scene)
}

/// The text before the first line `[[surface]]`, `[[mesh]]`, `[[model]]` or `[[camera_key]]`, then from each such line to the next.
fn chunks(text: &str) -> Vec<Range<usize>> {
    let mut starts = vec![0];
    let mut offset = 0;
    for line in text.split_inclusive('\n') {
        let header = line.split('#').next().unwrap_or_default().trim();
        if offset > 0
            && matches!(header, "[[surface]]" | "[[mesh]]" | "[[model]]" | "[[camera_key]]")
        {
            starts.push(offset);
        }
        offset += line.len();
    }
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    std::iter::zip(starts.iter().copied(), ends).map(|(start, end)| start..end).collect()
}

/// Checks the size of the text of a surface.
///
/// # Errors
/// A text that is longer than the limit.
pub(super) fn check_surface(text: &str) -> Result<()> {
    let size = bytes_that_count(text);
    if size > MAX_SURFACE_BYTES {
        return Err(Error::invalid(
            "text up to the next [[surface]]",
            format!("{size} bytes, without those of long strings"),
            format!(
                "at most {MAX_SURFACE_BYTES}: a large control net belongs in a .bpt or .obj file, a long trim in a \
                 path, many paths with rules in an SVG file"
            ),
        ));
    }
    Ok(())
}

/// The number of bytes of a TOML text; of each string, only the first `MAX_STRING_BYTES` bytes count.
fn bytes_that_count(text: &str) -> usize {
    let mut rest = text;
    let mut count = 0;
    while let Some(start) = rest.find(['"', '\'', '#']) {
        rest = &rest[start..];
        let quote = ["\"\"\"", "'''", "\"", "'"].into_iter().find(|quote| rest.starts_with(quote));
        let (length, max) = match quote {
            // A comment.
            None => (rest.find('\n').unwrap_or(rest.len()), usize::MAX),
            Some(quote) => {
                (quote.len() + length_of_string(&rest[quote.len()..], quote), MAX_STRING_BYTES)
            }
        };
        count += start + length.min(max);
        rest = &rest[length..];
    }
    count + rest.len()
}

/// The length of a string including its closing quote. If there is none, the string ends with its line or with the
/// text.
fn length_of_string(text: &str, quote: &str) -> usize {
    let escapes = quote.starts_with('"');
    let mut escaped = false;
    for (at, byte) in text.bytes().enumerate() {
        if escaped {
            escaped = false;
        } else if escapes && byte == b'\\' {
            escaped = true;
        } else if text.as_bytes()[at..].starts_with(quote.as_bytes()) {
            return at + quote.len();
        } else if byte == b'\n' && quote.len() == 1 {
            return at;
        }
    }
    text.len()
}

struct Builder<'a> {
    text: &'a str,
    path: &'a Path,
    /// They override the tables.
    options: &'a LoadOptions,
    /// The offset of the chunk that is being parsed; spans are relative to it.
    chunk: usize,
    textures: HashMap<PathBuf, Arc<Image>>,
    files: Vec<PathBuf>,
    /// How many surfaces come from `.bpt` files and CAD models.
    from_files: usize,
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

    /// Checks a value; an error gets the line of the value.
    fn check<T, U>(&self, value: Spanned<T>, check: impl FnOnce(T) -> Result<U>) -> Result<U> {
        let start = value.span().start;
        check(value.into_inner()).map_err(|error| self.at(start, error))
    }

    fn document(&self, chunk: &str) -> Result<Document> {
        check_surface(chunk).map_err(|error| self.at(0, error))?;
        toml::from_str(chunk)
            .map_err(|error| self.at(error.span().map_or(0, |span| span.start), error.message()))
    }

    /// Converts a table that a scene may have only once.
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

    /// The surfaces of one table, and where its trims are in the text. There is more than one surface if the table's
    /// file contains patches of two degrees, or several NURBS surfaces.
    fn surfaces(&mut self, table: Spanned<SurfaceTable>) -> Result<(Vec<Surface>, TrimPlaces)> {
        let start = table.span().start;
        let table = table.into_inner();
        if let (Some(degree), None) = (&table.degree, &table.control_points) {
            let error = Error::invalid("degree", "without control points", "control_points");
            return Err(self.at(degree.span().start, error));
        }
        if let (Some(knots), None) = (&table.knots, &table.degree) {
            let error = Error::invalid("knots", "without a degree", "degree = [u, v]");
            return Err(self.at(knots.span().start, error));
        }
        let degree = table.degree.map(|degree| self.check(degree, |[u, v]| Degree::new(u, v)));
        let degree = degree.transpose()?;
        let mut surfaces = match (table.control_points, table.file) {
            (Some(points), None) => {
                let knots = match (degree, table.knots) {
                    (Some(degree), Some(knots)) => {
                        Some(self.check(knots, |knots| checked_knots(degree, knots))?)
                    }
                    _ => None,
                };
                vec![self.check(points, |points| surface_of_points(points, degree, knots))?]
            }
            (None, Some(file)) => {
                let path = self.beside_scene(file.get_ref());
                let surfaces = self.check(file, |_| match extension(&path).as_str() {
                    "obj" => obj::load_surfaces(&path),
                    _ => bpt::parse(&read_text(&path)?, &path),
                })?;
                if extension(&path) != "obj" {
                    self.from_files += surfaces.len();
                }
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
        let transform = placed(table.translate, table.rotate_degrees, table.scale, table.matrix)
            .map_err(|error| self.at(start, error))?;
        for surface in &mut surfaces {
            surface.transform = transform;
            surface.paint = paint.clone();
            surface.shading = table.shading.into();
            surface.hidden = table.hidden;
            surface.join = table.join;
            surface.cull = match table.cull {
                CullName::None => Cull::None,
                CullName::Back => Cull::Back,
            };
        }
        let keep = table.keep.as_ref().map(|keep| keep.span().start);
        let Some(first_trim) = table.trim.first().map(|trim| trim.span().start).or(keep) else {
            return Ok((surfaces, TrimPlaces::of_surface(self.chunk + start)));
        };
        check_takes_trims(&surfaces).map_err(|error| self.at(first_trim, error))?;
        let keep = table.keep.map_or(KeepName::default(), Spanned::into_inner);
        let PlacedTrims { trims, places } = self.trims(table.trim, keep, &surfaces[0], start)?;
        if trims.keep == Keep::Inside && !trims.has_loops() {
            let borderless =
                Error::invalid("keep", "\"inside\" without a loop", "a loop or path as the border");
            return Err(self.at(start, borderless));
        }
        // Trims may be large, so one surface takes them without a copy.
        let (first, others) = surfaces.split_first_mut().expect("a file has a patch");
        for surface in others {
            surface.trims = trims.clone();
        }
        first.trims = trims;
        Ok((surfaces, places))
    }

    fn mesh(&mut self, table: Spanned<MeshTable>) -> Result<MeshModel> {
        let start = table.span().start;
        let table = table.into_inner();
        let smoothing = match (table.smoothing, table.alpha) {
            (SmoothingName::Phong, alpha) => {
                let alpha = alpha.map(|alpha| self.check(alpha, Alpha::new)).transpose()?;
                Smoothing::Phong(alpha.unwrap_or_default())
            }
            (_, Some(alpha)) => {
                let error = Error::invalid("alpha", alpha.as_ref(), "none but with \"phong\"");
                return Err(self.at(alpha.span().start, error));
            }
            (SmoothingName::Pn, None) => Smoothing::Pn,
            (SmoothingName::None, None) => Smoothing::None,
        };
        let crease = table.crease_degrees.map(|angle| self.check(angle, CreaseAngle::new));
        let crease = self.options.crease.or(crease.transpose()?).unwrap_or_default();
        let path = self.beside_scene(table.file.get_ref());
        let (mut model, files) = self.check(table.file, |_| {
            let obj::ObjScene { model, files, .. } = obj::load(&path, crease, smoothing)?;
            let without =
                "it has free-form surfaces and no face; expected the file of a [[surface]]";
            Ok((model.ok_or_else(|| unreadable(&path, without))?, files))
        })?;
        self.files.extend(files);
        model.level = table.level.map(|level| self.check(level, TessLevel::new)).transpose()?;
        if table.texture.is_some() || table.color.is_some() {
            model.materials.clear();
            model.paint = self.paint(table.texture, table.color, table.shading)?;
        }
        model.shading = table.shading.into();
        model.transform = placed(table.translate, table.rotate_degrees, table.scale, table.matrix)
            .map_err(|error| self.at(start, error))?;
        Ok(model)
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

fn camera_key_of(table: &CameraKeyTable, before: f64) -> Result<CameraKey> {
    let &CameraKeyTable { time, eye, target, up } = table;
    let key = CameraKey { time, eye: eye.into(), target: target.into(), up: up.into() };
    key.check_after(before)?;
    Ok(key)
}

/// Checks the knots along u and v of a surface.
fn checked_knots(degree: Degree, knots: [Vec<f64>; 2]) -> Result<[Vec<f64>; 2]> {
    NurbsSurface::check_knots(degree, &knots)?;
    let count = NurbsSurface::points_of_patches(degree, &knots);
    if count > MAX_PATCH_POINTS {
        let expected =
            format!("at most {MAX_PATCH_POINTS}; a larger surface belongs in an .obj file");
        return Err(Error::invalid("control points of all patches", count, expected));
    }
    Ok(knots)
}

/// A NURBS surface; or without knots, a patch of a degree; or without a degree, of 4×4 or 5×5 points.
fn surface_of_points(
    points: ControlPoints,
    degree: Option<Degree>,
    knots: Option<[Vec<f64>; 2]>,
) -> Result<Surface> {
    let points = match points {
        ControlPoints::Default => default_control_points(),
        ControlPoints::Points(points) => points,
    };
    match (degree, knots) {
        (Some(degree), Some(knots)) => {
            NurbsSurface::new(degree, knots, points).map(Surface::from_nurbs)
        }
        (Some(degree), None) => Surface::of_patch(degree, points),
        (None, _) => Surface::new(Degree::from_point_count(points.len())?, points),
    }
}

/// Checks that a table can trim its surfaces: their domain is the same, and they have no trims of their own.
fn check_takes_trims(surfaces: &[Surface]) -> Result<()> {
    let value = if surfaces.iter().any(|surface| surface.trims != Trims::default()) {
        "beside a file whose surfaces have trims of their own"
    } else if surfaces.len() > 1 && surfaces.iter().any(|surface| surface.nurbs().is_some()) {
        "beside a file of several surfaces, each with its own parameters"
    } else {
        return Ok(());
    };
    Err(Error::invalid("trim or keep", value, "none, or a file of one surface without trims"))
}

fn unit_range<const N: usize>(name: &str, values: [f32; N]) -> Result<[f32; N]> {
    if values.iter().all(|value| (0.0..=1.0).contains(value)) {
        Ok(values)
    } else {
        Err(Error::invalid(name, format!("{values:?}"), "numbers from 0 to 1"))
    }
}

/// The transform to world space, given as the first three rows of a matrix or by the arguments of [`transform`].
fn placed(
    translate: Option<DVec3Value>,
    rotate_degrees: Option<DVec3Value>,
    scale: Option<f64>,
    matrix: Option<[[f64; 4]; 3]>,
) -> Result<DMat4> {
    let Some([x, y, z]) = matrix.map(|rows| rows.map(DVec4::from_array)) else {
        return transform(translate, rotate_degrees, scale);
    };
    if translate.is_some() || rotate_degrees.is_some() || scale.is_some() {
        let value = "beside translate, rotate_degrees or scale";
        return Err(Error::invalid("matrix", value, "the matrix alone, or none"));
    }
    let matrix = DMat4::from_cols(x, y, z, DVec4::W).transpose();
    check_transform(&matrix)?;
    Ok(matrix)
}

/// Scale first, then the rotations about x, y and z, then the translation.
pub(super) fn transform(
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_long_strings_do_not_count() {
        let long = "x".repeat(1000);
        let [basic, literal] = [format!("a = \"{long}\""), format!("a = '{long}'")];
        let lines = format!("p = \"\"\"\n1 \"2\" \\\"\"\" {long}\n\"\"\"\nb = 1");
        for (text, count) in [
            ("a = 1", 5),
            ("a = \"12345\" # \"x\"\n", 18),
            (&basic, 4 + 64),
            (&literal, 4 + 64),
            (&format!("a = \"\\\"{long}\"\nb = 1"), 4 + 64 + 6),
            (&format!("# '{long}"), 1003),
            (&lines, 4 + 64 + 6),
            (&format!("a = \"{long}\nb = \"2\""), 4 + 64 + 8),
        ] {
            assert_eq!(bytes_that_count(text), count, "{text}");
        }
    }
}
