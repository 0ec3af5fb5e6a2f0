//! One step of smoothing: every triangle becomes nine, with two new points on each edge and one in
//! the middle. Names follow *Tessellation in Scotty3D*, the course project that this is a port of.
//!
//! ```text
//!               2
//!              / \              ek near corner k of edge k, fk far from it, m the middle.
//!            e2---f1            For each corner: the triangle at it, the one between its two
//!            / \ / \            edge points and the middle, the one on the middle third of
//!          f2---m---e1          the edge that begins there.
//!          / \ / \ / \
//!         0--e0---f0--1
//! ```
//!
//! The barycentric coordinates of the new points are constants. The course project computed them again from
//! positions, which broke its pictures.

use glam::{DVec2, DVec3, Vec3};

use super::vectors::mean;
use super::{
    Alpha, Corner, HalfedgeMesh, Mesh, PhongTriangle, PnTriangle, SmoothTriangle, Smoothing,
};
use crate::error::{Error, Result};

/// The number of triangles that replace each triangle.
const PARTS: usize = 9;
const THIRD: f64 = 1.0 / 3.0;
const CENTER: [f64; 3] = [THIRD; 3];
/// Barycentric coordinates of the two points of each edge.
const EDGES: [[[f64; 3]; 2]; 3] = {
    const TWO: f64 = 2.0 / 3.0;
    [
        [[TWO, THIRD, 0.0], [THIRD, TWO, 0.0]],
        [[0.0, TWO, THIRD], [0.0, THIRD, TWO]],
        [[THIRD, 0.0, TWO], [TWO, 0.0, THIRD]],
    ]
};

/// A surface over a triangle.
pub trait CurvedTriangle {
    /// The point at barycentric coordinates whose sum is 1. On an edge, where one of them is zero, neighbours have
    /// the same point to the last bit.
    fn position(&self, u: f64, v: f64, w: f64) -> DVec3;

    /// The normal for shading at barycentric coordinates whose sum is 1: always a unit vector.
    fn normal(&self, u: f64, v: f64, w: f64) -> DVec3;
}

/// A list of values of the new mesh, such as positions or normals. It has the old entries, then two for each edge in
/// the order of the edges' first half-edges, then one for each face, then two more for each edge whose sides differ.
struct TessellationList<T> {
    /// The old entries and those of edges.
    entries: Vec<T>,
    faces: Vec<T>,
    apart: Vec<T>,
    /// The numbers of the first entry of edges, of faces, and of `apart`.
    starts: [u32; 3],
}

impl<T: Copy + PartialEq> TessellationList<T> {
    /// Gives every new entry its number.
    fn assign_tessellation_indices(old: &[T], mesh: &HalfedgeMesh) -> Self {
        let edges = old.len() + 2 * mesh.edges() as usize;
        let faces = mesh.mesh().triangles.len();
        let mut entries = Vec::with_capacity(edges + faces);
        entries.extend_from_slice(old);
        Self {
            entries,
            faces: Vec::with_capacity(faces),
            apart: Vec::new(),
            starts: [old.len(), edges, edges + faces].map(|start| start as u32),
        }
    }

    /// The numbers of the two entries of a half-edge's edge; the one nearer to the half-edge's beginning comes first.
    /// The first half-edge of the edge creates the entries. Its twin creates entries of its own where the sides
    /// differ. `of_corner` returns a corner's number in this list.
    fn edge_tess_index(
        &mut self,
        mesh: &HalfedgeMesh,
        halfedge: u32,
        of_corner: impl Fn(Corner) -> u32,
        entries: impl FnOnce() -> [T; 2],
    ) -> [u32; 2] {
        let edge = mesh.edge(halfedge);
        let first = mesh.halfedge(edge);
        let index = self.starts[0] + 2 * edge;
        if halfedge == first {
            self.entries.extend_from_slice(&entries());
            return [index, index + 1];
        }
        let same = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|halfedge| of_corner(mesh.corner(halfedge)));
            a == b || self.entries[a as usize] == self.entries[b as usize]
        };
        // At a border that triangles share, half-edges may run in the same direction.
        let against = mesh.vertex(halfedge) != mesh.vertex(first);
        let ends = if against { [mesh.next(first), first] } else { [first, mesh.next(first)] };
        if same(halfedge, ends[0]) && same(mesh.next(halfedge), ends[1]) {
            return if against { [index + 1, index] } else { [index, index + 1] };
        }
        let index = self.starts[2] + self.apart.len() as u32;
        self.apart.extend_from_slice(&entries());
        [index, index + 1]
    }

    /// Adds the entry of a face, and returns its number.
    fn face_tess_index(&mut self, entry: T) -> u32 {
        self.faces.push(entry);
        self.starts[1] + self.faces.len() as u32 - 1
    }

    /// The whole list.
    fn build_tessellation_list(mut self) -> Vec<T> {
        self.entries.append(&mut self.faces);
        self.entries.append(&mut self.apart);
        self.entries
    }
}

impl HalfedgeMesh {
    /// The mesh after one step.
    ///
    /// Its points lie on the surfaces over this mesh's triangles. The old points come first, then two for each edge,
    /// then one for each face. Of the two on an edge, the one nearer to the beginning of the edge's first half-edge
    /// comes first. Normals and texture coordinates have the same order. Values that differ between the sides of an
    /// edge follow at the end. The new triangles are in the order of the triangles that they replace.
    ///
    /// # Errors
    /// More than [`Mesh::MAX_TRIANGLES`].
    pub fn tessellate(&self, smoothing: Smoothing) -> Result<Mesh> {
        match smoothing {
            Smoothing::None => self.phong(Alpha::NONE),
            Smoothing::Pn => self.pn_triangle(),
            Smoothing::Phong(alpha) => self.phong(alpha),
        }
    }

    /// The mesh after one step with curved PN triangles; see [`HalfedgeMesh::tessellate`].
    ///
    /// # Errors
    /// More than [`Mesh::MAX_TRIANGLES`].
    pub fn pn_triangle(&self) -> Result<Mesh> {
        self.tessellate_on(PnTriangle::new)
    }

    /// The mesh after one step of Phong tessellation; see [`HalfedgeMesh::tessellate`].
    ///
    /// # Errors
    /// More than [`Mesh::MAX_TRIANGLES`].
    pub fn phong(&self, alpha: Alpha) -> Result<Mesh> {
        self.tessellate_on(|triangle| PhongTriangle::new(triangle, alpha))
    }

    fn tessellate_on<S: CurvedTriangle>(
        &self,
        surface: impl Fn(&SmoothTriangle) -> S,
    ) -> Result<Mesh> {
        let old = self.mesh();
        check_size(old.triangles.len(), 1)?;
        let mut positions = TessellationList::assign_tessellation_indices(&old.positions, self);
        let mut normals = TessellationList::assign_tessellation_indices(&old.normals, self);
        let mut coordinates = (!old.coordinates.is_empty())
            .then(|| TessellationList::assign_tessellation_indices(&old.coordinates, self));
        let mut colors = (!old.colors.is_empty())
            .then(|| TessellationList::assign_tessellation_indices(&old.colors, self));
        let mut triangles = Vec::with_capacity(PARTS * old.triangles.len());
        for (number, corners) in (0..).zip(&old.triangles) {
            let surface = surface(&self.triangle(number));
            let position = |[u, v, w]: [f64; 3]| surface.position(u, v, w);
            let normal = |[u, v, w]: [f64; 3]| surface.normal(u, v, w);
            let coordinate = |weights: [f64; 3]| -> DVec2 {
                let of_corners = corners.map(|corner| old.coordinates[corner.coordinate as usize]);
                mean(of_corners.map(|coordinate| coordinate.extend(0.0)), weights).truncate()
            };
            let color = |weights: [f64; 3]| {
                let of_corners = corners.map(|corner| old.colors[corner.position as usize]);
                let of_corners = of_corners.map(|color| Vec3::from_array(color).as_dvec3());
                mean(of_corners, weights).as_vec3().to_array()
            };
            let edges = [0, 1, 2].map(|k| {
                let halfedge = 3 * number + k;
                let points = EDGES[k as usize];
                let [near, far] = positions.edge_tess_index(
                    self,
                    halfedge,
                    |corner| corner.position,
                    || points.map(position),
                );
                let normal = normals.edge_tess_index(
                    self,
                    halfedge,
                    |corner| corner.normal,
                    || points.map(normal),
                );
                let coordinate = coordinates.as_mut().map_or([Corner::NONE; 2], |list| {
                    let of_corner = |corner: Corner| corner.coordinate;
                    list.edge_tess_index(self, halfedge, of_corner, || points.map(coordinate))
                });
                if let Some(list) = &mut colors {
                    let of_corner = |corner: Corner| corner.position;
                    list.edge_tess_index(self, halfedge, of_corner, || points.map(color));
                }
                [
                    Corner { position: near, normal: normal[0], coordinate: coordinate[0] },
                    Corner { position: far, normal: normal[1], coordinate: coordinate[1] },
                ]
            });
            let center = Corner {
                position: positions.face_tess_index(position(CENTER)),
                normal: normals.face_tess_index(normal(CENTER)),
                coordinate: coordinates
                    .as_mut()
                    .map_or(Corner::NONE, |list| list.face_tess_index(coordinate(CENTER))),
            };
            if let Some(list) = &mut colors {
                list.face_tess_index(color(CENTER));
            }
            triangles.extend_from_slice(&build_tessellation_faces(*corners, edges, center));
        }
        Ok(Mesh {
            positions: positions.build_tessellation_list(),
            normals: normals.build_tessellation_list(),
            coordinates: coordinates.map_or(Vec::new(), TessellationList::build_tessellation_list),
            colors: colors.map_or(Vec::new(), TessellationList::build_tessellation_list),
            triangles,
        })
    }
}

/// The nine triangles that replace a triangle; see the picture at the top of this file.
fn build_tessellation_faces(
    corners: [Corner; 3],
    edges: [[Corner; 2]; 3],
    center: Corner,
) -> [[Corner; 3]; PARTS] {
    let [a, b, c] = corners;
    let [[e0, f0], [e1, f1], [e2, f2]] = edges;
    let m = center;
    [
        [a, e0, f2],
        [e0, m, f2],
        [e0, f0, m],
        [b, e1, f0],
        [e1, m, f0],
        [e1, f1, m],
        [c, e2, f1],
        [e2, m, f1],
        [e2, f2, m],
    ]
}

/// Refuses steps that would make more triangles than a mesh may have.
fn check_size(triangles: usize, steps: u32) -> Result<()> {
    let count = PARTS.checked_pow(steps).and_then(|parts| triangles.checked_mul(parts));
    if count.is_some_and(|count| count <= Mesh::MAX_TRIANGLES) {
        return Ok(());
    }
    Err(Error::invalid(
        "number of triangles after smoothing",
        format!("{triangles} · 9^{steps}"),
        format!("at most {}: fewer steps, or a smaller mesh", Mesh::MAX_TRIANGLES),
    ))
}

/// The mesh after the given number of smoothing steps.
///
/// # Errors
/// More than [`Mesh::MAX_TRIANGLES`].
pub fn smooth(mesh: Mesh, smoothing: Smoothing, steps: u32) -> Result<Mesh> {
    check_size(mesh.triangles.len(), steps)?;
    let mut coarse = HalfedgeMesh::new(mesh);
    for _ in 1..steps {
        coarse = coarse.step(smoothing)?;
    }
    if steps == 0 { Ok(coarse.into_mesh()) } else { coarse.tessellate(smoothing) }
}
