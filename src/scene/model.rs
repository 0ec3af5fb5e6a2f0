//! Triangle meshes in a scene.

use std::ops::Range;
use std::rc::Rc;
use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::{Paint, Shading, TessLevel};
use crate::bezier::bounding_box;
use crate::mesh::{
    Alpha, CurvedTriangle, HalfedgeMesh, Mesh, PhongTriangle, PnTriangle, SmoothTriangle, Smoothing,
};

/// A triangle mesh with its transform and paint, drawn as a smooth surface by either method.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshModel {
    mesh: Arc<HalfedgeMesh>,
    smoothing: Smoothing,
    /// The corners of a box around the surface, in model space.
    hull: [DVec3; 2],
    /// The tessellation level of all its triangles, instead of the scene's level or tolerance.
    pub level: Option<TessLevel>,
    /// Model space to world space.
    pub transform: DMat4,
    /// Colour before lighting; a picture is placed by the mesh's texture coordinates, and repeats.
    pub paint: Paint,
    /// Triangles with a paint of their own, one range after the other.
    pub materials: Vec<Material>,
    /// Lighting.
    pub shading: Shading,
}

/// The paint of some triangles of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Its name in the file.
    pub name: String,
    /// Colour before lighting.
    pub paint: Paint,
    /// The indices of the triangles.
    pub triangles: Range<usize>,
}

impl MeshModel {
    /// A mesh without a transform, grey and lit.
    #[must_use]
    pub fn new(mesh: Mesh, smoothing: Smoothing) -> Self {
        let mesh = Arc::new(HalfedgeMesh::new(mesh));
        let hull = hull(&mesh, smoothing);
        Self {
            mesh,
            smoothing,
            hull,
            level: None,
            transform: DMat4::IDENTITY,
            paint: Paint::default(),
            materials: Vec::new(),
            shading: Shading::default(),
        }
    }

    /// The triangles.
    #[must_use]
    pub fn mesh(&self) -> &HalfedgeMesh {
        &self.mesh
    }

    /// The smoothing.
    #[must_use]
    pub const fn smoothing(&self) -> Smoothing {
        self.smoothing
    }

    /// Changes the smoothing.
    pub fn set_smoothing(&mut self, smoothing: Smoothing) {
        self.smoothing = smoothing;
        self.hull = hull(&self.mesh, smoothing);
    }

    /// The corners of a box in model space that holds the surface: minimum and maximum.
    #[must_use]
    pub const fn hull(&self) -> [DVec3; 2] {
        self.hull
    }

    /// The smooth surface over a triangle.
    #[must_use]
    pub(crate) fn curved(&self, triangle: u32) -> Curved {
        Curved::new(&self.mesh.triangle(triangle), self.smoothing)
    }

    /// The corners of the box around it in world space.
    pub(crate) fn world_hull(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        (0..8).map(|corner| {
            let at = |axis: usize| self.hull[corner >> axis & 1][axis];
            self.transform.transform_point3(DVec3::new(at(0), at(1), at(2)))
        })
    }

    /// Points of the surface in world space: the corners and, for smooth triangles, the middles of the edges and of
    /// the triangles.
    pub(super) fn samples(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        const THIRD: f64 = 1.0 / 3.0;
        const PLACES: [[f64; 3]; 4] =
            [[0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [THIRD, THIRD, THIRD]];
        let mesh = self.mesh.mesh();
        // Each corner counts once, even if several triangles share it.
        let mut is_corner = vec![false; mesh.positions().len()];
        for corner in mesh.triangles().iter().flatten() {
            is_corner[corner.position as usize] = true;
        }
        let is_corner: Rc<[bool]> = is_corner.into();
        let corners = (0..is_corner.len())
            .filter(move |position| is_corner[*position])
            .map(|position| mesh.positions()[position]);
        let is_flat = self.smoothing == Smoothing::None;
        let smooth = if is_flat { 0 } else { mesh.triangles().len() as u32 };
        let inner = (0..smooth).flat_map(move |triangle| {
            let curved = self.curved(triangle);
            PLACES.map(|[u, v, w]| curved.position(u, v, w))
        });
        corners.chain(inner).map(|point| self.transform.transform_point3(point))
    }
}

/// The corners of a box around the control points of all triangles.
fn hull(mesh: &HalfedgeMesh, smoothing: Smoothing) -> [DVec3; 2] {
    if smoothing == Smoothing::None {
        let positions = mesh.mesh().positions();
        let corners = mesh.mesh().triangles().iter().flatten();
        return bounding_box(corners.map(|corner| positions[corner.position as usize]));
    }
    bounding_box((0..mesh.mesh().triangles().len() as u32).flat_map(|triangle| {
        let curved = Curved::new(&mesh.triangle(triangle), smoothing);
        curved.with_control_points(|points| bounding_box(points.iter().copied()))
    }))
}

/// A smooth surface over a triangle, of either kind. Meshes without smoothing use Phong tessellation with α = 0.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Curved {
    Pn(PnTriangle),
    Phong(PhongTriangle),
}

impl Curved {
    fn new(triangle: &SmoothTriangle, smoothing: Smoothing) -> Self {
        match smoothing {
            Smoothing::None => Self::Phong(PhongTriangle::new(triangle, Alpha::NONE)),
            Smoothing::Pn => Self::Pn(PnTriangle::new(triangle)),
            Smoothing::Phong(alpha) => Self::Phong(PhongTriangle::new(triangle, alpha)),
        }
    }

    /// Passes its 10 or 6 control points to a function.
    pub(crate) fn with_control_points<T>(&self, use_them: impl FnOnce(&[DVec3]) -> T) -> T {
        match self {
            Self::Pn(triangle) => use_them(&triangle.control_points()),
            Self::Phong(triangle) => use_them(&triangle.control_points()),
        }
    }

    fn position(&self, u: f64, v: f64, w: f64) -> DVec3 {
        match self {
            Self::Pn(triangle) => triangle.position(u, v, w),
            Self::Phong(triangle) => triangle.position(u, v, w),
        }
    }
}
