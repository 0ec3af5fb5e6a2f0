use std::f64::consts::PI;

use super::*;
use crate::bezier::Degree;
use crate::model::{Frame, NurbsCurve};

fn frame() -> Frame {
    let turn = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.5, 1.1, -0.4);
    let [x, y, z] = [turn.x_axis, turn.y_axis, turn.z_axis];
    Frame { origin: DVec3::new(3.0, -2.0, 1.0), x, y, z }
}

/// A curve that winds away from the z axis of the frame, in its plane of x and z.
fn profile() -> BoundedCurve {
    let frame = frame();
    let points = [[1.0, 0.0], [2.0, 0.5], [1.5, 2.0], [2.5, 3.0], [2.0, 4.0]];
    let place = |[x, z]: [f64; 2]| (frame.origin + x * frame.x + z * frame.z).extend(1.0 + 0.1 * z);
    let knots = vec![0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0];
    let curve = NurbsCurve::new(3, knots, points.map(place).to_vec()).unwrap();
    BoundedCurve { curve: Curve::Nurbs(curve), range: [0.0, 1.0] }
}

fn wavy() -> NurbsSurface {
    let height = |x: f64, y: f64| (1.3 * x).sin() + 0.7 * (0.9 * x * y).cos();
    let points = (0..30).map(|i| {
        let (x, y) = (f64::from(i % 6), f64::from(i / 6));
        DVec3::new(x, y, height(x, y)).extend(1.0 + 0.2 * x.sin())
    });
    let knots = [
        vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.5, 3.0, 3.0, 3.0, 3.0],
        vec![2.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0],
    ];
    NurbsSurface::new(Degree::new(3, 2).unwrap(), knots, points.collect()).unwrap()
}

/// Surfaces with parameters within which they do not meet themselves.
fn surfaces() -> Vec<(FaceSurface, [f64; 4])> {
    let frame = frame();
    let left = Frame { y: -frame.y, ..frame };
    let revolution =
        FaceSurface::Revolution { origin: frame.origin, axis: frame.z, curve: profile() };
    let direction = (frame.y + 0.3 * frame.x).normalize();
    vec![
        (FaceSurface::Plane(frame), [-5.0, 5.0, -5.0, 5.0]),
        (FaceSurface::Cylinder { frame, radius: 1.5 }, [-3.0, 3.0, -5.0, 5.0]),
        (FaceSurface::Cylinder { frame: left, radius: 1.5 }, [-3.0, 3.0, -5.0, 5.0]),
        (FaceSurface::Cone { frame, radius: 1.5, half_angle: 0.4 }, [-3.0, 3.0, -3.0, 5.0]),
        (FaceSurface::Cone { frame, radius: 0.0, half_angle: -0.9 }, [-3.0, 3.0, -3.0, -0.1]),
        (FaceSurface::Sphere { frame, radius: 2.0 }, [-3.0, 3.0, -1.5, 1.5]),
        (
            FaceSurface::Torus { frame, major_radius: 2.0, minor_radius: 0.5 },
            [-3.0, 3.0, -3.0, 3.0],
        ),
        (
            FaceSurface::Torus { frame, major_radius: 0.5, minor_radius: 1.0 },
            [-3.0, 3.0, -1.5, 1.5],
        ),
        (revolution, [-3.0, 3.0, 0.0, 1.0]),
        (FaceSurface::Extrusion { direction, curve: profile() }, [0.0, 1.0, -4.0, 4.0]),
        (FaceSurface::Nurbs(wavy()), [0.0, 3.0, 2.0, 4.0]),
    ]
}

#[test]
fn the_nearest_parameters_of_a_point_of_a_surface_are_its_own() {
    for (surface, [u0, u1, v0, v1]) in surfaces() {
        let sheet = Sheet::new(&surface, 1e-6, 1e-6);
        for i in 0..=12 {
            for j in 0..=12 {
                let share = dvec2(f64::from(i), f64::from(j)) / 12.0;
                let uv = dvec2(u0, v0) + share * dvec2(u1 - u0, v1 - v0);
                let point = sheet.at(uv).position;
                for near in [None, Some(uv + dvec2(0.02, -0.02)), Some(uv + dvec2(-0.01, 0.0))] {
                    let found = sheet.unwrapped(sheet.nearest(point, near), uv);
                    assert!(
                        found.distance(uv) < 1e-9,
                        "{surface:?} at {uv}: {found} from {near:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn derivatives_are_those_of_the_points() {
    const STEP: f64 = 1e-6;
    for (surface, [u0, u1, v0, v1]) in surfaces() {
        for (x, y) in [(0.1, 0.2), (0.37, 0.81), (0.72, 0.43), (0.9, 0.05)] {
            let [u, v] = [u0 + x * (u1 - u0), v0 + y * (v1 - v0)];
            let at = |u: f64, v: f64| surface.at(u, v).position;
            let found = surface.at(u, v);
            let du = (at(u + STEP, v) - at(u - STEP, v)) / (2.0 * STEP);
            let dv = (at(u, v + STEP) - at(u, v - STEP)) / (2.0 * STEP);
            assert!(found.du.distance(du) < 1e-8 * du.length().max(1.0), "{surface:?}");
            assert!(found.dv.distance(dv) < 1e-8 * dv.length().max(1.0), "{surface:?}");
        }
    }
    let surface = wavy();
    for (u, v) in [(0.0, 2.0), (3.0, 4.0), (1.0, 3.0), (0.4, 2.9), (2.1, 3.3)] {
        let (found, expected) =
            (super::super::evaluate::nurbs_at(&surface, u, v), surface.at(u, v));
        assert!(found.position.distance(expected.position) < 1e-13);
        assert!(found.du.distance(expected.du) < 1e-12 && found.dv.distance(expected.dv) < 1e-12);
    }
}

#[test]
fn the_nearest_parameters_are_periods_near_those_given() {
    let surface = FaceSurface::Torus { frame: frame(), major_radius: 2.0, minor_radius: 0.5 };
    let sheet = Sheet::new(&surface, 1e-6, 1e-6);
    for near in [dvec2(0.3, 0.4), dvec2(7.0 * PI, -9.0 * PI), dvec2(-20.0, 31.0)] {
        let found = sheet.nearest(sheet.at(near).position, Some(near + dvec2(1.0, -1.0)));
        assert!(found.distance(near) < 1e-12, "{found} near {near}");
    }
}

#[test]
fn poles_are_found() {
    let frame = frame();
    let count = |surface: &FaceSurface| Sheet::new(surface, 1e-6, 1e-6).poles().len();
    assert_eq!(count(&FaceSurface::Sphere { frame, radius: 2.0 }), 2);
    let cone = FaceSurface::Cone { frame, radius: 1.5, half_angle: 0.4 };
    let apex = Sheet::new(&cone, 1e-6, 1e-6).poles()[0];
    assert!(apex.distance(cone.at(1.0, -1.5 / 0.4_f64.sin()).position) < 1e-12);
    assert_eq!(count(&FaceSurface::Nurbs(wavy())), 0);
    assert_eq!(count(&FaceSurface::Cylinder { frame, radius: 2.0 }), 0);
}

#[test]
fn second_derivatives_are_the_changes_of_the_first() {
    const STEP: f64 = 1e-5;
    // With weights that change along both parameters.
    let mut rational = wavy();
    for (i, point) in rational.points_mut().iter_mut().enumerate() {
        point.w = 1.0 + 0.3 * (i as f64).sin();
    }
    let rational = (FaceSurface::Nurbs(rational), [0.0, 3.0, 2.0, 4.0]);
    let all = surfaces().into_iter().chain([rational]);
    for (number, (surface, [low_u, high_u, low_v, high_v])) in all.enumerate() {
        for i in 0..25 {
            // Away from knots, at which they jump.
            let share = |i: u32| 0.013 + 0.97 * f64::from(i) / 4.0;
            let uv = dvec2(
                low_u + share(i % 5) * (high_u - low_u),
                low_v + share(i / 5) * (high_v - low_v),
            );
            let found = surface.curved(uv, uv);
            assert_eq!(found.at.position.distance(surface.at(uv.x, uv.y).position), 0.0);
            let change = |axis: DVec2| {
                let [before, after] = [-STEP, STEP].map(|step| {
                    let place = uv + step * axis;
                    surface.at(place.x, place.y)
                });
                [after.du - before.du, after.dv - before.dv].map(|change| change / (2.0 * STEP))
            };
            let ([duu, duv], [other, dvv]) = (change(DVec2::X), change(DVec2::Y));
            let all = [(found.duu, duu), (found.duv, duv), (found.duv, other), (found.dvv, dvv)];
            for (found, expected) in all {
                let off = found.distance(expected);
                assert!(off < 1e-5 * (1.0 + expected.length()), "{number}: {found} {expected}");
            }
        }
    }
}

#[test]
fn points_beside_a_knot_or_a_seam_are_of_that_side() {
    // The curve has a corner at 1, and ends where it begins.
    let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 0.0]];
    let points = corners.map(|[x, y]| DVec3::new(x, y, 0.0).extend(1.0)).to_vec();
    let knots = vec![0.0, 0.0, 1.0, 2.0, 3.0, 3.0];
    let curve = Curve::Nurbs(NurbsCurve::new(1, knots, points).unwrap());
    let curve = BoundedCurve { curve, range: [0.0, 3.0] };
    let surface = FaceSurface::Extrusion { direction: DVec3::Z, curve };
    let sheet = Sheet::new(&surface, 1e-7, 1e-6);
    let along = |u: f64, side: f64| sheet.beside(dvec2(u, 0.5), dvec2(side, 0.3)).at.du;
    for seam in [0.0, 3.0] {
        assert!(along(seam, 1.0).distance(DVec3::new(2.0, 0.0, 0.0)) < 1e-12);
        assert!(along(seam, -1.0).distance(DVec3::new(-2.0, -1.0, 0.0)) < 1e-12);
    }
    assert!(along(1.0, 1.0).distance(DVec3::Y) < 1e-12);
    assert!(along(1.0, -1.0).distance(DVec3::new(2.0, 0.0, 0.0)) < 1e-12);
}
