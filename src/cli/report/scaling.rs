//! Section 4: how cost grows with patches, trim segments and mesh triangles.

use std::f64::consts::TAU;
use std::time::Instant;

use crate::io::Result;
use freeform_surface::inspect::HalfedgeMesh;
use freeform_surface::inspect::measure::{Timing, in_turns_by};
use freeform_surface::{
    Corner, CreaseAngle, Degree, Mesh, Scene, Segment, Smoothing, Surface, TrimLoop,
};
use glam::{DVec3, DVec4, dvec2, dvec3};

use super::Section;
use super::bench::Bench;
use super::peers::process::peak;
use super::plot::{Line, plot};
use super::row::Row;

pub(super) fn section(bench: &mut Bench) -> Result<Section> {
    let mut section = Section::new(
        "scaling",
        "Scaling: time and memory against size",
        "Ten times the work should take ten times the time at most. Patches fill the same picture, so \
         that small scenes cost what its pixels cost. Memory is what the process grows by at most \
         meanwhile, beyond what it holds from before.",
    );
    let patches: &[usize] =
        if bench.quick { &[1, 100, 1_000] } else { &[1, 10, 100, 1_000, 10_000] };
    let segments: &[usize] =
        if bench.quick { &[4, 400, 40_000] } else { &[4, 40, 400, 4_000, 40_000, 100_000] };
    let triangles: &[usize] =
        if bench.quick { &[1_000, 10_000] } else { &[1_000, 10_000, 100_000, 1_000_000] };
    bench.begin(patches.len() + segments.len() + triangles.len());
    let mut lines = Vec::new();
    for (name, sizes, measure) in [
        ("patches", patches, of_patches as fn(&mut Bench, usize) -> Result<(Timing, Row)>),
        ("trim segments", segments, of_segments),
        ("mesh triangles, one PN step", triangles, of_triangles),
    ] {
        let mut points = Vec::new();
        for size in sizes {
            bench.step(format!("scaling: {size} {name}"));
            let before = memory_from_here();
            let (timing, row) = measure(bench, *size)?;
            let grown = before.and_then(|before| Some(most_memory()?.saturating_sub(before)));
            points.push((*size as f64, timing.ms));
            let command = bench.report_command("scaling");
            section.rows.push(Row { memory: grown, command, ..row }.timed(timing));
        }
        if let [.., a, b] = points[..] {
            section.findings.push(format!(
                "{name}: from {:.0} to {:.0} the time grows as the size to the power of {:.2}.",
                a.0,
                b.0,
                slope(a, b)
            ));
        }
        lines.push(Line { name: name.into(), points });
    }
    let svg = plot("size", "milliseconds", &lines, None)?;
    section
        .plots
        .push(("Time over size: patches and trim segments a frame, triangles a step".into(), svg));
    Ok(section)
}

/// The exponent with which time grows with size between two points.
fn slope(a: (f64, f64), b: (f64, f64)) -> f64 {
    (b.1 / a.1).ln() / (b.0 / a.0).ln()
}

/// Resets the process' memory peak and returns the new peak: the bytes that the process holds now. Only Linux
/// reports it.
fn memory_from_here() -> Option<u64> {
    std::fs::write("/proc/self/clear_refs", "5").ok()?;
    most_memory()
}

/// The process' memory peak in bytes since the last reset.
fn most_memory() -> Option<u64> {
    peak("/proc/self/status")
}

/// A field of bumps as wide as the picture.
fn of_patches(bench: &mut Bench, count: usize) -> Result<(Timing, Row)> {
    let mut scene = Scene::listing16();
    let single = scene.surfaces.remove(0);
    let side = (count as f64).sqrt().ceil() as usize;
    let points = (0..count).flat_map(|patch| {
        let (x, z) = ((patch % side) as f64, (patch / side) as f64);
        single.control_points().iter().map(move |p| *p + DVec4::new(x, 0.0, -z, 0.0))
    });
    let mut surface = Surface::new(Degree::CUBIC, points.collect())?;
    surface.paint = single.paint;
    scene.surfaces.push(surface);
    let timing = bench.time(std::slice::from_ref(&scene))?[0];
    Ok((timing, Row { patches: Some(count), ..Row::new("scaling", "patches", "exact") }))
}

/// A hole with a wavy border of `count` straight segments.
fn of_segments(bench: &mut Bench, count: usize) -> Result<(Timing, Row)> {
    let mut scene = Scene::listing16();
    let at = |i: usize| {
        let angle = TAU * (i % count) as f64 / count as f64;
        let radius = 0.3 + 0.05 * (12.0 * angle).sin();
        dvec2(0.5 + radius * angle.cos(), 0.5 + radius * angle.sin())
    };
    let segments =
        (0..count).map(|i| Segment::new(&[at(i), at(i + 1)])).collect::<Result<_, _>>()?;
    let trims = &mut scene.surfaces[0].trims;
    trims.circles.clear();
    trims.add_loop(TrimLoop::new(segments)?)?;
    let timing = bench.time(std::slice::from_ref(&scene))?[0];
    Ok((timing, Row { segments: Some(count), ..Row::new("scaling", "trim segments", "exact") }))
}

/// Finds the neighbours of a torus of about `count` triangles and smooths it by one step.
fn of_triangles(bench: &mut Bench, count: usize) -> Result<(Timing, Row)> {
    let mesh = torus((count / 2).isqrt())?;
    let triangles = mesh.triangles().len();
    let timing = in_turns_by(bench.turns, 1, |_| {
        let mesh = mesh.clone();
        let start = Instant::now();
        let stepped = HalfedgeMesh::new(mesh).tessellate(Smoothing::Pn)?;
        let time = start.elapsed();
        drop(stepped);
        Result::<_>::Ok(time)
    })?[0];
    let row = Row::new("scaling", "mesh triangles", "pn");
    Ok((timing, Row { triangles: Some(triangles as u64), ..row }))
}

/// A torus of `side` × `side` quads.
fn torus(side: usize) -> Result<Mesh> {
    let point = |i: usize| {
        let (a, b) = (TAU * (i % side) as f64 / side as f64, TAU * (i / side) as f64 / side as f64);
        let radius = 1.0 + 0.4 * b.cos();
        dvec3(radius * a.cos(), radius * a.sin(), 0.4 * b.sin())
    };
    let positions: Vec<DVec3> = (0..side * side).map(point).collect();
    let corner = |column: usize, row: usize| Corner {
        position: (row % side * side + column % side) as u32,
        normal: Corner::NONE,
        coordinate: Corner::NONE,
    };
    let triangles = (0..side * side).flat_map(|i| {
        let (x, y) = (i % side, i / side);
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        [[a, b, c], [a, c, d]]
    });
    Ok(Mesh::new(positions, Vec::new(), Vec::new(), triangles.collect(), CreaseAngle::NONE)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_counted_at_its_most() {
        let Some(before) = memory_from_here() else { return };
        // Every page of the block is written, then the block is freed.
        drop(std::hint::black_box(vec![1_u8; 256 << 20]));
        let grown = most_memory().unwrap() - before;
        // Other tests run at the same time, and what they free and allocate counts too.
        assert!((150 << 20..360 << 20).contains(&grown), "{grown}");
    }

    #[test]
    fn slopes_are_powers() {
        assert!((slope((10.0, 2.0), (1000.0, 200.0)) - 1.0).abs() < 1e-12);
        assert!((slope((10.0, 2.0), (100.0, 200.0)) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_torus_is_closed() {
        let mesh = HalfedgeMesh::new(torus(10).unwrap());
        assert!((0..mesh.halfedges()).all(|halfedge| mesh.twin(halfedge).is_some()));
        assert_eq!(mesh.mesh().triangles().len(), 200);
    }
}
