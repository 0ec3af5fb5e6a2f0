//! Sets uniforms that programs of several pipelines have.

use glam::{DMat4, DVec3, Mat4, Vec4};

use super::Frame;
use crate::camera::ViewProjection;
use crate::gpu::Program;
use crate::programs::{Output, location};
use crate::scene::{Analysis, AnalysisKind, CurvatureKind, Draft, Light, RenderSettings, Stripes};

/// The height of the thesis' lamps above and below the world's origin.
const LAMP_HEIGHT: f64 = 10.0;

/// Sets what lighting needs: the positions of the thesis' lamps in view space, or the eye for the studio's.
pub(crate) fn set_lights(program: &Program, frame: &Frame) {
    match frame.settings.light {
        Light::Thesis => {
            let lamp = |height| frame.camera.view.transform_point3(DVec3::Y * height).as_vec3();
            program.set_vec3(location::LIGHT_POSITION, lamp(LAMP_HEIGHT));
            program.set_vec3(location::LIGHT_POSITION_2, lamp(-LAMP_HEIGHT));
        }
        Light::Studio => program.set_vec4(location::EYE, frame.camera.eye_in_view().as_vec4()),
    }
}

/// The analysis that an output shows. Of AOVs it is the curvature, by any method: what has none writes zeros.
pub(crate) fn analysis_of(settings: &RenderSettings, output: Output) -> Option<Analysis> {
    match output {
        Output::Picture => settings.shown_analysis(),
        Output::Aovs => settings.analysis.filter(|own| own.kind() == AnalysisKind::Curvature),
        Output::Triangles => None,
    }
}

/// Sets what an analysis needs. `limit` is the curvature at the end of the scale, if there is one.
pub(super) fn set_analysis(program: &Program, frame: &Frame, analysis: &Analysis, limit: f64) {
    let view = &frame.camera.view;
    let (direction, number) = match *analysis {
        Analysis::Zebra(Stripes { count, direction })
        | Analysis::Isophotes(Stripes { count, direction }) => {
            let upright = direction.map_or(DVec3::Y, |own| view.transform_vector3(own.get()));
            (upright, f64::from(count.get()))
        }
        Analysis::Curvature { of, .. } => {
            let number = match of {
                CurvatureKind::Gaussian => 0,
                CurvatureKind::Mean => 1,
                CurvatureKind::Largest => 2,
            };
            program.set_i32(location::CURVATURE_KIND, number);
            (DVec3::ZERO, 1.0 / limit)
        }
        Analysis::Draft(Draft { pull, limit }) => {
            (view.transform_vector3(pull.get()), 1.0 / limit.degrees().to_radians())
        }
    };
    program.set_vec4(location::EYE, frame.camera.eye_in_view().as_vec4());
    program.set_vec4(location::ANALYSIS, direction.extend(number).as_vec4());
}

/// Sets the factor from the distance along the view axis to depth, if the fragment stage writes
/// such a depth ([`ViewProjection::depth_scale`]).
pub(crate) fn set_depth(program: &Program, frame: &Frame) {
    if let Some(scale) = frame.camera.depth_scale() {
        program.set_f32(location::DEPTH_SCALE, scale as f32);
    }
}

/// Sets what AOVs need: the matrix from view space to world space, and the viewport.
pub(crate) fn set_aovs(program: &Program, frame: &Frame) {
    let to_world = frame.camera.view.inverse().as_mat4();
    program.set_mat4(location::VIEW_TO_WORLD, &to_world);
    program.set_vec4(location::VIEWPORT, frame.viewport.origin_and_half());
}

/// Sets the matrices of one surface or mesh from their columns ([`super::draw_list::matrices`]). If
/// `sign` is −1, normals are reversed.
pub(super) fn set_columns(program: &Program, columns: &[Vec4], sign: f32) {
    let matrix = |first: usize| {
        let [x, y, z, w] = [0, 1, 2, 3].map(|i| columns[first + i]);
        Mat4::from_cols(x, y, z, w)
    };
    program.set_mat4(location::TO_CLIP, &matrix(0));
    program.set_mat4(location::TO_VIEW, &matrix(4));
    program.set_mat4(location::NORMAL_TO_VIEW, &(matrix(8) * sign));
}

/// Sets the matrices of the ported shaders. The origin of their world space is moved to the eye,
/// because `f32` coordinates of a scene far from the origin would be imprecise.
pub(crate) fn set_matrices(program: &Program, model: &DMat4, camera: &ViewProjection) {
    let eye = camera.view.inverse().w_axis.truncate();
    let to_eye = DMat4::from_translation(-eye);
    program.set_mat4(location::MODEL, &(to_eye * *model).as_mat4());
    program.set_mat4(location::VIEW, &(camera.view * DMat4::from_translation(eye)).as_mat4());
    program.set_mat4(location::PROJECTION, &camera.for_driver().as_mat4());
}
