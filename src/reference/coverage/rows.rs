//! The loops of a surface, prepared for many queries: the oracle's test, evaluated only for the curves near a
//! row.

use glam::DVec2;

use crate::trim::{FillRule, Keep, Segment, TrimLoop, Trims, ray_crossings};

/// The maximum number of rows, and the maximum number of entries of all rows together if every curve is in each
/// row.
const MAX_ROWS: usize = 512;
const MAX_ENTRIES: usize = 8_000_000;

/// The loops of a surface, their curves sorted into rows of the domain.
#[derive(Debug)]
pub(super) struct TrimRows<'a> {
    /// For each row, the curves that may cross it, each with the index of its fill rule, in ascending order.
    /// The first and the last row extend to infinity.
    rows: Vec<Vec<(usize, &'a Segment)>>,
    /// Minimum and maximum v of the rows.
    range: [f64; 2],
    /// The fill rules of the loops and of each path.
    rules: Vec<FillRule>,
    keep: Keep,
    /// Whether the loops cut anything.
    on: bool,
}

impl<'a> TrimRows<'a> {
    /// `range` is that of v.
    pub(super) fn new(trims: &'a Trims, range: [f64; 2]) -> Self {
        let count = trims.segment_count().max(1);
        let mut rows = vec![Vec::new(); (MAX_ENTRIES / count).clamp(1, MAX_ROWS.min(count))];
        for (number, fill) in trims.fills().enumerate() {
            for segment in fill.loops.iter().flat_map(TrimLoop::segments) {
                let heights = segment.points().iter().map(|point| point.y);
                let min = heights.clone().fold(f64::INFINITY, f64::min);
                let max = heights.fold(f64::NEG_INFINITY, f64::max);
                let [first, last] = [min, max].map(|v| row_of(v, range, rows.len()));
                for row in &mut rows[first..=last] {
                    row.push((number, segment));
                }
            }
        }
        let rules = trims.fills().map(|fill| fill.rule).collect();
        Self { rows, range, rules, keep: trims.keep, on: trims.loops_on && trims.has_loops() }
    }

    /// Whether the loops cut `uv`, decided as [`Trims::cut`] does.
    pub(super) fn cut(&self, uv: DVec2) -> bool {
        let row = &self.rows[row_of(uv.y, self.range, self.rows.len())];
        let inside = || {
            row.chunk_by(|(a, _), (b, _)| a == b).any(|filled| {
                let number = filled.iter().map(|(_, segment)| ray_crossings(segment, uv)).sum();
                self.rules[filled[0].0].fills(number)
            })
        };
        self.on && inside() != (self.keep == Keep::Inside)
    }
}

/// The row of `v`. It never decreases as `v` grows, so that a curve is in the rows of all its points.
fn row_of(v: f64, [low, high]: [f64; 2], rows: usize) -> usize {
    (((v - low) / (high - low) * rows as f64) as usize).min(rows - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;

    #[test]
    fn rows_decide_as_all_curves_do() {
        let path = std::path::Path::new("resources/scenes/gallery/lettering.toml");
        let scene = Scene::load(path).unwrap();
        for surface in &scene.surfaces {
            let mut trims = surface.trims.clone();
            for keep in [Keep::Outside, Keep::Inside] {
                trims.keep = keep;
                let rows = TrimRows::new(&trims, [0.0, 1.0]);
                let mut cut = 0;
                for i in 0..10_000 {
                    // This includes the rows of the curves' ends, and places beyond the domain.
                    let uv = DVec2::new(f64::from(i % 100), f64::from(i / 100)) / 90.0 - 0.05;
                    let expected = trims.cut(uv);
                    assert_eq!(trims.shapes_cut(uv) || rows.cut(uv), expected, "{uv}");
                    cut += i32::from(expected);
                }
                assert!(!trims.has_loops() || (100..9900).contains(&cut), "{cut}");
            }
        }
    }
}
