//! Finds edges that are the same in space. Files without topology (IGES) give each face edges of its own; afterwards
//! faces that meet share them.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

use super::{BoundedCurve, Curve, Model, NurbsCurve};

/// Inner places at which edges are compared.
const PLACES: u32 = 9;

/// An edge that one face alone uses, once.
struct OpenEdge {
    edge: usize,
    product: usize,
    ends: [DVec3; 2],
}

/// Another edge that is the same.
struct Same {
    edge: usize,
    reversed: bool,
    /// The largest distance between the two.
    apart: f64,
}

impl Model {
    /// Joins edges of a product's faces that no two faces share and that lie within `tolerance` of each other, and returns
    /// how many were joined. Each face keeps its p-curves. Edges shorter than the tolerance stay as they are.
    pub fn sew(&mut self, tolerance: f64) -> usize {
        let open = self.open_edges(tolerance);
        // The middle between its ends finds an edge in either direction.
        let cell = |ends: &[DVec3; 2]| {
            (ends[0].midpoint(ends[1]) / (2.0 * tolerance)).floor().as_i64vec3()
        };
        let mut cells: HashMap<I64Vec3, Vec<usize>> = HashMap::new();
        for (number, edge) in open.iter().enumerate() {
            cells.entry(cell(&edge.ends)).or_default().push(number);
        }
        let mut is_taken = vec![false; open.len()];
        let mut joined: HashMap<usize, (usize, bool)> = HashMap::new();
        for (number, edge) in open.iter().enumerate() {
            if is_taken[number] {
                continue;
            }
            let mut best: Option<(usize, Same)> = None;
            for near in neighbours(cell(&edge.ends)) {
                for other in cells.get(&near).into_iter().flatten() {
                    if *other <= number || is_taken[*other] || open[*other].product != edge.product
                    {
                        continue;
                    }
                    let same = self.compare(edge, &open[*other], tolerance);
                    if let Some(same) = same
                        && best.as_ref().is_none_or(|(_, best)| same.apart < best.apart)
                    {
                        best = Some((*other, same));
                    }
                }
            }
            if let Some((other, same)) = best {
                is_taken[number] = true;
                is_taken[other] = true;
                joined.insert(same.edge, (edge.edge, same.reversed));
            }
        }
        self.replace(&joined);
        joined.len()
    }

    fn open_edges(&self, tolerance: f64) -> Vec<OpenEdge> {
        let mut uses = vec![0_u32; self.edges.len()];
        for coedge in self.faces.iter().flat_map(|face| face.loops.iter().flatten()) {
            uses[coedge.edge] += 1;
        }
        let mut open = Vec::new();
        for (product, of) in self.products.iter().enumerate() {
            let [first, count] = of.faces;
            let faces = self.faces.get(first..first + count).unwrap_or_default();
            for coedge in faces.iter().flat_map(|face| face.loops.iter().flatten()) {
                let Some(curve) = &self.edges[coedge.edge].curve else { continue };
                let ends = curve.range.map(|t| curve.curve.at(t)[0]);
                let middle = curve.curve.at(0.5 * (curve.range[0] + curve.range[1]))[0];
                let is_long = ends.iter().any(|end| end.distance(middle) > tolerance);
                if uses[coedge.edge] == 1 && is_long {
                    open.push(OpenEdge { edge: coedge.edge, product, ends });
                }
            }
        }
        open
    }

    fn compare(&self, edge: &OpenEdge, other: &OpenEdge, tolerance: f64) -> Option<Same> {
        let [own_curve, curve] = [edge, other].map(|edge| self.edges[edge.edge].curve.as_ref());
        let (own_curve, curve) = (own_curve?, curve?);
        let ends_apart = |reversed: bool| {
            let [start, end] = edge.ends;
            let [first, last] = if reversed { [1, 0] } else { [0, 1] }.map(|i| other.ends[i]);
            start.distance(first).max(end.distance(last))
        };
        let mut apart = ends_apart(false).min(ends_apart(true));
        let mut along = 0.0;
        for i in 1..=PLACES {
            if apart > tolerance {
                return None;
            }
            let share = f64::from(i) / f64::from(PLACES + 1);
            let [low, high] = own_curve.range;
            let [place, slope] = own_curve.curve.at(low + share * (high - low));
            let [nearest, other_slope] = nearest(curve, place);
            apart = apart.max(place.distance(nearest));
            along += slope.normalize_or_zero().dot(other_slope.normalize_or_zero());
        }
        let reversed = along < 0.0;
        apart = apart.max(ends_apart(reversed));
        (apart <= tolerance).then_some(Same { edge: other.edge, reversed, apart })
    }

    /// Replaces edges by others, which may run the other way, and removes them.
    fn replace(&mut self, joined: &HashMap<usize, (usize, bool)>) {
        let mut numbers = Vec::with_capacity(self.edges.len());
        let mut next = 0;
        for edge in 0..self.edges.len() {
            numbers.push(next);
            next += usize::from(!joined.contains_key(&edge));
        }
        for coedge in self.faces.iter_mut().flat_map(|face| face.loops.iter_mut().flatten()) {
            if let Some((edge, reversed)) = joined.get(&coedge.edge) {
                coedge.edge = *edge;
                if *reversed {
                    coedge.forward = !coedge.forward;
                    coedge.pcurve = coedge.pcurve.as_ref().map(NurbsCurve::reversed);
                }
            }
            coedge.edge = numbers[coedge.edge];
        }
        let mut edge = 0;
        self.edges.retain(|_| {
            edge += 1;
            !joined.contains_key(&(edge - 1))
        });
    }
}

/// A cell of a grid and those around it.
fn neighbours(cell: I64Vec3) -> impl Iterator<Item = I64Vec3> {
    (0..27).map(move |i| cell + I64Vec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1))
}

/// The point of a curve nearest to a place, and the derivative there.
fn nearest(curve: &BoundedCurve, place: DVec3) -> [DVec3; 2] {
    let [low, high] = curve.range;
    let samples = match &curve.curve {
        Curve::Line { .. } => 1,
        Curve::Circle { .. } | Curve::Ellipse { .. } => 32,
        Curve::Nurbs(curve) => 4 * curve.control_points().len(),
    };
    let at = |i: usize| low + i as f64 / samples as f64 * (high - low);
    let distance = |t: f64| curve.curve.at(t)[0].distance_squared(place);
    let start = (0..=samples).map(at).min_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    let mut t = start.unwrap_or(low);
    for _ in 0..8 {
        let [point, slope] = curve.curve.at(t);
        let step = (place - point).dot(slope) / slope.length_squared();
        if !step.is_finite() {
            break;
        }
        let next = (t + step).clamp(low, high);
        if distance(next) >= distance(t) {
            break;
        }
        t = next;
    }
    curve.curve.at(t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Coedge, Edge, Face, FaceSurface, Frame, Product};
    use glam::{DVec2, DVec4};

    /// A face with one loop of edges of its own: curves, and whether the loop follows them.
    fn add_face(model: &mut Model, curves: Vec<(BoundedCurve, bool)>) {
        let coedge = |(i, (_, forward)): (usize, &(BoundedCurve, bool))| Coedge {
            edge: model.edges.len() + i,
            forward: *forward,
            pcurve: None,
        };
        let coedges = curves.iter().enumerate().map(coedge).collect();
        let frame = Frame { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
        model.faces.push(Face {
            name: String::new(),
            tolerance: 1e-7,
            color: None,
            reversed: false,
            surface: FaceSurface::Plane(frame),
            bounds: [DVec2::ZERO, DVec2::ONE],
            loops: vec![coedges],
        });
        model.products[0].faces[1] += 1;
        let edges =
            curves.into_iter().map(|(curve, _)| Edge { tolerance: 1e-7, curve: Some(curve) });
        model.edges.extend(edges);
    }

    fn empty() -> Model {
        let product = Product { name: String::new(), color: None, faces: [0, 0], uses: Vec::new() };
        Model {
            name: String::new(),
            unit: 1e-3,
            edges: Vec::new(),
            faces: Vec::new(),
            products: vec![product],
        }
    }

    fn line(from: DVec3, to: DVec3) -> BoundedCurve {
        let direction = (to - from).normalize();
        BoundedCurve {
            curve: Curve::Line { origin: from, direction },
            range: [0.0, from.distance(to)],
        }
    }

    fn quarter(radius: f64, reversed: bool) -> BoundedCurve {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let mut points = vec![
            DVec4::new(radius, 0.0, 0.0, 1.0),
            DVec4::new(radius, radius, 0.0, half),
            DVec4::new(0.0, radius, 0.0, 1.0),
        ];
        if reversed {
            points.reverse();
        }
        let curve = NurbsCurve::new(2, vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0], points).unwrap();
        BoundedCurve { curve: Curve::Nurbs(curve), range: [0.0, 1.0] }
    }

    fn circle(start: f64) -> BoundedCurve {
        let frame = Frame { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
        let curve = Curve::Circle { frame, radius: 1.0 };
        BoundedCurve { curve, range: [start, start + std::f64::consts::FRAC_PI_2] }
    }

    #[test]
    fn equal_edges_are_joined_in_either_direction() {
        let (a, b, c) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        let mut model = empty();
        add_face(&mut model, vec![(line(a, b), true), (circle(0.0), true), (line(c, a), true)]);
        // The same arc as a rational curve, nearly, and the other way; a line with the same ends as the arc.
        let d = DVec3::ONE;
        let arc = quarter(1.0, true);
        add_face(&mut model, vec![(arc, true), (line(b, d), true), (line(c, d), false)]);
        add_face(&mut model, vec![(line(b, c), true), (line(b, a), false), (line(a, c), true)]);
        assert_eq!(model.sew(1e-6), 3);
        assert_eq!(model.edges.len(), 6);
        let uses: Vec<Vec<(usize, bool)>> = model
            .faces
            .iter()
            .map(|face| face.loops[0].iter().map(|coedge| (coedge.edge, coedge.forward)).collect())
            .collect();
        assert_eq!(uses[0], [(0, true), (1, true), (2, true)]);
        assert_eq!(uses[1][0], (1, false), "the arc");
        assert_eq!(uses[2][1..], [(0, true), (2, false)], "two lines");
        assert_eq!(model.sew(1e-6), 0);
    }

    #[test]
    fn edges_apart_and_edges_that_are_shared_already_stay() {
        let mut model = empty();
        add_face(&mut model, vec![(quarter(1.0, false), true)]);
        add_face(&mut model, vec![(quarter(1.0 + 1e-5, false), true)]);
        let before = model.clone();
        assert_eq!(model.sew(1e-6), 0);
        assert_eq!(model, before);
        assert_eq!(model.clone().sew(1e-4), 1);
        // A third one that is near both: the nearer one is taken.
        add_face(&mut model, vec![(quarter(1.0 + 8e-6, true), true)]);
        model.faces.swap(0, 1);
        assert_eq!(model.sew(1e-4), 1);
        let edges: Vec<usize> = model.faces.iter().map(|face| face.loops[0][0].edge).collect();
        assert_eq!(edges, [1, 0, 1]);
        let shared = model.clone();
        assert_eq!(model.sew(1e-4), 0);
        assert_eq!(model, shared);
    }
}
