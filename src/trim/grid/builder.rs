//! Finds the pieces that each cell lists, and the winding number at the cell's corner.

use std::ops::Range;

use glam::Vec2;

use super::cutting::{FilledCurve, finer_side};
use super::{
    CROWDED, EVEN_ODD, FALLS, FINER, HEADER_WORDS, LAST_HEAD, LIST, PIECE_WORDS, end_list,
};
use crate::trim::FillRule;
use crate::trim::pieces::Piece;
use crate::trim::uniform_grid::{BELOW_ONE, Bounds, UniformGrid, count_before, touched};

/// Bit of a reference to a piece that bulges to the left of its chord.
const LEFT: u32 = 8;
/// A grid of more words is not subdivided further.
const MANY_WORDS: usize = 1 << 26;

/// A piece with the direction of its loop and the fill that it belongs to.
pub(super) struct Member {
    pub(super) piece: Piece,
    /// Whether the loop runs from its upper to its lower end.
    falls: bool,
    /// The number of the fill.
    fill: u32,
}

impl Member {
    /// The piece of a curve. `None` if rounding leaves only a point.
    pub(super) fn of(FilledCurve { curve, fill }: &FilledCurve) -> Option<Self> {
        let piece = Piece::new(curve)?;
        Some(Self { piece, falls: curve[0].y > curve[3].y, fill: *fill })
    }

    /// The piece's contribution to a winding number if the ray crosses it.
    fn turn(&self) -> i32 {
        if self.falls { -1 } else { 1 }
    }
}

/// A cell's reference to a piece: the number of the piece, and which end, if only one, lies to the right of the cell.
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

/// The pieces of one fill that the samples of a cell are tested against.
struct Group {
    fill: usize,
    /// The winding number of a sample whose ray meets no piece.
    base: i32,
    references: Vec<Reference>,
}

/// Pieces of one fill in one cell.
struct Listed {
    cell: usize,
    fill: usize,
    /// The winding number at the cell's lower right corner.
    corner: i32,
    /// The range of the pieces' numbers in the list of all cells' pieces.
    members: Range<usize>,
}

pub(super) struct Builder<'a> {
    pub(super) members: &'a [Member],
    pub(super) rules: &'a [FillRule],
    /// Whether lists have heads.
    pub(super) has_rules: bool,
    /// Whether points outside all fills are cut.
    pub(super) outside: bool,
    /// The index of the word where the pieces begin.
    pub(super) first_piece: usize,
    pub(super) words: &'a mut Vec<u32>,
    /// Length of the longest list.
    pub(super) longest: usize,
}

impl Builder<'_> {
    /// Writes the cells of the domain.
    pub(super) fn fill_domain(&mut self, uniform_grid: &UniformGrid) {
        let mut first = 0;
        let groups = self.members.chunk_by(|a, b| a.fill == b.fill).map(|members| {
            let pieces = first..first + members.len() as u32;
            first = pieces.end;
            let reference = |piece| Reference { piece, beyond: Beyond::Neither };
            Group {
                fill: members[0].fill as usize,
                base: 0,
                references: pieces.map(reference).collect(),
            }
        });
        let groups: Vec<Group> = groups.collect();
        self.fill(HEADER_WORDS, uniform_grid, &groups, true);
    }

    /// Writes the cells of a uniform grid, which begin at the word `first`. The grid is that of the domain or a finer
    /// one.
    fn fill(
        &mut self,
        first: usize,
        uniform_grid: &UniformGrid,
        groups: &[Group],
        is_domain: bool,
    ) {
        let [columns, rows] = &[0, 1].map(|axis| uniform_grid.bounds(axis));
        let mut inside = vec![false; uniform_grid.count()];
        let mut listed: Vec<Listed> = Vec::new();
        let mut members: Vec<u32> = Vec::new();
        for group in groups {
            // Complete loops have no inside beyond the columns and rows that they touch.
            let window = if is_domain || self.has_whole_loops(group) {
                self.touched(columns, rows, group)
            } else {
                [0..columns.len(), 0..rows.len()]
            };
            let [in_columns, in_rows] = [&columns[window[0].clone()], &rows[window[1].clone()]];
            let corners = self.corners(in_columns, in_rows, group);
            let (starts, touching) = self.members_of_cells(in_columns, in_rows, group);
            let before = members.len();
            members.extend(touching);
            let cells = window[1]
                .clone()
                .flat_map(|row| window[0].clone().map(move |column| row * columns.len() + column));
            let rule = self.rules[group.fill];
            for ((cell, corner), range) in cells.zip(corners).zip(starts.windows(2)) {
                if range[0] == range[1] {
                    inside[cell] |= rule.fills(corner);
                } else {
                    let members = before + range[0] as usize..before + range[1] as usize;
                    listed.push(Listed { cell, fill: group.fill, corner, members });
                }
            }
        }
        for (cell, inside) in inside.iter().enumerate() {
            self.words[first + cell] = u32::from(*inside != self.outside);
        }
        listed.sort_by_key(|listed| listed.cell);
        for listed in listed.chunk_by(|a, b| a.cell == b.cell) {
            let cell = listed[0].cell;
            if !inside[cell] {
                let bounds = [columns[cell % columns.len()], rows[cell / columns.len()]];
                let group =
                    |listed: &Listed| self.group(listed, &members[listed.members.clone()], bounds);
                // A cell nearly always has pieces of only one fill, which needs no vector of groups.
                let word = match listed {
                    [only] => self.list(&[group(only)], bounds, is_domain),
                    _ => {
                        let groups: Vec<Group> = listed.iter().map(group).collect();
                        self.list(&groups, bounds, is_domain)
                    }
                };
                self.words[first + cell] = word;
            }
        }
    }

    /// A cell's references to the pieces of one fill.
    fn group(&self, listed: &Listed, members: &[u32], [columns, rows]: [Bounds; 2]) -> Group {
        let corner = Vec2::new(columns[1].min(BELOW_ONE), rows[0]);
        let references: Vec<Reference> =
            members.iter().map(|piece| self.reference(*piece, corner.x)).collect();
        // The base is chosen so that the result at the corner itself is correct.
        let counted: i32 =
            references.iter().map(|reference| self.crossings(*reference, corner)).sum();
        Group { fill: listed.fill, base: listed.corner - counted, references }
    }

    fn member(&self, reference: Reference) -> &Member {
        &self.members[reference.piece as usize]
    }

    fn reference(&self, piece: u32, right: f32) -> Reference {
        let shape = &self.members[piece as usize].piece;
        let beyond = match (shape.low.x > right, shape.high.x > right) {
            (true, false) => Beyond::Low,
            (false, true) => Beyond::High,
            _ => Beyond::Neither,
        };
        Reference { piece, beyond }
    }

    /// A piece's contribution to the winding number of a sample in its cell.
    fn crossings(&self, reference: Reference, uv: Vec2) -> i32 {
        let member = self.member(reference);
        let end = match reference.beyond {
            Beyond::Neither => 0,
            Beyond::Low => -i32::from(member.piece.low.y <= uv.y),
            Beyond::High => i32::from(member.piece.high.y <= uv.y),
        };
        member.turn() * (i32::from(member.piece.crosses(uv)) + end)
    }

    /// The word of a reference in the shader's buffer.
    fn word(&self, reference: Reference) -> u32 {
        let member = self.member(reference);
        let left = if member.piece.bulges_left() { LEFT } else { 0 };
        let falls = if member.falls { FALLS } else { 0 };
        let number = (self.first_piece / PIECE_WORDS) as u32 + reference.piece;
        number * 32 + reference.beyond as u32 + left + falls
    }

    /// Appends the lists or the finer grid of a cell with pieces, and returns the cell's word.
    fn list(&mut self, groups: &[Group], bounds: [Bounds; 2], may_refine: bool) -> u32 {
        let count: usize = groups.iter().map(|group| group.references.len()).sum();
        if may_refine && count > CROWDED && self.words.len() < MANY_WORDS {
            let finer = self.finer(groups, count, bounds);
            if finer.count() > 1 {
                let header = self.words.len();
                self.words.extend(finer.words());
                let first = self.words.len();
                self.words.resize(first + finer.count(), 0);
                self.fill(first, &finer, groups, false);
                return header as u32 * 8 + FINER;
            }
        }
        let list = self.words.len();
        let mut turned = self.outside;
        for (number, group) in groups.iter().enumerate() {
            self.longest = self.longest.max(group.references.len());
            if self.has_rules {
                let is_last = number + 1 == groups.len();
                self.words.push(self.head(group, is_last));
            } else {
                turned ^= self.rules[group.fill].fills(group.base);
            }
            for reference in &group.references {
                let word = self.word(*reference);
                self.words.push(word);
            }
            end_list(self.words);
        }
        list as u32 * 8 + LIST + u32::from(turned)
    }

    /// The word before the references of a group.
    fn head(&self, group: &Group, is_last: bool) -> u32 {
        let rule = match self.rules[group.fill] {
            FillRule::EvenOdd => EVEN_ODD,
            FillRule::NonZero => 0,
        };
        (group.base * 4 + rule + if is_last { LAST_HEAD } else { 0 }) as u32
    }

    /// The uniform grid of a crowded cell. It is coarser if the cell's pieces are large, so that the number of
    /// references stays in proportion to the number of pieces.
    fn finer(&self, groups: &[Group], count: usize, [columns, rows]: [Bounds; 2]) -> UniformGrid {
        const MAX_REFERENCES_PER_PIECE: f32 = 6.0;
        let (min, max) = (Vec2::new(columns[0], rows[0]), Vec2::new(columns[1], rows[1]));
        let extent = max - min;
        let mut side = finer_side(count);
        let cells_at = |side: u32| -> f32 {
            let cells = |reference: &Reference| {
                let piece = &self.member(*reference).piece;
                let size = (piece.high - piece.low).abs().min(extent) / extent * side as f32;
                (size.x + 1.0) * (size.y + 1.0)
            };
            groups.iter().flat_map(|group| &group.references).map(cells).sum()
        };
        while side > 1 && cells_at(side) > MAX_REFERENCES_PER_PIECE * count as f32 {
            side /= 2;
        }
        UniformGrid::new(min, max, side)
    }

    /// Whether the pieces of a group form complete loops: at every v where pieces end, as many arrive as leave.
    fn has_whole_loops(&self, group: &Group) -> bool {
        if group.base != 0 || group.references.iter().any(|one| one.beyond != Beyond::Neither) {
            return false;
        }
        let ends = group.references.iter().flat_map(|reference| {
            let member = self.member(*reference);
            [(member.piece.low.y, member.turn()), (member.piece.high.y, -member.turn())]
        });
        let mut ends: Vec<(f32, i32)> = ends.collect();
        ends.sort_unstable_by(|(a, _), (b, _)| a.total_cmp(b));
        ends.chunk_by(|(a, _), (b, _)| a == b)
            .all(|ends| ends.iter().map(|(_, turn)| turn).sum::<i32>() == 0)
    }

    /// The range of columns and the range of rows that the pieces of a group touch.
    fn touched(&self, columns: &[Bounds], rows: &[Bounds], group: &Group) -> [Range<usize>; 2] {
        let (mut min, mut max) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for reference in &group.references {
            let piece = &self.member(*reference).piece;
            min = min.min(piece.low.min(piece.high));
            max = max.max(piece.low.max(piece.high));
        }
        [touched(columns, [min.x, max.x]), touched(rows, [min.y, max.y])]
    }

    /// The winding number at the lower right corner of each cell.
    fn corners(&self, columns: &[Bounds], rows: &[Bounds], group: &Group) -> Vec<i32> {
        // Each entry counts in its own column and in all columns to the right of it.
        let width = columns.len();
        let rights: Vec<f32> = columns.iter().map(|[_, right]| right.min(BELOW_ONE)).collect();
        let mut turns = vec![0; (width + 1) * rows.len()];
        let mut row_turns = vec![0; rows.len() + 1];
        for reference in &group.references {
            let member = self.member(*reference);
            let (piece, turn) = (&member.piece, member.turn());
            let rows_below = |v: f32| count_before(rows, v, |[bottom, _]| *bottom < v);
            match reference.beyond {
                Beyond::Neither => {}
                Beyond::Low => row_turns[rows_below(piece.low.y)] -= turn,
                Beyond::High => row_turns[rows_below(piece.high.y)] += turn,
            }
            let [min, max] = piece.u_range();
            // No sample lies on the right border.
            let surely = if min < 1.0 {
                count_before(columns, min, |[_, right]| *right < min)
            } else {
                width
            };
            for row in rows_below(piece.low.y)..rows_below(piece.high.y) {
                let v = rows[row][0];
                turns[row * (width + 1)] += turn;
                turns[row * (width + 1) + surely] -= turn;
                let maybe = rights[surely..].iter().take_while(|right| **right < max);
                for (column, right) in (surely..).zip(maybe) {
                    if piece.crosses(Vec2::new(*right, v)) {
                        turns[row * (width + 1) + column] += turn;
                        turns[row * (width + 1) + column + 1] -= turn;
                    }
                }
            }
        }
        let mut corners = Vec::with_capacity(width * rows.len());
        let mut row_number = group.base;
        for row in 0..rows.len() {
            row_number += row_turns[row];
            let mut number = row_number;
            for column in 0..width {
                number += turns[row * (width + 1) + column];
                corners.push(number);
            }
        }
        corners
    }

    /// The pieces that touch each cell and affect its result. Those of cell i are
    /// `members[starts[i]..starts[i + 1]]`.
    fn members_of_cells(
        &self,
        columns: &[Bounds],
        rows: &[Bounds],
        group: &Group,
    ) -> (Vec<u32>, Vec<u32>) {
        let cells = columns.len() * rows.len();
        let mut starts = vec![0_u32; cells + 1];
        let each = |visit: &mut dyn FnMut(usize, u32)| {
            for reference in &group.references {
                let piece = &self.member(*reference).piece;
                let [min, max] = piece.u_range();
                for row in touched(rows, [piece.low.y, piece.high.y]) {
                    if is_beside(piece, rows[row]) {
                        continue;
                    }
                    for column in touched(columns, [min, max]) {
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

/// Whether the cells of a row need not list a piece that touches them. This holds for pieces on the left border of
/// the domain, because no ray towards greater u meets them. It holds for pieces on the right border, because all
/// samples lie to the left of it. It also holds for level pieces that do not lie within the row.
fn is_beside(piece: &Piece, [bottom, top]: Bounds) -> bool {
    let [min, max] = piece.u_range();
    let is_beside = |v: f32| (v <= bottom) == (v <= top.min(BELOW_ONE));
    let is_level = piece.low.y == piece.high.y;
    max <= 0.0 || min >= 1.0 || (is_level && is_beside(piece.low.y))
}
