//! `freeform measure`, the AOVs that `--aov` writes, and the values that `--tolerance` accepts.

use crate::harness::program::{Folder, SCENE, resource, text};

/// A flat unit square seen straight from above, with u to the right and v up, at 100 pixels per unit. It covers
/// pixels 5 … 105.
fn square() -> String {
    let points: Vec<String> = (0..16)
        .map(|i| format!("[{}, 0, -{}]", f64::from(i % 4) / 3.0, f64::from(i / 4) / 3.0))
        .collect();
    format!(
        "camera = {{ eye = [0.5, 2, -0.5], target = [0.5, 0, -0.5], up = [0, 0, -1], orthographic_height = 1.1 }}
         surface = [{{ control_points = [{}] }}]",
        points.join(", ")
    )
}

/// The number that follows some words.
fn number_after(said: &str, words: &str) -> f64 {
    let (_, rest) = said.split_once(words).unwrap_or_else(|| panic!("no {words:?} in {said}"));
    let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
    rest[..end].parse().unwrap_or_else(|error| panic!("{error} after {words:?} in {said}"))
}

/// The standard output of `measure`.
fn measured(folder: &Folder, arguments: &[&str]) -> String {
    let arguments = [&["measure", "--resolution", "96x64"], arguments].concat();
    let output = folder.run(&arguments);
    let said = text(&output.stdout);
    assert!(output.status.success() && output.stderr.is_empty(), "{output:?}");
    said
}

/// The output as JSON objects, one per line.
fn objects(folder: &Folder, arguments: &[&str]) -> Vec<serde_json::Value> {
    let said = measured(folder, &[arguments, &["--format", "json"]].concat());
    said.lines().map(|line| serde_json::from_str(line).expect("one object a line")).collect()
}

#[test]
fn measure_says_a_line_for_each_scene() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let teapot = resource("surfaces/teapot.bpt");
    let said = measured(&folder, &["a.toml", &teapot]);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines.len(), 2, "{said}");
    for (line, name) in lines.into_iter().zip(["a.toml", &teapot]) {
        let start = format!("{name} (exact, tolerance 0.5 px): at most ");
        assert!(line.starts_with(&start), "{line}");
        let off = number_after(line, "at most ");
        assert!(off > 0.0 && off <= 0.5, "{line}");
        assert!(number_after(line, "off, ") <= off, "{line}");
        assert!(line.contains(" 0 crack pixels, "), "{line}");
        assert!(!line.contains("limit") && !line.contains("NaN"), "{line}");
    }
}

#[test]
fn measure_gives_objects_to_programs() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let teapot = resource("surfaces/teapot.bpt");
    let all = objects(&folder, &["a.toml", &teapot]);
    assert_eq!(all.len(), 2);
    for (object, name) in all.iter().zip(["a.toml", &teapot]) {
        assert_eq!((&object["scene"], &object["method"]), (&name.into(), &"exact".into()));
        assert_eq!((&object["tolerance"], &object["level"]), (&0.5.into(), &().into()));
        let number = |key: &str| object[key].as_f64().unwrap_or_else(|| panic!("{key}: {object}"));
        assert!(number("max_error_px") > 0.0 && number("max_error_px") <= 0.5, "{object}");
        assert!(number("mean_error_px") < number("max_error_px"), "{object}");
        assert!(number("triangles") > 1.0 && number("ms") > 0.0, "{object}");
        assert_eq!((number("crack_pixels"), number("unmet_views")), (0.0, 0.0), "{object}");
        assert!(number("silhouette_pixels") >= 0.0 && number("normal_error_deg") > 0.0, "{object}");
    }
}

#[test]
fn measure_takes_method_level_tolerance_and_normals() {
    let folder = Folder::new();
    let teapot = resource("surfaces/teapot.bpt");
    let one = |flags: &[&str]| objects(&folder, &[&[teapot.as_str()], flags].concat()).remove(0);
    let thesis = one(&["--method", "thesis"]);
    assert_eq!((&thesis["method"], &thesis["level"]), (&"thesis".into(), &32.into()));
    assert!(thesis["tolerance"].is_null());
    assert_eq!(thesis["triangles"], 32 * 32 * 32 * 2);
    let coarse = one(&["--level", "2"]);
    assert_eq!((&coarse["method"], &coarse["level"]), (&"exact".into(), &2.into()));
    assert_eq!(coarse["triangles"], 32 * 2 * 2 * 2);
    let fine = one(&["--tolerance", "0.05", "--normals", "pixel"]);
    assert_eq!(fine["tolerance"], 0.05);
    let of = |object: &serde_json::Value, key: &str| object[key].as_f64().unwrap();
    assert!(of(&coarse, "max_error_px") > 0.5 && of(&fine, "max_error_px") <= 0.05);
    // Normals per pixel do not depend on the triangles, but interpolated normals do.
    assert!(of(&coarse, "normal_error_deg") > 5.0 && of(&fine, "normal_error_deg") < 0.1);
    assert!(of(&one(&["--level", "2", "--normals", "pixel"]), "normal_error_deg") < 0.1);
}

#[test]
fn measure_looks_from_random_views() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let one = |flags: &[&str]| {
        let mut object = objects(&folder, &[&["a.toml"], flags].concat()).remove(0);
        object.as_object_mut().unwrap().remove("ms");
        object
    };
    let framed = one(&[]);
    let three = one(&["--views", "3"]);
    assert_ne!(three, framed);
    assert_eq!(three, one(&["--views", "3", "--seed", "1"]), "the same views");
    assert_ne!(three, one(&["--views", "3", "--seed", "2"]), "other views");
    assert_ne!(three, one(&["--views", "4"]));
    assert!(three["max_error_px"].as_f64().unwrap() <= 0.5, "{three}");
}

#[test]
fn measure_counts_leaks_of_models_in_close_ups() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let model = resource("models/bracket.ffm");
    let of = |flags: &[&str]| objects(&folder, &[&[model.as_str()], flags].concat()).remove(0);
    let framed = of(&[]);
    assert!(framed["leaks"].is_u64() && framed["open_edges"] == 0, "{framed}");
    let close = of(&["--views", "3", "--zoom", "1000"]);
    assert!(close["leaks"].is_u64() && close["gap_px"] != framed["gap_px"], "{close}");
    assert_ne!(close["gap_px"], of(&["--views", "3", "--zoom", "1000", "--seed", "2"])["gap_px"]);
    let said = measured(&folder, &[&model, "--zoom", "10"]);
    assert!(said.contains(" leaks") && said.contains("gaps of the data up to "), "{said}");
    assert!(objects(&folder, &["a.toml"])[0].get("leaks").is_none());
    refused(&folder, &["measure", "a.toml", "--zoom", "10"], 1, &["no edge that faces share"]);
    refused(&folder, &["measure", "a.toml", "--zoom", "0.5"], 2, &["--zoom", "from 1"]);
}

#[test]
fn measure_goes_on_after_a_bad_scene() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let output = folder.run(&["measure", "none.toml", "a.toml", "--resolution", "8x8"]);
    let (said, complained) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(1));
    assert!(said.starts_with("a.toml (") && said.lines().count() == 1, "{said}");
    assert!(complained.starts_with("freeform: cannot read none.toml"), "{complained}");
    assert_eq!(complained.lines().count(), 1, "{complained}");
}

/// An AOV's file: width, height, and for each pixel R, G, B and A, or Z alone for depth.
fn exr(folder: &Folder, name: &str) -> (u32, u32, Vec<[f32; 4]>) {
    let read = exr::prelude::read_first_flat_layer_from_file(folder.path(name)).unwrap();
    let layer = read.layer_data;
    let mut pixels = vec![[f32::NAN; 4]; layer.size.area()];
    for channel in &layer.channel_data.list {
        let name = channel.name.to_string();
        let component = ["R", "G", "B", "A", "Z"].iter().position(|other| *other == name).unwrap();
        for (pixel, value) in pixels.iter_mut().zip(channel.sample_data.values_as_f32()) {
            pixel[component % 4] = value;
        }
    }
    (layer.size.x() as u32, layer.size.y() as u32, pixels)
}

#[test]
fn aovs_are_what_pixels_show() {
    let folder = Folder::new();
    folder.write("a.toml", square());
    let kinds = ["uv", "position", "normal", "depth"];
    let flags: Vec<String> =
        kinds.iter().flat_map(|kind| ["--aov".into(), format!("{kind}={kind}.exr")]).collect();
    let flags: Vec<&str> = flags.iter().map(String::as_str).collect();
    let output =
        folder.run(&[&["render", "a.toml", "--resolution", "120x110"], &flags[..]].concat());
    assert!(output.status.success(), "{output:?}");
    assert!(folder.path("a.png").exists());
    for (kind, name) in kinds.into_iter().zip(["uv.exr", "position.exr", "normal.exr", "depth.exr"])
    {
        let (width, height, pixels) = exr(&folder, name);
        assert_eq!((width, height), (120, 110));
        for (i, pixel) in pixels.iter().enumerate() {
            let (x, y) = ((i % 120) as f32 + 0.5, (i / 120) as f32 + 0.5);
            let (u, v) = ((x - 10.0) / 100.0, (105.0 - y) / 100.0);
            let inside = (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v);
            let expected = match kind {
                "depth" if !inside => [f32::INFINITY; 4],
                _ if !inside => [0.0; 4],
                "uv" => [u, v, 0.0, 1.0],
                "position" => [u, 0.0, -v, 1.0],
                "normal" => [0.0, 1.0, 0.0, 1.0],
                _ => [2.0, 2.0, 2.0, 1.0],
            };
            let channels = if kind == "depth" { 1 } else { 4 };
            assert_eq!(pixel.iter().filter(|value| !value.is_nan()).count(), channels);
            let off = |c: usize| {
                if pixel[c] == expected[c] { 0.0 } else { (pixel[c] - expected[c]).abs() }
            };
            let off = (0..channels).map(off).fold(0.0, f32::max);
            assert!(off <= 1e-5, "{kind} at ({x}, {y}): {pixel:?}, not {expected:?}");
        }
    }
}

#[test]
fn aovs_count_patches_through_all_surfaces() {
    let folder = Folder::new();
    let teapot = resource("surfaces/teapot.bpt");
    folder.write(
        "a.toml",
        format!(
            "surface = [{{ file = {teapot:?} }}, {{ control_points = \"default\", scale = 9, translate = [0, 0, 9] }}]"
        ),
    );
    let output = folder.run(&["render", "a.toml", "--resolution", "96x96", "--aov", "uv=n.exr"]);
    assert!(output.status.success(), "{output:?}");
    let (_, _, pixels) = exr(&folder, "n.exr");
    let drawn = || pixels.iter().filter(|pixel| pixel[3] == 1.0);
    assert!(drawn().all(|[u, v, ..]| (0.0..=1.0).contains(u) && (0.0..=1.0).contains(v)));
    let mut patches: Vec<f32> = drawn().map(|pixel| pixel[2]).collect();
    patches.sort_by(f32::total_cmp);
    patches.dedup();
    // The square is the last patch; some patches of the teapot are hidden.
    assert!(patches.iter().all(|patch| patch.fract() == 0.0), "{patches:?}");
    assert!(patches.len() > 10 && patches.last() == Some(&32.0), "{patches:?}");
}

/// Runs the program, which must fail with one line.
fn refused(folder: &Folder, arguments: &[&str], status: i32, words: &[&str]) {
    let output = folder.run(arguments);
    let said = text(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
    assert!(words.iter().all(|word| said.contains(word)), "{arguments:?}: {said}");
    assert_eq!(said.trim_end().lines().count(), 1, "{arguments:?}: {said}");
    assert!(said.starts_with("freeform: ") && output.stdout.is_empty(), "{said}");
}

#[test]
fn wrong_tolerances_and_aovs_are_status_2() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    for command in ["render", "measure"] {
        for tolerance in ["0", "-1", "nan", "1000", "inf", "-0.5", "", "half", "0.009", "100.1"] {
            let words = ["--tolerance", "from 0.01 to 100"];
            refused(&folder, &[command, "a.toml", "--tolerance", tolerance], 2, &words);
        }
        let both = [command, "a.toml", "--tolerance", "0.5", "--level", "8"];
        refused(&folder, &both, 2, &["--tolerance", "cannot be used with", "--level"]);
        let normals = [command, "a.toml", "--normals", "face"];
        refused(&folder, &normals, 2, &["--normals", "vertex or pixel"]);
    }
    for (aov, words) in [
        ("uv", ["--aov", "KIND=FILE.exr"]),
        ("colour=x.exr", ["--aov", "uv, position, normal, depth, face or curvature"]),
        ("depth=x.png", ["--aov", ".exr"]),
    ] {
        refused(&folder, &["render", "a.toml", "--aov", aov], 2, &words);
    }
    refused(&folder, &["measure", "a.toml", "--views=-1"], 2, &["--views"]);
    refused(&folder, &["measure", "a.toml", "--format", "xml"], 2, &["--format", "line, json"]);
    refused(&folder, &["measure"], 2, &["SCENE"]);
    assert_eq!(std::fs::read_dir(folder.root()).unwrap().count(), 1, "something was written");
}

#[test]
fn aovs_of_several_scenes_are_refused() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    folder.write("b.toml", SCENE);
    let arguments = ["render", "a.toml", "b.toml", "--resolution", "8x8", "--aov", "uv=x.exr"];
    let output = folder.run(&arguments);
    let said = text(&output.stderr);
    assert!(!output.status.success() && said.contains("--aov"), "{said}");
    assert!(!folder.path("x.exr").exists());
}

#[test]
fn two_aovs_in_one_file_are_refused() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let one = ["render", "a.toml", "--resolution", "8x8", "--aov", "uv=x.exr"];
    let output =
        folder.run(&[&one[..], &["--aov", "depth=y.exr", "--aov", "normal=x.exr"]].concat());
    let said = text(&output.stderr);
    let words = ["--aov", "x.exr for two AOVs", "a file for each"];
    assert!(!output.status.success() && words.iter().all(|word| said.contains(word)), "{said}");
    assert_eq!(std::fs::read_dir(folder.root()).unwrap().count(), 1, "something was written");
    assert!(folder.run(&one).status.success());
}

#[test]
fn scenes_of_level_and_tolerance_are_refused_with_their_line() {
    let folder = Folder::new();
    let surface = "[[surface]]\ncontrol_points = \"default\"\n";
    for (render, line, words) in [
        ("level = 4\ntolerance = 0.5", ":3:", ["level and tolerance", "one of them"]),
        ("\ntolerance = 0.5\nlevel = 4", ":3:", ["level and tolerance", "one of them"]),
        ("tolerance = 0", ":2:", ["tolerance is 0", "0.01 to 100"]),
        ("tolerance = -1.0", ":2:", ["tolerance is -1", "0.01 to 100"]),
        ("tolerance = nan", ":2:", ["tolerance is NaN", "0.01 to 100"]),
        ("tolerance = 1e3", ":2:", ["tolerance is 1000", "0.01 to 100"]),
        ("normals = \"face\"", ":2:", ["normals is \"face\"", "\"vertex\" or \"pixel\""]),
    ] {
        folder.write("a.toml", format!("[render]\n{render}\n{surface}"));
        let place = format!("a.toml{line}");
        for command in ["render", "measure"] {
            refused(&folder, &[command, "a.toml"], 1, &[&place, words[0], words[1]]);
        }
    }
}

#[test]
fn verbose_says_what_was_drawn() {
    let folder = Folder::new();
    // The second surface is behind the camera.
    let points = "control_points = \"default\"";
    folder.write(
        "a.toml",
        format!(
            "camera = {{ eye = [0.9, 1.0, 1.5], target = [0, 0, 0] }}
             surface = [{{ {points} }}, {{ {points}, translate = [5, 6, 9] }}]"
        ),
    );
    let run = |flags: &[&str]| {
        let arguments =
            [&["render", "a.toml", "--verbose", "--resolution", "64x48"], flags].concat();
        let output = folder.run(&arguments);
        assert!(output.status.success(), "{output:?}");
        text(&output.stderr)
    };
    let said = run(&[]);
    assert!(said.contains("patches 1 drawn, 1 culled\n"), "{said}");
    assert_eq!(number_after(&said, ", draws "), 1.0, "{said}");
    let (triangles, bound) = (number_after(&said, "triangles "), number_after(&said, "at most "));
    assert!(triangles >= 2.0 && bound > 0.0 && bound <= 0.5, "{said}");
    assert!(said.contains(" px from the surface\n"), "{said}");
    let finer = run(&["--tolerance", "0.05"]);
    assert!(number_after(&finer, "triangles ") > triangles, "{finer}");
    assert!(number_after(&finer, "at most ") <= 0.05, "{finer}");
    // The thesis' method culls nothing and does not compute a bound.
    let thesis = run(&["--method", "thesis"]);
    assert!(thesis.contains("patches 2 drawn, 0 culled\ntriangles 4096, draws "), "{thesis}");
    assert!(!thesis.contains("px from the surface"), "{thesis}");
}

#[test]
fn measure_leaves_meshes_out() {
    let folder = Folder::new();
    folder.write("a.toml", SCENE);
    let mesh = format!("[[mesh]]\nfile = {:?}\n", resource("meshes/torus.obj"));
    folder.write("b.toml", format!("{SCENE}\n{mesh}"));
    let one = |name: &str| {
        let mut object = objects(&folder, &[name]).remove(0);
        for key in ["ms", "scene"] {
            object.as_object_mut().unwrap().remove(key);
        }
        object
    };
    assert_eq!(one("a.toml"), one("b.toml"));
    folder.write("c.toml", mesh);
    let output = folder.run(&["measure", "c.toml"]);
    let said = text(&output.stderr);
    assert_eq!((output.status.code(), said.lines().count()), (Some(1), 1), "{said}");
    assert!(said.contains("c.toml") && said.contains("no Bézier surface"), "{said}");
}
