//! The trims of a surface in the driver's memory, in one form for each method.

use std::sync::Arc;

use glam::Vec2;

use crate::error::Result;
use crate::gpu::{Gl, TexelBuffer};
use crate::programs::{TRIM_WORDS_UNIT, TrimFeatures};
use crate::scene::{Method, RenderSettings, TessLevel, Tessellation};
use crate::tessellation::{FixedSplit, TrimSplits};
use crate::thesis::trims::ThesisTrims;
use crate::trim::{TrimGrid, Trims};

/// The trims in the forms that the shaders of the two methods read. A form is made when its method
/// first draws the surface, and is discarded when the trims change.
#[derive(Debug, Default)]
pub(crate) struct UploadedTrims {
    pub(crate) thesis: Option<ThesisTrims>,
    pub(crate) exact: Option<ExactTrims>,
}

impl UploadedTrims {
    /// Makes what the method of the settings needs, if it is not made yet.
    pub(super) fn prepare(
        &mut self,
        gl: &Gl,
        trims: &Trims,
        settings: &RenderSettings,
    ) -> Result<()> {
        match settings.method {
            Method::Thesis if self.thesis.is_none() => {
                self.thesis = Some(ThesisTrims::new(gl, trims)?);
            }
            Method::Exact => {
                if self.exact.is_none() {
                    self.exact = Some(ExactTrims::new(gl, trims)?);
                }
                if let (Some(exact), Tessellation::Level(level)) =
                    (&mut self.exact, settings.tessellation)
                {
                    exact.fix(level);
                }
            }
            Method::Thesis => {}
        }
        Ok(())
    }
}

/// The exact method's grid, and the results of trimming sub-patches with it.
#[derive(Debug)]
pub(crate) struct ExactTrims {
    grid: Arc<TrimGrid>,
    features: TrimFeatures,
    /// The grid in the form that the shaders read; `None` if they need no trim code.
    words: Option<TexelBuffer>,
    /// For frames within a tolerance.
    sub_patches: TrimSplits,
    /// For frames at a fixed level: those of the level that was requested last.
    fixed: Option<(TessLevel, FixedSplit)>,
}

impl ExactTrims {
    fn new(gl: &Gl, trims: &Trims) -> Result<Self> {
        let grid = Arc::new(TrimGrid::new(trims));
        let features = TrimFeatures {
            loop_columns: grid.loop_columns(),
            finer_loops: grid.has_finer_cells(),
            long_lists: grid.has_long_lists(),
            fill_rules: grid.has_rules(),
            shape_grid: grid.has_shapes(),
            ..TrimFeatures::NONE
        };
        let words = features.any().then(|| TexelBuffer::of_words(gl, "trim grid", grid.words()));
        let sub_patches = TrimSplits::new(&grid);
        Ok(Self { grid, features, words: words.transpose()?, sub_patches, fixed: None })
    }

    /// Makes the sub-patches for a fixed level, if they are not made yet.
    fn fix(&mut self, level: TessLevel) {
        if self.fixed.as_ref().is_none_or(|(known, _)| *known != level) {
            self.fixed = Some((level, FixedSplit::new(&self.grid, level)));
        }
    }

    /// The parts of the trim code that the shaders need.
    pub(crate) const fn features(&self) -> TrimFeatures {
        self.features
    }

    /// The sub-patches for a tolerance, if the trims cut anything; and those of the fixed level
    /// that was requested last, if there was one.
    pub(crate) fn sub_patches(&mut self) -> (Option<&mut TrimSplits>, Option<&FixedSplit>) {
        // Without any curves and shapes the answer is the same everywhere: `Keep::Inside` cuts it
        // all.
        let cuts = self.features.any() || self.grid.cut(Vec2::splat(0.5));
        (
            cuts.then_some(&mut self.sub_patches),
            self.fixed.as_ref().map(|(_, sub_patches)| sub_patches),
        )
    }

    /// Binds the grid for the shaders' trim code.
    pub(crate) fn bind(&self) {
        if let Some(words) = &self.words {
            words.bind(TRIM_WORDS_UNIT);
        }
    }
}
