//! The stored models are closed solids: every edge has two uses in opposite directions, edges meet end to end and lie
//! on their surfaces, and the volumes are those of the shapes. Curves and surfaces are evaluated here by their
//! formulas.

use std::f64::consts::PI;
use std::path::Path;

use freeform_surface::glam::{DVec2, DVec3, DVec4, dvec2};
use freeform_surface::model::{
    BoundedCurve, Coedge, Curve, Face, FaceSurface, Frame, Model, NurbsCurve,
};

#[path = "../../examples/make_models/assembly.rs"]
mod assembly;
#[path = "../../examples/make_models/blade.rs"]
mod blade;
#[path = "../../examples/make_models/bracket.rs"]
mod bracket;
#[path = "../../examples/make_models/flange.rs"]
mod flange;
#[path = "../../examples/make_models/solid.rs"]
pub(crate) mod solid;

const NAMES: [&str; 4] = ["assembly", "blade", "bracket", "flange"];

fn path(name: &str) -> String {
    format!("{}/resources/models/{name}.ffm", env!("CARGO_MANIFEST_DIR"))
}

fn load(name: &str) -> Model {
    let file = std::fs::File::open(path(name)).unwrap();
    Model::read(std::io::BufReader::new(file), Path::new(&path(name))).unwrap()
}

/// The value of a B-spline basis function, by its recursive definition.
fn basis(knots: &[f64], degree: usize, i: usize, t: f64) -> f64 {
    if degree == 0 {
        let last = knots[knots.len() - 1];
        let is_end = t == last && knots[i] < t && knots[i + 1] == last;
        return f64::from((knots[i] <= t && t < knots[i + 1]) || is_end);
    }
    let share = |from: f64, to: f64| if from == to { 0.0 } else { (t - from) / (to - from) };
    let (first, second) = (&knots[i..=i + degree], &knots[i + 1..=i + degree + 1]);
    let mut sum = share(first[0], first[degree]) * basis(knots, degree - 1, i, t);
    if second[0] < second[degree] {
        sum += (1.0 - share(second[0], second[degree])) * basis(knots, degree - 1, i + 1, t);
    }
    sum
}

fn on_ellipse(frame: &Frame, radii: [f64; 2], t: f64) -> DVec3 {
    frame.origin + radii[0] * t.cos() * frame.x + radii[1] * t.sin() * frame.y
}

fn on_curve(BoundedCurve { curve, .. }: &BoundedCurve, t: f64) -> DVec3 {
    match curve {
        Curve::Line { origin, direction } => *origin + t * *direction,
        Curve::Circle { frame, radius } => on_ellipse(frame, [*radius; 2], t),
        Curve::Ellipse { frame, radii } => on_ellipse(frame, *radii, t),
        Curve::Nurbs(curve) => {
            let point = |point: &DVec4| (point.truncate() * point.w).extend(point.w);
            let sum: DVec4 = blend(curve, t, point);
            sum.truncate() / sum.w
        }
    }
}

fn blend<P, Q: std::ops::Mul<f64, Output = Q> + std::iter::Sum>(
    curve: &NurbsCurve<P>,
    t: f64,
    point: impl Fn(&P) -> Q,
) -> Q {
    let factor = |i: usize| basis(curve.knots(), curve.degree(), i, t);
    curve.control_points().iter().enumerate().map(|(i, p)| point(p) * factor(i)).sum()
}

fn on_surface(surface: &FaceSurface, at: DVec2) -> DVec3 {
    let (u, v) = (at.x, at.y);
    let around = |frame: &Frame| u.cos() * frame.x + u.sin() * frame.y;
    match surface {
        FaceSurface::Plane(frame) => frame.origin + u * frame.x + v * frame.y,
        FaceSurface::Cylinder { frame, radius } => {
            frame.origin + *radius * around(frame) + v * frame.z
        }
        FaceSurface::Cone { frame, radius, half_angle } => {
            let (sine, cosine) = half_angle.sin_cos();
            frame.origin + (radius + v * sine) * around(frame) + v * cosine * frame.z
        }
        FaceSurface::Sphere { frame, radius } => {
            frame.origin + *radius * (v.cos() * around(frame) + v.sin() * frame.z)
        }
        FaceSurface::Nurbs(surface) => {
            let ([knots_u, knots_v], degree) = (surface.knots(), surface.degree());
            let mut sum = DVec4::ZERO;
            for (row, points) in surface.control_points().chunks(surface.columns()).enumerate() {
                let of_row = basis(knots_v, degree.v(), row, v);
                for (column, p) in points.iter().enumerate() {
                    let factor = of_row * basis(knots_u, degree.u(), column, u);
                    sum += (p.truncate() * p.w).extend(p.w) * factor;
                }
            }
            sum.truncate() / sum.w
        }
        _ => unreachable!("no stored model has such a surface"),
    }
}

/// The parameters of the point of a surface that is nearest to a point beside it.
fn nearest(surface: &FaceSurface, point: DVec3) -> DVec2 {
    let local = |frame: &Frame| {
        let offset = point - frame.origin;
        DVec3::new(offset.dot(frame.x), offset.dot(frame.y), offset.dot(frame.z))
    };
    match surface {
        FaceSurface::Plane(frame) => local(frame).truncate(),
        FaceSurface::Cylinder { frame, .. } => {
            let at = local(frame);
            dvec2(at.y.atan2(at.x), at.z)
        }
        FaceSurface::Cone { frame, radius, half_angle } => {
            let at = local(frame);
            let (sine, cosine) = half_angle.sin_cos();
            dvec2(at.y.atan2(at.x), (at.truncate().length() - radius) * sine + at.z * cosine)
        }
        FaceSurface::Sphere { frame, .. } => {
            let at = local(frame);
            dvec2(at.y.atan2(at.x), at.z.atan2(at.truncate().length()))
        }
        _ => unreachable!("faces on other surfaces have p-curves"),
    }
}

fn curve_of<'a>(model: &'a Model, coedge: &Coedge) -> &'a BoundedCurve {
    model.edges[coedge.edge].curve.as_ref().expect("the stored models have no points as edges")
}

/// Points along a coedge in its direction: in the surface's parameters and in space.
fn samples(model: &Model, face: &Face, coedge: &Coedge, count: usize) -> Vec<(DVec2, DVec3)> {
    let curve = curve_of(model, coedge);
    let sample = |i: usize| {
        let share = i as f64 / count as f64;
        let share = if coedge.forward { share } else { 1.0 - share };
        let [first, last] = curve.range;
        let point = on_curve(curve, first + share * (last - first));
        let at = coedge.pcurve.as_ref().map(|pcurve| {
            let [first, last] = pcurve.domain();
            let weighted = |p: &DVec3| DVec3::new(p.x * p.z, p.y * p.z, p.z);
            let sum: DVec3 = blend(pcurve, first + share * (last - first), weighted);
            sum.truncate() / sum.z
        });
        (at.unwrap_or_else(|| nearest(&face.surface, point)), point)
    };
    (0..=count).map(sample).collect()
}

/// The volume between the origin and a surface, per area of its parameters.
fn density(surface: &FaceSurface, at: DVec2) -> f64 {
    if let FaceSurface::Nurbs(surface) = surface {
        let at = surface.at(at.x, at.y);
        return at.position.dot(at.du.cross(at.dv)) / 3.0;
    }
    let step = 1e-5;
    let along = |direction: DVec2| {
        (on_surface(surface, at + step * direction) - on_surface(surface, at - step * direction))
            / (2.0 * step)
    };
    on_surface(surface, at).dot(along(DVec2::X).cross(along(DVec2::Y))) / 3.0
}

/// The volume between the origin and a face, by Green's theorem along its loops. It is negative where the outside faces
/// the origin.
fn volume(model: &Model, face: &Face) -> f64 {
    let low = face.bounds[0].y;
    // The density along v up to a place, by Gauss' rule of three points.
    let up_to = |at: DVec2| -> f64 {
        let step = (at.y - low) / 8.0;
        let at_share = |i: i32, share: f64| {
            density(&face.surface, dvec2(at.x, low + (f64::from(i) + share) * step))
        };
        let off = 0.15_f64.sqrt();
        (0..8)
            .map(|i| {
                (5.0 * (at_share(i, 0.5 - off) + at_share(i, 0.5 + off)) + 8.0 * at_share(i, 0.5))
                    * step
                    / 18.0
            })
            .sum()
    };
    let is_round = !matches!(face.surface, FaceSurface::Plane(_) | FaceSurface::Nurbs(_));
    let mut sum = 0.0;
    for coedges in &face.loops {
        let mut before: Option<DVec2> = None;
        for coedge in coedges {
            let mut first = true;
            for (mut at, _) in samples(model, face, coedge, 100) {
                if let Some(before) = before {
                    if is_round {
                        at.x += 2.0 * PI * ((before.x - at.x) / (2.0 * PI)).round();
                    }
                    // The ends of neighbours are the same place.
                    if !first {
                        sum -= (up_to(at) + up_to(before)) / 2.0 * (at.x - before.x);
                    }
                }
                before = Some(at);
                first = false;
            }
        }
    }
    if face.reversed { -sum } else { sum }
}

/// The volume of the faces of a product, without those of its uses.
fn volume_of(model: &Model, product: usize) -> f64 {
    let [first, count] = model.products[product].faces;
    model.faces[first..first + count].iter().map(|face| volume(model, face)).sum()
}

#[test]
fn stored_models_are_what_their_example_writes() {
    for model in [assembly::model(), blade::model(), bracket::model(), flange::model()] {
        let model = model.unwrap();
        let mut text = Vec::new();
        model.write(&mut text).unwrap();
        let stored = std::fs::read(path(&model.name)).unwrap();
        assert!(text == stored, "{}: run the example make_models", model.name);
        assert!(text.len() < 200_000, "{} has {} bytes", model.name, text.len());
        assert_eq!(load(&model.name), model);
    }
}

#[test]
fn every_edge_has_two_uses_in_opposite_directions() {
    for name in NAMES {
        let model = load(name);
        let mut uses = vec![Vec::new(); model.edges.len()];
        for face in &model.faces {
            for coedge in face.loops.iter().flatten() {
                uses[coedge.edge].push(coedge.forward != face.reversed);
            }
        }
        for (edge, uses) in uses.iter().enumerate() {
            assert!(
                matches!(uses[..], [true, false] | [false, true]),
                "{name}: edge {edge}: {uses:?}"
            );
        }
        // Every face belongs to one product.
        let mut next = 0;
        for product in &model.products {
            assert_eq!(product.faces[0], next, "{name}: {}", product.name);
            next += product.faces[1];
        }
        assert_eq!(next, model.faces.len(), "{name}");
    }
}

#[test]
fn edges_meet_end_to_end_and_lie_on_their_surfaces() {
    for name in NAMES {
        let model = load(name);
        for (number, face) in model.faces.iter().enumerate() {
            let place = format!("{name}: face {number} {}", face.name);
            for coedges in &face.loops {
                let ends: Vec<_> =
                    coedges.iter().map(|coedge| samples(&model, face, coedge, 1)).collect();
                for (i, end) in ends.iter().enumerate() {
                    let next = &ends[(i + 1) % ends.len()];
                    let gap = end[1].1.distance(next[0].1);
                    assert!(gap < 1e-9, "{place}: {gap} after edge {}", coedges[i].edge);
                    if coedges[i].pcurve.is_some() {
                        assert!(end[1].0.distance(next[0].0) < 1e-12, "{place}: {i}");
                    }
                }
                for coedge in coedges {
                    for (at, point) in samples(&model, face, coedge, 40) {
                        let off = on_surface(&face.surface, at).distance(point);
                        assert!(off < 1e-9, "{place}: edge {} is {off} off", coedge.edge);
                        // Angles may be whole turns away from the bounds.
                        let [low, high] = face.bounds;
                        let turn = |u: f64| {
                            (0..=1).any(|turn| {
                                let u = u + f64::from(turn) * 2.0 * PI;
                                (low.x - 1e-9..=high.x + 1e-9).contains(&u)
                            })
                        };
                        assert!(turn(at.x), "{place}: u = {} outside of {low} to {high}", at.x);
                        assert!(
                            (low.y - 1e-9..=high.y + 1e-9).contains(&at.y),
                            "{place}: v = {}",
                            at.y
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn volumes_are_those_of_the_shapes() {
    let near = |name: &str, volume: f64, expected: f64| {
        println!("{name}: {volume} mm³");
        assert!((volume / expected - 1.0).abs() < 2e-3, "{name}: {volume}, expected {expected}");
    };
    let frustum = |a: f64, b: f64, height: f64| PI * height * (a * a + a * b + b * b) / 3.0;
    let disc = |radius: f64, height: f64| PI * radius * radius * height;
    let holes = 6.0 * (disc(4.5, 10.5) + frustum(4.5, 6.0, 1.5));
    let flange =
        disc(50.0, 10.5) + frustum(50.0, 48.5, 1.5) + disc(25.0, 17.0) + frustum(25.0, 24.0, 1.0)
            - disc(15.0, 30.0)
            - holes;
    near("flange", volume_of(&load("flange"), 0), flange);
    let inner = (1.0 - PI / 4.0) * 64.0;
    let rounded = (1.0 - PI / 4.0) * 16.0 * (56.0 + 36.0 + 46.0) + (1.0 - PI / 6.0) * 64.0;
    let bracket = (600.0 + 400.0 + inner) * 40.0 - rounded - 2.0 * disc(5.0, 10.0);
    near("bracket", volume_of(&load("bracket"), 0), bracket);
    let assembly = load("assembly");
    let hexagon = 13.0 * 13.0 * 3_f64.sqrt() / 2.0;
    near("bolt", volume_of(&assembly, 0), hexagon * 5.5 + disc(4.0, 20.0) + frustum(3.0, 4.0, 1.0));
    near("plate", volume_of(&assembly, 1), (4800.0 - 200.0) * 12.0 - 4.0 * disc(4.5, 12.0));
    let blade = load("blade");
    near("blade", volume_of(&blade, 0), volume_by_sections(&blade));
}

/// The volume of the blade by the areas of its sections: the surface's v goes up with the height, which is the same
/// along each row of control points.
fn volume_by_sections(blade: &Model) -> f64 {
    let surface = &blade.faces[0].surface;
    let section = |v: f64| {
        let outline: Vec<DVec3> =
            (0..200).map(|i| on_surface(surface, dvec2(f64::from(i) / 200.0, v))).collect();
        let area: f64 = (0..200)
            .map(|i| outline[i].truncate().perp_dot(outline[(i + 1) % 200].truncate()) / 2.0)
            .sum();
        (outline[0].z, area)
    };
    let sections: Vec<_> = (0..=60).map(|i| section(f64::from(i) / 60.0)).collect();
    sections.windows(2).map(|pair| (pair[1].0 - pair[0].0) * (pair[0].1 + pair[1].1) / 2.0).sum()
}

#[test]
fn the_assembly_shows_every_bolt_in_its_place() {
    let model = load("assembly");
    let instances = model.instances().unwrap();
    assert_eq!(instances.len(), 2 * (11 + 4 * 11));
    let mirrored = instances.iter().filter(|i| i.placement.matrix3.determinant() < 0.0).count();
    assert_eq!(mirrored, instances.len() / 2);
    let red = instances.iter().filter(|i| i.color == Some([0.8, 0.2, 0.15])).count();
    assert_eq!(red, 2 * 11);
    let plates = instances.iter().filter(|i| i.color == model.products[1].color).count();
    assert_eq!(plates, 2 * 11);
}
