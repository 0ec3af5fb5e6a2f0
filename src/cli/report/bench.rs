//! The measuring bench of the report: a context, its targets, and the folder of scenes.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::io::{Error, Result};
use freeform_surface::inspect::Timer;
use freeform_surface::inspect::measure::{
    Measurement, Timing, in_turns_by, measure, measure_drawn,
};
use freeform_surface::inspect::programs::Sources;
use freeform_surface::inspect::{DrawnVertex, reference};
use freeform_surface::inspect::{StaticMesh, StaticStyle};
use freeform_surface::{
    Aovs, FloatTarget, Frame, FrameStats, Framebuffer, Gl, Headless, Image, PreparedScene,
    Renderer, Scene, Trims,
};
use glam::{DMat4, DVec2, UVec2};
use indicatif::ProgressBar;

/// Measures scenes in pictures of one size.
pub(super) struct Bench {
    picture: Framebuffer,
    numbers: FloatTarget,
    renderer: Renderer,
    /// A renderer whose shaders do not cut trims.
    uncut: Renderer,
    /// The device's clock; `None` if the driver draws on the processor.
    timer: Option<Timer>,
    context: Headless,
    pub(super) size: (u32, u32),
    /// The number of repetitions from which the median is taken.
    pub(super) turns: usize,
    pub(super) quick: bool,
    resources: PathBuf,
    /// CAD models to measure beside the project's own.
    pub(super) models: Vec<PathBuf>,
    bar: ProgressBar,
}

/// Pixels for which the trim decision is wrong.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Wrong {
    pub(super) pixels: usize,
    /// The largest distance of a wrong pixel from the nearest pixel on the other side of the border, in pixels.
    /// It is 0 if no pixel is wrong, and `None` if the picture has no border.
    pub(super) distance: Option<f64>,
}

impl Bench {
    pub(super) fn new(
        context: Headless,
        sources: Sources,
        resources: PathBuf,
        quick: bool,
        bar: ProgressBar,
    ) -> Result<Self> {
        let size = if quick { (500, 300) } else { (1000, 600) };
        let uncut = ["common/trim.glsl", "thesis/trim.glsl"].into_iter().fold(
            Sources::default(),
            |sources, file| {
                sources.with_edit(
                    file,
                    "bool cut(vec2 uv)\n{",
                    "bool cut(vec2 uv)\n{\n    return false;",
                )
            },
        );
        let uncut = Renderer::with_sources(context.gl(), uncut)?;
        let renderer = Renderer::with_sources(context.gl(), sources)?;
        let is_software = context.info().is_software();
        let timer = if is_software { None } else { Some(Timer::new(context.gl())?) };
        Ok(Self {
            picture: Framebuffer::new(context.gl(), size.0, size.1)?,
            numbers: FloatTarget::for_aovs(&renderer, size)?,
            renderer,
            uncut,
            timer,
            context,
            size,
            turns: if quick { 5 } else { 9 },
            quick,
            resources,
            models: Vec::new(),
            bar,
        })
    }

    /// Changes the size of pictures.
    pub(super) fn resize(&mut self, size: (u32, u32)) -> Result<()> {
        self.picture = Framebuffer::new(self.context.gl(), size.0, size.1)?;
        self.numbers = FloatTarget::for_aovs(&self.renderer, size)?;
        self.size = size;
        Ok(())
    }

    /// The driver, for the first lines of the report.
    pub(super) fn driver(&self) -> String {
        let info = self.context.info();
        format!("{}, OpenGL {}", info.renderer, info.version)
    }

    /// The clock that measures the times, for the first lines of the report.
    pub(super) const fn clock(&self) -> &'static str {
        match self.timer {
            None => "the wall clock around a finished frame",
            Some(_) => {
                "what the processor or the device takes for a frame, whichever is longer: they work side \
                 by side"
            }
        }
    }

    /// Announces the number of steps of a section.
    pub(super) fn begin(&self, steps: usize) {
        self.bar.set_length(steps as u64);
        self.bar.set_position(0);
    }

    /// Announces the current step.
    pub(super) fn step(&self, what: impl Into<String>) {
        self.bar.set_message(what.into());
        self.bar.inc(1);
    }

    /// A scene or mesh, by its path in the folder of resources.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.resources.join(name)
    }

    pub(super) fn scene(&self, name: &str) -> Result<Scene> {
        Ok(Scene::load(&self.path(name))?)
    }

    /// The command that repeats the measurements of a section.
    pub(super) fn report_command(&self, section: &str) -> String {
        let quick = if self.quick { " --quick" } else { "" };
        format!("freeform report --only {section}{quick}")
    }

    /// The command that measures a scene by hand in a picture of this size.
    pub(super) fn command(&self, scene: &str, options: &str) -> String {
        let (width, height) = self.size;
        format!("freeform measure {scene} {options} --resolution {width}x{height}")
    }

    pub(super) fn frame(&self, scene: &Scene) -> Frame {
        Frame::of(scene, self.size)
    }

    /// The time of a frame of each scene while the camera moves from frame to frame.
    pub(super) fn time(&mut self, scenes: &[Scene]) -> Result<Vec<Timing>> {
        let mut prepared = Vec::with_capacity(scenes.len());
        for scene in scenes {
            prepared.push((self.prepare(scene)?, Moving::new(self.frame(scene))));
        }
        self.time_frames(scenes.len(), |renderer, number| {
            let (prepared, camera) = &mut prepared[number];
            Ok(prepared.draw(renderer, &camera.next()).map(drop)?)
        })
    }

    /// The times of frames; `draw` receives the frame's number. On drivers that share the processor's cores,
    /// this is the wall-clock time until the frame is finished. On others it is the longer of the processor's
    /// and the device's time for the frame, since they work in parallel.
    pub(super) fn time_frames(
        &mut self,
        count: usize,
        mut draw: impl FnMut(&mut Renderer, usize) -> Result<()>,
    ) -> Result<Vec<Timing>> {
        self.picture.bind();
        let gl = self.context.gl();
        let renderer = &mut self.renderer;
        let Some(timer) = &self.timer else {
            return in_turns_by(self.turns, count, |number| {
                let start = Instant::now();
                draw(renderer, number)?;
                gl.finish();
                Ok(start.elapsed())
            });
        };
        in_turns_by(self.turns, count, |number| {
            let mut told = Duration::ZERO;
            let drawn = timer.time(|| {
                let start = Instant::now();
                draw(renderer, number)?;
                told = start.elapsed();
                Result::<()>::Ok(())
            })?;
            Ok(told.max(drawn))
        })
    }

    /// The times of a scene's first picture by a new renderer: until everything is uploaded and planned, for the
    /// shaders, and for the frame without them. The shaders' is that of the first draw beyond that of the second.
    pub(super) fn first_picture(&self, scene: &Scene) -> Result<[Duration; 3]> {
        self.picture.bind();
        let gl = self.context.gl();
        let start = Instant::now();
        let frame = self.frame(scene);
        let mut renderer = Renderer::new(gl)?;
        let mut prepared = PreparedScene::new(&renderer, scene)?;
        prepared.prepare(&renderer, &frame)?;
        let uploaded = start.elapsed();
        let mut draw = || -> Result<Duration> {
            let start = Instant::now();
            let _ = prepared.draw(&mut renderer, &frame)?;
            gl.finish();
            Ok(start.elapsed())
        };
        let (first, second) = (draw()?, draw()?);
        Ok([uploaded, first.saturating_sub(second), second.min(first)])
    }

    /// The AOVs of a scene's picture, and its statistics.
    pub(super) fn numbers(&mut self, scene: &Scene) -> Result<(Aovs, FrameStats)> {
        let frame = self.frame(scene);
        let mut prepared = self.prepare(scene)?;
        let aovs = prepared.aovs(&mut self.renderer, &self.numbers, &frame)?;
        Ok((aovs, prepared.stats()))
    }

    /// The AOVs of a scene's picture through shaders that do not cut trims.
    fn uncut(&mut self, scene: &Scene) -> Result<Aovs> {
        let frame = self.frame(scene);
        Ok(self.prepare(scene)?.aovs(&mut self.uncut, &self.numbers, &frame)?)
    }

    /// The errors of a scene's picture, and the statistics of its frame.
    pub(super) fn errors(&mut self, scene: &Scene) -> Result<(Measurement, FrameStats)> {
        let (aovs, stats) = self.numbers(scene)?;
        let projection = self.frame(scene).camera;
        Ok((measure_drawn(scene, &projection, &aovs), stats))
    }

    /// The same, including pixels that are missing or should not be drawn.
    pub(super) fn errors_and_silhouette(
        &mut self,
        scene: &Scene,
    ) -> Result<(Measurement, FrameStats)> {
        let (aovs, stats) = self.numbers(scene)?;
        let projection = self.frame(scene).camera;
        let method = scene.settings.method;
        let coverage = reference::coverage(scene, &projection, UVec2::from(self.size), method)?;
        Ok((measure(scene, &projection, &aovs, &coverage), stats))
    }

    /// The pixels of a scene of one surface whose trim decision is wrong. The correct decision is that of the
    /// trims in `f64` at the (u, v) that the pixel shows. It is compared with whether the pixel is drawn.
    ///
    /// For a pixel that is cut, (u, v) comes from the same triangles drawn with shaders that do not cut. This
    /// also applies where something else shows through the cut. If the pixel is missing there too, the
    /// processor has left out its sub-patch as wholly cut. This is wrong if, in a picture without trims, the
    /// pixel and all pixels around it are kept. One such pixel alone may be due to the triangles: without trims
    /// the triangles are different, and lie up to the tolerance away.
    pub(super) fn wrong(&mut self, scene: &Scene) -> Result<Wrong> {
        let trims = &scene.surfaces[0].trims;
        let keeps = |[u, v, _, drawn]: &[f32; 4]| {
            (*drawn != 0.0).then(|| !trims.cut(DVec2::new(f64::from(*u), f64::from(*v))))
        };
        let kept = |aovs: &Aovs| aovs.uv.iter().map(keeps).collect::<Vec<_>>();
        let (left, all) = (self.numbers(scene)?.0, self.uncut(scene)?);
        let (mut drawn, uncut) = (kept(&left), kept(&all));
        for (drawn, (left, all)) in drawn.iter_mut().zip(left.uv.iter().zip(&all.uv)) {
            // Behind the cut, the pixel shows something else.
            drawn.take_if(|_| left.iter().zip(all).any(|(a, b)| (a - b).abs() > 1e-3));
        }
        let mut untrimmed = scene.clone();
        untrimmed.surfaces[0].trims = Trims::default();
        let whole = kept(&self.numbers(&untrimmed)?.0);
        Ok(wrong(&Kept { drawn, uncut, whole, width: self.size.0 as usize }))
    }

    /// The functions of the context, for objects that a section makes itself.
    pub(super) fn gl(&self) -> Gl {
        self.context.gl().clone()
    }

    /// A scene uploaded to the driver's memory.
    pub(super) fn prepare(&self, scene: &Scene) -> Result<PreparedScene> {
        Ok(PreparedScene::new(&self.renderer, scene)?)
    }

    /// How far static triangles are from the surfaces of the scene that they replace.
    pub(super) fn static_errors(
        &mut self,
        mesh: &StaticMesh,
        style: &StaticStyle<'_>,
        scene: &Scene,
    ) -> Result<Measurement> {
        let frame = self.frame(scene);
        let aovs = self.renderer.static_aovs(mesh, style, &self.numbers, &frame)?;
        Ok(measure_drawn(scene, &frame.camera, &aovs))
    }

    /// A picture of static triangles in the view and the style of a scene, and its AOVs.
    pub(super) fn static_picture(
        &mut self,
        mesh: &StaticMesh,
        style: &StaticStyle<'_>,
        scene: &Scene,
    ) -> Result<(Image, Aovs)> {
        let frame = self.frame(scene);
        let aovs = self.renderer.static_aovs(mesh, style, &self.numbers, &frame)?;
        self.picture.bind();
        self.renderer.clear(frame.settings.background);
        self.renderer.draw_static(mesh, style, &frame)?;
        Ok((self.picture.read(), aovs))
    }

    /// The corners of the triangles that a scene is drawn with.
    pub(super) fn triangles(&mut self, scene: &Scene) -> Result<Vec<DrawnVertex>> {
        self.picture.bind();
        let frame = self.frame(scene);
        Ok(self.prepare(scene)?.triangles(&mut self.renderer, &frame)?)
    }

    /// A scene's picture.
    pub(super) fn picture(&mut self, scene: &Scene) -> Result<Image> {
        self.picture.bind();
        let frame = self.frame(scene);
        let _ = self.prepare(scene)?.draw(&mut self.renderer, &frame)?;
        Ok(self.picture.read())
    }

    /// Fails if the driver has reported an error since the last call. It may then have drawn nothing, and its
    /// times would be too short.
    pub(super) fn check_driver(&self) -> Result<()> {
        match self.context.debug_log().take_errors().into_iter().next() {
            None => Ok(()),
            Some(reason) => Err(Error::Driver { what: "a section".into(), reason }),
        }
    }
}

/// A camera that turns back and forth by an eighth of a degree per frame. Every frame has another view, and the
/// visible part stays in the picture.
#[derive(Debug, Clone)]
pub(super) struct Moving {
    start: Frame,
    frames: u32,
}

impl Moving {
    /// Number of frames in one direction.
    const WAY: u32 = 8;

    pub(super) const fn new(start: Frame) -> Self {
        Self { start, frames: 0 }
    }

    pub(super) fn next(&mut self) -> Frame {
        self.frames += 1;
        let place = self.frames % (2 * Self::WAY);
        let steps = place.min(2 * Self::WAY - place);
        let turn = DMat4::from_rotation_y(f64::from(steps) * 0.125_f64.to_radians());
        let mut frame = self.start;
        frame.camera.view = turn * frame.camera.view;
        frame
    }
}

/// For each pixel, whether the trims keep the (u, v) that it shows, decided in `f64`; `None` where nothing is
/// drawn.
struct Kept {
    /// For the picture as it is drawn.
    drawn: Vec<Option<bool>>,
    /// For the same triangles through shaders that do not cut trims.
    uncut: Vec<Option<bool>>,
    /// For the scene without trims.
    whole: Vec<Option<bool>>,
    width: usize,
}

fn wrong(Kept { drawn, uncut, whole, width }: &Kept) -> Wrong {
    let width = *width;
    let height = whole.len() / width;
    let row = |i: usize| {
        let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        (around(i / width, height), around(i % width, width))
    };
    let all_around = |i: usize, decision: bool| {
        let (rows, columns) = row(i);
        rows.flat_map(|y| columns.clone().map(move |x| y * width + x))
            .all(|near| whole[near] == Some(decision))
    };
    let place = |i: usize| DVec2::new((i % width) as f64, (i / width) as f64);
    // The pixels next to a border, by the side of it that they are on.
    let beside = |decision: bool| -> Vec<DVec2> {
        let own = (0..whole.len()).filter(|i| whole[*i] == Some(decision));
        own.filter(|i| !all_around(*i, decision)).map(place).collect()
    };
    let beside = [beside(false), beside(true)];
    let mut all = Wrong { pixels: 0, distance: Some(0.0) };
    for i in 0..whole.len() {
        let own = match (drawn[i], uncut[i]) {
            (Some(kept), _) => (!kept).then_some(false),
            (None, Some(kept)) => kept.then_some(true),
            (None, None) => all_around(i, true).then_some(true),
        };
        let Some(own) = own else { continue };
        let others = &beside[usize::from(!own)];
        let nearest = others.iter().map(|at| at.distance_squared(place(i))).min_by(f64::total_cmp);
        all.pixels += 1;
        all.distance = all.distance.zip(nearest).map(|(max, near)| max.max(near.sqrt()));
    }
    all
}

/// Marks in red where two pictures differ by more than a shade; elsewhere shows the first picture, paler.
pub(super) fn difference(a: &Image, b: &Image) -> Image {
    let mut image = a.clone();
    for (pixel, other) in image.pixels_mut().zip(b.pixels()) {
        let differs = pixel.0.iter().zip(other.0).any(|(a, b)| a.abs_diff(b) > 8);
        pixel.0 = if differs {
            [220, 0, 30, 255]
        } else {
            let [red, green, blue, _] = pixel.0.map(|channel| 170 + channel / 4);
            [red, green, blue, 255]
        };
    }
    image
}

/// Whether a folder has the scenes that the report needs.
pub(super) fn check_resources(folder: &Path) -> Result<()> {
    if folder.join("scenes/thesis/fig22.toml").is_file() {
        return Ok(());
    }
    Err(Error::file(
        "read",
        folder,
        "it does not hold the project's scenes; expected its folder \"resources\", see \
                 --resources",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_that_was_moved() {
        // Of every ten columns, columns 0 to 4 are kept.
        let whole: Vec<_> = (0..30).map(|i| Some(i % 10 < 5)).collect();
        let drawn = |columns: usize| (0..30).map(move |i| (i % 10 < columns).then_some(i % 10 < 5));
        let found = |columns| {
            let (drawn, uncut) = (drawn(columns).collect(), whole.clone());
            wrong(&Kept { drawn, uncut, whole: whole.clone(), width: 10 })
        };
        assert_eq!(found(5), Wrong { pixels: 0, distance: Some(0.0) });
        assert_eq!(found(7), Wrong { pixels: 6, distance: Some(2.0) });
        assert_eq!(found(4), Wrong { pixels: 3, distance: Some(1.0) });
        assert_eq!(found(2), Wrong { pixels: 9, distance: Some(3.0) });
    }

    #[test]
    fn parts_that_are_left_out_wrongly_are_found_and_no_border_has_no_distance() {
        let whole = vec![Some(true); 30];
        let drawn: Vec<_> = (0..30).map(|i| (i % 10 < 6).then_some(true)).collect();
        let found = wrong(&Kept { uncut: drawn.clone(), drawn, whole, width: 10 });
        assert_eq!(found, Wrong { pixels: 12, distance: None });
    }

    #[test]
    fn the_camera_never_rests_and_comes_back() {
        let scene = Scene::listing16();
        let start = Frame::of(&scene, (8, 8));
        let mut camera = Moving::new(start);
        let mut last = start;
        for number in 1..=32 {
            let next = camera.next();
            assert!(next.camera.view != last.camera.view, "{number}");
            assert_eq!(next.camera.view == start.camera.view, number % 16 == 0);
            last = next;
        }
    }

    #[test]
    fn a_difference_is_red_where_pictures_differ() {
        let grey = Image::from_pixel(2, 1, image::Rgba([100, 100, 100, 255]));
        let mut other = grey.clone();
        other.put_pixel(1, 0, image::Rgba([100, 120, 100, 255]));
        let difference = difference(&grey, &other);
        assert_eq!(difference.get_pixel(0, 0).0, [195, 195, 195, 255]);
        assert_eq!(difference.get_pixel(1, 0).0, [220, 0, 30, 255]);
    }
}
