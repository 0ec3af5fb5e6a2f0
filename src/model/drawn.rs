//! Faces as they are drawn: an exact NURBS surface with trims in its parameters.

use glam::{DVec2, DVec3};

use super::boundary;
use super::chain::{Chain, Distances, chain, sorted};
use super::evaluate::nurbs_at;
use super::sheet::Sheet;
use super::{BoundedCurve, Coedge, Curve, Face, FaceSurface, Model};
use crate::bezier::{NurbsSurface, SurfacePoint, bounding_box};
use crate::error::{Error, Result};
use crate::parallel;
use crate::trim::{Segment, Trims};

/// A face as the renderer draws it.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnFace {
    /// The surface over the part of its parameters that the face needs. It is the same as that of the face, but arcs
    /// have the parameters of rational quadratic curves.
    pub surface: NurbsSurface,
    /// The loops in the parameters of `surface`.
    pub trims: Trims,
    /// The edges in the parameters of `surface`, loop by loop.
    pub edges: Vec<DrawnEdge>,
    /// After which differences of u and of v the surface is the same, if it is closed. Edges may lie periods outside of
    /// its domain.
    pub periods: [Option<f64>; 2],
    /// What was changed so that its loops could be drawn.
    pub repairs: Repairs,
}

/// What was changed so that the loops of a face could be drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Repairs {
    /// Whether p-curves of the file were left out, because with them the loops are not closed or bound no part of the
    /// surface.
    pub without_pcurves: bool,
    /// Whether the edges were put in another order: each is followed by the one that begins nearest to its end.
    pub is_reordered: bool,
    /// Gaps between edges that lines close, loop by loop. Gaps below 1e-7 of the model's diagonal are left out.
    pub gaps: Vec<ClosedGap>,
}

/// A gap between two edges of a loop that a line closes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedGap {
    /// The numbers of the edges before and after it.
    pub edges: [usize; 2],
    /// The distance in space between the end of one and the start of the other, on the surface.
    pub length: f64,
}

impl DrawnFace {
    /// The point at (u, v), which may lie periods outside of the domain.
    #[must_use]
    pub fn point(&self, uv: DVec2) -> DVec3 {
        self.at(uv).position
    }

    /// The same with the derivatives.
    pub(super) fn at(&self, uv: DVec2) -> SurfacePoint {
        let [low, high] = self.surface.domain();
        let uv = (uv + self.periods_into_domain(uv)).clamp(low, high);
        nurbs_at(&self.surface, uv.x, uv.y)
    }

    /// The whole periods to be added to (u, v) so that it lies in the domain.
    pub(super) fn periods_into_domain(&self, uv: DVec2) -> DVec2 {
        let [low, high] = self.surface.domain();
        let mut by = DVec2::ZERO;
        for axis in 0..2 {
            if let Some(period) = self.periods[axis] {
                let middle = f64::midpoint(low[axis], high[axis]);
                if !(low[axis]..=high[axis]).contains(&uv[axis]) {
                    by[axis] = -period * ((uv[axis] - middle) / period).round();
                }
            }
        }
        by
    }
}

/// An edge in the parameters of a drawn face.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnEdge {
    /// The number of the edge.
    pub edge: usize,
    /// Whether the segments follow the edge's curve from its start to its end.
    pub forward: bool,
    /// The number of the face's loop; the outermost loop comes first.
    pub trim_loop: usize,
    /// Where the segments come from.
    pub source: PcurveSource,
    /// Whether no lines and cubics were found within the accuracy of fits, 1e-7 of the model's diagonal. The segments
    /// are further from the edge; [`Model::deviations`] says how far.
    pub is_rough: bool,
    /// The edge in the order of the loop.
    pub segments: Vec<Segment>,
}

/// Where the p-curve of an edge comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PcurveSource {
    /// The file.
    File,
    /// The edge's curve in space; the file has no p-curve.
    Projected,
    /// The edge's curve in space, because the file's p-curve is too far from it, or because the face could not be drawn
    /// with it ([`Repairs::without_pcurves`]).
    Refused,
}

/// The largest distance of a p-curve of the file from its edge, as a share of the model's diagonal.
const PCURVE: f64 = 1e-6;
/// The largest distance of the segments of an edge from it, as a share of the model's diagonal.
const FITTED: f64 = 1e-7;
/// The largest distance of an edge from a surface, as a share of the model's diagonal.
const SURFACE: f64 = 1e-3;
/// The largest gap between edges that is closed by a line, as a share of the model's diagonal.
const GAP: f64 = 1e-4;

impl Model {
    /// The diagonal of the bounding box of the whole model, about: by the control points of its edges' curves.
    #[must_use]
    pub fn diagonal(&self) -> f64 {
        let mut boxes: Vec<Vec<DVec3>> = Vec::with_capacity(self.products.len());
        for product in &self.products {
            let [first, count] = product.faces;
            let own = self.faces.get(first..first + count).unwrap_or_default();
            let mut points: Vec<DVec3> = own.iter().flat_map(|face| self.points_of(face)).collect();
            for place in &product.uses {
                let corners = boxes.get(place.product).into_iter().flatten();
                points.extend(corners.map(|point| place.placement.transform_point3(*point)));
            }
            boxes.push(corners(points));
        }
        let all = || corners(self.faces.iter().flat_map(|face| self.points_of(face)).collect());
        let whole = boxes.pop().filter(|corners| !corners.is_empty()).unwrap_or_else(all);
        if whole.is_empty() { 0.0 } else { whole[0].distance(whole[7]) }
    }

    /// Points that span a face.
    fn points_of(&self, face: &Face) -> Vec<DVec3> {
        let coedges = face.loops.iter().flatten();
        let curves = coedges.filter_map(|coedge| self.edges.get(coedge.edge)?.curve.as_ref());
        let mut points: Vec<DVec3> = curves.flat_map(points_of_curve).collect();
        if let FaceSurface::Nurbs(surface) = &face.surface {
            if points.is_empty() {
                points.extend(surface.control_points().iter().map(|point| point.truncate()));
            }
        } else {
            let [low, high] = face.bounds;
            let is_finite = low.is_finite() && high.is_finite();
            if points.len() < 8 && is_finite {
                let at = |i: u32, low: f64, high: f64| low + f64::from(i) / 8.0 * (high - low);
                points.extend((0..81).map(|i| {
                    face.surface.at(at(i % 9, low.x, high.x), at(i / 9, low.y, high.y)).position
                }));
            }
        }
        points
    }

    /// A face as it is drawn. `diagonal` is [`Model::diagonal`], to which tolerances are relative.
    ///
    /// # Errors
    /// A face whose edges do not form closed loops or do not bound a part of its surface; the error names it.
    ///
    /// # Panics
    /// If there is no such face.
    pub fn drawn_face(&self, number: usize, diagonal: f64) -> Result<DrawnFace> {
        let face = &self.faces[number];
        self.draw(face, diagonal).map_err(|error| {
            let name =
                if face.name.is_empty() { String::new() } else { format!(" {:?}", face.name) };
            error.within(format!("face {number}{name}"))
        })
    }

    fn draw(&self, face: &Face, diagonal: f64) -> Result<DrawnFace> {
        for coedge in face.loops.iter().flatten() {
            if coedge.edge >= self.edges.len() {
                let expected = format!("below {}", self.edges.len());
                return Err(Error::invalid("number of an edge", coedge.edge, expected));
            }
        }
        let sheet = self.sheet_of(face, diagonal);
        let distances = Distances {
            pcurve: PCURVE * diagonal,
            surface: SURFACE * diagonal,
            gap: GAP * diagonal,
            line: FITTED * diagonal,
        };
        // The p-curves of the file may be wrong, and the order of the edges.
        let projected = Distances { pcurve: f64::NEG_INFINITY, ..distances };
        let has_pcurves = face.loops.iter().flatten().any(|coedge| coedge.pcurve.is_some());
        let attempts = [(false, &distances), (false, &projected), (true, &projected)];
        let mut first_error = None;
        for (is_sorted, distances) in attempts {
            let drawn = self
                .chains(face, &sheet, is_sorted, distances)
                .and_then(|chains| boundary::drawn(face, &sheet, chains, FITTED * diagonal));
            match drawn {
                Ok(mut drawn) => {
                    drawn.repairs.is_reordered = is_sorted;
                    drawn.repairs.without_pcurves = has_pcurves && distances.pcurve < 0.0;
                    return Ok(drawn);
                }
                Err(error) => first_error = first_error.or(Some(error)),
            }
        }
        Err(first_error.unwrap_or_else(|| Error::invalid("face", "not drawn", "closed loops")))
    }

    /// The surface of a face. The edges of its loops must exist.
    pub(super) fn sheet_of<'a>(&self, face: &'a Face, diagonal: f64) -> Sheet<'a> {
        // The two sides of a seam may be as far apart as its tolerance.
        let coedges = face.loops.iter().flatten();
        let mut uses: Vec<usize> = coedges.map(|coedge| coedge.edge).collect();
        uses.sort_unstable();
        let seams = uses.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]);
        let closed = seams.map(|edge| self.edges[edge].tolerance).fold(PCURVE * diagonal, f64::max);
        Sheet::new(&face.surface, FITTED * diagonal, closed)
    }

    /// The loops of a face in the parameters of its surface.
    fn chains<'a>(
        &'a self,
        face: &'a Face,
        sheet: &'a Sheet<'a>,
        is_sorted: bool,
        distances: &Distances,
    ) -> Result<Vec<Chain<'a>>> {
        let chain = |(number, coedges): (usize, &'a Vec<Coedge>)| {
            let coedges = if is_sorted { sorted(self, coedges) } else { coedges.iter().collect() };
            chain(self, face, &coedges, sheet, distances)
                .map_err(|error| error.within(format!("loop {number}")))
        };
        face.loops.iter().enumerate().map(chain).collect()
    }

    /// All faces as they are drawn, in their order, by several threads.
    #[must_use]
    pub fn drawn_faces(&self) -> Vec<Result<DrawnFace>> {
        let diagonal = self.diagonal();
        parallel::map(self.faces.len(), |number| self.drawn_face(number, diagonal))
    }
}

/// The corners of a bounding box.
fn corners(points: Vec<DVec3>) -> Vec<DVec3> {
    if points.is_empty() {
        return points;
    }
    let [low, high] = bounding_box(points);
    let pick = |i: usize, axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
    (0..8).map(|i| DVec3::new(pick(i, 0), pick(i, 1), pick(i, 2))).collect()
}

fn points_of_curve(curve: &BoundedCurve) -> Vec<DVec3> {
    let [low, high] = curve.range;
    let count = match curve.curve {
        Curve::Line { .. } => 1,
        _ => 16,
    };
    let share = |i: u32| f64::from(i) / f64::from(count);
    (0..=count).map(|i| curve.curve.at(low + share(i) * (high - low))[0]).collect()
}
