//! The files of `glsl/` that make up each stage of a program, in order.

use super::Pipeline;
use crate::gpu::StageKind::{self, Fragment, Geometry, TessControl, TessEvaluation, Vertex};
use crate::scene::{AnalysisKind, Light, Method};

/// A file of a stage.
pub(super) struct Ingredient {
    pub(super) stage: StageKind,
    pub(super) file: &'static str,
    when: When,
}

/// When a file is part of its stage.
#[derive(Clone, Copy)]
enum When {
    Always,
    /// The output is a picture or captured triangles.
    Picture,
    /// The output is AOVs.
    Aovs,
    /// The output is not AOVs, and the thesis' lamps are lit.
    LitAsThesis,
    /// The output is not AOVs, and the studio's lamps are lit.
    LitInStudio,
    /// There are trims.
    Trimmed,
    /// The fragment stage evaluates patches: for normals per pixel, isolines or an analysis.
    Evaluated,
    /// The fragment stage looks for the true surface at a pixel.
    TrueSurface,
    /// The output is a picture of an analysis.
    Analysed,
    /// There are isolines.
    Isolines,
    /// The fragment stage calls the `normalAt` of `common/normal.frag`: the output is not AOVs, or normals are evaluated
    /// per pixel, and no analysis has its own.
    Normal,
}

/// Properties of a program that determine its files.
pub(super) struct Facts {
    pub(super) aovs: bool,
    /// `None`: unlit, or AOVs.
    pub(super) light: Option<Light>,
    pub(super) analysis: Option<AnalysisKind>,
    pub(super) trimmed: bool,
    pub(super) pixel_normals: bool,
    pub(super) is_evaluated: bool,
    pub(super) isolines: bool,
}

impl Ingredient {
    pub(super) fn is_part(&self, facts: &Facts) -> bool {
        match self.when {
            When::Always => true,
            When::Picture => !facts.aovs,
            When::Aovs => facts.aovs,
            When::LitAsThesis => facts.light == Some(Light::Thesis),
            When::LitInStudio => facts.light == Some(Light::Studio),
            When::Trimmed => facts.trimmed,
            When::Evaluated => facts.is_evaluated,
            When::TrueSurface => facts.analysis.is_some(),
            When::Analysed => facts.analysis.is_some() && !facts.aovs,
            When::Isolines => facts.isolines,
            When::Normal => facts.pixel_normals || !facts.aovs && facts.analysis.is_none(),
        }
    }
}

macro_rules! recipe {
    ($($stage:ident $file:literal $when:ident;)*) => {
        &[$(Ingredient { stage: $stage, file: $file, when: When::$when }),*]
    };
}

/// The name of a pipeline for messages, and its files.
pub(super) const fn recipe(pipeline: Pipeline) -> (&'static str, &'static [Ingredient]) {
    match pipeline {
        Pipeline::Thesis(_) => ("thesis surface", THESIS),
        Pipeline::Report => ("report surface", REPORT),
        Pipeline::Exact { .. } => ("exact surface", EXACT),
        Pipeline::Triangles { .. } => ("smooth triangles", TRIANGLES),
        Pipeline::Static(Method::Exact) => ("static triangles", STATIC_EXACT),
        Pipeline::Static(Method::Thesis) => ("static triangles, as the thesis", STATIC_THESIS),
        Pipeline::Strokes { .. } => ("strokes", STROKES),
        Pipeline::Points => ("control points", POINTS),
    }
}

const THESIS: &[Ingredient] = recipe! {
    Vertex "thesis/surface.vert" Always;
    TessControl "thesis/surface.tesc" Always;
    TessEvaluation "thesis/surface.tese" Always;
    Geometry "common/aov.geom" Aovs;
    Fragment "common/phong.glsl" LitAsThesis;
    Fragment "common/srgb.glsl" LitInStudio;
    Fragment "common/studio.glsl" LitInStudio;
    Fragment "thesis/trim.glsl" Trimmed;
    Fragment "common/aov.frag" Aovs;
    Fragment "thesis/surface.frag" Picture;
};

const REPORT: &[Ingredient] = recipe! {
    Vertex "thesis/surface.vert" Always;
    TessControl "report/surface.tesc" Always;
    TessEvaluation "report/surface.tese" Always;
    Fragment "thesis/trim.glsl" Trimmed;
    Fragment "report/surface.frag" Picture;
};

const EXACT: &[Ingredient] = recipe! {
    Vertex "exact/surface.vert" Always;
    TessControl "exact/points.glsl" Always;
    TessControl "exact/surface.tesc" Always;
    TessEvaluation "common/levels.glsl" Always;
    TessEvaluation "exact/points.glsl" Always;
    TessEvaluation "exact/patch.glsl" Always;
    TessEvaluation "common/srgb.glsl" LitInStudio;
    TessEvaluation "exact/surface.tese" Always;
    Geometry "common/aov.geom" Aovs;
    Fragment "exact/points.glsl" Evaluated;
    Fragment "exact/patch.glsl" Evaluated;
    Fragment "exact/pixel.glsl" Evaluated;
    Fragment "exact/true_surface.glsl" TrueSurface;
    Fragment "common/normal.frag" Normal;
    Fragment "exact/isolines.glsl" Isolines;
    Fragment "common/phong.glsl" LitAsThesis;
    Fragment "common/srgb.glsl" LitInStudio;
    Fragment "common/studio.glsl" LitInStudio;
    Fragment "common/analysis.glsl" Analysed;
    Fragment "common/trim.glsl" Trimmed;
    Fragment "common/aov.frag" Aovs;
    Fragment "exact/surface.frag" Picture;
};

const TRIANGLES: &[Ingredient] = recipe! {
    Vertex "triangles/triangle.vert" Always;
    TessControl "triangles/triangle.tesc" Always;
    TessEvaluation "common/levels.glsl" Always;
    TessEvaluation "triangles/triangle.tese" Always;
    Geometry "common/aov.geom" Aovs;
    Fragment "common/normal.frag" Picture;
    Fragment "common/phong.glsl" LitAsThesis;
    Fragment "common/srgb.glsl" LitInStudio;
    Fragment "common/studio.glsl" LitInStudio;
    Fragment "common/analysis.glsl" Analysed;
    Fragment "common/aov.frag" Aovs;
    Fragment "exact/surface.frag" Picture;
};

const STATIC_EXACT: &[Ingredient] = recipe! {
    Vertex "common/static.vert" Always;
    Geometry "common/aov.geom" Aovs;
    Fragment "common/normal.frag" Picture;
    Fragment "common/phong.glsl" LitAsThesis;
    Fragment "common/srgb.glsl" LitInStudio;
    Fragment "common/studio.glsl" LitInStudio;
    Fragment "common/analysis.glsl" Analysed;
    Fragment "thesis/trim.glsl" Trimmed;
    Fragment "common/aov.frag" Aovs;
    Fragment "exact/surface.frag" Picture;
};

const STATIC_THESIS: &[Ingredient] = recipe! {
    Vertex "common/static.vert" Always;
    Geometry "common/aov.geom" Aovs;
    Fragment "common/phong.glsl" LitAsThesis;
    Fragment "common/srgb.glsl" LitInStudio;
    Fragment "common/studio.glsl" LitInStudio;
    Fragment "thesis/trim.glsl" Trimmed;
    Fragment "common/aov.frag" Aovs;
    Fragment "thesis/surface.frag" Picture;
};

const STROKES: &[Ingredient] = recipe! {
    Vertex "exact/stroke.vert" Always;
    Fragment "common/phong.glsl" LitAsThesis;
    Fragment "common/srgb.glsl" LitInStudio;
    Fragment "common/studio.glsl" LitInStudio;
    Fragment "common/analysis.glsl" Analysed;
    Fragment "exact/stroke.frag" Always;
};

const POINTS: &[Ingredient] = recipe! {
    Vertex "report/points.vert" Always;
    Fragment "report/surface.frag" Picture;
};
