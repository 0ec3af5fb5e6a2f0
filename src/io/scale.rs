//! The scale of an analysis in a picture: colours with numbers beside them.

use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Point, Size};
use embedded_graphics::mono_font::iso_8859_1::{FONT_7X13, FONT_9X18, FONT_10X20};
use embedded_graphics::mono_font::{MonoFont, MonoTextStyle};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::text::{Baseline, Text};
use embedded_graphics::{Drawable as _, Pixel};
use freeform_surface::{Analysis, CurvatureKind, Image};
use image::Rgba;

/// Pictures of fewer pixels along a side have no scale: it would hide what they show.
const LEAST: u32 = 160;
/// The intervals between numbers.
const STEPS: i32 = 4;
/// Rows of one colour.
const BANDS: u32 = 48;
const PAPER: Rgba<u8> = Rgba([250, 250, 250, 255]);
const INK: Rgba<u8> = Rgba([20, 20, 25, 255]);

/// Draws the scale of an analysis into the lower left corner of a picture, if it has one and there is room. `limit` is
/// the curvature at the end of the scale, if it shows curvature.
pub(crate) fn draw(image: &mut Image, analysis: &Analysis, limit: Option<f64>) {
    let size = image.dimensions();
    let Some(scale) = for_picture(analysis, limit, size) else { return };
    let (x, y) = corner(size.1, scale.height());
    image::imageops::replace(image, &scale, x.into(), y.into());
}

/// The upper left corner of a scale in a picture, from the heights of the picture and of the scale in pixels.
pub(crate) const fn corner(height: u32, rows: u32) -> (u32, u32) {
    let margin = height / 40;
    (margin, height.saturating_sub(rows + margin))
}

/// The scale alone, if a picture of that size has one.
pub(crate) fn for_picture(
    analysis: &Analysis,
    limit: Option<f64>,
    (width, height): (u32, u32),
) -> Option<Image> {
    if width.min(height) < LEAST {
        return None;
    }
    picture(analysis, limit, height)
}

/// The scale for a picture of that height in pixels.
fn picture(analysis: &Analysis, limit: Option<f64>, height: u32) -> Option<Image> {
    let colors = analysis.scale_colors()?;
    let (title, end, unit) = match analysis {
        Analysis::Curvature { of, .. } => {
            let name = match of {
                CurvatureKind::Gaussian => "Gaussian",
                CurvatureKind::Mean => "mean",
                CurvatureKind::Largest => "largest",
            };
            (format!("{name} curvature"), limit?, "")
        }
        Analysis::Draft(draft) => ("draft".to_owned(), draft.limit.degrees(), "°"),
        Analysis::Zebra(_) | Analysis::Isophotes(_) => return None,
    };
    let font = match height {
        ..700 => &FONT_7X13,
        700..1400 => &FONT_9X18,
        _ => &FONT_10X20,
    };
    let Size { width: advance, height: line } = font.character_size;
    let number = |step: i32| words(end * f64::from(step) / f64::from(STEPS / 2)) + unit;
    let steps = -STEPS / 2..=STEPS / 2;
    let longest = steps.clone().map(|step| number(step).chars().count()).max().unwrap_or(0) as u32;
    let pad = line / 2;
    let (bar, gap) = (2 * advance, advance);
    let band = (height / 4 / BANDS).max(2);
    let inside = (bar + gap + longest * advance).max(title.chars().count() as u32 * advance);
    let rows = band * BANDS;
    let size = (inside + 2 * pad, rows + 2 * line + line / 2 + 2 * pad);
    let mut scale = Image::from_pixel(size.0, size.1, PAPER);
    let top = pad + 2 * line;
    for row in 0..rows {
        let value = 1.0 - 2.0 * (f64::from(row / band) + 0.5) / f64::from(BANDS);
        let [red, green, blue] = colors.at(value).map(|channel| (channel * 255.0).round() as u8);
        for column in 0..bar {
            scale.put_pixel(pad + column, top + row, Rgba([red, green, blue, 255]));
        }
    }
    write(&mut scale, font, &title, pad, pad + line / 2);
    for step in steps {
        let share = f64::from(STEPS / 2 - step) / f64::from(STEPS);
        let middle = top + (share * f64::from(rows)).round() as u32;
        write(&mut scale, font, &number(step), pad + bar + gap, middle);
    }
    Some(scale)
}

/// A number of at most three digits, with an exponent if it is small or large.
fn words(value: f64) -> String {
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    match rounded.abs() {
        0.0 => "0".into(),
        0.001..100_000.0 => rounded.to_string(),
        _ => format!("{rounded:e}"),
    }
}

/// Writes a line of text from `x` on, with its middle at `y`.
fn write(scale: &mut Image, font: &MonoFont<'_>, text: &str, x: u32, y: u32) {
    let style = MonoTextStyle::new(font, BinaryColor::On);
    let text = Text::with_baseline(text, Point::new(x as i32, y as i32), style, Baseline::Middle);
    let Ok(_) = text.draw(&mut Canvas(scale));
}

/// A picture that takes ink.
struct Canvas<'a>(&'a mut Image);

impl OriginDimensions for Canvas<'_> {
    fn size(&self) -> Size {
        Size::new(self.0.width(), self.0.height())
    }
}

impl DrawTarget for Canvas<'_> {
    type Color = BinaryColor;
    type Error = std::convert::Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Self::Error> {
        for Pixel(place, color) in pixels {
            let at = (u32::try_from(place.x), u32::try_from(place.y));
            if let ((Ok(x), Ok(y)), BinaryColor::On) = (at, color)
                && let Some(pixel) = self.0.get_pixel_mut_checked(x, y)
            {
                *pixel = INK;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use freeform_surface::{AnalysisKind, CurvatureLimit};

    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-0.5, "-0.5"),
            (1.0 / 3.0, "0.333"),
            (12_345.0, "12300"),
            (2e-9, "2e-9"),
            (-5e7, "-5e7"),
            (0.05 * 0.5, "0.025"),
        ] {
            assert_eq!(words(value), text);
        }
    }

    #[test]
    fn a_scale_is_in_the_corner_and_nothing_else_changes() {
        let grey = Rgba([100, 100, 100, 255]);
        let mut image = Image::from_pixel(400, 300, grey);
        let curvature = AnalysisKind::Curvature.with_defaults();
        draw(&mut image, &AnalysisKind::Zebra.with_defaults(), None);
        assert!(image.pixels().all(|pixel| *pixel == grey));
        draw(&mut image, &curvature, Some(0.02));
        let scale = picture(&curvature, Some(0.02), 300).unwrap();
        let (left, top) = (7, 300 - 7 - scale.height());
        for (x, y, pixel) in image.enumerate_pixels() {
            let is_inside = (left..left + scale.width()).contains(&x)
                && (top..top + scale.height()).contains(&y);
            let expected = if is_inside { scale.get_pixel(x - left, y - top) } else { &grey };
            assert_eq!(pixel, expected, "({x}, {y})");
        }
        let mut small = Image::from_pixel(400, LEAST - 1, grey);
        draw(&mut small, &curvature, Some(0.02));
        assert!(small.pixels().all(|pixel| *pixel == grey));
    }

    #[test]
    fn colours_run_from_the_end_above_to_the_end_below_and_numbers_differ() {
        let draft = AnalysisKind::Draft.with_defaults();
        let scale = picture(&draft, None, 1000).unwrap();
        let ends = draft.scale_colors().unwrap();
        let column: Vec<[u8; 3]> = (0..scale.height())
            .map(|y| scale.get_pixel(FONT_9X18.character_size.height / 2 + 3, y).0)
            .map(|[r, g, b, _]| [r, g, b])
            .filter(|rgb| *rgb != [250; 3] && *rgb != [20, 20, 25])
            .collect();
        let near = |rgb: [u8; 3], value: f64| {
            let expected = ends.at(value).map(|channel| 255.0 * channel);
            rgb.iter().zip(expected).all(|(a, b)| (f32::from(*a) - b).abs() < 12.0)
        };
        assert!(near(column[0], 1.0) && near(column[column.len() - 1], -1.0), "{column:?}");
        let limit = |limit: f64| {
            let limit = CurvatureLimit::new(limit).unwrap();
            let analysis = Analysis::Curvature { of: CurvatureKind::Mean, limit: Some(limit) };
            picture(&analysis, Some(limit.get()), 300).unwrap()
        };
        assert!(limit(0.1) == limit(0.1) && limit(0.1) != limit(0.2));
    }
}
