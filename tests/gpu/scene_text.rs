//! Scenes as text: a scene that is written and read back draws the same picture.

use std::path::{Path, PathBuf};

use crate::harness::{assert_same, load, render, root};
use freeform_surface::{
    CameraKey, CameraPath, FillRule, Keep, Paint, Scene, Shading, TrimPath, Trims,
};
use glam::{DMat4, DVec3, UVec2, dvec3};

const SIZE: UVec2 = UVec2::new(160, 96);

/// All scenes of the resources that are readable.
fn scenes() -> Vec<PathBuf> {
    let folders = ["thesis", "report", "stability", "gallery"].map(|name| format!("scenes/{name}"));
    let mut scenes = Vec::new();
    for folder in folders.iter().map(String::as_str).chain(["surfaces", "meshes"]) {
        for entry in std::fs::read_dir(root().join("resources").join(folder)).unwrap() {
            let path = entry.unwrap().path();
            if path.is_file() && !path.to_string_lossy().contains("refused") {
                scenes.push(path);
            }
        }
    }
    scenes.sort();
    scenes
}

/// Writes a scene as if to the folder of its file, and reads the text back.
fn again(scene: &Scene, path: &Path) -> Scene {
    let written = scene.to_toml(path).unwrap();
    if !written.files.is_empty() {
        // A mesh with creases that its file does not have is written to a new file beside the scene.
        assert!(!scene.meshes.is_empty(), "{}: {}", path.display(), written.files.len());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("written.toml");
        let written = scene.to_toml(&path).unwrap();
        for (path, bytes) in &written.files {
            std::fs::write(path, bytes).unwrap();
        }
        std::fs::write(&path, &written.text).unwrap();
        return Scene::load(&path).unwrap();
    }
    Scene::from_toml(&written.text, path).unwrap_or_else(|error| {
        panic!("{error}\n{}", &written.text[..written.text.len().min(2_000)])
    })
}

#[test]
fn every_scene_reads_as_it_was_written() {
    let scenes = scenes();
    assert!(scenes.len() > 80, "{}", scenes.len());
    for path in scenes {
        let scene = load(&path);
        let read = again(&scene, &path.with_file_name("written.toml"));
        assert_eq!(read.settings, scene.settings, "{}", path.display());
        assert!(read.surfaces == scene.surfaces, "{}: surfaces", path.display());
        assert!(read.meshes == scene.meshes, "{}: meshes", path.display());
        if scene.up == DVec3::Y {
            assert_eq!(read.camera, scene.camera, "{}", path.display());
        }
    }
}

#[test]
fn what_was_written_draws_the_same_picture() {
    for name in [
        "scenes/thesis/fig20.toml",
        "scenes/thesis/fig27.toml",
        "scenes/report/textured.toml",
        "scenes/gallery/gear.toml",
        "scenes/stability/tess-rational-sphere.toml",
        "meshes/figure.obj",
    ] {
        let path = root().join("resources").join(name);
        let mut scene = load(&path);
        scene.camera = Some(scene.framed(5.0 / 3.0));
        let read = again(&scene, &path.with_file_name("written.toml"));
        let backend = crate::harness::backends()[0];
        let name = format!("scene-text-{}", name.replace('/', "-"));
        assert_same(&name, &render(&scene, SIZE, backend), &render(&read, SIZE, backend), &[], 0);
    }
}

#[test]
fn what_no_file_holds_is_written_beside() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = load(&root().join("resources/surfaces/teapot.bpt"));
    let moved = scene.surfaces[0].control_points()[7] + dvec3(0.1, 1.0 / 3.0, -1e-9).extend(0.0);
    scene.surfaces[0].set_control_point(moved, 7).unwrap();
    scene.surfaces[0].paint = Scene::listing16().surfaces[0].paint.clone();
    scene.surfaces[0].shading = Shading::Unlit;
    scene.surfaces[0].transform =
        DMat4::from_rotation_x(0.3) * DMat4::from_scale(DVec3::splat(3.0));
    scene.camera = Some(scene.framed(1.0));
    let key = |time: f64| CameraKey {
        time,
        eye: dvec3(time, 1.0 / 3.0, 2.0),
        target: DVec3::ZERO,
        up: DVec3::Y,
    };
    scene.camera_path = Some(CameraPath::new(vec![key(0.1), key(7.0)]).unwrap());
    let path = folder.path().join("new \"scene\".toml");
    let written = scene.to_toml(&path).unwrap();
    assert_eq!(written.files.len(), 2);
    for (path, bytes) in &written.files {
        std::fs::write(path, bytes).unwrap();
    }
    let read = Scene::from_toml(&written.text, &path).unwrap();
    assert!(read.surfaces == scene.surfaces);
    assert_eq!((read.camera, read.camera_path), (scene.camera, scene.camera_path));
}

#[test]
fn trims_that_are_off_are_left_out() {
    let mut scene = Scene::listing16();
    scene.surfaces[0].trims.circles_on = false;
    let text = scene.to_toml("a.toml".as_ref()).unwrap().text;
    assert!(!text.contains("circle"), "{text}");
}

#[test]
fn paths_keep_their_rules_and_lengths() {
    let mut scene = Scene::listing16();
    scene.surfaces[0].paint = Paint::default();
    let trims = &mut scene.surfaces[0].trims;
    trims.add_svg_path("M.1 .1 L.9 .1 .5 .5 Z").unwrap();
    for rule in [FillRule::NonZero, FillRule::EvenOdd] {
        let many = (0..300).map(|i| format!("M.{i} .3 q.05 .05 .1 0 z")).collect::<String>();
        trims.add_paths(vec![TrimPath::from_svg_path(&many, rule).unwrap()]).unwrap();
    }
    trims.add_paths(vec![TrimPath::default()]).unwrap();
    trims.keep = Keep::Inside;
    let read = |scene: &Scene| {
        let text = scene.to_toml("a.toml".as_ref()).unwrap().text;
        Scene::from_toml(&text, "a.toml".as_ref()).unwrap().surfaces[0].trims.clone()
    };
    let mut written = scene.surfaces[0].trims.clone();
    written.paths.pop();
    assert!(read(&scene) == written);
    // A border may consist of paths alone. If loops are switched off, the paths are left out too.
    scene.surfaces[0].trims.loops.clear();
    written.loops.clear();
    assert!(read(&scene) == written);
    scene.surfaces[0].trims.loops_on = false;
    assert!(read(&scene) == Trims { circles: written.circles, ..Trims::default() });
}

#[test]
fn paths_of_a_document_are_named_as_long_as_they_are_its_own() {
    let path = root().join("resources/scenes/gallery/badge.toml");
    let mut scene = load(&path);
    let paths = scene.surfaces[0].trims.paths.clone();
    let written = |scene: &Scene| {
        let text = scene.to_toml(&path).unwrap().text;
        let read = Scene::from_toml(&text, &path).unwrap();
        assert!(read.surfaces[0].trims == scene.surfaces[0].trims);
        (text.matches("svg = ").count(), text.matches("fill_rule = ").count())
    };
    assert_eq!(written(&scene), (1, 0));
    scene.surfaces[0].trims.paths.insert(0, paths[3].clone());
    scene.surfaces[0].trims.paths.extend(paths.clone());
    assert_eq!(written(&scene), (2, 1));
    scene.surfaces[0].trims.paths.remove(1);
    assert_eq!(written(&scene), (1, paths.len()));
    // A scene that could not be read back is not written.
    scene.surfaces[0].trims.paths = vec![paths[0].clone(); 3_000];
    let error = scene.to_toml(&path).unwrap_err().to_string();
    assert!(error.contains("many paths with rules in an SVG file"), "{error}");
}

#[test]
fn a_matrix_stands_alone_and_is_affine() {
    let scene = |place: &str| {
        let text = format!("[[surface]]\ncontrol_points = \"default\"\n{place}\n");
        Scene::from_toml(&text, "a.toml".as_ref())
    };
    let matrix = "matrix = [[0.0, 2.0, 0.0, 5.0], [1.0, 0.0, 0.0, 6.0], [0.0, 0.0, 3.0, 7.0]]";
    let read = scene(matrix).unwrap().surfaces[0].transform;
    assert_eq!(read.transform_point3(dvec3(1.0, 10.0, 100.0)), dvec3(25.0, 7.0, 307.0));
    let error = scene(&format!("{matrix}\nscale = 2.0")).unwrap_err().to_string();
    assert!(error.contains("a.toml:1") && error.contains("matrix"), "{error}");
    let error = scene("matrix = [[nan, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]").unwrap_err();
    assert!(error.to_string().contains("matrix"), "{error}");
}
