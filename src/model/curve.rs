//! Curves in space, and B-spline curves of any dimension.

use glam::{DVec3, DVec4};

use super::Frame;
use crate::bezier::check_knots;
use crate::error::Result;

/// A part of a curve, between two of its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct BoundedCurve {
    /// The curve.
    pub curve: Curve,
    /// The first and the last parameter; the first is less.
    pub range: [f64; 2],
}

/// A curve in space with its parameter t. x, y and the origin o are those of the frame.
#[derive(Debug, Clone, PartialEq)]
pub enum Curve {
    /// o + t d.
    Line {
        /// o.
        origin: DVec3,
        /// d, of unit length.
        direction: DVec3,
    },
    /// o + r (cos t x + sin t y).
    Circle {
        /// Its origin is the centre.
        frame: Frame,
        /// r, above 0.
        radius: f64,
    },
    /// o + a cos t x + b sin t y.
    Ellipse {
        /// Its origin is the centre.
        frame: Frame,
        /// a and b, both above 0.
        radii: [f64; 2],
    },
    /// A B-spline or Bézier curve: control points (x, y, z, weight).
    Nurbs(NurbsCurve<DVec4>),
}

/// A NURBS curve. The last coordinate of a control point is its weight; the others are not multiplied by it.
///
/// It takes the room of a pointer, because most coedges have none.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsCurve<P>(Box<Parts<P>>);

#[derive(Debug, Clone, PartialEq)]
struct Parts<P> {
    degree: usize,
    knots: Vec<f64>,
    points: Vec<P>,
}

impl<P> NurbsCurve<P> {
    /// A curve from its full knot vector and its control points. A knot vector has degree + 1 knots more than there
    /// are control points.
    ///
    /// # Errors
    /// A degree that is not from 1 to 15; knots that are not finite, decrease or leave no domain; a number of knots
    /// that is not that of the points. Knots are numbered from 0.
    pub fn new(degree: usize, knots: Vec<f64>, points: Vec<P>) -> Result<Self> {
        check_knots(degree, &knots, points.len())?;
        Ok(Self(Box::new(Parts { degree, knots, points })))
    }

    /// The degree.
    #[must_use]
    pub const fn degree(&self) -> usize {
        self.0.degree
    }

    /// The knots.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.0.knots
    }

    /// The control points.
    #[must_use]
    pub fn control_points(&self) -> &[P] {
        &self.0.points
    }

    /// The same curve from its end to its start, over the same domain.
    #[must_use]
    pub fn reversed(&self) -> Self
    where
        P: Copy,
    {
        let [low, high] = self.domain();
        let Parts { degree, knots, points } = &*self.0;
        let knots = knots.iter().rev().map(|knot| low + high - knot).collect();
        let points = points.iter().rev().copied().collect();
        Self(Box::new(Parts { degree: *degree, knots, points }))
    }

    /// The first and the last parameter.
    #[must_use]
    pub fn domain(&self) -> [f64; 2] {
        [self.0.knots[self.0.degree], self.0.knots[self.0.points.len()]]
    }
}
