//! How far the edges of drawn faces are from the curves in space, by dense samples.

use glam::DVec3;

use super::projection::nearest_on;
use super::sheet::Sheet;
use super::{BoundedCurve, DrawnEdge, DrawnFace, Model};

/// Largest distances in space of an edge of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// The number of the edge.
    pub edge: usize,
    /// Of the drawn edge from its curve.
    pub drawn: f64,
    /// Of the curve from the face's surface.
    pub surface: f64,
}

/// Places along an edge that are compared.
const PLACES: usize = 200;

impl Model {
    /// How far the edges of a face are from their curves, by 200 places on each. Edges that are a point are left out.
    /// `diagonal` is [`Model::diagonal`].
    ///
    /// # Panics
    /// If the drawn face is not that of the face with this number.
    #[must_use]
    pub fn deviations(&self, number: usize, drawn: &DrawnFace, diagonal: f64) -> Vec<Deviation> {
        let tolerance = 1e-9 * diagonal;
        let sheet = Sheet::new(&self.faces[number].surface, tolerance, 1e3 * tolerance);
        let of = |edge: &DrawnEdge| {
            let curve = self.edges[edge.edge].curve.as_ref()?;
            let mut surface: f64 = 0.0;
            let mut near = None;
            for i in 0..=PLACES {
                let share = i as f64 / PLACES as f64;
                let [low, high] = curve.range;
                let point = curve.curve.at(low + share * (high - low))[0];
                let uv = sheet.nearest(point, near);
                near = Some(uv);
                surface = surface.max(sheet.at(uv).position.distance(point));
            }
            Some(Deviation { edge: edge.edge, drawn: of_edge(drawn, edge, curve), surface })
        };
        drawn.edges.iter().filter_map(of).collect()
    }
}

fn of_edge(drawn: &DrawnFace, edge: &DrawnEdge, curve: &BoundedCurve) -> f64 {
    let [first, last] = curve.range;
    let each = PLACES.div_ceil(edge.segments.len()).max(4);
    let at = |segment: usize, i: usize| -> DVec3 {
        drawn.point(edge.segments[segment].point(i as f64 / each as f64))
    };
    let samples: Vec<(f64, DVec3)> = (0..=PLACES)
        .map(|i| first + (last - first) * i as f64 / PLACES as f64)
        .map(|t| (t, curve.curve.at(t)[0]))
        .collect();
    let mut largest: f64 = 0.0;
    let mut near = if edge.forward { first } else { last };
    for segment in 0..edge.segments.len() {
        for i in 0..=each {
            let point = at(segment, i);
            let (mut t, mut distance) = nearest_on(curve, point, near);
            let (closest, _) = samples
                .iter()
                .map(|(t, sample)| (*t, sample.distance_squared(point)))
                .min_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or((near, 0.0));
            let other = nearest_on(curve, point, closest);
            if other.1 < distance {
                (t, distance) = other;
            }
            near = t;
            largest = largest.max(distance);
        }
    }
    let ends = [at(0, 0), at(edge.segments.len() - 1, each)];
    let of_curve = if edge.forward { [first, last] } else { [last, first] };
    let at_ends = (0..2).map(|i| curve.curve.at(of_curve[i])[0].distance(ends[i]));
    at_ends.fold(largest, f64::max)
}
