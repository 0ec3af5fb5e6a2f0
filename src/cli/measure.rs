//! `freeform measure`: measures how far pictures of a scene deviate from it, and prints the result as text or
//! JSON.

mod leaks;

use std::path::Path;
use std::time::{Duration, Instant};

use crate::io::{Error, Result};
use freeform_surface::inspect::measure::{
    AnalysisErrors, LeakFinder, Leaks, Measurement, Suspects, measure, measure_analysis,
    random_view,
};
use freeform_surface::inspect::reference;
use freeform_surface::{
    FloatTarget, Frame, Framebuffer, Headless, Method, PreparedScene, RenderSettings, Renderer,
    Samples, Scene, Tessellation,
};
use glam::UVec2;
use indicatif::ProgressBar;
use serde::Serialize;

use super::{Format, MeasureArguments};
use crate::io::{input, say};
use leaks::{LeakCounts, LeakObject};

/// The number of frames whose median time is reported.
const FRAMES: usize = 3;

/// Measures every scene and prints a line for each.
///
/// # Errors
/// One for each scene that failed; the others are still measured.
pub(super) fn all(arguments: &MeasureArguments) -> Result<(), Vec<Error>> {
    input::check(&arguments.scenes).map_err(|error| vec![error])?;
    let mut bench = Bench::new(arguments).map_err(|error| vec![error])?;
    let bar = if arguments.views > 1 {
        ProgressBar::new(arguments.views.saturating_mul(arguments.scenes.len() as u64))
    } else {
        ProgressBar::hidden()
    };
    let mut errors = Vec::new();
    for path in &arguments.scenes {
        let told = bench.measure(path, &bar).and_then(|report| {
            let line = match arguments.format {
                Format::Line => report.line(),
                Format::Json => report.json(),
            };
            bar.suspend(|| say(line))
        });
        errors.extend(told.err());
    }
    bar.finish_and_clear();
    if errors.is_empty() { Ok(()) } else { Err(errors) }
}

/// A context with render targets in which the scenes are measured one after the other.
struct Bench<'a> {
    picture: Framebuffer,
    numbers: FloatTarget,
    renderer: Renderer,
    context: Headless,
    arguments: &'a MeasureArguments,
}

impl<'a> Bench<'a> {
    fn new(arguments: &'a MeasureArguments) -> Result<Self> {
        let context = Headless::new(arguments.backend)?;
        let renderer = Renderer::new(context.gl())?;
        let (width, height) = arguments.resolution;
        Ok(Self {
            picture: Framebuffer::new(context.gl(), width, height)?,
            numbers: FloatTarget::for_aovs(&renderer, arguments.resolution)?,
            renderer,
            context,
            arguments,
        })
    }

    /// Measures a scene from its own camera, or from random cameras.
    fn measure(&mut self, path: &Path, bar: &ProgressBar) -> Result<Report> {
        let mut scene = self.arguments.load.load(path)?;
        self.arguments.style.apply(&mut scene, path)?;
        self.arguments.shading.apply(&mut scene.settings)?;
        self.arguments.shading.check_shown(&scene.settings)?;
        // The reference has only Bézier surfaces, so meshes are not drawn.
        scene.meshes.clear();
        if scene.surfaces.is_empty() {
            return Err(Error::file(
                "measure",
                path,
                "it has no Bézier surface; meshes are not measured",
            ));
        }
        let mut prepared = PreparedScene::new(&self.renderer, &scene)?;
        let seen = scene.clone();
        let finder = (!seen.models.is_empty()).then(|| LeakFinder::new(&seen));
        let mut report = Report {
            scene: path.display().to_string(),
            method: scene.settings.method,
            fineness: match (scene.settings.method, scene.settings.tessellation) {
                (Method::Exact, Tessellation::Within(tolerance)) => {
                    Fineness::Tolerance(tolerance.pixels())
                }
                (_, tessellation) => Fineness::Level(tessellation.level().get()),
            },
            measurement: Measurement::default(),
            triangles: 0,
            ms: 0.0,
            unmet_views: 0,
            analysis: None,
            leaks: finder.as_ref().map(|of| LeakCounts::new(of.open_edges(), of.has_closed())),
        };
        let (width, height) = self.arguments.resolution;
        let aspect = f64::from(width) / f64::from(height);
        let views = self.arguments.views.max(1);
        let mut unmet = 0.0_f64;
        let mut met_views = 0;
        for view in 0..views {
            let seed = self.arguments.seed;
            if let Some(zoom) = self.arguments.zoom {
                let close = |finder: &LeakFinder<'_>| finder.close_up(seed, view, aspect, zoom);
                scene.camera = Some(finder.as_ref().and_then(close).ok_or_else(|| {
                    let reason = "it has no edge that faces share, to look at from close up";
                    Error::file("measure", path, reason)
                })?);
            } else if self.arguments.views > 0 {
                scene.camera = Some(random_view(&scene, seed, view, aspect));
            }
            let View { measurement, analysis, leaks, triangles, ms, unmet: left } =
                self.view(&scene, &mut prepared, finder.as_ref())?;
            bar.inc(1);
            // Leaks count whatever the tolerance is.
            if let Some((all, leaks)) = report.leaks.as_mut().zip(leaks) {
                all.add(&leaks);
            }
            if let Some(left) = left {
                report.unmet_views += 1;
                unmet = unmet.max(left);
                if views > 1 {
                    continue;
                }
            }
            met_views += 1;
            report.measurement = report.measurement.merge(&measurement);
            if let Some(errors) = analysis {
                report.analysis = Some(report.analysis.unwrap_or_default().merge(&errors));
            }
            report.triangles += triangles;
            report.ms += ms;
        }
        if met_views == 0 {
            // Every view was left out, so these values are unknown.
            let none = f64::NAN;
            report.measurement.max_error_px = none;
            report.measurement.mean_error_px = none;
            report.measurement.rms_error_px = none;
            report.measurement.normal_error_deg = none;
        }
        report.triangles /= met_views.max(1);
        report.ms /= met_views.max(1) as f64;
        if report.unmet_views > 0 {
            bar.suspend(|| {
                eprintln!(
                    "freeform: {}: tolerance not met in {} of {views} views, up to {unmet:.2} px",
                    report.scene, report.unmet_views
                );
            });
        }
        Ok(report)
    }

    /// Measures one view.
    fn view(
        &mut self,
        scene: &Scene,
        prepared: &mut PreparedScene,
        finder: Option<&LeakFinder<'_>>,
    ) -> Result<View> {
        let (width, height) = self.arguments.resolution;
        let frame = Frame::of(scene, (width, height));
        let aovs = prepared.aovs(&mut self.renderer, &self.numbers, &frame)?;
        let size = UVec2::new(width, height);
        let coverage = reference::coverage(scene, &frame.camera, size, scene.settings.method)?;
        let measurement = measure(scene, &frame.camera, &aovs, &coverage);
        let tolerance = match scene.settings.tessellation {
            Tessellation::Within(tolerance) => prepared.stats().unmet.unwrap_or(tolerance.pixels()),
            Tessellation::Level(_) => measurement.max_error_px,
        };
        let leaks =
            finder.map(|finder| finder.find(&frame.camera, &aovs, tolerance, Suspects::Between));
        self.picture.bind();
        let mut times = [Duration::ZERO; FRAMES];
        for time in &mut times {
            let start = Instant::now();
            let _ = prepared.draw(&mut self.renderer, &frame)?;
            self.context.gl().finish();
            *time = start.elapsed();
        }
        times.sort_unstable();
        let stats = prepared.stats();
        let analysis = match scene.settings.shown_analysis() {
            None => None,
            Some(analysis) => {
                let mut bare = frame;
                bare.settings = RenderSettings {
                    samples: Samples::default(),
                    wireframe: false,
                    control_points: false,
                    edges: None,
                    isolines: None,
                    ..frame.settings
                };
                let image =
                    prepared.picture(&mut self.renderer, &self.picture, &bare, |_, _| {})?;
                let limit = prepared.curvature_limit(&analysis).unwrap_or(1.0);
                let shown = (&analysis, limit);
                Some(measure_analysis(scene, &frame.camera, shown, &aovs, &image).0)
            }
        };
        let complaints = self.context.debug_log().take_errors();
        if !complaints.is_empty() {
            let what = format!("numbers for {width}x{height} pixels");
            return Err(Error::Driver { what, reason: complaints.join("; ") });
        }
        Ok(View {
            measurement,
            analysis,
            leaks,
            triangles: stats.triangles,
            ms: times[FRAMES / 2].as_secs_f64() * 1e3,
            unmet: stats.unmet,
        })
    }
}

/// What was measured in one view.
struct View {
    measurement: Measurement,
    /// Of the shading that is shown in place of light and colour.
    analysis: Option<AnalysisErrors>,
    leaks: Option<Leaks>,
    triangles: u64,
    ms: f64,
    /// The error that remains if a limit keeps the view from meeting the tolerance.
    unmet: Option<f64>,
}

/// How finely a scene was tessellated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Fineness {
    /// A level for all patches.
    Level(u32),
    /// Levels as the picture needs them, for this largest error in pixels.
    Tolerance(f64),
}

/// The errors of a scene's pictures, and their cost.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Report {
    /// The scene's file.
    pub(super) scene: String,
    /// The method for trims and normals.
    pub(super) method: Method,
    /// How finely the scene was tessellated.
    pub(super) fineness: Fineness,
    /// The errors of all its pictures together.
    pub(super) measurement: Measurement,
    /// Triangles of a frame, on average.
    pub(super) triangles: u64,
    /// Milliseconds of a still frame, on average.
    pub(super) ms: f64,
    /// The number of views that reached a limit. If there are several views, the other values leave these views
    /// out.
    pub(super) unmet_views: u64,
    /// The errors of the shading that is shown in place of light and colour.
    pub(super) analysis: Option<AnalysisErrors>,
    /// The leaks, if the scene has CAD models.
    leaks: Option<LeakCounts>,
}

/// The keys of the JSON object, in order.
#[derive(Serialize)]
struct Object<'a> {
    scene: &'a str,
    method: &'a str,
    #[serde(flatten)]
    fineness: Fineness,
    max_error_px: f64,
    mean_error_px: f64,
    normal_error_deg: f64,
    silhouette_pixels: usize,
    crack_pixels: usize,
    hidden_pixels: usize,
    triangles: u64,
    ms: f64,
    unmet_views: u64,
    covered_pixels: usize,
    bad_values: usize,
    #[serde(flatten)]
    analysis: Option<AnalysisObject>,
    #[serde(flatten)]
    leaks: Option<LeakObject>,
}

/// The keys of an analysis, in order.
#[derive(Serialize)]
struct AnalysisObject {
    shading_pixels: usize,
    wrong_shading_pixels: usize,
    pixels_at_stripe_borders: usize,
    pixels_beside_surfaces: usize,
}

impl Report {
    const fn method_name(&self) -> &'static str {
        match self.method {
            Method::Thesis => "thesis",
            Method::Exact => "exact",
        }
    }

    /// The report as one line of text.
    pub(super) fn line(&self) -> String {
        let errors = &self.measurement;
        let fineness = match self.fineness {
            Fineness::Level(level) => format!("level {level}"),
            Fineness::Tolerance(pixels) => format!("tolerance {pixels} px"),
        };
        let mut line = format!(
            "{} ({}, {fineness}): at most {:.3} px off, {:.4} px on average, normals {:.2}°, {} \
             silhouette pixels, {} crack pixels, {} triangles, {:.2} ms",
            self.scene,
            self.method_name(),
            errors.max_error_px,
            errors.mean_error_px,
            errors.normal_error_deg,
            errors.silhouette_pixels,
            errors.crack_pixels,
            self.triangles,
            self.ms,
        );
        if self.unmet_views > 0 {
            line.push_str(&format!(", {} views at a limit", self.unmet_views));
        }
        if errors.hidden_pixels > 0 {
            line.push_str(&format!(", {} pixels show what is hidden", errors.hidden_pixels));
        }
        if errors.bad_values > 0 {
            line.push_str(&format!(", {} NaN or infinite values", errors.bad_values));
        }
        if let Some(AnalysisErrors { compared, wrong, at_borders, beside }) = self.analysis {
            line.push_str(&format!(
                ", {wrong} of {compared} pixels of the shading wrong ({} not compared)",
                at_borders + beside
            ));
        }
        if let Some(leaks) = &self.leaks {
            line.push_str(&format!(", {}", leaks.words()));
        }
        line
    }

    /// The report as one line with a JSON object. Values that are not finite become null.
    pub(super) fn json(&self) -> String {
        let errors = &self.measurement;
        serde_json::to_string(&Object {
            scene: &self.scene,
            method: self.method_name(),
            fineness: self.fineness,
            max_error_px: errors.max_error_px,
            mean_error_px: errors.mean_error_px,
            normal_error_deg: errors.normal_error_deg,
            silhouette_pixels: errors.silhouette_pixels,
            crack_pixels: errors.crack_pixels,
            hidden_pixels: errors.hidden_pixels,
            triangles: self.triangles,
            ms: self.ms,
            unmet_views: self.unmet_views,
            covered_pixels: errors.covered,
            bad_values: errors.bad_values,
            analysis: self.analysis.map(|errors| AnalysisObject {
                shading_pixels: errors.compared,
                wrong_shading_pixels: errors.wrong,
                pixels_at_stripe_borders: errors.at_borders,
                pixels_beside_surfaces: errors.beside,
            }),
            leaks: self.leaks.as_ref().map(LeakCounts::object),
        })
        .expect("strings and numbers")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> Report {
        Report {
            scene: "a \"b\"\n.toml".into(),
            method: Method::Thesis,
            fineness: Fineness::Level(16),
            measurement: Measurement {
                max_error_px: 0.4375,
                mean_error_px: 0.0625,
                rms_error_px: 0.125,
                normal_error_deg: 1.5,
                silhouette_pixels: 7,
                crack_pixels: 2,
                hidden_pixels: 0,
                bad_values: 0,
                covered: 1000,
                expected: 1001,
            },
            triangles: 1024,
            ms: 2.25,
            unmet_views: 0,
            analysis: None,
            leaks: None,
        }
    }

    #[test]
    fn the_object_has_its_keys_in_order() {
        let expected = r#"{"scene":"a \"b\"\n.toml","method":"thesis","level":16,"#.to_owned()
            + r#""max_error_px":0.4375,"mean_error_px":0.0625,"normal_error_deg":1.5,"#
            + r#""silhouette_pixels":7,"crack_pixels":2,"hidden_pixels":0,"triangles":1024,"ms":2.25,"unmet_views":0,"covered_pixels":1000,"bad_values":0}"#;
        assert_eq!(report().json(), expected);
        let report =
            Report { method: Method::Exact, fineness: Fineness::Tolerance(0.5), ..report() };
        let text = report.json();
        assert!(text.contains(r#""method":"exact","tolerance":0.5,"max_error_px""#), "{text}");
        assert!(!text.contains("level"), "{text}");
    }

    #[test]
    fn what_is_no_number_is_null() {
        let mut report = report();
        report.measurement.max_error_px = f64::INFINITY;
        report.measurement.mean_error_px = f64::NAN;
        report.ms = f64::NEG_INFINITY;
        let object: serde_json::Value = serde_json::from_str(&report.json()).unwrap();
        for key in ["max_error_px", "mean_error_px", "ms"] {
            assert!(object[key].is_null(), "{key}");
        }
        assert_eq!(object["normal_error_deg"], 1.5);
    }

    #[test]
    fn the_line_says_how_it_was_cut_and_what_came_out() {
        let mut report = report();
        report.scene = "a.toml".into();
        let expected = "a.toml (thesis, level 16): at most 0.438 px off, 0.0625 px on average, \
                        normals 1.50°, 7 silhouette pixels, 2 crack pixels, 1024 triangles, 2.25 ms";
        assert_eq!(report.line(), expected);
        report.fineness = Fineness::Tolerance(0.25);
        report.measurement.bad_values = 3;
        report.unmet_views = 2;
        let line = report.line();
        assert!(line.contains("2 views at a limit"));
        assert!(line.contains("tolerance 0.25 px") && line.ends_with("3 NaN or infinite values"));
    }
}
