//! Parts of an edge in view space.

use glam::{DVec2, DVec3};

/// The largest value of |t (1 − t) (t − 1/2)| between 0 and 1: how far a cubic with a third difference of 1 is off the
/// parabola through its ends and its middle.
const CUBIC: f64 = 0.04812;

/// An end of a part of an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    /// Of both faces, in view space.
    pub(super) normals: [DVec3; 2],
    /// (u, v) on both faces.
    pub(super) shares: [DVec2; 2],
}

impl End {
    pub(super) fn between(self, other: Self, share: f64) -> Self {
        let both = [0, 1];
        Self {
            normals: both.map(|face| {
                self.normals[face].lerp(other.normals[face], share).normalize_or_zero()
            }),
            shares: both.map(|face| self.shares[face].lerp(other.shares[face], share)),
        }
    }
}

/// A part of an edge in view space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    /// The control points of a cubic.
    pub(super) points: [DVec3; 4],
    pub(super) ends: [End; 2],
    /// Whether it begins and ends where the whole edge does.
    pub(super) is_end: [bool; 2],
}

impl Part {
    /// Upper bound of the distance of the cubic from its segment ([`Part::straight`]), at equal parameters.
    pub(super) fn bend(&self) -> f64 {
        let [middle, third] = self.off_line();
        0.5 * middle.length() + CUBIC * third.length()
    }

    /// How far the middle of the cubic is off the line between its ends, and the third difference.
    fn off_line(&self) -> [DVec3; 2] {
        let [a, b, c, d] = self.points;
        [0.375 * (b + c - a - d), d - 3.0 * c + 3.0 * b - a]
    }

    /// The least number of equal parts, or 2, that are off their segments by at most `limit`.
    pub(super) fn count_within(&self, limit: f64) -> u32 {
        /// More parts might be out of the picture.
        const MOST: u32 = 16;
        let [a, b, c, d] = self.points;
        let second = |a: DVec3, b: DVec3, c: DVec3| (a - 2.0 * b + c).length_squared();
        // Half of an eighth of the largest second derivative, which is 6 times the largest second difference.
        let second = 0.375 * second(a, b, c).max(second(b, c, d)).sqrt();
        let third = CUBIC * self.off_line()[1].length();
        let is_within = |count: &u32| {
            let share = 1.0 / f64::from(*count);
            (second + third * share) * share * share <= limit
        };
        (2..=MOST).find(is_within).unwrap_or(2)
    }

    /// The straight part that stands for the cubic: the line between its ends, moved by half of the way to its middle.
    pub(super) fn straight(&self) -> Self {
        let shift = 0.5 * self.off_line()[0];
        let [start, .., end] = self.points;
        Self { points: line(start + shift, end + shift), ..*self }
    }

    /// The part between two parameters.
    pub(super) fn between(&self, from: f64, to: f64) -> Self {
        let [a, b, c, d] = self.points;
        // The blossom of the cubic.
        let point = |r: f64, s: f64, t: f64| {
            let (ab, bc, cd) = (a.lerp(b, r), b.lerp(c, r), c.lerp(d, r));
            ab.lerp(bc, s).lerp(bc.lerp(cd, s), t)
        };
        let [start, end] = self.ends;
        Self {
            points: [
                point(from, from, from),
                point(from, from, to),
                point(from, to, to),
                point(to, to, to),
            ],
            ends: [from, to].map(|share| start.between(end, share)),
            is_end: [self.is_end[0] && from == 0.0, self.is_end[1] && to == 1.0],
        }
    }

    /// The straight part beyond a distance along the view axis.
    pub(super) fn beyond(&self, near: f64) -> Option<Self> {
        // Points on the near plane itself have a place on the screen.
        let [mut start, mut end] = [(self.points[0], self.ends[0]), (self.points[3], self.ends[1])];
        let [a, b] = [start, end].map(|(point, _)| -point.z - near);
        if a > 0.0 && b > 0.0 {
            return Some(*self);
        }
        if a <= 0.0 && b <= 0.0 {
            return None;
        }
        let share = a / (a - b);
        let cut = (start.0.lerp(end.0, share), start.1.between(end.1, share));
        if a < 0.0 {
            start = cut;
        } else if b < 0.0 {
            end = cut;
        }
        Some(Self { points: line(start.0, end.0), ends: [start.1, end.1], is_end: self.is_end })
    }
}

/// The control points of a line as a cubic.
pub(super) fn line(start: DVec3, end: DVec3) -> [DVec3; 4] {
    [start, start.lerp(end, 1.0 / 3.0), start.lerp(end, 2.0 / 3.0), end]
}
