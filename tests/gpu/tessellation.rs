//! Tessellation of patches: neighbours meet, there are no more triangles than necessary, draws are small enough
//! for the driver's numbering, and nothing invisible is drawn.

use std::collections::BTreeSet;

use freeform_surface::inspect::DrawnVertex;
use freeform_surface::inspect::measure::Random;
use freeform_surface::inspect::measure::random_view;
use freeform_surface::{Camera, Circle, Cull, Degree, Frame, Image, Lens, Patch, Scene, Surface};
use glam::{DMat4, DVec2, DVec3, DVec4, dvec2, dvec3, uvec2};

use crate::harness::Stage;
use crate::harness::neighbours::{by_patch, check_insides, check_neighbours};
use crate::harness::patches::{at_level, count_drawn, field, is_long, scene_of, turned, within};
use crate::harness::{assert_same, load, root};

fn teapot() -> Scene {
    let scene = load(&root().join("resources/surfaces/teapot.bpt"));
    Scene { settings: within(0.5), ..scene }
}

/// The scene's own view and random views, with the same number of each family.
fn views(scene: &Scene, aspect: f64, of_each: u64) -> Vec<Option<Camera>> {
    let random = (0..4 * of_each).map(|index| Some(random_view(scene, 7, index, aspect)));
    [scene.camera].into_iter().chain(random).collect()
}

#[test]
fn edges_of_two_degrees_meet_bit_for_bit() {
    let mut stage = Stage::new(uvec2(960, 600));
    let path = root().join("resources/scenes/stability/tess-raised-edges.toml");
    let mut scene = Scene { settings: within(0.5), ..load(&path) };
    let mut prepared = stage.prepared(&scene);
    // The last control point of an inner row and one that no edge depends on.
    let changes: [&[(usize, f64)]; 2] = [&[], &[(4, 0.5)]];
    for changes in changes {
        for (index, y) in changes {
            let point = scene.surfaces[0].control_points()[*index];
            let point = DVec4::new(point.x, point.y + y, point.z, point.w);
            scene.surfaces[0].set_control_point(point, *index).unwrap();
            prepared.surfaces_mut()[0].set_control_point(point, *index).unwrap();
        }
        for (view, camera) in views(&scene, stage.aspect(), 8).into_iter().enumerate() {
            let shown = Scene { camera, ..scene.clone() };
            let drawn = stage.triangles(&mut prepared, &stage.frame(&shown));
            let met = check_neighbours(&format!("view {view}"), &shown, &drawn);
            check_insides(&format!("view {view}"), &drawn);
            if view == 0 {
                assert!(met.pairs == 3 && met.segments > 20, "{} {}", met.pairs, met.segments);
            }
        }
    }
}

#[test]
fn patches_of_the_teapot_meet_bit_for_bit() {
    let mut stage = Stage::new(uvec2(1920, 1080));
    let mut scene = teapot();
    let mut prepared = stage.prepared(&scene);
    let mut in_parts = 0;
    for (view, camera) in views(&scene, stage.aspect(), 4).into_iter().enumerate() {
        scene.camera = camera;
        let drawn = stage.triangles(&mut prepared, &stage.frame(&scene));
        let met = check_neighbours(&format!("view {view}"), &scene, &drawn);
        check_insides(&format!("view {view}"), &drawn);
        // From outside nothing is culled. The pairs are: 4 in each ring of 4 patches, of which there are 9 and
        // one of the bottom; and at the poles of lid and bottom, each patch with each other.
        assert!(camera.is_some() || (met.pairs >= 52 && met.segments > 500), "{}", met.pairs);
        // A sub-patch has at most 65 different values of u.
        let places = |triangles: &Vec<&[DrawnVertex; 3]>| {
            let all = triangles.iter().copied().flatten().map(|corner| corner.uv[0].to_bits());
            all.collect::<BTreeSet<u32>>().len()
        };
        let max = by_patch(&drawn).values().map(places).max();
        in_parts += usize::from(max > Some(65));
    }
    assert!(in_parts >= 2, "no patch was near enough to be drawn in parts");
}

#[test]
fn all_parts_of_a_patch_are_drawn_once() {
    let mut stage = Stage::new(uvec2(1920, 1080));
    let mut random = Random(9);
    for degree in [Degree::CUBIC, Degree::QUARTIC] {
        let [_, (_, rough)] = pair(&mut random, [degree; 2], false, 0);
        let mut scene = scene_of(vec![Surface::new(degree, rough).unwrap()]);
        scene.settings = within(0.02);
        let mut prepared = stage.prepared(&scene);
        let drawn = stage.triangles(&mut prepared, &stage.frame(&scene));
        check_insides("parts", &drawn);
        let area = |[a, b, c]: [DVec2; 3]| 0.5 * (b - a).perp_dot(c - a).abs();
        let triangles = drawn.as_chunks::<3>().0.iter();
        let area: f64 = triangles
            .map(|corners| area(corners.each_ref().map(|corner| corner.uv.map(f64::from).into())))
            .sum();
        assert!((area - 1.0).abs() < 1e-5, "{degree:?}: triangles cover {area} of the domain");
        let all: BTreeSet<[u32; 2]> =
            drawn.iter().map(|vertex| vertex.uv.map(f32::to_bits)).collect();
        // A sub-patch has at most 64 cells a side; this gives the smallest number of sub-patches, a power of two.
        let parts = [0, 1].map(|axis| {
            let places: BTreeSet<u32> = all.iter().map(|uv| uv[axis]).collect();
            (places.len() - 1).div_ceil(64).next_power_of_two()
        });
        assert!(parts.iter().any(|parts| *parts > 1), "{degree:?}: drawn whole");
        for i in 0..(parts[0] + 1) * (parts[1] + 1) {
            let place = [i % (parts[0] + 1), i / (parts[0] + 1)];
            let corner = [0, 1].map(|axis| place[axis] as f32 / parts[axis] as f32);
            assert!(all.contains(&corner.map(f32::to_bits)), "{degree:?}: no {corner:?}");
        }
    }
}

/// A patch by its degree and its net.
type Net = (Degree, Vec<DVec4>);

/// Two patches of the given degrees side by side: the first is nearly flat, the second is rough and turned by
/// `turn`. The degrees along the common edge are equal.
fn pair(random: &mut Random, degrees: [Degree; 2], rational: bool, turn: usize) -> [Net; 2] {
    let mut net = |degree: Degree, x: f64, rough: f64| -> Vec<DVec4> {
        let (columns, steps) = (degree.columns(), [degree.u(), degree.v()].map(|n| n as f64));
        (0..degree.points())
            .map(|i| {
                let mut place = |cell: usize, steps: f64| {
                    (cell as f64 + rough * random.between(-0.3, 0.3)) / steps
                };
                let (x, y) = (x + place(i % columns, steps[0]), place(i / columns, steps[1]));
                let weight =
                    if rational { (rough * random.between(-1.5, 1.5)).exp2() } else { 1.0 };
                DVec4::new(x, y, rough * random.between(-1.0, 1.0), weight)
            })
            .collect()
    };
    let (flat, mut rough) = (net(degrees[0], 0.0, 0.02), net(degrees[1], 1.0, 1.0));
    let columns = degrees.map(Degree::columns);
    for row in 0..degrees[1].rows() {
        rough[row * columns[1]] = flat[row * columns[0] + columns[0] - 1];
    }
    [(degrees[0], flat), turned(degrees[1], &rough, turn)]
}

#[test]
fn random_patches_meet_in_every_orientation() {
    let mut stage = Stage::new(uvec2(1000, 600));
    let mut random = Random(1);
    let of_each = if is_long() { 10 } else { 1 };
    let hole = Circle::new(dvec2(0.5, 0.5), 0.45).unwrap();
    let degree = |u: usize, v: usize| Degree::new(u, v).unwrap();
    let mut cases: Vec<([Degree; 2], bool, usize)> = Vec::new();
    for degree in [Degree::CUBIC, Degree::QUARTIC] {
        cases.extend((0..16).map(|i| ([degree; 2], i >= 8, i % 8)));
    }
    for (i, degrees) in [
        [degree(1, 1), degree(1, 1)],
        [degree(2, 1), degree(1, 1)],
        [degree(1, 2), degree(2, 2)],
        [degree(1, 3), degree(3, 3)],
        [degree(4, 3), degree(2, 3)],
        [degree(2, 5), degree(7, 5)],
        [degree(6, 6), degree(1, 6)],
        [degree(3, 8), degree(9, 8)],
        [degree(15, 15), degree(2, 15)],
    ]
    .into_iter()
    .enumerate()
    {
        cases.extend([(degrees, false, i % 8), (degrees, true, (i + 3) % 8)]);
    }
    for (degrees, rational, turn) in cases {
        let [flat, rough] = pair(&mut random, degrees, rational, turn);
        let surface = |(degree, points): &Net| Surface::new(*degree, points.clone()).unwrap();
        let trimmed = |mut surface: Surface| {
            surface.trims.circles.push(hole);
            surface
        };
        // The flat patch with all weights doubled.
        let heavy = flat.1.iter().map(|p| p.truncate().extend(2.0 * p.w)).collect();
        let mut scenes = vec![
            ("two surfaces", vec![surface(&flat), surface(&rough)]),
            ("twice as heavy", vec![surface(&(flat.0, heavy)), surface(&rough)]),
            ("rough one trimmed", vec![surface(&flat), trimmed(surface(&rough))]),
            ("flat one trimmed", vec![trimmed(surface(&flat)), surface(&rough)]),
        ];
        if flat.0 == rough.0 {
            let together = [flat.1.as_slice(), &rough.1].concat();
            scenes.push(("one surface", vec![surface(&(flat.0, together))]));
        }
        for (how, surfaces) in scenes {
            let mut scene = scene_of(surfaces);
            let mut prepared = stage.prepared(&scene);
            let whole = !how.ends_with("trimmed");
            for (view, camera) in views(&scene, stage.aspect(), of_each).into_iter().enumerate() {
                let [a, b] = degrees;
                let name =
                    format!("{a} and {b}, rational {rational} turn {turn} {how} view {view}");
                scene.camera = camera;
                let drawn = stage.triangles(&mut prepared, &stage.frame(&scene));
                let met = check_neighbours(&name, &scene, &drawn);
                if whole {
                    check_insides(&name, &drawn);
                }
                if view == 0 {
                    let count = by_patch(&drawn);
                    let [flat, rough] = [0, 1].map(|patch| count[&patch].len());
                    assert!(met.pairs == 1 && met.segments > 4, "{name}: {}", met.segments);
                    // Of equal degrees, the rough patch has more triangles than its neighbour.
                    let is_rougher = rough > 2 * flat || degrees[0] != degrees[1];
                    assert!(is_rougher || degrees[0].u() < 3, "{name}: {flat}, {rough} triangles");
                }
            }
        }
    }
}

#[test]
fn half_a_pixel_of_the_teapot_takes_45_000_triangles() {
    let mut stage = Stage::new(uvec2(1920, 1080));
    let scene = load(&root().join("resources/scenes/gallery/teapot.toml"));
    let mut prepared = stage.prepared(&scene);
    stage.picture(&mut prepared, &stage.frame(&scene));
    let stats = prepared.stats();
    assert_eq!((stats.patches, stats.culled, stats.unmet), (32, 0, None), "{stats:?}");
    assert!((1_000..=45_000).contains(&stats.triangles), "{stats:?}");
    assert!(stats.largest_bound.is_some_and(|bound| bound <= 0.5), "{stats:?}");
    let drawn = stage.triangles(&mut prepared, &stage.frame(&scene));
    assert_eq!(drawn.len() as u64, 3 * stats.triangles);
}

/// A rough field of `side` × `side` patches.
fn rough_field(side: usize) -> Scene {
    let mut random = Random(5);
    let points_a_side = 3 * side + 1;
    let heights: Vec<f64> = (0..points_a_side.pow(2)).map(|_| random.between(-0.4, 0.4)).collect();
    let points = field(side, |column, row| match (column, row) {
        // The first patch has the minimum and the maximum height of all.
        (1, 1) => -0.4,
        (2, 2) => 0.4,
        _ => heights[row * points_a_side + column],
    });
    scene_of(vec![Surface::new(Degree::CUBIC, points).unwrap()])
}

#[test]
fn draws_of_many_patches_are_few_and_whole() {
    let mut stage = Stage::new(uvec2(640, 400));
    // 82 million triangles take most of a minute.
    let side_at_level = if is_long() { 100 } else { 20 };
    for (side, settings) in [(100, within(0.5)), (side_at_level, at_level(64))] {
        let scene = Scene { settings, ..rough_field(side) };
        let mut prepared = stage.prepared(&scene);
        let frame = stage.frame(&scene);
        let found = stage.measured(&scene, &mut prepared, &frame);
        // An instance with more vertices than 16 bits can number would leave holes and draw wrong patches.
        assert!(found.covered > 100_000, "{found:?}");
        let wrong = found.crack_pixels + found.hidden_pixels + found.bad_values;
        assert_eq!(wrong, 0, "{found:?}");
        assert!(found.max_error_px <= 0.5, "{found:?}");
        let stats = prepared.stats();
        assert_eq!((stats.patches, stats.culled), (side * side, 0), "{stats:?}");
        // A patch of n × m cells has slightly more than n · m vertices, half as many as triangles.
        assert!(stats.triangles / 2 > 300_000 && stats.draws <= 60, "{stats:?}");
    }
}

/// Whether a patch lies outside one plane of the view frustum.
fn is_outside(points: &[DVec4], to_clip: DMat4) -> bool {
    let clips: Vec<DVec4> = points.iter().map(|p| to_clip * p.truncate().extend(1.0)).collect();
    (0..3).any(|axis| {
        [-1.0, 1.0].iter().any(|sign| clips.iter().all(|clip| sign * clip[axis] > clip.w))
    })
}

/// Whether one of 17 × 17 points of a patch is visible.
fn has_point_inside(points: &[DVec4], to_clip: DMat4) -> bool {
    let patch = Patch::new(Degree::CUBIC, points);
    (0..17 * 17).any(|i| {
        let point = patch.at(f64::from(i % 17) / 16.0, f64::from(i / 17) / 16.0).position;
        let clip = to_clip * point.extend(1.0);
        clip.truncate().abs().max_element() < clip.w
    })
}

#[test]
fn patches_out_of_sight_are_culled_and_not_missed() {
    const SIDE: usize = 20;
    let mut stage = Stage::new(uvec2(480, 300));
    let whole = rough_field(SIDE);
    let lens = Lens::Perspective { fov_y_radians: 0.7 };
    for (eye, target, seen_alone) in [
        // From above; level with the field; from within the field; and looking away from it.
        (dvec3(8.5, 11.0, 5.0), dvec3(8.6, 11.1, 0.0), 15..=40),
        (dvec3(17.5, 3.1, 1.0), dvec3(22.0, 3.0, 0.2), 1..=20),
        (dvec3(3.2, 18.0, 0.1), dvec3(0.0, 19.5, 0.0), 1..=25),
        (dvec3(10.0, 10.0, 3.0), dvec3(10.0, 10.1, 5.0), 0..=0),
    ] {
        let camera = Camera::new(eye, target, DVec3::Z, lens).unwrap();
        let scene = Scene { camera: Some(camera), ..whole.clone() };
        let frame = stage.frame(&scene);
        let to_clip = frame.camera.projection * frame.camera.view;
        let patches = scene.surfaces[0].control_points().chunks_exact(16);
        let seen: Vec<&[DVec4]> =
            patches.clone().filter(|patch| !is_outside(patch, to_clip)).collect();
        let shown = seen.iter().filter(|patch| has_point_inside(patch, to_clip)).count();
        assert!(seen_alone.contains(&seen.len()), "{eye}: {} are seen", seen.len());

        let mut prepared = stage.prepared(&scene);
        let picture = stage.picture(&mut prepared, &frame);
        let stats = prepared.stats();
        assert_eq!(stats.patches, SIDE * SIDE);
        // All sub-patches of the other patches may be out of view.
        let not_culled = stats.patches - stats.culled;
        assert!((shown..=seen.len()).contains(&not_culled), "{eye}: {not_culled}, {shown}");
        // The field's first and last patch preserve its box. Coordinates are rounded relative to the centre of
        // this box.
        let ends = [patches.clone().next(), patches.clone().last()].map(Option::unwrap);
        let points = [&seen[..], &ends[..]].concat().concat();
        let alone = scene_of(vec![Surface::new(Degree::CUBIC, points).unwrap()]);
        let expected = stage.picture(&mut stage.prepared(&alone), &frame);
        assert_same("culled", &expected, &picture, &[], 0);
        let drawn = count_drawn(&picture);
        assert_eq!(drawn > 2_000, !seen.is_empty(), "{eye}: {drawn} pixels");
    }
}

/// A closed box of six curved patches with Su × Sv outwards, or all of them mirrored.
fn closed_box(inside_out: bool) -> Surface {
    const PLACES: [f64; 4] = [-1.0, -0.4, 0.4, 1.0];
    let mut points = Vec::new();
    for (axis, sign) in (0..6).map(|face| (face / 2, [1.0, -1.0][face % 2])) {
        let mut net = Vec::new();
        for i in 0..16 {
            let (u, v) = (PLACES[i % 4], PLACES[i / 4]);
            let mut point = [0.0; 3];
            point[axis] = sign;
            point[(axis + 1) % 3] = u * sign;
            point[(axis + 2) % 3] = v;
            // The bulges are the same on both sides of an edge.
            let [x, y, z] = point;
            let point = dvec3(x, y, z) * (1.15 - 0.05 * (x * x + y * y + z * z));
            net.push((point + 0.05 * dvec3(z * y, x * z, x * y)).extend(1.0));
        }
        points.extend(turned(Degree::CUBIC, &net, if inside_out { 4 } else { 0 }).1);
    }
    Surface::new(Degree::CUBIC, points).unwrap()
}

/// Pixels with a neighbour that shows nothing.
fn at_silhouette(picture: &Image) -> Vec<bool> {
    let empty = |x: i64, y: i64| {
        let (Ok(x), Ok(y)) = (x.try_into(), y.try_into()) else { return true };
        picture.get_pixel_checked(x, y).is_none_or(|pixel| pixel.0[3] == 0)
    };
    let places = picture.enumerate_pixels().map(|(x, y, _)| (i64::from(x), i64::from(y)));
    places.map(|(x, y)| (0..9).any(|i| empty(x + i % 3 - 1, y + i / 3 - 1))).collect()
}

#[test]
fn backs_of_a_closed_box_need_not_be_drawn() {
    let mut stage = Stage::new(uvec2(300, 300));
    let mut random = Random(11);
    let turn = DMat4::from_axis_angle(dvec3(1.0, 2.0, 3.0).normalize(), 1.0);
    let mirror = turn * DMat4::from_scale(dvec3(-1.0, 2.0, 0.5));
    let moved = DMat4::from_translation(dvec3(3.0, -1.0, 0.0)) * turn;
    for (transform, inside_out) in [
        (DMat4::IDENTITY, false),
        (moved, false),
        // A mirror reverses the orientation of u and v.
        (mirror, true),
        (DMat4::IDENTITY, true),
        (mirror, false),
    ] {
        let outwards = inside_out == (transform.determinant() < 0.0);
        let mut surface = closed_box(inside_out);
        surface.transform = transform;
        let mut scene = Scene { settings: at_level(16), ..scene_of(vec![surface]) };
        let mut prepared = stage.prepared(&scene);
        let mut culled = 0;
        for view in 0..12 {
            let direction = DVec3::from_array([(); 3].map(|()| random.between(-1.0, 1.0)));
            let middle = transform.transform_point3(DVec3::ZERO);
            let eye = middle + 6.0 * direction.normalize();
            let lens = if view % 3 == 0 {
                Lens::Orthographic { height: 6.0 }
            } else {
                Lens::Perspective { fov_y_radians: 0.9 }
            };
            scene.camera = Some(Camera::new(eye, middle, dvec3(0.1, 0.2, 1.0), lens).unwrap());
            let frame = stage.frame(&scene);
            let [all, fronts] = [Cull::None, Cull::Back].map(|cull| {
                prepared.surfaces_mut()[0].set_cull(cull);
                let picture = stage.picture(&mut prepared, &frame);
                (picture, prepared.stats())
            });
            assert_eq!(all.1.culled, 0);
            assert!(count_drawn(&all.0) > 10_000);
            culled += fronts.1.culled;
            if outwards {
                // At the silhouette, front faces and back faces meet at the same depth.
                assert_same("backs", &all.0, &fronts.0, &at_silhouette(&all.0), 0);
                let alpha = |picture: &Image| picture.pixels().map(|p| p.0[3]).collect::<Vec<_>>();
                assert_eq!(alpha(&all.0), alpha(&fronts.0));
                // Within a tolerance, front faces alone may get fewer triangles than together with the back
                // faces.
                let settings = within(0.5);
                let found = stage.measured(&scene, &mut prepared, &Frame { settings, ..frame });
                let wrong = found.crack_pixels + found.hidden_pixels;
                assert!(found.max_error_px <= 0.5 && wrong == 0, "{found:?}");
                assert!(prepared.stats().culled == fronts.1.culled);
            } else if fronts.1.culled > 0 {
                assert_ne!(all.0, fronts.0, "fronts were left out and not missed");
            }
        }
        // One to three of the six sides face away completely.
        assert!((12..=36).contains(&culled), "{culled} culled");
    }
}

#[test]
fn backs_of_rational_patches_are_drawn() {
    let mut stage = Stage::new(uvec2(200, 200));
    let mut scene = load(&root().join("resources/scenes/stability/tess-rational-sphere.toml"));
    scene.settings = within(0.5);
    scene.surfaces.iter_mut().for_each(|surface| surface.cull = Cull::Back);
    let mut prepared = stage.prepared(&scene);
    let picture = stage.picture(&mut prepared, &stage.frame(&scene));
    assert!(count_drawn(&picture) > 5_000);
    assert_eq!(prepared.stats().culled, 0);
}

#[test]
fn a_changed_control_point_draws_as_in_a_new_scene() {
    let mut stage = Stage::new(uvec2(480, 300));
    let mut scene = teapot();
    let mut prepared = stage.prepared(&scene);
    let frame = stage.frame(&scene);
    let mut before = stage.picture(&mut prepared, &frame);
    // One point inside a patch of the body and one on an edge of the spout. Both stay in the model's box.
    for (index, to) in [(4 * 16 + 5, dvec3(0.5, -0.5, 0.5)), (20 * 16 + 3, dvec3(0.0, 0.1, 1.0))] {
        assert_eq!(stage.picture(&mut prepared, &frame), before, "a still frame");
        prepared.surfaces_mut()[0].set_specific_control_point(to, index).unwrap();
        scene.surfaces[0].set_control_point(to.extend(1.0), index).unwrap();
        let changed = stage.picture(&mut prepared, &frame);
        let mut fresh = stage.prepared(&scene);
        let expected = stage.picture(&mut fresh, &frame);
        assert_same("changed", &expected, &changed, &[], 0);
        assert_eq!(prepared.stats(), fresh.stats());
        assert_ne!(changed, before);
        before = changed;
    }
}

/// Moves a patch point by point, and fails if its picture then exceeds the tolerance.
fn check_moved_by(distance: f64) {
    let mut stage = Stage::new(uvec2(480, 300));
    let [_, (_, rough)] = pair(&mut Random(1), [Degree::CUBIC; 2], false, 0);
    let mut scene = scene_of(vec![Surface::new(Degree::CUBIC, rough).unwrap()]);
    let mut prepared = stage.prepared(&scene);
    for i in 0..16 {
        let to = scene.surfaces[0].control_points()[i] + DVec3::splat(distance).extend(0.0);
        prepared.surfaces_mut()[0].set_control_point(to, i).unwrap();
        scene.surfaces[0].set_control_point(to, i).unwrap();
    }
    let frame = stage.frame(&scene);
    let found = stage.measured(&scene, &mut prepared, &frame);
    let stats = prepared.stats();
    assert!(found.covered > 10_000 && stats.unmet.is_none(), "{found:?} {stats:?}");
    let wrong = found.crack_pixels + found.hidden_pixels;
    assert!(found.max_error_px <= 0.5 && wrong == 0, "{found:?} {stats:?}");
}

#[test]
fn control_points_moved_out_of_their_box_stay_within_tolerance() {
    check_moved_by(10.0);
}

#[test]
fn control_points_moved_far_away_stay_within_tolerance() {
    check_moved_by(1e6);
}

/// Surfaces that share a draw fetch their matrices; a single surface has them as uniforms. The vertices must be
/// the same.
#[test]
fn a_surface_has_the_same_triangles_alone_and_beside_another() {
    let mut stage = Stage::new(uvec2(640, 400));
    let mut alone = teapot();
    alone.surfaces[0].transform =
        DMat4::from_rotation_y(0.3) * DMat4::from_scale(DVec3::splat(0.7));
    alone.camera = Some(alone.framed(1.6));
    let mut both = alone.clone();
    both.surfaces.push(alone.surfaces[0].clone());
    both.surfaces[1].transform = DMat4::from_translation(dvec3(0.5, 9.0, 0.0));
    let mut draw = |scene: &Scene| {
        let mut prepared = stage.prepared(scene);
        stage.triangles(&mut prepared, &stage.frame(scene))
    };
    let (mut alone, mut both) = (draw(&alone), draw(&both));
    assert!(both.len() > alone.len() && alone.len() > 3_000, "{} {}", both.len(), alone.len());
    both.retain(|corner| corner.patch < 32);
    // The near and the far plane depend on the whole scene, so that depths differ.
    alone.iter_mut().chain(&mut both).for_each(|corner| corner.clip[2] = 0.0);
    assert_eq!(alone, both);
}
