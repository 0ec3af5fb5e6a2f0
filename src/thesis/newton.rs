//! The thesis' trimming by Newton's method, in `f64`: the twin of `glsl/thesis/trim.glsl`, step by
//! step. Keep both in step; `tests/gpu/figures.rs` compares their pictures.
//!
//! It reproduces the limits of the thesis' method on purpose. A loop consists of an upper and a lower curve, both
//! given from the loop's left end to its right end. The two ends lie on one row (figure 28 shows the result if they
//! do not). Where a row misses a curve, Newton's method does not converge and cuts speckles.

use glam::DVec2;

use crate::error::{Error, Result};
use crate::trim::{Keep, Segment, TrimLoop, Trims, inside_loops};

/// When Newton's method stops (listing 10; figures 29–34 vary both values).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Newton {
    iterations: u32,
    epsilon: f64,
}

impl Default for Newton {
    /// The thesis' figures: 10 iterations, a last step below 0.001.
    fn default() -> Self {
        Self { iterations: 10, epsilon: 0.001 }
    }
}

impl Newton {
    /// The maximum number of iterations. With more, no figure changes and a frame takes seconds.
    pub const MAX_ITERATIONS: u32 = 1000;

    /// At most `iterations` steps, ending early after a step in `t` shorter than `epsilon`.
    ///
    /// # Errors
    /// Iterations outside 1…1000, an epsilon that is not finite and above 0.
    pub fn new(iterations: u32, epsilon: f64) -> Result<Self> {
        if !(1..=Self::MAX_ITERATIONS).contains(&iterations) {
            return Err(Error::invalid(
                "newton iterations",
                iterations,
                format!("a whole number from 1 to {}", Self::MAX_ITERATIONS),
            ));
        }
        if !(epsilon.is_finite() && epsilon > 0.0) {
            return Err(Error::invalid("newton epsilon", epsilon, "a finite number above 0"));
        }
        Ok(Self { iterations, epsilon })
    }

    /// The maximum number of steps.
    #[must_use]
    pub const fn iterations(&self) -> u32 {
        self.iterations
    }

    /// The step in `t` below which the search ends.
    #[must_use]
    pub const fn epsilon(&self) -> f64 {
        self.epsilon
    }

    /// The parameter at which the curve meets the row `v`, found by Newton's method from the start value `t` (listing
    /// 10). Without convergence, it is the last iterate.
    fn root<const N: usize>(&self, curve: &[DVec2; N], v: f64, mut t: f64) -> f64 {
        for _ in 0..self.iterations {
            let [value, slope] = value_and_slope(&curve.map(|point| point.y), t);
            let step = (value - v) / slope;
            t -= step;
            if step.abs() < self.epsilon {
                break;
            }
        }
        t
    }

    /// Where the row through `uv` meets the curve, searched from both ends of the curve. For both searches, the `t`
    /// and the u there relative to `uv`.
    fn meetings<const N: usize>(&self, curve: &[DVec2; N], uv: DVec2) -> [(f64, f64); 2] {
        [1.0, 0.0].map(|start| {
            let t = self.root(curve, uv.y, start);
            (t, value_and_slope(&curve.map(|point| point.x), t)[0] - uv.x)
        })
    }

    /// Listing 11: whether `uv` lies between the two points where its row meets the curve.
    fn below<const N: usize>(&self, curve: &[DVec2; N], uv: DVec2) -> bool {
        let [(t1, x1), (t2, x2)] = self.meetings(curve, uv);
        let in_curve = 0.0..=1.0;
        x1 > 0.0 && x2 < 0.0 && in_curve.contains(&t1) && in_curve.contains(&t2)
    }

    /// Listing 12: the same for the outer curve, unless `uv` lies between the points where its row meets the inner
    /// curve. The listing does not test the `t` of those points.
    fn below_outer_only<const N: usize>(
        &self,
        outer: &[DVec2; N],
        inner: &[DVec2; N],
        uv: DVec2,
    ) -> bool {
        let [(_, x3), (_, x4)] = self.meetings(inner, uv);
        self.below(outer, uv) && !(x3 > 0.0 && x4 < 0.0)
    }
}

/// One coordinate of a quadratic or cubic Bézier curve and its derivative, in Bernstein form.
fn value_and_slope<const N: usize>(b: &[f64; N], t: f64) -> [f64; 2] {
    let s = 1.0 - t;
    match *b.as_slice() {
        [b0, b1, b2] => {
            [s * s * b0 + 2.0 * t * s * b1 + t * t * b2, 2.0 * s * (b1 - b0) + 2.0 * t * (b2 - b1)]
        }
        [b0, b1, b2, b3] => [
            s * s * s * b0 + 3.0 * t * s * s * b1 + 3.0 * t * t * s * b2 + t * t * t * b3,
            3.0 * s * s * (b1 - b0) + 6.0 * t * s * (b2 - b1) + 3.0 * t * t * (b3 - b2),
        ],
        _ => unreachable!("the thesis trims by quadratic and cubic curves"),
    }
}

/// The loops of a surface in the four forms of the thesis, with its numbering of the points:
///
/// ```text
///      p1                p1    p2         The nested forms append the inner loop
///    /    \            /          \       in the same order: p4…p7, p6…p11.
///  p0      p2        p0            p3     Curves are p0 p1 p2 and p0 p3 p2,
///    \    /            \          /       or p0 p1 p2 p3 and p0 p4 p5 p3 (listing 9).
///      p3                p4    p5
/// ```
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NewtonTrims {
    /// Loops of two quadratics (`bezierBool`).
    pub quadratic: Vec<[DVec2; 4]>,
    /// A loop of two quadratics inside another (`bezierBool2`).
    pub nested_quadratic: Vec<[DVec2; 8]>,
    /// Loops of two cubics (`cubicBezierBool`).
    pub cubic: Vec<[DVec2; 6]>,
    /// A loop of two cubics inside another (`cubicBezierBool2`).
    pub nested_cubic: Vec<[DVec2; 12]>,
}

impl NewtonTrims {
    /// Sorts loops into the thesis' forms: a loop inside another of its kind makes the nested form with it,
    /// regardless of their order. If loops overlap and neither lies inside the other, each cuts its own inside.
    ///
    /// # Errors
    /// A loop that is not two quadratics or two cubics; islands that the forms cannot hold: two in
    /// one loop, one of another kind, one in an island. Loops are named by their number from 0.
    pub fn from_loops(loops: &[TrimLoop]) -> Result<Self> {
        Self::sorted(loops).map_err(|(_, error)| error)
    }

    /// The same; an error comes with the number of the loop that caused it.
    pub(crate) fn sorted(loops: &[TrimLoop]) -> Result<Self, (usize, Error)> {
        let forms = loops
            .iter()
            .enumerate()
            .map(|(i, trim_loop)| Form::of(trim_loop).ok_or_else(|| (i, unfit(i, trim_loop))))
            .collect::<Result<Vec<_>, _>>()?;
        let mut trims = Self::default();
        for (i, Nesting { around, inside }) in nestings(loops).iter().enumerate() {
            match (around.as_slice(), inside.as_slice()) {
                ([], []) => match forms[i] {
                    Form::Quadratic(points) => trims.quadratic.push(points),
                    Form::Cubic(points) => trims.cubic.push(points),
                },
                ([], [island]) => match (forms[i], forms[*island]) {
                    (Form::Quadratic(outer), Form::Quadratic(inner)) => {
                        trims.nested_quadratic.push(joined(&outer, &inner));
                    }
                    (Form::Cubic(outer), Form::Cubic(inner)) => {
                        trims.nested_cubic.push(joined(&outer, &inner));
                    }
                    _ => return Err((*island, misplaced(i, around, inside))),
                },
                // An island is part of the nested form of the loop around it.
                ([_], []) => {}
                _ => {
                    let last = inside.iter().copied().max().unwrap_or(i);
                    return Err((last, misplaced(i, around, inside)));
                }
            }
        }
        Ok(trims)
    }

    /// Sorts the loops of a surface.
    ///
    /// # Errors
    /// As [`NewtonTrims::from_loops`], and loops whose inside is kept, and paths with rules of their own.
    pub fn of(trims: &Trims) -> Result<Self> {
        if trims.paths.iter().any(|path| !path.loops.is_empty()) {
            return Err(Error::invalid(
                "a path",
                "filled by a rule of its own",
                "loops and paths without one: the thesis' method combines them all by even-odd",
            ));
        }
        if trims.keep == Keep::Inside && !trims.loops.is_empty() {
            return Err(Error::invalid(
                "keep",
                "\"inside\"",
                "\"outside\": the thesis' method can only cut holes",
            ));
        }
        Self::from_loops(&trims.loops)
    }

    /// Every point in the order of the shader's buffer: form after form, loop after loop.
    pub fn points(&self) -> impl Iterator<Item = DVec2> + '_ {
        (self.quadratic.iter().flatten())
            .chain(self.nested_quadratic.iter().flatten())
            .chain(self.cubic.iter().flatten())
            .chain(self.nested_cubic.iter().flatten())
            .copied()
    }

    /// Whether `uv` is cut (listings 11 and 12).
    #[must_use]
    pub fn cut(&self, newton: &Newton, uv: DVec2) -> bool {
        let quadratic = |p: &[DVec2]| [[p[0], p[1], p[2]], [p[0], p[3], p[2]]];
        let cubic = |p: &[DVec2]| [[p[0], p[1], p[2], p[3]], [p[0], p[4], p[5], p[3]]];
        self.quadratic.iter().any(|p| quadratic(p).iter().any(|curve| newton.below(curve, uv)))
            || self.nested_quadratic.iter().any(|p| {
                std::iter::zip(quadratic(&p[..4]), quadratic(&p[4..]))
                    .any(|(outer, inner)| newton.below_outer_only(&outer, &inner, uv))
            })
            || self.cubic.iter().any(|p| cubic(p).iter().any(|curve| newton.below(curve, uv)))
            || self.nested_cubic.iter().any(|p| {
                std::iter::zip(cubic(&p[..6]), cubic(&p[6..]))
                    .any(|(outer, inner)| newton.below_outer_only(&outer, &inner, uv))
            })
    }
}

#[derive(Clone, Copy)]
enum Form {
    Quadratic([DVec2; 4]),
    Cubic([DVec2; 6]),
}

impl Form {
    fn of(trim_loop: &TrimLoop) -> Option<Self> {
        match *trim_loop.segments() {
            [Segment::Quadratic([a, b, c]), Segment::Quadratic([_, d, _])] => {
                Some(Self::Quadratic([a, b, c, d]))
            }
            [Segment::Cubic([a, b, c, d]), Segment::Cubic([_, e, f, _])] => {
                Some(Self::Cubic([a, b, c, d, f, e]))
            }
            _ => None,
        }
    }
}

fn unfit(index: usize, trim_loop: &TrimLoop) -> Error {
    let degrees: Vec<&str> = trim_loop
        .segments()
        .iter()
        .take(5)
        .map(|segment| match segment {
            Segment::Line(_) => "line",
            Segment::Quadratic(_) => "quadratic",
            Segment::Cubic(_) => "cubic",
        })
        .collect();
    let more = if trim_loop.segments().len() > 5 { ", …" } else { "" };
    Error::invalid(
        format!("loop {index}"),
        format!("[{}{more}]", degrees.join(", ")),
        "two quadratics or two cubics, all that the thesis' method can cut",
    )
}

fn misplaced(index: usize, around: &[usize], inside: &[usize]) -> Error {
    let list = |loops: &[usize]| loops.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    let place = match (around, inside) {
        ([], inside) => format!("around loop {}", list(inside)),
        (around, []) => format!("inside loop {}", list(around)),
        _ => format!("inside loop {} and around loop {}", list(around), list(inside)),
    };
    Error::invalid(
        format!("loop {index}"),
        place,
        "one island at most in a loop, of the same kind and without one of its own: all that the \
         thesis' method can cut",
    )
}

/// The numbers of the loops that a loop lies in, and of the loops that lie in it.
#[derive(Clone, Default)]
struct Nesting {
    around: Vec<usize>,
    inside: Vec<usize>,
}

/// The nesting of every loop. A sweep over the bounding boxes from the left compares only loops whose boxes overlap
/// along u.
fn nestings(loops: &[TrimLoop]) -> Vec<Nesting> {
    let boxes: Vec<[DVec2; 2]> = loops.iter().map(TrimLoop::control_box).collect();
    let mut order: Vec<usize> = (0..loops.len()).collect();
    order.sort_by(|a, b| boxes[*a][0].x.total_cmp(&boxes[*b][0].x));
    let mut found = vec![Nesting::default(); loops.len()];
    let mut open: Vec<usize> = Vec::new();
    for new in order {
        open.retain(|old| boxes[*old][1].x >= boxes[new][0].x);
        for &old in &open {
            for (outer, inner) in [(old, new), (new, old)] {
                if holds(&loops[outer], &loops[inner]) {
                    found[outer].inside.push(inner);
                    found[inner].around.push(outer);
                }
            }
        }
        open.push(new);
    }
    found
}

/// Whether every point of `inner`, sampled along its curves, lies inside `outer`.
pub(crate) fn holds(outer: &TrimLoop, inner: &TrimLoop) -> bool {
    const SAMPLES: u32 = 16;
    let ([min, max], [inner_min, inner_max]) = (outer.control_box(), inner.control_box());
    let boxes_meet = min.cmple(inner_max).all() && inner_min.cmple(max).all();
    boxes_meet
        && inner
            .segments()
            .iter()
            .flat_map(|segment| {
                (0..SAMPLES).map(|i| segment.point(f64::from(i) / f64::from(SAMPLES)))
            })
            .all(|point| inside_loops(std::slice::from_ref(outer), point))
}

fn joined<const N: usize, const M: usize>(outer: &[DVec2; N], inner: &[DVec2; N]) -> [DVec2; M] {
    std::array::from_fn(|i| if i < N { outer[i] } else { inner[i - N] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;

    fn lens(half_width: f64, half_height: f64) -> TrimLoop {
        let [left, top] = [dvec2(0.5 - half_width, 0.5), dvec2(0.5, 0.5 + 2.0 * half_height)];
        let [right, bottom] = [dvec2(0.5 + half_width, 0.5), dvec2(0.5, 0.5 - 2.0 * half_height)];
        TrimLoop::new(vec![
            Segment::Quadratic([left, top, right]),
            Segment::Quadratic([right, bottom, left]),
        ])
        .unwrap()
    }

    fn pillow(half_width: f64, half_height: f64) -> TrimLoop {
        let corner = |x: f64, y: f64| dvec2(0.5 + x * half_width, 0.5 + y * half_height);
        TrimLoop::new(vec![
            Segment::Cubic([corner(-1., 0.), corner(-0.8, 1.3), corner(0.8, 1.3), corner(1., 0.)]),
            Segment::Cubic([
                corner(1., 0.),
                corner(0.8, -1.3),
                corner(-0.8, -1.3),
                corner(-1., 0.),
            ]),
        ])
        .unwrap()
    }

    /// The number of samples of a 200×200 grid with |v − ½| in `rows` that are decided wrongly.
    fn wrong(
        trims: &NewtonTrims,
        newton: &Newton,
        loops: &[TrimLoop],
        rows: std::ops::Range<f64>,
    ) -> usize {
        let n = 200;
        (0..n * n)
            .map(|i| dvec2((i % n) as f64 + 0.5, (i / n) as f64 + 0.5) / n as f64)
            .filter(|uv| rows.contains(&(uv.y - 0.5).abs()))
            .filter(|uv| trims.cut(newton, *uv) != inside_loops(loops, *uv))
            .count()
    }

    #[test]
    fn a_level_lens_is_right_on_its_rows_and_speckled_where_no_root_is() {
        let loops = [lens(0.3, 0.2)];
        let trims = NewtonTrims::from_loops(&loops).unwrap();
        assert_eq!(trims.quadratic.len(), 1);
        assert_eq!(trims.points().count(), 4);
        let newton = Newton::default();
        assert_eq!(wrong(&trims, &newton, &loops, 0.0..0.2), 0);
        assert!(wrong(&trims, &newton, &loops, 0.2..0.5) > 500);
    }

    #[test]
    fn fewer_iterations_are_worse_on_rows_that_have_roots() {
        let loops = [pillow(0.3, 0.3)];
        let trims = NewtonTrims::from_loops(&loops).unwrap();
        let misses = [1, 2, 10].map(|iterations| {
            let newton = Newton::new(iterations, 0.001).unwrap();
            wrong(&trims, &newton, &loops, 0.0..0.29)
        });
        assert!(misses[0] > misses[1] && misses[1] > misses[2], "{misses:?}");
        assert_eq!(misses[2], 0);
    }

    #[test]
    fn ends_on_two_rows_and_curves_from_the_right_are_cut_wrong() {
        let tilted = TrimLoop::new(vec![
            Segment::Quadratic([dvec2(0.2, 0.4), dvec2(0.5, 0.9), dvec2(0.8, 0.6)]),
            Segment::Quadratic([dvec2(0.8, 0.6), dvec2(0.5, 0.1), dvec2(0.2, 0.4)]),
        ])
        .unwrap();
        let from_right = TrimLoop::new(vec![
            Segment::Quadratic([dvec2(0.8, 0.5), dvec2(0.5, 0.9), dvec2(0.2, 0.5)]),
            Segment::Quadratic([dvec2(0.2, 0.5), dvec2(0.5, 0.1), dvec2(0.8, 0.5)]),
        ])
        .unwrap();
        for trim_loop in [tilted, from_right] {
            let loops = [trim_loop];
            let trims = NewtonTrims::from_loops(&loops).unwrap();
            assert!(wrong(&trims, &Newton::default(), &loops, 0.0..0.5) > 1000);
        }
    }

    fn counts(loops: &[TrimLoop]) -> [usize; 4] {
        let trims = NewtonTrims::from_loops(loops).unwrap();
        [
            trims.quadratic.len(),
            trims.nested_quadratic.len(),
            trims.cubic.len(),
            trims.nested_cubic.len(),
        ]
    }

    fn moved(trim_loop: &TrimLoop, by: DVec2) -> TrimLoop {
        let segments = trim_loop.segments().iter().map(|segment| {
            let points: Vec<DVec2> = segment.points().iter().map(|point| *point + by).collect();
            Segment::new(&points).unwrap()
        });
        TrimLoop::new(segments.collect()).unwrap()
    }

    #[test]
    fn a_loop_inside_another_is_its_island_in_any_order() {
        let far = dvec2(5.0, 0.0);
        let [outer, inner] = [moved(&pillow(0.4, 0.3), far), moved(&pillow(0.2, 0.1), far)];
        for loops in [
            [lens(0.4, 0.3), lens(0.1, 0.1), outer.clone(), inner.clone()],
            [inner.clone(), lens(0.4, 0.3), outer.clone(), lens(0.1, 0.1)],
        ] {
            assert_eq!(counts(&loops), [0, 1, 0, 1]);
        }
        // Listing 9 runs the lower cubic from left to right: p4 is the one nearer p0.
        let trims = NewtonTrims::from_loops(&[outer, inner]).unwrap();
        assert_eq!(trims.points().count(), 12);
        let p = &trims.nested_cubic[0];
        assert!(p[4].x < p[5].x && p[4].y < p[0].y);
    }

    #[test]
    fn a_loop_beside_another_is_no_island_though_the_boxes_overlap() {
        // The control box of a tall lens is twice as high as the lens.
        let beside = moved(&lens(0.05, 0.05), dvec2(-0.24, 0.38));
        let tall = lens(0.3, 0.44);
        for loops in [[tall.clone(), beside.clone()], [beside.clone(), tall]] {
            assert_eq!(counts(&loops), [2, 0, 0, 0]);
            let trims = NewtonTrims::from_loops(&loops).unwrap();
            assert!(trims.cut(&Newton::default(), dvec2(0.26, 0.9)));
        }
        // Loops that overlap cut their own insides.
        assert_eq!(
            counts(&[lens(0.2, 0.2), moved(&lens(0.2, 0.2), dvec2(0.1, 0.0))]),
            [2, 0, 0, 0]
        );
        // A loop that is given twice makes the same hole twice.
        assert_eq!(counts(&[lens(0.2, 0.2), lens(0.2, 0.2)]), [2, 0, 0, 0]);
    }

    #[test]
    fn thousands_of_loops_with_islands_are_sorted_and_a_late_fault_is_found() {
        let side = 50;
        let mut loops: Vec<TrimLoop> = (0..side * side)
            .flat_map(|i| {
                let place = dvec2(f64::from(i % side), f64::from(i / side));
                [moved(&lens(0.4, 0.4), place), moved(&lens(0.2, 0.2), place)]
            })
            .collect();
        assert_eq!(counts(&loops), [0, 2500, 0, 0]);
        loops.push(lens(0.1, 0.1));
        let (to_blame, _) = NewtonTrims::sorted(&loops).unwrap_err();
        assert_eq!(to_blame, 5000);
    }

    #[test]
    fn a_loop_that_reaches_further_right_does_not_end_the_one_it_overlaps() {
        // From the left: the outer loop, one far above it that reaches further, then the island.
        let outer = lens(0.4, 0.3);
        let above = moved(&lens(0.4, 0.1), dvec2(0.3, 5.0));
        let island = moved(&lens(0.05, 0.05), dvec2(0.1, 0.0));
        assert_eq!(counts(&[outer, above, island]), [1, 1, 0, 0]);
    }

    #[test]
    fn islands_that_the_forms_cannot_hold_are_refused() {
        for loops in [
            vec![lens(0.4, 0.4), pillow(0.1, 0.1)],
            vec![lens(0.4, 0.4), lens(0.3, 0.3), lens(0.1, 0.1)],
            vec![
                lens(0.4, 0.4),
                moved(&lens(0.05, 0.05), dvec2(0.1, 0.0)),
                moved(&lens(0.05, 0.05), dvec2(-0.1, 0.0)),
            ],
        ] {
            let text = NewtonTrims::from_loops(&loops).unwrap_err().to_string();
            assert!(text.contains("loop 0") && text.contains("one island"), "{text}");
        }
    }

    #[test]
    fn an_island_stays() {
        let loops = [pillow(0.4, 0.4), pillow(0.2, 0.2)];
        let trims = NewtonTrims::from_loops(&loops).unwrap();
        let newton = Newton::default();
        assert!(!trims.cut(&newton, dvec2(0.5, 0.55)) && !trims.cut(&newton, dvec2(0.5, 0.45)));
        assert!(trims.cut(&newton, dvec2(0.2, 0.52)) && trims.cut(&newton, dvec2(0.85, 0.48)));
    }

    #[test]
    fn other_loops_are_refused_by_number() {
        let triangle = TrimLoop::new(vec![
            Segment::Line([dvec2(0.1, 0.1), dvec2(0.9, 0.1)]),
            Segment::Line([dvec2(0.9, 0.1), dvec2(0.5, 0.9)]),
            Segment::Line([dvec2(0.5, 0.9), dvec2(0.1, 0.1)]),
        ])
        .unwrap();
        let text = NewtonTrims::from_loops(&[lens(0.3, 0.2), triangle]).unwrap_err().to_string();
        assert!(text.contains("loop 1") && text.contains("line, line, line"), "{text}");
    }

    #[test]
    fn settings_outside_their_range_are_refused() {
        for (iterations, epsilon) in [(0, 0.1), (1001, 0.1), (10, 0.0), (10, f64::NAN), (10, -1.0)]
        {
            assert!(Newton::new(iterations, epsilon).is_err());
        }
    }
}
