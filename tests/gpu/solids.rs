//! Faces of closed solids that face away are not drawn where the solid is seen from outside, and nobody sees it.

use freeform_surface::inspect::measure::random_view;
use freeform_surface::inspect::programs::Sources;
use freeform_surface::{Aovs, Camera, FrameStats, Lens, Rect, Scene, Surface};
use glam::{DMat4, DVec2, DVec3, Vec3, dvec3, uvec2};

use crate::harness::patches::within;
use crate::harness::{Stage, backends, load, render, render_with, root};

fn own(name: &str) -> Scene {
    let scene = load(&root().join(format!("resources/models/{name}.ffm")));
    Scene { settings: within(0.5), ..scene }
}

/// The same scene, in which no face is known to enclose anything.
fn open(scene: &Scene) -> Scene {
    let mut open = scene.clone();
    for model in &mut open.models {
        model.outsides = vec![None; model.outsides.len()].into();
    }
    open
}

fn draw(stage: &mut Stage, scene: &Scene) -> (Aovs, FrameStats) {
    let mut prepared = stage.prepared(scene);
    let frame = stage.frame(scene);
    let aovs = stage.aovs(&mut prepared, &frame);
    (aovs, prepared.stats())
}

/// Fails unless all pixels of a scene are what they are if every face is drawn.
fn check_is_whole(stage: &mut Stage, name: &str, scene: &Scene) {
    let (aovs, stats) = draw(stage, scene);
    let (expected, of_all) = draw(stage, &open(scene));
    assert_eq!(stats, of_all, "{name}");
    assert!(aovs.depth == expected.depth && aovs.face == expected.face, "{name}");
}

#[test]
fn what_faces_away_is_left_out_and_not_missed() {
    let mut stage = Stage::new(uvec2(480, 300));
    for name in ["assembly", "blade", "bracket", "flange"] {
        let mut culled = 0;
        for index in 0..6 {
            let mut scene = own(name);
            scene.camera = Some(random_view(&scene, 4, index, stage.aspect()));
            let (aovs, stats) = draw(&mut stage, &scene);
            let (expected, of_all) = draw(&mut stage, &open(&scene));
            culled += stats.culled - of_all.culled;
            assert!(stats.triangles <= of_all.triangles, "{name} {index}");
            // Beside a silhouette, within the tolerance, a face may be seen that faces away.
            let view = stage.projection(&scene).view;
            let mut beside = 0;
            for pixel in 0..aovs.depth.len() {
                // Where a neighbour is left out, an edge may have fewer vertices, within the tolerance.
                let [depth, other] = [&aovs, &expected].map(|aovs| aovs.depth[pixel][0]);
                let is_near = (depth - other).abs() <= 1e-3 * other.abs();
                if aovs.face[pixel] == expected.face[pixel] && is_near {
                    continue;
                }
                let place = aovs_place(&expected, pixel);
                let [face, ..] = expected.face[pixel];
                let model = &scene.models[0];
                let sign = model.outsides[face as usize].unwrap().sign as f32;
                let eye = view.inverse().transform_point3(DVec3::ZERO).as_vec3();
                let outwards = sign * placed_normal(&scene, &expected, pixel);
                assert!(
                    outwards.dot(place - eye) > -0.1 * (place - eye).length(),
                    "{name} {index}: pixel {pixel}: {:?} at {:?}, not face {face}, which is seen, at {:?}",
                    aovs.face[pixel],
                    aovs.depth[pixel],
                    expected.depth[pixel]
                );
                beside += 1;
            }
            assert!(beside <= 30, "{name} {index}: {beside} pixels");
        }
        assert!(culled > 0, "{name}: all faces were drawn");
    }
}

fn aovs_place(aovs: &Aovs, pixel: usize) -> Vec3 {
    Vec3::from_slice(&aovs.position[pixel][..3])
}

/// The unit normal ∂u × ∂v of a pixel in the space of the world, on the side that it has in the model.
fn placed_normal(scene: &Scene, aovs: &Aovs, pixel: usize) -> Vec3 {
    let [_, instance, ..] = aovs.face[pixel];
    let of_pixel =
        |surface: &&Surface| surface.face.is_some_and(|face| face.instance == instance as usize);
    let mirror = scene.surfaces.iter().find(of_pixel).unwrap().transform.determinant().signum();
    mirror as f32 * Vec3::from_slice(&aovs.normal[pixel][..3])
}

#[test]
fn a_solid_whose_inside_can_be_seen_is_drawn_whole() {
    let mut stage = Stage::new(uvec2(320, 200));
    // From inside: the eye is in the box of the flange, in the material and in its bore.
    for (number, eye) in
        [DVec3::new(45.0, 0.0, 5.0), DVec3::new(1.0, 2.0, 5.0)].into_iter().enumerate()
    {
        let mut scene = own("flange");
        let lens = Lens::Perspective { fov_y_radians: 1.0 };
        let target = eye + DVec3::new(-0.6, 0.7, 0.1);
        scene.camera = Some(Camera::new(eye, target, DVec3::Z, lens).unwrap());
        check_is_whole(&mut stage, &format!("eye {number} inside"), &scene);
    }
    // From outside, with a window in the face that is seen, with a face that is hidden, or that is missing.
    let scene = own("bracket");
    let (aovs, stats) = draw(&mut stage, &scene);
    assert!(stats.culled > draw(&mut stage, &open(&scene)).1.culled);
    let seen = aovs.face[aovs.face.len() / 2 + 160];
    let surface = scene
        .surfaces
        .iter()
        .position(|surface| surface.face.is_some_and(|face| face.face == seen[0] as usize))
        .unwrap();
    let mut cut = scene.clone();
    let [low, high] = cut.surfaces[surface].domain();
    let (middle, size) = (low.midpoint(high), 0.2 * (high - low));
    let range = |axis: usize| DVec2::new(middle[axis] - size[axis], middle[axis] + size[axis]);
    cut.surfaces[surface].trims.rects.push(Rect::new(range(0), range(1)).unwrap());
    check_is_whole(&mut stage, "a window", &cut);
    let mut hidden = scene.clone();
    hidden.surfaces[surface].hidden = true;
    check_is_whole(&mut stage, "hidden", &hidden);
    let mut missing = scene.clone();
    missing.surfaces.remove(surface);
    check_is_whole(&mut stage, "missing", &missing);
    let mut moved = scene.clone();
    moved.surfaces[surface].transform.w_axis.z += 50.0;
    check_is_whole(&mut stage, "moved", &moved);
    let mut lines = scene;
    lines.settings.wireframe = true;
    let pictures = [&lines, &open(&lines)].map(|scene| stage.render(scene));
    assert!(pictures[0] == pictures[1], "lines");
}

/// At silhouettes, normals along edges may point a little away from the eye. Strokes are lit from outside all the same.
#[test]
fn edges_at_silhouettes_have_no_bright_specks() {
    const FRAMES: u32 = 8;
    let size = uvec2(640, 480);
    let aspect = f64::from(size.x) / f64::from(size.y);
    let lit = "lit(linearOf(paint), from + depth * direction, -normal, outwards)";
    let marked = Sources::default().with_edit("exact/stroke.frag", lit, "vec3(1.0, 0.0, 1.0)");
    let (mut strokes, mut specks) = (0, 0);
    for mirror in [1.0, -1.0] {
        let mut scene = own("bracket");
        for surface in &mut scene.surfaces {
            surface.transform = DMat4::from_scale(dvec3(mirror, 1.0, 1.0)) * surface.transform;
        }
        let table = scene.turntable(scene.up, aspect);
        for number in 0..FRAMES {
            scene.camera = Some(table.at(f64::from(number) / f64::from(FRAMES)));
            let picture = render(&scene, size, backends()[0]);
            let marks = render_with(&scene, size, backends()[0], marked.clone());
            let light = |x: u32, y: u32| -> u32 {
                picture.get_pixel(x, y).0[..3].iter().copied().map(u32::from).sum()
            };
            for (x, y) in (1..size.y - 1).flat_map(|y| (1..size.x - 1).map(move |x| (x, y))) {
                if marks.get_pixel(x, y).0[..3] != [255, 0, 255] {
                    continue;
                }
                let around = (0..9).filter(|i| *i != 4);
                let most = around.map(|i| light(x + i % 3 - 1, y + i / 3 - 1)).max();
                strokes += 1;
                specks += u32::from(most.is_some_and(|most| light(x, y) > most + 40));
            }
        }
    }
    assert!(strokes > 1_000, "{strokes} pixels show strokes");
    assert_eq!(specks, 0, "of {strokes} pixels of strokes, brighter than all of their neighbours");
}
