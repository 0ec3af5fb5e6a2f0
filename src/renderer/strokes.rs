//! Strokes along the joints of faces, which close the gaps between the faces.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

use std::ops::Range;
use std::sync::Arc;

use glam::{DMat4, Mat4, Vec4};
use glow::HasContext;

use super::draws::PlanKey;
use super::surface::{PreparedSurface, to_bytes};
use super::uniforms::set_lights;
use super::{Frame, Renderer, set_aovs};
use crate::camera::ViewProjection;
use crate::error::Result;
use crate::gpu::{TexelBuffer, samples_of_target};
use crate::model::Joint;
use crate::parallel;
use crate::programs::{Output, Pipeline, ProgramKey, STROKES_UNIT, TrimFeatures, location};
use crate::scene::{Method, Paint, Shading, Tessellation};
use crate::tessellation::{PlacedJoint, SEGMENT_TEXELS, StrokeSegment, StrokeSide, StrokeView};

/// The error of `f32` in a face's border, as a share of the size of its control points' box: that of the points and of
/// the trims.
const ROUNDING: f64 = 5e-7;
/// Segments of an instance: as many vertices as suit drivers that do not take all of a draw at once.
const GROUP: usize = 64;
/// Joints that a thread takes at once.
const TOGETHER: usize = 128;

/// A joint of two surfaces of a scene.
#[derive(Debug)]
pub(crate) struct SurfaceJoint {
    /// The joints of its model, or of all surfaces without a model.
    pub(crate) joints: Arc<[Joint]>,
    /// Its number among them.
    pub(crate) number: usize,
    /// The numbers of the surfaces.
    pub(crate) surfaces: [usize; 2],
    /// A patch of each among the patches of all surfaces.
    pub(crate) patches: [usize; 2],
    /// The transforms of the surfaces for which the joint was made in world space; `None`: it is in the space of both.
    pub(crate) made_for: Option<[DMat4; 2]>,
}

/// The joints of a scene and their strokes in the last view.
#[derive(Debug, Default)]
pub(crate) struct Strokes {
    joints: Vec<SurfaceJoint>,
    /// What the segments were made for: the view, and the state of the list of draws.
    key: Option<(PlanKey, u64)>,
    /// The segments of each shading model.
    runs: Vec<(Shading, Range<usize>)>,
    buffer: Option<TexelBuffer>,
}

impl Strokes {
    pub(crate) fn new(joints: Vec<SurfaceJoint>) -> Self {
        Self { joints, ..Self::default() }
    }

    /// Brings the segments up to date with the surfaces, whose state has the number `state`, and the frame.
    ///
    /// # Errors
    /// No memory.
    pub(crate) fn update(
        &mut self,
        renderer: &Renderer,
        surfaces: &[PreparedSurface],
        frame: &Frame,
        state: u64,
    ) -> Result<()> {
        let settings = &frame.settings;
        let key = (PlanKey::new(frame, settings.tessellation), state);
        if self.joints.is_empty() || self.key == Some(key) {
            return Ok(());
        }
        self.key = None;
        self.runs.clear();
        let (Tessellation::Within(tolerance), Method::Exact, false) =
            (settings.tessellation, settings.method, settings.wireframe)
        else {
            return Ok(());
        };
        let view = StrokeView::new(&frame.camera, frame.viewport.pixels(), tolerance.pixels());
        let shading_of = |joint: &SurfaceJoint| surfaces[joint.surfaces[0]].shading();
        let mut placed: Vec<(Shading, PlacedJoint<'_>)> = Vec::with_capacity(self.joints.len());
        for joint in &self.joints {
            placed.extend(joint.placed(surfaces).map(|placed| (shading_of(joint), placed)));
        }
        let groups: Vec<&[_]> = placed.chunks(TOGETHER).collect();
        let of_groups = parallel::map(groups.len(), |number| {
            let mut segments: Vec<(Shading, StrokeSegment)> = Vec::new();
            let mut of_joint = Vec::new();
            for (shading, joint) in groups[number] {
                view.add(joint, &mut of_joint);
                segments.extend(of_joint.drain(..).map(|segment| (*shading, segment)));
            }
            segments
        });
        let mut segments: Vec<StrokeSegment> = Vec::new();
        for shading in [Shading::Phong, Shading::Unlit, Shading::Normals] {
            let first = segments.len();
            let all = of_groups.iter().flatten().filter(|(own, _)| *own == shading);
            segments.extend(all.map(|(_, segment)| *segment));
            if segments.len() > first {
                self.runs.push((shading, first..segments.len()));
            }
        }
        if !segments.is_empty() {
            let bytes = size_of_val(segments.as_slice());
            if self.buffer.as_ref().is_none_or(|buffer| buffer.buffer().bytes() < bytes) {
                let texels = segments.len().next_power_of_two() * SEGMENT_TEXELS;
                self.buffer = Some(TexelBuffer::of_texels(renderer.gl(), "strokes", texels)?);
            }
            if let Some(buffer) = &self.buffer {
                buffer.buffer().write(0, &segments);
            }
        }
        self.key = Some(key);
        Ok(())
    }

    /// The number of draws.
    pub(crate) fn draws(&self) -> usize {
        self.runs.len()
    }
}

impl SurfaceJoint {
    /// The joint in its place; `None` if a surface is hidden or no longer as the joint was made for.
    fn placed<'a>(&'a self, surfaces: &'a [PreparedSurface]) -> Option<PlacedJoint<'a>> {
        let [one, other] = self.surfaces.map(|number| &surfaces[number]);
        let joint = &self.joints[self.number];
        let is_whole =
            |surface: &PreparedSurface| !surface.surface().hidden && !surface.is_reshaped();
        let transforms = [one, other].map(|surface| surface.surface().transform);
        let (transform, is_in_place) = match self.made_for {
            Some(made_for) => (DMat4::IDENTITY, transforms == made_for),
            None => (transforms[0], transforms[0] == transforms[1]),
        };
        if !is_whole(one) || !is_whole(other) || !is_in_place {
            return None;
        }
        let side = |i: usize| {
            let surface = &surfaces[self.surfaces[i]];
            StrokeSide {
                patch: self.patches[i] as u32,
                color: to_bytes(surface.color()),
                picture: match &surface.surface().paint {
                    Paint::Texture(picture) => Some(picture.as_ref()),
                    Paint::Color(_) => None,
                },
                is_flat: surface.is_flat(),
                side: joint.sides[i],
            }
        };
        let scale = |of: DMat4| {
            let axes = [of.x_axis, of.y_axis, of.z_axis];
            axes.map(|axis| axis.length()).into_iter().fold(0.0, f64::max)
        };
        let size = (scale(transforms[0]) * one.points_scale())
            .max(scale(transforms[1]) * other.points_scale());
        Some(PlacedJoint {
            pieces: &joint.pieces,
            transform,
            sides: [side(0), side(1)],
            gap: scale(transform) * joint.gap + ROUNDING * size,
        })
    }
}

impl Renderer {
    /// Draws the strokes of an up-to-date list.
    ///
    /// # Errors
    /// A shader that the driver rejects.
    pub(crate) fn draw_strokes(
        &mut self,
        strokes: &Strokes,
        frame: &Frame,
        output: Output,
    ) -> Result<()> {
        let Some(buffer) = strokes.buffer.as_ref().filter(|_| strokes.key.is_some()) else {
            return Ok(());
        };
        let samples = samples_of_target(self.gl());
        for (shading, run) in &strokes.runs {
            let program = self.program(ProgramKey {
                pipeline: Pipeline::Strokes { samples },
                shading: *shading,
                trims: TrimFeatures::NONE,
                output,
                cut_out: false,
                far_depth: frame.camera.depth_scale().is_some(),
            })?;
            program.bind();
            match output {
                Output::Aovs => set_aovs(&program, frame),
                _ if *shading == Shading::Phong => set_lights(&program, frame),
                _ => {}
            }
            let view = StrokeView::new(&frame.camera, frame.viewport.pixels(), 1.0);
            let [start, direction] = view.rays().map(|rays| Mat4::from_mat3(rays.as_mat3()));
            program.set_mat4(location::RAY_START, &start);
            program.set_mat4(location::RAY_DIRECTION, &direction);
            program.set_vec4(location::DEPTH_TERMS, depth_terms(&frame.camera));
            program.set_vec4(location::VIEWPORT, frame.viewport.origin_and_half());
            program.set_i32(location::FIRST_SEGMENT, run.start as i32);
            program.set_i32(location::GROUP_SIZE, GROUP as i32);
            program.set_i32(location::SEGMENTS, run.end as i32);
            buffer.bind(STROKES_UNIT);
            self.set_state(frame, 1, false);
            self.sub_patches_array.bind_bare();
            let instances = run.len().div_ceil(GROUP) as i32;
            // SAFETY: the context is current (see the renderer); the shader fetches within the buffer.
            unsafe {
                self.gl().draw_arrays_instanced(glow::TRIANGLES, 0, 6 * GROUP as i32, instances);
            }
        }
        self.release();
        Ok(())
    }
}

/// How depth follows from the distance d along the view axis: (x d + y) / (z d + w).
fn depth_terms(camera: &ViewProjection) -> Vec4 {
    if let Some(scale) = camera.depth_scale() {
        return Vec4::new(scale as f32, 0.0, 0.0, 1.0);
    }
    let (z, w) = (camera.projection.row(2), camera.projection.row(3));
    let terms = [-0.5 * (z.z + w.z), 0.5 * (z.w + w.w), -w.z, w.w];
    Vec4::from_array(terms.map(|term| term as f32))
}
