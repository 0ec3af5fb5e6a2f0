//! The studio's light and the thesis' lamps.

use std::collections::BTreeSet;
use std::path::Path;

use freeform_surface::inspect::programs::Sources;
use freeform_surface::inspect::reference;
use freeform_surface::{
    Camera, Image, Lens, Light, Method, Paint, RenderSettings, Scene, Shading, TessLevel,
    Tessellation,
};
use glam::{DMat4, DVec3, UVec2, dvec3};

use crate::harness::patches::is_long;
use crate::harness::{
    Stage, assert_same, backends, difference, figures, load, render, render_with, root,
};
use crate::leaks::cube;
use crate::models::cad_files;

const SIZE: UVec2 = UVec2::new(160, 120);

fn teapot() -> Scene {
    load(&root().join("resources/surfaces/teapot.bpt"))
}

/// The fraction of pixels of which a channel differs by more than 8.
fn differing(a: &Image, b: &Image) -> f64 {
    let differs = |(a, b): (&image::Rgba<u8>, &image::Rgba<u8>)| {
        a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 8)
    };
    let wrong = a.pixels().zip(b.pixels()).filter(|pair| differs(*pair)).count();
    wrong as f64 / a.pixels().len() as f64
}

fn brightness(image: &Image) -> f64 {
    let sum: u64 = image.pixels().map(|pixel| u64::from(pixel.0[1])).sum();
    sum as f64 / image.pixels().len() as f64
}

#[test]
fn a_model_looks_the_same_at_any_size_and_place() {
    for method in [Method::Exact, Method::Thesis] {
        let mut scene = teapot();
        scene.settings.method = method;
        let plain = render(&scene, SIZE, backends()[0]);
        // The picture is neither black nor overexposed.
        assert!((60.0..180.0).contains(&brightness(&plain)), "{}", brightness(&plain));
        for (scale, offset) in
            [(1e-6, 0.0), (1e-3, 0.0), (1e3, 0.0), (1e6, 0.0), (1.0, 1e7), (1e-3, 1e3), (1e6, 1e7)]
        {
            let mut moved = scene.clone();
            let place = dvec3(offset, -offset, 0.5 * offset);
            for surface in &mut moved.surfaces {
                surface.transform =
                    DMat4::from_translation(place) * DMat4::from_scale(DVec3::splat(scale));
            }
            let picture = render(&moved, SIZE, backends()[0]);
            let share = differing(&plain, &picture);
            assert!(share < 0.01, "{method:?} × {scale} + {offset}: {share}");
        }
    }
}

#[test]
fn the_studio_lights_whatever_names_no_light() {
    let light = |text: &str| {
        let text = format!("{text}\n[[surface]]\ncontrol_points = \"default\"\n");
        Scene::from_toml(&text, Path::new("x.toml")).map(|scene| scene.settings.light)
    };
    let camera = "[camera]\neye = [0, 1, 2]\ntarget = [0, 0, 0]\n";
    assert_eq!(light("").unwrap(), Light::Studio);
    assert_eq!(light(camera).unwrap(), Light::Studio);
    for own in Light::ALL {
        let table = format!("{camera}[render]\nlight = \"{}\"", own.name());
        assert_eq!(light(&table).unwrap(), own);
    }
    let error = light("[render]\nlight = \"sun\"").unwrap_err().to_string();
    assert!(error.contains("x.toml:2: ") && error.contains("\"studio\" or \"thesis\""), "{error}");
    for bare in ["surfaces/teapot.bpt", "meshes/cube.obj", "models/bracket.ffm"] {
        assert_eq!(load(&root().join("resources").join(bare)).settings.light, Light::Studio);
    }
    // The thesis' and the report's own scenes keep the thesis' lamps.
    assert_eq!(Scene::listing16().settings.light, Light::Thesis);
    for (name, path) in figures() {
        assert_eq!(load(&path).settings.light, Light::Thesis, "{name}");
    }
}

/// The bump of figure 14 in three colours, from its own camera, without perspective, and from below. The first colour
/// is so dark that the formula of sRGB is linear there.
fn bumps(light: Light, method: Method) -> Vec<Scene> {
    let mut scene = load(&root().join("resources/scenes/thesis/fig14.toml"));
    scene.surfaces.iter_mut().for_each(|surface| surface.trims = Default::default());
    scene.settings = RenderSettings {
        light,
        method,
        control_points: false,
        tessellation: Tessellation::Level(TessLevel::new(16).unwrap()),
        ..scene.settings
    };
    let own = scene.camera.unwrap();
    let flat = Lens::Orthographic { height: 1.4 };
    let [from_above, from_below] = [own.eye(), own.eye() * DVec3::new(1.0, -1.0, 1.0)]
        .map(|eye| Camera::new(eye, own.target(), own.up(), flat).unwrap());
    let from_below_near =
        Camera::new(from_below.eye(), own.target(), own.up(), own.lens()).unwrap();
    [(own, 0.5), (from_above, 0.03), (from_below_near, 1.0)]
        .map(|(camera, grey)| {
            let mut scene = Scene { camera: Some(camera), ..scene.clone() };
            scene.surfaces[0].paint = Paint::Color([0.03, grey, 0.9]);
            scene
        })
        .to_vec()
}

#[test]
fn the_lights_are_those_of_the_reference() {
    for light in Light::ALL {
        for method in [Method::Exact, Method::Thesis] {
            for (i, scene) in bumps(light, method).iter().enumerate() {
                let expected = reference::render(scene, SIZE, method).unwrap();
                for backend in backends() {
                    let actual = render(scene, SIZE, backend);
                    let name = format!("light-{}-{method:?}-{i}-{backend}", light.name());
                    assert_same(&name, &expected.image, &actual, &expected.edge_band(1.5), 2);
                }
            }
        }
    }
}

#[test]
fn a_wrong_studio_does_not_pass() {
    const SRGB: &str = "common/srgb.glsl";
    const STUDIO: &str = "common/studio.glsl";
    let scenes = bumps(Light::Studio, Method::Exact);
    let expected: Vec<_> = (scenes.iter())
        .map(|scene| reference::render(scene, SIZE, Method::Exact).unwrap())
        .collect();
    for (file, right, wrong) in [
        (SRGB, "srgb / 12.92", "srgb / 4.0"),
        (SRGB, "vec3(2.4)", "vec3(2.3)"),
        (SRGB, "12.92 * light", "8.0 * light"),
        (SRGB, "1.0 / 2.4", "1.0 / 2.3"),
        (SRGB, "- 0.055, g", "- 0.04, g"),
        (STUDIO, "vec3(-2.0, 3.0, 3.0)", "vec3(2.0, 3.0, 3.0)"),
        (STUDIO, "FILL), 0.0)", "RIM), 0.0)"),
        (STUDIO, "0.12 * max(dot(normal, RIM)", "0.2 * max(dot(normal, RIM)"),
        (STUDIO, "0.06 * normal.y", "0.02 * normal.y"),
        (STUDIO, "0.3 * gloss", "0.2 * gloss"),
        (STUDIO, "-1.0 : 1.0", "1.0 : 1.0"),
        (STUDIO, "eye.w * position", "position"),
    ] {
        let sources = Sources::default().with_edit(file, right, wrong);
        let mut stage = Stage::with_sources(backends()[0], SIZE, sources);
        let wrong_pixels: usize = std::iter::zip(&scenes, &expected)
            .map(|(scene, expected)| {
                let left_out = expected.edge_band(1.5);
                difference(&expected.image, &stage.render(scene), &left_out, 2).unwrap().wrong
            })
            .sum();
        assert!(wrong_pixels > 20, "{file}, {wrong}: {wrong_pixels}");
    }
}

/// The colours of a picture without its background.
fn colors(image: &Image) -> BTreeSet<[u8; 3]> {
    let covered = image.pixels().filter(|pixel| pixel.0[3] > 0);
    covered.map(|pixel| [0, 1, 2].map(|channel| pixel.0[channel])).collect()
}

/// A cube without perspective has three colours. Those of a mesh are the same, and so are those of the strokes along the
/// edges of a CAD model, without its faces.
#[test]
fn faces_meshes_and_strokes_are_lit_alike() {
    let model = Scene::from_model(cube(0.0), Path::new("cube.ffm")).unwrap();
    let mesh = load(&root().join("resources/meshes/cube.obj"));
    let [model, mesh] = [model, mesh].map(|mut scene| {
        let lens = Lens::Orthographic { height: 1.0 };
        let from = Camera::new(DVec3::new(3.0, 4.0, 2.0), DVec3::ZERO, DVec3::Y, lens).unwrap();
        scene.camera = Some(scene.fitted(&from, 1.0));
        scene.settings.background = [0.0; 4];
        in_grey(&mut scene);
        scene
    });
    let size = UVec2::splat(120);
    let faces = colors(&render(&model, size, backends()[0]));
    assert_eq!(faces.len(), 3, "{faces:?}");
    let without_faces =
        Sources::default().with_edit("exact/surface.frag", "vec3 upright", "discard; vec3 upright");
    let strokes = colors(&render_with(&model, size, backends()[0], without_faces));
    for (name, other) in
        [("mesh", colors(&render(&mesh, size, backends()[0]))), ("strokes", strokes)]
    {
        assert!(other.len() >= 2, "{name}: {other:?}");
        for color in other {
            let is_near = |own: &[u8; 3]| (0..3).all(|i| own[i].abs_diff(color[i]) <= 1);
            assert!(faces.iter().any(is_near), "{name}: {color:?}, not {faces:?}");
        }
    }
}

/// Everything is lit and of one grey.
fn in_grey(scene: &mut Scene) {
    let grey = Paint::Color([0.5; 3]);
    for surface in &mut scene.surfaces {
        (surface.paint, surface.shading) = (grey.clone(), Shading::Phong);
    }
    for mesh in &mut scene.meshes {
        mesh.paint = grey.clone();
        mesh.materials.clear();
        mesh.shading = Shading::Phong;
    }
}

/// The directions to the faces, edges and corners of a cube.
fn cube_directions() -> impl Iterator<Item = DVec3> {
    let axis = || [-1.0, 0.0, 1.0].into_iter();
    axis()
        .flat_map(move |x| axis().flat_map(move |y| axis().map(move |z| DVec3::new(x, y, z))))
        .filter(|direction| *direction != DVec3::ZERO)
}

/// Grey models from 26 directions, every other one without perspective: how many pixels are covered, how many of them are
/// nearly black or white, and how many levels of brightness there are.
fn range_of(stage: &mut Stage, scene: &Scene) -> (usize, usize, usize) {
    let mut scene = scene.clone();
    in_grey(&mut scene);
    scene.settings =
        RenderSettings { background: [0.0; 4], isolines: None, edges: None, ..scene.settings };
    let mut prepared = stage.prepared(&scene);
    let (mut covered, mut lost, mut levels) = (0, 0, BTreeSet::new());
    for (i, direction) in cube_directions().enumerate() {
        let lens = match i % 2 {
            0 => Lens::Perspective { fov_y_radians: 0.7 },
            _ => Lens::Orthographic { height: 1.0 },
        };
        let up = if direction.x == 0.0 && direction.z == 0.0 { DVec3::X } else { DVec3::Y };
        let camera = Camera::new(direction, DVec3::ZERO, up, lens).unwrap();
        scene.camera = Some(scene.fitted(&camera, stage.aspect()));
        let picture = stage.picture(&mut prepared, &stage.frame(&scene));
        for pixel in picture.pixels().filter(|pixel| pixel.0[3] > 0) {
            // Grey stays grey.
            let level = pixel.0[1];
            assert!(pixel.0[0].abs_diff(level) <= 1 && pixel.0[2].abs_diff(level) <= 1);
            covered += 1;
            lost += usize::from(!(8..=250).contains(&level));
            levels.insert(level);
        }
    }
    (covered, lost, levels.len())
}

/// All that is in the repository and names no light, and with the long tests, real CAD files.
#[test]
fn no_model_is_black_or_burnt_out_or_flat_in_the_studio() {
    let mut stage = Stage::new(UVec2::new(96, 72));
    let mut folders: Vec<_> = ["scenes/gallery", "models", "meshes", "surfaces"]
        .map(|name| root().join("resources").join(name))
        .to_vec();
    folders.extend(cad_files().filter(|_| is_long()));
    let mut count = 0;
    for path in folders.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap()) {
        let path = path.unwrap().path();
        if path.extension().is_none_or(|extension| extension == "json" || extension == "md") {
            continue;
        }
        let scene = load(&path);
        if scene.settings.light != Light::Studio {
            continue;
        }
        let (covered, lost, levels) = range_of(&mut stage, &scene);
        let name = path.file_name().unwrap().display();
        println!("{name}: {covered} pixels, {lost} black or white, {levels} levels");
        assert!(covered > 5_000, "{name}: {covered}");
        assert!(lost * 100 <= covered, "{name}: {lost} of {covered}");
        // In a view without perspective, the up to three faces of a cube that are seen have one level each.
        let least = if path.ends_with("cube.obj") { 20 } else { 40 };
        assert!(levels >= least, "{name}: {levels}");
        count += 1;
    }
    assert!(count >= 14, "{count}");
}

/// Back faces are lit like front faces: a patch is turned around.
#[test]
fn both_sides_are_lit_alike() {
    let mut scene = teapot();
    let plain = render(&scene, SIZE, backends()[0]);
    for surface in &mut scene.surfaces {
        // Reversing the rows reverses the normals.
        let degree = surface.degree();
        let side = degree.columns();
        let points: Vec<_> = surface
            .control_points()
            .chunks(degree.points())
            .flat_map(|patch| patch.chunks(side).rev().flatten().copied())
            .collect();
        *surface = freeform_surface::Surface::new(degree, points).unwrap();
    }
    let turned = render(&scene, SIZE, backends()[0]);
    assert!(differing(&plain, &turned) < 0.01, "{}", differing(&plain, &turned));
}
