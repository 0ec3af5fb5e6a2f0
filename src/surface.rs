//! The ported class: one freeform surface with its control points and trims on the GPU.

use std::sync::Arc;

use glam::{DMat4, DVec2, DVec3, DVec4, Vec2, Vec4};

use crate::bezier::{check_coordinates, homogeneous};
use crate::gpu::{Buffer, Program, Texture};
use crate::renderer::programs::{TRIM_POINTS_BINDING, TRIM_SHAPES_BINDING, TrimFeatures, location};
use crate::renderer::{Frame, Renderer};
use crate::scene::default_control_points;
use crate::trim::holds;
use crate::{
    Circle, Degree, Ellipse, Error, Image, Interval, Newton, NewtonTrims, Paint, Result, Segment,
    Shading, Surface, TrimLoop, Trims,
};

/// A Bézier surface that can be drawn: the thesis' `CVK::FreeFormSurface`.
///
/// The calls are the thesis' under Rust's names. Where a call of the thesis takes a shader, ours
/// needs none: [`FreeFormSurface::render`] takes the renderer. Beyond the thesis a surface has any
/// number of trims of every kind, patches of 25 control points, and weights.
#[derive(Debug)]
pub struct FreeFormSurface {
    surface: Surface,
    loops: NewtonTrims,
    control_points: Buffer,
    texture: Arc<Texture>,
    trim_points: Option<Buffer>,
    trim_shapes: Option<Buffer>,
    trims_changed: bool,
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
    /// Loops that the thesis' method cannot cut, a picture that the driver cannot hold, no memory.
    pub fn from_surface(renderer: &Renderer, surface: Surface) -> Result<Self> {
        let texture = Arc::new(surface.paint.upload(renderer.gl())?);
        Self::with_texture(renderer, surface, texture)
    }

    /// The same with a texture that is there already, whatever the surface's paint says.
    ///
    /// # Errors
    /// Loops that the thesis' method cannot cut, no memory.
    pub fn with_texture(
        renderer: &Renderer,
        surface: Surface,
        texture: Arc<Texture>,
    ) -> Result<Self> {
        check_transform(&surface.transform)?;
        surface.trims.check()?;
        let loops = NewtonTrims::from_loops(&surface.trims.loops)?;
        let points: Vec<Vec4> =
            surface.control_points().iter().map(|point| homogeneous(*point).as_vec4()).collect();
        let control_points = Buffer::new(renderer.gl(), "control points", &points)?;
        Ok(Self {
            surface,
            loops,
            control_points,
            texture,
            trim_points: None,
            trim_shapes: None,
            trims_changed: true,
        })
    }

    /// Draws the surface into the bound framebuffer, and its control points if the frame asks for
    /// them.
    ///
    /// # Errors
    /// A shader that the driver does not take, or no memory for changed trims.
    pub fn render(&mut self, renderer: &mut Renderer, frame: &Frame) -> Result<()> {
        renderer.draw(self, frame)?;
        if frame.settings.control_points {
            renderer.draw_control_points(self, frame)?;
        }
        Ok(())
    }

    /// Places the surface in the world.
    ///
    /// # Errors
    /// A matrix that is not finite, has numbers beyond 1e15, or is not affine (last row 0 0 0 1).
    pub fn set_model_matrix(&mut self, matrix: DMat4) -> Result<()> {
        check_transform(&matrix)?;
        self.surface.transform = matrix;
        Ok(())
    }

    /// Moves one control point; it keeps its weight. Only its own bytes go to the GPU.
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
        self.control_points.write(index, &[homogeneous(point).as_vec4()]);
        Ok(())
    }

    /// Gives the surface a picture; several surfaces may share one.
    pub fn set_texture(&mut self, texture: Arc<Texture>) {
        self.texture = texture;
    }

    /// Chooses the lighting.
    pub const fn set_shading(&mut self, shading: Shading) {
        self.surface.shading = shading;
    }

    /// Switches the circles on.
    pub const fn enable_circular_trimming(&mut self) {
        self.surface.trims.circles_on = true;
        self.trims_changed = true;
    }

    /// Switches the circles off; they are kept.
    pub const fn disable_circular_trimming(&mut self) {
        self.surface.trims.circles_on = false;
        self.trims_changed = true;
    }

    /// Switches the intervals on.
    pub const fn enable_interval_trimming(&mut self) {
        self.surface.trims.intervals_on = true;
        self.trims_changed = true;
    }

    /// Switches the intervals off; they are kept.
    pub const fn disable_interval_trimming(&mut self) {
        self.surface.trims.intervals_on = false;
        self.trims_changed = true;
    }

    /// Switches the ellipses on.
    pub const fn enable_ellipse_trimming(&mut self) {
        self.surface.trims.ellipses_on = true;
        self.trims_changed = true;
    }

    /// Switches the ellipses off; they are kept.
    pub const fn disable_ellipse_trimming(&mut self) {
        self.surface.trims.ellipses_on = false;
        self.trims_changed = true;
    }

    /// Switches the Bézier loops on.
    pub const fn enable_bezier_curve_trimming(&mut self) {
        self.surface.trims.loops_on = true;
        self.trims_changed = true;
    }

    /// Switches the Bézier loops off; they are kept.
    pub const fn disable_bezier_curve_trimming(&mut self) {
        self.surface.trims.loops_on = false;
        self.trims_changed = true;
    }

    /// Makes this the one circle, as the thesis' call does; [`FreeFormSurface::add_circle`] adds.
    ///
    /// # Errors
    /// A radius that is negative or not finite, a centre that is not finite.
    pub fn circular_trimming(&mut self, radius: f64, center: DVec2) -> Result<()> {
        self.surface.trims.circles = vec![Circle::new(center, radius)?];
        self.trims_changed = true;
        Ok(())
    }

    /// Makes this the one interval.
    ///
    /// # Errors
    /// Bounds that are not finite or not in order.
    pub fn interval_trimming(&mut self, u: DVec2, v: DVec2) -> Result<()> {
        self.surface.trims.intervals = vec![Interval::new(u, v)?];
        self.trims_changed = true;
        Ok(())
    }

    /// Makes this the one ellipse, with its radii along u and v.
    ///
    /// # Errors
    /// A radius that is negative or not finite, a centre that is not finite.
    pub fn ellipse_trimming(&mut self, radius_u: f64, radius_v: f64, center: DVec2) -> Result<()> {
        let radii = DVec2::new(radius_u, radius_v);
        self.surface.trims.ellipses = vec![Ellipse::new(center, radii)?];
        self.trims_changed = true;
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
        self.replace_loops(vec![quadratic_loop([p0, p1, p2, p3])?])
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
        self.replace_loops(vec![cubic_loop(points)?])
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
        self.trims_changed = true;
        Ok(())
    }

    /// Adds an interval to those that are there.
    ///
    /// # Errors
    /// What [`Interval::new`] refuses; the surface stays as it was.
    pub fn add_interval(&mut self, interval: Interval) -> Result<()> {
        self.surface.trims.intervals.push(Interval::new(interval.u, interval.v)?);
        self.trims_changed = true;
        Ok(())
    }

    /// Adds an ellipse to those that are there.
    ///
    /// # Errors
    /// What [`Ellipse::new`] refuses; the surface stays as it was.
    pub fn add_ellipse(&mut self, ellipse: Ellipse) -> Result<()> {
        self.surface.trims.ellipses.push(Ellipse::new(ellipse.center, ellipse.radii)?);
        self.trims_changed = true;
        Ok(())
    }

    /// Adds a loop to those that are there; one inside another is an island.
    ///
    /// # Errors
    /// A loop that the thesis' method cannot cut; the surface stays as it was.
    pub fn add_trim_loop(&mut self, trim_loop: TrimLoop) -> Result<()> {
        let loops = &mut self.surface.trims.loops;
        loops.push(trim_loop);
        self.loops = NewtonTrims::from_loops(loops).inspect_err(|_| drop(loops.pop()))?;
        self.trims_changed = true;
        Ok(())
    }

    /// Removes every trim; the switches stay as they are.
    pub fn clear_trims(&mut self) {
        let trims = &mut self.surface.trims;
        trims.circles.clear();
        trims.intervals.clear();
        trims.ellipses.clear();
        trims.loops.clear();
        self.loops = NewtonTrims::default();
        self.trims_changed = true;
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

    fn replace_loops(&mut self, loops: Vec<TrimLoop>) -> Result<()> {
        self.loops = NewtonTrims::from_loops(&loops)?;
        self.surface.trims.loops = loops;
        self.trims_changed = true;
        Ok(())
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
        self.replace_loops(vec![outer, inner])
    }

    pub(crate) const fn texture(&self) -> &Arc<Texture> {
        &self.texture
    }

    pub(crate) const fn control_point_buffer(&self) -> &Buffer {
        &self.control_points
    }

    pub(crate) fn control_point_count(&self) -> usize {
        self.surface.control_points().len()
    }

    /// The kinds of trims that the surface has, switched on or not: a switch compiles nothing.
    pub(crate) fn trim_features(&self) -> TrimFeatures {
        let trims = &self.surface.trims;
        TrimFeatures {
            circles: !trims.circles.is_empty(),
            intervals: !trims.intervals.is_empty(),
            ellipses: !trims.ellipses.is_empty(),
            more_shapes: trims.circles.len() > 1
                || trims.intervals.len() > 1
                || trims.ellipses.len() > 1,
            quadratics: !self.loops.quadratic.is_empty(),
            nested_quadratics: !self.loops.nested_quadratic.is_empty(),
            cubics: !self.loops.cubic.is_empty(),
            nested_cubics: !self.loops.nested_cubic.is_empty(),
        }
    }

    /// Brings changed trims to the GPU.
    pub(crate) fn upload_trims(&mut self, gl: &Arc<glow::Context>) -> Result<()> {
        if !self.trims_changed {
            return Ok(());
        }
        let points: Vec<Vec2> = self.loops.points().map(|point| point.as_vec2()).collect();
        self.trim_points = uploaded(gl, "trim points", &points)?;
        self.trim_shapes = uploaded(gl, "trim shapes", &more_shapes(&self.surface.trims))?;
        self.trims_changed = false;
        Ok(())
    }

    /// Sets the uniforms and buffers of the trims that [`FreeFormSurface::trim_features`] tells.
    pub(crate) fn set_trims(&self, program: &Program, newton: &Newton) {
        let trims = &self.surface.trims;
        let switch = |on: bool, count: usize| if on { count as i32 } else { 0 };
        if let Some(circle) = trims.circles.first() {
            program.set_i32(location::CIRC_BOOL, switch(trims.circles_on, trims.circles.len()));
            program.set_vec2(location::TRIM_CENTER, circle.center.as_vec2());
            program.set_f32(location::TRIM_RADIUS, circle.radius as f32);
        }
        if let Some(interval) = trims.intervals.first() {
            let count = switch(trims.intervals_on, trims.intervals.len());
            program.set_i32(location::INTERVAL_BOOL, count);
            program.set_vec2(location::TRIM_VALUES_X, interval.u.as_vec2());
            program.set_vec2(location::TRIM_VALUES_Y, interval.v.as_vec2());
        }
        if let Some(ellipse) = trims.ellipses.first() {
            program
                .set_i32(location::ELLIPSE_BOOL, switch(trims.ellipses_on, trims.ellipses.len()));
            program.set_vec2(location::TRIM_ELLIPSE_CENTER, ellipse.center.as_vec2());
            program.set_f32(location::TRIM_RADIUS_1, ellipse.radii.x as f32);
            program.set_f32(location::TRIM_RADIUS_2, ellipse.radii.y as f32);
        }
        for (location, count) in [
            (location::BEZIER_BOOL, self.loops.quadratic.len()),
            (location::BEZIER_BOOL_2, self.loops.nested_quadratic.len()),
            (location::CUBIC_BEZIER_BOOL, self.loops.cubic.len()),
            (location::CUBIC_BEZIER_BOOL_2, self.loops.nested_cubic.len()),
        ] {
            if count > 0 {
                program.set_i32(location, switch(trims.loops_on, count));
            }
        }
        if let Some(points) = &self.trim_points {
            points.bind_storage(TRIM_POINTS_BINDING);
            program.set_i32(location::NEWTON_ITERATIONS, newton.iterations() as i32);
            program.set_f32(location::NEWTON_EPSILON, newton.epsilon() as f32);
        }
        if let Some(shapes) = &self.trim_shapes {
            shapes.bind_storage(TRIM_SHAPES_BINDING);
        }
    }
}

fn check_transform(matrix: &DMat4) -> Result<()> {
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
    pub(crate) fn upload(&self, gl: &Arc<glow::Context>) -> Result<Texture> {
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

fn uploaded<T: bytemuck::Pod>(
    gl: &Arc<glow::Context>,
    label: &str,
    values: &[T],
) -> Result<Option<Buffer>> {
    if values.is_empty() {
        return Ok(None);
    }
    Buffer::new(gl, label, values).map(Some)
}

/// What the uniforms have no room for, of the kinds that are switched on: circles, then intervals,
/// then ellipses, each from the second on.
fn more_shapes(trims: &Trims) -> Vec<Vec4> {
    let mut shapes = Vec::new();
    if trims.circles_on {
        shapes.extend(
            trims
                .circles
                .iter()
                .skip(1)
                .map(|circle| circle.center.as_vec2().extend(circle.radius as f32).extend(0.0)),
        );
    }
    if trims.intervals_on {
        shapes.extend(trims.intervals.iter().skip(1).map(|interval| {
            let (u, v) = (interval.u.as_vec2(), interval.v.as_vec2());
            Vec4::new(u.x, u.y, v.x, v.y)
        }));
    }
    if trims.ellipses_on {
        shapes.extend(trims.ellipses.iter().skip(1).map(|ellipse| {
            let (center, radii) = (ellipse.center.as_vec2(), ellipse.radii.as_vec2());
            Vec4::new(center.x, center.y, radii.x, radii.y)
        }));
    }
    shapes
}

fn quadratic_loop([p0, p1, p2, p3]: [DVec2; 4]) -> Result<TrimLoop> {
    TrimLoop::new(vec![Segment::Quadratic([p0, p1, p2]), Segment::Quadratic([p2, p3, p0])])
}

fn cubic_loop([p0, p1, p2, p3, p4, p5]: [DVec2; 6]) -> Result<TrimLoop> {
    TrimLoop::new(vec![Segment::Cubic([p0, p1, p2, p3]), Segment::Cubic([p3, p5, p4, p0])])
}
