//! A window with an OpenGL 4.5 context.
#![allow(unsafe_code, reason = "glutin's calls and glow's are unsafe")]

use std::num::NonZeroU32;

use crate::io::{Error, Result};
use freeform_surface::{DebugLog, Gl};
use glow::HasContext as _;
use glutin::config::{Config, ConfigTemplateBuilder};
use glutin::context::{
    ContextApi, ContextAttributesBuilder, GlProfile, NotCurrentGlContext as _,
    PossiblyCurrentContext, PossiblyCurrentGlContext as _, Version,
};
use glutin::display::{GetGlDisplay as _, GlDisplay as _};
use glutin::surface::{
    GlSurface as _, Surface, SurfaceAttributesBuilder, SwapInterval, WindowSurface,
};
use glutin_winit::{ApiPreference, DisplayBuilder, GlWindow as _};
use winit::dpi::{LogicalSize, PhysicalSize};
use winit::event_loop::ActiveEventLoop;
use winit::raw_window_handle::HasWindowHandle as _;
use winit::window::Window;

/// A window, its surface, and the context that draws into it. The context is current on its thread until it is
/// dropped.
pub(super) struct GlWindow {
    // Fields are dropped in this order: the surface before the context, and both before the window.
    surface: Surface<WindowSurface>,
    context: PossiblyCurrentContext,
    gl: Gl,
    debug_log: DebugLog,
    window: Window,
}

impl GlWindow {
    /// Opens a window.
    pub(super) fn new(events: &ActiveEventLoop, title: &str) -> Result<Self> {
        Self::open(events, title).map_err(unavailable)
    }

    fn open(events: &ActiveEventLoop, title: &str) -> Result<Self, Box<dyn std::error::Error>> {
        let attributes = Window::default_attributes()
            .with_title(title)
            .with_inner_size(LogicalSize::new(1000, 600));
        // The scene is drawn into a framebuffer of its own, so the window needs neither depth nor samples.
        let template = ConfigTemplateBuilder::new().with_depth_size(0).with_stencil_size(0);
        let (window, config): (_, Config) = DisplayBuilder::new()
            .with_preference(ApiPreference::FallbackEgl)
            .with_window_attributes(Some(attributes))
            .build(events, template, |mut configs| {
                // This closure cannot return an error.
                configs.next().unwrap_or_else(|| {
                    eprintln!("freeform: {}", unavailable("no configuration of pixels"));
                    std::process::exit(1)
                })
            })?;
        let window = window.ok_or("no window came with the display")?;
        let handle = window.window_handle()?.as_raw();
        let context = ContextAttributesBuilder::new()
            .with_context_api(ContextApi::OpenGl(Some(Version::new(4, 5))))
            .with_profile(GlProfile::Core)
            .with_debug(true)
            .build(Some(handle));
        let PhysicalSize { width, height } = window.inner_size();
        let at_least_1 = |side| NonZeroU32::new(side).unwrap_or(NonZeroU32::MIN);
        let surface = SurfaceAttributesBuilder::<WindowSurface>::new().build(
            handle,
            at_least_1(width),
            at_least_1(height),
        );
        let display = config.display();
        // SAFETY: the handle is that of the window, which outlives context and surface (see the type).
        let (context, surface) = unsafe {
            let context = display.create_context(&config, &context)?;
            (context, display.create_window_surface(&config, &surface)?)
        };
        let context = context.make_current(&surface)?;
        // Without vertical synchronisation, frames are shown as fast as they are drawn, which is acceptable.
        if let Err(error) = surface.set_swap_interval(&context, SwapInterval::Wait(NonZeroU32::MIN))
        {
            log::debug!("frames do not wait for the screen: {error}");
        }
        // SAFETY: the context is current, so the functions that the display returns belong to it.
        let mut gl = unsafe {
            glow::Context::from_loader_function_cstr(|name| display.get_proc_address(name))
        };
        let debug_log = DebugLog::install(&mut gl);
        // SAFETY: the context stays current; all objects drawn with it are dropped before it (see `Shown`).
        let gl = unsafe { Gl::new(gl) };
        Ok(Self { surface, context, gl, debug_log, window })
    }

    pub(super) const fn gl(&self) -> &Gl {
        &self.gl
    }

    pub(super) const fn window(&self) -> &Window {
        &self.window
    }

    /// The errors that the driver reported since the last call.
    pub(super) fn take_errors(&self) -> Vec<String> {
        self.debug_log.take_errors()
    }

    /// Adapts the surface to the window's new size.
    pub(super) fn resize(&self) {
        self.window.resize_surface(&self.surface, &self.context);
    }

    /// Binds the window's framebuffer for drawing and clears it to black.
    pub(super) fn begin(&self) {
        // SAFETY: the context is current (see the type).
        unsafe {
            self.gl.bind_framebuffer(glow::FRAMEBUFFER, None);
            self.gl.disable(glow::SCISSOR_TEST);
            self.gl.clear_color(0.0, 0.0, 0.0, 1.0);
            self.gl.clear(glow::COLOR_BUFFER_BIT);
        }
    }

    /// Resets state that the panel's painter leaves changed and that the renderer relies on.
    pub(super) fn reset(&self) {
        // SAFETY: the context is current (see the type).
        unsafe {
            self.gl.disable(glow::SCISSOR_TEST);
            self.gl.disable(glow::BLEND);
            self.gl.color_mask(true, true, true, true);
        }
    }

    /// Shows the drawn frame.
    pub(super) fn swap(&self) -> Result<()> {
        self.surface.swap_buffers(&self.context).map_err(|error| Error::Driver {
            what: "the picture in the window".into(),
            reason: error.to_string(),
        })
    }
}

/// The error for a window that cannot be opened.
fn unavailable(reason: impl std::fmt::Display) -> Error {
    Error::Window(format!(
        "no window with OpenGL 4.5 ({reason}); freeform render draws without one"
    ))
}

impl Drop for GlWindow {
    fn drop(&mut self) {
        // The objects that the renderer frees belong to this context.
        if let Err(error) = self.context.make_current(&self.surface) {
            log::debug!("a window is closed without its context: {error}");
        }
    }
}
