//! What zebra, isophotes, curvature and draft cost: frames at 1920 × 1080 against lit ones, in turns.
//!
//! `cargo bench --bench shading`

use std::path::Path;
use std::time::Instant;

use freeform_surface::inspect::measure::in_turns_by;
use freeform_surface::{AnalysisKind, Error, Frame, Offscreen, PreparedScene, Scene};

const FRAMES: u32 = 6;
const SIZE: (u32, u32) = (1920, 1080);

fn main() -> Result<(), Error> {
    let resources = Path::new(env!("CARGO_MANIFEST_DIR")).join("resources");
    for name in
        ["surfaces/teapot.bpt", "models/blade.ffm", "models/flange.ffm", "models/assembly.ffm"]
    {
        let scene = Scene::load(&resources.join(name))?;
        let mut offscreen = Offscreen::new(SIZE.0, SIZE.1)?;
        let mut prepared = PreparedScene::new(offscreen.renderer(), &scene)?;
        let shown = [None].into_iter().chain(AnalysisKind::ALL.map(Some));
        let frames: Vec<Frame> = shown
            .map(|kind| {
                let mut frame = Frame::of(&scene, SIZE);
                frame.settings.analysis = kind.map(AnalysisKind::with_defaults);
                frame
            })
            .collect();
        let timings = in_turns_by(9, frames.len(), |number| {
            let start = Instant::now();
            for _ in 0..FRAMES {
                offscreen.target().bind();
                let _ = prepared.draw(offscreen.renderer_mut(), &frames[number])?;
                offscreen.context().gl().finish();
            }
            Ok::<_, Error>(start.elapsed() / FRAMES)
        })?;
        let ratio = |number: usize| timings[number].ms / timings[0].ms;
        let ratios: Vec<String> = AnalysisKind::ALL
            .iter()
            .enumerate()
            .map(|(number, kind)| format!("{} {:.2}", kind.name(), ratio(number + 1)))
            .collect();
        println!("{name}: lit {:.1} ms; {}", timings[0].ms, ratios.join(", "));
    }
    Ok(())
}
