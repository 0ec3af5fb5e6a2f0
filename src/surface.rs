//! The ported class: one freeform surface with its control points and trims on the GPU.

mod points;
mod trims;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DMat4, DVec2, DVec3, DVec4};

use crate::bezier::check_coordinates;
use crate::gpu::Texture;
use crate::renderer::{Drawing, Frame, Renderer};
use crate::scene::default_control_points;
use crate::tessellation::Shape;
use crate::trim::holds;
use crate::{
    Circle, Cull, Degree, Ellipse, Error, Image, Interval, Keep, Paint, RenderSettings, Result,
    Segment, Shading, Surface, TrimLoop, Trims,
};
pub(crate) use points::{Centering, ControlPoints};
pub(crate) use trims::UploadedTrims;

/// A Bézier surface that can be drawn: the thesis' `CVK::FreeFormSurface`.
///
/// The calls are the thesis' under Rust's names. Where a call of the thesis takes a shader, ours
/// needs none: [`FreeFormSurface::render`] takes the renderer. Beyond the thesis a surface has any
/// number of trims of every kind, patches of 25 control points, and weights.
#[derive(Debug)]
pub struct FreeFormSurface {
    surface: Surface,
    /// Segments of all loops.
    segments: usize,
    control_points: ControlPoints,
    /// Of each patch.
    shapes: Vec<Shape>,
    texture: Arc<Texture>,
    uploaded_trims: UploadedTrims,
    revision: Revision,
    /// What is kept from frame to frame if the surface is drawn by itself.
    drawing: Option<Box<Drawing>>,
}

/// Tells states of surfaces apart: no two have the same numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Revision {
    /// Of the control points and their place in the world.
    pub(crate) points: u64,
    /// Of everything else.
    pub(crate) look: u64,
}

/// A number that was not there before.
fn new_number() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

impl FreeFormSurface {
    /// The default surface: 16 control points, flat in y = 0 between −0.5 and 0.5.
    ///
    /// # Errors
    /// The driver has no memory for it.
    pub fn new(renderer: &Renderer) -> Result<Self> {
        let surface = Surface::new(Degree::Cubic, default_control_points())?;
        Self::from_surface(renderer, surface)
    }

    /// A surface of 16 or 25 control points, row by row.
    ///
    /// # Errors
    /// Another number of points, a point that is not finite, no memory.
    pub fn with_control_points(renderer: &Renderer, points: &[DVec3]) -> Result<Self> {
        let degree = Degree::from_point_count(points.len())?;
        let points = points.iter().map(|point| point.extend(1.0)).collect();
        Self::from_surface(renderer, Surface::new(degree, points)?)
    }

    /// One or more patches with everything that belongs to them.
    ///
    /// # Errors
    /// Trims out of their range, a picture that the driver cannot hold, no memory.
    pub fn from_surface(renderer: &Renderer, surface: Surface) -> Result<Self> {
        let texture = Arc::new(surface.paint.upload(renderer.gl())?);
        Self::with_texture(renderer, surface, texture)
    }

    /// The same with a texture that is there already, whatever the surface's paint says.
    ///
    /// # Errors
    /// Trims out of their range, no memory.
    pub fn with_texture(
        renderer: &Renderer,
        surface: Surface,
        texture: Arc<Texture>,
    ) -> Result<Self> {
        let points = surface.control_points();
        let centering = Centering::of(points.iter());
        let mut uploaded = ControlPoints::upload(renderer.gl(), &[(points, centering)])?;
        Self::with_points(surface, texture, uploaded.remove(0))
    }

    /// The same with control points that are there already.
    pub(crate) fn with_points(
        surface: Surface,
        texture: Arc<Texture>,
        control_points: ControlPoints,
    ) -> Result<Self> {
        check_transform(&surface.transform)?;
        surface.trims.check()?;
        let degree = surface.degree();
        let patches = surface.control_points().chunks_exact(degree.points());
        Ok(Self {
            segments: surface.trims.segment_count(),
            shapes: patches.map(|points| Shape::new(degree, points)).collect(),
            surface,
            control_points,
            texture,
            uploaded_trims: UploadedTrims::default(),
            revision: Revision { points: new_number(), look: new_number() },
            drawing: None,
        })
    }

    /// Draws the surface into the bound framebuffer, and its control points if the frame asks for
    /// them.
    ///
    /// # Errors
    /// A shader that the driver does not take, no memory for changed trims, or loops that the frame's
    /// method cannot cut.
    pub fn render(&mut self, renderer: &mut Renderer, frame: &Frame) -> Result<()> {
        renderer.draw(self, frame)?;
        // Squares lie on top of everything.
        if frame.settings.control_points {
            renderer.draw_control_points(self, frame)?;
        }
        Ok(())
    }

    /// Builds and uploads what drawing with these settings needs for the trims, unless that is there
    /// already. Drawing does this by itself; call it to choose when.
    ///
    /// # Errors
    /// No memory, or loops that the method cannot cut.
    pub fn prepare(&mut self, renderer: &Renderer, settings: &RenderSettings) -> Result<()> {
        self.upload_trims(renderer.gl(), settings)
    }

    /// Places the surface in the world.
    ///
    /// # Errors
    /// A matrix that is not finite, has numbers beyond 1e15, or is not affine (last row 0 0 0 1).
    pub fn set_model_matrix(&mut self, matrix: DMat4) -> Result<()> {
        check_transform(&matrix)?;
        self.surface.transform = matrix;
        self.revision.points = new_number();
        Ok(())
    }

    /// Moves one control point; it keeps its weight. Only its own bytes go to the GPU; all of
    /// the surface's, centred anew, if it goes far out of their box or the box becomes much smaller. Edges
    /// that it had in common with other surfaces then differ from theirs by rounding.
    ///
    /// # Errors
    /// An index out of range, a point that is not finite; the surface stays as it was.
    pub fn set_specific_control_point(&mut self, point: DVec3, index: usize) -> Result<()> {
        let weight = self.surface.control_points().get(index).map_or(1.0, |point| point.w);
        self.set_control_point(point.extend(weight), index)
    }

    /// Moves one control point and gives it a weight.
    ///
    /// # Errors
    /// As [`FreeFormSurface::set_specific_control_point`], and a weight that is not above 0.
    pub fn set_control_point(&mut self, point: DVec4, index: usize) -> Result<()> {
        self.surface.set_control_point(point, index)?;
        self.control_points.write(index, point);
        let points = self.surface.control_points();
        if self.control_points.are_off_center(points) {
            self.control_points.recenter(points);
        }
        let degree = self.surface.degree();
        let patch = index / degree.points();
        let points = &self.surface.control_points()[patch * degree.points()..][..degree.points()];
        self.shapes[patch] = Shape::new(degree, points);
        self.revision.points = new_number();
        Ok(())
    }

    /// Gives the surface a picture; several surfaces may share one.
    pub fn set_texture(&mut self, texture: Arc<Texture>) {
        self.texture = texture;
        self.revision.look = new_number();
    }

    /// Chooses the lighting.
    pub fn set_shading(&mut self, shading: Shading) {
        self.surface.shading = shading;
        self.revision.look = new_number();
    }

    /// Chooses what need not be drawn.
    pub fn set_cull(&mut self, cull: Cull) {
        self.surface.cull = cull;
        self.revision.look = new_number();
    }

    /// Switches the circles on.
    pub fn enable_circular_trimming(&mut self) {
        self.surface.trims.circles_on = true;
        self.forget_trims();
    }

    /// Switches the circles off; they are kept.
    pub fn disable_circular_trimming(&mut self) {
        self.surface.trims.circles_on = false;
        self.forget_trims();
    }

    /// Switches the intervals on.
    pub fn enable_interval_trimming(&mut self) {
        self.surface.trims.intervals_on = true;
        self.forget_trims();
    }

    /// Switches the intervals off; they are kept.
    pub fn disable_interval_trimming(&mut self) {
        self.surface.trims.intervals_on = false;
        self.forget_trims();
    }

    /// Switches the ellipses on.
    pub fn enable_ellipse_trimming(&mut self) {
        self.surface.trims.ellipses_on = true;
        self.forget_trims();
    }

    /// Switches the ellipses off; they are kept.
    pub fn disable_ellipse_trimming(&mut self) {
        self.surface.trims.ellipses_on = false;
        self.forget_trims();
    }

    /// Switches the Bézier loops on.
    pub fn enable_bezier_curve_trimming(&mut self) {
        self.surface.trims.loops_on = true;
        self.forget_trims();
    }

    /// Switches the Bézier loops off; they are kept.
    pub fn disable_bezier_curve_trimming(&mut self) {
        self.surface.trims.loops_on = false;
        self.forget_trims();
    }

    /// Makes this the one circle, as the thesis' call does; [`FreeFormSurface::add_circle`] adds.
    ///
    /// # Errors
    /// A radius that is negative or not finite, a centre that is not finite.
    pub fn circular_trimming(&mut self, radius: f64, center: DVec2) -> Result<()> {
        self.surface.trims.circles = vec![Circle::new(center, radius)?];
        self.forget_trims();
        Ok(())
    }

    /// Makes this the one interval.
    ///
    /// # Errors
    /// Bounds that are not finite or not in order.
    pub fn interval_trimming(&mut self, u: DVec2, v: DVec2) -> Result<()> {
        self.surface.trims.intervals = vec![Interval::new(u, v)?];
        self.forget_trims();
        Ok(())
    }

    /// Makes this the one ellipse, with its radii along u and v.
    ///
    /// # Errors
    /// A radius that is negative or not finite, a centre that is not finite.
    pub fn ellipse_trimming(&mut self, radius_u: f64, radius_v: f64, center: DVec2) -> Result<()> {
        let radii = DVec2::new(radius_u, radius_v);
        self.surface.trims.ellipses = vec![Ellipse::new(center, radii)?];
        self.forget_trims();
        Ok(())
    }

    /// Makes this the one loop: the quadratics p0 p1 p2 above and p0 p3 p2 below (listing 17).
    /// Given clockwise from the left, with p0 and p2 on one row, as the thesis' method needs.
    ///
    /// # Errors
    /// A point that is not finite.
    pub fn set_bezier_curve_trimming(
        &mut self,
        p0: DVec2,
        p1: DVec2,
        p2: DVec2,
        p3: DVec2,
    ) -> Result<()> {
        self.replace_loops(vec![quadratic_loop([p0, p1, p2, p3])?]);
        Ok(())
    }

    /// Makes these the only loops: the outer one p0…p3, and inside it an island p4…p7.
    ///
    /// # Errors
    /// A point that is not finite, an inner loop that is not inside the outer one.
    pub fn set_nested_bezier_curve_trimming(&mut self, points: [DVec2; 8]) -> Result<()> {
        let [a, b, c, d, e, f, g, h] = points;
        self.replace_nested(quadratic_loop([a, b, c, d])?, quadratic_loop([e, f, g, h])?)
    }

    /// Makes this the one loop: the cubics p0 p1 p2 p3 above and p0 p4 p5 p3 below. Both run from
    /// the left, as listing 9 reads them: p4 is the lower inner point nearer p0.
    ///
    /// # Errors
    /// A point that is not finite.
    pub fn set_cubic_bezier_curve_trimming(&mut self, points: [DVec2; 6]) -> Result<()> {
        self.replace_loops(vec![cubic_loop(points)?]);
        Ok(())
    }

    /// Makes these the only loops: the outer one p0…p5, and inside it an island p6…p11.
    ///
    /// # Errors
    /// A point that is not finite, an inner loop that is not inside the outer one.
    pub fn set_nested_cubic_bezier_curve_trimming(&mut self, points: [DVec2; 12]) -> Result<()> {
        let [a, b, c, d, e, f, g, h, i, j, k, l] = points;
        self.replace_nested(cubic_loop([a, b, c, d, e, f])?, cubic_loop([g, h, i, j, k, l])?)
    }

    /// Adds a circle to those that are there.
    ///
    /// # Errors
    /// What [`Circle::new`] refuses; the surface stays as it was.
    pub fn add_circle(&mut self, circle: Circle) -> Result<()> {
        self.surface.trims.circles.push(Circle::new(circle.center, circle.radius)?);
        self.forget_trims();
        Ok(())
    }

    /// Adds an interval to those that are there.
    ///
    /// # Errors
    /// What [`Interval::new`] refuses; the surface stays as it was.
    pub fn add_interval(&mut self, interval: Interval) -> Result<()> {
        self.surface.trims.intervals.push(Interval::new(interval.u, interval.v)?);
        self.forget_trims();
        Ok(())
    }

    /// Adds an ellipse to those that are there.
    ///
    /// # Errors
    /// What [`Ellipse::new`] refuses; the surface stays as it was.
    pub fn add_ellipse(&mut self, ellipse: Ellipse) -> Result<()> {
        self.surface.trims.ellipses.push(Ellipse::new(ellipse.center, ellipse.radii)?);
        self.forget_trims();
        Ok(())
    }

    /// Adds a loop to those that are there; one inside another is an island. The exact method takes
    /// every loop; [`Method::Thesis`](crate::Method::Thesis) draws those that [`NewtonTrims`](crate::NewtonTrims) takes.
    ///
    /// # Errors
    /// More than 1,000,000 segments in all loops together; the surface stays as it was.
    pub fn add_trim_loop(&mut self, trim_loop: TrimLoop) -> Result<()> {
        let count = trim_loop.segments().len();
        self.surface.trims.add_loop_to(trim_loop, self.segments)?;
        self.segments += count;
        self.forget_trims();
        Ok(())
    }

    /// Chooses which side of the loops stays. The thesis' method knows [`Keep::Outside`] alone.
    pub fn set_keep(&mut self, keep: Keep) {
        self.surface.trims.keep = keep;
        self.forget_trims();
    }

    /// Removes every trim; the switches stay as they are.
    pub fn clear_trims(&mut self) {
        let trims = &mut self.surface.trims;
        trims.circles.clear();
        trims.intervals.clear();
        trims.ellipses.clear();
        trims.loops.clear();
        trims.paths.clear();
        self.segments = 0;
        self.forget_trims();
    }

    /// Replaces all trims and their switches.
    ///
    /// # Errors
    /// A shape that its constructor refuses, too many segments; the surface stays as it was.
    pub fn set_trims(&mut self, trims: Trims) -> Result<()> {
        trims.check()?;
        self.segments = trims.segment_count();
        self.surface.trims = trims;
        self.forget_trims();
        Ok(())
    }

    /// The trims as they are now.
    #[must_use]
    pub const fn trims(&self) -> &Trims {
        &self.surface.trims
    }

    /// The degree of the patches.
    #[must_use]
    pub const fn degree(&self) -> Degree {
        self.surface.degree()
    }

    /// The control points of all patches.
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        self.surface.control_points()
    }

    /// The lighting.
    #[must_use]
    pub const fn shading(&self) -> Shading {
        self.surface.shading
    }

    /// Model space to world space.
    #[must_use]
    pub const fn model_matrix(&self) -> &DMat4 {
        &self.surface.transform
    }

    fn replace_loops(&mut self, loops: Vec<TrimLoop>) {
        self.surface.trims.loops = loops;
        self.surface.trims.paths.clear();
        self.segments = self.surface.trims.segment_count();
        self.forget_trims();
    }

    fn replace_nested(&mut self, outer: TrimLoop, inner: TrimLoop) -> Result<()> {
        if !holds(&outer, &inner) {
            let [least, most] = inner.control_box();
            return Err(Error::invalid(
                "inner loop",
                format!("within {least} … {most}"),
                "a loop inside the outer one",
            ));
        }
        self.replace_loops(vec![outer, inner]);
        Ok(())
    }

    pub(crate) const fn texture(&self) -> &Arc<Texture> {
        &self.texture
    }

    pub(crate) const fn uploaded_points(&self) -> &ControlPoints {
        &self.control_points
    }

    pub(crate) fn shapes(&self) -> &[Shape] {
        &self.shapes
    }

    pub(crate) const fn cull(&self) -> Cull {
        self.surface.cull
    }

    pub(crate) const fn revision(&self) -> Revision {
        self.revision
    }

    /// From the driver's control points to world space.
    pub(crate) fn points_to_world(&self) -> DMat4 {
        self.surface.transform * self.control_points.centering().to_model()
    }

    /// What is kept from frame to frame if the surface is drawn by itself.
    pub(crate) const fn drawing_mut(&mut self) -> &mut Option<Box<Drawing>> {
        &mut self.drawing
    }

    /// Control points, shapes and trims at once, for the pass that uses them together.
    pub(crate) fn for_plan(&mut self) -> (&[DVec4], &[Shape], &mut UploadedTrims) {
        (self.surface.control_points(), &self.shapes, &mut self.uploaded_trims)
    }

    fn forget_trims(&mut self) {
        self.uploaded_trims = UploadedTrims::default();
        self.revision.look = new_number();
    }

    /// Brings what a method needs for the trims to the GPU, if it is not there yet.
    pub(crate) fn upload_trims(
        &mut self,
        gl: &Arc<glow::Context>,
        settings: &RenderSettings,
    ) -> Result<()> {
        self.uploaded_trims.prepare(gl, &self.surface.trims, settings)
    }

    /// What was uploaded since the trims changed last.
    pub(crate) const fn uploaded_trims(&self) -> &UploadedTrims {
        &self.uploaded_trims
    }
}

/// Checks a matrix that places something in the world.
pub(crate) fn check_transform(matrix: &DMat4) -> Result<()> {
    for column in [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis] {
        check_coordinates("model matrix", column.truncate())?;
    }
    if matrix.row(3) != DVec4::W {
        return Err(Error::invalid("last row of the model matrix", matrix.row(3), "0 0 0 1"));
    }
    Ok(())
}

impl Paint {
    /// The texture that shows this paint: the picture, or one texel of the colour.
    ///
    /// # Errors
    /// As [`Texture::new`].
    pub fn upload(&self, gl: &Arc<glow::Context>) -> Result<Texture> {
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

fn quadratic_loop([p0, p1, p2, p3]: [DVec2; 4]) -> Result<TrimLoop> {
    TrimLoop::new(vec![Segment::Quadratic([p0, p1, p2]), Segment::Quadratic([p2, p3, p0])])
}

fn cubic_loop([p0, p1, p2, p3, p4, p5]: [DVec2; 6]) -> Result<TrimLoop> {
    TrimLoop::new(vec![Segment::Cubic([p0, p1, p2, p3]), Segment::Cubic([p3, p5, p4, p0])])
}
