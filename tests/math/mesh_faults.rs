//! The hard cases of smoothing, which must never give NaNs, cracks or spikes. Also tests the other meshes of
//! `resources/meshes`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use freeform_surface::inspect::{CurvedTriangle, HalfedgeMesh, PhongTriangle, PnTriangle};
use freeform_surface::{Alpha, Corner, CreaseAngle, Mesh, Smoothing, smooth};
use glam::DVec3;

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("resources/meshes/{name}.obj"))
}

fn load(name: &str) -> Mesh {
    Mesh::load_obj(&file(name), CreaseAngle::NONE).unwrap_or_else(|error| panic!("{error}"))
}

fn methods() -> [Smoothing; 3] {
    let max = Alpha::new(1.0).unwrap();
    [Smoothing::Pn, Smoothing::Phong(Alpha::default()), Smoothing::Phong(max)]
}

fn corners(mesh: &Mesh, triangle: &[Corner; 3]) -> [DVec3; 3] {
    triangle.map(|corner| mesh.positions()[corner.position as usize])
}

fn longest(p: [DVec3; 3]) -> f64 {
    (0..3).map(|k| p[k].distance(p[(k + 1) % 3])).fold(0.0, f64::max)
}

/// Edges with only one side, keyed by position: a crack is such an edge, whatever the indices.
fn borders(mesh: &Mesh) -> usize {
    let bits = |point: DVec3| (point + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut sides: HashMap<_, i32> = HashMap::new();
    for triangle in mesh.triangles() {
        let p = corners(mesh, triangle).map(bits);
        for k in 0..3 {
            let (a, b) = (p[k], p[(k + 1) % 3]);
            if a != b {
                *sides.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
            }
        }
    }
    sides.values().filter(|sides| **sides != 0).count()
}

/// Smooths a hard case and checks its invariants; `open` is the expected number of border edges.
fn holds(name: &str, open: usize) -> Mesh {
    let mesh = load(&format!("hard/{name}"));
    assert_eq!(borders(&mesh), open, "{name}");
    for smoothing in methods() {
        let mut coarse = mesh.clone();
        for step in 1..=3 {
            let fine = smooth(coarse.clone(), smoothing, 1).unwrap();
            assert!(fine.positions().iter().all(|p| p.is_finite()), "{name}, {smoothing:?}");
            for normal in &fine.normals()[coarse.normals().len()..] {
                assert!((normal.length() - 1.0).abs() < 1e-12, "{name}, {smoothing:?}: {normal}");
            }
            assert_eq!(borders(&fine), open * 3_usize.pow(step), "{name}, {smoothing:?}");
            for (triangle, parts) in coarse.triangles().iter().zip(fine.triangles().chunks(9)) {
                let p = corners(&coarse, triangle);
                for point in parts.iter().flat_map(|part| corners(&fine, part)) {
                    // No point is further from the triangle than its longest edge, measured even from the
                    // centroid.
                    let far = point.distance((p[0] + p[1] + p[2]) / 3.0);
                    assert!(far <= longest(p), "{name}, {smoothing:?}: {point}");
                }
            }
            coarse = fine;
        }
    }
    let neighbours = HalfedgeMesh::new(mesh.clone());
    for number in 0..neighbours.halfedges() / 3 {
        let triangle = neighbours.triangle(number);
        let pn = PnTriangle::new(&triangle);
        let phong = PhongTriangle::new(&triangle, Alpha::default());
        for i in 0..=8_u32 {
            for j in 0..=8 - i {
                let [u, v, w] = [i, j, 8 - i - j].map(|k| f64::from(k) / 8.0);
                for (point, normal) in [
                    (pn.position(u, v, w), pn.normal(u, v, w)),
                    (phong.position(u, v, w), phong.normal(u, v, w)),
                ] {
                    assert!(point.is_finite(), "{name}: {point}");
                    assert!((normal.length() - 1.0).abs() < 1e-12, "{name}: {normal}");
                }
            }
        }
    }
    mesh
}

#[test]
fn a_triangle_of_no_area() {
    let mesh = holds("zero-area", 0);
    let area = |p: [DVec3; 3]| (p[1] - p[0]).cross(p[2] - p[0]).length();
    let min = mesh.triangles().iter().map(|t| area(corners(&mesh, t))).fold(1.0, f64::min);
    assert!(min < 1e-15, "{min}");
}

#[test]
fn a_needle() {
    let mesh = holds("needle", 0);
    let height = |p: [DVec3; 3]| (p[1] - p[0]).cross(p[2] - p[0]).length() / longest(p);
    let min = mesh.triangles().iter().map(|t| height(corners(&mesh, t))).fold(1.0, f64::min);
    assert!((min - 1e-6).abs() < 1e-9, "{min}");
}

#[test]
fn coincident_vertices() {
    let mesh = holds("coincident", 0);
    assert_eq!((mesh.positions().len(), mesh.triangles().len()), (63, 20));
    // The faces share their edges by index.
    assert_eq!(HalfedgeMesh::new(mesh).edges(), 30);
}

#[test]
fn a_zero_normal() {
    let mesh = holds("zero-normal", 0);
    let zero = mesh.normals().iter().position(|normal| *normal == DVec3::ZERO).unwrap() as u32;
    let mesh = HalfedgeMesh::new(mesh);
    let halfedge = (0..mesh.halfedges()).find(|h| mesh.vertex(*h) == zero).unwrap();
    // The control point next to it lies at a third of a straight edge.
    let triangle = mesh.triangle(mesh.face(halfedge));
    let k = halfedge as usize % 3;
    let [from, to] = [triangle.positions[k], triangle.positions[(k + 1) % 3]];
    let near = PnTriangle::new(&triangle).control_points()[3 + 2 * k];
    assert!(near.distance(from + (to - from) / 3.0) < 1e-15);
}

#[test]
fn opposite_normals() {
    let mesh = HalfedgeMesh::new(holds("opposite-normals", 0));
    let straight =
        mesh.edge_normals().iter().flatten().flatten().filter(|n| **n == DVec3::ZERO).count();
    assert!(straight >= 4, "{straight} ends of edges have no normal");
}

#[test]
fn a_normal_at_right_angles_to_its_face() {
    let mesh = holds("right-angle-normal", 0);
    assert!(mesh.normals()[0].dot(mesh.positions()[0]).abs() < 1e-15);
}

#[test]
fn a_boundary() {
    let mesh = load("hard/boundary");
    holds("boundary", borders(&mesh));
    assert!(borders(&mesh) > 0);
}

#[test]
fn a_crease() {
    let mesh = HalfedgeMesh::new(holds("crease", 0));
    // Both sides of every edge have the same two normals, although the normals of their corners differ.
    let normals = mesh.edge_normals();
    let mut creases = 0;
    for halfedge in 0..mesh.halfedges() {
        let at = |h: u32| normals[mesh.face(h) as usize][h as usize % 3];
        let twin = mesh.twin(halfedge).unwrap();
        let [near, far] = at(twin);
        assert_eq!(at(halfedge), [far, near]);
        let own = mesh.triangle(mesh.face(halfedge)).normals[halfedge as usize % 3];
        creases += usize::from(own != at(halfedge)[0]);
    }
    assert_eq!(creases, 24);
    // The crease persists: every edge of the cube has the normals of its two sides.
    let fine = mesh.tessellate(Smoothing::Pn).unwrap();
    assert_eq!(fine.normals().len(), 6 + 2 * 18 + 12 + 2 * 12);
}

#[test]
fn edges_of_1e_3_at_a_million() {
    let mesh = holds("offset-1e6", 0);
    // Moved to the origin, which is exact, the mesh gives the same result except for rounding.
    let place = DVec3::splat(1e6);
    let moved = Mesh::new(
        mesh.positions().iter().map(|p| *p - place).collect(),
        mesh.normals().to_vec(),
        Vec::new(),
        mesh.triangles().to_vec(),
        CreaseAngle::NONE,
    )
    .unwrap();
    for smoothing in methods() {
        let [far, near] = [&mesh, &moved].map(|m| smooth(m.clone(), smoothing, 1).unwrap());
        for (far, near) in far.positions().iter().zip(near.positions()) {
            let ulp = 2.0_f64.powi(-33);
            assert!((*far - place - *near).abs().max_element() <= 2.5 * ulp, "{far} {near}");
        }
    }
}

#[test]
fn normals_of_any_length() {
    let mesh = holds("normal-lengths", 0);
    for (normal, position) in mesh.normals().iter().zip(mesh.positions()) {
        assert!(normal.distance(*position) < 1e-14);
    }
}

#[test]
fn the_shapes_are_closed_and_their_normals_point_out() {
    for (name, triangles, open) in [
        ("icosahedron", 20, 0),
        ("cube", 12, 0),
        ("torus", 256, 0),
        ("grid", 72, 24),
        ("figure", 260, 0),
    ] {
        let mesh = load(name);
        assert_eq!((mesh.triangles().len(), borders(&mesh)), (triangles, open), "{name}");
        for smoothing in methods() {
            let fine = smooth(mesh.clone(), smoothing, 2).unwrap();
            assert_eq!(borders(&fine), 9 * open, "{name}");
        }
        for triangle in mesh.triangles() {
            let p = corners(&mesh, triangle);
            let face = (p[1] - p[0]).cross(p[2] - p[0]);
            let normals = triangle.map(|corner| mesh.normals()[corner.normal as usize]);
            assert!(normals.iter().all(|normal| normal.dot(face) > 0.0), "{name}");
        }
        // The mesh faces outwards if its volume is positive.
        let volume: f64 = mesh
            .triangles()
            .iter()
            .map(|t| {
                let [a, b, c] = corners(&mesh, t);
                a.dot(b.cross(c))
            })
            .sum();
        assert!(open > 0 || volume > 0.0, "{name}");
    }
}

#[test]
fn creases_by_angle() {
    let creased = |degrees| {
        let crease = CreaseAngle::new(degrees).unwrap();
        Mesh::load_obj(&file("cube"), crease).unwrap().normals().to_vec()
    };
    // At 89 degrees, each face has its own normal at each of its corners. The fan's diagonal is not a crease.
    assert_eq!(creased(89.0).len(), 24);
    assert!(creased(89.0).iter().all(|normal| normal.abs().max_element() == 1.0));
    let round = creased(91.0);
    assert_eq!(round.len(), 8);
    // Because normals are weighted by angle, the diagonals have no effect.
    assert!(round.iter().all(|n| (n.abs() - DVec3::splat(1.0 / 3.0_f64.sqrt())).length() < 1e-15));
    assert_eq!(creased(180.0).len(), 8);
}

#[test]
fn texture_coordinates_are_linear_on_both_sides_of_a_seam() {
    let mesh = load("torus");
    let fine = smooth(mesh.clone(), Smoothing::Pn, 1).unwrap();
    assert_eq!(fine.coordinates().len(), 17 * 9 + 2 * 384 + 256 + 2 * (16 + 8));
    for (triangle, parts) in mesh.triangles().iter().zip(fine.triangles().chunks(9)) {
        let old = triangle.map(|corner| mesh.coordinates()[corner.coordinate as usize]);
        let at = |corner: Corner| fine.coordinates()[corner.coordinate as usize];
        for (k, parts) in parts.chunks(3).enumerate() {
            let [a, b, c] = [0, 1, 2].map(|i| old[(k + i) % 3]);
            let thirds = |i: f64, j: f64, l: f64| (a * i + b * j + c * l) / 3.0;
            let [corner, inner, _] = parts else { panic!("three parts a corner") };
            for (got, expected) in [
                (at(corner[0]), a),
                (at(corner[1]), thirds(2.0, 1.0, 0.0)),
                (at(corner[2]), thirds(2.0, 0.0, 1.0)),
                (at(inner[1]), thirds(1.0, 1.0, 1.0)),
            ] {
                assert!(got.distance(expected) < 1e-15);
            }
        }
    }
}
