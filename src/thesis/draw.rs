//! Draws surfaces with the shader programs of the thesis and of the report. A Bézier patch is a patch of the
//! tessellator, and all patches have the same level.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

use std::rc::Rc;

use glow::HasContext;

use crate::error::Result;
use crate::programs::{Output, Pipeline, ProgramKey, location};
use crate::renderer::{
    DrawList, Frame, PreparedSurface, RED, Renderer, analysis_of, in_lines, set_aovs, set_depth,
    set_lights, set_matrices,
};
use crate::scene::{Method, Shading};
use crate::tessellation::{FrameStats, Split};

impl Renderer {
    /// Draws the surfaces of one picture by the method in the frame's settings.
    pub(crate) fn draw_surfaces(
        &mut self,
        surfaces: &mut [PreparedSurface],
        draw_list: &mut DrawList,
        frame: &Frame,
        output: Output,
    ) -> Result<FrameStats> {
        match frame.settings.method {
            Method::Thesis => self.draw_ported(surfaces, frame, output),
            Method::Exact => {
                draw_list.update(self, surfaces, frame)?;
                self.draw_patches(surfaces, draw_list, frame, output, None)?;
                Ok(draw_list.stats())
            }
        }
    }

    /// Draws surfaces as the thesis or the report does.
    fn draw_ported(
        &mut self,
        surfaces: &mut [PreparedSurface],
        frame: &Frame,
        output: Output,
    ) -> Result<FrameStats> {
        let mut stats = FrameStats::default();
        for surface in surfaces.iter_mut().filter(|surface| !surface.surface().hidden) {
            surface.upload_trims(self.gl(), &frame.settings)?;
            self.draw_ported_surface(surface, frame, output, &mut stats)?;
        }
        self.release();
        Ok(stats)
    }

    fn draw_ported_surface(
        &mut self,
        surface: &PreparedSurface,
        frame: &Frame,
        output: Output,
        stats: &mut FrameStats,
    ) -> Result<()> {
        let in_lines = in_lines(&frame.settings, output);
        let texture = match surface.texture() {
            Some(texture) if !in_lines => Rc::clone(texture),
            _ => self.color_texture(if in_lines { RED } else { surface.color() })?,
        };
        let Some(trims) = &surface.uploaded_trims().thesis else { return Ok(()) };
        let aov = output == Output::Aovs;
        let pipeline = Pipeline::ported(surface.degree(), surface.shading());
        let settings = &frame.settings;
        let shading = if in_lines { Shading::Unlit } else { surface.shading() };
        let key = ProgramKey {
            // The report's shaders do not pass on the position, which AOVs need.
            pipeline: if aov { Pipeline::Thesis(surface.degree()) } else { pipeline },
            shading,
            analysis: analysis_of(settings, output).filter(|_| aov).map(|shown| shown.kind()),
            light: frame.settings.light,
            trims: trims.features(&surface.surface().trims),
            output,
            cut_out: output == Output::Picture && texture.has_holes(),
            far_depth: frame.camera.depth_scale().is_some(),
        };
        let program = self.program(key)?;
        program.bind();
        set_depth(&program, frame);
        set_matrices(&program, &surface.points_to_world(), &frame.camera);
        let split = Split::of(settings.tessellation.level());
        program.set_f32(location::TESS_LEVEL, split.level as f32);
        if key.pipeline == Pipeline::Report {
            program.set_i32(location::WIREFRAME, i32::from(settings.wireframe));
            program.set_i32(location::SHOW_CONTROL_POINTS, 0);
        }
        if aov {
            set_aovs(&program, frame);
        }
        if shading == Shading::Phong && !aov {
            set_lights(&program, frame);
        }
        trims.set(&surface.surface().trims, &program, &settings.newton);
        texture.bind(0);
        let points = surface.degree().points();
        self.set_state(frame, points, settings.wireframe);
        let at_once = split.patches_per_draw(settings.wireframe);
        let patches = surface.cones().len();
        self.bind_points(surface);
        for domain in split.domains() {
            program.set_vec3(location::PART, domain);
            for first in (0..patches).step_by(at_once) {
                let count = at_once.min(patches - first);
                let first_patch = stats.patches + first;
                let first = surface.uploaded_points().first() + first * points;
                if aov {
                    program.set_i32(location::FIRST_PATCH, first_patch as i32);
                    program.set_i32(location::FIRST_POINT, first as i32);
                }
                // SAFETY: the context is current (see the type); the range lies within the buffer,
                // whose points fit an i32 since it was made.
                unsafe {
                    self.gl().draw_arrays(glow::PATCHES, first as i32, (count * points) as i32)
                }
                stats.draws += 1;
            }
        }
        let level = u64::from(settings.tessellation.level().get());
        stats.patches += patches;
        stats.triangles += 2 * level * level * patches as u64;
        Ok(())
    }
}
