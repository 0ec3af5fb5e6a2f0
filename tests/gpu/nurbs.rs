//! NURBS surfaces: trims, AOVs, neighbours and changes, compared with computations on the surfaces' own knots.

use freeform_surface::inspect::reference::coverage;
use freeform_surface::{
    Degree, Frame, Image, Light, LoadOptions, Method, NurbsSurface, Paint, Rect, RenderSettings,
    Scene, Shading, Surface, Trims,
};
use glam::{DVec2, DVec3, DVec4, UVec2, uvec2};

use super::trim_curves::{EITHER_WAY, check_pixels, cut_by_gpu};
use crate::harness::neighbours::{check_insides, check_neighbours};
use crate::harness::patches::{scene_of, within};
use crate::harness::trim_text::{TrimText, by_definition};
use crate::harness::{Stage, load, root};

/// The scenes that show curved surfaces.
const CURVED: [&str; 6] =
    ["crease", "torn", "periodic-torus", "sphere-and-torus", "knot-lines", "curved-trims"];

fn path(name: &str) -> std::path::PathBuf {
    root().join(format!("resources/scenes/stability/nurbs-{name}.toml"))
}

fn text(name: &str) -> String {
    std::fs::read_to_string(path(name)).unwrap()
}

#[test]
fn hard_surfaces_are_drawn_within_the_tolerance_and_without_cracks() {
    let mut stage = Stage::new(uvec2(480, 300));
    for name in CURVED {
        let scene = load(&path(name));
        let mut prepared = stage.prepared(&scene);
        let frame = Frame::new(stage.projection(&scene), stage.size, within(0.5));
        let found = stage.measured(&scene, &mut prepared, &frame);
        assert_eq!(
            (found.crack_pixels, found.hidden_pixels, found.bad_values),
            (0, 0, 0),
            "{name}"
        );
        assert!(found.max_error_px <= 0.5 && found.normal_error_deg <= 0.1, "{name}: {found:?}");
        assert!(found.covered > 5_000, "{name}: {found:?}");
        assert_eq!(prepared.stats().unmet, None, "{name}");
    }
}

/// A bicubic B-spline surface of `side` × `side` control points as the text of an OBJ file: larger than a stored scene
/// should be.
fn many_points(side: usize) -> String {
    let mut text = String::new();
    for i in 0..side * side {
        let (x, z) = ((i % side) as f64, (i / side) as f64);
        let height = 6.0 * (0.31 * x).sin() * (0.23 * z).cos() + 20.0 * (0.021 * (x + z)).sin();
        text += &format!("v {x} {height:.2} {}\n", 0.0 - z);
    }
    let last = side - 3;
    let indices: String = (1..=side * side).map(|index| format!(" {index}")).collect();
    let inner: String = (0..=last).map(|knot| format!(" {knot}")).collect();
    let knots = format!("0 0 0{inner} {last} {last} {last}");
    text + &format!(
        "cstype bspline\ndeg 3 3\nsurf 0 {last} 0 {last}{indices}\nparm u {knots}\nparm v {knots}\nend\n"
    )
}

#[test]
fn ninety_thousand_control_points_are_drawn_within_the_tolerance() {
    let mut stage = Stage::new(uvec2(480, 300));
    let scene =
        Scene::from_text(&many_points(300), "x.obj".as_ref(), &LoadOptions::default()).unwrap();
    assert_eq!(scene.surfaces[0].control_points().len(), 300 * 300);
    let mut prepared = stage.prepared(&scene);
    let frame = Frame::new(stage.projection(&scene), stage.size, within(0.5));
    let found = stage.measured(&scene, &mut prepared, &frame);
    assert_eq!((found.crack_pixels, found.bad_values), (0, 0), "{found:?}");
    assert!(found.max_error_px <= 0.5 && found.covered > 30_000, "{found:?}");
    assert_eq!(prepared.stats().patches, 297 * 297);
}

#[test]
fn the_patches_of_a_surface_meet_bit_for_bit() {
    let mut stage = Stage::new(uvec2(960, 540));
    for (name, pairs) in [
        // Per column 4 edges and per row 4, less the torn and the outer ones.
        ("crease", 4 * 2 + 3 * 3 + 2 + 3),
        ("torn", 2),
        // Both directions are closed: two edges for each patch.
        ("periodic-torus", 2 * 48),
        ("sphere-and-torus", 4 * 2 + 4 + 2 * 16),
    ] {
        let mut scene = load(&path(name));
        scene.settings = within(0.5);
        let mut prepared = stage.prepared(&scene);
        // From the middle of everything, so that nothing is out of view.
        let camera = scene.framed(stage.aspect());
        scene.camera = Some(camera);
        let drawn = stage.triangles(&mut prepared, &stage.frame(&scene));
        check_insides(name, &drawn);
        let met = check_neighbours(name, &scene, &drawn);
        assert!(met.pairs >= pairs, "{name}: {} of {pairs} pairs of sides", met.pairs);
    }
}

/// Two sheets that share a border curve with inner knots: the second runs the other way, and has weights elsewhere.
fn sheets_side_by_side() -> Scene {
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 3.0, 7.0, 8.0, 8.0, 8.0, 8.0];
    let border: Vec<DVec3> = (0..7)
        .map(|i| {
            let i = f64::from(i);
            DVec3::new(0.0, 0.37 * i, (1.9 * i).sin())
        })
        .collect();
    let along_u = || vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    let reversed: Vec<f64> = knots.iter().rev().map(|knot| 8.0 - knot).collect();
    let sheet = |knots: Vec<f64>, border: Vec<DVec3>, side: f64, weight: f64| {
        let points = border.iter().flat_map(|point| {
            [0.0, 1.0, 2.0].map(|column| {
                let off = DVec3::new(side * column, 0.0, 0.2 * column);
                (*point + off).extend(if column == 1.0 { weight } else { 1.0 })
            })
        });
        let degree = Degree::new(2, 3).unwrap();
        let points = points.collect();
        Surface::from_nurbs(NurbsSurface::new(degree, [along_u(), knots], points).unwrap())
    };
    let back = border.iter().rev().copied().collect();
    scene_of(vec![sheet(knots, border, 1.0, 1.0), sheet(reversed, back, -1.0, 2.5)])
}

#[test]
fn surfaces_with_the_same_border_meet_bit_for_bit() {
    let mut stage = Stage::new(uvec2(960, 540));
    let mut scene = sheets_side_by_side();
    let points: Vec<Vec<[u64; 4]>> = scene
        .surfaces
        .iter()
        .map(|surface| {
            let first = surface.patches().flat_map(|patch| patch.points().iter().step_by(3));
            first.map(|point| point.to_array().map(f64::to_bits)).collect()
        })
        .collect();
    let mut back = points[1].clone();
    back.reverse();
    assert_eq!(points[0], back);
    scene.camera = Some(scene.framed(stage.aspect()));
    let mut prepared = stage.prepared(&scene);
    let drawn = stage.triangles(&mut prepared, &stage.frame(&scene));
    let met = check_neighbours("side by side", &scene, &drawn);
    // 4 edges between the sheets, and 3 within each.
    assert!(met.pairs >= 4 + 2 * 3, "{} pairs", met.pairs);
}

#[test]
fn thirty_pairs_of_degrees_compile_few_programs() {
    let mut stage = Stage::new(uvec2(320, 200));
    let scene = load(&root().join("resources/scenes/stability/tess-many-degrees.toml"));
    let mut prepared = stage.prepared(&scene);
    let frame = stage.frame(&scene);
    let _ = stage.picture(&mut prepared, &frame);
    let count = stage.renderer().program_count();
    // One of them is that of 4×4 points.
    assert!((4..=9).contains(&count), "{count} programs");
}

#[test]
fn trims_over_a_flat_surface_are_right_at_every_pixel() {
    for name in ["flat-trims", "long-thin-domain"] {
        let mut scene = load(&path(name));
        // The text's oracle knows no SVG paths.
        let paths = text(name).matches("\npath = ").count();
        let text = without_paths(&text(name));
        if paths > 0 {
            scene = Scene::from_toml(&text, &path(name)).unwrap();
        }
        let trims = TrimText::new(&text);
        let cut = cut_by_gpu(&scene);
        check_pixels(name, &trims, &cut);
        assert!(cut.iter().filter(|cut| **cut).count() > 300_000, "{name}");
    }
}

/// A scene's text without the trims that are SVG paths.
fn without_paths(text: &str) -> String {
    let parts = text.split("[[surface.trim]]").filter(|part| !part.starts_with("\npath = "));
    parts.collect::<Vec<_>>().join("[[surface.trim]]")
}

#[test]
fn an_arc_over_several_patches_is_round() {
    let cut = cut_by_gpu(&load(&path("flat-trims")));
    let trims = TrimText::new(&without_paths(&text("flat-trims")));
    let [low, high] = trims.domain;
    let side = 2048;
    let mut inside = 0;
    for (i, cut) in cut.iter().enumerate() {
        let share = (DVec2::new((i % side) as f64, (i / side) as f64) + 0.5) / side as f64;
        let place = low + (high - low) * share;
        let off = (place - DVec2::new(3.5, 35.0)) / DVec2::new(0.3, 3.0);
        if off.length() < 1.1 && (off.length() - 1.0).abs() > 1e-6 {
            assert_eq!(*cut, off.length() < 1.0, "{place}");
            inside += usize::from(*cut);
        }
    }
    assert!(inside > 100_000, "{inside}");
}

#[test]
fn trims_over_a_curved_surface_are_right_at_every_pixel() {
    let size = UVec2::splat(2048);
    let mut stage = Stage::new(size);
    for name in ["curved-trims", "knot-lines"] {
        let text = without_paths(&text(name));
        let trims = TrimText::new(&text);
        let mut scene = Scene::from_toml(&text, &path(name)).unwrap();
        // Fine enough that both pictures show the same places, although trims divide patches.
        const FINE_PX: f64 = 0.02;
        let aovs_of = |stage: &mut Stage, scene: &Scene| {
            let mut prepared = stage.prepared(scene);
            let frame = Frame::new(stage.projection(scene), stage.size, within(FINE_PX));
            stage.aovs(&mut prepared, &frame)
        };
        let trimmed = aovs_of(&mut stage, &scene);
        scene.surfaces[0].trims = Trims::default();
        let whole = aovs_of(&mut stage, &scene);
        let surface = &scene.surfaces[0];
        let (mut kept, mut cut_away, mut close) = (0, 0, 0);
        for i in 0..whole.uv.len() {
            let cut = trimmed.uv[i][3] == 0.0;
            let shown = if cut { &whole } else { &trimmed };
            if shown.uv[i][3] == 0.0 {
                continue;
            }
            let [low, high] = surface.patch_domain(shown.uv[i][2] as usize);
            let [u, v] = shown.patch_uv[i].map(f64::from);
            let place = low + (high - low) * DVec2::new(u, v);
            let share = if cut { 1e-3 } else { EITHER_WAY };
            match trims.judge(place, cut, share * (high - low)) {
                Some(true) if cut => cut_away += 1,
                Some(true) => kept += 1,
                Some(false) => panic!("{name}: pixel {i} at {place}, cut: {cut}"),
                None => close += usize::from(!cut),
            }
        }
        assert!(kept > 500_000 && cut_away > 100_000, "{name}: {kept} kept, {cut_away} cut");
        assert!(close < 100, "{name}: {close}");
    }
}

#[test]
fn the_uv_aov_is_in_the_parameters_of_the_surface() {
    let mut stage = Stage::new(uvec2(480, 300));
    for name in CURVED {
        let scene = load(&path(name));
        let mut prepared = stage.prepared(&scene);
        let frame = Frame::new(stage.projection(&scene), stage.size, within(0.1));
        let aovs = stage.aovs(&mut prepared, &frame);
        let patches: Vec<&Surface> = scene
            .surfaces
            .iter()
            .flat_map(|surface| surface.patches().map(move |_| surface))
            .collect();
        let mut seen = 0;
        for (uv, position) in aovs.uv.iter().zip(&aovs.position).filter(|(uv, _)| uv[3] != 0.0) {
            let surface = patches[uv[2] as usize];
            let nurbs = surface.nurbs().unwrap();
            let [low, high] = nurbs.domain();
            // The last parameter belongs to no span of the basis functions.
            let last = low + (high - low) * (1.0 - 1e-9);
            let place = DVec2::new(uv[0].into(), uv[1].into()).clamp(low, last);
            let expected = surface.transform.transform_point3(by_definition(nurbs, place));
            let [x, y, z, _] = position.map(f64::from);
            let off = expected.distance(DVec3::new(x, y, z));
            assert!(off < 2e-3, "{name}: {off} off at {place}");
            seen += 1;
        }
        assert!(seen > 5_000, "{name}: {seen}");
    }
}

#[test]
fn a_moved_control_point_changes_the_surface_as_a_new_one() {
    let mut stage = Stage::new(uvec2(320, 200));
    let mut scene = load(&path("periodic-torus"));
    // A new surface has another centre, and so other last bits of its points. Under the thesis' lamps they change no
    // colour; in the studio, a channel of one pixel by 1.
    scene.settings = RenderSettings { light: Light::Thesis, ..within(0.5) };
    // Only a new surface would be joined where a moved point opens it in part.
    scene.surfaces[0].join = false;
    let mut prepared = stage.prepared(&scene);
    let frame = stage.frame(&scene);
    let before = stage.picture(&mut prepared, &frame);
    for index in [0, 15, 40, 98] {
        let point = scene.surfaces[0].control_points()[index] * DVec4::new(1.1, 1.3, 1.1, 1.0);
        scene.surfaces[0].set_control_point(point, index).unwrap();
        prepared.surfaces_mut()[0].set_control_point(point, index).unwrap();
        let moved = stage.picture(&mut prepared, &frame);
        let mut new = stage.prepared(&scene);
        assert_eq!(moved, stage.picture(&mut new, &frame), "point {index}");
        assert_ne!(moved, before, "point {index}");
    }
}

#[test]
fn a_picture_lies_over_the_domain_and_not_over_each_patch() {
    // One colour for each of 4 × 4 squares of the domain.
    let color = |x: u32, y: u32| image::Rgba([60 * x as u8 + 40, 60 * y as u8 + 40, 128, 255]);
    let picture = Image::from_fn(4, 4, |x, y| color(x, 3 - y));
    let mut scene = Scene::from_toml(&without_trims("flat-trims"), &path("flat-trims")).unwrap();
    scene.surfaces[0].shading = Shading::Unlit;
    scene.surfaces[0].paint = Paint::Texture(std::sync::Arc::new(picture));
    let image = Stage::new(UVec2::splat(256)).render(&scene);
    for (x, y) in (0..4).flat_map(|y| (0..4).map(move |x| (x, y))) {
        // In the middle of a square there is no other colour.
        assert_eq!(*image.get_pixel(64 * x + 32, 255 - (64 * y + 32)), color(x, y), "({x}, {y})");
    }
}

fn without_trims(name: &str) -> String {
    let text = text(name);
    text[..text.find("[[surface.trim]]").unwrap()].to_owned()
}

#[test]
fn wrong_surfaces_are_refused_with_name_value_and_range() {
    let refused = |degree: &str, knots: &str, points: &str, words: &[&str]| {
        let text =
            format!("[[surface]]\ndegree = {degree}\nknots = {knots}\ncontrol_points = {points}\n");
        let error = Scene::from_toml(&text, "x.toml".as_ref()).unwrap_err().to_string();
        assert!(error.starts_with("x.toml:") && error.lines().count() == 1, "{error}");
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let points = "[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]]";
    let good = "[[0, 0, 1, 1], [0, 0, 1, 1]]";
    assert!(
        Scene::from_toml(
            &format!("[[surface]]\ndegree = [1, 1]\nknots = {good}\ncontrol_points = {points}"),
            "x.toml".as_ref()
        )
        .is_ok()
    );
    refused("[0, 1]", good, points, &["degree along u", "is 0", "1 to 15"]);
    refused("[1, 16]", good, points, &["degree along v", "is 16", "1 to 15"]);
    let knots = "[[0, 0, 1, 0.5], [0, 0, 1, 1]]";
    refused("[1, 1]", knots, points, &["knots along u", "knot 3", "0.5", "at least 1"]);
    let knots = "[[0, 0, 1, 1], [0, 0, 1]]";
    refused("[1, 1]", knots, points, &["number of knots along v", "is 3", "at least 4"]);
    let knots = "[[0, 0, 0.5, 1, 1], [0, 0, 1, 1]]";
    refused("[1, 1]", knots, points, &["number of control points", "is 4", "3 along u times 2"]);
    let knots = "[[0, 1, 1, 2], [0, 0, 1, 1]]";
    refused("[1, 1]", knots, points, &["knots along u", "domain from knot 1 to knot 2", "1 to 1"]);
    let knots = "[[-1e308, -1e308, 1e308, 1e308], [0, 0, 1, 1]]";
    refused("[1, 1]", knots, points, &["x.toml:3:", "knots along u", "knot 0", "at most 1e15"]);
    let knots = "[[0, 0, 1, inf], [0, 0, 1, 1]]";
    refused("[1, 1]", knots, points, &["knots along u", "knot 3", "inf", "finite"]);
    let weighted = "[[0, 0, 0], [1, 0, 0, 0.0], [0, 1, 0], [1, 1, 0]]";
    refused("[1, 1]", good, weighted, &["weight of control point 1", "is 0", "above 0"]);
    let error = Scene::from_toml(
        &format!("[[surface]]\nknots = {good}\ncontrol_points = {points}"),
        "x.toml".as_ref(),
    );
    let error = error.unwrap_err().to_string();
    assert!(error.contains("x.toml:2:") && error.contains("knots"), "{error}");
    // 199 × 199 patches of degree 15.
    let knots = (0..230).map(f64::from).collect::<Vec<f64>>();
    let words = ["control points of all patches", "10137856", "1048576"];
    refused("[15, 15]", &format!("[{knots:?}, {knots:?}]"), points, &words);
    let thesis = "[render]\nmethod = \"thesis\"\n".to_owned() + &text("flat-trims");
    let thesis = thesis.replace("[render]\nlevel = 1\n", "").replace("background =", "#");
    let error = Scene::from_toml(&thesis, "x.toml".as_ref()).unwrap_err().to_string();
    assert!(error.starts_with("x.toml:") && error.contains("NURBS"), "{error}");
}

#[test]
fn the_reference_of_coverage_knows_the_trims_of_patches() {
    // One picture, compared with two halves of a surface.
    let mut stage = Stage::new(uvec2(320, 200));
    let knots = || vec![0.0, 0.0, 1.0, 2.0, 2.0];
    let points = (0..9).map(|i| DVec4::new(f64::from(i % 3), f64::from(i / 3), 0.0, 1.0));
    let degree = Degree::new(1, 1).unwrap();
    let nurbs = NurbsSurface::new(degree, [knots(), knots()], points.collect()).unwrap();
    let halves = [[0.0, 1.2], [0.8, 2.0]].map(|u| {
        let mut surface = Surface::from_nurbs(nurbs.clone());
        let rect = Rect::new(u.into(), DVec2::new(0.0, 2.0)).unwrap();
        surface.trims.rects.push(rect);
        scene_of(vec![surface])
    });
    let frame = stage.frame(&halves[0]);
    let mut prepared = stage.prepared(&halves[0]);
    let aovs = stage.aovs(&mut prepared, &frame);
    let wrong = halves.each_ref().map(|scene| {
        let expected = coverage(scene, &frame.camera, stage.size, Method::Exact).unwrap();
        let pixels = expected.pixels.iter().zip(&aovs.uv);
        pixels.filter(|(cover, uv)| cover.covered() != (uv[3] != 0.0)).count()
    });
    assert!(wrong[0] < 100 && wrong[1] > 5_000, "{wrong:?}");
}

#[test]
fn every_scene_has_its_test() {
    let tested = include_str!("nurbs.rs");
    for file in std::fs::read_dir(root().join("resources/scenes/stability")).unwrap() {
        let name = file.unwrap().file_name().into_string().unwrap();
        let Some(name) = name.strip_prefix("nurbs-") else { continue };
        let name = name.rsplit_once('.').unwrap().0;
        assert!(tested.contains(&format!("\"{name}\"")), "{name} has no test");
    }
}
