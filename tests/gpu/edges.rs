//! Lines along the edges of CAD models: where they are, which edges have one, and that nothing else changes.

use std::f64::consts::TAU;
use std::path::Path;

use freeform_surface::inspect::measure::Random;
use freeform_surface::model::{
    BoundedCurve, Coedge, Continuity, Curve, Edge, Face, FaceSurface, Frame as Axes, JointKind,
    Model, Product,
};
use freeform_surface::{
    Camera, EdgeColor, Edges, Error, Frame, Framebuffer, Image, Lens, LineWidth, Paint, Samples,
    Scene, Shading, TessLevel, Tessellation, ViewProjection,
};
use glam::{DAffine3, DVec2, DVec3, dvec3, uvec2};

use super::leaks::{cube, to_pixels};
use crate::harness::patches::within;
use crate::harness::{Stage, load, root};

/// A round plate of radius 1, which is open.
fn disc() -> Model {
    let axes = Axes { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
    let curve = Curve::Circle { frame: axes, radius: 1.0 };
    let edge = Edge { tolerance: 1e-7, curve: Some(BoundedCurve { curve, range: [0.0, TAU] }) };
    let face = Face {
        name: String::new(),
        tolerance: 1e-7,
        color: None,
        reversed: false,
        surface: FaceSurface::Plane(axes),
        bounds: [-DVec2::ONE, DVec2::ONE],
        loops: vec![vec![Coedge { edge: 0, forward: true, pcurve: None }]],
    };
    Model {
        name: "disc".into(),
        unit: 1.0,
        edges: vec![edge],
        faces: vec![face],
        products: vec![Product { name: String::new(), color: None, faces: [0, 1], uses: vec![] }],
    }
}

/// A scene in black with white edges, within half a pixel.
fn in_black(scene: Scene, width: f64, smooth: bool) -> Scene {
    let mut scene = Scene { settings: within(0.5), ..scene };
    scene.settings.background = [0.0, 0.0, 0.0, 1.0];
    let width = LineWidth::new(width).unwrap();
    scene.settings.edges = Some(Edges { width, color: EdgeColor::Rgb([1.0; 3]), smooth });
    for surface in &mut scene.surfaces {
        surface.shading = Shading::Unlit;
        surface.paint = Paint::Color([0.0; 3]);
    }
    scene
}

fn of_model(model: Model) -> Scene {
    let scene = Scene::from_model(model, Path::new("model.ffm")).unwrap();
    assert_eq!(scene.models[0].left_out, []);
    scene
}

fn own(name: &str) -> Scene {
    load(&root().join(format!("resources/models/{name}.ffm")))
}

fn camera(eye: DVec3, target: DVec3) -> Camera {
    let lens = Lens::Perspective { fov_y_radians: 0.6 };
    Camera::new(eye, target, DVec3::Z, lens).unwrap()
}

/// A picture with several samples a pixel.
fn picture(stage: &mut Stage, scene: &Scene, samples: i64) -> Image {
    let mut scene = scene.clone();
    scene.settings.samples = Samples::new(samples).unwrap();
    let frame = stage.frame(&scene);
    let gl = stage.context().gl().clone();
    let size = (stage.size.x, stage.size.y);
    let target = Framebuffer::for_samples(&gl, size, scene.settings.samples).unwrap();
    let mut prepared = stage.prepared(&scene);
    prepared.picture(stage.renderer_mut(), &target, &frame, |_, _| {}).unwrap()
}

fn light(image: &Image, x: u32, y: u32) -> f64 {
    f64::from(image.get_pixel(x, y).0[0]) / 255.0
}

/// An edge of a scene's model in its place, as points on the screen at equal steps of its parameter.
fn on_screen(scene: &Scene, projection: &ViewProjection, stage: &Stage, edge: usize) -> Vec<DVec2> {
    let model = &scene.models[0].model;
    let BoundedCurve { curve, range: [first, last] } = model.edges[edge].curve.as_ref().unwrap();
    (0..=2000)
        .map(|i| {
            let point = curve.at(first + f64::from(i) / 2000.0 * (last - first))[0];
            to_pixels(projection, stage.size, point)
        })
        .collect()
}

/// How far the centroid of the light around a part of a curve lies beside it. The part is straight but for far less than
/// a pixel.
fn off_line(image: &Image, part: &[DVec2], reach: f64) -> f64 {
    let (start, end) = (part[0], part[part.len() - 1]);
    let along = (end - start).normalize();
    let (mut sum, mut moment) = (0.0, 0.0);
    let low = start.min(end) - 2.0 * reach;
    let high = start.max(end) + 2.0 * reach;
    for y in low.y as u32..=high.y as u32 {
        for x in low.x as u32..=high.x as u32 {
            let pixel = DVec2::new(x.into(), y.into()) + 0.5;
            let share = (pixel - start).dot(along);
            let nearest = part
                .iter()
                .min_by(|a, b| pixel.distance_squared(**a).total_cmp(&pixel.distance_squared(**b)));
            let off = (pixel - *nearest.unwrap()).dot(along.perp());
            if (0.0..=end.distance(start)).contains(&share) && off.abs() <= reach {
                sum += light(image, x, y);
                moment += light(image, x, y) * off;
            }
        }
    }
    assert!(sum > 2.0 * end.distance(start), "no line from {start} to {end}: {sum}");
    moment / sum
}

/// Checks parts of about 24 pixels of an edge, away from its ends.
fn check_place(image: &Image, places: &[DVec2], margin: f64) -> usize {
    let ends = [places[0], places[places.len() - 1]];
    let mut parts = 0;
    let mut from = 0;
    for to in 1..places.len() {
        if places[from].distance(places[to]) < 24.0 {
            continue;
        }
        let part = &places[from..=to];
        from = to;
        if part.iter().all(|place| ends.iter().all(|end| place.distance(*end) > margin)) {
            let off = off_line(image, part, 4.0);
            assert!(off.abs() < 0.1, "{off} px from {} to {}", part[0], part[part.len() - 1]);
            parts += 1;
        }
    }
    parts
}

#[test]
fn lines_lie_on_their_curves() {
    let mut stage = Stage::new(uvec2(400, 300));
    for samples in [4, 16] {
        let mut scene = in_black(of_model(disc()), 3.0, false);
        scene.camera = Some(camera(dvec3(1.5, -3.0, 2.5), DVec3::ZERO));
        let image = picture(&mut stage, &scene, samples);
        let projection = stage.projection(&scene);
        let circle = on_screen(&scene, &projection, &stage, 0);
        assert!(check_place(&image, &circle, 0.0) > 15);

        let mut scene = in_black(of_model(cube(0.0)), 3.0, false);
        scene.camera = Some(camera(dvec3(3.0, -2.2, 2.6), DVec3::splat(0.5)));
        let image = picture(&mut stage, &scene, samples);
        let projection = stage.projection(&scene);
        for edge in visible_edges(&scene) {
            let places = on_screen(&scene, &projection, &stage, edge);
            assert!(check_place(&image, &places, 10.0) >= 2, "{edge}");
        }
    }
}

/// The edges of the cube's faces that are turned towards the eye.
fn visible_edges(scene: &Scene) -> Vec<usize> {
    let eye = scene.camera.unwrap().eye();
    let model = &scene.models[0].model;
    let is_seen = |face: &&Face| {
        let FaceSurface::Plane(axes) = &face.surface else { panic!() };
        axes.z.dot(eye - axes.origin) > 0.0
    };
    let mut edges: Vec<usize> = model
        .faces
        .iter()
        .filter(is_seen)
        .flat_map(|face| face.loops.iter().flatten().map(|coedge| coedge.edge))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

/// The light of all pixels that are further than `reach` from the places.
fn elsewhere(image: &Image, places: &[DVec2], reach: f64) -> f64 {
    let pixels = image.enumerate_pixels().map(|(x, y, _)| (x, y));
    pixels
        .filter(|(x, y)| light(image, *x, *y) > 0.0)
        .filter(|(x, y)| {
            let pixel = DVec2::new((*x).into(), (*y).into()) + 0.5;
            places.iter().all(|place| place.distance(pixel) > reach)
        })
        .map(|(x, y)| light(image, x, y))
        .sum()
}

#[test]
fn a_cube_shows_nine_edges_joined_at_seven_corners() {
    let mut stage = Stage::new(uvec2(400, 300));
    let mut random = Random(3);
    for number in 0..6 {
        let width = [1.5, 3.0, 6.0][number % 3];
        let mut scene = in_black(of_model(cube(0.0)), width, false);
        let mut unit = || random.unit();
        let eye = dvec3(2.5 + unit(), -1.0 - 2.0 * unit(), 2.0 + 2.0 * unit());
        scene.camera = Some(camera(eye, DVec3::splat(0.5)));
        let edges = visible_edges(&scene);
        assert_eq!(edges.len(), 9);
        let projection = stage.projection(&scene);
        // Whatever the tolerance: a level for all patches has no strokes between faces.
        if number % 2 == 1 {
            scene.settings.tessellation = Tessellation::Level(TessLevel::new(2).unwrap());
        }
        let image = picture(&mut stage, &scene, 4);
        let all: Vec<DVec2> =
            edges.iter().flat_map(|edge| on_screen(&scene, &projection, &stage, *edge)).collect();
        let hidden = elsewhere(&image, &all, 0.5 * width + 0.8);
        assert!(hidden == 0.0, "{number}: {hidden} pixels of hidden edges");
        // Every place of a visible edge is drawn to its full width, corners included.
        for place in &all {
            for (dx, dy) in (-4..=4).flat_map(|dx| (-4..=4).map(move |dy| (dx, dy))) {
                let pixel = place.floor() + DVec2::new(f64::from(dx), f64::from(dy));
                if (pixel + 0.5).distance(*place) < 0.5 * width - 0.75 {
                    let light = light(&image, pixel.x as u32, pixel.y as u32);
                    assert!(light == 1.0, "{number}: {light} beside {place}");
                }
            }
        }
        // Another cube in front hides the edges.
        let mut covered = scene.clone();
        let to_eye = DAffine3::from_translation(0.3 * (eye - DVec3::splat(0.5)));
        let mut cover = of_model(cube(0.0)).surfaces;
        for surface in &mut cover {
            let (shading, paint) = (Shading::Unlit, Paint::Color([0.0; 3]));
            (surface.shading, surface.paint, surface.face) = (shading, paint, None);
            let place = to_eye * DAffine3::from_scale(DVec3::splat(3.0));
            let to_middle = DAffine3::from_translation(DVec3::splat(-1.0 / 3.0));
            surface.transform = (place * to_middle).into();
        }
        covered.surfaces.extend(cover);
        let image = picture(&mut stage, &covered, 4);
        assert_eq!(elsewhere(&image, &[], 0.0), 0.0);
    }
}

#[test]
fn smooth_edges_only_on_request_and_seams_never() {
    let mut stage = Stage::new(uvec2(480, 300));
    for name in ["bracket", "flange"] {
        let scene = own(name);
        let projection = stage.projection(&scene);
        let places = |wanted: &[JointKind]| -> Vec<DVec2> {
            let joints = scene.models[0].joints.iter();
            let of_kind = joints.filter(|joint| wanted.contains(&joint.kind));
            of_kind.flat_map(|joint| on_screen(&scene, &projection, &stage, joint.edge)).collect()
        };
        let sharp = places(&[JointKind::Sharp]);
        let both = places(&[JointKind::Sharp, JointKind::Smooth]);
        let seams = places(&[JointKind::Seam]);
        let reach = 0.75 + 0.8;
        let image = picture(&mut stage, &in_black(scene.clone(), 1.5, false), 4);
        assert_eq!(elsewhere(&image, &sharp, reach), 0.0, "{name}");
        assert!(elsewhere(&image, &[], 0.0) > 100.0, "{name}");
        let image = picture(&mut stage, &in_black(scene.clone(), 1.5, true), 4);
        let smooth = elsewhere(&image, &sharp, reach);
        assert!(if name == "bracket" { smooth > 100.0 } else { smooth == 0.0 }, "{name}: {smooth}");
        assert_eq!(elsewhere(&image, &both, reach), 0.0, "{name}: a seam");
        assert!(name == "bracket" || !seams.is_empty());
    }
}

#[test]
fn aovs_and_open_shells_are_as_without_lines() {
    let mut stage = Stage::new(uvec2(240, 160));
    let plain = Scene { settings: within(2.0), ..of_model(disc()) };
    // What the scene does not know as a model has no strokes.
    let mut bare = plain.clone();
    bare.models.clear();
    bare.surfaces.iter_mut().for_each(|surface| surface.face = None);
    assert_eq!(stage.render(&plain), stage.render(&bare));
    for scene in [plain, Scene { settings: within(0.5), ..own("bracket") }] {
        let mut prepared = stage.prepared(&scene);
        let mut frame: Frame = stage.frame(&scene);
        let before = stage.aovs(&mut prepared, &frame);
        frame.settings.edges = Some(Edges::default());
        let image = stage.picture(&mut prepared, &frame);
        assert_eq!(format!("{before:?}"), format!("{:?}", stage.aovs(&mut prepared, &frame)));
        frame.settings.edges = None;
        assert_ne!(image, stage.picture(&mut prepared, &frame));
    }
}

#[test]
fn hidden_faces_take_their_lines_along_and_wireframes_have_them() {
    let mut stage = Stage::new(uvec2(400, 300));
    let mut scene = in_black(of_model(cube(0.0)), 3.0, false);
    scene.camera = Some(camera(dvec3(4.0, -2.0, 2.0), DVec3::splat(0.5)));
    let projection = stage.projection(&scene);
    let mut prepared = stage.prepared(&scene);
    let mut frame = stage.frame(&scene);
    // Only the top is left: its border is drawn.
    for (number, surface) in prepared.surfaces_mut().iter_mut().enumerate() {
        surface.set_hidden(number != 1);
    }
    let image = stage.picture(&mut prepared, &frame);
    let top: Vec<usize> =
        scene.models[0].model.faces[1].loops[0].iter().map(|coedge| coedge.edge).collect();
    let places = |edges: &[usize]| -> Vec<DVec2> {
        edges.iter().flat_map(|edge| on_screen(&scene, &projection, &stage, *edge)).collect()
    };
    assert_eq!(elsewhere(&image, &places(&top), 2.3), 0.0);
    for edge in &top {
        let ends = places(&[*edge]);
        let length = ends[0].distance(ends[2000]);
        let others: Vec<DVec2> =
            places(&top.iter().copied().filter(|other| other != edge).collect::<Vec<_>>());
        assert!(elsewhere(&image, &others, 2.3) > 2.0 * (length - 10.0));
    }
    // A wireframe hides none of the twelve.
    prepared.surfaces_mut().iter_mut().for_each(|surface| surface.set_hidden(false));
    frame.settings.wireframe = true;
    let image = stage.picture(&mut prepared, &frame);
    for number in 0..12 {
        let places = on_screen(&scene, &projection, &stage, number);
        let is_light = |place: &&DVec2| light(&image, place.x as u32, place.y as u32) == 1.0;
        // The lines of the triangles cross some of them.
        let count = places.iter().filter(is_light).count();
        assert!(10 * count > 9 * places.len(), "{number}: {count}");
    }
}

/// A model of two plane faces side by side: they meet in an edge without a bend, and six edges are open. Those of one
/// face are all its own.
fn two_squares() -> Model {
    let corner = |i: usize| dvec3([0.0, 1.0, 2.0][i % 3], (i / 3) as f64, 0.0);
    let mut edges = Vec::new();
    let mut edge = |from: usize, to: usize| {
        let (origin, along) = (corner(from), corner(to) - corner(from));
        let curve = Curve::Line { origin, direction: along };
        let curve = Some(BoundedCurve { curve, range: [0.0, 1.0] });
        edges.push(Edge { tolerance: 1e-7, curve });
    };
    // The edge of both faces is the first.
    for (from, to) in [(1, 4), (0, 1), (4, 3), (3, 0), (1, 2), (2, 5), (5, 4)] {
        edge(from, to);
    }
    let axes = Axes { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
    let face = |loops: [(usize, bool); 4], first: f64| Face {
        name: String::new(),
        tolerance: 1e-7,
        color: None,
        reversed: false,
        surface: FaceSurface::Plane(axes),
        bounds: [DVec2::new(first, 0.0), DVec2::new(first + 1.0, 1.0)],
        loops: vec![loops.map(|(edge, forward)| Coedge { edge, forward, pcurve: None }).to_vec()],
    };
    let one = face([(1, true), (0, true), (2, true), (3, true)], 0.0);
    let other = face([(4, true), (5, true), (6, true), (0, false)], 1.0);
    let product = Product { name: String::new(), color: None, faces: [0, 2], uses: vec![] };
    Model {
        name: "squares".into(),
        unit: 1.0,
        edges,
        faces: vec![one, other],
        products: vec![product],
    }
}

#[test]
fn edges_have_the_colours_of_their_classes() {
    let mut stage = Stage::new(uvec2(400, 300));
    let bytes = |class: Continuity| class.color().map(|channel| (channel * 255.0).round() as u8);
    // The classes of the first two follow from how they are made: six edges open and one G2, twelve sharp ones.
    let mut flat = of_model(two_squares());
    flat.camera = Some(camera(dvec3(1.4, -1.5, 3.0), dvec3(1.0, 0.5, 0.0)));
    let mut solid = of_model(cube(0.0));
    solid.camera = Some(camera(dvec3(3.0, -2.2, 2.6), DVec3::splat(0.5)));
    let by_hand: [Vec<Continuity>; 2] = [
        (0..7).map(|edge| if edge == 0 { Continuity::G2 } else { Continuity::Open }).collect(),
        vec![Continuity::G0; 12],
    ];
    let found = |scene: &Scene| {
        let edges = scene.models[0].model.continuity().unwrap();
        edges.into_iter().map(|edge| (edge.edge, edge.class)).collect::<Vec<_>>()
    };
    let of_hand = |number: usize| by_hand[number].iter().copied().enumerate().collect::<Vec<_>>();
    let own = ["bracket", "flange", "blade"].map(own).map(|scene| (found(&scene), scene));
    for (classes, scene) in [(of_hand(0), flat), (of_hand(1), solid)].into_iter().chain(own) {
        let name = scene.models[0].model.name.clone();
        let mut scene = in_black(scene, 3.0, false);
        scene.settings.edges =
            Some(Edges { color: EdgeColor::Continuity, ..scene.settings.edges.unwrap() });
        scene.settings.background = [1.0; 4];
        for surface in &mut scene.surfaces {
            surface.paint = Paint::Color([1.0; 3]);
        }
        let projection = stage.projection(&scene);
        let image = picture(&mut stage, &scene, 1);
        let mut drawn = 0;
        for class in Continuity::ALL {
            let of_class = classes.iter().filter(|(_, own)| *own == class);
            let places: Vec<DVec2> = of_class
                .flat_map(|(edge, _)| on_screen(&scene, &projection, &stage, *edge))
                .collect();
            let has_color = |(x, y, pixel): (u32, u32, &freeform_surface::image::Rgba<u8>)| {
                (pixel.0[..3] == bytes(class)).then(|| DVec2::new(x.into(), y.into()) + 0.5)
            };
            let colored: Vec<DVec2> = image.enumerate_pixels().filter_map(has_color).collect();
            let is_near = |pixel: &DVec2| places.iter().any(|place| place.distance(*pixel) < 2.3);
            assert!(colored.iter().all(is_near), "{name}: {} beside its edges", class.name());
            let is_visible = colored.len() > 30;
            // Edges of other models may be hidden.
            let must_be_seen = ["squares", "cube"].contains(&name.as_str());
            assert!(!must_be_seen || is_visible != places.is_empty(), "{name}: {}", class.name());
            drawn += colored.len();
        }
        let paper = image.pixels().filter(|pixel| pixel.0[..3] == [255; 3]).count();
        assert_eq!(drawn + paper, 400 * 300, "{name}: only these colours");
        assert!(drawn > 300, "{name}: {drawn}");
        if name == "squares" {
            // The smooth edge has no line in one colour.
            let plain = in_black(scene, 3.0, false);
            let middle = to_pixels(&projection, stage.size, dvec3(1.0, 0.5, 0.0));
            let at = |image: &Image| image.get_pixel(middle.x as u32, middle.y as u32).0;
            assert_eq!(at(&image)[..3], bytes(Continuity::G2));
            assert_eq!(at(&picture(&mut stage, &plain, 1))[..3], [0; 3]);
        }
    }
}

#[test]
fn the_setting_is_written_and_read_again() {
    let path = Path::new("scene.toml");
    let patch = "[[surface]]\ncontrol_points = \"default\"\ncolor = [0, 0, 0]\n";
    let read = |edges: &str| Scene::from_toml(&format!("render = {{ {edges} }}\n{patch}"), path);
    for (text, expected) in [
        ("", None),
        ("edges = false", None),
        ("edges = true", Some(Edges::default())),
        ("edges = {}", Some(Edges::default())),
        (
            "edges = { color = \"continuity\" }",
            Some(Edges { color: EdgeColor::Continuity, ..Edges::default() }),
        ),
        (
            "edges = { width = 2, color = [1, 0.5, 0], smooth = true }",
            Some(Edges {
                width: LineWidth::new(2.0).unwrap(),
                color: EdgeColor::Rgb([1.0, 0.5, 0.0]),
                smooth: true,
            }),
        ),
    ] {
        let scene = read(text).unwrap();
        assert_eq!(scene.settings.edges, expected, "{text}");
        let again = Scene::from_toml(&scene.to_toml(path).unwrap().text, path).unwrap();
        assert_eq!(again.settings, scene.settings);
    }
    for (wrong, named) in [
        ("edges = { width = 0 }", "width"),
        ("edges = { width = nan }", "width"),
        ("edges = { color = [2, 0, 0] }", "color"),
        ("edges = { color = \"rainbow\" }", "\"continuity\""),
        ("edges = { color = 3 }", "width, color and smooth"),
        ("edges = { colour = [1, 0, 0] }", "width, color and smooth"),
        ("edges = 3", "width, color and smooth"),
    ] {
        let error: Error = read(wrong).unwrap_err();
        let text = error.to_string();
        assert!(text.contains("scene.toml:1") && text.contains(named), "{wrong}: {text}");
    }
}
