//! Bounds of how far drawn edges are from their curves: never below dense samples, and little above them.

use freeform_surface::LoadOptions;
use freeform_surface::Segment;
use freeform_surface::model::{
    BoundedCurve, CertifiedDeviation, Curve, DrawnEdge, DrawnFace, FaceSurface, Model, PcurveSource,
};
use glam::DVec3;

use crate::cad_models::files;

/// The largest distance of p-curves of files that are used, and of computed ones, as shares of the diagonal.
const MAX_OF_FILE: f64 = 1.2e-6;
const MAX_FITTED: f64 = 1e-7;
/// Places along a drawn edge.
const PLACES: u32 = 150;
/// Places along a curve, around the nearest of which the nearest point is sought.
const SAMPLES: u32 = 2000;

/// The distance of a point from a curve, by samples and a search between those beside the nearest one.
fn distance(curve: &BoundedCurve, samples: &[DVec3], point: DVec3) -> f64 {
    let [first, last] = curve.range;
    let at = |i: f64| {
        let share = i / f64::from(SAMPLES);
        curve.curve.at(first + share * (last - first))[0].distance(point)
    };
    let nearest = (0..samples.len()).min_by(|a, b| {
        samples[*a].distance_squared(point).total_cmp(&samples[*b].distance_squared(point))
    });
    let nearest = nearest.unwrap() as f64;
    let [mut low, mut high] = [(nearest - 1.0).max(0.0), (nearest + 1.0).min(f64::from(SAMPLES))];
    for _ in 0..80 {
        let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if at(a) < at(b) { high = b } else { low = a }
    }
    at(low.midpoint(high)).min(at(nearest))
}

/// The largest distance of an edge of a face from its curve, by dense samples; at its ends from those of the curve.
fn sampled(face: &DrawnFace, edge: &DrawnEdge, curve: &BoundedCurve) -> f64 {
    let [first, last] = curve.range;
    let share = |i: u32| f64::from(i) / f64::from(SAMPLES);
    let samples: Vec<DVec3> =
        (0..=SAMPLES).map(|i| curve.curve.at(first + share(i) * (last - first))[0]).collect();
    let each = PLACES.div_ceil(edge.segments.len() as u32).max(4);
    let places = edge
        .segments
        .iter()
        .flat_map(|segment| (0..=each).map(move |i| segment.point(f64::from(i) / f64::from(each))));
    let inner = places.map(|place| distance(curve, &samples, face.point(place)));
    let ends = [edge.segments[0].start(), edge.segments[edge.segments.len() - 1].end()];
    let of_curve = if edge.forward { [first, last] } else { [last, first] };
    let at_ends = (0..2).map(|i| curve.curve.at(of_curve[i])[0].distance(face.point(ends[i])));
    inner.chain(at_ends).fold(0.0, f64::max)
}

/// Compares the bounds of a face's edges with samples, and returns the bounds.
fn check(model: &Model, face: &DrawnFace, name: &str) -> Vec<f64> {
    let diagonal = model.diagonal();
    let edges = face.edges.iter().filter(|edge| model.edges[edge.edge].curve.is_some());
    let bounds = model.certified_deviations(face, diagonal);
    assert_eq!(edges.clone().count(), bounds.len(), "{name}");
    let compare = |(edge, bound): (&DrawnEdge, CertifiedDeviation)| {
        assert_eq!(edge.edge, bound.edge, "{name}");
        let what = format!("{name}, edge {}, of {:?}", edge.edge, edge.source);
        let below = bound.drawn.unwrap_or_else(|| panic!("{what}: no bound"));
        let found = sampled(face, edge, model.edges[edge.edge].curve.as_ref().unwrap());
        let rounding = 1e-14 * diagonal;
        assert!(found <= below + rounding, "{what}: {below} is no bound of {found}");
        // Samples miss the largest distance.
        let most = 1.3 * found + 1.5e-9 * diagonal;
        assert!(below <= most, "{what}: {below} is far above {found}");
        below
    };
    edges.zip(bounds).map(compare).collect()
}

/// Checks that edges are as near to their curves as they should be, where these lie on the surface.
fn check_all(model: &Model, name: &str) {
    let diagonal = model.diagonal();
    for (number, face) in model.drawn_faces().iter().enumerate() {
        let name = format!("{name}, face {number}");
        let face = face.as_ref().unwrap_or_else(|error| panic!("{name}: {error}"));
        let bounds = check(model, face, &name);
        let edges = face.edges.iter().filter(|edge| model.edges[edge.edge].curve.is_some());
        let deviations = model.deviations(number, face, diagonal);
        for ((edge, bound), deviation) in edges.zip(bounds).zip(deviations) {
            let is_of_file = edge.source == PcurveSource::File;
            let most = if is_of_file { MAX_OF_FILE } else { MAX_FITTED };
            let most = most * diagonal + 1.15 * deviation.surface;
            assert!(bound <= most, "{name}: {deviation:?}, {bound} > {most}, {:?}", edge.source);
        }
    }
}

fn load(name: &str) -> Model {
    let path = format!("{}/resources/models/{name}.ffm", env!("CARGO_MANIFEST_DIR"));
    Model::load(path.as_ref(), &LoadOptions::default()).unwrap()
}

#[test]
fn bounds_of_own_models() {
    for name in ["assembly", "blade", "bracket", "flange"] {
        check_all(&load(name), name);
    }
}

#[test]
fn bounds_of_cad_files() {
    let Some((_, files)) = files() else { return };
    for file in files {
        let name = file.file_name().unwrap().to_str().unwrap();
        check_all(&Model::load(&file, &LoadOptions::default()).unwrap(), name);
    }
}

/// Segments that are moved on purpose: their distances are found.
#[test]
fn bounds_of_spoilt_fits() {
    for name in ["blade", "bracket", "flange"] {
        let model = load(name);
        for (number, face) in model.drawn_faces().into_iter().enumerate() {
            let face = face.unwrap();
            let [low, high] = face.surface.domain();
            for by in [1e-2, 1e-4, 1e-6] {
                let mut spoilt = face.clone();
                for segment in spoilt.edges.iter_mut().flat_map(|edge| &mut edge.segments) {
                    // Inside of the domain, and with the ends where they are.
                    let [start, end] = [segment.start(), segment.end()];
                    let off = 4.0 * by * (low.midpoint(high) - start.midpoint(end));
                    let control = |share: f64| match *segment {
                        Segment::Cubic([_, a, b, _]) => {
                            if share < 0.5 {
                                a
                            } else {
                                b
                            }
                        }
                        Segment::Quadratic([a, b, c]) => {
                            b.lerp(if share < 0.5 { a } else { c }, 1.0 / 3.0)
                        }
                        Segment::Line(_) => start.lerp(end, share),
                    };
                    let inner = [1.0 / 3.0, 2.0 / 3.0].map(|share| control(share) + off);
                    *segment = Segment::Cubic([start, inner[0], inner[1], end]);
                }
                check(&model, &spoilt, &format!("{name}, face {number}, {by}"));
            }
        }
    }
}

/// A line on a plane as a parabola of a known height.
#[test]
fn the_bound_of_a_parabola_is_its_height() {
    let model = load("bracket");
    let diagonal = model.diagonal();
    let faces = model.drawn_faces().into_iter().enumerate();
    let mut compared = 0;
    for (number, face) in faces {
        let mut face = face.unwrap();
        if !matches!(model.faces[number].surface, FaceSurface::Plane(_)) {
            continue;
        }
        let is_line = |edge: &DrawnEdge| {
            let curve = &model.edges[edge.edge].curve;
            matches!(curve, Some(BoundedCurve { curve: Curve::Line { .. }, .. }))
        };
        face.edges.retain(is_line);
        for height in [1e-3, 1e-5, 1e-7].map(|share| share * diagonal) {
            let mut bent = face.clone();
            for edge in &mut bent.edges {
                let [start, end] = [edge.segments[0].start(), edge.segments[0].end()];
                // The parameters of a plane are lengths.
                let off = 2.0 * height * (end - start).normalize().perp();
                edge.segments = vec![Segment::Quadratic([start, start.midpoint(end) + off, end])];
            }
            // Outside of the domain, border stands for it.
            for bound in model.certified_deviations(&bent, diagonal) {
                let below = bound.drawn.unwrap();
                assert!(
                    below <= 1.11 * height && (below >= height || below < 1e-9 * diagonal),
                    "face {number}, edge {}: {below}, not {height}",
                    bound.edge
                );
                compared += usize::from(below >= height);
            }
        }
    }
    assert!(compared >= 30, "{compared}");
}
