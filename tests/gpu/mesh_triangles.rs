//! Meshes in the tessellation stages: every vertex against the smooth surface in `f64`, and both sides of
//! every edge against each other.

use freeform_surface::inspect::measure::Random;
use freeform_surface::inspect::programs::Sources;
use freeform_surface::{
    Alpha, Camera, CreaseAngle, Frame, Image, Lens, Light, Mesh, Paint, Scene, Shading, Smoothing,
    TessLevel,
};
use glam::{DMat3, DMat4, DVec3, DVec4, EulerRot, dvec3, uvec2};

use crate::harness::meshes::{
    Distance, check_edges, creased, mesh, pieces, scene_of_mesh, to_clip, view, weights,
};
use crate::harness::patches::{at_level, count_drawn, scene_of, within};
use crate::harness::{Stage, backends};
use crate::harness::{load, root};

fn phong() -> Smoothing {
    Smoothing::Phong(Alpha::default())
}

/// A transform that rotates, stretches, shrinks and mirrors.
fn mirrored() -> DMat4 {
    DMat4::from_translation(dvec3(3.0, -1.0, 0.5))
        * DMat4::from_euler(EulerRot::XYZ, 0.4, 1.1, -0.7)
        * DMat4::from_scale(dvec3(-2.5, 2.0, 1.0))
}

/// Closed meshes, each with the maximum level of its tests.
fn closed() -> [(&'static str, Mesh, i64); 5] {
    [
        ("icosahedron", mesh("icosahedron"), 64),
        ("torus", mesh("torus"), 7),
        // Its edges and faces stay straight.
        ("creased cube", creased("cube", 60.0), 64),
        ("pawn", mesh("figure"), 7),
        ("creased pawn", creased("figure", 35.0), 3),
    ]
}

/// Fails unless all vertices of a frame lie on the surface and have its normals. Returns the number of
/// vertices.
fn check_vertices(name: &str, stage: &mut Stage, scene: &Scene) -> usize {
    let pieces = pieces(scene);
    let mut prepared = stage.prepared(scene);
    let frame = stage.frame(scene);
    let drawn = stage.triangles(&mut prepared, &frame);
    let (to_clip, view) = (to_clip(&frame), frame.camera.view);
    for vertex in &drawn {
        let (piece, place) = (&pieces[vertex.patch as usize], weights(vertex));
        let point = piece.point(place);
        let expected = view.transform_point3(point);
        let position = DVec4::from_array(vertex.position.map(f64::from));
        // A few units in the last place of values as large as the distance from the eye.
        let max = 5e-7 * expected.length();
        let off = expected.distance(position.truncate());
        assert!(off <= max && position.w == 1.0, "{name}: {vertex:?} is off by {off}");
        let clip = DVec4::from_array(vertex.clip.map(f64::from));
        let off = (to_clip * point.extend(1.0)).distance(clip);
        assert!(off <= 4.0 * max, "{name}: {vertex:?} is off by {off} in clip space");
        // The normals point inwards, as those of surfaces do.
        let expected = DMat3::from_mat4(view) * -piece.normal(place);
        let normal = DVec3::from_array(vertex.normal.map(f64::from));
        assert!((normal.length() - 1.0).abs() < 1e-5, "{name}: {vertex:?}");
        let degrees = normal.cross(expected).length().atan2(normal.dot(expected)).to_degrees();
        assert!(degrees <= 0.1, "{name}: the normal of {vertex:?} is {degrees} degrees off");
    }
    drawn.len()
}

/// Checks all methods, levels and places of the closed meshes.
fn check_all_vertices(stage: &mut Stage, smoothing: Smoothing) {
    for (name, mesh, finest) in closed() {
        for transform in [DMat4::IDENTITY, mirrored()] {
            for level in [1, 2, 3, 7, 32, 64].into_iter().filter(|level| *level <= finest) {
                let mut scene = scene_of_mesh(mesh.clone(), smoothing);
                scene.settings = at_level(level);
                scene.meshes[0].transform = transform;
                let name = format!("{name}, {smoothing:?}, level {level}, {transform}");
                let count = check_vertices(&name, stage, &scene);
                // The triangles form rings; their numbers at levels 1, 2 and 3 are known.
                let expected = match level {
                    1 => Some(1),
                    2 => Some(6),
                    3 => Some(13),
                    _ => None,
                };
                let triangles = mesh.triangles().len();
                let each = count / 3 / triangles;
                assert_eq!(count, 3 * triangles * each, "{name}");
                assert!(expected.is_none_or(|expected| expected == each), "{name}: {each}");
            }
        }
    }
}

#[test]
fn vertices_of_pn_triangles_are_those_of_the_surface() {
    check_all_vertices(&mut Stage::new(uvec2(160, 120)), Smoothing::Pn);
}

#[test]
fn vertices_of_phong_tessellation_are_those_of_the_surface() {
    check_all_vertices(&mut Stage::new(uvec2(160, 120)), phong());
    check_all_vertices(
        &mut Stage::new(uvec2(160, 120)),
        Smoothing::Phong(Alpha::new(0.3).unwrap()),
    );
}

#[test]
fn meshes_that_are_not_smoothed_stay_flat() {
    let mut stage = Stage::new(uvec2(160, 120));
    let mut scene = scene_of_mesh(mesh("torus"), Smoothing::None);
    scene.meshes[0].transform = mirrored();
    assert_eq!(check_vertices("flat", &mut stage, &scene), 3 * 256);
}

/// Fails unless the triangles of all closed meshes meet at their edges, with individual levels and with one
/// level for all.
fn check_all_edges(stage: &mut Stage, smoothing: Smoothing) {
    let mut random = Random(5);
    for (name, mesh, _) in closed() {
        let mut scene = scene_of_mesh(mesh, smoothing);
        scene.meshes[0].transform = mirrored();
        let mut prepared = stage.prepared(&scene);
        let pieces = pieces(&scene);
        for level in [1, 2, 3, 6, 7] {
            let frame = Frame { settings: at_level(level), ..stage.frame(&scene) };
            let drawn = stage.triangles(&mut prepared, &frame);
            let levels = check_edges(&format!("{name}, level {level}"), &pieces, &drawn);
            assert_eq!(levels.len(), pieces.len());
            assert!(levels.values().flatten().all(|edge| *edge == level as usize), "{name}");
        }
        let mut uneven = 0;
        for index in 0..24 {
            let distance =
                [Distance::Far, Distance::Near, Distance::Grazing, Distance::Inside][index % 4];
            scene.camera = Some(view(&pieces, &mut random, distance));
            let frame = Frame { settings: within(0.5), ..stage.frame(&scene) };
            let drawn = stage.triangles(&mut prepared, &frame);
            let levels = check_edges(&format!("{name}, view {index}"), &pieces, &drawn);
            uneven += levels.values().filter(|[a, b, c]| a != b || b != c).count();
        }
        let all_flat = name == "creased cube";
        assert!(all_flat || uneven > 100, "{name}: {uneven} have edges of different levels");
    }
}

#[test]
fn edges_of_pn_triangles_meet_bit_for_bit() {
    check_all_edges(&mut Stage::new(uvec2(480, 300)), Smoothing::Pn);
}

#[test]
fn edges_of_phong_tessellation_meet_bit_for_bit() {
    check_all_edges(&mut Stage::new(uvec2(480, 300)), phong());
}

/// Whether something panics, without printing the message.
fn fails(check: impl FnOnce() + std::panic::UnwindSafe) -> bool {
    std::panic::catch_unwind(check).is_err()
}

#[test]
fn shaders_that_are_a_little_wrong_are_noticed() {
    // The edit is found and the shaders compile, or the test fails here.
    let stage = |file: &str, old: &str, new: &str, smoothing: Smoothing| {
        let sources = Sources::default().with_edit(file, old, new);
        let mut stage = Stage::with_sources(backends()[0], uvec2(160, 120), sources);
        let scene = scene_of_mesh(mesh("torus"), smoothing);
        let mut prepared = stage.prepared(&scene);
        let frame = stage.frame(&scene);
        stage.triangles(&mut prepared, &frame);
        std::panic::AssertUnwindSafe(stage)
    };
    for (file, old, new, smoothing) in [
        ("triangles/triangle.tesc", "moved / 4.0", "moved / 4.1", Smoothing::Pn),
        ("triangles/triangle.tesc", "sum - 2.0", "sum - 1.9", Smoothing::Pn),
        ("triangles/triangle.tesc", "-0.5 * alpha", "-0.51 * alpha", phong()),
        ("triangles/triangle.tese", "passNormal = -passNormal;", "", phong()),
    ] {
        let mut stage = stage(file, old, new, smoothing);
        let check = move || check_all_vertices(&mut stage, smoothing);
        assert!(fails(check), "{old} became {new:?}");
    }
    for (file, old, new) in [
        // Each side would have places of its own.
        ("common/levels.glsl", "? levels - level :", "? levels - 0.99 * level :"),
        ("triangles/triangle.tese", ">> 8 * edge & 0xffu", ">> 24"),
    ] {
        let mut stage = stage(file, old, new, Smoothing::Pn);
        let check = move || check_all_edges(&mut stage, Smoothing::Pn);
        assert!(fails(check), "{old} became {new:?}");
    }
}

/// A camera that looks straight at the square from (−1, −1) to (1, 1) in z = 0.
fn in_front() -> Camera {
    Camera::new(DVec3::Z * 5.0, DVec3::ZERO, DVec3::Y, Lens::Orthographic { height: 2.0 }).unwrap()
}

#[test]
fn texture_coordinates_are_interpolated_linearly() {
    const SIDE: u32 = 64;
    let text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                f 1/1 2/2 3/3 4/4\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.obj");
    std::fs::write(&path, text).unwrap();
    let square = Mesh::load_obj(&path, CreaseAngle::NONE).unwrap();
    let texture = Image::from_fn(SIDE, SIDE, |x, y| {
        image::Rgba([(4 * x + 2) as u8, (4 * y + 2) as u8, 0, 255])
    });
    let mut stage = Stage::new(uvec2(SIDE, SIDE));
    for smoothing in [Smoothing::None, Smoothing::Pn, phong()] {
        let mut scene = scene_of_mesh(square.clone(), smoothing);
        scene.camera = Some(in_front());
        scene.meshes[0].paint = Paint::Texture(std::sync::Arc::new(texture.clone()));
        scene.meshes[0].shading = Shading::Unlit;
        scene.meshes[0].level = Some(TessLevel::new(5).unwrap());
        let mut prepared = stage.prepared(&scene);
        let frame = stage.frame(&scene);
        let picture = stage.picture(&mut prepared, &frame);
        for (x, y, pixel) in picture.enumerate_pixels() {
            // The first row of a texture is v = 1, that of a picture the upper one.
            let expected = texture.get_pixel(x, y);
            let off = (0..4).map(|c| pixel.0[c].abs_diff(expected.0[c])).max().unwrap();
            assert!(off <= 1, "{smoothing:?}: {x}, {y}: {pixel:?} and {expected:?}");
        }
    }
}

#[test]
fn light_falls_on_the_outside_whatever_the_transform() {
    // From above, under the thesis' upper lamp: a ball is brightest at the top, and a mirrored one is the same.
    let mut stage = Stage::new(uvec2(100, 100));
    let mut pictures = Vec::new();
    for x in [1.0, -1.0] {
        let mut scene = scene_of_mesh(mesh("icosahedron"), Smoothing::Pn);
        scene.meshes[0].transform = DMat4::from_scale(dvec3(x, 1.0, 1.0));
        scene.settings.light = Light::Thesis;
        let lens = Lens::Orthographic { height: 2.2 };
        scene.camera = Some(Camera::new(DVec3::Y * 5.0, DVec3::ZERO, DVec3::Z, lens).unwrap());
        let mut prepared = stage.prepared(&scene);
        let frame = stage.frame(&scene);
        pictures.push(stage.picture(&mut prepared, &frame));
    }
    let bright = |picture: &Image, x: u32| picture.get_pixel(x, 50).0[0];
    for picture in &pictures {
        let [middle, side] = [bright(picture, 40), bright(picture, 10)];
        assert!(middle > 200 && side < middle - 40 && side > 40, "{middle} and {side}");
    }
    // The icosahedron is its own mirror image.
    crate::harness::assert_same("mirrored", &pictures[0], &pictures[1], &[], 2);
}

#[test]
fn meshes_and_surfaces_share_a_scene() {
    let mut stage = Stage::new(uvec2(200, 150));
    let scene = load(&root().join("resources/surfaces/teapot.bpt"));
    let mut both = scene_of_mesh(mesh("torus"), Smoothing::Pn);
    // The mesh surrounds the teapot.
    both.meshes[0].transform = DMat4::from_rotation_x(1.6) * DMat4::from_scale(DVec3::splat(1.8));
    both.surfaces = scene.surfaces;
    both.camera = Some(both.framed(stage.aspect()));
    both.meshes.push(both.meshes[0].clone());
    both.meshes[1].transform = DMat4::from_translation(DVec3::X * 1e3);
    let mut prepared = stage.prepared(&both);
    let frame = stage.frame(&both);
    let picture = stage.picture(&mut prepared, &frame);
    let stats = prepared.stats();
    assert!(count_drawn(&picture) > 2_000);
    // The second mesh is out of view, the first one is not.
    assert_eq!((stats.patches, stats.culled), (32 + 2 * 256, 256));
    assert!(stats.draws > 1 && stats.unmet.is_none(), "{stats:?}");
    let drawn = stage.triangles(&mut prepared, &frame);
    assert_eq!(drawn.len() as u64, 3 * stats.triangles);
    let numbers = drawn.iter().map(|vertex| vertex.patch);
    assert_eq!(numbers.clone().max(), Some(32 + 255));
    assert!((0..32 + 256).all(|patch| numbers.clone().any(|number| number == patch)));
    // The numbers in pixels count through surfaces and meshes, and the normals show which side is outside.
    let aovs = stage.aovs(&mut prepared, &frame);
    let eye = frame.camera.view.inverse().w_axis.truncate();
    let mut pixels = 0;
    for ((uv, normal), position) in aovs.uv.iter().zip(&aovs.normal).zip(&aovs.position) {
        if uv[3] == 0.0 || uv[2] < 32.0 {
            continue;
        }
        let to = |[x, y, z, _]: [f32; 4]| DVec3::from_array([x, y, z].map(f64::from));
        assert!((uv[0] + uv[1]) <= 1.0001 && uv[2] < (32 + 256) as f32, "{uv:?}");
        // Away from the silhouette, the visible side of a closed mesh is its outside.
        let towards = to(*normal).dot((eye - to(*position)).normalize());
        assert!(towards > -0.2, "{towards}");
        pixels += 1;
    }
    assert!(pixels > 500, "{pixels}");
}

#[test]
fn meshes_out_of_sight_are_culled_and_others_are_not_missed() {
    let mut stage = Stage::new(uvec2(160, 120));
    let mut random = Random(9);
    let mut scene = scene_of_mesh(mesh("figure"), Smoothing::Pn);
    let pieces = pieces(&scene);
    let mut prepared = stage.prepared(&scene);
    let mut culled = 0;
    for _ in 0..40 {
        scene.camera = Some(view(&pieces, &mut random, Distance::Near));
        let frame = stage.frame(&scene);
        stage.picture(&mut prepared, &frame);
        culled += prepared.stats().culled;
        let drawn = stage.triangles(&mut prepared, &frame);
        let to_clip = to_clip(&frame);
        for (number, piece) in (0..).zip(&pieces) {
            let seen = crate::harness::meshes::GRID.iter().any(|place| {
                let clip = to_clip * piece.point(*place).extend(1.0);
                clip.truncate().abs().max_element() < clip.w
            });
            let is_drawn = drawn.iter().any(|vertex| vertex.patch == number);
            assert!(is_drawn || !seen, "triangle {number} is missing");
        }
    }
    assert!(culled > 40 * 50, "{culled}");
    // Behind the eye there is nothing to draw.
    let lens = Lens::Perspective { fov_y_radians: 0.8 };
    let away = Camera::new(DVec3::Z * 5.0, DVec3::Z * 9.0, DVec3::Y, lens).unwrap();
    scene.camera = Some(away);
    let frame = stage.frame(&scene);
    assert_eq!(count_drawn(&stage.picture(&mut prepared, &frame)), 0);
    let stats = prepared.stats();
    assert_eq!((stats.culled, stats.draws, stats.triangles), (260, 0, 0));
}

#[test]
fn a_level_of_its_own_wins_and_lines_show_it() {
    let mut stage = Stage::new(uvec2(160, 120));
    let mut scene = scene_of_mesh(mesh("icosahedron"), Smoothing::Pn);
    scene.settings = at_level(9);
    scene.meshes[0].level = Some(TessLevel::new(2).unwrap());
    let mut prepared = stage.prepared(&scene);
    let mut frame = stage.frame(&scene);
    let filled = stage.picture(&mut prepared, &frame);
    assert_eq!(prepared.stats().triangles, 20 * 6);
    frame.settings.wireframe = true;
    let lines = stage.picture(&mut prepared, &frame);
    let [filled, lines] = [filled, lines].map(|picture| count_drawn(&picture));
    assert!(lines > 500 && 4 * lines < 3 * filled, "{lines} of {filled}");
}

#[test]
fn empty_scenes_have_no_mesh() {
    let mut stage = Stage::new(uvec2(16, 16));
    let scene = Scene { camera: Some(in_front()), ..scene_of(Vec::new()) };
    let mut prepared = stage.prepared(&scene);
    let frame = stage.frame(&scene);
    assert_eq!(count_drawn(&stage.picture(&mut prepared, &frame)), 0);
    assert_eq!(prepared.stats().patches, 0);
}
