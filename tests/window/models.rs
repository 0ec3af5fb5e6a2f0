//! CAD models in the window, and files that take long to read.

use std::path::Path;
use std::time::{Duration, Instant};

use freeform_surface::inspect::reference::Rays;
use freeform_surface::{Image, Scene};
use glam::{DVec2, dvec2};

use crate::harness::assert_same;
use crate::harness::program::{Folder, resource};
use crate::screen::Screen;
use crate::{SQUARE, changed};

#[test]
fn faces_of_a_dropped_model_are_clicked_hidden_and_shown() {
    let folder = Folder::new();
    let path = folder.write("a.toml", SQUARE);
    let bytes = std::fs::read(resource("models/flange.ffm")).unwrap();
    let model = folder.write("flange.ffm", bytes);
    let broken = folder.write("broken.step", "nothing");
    let mut screen = Screen::start(&[path.to_str().unwrap()]);
    screen.keys(&["h", "h"]);
    let square = screen.picture();
    screen.drop_file(&model);
    let start = screen.picture();
    assert!(screen.title().starts_with("flange.ffm"), "{}", screen.title());
    assert!(changed(&square, &start) > 50_000);

    // Lines along the edges.
    screen.keys(&["d"]);
    let off = changed(&start, &screen.picture());
    assert!((500..20_000).contains(&off), "lines: {off}");
    screen.keys(&["d"]);
    assert_same("view-edges-off", &start, &screen.picture(), &[], 0);
    // Isolines.
    screen.keys(&["u"]);
    let off = changed(&start, &screen.picture());
    assert!((500..100_000).contains(&off), "isolines: {off}");
    screen.keys(&["u"]);
    assert_same("view-isolines-off", &start, &screen.picture(), &[], 0);

    // The middle of the highest visible face.
    let scene = Scene::load(&model).unwrap();
    let place = flange_face(&scene);
    let (x, y) = (place.x.round().to_string(), place.y.round().to_string());
    screen.mouse(&["mousemove", &x, &y]);
    screen.mouse_draws(&["click", "1"]);
    let clicked = screen.picture();
    let off = changed(&start, &clicked);
    assert!((300..60_000).contains(&off), "a line of text and an outline: {off}");
    screen.keys(&["v"]);
    screen.mouse(&["mousemove", "500", "590"]);
    let hidden = screen.picture();
    let pixel = |picture: &Image| picture.get_pixel(place.x as u32, place.y as u32).0;
    assert_ne!(pixel(&hidden), pixel(&start), "another face or the background is visible");
    screen.keys(&["ctrl+z"]);
    assert_same("view-face-undo", &start, &screen.picture(), &[], 0);
    screen.keys(&["ctrl+shift+z"]);
    assert_same("view-face-redo", &hidden, &screen.picture(), &[], 0);
    screen.keys(&["ctrl+s", "h", "h", "h"]);
    let saved = Scene::load(&folder.path("flange-edited-001.toml")).unwrap();
    assert_eq!(saved.surfaces.iter().filter(|surface| surface.hidden).count(), 1);
    screen.keys(&["a"]);
    assert_same("view-face-all", &start, &screen.picture(), &[], 0);

    // What cannot be read leaves the model as it is.
    screen.drop_file(&broken);
    let off = changed(&start, &screen.picture());
    assert!((50..40_000).contains(&off), "an error over the model: {off}");
    assert!(screen.title().starts_with("flange.ffm"), "{}", screen.title());
    screen.quit("Escape");
}

/// Key Z shows what `freeform render --shading` draws, with its scale.
#[test]
fn shadings_are_those_of_pictures() {
    let folder = Folder::new();
    let bytes = std::fs::read(resource("models/blade.ffm")).unwrap();
    let model = folder.write("blade.ffm", bytes);
    let model = model.to_str().unwrap();
    let mut screen = Screen::start(&[model]);
    screen.keys(&["h", "h"]);
    let lit = screen.picture();
    for kind in ["zebra", "isophotes", "curvature", "draft"] {
        screen.keys(&["z"]);
        let path = folder.path("expected.png");
        let out = path.to_str().unwrap();
        let arguments = ["render", model, "--shading", kind, "--resolution", "1000x600", "-o", out];
        assert!(folder.run(&arguments).status.success());
        let expected = image::open(&path).unwrap().to_rgba8();
        let shown = screen.picture();
        assert!(changed(&lit, &shown) > 20_000, "{kind}");
        assert_same(&format!("view-{kind}"), &expected, &shown, &[], 0);
    }
    screen.keys(&["z"]);
    assert_same("view-lit-again", &lit, &screen.picture(), &[], 0);
    screen.quit("Escape");
}

#[cfg(unix)]
#[test]
fn while_a_file_is_read_the_window_stays_alive_and_escape_abandons_it() {
    use std::os::unix::fs::PermissionsExt as _;

    let folder = Folder::new();
    let path = folder.write("a.toml", SQUARE);
    let other = folder.write("b.toml", SQUARE.replace("[1.0, 1.0, 1.0]", "[0.0, 1.0, 0.0]"));
    let part = folder.write("part.step", "endless");
    let script = "#!/bin/sh\necho progress 40 >&2\necho $$ > \"$0.id\"\nexec sleep 300\n";
    let helper = folder.write("helper", script);
    std::fs::set_permissions(&helper, std::fs::Permissions::from_mode(0o755)).unwrap();
    let helper_runs = || {
        let id = std::fs::read_to_string(folder.path("helper.id")).unwrap();
        Path::new("/proc").join(id.trim()).exists()
    };
    let helper_ends = || {
        let start = Instant::now();
        while helper_runs() {
            assert!(start.elapsed() < Duration::from_secs(30), "the helper is left over");
            std::thread::sleep(Duration::from_millis(20));
        }
    };

    let mut screen = Screen::start_with_helper(&[path.to_str().unwrap()], &helper);
    screen.keys(&["h", "h"]);
    let start = screen.picture();
    screen.drop_file(&part);
    let is_text = |off: usize| (50..40_000).contains(&off);
    screen.wait_for("the progress", |picture| is_text(changed(&start, picture)));
    assert!(helper_runs());
    screen.keys(&["Right"]);
    assert!(changed(&start, &screen.picture()) > 50_000 / 4, "the old scene turns");
    assert!(screen.title().starts_with("a.toml"), "{}", screen.title());
    screen.keys(&["r", "Escape"]);
    assert!(is_text(changed(&start, &screen.picture())), "it is told");
    helper_ends();
    screen.keys(&["r"]);
    assert_same("view-abandoned", &start, &screen.picture(), &[], 0);
    // Another file does the same.
    screen.drop_file(&part);
    screen.wait_for("the progress", |picture| is_text(changed(&start, picture)));
    screen.drop_file(&other);
    screen.wait_for("the other file", |picture| changed(&start, picture) > 50_000);
    assert!(screen.title().starts_with("b.toml"), "{}", screen.title());
    helper_ends();
    screen.quit("Escape");

    // The window opens before the first scene is read.
    let mut screen = Screen::start_with_helper(&[part.to_str().unwrap()], &helper);
    assert!(screen.title().contains(" 0 triangles "), "{}", screen.title());
    screen.keys(&["h", "h", "w", "f", "c", "Escape"]);
    helper_ends();
    screen.drop_file(&path);
    screen.wait_for("a scene", |picture| changed(&start, picture) == 0);
    screen.quit("Escape");
}

/// A place on the screen where a face of the flange is visible.
fn flange_face(scene: &Scene) -> DVec2 {
    let seen = scene.projection(1000, 600);
    let to_world = (seen.projection * seen.view).inverse();
    let rays = Rays::new(scene);
    let face_at = |place: DVec2| {
        let ndc = (place / dvec2(1000.0, 600.0) - 0.5) * dvec2(2.0, -2.0);
        let [near, far] = [-1.0, 1.0].map(|depth| to_world.project_point3(ndc.extend(depth)));
        rays.cast(near, far - near).map(|hit| hit.surface)
    };
    let places = (0..600).map(|i| dvec2(f64::from(i % 30) * 30.0, f64::from(i / 30) * 25.0));
    let mut inner = places.filter(|place| {
        let around = [dvec2(8.0, 0.0), dvec2(-8.0, 0.0), dvec2(0.0, 8.0), dvec2(0.0, -8.0)];
        let own = face_at(*place);
        own.is_some() && around.iter().all(|by| face_at(*place + *by) == own)
    });
    inner.next().expect("the flange is visible")
}
