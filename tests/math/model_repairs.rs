//! What is changed so that faces of models can be drawn is told.

use std::path::Path;

use freeform_surface::model::{DrawnFace, Model};

/// A square of side 1 whose upper edge is the given one, with the given lines of a loop.
fn square(top: &str, uses: &str) -> (Model, DrawnFace) {
    let text = format!(
        "freeform-model 1
edge tolerance 1e-7 range 0 1 line 0 0 0  1 0 0
edge tolerance 1e-7 range 0 1 line 1 0 0  0 1 0
edge tolerance 1e-7 {top}
edge tolerance 1e-7 range 0 1 line 0 0 0  0 1 0
face tolerance 1e-7 forward bounds 0 1 0 1 plane origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1
  loop 4 {uses}
product faces 0 1
end"
    );
    let model = Model::from_text(&text, Path::new("square.ffm")).unwrap();
    let face = model.drawn_face(0, model.diagonal()).unwrap();
    (model, face)
}

const TOP: &str = "range 0 1 line 0 1 0  1 0 0";
const USES: &str = "+ 0 + 1 - 2 - 3";

#[test]
fn a_sound_face_is_not_repaired() {
    let (_, face) = square(TOP, USES);
    assert_eq!(face.repairs, Default::default());
    assert!(face.edges.iter().all(|edge| !edge.is_rough));
}

#[test]
fn gaps_that_lines_close_are_told() {
    // 1e-5 short at its start, and 2e-5 too high.
    let (_, face) = square("range 1e-5 1 line 0 1.00002 0  1 0 0", USES);
    let found: Vec<_> = face.repairs.gaps.iter().map(|gap| (gap.edges, gap.length)).collect();
    let expected = [([1, 2], 2e-5), ([2, 3], 1e-5_f64.hypot(2e-5))];
    assert_eq!(found.len(), 2, "{found:?}");
    for ((edges, length), expected) in found.into_iter().zip(expected) {
        assert_eq!(edges, expected.0);
        assert!((length - expected.1).abs() < 1e-12, "{length}, not {}", expected.1);
    }
    assert!(!face.repairs.without_pcurves && !face.repairs.is_reordered);
    // Below 1e-7 of the diagonal, ends are moved.
    let (_, face) = square("range 1e-8 1 line 0 1 0  1 0 0", USES);
    assert_eq!(face.repairs, Default::default());
}

#[test]
fn edges_in_another_order_are_told() {
    let (model, sound) = square(TOP, USES);
    let (_, face) = square(TOP, "+ 0 - 2 + 1 - 3");
    assert!(face.repairs.is_reordered && !face.repairs.without_pcurves);
    assert_eq!(face.repairs.gaps, []);
    assert_eq!(face.area(), sound.area());
    assert_eq!(model.deviations(0, &face, model.diagonal()).len(), 4);
}

#[test]
fn p_curves_that_bound_no_face_are_told() {
    // Half a sphere. Along its pole, the p-curve of the file goes around once more instead of back.
    let model = |pole: &str| {
        let text = format!(
            "freeform-model 1
edge tolerance 1e-7 range 0 6.283185307179586 circle origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1 1
edge tolerance 1e-7 range 0 1.5707963267948966 circle origin 0 0 0 x 1 0 0 y 0 0 1 z 0 -1 0 1
edge tolerance 1e-7 point
face tolerance 1e-7 forward bounds 0 6.283185307179586 0 1.5707963267948966
  sphere origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1 1
  loop 4 + 0 + 1 + 2 pcurve degree 1 knots 4 0 0 1 1 points 2 {pole} - 1
product faces 0 1
end"
        );
        let model = Model::from_text(&text, Path::new("sphere.ffm")).unwrap();
        model.drawn_face(0, model.diagonal()).unwrap()
    };
    let [from, to] = ["6.283185307179586 1.5707963267948966 1", "0 1.5707963267948966 1"];
    let right = model(&format!("{from} {to}"));
    assert!(!right.repairs.without_pcurves, "{:?}", right.repairs);
    let wrong = model(&format!("{to} {from}"));
    assert!(wrong.repairs.without_pcurves && !wrong.repairs.is_reordered);
    assert_eq!(wrong.repairs.gaps, []);
    for area in [right.area(), wrong.area()] {
        assert!((area - std::f64::consts::TAU).abs() < 1e-9, "{area}");
    }
}

#[test]
fn a_fit_that_failed_is_told() {
    // The line passes the axis of the cylinder so near that its nearest parameter all but jumps by half a turn. The
    // file states a tolerance for it that lets it be as far from the surface.
    let text = "freeform-model 1
edge tolerance 1 range -1.25 1.25 line 0 1e-7 2  0.8 0 0.6
edge tolerance 1e-7 range 0 3.141592653589793 circle origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1 1
edge tolerance 1e-7 range 0 2.75 line 1 0 0  0 0 1
edge tolerance 1e-7 range 0 1.25 line -1 0 0  0 0 1
face tolerance 1e-7 forward bounds 0 3.2 0 3 cylinder origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1 1
  loop 4 + 1 + 3 + 0 - 2
product faces 0 1
end";
    let model = Model::from_text(text, Path::new("cut.ffm")).unwrap();
    let face = model.drawn_face(0, model.diagonal()).unwrap();
    let is_rough =
        |number: usize| face.edges.iter().any(|edge| edge.edge == number && edge.is_rough);
    assert_eq!([0, 1, 2, 3].map(is_rough), [true, false, false, false]);
}
