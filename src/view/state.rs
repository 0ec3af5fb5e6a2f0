//! The state of the viewer, and the effects of actions on it, without a window.

mod switches;

use std::fmt::Display;
use std::path::PathBuf;

use freeform_surface::inspect::NewtonTrims;
use freeform_surface::{
    Alpha, Analysis, AnalysisKind, Camera, Edges, FrameStats, Isolines, Method, Paint, Result,
    Scene, Smoothing, TessLevel, Tessellation, Tolerance, Trims, ViewProjection,
};
use glam::{DVec2, dvec2};

use super::action::Action;
use super::camera::{self, Mover};
use super::faces::{Picked, without_shapes_of_faces};
use super::pick::{PointId, pick};
use super::pointer::Pointer;
use super::trims::{PutBy, switched};
use super::undo::{Change, History};

/// The highest level that the keys reach, as in the report.
const MAX_LEVEL: u32 = 50;
/// The tolerances that `+` and `−` step through, in pixels.
const TOLERANCES: [f64; 13] =
    [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
/// A step of turning by keys, in radians.
const TURN: f64 = 5.0 * std::f64::consts::PI / 180.0;
/// A step of moving by keys, as a fraction of the picture's height.
const PAN: f64 = 0.05;
/// The factor by which one step of zooming scales the distance.
pub(crate) const ZOOM: f64 = 0.85;
/// The speed of the turntable, in radians per second.
const TURNTABLE: f64 = 0.5;

/// Actions that only the window can carry out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Request {
    Quit,
    Leave,
    Screenshot,
    Save,
    NextScene,
}

/// The overlay over the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cover {
    Panel,
    Help,
    Nothing,
}

/// The changes since the scene was last uploaded to the driver.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Changes {
    /// Anything that is visible in the picture.
    pub(crate) picture: bool,
    /// Everything: the whole scene must be uploaded again.
    pub(crate) scene: bool,
    /// Control points.
    pub(crate) points: Vec<PointId>,
    /// Surfaces whose trims changed.
    pub(crate) trims: Vec<usize>,
    /// Surfaces whose paint changed, or that were hidden or shown.
    pub(crate) styles: Vec<usize>,
}

/// A line of text for the user.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Message {
    Done(String),
    Error(String),
}

/// A scene, its camera, and the edits that can be made.
#[derive(Debug)]
pub(crate) struct State {
    scene: Scene,
    /// `None` for the built-in scene.
    file: Option<PathBuf>,
    /// The camera that the scene came with.
    home: Option<Camera>,
    mover: Mover,
    /// Size of the picture in pixels.
    size: DVec2,
    level: TessLevel,
    tolerance: Tolerance,
    /// How edges were last drawn.
    edges: Edges,
    /// How isolines were last drawn.
    isolines: Isolines,
    /// How each analysis was last shown.
    analyses: [Analysis; 4],
    pub(super) pointer: Pointer,
    history: History,
    /// The number of the last press of a key or button.
    press: u64,
    nested: PutBy,
    /// The paints of the surfaces, then of the meshes, before textures were last switched.
    other_paints: Vec<Paint>,
    changes: Changes,
    pub(crate) turntable: bool,
    /// The surface whose trims the panel shows.
    pub(crate) selected: usize,
    /// The surface that was clicked.
    pub(crate) picked: Option<Picked>,
    /// The mesh whose colour the panel shows.
    pub(crate) selected_mesh: usize,
    pub(crate) cover: Cover,
    pub(crate) message: Option<Message>,
    /// How far the scene is that is being read.
    pub(crate) progress: Option<String>,
}

impl State {
    pub(crate) fn new(scene: Scene, file: Option<PathBuf>) -> Self {
        let mut state = Self {
            home: None,
            mover: Mover::new(scene.up, None),
            scene,
            file: None,
            size: dvec2(1000.0, 600.0),
            level: TessLevel::default(),
            tolerance: Tolerance::default(),
            edges: Edges::default(),
            isolines: Isolines::default(),
            analyses: AnalysisKind::ALL.map(AnalysisKind::with_defaults),
            pointer: Pointer::default(),
            history: History::default(),
            press: 0,
            nested: PutBy::new(),
            other_paints: Vec::new(),
            changes: Changes::default(),
            turntable: false,
            selected: 0,
            picked: None,
            selected_mesh: 0,
            cover: Cover::Panel,
            message: None,
            progress: None,
        };
        state.open(state.scene.clone(), file);
        state
    }

    /// Shows another scene from the beginning.
    pub(crate) fn open(&mut self, scene: Scene, file: Option<PathBuf>) {
        self.home = scene.camera;
        self.mover = Mover::new(scene.up, scene.camera.as_ref());
        self.turntable = false;
        self.selected = 0;
        self.file = file;
        self.replace(scene);
    }

    /// Shows the scene again after its file has changed; the camera stays.
    pub(crate) fn reload(&mut self, mut scene: Scene) {
        self.home = scene.camera;
        scene.camera = self.scene.camera;
        self.selected = self.selected.min(scene.surfaces.len().saturating_sub(1));
        self.replace(scene);
    }

    fn replace(&mut self, scene: Scene) {
        match scene.settings.tessellation {
            Tessellation::Level(level) => self.level = level,
            Tessellation::Within(tolerance) => self.tolerance = tolerance,
        }
        self.scene = scene;
        self.history = History::default();
        self.nested.clear();
        self.other_paints.clear();
        self.pointer.let_go();
        self.picked = None;
        self.message = None;
        self.changes = Changes { picture: true, scene: true, ..Changes::default() };
    }

    pub(crate) const fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The scene as it is saved: with the current camera.
    pub(crate) fn saved_scene(&self) -> Scene {
        Scene { camera: Some(self.camera()), ..self.scene.clone() }
    }

    pub(crate) const fn file(&self) -> Option<&PathBuf> {
        self.file.as_ref()
    }

    pub(crate) const fn size(&self) -> DVec2 {
        self.size
    }

    /// Sets the size of the picture in pixels, at least one.
    pub(crate) fn resize(&mut self, width: u32, height: u32) {
        self.size = dvec2(width.max(1).into(), height.max(1).into());
        self.changes.picture = true;
    }

    pub(crate) fn aspect(&self) -> f64 {
        self.size.x / self.size.y
    }

    /// The current camera.
    pub(crate) fn camera(&self) -> Camera {
        self.scene.camera.unwrap_or_else(|| self.scene.framed(self.aspect()))
    }

    pub(crate) fn projection(&self) -> ViewProjection {
        self.scene.projection(self.size.x as u32, self.size.y as u32)
    }

    /// Returns the changes since the last call.
    pub(crate) fn take_changes(&mut self) -> Changes {
        std::mem::take(&mut self.changes)
    }

    /// Whether the mouse or the turntable is moving something.
    pub(crate) fn is_moving(&self) -> bool {
        self.turntable || self.pointer.is_busy()
    }

    /// Notes that the changes did not reach the driver, so that the next upload contains the whole scene.
    pub(crate) const fn note_lost(&mut self) {
        self.changes.scene = true;
    }

    pub(crate) const fn changed(&self) -> bool {
        self.changes.picture
    }

    /// Notes that a key or button was pressed: the edits of each press can be undone separately.
    pub(crate) const fn note_press(&mut self) {
        self.press += 1;
    }

    /// Shows the error of a result as a message; a success leaves the message as it is.
    pub(crate) fn report<T>(&mut self, result: Result<T, impl Display>) -> Option<T> {
        result.map_err(|error| self.message = Some(Message::Error(error.to_string()))).ok()
    }

    /// Carries out an action. Returns a request if only the window can carry it out.
    pub(crate) fn apply(&mut self, action: Action) -> Option<Request> {
        self.message = None;
        let done = match action {
            Action::Quit => return Some(Request::Quit),
            Action::Leave => return Some(Request::Leave),
            Action::Screenshot => return Some(Request::Screenshot),
            Action::Save => return Some(Request::Save),
            Action::NextScene => return Some(Request::NextScene),
            Action::Help => {
                self.cover = match self.cover {
                    Cover::Panel => Cover::Help,
                    Cover::Help => Cover::Nothing,
                    Cover::Nothing => Cover::Panel,
                };
                Ok(())
            }
            Action::Turntable => {
                self.turntable = !self.turntable;
                Ok(())
            }
            _ => self.change(action),
        };
        self.report(done);
        self.hover_again();
        None
    }

    /// Changes the picture.
    fn change(&mut self, action: Action) -> Result<()> {
        self.changes.picture = true;
        if action == Action::ResetCamera {
            self.scene.camera = self.home;
            return Ok(());
        }
        // A scene without a camera of its own would be framed anew with every change.
        let camera = self.hold_camera();
        let step = |x: i8, y: i8| dvec2(x.into(), y.into());
        match action {
            Action::Finer => self.set_level(1),
            Action::Coarser => self.set_level(-1),
            Action::UseTolerance => {
                self.set_tessellation(Tessellation::Within(self.tolerance));
                Ok(())
            }
            Action::LargerTolerance => self.step_tolerance(true),
            Action::SmallerTolerance => self.step_tolerance(false),
            Action::Wireframe => {
                let Scene { settings, surfaces, .. } = &mut self.scene;
                settings.wireframe = !settings.wireframe;
                // The thousands of points of a CAD model would hide it, and cannot be moved.
                let has_own = surfaces.iter().any(|surface| surface.face.is_none());
                settings.control_points = settings.wireframe && has_own;
                settings.red_lines = settings.wireframe;
                Ok(())
            }
            Action::Edges => {
                self.switch_edges();
                Ok(())
            }
            Action::Isolines => {
                self.switch_isolines();
                Ok(())
            }
            Action::Shading => {
                self.show_next_analysis();
                Ok(())
            }
            Action::Trim(kind) => {
                let mut nested = std::mem::take(&mut self.nested);
                let edits = switched(&self.scene, kind, self.selected, &mut nested);
                self.nested = nested;
                self.edit(edits)
            }
            Action::Method => self.set_method(match self.scene.settings.method {
                Method::Exact => Method::Thesis,
                Method::Thesis => Method::Exact,
            }),
            Action::Texture => self.switch_textures(),
            Action::Phong => self.switch_smoothing(Smoothing::Phong(Alpha::default())),
            Action::Pn => self.switch_smoothing(Smoothing::Pn),
            Action::Fit => self.look(Ok(self.scene.fitted(&camera, self.aspect()))),
            Action::LookFrom(side) => self.look(self.mover.look_from(&camera, side)),
            Action::Orthographic => {
                let other = self.mover.other_lens(&camera);
                self.look(other)
            }
            Action::Turn(x, y) => self.look(self.mover.turn(&camera, step(x, y) * TURN)),
            Action::Pan(x, y) => self.look(camera::pan(&camera, step(x, y) * PAN)),
            Action::Zoom(steps) => {
                self.look(camera::zoom(&camera, ZOOM.powi(steps.into()), DVec2::ZERO))
            }
            Action::Hide => self.hide(),
            Action::ShowAll => self.show_all(),
            Action::Undo | Action::Redo => {
                self.step_history(action == Action::Undo);
                Ok(())
            }
            Action::ResetCamera
            | Action::Turntable
            | Action::NextScene
            | Action::Screenshot
            | Action::Save
            | Action::Help
            | Action::Leave
            | Action::Quit => Ok(()),
        }
    }

    /// Fixes the current camera, so that later changes of the scene do not move it.
    pub(super) fn hold_camera(&mut self) -> Camera {
        let camera = self.camera();
        self.scene.camera = Some(camera);
        camera
    }

    pub(super) fn look(&mut self, camera: Result<Camera>) -> Result<()> {
        self.scene.camera = Some(camera?);
        self.changes.picture = true;
        Ok(())
    }

    pub(super) const fn mover(&self) -> &Mover {
        &self.mover
    }

    /// Advances the turntable by `seconds`.
    pub(crate) fn advance(&mut self, seconds: f64) {
        if self.turntable {
            let camera = self.hold_camera();
            let by = dvec2(seconds * TURNTABLE, 0.0);
            let turned = self.mover.turn(&camera, by);
            let looked = self.look(turned);
            self.report(looked);
            self.hover_again();
        }
    }

    fn set_level(&mut self, step: i64) -> Result<()> {
        let level = i64::from(self.level.get()) + step;
        // A scene's own level may be higher than the keys' maximum. From there, the keys only lower it.
        if (1..=i64::from(MAX_LEVEL.max(self.level.get()))).contains(&level) {
            self.level = TessLevel::new(level)?;
        }
        self.set_tessellation(Tessellation::Level(self.level));
        Ok(())
    }

    fn step_tolerance(&mut self, larger: bool) -> Result<()> {
        let now = self.tolerance.pixels();
        let next = if larger {
            TOLERANCES.iter().find(|other| **other > now)
        } else {
            TOLERANCES.iter().rfind(|other| **other < now)
        };
        let tolerance = next.map_or(Ok(self.tolerance), |pixels| Tolerance::new(*pixels))?;
        self.set_tessellation(Tessellation::Within(tolerance));
        Ok(())
    }

    /// Chooses how finely patches are tessellated.
    pub(crate) fn set_tessellation(&mut self, tessellation: Tessellation) {
        match tessellation {
            Tessellation::Level(level) => self.level = level,
            Tessellation::Within(tolerance) => self.tolerance = tolerance,
        }
        self.scene.settings.tessellation = tessellation;
        self.changes.picture = true;
    }

    /// The last chosen level and tolerance; one of them is in use.
    pub(crate) const fn finenesses(&self) -> (TessLevel, Tolerance) {
        (self.level, self.tolerance)
    }

    /// Chooses the method for trims and normals.
    ///
    /// # Errors
    /// The thesis' method cannot draw the degrees or cut the trims.
    pub(crate) fn set_method(&mut self, method: Method) -> Result<()> {
        if method == Method::Thesis {
            for (number, surface) in self.scene.surfaces.iter().enumerate() {
                (surface.degree().check_for_thesis())
                    .and_then(|()| check_for_thesis(&surface.trims))
                    .map_err(|error| error.within(format!("surface {number}")))?;
            }
        }
        self.scene.settings.method = method;
        self.changes.picture = true;
        Ok(())
    }

    /// Changes settings that do not have to be checked.
    pub(crate) fn change_settings(
        &mut self,
        change: impl FnOnce(&mut freeform_surface::RenderSettings),
    ) {
        self.hold_camera();
        change(&mut self.scene.settings);
        self.changes.picture = true;
    }

    /// Applies changes to the scene so that they can be undone. Those of the shape of a CAD model's faces are left out.
    ///
    /// # Errors
    /// The trims are not finite, or the thesis' method is in use and cannot cut them; all changes are left out.
    pub(crate) fn edit(&mut self, edits: Vec<Change>) -> Result<()> {
        let edits = without_shapes_of_faces(&self.scene, edits)?;
        if edits.is_empty() {
            return Ok(());
        }
        for part in &edits {
            if let Change::Trims(_, trims) = part {
                trims.check()?;
                if self.scene.settings.method == Method::Thesis {
                    check_for_thesis(trims)?;
                }
            }
        }
        self.hold_camera();
        note(&mut self.changes, &edits);
        self.history.edit(&mut self.scene, edits, self.press);
        Ok(())
    }

    fn step_history(&mut self, back: bool) {
        let Self { history, scene, changes, .. } = self;
        let edits = if back { history.undo(scene) } else { history.redo(scene) };
        note(changes, edits.unwrap_or_default());
        let unfit = |scene: &Scene| {
            scene.surfaces.iter().any(|surface| check_for_thesis(&surface.trims).is_err())
        };
        // These loops may be from a time when the exact method was in use.
        if scene.settings.method == Method::Thesis && unfit(scene) {
            scene.settings.method = Method::Exact;
        }
    }

    /// The window's title.
    pub(crate) fn title(&self, stats: &FrameStats, ms: f64) -> String {
        let file = self.file.as_ref().and_then(|file| file.file_name());
        let name = file.map_or("freeform".into(), |name| name.to_string_lossy());
        let fineness = match self.scene.settings.tessellation {
            Tessellation::Level(level) => format!("level {}", level.get()),
            Tessellation::Within(_) if self.scene.settings.method == Method::Thesis => {
                format!("level {}", TessLevel::default().get())
            }
            Tessellation::Within(tolerance) => format!("tolerance {} px", tolerance.pixels()),
        };
        format!("{name} · {fineness} · {} triangles · {ms:.1} ms", stats.triangles)
    }

    /// The object under the cursor may have moved away although the cursor did not move.
    fn hover_again(&mut self) {
        if self.pointer.hovered.is_some() {
            self.hover();
        }
    }

    /// Finds the control point under the cursor; returns true if it has changed.
    pub(super) fn hover(&mut self) -> bool {
        let found = pick(self.scene(), &self.projection(), self.size(), self.pointer.place);
        std::mem::replace(&mut self.pointer.hovered, found) != found
    }
}

fn check_for_thesis(trims: &Trims) -> Result<()> {
    NewtonTrims::of(trims).map(drop)
}

/// Records what the edits change.
fn note(changes: &mut Changes, edits: &[Change]) {
    changes.picture = true;
    for part in edits {
        match part {
            Change::Point(id, _) => changes.points.push(*id),
            Change::Trims(surface, _) => changes.trims.push(*surface),
            Change::SurfacePaint(surface, _) | Change::Hidden(surface, _) => {
                changes.styles.push(*surface);
            }
            Change::MeshPaint(..) => changes.scene = true,
        }
    }
}

#[cfg(test)]
pub(in crate::view) mod tests;
