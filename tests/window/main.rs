//! The window under Xvfb, with real keys and a real mouse from xdotool: the screen must show the expected
//! pictures.

mod drop;
#[path = "../harness/mod.rs"]
mod harness;
mod models;
mod screen;

use std::time::Duration;

use freeform_surface::{Image, Scene};
use glam::{DVec2, DVec3, Vec3Swizzles as _, dvec2};
use harness::program::{Folder, resource, text};
use harness::{assert_same, difference};
use screen::Screen;

/// A lit flat square seen from above, that fills most of the left side of the picture.
const SQUARE: &str = r#"
[camera]
eye = [0.25, 2.0, 0.0]
target = [0.25, 0.0, 0.0]
up = [0.0, 0.0, -1.0]
orthographic_height = 1.2

[render]
level = 4
background = [0.0, 0.0, 0.0, 1.0]

[[surface]]
control_points = "default"
color = [1.0, 1.0, 1.0]
shading = "flat"
"#;

/// Where a point of the world is on the screen.
fn place(scene: &Scene, point: DVec3) -> DVec2 {
    let seen = scene.projection(1000, 600);
    let ndc = (seen.projection * seen.view).project_point3(point);
    (ndc.xy() * dvec2(0.5, -0.5) + 0.5) * dvec2(1000.0, 600.0)
}

/// The number of pixels that differ strongly.
fn changed(before: &Image, after: &Image) -> usize {
    difference(before, after, &[], 16).unwrap().wrong
}

/// The number of red lines that a row of the picture crosses.
fn lines(picture: &Image, y: u32) -> usize {
    let red = |x: u32| {
        let [r, g, b, _] = picture.get_pixel(x, y).0;
        r > 200 && g < 60 && b < 60
    };
    (1..picture.width()).filter(|x| red(*x) && !red(x - 1)).count()
}

#[test]
fn every_key_does_what_its_line_says() {
    let folder = Folder::new();
    let scene = folder.write("a.toml", SQUARE);
    folder.write("b.toml", SQUARE.replace("[1.0, 1.0, 1.0]", "[0.0, 1.0, 0.0]"));
    let listed = text(&folder.run(&["view", "--list-bindings"]).stdout);
    let mut screen = Screen::start(&[scene.to_str().unwrap()]);
    // Removes the overlay from the picture.
    screen.keys(&["h", "h"]);
    let start = screen.picture();
    assert!(screen.title().starts_with("a.toml · level 4 · 32 triangles · "), "{}", screen.title());

    screen.keys(&["Up"]);
    assert!(screen.title().contains("· level 5 ·"), "{}", screen.title());
    screen.keys(&["Down", "Down"]);
    assert!(screen.title().contains("· level 3 ·"), "{}", screen.title());
    screen.keys(&["t"]);
    assert!(screen.title().contains("· tolerance 0.5 px ·"), "{}", screen.title());
    screen.keys(&["plus"]);
    assert!(screen.title().contains("· tolerance 1 px ·"), "{}", screen.title());
    screen.keys(&["minus", "minus"]);
    assert!(screen.title().contains("· tolerance 0.2 px ·"), "{}", screen.title());
    // The picture of a flat square does not depend on its tessellation.
    assert_same("view-levels", &start, &screen.picture(), &[], 0);

    // A key that switches something on also switches it off.
    for key in ["w", "u", "c", "i", "l", "b", "n"] {
        screen.keys(&[key]);
        let on = screen.picture();
        assert!(changed(&start, &on) > 1_000, "{key}: {}", changed(&start, &on));
        // The outer one of the nested loops stays.
        if key == "n" {
            screen.keys(&["ctrl+z"]);
            assert_same("view-undo", &start, &screen.picture(), &[], 0);
            screen.keys(&["ctrl+shift+z"]);
            assert_same("view-redo", &on, &screen.picture(), &[], 0);
            screen.keys(&["n"]);
            assert!(changed(&on, &screen.picture()) > 1_000, "the island is cut");
            screen.keys(&["b"]);
        } else {
            screen.keys(&[key]);
        }
        assert_same(&format!("view-{key}-off"), &start, &screen.picture(), &[], 0);
    }
    screen.keys(&["x"]);
    assert!(changed(&start, &screen.picture()) > 50_000);
    screen.keys(&["x"]);
    assert_same("view-x-off", &start, &screen.picture(), &[], 0);
    screen.keys(&["m"]);
    assert!(screen.title().contains("· level 32 ·"), "{}", screen.title());
    screen.keys(&["m"]);
    assert!(screen.title().contains("· tolerance 0.2 px ·"), "{}", screen.title());

    // R and Enter restore the camera.
    let still = screen.picture();
    for key in [
        "Left",
        "Right",
        "Next",
        "Prior",
        "shift+Up",
        "shift+Down",
        "shift+Left",
        "shift+Right",
        "f",
        "1",
        "3",
    ] {
        screen.keys(&[key]);
        assert!(changed(&still, &screen.picture()) > 500, "{key}");
        screen.keys(&[if key == "f" { "Return" } else { "r" }]);
        assert_same(&format!("view-{key}-reset"), &still, &screen.picture(), &[], 0);
    }
    // The scene's camera looks from above.
    screen.keys(&["1"]);
    assert!(changed(&still, &screen.picture()) > 500);
    screen.keys(&["7"]);
    assert_same("view-top", &still, &screen.picture(), &[], 0);
    screen.mouse(&["mousemove", "700", "560", "mousedown", "1"]);
    screen.mouse_draws(&["mousemove", "720", "450"]);
    screen.mouse(&["mouseup", "1"]);
    assert!(changed(&still, &screen.picture()) > 500, "the mouse turns the camera");
    screen.mouse(&["mousemove", "500", "590"]);
    screen.keys(&["5"]);
    let perspective = screen.picture();
    assert!(changed(&still, &perspective) > 500);
    screen.keys(&["5"]);
    assert!(changed(&perspective, &screen.picture()) > 500);
    screen.keys(&["r"]);

    screen.keys(&["space"]);
    let frames = screen.frames();
    std::thread::sleep(Duration::from_millis(500));
    assert!(screen.frames() > frames + 3, "the turntable turns");
    screen.keys(&["space"]);
    assert!(changed(&still, &screen.picture()) > 500);
    screen.keys(&["r"]);

    // P and E need a mesh, and report if there is no mesh.
    for key in ["p", "e"] {
        screen.keys(&[key]);
        assert!(changed(&still, &screen.picture()) > 50, "{key} says what it needs");
    }
    screen.keys(&["r"]);
    assert_same("view-message-gone", &still, &screen.picture(), &[], 0);

    screen.keys(&["F1"]);
    assert!(changed(&still, &screen.picture()) > 5_000, "the panel");
    screen.keys(&["F1"]);
    assert!(changed(&still, &screen.picture()) > 50_000, "the help");
    screen.keys(&["F1", "F12", "F12", "ctrl+s"]);
    for name in ["a-001.png", "a-002.png", "a-edited-001.toml"] {
        assert!(folder.path(name).is_file(), "{name}");
    }
    screen.keys(&["Tab"]);
    assert!(screen.title().starts_with("b.toml"), "{}", screen.title());
    screen.keys(&["Tab"]);
    assert!(screen.title().starts_with("a-edited-001.toml"), "{}", screen.title());
    screen.quit("ctrl+q");

    // A new line in the list needs a test: here, or below for meshes, files and the mouse.
    for line in listed.lines() {
        let known = "Up, Down |T |+, − |W |C |I |L |B |N |M |X |P |E |Space |Tab |R, Enter |F |1, 3, 7 |5 |\
            Left, Right |Page Up, Page Down |Shift+Up, |D |U |Z |V |A |Ctrl+Z |Ctrl+Shift+Z |Ctrl+S |F12 |\
            H, F1 |Esc, Ctrl+Q |click |left drag |Shift + left drag, |wheel, |drop a file ";
        let is_known = known.split('|').any(|known| line.starts_with(known));
        assert!(is_known, "not tested: {line}");
    }
}

#[test]
fn twice_the_level_has_twice_the_lines() {
    let folder = Folder::new();
    let scene = folder.write("a.toml", SQUARE);
    let mut screen = Screen::start(&[scene.to_str().unwrap()]);
    screen.keys(&["h", "h", "w", "Up", "Up", "Up", "Up"]);
    assert!(screen.title().contains("· level 8 ·"), "{}", screen.title());
    // This row lies between the ends of the diagonals.
    let coarse = lines(&screen.picture(), 317);
    screen.keys(&["Up"; 8]);
    assert!(screen.title().contains("· level 16 ·"), "{}", screen.title());
    let fine = lines(&screen.picture(), 317);
    // n columns have n + 1 lines between them and n diagonals.
    assert_eq!((coarse, fine), (17, 33));
    screen.quit("Escape");
}

#[test]
fn a_dragged_point_is_where_the_mouse_is_and_a_trim_takes_its_pixels() {
    let folder = Folder::new();
    let path = folder.write("a.toml", SQUARE);
    let scene = Scene::load(&path).unwrap();
    let mut screen = Screen::start(&[path.to_str().unwrap()]);
    screen.keys(&["h", "h"]);
    let before = screen.picture();
    let middle = place(&scene, DVec3::ZERO).as_uvec2();
    assert_eq!(before.get_pixel(middle.x, middle.y).0, [255, 255, 255, 255]);
    screen.keys(&["c"]);
    let cut = screen.picture();
    assert_eq!(cut.get_pixel(middle.x, middle.y).0, [0, 0, 0, 255]);
    let holes = before.pixels().zip(cut.pixels()).filter(|(a, b)| a != b).count();
    // A circle of radius 0.2 in a square that is 500 pixels wide.
    let expected = std::f64::consts::PI * 100.0 * 100.0;
    assert!((holes as f64 - expected).abs() < 0.01 * expected, "{holes} {expected}");
    screen.keys(&["c", "w"]);

    // The left front corner.
    let from = place(&scene, scene.surfaces[0].control_points()[0].truncate());
    let to = dvec2(60.0, 480.0);
    let beside = [format!("{}", from.x as i32 + 6), format!("{}", from.y as i32)];
    screen.mouse_draws(&["mousemove", &beside[0], &beside[1]]);
    let hovered = screen.picture();
    let gold = |picture: &Image| {
        picture
            .pixels()
            .filter(|pixel| pixel.0[0] > 200 && pixel.0[1] > 150 && pixel.0[2] < 120)
            .count()
    };
    assert!(gold(&hovered) > 20, "the point under the cursor is highlighted");
    screen.mouse(&["mousemove", &format!("{}", from.x as i32), &format!("{}", from.y as i32)]);
    screen.mouse(&["mousedown", "1"]);
    let (x, y) = (to.x.to_string(), to.y.to_string());
    screen.mouse_draws(&["mousemove", "100", "500"]);
    screen.mouse_draws(&["mousemove", &x, &y]);
    screen.mouse(&["mouseup", "1"]);
    let moved = screen.picture();
    let blue = |picture: &Image, place: DVec2| {
        let [r, g, b, _] = picture.get_pixel(place.x as u32, place.y as u32).0;
        r < 40 && (100..160).contains(&g) && b > 200
    };
    assert!(blue(&moved, to) && !blue(&moved, from), "the point is where the mouse is");
    screen.keys(&["ctrl+s"]);
    let saved = Scene::load(&folder.path("a-edited-001.toml")).unwrap();
    let point = saved.surfaces[0].control_points()[0].truncate();
    assert!(place(&saved, point).distance(to) < 1.0);
    screen.keys(&["ctrl+z"]);
    screen.mouse(&["mousemove", "500", "550"]);
    let back = screen.picture();
    assert!(blue(&back, from) && !blue(&back, to), "one step takes the whole drag back");
    screen.quit("Escape");
}

#[test]
fn a_trim_is_pulled_in_the_panel() {
    let folder = Folder::new();
    let path = folder.write("a.toml", SQUARE);
    let mut screen = Screen::start(&[path.to_str().unwrap()]);
    screen.keys(&["c"]);
    let before = screen.picture();
    // The points of the inset; the leftmost one is the circle's centre.
    let points =
        before.enumerate_pixels().filter(|(x, _, pixel)| *x > 700 && pixel.0 == [0, 128, 255, 255]);
    let (x, y, _) = points.min_by_key(|(x, y, _)| (*x, *y)).expect("the inset has points");
    let [from, to] = [(x + 2, y), (x + 32, y - 20)].map(|(x, y)| [x.to_string(), y.to_string()]);
    screen.mouse(&["mousemove", &from[0], &from[1]]);
    screen.mouse(&["mousedown", "1"]);
    for step in [10, 20] {
        screen.mouse_draws(&["mousemove", &(x + step).to_string(), &(y - step).to_string()]);
    }
    screen.mouse_draws(&["mousemove", &to[0], &to[1]]);
    screen.mouse(&["mouseup", "1"]);
    screen.mouse(&["mousemove", "500", "590"]);
    assert!(changed(&before, &screen.picture()) > 5_000, "the hole moves");
    screen.keys(&["ctrl+s", "ctrl+z", "h", "h", "h"]);
    let saved = Scene::load(&folder.path("a-edited-001.toml")).unwrap();
    let center = saved.surfaces[0].trims.circles[0].center;
    assert!(center.distance(dvec2(0.5, 0.5) + dvec2(30.0, 20.0) / 172.0) < 0.02, "{center}");
    assert!(changed(&before, &screen.picture()) < 500, "one step takes the pull back");
    screen.quit("Escape");
}

#[test]
fn the_window_shows_what_render_draws() {
    let folder = Folder::new();
    let scenes = [
        "scenes/thesis/fig24.toml",
        "scenes/report/wireframe.toml",
        "scenes/gallery/gear.toml",
        "surfaces/teapot.bpt",
        "meshes/figure.obj",
    ];
    for name in scenes {
        // The scene is in a folder of its own, because pictures and copies are written there.
        let from = resource(name);
        let file = from.rsplit('/').next().unwrap();
        let at = Folder::new();
        let copy = at.write(file, std::fs::read(&from).unwrap());
        let there = std::fs::read_to_string(&copy).unwrap();
        let textures = format!("{}/", resource("textures"));
        std::fs::write(&copy, there.replace("../../textures/", &textures)).unwrap();
        let mut screen = Screen::start(&[copy.to_str().unwrap()]);
        // The last three keys remove the message and change nothing.
        screen.keys(&["h", "h", "Right", "Prior", "ctrl+s", "h", "h", "h"]);
        let stem = file.split('.').next().unwrap();
        let saved = at.path(&format!("{stem}-edited-001.toml"));
        let shown = screen.picture();
        let output = at.path("rendered.png");
        let arguments = ["render", saved.to_str().unwrap(), "-o", output.to_str().unwrap()];
        let run = folder.run(&arguments);
        assert!(run.status.success(), "{}", text(&run.stderr));
        let rendered = image::open(&output).unwrap().into_rgba8();
        assert_same(&format!("view-{stem}"), &rendered, &shown, &[], 0);
        screen.quit("Escape");
    }
}

#[test]
fn at_rest_nothing_is_drawn() {
    let mut screen = Screen::start(&[]);
    screen.mouse_draws(&["mousemove", "300", "560"]);
    // If other windows share a few processors, the last frame of the mouse may come late.
    std::thread::sleep(Duration::from_secs(2));
    screen.rest();
    let (frames, cpu) = (screen.frames(), screen.cpu());
    std::thread::sleep(Duration::from_secs(5));
    assert_eq!(screen.frames(), frames);
    let used = screen.cpu() - cpu;
    assert!(used < Duration::from_millis(50), "{used:?} in 5 s");
    screen.quit("Escape");
}

#[test]
fn broken_files_and_tiny_windows_lose_nothing() {
    let folder = Folder::new();
    let path = folder.write("a.toml", SQUARE);
    let mut screen = Screen::start(&["--watch", path.to_str().unwrap()]);
    screen.keys(&["h", "h"]);
    let start = screen.picture();
    std::fs::write(&path, "[[surface]]\ncontrol_points = 1\n").unwrap();
    std::thread::sleep(Duration::from_millis(400));
    screen.rest();
    let broken = screen.picture();
    let off = changed(&start, &broken);
    assert!((50..40_000).contains(&off), "an error over the last good scene: {off}");
    std::fs::write(&path, SQUARE.replace("[1.0, 1.0, 1.0]", "[0.0, 0.0, 1.0]")).unwrap();
    std::thread::sleep(Duration::from_millis(400));
    screen.rest();
    assert!(changed(&start, &screen.picture()) > 50_000, "the file as it is now");
    let blue = screen.picture();
    for (width, height) in [("1", "1"), ("1000", "600"), ("37", "300"), ("1000", "600")] {
        screen.resize(width, height);
    }
    screen.hide_and_show();
    assert_same("view-shown-again", &blue, &screen.picture(), &[], 0);
    screen.keys(&["c", "c"]);
    screen.quit("Escape");
}

#[test]
fn every_file_that_a_scene_names_is_watched() {
    let folder = Folder::new();
    let save = |color: [u8; 4]| {
        let picture = image::RgbaImage::from_pixel(4, 4, image::Rgba(color));
        // Editors replace the file by another one.
        picture.save(folder.path("new.png")).unwrap();
        std::fs::rename(folder.path("new.png"), folder.path("picture.png")).unwrap();
    };
    save([255, 255, 255, 255]);
    let textured = SQUARE.replace("color = [1.0, 1.0, 1.0]", "texture = \"picture.png\"");
    assert_ne!(textured, SQUARE);
    let path = folder.write("a.toml", textured.replace("\"flat\"", "\"texture\""));
    let mut screen = Screen::start(&["--watch", path.to_str().unwrap()]);
    screen.keys(&["h", "h"]);
    let start = screen.picture();
    save([0, 0, 255, 255]);
    std::thread::sleep(Duration::from_millis(400));
    screen.rest();
    assert!(changed(&start, &screen.picture()) > 50_000, "the picture as it is now");
    screen.quit("Escape");
}

#[test]
fn dropped_files_open_and_what_is_none_is_told() {
    let folder = Folder::new();
    let path = folder.write("a.toml", SQUARE);
    let other = folder.write("b.toml", SQUARE.replace("[1.0, 1.0, 1.0]", "[0.0, 1.0, 0.0]"));
    let broken = folder.write("broken.toml", "[[surface]]\ncontrol_points = 1\n");
    let mut screen = Screen::start(&[path.to_str().unwrap()]);
    screen.keys(&["h", "h"]);
    let start = screen.picture();
    screen.drop_file(&other);
    let green = screen.picture();
    assert!(changed(&start, &green) > 50_000);
    assert!(screen.title().starts_with("b.toml"), "{}", screen.title());
    for wrong in [broken.as_path(), folder.root()] {
        screen.drop_file(wrong);
        let off = changed(&green, &screen.picture());
        assert!((50..40_000).contains(&off), "an error over the last good scene: {off}");
        assert!(screen.title().starts_with("b.toml"), "{}", screen.title());
    }
    screen.quit("Escape");
}

#[test]
fn the_mouse_pans_and_its_wheel_zooms_to_the_cursor() {
    let folder = Folder::new();
    let path = folder.write("a.toml", SQUARE);
    let mut screen = Screen::start(&[path.to_str().unwrap()]);
    screen.keys(&["h", "h"]);
    let start = screen.picture();
    let white = |picture: &Image| {
        // Leaves out the gold highlight of the corner under the cursor.
        let lit = picture.enumerate_pixels().filter(|(_, _, pixel)| pixel.0[2] > 128);
        lit.fold([u32::MAX, u32::MAX, 0, 0], |[a, b, c, d], (x, y, _)| {
            [a.min(x), b.min(y), c.max(x), d.max(y)]
        })
    };
    let [left, top, right, bottom] = white(&start);
    // Both ways of panning move the square.
    let shift =
        (&["keydown", "shift", "mousedown", "1"][..], &["mouseup", "1", "keyup", "shift"][..]);
    for (down, up) in [shift, (&["mousedown", "2"], &["mouseup", "2"])] {
        screen.mouse(down);
        screen.mouse_draws(&["mousemove", "530", "570"]);
        screen.mouse(up);
        let expected = [left + 30, top - 20, right + 30, bottom - 20];
        assert_eq!(white(&screen.picture()), expected, "{down:?}");
        screen.keys(&["r"]);
        screen.mouse(&["mousemove", "500", "590"]);
    }
    // The corner under the cursor stays.
    screen.mouse(&["mousemove", &left.to_string(), &bottom.to_string()]);
    screen.mouse_draws(&["click", "4"]);
    let [nearer_left, nearer_top, nearer_right, nearer_bottom] = white(&screen.picture());
    assert_eq!([nearer_left, nearer_bottom], [left, bottom]);
    assert!(nearer_right > right + 20 && nearer_top < top, "{nearer_right} {nearer_top}");
    screen.mouse_draws(&["click", "5"]);
    let back = white(&screen.picture());
    assert!(back[2].abs_diff(right) <= 1 && back[1].abs_diff(top) <= 1, "{back:?}");
    screen.quit("Escape");
}

#[test]
fn a_mesh_is_smoothed_by_its_keys_and_a_right_drag_zooms() {
    let folder = Folder::new();
    let bytes = std::fs::read(resource("meshes/icosahedron.obj")).unwrap();
    let path = folder.write("a.obj", bytes);
    let mut screen = Screen::start(&[path.to_str().unwrap()]);
    screen.keys(&["h", "h", "p"]);
    let phong = screen.picture();
    screen.keys(&["e"]);
    let pn = screen.picture();
    assert!(changed(&phong, &pn) > 500, "{}", changed(&phong, &pn));
    screen.keys(&["e"]);
    let plain = screen.picture();
    assert!(changed(&pn, &plain) > 500 && changed(&phong, &plain) > 500);
    screen.keys(&["p"]);
    assert_same("view-phong-again", &phong, &screen.picture(), &[], 0);
    let covered = |picture: &Image| {
        let corner = *picture.get_pixel(0, 0);
        picture.pixels().filter(|pixel| **pixel != corner).count()
    };
    screen.mouse(&["mousemove", "500", "300", "mousedown", "3"]);
    screen.mouse_draws(&["mousemove", "500", "400"]);
    screen.mouse(&["mouseup", "3"]);
    let farther = covered(&screen.picture());
    assert!(farther > 1_000 && 4 * farther < 3 * covered(&phong), "{farther} {}", covered(&phong));
    screen.quit("Escape");
}

#[test]
fn ten_thousand_random_events_do_no_harm() {
    const KEYS: [&str; 33] = [
        "Up",
        "Down",
        "t",
        "plus",
        "minus",
        "w",
        "c",
        "i",
        "l",
        "b",
        "n",
        "m",
        "x",
        "p",
        "e",
        "space",
        "r",
        "Return",
        "f",
        "1",
        "3",
        "7",
        "5",
        "h",
        "F1",
        "Left",
        "Right",
        "Next",
        "Prior",
        "shift+Up",
        "shift+Left",
        "ctrl+z",
        "ctrl+shift+z",
    ];
    let folder = Folder::new();
    let path = folder.write("a.toml", SQUARE);
    folder.write("b.obj", std::fs::read(resource("meshes/icosahedron.obj")).unwrap());
    let mut screen = Screen::start(&[path.to_str().unwrap()]);
    let mut random = 0x2545_F491_4F6C_DD1D_u64;
    let mut below = |bound: u64| {
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        ((random >> 32) * bound) >> 32
    };
    let mut script = String::new();
    for number in 0..10_000 {
        let line = match below(10) {
            0..4 => format!("key --delay 0 {}", KEYS[below(33) as usize]),
            4..7 => format!("mousemove {} {}", below(1000), below(600)),
            7 => format!("mousedown {}", 1 + below(3)),
            8 => format!("mouseup {}", 1 + below(3)),
            _ => format!("click --delay 0 {}", 4 + below(2)),
        };
        script.push_str(&line);
        script.push('\n');
        // Actions that write files or open other files, once in a while.
        if number % 1_000 == 999 {
            script.push_str("key --delay 0 F12\nkey --delay 0 ctrl+s\nkey --delay 0 Tab\n");
        }
    }
    script.push_str("mouseup 1\nmouseup 2\nmouseup 3\nmousemove 20 590\nclick 1\n");
    screen.rush(&script);
    // The turntable may be on.
    if !screen.rests_within(Duration::from_secs(30)) {
        screen.rush("key space\n");
    }
    screen.rest();
    assert!(folder.path("a-001.png").is_file());
    screen.quit("ctrl+q");
}

#[test]
fn without_a_display_it_says_what_draws_without_one() {
    let folder = Folder::new();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_freeform"))
        .arg("view")
        .current_dir(folder.root())
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.contains("freeform render"), "{error}");
}
