//! Clicks on CAD models, colours and hidden faces, without a window.

use std::path::{Path, PathBuf};

use freeform_surface::inspect::measure::Random;
use freeform_surface::{Camera, Lens, Paint};
use glam::dvec2;

use super::super::action::{Action, TrimKind};
use super::super::pointer::Button;
use super::super::state::tests::random_event;
use super::*;

fn model(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("resources/models").join(name)
}

fn state(name: &str) -> State {
    let path = model(name);
    let mut state = State::new(Scene::load(&path).unwrap(), Some(path));
    state.take_changes();
    state
}

fn click(state: &mut State, place: DVec2) -> Option<String> {
    state.move_to(place, true);
    state.press_button(Button::Left, false);
    state.release_button(Button::Left);
    state.picked.as_ref().map(|picked| picked.facts.clone())
}

/// Clicks on places all over the picture until the facts say this.
fn place_of(state: &mut State, text: &str) -> DVec2 {
    let mut all = (0..250).map(|i| dvec2(f64::from(i % 10), f64::from(i / 10)) * dvec2(97.0, 23.0));
    let is_it = |place: &DVec2| click(state, *place).is_some_and(|facts| facts.contains(text));
    all.find(is_it).expect("such a face is visible")
}

#[test]
fn a_click_names_the_face_under_the_cursor() {
    let mut state = state("flange.ffm");
    let before = state.scene().clone();
    let place = place_of(&mut state, ": plane, degrees 1 × 1, 1 patch, ");
    let facts = click(&mut state, place).unwrap();
    assert!(facts.ends_with(" mm²"), "{facts}");
    assert_eq!(state.message, Some(Message::Done(facts)));
    let picked = state.picked.clone().unwrap();
    assert_eq!(picked.surface, state.selected);
    let outline: Vec<&DVec3> = picked.outline.iter().flatten().collect();
    assert!(outline.len() > 8 && outline.iter().all(|point| point.is_finite()));
    place_of(&mut state, ": cylinder, degrees ");
    assert_eq!(click(&mut state, dvec2(1.0, 1.0)), None, "beside the model");
    assert_eq!(state.message, None);
    assert_eq!(*state.scene(), Scene { camera: state.scene().camera, ..before });
    // A drag turns the camera and selects nothing.
    state.move_to(place, true);
    state.press_button(Button::Left, false);
    assert!(!state.move_to(place + 1.0, true), "the hand is not steady");
    assert!(state.move_to(place + 5.0, true));
    state.move_to(place, true);
    state.release_button(Button::Left);
    assert_eq!(state.picked, None);
}

#[test]
fn areas_are_those_of_the_place_in_the_model() {
    // In the assembly, faces are used in several places, one of which is mirrored.
    let mut state = state("assembly.ffm");
    let scene = state.scene().clone();
    let area = |picked: Picked| {
        let number = picked.facts.rsplit(", ").next().unwrap().split(' ').next().unwrap();
        number.parse::<f64>().unwrap()
    };
    let mut larger = scene.clone();
    for surface in &mut larger.surfaces {
        surface.transform = DMat4::from_scale(DVec3::splat(3.0)) * surface.transform;
    }
    for number in 0..scene.surfaces.len() {
        let own = area(Picked::new(&scene, number).unwrap());
        let large = area(Picked::new(&larger, number).unwrap());
        assert!((large / own - 9.0).abs() < 0.02, "{own} {large}");
    }
    // The scale of the whole model in the scene is no part of the model.
    larger.models[0].transform = DMat4::from_scale(DVec3::splat(3.0));
    for number in 0..scene.surfaces.len() {
        assert_eq!(Picked::new(&larger, number).map(area), Picked::new(&scene, number).map(area));
    }
    state.select(Some(scene.surfaces.len() - 1));
    assert!(state.picked.unwrap().facts.contains(" (in place "));
}

#[test]
fn numbers_have_four_digits() {
    for (value, text) in [
        (0.0, "0.000"),
        (1234.5678, "1235"),
        (999.96, "1000"),
        (99.996, "100.0"),
        (0.012_345_67, "0.01235"),
        (1_234_567.0, "1235000"),
        (1.234_56e9, "1.235e9"),
        (1.234_56e-5, "1.235e-5"),
    ] {
        assert_eq!(four_digits(value), text);
    }
}

#[test]
fn hidden_faces_are_not_clicked_and_come_back() {
    let mut state = state("flange.ffm");
    let start = state.scene().clone();
    let place = place_of(&mut state, ": plane");
    click(&mut state, place);
    let number = state.selected;
    state.note_press();
    assert_eq!(state.apply(Action::Hide), None);
    assert_eq!((state.hidden_count(), state.picked.clone()), (1, None));
    let changes = state.take_changes();
    assert_eq!((changes.scene, changes.styles), (false, vec![number]));
    click(&mut state, place);
    assert!(state.picked.as_ref().is_none_or(|picked| picked.surface != number));
    state.note_press();
    state.apply(Action::Undo);
    click(&mut state, place);
    assert_eq!((state.hidden_count(), state.selected), (0, number));
    state.apply(Action::Redo);
    assert_eq!(state.hidden_count(), 1);
    state.note_press();
    state.apply(Action::ShowAll);
    assert_eq!(state.scene().surfaces, start.surfaces);
    state.apply(Action::Undo);
    assert_eq!(state.hidden_count(), 1);
    // Without a click there is nothing to hide.
    state.select(None);
    state.apply(Action::Hide);
    assert!(matches!(&state.message, Some(Message::Error(text)) if text.contains("click")));
}

#[test]
fn colours_and_hidden_faces_are_saved() {
    for name in ["flange.ffm", "assembly.ffm"] {
        let mut state = state(name);
        let count = state.scene().surfaces.len();
        let green = Paint::Color([0.0, 0.5, 0.25]);
        state.edit(vec![Change::SurfacePaint(count - 1, green)]).unwrap();
        state.edit(vec![Change::Hidden(1, true), Change::Hidden(count - 2, true)]).unwrap();
        let path = model("saved.toml");
        let saved = state.saved_scene();
        let written = saved.to_toml(&path).unwrap();
        assert!(written.files.is_empty());
        let again = Scene::from_toml(&written.text, &path).unwrap();
        assert_eq!(again.surfaces, saved.surfaces, "{}", written.text);
        assert!(written.text.contains(&format!("hide = [1, {}]", count - 2)), "{}", written.text);
        // Without the edits, nothing is written about single faces.
        let plain = Scene::load(&model(name)).unwrap().to_toml(&path).unwrap().text;
        assert!(!plain.contains("hide") && !plain.contains("colors"), "{plain}");
    }
}

#[test]
fn the_shape_of_a_cad_model_is_not_edited() {
    let mut state = state("bracket.ffm");
    let start = state.scene().surfaces.clone();
    for action in [
        Action::Trim(TrimKind::Circle),
        Action::Trim(TrimKind::Loop),
        Action::Trim(TrimKind::Nested),
        Action::Texture,
    ] {
        state.apply(action);
        let told = matches!(&state.message, Some(Message::Error(text)) if text.contains("CAD"));
        assert!(told, "{action:?}: {:?}", state.message);
    }
    state.apply(Action::Wireframe);
    let settings = state.scene().settings;
    assert!(settings.wireframe && !settings.control_points);
    // Their control points are not under the cursor.
    for x in 0..100 {
        for y in 0..60 {
            state.move_to(dvec2(f64::from(x), f64::from(y)) * 10.0, true);
            assert_eq!(state.pointer.point(), None);
        }
    }
    assert_eq!(state.scene().surfaces, start);
    // Beside a model, surfaces are edited as ever.
    let mut scene = state.scene().clone();
    scene.surfaces.push(Scene::listing16().surfaces.remove(0));
    let mut state = State::new(scene, None);
    state.apply(Action::Texture);
    assert_eq!(state.message, None);
    let (own, faces) = state.scene().surfaces.split_last().unwrap();
    assert!(matches!(own.paint, Paint::Color(_)));
    assert_eq!(faces, start);
}

#[test]
fn clicks_from_anywhere_do_no_harm() {
    let mut random = Random(7);
    let mut state = state("blade.ffm");
    let start: Vec<_> = state.scene().surfaces.iter().map(|face| face.trims.clone()).collect();
    for _ in 0..80 {
        // Not those that open other scenes.
        if state.scene().models.is_empty() {
            state = self::state("blade.ffm");
        }
        random_event(&mut state, &mut random);
        let place = dvec2(random.below(1000) as f64, random.below(600) as f64);
        state.pick_surface(place);
    }
    if !state.scene().models.is_empty() {
        let now = state.scene().surfaces.iter().map(|face| &face.trims);
        assert!(now.eq(&start));
    }
    // The eye in the middle of the model, and nothing at all.
    let mut state = self::state("flange.ffm");
    let lens = Lens::Perspective { fov_y_radians: 1.0 };
    let camera = Camera::new(DVec3::ZERO, DVec3::X, DVec3::Z, lens).unwrap();
    state.look(Ok(camera)).unwrap();
    state.pick_surface(dvec2(500.0, 300.0));
    let mut empty = State::new(Scene::default(), None);
    assert_eq!(click(&mut empty, dvec2(500.0, 300.0)), None);
    empty.apply(Action::Fit);
    empty.apply(Action::Trim(TrimKind::Circle));
    assert!(empty.projection().projection.is_finite());
}
