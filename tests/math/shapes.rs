//! Meshes of surfaces that have an equation, for tests, benches and examples.
#![allow(dead_code, unreachable_pub, reason = "every user is a crate that takes what it needs")]

use std::collections::HashMap;
use std::f64::consts::TAU;

use freeform_surface::{Corner, CreaseAngle, Mesh};
use glam::{DVec3, dvec3};

/// A mesh with one normal for each position.
pub fn mesh(positions: Vec<DVec3>, normals: Vec<DVec3>, faces: &[[u32; 3]]) -> Mesh {
    let corner = |index| Corner { position: index, normal: index, coordinate: Corner::NONE };
    let triangles = faces.iter().map(|face| face.map(corner)).collect();
    Mesh::new(positions, normals, Vec::new(), triangles, CreaseAngle::NONE).expect("a mesh")
}

/// The faces of a mesh, by position.
pub fn faces(mesh: &Mesh) -> Vec<[u32; 3]> {
    mesh.triangles().iter().map(|corners| corners.map(|corner| corner.position)).collect()
}

/// Corners of an icosahedron on the unit sphere, and its faces.
pub fn icosahedron() -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut positions = Vec::new();
    for axis in 0..3 {
        for (one, other) in [(-1.0, -golden), (-1.0, golden), (1.0, -golden), (1.0, golden)] {
            let mut point = [0.0; 3];
            point[axis] = one;
            point[(axis + 1) % 3] = other;
            positions.push(DVec3::from_array(point).normalize());
        }
    }
    let near = |a: usize, b: usize| (positions[a].distance(positions[b]) - 1.0515).abs() < 1e-3;
    let mut faces = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [p, q, r] = [a, b, c].map(|i| positions[i]);
                    let outward = (q - p).cross(r - p).dot(p) > 0.0;
                    let face = if outward { [a, b, c] } else { [a, c, b] };
                    faces.push(face.map(|i| i as u32));
                }
            }
        }
    }
    (positions, faces)
}

/// An icosahedron on the unit sphere whose faces are repeatedly cut into four.
pub fn sphere(halvings: u32) -> Mesh {
    let (mut positions, mut faces) = icosahedron();
    for _ in 0..halvings {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    mesh(positions.clone(), positions, &faces)
}

/// The distance of a point from the unit sphere.
pub fn off_sphere(point: DVec3) -> f64 {
    (point.length() - 1.0).abs()
}

/// The radii of the torus: of its centre circle, and of its tube.
const TORUS: [f64; 2] = [1.0, 0.4];

/// A torus around the y axis of `2·n` by `n` quads, two triangles each.
pub fn torus(n: u32) -> Mesh {
    let [major, minor] = TORUS;
    let (mut positions, mut normals, mut faces) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..2 * n {
        for j in 0..n {
            let (a, b) = (TAU * f64::from(i) / f64::from(2 * n), TAU * f64::from(j) / f64::from(n));
            let normal = dvec3(b.cos() * a.cos(), b.sin(), b.cos() * a.sin());
            normals.push(normal);
            positions.push(dvec3(a.cos(), 0.0, a.sin()) * major + normal * minor);
            let at = |i: u32, j: u32| i % (2 * n) * n + j % n;
            let [p, q, r, s] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            faces.extend([[p, q, r], [p, r, s]]);
        }
    }
    mesh(positions, normals, &faces)
}

/// The distance of a point from the torus.
pub fn off_torus(point: DVec3) -> f64 {
    let [major, minor] = TORUS;
    ((point.x.hypot(point.z) - major).hypot(point.y) - minor).abs()
}

/// The barycentric coordinates of a regular grid with `n` subdivisions per edge.
pub fn grid(n: u32) -> impl Iterator<Item = [f64; 3]> + Clone {
    (0..=n).flat_map(move |i| {
        (0..=n - i).map(move |j| [i, j, n - i - j].map(|k| f64::from(k) / f64::from(n)))
    })
}
