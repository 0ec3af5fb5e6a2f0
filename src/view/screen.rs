//! The scene in the driver's memory, and the picture that the window shows of it.

use std::sync::Arc;
use std::time::Instant;

use freeform_surface::gpu::{self, Framebuffer};
use freeform_surface::{
    Frame, FrameFigures, Image, PreparedScene, Renderer, Result, Samples, Scene,
};

use super::state::{Changes, State};

/// Draws the scene into a picture of its own, as `freeform render` does, so that both are the same.
pub(super) struct Screen {
    target: Framebuffer,
    samples: Samples,
    prepared: PreparedScene,
    renderer: Renderer,
    /// How long the last drawing took.
    ms: f64,
}

impl Screen {
    pub(super) fn new(gl: &Arc<glow::Context>) -> Result<Self> {
        let renderer = Renderer::new(gl)?;
        let nothing = Scene { surfaces: Vec::new(), ..Scene::listing16() };
        Ok(Self {
            target: Framebuffer::new(gl, 1, 1)?,
            samples: Samples::default(),
            prepared: PreparedScene::new(&renderer, &nothing)?,
            renderer,
            ms: 0.0,
        })
    }

    /// Brings what changed to the driver and draws.
    ///
    /// # Errors
    /// What the driver cannot hold or draw; the picture may be half done.
    pub(super) fn draw(&mut self, state: &State, changes: &Changes) -> Result<()> {
        let start = Instant::now();
        self.bring(state, changes)?;
        let frame = frame_of(state);
        self.target.bind();
        self.prepared.draw(&mut self.renderer, &frame)?;
        gpu::finish(self.renderer.gl());
        self.ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(())
    }

    /// The scene's picture with all samples, as `freeform render` makes it.
    ///
    /// # Errors
    /// As drawing.
    pub(super) fn picture(&mut self, state: &State) -> Result<Image> {
        let frame = frame_of(state);
        self.prepared.picture(&mut self.renderer, &self.target, &frame, |_, _| {})
    }

    /// Copies the picture into the window.
    pub(super) fn show(&self) {
        self.target.show();
    }

    pub(super) const fn figures(&self) -> FrameFigures {
        self.prepared.figures()
    }

    pub(super) const fn ms(&self) -> f64 {
        self.ms
    }

    /// Uploads what changed, and nothing else.
    fn bring(&mut self, state: &State, changes: &Changes) -> Result<()> {
        let scene = state.scene();
        let size = state.size().as_uvec2();
        let samples = scene.settings.samples;
        if self.target.size() != size.into() || self.samples != samples {
            self.target = Framebuffer::for_samples(self.renderer.gl(), size.into(), samples)?;
            self.samples = samples;
        }
        if changes.scene {
            self.prepared = PreparedScene::new(&self.renderer, scene)?;
            return Ok(());
        }
        let surfaces = self.prepared.surfaces_mut();
        for id in &changes.points {
            let point = scene.surfaces[id.surface].control_points()[id.index];
            surfaces[id.surface].set_control_point(point, id.index)?;
        }
        for surface in &changes.trims {
            surfaces[*surface].set_trims(scene.surfaces[*surface].trims.clone())?;
        }
        Ok(())
    }
}

fn frame_of(state: &State) -> Frame {
    Frame { projection: state.projection(), settings: state.scene().settings }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::state::tests::{Chance, event_by_chance};
    use freeform_surface::{Backend, Headless};

    /// Events by chance end in drawings without an error of the driver; and what is saved then is drawn
    /// the same, pixel for pixel.
    #[test]
    fn after_events_by_chance_the_saved_scene_is_what_is_shown() {
        let context = Headless::new(Backend::Auto).unwrap();
        let mut screen = Screen::new(context.gl()).unwrap();
        let mut state = State::new(Scene::listing16(), None);
        let mut chance = Chance(2);
        let mut drawn = 0;
        for number in 0..2_000 {
            event_by_chance(&mut state, &mut chance);
            if number % 25 > 0 {
                continue;
            }
            state.resize(160, 120);
            let changes = state.take_changes();
            if let Err(error) = screen.draw(&state, &changes) {
                panic!("event {number}: {error}");
            }
            let errors = context.debug_log().take_errors();
            assert!(errors.is_empty(), "event {number}: {errors:?}");
            let shown = screen.target.read();
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("saved.toml");
            let saved = state.saved_scene().to_toml(&path).unwrap();
            for (path, bytes) in &saved.files {
                std::fs::write(path, bytes).unwrap();
            }
            let again = Scene::from_toml(&saved.text, &path).unwrap();
            let mut prepared = PreparedScene::new(&screen.renderer, &again).unwrap();
            let frame = Frame { projection: again.projection(160, 120), settings: again.settings };
            let picture =
                prepared.picture(&mut screen.renderer, &screen.target, &frame, |_, _| {}).unwrap();
            assert!(picture == shown, "event {number}:\n{}", saved.text);
            drawn += 1;
        }
        assert_eq!(drawn, 80);
    }
}
