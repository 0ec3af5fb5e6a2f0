//! Freedoms that drivers have and use: they must not change a picture.
#![allow(unsafe_code, reason = "the driver's own limit is asked for")]

use freeform_surface::inspect::Buffer;
use freeform_surface::inspect::programs::Sources;
use freeform_surface::{
    Aovs, Camera, Corner, CreaseAngle, Degree, DriverInfo, Error, FloatTarget, Framebuffer, Lens,
    Mesh, MeshModel, Method, Scene, Smoothing, Surface, TessLevel, Tessellation,
};
use glam::{DVec2, DVec3, DVec4, UVec2, dvec2};
use glow::HasContext as _;

use crate::harness::Stage;
use crate::harness::{Checked, backends};

/// Number of squares along a side of the floors.
const SIDE: usize = 60;
/// Side of a square in pixels.
const PX: usize = 4;

/// A floor of squares, seen from above: each is `PX` pixels wide, the first at the lower left.
fn floor(level: u32) -> Scene {
    let middle = DVec3::new(0.5, 0.5, 0.0) * SIDE as f64;
    let lens = Lens::Orthographic { height: SIDE as f64 };
    let mut scene = Scene {
        surfaces: Vec::new(),
        camera: Some(Camera::new(middle + DVec3::Z, middle, DVec3::Y, lens).unwrap()),
        ..Scene::listing16()
    };
    scene.settings.tessellation = Tessellation::Level(TessLevel::new(i64::from(level)).unwrap());
    scene
}

fn draw(scene: &Scene, backend: freeform_surface::Backend) -> Aovs {
    let size = UVec2::splat((SIDE * PX) as u32);
    let mut stage = Stage::with_sources(backend, size, Sources::default());
    let mut prepared = stage.prepared(scene);
    stage.aovs(&mut prepared, &stage.frame(scene))
}

/// A pixel, counted from the lower left, that shows another patch than it should, or no patch.
#[derive(Debug)]
struct Wrong {
    column: usize,
    row: usize,
    shown: Option<f32>,
    #[expect(dead_code, reason = "for the test's message")]
    expected: usize,
}

/// The pixels that show another patch than `number` gives for their places.
fn wrong_numbers(aovs: &Aovs, number: impl Fn(DVec2) -> usize) -> Vec<Wrong> {
    let mut wrong = Vec::new();
    for (i, uv) in aovs.uv.iter().enumerate() {
        let (column, row) = (i % (SIDE * PX), SIDE * PX - 1 - i / (SIDE * PX));
        let expected = number((dvec2(column as f64, row as f64) + 0.5) / PX as f64);
        let shown = (uv[3] == 1.0).then_some(uv[2]);
        if shown != Some(expected as f32) {
            wrong.push(Wrong { column, row, shown, expected });
        }
    }
    wrong
}

/// Surfaces of patches with 25 and with 16 points alternate, and each surface is drawn in several draws. So
/// neither the start of a surface's points in their buffer nor the start of a draw is a multiple of anything.
#[test]
fn patches_keep_their_numbers_however_draws_are_divided() {
    let square = |number: usize, degree: Degree| {
        let side = degree.columns();
        let first = dvec2((number % SIDE) as f64, (number / SIDE) as f64);
        (0..side * side).map(move |i| {
            let at = |i: usize| i as f64 / (side - 1) as f64;
            DVec4::new(first.x + at(i % side), first.y + at(i / side), 0.0, 1.0)
        })
    };
    for method in [Method::Thesis, Method::Exact] {
        for level in [1, 4, 34] {
            let mut scene = floor(level);
            scene.settings.method = method;
            // The surfaces have one, two, three … rows of patches.
            let mut first = 0;
            for rows in 1.. {
                let degree = if rows % 2 == 1 { Degree::QUARTIC } else { Degree::CUBIC };
                let last = SIDE.min(first + rows);
                let points = (first * SIDE..last * SIDE).flat_map(|patch| square(patch, degree));
                scene.surfaces.push(Surface::new(degree, points.collect()).unwrap());
                first = last;
                if first == SIDE {
                    break;
                }
            }
            for backend in backends() {
                let number = |place: DVec2| place.y as usize * SIDE + place.x as usize;
                let wrong = wrong_numbers(&draw(&scene, backend), number);
                assert!(
                    wrong.is_empty(),
                    "{method:?} {level}: {} {:?}",
                    wrong.len(),
                    wrong.first()
                );
            }
        }
    }
}

#[test]
fn triangles_keep_their_numbers_however_draws_are_divided() {
    let corner = |x: usize, y: usize| Corner {
        position: (y * (SIDE + 1) + x) as u32,
        normal: 0,
        coordinate: Corner::NONE,
    };
    let positions = (0..(SIDE + 1) * (SIDE + 1))
        .map(|i| DVec3::new((i % (SIDE + 1)) as f64, (i / (SIDE + 1)) as f64, 0.0));
    let triangles = (0..SIDE * SIDE).flat_map(|square| {
        let (x, y) = (square % SIDE, square / SIDE);
        let [a, b] = [corner(x, y), corner(x + 1, y)];
        let [c, d] = [corner(x, y + 1), corner(x + 1, y + 1)];
        // The diagonal goes from the lower right to the upper left.
        [[a, b, c], [c, b, d]]
    });
    let mesh = Mesh::new(
        positions.collect(),
        vec![DVec3::Z],
        Vec::new(),
        triangles.collect(),
        CreaseAngle::default(),
    );
    let mesh = mesh.unwrap();
    for smoothing in [Smoothing::None, Smoothing::Pn, Smoothing::Phong(Default::default())] {
        for level in [1, 5, 20] {
            let mut scene = floor(level);
            scene.meshes.push(MeshModel::new(mesh.clone(), smoothing));
            for backend in backends() {
                let number = |place: DVec2| {
                    // Pixels on the diagonal itself may belong to either side.
                    let upper = place.fract().element_sum() > 1.0;
                    2 * (place.y as usize * SIDE + place.x as usize) + usize::from(upper)
                };
                let mut wrong = wrong_numbers(&draw(&scene, backend), number);
                let on_diagonal = |of: &Wrong| (of.column + of.row) % PX == PX - 1;
                wrong.retain(|of| of.shown.is_none() || !on_diagonal(of));
                assert!(
                    wrong.is_empty(),
                    "{smoothing:?} {level}: {} {:?}",
                    wrong.len(),
                    wrong.first()
                );
            }
        }
    }
}

#[test]
fn limits_that_are_too_low_are_named() {
    let enough = Checked::new(backends()[0]).info().clone();
    assert!(enough.check().is_ok());
    let too_little = [
        DriverInfo { max_patch_vertices: 24, ..enough.clone() },
        DriverInfo { max_tess_level: 63, ..enough.clone() },
        DriverInfo { max_patch_components: 109, ..enough.clone() },
        DriverInfo { max_texel_buffer: 65_535, ..enough.clone() },
        DriverInfo { max_fragment_storage_blocks: 1, ..enough.clone() },
    ];
    for (info, (limit, needed)) in
        too_little.iter().zip([(24, 25), (63, 64), (109, 110), (65_535, 65_536), (1, 2)])
    {
        let error = info.check().unwrap_err().to_string();
        assert!(error.contains(&format!("is {limit}; expected {needed} or more")), "{error}");
    }
}

#[test]
fn no_memory_is_one_error_that_names_the_object() {
    for backend in backends() {
        let context = freeform_surface::Headless::new(backend).unwrap();
        let side = context.info().max_size as u32;
        let gl = context.gl();
        // 16 bytes per pixel make 4 GiB for a side of 16,384.
        let error = match FloatTarget::new(gl, (side, side), 3) {
            Ok(_) => {
                eprintln!("{backend}: this driver has memory for 3 × {side} × {side} × 16 bytes");
                continue;
            }
            Err(error) => error,
        };
        assert!(matches!(error, Error::Driver { .. }), "{error}");
        assert!(error.to_string().contains("numbers"), "{error}");
        // The context remains usable.
        drop(context.debug_log().take_errors());
        let target = Framebuffer::new(gl, 8, 8).unwrap();
        assert_eq!(target.read().dimensions(), (8, 8));
        assert!(context.debug_log().take_errors().is_empty());
    }
}

#[test]
fn storage_beyond_the_drivers_limit_is_refused() {
    let context = Checked::new(backends()[0]);
    // SAFETY: the context is current; the parameter exists since OpenGL 4.3.
    let max = unsafe { context.gl().get_parameter_i64(glow::MAX_SHADER_STORAGE_BLOCK_SIZE) };
    if max > 1 << 30 {
        eprintln!("this driver's storage buffers hold {max} bytes: too many to try");
        return;
    }
    let values = vec![0_u32; max as usize / 4 + 1];
    let error = Buffer::for_storage(context.gl(), "trim points", &values).unwrap_err().to_string();
    assert!(error.contains("trim points") && error.contains(&max.to_string()), "{error}");
    assert!(Buffer::for_storage(context.gl(), "trim points", &values[..4]).is_ok());
}
