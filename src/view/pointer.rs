//! The place of the mouse over the picture, and its current gesture.

use glam::DVec2;

use super::pick::PointId;

/// A button of the mouse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Button {
    Left,
    Middle,
    Right,
}

/// The gesture of a held button.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) enum Gesture {
    #[default]
    None,
    Turn,
    Pan,
    /// Zooms around the place where the gesture began.
    Zoom(DVec2),
    Move(PointId),
}

/// The place of the cursor and its gesture.
#[derive(Debug, Default)]
pub(crate) struct Pointer {
    /// Pixels from the upper left corner.
    pub(super) place: DVec2,
    pub(super) gesture: Gesture,
    /// The button that began the gesture.
    pub(super) held: Option<Button>,
    /// Whether the press is a click until now: the cursor has not moved.
    pub(super) is_click: bool,
    pub(super) hovered: Option<PointId>,
}

impl Pointer {
    /// The control point under the cursor, or the one that is being dragged.
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

    /// Ends the current gesture.
    pub(crate) const fn let_go(&mut self) {
        self.gesture = Gesture::None;
        self.held = None;
        self.hovered = None;
    }
}
