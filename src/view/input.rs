//! Keys and buttons of the window system, translated into those of the table of actions.

use winit::event::{MouseButton, MouseScrollDelta};
use winit::keyboard::{self, ModifiersState, NamedKey};

use super::action::{Chord, Key, Modifiers};
use super::pointer::Button;

/// Pixels of a touchpad that count as one step of a wheel.
const WHEEL_STEP_PX: f64 = 40.0;

/// A pressed key, if the table may contain it.
pub(super) fn chord(key: &keyboard::Key, modifiers: ModifiersState) -> Option<Chord> {
    let key = match key {
        keyboard::Key::Character(text) => Key::Char(text.chars().next()?),
        keyboard::Key::Named(named) => match named {
            NamedKey::ArrowUp => Key::Up,
            NamedKey::ArrowDown => Key::Down,
            NamedKey::ArrowLeft => Key::Left,
            NamedKey::ArrowRight => Key::Right,
            NamedKey::PageUp => Key::PageUp,
            NamedKey::PageDown => Key::PageDown,
            NamedKey::Space => Key::Space,
            NamedKey::Tab => Key::Tab,
            NamedKey::Enter => Key::Enter,
            NamedKey::Escape => Key::Escape,
            NamedKey::F1 => Key::F1,
            NamedKey::F12 => Key::F12,
            _ => return None,
        },
        _ => return None,
    };
    // Keys with Alt or with the window system's own modifier belong to other programs.
    if modifiers.alt_key() || modifiers.super_key() {
        return None;
    }
    let modifiers = Modifiers { ctrl: modifiers.control_key(), shift: modifiers.shift_key() };
    Some(Chord { key, modifiers })
}

/// A mouse button, if it has an effect.
pub(super) const fn button(button: MouseButton) -> Option<Button> {
    match button {
        MouseButton::Left => Some(Button::Left),
        MouseButton::Middle => Some(Button::Middle),
        MouseButton::Right => Some(Button::Right),
        _ => None,
    }
}

/// Steps of the wheel; positive values are away from the user.
pub(super) fn wheel_steps(delta: MouseScrollDelta) -> f64 {
    let steps = match delta {
        MouseScrollDelta::LineDelta(_, lines) => f64::from(lines),
        MouseScrollDelta::PixelDelta(pixels) => pixels.y / WHEEL_STEP_PX,
    };
    if steps.is_finite() { steps } else { 0.0 }
}
