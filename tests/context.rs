//! Headless contexts: both backends, many at once, and what the driver says.
#![allow(unsafe_code, reason = "one test makes a mistake in OpenGL on purpose")]

mod common;

use freeform_surface::{Backend, Headless, Scene};
use glam::UVec2;
use glow::HasContext as _;

use common::{Checked, backends, render};

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
fn backends_have_names() {
    for name in ["auto", "egl", "osmesa"] {
        assert_eq!(name.parse::<Backend>().unwrap().to_string(), name);
    }
    assert!("vulkan".parse::<Backend>().unwrap_err().to_string().contains("osmesa"));
}
