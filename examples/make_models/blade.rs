//! A twisted blade: one rational surface of degrees 5 and 3 through sections, which closes at a sharp edge, and two
//! plane ends.

use freeform_surface::glam::{DVec2, DVec3, DVec4, dvec2, dvec3};
use freeform_surface::model::{Coedge, Curve, FaceSurface, Model, NurbsCurve};
use freeform_surface::{Degree, NurbsSurface, Result};

use super::solid::{Builder, coedge, plane, within};

/// The control points of a section of chord 1 from the sharp edge at (1, 0), around the round edge at (0, 0), back to
/// it: x, y and weight.
const SECTION: [[f64; 3]; 13] = [
    [1.0, 0.0, 1.0],
    [0.85, 0.05, 1.0],
    [0.7, 0.1, 1.0],
    [0.45, 0.17, 1.0],
    [0.2, 0.18, 1.25],
    [0.0, 0.12, 1.5],
    [-0.04, 0.02, 2.0],
    [0.0, -0.04, 1.5],
    [0.15, -0.05, 1.25],
    [0.4, -0.01, 1.0],
    [0.65, 0.01, 1.0],
    [0.85, 0.01, 1.0],
    [1.0, 0.0, 1.0],
];
/// Sections: height, chord and twist in degrees.
const SECTIONS: [[f64; 3]; 6] = [
    [0.0, 40.0, 0.0],
    [8.0, 39.0, 4.0],
    [24.0, 36.0, 13.0],
    [44.0, 31.0, 23.0],
    [62.0, 26.0, 31.0],
    [70.0, 24.0, 34.0],
];

pub(crate) fn model() -> Result<Model> {
    let mut blade = Builder::new("blade");
    let degree = Degree::new(5, 3)?;
    let knots = [clamped(5, &[0.15, 0.3, 0.42, 0.5, 0.58, 0.7, 0.85]), clamped(3, &[0.3, 0.65])];
    let points: Vec<DVec4> = SECTIONS.into_iter().flat_map(section).collect();
    let surface = NurbsSurface::new(degree, knots.clone(), points.clone())?;
    let columns = SECTION.len();
    let row = |row: usize| points[row * columns..][..columns].to_vec();
    let column: Vec<DVec4> = points.iter().step_by(columns).copied().collect();
    let [root, tip] =
        [0, SECTIONS.len() - 1].map(|number| NurbsCurve::new(5, knots[0].clone(), row(number)));
    let seam = NurbsCurve::new(3, knots[1].clone(), column)?;
    let [root, tip, seam] =
        [root?, tip?, seam].map(|curve| blade.edge(Curve::Nurbs(curve), [0.0, 1.0]));
    let sides = [
        with_pcurve(root, true, [DVec2::ZERO, DVec2::X])?,
        with_pcurve(seam, true, [DVec2::X, DVec2::ONE])?,
        with_pcurve(tip, false, [DVec2::Y, DVec2::ONE])?,
        with_pcurve(seam, false, [DVec2::ZERO, DVec2::Y])?,
    ];
    blade.face(FaceSurface::Nurbs(surface.clone()), false, surface.domain(), vec![sides.into()]);
    blade.name("aerofoil");
    for (edge, v, forward) in [(root, 0.0, false), (tip, 1.0, true)] {
        let normal = if forward { DVec3::Z } else { -DVec3::Z };
        let frame = plane(surface.at(0.0, v).position, normal);
        let ends =
            (0..=1000).map(|i| within(&frame, surface.at(f64::from(i) / 1000.0, v).position));
        let start = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let bounds = ends.fold(start, |[min, max], end| [min.min(end), max.max(end)]);
        // They need not be exact.
        let bounds = [(bounds[0] * 100.0).floor() / 100.0, (bounds[1] * 100.0).ceil() / 100.0];
        blade.face(FaceSurface::Plane(frame), false, bounds, vec![vec![coedge(edge, forward)]]);
        blade.name(if forward { "tip" } else { "root" });
    }
    blade.product("blade", Some([0.55, 0.7, 0.8]));
    Ok(blade.model)
}

/// The control points of a section, in thousandths of a millimetre.
fn section([height, chord, twist]: [f64; 3]) -> impl Iterator<Item = DVec4> {
    let rotation = DVec2::from_angle(twist.to_radians());
    SECTION.into_iter().map(move |[x, y, weight]| {
        // The twist is about a point at a third of the chord.
        let place = rotation.rotate(chord * dvec2(x - 0.33, y));
        let rounded = (place * 1000.0).round() / 1000.0;
        dvec3(rounded.x, rounded.y, height).extend(weight)
    })
}

/// The knots from 0 to 1 of a curve that begins and ends in control points.
fn clamped(degree: usize, inner: &[f64]) -> Vec<f64> {
    let end = |value: f64| std::iter::repeat_n(value, degree + 1);
    end(0.0).chain(inner.iter().copied()).chain(end(1.0)).collect()
}

/// The use of an edge that is a line in the surface's parameters.
fn with_pcurve(edge: usize, forward: bool, ends: [DVec2; 2]) -> Result<Coedge> {
    let points = ends.map(|end| end.extend(1.0)).into();
    let pcurve = Some(NurbsCurve::new(1, vec![0.0, 0.0, 1.0, 1.0], points)?);
    Ok(Coedge { edge, forward, pcurve })
}
