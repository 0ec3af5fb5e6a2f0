//! The measuring method of the benches: alternately and by medians, because machines are noisy.
#![allow(unreachable_pub, reason = "every bench is a crate that uses this")]

use std::convert::Infallible;

use freeform_surface::inspect::measure;

const TURNS: usize = 15;

/// The medians of several kinds of frames, measured alternately, in milliseconds.
pub fn in_turns(frames: &mut [&mut dyn FnMut()]) -> Vec<f64> {
    let mut frames: Vec<_> = frames
        .iter_mut()
        .map(|frame| {
            || {
                frame();
                Ok::<(), Infallible>(())
            }
        })
        .collect();
    let mut things: Vec<_> =
        frames.iter_mut().map(|frame| frame as &mut dyn FnMut() -> _).collect();
    let timings = measure::in_turns(TURNS, &mut things).expect("frames do not fail");
    timings.into_iter().map(|timing| timing.ms).collect()
}

/// Prints a measured value, and the limit under which it should stay.
pub fn line(what: &str, value: f64, bar: &str) {
    println!("{what:66} {value:10.3}   {bar}");
}
