//! Parts of patches: sizes that the drivers ask for, and what the trims leave of them.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use crate::scene::TessLevel;
use crate::trim::TrimGrid;

/// Vertices that one draw of filled triangles may make. Mesa's software driver numbers the vertices
/// of a draw with 16 bits (more than 65,535 render garbage without an error) and slows down
/// quadratically long before; much smaller draws cost a call each.
const VERTICES_PER_DRAW: u32 = 8_000;

/// The same for lines, where that driver walks over all vertices of a draw every few dozen lines.
const VERTICES_PER_DRAW_OF_LINES: u32 = 1_100;

/// A patch above this level is drawn in four parts if its level is even: a draw is never smaller
/// than a patch, and one of level 64 has 4,225 vertices.
const MAX_WHOLE_LEVEL: u32 = 32;

/// How a patch is handed to the tessellator: `side` × `side` parts of its domain, each at `level`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Parts {
    /// Parts along one side of the patch.
    pub(crate) side: u32,
    /// Level of one part.
    pub(crate) level: u32,
}

impl Parts {
    /// The parts of a patch at a level. Their vertices are those of the whole patch; the diagonals
    /// are those of each part.
    pub(crate) const fn of(level: TessLevel) -> Self {
        let level = level.get();
        if level > MAX_WHOLE_LEVEL && level.is_multiple_of(2) {
            Self { side: 2, level: level / 2 }
        } else {
            Self { side: 1, level }
        }
    }

    /// Smaller parts, about 8 a side, for patches with trims: those wholly kept can do without the
    /// trims' code, and those wholly cut need not be drawn at all. All parts of a patch are squares of
    /// one level. None if the level cannot be cut so.
    pub(crate) fn smaller(level: TessLevel) -> Option<Self> {
        let level = level.get();
        let divides = |side: &u32| level.is_multiple_of(*side);
        let side = (8..=15).find(divides).or_else(|| (2..8).rev().find(divides))?;
        Some(Self { side, level: level / side })
    }

    /// Column and row of each part.
    fn places(self) -> impl Iterator<Item = [u32; 2]> {
        (0..self.side * self.side).map(move |part| [part % self.side, part / self.side])
    }

    /// Where each part begins in the domain, and the length of its side: (u, v, length).
    pub(crate) fn domains(self) -> impl Iterator<Item = Vec3> {
        let length = 1.0 / self.side as f32;
        self.places().map(move |[u, v]| (Vec2::new(u as f32, v as f32) * length).extend(length))
    }

    /// How many patches one draw of a part takes.
    pub(crate) fn patches_per_draw(self, wireframe: bool) -> usize {
        patches_per_draw(self.level, wireframe)
    }
}

/// What the trims leave of a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cut {
    /// All of it.
    Kept,
    /// Some of it, or nobody knows.
    Trimmed,
    /// Nothing.
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

/// Parts must leave so much less of the domain to be trimmed as to be worth their vertices.
const WORTH_IT: f32 = 0.8;

/// A patch at one level in parts: columns and rows of those that the trims wholly keep and of those
/// that they may cut; those that they wholly cut are gone.
#[derive(Debug)]
pub(crate) struct FixedParts {
    pub(crate) parts: Parts,
    pub(crate) kept: Vec<[u32; 2]>,
    pub(crate) trimmed: Vec<[u32; 2]>,
}

impl FixedParts {
    /// Splits a patch at a level; into smaller parts only if that leaves less to be trimmed.
    pub(crate) fn new(grid: &TrimGrid, level: TessLevel) -> Self {
        let whole = Self::into(grid, Parts::of(level));
        match Parts::smaller(level) {
            Some(parts) if !whole.trimmed.is_empty() => {
                let smaller = Self::into(grid, parts);
                let worth_it = smaller.trimmed_share() < WORTH_IT * whole.trimmed_share();
                if worth_it { smaller } else { whole }
            }
            _ => whole,
        }
    }

    fn into(grid: &TrimGrid, parts: Parts) -> Self {
        let (mut kept, mut trimmed) = (Vec::new(), Vec::new());
        for place in parts.places() {
            match Cut::of(grid, [parts.side; 2], place) {
                Cut::Gone => {}
                Cut::Kept => kept.push(place),
                Cut::Trimmed => trimmed.push(place),
            }
        }
        Self { parts, kept, trimmed }
    }

    fn trimmed_share(&self) -> f32 {
        self.trimmed.len() as f32 / (self.parts.side * self.parts.side) as f32
    }
}

/// What the trims of a surface leave of the parts of its patches, which are all trimmed alike, for
/// every number of parts that was asked for.
#[derive(Debug)]
pub(crate) struct TrimParts {
    grid: Arc<TrimGrid>,
    /// By halvings along u and v, row by row.
    known: Vec<([u8; 2], Vec<Cut>)>,
    /// Up to how many halvings leave less to be trimmed.
    useful: u8,
}

impl TrimParts {
    /// More parts than 2³ a side save little more.
    const MAX_HALVINGS: u8 = 3;

    pub(crate) fn new(grid: &Arc<TrimGrid>) -> Self {
        let mut parts = Self { grid: Arc::clone(grid), known: Vec::new(), useful: 0 };
        let mut share = |halvings: u8| {
            let cuts = parts.cuts([halvings; 2]);
            cuts.iter().filter(|cut| cut.is_trimmed()).count() as f32 / cuts.len() as f32
        };
        let whole = share(0);
        let useful =
            (1..=Self::MAX_HALVINGS).rev().find(|halvings| share(*halvings) < WORTH_IT * whole);
        parts.useful = useful.unwrap_or(0);
        parts
    }

    /// How often a patch of such a diagonal on the screen, in pixels, is best halved along each side:
    /// smaller parts cost more vertices than they save fragments.
    pub(crate) fn halvings(&self, extent: f32) -> u8 {
        const MIN_PX: f32 = 48.0;
        let halvings = (extent / MIN_PX).max(1.0).log2().floor();
        self.useful.min(halvings as u8)
    }

    /// What is left of each part of a patch that is halved so often along u and v, row by row.
    pub(crate) fn cuts(&mut self, halvings: [u8; 2]) -> &[Cut] {
        let place = self.known.iter().position(|(known, _)| *known == halvings);
        let place = place.unwrap_or_else(|| {
            let side = halvings.map(|halvings| 1_u32 << halvings);
            let cuts = (0..side[0] * side[1])
                .map(|i| Cut::of(&self.grid, side, [i % side[0], i / side[0]]))
                .collect();
            self.known.push((halvings, cuts));
            self.known.len() - 1
        });
        &self.known[place].1
    }
}

fn patches_per_draw(level: u32, wireframe: bool) -> usize {
    let max = if wireframe { VERTICES_PER_DRAW_OF_LINES } else { VERTICES_PER_DRAW };
    (max / ((level + 1) * (level + 1))).max(1) as usize
}

/// How many vertices one draw of parts should make.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum DrawSize {
    /// As few as cost little: Mesa's software driver gathers them patch by patch in memory that it
    /// enlarges for each, and asks the system for more from 128 KiB on.
    Small,
    /// As many as 16 bits count on every driver, and more.
    Large,
}

/// How many of the parts that come first make one draw, by their vertices.
pub(crate) fn patches_of_next_draw(vertices: impl Iterator<Item = u32>, size: DrawSize) -> usize {
    let max = match size {
        DrawSize::Small => 800,
        DrawSize::Large => 32_000,
    };
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
                let parts = Parts::of(TessLevel::new(level).unwrap());
                let vertices = (parts.level + 1) * (parts.level + 1);
                let drawn = parts.patches_per_draw(wireframe) as u32 * vertices;
                assert!(drawn >= vertices && drawn <= VERTICES_PER_DRAW);
                assert_eq!(parts.side * parts.level, level as u32);
            }
        }
    }

    #[test]
    fn parts_tile_the_domain() {
        let whole: Vec<Vec3> = Parts::of(TessLevel::new(32).unwrap()).domains().collect();
        assert_eq!(whole, [Vec3::new(0.0, 0.0, 1.0)]);
        let parts: Vec<Vec3> = Parts::of(TessLevel::MAX).domains().collect();
        assert_eq!(parts.len(), 4);
        assert_eq!(parts[3], Vec3::splat(0.5));
        assert_eq!(Parts::of(TessLevel::new(63).unwrap()).side, 1);
        for level in 1..=64 {
            let level = TessLevel::new(level).unwrap();
            for parts in Parts::smaller(level).into_iter().chain([Parts::of(level)]) {
                assert_eq!(parts.side * parts.level, level.get());
                assert_eq!(parts.places().count() as u32, parts.side * parts.side);
            }
        }
        let side = |level| Parts::smaller(TessLevel::new(level).unwrap()).map(|parts| parts.side);
        let expected = [None, Some(7), Some(12), None, Some(8), Some(8)];
        assert_eq!([1, 7, 12, 31, 32, 64].map(side), expected);
    }

    #[test]
    fn a_split_leaves_out_what_is_cut_and_tells_what_is_kept() {
        let mut trims = Trims::default();
        let level = TessLevel::new(32).unwrap();
        let whole = FixedParts::new(&TrimGrid::new(&trims), level);
        assert_eq!((whole.parts.side, whole.kept.len(), whole.trimmed.len()), (1, 1, 0));
        // A square of 4 × 4 of the 8 × 8 parts, its border a little inside theirs.
        trims.add_svg_path("M.255 .255 H.745 V.745 H.255Z").unwrap();
        let split = FixedParts::new(&TrimGrid::new(&trims), level);
        assert_eq!(split.parts.side, 8);
        assert_eq!((split.kept.len(), split.trimmed.len()), (64 - 16, 16 - 4));
        trims.keep = Keep::Inside;
        let split = FixedParts::new(&TrimGrid::new(&trims), level);
        assert_eq!((split.kept.len(), split.trimmed.len()), (4, 16 - 4));
    }
}
