//! Finds neighbouring patches: patches that share the control points of an edge, in either direction. Both sides of
//! an edge must be divided at the same parameters.

use glam::DVec4;

use super::disjoint_sets::DisjointSets;
use crate::bezier::{Degree, PatchGrid};

/// The sides of a patch in the order of `gl_TessLevelOuter`: u = 0, v = 0, u = 1, v = 1.
pub(crate) const SIDES: usize = 4;

/// An edge that has no number yet.
const UNKNOWN: u32 = u32::MAX;

/// For each patch, the indices of its four edges.
#[derive(Debug, Default)]
pub(crate) struct EdgeTable {
    edges: Vec<[u32; SIDES]>,
    count: usize,
}

/// Patches that may share edges, because their surfaces have the same transform.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EdgeSource<'a> {
    pub(crate) degree: Degree,
    /// Control points of all patches.
    pub(crate) points: &'a [DVec4],
    /// Surfaces of different groups share no edges.
    pub(crate) group: u32,
    /// For a NURBS surface: which of its patches are neighbours.
    pub(crate) grid: Option<&'a PatchGrid>,
}

/// One side of a patch, in a form that can be sorted so that equal sides are adjacent.
struct Side {
    hash: u64,
    source: u32,
    /// Of the source.
    patch: u32,
    /// Of all.
    place: u32,
}

impl EdgeTable {
    /// Finds the neighbours among the patches of all sources. Patches are indexed consecutively over all sources.
    pub(crate) fn new(sources: &[EdgeSource<'_>]) -> Self {
        let count = |source: &EdgeSource<'_>| source.points.len() / source.degree.points();
        let patches = sources.iter().map(count).sum();
        let mut table = Self { edges: vec![[UNKNOWN; SIDES]; patches], count: 0 };
        let mut sides = Vec::new();
        let mut first = 0;
        for (number, source) in (0..).zip(sources) {
            if let Some(grid) = source.grid {
                table.number_within(grid, first);
            }
            // Other surfaces may touch this one along edges within it, too.
            let only_borders = sources.len() == 1;
            for (patch, points) in (0..).zip(source.points.chunks_exact(source.degree.points())) {
                for side in 0..SIDES {
                    let place = ((first + patch as usize) * SIDES + side) as u32;
                    if only_borders && table.number(place) != UNKNOWN {
                        continue;
                    }
                    let hash = hash(source.group, edge(source.degree, points, side));
                    sides.push(Side { hash, source: number, patch, place });
                }
            }
            first += count(source);
        }
        sides.sort_unstable_by_key(|side| (side.hash, side.place));
        let points_of = |side: &Side| {
            let source = &sources[side.source as usize];
            let all = source.degree.points();
            let points = &source.points[side.patch as usize * all..][..all];
            (source.group, edge(source.degree, points, side.place as usize % SIDES))
        };
        // For each number, the number that replaces it.
        let mut replaced: Vec<u32> = (0..table.count as u32).collect();
        for same_hash in sides.chunk_by(|a, b| a.hash == b.hash) {
            // Apart from collisions, all sides with one hash belong to one edge.
            for (i, side) in same_hash.iter().enumerate() {
                let (group, points) = points_of(side);
                let known = same_hash[..i].iter().find(|other| {
                    let (other_group, others) = points_of(other);
                    group == other_group && points.clone().eq(others)
                });
                let known = known.map(|other| replaced[table.number(other.place) as usize]);
                match (table.number(side.place), known) {
                    (UNKNOWN, Some(number)) => *table.number_mut(side.place) = number,
                    (UNKNOWN, None) => {
                        replaced.push(table.count as u32);
                        *table.number_mut(side.place) = table.count as u32;
                        table.count += 1;
                    }
                    (own, Some(number)) => replaced[own as usize] = number,
                    (_, None) => {}
                }
            }
        }
        table.renumber(&replaced);
        table
    }

    /// Numbers the edges between the patches of a NURBS surface, whose first patch has the index `first`.
    fn number_within(&mut self, grid: &PatchGrid, first: usize) {
        let (columns, rows) = (grid.columns.len(), grid.rows.len());
        for row in 0..rows {
            for column in 0..columns {
                let patch = first + row * columns + column;
                let right = first + row * columns + (column + 1) % columns;
                let above = first + (row + 1) % rows * columns + column;
                for (continues, side, neighbour, beside) in [
                    (grid.column_continues[column], 2, right, 0),
                    (grid.row_continues[row], 3, above, 1),
                ] {
                    if continues {
                        self.edges[patch][side] = self.count as u32;
                        self.edges[neighbour][beside] = self.count as u32;
                        self.count += 1;
                    }
                }
            }
        }
    }

    /// Renumbers the edges in the order in which the patches first use them, so that iterating over the patches reads
    /// the edges' memory in order. Numbers that are replaced by others are dropped.
    fn renumber(&mut self, replaced: &[u32]) {
        let mut numbers = vec![UNKNOWN; self.count];
        let mut next = 0;
        for edge in self.edges.as_flattened_mut() {
            let number = &mut numbers[replaced[*edge as usize] as usize];
            if *number == UNKNOWN {
                *number = next;
                next += 1;
            }
            *edge = *number;
        }
        self.count = next as usize;
    }

    fn number(&self, place: u32) -> u32 {
        self.edges[place as usize / SIDES][place as usize % SIDES]
    }

    fn number_mut(&mut self, place: u32) -> &mut u32 {
        &mut self.edges[place as usize / SIDES][place as usize % SIDES]
    }

    /// For each source, the first source that it is connected to through shared edges.
    pub(crate) fn connected(&self, sources: &[EdgeSource<'_>]) -> Vec<usize> {
        let mut sets = DisjointSets::new(sources.len());
        let mut owner = vec![usize::MAX; self.count];
        let mut patch = 0;
        for (number, source) in sources.iter().enumerate() {
            for _ in 0..source.points.len() / source.degree.points() {
                for edge in self.of(patch) {
                    if owner[edge] == usize::MAX {
                        owner[edge] = number;
                    }
                    sets.join(owner[edge], number);
                }
                patch += 1;
            }
        }
        (0..sources.len()).map(|source| sets.least(source)).collect()
    }

    /// The number of distinct edges.
    pub(crate) const fn count(&self) -> usize {
        self.count
    }

    /// For each side of each patch, whether it is no side of another one.
    pub(crate) fn open_sides(&self) -> Vec<[bool; SIDES]> {
        let mut uses = vec![0; self.count];
        self.edges.as_flattened().iter().for_each(|edge| uses[*edge as usize] += 1);
        self.edges.iter().map(|edges| edges.map(|edge| uses[edge as usize] == 1)).collect()
    }

    /// The edges of a patch.
    pub(crate) fn of(&self, patch: usize) -> [usize; SIDES] {
        self.edges[patch].map(|edge| edge as usize)
    }
}

/// The control points of a side, starting from the end that comes first in a fixed order.
fn edge(
    degree: Degree,
    points: &[DVec4],
    side: usize,
) -> impl Iterator<Item = [u64; 4]> + Clone + '_ {
    let place = SideOfPatch::new(degree, side);
    let n = place.count;
    // Weights scaled by a common factor describe the same curve.
    let line = (0..n).map(|i| points[place.index(i)]);
    let scale = line.map(|point| point.w).fold(0.0, f64::max).log2().floor().exp2();
    let at = move |i: usize| {
        let point = points[place.index(i)];
        // Adding 0 turns −0 into 0.
        let point = point.truncate().extend(point.w / scale) + DVec4::ZERO;
        point.to_array().map(f64::to_bits)
    };
    let reversed = (0..n).map(at).gt((0..n).rev().map(at));
    (0..n).map(move |i| at(if reversed { n - 1 - i } else { i }))
}

/// Where the control points of a side of a patch are.
#[derive(Debug, Clone, Copy)]
pub(super) struct SideOfPatch {
    first: usize,
    step: usize,
    pub(super) count: usize,
}

impl SideOfPatch {
    pub(super) const fn new(degree: Degree, side: usize) -> Self {
        let (columns, rows) = (degree.columns(), degree.rows());
        let (first, step, count) = match side {
            0 => (0, columns, rows),
            1 => (0, 1, columns),
            2 => (columns - 1, columns, rows),
            _ => (columns * (rows - 1), 1, columns),
        };
        Self { first, step, count }
    }

    /// The index in the patch of point `i` of the side, in the direction of its parameter.
    pub(super) const fn index(self, i: usize) -> usize {
        self.first + i * self.step
    }
}

/// FNV-1a over 64-bit words, its high bits mixed in.
fn hash(group: u32, points: impl Iterator<Item = [u64; 4]>) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325 ^ u64::from(group);
    for word in points.flatten() {
        hash = (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        hash ^= hash >> 29;
    }
    hash
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A patch over the square that begins at (x, y), its points turned and mirrored by `turn`.
    fn patch(degree: Degree, x: f64, y: f64, turn: u32) -> Vec<DVec4> {
        let n = degree.columns();
        let last = n - 1;
        (0..n * n)
            .map(|i| {
                let (mut column, mut row) = (i % n, i / n);
                for _ in 0..turn % 4 {
                    (column, row) = (last - row, column);
                }
                if turn >= 4 {
                    (column, row) = (row, column);
                }
                let at = |i: usize| i as f64 / last as f64;
                let (x, y) = (x + at(column), y + at(row));
                DVec4::new(x, y, (3.0 * x).sin() * y, 1.0)
            })
            .collect()
    }

    #[test]
    fn neighbours_are_found_in_all_eight_orientations() {
        for degree in [Degree::CUBIC, Degree::QUARTIC] {
            for turn in 0..8 {
                let mut points = patch(degree, 0.0, 0.0, 0);
                points.extend(patch(degree, 1.0, 0.0, turn));
                let table =
                    EdgeTable::new(&[EdgeSource { degree, points: &points, group: 0, grid: None }]);
                assert_eq!(table.count(), 7, "{turn}");
                assert!(table.of(1).contains(&table.of(0)[2]), "{turn}");
            }
        }
    }

    #[test]
    fn groups_and_other_weights_keep_edges_apart() {
        let (a, mut b) = (patch(Degree::CUBIC, 0.0, 0.0, 0), patch(Degree::CUBIC, 1.0, 0.0, 0));
        let count = |a: &[DVec4], b: &[DVec4], group: u32| {
            let source =
                |points, group| EdgeSource { degree: Degree::CUBIC, points, group, grid: None };
            EdgeTable::new(&[source(a, 0), source(b, group)]).count()
        };
        assert_eq!((count(&a, &b, 0), count(&a, &b, 1)), (7, 8));
        b[4].w = 2.0;
        assert_eq!(count(&a, &b, 0), 8);
        b.iter_mut().for_each(|point| point.w = 2.0);
        assert_eq!(count(&a, &b, 0), 7);
    }
}
