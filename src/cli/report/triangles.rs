//! Section 3: smoothed meshes against the sphere and the torus that they approximate.

use crate::io::Result;
use freeform_surface::inspect::DrawnVertex;
use freeform_surface::inspect::measure::in_turns;
use freeform_surface::{
    Alpha, CreaseAngle, Mesh, MeshModel, Scene, Smoothing, TessLevel, Tessellation, smooth,
};
use glam::{DMat4, DVec3};

use super::Section;
use super::bench::Bench;
use super::plot::{Line, plot};
use super::row::Row;

/// The distance of a point from an ideal surface.
type Distance = fn(DVec3) -> f64;

const SHAPES: [(&str, &str, Distance); 2] = [
    ("sphere", "meshes/icosahedron.obj", |point| (point.length() - 1.0).abs()),
    // A ring of radius 1, 0.4 thick, about y, as `examples/make_meshes.rs` makes it.
    ("torus", "meshes/torus.obj", |point| {
        let ring = (point.x.hypot(point.z) - 1.0).hypot(point.y);
        (ring - 0.4).abs()
    }),
];

pub(super) fn section(bench: &mut Bench) -> Result<Section> {
    let mut section = Section::new(
        "triangles",
        "Triangles: smoothed meshes against the ideal shape",
        "The largest distance of triangles, at their corners and centroids, from the sphere or torus \
         whose points and normals the coarse mesh has, in the model's units. The coarse mesh decides \
         how near its smooth surface is; more triangles come nearer to that surface. GPU times are \
         frames, software times all steps.",
    );
    let ways = [
        ("plain", Smoothing::None),
        ("pn", Smoothing::Pn),
        ("phong", Smoothing::Phong(Alpha::default())),
    ];
    let levels: &[i64] = if bench.quick { &[1, 3, 8] } else { &[1, 2, 3, 4, 8, 16, 32] };
    bench.begin(SHAPES.len());
    for (shape, path, distance) in SHAPES {
        bench.step(format!("triangles: {shape}"));
        let file = bench.path(path);
        let mesh = Mesh::load_obj(&file, CreaseAngle::NONE)?;
        let (mut over_time, mut over_triangles) = (Vec::new(), Vec::new());
        for (way, smoothing) in ways {
            let mut scenes = Vec::new();
            // Without smoothing, a mesh is the same at every level.
            let levels = if smoothing == Smoothing::None { &levels[..1] } else { levels };
            for level in levels {
                scenes.push(scene(&mesh, smoothing, *level)?);
            }
            let timings = bench.time(&scenes)?;
            let (mut times, mut counts) = (Vec::new(), Vec::new());
            for ((scene, level), timing) in scenes.iter().zip(levels).zip(timings) {
                let triangles = bench.triangles(scene)?;
                let projection = scene.projection(bench.size.0, bench.size.1);
                let error = largest(&corners(&triangles, projection.view), distance);
                times.push((timing.ms, error));
                counts.push((triangles.len() as f64 / 3.0, error));
                let row = Row {
                    level: Some(*level as u32),
                    triangles: Some(triangles.len() as u64 / 3),
                    max_error: Some(error),
                    command: bench.report_command("triangles"),
                    ..Row::new("triangles", shape, format!("{way}, GPU"))
                };
                section.rows.push(row.timed(timing));
            }
            over_time.push(Line { name: way.into(), points: times });
            over_triangles.push(Line { name: format!("{way}, GPU"), points: counts });
            let mut counts = Vec::new();
            for steps in 1..=(if smoothing == Smoothing::None { 0 } else { 3 }) {
                let mut step = || smooth(mesh.clone(), smoothing, steps).map(drop);
                let timing = in_turns(bench.turns, &mut [&mut step])?[0];
                let smoothed = smooth(mesh.clone(), smoothing, steps)?;
                let corners: Vec<DVec3> = smoothed
                    .triangles()
                    .iter()
                    .flatten()
                    .map(|corner| smoothed.positions()[corner.position as usize])
                    .collect();
                let error = largest(&corners, distance);
                counts.push((smoothed.triangles().len() as f64, error));
                let row = Row {
                    triangles: Some(smoothed.triangles().len() as u64),
                    max_error: Some(error),
                    command: format!(
                        "freeform smooth {} --method {way} --steps {steps} -o OUT.obj",
                        file.display()
                    ),
                    ..Row::new("triangles", shape, format!("{way}, software, {steps} steps"))
                };
                section.rows.push(row.timed(timing));
            }
            if !counts.is_empty() {
                over_triangles.push(Line { name: format!("{way}, software"), points: counts });
            }
        }
        let svg = plot("milliseconds a frame", "largest distance", &over_time, None)?;
        section.plots.push((format!("{shape}: distance from the ideal shape over time"), svg));
        let svg = plot("triangles", "largest distance", &over_triangles, None)?;
        section.plots.push((format!("{shape}: distance from the ideal shape over triangles"), svg));
        section.findings.extend(finding(&section.rows, shape));
    }
    Ok(section)
}

fn scene(mesh: &Mesh, smoothing: Smoothing, level: i64) -> Result<Scene> {
    let mut scene = Scene { surfaces: Vec::new(), ..Scene::listing16() };
    scene.meshes.push(MeshModel::new(mesh.clone(), smoothing));
    scene.settings.tessellation = Tessellation::Level(TessLevel::new(level)?);
    Ok(scene)
}

/// The corners of drawn triangles in world space.
fn corners(triangles: &[DrawnVertex], view: DMat4) -> Vec<DVec3> {
    let to_world = view.inverse();
    let corner = |vertex: &DrawnVertex| {
        let [x, y, z, _] = vertex.position.map(f64::from);
        to_world.transform_point3(DVec3::new(x, y, z))
    };
    triangles.iter().map(corner).collect()
}

/// The largest distance at corners and centroids.
fn largest(corners: &[DVec3], distance: Distance) -> f64 {
    let centroids = corners.chunks_exact(3).map(|triangle| triangle.iter().sum::<DVec3>() / 3.0);
    corners.iter().copied().chain(centroids).map(distance).fold(0.0, f64::max)
}

/// How much closer the smooth surfaces are than the plain mesh, each at its finest level. A coarser level may
/// come out closer only because of where its corners lie.
fn finding(rows: &[Row], shape: &str) -> Option<String> {
    let finest = |way: &str| {
        let rows =
            rows.iter().filter(|row| row.scene == shape && row.method == format!("{way}, GPU"));
        rows.max_by_key(|row| row.level)?.max_error
    };
    let (plain, pn, phong) = (finest("plain")?, finest("pn")?, finest("phong")?);
    Some(format!(
        "{shape}: curved PN triangles come {:.1} times as near as the plain mesh, Phong tessellation \
         {:.1} times.",
        plain / pn,
        plain / phong
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_that_was_moved_is_as_far_off() {
        let sphere = SHAPES[0].2;
        let corners = [DVec3::X, DVec3::Y, DVec3::Z].map(|corner| corner + 0.25 * corner);
        assert!((largest(&corners[..1], sphere) - 0.25).abs() < 1e-15);
        let torus = SHAPES[1].2;
        assert!(
            torus(DVec3::new(1.4, 0.0, 0.0)) < 1e-15 && torus(DVec3::new(0.0, 0.4, -1.0)) < 1e-15
        );
        assert!((torus(DVec3::new(1.0, 0.0, 0.0)) - 0.4).abs() < 1e-15);
        // For a flat triangle with its corners on the sphere, the centroid is further off than the corners.
        let flat = [DVec3::X, DVec3::Y, DVec3::Z];
        assert!((largest(&flat, sphere) - (1.0 - 1.0 / 3.0_f64.sqrt())).abs() < 1e-12);
    }
}
