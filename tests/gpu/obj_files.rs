//! Two hundred OBJ files with the variety of real files: each is drawn, or refused with one line. Smoothing
//! opens no gaps.

use std::collections::HashMap;
use std::fmt::Write as _;
use std::path::Path;

use freeform_surface::inspect::measure::Random;
use freeform_surface::{Corner, CreaseAngle, Mesh, MeshModel, Scene, Smoothing, smooth};
use glam::{DMat3, DVec3, UVec2, dvec3};

use crate::harness::Stage;

/// The way in which a file is written.
struct Style {
    line_end: &'static str,
    /// Indices are negative: they count back from the last definition above.
    negative: bool,
    /// Faces come before the definitions that they refer to.
    late: bool,
    /// Every face has its own points.
    apart: bool,
    normals: bool,
    coordinates: bool,
    colors: bool,
    continued: bool,
}

/// A shape: points, and faces of three and more corners.
#[derive(Default)]
struct Shape {
    points: Vec<DVec3>,
    faces: Vec<Vec<usize>>,
}

impl Shape {
    fn add(&mut self, points: &[DVec3], faces: &[Vec<usize>]) {
        let first = self.points.len();
        self.points.extend_from_slice(points);
        self.faces.extend(faces.iter().map(|face| face.iter().map(|i| first + i).collect()));
    }

    /// A prism over a star-shaped polygon: two faces of many corners and quadrilaterals around.
    fn prism(&mut self, random: &mut Random) {
        let count = 3 + random.below(12);
        let radii: Vec<f64> = (0..count).map(|_| 0.2 + random.unit()).collect();
        let at = |i: usize, z: f64| {
            let (sine, cosine) = (std::f64::consts::TAU * i as f64 / count as f64).sin_cos();
            dvec3(radii[i] * cosine, radii[i] * sine, z)
        };
        let points: Vec<DVec3> =
            (0..2 * count).map(|i| at(i % count, (i / count) as f64)).collect();
        let mut faces = vec![(0..count).rev().collect(), (count..2 * count).collect()];
        faces.extend((0..count).map(|i| {
            let next = (i + 1) % count;
            vec![i, next, count + next, count + i]
        }));
        self.add(&points, &faces);
    }

    /// A grid with hills, an island or two left out.
    fn terrain(&mut self, random: &mut Random) {
        let side = 3 + random.below(8);
        let points: Vec<DVec3> = (0..side * side)
            .map(|i| dvec3((i % side) as f64, (i / side) as f64, random.unit()))
            .collect();
        let holes = random.below(3);
        let mut faces = Vec::new();
        for (x, y) in (0..side - 1).flat_map(|y| (0..side - 1).map(move |x| (x, y))) {
            let corner = y * side + x;
            if holes > 0 && random.chance(10 * holes) {
                continue;
            }
            faces.push(vec![corner, corner + 1, corner + side + 1, corner + side]);
        }
        self.add(&points, &faces);
    }

    /// Adds the faults of real files: fins, duplicates, reversed faces, degenerate faces.
    fn spoil(&mut self, random: &mut Random) {
        for _ in 0..random.below(4) {
            let face = self.faces[random.below(self.faces.len())].clone();
            match random.below(6) {
                0 => {
                    // A fin on an edge.
                    let tip = self.points[face[0]] + dvec3(0.3, 0.4, 1.5);
                    self.points.push(tip);
                    self.faces.push(vec![face[0], face[1], self.points.len() - 1]);
                }
                1 => self.faces.push(face),
                2 => self.faces.push(face.into_iter().rev().collect()),
                3 => {
                    let turned = random.below(self.faces.len());
                    self.faces[turned].reverse();
                }
                4 => self.faces.push(vec![face[0], face[0], face[1]]),
                _ => {
                    let count = self.points.len();
                    self.points.push(dvec3(random.unit(), 2.0, -3.0));
                    self.faces.push(vec![face[0], face[1], face[0], count - 1]);
                }
            }
        }
    }
}

fn text_of(shape: &Shape, style: &Style, random: &mut Random) -> String {
    let (mut points, mut faces) = (Vec::new(), Vec::new());
    if style.apart {
        for face in &shape.faces {
            let first = points.len();
            points.extend(face.iter().map(|i| shape.points[*i]));
            faces.push((first..points.len()).collect::<Vec<_>>());
        }
    } else {
        points.clone_from(&shape.points);
        faces.clone_from(&shape.faces);
    }
    let mut head = String::from("# made by a test\nmtllib none.mtl\no thing\ns 1\n");
    let mut vertices = String::new();
    for point in &points {
        let _ = write!(vertices, "v {} {} {}", point.x, point.y, point.z);
        if style.colors {
            vertices += " 0.5 1 0";
        }
        vertices += "\n";
    }
    if style.coordinates {
        vertices += &"vt 0.25 0.5 0\n".repeat(points.len());
    }
    if style.normals {
        for _ in &points {
            let _ = writeln!(vertices, "vn {} {} 1", random.unit() - 0.5, random.unit() - 0.5);
        }
    }
    let mut body = String::new();
    for (number, face) in faces.iter().enumerate() {
        if random.chance(10) {
            let _ = writeln!(body, "g part{number}\nusemtl m{}\ns {}", number % 3, number % 2);
        }
        body += "f";
        for corner in face {
            let index = |count: usize| {
                if style.negative { *corner as i64 - count as i64 } else { *corner as i64 + 1 }
            };
            if style.continued && random.chance(20) {
                body += " \\\n";
            }
            let i = index(points.len());
            body += &match (style.coordinates, style.normals) {
                (false, false) => format!(" {i}"),
                (true, false) => format!(" {i}/{i}"),
                (false, true) => format!(" {i}//{i}"),
                (true, true) => format!(" {i}/{i}/{i}"),
            };
        }
        body += "\n";
    }
    body += "l 1 2\np 1\ncstype bspline\ndeg 2\ncurv 0 1 1 2 3\nparm u 0 0 0 1 1 1\nend\n";
    head += &if style.late { body + &vertices } else { vertices + &body };
    head.replace('\n', style.line_end)
}

const SMOOTHINGS: [Smoothing; 2] = [Smoothing::None, Smoothing::Pn];

/// Edges of an odd number of triangles, keyed by the positions of their ends.
fn open_edges(mesh: &Mesh) -> usize {
    let mut sides: HashMap<[[u64; 3]; 2], usize> = HashMap::new();
    for triangle in mesh.triangles() {
        let [a, b, c] = triangle.map(|corner: Corner| {
            let position = mesh.positions()[corner.position as usize] + DVec3::ZERO;
            position.to_array().map(f64::to_bits)
        });
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *sides.entry([from.min(to), from.max(to)]).or_default() += 1;
        }
    }
    sides.into_values().filter(|count| count % 2 == 1).count()
}

#[test]
fn two_hundred_files_are_drawn() {
    let mut random = Random(16);
    let mut stage = Stage::new(UVec2::splat(64));
    for number in 0..200 {
        let mut shape = Shape::default();
        for _ in 0..1 + random.below(3) {
            let mut part = Shape::default();
            if random.chance(60) {
                part.prism(&mut random)
            } else {
                part.terrain(&mut random)
            }
            part.spoil(&mut random);
            shape.add(&part.points, &part.faces);
        }
        let turn = DMat3::from_rotation_x(random.unit()) * DMat3::from_rotation_z(random.unit());
        let scale = 10_f64.powi(random.below(13) as i32 - 6);
        let offset = if random.chance(30) { scale * 1e7 } else { 0.0 };
        for point in &mut shape.points {
            *point = turn * *point * scale + offset;
        }
        let late = random.chance(20);
        let style = Style {
            line_end: if random.chance(30) { "\r\n" } else { "\n" },
            negative: !late && random.chance(20),
            late,
            apart: random.chance(30),
            normals: random.chance(30),
            coordinates: random.chance(30),
            colors: random.chance(20),
            continued: random.chance(20),
        };
        let mut text = text_of(&shape, &style, &mut random);
        if random.chance(20) {
            text.insert(0, '\u{feff}');
        }
        let crease = if random.chance(50) { CreaseAngle::default() } else { CreaseAngle::NONE };
        let name = format!("{number}.obj");
        let mesh = Mesh::read_obj(text.as_bytes(), Path::new(&name), crease)
            .unwrap_or_else(|error| panic!("{error}"));
        let whole: usize = shape.faces.iter().map(|face| face.len() - 2).sum();
        assert!(mesh.triangles().len() <= whole && 2 * mesh.triangles().len() > whole);
        assert_eq!(mesh.colors().is_empty(), !style.colors);
        let smoothing = SMOOTHINGS[number % SMOOTHINGS.len()];
        let scene = Scene {
            surfaces: Vec::new(),
            meshes: vec![MeshModel::new(mesh.clone(), smoothing)],
            ..Scene::listing16()
        };
        let mut prepared = stage.prepared(&scene);
        let picture = stage.picture(&mut prepared, &stage.frame(&scene));
        let background = scene.settings.background.map(|value| (255.0 * value).round() as u8);
        let drawn = picture.pixels().filter(|pixel| pixel.0 != background).count();
        assert!(drawn > 100, "{name}: {drawn} pixels are drawn");
        let open = open_edges(&mesh);
        for smoothing in [Smoothing::Pn, Smoothing::Phong(Default::default())] {
            let fine = smooth(mesh.clone(), smoothing, 1).unwrap();
            assert!(fine.positions().iter().all(|point| point.is_finite()), "{name}");
            // Far from the origin, rounding makes triangles of zero area, whose edges coincide.
            if offset == 0.0 {
                assert!(open_edges(&fine) <= 3 * open, "{name}: {} of {open}", open_edges(&fine));
            }
        }
    }
}

#[test]
fn two_hundred_broken_files_get_one_line() {
    let mut random = Random(61);
    let mut refused = 0;
    for number in 0..200 {
        let mut shape = Shape::default();
        shape.prism(&mut random);
        let style = Style {
            line_end: "\n",
            negative: false,
            late: false,
            apart: false,
            normals: true,
            coordinates: true,
            colors: false,
            continued: false,
        };
        let text = text_of(&shape, &style, &mut random);
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let place = random.below(lines.len());
        lines[place] = [
            "v nan 0 0",
            "v 1 2",
            "f 1 2",
            "f 0 1 2",
            "f 1 2 999999",
            "f 1/2/3/4 2 3",
            "vn 1 inf 0",
            "vt x",
            "f -999 1 2",
            "v 1e300 0 0",
            "f a b c",
            "\u{0}\u{1}",
            "surf 0 1 0 1 x",
        ][random.below(13)]
        .to_owned();
        let name = format!("{number}.obj");
        match Mesh::read_obj(lines.join("\n").as_bytes(), Path::new(&name), CreaseAngle::default())
        {
            Ok(mesh) => assert!(!mesh.triangles().is_empty()),
            Err(error) => {
                let error = error.to_string();
                assert!(error.starts_with(&format!("{number}.obj:")), "{error}");
                assert_eq!(error.lines().count(), 1, "{error}");
                refused += 1;
            }
        }
    }
    assert!(refused > 150, "{refused}");
}
