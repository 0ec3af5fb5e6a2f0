//! The closed products of the CAD models in a scene, and the edges that their faces share, in space and on the screen.

use std::collections::{HashMap, HashSet};

use glam::{DMat3, DMat4, DVec2, DVec3};

use super::screen::Screen;
use crate::model::{Deviation, Model, has_bare_border};
use crate::parallel;
use crate::scene::{FaceOfModel, Scene};

/// Pieces of an edge, which are cut further where the picture needs it.
const PIECES: usize = 32;
/// The largest distance of a segment from its edge, in pixels.
const FLAT_PX: f64 = 0.02;
/// The longest segment of a curve that is not a line, in pixels.
const LONG_PX: f64 = 100.0;
/// How often a piece is halved at most.
const MAX_HALVINGS: u32 = 40;

/// An edge that faces share, in a place of its product.
pub(super) struct SharedEdge<'a> {
    /// The number of the model in the scene.
    pub(super) model: usize,
    /// The number of the edge in the model.
    pub(super) edge: usize,
    /// An upper bound of the distance between the borders of its faces, in world space.
    gap: f64,
    of: &'a Model,
    transform: DMat4,
}

/// A segment of an edge on the screen.
pub(super) struct Segment {
    /// The number of the edge in [`Solids::edges`].
    pub(super) edge: usize,
    ends: [DVec2; 2],
    depths: [f64; 2],
    /// The distance between the borders of its faces, in pixels.
    pub(super) gap_px: f64,
}

impl Segment {
    /// The distance of a place in pixels, and the depth at the nearest point.
    pub(super) fn nearest(&self, place: DVec2) -> (f64, f64) {
        let [start, end] = self.ends;
        let along = end - start;
        let share = ((place - start).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let share = if share.is_nan() { 0.0 } else { share };
        let depth = self.depths[0] + share * (self.depths[1] - self.depths[0]);
        ((start + share * along).distance(place), depth)
    }
}

/// What the models of a scene enclose.
pub(super) struct Solids<'a> {
    /// For each surface of the scene, whether it is a face of a closed product.
    pub(super) is_closed: Vec<bool>,
    /// How many edges are used an odd number of times, and how many faces end without an edge.
    pub(super) open_edges: usize,
    /// Edges with at least two uses.
    pub(super) edges: Vec<SharedEdge<'a>>,
}

impl<'a> Solids<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        let mut solids =
            Self { is_closed: vec![false; scene.surfaces.len()], open_edges: 0, edges: Vec::new() };
        for (number, model) in scene.models.iter().enumerate() {
            let of_model = |face: FaceOfModel| (face.model == number).then_some(face.face);
            let faces: Vec<(usize, usize)> = scene
                .surfaces
                .iter()
                .enumerate()
                .filter_map(|(surface, own)| Some((surface, own.face.and_then(of_model)?)))
                .collect();
            solids.add(scene, number, &model.model, &faces);
        }
        solids
    }

    /// Adds a model. `faces` are the numbers of surfaces and of the faces that they are.
    fn add(&mut self, scene: &Scene, number: usize, model: &'a Model, faces: &[(usize, usize)]) {
        // A face that is hidden in one place counts as missing in all.
        let mut shown: HashSet<usize> = faces.iter().map(|(_, face)| *face).collect();
        for (_, face) in faces.iter().filter(|(surface, _)| scene.surfaces[*surface].hidden) {
            shown.remove(face);
        }
        let drawn = model.drawn_faces();
        let diagonal = model.diagonal();
        let drawn = |face: usize| drawn.get(face)?.as_ref().ok();
        // Two borders at an edge are no further apart than both are from its curve.
        let mut gaps: HashMap<usize, f64> = HashMap::new();
        let deviations = parallel::map(model.faces.len(), |face| {
            let drawn = drawn(face).filter(|_| shown.contains(&face))?;
            Some(model.deviations(face, drawn, diagonal))
        });
        for Deviation { edge, drawn, .. } in deviations.into_iter().flatten().flatten() {
            *gaps.entry(edge).or_default() += drawn;
        }

        let mut shared = HashSet::new();
        let mut closed_faces = HashSet::new();
        for product in &model.products {
            let [first, count] = product.faces;
            let own = || (first..first + count).filter(|face| shown.contains(face));
            let mut uses: HashMap<usize, usize> = HashMap::new();
            for coedge in own().flat_map(|face| model.faces[face].loops.iter().flatten()) {
                if model.edges[coedge.edge].curve.is_some() {
                    *uses.entry(coedge.edge).or_default() += 1;
                }
            }
            let ends = own().filter(|face| has_bare_border(&model.faces[*face], drawn(*face)));
            let open = uses.values().filter(|uses| *uses % 2 == 1).count() + ends.count();
            self.open_edges += open;
            if open == 0 {
                closed_faces.extend(own());
            }
            shared.extend(uses.into_iter().filter(|(_, uses)| *uses > 1).map(|(edge, _)| edge));
        }

        let mut placed = HashSet::new();
        for (surface, face) in faces.iter().copied().filter(|(_, face)| shown.contains(face)) {
            self.is_closed[surface] = closed_faces.contains(&face);
            let transform = scene.surfaces[surface].transform;
            let bits = transform.to_cols_array().map(f64::to_bits);
            for coedge in model.faces[face].loops.iter().flatten() {
                let edge = coedge.edge;
                if shared.contains(&edge) && placed.insert((edge, bits)) {
                    let gap = gaps.get(&edge).copied().unwrap_or(0.0) * stretch(&transform);
                    self.edges.push(SharedEdge { model: number, edge, gap, of: model, transform });
                }
            }
        }
    }

    /// The segments of all edges that may be in a picture or within `margin` pixels of it.
    pub(super) fn segments(&self, screen: &Screen, margin: f64) -> Vec<Segment> {
        let of = |number: usize| {
            let edge = &self.edges[number];
            let mut segments = Vec::new();
            if let Some([low, high]) = edge.range() {
                let t = |i: usize| low + (high - low) * i as f64 / PIECES as f64;
                let ends: Vec<_> = (0..=PIECES).map(|i| (t(i), edge.at(t(i)))).collect();
                let mut cut = Cut { edge, number, screen, margin, segments: &mut segments };
                ends.windows(2).for_each(|pair| cut.piece([pair[0], pair[1]], 0));
            }
            segments
        };
        parallel::map(self.edges.len(), of).into_iter().flatten().collect()
    }
}

/// An upper bound of the factor by which a transform changes lengths.
fn stretch(transform: &DMat4) -> f64 {
    let DMat3 { x_axis, y_axis, z_axis } = DMat3::from_mat4(*transform);
    let squares = [x_axis, y_axis, z_axis].map(DVec3::length_squared);
    let is_similar = squares.iter().all(|square| (square - squares[0]).abs() < 1e-9 * squares[0]);
    let bound: f64 = if is_similar { squares[0] } else { squares.iter().sum() };
    bound.sqrt()
}

impl SharedEdge<'_> {
    /// The first and the last parameter of its curve.
    pub(super) fn range(&self) -> Option<[f64; 2]> {
        Some(self.of.edges[self.edge].curve.as_ref()?.range)
    }

    /// Its point at a parameter, in world space.
    pub(super) fn at(&self, t: f64) -> DVec3 {
        let curve = self.of.edges[self.edge].curve.as_ref();
        let point = curve.map_or(DVec3::NAN, |curve| curve.curve.at(t)[0]);
        self.transform.transform_point3(point)
    }
}

/// Cuts an edge into segments.
struct Cut<'a> {
    edge: &'a SharedEdge<'a>,
    number: usize,
    screen: &'a Screen,
    margin: f64,
    segments: &'a mut Vec<Segment>,
}

impl Cut<'_> {
    /// A piece between two parameters with their points.
    fn piece(&mut self, [start, end]: [(f64, DVec3); 2], halvings: u32) {
        let t = f64::midpoint(start.0, end.0);
        let middle = (t, self.edge.at(t));
        let radius = middle.1.distance(start.1).max(middle.1.distance(end.1));
        // A piece of a curve may leave the ball that its ends and its middle span, but not by half.
        if !self.screen.may_show(middle.1, 1.5 * radius, self.margin) {
            return;
        }
        let place = |(_, point): (f64, DVec3)| self.screen.place(point);
        if let [Some(a), Some(m), Some(b)] = [place(start), place(middle), place(end)] {
            let gap_px = self.edge.gap / self.screen.pixel_at(middle.1);
            let (ends, depths) = ([a.0, b.0], [a.1, b.1]);
            let segment = Segment { edge: self.number, ends, depths, gap_px };
            let is_flat = segment.nearest(m.0).0 < FLAT_PX && a.0.distance(b.0) < LONG_PX;
            if is_flat || halvings == MAX_HALVINGS {
                self.segments.push(segment);
                return;
            }
        }
        if halvings < MAX_HALVINGS {
            self.piece([start, middle], halvings + 1);
            self.piece([middle, end], halvings + 1);
        }
    }
}
