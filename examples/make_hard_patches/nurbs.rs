//! The hard NURBS surfaces.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use glam::{DVec4, dvec3};

use super::{BLUE, ORANGE, Patch, Scene};

/// A camera that sees a surface over x and −z from 0 to 1, one to one in a square picture.
const ONE_TO_ONE: &str = "eye = [0.5, 1.0, -0.5]\ntarget = [0.5, 0.0, -0.5]\nup = [0.0, 0.0, -1.0]\n\
                          orthographic_height = 1.0\n\n[render]\nlevel = 1\n\
                          background = [0.0, 0.0, 0.0, 0.0]";

pub(super) fn scenes() -> [Scene; 8] {
    [
        crease(),
        torn(),
        periodic_torus(),
        sphere_and_torus(),
        knot_lines(),
        flat_trims(),
        long_thin_domain(),
        curved_trims(),
    ]
}

/// A knot vector: each knot as often as its number says.
fn repeated(knots: &[(f64, usize)]) -> Vec<f64> {
    knots.iter().flat_map(|(knot, count)| std::iter::repeat_n(*knot, *count)).collect()
}

fn nurbs(degree: [usize; 2], knots: [Vec<f64>; 2], points: Vec<DVec4>, color: [f64; 3]) -> Patch {
    Patch { knots: Some(knots), ..Patch::of_degree(degree, points, color) }
}

/// The averages of `degree` successive knots: with these places as control points, a curve is its own parameter.
fn greville(degree: usize, knots: &[f64]) -> Vec<f64> {
    let count = knots.len() - degree - 1;
    (1..=count).map(|i| knots[i..i + degree].iter().sum::<f64>() / degree as f64).collect()
}

/// A surface over x and −z from 0 to 1, which grow evenly with u and v, with a height for each x and z.
fn sheet(
    degree: [usize; 2],
    knots: [Vec<f64>; 2],
    color: [f64; 3],
    height: impl Fn(f64, f64) -> f64,
) -> Patch {
    let [xs, zs] = [0, 1].map(|axis| {
        let (knots, degree) = (&knots[axis], degree[axis]);
        let (first, last) = (knots[degree], knots[knots.len() - degree - 1]);
        let places = greville(degree, knots).into_iter();
        places.map(|place| (place - first) / (last - first)).collect::<Vec<f64>>()
    });
    let points =
        zs.iter().flat_map(|z| xs.iter().map(|x| dvec3(*x, height(*x, *z), -*z).extend(1.0)));
    let points = points.collect();
    nurbs(degree, knots, points, color)
}

fn crease() -> Scene {
    let height = |x: f64, z: f64| 0.25 * (9.0 * x).sin() * (4.0 * z).cos();
    let cubic = [
        repeated(&[(0.0, 4), (0.25, 1), (0.5, 3), (0.8, 1), (1.0, 4)]),
        repeated(&[(0.0, 4), (0.3, 1), (0.7, 2), (1.0, 4)]),
    ];
    let quintic = [
        repeated(&[(0.0, 6), (1.0, 5), (3.0, 2), (4.0, 6)]),
        repeated(&[(0.0, 3), (1.0, 1), (2.0, 3)]),
    ];
    let mut second = sheet([5, 2], quintic, BLUE, height);
    second.translate = Some(dvec3(1.1, 0.0, 0.0));
    Scene {
        name: "crease",
        about: "A knot of multiplicity 3 in a cubic surface and one of multiplicity 5 in a surface of degree 5: creases.",
        camera: "eye = [1.2, 1.3, 1.2]\ntarget = [1.0, 0.0, -0.5]",
        patches: vec![sheet([3, 3], cubic, ORANGE, height), second],
    }
}

fn torn() -> Scene {
    let knots = [
        vec![-2.0, -1.0, -0.5, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 3.5, 4.5],
        repeated(&[(0.0, 3), (0.5, 1), (1.0, 3)]),
    ];
    let points = (0..32).map(|i| {
        let (x, z) = ((i % 8) as f64, (i / 8) as f64);
        let apart = if i % 8 < 4 { 0.0 } else { 0.5 };
        (dvec3(x + apart, 2.0 * (1.3 * x).sin() + (1.7 * z).cos(), -2.0 * z) / 8.0).extend(1.0)
    });
    Scene {
        name: "torn",
        about: "A cubic surface without clamped ends and with a knot of multiplicity 4: it falls into two pieces.",
        camera: "eye = [0.6, 1.1, 1.1]\ntarget = [0.5, 0.0, -0.4]",
        patches: vec![nurbs([3, 2], knots, points.collect(), ORANGE)],
    }
}

fn periodic_torus() -> Scene {
    // Steps of 0.1 round differently everywhere.
    let knots = |count: usize| (0..count + 7).map(|i| i as f64 * 0.1).collect::<Vec<f64>>();
    let (around, along) = (8, 6);
    let points = (0..along + 3).flat_map(|row| {
        (0..around + 3).map(move |column| {
            let turn = |i: usize, of: usize| TAU * (i % of) as f64 / of as f64;
            let (a, b) = (turn(column, around), turn(row, along));
            let radius = 1.0 + 0.5 * b.cos();
            dvec3(radius * a.cos(), 0.5 * b.sin(), -radius * a.sin()).map(rounded).extend(1.0)
        })
    });
    Scene {
        name: "periodic-torus",
        about: "A torus of periodic cubic B-splines: it closes in both directions, up to the rounding of its knots.",
        camera: "eye = [1.2, 1.7, 1.9]\ntarget = [0.0, 0.0, 0.0]",
        patches: vec![nurbs([3, 3], [knots(around), knots(along)], points.collect(), ORANGE)],
    }
}

fn rounded(x: f64) -> f64 {
    (x * 1e6).round() / 1e6
}

/// The corners of a circle's square, with the weights of four rational quarters.
const CIRCLE: [(f64, f64, f64); 9] = [
    (1.0, 0.0, 1.0),
    (1.0, 1.0, FRAC_1_SQRT_2),
    (0.0, 1.0, 1.0),
    (-1.0, 1.0, FRAC_1_SQRT_2),
    (-1.0, 0.0, 1.0),
    (-1.0, -1.0, FRAC_1_SQRT_2),
    (0.0, -1.0, 1.0),
    (1.0, -1.0, FRAC_1_SQRT_2),
    (1.0, 0.0, 1.0),
];

fn sphere_and_torus() -> Scene {
    let quarters = |count: usize| {
        let inner = (1..count).map(|i| (i as f64, 2));
        let all: Vec<(f64, usize)> =
            [(0.0, 3)].into_iter().chain(inner).chain([(count as f64, 3)]).collect();
        repeated(&all)
    };
    let revolved = |profile: &[(f64, f64, f64)], x: f64| -> Vec<DVec4> {
        let rows = profile.iter().flat_map(|(radius, height, weight)| {
            CIRCLE.map(|(a, b, other)| {
                dvec3(x + radius * a, *height, -radius * b).extend(weight * other)
            })
        });
        rows.collect()
    };
    // From the south pole to the north pole.
    let meridian = [(0.0, -1.0), (1.0, -1.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let weights = [1.0, FRAC_1_SQRT_2, 1.0, FRAC_1_SQRT_2, 1.0];
    let meridian: Vec<_> =
        meridian.into_iter().zip(weights).map(|((r, h), w)| (0.8 * r, 0.8 * h, w)).collect();
    let tube: Vec<_> = CIRCLE.iter().map(|(a, b, w)| (0.7 + 0.3 * a, 0.3 * b, *w)).collect();
    Scene {
        name: "sphere-and-torus",
        about: "A sphere with its two poles and a torus, each as one rational surface of degree 2.",
        camera: "eye = [1.2, 1.9, 3.2]\ntarget = [1.0, 0.0, 0.0]",
        patches: vec![
            nurbs([2, 2], [quarters(4), quarters(2)], revolved(&meridian, 0.0), ORANGE),
            nurbs([2, 2], [quarters(4), quarters(4)], revolved(&tube, 2.0), BLUE),
        ],
    }
}

/// Knots along u and v of the surfaces with trims: uneven, some of them double.
fn uneven() -> [Vec<f64>; 2] {
    [
        repeated(&[(2.0, 4), (2.5, 1), (3.0, 2), (4.25, 1), (5.0, 4)]),
        repeated(&[(10.0, 3), (15.0, 1), (20.0, 1), (31.0, 2), (40.0, 3)]),
    ]
}

fn knot_lines() -> Scene {
    let height = |x: f64, z: f64| 0.2 * (5.0 * x).sin() * (4.0 * z).cos();
    let mut surface = sheet([3, 2], uneven(), ORANGE, height);
    surface.more = "keep = \"inside\"
[[surface.trim]]              # the border of the domain
loop = [[[2, 10], [5, 10]], [[5, 10], [5, 40]], [[5, 40], [2, 40]], [[2, 40], [2, 10]]]
[[surface.trim]]              # along knot lines, from knot to knot
loop = [[[2.5, 15], [3, 15]], [[3, 15], [3, 31]], [[3, 31], [2.5, 31]], [[2.5, 31], [2.5, 15]]]
[[surface.trim]]              # through a crossing of knot lines in a straight line, and back through another in a curve
loop = [[[3.625, 15], [4.25, 20]], [[4.25, 20], [4.875, 25]], [[4.875, 25], [4.9, 31], [4.25, 31]], [[4.25, 31], [3.4, 31], [3.625, 15]]]
";
    Scene {
        name: "knot-lines",
        about: "Trims that run along the border, along knot lines and through crossings of knot lines.",
        camera: "eye = [0.6, 1.0, 0.7]\ntarget = [0.5, 0.0, -0.5]",
        patches: vec![surface],
    }
}

/// Every kind of trim over several patches.
const TRIMS: &str = "[[surface.trim]]
nurbs = [{ degree = 2, knots = [0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4], points = [[3.5, 20], [3.5, 30, 0.7071067811865476], [3, 30], [2.5, 30, 0.7071067811865476], [2.5, 20], [2.5, 10, 0.7071067811865476], [3, 10], [3.5, 10, 0.7071067811865476], [3.5, 20]] }]
[[surface.trim]]
loop = [[[3, 12], [3.4, 14, 2.0], [2.7, 29, 0.5], [3.5, 25], [3.3, 16], [2.9, 24], [2.8, 15, 3.0], [3.2, 13], [3, 20], [2.6, 22], [2.8, 16], [3, 12]]]
[[surface.trim]]
loop = [[[4.25, 31], [4.9, 33]], [[4.9, 33], [4.6, 39], [4, 39], [4.25, 31]]]
[[surface.trim]]
path = \"M3.2 35 a.3 3 0 1 1 .6 0 a.3 3 0 1 1 -.6 0 z\"
[[surface.trim]]
circle = { center = [4.5, 12], radius = 0.4 }
[[surface.trim]]
ellipse = { center = [4.3, 22], radii = [0.4, 7] }
[[surface.trim]]
interval = { u = [2.25, 2.75], v = [32, 37] }
";

fn flat_trims() -> Scene {
    let mut surface = sheet([3, 2], uneven(), ORANGE, |_, _| 0.0);
    surface.more = TRIMS;
    Scene {
        name: "flat-trims",
        about: "Every kind of trim over the patches of a surface whose (u, v) are the pixels of a square picture.",
        camera: ONE_TO_ONE,
        patches: vec![surface],
    }
}

fn curved_trims() -> Scene {
    let mut surface =
        sheet([3, 2], uneven(), ORANGE, |x, z| 0.2 * (7.0 * x).sin() * (5.0 * z).cos());
    for (i, point) in surface.points.iter_mut().enumerate() {
        point.w = [1.0, 2.0, 0.5][i % 3];
    }
    surface.more = TRIMS;
    Scene {
        name: "curved-trims",
        about: "Every kind of trim over the patches of a curved surface with weights.",
        camera: "eye = [0.6, 1.3, 0.5]\ntarget = [0.5, 0.0, -0.5]",
        patches: vec![surface],
    }
}

fn long_thin_domain() -> Scene {
    let knots = [
        repeated(&[(1e5, 3), (101940.0, 1), (103880.0, 1), (107760.0, 3)]),
        repeated(&[(1e5, 3), (100000.00025, 1), (100000.001, 3)]),
    ];
    let mut surface = sheet([2, 2], knots, ORANGE, |_, _| 0.0);
    surface.more = "[[surface.trim]]
loop = [[[100500, 100000.0001], [107000, 100000.0002]], [[107000, 100000.0002], [107500, 100000.0006], [106000, 100000.0009]], [[106000, 100000.0009], [104000, 100000.0003], [102000, 100000.0012], [100500, 100000.0001]]]
[[surface.trim]]
ellipse = { center = [102000, 100000.0008], radii = [1000, 0.0001] }
[[surface.trim]]
loop = [[[106500, 100000.00005], [107500, 100000.00005, 0.5], [107500, 100000.00015]], [[107500, 100000.00015], [106500, 100000.00015, 3.0], [106500, 100000.00005]]]
";
    Scene {
        name: "long-thin-domain",
        about: "A domain of 7,760 by 0.001 at 100,000: parameters have few digits left there, and f32 has none.",
        camera: ONE_TO_ONE,
        patches: vec![surface],
    }
}
