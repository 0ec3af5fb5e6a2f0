//! How faces meet along their edges: gaps, angles between normals and jumps of curvature, on the exact surfaces.

mod border;
mod worst;

use glam::DVec3;

use super::projection::breaks;
use super::{BoundedCurve, Coedge, Curve, Model};
use crate::error::Result;
use crate::parallel;
use border::{Border, Follow, Place};
use worst::{MEASURES, Measure, Measures, Search};

/// Faces whose borders are further apart than this share of the model's diagonal leave a gap.
pub const GAP: f64 = 1e-5;
/// Where the normals of two faces differ by at most so many degrees, the edge between them is smooth.
pub const SMOOTH_DEGREES: f64 = 1.0;
/// The largest jump of curvature of an edge of class G2: as a share of the larger of the two curvatures, or of
/// 1 / diagonal where both are smaller.
pub const RELATIVE_JUMP: f64 = 0.05;

/// How the faces at an edge meet. The order is from bad to good.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Continuity {
    /// They are further apart than [`GAP`].
    Gap,
    /// Only one face has the edge.
    Open,
    /// More than two faces have the edge.
    NonManifold,
    /// They touch.
    G0,
    /// They also have the same tangent planes, within [`SMOOTH_DEGREES`].
    G1,
    /// They also have the same curvature across the edge, within [`RELATIVE_JUMP`].
    G2,
}

impl Continuity {
    /// All classes, in their order.
    pub const ALL: [Self; 6] =
        [Self::Gap, Self::Open, Self::NonManifold, Self::G0, Self::G1, Self::G2];

    /// Its name: gap, open, non-manifold, G0, G1 or G2.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gap => "gap",
            Self::Open => "open",
            Self::NonManifold => "non-manifold",
            Self::G0 => "G0",
            Self::G1 => "G1",
            Self::G2 => "G2",
        }
    }

    /// The colour of its edges in pictures: red, green and blue, each 0 … 1. People without one of the three kinds of
    /// cones can tell them apart too, and from a grey surface.
    #[must_use]
    pub const fn color(self) -> [f32; 3] {
        match self {
            Self::Gap => [0.85, 0.35, 0.0],
            Self::Open => [0.5, 0.1, 0.5],
            Self::NonManifold => [1.0, 0.9, 0.1],
            Self::G0 => [0.0, 0.0, 0.0],
            Self::G1 => [0.2, 0.7, 1.0],
            Self::G2 => [0.0, 0.2, 0.8],
        }
    }
}

/// The use of an edge by a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeUse<'a> {
    /// The number of the face.
    pub face: usize,
    /// The use in one of its loops.
    pub coedge: &'a Coedge,
}

/// The largest value along an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worst {
    /// The value.
    pub value: f64,
    /// The point of the edge's curve where it is reached, in the space of the edge's product.
    pub point: DVec3,
}

/// How the faces at an edge meet. Lengths are in the model's unit, in the space of the edge's product.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeContinuity {
    /// The number of the edge.
    pub edge: usize,
    /// The numbers of the faces that have it; a face with a seam stands twice.
    pub faces: Vec<usize>,
    /// The class.
    pub class: Continuity,
    /// The distance between the faces' borders at the same place of the edge. A border is where a surface is nearest to
    /// the edge's curve. `None` for an open edge.
    pub gap: Option<Worst>,
    /// The distance of the faces' borders from the edge's curve.
    pub off_edge: Worst,
    /// The angle between the outward normals in degrees, 0 to 180. Of two faces that are oriented against each other
    /// along the edge, one is turned around. `None` if not just two faces have the edge, or if a surface has no normal
    /// there.
    pub angle: Option<Worst>,
    /// The difference of the normal curvatures across the edge, in 1 / unit. `None` unless the class is G1 or G2.
    pub curvature: Option<Worst>,
    /// The same as a share of the larger curvature, as [`RELATIVE_JUMP`] says.
    pub relative_jump: Option<Worst>,
}

impl Model {
    /// For each edge, the faces that use it, in the order of the faces. A face with a seam uses it twice.
    ///
    /// # Panics
    /// If a loop has an edge that does not exist; [`Model::check`] refuses such models.
    #[must_use]
    pub fn edge_uses(&self) -> Vec<Vec<EdgeUse<'_>>> {
        let mut uses = vec![Vec::new(); self.edges.len()];
        for (face, of) in self.faces.iter().enumerate() {
            for coedge in of.loops.iter().flatten() {
                uses[coedge.edge].push(EdgeUse { face, coedge });
            }
        }
        uses
    }

    /// How the faces meet at each edge that a face uses, in the order of the edges, by several threads. Edges that are
    /// a point are left out.
    ///
    /// Everything is computed on the exact surfaces. The worst places are found by at least 64 places along an edge and
    /// at least 4 in each span of its curve and of the surfaces, and a search around the worst of them.
    ///
    /// # Errors
    /// As [`Model::check`].
    pub fn continuity(&self) -> Result<Vec<EdgeContinuity>> {
        self.check()?;
        let diagonal = self.diagonal();
        let of_faces = parallel::map(self.faces.len(), |face| {
            let sheet = self.sheet_of(&self.faces[face], diagonal);
            Follow::all(self, face, &sheet)
        });
        let mut follows: Vec<Vec<Follow>> = Vec::new();
        follows.resize_with(self.edges.len(), Vec::new);
        for follow in of_faces.into_iter().flatten() {
            follows[follow.edge].push(follow);
        }
        let of_edges = parallel::map(self.edges.len(), |edge| {
            let curve = self.edges[edge].curve.as_ref()?;
            let borders: Vec<Border<'_>> = follows[edge]
                .iter()
                .map(|follow| {
                    let sheet = self.sheet_of(&self.faces[follow.face], diagonal);
                    Border { sheet: sheet.for_near_points(), follow }
                })
                .collect();
            (!borders.is_empty()).then(|| self.of_edge(edge, curve, &borders, diagonal))
        });
        Ok(of_edges.into_iter().flatten().collect())
    }

    fn of_edge(
        &self,
        edge: usize,
        curve: &BoundedCurve,
        borders: &[Border<'_>],
        diagonal: f64,
    ) -> EdgeContinuity {
        // Whether the outside of the surface's ∂u × ∂v is that of the first face, continued across the edge.
        let is_turned: Vec<bool> = {
            let direction = |border: &Border<'_>| border.follow.forward;
            let first = self.faces[borders[0].follow.face].reversed;
            borders
                .iter()
                .enumerate()
                .map(|(i, border)| first ^ (i > 0 && direction(border) == direction(&borders[0])))
                .collect()
        };
        let at = |t: f64| {
            let here = curve.curve.at(t);
            let places: Vec<Place> = std::iter::zip(borders, &is_turned)
                .map(|(border, turned)| border.at(here, t, *turned))
                .collect();
            measures(here[0], &places, diagonal)
        };
        let search = Search::new(sample_places(curve, borders), at);
        let worst = |measure: Measure, noise: f64| {
            let (t, value) = search.worst(measure, noise)?;
            Some(Worst { value, point: curve.curve.at(t)[0] })
        };
        let gap = worst(Measure::Gap, 1e-12 * diagonal);
        let off_edge = worst(Measure::OffEdge, 1e-12 * diagonal);
        let angle = worst(Measure::Angle, 1e-9);
        let is_smooth = angle.is_some_and(|angle| angle.value <= SMOOTH_DEGREES);
        let jump =
            |measure: Measure, noise: f64| is_smooth.then(|| worst(measure, noise)).flatten();
        let curvature = jump(Measure::Jump, 1e-6 / diagonal);
        let relative_jump = jump(Measure::RelativeJump, 1e-6);
        let class = match borders.len() {
            _ if gap.is_some_and(|gap| gap.value > GAP * diagonal) => Continuity::Gap,
            1 => Continuity::Open,
            2 if !is_smooth => Continuity::G0,
            2 if relative_jump.is_some_and(|jump| jump.value <= RELATIVE_JUMP) => Continuity::G2,
            2 => Continuity::G1,
            _ => Continuity::NonManifold,
        };
        let is_shared = matches!(class, Continuity::G1 | Continuity::G2);
        EdgeContinuity {
            edge,
            faces: borders.iter().map(|border| border.follow.face).collect(),
            class,
            gap,
            off_edge: off_edge
                .unwrap_or(Worst { value: 0.0, point: curve.curve.at(curve.range[0])[0] }),
            angle,
            curvature: curvature.filter(|_| is_shared),
            relative_jump: relative_jump.filter(|_| is_shared),
        }
    }
}

/// Places along an edge: several in each span of its curve and of the surfaces that it lies on.
fn sample_places(curve: &BoundedCurve, borders: &[Border<'_>]) -> Vec<f64> {
    const MIN: usize = 64;
    const MIN_EACH: usize = 4;
    /// More spans are sampled as if they were fewer.
    const MAX_SPANS: usize = 250;
    let [low, high] = curve.range;
    let mut ends: Vec<f64> = borders.iter().flat_map(Border::crossings).collect();
    if let Curve::Nurbs(curve) = &curve.curve {
        ends.extend(breaks(curve.knots(), curve.degree(), curve.degree()));
    }
    ends.retain(|t| low < *t && *t < high);
    ends.extend(curve.range);
    ends.sort_by(f64::total_cmp);
    ends.dedup_by(|a, b| *a - *b <= 1e-9 * (high - low));
    if ends.len() > MAX_SPANS {
        ends = curve.range.to_vec();
    }
    let each = MIN.div_ceil(ends.len() - 1).max(MIN_EACH);
    let within = |pair: &[f64], i: usize| pair[0] + (pair[1] - pair[0]) * i as f64 / each as f64;
    let spans = ends.windows(2);
    let inner = spans.flat_map(|pair| (0..each).map(move |i| within(pair, i)));
    inner.chain([high]).collect()
}

/// What is measured at one place of an edge.
fn measures(point: DVec3, places: &[Place], diagonal: f64) -> Measures {
    let mut measures = [f64::NEG_INFINITY; MEASURES];
    let mut set = |measure: Measure, value: f64| {
        // What is no number counts as not measured.
        measures[measure as usize] = measures[measure as usize].max(value);
    };
    for (i, place) in places.iter().enumerate() {
        set(Measure::OffEdge, place.position.distance(point));
        for other in &places[..i] {
            set(Measure::Gap, place.position.distance(other.position));
        }
    }
    if let [a, b] = places {
        if let (Some(a), Some(b)) = (a.normal, b.normal) {
            set(Measure::Angle, a.cross(b).length().atan2(a.dot(b)).to_degrees());
        }
        if let (Some(a), Some(b)) = (a.curvature, b.curvature) {
            let jump = (a - b).abs();
            set(Measure::Jump, jump);
            set(Measure::RelativeJump, jump / a.abs().max(b.abs()).max(1.0 / diagonal));
        }
    }
    measures
}
