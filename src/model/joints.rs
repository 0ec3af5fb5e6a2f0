//! Joints: curves along which two faces of a model, or two surfaces of a scene, meet, or a face ends, with what each is
//! like there. The renderer closes the gap between the two along them, and draws edges of models as lines.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_8;

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::projection::nearest_on;
use super::{BoundedCurve, Curve, DrawnEdge, DrawnFace, Model, SMOOTH_DEGREES};
use crate::bezier::{Difference, Parabola, SurfacePoint};
use crate::error::Result;
use crate::parallel;

/// An edge where two faces meet, where one face meets itself, or where a face ends; or a curve along which two surfaces of
/// a scene meet.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// The number of the edge in the model. For surfaces of a scene: the number of the joint.
    pub edge: usize,
    /// What meets along it.
    pub kind: JointKind,
    /// The numbers of the two faces, or surfaces; an open edge has the same one twice.
    pub faces: [usize; 2],
    /// On which side each face lies if one looks along the curve and against its normal: 1 to the left, −1 to the
    /// right.
    pub sides: [f64; 2],
    /// The edge from its start to its end: in model space, for surfaces of a scene in world space.
    pub pieces: Vec<JointPiece>,
    /// Ranges of pieces. The first range has all pieces; range k of more than one is halved into the ranges 2k + 1 and
    /// 2k + 2.
    pub ranges: Vec<JointRange>,
    /// The largest distance between the pieces and the border of either face, by samples.
    pub gap: f64,
}

/// What meets along an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum JointKind {
    /// One face with nothing.
    Open,
    /// A face with itself.
    Seam,
    /// Two faces with the same tangent planes, within [`SMOOTH_DEGREES`] everywhere.
    Smooth,
    /// Two faces at an angle.
    Sharp,
}

/// A part of a joint.
#[derive(Debug, Clone, PartialEq)]
pub struct JointPiece {
    /// The control points of a cubic.
    pub points: [DVec3; 4],
    /// What the two faces are like at its start.
    pub start: [Beside; 2],
    /// (u, v) of both at half of its parameter, as [`Beside::share`].
    pub middle: [Vec2; 2],
    /// What they are like at its end.
    pub end: [Beside; 2],
}

/// A range of the pieces of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointRange {
    /// Upper bound of the distance of the pieces from the parabola through their ends and their middle.
    pub off: f64,
    /// The same for points of equal parameters, of which each piece has the same share; and about how far the points of
    /// the faces are from those, if (u, v) are interpolated by a parabola too.
    pub drift: f64,
    /// Of both faces, the unit normal from which the normals along the range differ by at most the angle with the sine
    /// below; zero if that is not known, or a right angle or more.
    pub normals: [Vec3; 2],
    /// The sines of these angles.
    pub sines: [f32; 2],
}

/// A face at a place of its border.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beside {
    /// The unit normal ∂u × ∂v; zero if the surface has none here.
    pub normal: Vec3,
    /// (u, v) as shares of the drawn surface's domain.
    pub share: Vec2,
}

/// The largest distance of a piece from its edge, as a share of the model's diagonal.
const FITTED: f64 = 1e-7;
/// The cosine of the largest angle between a normal and what is interpolated in its place: 5°.
const NORMAL_COS: f32 = 0.996;
/// How often a part of an edge is halved.
const MAX_HALVINGS: u32 = 8;
/// Places on each segment of a border that are compared with the edge, besides the start of the first.
const PLACES: u32 = 4;

impl Model {
    /// The joints of the faces that are drawn, in the order of their edges. `faces` are [`Model::drawn_faces`], and
    /// `diagonal` is [`Model::diagonal`]. An edge of more than two faces has a joint for each but the first; an edge of
    /// only one of these faces is open.
    #[must_use]
    pub fn joints(&self, faces: &[Result<DrawnFace>], diagonal: f64) -> Vec<Joint> {
        let mut uses: BTreeMap<usize, Vec<(usize, &DrawnEdge)>> = BTreeMap::new();
        for (number, face) in faces.iter().enumerate() {
            for edge in face.iter().flat_map(|face| &face.edges) {
                uses.entry(edge.edge).or_default().push((number, edge));
            }
        }
        let pairs: Vec<_> = uses
            .values()
            .flat_map(|uses| {
                let others = if uses.len() == 1 { &uses[..] } else { &uses[1..] };
                others.iter().map(|other| (uses.len() == 1, [uses[0], *other]))
            })
            .collect();
        let joints = parallel::map(pairs.len(), |number| {
            let (is_open, pair) = pairs[number];
            let borders = pair.map(|(face, edge)| {
                let drawn = faces[face].as_ref().ok()?;
                let curve = self.edges[edge.edge].curve.as_ref()?;
                Border::new(drawn, edge, curve, FITTED * diagonal)
            });
            let [Some(one), Some(other)] = borders else { return None };
            let [(one_face, edge), (other_face, _)] = pair;
            let curve = self.edges[edge.edge].curve.as_ref()?;
            let faces = [one_face, other_face];
            let joint = Joint::new(edge.edge, faces, curve, [&one, &other], diagonal);
            Some(if is_open { Joint { kind: JointKind::Open, ..joint } } else { joint })
        });
        joints.into_iter().flatten().collect()
    }
}

impl Joint {
    /// A joint along a curve. `diagonal` is that of the whole model or scene.
    pub(crate) fn new(
        edge: usize,
        faces: [usize; 2],
        curve: &dyn JointCurve,
        borders: [&Border<'_>; 2],
        diagonal: f64,
    ) -> Self {
        let Fit { pieces, largest, is_smooth, .. } = Fit::new(curve, borders, FITTED * diagonal);
        let kind = match (faces[0] == faces[1], is_smooth) {
            (true, _) => JointKind::Seam,
            (_, true) => JointKind::Smooth,
            _ => JointKind::Sharp,
        };
        let gap = borders[0].gap.max(borders[1].gap) + largest;
        let mut ranges = Vec::new();
        measure_ranges(&pieces, 0, &mut ranges);
        Self { edge, kind, faces, sides: borders.map(|border| border.side), pieces, ranges, gap }
    }
}

impl JointPiece {
    /// Where a range of pieces is half, and (u, v) of both faces there. All pieces have the same share of it.
    pub(crate) fn middle_of(pieces: &[Self]) -> (DVec3, [Vec2; 2]) {
        match &pieces[pieces.len() / 2] {
            piece if pieces.len().is_multiple_of(2) => {
                (piece.points[0], piece.start.map(|beside| beside.share))
            }
            piece => (point_of(&piece.points, 0.5), piece.middle),
        }
    }
}

/// Measures a range of pieces, and its halves.
fn measure_ranges(pieces: &[JointPiece], number: usize, ranges: &mut Vec<JointRange>) {
    let [Some(first), Some(last)] = [pieces.first(), pieces.last()] else { return };
    let (middle, _) = JointPiece::middle_of(pieces);
    let parabola = Parabola::through(first.points[0], middle, last.points[3]);
    let share = |i: usize| i as f64 / pieces.len() as f64;
    let difference = |(i, piece): (usize, &JointPiece)| {
        parabola.compare(&piece.points, [share(i), share(i + 1)])
    };
    let Difference { off, drift } =
        pieces.iter().enumerate().map(difference).fold(Difference::default(), Difference::max);
    if ranges.len() <= number {
        ranges.resize(number + 1, JointRange::default());
    }
    let [one, other] = [0, 1].map(|face| normals_of(pieces, face));
    let drift = drift.max(share_drift(pieces));
    ranges[number] = JointRange { off, drift, normals: [one.0, other.0], sines: [one.1, other.1] };
    if pieces.len() > 1 {
        let (first, second) = pieces.split_at(pieces.len() / 2);
        measure_ranges(first, 2 * number + 1, ranges);
        measure_ranges(second, 2 * number + 2, ranges);
    }
}

/// About how far points of both faces are from the pieces, if (u, v) are interpolated along them by a parabola: along an
/// edge, distances in space go with those in parameters.
fn share_drift(pieces: &[JointPiece]) -> f64 {
    let [Some(first), Some(last)] = [pieces.first(), pieces.last()] else { return 0.0 };
    let (point, middle) = JointPiece::middle_of(pieces);
    let length = first.points[0].distance(point) + point.distance(last.points[3]);
    let of_face = |face: usize| {
        let (start, end) = (first.start[face].share, last.end[face].share);
        let sag = middle[face] - start.midpoint(end);
        let off = |(i, share): (usize, Vec2)| {
            let at = i as f32 / (2 * pieces.len()) as f32;
            share.distance(start.lerp(end, at) + 4.0 * at * (1.0 - at) * sag)
        };
        let shares = pieces.iter().flat_map(|piece| [piece.start[face].share, piece.middle[face]]);
        let off = shares.enumerate().map(off).fold(0.0, f32::max);
        let extent = start.distance(middle[face]) + middle[face].distance(end);
        // Shares have 24 digits.
        if off <= 1e-6 { 0.0 } else { f64::from(off / extent) * length }
    };
    of_face(0).max(of_face(1))
}

/// A normal of a face, and the sine of the largest angle between it and any along the pieces.
fn normals_of(pieces: &[JointPiece], face: usize) -> (Vec3, f32) {
    let normals =
        || pieces.iter().flat_map(|piece| [piece.start[face].normal, piece.end[face].normal]);
    let axis = normals().sum::<Vec3>().normalize_or_zero();
    let cosine = normals().map(|normal| normal.dot(axis)).fold(1.0, f32::min);
    // Between the ends of a piece, normals differ from those interpolated.
    let angle = cosine.acos() + NORMAL_COS.acos();
    if angle < std::f32::consts::FRAC_PI_2 { (axis, angle.sin()) } else { (Vec3::ZERO, 1.0) }
}

/// A surface beside a joint, in the space of the joint.
pub(crate) trait JointSurface {
    /// Its point at (u, v).
    fn at(&self, uv: DVec2) -> SurfacePoint;
    /// (u, v) as shares of the domain. Where the surface is closed, on the side of the seam on which `middle` is.
    fn share(&self, uv: DVec2, middle: DVec2) -> DVec2;
}

impl JointSurface for DrawnFace {
    fn at(&self, uv: DVec2) -> SurfacePoint {
        self.at(uv)
    }

    fn share(&self, uv: DVec2, middle: DVec2) -> DVec2 {
        let [low, high] = self.surface.domain();
        (uv + self.periods_into_domain(middle) - low) / (high - low)
    }
}

/// The curve of a joint.
pub(crate) trait JointCurve {
    /// Parameters in ascending order, from the first to the last, between which the curve is smooth and short enough
    /// for a first cubic.
    fn breaks(&self) -> Vec<f64>;
    /// Its point at a parameter.
    fn point(&self, t: f64) -> DVec3;
    /// A cubic between two parameters.
    fn cubic(&self, from: f64, to: f64) -> [DVec3; 4];
    /// The distance of a point from the curve near a parameter.
    fn distance(&self, point: DVec3, near: f64) -> f64;
}

impl JointCurve for BoundedCurve {
    fn breaks(&self) -> Vec<f64> {
        let [first, last] = self.range;
        let mut breaks = vec![first];
        match &self.curve {
            Curve::Line { .. } => {}
            Curve::Circle { .. } | Curve::Ellipse { .. } => {
                let count = ((last - first) / FRAC_PI_8).ceil().clamp(1.0, 1e3) as u32;
                let at = |i: u32| first + f64::from(i) / f64::from(count) * (last - first);
                breaks.extend((1..count).map(at));
            }
            Curve::Nurbs(curve) => {
                breaks.extend(curve.knots().iter().filter(|knot| first < **knot && **knot < last));
                breaks.dedup();
            }
        }
        breaks.push(last);
        breaks
    }

    fn point(&self, t: f64) -> DVec3 {
        self.curve.at(t)[0]
    }

    /// The cubic with the directions of the edge at its ends.
    fn cubic(&self, from: f64, to: f64) -> [DVec3; 4] {
        let length = match self.curve {
            // The cubic nearest to an arc.
            Curve::Circle { .. } | Curve::Ellipse { .. } => 4.0 / 3.0 * (0.25 * (to - from)).tan(),
            _ => (to - from) / 3.0,
        };
        let ([start, slope], [end, slope_at_end]) = (self.curve.at(from), self.curve.at(to));
        [start, start + length * slope, end - length * slope_at_end, end]
    }

    fn distance(&self, point: DVec3, near: f64) -> f64 {
        nearest_on(self, point, near).1
    }
}

/// The border of a surface along the curve of a joint.
pub(crate) struct Border<'a> {
    pub(crate) surface: &'a dyn JointSurface,
    /// As [`Joint::sides`].
    pub(crate) side: f64,
    /// Parameters of the curve, in ascending order, and (u, v) there.
    pub(crate) places: Vec<(f64, DVec2)>,
    /// The largest distance of the places from the curve.
    pub(crate) gap: f64,
}

impl<'a> Border<'a> {
    /// Places whose distance is above the tolerance are looked for along the whole edge.
    fn new(
        face: &'a DrawnFace,
        edge: &DrawnEdge,
        curve: &BoundedCurve,
        tolerance: f64,
    ) -> Option<Self> {
        let [first, last] = curve.range;
        let (mut near, end) = if edge.forward { (first, last) } else { (last, first) };
        let mut places = Vec::with_capacity(1 + edge.segments.len() * PLACES as usize);
        let mut gap: f64 = 0.0;
        let start = edge.segments.first()?.start();
        gap = gap.max(face.point(start).distance(curve.curve.at(near)[0]));
        places.push((near, start));
        for (number, segment) in edge.segments.iter().enumerate() {
            for i in 1..=PLACES {
                let uv = segment.point(f64::from(i) / f64::from(PLACES));
                let point = face.point(uv);
                let is_last = number + 1 == edge.segments.len() && i == PLACES;
                // The ends of a closed edge are the same point.
                let (t, distance) = if is_last {
                    (end, point.distance(curve.curve.at(end)[0]))
                } else {
                    nearest_ahead(curve, point, [near, end], tolerance)
                };
                near = t;
                gap = gap.max(distance);
                places.push((t, uv));
            }
        }
        if !edge.forward {
            places.reverse();
        }
        Some(Self { surface: face, side: if edge.forward { 1.0 } else { -1.0 }, places, gap })
    }

    /// What the surface is like at a parameter of the curve, whose point there is given.
    fn at(&self, t: f64, point: DVec3, tolerance: f64) -> Place {
        let next = self.places.partition_point(|(place, _)| *place < t);
        let next = next.clamp(1, self.places.len() - 1);
        let ((from, at_from), (to, at_to)) = (self.places[next - 1], self.places[next]);
        let share = ((t - from) / (to - from)).clamp(0.0, 1.0);
        let mut uv = if share.is_finite() { at_from.lerp(at_to, share) } else { at_from };
        let mut at = self.surface.at(uv);
        // Between the places, the border is bent.
        let off = point - at.position;
        if let Some(step) = step_along(&at, off).filter(|_| off.length() > tolerance) {
            uv += step;
            at = self.surface.at(uv);
        }
        let normal = at.du.normalize_or_zero().cross(at.dv.normalize_or_zero());
        Place { uv, normal: normal.normalize_or_zero().as_vec3() }
    }

    /// The normals and (u, v) at the start, the middle and the end of a part of the curve.
    fn beside(&self, places: [Place; 3]) -> [Beside; 3] {
        places.map(|Place { uv, normal }| {
            let share = self.surface.share(uv, places[1].uv).clamp(DVec2::ZERO, DVec2::ONE);
            Beside { normal, share: share.as_vec2() }
        })
    }
}

/// The parameter of the point of an edge nearest to a point, between the parameter of the point before and that of the
/// end, and the distance.
fn nearest_ahead(
    curve: &BoundedCurve,
    point: DVec3,
    [near, end]: [f64; 2],
    tolerance: f64,
) -> (f64, f64) {
    const SAMPLES: u32 = 64;
    let from_last = nearest_on(curve, point, near);
    if from_last.1 <= tolerance {
        return from_last;
    }
    let at = |i: u32| near + f64::from(i) / f64::from(SAMPLES) * (end - near);
    let off = |t: &f64| curve.curve.at(*t)[0].distance_squared(point);
    let nearest = (0..=SAMPLES).map(at).min_by(|a, b| off(a).total_cmp(&off(b)));
    let other = nearest_on(curve, point, nearest.unwrap_or(near));
    if other.1 < from_last.1 { other } else { from_last }
}

/// The change of (u, v) that moves a point of a surface by `off`, apart from what is across the surface; `None` where
/// the surface is singular.
fn step_along(SurfacePoint { du, dv, .. }: &SurfacePoint, off: DVec3) -> Option<DVec2> {
    let [a, b, c] = [du.length_squared(), du.dot(*dv), dv.length_squared()];
    let determinant = a * c - b * b;
    let (along_u, along_v) = (du.dot(off), dv.dot(off));
    let step = DVec2::new(c * along_u - b * along_v, a * along_v - b * along_u) / determinant;
    (determinant > 1e-9 * a * c && step.is_finite()).then_some(step)
}

/// A face at a place of its border.
#[derive(Clone, Copy)]
struct Place {
    uv: DVec2,
    normal: Vec3,
}

/// A curve with the borders of two surfaces.
struct Fit<'a> {
    curve: &'a dyn JointCurve,
    borders: [&'a Border<'a>; 2],
    /// The largest distance of a piece from the curve.
    tolerance: f64,
    pieces: Vec<JointPiece>,
    /// The largest distance found.
    largest: f64,
    /// Whether the faces have the same tangent planes at all places found.
    is_smooth: bool,
}

impl<'a> Fit<'a> {
    /// Fits the pieces of a curve.
    fn new(curve: &'a dyn JointCurve, borders: [&'a Border<'a>; 2], tolerance: f64) -> Self {
        let pieces = Vec::new();
        let mut fit = Self { curve, borders, tolerance, pieces, largest: 0.0, is_smooth: true };
        let places = curve.breaks().into_iter().map(|t| (t, fit.places(t))).collect::<Vec<_>>();
        for ends in places.windows(2) {
            fit.add(ends[0], ends[1], 0);
        }
        fit
    }

    /// Whether the faces have the same tangent planes at a place of both, on opposite sides of the edge.
    fn is_smooth_at(&self, [one, other]: [Place; 2]) -> bool {
        let [one, other] = [one, other].map(|place| place.normal.as_dvec3());
        let turned = -self.borders[0].side * self.borders[1].side * other;
        let limit = 2.0 * (0.5 * SMOOTH_DEGREES.to_radians()).sin();
        one == DVec3::ZERO || other == DVec3::ZERO || one.distance(turned) <= limit
    }

    fn places(&self, t: f64) -> [Place; 2] {
        let point = self.curve.point(t);
        self.borders.map(|border| border.at(t, point, self.tolerance))
    }

    /// Appends the pieces between two parameters.
    fn add(&mut self, from: (f64, [Place; 2]), to: (f64, [Place; 2]), halvings: u32) {
        let points = self.curve.cubic(from.0, to.0);
        let middle = from.0.midpoint(to.0);
        let between = self.places(middle);
        let off = [0.25, 0.5, 0.75].map(|share| {
            let point = point_of(&points, share);
            self.curve.distance(point, from.0 + share * (to.0 - from.0))
        });
        let off = off.into_iter().fold(0.0, f64::max);
        let is_even = |side: usize| {
            let mean = from.1[side].normal + to.1[side].normal;
            let normal = between[side].normal;
            normal == Vec3::ZERO || mean.normalize_or_zero().dot(normal) >= NORMAL_COS
        };
        let is_fine = off <= self.tolerance && is_even(0) && is_even(1);
        if is_fine || halvings >= MAX_HALVINGS {
            self.largest = self.largest.max(off);
            let places = [from.1, between, to.1];
            self.is_smooth &= places.into_iter().all(|places| self.is_smooth_at(places));
            let beside = [0, 1].map(|i| self.borders[i].beside([from.1[i], between[i], to.1[i]]));
            let [start, middle, end] = [0, 1, 2].map(|place| beside.map(|of_face| of_face[place]));
            let middle = middle.map(|beside| beside.share);
            self.pieces.push(JointPiece { points, start, middle, end });
            return;
        }
        self.add(from, (middle, between), halvings + 1);
        self.add((middle, between), to, halvings + 1);
    }
}

fn point_of([a, b, c, d]: &[DVec3; 4], t: f64) -> DVec3 {
    let s = 1.0 - t;
    s * s * s * *a + 3.0 * s * s * t * *b + 3.0 * s * t * t * *c + t * t * t * *d
}
