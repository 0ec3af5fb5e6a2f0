//! The mouse over the picture: what a press begins, and what moving makes of it.

use std::f64::consts::PI;

use glam::{DVec2, dvec2};

use super::camera;
use super::pick::dragged;
use super::pointer::{Button, Gesture};
use super::state::{State, ZOOM};
use super::undo::Change;

/// How much nearer dragging over the whole height of the picture brings, as a power of e.
const DRAG_ZOOM: f64 = 4.0;

impl State {
    /// A button goes down where the cursor is; beside one that is held it does nothing.
    pub(crate) fn press_button(&mut self, button: Button, shift: bool) {
        if self.pointer.held.is_some() {
            return;
        }
        self.pointer.held = Some(button);
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

    /// A button goes up.
    pub(crate) fn release_button(&mut self, button: Button) {
        if self.pointer.held == Some(button) {
            self.pointer.held = None;
            self.pointer.gesture = Gesture::None;
            self.hover();
        }
    }

    /// The cursor leaves the picture; true if something was under it.
    pub(crate) const fn leave(&mut self) -> bool {
        self.pointer.hovered.take().is_some()
    }

    /// The cursor moves, over the picture or the panel; true if anything is to be shown of that.
    pub(crate) fn move_to(&mut self, place: DVec2, over_picture: bool) -> bool {
        let by = (place - self.pointer.place) * dvec2(1.0, -1.0) / self.size().y;
        self.pointer.place = place;
        if self.pointer.gesture == Gesture::None {
            return if over_picture { self.hover() } else { self.leave() };
        }
        let camera = self.hold_camera();
        let done = match self.pointer.gesture {
            Gesture::None => Ok(()),
            // What is in front follows the cursor.
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

    /// The wheel turns; above 0 is nearer.
    pub(crate) fn turn_wheel(&mut self, steps: f64) {
        let camera = self.hold_camera();
        // A broken device may send anything.
        let factor = ZOOM.powf(steps.clamp(-20.0, 20.0));
        let looked = self.look(camera::zoom(&camera, factor, self.off_middle(self.pointer.place)));
        self.report(looked);
        self.hover();
    }

    /// A place counted from the middle of the picture, in parts of its height, up.
    fn off_middle(&self, place: DVec2) -> DVec2 {
        (place - 0.5 * self.size()) * dvec2(1.0, -1.0) / self.size().y
    }
}
