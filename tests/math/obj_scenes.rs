//! OBJ files as other programs write them: byte order marks, continued lines, indices before their definition,
//! materials, colours, concave faces, Bézier surfaces.

use std::path::{Path, PathBuf};

use freeform_surface::{CreaseAngle, Degree, Mesh, Paint, Patch, Result, Scene};
use glam::{DVec3, dvec3};

fn read(bytes: impl AsRef<[u8]>) -> Result<Mesh> {
    Mesh::read_obj(bytes.as_ref(), Path::new("x.obj"), CreaseAngle::default())
}

fn error(bytes: impl AsRef<[u8]>) -> String {
    read(bytes).unwrap_err().to_string()
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// A folder with files in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, bytes).unwrap();
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn load(&self, name: &str) -> Scene {
        Scene::load(&self.path(name)).unwrap_or_else(|error| panic!("{error}"))
    }
}

#[test]
fn marks_and_bytes_of_other_encodings_do_no_harm() {
    let plain = read(format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    let marked = format!("\u{feff}{SQUARE}f 1 2 3 4\n");
    assert_eq!(read(&marked).unwrap(), plain);
    let mut latin = b"# Fl\xe4che\no W\xfcrfel\n".to_vec();
    latin.extend(format!("{SQUARE}g \u{df}\nf 1 2 3 4").bytes());
    assert_eq!(read(&latin).unwrap(), plain);
    assert_eq!(read(marked.replace('\n', "\r\n")).unwrap(), plain);
    let wide: Vec<u8> = "\u{feff}v 0 0 0\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(
        error(&wide).contains("x.obj:1: the text is UTF-16; expected UTF-8"),
        "{}",
        error(&wide)
    );
    // Other text files may begin with a byte order mark too.
    let folder = Folder::new(&[
        ("a.toml", "\u{feff}[[surface]]\ncontrol_points = \"default\"\n".as_bytes()),
        ("b.mtl", "\u{feff}newmtl red\nKd 1 0 0\n".as_bytes()),
        ("b.obj", format!("mtllib b.mtl\n{SQUARE}usemtl red\nf 1 2 3\n").as_bytes()),
    ]);
    assert_eq!(folder.load("a.toml").surfaces.len(), 1);
    assert_eq!(folder.load("b.obj").meshes[0].materials[0].paint, Paint::Color([1.0, 0.0, 0.0]));
    let patch: String = (0..16).map(|i| format!("{} {} 0\n", i % 4, i / 4)).collect();
    let path = folder.path("c.bpt");
    std::fs::write(&path, format!("\u{feff}1\n3 3\n{patch}")).unwrap();
    assert_eq!(Scene::load(&path).unwrap().surfaces.len(), 1);
}

#[test]
fn lines_go_on_after_a_backslash() {
    let plain = read(format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    for face in ["f 1 2 \\\n 3 4\n", "f \\\n1 \\\n2 3\\\n 4", "f 1 2 \\\r\n 3 4\r\n", "f 1 2 3 4\\"]
    {
        let text = format!("{SQUARE}{face}");
        match face {
            // At the end of the file there is no line to continue with.
            "f 1 2 3 4\\" => assert!(error(&text).contains("x.obj:5:"), "{}", error(&text)),
            _ => assert_eq!(read(&text).unwrap(), plain, "{face:?}"),
        }
    }
    // Paths in comments may end in a backslash too; line numbers are those of the file.
    let text = format!("# from C:\\models\\\n{SQUARE}f 1 \\\n 2 3\nf 1 2 nine\n");
    assert!(error(&text).starts_with("x.obj:8: "), "{}", error(&text));
    let long = format!("{SQUARE}f {}", "1 2 3 \\\n".repeat(200_000));
    assert!(error(&long).contains("x.obj:5: the line is longer than"), "{}", error(&long));
}

#[test]
fn indices_may_be_of_what_stands_further_down() {
    let late =
        read("f 1/1/1 2/2/1 3/3/1\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\n");
    let plain =
        read("v 0 0 0\nv 1 0 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\n");
    assert_eq!(late.unwrap(), plain.unwrap());
    // Negative indices count back from their own line.
    let negative = read("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 5 5 5\n").unwrap();
    let corner = negative.triangles()[0][0].position;
    assert_eq!(negative.positions()[corner as usize], DVec3::ZERO);
    for (text, words) in [
        ("f 1 2 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\n", "x.obj:1: index 4 of a position; expected 1 to 3"),
        ("v 0 0 0\nf -1 -2 1\n", "x.obj:2: index -2 of a position; expected −1 to −1"),
        (
            "\nf 1//2 2//2 3//2\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\n",
            "x.obj:2: index 2 of a normal",
        ),
    ] {
        assert!(error(text).contains(words), "{}", error(text));
    }
}

#[test]
fn what_has_no_face_says_what_it_has() {
    for (text, words) in [
        ("l 1 2\nl 2 3\nl 3 4\np 1\n", "it has 3 lines and 1 point, no face"),
        ("p 1 2 3\n", "it has 3 points, no face"),
        ("v 0 0 0\n", "it has 1 position, no face"),
        ("# nothing\n", "it has no face"),
        (
            "cstype cardinal\ndeg 3 3\nsurf 0 1 0 1 1 2\nend\nl 1 2\n",
            "it has 1 line and 1 cardinal surface, no face",
        ),
        (
            "cstype bspline\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nparm u 0 0 1 1\nparm v 0 0 1 1\nend\n",
            "it has 1 NURBS surface, no face",
        ),
        (
            "cstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\nend\nsurf 0 1 0 1 1 2 3 4\nend\np 1\n",
            "it has 2 Bézier patches and 1 point, no face",
        ),
    ] {
        assert!(error(text).contains(words), "{text}: {}", error(text));
    }
}

/// The area of all triangles together.
fn area(mesh: &Mesh) -> f64 {
    let of = |triangle: &[freeform_surface::Corner; 3]| {
        let [a, b, c] = triangle.map(|corner| mesh.positions()[corner.position as usize]);
        0.5 * (b - a).cross(c - a).length()
    };
    mesh.triangles().iter().map(of).sum()
}

#[test]
fn concave_faces_cover_what_they_border() {
    let arrow = read("v 0 0 0\nv 2 2 0\nv 0 1 0\nv -2 2 0\nf 1 2 3 4\n").unwrap();
    assert_eq!(area(&arrow), 2.0);
    let u = "v 0 0 0\nv 3 0 0\nv 3 2 0\nv 2 2 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 1 2 3 4 5 6 7 8\n";
    assert_eq!(area(&read(u).unwrap()), 5.0);
    assert_eq!(area(&read(u.replace("f 1 2 3 4 5 6 7 8", "f 8 7 6 5 4 3 2 1")).unwrap()), 5.0);
}

#[test]
fn materials_and_their_pictures_are_found() {
    let picture = {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let image = image::RgbaImage::from_pixel(2, 2, image::Rgba([0, 0, 255, 255]));
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let faces = "f 1 2 3\nusemtl red\nf 1 3 4\nusemtl blue\nf 2 3 4\nusemtl red\nf 1 2 4\nusemtl none\nf 1 4 3\n";
    let obj = format!("mtllib sub\\my colors.mtl\n{SQUARE}{faces}");
    let mtl = "newmtl red\nKa 1 1 1\nKd 1 0 0\nd 0.5\nnewmtl blue\nKd 0 0 1\nmap_Kd -s 2 2 1 a picture.png\n";
    let folder = Folder::new(&[
        ("a.obj", obj.as_bytes()),
        ("sub/my colors.mtl", mtl.as_bytes()),
        ("sub/a picture.png", &picture),
        (
            "scene.toml",
            b"[[mesh]]\nfile = \"a.obj\"\n[[mesh]]\nfile = \"a.obj\"\ncolor = [0, 1, 0]\n",
        ),
    ]);
    let scene = folder.load("a.obj");
    let files = ["a.obj", "sub/my colors.mtl", "sub/a picture.png"].map(|name| folder.path(name));
    assert_eq!(scene.files, files);
    let model = &scene.meshes[0];
    assert_eq!(model.mesh().mesh().triangles().len(), 5);
    // The triangles are in the order of their materials; those without a material are grey.
    let materials: Vec<_> =
        model.materials.iter().map(|one| (one.name.as_str(), one.triangles.len())).collect();
    assert_eq!(materials, [("red", 2), ("blue", 1)]);
    for material in &model.materials {
        match (material.name.as_str(), &material.paint) {
            ("red", paint) => assert_eq!(*paint, Paint::Color([1.0, 0.0, 0.0])),
            (_, Paint::Texture(image)) => assert_eq!(image.get_pixel(1, 1).0, [0, 0, 255, 255]),
            (_, other) => panic!("{other:?}"),
        }
        for triangle in &model.mesh().mesh().triangles()[material.triangles.clone()] {
            let corners = triangle.map(|corner| corner.position);
            let red = [[0, 2, 3], [0, 1, 3]].contains(&corners);
            assert_eq!(red, material.name == "red", "{corners:?}");
        }
    }
    // A scene's own colour has priority.
    let scene = folder.load("scene.toml");
    assert_eq!(scene.meshes[0].materials.len(), 2);
    assert_eq!(scene.meshes[1].materials, []);
    assert_eq!(scene.files.len(), 1 + 2 * 3);
}

#[test]
fn missing_materials_are_no_error() {
    let obj = format!("mtllib none.mtl\n{SQUARE}usemtl red\nf 1 2 3\n");
    let folder = Folder::new(&[
        ("a.obj", obj.as_bytes()),
        ("b.obj", obj.replace("none", "b").as_bytes()),
        ("b.mtl", b"newmtl red\nKd 1 0 0\nmap_Kd none.png\nKd nonsense\n"),
    ]);
    assert_eq!(folder.load("a.obj").meshes[0].materials, []);
    // A missing file is listed too, so that it can be watched.
    assert_eq!(folder.load("a.obj").files[1], folder.path("none.mtl"));
    assert_eq!(folder.load("b.obj").meshes[0].materials[0].paint, Paint::Color([1.0, 0.0, 0.0]));
    assert_eq!(folder.load("b.obj").files[2], folder.path("none.png"));
}

#[test]
fn positions_may_have_colors() {
    let mesh = read("v 0 0 0 1 0 0\nv 1 0 0 0 0.5 0\nv 1 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(mesh.colors(), [[1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [1.0; 3]]);
    let bytes = read("v 0 0 0 255 0 0\nv 1 0 0 0 51 0\nv 1 1 0 0 0 255 255\nf 1 2 3\n").unwrap();
    assert_eq!(bytes.colors(), [[1.0, 0.0, 0.0], [0.0, 0.2, 0.0], [0.0, 0.0, 1.0]]);
    let mut written = Vec::new();
    mesh.write_obj(&mut written).unwrap();
    assert_eq!(read(&written).unwrap(), mesh);
    // A step of smoothing interpolates the colours.
    let fine = freeform_surface::smooth(mesh.clone(), freeform_surface::Smoothing::Pn, 1).unwrap();
    assert_eq!(fine.colors().len(), fine.positions().len());
    for (position, color) in fine.positions().iter().zip(fine.colors()) {
        // Barycentric coordinates in the flat triangle.
        let [u, v, w] = [1.0 - position.x, position.x - position.y, position.y];
        let expected = dvec3(u + w, 0.5 * v + w, w);
        let color = glam::Vec3::from_array(*color).as_dvec3();
        assert!(color.distance(expected) < 1e-6, "{position}: {color} {expected}");
    }
    let none = mesh.clone().with_colors(Vec::new()).unwrap();
    assert_eq!(none.colors(), [[0.0; 3]; 0]);
    for bad in [vec![[0.0; 3]; 2], vec![[2.0; 3]; 3], vec![[f32::NAN; 3]; 3]] {
        assert!(mesh.clone().with_colors(bad).unwrap_err().to_string().contains("color"));
    }
}

/// The control points of a net whose height is not planar; u varies fastest.
fn net(columns: usize, rows: usize, weight: impl Fn(usize) -> f64) -> (String, Vec<DVec3>) {
    let mut text = String::new();
    let mut points = Vec::new();
    for i in 0..columns * rows {
        let (x, y) = ((i % columns) as f64, (i / columns) as f64);
        let point = dvec3(x, y, (x * 1.3).sin() + 0.2 * y * x);
        text += &format!("v {} {} {} {}\n", point.x, point.y, point.z, weight(i));
        points.push(point);
    }
    (text, points)
}

fn numbers(range: std::ops::RangeInclusive<usize>) -> String {
    range.map(|i| i.to_string()).collect::<Vec<_>>().join(" ")
}

#[test]
fn bezier_surfaces_are_patches() {
    // Two patches along u and one along v.
    let (points, net_points) = net(7, 4, |_| 1.0);
    let text = format!(
        "{points}cstype bezier\ndeg 3 3\nsurf 0 2 0 1 {}\nparm u 0 1 2\nparm v 0 1\nend\n",
        numbers(1..=28)
    );
    let folder = Folder::new(&[("a.obj", text.as_bytes())]);
    let scene = folder.load("a.obj");
    assert_eq!((scene.surfaces.len(), scene.meshes.len()), (1, 0));
    let surface = &scene.surfaces[0];
    assert_eq!((surface.degree(), surface.patches().len()), (Degree::CUBIC, 2));
    for (number, patch) in surface.patches().enumerate() {
        // By de Casteljau along u, then along v.
        for (u, v) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.3, 0.8)] {
            let lerp = |mut points: Vec<DVec3>, t: f64| {
                while points.len() > 1 {
                    points = points.windows(2).map(|pair| pair[0].lerp(pair[1], t)).collect();
                }
                points[0]
            };
            let rows = (0..4).map(|row| {
                lerp((0..4).map(|column| net_points[row * 7 + 3 * number + column]).collect(), u)
            });
            let expected = lerp(rows.collect(), v);
            assert!(patch.at(u, v).position.distance(expected) < 1e-14);
        }
    }
}

#[test]
fn weights_count_where_surfaces_are_rational() {
    let (points, _) = net(5, 5, |i| 1.0 + i as f64);
    for (kind, weight) in [("rat bezier", 3.0), ("bezier", 1.0)] {
        let text = format!(
            "{points}cstype {kind}\ndeg 4 4\nsurf 0 1 0 1 {}\nparm u 0 1\nparm v 0 1\nend\nf 1 2 7\n",
            numbers(1..=25)
        );
        let folder = Folder::new(&[("a.obj", text.as_bytes())]);
        let scene = folder.load("a.obj");
        assert_eq!((scene.surfaces.len(), scene.meshes.len()), (1, 1));
        let surface = &scene.surfaces[0];
        assert_eq!(surface.degree(), Degree::QUARTIC);
        assert_eq!(surface.control_points()[2].w, weight);
        let patch: Patch<'_> = surface.patches().next().unwrap();
        let corner = surface.control_points()[4].truncate();
        assert!(patch.at(1.0, 0.0).position.distance(corner) < 1e-14);
    }
    // The same as a surface of a scene.
    let (points, _) = net(4, 4, |_| 1.0);
    let surf = format!("cstype bezier\ndeg 3 3\nsurf 0 1 0 1 {}\nend\n", numbers(1..=16));
    let folder = Folder::new(&[
        ("a.obj", format!("{points}{surf}").as_bytes()),
        ("b.obj", format!("{points}f 1 2 3\n").as_bytes()),
        ("a.toml", b"[[surface]]\nfile = \"a.obj\"\ncolor = [1, 0, 0]\n"),
        ("b.toml", b"[[surface]]\nfile = \"b.obj\"\n"),
        ("c.toml", b"[[mesh]]\nfile = \"a.obj\"\n"),
    ]);
    assert_eq!(folder.load("a.toml").surfaces[0].paint, Paint::Color([1.0, 0.0, 0.0]));
    for (name, words) in [("b.toml", "no free-form surface"), ("c.toml", "[[surface]]")] {
        let text = Scene::load(&folder.path(name)).unwrap_err().to_string();
        assert!(text.contains(words) && text.contains(":2: "), "{text}");
    }
}

#[test]
fn bad_surfaces_are_refused_with_their_line() {
    let (points, _) = net(4, 4, |i| if i == 5 { 0.0 } else { 1.0 });
    let surf = |kind: &str, points: &str| {
        format!("cstype {kind}\ndeg 3 3\nsurf 0 1 0 1 {points}\nparm u 0 1\nparm v 0 1\nend\n")
    };
    for (text, words) in [
        (surf("bezier", &numbers(1..=15)), "x.obj:22: the surface has 15 control points"),
        (surf("bezier", &numbers(2..=17)), "x.obj:19: index 17 of a position; expected 1 to 16"),
        (surf("rat bezier", &numbers(1..=16)), "x.obj:19: the weight of position 6 is 0"),
        (surf("bezier", "1 2 three"), "x.obj:19: \"three\" is no index"),
    ] {
        let folder = Folder::new(&[("x.obj", format!("{points}{text}").as_bytes())]);
        let text = Scene::load(&folder.path("x.obj")).unwrap_err().to_string();
        assert!(text.contains(words), "{text}");
    }
}
