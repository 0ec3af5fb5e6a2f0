//! The trim test of the exact method: the data that the shaders read, and the same decision on the CPU.

#[cfg(test)]
mod tests;

use std::num::NonZeroU32;
use std::ops::Range;

use glam::Vec2;

use super::grid::{
    Built, EVEN_ODD, FALLS, FINER, HEADER_WORDS, LAST_HEAD, LIST, LONG_LIST, PIECE_WORDS, listed,
};
use super::pieces::{Piece, monotone_curves};
use super::uniform_grid::{BELOW_ONE, UniformGrid};
use super::{FillRule, Keep, Trims, grid, shapes};

/// The trims of a surface, compiled for fast and exact decisions.
///
/// It gives the same answer as [`Trims::cut`] for every sample that is further than 2·10⁻⁷ of the domain from all
/// curves, if their control points are at most about 1e9 away. The time for a sample does not depend on the number of
/// curves. The exceptions are thousands of curves that are crowded into 1/65,536 of the domain, that cross in one
/// point, or that each reach across the whole domain. The shaders read the words of this grid and make the same
/// decisions, bit for bit (`glsl/common/trim.glsl`).
#[derive(Debug, Clone, PartialEq)]
pub struct TrimGrid {
    words: Vec<u32>,
    loops: Option<Lookup>,
    shapes: Option<Lookup>,
    /// Whether everything is cut; used if the loops have no cells.
    all_cut: bool,
    pieces: Range<usize>,
    has_finer_cells: bool,
    has_long_lists: bool,
    has_rules: bool,
}

/// The usual least number of cells along a side of the grid of loops; that of shapes is twice as large. There may be
/// thousands of surfaces with few trims each.
const LEAST_SIDE: u32 = 8;

/// A grid that is stored in the words.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Lookup {
    /// Its place in the domain and its cells.
    uniform_grid: UniformGrid,
    /// The index of the word where its cells begin.
    cells: usize,
}

impl TrimGrid {
    /// Compiles the trims that are switched on.
    #[must_use]
    pub fn new(trims: &Trims) -> Self {
        Self::with_side(trims, LEAST_SIDE)
    }

    /// The same with at least so many cells along a side, if it has any: a power of two.
    pub(crate) fn with_side(trims: &Trims, least: u32) -> Self {
        let mut words = vec![0; HEADER_WORDS];
        let cut_loops = trims.loops_on && trims.has_loops();
        let fills: Vec<_> = if cut_loops {
            trims.fills().map(|fill| (fill.rule, monotone_curves(fill.loops))).collect()
        } else {
            Vec::new()
        };
        let keeps_inside = cut_loops && trims.keep == Keep::Inside;
        let (grid, all_cut) = match grid::build(&fills, keeps_inside, least, &mut words) {
            Built::Uniform(all_cut) => (None, all_cut),
            Built::Cells(grid) => (Some(grid), keeps_inside),
        };
        // Shapes are read four words at a time.
        words.resize(words.len().next_multiple_of(4), 0);
        let shapes = shapes::build(trims, 2 * least, &mut words)
            .map(|(uniform_grid, cells)| Lookup { uniform_grid, cells });
        let loops = grid
            .as_ref()
            .map(|grid| Lookup { uniform_grid: grid.uniform_grid, cells: HEADER_WORDS });
        if let Some(shapes) = &shapes {
            words[0] = shapes.uniform_grid.size.x;
            words[1] = shapes.cells as u32;
        }
        let pieces = grid.as_ref().map_or(0..0, |grid| grid.pieces.clone());
        let has_finer_cells = loops.is_some_and(|loops| {
            let cells = &words[loops.cells..][..loops.uniform_grid.count()];
            cells.iter().any(|cell| cell & 7 == FINER)
        });
        let has_long_lists = grid.as_ref().is_some_and(|grid| grid.longest > LONG_LIST);
        let has_rules = grid.is_some_and(|grid| grid.has_rules);
        Self { words, loops, shapes, all_cut, pieces, has_finer_cells, has_long_lists, has_rules }
    }

    /// Whether `uv` is cut, in the arithmetic of the shaders.
    #[must_use]
    pub fn cut(&self, uv: Vec2) -> bool {
        let uv = clamped(uv);
        self.cut_by_shapes(uv) || self.cut_by_loops(uv)
    }

    /// Whether everything in the rectangle from `min` up to, but not including, `max` is cut (`true`) or kept
    /// (`false`). `None` if that is not known: the rectangle may contain both.
    #[must_use]
    pub fn cut_throughout(&self, min: Vec2, max: Vec2) -> Option<bool> {
        let cells = |lookup: &Option<Lookup>, without: bool| match lookup {
            None => Some(without),
            Some(lookup) => self.throughout(lookup, min, max),
        };
        match cells(&self.shapes, false) {
            Some(true) => Some(true),
            Some(false) => cells(&self.loops, self.all_cut),
            None => cells(&self.loops, self.all_cut).filter(|cut| *cut),
        }
    }

    /// The answer of all cells that a rectangle touches, if they agree.
    fn throughout(&self, lookup: &Lookup, min: Vec2, max: Vec2) -> Option<bool> {
        let uniform_grid = &lookup.uniform_grid;
        // Rounding may put a sample just outside the rectangle. If the decision differs there, a curve is so close
        // that either decision is allowed.
        let last = Vec2::new(max.x.next_down(), max.y.next_down());
        let [first, last] = [min, last].map(|corner| uniform_grid.cell(clamped(corner)));
        let mut found = None;
        for row in first.y..=last.y {
            for column in first.x..=last.x {
                let cell = self.words[lookup.cells + (row * uniform_grid.size.x + column) as usize];
                let says = cell & 1 == 1;
                if cell & (LIST | FINER) != 0 || found.is_some_and(|found| found != says) {
                    return None;
                }
                found = Some(says);
            }
        }
        found
    }

    /// Whether the answer depends on the sample.
    pub(crate) const fn decides(&self) -> bool {
        self.loops.is_some() || self.shapes.is_some()
    }

    /// Whether a list is so long that the shader must walk it in several passes.
    pub(crate) const fn has_long_lists(&self) -> bool {
        self.has_long_lists
    }

    /// Whether there are paths with fill rules of their own.
    pub(crate) const fn has_rules(&self) -> bool {
        self.has_rules
    }

    /// Whether any cell has a finer uniform grid of its own.
    pub(crate) const fn has_finer_cells(&self) -> bool {
        self.has_finer_cells
    }

    /// The monotone pieces that the loops were cut into, as they are stored in the words. Each piece consists of its
    /// lower end, its upper end, and the first and last leg of its control polygon.
    #[must_use]
    pub fn pieces(&self) -> &[[f32; 8]] {
        bytemuck::cast_slice(&self.words[self.pieces.clone()])
    }

    /// The words that the shaders read.
    #[must_use]
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The number of columns (and of rows) of the loops' cells, a power of two; `None` if the loops have no cells.
    pub(crate) fn loop_columns(&self) -> Option<NonZeroU32> {
        self.loops.and_then(|loops| NonZeroU32::new(loops.uniform_grid.size.x))
    }

    /// Whether anything can be cut by circles, intervals or ellipses.
    pub(crate) const fn has_shapes(&self) -> bool {
        self.shapes.is_some()
    }

    /// The word of a sample's cell.
    fn cell(&self, lookup: &Lookup, uv: Vec2) -> u32 {
        self.words[lookup.cells + lookup.uniform_grid.cell_of(uv)]
    }

    fn cut_by_shapes(&self, uv: Vec2) -> bool {
        let Some(lookup) = &self.shapes else { return false };
        match self.cell(lookup, uv) {
            cell if cell & LIST == 0 => cell & 1 == 1,
            cell => listed(&self.words[(cell >> 3) as usize..])
                .any(|reference| shapes::cuts(&self.words, reference, uv)),
        }
    }

    fn cut_by_loops(&self, uv: Vec2) -> bool {
        let Some(lookup) = &self.loops else { return self.all_cut };
        let mut cell = self.cell(lookup, uv);
        if cell & 7 == FINER {
            let at = (cell >> 3) as usize;
            let finer = UniformGrid::from_words(&self.words[at..]);
            cell = self.words[at + UniformGrid::WORDS + finer.cell_of(uv)];
        }
        let turned = cell & 1 == 1;
        if cell & LIST == 0 {
            return turned;
        }
        let mut at = (cell >> 3) as usize;
        if !self.has_rules {
            return FillRule::EvenOdd.fills(self.crossings(&mut at, uv)) != turned;
        }
        loop {
            let head = self.words[at] as i32;
            at += 1;
            let rule = if head & EVEN_ODD != 0 { FillRule::EvenOdd } else { FillRule::NonZero };
            let inside = rule.fills((head >> 2) + self.crossings(&mut at, uv));
            if inside || head & LAST_HEAD != 0 {
                return inside != turned;
            }
        }
    }

    /// The contribution of the pieces of a list to the winding number. The list begins at the word `at`, which is
    /// moved past the end of the list.
    fn crossings(&self, at: &mut usize, uv: Vec2) -> i32 {
        let references = listed(&self.words[*at..]);
        let mut number = 0;
        for reference in references {
            *at += 1;
            let piece = Piece::from_words(&self.words[(reference >> 5) as usize * PIECE_WORDS..]);
            let end = match reference & 3 {
                0 => 0,
                1 => -i32::from(piece.low.y <= uv.y),
                _ => i32::from(piece.high.y <= uv.y),
            };
            let turn = if reference & FALLS != 0 { -1 } else { 1 };
            number += turn * (i32::from(piece.crosses(uv)) + end);
        }
        number
    }
}

fn clamped(uv: Vec2) -> Vec2 {
    uv.clamp(Vec2::ZERO, Vec2::splat(BELOW_ONE))
}
