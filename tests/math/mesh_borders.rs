//! Edges that no manifold surface has: shared by three or more triangles, or traversed twice in the same
//! direction. They are borders, and smoothing must not open gaps along them.

use std::collections::HashMap;
use std::path::Path;

use freeform_surface::inspect::{CurvedTriangle, HalfedgeMesh, PhongTriangle, PnTriangle};
use freeform_surface::{Alpha, Corner, CreaseAngle, Mesh, Smoothing, smooth};
use glam::{DVec3, dvec3};
use proptest::prelude::*;

fn read(text: &str) -> Mesh {
    Mesh::read_obj(text.as_bytes(), Path::new("x.obj"), CreaseAngle::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

type Bits = [u64; 3];

/// The number of triangles at each edge, keyed by the positions of its ends.
fn sides(mesh: &Mesh) -> HashMap<[Bits; 2], usize> {
    let mut sides = HashMap::new();
    for triangle in mesh.triangles() {
        let at = |corner: Corner| {
            let position = mesh.positions()[corner.position as usize] + DVec3::ZERO;
            position.to_array().map(f64::to_bits)
        };
        let [a, b, c] = triangle.map(at);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *sides.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    sides
}

fn open_edges(mesh: &Mesh) -> usize {
    sides(mesh).values().filter(|count| **count == 1).count()
}

/// After a step of smoothing, each edge of an odd number of triangles has become three such edges, and there
/// are no others. (Edges within triangles have two sides, or four and more where triangles coincide.)
fn check_nothing_opens(mesh: &Mesh) {
    let odd = |mesh: &Mesh| sides(mesh).into_values().filter(|count| count % 2 == 1).count();
    let open = odd(mesh);
    for smoothing in [Smoothing::Pn, Smoothing::Phong(Alpha::default()), Smoothing::None] {
        for steps in [1, 2] {
            let fine = smooth(mesh.clone(), smoothing, steps).unwrap();
            assert!(fine.positions().iter().all(|point| point.is_finite()));
            assert_eq!(odd(&fine), open * 3_usize.pow(steps), "{smoothing:?}, {steps} steps");
        }
    }
    // The driver draws the same points from all sides of an edge, bit for bit.
    let mesh = HalfedgeMesh::new(mesh.clone());
    let mut places: HashMap<(u32, u32), Vec<DVec3>> = HashMap::new();
    for halfedge in 0..mesh.halfedges() {
        let triangle = mesh.triangle(mesh.face(halfedge));
        let surfaces: [&dyn CurvedTriangle; 2] =
            [&PnTriangle::new(&triangle), &PhongTriangle::new(&triangle, Alpha::default())];
        let (from, to) = (mesh.vertex(halfedge), mesh.vertex(mesh.next(halfedge)));
        let mut points = Vec::new();
        for surface in surfaces {
            for i in 0..=8_u8 {
                let along = f64::from(if from < to { i } else { 8 - i }) / 8.0;
                let mut weights = [0.0; 3];
                weights[halfedge as usize % 3] = 1.0 - along;
                weights[(halfedge as usize + 1) % 3] = along;
                points.push(surface.position(weights[0], weights[1], weights[2]));
            }
        }
        let known = places.entry((from.min(to), from.max(to))).or_insert_with(|| points.clone());
        assert_eq!(*known, points, "edge of {from} and {to}");
    }
}

const FANS: &str = "v 0 0 0\nv 0 0 1\nv 1 0 0\nv -1 1 0\nv -1 -1 0\nf 1 2 3\nf 1 2 4\nf 2 1 5\n";
const DOUBLE_SIDED: &str =
    "v 0 0 0\nv 1 0 0\nv 1 1 0.2\nv 0 1 0\nf 1 2 3\nf 1 3 4\nf 3 2 1\nf 4 3 1\n";
const FLIPPED: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.3\nv 2 0 0\nf 1 2 3\nf 1 4 3\nf 2 5 3\n";

#[test]
fn what_no_surface_has_is_read_and_counted() {
    for (text, crowded, same_way) in [(FANS, 1, 0), (DOUBLE_SIDED, 1, 0), (FLIPPED, 0, 1)] {
        let mesh = read(text);
        let shared = HalfedgeMesh::new(mesh.clone()).shared_borders();
        assert_eq!((shared.crowded, shared.same_way), (crowded, same_way), "{text}");
        check_nothing_opens(&mesh);
    }
}

/// A sphere of longitudes and latitudes with a seam: the first and the last meridian have their own points.
fn sphere_with_a_seam() -> String {
    let (rings, round) = (6, 8);
    let mut text = String::new();
    for ring in 0..=rings {
        let (sine, cosine) = (f64::from(ring) / f64::from(rings) * std::f64::consts::PI).sin_cos();
        for i in 0..=round {
            let (y, x) =
                (f64::from(i % round) / f64::from(round) * std::f64::consts::TAU).sin_cos();
            // The poles are one point each.
            let sine = if ring == 0 || ring == rings { 0.0 } else { sine };
            text += &format!("v {} {} {cosine}\n", sine * x, sine * y);
        }
    }
    let at = |ring: i32, i: i32| 1 + ring * (round + 1) + i;
    for (ring, i) in (0..rings).flat_map(|ring| (0..round).map(move |i| (ring, i))) {
        let (a, b) = (at(ring, i), at(ring, i + 1));
        let (c, d) = (at(ring + 1, i), at(ring + 1, i + 1));
        text += &format!("f {a} {c} {d} {b}\n");
    }
    text
}

/// Two boxes side by side that share an edge, each with its own points.
fn touching_boxes(first: usize) -> String {
    let mut text = String::new();
    for (number, from) in [dvec3(5.0, 0.0, 0.0), dvec3(6.0, 1.0, 0.0)].into_iter().enumerate() {
        for i in 0..8 {
            let corner = from + dvec3(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2));
            text += &format!("v {} {} {}\n", corner.x, corner.y, corner.z);
        }
        for face in
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        {
            let corners = face.map(|corner| (first + 8 * number + corner + 1).to_string());
            text += &format!("f {}\n", corners.join(" "));
        }
    }
    text
}

#[test]
fn a_seam_is_closed_whatever_touches_elsewhere() {
    let sphere = sphere_with_a_seam();
    assert_eq!(open_edges(&read(&sphere)), 0);
    let points = sphere.lines().filter(|line| line.starts_with('v')).count();
    let both = read(&(sphere + &touching_boxes(points)));
    assert_eq!(open_edges(&both), 0);
    assert_eq!(HalfedgeMesh::new(both.clone()).shared_borders().crowded, 1);
    for smoothing in [Smoothing::Pn, Smoothing::Phong(Alpha::default())] {
        assert_eq!(open_edges(&smooth(both.clone(), smoothing, 2).unwrap()), 0, "{smoothing:?}");
    }
    check_nothing_opens(&both);
}

#[test]
fn normals_do_not_mix_where_two_shapes_touch() {
    let text = touching_boxes(0);
    let mesh = read(&text);
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|corner| mesh.positions()[corner.position as usize]);
        let face = (b - a).cross(c - a).normalize();
        for corner in triangle {
            let normal = mesh.normals()[corner.normal as usize];
            assert!(normal.distance(face) < 1e-12, "a box's edges are creases: {normal} {face}");
        }
    }
    // Without creases, the normal at a box's corner is still the mean of that box's three sides.
    let round = Mesh::read_obj(text.as_bytes(), Path::new("x.obj"), CreaseAngle::NONE).unwrap();
    for triangle in round.triangles() {
        for corner in triangle {
            let normal = round.normals()[corner.normal as usize];
            let expected = 1.0 / 3.0_f64.sqrt();
            let near = normal.abs().distance(DVec3::splat(expected)) < 1e-12;
            let position = round.positions()[corner.position as usize];
            // The shared edge is an exception. It is a border, where no triangle is connected to all three
            // sides.
            let on_common_edge = position.truncate() == glam::dvec2(6.0, 1.0);
            assert!(near || on_common_edge, "{position}: {normal}");
        }
    }
}

#[test]
fn a_cube_without_normals_keeps_its_edges() {
    let cube: Vec<String> = touching_boxes(0).lines().map(str::to_owned).collect();
    // The points of both boxes, but only the faces of the first.
    let mesh = read(&cube[..14].join("\n"));
    assert_eq!(mesh.triangles().len(), 12);
    assert_eq!(mesh.normals().len(), 24);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 200, ..ProptestConfig::default() })]

    /// Random triangles over a few points, so that edges with three and more triangles and in all directions
    /// are common.
    #[test]
    fn nothing_opens_in_any_soup(
        points in prop::collection::vec((-1.0..1.0, -1.0..1.0, -1.0..1.0), 4..9),
        faces in prop::collection::vec((0..9_usize, 0..9_usize, 0..9_usize), 1..14),
        crease in prop_oneof![Just(30.0), Just(180.0), 0.0..180.0],
    ) {
        let mut text = String::new();
        for (x, y, z) in &points {
            text += &format!("v {x} {y} {z}\n");
        }
        for (a, b, c) in &faces {
            let [a, b, c] = [a, b, c].map(|i| i % points.len() + 1);
            text += &format!("f {a} {b} {c}\n");
        }
        let crease = CreaseAngle::new(crease).unwrap();
        if let Ok(mesh) = Mesh::read_obj(text.as_bytes(), Path::new("x.obj"), crease) {
            check_nothing_opens(&mesh);
        }
    }
}
