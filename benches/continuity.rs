//! How long it takes to measure how faces meet: 1,012 edges of 484 bicubic patches without p-curves.
//!
//! `cargo bench --bench continuity` prints the median. It should stay below 0.5 s on two cores.

use std::time::Instant;

use freeform_surface::model::{
    BoundedCurve, Coedge, Continuity, Curve, Edge, Face, FaceSurface, Model, NurbsCurve, Product,
};
use freeform_surface::{Degree, NurbsSurface};
use glam::DVec4;

/// Patches along a side.
const SIDE: usize = 22;

fn main() {
    let model = quilt();
    let mut times: Vec<f64> = (0..9)
        .map(|_| {
            let start = Instant::now();
            let edges = model.continuity().expect("the model is valid");
            assert_eq!(edges.len(), 2 * SIDE * (SIDE + 1));
            assert!(edges.iter().all(|edge| edge.class != Continuity::Gap));
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("continuity of {} edges: {:.0} ms", model.edges.len(), 1e3 * times[times.len() / 2]);
}

/// A wavy square of patches with creases between them.
fn quilt() -> Model {
    let point = |column: usize, row: usize| {
        let (x, y) = (column as f64, row as f64);
        DVec4::new(x, y, (0.7 * x).sin() + (0.4 * x * y).cos(), 1.0)
    };
    let knots = || vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    let edge = |points: [DVec4; 4]| {
        let curve = NurbsCurve::new(3, knots(), points.to_vec()).expect("a cubic");
        let curve = BoundedCurve { curve: Curve::Nurbs(curve), range: [0.0, 1.0] };
        Edge { tolerance: 1e-7, curve: Some(curve) }
    };
    let mut edges = Vec::new();
    for row in 0..=SIDE {
        let along = |i: usize| edge([0, 1, 2, 3].map(|k| point(3 * i + k, 3 * row)));
        edges.extend((0..SIDE).map(along));
    }
    for row in 0..SIDE {
        let along = |i: usize| edge([0, 1, 2, 3].map(|k| point(3 * i, 3 * row + k)));
        edges.extend((0..=SIDE).map(along));
    }
    let faces = (0..SIDE * SIDE).map(|number| {
        let (column, row) = (number % SIDE, number / SIDE);
        let points = (0..16).map(|i| point(3 * column + i % 4, 3 * row + i / 4)).collect();
        let surface = NurbsSurface::new(Degree::CUBIC, [knots(), knots()], points);
        let surface = surface.expect("a bicubic patch");
        let (below, left) = (row * SIDE + column, SIDE * (SIDE + 1) + row * (SIDE + 1) + column);
        let uses = [(below, true), (left + 1, true), (below + SIDE, false), (left, false)];
        let coedge = |(edge, forward)| Coedge { edge, forward, pcurve: None };
        Face {
            name: String::new(),
            tolerance: 1e-7,
            color: None,
            reversed: false,
            bounds: surface.domain(),
            surface: FaceSurface::Nurbs(surface),
            loops: vec![uses.map(coedge).to_vec()],
        }
    });
    let faces: Vec<Face> = faces.collect();
    let product =
        Product { name: String::new(), color: None, faces: [0, faces.len()], uses: Vec::new() };
    Model { name: "quilt".into(), unit: 1.0, edges, faces, products: vec![product] }
}
