//! The smallest window that uses the library. It shows one surface. Left and Right turn it, Up and Down change
//! its level, W switches to lines, C cuts the hole, and Esc closes the window.
//!
//! `cargo run --release --features viewer --example demo`
#![allow(unsafe_code, reason = "a window's context is made and read by unsafe calls")]

use std::error::Error;
use std::num::NonZeroU32;

use freeform_surface::{Frame, FreeFormSurface, Gl, Renderer, Scene, TessLevel, Tessellation};
use glam::DMat4;
use glutin::config::ConfigTemplateBuilder;
use glutin::context::{
    ContextApi, ContextAttributesBuilder, NotCurrentGlContext as _, PossiblyCurrentContext, Version,
};
use glutin::display::{GetGlDisplay as _, GlDisplay as _};
use glutin::surface::{GlSurface as _, Surface, SurfaceAttributesBuilder, WindowSurface};
use glutin_winit::{DisplayBuilder, GlWindow as _};
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoop};
use winit::keyboard::{Key, NamedKey};
use winit::raw_window_handle::HasWindowHandle as _;
use winit::window::{Window, WindowId};

/// Everything that belongs to the window; the objects that are drawn are dropped before their context.
struct Shown {
    freeform: FreeFormSurface,
    renderer: Renderer,
    surface: Surface<WindowSurface>,
    context: PossiblyCurrentContext,
    window: Window,
}

/// The scene, and the window as soon as it exists.
struct Demo {
    scene: Scene,
    level: i64,
    angle: f64,
    hole: bool,
    shown: Option<Shown>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut demo =
        Demo { scene: Scene::listing16(), level: 32, angle: 0.0, hole: true, shown: None };
    Ok(EventLoop::new()?.run_app(&mut demo)?)
}

impl Shown {
    fn new(events: &ActiveEventLoop, scene: &Scene) -> Result<Self, Box<dyn Error>> {
        // The library uses the depth buffer of the window.
        let template = ConfigTemplateBuilder::new().with_depth_size(24);
        let (window, config) = DisplayBuilder::new()
            .with_window_attributes(Some(Window::default_attributes().with_title("demo")))
            .build(events, template, |mut configs| configs.next().expect("a configuration"))?;
        let window = window.ok_or("no window")?;
        let handle = window.window_handle()?.as_raw();
        let attributes = ContextAttributesBuilder::new()
            .with_context_api(ContextApi::OpenGl(Some(Version::new(4, 5))))
            .build(Some(handle));
        let size = window.inner_size();
        let [width, height] =
            [size.width, size.height].map(|side| NonZeroU32::new(side).unwrap_or(NonZeroU32::MIN));
        let pixels = SurfaceAttributesBuilder::<WindowSurface>::new().build(handle, width, height);
        let display = config.display();
        // SAFETY: the handle is the window's, which outlives context and surface.
        let (context, surface) = unsafe {
            let context = display.create_context(&config, &attributes)?;
            (context, display.create_window_surface(&config, &pixels)?)
        };
        let context = context.make_current(&surface)?;
        // SAFETY: the context is current and stays current; all objects drawn with it are dropped before it.
        let gl = unsafe {
            Gl::new(glow::Context::from_loader_function_cstr(|name| display.get_proc_address(name)))
        };
        let renderer = Renderer::new(&gl)?;
        let freeform = FreeFormSurface::from_surface(&renderer, scene.surfaces[0].clone())?;
        Ok(Self { freeform, renderer, surface, context, window })
    }
}

impl Demo {
    fn key(&mut self, key: &Key, events: &ActiveEventLoop) -> freeform_surface::Result<()> {
        let Some(shown) = &mut self.shown else { return Ok(()) };
        let freeform = &mut shown.freeform;
        match key {
            Key::Named(NamedKey::Escape) => events.exit(),
            Key::Named(NamedKey::ArrowLeft) => self.angle -= 0.1,
            Key::Named(NamedKey::ArrowRight) => self.angle += 0.1,
            Key::Named(NamedKey::ArrowUp) => self.level = (self.level + 1).min(50),
            Key::Named(NamedKey::ArrowDown) => self.level = (self.level - 1).max(1),
            Key::Character(key) if key == "w" => {
                self.scene.settings.wireframe = !self.scene.settings.wireframe;
            }
            Key::Character(key) if key == "c" && self.hole => {
                freeform.disable_circular_trimming();
                self.hole = false;
            }
            Key::Character(key) if key == "c" => {
                freeform.enable_circular_trimming();
                self.hole = true;
            }
            _ => {}
        }
        let turned = DMat4::from_translation(glam::dvec3(0.0, 1.0, 0.0))
            * DMat4::from_rotation_y(self.angle);
        freeform.set_model_matrix(turned)?;
        self.scene.settings.tessellation = Tessellation::Level(TessLevel::new(self.level)?);
        shown.window.request_redraw();
        Ok(())
    }

    fn draw(&mut self) -> Result<(), Box<dyn Error>> {
        let Some(shown) = &mut self.shown else { return Ok(()) };
        let size = shown.window.inner_size();
        let (width, height) = (size.width.max(1), size.height.max(1));
        let frame = Frame::of(&self.scene, (width, height));
        shown.renderer.clear(frame.settings.background);
        let _ = shown.freeform.render(&mut shown.renderer, &frame)?;
        Ok(shown.surface.swap_buffers(&shown.context)?)
    }
}

impl ApplicationHandler for Demo {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        match Shown::new(events, &self.scene) {
            Ok(shown) => self.shown = Some(shown),
            Err(error) => {
                eprintln!("demo: {error}");
                events.exit();
            }
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let done = match event {
            WindowEvent::CloseRequested => {
                events.exit();
                Ok(())
            }
            WindowEvent::Resized(_) => {
                if let Some(shown) = &self.shown {
                    shown.window.resize_surface(&shown.surface, &shown.context);
                    shown.window.request_redraw();
                }
                Ok(())
            }
            WindowEvent::KeyboardInput { event, .. } if event.state.is_pressed() => {
                self.key(&event.logical_key, events).map_err(Into::into)
            }
            WindowEvent::RedrawRequested => self.draw(),
            _ => Ok(()),
        };
        if let Err(error) = done {
            eprintln!("demo: {error}");
        }
    }

    fn exiting(&mut self, _: &ActiveEventLoop) {
        // The window is dropped while the window system still exists.
        self.shown = None;
    }
}
