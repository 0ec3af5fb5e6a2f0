//! Control points in the driver's memory. They are centred and scaled in `f64`, so that the
//! relative precision of `f32` does not depend on the position and the size of a model.

use std::rc::Rc;

use glam::{DMat4, DVec3, DVec4, Vec4};

use crate::bezier::{Degree, bounding_box, homogeneous};
use crate::error::Result;
use crate::gpu::{Attribute, Buffer, Gl, TexelBuffer, Vertex};

/// The translation and the scale that take a box of control points to coordinates within ±1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LocalFrame {
    center: DVec3,
    /// Half of the longest side of the box, rounded up to a power of two.
    scale: f64,
}

impl LocalFrame {
    /// For the bounding box of the given points.
    pub(crate) fn of<'a>(points: impl Iterator<Item = &'a DVec4>) -> Self {
        let [low, high] = bounding_box(points.map(|point| point.truncate()));
        let half = (0.5 * (high - low)).max_element();
        // The box of equal points has no size. Scaling by a power of two does not round.
        let half = if half > 0.0 { half } else { 1.0 };
        Self { center: low.midpoint(high), scale: half.log2().ceil().exp2() }
    }

    /// Half of the longest side of the box, rounded up to a power of two.
    pub(super) const fn scale(&self) -> f64 {
        self.scale
    }

    /// The matrix from the driver's control points to model space.
    pub(crate) fn to_model(self) -> DMat4 {
        DMat4::from_translation(self.center) * DMat4::from_scale(DVec3::splat(self.scale))
    }

    /// A control point (x, y, z, weight) as it is uploaded: centred, scaled and homogeneous, which
    /// means multiplied by its weight.
    pub(crate) fn apply(self, point: DVec4) -> Vec4 {
        homogeneous(((point.truncate() - self.center) / self.scale).extend(point.w)).as_vec4()
    }
}

/// A homogeneous control point.
impl Vertex for Vec4 {
    const ATTRIBUTES: &'static [Attribute] = &[Attribute::floats(0, 4, 0)];
}

/// The control points of a surface, in a buffer that several surfaces may share.
#[derive(Debug)]
pub(crate) struct ControlPoints {
    buffer: Rc<TexelBuffer>,
    /// The index of the surface's first point in the buffer.
    first: usize,
    centering: LocalFrame,
    /// The scale of the surface's own box when it was last centred. Neighbours that are centred together have a larger
    /// one.
    own_scale: f64,
    /// Upper bound of the coordinates' magnitudes after centring and scaling: 1, or more if points
    /// were moved out of the box.
    extent: f64,
    /// The number of moves since the points were last centred or their box was last computed.
    moved: usize,
    /// Whether the points relative to their patches are up to date.
    has_local: bool,
}

impl ControlPoints {
    /// Uploads the control points of several surfaces into one buffer, each with its own centring. The buffer has room
    /// for as many points again, relative to their patches ([`ControlPoints::write_local`]).
    pub(crate) fn upload(gl: &Gl, surfaces: &[(&[DVec4], LocalFrame)]) -> Result<Vec<Self>> {
        let count: usize = surfaces.iter().map(|(points, _)| points.len()).sum();
        let mut values = Vec::with_capacity(2 * count);
        for (points, centering) in surfaces {
            values.extend(points.iter().map(|point| centering.apply(*point)));
        }
        values.resize(2 * count, Vec4::ZERO);
        let buffer = Rc::new(TexelBuffer::of_vectors(gl, "control points", &values)?);
        let mut first = 0;
        let place = |(points, centering): &(&[DVec4], LocalFrame)| {
            let place = Self {
                buffer: Rc::clone(&buffer),
                first,
                centering: *centering,
                own_scale: LocalFrame::of(points.iter()).scale,
                extent: 1.0,
                moved: 0,
                has_local: false,
            };
            first += points.len();
            place
        };
        Ok(surfaces.iter().map(place).collect())
    }

    /// Overwrites points from an index on.
    pub(crate) fn write(&mut self, index: usize, points: &[DVec4]) {
        let LocalFrame { center, scale } = self.centering;
        let far = |point: &DVec4| ((point.truncate() - center) / scale).abs().max_element();
        self.extent = points.iter().map(far).fold(self.extent, f64::max);
        self.moved += points.len();
        self.has_local = false;
        let values: Vec<Vec4> = points.iter().map(|point| self.centering.apply(*point)).collect();
        self.buffer.buffer().write(self.first + index, &values);
    }

    /// Writes the points once more, relative to one of their patch, unless they are up to date. In these, `f32` resolves
    /// second derivatives as well in a surface of many patches as in one of a single patch; and at a pole, where control
    /// points are the same, as well as elsewhere, because there they are 0.
    pub(super) fn write_local(&mut self, degree: Degree, points: &[DVec4]) {
        if std::mem::replace(&mut self.has_local, true) {
            return;
        }
        let scale = self.centering.scale;
        let values: Vec<Vec4> = points
            .chunks_exact(degree.points())
            .flat_map(|patch| {
                let centering = LocalFrame { center: pole_or_first(degree, patch, scale), scale };
                patch.iter().map(move |point| centering.apply(*point))
            })
            .collect();
        self.buffer.buffer().write(self.local_offset() + self.first, &values);
    }

    /// How far behind a point it is relative to its patch.
    pub(super) fn local_offset(&self) -> usize {
        self.buffer.buffer().bytes() / size_of::<Vec4>() / 2
    }

    /// The index of the surface's first point in the buffer.
    pub(crate) const fn first(&self) -> usize {
        self.first
    }

    /// Whether the surface's points should be centred again: a point has moved far out of the box,
    /// or the box has shrunk to a quarter. If there are many points, their box is only computed
    /// after as many moves.
    pub(crate) fn are_off_center(&mut self, points: &[DVec4]) -> bool {
        const FAR: f64 = 3.0;
        const FEW: usize = 1024;
        if self.extent > FAR {
            return true;
        }
        if self.moved < points.len() && points.len() > FEW {
            return false;
        }
        self.moved = 0;
        4.0 * LocalFrame::of(points.iter()).scale <= self.own_scale
    }

    /// Centres the surface's points again and overwrites them all.
    pub(crate) fn recenter(&mut self, points: &[DVec4]) {
        self.rewrite(LocalFrame::of(points.iter()), points);
    }

    /// Centres the points of the same surface at another degree again, as the surface's own.
    pub(crate) fn recenter_like(&mut self, own: &Self, points: &[DVec4]) {
        self.rewrite(own.centering, points);
    }

    fn rewrite(&mut self, centering: LocalFrame, points: &[DVec4]) {
        self.centering = centering;
        self.own_scale = LocalFrame::of(points.iter()).scale;
        self.extent = 1.0;
        self.moved = 0;
        self.has_local = false;
        let values: Vec<Vec4> = points.iter().map(|point| self.centering.apply(*point)).collect();
        self.buffer.buffer().write(self.first, &values);
    }

    /// Upper bound of the magnitudes of the uploaded coordinates, before multiplication by the
    /// weights.
    pub(crate) const fn extent(&self) -> f64 {
        self.extent
    }

    pub(crate) const fn centering(&self) -> LocalFrame {
        self.centering
    }

    pub(crate) fn texels(&self) -> &Rc<TexelBuffer> {
        &self.buffer
    }

    pub(crate) fn buffer(&self) -> &Buffer {
        self.buffer.buffer()
    }
}

/// A control point of a patch that is the same as its neighbour, or else the first one. `scale` is the size of the
/// surface.
fn pole_or_first(degree: Degree, patch: &[DVec4], scale: f64) -> DVec3 {
    /// Points that are nearer to each other are the same but for rounding.
    const SAME: f64 = 1e-13;
    let columns = degree.columns();
    let is_same = |i: usize, j: usize| {
        patch
            .get(j)
            .is_some_and(|other| other.truncate().distance(patch[i].truncate()) <= SAME * scale)
    };
    let is_pole = |i: &usize| {
        let is_last = (i + 1).is_multiple_of(columns);
        is_same(*i, i + columns) || (!is_last && is_same(*i, i + 1))
    };
    patch[(0..patch.len()).find(is_pole).unwrap_or(0)].truncate()
}
