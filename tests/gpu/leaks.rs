//! Leaks: samples that see through a closed model where two of its faces meet are found, with the edge, and no others.

use std::path::Path;

use freeform_surface::inspect::measure::{
    Leak, LeakFinder, LeakKind, Leaks, Suspects, random_view,
};
use freeform_surface::inspect::programs::Sources;
use freeform_surface::model::{
    BoundedCurve, Coedge, Curve, Edge, Face, FaceSurface, Frame as Axes, Model, Product, ProductUse,
};
use freeform_surface::{Lens, Scene, Tessellation, ViewProjection};
use glam::{DAffine3, DMat4, DVec2, DVec3, UVec2, uvec2};

use crate::harness::patches::{is_long, within};
use crate::harness::{Stage, backends, load, root};

/// The corners of a face of the unit cube, counter-clockwise from outside: bit 0 of a number is x, bit 1 y, bit 2 z.
const SIDES: [[usize; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
/// The number of the face z = 1.
const TOP: usize = 1;

fn corner(number: usize) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|axis| f64::from(number as u32 >> axis & 1)))
}

/// The number of the cube's edge between two corners, and whether it runs from the first to the second.
fn edge_between(a: usize, b: usize) -> (usize, bool) {
    let all = (0..8).flat_map(|a| (0..3).map(move |axis| (a, a | 1 << axis)));
    let number = all.filter(|(a, b)| a != b).position(|ends| ends == (a.min(b), a.max(b)));
    (number.unwrap(), a < b)
}

/// A unit cube of twelve edges. The plane of its top is `raised` above them.
pub(super) fn cube(raised: f64) -> Model {
    let edges = (0..8_usize).flat_map(|a| (0..3).map(move |axis| (a, a | 1 << axis)));
    let edge = |(a, b)| {
        let curve = Curve::Line { origin: corner(a), direction: corner(b) - corner(a) };
        Edge { tolerance: 1e-7, curve: Some(BoundedCurve { curve, range: [0.0, 1.0] }) }
    };
    let face = |side: [usize; 4]| {
        let [x, y] = [1, 3].map(|i| corner(side[i]) - corner(side[0]));
        let z = x.cross(y);
        let coedge = |i: usize| {
            let (edge, forward) = edge_between(side[i], side[(i + 1) % 4]);
            Coedge { edge, forward, pcurve: None }
        };
        let off = if side == SIDES[TOP] { raised } else { 0.0 };
        Face {
            name: String::new(),
            tolerance: 1e-7,
            color: None,
            reversed: false,
            surface: FaceSurface::Plane(Axes { origin: corner(side[0]) + off * z, x, y, z }),
            bounds: [DVec2::ZERO, DVec2::ONE],
            loops: vec![(0..4).map(coedge).collect()],
        }
    };
    Model {
        name: "cube".into(),
        unit: 1.0,
        edges: edges.filter(|(a, b)| a != b).map(edge).collect(),
        faces: SIDES.map(face).to_vec(),
        products: vec![Product { name: String::new(), color: None, faces: [0, 6], uses: vec![] }],
    }
}

/// A model within a tolerance in pixels.
fn scene_of(model: Model, tolerance: f64) -> Scene {
    let scene = Scene::from_model(model, Path::new("cube.ffm")).unwrap();
    assert_eq!(scene.models[0].left_out, []);
    Scene { settings: within(tolerance), ..scene }
}

fn model(name: &str, tolerance: f64) -> Scene {
    let path = root().join(format!("resources/models/{name}.ffm"));
    Scene { settings: within(tolerance), ..load(&path) }
}

/// A stage that draws no strokes: what they hide is seen.
fn without_strokes(size: UVec2) -> Stage {
    let reach = "float reach = shape.z * shape.z;";
    let sources = Sources::default().with_edit("exact/stroke.frag", reach, "float reach = -1.0;");
    Stage::with_sources(backends()[0], size, sources)
}

/// The leaks in the picture of a scene, judged by a finder. The picture is that of `drawn`.
fn leaks_of(stage: &mut Stage, finder: &LeakFinder<'_>, drawn: &Scene, which: Suspects) -> Leaks {
    let mut prepared = stage.prepared(drawn);
    let frame = stage.frame(drawn);
    let aovs = stage.aovs(&mut prepared, &frame);
    let Tessellation::Within(tolerance) = drawn.settings.tessellation else { panic!() };
    finder.find(&frame.camera, &aovs, tolerance.pixels(), which)
}

pub(super) fn to_pixels(projection: &ViewProjection, size: UVec2, point: DVec3) -> DVec2 {
    let ndc = (projection.projection * projection.view).project_point3(point);
    DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size.as_dvec2()
}

#[test]
fn an_intact_cube_has_no_leak() {
    let mut stage = Stage::new(uvec2(320, 200));
    for tolerance in [0.1, 2.0] {
        let scene = scene_of(cube(0.0), tolerance);
        let finder = LeakFinder::new(&scene);
        assert!(finder.has_closed() && finder.open_edges() == 0);
        let none = |leaks: Leaks| {
            assert!(leaks.found.is_empty(), "{:?}", leaks.found);
            assert!(leaks.gap_px < 1e-3, "{}", leaks.gap_px);
        };
        none(leaks_of(&mut stage, &finder, &scene, Suspects::All));
        for zoom in [10.0, 100.0, 10_000.0] {
            for view in 0..if is_long() { 100 } else { 4 } {
                let camera = finder.close_up(3, view, stage.aspect(), zoom);
                assert!(camera.is_some());
                let close = Scene { camera, ..scene.clone() };
                none(leaks_of(&mut stage, &finder, &close, Suspects::Between));
            }
        }
    }
}

#[test]
fn a_crack_is_seen_with_its_edge_and_its_area() {
    let mut stage = Stage::new(uvec2(480, 300));
    let mirrored = {
        let mut model = cube(0.0);
        let placement = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let uses = vec![ProductUse { product: 0, placement, color: None }];
        model.products.push(Product { name: String::new(), color: None, faces: [6, 0], uses });
        model
    };
    let mut turned = cube(0.0);
    turned.faces.iter_mut().for_each(|face| face.reversed = true);
    let all = [
        (cube(0.0), DAffine3::IDENTITY, LeakKind::BackSide),
        (mirrored.clone(), mirrored.products[1].uses[0].placement, LeakKind::BackSide),
        // A cube whose faces are all inside out shows its outside there.
        (turned, DAffine3::IDENTITY, LeakKind::Hidden),
    ];
    for (model, placement, kind) in all {
        let scene = scene_of(model, 1.5);
        let finder = LeakFinder::new(&scene);
        let mut cracked = scene.clone();
        cracked.camera = Some(scene.framed(stage.aspect()));
        let projection = stage.projection(&cracked);
        let size = stage.size;
        let to_pixels =
            |point: DVec3| to_pixels(&projection, size, placement.transform_point3(point));
        // The top slides backwards by three pixels, off its edge at the front, y = 0.
        let [start, end] = [corner(4), corner(5)].map(to_pixels);
        let slide = 3.0 / to_pixels(corner(6)).distance(start) * DVec3::Y;
        let top = &mut cracked.surfaces[TOP].transform;
        *top = DMat4::from_translation(slide) * *top;
        let area = (end - start).perp_dot(to_pixels(corner(4) + slide) - start).abs();
        let leaks = leaks_of(&mut stage, &finder, &cracked, Suspects::Between);
        let count = leaks.found.len() as f64;
        assert!((count - area).abs() < 0.05 * area, "{count} leaks in {area} pixels");
        for leak in &leaks.found {
            let edge = leak.edge.unwrap();
            assert_eq!(leak.kind, kind, "{leak:?}");
            assert!(edge.distance_px < 3.0 && leak.depth.is_finite(), "{leak:?}");
            // Beside the corners, two edges are the nearest.
            let place = leak.pixel.as_dvec2() + 0.5;
            let is_beside = [start, end].iter().any(|end| end.distance(place) < 3.0);
            assert!(is_beside || edge.edge == edge_between(4, 5).0, "{leak:?}");
        }
        let all = leaks_of(&mut stage, &finder, &cracked, Suspects::All).found;
        assert!(leaks.found == all, "{} of {} leaks", leaks.found.len(), all.len());
        // Without what is behind the crack, it shows the background.
        for surface in [0, 3, 4, 5] {
            cracked.surfaces[surface].hidden = true;
        }
        let without = leaks_of(&mut stage, &finder, &cracked, Suspects::All).found;
        let is_in_crack = |pixel: UVec2| leaks.found.iter().any(|leak| leak.pixel == pixel);
        let in_crack = without.iter().filter(|leak| is_in_crack(leak.pixel));
        let of_nothing =
            |leak: &&Leak| leak.kind == LeakKind::Background && leak.depth.is_infinite();
        let count = in_crack.filter(of_nothing).count() as f64;
        assert!((count - area).abs() < 0.05 * area, "{count} leaks in {area} pixels");
    }
}

#[test]
fn gaps_of_the_data_are_known_in_pixels_and_seen() {
    let size = uvec2(320, 200);
    let (mut stage, mut closed) = (without_strokes(size), Stage::new(size));
    let raised = 5e-4;
    let scene = scene_of(cube(raised), 0.1);
    let finder = LeakFinder::new(&scene);
    let mut leaking = 0;
    for (zoom, views) in [(1.0, 1), (100.0, 30)] {
        for view in 0..views {
            let camera = finder.close_up(5, view, stage.aspect(), zoom);
            let close = Scene { camera, ..scene.clone() };
            let leaks = leaks_of(&mut stage, &finder, &close, Suspects::Between);
            let camera = close.camera.unwrap();
            let Lens::Orthographic { height } = camera.lens() else { panic!() };
            let expected = raised / (height / 200.0);
            let is_there = leaks.gap_px > 1e-3;
            assert!(is_there || zoom > 1.0);
            assert!(!is_there || (leaks.gap_px / expected - 1.0).abs() < 1e-3, "{}", leaks.gap_px);
            assert!(is_there || leaks.found.is_empty(), "{:?}", leaks.found);
            leaking += usize::from(!leaks.found.is_empty());
            let with_strokes = leaks_of(&mut closed, &finder, &close, Suspects::Between);
            assert_eq!(with_strokes.found, [], "view {view}");
        }
    }
    assert!(leaking > 0);
}

#[test]
fn open_models_are_not_judged() {
    let mut stage = Stage::new(uvec2(160, 100));
    let mut model = cube(0.0);
    model.products[0].faces = [0, 5];
    let scene = scene_of(model, 2.0);
    let finder = LeakFinder::new(&scene);
    assert!(!finder.has_closed());
    assert_eq!(finder.open_edges(), 4);
    assert_eq!(leaks_of(&mut stage, &finder, &scene, Suspects::All).found, []);
    let mut scene = scene_of(cube(0.0), 2.0);
    scene.surfaces[2].hidden = true;
    assert_eq!(LeakFinder::new(&scene).open_edges(), 4);
}

#[test]
fn faces_leak_along_curved_edges_without_strokes_only() {
    let size = uvec2(480, 300);
    let scene = model("flange", 2.0);
    let finder = LeakFinder::new(&scene);
    assert!(finder.has_closed() && finder.open_edges() == 0);
    let leaks = leaks_of(&mut without_strokes(size), &finder, &scene, Suspects::Between);
    assert!(leaks.found.len() > 100, "{}", leaks.found.len());
    for leak in &leaks.found {
        let edge = leak.edge.unwrap();
        assert!(edge.distance_px < 2.1, "{leak:?}");
    }
    let leaks = leaks_of(&mut Stage::new(size), &finder, &scene, Suspects::All);
    assert_eq!(leaks.found, []);
}

#[test]
fn closed_models_have_no_leak() {
    let mut stage = Stage::new(uvec2(320, 200));
    let views = if is_long() { 1_000 } else { 3 };
    for name in ["flange", "bracket", "blade", "assembly"] {
        for tolerance in [2.0, 0.5, 0.1] {
            let scene = model(name, tolerance);
            let finder = LeakFinder::new(&scene);
            assert!(finder.has_closed() && finder.open_edges() == 0);
            for view in 0..views {
                let random = random_view(&scene, 11, view, stage.aspect());
                let close_up = |zoom: f64| finder.close_up(12, view, stage.aspect(), zoom).unwrap();
                let cameras = [random, close_up(1.0), close_up(10.0), close_up(100.0)];
                for camera in cameras.into_iter().chain([close_up(10_000.0)]) {
                    let seen = Scene { camera: Some(camera), ..scene.clone() };
                    let leaks = leaks_of(&mut stage, &finder, &seen, Suspects::Between);
                    assert_eq!(leaks.found, [], "{name}, {tolerance} px, view {view}: {camera:?}");
                }
            }
        }
    }
}

#[test]
fn the_border_of_an_open_shell_does_not_grow() {
    let size = uvec2(320, 200);
    // Four sides of a cube: their edges with the missing ones are open, the others are shared.
    let mut shell = cube(0.0);
    shell.products[0].faces = [2, 4];
    let scene = scene_of(shell, 2.0);
    let covered = |mut stage: Stage| {
        let mut prepared = stage.prepared(&scene);
        let frame = stage.frame(&scene);
        stage.aovs(&mut prepared, &frame).uv.iter().map(|uv| uv[3] != 0.0).collect::<Vec<_>>()
    };
    assert!(covered(Stage::new(size)) == covered(without_strokes(size)));
}

#[test]
fn no_leak_is_missed_among_the_samples_that_are_not_looked_at() {
    let mut stage = without_strokes(uvec2(200, 120));
    let views = if is_long() { 20 } else { 2 };
    let mut found = 0;
    for name in ["flange", "bracket", "blade", "assembly"] {
        let scene = model(name, 2.0);
        let finder = LeakFinder::new(&scene);
        for view in 0..views {
            for zoom in [1.0, 30.0] {
                let camera = finder.close_up(9, view, stage.aspect(), zoom);
                let close = Scene { camera, ..scene.clone() };
                let all = leaks_of(&mut stage, &finder, &close, Suspects::All);
                let between = leaks_of(&mut stage, &finder, &close, Suspects::Between);
                assert_eq!(all.found, between.found, "{name} {view} × {zoom}");
                assert!(between.suspects < all.suspects);
                found += all.found.len();
            }
        }
    }
    assert!(found > 0);
}
