//! The hard cases of trimming, each a scene in `resources/scenes/stability` and a test. Each test states the
//! result of the thesis' method, and checks that the exact method decides every sample as the oracle does.
//!
//! The exact method is tested at every pixel of a picture of 2048², drawn by the GPU. On the CPU it is tested
//! at rows through every v that the grid stores and one ulp beside it. The thesis' method is evaluated by its
//! twin in `f64` at every eighth pixel and row (every 64th where there are thousands of loops). Among these are
//! the rows and pixels for which the scenes are made. The method refuses loops that its forms cannot represent.

use freeform_surface::inspect::{NewtonTrims, TrimGrid};
use freeform_surface::{Newton, Scene, Trims};
use glam::{UVec2, dvec2};

use crate::harness::Stage;
use crate::harness::oracle::{Row, centers, count_wrong, count_wrong_of_grid};
use crate::harness::{load, root};

const SIDE: u32 = 2048;

/// The result of the thesis' method for a scene.
#[derive(Debug, PartialEq)]
enum Thesis {
    /// The number of wrong samples of 256 × 256, or of 32 × 32 where there are thousands of loops.
    Wrong(usize),
    /// The method cannot represent the trims.
    Refuses,
}

fn scene(name: &str) -> Scene {
    load(&root().join("resources/scenes/stability").join(format!("trim-{name}.toml")))
}

/// The pixels that the GPU cuts out of a scene's patch, bottom row first, in the direction of v.
fn cut_by_gpu(scene: &Scene) -> Vec<bool> {
    let row = 4 * SIDE as usize;
    let image = Stage::new(UVec2::splat(SIDE)).render(scene);
    image.chunks_exact(row).rev().flat_map(|row| row.chunks_exact(4)).map(|p| p[3] == 0).collect()
}

fn thesis(trims: &Trims) -> Thesis {
    let Ok(loops) = NewtonTrims::of(trims) else { return Thesis::Refuses };
    let newton = Newton::default();
    let step = if trims.loops.len() > 1000 { 64 } else { 8 };
    let some: Vec<f64> = centers(SIDE).into_iter().step_by(step).collect();
    let wrong_in_row = |v: &f64| {
        let row = Row::new(trims, *v);
        let cut = |uv| trims.shapes_cut(uv) || loops.cut(&newton, uv);
        some.iter().filter(|u| cut(dvec2(**u, *v)) != row.cut(**u)).count()
    };
    Thesis::Wrong(some.iter().map(wrong_in_row).sum())
}

/// Every v that the grid stores, and the neighbouring values.
fn stored_rows(grid: &TrimGrid) -> Vec<f32> {
    let mut rows: Vec<f32> = grid.pieces().iter().flat_map(|piece| [piece[1], piece[3]]).collect();
    rows.sort_by(f32::total_cmp);
    rows.dedup();
    // Thousands of rows would take hours; all cases but two have fewer.
    let step = rows.len().div_ceil(400).max(1);
    rows.into_iter().step_by(step).flat_map(|v| [v.next_down(), v, v.next_up()]).collect()
}

fn check(name: &str, expected: Thesis) {
    let scene = scene(name);
    let trims = &scene.surfaces[0].trims;
    let pixels = centers(SIDE);
    let cut = cut_by_gpu(&scene);
    assert_eq!(count_wrong(trims, &pixels, &pixels, &cut), 0, "{name}: wrong pixels");

    let grid = TrimGrid::new(trims);
    let columns: Vec<f32> = (0..509).map(|i| i as f32 / 508.0).collect();
    let wrong = count_wrong_of_grid(trims, &grid, &columns, &stored_rows(&grid));
    assert_eq!(wrong, 0, "{name}: wrong samples on stored rows");
    assert_eq!(thesis(trims), expected, "{name}: the thesis' method");
}

macro_rules! cases {
    ($($test:ident: $name:literal, $thesis:expr;)*) => {
        $(#[test]
        fn $test() {
            check($name, $thesis);
        })*
    };
}

use Thesis::{Refuses, Wrong};

cases! {
    horizontal_tangent_on_a_row: "tangent-on-row", Wrong(1114);
    end_point_shared_on_a_row: "end-point-on-row", Wrong(1664);
    horizontal_and_vertical_segments: "straight-segments", Refuses;
    inflection_on_a_row: "inflection-on-row", Wrong(4623);
    cusp: "cusp", Wrong(1645);
    zero_length_segments: "zero-length", Refuses;
    vanishing_leading_coefficient: "linear-quadratic", Wrong(7901);
    loop_that_crosses_itself: "self-crossing", Wrong(2075);
    overlapping_loops: "overlapping", Wrong(8001);
    the_same_loop_twice: "twice", Wrong(19961);
    loops_that_touch: "touching", Refuses;
    end_points_on_two_rows: "ends-on-two-rows", Wrong(7626);
    counter_clockwise: "counter-clockwise", Wrong(19865);
    gap_of_1e_7: "gap-1e-7", Wrong(2030);
    coordinates_that_differ_by_2e_6: "nearly-level", Wrong(2467);
    loop_smaller_than_a_pixel: "smaller-than-a-pixel", Wrong(0);
    sliver: "sliver", Refuses;
    ring_around_the_domain: "ring-around", Wrong(5425);
    samples_on_edges_of_cells: "cell-edge", Refuses;
    coordinates_outside_the_domain: "outside", Refuses;
    border_with_a_hole: "keep-inside", Refuses;
    paths_of_both_rules: "fill-rules", Refuses;
    circles_intervals_and_ellipses: "shapes", Wrong(0);
    circles_as_rational_curves: "rational-circle", Refuses;
    a_rational_curve_of_degree_11: "degree-11", Refuses;
    b_spline_curves: "nurbs", Refuses;
    ten_thousand_segments: "10000-segments", Wrong(350);
    ten_thousand_segments_in_one_cell: "10000-in-one-cell", Refuses;
}

#[test]
fn what_is_no_loop_is_refused_by_number() {
    for (name, words) in [
        ("gap", ["loop 0", "gap between the end of segment 0 and the start of segment 1", "0.001"]),
        ("nan", ["loop 0", "segment 1", "NaN"]),
        ("infinity", ["loop 0", "segment 0", "inf"]),
    ] {
        let file = format!("resources/scenes/stability/trim-refused-{name}.toml");
        let text = Scene::load(&root().join(file)).unwrap_err().to_string();
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
        assert!(text.contains(".toml:19:"), "{text}");
    }
}

#[test]
fn every_scene_has_its_test() {
    let tested = include_str!("trim_stability.rs");
    for file in std::fs::read_dir(root().join("resources/scenes/stability")).unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        let Some(name) = name.strip_prefix("trim-") else { continue };
        let name = name.strip_suffix(".toml").unwrap();
        let name = name.strip_prefix("refused-").unwrap_or(name);
        assert!(tested.contains(&format!("\"{name}\"")), "{name} has no test");
    }
}
