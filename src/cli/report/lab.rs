//! Where things are measured: a context, its targets, and the folder of scenes.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use freeform_surface::gpu::{self, FloatTarget, Framebuffer, Timer};
use freeform_surface::measure::{Measurement, Timing, in_turns_by, measure, measure_drawn};
use freeform_surface::renderer::programs::Sources;
use freeform_surface::renderer::{StaticLook, StaticMesh};
use freeform_surface::{
    Aovs, DrawnVertex, Error, Frame, Headless, Image, PreparedScene, Renderer, Result, Scene,
    Trims, reference,
};
use glam::{DVec2, UVec2};
use indicatif::ProgressBar;

/// Measures scenes in pictures of one size.
pub(super) struct Lab {
    // The order matters: OpenGL objects go before the context.
    picture: Framebuffer,
    numbers: FloatTarget,
    renderer: Renderer,
    /// The device's clock, where it is not the processor itself.
    timer: Option<Timer>,
    context: Headless,
    pub(super) size: (u32, u32),
    /// Times that things are done to find the median of what they take.
    turns: usize,
    pub(super) quick: bool,
    resources: PathBuf,
    bar: ProgressBar,
}

/// Pixels that trims decide wrongly.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Wrong {
    pub(super) pixels: usize,
    /// From the furthest of them to the nearest pixel on the border, in pixels.
    pub(super) distance: f64,
}

impl Lab {
    pub(super) fn new(
        context: Headless,
        sources: Sources,
        resources: PathBuf,
        quick: bool,
        bar: ProgressBar,
    ) -> Result<Self> {
        let size = if quick { (500, 300) } else { (1000, 600) };
        let renderer = Renderer::with_sources(context.gl(), sources)?;
        let is_software = context.info().is_software();
        let timer = if is_software { None } else { Some(Timer::new(context.gl())?) };
        Ok(Self {
            picture: Framebuffer::new(context.gl(), size.0, size.1)?,
            numbers: FloatTarget::for_aovs(&renderer, size)?,
            renderer,
            timer,
            context,
            size,
            turns: if quick { 5 } else { 9 },
            quick,
            resources,
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

    /// The driver, for the report's first lines.
    pub(super) fn driver(&self) -> String {
        let info = self.context.info();
        format!("{}, OpenGL {}", info.renderer, info.version)
    }

    /// What times are taken of, for the report's first lines.
    pub(super) const fn clock(&self) -> &'static str {
        match self.timer {
            None => "the wall clock around a finished frame",
            Some(_) => {
                "what the processor or the device takes for a frame, whichever is longer: they work side \
                 by side"
            }
        }
    }

    /// Says how many things a section is going to do.
    pub(super) fn begin(&self, steps: usize) {
        self.bar.set_length(steps as u64);
        self.bar.set_position(0);
    }

    /// Says what is being done.
    pub(super) fn step(&self, what: impl Into<String>) {
        self.bar.set_message(what.into());
        self.bar.inc(1);
    }

    /// A scene or mesh, by its path in the folder of resources.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        self.resources.join(name)
    }

    pub(super) fn scene(&self, name: &str) -> Result<Scene> {
        Scene::load(&self.path(name))
    }

    /// The options that measure a scene in such a picture by hand.
    pub(super) fn command(&self, scene: &str, options: &str) -> String {
        let (width, height) = self.size;
        format!("freeform measure {scene} {options} --resolution {width}x{height}")
    }

    pub(super) fn frame(&self, scene: &Scene) -> Frame {
        let projection = scene.projection(self.size.0, self.size.1);
        Frame { projection, settings: scene.settings }
    }

    /// What a frame of each scene takes if the camera moves from frame to frame.
    pub(super) fn time(&mut self, scenes: &[Scene]) -> Result<Vec<Timing>> {
        let mut prepared = Vec::with_capacity(scenes.len());
        for scene in scenes {
            prepared.push((PreparedScene::new(&self.renderer, scene)?, self.frame(scene)));
        }
        self.time_frames(scenes.len(), |renderer, number| {
            let (prepared, frame) = &mut prepared[number];
            move_on(frame);
            prepared.draw(renderer, frame).map(drop)
        })
    }

    /// What frames take that are drawn by their number. On drivers that share the processor's cores this
    /// is the wall clock around a finished frame; on others the longer of what the processor and the
    /// device take for it, since they work side by side.
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
                gpu::finish(gl);
                Ok(start.elapsed())
            });
        };
        in_turns_by(self.turns, count, |number| {
            let mut told = Duration::ZERO;
            let drawn = timer.time(|| {
                let start = Instant::now();
                draw(renderer, number)?;
                told = start.elapsed();
                Ok(())
            })?;
            Ok(told.max(drawn))
        })
    }

    /// What each pixel of a scene's picture shows, and its triangles.
    pub(super) fn numbers(&mut self, scene: &Scene) -> Result<(Aovs, u64)> {
        let frame = self.frame(scene);
        let mut prepared = PreparedScene::new(&self.renderer, scene)?;
        let aovs = prepared.aovs(&mut self.renderer, &self.numbers, &frame)?;
        Ok((aovs, prepared.figures().triangles))
    }

    /// How far what is drawn of a scene is from its surfaces, and its triangles.
    pub(super) fn errors(&mut self, scene: &Scene) -> Result<(Measurement, u64)> {
        let (aovs, triangles) = self.numbers(scene)?;
        let projection = self.frame(scene).projection;
        Ok((measure_drawn(scene, &projection, &aovs), triangles))
    }

    /// The same, and what is missing or too much.
    pub(super) fn errors_and_silhouette(&mut self, scene: &Scene) -> Result<(Measurement, u64)> {
        let (aovs, triangles) = self.numbers(scene)?;
        let projection = self.frame(scene).projection;
        let method = scene.settings.method;
        let coverage = reference::coverage(scene, &projection, UVec2::from(self.size), method)?;
        Ok((measure(scene, &projection, &aovs, &coverage), triangles))
    }

    /// Whether the trims of a scene of one surface keep each pixel that it would cover without them:
    /// what they say, in `f64`, of the place that the pixel would show.
    pub(super) fn kept(&mut self, scene: &Scene) -> Result<Vec<Option<bool>>> {
        let mut untrimmed = scene.clone();
        for surface in &mut untrimmed.surfaces {
            surface.trims = Trims::default();
        }
        let (all, _) = self.numbers(&untrimmed)?;
        let trims = &scene.surfaces[0].trims;
        let keeps = |[u, v, _, drawn]: &[f32; 4]| {
            (*drawn != 0.0).then(|| !trims.cut(DVec2::new(f64::from(*u), f64::from(*v))))
        };
        Ok(all.uv.iter().map(keeps).collect())
    }

    /// The pixels that a scene's trims decide wrongly. What is drawn is judged by the place that it
    /// shows. What is missing has none: it is wrong if [`Lab::kept`] keeps it and all pixels around
    /// it, because without trims other triangles are drawn, up to the tolerance away.
    pub(super) fn wrong(&mut self, scene: &Scene, kept: &[Option<bool>]) -> Result<Wrong> {
        let (left, _) = self.numbers(scene)?;
        let trims = &scene.surfaces[0].trims;
        let own = |[u, v, _, drawn]: &[f32; 4]| {
            (*drawn != 0.0).then(|| !trims.cut(DVec2::new(f64::from(*u), f64::from(*v))))
        };
        let drawn: Vec<Option<bool>> = left.uv.iter().map(own).collect();
        Ok(wrong(kept, &drawn, self.size.0 as usize))
    }

    /// The functions of the context, for objects of a section's own.
    pub(super) fn gl(&self) -> Arc<glow::Context> {
        Arc::clone(self.context.gl())
    }

    /// A scene in the driver's memory.
    pub(super) fn prepare(&self, scene: &Scene) -> Result<PreparedScene> {
        PreparedScene::new(&self.renderer, scene)
    }

    /// How far static triangles are from the surfaces of the scene that they stand for.
    pub(super) fn static_errors(
        &mut self,
        mesh: &StaticMesh,
        look: &StaticLook<'_>,
        scene: &Scene,
    ) -> Result<Measurement> {
        let frame = self.frame(scene);
        let aovs = self.renderer.static_aovs(mesh, look, &self.numbers, &frame)?;
        Ok(measure_drawn(scene, &frame.projection, &aovs))
    }

    /// The corners of the triangles that a scene is drawn with.
    pub(super) fn triangles(&mut self, scene: &Scene) -> Result<Vec<DrawnVertex>> {
        self.picture.bind();
        let frame = self.frame(scene);
        PreparedScene::new(&self.renderer, scene)?.triangles(&mut self.renderer, &frame)
    }

    /// A scene's picture.
    pub(super) fn picture(&mut self, scene: &Scene) -> Result<Image> {
        self.picture.bind();
        let frame = self.frame(scene);
        PreparedScene::new(&self.renderer, scene)?.draw(&mut self.renderer, &frame)?;
        let image = self.picture.read();
        let complaints = self.context.debug_log().take_errors();
        if complaints.is_empty() {
            Ok(image)
        } else {
            Err(Error::Driver { what: "a picture".into(), reason: complaints.join("; ") })
        }
    }
}

/// Moves the camera on by nearly nothing: wherever the eye is, the view is another one.
pub(super) fn move_on(frame: &mut Frame) {
    frame.projection.view.w_axis.x *= 1.0 + 1e-9;
    frame.projection.view.w_axis.x += 1e-9;
}

/// `kept` says of each pixel that the surface covers whether its trims keep it, `drawn` the same of each
/// that is drawn, by the place that it shows.
fn wrong(kept: &[Option<bool>], drawn: &[Option<bool>], width: usize) -> Wrong {
    let place = |i: usize| DVec2::new((i % width) as f64, (i / width) as f64);
    let differs = |a: usize, b: usize| matches!((kept[a], kept[b]), (Some(a), Some(b)) if a != b);
    let border: Vec<DVec2> = (0..kept.len())
        .filter(|i| {
            i % width + 1 < width && differs(*i, i + 1)
                || i + width < kept.len() && differs(*i, i + width)
        })
        .map(place)
        .collect();
    let height = kept.len() / width;
    let is_missing = |i: usize| {
        let around = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        around(i / width, height).all(|row| {
            around(i % width, width).all(|column| kept[row * width + column] == Some(true))
        })
    };
    let mut wrong = Wrong::default();
    for (i, drawn) in drawn.iter().enumerate() {
        if drawn.map_or_else(|| is_missing(i), |keeps| !keeps) {
            let nearest =
                border.iter().map(|at| at.distance_squared(place(i))).fold(f64::INFINITY, f64::min);
            wrong.pixels += 1;
            wrong.distance = wrong.distance.max(nearest.sqrt());
        }
    }
    wrong
}

/// Where two pictures differ by more than a shade, in red; elsewhere the first, paler.
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
    Err(Error::File {
        action: "read",
        path: folder.to_owned(),
        reason: "it does not hold the project's scenes; expected its folder \"resources\", see \
                 --resources"
            .into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_border_that_was_moved() {
        // Of ten columns 0 … 4 are kept. By two more the furthest wrong one is 2 from the border.
        let kept: Vec<_> = (0..30).map(|i| Some(i % 10 < 5)).collect();
        let drawn = |columns: usize| -> Vec<_> {
            (0..30).map(|i| (i % 10 < columns).then_some(i % 10 < 5)).collect()
        };
        assert_eq!(wrong(&kept, &drawn(7), 10), Wrong { pixels: 6, distance: 2.0 });
        assert_eq!(wrong(&kept, &drawn(5), 10), Wrong::default());
        // One column less may be the triangles'; of three less the outermost does not count.
        assert_eq!(wrong(&kept, &drawn(4), 10), Wrong::default());
        let wide: Vec<_> = (0..70).map(|i| Some(i % 10 < 5)).collect();
        let few: Vec<_> = (0..70).map(|i| (i % 10 < 2).then_some(true)).collect();
        assert_eq!(wrong(&wide, &few, 10), Wrong { pixels: 14, distance: 2.0 });
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
