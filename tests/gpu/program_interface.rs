//! The linked programs have the names and locations of the thesis' listings.
#![allow(unsafe_code, reason = "one question to a program is asked of OpenGL itself")]

use freeform_surface::inspect::Program;
use freeform_surface::inspect::programs::{
    CONTROL_POINTS_UNIT, DOMAINS_UNIT, Output, Painting, PatchKind, Pipeline, ProgramKey,
    SUB_PATCHES_UNIT, SURFACES_UNIT, Sources, TRIM_POINTS_BINDING, TRIM_SHAPES_BINDING,
    TRIM_WORDS_UNIT, TrimFeatures, location,
};
use freeform_surface::{AnalysisKind, Degree, Error, Headless, Light, Method, Normals, Shading};
use glow::HasContext as _;

use crate::harness::{Checked, backends};

/// The binding point of a storage block, queried from the linked program. (glow 0.17 first queries the length
/// of the answer, which Mesa reports as 0.)
fn storage_binding(context: &Headless, program: &Program, block: &str) -> Option<i32> {
    type GetProgramResourceiv = unsafe extern "C" fn(
        program: u32,
        interface: u32,
        index: u32,
        property_count: i32,
        properties: *const u32,
        size: i32,
        length: *mut i32,
        values: *mut i32,
    );
    let address = context.proc_address(c"glGetProgramResourceiv");
    assert!(!address.is_null());
    let mut value = [-1];
    // SAFETY: the function exists since OpenGL 4.3 with this signature; it writes one number.
    unsafe {
        let query: GetProgramResourceiv = std::mem::transmute(address);
        let index = context.gl().get_shader_storage_block_index(program.raw(), block)?;
        let properties = [glow::BUFFER_BINDING];
        query(
            program.raw().0.get(),
            glow::SHADER_STORAGE_BLOCK,
            index,
            1,
            properties.as_ptr(),
            1,
            std::ptr::null_mut(),
            value.as_mut_ptr(),
        );
    }
    Some(value[0])
}

#[test]
fn the_thesis_program_has_every_name_of_the_listings() {
    for backend in backends() {
        let context = Checked::new(backend);
        for degree in [Degree::CUBIC, Degree::QUARTIC] {
            let key = ProgramKey {
                pipeline: Pipeline::Thesis(degree),
                shading: Shading::Phong,
                analysis: None,
                light: Light::Thesis,
                trims: TrimFeatures::ALL,
                output: Output::Picture,
                far_depth: false,
                cut_out: false,
            };
            let program = Sources::default().link(context.gl(), key).unwrap();
            for (name, place) in [
                ("tessLevel", location::TESS_LEVEL),
                ("modelMatrix", location::MODEL),
                ("viewMatrix", location::VIEW),
                ("projectionMatrix", location::PROJECTION),
                ("part", location::PART),
                ("trimValuesx", location::TRIM_VALUES_X),
                ("trimValuesy", location::TRIM_VALUES_Y),
                ("trimRadius", location::TRIM_RADIUS),
                ("trimCenter", location::TRIM_CENTER),
                ("trimRadius1", location::TRIM_RADIUS_1),
                ("trimRadius2", location::TRIM_RADIUS_2),
                ("trimEllipseCenter", location::TRIM_ELLIPSE_CENTER),
                ("circBool", location::CIRC_BOOL),
                ("intervalBool", location::INTERVAL_BOOL),
                ("ellipseBool", location::ELLIPSE_BOOL),
                ("bezierBool", location::BEZIER_BOOL),
                ("bezierBool2", location::BEZIER_BOOL_2),
                ("cubicBezierBool", location::CUBIC_BEZIER_BOOL),
                ("cubicBezierBool2", location::CUBIC_BEZIER_BOOL_2),
                ("newtonIterations", location::NEWTON_ITERATIONS),
                ("newtonEpsilon", location::NEWTON_EPSILON),
            ] {
                assert_eq!(program.uniform_location(name), Some(place), "{name}");
            }
            assert_eq!(program.uniform_i32("colortexture"), Some(0));
            let binding = |block| storage_binding(&context, &program, block);
            assert_eq!(binding("trimPointsSsbo"), Some(1));
            assert_eq!(TRIM_POINTS_BINDING, 1);
            assert_eq!(binding("trimShapesSsbo"), Some(TRIM_SHAPES_BINDING as i32));
        }
    }
}

#[test]
fn the_report_program_has_the_names_of_the_report() {
    for backend in backends() {
        let context = Checked::new(backend);
        let key = ProgramKey {
            pipeline: Pipeline::Report,
            shading: Shading::Unlit,
            analysis: None,
            light: Light::Thesis,
            trims: TrimFeatures::default(),
            output: Output::Picture,
            far_depth: false,
            cut_out: false,
        };
        let program = Sources::default().link(context.gl(), key).unwrap();
        for (name, place) in [
            ("tessLevel", location::TESS_LEVEL),
            ("model", location::MODEL),
            ("view", location::VIEW),
            ("projection", location::PROJECTION),
            ("part", location::PART),
            ("wireframe", location::WIREFRAME),
            ("showControlPoints", location::SHOW_CONTROL_POINTS),
        ] {
            assert_eq!(program.uniform_location(name), Some(place), "{name}");
        }
        assert_eq!(program.uniform_i32("textureSurface"), Some(0));
    }
}

#[test]
fn without_trims_no_trim_code_is_compiled_in() {
    let context = Checked::new(backends()[0]);
    let link = |trims| {
        let key = ProgramKey {
            pipeline: Pipeline::Thesis(Degree::CUBIC),
            shading: Shading::Phong,
            analysis: None,
            light: Light::Thesis,
            trims,
            output: Output::Picture,
            far_depth: false,
            cut_out: false,
        };
        Sources::default().link(context.gl(), key).unwrap()
    };
    let program = link(TrimFeatures::default());
    for name in ["circBool", "intervalBool", "ellipseBool", "bezierBool", "newtonEpsilon"] {
        assert_eq!(program.uniform_location(name), None, "{name}");
    }
    assert_eq!(storage_binding(&context, &program, "trimPointsSsbo"), None);
    let circles = link(TrimFeatures { circles: true, ..TrimFeatures::default() });
    assert!(circles.uniform_location("circBool").is_some());
    assert_eq!(circles.uniform_location("intervalBool"), None);
}

/// Every kind of trim compiles alone, so that no code of one kind relies on another.
#[test]
fn every_kind_of_trim_compiles_alone_and_in_the_report_program() {
    let context = Checked::new(backends()[0]);
    let none = TrimFeatures::default();
    for trims in [
        TrimFeatures { circles: true, ..none },
        TrimFeatures { intervals: true, ..none },
        TrimFeatures { ellipses: true, ..none },
        TrimFeatures { ellipses: true, more_shapes: true, ..none },
        TrimFeatures { quadratics: true, ..none },
        TrimFeatures { nested_quadratics: true, ..none },
        TrimFeatures { cubics: true, ..none },
        TrimFeatures { nested_cubics: true, ..none },
        TrimFeatures::ALL,
    ] {
        for (pipeline, shading) in [
            (Pipeline::Thesis(Degree::CUBIC), Shading::Phong),
            (Pipeline::Thesis(Degree::QUARTIC), Shading::Normals),
            (Pipeline::Thesis(Degree::CUBIC), Shading::Unlit),
            (Pipeline::Report, Shading::Unlit),
        ] {
            let key = ProgramKey {
                pipeline,
                shading,
                analysis: None,
                light: Light::Thesis,
                trims,
                output: Output::Picture,
                far_depth: false,
                cut_out: false,
            };
            Sources::default().link(context.gl(), key).unwrap_or_else(|e| panic!("{key:?}: {e}"));
        }
    }
}

/// The exact program compiles with every set of features, for one sample and for four.
#[test]
fn the_exact_program_compiles_for_all_it_may_have() {
    let context = Checked::new(backends()[0]);
    for bits in 0..64 {
        let has = |bit: u32| bits >> bit & 1 == 1;
        let trims = TrimFeatures {
            grid_loops: has(0),
            finer_loops: has(1),
            long_lists: has(2),
            shape_grid: has(3),
            fill_rules: has(5),
            ..TrimFeatures::NONE
        };
        for (degree, samples, shading, patches, normals, output) in [
            (
                Degree::CUBIC,
                1,
                Shading::Phong,
                PatchKind::Polynomial,
                Normals::Vertex,
                Output::Picture,
            ),
            (
                Degree::QUARTIC,
                4,
                Shading::Normals,
                PatchKind::Degenerate,
                Normals::Pixel,
                Output::Picture,
            ),
            (
                Degree::CUBIC,
                4,
                Shading::Unlit,
                PatchKind::Rational,
                Normals::Vertex,
                Output::Picture,
            ),
            (Degree::QUARTIC, 1, Shading::Phong, PatchKind::Rational, Normals::Pixel, Output::Aovs),
            (Degree::CUBIC, 1, Shading::Unlit, PatchKind::Degenerate, Normals::Pixel, Output::Aovs),
        ] {
            let painting = match (has(4), has(1)) {
                (false, _) => Painting::Color,
                (true, false) => Painting::Picture,
                (true, true) => Painting::PictureOverDomain,
            };
            let degree = Some(degree).filter(|_| !has(5));
            let shared = has(4);
            let isolines = has(2);
            let light = if has(3) { Light::Studio } else { Light::Thesis };
            let pipeline =
                Pipeline::Exact { degree, samples, patches, shared, painting, normals, isolines };
            let key = ProgramKey {
                pipeline,
                shading,
                analysis: None,
                light,
                trims,
                output,
                far_depth: has(1),
                cut_out: has(2),
            };
            let program = Sources::default()
                .link(context.gl(), key)
                .unwrap_or_else(|error| panic!("{key:?}: {error}"));
            let unit = |name: &str| program.uniform_i32(name);
            let words = (has(0) || has(3)).then_some(TRIM_WORDS_UNIT as i32);
            assert_eq!(unit("trimWords"), words, "{key:?}");
            assert_eq!(unit("trimPoints"), words.map(|unit| unit + 1), "{key:?}");
            assert_eq!(unit("controlPoints"), Some(CONTROL_POINTS_UNIT as i32));
            assert_eq!(unit("surfaces"), shared.then_some(SURFACES_UNIT as i32));
            assert_eq!(unit("subPatches"), Some(SUB_PATCHES_UNIT as i32));
            let to_clip = (!shared).then_some(location::TO_CLIP);
            assert_eq!(program.uniform_location("toClip"), to_clip);
            let is_shown = output == Output::Picture;
            let picture = has(4) && is_shown && (shading != Shading::Normals || has(2));
            assert_eq!(unit("colortexture"), picture.then_some(0), "{key:?}");
            let is_lit = is_shown && shading == Shading::Phong;
            let eye = (is_lit && light == Light::Studio).then_some(location::EYE);
            assert_eq!(program.uniform_location("eye"), eye, "{key:?}");
            let lamp = (is_lit && light == Light::Thesis).then_some(location::LIGHT_POSITION);
            assert_eq!(program.uniform_location("lightPosition"), lamp, "{key:?}");
            let lines = isolines && is_shown;
            assert_eq!(
                program.uniform_location("isolines"),
                lines.then_some(location::ISOLINES),
                "{key:?}"
            );
            let domains = lines || picture && painting == Painting::PictureOverDomain;
            assert_eq!(unit("domains"), domains.then_some(DOMAINS_UNIT as i32), "{key:?}");
            let to_world = (output == Output::Aovs).then_some(location::VIEW_TO_WORLD);
            assert_eq!(program.uniform_location("viewToWorld"), to_world);
        }
    }
}

/// Every analysis compiles for all that surfaces, meshes and strokes may be.
#[test]
fn analyses_compile_for_all_they_may_have() {
    let context = Checked::new(backends()[0]);
    let exact = |degree, patches, samples, shared| Pipeline::Exact {
        degree,
        samples,
        patches,
        shared,
        painting: Painting::Color,
        normals: Normals::Vertex,
        isolines: shared,
    };
    let mut pipelines = vec![
        Pipeline::Triangles { phong: true, colored: false },
        Pipeline::Static(Method::Exact),
        Pipeline::Strokes { samples: 4, lines: false },
        exact(None, PatchKind::Degenerate, 4, true),
    ];
    for patches in [PatchKind::Polynomial, PatchKind::Rational, PatchKind::Degenerate] {
        let degree = Some(Degree::new(1, 3).unwrap());
        pipelines.extend([exact(degree, patches, 1, false), exact(degree, patches, 4, true)]);
    }
    for pipeline in pipelines {
        for kind in AnalysisKind::ALL {
            for (trimmed, output) in
                [(false, Output::Picture), (true, Output::Picture), (true, Output::Aovs)]
            {
                let is_exact = matches!(pipeline, Pipeline::Exact { .. });
                let is_curvature = kind == AnalysisKind::Curvature;
                // Only surfaces show curvature, and of AOVs it is the only analysis.
                if is_curvature != (output == Output::Aovs) && !(is_exact && is_curvature) {
                    continue;
                }
                let grid_loops = trimmed && is_exact;
                let key = ProgramKey {
                    pipeline,
                    shading: Shading::Unlit,
                    analysis: Some(kind),
                    light: Light::Studio,
                    trims: TrimFeatures { grid_loops, ..TrimFeatures::NONE },
                    output,
                    far_depth: trimmed,
                    cut_out: false,
                };
                let program = Sources::default()
                    .link(context.gl(), key)
                    .unwrap_or_else(|error| panic!("{key:?}: {error}"));
                let is_shown = output == Output::Picture;
                let analysis = program.uniform_location("analysis");
                assert_eq!(analysis, is_shown.then_some(location::ANALYSIS), "{key:?}");
                let local = program.uniform_location("localPoints");
                assert_eq!(local, is_exact.then_some(location::LOCAL_POINTS), "{key:?}");
            }
        }
    }
}

#[test]
fn a_broken_shader_is_reported_with_stage_file_and_line() {
    let context = Checked::new(backends()[0]);
    let key = ProgramKey {
        pipeline: Pipeline::Thesis(Degree::CUBIC),
        shading: Shading::Phong,
        analysis: None,
        light: Light::Thesis,
        trims: TrimFeatures::ALL,
        output: Output::Picture,
        far_depth: false,
        cut_out: false,
    };
    let sources =
        Sources::default().with_edit("thesis/trim.glsl", "int p = 0;", "int p = nothing;");
    let Err(Error::Shader { what, log }) = sources.link(context.gl(), key) else {
        panic!("the shader is broken")
    };
    assert!(what.contains("fragment stage") && what.contains("thesis/trim.glsl"), "{what}");
    let text = include_str!("../../glsl/thesis/trim.glsl");
    let line = 1 + text.lines().position(|line| line.contains("int p = 0;")).unwrap();
    assert!(log.contains(&format!("thesis/trim.glsl:{line}")), "{log}");
    assert!(log.contains("nothing"), "{log}");
    let _ = context.debug_log().take_errors();

    let unlinked = Sources::default().with_edit(
        "thesis/surface.frag",
        "layout(location = 0) in vec3 passNormal;",
        "layout(location = 9) in vec3 missing;\n#define passNormal missing",
    );
    let key = ProgramKey { trims: TrimFeatures::default(), ..key };
    let Err(Error::Shader { what, log }) = unlinked.link(context.gl(), key) else {
        panic!("the stages do not fit")
    };
    assert!(what.contains("linking") && what.contains("thesis surface"), "{what}");
    assert!(log.contains("missing"), "{log}");
    let _ = context.debug_log().take_errors();
}
