//! Colours of meshes on the screen: materials, vertex colours, and repeating textures.

use std::path::Path;
use std::sync::Arc;

use freeform_surface::inspect::reference;
use freeform_surface::{
    Camera, CreaseAngle, Degree, Image, Lens, Material, Mesh, MeshModel, Method, Paint, Scene,
    Shading, Smoothing, Surface, TessLevel, Tessellation,
};
use glam::{DVec3, UVec2, dvec2, dvec3};

use crate::harness::{backends, render};

const SIZE: UVec2 = UVec2::new(64, 64);

/// A scene of a mesh over the unit square, seen from above so that it fills the picture.
fn scene(mesh: Mesh, smoothing: Smoothing) -> Scene {
    let middle = dvec3(0.5, 0.5, 0.0);
    let lens = Lens::Orthographic { height: 1.0 };
    let mut model = MeshModel::new(mesh, smoothing);
    model.shading = Shading::Unlit;
    model.paint = Paint::Color([1.0; 3]);
    let mut scene = Scene {
        surfaces: Vec::new(),
        meshes: vec![model],
        camera: Some(Camera::new(middle + DVec3::Z, middle, DVec3::Y, lens).unwrap()),
        ..Scene::listing16()
    };
    scene.settings.tessellation = Tessellation::Level(TessLevel::new(5).unwrap());
    scene
}

fn read(text: &str) -> Mesh {
    Mesh::read_obj(text.as_bytes(), Path::new("x.obj"), CreaseAngle::default()).unwrap()
}

const SMOOTHINGS: fn() -> [Smoothing; 3] =
    || [Smoothing::None, Smoothing::Pn, Smoothing::Phong(Default::default())];

/// Compares every pixel with the expected colour of its place.
fn check(scene: &Scene, color: impl Fn(glam::DVec2) -> Option<DVec3>) {
    for backend in backends() {
        let picture = render(scene, SIZE, backend);
        let mut compared = 0;
        for (x, y, pixel) in picture.enumerate_pixels() {
            let place = (dvec2(f64::from(x), f64::from(SIZE.y - 1 - y)) + 0.5) / SIZE.as_dvec2();
            let Some(expected) = color(place) else { continue };
            for (value, expected) in pixel.0.iter().zip(expected.to_array()) {
                let off = (f64::from(*value) - 255.0 * expected).abs();
                assert!(off <= 1.0, "{backend} {x} {y}: {pixel:?}, expected {expected}");
            }
            compared += 1;
        }
        assert!(compared > 800, "{compared}");
    }
}

#[test]
fn colors_of_corners_are_mixed_linearly() {
    let text =
        "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1 4//1\n";
    for smoothing in SMOOTHINGS() {
        let mut scene = scene(read(text), smoothing);
        let colors = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
        let at = |place: glam::DVec2| {
            if place.y < place.x {
                colors[0] * (1.0 - place.x) + colors[1] * (place.x - place.y) + colors[2] * place.y
            } else {
                colors[0] * (1.0 - place.y) + colors[2] * place.x + colors[3] * (place.y - place.x)
            }
        };
        check(&scene, |place| Some(at(place)));
        // The mesh's own colour multiplies them.
        scene.meshes[0].paint = Paint::Color([0.5, 1.0, 0.0]);
        check(&scene, |place| Some(at(place) * dvec3(0.5, 1.0, 0.0)));
    }
}

#[test]
fn materials_color_their_triangles() {
    // 16 strips of two triangles.
    let mut text = String::from("vn 0 0 1\n");
    for i in 0..=16 {
        text += &format!("v {0} 0 0\nv {0} 1 0\n", f64::from(i) / 16.0);
    }
    for i in 0..16 {
        let [a, b, c, d] = [2 * i + 1, 2 * i + 3, 2 * i + 4, 2 * i + 2];
        text += &format!("f {a}//1 {b}//1 {c}//1 {d}//1\n");
    }
    for smoothing in SMOOTHINGS() {
        let mut scene = scene(read(&text), smoothing);
        let paint = |color| Paint::Color(color);
        let material =
            |color, triangles| Material { name: String::new(), paint: paint(color), triangles };
        scene.meshes[0].materials =
            vec![material([1.0, 0.0, 0.0], 2..10), material([0.0, 0.0, 1.0], 20..32)];
        check(&scene, |place| {
            Some(match (16.0 * place.x) as usize {
                1..5 => DVec3::X,
                10..16 => DVec3::Z,
                _ => DVec3::ONE,
            })
        });
    }
}

#[test]
fn pictures_repeat_on_meshes_and_end_on_surfaces() {
    let picture = Image::from_fn(8, 8, |x, y| {
        image::Rgba([if x < 4 { 255 } else { 0 }, if y < 4 { 255 } else { 0 }, 0, 255])
    });
    let picture = Arc::new(picture);
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt -1 0\nvt 2 0\nvt 2 3\nvt -1 3\nvn 0 0 1\n\
                f 1/1/1 2/2/1 3/3/1 4/4/1\n";
    for smoothing in SMOOTHINGS() {
        let mut scene = scene(read(text), smoothing);
        scene.meshes[0].paint = Paint::Texture(Arc::clone(&picture));
        check(&scene, |place| {
            let at = 3.0 * place;
            let [x, y] = [at.x.rem_euclid(1.0), at.y.rem_euclid(1.0)];
            // Between texels and at smaller mipmap levels, the colours are mixed.
            let near =
                [x, y].iter().any(|at| [0.0, 0.5, 1.0].iter().any(|edge| (at - edge).abs() < 0.13));
            let red = f64::from(x < 0.5);
            let green = f64::from(y > 0.5);
            (!near).then_some(dvec3(red, green, 0.0))
        });
    }
}

#[test]
fn what_is_transparent_is_a_hole() {
    // A texture whose left half is opaque red and whose right half is transparent, except for a stripe.
    let picture = Image::from_fn(16, 16, |x, y| {
        let alpha = if x < 8 || y < 4 { 255 } else { 40 };
        image::Rgba([255, 0, 0, alpha])
    });
    let paint = Paint::Texture(Arc::new(picture));
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n\
                f 1/1/1 2/2/1 3/3/1 4/4/1\n";
    let points = |side: usize| {
        let at = move |i: usize| i as f64 / (side - 1) as f64;
        (0..side * side)
            .map(move |i| glam::DVec4::new(at(i % side), at(i / side), 0.0, 1.0))
            .collect()
    };
    for degree in [None, Some(Degree::CUBIC), Some(Degree::QUARTIC)] {
        for method in [Method::Exact, Method::Thesis] {
            let mut scene = scene(read(text), Smoothing::None);
            scene.settings.method = method;
            scene.settings.background = [0.0, 0.0, 1.0, 1.0];
            scene.meshes[0].paint = paint.clone();
            if let Some(degree) = degree {
                let mut surface = Surface::new(degree, points(degree.columns())).unwrap();
                surface.paint = paint.clone();
                surface.shading = Shading::Unlit;
                scene.surfaces.push(surface);
                scene.meshes.clear();
            }
            check(&scene, |place| {
                let near = (place.x - 0.5).abs() < 0.05 || (place.y - 0.75).abs() < 0.05;
                // Textures of meshes repeat: at their borders, texels of the opposite side are mixed in.
                let border = place.min(1.0 - place).min_element() < 0.04;
                let there = place.x < 0.5 || place.y > 0.75;
                (!near && !border).then_some(if there { DVec3::X } else { DVec3::Z })
            });
            if degree.is_some() {
                let expected = reference::render(&scene, SIZE, method).unwrap().image;
                let picture = render(&scene, SIZE, backends()[0]);
                let wrong = expected.pixels().zip(picture.pixels()).filter(|(a, b)| a != b).count();
                assert!(wrong < 130, "{degree:?} {method:?}: {wrong} differ from the reference");
            }
        }
    }
}
