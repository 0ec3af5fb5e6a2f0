//! Parabolas that stand for parts of curves in space.

use glam::DVec3;

/// A parabola from a start to an end: a quadratic Bézier curve.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parabola {
    /// Start, control point and end.
    pub(crate) points: [DVec3; 3],
}

impl Parabola {
    /// The parabola that is at `middle` at half of its parameter.
    pub(crate) fn through(start: DVec3, middle: DVec3, end: DVec3) -> Self {
        Self { points: [start, 2.0 * middle - start.midpoint(end), end] }
    }

    /// How far its middle is off the middle of its ends.
    pub(crate) fn sag(&self) -> DVec3 {
        let [start, control, end] = self.points;
        0.5 * (control - start.midpoint(end))
    }

    /// Its point at a parameter.
    pub(crate) fn at(&self, t: f64) -> DVec3 {
        let [a, b, c] = self.points;
        a.lerp(b, t).lerp(b.lerp(c, t), t)
    }

    /// The control points of the part between two parameters.
    fn between(&self, [from, to]: [f64; 2]) -> [DVec3; 3] {
        let [a, b, c] = self.points;
        // The blossom.
        let point = |r: f64, s: f64| a.lerp(b, r).lerp(b.lerp(c, r), s);
        [point(from, from), point(from, to), point(to, to)]
    }

    /// How far a cubic is from the parabola, if it is near its part between two parameters.
    ///
    /// At equal parameters, the two differ by a cubic E. Of this, what lies along the parabola only leads to another
    /// point of it, if one goes there by the same length; the parabola turns away from this by its curvature.
    pub(crate) fn compare(&self, cubic: &[DVec3; 4], range: [f64; 2]) -> Difference {
        let [a, b, c] = self.between(range);
        let raised = [a, (a + 2.0 * b) / 3.0, (2.0 * b + c) / 3.0, c];
        let off = [0, 1, 2, 3].map(|i| cubic[i] - raised[i]);
        let largest = off.into_iter().map(DVec3::length).fold(0.0, f64::max);
        let along = (c - a).normalize_or_zero();
        let legs = [b - a, c - b];
        let slowest = legs.map(|leg| leg.dot(along)).into_iter().fold(f64::INFINITY, f64::min);
        let change = (1..4).map(|i| 3.0 * off[i].distance(off[i - 1])).fold(0.0, f64::max);
        // Derivatives by the parameter of the part.
        if slowest <= 0.0 || change >= 2.0 * slowest {
            return Difference { off: largest, drift: largest };
        }
        let turn = legs.map(|leg| along.cross(leg).length() / leg.length());
        let turn = turn.into_iter().fold(0.0, f64::max);
        let across = off.into_iter().map(|off| along.cross(off).length()).fold(0.0, f64::max);
        let moved = largest / (2.0 * slowest);
        let away = legs[0].distance(legs[1]) * moved * moved;
        Difference { off: largest.min(across + turn * largest + away), drift: largest }
    }
}

/// Upper bounds of the distance of a curve from a parabola.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Difference {
    /// From the nearest point of the parabola.
    pub(crate) off: f64,
    /// From its point at the same parameter.
    pub(crate) drift: f64,
}

impl Difference {
    /// The larger of both bounds.
    pub(crate) fn max(self, other: Self) -> Self {
        Self { off: self.off.max(other.off), drift: self.drift.max(other.drift) }
    }

    /// After a map that stretches lengths by up to a factor.
    pub(crate) fn stretched(self, by: f64) -> Self {
        Self { off: self.off * by, drift: self.drift * by }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn cubic_at([a, b, c, d]: &[DVec3; 4], t: f64) -> DVec3 {
        let s = 1.0 - t;
        s * s * s * *a + 3.0 * s * s * t * *b + 3.0 * s * t * t * *c + t * t * t * *d
    }

    /// The largest distance of points of a cubic from the nearest of the parabola.
    fn distance(parabola: &Parabola, cubic: &[DVec3; 4]) -> f64 {
        let [a, b, c] = parabola.points;
        let at = |t: f64| a.lerp(b, t).lerp(b.lerp(c, t), t);
        let nearest = |point: DVec3| {
            let to = |t: &f64| at(*t).distance(point);
            let places = (0..=200).map(|i| f64::from(i) / 200.0);
            let best = places.min_by(|a, b| to(a).total_cmp(&to(b))).unwrap();
            let [mut low, mut high] = [best - 0.005, best + 0.005].map(|t| t.clamp(0.0, 1.0));
            for _ in 0..60 {
                let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                if to(&a) < to(&b) { high = b } else { low = a }
            }
            to(&low)
        };
        (0..=40).map(|i| nearest(cubic_at(cubic, f64::from(i) / 40.0))).fold(0.0, f64::max)
    }

    #[test]
    fn the_bound_holds_and_forgets_what_lies_along_the_curve() {
        for angle in [0.2, 0.4, 0.8_f64] {
            let k = 4.0 / 3.0 * (0.25 * angle).tan();
            let (sine, cosine) = angle.sin_cos();
            let end = dvec3(cosine, sine, 0.0);
            let arc = [DVec3::X, dvec3(1.0, k, 0.0), end + k * dvec3(sine, -cosine, 0.0), end];
            let parabola = Parabola::through(arc[0], cubic_at(&arc, 0.5), arc[3]);
            let (found, bound) =
                (distance(&parabola, &arc), parabola.compare(&arc, [0.0, 1.0]).off);
            assert!(found <= bound + 1e-12, "{angle}: {found} {bound}");
            // The distance of the two is θ⁴/512.
            assert!(bound <= angle.powi(4) / 64.0, "{angle}: {bound}");
        }
        for seed in 0..300 {
            let noise = |i: i32| (f64::from(seed * 31 + i) * 12.9898).sin() * 0.4;
            let cubic = [0, 1, 2, 3].map(|i| {
                dvec3(f64::from(i) + noise(i), noise(i + 4), noise(i + 8) * f64::from(seed % 3))
            });
            let parabola = Parabola::through(cubic[0], cubic_at(&cubic, 0.5), cubic[3]);
            let bound = parabola.compare(&cubic, [0.0, 1.0]).off;
            let found = distance(&parabola, &cubic);
            assert!(found <= bound + 1e-12, "{seed}: {found} {bound}");
        }
    }

    #[test]
    fn a_part_of_a_parabola_is_that_part() {
        let parabola = Parabola::through(DVec3::ZERO, dvec3(1.0, 2.0, 0.5), dvec3(3.0, 1.0, 0.0));
        assert!(parabola.sag().distance(dvec3(-0.5, 1.5, 0.5)) < 1e-15);
        let [a, b, c] = parabola.between([0.25, 0.75]);
        let cubic = [a, (a + 2.0 * b) / 3.0, (2.0 * b + c) / 3.0, c];
        assert!(parabola.compare(&cubic, [0.25, 0.75]).drift < 1e-15);
        let moved = cubic.map(|point| point + 0.1 * DVec3::Z);
        let bound = parabola.compare(&moved, [0.25, 0.75]).off;
        assert!((0.05..=0.1 + 1e-12).contains(&bound), "{bound}");
    }
}
