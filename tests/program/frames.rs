//! `freeform render` with a moving camera: turntables, and the keys of scenes.

use crate::batch::tree;
use crate::harness::program::{Folder, SCENE, resource, text};

const SIZE: [&str; 2] = ["--resolution", "60x40"];

/// A surface of which no two views are alike.
const SURFACE: &str = "[[surface]]\ncontrol_points = \"default\"\ntexture = \"brick.png\"\n";

/// A folder with the texture of the surface.
fn with_brick() -> Folder {
    let folder = Folder::new();
    folder.write("brick.png", std::fs::read(resource("textures/brick.png")).unwrap());
    folder
}

fn render(folder: &Folder, arguments: &[&str]) -> String {
    let output = folder.run(&[&["render"], arguments, &SIZE[..]].concat());
    assert!(output.status.success(), "{output:?}");
    text(&output.stdout)
}

fn image(folder: &Folder, name: &str) -> image::RgbaImage {
    image::open(folder.path(name)).unwrap().into_rgba8()
}

/// The picture of the surface from a place, drawn alone.
fn still(folder: &Folder, camera: &str) -> image::RgbaImage {
    folder.write("still.toml", format!("camera = {{ {camera} }}\n{SURFACE}"));
    render(folder, &["still.toml", "-o", "still.png"]);
    image(folder, "still.png")
}

/// Whether two pictures are the same but for the rounding of a camera.
fn same(a: &image::RgbaImage, b: &image::RgbaImage) -> bool {
    let differ = a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count();
    a.dimensions() == b.dimensions() && differ <= 8
}

#[test]
fn a_turntable_goes_around_the_target() {
    let folder = with_brick();
    let camera = "eye = [2, 1.5, 0.5], target = [0.5, 0, 0.5]";
    folder.write("a.toml", format!("camera = {{ {camera} }}\n{SURFACE}"));
    let said = render(&folder, &["a.toml", "--turntable", "4", "-o", "turn"]);
    assert!(said.contains("4 made"), "{said}");
    let eyes = ["[2, 1.5, 0.5]", "[0.5, 1.5, -1]", "[-1, 1.5, 0.5]", "[0.5, 1.5, 2]"];
    let stills = eyes.map(|eye| still(&folder, &format!("eye = {eye}, target = [0.5, 0, 0.5]")));
    for (number, still) in stills.iter().enumerate() {
        assert!(same(&image(&folder, &format!("turn/a-000{}.png", number + 1)), still), "{number}");
    }
    assert!(!same(&stills[0], &stills[1]) && !same(&stills[1], &stills[3]));
    // Around another axis, the vertical direction turns too.
    render(&folder, &["a.toml", "--turntable", "4", "--axis", "x", "--frames", "2-2", "-o", "x"]);
    let over = "eye = [2, 0, 2], target = [0.5, 0, 0.5], up = [0, 0, 1]";
    assert!(same(&image(&folder, "x/a-0002.png"), &still(&folder, over)));
    assert_eq!(tree(&folder.path("x")).len(), 2);
}

#[test]
fn a_scene_without_a_camera_stays_in_the_picture_and_fills_it() {
    let folder = Folder::new();
    // Long in one direction.
    let points: Vec<String> = (0..16).map(|i| format!("[{}, {}, 0]", 5 * (i % 4), i / 4)).collect();
    let surface = format!("[[surface]]\ncontrol_points = [{}]\n", points.join(", "));
    folder.write("long.toml", surface);
    render(&folder, &["long.toml", "--turntable", "8", "-o", "turn", "--samples", "1"]);
    let mut largest = 0;
    for frame in 1..=8 {
        let picture = image(&folder, &format!("turn/long-000{frame}.png"));
        let (width, height) = picture.dimensions();
        let background = *picture.get_pixel(0, 0);
        let drawn: Vec<_> =
            picture.enumerate_pixels().filter(|(.., p)| **p != background).collect();
        let is_at_border = |x, y| x == 0 || y == 0 || x == width - 1 || y == height - 1;
        assert!(
            !drawn.is_empty() && !drawn.iter().any(|(x, y, _)| is_at_border(*x, *y)),
            "{frame}"
        );
        let columns = drawn.iter().map(|(x, ..)| *x);
        largest = largest.max(columns.clone().max().unwrap() - columns.min().unwrap());
    }
    assert!(largest > 60 * 3 / 4, "{largest} of 60 columns");
}

#[test]
fn frames_do_not_depend_on_each_other() {
    let folder = with_brick();
    folder.write("a.toml", SURFACE);
    folder.write("b.bpt", std::fs::read(resource("surfaces/teapot.bpt")).unwrap());
    folder.write("c.ffm", std::fs::read(resource("models/bracket.ffm")).unwrap());
    let turn = ["a.toml", "b.bpt", "c.ffm", "--turntable", "12"];
    render(&folder, &[&turn[..], &["-o", "whole", "--jobs", "1"]].concat());
    let whole = tree(&folder.path("whole"));
    assert_eq!(whole.len(), 72);
    for count in [3, 7] {
        let out = format!("out{count}");
        for number in 1..=count {
            let shard = format!("{number}/{count}");
            let said = render(&folder, &[&turn[..], &["-o", &out, "--shard", &shard]].concat());
            assert!(said.contains(" 0 kept, 0 failed"), "{said}");
        }
        assert!(tree(&folder.path(&out)) == whole, "{count}");
    }
    let resume = [&turn[..], &["-o", "whole", "--resume"]].concat();
    assert!(render(&folder, &resume).contains("0 made, 36 kept"));
    assert!(render(&folder, &[&resume[..], &["--axis", "x"]].concat()).contains("36 made, 0 kept"));
    let other = [&turn[..3], &["--turntable", "13", "-o", "whole", "--resume"]].concat();
    assert!(render(&folder, &other).contains("39 made, 0 kept"));
}

#[test]
fn keys_move_the_camera() {
    let folder = with_brick();
    let key = |time: &str, place: &str| {
        format!(
            "[[camera_key]]\ntime = {time}\n{}\n",
            place.replace(", t", "\nt").replace(", u", "\nu")
        )
    };
    let places = [
        "eye = [2, 1.5, 0.5], target = [0.5, 0, 0.5]",
        "eye = [0, 1.5, 2], target = [0.5, 0, 0.5], up = [1, 1, 0]",
    ];
    let keys = key("2", places[0]) + &key("4", places[1]);
    folder.write("a.toml", format!("{SURFACE}{keys}"));
    render(&folder, &["a.toml", "--frames", "0-6", "-o", "move"]);
    let [first, last] = places.map(|place| still(&folder, place));
    // Half way, and the keys themselves, before and after which the camera stands still.
    let middle = "eye = [1, 1.5, 1.25], target = [0.5, 0, 0.5], up = [0.5, 1, 0]";
    let middle = still(&folder, middle);
    for (frame, still) in [(0, &first), (2, &first), (3, &middle), (4, &last), (6, &last)] {
        assert!(same(&image(&folder, &format!("move/a-000{frame}.png")), still), "{frame}");
    }
    assert!(!same(&first, &middle) && !same(&middle, &last));
    // Without frames, the camera is that of the first key; the lens is that of the scene's camera.
    render(&folder, &["a.toml", "-o", "one.png"]);
    assert!(same(&image(&folder, "one.png"), &first));
    let lens = "fov_y_degrees = 20";
    folder.write("b.toml", format!("camera = {{ {}, {lens} }}\n{SURFACE}{keys}", places[1]));
    render(&folder, &["b.toml", "--frames", "2-2", "-o", "b.png"]);
    assert!(same(&image(&folder, "b.png"), &still(&folder, &format!("{}, {lens}", places[0]))));
}

#[test]
fn wrong_frames_are_refused_in_one_line() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let key = |rest: &str| {
        format!("surface = [{{ control_points = \"default\" }}]\n[[camera_key]]\n{rest}\n")
    };
    let good = "time = 1\neye = [1, 1, 1]\ntarget = [0, 0, 0]\n";
    folder.write("late.toml", key(good) + "[[camera_key]]\n" + good);
    folder.write("same.toml", key("time = 1\neye = [1, 1, 1]\ntarget = [1, 1, 1]"));
    folder.write("none.toml", key("eye = [1, 1, 1]\ntarget = [1, 1, 1]"));
    folder.write(
        "through.toml",
        key(good) + "[[camera_key]]\ntime = 3\neye = [-1, -1, -1]\ntarget = [0, 0, 0]",
    );
    for (arguments, status, words) in [
        (&["a.toml", "--turntable", "0"][..], 2, "1..=9999999"),
        (&["a.toml", "--axis", "x"], 2, "--turntable"),
        (&["a.toml", "--turntable", "4", "--axis", "w"], 2, "x, y, z"),
        (&["a.toml", "--frames", "4-1"], 2, "A at most B"),
        (&["a.toml", "--turntable", "4", "--frames", "2-5"], 1, "1 to 4"),
        (&["a.toml", "--turntable", "4", "-o", "a.png"], 1, "a.png for several pictures"),
        (&["a.toml", "--frames", "1"], 1, "without a moving camera"),
        (
            &["late.toml", "-o", "a.png"],
            1,
            "late.toml:7: camera key time is 1; expected more than 1",
        ),
        (&["same.toml", "-o", "a.png"], 1, "same.toml:2: camera eye"),
        (&["none.toml", "-o", "a.png"], 1, "none.toml:2: missing field `time`"),
        (&["through.toml", "--frames", "2"], 1, "through.toml, frame 2: camera eye is [0, 0, 0]"),
    ] {
        let output = folder.run(&[&["render"], arguments, &SIZE[..]].concat());
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{said}");
        let first = said.lines().next().unwrap();
        assert!(first.contains(words), "{words}: {said}");
    }
    assert!(!tree(folder.root()).keys().any(|name| name.ends_with(".png")));
}
