//! Joints of models: what meets along each edge, against the classes of [`Model::continuity`].

use std::collections::{BTreeMap, BTreeSet};

use freeform_surface::LoadOptions;
use freeform_surface::model::{Continuity, Joint, JointKind, Model};

use crate::cad_models::files;

fn load(name: &str) -> Model {
    let path = format!("{}/resources/models/{name}.ffm", env!("CARGO_MANIFEST_DIR"));
    Model::load(path.as_ref(), &LoadOptions::default()).unwrap()
}

fn joints(model: &Model) -> Vec<Joint> {
    model.joints(&model.drawn_faces(), model.diagonal())
}

fn check(model: &Model, counts: &mut BTreeMap<&'static str, usize>) {
    let edges = model.continuity().unwrap();
    let joints = joints(model);
    assert_eq!(joints.len(), edges.len());
    for (joint, edge) in joints.iter().zip(&edges) {
        assert_eq!(joint.edge, edge.edge);
        let is_seam = edge.faces.len() == 2 && edge.faces[0] == edge.faces[1];
        let (kind, name) = match edge.class {
            Continuity::Open => (JointKind::Open, "open"),
            _ if is_seam => (JointKind::Seam, "seam"),
            Continuity::G0 => (JointKind::Sharp, "sharp"),
            Continuity::G1 | Continuity::G2 => (JointKind::Smooth, "smooth"),
            class => panic!("{class:?}"),
        };
        assert_eq!(joint.kind, kind, "{edge:?}");
        *counts.entry(name).or_default() += 1;
        if kind == JointKind::Open {
            assert_eq!(joint.faces, [edge.faces[0]; 2]);
        }
    }
}

#[test]
fn kinds_of_joints_are_the_classes_of_their_edges() {
    let mut counts = BTreeMap::new();
    for name in ["assembly", "blade", "bracket", "flange"] {
        let mut model = load(name);
        check(&model, &mut counts);
        // Without a face of a single product, its neighbours end at open edges.
        if model.products.len() == 1 {
            model.faces.remove(0);
            model.products[0].faces[1] -= 1;
            check(&model, &mut counts);
        }
    }
    let names: Vec<_> = counts.keys().copied().collect();
    assert_eq!(names, ["open", "seam", "sharp", "smooth"], "{counts:?}");
    assert!(counts.values().all(|count| *count > 2), "{counts:?}");
}

#[test]
fn the_outside_of_closed_solids_is_known_whatever_their_faces_say() {
    // In the other order, the first faces of two models point inwards.
    let names =
        ["assembly", "blade", "bracket", "flange"].map(|name| [(name, false), (name, true)]);
    for (name, turned) in names.into_iter().flatten() {
        let mut model = load(name);
        if turned && model.products.len() == 1 {
            model.faces.reverse();
        }
        // In the stored models `reversed` tells the outside (`model_solids.rs` computes the volumes with it).
        let told: Vec<f64> =
            model.faces.iter().map(|face| if face.reversed { -1.0 } else { 1.0 }).collect();
        model.faces.iter_mut().for_each(|face| face.reversed = false);
        let faces = model.drawn_faces();
        let joints = model.joints(&faces, model.diagonal());
        let found = model.outsides(&faces, &joints);
        let signs: Vec<f64> = found.iter().map(|outside| outside.unwrap().sign).collect();
        assert_eq!(signs, told, "{name}");
        // The faces of a product are one solid.
        for product in &model.products {
            let [first, count] = product.faces;
            let solids = found[first..first + count].iter().map(|outside| outside.unwrap().solid);
            let solids: BTreeSet<usize> = solids.collect();
            assert_eq!(solids.len(), count.min(1), "{name}");
        }
        // A face that is not drawn leaves its solid open, and no other.
        let mut without = model.drawn_faces();
        without[0] = Err(freeform_surface::Error::invalid("face", "left out", "drawn"));
        let joints = model.joints(&without, model.diagonal());
        let opened = model.outsides(&without, &joints);
        let of_first = found[0].unwrap().solid;
        for (before, after) in found.iter().zip(opened) {
            let is_open = before.unwrap().solid == of_first;
            assert_eq!(after.is_none(), is_open, "{name}");
        }
    }
}

#[test]
fn the_outside_of_solids_in_cad_files_is_that_of_the_kernel() {
    let Some((_, files)) = files() else { return };
    // Whether the file has solids only. The NIST part and the boxed sphere have poles.
    let expected = [
        ("as1-oc-214.stp", true),
        ("axom_boxed_sphere.step", true),
        ("gpucast_teapot.igs", false),
        ("io1-cm-214.stp", true),
        ("m6_screw_thread.step", true),
        ("nist_mbe_pmi_6.stp", true),
    ];
    for (name, is_solid) in expected {
        let file = files.iter().find(|file| file.ends_with(name)).unwrap();
        let model = Model::load(file, &LoadOptions::default()).unwrap();
        let faces = model.drawn_faces();
        let joints = model.joints(&faces, model.diagonal());
        for (number, (face, outside)) in
            std::iter::zip(&model.faces, model.outsides(&faces, &joints)).enumerate()
        {
            let sign = if face.reversed { -1.0 } else { 1.0 };
            let found = outside.map(|outside| outside.sign);
            assert_eq!(found, is_solid.then_some(sign), "{name}: face {number}");
        }
    }
}
