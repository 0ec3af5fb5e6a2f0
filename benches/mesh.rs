//! The cost of a smoothing step in software, for meshes of a thousand to a million triangles. Also the cost of
//! smooth triangles in the tessellation stages, compared with drawing the mesh of such a step.
//!
//! `cargo bench --bench mesh` prints medians, ratios and the limits under which they should stay; names after
//! `--` select sections: steps, memory, gpu, moving.

mod static_mesh;

#[path = "../tests/math/shapes.rs"]
mod shapes;
mod turns;

use std::hint::black_box;

use freeform_surface::inspect::StaticStyle;
use freeform_surface::inspect::programs::TrimFeatures;
use freeform_surface::inspect::{CurvedTriangle, HalfedgeMesh, PnTriangle, SmoothTriangle};
use freeform_surface::{
    Alpha, Backend, Frame, Framebuffer, Headless, Mesh, MeshModel, Method, Paint, PreparedScene,
    RenderSettings, Renderer, Scene, Shading, Smoothing, TessLevel, Tessellation, Tolerance,
    smooth,
};
use glam::{DMat4, DVec3, dvec3};
use shapes::torus;
use turns::{in_turns, line};

/// Sizes of tori; the number of triangles is four times the square of the size.
const SIDES: [u32; 4] = [16, 50, 158, 500];

fn main() {
    let asked: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let sections: [(&str, fn()); 4] =
        [("steps", steps), ("memory", memory), ("gpu", on_the_gpu), ("moving", moving)];
    for (name, section) in sections {
        if asked.is_empty() || asked.iter().any(|asked| asked == name) {
            section();
        }
    }
}

/// Evaluates the same points as a step, and writes them in one pass over the triangles without other work. Each
/// triangle evaluates the points of its marked edges, and its centre.
fn points_alone(mesh: &Mesh, marks: &[[bool; 3]]) -> (Vec<DVec3>, Vec<DVec3>) {
    const THIRD: f64 = 1.0 / 3.0;
    const TWO: f64 = 2.0 / 3.0;
    const EDGES: [[[f64; 3]; 2]; 3] = [
        [[TWO, THIRD, 0.0], [THIRD, TWO, 0.0]],
        [[0.0, TWO, THIRD], [0.0, THIRD, TWO]],
        [[THIRD, 0.0, TWO], [TWO, 0.0, THIRD]],
    ];
    let mut points = Vec::with_capacity(9 * mesh.positions().len());
    let mut directions = Vec::with_capacity(9 * mesh.positions().len());
    points.extend_from_slice(mesh.positions());
    directions.extend_from_slice(mesh.normals());
    for (corners, marks) in mesh.triangles().iter().zip(marks) {
        let normals = corners.map(|corner| mesh.normals()[corner.normal as usize]);
        let [a, b, c] = normals;
        let surface = PnTriangle::new(&SmoothTriangle {
            positions: corners.map(|corner| mesh.positions()[corner.position as usize]),
            normals,
            edge_normals: [[a, b], [b, c], [c, a]],
        });
        let mut evaluate = |[u, v, w]: [f64; 3]| {
            points.push(surface.position(u, v, w));
            directions.push(surface.normal(u, v, w));
        };
        for (edge, _) in EDGES.into_iter().zip(marks).filter(|(_, mark)| **mark) {
            edge.into_iter().for_each(&mut evaluate);
        }
        evaluate([THIRD; 3]);
    }
    (points, directions)
}

/// A step, with and without finding the neighbours, compared with evaluation alone.
fn steps() {
    let mut nanoseconds = Vec::new();
    for side in SIDES {
        let mesh = torus(side);
        let triangles = mesh.triangles().len();
        let neighbours = HalfedgeMesh::new(mesh.clone());
        let is_first = |halfedge| neighbours.halfedge(neighbours.edge(halfedge)) == halfedge;
        let marks: Vec<[bool; 3]> =
            (0..triangles as u32).map(|t| [0, 1, 2].map(|k| is_first(3 * t + k))).collect();
        let ms = in_turns(&mut [
            &mut || drop(black_box(HalfedgeMesh::new(mesh.clone()))),
            &mut || drop(black_box(neighbours.tessellate(Smoothing::Pn))),
            &mut || drop(black_box(neighbours.step(Smoothing::Pn))),
            &mut || drop(black_box(points_alone(&mesh, &marks))),
            &mut || drop(black_box(mesh.clone())),
        ]);
        let [find, step, further, points, copy] = ms[..] else {
            unreachable!("five were asked for")
        };
        let each = |ms: f64| ms * 1e6 / triangles as f64;
        let whole = find - copy + step;
        line(&format!("{triangles} triangles: neighbours, ns a triangle"), each(find - copy), "");
        line(&format!("{triangles} triangles: the step, ns a triangle"), each(step), "");
        line(&format!("{triangles} triangles: both / points alone"), whole / points, "≤ 2");
        line(
            &format!("{triangles} triangles: a further step / points alone"),
            further / points,
            "≤ 2",
        );
        nanoseconds.push(each(whole));
    }
    let max = nanoseconds.iter().copied().fold(0.0, f64::max);
    let ratio = max / nanoseconds[0];
    line("dearest time a triangle / that of the smallest mesh", ratio, "linear: about 1");
}

/// The peak memory of the process while it smooths a million triangles, compared with the result.
fn memory() {
    let figure = |name: &str| {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let line =
            status.lines().find_map(|line| line.strip_prefix(name)?.split_whitespace().next());
        line.and_then(|kilobytes| kilobytes.parse::<f64>().ok()).unwrap_or(f64::NAN) * 1024.0
    };
    for steps in [1, 2] {
        let mesh = torus(if steps == 1 { 500 } else { 158 });
        let before = figure("VmRSS:");
        // On Linux, this resets the peak.
        std::fs::write("/proc/self/clear_refs", "5").expect("a process may clear its own peak");
        let smoothed = smooth(mesh, Smoothing::Pn, steps).expect("a torus");
        let output = size_of_val(smoothed.positions())
            + size_of_val(smoothed.normals())
            + size_of_val(smoothed.coordinates())
            + size_of_val(smoothed.triangles());
        let ratio = (figure("VmHWM:") - before) / output as f64;
        line(&format!("{steps} steps: growth at most / bytes of the result"), ratio, "≤ 3");
    }
}

/// A scene of one mesh.
fn scene_of(mesh: &Mesh, smoothing: Smoothing, tessellation: Tessellation) -> Scene {
    let model = MeshModel::new(mesh.clone(), smoothing);
    let settings = RenderSettings { tessellation, ..RenderSettings::default() };
    Scene { settings, meshes: vec![model], ..Scene::default() }
}

/// Still frames at level 3, which makes 13 triangles of each. They are compared with the nine triangles of a
/// step in software, drawn as a static mesh with the same fragment shader.
fn on_the_gpu() {
    const SIDE: u32 = 1024;
    println!();
    let context = Headless::new(Backend::Auto).expect("an OpenGL context");
    let gl = context.gl();
    println!("{}, {}", context.info().renderer, context.info().version);
    let target = Framebuffer::new(gl, SIDE, SIDE).expect("a picture of the bench");
    target.bind();
    for side in [16, 71] {
        let mesh = torus(side);
        for (name, smoothing) in
            [("PN", Smoothing::Pn), ("Phong", Smoothing::Phong(Alpha::default()))]
        {
            let level = TessLevel::new(3).expect("a level");
            let scene = scene_of(&mesh, smoothing, Tessellation::Level(level));
            let mut renderer = Renderer::new(gl).expect("a renderer");
            let mut prepared = PreparedScene::new(&renderer, &scene).expect("it fits");
            let frame = Frame::of(&scene, (SIDE, SIDE));
            let step = smooth(mesh.clone(), smoothing, 1).expect("a torus");
            let mesh_of_step = static_mesh::of_mesh(gl, &step);
            let grey = Paint::Color([0.8; 3]).upload(gl).expect("a texel");
            let style = StaticStyle {
                method: Method::Exact,
                shading: Shading::Phong,
                trims: TrimFeatures::NONE,
                texture: &grey,
            };
            let mut still = Renderer::new(gl).expect("a renderer");
            let ms = in_turns(&mut [
                &mut || {
                    let _ = prepared.draw(&mut renderer, &frame).expect("it draws");
                    gl.finish();
                },
                &mut || {
                    still.clear(frame.settings.background);
                    still.draw_static(&mesh_of_step, &style, &frame).expect("it draws");
                    gl.finish();
                },
            ]);
            let triangles = mesh.triangles().len();
            let what = format!("{name}, {triangles} triangles at level 3: {:.2} ms", ms[0]);
            line(&format!("{what} / a step's mesh"), ms[0] / ms[1], "≤ 1.3");
        }
    }
}

/// The pass over all triangles that a camera motion needs.
fn moving() {
    println!();
    let context = Headless::new(Backend::Auto).expect("an OpenGL context");
    let gl = context.gl();
    let target = Framebuffer::new(gl, 64, 64).expect("a picture of the bench");
    target.bind();
    let half_a_pixel = Tessellation::Within(Tolerance::new(0.5).expect("a tolerance"));
    for side in [16, 50, 158] {
        let mesh = torus(side);
        let scene = scene_of(&mesh, Smoothing::Pn, half_a_pixel);
        let renderer = Renderer::new(gl).expect("a renderer");
        let mut prepared = PreparedScene::new(&renderer, &scene).expect("it fits");
        let frame = Frame::of(&scene, (64, 64));
        // Two views alternate, so that each frame has a new view.
        let mut other = frame;
        other.camera.view = DMat4::from_translation(dvec3(0.001, 0.0, 0.0)) * other.camera.view;
        let views = [frame, other];
        let mut turn = 0;
        let ms = in_turns(&mut [&mut || {
            turn += 1;
            prepared.prepare(&renderer, &views[turn % 2]).expect("it fits");
        }]);
        let triangles = mesh.triangles().len();
        line(&format!("{triangles} triangles, a new view: ms"), ms[0], "");
        let each = ms[0] * 1e6 / triangles as f64;
        line(&format!("{triangles} triangles, a new view: ns a triangle"), each, "linear");
    }
}
