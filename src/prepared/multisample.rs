//! Images with several samples per pixel. They use the driver's multisampling up to its maximum sample count;
//! beyond that, the scene is drawn once for each sample and the results are averaged.

use glam::{DMat4, DVec2, UVec2, dvec2, dvec3};

use super::PreparedScene;
use crate::camera::ViewProjection;
use crate::error::{Error, Result};
use crate::gpu::{DriverInfo, Framebuffer, Gl};
use crate::renderer::{Frame, Renderer};
use crate::scene::{Image, Samples};

impl Framebuffer {
    /// A target for images with `samples` samples per pixel. The target has all of them if the driver supports that.
    /// Otherwise it has one, and [`PreparedScene::picture`] draws into it repeatedly.
    ///
    /// # Errors
    /// As [`Framebuffer::new`].
    pub fn for_samples(gl: &Gl, (width, height): (u32, u32), samples: Samples) -> Result<Self> {
        let max = u32::try_from(DriverInfo::of(gl).max_samples).unwrap_or(0);
        let at_once = if samples.get() <= max { samples.get() } else { 1 };
        Self::with_samples(gl, width, height, at_once)
    }
}

impl PreparedScene {
    /// Draws the scene with the number of samples in the frame's settings, and reads the image back. If the target
    /// has fewer samples, the scene is drawn once for each sample. `progress` is called with the number of finished
    /// passes and the total.
    ///
    /// Pixels are averages of premultiplied colours (colour times alpha), so that edges on a transparent background
    /// keep the colour of the object drawn.
    ///
    /// # Errors
    /// As [`PreparedScene::draw`], or no memory for the image.
    pub fn picture(
        &mut self,
        renderer: &mut Renderer,
        target: &Framebuffer,
        frame: &Frame,
        mut progress: impl FnMut(u32, u32),
    ) -> Result<Image> {
        let samples = frame.settings.samples.get();
        let averages = samples.max(target.samples()) > 1;
        let mut frame = *frame;
        let background = frame.settings.background;
        if averages {
            let [red, green, blue, alpha] = background;
            frame.settings.background = [red * alpha, green * alpha, blue * alpha, alpha];
        }
        target.bind();
        let mut image = if samples <= target.samples() {
            let _ = self.draw(renderer, &frame)?;
            progress(1, 1);
            target.read()
        } else {
            self.average(renderer, target, &frame, &mut progress)?
        };
        if averages && background[3] < 1.0 {
            divide_by_alpha(&mut image, background);
        }
        Ok(image)
    }

    /// Draws the scene once for each sample and averages the images.
    fn average(
        &mut self,
        renderer: &mut Renderer,
        target: &Framebuffer,
        frame: &Frame,
        progress: &mut impl FnMut(u32, u32),
    ) -> Result<Image> {
        let (width, height) = target.size();
        let mut sums = vec![0.0_f32; 4 * width as usize * height as usize];
        let samples = frame.settings.samples;
        for (done, offset) in (1..).zip(sample_offsets(samples)) {
            let camera = moved(&frame.camera, -offset, frame.viewport.pixels());
            target.bind();
            let _ = self.draw(renderer, &Frame { camera, ..*frame })?;
            for (sum, byte) in sums.iter_mut().zip(target.read().as_raw()) {
                *sum += f32::from(*byte);
            }
            progress(done, samples.get());
        }
        let share = 1.0 / samples.get() as f32;
        let bytes = sums.iter().map(|sum| (sum * share).round() as u8).collect();
        Image::from_raw(width, height, bytes).ok_or_else(|| Error::Driver {
            what: format!("a picture of {width}x{height} pixels"),
            reason: "its size changed while it was drawn".into(),
        })
    }
}

/// Sample positions relative to the centre of a pixel, in pixels. They form a rank-1 lattice, in which each sample
/// has its own row and column. The factors are the ones with the least error on straight edges of all directions.
pub fn sample_offsets(samples: Samples) -> impl Iterator<Item = DVec2> {
    let count = samples.get();
    let factor = match count {
        ..=2 => 1,
        4 => 3,
        8 | 16 => 5,
        32 => 9,
        64 => 27,
        128 => 49,
        _ => 115,
    };
    (0..count).map(move |i| {
        let place = dvec2(f64::from(i), f64::from(i * factor % count));
        (place + 0.5) / f64::from(count) - 0.5
    })
}

/// The same view with its image shifted by `by_px` pixels to the right and up.
fn moved(camera: &ViewProjection, by_px: DVec2, size: UVec2) -> ViewProjection {
    let shift = 2.0 * by_px / size.as_dvec2();
    let to_clip = DMat4::from_translation(dvec3(shift.x, shift.y, 0.0));
    ViewProjection { view: camera.view, projection: to_clip * camera.projection }
}

/// Divides premultiplied colours by alpha. Pixels with alpha 0 get the background's colour.
fn divide_by_alpha(image: &mut Image, background: [f32; 4]) {
    let [red, green, blue, _] = background.map(|channel| (channel * 255.0).round() as u8);
    for pixel in image.pixels_mut() {
        let alpha = pixel.0[3];
        if alpha == 0 {
            pixel.0 = [red, green, blue, 0];
        } else if alpha < 255 {
            for channel in &mut pixel.0[..3] {
                let color = f32::from(*channel) * 255.0 / f32::from(alpha);
                *channel = color.round().min(255.0) as u8;
            }
        }
    }
}
