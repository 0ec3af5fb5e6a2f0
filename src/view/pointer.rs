//! Where the mouse is over the picture, and what it holds.

use glam::DVec2;

use super::pick::PointId;

/// A button of the mouse.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Button {
    Left,
    Middle,
    Right,
}

/// What a held button does.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) enum Gesture {
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
    pub(super) place: DVec2,
    pub(super) gesture: Gesture,
    /// The button that began it.
    pub(super) held: Option<Button>,
    pub(super) hovered: Option<PointId>,
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
