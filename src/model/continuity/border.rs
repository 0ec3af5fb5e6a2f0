//! An edge on the surface of one of its faces.

use glam::{DVec2, DVec3};

use crate::model::projection::{Trace, between, breaks, parts};
use crate::model::sheet::{Sheet, solve};
use crate::model::{Curve, FaceSurface, Model};

/// The use of an edge by a face, followed on its surface.
pub(super) struct Follow {
    pub(super) edge: usize,
    pub(super) face: usize,
    /// Whether the loop follows the edge's curve from its start to its end.
    pub(super) forward: bool,
    /// Places along the edge's curve with the nearest (u, v).
    samples: Vec<(f64, DVec2)>,
}

/// The border of a face along an edge.
pub(super) struct Border<'a> {
    /// For points near the surface.
    pub(super) sheet: Sheet<'a>,
    pub(super) follow: &'a Follow,
}

/// The border at one place of the edge.
pub(super) struct Place {
    pub(super) position: DVec3,
    /// The outward normal, if the surface has one there.
    pub(super) normal: Option<DVec3>,
    /// The normal curvature across the edge; above 0 where the surface bends to the side of the normal.
    pub(super) curvature: Option<f64>,
}

impl Follow {
    /// All edges of a face that are more than a point.
    pub(super) fn all(model: &Model, face: usize, sheet: &Sheet<'_>) -> Vec<Self> {
        let follow = |coedge: &crate::model::Coedge| {
            let curve = model.edges[coedge.edge].curve.as_ref()?;
            let pcurve = coedge.pcurve.as_ref();
            let mut near = pcurve.map(|pcurve| pcurve.at(pcurve.domain()[0])[0]);
            let mut samples = Vec::new();
            for part in parts(sheet, curve) {
                samples.extend(Trace::of_edge(sheet, curve, part, true, near).samples);
                near = samples.last().map(|(_, uv): &(f64, DVec2)| *uv);
            }
            Some(Self { edge: coedge.edge, face, forward: coedge.forward, samples })
        };
        model.faces[face].loops.iter().flatten().filter_map(follow).collect()
    }
}

impl Border<'_> {
    /// The border at t, where the edge's curve has a point and a derivative. `is_turned`: the outside is opposite to
    /// ∂u × ∂v.
    pub(super) fn at(&self, [point, slope]: [DVec3; 2], t: f64, is_turned: bool) -> Place {
        let uv = self.sheet.nearest(point, Some(between(&self.follow.samples, t)));
        let (along, _) = solve(&self.sheet.at(uv), slope, 0.0);
        // The face lies to the left of its loops.
        let inwards = if self.follow.forward { along.perp() } else { -along.perp() };
        let curved = self.sheet.beside(uv, inwards);
        let at = curved.at;
        let cross = at.du.cross(at.dv);
        let is_regular = !self.sheet.singular(&at).contains(&true)
            && cross.length() > 1e-9 * at.du.length() * at.dv.length();
        let side = if is_turned { -1.0 } else { 1.0 };
        let normal = is_regular.then(|| side * cross.normalize());
        let curvature = normal.zip(slope.try_normalize()).map(|(normal, slope)| {
            let across = solve(&at, normal.cross(slope), 0.0).0;
            let length = (at.du * across.x + at.dv * across.y).length_squared();
            let bend = curved.duu * across.x * across.x
                + curved.duv * 2.0 * across.x * across.y
                + curved.dvv * across.y * across.y;
            bend.dot(normal) / length
        });
        Place { position: at.position, normal, curvature }
    }

    /// About where the edge crosses knots of the surface.
    pub(super) fn crossings(&self) -> Vec<f64> {
        let mut found = Vec::new();
        for axis in 0..2 {
            let knots = knots(self.sheet.surface, axis);
            for pair in self.follow.samples.windows(2) {
                let [(from, a), (to, b)] = [pair[0], pair[1]].map(|(t, uv)| (t, uv[axis]));
                let inside = knots.iter().filter(|knot| a.min(b) < **knot && **knot < a.max(b));
                found.extend(inside.map(|knot| from + (to - from) * (knot - a) / (b - a)));
            }
        }
        found
    }
}

/// The knots of a surface along u (axis 0) or v (axis 1), each once.
fn knots(surface: &FaceSurface, axis: usize) -> Vec<f64> {
    match (surface, axis) {
        (FaceSurface::Nurbs(nurbs), _) => {
            let degree = [nurbs.degree().u(), nurbs.degree().v()][axis];
            breaks(&nurbs.knots()[axis], degree, degree)
        }
        (FaceSurface::Revolution { curve, .. }, 1) | (FaceSurface::Extrusion { curve, .. }, 0) => {
            match &curve.curve {
                Curve::Nurbs(curve) => breaks(curve.knots(), curve.degree(), curve.degree()),
                _ => Vec::new(),
            }
        }
        _ => Vec::new(),
    }
}
