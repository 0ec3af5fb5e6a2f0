//! The trims of a surface in the driver's memory, in the form of each method.

use std::sync::Arc;

use glam::{Vec2, Vec4};

use crate::gpu::{Buffer, Program, TexelBuffer};
use crate::renderer::programs::{
    TRIM_POINTS_BINDING, TRIM_SHAPES_BINDING, TRIM_WORDS_UNIT, TrimFeatures, location,
};
use crate::tessellation::Split;
use crate::{Method, Newton, NewtonTrims, Result, TessLevel, TrimGrid, Trims};

/// What the shaders of each method read. It is made when the method first draws the surface, and is
/// thrown away when its trims change.
#[derive(Debug, Default)]
pub(crate) struct UploadedTrims {
    pub(crate) thesis: Option<ThesisTrims>,
    pub(crate) exact: Option<ExactTrims>,
}

impl UploadedTrims {
    /// Makes what a method needs at a level, unless it is there.
    pub(super) fn prepare(
        &mut self,
        gl: &Arc<glow::Context>,
        trims: &Trims,
        method: Method,
        level: TessLevel,
    ) -> Result<()> {
        match (method, &mut self.exact) {
            (Method::Thesis, _) if self.thesis.is_none() => {
                self.thesis = Some(ThesisTrims::new(gl, trims)?);
            }
            (Method::Exact, None) => self.exact = Some(ExactTrims::new(gl, trims, level)?),
            (Method::Exact, Some(exact)) if exact.level != level => exact.split(gl, level)?,
            _ => {}
        }
        Ok(())
    }
}

/// The names and the buffers of the listings.
#[derive(Debug)]
pub(crate) struct ThesisTrims {
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

    /// The kinds of trims that the surface has, switched on or not: a switch compiles nothing.
    pub(crate) const fn features(&self, trims: &Trims) -> TrimFeatures {
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

    /// Sets the uniforms and buffers of the features.
    pub(crate) fn set(&self, trims: &Trims, program: &Program, newton: &Newton) {
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

/// The exact method's grids, and the parts of a patch that they leave to be drawn.
#[derive(Debug)]
pub(crate) struct ExactTrims {
    grid: TrimGrid,
    features: TrimFeatures,
    words: Option<TexelBuffer>,
    level: TessLevel,
    parts: PartList,
}

/// Parts of the domain in the driver's memory: first those that are wholly kept, then those that the
/// trims may cut.
#[derive(Debug)]
pub(crate) struct PartList {
    /// Tessellation level of each.
    pub(crate) level: u32,
    /// How many are wholly kept.
    pub(crate) kept: usize,
    /// How many must be trimmed.
    pub(crate) trimmed: usize,
    /// Their least and greatest (u, v). None if nothing is kept of the surface.
    pub(crate) boxes: Option<Buffer>,
}

impl ExactTrims {
    fn new(gl: &Arc<glow::Context>, trims: &Trims, level: TessLevel) -> Result<Self> {
        let grid = TrimGrid::new(trims);
        let features = TrimFeatures {
            loop_columns: grid.loop_columns(),
            finer_loops: grid.has_finer_cells(),
            long_lists: grid.has_long_lists(),
            shape_grid: grid.has_shapes(),
            ..TrimFeatures::NONE
        };
        let words = features.any().then(|| TexelBuffer::new(gl, "trim grid", grid.words()));
        let parts = PartList::new(gl, &grid, level)?;
        Ok(Self { grid, features, words: words.transpose()?, level, parts })
    }

    /// Makes the parts for another level; the grid stays.
    fn split(&mut self, gl: &Arc<glow::Context>, level: TessLevel) -> Result<()> {
        self.parts = PartList::new(gl, &self.grid, level)?;
        self.level = level;
        Ok(())
    }

    /// The kinds of trims that cut something.
    pub(crate) const fn features(&self) -> TrimFeatures {
        self.features
    }

    pub(crate) const fn parts(&self) -> &PartList {
        &self.parts
    }

    /// Binds what the features read.
    pub(crate) fn bind(&self) {
        if let Some(words) = &self.words {
            words.bind(TRIM_WORDS_UNIT);
        }
    }
}

impl PartList {
    fn new(gl: &Arc<glow::Context>, grid: &TrimGrid, level: TessLevel) -> Result<Self> {
        let Split { parts, kept, trimmed } = Split::new(grid, level);
        let boxes = uploaded(gl, "parts", &[kept.as_slice(), &trimmed].concat())?;
        Ok(Self { level: parts.level, kept: kept.len(), trimmed: trimmed.len(), boxes })
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
