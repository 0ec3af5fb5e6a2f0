//! Second derivatives and curvature of patches, in `f64`.

use glam::{DMat3, DVec3, DVec4};

use super::{MAX_SIDE, Patch, SurfacePoint, bernstein, homogeneous};

/// A point of a surface with its first and second derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvedPoint {
    /// The point S(u, v), ∂S/∂u and ∂S/∂v.
    pub at: SurfacePoint,
    /// ∂²S/∂u².
    pub duu: DVec3,
    /// ∂²S/∂u∂v.
    pub duv: DVec3,
    /// ∂²S/∂v².
    pub dvv: DVec3,
}

/// How a surface is curved at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceCurvature {
    /// The Gaussian curvature k₁ k₂, in 1/unit².
    pub gaussian: f64,
    /// The mean curvature (k₁ + k₂) / 2, in 1/unit. It is above 0 where the surface bends towards Su × Sv.
    pub mean: f64,
}

impl SurfaceCurvature {
    /// The principal curvature of larger magnitude, in 1/unit.
    #[must_use]
    pub fn largest(&self) -> f64 {
        let apart = (self.mean * self.mean - self.gaussian).max(0.0).sqrt();
        self.mean + apart.copysign(self.mean)
    }
}

impl CurvedPoint {
    /// By the quotient rule, from the homogeneous point and its derivatives: S, Su, Sv, Suu, Suv, Svv.
    pub(crate) fn of_homogeneous([value, u, v, uu, uv, vv]: [DVec4; 6]) -> Self {
        let position = value.truncate() / value.w;
        let first = |of: DVec4| (of.truncate() - position * of.w) / value.w;
        let (du, dv) = (first(u), first(v));
        let second = |of: DVec4, rest: DVec3| first(of) - rest / value.w;
        Self {
            at: SurfacePoint { position, du, dv },
            duu: second(uu, 2.0 * u.w * du),
            duv: second(uv, u.w * dv + v.w * du),
            dvv: second(vv, 2.0 * v.w * dv),
        }
    }

    /// The derivatives under a linear map. The position stays.
    #[must_use]
    pub fn mapped(&self, map: &DMat3) -> Self {
        let SurfacePoint { position, du, dv } = self.at;
        Self {
            at: SurfacePoint { position, du: *map * du, dv: *map * dv },
            duu: *map * self.duu,
            duv: *map * self.duv,
            dvv: *map * self.dvv,
        }
    }

    /// The curvature, or `None` where the tangents are parallel or one of them vanishes.
    #[must_use]
    pub fn curvature(&self) -> Option<SurfaceCurvature> {
        const PARALLEL: f64 = 1e-12;
        let SurfacePoint { du, dv, .. } = self.at;
        let (e, f, g) = (du.length_squared(), du.dot(dv), dv.length_squared());
        let cross = du.cross(dv);
        let area = cross.length_squared();
        let longest = e.max(g);
        if area <= PARALLEL * PARALLEL * longest * longest || !area.is_finite() {
            return None;
        }
        let normal = cross / area.sqrt();
        let (l, m, n) = (self.duu.dot(normal), self.duv.dot(normal), self.dvv.dot(normal));
        Some(SurfaceCurvature {
            gaussian: (l * n - m * m) / area,
            mean: (e * n - 2.0 * f * m + g * l) / (2.0 * area),
        })
    }
}

impl Patch<'_> {
    /// Value, first and second derivatives at (u, v).
    #[must_use]
    pub fn curved(&self, u: f64, v: f64) -> CurvedPoint {
        let (of_u, of_v) = (orders(self.degree.u(), u), orders(self.degree.v(), v));
        // S, Su, Sv, Suu, Suv, Svv as orders of derivatives.
        const ORDERS: [[usize; 2]; 6] = [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]];
        let mut sums = [DVec4::ZERO; 6];
        for (row, points) in self.points.chunks_exact(self.degree.columns()).enumerate() {
            for (column, point) in points.iter().enumerate() {
                let point = homogeneous(*point);
                for (sum, [along_u, along_v]) in sums.iter_mut().zip(ORDERS) {
                    *sum += point * (of_u[along_u][column] * of_v[along_v][row]);
                }
            }
        }
        CurvedPoint::of_homogeneous(sums)
    }
}

/// The Bernstein polynomials of a degree at t, and their first and second derivatives.
fn orders(degree: usize, t: f64) -> [[f64; MAX_SIDE]; 3] {
    let n = degree as f64;
    let mut of = [[0.0; MAX_SIDE]; 3];
    let [values, slopes, bends] = &mut of;
    for i in 0..=degree {
        // The polynomial of a degree that is lower by `order`, `back` places before i.
        let lower = |order: usize, back: usize| {
            let is_one = degree >= order && i >= back && i - back <= degree - order;
            if is_one { bernstein(degree - order, i - back, t) } else { 0.0 }
        };
        values[i] = bernstein(degree, i, t);
        slopes[i] = n * (lower(1, 1) - lower(1, 0));
        bends[i] = n * (n - 1.0) * (lower(2, 2) - 2.0 * lower(2, 1) + lower(2, 0));
    }
    of
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2};

    use super::*;
    use crate::bezier::{Degree, NurbsSurface};

    /// The control points of the 16 patches of a torus, exactly. The circles around the axis z are u.
    fn torus(major: f64, minor: f64) -> Vec<DVec4> {
        let knots: Vec<f64> = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].map(f64::from).to_vec();
        let circle = |i: usize| {
            let (sin, cos) = (i as f64 * FRAC_PI_2 / 2.0).sin_cos();
            let weight = if i.is_multiple_of(2) { 1.0 } else { FRAC_1_SQRT_2 };
            ([cos / weight, sin / weight], weight)
        };
        let points = (0..81).map(|i| {
            let ((around, one), (tube, other)) = (circle(i % 9), circle(i / 9));
            let from_axis = major + minor * tube[0];
            DVec4::new(from_axis * around[0], from_axis * around[1], minor * tube[1], one * other)
        });
        let knots = [knots.clone(), knots];
        NurbsSurface::new(biquadratic(), knots, points.collect()).unwrap().patches().1
    }

    fn biquadratic() -> Degree {
        Degree::new(2, 2).unwrap()
    }

    #[test]
    fn a_torus_has_its_closed_forms() {
        let (major, minor) = (2.0, 0.5);
        for points in torus(major, minor).chunks_exact(9) {
            let patch = Patch::new(biquadratic(), points);
            for (u, v) in [(0.0, 0.0), (0.3, 0.7), (1.0, 0.4)] {
                let here = patch.curved(u, v);
                let [x, y, _] = here.at.position.to_array();
                let cos = (x.hypot(y) - major) / minor;
                let around = cos / (major + minor * cos);
                let curvature = here.curvature().unwrap();
                // Su × Sv points out of the tube, away from which it bends.
                assert!((curvature.gaussian - around / minor).abs() < 1e-12);
                assert!((curvature.mean + 0.5 * (around + 1.0 / minor)).abs() < 1e-12);
                assert!((curvature.largest() + 1.0 / minor).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn derivatives_are_limits_of_differences() {
        let points: Vec<DVec4> = (0..20)
            .map(|i| {
                let (x, y) = (f64::from(i % 5), f64::from(i / 5));
                DVec4::new(x, y, (1.7 * x).sin() * (0.9 * y).cos(), 1.0 + 0.3 * (x * y).sin())
            })
            .collect();
        let patch = Patch::new(Degree::new(4, 3).unwrap(), &points);
        let (u, v, step) = (0.3, 0.6, 1e-5);
        let here = patch.curved(u, v);
        assert!((here.at.position - patch.at(u, v).position).length() < 1e-14);
        assert!((here.at.du - patch.at(u, v).du).length() < 1e-13);
        assert!((here.at.dv - patch.at(u, v).dv).length() < 1e-13);
        let along = |du: f64, dv: f64| {
            let (before, after) = (patch.at(u - du, v - dv), patch.at(u + du, v + dv));
            [after.du - before.du, after.dv - before.dv].map(|change| change / (2.0 * step))
        };
        let ([uu, vu], [uv, vv]) = (along(step, 0.0), along(0.0, step));
        for (exact, limit) in [(here.duu, uu), (here.duv, vu), (here.duv, uv), (here.dvv, vv)] {
            assert!((exact - limit).length() < 1e-7, "{exact} {limit}");
        }
    }

    #[test]
    fn curvature_is_missing_where_the_tangents_are_parallel_and_shrinks_with_the_size() {
        let points = torus(2.0, 0.5);
        let here = Patch::new(biquadratic(), &points[..9]).curved(0.2, 0.3);
        let larger = here.mapped(&DMat3::from_diagonal(DVec3::splat(1e6)));
        let (one, other) = (here.curvature().unwrap(), larger.curvature().unwrap());
        assert!((other.gaussian * 1e12 / one.gaussian - 1.0).abs() < 1e-12);
        assert!((other.mean * 1e6 / one.mean - 1.0).abs() < 1e-12);
        // Mirrored, it bends to the other side of Su × Sv.
        let mirrored = here.mapped(&DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)));
        assert!((mirrored.curvature().unwrap().mean + one.mean).abs() < 1e-12);
        let at = SurfacePoint { dv: 2.0 * here.at.du, ..here.at };
        assert_eq!(CurvedPoint { at, ..here }.curvature(), None);
    }
}
