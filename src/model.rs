//! CAD models as plain data in `f64`: faces with their exact surfaces and boundaries, edges that faces share, and
//! products that are used in several places. Lengths are in the model's unit, angles in radians.

mod area;
mod boundary;
mod certificate;
mod chain;
mod chart;
mod check;
mod continuity;
mod curve;
mod derivatives;
mod deviation;
mod drawn;
mod evaluate;
mod fit;
mod import;
mod instances;
mod joints;
mod projection;
mod read;
mod sew;
mod sheet;
mod solids;
mod write;

use glam::{DAffine3, DVec2, DVec3};

use crate::bezier::NurbsSurface;
pub use certificate::CertifiedDeviation;
pub use continuity::{
    Continuity, EdgeContinuity, EdgeUse, GAP, RELATIVE_JUMP, SMOOTH_DEGREES, Worst,
};
pub use curve::{BoundedCurve, Curve, NurbsCurve};
pub use deviation::Deviation;
pub use drawn::{ClosedGap, DrawnEdge, DrawnFace, PcurveSource, Repairs};
pub(crate) use import::ENDED;
pub use import::{ImportOptions, find_helper, import, is_cad_file};
pub use instances::Instance;
pub use joints::{Beside, Joint, JointKind, JointPiece, JointRange};
pub(crate) use joints::{Border, JointCurve, JointSurface};
pub use solids::Outside;
pub(crate) use solids::has_bare_border;

/// A CAD model. Edges, faces and products are numbered from 0 in their order; they refer to each other by number.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// The name in the file; may be empty.
    pub name: String,
    /// The length of one unit in metres.
    pub unit: f64,
    /// Edges; faces that meet along an edge share it.
    pub edges: Vec<Edge>,
    /// The faces of all products.
    pub faces: Vec<Face>,
    /// Products, each after those that it uses. The last one is the whole model.
    pub products: Vec<Product>,
}

/// An edge: a bounded curve along which faces end.
#[derive(Debug, Clone, PartialEq)]
pub struct Edge {
    /// The largest distance to the surfaces of its faces, as the file states it.
    pub tolerance: f64,
    /// The curve in space. `None` for an edge that is one point, such as the pole of a sphere.
    pub curve: Option<BoundedCurve>,
}

/// A face: the part of a surface that its loops bound.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// The name in the file; may be empty.
    pub name: String,
    /// The tolerance that the file states.
    pub tolerance: f64,
    /// The face's own colour or that of its solid: sRGB components from 0 to 1, as in scenes.
    pub color: Option<[f32; 3]>,
    /// Whether the outside of the solid is opposite to ∂u × ∂v of the surface.
    pub reversed: bool,
    /// The surface.
    pub surface: FaceSurface,
    /// The smallest and the largest parameters (u, v) of the face, as far as the file knows them. The parameters of a
    /// face on a closed surface may begin anywhere, but span at most one period.
    pub bounds: [DVec2; 2],
    /// The loops, each a closed chain of edges. The face lies to the left of a loop if one looks against ∂u × ∂v,
    /// whether it is reversed or not. Without loops, the face is all of the surface within its bounds.
    pub loops: Vec<Vec<Coedge>>,
}

/// The use of an edge in a loop of a face.
#[derive(Debug, Clone, PartialEq)]
pub struct Coedge {
    /// The number of the edge.
    pub edge: usize,
    /// Whether the loop follows the edge's curve from its start to its end.
    pub forward: bool,
    /// The edge in the parameters (u, v) of the face's surface, from the start of the edge's curve to its end, if the
    /// file has it: control points (u, v, weight).
    pub pcurve: Option<NurbsCurve<DVec3>>,
}

/// A right- or left-handed coordinate system: x, y and z are perpendicular and have unit length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// Its origin.
    pub origin: DVec3,
    /// Its x axis.
    pub x: DVec3,
    /// Its y axis.
    pub y: DVec3,
    /// Its z axis.
    pub z: DVec3,
}

impl Frame {
    /// Axes and origin of the space itself.
    pub const WORLD: Self = Self { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
}

/// The surface of a face with its parameters (u, v). x, y, z and the origin o are those of the frame.
#[derive(Debug, Clone, PartialEq)]
pub enum FaceSurface {
    /// o + u x + v y.
    Plane(Frame),
    /// o + r (cos u x + sin u y) + v z.
    Cylinder {
        /// Its z is the axis.
        frame: Frame,
        /// r, above 0.
        radius: f64,
    },
    /// o + (r + v sin a) (cos u x + sin u y) + v cos a z.
    Cone {
        /// Its z is the axis.
        frame: Frame,
        /// r at v = 0, at least 0.
        radius: f64,
        /// a, between −π/2 and π/2, not 0.
        half_angle: f64,
    },
    /// o + r (cos v (cos u x + sin u y) + sin v z), v from −π/2 to π/2.
    Sphere {
        /// Its origin is the centre.
        frame: Frame,
        /// r, above 0.
        radius: f64,
    },
    /// o + (R + r cos v) (cos u x + sin u y) + r sin v z.
    Torus {
        /// Its z is the axis.
        frame: Frame,
        /// R: the distance of the tube's middle from the axis, at least 0. It may be less than r.
        major_radius: f64,
        /// r: the tube's radius, above 0.
        minor_radius: f64,
    },
    /// The curve's point at v, turned by u about an axis.
    Revolution {
        /// A point of the axis.
        origin: DVec3,
        /// The direction of the axis, of unit length.
        axis: DVec3,
        /// The curve that is turned.
        curve: BoundedCurve,
    },
    /// The curve's point at u + v times the direction.
    Extrusion {
        /// The direction, of unit length.
        direction: DVec3,
        /// The curve that is moved.
        curve: BoundedCurve,
    },
    /// A B-spline or Bézier surface.
    Nurbs(NurbsSurface),
}

/// A part or an assembly.
#[derive(Debug, Clone, PartialEq)]
pub struct Product {
    /// The name in the file; may be empty.
    pub name: String,
    /// The colour of faces without one of their own: sRGB components from 0 to 1, as in scenes.
    pub color: Option<[f32; 3]>,
    /// The numbers of its own faces: the first, and how many.
    pub faces: [usize; 2],
    /// The products that it consists of.
    pub uses: Vec<ProductUse>,
}

/// A product in a place.
#[derive(Debug, Clone, PartialEq)]
pub struct ProductUse {
    /// The number of the product, which is less than that of the product that uses it.
    pub product: usize,
    /// From the used product's space to that of the using one. May mirror and scale.
    pub placement: DAffine3,
    /// The colour here, which goes before the product's own.
    pub color: Option<[f32; 3]>,
}

#[cfg(test)]
mod tests;

impl Model {
    /// The short name of the unit of length, such as mm; that of an unusual unit is its length in metres, in parentheses.
    #[must_use]
    pub fn unit_name(&self) -> String {
        const NAMES: [(f64, &str); 6] =
            [(1e-6, "µm"), (1e-3, "mm"), (1e-2, "cm"), (1.0, "m"), (0.0254, "in"), (0.3048, "ft")];
        let is_it = |metres: f64| (self.unit - metres).abs() < 1e-9 * metres;
        let found = NAMES.iter().find(|(metres, _)| is_it(*metres));
        found.map_or_else(|| format!("({} m)", self.unit), |(_, name)| (*name).to_owned())
    }
}

impl FaceSurface {
    /// The kind of the surface in the words of CAD systems.
    #[must_use]
    pub const fn kind(&self) -> &'static str {
        match self {
            Self::Plane(_) => "plane",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Sphere { .. } => "sphere",
            Self::Torus { .. } => "torus",
            Self::Revolution { .. } => "surface of revolution",
            Self::Extrusion { .. } => "surface of extrusion",
            Self::Nurbs(_) => "B-spline surface",
        }
    }
}
