//! Finds edges that are the same in space. Files without topology (IGES) give each face edges of its own; afterwards
//! faces that meet share them.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

use super::projection::nearest_on;
use super::{BoundedCurve, Curve, Model, NurbsCurve};

/// Inner places at which edges are compared.
const PLACES: u32 = 9;

/// An edge that one face alone uses, once.
struct OpenEdge {
    edge: usize,
    face: usize,
    product: usize,
    ends: [DVec3; 2],
}

/// How an edge is the same as another one.
struct Same {
    /// Whether it runs the other way.
    reversed: bool,
    /// The largest distance between the two.
    apart: f64,
}

/// Open edges by the middle between their ends, which finds an edge in either direction.
struct Cells {
    size: f64,
    /// The numbers of the edges of a product in each cell.
    edges: HashMap<(usize, I64Vec3), Vec<usize>>,
    is_taken: Vec<bool>,
}

impl Cells {
    fn new(open: &[OpenEdge], tolerance: f64) -> Self {
        let is_taken = vec![false; open.len()];
        let mut cells = Self { size: 2.0 * tolerance, edges: HashMap::new(), is_taken };
        for (number, edge) in open.iter().enumerate() {
            cells.edges.entry((edge.product, cells.cell(edge))).or_default().push(number);
        }
        cells
    }

    fn cell(&self, edge: &OpenEdge) -> I64Vec3 {
        (edge.ends[0].midpoint(edge.ends[1]) / self.size).floor().as_i64vec3()
    }

    /// The other edges near an edge that is not taken yet.
    fn near(&self, number: usize, edge: &OpenEdge) -> impl Iterator<Item = usize> {
        let middle = self.cell(edge);
        let cells =
            (0..27).map(move |i| middle + I64Vec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
        let cells = cells.filter(move |_| !self.is_taken[number]);
        let edges = cells.filter_map(|cell| self.edges.get(&(edge.product, cell)));
        edges.flatten().copied().filter(move |other| *other != number)
    }

    /// Takes an edge out of its cell.
    fn take(&mut self, number: usize, edge: &OpenEdge) {
        self.is_taken[number] = true;
        let key = (edge.product, self.cell(edge));
        if let Some(numbers) = self.edges.get_mut(&key)
            && let Some(place) = numbers.iter().position(|other| *other == number)
        {
            numbers.swap_remove(place);
        }
    }
}

impl Model {
    /// Joins edges of a product's faces that no two faces share and that lie within `tolerance` of each other, and
    /// returns how many were joined. Each face keeps its p-curves. Edges shorter than the tolerance stay as they are,
    /// and so do two edges of one face, unless they are equal up to rounding: a seam.
    pub fn sew(&mut self, tolerance: f64) -> usize {
        /// A share of the tolerance: edges that are this near are equal.
        const EQUAL: f64 = 1e-3;
        let open = self.open_edges(tolerance);
        let mut cells = Cells::new(&open, tolerance);
        let mut joined: HashMap<usize, (usize, bool)> = HashMap::new();
        let mut join = |cells: &mut Cells, [one, other]: [usize; 2], reversed: bool| {
            cells.take(one, &open[one]);
            cells.take(other, &open[other]);
            joined.insert(open[other].edge, (open[one].edge, reversed));
        };
        // Equal edges first, without a comparison of all with all where many are equal.
        for number in 0..open.len() {
            let equal = cells.near(number, &open[number]).find_map(|other| {
                let same = self.compare(&open[number], &open[other], EQUAL * tolerance)?;
                Some((other, same.reversed))
            });
            if let Some((other, reversed)) = equal {
                join(&mut cells, [number, other], reversed);
            }
        }
        // Of the others, those that are nearest to each other.
        let mut pairs: Vec<([usize; 2], Same)> = Vec::new();
        for number in 0..open.len() {
            let near = cells.near(number, &open[number]);
            let others =
                near.filter(|other| *other > number && open[*other].face != open[number].face);
            pairs.extend(others.filter_map(|other| {
                Some(([number, other], self.compare(&open[number], &open[other], tolerance)?))
            }));
        }
        pairs.sort_by(|a, b| a.1.apart.total_cmp(&b.1.apart));
        for (pair, same) in pairs {
            if pair.iter().all(|number| !cells.is_taken[*number]) {
                join(&mut cells, pair, same.reversed);
            }
        }
        self.replace(&joined);
        joined.len()
    }

    fn open_edges(&self, tolerance: f64) -> Vec<OpenEdge> {
        let uses = self.edge_uses();
        let mut open = Vec::new();
        for (product, of) in self.products.iter().enumerate() {
            let [first, count] = of.faces;
            let faces = self.faces.get(first..first + count).unwrap_or_default();
            let coedges = faces.iter().enumerate().flat_map(|(face, of)| {
                of.loops.iter().flatten().map(move |coedge| (first + face, coedge))
            });
            for (face, coedge) in coedges {
                let Some(curve) = &self.edges[coedge.edge].curve else { continue };
                let ends = curve.range.map(|t| curve.curve.at(t)[0]);
                let middle = curve.curve.at(0.5 * (curve.range[0] + curve.range[1]))[0];
                let is_long = ends.iter().any(|end| end.distance(middle) > tolerance);
                if uses[coedge.edge].len() == 1 && is_long {
                    open.push(OpenEdge { edge: coedge.edge, face, product, ends });
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
        (apart <= tolerance).then_some(Same { reversed, apart })
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
    let (t, _) = nearest_on(curve, place, start.unwrap_or(low));
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
        let frame = Frame::WORLD;
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
        let frame = Frame::WORLD;
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
    fn the_sides_of_a_narrow_face_stay_apart_and_a_seam_is_joined() {
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let rectangle = |width: f64| {
            vec![
                (line(at(0.0, 0.0), at(9.0, 0.0)), true),
                (line(at(9.0, 0.0), at(9.0, width)), true),
                (line(at(0.0, width), at(9.0, width)), false),
                (line(at(0.0, 0.0), at(0.0, width)), false),
            ]
        };
        let mut model = empty();
        add_face(&mut model, rectangle(5e-5));
        assert_eq!(model.sew(1e-4), 0);
        // On a closed surface both long sides would be one seam.
        let mut model = empty();
        let sides = rectangle(5e-5);
        add_face(&mut model, vec![sides[0].clone(), (sides[0].0.clone(), false)]);
        assert_eq!(model.sew(1e-4), 1);
    }

    #[test]
    fn the_nearest_pairs_are_joined_whatever_the_order() {
        let lines = |offsets: [f64; 3]| {
            let mut model = empty();
            for offset in offsets {
                let up = DVec3::new(0.0, offset, 0.0);
                add_face(&mut model, vec![(line(up, up + DVec3::X), true)]);
            }
            model.sew(1e-4);
            model.faces.iter().map(|face| face.loops[0][0].edge).collect::<Vec<_>>()
        };
        assert_eq!(lines([0.0, 6e-5, 6e-5]), [0, 1, 1]);
        assert_eq!(lines([0.0, 6e-5, 7e-5]), [0, 1, 1]);
        assert_eq!(lines([6e-5, 0.0, 6e-5]), [0, 1, 0]);
    }

    #[test]
    fn thousands_of_equal_edges_are_joined_in_pairs() {
        let mut model = empty();
        for _ in 0..20_000 {
            add_face(&mut model, vec![(circle(0.0), true)]);
        }
        assert_eq!(model.sew(1e-6), 10_000);
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
