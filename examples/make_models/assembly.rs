//! A plate with four bolts, twice: once as it is and once mirrored.

use freeform_surface::Result;
use freeform_surface::glam::{DAffine3, DVec3, dvec3};
use freeform_surface::model::{Frame, Model, ProductUse};

use super::solid::{Builder, Circle, Ring, upright};

const THICKNESS: f64 = 12.0;
/// Where the bolts are.
const PLACES: [[f64; 2]; 4] = [[12.0, 12.0], [68.0, 12.0], [12.0, 48.0], [48.0, 48.0]];

pub(crate) fn model() -> Result<Model> {
    let mut assembly = Builder::new("assembly");
    bolt(&mut assembly);
    let bolt = assembly.product("bolt", Some([0.35, 0.37, 0.4]));
    plate(&mut assembly);
    let plate = assembly.product("plate", Some([0.75, 0.77, 0.8]));
    let half = assembly.product("plate with bolts", None);
    let used = |product: usize, placement: DAffine3| ProductUse { product, placement, color: None };
    let mut uses = vec![used(plate, DAffine3::IDENTITY)];
    uses.extend(
        PLACES.map(|[x, y]| used(bolt, DAffine3::from_translation(dvec3(x, y, THICKNESS)))),
    );
    // One of them is marked.
    uses[4].color = Some([0.8, 0.2, 0.15]);
    assembly.model.products[half].uses = uses;
    let whole = assembly.product("assembly", None);
    let mirror = DAffine3::from_translation(dvec3(-10.0, 0.0, 0.0))
        * DAffine3::from_scale(dvec3(-1.0, 1.0, 1.0));
    assembly.model.products[whole].uses = vec![used(half, DAffine3::IDENTITY), used(half, mirror)];
    Ok(assembly.model)
}

/// A bolt of 8 mm with a hexagonal head, which stands on z = 0.
fn bolt(bolt: &mut Builder) {
    const HEAD: f64 = 5.5;
    const ACROSS_FLATS: f64 = 13.0;
    let side = ACROSS_FLATS / 3_f64.sqrt();
    let corner = |i: usize, z: f64| {
        let half = ACROSS_FLATS / 2.0;
        let [x, y] = [
            [side, 0.0],
            [side / 2.0, half],
            [-side / 2.0, half],
            [-side, 0.0],
            [-side / 2.0, -half],
            [side / 2.0, -half],
        ][i % 6];
        dvec3(x, y, z)
    };
    let [low, high] = [0.0, HEAD].map(|z| [0, 1, 2, 3, 4, 5].map(|i| corner(i, z)));
    let axis = Frame::WORLD;
    let [end, chamfer, shank] = [(3.0, -21.0), (4.0, -20.0), (4.0, 0.0)]
        .map(|(radius, height)| bolt.circle(&axis, radius, height));
    let outer = Ring { is_outer: true, has_seam: true };
    bolt.polygon(DVec3::Z, &high, &[]);
    prism_sides(bolt, &low, &high);
    bolt.polygon(-DVec3::Z, &low, &[shank]);
    bolt.ring(&axis, [chamfer, shank], &outer);
    bolt.ring(&axis, [end, chamfer], &outer);
    bolt.disc(-DVec3::Z, end, &[]);
}

/// A plate with a cut corner and four holes.
fn plate(plate: &mut Builder) {
    let outline = [[0.0, 0.0], [80.0, 0.0], [80.0, 40.0], [60.0, 60.0], [0.0, 60.0]];
    let [low, high] = [0.0, THICKNESS].map(|z| outline.map(|[x, y]| dvec3(x, y, z)));
    let holes = PLACES.map(|[x, y]| {
        let axis = upright(dvec3(x, y, 0.0));
        (axis, [0.0, THICKNESS].map(|height| plate.circle(&axis, 4.5, height)))
    });
    let ends = |end: usize| holes.map(|(_, circles): (Frame, [Circle; 2])| circles[end]);
    plate.polygon(-DVec3::Z, &low, &ends(0));
    plate.polygon(DVec3::Z, &high, &ends(1));
    prism_sides(plate, &low, &high);
    for (axis, circles) in holes {
        plate.ring(&axis, circles, &Ring { is_outer: false, has_seam: true });
    }
}

/// The sides between two polygons, which are counter-clockwise seen from above.
fn prism_sides(solid: &mut Builder, low: &[DVec3], high: &[DVec3]) {
    for i in 0..low.len() {
        let next = (i + 1) % low.len();
        let normal = (low[next] - low[i]).cross(DVec3::Z).normalize();
        solid.polygon(normal, &[low[i], low[next], high[next], high[i]], &[]);
    }
}
