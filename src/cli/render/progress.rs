//! How far many pictures are: a bar on a terminal, a line now and then elsewhere.

use std::time::{Duration, Instant};

use indicatif::{HumanDuration, ProgressBar, ProgressStyle};

/// The time between two lines.
const BETWEEN_LINES: Duration = Duration::from_secs(10);

pub(super) struct Progress {
    bar: ProgressBar,
    start: Instant,
    last_line: Instant,
    total: u64,
    done: u64,
}

impl Progress {
    pub(super) fn new(total: usize) -> Self {
        let bar = ProgressBar::new(total as u64);
        if let Ok(style) =
            ProgressStyle::with_template("{bar:40} {pos}/{len}, {per_sec}, {eta} left")
        {
            bar.set_style(style);
        }
        let now = Instant::now();
        Self { bar, start: now, last_line: now, total: total as u64, done: 0 }
    }

    /// Prints lines while the bar is out of the way.
    pub(super) fn print<T>(&self, print: impl FnOnce() -> T) -> T {
        self.bar.suspend(print)
    }

    /// One more picture is done.
    pub(super) fn step(&mut self) {
        self.done += 1;
        self.bar.inc(1);
        let is_time = self.last_line.elapsed() >= BETWEEN_LINES && self.done < self.total;
        if self.bar.is_hidden() && is_time {
            self.last_line = Instant::now();
            eprintln!("freeform: {}", self.line());
        }
    }

    fn line(&self) -> String {
        let Self { done, total, .. } = *self;
        let rate = done as f64 / self.start.elapsed().as_secs_f64();
        let left = Duration::from_secs_f64((total - done) as f64 / rate);
        format!("{done} of {total} pictures, {rate:.1} a second, {} left", HumanDuration(left))
    }

    /// Removes the bar, and returns the time since the start.
    pub(super) fn finish(self) -> Duration {
        self.bar.finish_and_clear();
        self.start.elapsed()
    }
}
