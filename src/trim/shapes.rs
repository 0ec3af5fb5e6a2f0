//! Circles, intervals and ellipses in the exact method. They are tested by their equations, not by curves that
//! approximate them. They have a grid of their own, because there may be many of them.

use glam::{DVec2, UVec2, Vec2};

use super::grid::{LIST, end_list};
use super::uniform_grid::UniformGrid;
use super::{Circle, Ellipse, Rect, Trims};

/// The number of words of a shape in the shader's buffer.
pub(super) const SHAPE_WORDS: usize = 8;

/// The largest number of cells along a side of the grid.
const LARGEST_SIDE: u32 = 256;
/// The maximum number of cells that all shapes together may touch is this number times the number of shapes, but no
/// less than `MAX_CELLS`.
const MAX_CELLS_PER_SHAPE: f64 = 16.0;
const MAX_CELLS: f64 = 65_536.0;
/// Cells are enlarged by this much when a statement must hold for all their samples.
const MARGIN: f64 = 1e-6;
/// Circles and ellipses with a smaller radius contain no sample that could be told from their border.
const THINNEST: f64 = 1e-9;

/// A circle or an ellipse, or a rectangle.
#[derive(Debug, Clone, Copy)]
pub(super) enum Shape {
    Ellipse(Ellipse),
    Rect(Rect),
}

impl Shape {
    /// Minimum and maximum (u, v).
    fn extent(&self) -> [DVec2; 2] {
        match self {
            Self::Ellipse(Ellipse { center, radii }) => [center - radii, center + radii],
            Self::Rect(Rect { u, v }) => [DVec2::new(u.x, v.x), DVec2::new(u.y, v.y)],
        }
    }

    fn cuts(&self, uv: DVec2) -> bool {
        match self {
            Self::Ellipse(ellipse) => ellipse.cuts(uv),
            Self::Rect(interval) => interval.cuts(uv),
        }
    }

    /// Whether it cuts anything in a box.
    pub(super) fn touches(&self, [min, max]: [DVec2; 2]) -> bool {
        match self {
            // The point of the box that is nearest to the centre, in the metric of the ellipse.
            Self::Ellipse(ellipse) => ellipse.cuts(ellipse.center.clamp(min, max)),
            Self::Rect(_) => {
                let [low, high] = self.extent();
                low.cmple(max).all() && min.cmple(high).all()
            }
        }
    }

    /// Whether it cuts everything in a box. The corners decide this, because shapes are convex.
    pub(super) fn covers(&self, [min, max]: [DVec2; 2]) -> bool {
        [min, max, DVec2::new(min.x, max.y), DVec2::new(max.x, min.y)]
            .into_iter()
            .all(|corner| self.cuts(corner))
    }

    /// An ellipse is stored as a polynomial: a s² + b t² + c s + d t + e ≤ 0. The origin of s and t is the point of
    /// the domain that is nearest to the centre. With this origin `f32` is precise enough, however large the ellipse
    /// is and however far away its centre.
    fn words(&self) -> [u32; SHAPE_WORDS] {
        let words = match self {
            Self::Ellipse(Ellipse { center, radii }) => {
                let from = center.clamp(DVec2::ZERO, DVec2::ONE).as_vec2();
                let off = from.as_dvec2() - center;
                let square = 1.0 / (radii * radii);
                let linear = 2.0 * off * square;
                let constant = (off * off * square).element_sum() - 1.0;
                let [square, linear] = [square.as_vec2(), linear.as_vec2()];
                [from.x, from.y, square.x, square.y, linear.x, linear.y, constant as f32, 0.0]
            }
            Self::Rect(Rect { u, v }) => {
                let [u, v] = [u.as_vec2(), v.as_vec2()];
                [u.x, u.y, v.x, v.y, 0.0, 0.0, 0.0, 0.0]
            }
        };
        words.map(f32::to_bits)
    }

    /// The number of the kind in references.
    const fn kind(&self) -> u32 {
        match self {
            Self::Ellipse(_) => 0,
            Self::Rect(_) => 1,
        }
    }
}

/// Whether the shape of a reference cuts `uv`: twin of `cutByShape` in `glsl/common/trim.glsl`, bit
/// for bit.
pub(super) fn cuts(words: &[u32], reference: u32, uv: Vec2) -> bool {
    let at = (reference >> 3) as usize * 4;
    let word = |i: usize| f32::from_bits(words[at + i]);
    let point = |i: usize| Vec2::new(word(i), word(i + 1));
    if reference & 3 == 1 {
        let [u, v] = [point(0), point(2)];
        return uv.x >= u.x && uv.x <= u.y && uv.y >= v.x && uv.y <= v.y;
    }
    let off = uv - point(0);
    let terms = (point(2) * off + point(4)) * off;
    terms.x + terms.y + word(6) <= 0.0
}

/// Builds the grid of the shapes that are switched on and appends it to `words`, which must contain whole texels of
/// four words. The second value is the index of the word where the cells begin. `None` if no shape can cut anything.
///
/// A cell is 0 (nothing in it is cut), 1 (everything in it is cut), or offset · 8 + 2 (a list of references at that
/// offset). A reference is texel · 8 + kind, plus 4 for the last reference of a list.
pub(super) fn build(
    trims: &Trims,
    least: u32,
    words: &mut Vec<u32>,
) -> Option<(UniformGrid, usize)> {
    let is_thin = |shape: &Shape| match shape {
        Shape::Ellipse(ellipse) => ellipse.radii.min_element() <= THINNEST,
        Shape::Rect(_) => false,
    };
    let shapes: Vec<Shape> = shapes_of(trims).filter(|shape| !is_thin(shape)).collect();
    let first = words.len();
    for shape in &shapes {
        words.extend(shape.words());
    }
    if shapes.is_empty() {
        return None;
    }
    let uniform_grid = UniformGrid::of_domain(side_for(&shapes, least));
    let cells = words.len();
    words.resize(cells + uniform_grid.count(), 0);
    fill(&shapes, &uniform_grid, first, cells, words);
    Some((uniform_grid, cells))
}

/// The shapes that are switched on.
pub(super) fn shapes_of(trims: &Trims) -> impl Iterator<Item = Shape> + '_ {
    let circles = trims.circles.iter().filter(|_| trims.circles_on);
    let intervals = trims.rects.iter().filter(|_| trims.rects_on);
    let ellipses = trims.ellipses.iter().filter(|_| trims.ellipses_on);
    circles
        .map(|Circle { center, radius }| Ellipse { center: *center, radii: DVec2::splat(*radius) })
        .chain(ellipses.copied())
        .map(Shape::Ellipse)
        .chain(intervals.copied().map(Shape::Rect))
}

fn side_for(shapes: &[Shape], least: u32) -> u32 {
    let count = shapes.len() as f64;
    let cells_at = |side: f64| -> f64 {
        let cells = |shape: &Shape| {
            let [low, high] = shape.extent();
            let size = (high.min(DVec2::ONE) - low.max(DVec2::ZERO)).max(DVec2::ZERO) * side + 1.0;
            size.x * size.y
        };
        shapes.iter().map(cells).sum()
    };
    let mut side = (2.0 * count.sqrt()).clamp(least.into(), LARGEST_SIDE.into());
    while side > 4.0 && cells_at(side) > MAX_CELLS.max(MAX_CELLS_PER_SHAPE * count) {
        side *= 0.5;
    }
    side as u32
}

/// Writes the cells. A cell is covered by one shape, or it has a list of the shapes that touch it.
fn fill(
    shapes: &[Shape],
    uniform_grid: &UniformGrid,
    first: usize,
    cells: usize,
    words: &mut Vec<u32>,
) {
    let [columns, rows] = [0, 1].map(|axis| uniform_grid.bounds(axis));
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); uniform_grid.count()];
    let mut covered = vec![false; uniform_grid.count()];
    for (number, shape) in shapes.iter().enumerate() {
        let reference = (first + number * SHAPE_WORDS) as u32 / 4 * 8 + shape.kind();
        let [low, high] = shape.extent();
        let touched = |bounds: &[[f32; 2]], low: f64, high: f64| {
            let first = bounds.partition_point(|bounds| f64::from(bounds[1]) + MARGIN < low);
            let end = bounds.partition_point(|bounds| f64::from(bounds[0]) - MARGIN <= high);
            first..end.max(first)
        };
        for row in touched(&rows, low.y, high.y) {
            for column in touched(&columns, low.x, high.x) {
                let cell = UVec2::new(column as u32, row as u32);
                let index = (cell.y * uniform_grid.size.x + cell.x) as usize;
                let corner =
                    |i: usize| DVec2::new(f64::from(columns[column][i]), f64::from(rows[row][i]));
                // No sample is outside of the domain.
                let inside = |place: DVec2| place.clamp(DVec2::ZERO, DVec2::ONE);
                let box_of_cell = [inside(corner(0) - MARGIN), inside(corner(1) + MARGIN)];
                if shape.covers(box_of_cell) {
                    covered[index] = true;
                } else if shape.touches(box_of_cell) {
                    lists[index].push(reference);
                }
            }
        }
    }
    for (index, list) in lists.iter().enumerate() {
        words[cells + index] = if covered[index] {
            1
        } else if list.is_empty() {
            0
        } else {
            let at = words.len() as u32;
            words.extend(list);
            end_list(words);
            at * 8 + LIST
        };
    }
}
