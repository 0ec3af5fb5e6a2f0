//! Section 6: the same view by others: libGLU's NURBS tessellator, and a static mesh as the floor.

mod glu;

use std::collections::HashMap;

use freeform_surface::measure::Timing;
use freeform_surface::renderer::programs::TrimFeatures;
use freeform_surface::renderer::{StaticLook, StaticMesh, StaticVertex};
use freeform_surface::{
    DrawnVertex, Error, Frame, Method, Result, Scene, Shading, Tessellation, Tolerance,
};
use glam::{DMat4, Vec3};

use super::Section;
use super::lab::{Lab, move_on};
use super::plot::{Line, plot};
use super::row::Row;
use glu::{Glu, Patches};

/// Pixels of the view.
const SIZE: (u32, u32) = (1920, 1080);
pub(super) const SCENE: &str = "teapot";
pub(super) const LIBGLU: &str = "libGLU";
pub(super) const STATIC: &str = "static mesh";

/// Triangles as vertices and indices.
type Indexed = (Vec<StaticVertex>, Vec<u32>);

pub(super) fn section(lab: &mut Lab) -> Result<Section> {
    let mut section = Section::new(
        "peers",
        "Peers: the same view by others",
        "The teapot at 1920×1080 with a moving camera, all with the same fragment stage. libGLU's \
         NURBS tessellator makes triangles for each frame, by parametric error, with borders as \
         trimming curves of degree one; its time includes their upload. The static mesh is made of \
         the exact method's own triangles, once: the floor, which knows nothing of a new view.",
    );
    let size = lab.size;
    lab.resize(SIZE)?;
    let measured = measure(lab, &mut section);
    lab.resize(size)?;
    measured?;
    Ok(section)
}

fn measure(lab: &mut Lab, section: &mut Section) -> Result<()> {
    let scene = lab.scene("scenes/gallery/teapot.toml")?;
    let tolerances: &[f64] = if lab.quick { &[0.5] } else { &[4.0, 2.0, 1.0, 0.5, 0.25] };
    let mut glu = match Glu::load() {
        Ok(glu) => Some(glu),
        Err(reason) => {
            section.findings.push(format!("libGLU was not measured: {reason}."));
            None
        }
    };
    let names = ["exact", STATIC, LIBGLU];
    let mut lines = names.map(|name| Line { name: name.into(), points: Vec::new() });
    lab.begin(tolerances.len());
    for tolerance in tolerances {
        lab.step(format!("peers: {tolerance} px"));
        let rows = rows(lab, &scene, *tolerance, glu.as_mut())?;
        for (row, line) in rows.iter().zip(&mut lines) {
            line.points.extend(row.ms.zip(row.max_error_px));
        }
        section.rows.extend(rows);
    }
    let lines: Vec<Line> = lines.into_iter().filter(|line| !line.points.is_empty()).collect();
    let title = "teapot at 1920×1080: largest error over time; the line across is 0.5 px";
    let svg = plot("milliseconds a frame", "largest error, pixels", &lines, Some(0.5))?;
    section.plots.push((title.into(), svg));
    section.findings.extend(findings(&section.rows));
    Ok(())
}

/// All who draw within one tolerance, in turns.
fn rows(
    lab: &mut Lab,
    scene: &Scene,
    tolerance: f64,
    mut glu: Option<&mut Glu>,
) -> Result<Vec<Row>> {
    let mut scene = scene.clone();
    scene.settings.method = Method::Exact;
    scene.settings.tessellation = Tessellation::Within(Tolerance::new(tolerance)?);
    scene.settings.samples = Default::default();
    let frame = lab.frame(&scene);
    let corners = lab.triangles(&scene)?;
    let mesh = indexed(&corners, frame.projection.view);
    let gl = lab.gl();
    let still = StaticMesh::new(&gl, &mesh.0, &mesh.1)?;
    let mut streamed = StaticMesh::new(&gl, &mesh.0, &mesh.1)?;
    let patches = Patches::of(&scene);
    let texture = scene.surfaces[0].paint.upload(&gl)?;
    let look = StaticLook {
        method: Method::Exact,
        shading: Shading::Phong,
        trims: TrimFeatures::NONE,
        texture: &texture,
    };
    let mut prepared = lab.prepare(&scene)?;
    let mut frames = [frame; 3];
    let background = scene.settings.background;
    let ways = if glu.is_some() { 3 } else { 2 };
    let size = lab.size;
    let timings = lab.time_frames(ways, |renderer, way| {
        let frame = &mut frames[way];
        move_on(frame);
        match (way, glu.as_deref_mut()) {
            (0, _) => return prepared.draw(renderer, frame).map(drop),
            (1, _) | (_, None) => {
                renderer.clear(background);
                renderer.draw_static(&still, &look, frame)
            }
            (_, Some(glu)) => {
                fill(&mut streamed, glu, &patches, frame, size, tolerance)?;
                renderer.clear(background);
                renderer.draw_static(&streamed, &look, frame)
            }
        }
    })?;
    let row = |name: &str, timing: Timing| Row {
        tolerance: Some(tolerance),
        patches: Some(corners.iter().map(|corner| corner.patch + 1).max().unwrap_or(0) as usize),
        command: "freeform report --only peers".into(),
        ..Row::new("peers", SCENE, name).timed(timing)
    };
    let (errors, triangles) = lab.errors(&scene)?;
    let mut rows = vec![row("exact", timings[0]).measured(&errors, triangles)];
    let errors = lab.static_errors(&still, &look, &scene)?;
    rows.push(row(STATIC, timings[1]).measured(&errors, still.triangles() as u64));
    if let Some(glu) = glu {
        fill(&mut streamed, glu, &patches, &frame, size, tolerance)?;
        let errors = lab.static_errors(&streamed, &look, &scene)?;
        rows.push(row(LIBGLU, timings[2]).measured(&errors, streamed.triangles() as u64));
    }
    Ok(rows)
}

/// libGLU's triangles for a frame.
fn fill(
    mesh: &mut StaticMesh,
    glu: &mut Glu,
    patches: &Patches,
    frame: &Frame,
    size: (u32, u32),
    tolerance: f64,
) -> Result<()> {
    let made = glu
        .tessellate(patches, &frame.projection, size, tolerance)
        .map_err(|reason| Error::Driver { what: "libGLU's triangles".into(), reason })?;
    mesh.replace(&made.vertices, &made.indices)
}

/// The triangles that a frame draws, each corner of a patch once.
fn indexed(corners: &[DrawnVertex], view: DMat4) -> Indexed {
    let to_world = view.inverse();
    let mut numbers = HashMap::new();
    let (mut vertices, mut indices) = (Vec::new(), Vec::with_capacity(corners.len()));
    for corner in corners {
        let key = (corner.patch, corner.uv.map(f32::to_bits));
        indices.push(*numbers.entry(key).or_insert_with(|| {
            let [x, y, z, _] = corner.position.map(f64::from);
            let normal = Vec3::from(corner.normal).as_dvec3();
            vertices.push(StaticVertex {
                position: to_world.transform_point3([x, y, z].into()).as_vec3().into(),
                u: corner.uv[0],
                normal: to_world.transform_vector3(normal).as_vec3().into(),
                v: corner.uv[1],
                patch: corner.patch,
            });
            vertices.len() as u32 - 1
        }));
    }
    (vertices, indices)
}

/// How the exact frame stands to the others at half a pixel.
fn findings(rows: &[Row]) -> Vec<String> {
    let at_half = |name: &str| {
        let mut of = rows.iter().filter(|row| row.method == name && row.tolerance == Some(0.5));
        of.find_map(|row| Some((row.ms?, row.max_error_px?, row.triangles?)))
    };
    let Some((ms, error, triangles)) = at_half("exact") else { return Vec::new() };
    let other = |name: &str| {
        let (its, its_error, its_triangles) = at_half(name)?;
        let ratio = ms / its;
        let wins = if ratio <= 1.0 { "ahead of" } else { "behind" };
        Some(format!(
            "Teapot at half a pixel, 1920×1080: exact is {wins} {name}, {ratio:.2} of its time \
             ({ms:.1} ms against {its:.1}); largest error {error:.2} px with {triangles} triangles \
             against {its_error:.2} px with {its_triangles}."
        ))
    };
    [LIBGLU, STATIC].into_iter().filter_map(other).collect()
}
