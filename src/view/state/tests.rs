//! The effects of actions and the mouse on a scene, without a window.

use freeform_surface::inspect::measure::Random;
use freeform_surface::{AnalysisChange, AnalysisKind, DraftLimit, IsolineCount, Keep, Shading};
use glam::Vec3Swizzles as _;

use super::super::action::{BINDINGS, Binding, Side, TrimKind};
use super::super::pick::{on_screen, world_point};
use super::super::pointer::Button;
use super::*;

fn state() -> State {
    State::new(Scene::listing16(), None)
}

fn mesh() -> Scene {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/meshes/cube.obj");
    Scene::load(path.as_ref()).unwrap()
}

fn press(state: &mut State, actions: &[Action]) {
    for action in actions {
        state.note_press();
        assert_eq!(state.apply(*action), None, "{action:?}");
        assert_eq!(state.message, None, "{action:?}");
    }
}

#[test]
fn levels_go_from_1_to_50_and_t_brings_the_tolerance_back() {
    let mut state = state();
    let level = |state: &State| match state.scene.settings.tessellation {
        Tessellation::Level(level) => level.get(),
        Tessellation::Within(_) => 0,
    };
    press(&mut state, &[Action::Finer]);
    assert_eq!(level(&state), 33);
    press(&mut state, &[Action::Finer; 60]);
    assert_eq!(level(&state), 50);
    press(&mut state, &[Action::Coarser; 60]);
    assert_eq!(level(&state), 1);
    press(&mut state, &[Action::LargerTolerance]);
    assert_eq!(
        state.scene.settings.tessellation,
        Tessellation::Within(Tolerance::new(1.0).unwrap())
    );
    press(&mut state, &[Action::Finer, Action::UseTolerance]);
    assert_eq!(
        state.scene.settings.tessellation,
        Tessellation::Within(Tolerance::new(1.0).unwrap())
    );
    press(&mut state, &[Action::SmallerTolerance; 30]);
    assert_eq!(state.finenesses().1.pixels(), 0.01);
    // A scene's own level may be higher than the keys' maximum.
    let mut scene = Scene::listing16();
    scene.settings.tessellation = Tessellation::Level(TessLevel::MAX);
    let mut state = State::new(scene, None);
    press(&mut state, &[Action::Finer]);
    assert_eq!(level(&state), 64);
    press(&mut state, &[Action::Coarser]);
    assert_eq!(level(&state), 63);
}

#[test]
fn every_action_of_the_table_does_something() {
    for binding in BINDINGS {
        for (chord, action) in binding.keys_and_actions() {
            let on_mesh = matches!(action, Action::Phong | Action::Pn);
            let mut state = State::new(if on_mesh { mesh() } else { Scene::listing16() }, None);
            // An edit to undo, and a camera to reset.
            press(&mut state, &[Action::Turn(1, 1), Action::Trim(TrimKind::Rect)]);
            state.select(Some(0));
            if *action == Action::ShowAll {
                press(&mut state, &[Action::Hide]);
            }
            if *action == Action::Redo {
                press(&mut state, &[Action::Undo]);
            }
            let (scene, overlay, turntable) = (state.scene.clone(), state.cover, state.turntable);
            let request = state.apply(*action);
            let same_here = state.cover == overlay && state.turntable == turntable;
            let tolerance = *action == Action::UseTolerance;
            assert!(
                request.is_some() || !same_here || state.scene != scene || tolerance,
                "{chord} does nothing"
            );
        }
    }
}

#[test]
fn edges_come_back_as_they_were() {
    let mut state = state();
    press(&mut state, &[Action::Edges]);
    assert_eq!(state.scene().settings.edges, Some(Edges::default()));
    let own = Edges { smooth: true, ..Edges::default() };
    state.change_settings(|settings| settings.edges = Some(own));
    press(&mut state, &[Action::Edges]);
    assert_eq!(state.scene().settings.edges, None);
    press(&mut state, &[Action::Edges]);
    assert_eq!(state.scene().settings.edges, Some(own));
}

#[test]
fn isolines_come_back_as_they_were() {
    let mut state = state();
    press(&mut state, &[Action::Isolines]);
    assert_eq!(state.scene().settings.isolines, Some(Isolines::default()));
    let own = Isolines { count: IsolineCount::MAX, ..Isolines::default() };
    state.change_settings(|settings| settings.isolines = Some(own));
    press(&mut state, &[Action::Isolines]);
    assert_eq!(state.scene().settings.isolines, None);
    press(&mut state, &[Action::Isolines]);
    assert_eq!(state.scene().settings.isolines, Some(own));
}

#[test]
fn shadings_follow_each_other_and_come_back_as_they_were() {
    let mut state = state();
    let shown = |state: &State| state.scene().settings.analysis;
    for kind in AnalysisKind::ALL {
        press(&mut state, &[Action::Shading]);
        assert_eq!(shown(&state), Some(kind.with_defaults()));
    }
    let limit_degrees = DraftLimit::new(3.0).ok();
    let change = AnalysisChange { limit_degrees, ..AnalysisChange::default() };
    let own = AnalysisKind::Draft.with_defaults().changed(&change).unwrap();
    state.change_settings(|settings| settings.analysis = Some(own));
    press(&mut state, &[Action::Shading]);
    assert_eq!(shown(&state), None);
    press(&mut state, &[Action::Shading; 4]);
    assert_eq!(shown(&state), Some(own));
    state.show_analysis(Some(AnalysisKind::Zebra));
    assert_eq!(shown(&state), Some(AnalysisKind::Zebra.with_defaults()));
}

#[test]
fn what_an_action_changes_is_told() {
    let mut state = state();
    assert!(state.take_changes().scene);
    assert_eq!(state.take_changes(), Changes::default());
    press(&mut state, &[Action::Turn(1, 0)]);
    assert_eq!(state.take_changes(), Changes { picture: true, ..Changes::default() });
    press(&mut state, &[Action::Trim(TrimKind::Circle)]);
    let changes = state.take_changes();
    assert_eq!((changes.scene, changes.trims), (false, vec![0]));
    press(&mut state, &[Action::Help]);
    assert_eq!(state.take_changes(), Changes::default(), "help leaves the picture");
}

#[test]
fn a_drag_moves_one_point_and_is_taken_back_at_once() {
    let mut state = state();
    let start = state.scene.control_points();
    let at = |state: &State, index| {
        let id = PointId { surface: 0, index };
        let point = world_point(&state.scene, id).unwrap();
        on_screen(&state.projection(), state.size, point).unwrap().xy()
    };
    let from = at(&state, 5);
    assert!(state.move_to(from + 3.0, true), "the point is highlighted");
    state.take_changes();
    state.press_button(Button::Left, false);
    for step in 1..=20 {
        let to = from + dvec2(3.0, -2.0) * f64::from(step);
        state.move_to(to, true);
        assert!(at(&state, 5).distance(to) < 1e-6);
        let id = PointId { surface: 0, index: 5 };
        let only = Changes { picture: true, points: vec![id], ..Changes::default() };
        assert_eq!(state.take_changes(), only);
    }
    // Another button neither ends the drag nor begins its own.
    state.press_button(Button::Right, false);
    state.release_button(Button::Right);
    assert!(state.is_moving() && state.pointer.point().is_some());
    state.release_button(Button::Left);
    assert!(!state.is_moving());
    for (index, (before, after)) in std::iter::zip(&start, state.scene.control_points()).enumerate()
    {
        assert_eq!(*before != after, index == 5);
    }
    press(&mut state, &[Action::Undo]);
    assert_eq!(state.scene.control_points(), start);
    press(&mut state, &[Action::Redo]);
    assert!(at(&state, 5).distance(from + dvec2(60.0, -40.0)) < 1e-6);
}

#[test]
fn a_point_that_turns_away_under_the_cursor_is_highlighted_no_more() {
    let hovering = || {
        let mut state = state();
        let id = PointId { surface: 0, index: 0 };
        let point = world_point(&state.scene, id).unwrap();
        let place = on_screen(&state.projection(), state.size, point).unwrap().xy();
        state.move_to(place, true);
        assert_eq!(state.pointer.point(), Some(id));
        state
    };
    let mut turned = hovering();
    press(&mut turned, &[Action::Turn(1, 0)]);
    assert_eq!(turned.pointer.point(), None);
    let mut turning = hovering();
    press(&mut turning, &[Action::Turntable]);
    turning.advance(0.2);
    assert_eq!(turning.pointer.point(), None);
    let mut finer = hovering();
    press(&mut finer, &[Action::Finer]);
    assert!(finer.pointer.point().is_some());
}

#[test]
fn trims_with_numbers_that_are_none_and_edits_of_nothing_change_nothing() {
    let mut state = state();
    let start = state.scene.surfaces[0].trims.clone();
    press(&mut state, &[Action::Trim(TrimKind::Ellipse), Action::Undo]);
    state.take_changes();
    let mut broken = start.clone();
    broken
        .circles
        .push(freeform_surface::Circle { center: dvec2(f64::INFINITY, 0.5), radius: 0.1 });
    assert!(state.edit(vec![Change::Trims(0, Box::new(broken))]).is_err());
    assert!(state.edit(Vec::new()).is_ok());
    assert_eq!(state.scene.surfaces[0].trims, start);
    assert_eq!(state.take_changes(), Changes::default());
    // The undone edit can still be redone.
    press(&mut state, &[Action::Redo]);
    assert_ne!(state.scene.surfaces[0].trims, start);
}

trait ControlPoints {
    fn control_points(&self) -> Vec<glam::DVec4>;
}

impl ControlPoints for Scene {
    fn control_points(&self) -> Vec<glam::DVec4> {
        self.surfaces[0].control_points().to_vec()
    }
}

#[test]
fn the_mouse_turns_moves_and_zooms() {
    let mut state = state();
    let start = state.camera();
    let drag = |state: &mut State, button, shift| {
        state.apply(Action::ResetCamera);
        state.move_to(dvec2(5.0, 5.0), true);
        state.press_button(button, shift);
        state.move_to(dvec2(105.0, 55.0), true);
        state.release_button(button);
        state.camera()
    };
    let turned = drag(&mut state, Button::Left, false);
    assert_eq!(turned.target(), start.target());
    assert!(turned.eye().distance(start.eye()) > 0.1 && turned.eye().y > start.eye().y);
    for (button, shift) in [(Button::Left, true), (Button::Middle, false)] {
        let moved = drag(&mut state, button, shift);
        let by = moved.target() - start.target();
        assert!(by.length() > 0.01 && (moved.eye() - start.eye()).distance(by) < 1e-9);
    }
    let zoomed = drag(&mut state, Button::Right, false);
    assert!(zoomed.eye().distance(zoomed.target()) > start.eye().distance(start.target()));
    state.apply(Action::ResetCamera);
    state.turn_wheel(2.0);
    let near = state.camera();
    assert!(near.eye().distance(near.target()) < start.eye().distance(start.target()));
    // The first camera is restored, for any size of the picture.
    state.apply(Action::ResetCamera);
    assert_eq!(state.camera(), start);
    state.resize(300, 600);
    assert_eq!(state.camera(), Scene::listing16().framed(0.5));
}

#[test]
fn the_thesis_refuses_what_it_cannot_cut_and_nothing_changes() {
    let mut state = state();
    let mut trims = state.scene.surfaces[0].trims.clone();
    trims.add_svg_path("M.1 .1 h.2 v.2 z").unwrap();
    state.edit(vec![Change::Trims(0, Box::new(trims))]).unwrap();
    let scene = state.scene.clone();
    assert_eq!(state.apply(Action::Method), None);
    assert!(matches!(&state.message, Some(Message::Error(text)) if text.contains("surface 0")));
    assert_eq!(state.scene, scene);
    let mut thesis = State::new(Scene::listing16(), None);
    press(&mut thesis, &[Action::Method]);
    let before = thesis.scene.surfaces[0].trims.clone();
    assert!(
        thesis
            .edit(vec![Change::Trims(
                0,
                Box::new(Trims { keep: Keep::Outside, ..scene.surfaces[0].trims.clone() })
            )])
            .is_err()
    );
    assert_eq!(thesis.scene.surfaces[0].trims, before);
}

#[test]
fn meshes_are_smoothed_and_surfaces_say_that_they_are_none() {
    let mut state = State::new(mesh(), None);
    let smoothing = |state: &State| state.scene.meshes[0].smoothing();
    press(&mut state, &[Action::Pn]);
    assert_eq!(smoothing(&state), Smoothing::Pn);
    press(&mut state, &[Action::Phong]);
    assert_eq!(smoothing(&state), Smoothing::Phong(Alpha::default()));
    press(&mut state, &[Action::Phong]);
    assert_eq!(smoothing(&state), Smoothing::None);
    let mut state = self::state();
    state.apply(Action::Pn);
    assert!(matches!(&state.message, Some(Message::Error(text)) if text.contains("mesh")));
}

#[test]
fn pictures_go_and_come_back() {
    let mut state = state();
    let with = state.scene.surfaces[0].paint.clone();
    press(&mut state, &[Action::Texture]);
    assert!(matches!(state.scene.surfaces[0].paint, Paint::Color(_)));
    press(&mut state, &[Action::Texture]);
    assert_eq!(state.scene.surfaces[0].paint, with);
    let green = Paint::Color([0.0, 1.0, 0.0]);
    let mut scene = Scene::listing16();
    scene.surfaces[0].paint = green.clone();
    let mut state = State::new(scene, None);
    press(&mut state, &[Action::Texture]);
    assert_eq!(state.scene.surfaces[0].paint, with, "bricks");
    press(&mut state, &[Action::Texture]);
    assert_eq!(state.scene.surfaces[0].paint, green);
}

#[test]
fn a_file_that_changes_keeps_the_camera() {
    let mut state = state();
    press(&mut state, &[Action::LookFrom(Side::Right)]);
    let camera = state.camera();
    let mut changed = Scene::listing16();
    changed.surfaces[0].shading = Shading::Normals;
    state.reload(changed);
    assert_eq!(state.camera(), camera);
    assert_eq!(state.scene.surfaces[0].shading, Shading::Normals);
}

/// A random event, as users and window systems send them.
pub(crate) fn random_event(state: &mut State, random: &mut Random) {
    let actions: Vec<Action> =
        BINDINGS.iter().flat_map(Binding::keys_and_actions).map(|(_, action)| *action).collect();
    let place = dvec2(random.below(1400) as f64 - 200.0, random.below(900) as f64 - 150.0);
    match random.below(10) {
        0..=3 => {
            state.note_press();
            state.apply(actions[random.below(actions.len())]);
        }
        4..=6 => drop(state.move_to(place, random.below(4) > 0)),
        7 => {
            let button = [Button::Left, Button::Middle, Button::Right][random.below(3)];
            state.press_button(button, random.below(3) == 0);
        }
        8 => state.release_button([Button::Left, Button::Middle, Button::Right][random.below(3)]),
        _ => match random.below(5) {
            0 => state.resize(random.below(1000) as u32, random.below(600) as u32),
            1 => state.turn_wheel([1.0, -1.0, 1e300, -0.01][random.below(4)]),
            2 => state.advance(0.05),
            3 => drop(state.leave()),
            _ if random.below(40) == 0 => state.open(Scene::listing16(), None),
            _ if random.below(40) == 0 => state.open(mesh(), None),
            _ => state.selected = 0,
        },
    }
}

#[test]
fn ten_thousand_random_events_leave_a_scene_that_can_be_drawn() {
    let mut state = state();
    let mut random = Random(1);
    for number in 0..10_000 {
        random_event(&mut state, &mut random);
        let seen = state.projection();
        assert!(seen.view.is_finite() && seen.projection.is_finite(), "event {number}");
        let surfaces = &state.scene.surfaces;
        assert!(
            surfaces.iter().all(|surface| surface.world_points().all(|point| point.is_finite()))
        );
    }
}
