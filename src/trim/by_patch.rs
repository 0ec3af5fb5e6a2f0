//! Trims of a surface of several patches: what they do to each patch, in coordinates of the patch.
//!
//! `f32` then resolves a small fraction of each patch, however many patches the domain has and however far its
//! parameters are from 0. The patches are halved again and again, with the trims that reach each half. What lies beyond
//! one side of a half may run there as it likes: only its ends matter to the winding numbers within. So consecutive
//! curves beyond a side become one line, and few curves remain where there is little to decide.

use glam::DVec2;

use super::shapes::{Shape, shapes_of};
use super::{Ellipse, FillRule, Keep, Rect, Segment, TrimLoop, TrimPath, Trims};
use crate::bezier::{bounding_box, split};

/// What trims do to a patch.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum PatchTrims {
    /// They cut nothing of it.
    Kept,
    /// They cut all of it.
    Gone,
    /// They may cut a part of it. The trims are in coordinates that run from 0 to 1 along the patch.
    Cut(Box<Trims>),
}

/// What trims do to each patch of a grid, row by row. `columns` and `rows` are the parameters where the patches begin
/// and end.
pub(crate) fn trims_by_patch(
    trims: &Trims,
    columns: &[[f64; 2]],
    rows: &[[f64; 2]],
) -> Vec<PatchTrims> {
    let mut by_patch = vec![PatchTrims::Kept; columns.len() * rows.len()];
    let mut grid = Grid { columns, rows, keep: trims.keep, by_patch: &mut by_patch };
    let cuts_loops = trims.loops_on && trims.has_loops();
    let fills = trims.fills().filter(|_| cuts_loops).map(|fill| Fill {
        loops: fill.loops.iter().map(|one| one.segments().to_vec()).collect(),
        rule: fill.rule,
    });
    let content = Content {
        fills: fills.collect(),
        outside: cuts_loops && trims.keep == Keep::Inside,
        shapes: shapes_of(trims).collect(),
    };
    grid.divide([0, 0], [columns.len(), rows.len()], content);
    by_patch
}

/// Loops that are filled together.
#[derive(Debug, Clone)]
struct Fill {
    loops: Vec<Vec<Segment>>,
    rule: FillRule,
}

/// The trims that reach a block of patches.
#[derive(Debug, Clone)]
struct Content {
    fills: Vec<Fill>,
    /// Whether points outside of all fills are cut.
    outside: bool,
    shapes: Vec<Shape>,
}

struct Grid<'a> {
    columns: &'a [[f64; 2]],
    rows: &'a [[f64; 2]],
    keep: Keep,
    by_patch: &'a mut [PatchTrims],
}

impl Grid<'_> {
    /// Decides about the patches of the columns and rows from `first` up to, but not including, `end`.
    fn divide(&mut self, first: [usize; 2], end: [usize; 2], mut content: Content) {
        let block = [
            DVec2::new(self.columns[first[0]][0], self.rows[first[1]][0]),
            DVec2::new(self.columns[end[0] - 1][1], self.rows[end[1] - 1][1]),
        ];
        content.limit_to(block);
        if content.shapes.iter().any(|shape| shape.covers(block)) {
            return self.set(first, end, &PatchTrims::Gone);
        }
        if content.fills.is_empty() && (content.outside || content.shapes.is_empty()) {
            let decided = if content.outside { PatchTrims::Gone } else { PatchTrims::Kept };
            return self.set(first, end, &decided);
        }
        let counts = [end[0] - first[0], end[1] - first[1]];
        if counts == [1, 1] {
            let trims = content.in_patch(block, self.keep);
            return self.set(first, end, &PatchTrims::Cut(Box::new(trims)));
        }
        let axis = usize::from(counts[1] > counts[0]);
        let (mut middle_end, mut middle_first) = (end, first);
        middle_end[axis] = first[axis] + counts[axis] / 2;
        middle_first[axis] = middle_end[axis];
        self.divide(first, middle_end, content.clone());
        self.divide(middle_first, end, content);
    }

    fn set(&mut self, first: [usize; 2], end: [usize; 2], decided: &PatchTrims) {
        for row in first[1]..end[1] {
            for column in first[0]..end[0] {
                self.by_patch[row * self.columns.len() + column] = decided.clone();
            }
        }
    }
}

impl Content {
    /// Leaves out what does not matter within a block.
    fn limit_to(&mut self, block: [DVec2; 2]) {
        self.shapes.retain(|shape| shape.touches(block));
        let mut is_inside = false;
        self.fills.retain_mut(|fill| {
            let mut touches = false;
            let middle = block[0].midpoint(block[1]);
            let around = |segments: &[Segment]| -> i32 {
                segments.iter().map(|segment| super::ray_crossings(segment, middle)).sum()
            };
            fill.loops.retain_mut(|one| {
                let reaches;
                (*one, reaches) = limited(one, block);
                touches |= reaches;
                reaches || around(one) != 0
            });
            if !touches {
                let number = fill.loops.iter().map(|one| around(one)).sum();
                is_inside |= fill.rule.fills(number);
            }
            touches
        });
        if is_inside {
            // Inside one fill, the others do not matter.
            self.fills.clear();
            self.outside = !self.outside;
        }
    }

    /// The trims in coordinates that run from 0 to 1 along a patch.
    fn in_patch(&self, [low, high]: [DVec2; 2], keep: Keep) -> Trims {
        let size = high - low;
        let local = |place: DVec2| (place - low) / size;
        let loops_of = |fill: &Fill| -> Vec<TrimLoop> {
            let loops = fill.loops.iter().filter(|segments| !segments.is_empty());
            let moved = loops.map(|segments| TrimLoop {
                segments: segments.iter().map(|segment| segment.map(local)).collect(),
            });
            moved.collect()
        };
        let mut trims = Trims { keep, ..Trims::default() };
        for fill in &self.fills {
            match fill.rule {
                FillRule::EvenOdd if self.fills.len() == 1 => trims.loops = loops_of(fill),
                rule => trims.paths.push(TrimPath { loops: loops_of(fill), rule }),
            }
        }
        for shape in &self.shapes {
            match *shape {
                Shape::Ellipse(Ellipse { center, radii }) => {
                    trims.ellipses.push(Ellipse { center: local(center), radii: radii / size });
                }
                Shape::Rect(Rect { u, v }) => {
                    let (from, to) = (local(DVec2::new(u.x, v.x)), local(DVec2::new(u.y, v.y)));
                    trims
                        .rects
                        .push(Rect { u: DVec2::new(from.x, to.x), v: DVec2::new(from.y, to.y) });
                }
            }
        }
        trims
    }
}

/// A side of a block.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Left,
    Right,
    Below,
    Above,
}

/// The side of a block beyond which a segment lies.
fn beyond(segment: &Segment, [low, high]: [DVec2; 2]) -> Option<Side> {
    let [min, max] = bounding_box(segment.points().iter().copied());
    let margin = MARGIN * (high - low);
    [
        (max.x < low.x - margin.x, Side::Left),
        (min.x > high.x + margin.x, Side::Right),
        (max.y < low.y - margin.y, Side::Below),
        (min.y > high.y + margin.y, Side::Above),
    ]
    .into_iter()
    .find_map(|(is, side)| is.then_some(side))
}

/// Relative to a block: what lies closer to it may touch it.
const MARGIN: f64 = 1e-6;

/// A closed chain of segments with the same winding numbers in a block, and whether it reaches the block.
///
/// Segments that reach far beyond the block are halved. Consecutive segments beyond one side become one line: both it
/// and they lie in a half plane that does not meet the block.
fn limited(segments: &[Segment], block: [DVec2; 2]) -> (Vec<Segment>, bool) {
    let mut parts = Vec::with_capacity(segments.len());
    for segment in segments {
        halve(segment, block, 0, &mut parts);
    }
    let reaches = parts.iter().any(|(_, side)| side.is_none());
    let mut joined: Vec<(Segment, Option<Side>)> = Vec::with_capacity(parts.len());
    for (segment, side) in parts {
        match joined.last_mut() {
            Some((before, known)) if side.is_some() && *known == side => {
                *before = Segment::Line([before.start(), segment.end()]);
            }
            _ => joined.push((segment, side)),
        }
    }
    // Points that the chain does not leave count for nothing.
    let is_point =
        |segment: &Segment| matches!(segment, Segment::Line([start, end]) if start == end);
    let segments = joined.into_iter().map(|(segment, _)| segment);
    (segments.filter(|segment| !is_point(segment)).collect(), reaches)
}

/// Halves a segment until each part lies beyond a side of the block or is no larger than it.
fn halve(
    segment: &Segment,
    block: [DVec2; 2],
    depth: u32,
    parts: &mut Vec<(Segment, Option<Side>)>,
) {
    const DEEPEST: u32 = 64;
    let side = beyond(segment, block);
    let [min, max] = bounding_box(segment.points().iter().copied());
    let is_small = || (max - min).cmple(block[1] - block[0]).all();
    if side.is_some() || depth == DEEPEST || is_small() {
        parts.push((*segment, side));
        return;
    }
    for half in segment.halves() {
        halve(&half, block, depth + 1, parts);
    }
}

impl Segment {
    fn halves(&self) -> [Self; 2] {
        let middle = |a: DVec2, b: DVec2| 0.5 * (a + b);
        match self {
            Self::Line(points) => split(points, middle).map(Self::Line),
            Self::Quadratic(points) => split(points, middle).map(Self::Quadratic),
            Self::Cubic(points) => split(points, middle).map(Self::Cubic),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trim::Circle;
    use glam::dvec2;
    use proptest::prelude::*;

    /// Where patches begin and end.
    fn spans() -> impl Strategy<Value = Vec<[f64; 2]>> {
        (-3.0..3.0, prop::collection::vec(0.001..1.0_f64, 1..9)).prop_map(|(first, steps)| {
            let mut knot = first;
            let span = |step: &f64| {
                let before = knot;
                knot += step;
                [before, knot]
            };
            steps.iter().map(span).collect()
        })
    }

    /// Places as shares of the domain, some of them beyond it.
    fn places(count: usize) -> impl Strategy<Value = Vec<DVec2>> {
        prop::collection::vec((-0.4..1.4, -0.4..1.4).prop_map(|(u, v)| dvec2(u, v)), count)
    }

    /// A loop of a line, a quadratic and two cubics.
    fn loop_of(points: &[DVec2]) -> TrimLoop {
        let p = |i: usize| points[i % 9];
        let segments = vec![
            Segment::Line([p(0), p(1)]),
            Segment::Quadratic([p(1), p(2), p(3)]),
            Segment::Cubic([p(3), p(4), p(5), p(6)]),
            Segment::Cubic([p(6), p(7), p(8), p(0)]),
        ];
        TrimLoop::new(segments).unwrap()
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        #[test]
        fn patches_are_cut_as_the_whole_surface_is(
            columns in spans(),
            rows in spans(),
            points in prop::collection::vec(places(9), 0..4),
            round in prop::collection::vec((-0.2..1.2, -0.2..1.2, 0.01..0.6, 0.01..0.6), 0..3),
            rule in any::<bool>(),
            keep in any::<bool>(),
            samples in places(100),
        ) {
            let low = dvec2(columns[0][0], rows[0][0]);
            let high = dvec2(columns[columns.len() - 1][1], rows[rows.len() - 1][1]);
            let place = |share: DVec2| low + share * (high - low);
            let keep = if keep { Keep::Inside } else { Keep::Outside };
            let mut trims = Trims { keep, ..Trims::default() };
            for (i, points) in points.iter().enumerate() {
                let one = loop_of(&points.iter().map(|share| place(*share)).collect::<Vec<_>>());
                if i == 1 {
                    let rule = if rule { FillRule::NonZero } else { FillRule::EvenOdd };
                    trims.paths.push(TrimPath { loops: vec![one], rule });
                } else {
                    trims.loops.push(one);
                }
            }
            for (i, (u, v, a, b)) in round.into_iter().enumerate() {
                let (center, radii) = (place(dvec2(u, v)), dvec2(a, b) * (high - low));
                match i {
                    0 => trims.ellipses.push(Ellipse { center, radii }),
                    1 => trims.circles.push(Circle { center, radius: radii.min_element() }),
                    _ => {
                        let (from, to) = (center - radii, center + radii);
                        trims.rects.push(Rect { u: dvec2(from.x, to.x), v: dvec2(from.y, to.y) });
                    }
                }
            }
            let by_patch = trims_by_patch(&trims, &columns, &rows);
            for (number, patch) in by_patch.iter().enumerate() {
                let (u, v) = (columns[number % columns.len()], rows[number / columns.len()]);
                let (first, last) = (dvec2(u[0], v[0]), dvec2(u[1], v[1]));
                for share in samples.iter().map(|share| share.fract().abs()) {
                    let at = first + share * (last - first);
                    let found = match patch {
                        PatchTrims::Kept => false,
                        PatchTrims::Gone => true,
                        PatchTrims::Cut(own) => own.cut(share),
                    };
                    // Within rounding of a border, either is right.
                    let near = [-1e-9, 1e-9].map(|off| trims.cut(at + off * (high - low)));
                    if near == [trims.cut(at); 2] {
                        prop_assert_eq!(found, trims.cut(at), "patch {} at {}", number, at);
                    }
                }
            }
        }
    }

    #[test]
    fn what_does_not_reach_a_patch_is_left_out() {
        // A fine polygon over 30 × 30 patches: most patches hold few of its 600 lines, and many need no trims at all.
        let corner = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / 600.0;
            dvec2(15.0, 15.0) + 10.0 * dvec2(angle.cos(), angle.sin())
        };
        let lines = (0..600).map(|i| Segment::Line([corner(i), corner((i + 1) % 600)])).collect();
        let trims = Trims { loops: vec![TrimLoop::new(lines).unwrap()], ..Trims::default() };
        let spans: Vec<[f64; 2]> = (0..30).map(|i| [f64::from(i), f64::from(i) + 1.0]).collect();
        let by_patch = trims_by_patch(&trims, &spans, &spans);
        let cut: Vec<usize> = by_patch
            .iter()
            .filter_map(|patch| match patch {
                PatchTrims::Cut(trims) => Some(trims.segment_count()),
                _ => None,
            })
            .collect();
        assert!(cut.len() < 100, "{} patches are cut", cut.len());
        assert!(cut.iter().all(|count| *count < 60), "{cut:?}");
        let gone = by_patch.iter().filter(|patch| **patch == PatchTrims::Gone).count();
        assert!((230..314).contains(&gone), "{gone}");
    }
}
