//! The mouse over the picture: the gesture that a press begins, and the effect of moving the mouse.

use std::f64::consts::PI;

use glam::{DVec2, dvec2};

use super::camera;
use super::pick::dragged;
use super::pointer::{Button, Gesture};
use super::state::{State, ZOOM};
use super::undo::Change;

/// Dragging over the whole height of the picture zooms by e to this power.
const DRAG_ZOOM: f64 = 4.0;
/// The largest distance in pixels that the cursor moves during a click.
const CLICK_PX: f64 = 2.0;

impl State {
    /// Presses a button at the cursor. This does nothing while another button is held.
    pub(crate) fn press_button(&mut self, button: Button, shift: bool) {
        if self.pointer.held.is_some() {
            return;
        }
        self.pointer.held = Some(button);
        self.pointer.is_click = button == Button::Left && !shift;
        self.note_press();
        self.hover();
        let pointer = &mut self.pointer;
        pointer.gesture = match (button, shift, pointer.hovered) {
            (Button::Left, false, Some(id)) => Gesture::Move(id),
            (Button::Left, false, None) => Gesture::Turn,
            (Button::Left, true, _) | (Button::Middle, _, _) => Gesture::Pan,
            (Button::Right, _, _) => Gesture::Zoom(pointer.place),
        };
        if let Gesture::Move(id) = self.pointer.gesture {
            self.selected = id.surface;
        }
    }

    /// Releases a button.
    pub(crate) fn release_button(&mut self, button: Button) {
        if self.pointer.held == Some(button) {
            self.pointer.held = None;
            let gesture = std::mem::take(&mut self.pointer.gesture);
            if self.pointer.is_click && gesture == Gesture::Turn {
                self.pick_surface(self.pointer.place);
            }
            self.hover();
        }
    }

    /// The cursor leaves the picture; returns true if something was under it.
    pub(crate) const fn leave(&mut self) -> bool {
        self.pointer.hovered.take().is_some()
    }

    /// The cursor moves, over the picture or the panel; returns true if this has a visible effect.
    pub(crate) fn move_to(&mut self, place: DVec2, over_picture: bool) -> bool {
        let pointer = &mut self.pointer;
        if pointer.is_click && pointer.gesture == Gesture::Turn {
            if place.distance(pointer.place) <= CLICK_PX {
                return false;
            }
            pointer.is_click = false;
        }
        let by = (place - self.pointer.place) * dvec2(1.0, -1.0) / self.size().y;
        self.pointer.place = place;
        if self.pointer.gesture == Gesture::None {
            return if over_picture { self.hover() } else { self.leave() };
        }
        let camera = self.hold_camera();
        let done = match self.pointer.gesture {
            Gesture::None => Ok(()),
            // The side that faces the viewer follows the cursor.
            Gesture::Turn => self.look(self.mover().turn(&camera, -by * PI)),
            Gesture::Pan => self.look(camera::pan(&camera, -by)),
            Gesture::Zoom(from) => {
                let factor = (-by.y * DRAG_ZOOM).exp();
                self.look(camera::zoom(&camera, factor, self.off_middle(from)))
            }
            Gesture::Move(id) => {
                let point = dragged(self.scene(), id, &self.projection(), self.size(), place);
                self.edit(point.map(|point| Change::Point(id, point)).into_iter().collect())
            }
        };
        self.report(done);
        true
    }

    /// Turns the wheel; positive values zoom in.
    pub(crate) fn turn_wheel(&mut self, steps: f64) {
        let camera = self.hold_camera();
        // A broken device may send any value.
        let factor = ZOOM.powf(steps.clamp(-20.0, 20.0));
        let looked = self.look(camera::zoom(&camera, factor, self.off_middle(self.pointer.place)));
        self.report(looked);
        self.hover();
    }

    /// A place measured from the centre of the picture, in fractions of its height, upwards.
    fn off_middle(&self, place: DVec2) -> DVec2 {
        (place - 0.5 * self.size()) * dvec2(1.0, -1.0) / self.size().y
    }
}
