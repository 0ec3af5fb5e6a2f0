//! Tests of the instances of faces.

use glam::{DAffine3, DVec3, dvec3};

use super::*;
use crate::model::{FaceSurface, Frame, ProductUse};

fn model(colors: &[Option<[f32; 3]>], products: Vec<Product>) -> Model {
    let face = |color: &Option<[f32; 3]>| Face {
        name: String::new(),
        tolerance: 0.0,
        color: *color,
        reversed: false,
        surface: FaceSurface::Plane(Frame::WORLD),
        bounds: [glam::DVec2::ZERO, glam::DVec2::ONE],
        loops: Vec::new(),
    };
    let faces = colors.iter().map(face).collect();
    Model { name: String::new(), unit: 0.001, edges: Vec::new(), faces, products }
}

fn product(color: Option<[f32; 3]>, faces: [usize; 2], uses: Vec<ProductUse>) -> Product {
    Product { name: String::new(), color, faces, uses }
}

fn used(product: usize, placement: DAffine3, color: Option<[f32; 3]>) -> ProductUse {
    ProductUse { product, placement, color }
}

const RED: Option<[f32; 3]> = Some([1.0, 0.0, 0.0]);
const GREEN: Option<[f32; 3]> = Some([0.0, 1.0, 0.0]);
const BLUE: Option<[f32; 3]> = Some([0.0, 0.0, 1.0]);

#[test]
fn faces_are_listed_depth_first_with_their_places_and_colours() {
    let moved = DAffine3::from_translation(DVec3::X);
    let scaled = DAffine3::from_scale(DVec3::splat(2.0));
    let products = vec![
        product(RED, [0, 2], vec![]),
        product(None, [2, 1], vec![used(0, moved, None), used(0, moved, GREEN)]),
        // Not in the tree.
        product(None, [0, 3], vec![]),
        product(GREEN, [2, 0], vec![used(1, scaled, BLUE), used(0, DAffine3::IDENTITY, None)]),
    ];
    let model = model(&[None, GREEN, None], products);
    let found: Vec<_> = model
        .instances()
        .unwrap()
        .iter()
        .map(|i| (i.face, i.placement.transform_point3(dvec3(1.0, 0.0, 0.0)).x, i.color))
        .collect();
    assert_eq!(
        found,
        [
            (2, 2.0, BLUE),
            (0, 4.0, RED),
            (1, 4.0, GREEN),
            (0, 4.0, GREEN),
            (1, 4.0, GREEN),
            (0, 1.0, RED),
            (1, 1.0, GREEN),
        ]
    );
}

#[test]
fn products_that_double_forty_times_are_refused_at_once() {
    let doubling = |levels: usize, faces: usize| {
        let mut products = vec![product(None, [0, faces], vec![])];
        for level in 0..levels {
            products.push(product(None, [0, 0], vec![used(level, DAffine3::IDENTITY, None); 2]));
        }
        model(&[None], products).instances()
    };
    assert_eq!(doubling(10, 1).unwrap().len(), 1024);
    for (levels, count) in [(40, "1099511627776"), (80, "at least 18446744073709551615")] {
        let message = format!("number of faces in all places is {count}; expected at most 1000000");
        assert_eq!(doubling(levels, 1).unwrap_err().to_string(), message);
    }
    // Products without faces are not visited.
    assert!(doubling(80, 0).unwrap().is_empty());
}

#[test]
fn chains_are_limited_too() {
    let chain = |length: usize, width: usize| {
        let mut products = vec![product(None, [0, 1], vec![])];
        for level in 0..length {
            products.push(product(None, [0, 0], vec![used(level, DAffine3::IDENTITY, None)]));
        }
        let uses = vec![used(length, DAffine3::IDENTITY, None); width];
        products.push(product(None, [0, 0], uses));
        model(&[None], products).instances()
    };
    assert_eq!(chain(100_000, 1).unwrap().len(), 1);
    let message = chain(1_000, 1_000).unwrap_err().to_string();
    assert_eq!(message, "number of uses of products is 1001000; expected at most 1000000");
}

#[test]
fn a_placement_that_grows_beyond_all_numbers_is_refused() {
    let large = DAffine3::from_scale(DVec3::splat(1e15));
    let mut products = vec![product(None, [0, 1], vec![])];
    products.extend((0..40).map(|level| product(None, [0, 0], vec![used(level, large, None)])));
    let message = model(&[None], products).instances().unwrap_err().to_string();
    assert!(
        message.ends_with("is too large; expected finite numbers in the whole model"),
        "{message}"
    );
}

#[test]
fn a_model_without_products_has_no_instances() {
    assert!(model(&[None], vec![]).instances().unwrap().is_empty());
}
