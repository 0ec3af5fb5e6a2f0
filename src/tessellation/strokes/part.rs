//! Parts of an edge in view space.

use glam::{DVec2, DVec3};

use crate::bezier::{Difference, Parabola};

/// An end of a part of an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    /// Of both faces, in view space.
    pub(super) normals: [DVec3; 2],
    /// (u, v) on both faces.
    pub(super) shares: [DVec2; 2],
}

impl End {
    fn between(self, other: Self, share: f64) -> Self {
        let both = [0, 1];
        Self {
            normals: both.map(|face| {
                self.normals[face].lerp(other.normals[face], share).normalize_or_zero()
            }),
            shares: both.map(|face| self.shares[face].lerp(other.shares[face], share)),
        }
    }
}

/// A part of an edge in view space that is a cubic.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub(super) points: [DVec3; 4],
    pub(super) ends: [End; 2],
    /// (u, v) on both faces at half of its parameter.
    pub(super) middle: [DVec2; 2],
    /// Whether it begins and ends where the whole edge does.
    pub(super) is_end: [bool; 2],
}

impl Part {
    /// The parabola that stands for it.
    pub(super) fn bow(&self) -> Bow {
        let [start, .., end] = self.points;
        let middle = self.point([0.5; 3]);
        let parabola = Parabola::through(start, middle, end);
        let difference = parabola.compare(&self.points, [0.0, 1.0]);
        Bow { parabola, difference, ends: self.ends, middle: self.middle, is_end: self.is_end }
    }

    /// The blossom of the cubic.
    fn point(&self, [r, s, t]: [f64; 3]) -> DVec3 {
        let [a, b, c, d] = self.points;
        let (ab, bc, cd) = (a.lerp(b, r), b.lerp(c, r), c.lerp(d, r));
        ab.lerp(bc, s).lerp(bc.lerp(cd, s), t)
    }

    /// The part between two parameters.
    pub(super) fn between(&self, from: f64, to: f64) -> Self {
        let [start, end] = self.ends;
        let shares = |t: f64| {
            [0, 1].map(|face| {
                let straight = start.shares[face].lerp(end.shares[face], t);
                let sag = self.middle[face] - start.shares[face].midpoint(end.shares[face]);
                straight + 4.0 * t * (1.0 - t) * sag
            })
        };
        Self {
            points: [[from; 3], [from, from, to], [from, to, to], [to; 3]].map(|t| self.point(t)),
            ends: [from, to].map(|t| End { shares: shares(t), ..start.between(end, t) }),
            middle: shares(from.midpoint(to)),
            is_end: [self.is_end[0] && from == 0.0, self.is_end[1] && to == 1.0],
        }
    }
}

/// A parabola in view space that stands for a part of an edge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bow {
    pub(super) parabola: Parabola,
    /// How far the edge is from it.
    pub(super) difference: Difference,
    pub(super) ends: [End; 2],
    /// (u, v) on both faces at half of its parameter.
    pub(super) middle: [DVec2; 2],
    /// Whether it begins and ends where the whole edge does.
    pub(super) is_end: [bool; 2],
}

impl Bow {
    /// Where it begins and ends.
    pub(super) const fn tips(&self) -> [DVec3; 2] {
        let [start, _, end] = self.parabola.points;
        [start, end]
    }

    /// The part beyond a distance along the view axis of the line between its ends.
    pub(super) fn line_beyond(&self, near: f64) -> Option<Self> {
        let [start, end] = self.tips();
        // Points on the near plane itself have a place on the screen.
        let [a, b] = [start, end].map(|point| -point.z - near);
        if a <= 0.0 && b <= 0.0 {
            return None;
        }
        let share = a / (a - b);
        let cut = || (start.lerp(end, share), self.ends[0].between(self.ends[1], share));
        let from = if a < 0.0 { cut() } else { (start, self.ends[0]) };
        let to = if b < 0.0 { cut() } else { (end, self.ends[1]) };
        let middle = [0, 1].map(|face| from.1.shares[face].midpoint(to.1.shares[face]));
        let parabola = Parabola::through(from.0, from.0.midpoint(to.0), to.0);
        Some(Self { parabola, ends: [from.1, to.1], middle, ..*self })
    }
}
