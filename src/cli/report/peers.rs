//! Section 6: the same view drawn by other means: libGLU's NURBS tessellator, and a static mesh as the lower
//! bound of the cost.

pub(super) mod f3d;
mod glu;
pub(super) mod occt;
pub(super) mod process;

use std::collections::HashMap;

use crate::io::{Error, Result};
use freeform_surface::inspect::DrawnVertex;
use freeform_surface::inspect::measure::Timing;
use freeform_surface::inspect::programs::TrimFeatures;
use freeform_surface::inspect::{StaticMesh, StaticStyle, StaticVertex};
use freeform_surface::{DebugLog, Frame, Method, Scene, Shading, Tessellation, Tolerance};
use glam::{DMat4, Vec3};

use super::Section;
use super::bench::{Bench, Moving};
use super::plot::{Line, plot};
use super::row::Row;
use glu::{Glu, Patches};

/// Size of the view in pixels.
const SIZE: (u32, u32) = (1920, 1080);
pub(super) const SCENE: &str = "teapot";
pub(super) const LIBGLU: &str = "libGLU";
pub(super) const STATIC: &str = "static mesh";

pub(super) fn section(bench: &mut Bench) -> Result<Section> {
    let mut section = Section::new(
        "peers",
        "Peers: the same view by others",
        "The teapot at 1920×1080 with a moving camera, all with the same fragment stage. libGLU's \
         NURBS tessellator makes triangles for each frame, by parametric error, with borders as \
         trimming curves of degree one; its time includes their upload. The static mesh is made of \
         the exact method's own triangles, once: the floor, which knows nothing of a new view.",
    );
    let size = bench.size;
    bench.resize(SIZE)?;
    let measured = measure(bench, &mut section);
    bench.resize(size)?;
    measured?;
    Ok(section)
}

fn measure(bench: &mut Bench, section: &mut Section) -> Result<()> {
    let mut scene = bench.scene("scenes/gallery/teapot.toml")?;
    scene.settings.method = Method::Exact;
    scene.settings.samples = Default::default();
    let tolerances: &[f64] = if bench.quick { &[0.5] } else { &[4.0, 2.0, 1.0, 0.5, 0.25] };
    let mut peer = match Glu::load().and_then(|glu| Ok((glu, Patches::of(&scene)?))) {
        Ok(peer) => Some(peer),
        Err(reason) => {
            let note = Some(format!("not measured: {reason}"));
            section.rows.push(Row { note, ..Row::new("peers", SCENE, LIBGLU) });
            None
        }
    };
    bench.begin(tolerances.len());
    for tolerance in tolerances {
        bench.step(format!("peers: {tolerance} px"));
        scene.settings.tessellation = Tessellation::Within(Tolerance::new(*tolerance)?);
        section.rows.extend(rows(bench, &scene, *tolerance, peer.as_mut())?);
    }
    let line = |name: &str| {
        let of = section.rows.iter().filter(|row| row.method == name);
        let points = of.filter_map(|row| row.ms.zip(row.max_error_px)).collect();
        Line { name: name.into(), points }
    };
    let lines: Vec<Line> = ["exact", STATIC, LIBGLU]
        .map(line)
        .into_iter()
        .filter(|line| !line.points.is_empty())
        .collect();
    let title = "teapot at 1920×1080: largest error over time; the line across is 0.5 px";
    let svg = plot("milliseconds a frame", "largest error, pixels", &lines, Some(0.5))?;
    section.plots.push((title.into(), svg));
    section.findings.extend(findings(&section.rows));
    Ok(())
}

/// All methods and peers that stay within one tolerance, measured alternately.
fn rows(
    bench: &mut Bench,
    scene: &Scene,
    tolerance: f64,
    mut peer: Option<&mut (Glu, Patches)>,
) -> Result<Vec<Row>> {
    let frame = bench.frame(scene);
    let corners = bench.triangles(scene)?;
    let (vertices, indices) = indexed(&corners, frame.camera.view);
    let gl = bench.gl();
    let still = StaticMesh::new(&gl, &vertices, &indices)?;
    let mut streamed = StaticMesh::new(&gl, &vertices, &indices)?;
    let texture = scene.surfaces[0].paint.upload(&gl)?;
    let style = StaticStyle {
        method: Method::Exact,
        shading: Shading::Phong,
        trims: TrimFeatures::NONE,
        texture: &texture,
    };
    let mut prepared = bench.prepare(scene)?;
    let mut cameras = vec![Moving::new(frame); 2 + usize::from(peer.is_some())];
    let background = scene.settings.background;
    let size = bench.size;
    let timings = bench.time_frames(cameras.len(), |renderer, way| {
        let frame = &cameras[way].next();
        if way == 0 {
            return Ok(prepared.draw(renderer, frame).map(drop)?);
        }
        renderer.clear(background);
        match peer.as_deref_mut().filter(|_| way == 2) {
            None => Ok(renderer.draw_static(&still, &style, frame)?),
            Some(peer) => {
                fill(&mut streamed, peer, &gl, frame, size, tolerance)?;
                Ok(renderer.draw_static(&streamed, &style, frame)?)
            }
        }
    })?;
    let row = |name: &str, timing: Timing| Row {
        tolerance: Some(tolerance),
        patches: Some(prepared.stats().patches),
        command: bench.report_command("peers"),
        ..Row::new("peers", SCENE, name).timed(timing)
    };
    let mut rows = vec![row("exact", timings[0]), row(STATIC, timings[1])];
    rows.extend(timings.get(2).map(|timing| row(LIBGLU, *timing)));
    let (errors, stats) = bench.errors(scene)?;
    rows[0] = rows[0].clone().measured(&errors, stats.triangles);
    let errors = bench.static_errors(&still, &style, scene)?;
    rows[1] = rows[1].clone().measured(&errors, still.triangles() as u64);
    if let Some(peer) = peer {
        fill(&mut streamed, peer, &gl, &frame, size, tolerance)?;
        let errors = bench.static_errors(&streamed, &style, scene)?;
        rows[2] = rows[2].clone().measured(&errors, streamed.triangles() as u64);
    }
    Ok(rows)
}

/// libGLU's triangles for a frame.
fn fill(
    mesh: &mut StaticMesh,
    (glu, patches): &mut (Glu, Patches),
    gl: &glow::Context,
    frame: &Frame,
    size: (u32, u32),
    tolerance: f64,
) -> Result<()> {
    // The library draws nothing, but it enables and disables state that only old contexts have.
    let made =
        DebugLog::unheard(gl, move || glu.tessellate(patches, &frame.camera, size, tolerance));
    let made =
        made.map_err(|reason| Error::Driver { what: "libGLU's triangles".into(), reason })?;
    Ok(mesh.replace(&made.vertices, &made.indices)?)
}

/// The triangles that a frame draws, indexed so that each vertex of a patch occurs once.
pub(super) fn indexed(corners: &[DrawnVertex], view: DMat4) -> (Vec<StaticVertex>, Vec<u32>) {
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

/// How the frame of the exact method compares with the others at half a pixel.
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
