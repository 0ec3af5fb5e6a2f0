//! A flange with a hub, a bore, six countersunk holes and chamfers.

use freeform_surface::Result;
use freeform_surface::glam::{DVec3, dvec3};
use freeform_surface::model::{Frame, Model};

use super::solid::{Builder, Ring, upright};

pub(crate) fn model() -> Result<Model> {
    const OUTER: Ring = Ring { is_outer: true, has_seam: true };
    const BORE: Ring = Ring { is_outer: false, has_seam: true };
    const HOLE: Ring = Ring { is_outer: false, has_seam: false };
    let mut flange = Builder::new("flange");
    let axis = Frame::WORLD;
    // The outline from the bottom upwards: radius and height.
    let outline =
        [(50.0, 0.0), (50.0, 10.5), (48.5, 12.0), (25.0, 12.0), (25.0, 29.0), (24.0, 30.0)];
    let [bottom, rim, edge, foot, neck, top] =
        outline.map(|(radius, height)| flange.circle(&axis, radius, height));
    let [bore_bottom, bore_top] = [0.0, 30.0].map(|height| flange.circle(&axis, 15.0, height));
    let mut lower = vec![bore_bottom];
    let mut upper = vec![foot];
    let mut holes = Vec::new();
    // Six directions, in steps of a sixth of a turn.
    let (c, s) = (0.5, 3_f64.sqrt() / 2.0);
    for [x, y] in [[1.0, 0.0], [c, s], [-c, s], [-1.0, 0.0], [-c, -s], [c, -s]] {
        let axis = upright(37.5 * dvec3(x, y, 0.0));
        let circles = [(4.5, 0.0), (4.5, 10.5), (6.0, 12.0)]
            .map(|(radius, height)| flange.circle(&axis, radius, height));
        lower.push(circles[0]);
        upper.push(circles[2]);
        holes.push((axis, circles));
    }
    flange.disc(-DVec3::Z, bottom, &lower);
    flange.name("bottom");
    flange.ring(&axis, [bottom, rim], &OUTER);
    flange.ring(&axis, [rim, edge], &OUTER);
    flange.name("chamfer");
    flange.disc(DVec3::Z, edge, &upper);
    flange.ring(&axis, [foot, neck], &OUTER);
    flange.ring(&axis, [neck, top], &OUTER);
    flange.disc(DVec3::Z, top, &[bore_top]);
    flange.ring(&axis, [bore_bottom, bore_top], &BORE);
    flange.name("bore");
    for (axis, [bottom, middle, top]) in holes {
        flange.ring(&axis, [bottom, middle], &HOLE);
        flange.ring(&axis, [middle, top], &HOLE);
    }
    flange.product("flange", Some([0.62, 0.66, 0.7]));
    Ok(flange.model)
}
