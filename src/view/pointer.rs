//! The mouse over the picture: what a press begins, and what moving makes of it.

use std::f64::consts::PI;

use glam::{DVec2, dvec2};

use super::camera;
use super::pick::{PointId, dragged, pick};
use super::state::{State, ZOOM};
use super::undo::Part;

/// How much nearer dragging over the whole height of the picture brings, as a power of e.
const DRAG_ZOOM: f64 = 4.0;

/// A button of the mouse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Button {
    Left,
    Middle,
    Right,
}

/// What a held button does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
enum Gesture {
    #[default]
    None,
    Turn,
    Pan,
    /// Around the place where it began.
    Zoom(DVec2),
    Move(PointId),
}

/// Where the cursor is and what it does.
#[derive(Debug, Default)]
pub(crate) struct Pointer {
    /// Pixels from the upper left corner.
    place: DVec2,
    gesture: Gesture,
    /// The button that began it.
    held: Option<Button>,
    hovered: Option<PointId>,
}

impl Pointer {
    /// The control point under the cursor or in its grip.
    pub(crate) const fn point(&self) -> Option<PointId> {
        match self.gesture {
            Gesture::Move(id) => Some(id),
            Gesture::None => self.hovered,
            _ => None,
        }
    }

    /// Pixels from the upper left corner.
    pub(crate) const fn place(&self) -> DVec2 {
        self.place
    }

    /// Whether a button is held.
    pub(crate) fn is_busy(&self) -> bool {
        self.gesture != Gesture::None
    }

    /// Ends whatever is under way.
    pub(crate) const fn let_go(&mut self) {
        self.gesture = Gesture::None;
        self.held = None;
        self.hovered = None;
    }
}

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
                self.edit(point.map(|point| Part::Point(id, point)).into_iter().collect())
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

    /// What was under the cursor may have moved away without it.
    pub(super) fn hover_again(&mut self) {
        if self.pointer.hovered.is_some() {
            self.hover();
        }
    }

    /// Finds the control point under the cursor; true if that is another one.
    fn hover(&mut self) -> bool {
        let found = pick(self.scene(), &self.projection(), self.size(), self.pointer.place);
        std::mem::replace(&mut self.pointer.hovered, found) != found
    }
}
