//! Helpers for the tests of drawn meshes: the smooth surfaces over their triangles in `f64`, random views, and
//! the faults of pictures and triangles.

use std::collections::{HashMap, HashSet};

use freeform_surface::inspect::measure::Random;
use freeform_surface::inspect::{
    CurvedTriangle, DrawnVertex, HalfedgeMesh, PhongTriangle, PnTriangle,
};
use freeform_surface::{
    Alpha, Aovs, Camera, CreaseAngle, Frame, Image, Lens, Mesh, MeshModel, Scene, Smoothing,
};
use glam::{DMat4, DVec2, DVec3, DVec4, UVec2, dvec2};

use super::patches::scene_of;
use super::root;

/// Barycentric coordinates of a grid with four subdivisions per side.
pub const GRID: [[f64; 3]; 15] = {
    let (mut grid, mut at, mut i) = ([[0.0; 3]; 15], 0, 0);
    while i <= 4 {
        let mut j = 0;
        while i + j <= 4 {
            grid[at] = [i as f64 / 4.0, j as f64 / 4.0, (4 - i - j) as f64 / 4.0];
            at += 1;
            j += 1;
        }
        i += 1;
    }
    grid
};

/// A mesh of `resources/meshes`.
pub fn mesh(name: &str) -> Mesh {
    creased(name, 180.0)
}

/// The same mesh with creases where the angle between triangles is larger than this.
pub fn creased(name: &str, degrees: f64) -> Mesh {
    let path = root().join(format!("resources/meshes/{name}.obj"));
    let crease = CreaseAngle::new(degrees).unwrap();
    Mesh::load_obj(&path, crease).unwrap_or_else(|error| panic!("{error}"))
}

/// A scene of one mesh, drawn with no background.
pub fn scene_of_mesh(mesh: Mesh, smoothing: Smoothing) -> Scene {
    let meshes = vec![MeshModel::new(mesh, smoothing)];
    Scene { meshes, up: DVec3::Y, ..scene_of(Vec::new()) }
}

/// The smooth surface over a triangle of a scene, placed in the world.
pub struct Piece {
    surface: Box<dyn CurvedTriangle>,
    transform: DMat4,
    to_world: DMat4,
    /// The flat triangle.
    pub corners: [DVec3; 3],
    /// Numbers of its positions and edges, each with the number of the mesh.
    pub vertices: [(usize, u32); 3],
    pub edges: [(usize, u32); 3],
}

impl Piece {
    pub fn point(&self, [u, v, w]: [f64; 3]) -> DVec3 {
        self.transform.transform_point3(self.surface.position(u, v, w))
    }

    /// A unit vector that points outwards.
    pub fn normal(&self, [u, v, w]: [f64; 3]) -> DVec3 {
        self.to_world.transform_vector3(self.surface.normal(u, v, w)).normalize()
    }

    pub fn longest_edge(&self) -> f64 {
        let [a, b, c] = self.corners;
        a.distance(b).max(b.distance(c)).max(c.distance(a))
    }
}

/// The pieces of all meshes of a scene, in the order of their numbers.
pub fn pieces(scene: &Scene) -> Vec<Piece> {
    let of = |(number, model): (usize, &MeshModel)| {
        let (mesh, transform) = (model.mesh().clone(), model.transform);
        let smoothing = model.smoothing();
        (0..mesh.mesh().triangles().len() as u32)
            .map(|triangle| {
                let own = mesh.triangle(triangle);
                let surface: Box<dyn CurvedTriangle> = match smoothing {
                    Smoothing::None => Box::new(PhongTriangle::new(&own, Alpha::NONE)),
                    Smoothing::Pn => Box::new(PnTriangle::new(&own)),
                    Smoothing::Phong(alpha) => Box::new(PhongTriangle::new(&own, alpha)),
                };
                let halfedges = [0, 1, 2].map(|k| 3 * triangle + k);
                Piece {
                    surface,
                    transform,
                    to_world: transform.inverse().transpose(),
                    corners: own.positions.map(|point| transform.transform_point3(point)),
                    vertices: halfedges.map(|halfedge| (number, mesh.vertex(halfedge))),
                    edges: halfedges.map(|halfedge| (number, mesh.edge(halfedge))),
                }
            })
            .collect::<Vec<_>>()
    };
    scene.meshes.iter().enumerate().flat_map(of).collect()
}

/// The number of edges of a scene's meshes that have only one side.
pub fn borders(scene: &Scene) -> usize {
    let of =
        |mesh: &HalfedgeMesh| (0..mesh.halfedges()).filter(|h| mesh.twin(*h).is_none()).count();
    scene.meshes.iter().map(|model| of(model.mesh())).sum()
}

/// The barycentric weights of a vertex.
pub fn weights(vertex: &DrawnVertex) -> [f64; 3] {
    let [v, w] = vertex.uv.map(f64::from);
    [1.0 - (v + w), v, w]
}

/// The position of a random view relative to a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distance {
    Far,
    Near,
    Grazing,
    Inside,
}

/// A random camera; sizes are half the diagonal of the pieces' box.
pub fn view(pieces: &[Piece], random: &mut Random, distance: Distance) -> Camera {
    let corners = || pieces.iter().flat_map(|piece| piece.corners);
    let [low, high] = corners()
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(p), high.max(p)]);
    let (middle, size) = (low.midpoint(high), 0.5 * low.distance(high));
    let piece = &pieces[(random.between(0.0, pieces.len() as f64) as usize).min(pieces.len() - 1)];
    let (v, w) = (random.between(0.0, 0.5), random.between(0.0, 0.5));
    let place = [1.0 - v - w, v, w];
    let (point, normal) = (piece.point(place), piece.normal(place));
    let (eye, target) = match distance {
        Distance::Far => (middle + random.direction() * (size * random.between(2.8, 12.0)), middle),
        Distance::Near => {
            let away = (normal + 0.8 * random.direction()).normalize();
            (point + away * (size * random.between(0.1, 0.8)), point)
        }
        Distance::Grazing => {
            let along = normal.any_orthonormal_vector() + normal * random.between(0.01, 0.09);
            (point + along * (size * random.between(0.3, 2.0)), point)
        }
        Distance::Inside => {
            let at = [0, 1, 2].map(|axis| random.between(low[axis], high[axis]));
            (DVec3::from_array(at), point)
        }
    };
    let lens = Lens::Perspective { fov_y_radians: 0.8 };
    let up = random.direction();
    let up =
        if up.cross(target - eye).length() > 0.1 * size { up } else { up.any_orthonormal_vector() };
    Camera::new(eye, target, up, lens).unwrap()
}

/// Clip space to pixels.
pub fn pixels(clip: DVec4, size: UVec2) -> DVec2 {
    0.5 * (dvec2(clip.x, clip.y) / clip.w + 1.0) * size.as_dvec2()
}

/// World space to clip space.
pub fn to_clip(frame: &Frame) -> DMat4 {
    frame.camera.projection * frame.camera.view
}

fn clip_of(vertex: &DrawnVertex) -> DVec4 {
    DVec4::from_array(vertex.clip.map(f64::from))
}

/// The largest distance on the screen, in pixels, between a possibly visible point of a drawn triangle and the
/// corresponding point of the smooth surface. Also returns the number of such points.
pub fn off_by(pieces: &[Piece], drawn: &[DrawnVertex], frame: &Frame, size: UVec2) -> (f64, usize) {
    let to_clip = to_clip(frame);
    let (mut max, mut count) = (0.0_f64, 0);
    for corners in drawn.chunks_exact(3) {
        let piece = &pieces[corners[0].patch as usize];
        let clips = [0, 1, 2].map(|k| clip_of(&corners[k]));
        let places = [0, 1, 2].map(|k| DVec3::from_array(weights(&corners[k])));
        for by in GRID {
            let chord = clips[0] * by[0] + clips[1] * by[1] + clips[2] * by[2];
            if chord.truncate().abs().max_element() > chord.w {
                continue;
            }
            let place = places[0] * by[0] + places[1] * by[1] + places[2] * by[2];
            let truth = to_clip * piece.point(place.into()).extend(1.0);
            max = max.max(pixels(chord, size).distance(pixels(truth, size)));
            count += 1;
        }
    }
    (max, count)
}

type Bits = [u32; 4];

/// The place of a vertex in clip space to the last bit; −0 is 0.
fn bits(vertex: &DrawnVertex) -> Bits {
    vertex.clip.map(|value| (value + 0.0).to_bits())
}

/// Fails unless both sides of every edge have the same vertices, and all triangles around a position have the
/// same corner. Returns the number of levels of each edge, by triangle.
pub fn check_edges(
    name: &str,
    pieces: &[Piece],
    drawn: &[DrawnVertex],
) -> HashMap<u32, [usize; 3]> {
    let mut sides: HashMap<(u32, usize), HashSet<Bits>> = HashMap::new();
    let mut corners: HashMap<(usize, u32), Bits> = HashMap::new();
    for vertex in drawn {
        let (place, patch) = (weights(vertex), vertex.patch);
        for k in 0..3 {
            // Edge k lies opposite the corner that follows its end.
            if place[(k + 2) % 3].abs() < 1e-6 {
                sides.entry((patch, k)).or_default().insert(bits(vertex));
            }
            if place[k] > 1.0 - 1e-6 {
                let position = pieces[patch as usize].vertices[k];
                let first = *corners.entry(position).or_insert_with(|| bits(vertex));
                assert_eq!(first, bits(vertex), "{name}: corner {position:?} of {patch}");
            }
        }
    }
    let mut edges: HashMap<(usize, u32), (u32, &HashSet<Bits>)> = HashMap::new();
    for ((patch, k), vertices) in &sides {
        let edge = pieces[*patch as usize].edges[*k];
        let (other, first) = *edges.entry(edge).or_insert((*patch, vertices));
        assert_eq!(first, vertices, "{name}: the edge of triangles {other} and {patch}");
    }
    let mut levels: HashMap<u32, [usize; 3]> = HashMap::new();
    for ((patch, k), vertices) in &sides {
        levels.entry(*patch).or_default()[*k] = vertices.len() - 1;
    }
    levels
}

/// Enclosed groups of pixels that show nothing. Each pixel is connected to its eight neighbours.
pub fn holes(picture: &Image) -> Vec<Vec<(u32, u32)>> {
    let (width, height) = picture.dimensions();
    let mut seen = HashSet::new();
    let mut holes = Vec::new();
    for (x, y, _) in picture.enumerate_pixels().filter(|(_, _, pixel)| pixel.0[3] == 0) {
        let (mut group, mut open, mut shut_in) = (Vec::new(), vec![(x, y)], true);
        while let Some((x, y)) = open.pop() {
            if picture.get_pixel(x, y).0[3] != 0 || !seen.insert((x, y)) {
                continue;
            }
            group.push((x, y));
            shut_in &= x > 0 && y > 0 && x + 1 < width && y + 1 < height;
            let along = |at: u32, end: u32| at.saturating_sub(1)..=(at + 1).min(end - 1);
            open.extend(along(x, width).flat_map(|x| along(y, height).map(move |y| (x, y))));
        }
        if shut_in && !group.is_empty() {
            holes.push(group);
        }
    }
    holes
}

/// Whether one sheet of the smooth surfaces covers a pixel and the places one pixel away from it, with the same
/// side and about the same depth. At silhouettes, where sheets end, half a tolerance may open a slit.
pub fn is_covered(pieces: &[Piece], frame: &Frame, size: UVec2, (x, y): (u32, u32)) -> bool {
    const SIDE: usize = 64;
    const SAME_DEPTH: f64 = 0.05;
    let to_clip = to_clip(frame);
    let middle = dvec2(f64::from(x) + 0.5, f64::from(size.y - 1 - y) + 0.5);
    let places = [DVec2::ZERO, DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y].map(|by| middle + by);
    // The depth and the side of everything that covers each place.
    let mut covering: [Vec<(f64, bool)>; 5] = Default::default();
    let at = |piece: &Piece, i: usize, j: usize| {
        let place = [i, j, SIDE - i - j].map(|k| k as f64 / SIDE as f64);
        to_clip * piece.point(place).extend(1.0)
    };
    // Pieces are skipped if their box on the screen, enlarged by its own size, does not contain the pixel.
    let is_near = |piece: &&Piece| {
        let places = GRID.map(|place| to_clip * piece.point(place).extend(1.0));
        if places.iter().any(|clip| clip.w <= 0.0) {
            return true;
        }
        let places = places.map(|clip| pixels(clip, size));
        let low = places.into_iter().reduce(DVec2::min).unwrap_or_default();
        let high = places.into_iter().reduce(DVec2::max).unwrap_or_default();
        let grown = high - low + 2.0;
        middle.cmpge(low - grown).all() && middle.cmple(high + grown).all()
    };
    for piece in pieces.iter().filter(is_near) {
        for (i, j) in (0..SIDE).flat_map(|i| (0..SIDE - i).map(move |j| (i, j))) {
            let first = [at(piece, i, j), at(piece, i + 1, j), at(piece, i, j + 1)];
            let second = (i + j + 2 <= SIDE)
                .then(|| [at(piece, i + 1, j + 1), at(piece, i, j + 1), at(piece, i + 1, j)]);
            for triangle in [Some(first), second].into_iter().flatten() {
                // Triangles that extend in front of the near plane are skipped, because they are clipped there.
                if triangle.iter().any(|clip| clip.w <= 0.0 || clip.z < -clip.w) {
                    continue;
                }
                let [a, b, c] = triangle.map(|clip| pixels(clip, size));
                for (place, covering) in places.iter().zip(&mut covering) {
                    let side = |a: DVec2, b: DVec2| (b - a).perp_dot(*place - a);
                    let sides = [side(a, b), side(b, c), side(c, a)];
                    if sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0) {
                        covering.push((triangle[0].w, sides.iter().sum::<f64>() > 0.0));
                    }
                }
            }
        }
    }
    let [middle, around @ ..] = covering;
    middle.iter().any(|(depth, side)| {
        let same = |(other, of): &(f64, bool)| {
            of == side && (other - depth).abs() < SAME_DEPTH * depth.max(*other)
        };
        around.iter().all(|covering| covering.iter().any(same))
    })
}

/// Pixels that show the inside of closed meshes to an eye outside of them, as a crack would.
pub fn insides(aovs: &Aovs, frame: &Frame) -> usize {
    // The normals of smooth meshes differ a little from those of the triangles.
    const TURNED: f64 = -0.5;
    let eye = frame.camera.view.inverse().w_axis.truncate();
    let vector = |[x, y, z, _]: &[f32; 4]| DVec3::from_array([*x, *y, *z].map(f64::from));
    let towards = |normal: &[f32; 4], position: &[f32; 4]| {
        vector(normal).dot((eye - vector(position)).normalize())
    };
    let pixels = aovs.normal.iter().zip(&aovs.position).filter(|(normal, _)| normal[3] != 0.0);
    pixels.filter(|(normal, position)| towards(normal, position) < TURNED).count()
}

/// Pixels that show nothing although the surface is there, in small enclosed groups.
pub fn cracks(picture: &Image, pieces: &[Piece], frame: &Frame, size: UVec2) -> usize {
    const SMALL: usize = 8;
    holes(picture)
        .into_iter()
        .filter(|hole| hole.len() <= SMALL)
        .flatten()
        .filter(|pixel| is_covered(pieces, frame, size, *pixel))
        .count()
}
