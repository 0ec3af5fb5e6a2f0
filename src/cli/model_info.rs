//! `freeform info FILE`: what a CAD model consists of, and how well its edges lie on its faces.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use freeform_surface::LoadOptions;
use freeform_surface::model::{
    CertifiedDeviation, ClosedGap, Deviation, DrawnEdge, DrawnFace, Model, PcurveSource,
};
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
    let (model, joined) = Model::load_sewn(path, options)?;
    let faces = model.drawn_faces();
    let info = Info { unit: model.unit_name(), diagonal: model.diagonal(), model, faces };
    info.contents(path)?;
    info.edges(joined)?;
    info.p_curves()?;
    info.repairs()?;
    let left_out = info.faces.iter().filter_map(|face| face.as_ref().err());
    named(left_out.map(|error| ("left out".into(), error.to_string())).collect(), "faces")
}

/// A model and its faces as they are drawn.
struct Info {
    model: Model,
    faces: Vec<freeform_surface::Result<DrawnFace>>,
    unit: String,
    diagonal: f64,
}

impl Info {
    /// The faces that are drawn, with their numbers.
    fn drawn(&self) -> impl Iterator<Item = (usize, &DrawnFace)> {
        self.faces.iter().enumerate().filter_map(|(face, of)| Some((face, of.as_ref().ok()?)))
    }

    /// The edges of the faces that are drawn, with the numbers of these.
    fn drawn_edges(&self) -> impl Iterator<Item = (usize, &DrawnFace, &DrawnEdge)> {
        self.drawn().flat_map(|(face, of)| of.edges.iter().map(move |edge| (face, of, edge)))
    }

    /// A distance with its share of the diagonal.
    fn length(&self, length: f64) -> String {
        let share = length / self.diagonal;
        format!("{length:.2e} {} ({share:.1e} of the diagonal)", self.unit)
    }

    /// Prints what the model consists of.
    fn contents(&self, path: &Path) -> Result<()> {
        let Self { model, faces, unit, .. } = self;
        let name =
            if model.name.is_empty() { path.display().to_string() } else { model.name.clone() };
        line("model", name)?;
        line("unit", unit.clone())?;
        let instances = model.instances()?;
        let drawn = |face: usize| faces[face].as_ref().ok();
        let size = size(instances.iter().filter_map(|at| Some((drawn(at.face)?, at.placement))));
        let [x, y, z] = size.to_array().map(digits);
        line("size", format!("{x} × {y} × {z} {unit}"))?;
        line("products", model.products.len().to_string())?;
        line("faces", format!("{}, in all places {}", model.faces.len(), instances.len()))?;
        line("  by surface", counts(model.faces.iter().map(|face| face.surface.kind())))?;
        let drawn = || self.drawn().map(|(_, face)| face);
        line("  by degree", counts(drawn().map(|face| face.surface.degree())))?;
        line("  Bézier patches", drawn().map(patches).sum::<usize>().to_string())?;
        let segments = drawn().map(|face| face.trims.segment_count()).sum::<usize>();
        line("  trim segments", segments.to_string())?;
        line("  area", format!("{} {unit}²", digits(drawn().map(DrawnFace::area).sum())))
    }

    /// Prints how many edges there are, how many faces use them, and how many were joined to others.
    fn edges(&self, joined: usize) -> Result<()> {
        let edges = &self.model.edges;
        let uses = self.model.edge_uses();
        let with_length = || std::iter::zip(edges, &uses).filter(|(edge, _)| edge.curve.is_some());
        let used = |times: usize| with_length().filter(|(_, uses)| uses.len() == times).count();
        let more = with_length().filter(|(_, uses)| uses.len() > 2).count();
        let points = edges.iter().filter(|edge| edge.curve.is_none()).count();
        let [twice, open] = [2, 1].map(used);
        let count = edges.len();
        line(
            "edges",
            format!(
                "{count}: used twice {twice}, open {open}, used more often {more}, poles {points}"
            ),
        )?;
        line("  joined to others", joined.to_string())
    }

    /// Prints where the p-curves come from, and how far they are from their edges.
    fn p_curves(&self) -> Result<()> {
        let from = |source: PcurveSource, without: bool| {
            let is_it = |(_, face, edge): &(usize, &DrawnFace, &DrawnEdge)| {
                edge.source == source && face.repairs.without_pcurves == without
            };
            self.drawn_edges().filter(is_it).count()
        };
        let of_both = |source| from(source, false) + from(source, true);
        line(
            "p-curves",
            format!(
                "{} of the file, {} computed, {} computed because the file's is off",
                of_both(PcurveSource::File),
                of_both(PcurveSource::Projected),
                from(PcurveSource::Refused, false),
            ),
        )?;
        let mut found: Vec<(usize, Deviation)> = self
            .drawn()
            .flat_map(|(face, of)| {
                let all = self.model.deviations(face, of, self.diagonal);
                all.into_iter().map(move |found| (face, found))
            })
            .collect();
        let largest = |of: fn(&Deviation) -> f64| {
            found.iter().map(|(_, found)| of(found)).fold(0.0, f64::max)
        };
        line("  furthest off the edge", self.length(largest(|found| found.drawn)))?;
        self.certain()?;
        // Two faces at an edge are no further apart than both are from it.
        let mut gaps: HashMap<usize, Vec<f64>> = HashMap::new();
        for (_, found) in &found {
            gaps.entry(found.edge).or_default().push(found.drawn);
        }
        let gap = gaps.values().filter(|sides| sides.len() > 1).map(|sides| sides.iter().sum());
        let gap = self.length(gap.fold(0.0, f64::max));
        line("largest gap at an edge", format!("at most {gap}"))?;
        line("edges off surfaces", self.length(largest(|found| found.surface)))?;
        found.retain(|(_, found)| found.surface > NAMED * self.diagonal);
        found.sort_by(|a, b| b.1.surface.total_cmp(&a.1.surface));
        let off = found.iter().map(|(face, found)| {
            (format!("  edge {}, face {face}", found.edge), self.length(found.surface))
        });
        named(off.collect(), "edges")
    }

    /// Prints the distance that no place of a drawn edge exceeds.
    fn certain(&self) -> Result<()> {
        let found: Vec<(usize, CertifiedDeviation)> = self
            .drawn()
            .flat_map(|(face, of)| {
                let all = self.model.certified_deviations(of, self.diagonal);
                all.into_iter().map(move |found| (face, found))
            })
            .collect();
        let largest = found.iter().filter_map(|(_, found)| found.drawn).fold(0.0, f64::max);
        line("  certainly below", self.length(largest))?;
        let without = found.iter().filter(|(_, found)| found.drawn.is_none());
        let without = without.map(|(face, found)| {
            (format!("  edge {}, face {face}", found.edge), "no bound was found".into())
        });
        named(without.collect(), "edges")
    }

    /// Prints what was changed so that faces could be drawn, and where edges could not be drawn accurately.
    fn repairs(&self) -> Result<()> {
        let faces = |is_it: fn(&DrawnFace) -> bool| -> Vec<(String, String)> {
            let found = self.drawn().filter(|(_, face)| is_it(face));
            found.map(|(face, _)| (format!("  face {face}"), self.name_of(face))).collect()
        };
        let without = faces(|face| face.repairs.without_pcurves);
        line("p-curves left out", format!("of {} faces, which they do not bound", without.len()))?;
        named(without, "faces")?;
        let reordered = faces(|face| face.repairs.is_reordered);
        line("edges reordered", format!("of {} faces", reordered.len()))?;
        named(reordered, "faces")?;

        let gaps =
            self.drawn().flat_map(|(face, of)| of.repairs.gaps.iter().map(move |g| (face, g)));
        let mut gaps: Vec<(usize, &ClosedGap)> = gaps.collect();
        gaps.sort_by(|a, b| b.1.length.total_cmp(&a.1.length));
        let largest = gaps.first().map(|(_, gap)| format!(", at most {}", self.length(gap.length)));
        line("gaps closed by lines", format!("{}{}", gaps.len(), largest.unwrap_or_default()))?;
        let gaps = gaps.into_iter().map(|(face, ClosedGap { edges: [before, after], length })| {
            (format!("  edge {before} to {after}, face {face}"), self.length(*length))
        });
        named(gaps.collect(), "gaps")?;

        let rough = self.drawn_edges().filter(|(_, _, edge)| edge.is_rough);
        let rough = rough.map(|(face, of, DrawnEdge { edge, .. })| {
            let all = self.model.deviations(face, of, self.diagonal);
            let off = all.into_iter().filter(|found| found.edge == *edge);
            let off = off.map(|found| found.drawn).fold(0.0, f64::max);
            (format!("  edge {edge}, face {face}"), format!("off by {}", self.length(off)))
        });
        let rough: Vec<_> = rough.collect();
        line("edges drawn roughly", rough.len().to_string())?;
        named(rough, "edges")
    }

    /// The name of a face in quotes, if it has one.
    fn name_of(&self, face: usize) -> String {
        let name = &self.model.faces[face].name;
        if name.is_empty() { String::new() } else { format!("{name:?}") }
    }
}

fn line(name: &str, value: String) -> Result<()> {
    say(format_args!("{name:24} {value}"))
}

/// Prints a line for each of the first things, and how many more there are.
fn named(lines: Vec<(String, String)>, what: &str) -> Result<()> {
    for (name, value) in lines.iter().take(MOST) {
        line(name, value.clone())?;
    }
    if lines.len() > MOST {
        line("  ", format!("{} more {what}", lines.len() - MOST))?;
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
