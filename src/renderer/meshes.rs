//! Meshes, drawn as OpenGL patches of three vertices. The tessellation stages divide smooth
//! triangles; flat ones have level 1.

use std::mem::offset_of;
use std::rc::Rc;

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3};

use super::draw_list::matrices;
use super::draws::{Draw, PlanKey, divide};
use super::points::LocalFrame;
use super::uniforms::{analysis_of, set_analysis, set_aovs, set_columns, set_depth, set_lights};
use super::{DrawnVertex, Frame, Renderer, in_lines};
use crate::error::Result;
use crate::gpu::{Attribute, Buffer, Gl, TexelBuffer, Texture, Vertex};
use crate::mesh::{Corner, Smoothing};
use crate::programs::{LEVELS_UNIT, Output, Pipeline, ProgramKey, TrimFeatures, location};
use crate::scene::{
    Analysis, AnalysisKind, MeshModel, Paint, Shading, TessLevel, Tessellation, check_transform,
};
use crate::tessellation::{
    FrameStats, Rounding, Screen, Tessellated, TriangleBound, raise, triangles_of_triangle,
    vertices_of_triangle,
};

/// A corner of a flat triangle as `triangles/triangle.vert` reads it.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct FlatCorner {
    /// Position, centred and scaled; and the texture coordinate s.
    position: [f32; 4],
    /// Normal, and the texture coordinate t.
    normal: [f32; 4],
}

/// A corner of a flat triangle without texture coordinates.
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
    /// The normal at this corner that shapes the edge to the next corner.
    leaving: [f32; 3],
    /// The normal at this corner that shapes the edge from the corner before.
    arriving: [f32; 3],
}

impl Vertex for FlatCorner {
    const ATTRIBUTES: &'static [Attribute] = &[
        Attribute::floats(0, 4, offset_of!(Self, position)),
        Attribute::floats(1, 4, offset_of!(Self, normal)),
    ];
}

/// OpenGL sets the missing fourth components to 1.
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

/// The paint of consecutive triangles.
#[derive(Debug)]
struct Painted {
    /// The index after the last triangle; the first one follows the triangles of the paint before.
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
    /// The colour of each corner, if the mesh has colours.
    colors: Option<Buffer>,
    /// Control points of all triangles, 10 or 6 each; empty for flat ones.
    nets: Vec<DVec3>,
    key: Option<PlanKey>,
    /// For each triangle, the level that it needs regardless of its neighbours; 0 if it is out of
    /// view.
    needs: Vec<u8>,
    /// For each edge, the largest need of its triangles. Empty if all levels are equal.
    edges: Vec<u8>,
    /// For each triangle, the levels that it is drawn with.
    words: Vec<TriangleLevels>,
    /// The same in the driver's memory.
    levels: Option<TexelBuffer>,
    draws: Vec<Draw>,
    stats: FrameStats,
}

impl PreparedMesh {
    /// Uploads a mesh; `texture` returns the uploaded texture of a paint.
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
            key: None,
            needs: Vec::new(),
            edges: Vec::new(),
            words: Vec::new(),
            levels: None,
            draws: Vec::new(),
            stats: FrameStats::default(),
        })
    }

    /// Statistics of the last update.
    pub(crate) const fn stats(&self) -> FrameStats {
        self.stats
    }

    /// The matrix from the driver's points to world space.
    fn points_to_world(&self) -> DMat4 {
        self.model.transform * self.centering.to_model()
    }

    /// Brings levels and draws up to date with a frame.
    pub(crate) fn update(&mut self, renderer: &Renderer, frame: &Frame) -> Result<()> {
        let tessellation = match (self.model.smoothing(), self.model.level) {
            (Smoothing::None, _) => Tessellation::Level(TessLevel::ONE),
            (_, Some(level)) => Tessellation::Level(level),
            (_, None) => frame.settings.tessellation,
        };
        let key = PlanKey::new(frame, tessellation);
        if self.key == Some(key) {
            return Ok(());
        }
        // If the update fails, the next one starts again.
        self.key = None;
        self.find_levels(&key);
        match &self.levels {
            Some(levels) => levels.buffer().write(0, bytemuck::cast_slice::<_, u32>(&self.words)),
            None => {
                let words = bytemuck::cast_slice(&self.words);
                let levels = TexelBuffer::of_words(renderer.gl(), "levels of triangles", words);
                self.levels = Some(levels?);
            }
        }
        self.find_draws(renderer.draw_size().vertices());
        self.key = Some(key);
        Ok(())
    }

    /// Computes the levels of all triangles, and the statistics.
    fn find_levels(&mut self, key: &PlanKey) {
        let (tolerance, fixed) = match key.tessellation {
            Tessellation::Within(tolerance) => (tolerance.pixels(), None),
            Tessellation::Level(level) => (1.0, Some(level.get() as u8)),
        };
        let screen = Screen::new(&key.camera, key.size, tolerance);
        let view_to_clip = key.camera.projection * key.camera.view;
        let rounding = Rounding::new(&(view_to_clip * self.points_to_world()), 1.0);
        let to_clip = view_to_clip * self.model.transform;
        let mesh = self.model.mesh();
        let triangles = mesh.mesh().triangles().len();
        let mut stats = FrameStats { patches: triangles, ..FrameStats::default() };
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
        // With a fixed level, all edges have that level.
        self.edges.resize(if fixed.is_none() { mesh.edges() as usize } else { 0 }, 0);
        for triangle in 0..triangles {
            let bound = bound(triangle);
            let need = bound.map_or(0, |bound| fixed.unwrap_or_else(|| bound.level(&screen)));
            if let Some(bound) = bound {
                let error = bound.error(need, &screen);
                raise(&mut stats.largest_bound, error);
                if fixed.is_none() && error > screen.tolerance() {
                    raise(&mut stats.unmet, error);
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
            self.words.push(if drawn {
                TriangleLevels::new(edges, inside)
            } else {
                TriangleLevels(0)
            });
            stats.culled += usize::from(!drawn);
            stats.triangles += triangles_of_triangle(if drawn { inside } else { 0 });
        }
        self.stats = stats;
    }

    /// Divides the triangles of each paint into draws of the size that suits the driver.
    fn find_draws(&mut self, max_vertices: u32) {
        self.draws.clear();
        let mut first = 0;
        for (paint, Painted { end, .. }) in self.paints.iter().enumerate() {
            divide(&self.words[first..*end], first, paint, max_vertices, &mut self.draws);
            first = *end;
        }
        self.stats.draws = self.draws.len();
    }
}

/// The levels of a triangle as `triangles/triangle.tesc` reads them, 8 bits each: those of its
/// three edges, then that of its inside. All are 0 if it is not drawn.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(transparent)]
struct TriangleLevels(u32);

impl TriangleLevels {
    const fn new(edges: [u32; 3], inside: u32) -> Self {
        Self(edges[0] | edges[1] << 8 | edges[2] << 16 | inside << 24)
    }

    const fn inside(self) -> u32 {
        self.0 >> 24
    }
}

impl Tessellated for TriangleLevels {
    fn vertices(&self) -> u32 {
        if self.0 == 0 { 0 } else { vertices_of_triangle(self.inside()) }
    }

    fn triangles(&self) -> u64 {
        triangles_of_triangle(self.inside())
    }
}

impl Renderer {
    /// Draws a mesh with the levels of the last update. `first_patch` is the index of its first
    /// triangle among all patches of the scene.
    ///
    /// # Errors
    /// A shader that the driver rejects, or as [`Renderer::make_draws`].
    pub(crate) fn draw_mesh(
        &mut self,
        mesh: &PreparedMesh,
        frame: &Frame,
        output: Output,
        first_patch: usize,
        captured: Option<&mut Vec<DrawnVertex>>,
    ) -> Result<()> {
        let Some(levels) = &mesh.levels else { return Ok(()) };
        let smoothing = mesh.model.smoothing();
        let is_picture = output == Output::Picture;
        let in_lines = in_lines(&frame.settings, output);
        let shading = if in_lines { Shading::Unlit } else { mesh.model.shading };
        let lines = if in_lines { Some(self.color_texture(super::RED)?) } else { None };
        let colored = mesh.colors.is_some() && is_picture && !in_lines;
        // Meshes have no curvature to show.
        let is_shown = |shown: &Analysis| !is_picture || shown.kind() != AnalysisKind::Curvature;
        let analysis = analysis_of(&frame.settings, output).filter(is_shown);
        let colored = colored && analysis.is_none();
        let key = ProgramKey {
            pipeline: Pipeline::Triangles { phong: smoothing != Smoothing::Pn, colored },
            shading: if analysis.is_some() { Shading::Unlit } else { shading },
            analysis: analysis.map(|shown| shown.kind()),
            light: frame.settings.light,
            trims: TrimFeatures::NONE,
            output,
            cut_out: is_picture && !in_lines && mesh.paints.iter().any(Painted::has_holes),
            far_depth: frame.camera.depth_scale().is_some(),
        };
        let program = self.program(key)?;
        program.bind();
        set_depth(&program, frame);
        let columns = matrices(&mesh.points_to_world(), &frame.camera);
        // The cofactor matrix transforms cross products. If the transform mirrors, it reverses
        // normals; the sign makes them point outwards again.
        let sign = mesh.model.transform.determinant().signum() as f32;
        set_columns(&program, &columns, sign);
        if let Smoothing::Phong(alpha) = smoothing {
            program.set_f32(location::ALPHA, alpha.get() as f32);
        }
        if let Some(analysis) = analysis.filter(|_| is_picture) {
            set_analysis(&program, frame, &analysis, 1.0);
        } else if is_picture {
            if shading == Shading::Phong {
                set_lights(&program, frame);
            }
        } else {
            program.set_i32(location::FIRST_PATCH, first_patch as i32);
        }
        if output == Output::Aovs {
            set_aovs(&program, frame);
        }
        levels.bind(LEVELS_UNIT);
        self.set_state(frame, 3, frame.settings.wireframe);
        let array = match smoothing {
            Smoothing::None if mesh.model.mesh().mesh().coordinates().is_empty() => {
                &self.bare_array
            }
            Smoothing::None => &self.flat_array,
            _ => &self.corners_array,
        };
        array.bind(&mesh.corners);
        array.bind_colors(mesh.colors.as_ref().filter(|_| colored));
        let bind = |draw: &Draw, is_new: bool| {
            if is_new {
                lines.as_ref().unwrap_or(&mesh.paints[draw.batch].texture).bind(0);
            }
        };
        self.make_draws(&mesh.draws, 3, bind, captured)
    }
}
