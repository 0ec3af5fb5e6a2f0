//! An angle bracket: three of its outer edges are rounded and meet in an eighth of a sphere, and so is its inner edge.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use freeform_surface::Result;
use freeform_surface::glam::{DVec2, DVec3, dvec2, dvec3};
use freeform_surface::model::{FaceSurface, Frame, Model};

use super::solid::{Builder, Ring};

const LENGTH: f64 = 60.0;
const WIDTH: f64 = 40.0;
const HEIGHT: f64 = 50.0;
const THICKNESS: f64 = 10.0;
/// The radius of the outer edges.
const OUTER: f64 = 4.0;
/// The radius of the inner edge.
const INNER: f64 = 8.0;
const HOLE: f64 = 5.0;

pub(crate) fn model() -> Result<Model> {
    let mut bracket = Builder::new("bracket");
    let [x, y, z] = [DVec3::X, DVec3::Y, DVec3::Z];
    let (r, t, foot) = (OUTER, THICKNESS, THICKNESS + INNER);
    // Where the sphere touches the planes x = 0, y = 0 and z = 0.
    let center = DVec3::splat(r);
    let [back, side, bottom] = [dvec3(0.0, r, r), dvec3(r, 0.0, r), dvec3(r, r, 0.0)];
    // Where the rounded edges along x, y and z end, in both planes that they touch.
    let along_x = [dvec3(LENGTH, 0.0, r), dvec3(LENGTH, r, 0.0)];
    let along_y = [dvec3(r, WIDTH, 0.0), dvec3(0.0, WIDTH, r)];
    let along_z = [dvec3(0.0, r, HEIGHT), dvec3(r, 0.0, HEIGHT)];
    bracket.arc(center, back, side);
    bracket.arc(center, side, bottom);
    bracket.arc(center, bottom, back);
    bracket.arc(dvec3(LENGTH, r, r), along_x[0], along_x[1]);
    bracket.arc(dvec3(r, WIDTH, r), along_y[0], along_y[1]);
    bracket.arc(dvec3(r, r, HEIGHT), along_z[0], along_z[1]);
    // The outline at y = 0 and y = WIDTH from the end of the foot on, around the inner edge.
    let outline =
        |y: f64| [(LENGTH, t), (foot, t), (t, foot), (t, HEIGHT)].map(|(x, z)| dvec3(x, y, z));
    let (near, far) = (outline(0.0), outline(WIDTH));
    for ([_, from, to, _], y) in [(near, 0.0), (far, WIDTH)] {
        bracket.arc(dvec3(foot, y, foot), from, to);
    }
    let far_bottom = dvec3(LENGTH, WIDTH, 0.0);
    let far_top = dvec3(0.0, WIDTH, HEIGHT);
    let through_foot = Frame { origin: dvec3(40.0, 22.0, 0.0), ..Frame::WORLD };
    let through_back = Frame { origin: dvec3(0.0, 22.0, 35.0), x: y, y: z, z: x };
    let [foot_hole, back_hole] = [through_foot, through_back]
        .map(|axis| [0.0, t].map(|height| bracket.circle(&axis, HOLE, height)));

    bracket.polygon(-y, &[side, along_x[0], near[0], near[1], near[2], near[3], along_z[1]], &[]);
    bracket.polygon(
        y,
        &[along_y[0], far_bottom, far[0], far[1], far[2], far[3], far_top, along_y[1]],
        &[],
    );
    bracket.polygon(-x, &[back, along_y[1], far_top, along_z[0]], &[back_hole[0]]);
    bracket.polygon(-z, &[bottom, along_x[1], far_bottom, along_y[0]], &[foot_hole[0]]);
    bracket.polygon(x, &[along_x[1], far_bottom, far[0], near[0], along_x[0]], &[]);
    bracket.polygon(z, &[near[1], near[0], far[0], far[1]], &[foot_hole[1]]);
    bracket.polygon(x, &[near[2], far[2], far[3], near[3]], &[back_hole[1]]);
    bracket.polygon(z, &[along_z[1], near[3], far[3], far_top, along_z[0]], &[]);
    for (axes, length, corners) in [
        ([-y, -z, x], LENGTH - r, [side, bottom, along_x[1], along_x[0]]),
        ([-z, -x, y], WIDTH - r, [bottom, back, along_y[1], along_y[0]]),
        ([-x, -y, z], HEIGHT - r, [back, side, along_z[1], along_z[0]]),
    ] {
        let [x, y, z] = axes.map(|axis| axis + DVec3::ZERO);
        let surface = FaceSurface::Cylinder { frame: Frame { origin: center, x, y, z }, radius: r };
        let loops = vec![bracket.chain(&corners)];
        bracket.face(surface, false, [DVec2::ZERO, dvec2(FRAC_PI_2, length)], loops);
        bracket.name("rounded edge");
    }
    let [x_axis, y_axis] = [-z, -x].map(|axis| axis + DVec3::ZERO);
    let inner = Frame { origin: dvec3(foot, 0.0, foot), x: x_axis, y: y_axis, z: y };
    let loops = vec![bracket.chain(&[near[1], near[2], far[2], far[1]])];
    let bounds = [DVec2::ZERO, dvec2(FRAC_PI_2, WIDTH)];
    bracket.face(FaceSurface::Cylinder { frame: inner, radius: INNER }, true, bounds, loops);
    bracket.name("inner edge");
    corner(&mut bracket, center, &[back, bottom, side]);
    let hole = Ring { is_outer: false, has_seam: true };
    bracket.ring(&through_foot, foot_hole, &hole);
    bracket.ring(&through_back, back_hole, &hole);
    bracket.product("bracket", Some([0.85, 0.55, 0.2]));
    Ok(bracket.model)
}

/// The eighth of a sphere. Its parameters have their poles outside of it.
fn corner(bracket: &mut Builder, center: DVec3, corners: &[DVec3; 3]) {
    let z = dvec3(1.0, -1.0, 0.0).normalize();
    let x = DVec3::splat(-1.0).normalize();
    let frame = Frame { origin: center, x, y: z.cross(x), z };
    let bounds = [
        dvec2(-std::f64::consts::FRAC_1_SQRT_2.atan(), -FRAC_PI_4),
        dvec2(std::f64::consts::SQRT_2.atan(), FRAC_PI_4),
    ];
    let loops = vec![bracket.chain(corners)];
    bracket.face(FaceSurface::Sphere { frame, radius: OUTER }, false, bounds, loops);
    bracket.name("corner");
}
