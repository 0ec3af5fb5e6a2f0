//! Headless contexts: both backends, many contexts at once, and the driver's messages.
#![allow(unsafe_code, reason = "one test makes a mistake in OpenGL on purpose")]

use std::time::Duration;

use freeform_surface::inspect::Timer;
use freeform_surface::{
    Backend, Error, Frame, Framebuffer, Headless, Method, Offscreen, PreparedScene, Renderer,
    Samples, Scene, TessLevel, Tessellation, Viewport,
};
use glam::{IVec2, UVec2};
use glow::HasContext as _;

use crate::harness::{Checked, assert_same, backends, draw, render};

#[test]
fn every_backend_gives_what_the_program_relies_on() {
    for backend in backends() {
        let context = Checked::new(backend);
        let info = context.info();
        assert_eq!(context.backend(), backend);
        assert!(info.max_patch_vertices >= 25 && info.max_tess_level >= 64, "{info:?}");
        assert!(info.max_fragment_storage_blocks >= 2 && info.max_size >= 4096, "{info:?}");
        assert!(info.version.contains('.') && !info.renderer.is_empty(), "{info:?}");
    }
    assert!(matches!(
        Headless::new(Backend::Auto).unwrap().backend(),
        Backend::Egl | Backend::Osmesa
    ));
}

#[test]
fn a_mistake_in_opengl_reaches_the_debug_log() {
    for backend in backends() {
        let context = Headless::new(backend).unwrap();
        assert!(context.debug_log().take_errors().is_empty());
        // SAFETY: the context is current; an unknown capability is an error without effect.
        unsafe { context.gl().enable(0xdead) };
        let errors = context.debug_log().take_errors();
        assert!(!errors.is_empty() && errors[0].contains("GL_INVALID_ENUM"), "{errors:?}");
        assert!(context.debug_log().take_errors().is_empty());
    }
}

#[test]
fn what_was_made_with_a_context_keeps_it() {
    let scene = Scene::listing16();
    let size = UVec2::new(64, 48);
    for backend in backends() {
        let expected = render(&scene, size, backend);
        let context = Headless::new(backend).unwrap();
        let target = Framebuffer::new(context.gl(), size.x, size.y).unwrap();
        let mut renderer = Renderer::new(context.gl()).unwrap();
        drop(context);
        let mut prepared = PreparedScene::new(&renderer, &scene).unwrap();
        crate::harness::draw(&scene, &mut prepared, &mut renderer, &target);
        assert_eq!(target.read(), expected);
    }
}

#[test]
fn a_scene_can_be_prepared_for_every_method_and_switched_between_them() {
    let size = UVec2::new(96, 64);
    let level = Tessellation::Level(TessLevel::new(7).unwrap());
    let mut scenes = Vec::new();
    for method in [Method::Thesis, Method::Exact, Method::Thesis, Method::Exact] {
        for tessellation in [level, Tessellation::default()] {
            let mut scene = Scene::listing16();
            scene.settings.method = method;
            scene.settings.tessellation = tessellation;
            scenes.push(scene);
        }
    }
    for backend in backends() {
        let expected: Vec<_> = scenes.iter().map(|scene| render(scene, size, backend)).collect();
        let context = Checked::new(backend);
        let target = Framebuffer::new(context.gl(), size.x, size.y).unwrap();
        let mut renderer = Renderer::new(context.gl()).unwrap();
        let mut prepared = PreparedScene::new(&renderer, &scenes[0]).unwrap();
        target.bind();
        for (scene, expected) in scenes.iter().zip(expected) {
            let frame = Frame::of(scene, size);
            prepared.prepare(&renderer, &frame).unwrap();
            let _ = prepared.draw(&mut renderer, &frame).unwrap();
            assert!(target.read() == expected, "{:?}", scene.settings);
        }
    }
}

#[test]
fn contexts_on_many_threads_do_not_disturb_each_other() {
    let scene = Scene::listing16();
    let size = UVec2::new(64, 48);
    for backend in backends() {
        let expected = render(&scene, size, backend);
        std::thread::scope(|scope| {
            let threads: Vec<_> = (0..6)
                .map(|_| {
                    scope
                        .spawn(|| (0..3).map(|_| render(&scene, size, backend)).collect::<Vec<_>>())
                })
                .collect();
            for thread in threads {
                for picture in thread.join().unwrap() {
                    assert_eq!(picture, expected);
                }
            }
        });
    }
}

#[test]
fn several_contexts_of_one_thread_take_turns() {
    for backend in backends() {
        let [first, second] = [Checked::new(backend), Checked::new(backend)];
        let targets = [&first, &second].map(|context| {
            context.make_current().unwrap();
            let target = Framebuffer::new(context.gl(), 8, 8).unwrap();
            target.bind();
            target
        });
        let [target_of_first, target_of_second] = targets;
        for (context, target, red) in
            [(&first, &target_of_first, 0.0), (&second, &target_of_second, 1.0)]
        {
            context.make_current().unwrap();
            let renderer = Renderer::new(context.gl()).unwrap();
            renderer.clear([red, 0.0, 0.0, 1.0]);
            assert_eq!(target.read().get_pixel(0, 0).0, [(red * 255.0) as u8, 0, 0, 255]);
        }
        first.make_current().unwrap();
        drop(target_of_first);
        drop(first);
        second.make_current().unwrap();
        assert_eq!(target_of_second.read().get_pixel(0, 0).0, [255, 0, 0, 255]);
    }
}

#[test]
fn dropping_a_context_leaves_the_log_of_another_alone() {
    for backend in backends() {
        let first = Headless::new(backend).unwrap();
        let second = Headless::new(backend).unwrap();
        drop(first);
        second.make_current().unwrap();
        // SAFETY: the context is current; an unknown capability is an error without effect.
        unsafe { second.gl().enable(0xdead) };
        assert!(!second.debug_log().take_errors().is_empty());
    }
}

/// A caller's own OpenGL state must change neither the picture nor the places where memory is read and written.
#[test]
fn the_state_of_the_caller_does_not_show() {
    let scene = Scene::listing16();
    let size = UVec2::new(160, 120);
    let expected = render(&scene, size, backends()[0]);
    let context = Checked::new(backends()[0]);
    let gl = context.gl();
    let target = Framebuffer::new(gl, size.x, size.y).unwrap();
    // SAFETY: the context is current; all objects are made here and live on.
    unsafe {
        for parameter in [
            glow::PACK_ROW_LENGTH,
            glow::PACK_SKIP_ROWS,
            glow::PACK_SKIP_PIXELS,
            glow::UNPACK_ROW_LENGTH,
            glow::UNPACK_SKIP_ROWS,
            glow::UNPACK_SKIP_PIXELS,
        ] {
            gl.pixel_store_i32(parameter, 5000);
        }
        gl.pixel_store_i32(glow::PACK_ALIGNMENT, 8);
        for target in [glow::PIXEL_PACK_BUFFER, glow::PIXEL_UNPACK_BUFFER] {
            let buffer = gl.create_buffer().unwrap();
            gl.bind_buffer(target, Some(buffer));
            gl.buffer_data_size(target, 16, glow::STREAM_DRAW);
        }
        let sampler = gl.create_sampler().unwrap();
        gl.sampler_parameter_i32(sampler, glow::TEXTURE_MIN_FILTER, glow::NEAREST as i32);
        gl.sampler_parameter_i32(sampler, glow::TEXTURE_MAG_FILTER, glow::NEAREST as i32);
        gl.bind_sampler(0, Some(sampler));
        gl.depth_func(glow::NEVER);
        gl.enable(glow::BLEND);
        gl.blend_func(glow::ZERO, glow::ONE);
        gl.enable(glow::CULL_FACE);
        gl.cull_face(glow::FRONT_AND_BACK);
        gl.enable(glow::STENCIL_TEST);
        gl.polygon_mode(glow::FRONT_AND_BACK, glow::POINT);
        gl.patch_parameter_i32(glow::PATCH_VERTICES, 3);
    }
    let mut renderer = Renderer::new(gl).unwrap();
    let mut prepared = PreparedScene::new(&renderer, &scene).unwrap();
    draw(&scene, &mut prepared, &mut renderer, &target);
    assert_eq!(target.read(), expected);
    // SAFETY: the context is current.
    unsafe { gl.enable(glow::RASTERIZER_DISCARD) };
    target.bind();
    draw(&scene, &mut prepared, &mut renderer, &target);
    assert_eq!(target.read(), expected);
}

#[test]
fn the_devices_clock_runs_and_hands_errors_on() {
    for backend in backends() {
        let context = Checked::new(backend);
        let gl = context.gl();
        let target = Framebuffer::new(gl, 256, 256).unwrap();
        let scene = Scene::listing16();
        let mut renderer = Renderer::new(gl).unwrap();
        let mut prepared = PreparedScene::new(&renderer, &scene).unwrap();
        let timer = Timer::new(gl).unwrap();
        let time = timer.time(|| {
            draw(&scene, &mut prepared, &mut renderer, &target);
            Ok::<(), Error>(())
        });
        let time = time.unwrap();
        assert!(time > Duration::ZERO && time < Duration::from_secs(60), "{backend}: {time:?}");
        let wrong = || Err(Error::Context("on purpose".into()));
        assert!(timer.time(wrong).unwrap_err().to_string().contains("on purpose"));
        // The timer is ready for the next measurement.
        assert!(timer.time(|| Ok::<(), Error>(())).unwrap() < Duration::from_secs(60));
    }
}

#[test]
fn backends_have_names() {
    for name in ["auto", "egl", "osmesa"] {
        assert_eq!(name.parse::<Backend>().unwrap().to_string(), name);
    }
    assert!("vulkan".parse::<Backend>().unwrap_err().to_string().contains("osmesa"));
}

#[test]
fn a_frame_is_drawn_in_its_viewport_whatever_the_context_has() {
    let scene = Scene::listing16();
    let size = UVec2::new(96, 64);
    let origin = IVec2::new(18, 10);
    for backend in backends() {
        let context = Checked::new(backend);
        let mut renderer = Renderer::new(context.gl()).unwrap();
        let mut prepared = PreparedScene::new(&renderer, &scene).unwrap();
        let mut drawn = |target: &Framebuffer, frame: &Frame, viewport: i32| {
            target.bind();
            // SAFETY: the context is current.
            unsafe { context.gl().viewport(0, 0, viewport, viewport) };
            let stats = prepared.draw(&mut renderer, frame).unwrap();
            (stats, target.read())
        };
        let frame = Frame::of(&scene, size);
        let own = Framebuffer::new(context.gl(), size.x, size.y).unwrap();
        let (stats, expected) = drawn(&own, &frame, 7);
        assert_eq!((stats, expected.clone()), drawn(&own, &frame, 1000), "{backend}");
        // At an offset in a larger framebuffer, the picture is the same.
        let large = Framebuffer::new(context.gl(), 160, 120).unwrap();
        let moved = Frame { viewport: Viewport { origin, size }, ..frame };
        let (moved_stats, picture) = drawn(&large, &moved, 1000);
        assert_eq!(moved_stats, stats);
        let top = 120 - origin.y as u32 - size.y;
        let part = image::imageops::crop_imm(&picture, origin.x as u32, top, size.x, size.y);
        assert_same("viewport", &expected, &part.to_image(), &[], 1);
        // So it is of many samples, each a drawing of its own.
        let mut many = frame;
        many.settings.samples = Samples::new(16).unwrap();
        let expected = prepared.picture(&mut renderer, &own, &many, |_, _| {}).unwrap();
        let moved = Frame { settings: many.settings, ..moved };
        let picture = prepared.picture(&mut renderer, &large, &moved, |_, _| {}).unwrap();
        let part = image::imageops::crop_imm(&picture, origin.x as u32, top, size.x, size.y);
        assert_same("viewport of 16 samples", &expected, &part.to_image(), &[], 1);
    }
}

#[test]
fn an_offscreen_is_dropped_in_its_own_context() {
    let scene = Scene::listing16();
    let first = Offscreen::new(64, 48).unwrap();
    let mut second = Offscreen::new(64, 48).unwrap();
    let (before, _) = second.render(&scene).unwrap();
    // Both contexts number their objects alike.
    drop(first);
    second.context().make_current().unwrap();
    let (after, _) = second.render(&scene).unwrap();
    assert!(before == after && before.pixels().any(|pixel| *pixel != before[(0, 0)]));
    assert_eq!(second.context().debug_log().take_errors(), Vec::<String>::new());
}
