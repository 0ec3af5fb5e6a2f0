//! The hard cases of smoothing, each a scene in `resources/scenes/stability` and a test: curved PN triangles,
//! Phong tessellation, and the mesh without smoothing.

use freeform_surface::inspect::measure::Random;
use freeform_surface::{AovKind, Frame, Scene};
use glam::{DVec3, DVec4, uvec2};

use crate::harness::Stage;
use crate::harness::meshes::{Distance, borders, check_edges, cracks, off_by, pieces, view};
use crate::harness::patches::{at_level, count_drawn, within};
use crate::harness::{load, root};

fn scene(name: &str) -> Scene {
    load(&root().join("resources/scenes/stability").join(format!("tri-{name}.toml")))
}

/// The distance of a point from a triangle.
fn distance(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_edge = |a: DVec3, b: DVec3| {
        let along = b - a;
        let at = (point - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        point.distance(a + along * at.clamp(0.0, 1.0))
    };
    let edges = to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a));
    let normal = (b - a).cross(c - a);
    let inside = |a: DVec3, b: DVec3| (b - a).cross(point - a).dot(normal) >= 0.0;
    if normal != DVec3::ZERO && inside(a, b) && inside(b, c) && inside(c, a) {
        (point - a).dot(normal.normalize()).abs()
    } else {
        edges
    }
}

/// Draws a scene with all methods and settings and checks its invariants; `open` is the number of border edges
/// of each mesh.
fn holds(name: &str, open: usize) {
    let mut scene = scene(name);
    assert_eq!(scene.meshes.len(), 3, "{name}");
    assert_eq!(borders(&scene), 3 * open, "{name}");
    let mut stage = Stage::new(uvec2(240, 120));
    let pieces = pieces(&scene);
    let mut prepared = stage.prepared(&scene);
    let mut random = Random(7);
    let mut near_enough = 0;
    for index in 0..12 {
        // The first view is the scene's own.
        if index > 0 {
            let distance = [Distance::Far, Distance::Near, Distance::Grazing][index % 3];
            scene.camera = Some(view(&pieces, &mut random, distance));
        }
        let levels = [1, 2, 3, 8].map(at_level);
        for settings in [within(0.5)].into_iter().chain(levels) {
            let name = format!("{name}, view {index}, {:?}", settings.tessellation);
            let frame = Frame { settings, ..stage.frame(&scene) };
            let picture = stage.picture(&mut prepared, &frame);
            if index == 0 {
                assert!(count_drawn(&picture) > 3_000, "{name}");
            }
            let (figures, drawn) = (prepared.stats(), stage.triangles(&mut prepared, &frame));
            // Near views may reach the limit of 64 levels; the scene's own view never does.
            assert!(index > 0 || figures.unmet.is_none(), "{name}: {figures:?}");
            if figures.largest_bound.is_some_and(|bound| bound <= 1.0) {
                assert_eq!(cracks(&picture, &pieces, &frame, stage.size), 0, "{name}");
                near_enough += 1;
            }
            let from_view = frame.camera.view.inverse();
            for vertex in &drawn {
                let all = [&vertex.clip[..], &vertex.position, &vertex.normal, &vertex.uv].concat();
                assert!(all.iter().all(|value| value.is_finite()), "{name}: {vertex:?}");
                let normal = DVec3::from_array(vertex.normal.map(f64::from));
                assert!((normal.length() - 1.0).abs() < 1e-5, "{name}: {vertex:?}");
                let position = DVec4::from_array(vertex.position.map(f64::from)).truncate();
                let piece = &pieces[vertex.patch as usize];
                let far = distance(from_view.transform_point3(position), piece.corners);
                assert!(far <= piece.longest_edge(), "{name}: {vertex:?} is {far} off");
            }
            check_edges(&name, &pieces, &drawn);
            if let Some(bound) = figures.largest_bound {
                let (off, _) = off_by(&pieces, &drawn, &frame, stage.size);
                assert!(off <= bound, "{name}: {off} px, {bound} at most");
            }
            let aovs = stage.aovs(&mut prepared, &frame);
            for kind in AovKind::ALL {
                let finite =
                    aovs.channel(kind).as_flattened().iter().all(|value| value.is_finite());
                assert!(finite, "{name}: {}", kind.name());
            }
        }
    }
    assert!(near_enough >= 12, "{name}: {near_enough}");
}

#[test]
fn a_triangle_of_no_area() {
    holds("zero-area", 0);
}

#[test]
fn a_needle() {
    holds("needle", 0);
}

#[test]
fn coincident_vertices() {
    holds("coincident", 0);
}

#[test]
fn a_zero_normal() {
    holds("zero-normal", 0);
}

#[test]
fn opposite_normals() {
    holds("opposite-normals", 0);
}

#[test]
fn a_normal_at_right_angles_to_its_face() {
    holds("right-angle-normal", 0);
}

#[test]
fn a_boundary() {
    holds("boundary", 11);
}

#[test]
fn a_crease() {
    holds("crease", 0);
}

#[test]
fn edges_of_1e_3_at_a_million() {
    holds("offset-1e6", 0);
}

#[test]
fn normals_of_any_length() {
    holds("normal-lengths", 0);
}

#[test]
fn every_scene_has_its_test() {
    let tested = include_str!("mesh_stability.rs");
    let mut count = 0;
    for file in std::fs::read_dir(root().join("resources/scenes/stability")).unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        let Some(name) = name.strip_prefix("tri-") else { continue };
        let name = name.strip_suffix(".toml").unwrap();
        assert!(tested.contains(&format!("holds(\"{name}\"")), "{name} has no test");
        count += 1;
    }
    let meshes = std::fs::read_dir(root().join("resources/meshes/hard")).unwrap().count();
    assert_eq!(count, meshes);
}
