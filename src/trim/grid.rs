//! The exact method's grid over the loops of a surface: which pieces a sample must be tested
//! against, and what is known without any.
//!
//! Whether a sample is cut is the parity of what a ray towards greater u crosses. Instead of
//! following it to infinity, a sample is compared with the corner of its cell at the right and
//! below, whose parity is stored: on the way there lie only pieces that touch the cell. (Shortcuts:
//! Nehab and Hoppe 2008; Ganacim and others 2014.)
//!
//! A piece that touches the cell and leaves it to the right still meets the ray beyond. What follows
//! it there cancels out, because the loop is closed, down to the row test of the end that lies to
//! the right: a reference names that end, and both tests together count only what is in the cell.
//!
//! # Words
//!
//! The shader reads one buffer of 32-bit words, four of which make a texel: a header, the cells of
//! the loops (it is compiled for their number), the pieces, then lists and finer cells, then the
//! shapes and theirs.
//!
//! | word of the header | meaning |
//! |---|---|
//! | 0 | columns and rows of the shapes' cells |
//! | 1 | the word where those begin |
//!
//! | cell | meaning |
//! |---|---|
//! | 0, 1 | everything in it is kept, cut |
//! | word · 8 + 2, 3 | a list of references there; 3 if without them the corner were cut |
//! | word · 8 + 4 | a finer lattice there: least u, v, scale u, v, columns, then its cells |
//!
//! A reference is texel of the piece · 16, plus 1 if the piece's lower end lies right of the cell, 2
//! if its upper one does, plus 4 for the last of a list, plus 8 if the piece bulges to the left of its
//! chord.

use std::ops::Range;

use glam::{DVec2, Vec2};

use super::lattice::{Bounds, Lattice, touched};
use super::pieces::{Curve, Piece, split};

/// Words of the header; the loops' cells begin behind it.
pub(super) const HEADER_WORDS: usize = 4;
/// Words of a piece.
const PIECE_WORDS: usize = 8;
/// Bit of a cell with a list.
pub(super) const LIST: u32 = 2;
/// Bit of a cell with a finer lattice.
pub(super) const FINER: u32 = 4;
/// Bit of the last reference of a list.
pub(super) const LAST: u32 = 4;
/// Bit of a reference to a piece that bulges to the left of its chord.
const LEFT: u32 = 8;
/// A longer list is walked in several goes by the shader.
pub(super) const LONG_LIST: usize = 32;

/// Cells along a side.
const SIDES: std::ops::RangeInclusive<u32> = 32..=256;
/// A cell with more pieces than this is cut once more.
const CROWDED: usize = 12;
/// Cutting curves to the size of cells adds so many pieces for each, but at least and at most these.
const MORE_PIECES_PER_CURVE: usize = 15;
const MORE_PIECES: std::ops::RangeInclusive<usize> = 1 << 14..=1 << 20;
/// From so many words on no cell is cut once more.
const MANY_WORDS: usize = 1 << 26;

/// A piece as a cell refers to it: its number, and its end to the right of the cell.
#[derive(Clone, Copy)]
struct Reference {
    piece: u32,
    beyond: Beyond,
}

#[derive(Clone, Copy, PartialEq)]
enum Beyond {
    Neither,
    Low,
    High,
}

impl Reference {
    fn new(piece: usize, shape: &Piece, right: f32) -> Self {
        let beyond = match (shape.low.x > right, shape.high.x > right) {
            (true, false) => Beyond::Low,
            (false, true) => Beyond::High,
            _ => Beyond::Neither,
        };
        Self { piece: piece as u32, beyond }
    }

    /// The shader's word, where the pieces begin at a texel.
    fn word(self, shape: &Piece, first_texel: usize) -> u32 {
        let left = if shape.bulges_left() { LEFT } else { 0 };
        let texel = first_texel as u32 + self.piece * 2;
        texel * 16 + self.beyond as u32 + left
    }

    /// Whether the row of the end beyond the cell is reached at `v`.
    fn end_reached(self, shape: &Piece, v: f32) -> bool {
        match self.beyond {
            Beyond::Neither => false,
            Beyond::Low => shape.low.y <= v,
            Beyond::High => shape.high.y <= v,
        }
    }
}

/// What was built.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub(super) lattice: Lattice,
    /// The words of the pieces.
    pub(super) pieces: Range<usize>,
    /// Length of the longest list of references.
    pub(super) longest: usize,
}

/// Builds the grid of closed chains of monotone curves behind the header, which is all that `words`
/// has. What is outside of all of them is cut if `outside` says so, and from chain to chain the
/// other way round. None if nothing is inside the chains.
pub(super) fn build(curves: &[Curve], outside: bool, words: &mut Vec<u32>) -> Option<Grid> {
    debug_assert_eq!(words.len(), HEADER_WORDS);
    let lattice = lattice_of(curves)?;
    let parts = cut_to_cells(curves, &lattice);
    let pieces: Vec<Piece> = parts.iter().filter_map(Piece::new).collect();
    words.reserve(pieces.len() * (PIECE_WORDS + 4) + lattice.count());
    words.resize((HEADER_WORDS + lattice.count()).next_multiple_of(4), 0);
    let first_piece = words.len();
    words.extend(pieces.iter().flat_map(Piece::words));
    let end = words.len();
    let all: Vec<Reference> = (0..pieces.len() as u32)
        .map(|piece| Reference { piece, beyond: Beyond::Neither })
        .collect();
    let first_texel = first_piece / 4;
    let mut builder = Builder { pieces: &pieces, first_texel, words, longest: 0 };
    builder.fill(HEADER_WORDS, &lattice, &all, outside, true);
    let longest = builder.longest;
    Some(Grid { lattice, pieces: first_piece..end, longest })
}

/// The lattice for so many curves: about 4 cells for each, fewer if that cut long curves into too
/// many pieces. None if the curves hold nothing between them.
fn lattice_of(curves: &[Curve]) -> Option<Lattice> {
    let mut least = Vec2::INFINITY;
    let mut most = Vec2::NEG_INFINITY;
    for piece in curves.iter().filter_map(Piece::new) {
        least = least.min(piece.low.min(piece.high));
        most = most.max(piece.low.max(piece.high));
    }
    if !least.cmplt(most).all() {
        return None;
    }
    // A power of two, because programs are compiled for each.
    let wanted = (2 * curves.len().isqrt() as u32).next_power_of_two();
    let mut side = wanted.clamp(*SIDES.start(), *SIDES.end());
    let pieces_at = |side: u32| -> f64 {
        let cells = |curve: &Curve| (curve[3] - curve[0]).abs().max_element() * f64::from(side);
        curves.iter().map(|curve| cells(curve).max(1.0)).sum()
    };
    while side > 1 && pieces_at(side) > most_pieces(curves) as f64 / 2.0 {
        side /= 2;
    }
    Some(Lattice::of_domain(side))
}

/// How many pieces curves may be cut into.
fn most_pieces(curves: &[Curve]) -> usize {
    let more = MORE_PIECES_PER_CURVE * curves.len();
    curves.len() + more.clamp(*MORE_PIECES.start(), *MORE_PIECES.end())
}

/// Cuts curves until their boxes are no larger than the cells they touch; in crowded cells than the
/// finer cells there.
fn cut_to_cells(curves: &[Curve], lattice: &Lattice) -> Vec<Curve> {
    // Smaller pieces would be cut by rounding.
    const SMALLEST: f64 = 1e-6;
    let cell = DVec2::ONE / lattice.size.as_dvec2();
    let budget = most_pieces(curves);
    let mut parts = Vec::with_capacity(curves.len());
    for curve in curves {
        halve(curve, 0, &mut parts, &|_| cell);
    }
    let [columns, rows] = [0, 1].map(|axis| lattice.bounds(axis));
    let mut counts = vec![0_u32; lattice.count()];
    let cells_of = |part: &Curve| {
        let (least, most) = (part[0].min(part[3]).as_vec2(), part[0].max(part[3]).as_vec2());
        let columns = touched(&columns, [least.x, most.x]);
        touched(&rows, [least.y, most.y])
            .flat_map(move |row| columns.clone().map(move |column| (row, column)))
            .map(|(row, column)| row * lattice.size.x as usize + column)
    };
    for part in &parts {
        for cell in cells_of(part) {
            counts[cell] += 1;
        }
    }
    if counts.iter().all(|count| *count as usize <= CROWDED) {
        return parts;
    }
    let mut finer = Vec::with_capacity(parts.len());
    for part in &parts {
        let crowd = cells_of(part).map(|cell| counts[cell] as usize).max().unwrap_or(0);
        if crowd <= CROWDED || finer.len() > budget {
            finer.push(*part);
            continue;
        }
        halve(part, 0, &mut finer, &|part| {
            let crowd = cells_of(part).map(|cell| counts[cell] as usize).max().unwrap_or(0);
            let side = if crowd > CROWDED { finer_side(crowd) } else { 1 };
            (cell / f64::from(side)).max(DVec2::splat(SMALLEST))
        });
    }
    finer
}

/// Cells along a side of the finer lattice in a cell with so many pieces.
fn finer_side(count: usize) -> u32 {
    (2.0 * (count as f64).sqrt()).min((*SIDES.end()).into()) as u32
}

/// Halves a curve until its box is no larger than `limit` allows there.
fn halve(curve: &Curve, depth: u32, parts: &mut Vec<Curve>, limit: &impl Fn(&Curve) -> DVec2) {
    const DEEPEST: u32 = 12;
    let extent = (curve[3] - curve[0]).abs();
    if depth == DEEPEST || extent.cmple(limit(curve)).all() {
        parts.push(*curve);
        return;
    }
    for half in split(curve, 0.5) {
        halve(&half, depth + 1, parts, limit);
    }
}

/// Appends a list of references, which must not be empty.
pub(super) fn push_list(words: &mut Vec<u32>, references: impl Iterator<Item = u32>) {
    words.extend(references);
    if let Some(last) = words.last_mut() {
        *last |= LAST;
    }
}

/// The references of a list.
pub(super) fn listed(words: &[u32]) -> impl Iterator<Item = u32> {
    let end = words.iter().position(|word| word & LAST != 0).map_or(words.len(), |last| last + 1);
    words[..end].iter().copied()
}

struct Builder<'a> {
    pieces: &'a [Piece],
    first_texel: usize,
    words: &'a mut Vec<u32>,
    /// Length of the longest list.
    longest: usize,
}

impl Builder<'_> {
    /// Fills the cells of a lattice, which begin at a word. The parity of its samples is `base` and
    /// that of `references` together.
    fn fill(
        &mut self,
        first: usize,
        lattice: &Lattice,
        references: &[Reference],
        base: bool,
        may_refine: bool,
    ) {
        let columns = lattice.bounds(0);
        let rows = lattice.bounds(1);
        let corners = self.corners(&columns, &rows, references, base);
        let (starts, members) = self.members(&columns, &rows, references);
        for (cell, range) in starts.windows(2).enumerate() {
            let corner = Vec2::new(columns[cell % columns.len()][1], rows[cell / columns.len()][0]);
            let listed = &members[range[0] as usize..range[1] as usize];
            self.words[first + cell] = if listed.is_empty() {
                u32::from(corners[cell])
            } else {
                let bounds = [columns[cell % columns.len()], rows[cell / columns.len()]];
                self.list(listed, corners[cell], corner, bounds, may_refine)
            };
        }
    }

    /// Appends what a cell with pieces needs, and returns its word.
    fn list(
        &mut self,
        listed: &[u32],
        corner_cut: bool,
        corner: Vec2,
        [[left, right], [bottom, top]]: [Bounds; 2],
        may_refine: bool,
    ) -> u32 {
        let references: Vec<Reference> = listed
            .iter()
            .map(|piece| Reference::new(*piece as usize, &self.pieces[*piece as usize], right))
            .collect();
        // Such that the corner itself comes out right.
        let base = references.iter().fold(corner_cut, |cut, reference| {
            let piece = &self.pieces[reference.piece as usize];
            cut ^ piece.crosses(corner) ^ reference.end_reached(piece, corner.y)
        });
        if may_refine && references.len() > CROWDED && self.words.len() < MANY_WORDS {
            let finer = self.finer(&references, Vec2::new(left, bottom), Vec2::new(right, top));
            if finer.count() > 1 {
                let header = self.words.len();
                self.words.extend(finer.words());
                let first = self.words.len();
                self.words.resize(first + finer.count(), 0);
                self.fill(first, &finer, &references, base, false);
                return header as u32 * 8 + FINER;
            }
        }
        let list = self.words.len();
        self.longest = self.longest.max(references.len());
        let words =
            references.iter().map(|r| r.word(&self.pieces[r.piece as usize], self.first_texel));
        push_list(self.words, words);
        list as u32 * 8 + LIST + u32::from(base)
    }

    /// The lattice of a crowded cell; a coarser one if its pieces are large, so that the references
    /// do not outgrow them.
    fn finer(&self, references: &[Reference], least: Vec2, most: Vec2) -> Lattice {
        const MOST_REFERENCES_PER_PIECE: f32 = 6.0;
        let extent = most - least;
        let mut side = finer_side(references.len());
        let cells_at = |side: u32| -> f32 {
            let cells = |reference: &Reference| {
                let piece = &self.pieces[reference.piece as usize];
                let size = (piece.high - piece.low).abs().min(extent) / extent * side as f32;
                (size.x + 1.0) * (size.y + 1.0)
            };
            references.iter().map(cells).sum()
        };
        while side > 1 && cells_at(side) > MOST_REFERENCES_PER_PIECE * references.len() as f32 {
            side /= 2;
        }
        Lattice::new(least, most, side)
    }

    /// Whether the corner of each cell, at its right and its bottom, is cut.
    fn corners(
        &self,
        columns: &[Bounds],
        rows: &[Bounds],
        references: &[Reference],
        base: bool,
    ) -> Vec<bool> {
        // Each entry turns the parity of its column and of those to the right of it.
        let width = columns.len();
        let mut turns = vec![false; (width + 1) * rows.len()];
        let mut row_turns = vec![false; rows.len() + 1];
        for reference in references {
            let piece = &self.pieces[reference.piece as usize];
            let end = match reference.beyond {
                Beyond::Neither => None,
                Beyond::Low => Some(piece.low.y),
                Beyond::High => Some(piece.high.y),
            };
            if let Some(v) = end {
                row_turns[rows.partition_point(|[bottom, _]| *bottom < v)] ^= true;
            }
            let first = rows.partition_point(|[bottom, _]| *bottom < piece.low.y);
            let last = rows.partition_point(|[bottom, _]| *bottom < piece.high.y);
            for row in first..last {
                let v = rows[row][0];
                let [least, most] = piece.u_range();
                let surely = columns.partition_point(|[_, right]| *right < least);
                turns[row * (width + 1)] ^= true;
                turns[row * (width + 1) + surely] ^= true;
                let maybe = columns[surely..].iter().take_while(|[_, right]| *right < most);
                for (column, [_, right]) in (surely..).zip(maybe) {
                    if piece.crosses(Vec2::new(*right, v)) {
                        turns[row * (width + 1) + column] ^= true;
                        turns[row * (width + 1) + column + 1] ^= true;
                    }
                }
            }
        }
        let mut corners = Vec::with_capacity(width * rows.len());
        let mut row_cut = base;
        for row in 0..rows.len() {
            row_cut ^= row_turns[row];
            let mut cut = row_cut;
            for column in 0..width {
                cut ^= turns[row * (width + 1) + column];
                corners.push(cut);
            }
        }
        corners
    }

    /// The pieces that touch each cell: those of cell i are `members[starts[i]..starts[i + 1]]`.
    fn members(
        &self,
        columns: &[Bounds],
        rows: &[Bounds],
        references: &[Reference],
    ) -> (Vec<u32>, Vec<u32>) {
        let cells = columns.len() * rows.len();
        let mut starts = vec![0_u32; cells + 1];
        let each = |visit: &mut dyn FnMut(usize, u32)| {
            for reference in references {
                let piece = &self.pieces[reference.piece as usize];
                let [least, most] = piece.u_range();
                for row in touched(rows, [piece.low.y, piece.high.y]) {
                    for column in touched(columns, [least, most]) {
                        visit(row * columns.len() + column, reference.piece);
                    }
                }
            }
        };
        each(&mut |cell, _| starts[cell + 1] += 1);
        for cell in 0..cells {
            starts[cell + 1] += starts[cell];
        }
        let mut members = vec![0; starts[cells] as usize];
        let mut next = starts.clone();
        each(&mut |cell, piece| {
            members[next[cell] as usize] = piece;
            next[cell] += 1;
        });
        (starts, members)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trim::pieces::monotone_curves;
    use crate::{Segment, TrimLoop};
    use proptest::prelude::*;

    /// The bounds of every cell that can be looked up, finer ones too, and the pieces it lists.
    fn cells(grid: &Grid, words: &[u32]) -> Vec<([Bounds; 2], Vec<usize>)> {
        let mut found = Vec::new();
        let mut lattices = vec![(grid.lattice, HEADER_WORDS)];
        while let Some((lattice, first)) = lattices.pop() {
            let [columns, rows] = [0, 1].map(|axis| lattice.bounds(axis));
            for cell in 0..lattice.count() {
                let [column, row] = [cell % columns.len(), cell / columns.len()];
                let bounds = [columns[column], rows[row]];
                let word = words[first + cell];
                let at = (word >> 3) as usize;
                if word & 7 == FINER {
                    let corner = |i: usize| Vec2::new(bounds[0][i], bounds[1][i]);
                    let side = words[at + 4];
                    let finer = Lattice::new(corner(0), corner(1), side);
                    assert_eq!(finer.words(), words[at..at + Lattice::WORDS]);
                    lattices.push((finer, at + Lattice::WORDS));
                } else if word & LIST != 0 {
                    let piece =
                        |word: u32| ((word >> 4) as usize * 4 - grid.pieces.start) / PIECE_WORDS;
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
    fn lenses(side: usize, step: f64, least: f64) -> Vec<TrimLoop> {
        let lens = |i: usize| {
            let (u, v) = (least + step * (i % side) as f64, least + step * (i / side) as f64);
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

    fn check(loops: &[TrimLoop], rows: &[f32]) {
        let mut words = vec![0; HEADER_WORDS];
        let Some(grid) = build(&monotone_curves(loops), false, &mut words) else { return };
        let pieces: Vec<Piece> =
            words[grid.pieces.clone()].chunks_exact(PIECE_WORDS).map(Piece::from_words).collect();
        for (bounds, listed) in cells(&grid, &words) {
            let mut is_listed = vec![false; pieces.len()];
            for piece in listed {
                is_listed[piece] = true;
            }
            for (piece, is_listed) in pieces.iter().zip(is_listed) {
                let [least, most] = piece.u_range();
                let touches = least <= bounds[0][1]
                    && most >= bounds[0][0]
                    && piece.low.y <= bounds[1][1]
                    && piece.high.y >= bounds[1][0];
                assert_eq!(is_listed, touches, "{piece:?} in {bounds:?}");
            }
        }
        // The end points alone decide how many pieces a row meets: an even number.
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
        let grid = build(&monotone_curves(&loops), false, &mut words).unwrap();
        let cells = &words[HEADER_WORDS..][..grid.lattice.count()];
        assert!(cells.iter().any(|cell| cell & 7 == FINER));
        check(&loops, &[0.5, 0.505]);
    }

    #[test]
    fn ten_thousand_spread_segments_take_less_than_200_bytes_each() {
        let loops = lenses(71, 1.0 / 71.0, 0.0);
        let mut words = vec![0; HEADER_WORDS];
        let grid = build(&monotone_curves(&loops), false, &mut words).unwrap();
        let segments = 2 * loops.len();
        assert!(segments >= 10_000 && grid.pieces.len() >= PIECE_WORDS * segments);
        assert!(4 * words.len() <= 200 * segments, "{} bytes", 4 * words.len());
    }

    #[test]
    fn a_hundred_thousand_long_segments_do_not_grow_the_grid_beyond_bounds() {
        let points: Vec<(f64, f64)> = (0..300_000)
            .map(|i| {
                (f64::from(i * 7919 % 10_007) / 10_007.0, f64::from(i * 104_729 % 9973) / 9973.0)
            })
            .collect();
        let mut words = vec![0; HEADER_WORDS];
        let grid = build(&monotone_curves(&[chain(&points)]), false, &mut words).unwrap();
        assert!(4 * words.len() < 400 << 20, "{} MiB", words.len() >> 18);
        assert!(grid.longest > LONG_LIST);
    }

    #[test]
    fn what_has_no_inside_has_no_grid() {
        let level = [(0.2, 0.5), (0.4, 0.5), (0.6, 0.5), (0.8, 0.5), (0.6, 0.5), (0.4, 0.5)];
        let outside = level.map(|(u, v)| (u + 2.0, v * 3.0 * u));
        for points in [level, level.map(|(u, v)| (v, u)), outside] {
            assert_eq!(
                build(&monotone_curves(&[chain(&points)]), false, &mut vec![0; HEADER_WORDS]),
                None
            );
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
