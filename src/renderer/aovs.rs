//! Targets for AOVs: floating-point images that `common/aov.frag` writes to.

use super::Renderer;
use crate::aov::Aovs;
use crate::error::Result;
use crate::gpu::FloatTarget;

/// The number of images that `common/aov.frag` writes to, without curvature. The curvature is one more.
const PICTURES: u32 = 3;

impl FloatTarget {
    /// A target for `PreparedScene::aovs`, without curvature.
    ///
    /// # Errors
    /// As [`FloatTarget::new`].
    pub fn for_aovs(renderer: &Renderer, size: (u32, u32)) -> Result<Self> {
        Self::new(renderer.gl(), size, PICTURES)
    }

    /// A target for `PreparedScene::aovs` with curvature, which takes longer.
    ///
    /// # Errors
    /// As [`FloatTarget::new`].
    pub fn for_aovs_and_curvature(renderer: &Renderer, size: (u32, u32)) -> Result<Self> {
        Self::new(renderer.gl(), size, PICTURES + 1)
    }

    /// Whether it has room for curvature.
    pub(crate) fn has_curvature(&self) -> bool {
        self.pictures() > PICTURES
    }

    /// The AOVs that `common/aov.frag` has written to such a target. u and v are those in the patch.
    pub(crate) fn aovs(&self) -> Aovs {
        let (uv, position, both) = (self.read(0), self.read(1), self.read(2));
        // The alpha of the first image is 1 where something is drawn, and 0 elsewhere.
        let drawn = |i: usize| uv[i][3];
        let normal = both.iter().enumerate().map(|(i, [x, y, z, _])| [*x, *y, *z, drawn(i)]);
        let depth = both.iter().enumerate().map(|(i, [_, _, _, d])| [*d, *d, *d, drawn(i)]);
        let patch_uv = uv.iter().map(|[u, v, ..]| [*u, *v]).collect();
        let (normal, depth) = (normal.collect(), depth.collect());
        let face = vec![[0.0; 4]; uv.len()];
        let curvature = if self.has_curvature() { self.read(PICTURES) } else { face.clone() };
        Aovs { size: self.size(), normal, depth, uv, patch_uv, position, face, curvature }
    }
}
