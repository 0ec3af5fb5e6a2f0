//! How close smoothed meshes come to the sphere and the torus on which their points lie.

use crate::convergence::{
    HALVINGS, LEVELS, Shape, after_steps, at_level, of_surface, shapes as surfaces,
};
use freeform_surface::{Alpha, Smoothing};

const PHONG: Smoothing = Smoothing::Phong(Alpha::NONE);

#[test]
fn flat_triangles_gain_a_factor_of_4_and_pn_of_11_to_17_when_edges_are_halved() {
    for Shape { name, meshes, distance } in &surfaces() {
        let orders = |smoothing| {
            let errors: Vec<f64> =
                meshes.iter().map(|mesh| of_surface(mesh, smoothing, *distance)).collect();
            errors.windows(2).map(|pair| pair[0] / pair[1]).collect::<Vec<_>>()
        };
        let last = HALVINGS - 2;
        let flat = orders(Smoothing::None);
        assert!((3.5..4.1).contains(&flat[last]), "{name}: {flat:?}");
        let pn = orders(Smoothing::Pn);
        assert!(pn.iter().all(|gain| *gain > 8.0), "{name}: {pn:?}");
        assert!((11.0..17.0).contains(&pn[last]), "{name}: {pn:?}");
        assert_eq!(orders(PHONG), flat, "{name}");
    }
}

#[test]
fn phong_is_nearer_by_1_over_1_minus_2_alpha() {
    for Shape { name, meshes, distance } in &surfaces() {
        let mesh = &meshes[HALVINGS - 1];
        let flat = of_surface(mesh, Smoothing::None, *distance);
        for (alpha, expected) in [(0.25, 2.0), (0.75, 2.0), (0.9, 1.25), (1.0, 1.0)] {
            let alpha = Alpha::new(alpha).unwrap();
            let factor = flat / of_surface(mesh, Smoothing::Phong(alpha), *distance);
            assert!((factor / expected - 1.0).abs() < 0.05, "{name}, {alpha:?}: {factor}");
        }
    }
}

#[test]
fn levels_add_no_more_than_their_facets() {
    for Shape { name, meshes, distance } in &surfaces() {
        let mesh = &meshes[1];
        let flat = of_surface(mesh, Smoothing::None, *distance);
        for smoothing in [Smoothing::Pn, Smoothing::Phong(Alpha::default())] {
            let smooth = of_surface(mesh, smoothing, *distance);
            for level in LEVELS {
                let drawn = at_level(mesh, smoothing, level, *distance);
                let facets = 1.5 * flat / f64::from(level * level);
                assert!(drawn <= smooth + facets, "{name}, {smoothing:?}, {level}: {drawn}");
                if level > 1 {
                    assert!(drawn < flat / 1.5, "{name}, {smoothing:?}, {level}: {drawn}");
                }
            }
        }
    }
}

#[test]
fn steps_are_nearer_than_the_flat_triangles() {
    for Shape { name, meshes, distance } in &surfaces() {
        for (smoothing, factor) in [(Smoothing::Pn, 3.0), (Smoothing::Phong(Alpha::default()), 3.0)]
        {
            for steps in crate::convergence::STEPS {
                let [flat, smooth] = [Smoothing::None, smoothing]
                    .map(|smoothing| after_steps(&meshes[0], smoothing, steps, *distance));
                assert!(flat > factor * smooth, "{name}, {smoothing:?}, {steps}: {flat} {smooth}");
            }
        }
    }
}

#[test]
fn the_page_of_tables_is_what_is_measured() {
    let page = include_str!("../../docs/mesh-convergence.md");
    assert!(
        page == crate::convergence::document(),
        "cargo run --release --example mesh_convergence > docs/mesh-convergence.md"
    );
}
