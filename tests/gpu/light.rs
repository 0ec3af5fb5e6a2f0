//! The lights of the world and of the camera.

use std::path::Path;

use freeform_surface::inspect::reference;
use freeform_surface::{Image, Light, Method, Scene, TessLevel, Tessellation};
use glam::{DMat4, DVec3, UVec2, dvec3};

use crate::harness::{assert_same, backends, load, render, root};

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
fn bare_files_and_framed_scenes_are_lit_from_the_camera() {
    let light = |text: &str| {
        let text = format!("{text}\n[[surface]]\ncontrol_points = \"default\"\n");
        Scene::from_toml(&text, Path::new("x.toml")).map(|scene| scene.settings.light)
    };
    let camera = "[camera]\neye = [0, 1, 2]\ntarget = [0, 0, 0]\n";
    assert_eq!(light("").unwrap(), Light::Camera);
    assert_eq!(light(camera).unwrap(), Light::World);
    assert_eq!(light("[render]\nlight = \"world\"").unwrap(), Light::World);
    assert_eq!(light(&format!("{camera}[render]\nlight = \"camera\"")).unwrap(), Light::Camera);
    let error = light("[render]\nlight = \"sun\"").unwrap_err().to_string();
    assert!(error.contains("x.toml:2: ") && error.contains("\"camera\" or \"world\""), "{error}");
    assert_eq!(teapot().settings.light, Light::Camera);
    let cube = load(&root().join("resources/meshes/cube.obj"));
    assert_eq!(cube.settings.light, Light::Camera);
    // The thesis' own scenes keep the thesis' lights.
    assert_eq!(Scene::listing16().settings.light, Light::World);
    for entry in std::fs::read_dir(root().join("resources/scenes/thesis")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "toml") {
            assert_eq!(load(&path).settings.light, Light::World, "{}", path.display());
        }
    }
}

#[test]
fn the_lights_are_those_of_the_reference() {
    for light in [Light::World, Light::Camera] {
        for method in [Method::Exact, Method::Thesis] {
            let mut scene = load(&root().join("resources/scenes/thesis/fig14.toml"));
            scene.surfaces.iter_mut().for_each(|surface| surface.trims = Default::default());
            scene.settings.light = light;
            scene.settings.method = method;
            scene.settings.tessellation = Tessellation::Level(TessLevel::new(16).unwrap());
            let expected = reference::render(&scene, SIZE, method).unwrap();
            for backend in backends() {
                let actual = render(&scene, SIZE, backend);
                let name = format!("light-{light:?}-{method:?}-{backend}");
                assert_same(&name, &expected.image, &actual, &expected.edge_band(1.5), 2);
            }
        }
    }
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
