//! Merges positions that a file contains several times.

use std::collections::HashMap;

use glam::DVec3;

use super::Corner;

/// Replaces equal positions by the first of them, so that seams of a file do not tear open. Triangles that then have
/// the same position twice are removed; their neighbours meet without them. Returns the numbers of the removed
/// triangles.
pub(crate) fn weld(positions: &[DVec3], triangles: &mut Vec<[Corner; 3]>) -> Vec<u32> {
    let mut firsts = HashMap::with_capacity(positions.len());
    let welded: Vec<u32> = (0..)
        .zip(positions)
        .map(|(index, position)| {
            // Adding zero turns −0 into 0.
            let bits = (*position + DVec3::ZERO).to_array().map(f64::to_bits);
            *firsts.entry(bits).or_insert(index)
        })
        .collect();
    let mut dropped = Vec::new();
    let mut number = 0;
    triangles.retain_mut(|corners| {
        let [a, b, c] = corners.each_mut().map(|corner| {
            corner.position = welded[corner.position as usize];
            corner.position
        });
        let kept = a != b && b != c && c != a;
        if !kept {
            dropped.push(number);
        }
        number += 1;
        kept
    });
    dropped
}
