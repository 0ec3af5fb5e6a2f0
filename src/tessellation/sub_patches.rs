//! Sub-patches of patches: their sizes, chosen to suit drivers, and the result of trimming them.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::scene::TessLevel;
use crate::trim::TrimGrid;

/// The number of vertices that one draw of filled triangles may generate. Mesa's software driver indexes the vertices
/// of a draw with 16 bits (more than 65,535 render garbage without an error), and its time grows quadratically long
/// before that. Much smaller draws cost a call each.
const VERTICES_PER_DRAW: u32 = 8_000;

/// The same for wireframe lines, where that driver iterates over all vertices of a draw every few dozen lines.
const VERTICES_PER_DRAW_OF_LINES: u32 = 1_100;

/// A patch above this level is drawn as four sub-patches if its level is even. Otherwise a draw could not be smaller
/// than the patch, and a patch of level 64 has 4,225 vertices.
const MAX_WHOLE_LEVEL: u32 = 32;

/// How a patch is passed to the tessellator: as `side` × `side` sub-patches of its domain, each at `level`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Split {
    /// Sub-patches along one side of the patch.
    pub(crate) side: u32,
    /// Level of one sub-patch.
    pub(crate) level: u32,
}

impl Split {
    /// The sub-patches of a patch at a level. Their vertices are those of the unsplit patch, but the diagonals follow
    /// each sub-patch.
    pub(crate) const fn of(level: TessLevel) -> Self {
        let level = level.get();
        if level > MAX_WHOLE_LEVEL && level.is_multiple_of(2) {
            Self { side: 2, level: level / 2 }
        } else {
            Self { side: 1, level }
        }
    }

    /// Smaller sub-patches, about 8 a side, for patches with trims. Sub-patches that are kept entirely are drawn
    /// without trim code; those that are cut away entirely are not drawn. All sub-patches of a patch are squares of
    /// one level. `None` if the level cannot be divided this way.
    pub(crate) fn smaller(level: TessLevel) -> Option<Self> {
        let level = level.get();
        let divides = |side: &u32| level.is_multiple_of(*side);
        let side = (8..=15).find(divides).or_else(|| (2..8).rev().find(divides))?;
        Some(Self { side, level: level / side })
    }

    /// Column and row of each sub-patch.
    fn places(self) -> impl Iterator<Item = [u32; 2]> {
        (0..self.side * self.side)
            .map(move |sub_patch| [sub_patch % self.side, sub_patch / self.side])
    }

    /// The origin of each sub-patch in the domain, and its side length: (u, v, length).
    pub(crate) fn domains(self) -> impl Iterator<Item = Vec3> {
        let length = 1.0 / self.side as f32;
        self.places().map(move |[u, v]| (Vec2::new(u as f32, v as f32) * length).extend(length))
    }

    /// The number of patches whose sub-patch fits in one draw.
    pub(crate) fn patches_per_draw(self, wireframe: bool) -> usize {
        patches_per_draw(self.level, wireframe)
    }
}

/// The result of trimming a sub-patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cut {
    /// The whole sub-patch is kept.
    Kept,
    /// A region of it is kept, or the result is unknown.
    Trimmed,
    /// The whole sub-patch is cut away.
    Gone,
}

impl Cut {
    fn of(grid: &TrimGrid, side: [u32; 2], place: [u32; 2]) -> Self {
        let corner = |place: [u32; 2]| {
            Vec2::new(place[0] as f32 / side[0] as f32, place[1] as f32 / side[1] as f32)
        };
        match grid.cut_throughout(corner(place), corner(place.map(|i| i + 1))) {
            Some(true) => Self::Gone,
            Some(false) => Self::Kept,
            None => Self::Trimmed,
        }
    }

    pub(crate) fn is_drawn(self) -> bool {
        self != Self::Gone
    }

    pub(crate) fn is_trimmed(self) -> bool {
        self == Self::Trimmed
    }
}

/// A patch is split only if the trimmed share of the domain shrinks below this factor.
const WORTH_IT: f32 = 0.8;

/// A patch split at one level: columns and rows of the sub-patches that the trims keep entirely, and of those that
/// the trims may cut. Sub-patches that are cut away entirely are omitted.
#[derive(Debug, Clone)]
pub(crate) struct FixedSplit {
    pub(crate) split: Split,
    pub(crate) kept: Vec<[u32; 2]>,
    pub(crate) trimmed: Vec<[u32; 2]>,
}

impl FixedSplit {
    /// Splits a patch at a level. It uses smaller sub-patches only if they reduce the area that needs trimming.
    pub(crate) fn new(grid: &TrimGrid, level: TessLevel) -> Self {
        let whole = Self::into(grid, Split::of(level));
        match Split::smaller(level) {
            Some(split) if !whole.trimmed.is_empty() => {
                let smaller = Self::into(grid, split);
                let worth_it = smaller.trimmed_share() < WORTH_IT * whole.trimmed_share();
                if worth_it { smaller } else { whole }
            }
            _ => whole,
        }
    }

    /// Splits a patch without trims at a level.
    pub(crate) fn untrimmed(level: TessLevel) -> Self {
        let split = Split::of(level);
        Self { split, kept: split.places().collect(), trimmed: Vec::new() }
    }

    fn into(grid: &TrimGrid, split: Split) -> Self {
        let (mut kept, mut trimmed) = (Vec::new(), Vec::new());
        for place in split.places() {
            match Cut::of(grid, [split.side; 2], place) {
                Cut::Gone => {}
                Cut::Kept => kept.push(place),
                Cut::Trimmed => trimmed.push(place),
            }
        }
        Self { split, kept, trimmed }
    }

    fn trimmed_share(&self) -> f32 {
        self.trimmed.len() as f32 / (self.split.side * self.split.side) as f32
    }
}

/// The results of trimming the sub-patches of patches with one grid, for every subdivision requested so far.
#[derive(Debug, Clone)]
pub(crate) struct TrimSplits {
    grid: Arc<TrimGrid>,
    /// Results by split depth along u and v, row by row.
    known: Vec<([u8; 2], Vec<Cut>)>,
    /// The largest split depth that reduces the area that needs trimming.
    useful: u8,
}

impl TrimSplits {
    /// More than 2³ sub-patches a side save little more.
    const MAX_DEPTH: u8 = 3;

    pub(crate) fn new(grid: &Arc<TrimGrid>) -> Self {
        let mut sub_patches = Self { grid: Arc::clone(grid), known: Vec::new(), useful: 0 };
        let mut share = |depth: u8| {
            let cuts = sub_patches.cuts([depth; 2]);
            cuts.iter().filter(|cut| cut.is_trimmed()).count() as f32 / cuts.len() as f32
        };
        let whole = share(0);
        let useful = (1..=Self::MAX_DEPTH).rev().find(|depth| share(*depth) < WORTH_IT * whole);
        sub_patches.useful = useful.unwrap_or(0);
        sub_patches
    }

    pub(crate) fn grid(&self) -> &TrimGrid {
        &self.grid
    }

    /// The best split depth along each side for a patch with the given screen diagonal in pixels. Smaller sub-patches
    /// cost more in vertices than they save in fragments.
    pub(crate) fn depth(&self, extent: f32) -> u8 {
        const MIN_PX: f32 = 48.0;
        let depth = (extent / MIN_PX).max(1.0).log2().floor();
        self.useful.min(depth as u8)
    }

    /// The result of trimming each sub-patch at a split depth along u and v, row by row.
    pub(crate) fn cuts(&mut self, depth: [u8; 2]) -> &[Cut] {
        let place = self.known.iter().position(|(known, _)| *known == depth);
        let place = place.unwrap_or_else(|| {
            let side = depth.map(|depth| 1_u32 << depth);
            let cuts = (0..side[0] * side[1])
                .map(|i| Cut::of(&self.grid, side, [i % side[0], i / side[0]]))
                .collect();
            self.known.push((depth, cuts));
            self.known.len() - 1
        });
        &self.known[place].1
    }
}

fn patches_per_draw(level: u32, wireframe: bool) -> usize {
    let max = if wireframe { VERTICES_PER_DRAW_OF_LINES } else { VERTICES_PER_DRAW };
    (max / ((level + 1) * (level + 1))).max(1) as usize
}

/// The number of vertices and triangles that the tessellator generates for a patch of OpenGL: a sub-patch, or a
/// triangle of a mesh. Both are 0 for a patch that is not drawn.
pub(crate) trait Tessellated {
    fn vertices(&self) -> u32;
    fn triangles(&self) -> u64;
}

/// The number of vertices that one draw should have.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DrawSize {
    /// As few as cost little: Mesa's software driver gathers them patch by patch in memory that it
    /// enlarges for each, and asks the system for more from 128 KiB on.
    Small,
    /// As many as 16 bits count on every driver, and more.
    Large,
}

impl DrawSize {
    /// The maximum number of vertices of a draw or of an instance, unless a single patch has more.
    pub(crate) const fn vertices(self) -> u32 {
        match self {
            Self::Small => 800,
            Self::Large => 32_000,
        }
    }
}

/// The number of sub-patches at the front of the sequence that make one draw of at most `max` vertices, given their
/// vertex counts.
pub(crate) fn patches_of_next_draw(vertices: impl Iterator<Item = u32>, max: u32) -> usize {
    let mut sum = 0;
    let fitting = vertices.take_while(|vertices| {
        sum += vertices;
        sum <= max
    });
    fitting.count().max(1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trim::{Keep, Trims};

    #[test]
    fn no_draw_makes_more_vertices_than_16_bits_count() {
        for level in 1..=64 {
            for wireframe in [false, true] {
                let split = Split::of(TessLevel::new(level).unwrap());
                let vertices = (split.level + 1) * (split.level + 1);
                let drawn = split.patches_per_draw(wireframe) as u32 * vertices;
                assert!(drawn >= vertices && drawn <= VERTICES_PER_DRAW);
                assert_eq!(split.side * split.level, level as u32);
            }
        }
    }

    #[test]
    fn parts_tile_the_domain() {
        let whole: Vec<Vec3> = Split::of(TessLevel::new(32).unwrap()).domains().collect();
        assert_eq!(whole, [Vec3::new(0.0, 0.0, 1.0)]);
        let sub_patches: Vec<Vec3> = Split::of(TessLevel::MAX).domains().collect();
        assert_eq!(sub_patches.len(), 4);
        assert_eq!(sub_patches[3], Vec3::splat(0.5));
        assert_eq!(Split::of(TessLevel::new(63).unwrap()).side, 1);
        for level in 1..=64 {
            let level = TessLevel::new(level).unwrap();
            for split in Split::smaller(level).into_iter().chain([Split::of(level)]) {
                assert_eq!(split.side * split.level, level.get());
                assert_eq!(split.places().count() as u32, split.side * split.side);
            }
        }
        let side = |level| Split::smaller(TessLevel::new(level).unwrap()).map(|split| split.side);
        let expected = [None, Some(7), Some(12), None, Some(8), Some(8)];
        assert_eq!([1, 7, 12, 31, 32, 64].map(side), expected);
    }

    #[test]
    fn a_split_leaves_out_what_is_cut_and_tells_what_is_kept() {
        let mut trims = Trims::default();
        let level = TessLevel::new(32).unwrap();
        let whole = FixedSplit::new(&TrimGrid::new(&trims), level);
        assert_eq!((whole.split.side, whole.kept.len(), whole.trimmed.len()), (1, 1, 0));
        // A square of 4 × 4 of the 8 × 8 sub-patches, its border a little inside theirs.
        trims.add_svg_path("M.255 .255 H.745 V.745 H.255Z").unwrap();
        let split = FixedSplit::new(&TrimGrid::new(&trims), level);
        assert_eq!(split.split.side, 8);
        assert_eq!((split.kept.len(), split.trimmed.len()), (64 - 16, 16 - 4));
        trims.keep = Keep::Inside;
        let split = FixedSplit::new(&TrimGrid::new(&trims), level);
        assert_eq!((split.kept.len(), split.trimmed.len()), (4, 16 - 4));
    }
}
