//! How patches are cut into triangles: sizes that the drivers ask for.

use std::ops::Range;

use glam::{Vec2, Vec3, Vec4, Vec4Swizzles as _};

use crate::{TessLevel, TrimGrid};

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

    /// The parts' least and greatest (u, v).
    pub(crate) fn boxes(self) -> impl Iterator<Item = Vec4> {
        let border = move |i: u32| i as f32 / self.side as f32;
        (0..self.side * self.side).map(move |part| {
            let (u, v) = (part % self.side, part / self.side);
            Vec4::new(border(u), border(v), border(u + 1), border(v + 1))
        })
    }

    /// Where each part begins in the domain, and the length of its side: (u, v, length).
    pub(crate) fn domains(self) -> impl Iterator<Item = Vec3> {
        let length = 1.0 / self.side as f32;
        (0..self.side * self.side).map(move |part| {
            let corner = Vec2::new((part % self.side) as f32, (part / self.side) as f32);
            (corner * length).extend(length)
        })
    }

    /// How many patches one draw of a part takes.
    pub(crate) fn patches_per_draw(self, wireframe: bool) -> usize {
        patches_per_draw(self.level, wireframe)
    }
}

/// A patch in parts: those that the trims wholly keep and those that they may cut; those that they
/// wholly cut are gone.
#[derive(Debug)]
pub(crate) struct Split {
    pub(crate) parts: Parts,
    /// Least and greatest (u, v).
    pub(crate) kept: Vec<Vec4>,
    /// Least and greatest (u, v).
    pub(crate) trimmed: Vec<Vec4>,
}

impl Split {
    /// Splits a patch at a level; into smaller parts only if that leaves less to be trimmed.
    pub(crate) fn new(grid: &TrimGrid, level: TessLevel) -> Self {
        // Smaller parts cost vertices: they must leave so much less of the domain to be trimmed.
        const WORTH_IT: f32 = 0.8;
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
        for part in parts.boxes() {
            match grid.cut_throughout(part.xy(), part.zw()) {
                Some(true) => {}
                Some(false) => kept.push(part),
                None => trimmed.push(part),
            }
        }
        Self { parts, kept, trimmed }
    }

    fn trimmed_share(&self) -> f32 {
        self.trimmed.len() as f32 / (self.parts.side * self.parts.side) as f32
    }
}

fn patches_per_draw(level: u32, wireframe: bool) -> usize {
    let most = if wireframe { VERTICES_PER_DRAW_OF_LINES } else { VERTICES_PER_DRAW };
    (most / ((level + 1) * (level + 1))).max(1) as usize
}

/// One draw: these patches, each in these parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Batch {
    pub(crate) patches: Range<usize>,
    pub(crate) instances: Range<usize>,
}

/// The draws of so many patches, each in the parts `instances`, at a level for each part.
pub(crate) fn batches(
    level: u32,
    wireframe: bool,
    patches: usize,
    instances: Range<usize>,
) -> impl Iterator<Item = Batch> {
    let most = patches_per_draw(level, wireframe);
    let patches_at_once = most.min(patches).max(1);
    let instances_at_once = (most / patches_at_once).max(1);
    (0..patches).step_by(patches_at_once).flat_map(move |first| {
        let end = patches.min(first + patches_at_once);
        let all = instances.clone();
        all.clone().step_by(instances_at_once).map(move |instance| Batch {
            patches: first..end,
            instances: instance..all.end.min(instance + instances_at_once),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Keep, Trims};

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
                let boxes: Vec<Vec4> = parts.boxes().collect();
                assert_eq!(boxes.len() as u32, parts.side * parts.side);
                assert_eq!((boxes[0].x, boxes[boxes.len() - 1].w), (0.0, 1.0));
                // Neighbours meet bit for bit.
                for (left, right) in boxes.iter().zip(&boxes[1..]) {
                    assert!(left.z == right.x || right.x == 0.0 && left.w == right.y);
                }
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
        let whole = Split::new(&TrimGrid::new(&trims), level);
        assert_eq!((whole.parts.side, whole.kept.len(), whole.trimmed.len()), (1, 1, 0));
        // A square of 4 × 4 of the 8 × 8 parts, its border a little inside theirs.
        trims.add_svg_path("M.255 .255 H.745 V.745 H.255Z").unwrap();
        let split = Split::new(&TrimGrid::new(&trims), level);
        assert_eq!(split.parts.side, 8);
        assert_eq!((split.kept.len(), split.trimmed.len()), (64 - 16, 16 - 4));
        trims.keep = Keep::Inside;
        let split = Split::new(&TrimGrid::new(&trims), level);
        assert_eq!((split.kept.len(), split.trimmed.len()), (4, 16 - 4));
    }
}
