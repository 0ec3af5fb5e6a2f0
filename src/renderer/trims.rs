//! The trims of a surface in the driver's memory, in the form of each method.

use std::sync::Arc;

use glam::{Vec2, Vec4};

use super::programs::{
    TRIM_POINTS_BINDING, TRIM_SHAPES_BINDING, TRIM_WORDS_UNIT, TrimFeatures, location,
};
use crate::error::Result;
use crate::gpu::{Buffer, Gl, Program, TexelBuffer};
use crate::scene::{Method, RenderSettings, TessLevel, Tessellation};
use crate::tessellation::{FixedParts, TrimParts};
use crate::trim::{Newton, NewtonTrims, TrimGrid, Trims};

/// What the shaders of each method read. It is made when the method first draws the surface, and is
/// thrown away when its trims change.
#[derive(Debug, Default)]
pub(crate) struct UploadedTrims {
    pub(crate) thesis: Option<ThesisTrims>,
    pub(crate) exact: Option<ExactTrims>,
}

impl UploadedTrims {
    /// Makes what a method needs, unless it is there.
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

/// The names and the buffers of the listings.
#[derive(Debug)]
pub(crate) struct ThesisTrims {
    loops: NewtonTrims,
    points: Option<Buffer>,
    shapes: Option<Buffer>,
}

impl ThesisTrims {
    fn new(gl: &Gl, trims: &Trims) -> Result<Self> {
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

/// The exact method's grid, and the parts of a patch that it leaves to be drawn.
#[derive(Debug)]
pub(crate) struct ExactTrims {
    grid: Arc<TrimGrid>,
    features: TrimFeatures,
    words: Option<TexelBuffer>,
    /// Within a tolerance.
    parts: TrimParts,
    /// At the level that was asked for last.
    fixed: Option<(TessLevel, FixedParts)>,
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
        let parts = TrimParts::new(&grid);
        Ok(Self { grid, features, words: words.transpose()?, parts, fixed: None })
    }

    /// Makes the parts for a level; the grid stays.
    fn fix(&mut self, level: TessLevel) {
        if self.fixed.as_ref().is_none_or(|(known, _)| *known != level) {
            self.fixed = Some((level, FixedParts::new(&self.grid, level)));
        }
    }

    /// The kinds of trims that cut something.
    pub(crate) const fn features(&self) -> TrimFeatures {
        self.features
    }

    /// The parts within a tolerance, if there are trims, and those at a level, if there is one.
    pub(crate) fn parts(&mut self) -> (Option<&mut TrimParts>, Option<&FixedParts>) {
        let cuts = self.features.any() || self.grid.cut(Vec2::splat(0.5));
        (cuts.then_some(&mut self.parts), self.fixed.as_ref().map(|(_, parts)| parts))
    }

    /// Binds what the features read.
    pub(crate) fn bind(&self) {
        if let Some(words) = &self.words {
            words.bind(TRIM_WORDS_UNIT);
        }
    }
}

fn uploaded<T: bytemuck::Pod>(gl: &Gl, label: &str, values: &[T]) -> Result<Option<Buffer>> {
    if values.is_empty() {
        return Ok(None);
    }
    Buffer::for_storage(gl, label, values).map(Some)
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
