//! Shader programs: which one a surface needs, how it is assembled, and its interface to the draw
//! calls.
//!
//! A program is assembled from files of `glsl/`, according to the properties of a surface. For
//! example, a surface without trims gets no trim code. `glsl/README.md` lists the names, locations
//! and bindings.

mod recipes;

use std::borrow::Cow;
use std::collections::HashMap;

use crate::bezier::Degree;
use crate::error::Result;
use crate::gpu::{Gl, Program, ShaderPart, Stage};
use crate::scene::{AnalysisKind, Light, Method, Normals, Shading};
pub use crate::tessellation::PatchKind;
use recipes::{Facts, recipe};

/// The maximum number of control points that are passed on to the evaluation stage: `GL_MAX_TESS_PATCH_COMPONENTS` may
/// be 120. Vertices of larger patches fetch theirs.
const MAX_HELD: usize = 25;

/// Locations of the uniforms, by their names in GLSL; the same as in `layout(location = …)` in
/// `glsl/`.
pub mod location {
    /// `tessLevel`.
    pub const TESS_LEVEL: u32 = 0;
    /// `modelMatrix`, `model`.
    pub const MODEL: u32 = 1;
    /// `viewMatrix`, `view`.
    pub const VIEW: u32 = 2;
    /// `projectionMatrix`, `projection`.
    pub const PROJECTION: u32 = 3;
    /// `part`.
    pub const PART: u32 = 4;
    /// `trimValuesx`.
    pub const TRIM_VALUES_X: u32 = 5;
    /// `trimValuesy`.
    pub const TRIM_VALUES_Y: u32 = 6;
    /// `trimRadius`.
    pub const TRIM_RADIUS: u32 = 7;
    /// `trimCenter`.
    pub const TRIM_CENTER: u32 = 8;
    /// `trimRadius1`.
    pub const TRIM_RADIUS_1: u32 = 9;
    /// `trimRadius2`.
    pub const TRIM_RADIUS_2: u32 = 10;
    /// `trimEllipseCenter`.
    pub const TRIM_ELLIPSE_CENTER: u32 = 11;
    /// `circBool`.
    pub const CIRC_BOOL: u32 = 12;
    /// `intervalBool`.
    pub const INTERVAL_BOOL: u32 = 13;
    /// `ellipseBool`.
    pub const ELLIPSE_BOOL: u32 = 14;
    /// `bezierBool`.
    pub const BEZIER_BOOL: u32 = 15;
    /// `bezierBool2`.
    pub const BEZIER_BOOL_2: u32 = 16;
    /// `cubicBezierBool`.
    pub const CUBIC_BEZIER_BOOL: u32 = 17;
    /// `cubicBezierBool2`.
    pub const CUBIC_BEZIER_BOOL_2: u32 = 18;
    /// `newtonIterations`.
    pub const NEWTON_ITERATIONS: u32 = 19;
    /// `newtonEpsilon`.
    pub const NEWTON_EPSILON: u32 = 20;
    /// `wireframe`.
    pub const WIREFRAME: u32 = 21;
    /// `showControlPoints`.
    pub const SHOW_CONTROL_POINTS: u32 = 22;
    /// `pointSize`.
    pub const POINT_SIZE: u32 = 23;
    /// `viewToWorld`.
    pub const VIEW_TO_WORLD: u32 = 24;
    /// `firstPatch`.
    pub const FIRST_PATCH: u32 = 25;
    /// `viewport`.
    pub const VIEWPORT: u32 = 26;
    /// `toClip`.
    pub const TO_CLIP: u32 = 27;
    /// `toView`.
    pub const TO_VIEW: u32 = 28;
    /// `normalToView`.
    pub const NORMAL_TO_VIEW: u32 = 29;
    /// `alpha`.
    pub const ALPHA: u32 = 30;
    /// `firstPoint`.
    pub const FIRST_POINT: u32 = 31;
    /// `lightPosition`.
    pub const LIGHT_POSITION: u32 = 33;
    /// `lightPosition2`.
    pub const LIGHT_POSITION_2: u32 = 34;
    /// `depthScale`.
    pub const DEPTH_SCALE: u32 = 32;
    /// `groupSize`.
    pub const GROUP_SIZE: u32 = 35;
    /// `passPaint`.
    pub const PAINT: u32 = 36;
    /// `segments`.
    pub const SEGMENTS: u32 = 37;
    /// `firstSegment`.
    pub const FIRST_SEGMENT: u32 = 41;
    /// `rayStart`.
    pub const RAY_START: u32 = 38;
    /// `rayDirection`.
    pub const RAY_DIRECTION: u32 = 39;
    /// `depthTerms`.
    pub const DEPTH_TERMS: u32 = 40;
    /// `isolines`.
    pub const ISOLINES: u32 = 42;
    /// `isolineColor`.
    pub const ISOLINE_COLOR: u32 = 43;
    /// `eye`.
    pub const EYE: u32 = 44;
    /// `analysis`.
    pub const ANALYSIS: u32 = 45;
    /// `localPoints`.
    pub const LOCAL_POINTS: u32 = 46;
    /// `curvatureKind`.
    pub const CURVATURE_KIND: u32 = 47;
}

/// Binding point of the storage buffer `trimPointsSsbo`, as in listing 13.
pub const TRIM_POINTS_BINDING: u32 = 1;
/// Binding point of the storage buffer `trimShapesSsbo`.
pub const TRIM_SHAPES_BINDING: u32 = 2;
/// Texture unit of `trimWords`; the next unit is that of `trimPoints`.
pub const TRIM_WORDS_UNIT: u32 = 1;
/// Texture unit of `controlPoints`.
pub const CONTROL_POINTS_UNIT: u32 = 3;
/// Texture unit of `surfaces`.
pub const SURFACES_UNIT: u32 = 4;
/// Texture unit of `subPatches`.
pub const SUB_PATCHES_UNIT: u32 = 8;
/// Texture unit of `strokes`; programs with strokes have no sub-patches.
pub const STROKES_UNIT: u32 = SUB_PATCHES_UNIT;
/// Texture unit of `domains`.
pub const DOMAINS_UNIT: u32 = 7;
/// Texture unit of `levels`. The buffer's second view, which no shader reads, takes the next unit.
pub const LEVELS_UNIT: u32 = 5;

/// The kind of a program, which determines its shader stages.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Pipeline {
    /// The thesis' method: the double de Casteljau algorithm.
    Thesis(Degree),
    /// The report's method: 5×5 control points, Bernstein polynomials, texture without lighting.
    Report,
    /// The exact method: true normals; trims are looked up in a grid, for each sample of a pixel.
    Exact {
        /// The degree of the patches; `None`: any, which each sub-patch states.
        degree: Option<Degree>,
        /// Samples per pixel of the target.
        samples: u32,
        /// How the patches are evaluated.
        patches: PatchKind,
        /// Whether one draw may contain patches of several surfaces, each with its own matrices and colour.
        shared: bool,
        /// Where the colour before lighting comes from.
        painting: Painting,
        /// Whether normals are evaluated per vertex or per pixel.
        normals: Normals,
        /// Whether there are lines of equal u and of equal v; in pictures only.
        isolines: bool,
    },
    /// Smooth triangles of meshes.
    Triangles {
        /// Phong tessellation if true, curved PN triangles if false.
        phong: bool,
        /// Whether the vertices have colours.
        colored: bool,
    },
    /// Triangles tessellated in advance, with the fragment stage of a method.
    Static(Method),
    /// Strokes along the edges of faces.
    Strokes {
        /// Samples per pixel of the target.
        samples: u32,
        /// Whether they are lines on top of the faces.
        lines: bool,
    },
    /// Control points, drawn as squares.
    Points,
}

/// Where the exact method's colour before lighting comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Painting {
    /// Each surface has one colour.
    Color,
    /// A picture over each patch.
    Picture,
    /// A picture over the domain of a NURBS surface.
    PictureOverDomain,
}

impl Pipeline {
    /// The pipeline of a ported method: the report's for unlit 5×5 patches, which are all that it
    /// can draw, and the thesis' for all others.
    #[must_use]
    pub const fn ported(degree: Degree, shading: Shading) -> Self {
        match (degree, shading) {
            (Degree::QUARTIC, Shading::Unlit) => Self::Report,
            (degree, _) => Self::Thesis(degree),
        }
    }
}

/// The kinds of trims that are compiled in. The thesis' and the report's programs use the fields up
/// to `nested_cubics`, the exact method the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct TrimFeatures {
    /// Circles (`circBool`).
    pub circles: bool,
    /// Rectangles (`intervalBool`).
    pub intervals: bool,
    /// Ellipses (`ellipseBool`).
    pub ellipses: bool,
    /// More than one trim of any of the three kinds above.
    pub more_shapes: bool,
    /// Quadratic loops (`bezierBool`).
    pub quadratics: bool,
    /// Quadratic loops with an island (`bezierBool2`).
    pub nested_quadratics: bool,
    /// Cubic loops (`cubicBezierBool`).
    pub cubics: bool,
    /// Cubic loops with an island (`cubicBezierBool2`).
    pub nested_cubics: bool,
    /// Loops, in a grid.
    pub grid_loops: bool,
    /// Some cells of this grid are subdivided.
    pub finer_loops: bool,
    /// Some cells of this grid list more than 32 pieces.
    pub long_lists: bool,
    /// Some loops are paths with their own fill rules.
    pub fill_rules: bool,
    /// Circles, rectangles and ellipses, in a second grid.
    pub shape_grid: bool,
}

impl TrimFeatures {
    /// No trims.
    pub const NONE: Self = Self {
        circles: false,
        intervals: false,
        ellipses: false,
        more_shapes: false,
        quadratics: false,
        nested_quadratics: false,
        cubics: false,
        nested_cubics: false,
        grid_loops: false,
        finer_loops: false,
        long_lists: false,
        fill_rules: false,
        shape_grid: false,
    };

    /// All trims of the thesis' method.
    pub const ALL: Self = Self {
        circles: true,
        intervals: true,
        ellipses: true,
        more_shapes: true,
        quadratics: true,
        nested_quadratics: true,
        cubics: true,
        nested_cubics: true,
        ..Self::NONE
    };

    /// Whether there are loops of the thesis' method.
    const fn loops(&self) -> bool {
        self.quadratics || self.nested_quadratics || self.cubics || self.nested_cubics
    }

    /// Whether there are any trims.
    #[must_use]
    pub const fn any(&self) -> bool {
        self.circles
            || self.intervals
            || self.ellipses
            || self.loops()
            || self.grid_loops
            || self.shape_grid
    }

    const fn defines(&self) -> [(&'static str, bool); 14] {
        [
            ("TRIMMED", self.any()),
            ("CIRCLES", self.circles),
            ("INTERVALS", self.intervals),
            ("ELLIPSES", self.ellipses),
            ("MORE_SHAPES", self.more_shapes),
            ("QUADRATICS", self.quadratics),
            ("NESTED_QUADRATICS", self.nested_quadratics),
            ("CUBICS", self.cubics),
            ("NESTED_CUBICS", self.nested_cubics),
            ("LOOPS", self.grid_loops),
            ("FINER_LOOPS", self.finer_loops),
            ("LONG_LISTS", self.long_lists),
            ("FILL_RULES", self.fill_rules),
            ("SHAPES", self.shape_grid),
        ]
    }
}

/// Everything that distinguishes one program from another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct ProgramKey {
    /// The kind of program.
    pub pipeline: Pipeline,
    /// The shading model.
    pub shading: Shading,
    /// What is shown in place of the shading. With AOVs, the curvature adds an image; others are not used.
    pub analysis: Option<AnalysisKind>,
    /// The light, with [`Shading::Phong`].
    pub light: Light,
    /// The kinds of trims.
    pub trims: TrimFeatures,
    /// What drawing produces.
    pub output: Output,
    /// Whether fragments are discarded where the texture's alpha is below 0.5.
    pub cut_out: bool,
    /// Whether the fragment stage writes the distance along the view axis, divided by the far
    /// plane's distance, as depth ([`location::DEPTH_SCALE`]).
    pub far_depth: bool,
}

/// What drawing produces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Output {
    /// A colour per pixel.
    #[default]
    Picture,
    /// Values per pixel ([`crate::aov::Aovs`]).
    Aovs,
    /// The vertices of the triangles, captured by transform feedback (`DrawnVertex`); no pixels.
    Triangles,
}

/// The shader outputs that transform feedback captures, in the order of the fields of
/// `DrawnVertex`.
const KEPT: [&str; 5] = ["gl_Position", "position", "passNormal", "passTessCoord", "passPatch"];

macro_rules! glsl {
    ($($file:literal),* $(,)?) => {
        [$(($file, include_str!(concat!("../glsl/", $file)))),*]
    };
}

/// Every shader file of `glsl/`: its path there and its text.
const FILES: [(&str, &str); 33] = glsl![
    "common/analysis.glsl",
    "common/aov.geom",
    "common/aov.frag",
    "common/levels.glsl",
    "common/normal.frag",
    "common/phong.glsl",
    "common/srgb.glsl",
    "common/static.vert",
    "common/studio.glsl",
    "common/trim.glsl",
    "exact/patch.glsl",
    "exact/points.glsl",
    "exact/surface.vert",
    "exact/surface.tesc",
    "exact/surface.tese",
    "exact/surface.frag",
    "exact/pixel.glsl",
    "exact/true_surface.glsl",
    "exact/isolines.glsl",
    "exact/stroke.vert",
    "exact/stroke.frag",
    "thesis/surface.vert",
    "thesis/surface.tesc",
    "thesis/surface.tese",
    "thesis/trim.glsl",
    "thesis/surface.frag",
    "report/surface.tesc",
    "report/surface.tese",
    "report/surface.frag",
    "report/points.vert",
    "triangles/triangle.vert",
    "triangles/triangle.tesc",
    "triangles/triangle.tese",
];

/// The source texts of the shaders: the library's own, some of which may be replaced.
#[derive(Debug, Clone, Default)]
pub struct Sources {
    replaced: HashMap<&'static str, String>,
}

impl Sources {
    /// Replaces all occurrences of `old` by `new` in a file: for experiments, and for tests that
    /// must notice a wrong shader.
    ///
    /// # Panics
    /// If `glsl/` has no such file, or the file does not contain `old`.
    #[must_use]
    pub fn with_edit(mut self, file: &str, old: &str, new: &str) -> Self {
        let (name, own) = FILES
            .iter()
            .find(|(name, _)| *name == file)
            .unwrap_or_else(|| panic!("glsl/ has no {file}"));
        let text = self.replaced.entry(name).or_insert_with(|| (*own).to_owned());
        assert!(text.contains(old), "glsl/{file} does not contain {old:?}");
        *text = text.replace(old, new);
        self
    }

    fn part(&self, file: &'static str) -> ShaderPart {
        let own = || {
            let (_, text) = FILES
                .iter()
                .find(|(name, _)| *name == file)
                .expect("stages name files of the table");
            Cow::Borrowed(*text)
        };
        ShaderPart {
            file,
            text: self.replaced.get(file).map_or_else(own, |text| Cow::Owned(text.clone())),
        }
    }

    /// Compiles and links the program of a key.
    ///
    /// # Errors
    /// The driver rejects a shader or the program. Errors of the compiler name file and line.
    pub fn link(&self, gl: &Gl, key: ProgramKey) -> Result<Program> {
        let samples = match key.pipeline {
            Pipeline::Exact { samples, .. } | Pipeline::Strokes { samples, .. }
                if key.output != Output::Aovs =>
            {
                samples
            }
            _ => 1,
        };
        let mut defines = vec![("SAMPLES", samples)];
        let mut facts = Facts {
            aovs: key.output == Output::Aovs,
            light: (key.shading == Shading::Phong
                && key.output != Output::Aovs
                && key.analysis.is_none())
            .then_some(key.light),
            analysis: key.analysis,
            trimmed: key.trims.any(),
            pixel_normals: false,
            is_evaluated: false,
            isolines: false,
        };
        let mut on: Vec<(&'static str, bool)> = Vec::new();
        if let Pipeline::Thesis(degree) = key.pipeline {
            defines.push(("SIDE", degree.columns() as u32));
        }
        let is_curvature = key.analysis == Some(AnalysisKind::Curvature);
        let mut painting = Painting::Picture;
        if let Pipeline::Exact {
            degree, patches, shared, painting: own, normals, isolines, ..
        } = key.pipeline
        {
            painting = own;
            if let Some(degree) = degree {
                let (columns, rows) = (degree.columns() as u32, degree.rows() as u32);
                defines.extend([("COLUMNS", columns), ("ROWS", rows)]);
            }
            let are_seen = facts.aovs || key.shading != Shading::Unlit && key.analysis.is_none();
            facts.pixel_normals = normals == Normals::Pixel && are_seen;
            facts.isolines = isolines && key.output == Output::Picture;
            facts.is_evaluated = facts.pixel_normals || facts.isolines || facts.analysis.is_some();
            on.extend([
                ("SHARED", shared),
                ("ANY_DEGREE", degree.is_none()),
                ("HELD", degree.is_some_and(|degree| degree.points() <= MAX_HELD)),
                ("RATIONAL", patches != PatchKind::Polynomial),
                ("DEGENERATE", patches == PatchKind::Degenerate),
                ("PIXEL_NORMALS", facts.pixel_normals),
                ("EVALUATED", facts.is_evaluated),
                ("ISOLINES", facts.isolines),
            ]);
        }
        if let Pipeline::Strokes { lines, .. } = key.pipeline {
            on.push(("LINES", lines));
        }
        if let Pipeline::Triangles { phong, colored } = key.pipeline {
            on.extend([("PHONG_TESSELLATION", phong), ("COLORED", colored)]);
        }
        on.extend([
            ("TEXTURED", painting != Painting::Color),
            ("OVER_DOMAIN", painting == Painting::PictureOverDomain),
            ("AOV", key.output != Output::Picture),
            ("GEOMETRY", key.output == Output::Aovs),
            ("CUT_OUT", key.cut_out && painting != Painting::Color),
            ("FAR_DEPTH", key.far_depth),
            ("PHONG", facts.light == Some(Light::Thesis)),
            ("STUDIO", facts.light == Some(Light::Studio)),
            ("NORMALS", key.shading == Shading::Normals),
            ("ANALYSIS", key.analysis.is_some() && !facts.aovs),
            ("ZEBRA", key.analysis == Some(AnalysisKind::Zebra)),
            ("ISOPHOTES", key.analysis == Some(AnalysisKind::Isophotes)),
            ("CURVATURE", is_curvature && matches!(key.pipeline, Pipeline::Exact { .. })),
            ("CURVATURE_AOV", is_curvature && facts.aovs),
            ("DRAFT", key.analysis == Some(AnalysisKind::Draft)),
        ]);
        on.extend(key.trims.defines());
        defines.extend(on.into_iter().filter(|(_, on)| *on).map(|(name, _)| (name, 1)));

        let (label, ingredients) = recipe(key.pipeline);
        let mut stages: Vec<Stage> = Vec::new();
        for ingredient in ingredients.iter().filter(|ingredient| ingredient.is_part(&facts)) {
            if stages.last().is_none_or(|stage| stage.kind != ingredient.stage) {
                stages.push(Stage { kind: ingredient.stage, parts: Vec::new() });
            }
            if let Some(stage) = stages.last_mut() {
                stage.parts.push(self.part(ingredient.file));
            }
        }
        let kept: &[&str] = if key.output == Output::Triangles { &KEPT } else { &[] };
        Program::new(gl, label, &defines, &stages, kept)
    }
}
