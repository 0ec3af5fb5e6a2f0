//! The hard cases of tessellation, each a scene in `resources/scenes/stability` and a test, with both methods
//! side by side from the scene's own camera. The exact method stays within half a pixel and a tenth of a degree
//! everywhere. The faults of the thesis' picture at its level of 32 are stated.

use freeform_surface::inspect::measure::Measurement;
use freeform_surface::{Frame, FrameStats, Method, Scene};
use glam::uvec2;

use crate::harness::Stage;
use crate::harness::patches::within;
use crate::harness::{load, root};

/// A fault of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Fault {
    /// A point is further from its surface than this number of pixels, which is one of [`BANDS`].
    Off(f64),
    /// A normal is turned by more than 1°.
    Normals,
    /// Pixels within the surface are missing.
    Cracks,
    /// Pixels show hidden points.
    Hidden,
    /// Values that are not finite.
    BadValues,
}

/// Bands of errors in pixels.
const BANDS: [f64; 5] = [0.5, 2.0, 5.0, 20.0, 50.0];

fn faults(found: &Measurement) -> Vec<Fault> {
    let off = BANDS.into_iter().rfind(|band| found.max_error_px > *band).map(Fault::Off);
    let others = [
        (found.normal_error_deg > 1.0, Fault::Normals),
        (found.crack_pixels > 0, Fault::Cracks),
        (found.hidden_pixels > 0, Fault::Hidden),
        (found.bad_values > 0, Fault::BadValues),
    ];
    let others = others.into_iter().filter(|(is, _)| *is).map(|(_, fault)| fault);
    off.into_iter().chain(others).collect()
}

fn scene(name: &str) -> Scene {
    load(&root().join("resources/scenes/stability").join(format!("tess-{name}.toml")))
}

fn draw(scene: &Scene, method: Method) -> (Measurement, FrameStats) {
    let mut stage = Stage::new(uvec2(480, 300));
    let mut prepared = stage.prepared(scene);
    let mut settings = within(0.5);
    settings.method = method;
    let frame = Frame::new(stage.projection(scene), stage.size, settings);
    (stage.measured(scene, &mut prepared, &frame), prepared.stats())
}

fn check(name: &str, thesis: &[Fault]) {
    check_exact(name);
    let (found, _) = draw(&scene(name), Method::Thesis);
    assert_eq!(faults(&found), thesis, "{name}: the thesis' method: {found:?}");
}

fn check_exact(name: &str) {
    let (found, stats) = draw(&scene(name), Method::Exact);
    let numbers = (found.crack_pixels + found.hidden_pixels, found.bad_values, stats.unmet);
    assert_eq!(numbers, (0, 0, None), "{name}: {found:?} {stats:?}");
    assert!(found.max_error_px <= 0.5, "{name}: {found:?}");
    assert!(found.normal_error_deg <= 0.1, "{name}: {found:?}");
    // Everything that has a size on the screen is visible.
    assert_eq!(found.covered > 0, name != "far", "{name}: {found:?}");
}

/// A scene with degrees that the thesis' method refuses.
fn check_degrees(name: &str) {
    check_exact(name);
    let path = root().join("resources/scenes/stability").join(format!("tess-{name}.toml"));
    let text = std::fs::read_to_string(&path).unwrap() + "\n[render]\nmethod = \"thesis\"\n";
    let error = Scene::from_toml(&text, &path).unwrap_err().to_string();
    assert!(error.contains("degree") && error.contains("(3, 3) or (4, 4)"), "{error}");
}

macro_rules! cases {
    ($($test:ident: $name:literal, $thesis:expr;)*) => {
        $(#[test]
        fn $test() {
            check($name, &$thesis);
        })*
    };
}

use Fault::{Cracks, Hidden, Normals, Off};

cases! {
    all_points_coincident: "all-coincident", [Normals];
    behind_the_camera: "behind", [Normals];
    both_tangents_zero: "both-tangents-zero", [Normals];
    collapsed_edge: "collapsed-edge", [Normals];
    cusp: "cusp", [Normals];
    smaller_than_a_pixel: "far", [];
    flat: "flat", [];
    grazing_view: "grazing", [Normals];
    camera_inside_the_surface: "inside", [Normals];
    more_than_64_levels: "more-than-64", [Off(5.0), Normals, Cracks, Hidden];
    near_plane_through_the_surface: "near-plane", [Off(2.0), Normals];
    offset_1e6: "offset-1e6", [Normals];
    orthographic: "orthographic", [Normals];
    nearly_parallel_tangents: "parallel-tangents", [Off(0.5)];
    pole: "pole", [Off(0.5), Normals];
    quartic: "quartic", [Normals];
    rational_sphere: "rational-sphere", [Normals];
    self_fold: "self-fold", [Off(0.5), Normals];
    shared_edges: "shared-edges", [Normals];
    size_1e_6: "size-1e-6", [Normals];
    size_1e6: "size-1e6", [Normals];
    thin: "thin", [Off(0.5)];
    trimmed_neighbours: "trimmed-neighbours", [Off(0.5), Normals];
    twist: "twist", [Normals];
    neighbours_of_two_levels: "two-levels", [Off(5.0), Normals];
    weights_from_1e_3_to_1e3: "weights", [Off(50.0), Normals, Hidden];
}

#[test]
fn the_largest_degree() {
    check_degrees("degree-15");
}

#[test]
fn the_smallest_degree() {
    check_degrees("bilinear-saddle");
}

#[test]
fn whole_cylinder_and_cone() {
    check_degrees("cylinder-and-cone");
}

#[test]
fn rational_torus() {
    check_degrees("torus");
}

#[test]
fn neighbours_of_different_degrees() {
    check_degrees("mixed-degrees");
}

#[test]
fn edges_of_another_degree_on_each_side() {
    check_degrees("raised-edges");
}

#[test]
fn neighbours_of_thirty_degrees() {
    check_degrees("many-degrees");
}

#[test]
fn weights_from_1e_3_to_1e3_along_an_edge() {
    check_degrees("weights-along-an-edge");
}

#[test]
fn what_is_flat_or_far_takes_two_triangles() {
    for name in ["flat", "far"] {
        let (_, stats) = draw(&scene(name), Method::Exact);
        assert_eq!((stats.triangles, stats.draws), (2, 1), "{name}");
    }
}

#[test]
fn what_is_no_control_point_is_refused_by_number() {
    for (name, words) in [
        ("nan", ["control point 6", "NaN", "finite"]),
        ("infinity", ["control point 6", "inf", "finite"]),
        ("zero-weight", ["weight of control point 6", "is 0", "above 0"]),
        ("negative-weight", ["weight of control point 6", "is -1", "above 0"]),
    ] {
        let file = format!("resources/scenes/stability/tess-refused-{name}.toml");
        let text = Scene::load(&root().join(file)).unwrap_err().to_string();
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
        assert!(text.contains(".toml:8:") && text.lines().count() == 1, "{text}");
    }
}

#[test]
fn every_scene_has_its_test() {
    let tested = include_str!("tessellation_stability.rs");
    let mut count = 0;
    for file in std::fs::read_dir(root().join("resources/scenes/stability")).unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        let Some(name) = name.strip_prefix("tess-") else { continue };
        let name = name.strip_suffix(".toml").unwrap();
        let name = name.strip_prefix("refused-").unwrap_or(name);
        assert!(
            tested.contains(&format!("(\"{name}\"")) || tested.contains(&format!(": \"{name}\"")),
            "{name} has no test"
        );
        count += 1;
    }
    assert!(count >= 30, "{count} scenes");
}
