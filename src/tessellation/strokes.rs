//! Strokes: joints as line segments of a certain width on the screen. All points of the screen within half a width of a
//! segment are drawn, as part of one of the two faces.
//!
//! The same segments draw an edge as a line of a given width and colour. A line lies in front of its faces.
//!
//! Why no sample between two faces stays empty: each face's border, as it is drawn, is nowhere further from the edge
//! than the error of the face's triangles plus the distance of its border from the edge. Half of a stroke's width is the
//! larger of the two sums plus the distance of its segments from the edge. Where the borders of both faces pass the same
//! place of the edge, both lie within the disc around it, and so does the line between them. What lies between the two
//! borders are all these lines; the stroke contains all these discs.

mod paint;
mod part;

use bytemuck::{Pod, Zeroable};
use glam::{DMat2, DMat3, DMat4, DVec2, DVec3, UVec2, Vec2, Vec3};

pub(crate) use self::paint::{CurvaturePaint, StrokePaint};
use self::part::{End, Part, line};
use super::Eye;
use crate::camera::ViewProjection;
use crate::model::{Beside, JointPiece, JointRange};

/// Half of the least width in pixels: the driver moves vertices by 1/256 px at most, in each direction.
const LEAST: f64 = 1.0 / 64.0;
/// The part of a tolerance in pixels that strokes need: what the triangles of surfaces with joints do not get.
pub(crate) fn kept_for_strokes(tolerance: f64) -> f64 {
    (0.125 * tolerance).max(1.5 * LEAST).min(0.5 * tolerance)
}

/// How far a stroke's segments may be off its edge, in pixels: the stroke, which is wider by as much, is to end within
/// the tolerance.
fn off_edge(tolerance: f64) -> f64 {
    (0.5 * (kept_for_strokes(tolerance) - LEAST)).max(tolerance / 64.0)
}

/// How much farther than a face its part of a stroke is drawn, as a share of half of the width: the face itself is to
/// be in front.
const BEHIND: f32 = 0.25;
/// The same where both faces come nearer on the sides of the edge: it may be the far side of a solid, and the strokes of
/// edges on the near side are to be in front.
const FAR_BEHIND: f32 = 1.0;
/// What is added to the above if the start of a segment is cut, and if its end is.
const CUT_ENDS: [f32; 2] = [4.0, 8.0];
/// What is added if it is known which side of the faces is the outside of a solid.
const KNOWS_OUTSIDE: f32 = 16.0;
/// What is added then if the normal of the face to the left points into the solid, and if that to the right does.
const INWARDS: [f32; 2] = [32.0, 64.0];
/// An edge is closed if its ends are nearer to each other than this, as a share of its extent.
const CLOSED: f64 = 1e-6;
/// The sine of the least angle to the line of sight at which a face clearly lies on one side of its edge.
const CLEARLY: f64 = 0.1;
/// The longest segment in pixels that has one colour, where colours change along the face.
const VARIED: f64 = 4.0;
/// How often a piece of an edge is divided at most.
const MAX_DIVISIONS: u32 = 40;
/// The number of pixels that the segments of a line may be off its edge.
const OFF_LINE: f64 = 1.0 / 32.0;

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
    /// How much farther than the faces' planes it is drawn, as a share of half of the width; lines are drawn nearer. A
    /// stroke that closes a gap has [`CUT_ENDS`] added for each end that is not round, [`KNOWS_OUTSIDE`] and
    /// [`INWARDS`].
    behind: f32,
    /// For the face that is drawn to the left, seen from the start: the normal ∂u × ∂v in view space at the start, its
    /// colour, the normal at the end and the number of a patch. The same for the face to the right.
    faces: [StrokeFace; 2],
    /// (u, v) of the left face at the start and the end, as shares of the domain, then of the right face.
    shares: [[Vec2; 2]; 2],
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

/// Texels of a segment.
pub(crate) const SEGMENT_TEXELS: usize = size_of::<StrokeSegment>() / 16;

/// A face of a joint in its place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StrokeSide<'a> {
    /// The number of the Bézier patch among the patches of all surfaces, or of any patch of a NURBS surface.
    pub(crate) patch: u32,
    pub(crate) paint: StrokePaint<'a>,
    /// Whether triangles follow it without error.
    pub(crate) is_flat: bool,
    /// 1 if the face lies to the left of the edge's direction, seen against its normal; −1 otherwise.
    pub(crate) side: f64,
}

/// A joint in its place.
pub(crate) struct PlacedJoint<'a> {
    pub(crate) pieces: &'a [JointPiece],
    pub(crate) ranges: &'a [JointRange],
    /// From the model to world space.
    pub(crate) transform: DMat4,
    pub(crate) sides: [StrokeSide<'a>; 2],
    /// The largest distance of the faces' borders from the pieces in world units, with the error of `f32`.
    pub(crate) gap: f64,
    /// What is drawn instead of what closes the gap.
    pub(crate) line: Option<StrokeLine>,
    /// If both faces enclose a solid that is seen from outside: the viewpoint in the model, and for each face 1 if its
    /// normal ∂u × ∂v points out of the solid, else −1.
    pub(crate) outside: Option<(Eye, [f64; 2])>,
}

impl PlacedJoint<'_> {
    /// Whether both faces face away along a range of the pieces, so that the solid itself hides it.
    fn is_hidden(&self, number: usize, pieces: &[JointPiece]) -> bool {
        let Some((eye, signs)) = self.outside else { return false };
        let JointRange { shift, off, normals, sines } = self.ranges[number];
        let (start, end) = (pieces[0].points[0], pieces[pieces.len() - 1].points[3]);
        // All lines of sight to the range differ from one of them by an angle with this sine at most.
        let (sight, spread) = match eye {
            Eye::Towards(direction) => (-direction.normalize_or_zero(), 0.0),
            Eye::At(eye) => {
                let to_middle = start.midpoint(end) + shift - eye;
                let distance = to_middle.length();
                (to_middle / distance, (0.5 * start.distance(end) + off) / distance)
            }
        };
        (0..2).all(|face| {
            let sine = f64::from(sines[face]);
            let least = sine * (1.0 - spread * spread).sqrt() + spread * (1.0 - sine * sine).sqrt();
            sine * sine + spread * spread < 1.0
                && signs[face] * normals[face].as_dvec3().dot(sight) > least
        })
    }
}

/// How a line along a joint is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StrokeLine {
    /// Half of the width in pixels.
    pub(crate) half_width: f64,
    pub(crate) color: [u8; 3],
    /// How much nearer than the faces' planes it lies: by the width of so many pixels there.
    pub(crate) nearer: f64,
    /// Which of the two faces are seen.
    pub(crate) shown: [bool; 2],
}

/// How a camera sees points of view space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StrokeView {
    view: DMat4,
    projection: DMat4,
    /// Half of the picture's size in pixels.
    half: DVec2,
    tolerance: f64,
    /// The least distance along the view axis that is drawn.
    near: f64,
    /// The largest number of pixels that a unit of length takes at distance 1, or for parallel lines of sight at any
    /// distance.
    magnification: f64,
    is_parallel: bool,
}

impl StrokeView {
    /// For a tolerance in pixels.
    pub(crate) fn new(camera: &ViewProjection, size: UVec2, tolerance: f64) -> Self {
        let projection = camera.projection;
        let half = 0.5 * size.as_dvec2();
        let is_parallel = projection.row(3).z == 0.0;
        let near = camera.nearest();
        let scale = DVec2::new(projection.x_axis.x, projection.y_axis.y).abs() * half;
        // Oblique lines of sight magnify displacements along them.
        let slope = if is_parallel { DVec2::ZERO } else { half / scale };
        let magnification = scale.max_element() * (1.0 + slope.length_squared()).sqrt();
        Self { view: camera.view, projection, half, tolerance, near, magnification, is_parallel }
    }

    /// The place of a point of view space on the screen, in pixels from the middle.
    fn place(&self, point: DVec3) -> DVec2 {
        let clip = self.projection * point.extend(1.0);
        clip.truncate().truncate() / clip.w * self.half
    }

    /// The largest number of pixels of a unit of length at a distance along the view axis.
    fn px_per_unit(&self, depth: f64) -> f64 {
        if self.is_parallel { self.magnification } else { self.magnification / depth }
    }

    /// The matrices from a place on the screen (x/w, y/w, 1) to the point that is seen there at distance 0 along the
    /// view axis, and to what is added to it for each unit of distance.
    pub(crate) fn rays(&self) -> [DMat3; 2] {
        let [x, y, w] = [0, 1, 3].map(|row| self.projection.row(row));
        let to_view = DMat2::from_cols(DVec2::new(x.x, y.x), DVec2::new(x.y, y.y)).inverse();
        // x/w · (w.z z + w.w) = x.x X + x.y Y + x.z z + x.w with z = −distance.
        let affine = |by: f64, off: DVec2, z: f64| {
            let columns = [DVec2::X * by, DVec2::Y * by, off].map(|column| to_view * column);
            DMat3::from_cols(columns[0].extend(0.0), columns[1].extend(0.0), columns[2].extend(z))
        };
        [affine(w.w, -DVec2::new(x.w, y.w), 0.0), affine(-w.z, DVec2::new(x.z, y.z), -1.0)]
    }

    /// Appends the segments of a joint that are in the picture.
    pub(crate) fn add(&self, joint: &PlacedJoint<'_>, segments: &mut Vec<StrokeSegment>) {
        let to_view = self.view * joint.transform;
        let linear = DMat3::from_mat4(to_view);
        let cofactors = DMat3::from_cols(
            linear.y_axis.cross(linear.z_axis),
            linear.z_axis.cross(linear.x_axis),
            linear.x_axis.cross(linear.y_axis),
        );
        let normals = |besides: &[Beside; 2]| {
            besides.map(|beside| (cofactors * beside.normal.as_dvec3()).normalize_or_zero())
        };
        let is_flat = joint.sides.iter().all(|side| side.is_flat);
        let faces_error =
            if is_flat { 0.0 } else { self.tolerance - kept_for_strokes(self.tolerance) };
        let [Some(first), Some(last)] = [joint.pieces.first(), joint.pieces.last()] else { return };
        let is_closed = first.points[0].distance(last.points[3]) <= CLOSED * joint.ranges[0].off;
        let part = |pieces: &[JointPiece], shift: DVec3, is_end: [bool; 2]| {
            let (first, last) = (&pieces[0], &pieces[pieces.len() - 1]);
            let [a, b, c, d] = if pieces.len() == 1 {
                first.points
            } else {
                line(first.points[0] + shift, last.points[3] + shift)
            };
            let ends = [&first.start, &last.end].map(|besides| End {
                normals: normals(besides),
                shares: besides.map(|beside| beside.share.as_dvec2()),
            });
            let points = [a, b, c, d].map(|point| to_view.transform_point3(point));
            Part { points, ends, is_end: is_end.map(|end| end && !is_closed) }
        };
        let axes = [linear.x_axis, linear.y_axis, linear.z_axis];
        let scale = axes.iter().map(|axis| axis.length_squared()).sum::<f64>().sqrt();
        // Ranges of pieces, from the whole joint: those that are straight enough become one segment.
        let mut ranges = vec![(0, 0..joint.pieces.len())];
        while let Some((number, range)) = ranges.pop() {
            let pieces = &joint.pieces[range.clone()];
            if joint.is_hidden(number, pieces) {
                continue;
            }
            let is_end = [range.start == 0, range.end == joint.pieces.len()];
            let JointRange { shift, off, .. } = joint.ranges[number];
            let part = part(pieces, shift, is_end);
            if range.len() == 1 {
                self.add_part(joint, faces_error, part, 0, segments);
                continue;
            }
            match self.look(joint, faces_error, &part, scale * off, 0) {
                Look::Outside => {}
                Look::Straight(half_width) => {
                    segments.extend(self.segment(joint, &part, half_width));
                }
                Look::Other(_) => {
                    let middle = range.start + range.len() / 2;
                    ranges.push((2 * number + 2, middle..range.end));
                    ranges.push((2 * number + 1, range.start..middle));
                }
            }
        }
    }

    /// What a part looks like if it is nowhere further than `off` from the segment that stands for it. After many
    /// divisions it counts as straight.
    fn look(
        &self,
        joint: &PlacedJoint<'_>,
        faces_error: f64,
        part: &Part,
        off: f64,
        divisions: u32,
    ) -> Look {
        let depths = part.points.map(|point| -point.z);
        let farthest = depths.into_iter().fold(f64::NEG_INFINITY, f64::max) + off;
        let nearest = depths.into_iter().fold(f64::INFINITY, f64::min) - off;
        if farthest <= self.near {
            return Look::Outside;
        }
        let is_in_front = nearest > self.near;
        let px = self.px_per_unit(if is_in_front { nearest } else { self.near });
        let (off_edge, gap) = match joint.line {
            Some(_) => (OFF_LINE, 0.0),
            None => (off_edge(self.tolerance), joint.gap),
        };
        let half_width = |error: f64| match joint.line {
            Some(line) => line.half_width,
            None => LEAST + faces_error + error + gap * px,
        };
        let error = off * px;
        if is_in_front && self.is_outside(&part.points, half_width(off_edge) + error) {
            return Look::Outside;
        }
        // The width is that of the nearest place; far from it, it may be too much.
        let excess = gap * (px - self.px_per_unit(farthest));
        let is_varied = joint.line.is_none() && joint.sides.iter().any(|side| side.paint.varies());
        let is_short = !is_varied || part.points[0].distance(part.points[3]) * px <= VARIED;
        if (error + excess <= off_edge && is_short) || divisions >= MAX_DIVISIONS {
            Look::Straight(half_width(error))
        } else {
            let is_only_bent = is_in_front && is_short && 2.0 * excess <= off_edge;
            Look::Other(if is_only_bent { (off_edge - excess) / px } else { 0.0 })
        }
    }

    fn add_part(
        &self,
        joint: &PlacedJoint<'_>,
        faces_error: f64,
        part: Part,
        divisions: u32,
        segments: &mut Vec<StrokeSegment>,
    ) {
        match self.look(joint, faces_error, &part, part.bend(), divisions) {
            Look::Outside => {}
            Look::Straight(half_width) => {
                segments.extend(self.segment(joint, &part.straight(), half_width));
            }
            Look::Other(limit) => {
                let count = part.count_within(limit);
                for number in 0..count {
                    let [from, to] = [number, number + 1].map(|i| f64::from(i) / f64::from(count));
                    let part = part.between(from, to);
                    self.add_part(joint, faces_error, part, divisions + 1, segments);
                }
            }
        }
    }

    /// Whether all points lie beyond one side of the picture by more than a width in pixels.
    fn is_outside(&self, points: &[DVec3; 4], width: f64) -> bool {
        let limit = 1.0 + width / self.half;
        let places = points.map(|point| self.place(point) / self.half);
        (0..2).any(|axis| {
            places.iter().all(|place| place[axis] > limit[axis])
                || places.iter().all(|place| place[axis] < -limit[axis])
        })
    }

    /// The straight segment of a part, if any of it is beyond the near plane.
    fn segment(
        &self,
        joint: &PlacedJoint<'_>,
        part: &Part,
        half_width: f64,
    ) -> Option<StrokeSegment> {
        let part = &part.beyond(self.near)?;
        let [start, end] = [part.points[0], part.points[3]];
        let left = (self.place(end) - self.place(start)).perp().normalize_or_zero();
        let middle = start.midpoint(end);
        let direction = part.points[3] - part.points[0];
        // For each face, how far a step into it goes to the left on the screen, and how much further away.
        let steps = [0, 1].map(|face| {
            let normal = part.ends[0].normals[face] + part.ends[1].normals[face];
            let into = joint.sides[face].side * normal.cross(direction).normalize_or_zero();
            let moved = if self.is_parallel {
                into.truncate()
            } else {
                into.truncate() - middle.truncate() * (into.z / middle.z)
            };
            let on_screen = DMat2::from_cols(
                self.projection.x_axis.truncate().truncate(),
                self.projection.y_axis.truncate().truncate(),
            ) * moved
                * self.half;
            (on_screen.dot(left), -into.z)
        });
        if let Some(line) = &joint.line {
            return self.line(line, part, steps);
        }
        let [(a, a_farther), (b, b_farther)] = steps;
        let is_clear = a.abs().min(b.abs()) > CLEARLY * self.magnification;
        let is_fold = (a < 0.0) == (b < 0.0);
        let mut ends = [(start, part.ends[0]), (end, part.ends[1])];
        let ([to_left, to_right], behind) = if is_fold {
            // The nearer face hides the other one. Its border may have receded before that of the other one, so the
            // stroke lies in front. On the other side of the edge there is nothing to draw.
            if is_clear && a < 0.0 {
                ends.reverse();
            }
            ([usize::from(a_farther * b.abs() > b_farther * a.abs()); 2], -BEHIND)
        } else {
            // If both faces come nearer, the edge lies in a valley or on the far side of a solid.
            let is_deep = a_farther < 0.0 && b_farther < 0.0;
            let behind = if is_deep {
                // The strokes of other edges cover the end: that of an edge on the far side would be seen there.
                let cut = CUT_ENDS.iter().zip(part.is_end).filter(|(_, is_end)| *is_end);
                FAR_BEHIND + cut.map(|(code, _)| code).sum::<f32>()
            } else if is_clear {
                BEHIND
            } else {
                -BEHIND
            };
            (if a < 0.0 { [1, 0] } else { [0, 1] }, behind)
        };
        let half_width = if is_fold && is_clear { -half_width } else { half_width };
        let outside = joint.outside.map_or(0.0, |(_, signs)| {
            let is_mirrored = joint.transform.determinant() < 0.0;
            let points_in = |face: usize| (signs[face] < 0.0) != is_mirrored;
            let inwards = [to_left, to_right].map(points_in).into_iter().zip(INWARDS);
            KNOWS_OUTSIDE + inwards.filter(|(is, _)| *is).map(|(_, code)| code).sum::<f32>()
        });
        let face = |face: usize| {
            let [start, end] = ends.map(|(_, end)| end.shares[face]);
            let color = joint.sides[face].paint.color_at(start.midpoint(end))?;
            Some(StrokeFace {
                start: ends[0].1.normals[face].as_vec3(),
                color: packed(color),
                end: ends[1].1.normals[face].as_vec3(),
                patch: joint.sides[face].patch as f32,
            })
        };
        let shares = |face: usize| ends.map(|(_, end)| end.shares[face].as_vec2());
        let places = ends.map(|(point, _)| self.place(point));
        let segment = StrokeSegment {
            ends: places.map(DVec2::as_vec2),
            depths: DVec2::new(-ends[0].0.z, -ends[1].0.z).as_vec2(),
            half_width: half_width as f32,
            behind: behind + outside,
            faces: [face(to_left)?, face(to_right)?],
            shares: [shares(to_left), shares(to_right)],
        };
        places.iter().all(|place| place.is_finite()).then_some(segment)
    }
}

impl StrokeView {
    /// The straight segment of a part of a line. `steps` are, for each face, how far a step into it goes to the left on
    /// the screen, and how much further away.
    fn line(
        &self,
        line: &StrokeLine,
        part: &Part,
        steps: [(f64, f64); 2],
    ) -> Option<StrokeSegment> {
        let ends = [(part.points[0], part.ends[0]), (part.points[3], part.ends[1])];
        let side = |is_left: bool| {
            let on_side = |face: &usize| line.shown[*face] && (steps[*face].0 >= 0.0) == is_left;
            let nearer = |one: &usize, other: &usize| {
                let [one, other] = [steps[*one], steps[*other]];
                (one.1 * other.0.abs()).total_cmp(&(other.1 * one.0.abs()))
            };
            let face = (0..2).filter(on_side).min_by(nearer);
            // Without a face, the line has the depth of the edge.
            let normal = |end: End| face.map_or(Vec3::ZERO, |face| end.normals[face].as_vec3());
            let [start, end] = ends.map(|(_, end)| normal(end));
            StrokeFace { start, color: packed(line.color), end, patch: 0.0 }
        };
        let places = ends.map(|(point, _)| self.place(point));
        let segment = StrokeSegment {
            ends: places.map(DVec2::as_vec2),
            depths: DVec2::new(-ends[0].0.z, -ends[1].0.z).as_vec2(),
            half_width: line.half_width as f32,
            behind: (-line.nearer / line.half_width) as f32,
            faces: [side(true), side(false)],
            shares: [[Vec2::ZERO; 2]; 2],
        };
        places.iter().all(|place| place.is_finite()).then_some(segment)
    }
}

/// A colour as one number.
fn packed([red, green, blue]: [u8; 3]) -> f32 {
    (f32::from(red) * 256.0 + f32::from(green)) * 256.0 + f32::from(blue)
}

/// What a part of an edge looks like.
enum Look {
    /// It is not in the picture.
    Outside,
    /// A segment with half of this width covers it.
    Straight(f64),
    /// It is bent, or near the eye. Parts of it that are off their segments by at most this, in space, count as straight;
    /// 0 if that is not known.
    Other(f64),
}
