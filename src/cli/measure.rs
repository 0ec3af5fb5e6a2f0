//! `freeform measure`: what it says about a scene, to people and to programs.

use freeform_surface::Method;
use freeform_surface::measure::Measurement;
use serde::Serialize;

/// How finely a scene was cut into triangles.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Fineness {
    /// A level for all patches.
    Level(u32),
    /// As the picture needs: so many pixels off at most.
    Tolerance(f64),
}

/// The errors of a scene's pictures, and what they cost.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Report {
    /// The scene's file.
    pub(super) scene: String,
    /// Whose trims and normals.
    pub(super) method: Method,
    /// How finely.
    pub(super) fineness: Fineness,
    /// The errors of all its pictures together.
    pub(super) measurement: Measurement,
    /// Triangles of a frame.
    pub(super) triangles: u64,
    /// Milliseconds of a frame.
    pub(super) ms: f64,
}

/// The keys of the object, in their order.
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
    triangles: u64,
    ms: f64,
}

impl Report {
    const fn method_name(&self) -> &'static str {
        match self.method {
            Method::Thesis => "thesis",
            Method::Exact => "exact",
        }
    }

    /// One line to read.
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
        if errors.bad_values > 0 {
            line.push_str(&format!(", {} NaN or infinite values", errors.bad_values));
        }
        line
    }

    /// One JSON object in a line. What is no finite number is null.
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
            triangles: self.triangles,
            ms: self.ms,
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
                normal_error_deg: 1.5,
                silhouette_pixels: 7,
                crack_pixels: 2,
                bad_values: 0,
                covered: 1000,
                expected: 1001,
            },
            triangles: 1024,
            ms: 2.25,
        }
    }

    #[test]
    fn the_object_has_its_keys_in_order() {
        let expected = r#"{"scene":"a \"b\"\n.toml","method":"thesis","level":16,"#.to_owned()
            + r#""max_error_px":0.4375,"mean_error_px":0.0625,"normal_error_deg":1.5,"#
            + r#""silhouette_pixels":7,"crack_pixels":2,"triangles":1024,"ms":2.25}"#;
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
        let line = report.line();
        assert!(line.contains("tolerance 0.25 px") && line.ends_with("3 NaN or infinite values"));
    }
}
