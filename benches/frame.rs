//! A frame of the thesis' scene, tessellated, against the same triangles as a static mesh through
//! the same fragment stage: `cargo bench --bench frame`.
//!
//! Criterion gives each case its time. The ratios at the end are taken apart from it, with the two
//! methods in turns and the median of each, because only that holds on a machine whose speed drifts.
#![allow(unsafe_code, reason = "the static mesh is drawn with OpenGL itself")]

use std::hint::black_box;
use std::sync::Arc;
use std::time::{Duration, Instant};

use criterion::Criterion;
use freeform_surface::gpu::{self, Framebuffer, Program, ShaderPart, Stage, StageKind, Texture};
use freeform_surface::reference::thesis_normal;
use freeform_surface::renderer::programs::location;
use freeform_surface::{
    Backend, Degree, Frame, Headless, Paint, PreparedScene, Renderer, Scene, Surface, TessLevel,
    Tessellation,
};
use glam::DVec4;
use glow::HasContext;

const SIDE: u32 = 1024;
const TURNS: usize = 25;

/// The thesis' scene, or a field of 8×8 such patches.
fn scene(patches: usize, level: u32, wireframe: bool) -> Scene {
    let mut scene = Scene::listing16();
    scene.settings.tessellation =
        Tessellation::Level(TessLevel::new(level.into()).expect("a level"));
    scene.settings.wireframe = wireframe;
    let single = scene.surfaces.remove(0);
    let side = patches.isqrt();
    let points: Vec<DVec4> = (0..patches)
        .flat_map(|patch| {
            let (x, z) = ((patch % side) as f64, (patch / side) as f64);
            single.control_points().iter().map(move |p| *p + DVec4::new(x, 0.0, -z, 0.0))
        })
        .collect();
    let mut surface = Surface::new(Degree::Cubic, points).expect("whole patches");
    surface.paint = single.paint;
    surface.trims = single.trims;
    surface.transform = single.transform;
    scene.surfaces.push(surface);
    scene
}

struct StaticMesh {
    gl: Arc<glow::Context>,
    vertex_array: glow::VertexArray,
    buffers: [glow::Buffer; 2],
    count: i32,
    program: Program,
    texture: Texture,
}

impl StaticMesh {
    fn new(gl: &Arc<glow::Context>, scene: &Scene) -> Self {
        let surface = &scene.surfaces[0];
        let level = scene.settings.tessellation.level().get() as usize;
        let mut vertices: Vec<[f32; 8]> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        for patch in surface.patches() {
            let first = vertices.len() as u32;
            for i in 0..(level + 1) * (level + 1) {
                let u = (i % (level + 1)) as f64 / level as f64;
                let v = (i / (level + 1)) as f64 / level as f64;
                let (p, n) = (patch.at(u, v).position, thesis_normal(&patch, u, v));
                vertices.push([p.x, p.y, p.z, u, n.x, n.y, n.z, v].map(|value| value as f32));
            }
            for cell in 0..level * level {
                let corner = first + (cell / level * (level + 1) + cell % level) as u32;
                let above = corner + level as u32 + 1;
                indices.extend([corner, corner + 1, above, corner + 1, above + 1, above]);
            }
        }
        let part = |file, text: &'static str| ShaderPart { file, text: text.into() };
        let stages = [
            Stage {
                kind: StageKind::Vertex,
                parts: vec![part("static_mesh.vert", include_str!("static_mesh.vert"))],
            },
            Stage {
                kind: StageKind::Fragment,
                parts: vec![
                    part("trim.glsl", include_str!("../glsl/thesis/trim.glsl")),
                    part("surface.frag", include_str!("../glsl/thesis/surface.frag")),
                ],
            },
        ];
        let program = Program::new(
            gl,
            "static mesh",
            &[("PHONG", 1), ("TRIMMED", 1), ("CIRCLES", 1)],
            &stages,
            &[],
        )
        .expect("it links");
        let Paint::Texture(image) = &surface.paint else { unreachable!("the scene has bricks") };
        let texture = Texture::new(gl, "bricks", image).expect("the bricks fit");
        // SAFETY: the context is current; the objects are new, filled and described as they are.
        unsafe {
            let vertex_array = gl.create_named_vertex_array().expect("a vertex array");
            let vertex_buffer = gl.create_named_buffer().expect("a buffer");
            let index_buffer = gl.create_named_buffer().expect("a buffer");
            let bytes = bytemuck::cast_slice(&vertices);
            gl.named_buffer_data_u8_slice(vertex_buffer, bytes, glow::STATIC_DRAW);
            let bytes = bytemuck::cast_slice(&indices);
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
            }
        }
    }

    fn draw(&self, renderer: &Renderer, scene: &Scene, frame: &Frame) {
        renderer.clear(frame.settings.background);
        self.program.bind();
        self.program.set_mat4(location::MODEL, &scene.surfaces[0].transform.as_mat4());
        self.program.set_mat4(location::VIEW, &frame.projection.view.as_mat4());
        self.program.set_mat4(location::PROJECTION, &frame.projection.projection.as_mat4());
        let circle = &scene.surfaces[0].trims.circles[0];
        self.program.set_i32(location::CIRC_BOOL, 1);
        self.program.set_vec2(location::TRIM_CENTER, circle.center.as_vec2());
        self.program.set_f32(location::TRIM_RADIUS, circle.radius as f32);
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

fn median(mut times: Vec<Duration>) -> Duration {
    times.sort_unstable();
    times[times.len() / 2]
}

fn main() {
    let mut criterion = Criterion::default().configure_from_args().sample_size(20);
    let context = Headless::new(Backend::Auto).expect("an OpenGL context");
    let gl = context.gl();
    let target = Framebuffer::new(gl, SIDE, SIDE).expect("a picture of the bench");
    let mut renderer = Renderer::new(gl).expect("a renderer");
    let mut ratios = Vec::new();
    println!("{}, {}", context.info().renderer, context.info().version);

    let levels = [1, 16, 32, 64].map(|level| (1, level));
    for (patches, level) in levels.into_iter().chain([(64, 64)]) {
        for wireframe in [false, true] {
            let scene = scene(patches, level, wireframe);
            let mut prepared = PreparedScene::new(&renderer, &scene).expect("it fits");
            let mesh = StaticMesh::new(gl, &scene);
            let frame =
                Frame { projection: scene.projection(SIDE, SIDE), settings: scene.settings };
            target.bind();
            let mut tessellated = || {
                prepared.draw(&mut renderer, &frame).expect("it draws");
                gpu::finish(gl);
            };
            let name = format!(
                "{patches} patches, level {level}, {}",
                if wireframe { "lines" } else { "filled" }
            );
            criterion.bench_function(&format!("tessellated: {name}"), |b| b.iter(&mut tessellated));
            let still = Renderer::new(gl).expect("a renderer");
            let mut static_mesh = || {
                mesh.draw(black_box(&still), &scene, &frame);
                gpu::finish(gl);
            };
            criterion.bench_function(&format!("static mesh: {name}"), |b| b.iter(&mut static_mesh));

            let mut times = [Vec::new(), Vec::new()];
            for _ in 0..TURNS {
                let start = Instant::now();
                tessellated();
                times[0].push(start.elapsed());
                let start = Instant::now();
                static_mesh();
                times[1].push(start.elapsed());
            }
            let [ours, floor] = times.map(median);
            ratios.push((name, ours, floor));
        }
    }
    criterion.final_summary();
    println!(
        "\n{:44} {:>12} {:>12} {:>7}",
        "in turns, medians", "tessellated", "static mesh", "ratio"
    );
    for (name, ours, floor) in ratios {
        let [ours, floor] = [ours, floor].map(|time| time.as_secs_f64() * 1e3);
        println!("{name:44} {ours:9.2} ms {floor:9.2} ms {:7.2}", ours / floor);
    }
}
