//! Section 5: the hard cases, both methods side by side.

use std::path::{Path, PathBuf};

use crate::io::Result;
use freeform_surface::inspect::NewtonTrims;
use freeform_surface::inspect::measure::Measurement;
use freeform_surface::{AovKind, Method, Scene};

use super::bench::{Bench, Wrong};
use super::row::{Row, name};
use super::{Figure, Section};

/// Size in pixels of the pictures in which cases are measured. It is small because the `f64` reference of the
/// largest cases is slow.
const SIZE: (u32, u32) = (300, 180);
/// Width of the small pictures.
const THUMBNAIL: u32 = 200;
/// A picture whose error is larger than this is wrong, whatever level was requested.
const FAR_PX: f64 = 0.5;
/// A picture whose normals are turned by more than this is wrong too.
const TURNED_DEG: f64 = 15.0;

pub(super) fn section(bench: &mut Bench) -> Result<Section> {
    let mut section = Section::new(
        "stability",
        "Stability: the hard cases",
        "One scene for each thing that is hard, in pictures of 300×180, and what went wrong. Wrong pixels \
         are those that trims decide wrongly. Silhouette pixels are those whose coverage differs from the \
         surface's own, which triangles within the tolerance may do. What a method cannot draw at all it \
         refuses, and says why. Meshes are drawn in the one way that there is.",
    );
    let size = bench.size;
    bench.resize(SIZE)?;
    let measured = measure(bench, &mut section);
    bench.resize(size)?;
    measured?;
    section.findings = findings(&section.rows);
    Ok(section)
}

fn measure(bench: &mut Bench, section: &mut Section) -> Result<()> {
    let mut cases = cases(bench)?;
    if bench.quick {
        cases.retain(|(name, _)| QUICK.contains(&name.as_str()));
    }
    bench.begin(cases.len());
    for (case, path) in &cases {
        bench.step(format!("stability: {case}"));
        let scene = Scene::load(path)?;
        if !scene.meshes.is_empty() {
            row_of_mesh(bench, case, &scene, section)?;
            continue;
        }
        for method in [Method::Exact, Method::Thesis] {
            let mut scene = scene.clone();
            scene.settings.method = method;
            row_of(bench, case, &scene, path, section)?;
        }
    }
    Ok(())
}

/// The number of cases without a fault for each method, and the cases in which the exact method has one.
fn findings(rows: &[Row]) -> Vec<String> {
    let of = |method: &str| {
        let rows: Vec<&Row> = rows.iter().filter(|row| row.method == method).collect();
        let wrong: Vec<&Row> = rows.iter().copied().filter(|row| row.note.is_some()).collect();
        (!rows.is_empty()).then_some((rows.len(), wrong))
    };
    let named = |wrong: &[&Row]| {
        let told =
            |row: &&Row| format!("{}: {}", row.scene, row.note.as_deref().unwrap_or_default());
        wrong.iter().map(told).collect::<Vec<_>>().join("; ")
    };
    let mut findings = Vec::new();
    for method in ["exact", "thesis", MESHES] {
        if let Some((all, wrong)) = of(method) {
            let names = match (method, wrong.is_empty()) {
                ("thesis", _) | (_, true) => String::new(),
                _ => format!(" ({})", named(&wrong)),
            };
            findings.push(format!(
                "{method}: in {} of {all} cases something goes wrong{names}.",
                wrong.len()
            ));
        }
    }
    findings
}

/// The name of the method in rows of meshes.
const MESHES: &str = "smooth triangles";

/// Cases of a quick report: one of each kind.
const QUICK: [&str; 7] = [
    "tess-collapsed-edge",
    "tess-near-plane",
    "tess-offset-1e6",
    "tri-needle",
    "trim-counter-clockwise",
    "trim-ends-on-two-rows",
    "trim-sliver",
];

/// The scenes of the folder by name, except those that exist to be refused.
fn cases(bench: &Bench) -> Result<Vec<(String, PathBuf)>> {
    let folder = bench.path("scenes/stability");
    let fail = |error: std::io::Error| crate::io::Error::file("read", folder.clone(), error);
    let mut cases = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        let case = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        if !case.contains("refused") {
            cases.push((case, path));
        }
    }
    cases.sort();
    Ok(cases)
}

/// Adds the row and picture of a case by one method.
fn row_of(
    bench: &mut Bench,
    case: &str,
    scene: &Scene,
    path: &Path,
    section: &mut Section,
) -> Result<()> {
    let method = name(scene.settings.method);
    let row = Row::new("stability", case, method);
    let refused = scene.surfaces.iter().find_map(|surface| {
        let degree = surface.degree().check_for_thesis();
        degree.and_then(|()| NewtonTrims::of(&surface.trims).map(drop)).err()
    });
    if let (Method::Thesis, Some(error)) = (scene.settings.method, refused) {
        section.rows.push(Row { note: Some(format!("refused: {error}")), ..row });
        return Ok(());
    }
    // Trim borders are compared with the decision of the trims themselves, which is sharper than a comparison
    // of silhouettes.
    let row = if case.starts_with("trim-") && scene.surfaces.len() == 1 {
        let wrong = bench.wrong(scene)?;
        Row {
            wrong_pixels: Some(wrong.pixels),
            max_wrong_distance: wrong.distance,
            note: note_of_trims(wrong),
            command: bench.report_command("stability"),
            ..row
        }
    } else {
        let (errors, stats) = bench.errors_and_silhouette(scene)?;
        Row {
            silhouette_pixels: Some(errors.silhouette_pixels),
            note: note_of(&errors, stats.unmet),
            command: bench.command(&path.display().to_string(), &format!("--method {method}")),
            ..row.measured(&errors, stats.triangles)
        }
    };
    show(bench, scene, &row, section)?;
    section.rows.push(row);
    Ok(())
}

/// Adds the row and picture of a mesh.
fn row_of_mesh(bench: &mut Bench, case: &str, scene: &Scene, section: &mut Section) -> Result<()> {
    let (aovs, stats) = bench.numbers(scene)?;
    let numbers = AovKind::ALL.iter().flat_map(|kind| aovs.channel(*kind).as_flattened());
    let bad = numbers.filter(|value| !value.is_finite()).count();
    let drawn = aovs.uv.iter().any(|[.., drawn]| *drawn != 0.0);
    let row = Row {
        triangles: Some(stats.triangles),
        note: match (drawn, bad) {
            (false, _) => Some("nothing is drawn".into()),
            (true, 0) => None,
            (true, _) => Some(format!("{bad} numbers are none")),
        },
        command: bench.report_command("stability"),
        ..Row::new("stability", case, MESHES)
    };
    show(bench, scene, &row, section)?;
    section.rows.push(row);
    Ok(())
}

/// Adds the small picture of a row.
fn show(bench: &mut Bench, scene: &Scene, row: &Row, section: &mut Section) -> Result<()> {
    let picture = bench.picture(scene)?;
    let height = THUMBNAIL * picture.height() / picture.width();
    let note = row.note.as_deref().unwrap_or("nothing goes wrong");
    section.figures.push(Figure {
        caption: format!("{}, {}: {note}", row.scene, row.method),
        image: image::imageops::thumbnail(&picture, THUMBNAIL, height),
    });
    Ok(())
}

fn note_of_trims(Wrong { pixels, distance }: Wrong) -> Option<String> {
    let how_far =
        distance.map_or("with no border in sight".into(), |px| format!("up to {px:.1} px away"));
    (pixels > 0).then(|| format!("{pixels} wrong pixels, {how_far}"))
}

/// The faults of a surface in words; `unmet` is the remaining error if the tolerance is not met.
fn note_of(errors: &Measurement, unmet: Option<f64>) -> Option<String> {
    let mut notes = Vec::new();
    if let Some(unmet) = unmet {
        notes.push(format!("tolerance not met, up to {unmet:.2} px"));
    }
    if errors.max_error_px > FAR_PX {
        notes.push(format!("up to {:.1} px off", errors.max_error_px));
    }
    if errors.normal_error_deg > TURNED_DEG {
        notes.push(format!("normals up to {:.0}° off or missing", errors.normal_error_deg));
    }
    for (count, what) in [
        (errors.crack_pixels, "cracks"),
        (errors.hidden_pixels, "pixels that show what is hidden"),
        (errors.bad_values, "numbers that are none"),
    ] {
        if count > 0 {
            notes.push(format!("{count} {what}"));
        }
    }
    (!notes.is_empty()).then(|| notes.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_goes_wrong_is_said() {
        let fine =
            Measurement { max_error_px: 0.4, normal_error_deg: 2.0, ..Measurement::default() };
        assert_eq!(note_of(&fine, None), None);
        let bad = Measurement {
            max_error_px: 3.25,
            normal_error_deg: 48.0,
            crack_pixels: 2,
            bad_values: 1,
            ..fine
        };
        let expected = "tolerance not met, up to 4.00 px, up to 3.2 px off, normals up to 48° off or \
                        missing, 2 cracks, 1 numbers that are none";
        assert_eq!(note_of(&bad, Some(4.0)).as_deref(), Some(expected));
        let wrong = |pixels, distance| note_of_trims(Wrong { pixels, distance });
        assert_eq!(wrong(0, Some(0.0)), None);
        assert_eq!(wrong(7, Some(2.0)).as_deref(), Some("7 wrong pixels, up to 2.0 px away"));
        assert_eq!(wrong(7, None).as_deref(), Some("7 wrong pixels, with no border in sight"));
    }

    #[test]
    fn cases_that_go_wrong_are_counted_and_named() {
        let row = |method: &str, scene: &str, note: Option<&str>| Row {
            note: note.map(String::from),
            ..Row::new("stability", scene, method)
        };
        let rows =
            [row("exact", "a", None), row("exact", "b", Some("far off")), row("thesis", "a", None)];
        let findings = findings(&rows);
        assert_eq!(findings[0], "exact: in 1 of 2 cases something goes wrong (b: far off).");
        assert_eq!(findings[1], "thesis: in 0 of 1 cases something goes wrong.");
    }
}
