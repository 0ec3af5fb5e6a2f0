//! A scene as the text of a `.toml` file that draws the same picture.
//!
//! Numbers are written with enough digits to read the same number back. Patches, meshes and pictures that a file of
//! the scene still contains are referred to by the name of that file; others need files beside the text.

use std::fmt::Write as _;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat4, DVec2, DVec3, DVec4};
use image::ImageFormat;

use super::document::{MAX_PATCH_POINTS, check_surface, transform};
use super::file::{extension, read_text};
use super::{
    Analysis, CadModel, Cull, Direction, Draft, EdgeColor, Edges, Image, Isolines, MeshModel,
    Method, Normals, Paint, RenderSettings, Scene, Shading, Stripes, Surface, Tessellation, bpt,
    default_control_points, load_texture, obj, svg,
};
use crate::bezier::Degree;
use crate::camera::{Camera, CameraPath, Lens};
use crate::error::{Error, Result};
use crate::mesh::{CreaseAngle, Mesh, Smoothing};
use crate::trim::{FillRule, Keep, Segment, TrimLoop, TrimPath, Trims};

/// If the loops have more segments than this together, they are written as a path, whose length a scene does not
/// limit.
const MANY_SEGMENTS: usize = 200;

/// The text of a scene file, and the files that it needs beside it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneText {
    /// The file's text.
    pub text: String,
    /// Other files that it names, and their bytes.
    pub files: Vec<(PathBuf, Vec<u8>)>,
}

impl Scene {
    /// The text of a `.toml` file at `path` that draws the same picture. Trims that are switched off are left out.
    /// Files beside it get its name and a number.
    ///
    /// # Errors
    /// A picture that cannot be encoded; more trims than the text of a surface can hold; more colours of single faces
    /// of a CAD model than the text of a model can hold (about 4,000); a NURBS surface of more control points than fit
    /// in a file (about 150,000).
    pub fn to_toml(&self, path: &Path) -> Result<SceneText> {
        let mut writer = Writer {
            path,
            sources: &self.files,
            pictures: Vec::new(),
            documents: None,
            out: SceneText { text: String::new(), files: Vec::new() },
        };
        if let Some(camera) = self.camera {
            writer.camera(&camera);
        }
        for key in self.camera_path.iter().flat_map(CameraPath::keys) {
            writer.header("[[camera_key]]");
            writer.line("time", format_args!("{:?}", key.time));
            writer.place([key.eye, key.target, key.up]);
        }
        writer.settings(&self.settings);
        writer.line("up", if self.up == DVec3::Z { "\"z\"" } else { "\"y\"" });
        for surface in self.surfaces.iter().filter(|surface| surface.face.is_none()) {
            writer.surface(surface)?;
        }
        for mesh in &self.meshes {
            writer.mesh(mesh)?;
        }
        for (number, model) in self.models.iter().enumerate() {
            let of_model =
                |surface: &&Surface| surface.face.is_some_and(|face| face.model == number);
            writer.model(model, self.surfaces.iter().filter(of_model))?;
        }
        Ok(writer.out)
    }
}

/// An analysis as a table.
fn table_of(analysis: &Analysis) -> String {
    let mut table = format!("{{ kind = \"{}\"", analysis.kind().name());
    let direction = |own: Direction| format!(", direction = {}", vector(own.get()));
    match analysis {
        Analysis::Zebra(Stripes { count, direction: own })
        | Analysis::Isophotes(Stripes { count, direction: own }) => {
            table += &format!(", stripes = {}", count.get());
            table += &own.map_or_else(String::new, direction);
        }
        Analysis::Curvature { of, limit } => {
            table += &format!(", curvature = \"{}\"", of.name());
            table += &limit.map_or_else(String::new, |own| format!(", limit = {:?}", own.get()));
        }
        Analysis::Draft(Draft { pull, limit }) => {
            table += &direction(*pull);
            table += &format!(", limit_degrees = {:?}", limit.degrees());
        }
    }
    table + " }"
}

struct Writer<'a> {
    path: &'a Path,
    /// Files of the scene.
    sources: &'a [PathBuf],
    /// Pictures that have a name already.
    pictures: Vec<(Arc<Image>, String)>,
    /// The SVG files among the sources, with their paths; `None` until they are needed.
    documents: Option<Vec<(PathBuf, Vec<TrimPath>)>>,
    out: SceneText,
}

impl Writer<'_> {
    fn line(&mut self, key: &str, value: impl std::fmt::Display) {
        // Writing to a string cannot fail.
        let _ = writeln!(self.out.text, "{key} = {value}");
    }

    fn header(&mut self, header: &str) {
        let gap = if self.out.text.is_empty() { "" } else { "\n" };
        let _ = writeln!(self.out.text, "{gap}{header}");
    }

    fn place(&mut self, [eye, target, up]: [DVec3; 3]) {
        self.line("eye", vector(eye));
        self.line("target", vector(target));
        self.line("up", vector(up));
    }

    fn camera(&mut self, camera: &Camera) {
        self.header("[camera]");
        self.place([camera.eye(), camera.target(), camera.up()]);
        match camera.lens() {
            Lens::Perspective { fov_y_radians } => {
                self.line("fov_y_degrees", format_args!("{:?}", degrees(fov_y_radians)));
            }
            Lens::Orthographic { height } => {
                self.line("orthographic_height", format_args!("{height:?}"));
            }
        }
    }

    fn settings(&mut self, settings: &RenderSettings) {
        let RenderSettings {
            background,
            method,
            samples,
            tessellation,
            normals,
            light,
            wireframe,
            red_lines,
            control_points,
            edges,
            isolines,
            analysis,
            newton,
        } = settings;
        self.header("[render]");
        self.line("background", format_args!("{background:?}"));
        let method = match method {
            Method::Thesis => "thesis",
            Method::Exact => "exact",
        };
        self.line("method", format_args!("\"{method}\""));
        self.line("light", format_args!("\"{}\"", light.name()));
        self.line("samples", samples.get());
        match tessellation {
            Tessellation::Level(level) => self.line("level", level.get()),
            Tessellation::Within(tolerance) => {
                self.line("tolerance", format_args!("{:?}", tolerance.pixels()));
            }
        }
        let normals = match normals {
            Normals::Vertex => "vertex",
            Normals::Pixel => "pixel",
        };
        self.line("normals", format_args!("\"{normals}\""));
        self.line("wireframe", wireframe);
        self.line("red_lines", red_lines);
        self.line("control_points", control_points);
        if let Some(Edges { width, color, smooth }) = edges {
            let color = match color {
                EdgeColor::Rgb(rgb) => format!("{rgb:?}"),
                EdgeColor::Continuity => "\"continuity\"".into(),
            };
            let width = width.pixels();
            let table = format_args!("{{ width = {width:?}, color = {color}, smooth = {smooth} }}");
            self.line("edges", table);
        }
        if let Some(Isolines { count, width, color }) = isolines {
            let (count, width) = (count.get(), width.pixels());
            let table = format_args!("{{ count = {count}, width = {width:?}, color = {color:?} }}");
            self.line("isolines", table);
        }
        if let Some(analysis) = analysis {
            self.line("shading", table_of(analysis));
        }
        let (iterations, epsilon) = (newton.iterations(), newton.epsilon());
        self.line("newton", format_args!("{{ iterations = {iterations}, epsilon = {epsilon:?} }}"));
    }

    fn surface(&mut self, surface: &Surface) -> Result<()> {
        let start = self.out.text.len();
        self.surface_with(surface, false)?;
        let checked = check_surface(&self.out.text[start..]);
        let is_large = surface.nurbs().is_some() && surface.patch_points().len() > MAX_PATCH_POINTS;
        if is_large || (checked.is_err() && surface.nurbs().is_some()) {
            self.out.text.truncate(start);
            self.surface_with(surface, true)?;
            return check_surface(&self.out.text[start..]);
        }
        checked
    }

    /// Writes a surface, with a NURBS surface in the text or in a file.
    fn surface_with(&mut self, surface: &Surface, nurbs_in_file: bool) -> Result<()> {
        self.header("[[surface]]");
        let points = surface.control_points();
        let is_default = points == default_control_points() && surface.degree() == Degree::CUBIC;
        if is_default && surface.nurbs().is_none() {
            self.line("control_points", "\"default\"");
        } else if let Some(nurbs) = surface.nurbs().filter(|_| !nurbs_in_file) {
            let [u, v] = nurbs.knots();
            self.line("knots", format_args!("[{}, {}]", numbers(u), numbers(v)));
            self.net(surface, true);
        } else if surface.nurbs().is_none() && points.len() == surface.degree().points() {
            let is_plain = Degree::from_point_count(points.len()).ok() == Some(surface.degree());
            self.net(surface, !is_plain);
        } else {
            let file = self.surface_file(surface)?;
            self.line("file", file);
        }
        self.style(&surface.paint, surface.shading, &surface.transform)?;
        if surface.cull == Cull::Back {
            self.line("cull", "\"back\"");
        }
        if surface.hidden {
            self.line("hidden", true);
        }
        if !surface.join {
            self.line("join", false);
        }
        self.trims(&surface.trims);
        Ok(())
    }

    /// Writes control points in the text, and their degree if it is needed.
    fn net(&mut self, surface: &Surface, with_degree: bool) {
        if with_degree {
            let degree = surface.degree();
            self.line("degree", format_args!("[{}, {}]", degree.u(), degree.v()));
        }
        let points = surface.control_points().iter();
        let rows: String =
            points.map(|point| format!("    {},\n", control_point(*point))).collect();
        self.line("control_points", format_args!("[\n{rows}]"));
    }

    /// The name of a file with a surface: a `.bpt` file for patches without weights, otherwise an `.obj` file.
    fn surface_file(&mut self, surface: &Surface) -> Result<String> {
        let points = surface.control_points();
        for source in self.sources {
            let read = match extension(source).as_str() {
                "bpt" => read_text(source).and_then(|text| bpt::parse(&text, source)),
                "obj" => obj::load_surfaces(source),
                _ => continue,
            };
            let is_same = |read: &Surface| {
                (read.degree(), read.control_points(), read.nurbs(), &read.trims)
                    == (surface.degree(), points, surface.nurbs(), &Trims::default())
            };
            if read.is_ok_and(|read| matches!(&*read, [only] if is_same(only))) {
                return Ok(self.name(source));
            }
        }
        if surface.nurbs().is_some() || points.iter().any(|point| point.w != 1.0) {
            let text = obj::surface_text(surface)?;
            return Ok(self.beside("obj", text.into_bytes()));
        }
        let degree = surface.degree();
        let mut text = format!("{}\n", surface.patches().len());
        for patch in points.chunks_exact(surface.degree().points()) {
            let _ = writeln!(text, "{} {}", degree.u(), degree.v());
            for point in patch {
                let _ = writeln!(text, "{:?} {:?} {:?}", point.x, point.y, point.z);
            }
        }
        Ok(self.beside("bpt", text.into_bytes()))
    }

    fn mesh(&mut self, model: &MeshModel) -> Result<()> {
        self.header("[[mesh]]");
        let mesh = model.mesh().mesh();
        let source = self.sources.iter().find(|source| {
            let reads_same = |source| {
                Mesh::load_obj(source, CreaseAngle::default()).is_ok_and(|read| read == *mesh)
            };
            extension(source) == "obj" && reads_same(source)
        });
        let file = match source {
            Some(source) => self.name(source),
            None => {
                let mut bytes = Vec::new();
                mesh.write_obj(&mut bytes)
                    .map_err(|error| Error::file("write", self.path, error))?;
                self.beside("obj", bytes)
            }
        };
        self.line("file", file);
        match model.smoothing() {
            Smoothing::None => {}
            Smoothing::Pn => self.line("smoothing", "\"pn\""),
            Smoothing::Phong(alpha) => {
                self.line("smoothing", "\"phong\"");
                self.line("alpha", format_args!("{:?}", alpha.get()));
            }
        }
        if let Some(level) = model.level {
            self.line("level", level.get());
        }
        self.style(&model.paint, model.shading, &model.transform)
    }

    /// Writes a CAD model; of its faces, only which are hidden and whose colours are not those of the file.
    fn model<'s>(
        &mut self,
        model: &CadModel,
        faces: impl Iterator<Item = &'s Surface>,
    ) -> Result<()> {
        let start = self.out.text.len();
        self.header("[[model]]");
        let name = self.name(&model.file);
        self.line("file", name);
        if let Some(rgb) = model.color {
            self.line("color", format_args!("{rgb:?}"));
        }
        self.placement(&model.transform);
        let colors = model.colors()?;
        let (mut hidden, mut painted) = (Vec::new(), String::new());
        for surface in faces {
            let Some(face) = surface.face.map(|face| face.instance) else { continue };
            if surface.hidden {
                hidden.push(face);
            }
            if let Paint::Color(rgb) = surface.paint
                && colors.get(face) != Some(&rgb)
            {
                let _ = writeln!(painted, "    {{ face = {face}, color = {rgb:?} }},");
            }
        }
        if !hidden.is_empty() {
            self.line("hide", format_args!("{hidden:?}"));
        }
        if !painted.is_empty() {
            self.line("colors", format_args!("[\n{painted}]"));
        }
        check_surface(&self.out.text[start..])
    }

    fn style(&mut self, paint: &Paint, shading: Shading, matrix: &DMat4) -> Result<()> {
        match paint {
            Paint::Color(rgb) => self.line("color", format_args!("{rgb:?}")),
            Paint::Texture(image) => {
                let name = self.picture(image)?;
                self.line("texture", name);
            }
        }
        match shading {
            Shading::Phong => {}
            Shading::Unlit => self.line("shading", "\"texture\""),
            Shading::Normals => self.line("shading", "\"normals\""),
        }
        self.placement(matrix);
        Ok(())
    }

    fn placement(&mut self, matrix: &DMat4) {
        let bits = |matrix: &DMat4| matrix.to_cols_array().map(f64::to_bits);
        let translate = matrix.w_axis.truncate();
        let moved = transform(Some(translate.into()), None, None);
        if moved.is_ok_and(|moved| bits(&moved) == bits(matrix)) {
            if translate != DVec3::ZERO {
                self.line("translate", vector(translate));
            }
        } else {
            let rows = [0, 1, 2].map(|row| numbers(&matrix.row(row).to_array()));
            self.line("matrix", format_args!("[{}]", rows.join(", ")));
        }
    }

    /// The name of a file with this picture.
    fn picture(&mut self, image: &Arc<Image>) -> Result<String> {
        if let Some((_, name)) = self.pictures.iter().find(|(known, _)| Arc::ptr_eq(known, image)) {
            return Ok(name.clone());
        }
        let is_picture = |source: &PathBuf| {
            !matches!(extension(source).as_str(), "toml" | "bpt" | "obj" | "svg")
                && load_texture(source).is_ok_and(|read| read == **image)
        };
        let name = match self.sources.iter().find(|source| is_picture(source)) {
            Some(source) => self.name(source),
            None => {
                let mut bytes = Cursor::new(Vec::new());
                image
                    .write_to(&mut bytes, ImageFormat::Png)
                    .map_err(|error| Error::file("write", self.path, error))?;
                self.beside("png", bytes.into_inner())
            }
        };
        self.pictures.push((Arc::clone(image), name.clone()));
        Ok(name)
    }

    /// Adds a file beside the text, and returns its name as a TOML string.
    fn beside(&mut self, extension: &str, bytes: Vec<u8>) -> String {
        let stem = self.path.file_stem().unwrap_or_default().to_string_lossy();
        let name = format!("{stem}-{}.{extension}", self.out.files.len() + 1);
        self.out.files.push((self.path.with_file_name(&name), bytes));
        quoted(&name)
    }

    /// The name of a file as a TOML string: relative to the text's folder, or absolute.
    fn name(&self, file: &Path) -> String {
        let folder = self.path.parent().unwrap_or_else(|| Path::new(""));
        let name = match file.strip_prefix(folder) {
            Ok(name) => name.to_owned(),
            Err(_) => std::path::absolute(file).unwrap_or_else(|_| file.to_owned()),
        };
        quoted(&name.to_string_lossy())
    }

    fn trims(&mut self, trims: &Trims) {
        let on = |on: bool| if on { usize::MAX } else { 0 };
        let loops = &trims.loops[..trims.loops.len().min(on(trims.loops_on))];
        if trims.keep == Keep::Inside && trims.loops_on && trims.has_loops() {
            self.line("keep", "\"inside\"");
        }
        for circle in trims.circles.iter().take(on(trims.circles_on)) {
            let (center, radius) = (pair(circle.center), circle.radius);
            self.trim("circle", format_args!("{{ center = {center}, radius = {radius:?} }}"));
        }
        for interval in trims.rects.iter().take(on(trims.rects_on)) {
            let (u, v) = (pair(interval.u), pair(interval.v));
            self.trim("interval", format_args!("{{ u = {u}, v = {v} }}"));
        }
        for ellipse in trims.ellipses.iter().take(on(trims.ellipses_on)) {
            let (center, radii) = (pair(ellipse.center), pair(ellipse.radii));
            self.trim("ellipse", format_args!("{{ center = {center}, radii = {radii} }}"));
        }
        if loops.iter().map(|one| one.segments().len()).sum::<usize>() > MANY_SEGMENTS {
            self.trim("path", path_text(loops));
        } else {
            for trim_loop in loops {
                let segments = trim_loop.segments().iter().map(|segment| {
                    let points: Vec<String> = segment.points().iter().copied().map(pair).collect();
                    format!("    [{}],\n", points.join(", "))
                });
                self.trim("loop", format_args!("[\n{}]", segments.collect::<String>()));
            }
        }
        self.paths(&trims.paths[..trims.paths.len().min(on(trims.loops_on))]);
    }

    /// Writes paths. Consecutive paths that an SVG file of the scene contains are written as the name of this file,
    /// all others one by one.
    fn paths(&mut self, mut paths: &[TrimPath]) {
        if paths.is_empty() {
            return;
        }
        let sources = self.sources;
        let documents = self.documents.take().unwrap_or_else(|| {
            let documents = sources.iter().filter(|source| extension(source) == "svg");
            documents.filter_map(|file| Some((file.clone(), svg::load(file).ok()?.0))).collect()
        });
        while let Some((first, rest)) = paths.split_first() {
            let document = documents.iter().find(|(_, filled)| paths.starts_with(filled));
            if let Some((file, filled)) = document {
                let name = self.name(file);
                self.trim("svg", name);
                paths = &paths[filled.len()..];
                continue;
            }
            paths = rest;
            if first.loops.is_empty() {
                continue;
            }
            self.trim("path", path_text(&first.loops));
            let rule = match first.rule {
                FillRule::EvenOdd => "evenodd",
                FillRule::NonZero => "nonzero",
            };
            self.line("fill_rule", format_args!("\"{rule}\""));
        }
        self.documents = Some(documents);
    }

    fn trim(&mut self, key: &str, value: impl std::fmt::Display) {
        self.header("[[surface.trim]]");
        self.line(key, value);
    }
}

/// Loops as a string of SVG path data.
fn path_text(loops: &[TrimLoop]) -> String {
    let lines: Vec<String> = loops.iter().map(path_data).collect();
    format!("\"\"\"\n{}\n\"\"\"", lines.join("\n"))
}

/// A loop as SVG path data; it ends where it began.
fn path_data(trim_loop: &TrimLoop) -> String {
    let mut data = String::new();
    let start = trim_loop.segments()[0].start();
    let _ = write!(data, "M{:?} {:?}", start.x, start.y);
    for segment in trim_loop.segments() {
        data.push(match segment {
            Segment::Line(_) => 'L',
            Segment::Quadratic(_) => 'Q',
            Segment::Cubic(_) => 'C',
        });
        for (i, point) in segment.points()[1..].iter().enumerate() {
            let gap = if i == 0 { "" } else { " " };
            let _ = write!(data, "{gap}{:?} {:?}", point.x, point.y);
        }
    }
    data
}

fn numbers(values: &[f64]) -> String {
    format!("{values:?}")
}

fn control_point(point: DVec4) -> String {
    if point.w == 1.0 { vector(point.truncate()) } else { numbers(&point.to_array()) }
}

fn vector(vector: DVec3) -> String {
    numbers(&vector.to_array())
}

fn pair(pair: DVec2) -> String {
    numbers(&pair.to_array())
}

/// The degrees that become exactly these radians when they are read, if there is such a number; otherwise the
/// nearest.
fn degrees(radians: f64) -> f64 {
    let near = radians.to_degrees();
    let others = [near, near.next_up(), near.next_down()];
    let further = [near.next_up().next_up(), near.next_down().next_down()];
    let mut all = others.into_iter().chain(further);
    all.find(|degrees| degrees.to_radians() == radians).unwrap_or(near)
}

/// A TOML string.
fn quoted(text: &str) -> String {
    let mut quoted = String::from('"');
    for char in text.chars() {
        match char {
            '"' | '\\' => quoted.extend(['\\', char]),
            char if char.is_control() => {
                let _ = write!(quoted, "\\U{:08X}", u32::from(char));
            }
            char => quoted.push(char),
        }
    }
    quoted.push('"');
    quoted
}
