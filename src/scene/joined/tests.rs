use super::super::Scene;
use super::*;
use crate::bezier::Degree;
use crate::trim::{Circle, Keep, Segment, TrimLoop};
use glam::{DMat4, DVec2, DVec4, dvec2};

/// A flat patch over x and y from `low` to `high`, whose normal is z.
fn flat(low: DVec2, high: DVec2) -> Surface {
    let at = |i: usize| low + (high - low) * dvec2((i % 4) as f64, (i / 4) as f64) / 3.0;
    Surface::new(Degree::CUBIC, (0..16).map(|i| at(i).extend(0.0).extend(1.0)).collect()).unwrap()
}

fn all_open(surfaces: &[Surface]) -> Vec<[bool; 4]> {
    surfaces.iter().flat_map(Surface::patches).map(|_| [true; 4]).collect()
}

/// The joints, each as the ends of its curve, in order.
fn ends(surfaces: &[Surface]) -> Vec<[DVec3; 2]> {
    let joints = joined(surfaces, &all_open(surfaces));
    let ends = joints.iter().map(|JoinedSurfaces { joint, .. }| {
        assert!(joint.gap < 1e-6);
        [joint.pieces[0].points[0], joint.pieces[joint.pieces.len() - 1].points[3]]
    });
    ends.collect()
}

/// Fails unless joints along y = 0 have these ranges of x.
fn check_ranges(surfaces: &[Surface], expected: &[[f64; 2]]) {
    let mut found: Vec<[f64; 2]> = ends(surfaces)
        .into_iter()
        .map(|ends| {
            assert!(ends.iter().all(|end| end.y.abs() < 1e-6 && end.z.abs() < 1e-6), "{ends:?}");
            let [a, b] = ends.map(|end| end.x);
            [a.min(b), a.max(b)]
        })
        .collect();
    found.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let is_near = |(a, b): (&[f64; 2], &[f64; 2])| (0..2).all(|i| (a[i] - b[i]).abs() < 1e-5);
    let all_near = found.iter().zip(expected).all(is_near);
    assert!(found.len() == expected.len() && all_near, "{found:?}, expected {expected:?}");
}

#[test]
fn whole_borders_and_parts_of_them_are_joined() {
    let above = || flat(DVec2::ZERO, dvec2(3.0, 1.0));
    let below = |from: f64, to: f64| flat(dvec2(from, -1.0), dvec2(to, 0.0));
    check_ranges(&[above(), below(0.0, 3.0)], &[[0.0, 3.0]]);
    check_ranges(&[above(), below(1.0, 2.0)], &[[1.0, 2.0]]);
    check_ranges(&[above(), below(-1.0, 2.0)], &[[0.0, 2.0]]);
    check_ranges(&[below(-1.0, 0.5), above(), below(1.5, 7.0)], &[[0.0, 0.5], [1.5, 3.0]]);
    // They meet in a point, or not at all.
    check_ranges(&[above(), below(3.0, 4.0)], &[]);
    check_ranges(&[above(), flat(dvec2(0.0, -1.0), dvec2(3.0, -1e-3))], &[]);
    // Other transforms, and the other way.
    let mut other = flat(DVec2::ZERO, DVec2::ONE);
    other.transform = DMat4::from_scale(DVec3::splat(2.0)) * DMat4::from_rotation_x(2.0);
    check_ranges(&[above(), other.clone()], &[[0.0, 2.0]]);
    other.transform = DMat4::from_translation(2.0 * DVec3::X)
        * DMat4::from_rotation_z(2.0 * 1e-9)
        * DMat4::from_scale(DVec3::new(-1.5, -1.0, 1.0));
    check_ranges(&[above(), other], &[[0.5, 2.0]]);
}

#[test]
fn surfaces_that_are_not_to_be_joined_are_not() {
    let mut surfaces = [flat(DVec2::ZERO, DVec2::ONE), flat(dvec2(0.0, -1.0), dvec2(1.0, 0.0))];
    assert_eq!(ends(&surfaces).len(), 1);
    surfaces[1].join = false;
    assert_eq!(ends(&surfaces).len(), 0);
    surfaces[1].join = true;
    assert!(joined(&surfaces, &[[false; 4], [true; 4]]).is_empty());
}

#[test]
fn what_trims_cut_is_not_joined() {
    let circle = |x: f64, y: f64| Circle::new(dvec2(x, y), 0.2).unwrap();
    let [mut above, mut below] =
        [flat(DVec2::ZERO, DVec2::ONE), flat(dvec2(0.0, -1.0), dvec2(1.0, 0.0))];
    above.trims.circles.push(circle(0.5, 0.0));
    check_ranges(&[above.clone(), below.clone()], &[[0.0, 0.3], [0.7, 1.0]]);
    below.trims.circles.push(circle(0.9, 1.0));
    check_ranges(&[above.clone(), below.clone()], &[[0.0, 0.3]]);
    below.trims.circles_on = false;
    check_ranges(&[above, below], &[[0.0, 0.3], [0.7, 1.0]]);
}

#[test]
fn a_hole_is_joined_to_what_fills_it_and_their_common_outlines_are_not() {
    let mut surfaces = [flat(DVec2::ZERO, DVec2::ONE), flat(DVec2::ZERO, DVec2::ONE)];
    let corners = [(0.2, 0.2), (0.7, 0.3), (0.4, 0.8)].map(|(x, y)| dvec2(x, y));
    let line = |i: usize| Segment::Line([corners[i], corners[(i + 1) % 3]]);
    for surface in &mut surfaces {
        surface.trims.add_loop(TrimLoop::new((0..3).map(line).collect()).unwrap()).unwrap();
    }
    surfaces[1].trims.keep = Keep::Inside;
    let found = ends(&surfaces);
    assert_eq!(found.len(), 3, "{found:?}");
    let is_corner =
        |end: &DVec3| corners.iter().any(|corner| end.truncate().distance(*corner) < 1e-9);
    assert!(found.iter().flatten().all(is_corner));
    // The same border of one surface twice is nothing that meets.
    let frame = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| dvec2(x, y));
    let side = |i: usize| Segment::Line([frame[i], frame[(i + 1) % 4]]);
    let mut whole = flat(DVec2::ZERO, DVec2::ONE);
    whole.trims.add_loop(TrimLoop::new((0..4).map(side).collect()).unwrap()).unwrap();
    whole.trims.keep = Keep::Inside;
    assert!(ends(&[whole.clone(), flat(DVec2::splat(0.5), DVec2::splat(0.6))]).is_empty());
    check_ranges(&[whole, flat(dvec2(0.0, -1.0), dvec2(1.0, 0.0))], &[[0.0, 1.0]]);
}

#[test]
fn of_many_equal_borders_each_is_joined_to_one() {
    for count in [2, 3, 5] {
        let equal: Vec<Surface> = (0..count).map(|_| flat(DVec2::ZERO, DVec2::ONE)).collect();
        assert_eq!(ends(&equal).len(), 4 * (count - 1));
    }
}

#[test]
fn normals_sides_and_parameters_are_those_of_the_surfaces() {
    // A quarter of a cylinder around x that begins at y = 0, of the second of two patches of a surface.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let arc = [(0.0, 0.0, 1.0), (-1.0, 0.0, half), (-1.0, -1.0, 1.0)];
    let points = |at: f64| {
        let row = move |(y, z, w)| [0.0, 2.0].map(|x| DVec4::new(at + x, y, z, w));
        arc.into_iter().flat_map(row)
    };
    let tube = Surface::new(Degree::new(1, 2).unwrap(), points(9.0).chain(points(0.0)).collect());
    let mut above = flat(DVec2::ZERO, dvec2(1.0, 1.0));
    above.transform = DMat4::from_scale(DVec3::new(2.0, 1.0, -1.0));
    let surfaces = [tube.unwrap(), above];
    let found = joined(&surfaces, &all_open(&surfaces));
    assert_eq!(found.len(), 1);
    let JoinedSurfaces { joint, patches } = &found[0];
    assert_eq!((joint.faces, *patches), ([0, 1], [1, 0]));
    for (piece, i) in joint.pieces.iter().flat_map(|piece| [(piece, 0), (piece, 3)]) {
        let (point, beside) = (piece.points[i], if i == 0 { &piece.start } else { &piece.end });
        let direction = piece.points[3] - piece.points[0];
        for (number, into) in [-DVec3::Y, DVec3::Y].into_iter().enumerate() {
            let share = beside[number].share.as_dvec2();
            let at = surfaces[number].at(patches[number], share.x, share.y).position;
            let at = surfaces[number].transform.transform_point3(at);
            assert!(at.distance(point) < 1e-6);
            let normal = beside[number].normal.as_dvec3();
            assert!((normal.length() - 1.0).abs() < 1e-6);
            let across = joint.sides[number] * normal.cross(direction).normalize();
            assert!(across.distance(into) < 1e-6, "{number}: {across}");
        }
    }
}

#[test]
fn the_text_of_a_scene_keeps_which_surfaces_are_not_joined() {
    let text = "[[surface]]\ncontrol_points = \"default\"\njoin = false\n\
                [[surface]]\ncontrol_points = \"default\"\n";
    let path = std::path::Path::new("scene.toml");
    let scene = Scene::from_toml(text, path).unwrap();
    assert_eq!([scene.surfaces[0].join, scene.surfaces[1].join], [false, true]);
    let written = scene.to_toml(path).unwrap().text;
    assert_eq!(written.matches("join").count(), 1, "{written}");
    assert_eq!(Scene::from_toml(&written, path).unwrap().surfaces, scene.surfaces);
}
