//! The winding number of closed loops around a point, computed by subdivision in `f64`, without roots or derivatives.

use glam::DVec2;

use super::{FillRule, Segment, TrimLoop};
use crate::bezier::{bounding_box, split};

/// Pieces smaller than this are treated as points. The size is relative to the sample's coordinates where those
/// exceed 1. With a larger value, shaders in `f32` could notice the difference; with a smaller value, rounding would
/// keep pieces from shrinking.
const POINT_SIZE: f64 = 1e-13;

/// Whether `uv` lies inside an odd number of loops: whether [`winding_number`] is odd.
#[must_use]
pub fn inside_loops(loops: &[TrimLoop], uv: DVec2) -> bool {
    FillRule::EvenOdd.fills(winding_number(loops, uv))
}

/// How often loops go around `uv`, counted counter-clockwise with u to the right and v upwards.
///
/// The crossings of the loops with a ray from `uv` towards greater u are added up: an upward crossing counts 1, a
/// downward crossing −1. The row test `v₀ ≤ v < v₁` is half open, so that an end point shared by two curves counts
/// once. Points closer than about 1e-13 to a curve may fall on either side.
#[must_use]
pub fn winding_number(loops: &[TrimLoop], uv: DVec2) -> i32 {
    loops.iter().flat_map(TrimLoop::segments).map(|segment| ray_crossings(segment, uv)).sum()
}

/// How often a curve crosses the ray from `uv` towards greater u upwards, minus how often it crosses the ray
/// downwards. [`winding_number`] is the sum of these differences. Only curves that have control points both above and
/// below the row of `uv` contribute.
#[must_use]
pub fn ray_crossings(segment: &Segment, uv: DVec2) -> i32 {
    match *segment {
        Segment::Line(points) => crossings(points, uv),
        Segment::Quadratic(points) => crossings(points, uv),
        Segment::Cubic(points) => crossings(points, uv),
    }
}

fn crossings<const N: usize>(points: [DVec2; N], uv: DVec2) -> i32 {
    let [min, max] = bounding_box(points);
    if uv.y < min.y || uv.y > max.y || uv.x >= max.x {
        return 0;
    }
    let point_size = POINT_SIZE * uv.abs().max_element().max(1.0);
    if uv.x < min.x || (max - min).max_element() < point_size {
        // The whole piece lies on the side of the ray, or it counts as a point: only its ends matter.
        return i32::from(points[0].y <= uv.y) - i32::from(points[N - 1].y <= uv.y);
    }
    let [first, second] = split(&points, |a, b| (a + b) * 0.5);
    crossings(first, uv) + crossings(second, uv)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;

    fn square(low: f64, high: f64) -> TrimLoop {
        let corners = [dvec2(low, low), dvec2(high, low), dvec2(high, high), dvec2(low, high)];
        TrimLoop::new((0..4).map(|i| Segment::Line([corners[i], corners[(i + 1) % 4]])).collect())
            .unwrap()
    }

    #[test]
    fn islands_and_corners() {
        let loops = [square(0.1, 0.9), square(0.3, 0.7), square(0.45, 0.55)];
        for (uv, expected) in [
            (dvec2(0.05, 0.5), false),
            (dvec2(0.2, 0.5), true),
            (dvec2(0.4, 0.5), false),
            (dvec2(0.5, 0.5), true),
            // Rows through corners: each counts once, from above or below.
            (dvec2(0.0, 0.1), false),
            (dvec2(0.2, 0.1), true),
            (dvec2(0.0, 0.9), false),
            (dvec2(0.0, 0.3), false),
            (dvec2(0.2, 0.7), true),
        ] {
            assert_eq!(inside_loops(&loops, uv), expected, "{uv}");
        }
    }

    #[test]
    fn loops_are_counted_by_their_directions() {
        let backwards = |outer: &TrimLoop| {
            let turned = outer.segments().iter().rev().map(|s| Segment::Line([s.end(), s.start()]));
            TrimLoop::new(turned.collect()).unwrap()
        };
        let (outer, inner) = (square(0.1, 0.9), square(0.3, 0.7));
        let same = [outer.clone(), inner.clone()];
        let opposite = [outer.clone(), backwards(&inner)];
        let twice_back = [backwards(&outer), backwards(&inner), backwards(&inner)];
        for (uv, numbers) in [
            (dvec2(0.05, 0.5), [0, 0, 0]),
            (dvec2(0.2, 0.5), [1, 1, -1]),
            (dvec2(0.5, 0.5), [2, 0, -3]),
            (dvec2(0.8, 0.7), [1, 1, -1]),
            (dvec2(0.95, 0.5), [0, 0, 0]),
        ] {
            let found = [&same[..], &opposite, &twice_back].map(|l| winding_number(l, uv));
            assert_eq!(found, numbers, "{uv}");
        }
    }

    #[test]
    fn a_parabola_cuts_where_its_closed_form_says() {
        // v = 0.2 + 2·0.6·t(1−t) over u = t, closed by its chord.
        let arch = TrimLoop::new(vec![
            Segment::Quadratic([dvec2(0.0, 0.2), dvec2(0.5, 0.8), dvec2(1.0, 0.2)]),
            Segment::Line([dvec2(1.0, 0.2), dvec2(0.0, 0.2)]),
        ])
        .unwrap();
        for i in 0..200 {
            for j in 0..200 {
                let uv = dvec2((f64::from(i) + 0.37) / 200.0, (f64::from(j) + 0.61) / 200.0);
                let top = 0.2 + 1.2 * uv.x * (1.0 - uv.x);
                let expected = uv.y > 0.2 && uv.y < top;
                assert_eq!(inside_loops(std::slice::from_ref(&arch), uv), expected, "{uv}");
            }
        }
    }

    #[test]
    fn a_tangent_row_counts_both_or_neither() {
        // The arch of the parabola touches the row v = 0.5 in its top point (0.5, 0.5).
        let arch = TrimLoop::new(vec![
            Segment::Quadratic([dvec2(0.0, 0.2), dvec2(0.5, 0.8), dvec2(1.0, 0.2)]),
            Segment::Line([dvec2(1.0, 0.2), dvec2(0.0, 0.2)]),
        ])
        .unwrap();
        for u in [0.0, 0.25, 0.49, 0.51, 0.9] {
            assert!(!inside_loops(std::slice::from_ref(&arch), dvec2(u, 0.5)));
        }
    }
}
