//! Strokes: joints as parabolas of a certain width on the screen. All points of the screen within half a width of such a
//! segment are drawn, as part of one of the two faces.
//!
//! The same segments draw an edge as a line of a given width and colour. A line lies in front of its faces.
//!
//! Why no sample between two faces stays empty: each face's border, as it is drawn, is nowhere further from the edge
//! than the error of the face's triangles plus the distance of its border from the edge. Half of a stroke's width is the
//! larger of the two sums plus the distance of its segments from the edge. Where the borders of both faces pass the same
//! place of the edge, both lie within the disc around it, and so does the line between them. What lies between the two
//! borders are all these lines; the stroke contains all these discs.

mod look;
mod paint;
mod part;
mod segment;

use glam::{DMat2, DMat3, DMat4, DVec2, DVec3, UVec2, Vec2};

use self::look::Look;
pub(crate) use self::paint::{CurvaturePaint, StrokePaint};
use self::part::{Bow, End, Part};
pub(crate) use self::segment::{SEGMENT_TEXELS, StrokeSegment};
use super::Eye;
use crate::bezier::{Difference, Parabola};
use crate::camera::ViewProjection;
use crate::model::{Beside, JointPiece, JointRange};

/// Half of the least width in pixels: the driver moves vertices by 1/256 px at most, in each direction.
const LEAST: f64 = 1.0 / 64.0;
/// The part of a tolerance in pixels that strokes need: what the triangles of surfaces with joints do not get. The
/// distance of parabolas from edges falls with the fourth power of their length, so that little is enough.
pub(crate) fn kept_for_strokes(tolerance: f64) -> f64 {
    (0.0625 * tolerance).max(1.5 * LEAST).min(0.5 * tolerance)
}

/// How far a stroke's segments may be off its edge, in pixels: the stroke, which is wider by as much, is to end within
/// the tolerance.
fn off_edge(tolerance: f64) -> f64 {
    (0.5 * (kept_for_strokes(tolerance) - LEAST)).max(tolerance / 64.0)
}

/// An edge is closed if its ends are nearer to each other than this, as a share of its extent.
const CLOSED: f64 = 1e-6;
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
    /// Whether both faces face away along a range of the pieces, so that the solid itself hides it. A parabola stands for
    /// the range.
    fn is_hidden(&self, range: &JointRange, parabola: &Parabola) -> bool {
        let Some((eye, signs)) = self.outside else { return false };
        let JointRange { off, normals, sines, .. } = *range;
        // All lines of sight to the range differ from one of them by an angle with this sine at most.
        let (sight, spread) = match eye {
            Eye::Towards(direction) => (-direction.normalize_or_zero(), 0.0),
            Eye::At(eye) => {
                let ([start, _, end], half_sag) = (parabola.points, 0.5 * parabola.sag());
                let to_middle = start.midpoint(end) + half_sag - eye;
                let radius = 0.5 * start.distance(end) + half_sag.length() + off;
                (to_middle.normalize_or_zero(), radius / to_middle.length())
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
        let [tip, other_tip] = [first.points[0], last.points[3]];
        let extent = tip.distance(first.points[3]) + joint.ranges[0].off;
        let is_closed = tip.distance(other_tip) <= CLOSED * extent;
        let end = |besides: &[Beside; 2]| End {
            normals: normals(besides),
            shares: besides.map(|beside| beside.share.as_dvec2()),
        };
        let stretch = stretch(&linear);
        // Ranges of pieces, from the whole joint: those that are near a parabola become one segment.
        let mut ranges = vec![(0, 0..joint.pieces.len())];
        while let Some((number, range)) = ranges.pop() {
            let pieces = &joint.pieces[range.clone()];
            let (first, last) = (&pieces[0], &pieces[pieces.len() - 1]);
            let (middle, shares) = JointPiece::middle_of(pieces);
            let parabola = Parabola::through(first.points[0], middle, last.points[3]);
            if joint.is_hidden(&joint.ranges[number], &parabola) {
                continue;
            }
            let ends = [end(&first.start), end(&last.end)];
            let middle = shares.map(Vec2::as_dvec2);
            let is_end = [range.start == 0, range.end == joint.pieces.len()];
            let is_end = is_end.map(|is_end| is_end && !is_closed);
            if let [piece] = pieces {
                let points = piece.points.map(|point| to_view.transform_point3(point));
                let part = Part { points, ends, middle, is_end };
                self.add_part(joint, faces_error, part, 0, segments);
                continue;
            }
            let parabola =
                Parabola { points: parabola.points.map(|point| to_view.transform_point3(point)) };
            let JointRange { off, drift, .. } = joint.ranges[number];
            let difference = Difference { off, drift }.stretched(stretch);
            let bow = Bow { parabola, difference, ends, middle, is_end };
            match self.look(joint, faces_error, &bow, 0) {
                Look::Outside => {}
                Look::Drawn(half_width, shape) => {
                    segments.extend(self.segment(joint, &bow, half_width, shape));
                }
                Look::Divided(_) => {
                    let middle = range.start + range.len() / 2;
                    ranges.push((2 * number + 2, middle..range.end));
                    ranges.push((2 * number + 1, range.start..middle));
                }
            }
        }
    }
}

/// The largest factor by which a map stretches lengths, or a little more unless it stretches all alike.
fn stretch(linear: &DMat3) -> f64 {
    let squared = linear.transpose() * *linear;
    let row = |column: DVec3| column.abs().element_sum();
    [squared.x_axis, squared.y_axis, squared.z_axis].map(row).into_iter().fold(0.0, f64::max).sqrt()
}
