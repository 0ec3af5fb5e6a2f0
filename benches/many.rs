//! Thousands of surfaces in one scene, and surfaces of tens of thousands of patches: `cargo bench --bench many`.
//!
//! It prints medians of alternating measurements, ratios, memory, and the limits under which they should stay.

mod static_mesh;
mod turns;

use std::time::Instant;

use freeform_surface::glam::{DMat4, DVec2, DVec4, dvec2, dvec3};
use freeform_surface::inspect::StaticStyle;
use freeform_surface::inspect::programs::TrimFeatures;
use freeform_surface::{
    Backend, Degree, Frame, Framebuffer, Headless, Method, NurbsSurface, Paint, PreparedScene,
    Renderer, Scene, Segment, Shading, Surface, TrimLoop, default_control_points,
};
use turns::{in_turns, line};

const SIZE: (u32, u32) = (1920, 1080);

/// A hole of four cubics in the middle of the domain.
fn hole() -> TrimLoop {
    let corners = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)].map(|(x, y)| dvec2(x, y));
    let quarter = |i: usize| {
        let (from, to): (DVec2, DVec2) = (corners[i], corners[(i + 1) % 4]);
        let points = [from, from + 0.55 * to, to + 0.55 * from, to];
        Segment::Cubic(points.map(|point| DVec2::splat(0.5) + 0.25 * point))
    };
    TrimLoop::new((0..4).map(quarter).collect()).expect("a closed loop")
}

/// Bumps side by side, each a surface with its own place and colour.
fn bumps(count: usize, trimmed: bool) -> Scene {
    let mut points = default_control_points();
    for index in [5, 6, 9, 10] {
        points[index].y = 0.5;
    }
    let mut single = Surface::new(Degree::CUBIC, points).expect("one patch");
    if trimmed {
        single.trims.add_loop(hole()).expect("a loop");
    }
    let columns = (count as f64 * 16.0 / 9.0).sqrt().ceil() as usize;
    let surface = |i: usize| {
        let place = dvec3((i % columns) as f64, 0.0, -((i / columns) as f64));
        let mut surface = single.clone();
        surface.transform = DMat4::from_translation(1.1 * place);
        surface.paint = Paint::Color([0.3 + 0.5 * (i % 7) as f32 / 7.0, 0.6, 0.4]);
        surface
    };
    Scene { surfaces: (0..count).map(surface).collect(), ..Scene::default() }
}

/// A bicubic NURBS surface of `side` × `side` control points.
fn terrain(side: usize) -> NurbsSurface {
    let knots = |_| {
        let inner = (0..side - 2).map(|i| i as f64);
        let (first, last) = ([0.0; 3], [(side - 3) as f64; 3]);
        first.into_iter().chain(inner).chain(last).collect::<Vec<f64>>()
    };
    let point = |i: usize| {
        let (x, y) = ((i % side) as f64, (i / side) as f64);
        DVec4::new(x, y, 3.0 * (0.31 * x).sin() * (0.23 * y).cos(), 1.0)
    };
    let points = (0..side * side).map(point).collect();
    NurbsSurface::new(Degree::CUBIC, [0, 1].map(knots), points).expect("a surface")
}

/// The memory of this process, with that of the driver, in bytes. 0 where the system does not tell.
fn memory_in_use() -> f64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let resident = pages.split(' ').nth(1).and_then(|pages| pages.parse::<f64>().ok());
    resident.unwrap_or(0.0) * 4096.0
}

fn main() {
    let context = Headless::new(Backend::Auto).expect("an OpenGL context");
    let gl = context.gl();
    println!("{}, {}", context.info().renderer, context.info().version);
    let target = Framebuffer::new(gl, SIZE.0, SIZE.1).expect("a picture");
    let mut renderer = Renderer::new(gl).expect("a renderer");
    target.bind();

    for count in [1, 10, 100, 1_000, 10_000] {
        let scenes = [true, false].map(|trimmed| bumps(count, trimmed));
        let frame = Frame::of(&scenes[0], SIZE);
        let before = memory_in_use();
        let started = Instant::now();
        let mut trimmed = PreparedScene::new(&renderer, &scenes[0]).expect("it fits");
        trimmed.prepare(&renderer, &frame).expect("it fits");
        let start_ms = started.elapsed().as_secs_f64() * 1e3;
        let bytes = memory_in_use() - before;
        let mut plain = PreparedScene::new(&renderer, &scenes[1]).expect("it fits");
        let triangles = plain.triangles(&mut renderer, &frame).expect("they fit");
        let mesh = static_mesh::of_drawn(gl, &triangles, &frame.camera.view.inverse());
        let texture = Paint::default().upload(gl).expect("a texel");
        let style = StaticStyle {
            method: Method::Exact,
            shading: Shading::Phong,
            trims: TrimFeatures::NONE,
            texture: &texture,
        };
        let mut still = PreparedScene::new(&renderer, &scenes[0]).expect("it fits");
        still.prepare(&renderer, &frame).expect("it fits");
        let shared = std::cell::RefCell::new(&mut renderer);
        let draw = |scene: &mut PreparedScene| {
            let _ = scene.draw(*shared.borrow_mut(), &frame).expect("it draws");
            gl.finish();
        };
        let mut cut = || draw(&mut trimmed);
        let mut whole = || draw(&mut plain);
        let mut fixed = || {
            let renderer = &mut *shared.borrow_mut();
            renderer.clear([0.0; 4]);
            renderer.draw_static(&mesh, &style, &frame).expect("it draws");
            gl.finish();
        };
        let mut cpu = || still.prepare(*shared.borrow_mut(), &frame).expect("it fits");
        let ms = in_turns(&mut [&mut cut, &mut whole, &mut fixed, &mut cpu]);
        let (stats, plain_stats) = (trimmed.stats(), plain.stats());
        println!("\n{count} surfaces, one hole of 4 segments each");
        line("until all is uploaded, ms", start_ms, "");
        // 16 control points and 4 segments each.
        line("bytes a point or segment", bytes / (20 * count) as f64, "at most 200 for 10,000");
        line("a frame, ms", ms[0], "");
        line("/ the same without trims", ms[0] / ms[1], "at most 1.4 for 10,000");
        line("draws", stats.draws as f64, "at most 60 for 10,000");
        line("draws without trims", plain_stats.draws as f64, "");
        line("/ one static mesh of the same triangles", ms[0] / ms[2], "at most 2.5 for 10,000");
        line("without trims / static mesh", ms[1] / ms[2], "");
        line("a still view on the CPU, ms", ms[3], "at most 1");
    }

    for side in [30, 100, 300] {
        let before = memory_in_use();
        let started = Instant::now();
        let surface = Surface::from_nurbs(terrain(side));
        let scene = Scene { surfaces: vec![surface], ..Scene::default() };
        let patches_ms = started.elapsed().as_secs_f64() * 1e3;
        let frame = Frame::of(&scene, SIZE);
        let started = Instant::now();
        let mut prepared = PreparedScene::new(&renderer, &scene).expect("it fits");
        let upload_ms = started.elapsed().as_secs_f64() * 1e3;
        let started = Instant::now();
        prepared.prepare(&renderer, &frame).expect("it fits");
        let plan_ms = started.elapsed().as_secs_f64() * 1e3;
        let bytes = memory_in_use() - before;
        let points = scene.surfaces[0].patch_points().len();
        println!("\nA bicubic NURBS surface of {side} × {side} points");
        line("bytes a point of its patches", bytes / points as f64, "at most 200 for 300");
        line("its patches, ms", patches_ms, "");
        line("uploaded, ms", upload_ms, "");
        line("planned, ms", plan_ms, "");
        line(
            "all until the first draw, ms",
            patches_ms + upload_ms + plan_ms,
            "at most 400 for 300",
        );
    }
}
