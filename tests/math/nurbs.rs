//! NURBS surfaces and their patches, compared with their definition: basis functions on the given knots.

use freeform_surface::{Degree, NurbsSurface, Surface};
use glam::{DVec4, dvec2};
use proptest::prelude::*;

use crate::trim_text::by_definition;

/// A degree and knots: steps between them, some of them 0.
fn axis() -> impl Strategy<Value = (usize, Vec<f64>)> {
    (1..=15_usize).prop_flat_map(|degree| {
        let steps = prop::collection::vec(
            prop_oneof![Just(0.0), 0.01..2.0],
            2 * degree + 1..=2 * degree + 6,
        );
        (Just(degree), -5.0..5.0, steps).prop_map(|(degree, first, steps)| {
            let mut knots = vec![first];
            knots.extend(steps.iter().scan(first, |knot, step| {
                *knot += step;
                Some(*knot)
            }));
            (degree, knots)
        })
    })
}

prop_compose! {
    fn surface()(
        along_u in axis(),
        along_v in axis(),
        weighted in any::<bool>(),
        seeds in prop::collection::vec((-1.0..1.0, -1.0..1.0, -1.0..1.0, 0.1..10.0), 1..50),
    ) -> Option<NurbsSurface> {
        let [columns, rows] = [&along_u, &along_v].map(|(degree, knots)| knots.len() - degree - 1);
        let point = |i: usize| {
            let (x, y, z, w): (f64, f64, f64, f64) = seeds[i * 7 % seeds.len()];
            DVec4::new(x + i as f64 * 0.01, y, z, if weighted { w } else { 1.0 })
        };
        let degree = Degree::new(along_u.0, along_v.0).unwrap();
        let points = (0..columns * rows).map(point).collect();
        // Knots that leave no domain are refused.
        NurbsSurface::new(degree, [along_u.1, along_v.1], points).ok()
    }
}

/// The blends of a rational surface lose digits in proportion to the ratio of its weights.
const ROUNDING: f64 = 1e-11;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn patches_and_points_are_those_of_the_definition(nurbs in surface()) {
        let Some(nurbs) = nurbs else { return Ok(()) };
        let surface = Surface::from_nurbs(nurbs.clone());
        prop_assert_eq!(surface.control_points(), nurbs.control_points());
        for (number, patch) in surface.patches().enumerate() {
            let [low, high] = surface.patch_domain(number);
            for share in [dvec2(0.0, 0.0), dvec2(0.3, 0.9), dvec2(0.5, 0.5), dvec2(0.99, 0.01)] {
                let place = low + share * (high - low);
                let expected = by_definition(&nurbs, place);
                for (what, found) in [
                    ("patch", patch.at(share.x, share.y).position),
                    ("surface", surface.at(number, share.x, share.y).position),
                    ("NURBS", nurbs.at(place.x, place.y).position),
                ] {
                    prop_assert!(found.distance(expected) < ROUNDING, "{} at {}: {} {}", what, place, found, expected);
                }
                // Derivatives of the two evaluations, each in its own way.
                let (a, b) = (patch.at(share.x, share.y), surface.at(number, share.x, share.y));
                let size = 1.0 + a.du.length() + a.dv.length();
                prop_assert!((a.du - b.du).length() + (a.dv - b.dv).length() < 1e-9 * size);
            }
        }
    }

    #[test]
    fn neighbouring_patches_share_their_control_points(nurbs in surface()) {
        let Some(nurbs) = nurbs else { return Ok(()) };
        let surface = Surface::from_nurbs(nurbs.clone());
        let patches: Vec<_> = surface.patches().collect();
        let degree = nurbs.degree();
        let is_continuous = |axis: usize, knot: f64| {
            let times = nurbs.knots()[axis].iter().filter(|other| **other == knot).count();
            times <= [degree.u(), degree.v()][axis]
        };
        for (a, first) in patches.iter().enumerate() {
            for (b, second) in patches.iter().enumerate() {
                let ([a_low, a_high], [b_low, _]) = (surface.patch_domain(a), surface.patch_domain(b));
                if a_high.x == b_low.x && a_low.y == b_low.y && is_continuous(0, b_low.x) {
                    for row in 0..degree.rows() {
                        let (last, start) = (row * degree.columns() + degree.u(), row * degree.columns());
                        prop_assert_eq!(first.points()[last], second.points()[start]);
                    }
                }
                if a_high.y == b_low.y && a_low.x == b_low.x && is_continuous(1, b_low.y) {
                    for column in 0..degree.columns() {
                        let last = degree.v() * degree.columns() + column;
                        prop_assert_eq!(first.points()[last], second.points()[column]);
                    }
                }
            }
        }
    }
}

#[test]
fn a_span_that_is_too_short_to_draw_leaves_no_gap() {
    let knots = [vec![0.0, 0.0, 0.0, 0.5, 0.5 + 3e-13, 1.0, 1.0, 1.0], vec![0.0, 0.0, 1.0, 1.0]];
    let points = (0..10).map(f64::from).map(|x| DVec4::new(x, 1e3 * x.sin(), 0.3 * x, 1.0));
    let nurbs = NurbsSurface::new(Degree::new(2, 1).unwrap(), knots, points.collect()).unwrap();
    let surface = Surface::from_nurbs(nurbs);
    let [first, second] = &surface.patches().collect::<Vec<_>>()[..] else { panic!("two patches") };
    for row in 0..2 {
        assert_eq!(first.points()[3 * row + 2], second.points()[3 * row]);
    }
}

#[test]
fn a_surface_without_inner_knots_is_its_own_patch() {
    let points: Vec<DVec4> =
        (0..12).map(|i| DVec4::new(f64::from(i) * 0.1, f64::from(i * i), 0.3, 1.0)).collect();
    let knots = [vec![3.0, 3.0, 3.0, 3.0, 7.0, 7.0, 7.0, 7.0], vec![0.0, 0.0, 0.0, 0.1, 0.1, 0.1]];
    let nurbs = NurbsSurface::new(Degree::new(3, 2).unwrap(), knots, points.clone()).unwrap();
    let surface = Surface::from_nurbs(nurbs);
    assert_eq!(surface.patch_points(), points);
    assert_eq!(surface.domain(), [dvec2(3.0, 0.0), dvec2(7.0, 0.1)]);
}

#[test]
fn knots_that_differ_by_rounding_are_one_knot() {
    let third = 1.0 / 3.0;
    let near = third + 1e-16 * 2.0;
    let knots = |knot: [f64; 2]| vec![0.0, 0.0, 0.0, knot[0], knot[1], 1.0, 1.0, 1.0];
    let points: Vec<DVec4> = (0..15)
        .map(|i| DVec4::new(f64::from(i % 5), f64::from(i / 5), f64::from(i), 1.0))
        .collect();
    let surface = |knot: [f64; 2]| {
        let along_v = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
        let degree = Degree::new(2, 2).unwrap();
        Surface::from_nurbs(
            NurbsSurface::new(degree, [knots(knot), along_v], points.clone()).unwrap(),
        )
    };
    let (rounded, double) = (surface([third, near]), surface([third, third]));
    assert_eq!((rounded.patches().len(), double.patches().len()), (2, 2));
    for (a, b) in rounded.patch_points().iter().zip(double.patch_points()) {
        assert!(a.distance(*b) < 1e-12, "{a} {b}");
    }
}
