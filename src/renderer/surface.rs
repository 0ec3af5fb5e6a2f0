//! A surface in the driver's memory.

use std::rc::Rc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DMat4, DVec3, DVec4};

use super::points::{ControlPoints, LocalFrame};
use super::trims::UploadedTrims;
use crate::bezier::Degree;
use crate::error::Result;
use crate::gpu::{Gl, Texture};
use crate::scene::{Cull, Image, Paint, RenderSettings, Shading, Surface, check_transform};
use crate::tessellation::NormalCone;
use crate::trim::Trims;

/// A surface in the driver's memory, to be changed between frames.
///
/// Changes are uploaded automatically: a control point at once, trims when they are next drawn.
#[derive(Debug)]
pub struct PreparedSurface {
    surface: Surface,
    control_points: ControlPoints,
    /// Of each patch.
    cones: Vec<NormalCone>,
    texture: Rc<Texture>,
    uploaded_trims: UploadedTrims,
    revision: Revision,
}

/// Identifies the state of a surface: no two states have the same numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Revision {
    /// Of the borders of the patches and their place in the world.
    pub(super) borders: u64,
    /// Of everything else.
    pub(super) rest: u64,
}

/// A number that was not there before.
fn new_number() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

impl PreparedSurface {
    /// Uploads a surface; the texture is used whatever the surface's paint says.
    pub(crate) fn new(gl: &Gl, surface: Surface, texture: Rc<Texture>) -> Result<Self> {
        let points = surface.control_points();
        let centering = LocalFrame::of(points.iter());
        let mut uploaded = ControlPoints::upload(gl, &[(points, centering)])?;
        Self::with_points(surface, texture, uploaded.remove(0))
    }

    /// The same with control points that are there already.
    pub(crate) fn with_points(
        surface: Surface,
        texture: Rc<Texture>,
        control_points: ControlPoints,
    ) -> Result<Self> {
        check_transform(&surface.transform)?;
        surface.trims.check()?;
        let degree = surface.degree();
        let patches = surface.control_points().chunks_exact(degree.points());
        Ok(Self {
            cones: patches.map(|points| NormalCone::new(degree, points)).collect(),
            surface,
            control_points,
            texture,
            uploaded_trims: UploadedTrims::default(),
            revision: Revision { borders: new_number(), rest: new_number() },
        })
    }

    /// The surface as it is now; of its paint only what it was made with.
    #[must_use]
    pub const fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Places the surface in the world.
    ///
    /// # Errors
    /// A matrix that is not finite, has entries beyond 1e15, or is not affine (last row 0 0 0 1).
    pub fn set_model_matrix(&mut self, matrix: DMat4) -> Result<()> {
        check_transform(&matrix)?;
        self.surface.transform = matrix;
        self.revision.borders = new_number();
        Ok(())
    }

    /// Moves one control point; it keeps its weight.
    ///
    /// # Errors
    /// An index out of range, a point that is not finite; the surface stays as it was.
    pub fn set_specific_control_point(&mut self, point: DVec3, index: usize) -> Result<()> {
        let weight = self.surface.control_points().get(index).map_or(1.0, |point| point.w);
        self.set_control_point(point.extend(weight), index)
    }

    /// Moves one control point and gives it a weight. Only its own bytes go to the GPU; all of
    /// the surface's, centred anew, if it goes far out of their box or the box becomes much smaller. Edges
    /// that it had in common with other surfaces then differ from theirs by rounding.
    ///
    /// # Errors
    /// An index out of range, a point that is not finite, a weight that is not above 0; the surface stays
    /// as it was.
    pub fn set_control_point(&mut self, point: DVec4, index: usize) -> Result<()> {
        self.surface.set_control_point(point, index)?;
        self.control_points.write(index, point);
        let points = self.surface.control_points();
        let degree = self.surface.degree();
        if self.control_points.are_off_center(points) {
            self.control_points.recenter(points);
            self.revision.borders = new_number();
        } else if degree.is_on_border(index % degree.points()) {
            self.revision.borders = new_number();
        }
        let patch = index / degree.points();
        let points = &self.surface.control_points()[patch * degree.points()..][..degree.points()];
        self.cones[patch] = NormalCone::new(degree, points);
        self.revision.rest = new_number();
        Ok(())
    }

    /// Gives the surface a picture; several surfaces may share one.
    pub fn set_texture(&mut self, texture: Rc<Texture>) {
        self.texture = texture;
        self.revision.rest = new_number();
    }

    /// Chooses the lighting.
    pub fn set_shading(&mut self, shading: Shading) {
        self.surface.shading = shading;
        self.revision.rest = new_number();
    }

    /// Chooses what need not be drawn.
    pub fn set_cull(&mut self, cull: Cull) {
        self.surface.cull = cull;
        self.revision.rest = new_number();
    }

    /// Replaces all trims and their switches.
    ///
    /// # Errors
    /// A shape that its constructor refuses, too many segments; the surface stays as it was.
    pub fn set_trims(&mut self, trims: Trims) -> Result<()> {
        trims.check()?;
        *self.trims_mut() = trims;
        Ok(())
    }

    /// The trims, to be changed into others that are valid.
    pub(crate) fn trims_mut(&mut self) -> &mut Trims {
        self.uploaded_trims = UploadedTrims::default();
        self.revision.rest = new_number();
        &mut self.surface.trims
    }

    /// Brings what a method needs for the trims to the GPU, if it is not there yet.
    pub(crate) fn upload_trims(&mut self, gl: &Gl, settings: &RenderSettings) -> Result<()> {
        self.uploaded_trims.prepare(gl, &self.surface.trims, settings)
    }

    pub(crate) const fn degree(&self) -> Degree {
        self.surface.degree()
    }

    pub(crate) const fn shading(&self) -> Shading {
        self.surface.shading
    }

    pub(crate) const fn texture(&self) -> &Rc<Texture> {
        &self.texture
    }

    pub(crate) const fn uploaded_points(&self) -> &ControlPoints {
        &self.control_points
    }

    /// The uploaded form of the trims, as far as it is needed.
    pub(crate) const fn uploaded_trims(&self) -> &UploadedTrims {
        &self.uploaded_trims
    }

    pub(crate) fn cones(&self) -> &[NormalCone] {
        &self.cones
    }

    pub(super) const fn revision(&self) -> Revision {
        self.revision
    }

    /// From the driver's control points to world space.
    pub(crate) fn points_to_world(&self) -> DMat4 {
        self.surface.transform * self.control_points.centering().to_model()
    }

    /// Control points, cones and trims at once, for the pass that uses them together.
    pub(super) fn for_plan(&mut self) -> (&[DVec4], &[NormalCone], &mut UploadedTrims) {
        (self.surface.control_points(), &self.cones, &mut self.uploaded_trims)
    }
}

impl Paint {
    /// The texture that shows this paint: the picture, or one texel of the colour.
    ///
    /// # Errors
    /// As [`Texture::new`].
    pub fn upload(&self, gl: &Gl) -> Result<Texture> {
        match self {
            Self::Texture(image) => Texture::new(gl, "surface picture", image),
            Self::Color(rgb) => {
                let [r, g, b] = rgb.map(|channel| (channel * 255.0).round() as u8);
                let texel = Image::from_pixel(1, 1, image::Rgba([r, g, b, 255]));
                Texture::new(gl, "surface color", &texel)
            }
        }
    }
}
