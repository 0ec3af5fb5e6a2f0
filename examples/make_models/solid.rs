//! Builds solids face by face. Faces that meet along an edge share it.

use std::collections::HashMap;
use std::f64::consts::TAU;

use freeform_surface::glam::{DVec2, DVec3};
use freeform_surface::model::{
    BoundedCurve, Coedge, Curve, Edge, Face, FaceSurface, Frame, Model, Product,
};

/// The tolerance of all edges and faces.
pub(crate) const TOLERANCE: f64 = 1e-7;

/// A model that grows.
pub(crate) struct Builder {
    pub(crate) model: Model,
    /// The edges of the current product between two points.
    between: HashMap<[[u64; 3]; 2], usize>,
    first_face: usize,
}

/// A full circle.
#[derive(Clone, Copy)]
pub(crate) struct Circle {
    pub(crate) edge: usize,
    radius: f64,
    /// Along the axis.
    height: f64,
}

/// The surface between two circles about an axis.
pub(crate) struct Ring {
    /// Whether the outside of the solid is away from the axis.
    pub(crate) is_outer: bool,
    /// Whether an edge connects the two circles. Otherwise each of them is a loop.
    pub(crate) has_seam: bool,
}

impl Builder {
    pub(crate) fn new(name: &str) -> Self {
        let model = Model {
            name: name.into(),
            unit: 0.001,
            edges: Vec::new(),
            faces: Vec::new(),
            products: Vec::new(),
        };
        Self { model, between: HashMap::new(), first_face: 0 }
    }

    /// Makes a product of the faces since the last one. Returns its number.
    pub(crate) fn product(&mut self, name: &str, color: Option<[f32; 3]>) -> usize {
        let faces = [self.first_face, self.model.faces.len() - self.first_face];
        let product = Product { name: name.into(), color, faces, uses: Vec::new() };
        self.model.products.push(product);
        self.between.clear();
        self.first_face = self.model.faces.len();
        self.model.products.len() - 1
    }

    /// Adds an edge and returns its number.
    pub(crate) fn edge(&mut self, curve: Curve, range: [f64; 2]) -> usize {
        let curve = Some(BoundedCurve { curve, range });
        self.model.edges.push(Edge { tolerance: TOLERANCE, curve });
        self.model.edges.len() - 1
    }

    pub(crate) fn line(&mut self, from: DVec3, to: DVec3) -> usize {
        let direction = clean((to - from).normalize());
        self.edge(Curve::Line { origin: from, direction }, [0.0, from.distance(to)])
    }

    /// An arc of less than half a turn, which loops through its ends will use.
    pub(crate) fn arc(&mut self, center: DVec3, from: DVec3, to: DVec3) {
        let radius = from.distance(center);
        let x = clean((from - center) / radius);
        let z = clean(x.cross(to - center).normalize());
        let y = clean(z.cross(x));
        let angle = (to - center).dot(y).atan2((to - center).dot(x));
        let frame = Frame { origin: center, x, y, z };
        let edge = self.edge(Curve::Circle { frame, radius }, [0.0, angle]);
        self.between.insert([key(from), key(to)], edge);
    }

    /// A circle about the axis of a frame, through a point above its x axis.
    pub(crate) fn circle(&mut self, axis: &Frame, radius: f64, height: f64) -> Circle {
        let frame = Frame { origin: axis.origin + height * axis.z, ..*axis };
        let edge = self.edge(Curve::Circle { frame, radius }, [0.0, TAU]);
        Circle { edge, radius, height }
    }

    /// The closed chain of edges through points. Where two points have no edge yet, it is a line.
    pub(crate) fn chain(&mut self, points: &[DVec3]) -> Vec<Coedge> {
        (0..points.len())
            .map(|i| {
                let [from, to] = [points[i], points[(i + 1) % points.len()]];
                if let Some(edge) = self.between.get(&[key(from), key(to)]) {
                    return coedge(*edge, true);
                }
                if let Some(edge) = self.between.get(&[key(to), key(from)]) {
                    return coedge(*edge, false);
                }
                let edge = self.line(from, to);
                self.between.insert([key(from), key(to)], edge);
                coedge(edge, true)
            })
            .collect()
    }

    pub(crate) fn face(
        &mut self,
        surface: FaceSurface,
        reversed: bool,
        bounds: [DVec2; 2],
        loops: Vec<Vec<Coedge>>,
    ) {
        self.model.faces.push(Face {
            name: String::new(),
            tolerance: TOLERANCE,
            color: None,
            reversed,
            surface,
            bounds,
            loops,
        });
    }

    /// Names the last face.
    pub(crate) fn name(&mut self, name: &str) {
        if let Some(face) = self.model.faces.last_mut() {
            face.name = name.into();
        }
    }

    /// A plane face with a polygon, given in either direction, as its outer loop. `normal` points out of the solid.
    pub(crate) fn polygon(&mut self, normal: DVec3, points: &[DVec3], holes: &[Circle]) {
        let frame = plane(points[0], normal);
        let flat: Vec<DVec2> = points.iter().map(|point| within(&frame, *point)).collect();
        let crosses = (0..flat.len()).map(|i| flat[i].perp_dot(flat[(i + 1) % flat.len()]));
        let mut points = points.to_vec();
        if crosses.sum::<f64>() < 0.0 {
            points.reverse();
        }
        let min = flat.iter().copied().reduce(DVec2::min).unwrap_or_default();
        let max = flat.iter().copied().reduce(DVec2::max).unwrap_or_default();
        let outer = self.chain(&points);
        let inner =
            holes.iter().map(|hole| vec![coedge(hole.edge, self.axis(*hole).dot(normal) < 0.0)]);
        let loops = std::iter::once(outer).chain(inner).collect();
        self.face(FaceSurface::Plane(frame), false, [min, max].map(|end| end + DVec2::ZERO), loops);
    }

    /// A plane face within a circle. `normal` points out of the solid.
    pub(crate) fn disc(&mut self, normal: DVec3, outer: Circle, holes: &[Circle]) {
        let is_along = |circle: Circle| self.axis(circle).dot(normal) > 0.0;
        let mut loops = vec![vec![coedge(outer.edge, is_along(outer))]];
        loops.extend(holes.iter().map(|hole| vec![coedge(hole.edge, !is_along(*hole))]));
        let frame = plane(self.frame(outer).origin, normal);
        let bounds = [DVec2::splat(-outer.radius), DVec2::splat(outer.radius)];
        self.face(FaceSurface::Plane(frame), false, bounds, loops);
    }

    /// The part of a cylinder or cone between two circles about an axis, the first of which is the lower one.
    pub(crate) fn ring(&mut self, axis: &Frame, [low, high]: [Circle; 2], ring: &Ring) {
        let frame = self.frame(low);
        let rise = high.height - low.height;
        let (surface, length) = if low.radius == high.radius {
            (FaceSurface::Cylinder { frame, radius: low.radius }, rise)
        } else {
            let half_angle = (high.radius - low.radius).atan2(rise);
            let length = rise.hypot(high.radius - low.radius);
            (FaceSurface::Cone { frame, radius: low.radius, half_angle }, length)
        };
        let loops = if ring.has_seam {
            let end =
                |circle: Circle| axis.origin + circle.height * axis.z + circle.radius * axis.x;
            let seam = self.line(end(low), end(high));
            let edges = [(low.edge, true), (seam, true), (high.edge, false), (seam, false)];
            vec![edges.map(|(edge, forward)| coedge(edge, forward)).into()]
        } else {
            vec![vec![coedge(low.edge, true)], vec![coedge(high.edge, false)]]
        };
        let bounds = [DVec2::ZERO, DVec2::new(TAU, length)];
        self.face(surface, !ring.is_outer, bounds, loops);
    }

    fn frame(&self, circle: Circle) -> Frame {
        match self.model.edges[circle.edge].curve {
            Some(BoundedCurve { curve: Curve::Circle { frame, .. }, .. }) => frame,
            _ => unreachable!("the edge of a circle is a circle"),
        }
    }

    fn axis(&self, circle: Circle) -> DVec3 {
        self.frame(circle).z
    }
}

pub(crate) fn coedge(edge: usize, forward: bool) -> Coedge {
    Coedge { edge, forward, pcurve: None }
}

/// An axis along z through a point.
pub(crate) fn upright(origin: DVec3) -> Frame {
    Frame { origin, ..Frame::WORLD }
}

/// A right-handed frame whose z axis is a normal.
pub(crate) fn plane(origin: DVec3, normal: DVec3) -> Frame {
    let near = if normal.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
    let x = clean(near.reject_from_normalized(normal).normalize());
    Frame { origin, x, y: clean(normal.cross(x)), z: clean(normal) }
}

/// The parameters of a point of a plane.
pub(crate) fn within(plane: &Frame, point: DVec3) -> DVec2 {
    let offset = point - plane.origin;
    DVec2::new(offset.dot(plane.x), offset.dot(plane.y))
}

/// Turns −0 into 0.
fn clean(vector: DVec3) -> DVec3 {
    vector + DVec3::ZERO
}

/// The bits of a point, in which −0 is 0.
fn key(point: DVec3) -> [u64; 3] {
    clean(point).to_array().map(f64::to_bits)
}
