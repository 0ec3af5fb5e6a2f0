//! Trim curves of any degree with weights, and NURBS curves: every pixel of 2048² is decided as an independent
//! computation does that evaluates the curves of the scene's text with their own knots.

use freeform_surface::Scene;
use glam::{DVec2, UVec2};

use crate::harness::trim_text::TrimText;
use crate::harness::{Stage, load, root};

pub(crate) const SIDE: usize = 2048;
/// The distance from a curve within which a sample may be decided either way, as a share of the smallest patch.
pub(crate) const EITHER_WAY: f64 = 2e-7;

fn check(name: &str) -> Vec<bool> {
    let path = root().join(format!("resources/scenes/stability/trim-{name}.toml"));
    let trims = TrimText::new(&std::fs::read_to_string(&path).unwrap());
    let cut = cut_by_gpu(&load(&path));
    check_pixels(name, &trims, &cut);
    cut
}

/// Compares every pixel of a square picture of the domain, given bottom row first, with the trims of the text.
pub(crate) fn check_pixels(name: &str, trims: &TrimText, cut: &[bool]) {
    let [low, high] = trims.domain;
    let (mut wrong, mut close) = (0, 0);
    for (i, cut) in cut.iter().enumerate() {
        let share = (DVec2::new((i % SIDE) as f64, (i / SIDE) as f64) + 0.5) / SIDE as f64;
        match trims.judge(low + (high - low) * share, *cut, EITHER_WAY * trims.patch) {
            Some(true) => {}
            Some(false) => wrong += 1,
            None => close += 1,
        }
    }
    assert_eq!(wrong, 0, "{name}: wrong pixels");
    assert!(close < 100, "{name}: {close} pixels may be either way");
}

/// The pixels that the GPU cuts out, bottom row first.
pub(crate) fn cut_by_gpu(scene: &Scene) -> Vec<bool> {
    let row = 4 * SIDE;
    let image = Stage::new(UVec2::splat(SIDE as u32)).render(scene);
    image.chunks_exact(row).rev().flat_map(|row| row.chunks_exact(4)).map(|p| p[3] == 0).collect()
}

#[test]
fn rational_circles_are_cut_as_circles() {
    let cut = check("rational-circle");
    // The same by the circles' equation.
    let mut inside = 0;
    for (i, cut) in cut.iter().enumerate() {
        let [u, v] = [i % SIDE, i / SIDE].map(|i| (i as f64 + 0.5) / SIDE as f64);
        let beyond = [(0.35, 0.25), (0.75, 0.2)]
            .map(|(center, radius)| DVec2::new(u, v).distance(DVec2::splat(center)) - radius);
        let nearest = beyond[0].min(beyond[1]);
        if nearest.abs() > EITHER_WAY {
            assert_eq!(*cut, nearest < 0.0, "({u}, {v})");
            inside += usize::from(*cut);
        }
    }
    assert!(inside > 1_000_000, "{inside}");
}

#[test]
fn a_curve_of_degree_11_is_cut_as_its_own_points_say() {
    let cut = check("degree-11");
    assert!(cut.iter().filter(|cut| **cut).count() > 500_000);
}

#[test]
fn nurbs_curves_are_cut_as_their_own_knots_say() {
    let cut = check("nurbs");
    assert!(cut.iter().filter(|cut| **cut).count() > 500_000);
}

#[test]
fn wrong_curves_are_refused_with_their_line() {
    let refused = |trim: &str, words: &[&str]| {
        let text = format!("[[surface]]\ncontrol_points = \"default\"\n[[surface.trim]]\n{trim}\n");
        let error = Scene::from_toml(&text, "x.toml".as_ref()).unwrap_err().to_string();
        assert!(error.starts_with("x.toml:") && error.lines().count() == 1, "{error}");
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let points = "[[0.1, 0.1], [0.5, 0.1, 2.0], [0.1, 0.1]]";
    let nurbs = |degree: &str, knots: &str| {
        format!("nurbs = [{{ degree = {degree}, knots = {knots}, points = {points} }}]")
    };
    refused(&nurbs("0", "[0, 1]"), &["x.toml:3:", "loop 0", "segment 0", "degree", "1 to 15"]);
    refused(&nurbs("2", "[0, 0, 1, 1]"), &["number of knots", "is 4", "6, points"]);
    refused(&nurbs("1", "[0, 0, 2, 1, 3]"), &["knot 3", "is 1", "at least 2"]);
    refused(&nurbs("2", "[0, 0, 0, 0, 0, 0]"), &["domain", "0 to 0"]);
    refused("loop = [[[0.1, 0.1], [0.5, 0.1, -2.0], [0.1, 0.1]]]", &["weight of point 1", "-2"]);
    refused("loop = [[[0.1, 0.1], [0.5, 0.1, 2.0, 1.0], [0.1, 0.1]]]", &["[u, v, weight]"]);
    refused("loop = [[[0.1, 0.1]]]", &["number of points", "is 1", "2 to 16"]);
    let twice = format!("loop = [{points}]\n{}", nurbs("2", "[0, 0, 0, 1, 1, 1]"));
    refused(&twice, &["loop beside nurbs"]);
}
