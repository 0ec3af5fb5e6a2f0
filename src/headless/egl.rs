//! Contexts on EGL devices, without a window or another EGL surface.

use std::ffi::{CStr, c_void};

use glutin::api::egl::config::Config;
use glutin::api::egl::context::PossiblyCurrentContext;
use glutin::api::egl::device::Device;
use glutin::api::egl::display::Display;
use glutin::config::{ConfigSurfaceTypes, ConfigTemplateBuilder};
use glutin::context::{
    ContextApi, ContextAttributesBuilder, GlProfile, PossiblyCurrentGlContext as _, Version,
};
use glutin::display::GlDisplay as _;

/// A context, made current by [`Context::new`]. After it is dropped, no context is current.
pub(super) struct Context {
    /// `None` only in `drop`. (The type's name is glutin's; another context may be current.)
    current: Option<PossiblyCurrentContext>,
    display: Display,
}

impl Context {
    /// A context on the first device that gives a 4.5 core context; hardware devices are tried
    /// before software ones.
    pub(super) fn new() -> Result<(Self, glow::Context), String> {
        let mut devices: Vec<Device> =
            Device::query_devices().map_err(|error| format!("EGL: {error}"))?.collect();
        devices.sort_by_key(|device| device.extensions().contains("EGL_MESA_device_software"));
        let mut reasons = Vec::new();
        for device in &devices {
            match Self::on(device) {
                Ok(made) => return Ok(made),
                Err(error) => {
                    let name = device.name().unwrap_or("unnamed device");
                    reasons.push(format!("{name}: {error}"));
                }
            }
        }
        if reasons.is_empty() {
            reasons.push("no device".into());
        }
        Err(format!("EGL: {}", reasons.join(", ")))
    }

    fn on(device: &Device) -> Result<(Self, glow::Context), glutin::error::Error> {
        // SAFETY: the device comes from EGL, and no display handle is passed.
        let display = unsafe { Display::with_device(device, None)? };
        let template =
            ConfigTemplateBuilder::new().with_surface_type(ConfigSurfaceTypes::empty()).build();
        // SAFETY: the template names no window.
        let config: Option<Config> = unsafe { display.find_configs(template)?.next() };
        let config = config.ok_or(glutin::error::ErrorKind::BadConfig)?;
        let attributes = ContextAttributesBuilder::new()
            .with_context_api(ContextApi::OpenGl(Some(Version::new(4, 5))))
            .with_profile(GlProfile::Core)
            .with_debug(true)
            .build(None);
        // SAFETY: the config is this display's, and no window handle is passed.
        let context = unsafe { display.create_context(&config, &attributes)? };
        let context = context.make_current_surfaceless()?;
        let context = Self { current: Some(context), display };
        // SAFETY: the context is current, so EGL returns its functions.
        let gl =
            unsafe { glow::Context::from_loader_function_cstr(|name| context.proc_address(name)) };
        Ok((context, gl))
    }

    pub(super) fn make_current(&self) -> Result<(), String> {
        let context = self.current.as_ref().ok_or("EGL: the context is gone")?;
        context.make_current_surfaceless().map_err(|error| format!("EGL: {error}"))
    }

    pub(super) fn proc_address(&self, name: &CStr) -> *const c_void {
        self.display.get_proc_address(name)
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        if let Some(Err(error)) = self.current.take().map(|context| context.make_not_current()) {
            log::debug!("EGL context was not released: {error}");
        }
    }
}
