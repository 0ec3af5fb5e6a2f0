//! CAD models on the command line: `freeform info FILE`, `freeform convert`, and lines in pictures.

use crate::harness::program::{Folder, resource, text};

/// A sheet of 2 × 1 inches, used twice, and a face whose edge is missing.
const SHEETS: &str = "freeform-model 1 name \"sheets\" unit 0.0254
edge tolerance 1e-7 range 0 2 line 0 0 0  1 0 0
edge tolerance 1e-7 range 0 1 line 2 0 0  0 1 0
edge tolerance 1e-7 range 0 2 line 0 1 0  1 0 0
edge tolerance 1e-7 range 0 1 line 0 0 0  0 1 0
face tolerance 1e-7 forward bounds 0 2 0 1 plane origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1
  loop 4 + 0 + 1 - 2 - 3
face name \"torn\" tolerance 1e-7 forward bounds 0 2 0 1 plane origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1
  loop 3 + 0 + 1 - 2
product name \"sheet\" faces 0 2
product faces 2 0 use 0 columns 1 0 0 0 1 0 0 0 1 0 0 0 use 0 columns 1 0 0 0 1 0 0 0 1 3 0 4
end
";

#[test]
fn info_says_what_a_model_consists_of() {
    let folder = Folder::new();
    folder.write("sheets.ffm", SHEETS);
    let output = folder.run(&["info", "sheets.ffm"]);
    let said = text(&output.stdout);
    let value = |name: &str| {
        let line = said.lines().find(|line| line.trim_start().starts_with(name));
        line.unwrap_or_else(|| panic!("{name} in {said}"))[24..].trim().to_owned()
    };
    assert!(output.status.success(), "{}", text(&output.stderr));
    for (name, expected) in [
        ("model", "sheets"),
        ("unit", "in"),
        ("size", "5 × 1 × 4 in"),
        ("products", "2"),
        ("faces", "2, in all places 4"),
        ("by surface", "plane 2"),
        ("by degree", "(1, 1) 1"),
        ("trim segments", "4"),
        ("area", "2 in²"),
        ("edges  ", "4: used twice 3, open 1, used more often 0, poles 0"),
        ("p-curves", "0 of the file, 4 computed, 0 computed because the file's is off"),
    ] {
        assert_eq!(value(name), expected, "{name}");
    }
    assert!(value("left out").starts_with("face 1 \"torn\""), "{said}");
    let output = folder.run(&["info", "none.ffm"]);
    assert_eq!(output.status.code(), Some(1));
    assert_eq!(text(&output.stderr).lines().count(), 1);
}

/// A square whose edges are out of order, one with gaps, and a part of a cylinder with an edge along which the nearest
/// parameter all but jumps.
const REPAIRED: &str = "freeform-model 1 unit 0.001
edge tolerance 1e-7 range 0 1 line 0 0 0  1 0 0
edge tolerance 1e-7 range 0 1 line 1 0 0  0 1 0
edge tolerance 1e-7 range 0 1 line 0 1 0  1 0 0
edge tolerance 1e-7 range 0 1 line 0 0 0  0 1 0
edge tolerance 1e-7 range 0 1 line 0 1.00001 0  1 0 0
edge tolerance 1 range -1.25 1.25 line 0 1e-7 2  0.8 0 0.6
edge tolerance 1e-7 range 0 3.141592653589793 circle origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1 1
edge tolerance 1e-7 range 0 2.75 line 1 0 0  0 0 1
edge tolerance 1e-7 range 0 1.25 line -1 0 0  0 0 1
face name \"mixed\" tolerance 1e-7 forward bounds 0 1 0 1 plane origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1
  loop 4 + 0 - 2 + 1 - 3
face tolerance 1e-7 forward bounds 0 1 0 1 plane origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1
  loop 4 + 0 + 1 - 4 - 3
face tolerance 1e-7 forward bounds 0 3.2 0 3 cylinder origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1 1
  loop 4 + 6 + 8 + 5 - 7
product faces 0 3
end
";

#[test]
fn info_says_what_was_repaired() {
    let folder = Folder::new();
    folder.write("repaired.ffm", REPAIRED);
    let output = folder.run(&["info", "repaired.ffm"]);
    let said = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let lines: Vec<&str> =
        said.lines().skip_while(|line| !line.starts_with("p-curves left")).collect();
    let starts = [
        "p-curves left out        of 0 faces",
        "edges reordered          of 1 faces",
        "  face 0                 \"mixed\"",
        "gaps closed by lines     2, at most 1.00e-5 mm (",
        "  edge ",
        "  edge ",
        "edges drawn roughly      1",
        "  edge 5, face 2         off by ",
    ];
    assert_eq!(lines.len(), starts.len(), "{said}");
    for (line, start) in lines.iter().zip(starts) {
        assert!(line.starts_with(start), "{line:?}, not {start:?} in {said}");
    }
    assert!(lines[4..6].iter().all(|line| line.contains(", face 1  ")), "{said}");
    assert!(said.contains("\n  certainly below        "), "{said}");
    assert!(said.contains("\n  joined to others       0\n"), "{said}");
}

#[test]
fn convert_writes_the_model_whole_or_nothing() {
    let folder = Folder::new();
    let flange = resource("models/flange.ffm");
    let output = folder.run(&["convert", &flange, "-o", "out.ffm"]);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let stored = std::fs::read_to_string(&flange).unwrap();
    assert_eq!(std::fs::read_to_string(folder.path("out.ffm")).unwrap(), stored);
    let output = folder.run(&["convert", &flange, "-o", "-"]);
    assert_eq!(text(&output.stdout), stored);

    folder.write("cut.ffm", &stored[..stored.len() / 2]);
    for (arguments, words) in [
        (["convert", "cut.ffm", "-o", "out.ffm"], "cut.ffm:"),
        (["convert", "none.step", "-o", "out.ffm"], "none.step"),
        (["convert", &flange, "-o", "out.step"], "ends in .ffm"),
    ] {
        let output = folder.run(&arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
        assert_eq!(std::fs::read_to_string(folder.path("out.ffm")).unwrap(), stored);
        assert!(!folder.path("out.step").exists());
    }
}

#[test]
fn inspect_says_how_faces_meet() {
    let folder = Folder::new();
    let bracket = resource("models/bracket.ffm");
    let output = folder.run(&["inspect", &bracket]);
    let said = text(&output.stdout);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let mut lines = said.lines();
    let first = lines.next().unwrap();
    let expected = "36 edges: G2 2, G1 11, G0 23, non-manifold 0, open 0, gap 0; largest gap ";
    assert!(first.starts_with(expected) && first.contains("largest angle 90.0° at edge"), "{said}");
    assert!(lines.next().unwrap().contains("G1: angle at most 1°"), "{said}");
    assert_eq!(said.lines().count(), 2 + 2 + 20 + 1, "{said}");
    assert_eq!(said.lines().last(), Some("16 more edges; --all lists them"));
    let all = folder.run(&["inspect", &bracket, "--all"]);
    let all = text(&all.stdout);
    assert_eq!(all.lines().count(), 2 + 2 + 36, "{all}");
    // A quarter of a cylinder of radius 4 between two planes.
    let fillets = all.lines().filter(|line| line.contains(" G1 ") && line.contains(" 0.250 "));
    assert!(fillets.count() > 0, "{all}");

    let output = folder.run(&["inspect", &bracket, "--format", "json"]);
    let object: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&object["model"], &object["unit_metres"]), (&"bracket".into(), &0.001.into()));
    assert_eq!((&object["classes"]["G1"], &object["classes"]["gap"]), (&11.into(), &0.into()));
    assert_eq!(object["limits"]["angle_degrees"], 1.0);
    let edges = object["edges"].as_array().unwrap();
    assert_eq!(edges.len(), 36);
    for edge in edges {
        let is_smooth = edge["class"] != "G0";
        assert_eq!(edge["faces"].as_array().unwrap().len(), 2, "{edge}");
        assert_eq!(edge["angle_degrees"]["point"].as_array().unwrap().len(), 3, "{edge}");
        assert!(edge["gap"]["value"].as_f64().unwrap() < 1e-9, "{edge}");
        assert!(edge["off_edge"]["value"].as_f64().unwrap() < 1e-9, "{edge}");
        assert_eq!(edge["curvature_jump"].is_null(), !is_smooth, "{edge}");
        assert_eq!(edge["relative_curvature_jump"].is_null(), !is_smooth, "{edge}");
    }
}

#[test]
fn inspect_refuses_what_is_no_model_in_one_line() {
    let folder = Folder::new();
    folder.write("cut.ffm", &SHEETS[..SHEETS.len() / 2]);
    for (arguments, status, words) in [
        (&["inspect", "cut.ffm"][..], 1, "cut.ffm:"),
        (&["inspect", "none.step"], 1, "none.step"),
        (&["inspect"], 2, "MODEL"),
        (&["inspect", "cut.ffm", "--format", "xml"], 2, "xml"),
    ] {
        let output = folder.run(arguments);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
        assert!(output.stdout.is_empty());
    }
}

#[test]
fn lines_of_the_command_line_override_the_scenes() {
    let folder = Folder::new();
    let model = resource("models/bracket.ffm");
    folder.write(
        "lined.toml",
        format!("[render]\nedges = true\nisolines = 5\n[[model]]\nfile = {model:?}\n"),
    );
    let render = |scene: &str, options: &[&str]| {
        let arguments = ["render", scene, "--resolution", "240x160", "-o", "out.png"];
        let output = folder.run(&[&arguments[..], options].concat());
        assert!(output.status.success(), "{}", text(&output.stderr));
        std::fs::read(folder.path("out.png")).unwrap()
    };
    let plain = render(&model, &[]);
    let edges = render(&model, &["--edges"]);
    let classes = render(&model, &["--color", "continuity"]);
    let isolines = render(&model, &["--isolines", "5"]);
    let all = [&plain, &edges, &classes, &isolines];
    for (i, one) in all.iter().enumerate() {
        assert!(all[..i].iter().all(|other| other != one), "{i}");
    }
    assert_eq!(render(&model, &["--edges", "--color=continuity"]), classes);
    assert_eq!(render("lined.toml", &["--edges=false"]), isolines);
    assert_eq!(render("lined.toml", &["--isolines", "0"]), edges);
    assert_eq!(render("lined.toml", &["--isolines=0", "--color", "continuity"]), classes);
}

#[test]
fn wrong_lines_are_refused_in_one_line() {
    let folder = Folder::new();
    let model = resource("models/bracket.ffm");
    for (option, value, words) in [
        ("--isolines", "-1", "from 0 to 1000"),
        ("--isolines", "1001", "from 0 to 1000"),
        ("--isolines", "2.5", "from 0 to 1000"),
        ("--isolines", "99999999999999999999", "from 0 to 1000"),
        ("--color", "rainbow", "continuity"),
    ] {
        let output = folder.run(&["render", &model, option, value]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(words) && said.lines().count() == 1, "{said}");
    }
}
