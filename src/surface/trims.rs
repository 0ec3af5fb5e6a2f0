//! The trims of a surface in the driver's memory, in the form of each method.

use std::sync::Arc;

use glam::{Vec2, Vec4};

use crate::gpu::{Buffer, Program};
use crate::renderer::programs::{
    TRIM_GRID_BINDING, TRIM_POINTS_BINDING, TRIM_SHAPES_BINDING, TrimFeatures, location,
};
use crate::trim::Lookup;
use crate::{Method, Newton, NewtonTrims, Result, TrimGrid, Trims};

/// What the shaders of one method read. It is made when the method first draws the surface, and
/// again when its trims have changed.
#[derive(Debug)]
pub(super) enum UploadedTrims {
    Thesis(ThesisTrims),
    Exact(ExactTrims),
}

impl UploadedTrims {
    pub(super) fn new(gl: &Arc<glow::Context>, trims: &Trims, method: Method) -> Result<Self> {
        Ok(match method {
            Method::Thesis => Self::Thesis(ThesisTrims::new(gl, trims)?),
            Method::Exact => Self::Exact(ExactTrims::new(gl, trims)?),
        })
    }

    pub(super) const fn method(&self) -> Method {
        match self {
            Self::Thesis(_) => Method::Thesis,
            Self::Exact(_) => Method::Exact,
        }
    }

    /// The kinds of trims that the surface has, switched on or not: a switch compiles nothing.
    pub(super) const fn features(&self, trims: &Trims) -> TrimFeatures {
        match self {
            Self::Thesis(thesis) => thesis.features(trims),
            Self::Exact(_) => ExactTrims::features(trims),
        }
    }

    /// Sets the uniforms and buffers of the features.
    pub(super) fn set(&self, trims: &Trims, program: &Program, newton: &Newton) {
        match self {
            Self::Thesis(thesis) => thesis.set(trims, program, newton),
            Self::Exact(exact) => exact.set(trims, program),
        }
    }
}

/// The names and the buffers of the listings.
#[derive(Debug)]
pub(super) struct ThesisTrims {
    loops: NewtonTrims,
    points: Option<Buffer>,
    shapes: Option<Buffer>,
}

impl ThesisTrims {
    fn new(gl: &Arc<glow::Context>, trims: &Trims) -> Result<Self> {
        let loops = NewtonTrims::of(trims)?;
        let points: Vec<Vec2> = loops.points().map(|point| point.as_vec2()).collect();
        let points = uploaded(gl, "trim points", &points)?;
        let shapes = uploaded(gl, "trim shapes", &more_shapes(trims))?;
        Ok(Self { loops, points, shapes })
    }

    const fn features(&self, trims: &Trims) -> TrimFeatures {
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
            ..TrimFeatures::NONE
        }
    }

    fn set(&self, trims: &Trims, program: &Program, newton: &Newton) {
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

/// The exact method's grids.
#[derive(Debug)]
pub(super) struct ExactTrims {
    loops: Lookup,
    shapes: Lookup,
    keeps_inside: bool,
    grid: Option<Buffer>,
}

impl ExactTrims {
    fn new(gl: &Arc<glow::Context>, trims: &Trims) -> Result<Self> {
        let grid = TrimGrid::new(trims);
        Ok(Self {
            loops: *grid.loops(),
            shapes: *grid.shapes(),
            keeps_inside: grid.keeps_inside(),
            grid: uploaded(gl, "trim grid", grid.words())?,
        })
    }

    const fn features(trims: &Trims) -> TrimFeatures {
        TrimFeatures {
            loop_grid: !trims.loops.is_empty(),
            shape_grid: !(trims.circles.is_empty()
                && trims.intervals.is_empty()
                && trims.ellipses.is_empty()),
            ..TrimFeatures::NONE
        }
    }

    fn set(&self, trims: &Trims, program: &Program) {
        let features = Self::features(trims);
        if features.loop_grid {
            let places = [location::LOOP_BOX, location::LOOP_SCALE, location::LOOP_CELLS];
            set_lookup(program, places, &self.loops);
            program.set_i32(location::KEEP_INSIDE, i32::from(self.keeps_inside));
        }
        if features.shape_grid {
            let places = [location::SHAPE_BOX, location::SHAPE_SCALE, location::SHAPE_CELLS];
            set_lookup(program, places, &self.shapes);
        }
        if let Some(grid) = &self.grid {
            grid.bind_storage(TRIM_GRID_BINDING);
        }
    }
}

fn set_lookup(program: &Program, [place, scale, cells]: [u32; 3], lookup: &Lookup) {
    let lattice = &lookup.lattice;
    let (least, most) = (lattice.least, lattice.most);
    program.set_vec4(place, Vec4::new(least.x, least.y, most.x, most.y));
    program.set_vec2(scale, lattice.scale);
    program.set_uvec3(cells, lattice.size.extend(lookup.cells));
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
