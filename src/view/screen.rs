//! The uploaded scene, and the picture of it that the window shows.

use std::time::Instant;

use freeform_surface::{
    Frame, FrameStats, Framebuffer, Gl, Image, Paint, PreparedScene, Renderer, Result, Samples,
    Scene, Surface,
};

use super::state::{Changes, State};

/// Draws the scene into a picture of its own, as `freeform render` does, so that both pictures are the same.
pub(super) struct Screen {
    target: Framebuffer,
    /// The picture at rest, if drawing into the target alone cannot produce it.
    still: Option<Framebuffer>,
    samples: Samples,
    prepared: PreparedScene,
    renderer: Renderer,
    /// Whether the target shows anything other than the scene with all its samples.
    stale: bool,
    /// The duration of the last drawing in milliseconds.
    ms: f64,
}

impl Screen {
    pub(super) fn new(gl: &Gl) -> Result<Self> {
        let renderer = Renderer::new(gl)?;
        let nothing = Scene { surfaces: Vec::new(), ..Scene::listing16() };
        Ok(Self {
            target: Framebuffer::new(gl, 1, 1)?,
            still: None,
            samples: Samples::default(),
            prepared: PreparedScene::new(&renderer, &nothing)?,
            renderer,
            stale: true,
            ms: 0.0,
        })
    }

    /// Uploads the changes and draws. If the scene asks for more samples than the driver supports in one pass,
    /// one sample is used while the mouse or the turntable moves something.
    ///
    /// # Errors
    /// The driver cannot store or draw something; the picture may be incomplete.
    pub(super) fn bring_and_draw(&mut self, state: &mut State) -> Result<()> {
        let changes = state.take_changes();
        // If this fails, the next call uploads the whole scene.
        self.draw(state, &changes).inspect_err(|_| state.note_lost())
    }

    fn draw(&mut self, state: &State, changes: &Changes) -> Result<()> {
        let start = Instant::now();
        self.bring(state, changes)?;
        let frame = frame_of(state);
        let samples = frame.settings.samples.get();
        // With a transparent background, averaged colours are premultiplied by alpha, and a window cannot
        // divide them by it.
        let is_whole = samples <= self.target.samples()
            && (samples == 1 || frame.settings.background[3] == 1.0);
        if is_whole || state.is_moving() {
            self.target.bind();
            let _ = self.prepared.draw(&mut self.renderer, &frame)?;
            self.still = None;
            self.stale = !is_whole;
        } else {
            let image = self.picture(state)?;
            let (width, height) = self.target.size();
            let still = Framebuffer::new(self.renderer.gl(), width, height)?;
            still.write(&image)?;
            self.still = Some(still);
            self.stale = false;
        }
        self.renderer.gl().finish();
        self.ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(())
    }

    /// Whether the same picture must be drawn again with all samples as soon as nothing moves.
    pub(super) fn is_unfinished(&self, state: &State) -> bool {
        self.stale && !state.is_moving()
    }

    /// The scene's picture with all samples, as `freeform render` makes it.
    ///
    /// # Errors
    /// The same as for drawing.
    pub(super) fn picture(&mut self, state: &State) -> Result<Image> {
        let frame = frame_of(state);
        // This draws into the target.
        self.stale = true;
        self.prepared.picture(&mut self.renderer, &self.target, &frame, |_, _| {})
    }

    /// Copies the picture into the window.
    pub(super) fn show(&self) {
        self.shown().show();
    }

    fn shown(&self) -> &Framebuffer {
        self.still.as_ref().unwrap_or(&self.target)
    }

    /// The curvature at the end of the scale, if the picture shows curvature.
    pub(super) fn curvature_limit(&self, state: &State) -> Option<f64> {
        self.prepared.curvature_limit(&state.scene().settings.shown_analysis()?)
    }

    pub(super) const fn stats(&self) -> FrameStats {
        self.prepared.stats()
    }

    pub(super) const fn ms(&self) -> f64 {
        self.ms
    }

    /// Uploads only the changes.
    fn bring(&mut self, state: &State, changes: &Changes) -> Result<()> {
        let scene = state.scene();
        let size = state.size().as_uvec2();
        let samples = scene.settings.samples;
        if self.target.size() != size.into() || self.samples != samples {
            self.target = Framebuffer::for_samples(self.renderer.gl(), size.into(), samples)?;
            self.samples = samples;
        }
        // A picture needs a new texture.
        let is_color = |surface: &Surface| matches!(surface.paint, Paint::Color(_));
        let repaints = |number: &usize| {
            let [before, after] =
                [self.prepared.surfaces()[*number].surface(), &scene.surfaces[*number]];
            before.paint != after.paint && !(is_color(before) && is_color(after))
        };
        if changes.scene || changes.styles.iter().any(repaints) {
            self.prepared = PreparedScene::new(&self.renderer, scene)?;
            return Ok(());
        }
        let surfaces = self.prepared.surfaces_mut();
        for id in &changes.points {
            let point = scene.surfaces[id.surface].control_points()[id.index];
            surfaces[id.surface].set_control_point(point, id.index)?;
        }
        for number in &changes.styles {
            let Surface { hidden, paint, .. } = &scene.surfaces[*number];
            surfaces[*number].set_hidden(*hidden);
            if let Paint::Color(rgb) = paint {
                surfaces[*number].set_color(*rgb);
            }
        }
        for surface in &changes.trims {
            surfaces[*surface].set_trims(scene.surfaces[*surface].trims.clone())?;
        }
        Ok(())
    }
}

fn frame_of(state: &State) -> Frame {
    Frame::new(state.projection(), state.size().as_uvec2(), state.scene().settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::view::action::Action;
    use crate::view::state::tests::random_event;
    use crate::view::undo::Change;
    use freeform_surface::inspect::measure::Random;
    use freeform_surface::{Backend, Headless, TessLevel, Tessellation};

    #[test]
    fn at_rest_all_samples_are_shown_and_one_while_something_moves() {
        let context = Headless::new(Backend::Auto).unwrap();
        let mut screen = Screen::new(context.gl()).unwrap();
        let mut scene = Scene::listing16();
        // One pass does not average over a transparent background either.
        let transparent = [0.2, 0.8, 0.25, 0.0];
        for (samples, background) in [(64, scene.settings.background), (4, transparent)] {
            scene.settings.samples = Samples::new(samples).unwrap();
            scene.settings.background = background;
            check_at_rest(&mut screen, scene.clone());
            assert!(context.debug_log().take_errors().is_empty());
        }
    }

    fn check_at_rest(screen: &mut Screen, scene: Scene) {
        let mut state = State::new(scene, None);
        state.resize(80, 60);
        let changes = state.take_changes();
        screen.draw(&state, &changes).unwrap();
        let shown = screen.shown().read();
        assert!(shown == screen.picture(&state).unwrap(), "all samples");
        // Making the picture has drawn into the target.
        assert!(screen.is_unfinished(&state));
        screen.draw(&state, &Changes::default()).unwrap();
        assert!(screen.shown().read() == shown && !screen.is_unfinished(&state));
        state.apply(Action::Turntable);
        let changes = state.take_changes();
        screen.draw(&state, &changes).unwrap();
        assert!(screen.shown().read() != shown, "one sample");
        assert!(!screen.is_unfinished(&state));
        state.apply(Action::Turntable);
        assert!(screen.is_unfinished(&state));
        screen.draw(&state, &Changes::default()).unwrap();
        assert!(screen.shown().read() == shown && !screen.is_unfinished(&state));
    }

    #[test]
    fn colours_and_hidden_faces_are_drawn_without_a_new_upload() {
        let context = Headless::new(Backend::Auto).unwrap();
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/models/bracket.ffm");
        let mut scene = Scene::load(path.as_ref()).unwrap();
        scene.settings.tessellation = Tessellation::Level(TessLevel::new(8).unwrap());
        scene.camera = Some(scene.framed(4.0 / 3.0));
        let shown = |state: &mut State, screen: &mut Screen| {
            state.resize(160, 120);
            let changes = state.take_changes();
            screen.draw(state, &changes).unwrap();
            (changes.scene, screen.shown().read())
        };
        let [mut screen, mut fresh] = [0, 1].map(|_| Screen::new(context.gl()).unwrap());
        let mut state = State::new(scene.clone(), None);
        let mut before = shown(&mut state, &mut screen).1;
        for number in 0..scene.surfaces.len() {
            let next = (number + 1) % scene.surfaces.len();
            let red = Paint::Color([1.0, 0.0, 0.0]);
            state
                .edit(vec![Change::Hidden(number, true), Change::SurfacePaint(next, red)])
                .unwrap();
            let (is_new, now) = shown(&mut state, &mut screen);
            let wrong =
                |other: &Image| now.pixels().zip(other.pixels()).filter(|(a, b)| a != b).count();
            let again = shown(&mut State::new(state.scene().clone(), None), &mut fresh).1;
            assert_eq!((is_new, wrong(&again)), (false, 0), "{number}");
            // Without the hidden surfaces, the rounding is different.
            let mut without = state.scene().clone();
            without.surfaces.retain(|surface| !surface.hidden);
            let without = shown(&mut State::new(without, None), &mut fresh).1;
            assert!(wrong(&without) < 20, "{number}: {}", wrong(&without));
            if number == 0 {
                assert!(now != before);
                before = now;
            }
        }
        assert!(screen.shown().read().pixels().all(|pixel| pixel == before.get_pixel(0, 0)));
        assert!(context.debug_log().take_errors().is_empty());
    }

    /// After random events, the driver still draws without errors. The saved scene gives the same picture,
    /// pixel for pixel.
    #[test]
    fn after_random_events_the_saved_scene_is_what_is_shown() {
        let context = Headless::new(Backend::Auto).unwrap();
        let mut screen = Screen::new(context.gl()).unwrap();
        let mut state = State::new(Scene::listing16(), None);
        let mut random = Random(2);
        let mut drawn = 0;
        for number in 0..2_000 {
            random_event(&mut state, &mut random);
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
            let shown = screen.shown().read();
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("saved.toml");
            let saved = state.saved_scene().to_toml(&path).unwrap();
            for (path, bytes) in &saved.files {
                std::fs::write(path, bytes).unwrap();
            }
            let again = Scene::from_toml(&saved.text, &path).unwrap();
            let mut prepared = PreparedScene::new(&screen.renderer, &again).unwrap();
            let frame = Frame::of(&again, (160, 120));
            let picture =
                prepared.picture(&mut screen.renderer, &screen.target, &frame, |_, _| {}).unwrap();
            assert!(picture == shown, "event {number}:\n{}", saved.text);
            drawn += 1;
        }
        assert_eq!(drawn, 80);
    }
}
