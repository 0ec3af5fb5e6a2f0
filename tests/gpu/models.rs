//! CAD models: what a ray from the eye meets is what the pixel shows; size, place and mirrors make no difference.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use freeform_surface::inspect::measure::{Random, random_view};
use freeform_surface::inspect::reference::{Hit, Rays};
use freeform_surface::model::{BoundedCurve, Curve, FaceSurface, Frame as Axes, Model, NurbsCurve};
use freeform_surface::{
    Aovs, Camera, Image, Lens, LoadOptions, NurbsSurface, Scene, Surface, ViewProjection,
};
use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4, UVec2, uvec2};

use crate::harness::patches::{is_long, within};
use crate::harness::{Stage, load, root};

const OWN: [&str; 4] = ["assembly", "blade", "bracket", "flange"];

fn path_of(name: &str) -> PathBuf {
    root().join(format!("resources/models/{name}.ffm"))
}

/// The folder of CAD files. `None`, which is said, without it or without the reader of such files.
pub(super) fn cad_files() -> Option<PathBuf> {
    let reader = root().join("cad/build/freeform-occt");
    let mut folders = ["shared/data/cad", "../shared/data/cad"].into_iter();
    let found = folders.find_map(|name| Some(root().join(name)).filter(|folder| folder.is_dir()));
    let found = found.filter(|_| reader.is_file());
    if found.is_none() {
        println!("skipped: no CAD files or no {}", reader.display());
    }
    found
}

/// The rays of a picture.
struct View<'a> {
    rays: Rays<'a>,
    scene: &'a Scene,
    projection: ViewProjection,
    size: UVec2,
}

impl View<'_> {
    /// What the ray through a place of the picture meets: pixels from the upper left corner.
    fn at(&self, place: DVec2) -> Option<(usize, f64)> {
        let ndc = DVec2::new(2.0, -2.0) * place / self.size.as_dvec2() + DVec2::new(-1.0, 1.0);
        let from_clip = (self.projection.projection * self.projection.view).inverse();
        let [near, far] = [-1.0, 1.0].map(|z| from_clip.project_point3(ndc.extend(z)));
        let Hit { surface, distance, .. } = self.rays.cast(near, far - near)?;
        let point = near + distance * (far - near);
        Some((surface, -self.projection.view.transform_point3(point).z))
    }

    /// The size of a pixel at a depth, in world space.
    fn pixel_at(&self, depth: f64) -> f64 {
        let clip = self.projection.projection * DVec4::new(0.0, 0.0, -depth, 1.0);
        let step = DVec3::new(2.0 / f64::from(self.size.x), 0.0, clip.z / clip.w);
        let from_clip = self.projection.projection.inverse();
        let [at, beside] = [step.with_x(0.0), step].map(|ndc| from_clip.project_point3(ndc));
        at.distance(beside)
    }

    /// Compares pixels with rays. Pixels near an edge or a silhouette are left out: where rays a pixel around do not
    /// all meet the same face. Returns the numbers of pixels that show a face and that show nothing.
    fn compare(&self, name: &str, aovs: &Aovs, random: &mut Random, count: usize) -> [usize; 2] {
        let mut compared = [0; 2];
        for _ in 0..count {
            let pixel = DVec2::new(random.unit(), random.unit()) * self.size.as_dvec2();
            let pixel = pixel.as_uvec2();
            let center = pixel.as_dvec2() + 0.5;
            let offsets = (0..9).map(|i| DVec2::new(f64::from(i % 3), f64::from(i / 3)) - 1.0);
            let around: Vec<_> = offsets.map(|offset| self.at(center + offset)).collect();
            let surfaces = || around.iter().map(|hit| hit.map(|(surface, _)| surface));
            if surfaces().any(|surface| Some(surface) != surfaces().next()) {
                continue;
            }
            let shown = (pixel.y * self.size.x + pixel.x) as usize;
            let [depth, .., alpha] = aovs.depth[shown];
            let what = format!("{name}: pixel {pixel}");
            let Some((surface, _)) = around[4] else {
                assert_eq!(alpha, 0.0, "{what} shows a face where nothing is");
                compared[1] += 1;
                continue;
            };
            let face = self.scene.surfaces[surface].face.unwrap();
            assert_eq!(aovs.face[shown][..2], [face.face as f32, face.instance as f32], "{what}");
            // The tolerance moves points by up to half a pixel on the screen, and along the view.
            let depths = || around.iter().flatten().map(|(_, depth)| *depth);
            let [low, high] = [depths().fold(f64::MAX, f64::min), depths().fold(0.0, f64::max)];
            let slack = 0.5 * self.pixel_at(high);
            let depth = f64::from(depth);
            assert!(
                (low - slack..=high + slack).contains(&depth),
                "{what}: {depth}, not {low} to {high}"
            );
            compared[0] += 1;
        }
        compared
    }
}

/// Compares three views of a scene with `count` rays each.
fn check_rays(stage: &mut Stage, name: &str, scene: &Scene, count: usize) {
    let mut prepared = stage.prepared(scene);
    let views = [None, Some(0), Some(3)];
    for index in views {
        let camera = index.map(|index| random_view(scene, 11, index, stage.aspect()));
        let shown = Scene { camera, settings: within(0.5), ..scene.clone() };
        let frame = stage.frame(&shown);
        let aovs = stage.aovs(&mut prepared, &frame);
        let view =
            View { rays: Rays::new(scene), scene, projection: frame.camera, size: stage.size };
        let mut random = Random(5);
        let [seen, nothing] = view.compare(&format!("{name} {index:?}"), &aovs, &mut random, count);
        assert!(10 * (seen + nothing) > count, "{name} {index:?}: {seen} {nothing}");
        if index.is_none() {
            // A propeller fills few of the pixels; 50 of it are enough.
            let is_enough = seen > (count / 10).min(50) && 20 * nothing > count;
            assert!(is_enough, "{name}: {seen} {nothing}");
        }
    }
}

#[test]
fn pixels_of_own_models_show_what_rays_meet() {
    let mut stage = Stage::new(uvec2(480, 300));
    for name in OWN {
        let count = if is_long() { 2000 } else { 250 };
        check_rays(&mut stage, name, &load(&path_of(name)), count);
    }
}

#[test]
fn pixels_of_cad_files_show_what_rays_meet() {
    let Some(folder) = cad_files() else { return };
    let mut stage = Stage::new(uvec2(480, 300));
    let short = ["as1-oc-214.stp", "io1-cm-214.stp", "axom_boxed_sphere.step"];
    let mut files: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    for file in files {
        let name = file.file_name().unwrap().to_str().unwrap();
        if !is_long() && !short.contains(&name) {
            continue;
        }
        let scene = Scene::load(&file).unwrap();
        check_rays(&mut stage, name, &scene, if is_long() { 2000 } else { 100 });
    }
}

/// A scene of the text of a model.
fn scene_of(text: &str) -> Scene {
    Scene::from_text(text, Path::new("model.ffm"), &LoadOptions::default()).unwrap()
}

fn text_of(model: &Model) -> String {
    let mut text = Vec::new();
    model.write(&mut text).unwrap();
    String::from_utf8(text).unwrap()
}

/// A model with all its points changed by a similarity: scale, then a translation.
fn placed(model: &Model, scale: f64, translation: DVec3) -> Model {
    let point = |point: DVec3| point * scale + translation;
    let axes = |frame: Axes| Axes { origin: point(frame.origin), ..frame };
    let net = |points: &[DVec4]| -> Vec<DVec4> {
        points.iter().map(|p| point(p.truncate()).extend(p.w)).collect()
    };
    // Parameters that are lengths are scaled too.
    let curve = |bounded: &BoundedCurve| {
        let [low, high] = bounded.range;
        match &bounded.curve {
            Curve::Line { origin, direction } => BoundedCurve {
                curve: Curve::Line { origin: point(*origin), direction: *direction },
                range: [low * scale, high * scale],
            },
            Curve::Circle { frame, radius } => BoundedCurve {
                curve: Curve::Circle { frame: axes(*frame), radius: radius * scale },
                range: [low, high],
            },
            Curve::Ellipse { frame, radii } => BoundedCurve {
                curve: Curve::Ellipse { frame: axes(*frame), radii: radii.map(|r| r * scale) },
                range: [low, high],
            },
            Curve::Nurbs(curve) => {
                let points = net(curve.control_points());
                let moved = NurbsCurve::new(curve.degree(), curve.knots().to_vec(), points);
                BoundedCurve { curve: Curve::Nurbs(moved.unwrap()), range: [low, high] }
            }
        }
    };
    let mut placed = model.clone();
    for edge in &mut placed.edges {
        edge.tolerance *= scale;
        edge.curve = edge.curve.as_ref().map(curve);
    }
    for face in &mut placed.faces {
        face.tolerance *= scale;
        let both = DVec2::splat(scale);
        let along_v = DVec2::new(1.0, scale);
        let lengths;
        (face.surface, lengths) = match &face.surface {
            FaceSurface::Plane(frame) => (FaceSurface::Plane(axes(*frame)), both),
            FaceSurface::Cylinder { frame, radius } => {
                (FaceSurface::Cylinder { frame: axes(*frame), radius: radius * scale }, along_v)
            }
            FaceSurface::Cone { frame, radius, half_angle } => {
                let (frame, radius) = (axes(*frame), radius * scale);
                (FaceSurface::Cone { frame, radius, half_angle: *half_angle }, along_v)
            }
            FaceSurface::Sphere { frame, radius } => {
                (FaceSurface::Sphere { frame: axes(*frame), radius: radius * scale }, DVec2::ONE)
            }
            FaceSurface::Torus { frame, major_radius, minor_radius } => {
                let radii = [major_radius * scale, minor_radius * scale];
                let [major_radius, minor_radius] = radii;
                let frame = axes(*frame);
                (FaceSurface::Torus { frame, major_radius, minor_radius }, DVec2::ONE)
            }
            FaceSurface::Nurbs(surface) => {
                let points = net(surface.control_points());
                let knots = surface.knots().clone();
                let moved = NurbsSurface::new(surface.degree(), knots, points).unwrap();
                (FaceSurface::Nurbs(moved), DVec2::ONE)
            }
            FaceSurface::Revolution { origin, axis, curve: of } => {
                let (origin, axis, moved) = (point(*origin), *axis, curve(of));
                let along = moved.range[1] / of.range[1];
                (FaceSurface::Revolution { origin, axis, curve: moved }, DVec2::new(1.0, along))
            }
            FaceSurface::Extrusion { direction, curve: of } => {
                let (direction, moved) = (*direction, curve(of));
                let along = moved.range[1] / of.range[1];
                (FaceSurface::Extrusion { direction, curve: moved }, DVec2::new(along, scale))
            }
        };
        face.bounds = face.bounds.map(|bound| bound * lengths);
        for coedge in face.loops.iter_mut().flatten() {
            coedge.pcurve = coedge.pcurve.as_ref().map(|pcurve| {
                let points = pcurve.control_points().iter();
                let points = points.map(|p| (p.truncate() * lengths).extend(p.z)).collect();
                NurbsCurve::new(pcurve.degree(), pcurve.knots().to_vec(), points).unwrap()
            });
        }
    }
    for place in placed.products.iter_mut().flat_map(|product| &mut product.uses) {
        let moved = DAffine3::from_translation(translation);
        let to = moved * DAffine3::from_scale(DVec3::splat(scale));
        place.placement = to * place.placement * to.inverse();
    }
    placed
}

/// How many pixels of two pictures differ by more than rounding, and how many of these have no edge beside them.
fn differences(a: &Image, b: &Image) -> [usize; 2] {
    let apart = |a: &image::Rgba<u8>, b: &image::Rgba<u8>| {
        std::iter::zip(a.0, b.0).map(|(a, b)| a.abs_diff(b)).max().unwrap_or_default()
    };
    let mut counts = [0; 2];
    for (x, y, pixel) in a.enumerate_pixels() {
        if apart(pixel, b.get_pixel(x, y)) <= 3 {
            continue;
        }
        counts[0] += 1;
        let around = (0..9)
            .map(|i| (x + i % 3, y + i / 3))
            .filter_map(|(x, y)| b.get_pixel_checked(x.checked_sub(1)?, y.checked_sub(1)?));
        // At a silhouette, the pixel moves to one of these, or a part that is hidden just beside it shows.
        let has_moved = around.clone().any(|other| apart(pixel, other) <= 16);
        let is_edge = around.clone().any(|other| apart(b.get_pixel(x, y), other) > 16);
        counts[1] += usize::from(!has_moved && !is_edge);
    }
    counts
}

/// A curve that is turned about the z axis, and the same moved along y beside it.
fn swept() -> Model {
    let nurbs = |x: f64, y: f64| {
        let points = [[1.0, 0.0], [2.0, 0.5], [1.5, 2.0], [2.5, 3.0], [2.0, 4.0]];
        let points = points.map(|[along, z]| format!("{} {y} {z} 1 ", x + along)).concat();
        format!("range 0 1 nurbs degree 3 knots 9 0 0 0 0 0.5 1 1 1 1 points 5 {points}")
    };
    let circle = |radius: f64, z: f64| {
        format!("range 0 6.283185307179586 circle origin 0 0 {z} x 1 0 0 y 0 1 0 z 0 0 1 {radius}")
    };
    let line = |x: f64, z: f64| format!("range 0 2 line {x} -1 {z} 0 1 0");
    let edges = [
        circle(1.0, 0.0),
        circle(2.0, 4.0),
        nurbs(3.0, -1.0),
        nurbs(3.0, 1.0),
        line(4.0, 0.0),
        line(5.0, 4.0),
    ];
    let edges: String = edges.map(|edge| format!("edge tolerance 1e-7 {edge}\n")).concat();
    let text = format!(
        "freeform-model 1\n{edges}
        face tolerance 1e-7 forward bounds 0 6.283185307179586 0 1
          revolution origin 0 0 0 axis 0 0 1 {} loop 1 + 0 loop 1 - 1
        face tolerance 1e-7 forward bounds 0 1 0 2
          extrusion direction 0 1 0 {} loop 4 + 2 + 5 - 3 - 4
        product faces 0 2\nend",
        nurbs(0.0, 0.0),
        nurbs(3.0, -1.0),
    );
    Model::from_text(&text, Path::new("swept.ffm")).unwrap()
}

#[test]
fn faces_and_the_strokes_between_them_end_within_the_tolerance() {
    let mut stage = Stage::new(uvec2(500, 300));
    for name in OWN {
        let scene = load(&path_of(name));
        let mut prepared = stage.prepared(&scene);
        for (tolerance, index) in [(2.0, 0), (0.5, 1), (0.5, 2), (0.25, 3), (0.1, 4)] {
            let camera = Some(random_view(&scene, 7, index, stage.aspect()));
            let shown = Scene { camera, settings: within(tolerance), ..scene.clone() };
            let frame = stage.frame(&shown);
            let measured = stage.measured(&shown, &mut prepared, &frame);
            let error = measured.max_error_px;
            assert!(error <= tolerance, "{name} {index}: {error} px, not {tolerance}");
        }
    }
}

#[test]
fn size_and_place_make_no_difference() {
    let mut stage = Stage::new(uvec2(480, 300));
    let own = ["bracket", "blade", "assembly"].map(|name| {
        let text = std::fs::read_to_string(path_of(name)).unwrap();
        (name, Model::from_text(&text, Path::new("x.ffm")).unwrap())
    });
    let mut models = Vec::from(own);
    models.push(("swept", swept()));
    if let Some(folder) = cad_files() {
        let name = "io1-cm-214.stp";
        models.push((name, Model::load(&folder.join(name), &LoadOptions::default()).unwrap()));
    }
    for (name, model) in models {
        let expected = stage.render(&scene_of(&text_of(&model)));
        let size = model.diagonal();
        for (scale, translation) in [
            (1e-6, DVec3::ZERO),
            (1e-3, DVec3::ZERO),
            (1e6, DVec3::ZERO),
            (1.0, 1e6 * size * DVec3::new(0.3, -0.7, 0.6)),
        ] {
            let scene = scene_of(&text_of(&placed(&model, scale, translation)));
            assert_eq!(scene.models[0].left_out, [], "{name} × {scale}");
            let mut prepared = stage.prepared(&scene);
            let frame = stage.frame(&scene);
            let picture = stage.picture(&mut prepared, &frame);
            assert_eq!(prepared.stats().unmet, None, "{name} × {scale} + {translation}");
            let [differ, inside] = differences(&expected, &picture);
            assert!(
                differ < 300 && inside == 0,
                "{name} × {scale} + {translation}: {differ} {inside}"
            );
        }
    }
}

#[test]
fn both_sides_and_mirrored_uses_are_lit_alike() {
    let mut stage = Stage::new(uvec2(480, 300));
    let text = std::fs::read_to_string(path_of("flange")).unwrap();
    let model = Model::from_text(&text, Path::new("flange.ffm")).unwrap();
    let lens = Lens::Orthographic { height: 1.2 * model.diagonal() };
    let target = DVec3::new(0.0, 0.0, 5.0);
    let camera = Camera::new(target + DVec3::new(300.0, -200.0, 250.0), target, DVec3::Z, lens);
    let render = |stage: &mut Stage, model: &Model| {
        let mut scene = scene_of(&text_of(model));
        scene.camera = Some(*camera.as_ref().unwrap());
        stage.render(&scene)
    };
    let expected = render(&mut stage, &model);
    let mut reversed = model.clone();
    reversed.faces.iter_mut().for_each(|face| face.reversed = !face.reversed);
    assert_eq!(differences(&expected, &render(&mut stage, &reversed)), [0; 2], "reversed");
    // The flange is its own mirror image, but all its surfaces turn the other way.
    let mut mirrored = model.clone();
    let whole = mirrored.products.len() - 1;
    mirrored.products.push(freeform_surface::model::Product {
        name: String::new(),
        color: None,
        faces: [0, 0],
        uses: vec![freeform_surface::model::ProductUse {
            product: whole,
            placement: DAffine3::from_scale(DVec3::new(1.0, -1.0, 1.0)),
            color: None,
        }],
    });
    let [differ, inside] = differences(&expected, &render(&mut stage, &mirrored));
    assert!(differ < 200 && inside == 0, "mirrored: {differ} {inside}");
}

#[test]
fn a_scene_places_models_beside_surfaces() {
    let path = root().join("scene.toml");
    let text = "[[surface]]\ncontrol_points = \"default\"\n\
        [[model]]\nfile = \"resources/models/bracket.ffm\"\nscale = 0.01\ntranslate = [0.0, 0.0, 1.0]\n\
        color = [1.0, 0.5, 0.0]\n\
        [[model]]\nfile = \"resources/models/assembly.ffm\"\n";
    let scene = Scene::from_toml(text, &path).unwrap();
    assert_eq!(scene.models.len(), 2);
    let bracket: Vec<_> =
        scene.surfaces.iter().filter(|s| s.face.is_some_and(|face| face.model == 0)).collect();
    assert_eq!(bracket.len(), scene.models[0].model.faces.len());
    let instances = scene.models[1].model.instances().unwrap();
    assert_eq!(scene.surfaces.len(), 1 + bracket.len() + instances.len());
    assert!(bracket.iter().all(|s| s.transform.w_axis.truncate() == DVec3::Z));
    // A saved scene names the models, and is the same again.
    let saved = scene.to_toml(&path).unwrap();
    assert_eq!(saved.files, []);
    let again = Scene::from_toml(&saved.text, &path).unwrap();
    assert_eq!(again.surfaces, scene.surfaces);
    assert!(
        again
            .models
            .iter()
            .zip(&scene.models)
            .all(|(a, b)| Arc::ptr_eq(&a.model, &b.model) || a == b)
    );
    let wrong = "[[model]]\nfile = \"no.ffm\"\n";
    let error = Scene::from_toml(wrong, &path).unwrap_err().to_string();
    assert!(error.contains("scene.toml:2") && error.contains("no.ffm"), "{error}");
}

/// Surfaces that are alike share the grids of their trims. What is cut out of one of them is not cut out of the other.
#[test]
fn trims_of_one_of_two_alike_change_without_the_other() {
    let mut stage = Stage::new(uvec2(480, 300));
    let flange = load(&path_of("flange"));
    let holes = |one: &&Surface| one.trims.loops.len();
    let mut plate = flange.surfaces.iter().max_by_key(holes).unwrap().clone();
    plate.face = None;
    let [low, high] = bounds(&plate);
    let mut other = plate.clone();
    other.transform = DMat4::from_translation(1.2 * (high - low)) * plate.transform;
    let scene = Scene { surfaces: vec![plate, other], settings: within(0.5), ..Scene::default() };
    for changed in [0, 1] {
        let mut expected = scene.clone();
        // Fewer words: they fit where the others are.
        expected.surfaces[changed].trims.loops.truncate(2);
        let frame = stage.frame(&expected);
        let mut prepared = stage.prepared(&scene);
        let before = stage.aovs(&mut prepared, &frame);
        let trims = expected.surfaces[changed].trims.clone();
        prepared.surfaces_mut()[changed].set_trims(trims).unwrap();
        let after = stage.aovs(&mut prepared, &frame);
        let mut anew = stage.prepared(&expected);
        let expected = stage.aovs(&mut anew, &frame);
        assert!(after.depth == expected.depth, "{changed}");
        assert!(after.depth != before.depth, "{changed}: nothing is seen of the change");
    }
}

/// The box around the control points of a surface in the world.
fn bounds(surface: &Surface) -> [DVec3; 2] {
    let points = || surface.world_points();
    [points().fold(DVec3::INFINITY, DVec3::min), points().fold(DVec3::NEG_INFINITY, DVec3::max)]
}
