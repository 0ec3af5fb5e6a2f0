//! Tests of the report on scenes with known answers, and on shaders that were
//! broken on purpose.

use std::path::Path;

use freeform_surface::inspect::programs::{Sources, TrimFeatures};
use freeform_surface::inspect::{StaticMesh, StaticStyle, StaticVertex};
use freeform_surface::{
    Backend, Camera, Degree, Headless, Lens, Method, Rect, Scene, Shading, Surface, TessLevel,
    Tessellation,
};
use glam::{DVec3, DVec4, Vec3, dvec2, vec3};
use indicatif::ProgressBar;

use super::bench::{Bench, Wrong};
use super::triangles;

/// Pixels per unit: two units fill the 300 pixels of a quick report's picture.
const UNIT_PX: f32 = 150.0;

fn bench(sources: Sources, quick: bool) -> Bench {
    let resources = Path::new(env!("CARGO_MANIFEST_DIR")).join("resources");
    let context = Headless::new(Backend::Auto).unwrap();
    Bench::new(context, sources, resources, quick, ProgressBar::hidden()).unwrap()
}

/// A unit square in z = 0 with x = u and y = v, seen from above.
fn square() -> Scene {
    let third = |i: usize| i as f64 / 3.0;
    let points = (0..16).map(|i| DVec4::new(third(i % 4), third(i / 4), 0.0, 1.0)).collect();
    let middle = DVec3::new(0.5, 0.5, 0.0);
    let lens = Lens::Orthographic { height: 2.0 };
    Scene {
        surfaces: vec![Surface::new(Degree::CUBIC, points).unwrap()],
        camera: Some(Camera::new(middle + DVec3::Z, middle, DVec3::Y, lens).unwrap()),
        ..Scene::listing16()
    }
}

#[test]
fn of_a_plane_nothing_is_off() {
    let (errors, stats) = bench(Sources::default(), true).errors(&square()).unwrap();
    assert_eq!((errors.covered, errors.bad_values), (150 * 150, 0));
    assert!(errors.max_error_px < 1e-3 && errors.normal_error_deg < 1e-2, "{errors:?}");
    assert!(stats.triangles > 0);
}

#[test]
fn a_shifted_and_turned_surface_is_off_by_that() {
    let mut bench = bench(Sources::default(), true);
    let shift = vec3(3.0, 4.0, 0.0) / UNIT_PX;
    let (sine, cosine) = 10_f32.to_radians().sin_cos();
    let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[u, v]| StaticVertex {
        position: (Vec3::new(u, v, 0.0) + shift).into(),
        u,
        // Sv × Su points down.
        normal: [0.0, sine, -cosine],
        v,
        patch: 0,
    });
    let gl = bench.gl();
    let mesh = StaticMesh::new(&gl, &corners, &[0, 1, 2, 2, 1, 3]).unwrap();
    let scene = square();
    let texture = scene.surfaces[0].paint.upload(&gl).unwrap();
    let style = StaticStyle {
        method: Method::Exact,
        shading: Shading::Phong,
        trims: TrimFeatures::NONE,
        texture: &texture,
    };
    let errors = bench.static_errors(&mesh, &style, &scene).unwrap();
    assert_eq!(errors.covered, 150 * 150);
    for error in [errors.max_error_px, errors.rms_error_px] {
        assert!((error - 5.0).abs() < 1e-3, "{errors:?}");
    }
    assert!((errors.normal_error_deg - 10.0).abs() < 1e-2, "{errors:?}");
}

#[test]
fn an_icosahedron_is_as_far_from_its_sphere_as_its_faces() {
    let section = triangles::section(&mut bench(Sources::default(), true)).unwrap();
    let plain = |row: &&super::row::Row| row.scene == "sphere" && row.method == "plain, GPU";
    let row = section.rows.iter().find(plain).unwrap();
    // The inscribed sphere has the radius √((5 + 2√5) / 15).
    let expected = 1.0 - ((5.0 + 2.0 * 5_f64.sqrt()) / 15.0).sqrt();
    assert!((row.max_error.unwrap() - expected).abs() < 1e-5, "{row:?}");
    assert_eq!(row.triangles, Some(20));
}

#[test]
fn a_border_that_was_moved_by_three_pixels_is_found_there() {
    let mut scene = square();
    let interval = Rect::new(dvec2(0.4, 0.6), dvec2(0.2, 0.8)).unwrap();
    scene.surfaces[0].trims.rects.push(interval);
    scene.settings.method = Method::Exact;
    let found = |sources| {
        let mut bench = bench(sources, true);
        bench.wrong(&scene).unwrap()
    };
    let right = found(Sources::default());
    assert_eq!(right, Wrong { pixels: 0, distance: Some(0.0) });
    let moved = Sources::default().with_edit(
        "common/trim.glsl",
        "uv = clamp(uv, 0.0, 0.99999994);",
        "uv = clamp(uv + vec2(0.02, 0.0), 0.0, 0.99999994);",
    );
    let wrong = found(moved);
    // Three columns of 90 pixels are drawn inside the hole, and three columns beside it are missing.
    assert_eq!(wrong, Wrong { pixels: 6 * 90, distance: Some(3.0) });
}

#[test]
fn a_weight_that_is_off_by_a_thousandth_shows() {
    let mut scene = bench(Sources::default(), true).scene("scenes/thesis/fig14.toml").unwrap();
    scene.settings.method = Method::Exact;
    scene.settings.tessellation = Tessellation::Level(TessLevel::new(64).unwrap());
    let error = |sources| bench(sources, false).errors(&scene).unwrap().0.max_error_px;
    let right = error(Sources::default());
    let broken = Sources::default().with_edit(
        "exact/patch.glsl",
        "(ofS[n - i] * ofT[i])",
        "(ofS[n - i] * ofT[i]) + (i == 1 ? 1e-3 : 0.0)",
    );
    let wrong = error(broken);
    assert!(right < 0.1 && wrong > 3.0 * right, "{right} {wrong}");
}

#[test]
fn a_trim_that_is_off_by_a_ten_thousandth_shows() {
    let mut wrong = Vec::new();
    for shift in ["0.0", "1e-4"] {
        let sources = Sources::default().with_edit(
            "common/trim.glsl",
            "uv = clamp(uv, 0.0, 0.99999994);",
            &format!("uv = clamp(uv + {shift}, 0.0, 0.99999994);"),
        );
        let mut bench = bench(sources, false);
        let mut scene = bench.scene("scenes/thesis/fig22.toml").unwrap();
        scene.settings.method = Method::Exact;
        wrong.push(bench.wrong(&scene).unwrap().pixels);
    }
    assert!(wrong[0] == 0 && wrong[1] > 10, "{wrong:?}");
}
