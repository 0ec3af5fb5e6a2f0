//! The trims of a surface, patch by patch, in the form that planning needs.

use std::sync::Arc;

use glam::Vec2;

use super::sub_patches::{FixedSplit, TrimSplits};
use crate::bezier::PatchGrid;
use crate::scene::TessLevel;
use crate::trim::{PatchTrims, TrimGrid, Trims, trims_by_patch};

/// What the trims of a surface do to a patch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PatchCut {
    /// They cut nothing of it.
    Kept,
    /// They cut all of it.
    Gone,
    /// The grid with this index decides.
    Grid(u32),
}

/// The trims of a surface's patches, and what they do to the patches' sub-patches.
#[derive(Debug, Clone)]
pub(crate) struct SurfaceTrims {
    grids: Vec<TrimSplits>,
    /// For each patch. If there is only one, it holds for all patches.
    patches: Vec<PatchCut>,
    /// The splits at the fixed level that was requested last: of a patch without trims, then of each grid.
    fixed: Option<(TessLevel, Vec<FixedSplit>)>,
}

impl SurfaceTrims {
    /// For Bézier patches, which all have the same trims, or for the patches of a NURBS surface.
    pub(crate) fn new(trims: &Trims, patches: Option<&PatchGrid>) -> Self {
        Self::with_grids(trims, patches, TrimGrid::new)
    }

    /// The same with grids that `grid_of` makes.
    pub(crate) fn with_grids(
        trims: &Trims,
        patches: Option<&PatchGrid>,
        grid_of: impl Fn(&Trims) -> TrimGrid,
    ) -> Self {
        let mut all = Self { grids: Vec::new(), patches: Vec::new(), fixed: None };
        let Some(grid) = patches else {
            let cut = all.add(grid_of(trims));
            all.patches.push(cut);
            return all;
        };
        for patch in trims_by_patch(trims, &grid.columns, &grid.rows) {
            let cut = match patch {
                PatchTrims::Kept => PatchCut::Kept,
                PatchTrims::Gone => PatchCut::Gone,
                PatchTrims::Cut(own) => all.add(grid_of(&own)),
            };
            all.patches.push(cut);
        }
        all
    }

    /// Adds a grid, unless its answer is the same everywhere.
    fn add(&mut self, grid: TrimGrid) -> PatchCut {
        if grid.decides() {
            self.grids.push(TrimSplits::new(&Arc::new(grid)));
            PatchCut::Grid(self.grids.len() as u32 - 1)
        } else if grid.cut(Vec2::splat(0.5)) {
            PatchCut::Gone
        } else {
            PatchCut::Kept
        }
    }

    /// The grids that decide, in the order of their indices.
    pub(crate) fn grids(&self) -> impl ExactSizeIterator<Item = &TrimGrid> + Clone {
        self.grids.iter().map(TrimSplits::grid)
    }

    /// What the trims do to a patch.
    pub(crate) fn of(&self, patch: usize) -> PatchCut {
        if self.patches.len() == 1 { self.patches[0] } else { self.patches[patch] }
    }

    /// Whether everything of a patch in the rectangle from `min` up to, but not including, `max` is cut or kept
    /// ([`TrimGrid::cut_throughout`]).
    pub(crate) fn cut_throughout(&self, patch: usize, min: Vec2, max: Vec2) -> Option<bool> {
        match self.of(patch) {
            PatchCut::Kept => Some(false),
            PatchCut::Gone => Some(true),
            PatchCut::Grid(grid) => self.grids[grid as usize].grid().cut_throughout(min, max),
        }
    }

    /// The sub-patches of the patches that a grid decides about.
    pub(crate) fn splits(&mut self, grid: u32) -> &mut TrimSplits {
        &mut self.grids[grid as usize]
    }

    /// Makes the splits at a fixed level, if they are not made yet.
    pub(crate) fn fix(&mut self, level: TessLevel) {
        if self.fixed.as_ref().is_none_or(|(known, _)| *known != level) {
            let of_grids = self.grids.iter().map(|splits| FixedSplit::new(splits.grid(), level));
            let all = std::iter::once(FixedSplit::untrimmed(level)).chain(of_grids).collect();
            self.fixed = Some((level, all));
        }
    }

    /// The split of a patch at the level that was fixed last; `None` if all of the patch is cut.
    ///
    /// # Panics
    /// If no level was fixed.
    pub(crate) fn fixed(&self, patch: usize) -> Option<&FixedSplit> {
        let (_, splits) = self.fixed.as_ref().expect("a level was fixed");
        match self.of(patch) {
            PatchCut::Kept => Some(&splits[0]),
            PatchCut::Gone => None,
            PatchCut::Grid(grid) => Some(&splits[1 + grid as usize]),
        }
    }
}
