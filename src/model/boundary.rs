//! The part of the plane of parameters that the loops of a face bound, as trims of the drawn surface.
//!
//! Trims fill by even-odd within the domain of the drawn surface. A loop that goes around a closed surface once does
//! not close there: it is repeated until it crosses the domain and closed along the domain's high border. A single such
//! loop that has the face below it needs the border of the domain as another loop.

use glam::{DVec2, dvec2};

use super::chain::{Chain, Piece};
use super::chart::{Axis, axes, drawn_surface};
use super::fit::{Accuracy, Fit, Fitted};
use super::projection::breaks;
use super::sheet::Sheet;
use super::{Coedge, DrawnEdge, DrawnFace, Face, FaceSurface, PcurveSource, Repairs};
use crate::error::{Error, Result};
use crate::trim::{Keep, Segment, TrimLoop, Trims};

/// The domain of a face, and the chains in it.
struct Region<'a, 'b> {
    sheet: &'b Sheet<'a>,
    chains: Vec<Chain<'a>>,
    bounds: [DVec2; 2],
    /// The direction around which chains go that are closed only modulo its period: 0 for u, 1 for v.
    around: Option<usize>,
    /// Along which directions chains are repeated after whole periods.
    repeats: [bool; 2],
    /// Whether the border of the domain is a loop of its own.
    has_border: bool,
}

/// Draws a face whose loops are the given chains.
///
/// # Errors
/// Chains that do not bound a part of the surface, a surface without extent.
pub(super) fn drawn<'a>(
    face: &'a Face,
    sheet: &Sheet<'a>,
    chains: Vec<Chain<'a>>,
    in_space: f64,
) -> Result<DrawnFace> {
    let mut region = Region {
        sheet,
        chains,
        bounds: face.bounds,
        around: None,
        repeats: [false; 2],
        has_border: false,
    };
    region.find(face)?;
    region.draw(in_space)
}

impl Region<'_, '_> {
    /// Finds the domain and places the chains in it.
    fn find(&mut self, face: &Face) -> Result<()> {
        let whole = |axis: usize, start: f64| {
            let [low, high] = self.sheet.limits.map(|limit| limit[axis]);
            match self.sheet.periods[axis] {
                Some(period) if low.is_infinite() => [start, start + period],
                _ => [low, high],
            }
        };
        if self.chains.is_empty() {
            let [low, high] = face.bounds;
            let limits = self.sheet.limits;
            self.bounds = [low.max(limits[0]), high.min(limits[1])];
            return Ok(());
        }
        let sum: glam::IVec2 = self.chains.iter().map(|chain| chain.winding).sum();
        let is_winding = |axis: usize| self.chains.iter().any(|chain| chain.winding[axis] != 0);
        match [is_winding(0), is_winding(1)] {
            [true, true] => {
                Err(Error::invalid("loops", "closed around both directions", "one direction"))
            }
            [false, false] => {
                let area: f64 = self.chains.iter().map(|chain| chain.area).sum();
                let whole = [whole(0, face.bounds[0].x), whole(1, face.bounds[0].y)];
                if area < 0.0 && self.is_outside(face, whole) {
                    self.bounds =
                        [dvec2(whole[0][0], whole[1][0]), dvec2(whole[0][1], whole[1][1])];
                    self.has_border = true;
                    self.repeats = self.sheet.periods.map(|period| period.is_some());
                    return Ok(());
                }
                self.enclose();
                Ok(())
            }
            [along_u, _] => {
                let around = usize::from(!along_u);
                let above = if along_u { sum.x } else { -sum.y };
                self.around = Some(around);
                self.has_border = above < 0;
                let first = self.chains.iter().find(|chain| chain.winding[around] != 0);
                let start = first.map_or(0.0, |chain| chain.pieces[0].ends[0][around]);
                let domain = whole(around, start);
                self.enclose_winding(face, around, domain, above)
            }
        }
    }

    /// Whether loops that run clockwise leave the rest of a closed surface.
    fn is_outside(&self, face: &Face, whole: [[f64; 2]; 2]) -> bool {
        let is_finite = whole.iter().flatten().all(|bound| bound.is_finite());
        let is_closed = self.sheet.periods.iter().any(Option::is_some);
        let size = face.bounds[1] - face.bounds[0];
        let is_smaller = self.chains.iter().all(|chain| {
            let own = chain.bounds[1] - chain.bounds[0];
            own.x < 0.9 * size.x || own.y < 0.9 * size.y
        });
        is_finite && is_closed && is_smaller
    }

    /// The domain of loops that are closed in the parameters.
    fn enclose(&mut self) {
        let size = |chain: &Chain<'_>| (chain.bounds[1] - chain.bounds[0]).element_product();
        let largest = (0..self.chains.len())
            .max_by(|a, b| size(&self.chains[*a]).total_cmp(&size(&self.chains[*b])));
        let Some(largest) = largest else { return };
        self.chains.swap(0, largest);
        let (outer, inner) = self.chains.split_at_mut(1);
        let middle = |chain: &Chain<'_>| chain.bounds[0].midpoint(chain.bounds[1]);
        // The outer loop within the limits.
        for axis in 0..2 {
            let low = self.sheet.limits[0][axis];
            if let (Some(period), true) = (self.sheet.periods[axis], low.is_finite()) {
                let slack = 1e-6 * period;
                let turns = ((outer[0].bounds[0][axis] + slack - low) / period).floor();
                let mut by = DVec2::ZERO;
                by[axis] = -turns * period;
                outer[0].shift(by);
            }
        }
        for chain in inner {
            let near = self.sheet.unwrapped(middle(chain), middle(&outer[0]));
            chain.shift(near - middle(chain));
            let place = chain.pieces[0].ends[0];
            let turns = |axis: usize| self.sheet.periods[axis].map_or([0.0; 3], |p| [0.0, -p, p]);
            let shifts = turns(0).into_iter().flat_map(|x| turns(1).map(|y| dvec2(x, y)));
            let shift = shifts.into_iter().find(|shift| outer[0].contains(place + *shift));
            chain.shift(shift.unwrap_or(DVec2::ZERO));
        }
        let lows = self.chains.iter().map(|chain| chain.bounds[0]);
        let highs = self.chains.iter().map(|chain| chain.bounds[1]);
        let mut low = lows.fold(DVec2::INFINITY, DVec2::min);
        let mut high = highs.fold(DVec2::NEG_INFINITY, DVec2::max);
        for axis in 0..2 {
            let limits = self.sheet.limits.map(|limit| limit[axis]);
            if self.sheet.periods[axis].is_some_and(|p| high[axis] > limits[1] + 1e-6 * p) {
                // Beyond the seam of a surface whose domain cannot begin elsewhere.
                self.repeats[axis] = true;
                (low[axis], high[axis]) = (limits[0], limits[1]);
            }
            low[axis] = low[axis].max(limits[0]);
            high[axis] = high[axis].min(limits[1]);
        }
        self.bounds = [low, high];
    }

    /// The domain where chains go around.
    fn enclose_winding(
        &mut self,
        face: &Face,
        around: usize,
        domain: [f64; 2],
        above: i32,
    ) -> Result<()> {
        let across = 1 - around;
        if self.chains.iter().any(|chain| chain.winding[around].abs() > 1) || above.abs() > 1 {
            return Err(Error::invalid("loops", "several times around", "once around"));
        }
        self.repeats[around] = true;
        let period = domain[1] - domain[0];
        for chain in &mut self.chains {
            let [low, high] = chain.bounds;
            let off = f64::midpoint(domain[0], domain[1]) - low.midpoint(high)[around];
            let mut by = DVec2::ZERO;
            by[around] = period * (off / period).round();
            chain.shift(by);
        }
        let is_above = |chain: &Chain<'_>| (chain.winding[around] > 0) == (around == 0);
        let limits = self.sheet.limits.map(|limit| limit[across]);
        if let Some(period) = self.sheet.periods[across] {
            // The face goes from a chain below it upwards to one above it, perhaps across the seam.
            if above != 0 {
                return Err(Error::invalid("loops", "a single one around", "two on a torus"));
            }
            let middle = |chain: &Chain<'_>| chain.bounds[0].midpoint(chain.bounds[1])[across];
            let lowest = self.chains.iter().find(|c| c.winding[around] != 0 && is_above(c));
            let low = lowest.map_or(0.0, middle);
            for chain in &mut self.chains {
                let mut by = DVec2::ZERO;
                by[across] = -period * ((middle(chain) - low) / period + 1e-9).floor();
                chain.shift(by);
            }
            self.repeats[across] = limits[0].is_finite();
        }
        let lows = self.chains.iter().map(|chain| chain.bounds[0][across]);
        let highs = self.chains.iter().map(|chain| chain.bounds[1][across]);
        let mut low = lows.fold(f64::INFINITY, f64::min).max(limits[0]);
        let mut high = highs.fold(f64::NEG_INFINITY, f64::max).min(limits[1]);
        if self.repeats[across] {
            [low, high] = limits;
        }
        if above != 0 {
            let end = self.end(face, across, above > 0, f64::midpoint(low, high));
            if above > 0 { high = high.max(end) } else { low = low.min(end) }
        }
        self.bounds[0][around] = domain[0];
        self.bounds[1][around] = domain[1];
        self.bounds[0][across] = low;
        self.bounds[1][across] = high;
        Ok(())
    }

    /// Where a surface ends beyond the last chain.
    fn end(&self, face: &Face, axis: usize, is_high: bool, middle: f64) -> f64 {
        let side = usize::from(is_high);
        let limit = self.sheet.limits[side][axis];
        if limit.is_finite() {
            return limit;
        }
        if let FaceSurface::Cone { radius, half_angle, .. } = self.sheet.surface {
            let apex = -radius / half_angle.sin();
            if (apex > middle) == is_high {
                return apex;
            }
        }
        face.bounds[side][axis]
    }

    fn draw(&self, in_space: f64) -> Result<DrawnFace> {
        let [low, high] = self.bounds;
        if !(high - low).cmpgt(DVec2::ZERO).all() || !(high - low).is_finite() {
            let value = format!("{low} to {high}");
            return Err(Error::invalid("parameters of the face", value, "a range above 0"));
        }
        let axes = axes(self.sheet.surface, self.bounds);
        // Spans that are only touched are left out.
        let mut kept = self.bounds;
        for axis in 0..2 {
            if axes[axis] == Axis::Same && self.sheet.limits[0][axis].is_finite() {
                let slack = 1e-9 * (high - low)[axis];
                kept[0][axis] += slack;
                kept[1][axis] -= slack;
            }
        }
        let surface = drawn_surface(self.sheet.surface, kept, axes)?;
        let domain = surface.domain();
        let smooth = |axis: usize| {
            let degree = [surface.degree().u(), surface.degree().v()][axis];
            let own = breaks(&surface.knots()[axis], degree, 1);
            let Some(period) = self.sheet.periods[axis] else { return own };
            let turns = [-period, 0.0, period].into_iter();
            turns.flat_map(|by| own.iter().map(move |value| value + by)).collect()
        };
        let breaks = [smooth(0), smooth(1)];
        let accuracy = Accuracy { in_space, in_domain: 1e-8 * (domain[1] - domain[0]) };
        let outline = Outline { region: self, axes, domain, accuracy, breaks: &breaks };
        let mut trims = Trims { keep: Keep::Inside, ..Trims::default() };
        let mut edges = Vec::new();
        for (number, chain) in self.chains.iter().enumerate() {
            let drawn = outline.chain(chain, number, &mut edges);
            for segments in drawn {
                trims.add_loop(TrimLoop::closed(segments, domain[1] - domain[0])?)?;
            }
        }
        if self.has_border {
            trims.add_loop(TrimLoop::closed(border(domain), domain[1] - domain[0])?)?;
        }
        let gaps = self.chains.iter().flat_map(|chain| chain.gaps.iter().copied()).collect();
        let repairs = Repairs { gaps, ..Repairs::default() };
        Ok(DrawnFace { surface, trims, edges, periods: self.sheet.periods, repairs })
    }
}

/// The border of a domain, counter-clockwise.
fn border([low, high]: [DVec2; 2]) -> Vec<Segment> {
    let corners = [low, dvec2(high.x, low.y), high, dvec2(low.x, high.y)];
    (0..4).map(|i| Segment::Line([corners[i], corners[(i + 1) % 4]])).collect()
}

/// The chains of a region in drawn parameters.
struct Outline<'a, 'b, 'c> {
    region: &'c Region<'a, 'b>,
    axes: [Axis; 2],
    domain: [DVec2; 2],
    accuracy: Accuracy,
    breaks: &'c [Vec<f64>; 2],
}

impl Outline<'_, '_, '_> {
    /// The loops that a chain becomes, and its edges.
    fn chain(
        &self,
        chain: &Chain<'_>,
        number: usize,
        edges: &mut Vec<DrawnEdge>,
    ) -> Vec<Vec<Segment>> {
        let (mut pieces, rough): (Vec<Vec<Segment>>, Vec<bool>) =
            chain.pieces.iter().map(|piece| self.piece(piece)).unzip();
        self.join(chain, &mut pieces);
        let mut before: Option<&Coedge> = None;
        for ((piece, segments), is_rough) in chain.pieces.iter().zip(&pieces).zip(rough) {
            let Some(edge) = &piece.traced else { continue };
            // An edge through a pole has two pieces.
            let is_same = before.is_some_and(|before| std::ptr::eq(before, edge.coedge));
            before = Some(edge.coedge);
            if let Some(last) = edges.last_mut().filter(|_| is_same) {
                last.segments.extend(segments);
                last.is_rough |= is_rough;
                continue;
            }
            let source = match (edge.is_of_file, &edge.coedge.pcurve) {
                (true, _) => PcurveSource::File,
                (false, None) => PcurveSource::Projected,
                (false, Some(_)) => PcurveSource::Refused,
            };
            edges.push(DrawnEdge {
                edge: edge.coedge.edge,
                forward: edge.coedge.forward,
                trim_loop: number,
                source,
                is_rough,
                segments: segments.clone(),
            });
        }
        let segments: Vec<Segment> = pieces.into_iter().flatten().collect();
        let moved = |by: DVec2| segments.iter().map(move |segment| segment.map(|p| p + by));
        let around = self.region.around.filter(|around| chain.winding[*around] != 0);
        let repeats = |axis: usize| {
            let period = self.region.sheet.periods[axis];
            let Some(period) = period.filter(|_| self.region.repeats[axis]) else {
                return vec![0.0];
            };
            let ends = segments.iter().flat_map(|s| s.points()).map(|point| point[axis]);
            let (low, high) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(x), high.max(x))
            });
            // Copies that only touch the domain are not needed.
            let slack = 1e-9 * period;
            let [from, to] = [self.domain[0][axis], self.domain[1][axis]];
            let mut first = ((from + slack - high) / period).ceil();
            let mut last = ((to - slack - low) / period).floor();
            if around == Some(axis) {
                // The chain is to reach over the whole domain.
                let [a, b] = [chain.pieces[0].ends[0][axis], self.end_of(chain)[axis]];
                first = first.min(((from + slack - a.min(b)) / period).floor());
                last = last.max(((to - slack - a.max(b)) / period).ceil());
            } else if around.is_some() {
                // Copies below the domain count for all of it.
                first = first.min(-1.0);
            }
            (0..=(last - first).max(0.0) as usize).map(|i| (first + i as f64) * period).collect()
        };
        let [along_u, along_v] = [repeats(0), repeats(1)];
        let Some(around) = around else {
            let shifts = along_u.iter().flat_map(|x| along_v.iter().map(|y| dvec2(*x, *y)));
            return shifts.map(|by| moved(by).collect()).collect();
        };
        let (mut copies, across) =
            if around == 0 { (along_u, along_v) } else { (along_v, along_u) };
        if chain.winding[around] < 0 {
            copies.reverse();
        }
        let by = |a: f64, b: f64| if around == 0 { dvec2(a, b) } else { dvec2(b, a) };
        let closed = across.iter().filter_map(|b| {
            let mut all: Vec<Segment> = copies.iter().flat_map(|a| moved(by(*a, *b))).collect();
            let top = self.domain[1][1 - around];
            let is_at_top = |point: &DVec2| point[1 - around] == top;
            if all.iter().flat_map(Segment::points).all(is_at_top) {
                return None;
            }
            let (start, end) = (all[0].start(), all[all.len() - 1].end());
            let [mut above_start, mut above_end] = [start, end];
            above_start[1 - around] = top.max(start[1 - around]);
            above_end[1 - around] = above_start[1 - around];
            let corners = [end, above_end, above_start, start];
            let lines = corners.windows(2).filter(|pair| pair[0] != pair[1]);
            all.extend(lines.map(|pair| Segment::Line([pair[0], pair[1]])));
            Some(all)
        });
        closed.collect()
    }

    fn end_of(&self, chain: &Chain<'_>) -> DVec2 {
        chain.pieces[chain.pieces.len() - 1].ends[1]
    }

    /// The segments of a piece in the direction of the loop, and whether they are further from it than fits should be.
    fn piece(&self, piece: &Piece<'_>) -> (Vec<Segment>, bool) {
        let Some(edge) = &piece.traced else {
            return (vec![Segment::Line(piece.ends.map(|end| self.drawn(end)))], false);
        };
        let fit = Fit {
            trace: &edge.trace,
            shift: edge.shift,
            axes: self.axes,
            accuracy: self.accuracy,
            breaks: self.breaks,
        };
        let Fitted { mut segments, is_rough } = fit.segments();
        if !edge.coedge.forward {
            segments.reverse();
            for segment in &mut segments {
                segment.points_mut().reverse();
            }
        }
        (segments, is_rough)
    }

    fn drawn(&self, own: DVec2) -> DVec2 {
        dvec2(self.axes[0].drawn(own.x)[0], self.axes[1].drawn(own.y)[0])
    }

    /// Moves the ends of pieces so that they meet, and those near the border of the domain onto it.
    fn join(&self, chain: &Chain<'_>, pieces: &mut [Vec<Segment>]) {
        let count = pieces.len();
        // A chain that winds goes on a period away from its start.
        let mut turn = DVec2::ZERO;
        for axis in 0..2 {
            if chain.winding[axis] != 0 {
                let period = self.region.sheet.periods[axis].unwrap_or(0.0);
                turn[axis] = f64::from(chain.winding[axis]) * period;
            }
        }
        let slack = self.slack(chain);
        let mut vertices: Vec<DVec2> = (0..count)
            .map(|i| {
                let start = pieces[i][0].start();
                let before = &pieces[(i + count - 1) % count];
                let end = before[before.len() - 1].end();
                let end = if i == 0 { end - turn } else { end };
                self.on_border(start.midpoint(end), slack)
            })
            .collect();
        vertices.push(vertices[0] + turn);
        // Lines along a direction stay so.
        for i in 0..count {
            let [Segment::Line(_)] = pieces[i].as_slice() else { continue };
            for axis in 0..2 {
                let (a, b) = (vertices[i][axis], vertices[i + 1][axis]);
                if a != b && (a - b).abs() <= slack[axis] {
                    let is_border = |x: f64| x == self.domain[0][axis] || x == self.domain[1][axis];
                    let common = if is_border(b) { b } else { a };
                    vertices[i][axis] = common;
                    vertices[i + 1][axis] = common;
                }
            }
        }
        vertices[0] = vertices[count] - turn;
        for (i, segments) in pieces.iter_mut().enumerate() {
            set_end(segments, 0, vertices[i]);
            set_end(segments, 1, vertices[i + 1]);
        }
    }

    /// How far places may be moved in the drawn parameters.
    fn slack(&self, chain: &Chain<'_>) -> DVec2 {
        let mut scale = DVec2::ZERO;
        for piece in &chain.pieces {
            let at = self.region.sheet.at(piece.ends[0].midpoint(piece.ends[1]));
            scale = scale.max(dvec2(at.du.length(), at.dv.length()));
        }
        let in_space = 0.2 * self.accuracy.in_space / scale;
        in_space.min(100.0 * self.accuracy.in_domain).max(0.01 * self.accuracy.in_domain)
    }

    fn on_border(&self, mut place: DVec2, slack: DVec2) -> DVec2 {
        for bound in self.domain {
            for axis in 0..2 {
                if (place[axis] - bound[axis]).abs() <= slack[axis] {
                    place[axis] = bound[axis];
                }
            }
        }
        place
    }
}

/// Moves the start (0) or the end (1) of a chain of segments, with its direction.
fn set_end(segments: &mut [Segment], end: usize, to: DVec2) {
    let index = if end == 0 { 0 } else { segments.len() - 1 };
    let points = segments[index].points_mut();
    let last = points.len() - 1;
    let [at, beside] = if end == 0 { [0, 1] } else { [last, last - 1] };
    let moved = to - points[at];
    points[at] = to;
    if points.len() == 4 {
        points[beside] += moved;
    }
}
