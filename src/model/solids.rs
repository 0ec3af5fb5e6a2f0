//! Which faces enclose a solid, and on which side of them its outside is: found from the edges that they share, whatever
//! the file says.

use glam::DVec3;

use super::{DrawnEdge, DrawnFace, Face, FaceSurface, Joint, JointKind, Model};
use crate::bezier::bounding_box;
use crate::error::Result;
use crate::parallel;

/// The solid that a face encloses together with others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outside {
    /// The number of the solid in the model. Faces around a hollow of a solid are a solid of their own.
    pub solid: usize,
    /// 1 if ∂u × ∂v of the face's surface points out of it, −1 if it points into it.
    pub sign: f64,
}

/// The least share of the sum over all faces, without signs, that the integral for a volume must have. Below, its sign
/// could be an error of the integration.
const CERTAIN: f64 = 0.1;

impl Model {
    /// The solids that the drawn faces enclose: for each face, its outside; `None` where some face is missing, has an
    /// edge that not exactly two faces share, or has only one side. `faces` are [`Model::drawn_faces`], and `joints`
    /// [`Model::joints`].
    #[must_use]
    pub fn outsides(&self, faces: &[Result<DrawnFace>], joints: &[Joint]) -> Vec<Option<Outside>> {
        let mut shells = Shells::new(self, faces, joints);
        let closed: Vec<Shell> =
            (0..faces.len()).filter_map(|first| shells.closed_from(first)).collect();
        let drawn = |face: usize| faces[face].as_ref().ok();
        let middles: Vec<DVec3> = closed.iter().map(|shell| middle(shell, faces)).collect();
        let parts: Vec<(usize, usize, f64)> = closed
            .iter()
            .enumerate()
            .flat_map(|(solid, shell)| shell.iter().map(move |(face, sign)| (solid, *face, *sign)))
            .collect();
        let fluxes = parallel::map(parts.len(), |number| {
            let (solid, face, sign) = parts[number];
            drawn(face).map_or(f64::NAN, |face| sign * face.flux(middles[solid]))
        });
        let mut sums = vec![(0.0, 0.0); closed.len()];
        for ((solid, ..), flux) in parts.iter().zip(fluxes) {
            sums[*solid].0 += flux;
            sums[*solid].1 += flux.abs();
        }
        let mut outsides = vec![None; faces.len()];
        for (solid, face, sign) in parts {
            let (volume, all): (f64, f64) = sums[solid];
            if volume.abs() > CERTAIN * all {
                outsides[face] = Some(Outside { solid, sign: sign * volume.signum() });
            }
        }
        outsides
    }
}

/// Faces that are connected by edges, each with 1 or −1: with the same side out as the first one's ∂u × ∂v.
type Shell = Vec<(usize, f64)>;

/// Finds the faces that are connected.
struct Shells {
    /// For each face, the others that it shares an edge with, and −1 where ∂u × ∂v points to the other side.
    neighbours: Vec<Vec<(usize, f64)>>,
    /// Whether a face ends at one of its edges, or is not drawn.
    ends: Vec<bool>,
    /// The signs of the faces that were visited.
    signs: Vec<Option<f64>>,
}

impl Shells {
    fn new(model: &Model, faces: &[Result<DrawnFace>], joints: &[Joint]) -> Self {
        let mut uses = vec![0_u32; model.edges.len()];
        for edge in faces.iter().flatten().flat_map(|face| &face.edges) {
            uses[edge.edge] += 1;
        }
        let mut neighbours = vec![Vec::new(); faces.len()];
        let mut is_shared = vec![false; model.edges.len()];
        for Joint { edge, kind, faces: [one, other], sides, .. } in joints {
            if *kind != JointKind::Open && uses[*edge] == 2 {
                is_shared[*edge] = true;
                let turned = -sides[0] * sides[1];
                neighbours[*one].push((*other, turned));
                neighbours[*other].push((*one, turned));
            }
        }
        let is_end = |(face, drawn): (&Face, &Result<DrawnFace>)| match drawn {
            Ok(drawn) => {
                // A face goes on around a pole, which has no curve.
                let ends = |edge: &DrawnEdge| {
                    !is_shared[edge.edge] && model.edges[edge.edge].curve.is_some()
                };
                drawn.edges.iter().any(ends) || has_bare_border(face, Some(drawn))
            }
            Err(_) => true,
        };
        let ends = model.faces.iter().zip(faces).map(is_end).collect();
        Self { neighbours, ends, signs: vec![None; faces.len()] }
    }

    /// The faces connected with one that was not visited yet, if they are closed and have two sides.
    fn closed_from(&mut self, first: usize) -> Option<Shell> {
        if self.signs[first].is_some() {
            return None;
        }
        self.signs[first] = Some(1.0);
        let mut shell = vec![(first, 1.0)];
        let mut is_closed = true;
        let mut next = 0;
        while let Some((face, sign)) = shell.get(next).copied() {
            next += 1;
            is_closed &= !self.ends[face];
            for (other, turned) in &self.neighbours[face] {
                let expected = sign * turned;
                match self.signs[*other] {
                    Some(known) => is_closed &= known == expected,
                    None => {
                        self.signs[*other] = Some(expected);
                        shell.push((*other, expected));
                    }
                }
            }
        }
        is_closed.then_some(shell)
    }
}

/// The middle of the box around the control points of a shell's faces.
fn middle(shell: &Shell, faces: &[Result<DrawnFace>]) -> DVec3 {
    let drawn = shell.iter().filter_map(|(face, _)| faces[*face].as_ref().ok());
    let points = drawn.flat_map(|face| face.surface.control_points());
    let [low, high] = bounding_box(points.map(|point| point.truncate()));
    low.midpoint(high)
}

/// Whether a face ends where it has no edge: it has no loops, and its surface is not closed.
pub(crate) fn has_bare_border(face: &Face, drawn: Option<&DrawnFace>) -> bool {
    let is_closed = matches!(face.surface, FaceSurface::Sphere { .. } | FaceSurface::Torus { .. })
        || drawn.is_some_and(|drawn| drawn.periods.iter().all(Option::is_some));
    face.loops.is_empty() && !is_closed
}
