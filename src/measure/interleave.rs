//! The cost of several tasks, measured alternately because machines are noisy.

use std::time::{Duration, Instant};

/// The time that a task took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Timing {
    /// The median, in milliseconds.
    pub ms: f64,
    /// The interquartile range, divided by the median.
    pub spread: f64,
}

impl Timing {
    /// The statistics of some durations.
    ///
    /// # Panics
    /// Without any duration.
    #[must_use]
    pub fn of(mut times: Vec<Duration>) -> Self {
        times.sort_unstable();
        let at = |share: usize| times[share * (times.len() - 1) / 4].as_secs_f64() * 1e3;
        Self { ms: at(2), spread: (at(3) - at(1)) / at(2).max(f64::MIN_POSITIVE) }
    }
}

/// Runs several tasks alternately, once to warm up and then `turns` times, and returns the wall-clock time of
/// each.
///
/// # Errors
/// The first error of a task.
pub fn in_turns<E>(
    turns: usize,
    things: &mut [&mut dyn FnMut() -> Result<(), E>],
) -> Result<Vec<Timing>, E> {
    in_turns_by(turns, things.len(), |thing| {
        let start = Instant::now();
        things[thing]()?;
        Ok(start.elapsed())
    })
}

/// Like [`in_turns`], with a clock of the caller's: `one` runs the task with the given number and returns the
/// time that it took.
///
/// # Errors
/// The first error of a task.
pub fn in_turns_by<E>(
    turns: usize,
    things: usize,
    mut one: impl FnMut(usize) -> Result<Duration, E>,
) -> Result<Vec<Timing>, E> {
    for thing in 0..things {
        one(thing)?;
    }
    let mut times = vec![Vec::with_capacity(turns); things];
    for _ in 0..turns.max(1) {
        for (thing, times) in times.iter_mut().enumerate() {
            times.push(one(thing)?);
        }
    }
    Ok(times.into_iter().map(Timing::of).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_quartiles() {
        let times = [9, 1, 5, 3, 7].map(Duration::from_millis).to_vec();
        assert_eq!(Timing::of(times), Timing { ms: 5.0, spread: 0.8 });
    }

    #[test]
    fn all_take_turns() {
        let order = std::cell::RefCell::new(String::new());
        let mut a = || {
            order.borrow_mut().push('a');
            Ok::<(), ()>(())
        };
        let mut b = || {
            order.borrow_mut().push('b');
            Ok(())
        };
        assert_eq!(in_turns(2, &mut [&mut a, &mut b]).unwrap().len(), 2);
        assert_eq!(*order.borrow(), "ababab");
    }
}
