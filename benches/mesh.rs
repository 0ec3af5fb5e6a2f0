//! What a step of smoothing costs in software, for meshes of a thousand to a million triangles.
//!
//! `cargo bench --bench mesh` prints medians, ratios and the bars they should stay under; names after
//! `--` choose sections: steps, memory.

#[path = "../tests/shapes/mod.rs"]
mod shapes;
mod turns;

use std::hint::black_box;

use freeform_surface::{
    CurvedTriangle, HalfedgeMesh, Mesh, PnTriangle, SmoothTriangle, Smoothing, smooth,
};
use glam::DVec3;
use shapes::torus;
use turns::{in_turns, line};

/// Of tori, whose triangles are four times the square of it.
const SIDES: [u32; 4] = [16, 50, 158, 500];

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let sections: [(&str, fn()); 2] = [("steps", steps), ("memory", memory)];
    for (name, section) in sections {
        if asked.is_empty() || asked.iter().any(|asked| asked == name) {
            section();
        }
    }
}

/// What a step evaluates, evaluated and written by one pass over the triangles that thinks of
/// nothing else: each takes the points of the edges that are marked, and its middle.
fn points_alone(mesh: &Mesh, marks: &[[bool; 3]]) -> (Vec<DVec3>, Vec<DVec3>) {
    const THIRD: f64 = 1.0 / 3.0;
    const TWO: f64 = 2.0 / 3.0;
    const EDGES: [[[f64; 3]; 2]; 3] = [
        [[TWO, THIRD, 0.0], [THIRD, TWO, 0.0]],
        [[0.0, TWO, THIRD], [0.0, THIRD, TWO]],
        [[THIRD, 0.0, TWO], [TWO, 0.0, THIRD]],
    ];
    let mut points = Vec::with_capacity(9 * mesh.positions().len());
    let mut directions = Vec::with_capacity(9 * mesh.positions().len());
    points.extend_from_slice(mesh.positions());
    directions.extend_from_slice(mesh.normals());
    for (corners, marks) in mesh.triangles().iter().zip(marks) {
        let normals = corners.map(|corner| mesh.normals()[corner.normal as usize]);
        let [a, b, c] = normals;
        let surface = PnTriangle::new(&SmoothTriangle {
            positions: corners.map(|corner| mesh.positions()[corner.position as usize]),
            normals,
            edge_normals: [[a, b], [b, c], [c, a]],
        });
        let mut evaluate = |[u, v, w]: [f64; 3]| {
            points.push(surface.position(u, v, w));
            directions.push(surface.normal(u, v, w));
        };
        for (edge, _) in EDGES.into_iter().zip(marks).filter(|(_, mark)| **mark) {
            edge.into_iter().for_each(&mut evaluate);
        }
        evaluate([THIRD; 3]);
    }
    (points, directions)
}

/// A step, with and without finding the neighbours, beside evaluation alone.
fn steps() {
    let mut nanoseconds = Vec::new();
    for side in SIDES {
        let mesh = torus(side);
        let triangles = mesh.triangles().len();
        let neighbours = HalfedgeMesh::new(mesh.clone()).expect("a torus");
        let is_first = |halfedge| neighbours.halfedge(neighbours.edge(halfedge)) == halfedge;
        let marks: Vec<[bool; 3]> =
            (0..triangles as u32).map(|t| [0, 1, 2].map(|k| is_first(3 * t + k))).collect();
        let ms = in_turns(&mut [
            &mut || drop(black_box(HalfedgeMesh::new(mesh.clone()))),
            &mut || drop(black_box(neighbours.tessellate(Smoothing::Pn))),
            &mut || drop(black_box(neighbours.step(Smoothing::Pn))),
            &mut || drop(black_box(points_alone(&mesh, &marks))),
            &mut || drop(black_box(mesh.clone())),
        ]);
        let [find, step, further, points, copy] = ms[..] else {
            unreachable!("five were asked for")
        };
        let each = |ms: f64| ms * 1e6 / triangles as f64;
        let whole = find - copy + step;
        line(&format!("{triangles} triangles: neighbours, ns a triangle"), each(find - copy), "");
        line(&format!("{triangles} triangles: the step, ns a triangle"), each(step), "");
        line(&format!("{triangles} triangles: both / points alone"), whole / points, "≤ 2");
        line(
            &format!("{triangles} triangles: a further step / points alone"),
            further / points,
            "≤ 2",
        );
        nanoseconds.push(each(whole));
    }
    let most = nanoseconds.iter().copied().fold(0.0, f64::max);
    let ratio = most / nanoseconds[0];
    line("dearest time a triangle / that of the smallest mesh", ratio, "linear: about 1");
}

/// What the process holds at most while it smooths a million triangles, beside the result.
fn memory() {
    let figure = |name: &str| {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let line =
            status.lines().find_map(|line| line.strip_prefix(name)?.split_whitespace().next());
        line.and_then(|kilobytes| kilobytes.parse::<f64>().ok()).unwrap_or(f64::NAN) * 1024.0
    };
    for steps in [1, 2] {
        let mesh = torus(if steps == 1 { 500 } else { 158 });
        let before = figure("VmRSS:");
        // Linux: the peak counts from here.
        std::fs::write("/proc/self/clear_refs", "5").expect("a process may clear its own peak");
        let smoothed = smooth(mesh, Smoothing::Pn, steps).expect("a torus");
        let output = size_of_val(smoothed.positions())
            + size_of_val(smoothed.normals())
            + size_of_val(smoothed.coordinates())
            + size_of_val(smoothed.triangles());
        let ratio = (figure("VmHWM:") - before) / output as f64;
        line(&format!("{steps} steps: growth at most / bytes of the result"), ratio, "≤ 3");
    }
}
