//! egui over the picture: its input, its frames, and when it wants the next one.

use std::sync::Arc;
use std::time::Duration;

use crate::io::{Error, Result};
use egui::{Context, Pos2, Rect, ViewportId};
use egui_glow::Painter;
use freeform_surface::Gl;
use winit::event::WindowEvent;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// egui in a window.
pub(super) struct Overlay {
    context: Context,
    input: egui_winit::State,
    painter: Painter,
    /// The rectangles that it covered when it was last painted.
    covered: Vec<Rect>,
    /// Whether the mouse was over it at the last call of `is_over`.
    over: bool,
}

impl Overlay {
    pub(super) fn new(events: &ActiveEventLoop, gl: &Gl, window: &Window) -> Result<Self> {
        let painter =
            Painter::new(Arc::clone(gl.functions()), "", None, false).map_err(|error| {
                Error::Driver { what: "the panel".into(), reason: error.to_string() }
            })?;
        let context = Context::default();
        // The keys of egui's own zoom are used for the tolerance.
        context.options_mut(|options| options.zoom_with_keyboard = false);
        // A blinking caret would cause frames while nothing changes.
        context.all_styles_mut(|style| style.visuals.text_cursor.blink = false);
        let input = egui_winit::State::new(
            context.clone(),
            ViewportId::ROOT,
            events,
            Some(window.scale_factor() as f32),
            window.theme(),
            Some(painter.max_texture_side()),
        );
        Ok(Self { context, input, painter, covered: Vec::new(), over: false })
    }

    /// Passes an event on.
    pub(super) fn take(&mut self, window: &Window, event: &WindowEvent) {
        let _ = self.input.on_window_event(window, event);
    }

    /// Whether a text field of the panel receives the keys.
    pub(super) fn wants_keys(&self) -> bool {
        self.context.egui_wants_keyboard_input()
    }

    /// Whether the mouse at this pixel belongs to the panel, and whether the panel has to be redrawn for the
    /// mouse. The latter is also true if the mouse belonged to the panel at the last call.
    pub(super) fn is_over(&mut self, x: f64, y: f64) -> (bool, bool) {
        let scale = self.context.pixels_per_point();
        let place = Pos2::new(x as f32 / scale, y as f32 / scale);
        let over = self.covered.iter().any(|rect| rect.contains(place))
            || egui::Popup::is_any_open(&self.context)
            || self.context.egui_is_using_pointer();
        (over, std::mem::replace(&mut self.over, over) || over)
    }

    /// Paints the layout that `show` makes; `show` returns the rectangles that it covers. Returns the time
    /// after which egui wants to be painted again.
    pub(super) fn paint(
        &mut self,
        window: &Window,
        mut show: impl FnMut(&Context) -> Vec<Rect>,
    ) -> Duration {
        let input = self.input.take_egui_input(window);
        let mut covered = Vec::new();
        let mut output = self.context.run_ui(input, |ui| covered = show(ui.ctx()));
        self.covered = covered;
        self.input.handle_platform_output(window, output.platform_output);
        let size = window.inner_size();
        let shapes = self.context.tessellate(output.shapes, output.pixels_per_point);
        self.painter.paint_and_update_textures(
            [size.width.max(1), size.height.max(1)],
            output.pixels_per_point,
            &shapes,
            &mut output.textures_delta,
        );
        let root = output.viewport_output.get(&ViewportId::ROOT);
        root.map_or(Duration::MAX, |viewport| viewport.repaint_delay)
    }
}

impl Drop for Overlay {
    fn drop(&mut self) {
        self.painter.destroy();
    }
}
