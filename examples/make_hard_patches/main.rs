//! Makes the stability scenes of tessellation whose control points are computed: the same bump at
//! several sizes and places, surfaces of revolution, sheets of patches that share edges, and NURBS surfaces.
//!
//! `cargo run --release --example make_hard_patches` writes them to `resources/scenes/stability`.

mod nurbs;

use glam::{DVec2, DVec3, DVec4, Vec3Swizzles, dvec2, dvec3};

const ORANGE: [f64; 3] = [0.9, 0.6, 0.2];
const BLUE: [f64; 3] = [0.3, 0.6, 0.9];
/// Where both lights shine from the same side.
const DARK_ORANGE: [f64; 3] = [0.45, 0.3, 0.1];
const DARK_BLUE: [f64; 3] = [0.15, 0.3, 0.45];

fn main() -> std::io::Result<()> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/scenes/stability");
    for scene in [
        pole(),
        rational_sphere(),
        offset(),
        small(),
        large(),
        far(),
        orthographic(),
        quartic(),
        shared_edges(),
        degree_15(),
        saddle(),
        cylinder_and_cone(),
        torus(),
        mixed_degrees(),
        raised_edges(),
        weights_along_an_edge(),
        many_degrees(),
    ] {
        std::fs::write(format!("{folder}/tess-{}.toml", scene.name), scene.text())?;
    }
    for scene in nurbs::scenes() {
        std::fs::write(format!("{folder}/nurbs-{}.toml", scene.name), scene.text())?;
    }
    Ok(())
}

struct Scene {
    name: &'static str,
    /// A description of the difficulty.
    about: &'static str,
    camera: &'static str,
    patches: Vec<Patch>,
}

/// One `[[surface]]`.
struct Patch {
    /// Along u and v, if it is not that of 4×4 or 5×5 points.
    degree: Option<[usize; 2]>,
    /// Of a NURBS surface.
    knots: Option<[Vec<f64>; 2]>,
    points: Vec<DVec4>,
    color: [f64; 3],
    translate: Option<DVec3>,
    /// More lines of its table, and its trims.
    more: &'static str,
}

impl Scene {
    fn text(&self) -> String {
        let Self { about, camera, .. } = self;
        let mut text =
            format!("# {about}\n# Made by examples/make_hard_patches.\n\n[camera]\n{camera}\n");
        for Patch { degree, knots, points, color, translate, more } in &self.patches {
            let columns = match (degree, knots) {
                (Some([u, _]), Some([knots, _])) => knots.len() - u - 1,
                (Some([u, _]), None) => u + 1,
                (None, _) => points.len().isqrt(),
            };
            let rows = points.chunks(columns).map(|row| {
                let row: Vec<String> = row.iter().copied().map(list).collect();
                format!("    {},\n", row.join(", "))
            });
            text += "\n[[surface]]\n";
            if let Some(degree) = degree {
                text += &format!("degree = {degree:?}\n");
            }
            if let Some([u, v]) = knots {
                text += &format!("knots = [{u:?}, {v:?}]\n");
            }
            text += "control_points = [\n";
            text.extend(rows);
            text += &format!("]\ncolor = {color:?}\n");
            if let Some(translate) = translate {
                text += &format!("translate = {}\n", list(translate.extend(1.0)));
            }
            text += more;
        }
        text
    }
}

impl Patch {
    fn new(points: Vec<DVec3>, color: [f64; 3]) -> Self {
        let points = points.into_iter().map(|point| point.extend(1.0)).collect();
        Self { degree: None, knots: None, points, color, translate: None, more: "" }
    }

    fn weighted(points: Vec<DVec4>, color: [f64; 3]) -> Self {
        Self { points, ..Self::new(Vec::new(), color) }
    }

    fn of_degree(degree: [usize; 2], points: Vec<DVec4>, color: [f64; 3]) -> Self {
        Self { degree: Some(degree), ..Self::weighted(points, color) }
    }
}

/// A control point, with its weight if it has one.
fn list(point: DVec4) -> String {
    // Adding zero turns −0 into 0.
    let numbers = point.to_array().map(|value| value + 0.0);
    format!("{:?}", if point.w == 1.0 { &numbers[..3] } else { &numbers })
}

/// A bump of size 1, in tenths: u along x, v along −z.
fn bump() -> Vec<DVec3> {
    const PLACES: [f64; 4] = [-5.0, -2.0, 2.0, 5.0];
    const HEIGHTS: [[f64; 4]; 4] =
        [[0.0, 0.0, 0.0, 0.0], [0.0, 9.0, 6.0, 0.0], [0.0, 6.0, 9.0, 0.0], [0.0, 0.0, 0.0, 0.0]];
    let point = |i: usize| dvec3(PLACES[i % 4], HEIGHTS[i / 4][i % 4], -PLACES[i / 4]);
    (0..16).map(point).collect()
}

fn offset() -> Scene {
    let place = DVec3::splat(1e6);
    let points = bump().into_iter().map(|point| place + point / 10.0).collect();
    let moved = bump().into_iter().map(|point| point / 10.0).collect();
    Scene {
        name: "offset-1e6",
        about: "Bumps of size 1 at a million: f32 has steps of 1/16 there. The first has it in its\n\
                # control points, the second in translate.",
        camera: "eye = [1000001.2, 1000001.1, 1000001.7]\n\
                 target = [1000000.6, 1000000.1, 1000000.0]",
        patches: vec![
            Patch::new(points, DARK_ORANGE),
            Patch { translate: Some(place + dvec3(1.2, 0.0, 0.0)), ..Patch::new(moved, DARK_BLUE) },
        ],
    }
}

fn small() -> Scene {
    let points = bump().into_iter().map(|point| point / 1e7).collect();
    Scene {
        name: "size-1e-6",
        about: "A bump of size 1e-6: no bound may be absolute.",
        camera: "eye = [6e-7, 1e-6, 1.5e-6]\ntarget = [0.0, 1e-7, 0.0]",
        patches: vec![Patch::new(points, ORANGE)],
    }
}

fn large() -> Scene {
    let points = bump().into_iter().map(|point| point * 1e5).collect();
    // The lights stand at the origin, and Sv × Su points down.
    let translate = Some(dvec3(0.0, 1e6, 0.0));
    Scene {
        name: "size-1e6",
        about: "A bump of size 1e6: no bound may be absolute.",
        camera: "eye = [6e5, 2e6, 1.5e6]\ntarget = [0.0, 1.1e6, 0.0]",
        patches: vec![Patch { translate, ..Patch::new(points, DARK_ORANGE) }],
    }
}

fn far() -> Scene {
    let points = bump().into_iter().map(|point| point / 10.0).collect();
    Scene {
        name: "far",
        about: "A bump of size 1 from 1e5 away, smaller than a pixel: the least level will do.",
        camera: "eye = [0.0, 5e4, 8.66e4]\ntarget = [0.0, 0.0, 0.0]",
        patches: vec![Patch::new(points, ORANGE)],
    }
}

/// The points of a plane curve, turned about the origin by a number of quarter turns.
fn turned(curve: [DVec2; 4], quarters: usize) -> [DVec2; 4] {
    curve.map(|point| (0..quarters).fold(point, |point, _| point.perp()))
}

fn pole() -> Scene {
    // The knob of the teapot's lid, twice as large: its rows 0 and 2 are points.
    let profile = [dvec2(0.0, 0.9), dvec2(1.6, 0.9), dvec2(0.0, 0.0), dvec2(0.4, 0.0)];
    let circle = [dvec2(1.0, 0.0), dvec2(1.0, 0.56), dvec2(0.56, 1.0), dvec2(0.0, 1.0)];
    let patch = |quarters: usize| {
        let around = turned(circle, quarters);
        let revolved = profile.iter().flat_map(|p| {
            around.map(|a| dvec3(p.x * a.x, p.y, p.x * a.y).map(|x| (x * 1e4).round() / 1e4))
        });
        Patch::new(revolved.collect(), [ORANGE, BLUE][quarters % 2])
    };
    Scene {
        name: "pole",
        about: "Four patches around a pole, as in the knob of the teapot's lid: rows 0 and 2 of the\n\
                # control points are one point each, and all four patches meet in the first.",
        camera: "eye = [0.7, 1.9, 1.5]\ntarget = [0.0, 0.45, 0.0]",
        patches: (0..4).map(patch).collect(),
    }
}

fn rational_sphere() -> Scene {
    // (1 − t², 2t) / (1 + t²), a quarter of a circle, in degree 3.
    let quarter = [dvec2(1.0, 0.0), dvec2(1.0, 2.0 / 3.0), dvec2(0.5, 1.0), dvec2(0.0, 1.0)];
    let weights = [3.0, 3.0, 4.0, 6.0];
    let patch = |number: usize| {
        let around = turned(quarter, number % 4);
        let half = if number < 4 { 1.0 } else { -1.0 };
        let points = (0..16).map(|i| {
            let [radius, height] = quarter[i / 4].to_array();
            let place = (around[i % 4] * radius).extend(half * height).xzy();
            place.extend(weights[i / 4] * weights[i % 4])
        });
        let color = [ORANGE, BLUE][(number + number / 4) % 2];
        Patch::weighted(points.collect(), color)
    };
    Scene {
        name: "rational-sphere",
        about: "A sphere of eight rational patches: every point has to lie at 1 from the origin, and the\n\
                # rows at the poles are one point each, of different weights. Where neighbours meet, one\n\
                # has twice the other's weights.",
        camera: "eye = [1.0, 1.6, 2.6]\ntarget = [0.0, 0.0, 0.0]",
        patches: (0..8).map(patch).collect(),
    }
}

/// Control points of a patch of a sheet; neighbours in the sheet share an edge.
///
/// The sheet has points 0.2 apart. `place` is the patch's column and row.
fn of_sheet(place: [usize; 2], side: usize, heights: impl Fn(f64, f64) -> f64) -> Vec<DVec3> {
    let at = |i: usize| {
        let x = (place[0] * (side - 1) + i % side) as f64;
        let z = (place[1] * (side - 1) + i / side) as f64;
        dvec3(2.0 * x, heights(x, z).round(), -2.0 * z) / 10.0
    };
    (0..side * side).map(at).collect()
}

fn checkered(place: [usize; 2]) -> [f64; 3] {
    [ORANGE, BLUE][(place[0] + place[1]) % 2]
}

fn orthographic() -> Scene {
    let patch = |place| {
        let points = of_sheet(place, 4, |x, z| 6.0 * (1.3 * x).sin() * (1.1 * z).cos());
        Patch::new(points, checkered(place))
    };
    Scene {
        name: "orthographic",
        about: "Parallel projection: w is 1 everywhere, and the same size is asked for at every depth.",
        camera: "eye = [2.6, 3.0, 3.0]\ntarget = [0.6, 0.0, -0.6]\northographic_height = 1.6",
        patches: [[0, 0], [1, 0], [0, 1], [1, 1]].map(patch).into(),
    }
}

fn quartic() -> Scene {
    let patch = |place| {
        let points = of_sheet(place, 5, |x, z| 4.0 * (1.6 * x + 0.5).sin() + 3.0 * (1.5 * z).cos());
        Patch::new(points, checkered(place))
    };
    Scene {
        name: "quartic",
        about: "Two patches of degree 4 that share an edge.",
        camera: "eye = [1.3, 1.5, 1.2]\ntarget = [0.8, 0.0, -0.4]",
        patches: [[0, 0], [1, 0]].map(patch).into(),
    }
}

fn shared_edges() -> Scene {
    let patch = |number: usize| {
        let place = [number % 3, number / 3];
        let points = of_sheet(place, 4, |x, z| 6.0 * (1.2 * x).sin() * (1.7 * z).cos());
        // Mirrored, and with u and v exchanged, in all eight ways.
        let turned = (0..16).map(|i| {
            let [mut column, mut row] = [i % 4, i / 4];
            if number & 4 != 0 {
                std::mem::swap(&mut column, &mut row);
            }
            if number & 1 != 0 {
                column = 3 - column;
            }
            if number & 2 != 0 {
                row = 3 - row;
            }
            points[4 * row + column]
        });
        Patch::new(turned.collect(), checkered(place))
    };
    Scene {
        name: "shared-edges",
        about: "3×3 patches in all eight orientations: neighbours run through their shared edges in\n\
                # opposite directions, or one along u and the other along v. No crack may show.",
        camera: "eye = [1.5, 1.7, 1.2]\ntarget = [0.95, 0.0, -0.75]",
        patches: (0..9).map(patch).collect(),
    }
}

/// A net over the square from (0, 0) to (1, −1), with heights by column and row.
fn net(degree: [usize; 2], height: impl Fn(usize, usize) -> f64) -> Vec<DVec4> {
    let columns = degree[0] + 1;
    (0..columns * (degree[1] + 1))
        .map(|i| {
            let (column, row) = (i % columns, i / columns);
            let (x, z) = (column as f64 / degree[0] as f64, -(row as f64) / degree[1] as f64);
            let height = (100.0 * height(column, row)).round() / 100.0;
            dvec3(x, height, z).extend(1.0)
        })
        .collect()
}

fn degree_15() -> Scene {
    let waves = net([15, 15], |x, z| 0.9 * (1.7 * x as f64).sin() * (1.3 * z as f64 + 0.4).cos());
    let rib = net([15, 1], |x, _| if x % 2 == 0 { 0.6 } else { -0.6 });
    let rib = rib.iter().map(|p| *p + dvec3(1.2, 0.0, 0.0).extend(0.0)).collect();
    Scene {
        name: "degree-15",
        about: "The largest degree: 256 control points that rise and fall, and a ruled surface of it.",
        camera: "eye = [1.9, 1.6, 1.6]\ntarget = [1.0, 0.0, -0.5]",
        patches: vec![
            Patch::of_degree([15, 15], waves, ORANGE),
            Patch::of_degree([15, 1], rib, BLUE),
        ],
    }
}

fn saddle() -> Scene {
    let saddle = net([1, 1], |x, z| if x == z { 0.5 } else { -0.5 });
    Scene {
        name: "bilinear-saddle",
        about: "The smallest degree: straight edges, and only the mixed derivative bends the surface.",
        camera: "eye = [1.4, 1.1, 0.9]\ntarget = [0.5, 0.0, -0.5]",
        patches: vec![Patch::of_degree([1, 1], saddle, ORANGE)],
    }
}

/// A quarter of the unit circle as a rational curve of degree 2: places and weights.
const ARC: [(DVec2, f64); 3] = [
    (dvec2(1.0, 0.0), 1.0),
    (dvec2(1.0, 1.0), std::f64::consts::FRAC_1_SQRT_2),
    (dvec2(0.0, 1.0), 1.0),
];

/// A quarter of the unit circle, rotated.
fn arc(quarters: usize) -> [(DVec2, f64); 3] {
    let [cosine, sine] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][quarters];
    ARC.map(|(place, weight)| (DVec2::new(cosine, sine).rotate(place), weight))
}

fn cylinder_and_cone() -> Scene {
    let tube = |quarter: usize, top: f64, x: f64| {
        let points = [(1.0, 0.0), (top, 1.2)].into_iter().flat_map(|(radius, height)| {
            arc(quarter).map(|(place, weight)| {
                let place = 0.5 * radius * place;
                dvec3(x + place.x, height, place.y).extend(weight)
            })
        });
        Patch::of_degree([2, 1], points.collect(), [ORANGE, BLUE][quarter % 2])
    };
    let patches = (0..4).map(|quarter| tube(quarter, 1.0, 1.0));
    Scene {
        name: "cylinder-and-cone",
        about: "A whole cylinder and a cone with an apex, of rational patches of degrees 2 and 1: along v\n\
                # nothing bends.",
        camera: "eye = [2.6, 1.9, 2.6]\ntarget = [1.6, 0.5, 0.0]",
        patches: patches.chain((0..4).map(|quarter| tube(quarter, 0.0, 2.3))).collect(),
    }
}

fn torus() -> Scene {
    let patch = |number: usize| {
        let (around, along) = (arc(number % 4), arc(number / 4));
        let points = along.into_iter().flat_map(|(circle, weight)| {
            let (radius, height) = (1.0 + 0.4 * circle.x, 0.4 * circle.y);
            around.map(|(place, other)| {
                dvec3(radius * place.x, height, radius * place.y).extend(weight * other)
            })
        });
        Patch::of_degree([2, 2], points.collect(), checkered([number % 4, number / 4]))
    };
    Scene {
        name: "torus",
        about: "A torus of 16 rational patches of degree 2.",
        camera: "eye = [1.4, 1.9, 2.2]\ntarget = [0.0, 0.0, 0.0]",
        patches: (0..16).map(patch).collect(),
    }
}

fn mixed_degrees() -> Scene {
    let heights = |x: usize, z: usize| 0.3 * (2.1 * x as f64).sin() + [0.2, -0.4, 0.5, -0.1][z];
    let middle = net([3, 3], heights);
    let moved = |x: f64| dvec3(x, 0.0, 0.0).extend(0.0);
    // A neighbour has the degree of the common edge along it, and any degree across it.
    let neighbour = |across: usize, right: bool| {
        let mut points = net([across, 3], |x, z| heights(x + 3, z) + 0.1);
        for row in 0..4 {
            let (own, common) = if right { (0, 3) } else { (across, 0) };
            let shift = moved(if right { -1.0 } else { 1.0 });
            points[row * (across + 1) + own] = middle[row * 4 + common] + shift;
        }
        let shift = moved(if right { 1.0 } else { -1.0 });
        points.into_iter().map(|point| point + shift).collect::<Vec<_>>()
    };
    Scene {
        name: "mixed-degrees",
        about: "Patches of degrees 7, 3 and 1 along u whose edges are the same cubic curves. No crack may\n\
                # show.",
        camera: "eye = [1.4, 2.0, 1.5]\ntarget = [0.5, 0.0, -0.5]",
        patches: vec![
            Patch::of_degree([7, 3], neighbour(7, false), BLUE),
            Patch::of_degree([3, 3], middle.clone(), ORANGE),
            Patch::of_degree([1, 3], neighbour(1, true), BLUE),
        ],
    }
}

/// A curve with one more control point.
fn raised(points: &[DVec4]) -> Vec<DVec4> {
    let n = points.len() as f64;
    let homogeneous = |point: DVec4| (point.truncate() * point.w).extend(point.w);
    let inner = (1..points.len()).map(|i| {
        let share = i as f64 / n;
        let sum = homogeneous(points[i - 1]) * share + homogeneous(points[i]) * (1.0 - share);
        (sum.truncate() / sum.w).extend(sum.w)
    });
    let ends = [points[0], points[points.len() - 1]];
    std::iter::once(ends[0]).chain(inner).chain(std::iter::once(ends[1])).collect()
}

fn raised_edges() -> Scene {
    let mut middle = net([2, 2], |x, z| [0.3, -0.1, 0.4][x] * [0.5, 1.0, -0.6][z]);
    middle[5].w = 2.5;
    let moved = |points: Vec<DVec4>, by: DVec3| points.into_iter().map(move |p| p + by.extend(0.0));
    // The middle's last column, raised to degree 3, in a patch whose u runs the other way.
    let edge = raised(&[middle[2], middle[5], middle[8]]);
    let right = net([3, 3], |x, z| [0.1, 0.3, -0.2, 0.0][x] + [0.0, 0.2, 0.1, 0.3][z]);
    let mut right: Vec<DVec4> =
        (0..16).map(|i| right[i / 4 * 4 + 3 - i % 4] + DVec3::X.extend(0.0)).collect();
    (0..4).for_each(|row| right[4 * row + 3] = edge[row]);
    // Its first row, raised to degree 4.
    let edge = raised(&raised(&middle[..3]));
    let front = net([4, 1], |x, _| [0.3, 0.1, 0.0, 0.2, 0.4][x]);
    let mut front: Vec<DVec4> = moved(front, DVec3::Z).collect();
    front[5..].copy_from_slice(&edge);
    // Equal edges: this patch has to follow the middle.
    let mut left: Vec<DVec4> =
        moved(net([1, 2], |x, z| 0.2 * (x + z) as f64), DVec3::NEG_X).collect();
    (0..3).for_each(|row| left[2 * row + 1] = middle[3 * row]);
    Scene {
        name: "raised-edges",
        about: "Edges that are the same curve, but of another degree on each side: the middle patch has degree 2, its\n\
                # neighbours 3 and 4. No crack may show.",
        camera: "eye = [1.9, 2.3, 2.6]\ntarget = [0.5, 0.0, 0.0]",
        patches: vec![
            Patch::of_degree([2, 2], middle, ORANGE),
            Patch::of_degree([3, 3], right, BLUE),
            Patch::of_degree([4, 1], front, BLUE),
            Patch::of_degree([1, 2], left, BLUE),
        ],
    }
}

fn weights_along_an_edge() -> Scene {
    let weights = [1e-3, 0.03, 1.0, 30.0, 1e3];
    let mut near = net([3, 4], |x, z| 0.3 * ((x + 2 * z) as f64).sin());
    let mut far = net([2, 4], |x, z| 0.4 * ((2 * x + z) as f64).cos());
    for row in 0..5 {
        near[4 * row + 3].w = weights[row];
        far[3 * row] = near[4 * row + 3] - dvec3(1.0, 0.0, 0.0).extend(0.0);
    }
    let far = far.into_iter().map(|p| p + dvec3(1.0, 0.0, 0.0).extend(0.0)).collect();
    Scene {
        name: "weights-along-an-edge",
        about: "Weights from 1e-3 to 1e3 along the edge that two patches of different degrees share.",
        camera: "eye = [1.6, 1.5, 1.4]\ntarget = [1.0, 0.0, -0.5]",
        patches: vec![Patch::of_degree([3, 4], near, ORANGE), Patch::of_degree([2, 4], far, BLUE)],
    }
}

fn many_degrees() -> Scene {
    let height = |x: f64, z: f64| 0.4 * (1.7 * x).sin() * (1.3 * z).cos();
    let patch = |[column, row]: [usize; 2]| {
        let [u, v] = [column + 1, row + 1];
        let mut points: Vec<DVec4> = (0..(u + 1) * (v + 1))
            .map(|i| {
                let x = column as f64 + (i % (u + 1)) as f64 / u as f64;
                let z = row as f64 + (i / (u + 1)) as f64 / v as f64;
                dvec3(x, height(x, z), -z).map(|x| (x * 1e4).round() / 1e4).extend(1.0)
            })
            .collect();
        if (column + row) % 3 == 0 {
            let is_inner = |i: usize| {
                ![i % (u + 1), i / (u + 1)]
                    .iter()
                    .zip([u, v])
                    .any(|(place, last)| place.is_multiple_of(last))
            };
            (0..points.len()).filter(|i| is_inner(*i)).for_each(|i| points[i].w = 1.5);
        }
        Patch::of_degree([u, v], points, checkered([column, row]))
    };
    Scene {
        name: "many-degrees",
        about: "A patch for each of 30 pairs of degrees, side by side; some have weights. Not every pair gets a\n\
                # program of its own, and no crack may show.",
        camera: "eye = [5.0, 8.0, 6.0]\ntarget = [5.0, 0.0, -1.5]",
        patches: (0..30).map(|i| patch([i % 10, i / 10])).collect(),
    }
}
