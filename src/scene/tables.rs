//! The tables of a `.toml` scene as they are in the text, before anything is checked.

use glam::{DVec3, DVec4};
use serde::Deserialize;
use serde::de::{Deserializer, SeqAccess, Visitor};
use toml::Spanned;

use super::Shading;
use crate::trim::FillRule;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Document {
    pub(super) camera: Option<Spanned<CameraTable>>,
    #[serde(default)]
    pub(super) camera_key: Vec<Spanned<CameraKeyTable>>,
    pub(super) render: Option<Spanned<RenderTable>>,
    #[serde(default)]
    pub(super) surface: Vec<Spanned<SurfaceTable>>,
    #[serde(default)]
    pub(super) mesh: Vec<Spanned<MeshTable>>,
    #[serde(default)]
    pub(super) model: Vec<Spanned<ModelTable>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraTable {
    pub(super) eye: DVec3Value,
    pub(super) target: DVec3Value,
    #[serde(default = "upright")]
    pub(super) up: DVec3Value,
    pub(super) fov_y_degrees: Option<f64>,
    pub(super) orthographic_height: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CameraKeyTable {
    pub(super) time: f64,
    pub(super) eye: DVec3Value,
    pub(super) target: DVec3Value,
    #[serde(default = "upright")]
    pub(super) up: DVec3Value,
}

pub(super) type DVec3Value = [f64; 3];

pub(super) const fn upright() -> DVec3Value {
    [0.0, 1.0, 0.0]
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RenderTable {
    pub(super) background: Option<Spanned<[f32; 4]>>,
    pub(super) method: Option<Spanned<String>>,
    pub(super) samples: Option<Spanned<i64>>,
    pub(super) level: Option<Spanned<i64>>,
    pub(super) tolerance: Option<Spanned<f64>>,
    pub(super) normals: Option<Spanned<String>>,
    pub(super) up: Option<Spanned<String>>,
    pub(super) light: Option<Spanned<String>>,
    pub(super) wireframe: bool,
    pub(super) red_lines: bool,
    pub(super) control_points: bool,
    pub(super) edges: Option<Spanned<EdgesValue>>,
    pub(super) isolines: Option<Spanned<IsolinesValue>>,
    pub(super) shading: Option<Spanned<AnalysisValue>>,
    pub(super) newton: Option<Spanned<NewtonTable>>,
}

/// Whether edges are drawn, or how.
#[derive(Deserialize)]
#[serde(untagged, expecting = "expected true, false or a table of width, color and smooth")]
pub(super) enum EdgesValue {
    Shown(bool),
    As(EdgesTable),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EdgesTable {
    pub(super) width: Option<f64>,
    pub(super) color: Option<EdgeColorValue>,
    #[serde(default)]
    pub(super) smooth: bool,
}

/// One colour of all edges, or what their colours tell.
#[derive(Deserialize)]
#[serde(untagged)]
pub(super) enum EdgeColorValue {
    Rgb([f32; 3]),
    Named(String),
}

/// The number of isolines, or how they are drawn.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected a whole number from 0 to 1000 or a table of count, width and color"
)]
pub(super) enum IsolinesValue {
    Count(i64),
    As(IsolinesTable),
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct IsolinesTable {
    pub(super) count: Option<i64>,
    pub(super) width: Option<f64>,
    pub(super) color: Option<[f32; 3]>,
}

/// The name of an analysis, or its name and its settings.
#[derive(Deserialize)]
#[serde(
    untagged,
    expecting = "expected the name of a shading, or a table of kind, stripes, direction, curvature, limit and \
                 limit_degrees"
)]
pub(super) enum AnalysisValue {
    Named(String),
    As(AnalysisTable),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AnalysisTable {
    pub(super) kind: String,
    pub(super) stripes: Option<i64>,
    pub(super) direction: Option<DVec3Value>,
    pub(super) curvature: Option<String>,
    pub(super) limit: Option<f64>,
    pub(super) limit_degrees: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NewtonTable {
    pub(super) iterations: Option<u32>,
    pub(super) epsilon: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SurfaceTable {
    pub(super) degree: Option<Spanned<[usize; 2]>>,
    pub(super) knots: Option<Spanned<[Vec<f64>; 2]>>,
    pub(super) control_points: Option<Spanned<ControlPoints>>,
    pub(super) file: Option<Spanned<String>>,
    pub(super) texture: Option<Spanned<String>>,
    pub(super) color: Option<Spanned<[f32; 3]>>,
    #[serde(default)]
    pub(super) shading: ShadingName,
    pub(super) translate: Option<DVec3Value>,
    pub(super) rotate_degrees: Option<DVec3Value>,
    pub(super) scale: Option<f64>,
    pub(super) matrix: Option<[[f64; 4]; 3]>,
    pub(super) keep: Option<Spanned<KeepName>>,
    #[serde(default)]
    pub(super) cull: CullName,
    #[serde(default)]
    pub(super) hidden: bool,
    #[serde(default = "yes")]
    pub(super) join: bool,
    #[serde(default)]
    pub(super) trim: Vec<Spanned<TrimTable>>,
}

const fn yes() -> bool {
    true
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MeshTable {
    pub(super) file: Spanned<String>,
    #[serde(default)]
    pub(super) smoothing: SmoothingName,
    pub(super) alpha: Option<Spanned<f64>>,
    pub(super) level: Option<Spanned<i64>>,
    pub(super) crease_degrees: Option<Spanned<f64>>,
    pub(super) texture: Option<Spanned<String>>,
    pub(super) color: Option<Spanned<[f32; 3]>>,
    #[serde(default)]
    pub(super) shading: ShadingName,
    pub(super) translate: Option<DVec3Value>,
    pub(super) rotate_degrees: Option<DVec3Value>,
    pub(super) scale: Option<f64>,
    pub(super) matrix: Option<[[f64; 4]; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ModelTable {
    pub(super) file: Spanned<String>,
    pub(super) color: Option<Spanned<[f32; 3]>>,
    #[serde(default)]
    pub(super) hide: Vec<Spanned<usize>>,
    #[serde(default)]
    pub(super) colors: Vec<FaceColorTable>,
    pub(super) translate: Option<DVec3Value>,
    pub(super) rotate_degrees: Option<DVec3Value>,
    pub(super) scale: Option<f64>,
    pub(super) matrix: Option<[[f64; 4]; 3]>,
}

/// The colour of one face of a CAD model.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FaceColorTable {
    pub(super) face: Spanned<usize>,
    pub(super) color: Spanned<[f32; 3]>,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
pub(super) enum SmoothingName {
    #[default]
    None,
    Pn,
    Phong,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
pub(super) enum KeepName {
    #[default]
    Outside,
    Inside,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
pub(super) enum CullName {
    #[default]
    None,
    Back,
}

#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
pub(super) enum ShadingName {
    #[default]
    Phong,
    Texture,
    Flat,
    Normals,
}

impl From<ShadingName> for Shading {
    fn from(name: ShadingName) -> Self {
        match name {
            ShadingName::Phong => Self::Phong,
            ShadingName::Texture | ShadingName::Flat => Self::Unlit,
            ShadingName::Normals => Self::Normals,
        }
    }
}

/// One kind of trim, and the fill rule of a path.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TrimTable {
    pub(super) circle: Option<CircleTable>,
    pub(super) interval: Option<IntervalTable>,
    pub(super) ellipse: Option<EllipseTable>,
    pub(super) r#loop: Option<Vec<Vec<CurvePoint>>>,
    pub(super) nurbs: Option<Vec<NurbsTable>>,
    pub(super) path: Option<String>,
    pub(super) svg: Option<String>,
    pub(super) fill_rule: Option<FillRuleName>,
}

/// A B-spline curve of a loop.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NurbsTable {
    pub(super) degree: usize,
    pub(super) knots: Vec<f64>,
    pub(super) points: Vec<CurvePoint>,
}

/// A point of a curve of a loop: [u, v] or [u, v, weight].
#[derive(Deserialize, Clone, Copy)]
#[serde(untagged, expecting = "expected a point [u, v] or [u, v, weight]")]
pub(super) enum CurvePoint {
    Plain([f64; 2]),
    Weighted([f64; 3]),
}

impl From<CurvePoint> for DVec3 {
    fn from(point: CurvePoint) -> Self {
        match point {
            CurvePoint::Plain([u, v]) => Self::new(u, v, 1.0),
            CurvePoint::Weighted(point) => Self::from(point),
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CircleTable {
    pub(super) center: [f64; 2],
    pub(super) radius: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct IntervalTable {
    pub(super) u: [f64; 2],
    pub(super) v: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EllipseTable {
    pub(super) center: [f64; 2],
    pub(super) radii: [f64; 2],
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
pub(super) enum FillRuleName {
    EvenOdd,
    NonZero,
}

impl From<FillRuleName> for FillRule {
    fn from(name: FillRuleName) -> Self {
        match name {
            FillRuleName::EvenOdd => Self::EvenOdd,
            FillRuleName::NonZero => Self::NonZero,
        }
    }
}

/// `"default"`, or points of three or four numbers.
pub(super) enum ControlPoints {
    Default,
    Points(Vec<DVec4>),
}

impl<'de> Deserialize<'de> for ControlPoints {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PointsVisitor;
        impl<'de> Visitor<'de> for PointsVisitor {
            type Value = ControlPoints;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("points [x, y, z] or [x, y, z, weight], or \"default\"")
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Self::Value, E> {
                match text {
                    "default" => Ok(ControlPoints::Default),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(text), &self)),
                }
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut points = Vec::new();
                while let Some(ControlPoint(point)) = seq.next_element()? {
                    points.push(point);
                }
                Ok(ControlPoints::Points(points))
            }
        }
        deserializer.deserialize_any(PointsVisitor)
    }
}

/// One point; the weight is 1 if it is not given.
struct ControlPoint(DVec4);

impl<'de> Deserialize<'de> for ControlPoint {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct PointVisitor;
        impl<'de> Visitor<'de> for PointVisitor {
            type Value = ControlPoint;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a point [x, y, z] or [x, y, z, weight]")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut point = DVec4::W;
                let mut count = 0;
                while let Some(value) = seq.next_element()? {
                    if count < 4 {
                        point[count] = value;
                    }
                    count += 1;
                }
                if matches!(count, 3 | 4) {
                    Ok(ControlPoint(point))
                } else {
                    Err(serde::de::Error::invalid_length(count, &self))
                }
            }
        }
        deserializer.deserialize_seq(PointVisitor)
    }
}
