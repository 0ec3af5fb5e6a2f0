//! Isolines: where they lie, that nothing else is drawn and nothing is missing, and that nothing else changes. The true
//! lines are computed in `f64` from the surface and the camera.

use std::path::Path;

use freeform_surface::inspect::measure::Random;
use freeform_surface::inspect::programs::Sources;
use freeform_surface::{
    Aovs, Camera, Circle, Degree, Error, Frame, Framebuffer, Image, IsolineCount, Isolines, Lens,
    LineWidth, Normals, Paint, Samples, Scene, Shading, Surface, TessLevel, Tessellation, Trims,
};
use glam::{DVec2, DVec3, DVec4, dvec2, dvec3, uvec2};

use super::leaks::to_pixels;
use crate::harness::patches::{field, scene_of, within};
use crate::harness::{Stage, backends, load, root};

fn isolines(count: i64, width: f64) -> Isolines {
    let (count, width) = (IsolineCount::new(count).unwrap(), LineWidth::new(width).unwrap());
    Isolines { count, width, color: [1.0; 3] }
}

/// A scene in black with white isolines, within half a pixel.
fn in_black(scene: Scene, isolines: Isolines) -> Scene {
    let mut scene = Scene { settings: within(0.5), ..scene };
    scene.settings.background = [0.0, 0.0, 0.0, 1.0];
    scene.settings.isolines = Some(isolines);
    scene.meshes.clear();
    for surface in &mut scene.surfaces {
        surface.shading = Shading::Unlit;
        surface.paint = Paint::Color([0.0; 3]);
    }
    scene
}

/// A place of an isoline.
#[derive(Clone, Copy)]
struct Place {
    pixel: DVec2,
    /// Distance along the view axis.
    depth: f64,
    /// The numbers of the surface and of its Bézier patch (0 for a NURBS surface), and (u, v) as shares of the domain of the NURBS surface or Bézier patch.
    surface: [usize; 2],
    share: DVec2,
    /// The cosine of the angle between normal and line of sight, at any side; 0 without a normal.
    facing: f64,
}

/// The isolines of all surfaces, each at equal steps of its parameter. The places between are nowhere far away.
fn true_lines(scene: &Scene, frame: &Frame, steps: u32) -> Vec<Vec<Place>> {
    let count = scene.settings.isolines.unwrap().count.get();
    let size = frame.viewport.size;
    let mut lines = Vec::new();
    for (number, surface) in scene.surfaces.iter().enumerate() {
        let of_patch = |patch: usize, u: f64, v: f64| match surface.nurbs() {
            Some(nurbs) => {
                let [low, high] = nurbs.domain();
                let place = low + dvec2(u, v) * (high - low);
                nurbs.at(place.x, place.y)
            }
            None => surface.at(patch, u, v),
        };
        let patches = if surface.nurbs().is_some() { 1 } else { surface.patches().len() };
        for (patch, k) in (0..patches).flat_map(|patch| (0..2 * count).map(move |k| (patch, k))) {
            let line = |i: u32| {
                let fixed = (f64::from(k / 2) + 0.5) / f64::from(count);
                let along = f64::from(i) / f64::from(steps);
                let (u, v) = if k % 2 == 0 { (fixed, along) } else { (along, fixed) };
                let point = of_patch(patch, u, v);
                let [du, dv] = [point.du, point.dv].map(|d| surface.transform.transform_vector3(d));
                let at = surface.transform.transform_point3(point.position);
                let seen = frame.camera.view.transform_point3(at);
                let normal = frame.camera.view.transform_vector3(du.cross(dv).normalize_or_zero());
                let sight = if frame.camera.projection.row(3).z == 0.0 {
                    DVec3::Z
                } else {
                    seen.normalize()
                };
                Place {
                    pixel: to_pixels(&frame.camera, size, at),
                    depth: -seen.z,
                    surface: [number, patch],
                    share: dvec2(u, v),
                    facing: normal.normalize_or_zero().dot(sight).abs(),
                }
            };
            lines.push((0..=steps).map(line).collect());
        }
    }
    lines
}

/// A picture with several samples a pixel.
fn picture(stage: &mut Stage, scene: &Scene, samples: i64) -> Image {
    let mut frame = stage.frame(scene);
    frame.settings.samples = Samples::new(samples).unwrap();
    let gl = stage.context().gl().clone();
    let size = (stage.size.x, stage.size.y);
    let target = Framebuffer::for_samples(&gl, size, frame.settings.samples).unwrap();
    let mut prepared = stage.prepared(scene);
    prepared.picture(stage.renderer_mut(), &target, &frame, |_, _| {}).unwrap()
}

fn light(image: &Image, x: u32, y: u32) -> f64 {
    f64::from(image.get_pixel(x, y).0[0]) / 255.0
}

/// The light within `reach` of a part of a line, between perpendiculars at its ends: its sum, and its moment to the left
/// of the part.
fn light_along(image: &Image, part: &[Place], reach: f64) -> [f64; 2] {
    let (start, end) = (part[0].pixel, part[part.len() - 1].pixel);
    let along = (end - start).normalize();
    let (low, high) = (start.min(end) - 2.0 * reach, start.max(end) + 2.0 * reach);
    let (mut sum, mut moment) = (0.0, 0.0);
    for y in low.y as u32..=high.y as u32 {
        for x in low.x as u32..=high.x as u32 {
            let pixel = DVec2::new(x.into(), y.into()) + 0.5;
            let distance = |place: &DVec2| pixel.distance_squared(*place);
            let places = part.iter().map(|place| place.pixel);
            let nearest = places.min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap();
            let off = (pixel - nearest).dot(along.perp());
            let share = (pixel - start).dot(along);
            if (0.0..end.distance(start)).contains(&share) && off.abs() <= reach {
                sum += light(image, x, y);
                moment += light(image, x, y) * off;
            }
        }
    }
    [sum, moment]
}

/// Checks parts of about 16 pixels of all lines that are clearly seen and not near others: that their middle is within
/// 0.1 px of the true line, and their width right on the whole. Returns the number of parts.
fn check_places(name: &str, image: &Image, lines: &[Vec<Place>], width: f64) -> usize {
    let (parts, worst, drawn) = measure_places(image, lines, width);
    eprintln!("{name}: {parts} parts, off by at most {worst:.3} px, width {drawn:.3} of {width}");
    assert!(worst < 0.1, "{name}: {worst} px");
    assert!((drawn / width - 1.0).abs() < 0.02, "{name}: width {drawn} instead of {width}");
    parts
}

/// The number of such parts, how far the middle of one is from its line at most, and the mean width.
fn measure_places(image: &Image, lines: &[Vec<Place>], width: f64) -> (usize, f64, f64) {
    let (mut parts, mut sum, mut length, mut worst) = (0, 0.0, 0.0, 0.0_f64);
    let inside = |place: &Place| {
        let border = 12.0;
        let size = dvec2(image.width().into(), image.height().into());
        place.pixel.cmpgt(DVec2::splat(border)).all() && (size - place.pixel).min_element() > border
    };
    for (number, line) in lines.iter().enumerate() {
        let others = || lines.iter().enumerate().filter(|(other, _)| *other != number);
        let is_alone = |place: &Place| {
            let mut others = others().flat_map(|(_, line)| line);
            place.facing > 0.3
                && inside(place)
                && others.all(|other| other.pixel.distance_squared(place.pixel) > 81.0)
        };
        let is_alone: Vec<bool> = line.iter().map(is_alone).collect();
        let mut from = 0;
        for to in 0..line.len() {
            if !is_alone[to] {
                from = to + 1;
            } else if line[from].pixel.distance(line[to].pixel) >= 16.0 {
                let part = &line[from..=to];
                let [light, moment] = light_along(image, part, 4.0);
                let off = moment / light;
                assert!(light > width * 10.0, "no line at {}: {light}", part[0].pixel);
                worst = worst.max(off.abs());
                sum += light;
                length += part[0].pixel.distance(line[to].pixel);
                parts += 1;
                from = to;
            }
        }
    }
    (parts, worst, sum / length)
}

fn camera(eye: DVec3, target: DVec3) -> Camera {
    let lens = Lens::Perspective { fov_y_radians: 0.7 };
    Camera::new(eye, target, DVec3::Z, lens).unwrap()
}

/// A bicubic field with waves, seen from above.
fn waves() -> Scene {
    let height = |column: usize, row: usize| {
        0.4 * (0.9 * column as f64).sin() * (0.7 * row as f64 + 0.4).cos()
    };
    let surface = Surface::new(Degree::CUBIC, field(3, height)).unwrap();
    let mut scene = scene_of(vec![surface]);
    scene.camera = Some(camera(dvec3(2.2, -1.6, 4.5), dvec3(1.5, 1.5, 0.0)));
    scene
}

/// A rational patch of degrees 5 and 2.
fn weighted() -> Scene {
    let mut random = Random(7);
    let points = (0..18).map(|i| {
        let (x, y) = (f64::from(i % 6) / 2.5, f64::from(i / 6));
        DVec4::new(x, y, 0.5 * random.unit(), 0.5 + 1.5 * random.unit())
    });
    let surface = Surface::of_patch(Degree::new(5, 2).unwrap(), points.collect()).unwrap();
    let mut scene = scene_of(vec![surface]);
    scene.camera = Some(camera(dvec3(1.6, -1.2, 3.2), dvec3(1.0, 1.0, 0.2)));
    scene
}

/// The upper half of the sphere of the scene with sphere and torus: its far side would be beside the near one.
fn sphere() -> Scene {
    let mut scene = hard("nurbs-sphere-and-torus");
    scene.surfaces.truncate(1);
    scene.camera = None;
    scene
}

fn hard(name: &str) -> Scene {
    load(&root().join(format!("resources/scenes/stability/{name}.toml")))
}

#[test]
fn lines_lie_on_their_curves() {
    let mut stage = Stage::new(uvec2(420, 320));
    for (name, scene, count) in [("waves", waves(), 2), ("weighted", weighted(), 4)] {
        for (samples, width, normals) in [(1, 3.0, Normals::Vertex), (4, 2.0, Normals::Pixel)] {
            let mut scene = in_black(scene.clone(), isolines(count, width));
            scene.settings.normals = normals;
            let lines = true_lines(&scene, &stage.frame(&scene), 600);
            let image = picture(&mut stage, &scene, samples);
            assert!(check_places(name, &image, &lines, width) > 20, "{name}");
            // The lines do not move with the triangles.
            scene.settings.tessellation = within(8.0).tessellation;
            let image = picture(&mut stage, &scene, samples);
            assert!(check_places(name, &image, &lines, width) > 20, "{name}");
        }
    }
    // Four patches along u, three of which the whole surface has half a line in: N lines are those of the surface.
    let scene = in_black(sphere(), isolines(3, 3.0));
    let frame = stage.frame(&scene);
    let center = to_pixels(&frame.camera, stage.size, DVec3::ZERO);
    let depth = -frame.camera.view.transform_point3(DVec3::ZERO).z;
    let mut lines = true_lines(&scene, &frame, 600);
    for line in &mut lines {
        for place in line.iter_mut().filter(|place| place.depth > depth) {
            (place.pixel, place.facing) = (center + 1e6, 0.0);
        }
    }
    let image = picture(&mut stage, &scene, 1);
    assert!(check_places("sphere", &image, &lines, 3.0) > 20);
}

/// The check notices lines that are a little beside their place, and wider or narrower ones.
#[test]
fn wrong_lines_are_noticed() {
    let wrong = |old: &str, new: &str| {
        let sources = Sources::default().with_edit("exact/isolines.glsl", old, new);
        let mut stage = Stage::with_sources(backends()[0], uvec2(420, 320), sources);
        let scene = in_black(waves(), isolines(2, 3.0));
        let lines = true_lines(&scene, &stage.frame(&scene), 600);
        let image = picture(&mut stage, &scene, 1);
        measure_places(&image, &lines, 3.0)
    };
    assert!(wrong("(number + 0.5)", "(number + 0.51)").1 > 0.1);
    // The lines of the triangles are as far off as these.
    assert!(
        wrong("vec2 off = pixel - here.place;", "vec2 off = vec2(0.0); pixel = here.place;").1
            > 0.03
    );
    assert!((wrong("isolines.y + 0.5;", "isolines.y + 0.6;").2 / 3.0 - 1.0).abs() > 0.02);
}

/// Which pixels may have light: their centre is within `reach` of a line.
fn allowed(lines: &[Vec<Place>], size: (u32, u32), reach: f64) -> Vec<bool> {
    let (width, height) = (size.0 as i64, size.1 as i64);
    let mut allowed = vec![false; (width * height) as usize];
    let mut mark = |place: DVec2| {
        let low = (place - reach).max(DVec2::ZERO).floor();
        let high = (place + reach).min(dvec2(width as f64, height as f64) - 1.0);
        for y in low.y as i64..=high.y as i64 {
            for x in low.x as i64..=high.x as i64 {
                let center = dvec2(x as f64, y as f64) + 0.5;
                allowed[(y * width + x) as usize] |= center.distance(place) <= reach;
            }
        }
    };
    for pair in lines.iter().flat_map(|line| line.windows(2)) {
        let [from, to] = [pair[0], pair[1]];
        let apart = from.pixel.distance(to.pixel);
        if from.depth > 0.0 && to.depth > 0.0 && apart < 100.0 {
            let parts = (apart / 0.3).ceil().max(1.0) as u32;
            (0..=parts).for_each(|i| {
                mark(from.pixel.lerp(to.pixel, f64::from(i) / f64::from(parts)));
            });
        }
    }
    allowed
}

/// The surface and its Bézier patch (0 for a NURBS surface) that are seen at a pixel, and (u, v) there as a share of the domain of the NURBS surface or Bézier patch.
fn seen_at(scene: &Scene, aovs: &Aovs, (x, y): (i64, i64)) -> Option<([usize; 2], DVec2)> {
    let (width, height) = (i64::from(aovs.size.0), i64::from(aovs.size.1));
    let is_inside = (0..width).contains(&x) && (0..height).contains(&y);
    let at = is_inside.then_some((y * width + x) as usize)?;
    let [u, v, patch, drawn] = aovs.uv[at].map(f64::from);
    let mut first = 0;
    for (number, surface) in scene.surfaces.iter().enumerate().filter(|_| drawn > 0.0) {
        let before = first;
        first += surface.patches().len();
        if patch < first as f64 {
            let of_patch = if surface.nurbs().is_some() { 0 } else { patch as usize - before };
            let [low, high] = surface.domain();
            return Some(([number, of_patch], (dvec2(u, v) - low) / (high - low)));
        }
    }
    None
}

/// How many lit pixels are far from all lines, and how many places of visible lines have no light, of how many.
fn faults(scene: &Scene, image: &Image, aovs: &Aovs, lines: &[Vec<Place>]) -> [usize; 3] {
    let width = scene.settings.isolines.unwrap().width.pixels();
    // Coverage ends half a pixel beyond the line. At a silhouette, a line may be that much longer.
    let allowed = allowed(lines, image.dimensions(), 0.5 * width + 0.5 + 1.0);
    let stray = image
        .enumerate_pixels()
        .filter(|(x, y, _)| light(image, *x, *y) > 0.02)
        .filter(|(x, y, _)| !allowed[(y * image.width() + x) as usize])
        .count();
    let (mut missing, mut seen) = (0, 0);
    for place in lines.iter().flatten().filter(|place| place.facing > 0.3 && place.depth > 0.0) {
        let (x, y) = (place.pixel.x.floor() as i64, place.pixel.y.floor() as i64);
        let around = [(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)];
        // Only what is seen as this place of the surface all around.
        let is_own = around.into_iter().all(|(dx, dy)| {
            seen_at(scene, aovs, (x + dx, y + dy)).is_some_and(|(surface, share)| {
                surface == place.surface && (share - place.share).abs().max_element() < 0.02
            })
        });
        if is_own {
            seen += 1;
            // The middle of the pixel is at most 0.71 px from the line.
            let least = (0.5 * width + 0.5 - 0.75).min(1.0) - 0.01;
            missing += usize::from(light(image, x as u32, y as u32) < least);
        }
    }
    [stray, missing, seen]
}

#[test]
fn nothing_is_drawn_beside_the_lines_and_none_has_a_break() {
    let mut stage = Stage::new(uvec2(320, 240));
    let mut random = Random(11);
    let names = [
        "nurbs-sphere-and-torus",
        "nurbs-periodic-torus",
        "tess-pole",
        "tess-collapsed-edge",
        "tess-cylinder-and-cone",
        "tess-both-tangents-zero",
        "tess-flat",
        "tess-inside",
        "tess-more-than-64",
        "tess-near-plane",
        "tess-offset-1e6",
        "tess-orthographic",
        "tess-rational-sphere",
    ];
    let files = ["surfaces/teapot.bpt", "models/flange.ffm", "models/blade.ffm"];
    let mut wrong = Vec::new();
    let scenes = names.iter().map(|name| format!("scenes/stability/{name}.toml"));
    for name in scenes.chain(files.map(str::to_owned)) {
        let own = load(&root().join("resources").join(&name));
        let (mut stray, mut missing, mut seen) = (0, 0, 0);
        for view in 0..4 {
            let width = [2.0, 3.0][view % 2];
            let mut scene = in_black(own.clone(), isolines(4, width));
            scene.settings.normals = [Normals::Vertex, Normals::Pixel][view / 2];
            if view > 0 {
                // From another side, and nearer.
                let camera = scene.framed(stage.aspect());
                let (eye, target) = (camera.eye(), camera.target());
                let mut turn = || 2.0 * random.unit() - 1.0;
                let direction = dvec3(turn(), turn(), turn()).normalize();
                let distance = eye.distance(target) * [1.0, 0.6, 0.4][view - 1];
                let up = direction.any_orthonormal_vector();
                let lens = camera.lens();
                let eye = target + distance * direction;
                scene.camera = Camera::new(eye, target, up, lens).ok();
            }
            let frame = stage.frame(&scene);
            let lines = true_lines(&scene, &frame, 2000);
            let mut prepared = stage.prepared(&scene);
            let image = stage.picture(&mut prepared, &frame);
            let aovs = stage.aovs(&mut prepared, &frame);
            let found = faults(&scene, &image, &aovs, &lines);
            if let Some(folder) = std::env::var_os("ISO").filter(|_| found[0] + found[1] > 0) {
                eprintln!("{name}, view {view}: {found:?}");
                let file = format!("{}-{view}.png", name.replace('/', "-"));
                image.save(Path::new(&folder).join(file)).unwrap();
            }
            stray += found[0];
            missing += found[1];
            seen += found[2];
        }
        if stray > 4 || missing > 0 || seen < 1_000 {
            wrong.push(format!("{name}: {stray} stray, {missing} of {seen} missing"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn a_line_has_its_width_whatever_the_samples() {
    let mut stage = Stage::new(uvec2(200, 160));
    let corners = [[0.0, 0.0], [2.0, 0.2], [-0.3, 1.5], [1.7, 1.7]];
    let points = corners.map(|[x, y]| DVec4::new(x, y, 0.0, 1.0)).to_vec();
    let surface = Surface::of_patch(Degree::new(1, 1).unwrap(), points).unwrap();
    for (width, samples) in [(0.5, 1), (1.0, 1), (1.0, 4), (2.5, 1), (2.5, 64)] {
        let scene = in_black(scene_of(vec![surface.clone()]), isolines(1, width));
        let lines = true_lines(&scene, &stage.frame(&scene), 600);
        let image = picture(&mut stage, &scene, samples);
        assert!(check_places("plane", &image, &lines, width) > 8);
    }
}

#[test]
fn everything_else_stays_as_it_is() {
    let mut stage = Stage::new(uvec2(240, 180));
    let mut scene = waves();
    scene.settings.background = [0.0; 4];
    let circle = Circle::new(dvec2(0.4, 0.5), 0.3).unwrap();
    scene.surfaces[0].trims = Trims { circles: vec![circle], ..Trims::default() };
    let shown = Some(isolines(5, 2.0));
    for samples in [1, 4] {
        let without = picture(&mut stage, &scene, samples);
        let mut lined = scene.clone();
        lined.settings.isolines = shown;
        let with = picture(&mut stage, &lined, samples);
        let alpha = |image: &Image| image.pixels().map(|pixel| pixel.0[3]).collect::<Vec<_>>();
        assert_eq!(alpha(&without), alpha(&with), "lines are cut as the surface is");
        assert_ne!(without, with);
    }
    let mut prepared = stage.prepared(&scene);
    let mut frame = stage.frame(&scene);
    let mut all = |lines: Option<Isolines>, wireframe: bool, tessellation: Tessellation| {
        frame.settings = scene.settings;
        (frame.settings.isolines, frame.settings.wireframe) = (lines, wireframe);
        frame.settings.tessellation = tessellation;
        let image = stage.picture(&mut prepared, &frame);
        let aovs = format!("{:?}", stage.aovs(&mut prepared, &frame));
        let triangles = format!("{:?}", stage.triangles(&mut prepared, &frame));
        (image, aovs, triangles)
    };
    let within = scene.settings.tessellation;
    let level = Tessellation::Level(TessLevel::new(3).unwrap());
    let (plain, lined) = (all(None, false, within), all(shown, false, within));
    assert!(plain.1 == lined.1 && plain.2 == lined.2 && plain.0 != lined.0);
    assert!(all(None, false, within) == plain, "off again");
    assert!(all(None, true, within) == all(shown, true, within), "a wireframe has none");
    assert_ne!(all(None, false, level).0, all(shown, false, level).0);
}

#[test]
fn the_setting_is_written_and_read_again() {
    let path = Path::new("scene.toml");
    let patch = "[[surface]]\ncontrol_points = \"default\"\ncolor = [0, 0, 0]\n";
    let read = |lines: &str| Scene::from_toml(&format!("[render]\n{lines}\n{patch}"), path);
    let default = Isolines::default();
    let count = |count: i64| IsolineCount::new(count).unwrap();
    let own = Isolines {
        count: count(1000),
        width: LineWidth::new(0.1).unwrap(),
        color: [1.0, 0.5, 0.0],
    };
    for (text, expected) in [
        ("", None),
        ("isolines = 0", None),
        ("isolines = 1", Some(Isolines { count: count(1), ..default })),
        ("isolines = {}", Some(default)),
        ("isolines = { count = 1000, width = 0.1, color = [1, 0.5, 0] }", Some(own)),
    ] {
        let scene = read(text).unwrap();
        assert_eq!(scene.settings.isolines, expected, "{text}");
        let again = Scene::from_toml(&scene.to_toml(path).unwrap().text, path).unwrap();
        assert_eq!(again.settings, scene.settings);
    }
    for (wrong, named) in [
        ("isolines = -1", "0 to 1000"),
        ("isolines = 1001", "0 to 1000"),
        ("isolines = 1e9", "0 to 1000"),
        ("isolines = 99999999999", "0 to 1000"),
        ("isolines = 2.5", "0 to 1000"),
        ("isolines = true", "0 to 1000"),
        ("isolines = { count = -3 }", "0 to 1000"),
        ("isolines = { width = 0 }", "width"),
        ("isolines = { color = [0, 0, -1] }", "color"),
        ("isolines = { colour = [0, 0, 1] }", "count, width and color"),
    ] {
        let error: Error = read(wrong).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("scene.toml:2") && text.contains(named), "{wrong}: {text}");
    }
}
