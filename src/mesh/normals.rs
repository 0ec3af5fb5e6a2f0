//! Computes the normals that a mesh does not provide: those of triangles, and those of corners from the triangles
//! around them.

use std::cmp::Ordering;

use glam::{DVec3, DVec4};

use super::half_edge::{Connectivity, next};
use super::vectors::{direction, mean, sum};
use super::{Corner, CreaseAngle, Mesh};

/// A triangle whose longest side is 1 and whose area is less than this is treated as having no area: its area may be
/// rounding error alone.
const NO_AREA: f64 = 1e-14;

/// The sides of a triangle, from each corner to the next, scaled so that their products do not overflow or underflow;
/// `None` if the triangle is a point.
fn sides([a, b, c]: [DVec3; 3]) -> Option<[DVec3; 3]> {
    let sides = [b - a, c - b, a - c];
    let scale = sides.map(|side| side.abs().max_element()).into_iter().fold(0.0, f64::max);
    (scale > 0.0).then(|| sides.map(|side| side / scale))
}

/// The unit normal of a triangle; zero if it has no area.
fn of_face(corners: [DVec3; 3]) -> DVec3 {
    let Some([ab, bc, ca]) = sides(corners) else { return DVec3::ZERO };
    let cross = sum(ab.cross(bc), bc.cross(ca), ca.cross(ab));
    if cross.length() > NO_AREA { cross.normalize() } else { DVec3::ZERO }
}

/// The angles of a triangle, in radians; zeros if it is a point.
fn angles(corners: [DVec3; 3]) -> [f64; 3] {
    let Some(sides) = sides(corners) else { return [0.0; 3] };
    [0, 1, 2].map(|k| angle(sides[k], -sides[(k + 2) % 3]))
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}

/// The normal for shading where no better one is known: the interpolation of the corners' normals. If that vanishes,
/// it is the normal of the triangle. If the triangle has none, it is +z.
pub(super) fn shading(normals: [DVec3; 3], positions: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    direction(mean(normals, weights)).or_else(|| direction(of_face(positions))).unwrap_or(DVec3::Z)
}

/// Computes the normals of corners that have none: the mean of the normals of the faces around the position, weighted
/// by the faces' angles there (Thürmer, Wüthrich 1998). Faces beyond a crease or a border do not contribute.
pub(super) fn complete(mesh: &mut Mesh, crease: CreaseAngle) {
    if mesh.triangles.iter().flatten().all(|corner| corner.normal != Corner::NONE) {
        return;
    }
    let faces: Vec<DVec3> =
        mesh.triangles.iter().map(|corners| of_face(positions_of(mesh, corners))).collect();
    let (groups, count) = groups(mesh, &faces, crease);
    // The corners of each group, one group after the other.
    let mut ends = vec![0_u32; count + 1];
    for group in &groups {
        ends[*group as usize + 1] += 1;
    }
    for i in 1..ends.len() {
        ends[i] += ends[i - 1];
    }
    let mut corners = vec![0_u32; groups.len()];
    for (corner, group) in (0..).zip(&groups) {
        let end = &mut ends[*group as usize];
        corners[*end as usize] = corner;
        *end += 1;
    }
    let first = mesh.normals.len();
    mesh.normals.reserve_exact(count);
    let mut shares: Vec<DVec4> = Vec::new();
    let mut start = 0;
    for end in &ends[..count] {
        shares.clear();
        shares.extend(corners[start..*end as usize].iter().map(|corner| {
            let (triangle, k) = (*corner as usize / 3, *corner as usize % 3);
            let angle = angles(positions_of(mesh, &mesh.triangles[triangle]))[k];
            (faces[triangle] * angle).extend(angle)
        }));
        start = *end as usize;
        // Summed in the order of their values, so that the order of the triangles does not matter.
        shares.sort_unstable_by(|a, b| {
            let values = a.to_array().into_iter().zip(b.to_array());
            values
                .map(|(a, b)| a.total_cmp(&b))
                .find(|order| order.is_ne())
                .unwrap_or(Ordering::Equal)
        });
        let sum: DVec4 = shares.iter().sum();
        mesh.normals.push(direction(sum.truncate() / sum.w).unwrap_or(DVec3::ZERO));
    }
    for (corner, group) in mesh.triangles.iter_mut().flatten().zip(groups) {
        if corner.normal == Corner::NONE {
            corner.normal = first as u32 + group;
        }
    }
}

fn positions_of(mesh: &Mesh, corners: &[Corner; 3]) -> [DVec3; 3] {
    corners.map(|corner| mesh.positions[corner.position as usize])
}

/// For every corner the number of its group, and the number of groups. The corners of a group share a normal: they
/// can be reached from each other around their position without crossing a crease or a border.
fn groups(mesh: &Mesh, faces: &[DVec3], crease: CreaseAngle) -> (Vec<u32>, usize) {
    let connectivity = Connectivity::new(mesh.positions.len(), &mesh.triangles);
    let mut parents: Vec<u32> = (0..3 * faces.len() as u32).collect();
    for (halfedge, twin) in connectivity.pairs() {
        let [a, b] = [halfedge, twin].map(|halfedge| faces[halfedge as usize / 3]);
        if angle(a, b).to_degrees() <= crease.degrees() {
            join(&mut parents, halfedge, next(twin));
            join(&mut parents, next(halfedge), twin);
        }
    }
    let mut numbers = vec![Corner::NONE; parents.len()];
    let mut count = 0;
    for corner in 0..parents.len() {
        // A root has the lowest number of its group, so it comes first.
        let root = root(&mut parents, corner as u32) as usize;
        if root == corner {
            numbers[corner] = count;
            count += 1;
        } else {
            numbers[corner] = numbers[root];
        }
    }
    (numbers, count as usize)
}

/// The corner that represents the group of a corner (union-find).
fn root(parents: &mut [u32], mut corner: u32) -> u32 {
    while parents[corner as usize] != corner {
        let above = parents[parents[corner as usize] as usize];
        parents[corner as usize] = above;
        corner = above;
    }
    corner
}

fn join(parents: &mut [u32], a: u32, b: u32) {
    let (a, b) = (root(parents, a), root(parents, b));
    parents[a.max(b) as usize] = a.min(b);
}
