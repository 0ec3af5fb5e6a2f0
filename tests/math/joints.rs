//! Joints of models: what meets along each edge, against the classes of [`Model::continuity`].

use std::collections::BTreeMap;

use freeform_surface::LoadOptions;
use freeform_surface::model::{Continuity, Joint, JointKind, Model};

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
