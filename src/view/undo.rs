//! Edits of a scene that can be undone.

use freeform_surface::{Paint, Scene, Surface, Trims};
use glam::DVec4;

use super::pick::PointId;

/// The maximum number of edits that are remembered.
const MAX_EDITS: usize = 1000;

/// A property of a scene, with its value after or before an edit.
#[derive(Debug, Clone)]
pub(crate) enum Change {
    /// A control point.
    Point(PointId, DVec4),
    /// The trims of a surface.
    Trims(usize, Box<Trims>),
    /// The colour or picture of a surface.
    SurfacePaint(usize, Paint),
    /// Whether a surface is hidden.
    Hidden(usize, bool),
    /// The colour or picture of a mesh.
    MeshPaint(usize, Paint),
}

impl Change {
    /// Puts this value into the scene and keeps the old one. A value that the scene refuses is not applied.
    fn swap(&mut self, scene: &mut Scene) {
        match self {
            Self::Point(id, point) => {
                let Some(surface) = scene.surfaces.get_mut(id.surface) else { return };
                let Some(old) = surface.control_points().get(id.index).copied() else { return };
                if surface.set_control_point(*point, id.index).is_ok() {
                    *point = old;
                }
            }
            Self::Trims(surface, trims) => {
                if let Some(Surface { trims: own, .. }) = scene.surfaces.get_mut(*surface) {
                    std::mem::swap(own, trims);
                }
            }
            Self::SurfacePaint(surface, paint) => {
                if let Some(surface) = scene.surfaces.get_mut(*surface) {
                    std::mem::swap(&mut surface.paint, paint);
                }
            }
            Self::Hidden(surface, hidden) => {
                if let Some(surface) = scene.surfaces.get_mut(*surface) {
                    std::mem::swap(&mut surface.hidden, hidden);
                }
            }
            Self::MeshPaint(mesh, paint) => {
                if let Some(mesh) = scene.meshes.get_mut(*mesh) {
                    std::mem::swap(&mut mesh.paint, paint);
                }
            }
        }
    }

    /// Whether both change the same property.
    fn same_place(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Point(a, _), Self::Point(b, _)) => a == b,
            (Self::Trims(a, _), Self::Trims(b, _))
            | (Self::SurfacePaint(a, _), Self::SurfacePaint(b, _))
            | (Self::MeshPaint(a, _), Self::MeshPaint(b, _)) => a == b,
            (Self::Hidden(a, _), Self::Hidden(b, _)) => a == b,
            _ => false,
        }
    }
}

/// Changes that are made together, and the press of a key or button that caused them.
#[derive(Debug)]
struct Edit {
    changes: Vec<Change>,
    press: u64,
}

/// The edits that were made, and those that were undone.
#[derive(Debug, Default)]
pub(crate) struct History {
    done: Vec<Edit>,
    undone: Vec<Edit>,
}

impl History {
    /// Makes the changes. Edits of the same property during one press count as one.
    pub(crate) fn edit(&mut self, scene: &mut Scene, mut changes: Vec<Change>, press: u64) {
        for change in &mut changes {
            change.swap(scene);
        }
        self.undone.clear();
        let same = |last: &Edit| {
            last.press == press
                && last.changes.len() == changes.len()
                && std::iter::zip(&last.changes, &changes).all(|(a, b)| a.same_place(b))
        };
        if !self.done.last().is_some_and(same) {
            self.done.push(Edit { changes, press });
        }
        if self.done.len() > MAX_EDITS {
            self.done.remove(0);
        }
    }

    /// Undoes the last edit and returns its changes.
    pub(crate) fn undo(&mut self, scene: &mut Scene) -> Option<&[Change]> {
        Self::step(&mut self.done, &mut self.undone, scene)
    }

    /// Redoes the last undone edit and returns its changes.
    pub(crate) fn redo(&mut self, scene: &mut Scene) -> Option<&[Change]> {
        Self::step(&mut self.undone, &mut self.done, scene)
    }

    fn step<'a>(
        from: &mut Vec<Edit>,
        to: &'a mut Vec<Edit>,
        scene: &mut Scene,
    ) -> Option<&'a [Change]> {
        let mut edit = from.pop()?;
        for change in &mut edit.changes {
            change.swap(scene);
        }
        // Later edits do not belong to the same press.
        edit.press = 0;
        to.push(edit);
        to.last().map(|edit| edit.changes.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moved(index: usize, y: f64) -> Vec<Change> {
        vec![Change::Point(PointId { surface: 0, index }, DVec4::new(0.0, y, 0.0, 1.0))]
    }

    #[test]
    fn edits_of_one_press_are_taken_back_together() {
        let mut scene = Scene::listing16();
        let start = scene.clone();
        let mut history = History::default();
        for y in [1.0, 2.0, 3.0] {
            history.edit(&mut scene, moved(5, y), 1);
        }
        history.edit(&mut scene, moved(6, 4.0), 1);
        history.edit(&mut scene, moved(6, 5.0), 2);
        let end = scene.clone();
        for _ in 0..3 {
            assert!(history.undo(&mut scene).is_some());
        }
        assert_eq!(scene, start);
        assert!(history.undo(&mut scene).is_none());
        for _ in 0..3 {
            assert!(history.redo(&mut scene).is_some());
        }
        assert_eq!(scene, end);
        assert!(history.redo(&mut scene).is_none());
        history.undo(&mut scene);
        history.edit(&mut scene, moved(1, 1.0), 3);
        assert!(history.redo(&mut scene).is_none(), "a new edit ends what could be done again");
    }

    #[test]
    fn what_a_scene_does_not_take_stays_out() {
        let mut scene = Scene::listing16();
        let start = scene.clone();
        let mut history = History::default();
        history.edit(&mut scene, moved(99, 1.0), 1);
        history.edit(&mut scene, moved(5, f64::NAN), 2);
        assert_eq!(scene, start);
    }
}
