//! Meshes from random views: how far the triangles are from the smooth surface on the screen, in `f64`, and
//! whether the background shows through.

use freeform_surface::inspect::measure::Random;
use freeform_surface::{Alpha, CreaseAngle, Frame, Mesh, Smoothing};
use glam::{DMat4, dvec3, uvec2};

use crate::harness::Stage;
use crate::harness::meshes::{
    Distance, cracks, creased, holes, insides, mesh, off_by, pieces, scene_of_mesh, view,
};
use crate::harness::patches::{at_level, count_drawn, is_long, within};

const LOOKS: [Distance; 4] = [Distance::Far, Distance::Near, Distance::Grazing, Distance::Inside];

fn methods() -> [Smoothing; 2] {
    [Smoothing::Pn, Smoothing::Phong(Alpha::default())]
}

/// A tube along x whose neighbours need very different levels: short and long triangles alternate.
fn tube() -> Mesh {
    let mut text = String::new();
    let places = [0.0, 0.05, 1.0, 1.1, 3.0, 3.02];
    for x in places {
        for i in 0..5 {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(i) / 5.0).sin_cos();
            text += &format!("v {x} {cos} {sin}\nvn 0 {cos} {sin}\n");
        }
    }
    for row in 0..places.len() - 1 {
        for i in 0..5 {
            let corner = |row: usize, i: usize| {
                let number = 5 * row + i % 5 + 1;
                format!(" {number}//{number}")
            };
            let (a, b) = (corner(row, i), corner(row + 1, i));
            text += &format!("f{a}{b}{}{}\n", corner(row + 1, i + 1), corner(row, i + 1));
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tube.obj");
    std::fs::write(&path, text).unwrap();
    Mesh::load_obj(&path, CreaseAngle::NONE).unwrap()
}

#[test]
fn everything_that_is_drawn_is_within_the_tolerance() {
    let views = if is_long() { 200 } else { 8 };
    let mut stage = Stage::new(uvec2(320, 200));
    let mut random = Random(21);
    let (mut measured, mut unmet, mut points) = (0, 0, 0);
    for (name, mesh) in [
        ("icosahedron", mesh("icosahedron")),
        ("torus", mesh("torus")),
        ("cube", mesh("cube")),
        ("creased pawn", creased("figure", 35.0)),
        ("pawn", mesh("figure")),
        ("sheet", mesh("grid")),
        ("tube", tube()),
    ] {
        for smoothing in methods() {
            let mut scene = scene_of_mesh(mesh.clone(), smoothing);
            scene.meshes[0].transform =
                DMat4::from_rotation_x(0.3) * DMat4::from_scale(dvec3(1.0, 1.3, -0.8));
            let mut prepared = stage.prepared(&scene);
            let pieces = pieces(&scene);
            // The largest error relative to the requested tolerance.
            let mut max = 0.0_f64;
            for index in 0..views {
                scene.camera = Some(view(&pieces, &mut random, LOOKS[index % 4]));
                for tolerance in [2.0, 1.0, 0.5, 0.25] {
                    let settings = within(tolerance);
                    let frame = Frame { settings, ..stage.frame(&scene) };
                    let drawn = stage.triangles(&mut prepared, &frame);
                    let _ = stage.picture(&mut prepared, &frame);
                    let stats = prepared.stats();
                    if stats.unmet.is_some() {
                        unmet += 1;
                        continue;
                    }
                    let (off, count) = off_by(&pieces, &drawn, &frame, stage.size);
                    let bound = stats.largest_bound.unwrap_or(0.0);
                    assert!(bound <= tolerance, "{name}: {stats:?}");
                    assert!(
                        off <= bound,
                        "{name}, {smoothing:?}, view {index}: {off} px, {bound} at most, \
                         {tolerance} asked for"
                    );
                    max = max.max(off / tolerance);
                    points += count;
                    measured += 1;
                }
            }
            println!("{name}, {smoothing:?}: at most {max:.3} of the tolerance");
        }
    }
    println!("{measured} frames, {unmet} reached a limit, {points} points");
    assert!(points > 100_000 && measured > 2 * unmet, "{measured} and {unmet}, {points}");
}

/// Pictures of a mesh from all directions, alternately with one level and by tolerance.
fn check_no_background_inside(name: &str, mesh: &Mesh, views: usize, is_round: bool) {
    let mut stage = Stage::new(uvec2(160, 120));
    let mut random = Random(33);
    for smoothing in methods() {
        let mut scene = scene_of_mesh(mesh.clone(), smoothing);
        let mut prepared = stage.prepared(&scene);
        let pieces = pieces(&scene);
        let (mut drawn, mut near_enough) = (0, 0);
        for index in 0..views {
            let distance = [Distance::Far, Distance::Near, Distance::Grazing][index % 3];
            scene.camera = Some(view(&pieces, &mut random, distance));
            let uniform = at_level([1, 2, 3, 5, 8, 16][index % 6]);
            for settings in [uniform, within([0.3, 1.0, 3.0][index / 3 % 3])] {
                let frame = Frame { settings, ..stage.frame(&scene) };
                let picture = stage.picture(&mut prepared, &frame);
                drawn += count_drawn(&picture);
                let name =
                    format!("{name}, {smoothing:?}, view {index}, {:?}", settings.tessellation);
                if is_round {
                    assert_eq!(holes(&picture), Vec::<Vec<(u32, u32)>>::new(), "{name}");
                }
                if prepared.stats().largest_bound.is_some_and(|bound| bound <= 1.0) {
                    assert_eq!(cracks(&picture, &pieces, &frame, stage.size), 0, "{name}");
                    near_enough += 1;
                    if is_round {
                        let aovs = stage.aovs(&mut prepared, &frame);
                        assert_eq!(insides(&aovs, &frame), 0, "{name}");
                    }
                }
            }
        }
        assert!(drawn > 400 * views, "{name}: {drawn}");
        assert!(near_enough > views / 5, "{name}: {near_enough}");
    }
}

#[test]
fn no_background_in_a_ball() {
    check_no_background_inside("icosahedron", &mesh("icosahedron"), 200, true);
}

#[test]
fn no_background_in_a_cube() {
    check_no_background_inside("cube", &mesh("cube"), 200, true);
}

#[test]
fn no_background_in_a_creased_pawn() {
    check_no_background_inside("creased pawn", &creased("figure", 35.0), 200, false);
}

#[test]
fn no_background_in_a_torus() {
    check_no_background_inside("torus", &mesh("torus"), 200, false);
}

#[test]
fn no_background_in_a_pawn() {
    check_no_background_inside("pawn", &mesh("figure"), 200, false);
}

#[test]
fn a_gap_is_noticed() {
    // A corner of one triangle of a ball is moved inwards a little. Through the gap, the other side of the ball
    // is visible.
    let ball = mesh("icosahedron");
    let (mut positions, mut triangles) = (ball.positions().to_vec(), ball.triangles().to_vec());
    positions.push(positions[triangles[0][0].position as usize] * 0.97);
    triangles[0][0].position = positions.len() as u32 - 1;
    let normals = ball.normals().to_vec();
    let crease = CreaseAngle::NONE;
    let gap = Mesh::new(positions, normals, Vec::new(), triangles, crease).unwrap();
    let check = || check_no_background_inside("a gap", &gap, 60, true);
    assert!(std::panic::catch_unwind(check).is_err());
}
