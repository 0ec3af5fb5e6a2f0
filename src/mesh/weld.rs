//! Positions that a file has several times.

use std::collections::HashMap;

use glam::DVec3;

use super::Corner;
use super::half_edge::Connectivity;

/// The triangles with equal positions made one, the first of them, so that seams of a file do not
/// tear. What thereby has twice the same position is left out: its neighbours meet without it.
///
/// Where that would give some edge a third triangle, as where two cubes touch along an edge, no
/// positions are made one.
pub(crate) fn weld(positions: &[DVec3], triangles: Vec<[Corner; 3]>) -> Vec<[Corner; 3]> {
    let mut firsts = HashMap::with_capacity(positions.len());
    let welded: Vec<u32> = (0..)
        .zip(positions)
        .map(|(index, position)| {
            // Adding zero makes −0 and 0 one.
            let bits = (*position + DVec3::ZERO).to_array().map(f64::to_bits);
            *firsts.entry(bits).or_insert(index)
        })
        .collect();
    drop(firsts);
    let joined: Vec<[Corner; 3]> = triangles
        .iter()
        .map(|corners| {
            corners.map(|corner| Corner { position: welded[corner.position as usize], ..corner })
        })
        .filter(has_three_positions)
        .collect();
    if Connectivity::new(positions, &joined).is_ok() {
        joined
    } else {
        triangles.into_iter().filter(has_three_positions).collect()
    }
}

fn has_three_positions(corners: &[Corner; 3]) -> bool {
    let [a, b, c] = corners.map(|corner| corner.position);
    a != b && b != c && c != a
}
