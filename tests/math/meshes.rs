//! One step of smoothing: the topology, the positions of the new points, and independence from the order in
//! which a mesh is written.

use std::collections::{HashMap, HashSet};

use crate::shapes::{faces, grid, icosahedron, sphere, torus};
use freeform_surface::inspect::{CurvedTriangle, HalfedgeMesh, PhongTriangle, PnTriangle};
use freeform_surface::{Alpha, Corner, CreaseAngle, Mesh, Smoothing, smooth};
use glam::{DVec3, dvec3};

fn methods() -> [Smoothing; 3] {
    [Smoothing::Pn, Smoothing::Phong(Alpha::default()), Smoothing::None]
}

fn phong(alpha: f64) -> Smoothing {
    Smoothing::Phong(Alpha::new(alpha).unwrap())
}

/// The number of border edges and the Euler characteristic. Every directed edge must occur once.
fn topology(mesh: &Mesh) -> (usize, i64) {
    let mut directed = HashSet::new();
    let mut vertices = HashSet::new();
    for [a, b, c] in faces(mesh) {
        vertices.extend([a, b, c]);
        for edge in [(a, b), (b, c), (c, a)] {
            assert!(directed.insert(edge), "{edge:?} is there twice");
        }
    }
    let borders = directed.iter().filter(|(a, b)| !directed.contains(&(*b, *a))).count();
    let edges = (directed.len() + borders) / 2;
    (borders, vertices.len() as i64 - edges as i64 + mesh.triangles().len() as i64)
}

/// The point on a curved PN triangle by the paper's formula, term by term.
fn pn_point(p: [DVec3; 3], n: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    let near = |i: usize, j: usize| (2.0 * p[i] + p[j] - (p[j] - p[i]).dot(n[i]) * n[i]) / 3.0;
    let [b012, b021] = [near(0, 1), near(1, 0)];
    let [b120, b210] = [near(1, 2), near(2, 1)];
    let [b201, b102] = [near(2, 0), near(0, 2)];
    let e = (b012 + b021 + b120 + b210 + b201 + b102) / 6.0;
    let b111 = e + (e - (p[0] + p[1] + p[2]) / 3.0) / 2.0;
    u.powi(3) * p[0]
        + v.powi(3) * p[1]
        + w.powi(3) * p[2]
        + 3.0 * (u * u * v * b012 + u * v * v * b021)
        + 3.0 * (v * v * w * b120 + v * w * w * b210)
        + 3.0 * (w * w * u * b201 + w * u * u * b102)
        + 6.0 * u * v * w * b111
}

fn pn_normal(p: [DVec3; 3], n: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    let middle = |i: usize, j: usize| {
        let edge = p[j] - p[i];
        let factor = 2.0 * edge.dot(n[i] + n[j]) / edge.dot(edge);
        (n[i] + n[j] - factor * edge).normalize()
    };
    let squares = u * u * n[0] + v * v * n[1] + w * w * n[2];
    (squares + u * v * middle(0, 1) + v * w * middle(1, 2) + w * u * middle(2, 0)).normalize()
}

/// The point of Phong tessellation by the paper's formula: the projections into the corners' tangent planes,
/// averaged.
fn phong_point(p: [DVec3; 3], n: [DVec3; 3], weights: [f64; 3], alpha: f64) -> DVec3 {
    let mean = |points: [DVec3; 3]| (0..3).map(|i| weights[i] * points[i]).sum::<DVec3>();
    let flat = mean(p);
    let projected = [0, 1, 2].map(|i| flat - (flat - p[i]).dot(n[i]) * n[i]);
    (1.0 - alpha) * flat + alpha * mean(projected)
}

fn phong_normal(n: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    (u * n[0] + v * n[1] + w * n[2]).normalize()
}

/// A torus with altered normals, so that nothing is symmetric.
fn uneven() -> Mesh {
    let torus = torus(5);
    let wobble = |x: f64| (7.0 * x).sin() / 3.0;
    let bent = |p: &DVec3| *p + dvec3(wobble(p.y), wobble(p.z), wobble(p.x));
    let positions = torus.positions().iter().map(bent).collect();
    let normals = torus.normals().iter().map(bent).collect();
    crate::shapes::mesh(positions, normals, &faces(&torus))
}

#[test]
fn an_icosahedron_becomes_180_triangles_of_one_closed_surface() {
    let (positions, triangles) = icosahedron();
    let mesh = crate::shapes::mesh(positions.clone(), positions, &triangles);
    assert_eq!(topology(&mesh), (0, 2));
    for smoothing in methods() {
        let smoothed = smooth(mesh.clone(), smoothing, 1).unwrap();
        assert_eq!(smoothed.triangles().len(), 20 * 9);
        assert_eq!(smoothed.positions().len(), 12 + 2 * 30 + 20);
        assert_eq!(smoothed.normals().len(), smoothed.positions().len());
        assert_eq!(topology(&smoothed), (0, 2));
        // Outward as before.
        for [a, b, c] in faces(&smoothed).map_to(smoothed.positions()) {
            assert!((b - a).cross(c - a).dot(a + b + c) > 0.0);
        }
        let twice = smooth(mesh.clone(), smoothing, 2).unwrap();
        assert_eq!((twice.triangles().len(), topology(&twice)), (20 * 81, (0, 2)));
    }
    assert_eq!(topology(&smooth(torus(4), Smoothing::Pn, 2).unwrap()), (0, 0));
}

/// Positions of the corners of faces.
trait MapTo {
    fn map_to(self, positions: &[DVec3]) -> Vec<[DVec3; 3]>;
}

impl MapTo for Vec<[u32; 3]> {
    fn map_to(self, positions: &[DVec3]) -> Vec<[DVec3; 3]> {
        self.iter().map(|face| face.map(|i| positions[i as usize])).collect()
    }
}

#[test]
fn every_new_point_is_that_of_the_papers() {
    // The places in the old triangle of the corners of the nine new ones.
    let places: Vec<[f64; 3]> = grid(3).collect();
    for mesh in [sphere(0), sphere(1), torus(6), uneven()] {
        for smoothing in [Smoothing::Pn, phong(0.75), phong(0.3), Smoothing::None] {
            let smoothed = smooth(mesh.clone(), smoothing, 1).unwrap();
            for (t, corners) in mesh.triangles().iter().enumerate() {
                let p = corners.map(|corner| mesh.positions()[corner.position as usize]);
                let n = corners.map(|corner| mesh.normals()[corner.normal as usize]);
                let expected = |weights| match smoothing {
                    Smoothing::Pn => (pn_point(p, n, weights), pn_normal(p, n, weights)),
                    Smoothing::Phong(alpha) => {
                        (phong_point(p, n, weights, alpha.get()), phong_normal(n, weights))
                    }
                    Smoothing::None => (phong_point(p, n, weights, 0.0), phong_normal(n, weights)),
                };
                let parts = &smoothed.triangles()[9 * t..9 * t + 9];
                let mut found = HashSet::new();
                for corner in parts.iter().flatten() {
                    let at = smoothed.positions()[corner.position as usize];
                    let normal = smoothed.normals()[corner.normal as usize];
                    let place = places.iter().position(|weights| {
                        let (point, direction) = expected(*weights);
                        at.distance(point) < 1e-12 && normal.distance(direction) < 1e-12
                    });
                    found.insert(place.expect("a point of the closed form"));
                }
                assert_eq!(found.len(), 10, "all places of triangle {t}");
                // The new triangles fill the old one: each has a ninth of its area in the domain.
                let area = |[a, b, c]: [[f64; 3]; 3]| {
                    (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])
                };
                for part in parts {
                    let at = part.map(|corner| {
                        let at = smoothed.positions()[corner.position as usize];
                        let is_here = |w: &&[f64; 3]| at.distance(expected(**w).0) < 1e-12;
                        *places.iter().find(is_here).expect("found before")
                    });
                    assert!((area(at) - 1.0 / 9.0).abs() < 1e-12, "triangle {t}: {at:?}");
                }
            }
        }
    }
}

#[test]
fn twins_of_the_triangles_agree_with_the_papers_everywhere() {
    let mesh = HalfedgeMesh::new(uneven());
    for number in 0..mesh.halfedges() / 3 {
        let triangle = mesh.triangle(number);
        let (p, n) = (triangle.positions, triangle.normals);
        let pn = PnTriangle::new(&triangle);
        let phong = PhongTriangle::new(&triangle, Alpha::default());
        for weights in grid(7) {
            let [u, v, w] = weights;
            assert!(pn.position(u, v, w).distance(pn_point(p, n, weights)) < 1e-13);
            assert!(pn.normal(u, v, w).distance(pn_normal(p, n, weights)) < 1e-13);
            assert!(phong.position(u, v, w).distance(phong_point(p, n, weights, 0.75)) < 1e-13);
            assert!(phong.normal(u, v, w).distance(phong_normal(n, weights)) < 1e-13);
        }
        // The surface in Bernstein form over its control points.
        let [a, b, c, ab, ba, bc, cb, ca, ac, middle] = pn.control_points();
        let (u, v, w) = (0.2, 0.3, 0.5);
        let sides = ab * (u * u * v)
            + ba * (v * v * u)
            + bc * (v * v * w)
            + cb * (w * w * v)
            + ca * (w * w * u)
            + ac * (u * u * w);
        let cubic = a * (u * u * u)
            + b * (v * v * v)
            + c * (w * w * w)
            + sides * 3.0
            + middle * (6.0 * u * v * w);
        assert!(cubic.distance(pn.position(u, v, w)) < 1e-13);
        let [a, b, c, ab, bc, ca] = phong.control_points();
        let quadratic = a * (u * u)
            + b * (v * v)
            + c * (w * w)
            + (ab * (u * v) + bc * (v * w) + ca * (w * u)) * 2.0;
        assert!(quadratic.distance(phong.position(u, v, w)) < 1e-13);
        let [a, b, c, ab, bc, ca] = pn.normal_coefficients();
        let normal =
            a * (u * u) + b * (v * v) + c * (w * w) + ab * (u * v) + bc * (v * w) + ca * (w * u);
        assert!(normal.normalize().distance(pn.normal(u, v, w)) < 1e-13);
    }
}

#[test]
fn neighbours_have_the_same_points_to_the_last_bit() {
    let mesh = HalfedgeMesh::new(uneven());
    for halfedge in 0..mesh.halfedges() {
        let twin = mesh.twin(halfedge).expect("it is closed");
        let at = |halfedge: u32, t: f64| {
            let mut weights = [0.0; 3];
            let k = halfedge as usize % 3;
            weights[k] = 1.0 - t;
            weights[(k + 1) % 3] = t;
            let [u, v, w] = weights;
            let triangle = mesh.triangle(mesh.face(halfedge));
            let pn = PnTriangle::new(&triangle);
            let phong = PhongTriangle::new(&triangle, Alpha::default());
            [pn.position(u, v, w), pn.normal(u, v, w), phong.position(u, v, w)]
        };
        for step in 0..=16 {
            // Exact in binary, so that 1 − t is exactly t of the other side.
            let t = f64::from(step) / 16.0;
            assert_eq!(at(halfedge, t), at(twin, 1.0 - t));
        }
    }
}

/// The positions and normals after a step. The keys are the positions of the old triangle and the places in it,
/// so that the order of the triangles does not matter.
fn by_place(mesh: &Mesh, smoothing: Smoothing) -> HashMap<Vec<(u32, u32)>, [DVec3; 2]> {
    let smoothed = smooth(mesh.clone(), smoothing, 1).unwrap();
    let mut places = HashMap::new();
    for (t, corners) in mesh.triangles().iter().enumerate() {
        let old = corners.map(|corner| corner.position);
        let weights = [[3, 0, 0], [2, 1, 0], [2, 0, 1], [2, 1, 0], [1, 1, 1], [2, 0, 1]];
        for k in 0..3 {
            let parts = smoothed.triangles()[9 * t + 3 * k..][..2].iter().flatten();
            for (corner, weights) in parts.zip(weights) {
                let mut place: Vec<(u32, u32)> = (0..3)
                    .map(|i| (old[(k + i) % 3], weights[i]))
                    .filter(|(_, weight)| *weight > 0)
                    .collect();
                place.sort_unstable();
                let here = [
                    smoothed.positions()[corner.position as usize],
                    smoothed.normals()[corner.normal as usize],
                ];
                if let Some(before) = places.insert(place, here) {
                    assert_eq!(before, here);
                }
            }
        }
    }
    // The old points, two new ones for each of the 3/2 edges per triangle, and one for each triangle.
    assert_eq!(places.len(), mesh.positions().len() + 4 * mesh.triangles().len());
    places
}

#[test]
fn the_order_of_faces_and_of_their_corners_changes_no_bit() {
    for given in [true, false] {
        let rebuilt = |faces: &[[u32; 3]]| {
            let mesh = uneven();
            if given {
                return crate::shapes::mesh(
                    mesh.positions().to_vec(),
                    mesh.normals().to_vec(),
                    faces,
                );
            }
            let corner = |i| Corner { position: i, normal: Corner::NONE, coordinate: Corner::NONE };
            let triangles = faces.iter().map(|face| face.map(corner)).collect();
            let positions = mesh.positions().to_vec();
            Mesh::new(positions, vec![], vec![], triangles, CreaseAngle::NONE).unwrap()
        };
        let old = faces(&uneven());
        // 7 is coprime to the number of faces.
        let mixed: Vec<[u32; 3]> = (0..old.len())
            .map(|i| {
                let mut face = old[7 * i % old.len()];
                face.rotate_left(i % 3);
                face
            })
            .collect();
        for smoothing in methods() {
            assert_eq!(by_place(&rebuilt(&old), smoothing), by_place(&rebuilt(&mixed), smoothing));
        }
    }
}

#[test]
fn half_edges_know_their_neighbours() {
    // Two triangles, and a third one that touches them in a single vertex.
    let positions =
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, dvec3(1.0, 1.0, 0.0), -DVec3::X, -DVec3::Y];
    let normals = vec![DVec3::Z; 6];
    let mesh = crate::shapes::mesh(positions, normals, &[[0, 1, 2], [3, 2, 1], [0, 4, 5]]);
    let mesh = HalfedgeMesh::new(mesh);
    assert_eq!((mesh.halfedges(), mesh.edges()), (9, 8));
    assert_eq!((mesh.twin(1), mesh.twin(4), mesh.twin(0)), (Some(4), Some(1), None));
    assert_eq!([0, 1, 2].map(|h| mesh.next(h)), [1, 2, 0]);
    assert_eq!([3, 4, 8].map(|h| (mesh.vertex(h), mesh.face(h))), [(3, 1), (2, 1), (5, 2)]);
    assert_eq!(mesh.edge(4), mesh.edge(1));
    assert_eq!(mesh.halfedge(mesh.edge(4)), 1);
    assert_eq!(topology(&mesh.tessellate(Smoothing::Pn).unwrap()).0, 7 * 3);
}

#[test]
fn neighbours_after_a_step_are_those_that_are_found_anew() {
    for mesh in [uneven(), sphere(1)] {
        let stepped = HalfedgeMesh::new(mesh).step(Smoothing::Pn).unwrap();
        assert_eq!(HalfedgeMesh::new(stepped.mesh().clone()), stepped);
    }
    let open = crate::shapes::mesh(
        vec![DVec3::ZERO, DVec3::X, DVec3::Y, dvec3(1.0, 1.0, 0.3)],
        vec![DVec3::Z; 4],
        &[[0, 1, 2], [3, 2, 1]],
    );
    let stepped = HalfedgeMesh::new(open).step(Smoothing::Pn).unwrap();
    assert_eq!(HalfedgeMesh::new(stepped.mesh().clone()), stepped);
}

#[test]
fn edges_that_no_surface_has_are_borders_and_counted() {
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::Y];
    let normals = vec![DVec3::Z; 5];
    for (faces, edges, crowded, same_way, words) in [
        (&[[0, 1, 2], [1, 0, 3]][..], 5, 0, 0, ""),
        (&[[0, 1, 2], [1, 0, 3], [0, 1, 4]], 7, 1, 0, "1 edge of more than two triangles"),
        (
            &[[0, 1, 2], [0, 1, 3]],
            5,
            0,
            1,
            "1 edge that both triangles run through in the same direction",
        ),
    ] {
        let mesh =
            HalfedgeMesh::new(crate::shapes::mesh(positions.clone(), normals.clone(), faces));
        let shared = mesh.shared_borders();
        assert_eq!((shared.crowded, shared.same_way), (crowded, same_way));
        assert_eq!(mesh.edges(), edges);
        assert_eq!(mesh.twin(0).is_some(), crowded + same_way == 0);
        if !words.is_empty() {
            assert_eq!(shared.to_string(), words);
        }
    }
}

#[test]
fn too_many_triangles_are_refused_before_they_are_made() {
    let text = smooth(sphere(0), Smoothing::Pn, 7).unwrap_err().to_string();
    assert!(text.contains("20 · 9^7") && text.contains("50000000"), "{text}");
    assert!(smooth(sphere(0), Smoothing::Pn, u32::MAX).is_err());
    assert_eq!(smooth(sphere(0), Smoothing::Pn, 0).unwrap(), sphere(0));
}
