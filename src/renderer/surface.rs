//! A surface uploaded to the driver.

use std::rc::Rc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DMat4, DVec3, DVec4, Vec4};

use super::points::{ControlPoints, LocalFrame};
use super::trims::{ExactTrims, UploadedTrims};
use crate::bezier::Degree;
use crate::error::Result;
use crate::gpu::{Buffer, Gl, Texture};
use crate::scene::{Cull, Image, Method, Paint, RenderSettings, Shading, Surface, check_transform};
use crate::tessellation::{NormalCone, Raised, SquareNets};
use crate::trim::Trims;

/// A surface uploaded to the driver. It can be changed between frames.
///
/// Changes are uploaded automatically: control points immediately, trims at the next draw.
#[derive(Debug)]
pub struct PreparedSurface {
    surface: Surface,
    control_points: ControlPoints,
    /// What the exact method draws instead of the surface's own patches, if a neighbour has a higher degree.
    raised: Option<RaisedPatches>,
    /// One cone for each patch.
    cones: Vec<NormalCone>,
    nets: SquareNets,
    /// Used instead of the surface's paint.
    texture: Option<Rc<Texture>>,
    /// The control points of a NURBS surface, once they were drawn.
    net: Option<Buffer>,
    uploaded_trims: UploadedTrims,
    revision: Revision,
    /// Whether its points or trims are no longer those that it was made with.
    is_reshaped: bool,
}

/// What planning needs of the patches of a surface.
#[derive(Debug, Clone)]
pub(crate) struct PatchShapes {
    /// One cone for each patch.
    cones: Vec<NormalCone>,
    nets: SquareNets,
}

impl PatchShapes {
    /// From the control points of all patches.
    pub(crate) fn new(degree: Degree, points: &[DVec4]) -> Self {
        let patches = points.chunks_exact(degree.points());
        let cones = patches.map(|points| NormalCone::new(degree, points)).collect();
        Self { cones, nets: SquareNets::new(degree, points) }
    }
}

/// Patches of a higher degree, and their control points in the driver's memory.
#[derive(Debug)]
pub(crate) struct RaisedPatches {
    pub(crate) patches: Raised,
    pub(crate) control_points: ControlPoints,
}

/// Identifies the state of a surface. No two states have equal revisions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Revision {
    /// Revision of the patches' borders and of their placement in the world.
    pub(super) borders: u64,
    /// Revision of all other state.
    pub(super) rest: u64,
}

/// Returns a number that was never returned before.
pub(super) fn new_number() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

impl PreparedSurface {
    /// Uploads a surface. If a texture is given, it is used instead of the surface's paint; a picture must be given.
    pub(crate) fn new(gl: &Gl, surface: Surface, texture: Option<Rc<Texture>>) -> Result<Self> {
        let points = surface.patch_points();
        let centering = LocalFrame::of(points.iter());
        let mut uploaded = ControlPoints::upload(gl, &[(points, centering)])?;
        let shapes = PatchShapes::new(surface.degree(), points);
        Self::with_points(surface, texture, uploaded.remove(0), shapes, None)
    }

    /// The same, with control points that are already uploaded. `shapes` are those of the patches that are drawn.
    pub(crate) fn with_points(
        surface: Surface,
        texture: Option<Rc<Texture>>,
        control_points: ControlPoints,
        shapes: PatchShapes,
        raised: Option<RaisedPatches>,
    ) -> Result<Self> {
        check_transform(&surface.transform)?;
        surface.trims.check()?;
        let PatchShapes { cones, nets } = shapes;
        Ok(Self {
            cones,
            nets,
            surface,
            control_points,
            raised,
            texture,
            net: None,
            uploaded_trims: UploadedTrims::default(),
            revision: Revision { borders: new_number(), rest: new_number() },
            is_reshaped: false,
        })
    }

    /// The surface in its current state. Its paint, however, is the one that it was created with, or the last colour
    /// that was set.
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

    /// Moves one control point without changing its weight.
    ///
    /// # Errors
    /// An index out of range, or a point that is not finite; the surface stays unchanged.
    pub fn set_specific_control_point(&mut self, point: DVec3, index: usize) -> Result<()> {
        let weight = self.surface.control_points().get(index).map_or(1.0, |point| point.w);
        self.set_control_point(point.extend(weight), index)
    }

    /// Moves one control point and sets its weight. Only this point is uploaded, or for a NURBS surface, the patches
    /// that change. If points move far out of the control points' bounding box, or if the box becomes much smaller, all
    /// points of the surface are centred again and uploaded. Edges shared with other surfaces then differ from theirs
    /// by rounding.
    ///
    /// # Errors
    /// An index out of range, a point that is not finite, or a weight that is not above 0; the surface stays
    /// unchanged.
    pub fn set_control_point(&mut self, point: DVec4, index: usize) -> Result<()> {
        let is_whole = self.surface.nurbs().is_none() && self.raised.is_none();
        let before = (!is_whole).then(|| self.surface.shared_patch_points());
        self.surface.set_control_point(point, index)?;
        let degree = self.surface.degree();
        let points = self.surface.patch_points();
        let (changed, on_border): (Vec<usize>, bool) = match &before {
            None => {
                self.control_points.write(index, &[point]);
                let of_patch = index % degree.points();
                (vec![index / degree.points()], degree.is_on_border(of_patch))
            }
            Some(before) => {
                let patches = points.chunks_exact(degree.points()).enumerate();
                let pairs = patches.zip(before.chunks_exact(degree.points()));
                let changed = pairs.filter(|((_, now), before)| now != before);
                let changed: Vec<usize> = changed.map(|((patch, _), _)| patch).collect();
                let on_border = changed.iter().any(|patch| self.surface.is_outermost(*patch));
                (changed, on_border)
            }
        };
        for patch in &changed {
            let of_patch = |degree: Degree| patch * degree.points()..(patch + 1) * degree.points();
            let own = &points[of_patch(degree)];
            let mut drawn = (degree, own);
            if let Some(before) = &before {
                self.control_points.write(patch * degree.points(), own);
                if let Some(RaisedPatches { patches, control_points }) = &mut self.raised {
                    patches.update(*patch, degree, &before[of_patch(degree)], own);
                    drawn = (patches.degree, &patches.points[of_patch(patches.degree)]);
                    control_points.write(patch * patches.degree.points(), drawn.1);
                }
            }
            self.cones[*patch] = NormalCone::new(drawn.0, drawn.1);
            self.nets.update(*patch, drawn.1);
        }
        if self.control_points.are_off_center(points) {
            self.control_points.recenter(points);
            if let Some(RaisedPatches { patches, control_points }) = &mut self.raised {
                control_points.recenter_like(&self.control_points, &patches.points);
            }
            self.revision.borders = new_number();
        } else if on_border {
            self.revision.borders = new_number();
        }
        self.net = None;
        self.is_reshaped = true;
        self.revision.rest = new_number();
        Ok(())
    }

    /// Sets the surface's texture; several surfaces may share one.
    pub fn set_texture(&mut self, texture: Rc<Texture>) {
        self.texture = Some(texture);
        self.revision.rest = new_number();
    }

    /// Sets a colour instead of the texture or of another colour.
    pub fn set_color(&mut self, rgb: [f32; 3]) {
        self.surface.paint = Paint::Color(rgb);
        self.texture = None;
        self.revision.rest = new_number();
    }

    /// Hides the surface or shows it.
    pub fn set_hidden(&mut self, hidden: bool) {
        self.surface.hidden = hidden;
        self.revision.rest = new_number();
    }

    /// Sets the shading model.
    pub fn set_shading(&mut self, shading: Shading) {
        self.surface.shading = shading;
        self.revision.rest = new_number();
    }

    /// Sets which patches may be culled.
    pub fn set_cull(&mut self, cull: Cull) {
        self.surface.cull = cull;
        self.revision.rest = new_number();
    }

    /// Replaces all trims and their switches.
    ///
    /// # Errors
    /// A shape that its constructor rejects, or too many segments; the surface stays unchanged.
    pub fn set_trims(&mut self, trims: Trims) -> Result<()> {
        trims.check()?;
        *self.trims_mut() = trims;
        Ok(())
    }

    /// The trims, for in-place changes. The new trims must be valid.
    pub(crate) fn trims_mut(&mut self) -> &mut Trims {
        self.uploaded_trims = UploadedTrims::default();
        self.is_reshaped = true;
        self.revision.rest = new_number();
        &mut self.surface.trims
    }

    /// Uploads the trim data that a method needs, if it is not up to date.
    ///
    /// # Errors
    /// Degrees or trims that the method does not draw; no memory.
    pub(crate) fn upload_trims(&mut self, gl: &Gl, settings: &RenderSettings) -> Result<()> {
        if settings.method == Method::Thesis {
            self.surface.check_for_thesis()?;
        }
        let patches = self.surface.patch_grid();
        self.uploaded_trims.prepare(gl, &self.surface.trims, patches, settings)
    }

    /// Sets the grids of the trims for the exact method.
    pub(super) fn set_exact_trims(&mut self, exact: ExactTrims) {
        self.uploaded_trims.exact = Some(exact);
    }

    pub(crate) const fn degree(&self) -> Degree {
        self.surface.degree()
    }

    pub(crate) const fn shading(&self) -> Shading {
        self.surface.shading
    }

    /// The texture that is used instead of the surface's paint.
    pub(crate) const fn texture(&self) -> Option<&Rc<Texture>> {
        self.texture.as_ref()
    }

    /// The colour of the surface, if it has no texture.
    pub(crate) fn color(&self) -> [f32; 3] {
        match self.surface.paint {
            Paint::Color(rgb) => rgb,
            Paint::Texture(_) => [1.0; 3],
        }
    }

    /// The degree of the patches that the exact method draws.
    pub(crate) fn drawn_degree(&self) -> Degree {
        self.raised.as_ref().map_or(self.degree(), |raised| raised.patches.degree)
    }

    /// The control points of the patches that the exact method draws.
    pub(crate) fn drawn_points(&self) -> &[DVec4] {
        self.raised.as_ref().map_or(self.surface.patch_points(), |raised| &raised.patches.points)
    }

    /// The same in the driver's memory.
    pub(crate) fn uploaded_drawn_points(&self) -> &ControlPoints {
        self.raised.as_ref().map_or(&self.control_points, |raised| &raised.control_points)
    }

    /// Writes the drawn control points relative to their patches into the driver's memory, unless they are up to date.
    pub(super) fn write_local_points(&mut self) {
        let degree = self.drawn_degree();
        match &mut self.raised {
            None => self.control_points.write_local(degree, self.surface.patch_points()),
            Some(RaisedPatches { patches, control_points }) => {
                control_points.write_local(degree, &patches.points);
            }
        }
    }

    /// The control points of the surface's own patches in the driver's memory.
    pub(crate) const fn uploaded_points(&self) -> &ControlPoints {
        &self.control_points
    }

    /// The uploaded form of the trims; it holds only the data needed until now.
    pub(crate) const fn uploaded_trims(&self) -> &UploadedTrims {
        &self.uploaded_trims
    }

    /// A buffer with the control points as they were given, centred, and the index of the first of them.
    ///
    /// # Errors
    /// No memory.
    pub(super) fn net(&mut self, gl: &Gl) -> Result<(&Buffer, usize)> {
        let Some(nurbs) = self.surface.nurbs() else {
            return Ok((self.control_points.buffer(), self.control_points.first()));
        };
        if self.net.is_none() {
            let centering = self.control_points.centering();
            let points = nurbs.control_points().iter().map(|point| centering.apply(*point));
            let points: Vec<Vec4> = points.collect();
            self.net = Some(Buffer::new(gl, "control points of a NURBS surface", &points)?);
        }
        let net = self.net.as_ref().unwrap_or_else(|| self.control_points.buffer());
        Ok((net, 0))
    }

    pub(crate) fn cones(&self) -> &[NormalCone] {
        &self.cones
    }

    /// Whether its points or trims are no longer those that it was made with.
    pub(super) const fn is_reshaped(&self) -> bool {
        self.is_reshaped
    }

    /// Whether triangles follow it without error: one parallelogram.
    pub(super) fn is_flat(&self) -> bool {
        let [a, b, c, d] = self.drawn_points() else { return false };
        let is_even = a.w == b.w && a.w == c.w && a.w == d.w;
        let bent = (*a - *b - *c + *d).truncate().length();
        is_even && bent <= 1e-12 * self.points_scale()
    }

    /// Half of the longest side of the box of the control points, or up to twice as much.
    pub(super) const fn points_scale(&self) -> f64 {
        self.control_points.centering().scale()
    }

    pub(super) const fn revision(&self) -> Revision {
        self.revision
    }

    /// The matrix from the driver's control points to world space.
    pub(crate) fn points_to_world(&self) -> DMat4 {
        self.surface.transform * self.control_points.centering().to_model()
    }

    /// Borrows for the planning pass: the points along a side of the patches' square nets, these nets, the cones and
    /// the trims.
    pub(super) fn for_plan(&mut self) -> (usize, &[DVec4], &[NormalCone], &mut UploadedTrims) {
        let raised = self.raised.as_ref().map(|raised| &raised.patches.points[..]);
        let nets = self.nets.all(raised.unwrap_or_else(|| self.surface.patch_points()));
        (self.nets.side(), nets, &self.cones, &mut self.uploaded_trims)
    }
}

/// A colour in 8 bits for each channel.
pub(super) fn to_bytes(rgb: [f32; 3]) -> [u8; 3] {
    rgb.map(|channel| (channel * 255.0).round() as u8)
}

impl Paint {
    /// Uploads this paint as a texture: the image, or one texel of the colour.
    ///
    /// # Errors
    /// As [`Texture::new`].
    pub fn upload(&self, gl: &Gl) -> Result<Texture> {
        match self {
            Self::Texture(image) => Texture::new(gl, "surface picture", image),
            Self::Color(rgb) => {
                let [r, g, b] = to_bytes(*rgb);
                let texel = Image::from_pixel(1, 1, image::Rgba([r, g, b, 255]));
                Texture::new(gl, "surface color", &texel)
            }
        }
    }
}
