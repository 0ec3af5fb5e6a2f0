//! Sums, means and directions of vectors, computed so that rounding does not depend on the order of corners.

use glam::DVec3;

/// A sum of unit vectors that is shorter than this has no direction: it may be rounding error alone.
const VANISHED: f64 = 1e-8;
/// A normal whose squared length is this close to 1 is not normalized again, so that meshes that are written and read
/// back stay the same.
const UNIT: f64 = 1e-14;

/// Normalizes a given normal; zero stays zero. `None` if the normal is not finite.
pub(super) fn unit(normal: DVec3) -> Option<DVec3> {
    if (normal.length_squared() - 1.0).abs() <= UNIT {
        return Some(normal);
    }
    // Scaled first, because the squares of very long and very short vectors are out of range.
    let scale = normal.abs().max_element();
    normal.is_finite().then(|| if scale > 0.0 { (normal / scale).normalize() } else { DVec3::ZERO })
}

/// The direction of a sum of unit vectors; `None` if the sum vanishes.
pub(super) fn direction(sum: DVec3) -> Option<DVec3> {
    let length = sum.length();
    (length > VANISHED).then(|| sum / length)
}

/// The common normal of the two sides of an edge at one of its ends.
pub(super) fn between(own: DVec3, other: DVec3) -> DVec3 {
    if own == other { own } else { direction(own + other).unwrap_or(DVec3::ZERO) }
}

/// The component of a vector along a unit vector (or zero).
pub(super) fn along(vector: DVec3, unit: DVec3) -> DVec3 {
    unit * vector.dot(unit)
}

/// The weighted mean of three vectors; the same to the last bit for corners in any order.
pub(super) fn mean([a, b, c]: [DVec3; 3], [u, v, w]: [f64; 3]) -> DVec3 {
    sum(a * u, b * v, c * w)
}

/// The sum of three vectors; the same to the last bit in whatever order they are given.
pub(super) fn sum(a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let (low, high) = (a.min(b), a.max(b));
    let middle = low.max(high.min(c));
    (low.min(c) + high.max(c)) + middle
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_the_same_in_any_order() {
        let [a, b, c] = [0.1, -3.7e5, 1e-9].map(|x| DVec3::new(x, -x, 1.0 / x));
        for other in [sum(a, c, b), sum(b, a, c), sum(b, c, a), sum(c, a, b), sum(c, b, a)] {
            assert_eq!(sum(a, b, c), other);
        }
        assert!((sum(a, b, c) - (a + b + c)).length() < 1e-6);
    }
}
