//! Trim curves of any degree with weights, and NURBS curves: every pixel of 2048² is decided as an independent
//! computation does that evaluates the curves of the scene's text with their own knots.

use freeform_surface::Scene;
use glam::{DVec2, DVec3, UVec2};

use crate::harness::{Stage, load, root};

const SIDE: usize = 2048;
/// The distance from a curve within which a sample may be decided either way, in units of the domain.
const EITHER_WAY: f64 = 2e-7;

/// A B-spline curve as the text has it; a Bézier curve has the knots 0 and 1.
struct Curve {
    degree: usize,
    knots: Vec<f64>,
    /// (u, v, weight).
    points: Vec<DVec3>,
}

impl Curve {
    /// The point at a parameter, by the basis functions of Cox and de Boor.
    fn at(&self, t: f64) -> DVec2 {
        let Self { degree, knots, points } = self;
        let spans = *degree..points.len();
        let span = spans.rev().find(|i| knots[*i] <= t && knots[*i] < knots[i + 1]).unwrap();
        let mut basis = vec![0.0; points.len() + 1];
        basis[span] = 1.0;
        for order in 1..=*degree {
            for i in span - order..=span {
                let share = |from: usize, over: f64| {
                    let length = knots[from + order] - knots[from];
                    if length > 0.0 { over / length } else { 0.0 }
                };
                basis[i] = share(i, t - knots[i]) * basis[i]
                    + share(i + 1, knots[i + order + 1] - t) * basis[i + 1];
            }
        }
        let weighed = points.iter().zip(&basis);
        let sum: DVec3 = weighed.map(|(p, basis)| (p.truncate() * p.z).extend(p.z) * *basis).sum();
        sum.truncate() / sum.z
    }

    /// The curve as a fine polyline.
    fn polyline(&self) -> Vec<DVec2> {
        const STEPS: usize = 50_000;
        let spans = self.knots[self.degree..=self.points.len()].windows(2);
        let spans: Vec<_> = spans.filter(|span| span[0] < span[1]).collect();
        let at = |(span, step): (&&[f64], usize)| {
            let t = span[0] + (span[1] - span[0]) * step as f64 / STEPS as f64;
            self.at(t)
        };
        let steps = spans.iter().flat_map(|span| (0..=STEPS).map(move |step| (span, step)));
        steps.map(at).collect()
    }
}

/// The numbers of a list.
fn numbers(value: &toml::Value) -> Vec<f64> {
    let number = |value: &toml::Value| {
        value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64)).unwrap()
    };
    value.as_array().unwrap().iter().map(number).collect()
}

fn points(value: &toml::Value) -> Vec<DVec3> {
    let point = |value: &toml::Value| {
        let numbers = numbers(value);
        DVec3::new(numbers[0], numbers[1], numbers.get(2).copied().unwrap_or(1.0))
    };
    value.as_array().unwrap().iter().map(point).collect()
}

/// The loops of a scene's only surface, from its text.
fn loops(text: &str) -> Vec<Vec<Curve>> {
    let table: toml::Table = text.parse().unwrap();
    let trims = table["surface"][0]["trim"].as_array().unwrap();
    let bezier = |value: &toml::Value| {
        let points = points(value);
        let degree = points.len() - 1;
        let knots = [vec![0.0; points.len()], vec![1.0; points.len()]].concat();
        Curve { degree, knots, points }
    };
    let nurbs = |value: &toml::Value| Curve {
        degree: value["degree"].as_integer().unwrap() as usize,
        knots: numbers(&value["knots"]),
        points: points(&value["points"]),
    };
    let of_trim = |trim: &toml::Value| -> Vec<Curve> {
        match (trim.get("loop"), trim.get("nurbs")) {
            (Some(curves), None) => curves.as_array().unwrap().iter().map(bezier).collect(),
            (None, Some(curves)) => curves.as_array().unwrap().iter().map(nurbs).collect(),
            _ => panic!("no loop"),
        }
    };
    trims.iter().map(of_trim).collect()
}

/// For some rows, where polylines cross them.
struct Crossings {
    rows: Vec<(f64, Vec<f64>)>,
}

impl Crossings {
    /// Of the rows of pixels' centres, moved by `offset`.
    fn new(edges: &[[DVec2; 2]], offset: f64) -> Self {
        let center = |row: usize| (row as f64 + 0.5) / SIDE as f64 + offset;
        let mut rows: Vec<_> = (0..SIDE).map(|row| (center(row), Vec::new())).collect();
        for [a, b] in edges {
            let (low, high) = if a.y <= b.y { (a, b) } else { (b, a) };
            let first = ((low.y * SIDE as f64) as usize).saturating_sub(2);
            let last = ((high.y * SIDE as f64) as usize + 2).min(SIDE - 1);
            for (v, crossings) in &mut rows[first.min(SIDE - 1)..=last] {
                if low.y <= *v && *v < high.y {
                    crossings.push(low.x + (high.x - low.x) * (*v - low.y) / (high.y - low.y));
                }
            }
        }
        rows.iter_mut().for_each(|(_, crossings)| crossings.sort_by(f64::total_cmp));
        Self { rows }
    }

    /// Whether a place in a row is inside.
    fn inside(&self, row: usize, u: f64) -> bool {
        let crossings = &self.rows[row].1;
        (crossings.len() - crossings.partition_point(|crossing| *crossing <= u)) % 2 == 1
    }
}

fn check(name: &str) -> Vec<bool> {
    let path = root().join(format!("resources/scenes/stability/trim-{name}.toml"));
    let loops = loops(&std::fs::read_to_string(&path).unwrap());
    let edges: Vec<[DVec2; 2]> = loops
        .iter()
        .flat_map(|curves| {
            let mut corners: Vec<DVec2> = curves.iter().flat_map(Curve::polyline).collect();
            corners.push(corners[0]);
            corners.windows(2).map(|pair| [pair[0], pair[1]]).collect::<Vec<_>>()
        })
        .collect();
    let rows = [-EITHER_WAY, 0.0, EITHER_WAY].map(|offset| Crossings::new(&edges, offset));
    let cut = cut_by_gpu(&load(&path));
    let (mut wrong, mut close) = (0, 0);
    for (i, cut) in cut.iter().enumerate() {
        let (row, u) = (i / SIDE, ((i % SIDE) as f64 + 0.5) / SIDE as f64);
        let inside = rows[1].inside(row, u);
        let around = rows
            .iter()
            .flat_map(|rows| [-EITHER_WAY, EITHER_WAY].map(|offset| rows.inside(row, u + offset)));
        if around.into_iter().any(|other| other != inside) {
            close += 1;
        } else if *cut != inside {
            wrong += 1;
        }
    }
    assert_eq!(wrong, 0, "{name}: wrong pixels");
    assert!(close < 100, "{name}: {close} pixels may be either way");
    cut
}

/// The pixels that the GPU cuts out, bottom row first.
fn cut_by_gpu(scene: &Scene) -> Vec<bool> {
    let row = 4 * SIDE;
    let image = Stage::new(UVec2::splat(SIDE as u32)).render(scene);
    image.chunks_exact(row).rev().flat_map(|row| row.chunks_exact(4)).map(|p| p[3] == 0).collect()
}

#[test]
fn rational_circles_are_cut_as_circles() {
    let cut = check("rational-circle");
    // The same by the circles' equation.
    let mut inside = 0;
    for (i, cut) in cut.iter().enumerate() {
        let [u, v] = [i % SIDE, i / SIDE].map(|i| (i as f64 + 0.5) / SIDE as f64);
        let beyond = [(0.35, 0.25), (0.75, 0.2)]
            .map(|(center, radius)| DVec2::new(u, v).distance(DVec2::splat(center)) - radius);
        let nearest = beyond[0].min(beyond[1]);
        if nearest.abs() > EITHER_WAY {
            assert_eq!(*cut, nearest < 0.0, "({u}, {v})");
            inside += usize::from(*cut);
        }
    }
    assert!(inside > 1_000_000, "{inside}");
}

#[test]
fn a_curve_of_degree_11_is_cut_as_its_own_points_say() {
    let cut = check("degree-11");
    assert!(cut.iter().filter(|cut| **cut).count() > 500_000);
}

#[test]
fn nurbs_curves_are_cut_as_their_own_knots_say() {
    let cut = check("nurbs");
    assert!(cut.iter().filter(|cut| **cut).count() > 500_000);
}

#[test]
fn wrong_curves_are_refused_with_their_line() {
    let refused = |trim: &str, words: &[&str]| {
        let text = format!("[[surface]]\ncontrol_points = \"default\"\n[[surface.trim]]\n{trim}\n");
        let error = Scene::from_toml(&text, "x.toml".as_ref()).unwrap_err().to_string();
        assert!(error.starts_with("x.toml:") && error.lines().count() == 1, "{error}");
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
    };
    let points = "[[0.1, 0.1], [0.5, 0.1, 2.0], [0.1, 0.1]]";
    let nurbs = |degree: &str, knots: &str| {
        format!("nurbs = [{{ degree = {degree}, knots = {knots}, points = {points} }}]")
    };
    refused(&nurbs("0", "[0, 1]"), &["x.toml:3:", "loop 0", "segment 0", "degree", "1 to 15"]);
    refused(&nurbs("2", "[0, 0, 1, 1]"), &["number of knots", "is 4", "6, points"]);
    refused(&nurbs("1", "[0, 0, 2, 1, 3]"), &["knot 3", "is 1", "at least 2"]);
    refused(&nurbs("2", "[0, 0, 0, 0, 0, 0]"), &["domain", "0 to 0"]);
    refused("loop = [[[0.1, 0.1], [0.5, 0.1, -2.0], [0.1, 0.1]]]", &["weight of point 1", "-2"]);
    refused("loop = [[[0.1, 0.1], [0.5, 0.1, 2.0, 1.0], [0.1, 0.1]]]", &["[u, v, weight]"]);
    refused("loop = [[[0.1, 0.1]]]", &["number of points", "is 1", "2 to 16"]);
    let twice = format!("loop = [{points}]\n{}", nurbs("2", "[0, 0, 0, 1, 1, 1]"));
    refused(&twice, &["loop beside nurbs"]);
}
