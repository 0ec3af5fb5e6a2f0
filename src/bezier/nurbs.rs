//! NURBS surfaces: B-spline surfaces with weights.

use glam::{DVec2, DVec3, DVec4, dvec2};

use super::bspline::{Span, check_knots, spans};
use super::{Degree, SurfacePoint, check_control_point, homogeneous};
use crate::error::{Error, Result};

/// A NURBS surface: control points with weights over two knot vectors.
///
/// A knot vector has degree + 1 knots more than there are control points along its direction. Knots rise and may have
/// any multiplicity; the surface need not begin and end in control points. Its domain goes along each direction from
/// knot `degree` to the knot `degree` before the last, counted from 0.
#[derive(Debug, Clone, PartialEq)]
pub struct NurbsSurface {
    degree: Degree,
    knots: [Vec<f64>; 2],
    points: Vec<DVec4>,
}

/// How the Bézier patches of a NURBS surface divide its domain.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PatchGrid {
    /// The parameters along u where each column of patches begins and ends.
    pub(crate) columns: Vec<[f64; 2]>,
    /// The same along v for each row.
    pub(crate) rows: Vec<[f64; 2]>,
    /// For each column, whether it shares its last edge with the next column. For the last column: with the first.
    pub(crate) column_continues: Vec<bool>,
    /// The same for each row.
    pub(crate) row_continues: Vec<bool>,
}

impl PatchGrid {
    /// The first and the last parameters (u, v) of a patch. Patches are numbered row by row.
    pub(crate) fn domain_of(&self, patch: usize) -> [DVec2; 2] {
        let (u, v) =
            (self.columns[patch % self.columns.len()], self.rows[patch / self.columns.len()]);
        [dvec2(u[0], v[0]), dvec2(u[1], v[1])]
    }

    /// The number of the patch at parameters of the domain.
    pub(crate) fn patch_at(&self, place: DVec2) -> usize {
        let along = |spans: &[[f64; 2]], t: f64| {
            spans.partition_point(|span| span[1] < t).min(spans.len() - 1)
        };
        along(&self.rows, place.y) * self.columns.len() + along(&self.columns, place.x)
    }

    /// Whether the surface goes on beyond a side of a patch: 0 is u = 0, 1 is v = 0, 2 is u = 1, 3 is v = 1.
    pub(crate) fn continues(&self, patch: usize, side: usize) -> bool {
        let columns = self.columns.len();
        let (continues, place) = match side {
            0 | 2 => (&self.column_continues, patch % columns),
            _ => (&self.row_continues, patch / columns),
        };
        let before = place.checked_sub(1).unwrap_or(continues.len() - 1);
        continues[if side < 2 { before } else { place }]
    }
}

impl NurbsSurface {
    /// A surface from its full knot vectors along u and v and its control points (x, y, z, weight), row by row, with u
    /// along a row.
    ///
    /// # Errors
    /// Knots that are too few, not finite, decrease or leave no domain, a number of points that is not that of the
    /// knots, a point that is not finite or above 1e15, a weight that is not from 1e-9 to 1e9. Knots and points are
    /// numbered from 0.
    pub fn new(degree: Degree, knots: [Vec<f64>; 2], points: Vec<DVec4>) -> Result<Self> {
        let [columns, rows] = Self::check_knots(degree, &knots)?;
        if columns.checked_mul(rows) != Some(points.len()) {
            return Err(Error::invalid(
                "number of control points",
                points.len(),
                format!("{columns} along u times {rows} along v: knots - degree - 1"),
            ));
        }
        for (index, point) in points.iter().enumerate() {
            check_control_point(*point, index)?;
        }
        Ok(Self { degree, knots, points })
    }

    /// Checks knots along u and v. Returns the numbers of control points along u and v that they ask for.
    ///
    /// # Errors
    /// As [`NurbsSurface::new`].
    pub(crate) fn check_knots(degree: Degree, knots: &[Vec<f64>; 2]) -> Result<[usize; 2]> {
        let columns = check_axis("u", degree.u(), &knots[0])?;
        Ok([columns, check_axis("v", degree.v(), &knots[1])?])
    }

    /// The number of control points of all Bézier patches of a surface with such knots, or a little more.
    pub(crate) fn points_of_patches(degree: Degree, knots: &[Vec<f64>; 2]) -> usize {
        let spans = |degree: usize, knots: &[f64]| {
            let inside = knots.get(degree..knots.len().saturating_sub(degree)).unwrap_or_default();
            inside.windows(2).filter(|pair| pair[0] < pair[1]).count()
        };
        let patches = spans(degree.u(), &knots[0]).saturating_mul(spans(degree.v(), &knots[1]));
        patches.saturating_mul(degree.points())
    }

    /// The degrees along u and v.
    #[must_use]
    pub const fn degree(&self) -> Degree {
        self.degree
    }

    /// The knots along u and along v.
    #[must_use]
    pub const fn knots(&self) -> &[Vec<f64>; 2] {
        &self.knots
    }

    /// Control points along u.
    #[must_use]
    pub fn columns(&self) -> usize {
        self.knots[0].len() - self.degree.u() - 1
    }

    /// Control points along v.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.knots[1].len() - self.degree.v() - 1
    }

    /// The control points (x, y, z, weight), row by row.
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        &self.points
    }

    /// The control points, for changes that keep them valid.
    pub(crate) fn points_mut(&mut self) -> &mut [DVec4] {
        &mut self.points
    }

    /// The first and the last parameters (u, v) of the domain.
    #[must_use]
    pub fn domain(&self) -> [DVec2; 2] {
        let [u, v] = &self.knots;
        [dvec2(u[self.degree.u()], v[self.degree.v()]), dvec2(u[self.columns()], v[self.rows()])]
    }

    /// Value and first derivatives at (u, v) in the domain, by de Boor's algorithm on the given knots; for weights by
    /// the quotient rule. At a knot, derivatives are those towards greater parameters, except at the end of the domain.
    #[must_use]
    pub fn at(&self, u: f64, v: f64) -> SurfacePoint {
        self.in_spans(self.spans_of(dvec2(u, v)), u, v)
    }

    /// The same at a place within a patch, given by its domain; `share` goes from 0 to 1 there. Derivatives are those
    /// within the patch.
    pub(crate) fn at_in(&self, [low, high]: [DVec2; 2], share: DVec2) -> SurfacePoint {
        let place = low + share * (high - low);
        self.in_spans(self.spans_of(low.midpoint(high)), place.x, place.y)
    }

    fn spans_of(&self, place: DVec2) -> [usize; 2] {
        let [u, v] = &self.knots;
        [span_of(self.degree.u(), u, place.x), span_of(self.degree.v(), v, place.y)]
    }

    fn in_spans(&self, [span_u, span_v]: [usize; 2], u: f64, v: f64) -> SurfacePoint {
        let columns = self.columns();
        let first_row = span_v - self.degree.v();
        let along_rows: Vec<[DVec4; 2]> = (first_row..=span_v)
            .map(|row| {
                let points = &self.points[row * columns..][..columns];
                let points = &points[span_u - self.degree.u()..=span_u];
                let points: Vec<DVec4> = points.iter().copied().map(homogeneous).collect();
                de_boor(self.degree.u(), &self.knots[0], span_u, points, u)
            })
            .collect();
        let along_v = |of: usize| {
            let points = along_rows.iter().map(|row| row[of]).collect();
            de_boor(self.degree.v(), &self.knots[1], span_v, points, v)
        };
        let ([value, dv], [du, _]) = (along_v(0), along_v(1));
        let position = value.truncate() / value.w;
        let derivative = |of: DVec4| -> DVec3 { (of.truncate() - position * of.w) / value.w };
        SurfacePoint { position, du: derivative(du), dv: derivative(dv) }
    }

    /// The surface as Bézier patches, one for each pair of spans that are not empty. Neighbours share the control
    /// points of their common edge bit for bit. So do the first and the last patches of a surface that closes up to
    /// rounding.
    ///
    /// The second value are their control points, patch after patch, each row by row.
    pub(crate) fn patches(&self) -> (PatchGrid, Vec<DVec4>) {
        let [along_u, along_v] = [
            Axis::new(self.degree.u(), &self.knots[0]),
            Axis::new(self.degree.v(), &self.knots[1]),
        ];
        // All patches along u of each row of control points, then the same along v of each column of these.
        let (wide, tall) =
            (along_u.spans.len() * self.degree.columns(), along_v.spans.len() * self.degree.rows());
        let mut rows = Vec::with_capacity(wide * self.rows());
        for row in self.points.chunks_exact(self.columns()) {
            along_u.extend_with_curves(row, &mut rows);
        }
        let mut column = Vec::with_capacity(self.rows());
        let mut columns = Vec::with_capacity(wide * tall);
        for i in 0..wide {
            column.clear();
            column.extend(rows[i..].iter().step_by(wide));
            along_v.extend_with_curves(&column, &mut columns);
        }
        drop(rows);
        let closed = close(&mut columns, tall);
        let (along_u, along_v) = (along_u.spans, along_v.spans);
        let (in_row, in_column) = (self.degree.columns(), self.degree.rows());
        let mut points = Vec::with_capacity(wide * tall);
        for j in 0..along_v.len() {
            for i in 0..along_u.len() {
                for row in j * in_column..(j + 1) * in_column {
                    let place = |column: usize| columns[(i * in_row + column) * tall + row];
                    points.extend((0..in_row).map(place));
                }
            }
        }
        let ends = |spans: &[Span]| spans.iter().map(|span| span.ends).collect();
        let continues = |spans: &[Span], closed: bool| {
            let mut continues: Vec<bool> = spans.iter().map(|span| span.continues).collect();
            continues[spans.len() - 1] = closed;
            continues
        };
        let grid = PatchGrid {
            columns: ends(&along_u),
            rows: ends(&along_v),
            column_continues: continues(&along_u, closed[0]),
            row_continues: continues(&along_v, closed[1]),
        };
        (grid, points)
    }
}

/// The number of control points along a direction that the knots ask for.
fn check_axis(axis: &str, degree: usize, knots: &[f64]) -> Result<usize> {
    if knots.len() < 2 * (degree + 1) {
        let expected = format!("at least {} for degree {degree}", 2 * (degree + 1));
        return Err(Error::invalid(format!("number of knots along {axis}"), knots.len(), expected));
    }
    let points = knots.len() - degree - 1;
    check_knots(degree, knots, points)
        .map_err(|error| error.within(format!("knots along {axis}")))?;
    Ok(points)
}

/// The index of the first knot of the span that contains a parameter of the domain.
pub(crate) fn span_of(degree: usize, knots: &[f64], t: f64) -> usize {
    let last = knots.len() - degree - 1;
    let inside = &knots[degree..last];
    let span = degree + inside.partition_point(|knot| *knot <= t).saturating_sub(1);
    // The first of several equal knots begins an empty span.
    let is_span = |span: &usize| knots[*span] < knots[*span + 1];
    (span..last).find(is_span).or_else(|| (degree..span).rev().find(is_span)).unwrap_or(degree)
}

/// De Boor's algorithm: the point of a curve and its derivative, from the control points of a span.
fn de_boor(
    degree: usize,
    knots: &[f64],
    span: usize,
    mut points: Vec<DVec4>,
    t: f64,
) -> [DVec4; 2] {
    let mut derivative = DVec4::ZERO;
    for round in 1..=degree {
        for j in (round..=degree).rev() {
            let [low, high] = [knots[j + span - degree], knots[j + 1 + span - round]];
            if round == degree {
                derivative = (points[j] - points[j - 1]) * (degree as f64 / (high - low));
            }
            points[j] = points[j - 1].lerp(points[j], (t - low) / (high - low));
        }
    }
    [points[degree], derivative]
}

/// The spans of a knot vector, in both directions.
struct Axis {
    spans: Vec<Span>,
    /// Those of the knots in reverse order with the opposite sign.
    reversed: Vec<Span>,
}

impl Axis {
    fn new(degree: usize, knots: &[f64]) -> Self {
        let reversed: Vec<f64> = knots.iter().rev().map(|knot| -knot).collect();
        Self { spans: spans(degree, knots), reversed: spans(degree, &reversed) }
    }

    /// Appends the control points of the Bézier curves of a B-spline curve. Where the curve is continuous, neighbours
    /// share their common end. The direction in which the curve is given makes no difference, not even by rounding.
    fn extend_with_curves(&self, points: &[DVec4], curves: &mut Vec<DVec4>) {
        let bits = |point: &DVec4| point.to_array().map(f64::to_bits);
        let is_reversed = points.iter().rev().map(bits).lt(points.iter().map(bits));
        let first = curves.len();
        if is_reversed {
            let points: Vec<DVec4> = points.iter().rev().copied().collect();
            extend(&self.reversed, &points, curves);
            curves[first..].reverse();
        } else {
            extend(&self.spans, points, curves);
        }
    }
}

fn extend(spans: &[Span], points: &[DVec4], curves: &mut Vec<DVec4>) {
    for (i, span) in spans.iter().enumerate() {
        let start = curves.len();
        let count = span.factors.len().isqrt();
        let own = &points[span.first..][..count];
        curves.extend(span.factors.chunks_exact(count).map(|factors| blend(factors, own)));
        if i > 0 && spans[i - 1].continues {
            curves[start - 1] = curves[start];
        }
    }
}

/// A blend of control points (x, y, z, weight). Equal weights stay what they are, and so does a point of which the
/// blend consists alone.
fn blend(factors: &[f64], points: &[DVec4]) -> DVec4 {
    let used = || factors.iter().zip(points).filter(|(factor, _)| **factor != 0.0);
    let weight = used().next().map_or(1.0, |(_, point)| point.w);
    if used().count() == 1 {
        return used().map(|(_, point)| *point).sum();
    }
    if used().all(|(_, point)| point.w == weight) {
        let sum: DVec3 = used().map(|(factor, point)| point.truncate() * *factor).sum();
        return sum.extend(weight);
    }
    let sum: DVec4 = used().map(|(factor, point)| homogeneous(*point) * *factor).sum();
    (sum.truncate() / sum.w).extend(sum.w)
}

/// Closes a surface whose opposite borders are equal up to rounding, along u and along v. The control points are
/// given column by column, `tall` points each. Returns along which directions they are equal.
fn close(columns: &mut [DVec4], tall: usize) -> [bool; 2] {
    /// Relative to the largest coordinate, and of a weight.
    const ROUNDING: f64 = 1e-13;
    let size = columns.iter().map(|point| point.truncate().abs().max_element()).fold(0.0, f64::max);
    let equal = |a: &DVec4, b: &DVec4| {
        let off = (*a - *b).abs();
        off.truncate().max_element() <= ROUNDING * size && off.w <= ROUNDING * a.w
    };
    let last = columns.len() - tall;
    let along_u = (0..tall).all(|i| equal(&columns[i], &columns[last + i]));
    if along_u {
        columns.copy_within(0..tall, last);
    }
    let along_v = columns.chunks_exact(tall).all(|column| equal(&column[0], &column[tall - 1]));
    if along_v {
        for column in columns.chunks_exact_mut(tall) {
            column[tall - 1] = column[0];
        }
    }
    [along_u, along_v]
}
