//! Cuts loops into pieces that are monotone in u and in v. The exact method tests samples against these pieces
//! (Rockwood, Heaton and Davis 1989; Schollmeyer and Fröhlich 2009).
//!
//! Everything before the final rounding to `f32` is computed in `f64`. The rounding preserves the topology:
//! neighbouring pieces share their ends bit for bit, and inner control points stay in the bounding box of the ends.

use glam::{DVec2, Vec2};
use kurbo::common::solve_quadratic;

use super::{Segment, TrimLoop};
use crate::bezier;

/// The maximum number of halvings of a piece. A sample that is still undecided then is treated as lying to the right
/// of the curve.
const HALVINGS: u32 = 24;

/// Parameters closer than this to an end of a curve count as the end.
const END: f64 = 1e-9;

/// A cubic curve in `f64` that is monotone in u and in v, has no inflection, and lies in the domain.
pub(super) type Curve = [DVec2; 4];

/// A monotone curve without inflection, in the form that the shader reads: its lower and upper end, and the first and
/// last leg of its control polygon, from the lower end upwards.
///
/// Legs are short vectors with small rounding errors. Their directions are correct even if they are very short.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Piece {
    pub(super) low: Vec2,
    pub(super) high: Vec2,
    legs: [Vec2; 2],
}

impl Piece {
    /// Rounds a curve to `f32`. `None` if only a point is left.
    pub(super) fn new(curve: &Curve) -> Option<Self> {
        let [mut a, mut b, mut c, mut d] = *curve;
        if a.y > d.y {
            (a, b, c, d) = (d, c, b, a);
        }
        let (low, high) = (rounded(a), rounded(d));
        let chord = high - low;
        let (min, max) = (chord.min(Vec2::ZERO), chord.max(Vec2::ZERO));
        let legs = [rounded(b - a), rounded(d - c)].map(|leg| leg.clamp(min, max));
        (low != high).then_some(Self { low, high, legs })
    }

    /// Minimum and maximum u.
    pub(super) fn u_range(&self) -> [f32; 2] {
        [self.low.x.min(self.high.x), self.low.x.max(self.high.x)]
    }

    /// The words of the shader's buffer.
    pub(super) fn words(&self) -> [u32; 8] {
        let [first, last] = self.legs;
        let points = [self.low, self.high, first, last].map(|point| point.to_array());
        let [[a, b], [c, d], [e, f], [g, h]] = points;
        [a, b, c, d, e, f, g, h].map(f32::to_bits)
    }

    /// The piece that such words store.
    pub(super) fn from_words(words: &[u32]) -> Self {
        let point = |i: usize| Vec2::new(f32::from_bits(words[i]), f32::from_bits(words[i + 1]));
        Self { low: point(0), high: point(2), legs: [point(4), point(6)] }
    }

    /// Whether it bulges to the left of its chord.
    pub(super) fn bulges_left(&self) -> bool {
        let [first, last] = self.legs;
        cross(self.high - self.low, first - last) > 0.0
    }

    /// Whether the ray from `uv` towards greater u crosses the piece. Twin of the test of one piece in `cutByLoops`
    /// of `glsl/common/trim.glsl`, bit for bit.
    ///
    /// The half-open row test and the test of the bounding box decide the topology from the stored bits alone. Inside
    /// the box, the curve lies on one side of its chord.
    #[inline]
    pub(super) fn crosses(&self, uv: Vec2) -> bool {
        if (self.low.y <= uv.y) == (self.high.y <= uv.y) {
            return false;
        }
        let [min, max] = self.u_range();
        if uv.x < min || uv.x >= max {
            return uv.x < min;
        }
        let left = self.bulges_left();
        let turn = if left { 1.0 } else { -1.0 };
        if turn * cross(self.high - self.low, uv - self.low) < 0.0 {
            return !left;
        }
        self.left_of_curve(left, uv - self.low)
    }

    /// Whether a point in the bounding box, given relative to the lower end, lies to the left of the curve. The curve
    /// is halved until it is clear on which side of it the point lies.
    fn left_of_curve(&self, left: bool, point: Vec2) -> bool {
        let [first, last] = self.legs;
        let (mut a, mut b, mut d) = (Vec2::ZERO, first, self.high - self.low);
        let mut c = d - last;
        let turn = if left { 1.0 } else { -1.0 };
        for _ in 0..HALVINGS {
            // De Casteljau's averages without their factors ½. Multiplying by ½ is exact, so it makes no difference
            // when this is done.
            let (ab, bc, cd) = (a + b, b + c, c + d);
            let (abc, bcd) = (ab + bc, bc + cd);
            let middle = (abc + bcd) * 0.125;
            if middle.y <= point.y {
                (a, b, c) = (middle, bcd * 0.25, cd * 0.5);
            } else {
                (b, c, d) = (ab * 0.5, abc * 0.25, middle);
            }
            // The curve lies between the chords of its halves and the tangent at its middle.
            if turn * cross(d - a, point - a) < 0.0 {
                return !left;
            }
            if turn * cross(bcd - abc, point - middle) > 0.0 {
                return left;
            }
        }
        false
    }
}

/// The cross product of two vectors; above 0 if `b` points to the left of `a`.
fn cross(a: Vec2, b: Vec2) -> f32 {
    a.x * b.y - a.y * b.x
}

/// Rounds to `f32`. Values so small that drivers may treat them as zero become zero, and zero is never negative.
fn rounded(point: DVec2) -> Vec2 {
    const TINY: f64 = 1e-30;
    let component = |x: f64| if x.abs() < TINY { 0.0 } else { x as f32 };
    Vec2::new(component(point.x), component(point.y))
}

/// The loops as monotone curves inside the domain [0, 1]². Pieces outside are moved onto the border, so that the
/// chains stay closed.
pub(super) fn monotone_curves(loops: &[TrimLoop]) -> Vec<Curve> {
    let segments = loops.iter().flat_map(TrimLoop::segments);
    let mut curves = Vec::with_capacity(segments.clone().count() * 2);
    for segment in segments {
        if let Segment::Line(_) = segment {
            split_borders(&as_cubic(segment), 0, &mut curves);
            continue;
        }
        split_turns(&as_cubic(segment), 0, &mut |curve| {
            split_inflections(curve, 0, &mut |curve| split_borders(curve, 0, &mut curves));
        });
    }
    curves
}

fn as_cubic(segment: &Segment) -> Curve {
    match *segment {
        Segment::Line([a, b]) => [a, a.lerp(b, 1.0 / 3.0), a.lerp(b, 2.0 / 3.0), b],
        Segment::Quadratic([a, b, c]) => [a, a.lerp(b, 2.0 / 3.0), c.lerp(b, 2.0 / 3.0), c],
        Segment::Cubic(points) => points,
    }
}

/// The two pieces of a curve that is cut at `t`.
pub(super) fn split(curve: &Curve, t: f64) -> [Curve; 2] {
    bezier::split(curve, |a, b| a.lerp(b, t))
}

/// Cuts a curve until its control points are monotone in both coordinates.
fn split_turns(curve: &Curve, depth: u32, take: &mut impl FnMut(&Curve)) {
    // Each coordinate has at most two turning points and one inflection; more cuts come from rounding alone.
    const MAX_CUTS: u32 = 8;
    for axis in 0..2 {
        let Some((t, is_turn)) = cut_of(curve.map(|point| point[axis])) else { continue };
        if depth == MAX_CUTS {
            continue;
        }
        let [mut before, mut after] = split(curve, t);
        if is_turn {
            // The derivative is exactly zero there; this removes its rounding error.
            before[2][axis] = before[3][axis];
            after[1][axis] = after[0][axis];
        }
        split_turns(&before, depth + 1, take);
        split_turns(&after, depth + 1, take);
        return;
    }
    let [a, b, c, d] = *curve;
    let (min, max) = (a.min(d), a.max(d));
    take(&[a, b.clamp(min, max), c.clamp(min, max), d]);
}

/// Cuts a monotone curve at its inflections.
fn split_inflections(curve: &Curve, depth: u32, take: &mut impl FnMut(&Curve)) {
    let [first, middle, last] = [curve[1] - curve[0], curve[2] - curve[1], curve[3] - curve[2]];
    // Bernstein coefficients of the cross product of the first and second derivative.
    let [a, b, c] = [first.perp_dot(middle), 0.5 * first.perp_dot(last), middle.perp_dot(last)];
    let inside = |t: &f64| (END..=1.0 - END).contains(t);
    let turns = solve_quadratic(a, 2.0 * (b - a), a - 2.0 * b + c);
    match turns.into_iter().find(inside) {
        // On a straight line, the roots do not count.
        Some(t) if depth < 2 && [a, b, c] != [0.0; 3] => {
            for part in split(curve, t) {
                split_inflections(&part, depth + 1, take);
            }
        }
        _ => take(curve),
    }
}

/// The parameter at which a coordinate must be cut for its control points to become monotone, and whether the
/// coordinate turns there.
fn cut_of([a, b, c, d]: [f64; 4]) -> Option<(f64, bool)> {
    // Bernstein coefficients of the derivative, divided by 3.
    let (first, middle, last) = (b - a, c - b, d - c);
    let rising = first.max(middle).max(last) > 0.0;
    let falling = first.min(middle).min(last) < 0.0;
    if !(rising && falling) {
        return None;
    }
    let inside = |t: &f64| (END..=1.0 - END).contains(t);
    let turns = solve_quadratic(first, 2.0 * (middle - first), first - 2.0 * middle + last);
    if let Some(t) = turns.into_iter().find(inside) {
        return Some((t, true));
    }
    // The coordinate does not turn, but its derivative, a parabola, comes close to zero. The cut is at the vertex of
    // the parabola: both of its halves have Bernstein coefficients of one sign.
    Some((first - middle) / (first - 2.0 * middle + last)).filter(inside).map(|t| (t, false))
}

/// Cuts a monotone curve where it leaves the domain, and moves the pieces outside onto the border.
fn split_borders(curve: &Curve, depth: u32, curves: &mut Vec<Curve>) {
    // A monotone curve crosses each of the four borders at most once.
    if depth < 4 {
        for (axis, border) in [(0, 0.0), (0, 1.0), (1, 0.0), (1, 1.0)] {
            let side = |point: DVec2| point[axis] - border;
            let (start, end) = (side(curve[0]), side(curve[3]));
            if start.min(end) < 0.0 && start.max(end) > 0.0 {
                let [mut before, mut after] = split(curve, crossing(curve, axis, border));
                before[3][axis] = border;
                after[0][axis] = border;
                split_borders(&before, depth + 1, curves);
                split_borders(&after, depth + 1, curves);
                return;
            }
        }
    }
    let inside = curve.map(onto_border);
    let (min, max) = (inside[0].min(inside[3]), inside[0].max(inside[3]));
    curves.push(inside.map(|point| point.clamp(min, max)));
}

/// Clamps a point to the domain. A coordinate nearer than 5·10⁻⁸ to a border is moved onto it, because curves that
/// are meant to follow the border may be off by rounding.
fn onto_border(point: DVec2) -> DVec2 {
    const NEAR: f64 = 5e-8;
    let coordinate = |x: f64| match x {
        ..NEAR => 0.0,
        x if x > 1.0 - NEAR => 1.0,
        x => x,
    };
    DVec2::new(coordinate(point.x), coordinate(point.y))
}

/// The parameter at which a coordinate of a monotone curve is `value`, which lies between the coordinates of its
/// ends.
fn crossing(curve: &Curve, axis: usize, value: f64) -> f64 {
    let rising = curve[3][axis] > curve[0][axis];
    let segment = Segment::Cubic(*curve);
    let (mut low, mut high) = (0.0, 1.0);
    // More halvings than the significand of `f64` has bits.
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (segment.point(middle)[axis] < value) == rising {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
