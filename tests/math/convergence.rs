//! The distances of smoothed meshes from the surfaces on which their corners lie and whose normals they have.
#![allow(dead_code, unreachable_pub, reason = "a test and an example, each takes its part")]

use std::fmt::Write as _;

use freeform_surface::inspect::{CurvedTriangle, HalfedgeMesh, PhongTriangle, PnTriangle};
use freeform_surface::{Alpha, Mesh, Smoothing, smooth};
use glam::DVec3;

use crate::shapes::{grid, off_sphere, off_torus, sphere, torus};

/// Each flat triangle is measured at a grid with this number of subdivisions per edge.
const SAMPLES: u32 = 6;
pub const LEVELS: [u32; 6] = [1, 2, 4, 8, 16, 32];
pub const STEPS: [u32; 3] = [1, 2, 3];
pub const HALVINGS: usize = 4;

/// A surface, its meshes from coarse to fine (each with edges half as long), and the distance from the surface.
pub struct Shape {
    pub name: &'static str,
    pub meshes: [Mesh; HALVINGS],
    pub distance: fn(DVec3) -> f64,
}

pub fn shapes() -> [Shape; 2] {
    [
        Shape { name: "sphere", meshes: [0, 1, 2, 3].map(sphere), distance: off_sphere },
        Shape { name: "torus", meshes: [8, 16, 32, 64].map(torus), distance: off_torus },
    ]
}

pub fn methods() -> [(&'static str, Smoothing); 3] {
    let half = Alpha::new(0.5).expect("a factor");
    [
        ("PN", Smoothing::Pn),
        ("Phong, α = ¾", Smoothing::Phong(Alpha::default())),
        ("Phong, α = ½", Smoothing::Phong(half)),
    ]
}

fn point(corners: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    corners[0] * u + corners[1] * v + corners[2] * w
}

/// The largest distance of a mesh's flat triangles from the surface.
pub fn of_mesh(mesh: &Mesh, distance: fn(DVec3) -> f64) -> f64 {
    let of_triangle = |positions: [DVec3; 3]| {
        grid(SAMPLES).map(move |weights| distance(point(positions, weights))).fold(0.0, f64::max)
    };
    let corners = |triangle: &[freeform_surface::Corner; 3]| {
        triangle.map(|corner| mesh.positions()[corner.position as usize])
    };
    mesh.triangles().iter().map(|triangle| of_triangle(corners(triangle))).fold(0.0, f64::max)
}

/// The largest distance after `steps` steps.
pub fn after_steps(
    mesh: &Mesh,
    smoothing: Smoothing,
    steps: u32,
    distance: fn(DVec3) -> f64,
) -> f64 {
    of_mesh(&smooth(mesh.clone(), smoothing, steps).expect("a surface"), distance)
}

/// The largest distance of the triangles drawn at a level: flat triangles between the points of a grid.
pub fn at_level(mesh: &Mesh, smoothing: Smoothing, level: u32, distance: fn(DVec3) -> f64) -> f64 {
    largest(mesh, smoothing, |surface| of_curved(surface, level, distance))
}

/// The largest distance of the smooth surface itself, without tessellation.
pub fn of_surface(mesh: &Mesh, smoothing: Smoothing, distance: fn(DVec3) -> f64) -> f64 {
    largest(mesh, smoothing, |surface| {
        grid(24).map(|[u, v, w]| distance(surface.position(u, v, w))).fold(0.0, f64::max)
    })
}

fn largest(mesh: &Mesh, smoothing: Smoothing, of: impl Fn(&dyn CurvedTriangle) -> f64) -> f64 {
    let mesh = HalfedgeMesh::new(mesh.clone());
    (0..mesh.halfedges() / 3)
        .map(|triangle| {
            let triangle = mesh.triangle(triangle);
            match smoothing {
                Smoothing::None => of(&PhongTriangle::new(&triangle, Alpha::NONE)),
                Smoothing::Pn => of(&PnTriangle::new(&triangle)),
                Smoothing::Phong(alpha) => of(&PhongTriangle::new(&triangle, alpha)),
            }
        })
        .fold(0.0, f64::max)
}

fn of_curved(surface: &dyn CurvedTriangle, level: u32, distance: fn(DVec3) -> f64) -> f64 {
    let at = |i: u32, j: u32| {
        let [u, v, w] = [i, j, level - i - j].map(|k| f64::from(k) / f64::from(level));
        surface.position(u, v, w)
    };
    let mut max = 0.0_f64;
    for i in 0..level {
        for j in 0..level - i {
            let mut triangles = vec![[at(i, j), at(i + 1, j), at(i, j + 1)]];
            if i + j + 1 < level {
                triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
            for corners in triangles {
                for weights in grid(SAMPLES) {
                    max = max.max(distance(point(corners, weights)));
                }
            }
        }
    }
    max
}

const HEAD: &str = "\
# Accuracy of smoothed meshes

The meshes are sampled from a known surface. The tables show the largest distance between any point of the smoothed
triangles and that surface. The number in brackets says by which factor this distance is smaller than that of the flat
triangles. `cargo run --release --example mesh_convergence` generates this page, and `tests/math/mesh_convergence.rs`
checks it. The papers do not state rates of convergence. The following rates were derived for an edge of a sphere whose
normals enclose the angle 2θ:

- The flat edge is off by 1 − cos θ ≈ θ²/2. Halving the edges divides the distance by 4.
- Phong tessellation raises the middle of the edge by α·sin²θ·cos θ ≈ αθ², so it is off by |1 − 2α|·θ²/2. At α = ¾ this
  is half of the distance of the flat edge, on the outer side, at any fineness. That α looks best on coarse meshes, whose
  triangles lie deeper than their edges.
- Curved PN triangles raise the middle of the edge by ½·sin²θ·cos θ, as Phong tessellation does at α = ½. The remaining
  distance is 3θ⁴/8. Halving the edges divides it by 16. It is 4/(3θ²) times smaller than that of the flat edge.

In the middle of triangles the distances are larger, at the same rates. The curvature of the torus varies, so less
symmetric terms remain: the last halving divides the distance by 12 instead of 16. A smooth triangle that is drawn at
level n adds 1/n² of the flat triangle's distance. Repeated steps keep the points of earlier steps. They therefore do not
converge to the surface, but to about the distance of the smooth surface over the first mesh.
";

fn row(text: &mut String, name: &str, values: &[f64], flat: &[f64]) {
    write!(text, "| {name} |").expect("text");
    for (value, flat) in values.iter().zip(flat) {
        if value == flat {
            write!(text, " {value:.2e} |").expect("text");
        } else {
            write!(text, " {value:.2e} ({:.1}) |", flat / value).expect("text");
        }
    }
    text.push('\n');
}

fn table(
    text: &mut String,
    title: &str,
    columns: &[String],
    measure: impl Fn(Smoothing) -> Vec<f64>,
) {
    writeln!(text, "\n| {title} | {} |", columns.join(" | ")).expect("text");
    writeln!(text, "|---|{}", "---|".repeat(columns.len())).expect("text");
    let flat = measure(Smoothing::None);
    row(text, "flat", &flat, &flat);
    for (name, smoothing) in methods() {
        row(text, name, &measure(smoothing), &flat);
    }
}

/// The document with all tables.
pub fn document() -> String {
    let mut text = String::from(HEAD);
    for Shape { name, meshes, distance } in &shapes() {
        let [coarse, ..] = meshes;
        write!(text, "\n## {name}\n").expect("text");
        let triangles = coarse.triangles().len();
        let steps = STEPS.map(|steps| format!("{steps}"));
        table(&mut text, &format!("{triangles} triangles, steps"), &steps, |smoothing| {
            STEPS.map(|steps| after_steps(coarse, smoothing, steps, *distance)).to_vec()
        });
        let levels = LEVELS.map(|level| format!("{level}"));
        table(&mut text, &format!("{triangles} triangles, level"), &levels, |smoothing| {
            LEVELS.map(|level| at_level(coarse, smoothing, level, *distance)).to_vec()
        });
        let counts: Vec<String> =
            meshes.iter().map(|mesh| mesh.triangles().len().to_string()).collect();
        table(&mut text, "smooth surface over triangles", &counts, |smoothing| {
            meshes.iter().map(|mesh| of_surface(mesh, smoothing, *distance)).collect()
        });
    }
    text
}
