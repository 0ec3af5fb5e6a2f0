//! The control points of patches in clip space, and what they tell.

use glam::{DMat4, DVec4};

use super::number::Number;
use super::{Bound, Curvature, ROUNDING_UNIT, Rounding, Screen};

/// From the space of control points to clip space: the matrix row by row.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ToClip([DVec4; 4]);

impl From<DMat4> for ToClip {
    fn from(matrix: DMat4) -> Self {
        Self([0, 1, 2, 3].map(|row| matrix.row(row)))
    }
}

/// The control points (x, y, z, weight) of a patch of `N` × `N`, row by row.
pub(crate) type Points<const N: usize> = [[DVec4; N]; N];

/// The control points of a patch of `N` × `N` or of a part of one in clip space, row by row,
/// multiplied by their weights; or those of two patches side by side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClipNet<const N: usize, T = f64> {
    /// x, y, z, w and the weight.
    axes: [[[T; N]; N]; 5],
    /// Whether the weights may differ from 1.
    weighed: bool,
}

impl<const N: usize, T: Number> ClipNet<N, T> {
    /// Transforms the control points of each lane's patch; all weights are 1 unless it is `weighed`.
    #[inline]
    pub(crate) fn new<'a>(
        points: impl Fn(usize) -> &'a Points<N>,
        weighed: bool,
        to_clip: &ToClip,
    ) -> Self {
        let rows = to_clip.0.map(|m| [m.x, m.y, m.z, m.w].map(T::all));
        let mut net = Self { axes: [[[T::all(1.0); N]; N]; 5], weighed };
        for row in 0..N {
            for column in 0..N {
                let of = |pick: fn(&DVec4) -> f64| T::each(|lane| pick(&points(lane)[row][column]));
                let (x, y, z) = (of(|p| p.x), of(|p| p.y), of(|p| p.z));
                for (axis, m) in net.axes.iter_mut().zip(&rows) {
                    axis[row][column] = m[0] * x + m[1] * y + (m[2] * z + m[3]);
                }
                if weighed {
                    let weight = of(|p| p.w);
                    for axis in &mut net.axes {
                        axis[row][column] = axis[row][column] * weight;
                    }
                }
            }
        }
        net
    }

    /// The control points of one lane.
    pub(crate) fn lane(&self, lane: usize) -> ClipNet<N> {
        let axes = self.axes.map(|axis| axis.map(|row| row.map(|number| number.lane(lane))));
        ClipNet { axes, weighed: self.weighed }
    }

    /// By how much all control points lie outside of one plane of the view's frustum. Above 0 nothing is
    /// seen.
    #[inline]
    pub(crate) fn outside(&self) -> T {
        let w = self.axes[3].as_flattened();
        let mut most = T::all(f64::NEG_INFINITY);
        for axis in &self.axes[..3] {
            let (mut above, mut below) = (T::all(f64::INFINITY), T::all(f64::NEG_INFINITY));
            for (value, w) in axis.as_flattened().iter().zip(w) {
                above = above.least(*value - *w);
                below = below.most(*value + *w);
            }
            most = most.most(above).most(T::all(0.0) - below);
        }
        most
    }

    /// The least weight, and the least clip w of the points themselves.
    fn least_weight_and_depth(&self) -> [T; 2] {
        let [_, _, _, w, weight] = &self.axes;
        let mut least = [T::all(f64::INFINITY); 2];
        for (w, weight) in w.as_flattened().iter().zip(weight.as_flattened()) {
            least = [least[0].least(*weight), least[1].least(*w / *weight)];
        }
        least
    }

    /// Bounds the patches on a screen.
    #[inline]
    pub(crate) fn bound(&self, screen: &Screen, rounding: &Rounding) -> Bound<T> {
        let [x, y, _, w, _] = self.axes.each_ref().map(|axis| axis.as_flattened());
        let (mut least_w, mut greatest_w) = (T::all(f64::INFINITY), T::all(0.0));
        let mut ranges = [[T::all(f64::INFINITY), T::all(f64::NEG_INFINITY)]; 2];
        for ((x, y), w) in x.iter().zip(y).zip(w) {
            least_w = least_w.least(*w);
            greatest_w = greatest_w.most(*w);
            let inverse = T::all(1.0) / *w;
            for (range, value) in ranges.iter_mut().zip([*x, *y]) {
                let value = value * inverse;
                *range = [range[0].least(value), range[1].most(value)];
            }
        }
        let [least_weight, least_depth] =
            if self.weighed { self.least_weight_and_depth() } else { [T::all(1.0), least_w] };
        let seen = [least_w, least_depth, least_weight];
        let of_lane = |lane: usize| {
            let [least_w, least_depth, least_weight] = seen.map(|number| number.lane(lane));
            if least_depth < screen.near {
                Seen::across_near(screen, screen.near * least_weight)
            } else {
                let ranges = ranges.map(|range| range.map(|end| end.lane(lane)));
                Seen::new(screen, least_w, ranges)
            }
        };
        let seen = Seen::side_by_side(of_lane);
        let [uu, uv, vv] = self.squares(&seen);
        let degree = (N - 1) as f64;
        let second = T::all(degree * (degree - 1.0));
        let depth_ratio = greatest_w / seen.nearest;
        let diagonal = T::all(2.0 * screen.half.length());
        let extent = [0, 1].map(|axis| T::all(2.0 * screen.half[axis]) * seen.spread[axis]);
        let extent = (extent[0] * extent[0] + extent[1] * extent[1]).sqrt().least(diagonal);
        // Rasterisers interpolate what is divided by w, in `f32`.
        let interpolation = T::all(ROUNDING_UNIT) * depth_ratio * extent;
        let depth = least_depth.most(T::all(screen.near));
        Bound {
            curvature: Curvature {
                uu: second * uu.sqrt(),
                uv: T::all(degree * degree) * uv.sqrt(),
                vv: second * vv.sqrt(),
            },
            rounding: T::all(rounding.pixels(screen)) / depth + interpolation,
            depth_ratio,
            extent,
            least_depth,
        }
    }

    /// The squares of the largest second differences along u, along both and along v, on the screen.
    #[inline]
    fn squares(&self, seen: &Seen<T>) -> [T; 3] {
        let [x, y, _, w, _] = &self.axes;
        // About the middle of what is seen, in pixels.
        let mut points = [[[T::all(0.0); 3]; N]; N];
        for row in 0..N {
            for column in 0..N {
                let w = w[row][column];
                let about = |axis: usize, value: T| (value - seen.middle[axis] * w) * seen.px[axis];
                points[row][column] = [about(0, x[row][column]), about(1, y[row][column]), w];
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
        let [mut uu, mut uv, mut vv] = [T::all(0.0); 3];
        for row in &along_u {
            for i in 0..N - 2 {
                uu = uu.most(seen.squared(difference(row[i + 1], row[i])));
            }
        }
        for row in 0..N - 1 {
            for (next, here) in along_u[row + 1].iter().zip(&along_u[row]).take(N - 1) {
                uv = uv.most(seen.squared(difference(*next, *here)));
            }
        }
        for i in 0..N - 2 {
            for (next, here) in along_v[i + 1].iter().zip(&along_v[i]) {
                vv = vv.most(seen.squared(difference(*next, *here)));
            }
        }
        [uu, uv, vv]
    }
}

impl<const N: usize> ClipNet<N> {
    /// Whether all control points lie outside of one plane of the view's frustum: nothing is seen.
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
                let [low, high] = halved(&self.axes[axis][row]);
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
                let [low, high] = halved(&self.axes[axis].map(|row| row[column]));
                for row in 0..N {
                    halves[0].axes[axis][row][column] = low[row];
                    halves[1].axes[axis][row][column] = high[row];
                }
            }
        }
        halves
    }
}

/// What is seen of differences of control points; pairs are of x and y.
pub(crate) struct Seen<T> {
    /// Pixels for a unit.
    px: [T; 2],
    /// The middle of the ranges of x/w and y/w.
    middle: [T; 2],
    /// Half of the ranges' lengths.
    spread: [T; 2],
    /// The same in pixels for a unit of w.
    reach: [T; 2],
    /// The least w that can be seen.
    nearest: T,
}

impl Seen<f64> {
    /// For ranges [least, greatest] of x/w and y/w.
    pub(crate) fn new(screen: &Screen, least_w: f64, ranges: [[f64; 2]; 2]) -> Self {
        // Rounding must not narrow the ranges, nor shorten their halves.
        const WIDER: f64 = 1e-15;
        let ranges = ranges
            .map(|[low, high]| [low - WIDER, high + WIDER].map(|value| value.clamp(-1.0, 1.0)));
        let px = (screen.half / least_w).to_array();
        let spread = ranges.map(|[low, high]| 0.5 * (high - low) + WIDER);
        Self {
            px,
            middle: ranges.map(|[low, high]| 0.5 * (low + high)),
            spread,
            reach: [0, 1].map(|axis| px[axis] * spread[axis]),
            nearest: least_w,
        }
    }

    /// |ξ_S − ξ_L| ≤ t follows from |δx| + (1 + t)·|δw| ≤ t·w where w is the near plane's.
    pub(crate) fn across_near(screen: &Screen, near: f64) -> Self {
        let t = std::f64::consts::FRAC_1_SQRT_2 * screen.tolerance / screen.half;
        // Each axis by itself stays within 1/√2 of the tolerance.
        let px = screen.half * std::f64::consts::SQRT_2 / near;
        Self {
            px: px.to_array(),
            middle: [0.0; 2],
            spread: (1.0 + t).to_array(),
            reach: (px * (1.0 + t)).to_array(),
            nearest: near,
        }
    }

    /// The square of the size on the screen of a difference in clip space, at most.
    pub(crate) fn squared_in_clip(&self, [x, y, w]: [f64; 3]) -> f64 {
        let about = |axis: usize, value: f64| (value - self.middle[axis] * w) * self.px[axis];
        self.squared([about(0, x), about(1, y), w])
    }
}

impl<T: Number> Seen<T> {
    #[inline]
    fn side_by_side(of_lane: impl Fn(usize) -> Seen<f64>) -> Self {
        let lanes = [of_lane(0), of_lane(T::LANES - 1)];
        let pair = |pick: fn(&Seen<f64>) -> [f64; 2]| {
            [T::each(|lane| pick(&lanes[lane])[0]), T::each(|lane| pick(&lanes[lane])[1])]
        };
        Self {
            px: pair(|seen| seen.px),
            middle: pair(|seen| seen.middle),
            spread: pair(|seen| seen.spread),
            reach: pair(|seen| seen.reach),
            nearest: T::each(|lane| lanes[lane].nearest),
        }
    }

    /// The square of a difference's size on the screen, at most; x and y are about the middle and in
    /// pixels.
    #[inline]
    fn squared(&self, [x, y, w]: [T; 3]) -> T {
        let w = w.abs();
        let (x, y) = (x.abs() + self.reach[0] * w, y.abs() + self.reach[1] * w);
        x * x + y * y
    }
}

#[inline]
fn difference<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// De Casteljau's algorithm at ½: the control points of both halves.
fn halved<const N: usize>(line: &[f64; N]) -> [[f64; N]; 2] {
    let (mut low, mut high) = (*line, *line);
    for (step, low) in low.iter_mut().enumerate().skip(1) {
        for i in 0..N - step {
            high[i] = 0.5 * (high[i] + high[i + 1]);
        }
        *low = high[0];
    }
    [low, high]
}
