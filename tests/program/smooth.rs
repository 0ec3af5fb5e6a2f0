//! `freeform smooth`, from the command line.

use std::path::Path;
use std::process::{Command, Output};

use freeform_surface::{Alpha, CreaseAngle, Mesh, Smoothing, smooth};

fn freeform(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_freeform"))
        .args(arguments)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("the program runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).expect("it speaks UTF-8")
}

const FIGURE: &str = "resources/meshes/figure.obj";

fn load(path: &str, degrees: f64) -> Mesh {
    let crease = CreaseAngle::new(degrees).unwrap();
    Mesh::load_obj(&Path::new(env!("CARGO_MANIFEST_DIR")).join(path), crease).unwrap()
}

#[test]
fn it_writes_what_the_library_makes_and_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.obj");
    let out = out.to_str().unwrap();
    let half = Smoothing::Phong(Alpha::new(0.5).unwrap());
    for (options, smoothing, degrees, steps) in [
        (&["--method", "pn"][..], Smoothing::Pn, 30.0, 1),
        (&["--method=phong", "--steps=2"][..], Smoothing::Phong(Alpha::default()), 30.0, 2),
        (&["--method=phong", "--alpha=0.5", "--crease-degrees=40"][..], half, 40.0, 1),
    ] {
        let mut arguments = vec!["smooth", FIGURE, "-o", out];
        arguments.extend(options);
        let output = freeform(&arguments);
        let triangles = 260 * 9_usize.pow(steps);
        let line = format!("wrote {out}: 260 triangles became {triangles}\n");
        assert_eq!((text(&output.stdout), text(&output.stderr)), (line, String::new()));
        let expected = smooth(load(FIGURE, degrees), smoothing, steps).unwrap();
        let mut written = Vec::new();
        expected.write_obj(&mut written).unwrap();
        assert!(std::fs::read(out).unwrap() == written, "{options:?}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
    let output = freeform(&["smooth", FIGURE, "--method", "pn", "-o", "-"]);
    let mut written = Vec::new();
    smooth(load(FIGURE, 30.0), Smoothing::Pn, 1).unwrap().write_obj(&mut written).unwrap();
    assert!(output.status.success() && output.stdout == written);
    assert_eq!(text(&output.stderr), "wrote standard output: 260 triangles became 2340\n");
}

#[test]
fn wrong_use_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let bad = path("bad.obj");
    std::fs::write(&bad, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 0\n").unwrap();
    let flat = path("flat.obj");
    std::fs::write(&flat, "v 0 0 0\nv 1 0 0\nl 1 2\np 1\n").unwrap();
    let out = path("out.obj");
    for (input, options, status, words) in [
        (bad.as_str(), &["--method=pn"][..], 1, ["bad.obj:4:", "index 0 of a position"]),
        (&flat, &["--method=pn"], 1, ["cannot read", "1 line and 1 point, no face"]),
        ("no.obj", &["--method=pn"], 1, ["cannot read no.obj", ""]),
        (FIGURE, &["--method=pn", "--alpha=0.5"], 1, ["--alpha", "--method phong"]),
        (FIGURE, &["--method=pn", "--steps=6"], 1, ["260 · 9^6", "50000000"]),
        (FIGURE, &["--method=pn", "--steps=9"], 2, ["9", "1..=8"]),
        (FIGURE, &["--method=pn", "--steps", "-1"], 2, ["-1", "1..=8"]),
        (FIGURE, &["--method=flat"], 2, ["flat", "pn, phong"]),
        (FIGURE, &["--method=phong", "--alpha=2"], 2, ["2", "from 0 to 1"]),
        (FIGURE, &["--method=phong", "--alpha=nan"], 2, ["nan", "from 0 to 1"]),
        (FIGURE, &["--method=pn", "--crease-degrees=181"], 2, ["181", "from 0 to 180"]),
        (FIGURE, &[], 2, ["--method", ""]),
    ] {
        let mut arguments = vec!["smooth", input, "-o", &out];
        arguments.extend(options);
        let output = freeform(&arguments);
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(status), "{error}");
        assert_eq!((error.lines().count(), output.stdout.len()), (1, 0), "{error}");
        assert!(words.iter().all(|word| error.contains(word)), "{error}");
        assert!(!Path::new(&out).exists());
    }
    let same = freeform(&["smooth", &bad, "--method=pn", "-o", &bad]);
    assert!(text(&same.stderr).contains("read from"));
    let nowhere = freeform(&["smooth", FIGURE, "--method=pn", "-o", &path("no/out.obj")]);
    assert!(text(&nowhere.stderr).contains("cannot write"));
}
