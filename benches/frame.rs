//! A frame of the thesis' scene, tessellated, compared with the same triangles as a static mesh and with the
//! same fragment shader: `cargo bench --bench frame`.
//!
//! Criterion reports the time of each case. The ratios at the end are measured separately: the two methods
//! alternate, and the median of each is taken. Only that is reliable on a machine whose speed drifts.

mod static_mesh;

use std::hint::black_box;
use std::time::{Duration, Instant};

use criterion::Criterion;
use freeform_surface::inspect::StaticStyle;
use freeform_surface::inspect::programs::{Output, TrimFeatures, location};
use freeform_surface::inspect::reference::thesis_normal;
use freeform_surface::{
    Backend, Degree, Frame, Framebuffer, Headless, Method, PreparedScene, Renderer, Scene, Shading,
    Surface, TessLevel, Tessellation,
};
use glam::DVec4;

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
    let mut surface = Surface::new(Degree::CUBIC, points).expect("whole patches");
    surface.paint = single.paint;
    surface.trims = single.trims;
    surface.transform = single.transform;
    scene.surfaces.push(surface);
    scene
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
            let mesh = static_mesh::of_surface(gl, &scene, thesis_normal);
            let surface = &scene.surfaces[0];
            let texture = surface.paint.upload(gl).expect("the picture fits");
            let style = StaticStyle {
                method: Method::Thesis,
                shading: Shading::Phong,
                trims: TrimFeatures { circles: true, ..TrimFeatures::NONE },
                texture: &texture,
            };
            let frame = Frame::of(&scene, (SIDE, SIDE));
            target.bind();
            let mut tessellated = || {
                let _ = prepared.draw(&mut renderer, &frame).expect("it draws");
                gl.finish();
            };
            let name = format!(
                "{patches} patches, level {level}, {}",
                if wireframe { "lines" } else { "filled" }
            );
            criterion.bench_function(&format!("tessellated: {name}"), |b| b.iter(&mut tessellated));
            let mut still = Renderer::new(gl).expect("a renderer");
            let circle = surface.trims.circles[0];
            let program = still
                .program(style.key(frame.settings.light, None, Output::Picture, false))
                .expect("it links");
            program.set_i32(location::CIRC_BOOL, 1);
            program.set_vec2(location::TRIM_CENTER, circle.center.as_vec2());
            program.set_f32(location::TRIM_RADIUS, circle.radius as f32);
            let mut static_mesh = || {
                still.clear(frame.settings.background);
                still.draw_static(black_box(&mesh), &style, &frame).expect("it draws");
                gl.finish();
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
