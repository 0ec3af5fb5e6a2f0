//! Surfaces are created and dropped without leaks. The test is alone in its process, because it observes the
//! memory of the whole process.
#![cfg(target_os = "linux")]
#![allow(unsafe_code, reason = "the driver is asked which objects exist")]

#[path = "harness/mod.rs"]
mod harness;

use std::num::NonZeroU32;
use std::rc::Rc;

use freeform_surface::{
    Frame, Framebuffer, FreeFormSurface, Headless, Image, Offscreen, Renderer, Samples, Scene,
    TessLevel, Tessellation, Texture,
};
use glam::dvec2;
use glow::HasContext as _;

use harness::{Checked, backends};

/// Resident memory of the process in bytes.
fn resident() -> u64 {
    let statm = std::fs::read_to_string("/proc/self/statm").unwrap();
    let pages: u64 = statm.split_whitespace().nth(1).unwrap().parse().unwrap();
    pages * 4096
}

/// Buffers, textures, programs, shaders, framebuffers and renderbuffers that exist, by their OpenGL names.
fn objects(gl: &glow::Context) -> Vec<(char, u32)> {
    // SAFETY: the context is current; any name may be queried.
    let exists = |kind: char, number: NonZeroU32| unsafe {
        match kind {
            'b' => gl.is_buffer(glow::NativeBuffer(number)),
            't' => gl.is_texture(glow::NativeTexture(number)),
            'f' => gl.is_framebuffer(glow::NativeFramebuffer(number)),
            'r' => gl.is_renderbuffer(glow::NativeRenderbuffer(number)),
            'p' => gl.is_program(glow::NativeProgram(number)),
            _ => gl.is_shader(glow::NativeShader(number)),
        }
    };
    "btpsfr"
        .chars()
        .flat_map(|kind| (1..50_000).map(move |number| (kind, number)))
        .filter(|(kind, number)| exists(*kind, NonZeroU32::new(*number).unwrap()))
        .collect()
}

/// One after the other, because both look at the memory of the whole process.
#[test]
fn nothing_is_left_behind() {
    ten_thousand_surfaces();
    pictures_of_scenes();
}

/// Scenes of all kinds are drawn one after the other by one `Offscreen`, as by a worker of `freeform render`.
fn pictures_of_scenes() {
    let names =
        ["scenes/thesis/fig22.toml", "surfaces/teapot.bpt", "models/flange.ffm", "meshes/cube.obj"];
    let paths = names.map(|name| harness::root().join("resources").join(name));
    for backend in backends() {
        let mut offscreen = Offscreen::in_context(Headless::new(backend).unwrap(), 16, 16).unwrap();
        let mut round = |samples| {
            for path in &paths {
                let mut scene = harness::load(path);
                scene.settings.samples = Samples::new(samples).unwrap();
                let _ = offscreen.render(&scene).unwrap();
            }
            let scene = Scene { surfaces: vec![], ..Scene::default() };
            let _ = offscreen.render(&scene).unwrap();
            objects(offscreen.context().gl()).len()
        };
        // The programs and the framebuffer stay.
        let _ = (round(4), round(1));
        let before = [round(4), round(1)];
        for _ in 0..20 {
            assert_eq!([round(4), round(1)], before, "{backend}");
        }
    }
}

fn ten_thousand_surfaces() {
    for backend in backends() {
        let context = Checked::new(backend);
        let gl = context.gl();
        let nothing_yet = objects(gl);
        let target = Framebuffer::new(gl, 16, 16).unwrap();
        let mut renderer = Renderer::new(gl).unwrap();
        let scene = Scene::listing16();
        let mut settings = scene.settings;
        settings.tessellation = Tessellation::Level(TessLevel::new(2).unwrap());
        let frame = Frame::new(scene.projection(16, 16), (16, 16), settings);
        target.bind();
        let mut round = || {
            let mut surface = FreeFormSurface::new(&renderer).unwrap();
            let image = Image::from_pixel(4, 4, image::Rgba([200, 100, 50, 255]));
            surface.set_texture(Rc::new(Texture::new(gl, "round", &image).unwrap()));
            for center in [dvec2(0.3, 0.3), dvec2(0.7, 0.7)] {
                surface.circular_trimming(0.1, center).unwrap();
                surface.add_circle(surface.trims().circles[0]).unwrap();
            }
            let [a, b, c, d] =
                [(0.2, 0.5), (0.5, 0.9), (0.8, 0.5), (0.5, 0.1)].map(|(u, v)| dvec2(u, v));
            surface.set_bezier_curve_trimming(a, b, c, d).unwrap();
            let _ = surface.render(&mut renderer, &frame).unwrap();
            // A software driver queues commands, and memory with them, until the program waits for it.
            gl.finish();
        };
        round();
        let objects_before = objects(gl);
        for _ in 0..100 {
            round();
        }
        let before = resident();
        for _ in 0..10_000 {
            round();
        }
        let after = resident();
        assert_eq!(objects(gl), objects_before);
        assert!(
            after <= before + before / 20,
            "{backend}: resident memory grew from {before} to {after} bytes"
        );
        drop((renderer, target));
        assert_eq!(objects(gl), nothing_yet);
    }
}
