//! Bounds the screen-space distance between triangles and a patch, from the patch's control points in clip space
//! (Filip, Magedson, Markot 1986, under perspective and for rational patches).
//!
//! Over a triangle whose extent is h₁ along u and h₂ along v, the error of linear interpolation of
//! a function g is at most ⅛(h₁²·max|g_uu| + 2h₁h₂·max|g_uv| + h₂²·max|g_vv|). For a patch of
//! degree n, |g_uu| and |g_vv| are at most n(n − 1) times the largest second difference of the
//! control points in their direction, and |g_uv| is at most n² times the largest mixed difference.
//! The interpolated quantities are the homogeneous clip coordinates x, y and w; those of a rational
//! patch are not divided by its weight. For a point S of the surface, the triangle's point L at the
//! same (u, v), ξ = x/w and δ = S − L,
//!
//! ```text
//! ξ_S − ξ_L = (δx − ξ_L·δw) / S_w
//! ```
//!
//! exactly. It is therefore enough to bound |δx − ξ·δw| and |δy − η·δw|, with η = y/w, for all
//! visible ξ and η. These are convex in ξ and η, so their maxima lie at the ends of the visible
//! ranges.

mod net;
mod number;
mod together;

use glam::{DMat4, DVec2, DVec4, UVec2};

pub(crate) use net::{ClipNet, Points, Seen, ToClip};
use number::Number;
pub(crate) use together::{Candidate, Need, TOGETHER, needs_of};

use crate::bezier::Degree;
use crate::camera::ViewProjection;

/// 2⁻²³, twice the largest relative error of rounding to `f32`, which is 2⁻²⁴. The measured error
/// of evaluating a patch was at most 1.6 · 2⁻²⁴ times the sum of magnitudes in [`Rounding::new`].
const ROUNDING_UNIT: f64 = 1.0 / (1 << 23) as f64;
/// How far a rasterizer may move a vertex, in pixels: it rounds coordinates to multiples of 1/256,
/// so √2/512 ≈ 0.0028.
pub(super) const SUBPIXEL: f64 = 0.003;
/// The share of the tolerance that the levels are computed for. The rest allows for the error of
/// the tessellator's fixed-point coordinates.
const SHARE: f64 = 0.99;

/// The properties of the image that the bound needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Screen {
    /// Half of the width and height: the number of pixels per unit of x/w and of y/w.
    half: DVec2,
    /// The least positive clip w on the near and the far plane, for points of weight 1. Without
    /// one, the `f64::MIN_POSITIVE`.
    near: f64,
    /// Tolerance in pixels.
    tolerance: f64,
}

impl Screen {
    pub(crate) fn new(projection: &ViewProjection, size: UVec2, tolerance: f64) -> Self {
        let (z, w) = (projection.projection.row(2), projection.projection.row(3));
        // Clip w where z = `sign`·w; `depth` is the view-space z there.
        let at = |sign: f64| {
            let depth = (w.w * sign - z.w) / (z.z - w.z * sign);
            w.z * depth + w.w
        };
        let near =
            [at(-1.0), at(1.0)].into_iter().filter(|w| *w > 0.0).fold(f64::INFINITY, f64::min);
        let near = if near.is_finite() { near } else { f64::MIN_POSITIVE };
        Self { half: size.as_dvec2() * 0.5, near, tolerance }
    }

    pub(crate) const fn tolerance(&self) -> f64 {
        self.tolerance
    }

    pub(super) const fn near(&self) -> f64 {
        self.near
    }

    /// The part of the tolerance that the error of rounding leaves to subdivision.
    #[inline(always)]
    pub(super) fn left_by<T: Number>(&self, rounding: T) -> T {
        let all = |value| T::all(rounding.token(), value);
        let left = all(SHARE * self.tolerance - SUBPIXEL) - rounding;
        // If rounding uses up the tolerance, more triangles do not help.
        all(0.1 * self.tolerance).choose_at_most(left, [left, all(0.5 * self.tolerance)])
    }
}

/// Upper bounds of the errors that rounding to `f32` causes in the clip coordinates of a surface's
/// points, for one image.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rounding {
    x: f64,
    y: f64,
    w: f64,
}

impl Rounding {
    /// For control points within ±`extent` that are transformed by `to_clip`.
    pub(crate) fn new(to_clip: &DMat4, extent: f64) -> Self {
        // Control points are rounded, summed and multiplied by a matrix. The error is a few units
        // in the last place of the terms' magnitudes; measured errors stay below this estimate.
        let size = DVec4::new(extent, extent, extent, 1.0);
        let error = |row: DVec4| ROUNDING_UNIT * row.abs().dot(size);
        Self { x: error(to_clip.row(0)), y: error(to_clip.row(1)), w: error(to_clip.row(3)) }
    }

    /// The same for patches of a degree: points of higher degrees are sums of more terms, whose errors grow with the
    /// number of factors. Measured in `f32` as the shaders compute, the largest error of a coordinate grows by factors
    /// of 1.5, 2.0, 2.7 and 3.8 from degree 4 to the degrees 6, 8, 11 and 15.
    pub(crate) fn of_degree(self, degree: Degree) -> Self {
        let factor = (degree.u().max(degree.v()) as f64 / 4.0).max(1.0);
        Self { x: self.x * factor, y: self.y * factor, w: self.w * factor }
    }

    /// The bound as a distance in pixels, for points with w = 1.
    pub(super) fn pixels(&self, screen: &Screen) -> f64 {
        (screen.half * DVec2::new(self.x + self.w, self.y + self.w)).length()
    }
}

/// Curvature of a patch on the screen: upper bounds of its second derivatives, in pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Curvature<T = f64> {
    /// Along u.
    pub(crate) uu: T,
    /// The mixed derivative along u and v.
    pub(crate) uv: T,
    /// Along v.
    pub(crate) vv: T,
}

/// Error bounds derived from the control points of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bound<T = f64> {
    pub(crate) curvature: Curvature<T>,
    /// Upper bound of the rounding error at visible points, in pixels.
    pub(crate) rounding: T,
    /// Ratio of the largest clip w of the control points to the least visible one. In a rational
    /// patch both are multiplied by weights.
    pub(crate) depth_ratio: T,
    /// Diagonal of the patch's possibly visible region on the screen, in pixels.
    pub(crate) extent: T,
    /// The least clip w of the control points, not multiplied by their weights.
    min_depth: T,
}

impl<T: Number> Bound<T> {
    /// The bound of one lane's patch.
    #[inline(always)]
    fn lane(&self, lane: usize) -> Bound {
        let Curvature { uu, uv, vv } = self.curvature;
        Bound {
            curvature: Curvature { uu: uu.lane(lane), uv: uv.lane(lane), vv: vv.lane(lane) },
            rounding: self.rounding.lane(lane),
            depth_ratio: self.depth_ratio.lane(lane),
            extent: self.extent.lane(lane),
            min_depth: self.min_depth.lane(lane),
        }
    }

    /// Upper bound of the distance in pixels between the patch and its triangles, with the given cells along u and v;
    /// infinite where no bound is known.
    #[inline(always)]
    pub(crate) fn error(&self, cells: [T; 2], screen: &Screen) -> T {
        let all = |value| T::all(self.rounding.token(), value);
        let error = self.curvature.error(cells) + self.rounding + all(SUBPIXEL);
        // If the patch crosses the near plane, the bound is valid only up to the tolerance.
        let across_near = error.choose_at_most(all(screen.tolerance), [error, all(f64::INFINITY)]);
        all(screen.near).choose_at_most(self.min_depth, [error, across_near])
    }

    /// The numbers of cells along u and v that keep the patch within the tolerance, unless rounding
    /// uses up nearly all of it: more cells do not reduce the rounding error. Infinite if no bound
    /// is known.
    #[inline(always)]
    pub(crate) fn levels(&self, screen: &Screen) -> [T; 2] {
        self.curvature.levels(screen.left_by(self.rounding))
    }
}

impl<T: Number> Curvature<T> {
    /// Upper bound of the distance in pixels between the patch and its triangles, with the given
    /// cells along u and v and without rounding.
    #[inline(always)]
    pub(crate) fn error(&self, [along_u, along_v]: [T; 2]) -> T {
        let all = |value| T::all(self.uu.token(), value);
        let (h, k) = (all(1.0) / along_u, all(1.0) / along_v);
        (self.uu * h * h + all(2.0) * self.uv * h * k + self.vv * k * k) * all(0.125)
    }

    /// Integer levels along u and v whose error is at most 1 + 10⁻⁹ times the tolerance, with
    /// nearly the fewest cells. The level along v is the least for that along u. They are
    /// floating-point values because they may be arbitrarily large, or infinite.
    #[inline(always)]
    pub(crate) fn levels(&self, tolerance: T) -> [T; 2] {
        let Self { uu, uv, vv } = *self;
        let all = |value| T::all(uu.token(), value);
        let one = all(1.0);
        // Levels in the ratio of the square roots of uu and vv need the fewest triangles. For a
        // patch with only the mixed derivative any ratio does. Values near zero are replaced, to
        // limit the ratio.
        let twist = all(0.3) * uv.sqrt();
        let (a, b) = (uu.sqrt().larger(twist), vv.sqrt().larger(twist));
        // The level n along u, if the level along v is n·b/a.
        let ratio = a / b.larger(all(1e-6) * a).larger(all(f64::MIN_POSITIVE));
        let along_u = (uu + all(2.0) * uv * ratio + vv * ratio * ratio) / (all(8.0) * tolerance);
        let along_u = along_u.sqrt().ceil().larger(one);
        // The least level 1/k along v for this n: vv/8·k² + uv/(4n)·k ≤ rest, where the rest is the
        // part of the tolerance that uu leaves. A small margin keeps the rest positive.
        let rest = tolerance * all(1.0 + 5e-10) - uu / (all(8.0) * along_u * along_u);
        let linear = uv / (all(4.0) * along_u);
        let root = (linear * linear + all(0.5) * vv * rest).sqrt();
        let along_v = ((linear + root) / (all(2.0) * rest)).ceil().larger(one);
        // Level 1 where that is enough, and infinity where no bound is known.
        let (flat, sum) = (self.error([one; 2]), uu + uv + vv);
        let along_u = flat.choose_at_most(tolerance, [one, along_u]);
        let along_v = flat.choose_at_most(tolerance, [one, along_v]);
        let (max, infinite) = (all(f64::MAX), all(f64::INFINITY));
        [sum.choose_at_most(max, [along_u, infinite]), sum.choose_at_most(max, [along_v, infinite])]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::{Patch, bernstein};
    use crate::camera::{Camera, Lens};
    use crate::tessellation::square_nets::{SquareNets, with_side};
    use fearless_simd::Level;
    use glam::{DVec3, dvec2};
    use proptest::prelude::*;

    const SIZE: UVec2 = UVec2::new(640, 400);
    const EXACT: Rounding = Rounding { x: 0.0, y: 0.0, w: 0.0 };

    /// `long` cases if the environment variable asks for a long run, otherwise 500.
    fn cases(long: u32) -> ProptestConfig {
        let is_long = std::env::var_os("FREEFORM_TEST_LONG").is_some();
        ProptestConfig { cases: if is_long { long } else { 500 }, ..ProptestConfig::default() }
    }

    fn points(degree: Degree) -> impl Strategy<Value = Vec<DVec4>> {
        // Bumps of random height; in a quarter of the cases, weights that differ by factors up to
        // 1000.
        let weights = prop_oneof![3 => Just(0.0), 1 => 0.0..3.5_f64];
        let numbers = prop::collection::vec(prop::array::uniform4(-1.0..1.0_f64), degree.points());
        (numbers, 0.0..1.0_f64, weights).prop_map(move |(numbers, rough, spread)| {
            let columns = degree.columns();
            let place = |i: usize, degree: usize| i as f64 / degree as f64 - 0.5;
            let point = |(i, [x, y, z, w]): (usize, &[f64; 4])| {
                let flat =
                    DVec3::new(place(i % columns, degree.u()), place(i / columns, degree.v()), 0.0);
                (flat + rough * DVec3::new(*x, *y, *z)).extend((spread * w).exp())
            };
            numbers.iter().enumerate().map(point).collect()
        })
    }

    /// Patches of the degrees of the thesis and the report, and of all others.
    fn patch() -> impl Strategy<Value = (Degree, Vec<DVec4>)> {
        let any = (1..=Degree::MAX, 1..=Degree::MAX).prop_map(|(u, v)| Degree::new(u, v).unwrap());
        prop_oneof![Just(Degree::CUBIC), Just(Degree::QUARTIC), any]
            .prop_flat_map(|degree| (Just(degree), points(degree)))
    }

    fn projection() -> impl Strategy<Value = ViewProjection> {
        let direction = prop::array::uniform3(-1.0..1.0_f64);
        (direction, 0.1..8.0_f64, any::<bool>()).prop_filter_map("an eye", |(to, far, flat)| {
            let eye = DVec3::from(to).try_normalize()? * far;
            let lens = if flat {
                Lens::Orthographic { height: 2.0 }
            } else {
                Lens::Perspective { fov_y_radians: 0.8 }
            };
            let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, lens).ok()?;
            let corners = [DVec3::splat(-2.0), DVec3::splat(2.0)];
            Some(camera.projection(corners.into_iter(), f64::from(SIZE.x) / f64::from(SIZE.y)))
        })
    }

    /// The homogeneous point of a patch at (u, v).
    fn homogeneous_at(degree: Degree, points: &[DVec4], u: f64, v: f64) -> DVec4 {
        let columns = degree.columns();
        let weigh = |(i, point): (usize, &DVec4)| {
            let weight =
                bernstein(degree.u(), i % columns, u) * bernstein(degree.v(), i / columns, v);
            (point.truncate() * point.w).extend(point.w) * weight
        };
        points.iter().enumerate().map(weigh).sum()
    }

    /// The largest distance on the screen between the patch and random triangles in random cells,
    /// measured at random visible points of the triangles.
    fn measured(
        degree: Degree,
        points: &[DVec4],
        projection: &ViewProjection,
        levels: [f64; 2],
        random: &[[f64; 8]],
    ) -> f64 {
        let to_clip = projection.projection * projection.view;
        let clip = |u: f64, v: f64| to_clip * homogeneous_at(degree, points, u, v);
        let px = |p: DVec4| dvec2(p.x, p.y) / p.w * SIZE.as_dvec2() * 0.5;
        let mut max = 0.0_f64;
        for numbers in random {
            let cell = [0, 1].map(|i| (numbers[i] * levels[i]).floor().min(levels[i] - 1.0));
            // Corners of the cell or points of its upper edge, as a driver may connect them.
            let corners = [2, 3, 4].map(|i| {
                let along = numbers[i] * 4.0;
                let rest = along.fract();
                let (x, y) = match along as u32 {
                    0 => (rest.round(), 0.0),
                    1 => (1.0, rest.round()),
                    2 => (rest, 1.0),
                    _ => (0.0, rest.round()),
                };
                [(cell[0] + x) / levels[0], (cell[1] + y) / levels[1]]
            });
            let sum = numbers[5] + numbers[6] + numbers[7];
            let weights = [5, 6, 7].map(|i| numbers[i] / sum);
            let mut linear = DVec4::ZERO;
            let mut at = [0.0; 2];
            for (corner, weight) in corners.iter().zip(weights) {
                linear += clip(corner[0], corner[1]) * weight;
                at = [0, 1].map(|i| at[i] + corner[i] * weight);
            }
            let w = linear.w;
            let seen = w > 0.0 && [linear.x, linear.y, linear.z].iter().all(|c| c.abs() <= w);
            let point = clip(at[0], at[1]);
            if seen {
                assert!(point.w > 0.0, "a point behind the eye");
                max = max.max(px(linear).distance(px(point)));
            }
        }
        max
    }

    fn patches<const N: usize>(points: &[DVec4]) -> &[Points<N>] {
        points.as_chunks().0.as_chunks().0
    }

    fn net<const N: usize>(points: &[DVec4], to_clip: DMat4) -> ClipNet<N> {
        let is_rational = points.iter().any(|point| point.w != 1.0);
        ClipNet::new((), |_| &patches(points)[0], is_rational, &to_clip.into())
    }

    fn check(
        degree: Degree,
        points: &[DVec4],
        projection: &ViewProjection,
        tolerance: f64,
        random: &[[f64; 8]],
    ) -> Result<(), TestCaseError> {
        let screen = Screen::new(projection, SIZE, tolerance);
        let to_clip = projection.projection * projection.view;
        let nets = SquareNets::new(degree, points);
        let (curvature, outside) = with_side!(nets.side(), N => {
            let net = net::<N>(nets.all(points), to_clip);
            (net.bound(&screen, &EXACT).curvature, net.is_outside())
        });
        let levels = curvature.levels(tolerance);
        prop_assert!(levels.iter().all(|level| *level >= 1.0 && level.fract() == 0.0));
        prop_assert!(curvature.error(levels) <= tolerance * (1.0 + 1e-9));
        let [along_u, along_v] = levels;
        if along_v > 1.0 && along_v.is_finite() {
            let fewer = curvature.error([along_u, along_v - 1.0]);
            prop_assert!(fewer > tolerance * (1.0 - 1e-9), "{fewer} with fewer than {levels:?}");
        }
        let error = measured(degree, points, projection, levels, random);
        prop_assert!(error <= tolerance * (1.0 + 1e-6), "{error} at {levels:?}");
        if outside {
            prop_assert_eq!(measured(degree, points, projection, [1.0; 2], random), 0.0);
            let patch = Patch::new(degree, points);
            for numbers in random {
                let clip = to_clip * patch.at(numbers[0], numbers[1]).position.extend(1.0);
                let inside = clip.truncate().abs().max_element() < clip.w;
                prop_assert!(!inside, "{clip} is seen");
            }
        }
        Ok(())
    }

    /// The instruction set of this processor and those of older ones.
    fn processors() -> Vec<Level> {
        let all = Level::new();
        #[cfg(target_arch = "x86_64")]
        let older = [
            all.as_sse2().map(Level::Sse2),
            all.as_sse4_2().map(Level::Sse4_2),
            all.as_avx2().map(Level::Avx2),
        ];
        #[cfg(not(target_arch = "x86_64"))]
        let older = [None];
        older.into_iter().flatten().chain([all]).collect()
    }

    /// Fails unless the needs of patches computed in lanes equal those of each patch alone, with
    /// every instruction set.
    fn check_side_by_side<const N: usize>(
        all: &[Vec<DVec4>],
        to_clip: DMat4,
        screen: &Screen,
        rounding: &Rounding,
    ) -> Result<(), TestCaseError> {
        let is_rational = |points: &[DVec4]| points.iter().any(|point| point.w != 1.0);
        let alone: Vec<_> = all
            .iter()
            .map(|points| {
                let net = net::<N>(points, to_clip);
                (!net.is_outside()).then(|| Need::new(net.bound(screen, rounding), screen))
            })
            .collect();
        // Their places differ from their order, as if patches between them were culled.
        let candidates: Vec<_> = (0..)
            .zip(all)
            .map(|(i, points): (usize, &Vec<DVec4>)| Candidate {
                points: &patches::<N>(points)[0],
                is_rational: is_rational(points),
                place: TOGETHER - 1 - 2 * i,
            })
            .collect();
        for level in processors() {
            let mut needs = [None; TOGETHER];
            needs_of(level, &candidates, &to_clip.into(), rounding, screen, &mut needs);
            for (candidate, alone) in candidates.iter().zip(&alone) {
                prop_assert_eq!(&needs[candidate.place], alone, "{:?}", level);
            }
        }
        Ok(())
    }

    fn random() -> impl Strategy<Value = Vec<[f64; 8]>> {
        prop::collection::vec(prop::array::uniform8(0.0..1.0_f64), 300)
    }

    proptest! {
        #![proptest_config(cases(20_000))]

        #[test]
        fn no_triangle_of_a_cell_is_further_than_the_tolerance(
            (degree, points) in patch(),
            projection in projection(),
            tolerance in prop_oneof![Just(0.25), Just(0.5), Just(2.0), 0.05..10.0_f64],
            random in random(),
        ) {
            check(degree, &points, &projection, tolerance, &random)?;
        }

        #[test]
        fn patches_side_by_side_are_bounded_as_each_alone(
            patches in prop_oneof![
                prop::collection::vec(points(Degree::CUBIC), 1..20),
                prop::collection::vec(points(Degree::QUARTIC), 1..20),
            ],
            projection in projection(),
        ) {
            let to_clip = projection.projection * projection.view;
            let screen = Screen::new(&projection, SIZE, 0.5);
            let rounding = Rounding::new(&to_clip, 1.0);
            match patches[0].len() {
                16 => check_side_by_side::<4>(&patches, to_clip, &screen, &rounding)?,
                _ => check_side_by_side::<5>(&patches, to_clip, &screen, &rounding)?,
            }
        }

        #[test]
        fn halves_are_parts_of_the_patch(
            points in points(Degree::QUARTIC),
            projection in projection(),
            random in random(),
        ) {
            let to_clip = projection.projection * projection.view;
            let net = net::<5>(&points, to_clip);
            let [_, quarter] = net.halves_along_u()[1].halves_along_v();
            for numbers in &random[..10] {
                let [u, v] = [numbers[0], numbers[1]];
                let expected = to_clip
                    * homogeneous_at(Degree::QUARTIC, &points, 0.5 + 0.5 * u, 0.5 + 0.5 * v);
                for (axis, expected) in quarter.axes().iter().zip(expected.to_array()) {
                    let found: f64 = (0..25)
                        .map(|i| bernstein(4, i % 5, u) * bernstein(4, i / 5, v) * axis[i / 5][i % 5])
                        .sum();
                    prop_assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()));
                }
            }
        }
    }

    #[test]
    fn lanes_have_the_levels_of_their_curvatures() {
        let values = [0.0, 1e-300, 1.0, 3.0, 200.0, 1e300, f64::INFINITY, f64::NAN];
        let of =
            |i: usize| Curvature { uu: values[i / 64], uv: values[i / 8 % 8], vv: values[i % 8] };
        for processor in processors() {
            fearless_simd::dispatch!(processor, simd => check_lanes(simd, of));
        }
    }

    #[inline(always)]
    fn check_lanes<S: fearless_simd::Simd>(simd: S, of: impl Fn(usize) -> Curvature) {
        let lanes = number::Lanes::<S>::LANES;
        for first in (0..512).step_by(lanes) {
            let each = |pick: fn(Curvature) -> f64| {
                number::Lanes::each(simd, |lane| pick(of(first + lane)))
            };
            let all = Curvature { uu: each(|c| c.uu), uv: each(|c| c.uv), vv: each(|c| c.vv) };
            let levels = all.levels(number::Lanes::all(simd, 0.5));
            for lane in 0..lanes {
                let alone = of(first + lane);
                assert_eq!(levels.map(|level| level.lane(lane)), alone.levels(0.5), "{alone:?}");
            }
        }
    }

    #[test]
    fn what_rounding_leaves_is_shared_out() {
        let projection =
            Camera::new(DVec3::Z, DVec3::ZERO, DVec3::Y, Lens::Orthographic { height: 2.0 })
                .unwrap()
                .projection([DVec3::splat(-1.0), DVec3::splat(1.0)].into_iter(), 1.6);
        let screen = Screen::new(&projection, SIZE, 0.5);
        let levels = |rounding| {
            let curvature = Curvature { uu: 128.0, uv: 0.0, vv: 0.0 };
            let bound =
                Bound { curvature, rounding, depth_ratio: 1.0, extent: 9.0, min_depth: 1.0 };
            let levels = bound.levels(&screen);
            (levels, bound.error(levels, &screen))
        };
        assert_eq!(levels(0.0).0, [6.0, 1.0]);
        // A quarter of the tolerance is left for the cells: twice as many are needed.
        let (finer, error) = levels(0.375);
        assert_eq!(finer, [12.0, 1.0]);
        assert!(error <= 0.5, "{error}");
        // If too little is left, half of the tolerance is used.
        for much in [0.45, 3.0, f64::INFINITY, f64::NAN] {
            assert_eq!(levels(much).0, [8.0, 1.0], "{much}");
        }
    }

    #[test]
    fn levels_of_simple_curvatures() {
        let levels = |uu, uv, vv| Curvature { uu, uv, vv }.levels(0.5);
        assert_eq!(levels(0.0, 0.0, 0.0), [1.0, 1.0]);
        assert_eq!(levels(400.0, 0.0, 0.0), [10.0, 1.0]);
        assert_eq!(levels(0.0, 0.0, 900.0), [1.0, 15.0]);
        let [u, v] = levels(0.0, 200.0, 0.0);
        assert!(u * v >= 100.0 && u * v <= 132.0, "{u} {v}");
        // Curved in one direction, with negligible curvature in the others.
        assert_eq!(levels(399.0, 0.0, 1e-20), [10.0, 1.0]);
        assert_eq!(levels(400.0, 1e-30, 0.0), [10.0, 1.0]);
        assert_eq!(levels(1e-300, 1e-300, 900.0), [1.0, 15.0]);
        assert_eq!(levels(1e-300, 0.0, 0.0), [1.0, 1.0]);
        assert_eq!(levels(f64::INFINITY, 1.0, 1.0), [f64::INFINITY; 2]);
        assert_eq!(levels(f64::NAN, 1.0, 1.0), [f64::INFINITY; 2]);
    }
}
