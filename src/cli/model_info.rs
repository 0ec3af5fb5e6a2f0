//! `freeform info FILE`: what a CAD model consists of, and how well its edges lie on its faces.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use freeform_surface::LoadOptions;
use freeform_surface::model::{Deviation, DrawnFace, Model, PcurveSource};
use glam::DVec3;

use crate::io::{Result, say};

/// The largest share of the model's diagonal that an edge may lie off a surface without being named.
const NAMED: f64 = 1e-6;
/// No more edges and faces than this are named.
const MOST: usize = 20;

/// Prints the model of a file.
///
/// # Errors
/// The file cannot be read.
pub(super) fn print(path: &Path, options: &LoadOptions) -> Result<()> {
    let model = Model::load(path, options)?;
    let faces = model.drawn_faces();
    let unit = model.unit_name();
    let line = |name: &str, value: String| say(format_args!("{name:24} {value}"));
    line(
        "model",
        if model.name.is_empty() { path.display().to_string() } else { model.name.clone() },
    )?;
    line("unit", unit.clone())?;
    let instances = model.instances()?;
    let drawn = |face: usize| faces[face].as_ref().ok();
    let size = size(instances.iter().filter_map(|at| Some((drawn(at.face)?, at.placement))));
    line("size", format!("{} × {} × {} {unit}", digits(size.x), digits(size.y), digits(size.z)))?;
    line("products", model.products.len().to_string())?;
    line("faces", format!("{}, in all places {}", model.faces.len(), instances.len()))?;
    line("  by surface", counts(model.faces.iter().map(|face| face.surface.kind())))?;
    let had = || faces.iter().filter_map(|face| face.as_ref().ok());
    line("  by degree", counts(had().map(|face| face.surface.degree())))?;
    line("  Bézier patches", had().map(patches).sum::<usize>().to_string())?;
    line(
        "  trim segments",
        had().map(|face| face.trims.segment_count()).sum::<usize>().to_string(),
    )?;
    line("  area", format!("{} {unit}²", digits(had().map(DrawnFace::area).sum())))?;
    edges(&model, &line)?;
    p_curves(&model, &faces, &unit, &line)?;
    let left_out = faces.iter().filter_map(|face| face.as_ref().err());
    let count = left_out.clone().count();
    for error in left_out.take(MOST) {
        line("left out", error.to_string())?;
    }
    if count > MOST {
        line("left out", format!("{} more faces", count - MOST))?;
    }
    Ok(())
}

/// Prints how many edges there are, and how many faces use them.
fn edges(model: &Model, line: &impl Fn(&str, String) -> Result<()>) -> Result<()> {
    let uses = model.edge_uses();
    let with_length =
        || std::iter::zip(&model.edges, &uses).filter(|(edge, _)| edge.curve.is_some());
    let used = |times: usize| with_length().filter(|(_, uses)| uses.len() == times).count();
    let more = with_length().filter(|(_, uses)| uses.len() > 2).count();
    let points = model.edges.iter().filter(|edge| edge.curve.is_none()).count();
    line(
        "edges",
        format!(
            "{}: used twice {}, open {}, used more often {more}, poles {points}",
            model.edges.len(),
            used(2),
            used(1),
        ),
    )
}

/// Prints where the p-curves come from, and how far they are from their edges.
fn p_curves(
    model: &Model,
    faces: &[freeform_surface::Result<DrawnFace>],
    unit: &str,
    line: &impl Fn(&str, String) -> Result<()>,
) -> Result<()> {
    let drawn =
        || faces.iter().enumerate().filter_map(|(face, of)| Some((face, of.as_ref().ok()?)));
    let from = |source: PcurveSource| {
        drawn().flat_map(|(_, face)| &face.edges).filter(|edge| edge.source == source).count()
    };
    line(
        "p-curves",
        format!(
            "{} of the file, {} computed, {} computed because the file's is off",
            from(PcurveSource::File),
            from(PcurveSource::Projected),
            from(PcurveSource::Refused),
        ),
    )?;
    let diagonal = model.diagonal();
    let length =
        |length: f64| format!("{length:.2e} {unit} ({:.1e} of the diagonal)", length / diagonal);
    let mut found: Vec<(usize, Deviation)> = drawn()
        .flat_map(|(face, of)| {
            model.deviations(face, of, diagonal).into_iter().map(move |found| (face, found))
        })
        .collect();
    let largest =
        |of: fn(&Deviation) -> f64| found.iter().map(|(_, found)| of(found)).fold(0.0, f64::max);
    line("  furthest off the edge", length(largest(|found| found.drawn)))?;
    // Two faces at an edge are no further apart than both are from it.
    let mut gaps: HashMap<usize, Vec<f64>> = HashMap::new();
    for (_, found) in &found {
        gaps.entry(found.edge).or_default().push(found.drawn);
    }
    let gap = gaps.values().filter(|sides| sides.len() > 1).map(|sides| sides.iter().sum());
    line("largest gap at an edge", format!("at most {}", length(gap.fold(0.0, f64::max))))?;
    line("edges off surfaces", length(largest(|found| found.surface)))?;
    found.retain(|(_, found)| found.surface > NAMED * diagonal);
    found.sort_by(|a, b| b.1.surface.total_cmp(&a.1.surface));
    for (face, Deviation { edge, surface, .. }) in found.iter().take(MOST) {
        line(&format!("  edge {edge}, face {face}"), length(*surface))?;
    }
    if found.len() > MOST {
        line("  ", format!("{} more edges", found.len() - MOST))?;
    }
    Ok(())
}

fn patches(face: &DrawnFace) -> usize {
    let spans = |knots: &[f64], degree: usize| {
        knots[degree..knots.len() - degree].windows(2).filter(|pair| pair[0] < pair[1]).count()
    };
    let [u, v] = face.surface.knots();
    spans(u, face.surface.degree().u()) * spans(v, face.surface.degree().v())
}

/// How often each value occurs, the most frequent first.
fn counts<T: std::fmt::Display>(values: impl Iterator<Item = T>) -> String {
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    for value in values {
        *counts.entry(value.to_string()).or_default() += 1;
    }
    let mut counts: Vec<(String, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let texts = counts.into_iter().map(|(value, count)| format!("{value} {count}"));
    texts.collect::<Vec<_>>().join(", ")
}

/// The size of the box around the edges and inner points of faces in their places.
fn size<'a>(faces: impl Iterator<Item = (&'a DrawnFace, glam::DAffine3)>) -> DVec3 {
    const STEPS: u32 = 16;
    let mut corners = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    for (face, placement) in faces {
        let [low, high] = face.surface.domain();
        let share = |i: u32| f64::from(i) / f64::from(STEPS);
        let inner = (0..(STEPS + 1) * (STEPS + 1)).map(|i| {
            low + (high - low) * glam::dvec2(share(i % (STEPS + 1)), share(i / (STEPS + 1)))
        });
        let inner = inner.filter(|place| !face.trims.cut(*place));
        let segments = face.edges.iter().flat_map(|edge| &edge.segments);
        let border = segments.flat_map(|segment| (0..=STEPS).map(move |i| segment.point(share(i))));
        for place in inner.chain(border) {
            let place = place.clamp(low, high);
            let point = placement.transform_point3(face.surface.at(place.x, place.y).position);
            corners = [corners[0].min(point), corners[1].max(point)];
        }
    }
    if corners[0].is_finite() { corners[1] - corners[0] } else { DVec3::ZERO }
}

/// A number with six digits, in its shortest form.
fn digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
