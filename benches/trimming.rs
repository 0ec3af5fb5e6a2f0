//! The cost of trims: the exact method and Newton's, compared with the same surface without trims. All are
//! measured in one run and alternately, because machines are noisy. Also the cost of building the grid.
//!
//! `cargo bench --bench trimming` prints medians, ratios and the limits under which they should stay.

mod turns;

use std::hint::black_box;

use freeform_surface::inspect::TrimGrid;
use freeform_surface::{
    Backend, Frame, Framebuffer, FreeFormSurface, Gl, Headless, Method, PreparedScene,
    RenderSettings, Renderer, Scene, Segment, TrimLoop, Trims,
};
use glam::{DVec2, dvec2};
use turns::{in_turns, line};

const SIDE: u32 = 1024;

const FILLING: &str = r#"
camera = { eye = [0, 2, 0], target = [0, 0, 0], up = [0, 0, -1], orthographic_height = 1 }
surface = [{ control_points = "default", texture = "resources/textures/brick.png" }]
"#;

/// A hole of two quarter turns above and two below: four cubics.
fn hole(center: DVec2, radius: f64) -> TrimLoop {
    let arm = 0.552_284_749_831;
    let corner = |angle: i32| match angle.rem_euclid(4) {
        0 => dvec2(1.0, 0.0),
        1 => dvec2(0.0, 1.0),
        2 => dvec2(-1.0, 0.0),
        _ => dvec2(0.0, -1.0),
    };
    let place = |p: DVec2| center + p * radius;
    let quarter = |i: i32| {
        let (from, to) = (corner(i), corner(i + 1));
        Segment::Cubic([from, from + to * arm, to + from * arm, to].map(place))
    };
    TrimLoop::new((0..4).map(quarter).collect()).expect("a closed loop")
}

/// `count` cubics as holes in rows, over a square of the domain.
fn lace(count: usize, min: DVec2, side: f64) -> Vec<TrimLoop> {
    let holes = count / 4;
    let columns = (holes as f64).sqrt().ceil() as usize;
    let step = side / columns as f64;
    (0..holes)
        .map(|i| {
            let cell = dvec2((i % columns) as f64, (i / columns) as f64) + 0.5;
            hole(min + cell * step, 0.35 * step)
        })
        .collect()
}

/// One loop of cubics between points all over the domain.
fn scribble(count: usize) -> TrimLoop {
    let point = |i: usize| {
        let i = (i % (3 * count)) as f64;
        dvec2((i * 0.618_034).fract(), (i * 0.754_878).fract())
    };
    let cubic = |i: usize| Segment::Cubic([0, 1, 2, 3].map(|k| point(3 * i + k)));
    TrimLoop::new((0..count).map(cubic).collect()).expect("a closed loop")
}

fn trims(loops: Vec<TrimLoop>) -> Trims {
    Trims { loops, ..Trims::default() }
}

fn timed(mut work: impl FnMut()) -> f64 {
    in_turns(&mut [&mut work])[0]
}

fn main() {
    let context = Headless::new(Backend::Auto).expect("an OpenGL context");
    let gl = context.gl();
    println!("{}, {}\n", context.info().renderer, context.info().version);
    frames(gl);
    building(gl);
    many_surfaces(gl);
}

/// Whole frames of the thesis' surface with its own and with many more trims.
fn frames(gl: &Gl) {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let figure =
        Scene::load(&root.join("resources/scenes/thesis/fig24.toml")).expect("the figure's scene");
    let target = Framebuffer::new(gl, SIDE, SIDE).expect("a picture of the bench");
    target.bind();
    let with = |trims: Trims, method: Method| {
        let mut scene = figure.clone();
        scene.settings.method = method;
        scene.surfaces[0].trims = trims;
        scene
    };
    let own = figure.surfaces[0].trims.clone();
    // A patch that fills the picture, for many trims.
    let filling = |loops: Vec<TrimLoop>| {
        let mut scene = Scene::from_toml(FILLING, "filling.toml".as_ref()).expect("a scene");
        scene.surfaces[0].trims = trims(loops);
        scene
    };
    let scenes = [
        with(Trims::default(), Method::Exact),
        with(own.clone(), Method::Exact),
        with(Trims::default(), Method::Thesis),
        with(own, Method::Thesis),
        filling(Vec::new()),
        filling(lace(10_000, DVec2::ZERO, 1.0)),
        filling(lace(10_000, dvec2(0.45, 0.45), 0.1)),
        filling(lace(100_000, DVec2::ZERO, 1.0)),
    ];
    let mut drawn: Vec<_> = scenes
        .iter()
        .map(|scene| {
            let mut renderer = Renderer::new(gl).expect("a renderer");
            let mut prepared = PreparedScene::new(&renderer, scene).expect("it fits");
            let frame = Frame::of(scene, (SIDE, SIDE));
            move || {
                let _ = prepared.draw(&mut renderer, &frame).expect("it draws");
                gl.finish();
            }
        })
        .collect();
    let mut frames: Vec<&mut dyn FnMut()> =
        drawn.iter_mut().map(|frame| frame as &mut dyn FnMut()).collect();
    let ms = in_turns(&mut frames);
    let (untrimmed, exact) = (ms[0], ms[1]);
    line("figure 24, untrimmed, ms", untrimmed, "");
    line("figure 24, exact, ms", exact, "");
    line("figure 24, Newton, ms", ms[3], "");
    line("figure 24: exact / untrimmed", exact / untrimmed, "≤ 1.15");
    let newton_cost = ms[3] - ms[2];
    let exact_cost = (exact - untrimmed).max(0.02 * exact);
    line("figure 24: what Newton adds / what exact adds", newton_cost / exact_cost, "≥ 10");
    line("a patch that fills the picture, untrimmed, ms", ms[4], "");
    line("10,000 cubics spread / untrimmed", ms[5] / ms[4], "≤ 1.8");
    line("10,000 cubics in 1 % of the domain / untrimmed", ms[6] / ms[4], "≤ 1.5");
    line("100,000 cubics spread / untrimmed", ms[7] / ms[4], "");
}

/// Building the grid, and its upload.
fn building(gl: &Gl) {
    println!();
    for count in [100, 1_000, 10_000, 100_000] {
        let trims = trims(lace(count, DVec2::ZERO, 1.0));
        let ms = timed(|| drop(black_box(TrimGrid::new(black_box(&trims)))));
        let bytes = 4 * TrimGrid::new(&trims).words().len();
        let bar = if count == 10_000 { "≤ 30" } else { "" };
        line(&format!("grid of {count} cubics, ms"), ms, bar);
        let bar = if count == 10_000 { "≤ 200" } else { "" };
        line("  bytes a cubic", bytes as f64 / count as f64, bar);
    }
    for count in [100, 1_000, 10_000] {
        let trims = trims(vec![scribble(count)]);
        let ms = timed(|| drop(black_box(TrimGrid::new(black_box(&trims)))));
        line(&format!("grid of one loop of {count} long cubics, ms"), ms, "");
    }
    let renderer = Renderer::new(gl).expect("a renderer");
    let mut surface = FreeFormSurface::new(&renderer).expect("a surface");
    let settings = RenderSettings::default();
    let mut at = 0.3;
    let ms = timed(|| {
        at = 1.0 - at;
        surface.clear_trims();
        surface.add_trim_loop(hole(dvec2(at, 0.5), 0.2)).expect("a loop");
        surface.prepare(&renderer, &settings).expect("it fits");
        gl.finish();
    });
    line("one loop of 4 segments changed: rebuild and upload, ms", ms, "≤ 0.2");
}

/// Many surfaces with few trims each.
fn many_surfaces(gl: &Gl) {
    println!();
    let target = Framebuffer::new(gl, SIDE, SIDE).expect("a picture of the bench");
    target.bind();
    for count in [1, 10, 100, 1_000] {
        let side = f64::from(count).sqrt().ceil();
        let mut scene = Scene::listing16();
        let mut surface = scene.surfaces.remove(0);
        surface.trims = trims(lace(8, dvec2(0.1, 0.1), 0.8));
        for i in 0..count {
            let place = dvec2(f64::from(i) % side, (f64::from(i) / side).floor());
            surface.transform =
                glam::DMat4::from_translation(glam::dvec3(place.x - side / 2.0, 0.0, -place.y));
            scene.surfaces.push(surface.clone());
        }
        let mut renderer = Renderer::new(gl).expect("a renderer");
        let mut prepared = PreparedScene::new(&renderer, &scene).expect("it fits");
        let frame = Frame::of(&scene, (SIDE, SIDE));
        let ms = timed(|| {
            let _ = prepared.draw(&mut renderer, &frame).expect("it draws");
            gl.finish();
        });
        line(&format!("{count} surfaces of 8 segments, ms a frame"), ms, "");
    }
}
