//! What tessellation is measured against: the same triangles, computed beforehand.
#![allow(dead_code, unreachable_pub, reason = "every bench is a crate that uses a part of it")]
#![allow(unsafe_code, reason = "the mesh is drawn with OpenGL itself")]

use std::collections::HashMap;
use std::sync::Arc;

use freeform_surface::gpu::{Program, ShaderPart, Stage, StageKind, Texture};
use freeform_surface::renderer::programs::location;
use freeform_surface::{Circle, Frame, Image, Mesh, Paint, Patch, Renderer, Scene};
use glam::{DVec3, Mat4};
use glow::HasContext;

/// Triangles with positions, u, normals and v at their corners.
pub struct StaticMesh {
    gl: Arc<glow::Context>,
    vertex_array: glow::VertexArray,
    buffers: [glow::Buffer; 2],
    count: i32,
    program: Program,
    texture: Texture,
    transform: Mat4,
    circle: Option<Circle>,
}

/// The triangles of a mesh, one vertex for each pair of position and normal.
fn indexed(mesh: &Mesh) -> (Vec<[f32; 8]>, Vec<u32>) {
    let mut numbers = HashMap::new();
    let (mut vertices, mut indices) = (Vec::new(), Vec::new());
    for corner in mesh.triangles().iter().flatten() {
        indices.push(*numbers.entry((corner.position, corner.normal)).or_insert_with(|| {
            let p = mesh.positions()[corner.position as usize];
            let n = mesh.normals()[corner.normal as usize];
            vertices.push([p.x, p.y, p.z, 0.0, n.x, n.y, n.z, 0.0].map(|value| value as f32));
            vertices.len() as u32 - 1
        }));
    }
    (vertices, indices)
}

impl StaticMesh {
    /// The triangles of a scene's one surface at its level, its normals by `normal`, drawn with these
    /// parts of a fragment stage.
    pub fn new(
        gl: &Arc<glow::Context>,
        scene: &Scene,
        normal: fn(&Patch<'_>, f64, f64) -> DVec3,
        defines: &[(&str, u32)],
        fragment: &[(&'static str, &'static str)],
    ) -> Self {
        let surface = &scene.surfaces[0];
        let level = scene.settings.tessellation.level().get() as usize;
        let mut vertices: Vec<[f32; 8]> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        for patch in surface.patches() {
            let first = vertices.len() as u32;
            for i in 0..(level + 1) * (level + 1) {
                let u = (i % (level + 1)) as f64 / level as f64;
                let v = (i / (level + 1)) as f64 / level as f64;
                let (p, n) = (patch.at(u, v).position, normal(&patch, u, v));
                vertices.push([p.x, p.y, p.z, u, n.x, n.y, n.z, v].map(|value| value as f32));
            }
            for cell in 0..level * level {
                let corner = first + (cell / level * (level + 1) + cell % level) as u32;
                let above = corner + level as u32 + 1;
                indices.extend([corner, corner + 1, above, corner + 1, above + 1, above]);
            }
        }
        let Paint::Texture(image) = &surface.paint else { unreachable!("the scene has bricks") };
        let mut made = Self::of(gl, (&vertices, &indices), image, defines, fragment);
        made.transform = surface.transform.as_mat4();
        made.circle = surface.trims.circles.first().copied();
        made
    }

    /// A mesh in one colour.
    pub fn of_mesh(
        gl: &Arc<glow::Context>,
        mesh: &Mesh,
        color: image::Rgba<u8>,
        defines: &[(&str, u32)],
        fragment: &[(&'static str, &'static str)],
    ) -> Self {
        let (vertices, indices) = indexed(mesh);
        let image = Image::from_pixel(1, 1, color);
        Self::of(gl, (&vertices, &indices), &image, defines, fragment)
    }

    fn of(
        gl: &Arc<glow::Context>,
        (vertices, indices): (&[[f32; 8]], &[u32]),
        image: &Image,
        defines: &[(&str, u32)],
        fragment: &[(&'static str, &'static str)],
    ) -> Self {
        let part = |file, text: &'static str| ShaderPart { file, text: text.into() };
        let stages = [
            Stage {
                kind: StageKind::Vertex,
                parts: vec![part("static_mesh.vert", include_str!("static_mesh.vert"))],
            },
            Stage {
                kind: StageKind::Fragment,
                parts: fragment.iter().map(|(file, text)| part(file, text)).collect(),
            },
        ];
        let program = Program::new(gl, "static mesh", defines, &stages, &[]).expect("it links");
        let texture = Texture::new(gl, "picture", image).expect("the picture fits");
        // SAFETY: the context is current; the objects are new, filled and described as they are.
        unsafe {
            let vertex_array = gl.create_named_vertex_array().expect("a vertex array");
            let vertex_buffer = gl.create_named_buffer().expect("a buffer");
            let index_buffer = gl.create_named_buffer().expect("a buffer");
            let bytes = bytemuck::cast_slice(vertices);
            gl.named_buffer_data_u8_slice(vertex_buffer, bytes, glow::STATIC_DRAW);
            let bytes = bytemuck::cast_slice(indices);
            gl.named_buffer_data_u8_slice(index_buffer, bytes, glow::STATIC_DRAW);
            gl.vertex_array_vertex_buffer(vertex_array, 0, Some(vertex_buffer), 0, 32);
            gl.vertex_array_element_buffer(vertex_array, Some(index_buffer));
            for (attribute, offset) in [(0, 0), (1, 16)] {
                gl.enable_vertex_array_attrib(vertex_array, attribute);
                gl.vertex_array_attrib_format_f32(
                    vertex_array,
                    attribute,
                    4,
                    glow::FLOAT,
                    false,
                    offset,
                );
                gl.vertex_array_attrib_binding_f32(vertex_array, attribute, 0);
            }
            Self {
                gl: Arc::clone(gl),
                vertex_array,
                buffers: [vertex_buffer, index_buffer],
                count: indices.len() as i32,
                program,
                texture,
                transform: Mat4::IDENTITY,
                circle: None,
            }
        }
    }

    /// Draws it, after clearing.
    pub fn draw(&self, renderer: &Renderer, frame: &Frame) {
        renderer.clear(frame.settings.background);
        self.program.bind();
        self.program.set_mat4(location::MODEL, &self.transform);
        self.program.set_mat4(location::VIEW, &frame.projection.view.as_mat4());
        self.program.set_mat4(location::PROJECTION, &frame.projection.projection.as_mat4());
        if let Some(circle) = &self.circle {
            self.program.set_i32(location::CIRC_BOOL, 1);
            self.program.set_vec2(location::TRIM_CENTER, circle.center.as_vec2());
            self.program.set_f32(location::TRIM_RADIUS, circle.radius as f32);
        }
        self.texture.bind(0);
        let mode = if frame.settings.wireframe { glow::LINE } else { glow::FILL };
        // SAFETY: the context is current; the element buffer holds `count` indices of vertices.
        unsafe {
            self.gl.enable(glow::DEPTH_TEST);
            self.gl.polygon_mode(glow::FRONT_AND_BACK, mode);
            self.gl.bind_vertex_array(Some(self.vertex_array));
            self.gl.draw_elements(glow::TRIANGLES, self.count, glow::UNSIGNED_INT, 0);
            self.gl.bind_vertex_array(None);
            self.gl.polygon_mode(glow::FRONT_AND_BACK, glow::FILL);
        }
    }
}

impl Drop for StaticMesh {
    fn drop(&mut self) {
        // SAFETY: the context is current; nothing else owns the three objects.
        unsafe {
            self.gl.delete_vertex_array(self.vertex_array);
            for buffer in self.buffers {
                self.gl.delete_buffer(buffer);
            }
        }
    }
}
