//! The ported class in a context of the caller's.

use std::rc::Rc;

use freeform_surface::inspect::programs::Sources;
use freeform_surface::inspect::reference;
use freeform_surface::{
    Backend, Circle, Degree, Ellipse, Frame, Framebuffer, FreeFormSurface, Image, Method,
    PreparedScene, Rect, RenderSettings, Renderer, Scene, Segment, Shading, Surface, TessLevel,
    Tessellation, Texture, TrimLoop,
};
use glam::{DMat4, DVec2, DVec3, DVec4, UVec2, dvec2, dvec3};

use crate::harness::Stage;
use crate::harness::{
    BAND_PX, Checked, assert_same, backends, difference, draw, excuse_speckles, render,
};

const SIZE: UVec2 = UVec2::new(160, 120);
const METHODS: [Method; 2] = [Method::Thesis, Method::Exact];

/// A stage with a frame that sees the default surface from above.
struct FromAbove {
    stage: Stage,
    frame: Frame,
}

impl FromAbove {
    fn new(backend: Backend, method: Method) -> Self {
        let scene = Scene::from_toml(
            "camera = { eye = [0, 2, 0], target = [0, 0, 0], up = [0, 0, -1], orthographic_height = 1.1 }
             surface = [{ control_points = \"default\" }]",
            "above.toml".as_ref(),
        )
        .unwrap();
        let settings = RenderSettings {
            background: [0.0; 4],
            method,
            tessellation: Tessellation::Level(TessLevel::new(4).unwrap()),
            ..RenderSettings::default()
        };
        Self {
            stage: Stage::with_sources(backend, SIZE, Sources::default()),
            frame: Frame::new(scene.projection(SIZE.x, SIZE.y), SIZE, settings),
        }
    }

    fn renderer(&self) -> &Renderer {
        self.stage.renderer()
    }

    fn picture(&mut self, surface: &mut FreeFormSurface) -> Image {
        self.stage.picture_of_surface(surface, &self.frame)
    }

    /// Whether the pixel at (u, v) of the flat default surface is drawn.
    fn shows(&mut self, surface: &mut FreeFormSurface, uv: DVec2) -> bool {
        let picture = self.picture(surface);
        let at = (uv - 0.5) / 1.1 * f64::from(SIZE.y);
        let x = (f64::from(SIZE.x) / 2.0 + at.x) as u32;
        let y = (f64::from(SIZE.y) / 2.0 - at.y) as u32;
        picture.get_pixel(x, y).0[3] != 0
    }
}

fn lens(half_width: f64, half_height: f64) -> [DVec2; 4] {
    [
        dvec2(0.5 - half_width, 0.5),
        dvec2(0.5, 0.5 + 2.0 * half_height),
        dvec2(0.5 + half_width, 0.5),
        dvec2(0.5, 0.5 - 2.0 * half_height),
    ]
}

fn pillow(half_width: f64, half_height: f64) -> [DVec2; 6] {
    let at = |x: f64, y: f64| dvec2(0.5 + x * half_width, 0.5 + y * half_height);
    [at(-1.0, 0.0), at(-0.8, 1.3), at(0.8, 1.3), at(1.0, 0.0), at(-0.8, -1.3), at(0.8, -1.3)]
}

#[test]
fn every_trimming_call_cuts_and_every_switch_brings_back() {
    for (backend, method) in
        backends().into_iter().flat_map(|backend| METHODS.map(|m| (backend, m)))
    {
        let mut stage = FromAbove::new(backend, method);
        let mut surface = FreeFormSurface::new(stage.renderer()).unwrap();
        let middle = dvec2(0.5, 0.5);
        assert!(stage.shows(&mut surface, middle));

        surface.circular_trimming(0.2, middle).unwrap();
        assert!(!stage.shows(&mut surface, middle));
        assert!(stage.shows(&mut surface, dvec2(0.75, 0.5)));
        surface.disable_circular_trimming();
        assert!(stage.shows(&mut surface, middle));
        surface.enable_circular_trimming();
        assert!(!stage.shows(&mut surface, middle));

        let corner = dvec2(0.15, 0.15);
        surface.interval_trimming(dvec2(0.1, 0.2), dvec2(0.1, 0.2)).unwrap();
        assert!(!stage.shows(&mut surface, corner) && !stage.shows(&mut surface, middle));
        surface.disable_interval_trimming();
        assert!(stage.shows(&mut surface, corner));
        surface.enable_interval_trimming();

        let right = dvec2(0.85, 0.5);
        surface.ellipse_trimming(0.1, 0.3, right).unwrap();
        assert!(!stage.shows(&mut surface, right) && !stage.shows(&mut surface, dvec2(0.85, 0.75)));
        surface.disable_ellipse_trimming();
        assert!(stage.shows(&mut surface, right));
        surface.enable_ellipse_trimming();

        surface.clear_trims();
        assert!(stage.shows(&mut surface, middle) && stage.shows(&mut surface, right));

        let ring = dvec2(0.5, 0.74);
        let [p0, p1, p2, p3] = lens(0.4, 0.3);
        surface.set_bezier_curve_trimming(p0, p1, p2, p3).unwrap();
        assert!(!stage.shows(&mut surface, middle) && !stage.shows(&mut surface, ring));
        surface.disable_bezier_curve_trimming();
        assert!(stage.shows(&mut surface, middle));
        surface.enable_bezier_curve_trimming();

        let nested: Vec<DVec2> = lens(0.4, 0.3).into_iter().chain(lens(0.2, 0.2)).collect();
        surface.set_nested_bezier_curve_trimming(nested.try_into().unwrap()).unwrap();
        assert!(stage.shows(&mut surface, middle) && !stage.shows(&mut surface, dvec2(0.2, 0.52)));

        surface.set_cubic_bezier_curve_trimming(pillow(0.4, 0.3)).unwrap();
        assert!(!stage.shows(&mut surface, middle) && !stage.shows(&mut surface, dvec2(0.2, 0.52)));

        let nested: Vec<DVec2> = pillow(0.4, 0.3).into_iter().chain(pillow(0.2, 0.2)).collect();
        surface.set_nested_cubic_bezier_curve_trimming(nested.try_into().unwrap()).unwrap();
        assert!(stage.shows(&mut surface, middle) && !stage.shows(&mut surface, dvec2(0.2, 0.52)));
    }
}

#[test]
fn many_trims_of_every_kind_cut_at_once() {
    METHODS.into_iter().for_each(many_trims_cut_at_once);
}

fn many_trims_cut_at_once(method: Method) {
    let mut stage = FromAbove::new(backends()[0], method);
    let mut surface = FreeFormSurface::new(stage.renderer()).unwrap();
    surface.set_shading(Shading::Unlit);
    let mut scene = Scene::from_toml(
        "camera = { eye = [0, 2, 0], target = [0, 0, 0], up = [0, 0, -1], orthographic_height = 1.1 }
         render = { background = [0, 0, 0, 0], level = 4 }
         surface = [{ control_points = \"default\", shading = \"flat\" }]",
        "above.toml".as_ref(),
    )
    .unwrap();
    for i in 0..8 {
        let u = 0.08 + 0.12 * f64::from(i);
        surface.add_circle(Circle::new(dvec2(u, 0.1), 0.04).unwrap()).unwrap();
        let interval = Rect::new(dvec2(u - 0.03, u + 0.03), dvec2(0.2, 0.3)).unwrap();
        surface.add_rect(interval).unwrap();
        surface.add_ellipse(Ellipse::new(dvec2(u, 0.4), dvec2(0.02, 0.06)).unwrap()).unwrap();
    }
    let mut compare = |name: &str, surface: &mut FreeFormSurface| {
        scene.surfaces[0].trims = surface.trims().clone();
        let picture = reference::render(&scene, SIZE, method).unwrap();
        let actual = stage.picture(surface);
        let mut left_out = picture.edge_band(BAND_PX);
        if method == Method::Thesis {
            let excused = excuse_speckles(&scene, &picture, &actual, &mut left_out, 2);
            assert!(excused <= 4, "{name}: {excused} pixels only explained by speckles");
        }
        assert_same(&format!("{name}-{method:?}"), &picture.image, &actual, &left_out, 2);
    };
    // Without loops there are no speckles, so no pixel is excused.
    compare("many-shapes", &mut surface);
    for i in 0..3 {
        let shift = dvec2(0.32 * f64::from(i) - 0.32, 0.22);
        let [a, b, c, d] = lens(0.12, 0.1).map(|p| p + shift);
        let lens = vec![Segment::Quadratic([a, b, c]), Segment::Quadratic([c, d, a])];
        surface.add_trim_loop(TrimLoop::new(lens).unwrap()).unwrap();
    }
    compare("many-shapes-and-loops", &mut surface);
}

#[test]
fn moving_a_point_moves_the_surface_and_a_bad_point_leaves_it() {
    let mut stage = FromAbove::new(backends()[0], Method::Exact);
    let mut surface = FreeFormSurface::new(stage.renderer()).unwrap();
    let corner = dvec2(0.02, 0.02);
    assert!(stage.shows(&mut surface, corner));
    surface.set_specific_control_point(dvec3(0.0, 0.0, 0.0), 0).unwrap();
    assert!(!stage.shows(&mut surface, corner));
    let far_corner = dvec2(0.98, 0.98);
    assert!(stage.shows(&mut surface, far_corner));
    surface.set_specific_control_point(dvec3(0.0, 0.0, 0.0), 15).unwrap();
    assert!(!stage.shows(&mut surface, far_corner));
    let before = stage.picture(&mut surface);

    for (result, words) in [
        (surface.set_specific_control_point(DVec3::ZERO, 16), ["index", "16", "0 to 15"]),
        (surface.set_specific_control_point(DVec3::NAN, 3), ["control point 3", "NaN", "finite"]),
        (
            surface.set_control_point(DVec4::new(0.0, 0.0, 0.0, -2.0), 3),
            ["weight", "-2", "above 0"],
        ),
        (surface.circular_trimming(-1.0, DVec2::ZERO), ["circle radius", "-1", "0 or above"]),
        (surface.circular_trimming(f64::NAN, DVec2::ZERO), ["circle radius", "NaN", "finite"]),
        (
            surface.ellipse_trimming(0.1, f64::INFINITY, DVec2::ZERO),
            ["ellipse radius", "inf", "finite"],
        ),
        (surface.interval_trimming(dvec2(1.0, 0.0), DVec2::ZERO), ["interval u", "[1, 0]", "≤"]),
        (surface.set_model_matrix(DMat4::NAN), ["model matrix", "NaN", "finite"]),
        (
            surface.set_bezier_curve_trimming(DVec2::NAN, DVec2::ZERO, DVec2::ONE, DVec2::ZERO),
            ["segment 0", "NaN", "finite"],
        ),
    ] {
        let text = result.unwrap_err().to_string();
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    }
    // Inside the box of the outer loop's control points, but not inside the loop.
    let [a, b, c, d] = lens(0.05, 0.05).map(|p| p + dvec2(-0.24, 0.38));
    let beside: Vec<DVec2> = lens(0.3, 0.44).into_iter().chain([a, b, c, d]).collect();
    assert!(surface.set_nested_bezier_curve_trimming(beside.try_into().unwrap()).is_err());
    let bare = Circle { center: DVec2::ZERO, radius: f64::NAN };
    assert!(surface.add_circle(bare).unwrap_err().to_string().contains("circle radius"));
    let projective = DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::Z, DVec4::ONE * 0.5);
    assert!(surface.set_model_matrix(projective).unwrap_err().to_string().contains("last row"));
    let mut plain = Surface::new(Degree::CUBIC, surface.control_points().to_vec()).unwrap();
    plain.trims.circles.push(bare);
    assert!(FreeFormSurface::from_surface(stage.renderer(), plain).is_err());
    // The matrix of a mesh is refused too.
    let cube = crate::harness::root().join("resources/meshes/cube.obj");
    let mut scene = Scene::load(&cube).unwrap();
    scene.meshes[0].transform = projective;
    let error = PreparedScene::new(stage.renderer(), &scene).unwrap_err().to_string();
    assert!(error.contains("last row of the model matrix"), "{error}");
    let outside: Vec<DVec2> = lens(0.2, 0.1).into_iter().chain(lens(0.3, 0.1)).collect();
    let text = surface.set_nested_bezier_curve_trimming(outside.try_into().unwrap()).unwrap_err();
    assert!(text.to_string().contains("inner loop"), "{text}");
    let line = TrimLoop::new(vec![
        Segment::Line([DVec2::ZERO, DVec2::ONE]),
        Segment::Line([DVec2::ONE, DVec2::ZERO]),
    ]);
    let mut with_line = Surface::new(Degree::CUBIC, surface.control_points().to_vec()).unwrap();
    with_line.trims.loops.push(line.unwrap());
    let mut with_line = FreeFormSurface::from_surface(stage.renderer(), with_line).unwrap();
    assert!(with_line.render(stage.stage.renderer_mut(), &stage.frame).is_ok());
    let mut frame = stage.frame;
    frame.settings.method = Method::Thesis;
    let text = with_line.render(stage.stage.renderer_mut(), &frame).unwrap_err().to_string();
    assert!(text.contains("loop 0") && text.contains("line, line"), "{text}");
    with_line.clear_trims();
    assert!(with_line.render(stage.stage.renderer_mut(), &frame).is_ok());
    for count in [0, 15, 17, 26] {
        let points = vec![DVec3::ZERO; count];
        let text = FreeFormSurface::with_control_points(stage.renderer(), &points).unwrap_err();
        assert!(text.to_string().contains("16 (4×4) or 25 (5×5)"), "{text}");
    }
    assert_eq!(stage.picture(&mut surface), before);
}

#[test]
fn the_model_matrix_the_texture_and_25_points_are_used() {
    let mut stage = FromAbove::new(backends()[0], Method::Exact);
    let points: Vec<DVec3> = (0..25)
        .map(|i| dvec3(f64::from(i % 5) / 4.0 - 0.5, 0.0, 0.5 - f64::from(i / 5) / 4.0))
        .collect();
    let mut surface = FreeFormSurface::with_control_points(stage.renderer(), &points).unwrap();
    surface.set_shading(Shading::Unlit);
    let image = Image::from_fn(2, 2, |x, y| image::Rgba([255 * x as u8, 255 * y as u8, 0, 255]));
    surface.set_texture(Rc::new(Texture::new(stage.renderer().gl(), "test", &image).unwrap()));
    let picture = stage.picture(&mut surface);
    // The picture's first row is v = 1, its first column u = 0.
    assert_eq!(picture.get_pixel(40, 16).0, [0, 0, 0, 255]);
    assert_eq!(picture.get_pixel(120, 16).0, [255, 0, 0, 255]);
    assert_eq!(picture.get_pixel(40, 104).0, [0, 255, 0, 255]);
    surface.set_model_matrix(DMat4::from_translation(dvec3(5.0, 0.0, 0.0))).unwrap();
    assert!(stage.picture(&mut surface).pixels().all(|pixel| pixel.0 == [0; 4]));
}

#[test]
fn rational_patches_match_the_reference() {
    // Quarter cylinders of both degrees, in both programs.
    let s = std::f64::consts::FRAC_1_SQRT_2;
    let raise = |points: &[DVec4]| -> Vec<DVec4> {
        // Degree elevation in homogeneous coordinates.
        let n = points.len();
        let at = |i: usize| points[i];
        let mut raised = vec![at(0)];
        for i in 1..n {
            let a = i as f64 / n as f64;
            raised.push(at(i - 1) * a + at(i) * (1.0 - a));
        }
        raised.push(at(n - 1));
        raised
    };
    let quadratic = [(1.0, 0.0, 1.0), (1.0, 1.0, s), (0.0, 1.0, 1.0)]
        .map(|(x, y, w)| DVec4::new(x * w, y * w, 0.0, w));
    let cubic = raise(&quadratic);
    let quartic = raise(&cubic);
    for (degree, arc) in [(Degree::CUBIC, cubic), (Degree::QUARTIC, quartic)] {
        for shading in [Shading::Unlit, Shading::Normals, Shading::Phong] {
            let side = degree.columns();
            let points = (0..degree.points())
                .map(|i| {
                    let point = arc[i % side];
                    let z = -((i / side) as f64) / (side - 1) as f64;
                    (point.truncate() / point.w + DVec3::Z * z).extend(point.w)
                })
                .collect();
            let mut surface = Surface::new(degree, points).unwrap();
            surface.shading = shading;
            let mut scene = Scene::listing16();
            scene.surfaces = vec![surface];
            for method in METHODS {
                scene.settings.method = method;
                let picture = reference::render(&scene, SIZE, method).unwrap();
                let actual = render(&scene, SIZE, backends()[0]);
                let name = format!("rational-{degree:?}-{shading:?}-{method:?}");
                assert_same(&name, &picture.image, &actual, &picture.edge_band(1.5), 2);
                let background = [51, 51, 64];
                let drawn =
                    picture.image.pixels().filter(|pixel| pixel.0[..3] != background).count();
                assert!(drawn > 2000, "{name}: {drawn}");
            }
        }
    }
}

#[test]
fn the_teapot_matches_the_reference() {
    let mut scene =
        crate::harness::load(&crate::harness::root().join("resources/surfaces/teapot.bpt"));
    // The reference cuts patches at one level.
    scene.settings.tessellation = Tessellation::Level(TessLevel::default());
    for method in METHODS {
        scene.settings.method = method;
        let picture = reference::render(&scene, SIZE, method).unwrap();
        let left_out = picture.edge_band(BAND_PX);
        for backend in backends() {
            let actual = render(&scene, SIZE, backend);
            let name = format!("teapot-{method:?}-{backend}");
            assert_same(&name, &picture.image, &actual, &left_out, 2);
        }
    }
}

/// Mesa's software driver numbers vertices with 16 bits: 64 patches at level 64 in one draw would be drawn
/// wrongly.
#[test]
fn sixty_four_patches_at_level_64_equal_the_patches_one_by_one() {
    let mut points = Vec::new();
    for patch in 0..64 {
        let corner = dvec2(f64::from(patch % 8), f64::from(patch / 8));
        for i in 0..16 {
            let place = corner + dvec2(f64::from(i % 4), f64::from(i / 4)) / 3.0;
            let height = (place.x * 1.1).sin() * (place.y * 0.9).cos();
            points.push(DVec4::new(place.x - 4.0, height, 4.0 - place.y, 1.0));
        }
    }
    METHODS.into_iter().for_each(|method| sixty_four_patches(&points, method));
}

fn sixty_four_patches(points: &[DVec4], method: Method) {
    let mut scene = Scene::listing16();
    scene.settings.method = method;
    scene.settings.tessellation = Tessellation::Level(TessLevel::MAX);
    scene.surfaces = vec![Surface::new(Degree::CUBIC, points.to_vec()).unwrap()];
    let together = render(&scene, SIZE, backends()[0]);

    // The same camera and clip planes, but one surface for each patch.
    scene.surfaces = points
        .chunks(16)
        .map(|patch| Surface::new(Degree::CUBIC, patch.to_vec()).unwrap())
        .collect();
    let context = Checked::new(backends()[0]);
    let target = Framebuffer::new(context.gl(), SIZE.x, SIZE.y).unwrap();
    let mut renderer = Renderer::new(context.gl()).unwrap();
    let mut prepared = PreparedScene::new(&renderer, &scene).unwrap();
    draw(&scene, &mut prepared, &mut renderer, &target);
    let apart = target.read();
    assert_eq!(difference(&together, &apart, &[], 0).unwrap().wrong, 0);

    // Both pictures are also correct.
    let picture = reference::render(&scene, SIZE, method).unwrap();
    assert_same(
        &format!("64-patches-{method:?}"),
        &picture.image,
        &together,
        &picture.edge_band(1.5),
        2,
    );
}

#[test]
fn a_surface_takes_any_grid_of_points() {
    let mut above = FromAbove::new(backends()[0], Method::Exact);
    let thesis = RenderSettings { method: Method::Thesis, ..above.frame.settings };
    for (columns, rows) in [(2, 2), (3, 2), (2, 7), (16, 16)] {
        let at = |i: usize, count: usize| i as f64 / (count - 1) as f64 - 0.5;
        let points: Vec<DVec3> = (0..columns * rows)
            .map(|i| dvec3(at(i % columns, columns), 0.0, -at(i / columns, rows)))
            .collect();
        let renderer = above.renderer();
        let mut surface = FreeFormSurface::with_grid(renderer, columns, rows, &points).unwrap();
        assert_eq!(surface.degree(), Degree::new(columns - 1, rows - 1).unwrap());
        let error = FreeFormSurface::with_grid(renderer, columns, rows, &points[1..]).unwrap_err();
        let expected = format!("{columns} along u times {rows} along v");
        assert!(error.to_string().contains(&expected), "{error}");
        let error = surface.prepare(renderer, &thesis).unwrap_err().to_string();
        assert!(error.contains("(3, 3) or (4, 4)"), "{error}");

        // The last control point is a corner of the patch.
        let corner = dvec2(0.98, 0.98);
        assert!(above.shows(&mut surface, corner) && above.shows(&mut surface, dvec2(0.5, 0.5)));
        surface.set_specific_control_point(dvec3(0.2, 0.0, -0.2), columns * rows - 1).unwrap();
        assert!(!above.shows(&mut surface, corner) && above.shows(&mut surface, dvec2(0.3, 0.3)));
    }
    let renderer = above.renderer();
    for (columns, rows) in [(1, 4), (4, 17), (0, 0)] {
        let error = FreeFormSurface::with_grid(renderer, columns, rows, &[]).unwrap_err();
        assert!(error.to_string().contains("1 to 15"), "{error}");
    }
}
