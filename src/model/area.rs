//! Integrals over drawn faces, by Gauss quadrature row by row between the places where the loops turn.

use glam::DVec3;

use super::DrawnFace;
use super::evaluate::nurbs_at;
use crate::bezier::SurfacePoint;
use crate::trim::{Keep, Segment};

/// A piece of a loop that rises or falls along v.
struct Monotone<'a> {
    segment: &'a Segment,
    /// Its parameters at the least and the largest v.
    ends: [f64; 2],
    /// The least and the largest v.
    range: [f64; 2],
}

/// Rows of a coarse integral.
const ROWS: u32 = 6;

/// How many points an integral takes.
#[derive(Clone, Copy)]
enum Precision {
    Fine,
    Coarse,
}

/// Points and weights for the interval from 0 to 1.
type Rule = Vec<(f64, f64)>;

impl DrawnFace {
    /// The area of the face. On smooth surfaces the relative error is below 1e-6.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.integral(Precision::Fine, |at| at.du.cross(at.dv).length())
    }

    /// The integral of the distance from a point to the tangent plane, positive where ∂u × ∂v points away from the
    /// point: three times the volume of the cone from the point to the face. The relative error is several per cent.
    pub(super) fn flux(&self, origin: DVec3) -> f64 {
        self.integral(Precision::Coarse, |at| (at.position - origin).dot(at.du.cross(at.dv)))
    }

    /// The integral over the parameters of the face.
    fn integral(&self, precision: Precision, of: impl Fn(&SurfacePoint) -> f64) -> f64 {
        let [low, high] = self.surface.domain();
        let degree = self.surface.degree();
        let [of_u, of_v] = self.surface.knots();
        let inner = |knots: &[f64], degree: usize| knots[degree..knots.len() - degree].to_vec();
        let mut columns = inner(of_u, degree.u());
        let mut rows = inner(of_v, degree.v());
        let segments = self.trims.loops.iter().flat_map(|one| one.segments());
        let pieces: Vec<Monotone<'_>> = segments.flat_map(monotone).collect();
        let (across, along) = match precision {
            Precision::Fine => {
                rows.extend(pieces.iter().flat_map(|piece| piece.range));
                rows.retain(|v| (low.y..=high.y).contains(v));
                rows.sort_by(f64::total_cmp);
                rows.dedup_by(|a, b| (*a - *b).abs() <= 1e-14 * (high.y - low.y));
                // Many rows or columns are short.
                let across = gauss(if rows.len() < 100 { 20 } else { 6 });
                (across, gauss(if columns.len() < 20 { 12 } else { 5 }))
            }
            Precision::Coarse => {
                columns = vec![low.x, high.x];
                rows = (0..=ROWS)
                    .map(|i| low.y + f64::from(i) / f64::from(ROWS) * (high.y - low.y))
                    .collect();
                // Of a polynomial patch of degree p, the integrand has the degree 3 p − 1 along u.
                (gauss(2), gauss((degree.u() as u32 * 3).div_ceil(2).min(5)))
            }
        };
        let mut sum = 0.0;
        for pair in rows.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let middle = from.midpoint(to);
            let is_active =
                |piece: &&Monotone<'_>| piece.range[0] < middle && middle < piece.range[1];
            let active: Vec<&Monotone<'_>> = pieces.iter().filter(is_active).collect();
            for (x, weight) in &across {
                // Near places where a loop turns, the width of the face goes with the root of the distance.
                let v = from + (to - from) * x * x * (3.0 - 2.0 * x);
                let weight = weight * (to - from) * 6.0 * x * (1.0 - x);
                let mut ends: Vec<f64> = active.iter().map(|piece| piece.u_at(v)).collect();
                ends.sort_by(f64::total_cmp);
                if self.trims.loops.is_empty() || self.trims.keep == Keep::Outside {
                    ends.insert(0, low.x);
                    ends.push(high.x);
                }
                for pair in ends.chunks_exact(2) {
                    let range = [pair[0].max(low.x), pair[1].min(high.x)];
                    sum += weight * self.row(v, range, &columns, &along, &of);
                }
            }
        }
        sum
    }

    /// The integral along u at v.
    fn row(
        &self,
        v: f64,
        [from, to]: [f64; 2],
        columns: &[f64],
        rule: &Rule,
        of: &impl Fn(&SurfacePoint) -> f64,
    ) -> f64 {
        let mut sum = 0.0;
        for pair in columns.windows(2) {
            let (low, high) = (pair[0].max(from), pair[1].min(to));
            if low >= high {
                continue;
            }
            for (x, weight) in rule {
                let at = nurbs_at(&self.surface, low + (high - low) * x, v);
                sum += weight * (high - low) * of(&at);
            }
        }
        sum
    }
}

impl Monotone<'_> {
    /// u where the piece has a given v.
    fn u_at(&self, v: f64) -> f64 {
        let [mut low, mut high] = self.ends;
        for _ in 0..60 {
            let middle = low.midpoint(high);
            if self.segment.point(middle).y < v {
                low = middle
            } else {
                high = middle
            }
            if (high - low).abs() < 1e-15 {
                break;
            }
        }
        self.segment.point(low.midpoint(high)).x
    }
}

/// The pieces of a segment between the places where it turns along v.
fn monotone(segment: &Segment) -> Vec<Monotone<'_>> {
    let v: Vec<f64> = segment.points().iter().map(|point| point.y).collect();
    let mut ends = vec![0.0];
    match *v.as_slice() {
        [a, b, c] => ends.extend(roots(0.0, a - 2.0 * b + c, b - a)),
        [a, b, c, d] => {
            ends.extend(roots(d - 3.0 * c + 3.0 * b - a, 2.0 * (c - 2.0 * b + a), b - a));
        }
        _ => {}
    }
    ends.push(1.0);
    ends.sort_by(f64::total_cmp);
    let piece = |pair: &[f64]| {
        let [a, b] = [pair[0], pair[1]];
        let [v_a, v_b] = [a, b].map(|t| segment.point(t).y);
        let (ends, range) = if v_a < v_b { ([a, b], [v_a, v_b]) } else { ([b, a], [v_b, v_a]) };
        Monotone { segment, ends, range }
    };
    ends.windows(2).map(piece).collect()
}

/// The roots of a t² + b t + c between 0 and 1.
fn roots(a: f64, b: f64, c: f64) -> impl Iterator<Item = f64> {
    let root = (b * b - 4.0 * a * c).sqrt();
    let q = -0.5 * (b + root.copysign(b));
    [q / a, c / q].into_iter().filter(|t| 0.0 < *t && *t < 1.0)
}

/// Gauss–Legendre quadrature.
fn gauss(count: u32) -> Rule {
    let n = f64::from(count);
    (0..count)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (f64::from(i) + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..8 {
                let (mut before, mut value) = (1.0, x);
                for k in 2..=count {
                    let k = f64::from(k);
                    (before, value) =
                        (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
                }
                slope = n * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}
