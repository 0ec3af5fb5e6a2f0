//! Textures on surfaces: bilinear filtering in each mipmap level, linear between levels, clamped to the edge,
//! as `gpu::Texture` requests from the driver.

use glam::{DVec2, DVec4};

use crate::scene::Paint;

/// One mipmap level, rows from v = 0 upwards.
pub(super) struct Level {
    width: usize,
    height: usize,
    /// Red, green, blue and alpha.
    texels: Vec<DVec4>,
}

/// A colour, or a texture with its mipmap levels.
pub(super) enum Sampler<'a> {
    Color(&'a [f32; 3]),
    Levels(Vec<Level>),
}

impl<'a> Sampler<'a> {
    pub(super) fn new(paint: &'a Paint) -> Self {
        let image = match paint {
            Paint::Color(color) => return Self::Color(color),
            Paint::Texture(image) => image,
        };
        let (width, height) = (image.width() as usize, image.height() as usize);
        let texels = image
            .rows()
            .rev()
            .flatten()
            .map(|texel| DVec4::from(texel.0.map(|value| f64::from(value) / 255.0)))
            .collect();
        let mut levels = vec![Level { width, height, texels }];
        while let Some(smaller) = levels.last().and_then(Level::half) {
            levels.push(smaller);
        }
        Self::Levels(levels)
    }

    /// The colour and alpha at `uv`. `uv_per_px` are the changes of (u, v) to the next pixel right and down.
    pub(super) fn sample(&self, uv: DVec2, uv_per_px: [DVec2; 2]) -> DVec4 {
        match self {
            // The renderer stores colours in textures of 8 bits.
            Self::Color([red, green, blue]) => DVec4::from(
                [red, green, blue, &1.0]
                    .map(|channel| (f64::from(*channel) * 255.0).round() / 255.0),
            ),
            Self::Levels(levels) => {
                let size = DVec2::new(levels[0].width as f64, levels[0].height as f64);
                let [right, down] = uv_per_px.map(|step| (step * size).length());
                let texels = right.max(down);
                let level = texels.max(1.0).log2().min((levels.len() - 1) as f64);
                let below = level.floor() as usize;
                let above = (below + 1).min(levels.len() - 1);
                levels[below].bilinear(uv).lerp(levels[above].bilinear(uv), level.fract())
            }
        }
    }
}

impl Level {
    /// The next smaller level: each texel is the mean of two by two. `None` after 1×1.
    fn half(&self) -> Option<Self> {
        if self.width == 1 && self.height == 1 {
            return None;
        }
        let (width, height) = ((self.width / 2).max(1), (self.height / 2).max(1));
        let texels = (0..width * height)
            .map(|i| {
                let place = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
                let mean = self.bilinear(place / DVec2::new(width as f64, height as f64));
                // Levels are stored in 8 bits.
                (mean * 255.0).round() / 255.0
            })
            .collect();
        Some(Self { width, height, texels })
    }

    fn bilinear(&self, uv: DVec2) -> DVec4 {
        let x = uv.x * self.width as f64 - 0.5;
        let y = uv.y * self.height as f64 - 0.5;
        let texel = |x: f64, y: f64| {
            let column = x.clamp(0.0, (self.width - 1) as f64) as usize;
            let row = y.clamp(0.0, (self.height - 1) as f64) as usize;
            self.texels[row * self.width + column]
        };
        let (left, low) = (x.floor(), y.floor());
        let lower = texel(left, low).lerp(texel(left + 1.0, low), x - left);
        let upper = texel(left, low + 1.0).lerp(texel(left + 1.0, low + 1.0), x - left);
        lower.lerp(upper, y - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Image;
    use std::sync::Arc;

    fn checker() -> Paint {
        Paint::Texture(Arc::new(Image::from_fn(4, 2, |x, y| {
            let value = if (x + y) % 2 == 0 { 255 } else { 0 };
            image::Rgba([value, (x * 50) as u8, (y * 100) as u8, 255])
        })))
    }

    #[test]
    fn texel_centres_show_their_texels_and_the_first_row_is_on_top() {
        let paint = checker();
        let sampler = Sampler::new(&paint);
        let top_left = sampler.sample(DVec2::new(0.125, 0.75), [DVec2::ZERO; 2]);
        assert_eq!(top_left, DVec4::new(1.0, 0.0, 0.0, 1.0));
        let bottom_right = sampler.sample(DVec2::new(0.875, 0.25), [DVec2::ZERO; 2]);
        assert!(bottom_right.distance(DVec4::new(1.0, 150.0 / 255.0, 100.0 / 255.0, 1.0)) < 1e-12);
    }

    #[test]
    fn between_centres_and_beyond_edges() {
        let paint = checker();
        let sampler = Sampler::new(&paint);
        let between = sampler.sample(DVec2::new(0.25, 0.75), [DVec2::ZERO; 2]);
        assert!((between.x - 0.5).abs() < 1e-12);
        let beyond = sampler.sample(DVec2::new(-1.0, 2.0), [DVec2::ZERO; 2]);
        assert_eq!(beyond, sampler.sample(DVec2::new(0.125, 0.75), [DVec2::ZERO; 2]));
    }

    #[test]
    fn a_large_footprint_averages() {
        let paint = checker();
        let sampler = Sampler::new(&paint);
        let mean = sampler.sample(DVec2::new(0.3, 0.3), [DVec2::X * 10.0; 2]);
        assert!((mean.x - 0.5).abs() < 0.01);
    }
}
