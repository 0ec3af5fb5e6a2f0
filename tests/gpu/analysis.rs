//! Zebra, isophotes, curvature and draft: each pixel against the true surface, in `f64`, and against closed forms.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4};
use std::path::Path;

use freeform_surface::inspect::measure::{AnalysisErrors, Random, measure_analysis, random_view};
use freeform_surface::inspect::programs::Sources;
use freeform_surface::{
    Analysis, AnalysisKind, Camera, CurvatureKind, CurvatureLimit, Degree, Direction, Draft,
    DraftLimit, Frame, Framebuffer, Image, Lens, NurbsSurface, Samples, Scene, StripeCount,
    Stripes, Surface,
};
use glam::{DVec2, DVec3, DVec4, UVec2, dvec3, uvec2};

use crate::harness::patches::{is_long, scene_of, within};
use crate::harness::{Stage, backends, load, root};

pub(super) const SIZE: UVec2 = uvec2(320, 240);

/// A surface of revolution about z over the whole circle: u around the axis, v along a curve of degree 2, whose control
/// points are the distance from the axis, the height and the weight.
fn revolution(curve: &[[f64; 3]], knots: Vec<f64>) -> Surface {
    let circle = |i: usize| {
        let (sin, cos) = (i as f64 * FRAC_PI_4).sin_cos();
        let weight = if i.is_multiple_of(2) { 1.0 } else { FRAC_1_SQRT_2 };
        (DVec2::new(cos, sin) / weight, weight)
    };
    let points = curve.iter().flat_map(|[from_axis, height, own]| {
        (0..9).map(move |i| {
            let (around, weight) = circle(i);
            (*from_axis * around).extend(*height).extend(weight * own)
        })
    });
    let around = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4].map(f64::from).to_vec();
    let degree = Degree::new(2, 2).unwrap();
    Surface::from_nurbs(NurbsSurface::new(degree, [around, knots], points.collect()).unwrap())
}

/// An arc about the axis from one angle to another in steps of 45° between control points.
fn arc(middle: [f64; 2], radius: f64, first: f64, count: usize) -> Surface {
    let curve: Vec<[f64; 3]> = (0..2 * count + 1)
        .map(|i| {
            let (sin, cos) = (first + i as f64 * FRAC_PI_4).sin_cos();
            let weight = if i.is_multiple_of(2) { 1.0 } else { FRAC_1_SQRT_2 };
            let far = radius / weight;
            [middle[0] + far * cos, middle[1] + far * sin, weight]
        })
        .collect();
    let knots = (0..=count).flat_map(|i| [i as f64; 2]).collect::<Vec<_>>();
    let knots = [vec![0.0], knots, vec![count as f64]].concat();
    revolution(&curve, knots)
}

pub(super) fn sphere() -> Scene {
    scene_of(vec![arc([0.0, 0.0], 1.0, -2.0 * FRAC_PI_4, 2)])
}

pub(super) const MAJOR: f64 = 1.0;
pub(super) const MINOR: f64 = 0.4;

pub(super) fn torus() -> Scene {
    scene_of(vec![arc([MAJOR, 0.0], MINOR, 0.0, 4)])
}

/// A cone about z that gets narrower upwards by so many degrees.
fn cone(degrees: f64) -> Surface {
    let slope = degrees.to_radians().tan();
    let curve = [-1.0, 0.0, 1.0].map(|height: f64| [2.0 - height * slope, height, 1.0]);
    revolution(&curve, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0])
}

/// A B-spline surface of degree 5 in both directions.
fn quintic() -> Scene {
    let knots = |spans: usize| {
        let inner = (1..spans).map(|i| i as f64);
        let ends = |at: f64| std::iter::repeat_n(at, 6);
        ends(0.0).chain(inner).chain(ends(spans as f64)).collect::<Vec<_>>()
    };
    let mut random = Random(11);
    let points = (0..10 * 12).map(|i| {
        let (x, y) = (f64::from(i % 10) / 9.0, f64::from(i / 10) / 11.0);
        DVec4::new(x, y, 0.15 * (6.0 * x).sin() * (5.0 * y).cos() + 0.02 * random.unit(), 1.0)
    });
    let degree = Degree::new(5, 5).unwrap();
    let nurbs = NurbsSurface::new(degree, [knots(5), knots(7)], points.collect()).unwrap();
    scene_of(vec![Surface::from_nurbs(nurbs)])
}

fn teapot() -> Scene {
    let scene = load(&root().join("resources/surfaces/teapot.bpt"));
    Scene { settings: within(0.5), ..scene }
}

/// The errors of a picture of an analysis, and the picture.
fn judged(stage: &mut Stage, scene: &Scene, analysis: Analysis) -> (AnalysisErrors, Image) {
    let mut scene = scene.clone();
    scene.settings.analysis = Some(analysis);
    let mut prepared = stage.prepared(&scene);
    let frame = stage.frame(&scene);
    let image = stage.picture(&mut prepared, &frame);
    let aovs = stage.aovs(&mut prepared, &frame);
    let limit = prepared.curvature_limit(&analysis).unwrap_or(1.0);
    let shown = (&analysis, limit);
    (measure_analysis(&scene, &frame.camera, shown, &aovs, &image).0, image)
}

fn stripes(kind: AnalysisKind, count: i64, direction: DVec3) -> Analysis {
    let stripes = Stripes {
        count: StripeCount::new(count).unwrap(),
        direction: Direction::new(direction).ok(),
    };
    match kind {
        AnalysisKind::Zebra => Analysis::Zebra(stripes),
        _ => Analysis::Isophotes(stripes),
    }
}

/// Views of all kinds, from near and far, one that frames the scene, and one without perspective.
pub(super) fn views(scene: &Scene, count: u64) -> Vec<Scene> {
    let aspect = f64::from(SIZE.x) / f64::from(SIZE.y);
    let random = (0..count)
        .map(|i| Scene { camera: Some(random_view(scene, 5, i, aspect)), ..scene.clone() });
    let framed = scene.framed(aspect);
    let height = 0.8 * framed.eye().distance(framed.target());
    let lens = Lens::Orthographic { height };
    let flat = Camera::new(framed.eye(), framed.target(), framed.up(), lens).unwrap();
    let flat = Scene { camera: Some(flat), ..scene.clone() };
    [scene.clone(), flat].into_iter().chain(random).collect()
}

/// All pixels further than 0.1 px from the border of a stripe are right: within half a pixel but for one of a thousand,
/// within a pixel but for two.
fn check_stripes(name: &str, scene: &Scene) {
    let mut stage = Stage::new(SIZE);
    for kind in [AnalysisKind::Zebra, AnalysisKind::Isophotes] {
        for (tolerance, wrong) in [(0.5, 1), (1.0, 2)] {
            let mut all = AnalysisErrors::default();
            for view in views(scene, if is_long() { 32 } else { 4 }) {
                let mut view = view;
                view.settings.tessellation = within(tolerance).tessellation;
                let (errors, _) =
                    judged(&mut stage, &view, stripes(kind, 24, dvec3(0.3, -0.5, 0.8)));
                all = all.merge(&errors);
            }
            println!("{name} {kind:?} {tolerance} px: {all:?}");
            assert!(all.compared > 20_000, "{name}: {all:?}");
            assert!(all.beside * 50 < all.compared, "{name}: {all:?}");
            let share = all.compared * wrong / 1000;
            assert!(all.wrong <= share, "{name} {kind:?} {tolerance}: {all:?}");
        }
    }
}

#[test]
fn stripes_of_a_sphere_and_a_torus_are_where_the_true_surface_has_them() {
    check_stripes("sphere", &sphere());
    check_stripes("torus", &torus());
}

#[test]
fn stripes_of_the_teapot_and_of_degree_five_are_where_the_true_surface_has_them() {
    check_stripes("teapot", &teapot());
    check_stripes("quintic", &quintic());
}

#[test]
fn stripes_of_a_cad_model_are_where_the_true_surface_has_them() {
    let bracket = load(&root().join("resources/models/bracket.ffm"));
    check_stripes("bracket", &Scene { settings: within(0.5), ..bracket });
    let Some(folder) = crate::models::cad_files() else { return };
    let nacelle = load(&folder.join("tigl_nacelle.stp"));
    check_stripes("nacelle", &Scene { settings: within(0.5), ..nacelle });
}

/// Colours of curvature and draft over scales that are passed in many pixels, in models where strokes close gaps too.
#[test]
fn colours_are_those_of_the_true_surface() {
    let mut stage = Stage::new(SIZE);
    let blade = load(&root().join("resources/models/blade.ffm"));
    let blade = Scene { settings: within(0.5), ..blade };
    for (name, scene) in
        [("torus", torus()), ("quintic", quintic()), ("teapot", teapot()), ("blade", blade)]
    {
        let limit_degrees = DraftLimit::new(1.0).unwrap();
        let pull = Direction::new(DVec3::Z).unwrap();
        let mut shown = vec![Analysis::Draft(Draft { pull, limit: limit_degrees })];
        // The curvature of the teapot jumps between its patches, within a pixel of which it is not told apart.
        if name != "teapot" {
            shown.extend(CurvatureKind::ALL.map(|of| Analysis::Curvature { of, limit: None }));
        }
        for analysis in shown {
            let mut all = AnalysisErrors::default();
            for view in views(&scene, 0) {
                all = all.merge(&judged(&mut stage, &view, analysis).0);
            }
            println!("{name} {analysis:?}: {all:?}");
            assert!(all.compared > 10_000, "{name}: {all:?}");
            let share = if name == "teapot" { 500 } else { 1000 };
            assert!(all.wrong * share <= all.compared, "{name} {analysis:?}: {all:?}");
        }
    }
}

/// A bulge is blue and a bowl is red, whatever the parameters.
#[test]
fn the_side_that_is_seen_gives_the_sign() {
    let mut stage = Stage::new(SIZE);
    for (eye, is_bowl) in [(dvec3(0.0, -4.0, 0.3), false), (dvec3(0.0, 0.5, 0.1), true)] {
        for of in CurvatureKind::ALL {
            let mut scene = sphere();
            let lens = Lens::Perspective { fov_y_radians: 0.7 };
            scene.camera = Some(Camera::new(eye, DVec3::ZERO, DVec3::Z, lens).unwrap());
            let limit = CurvatureLimit::new(0.5).ok();
            let (_, image) = judged(&mut stage, &scene, Analysis::Curvature { of, limit });
            let is_red = is_bowl || of == CurvatureKind::Gaussian;
            let [red, _, blue, alpha] = image.get_pixel(SIZE.x / 2, SIZE.y / 2).0;
            assert!(alpha == 255 && (red > blue) == is_red, "{of:?} {is_bowl}: {red} {blue}");
        }
    }
}

/// Holes of pictures are holes in every shading, also where strokes close the gap between two surfaces.
#[test]
fn holes_of_pictures_stay_holes() {
    let mut stage = Stage::new(SIZE);
    let picture = Image::from_pixel(4, 4, image::Rgba([200, 100, 50, 0]));
    // Their common edge has other parameters on both sides, so that a stroke joins them.
    let surface = |first: f64, along: &[f64]| {
        let points = along.iter().flat_map(|y| {
            [0.0, 0.5, 1.0].map(|x| DVec4::new(first + x, *y, 0.6 * x * (1.0 - x), 1.0))
        });
        Surface::of_patch(Degree::new(2, along.len() - 1).unwrap(), points.collect()).unwrap()
    };
    let mut scene = scene_of(vec![surface(0.0, &[0.0, 1.0]), surface(1.0, &[0.0, 0.3, 1.0])]);
    scene.settings.tessellation = within(4.0).tessellation;
    let count = |scene: &Scene, stage: &mut Stage, kind: AnalysisKind| {
        let image = judged(stage, scene, kind.with_defaults()).1;
        image.pixels().filter(|pixel| pixel.0[3] != 0).count()
    };
    for kind in AnalysisKind::ALL {
        assert!(count(&scene, &mut stage, kind) > 5_000);
        let mut cut = scene.clone();
        for surface in &mut cut.surfaces {
            surface.paint = freeform_surface::Paint::Texture(picture.clone().into());
        }
        assert_eq!(count(&cut, &mut stage, kind), 0, "{kind:?}");
    }
}

/// Without the step to the pixel, stripes follow the triangles: the measurement notices.
#[test]
fn stripes_without_the_step_to_the_pixel_are_found_to_be_wrong() {
    let sources = Sources::default().with_edit(
        "exact/true_surface.glsl",
        "vec2 off = pixelPlace() - viewport.zw * clip.xy / clip.w;",
        "vec2 off = vec2(0.0);",
    );
    let mut scene = torus();
    scene.settings.tessellation = within(2.0).tessellation;
    let analysis = stripes(AnalysisKind::Zebra, 60, DVec3::Z);
    let [own, without] = [Sources::default(), sources].map(|sources| {
        let mut stage = Stage::with_sources(backends()[0], SIZE, sources);
        judged(&mut stage, &scene, analysis).0
    });
    assert!(without.wrong > 20 * own.wrong.max(1), "{own:?} {without:?}");
}

/// Cones of known draft, pulled along their axis, from both sides. A hundredth of a degree is two levels of the colour.
#[test]
fn draft_is_within_a_hundredth_of_a_degree() {
    let mut stage = Stage::new(SIZE);
    for degrees in [-0.9, -0.4, 0.0, 0.3, 0.6, 0.85] {
        for (from, sign) in [(dvec3(7.0, 1.0, 0.5), 1.0), (dvec3(0.1, 0.0, 0.05), -1.0)] {
            let lens = Lens::Perspective { fov_y_radians: 0.9 };
            let mut scene = scene_of(vec![cone(degrees)]);
            let target = dvec3(-4.0, 0.0, 0.0);
            scene.camera = Some(Camera::new(from, target, DVec3::Z, lens).unwrap());
            let limit = DraftLimit::new(1.0).unwrap();
            let pull = Direction::new(5.0 * DVec3::Z).unwrap();
            let analysis = Analysis::Draft(Draft { pull, limit });
            let (errors, image) = judged(&mut stage, &scene, analysis);
            // From inside, the normal that is seen points the other way.
            let value: f64 = sign * degrees;
            let (middle, end) = (
                [0.98, 0.88, 0.4],
                if value < 0.0 { [0.8, 0.15, 0.15] } else { [0.15, 0.6, 0.25] },
            );
            let expected: [f64; 3] =
                std::array::from_fn(|i| middle[i] + value.abs() * (end[i] - middle[i]));
            let drawn = image.pixels().filter(|pixel| pixel.0[3] != 0).collect::<Vec<_>>();
            assert!(drawn.len() > 5_000, "{}", drawn.len());
            let is_right = |pixel: &image::Rgba<u8>| {
                (0..3).all(|i| (f64::from(pixel.0[i]) - 255.0 * expected[i]).abs() <= 1.5)
            };
            let wrong = drawn.iter().filter(|pixel| !is_right(pixel)).count();
            // At the silhouette, the triangles show a little of the other side.
            assert!(
                wrong * 500 <= drawn.len(),
                "{degrees}° from {from}: {wrong} of {}",
                drawn.len()
            );
            assert!(errors.wrong * 500 <= errors.compared, "{errors:?}");
        }
    }
}

/// The direction of the parameters does not change what is seen.
#[test]
fn the_parameters_do_not_matter() {
    let mut stage = Stage::new(SIZE);
    let own = quintic();
    let mut turned = own.clone();
    let nurbs = own.surfaces[0].nurbs().unwrap();
    let [u, v] = nurbs.knots().clone();
    let columns = u.len() - 6;
    // u runs backwards.
    let last = u[u.len() - 1];
    let backwards: Vec<f64> = u.iter().rev().map(|knot| last - knot).collect();
    let rows = nurbs.control_points().chunks_exact(columns);
    let points: Vec<DVec4> = rows.flat_map(|row| row.iter().rev().copied()).collect();
    let degree = Degree::new(5, 5).unwrap();
    turned.surfaces[0] =
        Surface::from_nurbs(NurbsSurface::new(degree, [backwards, v], points).unwrap());
    for kind in AnalysisKind::ALL {
        for of in CurvatureKind::ALL {
            let analysis = match kind {
                AnalysisKind::Curvature => Analysis::Curvature { of, limit: None },
                AnalysisKind::Draft => Analysis::Draft(Draft {
                    pull: Direction::new(DVec3::Y).unwrap(),
                    limit: DraftLimit::new(90.0).unwrap(),
                }),
                _ => kind.with_defaults(),
            };
            let [one, other] = [&own, &turned].map(|scene| judged(&mut stage, scene, analysis).1);
            let differs = |(a, b): (&image::Rgba<u8>, &image::Rgba<u8>)| {
                a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 2)
            };
            let wrong = one.pixels().zip(other.pixels()).filter(|pair| differs(*pair)).count();
            let colors: std::collections::BTreeSet<_> = one.pixels().map(|pixel| pixel.0).collect();
            assert!(colors.len() >= 3, "{analysis:?}");
            assert!(wrong * 200 < one.pixels().len(), "{analysis:?}: {wrong}");
        }
    }
}

/// Stripes have two colours with one sample, in models too, where strokes close gaps; and greys between with several.
#[test]
fn stripes_are_dark_or_bright_and_mixed_by_samples_only() {
    let mut scene = load(&root().join("resources/models/bracket.ffm"));
    scene.settings = within(2.0);
    let mut stage = Stage::new(SIZE);
    let analysis = AnalysisKind::Zebra.with_defaults();
    let (_, image) = judged(&mut stage, &scene, analysis);
    for pixel in image.pixels().filter(|pixel| pixel.0[3] != 0) {
        assert!([26, 242].contains(&pixel.0[0]), "{pixel:?}");
    }
    scene.settings.analysis = Some(analysis);
    scene.settings.background = [0.0, 0.0, 0.0, 1.0];
    let gl = stage.context().gl().clone();
    let mut greys = [0; 2];
    for (greys, samples) in greys.iter_mut().zip([4, 64]) {
        let samples = Samples::new(samples).unwrap();
        let target = Framebuffer::for_samples(&gl, (SIZE.x, SIZE.y), samples).unwrap();
        let mut frame = Frame::of(&scene, SIZE);
        frame.settings.samples = samples;
        let mut prepared = stage.prepared(&scene);
        let image = prepared.picture(stage.renderer_mut(), &target, &frame, |_, _| {}).unwrap();
        *greys =
            image.pixels().map(|pixel| pixel.0[0]).collect::<std::collections::BTreeSet<_>>().len();
    }
    assert!(greys[0] > 4 && greys[1] > 3 * greys[0], "{greys:?}");
}

/// A finely divided sphere of triangles has nearly the stripes of the true sphere; curvature leaves meshes lit.
#[test]
fn meshes_have_stripes_by_their_normals() {
    let (around, along) = (64, 32);
    let mut text = String::new();
    for i in 0..=along {
        for j in 0..around {
            let [tilt, turn] = [(i, along), (j, around / 2)]
                .map(|(i, n)| f64::from(i) / f64::from(n) * std::f64::consts::PI);
            let [x, y, z] = [tilt.sin() * turn.cos(), tilt.sin() * turn.sin(), tilt.cos()];
            text += &format!("v {x} {y} {z}\nvn {x} {y} {z}\n");
        }
    }
    for i in 0..along {
        for j in 0..around {
            let at = |i: i32, j: i32| 1 + i * around + j % around;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            text += &format!("f {a}//{a} {b}//{b} {c}//{c}\nf {a}//{a} {c}//{c} {d}//{d}\n");
        }
    }
    let options = freeform_surface::LoadOptions::default();
    let mut scene = Scene::from_text(&text, Path::new("ball.obj"), &options).unwrap();
    scene.meshes[0].set_smoothing(freeform_surface::Smoothing::Pn);
    scene.settings = within(0.5);
    let mut stage = Stage::new(SIZE);
    let lit = stage.render(&scene);
    scene.settings.analysis = Some(AnalysisKind::Curvature.with_defaults());
    assert_eq!(stage.render(&scene), lit);
    for kind in [AnalysisKind::Zebra, AnalysisKind::Isophotes] {
        let analysis = stripes(kind, 12, DVec3::Y);
        scene.settings.analysis = Some(analysis);
        let image = stage.render(&scene);
        let mut exact = sphere();
        exact.camera = Some(scene.framed(f64::from(SIZE.x) / f64::from(SIZE.y)));
        exact.settings.analysis = Some(analysis);
        let expected = stage.render(&exact);
        let (mut both, mut wrong) = (0, 0);
        for (a, b) in image.pixels().zip(expected.pixels()) {
            both += usize::from(a.0[3] != 0 && b.0[3] != 0);
            wrong += usize::from(a.0[3] != 0 && b.0[3] != 0 && a.0[0].abs_diff(b.0[0]) > 2);
        }
        assert!(both > 10_000 && wrong * 20 < both, "{kind:?}: {wrong} of {both}");
    }
}

#[test]
fn scenes_name_what_is_shown() {
    let read = |shading: &str| {
        let text = format!(
            "[render]\nshading = {shading}\n[[surface]]\ncontrol_points = \"default\"\nshading = \"normals\"\n"
        );
        Scene::from_toml(&text, Path::new("x.toml"))
    };
    let direction = |x: f64, y: f64, z: f64| Direction::new(dvec3(x, y, z)).unwrap();
    let limit = CurvatureLimit::new(0.25).ok();
    for (text, expected) in [
        ("\"zebra\"", AnalysisKind::Zebra.with_defaults()),
        ("\"isophotes\"", AnalysisKind::Isophotes.with_defaults()),
        ("\"curvature\"", AnalysisKind::Curvature.with_defaults()),
        ("\"draft\"", AnalysisKind::Draft.with_defaults()),
        (
            "{ kind = \"isophotes\", stripes = 9, direction = [0, 3, 4] }",
            stripes(AnalysisKind::Isophotes, 9, dvec3(0.0, 3.0, 4.0)),
        ),
        (
            "{ kind = \"curvature\", curvature = \"largest\", limit = 0.25 }",
            Analysis::Curvature { of: CurvatureKind::Largest, limit },
        ),
        (
            "{ kind = \"draft\", direction = [0, 0, -2], limit_degrees = 3 }",
            Analysis::Draft(Draft {
                pull: direction(0.0, 0.0, -1.0),
                limit: DraftLimit::new(3.0).unwrap(),
            }),
        ),
    ] {
        let scene = read(text).unwrap();
        assert_eq!(scene.settings.analysis, Some(expected), "{text}");
        // What is written is read back.
        let written = scene.to_toml(Path::new("y.toml")).unwrap().text;
        let again = Scene::from_toml(&written, Path::new("y.toml")).unwrap();
        assert_eq!(again.settings, scene.settings, "{written}");
    }
    for (text, words) in [
        ("\"stripes\"", "\"zebra\", \"isophotes\", \"curvature\" or \"draft\""),
        ("{ kind = \"zebra\", limit = 1 }", "given with zebra"),
        ("{ kind = \"zebra\", stripes = 0 }", "from 1 to 1000"),
        ("{ kind = \"draft\", direction = [0, 0, 0] }", "not all 0"),
        ("{ kind = \"draft\", limit_degrees = 91 }", "to 90"),
        ("{ kind = \"curvature\", curvature = \"max\" }", "\"gaussian\", \"mean\" or \"largest\""),
        ("{ kind = \"curvature\", limit = -1 }", "1e-30"),
        ("7", "expected the name of a shading"),
    ] {
        let error = read(text).unwrap_err().to_string();
        assert!(error.starts_with("cannot read x.toml:2") || error.contains("x.toml:2"), "{error}");
        assert!(error.contains(words), "{error}");
    }
}
