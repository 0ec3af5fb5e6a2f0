//! The library inside a context that is yours: it needs a `glow::Context` and draws into whatever
//! framebuffer is bound, between your own draws.
//!
//! Here the context and the framebuffer come from bare EGL through glutin, as a window's would; the
//! library's own headless contexts are not used. `cargo run --release --example own_context` writes
//! `own_context.png`.
#![allow(unsafe_code, reason = "a caller with a context of its own calls OpenGL itself")]

use freeform_surface::glam::{DVec3, dvec2};
use freeform_surface::{Camera, Frame, FreeFormSurface, Gl, RenderSettings, Renderer};
use glow::{HasContext, PixelPackData};
use glutin::api::egl::{device::Device, display::Display};
use glutin::config::{ConfigSurfaceTypes, ConfigTemplateBuilder};
use glutin::context::{ContextApi, ContextAttributesBuilder, GlProfile, Version};
use glutin::display::GlDisplay as _;

const SIZE: i32 = 512;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let device = Device::query_devices()?.next().ok_or("EGL has no device")?;
    let attributes = ContextAttributesBuilder::new()
        .with_context_api(ContextApi::OpenGl(Some(Version::new(4, 5))))
        .with_profile(GlProfile::Core)
        .build(None);
    let template =
        ConfigTemplateBuilder::new().with_surface_type(ConfigSurfaceTypes::empty()).build();
    // SAFETY: device, display, config and context belong together; no window handle is passed. The context
    // stays current as long as the handle lives.
    let (_context, gl) = unsafe {
        let display = Display::with_device(&device, None)?;
        let config = display.find_configs(template)?.next().ok_or("EGL has no config")?;
        let context = display.create_context(&config, &attributes)?.make_current_surfaceless()?;
        let gl = glow::Context::from_loader_function_cstr(|name| display.get_proc_address(name));
        (context, Gl::new(gl))
    };

    // A framebuffer of the caller's that already contains a blue upper half.
    // SAFETY: the context is current.
    let (framebuffer, renderbuffers) = unsafe {
        let framebuffer = gl.create_framebuffer()?;
        let renderbuffers = [gl.create_renderbuffer()?, gl.create_renderbuffer()?];
        gl.bind_framebuffer(glow::FRAMEBUFFER, Some(framebuffer));
        for (buffer, format, attachment) in [
            (renderbuffers[0], glow::RGBA8, glow::COLOR_ATTACHMENT0),
            (renderbuffers[1], glow::DEPTH_COMPONENT24, glow::DEPTH_ATTACHMENT),
        ] {
            gl.bind_renderbuffer(glow::RENDERBUFFER, Some(buffer));
            gl.renderbuffer_storage(glow::RENDERBUFFER, format, SIZE, SIZE);
            gl.framebuffer_renderbuffer(
                glow::FRAMEBUFFER,
                attachment,
                glow::RENDERBUFFER,
                Some(buffer),
            );
        }
        gl.clear_color(1.0, 1.0, 1.0, 1.0);
        gl.clear(glow::COLOR_BUFFER_BIT | glow::DEPTH_BUFFER_BIT);
        gl.enable(glow::SCISSOR_TEST);
        gl.scissor(0, SIZE / 2, SIZE, SIZE / 2);
        gl.clear_color(0.6, 0.75, 0.95, 1.0);
        gl.clear(glow::COLOR_BUFFER_BIT);
        gl.disable(glow::SCISSOR_TEST);
        (framebuffer, renderbuffers)
    };

    {
        let mut renderer = Renderer::new(&gl)?;
        let mut surface = FreeFormSurface::new(&renderer)?;
        for index in [5, 6, 9, 10] {
            let raised = surface.control_points()[index].truncate().with_y(0.5);
            surface.set_specific_control_point(raised, index)?;
        }
        surface.circular_trimming(0.2, dvec2(0.5, 0.5))?;
        let points = surface.surface().world_points();
        let camera = Camera::framing(points.clone(), DVec3::Y, 1.0);
        let size = (SIZE as u32, SIZE as u32);
        let frame = Frame::new(camera.projection(points, 1.0), size, RenderSettings::default());
        let stats = surface.render(&mut renderer, &frame)?;
        println!("{} triangles in {} draws", stats.triangles, stats.draws);
    }

    let mut pixels = vec![0; (4 * SIZE * SIZE) as usize];
    // SAFETY: the context is current and the slice holds SIZE × SIZE RGBA pixels.
    unsafe {
        let to = PixelPackData::Slice(Some(&mut pixels));
        gl.read_pixels(0, 0, SIZE, SIZE, glow::RGBA, glow::UNSIGNED_BYTE, to);
        gl.delete_framebuffer(framebuffer);
        for buffer in renderbuffers {
            gl.delete_renderbuffer(buffer);
        }
    }
    let picture = image::RgbaImage::from_raw(SIZE as u32, SIZE as u32, pixels).ok_or("pixels")?;
    image::imageops::flip_vertical(&picture).save("own_context.png")?;
    println!("wrote own_context.png");
    Ok(())
}
