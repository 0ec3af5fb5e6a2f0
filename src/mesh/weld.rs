//! Positions that a file has several times.

use std::collections::HashMap;

use glam::DVec3;

use super::Corner;

/// Makes equal positions one, the first of them, so that seams of a file do not tear, and leaves out triangles
/// that thereby have twice the same position: their neighbours meet without them. Returns their numbers.
pub(crate) fn weld(positions: &[DVec3], triangles: &mut Vec<[Corner; 3]>) -> Vec<u32> {
    let mut firsts = HashMap::with_capacity(positions.len());
    let welded: Vec<u32> = (0..)
        .zip(positions)
        .map(|(index, position)| {
            // Adding zero makes −0 and 0 one.
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
