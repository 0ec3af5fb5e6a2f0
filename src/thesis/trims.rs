//! Trims in the form that the listings' shaders read: uniforms, and buffers for data that does not fit into the
//! uniforms.

use glam::{Vec2, Vec4};

use crate::error::Result;
use crate::gpu::{Buffer, Gl, Program};
use crate::programs::{TRIM_POINTS_BINDING, TRIM_SHAPES_BINDING, TrimFeatures, location};
use crate::thesis::newton::{Newton, NewtonTrims};
use crate::trim::Trims;

/// The loops and the buffers for the listings' shaders.
#[derive(Debug)]
pub(crate) struct ThesisTrims {
    loops: NewtonTrims,
    points: Option<Buffer>,
    shapes: Option<Buffer>,
}

impl ThesisTrims {
    pub(crate) fn new(gl: &Gl, trims: &Trims) -> Result<Self> {
        let loops = NewtonTrims::of(trims)?;
        let points: Vec<Vec2> = loops.points().map(|point| point.as_vec2()).collect();
        let points = uploaded(gl, "trim points", &points)?;
        let shapes = uploaded(gl, "trim shapes", &more_shapes(trims))?;
        Ok(Self { loops, points, shapes })
    }

    /// The kinds of trims that the surface has, even if they are switched off, so that switching them does not
    /// compile a new program.
    pub(crate) const fn features(&self, trims: &Trims) -> TrimFeatures {
        TrimFeatures {
            circles: !trims.circles.is_empty(),
            intervals: !trims.rects.is_empty(),
            ellipses: !trims.ellipses.is_empty(),
            more_shapes: trims.circles.len() > 1
                || trims.rects.len() > 1
                || trims.ellipses.len() > 1,
            quadratics: !self.loops.quadratic.is_empty(),
            nested_quadratics: !self.loops.nested_quadratic.is_empty(),
            cubics: !self.loops.cubic.is_empty(),
            nested_cubics: !self.loops.nested_cubic.is_empty(),
            ..TrimFeatures::NONE
        }
    }

    /// Sets the uniforms and buffers of the features.
    pub(crate) fn set(&self, trims: &Trims, program: &Program, newton: &Newton) {
        let switch = |on: bool, count: usize| if on { count as i32 } else { 0 };
        if let Some(circle) = trims.circles.first() {
            program.set_i32(location::CIRC_BOOL, switch(trims.circles_on, trims.circles.len()));
            program.set_vec2(location::TRIM_CENTER, circle.center.as_vec2());
            program.set_f32(location::TRIM_RADIUS, circle.radius as f32);
        }
        if let Some(interval) = trims.rects.first() {
            let count = switch(trims.rects_on, trims.rects.len());
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
        if let Some(points) = &self.points {
            points.bind_storage(TRIM_POINTS_BINDING);
            program.set_i32(location::NEWTON_ITERATIONS, newton.iterations() as i32);
            program.set_f32(location::NEWTON_EPSILON, newton.epsilon() as f32);
        }
        if let Some(shapes) = &self.shapes {
            shapes.bind_storage(TRIM_SHAPES_BINDING);
        }
    }
}

fn uploaded<T: bytemuck::Pod>(gl: &Gl, label: &str, values: &[T]) -> Result<Option<Buffer>> {
    if values.is_empty() {
        return Ok(None);
    }
    Buffer::for_storage(gl, label, values).map(Some)
}

/// The shapes that do not fit into the uniforms, of the kinds that are switched on: circles, then rectangles,
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
    if trims.rects_on {
        shapes.extend(trims.rects.iter().skip(1).map(|interval| {
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
