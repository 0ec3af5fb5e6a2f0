//! The trims of a patch, decided at its places.

use glam::DVec2;

use super::rows::TrimRows;
use crate::error::Result;
use crate::reference::TrimDecision;
use crate::scene::{Method, Surface};
use crate::tessellation::SurfaceTrims;
use crate::thesis::newton::Newton;
use crate::trim::{TrimGrid, Trims};

/// The trims of a patch in a form that is fast enough to evaluate at every pixel.
pub(super) struct Cut<'a> {
    surface: &'a Surface,
    pub(super) decision: Decision<'a>,
    /// The number of the patch in its surface.
    pub(super) patch: usize,
}

pub(super) enum Decision<'a> {
    Nothing,
    Thesis(TrimDecision<'a>),
    Exact(TrimRows<'a>, SurfaceTrims),
}

impl<'a> Cut<'a> {
    pub(super) fn new(surface: &'a Surface, newton: Newton, method: Method) -> Result<Self> {
        let trims = &surface.trims;
        let decision = if trims.is_empty() {
            Decision::Nothing
        } else if method == Method::Thesis {
            Decision::Thesis(TrimDecision::new(trims, newton, method)?)
        } else {
            let [low, high] = surface.domain();
            let rows = TrimRows::new(trims, [low.y, high.y]);
            // Fine enough to tell cracks from what is close to a trim.
            let grid_of = |trims: &Trims| TrimGrid::with_side(trims, 32);
            Decision::Exact(rows, SurfaceTrims::with_grids(trims, surface.patch_grid(), grid_of))
        };
        Ok(Self { surface, decision, patch: 0 })
    }

    /// Whether there may be something to cut.
    pub(super) const fn is_possible(&self) -> bool {
        !matches!(self.decision, Decision::Nothing)
    }

    /// Whether a place of the patch is cut; u and v run from 0 to 1 along the patch.
    pub(super) fn cuts(&self, uv: DVec2) -> bool {
        let [low, high] = self.surface.patch_domain(self.patch);
        let place = low + uv * (high - low);
        match &self.decision {
            Decision::Nothing => false,
            Decision::Thesis(decision) => decision.cut(place),
            Decision::Exact(rows, _) => self.surface.trims.shapes_cut(place) || rows.cut(place),
        }
    }
}
