//! B-splines by their definition; and the trims of a scene's only surface, read from its text and decided without the
//! library: curves are evaluated with their own knots, and circles, ellipses and rectangles by their equations.

use freeform_surface::NurbsSurface;
use glam::{DVec2, DVec3, DVec4};

/// A B-spline curve as the text has it; a Bézier curve has the knots 0 and 1.
struct Curve {
    degree: usize,
    knots: Vec<f64>,
    /// (u, v, weight).
    points: Vec<DVec3>,
}

/// The B-spline basis functions at a parameter, by the recursion of Cox and de Boor.
fn basis_functions(degree: usize, knots: &[f64], t: f64) -> Vec<f64> {
    let count = knots.len() - degree - 1;
    let span = (degree..count).rev().find(|i| knots[*i] <= t && knots[*i] < knots[i + 1]);
    let span = span.expect("a parameter of the domain");
    let mut basis = vec![0.0; count + 1];
    basis[span] = 1.0;
    for order in 1..=degree {
        for i in span - order..=span {
            let share = |from: usize, over: f64| {
                let length = knots[from + order] - knots[from];
                if length > 0.0 { over / length } else { 0.0 }
            };
            basis[i] = share(i, t - knots[i]) * basis[i]
                + share(i + 1, knots[i + order + 1] - t) * basis[i + 1];
        }
    }
    basis.truncate(count);
    basis
}

/// The point of a surface by its definition.
pub fn by_definition(nurbs: &NurbsSurface, place: DVec2) -> DVec3 {
    let [u, v] = nurbs.knots();
    let along_u = basis_functions(nurbs.degree().u(), u, place.x);
    let along_v = basis_functions(nurbs.degree().v(), v, place.y);
    let mut sum = DVec4::ZERO;
    for (row, b) in nurbs.control_points().chunks(nurbs.columns()).zip(&along_v) {
        for (point, a) in row.iter().zip(&along_u) {
            sum += (point.truncate() * point.w).extend(point.w) * (a * b);
        }
    }
    sum.truncate() / sum.w
}

impl Curve {
    fn at(&self, t: f64) -> DVec2 {
        let basis = basis_functions(self.degree, &self.knots, t);
        let weighed = self.points.iter().zip(&basis);
        let sum: DVec3 = weighed.map(|(p, basis)| (p.truncate() * p.z).extend(p.z) * *basis).sum();
        sum.truncate() / sum.z
    }

    /// The curve as a fine polyline.
    fn polyline(&self) -> Vec<DVec2> {
        const STEPS: usize = 20_000;
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
    value.as_array().unwrap().iter().map(number).collect()
}

fn number(value: &toml::Value) -> f64 {
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64)).unwrap()
}

fn pair(value: &toml::Value) -> DVec2 {
    DVec2::from_slice(&numbers(value))
}

fn points(value: &toml::Value) -> Vec<DVec3> {
    let point = |value: &toml::Value| {
        let numbers = numbers(value);
        DVec3::new(numbers[0], numbers[1], numbers.get(2).copied().unwrap_or(1.0))
    };
    value.as_array().unwrap().iter().map(point).collect()
}

/// The curves of a loop, if the trim is one.
fn curves(trim: &toml::Value) -> Option<Vec<Curve>> {
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
    match (trim.get("loop"), trim.get("nurbs")) {
        (Some(curves), None) => Some(curves.as_array().unwrap().iter().map(bezier).collect()),
        (None, Some(curves)) => Some(curves.as_array().unwrap().iter().map(nurbs).collect()),
        _ => None,
    }
}

/// The trims of a surface.
pub struct TrimText {
    /// First and last parameters of the domain.
    pub domain: [DVec2; 2],
    /// The sizes of the smallest patch.
    pub patch: DVec2,
    keeps_inside: bool,
    /// The edges of the loops as polylines, for each of some rows of the domain that they touch.
    rows: Vec<Vec<[DVec2; 2]>>,
    /// Centres and radii.
    ellipses: Vec<[DVec2; 2]>,
    /// Ranges of u and v.
    rects: Vec<[DVec2; 2]>,
}

const ROWS: usize = 2048;

impl TrimText {
    pub fn new(text: &str) -> Self {
        let table: toml::Table = text.parse().unwrap();
        let surface = &table["surface"][0];
        let (mut domain, mut patch) = ([DVec2::ZERO, DVec2::ONE], DVec2::ONE);
        if let Some(knots) = surface.get("knots") {
            for axis in 0..2 {
                let degree = surface["degree"][axis].as_integer().unwrap() as usize;
                let knots = numbers(&knots[axis]);
                let inside = &knots[degree..knots.len() - degree];
                domain[0][axis] = inside[0];
                domain[1][axis] = inside[inside.len() - 1];
                let spans = inside.windows(2).map(|pair| pair[1] - pair[0]);
                patch[axis] = spans.filter(|span| *span > 0.0).fold(f64::INFINITY, f64::min);
            }
        }
        let keeps_inside = surface.get("keep").is_some_and(|keep| keep.as_str() == Some("inside"));
        let mut all = Self {
            domain,
            patch,
            keeps_inside,
            rows: vec![Vec::new(); ROWS],
            ellipses: Vec::new(),
            rects: Vec::new(),
        };
        for trim in surface["trim"].as_array().unwrap() {
            if let Some(curves) = curves(trim) {
                all.add_loop(&curves.iter().flat_map(Curve::polyline).collect::<Vec<_>>());
            } else if let Some(circle) = trim.get("circle") {
                let radius = DVec2::splat(number(&circle["radius"]));
                all.ellipses.push([pair(&circle["center"]), radius]);
            } else if let Some(ellipse) = trim.get("ellipse") {
                all.ellipses.push([pair(&ellipse["center"]), pair(&ellipse["radii"])]);
            } else {
                let interval = &trim["interval"];
                all.rects.push([pair(&interval["u"]), pair(&interval["v"])]);
            }
        }
        all
    }

    fn row_of(&self, v: f64) -> usize {
        let [low, high] = self.domain;
        (((v - low.y) / (high.y - low.y) * ROWS as f64) as usize).min(ROWS - 1)
    }

    fn add_loop(&mut self, corners: &[DVec2]) {
        for i in 0..corners.len() {
            let edge = [corners[i], corners[(i + 1) % corners.len()]];
            let [a, b] = edge.map(|end| self.row_of(end.y));
            for row in &mut self.rows[a.min(b)..=a.max(b)] {
                row.push(edge);
            }
        }
    }

    /// Whether a place of the domain is cut.
    pub fn cut(&self, uv: DVec2) -> bool {
        let in_ellipse = |[center, radii]: &[DVec2; 2]| ((uv - *center) / *radii).length() <= 1.0;
        let in_rect =
            |[u, v]: &[DVec2; 2]| (u.x..=u.y).contains(&uv.x) && (v.x..=v.y).contains(&uv.y);
        if self.ellipses.iter().any(in_ellipse) || self.rects.iter().any(in_rect) {
            return true;
        }
        let row = &self.rows[self.row_of(uv.y)];
        let crosses = |[a, b]: &&[DVec2; 2]| {
            (a.y <= uv.y) != (b.y <= uv.y)
                && uv.x < a.x + (b.x - a.x) * ((uv.y - a.y) / (b.y - a.y))
        };
        (row.iter().filter(crosses).count() % 2 == 1) != self.keeps_inside
    }

    /// Whether a decision is right, where one within `distance` along u or v may be either way. `None`: it may.
    pub fn judge(&self, uv: DVec2, cut: bool, distance: DVec2) -> Option<bool> {
        if self.cut(uv) == cut {
            return Some(true);
        }
        let around = [-1.0, 0.0, 1.0].map(|x| [-1.0, 0.0, 1.0].map(|y| DVec2::new(x, y)));
        let either = around.as_flattened().iter().any(|off| self.cut(uv + *off * distance) == cut);
        (!either).then_some(false)
    }
}
