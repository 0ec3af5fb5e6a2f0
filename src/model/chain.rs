//! Loops of faces as chains in the parameters of the surface, continuous across the periods and the poles of a surface.

use glam::{DVec2, IVec2};

use super::projection::{Trace, Traced, accurate_pcurve, parts};
use super::sheet::Sheet;
use super::{ClosedGap, Coedge, Edge, Face, Model};
use crate::error::{Error, Result};

/// An edge in a chain, or a line that joins two.
pub(super) struct Piece<'a> {
    /// The edge; `None` for a line.
    pub(super) traced: Option<TracedEdge<'a>>,
    /// Where it begins and ends in the direction of the loop.
    pub(super) ends: [DVec2; 2],
}

/// An edge of a chain.
pub(super) struct TracedEdge<'a> {
    pub(super) trace: Trace<'a>,
    pub(super) coedge: &'a Coedge,
    /// Whole periods to be added to the parameters of the trace.
    pub(super) shift: DVec2,
    /// Whether the trace is the file's p-curve.
    pub(super) is_of_file: bool,
}

/// A loop in the parameters of a surface.
pub(super) struct Chain<'a> {
    pub(super) pieces: Vec<Piece<'a>>,
    /// How many periods lie between its start and its end.
    pub(super) winding: IVec2,
    /// The least and the largest parameters; larger than the loop where the largest lie between samples.
    pub(super) bounds: [DVec2; 2],
    /// The area that it encloses on the left, by samples.
    pub(super) area: f64,
    /// Where lines join edges that are apart.
    pub(super) gaps: Vec<ClosedGap>,
}

impl Piece<'_> {
    /// Places along it in the direction of the loop.
    pub(super) fn places(&self) -> Vec<DVec2> {
        let Some(edge) = &self.traced else { return self.ends.to_vec() };
        let places = edge.trace.samples.iter().map(|(_, uv)| *uv + edge.shift);
        if edge.coedge.forward { places.collect() } else { places.rev().collect() }
    }

    /// The ends of its edge, and how far the edge would go from there in its direction.
    fn inwards(&self) -> Option<[(DVec2, DVec2); 2]> {
        let edge = self.traced.as_ref()?;
        let [first, last] = edge.trace.range;
        let from = |t: f64, length: f64| {
            let Traced { uv, slope, .. } = edge.trace.at(t);
            (uv + edge.shift, slope * length)
        };
        Some([from(first, last - first), from(last, first - last)])
    }
}

/// Distances that matter for chains of a face.
pub(super) struct Distances {
    /// The largest distance of a p-curve of the file from its edge; below 0, p-curves are not used.
    pub(super) pcurve: f64,
    /// The largest distance of an edge from the surface, unless its tolerance is large.
    pub(super) surface: f64,
    /// Parts of chains that are further apart are not joined.
    pub(super) gap: f64,
    /// Parts of chains that are further apart are joined by a line, others by moving their ends.
    pub(super) line: f64,
}

/// The loop of a face, with its edges projected.
///
/// # Errors
/// A loop without edges, one whose edges do not meet, or an edge far from the surface.
pub(super) fn chain<'a>(
    model: &'a Model,
    face: &'a Face,
    coedges: &[&'a Coedge],
    sheet: &'a Sheet<'a>,
    distances: &Distances,
) -> Result<Chain<'a>> {
    let edges = trace(model, coedges, sheet, distances)?;
    let middle = {
        let places = edges.iter().flat_map(|edge| edge.trace.samples.iter().map(|(_, uv)| *uv));
        let count = edges.iter().map(|edge| edge.trace.samples.len()).sum::<usize>();
        places.sum::<DVec2>() / count as f64
    };
    let (pieces, gaps) = (Vec::new(), Vec::new());
    let mut joints = Joints { model, face, sheet, middle, distances, pieces, gaps };
    let first = ends(&edges[0])[0];
    let starts: Vec<DVec2> = edges.iter().map(|edge| ends(edge)[0]).collect();
    let uses: Vec<&Coedge> = edges.iter().map(|edge| edge.coedge).collect();
    let count = edges.len();
    let mut cursor = first;
    for (i, mut edge) in edges.into_iter().enumerate() {
        edge.shift = cursor - starts[i];
        // Whole periods without rounding.
        for axis in 0..2 {
            let period = sheet.periods[axis];
            edge.shift[axis] = period.map_or(0.0, |p| p * (edge.shift[axis] / p).round());
        }
        let ends = ends(&edge).map(|end| end + edge.shift);
        joints.pieces.push(Piece { traced: Some(edge), ends });
        let next = (i + 1) % count;
        let is_seam = uses[i].edge == uses[next].edge && !std::ptr::eq(uses[i], uses[next]);
        cursor = joints.join(ends[1], starts[next], [uses[i].edge, uses[next].edge], is_seam)?;
    }
    let periods = sheet.periods.map(|period| period.unwrap_or(f64::INFINITY));
    let turns = (cursor - first) / DVec2::from(periods);
    let winding = IVec2::new(turns.x.round() as i32, turns.y.round() as i32);
    let Joints { pieces, gaps, .. } = joints;
    let mut chain = Chain { pieces, winding, bounds: [DVec2::ZERO; 2], area: 0.0, gaps };
    chain.measure();
    Ok(chain)
}

/// The edges of a loop in the parameters of the surface.
fn trace<'a>(
    model: &'a Model,
    coedges: &[&'a Coedge],
    sheet: &'a Sheet<'a>,
    distances: &Distances,
) -> Result<Vec<TracedEdge<'a>>> {
    let mut edges: Vec<TracedEdge<'a>> = Vec::with_capacity(coedges.len());
    for &coedge in coedges {
        let near = |edges: &[TracedEdge<'a>]| edges.last().map(|edge| ends(edge)[1]);
        let Some(curve) = &model.edges[coedge.edge].curve else {
            // Without a p-curve, the chain gets a line there.
            if let Some(pcurve) = coedge.pcurve.as_ref().filter(|p| is_point(sheet, p, distances)) {
                let trace = Trace::of_pcurve(sheet, pcurve);
                edges.push(TracedEdge { trace, coedge, shift: DVec2::ZERO, is_of_file: true });
            }
            continue;
        };
        if let Some(pcurve) = accurate_pcurve(sheet, coedge, curve, distances.pcurve) {
            let trace = Trace::of_pcurve(sheet, pcurve);
            edges.push(TracedEdge { trace, coedge, shift: DVec2::ZERO, is_of_file: true });
            continue;
        }
        let mut parts = parts(sheet, curve);
        if !coedge.forward {
            parts.reverse();
        }
        let tolerance = model.edges[coedge.edge].tolerance;
        let most = distances.surface.max(100.0 * tolerance);
        for range in parts {
            let trace = Trace::of_edge(sheet, curve, range, coedge.forward, near(&edges));
            let distance = trace.distance();
            if distance > most {
                let name = format!("distance of edge {} from the surface", coedge.edge);
                return Err(Error::invalid(name, distance, format!("at most {most}")));
            }
            edges.push(TracedEdge { trace, coedge, shift: DVec2::ZERO, is_of_file: false });
        }
    }
    if edges.is_empty() {
        return Err(Error::invalid("loop", "empty", "at least one edge with a curve"));
    }
    Ok(edges)
}

/// Whether a p-curve stays at one point in space.
fn is_point(
    sheet: &Sheet<'_>,
    pcurve: &super::NurbsCurve<glam::DVec3>,
    distances: &Distances,
) -> bool {
    let [low, high] = pcurve.domain();
    let at = |t: f64| sheet.at(pcurve.at(t)[0]).position;
    let first = at(low);
    let most = 10.0 * distances.pcurve;
    [0.25, 0.5, 0.75, 1.0]
        .iter()
        .all(|share| at(low + share * (high - low)).distance(first) <= most)
}

/// Where an edge begins and ends in the direction of its loop, without its shift.
fn ends(edge: &TracedEdge<'_>) -> [DVec2; 2] {
    let samples = &edge.trace.samples;
    let [first, last] = [samples[0].1, samples[samples.len() - 1].1];
    if edge.coedge.forward { [first, last] } else { [last, first] }
}

struct Joints<'a, 'b> {
    model: &'a Model,
    face: &'a Face,
    sheet: &'a Sheet<'a>,
    /// The mean of the loop's parameters.
    middle: DVec2,
    distances: &'b Distances,
    pieces: Vec<Piece<'a>>,
    gaps: Vec<ClosedGap>,
}

impl Joints<'_, '_> {
    /// Joins the end of an edge and the start of the next one, with a line if they are apart. Returns the start, whole
    /// periods off.
    fn join(
        &mut self,
        from: DVec2,
        start: DVec2,
        edges: [usize; 2],
        is_seam: bool,
    ) -> Result<DVec2> {
        let mut to = self.sheet.unwrapped(start, from);
        let at = self.sheet.at(from);
        let singular = self.sheet.singular(&at);
        let is_pole = self.is_edge(edges[0]) && self.is_edge(edges[1]);
        for axis in 0..2 {
            let Some(period) = self.sheet.periods[axis].filter(|_| singular[axis] && is_pole)
            else {
                continue;
            };
            // The face lies to the left of the line along the pole.
            let is_high = from[1 - axis] > self.middle[1 - axis];
            let sign = if is_high == (axis == 0) { -1.0 } else { 1.0 };
            let turn = (sign * (start[axis] - from[axis])).rem_euclid(period);
            let is_none = turn.min(period - turn) < 1e-6 * period;
            let turn = match (is_none, is_seam) {
                (true, true) => period,
                (true, false) => 0.0,
                (false, _) => turn,
            };
            to[axis] = from[axis] + sign * turn;
            if is_none {
                let near = self.sheet.unwrapped(start, to);
                to[axis] = near[axis];
            }
        }
        let there = self.sheet.at(to);
        let gap = at.position.distance(there.position);
        let tolerance = edges.iter().map(|edge| self.model.edges[*edge].tolerance);
        let tolerance = tolerance.fold(self.face.tolerance, f64::max);
        if gap > self.distances.gap.max(10.0 * tolerance) {
            return Err(Error::invalid(
                format!("gap between edges {} and {}", edges[0], edges[1]),
                gap,
                format!("at most {}: a closed loop", self.distances.gap.max(10.0 * tolerance)),
            ));
        }
        let moved = ((to - from).abs() * DVec2::new(at.du.length(), at.dv.length())).element_sum();
        let is_turn = (0..2).any(|axis| singular[axis] && (to[axis] - from[axis]).abs() > 1e-9);
        if gap > self.distances.line {
            self.gaps.push(ClosedGap { edges, length: gap });
        }
        if is_turn || moved > self.distances.line {
            self.pieces.push(Piece { traced: None, ends: [from, to] });
        }
        Ok(to)
    }

    /// Whether an edge is more than a point.
    fn is_edge(&self, edge: usize) -> bool {
        let Edge { curve, .. } = &self.model.edges[edge];
        curve.is_some()
    }
}

impl Chain<'_> {
    /// Sets the bounds and the area.
    fn measure(&mut self) {
        let [mut low, mut high] = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let origin = self.pieces[0].ends[0];
        let mut area = 0.0;
        for piece in &self.pieces {
            let places = piece.places();
            let [mut least, mut largest] =
                [piece.ends[0].min(piece.ends[1]), piece.ends[0].max(piece.ends[1])];
            let [of_ends_least, of_ends_largest] = [least, largest];
            for place in &places {
                least = least.min(*place);
                largest = largest.max(*place);
            }
            // Between samples an edge may go further.
            let margin = 0.02 * (largest - least);
            let inwards = piece.inwards();
            for axis in 0..2 {
                let size = largest[axis] - least[axis];
                let goes_beyond = |bound: f64, sign: f64| {
                    inwards.iter().flatten().any(|(end, direction)| {
                        let is_there = (end[axis] - bound).abs() <= 1e-9 * size;
                        is_there && sign * direction[axis] > 1e-9 * size
                    })
                };
                if least[axis] < of_ends_least[axis] || goes_beyond(least[axis], -1.0) {
                    least[axis] -= margin[axis];
                }
                if largest[axis] > of_ends_largest[axis] || goes_beyond(largest[axis], 1.0) {
                    largest[axis] += margin[axis];
                }
            }
            low = low.min(least);
            high = high.max(largest);
            let pairs = places.windows(2);
            area +=
                pairs.map(|pair| 0.5 * (pair[0] - origin).perp_dot(pair[1] - origin)).sum::<f64>();
        }
        self.bounds = [low, high];
        self.area = area;
    }

    /// Moves the whole chain.
    pub(super) fn shift(&mut self, by: DVec2) {
        for piece in &mut self.pieces {
            piece.ends = piece.ends.map(|end| end + by);
            if let Some(edge) = &mut piece.traced {
                edge.shift += by;
            }
        }
        self.bounds = self.bounds.map(|bound| bound + by);
    }

    /// Whether a place lies within the chain, by its samples.
    pub(super) fn contains(&self, place: DVec2) -> bool {
        let mut inside = false;
        let places: Vec<DVec2> = self.pieces.iter().flat_map(Piece::places).collect();
        for (i, a) in places.iter().enumerate() {
            let b = places[(i + 1) % places.len()];
            if (a.y <= place.y) != (b.y <= place.y) {
                let x = a.x + (b.x - a.x) * (place.y - a.y) / (b.y - a.y);
                inside ^= x > place.x;
            }
        }
        inside
    }
}

/// The edges of a loop, each followed by the one that begins nearest to its end. Edges that are points are left out.
pub(super) fn sorted<'a>(model: &Model, coedges: &'a [Coedge]) -> Vec<&'a Coedge> {
    let ends = |coedge: &Coedge| {
        let curve = model.edges[coedge.edge].curve.as_ref()?;
        let [first, last] = curve.range.map(|t| curve.curve.at(t)[0]);
        Some(if coedge.forward { [first, last] } else { [last, first] })
    };
    let mut rest: Vec<_> = coedges.iter().filter_map(|c| Some((c, ends(c)?))).collect();
    let mut sorted: Vec<&Coedge> = Vec::with_capacity(rest.len());
    let mut cursor = None;
    while !rest.is_empty() {
        let next = cursor.map_or(0, |cursor: glam::DVec3| {
            let far = |i: &usize| rest[*i].1[0].distance_squared(cursor);
            (0..rest.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or(0)
        });
        let (coedge, [_, end]) = rest.remove(next);
        sorted.push(coedge);
        cursor = Some(end);
    }
    sorted
}
