//! What keys do: one table, from which the window takes its actions, and the help, the README and
//! `freeform view --list-bindings` their lists.

use std::fmt;

/// Something that a key asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Action {
    /// One level finer.
    Finer,
    /// One level coarser.
    Coarser,
    /// From one level back to the tolerance.
    UseTolerance,
    /// The next larger tolerance.
    LargerTolerance,
    /// The next smaller tolerance.
    SmallerTolerance,
    /// Lines and control points.
    Wireframe,
    /// A kind of trims on or off.
    Trim(TrimKind),
    /// The other method.
    Method,
    /// Pictures on or off.
    Texture,
    /// Phong tessellation of meshes on or off.
    Phong,
    /// Curved PN triangles of meshes on or off.
    Pn,
    /// The turntable stops or starts.
    Turntable,
    /// The camera as the scene has it.
    ResetCamera,
    /// The camera sees everything.
    Fit,
    /// The camera looks along an axis.
    LookFrom(Side),
    /// From perspective to orthographic and back.
    Orthographic,
    /// The camera turns by a step: to the right, and up.
    Turn(i8, i8),
    /// The camera moves by a step: to the right, and up.
    Pan(i8, i8),
    /// Moves the camera nearer by this number of steps.
    Zoom(i8),
    /// The next scene of the folder.
    NextScene,
    /// A picture beside the scene.
    Screenshot,
    /// The scene into a file.
    Save,
    /// The last edit is taken back.
    Undo,
    /// What was taken back is done again.
    Redo,
    /// Help, then nothing, then the panel.
    Help,
    /// The program ends.
    Quit,
}

/// Kinds of trims, as the keys tell them apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum TrimKind {
    /// Circles.
    Circle,
    /// Intervals.
    Rect,
    /// Ellipses.
    Ellipse,
    /// All loops.
    Loop,
    /// Loops inside loops.
    Nested,
}

/// Where a camera may look from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    /// From the front.
    Front,
    /// From the right.
    Right,
    /// From above.
    Top,
}

/// A key, whatever window system it came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Key {
    /// A key that writes; letters are small.
    Char(char),
    Up,
    Down,
    Left,
    Right,
    PageUp,
    PageDown,
    Space,
    Tab,
    Enter,
    Escape,
    F1,
    F12,
}

/// The keys that are held besides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Modifiers {
    pub(crate) ctrl: bool,
    pub(crate) shift: bool,
}

/// A key with its modifiers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Chord {
    pub(crate) key: Key,
    pub(crate) modifiers: Modifiers,
}

/// One line of the table: several keys, each with its action, and what they do.
#[derive(Debug)]
pub(crate) struct Binding {
    keys: &'static [(Chord, Action)],
    help: &'static str,
}

const fn plain(key: Key) -> Chord {
    Chord { key, modifiers: Modifiers { ctrl: false, shift: false } }
}

const fn letter(letter: char) -> Chord {
    plain(Key::Char(letter))
}

const fn shift(key: Key) -> Chord {
    Chord { key, modifiers: Modifiers { ctrl: false, shift: true } }
}

const fn ctrl(letter: char) -> Chord {
    Chord { key: Key::Char(letter), modifiers: Modifiers { ctrl: true, shift: false } }
}

const fn ctrl_shift(letter: char) -> Chord {
    Chord { key: Key::Char(letter), modifiers: Modifiers { ctrl: true, shift: true } }
}

/// All keys.
pub(crate) const BINDINGS: &[Binding] = &[
    Binding {
        keys: &[(plain(Key::Up), Action::Finer), (plain(Key::Down), Action::Coarser)],
        help: "one level for all, 1 to 50: finer, coarser",
    },
    Binding { keys: &[(letter('t'), Action::UseTolerance)], help: "back to the tolerance" },
    Binding {
        keys: &[(letter('+'), Action::LargerTolerance), (letter('-'), Action::SmallerTolerance)],
        help: "larger or smaller tolerance",
    },
    Binding {
        keys: &[(letter('w'), Action::Wireframe)],
        help: "wireframe: red lines, blue control points",
    },
    Binding { keys: &[(letter('c'), Action::Trim(TrimKind::Circle))], help: "circle on, off" },
    Binding { keys: &[(letter('i'), Action::Trim(TrimKind::Rect))], help: "interval on, off" },
    Binding { keys: &[(letter('l'), Action::Trim(TrimKind::Ellipse))], help: "ellipse on, off" },
    Binding { keys: &[(letter('b'), Action::Trim(TrimKind::Loop))], help: "Bézier loop on, off" },
    Binding { keys: &[(letter('n'), Action::Trim(TrimKind::Nested))], help: "nested loop on, off" },
    Binding { keys: &[(letter('m'), Action::Method)], help: "method: thesis or exact" },
    Binding { keys: &[(letter('x'), Action::Texture)], help: "texture on, off" },
    Binding { keys: &[(letter('p'), Action::Phong)], help: "Phong tessellation of meshes on, off" },
    Binding { keys: &[(letter('e'), Action::Pn)], help: "curved PN triangles of meshes on, off" },
    Binding { keys: &[(plain(Key::Space), Action::Turntable)], help: "turntable on, off" },
    Binding { keys: &[(plain(Key::Tab), Action::NextScene)], help: "next scene of the folder" },
    Binding {
        keys: &[(letter('r'), Action::ResetCamera), (plain(Key::Enter), Action::ResetCamera)],
        help: "the scene's camera",
    },
    Binding { keys: &[(letter('f'), Action::Fit)], help: "fit: see everything" },
    Binding {
        keys: &[
            (letter('1'), Action::LookFrom(Side::Front)),
            (letter('3'), Action::LookFrom(Side::Right)),
            (letter('7'), Action::LookFrom(Side::Top)),
        ],
        help: "look from the front, the right, the top",
    },
    Binding { keys: &[(letter('5'), Action::Orthographic)], help: "orthographic or perspective" },
    Binding {
        keys: &[(plain(Key::Left), Action::Turn(-1, 0)), (plain(Key::Right), Action::Turn(1, 0))],
        help: "turn the camera",
    },
    Binding {
        keys: &[(plain(Key::PageUp), Action::Zoom(1)), (plain(Key::PageDown), Action::Zoom(-1))],
        help: "nearer, farther",
    },
    Binding {
        keys: &[
            (shift(Key::Up), Action::Pan(0, 1)),
            (shift(Key::Down), Action::Pan(0, -1)),
            (shift(Key::Left), Action::Pan(-1, 0)),
            (shift(Key::Right), Action::Pan(1, 0)),
        ],
        help: "move the camera",
    },
    Binding { keys: &[(ctrl('z'), Action::Undo)], help: "undo" },
    Binding { keys: &[(ctrl_shift('z'), Action::Redo)], help: "redo" },
    Binding { keys: &[(ctrl('s'), Action::Save)], help: "save the scene beside its file" },
    Binding { keys: &[(plain(Key::F12), Action::Screenshot)], help: "picture beside the scene" },
    Binding {
        keys: &[(letter('h'), Action::Help), (plain(Key::F1), Action::Help)],
        help: "help, then nothing, then the panel",
    },
    Binding {
        keys: &[(plain(Key::Escape), Action::Quit), (ctrl('q'), Action::Quit)],
        help: "quit",
    },
];

/// What the mouse does, for the same lists.
pub(crate) const MOUSE: &[(&str, &str)] = &[
    ("left drag", "turn the camera; on a highlighted control point, move it"),
    ("Shift + left drag, middle drag", "move the camera"),
    ("wheel, right drag", "zoom to the cursor"),
    ("drop a file", "open it"),
];

impl Action {
    /// What a key asks for, if anything.
    pub(crate) fn of(chord: Chord) -> Option<Self> {
        let chord = chord.normalized();
        BINDINGS
            .iter()
            .flat_map(Binding::keys_and_actions)
            .find(|(bound, _)| *bound == chord)
            .map(|(_, action)| *action)
    }

    /// Whether holding the key down does it again and again.
    pub(crate) const fn repeats(self) -> bool {
        matches!(
            self,
            Self::Finer
                | Self::Coarser
                | Self::LargerTolerance
                | Self::SmallerTolerance
                | Self::Turn(..)
                | Self::Pan(..)
                | Self::Zoom(_)
                | Self::Undo
                | Self::Redo
        )
    }
}

impl Chord {
    /// As the table has it: small letters, and no shift where it only serves to write the character.
    fn normalized(self) -> Self {
        let Key::Char(char) = self.key else { return self };
        let ctrl = self.modifiers.ctrl;
        let shift = self.modifiers.shift && ctrl && char.is_alphabetic();
        let char = match char {
            // The same key without shift.
            '=' => '+',
            '_' => '-',
            _ => char.to_lowercase().next().unwrap_or(char),
        };
        Self { key: Key::Char(char), modifiers: Modifiers { ctrl, shift } }
    }
}

impl fmt::Display for Chord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.modifiers.ctrl {
            f.write_str("Ctrl+")?;
        }
        if self.modifiers.shift {
            f.write_str("Shift+")?;
        }
        match self.key {
            Key::Char('-') => f.write_str("−"),
            Key::Char(char) => write!(f, "{}", char.to_uppercase()),
            Key::PageUp => f.write_str("Page Up"),
            Key::PageDown => f.write_str("Page Down"),
            Key::Escape => f.write_str("Esc"),
            key => write!(f, "{key:?}"),
        }
    }
}

impl Binding {
    /// The keys and what each of them does.
    pub(crate) fn keys_and_actions(&self) -> impl Iterator<Item = &'static (Chord, Action)> {
        self.keys.iter()
    }

    /// The keys as a person reads them.
    pub(crate) fn keys(&self) -> String {
        let keys: Vec<String> = self.keys.iter().map(|(chord, _)| chord.to_string()).collect();
        keys.join(", ")
    }
}

/// Keys and mouse with what they do, line by line.
pub(crate) fn lines() -> impl Iterator<Item = (String, &'static str)> {
    let keys = BINDINGS.iter().map(|binding| (binding.keys(), binding.help));
    keys.chain(MOUSE.iter().map(|(what, help)| ((*what).to_owned(), *help)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(key: Key, ctrl: bool, shift: bool) -> Option<Action> {
        Action::of(Chord { key, modifiers: Modifiers { ctrl, shift } })
    }

    #[test]
    fn no_key_is_bound_twice() {
        let chords: Vec<Chord> =
            BINDINGS.iter().flat_map(Binding::keys_and_actions).map(|(chord, _)| *chord).collect();
        for (i, chord) in chords.iter().enumerate() {
            assert!(!chords[..i].contains(chord), "{chord}");
            assert_eq!(chord.normalized(), *chord, "{chord} can never be pressed");
        }
    }

    #[test]
    fn shift_counts_where_it_means_something() {
        assert_eq!(of(Key::Char('W'), false, true), Some(Action::Wireframe));
        assert_eq!(of(Key::Char('+'), false, true), Some(Action::LargerTolerance));
        assert_eq!(of(Key::Char('='), false, false), Some(Action::LargerTolerance));
        assert_eq!(of(Key::Char('z'), true, false), Some(Action::Undo));
        assert_eq!(of(Key::Char('Z'), true, true), Some(Action::Redo));
        assert_eq!(of(Key::Up, false, true), Some(Action::Pan(0, 1)));
        assert_eq!(of(Key::Up, false, false), Some(Action::Finer));
        assert_eq!(of(Key::Char('w'), true, false), None);
        assert_eq!(of(Key::Char('q'), false, false), None);
    }

    #[test]
    fn the_readme_has_the_table() {
        let readme = include_str!("../../README.md");
        for (keys, help) in lines() {
            let line = format!("| {keys} | {help} |");
            assert!(readme.contains(&line), "README.md lacks the line\n{line}");
        }
    }
}
