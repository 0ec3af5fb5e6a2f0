//! `freeform info --check`: draws patches, trims and a mesh with known points, reads the drawn AOVs back and
//! compares them with `f64`.

use std::f64::consts::{PI, TAU};
use std::fmt;

use crate::io::{Error, Result};
use freeform_surface::inspect::measure::measure;
use freeform_surface::inspect::programs::Sources;
use freeform_surface::inspect::reference::coverage;
use freeform_surface::{
    Aovs, Camera, Circle, Corner, CreaseAngle, Degree, Ellipse, FloatTarget, Frame, Headless, Lens,
    Mesh, MeshModel, Method, Normals, PreparedScene, Rect, Renderer, Scene, Smoothing, Surface,
    TessLevel, Tessellation, TrimLoop,
};
use glam::{DVec2, DVec3, DVec4, UVec2, dvec2, dvec3};

/// Size of the pictures in pixels.
const SIZE: UVec2 = UVec2::new(192, 144);

/// Results for a driver that draws correctly.
#[derive(Debug)]
pub(super) struct Checked {
    /// The largest distance on the screen between a pixel and the point of a patch that it shows.
    patches_px: f64,
    /// The number of pixels whose trims were compared.
    trimmed: usize,
    /// The largest distance of a point of the mesh from the sphere of radius 1.
    mesh: f64,
}

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { patches_px, trimmed, mesh } = self;
        write!(
            f,
            "patches within {patches_px:.2} px, {trimmed} trimmed pixels as in f64, a smooth mesh within \
             {mesh:.0e} of its radius"
        )
    }
}

/// Draws everything and compares it.
///
/// # Errors
/// The first object that is drawn wrongly or not at all.
pub(super) fn run(context: &Headless, sources: Sources) -> Result<Checked> {
    let mut renderer = Renderer::with_sources(context.gl(), sources)?;
    let of = |what: &str, found: std::result::Result<_, String>| {
        found.map_err(|wrong| {
            Error::WrongDriver(format!("WRONG on {}: {what}: {wrong}", context.info()))
        })
    };
    let mut patches_px = 0.0;
    for method in [Method::Exact, Method::Thesis] {
        let scene = patches(method);
        let drawn = draw(&mut renderer, &scene)?;
        patches_px = of("patches", patches_off(&scene, &drawn))?.max(patches_px);
    }
    let scene = square();
    let trimmed = of("trims", trims_off(&scene, &draw(&mut renderer, &scene)?))?;
    let scene = sphere()?;
    let mesh = of("meshes", sphere_off(&scene, &draw(&mut renderer, &scene)?))?;
    if let Some(complaint) = context.debug_log().take_errors().first() {
        of("the driver's own errors", Err(complaint.clone()))?;
    }
    Ok(Checked { patches_px, trimmed: trimmed as usize, mesh })
}

fn draw(renderer: &mut Renderer, scene: &Scene) -> Result<Aovs> {
    let target = FloatTarget::for_aovs(renderer, SIZE.into())?;
    let frame = Frame::of(scene, SIZE);
    Ok(PreparedScene::new(renderer, scene)?.aovs(renderer, &target, &frame)?)
}

/// A height field of 144 cubic patches and, behind it, a rational patch of degree 4. The rational patch comes
/// first in the scene.
fn patches(method: Method) -> Scene {
    const SIDE: usize = 12;
    let height = |x: f64, y: f64| 0.3 * (2.5 * x).sin() * (3.0 * y).cos();
    let grid = |side: usize, from: DVec2, size: f64| {
        let at = move |i: usize| i as f64 / (side - 1) as f64 * size;
        (0..side * side).map(move |i| from + dvec2(at(i % side), at(i / side)))
    };
    let weight = |point: DVec2| 1.0 + 0.5 * (3.0 * point.x).sin();
    let quartic = grid(5, dvec2(-0.5, 1.05), 1.0)
        .map(|at| DVec4::new(at.x, at.y, height(2.0 * at.x, at.y), weight(at)));
    let hills: Vec<DVec4> = grid(3 * SIDE + 1, DVec2::splat(-1.0), 2.0)
        .map(|at| DVec4::new(at.x, at.y, height(at.x, at.y), 1.0))
        .collect();
    let point = |patch: usize, i: usize| {
        let (column, row) = (3 * (patch % SIDE) + i % 4, 3 * (patch / SIDE) + i / 4);
        hills[row * (3 * SIDE + 1) + column]
    };
    let cubic = (0..SIDE * SIDE).flat_map(|patch| (0..16).map(move |i| point(patch, i)));
    let lens = Lens::Perspective { fov_y_radians: 40_f64.to_radians() };
    let camera = Camera::new(dvec3(-1.2, -2.2, 2.2), dvec3(0.0, 0.3, 0.0), DVec3::Z, lens);
    let surface = |degree, points| Surface::new(degree, points).expect("finite control points");
    let mut scene = Scene {
        surfaces: vec![
            surface(Degree::QUARTIC, quartic.collect()),
            surface(Degree::CUBIC, cubic.collect()),
        ],
        camera: Some(camera.expect("a fixed camera")),
        ..Scene::listing16()
    };
    scene.settings.method = method;
    scene.settings.normals = Normals::Pixel;
    if method == Method::Thesis {
        scene.settings.tessellation = Tessellation::Level(TessLevel::default());
    }
    scene
}

/// The largest distance on the screen between a pixel and the point that it claims to show.
fn patches_off(scene: &Scene, drawn: &Aovs) -> std::result::Result<f64, String> {
    let projection = scene.projection(SIZE.x, SIZE.y);
    let method = scene.settings.method;
    let name = if method == Method::Exact { "exact" } else { "thesis'" };
    let reference =
        coverage(scene, &projection, SIZE, method).map_err(|error| error.to_string())?;
    let found = measure(scene, &projection, drawn, &reference);
    let tolerance = 0.5;
    if found.bad_values > 0 || found.max_error_px.is_nan() || found.max_error_px > tolerance {
        return Err(format!(
            "{:.2} px from their places by the {name} method (at most {tolerance} expected), {} numbers \
             make no sense",
            found.max_error_px, found.bad_values
        ));
    }
    if found.crack_pixels + found.hidden_pixels > 0
        || found.covered.abs_diff(found.expected) > found.expected / 50
    {
        return Err(format!(
            "{} pixels drawn by the {name} method, expected {}; {} are holes, {} show what is hidden",
            found.covered, found.expected, found.crack_pixels, found.hidden_pixels
        ));
    }
    // The normals of the thesis' method are wrong by design, so only those of the exact method are checked.
    let normals = 0.1;
    if method == Method::Exact
        && (found.normal_error_deg.is_nan() || found.normal_error_deg > normals)
    {
        return Err(format!(
            "normals {:.2} degrees off, at most {normals} expected",
            found.normal_error_deg
        ));
    }
    Ok(found.max_error_px)
}

/// A square cut by trims of every kind. For each pixel, the place in the domain that it shows is known.
fn square() -> Scene {
    let third = |i: usize| i as f64 / 3.0;
    let points = (0..16).map(|i| DVec4::new(third(i % 4), third(i / 4), 0.0, 1.0)).collect();
    let middle = dvec3(0.5, 0.5, 0.0);
    let camera =
        Camera::new(middle + DVec3::Z, middle, DVec3::Y, Lens::Orthographic { height: 1.0 });
    let mut surface = Surface::new(Degree::CUBIC, points).expect("a patch");
    let trims = &mut surface.trims;
    trims.circles.extend(Circle::new(dvec2(0.21, 0.77), 0.153));
    trims.rects.extend(Rect::new(dvec2(0.613, 0.907), dvec2(0.711, 0.873)));
    trims.ellipses.extend(Ellipse::new(dvec2(0.307, 0.247), dvec2(0.217, 0.113)));
    let path = "M.61 .13 C.93 .11 .97 .29 .83 .41 Q.67 .57 .57 .37 Z M.71 .23 h.11 v.12 h-.11 z";
    trims.loops = TrimLoop::from_svg_path(path).expect("closed loops");
    Scene {
        surfaces: vec![surface],
        camera: Some(camera.expect("a fixed camera")),
        ..Scene::listing16()
    }
}

/// The number of pixels of the square that were compared.
fn trims_off(scene: &Scene, drawn: &Aovs) -> std::result::Result<f64, String> {
    let size = SIZE.as_dvec2();
    let (mut compared, mut wrong) = (0_u32, 0);
    for (i, uv) in drawn.uv.iter().enumerate() {
        let pixel = UVec2::new(i as u32 % SIZE.x, i as u32 / SIZE.x).as_dvec2() + 0.5;
        let from_middle = (pixel - 0.5 * size) / size.y;
        let place = dvec2(0.5 + from_middle.x, 0.5 - from_middle.y);
        let within = place.x > 0.0 && place.x < 1.0;
        let expected = within && !scene.surfaces[0].trims.cut(place);
        compared += u32::from(within);
        let off = dvec2(f64::from(uv[0]), f64::from(uv[1])).distance(place);
        wrong += u32::from((uv[3] != 0.0) != expected || expected && (off.is_nan() || off > 1e-5));
    }
    if wrong > 0 {
        return Err(format!("{wrong} of {compared} pixels are not as in f64"));
    }
    Ok(f64::from(compared))
}

/// A sphere of radius 1 as curved PN triangles, seen along −z.
fn sphere() -> Result<Scene> {
    const RINGS: u32 = 24;
    const ROUND: u32 = 48;
    let mut positions = vec![DVec3::Z];
    for ring in 1..RINGS {
        let (sine, cosine) = (PI * f64::from(ring) / f64::from(RINGS)).sin_cos();
        positions.extend((0..ROUND).map(|i| {
            let (y, x) = (TAU * f64::from(i) / f64::from(ROUND)).sin_cos();
            dvec3(sine * x, sine * y, cosine)
        }));
    }
    positions.push(DVec3::NEG_Z);
    let at = |ring: u32, i: u32| match ring {
        0 => 0,
        RINGS => 1 + (RINGS - 1) * ROUND,
        _ => 1 + (ring - 1) * ROUND + i % ROUND,
    };
    let corner = |position| Corner { position, normal: position, coordinate: Corner::NONE };
    let mut triangles = Vec::new();
    for (ring, i) in (0..RINGS).flat_map(|ring| (0..ROUND).map(move |i| (ring, i))) {
        let [a, b] = [at(ring, i), at(ring, i + 1)];
        let [c, d] = [at(ring + 1, i), at(ring + 1, i + 1)];
        if ring > 0 {
            triangles.push([a, c, b].map(corner));
        }
        if ring + 1 < RINGS {
            triangles.push([b, c, d].map(corner));
        }
    }
    let normals = positions.clone();
    let mesh = Mesh::new(positions, normals, Vec::new(), triangles, CreaseAngle::default())?;
    let mut model = MeshModel::new(mesh, Smoothing::Pn);
    model.level = Some(TessLevel::new(4)?);
    let camera =
        Camera::new(3.0 * DVec3::Z, DVec3::ZERO, DVec3::Y, Lens::Orthographic { height: 2.2 })?;
    Ok(Scene {
        surfaces: Vec::new(),
        meshes: vec![model],
        camera: Some(camera),
        ..Scene::listing16()
    })
}

/// The largest distance of a drawn point from the sphere.
fn sphere_off(scene: &Scene, drawn: &Aovs) -> std::result::Result<f64, String> {
    /// Curved PN triangles of this size deviate from their sphere by less than this.
    const NEAR: f64 = 5e-4;
    let mesh = scene.meshes[0].mesh().mesh();
    let size = SIZE.as_dvec2();
    let (mut expected, mut missing, mut wrong, mut max) = (0_u32, 0, 0, 0.0_f64);
    for (i, (uv, position)) in drawn.uv.iter().zip(&drawn.position).enumerate() {
        let pixel = UVec2::new(i as u32 % SIZE.x, i as u32 / SIZE.x).as_dvec2() + 0.5;
        let place = (pixel - 0.5 * size) * dvec2(2.2, -2.2) / size.y;
        if place.length() > 0.98 {
            continue;
        }
        expected += 1;
        if uv[3] == 0.0 {
            missing += 1;
            continue;
        }
        let [x, y, z, _] = position.map(f64::from);
        let point = dvec3(x, y, z);
        let off = (point.length() - 1.0).abs();
        let on_ray = z > 0.0 && point.truncate().distance(place) < NEAR;
        // The triangle with the pixel's number must be near this point.
        let triangle = mesh.triangles().get(uv[2] as usize);
        let near = triangle.is_some_and(|corners| {
            let [a, b, c] = corners.map(|corner| mesh.positions()[corner.position as usize]);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            [a, b, c].iter().all(|corner| corner.distance(point) < 1.01 * longest)
        });
        wrong += u32::from(!on_ray || !near || off.is_nan() || off > NEAR);
        max = max.max(off);
    }
    if missing + wrong > 0 {
        return Err(format!(
            "of {expected} pixels of a sphere {missing} are holes and {wrong} are off ({max:.1e} of its \
             radius at most, {NEAR:.0e} expected)"
        ));
    }
    Ok(max)
}

#[cfg(test)]
mod tests {
    use freeform_surface::Backend;

    use super::*;

    fn error(file: &str, old: &str, new: &str) -> String {
        let context = Headless::new(Backend::Auto).unwrap();
        let sources = Sources::default().with_edit(file, old, new);
        run(&context, sources).expect_err(new).to_string()
    }

    #[test]
    fn this_driver_is_right() {
        let context = Headless::new(Backend::Auto).unwrap();
        let checked = run(&context, Sources::default()).unwrap_or_else(|error| panic!("{error}"));
        assert!(checked.patches_px > 0.0 && checked.mesh > 0.0, "{checked:?}");
        assert_eq!(checked.trimmed, 144 * 144);
    }

    #[test]
    fn drivers_that_are_wrong_are_told_by_what_they_draw() {
        for (file, old, new, words) in [
            ("exact/surface.tese", "passTessCoord = t;", "passTessCoord = t * 0.99;", "trims"),
            ("exact/surface.tese", "placeOfPatch.y;", "placeOfPatch.y + 1u;", "exact"),
            ("exact/patch.glsl", "float(binomial) *", "float(i == 1 ? 2 : binomial) *", "exact"),
            ("thesis/surface.vert", "- firstPoint)", ")", "thesis"),
            // Some drivers restart the numbering of patches within a draw.
            (
                "thesis/surface.vert",
                "gl_VertexID - firstPoint",
                "(gl_VertexID - firstPoint) % 48",
                "thesis",
            ),
            ("triangles/triangle.vert", "gl_VertexID / 3", "gl_VertexID / 3 % 64", "meshes"),
            ("triangles/triangle.tese", "edges + middle", "edges - middle", "meshes"),
            (
                "common/trim.glsl",
                "uv = clamp(uv, 0.0, 0.99999994);",
                "uv = clamp(uv + 2e-3, 0.0, 0.99999994);",
                "trims",
            ),
            ("common/aov.frag", "-position.z", "sqrt(-1.0 - position.x * position.x)", "no sense"),
        ] {
            let error = error(file, old, new);
            assert!(error.starts_with("WRONG on ") && error.contains(words), "{file}: {error}");
        }
    }
}
