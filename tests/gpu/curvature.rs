//! Curvature against closed forms, at poles and cusps, and the ends of its scales.

use std::path::Path;

use freeform_surface::{
    Analysis, Camera, CurvatureKind, CurvatureLimit, Degree, FloatTarget, Lens, Method, Scene,
    Surface,
};
use glam::{DMat3, DMat4, DVec2, DVec3, dvec3};

use super::analysis::{MAJOR, MINOR, SIZE, sphere, torus, views};
use crate::harness::patches::{scene_of, within};
use crate::harness::{Stage, load, root};

/// The AOVs of curvature and position, and for each covered pixel the ray through its centre in world space.
struct Seen {
    curvature: Vec<[f32; 4]>,
    normal: Vec<[f32; 4]>,
    position: Vec<[f32; 4]>,
    eye: DVec3,
    rays: Vec<DVec3>,
}

fn seen(stage: &mut Stage, scene: &Scene) -> Seen {
    let frame = stage.frame(scene);
    let mut prepared = stage.prepared(scene);
    let size = (stage.size.x, stage.size.y);
    let target = FloatTarget::for_aovs_and_curvature(stage.renderer(), size).unwrap();
    let aovs = prepared.aovs(stage.renderer_mut(), &target, &frame).unwrap();
    let to_world = (frame.camera.projection * frame.camera.view).inverse();
    let eye = frame.camera.view.inverse().w_axis.truncate();
    let rays = (0..size.0 * size.1).map(|i| {
        let place = DVec2::new(f64::from(i % size.0) + 0.5, f64::from(i / size.0) + 0.5);
        let ndc = DVec2::new(2.0 * place.x / f64::from(size.0), 2.0 * place.y / f64::from(size.1));
        let at = to_world.project_point3(dvec3(ndc.x - 1.0, 1.0 - ndc.y, 0.0));
        (at - eye).normalize()
    });
    let rays = rays.collect();
    let (curvature, normal, position) = (aovs.curvature, aovs.normal, aovs.position);
    Seen { curvature, normal, position, eye, rays }
}

/// On a sphere and a torus of any size and place, curvature is that of the closed form at the point that the ray through
/// the pixel's centre meets, except within 6° of silhouettes.
#[test]
fn curvature_is_the_closed_form_of_spheres_and_tori() {
    let mut stage = Stage::new(SIZE);
    for (scale, place) in [(1.0, DVec3::ZERO), (1e-3, dvec3(5.0, 1.0, 0.0)), (1e4, DVec3::ONE)] {
        for is_torus in [false, true] {
            let mut scene = if is_torus { torus() } else { sphere() };
            let turn = DMat4::from_quat(glam::DQuat::from_axis_angle(DVec3::X, 0.6));
            scene.surfaces[0].transform =
                DMat4::from_translation(place) * turn * DMat4::from_scale(DVec3::splat(scale));
            let from_world = scene.surfaces[0].transform.inverse();
            let Seen { curvature, normal, position, eye, rays } = seen(&mut stage, &scene);
            let (origin, mut compared, mut worst) =
                (from_world.transform_point3(eye), 0, [0.0_f64; 3]);
            for i in 0..rays.len() {
                if curvature[i][3] == 0.0 {
                    assert_eq!(curvature[i], [0.0; 4]);
                    continue;
                }
                let ray = DMat3::from_mat4(turn).inverse() * rays[i];
                // From the drawn point along the ray to the true one.
                let drawn = from_world.transform_point3(DVec3::from_array([
                    position[i][0].into(),
                    position[i][1].into(),
                    position[i][2].into(),
                ]));
                let mut along = (drawn - origin).dot(ray);
                let field = |point: DVec3| {
                    let ring = if is_torus { MAJOR } else { 0.0 };
                    let from_axis = point.truncate().length();
                    let off = DVec2::new(from_axis - ring, point.z);
                    let radial = (point.truncate() / from_axis * off.x / off.length())
                        .extend(off.y / off.length());
                    (off.length() - if is_torus { MINOR } else { 1.0 }, radial, off)
                };
                for _ in 0..20 {
                    let (distance, gradient, _) = field(origin + along * ray);
                    along -= distance / gradient.dot(ray);
                }
                let (distance, outwards, off) = field(origin + along * ray);
                let is_there = distance.abs() < 1e-12;
                if !is_there || outwards.dot(ray).abs() < 0.1 {
                    continue;
                }
                let across = if is_torus { 1.0 / MINOR } else { 1.0 };
                let around = if is_torus { off.x / MINOR / (MAJOR + off.x) } else { 1.0 };
                // The normal Su × Sv of both points outwards; they bend away from it.
                let own = DVec3::from_array([
                    normal[i][0].into(),
                    normal[i][1].into(),
                    normal[i][2].into(),
                ]);
                let side = (turn.transform_vector3(outwards)).dot(own).signum();
                let expected = [
                    across * around / scale / scale,
                    -side * 0.5 * (across + around) / scale,
                    -side * across / scale,
                ];
                let sizes =
                    [across * across.max(around) / scale / scale, across / scale, across / scale];
                for k in 0..3 {
                    let off = (f64::from(curvature[i][k]) - expected[k]).abs();
                    // Where the Gaussian curvature of the torus passes 0, its error is that of its factors.
                    let size = expected[k].abs().max(0.1 * sizes[k]);
                    worst[k] = worst[k].max(off / size);
                }
                compared += 1;
            }
            println!("torus: {is_torus}, × {scale}: {worst:?}, {compared} pixels");
            assert!(compared > 8_000, "{compared}");
            assert!(worst.iter().all(|worst| *worst <= 1e-4), "{is_torus} {scale}: {worst:?}");
        }
    }
}

/// Curvature under transforms that stretch and mirror: the sphere becomes an ellipsoid, whose curvature at a point x is
/// 1 / (abc h²)² with h² = Σ xᵢ²/aᵢ⁴.
#[test]
fn curvature_is_that_of_the_stretched_and_mirrored_surface() {
    let mut stage = Stage::new(SIZE);
    for axes in [dvec3(1.0, 2.0, 0.7), dvec3(-1.0, 1.5, 0.8)] {
        let mut scene = sphere();
        scene.surfaces[0].transform = DMat4::from_scale(axes);
        let Seen { curvature, normal, eye, rays, .. } = seen(&mut stage, &scene);
        let (mut compared, mut worst) = (0, [0.0_f64; 2]);
        for (i, ray) in rays.iter().enumerate() {
            let (from, along) = (eye / axes, *ray / axes);
            let (a, b, c) = (along.length_squared(), from.dot(along), from.length_squared() - 1.0);
            let root = b * b - a * c;
            if curvature[i][3] == 0.0 || root <= 0.0 {
                continue;
            }
            let at = eye + *ray * ((-b - root.sqrt()) / a);
            let gradient = at / (axes * axes);
            if gradient.normalize().dot(*ray).abs() < 0.1 {
                continue;
            }
            let (h, volume) = (gradient.length(), axes.x * axes.y * axes.z);
            let gaussian = 1.0 / (volume * h * h).powi(2);
            // From the trace of the shape operator.
            let sum = axes.length_squared() - at.length_squared();
            let mean = 0.5 * sum / (volume * volume * h.powi(3));
            let own = DVec3::from_array([0, 1, 2].map(|k| f64::from(normal[i][k])));
            let expected = [gaussian, -own.dot(gradient).signum() * mean];
            for k in 0..2 {
                let off = (f64::from(curvature[i][k]) / expected[k] - 1.0).abs();
                worst[k] = worst[k].max(off);
            }
            compared += 1;
        }
        println!("{axes}: {worst:?} of {compared}");
        assert!(compared > 10_000, "{compared}");
        assert!(worst.iter().all(|worst| *worst <= 1e-4), "{axes}: {worst:?}");
    }
}

/// Curvature is a number everywhere, at poles, cusps and creases too.
#[test]
fn curvature_is_finite_everywhere() {
    let mut stage = Stage::new(SIZE);
    let folder = root().join("resources/scenes/stability");
    let mut files: Vec<_> =
        std::fs::read_dir(folder).unwrap().map(|file| file.unwrap().path()).collect();
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    files.retain(|path| name(path).ends_with(".toml") && !name(path).contains("refused"));
    files.sort();
    assert!(files.len() > 10);
    let mut covered = 0;
    for path in files {
        for view in views(&Scene { settings: within(0.5), ..load(&path) }, 4) {
            let Seen { curvature, .. } = seen(&mut stage, &view);
            for pixel in &curvature {
                assert!(
                    pixel.iter().all(|value| value.is_finite()),
                    "{}: {pixel:?}",
                    path.display()
                );
                covered += usize::from(pixel[3] == 1.0);
            }
        }
    }
    assert!(covered > 100_000, "{covered}");
}

/// What has no curvature, meshes and the thesis' method, has zeros, also where it hides a surface.
#[test]
fn meshes_and_the_thesis_have_no_curvature() {
    let mut stage = Stage::new(SIZE);
    let mut scene = load(&root().join("resources/scenes/thesis/fig14.toml"));
    let is_drawn = |seen: &Seen| seen.position.iter().filter(|pixel| pixel[3] != 0.0).count();
    let own = seen(&mut stage, &scene);
    assert!(is_drawn(&own) > 5_000 && own.curvature.iter().all(|pixel| *pixel == [0.0; 4]));
    let mesh = crate::harness::meshes::mesh("torus");
    scene.meshes.push(freeform_surface::MeshModel::new(mesh, freeform_surface::Smoothing::Pn));
    for method in [Method::Thesis, Method::Exact] {
        scene.settings.method = method;
        scene.surfaces.retain(|_| method == Method::Thesis);
        let both = seen(&mut stage, &scene);
        assert!(is_drawn(&both) > 5_000, "{method:?}");
        assert!(both.curvature.iter().all(|pixel| *pixel == [0.0; 4]), "{method:?}");
    }
}

/// At the pole of a sphere, where u has no direction, curvature is that of the sphere.
#[test]
fn a_pole_is_as_curved_as_the_rest() {
    let mut scene = sphere();
    let lens = Lens::Perspective { fov_y_radians: 0.05 };
    scene.camera = Some(Camera::new(3.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, lens).unwrap());
    let mut stage = Stage::new(SIZE);
    let Seen { curvature, .. } = seen(&mut stage, &scene);
    for [gaussian, mean, largest, alpha] in curvature {
        assert_eq!(alpha, 1.0);
        assert!(
            (gaussian - 1.0).abs() < 1e-3 && (mean.abs() - 1.0).abs() < 1e-3,
            "{gaussian} {mean}"
        );
        assert!((largest.abs() - 1.0).abs() < 0.03, "{largest}");
    }
}

/// The limit that suits a scene is that of most of its curved area, whatever flat faces it has beside.
#[test]
fn the_limit_suits_the_scene() {
    let mut stage = Stage::new(SIZE);
    let mut limit = |scene: &Scene, of: CurvatureKind, limit: Option<f64>| {
        let limit = limit.map(|limit| CurvatureLimit::new(limit).unwrap());
        let analysis = Analysis::Curvature { of, limit };
        let mut scene = scene.clone();
        scene.settings.analysis = Some(analysis);
        let mut prepared = stage.prepared(&scene);
        let frame = stage.frame(&scene);
        let _ = stage.picture(&mut prepared, &frame);
        prepared.curvature_limit(&analysis).unwrap()
    };
    let mut ball = sphere();
    ball.surfaces[0].transform = DMat4::from_scale(DVec3::splat(0.3));
    for (of, expected) in
        [(CurvatureKind::Gaussian, 20.0), (CurvatureKind::Mean, 5.0), (CurvatureKind::Largest, 5.0)]
    {
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-9;
        assert!(near(limit(&ball, of, None), expected), "{of:?}");
        assert!(near(limit(&ball, of, Some(0.7)), 0.7));
        let floor = (0..4).map(|i| dvec3(f64::from(i % 2), f64::from(i / 2), -1.0).extend(1.0));
        let floor = Surface::new(Degree::new(1, 1).unwrap(), floor.collect()).unwrap();
        let both = scene_of(vec![ball.surfaces[0].clone(), floor.clone()]);
        assert!(near(limit(&both, of, None), expected), "{of:?}");
        assert!(limit(&scene_of(vec![floor]), of, None) > 0.0);
    }
}
