//! The measurements as flat rows for other programs.

use freeform_surface::Method;
use freeform_surface::inspect::measure::{Measurement, Timing};
use serde::Serialize;

/// The report points out a spread above this share of the median.
pub(super) const NOISY: f64 = 0.2;

/// One measurement. Fields that do not apply are `None`; in JSON they are null, and so are infinite values.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub(super) struct Row {
    pub(super) section: &'static str,
    pub(super) scene: String,
    pub(super) method: String,
    pub(super) level: Option<u32>,
    pub(super) tolerance: Option<f64>,
    pub(super) iterations: Option<u32>,
    pub(super) epsilon: Option<f64>,
    pub(super) segments: Option<usize>,
    pub(super) patches: Option<usize>,
    pub(super) ms: Option<f64>,
    /// The interquartile range of the times, divided by the median.
    pub(super) spread: Option<f64>,
    pub(super) triangles: Option<u64>,
    pub(super) max_error_px: Option<f64>,
    pub(super) rms_error_px: Option<f64>,
    pub(super) normal_error_deg: Option<f64>,
    pub(super) wrong_pixels: Option<usize>,
    /// The pixels among which the wrong ones were counted, where these are not all.
    pub(super) pixels: Option<usize>,
    /// The distance of the furthest wrong pixel from the border that it is on the wrong side of, in pixels.
    pub(super) max_wrong_distance: Option<f64>,
    /// Pixels along the silhouette that are wrongly drawn or wrongly missing.
    pub(super) silhouette_pixels: Option<usize>,
    /// The largest distance from the ideal surface, in the model's units.
    pub(super) max_error: Option<f64>,
    /// The bytes by which the process grew; for a whole program, the most that it held.
    pub(super) memory: Option<u64>,
    /// The error, in words.
    pub(super) note: Option<String>,
    pub(super) command: String,
}

impl Row {
    pub(super) fn new(section: &'static str, scene: &str, method: impl Into<String>) -> Self {
        Self { section, scene: scene.into(), method: method.into(), ..Self::default() }
    }

    pub(super) fn timed(self, timing: Timing) -> Self {
        Self { ms: Some(timing.ms), spread: Some(timing.spread), ..self }
    }

    pub(super) fn measured(self, errors: &Measurement, triangles: u64) -> Self {
        Self {
            triangles: Some(triangles),
            max_error_px: Some(errors.max_error_px),
            rms_error_px: Some(errors.rms_error_px),
            normal_error_deg: Some(errors.normal_error_deg),
            ..self
        }
    }

    pub(super) fn is_noisy(&self) -> bool {
        self.spread.is_some_and(|spread| spread > NOISY)
    }
}

/// The wrong pixels and milliseconds of all trimmed figures together, by the exact method (`None`) or by
/// Newton's method with this number of iterations and this epsilon. Figures drawn as lines have no pixel count
/// and pictures of defects have no time, so both are left out.
pub(super) fn trims(rows: &[&Row], newton: Option<(u32, f64)>) -> Option<(usize, f64)> {
    let mut sum = None;
    for row in rows
        .iter()
        .filter(|row| row.section == "trimming" && row.iterations.zip(row.epsilon) == newton)
    {
        if let (Some(pixels), Some(ms)) = (row.wrong_pixels, row.ms) {
            let (all_pixels, all_ms) = sum.unwrap_or_default();
            sum = Some((all_pixels + pixels, all_ms + ms));
        }
    }
    sum
}

/// The rows of a scene for an error of half a pixel: the exact method with that tolerance, and the fastest of
/// the thesis' levels whose measured error stays within it.
pub(super) fn half_a_pixel<'a>(rows: &[&'a Row], scene: &str) -> [Option<&'a Row>; 2] {
    let here = || {
        let rows = rows.iter().copied();
        rows.filter(move |row| row.section == "tessellation" && row.scene == scene)
    };
    let holds = |row: &&Row| row.max_error_px.is_some_and(|error| error <= 0.5);
    let ms = |row: &Row| row.ms.unwrap_or(f64::INFINITY);
    [
        here().find(|row| row.method == "exact" && row.tolerance == Some(0.5)),
        here()
            .filter(|row| row.method == "thesis")
            .filter(holds)
            .min_by(|a, b| ms(a).total_cmp(&ms(b))),
    ]
}

/// The name of a method in rows and on command lines.
pub(super) const fn name(method: Method) -> &'static str {
    match method {
        Method::Exact => "exact",
        Method::Thesis => "thesis",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trims_are_summed_where_they_are_counted_and_timed() {
        let trim = |newton: Option<(u32, f64)>, wrong_pixels, ms| Row {
            iterations: newton.map(|(iterations, _)| iterations),
            epsilon: newton.map(|(_, epsilon)| epsilon),
            wrong_pixels,
            ms,
            ..Row::new("trimming", "figure", "a method")
        };
        let usual = Some((10, 1e-3));
        let rows = [
            trim(usual, Some(3), Some(1.0)),
            trim(usual, None, Some(50.0)),
            trim(None, Some(7), None),
            trim(Some((5, 1e-3)), Some(9), Some(2.0)),
            trim(usual, Some(4), Some(2.5)),
        ];
        let rows = rows.each_ref();
        assert_eq!(trims(&rows, usual), Some((7, 3.5)));
        assert_eq!(trims(&rows, None), None);
    }

    #[test]
    fn the_fastest_level_that_holds_half_a_pixel_is_found() {
        let row = |method: &str, level, tolerance, ms, error| Row {
            level,
            tolerance,
            ms: Some(ms),
            max_error_px: Some(error),
            ..Row::new("tessellation", "teapot", method)
        };
        let rows = [
            row("exact", None, Some(1.0), 1.0, 0.3),
            row("exact", None, Some(0.5), 3.0, 0.2),
            row("thesis", Some(16), None, 2.0, 0.7),
            row("thesis", Some(64), None, 8.0, 0.1),
            row("thesis", Some(32), None, 5.0, 0.4),
        ];
        let [ours, thesis] = half_a_pixel(&rows.each_ref(), "teapot");
        assert_eq!(ours.map(|row| row.ms), Some(Some(3.0)));
        assert_eq!(thesis.map(|row| row.level), Some(Some(32)));
        assert_eq!(half_a_pixel(&rows.each_ref(), "sphere"), [None; 2]);
    }
}
