//! The figures of the thesis and of the report, drawn by the GPU, against the `f64` reference at the
//! same level.
//!
//! No channel may be off by more than 2/255, or 4/255 where textured. The following are left out because the
//! driver is free to choose them; nothing else is left out:
//!
//! - pixels within 1.5 px of a silhouette, of the edge of a trim, or of the square of a control
//!   point, where a sample's exact place decides;
//! - pixels within 1.5 px of a line in wireframe, since OpenGL leaves a line's pixels to the driver;
//!   instead, the place of each line is tested by distance, and its colour where both renderers draw it;
//! - on textures, pixels whose centre lies within 1/128 px of an edge between two triangles: drivers
//!   round vertices to a grid of 1/256 px or so, which decides the triangle, and with it the
//!   texture's level of detail.
//!
//! The diagonals of the tessellation are free too; the reference draws those of Mesa (see `reference`). Where a
//! row has no root, Newton's method amplifies the last bit of `f32`. A speckle between the reference's pixels
//! may then fall on a pixel of the GPU. Such a pixel is excused if the reference's own decision changes within
//! 1.5 px of it.

use freeform_surface::inspect::programs::Sources;
use freeform_surface::inspect::reference::{self, Picture, Pixel, TrimDecision};
use freeform_surface::{Backend, Image, Method, Newton, Paint, Scene};
use glam::UVec2;

use crate::harness::{
    BAND_PX, assert_same, backends, difference, excuse_speckles, figures, load, render,
    stored_reference,
};

/// The size of the stored references.
const SMALL: UVec2 = UVec2::new(250, 150);
/// The size of the command line's pictures.
const LARGE: UVec2 = UVec2::new(1000, 600);
/// The number of pixels that speckles between pixels may explain in one picture: 1 in 20,000 of the large
/// pictures.
const MAX_EXCUSED: usize = 30;

fn is_textured(scene: &Scene) -> bool {
    scene.surfaces.iter().any(|surface| matches!(surface.paint, Paint::Texture(_)))
}

fn tolerance(scene: &Scene) -> u8 {
    if is_textured(scene) { 4 } else { 2 }
}

/// The pixels that the driver is free to choose.
fn left_out(scene: &Scene, picture: &Picture) -> Vec<bool> {
    let mut left_out = picture.edge_band(BAND_PX);
    let (width, height) = (picture.image.width() as i32, picture.image.height() as i32);
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let Pixel::Surface(fragment) = pixel else { continue };
        if scene.settings.wireframe {
            // Neighbours up to (1, 1) away are within 1.5 px.
            let (x, y) = (i as i32 % width, i as i32 / width);
            for (x, y) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x + dx, y + dy))) {
                if (0..width).contains(&x) && (0..height).contains(&y) {
                    left_out[(y * width + x) as usize] = true;
                }
            }
        } else if is_textured(scene) && fragment.edge_px < 1.0 / 128.0 {
            left_out[i] = true;
        }
    }
    left_out
}

fn check(name: &str, scene: &Scene, picture: &Picture, expected: &Image, actual: &Image) {
    let mut left_out = left_out(scene, picture);
    let excused = excuse_speckles(scene, picture, actual, &mut left_out, tolerance(scene));
    assert!(excused <= MAX_EXCUSED, "{name}: {excused} pixels only explained by speckles");
    assert_same(name, expected, actual, &left_out, tolerance(scene));
}

fn small_figures(backend: Backend) {
    for (name, path) in figures() {
        let scene = load(&path);
        let picture = reference::render(&scene, SMALL, Method::Thesis).unwrap();
        let stored = stored_reference(&name, &picture.image);
        // The stored picture is the reference's; another machine's libm may round differently.
        assert_same(&format!("{name}-stored"), &stored, &picture.image, &[], 1);
        let actual = render(&scene, SMALL, backend);
        check(&format!("{name}-{backend}"), &scene, &picture, &stored, &actual);
    }
}

#[test]
fn figures_match_their_stored_references_through_egl() {
    if backends().contains(&Backend::Egl) {
        small_figures(Backend::Egl);
    }
}

#[test]
fn figures_match_their_stored_references_through_osmesa() {
    if backends().contains(&Backend::Osmesa) {
        small_figures(Backend::Osmesa);
    }
}

#[test]
fn figures_match_the_reference_at_full_size() {
    for (name, path) in figures() {
        let scene = load(&path);
        let picture = reference::render(&scene, LARGE, Method::Thesis).unwrap();
        let actual = render(&scene, LARGE, backends()[0]);
        check(&format!("{name}-large"), &scene, &picture, &picture.image, &actual);
    }
}

/// Pixels of a picture that differ from the background.
fn drawn(image: &Image, background: [u8; 4]) -> Vec<(i32, i32)> {
    image
        .enumerate_pixels()
        .filter(|(_, _, pixel)| (0..4).any(|c| pixel.0[c].abs_diff(background[c]) > 1))
        .map(|(x, y, _)| (x as i32, y as i32))
        .collect()
}

/// The number of `pixels` that have no pixel of `others` within one pixel.
fn lonely(pixels: &[(i32, i32)], others: &[(i32, i32)]) -> usize {
    let others: std::collections::HashSet<_> = others.iter().copied().collect();
    pixels
        .iter()
        .filter(|(x, y)| !(-1..=1).any(|dy| (-1..=1).any(|dx| others.contains(&(x + dx, y + dy)))))
        .count()
}

#[test]
fn lines_lie_where_the_reference_draws_them() {
    for name in ["thesis/fig21", "thesis/fig26", "report/wireframe"] {
        let path =
            crate::harness::root().join("resources/scenes").join(name).with_extension("toml");
        let scene = load(&path);
        let background = scene.settings.background.map(|c| (c * 255.0).round() as u8);
        let reference = reference::render(&scene, LARGE, Method::Thesis).unwrap().image;
        let actual = render(&scene, LARGE, backends()[0]);
        let (expected, actual) = (drawn(&reference, background), drawn(&actual, background));
        assert!(expected.len() > 20_000, "{name}: only {} pixels of lines", expected.len());
        let strays = [lonely(&expected, &actual), lonely(&actual, &expected)];
        // Drivers drop or add the pixel at a line's end.
        assert!(strays.iter().all(|count| *count <= 5), "{name}: {strays:?} pixels astray");
    }
}

/// Pixels of lines in the report's picture that are neither red nor blue.
fn wrongly_coloured(scene: &Scene, actual: &Image) -> usize {
    let background = scene.settings.background.map(|c| (c * 255.0).round() as u8);
    drawn(actual, background)
        .iter()
        .filter(|(x, y)| {
            let color = actual.get_pixel(*x as u32, *y as u32).0;
            color != [255, 0, 0, 255] && color != [0, 128, 255, 255]
        })
        .count()
}

#[test]
fn lines_have_the_colours_of_the_reference() {
    let scene = load(&crate::harness::root().join("resources/scenes/report/wireframe.toml"));
    let actual = render(&scene, LARGE, backends()[0]);
    assert_eq!(wrongly_coloured(&scene, &actual), 0);
    let green = Sources::default().with_edit(
        "report/surface.frag",
        "color = vec4(1.0, 0.0, 0.0, 1.0)",
        "color = vec4(0.0, 1.0, 0.0, 1.0)",
    );
    let actual = crate::harness::render_with(&scene, LARGE, backends()[0], green);
    assert!(wrongly_coloured(&scene, &actual) > 10_000);

    // The thesis' lines are lit. Where both renderers draw a line, its light is the same, except for the
    // fraction of a pixel by which the samples of the line may be apart.
    for name in ["fig21.toml", "fig26.toml"] {
        let mut scene = load(&crate::harness::root().join("resources/scenes/thesis").join(name));
        scene.surfaces[0].paint = Paint::Color([0.6, 0.7, 0.8]);
        let picture = reference::render(&scene, LARGE, Method::Thesis).unwrap();
        let actual = render(&scene, LARGE, backends()[0]);
        let background = *picture.image.get_pixel(0, 0);
        let apart: Vec<bool> = std::iter::zip(picture.image.pixels(), actual.pixels())
            .map(|(a, b)| *a == background || *b == background)
            .collect();
        let found = difference(&picture.image, &actual, &apart, 8).unwrap();
        assert!(found.compared > 20_000, "{name}: {found:?}");
        assert!(found.wrong < found.compared / 200, "{name}: {found:?}");
    }
}

#[test]
fn diagonals_are_those_the_reference_draws() {
    for level in (1..=9).chain([33, 34]) {
        let text = format!(
            "camera = {{ eye = [0, 2, 0], target = [0, 0, 0], up = [0, 0, -1], orthographic_height = 1.2 }}
             render = {{ level = {level}, wireframe = true, background = [0, 0, 0, 1] }}
             surface = [{{ control_points = \"default\", color = [1, 1, 1], shading = \"flat\" }}]"
        );
        let scene = Scene::from_toml(&text, "diagonals.toml".as_ref()).unwrap();
        let size = UVec2::splat(480);
        let reference = reference::render(&scene, size, Method::Thesis).unwrap().image;
        let actual = render(&scene, size, backends()[0]);
        let (expected, actual) =
            (drawn(&reference, [0, 0, 0, 255]), drawn(&actual, [0, 0, 0, 255]));
        assert_eq!(lonely(&expected, &actual), 0, "level {level}");
        assert_eq!(lonely(&actual, &expected), 0, "level {level}");
    }
}

/// The thesis' pictures are wrong where its method is wrong. The reference has twins of both methods, so wrong
/// pixels are counted without a GPU.
#[test]
fn the_thesis_misses_the_truth_where_its_model_says() {
    let count = |name: &str| {
        let scene = load(&crate::harness::root().join("resources/scenes/thesis").join(name));
        let thesis = reference::render(&scene, SMALL, Method::Thesis).unwrap();
        let truth = reference::render(&scene, SMALL, Method::Exact).unwrap();
        let decisions: Vec<TrimDecision<'_>> = (scene.surfaces.iter())
            .map(|surface| {
                TrimDecision::new(&surface.trims, scene.settings.newton, Method::Exact).unwrap()
            })
            .collect();
        let is_wrong = |pixel: &&Pixel| match pixel {
            Pixel::Surface(fragment) => decisions[fragment.surface].cut(fragment.uv),
            Pixel::Hole(fragment) => !decisions[fragment.surface].cut(fragment.uv),
            _ => false,
        };
        let trims = thesis.pixels.iter().filter(is_wrong).count();
        let light = difference(&truth.image, &thesis.image, &[], 16).unwrap().wrong;
        (trims, light)
    };
    // The tangent along u of the thesis' normal comes from the last row. So much of a lit bump is off by more
    // than 16/255, although nothing is cut. Circles, intervals and ellipses are cut exactly.
    let (trims, light) = count("fig14.toml");
    assert_eq!(trims, 0);
    assert!(light > 3000, "{light}");
    for name in ["fig15.toml", "fig16.toml", "fig18.toml", "fig20.toml"] {
        assert_eq!(count(name).0, 0, "{name}");
    }
    // A row without a root makes Newton's method diverge. It leaves speckles above and below each loop, and
    // inside the ring of nested loops, whose inner curves are not tested for t in [0, 1].
    for name in ["fig22.toml", "fig23.toml", "fig24.toml", "fig25.toml"] {
        let (trims, _) = count(name);
        assert!((20..400).contains(&trims), "{name}: {trims}");
    }
    // The end points lie on two rows: whole stretches between these rows are wrong.
    let (tilted, _) = count("fig28.toml");
    assert!(tilted > 1000, "{tilted}");
    // Six iterations are worse than seven. An epsilon of 0.1 bends the edge, one of 0.01 leaves a
    // step in it; with 0.001 and 0.0001 the edge is right.
    let [seven, six] = ["fig29.toml", "fig30.toml"].map(|name| count(name).0);
    assert!(six > seven, "{six} {seven}");
    let [hundredth, thousandth, fine] = ["fig32.toml", "fig33.toml", "fig34.toml"]
        .map(|name| load(&crate::harness::root().join("resources/scenes/thesis").join(name)))
        .map(|scene| edge_misses(&scene));
    let mut tenth = load(&crate::harness::root().join("resources/scenes/thesis/fig31.toml"));
    let bent = edge_misses(&tenth);
    tenth.settings.newton = Newton::default();
    let straight = edge_misses(&tenth);
    assert!(bent > 500 && bent > 5 * straight, "{bent} {straight}");
    assert!(hundredth > 1000, "{hundredth}");
    assert!(thousandth < 100 && fine <= thousandth, "{thousandth} {fine}");
}

/// Pixels inside the hole that the thesis leaves, and pixels outside that it cuts and that are connected to the
/// hole. These are the errors of the edge, without the speckles further out.
fn edge_misses(scene: &Scene) -> usize {
    let is_drawn = |arithmetic| -> Vec<bool> {
        let picture = reference::render(scene, LARGE, arithmetic).unwrap();
        picture.pixels.iter().map(|pixel| matches!(pixel, Pixel::Surface(_))).collect()
    };
    let (thesis, truth) = (is_drawn(Method::Thesis), is_drawn(Method::Exact));
    let (width, height) = (LARGE.x as usize, LARGE.y as usize);
    (0..width)
        .map(|x| {
            // The hole is below; the search goes up from there to the first drawn pixel.
            let edge =
                |drawn: &[bool]| (0..height).rev().find(|y| drawn[y * width + x]).unwrap_or(0);
            edge(&thesis).abs_diff(edge(&truth))
        })
        .sum()
}

#[test]
fn a_wrong_shader_does_not_pass() {
    let small = |name: &str| {
        let scene = load(&crate::harness::root().join("resources/scenes").join(name));
        let picture = reference::render(&scene, SMALL, Method::Thesis).unwrap();
        let left_out = left_out(&scene, &picture);
        (scene, picture, left_out)
    };
    let [thesis, report] = ["thesis/fig15.toml", "report/textured.toml"].map(small);
    for (file, right, wrong) in [
        ("thesis/surface.tese", "t * points[j + 1]", "t * 1.01 * points[j + 1]"),
        ("common/phong.glsl", "vec3(0.1)", "vec3(0.15)"),
        ("thesis/trim.glsl", "< radius", "< radius + 0.02"),
        ("thesis/surface.tesc", "= tessLevel", "= 2.0"),
        ("report/surface.tese", "power(t, i)", "power(t, i) * (1.0 + 0.02 * float(i))"),
        ("report/surface.frag", "texture(textureSurface", "0.9 * texture(textureSurface"),
    ] {
        let (scene, picture, left_out) = if file.starts_with("report") { &report } else { &thesis };
        let sources = Sources::default().with_edit(file, right, wrong);
        let actual = crate::harness::render_with(scene, SMALL, backends()[0], sources);
        let found = difference(&picture.image, &actual, left_out, 4).unwrap();
        assert!(found.wrong > 20, "{file} with {wrong}: {found:?}");
    }
}
