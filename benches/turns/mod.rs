//! How the benches measure: in turns and by medians, because machines are noisy.
#![allow(unreachable_pub, reason = "every bench is a crate that uses this")]

use std::time::{Duration, Instant};

const TURNS: usize = 15;

fn median(mut times: Vec<Duration>) -> f64 {
    times.sort_unstable();
    times[times.len() / 2].as_secs_f64() * 1e3
}

/// Medians of several frames in turns, in milliseconds.
pub fn in_turns(frames: &mut [&mut dyn FnMut()]) -> Vec<f64> {
    for frame in frames.iter_mut() {
        frame();
    }
    let mut times = vec![Vec::new(); frames.len()];
    for _ in 0..TURNS {
        for (frame, times) in frames.iter_mut().zip(&mut times) {
            let start = Instant::now();
            frame();
            times.push(start.elapsed());
        }
    }
    times.into_iter().map(median).collect()
}

/// Prints what was measured, and the bar that it should stay under.
pub fn line(what: &str, value: f64, bar: &str) {
    println!("{what:66} {value:10.3}   {bar}");
}
