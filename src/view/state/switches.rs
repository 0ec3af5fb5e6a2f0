//! What keys switch on and off, and how it comes back as it was.

use std::sync::Arc;

use freeform_surface::{AnalysisKind, Error, Image, Paint, Result, Scene, Smoothing};

use super::State;
use crate::view::undo::Change;

impl State {
    /// Removes all textures, or puts them back; where there were none, it uses bricks.
    pub(super) fn switch_textures(&mut self) -> Result<()> {
        let surfaces = self.scene.surfaces.iter().map(|surface| &surface.paint);
        let meshes = self.scene.meshes.iter().map(|mesh| &mesh.paint);
        let paints: Vec<Paint> = surfaces.chain(meshes).cloned().collect();
        let is_picture = |paint: &Paint| matches!(paint, Paint::Texture(_));
        let off = paints.iter().any(is_picture);
        // If there is no earlier paint, it is grey or bricks.
        let fallback = match self.other_paints.iter().any(is_picture) {
            _ if off => Some(Paint::default()),
            true => None,
            false => Some(Paint::Texture(bricks())),
        };
        let mut edits = Vec::new();
        for (number, paint) in paints.iter().enumerate() {
            let other = self.other_paints.get(number).filter(|other| is_picture(other) != off);
            let Some(other) = other.or(fallback.as_ref()) else { continue };
            if is_picture(paint) == off {
                let surfaces = self.scene.surfaces.len();
                edits.push(match number.checked_sub(surfaces) {
                    None => Change::SurfacePaint(number, other.clone()),
                    Some(mesh) => Change::MeshPaint(mesh, other.clone()),
                });
            }
        }
        self.other_paints = paints;
        self.edit(edits)
    }

    /// Switches the lines along edges on or off.
    pub(crate) fn switch_edges(&mut self) {
        let edges = toggled(self.scene.settings.edges, &mut self.edges);
        self.change_settings(|settings| settings.edges = edges);
    }

    /// Switches the isolines on or off.
    pub(crate) fn switch_isolines(&mut self) {
        let isolines = toggled(self.scene.settings.isolines, &mut self.isolines);
        self.change_settings(|settings| settings.isolines = isolines);
    }

    /// Shows an analysis as it was last shown, or the light.
    pub(crate) fn show_analysis(&mut self, kind: Option<AnalysisKind>) {
        if let Some(shown) = self.scene.settings.analysis
            && let Some(own) = self.analyses.iter_mut().find(|own| own.kind() == shown.kind())
        {
            *own = shown;
        }
        let next =
            kind.and_then(|kind| self.analyses.iter().find(|own| own.kind() == kind).copied());
        self.change_settings(|settings| settings.analysis = next);
    }

    /// Shows the next analysis; after the last one, the light.
    pub(super) fn show_next_analysis(&mut self) {
        let shown = self.scene.settings.analysis.map(|own| own.kind());
        let number = |kind| AnalysisKind::ALL.iter().position(|own| *own == kind);
        let next = shown.and_then(number).map_or(0, |number| number + 1);
        self.show_analysis(AnalysisKind::ALL.get(next).copied());
    }

    /// Switches this smoothing on or off for all meshes.
    pub(super) fn switch_smoothing(&mut self, smoothing: Smoothing) -> Result<()> {
        if self.scene.meshes.is_empty() {
            return Err(Error::invalid(
                "scene",
                "without a mesh",
                "one with a [[mesh]], or an .obj file",
            ));
        }
        let on = |other| std::mem::discriminant(&other) == std::mem::discriminant(&smoothing);
        let smoothing = if self.scene.meshes.iter().all(|mesh| on(mesh.smoothing())) {
            Smoothing::None
        } else {
            smoothing
        };
        for mesh in &mut self.scene.meshes {
            mesh.set_smoothing(smoothing);
        }
        self.changes.scene = true;
        Ok(())
    }
}

/// Nothing instead of something, which is remembered, and the other way round.
fn toggled<T: Copy>(shown: Option<T>, last: &mut T) -> Option<T> {
    match shown {
        Some(own) => {
            *last = own;
            None
        }
        None => Some(*last),
    }
}

/// The texture of bricks of the built-in scene.
fn bricks() -> Arc<Image> {
    match Scene::listing16().surfaces.swap_remove(0).paint {
        Paint::Texture(image) => image,
        Paint::Color(_) => unreachable!("the built-in scene has a picture"),
    }
}
