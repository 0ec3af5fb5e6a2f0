//! What the strokes along shared edges cost, on CAD models: `cargo bench --bench joints`, or with files of your own
//! `cargo bench --bench joints -- part.step`.
//!
//! It prints medians of alternating measurements, ratios, and the limits under which they should stay.

mod turns;

use std::cell::Cell;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use freeform_surface::glam::DQuat;
use freeform_surface::{
    Backend, Camera, Frame, Framebuffer, Headless, LoadOptions, PreparedScene, Renderer, Scene,
};
use turns::{in_turns, line};

const SIZE: (u32, u32) = (1920, 1080);

/// The same scene without joints.
fn apart(scene: &Scene) -> Scene {
    let mut apart = scene.clone();
    apart.models.iter_mut().for_each(|model| model.joints = [].into());
    apart
}

/// The frame of a camera that goes around the scene a little further with each call.
fn turning(scene: &Scene) -> impl Fn() -> Frame {
    let aspect = f64::from(SIZE.0) / f64::from(SIZE.1);
    let camera = scene.camera.unwrap_or_else(|| scene.framed(aspect));
    let angle = Cell::new(0.0_f64);
    move || {
        angle.set(angle.get() + 0.01);
        let turn = DQuat::from_axis_angle(camera.up().normalize(), angle.get());
        let eye = camera.target() + turn * (camera.eye() - camera.target());
        let turned = Camera::new(eye, camera.target(), camera.up(), camera.lens());
        let seen = Scene { camera: turned.ok(), ..Scene::default() };
        let points = scene.surfaces.iter().flat_map(|surface| surface.world_points());
        let camera = seen.camera.unwrap_or(camera).projection(points, aspect);
        Frame::new(camera, SIZE, scene.settings)
    }
}

fn measure(name: &str, scene: &Scene, renderer: &mut Renderer) {
    let gl = renderer.gl().clone();
    let plain = apart(scene);
    let both = [scene, &plain].map(|scene| PreparedScene::new(renderer, scene).expect("it fits"));
    let [joined, apart] = both.map(std::cell::RefCell::new);
    let still = Frame::of(scene, SIZE);
    let (next, next_apart) = (turning(scene), turning(scene));
    let renderer = std::cell::RefCell::new(renderer);
    let draw = |scene: &std::cell::RefCell<PreparedScene>, frame: &Frame| {
        let mut renderer = renderer.borrow_mut();
        let _ = scene.borrow_mut().draw(*renderer, frame).expect("it draws");
        gl.finish();
    };
    let plan = |scene: &std::cell::RefCell<PreparedScene>, frame: &Frame| {
        scene.borrow_mut().prepare(*renderer.borrow_mut(), frame).expect("it fits");
    };
    let of_still = in_turns(&mut [&mut || draw(&joined, &still), &mut || draw(&apart, &still)]);
    let of_moving =
        in_turns(&mut [&mut || draw(&joined, &next()), &mut || draw(&apart, &next_apart())]);
    let of_plan =
        in_turns(&mut [&mut || plan(&joined, &next()), &mut || plan(&apart, &next_apart())]);
    let joints: usize = scene.models.iter().map(|model| model.joints.len()).sum();
    println!("\n{name}: {joints} joints of models");
    line("a still frame, ms", of_still[0], "");
    line("/ without strokes", of_still[0] / of_still[1], "at most 1.15");
    line("a frame of a turning camera, ms", of_moving[0], "");
    line("/ without strokes", of_moving[0] / of_moving[1], "at most 1.15");
    line("a new view on the CPU, ms", of_plan[0], "");
    line("of which strokes, ms", of_plan[0] - of_plan[1], "at most 3 for 10,000 edges");
}

fn main() {
    let context = Headless::new(Backend::Auto).expect("an OpenGL context");
    println!("{}, {}", context.info().renderer, context.info().version);
    let target = Framebuffer::new(context.gl(), SIZE.0, SIZE.1).expect("a picture");
    let mut renderer = Renderer::new(context.gl()).expect("a renderer");
    target.bind();
    let files: Vec<PathBuf> =
        std::env::args().skip(1).filter(|arg| !arg.starts_with("--")).map(PathBuf::from).collect();
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("resources/models");
    let own = ["flange", "bracket", "blade", "assembly"]
        .map(|name| models.join(name).with_extension("ffm"));
    for file in if files.is_empty() { own.to_vec() } else { files } {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let scene = Scene::load_with(&file, &LoadOptions::default()).expect("a model");
        measure(&name, &scene, &mut renderer);
    }
    // Many edges.
    let mut text = String::new();
    for i in 0..200 {
        let (x, y) = (i % 20, i / 20);
        let _ = write!(
            text,
            "[[model]]\nfile = \"flange.ffm\"\ntranslate = [{}.0, {}.0, 0.0]\n",
            200 * x,
            200 * y
        );
    }
    let scene = Scene::from_toml(&text, &models.join("flanges.toml")).expect("flanges");
    measure("200 flanges", &scene, &mut renderer);
}
