//! The connectivity of a mesh, as half-edges.
//!
//! ```text
//!                 2
//!                / \            half-edge 3·t + k of triangle t runs from its corner k to the next;
//!     3t + 2    /   \  3t + 1   its twin runs the other way in the neighbour. An edge is a pair of
//!              /  t  \          twins, or a half-edge at a border; its first half-edge is the one
//!             0-------1         of the lower number.
//!               3t + 0
//! ```

use std::fmt;
use std::sync::OnceLock;

use glam::DVec3;

use super::vectors::between;
use super::{Corner, Mesh, Smoothing};
use crate::error::Result;

/// No twin: the half-edge is at a border.
const NONE: u32 = u32::MAX;

/// The next half-edge of the same triangle.
pub(super) const fn next(halfedge: u32) -> u32 {
    if halfedge % 3 == 2 { halfedge - 2 } else { halfedge + 1 }
}

/// A half-edge of an edge that is not a pair of twins, and whether it runs against the edge's first half-edge.
type Side = (u32, bool);

/// The half-edges of a list of triangles, by number.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Connectivity {
    /// The twin of each half-edge, or [`NONE`].
    twins: Vec<u32>,
    /// The edge of each half-edge.
    edges: Vec<u32>,
    /// The first half-edge of each edge, ascending.
    halfedges: Vec<u32>,
    /// For each edge that several triangles share but that is not a pair of twins: its half-edges, beginning with the
    /// edge's first one.
    fans: Vec<Vec<Side>>,
}

impl Connectivity {
    /// Pairs the half-edges that have both positions in common and run in opposite directions. If more than two
    /// half-edges have both positions in common, or if two run in the same direction, they have no twins: they are
    /// borders that share the edge.
    pub(super) fn new(position_count: usize, triangles: &[[Corner; 3]]) -> Self {
        let ends = |halfedge: u32| {
            let (triangle, k) = (halfedge as usize / 3, halfedge as usize % 3);
            let corners = &triangles[triangle];
            (corners[k].position, corners[(k + 1) % 3].position)
        };
        let count = 3 * triangles.len() as u32;
        // Half-edges are sorted into buckets by the lower of their two position indices.
        let mut starts = vec![0_u32; position_count + 1];
        for halfedge in 0..count {
            let (from, to) = ends(halfedge);
            starts[from.min(to) as usize + 1] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        // The sort key holds the higher position index and the half-edge in one integer.
        let mut buckets = vec![0_u64; count as usize];
        for halfedge in 0..count {
            let (from, to) = ends(halfedge);
            let place = &mut starts[from.min(to) as usize];
            buckets[*place as usize] = u64::from(from.max(to)) << 32 | u64::from(halfedge);
            *place += 1;
        }
        let mut twins = vec![NONE; count as usize];
        let mut fans: Vec<Vec<Side>> = Vec::new();
        let mut start = 0;
        // Filling a bucket has moved its entry in `starts` to the end of the bucket.
        for end in &starts[..position_count] {
            let bucket = &mut buckets[start..*end as usize];
            start = *end as usize;
            bucket.sort_unstable();
            for edge in bucket.chunk_by(|a, b| a >> 32 == b >> 32) {
                let first = edge[0] as u32;
                match *edge {
                    [_] => {}
                    [_, second] if ends(first).0 != ends(second as u32).0 => {
                        twins[first as usize] = second as u32;
                        twins[second as u32 as usize] = first;
                    }
                    _ => {
                        let side = |halfedge| (halfedge, ends(halfedge).0 != ends(first).0);
                        fans.push(edge.iter().map(|number| side(*number as u32)).collect());
                    }
                }
            }
        }
        Self::of_twins(twins, fans)
    }

    /// The half-edges after a step. The nine triangles that replace an old one have a fixed order.
    fn tessellated(&self) -> Self {
        // Half-edge `i` of the new triangle `part`, one of the three at corner `k`.
        let of =
            |triangle: u32, k: u32, part: u32, i: u32| 27 * triangle + 9 * (k % 3) + 3 * part + i;
        // The new half-edge along a third (0, 1 or 2) of an old half-edge.
        let third = |halfedge: u32, third: u32| {
            let (triangle, k) = (halfedge / 3, halfedge % 3);
            match third {
                0 => of(triangle, k, 0, 0),
                1 => of(triangle, k, 2, 0),
                _ => of(triangle, k + 1, 0, 2),
            }
        };
        // The new half-edge on the other side of a third of an old half-edge.
        let across = |halfedge: u32, part: u32| match self.twins[halfedge as usize] {
            NONE => NONE,
            twin => third(twin, 2 - part),
        };
        let mut twins = Vec::with_capacity(9 * self.twins.len());
        for (halfedge, triangle) in (0..self.twins.len() as u32).map(|h| (h, h / 3)) {
            let k = halfedge % 3;
            let before = 3 * triangle + (k + 2) % 3;
            twins.extend([
                across(halfedge, 0),
                of(triangle, k, 1, 2),
                across(before, 2),
                of(triangle, k, 2, 2),
                of(triangle, k + 2, 2, 1),
                of(triangle, k, 0, 1),
                across(halfedge, 1),
                of(triangle, k + 1, 1, 1),
                of(triangle, k, 1, 0),
            ]);
        }
        let thirds = self.fans.iter().flat_map(|fan| {
            (0..3).map(|part| {
                let of_side = |(halfedge, against): &Side| {
                    (third(*halfedge, if *against { 2 - part } else { part }), *against)
                };
                fan.iter().map(of_side).collect()
            })
        });
        Self::of_twins(twins, thirds.collect())
    }

    /// Half-edges with their twins, each pair once.
    pub(super) fn pairs(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        (0..)
            .zip(&self.twins)
            .filter(|(_, twin)| **twin != NONE)
            .map(|(a, b)| (a, *b))
            .filter(|(a, b)| a < b)
    }

    /// Numbers the edges in the order of their first half-edges.
    fn of_twins(twins: Vec<u32>, mut fans: Vec<Vec<Side>>) -> Self {
        let mut edges = vec![NONE; twins.len()];
        let mut halfedges = Vec::with_capacity(twins.len() / 2 + 1);
        // The first half-edge of a fan has the lowest number. Until edges are numbered, `edges` holds its number for
        // all half-edges of the fan.
        for fan in &mut fans {
            // After a step, the first half-edge of a fan is first again, except at borders that run the other way.
            let (first, against) = fan.iter().copied().min().unwrap_or((NONE, false));
            fan.sort_unstable();
            for (halfedge, side) in fan {
                *side ^= against;
                edges[*halfedge as usize] = first;
            }
        }
        for (halfedge, twin) in (0..).zip(&twins) {
            let first = match edges[halfedge as usize] {
                NONE if *twin < halfedge => *twin,
                NONE => halfedge,
                first => first,
            };
            edges[halfedge as usize] = if first < halfedge {
                edges[first as usize]
            } else {
                halfedges.push(halfedge);
                halfedges.len() as u32 - 1
            };
        }
        fans.sort_unstable();
        Self { twins, edges, halfedges, fans }
    }

    /// The half-edges of the edge of a half-edge, if that edge is a fan.
    fn fan(&self, halfedge: u32) -> Option<&[Side]> {
        if self.fans.is_empty() {
            return None;
        }
        let first = self.halfedges[self.edges[halfedge as usize] as usize];
        let number = self.fans.binary_search_by_key(&first, |fan| fan[0].0).ok()?;
        Some(&self.fans[number])
    }
}

/// The numbers of edges that several triangles share without being neighbours there. Drawing and smoothing treat
/// these triangles as having borders that share the edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SharedBorders {
    /// Edges of more than two triangles.
    pub crowded: usize,
    /// Edges that two triangles run through in the same direction.
    pub same_way: usize,
}

/// Writes, for example, "12 edges of more than two triangles and 2 that both triangles run through in the same
/// direction".
impl fmt::Display for SharedBorders {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let edges =
            |count: usize| if count == 1 { "1 edge".into() } else { format!("{count} edges") };
        let crowded = format!("{} of more than two triangles", edges(self.crowded));
        let same_way = "that both triangles run through in the same direction";
        match (self.crowded, self.same_way) {
            (_, 0) => f.write_str(&crowded),
            (0, count) => write!(f, "{} {same_way}", edges(count)),
            (_, count) => write!(f, "{crowded} and {} {same_way}", edges(count)),
        }
    }
}

/// The corners and normals that define the smooth surface over a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SmoothTriangle {
    /// The corners.
    pub positions: [DVec3; 3],
    /// The normals of the corners, for shading: unit vectors, or zero.
    pub normals: [DVec3; 3],
    /// For the edge from corner k to the next: the normals at its ends that shape it. Neighbours have the same ones.
    pub edge_normals: [[DVec3; 2]; 3],
}

/// A mesh whose triangles know their neighbours.
///
/// It may have borders, several components, triangles that touch only in a vertex, and non-manifold edges of three or
/// more triangles. Normals and texture coordinates do not affect the connectivity.
#[derive(Debug, Clone)]
pub struct HalfedgeMesh {
    mesh: Mesh,
    /// Computed on first use: a mesh that is drawn without smoothing needs no connectivity.
    connectivity: OnceLock<Connectivity>,
}

impl PartialEq for HalfedgeMesh {
    fn eq(&self, other: &Self) -> bool {
        self.mesh == other.mesh && self.connectivity() == other.connectivity()
    }
}

impl HalfedgeMesh {
    /// Two triangles are neighbours if they run through an edge in opposite directions. All other edges are borders.
    /// A border that several triangles share still counts as one edge ([`HalfedgeMesh::shared_borders`]).
    #[must_use]
    pub const fn new(mesh: Mesh) -> Self {
        Self { mesh, connectivity: OnceLock::new() }
    }

    fn connectivity(&self) -> &Connectivity {
        let mesh = &self.mesh;
        self.connectivity
            .get_or_init(|| Connectivity::new(mesh.positions().len(), mesh.triangles()))
    }

    /// How many edges several triangles share without being neighbours there.
    #[must_use]
    pub fn shared_borders(&self) -> SharedBorders {
        let same_way = self.connectivity().fans.iter().filter(|fan| fan.len() == 2).count();
        SharedBorders { crowded: self.connectivity().fans.len() - same_way, same_way }
    }

    /// The mesh.
    #[must_use]
    pub const fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// The mesh without its connectivity.
    #[must_use]
    pub fn into_mesh(self) -> Mesh {
        self.mesh
    }

    /// The number of half-edges: three for each triangle.
    #[must_use]
    pub fn halfedges(&self) -> u32 {
        3 * self.mesh.triangles().len() as u32
    }

    /// The number of edges.
    #[must_use]
    pub fn edges(&self) -> u32 {
        self.connectivity().halfedges.len() as u32
    }

    /// The half-edge that runs the other way in the neighbour; `None` at a border.
    #[must_use]
    pub fn twin(&self, halfedge: u32) -> Option<u32> {
        Some(self.connectivity().twins[halfedge as usize]).filter(|twin| *twin != NONE)
    }

    /// The next half-edge of the same triangle.
    #[must_use]
    pub const fn next(&self, halfedge: u32) -> u32 {
        next(halfedge)
    }

    /// The position that the half-edge begins at.
    #[must_use]
    pub fn vertex(&self, halfedge: u32) -> u32 {
        self.corner(halfedge).position
    }

    /// The edge of the half-edge.
    #[must_use]
    pub fn edge(&self, halfedge: u32) -> u32 {
        self.connectivity().edges[halfedge as usize]
    }

    /// The triangle of the half-edge.
    #[must_use]
    pub const fn face(&self, halfedge: u32) -> u32 {
        halfedge / 3
    }

    /// The first half-edge of an edge.
    #[must_use]
    pub fn halfedge(&self, edge: u32) -> u32 {
        self.connectivity().halfedges[edge as usize]
    }

    /// The mesh after a step of smoothing. Its connectivity is derived from the connectivity of this mesh. Use this
    /// instead of [`HalfedgeMesh::tessellate`] if further steps follow.
    ///
    /// # Errors
    /// More than [`Mesh::MAX_TRIANGLES`].
    pub fn step(&self, smoothing: Smoothing) -> Result<Self> {
        let mesh = self.tessellate(smoothing)?;
        Ok(Self { mesh, connectivity: self.connectivity().tessellated().into() })
    }

    /// The corner that the half-edge begins at.
    pub(super) fn corner(&self, halfedge: u32) -> Corner {
        self.mesh.triangles[halfedge as usize / 3][halfedge as usize % 3]
    }

    /// For each triangle and its edge from corner k to the next, the normals at the two ends that
    /// shape the edge.
    ///
    /// If both sides have the same normal, it is used. At a crease it is the normalized sum of both normals, or zero
    /// if they are opposite; a zero normal makes the edge straight there. So both sides get the same normal, bit for
    /// bit. Triangles that share a border also get the same normal: their common one if all have the same, otherwise
    /// zero.
    #[must_use]
    pub fn edge_normals(&self) -> Vec<[[DVec3; 2]; 3]> {
        (0..self.halfedges() / 3).map(|triangle| self.triangle(triangle).edge_normals).collect()
    }

    /// The corners and normals that define the smooth surface over a triangle.
    #[must_use]
    pub fn triangle(&self, triangle: u32) -> SmoothTriangle {
        let corners = &self.mesh.triangles[triangle as usize];
        SmoothTriangle {
            positions: corners.map(|corner| self.mesh.positions[corner.position as usize]),
            normals: corners.map(|corner| self.mesh.normals[corner.normal as usize]),
            edge_normals: [0, 1, 2].map(|k| self.normals_along(3 * triangle + k)),
        }
    }

    /// The normals that shape an edge, at the beginning and the end of a half-edge of it.
    fn normals_along(&self, halfedge: u32) -> [DVec3; 2] {
        let normals = self.mesh.normals();
        let normal = |halfedge: u32| normals[self.corner(halfedge).normal as usize];
        let ends = [halfedge, self.next(halfedge)];
        if let Some(fan) = self.connectivity().fan(halfedge) {
            let at = |end: usize| {
                let against = fan.contains(&(halfedge, true));
                let mut of_sides = fan.iter().map(|(halfedge, other)| {
                    let end = if *other == against { end } else { 1 - end };
                    normal([*halfedge, self.next(*halfedge)][end])
                });
                let first = of_sides.next().unwrap_or(DVec3::ZERO);
                if of_sides.all(|normal| normal == first) { first } else { DVec3::ZERO }
            };
            return [at(0), at(1)];
        }
        let of_twin = self.twin(halfedge).map_or(ends, |twin| [self.next(twin), twin]);
        [0, 1].map(|end| {
            let [own, other] =
                [ends[end], of_twin[end]].map(|end| self.corner(end).normal as usize);
            if own == other { normals[own] } else { between(normals[own], normals[other]) }
        })
    }
}
