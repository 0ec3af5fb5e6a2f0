//! Strokes along the joints of faces: those that close the gaps between the faces, and lines.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use glam::{DMat4, DVec4, Mat4, Vec4};
use glow::HasContext;

use super::draw_list::DrawList;
use super::draws::PlanKey;
use super::solids::Solids;
use super::surface::{PreparedSurface, to_bytes};
use super::uniforms::{analysis_of, set_analysis, set_lights};
use super::{Frame, Renderer, set_aovs};
use crate::camera::ViewProjection;
use crate::error::Result;
use crate::gpu::{TexelBuffer, samples_of_target};
use crate::model::{Continuity, Joint, JointKind, Model};
use crate::parallel;
use crate::programs::{Output, Pipeline, ProgramKey, STROKES_UNIT, TrimFeatures, location};
use crate::scene::{
    Analysis, AnalysisKind, CurvatureKind, EdgeColor, Edges, Method, Paint, Shading, Tessellation,
};
use crate::tessellation::{
    CurvaturePaint, PlacedJoint, SEGMENT_TEXELS, StrokeLine, StrokePaint, StrokeSegment,
    StrokeSide, StrokeView,
};

/// The error of `f32` in a face's border, as a share of the size of its control points' box: that of the points and of
/// the trims.
const ROUNDING: f64 = 5e-7;
/// Segments of an instance: as many vertices as suit drivers that do not take all of a draw at once.
const GROUP: usize = 64;
/// Joints that a thread takes at once.
const TOGETHER: usize = 128;
/// Segments of one shading model are drawn together, in this order.
const SHADINGS: [Shading; 3] = [Shading::Phong, Shading::Unlit, Shading::Normals];

/// A joint of surfaces of a scene.
#[derive(Debug)]
pub(crate) struct SurfaceJoint {
    /// The joints of its model, or of all surfaces without a model.
    pub(crate) joints: Arc<[Joint]>,
    /// Its number among them.
    pub(crate) number: usize,
    /// The numbers of the surfaces; the same one twice if a surface ends there.
    pub(crate) surfaces: [usize; 2],
    /// A patch of each among the patches of all surfaces.
    pub(crate) patches: [usize; 2],
    /// Whether the gap between the surfaces is to be closed.
    pub(crate) closes_gap: bool,
    /// The number of its model in the scene. Surfaces without a model have no edges.
    pub(crate) model: Option<usize>,
    /// The transforms of the surfaces for which the joint was made in world space; `None`: it is in the space of both.
    pub(crate) made_for: Option<[DMat4; 2]>,
}

/// The joints of a scene, and their strokes and lines in the last view.
#[derive(Debug, Default)]
pub(crate) struct Strokes {
    joints: Vec<SurfaceJoint>,
    /// The models of the scene.
    models: Vec<ModelEdges>,
    /// What closes the gaps between faces.
    closing: Segments,
    /// Lines along edges.
    lines: Segments,
}

/// A model, and how its faces meet.
#[derive(Debug)]
struct ModelEdges {
    model: Arc<Model>,
    /// The class of each edge that has one, by its number, once it was asked for.
    classes: Option<HashMap<usize, Continuity>>,
}

/// Segments in the driver's memory.
#[derive(Debug, Default)]
struct Segments {
    /// What they were made for.
    key: Option<SegmentsKey>,
    /// The segments of each shading model.
    runs: Vec<(Shading, Range<usize>)>,
    buffer: Option<TexelBuffer>,
}

/// What segments depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SegmentsKey {
    view: PlanKey,
    /// The state of the list of draws.
    state: u64,
    edges: Option<Edges>,
    /// Whether colours are those of an analysis.
    are_analysed: bool,
    /// The curvature that colours show, and its value at the end of the scale.
    curvature: Option<(CurvatureKind, f64)>,
}

/// What the colours of surfaces are in a frame.
struct Colors<'a> {
    surfaces: &'a [PreparedSurface],
    /// Whether they are those of an analysis.
    are_analysed: bool,
    curvature: Option<CurvatureColors>,
}

struct CurvatureColors {
    kind: CurvatureKind,
    limit: f64,
    /// In world space.
    eye: DVec4,
    /// For each surface, the number of its first patch among those of all surfaces.
    firsts: Vec<usize>,
}

impl Strokes {
    /// With the models of the scene.
    pub(crate) fn new(joints: Vec<SurfaceJoint>, models: Vec<Arc<Model>>) -> Self {
        let models = models.into_iter().map(|model| ModelEdges { model, classes: None }).collect();
        Self { joints, models, ..Self::default() }
    }

    /// Whether there are gaps to be closed, which needs a share of the tolerance.
    pub(crate) fn close_gaps(&self) -> bool {
        self.joints.iter().any(|joint| joint.closes_gap)
    }

    /// Whether the last view shows strokes that close gaps.
    pub(crate) fn closed_gaps(&self) -> bool {
        !self.closing.runs.is_empty()
    }

    /// Brings the segments up to date with the surfaces, the frame, and the list that is up to date with both.
    ///
    /// # Errors
    /// No memory; a model whose edges are to have the colours of their classes, and that [`Model::check`] refuses.
    pub(crate) fn update(
        &mut self,
        renderer: &Renderer,
        surfaces: &[PreparedSurface],
        frame: &Frame,
        list: &DrawList,
    ) -> Result<()> {
        let settings = &frame.settings;
        let view = PlanKey::new(frame, settings.tessellation);
        let analysis = settings.shown_analysis();
        let curvature = match analysis {
            Some(Analysis::Curvature { of, .. }) => {
                list.curvature_limit(analysis).map(|limit| (of, limit))
            }
            _ => None,
        };
        let are_analysed = analysis.is_some();
        let key = SegmentsKey { view, state: list.state(), edges: None, are_analysed, curvature };
        let solids = list.solids();
        let is_exact = settings.method == Method::Exact;
        let by_class =
            settings.edges.is_some_and(|edges| edges.color == EdgeColor::Continuity) && is_exact;
        for model in self.models.iter_mut().filter(|_| by_class) {
            model.classify()?;
        }
        let (joints, models) = (&self.joints, &self.models);
        match settings.tessellation {
            Tessellation::Within(tolerance) if is_exact && !settings.wireframe => {
                let view = StrokeView::new(&frame.camera, key.view.size, tolerance.pixels());
                self.closing.update(renderer, key, &view, || {
                    let colors = Colors::new(surfaces, frame, are_analysed, curvature);
                    joints.iter().filter_map(|joint| joint.placed(&colors, solids)).collect()
                })?;
            }
            _ => self.closing.clear(),
        }
        match &settings.edges {
            Some(edges) if is_exact => {
                let view = StrokeView::new(&frame.camera, key.view.size, 1.0);
                let key = SegmentsKey {
                    edges: settings.edges,
                    are_analysed: false,
                    curvature: None,
                    ..key
                };
                let off_faces = match settings.tessellation {
                    Tessellation::Within(tolerance) => tolerance.pixels(),
                    Tessellation::Level(_) => 1.0,
                };
                self.lines.update(renderer, key, &view, || {
                    let colors = Colors { surfaces, are_analysed: false, curvature: None };
                    joints
                        .iter()
                        .filter_map(|joint| joint.line(&colors, solids, models, edges, off_faces))
                        .collect()
                })?;
            }
            _ => self.lines.clear(),
        }
        Ok(())
    }
}

impl<'a> Colors<'a> {
    fn new(
        surfaces: &'a [PreparedSurface],
        frame: &Frame,
        are_analysed: bool,
        curvature: Option<(CurvatureKind, f64)>,
    ) -> Self {
        let curvature = curvature.map(|(kind, limit)| CurvatureColors {
            kind,
            limit,
            eye: frame.camera.view.inverse() * frame.camera.eye_in_view(),
            firsts: surfaces
                .iter()
                .scan(0, |next, surface| {
                    *next += surface.cones().len();
                    Some(*next - surface.cones().len())
                })
                .collect(),
        });
        Self { surfaces, are_analysed, curvature }
    }

    /// Of a surface; `patch` is one of its patches among those of all surfaces.
    fn of(&self, surface: usize, patch: usize) -> StrokePaint<'a> {
        let own = self.surfaces[surface].surface();
        let picture = match &own.paint {
            Paint::Texture(picture) => Some(picture.as_ref()),
            Paint::Color(_) => None,
        };
        match (&self.curvature, picture) {
            (Some(CurvatureColors { kind, limit, eye, firsts }), picture) => {
                let patch = patch - firsts[surface];
                let (kind, limit, eye) = (*kind, *limit, *eye);
                let surface = own;
                let paint = CurvaturePaint { surface, patch, kind, limit, picture, eye };
                StrokePaint::Curvature(paint)
            }
            (None, Some(picture)) => StrokePaint::Picture(picture),
            (None, None) => StrokePaint::Color(to_bytes(self.surfaces[surface].color())),
        }
    }
}

impl ModelEdges {
    /// Finds the classes of the edges, if they are not known.
    ///
    /// # Errors
    /// A model that [`Model::check`] refuses.
    fn classify(&mut self) -> Result<()> {
        if self.classes.is_none() {
            let edges = self.model.continuity()?;
            self.classes = Some(edges.into_iter().map(|edge| (edge.edge, edge.class)).collect());
        }
        Ok(())
    }

    fn class(&self, edge: usize) -> Option<Continuity> {
        self.classes.as_ref()?.get(&edge).copied()
    }
}

impl Segments {
    fn clear(&mut self) {
        self.key = None;
        self.runs.clear();
    }

    /// Makes the segments of joints, unless they are up to date.
    fn update<'a>(
        &mut self,
        renderer: &Renderer,
        key: SegmentsKey,
        view: &StrokeView,
        joints: impl FnOnce() -> Vec<(Shading, PlacedJoint<'a>)>,
    ) -> Result<()> {
        if self.key == Some(key) {
            return Ok(());
        }
        self.clear();
        let placed = joints();
        let groups: Vec<&[_]> = placed.chunks(TOGETHER).collect();
        let of_groups = parallel::map(groups.len(), |number| {
            let mut segments = SHADINGS.map(|shading| (shading, Vec::new()));
            for (shading, joint) in groups[number] {
                let alike = segments.iter_mut().find(|(own, _)| own == shading);
                alike.into_iter().for_each(|(_, segments)| view.add(joint, segments));
            }
            segments
        });
        let all = || of_groups.iter().flatten().filter(|(_, segments)| !segments.is_empty());
        let count: usize = all().map(|(_, segments)| segments.len()).sum();
        let bytes = count * size_of::<StrokeSegment>();
        if self.buffer.as_ref().map_or(0, |buffer| buffer.buffer().bytes()) < bytes {
            let texels = count.next_power_of_two() * SEGMENT_TEXELS;
            self.buffer = Some(TexelBuffer::of_texels(renderer.gl(), "strokes", texels)?);
        }
        let mut next = 0;
        for shading in SHADINGS {
            let first = next;
            for (_, segments) in all().filter(|(own, _)| *own == shading) {
                let buffer = self.buffer.as_ref().expect("it has room for all segments");
                buffer.buffer().write(next, segments);
                next += segments.len();
            }
            if next > first {
                self.runs.push((shading, first..next));
            }
        }
        self.key = Some(key);
        Ok(())
    }
}

impl SurfaceJoint {
    fn joint(&self) -> &Joint {
        &self.joints[self.number]
    }

    /// The joint in its place, whose gap is to be closed; `None` if a surface is hidden or no longer as the joint was
    /// made for.
    fn placed<'a>(
        &'a self,
        colors: &Colors<'a>,
        solids: &Solids,
    ) -> Option<(Shading, PlacedJoint<'a>)> {
        let surfaces = colors.surfaces;
        let shown = self.shown(surfaces)?;
        if !self.closes_gap || shown != [true; 2] {
            return None;
        }
        let scale = |of: DMat4| {
            let axes = [of.x_axis, of.y_axis, of.z_axis];
            axes.map(|axis| axis.length()).into_iter().fold(0.0, f64::max)
        };
        let [one, other] = self.surfaces.map(|number| &surfaces[number]);
        let size = |of: &PreparedSurface| scale(of.surface().transform) * of.points_scale();
        let gap = scale(self.transform(surfaces)) * self.joint().gap
            + ROUNDING * size(one).max(size(other));
        let shading = if colors.are_analysed { Shading::Unlit } else { one.shading() };
        Some((shading, self.with(colors, solids, gap, None)))
    }

    /// The line along the joint.
    fn line<'a>(
        &'a self,
        colors: &Colors<'a>,
        solids: &Solids,
        models: &[ModelEdges],
        edges: &Edges,
        off_faces: f64,
    ) -> Option<(Shading, PlacedJoint<'a>)> {
        let joint = self.joint();
        let color = match edges.color {
            EdgeColor::Continuity => models[self.model?].class(joint.edge)?.color(),
            EdgeColor::Rgb(rgb) => rgb,
        };
        let is_drawn = self.model.is_some()
            && match joint.kind {
                _ if edges.color == EdgeColor::Continuity => true,
                JointKind::Open | JointKind::Sharp => true,
                JointKind::Smooth => edges.smooth,
                JointKind::Seam => false,
            };
        let shown = self.shown(colors.surfaces).filter(|shown| is_drawn && *shown != [false; 2])?;
        let half_width = 0.5 * edges.width.pixels();
        let nearer = half_width + off_faces;
        let line = StrokeLine { half_width, color: to_bytes(color), nearer, shown };
        Some((Shading::Unlit, self.with(colors, solids, 0.0, Some(line))))
    }

    /// Which of the surfaces are drawn; `None` if one is no longer as the joint was made for.
    fn shown(&self, surfaces: &[PreparedSurface]) -> Option<[bool; 2]> {
        let [one, other] = self.surfaces.map(|number| &surfaces[number]);
        let transforms = [one, other].map(|surface| surface.surface().transform);
        let is_together = match self.made_for {
            Some(made_for) => transforms == made_for,
            None => transforms[0] == transforms[1],
        };
        let is_as_made = is_together && !one.is_reshaped() && !other.is_reshaped();
        is_as_made.then(|| [one, other].map(|surface| !surface.surface().hidden))
    }

    /// From the space of the joint to world space.
    fn transform(&self, surfaces: &[PreparedSurface]) -> DMat4 {
        match self.made_for {
            Some(_) => DMat4::IDENTITY,
            None => surfaces[self.surfaces[0]].surface().transform,
        }
    }

    fn with<'a>(
        &'a self,
        colors: &Colors<'a>,
        solids: &Solids,
        gap: f64,
        line: Option<StrokeLine>,
    ) -> PlacedJoint<'a> {
        let joint = self.joint();
        let surfaces = colors.surfaces;
        let side = |i: usize| {
            let surface = &surfaces[self.surfaces[i]];
            StrokeSide {
                patch: self.patches[i] as u32,
                paint: colors.of(self.surfaces[i], self.patches[i]),
                is_flat: surface.is_flat(),
                side: joint.sides[i],
            }
        };
        let transform = self.transform(surfaces);
        let outside = match self.surfaces.map(|number| solids.seen(number)) {
            [Some((eye, solid, one)), Some((_, same, other))] if solid == same => {
                Some((eye, [one, other]))
            }
            _ => None,
        };
        let (pieces, ranges) = (&joint.pieces, &joint.ranges);
        PlacedJoint { pieces, ranges, transform, sides: [side(0), side(1)], gap, line, outside }
    }
}

impl Renderer {
    /// Draws what an up-to-date list has for an output: the strokes that close gaps, and on pictures the lines. Returns
    /// the number of draws.
    ///
    /// # Errors
    /// A shader that the driver rejects.
    pub(crate) fn draw_strokes(
        &mut self,
        strokes: &Strokes,
        frame: &Frame,
        output: Output,
    ) -> Result<usize> {
        self.draw_segments(&strokes.closing, frame, output, false)?;
        let is_picture = output == Output::Picture;
        if is_picture {
            self.draw_segments(&strokes.lines, frame, output, true)?;
        }
        let lines = if is_picture { strokes.lines.runs.len() } else { 0 };
        Ok(strokes.closing.runs.len() + lines)
    }

    fn draw_segments(
        &mut self,
        segments: &Segments,
        frame: &Frame,
        output: Output,
        lines: bool,
    ) -> Result<()> {
        let Some(buffer) = segments.buffer.as_ref().filter(|_| segments.key.is_some()) else {
            return Ok(());
        };
        let samples = samples_of_target(self.gl());
        // The colours of curvature are in the segments.
        let is_shown = |shown: &Analysis| {
            !lines && (output == Output::Aovs || shown.kind() != AnalysisKind::Curvature)
        };
        let analysis = analysis_of(&frame.settings, output).filter(is_shown);
        for (shading, run) in &segments.runs {
            let program = self.program(ProgramKey {
                pipeline: Pipeline::Strokes { samples, lines },
                shading: *shading,
                analysis: analysis.map(|shown| shown.kind()),
                light: frame.settings.light,
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
            if let Some(analysis) = analysis.as_ref().filter(|_| output == Output::Picture) {
                set_analysis(&program, frame, analysis, 1.0);
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
