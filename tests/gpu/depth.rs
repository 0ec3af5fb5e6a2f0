//! Nearer surfaces hide farther ones over all ranges of depth: at distances from 1 to 10⁷, and with differences
//! down to 10⁻⁵ of the distance.

use freeform_surface::inspect::measure::measure;
use freeform_surface::inspect::reference::coverage;
use freeform_surface::{
    Camera, Corner, CreaseAngle, Degree, Frame, Lens, Mesh, MeshModel, Method, Paint, Samples,
    Scene, Shading, Smoothing, Surface, TessLevel, Tessellation,
};
use glam::{DMat4, DVec2, DVec3, DVec4, UVec2, dvec3};

use crate::harness::Stage;
use crate::harness::{backends, render};

const SIZE: UVec2 = UVec2::new(60, 40);

/// The pipeline that draws.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Drawer {
    Exact,
    Thesis,
    Report,
    Mesh(Smoothing),
}

const DRAWERS: [Drawer; 5] = [
    Drawer::Exact,
    Drawer::Thesis,
    Drawer::Report,
    Drawer::Mesh(Smoothing::None),
    Drawer::Mesh(Smoothing::Pn),
];

/// A plane in front of the eye at the origin, which looks along −z. It is as wide as its distance, and is
/// tilted by a fraction of it.
fn plane(drawer: Drawer, distance: f64, tilt: f64, color: [f32; 3], scene: &mut Scene) {
    let place = |u: f64, v: f64| {
        let [x, y] = [u, v].map(|at| (2.0 * at - 1.0) * distance);
        dvec3(x, y, -distance + tilt * x)
    };
    if let Drawer::Mesh(smoothing) = drawer {
        let corner = |position| Corner { position, normal: 0, coordinate: Corner::NONE };
        let mesh = Mesh::new(
            vec![place(0.0, 0.0), place(1.0, 0.0), place(1.0, 1.0), place(0.0, 1.0)],
            vec![DVec3::Z],
            Vec::new(),
            vec![[0, 1, 2].map(corner), [0, 2, 3].map(corner)],
            CreaseAngle::default(),
        );
        let mut model = MeshModel::new(mesh.unwrap(), smoothing);
        model.paint = Paint::Color(color);
        model.shading = Shading::Unlit;
        scene.meshes.push(model);
        return;
    }
    let degree = if drawer == Drawer::Report { Degree::QUARTIC } else { Degree::CUBIC };
    let side = degree.columns();
    let at = |i: usize| i as f64 / (side - 1) as f64;
    let points: Vec<DVec4> =
        (0..side * side).map(|i| place(at(i % side), at(i / side)).extend(1.0)).collect();
    let mut surface = Surface::new(degree, points).unwrap();
    surface.paint = Paint::Color(color);
    surface.shading = Shading::Unlit;
    scene.surfaces.push(surface);
}

fn empty(drawer: Drawer, lens: Lens) -> Scene {
    let camera = Camera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, lens).unwrap();
    let mut scene = Scene { surfaces: Vec::new(), camera: Some(camera), ..Scene::listing16() };
    scene.settings.method = match drawer {
        Drawer::Thesis | Drawer::Report => Method::Thesis,
        _ => Method::Exact,
    };
    scene.settings.tessellation = Tessellation::Level(TessLevel::new(4).unwrap());
    scene
}

const PERSPECTIVE: Lens = Lens::Perspective { fov_y_radians: 1.0 };
const RED: [f32; 3] = [1.0, 0.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

#[test]
fn of_two_planes_the_nearer_is_seen() {
    for drawer in DRAWERS {
        for far in [1.0, 37.0, 1e3, 1e5, 1e7] {
            for near in [1.0, 0.3 * far, far * (1.0 - 1e-5)] {
                if near >= far {
                    continue;
                }
                for turned in [false, true] {
                    // A third plane at distance 1, outside the picture, keeps the clip planes far apart.
                    let mut scene = empty(drawer, PERSPECTIVE);
                    let planes = [(near, RED), (far, BLUE)];
                    let order = if turned { [1, 0] } else { [0, 1] };
                    for i in order {
                        plane(drawer, planes[i].0, 0.05, planes[i].1, &mut scene);
                    }
                    plane(drawer, 1.0, 0.0, BLUE, &mut scene);
                    let aside = DMat4::from_translation(dvec3(2.2, 0.0, 0.0));
                    if let Some(model) = scene.meshes.last_mut() {
                        model.transform = aside;
                    } else {
                        scene.surfaces.last_mut().unwrap().transform = aside;
                    }
                    for backend in backends() {
                        let picture = render(&scene, SIZE, backend);
                        let wrong =
                            picture.pixels().filter(|pixel| pixel.0 != [255, 0, 0, 255]).count();
                        assert_eq!(wrong, 0, "{drawer:?} {near} before {far}, {turned}");
                    }
                }
            }
        }
    }
}

#[test]
fn several_samples_and_parallel_views_keep_the_order() {
    for drawer in DRAWERS {
        for (lens, samples) in
            [(PERSPECTIVE, 4), (PERSPECTIVE, 8), (Lens::Orthographic { height: 1.0 }, 1)]
        {
            let mut scene = empty(drawer, lens);
            scene.settings.samples = Samples::new(samples).unwrap();
            plane(drawer, 1e4 * (1.0 - 1e-4), 0.0, RED, &mut scene);
            plane(drawer, 1e4, 0.0, BLUE, &mut scene);
            let picture = render(&scene, SIZE, backends()[0]);
            assert!(picture.pixels().all(|pixel| pixel.0 == [255, 0, 0, 255]), "{drawer:?}");
        }
    }
}

/// A plate close to the eye in front of a distant wall: each method draws both, and a picture without the plate
/// counts as wrong.
#[test]
fn a_plate_close_to_the_eye_is_drawn_and_missed_where_it_is_not() {
    let mut stage = Stage::new(SIZE);
    for (near, far) in [(0.05, 600.0), (1.0, 1e7), (1e-3, 1.0)] {
        for method in [Method::Exact, Method::Thesis] {
            let mut scene = empty(Drawer::Exact, PERSPECTIVE);
            scene.settings.method = method;
            plane(Drawer::Exact, near, 0.0, RED, &mut scene);
            // Half as wide as the picture.
            let half = DMat4::from_scale(dvec3(0.25, 0.25, 1.0));
            scene.surfaces[0].transform = half;
            plane(Drawer::Exact, far, 0.0, BLUE, &mut scene);
            let projection = scene.projection(SIZE.x, SIZE.y);
            let frame = Frame::of(&scene, SIZE);
            let reference = coverage(&scene, &projection, SIZE, method).unwrap();
            let mut drawn = |scene: &Scene| {
                let mut prepared = stage.prepared(scene);
                stage.aovs(&mut prepared, &frame)
            };
            let aovs = drawn(&scene);
            let found = measure(&scene, &projection, &aovs, &reference);
            assert_eq!((found.hidden_pixels, found.silhouette_pixels), (0, 0), "{near} {method:?}");
            let shown = |number: f32| aovs.uv.iter().filter(|uv| uv[2] == number).count();
            assert!(shown(0.0) > 300 && shown(1.0) > 300, "{near} {method:?}");
            for (i, uv) in aovs.uv.iter().enumerate() {
                let place = UVec2::new(i as u32 % SIZE.x, i as u32 / SIZE.x).as_dvec2() + 0.5;
                let place = (place - 0.5 * SIZE.as_dvec2()).abs() / (0.5 * f64::from(SIZE.y));
                // The plate's half width over its distance, in units of the picture's half height at distance
                // 1.
                let edge = DVec2::splat(0.25 / 0.5_f64.tan());
                let distance = if place.cmplt(edge).all() { near } else { far };
                assert_eq!(uv[3], 1.0);
                let off = (f64::from(aovs.depth[i][0]) - distance).abs() / distance;
                assert!(off < 1e-5, "{i}: {} of {distance}", aovs.depth[i][0]);
            }
            // The scene without the plate, as if clip planes had removed it.
            let mut without = scene.clone();
            without.surfaces[0].transform = DMat4::from_translation(dvec3(0.0, 0.0, 10.0 * far));
            let found = measure(&scene, &projection, &drawn(&without), &reference);
            // The plate is 18 pixels wide and high; those within two pixels of its border do not count.
            assert!(found.hidden_pixels.abs_diff(14 * 14) < 30, "{near} {method:?}: {found:?}");
        }
    }
}
