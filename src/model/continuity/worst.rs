//! The search for the largest values along an edge.

/// What is measured along an edge.
#[derive(Debug, Clone, Copy)]
pub(super) enum Measure {
    Gap,
    OffEdge,
    Angle,
    Jump,
    RelativeJump,
}

/// The number of measures.
pub(super) const MEASURES: usize = 5;

/// The values of all measures at one place; −∞ for what cannot be measured there.
pub(super) type Measures = [f64; MEASURES];

/// Places along an edge with their measures.
pub(super) struct Search<F> {
    samples: Vec<(f64, Measures)>,
    at: F,
}

impl<F: Fn(f64) -> Measures> Search<F> {
    /// Measures at rising places.
    pub(super) fn new(places: Vec<f64>, at: F) -> Self {
        Self { samples: places.into_iter().map(|t| (t, at(t))).collect(), at }
    }

    /// Where a measure is the largest, and its value. Differences below `noise` are none. `None` if it cannot be
    /// measured anywhere.
    pub(super) fn worst(&self, measure: Measure, noise: f64) -> Option<(f64, f64)> {
        let value = |i: usize| self.samples[i].1[measure as usize];
        let best = (0..self.samples.len()).max_by(|a, b| value(*a).total_cmp(&value(*b)))?;
        let found = (self.samples[best].0, value(best));
        let beside = [best.saturating_sub(1), (best + 1).min(self.samples.len() - 1)];
        let least = value(beside[0]).min(value(beside[1]));
        if found.1 == f64::NEG_INFINITY {
            return None;
        }
        if found.1 - least <= noise + 1e-7 * found.1 {
            return Some(found);
        }
        let of = |t: f64| (self.at)(t)[measure as usize];
        let refined = golden_section(of, beside.map(|i| self.samples[i].0));
        Some(if refined.1 > found.1 { refined } else { found })
    }
}

/// The place and the value of a maximum within a range, by the golden section.
fn golden_section(of: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> (f64, f64) {
    /// The range becomes 5·10⁻⁴ of its length, and the values near a smooth maximum are off by the square of that.
    const ROUNDS: usize = 16;
    const SHARE: f64 = 0.618_033_988_749_894_9;
    let within = |low: f64, high: f64| low + SHARE * (high - low);
    let with = |t: f64| (t, of(t));
    let (mut a, mut b) = (with(within(high, low)), with(within(low, high)));
    for _ in 0..ROUNDS {
        if a.1 > b.1 {
            high = b.0;
            b = a;
            a = with(within(high, low));
        } else {
            low = a.0;
            a = b;
            b = with(within(low, high));
        }
    }
    if a.1 > b.1 { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_value_between_samples_is_found() {
        let at = |t: f64| [1.0 - (t - 0.3217).powi(2), t, -t, f64::NEG_INFINITY, 5.0];
        let search = Search::new((0..=8).map(|i| f64::from(i) / 8.0).collect(), at);
        let (t, value) = search.worst(Measure::Gap, 0.0).unwrap();
        assert!((t - 0.3217).abs() < 1e-4 && (value - 1.0).abs() < 1e-8, "{t} {value}");
        assert_eq!(search.worst(Measure::OffEdge, 0.0), Some((1.0, 1.0)));
        assert_eq!(search.worst(Measure::Angle, 0.0), Some((0.0, 0.0)));
        assert_eq!(search.worst(Measure::Jump, 0.0), None);
        assert_eq!(search.worst(Measure::RelativeJump, 0.0).unwrap().1, 5.0);
    }
}
