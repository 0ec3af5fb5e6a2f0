//! Segments of strokes in the form that the shaders read.

use std::cmp::Ordering;

use bytemuck::{Pod, Zeroable};
use glam::{DMat2, DVec2, Vec2, Vec3};

use super::look::Shape;
use super::part::{Bow, End};
use super::{PlacedJoint, StrokeLine, StrokeView};

/// How much farther than a face its part of a stroke is drawn, as a share of half of the width: the face itself is to
/// be in front.
const BEHIND: f32 = 0.25;
/// The same where both faces come nearer on the sides of the edge: it may be the far side of a solid, and the strokes of
/// edges on the near side are to be in front.
const FAR_BEHIND: f32 = 1.0;
/// Codes of a segment whose start is cut, and whose end is.
const CUT_ENDS: [u32; 2] = [1, 2];
/// It is known which side of the faces is the outside of a solid.
const KNOWS_OUTSIDE: u32 = 4;
/// The normal of the face to the left points into that solid, and that of the face to the right does.
const INWARDS: [u32; 2] = [8, 16];
/// The sine of the least angle to the line of sight at which a face clearly lies on one side of its edge.
const CLEARLY: f64 = 0.1;

/// A segment of a stroke, as `exact/stroke.vert` fetches it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct StrokeSegment {
    /// Start and end in pixels from the middle of the viewport.
    ends: [Vec2; 2],
    /// Distances of the start and the end along the view axis.
    depths: Vec2,
    /// Half of the width in pixels; negative if only the left side is drawn.
    half_width: f32,
    /// How much farther than the faces' planes it is drawn, as a share of half of the width; lines are drawn nearer.
    behind: f32,
    /// How far its middle is off the middle of its ends, in pixels, and the same of the distances.
    sag: Vec2,
    depth_sag: f32,
    /// The sum of [`CUT_ENDS`] for each end that is not round, [`KNOWS_OUTSIDE`] and [`INWARDS`]; exact in `f32`.
    codes: f32,
    /// For the face that is drawn to the left, seen from the start: the normal ∂u × ∂v in view space at the start, its
    /// colour, the normal at the end and the number of a patch. The same for the face to the right.
    faces: [StrokeFace; 2],
    /// (u, v) of the left face at the start and the end, as shares of the domain, then of the right face.
    shares: [[Vec2; 2]; 2],
    /// How far (u, v) of both in the middle are off the middle of these.
    share_sags: [Vec2; 2],
}

/// A face beside a segment.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
struct StrokeFace {
    start: Vec3,
    /// Red, green and blue from 0 to 255, each times a power of 256: exact in `f32`.
    color: f32,
    end: Vec3,
    patch: f32,
}

impl StrokeSegment {
    fn is_finite(&self) -> bool {
        self.ends.iter().all(|end| end.is_finite()) && self.sag.is_finite()
    }
}

/// Texels of a segment.
pub(crate) const SEGMENT_TEXELS: usize = size_of::<StrokeSegment>() / 16;

impl StrokeView {
    /// For each face at a parameter of a parabola, how far a step into it goes to the left on the screen, and how much
    /// further away.
    pub(super) fn steps(
        &self,
        joint: &PlacedJoint<'_>,
        bow: &Bow,
        shape: &Shape,
        at: f64,
    ) -> [Step; 2] {
        let [start, control, end] = bow.parabola.points;
        let point = bow.parabola.at(at);
        let direction = (control - start).lerp(end - control, at);
        let along = shape.ends[1] - shape.ends[0] + 4.0 * (1.0 - 2.0 * at) * shape.sag;
        let left = along.perp().normalize_or_zero();
        [0, 1].map(|face| {
            let normal = bow.ends[0].normals[face].lerp(bow.ends[1].normals[face], at);
            let into = joint.sides[face].side * normal.cross(direction).normalize_or_zero();
            let moved = if self.is_parallel {
                into.truncate()
            } else {
                into.truncate() - point.truncate() * (into.z / point.z)
            };
            let on_screen = DMat2::from_cols(
                self.projection.x_axis.truncate().truncate(),
                self.projection.y_axis.truncate().truncate(),
            ) * moved
                * self.half;
            Step { to_left: on_screen.dot(left), farther: -into.z }
        })
    }

    /// How two faces lie beside an edge on the screen.
    pub(super) fn layout(&self, [a, b]: [Step; 2]) -> Layout {
        let is_left = [a.to_left >= 0.0, b.to_left >= 0.0];
        let is_fold = is_left[0] == is_left[1];
        Layout {
            is_left,
            is_clear: a.to_left.abs().min(b.to_left.abs()) > CLEARLY * self.magnification,
            is_deep: a.farther < 0.0 && b.farther < 0.0,
            nearer: is_fold.then(|| usize::from(b.compare(&a).is_lt())),
        }
    }

    /// How both faces lie along a parabola, if that is the same all along it.
    pub(super) fn layout_along(
        &self,
        joint: &PlacedJoint<'_>,
        bow: &Bow,
        shape: &Shape,
    ) -> Option<Layout> {
        let [start, middle, end] =
            [0.0, 0.5, 1.0].map(|at| self.layout(self.steps(joint, bow, shape, at)));
        start.with(middle)?.with(end)
    }

    /// The segment of a part: of a shape, or of the line between its ends, if any of that is beyond the near plane.
    pub(super) fn segment(
        &self,
        joint: &PlacedJoint<'_>,
        bow: &Bow,
        half_width: f64,
        shape: Option<(Shape, Layout)>,
    ) -> Option<StrokeSegment> {
        let (bow, shape, layout) = match shape {
            Some((shape, layout)) => (*bow, shape, layout),
            None => {
                let line = bow.line_beyond(self.near)?;
                let ends = line.tips().map(|tip| self.place(tip));
                let shape = Shape { ends, sag: DVec2::ZERO, off: 0.0, drift: 0.0 };
                (line, shape, self.layout(self.steps(joint, &line, &shape, 0.5)))
            }
        };
        if let Some(line) = &joint.line {
            return self.line(line, &bow, &shape, self.steps(joint, &bow, &shape, 0.5));
        }
        let Layout { is_left, is_clear, is_deep, nearer } = layout;
        let mut ends = [0, 1].map(|end| (shape.ends[end], -bow.tips()[end].z, bow.ends[end]));
        let mut codes = 0;
        let ([to_left, to_right], behind) = if let Some(nearer) = nearer {
            // The nearer face hides the other one. Its border may have receded before that of the other one, so the
            // stroke lies in front. On the other side of the edge there is nothing to draw.
            if is_clear && !is_left[0] {
                ends.reverse();
            }
            ([nearer; 2], -BEHIND)
        } else {
            // If both faces come nearer, the edge lies in a valley or on the far side of a solid.
            let behind = if is_deep {
                // The strokes of other edges cover the end: that of an edge on the far side would be seen there.
                let cut = CUT_ENDS.iter().zip(bow.is_end).filter(|(_, is_end)| *is_end);
                codes += cut.map(|(code, _)| code).sum::<u32>();
                FAR_BEHIND
            } else if is_clear {
                BEHIND
            } else {
                -BEHIND
            };
            (if is_left[0] { [0, 1] } else { [1, 0] }, behind)
        };
        let half_width = if nearer.is_some() && is_clear { -half_width } else { half_width };
        if let Some((_, signs)) = joint.outside {
            let is_mirrored = joint.transform.determinant() < 0.0;
            let points_in = |face: usize| (signs[face] < 0.0) != is_mirrored;
            let inwards = [to_left, to_right].map(points_in).into_iter().zip(INWARDS);
            codes +=
                KNOWS_OUTSIDE + inwards.filter(|(is, _)| *is).map(|(_, code)| code).sum::<u32>();
        }
        let face = |face: usize| {
            let color = joint.sides[face].paint.color_at(bow.middle[face])?;
            Some(StrokeFace {
                start: ends[0].2.normals[face].as_vec3(),
                color: packed(color),
                end: ends[1].2.normals[face].as_vec3(),
                patch: joint.sides[face].patch as f32,
            })
        };
        let shares = |face: usize| ends.map(|(.., end)| end.shares[face].as_vec2());
        let share_sag = |face: usize| {
            let [start, end] = ends.map(|(.., end)| end.shares[face]);
            (bow.middle[face] - start.midpoint(end)).as_vec2()
        };
        let segment = StrokeSegment {
            ends: ends.map(|(place, ..)| place.as_vec2()),
            depths: Vec2::from(ends.map(|(_, depth, _)| depth as f32)),
            half_width: half_width as f32,
            behind,
            sag: shape.sag.as_vec2(),
            depth_sag: -bow.parabola.sag().z as f32,
            codes: codes as f32,
            faces: [face(to_left)?, face(to_right)?],
            shares: [shares(to_left), shares(to_right)],
            share_sags: [share_sag(to_left), share_sag(to_right)],
        };
        segment.is_finite().then_some(segment)
    }

    /// The segment of a part of a line. `steps` are those in its middle.
    fn line(
        &self,
        line: &StrokeLine,
        bow: &Bow,
        shape: &Shape,
        steps: [Step; 2],
    ) -> Option<StrokeSegment> {
        let side = |is_left: bool| {
            let on_side =
                |face: &usize| line.shown[*face] && (steps[*face].to_left >= 0.0) == is_left;
            let nearer = |one: &usize, other: &usize| steps[*one].compare(&steps[*other]);
            let face = (0..2).filter(on_side).min_by(nearer);
            // Without a face, the line has the depth of the edge.
            let normal = |end: End| face.map_or(Vec3::ZERO, |face| end.normals[face].as_vec3());
            let [start, end] = bow.ends.map(normal);
            StrokeFace { start, color: packed(line.color), end, patch: 0.0 }
        };
        let segment = StrokeSegment {
            ends: shape.ends.map(DVec2::as_vec2),
            depths: Vec2::from(bow.tips().map(|tip| -tip.z as f32)),
            half_width: line.half_width as f32,
            behind: (-line.nearer / line.half_width) as f32,
            sag: shape.sag.as_vec2(),
            depth_sag: -bow.parabola.sag().z as f32,
            codes: 0.0,
            faces: [side(true), side(false)],
            shares: [[Vec2::ZERO; 2]; 2],
            share_sags: [Vec2::ZERO; 2],
        };
        segment.is_finite().then_some(segment)
    }
}

/// A colour as one number.
fn packed([red, green, blue]: [u8; 3]) -> f32 {
    (f32::from(red) * 256.0 + f32::from(green)) * 256.0 + f32::from(blue)
}

/// A step from an edge into a face.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// How far it goes to the left of the edge on the screen.
    to_left: f64,
    /// How much farther from the eye.
    farther: f64,
}

impl Step {
    /// Less if its face is the nearer one of two on the same side of an edge.
    fn compare(&self, other: &Self) -> Ordering {
        (self.farther * other.to_left.abs()).total_cmp(&(other.farther * self.to_left.abs()))
    }
}

/// How two faces lie beside an edge on the screen.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Whether each lies to the left.
    is_left: [bool; 2],
    /// Whether both clearly lie on one side.
    is_clear: bool,
    /// Whether both come nearer with the distance from the edge.
    is_deep: bool,
    /// If both lie on the same side, the one in front.
    nearer: Option<usize>,
}

impl Layout {
    /// The layout of an edge that has this one somewhere and another one elsewhere, if one segment can show both.
    fn with(self, other: Self) -> Option<Self> {
        let is_same = self.is_left == other.is_left && self.nearer == other.nearer;
        is_same.then_some(Self {
            is_clear: self.is_clear && other.is_clear,
            is_deep: self.is_deep || other.is_deep,
            ..self
        })
    }
}
