//! Section 7: CAD models, from the file to the picture, beside OCCT's mesh and F3D.

mod files;
mod findings;

use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::io::Result;
use freeform_surface::inspect::measure::Timing;
use freeform_surface::inspect::programs::TrimFeatures;
use freeform_surface::inspect::{StaticMesh, StaticStyle};
use freeform_surface::model::{Model, is_cad_file};
use freeform_surface::{
    Frame, LoadOptions, Method, Paint, Scene, Shading, Tessellation, Tolerance,
};

use super::bench::{Bench, Moving};
use super::peers::{STATIC, f3d, indexed, occt, process};
use super::plot::{Line, plot};
use super::row::Row;
use super::{Figure, Section};
use files::{Files, Subject};
pub(super) use findings::first_lines;

/// Size of the views in pixels.
const SIZE: (u32, u32) = (1920, 1080);
/// The tolerance, in pixels, at which others are compared.
const HALF: f64 = 0.5;

const EXACT: &str = "exact";
/// What the processor does for a new view before it draws.
const PLAN: &str = "exact: plan";
/// From the file to the first picture, in this process.
const FIRST: &str = "first picture";
/// The same for the model of a STEP, IGES or BREP file in the project's own format.
const FIRST_OWN: &str = "first picture from .ffm";
/// The parts of a first picture.
const PARTS: [&str; 5] = ["reading", "projection", "upload", "shaders", "frame"];
/// `freeform render` as a program of its own.
const PROGRAM: &str = "the program";
const PROGRAM_OWN: &str = "the program from .ffm";
const OCCT: &str = "OCCT mesh";
const F3D: &str = "F3D";
const F3D_LOAD: &str = "F3D: load";
const F3D_FIRST: &str = "F3D: first picture";

pub(super) fn section(bench: &mut Bench) -> Result<Section> {
    let mut section = Section::new(
        "models",
        "Models: CAD files from the file to the picture",
        "Models of CAD systems, framed. Frames have a moving camera; the static mesh is made of the exact method's own \
         triangles for half a pixel, without trims; the plan is what the processor does for a new view. The first picture is that of a new renderer with the driver's cache \
         of shaders; upload includes the search for neighbours and the plan of the first frame, shaders are what the \
         first draw takes longer than the second. The program is `freeform render` from its start to its end; its memory \
         is the most that it holds. OCCT meshes the file with a deflection of half a pixel at the model's nearest point; \
         its error is the largest distance of a surface from the planes of its triangles, at the middles of triangles \
         and sides, or of an edge's curve from its lines, in pixels there. F3D meshes when it loads, as finely as its \
         settings say, and has effects switched off; the start of its program and context are not counted.",
    );
    let files = Files::new()?;
    let subjects = files.subjects(bench)?;
    for subject in &subjects {
        let caption = subject.name.clone();
        let image = bench.picture(&subject.scene)?;
        section.figures.push(Figure { caption, image });
    }
    let size = bench.size;
    if !bench.quick {
        bench.resize(SIZE)?;
    }
    let measured = measure(bench, &files, &subjects, &mut section);
    bench.resize(size)?;
    measured?;
    Ok(section)
}

/// Programs beside which files are measured, or why they are not.
struct Others {
    f3d: Result<String, String>,
    occt: Result<PathBuf, String>,
}

fn measure(
    bench: &mut Bench,
    files: &Files,
    subjects: &[Subject],
    section: &mut Section,
) -> Result<()> {
    let others = Others { f3d: f3d::version(), occt: occt::helper() };
    bench.begin(2 * subjects.len());
    for subject in subjects {
        bench.step(format!("models: frames of {}", subject.name));
        section.rows.extend(frames(bench, subject)?);
        bench.step(format!("models: first pictures of {}", subject.name));
        section.rows.extend(first_pictures(bench, files, subject, &others)?);
    }
    section.rows.extend(missing(&others, subjects));
    let lines: Vec<Line> = subjects
        .iter()
        .map(|Subject { name, .. }| {
            let of = section.rows.iter().filter(|row| row.scene == *name && row.method == EXACT);
            let points = of.filter_map(|row| row.ms.zip(row.max_error_px)).collect();
            Line { name: name.clone(), points }
        })
        .collect();
    let title = "Models: largest error over time; the line across is 0.5 px";
    let svg = plot("milliseconds a frame", "largest error, pixels", &lines, Some(HALF))?;
    section.plots.push((title.into(), svg));
    section.findings = findings::findings(&section.rows);
    Ok(())
}

/// Rows that say why others are not measured.
fn missing(others: &Others, subjects: &[Subject]) -> Vec<Row> {
    let no_file = || {
        let is_there = subjects.iter().any(|subject| is_cad_file(&subject.path));
        (!is_there).then(|| "no STEP, IGES or BREP file is given (--model FILE)".to_owned())
    };
    let row = |name: &str, reason: Option<String>| {
        let note = Some(format!("not measured: {}", reason?));
        Some(Row { note, ..Row::new("models", "all", name) })
    };
    let reasons = [
        (F3D, others.f3d.as_ref().err().cloned().or_else(no_file)),
        (OCCT, others.occt.as_ref().err().cloned().or_else(no_file)),
    ];
    reasons.into_iter().filter_map(|(name, reason)| row(name, reason)).collect()
}

fn within(scene: &Scene, tolerance: f64) -> Result<Scene> {
    let mut scene = scene.clone();
    scene.settings.method = Method::Exact;
    scene.settings.samples = Default::default();
    scene.settings.tessellation = Tessellation::Within(Tolerance::new(tolerance)?);
    Ok(scene)
}

/// Frames by tolerance and of a static mesh, measured alternately.
fn frames(bench: &mut Bench, subject: &Subject) -> Result<Vec<Row>> {
    let tolerances: &[f64] = if bench.quick { &[2.0, HALF] } else { &[2.0, 1.0, HALF, 0.25] };
    let loaded = &subject.scene;
    let scenes =
        tolerances.iter().map(|pixels| within(loaded, *pixels)).collect::<Result<Vec<_>>>()?;
    let frame = bench.frame(loaded);
    let (vertices, indices) = indexed(&bench.triangles(&within(loaded, HALF)?)?, frame.camera.view);
    let gl = bench.gl();
    let still = StaticMesh::new(&gl, &vertices, &indices)?;
    let texture = Paint::default().upload(&gl)?;
    let style = StaticStyle {
        method: Method::Exact,
        shading: Shading::Phong,
        trims: TrimFeatures::NONE,
        texture: &texture,
    };
    let mut prepared = Vec::with_capacity(scenes.len());
    for scene in &scenes {
        prepared.push((bench.prepare(scene)?, Moving::new(bench.frame(scene))));
    }
    let mut planned = (bench.prepare(&within(loaded, HALF)?)?, Moving::new(frame));
    let mut camera = Moving::new(frame);
    let background = loaded.settings.background;
    let timings = bench.time_frames(scenes.len() + 2, |renderer, way| {
        if let Some((prepared, camera)) = prepared.get_mut(way) {
            return Ok(prepared.draw(renderer, &camera.next()).map(drop)?);
        }
        if way == scenes.len() {
            let (prepared, camera) = &mut planned;
            return Ok(prepared.prepare(renderer, &camera.next())?);
        }
        renderer.clear(background);
        Ok(renderer.draw_static(&still, &style, &camera.next())?)
    })?;
    let mut rows = Vec::with_capacity(timings.len());
    for ((scene, tolerance), timing) in scenes.iter().zip(tolerances).zip(&timings) {
        let (errors, stats) = bench.errors(scene)?;
        rows.push(Row {
            tolerance: Some(*tolerance),
            patches: Some(stats.patches),
            command: command_of(bench, subject, *tolerance),
            ..row(subject, EXACT).timed(*timing).measured(&errors, stats.triangles)
        });
    }
    let command = bench.report_command("models");
    let others = timings[scenes.len()..].iter().zip([PLAN, STATIC]);
    rows.extend(others.map(|(timing, method)| Row {
        tolerance: Some(HALF),
        triangles: (method == STATIC).then_some(still.triangles() as u64),
        command: command.clone(),
        ..row(subject, method).timed(*timing)
    }));
    Ok(rows)
}

/// The command that measures a subject by hand; the large model is no file that stays.
fn command_of(bench: &Bench, subject: &Subject, tolerance: f64) -> String {
    if subject.is_made {
        return bench.report_command("models");
    }
    bench.command(&subject.path.display().to_string(), &format!("--tolerance {tolerance}"))
}

fn row(subject: &Subject, method: impl Into<String>) -> Row {
    Row::new("models", &subject.name, method)
}

/// The times of one thing in all turns.
#[derive(Debug, Default)]
struct Times {
    row: Row,
    all: Vec<Duration>,
}

/// Rows and their times, in the order in which they were first measured.
#[derive(Debug, Default)]
struct Turns(Vec<Times>);

impl Turns {
    /// Adds a time to the row of the same method. What the row says besides is that of the last turn.
    fn add(&mut self, row: Row, time: Duration) {
        let known = self.0.iter_mut().find(|times| times.row.method == row.method);
        match known {
            Some(times) => {
                times.row = row;
                times.all.push(time);
            }
            None => self.0.push(Times { row, all: vec![time] }),
        }
    }

    /// The rows with the medians of their times. The first turn warms up, if there are several.
    fn rows(self) -> Vec<Row> {
        let timed = |Times { row, mut all }: Times| {
            if all.len() > 1 {
                all.remove(0);
            }
            row.timed(Timing::of(all))
        };
        self.0.into_iter().map(timed).collect()
    }
}

fn ms(milliseconds: f64) -> Duration {
    Duration::try_from_secs_f64(milliseconds / 1e3).unwrap_or_default()
}

/// First pictures by this program, as a part of this process and alone, and by others, in turns.
fn first_pictures(
    bench: &mut Bench,
    files: &Files,
    subject: &Subject,
    others: &Others,
) -> Result<Vec<Row>> {
    let is_cad = is_cad_file(&subject.path);
    let mut ways = vec![(FIRST, PROGRAM, subject.path.clone())];
    if is_cad {
        let model = &subject.scene.models[0].model;
        ways.push((FIRST_OWN, PROGRAM_OWN, files.write("converted.ffm", model)?));
    }
    let pixel = pixel(&subject.scene, &bench.frame(&subject.scene));
    let mut turns = Turns::default();
    let mut notes = Vec::new();
    // The first turn is no measurement.
    for turn in 0..if bench.quick { 1 } else { 4 } {
        for (first, program, path) in &ways {
            in_process(bench, subject, first, path, &mut turns)?;
            alone(bench, subject, program, path, &mut turns);
        }
        if !is_cad || !notes.is_empty() {
            continue;
        }
        if others.f3d.is_ok() {
            let frames = if bench.quick { 3 } else { 9 };
            match f3d::show(&subject.path, bench.size, frames) {
                Err(reason) => notes.push(failed(subject, F3D, &reason)),
                Ok(shown) => {
                    let memory = shown.memory;
                    turns.add(row(subject, F3D_LOAD), ms(shown.load));
                    turns.add(
                        Row { memory, ..row(subject, F3D_FIRST) },
                        ms(shown.load + shown.first),
                    );
                    turns.add(row(subject, F3D), ms(shown.frame));
                }
            }
        }
        if let Ok(helper) = &others.occt {
            match occt::mesh(helper, &subject.path, HALF * pixel) {
                Err(reason) => notes.push(failed(subject, OCCT, &reason)),
                Ok(meshed) => {
                    let made = Row {
                        tolerance: Some(HALF),
                        triangles: Some(meshed.triangles),
                        max_error_px: Some(meshed.distance / pixel),
                        max_error: Some(meshed.distance),
                        ..row(subject, OCCT)
                    };
                    turns.add(made, ms(meshed.ms));
                }
            }
        }
        log::debug!("models: turn {turn} of {}", subject.name);
    }
    let command = bench.report_command("models");
    let rows = turns.rows().into_iter().chain(notes);
    Ok(rows.map(|row| Row { command: command.clone(), ..row }).collect())
}

fn failed(subject: &Subject, method: &str, reason: &str) -> Row {
    Row { note: Some(format!("failed: {reason}")), ..row(subject, method) }
}

/// From the file to the first picture, in parts.
fn in_process(
    bench: &Bench,
    subject: &Subject,
    method: &str,
    path: &Path,
    turns: &mut Turns,
) -> Result<()> {
    let start = std::time::Instant::now();
    let model = Model::load(path, &LoadOptions::default())?;
    let read = start.elapsed();
    let scene = Scene::from_model(model, path)?;
    let projected = start.elapsed() - read;
    let scene = within(&scene, HALF)?;
    let [uploaded, shaders, frame] = bench.first_picture(&scene)?;
    let parts = [read, projected, uploaded, shaders, frame];
    turns.add(row(subject, method), parts.iter().sum());
    for (part, time) in PARTS.iter().zip(parts) {
        turns.add(row(subject, format!("{method}: {part}")), time);
    }
    Ok(())
}

/// `freeform render` with its own process, if this program is it.
fn alone(bench: &Bench, subject: &Subject, method: &str, path: &Path, turns: &mut Turns) {
    let Ok(program) = std::env::current_exe() else { return };
    let (width, height) = bench.size;
    let mut command = std::process::Command::new(program);
    command.arg("render").arg(path).args(["-o", "-", "--resolution"]);
    command.arg(format!("{width}x{height}"));
    match process::run(&mut command) {
        Ok(ended) => turns.add(Row { memory: ended.memory, ..row(subject, method) }, ended.time),
        Err(reason) => log::warn!("{method} of {}: {reason}", subject.name),
    }
}

/// The size of a pixel in the model's unit, at the point of the model that is nearest to the eye.
fn pixel(scene: &Scene, frame: &Frame) -> f64 {
    let clip = frame.camera.projection * frame.camera.view;
    let points = scene.surfaces.iter().flat_map(|surface| surface.world_points());
    let nearest = points.map(|point| (clip * point.extend(1.0)).w).fold(f64::INFINITY, f64::min);
    let height = f64::from(frame.viewport.size.y);
    2.0 * nearest / (frame.camera.projection.y_axis.y * height)
}
