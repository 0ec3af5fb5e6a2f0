//! The exact decision at many samples: the `f64` oracle, row by row, so that each row is tested only against
//! the curves that it meets.

use freeform_surface::inspect::{TrimGrid, ray_crossings};
use freeform_surface::{FillRule, Keep, Segment, TrimLoop, Trims};
use glam::{DVec2, Vec2, dvec2};

/// The distance from a curve within which a sample may be decided either way, in units of the domain.
pub const EITHER_WAY: f64 = 2e-7;

/// The centres of `side` × `side` pixels.
pub fn centers(side: u32) -> Vec<f64> {
    (0..side).map(|i| (f64::from(i) + 0.5) / f64::from(side)).collect()
}

/// The curves that one row of samples meets.
pub struct Row<'a> {
    trims: &'a Trims,
    v: f64,
    /// The fill rule and the curves of the loops, then of each path.
    fills: Vec<(FillRule, Vec<&'a Segment>)>,
}

impl<'a> Row<'a> {
    pub fn new(trims: &'a Trims, v: f64) -> Self {
        let meets = |segment: &&Segment| {
            let points = segment.points();
            points.iter().any(|p| p.y <= v) && points.iter().any(|p| p.y >= v)
        };
        let of = |loops: &'a [TrimLoop]| {
            loops.iter().flat_map(|one| one.segments()).filter(meets).collect()
        };
        let mut fills = vec![(FillRule::EvenOdd, of(&trims.loops))];
        fills.extend(trims.paths.iter().map(|path| (path.rule, of(&path.loops))));
        Self { trims, v, fills }
    }

    /// Whether the sample at `u` is cut.
    pub fn cut(&self, u: f64) -> bool {
        let uv = dvec2(u, self.v);
        let inside = self.fills.iter().any(|(rule, segments)| {
            let number: i32 = segments.iter().map(|segment| ray_crossings(segment, uv)).sum();
            match rule {
                FillRule::EvenOdd => number.rem_euclid(2) == 1,
                FillRule::NonZero => number != 0,
            }
        });
        let loops = self.trims.loops_on && self.trims.has_loops();
        self.trims.shapes_cut(uv) || loops && inside != (self.trims.keep == Keep::Inside)
    }
}

/// Whether the decision changes within `radius` of a sample.
pub fn changes_within(trims: &Trims, uv: DVec2, radius: f64) -> bool {
    let here = Row::new(trims, uv.y).cut(uv.x);
    (0..32).map(|i| f64::from(i) * std::f64::consts::TAU / 32.0).any(|angle| {
        [1.0, 0.5, 0.2].into_iter().any(|part| {
            let other = uv + DVec2::from_angle(angle) * (radius * part);
            Row::new(trims, other.y).cut(other.x) != here
        })
    })
}

/// Counts the samples that are decided wrongly and are further than [`EITHER_WAY`] from a curve. `decided` has
/// the samples row by row, for the rows `vs` and the columns `us`.
pub fn count_wrong(trims: &Trims, us: &[f64], vs: &[f64], decided: &[bool]) -> usize {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let band = vs.len().div_ceil(threads).max(1);
    std::thread::scope(|scope| {
        let bands: Vec<_> = vs
            .chunks(band)
            .zip(decided.chunks(band * us.len()))
            .map(|(vs, decided)| scope.spawn(move || wrong_in_band(trims, us, vs, decided)))
            .collect();
        bands.into_iter().map(|band| band.join().expect("a band of rows")).sum()
    })
}

fn wrong_in_band(trims: &Trims, us: &[f64], vs: &[f64], decided: &[bool]) -> usize {
    let mut wrong = 0;
    for (v, decided) in vs.iter().zip(decided.chunks(us.len())) {
        let row = Row::new(trims, *v);
        for (u, decided) in us.iter().zip(decided) {
            if row.cut(*u) != *decided && !changes_within(trims, dvec2(*u, *v), EITHER_WAY) {
                wrong += 1;
            }
        }
    }
    wrong
}

/// The number of wrong decisions of the compiled trims on the CPU.
pub fn count_wrong_of_grid(trims: &Trims, grid: &TrimGrid, us: &[f32], vs: &[f32]) -> usize {
    let decided: Vec<bool> =
        vs.iter().flat_map(|v| us.iter().map(|u| grid.cut(Vec2::new(*u, *v)))).collect();
    let [us, vs] = [us, vs].map(|values| values.iter().map(|x| f64::from(*x)).collect::<Vec<_>>());
    count_wrong(trims, &us, &vs, &decided)
}
