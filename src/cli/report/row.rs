//! What is measured, as flat rows for programs.

use freeform_surface::Method;
use freeform_surface::measure::{Measurement, Timing};
use serde::Serialize;

/// A spread above this share of the median is pointed out.
pub(super) const NOISY: f64 = 0.2;

/// One thing that was measured. What does not apply is none, and null in JSON.
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
    /// The distance between the quartiles of the times, over the median.
    pub(super) spread: Option<f64>,
    pub(super) triangles: Option<u64>,
    pub(super) max_error_px: Option<f64>,
    pub(super) rms_error_px: Option<f64>,
    pub(super) normal_error_deg: Option<f64>,
    pub(super) wrong_pixels: Option<usize>,
    /// In pixels, from the furthest wrong pixel to the border that it is on the wrong side of.
    pub(super) max_wrong_distance: Option<f64>,
    /// Pixels along the silhouette that are drawn and should not be, or the other way round.
    pub(super) silhouette_pixels: Option<usize>,
    /// The largest distance from the ideal surface in the model's units.
    pub(super) max_error: Option<f64>,
    /// Bytes that the process grew by.
    pub(super) memory: Option<u64>,
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

/// The name of a method in rows and on command lines.
pub(super) const fn name(method: Method) -> &'static str {
    match method {
        Method::Exact => "exact",
        Method::Thesis => "thesis",
    }
}
