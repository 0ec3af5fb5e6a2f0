//! The control points of patches in clip space, and the error bounds that follow from them.

use glam::{DMat4, DVec4};

use super::number::Number;
use super::{Bound, Curvature, ROUNDING_UNIT, Rounding, Screen};
use crate::bezier::split;

/// The matrix from the space of the control points to clip space, row by row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ToClip([DVec4; 4]);

impl From<DMat4> for ToClip {
    fn from(matrix: DMat4) -> Self {
        Self([0, 1, 2, 3].map(|row| matrix.row(row)))
    }
}

/// The control points (x, y, z, weight) of a patch of `N` × `N`, row by row.
pub(crate) type Points<const N: usize> = [[DVec4; N]; N];

/// The `N` × `N` control points of a patch or sub-patch in clip space, row by row, multiplied by
/// their weights. If `T` has lanes, those of one patch in each lane.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClipNet<const N: usize, T = f64> {
    /// x, y, z, w and the weight.
    axes: [[[T; N]; N]; 5],
    /// Whether the weights may differ from 1.
    is_rational: bool,
}

impl<const N: usize, T: Number> ClipNet<N, T> {
    /// Transforms the control points of each lane's patch. Unless `is_rational`, all weights must
    /// be 1.
    #[inline(always)]
    pub(crate) fn new<'a>(
        token: T::Token,
        points: impl Fn(usize) -> &'a Points<N>,
        is_rational: bool,
        to_clip: &ToClip,
    ) -> Self {
        let mut rows = [[T::all(token, 0.0); 4]; 4];
        for (row, values) in rows.iter_mut().zip(&to_clip.0) {
            for (number, value) in row.iter_mut().zip(values.to_array()) {
                *number = T::all(token, value);
            }
        }
        let mut net = Self { axes: [[[T::all(token, 1.0); N]; N]; 5], is_rational };
        for row in 0..N {
            for column in 0..N {
                let point = |lane: usize| points(lane)[row][column];
                let x = T::each(token, |lane| point(lane).x);
                let y = T::each(token, |lane| point(lane).y);
                let z = T::each(token, |lane| point(lane).z);
                for (axis, m) in net.axes.iter_mut().zip(&rows) {
                    axis[row][column] = m[0] * x + m[1] * y + (m[2] * z + m[3]);
                }
                if is_rational {
                    let weight = T::each(token, |lane| point(lane).w);
                    for axis in &mut net.axes {
                        axis[row][column] = axis[row][column] * weight;
                    }
                }
            }
        }
        net
    }

    #[inline(always)]
    fn token(&self) -> T::Token {
        self.axes[0][0][0].token()
    }

    /// Above 0 if all control points lie outside of one plane of the view frustum, so that nothing
    /// of the patch is visible.
    #[inline(always)]
    pub(crate) fn outside(&self) -> T {
        let token = self.token();
        let w = self.axes[3].as_flattened();
        let mut max = T::all(token, f64::NEG_INFINITY);
        for axis in &self.axes[..3] {
            let mut above = T::all(token, f64::INFINITY);
            let mut below = T::all(token, f64::NEG_INFINITY);
            for (value, w) in axis.as_flattened().iter().zip(w) {
                above = above.smaller(*value - *w);
                below = below.larger(*value + *w);
            }
            max = max.larger(above).larger(T::all(token, 0.0) - below);
        }
        max
    }

    /// The least weight, and the least clip w not multiplied by the weight.
    #[inline(always)]
    fn least_weight_and_depth(&self) -> [T; 2] {
        let [_, _, _, w, weight] = &self.axes;
        let mut min = [T::all(self.token(), f64::INFINITY); 2];
        for (w, weight) in w.as_flattened().iter().zip(weight.as_flattened()) {
            min = [min[0].smaller(*weight), min[1].smaller(*w / *weight)];
        }
        min
    }

    /// The error bounds of the patches on a screen.
    #[inline(always)]
    pub(crate) fn bound(&self, screen: &Screen, rounding: &Rounding) -> Bound<T> {
        let token = self.token();
        let [x, y, _, w, _] = &self.axes;
        let (x, y, w) = (x.as_flattened(), y.as_flattened(), w.as_flattened());
        let (mut min_w, mut max_w) = (T::all(token, f64::INFINITY), T::all(token, 0.0));
        let empty = [T::all(token, f64::INFINITY), T::all(token, f64::NEG_INFINITY)];
        let mut ranges = [empty; 2];
        for ((x, y), w) in x.iter().zip(y).zip(w) {
            min_w = min_w.smaller(*w);
            max_w = max_w.larger(*w);
            let inverse = T::all(token, 1.0) / *w;
            for (range, value) in ranges.iter_mut().zip([*x, *y]) {
                let value = value * inverse;
                *range = [range[0].smaller(value), range[1].larger(value)];
            }
        }
        let [min_weight, min_depth] = if self.is_rational {
            self.least_weight_and_depth()
        } else {
            [T::all(token, 1.0), min_w]
        };
        let near = T::all(token, screen.near);
        let seen = Seen::new(screen, min_w, ranges);
        let across_near = Seen::across_near(screen, near * min_weight);
        let seen = seen.choose_if_at_most([near, min_depth], &across_near);
        let [uu, uv, vv] = self.squares(&seen);
        let degree = (N - 1) as f64;
        let second = T::all(token, degree * (degree - 1.0));
        let depth_ratio = max_w / seen.nearest;
        let diagonal = T::all(token, 2.0 * screen.half.length());
        let width = T::all(token, 2.0 * screen.half.x) * seen.spread[0];
        let height = T::all(token, 2.0 * screen.half.y) * seen.spread[1];
        let extent = (width * width + height * height).sqrt().smaller(diagonal);
        // Rasterizers interpolate quotients by w, in `f32`.
        let interpolation = T::all(token, ROUNDING_UNIT) * depth_ratio * extent;
        let depth = min_depth.larger(near);
        Bound {
            curvature: Curvature {
                uu: second * uu.sqrt(),
                uv: T::all(token, degree * degree) * uv.sqrt(),
                vv: second * vv.sqrt(),
            },
            rounding: T::all(token, rounding.pixels(screen)) / depth + interpolation,
            depth_ratio,
            extent,
            min_depth,
        }
    }

    /// Upper bounds of the squared second differences on the screen, in pixels: along u, mixed,
    /// along v.
    #[inline(always)]
    fn squares(&self, seen: &Seen<T>) -> [T; 3] {
        let zero = T::all(self.token(), 0.0);
        let [x, y, _, w, _] = &self.axes;
        // Relative to the middle of the visible range, in pixels.
        let mut points = [[[zero; 3]; N]; N];
        for row in 0..N {
            for column in 0..N {
                let w = w[row][column];
                let at = [x[row][column], y[row][column], w];
                points[row][column] = seen.about_middle(at);
            }
        }
        let (mut along_u, mut along_v) = (points, points);
        for row in 0..N {
            for i in 0..N - 1 {
                along_u[row][i] = difference(points[row][i + 1], points[row][i]);
            }
        }
        for i in 0..N - 1 {
            for column in 0..N {
                along_v[i][column] = difference(points[i + 1][column], points[i][column]);
            }
        }
        let [mut uu, mut uv, mut vv] = [zero; 3];
        for row in &along_u {
            for i in 0..N - 2 {
                uu = uu.larger(seen.squared(difference(row[i + 1], row[i])));
            }
        }
        for row in 0..N - 1 {
            for (next, here) in along_u[row + 1].iter().zip(&along_u[row]).take(N - 1) {
                uv = uv.larger(seen.squared(difference(*next, *here)));
            }
        }
        for i in 0..N - 2 {
            for (next, here) in along_v[i + 1].iter().zip(&along_v[i]) {
                vv = vv.larger(seen.squared(difference(*next, *here)));
            }
        }
        [uu, uv, vv]
    }
}

impl<const N: usize> ClipNet<N> {
    /// Whether all control points lie outside of one plane of the view frustum, so that nothing is
    /// visible.
    pub(crate) fn is_outside(&self) -> bool {
        self.outside() > 0.0
    }

    /// x, y, z, w and the weight of the control points.
    #[cfg(test)]
    pub(super) const fn axes(&self) -> &[[[f64; N]; N]; 5] {
        &self.axes
    }

    /// The halves, cut at the middle of u.
    pub(crate) fn halves_along_u(&self) -> [Self; 2] {
        let mut halves = [*self; 2];
        for axis in 0..5 {
            for row in 0..N {
                let [low, high] = split(&self.axes[axis][row], middle);
                halves[0].axes[axis][row] = low;
                halves[1].axes[axis][row] = high;
            }
        }
        halves
    }

    /// The halves, cut at the middle of v.
    pub(crate) fn halves_along_v(&self) -> [Self; 2] {
        let mut halves = [*self; 2];
        for axis in 0..5 {
            for column in 0..N {
                let [low, high] = split(&self.axes[axis].map(|row| row[column]), middle);
                for row in 0..N {
                    halves[0].axes[axis][row][column] = low[row];
                    halves[1].axes[axis][row][column] = high[row];
                }
            }
        }
        halves
    }
}

/// The visible ranges of x/w, y/w and w of a patch. They bound the size of a difference (δx, δy,
/// δw) of control points on the screen. Pairs are for x and y.
pub(crate) struct Seen<T> {
    /// Pixels per unit of clip x and y, at most.
    px: [T; 2],
    /// The middle of the ranges of x/w and y/w.
    middle: [T; 2],
    /// Half of the ranges' lengths.
    spread: [T; 2],
    /// The product `px` · `spread`: pixels per unit of w.
    reach: [T; 2],
    /// The least visible clip w; in a rational patch multiplied by the weight.
    nearest: T,
}

impl Seen<f64> {
    /// Upper bound of the squared size on the screen of a difference in clip space.
    pub(crate) fn squared_in_clip(&self, difference: [f64; 3]) -> f64 {
        self.squared(self.about_middle(difference))
    }
}

impl<T: Number> Seen<T> {
    /// For a patch in front of the near plane, with the least w and the ranges [least, greatest] of
    /// x/w and y/w of its control points. The ranges are clipped to the screen.
    #[inline(always)]
    pub(crate) fn new(screen: &Screen, min_w: T, ranges: [[T; 2]; 2]) -> Self {
        // Added to ranges and half lengths, so that rounding cannot make them smaller.
        const WIDER: f64 = 1e-15;
        let token = min_w.token();
        let (wider, one) = (T::all(token, WIDER), T::all(token, 1.0));
        let (half, minus_one) = (T::all(token, 0.5), T::all(token, -1.0));
        let mut px = [one; 2];
        let (mut middle, mut spread, mut reach) = (px, px, px);
        for axis in 0..2 {
            let low = (ranges[axis][0] - wider).larger(minus_one).smaller(one);
            let high = (ranges[axis][1] + wider).larger(minus_one).smaller(one);
            px[axis] = T::all(token, screen.half[axis]) / min_w;
            middle[axis] = half * (low + high);
            spread[axis] = half * (high - low) + wider;
            reach[axis] = px[axis] * spread[axis];
        }
        Self { px, middle, spread, reach, nearest: min_w }
    }

    /// For a patch that crosses the near plane, where w is `near`. At visible points of a triangle
    /// |δx| + (1 + t)·|δw| ≤ t·near implies |ξ_S − ξ_L| ≤ t, with the symbols of the parent module.
    /// The bound is therefore valid only if it is at most the tolerance.
    #[inline(always)]
    pub(crate) fn across_near(screen: &Screen, near: T) -> Self {
        let token = near.token();
        let mut px = [near; 2];
        let (mut spread, mut reach) = (px, px);
        for axis in 0..2 {
            let t = std::f64::consts::FRAC_1_SQRT_2 * screen.tolerance / screen.half[axis];
            // The tolerance divided by √2 for each axis.
            px[axis] = T::all(token, screen.half[axis] * std::f64::consts::SQRT_2) / near;
            spread[axis] = T::all(token, 1.0 + t);
            reach[axis] = px[axis] * spread[axis];
        }
        Self { px, middle: [T::all(token, 0.0); 2], spread, reach, nearest: near }
    }

    /// Chooses `self` in lanes where a ≤ b, and `other` elsewhere.
    #[inline(always)]
    fn choose_if_at_most(&self, [a, b]: [T; 2], other: &Self) -> Self {
        let of = |this: T, other: T| a.choose_at_most(b, [this, other]);
        let pair = |this: [T; 2], other: [T; 2]| [of(this[0], other[0]), of(this[1], other[1])];
        Self {
            px: pair(self.px, other.px),
            middle: pair(self.middle, other.middle),
            spread: pair(self.spread, other.spread),
            reach: pair(self.reach, other.reach),
            nearest: of(self.nearest, other.nearest),
        }
    }

    /// A point or a difference of points in clip space, with x and y in pixels relative to the
    /// middle of the visible range.
    #[inline(always)]
    fn about_middle(&self, [x, y, w]: [T; 3]) -> [T; 3] {
        [(x - self.middle[0] * w) * self.px[0], (y - self.middle[1] * w) * self.px[1], w]
    }

    /// Upper bound of the squared size on the screen of a difference returned by `about_middle`.
    #[inline(always)]
    fn squared(&self, [x, y, w]: [T; 3]) -> T {
        let w = w.abs();
        let (x, y) = (x.abs() + self.reach[0] * w, y.abs() + self.reach[1] * w);
        x * x + y * y
    }
}

fn middle(a: f64, b: f64) -> f64 {
    0.5 * (a + b)
}

#[inline(always)]
fn difference<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
