//! Section 5: the hard cases, both methods side by side.

use std::path::PathBuf;

use freeform_surface::{Method, NewtonTrims, Result, Scene};

use super::lab::{Lab, Wrong};
use super::row::{Row, name};
use super::{Figure, Section};

/// Pixels that cases are measured in: the f64 answers of the largest take their time.
const SIZE: (u32, u32) = (300, 180);
/// Width of the small pictures.
const THUMBNAIL: u32 = 200;

pub(super) fn section(lab: &mut Lab) -> Result<Section> {
    let mut section = Section::new(
        "stability",
        "Stability: the hard cases",
        "One scene for each thing that is hard. Wrong pixels are those that trims decide wrongly. Of what \
         is hard to tessellate, the pixels count whose coverage differs from the surface's own, which \
         triangles within the tolerance may do along silhouettes. What the thesis' method cannot draw \
         at all has no row of it.",
    );
    let size = lab.size;
    lab.resize(SIZE)?;
    let mut cases = cases(lab)?;
    if lab.quick {
        cases.retain(|(name, _)| QUICK.contains(&name.as_str()));
    }
    lab.begin(cases.len());
    let (mut better, mut wrong) = (0, Vec::new());
    for (case, path) in &cases {
        lab.step(format!("stability: {case}"));
        let Ok(scene) = Scene::load(path) else { continue };
        let mut counts = [None; 2];
        for (count, method) in counts.iter_mut().zip([Method::Exact, Method::Thesis]) {
            let mut scene = scene.clone();
            scene.settings.method = method;
            if method == Method::Thesis && thesis_refuses(&scene) {
                continue;
            }
            *count = Some(row_of(lab, case, &scene, &path.display().to_string(), &mut section)?);
        }
        match counts {
            [Some(exact), Some(thesis)] if exact < thesis => better += 1,
            [Some(exact), Some(thesis)] if exact > thesis => wrong.push(case.as_str()),
            _ => {}
        }
    }
    lab.resize(size)?;
    section.findings.push(format!(
        "Of {} hard cases exact has fewer wrong or silhouette pixels in {better}, more in {}{}.",
        cases.len(),
        wrong.len(),
        if wrong.is_empty() { String::new() } else { format!(" ({})", wrong.join(", ")) }
    ));
    Ok(section)
}

/// Whether the thesis' method has no way to cut the loops of a scene.
fn thesis_refuses(scene: &Scene) -> bool {
    scene.surfaces.iter().any(|surface| NewtonTrims::of(&surface.trims).is_err())
}

/// Cases of a quick report: one of each kind.
const QUICK: [&str; 6] = [
    "tess-collapsed-edge",
    "tess-near-plane",
    "tess-offset-1e6",
    "trim-counter-clockwise",
    "trim-ends-on-two-rows",
    "trim-sliver",
];

/// The scenes of the folder by name, but those that are there to be refused.
fn cases(lab: &Lab) -> Result<Vec<(String, PathBuf)>> {
    let folder = lab.path("scenes/stability");
    let fail = |error: std::io::Error| freeform_surface::Error::File {
        action: "read",
        path: folder.clone(),
        reason: error.to_string(),
    };
    let mut cases = Vec::new();
    for entry in std::fs::read_dir(&folder).map_err(fail)? {
        let path = entry.map_err(fail)?.path();
        let case = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        // Meshes have no surfaces to be measured by.
        let is_surface = case.starts_with("tess-") || case.starts_with("trim-");
        if is_surface && !case.contains("refused") {
            cases.push((case, path));
        }
    }
    cases.sort();
    Ok(cases)
}

/// Adds the row and picture of a case by one method, and counts its wrong or silhouette pixels.
fn row_of(
    lab: &mut Lab,
    case: &str,
    scene: &Scene,
    path: &str,
    section: &mut Section,
) -> Result<usize> {
    let method = scene.settings.method;
    let row = Row::new("stability", case, name(method));
    // The border of trims is compared by their own answers, which are sharper than a silhouette's.
    let (pixels, what, row) = if case.starts_with("trim-") && scene.surfaces.len() == 1 {
        let kept = lab.kept(scene)?;
        let Wrong { pixels, distance } = lab.wrong(scene, &kept)?;
        let (wrong_pixels, max_wrong_distance) = (Some(pixels), Some(distance));
        (pixels, "wrong", Row { wrong_pixels, max_wrong_distance, ..row })
    } else {
        let (errors, triangles) = lab.errors_and_silhouette(scene)?;
        let silhouette_pixels = Some(errors.silhouette_pixels);
        let row = Row { silhouette_pixels, ..row.measured(&errors, triangles) };
        (errors.silhouette_pixels, "silhouette", row)
    };
    let command = lab.command(path, &format!("--method {}", name(method)));
    section.rows.push(Row { command, ..row });
    let picture = lab.picture(scene)?;
    let height = THUMBNAIL * picture.height() / picture.width();
    section.figures.push(Figure {
        caption: format!("{case}, {}: {pixels} {what} pixels", name(method)),
        image: image::imageops::thumbnail(&picture, THUMBNAIL, height),
    });
    Ok(pixels)
}
