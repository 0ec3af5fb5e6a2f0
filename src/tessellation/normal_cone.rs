//! Computes a cone that contains all normals of a patch, and from it whether a normal may vanish. This is done once,
//! before the first frame.
//!
//! A normal is the cross product of two tangents. The tangents of a polynomial patch are positive sums of its
//! control differences. Those of a rational patch S = A / w have the directions A_u·w − A·w_u, and these are
//! positive sums of that polynomial's Bernstein coefficients. So the cross products of all pairs of these
//! vectors, one along u and one along v, span a cone that holds every normal.

use glam::{DVec3, DVec4, Vec3};

use crate::bezier::{Degree, binomials, homogeneous, split_slice};

/// The form of evaluation that a patch needs. Each kind has its own shader programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PatchKind {
    /// All weights are 1, and no normal vanishes.
    Polynomial,
    /// Weights differ, and no normal vanishes.
    Rational,
    /// A normal may vanish; weights may differ.
    Degenerate,
}

impl PatchKind {
    /// Every kind, by its number.
    pub(crate) const ALL: [Self; 3] = [Self::Polynomial, Self::Rational, Self::Degenerate];
}

/// Normals of a patch, in the space of its control points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NormalCone {
    /// The largest angle between this direction and any normal Su × Sv has the sine below. The axis is zero if no
    /// cone is known, because a normal may vanish.
    axis: Vec3,
    /// Sine of the angle.
    sine: f32,
    /// Whether the patch's weights differ from 1.
    is_rational: bool,
}

/// The viewpoint of a surface, in the space of its control points.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Eye {
    /// The eye at a finite position.
    At(DVec3),
    /// The eye at infinity: the direction towards it.
    Towards(DVec3),
}

impl NormalCone {
    pub(crate) fn new(degree: Degree, points: &[DVec4]) -> Self {
        let (columns, rows) = (degree.columns(), degree.rows());
        let is_rational = points.iter().any(|point| point.w != 1.0);
        let unknown = Self { axis: Vec3::ZERO, sine: 1.0, is_rational };
        let sum = |step: usize, from: usize, count: usize| -> DVec3 {
            (0..count).map(|i| points[from + i * step].truncate()).sum()
        };
        let along_u = sum(columns, columns - 1, rows) - sum(columns, 0, rows);
        let along_v = sum(1, points.len() - columns, columns) - sum(1, 0, columns);
        let Some(axis) = along_u.cross(along_v).try_normalize() else { return unknown };
        // Products of coordinates far from the origin would lose the differences between them.
        let origin = if is_rational { points[0].truncate().extend(0.0) } else { DVec4::ZERO };
        let points = points.iter().map(|point| homogeneous(*point - origin)).collect();
        let net = Net { columns, rows, is_rational, points };
        let tangents = net.tangents();
        let longest = [longest(&tangents[0]), longest(&tangents[1])];
        match net.min_cosine(axis, tangents, longest, 0) {
            Some(cosine) => {
                let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
                // Rounded conservatively.
                Self { axis: axis.as_vec3(), sine: sine as f32 + 1e-5, is_rational }
            }
            None => unknown,
        }
    }

    /// The form of evaluation that the patch needs.
    pub(crate) fn kind(&self) -> PatchKind {
        match (self.axis == Vec3::ZERO, self.is_rational) {
            (true, _) => PatchKind::Degenerate,
            (false, true) => PatchKind::Rational,
            (false, false) => PatchKind::Polynomial,
        }
    }

    /// Whether the patch's weights differ from 1.
    pub(crate) const fn is_rational(&self) -> bool {
        self.is_rational
    }

    /// Whether the whole patch is back-facing: the eye sees the side from which u and v turn clockwise.
    /// `sign` is −1 if the model's matrix mirrors.
    pub(crate) fn faces_away(&self, points: &[DVec4], eye: Eye, sign: f64) -> bool {
        if self.kind() == PatchKind::Degenerate {
            return false;
        }
        let (axis, sine) = (self.axis.as_dvec3() * sign, f64::from(self.sine));
        let away = |to_eye: DVec3| to_eye.dot(axis) < -sine * to_eye.length();
        match eye {
            Eye::Towards(direction) => away(direction),
            // The eye positions from which all normals point away form a convex cone at each point. A property that
            // holds at the control points therefore holds on the patch, which lies in their convex hull.
            Eye::At(place) => points.iter().all(|point| away(place - point.truncate())),
        }
    }
}

/// A net of homogeneous control points.
struct Net {
    columns: usize,
    rows: usize,
    is_rational: bool,
    points: Vec<DVec4>,
}

impl Net {
    /// Vectors of which all tangents along u, and along v, are positive sums, apart from a factor.
    fn tangents(&self) -> [Vec<DVec3>; 2] {
        let (columns, rows) = (self.columns, self.rows);
        let along = |step: usize, size: [usize; 2]| -> Vec<DVec4> {
            (0..size[0] * size[1])
                .map(|i| {
                    let at = i / size[0] * columns + i % size[0];
                    self.points[at + step] - self.points[at]
                })
                .collect()
        };
        let [u_size, v_size] = [[columns - 1, rows], [columns, rows - 1]];
        let (du, dv) = (along(1, u_size), along(columns, v_size));
        if !self.is_rational {
            return [du, dv].map(|net| net.iter().map(|point| point.truncate()).collect());
        }
        [quotient(&du, u_size, self), quotient(&dv, v_size, self)]
    }

    /// The smallest cosine between the axis and any normal; `None` if a normal may vanish or turn further
    /// than the splits can tell. It is found from the net's tangents. `longest` are the longest tangents of the whole
    /// patch, as the split patch has them.
    fn min_cosine(
        &self,
        axis: DVec3,
        [along_u, along_v]: [Vec<DVec3>; 2],
        longest: [f64; 2],
        splits: u32,
    ) -> Option<f64> {
        // Shaders count shorter tangents, relative to the longest, as zero.
        const SHORT: f64 = 2e-3;
        const MIN: f64 = 0.02;
        let mut min = 1.0_f64;
        let mut long = true;
        for a in &along_u {
            long &= a.length() > SHORT * longest[0];
            if !long || min <= MIN {
                break;
            }
            for b in &along_v {
                let normal = a.cross(*b);
                min = min.min(normal.dot(axis) / (a.length() * b.length()));
            }
        }
        long &= along_v.iter().all(|b| b.length() > SHORT * longest[1]);
        // A positive sum of vectors lies no further from the axis than the farthest of them.
        if long && min > MIN {
            return Some(min);
        }
        if splits == self.max_splits() {
            return None;
        }
        let mut min = 1.0_f64;
        for half in self.halves(true) {
            for quarter in half.halves(false) {
                let longest = longest.map(|length| 0.5 * length);
                let tangents = quarter.tangents();
                min = min.min(quarter.min_cosine(axis, tangents, longest, splits + 1)?);
            }
        }
        Some(min)
    }

    /// The maximum number of times that the patch is halved in each direction to narrow its cone. Time grows with the
    /// square of the number of control points.
    const fn max_splits(&self) -> u32 {
        if self.points.len() <= 36 { 3 } else { 1 }
    }

    /// Split at the middle of u or v.
    fn halves(&self, along_u: bool) -> [Self; 2] {
        let Self { columns, rows, is_rational, .. } = *self;
        let place =
            |line: usize, i: usize| if along_u { line * columns + i } else { i * columns + line };
        let (lines, count) = if along_u { (rows, columns) } else { (columns, rows) };
        let mut halves = [self.points.clone(), self.points.clone()];
        for line in 0..lines {
            let mut before: Vec<DVec4> = (0..count).map(|i| self.points[place(line, i)]).collect();
            let mut after = before.clone();
            split_slice(&mut before, &mut after, |a, b| 0.5 * (a + b));
            for i in 0..count {
                halves[0][place(line, i)] = before[i];
                halves[1][place(line, i)] = after[i];
            }
        }
        halves.map(|points| Self { columns, rows, is_rational, points })
    }
}

fn longest(tangents: &[DVec3]) -> f64 {
    tangents.iter().map(|tangent| tangent.length()).fold(0.0, f64::max)
}

/// The Bernstein coefficients of A′·w − A·w′, where (A, w) is the patch of a net and `slopes` are the control
/// points of its derivative, in the given columns and rows.
fn quotient(slopes: &[DVec4], [columns, rows]: [usize; 2], net: &Net) -> Vec<DVec3> {
    // Of coefficients times binomial coefficients, products are convolutions.
    let factors = |columns: usize, rows: usize| {
        binomials(rows).flat_map(move |row| binomials(columns).map(move |column| row * column))
    };
    let slopes = slopes.iter().zip(factors(columns, rows)).map(|(slope, by)| by * *slope);
    let points: Vec<DVec4> =
        net.points.iter().zip(factors(net.columns, net.rows)).map(|(p, by)| by * *p).collect();
    let size = [columns + net.columns - 1, rows + net.rows - 1];
    let mut product = vec![DVec3::ZERO; size[0] * size[1]];
    for (i, slope) in slopes.enumerate() {
        for (row, points) in points.chunks_exact(net.columns).enumerate() {
            let first = (i / columns + row) * size[0] + i % columns;
            for (sum, point) in product[first..].iter_mut().zip(points) {
                *sum += slope.truncate() * point.w - point.truncate() * slope.w;
            }
        }
    }
    product.iter_mut().zip(factors(size[0], size[1])).for_each(|(sum, by)| *sum /= by);
    product
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::Patch;

    /// A quarter of a cylinder along z: the quadratic arc (weights 1, √½, 1) raised to a cubic.
    fn cylinder() -> Vec<DVec4> {
        let s = std::f64::consts::FRAC_1_SQRT_2;
        let (near, far) = (1.0, 2.0 * s / (1.0 + 2.0 * s));
        let w = (1.0 + 2.0 * s) / 3.0;
        let arc = [(1.0, 0.0, 1.0), (near, far, w), (far, near, w), (0.0, 1.0, 1.0)];
        (0..16)
            .map(|i| {
                let (x, y, w) = arc[i % 4];
                DVec4::new(x, y, (i / 4) as f64, w)
            })
            .collect()
    }

    /// The largest angle between the axis and normals of a fine grid, as a sine.
    fn turned(points: &[DVec4], axis: Vec3) -> f64 {
        let patch = Patch::new(Degree::CUBIC, points);
        let places = (0..=32).flat_map(|i| (0..=32).map(move |j| [i, j]));
        places
            .map(|place| {
                let [u, v] = place.map(|i| f64::from(i) / 32.0);
                let normal = patch.normal(u, v).unwrap();
                assert!(normal.dot(axis.as_dvec3()) > 0.0);
                normal.cross(axis.as_dvec3()).length()
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn the_cone_of_a_rational_patch_holds_its_normals() {
        let points = cylinder();
        let cone = NormalCone::new(Degree::CUBIC, &points);
        assert_eq!(cone.kind(), PatchKind::Rational);
        // Normals of a quarter turn by 45 degrees to either side of the middle.
        let turned = turned(&points, cone.axis);
        assert!((turned - 0.5_f64.sqrt()).abs() < 1e-6, "{turned}");
        let sine = f64::from(cone.sine);
        assert!((turned..turned + 0.1).contains(&sine), "{sine}, {turned}");
    }

    #[test]
    fn uneven_weights_turn_normals_no_further_than_the_cone() {
        for seed in 0..200_u32 {
            let noise = |i: u32| {
                let x = (f64::from(seed * 131 + i) * 12.9898).sin() * 43758.5453;
                x - x.floor()
            };
            let points: Vec<DVec4> = (0..16)
                .map(|i| {
                    let (x, y) = (f64::from(i % 4), f64::from(i / 4));
                    let z = 0.8 * noise(i);
                    DVec4::new(x, y, z, 0.3 + 2.0 * noise(i + 16))
                })
                .collect();
            let cone = NormalCone::new(Degree::CUBIC, &points);
            if cone.kind() == PatchKind::Rational {
                assert!(turned(&points, cone.axis) <= f64::from(cone.sine), "{seed}");
            }
        }
    }

    #[test]
    fn the_cone_is_the_same_far_from_the_origin() {
        let here = NormalCone::new(Degree::CUBIC, &cylinder());
        // A power of two, and multiples of its last bit: the points themselves stay exact.
        let far = DVec3::new(1.0, -2.0, 1.0) * 2_f64.powi(46);
        let exact = |point: &DVec4| (point.truncate() * 256.0).round().extend(point.w);
        let near: Vec<DVec4> = cylinder().iter().map(exact).collect();
        let moved: Vec<DVec4> = near.iter().map(|p| (p.truncate() + far).extend(p.w)).collect();
        let [near, moved] = [near, moved].map(|points| NormalCone::new(Degree::CUBIC, &points));
        assert!((near.sine - here.sine).abs() < 0.01);
        assert_eq!(moved, near);
    }

    #[test]
    fn the_back_of_a_rational_patch_is_known() {
        let points = cylinder();
        let cone = NormalCone::new(Degree::CUBIC, &points);
        // u turns from x to y, v runs along z: Su × Sv points outwards.
        let away = |x: f64, y: f64| cone.faces_away(&points, Eye::At(DVec3::new(x, y, 1.5)), 1.0);
        assert!(away(-9.0, -9.0) && !away(9.0, 9.0) && !away(9.0, -9.0));
        let inwards = Eye::Towards(DVec3::new(-1.0, -1.0, 0.0));
        assert!(cone.faces_away(&points, inwards, 1.0) && !cone.faces_away(&points, inwards, -1.0));
    }

    #[test]
    fn a_tip_is_degenerate_with_and_without_weights() {
        for weight in [1.0, 0.7] {
            let mut points = cylinder();
            for point in &mut points {
                point.w = weight;
            }
            let first = points[0];
            points[..4].fill(first);
            let cone = NormalCone::new(Degree::CUBIC, &points);
            assert_eq!(cone.kind(), PatchKind::Degenerate);
            assert_eq!(cone.is_rational(), weight != 1.0);
        }
    }
}
