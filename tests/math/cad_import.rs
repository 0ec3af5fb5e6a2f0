//! Real STEP, IGES and BREP files, read by the helper program. Left out where the helper (`sh setup.sh cad`) or the
//! files are absent.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use freeform_surface::model::{ImportOptions, import};

/// The files and their numbers of faces, in products and in all places of them. The numbers of the products are those
/// of ADVANCED_FACE entities in STEP files, of entities 144 (or of 128, if there are none) in IGES files and of face
/// records in BREP files.
const FILES: [(&str, usize, usize); 12] = [
    ("as1-oc-214.stp", 53, 160),
    ("as1_pe_203.igs", 160, 160),
    ("axom_boxed_sphere.step", 192, 192),
    ("bladex_propeller.iges", 22, 22),
    ("dm1-oc-214.stp", 31, 61),
    ("gpucast_part.igs", 134, 134),
    ("gpucast_teapot.igs", 32, 32),
    ("io1-cm-214.stp", 29, 29),
    ("m6_screw_thread.step", 28, 28),
    ("nist_mbe_pmi_6.stp", 152, 152),
    ("tigl_d150_fused.brep", 257, 257),
    ("tigl_nacelle.stp", 6, 6),
];

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/cad")
}

/// The text of a file's model; `None` if the helper is absent.
fn model_of(path: &Path) -> Option<Result<String, String>> {
    match import(path, &ImportOptions::default(), |_| ControlFlow::Continue(())) {
        Err(error) if error.to_string().contains("setup.sh cad") => {
            eprintln!("left out: {error}");
            None
        }
        result => Some(result.map_err(|error| error.to_string())),
    }
}

/// The number of faces of the last product and of all that it uses.
fn faces_in_all_places(model: &str) -> usize {
    let number = |word: Option<&str>| word.and_then(|word| word.parse::<usize>().ok()).unwrap();
    let mut products: Vec<usize> = Vec::new();
    for line in model.lines() {
        if let Some(used) = line.strip_prefix("use ") {
            let faces = products[number(used.split(' ').next())];
            *products.last_mut().unwrap() += faces;
        } else if line.starts_with("product ") {
            products.push(number(line.split(' ').next_back()));
        }
    }
    products.pop().unwrap()
}

#[test]
fn every_face_of_real_files_is_imported() {
    for (name, in_products, in_all_places) in FILES {
        let path = folder().join(name);
        if !path.exists() {
            eprintln!("left out: {} is absent", path.display());
            return;
        }
        let Some(model) = model_of(&path) else { return };
        let model = model.unwrap();
        let faces = model.lines().filter(|line| line.starts_with("face ")).count();
        assert_eq!(faces, in_products, "{name}");
        assert_eq!(faces_in_all_places(&model), in_all_places, "{name}");
    }
}

/// The lines of one rectangle as an IGES file of a surface 128, with wrong numbers of lines in the directory.
fn iges_with_wrong_numbers(first_line: usize) -> String {
    let line =
        |text: &str, section: &str, number: usize| format!("{text:<72}{section}{number:>7}\n");
    let entry = |fields: [&str; 9]| fields.map(|field| format!("{field:>8}")).concat();
    let first = first_line.to_string();
    let directory = [
        entry(["128", &first, "0", "1", "0", "0", "0", "0", "00010000"]),
        entry(["128", "0", "0", "1", "0", "", "", "FACE", "0"]),
    ];
    let parameters = [
        "128,1,1,1,1,0,0,1,0,0,0.,0.,1.,1.,0.,0.,1.,1.,1.,1.,1.,1.,",
        "0.,0.,0.,3.,0.,0.,0.,2.,0.,3.,2.,0.,0.,1.,0.,1.;",
    ];
    let mut text = line("a file", "S", 1) + &line("1H,", "G", 1);
    text += &directory.iter().map(|own| line(own, "D", 1)).collect::<String>();
    text += &parameters.iter().map(|own| line(own, "P", 4)).collect::<String>();
    text + &line("S      1G      1D      2P      2", "T", 1)
}

#[test]
fn an_iges_file_with_wrong_numbers_is_numbered_anew() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("numbers.igs");
    std::fs::write(&path, iges_with_wrong_numbers(1)).unwrap();
    let Some(model) = model_of(&path) else { return };
    let model = model.unwrap();
    assert_eq!(faces_in_all_places(&model), 1);
    assert!(model.contains("points 2 2 0 0 0 1 3 0 0 1 0 2 0 1 3 2 0 1"), "{model}");
    for first_line in [0, 3, 99_999] {
        std::fs::write(&path, iges_with_wrong_numbers(first_line)).unwrap();
        let message = model_of(&path).unwrap().unwrap_err();
        assert!(message.ends_with("its directory is not in order"), "{first_line}: {message}");
    }
}

#[test]
fn files_that_are_cut_off_or_something_else_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text, expected) in [
        ("empty.step", "", "it is empty"),
        ("other.step", "hello", "it is no complete STEP file"),
        ("cut.stp", "ISO-10303-21;\nHEADER;\n", "it is no complete STEP file"),
        ("other.igs", "hello", "it is no complete IGES file"),
        ("other.brep", "hello", "it is no complete BREP file"),
        ("other.txt", "hello", "its name does not end with .step"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let Some(result) = model_of(&path) else { return };
        let message = result.unwrap_err();
        assert!(message.contains(expected) && message.lines().count() == 1, "{name}: {message}");
    }
}

#[test]
fn damaged_step_files_are_one_line_each() {
    let path = self::folder().join("as1-oc-214.stp");
    let Ok(text) = std::fs::read(&path) else {
        eprintln!("left out: {} is absent", path.display());
        return;
    };
    let text = String::from_utf8_lossy(&text);
    let data = text.find("DATA;").unwrap() + 5;
    // The first use of a product in an assembly becomes a use of the assembly in itself.
    let (before, used) = text.split_once("NEXT_ASSEMBLY_USAGE_OCCURRENCE(").unwrap();
    let values: Vec<&str> = used.splitn(6, ',').collect();
    let [id, name, text_of, assembly, _, rest] = values[..] else { panic!("{values:?}") };
    let contains_itself = format!(
        "{before}NEXT_ASSEMBLY_USAGE_OCCURRENCE({id},{name},{text_of},{assembly},{assembly},{rest}"
    );
    let folder = tempfile::tempdir().unwrap();
    for (name, text, expected) in [
        // Versions of OCCT do different things with these two, but no file is read half.
        ("itself", contains_itself, None),
        ("quotes", text.replacen('\'', "", 4001), None),
        ("half", text[..text.len() / 2].to_owned(), Some("it is no complete STEP file")),
        (
            "nothing",
            format!("{}\nENDSEC;\nEND-ISO-10303-21;\n", &text[..data]),
            Some("it has no shapes"),
        ),
    ] {
        let path = folder.path().join(format!("{name}.stp"));
        std::fs::write(&path, &text).unwrap();
        let Some(result) = model_of(&path) else { return };
        match result {
            Ok(model) => {
                assert_eq!(expected, None, "{name}");
                assert!(faces_in_all_places(&model) > 0 && model.trim_end().ends_with("end"));
            }
            Err(message) => {
                assert!(message.contains(expected.unwrap_or(name)), "{name}: {message}");
                assert_eq!(message.lines().count(), 1, "{message}");
            }
        }
    }
}
