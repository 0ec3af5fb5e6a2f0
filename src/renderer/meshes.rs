//! Meshes as smooth triangles: patches of three points, cut by the tessellation stages.
#![allow(unsafe_code, reason = "drawing is unsafe in glow")]

use std::mem::offset_of;
use std::rc::Rc;

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3};
use glow::HasContext;

use super::capture::Feedback;
use super::draw_list::{PlanKey, matrices};
use super::points::LocalFrame;
use super::programs::{LEVELS_UNIT, Output, Pipeline, ProgramKey, TrimFeatures, location};
use super::{
    DrawnVertex, Frame, Renderer, in_lines, set_columns, set_depth, set_for_aovs, set_lights,
};
use crate::error::Result;
use crate::gpu::{Attribute, Buffer, Gl, Target, TexelBuffer, Texture, Vertex};
use crate::mesh::{Corner, Smoothing};
use crate::scene::{MeshModel, Paint, Shading, TessLevel, Tessellation, check_transform};
use crate::tessellation::{
    DrawSize, FrameStats, Rounding, Screen, TriangleBound, parts_of_next_draw, raise,
    triangles_of_triangle, vertices_of_triangle,
};

/// A corner of a flat triangle as `triangles/triangle.vert` reads it.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct FlatCorner {
    /// And s of the texture coordinates.
    position: [f32; 4],
    /// And t.
    normal: [f32; 4],
}

/// The same without texture coordinates.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct BareCorner {
    position: [f32; 3],
    normal: [f32; 3],
}

/// A corner of a smooth triangle.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct SmoothCorner {
    flat: FlatCorner,
    /// The normal here that shapes the edge to the next corner, and the edge from the one before.
    leaving: [f32; 3],
    arriving: [f32; 3],
}

impl Vertex for FlatCorner {
    const ATTRIBUTES: &'static [Attribute] = &[
        Attribute::floats(0, 4, offset_of!(Self, position)),
        Attribute::floats(1, 4, offset_of!(Self, normal)),
    ];
}

/// OpenGL makes the fourth numbers 1.
impl Vertex for BareCorner {
    const ATTRIBUTES: &'static [Attribute] = &[
        Attribute::floats(0, 3, offset_of!(Self, position)),
        Attribute::floats(1, 3, offset_of!(Self, normal)),
    ];
}

impl Vertex for SmoothCorner {
    const ATTRIBUTES: &'static [Attribute] = &[
        Attribute::floats(0, 4, offset_of!(Self, flat.position)),
        Attribute::floats(1, 4, offset_of!(Self, flat.normal)),
        Attribute::floats(2, 3, offset_of!(Self, leaving)),
        Attribute::floats(3, 3, offset_of!(Self, arriving)),
    ];
}

/// A draw call: so many triangles from this one on.
#[derive(Debug, Clone, Copy)]
struct Draw {
    first: usize,
    count: usize,
    triangles: u64,
    /// The number of its paint.
    paint: usize,
}

/// The paint of triangles up to this one.
#[derive(Debug)]
struct Painted {
    end: usize,
    texture: Rc<Texture>,
}

impl Painted {
    fn has_holes(&self) -> bool {
        self.texture.has_holes()
    }
}

/// A mesh in the driver's memory.
#[derive(Debug)]
pub(crate) struct PreparedMesh {
    model: MeshModel,
    paints: Vec<Painted>,
    centering: LocalFrame,
    corners: Buffer,
    /// Of each corner, if the mesh has some.
    colors: Option<Buffer>,
    /// Control points of all triangles, 10 or 6 each; none of flat ones.
    nets: Vec<DVec3>,
    seen: Option<PlanKey>,
    /// Of each triangle what it needs by itself; 0 if it is out of sight.
    needs: Vec<u8>,
    /// Of each edge the larger need.
    edges: Vec<u8>,
    /// Of each triangle the levels as the control stage reads them; 0 if it is not drawn.
    words: Vec<u32>,
    levels: Option<TexelBuffer>,
    draws: Vec<Draw>,
    figures: FrameStats,
}

impl PreparedMesh {
    /// Uploads a mesh; `texture` uploads a paint.
    pub(crate) fn new<'a>(
        gl: &Gl,
        model: &'a MeshModel,
        mut texture: impl FnMut(&'a Paint) -> Result<Rc<Texture>>,
    ) -> Result<Self> {
        check_transform(&model.transform)?;
        let mesh = model.mesh().mesh();
        let count = mesh.triangles().len();
        let mut paints: Vec<Painted> = Vec::new();
        for material in &model.materials {
            let begin = paints.last().map_or(0, |paint| paint.end);
            if begin < material.triangles.start {
                let texture = texture(&model.paint)?;
                paints.push(Painted { end: material.triangles.start, texture });
            }
            paints
                .push(Painted { end: material.triangles.end, texture: texture(&material.paint)? });
        }
        if paints.last().is_none_or(|paint| paint.end < count) {
            paints.push(Painted { end: count, texture: texture(&model.paint)? });
        }
        let centering = LocalFrame::of(model.hull().map(|point| point.extend(1.0)).iter());
        let is_flat = model.smoothing() == Smoothing::None;
        let flat_corner = |corner: &Corner| {
            let st = mesh.coordinates().get(corner.coordinate as usize);
            let st = st.copied().unwrap_or_default().as_vec2();
            let position = mesh.positions()[corner.position as usize].extend(1.0);
            let normal = mesh.normals()[corner.normal as usize].as_vec3();
            FlatCorner {
                position: centering.apply(position).truncate().extend(st.x).into(),
                normal: normal.extend(st.y).into(),
            }
        };
        let all = || mesh.triangles().iter().flatten();
        let corners = if is_flat && mesh.coordinates().is_empty() {
            let bare = |corner| {
                let FlatCorner { position: [x, y, z, _], normal: [a, b, c, _] } =
                    flat_corner(corner);
                BareCorner { position: [x, y, z], normal: [a, b, c] }
            };
            Buffer::of_values(gl, "bare corners of flat triangles", 3 * count, all().map(bare))?
        } else if is_flat {
            let corners = all().map(flat_corner);
            Buffer::of_values(gl, "corners of flat triangles", 3 * count, corners)?
        } else {
            let corners = (0..).zip(mesh.triangles()).flat_map(|(number, own)| {
                let triangle = model.mesh().triangle(number);
                [0, 1, 2].map(|k| SmoothCorner {
                    flat: flat_corner(&own[k]),
                    leaving: triangle.edge_normals[k][0].as_vec3().into(),
                    arriving: triangle.edge_normals[(k + 2) % 3][1].as_vec3().into(),
                })
            });
            Buffer::of_values(gl, "corners of smooth triangles", 3 * count, corners)?
        };
        let colors = (!mesh.colors().is_empty()).then(|| {
            let colors = all().map(|corner| {
                let [red, green, blue] = mesh.colors()[corner.position as usize]
                    .map(|value| (255.0 * value).round() as u8);
                [red, green, blue, 255]
            });
            Buffer::of_values(gl, "colors of corners", 3 * count, colors)
        });
        let mut nets = Vec::new();
        if !is_flat {
            for number in 0..count as u32 {
                model.curved(number).with_control_points(|points| nets.extend_from_slice(points));
            }
        }
        Ok(Self {
            model: model.clone(),
            paints,
            centering,
            corners,
            colors: colors.transpose()?,
            nets,
            seen: None,
            needs: Vec::new(),
            edges: Vec::new(),
            words: Vec::new(),
            levels: None,
            draws: Vec::new(),
            figures: FrameStats::default(),
        })
    }

    /// What a frame draws of it.
    pub(crate) const fn stats(&self) -> FrameStats {
        self.figures
    }

    /// From the driver's points to world space.
    fn points_to_world(&self) -> DMat4 {
        self.model.transform * self.centering.to_model()
    }

    /// Brings levels and draws up to date with a frame.
    pub(crate) fn update(
        &mut self,
        gl: &Gl,
        frame: &Frame,
        target: &Target,
        draw_size: DrawSize,
    ) -> Result<()> {
        let tessellation = match (self.model.smoothing(), self.model.level) {
            (Smoothing::None, _) => Tessellation::Level(TessLevel::ONE),
            (_, Some(level)) => Tessellation::Level(level),
            (_, None) => frame.settings.tessellation,
        };
        let seen = PlanKey { projection: frame.projection, size: target.size, tessellation };
        if self.seen == Some(seen) {
            return Ok(());
        }
        // Only a whole update counts.
        self.seen = None;
        self.find_levels(&seen);
        match &self.levels {
            Some(levels) => levels.buffer().write(0, &self.words),
            None => {
                self.levels = Some(TexelBuffer::of_words(gl, "levels of triangles", &self.words)?)
            }
        }
        self.find_draws(draw_size);
        self.seen = Some(seen);
        Ok(())
    }

    /// The levels of all triangles that can be seen.
    fn find_levels(&mut self, seen: &PlanKey) {
        let (tolerance, fixed) = match seen.tessellation {
            Tessellation::Within(tolerance) => (tolerance.pixels(), None),
            Tessellation::Level(level) => (1.0, Some(level.get() as u8)),
        };
        let screen = Screen::new(&seen.projection, seen.size, tolerance);
        let view_to_clip = seen.projection.projection * seen.projection.view;
        let rounding = Rounding::new(&(view_to_clip * self.points_to_world()), 1.0);
        let to_clip = view_to_clip * self.model.transform;
        let mesh = self.model.mesh();
        let triangles = mesh.mesh().triangles().len();
        let mut figures = FrameStats { patches: triangles, ..FrameStats::default() };
        let bound = |triangle: usize| {
            let points = self.nets.len() / triangles;
            if points == 0 {
                let corners = mesh.mesh().triangles()[triangle]
                    .map(|corner| mesh.mesh().positions()[corner.position as usize]);
                return TriangleBound::new(&corners, &to_clip, &screen, &rounding);
            }
            let net = &self.nets[triangle * points..][..points];
            TriangleBound::new(net, &to_clip, &screen, &rounding)
        };
        self.needs.clear();
        self.edges.clear();
        // At one level all edges have it.
        self.edges.resize(if fixed.is_none() { mesh.edges() as usize } else { 0 }, 0);
        for triangle in 0..triangles {
            let bound = bound(triangle);
            let need = bound.map_or(0, |bound| fixed.unwrap_or_else(|| bound.level(&screen)));
            if let Some(bound) = bound {
                let error = bound.error(need, &screen);
                raise(&mut figures.largest_bound, error);
                if fixed.is_none() && error > screen.tolerance() {
                    raise(&mut figures.unmet, error);
                }
            }
            if fixed.is_none() {
                for k in 0..3 {
                    let edge = &mut self.edges[mesh.edge((3 * triangle + k) as u32) as usize];
                    *edge = need.max(*edge);
                }
            }
            self.needs.push(need);
        }
        self.words.clear();
        for (triangle, need) in self.needs.iter().enumerate() {
            let edges: [u32; 3] = [0, 1, 2].map(|k| match fixed {
                Some(level) => level.into(),
                None => self.edges[mesh.edge((3 * triangle + k) as u32) as usize].into(),
            });
            let inside = edges[0].max(edges[1]).max(edges[2]);
            let drawn = *need > 0;
            let word = edges[0] | edges[1] << 8 | edges[2] << 16 | inside << 24;
            self.words.push(if drawn { word } else { 0 });
            figures.culled += usize::from(!drawn);
            figures.triangles += triangles_of_triangle(if drawn { inside } else { 0 });
        }
        self.figures = figures;
    }

    /// Draws of triangles of one paint that follow one another, as many vertices each as the driver likes.
    fn find_draws(&mut self, draw_size: DrawSize) {
        self.draws.clear();
        let inside = |word: &u32| word >> 24;
        let vertices = |word: &u32| if *word == 0 { 0 } else { vertices_of_triangle(inside(word)) };
        let mut first = 0;
        for (paint, Painted { end, .. }) in self.paints.iter().enumerate() {
            while let Some(next) = self.words[first..*end].iter().position(|word| *word != 0) {
                first += next;
                let rest = &self.words[first..*end];
                let fitting = parts_of_next_draw(rest.iter().map(vertices), draw_size);
                let last = rest[..fitting].iter().rposition(|word| *word != 0);
                let count = last.map_or(fitting, |last| last + 1);
                let triangles =
                    rest[..count].iter().map(|word| triangles_of_triangle(inside(word)));
                self.draws.push(Draw { first, count, triangles: triangles.sum(), paint });
                first += count;
            }
            first = *end;
        }
        self.figures.draws = self.draws.len();
    }
}

impl Renderer {
    /// Draws a mesh as it was last updated; `first_patch` is the number of its first triangle among all
    /// patches.
    pub(super) fn draw_mesh(
        &mut self,
        mesh: &PreparedMesh,
        frame: &Frame,
        output: Output,
        first_patch: usize,
        mut kept: Option<&mut Vec<DrawnVertex>>,
    ) -> Result<()> {
        let Some(levels) = &mesh.levels else { return Ok(()) };
        let smoothing = mesh.model.smoothing();
        let is_picture = output == Output::Picture;
        let own = &mesh.paints[0].texture;
        let (shading, _) = self.look(mesh.model.shading, own, &frame.settings, output);
        let in_lines = in_lines(&frame.settings, output);
        let colored = mesh.colors.is_some() && is_picture && !in_lines;
        let key = ProgramKey {
            pipeline: Pipeline::Triangles { phong: smoothing != Smoothing::Pn, colored },
            shading,
            trims: TrimFeatures::NONE,
            output,
            cut_out: is_picture && !in_lines && mesh.paints.iter().any(Painted::has_holes),
            far_depth: frame.projection.depth_scale().is_some(),
        };
        self.program(key)?;
        let program = &self.programs[&key];
        program.bind();
        set_depth(program, frame.projection.depth_scale());
        let columns = matrices(&mesh.points_to_world(), &frame.projection);
        // Cross products turn with the triangle, normals stay outside.
        let sign = mesh.model.transform.determinant().signum() as f32;
        set_columns(program, &columns, sign);
        if let Smoothing::Phong(alpha) = smoothing {
            program.set_f32(location::ALPHA, alpha.get() as f32);
        }
        if is_picture {
            if shading == Shading::Phong {
                set_lights(program, frame);
            }
        } else {
            program.set_i32(location::FIRST_PATCH, first_patch as i32);
        }
        if output == Output::Aovs {
            set_for_aovs(program, frame, &Target::bound(&self.gl));
        }
        levels.bind(LEVELS_UNIT);
        self.set_state(3, frame.settings.wireframe);
        let array = match smoothing {
            Smoothing::None if mesh.model.mesh().mesh().coordinates().is_empty() => {
                &self.bare_array
            }
            Smoothing::None => &self.flat_array,
            _ => &self.corners_array,
        };
        array.bind(&mesh.corners);
        array.bind_colors(mesh.colors.as_ref().filter(|_| colored));
        let mut paint = None;
        for draw in &mesh.draws {
            if paint.replace(draw.paint) != Some(draw.paint) {
                let texture = &mesh.paints[draw.paint].texture;
                self.look(shading, texture, &frame.settings, output).1.bind(0);
            }
            let feedback = match kept {
                Some(_) => Some(
                    Feedback::begin(&self.gl, draw.triangles).inspect_err(|_| self.release())?,
                ),
                None => None,
            };
            // SAFETY: the context is current (see the type); the range lies within the buffer, whose
            // bytes fit an i32 since it was made.
            unsafe {
                let (first, count) = (3 * draw.first as i32, 3 * draw.count as i32);
                self.gl.draw_arrays(glow::PATCHES, first, count);
            }
            if let (Some(feedback), Some(kept)) = (feedback, kept.as_deref_mut()) {
                feedback.end(kept);
            }
        }
        self.release();
        Ok(())
    }
}
