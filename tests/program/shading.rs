//! What is shown in place of light and colour, from the command line.

use exr::prelude::read_first_rgba_layer_from_file;

use crate::harness::program::{Folder, resource, text};

const SIZE: [&str; 2] = ["--resolution", "300x200"];

/// The picture of a model with some options.
fn picture(folder: &Folder, options: &[&str]) -> image::RgbaImage {
    let model = resource("models/flange.ffm");
    let path = folder.path("out.png");
    let fixed = ["render", &model, "-o", path.to_str().unwrap()];
    let output = folder.run(&[&fixed, &SIZE[..], options].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    image::open(&path).unwrap().to_rgba8()
}

#[test]
fn options_change_the_picture_and_the_scale_can_be_left_out() {
    let folder = Folder::new();
    let pictures: Vec<_> = [
        &[][..],
        &["--shading", "zebra"],
        &["--shading", "zebra", "--stripes", "7"],
        &["--shading", "zebra", "--direction", "-1,0,0"],
        &["--shading", "isophotes"],
        &["--shading", "curvature", "--curvature", "mean"],
        &["--shading", "curvature", "--curvature", "mean", "--limit", "0.5"],
        &["--shading", "curvature", "--curvature", "largest", "--limit", "0.5"],
        &["--shading", "draft", "--direction", "1,0,0"],
        &["--shading", "draft", "--direction", "1,0,0", "--limit-degrees", "80"],
        &["--shading", "draft", "--direction", "1,0,0", "--limit-degrees", "80", "--no-scale"],
    ]
    .iter()
    .map(|options| picture(&folder, options))
    .collect();
    for (i, one) in pictures.iter().enumerate() {
        assert!(pictures[..i].iter().all(|other| one != other), "{i}");
    }
    // Without the scale, the lower left corner is empty.
    let [with, without] = [9, 10].map(|i| pictures[i].get_pixel(20, 185).0);
    assert_eq!(without, pictures[0].get_pixel(20, 185).0);
    assert_ne!(with, without);
    assert!(picture(&folder, &["--shading", "none"]) == pictures[0]);
}

#[test]
fn what_does_not_fit_is_refused_in_one_line() {
    let folder = Folder::new();
    let model = resource("surfaces/teapot.bpt");
    for (options, status, words) in [
        (&["--shading", "stripes"][..], 2, "expected zebra, isophotes, curvature, draft or none"),
        (&["--stripes", "5"], 2, "--shading"),
        (&["--shading", "zebra", "--stripes", "0"], 2, "from 1 to 1000"),
        (&["--shading", "zebra", "--direction", "0,0,0"], 2, "not all 0"),
        (&["--shading", "draft", "--direction", "1,2"], 2, "X,Y,Z"),
        (&["--shading", "curvature", "--curvature", "max"], 2, "gaussian, mean or largest"),
        (&["--shading", "draft", "--limit-degrees", "91"], 2, "to 90"),
        (&["--shading", "zebra", "--limit", "1"], 1, "given with zebra"),
        (&["--shading", "none", "--stripes", "5"], 1, "a kind that has them"),
        (&["--shading", "zebra", "--method", "thesis"], 1, "--method exact"),
    ] {
        let output = folder.run(&[&["render", &model, "-o", "out.png"], options].concat());
        let told = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{options:?}: {told}");
        assert!(told.contains(words) && told.trim().lines().count() == 1, "{options:?}: {told}");
        assert!(!folder.path("out.png").exists());
    }
}

/// A cylinder of radius 2 from its own text: the principal curvatures are 1/2 and 0.
#[test]
fn curvature_is_written_as_numbers() {
    let folder = Folder::new();
    let scene = folder.write(
        "cylinder.toml",
        "[[surface]]\ndegree = [2, 1]\nknots = [[0, 0, 0, 1, 1, 1], [0, 0, 1, 1]]\n\
         control_points = [[2, 0, 0, 1], [2, 2, 0, 0.7071067811865476], [0, 2, 0, 1],\n\
         [2, 0, 3, 1], [2, 2, 3, 0.7071067811865476], [0, 2, 3, 1]]\n",
    );
    let path = folder.path("c.exr");
    let aov = format!("curvature={}", path.display());
    let fixed = ["render", scene.to_str().unwrap(), "-o", "c.png", "--aov", &aov];
    let output = folder.run(&[&fixed, &SIZE[..]].concat());
    assert!(output.status.success(), "{}", text(&output.stderr));
    let pixels = read_first_rgba_layer_from_file(
        &path,
        |_, _| Vec::<[f32; 4]>::new(),
        |pixels, _, (r, g, b, a): (f32, f32, f32, f32)| pixels.push([r, g, b, a]),
    );
    let pixels = pixels.unwrap().layer_data.channel_data.pixels;
    let drawn: Vec<_> = pixels.iter().filter(|pixel| pixel[3] == 1.0).collect();
    assert!(drawn.len() > 5_000 && drawn.len() < pixels.len(), "{}", drawn.len());
    for [gaussian, mean, largest, _] in drawn {
        // Su × Sv points outwards, away from which it bends.
        assert!(gaussian.abs() < 1e-5, "{gaussian}");
        assert!((mean + 0.25).abs() < 1e-5 && (largest + 0.5).abs() < 1e-5, "{mean} {largest}");
    }
    assert!(pixels.iter().all(|pixel| pixel[3] == 1.0 || *pixel == [0.0; 4]));
}

#[test]
fn wrong_pixels_of_a_shading_are_counted() {
    let folder = Folder::new();
    let scene = resource("surfaces/teapot.bpt");
    let fixed = ["measure", &scene, "--format", "json", "--resolution", "500x300"];
    for kind in ["zebra", "isophotes", "draft"] {
        let output = folder.run(&[&fixed[..], &["--shading", kind]].concat());
        let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let [all, wrong] =
            ["shading_pixels", "wrong_shading_pixels"].map(|key| object[key].as_u64().unwrap());
        assert!(all > 50_000 && 1000 * wrong <= all, "{kind}: {wrong} of {all}");
    }
    let output = folder.run(&fixed);
    assert!(!text(&output.stdout).contains("shading"), "{}", text(&output.stdout));
    // What a scene draws besides does not count.
    let model = resource("models/flange.ffm");
    let text_of = |settings: &str| format!("[render]\n{settings}\n[[model]]\nfile = \"{model}\"\n");
    let count = |settings: &str| {
        let scene = folder.write("scene.toml", text_of(settings));
        let scene = scene.to_str().unwrap();
        let fixed = ["measure", scene, "--format", "json", "--resolution", "300x200"];
        let output = folder.run(&[&fixed[..], &["--shading", "zebra"]].concat());
        let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        object["wrong_shading_pixels"].as_u64().unwrap()
    };
    assert_eq!(count("samples = 8\nedges = true\nisolines = 20"), count(""));
    let line = folder.run(&["measure", &scene, "--resolution", "200x100", "--shading", "zebra"]);
    assert!(text(&line.stdout).contains("pixels of the shading wrong"), "{}", text(&line.stdout));
}
