//! The cost of tessellation, compared with static meshes of the same triangles; the cost within a tolerance,
//! compared with one level for all patches; and the pass over the patches that a moving camera needs. All are
//! measured in one run and alternately, because machines are noisy.
//!
//! `cargo bench --bench tessellation` prints medians, ratios and the limits under which they should stay; names
//! after `--` select sections: static, degrees, teapot, normals, moving, sight, cut, memory.

mod static_mesh;
mod turns;

use freeform_surface::inspect::StaticStyle;
use freeform_surface::inspect::programs::TrimFeatures;
use freeform_surface::{
    Backend, Camera, Degree, Frame, Framebuffer, Gl, Headless, Lens, Method, Normals, Patch,
    PreparedScene, Rect, Renderer, Scene, Shading, Surface, TessLevel, Tessellation, Tolerance,
};
use glam::{DVec3, DVec4, dvec2, dvec3};
use turns::{in_turns, line};

const SIDE: u32 = 1024;
/// Triangles of the largest static mesh.
const MAX_TRIANGLES: usize = 2_000_000;

/// The normal Sv × Su, with v first as in the thesis.
fn exact_normal(patch: &Patch<'_>, u: f64, v: f64) -> DVec3 {
    -patch.normal(u, v).unwrap_or(DVec3::Y)
}

fn level(level: u32) -> Tessellation {
    Tessellation::Level(TessLevel::new(level.into()).expect("a level of the bench"))
}

fn within(pixels: f64) -> Tessellation {
    Tessellation::Within(Tolerance::new(pixels).expect("a tolerance of the bench"))
}

/// Measures something and prints it.
type Section = fn(&Gl);

/// A field of `patches` patches like that of listing 16, seen from above.
fn field(patches: usize) -> Scene {
    let mut scene = Scene::listing16();
    let single = scene.surfaces.remove(0);
    let side = (patches as f64).sqrt().ceil() as usize;
    let points: Vec<DVec4> = (0..patches)
        .flat_map(|patch| {
            let (x, z) = ((patch % side) as f64, (patch / side) as f64);
            single.control_points().iter().map(move |p| *p + DVec4::new(x, 0.0, -z, 0.0))
        })
        .collect();
    let mut surface = Surface::new(Degree::CUBIC, points).expect("whole patches");
    surface.paint = single.paint;
    scene.surfaces.push(surface);
    scene
}

/// A scene in the driver's memory that is drawn again and again.
struct Drawn<'a> {
    gl: &'a Gl,
    renderer: Renderer,
    prepared: PreparedScene,
    frame: Frame,
}

impl<'a> Drawn<'a> {
    fn new(gl: &'a Gl, scene: &Scene, (width, height): (u32, u32)) -> Self {
        let renderer = Renderer::new(gl).expect("a renderer");
        let prepared = PreparedScene::new(&renderer, scene).expect("it fits");
        let frame = Frame::of(scene, (width, height));
        Self { gl, renderer, prepared, frame }
    }

    fn draw(&mut self) {
        let _ = self.prepared.draw(&mut self.renderer, &self.frame).expect("it draws");
        self.gl.finish();
    }

    fn triangles(&mut self) -> u64 {
        self.draw();
        self.prepared.stats().triangles
    }
}

fn main() {
    let context = Headless::new(Backend::Auto).expect("an OpenGL context");
    let gl = context.gl();
    println!("{}, {}\n", context.info().renderer, context.info().version);
    let asked: Vec<String> = std::env::args().skip(1).filter(|name| name != "--bench").collect();
    let sections: [(&str, Section); 8] = [
        ("static", static_meshes),
        ("degrees", degrees),
        ("teapot", teapot),
        ("normals", normals),
        ("moving", moving),
        ("sight", out_of_sight),
        ("cut", cut_away),
        ("memory", memory),
    ];
    for (name, section) in sections {
        if asked.is_empty() || asked.iter().any(|asked| asked == name) {
            section(gl);
        }
    }
}

/// One level for all patches, compared with a static mesh of the same triangles.
fn static_meshes(gl: &Gl) {
    let target = Framebuffer::new(gl, SIDE, SIDE).expect("a picture of the bench");
    for patches in [1, 64, 1024, 10_000] {
        for cells in [1, 4, 8, 16, 32, 64] {
            if 2 * patches * (cells * cells) as usize > MAX_TRIANGLES {
                continue;
            }
            let mut scene = field(patches);
            scene.settings.tessellation = level(cells);
            target.bind();
            let mut ours = Drawn::new(gl, &scene, (SIDE, SIDE));
            let mesh = static_mesh::of_surface(gl, &scene, exact_normal);
            let texture = scene.surfaces[0].paint.upload(gl).expect("the picture fits");
            let style = StaticStyle {
                method: Method::Exact,
                shading: Shading::Phong,
                trims: TrimFeatures::NONE,
                texture: &texture,
            };
            let frame = ours.frame;
            let mut still = Renderer::new(gl).expect("a renderer");
            let ms = in_turns(&mut [&mut || ours.draw(), &mut || {
                still.clear(frame.settings.background);
                still.draw_static(&mesh, &style, &frame).expect("it draws");
                gl.finish();
            }]);
            let bar = if cells >= 8 { "≤ 1.3" } else { "≤ 1.8" };
            let what =
                format!("{patches} patches at level {cells} ({:.2} ms) / static mesh", ms[0]);
            line(&what, ms[0] / ms[1], bar);
        }
    }
}

/// Patches of several degrees with the same triangles, compared with 4×4 control points.
fn degrees(gl: &Gl) {
    println!();
    let target = Framebuffer::new(gl, SIDE, SIDE).expect("a picture of the bench");
    target.bind();
    const PATCHES: usize = 32;
    let field_of = |u: usize, v: usize| {
        let degree = Degree::new(u, v).expect("a degree");
        let points = (0..PATCHES * PATCHES).flat_map(|patch| {
            (0..degree.points()).map(move |i| {
                let x = (i % (u + 1)) as f64 / u as f64 + (patch % PATCHES) as f64;
                let z = (i / (u + 1)) as f64 / v as f64 + (patch / PATCHES) as f64;
                DVec4::new(x, 0.2 * (2.0 * x).sin() * (2.0 * z).cos(), -z, 1.0)
            })
        });
        let mut scene = Scene::listing16();
        scene.surfaces = vec![Surface::new(degree, points.collect()).expect("whole patches")];
        scene.settings.tessellation = Tessellation::Level(TessLevel::new(16).expect("a level"));
        scene.camera = Some(scene.framed(1.0));
        Drawn::new(gl, &scene, (SIDE, SIDE))
    };
    let mut cubic = field_of(3, 3);
    for (u, v, bar) in
        [(1, 1, "≤ 1.0"), (2, 1, "≤ 1.0"), (2, 2, ""), (5, 5, ""), (8, 8, "≤ 2.5"), (15, 15, "")]
    {
        let mut other = field_of(u, v);
        let ms = in_turns(&mut [&mut || other.draw(), &mut || cubic.draw()]);
        let what = format!("1024 patches of degrees ({u}, {v}) ({:.2} ms) / (3, 3)", ms[0]);
        line(&what, ms[0] / ms[1], bar);
    }
}

/// The teapot, entirely within the picture.
fn teapot_scene() -> Scene {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    Scene::load(&root.join("resources/scenes/gallery/teapot.toml")).expect("the teapot's file")
}

/// Levels by tolerance, compared with the one level that is sufficient everywhere.
fn teapot(gl: &Gl) {
    println!();
    let size = (1920, 1080);
    let target = Framebuffer::new(gl, size.0, size.1).expect("a picture of the bench");
    target.bind();
    let mut scene = teapot_scene();
    scene.settings.tessellation = within(0.5);
    let mut adaptive = Drawn::new(gl, &scene, size);
    let triangles = adaptive.triangles();
    // The minimum level whose bound is within the tolerance, as for the adaptive levels.
    let enough = (1..=64).find(|cells| {
        scene.settings.tessellation = level(*cells);
        let mut drawn = Drawn::new(gl, &scene, size);
        drawn.draw();
        drawn.prepared.stats().largest_bound.is_some_and(|bound| bound <= 0.5)
    });
    let enough = enough.unwrap_or(64);
    scene.settings.tessellation = level(enough);
    let mut uniform = Drawn::new(gl, &scene, size);
    let ms = in_turns(&mut [&mut || adaptive.draw(), &mut || uniform.draw()]);
    line("teapot at 0.5 px, 1920×1080: triangles", triangles as f64, "≤ 45,000");
    line(
        &format!("  level that is enough everywhere: {enough}, triangles"),
        uniform.triangles() as f64,
        "",
    );
    line("  ms at 0.5 px", ms[0], "");
    line("  0.5 px / that level", ms[0] / ms[1], "≤ 0.6");
}

/// Normals per pixel, compared with normals per vertex.
fn normals(gl: &Gl) {
    println!();
    let target = Framebuffer::new(gl, SIDE, SIDE).expect("a picture of the bench");
    target.bind();
    for (name, mut scene) in [("teapot", teapot_scene()), ("listing 16", field(1))] {
        let mut vertex = Drawn::new(gl, &scene, (SIDE, SIDE));
        scene.settings.normals = Normals::Pixel;
        let mut pixel = Drawn::new(gl, &scene, (SIDE, SIDE));
        let ms = in_turns(&mut [&mut || vertex.draw(), &mut || pixel.draw()]);
        line(
            &format!("{name}: normals at pixels / at vertices"),
            ms[1] / ms[0],
            "default if < 1.15",
        );
    }
}

/// The pass over all patches that a camera motion needs.
fn moving(gl: &Gl) {
    println!();
    let target = Framebuffer::new(gl, 64, 64).expect("a picture of the bench");
    target.bind();
    for patches in [100, 1_000, 10_000, 100_000] {
        let mut scene = field(patches);
        scene.settings.tessellation = within(0.5);
        let mut drawn = Drawn::new(gl, &scene, (64, 64));
        // The pass alone, without drawing: two views alternate, so that each one is new.
        let views = [drawn.frame, {
            let mut other = drawn.frame;
            other.camera.view =
                glam::DMat4::from_translation(dvec3(0.001, 0.0, 0.0)) * other.camera.view;
            other
        }];
        let mut turn = 0;
        let ms = in_turns(&mut [&mut || {
            turn += 1;
            drawn.prepared.prepare(&drawn.renderer, &views[turn % 2]).expect("it fits");
        }]);
        let bar = if patches == 10_000 { "≤ 3" } else { "" };
        line(&format!("{patches} patches, a new view: level, cull and batch pass, ms"), ms[0], bar);
    }
}

/// Patches outside the view.
fn out_of_sight(gl: &Gl) {
    println!();
    let target = Framebuffer::new(gl, SIDE, SIDE).expect("a picture of the bench");
    target.bind();
    let mut all = field(10_000);
    all.settings.tessellation = within(0.5);
    // From above, with a corner of 22 × 22 of the 100 × 100 patches in view.
    let middle = dvec3(10.5, 1.0, -10.5);
    let lens = Lens::Orthographic { height: 21.9 };
    let camera = Camera::new(middle + DVec3::Y, middle, -DVec3::Z, lens).expect("a camera");
    all.camera = Some(camera);
    let mut few = all.clone();
    let is_seen = |(i, _): &(usize, &[DVec4])| i % 100 < 22 && i / 100 < 22;
    let patches = all.surfaces[0].control_points().chunks(16).enumerate().filter(is_seen);
    let points = patches.flat_map(|(_, points)| points.to_vec()).collect();
    let mut surface = Surface::new(Degree::CUBIC, points).expect("whole patches");
    surface.paint = all.surfaces[0].paint.clone();
    surface.transform = all.surfaces[0].transform;
    few.surfaces = vec![surface];
    let [mut whole, mut seen] = [&all, &few].map(|scene| Drawn::new(gl, scene, (SIDE, SIDE)));
    // Every frame has a new view.
    let step = |drawn: &mut Drawn<'_>| {
        drawn.frame.camera.view.w_axis.x += 1e-6;
        drawn.draw();
    };
    let ms = in_turns(&mut [&mut || step(&mut whole), &mut || step(&mut seen)]);
    let culled = whole.prepared.stats().culled;
    line(
        &format!("10,000 patches, {culled} out of sight / the others alone"),
        ms[0] / ms[1],
        "≤ 1.3",
    );
}

/// A patch of which trims keep a tenth.
fn cut_away(gl: &Gl) {
    println!();
    let target = Framebuffer::new(gl, SIDE, SIDE).expect("a picture of the bench");
    target.bind();
    let mut scene = field(1);
    let camera = Camera::new(
        dvec3(0.0, 3.0, 0.0),
        dvec3(0.0, 1.0, 0.0),
        -DVec3::Z,
        Lens::Orthographic { height: 1.0 },
    );
    scene.camera = Some(camera.expect("a camera"));
    scene.settings.tessellation = within(0.5);
    let mut whole = Drawn::new(gl, &scene, (SIDE, SIDE));
    let trim = Rect::new(dvec2(0.0, 1.0), dvec2(0.1, 1.0)).expect("an interval");
    scene.surfaces[0].trims.rects.push(trim);
    let mut cut = Drawn::new(gl, &scene, (SIDE, SIDE));
    let ms = in_turns(&mut [&mut || cut.draw(), &mut || whole.draw()]);
    line("a patch with 90 % cut away / the same uncut", ms[0] / ms[1], "≤ 0.5");
}

/// The growth of the process per patch.
fn memory(gl: &Gl) {
    println!();
    let resident = || {
        let statm = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
        let pages = statm.split_whitespace().nth(1).and_then(|pages| pages.parse::<f64>().ok());
        pages.unwrap_or(f64::NAN) * 4096.0
    };
    let target = Framebuffer::new(gl, 64, 64).expect("a picture of the bench");
    target.bind();
    let draw = |patches: usize| {
        let mut scene = field(patches);
        scene.settings.tessellation = within(0.5);
        let mut drawn = Drawn::new(gl, &scene, (64, 64));
        drawn.draw();
        (scene, drawn)
    };
    // The programs and the driver's own data already exist here.
    let first = draw(100);
    let before = resident();
    let many = draw(100_000);
    let bytes = (resident() - before) / 1e5;
    drop((first, many));
    line("100,000 patches: bytes a patch, with the scene and the driver's copy", bytes, "≤ 1,200");
}
