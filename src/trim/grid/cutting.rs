//! Curves cut to the size of the cells that they touch.

use glam::{DVec2, Vec2};

use super::CROWDED;
use crate::trim::pieces::{Curve, Piece, split};
use crate::trim::uniform_grid::{UniformGrid, touched};

/// The largest number of cells along a side of a grid.
const LARGEST_SIDE: u32 = 256;
/// The maximum number of pieces, for each curve, that cutting curves to the size of cells may add. The total is
/// clamped to `MORE_PIECES`.
const MORE_PIECES_PER_CURVE: usize = 15;
const MORE_PIECES: std::ops::RangeInclusive<usize> = 1 << 14..=1 << 20;

/// A curve, and the number of the fill that its loop belongs to.
#[derive(Debug, Clone, Copy)]
pub(super) struct FilledCurve {
    pub(super) curve: Curve,
    pub(super) fill: u32,
}

/// The uniform grid for these curves. It has about 4 cells for each curve, or fewer if that would cut long curves
/// into too many pieces, but at least `least` along a side. `None` if the curves enclose no area.
pub(super) fn uniform_grid_of(curves: &[FilledCurve], least: u32) -> Option<UniformGrid> {
    let mut min = Vec2::INFINITY;
    let mut max = Vec2::NEG_INFINITY;
    for piece in curves.iter().filter_map(|curve| Piece::new(&curve.curve)) {
        min = min.min(piece.low.min(piece.high));
        max = max.max(piece.low.max(piece.high));
    }
    if !min.cmplt(max).all() {
        return None;
    }
    // A power of two, which the shaders are told in few bits.
    let wanted = (2 * curves.len().isqrt() as u32).next_power_of_two();
    let mut side = wanted.clamp(least, LARGEST_SIDE);
    let pieces_at = |side: u32| -> f64 {
        let cells = |curve: &Curve| (curve[3] - curve[0]).abs().max_element() * f64::from(side);
        curves.iter().map(|curve| cells(&curve.curve).max(1.0)).sum()
    };
    while side > 1 && pieces_at(side) > most_pieces(curves) as f64 / 2.0 {
        side /= 2;
    }
    Some(UniformGrid::of_domain(side))
}

/// The maximum number of pieces that the curves may be cut into.
fn most_pieces(curves: &[FilledCurve]) -> usize {
    let more = MORE_PIECES_PER_CURVE * curves.len();
    curves.len() + more.clamp(*MORE_PIECES.start(), *MORE_PIECES.end())
}

/// Cuts curves until their bounding boxes are no larger than the cells that they touch. In crowded cells, the limit
/// is the size of the finer cells there.
pub(super) fn cut_to_cells(curves: &[FilledCurve], uniform_grid: &UniformGrid) -> Vec<FilledCurve> {
    // For smaller pieces, rounding would decide where they are cut.
    const SMALLEST: f64 = 1e-6;
    let cell = DVec2::ONE / uniform_grid.size.as_dvec2();
    let budget = most_pieces(curves);
    let mut parts = Vec::with_capacity(curves.len());
    for curve in curves {
        halve(curve, 0, &mut parts, &|_| cell);
    }
    let [columns, rows] = [0, 1].map(|axis| uniform_grid.bounds(axis));
    let mut counts = vec![0_u32; uniform_grid.count()];
    let cells_of = |part: &FilledCurve| {
        let part = &part.curve;
        let (min, max) = (part[0].min(part[3]).as_vec2(), part[0].max(part[3]).as_vec2());
        let columns = touched(&columns, [min.x, max.x]);
        touched(&rows, [min.y, max.y])
            .flat_map(move |row| columns.clone().map(move |column| (row, column)))
            .map(|(row, column)| row * uniform_grid.size.x as usize + column)
    };
    for part in &parts {
        for cell in cells_of(part) {
            counts[cell] += 1;
        }
    }
    if counts.iter().all(|count| *count as usize <= CROWDED) {
        return parts;
    }
    let mut finer = Vec::with_capacity(parts.len());
    for part in &parts {
        let crowd = cells_of(part).map(|cell| counts[cell] as usize).max().unwrap_or(0);
        if crowd <= CROWDED || finer.len() > budget {
            finer.push(*part);
            continue;
        }
        halve(part, 0, &mut finer, &|part| {
            let crowd = cells_of(part).map(|cell| counts[cell] as usize).max().unwrap_or(0);
            let side = if crowd > CROWDED { finer_side(crowd) } else { 1 };
            (cell / f64::from(side)).max(DVec2::splat(SMALLEST))
        });
    }
    finer
}

/// The number of cells along a side of the finer grid in a cell that has `count` pieces.
pub(super) fn finer_side(count: usize) -> u32 {
    (2.0 * (count as f64).sqrt()).min(LARGEST_SIDE.into()) as u32
}

/// Halves a curve repeatedly until the bounding box of each piece is no larger than `limit` allows for it.
fn halve(
    curve: &FilledCurve,
    depth: u32,
    parts: &mut Vec<FilledCurve>,
    limit: &impl Fn(&FilledCurve) -> DVec2,
) {
    const DEEPEST: u32 = 12;
    let extent = (curve.curve[3] - curve.curve[0]).abs();
    if depth == DEEPEST || extent.cmple(limit(curve)).all() {
        parts.push(*curve);
        return;
    }
    for half in split(&curve.curve, 0.5) {
        halve(&FilledCurve { curve: half, ..*curve }, depth + 1, parts, limit);
    }
}
