//! Trims of a surface of several patches: what they do to each patch, in coordinates of the patch.
//!
//! `f32` then resolves a small fraction of each patch, however many patches the domain has and however far its
//! parameters are from 0. The patches are halved again and again, with the trims that reach each half. What lies beyond
//! one side of a half may run there as it likes: only its ends matter to the winding numbers within. So consecutive
//! curves beyond a side become one line, and few curves remain where there is little to decide.

use glam::DVec2;

use super::{Circle, Ellipse, FillRule, Keep, Rect, Segment, TrimLoop, TrimPath, Trims};
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
        shapes: shapes_of(trims),
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

#[derive(Debug, Clone, Copy)]
enum Shape {
    Ellipse(Ellipse),
    Rect(Rect),
}

impl Shape {
    fn cuts(&self, uv: DVec2) -> bool {
        match self {
            Self::Ellipse(ellipse) => ellipse.cuts(uv),
            Self::Rect(rect) => rect.cuts(uv),
        }
    }

    /// Whether it cuts anything of a block.
    fn touches(&self, [low, high]: [DVec2; 2]) -> bool {
        match self {
            Self::Ellipse(ellipse) => ellipse.cuts(ellipse.center.clamp(low, high)),
            Self::Rect(Rect { u, v }) => {
                u.x <= high.x && u.y >= low.x && v.x <= high.y && v.y >= low.y
            }
        }
    }

    /// Whether it cuts all of a block, which its corners decide.
    fn covers(&self, [low, high]: [DVec2; 2]) -> bool {
        let corners = [low, high, DVec2::new(low.x, high.y), DVec2::new(high.x, low.y)];
        corners.into_iter().all(|corner| self.cuts(corner))
    }
}

fn shapes_of(trims: &Trims) -> Vec<Shape> {
    let circles = trims.circles.iter().filter(|_| trims.circles_on);
    let ellipses = trims.ellipses.iter().filter(|_| trims.ellipses_on);
    let rects = trims.rects.iter().filter(|_| trims.rects_on);
    let round =
        |&Circle { center, radius }: &Circle| Ellipse { center, radii: DVec2::splat(radius) };
    let rounds = circles.map(round).chain(ellipses.copied()).map(Shape::Ellipse);
    rounds.chain(rects.copied().map(Shape::Rect)).collect()
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
            for one in &mut fill.loops {
                let (limited, reaches) = limited(one, block);
                *one = limited;
                touches |= reaches;
            }
            if !touches {
                let middle = block[0].midpoint(block[1]);
                let segments = fill.loops.iter().flatten();
                let number = segments.map(|segment| super::ray_crossings(segment, middle)).sum();
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
