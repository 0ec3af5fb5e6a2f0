//! Exact trims on the GPU, compared with the `f64` oracle, and bit for bit with their twin on the CPU. They are
//! tested with and without the grid, and at every sample of a pixel.
#![allow(unsafe_code, reason = "targets with floats and with several samples are made here")]

use freeform_surface::inspect::TrimGrid;
use freeform_surface::inspect::measure::Random;
use freeform_surface::inspect::programs::Sources;
use freeform_surface::{
    Circle, FillRule, Frame, Framebuffer, Gl, Keep, PreparedScene, Renderer, Samples, Scene,
    Segment, Shading, TessLevel, Tessellation, TrimLoop, TrimPath, Trims,
};
use glam::{DMat4, DVec2, DVec3, DVec4, UVec2, Vec2, dvec2, vec2};
use glow::{HasContext, PixelPackData};

use crate::harness::Stage;
use crate::harness::oracle::{EITHER_WAY, centers, changes_within, count_wrong};
use crate::harness::{Checked, backends, load, root};

/// A flat patch that fills a square picture exactly.
fn flat(trims: Trims) -> Scene {
    let text = r#"
        camera = { eye = [0, 1, 0], target = [0, 0, 0], up = [0, 0, -1], orthographic_height = 1 }
        render = { level = 1, background = [0, 0, 0, 0] }
        surface = [{ control_points = "default", shading = "flat" }]"#;
    let mut scene = Scene::from_toml(text, "flat.toml".as_ref()).unwrap();
    scene.surfaces[0].trims = trims;
    scene
}

/// Chains of cubics between random points, which cross themselves and each other and leave the
/// domain.
fn random_loops(random: &mut Random) -> Vec<TrimLoop> {
    let chain = |random: &mut Random| {
        let mut coordinate = || random.unit() * 1.4 - 0.2;
        let mut point = || dvec2(coordinate(), coordinate());
        let mut points = vec![point(), point(), point()];
        while points.len() < 15 && point().x > 0.3 {
            points.extend([point(), point(), point()]);
        }
        let at = |i: usize| points[i % points.len()];
        let cubic = |i: usize| Segment::Cubic([at(i), at(i + 1), at(i + 2), at(i + 3)]);
        TrimLoop::new((0..points.len()).step_by(3).map(cubic).collect()).unwrap()
    };
    (0..1 + random.below(4)).map(|_| chain(random)).collect()
}

/// Random loops, and paths with both fill rules.
fn random_paths(random: &mut Random) -> Trims {
    let mut trims = Trims { loops: random_loops(random), ..Trims::default() };
    for _ in 0..1 + random.below(4) {
        let rule = if random.unit() < 0.7 { FillRule::NonZero } else { FillRule::EvenOdd };
        trims.paths.push(TrimPath { loops: random_loops(random), rule });
    }
    trims.keep = if random.unit() < 0.5 { Keep::Outside } else { Keep::Inside };
    trims
}

/// Draws flat scenes and counts the pixels with a wrong decision.
struct FlatPictures(Stage);

impl FlatPictures {
    const SIDE: u32 = 2048;

    fn new() -> Self {
        Self(Stage::new(UVec2::splat(Self::SIDE)))
    }

    fn wrong(&mut self, trims: &Trims) -> usize {
        let image = self.0.render(&flat(trims.clone()));
        let rows = image.chunks_exact(4 * Self::SIDE as usize).rev();
        let cut: Vec<bool> = rows.flat_map(|row| row.chunks_exact(4)).map(|p| p[3] == 0).collect();
        let pixels = centers(Self::SIDE);
        count_wrong(trims, &pixels, &pixels, &cut)
    }
}

#[test]
fn every_pixel_of_200_random_scenes_is_decided_as_the_oracle_does() {
    let mut pictures = FlatPictures::new();
    let mut random = Random(1);
    for number in 0..200 {
        let trims = Trims { loops: random_loops(&mut random), ..Trims::default() };
        assert_eq!(pictures.wrong(&trims), 0, "scene {number}: {:?}", trims.loops);
    }
}

#[test]
fn every_pixel_of_60_random_scenes_of_paths_is_decided_as_the_oracle_does() {
    let mut pictures = FlatPictures::new();
    let mut random = Random(7);
    for number in 0..60 {
        let trims = random_paths(&mut random);
        assert_eq!(pictures.wrong(&trims), 0, "scene {number}: {trims:?}");
    }
}

#[test]
fn every_pixel_of_the_gallerys_trims_is_decided_as_the_oracle_does() {
    let mut pictures = FlatPictures::new();
    for name in ["lettering", "gear", "lace", "shell", "badge"] {
        let scene = load(&root().join(format!("resources/scenes/gallery/{name}.toml")));
        assert!(!scene.surfaces.is_empty());
        for (number, surface) in scene.surfaces.iter().enumerate() {
            assert_eq!(pictures.wrong(&surface.trims), 0, "{name}, surface {number}");
        }
    }
}

/// Trims of every kind: shapes, curves of every degree, islands, and many small loops.
fn mixed_trims() -> Trims {
    let mut trims =
        load(&root().join("resources/scenes/stability/trim-shapes.toml")).surfaces[0].trims.clone();
    trims
        .add_svg_path("M.1 .1 L.9 .15 .8 .9 Q.5 .5 .1 .9Z M.3 .4 C.3 .6 .6 .7 .6 .4 S.3 .2 .3 .4Z")
        .unwrap();
    for i in 0..40 {
        let (u, v) = (0.42 + 0.002 * f64::from(i % 8), 0.45 + 0.002 * f64::from(i / 8));
        trims.add_svg_path(&format!("M{u} {v} q.0005 .0015 .001 0 t-.001 0z")).unwrap();
    }
    trims
}

/// Petals that meet in one point. The grid's cell there lists hundreds of pieces, which bulge to either side.
fn starburst() -> Trims {
    let mut trims = Trims::default();
    for i in 0..120 {
        let turn = 0.051 * f64::from(i);
        let at = |radius: f64, turn: f64| dvec2(0.47, 0.53) + radius * DVec2::from_angle(turn);
        let [a, b] = [at(0.4, turn), at(0.4, turn + 0.03)];
        let [p, q] = [at(0.2, turn - 0.3), at(0.2, turn - 0.25)];
        let path = format!(
            "M.47 .53 Q{} {} {} {} L{} {} Q{} {} .47 .53Z",
            p.x, p.y, a.x, a.y, b.x, b.y, q.x, q.y
        );
        trims.add_svg_path(&path).unwrap();
    }
    trims
}

/// A target of 32-bit floats, for values that must come back bit for bit.
struct FloatTarget {
    gl: Gl,
    framebuffer: glow::Framebuffer,
    buffers: [glow::Renderbuffer; 2],
    side: u32,
}

impl FloatTarget {
    fn new(gl: &Gl, side: u32) -> Self {
        // SAFETY: the context is current; all objects are new, and deleted by `drop`.
        unsafe {
            let framebuffer = gl.create_named_framebuffer().unwrap();
            let buffers = [
                (glow::RGBA32F, glow::COLOR_ATTACHMENT0),
                (glow::DEPTH_COMPONENT32F, glow::DEPTH_ATTACHMENT),
            ]
            .map(|(format, place)| {
                let buffer = gl.create_renderbuffer().unwrap();
                gl.bind_renderbuffer(glow::RENDERBUFFER, Some(buffer));
                gl.renderbuffer_storage(glow::RENDERBUFFER, format, side as i32, side as i32);
                let kind = glow::RENDERBUFFER;
                gl.named_framebuffer_renderbuffer(Some(framebuffer), place, kind, Some(buffer));
                buffer
            });
            Self { gl: gl.clone(), framebuffer, buffers, side }
        }
    }

    /// Four floats per pixel, bottom row first.
    fn draw(&self, scene: &Scene, sources: Sources) -> Vec<[f32; 4]> {
        let mut renderer = Renderer::with_sources(&self.gl, sources).unwrap();
        let mut prepared = PreparedScene::new(&renderer, scene).unwrap();
        let side = self.side as i32;
        let mut bytes = vec![0; 16 * (self.side * self.side) as usize];
        // SAFETY: the context is current; the slice holds the pixels that are asked for.
        unsafe {
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, Some(self.framebuffer));
            self.gl.viewport(0, 0, side, side);
            let _ =
                prepared.draw(&mut renderer, &Frame::of(scene, (self.side, self.side))).unwrap();
            let slice = PixelPackData::Slice(Some(&mut bytes));
            self.gl.read_pixels(0, 0, side, side, glow::RGBA, glow::FLOAT, slice);
        }
        bytes
            .chunks_exact(16)
            .map(|pixel| {
                [0, 1, 2, 3]
                    .map(|i| f32::from_ne_bytes(pixel[4 * i..4 * i + 4].try_into().unwrap()))
            })
            .collect()
    }
}

impl Drop for FloatTarget {
    fn drop(&mut self) {
        // SAFETY: the context is current; nothing else owns these objects.
        unsafe {
            self.gl.delete_framebuffer(self.framebuffer);
            for buffer in self.buffers {
                self.gl.delete_renderbuffer(buffer);
            }
        }
    }
}

/// Shaders that output (u, v), and in blue 1 where the surface is kept and 0 where it is cut.
fn decisions() -> Sources {
    Sources::default()
        .with_edit(
            "exact/surface.frag",
            "discard;",
            "{ fragmentColor = vec4(passTessCoord, 0, 1); return; }",
        )
        .with_edit("exact/surface.frag", "vec4(diffuseColor, 1.0)", "vec4(passTessCoord, 1, 1)")
}

/// The same without the grid: every sample is tested against every piece.
fn brute_force(pieces: std::ops::Range<usize>) -> Sources {
    let grid = include_str!("../../glsl/common/trim.glsl");
    let end = pieces.end;
    let start = pieces.start;
    let without = format!(
        "
bool cutByLoops(vec2 uv)
{{
    bool inside = false;
    for (int piece = {start}; piece < {end}; piece += 2) {{
        vec4 ends = texelFetch(trimPoints, piece), legs = texelFetch(trimPoints, piece + 1);
        if ((ends.y <= uv.y) == (ends.w <= uv.y) || uv.x >= max(ends.x, ends.z))
            continue;
        if (uv.x < min(ends.x, ends.z)) {{
            inside = !inside;
            continue;
        }}
        precise vec2 point = uv - ends.xy, a = vec2(0.0), b = legs.xy, d = ends.zw - ends.xy;
        precise vec2 c = d - legs.zw;
        bool left = crossed(d, legs.xy - legs.zw) > 0.0;
        float turn = left ? 1.0 : -1.0;
        bool decided = turn * crossed(d, point) < 0.0, isLeft = decided && !left;
        for (int halving = 0; halving < 24 && !decided; ++halving) {{
            precise vec2 ab = (a + b) * 0.5, bc = (b + c) * 0.5, cd = (c + d) * 0.5;
            precise vec2 abc = (ab + bc) * 0.5, bcd = (bc + cd) * 0.5, middle = (abc + bcd) * 0.5;
            if (middle.y <= point.y) {{
                a = middle; b = bcd; c = cd;
            }} else {{
                b = ab; c = abc; d = middle;
            }}
            bool outside = turn * crossed(d - a, point - a) < 0.0;
            bool beyond = turn * crossed(bcd - abc, point - middle) > 0.0;
            decided = outside || beyond;
            isLeft = outside ? !left : beyond && left;
        }}
        inside = inside != isLeft;
    }}
    return inside;
}}
"
    );
    let start = grid.find("bool cutByLoops(vec2 uv)").unwrap();
    let end = start + grid[start..].find("#endif\n\n#ifdef SHAPES").unwrap();
    decisions().with_edit("common/trim.glsl", &grid[start..end], &without)
}

/// A wavy patch whose triangles are not aligned with pixels, in perspective.
fn curved(trims: Trims) -> Scene {
    let mut scene = Scene::listing16();
    scene.settings.background = [0.0; 4];
    // 61 is a prime: the patch is not split into sub-patches, so cut areas are drawn too.
    scene.settings.tessellation = Tessellation::Level(TessLevel::new(61).unwrap());
    scene.surfaces[0].trims = trims;
    scene.surfaces[0].shading = Shading::Unlit;
    scene
}

/// Compares every drawn pixel with the twin on the CPU and with the oracle. Returns the numbers of kept and cut
/// pixels.
fn compare(scene: &Scene, pixels: &[[f32; 4]]) -> [usize; 2] {
    let trims = &scene.surfaces[0].trims;
    let grid = TrimGrid::new(trims);
    let mut counts = [0; 2];
    for [u, v, kept, alpha] in pixels {
        if *alpha == 0.0 {
            continue;
        }
        let is_cut = *kept == 0.0;
        let uv = vec2(*u, *v);
        counts[usize::from(is_cut)] += 1;
        assert_eq!(grid.cut(uv), is_cut, "GPU and CPU at {uv:?}");
        let uv = uv.as_dvec2();
        assert!(
            trims.cut(uv) == is_cut || changes_within(trims, uv, EITHER_WAY),
            "GPU and oracle at {uv}"
        );
    }
    counts
}

#[test]
fn the_gpu_decides_bit_for_bit_as_the_cpu_does_on_a_curved_patch() {
    for backend in backends() {
        let context = Checked::new(backend);
        let target = FloatTarget::new(context.gl(), 512);
        let mut random = Random(2);
        let mut all_cut = 0;
        for number in 0..12 {
            let trims = match number {
                0 => mixed_trims(),
                1 => starburst(),
                2 => {
                    // Long lists that have heads.
                    let path = TrimPath { loops: starburst().loops, rule: FillRule::NonZero };
                    Trims { paths: vec![path.clone(), path], ..Trims::default() }
                }
                3..6 => random_paths(&mut random),
                _ => Trims { loops: random_loops(&mut random), ..Trims::default() },
            };
            let scene = curved(trims);
            let [kept, cut] = compare(&scene, &target.draw(&scene, decisions()));
            assert!(kept + cut > 20_000, "{number}: {kept} {cut}");
            all_cut += cut;
        }
        assert!(all_cut > 100_000, "{all_cut}");
    }
}

#[test]
fn the_grid_and_brute_force_agree_bit_for_bit_on_the_gpu() {
    let context = Checked::new(backends()[0]);
    let target = FloatTarget::new(context.gl(), 256);
    let mut random = Random(3);
    for number in 0..8 {
        let mut trims = match number {
            0 => mixed_trims(),
            _ => Trims { loops: random_loops(&mut random), ..Trims::default() },
        };
        trims.circles_on = false;
        let scene = curved(trims);
        let grid = TrimGrid::new(&scene.surfaces[0].trims);
        let pieces = grid.pieces();
        // The texels of the pieces in the shader's buffer.
        let before = pieces.as_ptr() as usize - grid.words().as_ptr() as usize;
        let pieces = before / 16..before / 16 + 2 * pieces.len();
        let with_grid = target.draw(&scene, decisions());
        let without = target.draw(&scene, brute_force(pieces));
        assert!(with_grid.iter().any(|pixel| pixel[2] == 1.0));
        assert_eq!(with_grid, without, "{number}");
    }
}

#[test]
fn parts_of_a_patch_change_nothing() {
    // At level 32, sub-patches are wholly kept, wholly cut, or trimmed; at level 1 there is a single sub-patch.
    let trims = mixed_trims();
    let mut whole = flat(trims.clone());
    // The default patch is flat but unevenly parametrised: between its vertices (u, v) would be curved.
    for i in 0..16 {
        let place = dvec2(f64::from(i % 4), f64::from(i / 4)) / 3.0 - 0.5;
        whole.surfaces[0]
            .set_control_point(DVec4::new(place.x, 0.0, -place.y, 1.0), i as usize)
            .unwrap();
    }
    let mut parts = whole.clone();
    parts.settings.tessellation = Tessellation::Level(TessLevel::new(32).unwrap());
    let pictures = [&whole, &parts]
        .map(|scene| crate::harness::render(scene, glam::UVec2::splat(512), backends()[0]));
    // Levels place triangles differently, so that (u, v) is rounded differently.
    for picture in pictures {
        for (x, y, pixel) in picture.enumerate_pixels() {
            let uv = dvec2(f64::from(x) + 0.5, 511.5 - f64::from(y)) / 512.0;
            let is_cut = pixel.0[3] == 0;
            assert!(trims.cut(uv) == is_cut || changes_within(&trims, uv, 1e-6), "{x} {y}");
        }
    }
}

/// One picture for each sample of a pixel, of the samples that are drawn, bottom row first.
fn samples_drawn(context: &Checked, scene: &Scene, side: u32) -> Vec<(DVec2, Vec<bool>)> {
    // glow 0.17 does not have this function.
    type GetMultisamplefv = unsafe extern "C" fn(name: u32, index: u32, value: *mut f32);
    let get_multisample_fv = context.proc_address(c"glGetMultisamplefv");
    assert!(!get_multisample_fv.is_null());
    let gl = context.gl();
    const SAMPLES: i32 = 4;
    let size = side as i32;
    let vertex = "#version 450 core
        void main() { gl_Position = vec4(vec2[](vec2(-1), vec2(3, -1), vec2(-1, 3))[gl_VertexID], 0, 1); }";
    let fragment = "#version 450 core
        layout(binding = 0) uniform sampler2DMS samples;
        layout(location = 0) uniform int number;
        out vec4 color;
        void main() { color = texelFetch(samples, ivec2(gl_FragCoord.xy), number); }";
    // SAFETY: the context is current; the objects are new and live as long as the context, which the
    // caller drops next; the slice holds the pixels that are asked for.
    unsafe {
        let texture = |format| {
            let texture = gl.create_texture().unwrap();
            gl.bind_texture(glow::TEXTURE_2D_MULTISAMPLE, Some(texture));
            let kind = glow::TEXTURE_2D_MULTISAMPLE;
            gl.tex_storage_2d_multisample(kind, SAMPLES, format, size, size, true);
            texture
        };
        let (color, depth) = (texture(glow::RGBA8), texture(glow::DEPTH_COMPONENT32F));
        let framebuffer = gl.create_named_framebuffer().unwrap();
        gl.named_framebuffer_texture(Some(framebuffer), glow::COLOR_ATTACHMENT0, Some(color), 0);
        gl.named_framebuffer_texture(Some(framebuffer), glow::DEPTH_ATTACHMENT, Some(depth), 0);
        gl.bind_framebuffer(glow::FRAMEBUFFER, Some(framebuffer));
        gl.viewport(0, 0, size, size);
        let mut renderer = Renderer::new(gl).unwrap();
        let mut prepared = PreparedScene::new(&renderer, scene).unwrap();
        let _ = prepared.draw(&mut renderer, &Frame::of(scene, (side, side))).unwrap();
        let get_multisample_fv: GetMultisamplefv = std::mem::transmute(get_multisample_fv);
        let positions: Vec<DVec2> = (0..SAMPLES)
            .map(|i| {
                let mut position = [0.0; 2];
                get_multisample_fv(glow::SAMPLE_POSITION, i as u32, position.as_mut_ptr());
                Vec2::from(position).as_dvec2()
            })
            .collect();

        let program = gl.create_program().unwrap();
        for (kind, text) in [(glow::VERTEX_SHADER, vertex), (glow::FRAGMENT_SHADER, fragment)] {
            let shader = gl.create_shader(kind).unwrap();
            gl.shader_source(shader, text);
            gl.compile_shader(shader);
            gl.attach_shader(program, shader);
        }
        gl.link_program(program);
        assert!(gl.get_program_link_status(program));
        let vertices = gl.create_vertex_array().unwrap();
        let single = Framebuffer::new(gl, side, side).unwrap();
        single.bind();
        gl.disable(glow::DEPTH_TEST);
        gl.use_program(Some(program));
        gl.bind_vertex_array(Some(vertices));
        gl.bind_texture_unit(0, Some(color));
        (0..SAMPLES)
            .zip(positions)
            .map(|(number, position)| {
                gl.uniform_1_i32(Some(&glow::NativeUniformLocation(0)), number);
                gl.draw_arrays(glow::TRIANGLES, 0, 3);
                let image = single.read();
                let rows = image.chunks_exact(4 * side as usize).rev();
                let drawn = rows.flat_map(|row| row.chunks_exact(4)).map(|p| p[3] != 0).collect();
                (position, drawn)
            })
            .collect()
    }
}

#[test]
fn every_sample_of_a_pixel_is_decided_at_its_own_place() {
    const SIDE: u32 = 512;
    for backend in backends() {
        for trims in [mixed_trims(), random_paths(&mut Random(5))] {
            let scene = flat(trims);
            let context = Checked::new(backend);
            let samples = samples_drawn(&context, &scene, SIDE);
            assert_eq!(samples.len(), 4);
            for (place, drawn) in samples {
                let at = |axis: usize| -> Vec<f64> {
                    (0..SIDE).map(|i| (f64::from(i) + place[axis]) / f64::from(SIDE)).collect()
                };
                let cut: Vec<bool> = drawn.iter().map(|drawn| !drawn).collect();
                let trims = &scene.surfaces[0].trims;
                assert_eq!(count_wrong(trims, &at(0), &at(1), &cut), 0, "sample at {place}");
            }
        }
    }
}

/// The area of a pixel that lies in a polygon, by clipping.
fn covered(polygon: &[DVec2], corner: DVec2, size: f64) -> f64 {
    let mut points = polygon.to_vec();
    for (axis, sign, border) in [
        (0, 1.0, corner.x),
        (0, -1.0, corner.x + size),
        (1, 1.0, corner.y),
        (1, -1.0, corner.y + size),
    ] {
        let inside = |p: DVec2| sign * (p[axis] - border);
        let mut clipped = Vec::with_capacity(points.len() + 4);
        for i in 0..points.len() {
            let (from, to) = (points[i], points[(i + 1) % points.len()]);
            let (a, b) = (inside(from), inside(to));
            if a >= 0.0 {
                clipped.push(from);
            }
            if (a >= 0.0) != (b >= 0.0) {
                clipped.push(from + (to - from) * (a / (a - b)));
            }
        }
        points = clipped;
    }
    let area: f64 =
        (0..points.len()).map(|i| points[i].perp_dot(points[(i + 1) % points.len()])).sum();
    area.abs() * 0.5 / (size * size)
}

/// A square with a round hole and a star-shaped hole, in the domain, rotated by an angle in a picture from 0 to
/// 1. Also returns the outlines of the square and of the holes.
fn turned_square(angle: f64) -> (Scene, [Vec<DVec2>; 3]) {
    let around =
        |count: usize| (0..count).map(move |i| i as f64 * std::f64::consts::TAU / count as f64);
    let center = dvec2(0.3, 0.35);
    let hole = around(2000).map(|turn| center + 0.2 * DVec2::from_angle(turn)).collect();
    let star: Vec<DVec2> = around(10)
        .enumerate()
        .map(|(i, turn)| {
            let radius = if i % 2 == 0 { 0.22 } else { 0.1 };
            dvec2(0.68, 0.68) + radius * DVec2::from_angle(0.1 + turn)
        })
        .collect();
    let mut trims = Trims::default();
    trims.circles.push(Circle::new(center, 0.2).unwrap());
    let line = |i: usize| Segment::Line([star[i], star[(i + 1) % star.len()]]);
    trims.add_loop(TrimLoop::new((0..star.len()).map(line).collect()).unwrap()).unwrap();
    let mut scene = flat(trims);
    scene.surfaces[0].transform =
        DMat4::from_rotation_y(angle) * DMat4::from_scale(DVec3::splat(0.7));
    let on_screen = |uv: DVec2| 0.5 + DVec2::from_angle(angle).rotate((uv - 0.5) * 0.7);
    let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| dvec2(u, v));
    let outlines = [square.to_vec(), hole, star];
    (scene, outlines.map(|outline| outline.into_iter().map(on_screen).collect()))
}

#[test]
fn edges_of_trims_and_silhouettes_cover_what_they_should() {
    const SIDE: u32 = 200;
    const PARTLY: std::ops::Range<f64> = 1e-9..1.0 - 1e-9;
    let context = Checked::new(backends()[0]);
    let mut renderer = Renderer::new(context.gl()).unwrap();
    for (samples, max) in [(4, 0.10), (16, 0.04), (64, 0.015)] {
        let samples = Samples::new(samples).unwrap();
        let target = Framebuffer::for_samples(context.gl(), (SIDE, SIDE), samples).unwrap();
        let (mut silhouettes, mut edges) = (Vec::new(), Vec::new());
        // Four samples are accurate for some directions of edges and inaccurate for others.
        for turn in 0..6 {
            let (mut scene, outlines) = turned_square(0.07 + 0.26 * f64::from(turn));
            scene.settings.samples = samples;
            let mut prepared = PreparedScene::new(&renderer, &scene).unwrap();
            let frame = Frame::of(&scene, (SIDE, SIDE));
            let image = prepared.picture(&mut renderer, &target, &frame, |_, _| ()).unwrap();
            for (x, y, pixel) in image.enumerate_pixels() {
                let corner = dvec2(x.into(), (SIDE - 1 - y).into()) / f64::from(SIDE);
                let [square, hole, star] =
                    [0, 1, 2].map(|i| covered(&outlines[i], corner, 1.0 / f64::from(SIDE)));
                let error = f64::from(pixel.0[3]) / 255.0 - (square - hole - star);
                if PARTLY.contains(&square) {
                    silhouettes.push(error);
                } else if PARTLY.contains(&(hole + star)) {
                    edges.push(error);
                } else {
                    assert!(error.abs() < 0.01, "nothing but inside or outside: {error}");
                }
            }
        }
        for (what, errors) in [("silhouettes", silhouettes), ("trims", edges)] {
            let squares: f64 = errors.iter().map(|error| error * error).sum();
            let rmse = (squares / errors.len() as f64).sqrt();
            assert!(errors.len() > 2000 && rmse > 0.001, "{what}: {} {rmse}", errors.len());
            let samples = samples.get();
            assert!(rmse <= max, "{what} with {samples} samples: RMSE {rmse:.4} > {max}");
        }
    }
}
