//! How faces meet along edges, against closed forms: solids of simple shapes, and a surface that is cut at a knot.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::path::Path;

use freeform_surface::glam::{DMat3, DVec2, DVec3, DVec4, dvec2, dvec3};
use freeform_surface::model::{
    BoundedCurve, Continuity, Curve, Edge, EdgeContinuity, Face, FaceSurface, Frame, Model,
    NurbsCurve, Product,
};
use freeform_surface::{Degree, LoadOptions, NurbsSurface};

use super::model_solids::solid::{Builder, Ring, coedge, upright};

fn finished(mut builder: Builder) -> Model {
    builder.product("solid", None);
    builder.model
}

/// The vertices of a box from −a to a. `c` is where its faces end, a − radius: the vertex on the face across an axis.
fn vertex(signs: DVec3, axis: usize, [a, c]: [f64; 2]) -> DVec3 {
    let mut vertex = c * signs;
    vertex[axis] = a * signs[axis];
    vertex
}

fn corners() -> impl Iterator<Item = DVec3> {
    let sign = |i: usize, axis: usize| if i >> axis & 1 == 0 { -1.0 } else { 1.0 };
    (0..8).map(move |i| dvec3(sign(i, 0), sign(i, 1), sign(i, 2)))
}

fn add_planes(builder: &mut Builder, size: [f64; 2]) {
    for axis in 0..3 {
        let [k, l] = [(axis + 1) % 3, (axis + 2) % 3];
        for side in [-1.0, 1.0] {
            let points = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| {
                let mut signs = DVec3::ZERO;
                (signs[axis], signs[k], signs[l]) = (side, x, y);
                vertex(signs, axis, size)
            });
            builder.polygon(side * DVec3::AXES[axis], &points, &[]);
        }
    }
}

/// A cube from −1 to 1 whose edges and corners have a radius.
fn rounded_cube(radius: f64) -> Model {
    let size = [1.0, 1.0 - radius];
    let c = size[1];
    let mut builder = Builder::new("rounded");
    for signs in corners() {
        for axis in 0..3 {
            let [from, to] = [axis, (axis + 1) % 3].map(|axis| vertex(signs, axis, size));
            builder.arc(c * signs, from, to);
        }
    }
    add_planes(&mut builder, size);
    for axis in 0..3 {
        let [k, l] = [(axis + 1) % 3, (axis + 2) % 3];
        for signs in corners().filter(|signs| signs[axis] < 0.0) {
            let mut other = signs;
            other[axis] = 1.0;
            let [mut origin, z] = [c * signs, DVec3::AXES[axis]];
            origin[axis] = 0.0;
            let frame =
                Frame { origin, x: signs[k] * DVec3::AXES[k], y: signs[l] * DVec3::AXES[l], z };
            let points = [(signs, k), (signs, l), (other, l), (other, k)]
                .map(|(signs, axis)| vertex(signs, axis, size));
            let chain = builder.chain(&points);
            let bounds = [dvec2(0.0, -c), dvec2(FRAC_PI_2, c)];
            let is_left = signs[k] * signs[l] < 0.0;
            builder.face(FaceSurface::Cylinder { frame, radius }, is_left, bounds, vec![chain]);
        }
    }
    for signs in corners() {
        let [x, y, z] = [0, 1, 2].map(|axis| signs[axis] * DVec3::AXES[axis]);
        let frame = Frame { origin: c * signs, x, y, z };
        let chain = builder.chain(&[0, 1, 2].map(|axis| vertex(signs, axis, size)));
        let is_left = signs.element_product() < 0.0;
        let bounds = [DVec2::ZERO, DVec2::splat(FRAC_PI_2)];
        builder.face(FaceSurface::Sphere { frame, radius }, is_left, bounds, vec![chain]);
    }
    finished(builder)
}

fn assert_near(found: f64, expected: f64, most: f64, what: &str) {
    assert!((found - expected).abs() <= most, "{what}: {found}, not {expected}");
}

/// The values of an edge: gap, angle, and the jump of curvature if there is one.
fn values(edge: &EdgeContinuity) -> (f64, f64, Option<f64>) {
    let [gap, angle] = [edge.gap, edge.angle].map(|worst| worst.unwrap().value);
    assert!(edge.off_edge.value < 1e-9 || edge.class == Continuity::Gap, "{edge:?}");
    (gap, angle, edge.curvature.map(|worst| worst.value))
}

#[test]
fn a_cube_has_right_angles() {
    let mut builder = Builder::new("cube");
    add_planes(&mut builder, [1.0, 1.0]);
    let edges = finished(builder).continuity().unwrap();
    assert_eq!(edges.len(), 12);
    for edge in &edges {
        let (gap, angle, jump) = values(edge);
        assert!(gap < 1e-12 && jump.is_none() && edge.class == Continuity::G0, "{edge:?}");
        assert_near(angle, 90.0, 1e-9, "angle");
        assert_eq!(edge.angle.unwrap().point.abs().to_array().map(|x| x == 1.0), [true; 3]);
    }
}

#[test]
fn a_rounded_cube_is_smooth_and_its_curvature_jumps() {
    let radius = 0.25;
    let edges = rounded_cube(radius).continuity().unwrap();
    assert_eq!(edges.len(), 48);
    for edge in &edges {
        let (gap, angle, jump) = values(edge);
        assert!(gap < 1e-12 && angle < 1e-6 && edge.class == Continuity::G1, "{edge:?}");
        assert_near(jump.unwrap(), 1.0 / radius, 1e-9, "jump");
        assert_near(edge.relative_jump.unwrap().value, 1.0, 1e-9, "relative jump");
    }
}

#[test]
fn cylinders_and_cones() {
    let (axis, ring) = (upright(dvec3(3.0, -2.0, 1.0)), Ring { is_outer: true, has_seam: true });
    let mut builder = Builder::new("pin");
    let circles = [(2.0, 0.0), (2.0, 3.0), (1.0, 4.0)];
    let [low, middle, high] = circles.map(|(radius, height)| builder.circle(&axis, radius, height));
    builder.disc(-DVec3::Z, low, &[]);
    builder.ring(&axis, [low, middle], &ring);
    builder.ring(&axis, [middle, high], &ring);
    builder.disc(DVec3::Z, high, &[]);
    let edges = finished(builder).continuity().unwrap();
    assert_eq!(edges.len(), 5);
    for edge in &edges {
        let (gap, angle, jump) = values(edge);
        assert!(gap < 1e-12, "{edge:?}");
        let (class, expected) = match edge.faces[..] {
            [0, 1] => (Continuity::G0, 90.0),
            [1, 2] | [2, 3] => (Continuity::G0, FRAC_PI_4.to_degrees()),
            // The seams.
            _ => (Continuity::G2, 0.0),
        };
        assert_near(angle, expected, 1e-6, "angle");
        assert_eq!((edge.class, edge.faces[0] == edge.faces[1]), (class, expected == 0.0));
        assert!(jump.is_none_or(|jump| jump < 1e-9), "{edge:?}");
    }
}

/// x and y are the parameters, z = 0.3 x² + 0.5 x (y − 0.4)² + c (x − 1)₊ᵏ for x from 0 to 2 and y from 0 to 1: a
/// B-spline surface of degrees 3 and 2 whose derivative of order k jumps by k! c at x = 1.
fn creased(k: usize, c: f64) -> NurbsSurface {
    let mut knots = vec![0.0; 4];
    knots.extend(vec![1.0; 4 - k]);
    knots.extend([2.0; 4]);
    let mut points = Vec::new();
    for j in 0..3 {
        let y = 0.5 * f64::from(j);
        let height = [0.16, -0.24, 0.36][j as usize];
        for i in 1..knots.len() - 3 {
            // Control points are values of the polar form at three knots.
            let polar = |origin: f64, order: usize| {
                let [a, b, c] = [0, 1, 2].map(|n| knots[i + n] - origin);
                [(a + b + c) / 3.0, (a * b + a * c + b * c) / 3.0, a * b * c][order - 1]
            };
            let beyond = if knots[i + 2] > 1.0 { polar(1.0, k) } else { 0.0 };
            let z = 0.3 * polar(0.0, 2) + 0.5 * polar(0.0, 1) * height + c * beyond;
            points.push(DVec4::new(polar(0.0, 1), y, z, 1.0));
        }
    }
    let along_v = vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0];
    NurbsSurface::new(Degree::new(3, 2).unwrap(), [knots, along_v], points).unwrap()
}

/// The two parts of such a surface before and after u = t, by inserting the knot until it has multiplicity 3 (Boehm).
fn cut(surface: &NurbsSurface, t: f64) -> [NurbsSurface; 2] {
    let mut knots = surface.knots()[0].clone();
    let mut rows: Vec<Vec<DVec4>> =
        surface.control_points().chunks(surface.columns()).map(<[DVec4]>::to_vec).collect();
    let last = |knots: &[f64]| knots.partition_point(|knot| *knot <= t) - 1;
    while knots.iter().filter(|knot| **knot == t).count() < 3 {
        let k = last(&knots);
        let multiplicity = knots.iter().filter(|knot| **knot == t).count();
        for row in &mut rows {
            let point = |i: usize| {
                if i + 3 <= k {
                    return row[i];
                }
                if i > k - multiplicity {
                    return row[i - 1];
                }
                row[i - 1].lerp(row[i], (t - knots[i]) / (knots[i + 3] - knots[i]))
            };
            *row = (0..=row.len()).map(point).collect();
        }
        knots.insert(k + 1, t);
    }
    let k = last(&knots);
    let part = |knots: Vec<f64>, columns: std::ops::Range<usize>| {
        let points = rows.iter().flat_map(|row| row[columns.clone()].to_vec()).collect();
        let along_v = surface.knots()[1].clone();
        NurbsSurface::new(surface.degree(), [knots, along_v], points).unwrap()
    };
    let left = knots[..=k].iter().copied().chain([t]).collect();
    let right = [t].into_iter().chain(knots[k - 2..].iter().copied()).collect();
    [part(left, 0..k - 2), part(right, k - 3..rows[0].len())]
}

/// Two faces that share an edge: the last column of the first surface, where the second one begins.
fn pair([left, right]: &[NurbsSurface; 2]) -> Model {
    let curve = |degree: usize, knots: &[f64], points: Vec<DVec4>| {
        let curve = NurbsCurve::new(degree, knots.to_vec(), points).unwrap();
        let range = curve.domain();
        let curve = Some(BoundedCurve { curve: Curve::Nurbs(curve), range });
        Edge { tolerance: 1e-7, curve }
    };
    let column = |of: &NurbsSurface, i: usize| {
        let points = of.control_points().iter().skip(i).step_by(of.columns()).copied();
        curve(2, &of.knots()[1], points.collect())
    };
    let row = |of: &NurbsSurface, j: usize| {
        let points = of.control_points()[j * of.columns()..][..of.columns()].to_vec();
        curve(3, &of.knots()[0], points)
    };
    let edges = vec![
        column(left, left.columns() - 1),
        row(left, 0),
        row(left, 2),
        column(left, 0),
        row(right, 0),
        column(right, right.columns() - 1),
        row(right, 2),
    ];
    let face = |of: &NurbsSurface, edges: [usize; 4]| Face {
        name: String::new(),
        tolerance: 1e-7,
        color: None,
        reversed: false,
        bounds: of.domain(),
        surface: FaceSurface::Nurbs(of.clone()),
        loops: vec![
            std::iter::zip(edges, [true, true, false, false])
                .map(|(edge, forward)| coedge(edge, forward))
                .collect(),
        ],
    };
    Model {
        name: String::new(),
        unit: 1.0,
        edges,
        faces: vec![face(left, [1, 0, 2, 3]), face(right, [4, 5, 6, 0])],
        products: vec![Product { name: String::new(), color: None, faces: [0, 2], uses: vec![] }],
    }
}

/// The edge that faces 0 and 1 share.
fn common(model: &Model) -> EdgeContinuity {
    let edges = model.continuity().unwrap();
    let is_open = |edge: &EdgeContinuity| edge.class == Continuity::Open && edge.angle.is_none();
    assert_eq!(edges.iter().filter(|edge| is_open(edge)).count(), 6);
    edges.into_iter().next().unwrap()
}

/// z = 0.3 x² + 0.5 x y for x in a range, with x = u and y = v + skew (u − 1).
fn skewed([low, high]: [f64; 2], skew: f64) -> NurbsSurface {
    let mut points = Vec::new();
    for j in 0..3 {
        let v = 0.5 * f64::from(j);
        for i in 0..4 {
            let [a, b, c] = [2, 1, 0].map(|n| if i > n { high } else { low });
            let (mean, pairs) = ((a + b + c) / 3.0, (a * b + a * c + b * c) / 3.0);
            let z = (0.3 + 0.5 * skew) * pairs + 0.5 * mean * (v - skew);
            points.push(DVec4::new(mean, v + skew * (mean - 1.0), z, 1.0));
        }
    }
    let knots = [[[low; 4], [high; 4]].concat(), vec![0.0, 0.0, 0.0, 1.0, 1.0, 1.0]];
    NurbsSurface::new(Degree::new(3, 2).unwrap(), knots, points).unwrap()
}

#[test]
fn curvature_does_not_depend_on_the_parameters() {
    let edge = common(&pair(&[skewed([0.0, 1.0], -0.4), skewed([1.0, 2.0], 0.7)]));
    let (gap, angle, jump) = values(&edge);
    assert!(gap < 1e-12 && angle < 1e-6 && edge.class == Continuity::G2, "{edge:?}");
    assert!(jump.unwrap() < 1e-9, "{edge:?}");
}

/// The largest value for y from 0 to 1.
fn largest(of: impl Fn(f64) -> f64) -> f64 {
    (0..=100_000).map(|i| of(f64::from(i) * 1e-5)).fold(0.0, f64::max)
}

#[test]
fn a_smooth_surface_cut_in_two_stays_smooth() {
    // Within a span, at a knot where the third derivative jumps, and where the knot is no crease.
    for (k, c, t) in [(2, 0.4, 0.37), (2, 0.4, 1.6), (3, 0.4, 1.0), (1, 0.0, 1.0)] {
        let surface = creased(k, c);
        let edge = common(&pair(&cut(&surface, t)));
        let (gap, angle, jump) = values(&edge);
        assert!(gap < 1e-12 && angle < 1e-6, "{edge:?}");
        assert!(jump.unwrap() < 1e-6 && edge.class == Continuity::G2, "{edge:?}");
    }
}

#[test]
fn the_curvature_jumps_at_a_double_knot() {
    let c = 0.4;
    let surface = creased(2, c);
    // The second fundamental form across the edge changes by 2 c; x has the share √G / W of a unit step across it.
    let expected = largest(|y| {
        let [zx, zy] = [0.6 + 0.5 * (y - 0.4).powi(2), y - 0.4];
        2.0 * c * (1.0 + zy * zy) / (1.0 + zx * zx + zy * zy).powf(1.5)
    });
    let mut model = pair(&cut(&surface, 1.0));
    let one = common(&model);
    // The same with both faces on the whole surface.
    for face in &mut model.faces {
        face.surface = FaceSurface::Nurbs(surface.clone());
    }
    let other = common(&model);
    for edge in [one, other] {
        let (gap, angle, jump) = values(&edge);
        assert!(gap < 1e-12 && angle < 1e-6 && edge.class == Continuity::G1, "{edge:?}");
        assert_near(jump.unwrap(), expected, 1e-7 * expected, "jump");
    }
}

#[test]
fn normals_turn_at_a_triple_knot() {
    let c = 0.4;
    let surface = creased(1, c);
    let expected = largest(|y| {
        let [zx, zy] = [0.6 + 0.5 * (y - 0.4).powi(2), y - 0.4];
        dvec3(-zx, -zy, 1.0).angle_between(dvec3(-zx - c, -zy, 1.0)).to_degrees()
    });
    let mut model = pair(&cut(&surface, 1.0));
    let one = common(&model);
    // A face that is oriented against the other one is turned.
    model.faces[1].reversed = true;
    let turned = common(&model);
    for face in &mut model.faces {
        face.surface = FaceSurface::Nurbs(surface.clone());
    }
    let other = common(&model);
    for edge in [one, turned, other] {
        let (gap, angle, jump) = values(&edge);
        assert!(gap < 1e-12 && jump.is_none() && edge.class == Continuity::G0, "{edge:?}");
        assert_near(angle, expected, 1e-7, "angle");
    }
}

#[test]
fn gaps_are_distances_between_borders() {
    let size = 1e-3;
    let [left, right] = cut(&creased(3, 0.0), 1.0);
    // Flat, and the second surface is moved: up in the middle of its border, or away.
    let moved = |of: &NurbsSurface, by: &dyn Fn(usize) -> DVec3| {
        let points =
            of.control_points().iter().enumerate().map(|(i, point)| {
                (dvec3(point.x, point.y, 0.0) + by(i / of.columns())).extend(1.0)
            });
        NurbsSurface::new(of.degree(), of.knots().clone(), points.collect()).unwrap()
    };
    let left = moved(&left, &|_| DVec3::ZERO);
    let up = moved(&right, &|row| if row == 1 { 2.0 * size * DVec3::Z } else { DVec3::ZERO });
    let away = moved(&right, &|_| size * DVec3::X);
    let edge = common(&pair(&[left.clone(), up]));
    let gap = edge.gap.unwrap();
    assert_eq!((edge.class, edge.curvature), (Continuity::Gap, None));
    assert_near(gap.value, size, 1e-9 * size, "gap");
    assert!(gap.point.distance(dvec3(1.0, 0.5, 0.0)) < 1e-3, "{gap:?}");
    let mut model = pair(&[left, away]);
    let edge = common(&model);
    assert_near(edge.gap.unwrap().value, size, 1e-12, "gap");
    assert_near(edge.off_edge.value, size, 1e-12, "distance of the edge");
    assert_near(edge.angle.unwrap().value, 0.0, 1e-6, "angle");

    // With a third face at the edge.
    model.faces[1].surface = FaceSurface::Nurbs(right.clone());
    let third = model.faces[0].clone();
    model.faces = vec![third.clone(), third.clone(), third];
    model.products[0].faces = [0, 3];
    let edges = model.continuity().unwrap();
    assert_eq!((edges[0].class, edges[0].angle), (Continuity::NonManifold, None));
    assert_eq!(edges[0].faces, [0, 1, 2]);
    // Edges that no face uses are left out.
    assert_eq!(edges.iter().map(|edge| edge.edge).collect::<Vec<_>>(), [0, 1, 2, 3]);
    model.faces[0].loops[0][0].edge = 7;
    assert!(model.continuity().unwrap_err().to_string().contains("edge"));
}

/// Whether a plane touches a cylinder along a line, and the radius.
fn touch(model: &Model, faces: &[usize]) -> Option<f64> {
    let [a, b] = faces else { return None };
    let (plane, axis, radius) = match (&model.faces[*a].surface, &model.faces[*b].surface) {
        (FaceSurface::Plane(plane), FaceSurface::Cylinder { frame, radius })
        | (FaceSurface::Cylinder { frame, radius }, FaceSurface::Plane(plane)) => {
            (plane, frame, *radius)
        }
        _ => return None,
    };
    let distance = (axis.origin - plane.origin).dot(plane.z).abs();
    let is_parallel = axis.z.dot(plane.z).abs() < 1e-9;
    (is_parallel && (distance - radius).abs() < 1e-9 * radius).then_some(radius)
}

/// How a colour looks in CIE L*a*b*, after a matrix over linear red, green and blue.
fn lab(rgb: [f64; 3], seen: DMat3) -> DVec3 {
    let linear = |channel: f64| {
        if channel <= 0.04045 { channel / 12.92 } else { ((channel + 0.055) / 1.055).powf(2.4) }
    };
    let linear = (seen * DVec3::from(rgb.map(linear))).clamp(DVec3::ZERO, DVec3::ONE);
    let to_xyz = [0.4125, 0.3576, 0.1804, 0.2127, 0.7152, 0.0722, 0.0193, 0.1192, 0.9503];
    let xyz = DMat3::from_cols_array(&to_xyz).transpose() * linear / dvec3(0.9505, 1.0, 1.0888);
    let f = xyz.to_array().map(|t| if t > 0.008856 { t.cbrt() } else { 7.787 * t + 16.0 / 116.0 });
    dvec3(116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2]))
}

/// The matrices are those of Machado, Oliveira and Fernandes (2009) for people without one kind of cones.
#[test]
fn everybody_can_tell_the_colours_of_classes_apart() {
    let matrices = [
        [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        [0.1523, 1.0526, -0.2049, 0.1145, 0.7863, 0.0992, -0.0039, -0.0481, 1.0520],
        [0.3673, 0.8606, -0.2280, 0.2801, 0.6725, 0.0474, -0.0118, 0.0429, 0.9689],
        [1.2555, -0.0767, -0.1788, -0.0784, 0.9308, 0.1476, 0.0047, 0.6914, 0.3039],
    ];
    let classes = Continuity::ALL.map(|class| class.color().map(f64::from));
    let grey = [0.7, 0.72, 0.75];
    let all: Vec<_> = classes.into_iter().chain([grey]).collect();
    for matrix in matrices {
        let seen = DMat3::from_cols_array(&matrix).transpose();
        for (i, one) in all.iter().enumerate() {
            for other in &all[..i] {
                // 2 is just noticeable side by side.
                let apart = lab(*one, seen).distance(lab(*other, seen));
                assert!(apart > 25.0, "{one:?} and {other:?} are {apart:.1} apart");
            }
        }
    }
}

#[test]
fn cad_files() {
    let Some((_, files)) = super::cad_models::files() else { return };
    let mut fillets = 0;
    for file in files {
        let model = Model::load(&file, &LoadOptions::default()).unwrap();
        let edges = model.continuity().unwrap();
        let used = model.edge_uses();
        let used = (0..model.edges.len())
            .filter(|edge| model.edges[*edge].curve.is_some() && !used[*edge].is_empty());
        assert!(used.eq(edges.iter().map(|edge| edge.edge)), "{}", file.display());
        for edge in &edges {
            check_edge(&model, edge, &file);
            let Some(radius) = touch(&model, &edge.faces) else { continue };
            fillets += 1;
            let (_, angle, jump) = values(edge);
            assert!(angle < 1e-4 && edge.class == Continuity::G1, "{edge:?}");
            assert_near(jump.unwrap(), 1.0 / radius, 1e-6 / radius, "jump");
        }
    }
    assert!(fillets > 20, "{fillets} fillets");
}

fn check_edge(model: &Model, edge: &EdgeContinuity, file: &Path) {
    let place = format!("{}: {edge:?}", file.display());
    let diagonal = model.diagonal();
    let all = [edge.gap, Some(edge.off_edge), edge.angle, edge.curvature, edge.relative_jump];
    for worst in all.into_iter().flatten() {
        assert!(worst.value.is_finite() && worst.value >= 0.0, "{place}");
        assert!(worst.point.is_finite(), "{place}");
    }
    assert!(edge.off_edge.value <= 1e-3 * diagonal, "{place}");
    // Two borders are no further apart than both are from the edge.
    if let Some(gap) = edge.gap {
        assert!(gap.value <= 2.0 * edge.off_edge.value + 1e-12 * diagonal, "{place}");
    }
    assert_eq!(edge.curvature.is_some(), edge.class >= Continuity::G1, "{place}");
    assert!(edge.angle.is_none_or(|angle| angle.value <= 180.0), "{place}");
}
