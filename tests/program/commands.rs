//! The program as a user runs it: the files that it writes, its messages, and the files that it leaves alone.

use std::path::Path;
use std::process::Command;

use crate::harness::program::{Folder, SCENE, resource, text};

fn size(path: &Path) -> (u32, u32) {
    image::image_dimensions(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn alone_it_renders_the_default_scene_and_says_what_comes_next() {
    let folder = Folder::new();
    let output = folder.run(&[]);
    let said = text(&output.stdout);
    assert!(output.status.success(), "{output:?}");
    assert!(said.contains("wrote freeform.png") && said.contains("freeform render"), "{said}");
    assert_eq!(size(&folder.path("freeform.png")), (1000, 600));
}

#[test]
fn a_folder_gets_a_picture_for_each_scene() {
    let folder = Folder::new();
    let scenes = [resource("scenes/thesis/fig15.toml"), resource("surfaces/teapot.bpt")];
    let output =
        folder.run(&["render", &scenes[0], &scenes[1], "-o", "out/", "--resolution", "80x60"]);
    assert!(output.status.success(), "{output:?}");
    for name in ["out/fig15.png", "out/teapot.png"] {
        assert_eq!(size(&folder.path(name)), (80, 60));
        assert!(text(&output.stdout).contains(name));
    }
}

#[test]
fn standard_output_gets_the_picture_and_nothing_else() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let output = folder.run(&["render", "a.toml", "-o", "-", "--resolution", "32x24"]);
    let picture = image::load_from_memory(&output.stdout).unwrap();
    assert_eq!((picture.width(), picture.height()), (32, 24));
    assert!(output.stderr.is_empty());
}

#[test]
fn a_scene_comes_from_standard_input() {
    let folder = Folder::new();
    let patch: String = (0..16).map(|i| format!("{} {} 0\n", i % 4, i / 4)).collect();
    let patch = format!("\n1\n3 3\n{patch}");
    let size = ["--resolution", "32x24"];
    let face = "\u{feff}# a face\n\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for (name, text) in [("a.toml", SCENE), ("b.bpt", patch.as_str()), ("c.obj", face)] {
        folder.write(name, text);
        let output = folder.run_with(&[&["render", "-", "-o", "in.png"][..], &size].concat(), text);
        assert!(output.status.success(), "{output:?}");
        assert!(
            folder.run(&[&["render", name, "-o", "file.png"][..], &size].concat()).status.success()
        );
        let [a, b] = ["in.png", "file.png"].map(|name| std::fs::read(folder.path(name)).unwrap());
        assert!(a == b, "{name}");
    }
    // The picture is then named after the program.
    assert!(folder.run_with(&[&["render", "-"][..], &size].concat(), SCENE).status.success());
    assert!(folder.path("freeform.png").exists());
    for (scenes, text, words) in [
        (&["-"][..], "", "cannot read standard input: it is empty"),
        (&["-"], "# v\n\nv = 1\n", "standard input:3: "),
        (&["-", "-"], SCENE, "standard input once"),
    ] {
        let output = folder.run_with(&[&["render"], scenes].concat(), text);
        let said = std::str::from_utf8(&output.stderr).unwrap();
        assert_eq!((output.status.code(), said.lines().count()), (Some(1), 1), "{said}");
        assert!(said.contains(words), "{said}");
    }
}

#[test]
fn what_stands_upright_is_the_same_bare_and_in_a_scene() {
    let folder = Folder::new();
    let teapot = resource("surfaces/teapot.bpt");
    let scene = format!("[[surface]]\nfile = {teapot:?}\n");
    folder.write("plain.toml", &scene);
    folder.write("y.toml", format!("[render]\nup = \"y\"\n{scene}"));
    let render = |arguments: &[&str]| {
        let picture = ["-o", "out.png", "--resolution", "80x60"];
        let output = folder.run(&[&["render"], arguments, &picture].concat());
        assert!(output.status.success(), "{output:?}");
        std::fs::read(folder.path("out.png")).unwrap()
    };
    let bare = render(&[&teapot]);
    assert!(render(&["plain.toml"]) == bare);
    assert!(render(&["y.toml", "--up", "z"]) == bare);
    let lying = render(&["y.toml"]);
    assert!(lying != bare && render(&[&teapot, "--up=y"]) == lying);
    let wrong = folder.run(&["render", &teapot, "--up", "x"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(text(&wrong.stderr).contains("expected y or z"));
}

#[test]
fn a_path_outside_of_the_domain_is_warned_of() {
    let folder = Folder::new();
    let scene = |path: &str| {
        format!("[[surface]]\ncontrol_points = \"default\"\n[[surface.trim]]\npath = \"{path}\"\n")
    };
    for (path, words) in [
        (
            "M2 2 h1 v1 z M-3 .5 h1 v1 z",
            "freeform: warning: a.toml:3: this trim lies wholly outside",
        ),
        // The path reaches into the domain, or one of its subpaths lies in it.
        ("M-1 .5 h1.5 v1 z", ""),
        ("M2 2 h1 v1 z M.2 .2 h.1 v.1 z", ""),
    ] {
        folder.write("a.toml", scene(path));
        let output = folder.run(&["render", "a.toml", "--resolution", "8x8"]);
        let said = text(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert!(if words.is_empty() { said.is_empty() } else { said.starts_with(words) }, "{said}");
        assert!(said.lines().count() <= 1, "{said}");
    }
}

#[test]
fn verbose_tells_of_edges_that_no_surface_has() {
    let folder = Folder::new();
    let fans =
        "v 0 0 0\nv 0 0 1\nv 1 0 0\nv -1 1 0\nv -1 -1 0\nf 1 2 3\nf 1 2 4\nf 2 1 5\nf 1 1 3\n";
    folder.write("fans.obj", fans);
    let quiet = folder.run(&["render", "fans.obj", "--resolution", "8x8"]);
    assert!(quiet.status.success() && quiet.stderr.is_empty(), "{quiet:?}");
    let output = folder.run(&["render", "fans.obj", "--resolution", "8x8", "--verbose"]);
    let said = text(&output.stderr);
    let words = [
        "freeform: fans.obj: 1 edge of more than two triangles; they are borders",
        "freeform: fans.obj: 1 triangle with the same position twice left out",
    ];
    assert!(words.iter().all(|word| said.contains(word)), "{said}");
}

#[test]
fn a_transparent_background_stays_transparent() {
    let folder = Folder::new();
    folder.write("a.toml", format!("render = {{ background = [0, 0, 0, 0] }}\n{SCENE}"));
    assert!(folder.run(&["render", "a.toml", "--resolution", "40x30"]).status.success());
    let picture = image::open(folder.path("a.png")).unwrap().into_rgba8();
    assert_eq!(picture.get_pixel(0, 0).0[3], 0);
    assert_eq!(picture.get_pixel(20, 15).0[3], 255);
}

#[test]
fn flags_win_over_the_scene() {
    let folder = Folder::new();
    folder.write("a.toml", format!("render = {{ level = 32 }}\n{SCENE}"));
    let picture = |flags: &[&str]| {
        let arguments =
            [&["render", "a.toml", "-o", "a.png", "--resolution", "120x90"], flags].concat();
        let output = folder.run(&arguments);
        assert!(output.status.success(), "{output:?}");
        image::open(folder.path("a.png")).unwrap().into_rgba8()
    };
    let drawn = |image: &image::RgbaImage| {
        let background = *image.get_pixel(0, 0);
        image.pixels().filter(|pixel| **pixel != background).count()
    };
    let filled = picture(&[]);
    let coarse = picture(&["--wireframe", "--level", "2"]);
    let fine = picture(&["--wireframe", "--level", "8"]);
    assert!(drawn(&coarse) < drawn(&fine) && drawn(&fine) < drawn(&filled));
    folder.write("b.toml", format!("render = {{ wireframe = true }}\n{SCENE}"));
    let filled_again =
        folder.run(&["render", "b.toml", "--wireframe=false", "--resolution", "120x90"]);
    assert!(filled_again.status.success(), "{filled_again:?}");
    let again = image::open(folder.path("b.png")).unwrap().into_rgba8();
    assert_eq!(drawn(&again), drawn(&filled));
    let points = picture(&["--control-points"]);
    let blue = image::Rgba([0, 128, 255, 255]);
    assert!(points.pixels().filter(|pixel| **pixel == blue).count() >= 16 * 40);
    for backend in crate::harness::backends() {
        assert_eq!(drawn(&picture(&["--backend", &backend.to_string()])), drawn(&filled));
    }
}

#[test]
fn samples_smooth_edges_and_the_method_can_be_chosen() {
    let folder = Folder::new();
    let camera = "camera = { eye = [0, 2, 0], target = [0, 0, 0], up = [0, 0, -1], orthographic_height = 1.3 }";
    let trim = "[[surface.trim]]\npath = \"M.2 .2 L.8 .3 .4 .8Z\"";
    let patch =
        "[[surface]]\ncontrol_points = \"default\"\nshading = \"flat\"\ncolor = [1, 0.5, 0]";
    folder.write(
        "a.toml",
        format!("{camera}\nrender = {{ background = [0, 0, 1, 0] }}\n{patch}\n{trim}"),
    );
    let picture = |samples: &str| {
        let flags = ["--samples", samples, "--resolution", "80x60"];
        let output = folder.run(&[&["render", "a.toml", "-o", "a.png"], &flags[..]].concat());
        assert!(output.status.success(), "{output:?}");
        image::open(folder.path("a.png")).unwrap().into_rgba8()
    };
    for (samples, min) in [("1", 0), ("4", 40), ("16", 80), ("64", 100)] {
        let image = picture(samples);
        let partly: Vec<_> =
            image.pixels().filter(|pixel| !matches!(pixel.0[3], 0 | 255)).collect();
        assert!(partly.len() >= min && (min > 0 || partly.is_empty()), "{samples}");
        // A partly covered pixel keeps the colour of the surface that covers it.
        for pixel in partly {
            let [red, green, blue, _] = pixel.0;
            assert!(red > 245 && (118..140).contains(&green) && blue < 10, "{pixel:?}");
        }
    }
    let words = ["a.toml", "line, line", "two quadratics or two cubics"];
    refused(&folder, &["a.toml", "--method", "thesis"], 1, &words);
    let inside = format!(
        "{patch}\nkeep = \"inside\"\n[[surface.trim]]\nloop = [[[0.2, 0.5], [0.5, 0.9], [0.8, 0.5]], [[0.8, 0.5], [0.5, 0.1], [0.2, 0.5]]]"
    );
    folder.write("b.toml", inside);
    refused(&folder, &["b.toml", "--method", "thesis"], 1, &["b.toml", "keep is \"inside\""]);
}

#[test]
fn verbose_tells_the_parts_of_the_time() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let output =
        folder.run(&["render", "a.toml", "--verbose", "--resolution", "32x24", "--level", "4"]);
    let said = text(&output.stderr);
    for part in ["driver start-up", "shader compilation", "the program's own part", "triangles 32"]
    {
        assert!(said.contains(part), "{said}");
    }
}

#[test]
fn info_names_backend_driver_and_limits() {
    let folder = Folder::new();
    let output = folder.run(&["info"]);
    let said = text(&output.stdout);
    assert!(output.status.success());
    for word in
        ["backend", "renderer", "version", "patch vertices", "tessellation level", "storage"]
    {
        assert!(said.contains(word), "{said}");
    }
}

#[test]
fn info_says_in_one_line_whether_the_driver_is_right() {
    let folder = Folder::new();
    let output = folder.run(&["info", "--check"]);
    let said = text(&output.stdout);
    assert!(output.status.success(), "{said}");
    assert!(said.starts_with("right on ") && said.contains("trimmed pixels"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
}

/// Runs a render that must fail with one line, and checks that an older picture still exists.
fn refused(folder: &Folder, arguments: &[&str], status: i32, words: &[&str]) {
    let old = folder.write("old.png", b"an older picture");
    let arguments = [&["render", "-o", "old.png"], arguments].concat();
    let output = folder.run(&arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
    assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {said}");
    assert_eq!(said.trim_end().lines().count(), 1, "{arguments:?}: {said}");
    assert!(said.starts_with("freeform: "), "{said}");
    assert!(!said.contains("panicked"), "{said}");
    assert_eq!(std::fs::read(old).unwrap(), b"an older picture");
    let parts = std::fs::read_dir(folder.root())
        .unwrap()
        .filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().ends_with(".part"));
    assert_eq!(parts.count(), 0);
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("folder.toml")).unwrap();
    folder.write("empty.toml", "");
    folder.write("blank.bpt", " \n\t\n");
    folder.write("binary.toml", [0x89, b'P', b'N', b'G', 0, 255, 254]);
    folder.write("binary.bpt", [0u8, 1, 2, 3, 27, 7, 9]);
    folder.write("scene.stl", "v 0 0 0");
    folder.write("huge.bpt", "1073741824\n3 3\n1 2 3\n");
    let teapot = std::fs::read_to_string(resource("surfaces/teapot.bpt")).unwrap();
    folder.write("cut.bpt", &teapot[..teapot.len() / 2]);
    for (file, words) in [
        ("none.toml", &["none.toml", "No such file"][..]),
        ("folder.toml", &["folder folder.toml", "without a scene"]),
        ("empty.toml", &["empty.toml", "empty"]),
        ("blank.bpt", &["blank.bpt", "empty"]),
        ("binary.toml", &["binary.toml", "not text"]),
        ("binary.bpt", &["binary.bpt:1:", "no number"]),
        ("scene.stl", &["scene.stl", ".toml, .bpt, .obj, .ffm, .step, .iges or .brep"]),
        ("none.obj", &["none.obj", "No such file"]),
        ("huge.bpt", &["huge.bpt:3:", "ends after 3 of its 48"]),
        ("cut.bpt", &["cut.bpt:", "ends after"]),
    ] {
        refused(&folder, &[file], 1, words);
    }
}

#[test]
fn scenes_with_mistakes_are_refused_with_their_line() {
    let folder = Folder::new();
    let points = |count: usize| vec!["[0, 0, 0]"; count].join(", ");
    folder.write("words.png", "these are words");
    image::GrayImage::new(40_000, 1).save(folder.path("wide.png")).unwrap();
    folder.write("words.svg", "these are words");
    folder.write(
        "lines.svg",
        "<svg xmlns='http://www.w3.org/2000/svg'><path d='M0 0H9V9' fill='none' stroke='red'/></svg>",
    );
    let surface = |rest: &str| format!("[[surface]]\n{rest}\n");
    let trim =
        |rest: &str| surface(&format!("control_points = \"default\"\n[[surface.trim]]\n{rest}"));
    for (toml, words) in [
        ("surface = 3".into(), &[":1:", "invalid type"][..]),
        ("[render]\nlevel = \"high\"".into(), &[":2:", "expected i64"]),
        ("[render]\nlevel = 0".into(), &[":2:", "level is 0", "1 to 64"]),
        ("[render]\nlevel = 65".into(), &[":2:", "level is 65"]),
        ("[render]\nlevel = -1".into(), &[":2:", "level is -1"]),
        ("[render]\nlevel = nan".into(), &[":2:", "expected i64"]),
        ("[render]\nlevle = 3".into(), &[":2:", "unknown field `levle`", "level"]),
        ("[render]\nbackground = [0, 0, 2, 1]".into(), &[":2:", "background", "0 to 1"]),
        ("[render]\nnewton = { iterations = 0 }".into(), &[":2:", "iterations is 0", "1 to 1000"]),
        ("[render]\nmethod = \"magic\"".into(), &[":2:", "magic", "thesis"]),
        ("[render]\nsamples = 3".into(), &[":2:", "samples is 3", "1, 2, 4"]),
        ("[render\n".into(), &[":1:"]),
        (
            surface("control_points = \"default\"\nkeep = \"inside\""),
            &[":1:", "keep is \"inside\" without a loop"],
        ),
        (surface("control_points = \"default\"\nkeep = \"both\""), &[":3:", "both", "inside"]),
        (
            surface("control_points = \"default\"\n[[surface.trim]]\npath = \"M0 0 Z\""),
            &[":3:", "path is empty", "subpath with a segment"],
        ),
        (
            surface(
                "control_points = \"default\"\n[[surface.trim]]\npath = \"M0 0 L1 1 0 1Z\"\n[[surface.trim]]\npath = \"M0 0 L1 1 0 1Z M0 0 L1e16 0Z\"",
            ),
            &[":5:", "loop 2", "finite"],
        ),
        (trim("path = \"M0 0 L1 1 0 1Z\"\nfill_rule = \"odd\""), &[":5:", "`odd`", "nonzero"]),
        (trim("fill_rule = \"nonzero\"\nloop = []"), &[":3:", "fill_rule", "a path"]),
        (trim("path = \"M0 0 L1 1 0 1Z\"\nloop = []"), &[":3:", "one of circle", "svg"]),
        (trim(""), &[":3:", "one of circle"]),
        (trim("svg = \"none.svg\""), &[":3:", "none.svg", "No such file"]),
        (trim("svg = \"words.svg\""), &[":3:", "words.svg", "valid SVG"]),
        (trim("svg = \"lines.svg\""), &[":3:", "lines.svg", "without a filled shape"]),
        (
            trim(
                "path = \"M0 0 L1 1 0 1Z\"\nfill_rule = \"evenodd\"\n[render]\nmethod = \"thesis\"",
            ),
            &[":3:", "a path", "rule of its own"],
        ),
        ("[camera]\neye = [0, 0, 0]\ntarget = [0, 0, 0]".into(), &[":1:", "camera eye"]),
        (surface("control_points = \"defualt\""), &[":2:", "default"]),
        (surface(&format!("control_points = [{}]", points(15))), &[":2:", "is 15", "16 (4×4)"]),
        (surface(&format!("control_points = [{}]", points(26))), &[":2:", "is 26", "25 (5×5)"]),
        (
            surface(&format!("control_points = [{}, [0, nan, 0]]", points(15))),
            &[":2:", "control point 15", "NaN"],
        ),
        (
            surface(&format!("control_points = [{}, [0, 0, 0, 0]]", points(15))),
            &[":2:", "weight of control point 15", "above 0"],
        ),
        (surface("control_points = [[1, 2]]"), &[":2:", "[x, y, z]"]),
        (surface("color = [1, 1, 1]"), &[":1:", "either control_points or file"]),
        (surface("file = \"none.bpt\""), &[":2:", "none.bpt", "No such file"]),
        (surface("control_points = \"default\"\nscale = 0"), &[":1:", "scale is 0"]),
        (surface("control_points = \"default\"\ntexture = \"none.png\""), &[":3:", "none.png"]),
        (
            surface("control_points = \"default\"\ntexture = \"words.png\""),
            &[":3:", "words.png", "no PNG, JPEG or BMP"],
        ),
        (
            surface("control_points = \"default\"\ntexture = \"wide.png\""),
            &[":3:", "wide.png", "40000 × 1", "16384"],
        ),
        (
            surface(
                "control_points = \"default\"\n[[surface.trim]]\ncircle = { center = [0, 0], radius = -1 }",
            ),
            &[":3:", "circle radius is -1"],
        ),
        (
            surface("control_points = \"default\"\n[[surface.trim]]\nsquare = { size = 1 }"),
            &["square", "circle"],
        ),
        (
            surface(
                "control_points = \"default\"\n[[surface.trim]]\nloop = [[[0, 0], [1, 1]], [[1, 1], [0, 0.5]]]",
            ),
            &["gap", "segment 1", "closed"],
        ),
        (
            surface(
                "control_points = \"default\"\n[[surface.trim]]\nloop = [[[0, 0], [1, 1]], [[1, 1], [0, 0]]]\n[render]\nmethod = \"thesis\"",
            ),
            &[":3:", "line, line", "two quadratics or two cubics"],
        ),
        (
            surface("control_points = \"default\"\n\n[[surface]]\ncontrol_points = \"no\""),
            &[":5:", "default"],
        ),
        (
            surface(
                "control_points = \"default\"\n[[surface]]\ncontrol_points = \"default\"\nscale = inf",
            ),
            &[":3:", "scale is inf"],
        ),
        (
            {
                let lens = |w: f64| {
                    let (left, right) = (0.5 - w, 0.5 + w);
                    format!(
                        "[[surface.trim]]\nloop = [[[{left}, 0.5], [0.5, {right}], [{right}, 0.5]], [[{right}, 0.5], [0.5, {left}], [{left}, 0.5]]]\n"
                    )
                };
                surface(&format!(
                    "control_points = \"default\"\n{}{}{}\n[render]\nmethod = \"thesis\"",
                    lens(0.4),
                    lens(0.2),
                    lens(0.1)
                ))
            },
            &[":7:", "one island at most"],
        ),
        ("surface = []".into(), &[":1:", "at least one [[surface]]"]),
    ] {
        // A scene needs a surface. It is added last, so that lines count from the fault.
        let toml: String = toml;
        let whole = if toml.contains("surface") {
            toml
        } else {
            format!("{toml}\n{}", surface("control_points = \"default\""))
        };
        folder.write("scene.toml", whole);
        let words: Vec<&str> = [&["scene.toml"], words].concat();
        refused(&folder, &["scene.toml"], 1, &words);
    }
}

#[test]
fn wrong_usage_is_status_2_and_says_what_was_expected() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    for level in ["0", "-1", "NaN", "65", "1e9", "", "4.5"] {
        refused(&folder, &["a.toml", "--level", level], 2, &["--level", "1 to 64"]);
    }
    for resolution in ["0", "0x5", "5x0", "-5x5", "5", "axb", "5x5x5", "99999999999x2"] {
        let flag = format!("--resolution={resolution}");
        refused(&folder, &["a.toml", &flag], 2, &["--resolution", "WIDTHxHEIGHT"]);
    }
    for samples in ["0", "3", "512", "-4", "four"] {
        refused(&folder, &["a.toml", "--samples", samples], 2, &["--samples", "1, 2, 4"]);
    }
    refused(&folder, &["a.toml", "--method", "magic"], 2, &["--method", "exact or thesis"]);
    refused(&folder, &["a.toml", "--backend", "vulkan"], 2, &["auto, egl or osmesa"]);
    refused(&folder, &[], 2, &["SCENE"]);
    refused(&folder, &["a.toml", "--colour"], 2, &["--colour"]);
}

#[test]
fn what_the_driver_or_the_disk_refuses_is_one_line() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    folder.write("file", "no folder");
    refused(&folder, &["a.toml", "--resolution", "100000x10"], 1, &["100000x10", "this driver"]);
    for (output, words) in [
        ("file/x.png", &["file/x.png"][..]),
        ("none/x.png", &["none/x.png", "No such file"]),
        ("x.jpg", &["x.jpg", ".png"]),
        ("file/", &["file/"]),
    ] {
        let run = folder.run(&["render", "a.toml", "-o", output]);
        let said = text(&run.stderr);
        assert_eq!(run.status.code(), Some(1), "{said}");
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
        assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    }
}

#[test]
fn a_picture_never_replaces_what_the_scene_was_read_from() {
    let folder = Folder::new();
    let brick = std::fs::read(resource("textures/brick.png")).unwrap();
    folder.write("wall.png", &brick);
    folder.write(
        "wall.toml",
        format!("{}\n", SCENE.replace("\"default\"", "\"default\", texture = \"wall.png\"")),
    );
    let output = folder.run(&["render", "wall.toml"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("wall.png, which the scene was read from"));
    assert_eq!(std::fs::read(folder.path("wall.png")).unwrap(), brick);

    // Nor does the picture of one scene replace a file that another scene of the same call needs.
    let user = std::fs::read(folder.path("wall.toml")).unwrap();
    folder.write("user.toml", user);
    folder.write("wall.toml", SCENE);
    let output = folder.run(&["render", "wall.toml", "user.toml", "--resolution", "8x8"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(std::fs::read(folder.path("wall.png")).unwrap(), brick);
    assert!(folder.path("user.png").exists());
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_no_scenes() {
    let folder = Folder::new();
    std::os::unix::fs::symlink("/dev/zero", folder.path("zero.toml")).unwrap();
    refused(&folder, &["zero.toml"], 1, &["zero.toml", "device"]);
    let scene = SCENE.replace("\"default\"", "\"default\", texture = \"zero.png\"");
    std::os::unix::fs::symlink("/dev/zero", folder.path("zero.png")).unwrap();
    folder.write("scene.toml", scene);
    refused(&folder, &["scene.toml"], 1, &["zero.png", "device"]);
}

#[test]
fn without_a_driver_one_line_names_the_packages() {
    let folder = Folder::new();
    // If no vendor's library is configured, EGL finds no device.
    let output = Command::new(env!("CARGO_BIN_EXE_freeform"))
        .args(["info", "--backend", "egl"])
        .env("__EGL_VENDOR_LIBRARY_DIRS", folder.root())
        .env_remove("__EGL_VENDOR_LIBRARY_FILENAMES")
        .output()
        .unwrap();
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert_eq!(said.trim_end().lines().count(), 1, "{said}");
    assert!(said.contains("libegl1") && said.contains("libosmesa6"), "{said}");
}

#[test]
fn one_bad_scene_does_not_stop_the_others() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    folder.write("bad.toml", "surface = []");
    folder.write("c.toml", SCENE);
    let output =
        folder.run(&["render", "a.toml", "bad.toml", "c.toml", "-o", "out", "--resolution", "8x8"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("bad.toml:1:"));
    assert!(folder.path("out/a.png").exists() && folder.path("out/c.png").exists());
    assert!(!folder.path("out/bad.png").exists());
}

#[test]
fn meshes_are_smoothed_as_asked() {
    let folder = Folder::new();
    let mesh = resource("meshes/icosahedron.obj");
    folder.write("a.toml", format!("[[mesh]]\nfile = {mesh:?}\nsmoothing = \"pn\"\n"));
    let picture = |arguments: &[&str]| {
        let all = [&["render", "-o", "a.png", "--resolution", "60x40"], arguments].concat();
        let output = folder.run(&all);
        assert!(output.status.success(), "{output:?}");
        image::open(folder.path("a.png")).unwrap().into_rgba8()
    };
    let flat = picture(&[&mesh]);
    let [pn, phong] = ["pn", "phong"].map(|method| picture(&[&mesh, "--smoothing", method]));
    assert!(flat != pn && pn != phong && flat != phong);
    assert_eq!(picture(&["a.toml"]), pn);
    assert_eq!(picture(&["a.toml", "--smoothing", "none"]), flat);
    let output = folder.run(&["render", &mesh, "--smoothing", "loop"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("expected none, pn or phong"), "{output:?}");
    let output = folder.run(&["render", "a.toml", "--verbose", "--level", "3", "-o", "a.png"]);
    let said = text(&output.stdout) + &text(&output.stderr);
    assert!(said.contains("patches 20 drawn, 0 culled"), "{said}");
    assert!(said.contains("triangles 260, draws 1"), "{said}");
}

#[test]
fn keys_are_listed_without_a_window() {
    let output = Folder::new().run(&["view", "--list-bindings"]);
    assert!(output.status.success());
    let list = text(&output.stdout);
    let is_named = |line: &str| line.starts_with("W  ") && line.contains("wireframe");
    assert!(list.lines().any(is_named), "{list}");
}

#[cfg(not(feature = "viewer"))]
#[test]
fn a_program_without_its_window_says_how_to_get_it() {
    let output = Folder::new().run(&["view"]);
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert_eq!(error.lines().count(), 1, "{error}");
    assert!(error.contains("--features viewer"), "{error}");
}
