//! Draws the sub-patches of the exact method.

use glam::Vec2;

use super::capture::DrawnVertex;
use super::draw_list::{Batch, DrawList, isolines};
use super::draws::Draw;
use super::uniforms::{analysis_of, set_analysis, set_aovs, set_columns, set_depth, set_lights};
use super::{Frame, PreparedSurface, Renderer, in_lines};
use crate::error::Result;
use crate::gpu::samples_of_target;
use crate::programs::{
    CONTROL_POINTS_UNIT, DOMAINS_UNIT, Output, Painting, Pipeline, ProgramKey, SUB_PATCHES_UNIT,
    SURFACES_UNIT, location,
};
use crate::scene::{Isolines, Shading};

impl Renderer {
    /// Draws the sub-patches of an up-to-date list: with trim code those that trims may cut,
    /// without it those that are completely kept. The triangles are written to `captured`, if it is
    /// given.
    ///
    /// # Errors
    /// A shader that the driver rejects, or as [`Renderer::make_draws`].
    pub(crate) fn draw_patches(
        &mut self,
        surfaces: &[PreparedSurface],
        draw_list: &DrawList,
        frame: &Frame,
        output: Output,
        captured: Option<&mut Vec<DrawnVertex>>,
    ) -> Result<()> {
        let Some(sub_patches) = draw_list.sub_patches() else { return Ok(()) };
        let settings = &frame.settings;
        let samples = samples_of_target(self.gl());
        let in_lines = in_lines(settings, output);
        let isolines = isolines(settings).filter(|_| output == Output::Picture);
        let analysis = analysis_of(settings, output);
        let kind = analysis.map(|shown| shown.kind());
        // Red lines and AOVs need no picture. Normals and analyses need it only if it has holes.
        let is_painted = |batch: &Batch| {
            let texture = surfaces[batch.surface].texture();
            let has_holes = texture.is_some_and(|texture| texture.has_holes());
            let is_shown = analysis.is_none() && batch.shading != Shading::Normals || has_holes;
            output == Output::Picture && !in_lines && is_shown
        };
        let key = |batch: &Batch| ProgramKey {
            pipeline: Pipeline::Exact {
                degree: batch.degree,
                samples,
                patches: batch.patches,
                shared: batch.shared,
                painting: if is_painted(batch) { batch.painting } else { Painting::Color },
                normals: settings.normals,
                isolines: isolines.is_some(),
            },
            shading: if in_lines || analysis.is_some() { Shading::Unlit } else { batch.shading },
            analysis: kind,
            light: settings.light,
            trims: batch.trims,
            output,
            cut_out: output == Output::Picture
                && is_painted(batch)
                && surfaces[batch.surface].texture().is_some_and(|texture| texture.has_holes()),
            far_depth: frame.camera.depth_scale().is_some(),
        };
        // All programs are linked before anything is bound, because the driver may reject one.
        for batch in draw_list.drawn_batches() {
            self.program(key(batch))?;
        }
        let this = &*self;
        let bind = |draw: &Draw, is_new: bool| {
            let batch = &draw_list.batches()[draw.batch];
            let program = &this.programs[&key(batch)];
            if !is_new {
                program.set_i32(location::GROUP_SIZE, draw.count as i32);
                return;
            }
            let surface = &surfaces[batch.surface];
            program.bind();
            program.set_i32(location::GROUP_SIZE, draw.count as i32);
            set_depth(program, frame);
            match output {
                Output::Aovs => set_aovs(program, frame),
                _ if key(batch).shading == Shading::Phong => set_lights(program, frame),
                _ => {}
            }
            if let Some(analysis) = analysis.as_ref().filter(|_| output == Output::Picture) {
                let limit = draw_list.curvature_limit(Some(*analysis)).unwrap_or(1.0);
                set_analysis(program, frame, analysis, limit);
                program.set_vec4(location::VIEWPORT, frame.viewport.origin_and_half());
            }
            if kind.is_some() {
                let offset = surface.uploaded_drawn_points().local_offset();
                program.set_i32(location::LOCAL_POINTS, offset as i32);
            }
            if let Some(Isolines { count, width, color }) = isolines {
                let lines = Vec2::new(count.get() as f32, 0.5 * width.pixels() as f32);
                program.set_vec2(location::ISOLINES, lines);
                program.set_vec3(location::ISOLINE_COLOR, color.into());
                program.set_vec4(location::VIEWPORT, frame.viewport.origin_and_half());
            }
            if batch.trims.any() {
                draw_list.trims().bind();
            }
            if let Some(texture) = surface.texture().filter(|_| is_painted(batch)) {
                texture.bind(0);
            }
            surface.uploaded_drawn_points().texels().bind(CONTROL_POINTS_UNIT);
            if !batch.shared {
                let columns = draw_list.columns(batch.surface);
                set_columns(program, columns, 1.0);
                let ProgramKey { shading, pipeline, .. } = key(batch);
                let has_color =
                    matches!(pipeline, Pipeline::Exact { painting: Painting::Color, .. });
                if has_color && shading != Shading::Normals && output != Output::Aovs {
                    program.set_vec3(location::PAINT, columns[columns.len() - 1].truncate());
                }
            }
            for (buffer, unit) in
                [(draw_list.matrices(), SURFACES_UNIT), (draw_list.domains(), DOMAINS_UNIT)]
            {
                if let Some(buffer) = buffer {
                    buffer.bind(unit);
                }
            }
            this.set_state(frame, 1, settings.wireframe);
            sub_patches.bind(SUB_PATCHES_UNIT);
            this.sub_patches_array.bind_bare();
        };
        self.make_draws(draw_list.draws(), 1, bind, captured)
    }
}
