//! The exact method's grid over the loops of a surface. Each cell stores the pieces that its samples must be tested
//! against, and the part of the answer that is known without testing any piece.
//!
//! Whether a sample is inside depends on how often a ray from it towards greater u crosses the loops, upwards and
//! downwards. The ray is not followed to infinity. The sample is instead compared with the lower right corner of its
//! cell, whose winding number is known. Only pieces that touch the cell lie between the sample and this corner. (The
//! literature calls this shortcuts: Nehab and Hoppe 2008; Ganacim and others 2014.)
//!
//! A piece that touches the cell and leaves it to the right can still cross the ray beyond the cell. Because the loop
//! is closed, the crossings beyond the cell cancel out, except for the row test of the piece's end that lies to the
//! right. A reference names that end. The piece's test and the row test of this end together count only the crossings
//! within the cell.
//!
//! # Words
//!
//! The shader reads one buffer of 32-bit words; four words make a texel. The buffer holds, in this order: a header,
//! the cells of the loops, the pieces, the lists and finer cells of the loops, the shapes, and the cells and lists of
//! the shapes. The shader is told the number of the loops' columns with each sub-patch. All
//! indices of words count from the header, because one buffer holds the grids of all surfaces.
//!
//! | word of the header | meaning |
//! |---|---|
//! | 0 | columns and rows of the shapes' cells |
//! | 1 | the index of the word where the shapes' cells begin |
//!
//! | cell | meaning |
//! |---|---|
//! | 0, 1 | 0: everything in the cell is kept; 1: everything in it is cut |
//! | word · 8 + 2, 3 | a list at that word; 3 inverts its result |
//! | word · 8 + 4 | a finer uniform grid at that word: minimum u, v, scale u, v, columns, then its cells |
//!
//! A list consists of references; its result is "cut" if the number of crossings is odd. If paths have fill rules of
//! their own ([`Grid::has_rules`]), the cell has several such lists in a row, one for each path that has pieces in
//! the cell. Each of them follows a head: 4 times the winding number without its pieces, plus 1 for even-odd, plus 2
//! for the last head of the cell. A sample is inside if it is inside one of the paths; the cell's word says whether
//! the inside is cut.
//!
//! A reference is a sum: 32 times the number of the piece (the index of its first word / 8), plus 1 if only the
//! piece's lower end lies to the right of the cell, plus 2 if only its upper end does, plus 4 for the last reference
//! of a list, plus 8 if the piece bulges to the left of its chord, plus 16 if its loop follows it downwards.

mod builder;
mod cutting;

use std::ops::Range;

use super::FillRule;
use super::pieces::Curve;
use super::uniform_grid::UniformGrid;
use builder::{Builder, Member};
use cutting::{FilledCurve, cut_to_cells, uniform_grid_of};

/// The number of words of the header; the loops' cells follow it.
pub(super) const HEADER_WORDS: usize = 4;
/// The number of words of a piece.
pub(super) const PIECE_WORDS: usize = 8;
/// Bit of a cell with a list.
pub(super) const LIST: u32 = 2;
/// Bit of a cell with a finer uniform grid.
pub(super) const FINER: u32 = 4;
/// Bit of the last reference of a list.
pub(super) const LAST: u32 = 4;
/// Bit of a reference to a piece that its loop follows downwards.
pub(super) const FALLS: u32 = 16;
/// Bit of the head of a path that is filled by even-odd.
pub(super) const EVEN_ODD: i32 = 1;
/// Bit of a cell's last head.
pub(super) const LAST_HEAD: i32 = 2;
/// The shader walks a longer list in several passes.
pub(super) const LONG_LIST: usize = 32;

/// A cell with more pieces than this gets a finer grid of its own.
const CROWDED: usize = 12;

/// The finished grid.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub(super) uniform_grid: UniformGrid,
    /// The indices of the words of the pieces.
    pub(super) pieces: Range<usize>,
    /// Length of the longest list of references.
    pub(super) longest: usize,
    /// Whether lists have heads.
    pub(super) has_rules: bool,
}

/// The result of [`build`].
pub(super) enum Built {
    /// The decision is the same everywhere: everything is cut, or everything is kept. This is so, for example, if the
    /// loops only follow the border of the domain.
    Uniform(bool),
    /// The decision depends on the cell.
    Cells(Grid),
}

/// Builds the grid of closed chains of monotone curves and appends it to `words`, which holds only the header. Each
/// fill has its own rule. If `outside` is true, points outside all fills are cut; otherwise points inside a fill are
/// cut. A side has at least `least` cells.
pub(super) fn build(
    fills: &[(FillRule, Vec<Curve>)],
    outside: bool,
    least: u32,
    words: &mut Vec<u32>,
) -> Built {
    debug_assert_eq!(words.len(), HEADER_WORDS);
    let curves: Vec<FilledCurve> = (0..)
        .zip(fills)
        .flat_map(|(fill, (_, curves))| {
            curves.iter().map(move |&curve| FilledCurve { curve, fill })
        })
        .collect();
    let Some(uniform_grid) = uniform_grid_of(&curves, least) else {
        return Built::Uniform(outside);
    };
    let members: Vec<Member> =
        cut_to_cells(&curves, &uniform_grid).iter().filter_map(Member::of).collect();
    words.reserve(members.len() * (PIECE_WORDS + 4) + uniform_grid.count());
    words.resize((HEADER_WORDS + uniform_grid.count()).next_multiple_of(PIECE_WORDS), 0);
    let first_piece = words.len();
    words.extend(members.iter().flat_map(|member| member.piece.words()));
    let pieces = first_piece..words.len();
    let rules: Vec<FillRule> = fills.iter().map(|(rule, _)| *rule).collect();
    let has_rules = rules != [FillRule::EvenOdd];
    let mut builder = Builder {
        members: &members,
        rules: &rules,
        has_rules,
        outside,
        first_piece,
        words,
        longest: 0,
    };
    builder.fill_domain(&uniform_grid);
    let longest = builder.longest;
    let cells = &words[HEADER_WORDS..][..uniform_grid.count()];
    if cells[0] & (LIST | FINER) == 0 && cells.iter().all(|cell| *cell == cells[0]) {
        let all_cut = cells[0] == 1;
        words.truncate(HEADER_WORDS);
        return Built::Uniform(all_cut);
    }
    Built::Cells(Grid { uniform_grid, pieces, longest, has_rules })
}

/// Marks the last word as the last of its list.
pub(super) fn end_list(words: &mut [u32]) {
    if let Some(last) = words.last_mut() {
        *last |= LAST;
    }
}

/// The references of a list.
pub(super) fn listed(words: &[u32]) -> impl Iterator<Item = u32> {
    let end = words.iter().position(|word| word & LAST != 0).map_or(words.len(), |last| last + 1);
    words[..end].iter().copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trim::pieces::{Piece, monotone_curves};
    use crate::trim::uniform_grid::{BELOW_ONE, Bounds};
    use crate::trim::{Segment, TrimLoop};
    use glam::Vec2;
    use proptest::prelude::*;

    fn even_odd(loops: &[TrimLoop]) -> [(FillRule, Vec<Curve>); 1] {
        [(FillRule::EvenOdd, monotone_curves(loops))]
    }

    fn cells_of(loops: &[TrimLoop], words: &mut Vec<u32>) -> Grid {
        match build(&even_odd(loops), false, 32, words) {
            Built::Cells(grid) => grid,
            Built::Uniform(all_cut) => panic!("everything alike: {all_cut}"),
        }
    }

    /// The bounds of every cell that can be looked up, including finer cells, and the pieces that it lists.
    fn cells(grid: &Grid, words: &[u32]) -> Vec<([Bounds; 2], Vec<usize>)> {
        let mut found = Vec::new();
        let mut uniform_grids = vec![(grid.uniform_grid, HEADER_WORDS)];
        while let Some((uniform_grid, first)) = uniform_grids.pop() {
            let [columns, rows] = [0, 1].map(|axis| uniform_grid.bounds(axis));
            for cell in 0..uniform_grid.count() {
                let [column, row] = [cell % columns.len(), cell / columns.len()];
                let bounds = [columns[column], rows[row]];
                let word = words[first + cell];
                let at = (word >> 3) as usize;
                if word & 7 == FINER {
                    let corner = |i: usize| Vec2::new(bounds[0][i], bounds[1][i]);
                    let side = words[at + 4];
                    let finer = UniformGrid::new(corner(0), corner(1), side);
                    assert_eq!(finer.words(), words[at..at + UniformGrid::WORDS]);
                    uniform_grids.push((finer, at + UniformGrid::WORDS));
                } else if word & LIST != 0 {
                    let piece = |word: u32| (word >> 5) as usize - grid.pieces.start / PIECE_WORDS;
                    let pieces = listed(&words[at..]).map(piece).collect();
                    found.push((bounds, pieces));
                } else {
                    found.push((bounds, Vec::new()));
                }
            }
        }
        found
    }

    fn chain(points: &[(f64, f64)]) -> TrimLoop {
        let at = |i: usize| points[i % points.len()].into();
        let cubic = |i: usize| Segment::Cubic([at(i), at(i + 1), at(i + 2), at(i + 3)]);
        TrimLoop::new((0..points.len()).step_by(3).map(cubic).collect()).unwrap()
    }

    /// Lenses in rows and columns: many small curves.
    fn lenses(side: usize, step: f64, min: f64) -> Vec<TrimLoop> {
        let lens = |i: usize| {
            let (u, v) = (min + step * (i % side) as f64, min + step * (i / side) as f64);
            let at = |x: f64, y: f64| (u + x * step, v + y * step);
            chain(&[
                at(0.1, 0.5),
                at(0.3, 0.9),
                at(0.7, 0.9),
                at(0.9, 0.5),
                at(0.7, 0.1),
                at(0.3, 0.1),
            ])
        };
        (0..side * side).map(lens).collect()
    }

    /// Whether a piece lies on the left or right border of the domain, or is level and not within a row of cells.
    fn is_alike(piece: &Piece, [_, [bottom, top]]: [Bounds; 2]) -> bool {
        let [min, max] = piece.u_range();
        let is_within = bottom < piece.low.y && piece.low.y <= top.min(BELOW_ONE);
        max == 0.0 || min == 1.0 || (piece.low.y == piece.high.y && !is_within)
    }

    fn check(loops: &[TrimLoop], rows: &[f32]) {
        let mut words = vec![0; HEADER_WORDS];
        let Built::Cells(grid) = build(&even_odd(loops), false, 32, &mut words) else { return };
        let pieces: Vec<Piece> =
            words[grid.pieces.clone()].chunks_exact(PIECE_WORDS).map(Piece::from_words).collect();
        for (bounds, listed) in cells(&grid, &words) {
            let mut is_listed = vec![false; pieces.len()];
            for piece in listed {
                is_listed[piece] = true;
            }
            for (piece, is_listed) in pieces.iter().zip(is_listed) {
                let [min, max] = piece.u_range();
                let touches = min <= bounds[0][1]
                    && max >= bounds[0][0]
                    && piece.low.y <= bounds[1][1]
                    && piece.high.y >= bounds[1][0];
                let is_right = if touches && !is_listed {
                    is_alike(piece, bounds)
                } else {
                    is_listed == touches
                };
                assert!(is_right, "{piece:?} in {bounds:?}");
            }
        }
        // The end points alone decide how many pieces a row meets. The number must be even.
        let stored = pieces.iter().take(50).flat_map(|piece| [piece.low.y, piece.high.y]);
        for v in stored.chain(rows.iter().copied()) {
            let met = pieces.iter().filter(|p| (p.low.y <= v) != (p.high.y <= v)).count();
            assert!(met.is_multiple_of(2), "{met} pieces in row {v}");
        }
    }

    #[test]
    fn crowded_cells_list_every_piece_that_touches_them() {
        let mut loops = lenses(12, 0.001, 0.5);
        loops.push(chain(&[
            (0.05, 0.5),
            (0.1, 1.1),
            (0.9, 1.1),
            (0.95, 0.5),
            (0.9, -0.1),
            (0.1, -0.1),
        ]));
        let mut words = vec![0; HEADER_WORDS];
        let grid = cells_of(&loops, &mut words);
        let cells = &words[HEADER_WORDS..][..grid.uniform_grid.count()];
        assert!(cells.iter().any(|cell| cell & 7 == FINER));
        check(&loops, &[0.5, 0.505]);
    }

    #[test]
    fn ten_thousand_spread_segments_take_less_than_200_bytes_each() {
        let loops = lenses(71, 1.0 / 71.0, 0.0);
        let mut words = vec![0; HEADER_WORDS];
        let grid = cells_of(&loops, &mut words);
        let segments = 2 * loops.len();
        assert!(segments >= 10_000 && grid.pieces.len() >= PIECE_WORDS * segments);
        assert!(4 * words.len() <= 200 * segments, "{} bytes", 4 * words.len());
    }

    #[test]
    fn a_hundred_thousand_long_segments_do_not_grow_the_grid_beyond_bounds() {
        let points: Vec<(f64, f64)> = (0..300_000_u64)
            .map(|i| ((i * 7919 % 10_007) as f64 / 10_007.0, (i * 104_729 % 9973) as f64 / 9973.0))
            .collect();
        let mut words = vec![0; HEADER_WORDS];
        let grid = cells_of(&[chain(&points)], &mut words);
        assert!(4 * words.len() < 400 << 20, "{} MiB", words.len() >> 18);
        assert!(grid.longest > LONG_LIST);
    }

    #[test]
    fn what_has_no_inside_has_no_grid() {
        let level = [(0.2, 0.5), (0.4, 0.5), (0.6, 0.5), (0.8, 0.5), (0.6, 0.5), (0.4, 0.5)];
        let outside = level.map(|(u, v)| (u + 2.0, v * 3.0 * u));
        for points in [level, level.map(|(u, v)| (v, u)), outside] {
            let mut words = vec![0; HEADER_WORDS];
            let built = build(&even_odd(&[chain(&points)]), false, 32, &mut words);
            assert!(matches!(built, Built::Uniform(false)) && words.len() == HEADER_WORDS);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn cells_list_every_piece_that_touches_them(
            points in prop::collection::vec((-0.3..1.3, -0.3..1.3), 6..30),
            rows in prop::collection::vec(0.0_f32..1.0, 10),
        ) {
            let loops = [chain(&points[..points.len() / 3 * 3])];
            check(&loops, &rows);
        }
    }
}
