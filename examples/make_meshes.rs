//! Makes the meshes of `resources/meshes`: shapes for smoothing, and the hard cases of smoothing.
//!
//! `cargo run --release --example make_meshes` writes them.

use std::f64::consts::TAU;

use glam::{DVec3, dvec3};

/// A mesh in the form of an OBJ file; faces are corners of position, texture coordinate and normal, counted
/// from 0.
#[derive(Default)]
struct Obj {
    /// A description of the mesh.
    about: &'static str,
    positions: Vec<DVec3>,
    coordinates: Vec<[f64; 2]>,
    normals: Vec<DVec3>,
    faces: Vec<Vec<[Option<usize>; 3]>>,
}

impl Obj {
    fn text(&self) -> String {
        let mut text = format!("# {}\n# Made by examples/make_meshes.rs.\n", self.about);
        // Adding zero turns −0 into 0.
        let numbers = |values: &[f64]| -> String {
            values.iter().map(|value| format!(" {}", value + 0.0)).collect()
        };
        text.extend(self.positions.iter().map(|p| format!("v{}\n", numbers(&p.to_array()))));
        text.extend(self.coordinates.iter().map(|c| format!("vt{}\n", numbers(c))));
        text.extend(self.normals.iter().map(|n| format!("vn{}\n", numbers(&n.to_array()))));
        for face in &self.faces {
            text += "f";
            for indices in face {
                let [p, c, n] = indices.map(|i| i.map_or(String::new(), |i| (i + 1).to_string()));
                let corner = format!(" {p}/{c}/{n}");
                text += corner.trim_end_matches('/');
            }
            text += "\n";
        }
        text
    }

    /// The same faces, with a normal for each position.
    fn with_normals(mut self, normals: Vec<DVec3>) -> Self {
        self.normals = normals;
        for [position, _, normal] in self.faces.iter_mut().flatten() {
            *normal = *position;
        }
        self
    }

    fn add_face(&mut self, positions: &[usize]) {
        self.faces.push(positions.iter().map(|i| [Some(*i), None, None]).collect());
    }

    /// Adds a vertex near the middle of the first face's first edge to the neighbouring face. The gap that this
    /// opens between the two faces becomes a triangle of its own.
    fn with_sliver(mut self, moved: DVec3) -> Self {
        let [a, b] = [0, 1].map(|k| self.faces[0][k][0].expect("a position"));
        let middle = self.positions.len();
        self.positions.push(self.positions[a].midpoint(self.positions[b]) + moved);
        let runs = |face: &[[Option<usize>; 3]]| {
            (0..3).find(|k| face[*k][0] == Some(b) && face[(*k + 1) % 3][0] == Some(a))
        };
        let (face, k) = (0..self.faces.len())
            .find_map(|i| runs(&self.faces[i]).map(|k| (i, k)))
            .expect("the mesh is closed");
        let far = self.faces[face][(k + 2) % 3][0].expect("a position");
        self.faces.remove(face);
        self.add_face(&[b, middle, far]);
        self.add_face(&[middle, a, far]);
        self.add_face(&[b, a, middle]);
        self
    }
}

fn icosahedron(about: &'static str) -> Obj {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let point = |x: f64, y: f64, z: f64| dvec3(x, y, z).normalize();
    let rectangle = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)];
    let mut positions: Vec<DVec3> = rectangle.iter().map(|(a, b)| point(*a, *b, 0.0)).collect();
    positions.extend(rectangle.map(|(a, b)| point(0.0, a, b)));
    positions.extend(rectangle.map(|(a, b)| point(b, 0.0, a)));
    let near = |a: usize, b: usize| positions[a].distance(positions[b]) < 1.1;
    let mut obj = Obj { about, ..Obj::default() };
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if near(a, b) && near(b, c) && near(c, a) {
                    let [p, q, r] = [a, b, c].map(|i| positions[i]);
                    let outward = (q - p).cross(r - p).dot(p) > 0.0;
                    obj.add_face(&if outward { [a, b, c] } else { [a, c, b] });
                }
            }
        }
    }
    obj.positions = positions;
    obj
}

/// The icosahedron with the normals of its sphere.
fn round(about: &'static str) -> Obj {
    let obj = icosahedron(about);
    let normals = obj.positions.clone();
    obj.with_normals(normals)
}

fn cube(about: &'static str) -> Obj {
    let mut obj = Obj { about, ..Obj::default() };
    let sign = |i: usize, bit: usize| if i & bit == 0 { -1.0 } else { 1.0 };
    obj.positions = (0..8).map(|i| dvec3(sign(i, 1), sign(i, 2), sign(i, 4))).collect();
    for face in [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    {
        obj.add_face(&face);
    }
    obj
}

/// Each face has its own normals, so every edge is a crease.
fn creased_cube(about: &'static str) -> Obj {
    let mut obj = cube(about);
    obj.normals = vec![-DVec3::Z, DVec3::Z, -DVec3::Y, DVec3::Y, -DVec3::X, DVec3::X];
    for (number, face) in obj.faces.iter_mut().enumerate() {
        face.iter_mut().for_each(|corner| corner[2] = Some(number));
    }
    obj
}

fn torus() -> Obj {
    const AROUND: usize = 16;
    const ACROSS: usize = 8;
    let mut obj =
        Obj { about: "A torus with its normals and texture coordinates.", ..Obj::default() };
    let angle = |i: usize, count: usize| (TAU * i as f64 / count as f64).sin_cos();
    for i in 0..AROUND {
        for j in 0..ACROSS {
            let ((sin_a, cos_a), (sin_b, cos_b)) = (angle(i, AROUND), angle(j, ACROSS));
            let normal = dvec3(cos_b * cos_a, sin_b, cos_b * sin_a);
            obj.normals.push(normal);
            obj.positions.push(dvec3(cos_a, 0.0, sin_a) + normal * 0.4);
        }
    }
    // The texture's seams need columns and rows of their own.
    let side = ACROSS + 1;
    for i in 0..=AROUND {
        obj.coordinates
            .extend((0..side).map(|j| [i as f64 / AROUND as f64, j as f64 / ACROSS as f64]));
    }
    for i in 0..AROUND {
        for j in 0..ACROSS {
            let corner = |i: usize, j: usize| {
                let vertex = Some(i % AROUND * ACROSS + j % ACROSS);
                [vertex, Some(i * side + j), vertex]
            };
            obj.faces.push(vec![
                corner(i, j),
                corner(i, j + 1),
                corner(i + 1, j + 1),
                corner(i + 1, j),
            ]);
        }
    }
    obj
}

fn grid() -> Obj {
    const SIDE: usize = 6;
    let about =
        "A sheet of quads with a bump, and texture coordinates; normals are left to the reader.";
    let mut obj = Obj { about, ..Obj::default() };
    for i in 0..=SIDE {
        for j in 0..=SIDE {
            let (x, z) = (j as f64 * 2.0 / SIDE as f64 - 1.0, 1.0 - i as f64 * 2.0 / SIDE as f64);
            let height = 0.6 * (-4.0 * (x * x + z * z)).exp();
            obj.positions.push(dvec3(x, height, z));
            obj.coordinates.push([j as f64 / SIDE as f64, i as f64 / SIDE as f64]);
        }
    }
    for i in 0..SIDE {
        for j in 0..SIDE {
            let corner = |i: usize, j: usize| {
                let vertex = Some(i * (SIDE + 1) + j);
                [vertex, vertex, None]
            };
            obj.faces.push(vec![
                corner(i, j),
                corner(i, j + 1),
                corner(i + 1, j + 1),
                corner(i + 1, j),
            ]);
        }
    }
    obj
}

/// A pawn: a profile of radii and heights turned around the y axis.
fn figure() -> Obj {
    const AROUND: usize = 10;
    const PROFILE: [(f64, f64); 13] = [
        (0.60, 0.00),
        (0.62, 0.12),
        (0.50, 0.24),
        (0.44, 0.34),
        (0.28, 0.50),
        (0.20, 0.85),
        (0.19, 1.05),
        (0.34, 1.12),
        (0.34, 1.18),
        (0.20, 1.24),
        (0.32, 1.45),
        (0.29, 1.65),
        (0.16, 1.80),
    ];
    let mut obj = Obj { about: "A pawn; normals are left to the reader.", ..Obj::default() };
    for (radius, height) in PROFILE {
        for i in 0..AROUND {
            let (sin, cos) = (TAU * i as f64 / AROUND as f64).sin_cos();
            obj.positions.push(dvec3(radius * cos, height, radius * sin));
        }
    }
    let rings = PROFILE.len();
    let [bottom, top] = [0, 1].map(|i| rings * AROUND + i);
    obj.positions.extend([DVec3::ZERO, DVec3::Y * 1.86]);
    for i in 0..AROUND {
        let next = (i + 1) % AROUND;
        for ring in 0..rings - 1 {
            let (low, high) = (ring * AROUND, (ring + 1) * AROUND);
            obj.add_face(&[low + i, high + i, high + next, low + next]);
        }
        obj.add_face(&[bottom, i, next]);
        let last = (rings - 1) * AROUND;
        obj.add_face(&[top, last + next, last + i]);
    }
    obj
}

/// Every face has its own corners; one face is degenerate, a line between two places.
fn coincident() -> Obj {
    let about = "An icosahedron whose faces share no vertex: all are there several times. Two corners of\n\
                 # the last face are in one place, so that it has no third edge.";
    let whole = round(about);
    let mut obj = Obj { about, ..Obj::default() };
    let mut add = |corners: &[usize]| {
        let first = obj.positions.len();
        obj.positions.extend(corners.iter().map(|i| whole.positions[*i]));
        obj.normals.extend(corners.iter().map(|i| whole.normals[*i]));
        obj.faces.push((first..first + corners.len()).map(|i| [Some(i), None, Some(i)]).collect());
    };
    for face in &whole.faces {
        let corners: Vec<usize> = face.iter().filter_map(|corner| corner[0]).collect();
        add(&corners);
    }
    add(&[0, 1, 1]);
    obj
}

fn opposite() -> Obj {
    let mut obj = round(
        "Normals that point the other way: at one vertex from face to face, so that their sum is zero\n\
         # along edges; at another in all faces, so that they are against those of its neighbours.",
    );
    let flipped = obj.normals.len();
    obj.normals.push(-obj.normals[0]);
    obj.normals[3] = -obj.normals[3];
    let around = obj.faces.iter_mut().flatten().filter(|corner| corner[0] == Some(0));
    for (number, corner) in around.enumerate() {
        if number % 2 == 1 {
            corner[2] = Some(flipped);
        }
    }
    obj
}

fn hard() -> [(&'static str, Obj); 10] {
    let sphere = |mut obj: Obj| {
        let normals = obj.positions.iter().map(|p| p.normalize()).collect();
        obj.normals.clear();
        obj.with_normals(normals)
    };
    let mut zero = round("The normal of one vertex is zero: edges are straight there.");
    zero.normals[0] = DVec3::ZERO;
    let mut right =
        round("The normal of one vertex is at right angles to the sphere's, in the faces.");
    right.normals[0] = right.positions[0].any_orthonormal_vector();
    let mut boundary = round("Part of an icosahedron: a surface with a border.");
    boundary.faces.truncate(11);
    let mut offset =
        round("An icosahedron with edges of 1e-3 at a million, where f32 has steps of 1/16.");
    for position in &mut offset.positions {
        *position = *position * 1e-3 + DVec3::splat(1e6);
    }
    let mut lengths = round("Normals of lengths from 1e-200 to 1e200.");
    for (i, normal) in lengths.normals.iter_mut().enumerate() {
        *normal *= [1e-200, 1e-3, 0.5, 1e3, 7.0, 1e200][i % 6];
    }
    let zero_area =
        icosahedron("One triangle has no area: its third corner is the middle of an edge.");
    let needle = icosahedron("One triangle is a needle: an edge of 1 and a height of 1e-6.");
    let [a, b] = [0, 1].map(|k| needle.faces[0][k][0].expect("a position"));
    let outward = needle.positions[a] + needle.positions[b];
    [
        ("zero-area", sphere(zero_area.with_sliver(DVec3::ZERO))),
        ("needle", sphere(needle.with_sliver(outward.normalize() * 1e-6))),
        ("coincident", coincident()),
        ("zero-normal", zero),
        ("opposite-normals", opposite()),
        ("right-angle-normal", right),
        ("boundary", boundary),
        (
            "crease",
            creased_cube("A cube with normals of its own on each face: every edge is a crease."),
        ),
        ("offset-1e6", offset),
        ("normal-lengths", lengths),
    ]
}

fn main() -> std::io::Result<()> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/meshes");
    std::fs::create_dir_all(format!("{folder}/hard"))?;
    for (name, obj) in [
        ("icosahedron", round("An icosahedron with the normals of its sphere.")),
        ("cube", cube("A cube of quads; normals are left to the reader.")),
        ("torus", torus()),
        ("grid", grid()),
        ("figure", figure()),
    ] {
        std::fs::write(format!("{folder}/{name}.obj"), obj.text())?;
    }
    for (name, obj) in hard() {
        std::fs::write(format!("{folder}/hard/{name}.obj"), obj.text())?;
    }
    Ok(())
}
