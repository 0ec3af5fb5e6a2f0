//! The ported class: one freeform surface with its control points and trims on the GPU, with the methods of the
//! thesis.

use std::rc::Rc;

use glam::{DMat4, DVec2, DVec3, DVec4};

use crate::bezier::Degree;
use crate::error::{Error, Result};
use crate::gpu::Texture;
use crate::programs::Output;
use crate::renderer::{DrawList, Frame, PreparedSurface, Renderer};
use crate::scene::{Cull, RenderSettings, Shading, Surface, default_control_points};
use crate::tessellation::FrameStats;
use crate::thesis::newton::holds;
use crate::trim::{Circle, Ellipse, Keep, Rect, Segment, TrimLoop, Trims};

/// A Bézier surface that can be drawn: the thesis' `CVK::FreeFormSurface`.
///
/// The methods are those of the thesis, with names in Rust's style. Methods that take a shader in the thesis take
/// none here; [`FreeFormSurface::render`] takes the renderer instead. Unlike in the thesis, a surface can have any
/// number of trims of every kind, patches of 25 control points, and weights.
#[derive(Debug)]
pub struct FreeFormSurface {
    prepared: PreparedSurface,
    /// The number of segments of all loops.
    segments: usize,
    /// The draw list of the exact method, which is kept from frame to frame.
    draw_list: DrawList,
}

impl FreeFormSurface {
    /// The default surface: 16 control points, flat in y = 0 between −0.5 and 0.5.
    ///
    /// # Errors
    /// The driver has no memory for it.
    pub fn new(renderer: &Renderer) -> Result<Self> {
        let surface = Surface::new(Degree::CUBIC, default_control_points())?;
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

    /// A surface of `columns` × `rows` control points, row by row: a patch of degrees `columns` − 1 and `rows` − 1. The
    /// thesis' method draws only 4×4 and 5×5, the exact method all from 2×2 to 16×16.
    ///
    /// # Errors
    /// A number of columns or rows that is not from 2 to 16, another number of points, a point that is not finite, no
    /// memory.
    pub fn with_grid(
        renderer: &Renderer,
        columns: usize,
        rows: usize,
        points: &[DVec3],
    ) -> Result<Self> {
        let degree = Degree::new(columns.saturating_sub(1), rows.saturating_sub(1))?;
        let points = points.iter().map(|point| point.extend(1.0)).collect();
        Self::from_surface(renderer, Surface::of_patch(degree, points)?)
    }

    /// A surface of one or more patches, with its transform, paint and trims.
    ///
    /// # Errors
    /// Trims out of their range, a picture that the driver cannot hold, no memory.
    pub fn from_surface(renderer: &Renderer, surface: Surface) -> Result<Self> {
        let texture = Rc::new(surface.paint.upload(renderer.gl())?);
        Self::with_texture(renderer, surface, texture)
    }

    /// The same with an existing texture, which is used instead of the surface's paint.
    ///
    /// # Errors
    /// Trims out of their range, no memory.
    pub fn with_texture(
        renderer: &Renderer,
        surface: Surface,
        texture: Rc<Texture>,
    ) -> Result<Self> {
        let segments = surface.trims.segment_count();
        let prepared = PreparedSurface::new(renderer.gl(), surface, Some(texture))?;
        Ok(Self { prepared, segments, draw_list: DrawList::default() })
    }

    /// Draws the surface into the bound framebuffer, and its control points if the frame asks for them. Returns
    /// statistics of what was drawn.
    ///
    /// # Errors
    /// A shader that the driver does not accept, no memory for changed trims, or loops that the frame's method cannot
    /// cut.
    pub fn render(&mut self, renderer: &mut Renderer, frame: &Frame) -> Result<FrameStats> {
        let surfaces = std::slice::from_mut(&mut self.prepared);
        let stats =
            renderer.draw_surfaces(surfaces, &mut self.draw_list, frame, Output::Picture)?;
        // The squares of control points lie on top of everything.
        if frame.settings.control_points {
            renderer.draw_control_points(&mut self.prepared, frame)?;
        }
        Ok(stats)
    }

    /// Builds and uploads the trim data that drawing with these settings needs, unless it already exists. Drawing
    /// does this automatically; call this method to choose when it happens.
    ///
    /// # Errors
    /// No memory, or loops that the method cannot cut.
    pub fn prepare(&mut self, renderer: &Renderer, settings: &RenderSettings) -> Result<()> {
        self.prepared.upload_trims(renderer.gl(), settings)
    }

    /// Places the surface in the world: see [`PreparedSurface::set_model_matrix`].
    ///
    /// # Errors
    /// As there.
    pub fn set_model_matrix(&mut self, matrix: DMat4) -> Result<()> {
        self.prepared.set_model_matrix(matrix)
    }

    /// Moves one control point; it keeps its weight: see [`PreparedSurface::set_control_point`].
    ///
    /// # Errors
    /// As there.
    pub fn set_specific_control_point(&mut self, point: DVec3, index: usize) -> Result<()> {
        self.prepared.set_specific_control_point(point, index)
    }

    /// Moves one control point and gives it a weight: see [`PreparedSurface::set_control_point`].
    ///
    /// # Errors
    /// As there.
    pub fn set_control_point(&mut self, point: DVec4, index: usize) -> Result<()> {
        self.prepared.set_control_point(point, index)
    }

    /// Gives the surface a picture; several surfaces may share one.
    pub fn set_texture(&mut self, texture: Rc<Texture>) {
        self.prepared.set_texture(texture);
    }

    /// Chooses the lighting.
    pub fn set_shading(&mut self, shading: Shading) {
        self.prepared.set_shading(shading);
    }

    /// Chooses which patches need not be drawn.
    pub fn set_cull(&mut self, cull: Cull) {
        self.prepared.set_cull(cull);
    }

    /// Switches the circles on.
    pub fn enable_circular_trimming(&mut self) {
        self.prepared.trims_mut().circles_on = true;
    }

    /// Switches the circles off; they are kept.
    pub fn disable_circular_trimming(&mut self) {
        self.prepared.trims_mut().circles_on = false;
    }

    /// Switches the rectangles on.
    pub fn enable_interval_trimming(&mut self) {
        self.prepared.trims_mut().rects_on = true;
    }

    /// Switches the rectangles off; they are kept.
    pub fn disable_interval_trimming(&mut self) {
        self.prepared.trims_mut().rects_on = false;
    }

    /// Switches the ellipses on.
    pub fn enable_ellipse_trimming(&mut self) {
        self.prepared.trims_mut().ellipses_on = true;
    }

    /// Switches the ellipses off; they are kept.
    pub fn disable_ellipse_trimming(&mut self) {
        self.prepared.trims_mut().ellipses_on = false;
    }

    /// Switches the Bézier loops on.
    pub fn enable_bezier_curve_trimming(&mut self) {
        self.prepared.trims_mut().loops_on = true;
    }

    /// Switches the Bézier loops off; they are kept.
    pub fn disable_bezier_curve_trimming(&mut self) {
        self.prepared.trims_mut().loops_on = false;
    }

    /// Replaces all circles by this one, as the thesis' method does. To add a circle, use
    /// [`FreeFormSurface::add_circle`].
    ///
    /// # Errors
    /// A radius that is negative or not finite, a centre that is not finite.
    pub fn circular_trimming(&mut self, radius: f64, center: DVec2) -> Result<()> {
        let circles = vec![Circle::new(center, radius)?];
        self.prepared.trims_mut().circles = circles;
        Ok(())
    }

    /// Replaces all rectangles by this one.
    ///
    /// # Errors
    /// Bounds that are not finite or not in order.
    pub fn interval_trimming(&mut self, u: DVec2, v: DVec2) -> Result<()> {
        let rects = vec![Rect::new(u, v)?];
        self.prepared.trims_mut().rects = rects;
        Ok(())
    }

    /// Replaces all ellipses by this one, given by its radii along u and v.
    ///
    /// # Errors
    /// A radius that is negative or not finite, a centre that is not finite.
    pub fn ellipse_trimming(&mut self, radius_u: f64, radius_v: f64, center: DVec2) -> Result<()> {
        let radii = DVec2::new(radius_u, radius_v);
        let ellipses = vec![Ellipse::new(center, radii)?];
        self.prepared.trims_mut().ellipses = ellipses;
        Ok(())
    }

    /// Replaces all loops and paths by one loop: the quadratics p0 p1 p2 above and p0 p3 p2 below (listing 17). The
    /// points run clockwise from the left, and p0 and p2 lie on one row, as the thesis' method needs.
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

    /// Replaces all loops and paths by two loops: the outer one p0…p3, and inside it an island p4…p7.
    ///
    /// # Errors
    /// A point that is not finite, an inner loop that is not inside the outer one.
    pub fn set_nested_bezier_curve_trimming(&mut self, points: [DVec2; 8]) -> Result<()> {
        let [a, b, c, d, e, f, g, h] = points;
        self.replace_nested(quadratic_loop([a, b, c, d])?, quadratic_loop([e, f, g, h])?)
    }

    /// Replaces all loops and paths by one loop: the cubics p0 p1 p2 p3 above and p0 p4 p5 p3 below. Both run from
    /// left to right, as in listing 9: p4 is the lower inner point nearer to p0.
    ///
    /// # Errors
    /// A point that is not finite.
    pub fn set_cubic_bezier_curve_trimming(&mut self, points: [DVec2; 6]) -> Result<()> {
        self.replace_loops(vec![cubic_loop(points)?]);
        Ok(())
    }

    /// Replaces all loops and paths by two loops: the outer one p0…p5, and inside it an island p6…p11.
    ///
    /// # Errors
    /// A point that is not finite, an inner loop that is not inside the outer one.
    pub fn set_nested_cubic_bezier_curve_trimming(&mut self, points: [DVec2; 12]) -> Result<()> {
        let [a, b, c, d, e, f, g, h, i, j, k, l] = points;
        self.replace_nested(cubic_loop([a, b, c, d, e, f])?, cubic_loop([g, h, i, j, k, l])?)
    }

    /// Adds a circle to the existing ones.
    ///
    /// # Errors
    /// As [`Circle::new`]; the surface stays as it was.
    pub fn add_circle(&mut self, circle: Circle) -> Result<()> {
        let added = Circle::new(circle.center, circle.radius)?;
        self.prepared.trims_mut().circles.push(added);
        Ok(())
    }

    /// Adds a rectangle to the existing ones.
    ///
    /// # Errors
    /// As [`Rect::new`]; the surface stays as it was.
    pub fn add_rect(&mut self, rect: Rect) -> Result<()> {
        let added = Rect::new(rect.u, rect.v)?;
        self.prepared.trims_mut().rects.push(added);
        Ok(())
    }

    /// Adds an ellipse to the existing ones.
    ///
    /// # Errors
    /// As [`Ellipse::new`]; the surface stays as it was.
    pub fn add_ellipse(&mut self, ellipse: Ellipse) -> Result<()> {
        let added = Ellipse::new(ellipse.center, ellipse.radii)?;
        self.prepared.trims_mut().ellipses.push(added);
        Ok(())
    }

    /// Adds a loop to the existing ones; a loop inside another is an island. The exact method accepts every loop;
    /// [`Method::Thesis`](crate::scene::Method::Thesis) draws only loops that `inspect::NewtonTrims` accepts.
    ///
    /// # Errors
    /// More than 1,000,000 segments in all loops together; the surface stays as it was.
    pub fn add_trim_loop(&mut self, trim_loop: TrimLoop) -> Result<()> {
        let count = trim_loop.segments().len();
        self.prepared.trims_mut().add_loop_to(trim_loop, self.segments)?;
        self.segments += count;
        Ok(())
    }

    /// Chooses which side of the loops is kept. The thesis' method supports only [`Keep::Outside`].
    pub fn set_keep(&mut self, keep: Keep) {
        self.prepared.trims_mut().keep = keep;
    }

    /// Removes every trim; the switches stay as they are.
    pub fn clear_trims(&mut self) {
        let trims = self.prepared.trims_mut();
        trims.circles.clear();
        trims.rects.clear();
        trims.ellipses.clear();
        trims.loops.clear();
        trims.paths.clear();
        self.segments = 0;
    }

    /// Replaces all trims and their switches.
    ///
    /// # Errors
    /// A shape that its constructor refuses, too many segments; the surface stays as it was.
    pub fn set_trims(&mut self, trims: Trims) -> Result<()> {
        let segments = trims.segment_count();
        self.prepared.set_trims(trims)?;
        self.segments = segments;
        Ok(())
    }

    /// The current state of the surface, except for its paint, which is the one that the surface was created with.
    #[must_use]
    pub const fn surface(&self) -> &Surface {
        self.prepared.surface()
    }

    /// The trims as they are now.
    #[must_use]
    pub const fn trims(&self) -> &Trims {
        &self.prepared.surface().trims
    }

    /// The degree of the patches.
    #[must_use]
    pub const fn degree(&self) -> Degree {
        self.prepared.surface().degree()
    }

    /// The control points of all patches.
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        self.prepared.surface().control_points()
    }

    /// The lighting.
    #[must_use]
    pub const fn shading(&self) -> Shading {
        self.prepared.surface().shading
    }

    /// Model space to world space.
    #[must_use]
    pub const fn model_matrix(&self) -> &DMat4 {
        &self.prepared.surface().transform
    }

    fn replace_loops(&mut self, loops: Vec<TrimLoop>) {
        let trims = self.prepared.trims_mut();
        trims.loops = loops;
        trims.paths.clear();
        self.segments = trims.segment_count();
    }

    fn replace_nested(&mut self, outer: TrimLoop, inner: TrimLoop) -> Result<()> {
        if !holds(&outer, &inner) {
            let [min, max] = inner.control_box();
            return Err(Error::invalid(
                "inner loop",
                format!("within {min} … {max}"),
                "a loop inside the outer one",
            ));
        }
        self.replace_loops(vec![outer, inner]);
        Ok(())
    }
}

fn quadratic_loop([p0, p1, p2, p3]: [DVec2; 4]) -> Result<TrimLoop> {
    TrimLoop::new(vec![Segment::Quadratic([p0, p1, p2]), Segment::Quadratic([p2, p3, p0])])
}

fn cubic_loop([p0, p1, p2, p3, p4, p5]: [DVec2; 6]) -> Result<TrimLoop> {
    TrimLoop::new(vec![Segment::Cubic([p0, p1, p2, p3]), Segment::Cubic([p3, p5, p4, p0])])
}
