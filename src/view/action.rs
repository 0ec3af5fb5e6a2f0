//! The table of keys and their actions. The window takes its actions from it, and the help, the README and
//! `freeform view --list-bindings` take their lists from it.

use std::fmt;

/// An action that a key triggers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Action {
    /// One level finer.
    Finer,
    /// One level coarser.
    Coarser,
    /// Returns from one level for all patches to the tolerance.
    UseTolerance,
    /// The next larger tolerance.
    LargerTolerance,
    /// The next smaller tolerance.
    SmallerTolerance,
    /// Wireframe and control points on or off.
    Wireframe,
    /// Lines along the edges of CAD models on or off.
    Edges,
    /// Lines of equal u and of equal v on or off.
    Isolines,
    /// The next kind of shading.
    Shading,
    /// A kind of trims on or off.
    Trim(TrimKind),
    /// Switches to the other method.
    Method,
    /// Textures on or off.
    Texture,
    /// Phong tessellation of meshes on or off.
    Phong,
    /// Curved PN triangles of meshes on or off.
    Pn,
    /// The turntable stops or starts.
    Turntable,
    /// Returns to the scene's camera.
    ResetCamera,
    /// Moves the camera so that it sees everything.
    Fit,
    /// The camera looks along an axis.
    LookFrom(Side),
    /// Switches between perspective and orthographic.
    Orthographic,
    /// The camera turns by a step: to the right, and up.
    Turn(i8, i8),
    /// The camera moves by a step: to the right, and up.
    Pan(i8, i8),
    /// Moves the camera nearer by this number of steps.
    Zoom(i8),
    /// The next scene of the folder.
    NextScene,
    /// Writes a picture beside the scene's file.
    Screenshot,
    /// Writes the scene to a file.
    Save,
    /// Hides the surface that was clicked.
    Hide,
    /// Shows all hidden surfaces.
    ShowAll,
    /// Undoes the last edit.
    Undo,
    /// Redoes the last undone edit.
    Redo,
    /// Shows the help, then nothing, then the panel.
    Help,
    /// Abandons the file that is being read, or else ends the program.
    Leave,
    /// Ends the program.
    Quit,
}

/// Kinds of trims, as the keys distinguish them.
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

/// A key, independent of the window system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Key {
    /// A key that types a character; letters are lower-case.
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

/// The modifier keys that are held.
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

/// One line of the table: several keys, the action of each, and a description.
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

/// All key bindings.
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
    Binding { keys: &[(letter('d'), Action::Edges)], help: "draw edges of CAD models: on, off" },
    Binding {
        keys: &[(letter('u'), Action::Isolines)],
        help: "isolines: lines of equal u and of equal v on, off",
    },
    Binding {
        keys: &[(letter('z'), Action::Shading)],
        help: "shading: zebra, isophotes, curvature, draft, light",
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
    Binding { keys: &[(letter('v'), Action::Hide)], help: "hide the face that was clicked" },
    Binding { keys: &[(letter('a'), Action::ShowAll)], help: "show all faces" },
    Binding { keys: &[(ctrl('z'), Action::Undo)], help: "undo" },
    Binding { keys: &[(ctrl_shift('z'), Action::Redo)], help: "redo" },
    Binding { keys: &[(ctrl('s'), Action::Save)], help: "save the scene beside its file" },
    Binding { keys: &[(plain(Key::F12), Action::Screenshot)], help: "picture beside the scene" },
    Binding {
        keys: &[(letter('h'), Action::Help), (plain(Key::F1), Action::Help)],
        help: "help, then nothing, then the panel",
    },
    Binding {
        keys: &[(plain(Key::Escape), Action::Leave), (ctrl('q'), Action::Quit)],
        help: "quit; while a file is read, Esc abandons it",
    },
];

/// The mouse bindings, for the same lists.
pub(crate) const MOUSE: &[(&str, &str)] = &[
    ("click", "name the face or surface under the cursor, and select it"),
    ("left drag", "turn the camera; on a highlighted control point, move it"),
    ("Shift + left drag, middle drag", "move the camera"),
    ("wheel, right drag", "zoom to the cursor"),
    ("drop a file", "open it"),
];

impl Action {
    /// The action of a key, if it has one.
    pub(crate) fn of(chord: Chord) -> Option<Self> {
        let chord = chord.normalized();
        BINDINGS
            .iter()
            .flat_map(Binding::keys_and_actions)
            .find(|(bound, _)| *bound == chord)
            .map(|(_, action)| *action)
    }

    /// Whether the action repeats while the key is held down.
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
    /// The key as the table contains it: in lower case, and without Shift where it only serves to type the
    /// character.
    fn normalized(self) -> Self {
        let Key::Char(char) = self.key else { return self };
        let ctrl = self.modifiers.ctrl;
        let shift = self.modifiers.shift && ctrl && char.is_alphabetic();
        let char = match char {
            // The same key without Shift.
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
    /// The keys, each with its action.
    pub(crate) fn keys_and_actions(&self) -> impl Iterator<Item = &'static (Chord, Action)> {
        self.keys.iter()
    }

    /// The keys in the form that users read.
    pub(crate) fn keys(&self) -> String {
        let keys: Vec<String> = self.keys.iter().map(|(chord, _)| chord.to_string()).collect();
        keys.join(", ")
    }
}

/// The keys and mouse inputs with their descriptions, line by line.
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
