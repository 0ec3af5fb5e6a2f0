//! Wavefront OBJ: files that are read, files that are refused with the line of the error, and written files
//! that read back.

use std::io::{BufReader, Read};
use std::path::Path;

use freeform_surface::{Corner, CreaseAngle, Mesh, Result, Scene, Smoothing, smooth};
use glam::{DVec2, DVec3, dvec2, dvec3};
use proptest::prelude::*;

fn read(text: &str) -> Result<Mesh> {
    Mesh::read_obj(text.as_bytes(), Path::new("x.obj"), CreaseAngle::NONE)
}

fn positions(mesh: &Mesh) -> Vec<[u32; 3]> {
    mesh.triangles().iter().map(|corners| corners.map(|corner| corner.position)).collect()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
const BOX: &str = "# a comment\nmtllib x.mtl\no box\nv 0 0 0 1.0\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0 # here\r\n\
                   v 0 1 0\nvt 0 0\nvt 1 0 0\nvt 1\nvn 0 0 2\ng one\nusemtl red\ns off\n\
                   f 1/1/1 2/2/1 3/3/1\n\ng two\nf -4//-1 -2//-1 -1//1\nl 1 2\n";

#[test]
fn statements_are_read_and_others_skipped() {
    let mesh = read(BOX).unwrap();
    assert_eq!(mesh.positions(), [DVec3::ZERO, DVec3::X, dvec3(1.0, 1.0, 0.0), DVec3::Y]);
    assert_eq!(mesh.normals(), [DVec3::Z]);
    // The second face has no texture coordinates: (0, 0) is added.
    assert_eq!(mesh.coordinates(), [DVec2::ZERO, DVec2::X, DVec2::X, DVec2::ZERO]);
    let corner = |position, coordinate| Corner { position, normal: 0, coordinate };
    assert_eq!(
        mesh.triangles(),
        [[corner(0, 0), corner(1, 1), corner(2, 2)], [corner(0, 3), corner(2, 3), corner(3, 3)]]
    );
}

#[test]
fn polygons_become_fans_and_missing_normals_are_computed() {
    let mesh = read(&format!("{SQUARE}v -1 0.5 0\nf 1 2 3 4 5\n")).unwrap();
    assert_eq!(positions(&mesh), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
    assert!(mesh.coordinates().is_empty());
    assert!(mesh.normals().iter().all(|normal| normal.distance(DVec3::Z) < 1e-15));
}

#[test]
fn computed_normals_are_weighted_by_angle() {
    // A corner of a cube: a face of two triangles has the same weight as a face of one.
    let mesh = read(&format!("{SQUARE}v 0 0 1\nf 1 2 3\nf 1 3 4\nf 5 1 4\nf 1 5 2\n")).unwrap();
    let normal = mesh.normals()[mesh.triangles()[0][0].normal as usize];
    assert!(normal.distance(dvec3(1.0, 1.0, 1.0).normalize()) < 1e-15, "{normal}");
}

#[test]
fn equal_positions_are_one() {
    let twice = format!("{SQUARE}v -0 0 0\nv 1 1 0\nf 1 2 3\nf 5 6 4\n");
    assert_eq!(positions(&read(&twice).unwrap()), [[0, 1, 2], [0, 2, 3]]);
    // The same holds where sheets touch along an edge.
    let sheets = format!("{twice}v 0 0 0\nv 1 1 0\nv 0 0 5\nf 7 8 9\n");
    assert_eq!(positions(&read(&sheets).unwrap()), [[0, 1, 2], [0, 2, 3], [0, 2, 8]]);
    // A triangle that has the same position twice is left out.
    let line = format!("{twice}f 1 5 2\nf 1 1 3\n");
    assert_eq!(positions(&read(&line).unwrap()).len(), 2);
    let nothing = read(&format!("{SQUARE}f 1 1 3\n")).unwrap_err().to_string();
    assert!(nothing.contains("of 1 triangle each has the same position twice"), "{nothing}");
}

#[test]
fn bad_files_are_refused_with_their_line() {
    let square = |rest: &str| format!("{SQUARE}vt 0 0\nvn 0 0 1\n{rest}\n");
    for (text, words) in [
        (square("f 0 1 2"), ["x.obj:7:", "index 0 of a position; expected 1 to 4"]),
        (square("f 1 2 5"), ["x.obj:7:", "index 5 of a position; expected 1 to 4"]),
        (square("f 1 2 -5"), ["x.obj:7:", "index -5 of a position"]),
        (square("f 1/0 2 3"), ["x.obj:7:", "index 0 of a texture coordinate; expected 1 to 1"]),
        (square("f 1//2 2 3"), ["x.obj:7:", "index 2 of a normal"]),
        (square("f 1//6148914691236517206 2 3"), ["x.obj:7:", "index 6148914691236517206"]),
        (square("f 1 2 99999999999999999999"), ["x.obj:7:", "is no index"]),
        (square("f 1 2"), ["x.obj:7:", "the face has 2 corners; expected at least 3"]),
        (square("f"), ["x.obj:7:", "the face has 0 corners"]),
        (square("f 1/1/1/1 2 3"), ["x.obj:7:", "\"1/1/1/1\" is no corner"]),
        (square("f /1 2 3"), ["x.obj:7:", "\"/1\" is no corner"]),
        (square("f 1 2 x"), ["x.obj:7:", "\"x\" is no index"]),
        (square("\nv nan 0 0"), ["x.obj:8:", "\"nan\" is no finite number"]),
        (square("v 1e999 0 0"), ["x.obj:7:", "\"1e999\" is no finite number"]),
        (square("v 1e16 0 0"), ["x.obj:7:", "at most 1e15"]),
        (square("v 1 2"), ["x.obj:7:", "the position has 2 numbers; expected 3"]),
        (square("v 1 2 3 4 5 6 7 8"), ["x.obj:7:", "the position has 8 numbers"]),
        (square("vn 1 2"), ["x.obj:7:", "the normal has 2 numbers; expected 3"]),
        (square("vn 1 inf 2"), ["x.obj:7:", "\"inf\""]),
        (square("vt"), ["x.obj:7:", "the texture coordinate has 0 numbers"]),
        (square("vt 1 nan"), ["x.obj:7:", "\"nan\""]),
        ("f 1 2 3".into(), ["x.obj:1:", "index 1 of a position; but there is none"]),
        (SQUARE.into(), ["x.obj", "it has 4 positions, no face"]),
        (String::new(), ["x.obj", "it has no face"]),
    ] {
        let error = read(&text).unwrap_err().to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{text}: {error}");
        assert_eq!(error.lines().count(), 1);
    }
    let load = |path: &str| Mesh::load_obj(Path::new(path), CreaseAngle::NONE).unwrap_err();
    assert!(load("no/such.obj").to_string().contains("cannot read no/such.obj"));
    assert!(load("/").to_string().contains("a folder"));
}

#[test]
fn a_line_of_a_gibibyte_is_refused_without_being_read() {
    struct Counted<R>(R, u64);
    impl<R: Read> Read for Counted<R> {
        fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
            let count = self.0.read(to)?;
            self.1 += count as u64;
            Ok(count)
        }
    }
    let line = std::io::repeat(b'1').take(1 << 30);
    let mut source = Counted("\n\nv ".as_bytes().chain(line), 0);
    let error = Mesh::read_obj(BufReader::new(&mut source), Path::new("x.obj"), CreaseAngle::NONE);
    let error = error.unwrap_err().to_string();
    assert_eq!(error, "x.obj:3: the line is longer than 1048576 bytes");
    assert!(source.1 < 2 << 20, "{} bytes were read", source.1);
}

#[test]
fn what_is_written_reads_back_as_the_same_numbers() {
    for name in ["figure", "torus", "hard/opposite-normals", "hard/offset-1e6", "hard/boundary"] {
        let path = format!("{}/resources/meshes/{name}.obj", env!("CARGO_MANIFEST_DIR"));
        let mesh = Mesh::load_obj(Path::new(&path), CreaseAngle::NONE).unwrap();
        for smoothing in [Smoothing::None, Smoothing::Pn] {
            let mesh = smooth(mesh.clone(), smoothing, 1).unwrap();
            let mut text = Vec::new();
            mesh.write_obj(&mut text).unwrap();
            let text = String::from_utf8(text).unwrap();
            assert_eq!(read(&text).unwrap(), mesh, "{name}");
        }
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("resources/meshes/torus.obj");
    let torus = Mesh::load_obj(&path, CreaseAngle::NONE).unwrap();
    let place = torus.triangles()[0][1].coordinate as usize;
    assert_eq!(torus.coordinates()[place], dvec2(0.0, 0.125));
}

/// Reading returns a mesh, or an error of one line.
fn answers(bytes: &[u8]) {
    for degrees in [0.0, 180.0] {
        let crease = CreaseAngle::new(degrees).unwrap();
        match Mesh::read_obj(bytes, Path::new("x.obj"), crease) {
            Ok(mesh) => {
                assert!(!mesh.triangles().is_empty());
                for smoothing in [Smoothing::Pn, Smoothing::None] {
                    if let Ok(fine) = smooth(mesh.clone(), smoothing, 1) {
                        assert!(fine.positions().iter().all(|point| point.is_finite()));
                    }
                }
            }
            Err(error) => assert_eq!(error.to_string().lines().count(), 1, "{error}"),
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_bytes_get_an_answer(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        answers(&bytes);
    }

    #[test]
    fn mutated_files_get_an_answer(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = BOX.as_bytes().to_vec();
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        answers(&bytes);
        answers(&bytes[..cut.index(bytes.len())]);
    }

    #[test]
    fn any_faces_get_an_answer(
        numbers in prop::collection::vec(prop_oneof![-9.0..9.0, any::<f64>()], 12),
        faces in prop::collection::vec(prop::collection::vec(-5_i64..6, 0..6), 0..12),
    ) {
        let mut text = String::new();
        for point in numbers.chunks(3) {
            text += &format!("v {} {} {}\n", point[0], point[1], point[2]);
        }
        for face in faces {
            let corners: Vec<String> = face.iter().map(i64::to_string).collect();
            text += &format!("f {}\n", corners.join(" "));
        }
        answers(text.as_bytes());
    }
}

#[test]
fn what_is_wrong_with_a_mesh_of_a_scene_is_said_with_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("good.obj", &format!("{SQUARE}f 1 2 3 4\n"));
    write("bad.obj", &format!("{SQUARE}f 1 2 9\n"));
    write("curve.obj", &format!("{SQUARE}cstype cardinal\ndeg 3 3\nsurf 0 1 0 1 1 2 3 4\nend\n"));
    let read = |mesh: &str| {
        let text = format!("[render]\nlevel = 2\n\n[[mesh]]\n{mesh}\n");
        Scene::from_toml(&text, &folder.path().join("scene.toml"))
    };
    assert_eq!(read("file = \"good.obj\"\nsmoothing = \"pn\"").unwrap().meshes.len(), 1);
    let good = "file = \"good.obj\"\nsmoothing = \"phong\"\n";
    for (mesh, line, words) in [
        (format!("{good}alpha = 1.5"), 7, ["alpha", "1.5", "from 0 to 1"]),
        ("file = \"good.obj\"\nalpha = 0.5".into(), 6, ["alpha", "0.5", "phong"]),
        (format!("{good}level = 65"), 7, ["level", "65", "64"]),
        (format!("{good}crease_degrees = 181"), 7, ["crease_degrees", "181", "180"]),
        (format!("{good}scale = 0"), 4, ["scale", "0", "other than 0"]),
        (format!("{good}color = [0, 0, 2]"), 7, ["color", "2", "0 to 1"]),
        (format!("{good}smooth = 1"), 7, ["smooth", "unknown field", "smoothing"]),
        ("file = \"good.obj\"\nsmoothing = \"loop\"".into(), 6, ["loop", "pn", "phong"]),
        ("smoothing = \"pn\"".into(), 4, ["missing", "file", "scene.toml"]),
        ("file = \"none.obj\"".into(), 5, ["none.obj", "No such file", "read"]),
        ("file = \"bad.obj\"".into(), 5, ["bad.obj", "5", "9"]),
        ("file = \"curve.obj\"".into(), 5, ["curve.obj", "1 cardinal surface", "no face"]),
    ] {
        let text = read(&mesh).unwrap_err().to_string();
        let place = format!("scene.toml:{line}: ");
        assert!(text.contains(&place) && text.lines().count() == 1, "{mesh}: {text}");
        assert!(words.iter().all(|word| text.contains(word)), "{mesh}: {text}");
    }
}
