//! Makes the scenes in `resources/scenes/gallery`, which show uses of exact trims: `cargo run --release
//! --example make_gallery`.
//!
//! The thesis' lamps are 10 above and 10 below the world's origin, so each scene has a place relative to it. Shadows
//! are surfaces too: the shadow of a patch on a floor is a rational patch with the same trims.

use std::f64::consts::TAU;

use freeform_surface::TrimLoop;
use glam::{DAffine2, DVec2, DVec3, DVec4, I64Vec2, dvec2, dvec3};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/scenes/gallery");
    std::fs::create_dir_all(folder)?;
    for scene in [lettering()?, gear(), lace(), shell()] {
        let path = format!("{folder}/{}.toml", scene.name);
        std::fs::write(&path, scene.text())?;
        println!("{path}");
    }
    Ok(())
}

/// One file of the gallery. Its points, and the camera's eye and target, are relative to its place.
struct Scene {
    name: &'static str,
    about: &'static str,
    place: DVec3,
    camera: [DVec3; 2],
    background: [f64; 4],
    surfaces: Vec<Surface>,
}

/// One `[[surface]]`.
#[derive(Clone)]
struct Surface {
    points: [DVec4; 16],
    color: [f64; 3],
    shading: &'static str,
    keep: &'static str,
    path: String,
}

impl Scene {
    fn text(&self) -> String {
        let [eye, target] = self.camera.map(|point| list((self.place + point).extend(1.0)));
        let mut text = format!(
            "# {}\n# Made by examples/make_gallery.rs.\n\n\
             [camera]\neye = {eye}\ntarget = {target}\nfov_y_degrees = 30.0\n\n\
             [render]\nmethod = \"exact\"\nlight = \"thesis\"\nlevel = 32\nsamples = 4\nbackground = {:?}\n",
            self.about, self.background,
        );
        for Surface { points, color, shading, keep, path } in &self.surfaces {
            let points = points.map(list);
            let rows = points.chunks(4).map(|row| format!("    {},\n", row.join(", ")));
            text += &format!(
                "\n[[surface]]\ncontrol_points = [\n{}]\ntranslate = {}\ncolor = {color:?}\n\
                 shading = \"{shading}\"\nkeep = \"{keep}\"\n\n\
                 [[surface.trim]]\npath = \"\"\"\n{path}\"\"\"\n",
                rows.collect::<String>(),
                list(self.place.extend(1.0)),
            );
        }
        text
    }
}

impl Surface {
    fn new(points: [DVec3; 16], color: [f64; 3], keep: &'static str, path: String) -> Self {
        Self { points: points.map(|point| point.extend(1.0)), color, shading: "phong", keep, path }
    }

    /// The shadow on the floor that the upper lamp of a scene at `place` casts.
    fn shadow(&self, place: DVec3, floor: f64, color: [f64; 3]) -> Self {
        let light = dvec3(0.0, 10.0, 0.0) - place;
        let points = self.points.map(|point| {
            let weight = (light.y - point.y) / (light.y - floor);
            (light + (point.truncate() - light) / weight).extend(weight)
        });
        Self { points, color, shading: "flat", ..self.clone() }
    }
}

/// A control point to four decimals, with its weight if it has one.
fn list(point: DVec4) -> String {
    // Adding zero turns −0 into 0.
    let numbers = point.to_array().map(|value| (value * 1e4).round() / 1e4 + 0.0);
    format!("{:?}", if point.w == 1.0 { &numbers[..3] } else { &numbers })
}

/// Control points over a level rectangle, `u` along x and `v` along z, at the heights of four rows.
fn sheet(size: DVec2, heights: [f64; 16]) -> [DVec3; 16] {
    std::array::from_fn(|i| {
        let [x, z] = [i % 4, i / 4].map(|number| number as f64 / 3.0 - 0.5);
        dvec3(x * size.x, heights[i], z * size.y)
    })
}

/// The heights of x² over −1 … 1 as a cubic Bézier curve.
const SQUARE: [f64; 4] = [1.0, -1.0 / 3.0, -1.0 / 3.0, 1.0];

/// Writes SVG path data, relative and in whole steps so that rounding errors do not add up.
struct Pen {
    /// Maps the points that the pen receives into the domain.
    map: DAffine2,
    data: String,
    start: I64Vec2,
    at: I64Vec2,
}

impl Pen {
    const STEPS: f64 = 1e5;

    /// A pen for points that are `scale` in the domain and `origin` away from its corner.
    fn new(scale: DVec2, origin: DVec2) -> Self {
        let map = DAffine2::from_scale_angle_translation(scale, 0.0, origin);
        Self { map, data: String::new(), start: I64Vec2::ZERO, at: I64Vec2::ZERO }
    }

    fn move_to(&mut self, to: DVec2) {
        self.draw("m", [to]);
        self.start = self.at;
    }

    fn close(&mut self) {
        self.data += "z\n";
        self.at = self.start;
    }

    fn draw(&mut self, command: &str, points: impl IntoIterator<Item = DVec2>) {
        self.data += command;
        let from = self.at;
        for point in points {
            self.at = (self.map.transform_point2(point) * Self::STEPS).round().as_i64vec2();
            for steps in (self.at - from).to_array() {
                // Without the zero before the point.
                let number = (steps as f64 / Self::STEPS).to_string().replacen("0.", ".", 1);
                self.data += if steps < 0 { "" } else { " " };
                self.data += &number;
            }
        }
    }

    /// An arc to the left or, with a negative radius, to the right; the map must scale uniformly.
    fn arc(&mut self, radius: f64, large: bool, to: DVec2) {
        let size = (radius.abs() * self.map.matrix2.x_axis.x * Self::STEPS).round() / Self::STEPS;
        let [large, left] = [large, radius > 0.0].map(u8::from);
        self.draw(&format!("a {size} {size} 0 {large} {left}"), [to]);
    }

    fn circle(&mut self, center: DVec2, radius: f64) {
        self.move_to(center + radius * DVec2::X);
        self.arc(radius, false, center - radius * DVec2::X);
        self.arc(radius, false, center + radius * DVec2::X);
        self.close();
    }
}

/// Widths and outlines, in thousandths of the sheet's unit; an outline with width 0 is not moved.
const LETTERS: [(f64, &str); 8] = [
    (0.0, "M30 -180 C850 0 1650 -400 2560 -150 C1650 -460 850 -60 30 -180 Z"),
    (575.0, B),
    (0.0, "M196 574 Q262 640 304 742 H446 Q402 644 308 574 Z"),
    (545.0, E),
    (460.0, "M0 0 V92 L258 398 H12 V500 H415 V410 L158 102 H420 V0 Z"),
    (190.0, "M0 0 V500 H122 V0 Z M-12 652 Q-12 725 61 725 T134 652 T61 579 T-12 652 Z"),
    (550.0, E),
    (300.0, R),
];
const B: &str = "M0 0 V700 H275 C405 700 478 632 478 528 C478 452 437 397 374 372
    C458 350 517 285 517 195 C517 72 428 0 288 0 Z M128 412 H262 C318 412 350 446 350 503
    C350 561 318 594 262 594 H128 Z M128 106 H274 C346 106 386 144 386 208 S346 310 274 310 H128 Z";
const E: &str = "M499 205 H127 C140 134 191 93 266 93 C322 93 364 114 394 154 L479 94
    C431 25 356 -12 262 -12 C105 -12 0 94 0 250 C0 406 104 512 254 512 C404 512 502 410 502 262
    C502 242 501 223 499 205 Z M128 299 H376 C363 370 319 410 254 410 C187 410 141 370 128 299 Z";
const R: &str = "M0 0 V500 H116 V422 C148 480 204 514 275 514 Q290 514 305 511 V394
    Q287 398 266 398 C176 398 122 336 122 232 V0 Z";

fn lettering() -> Result<Scene, freeform_surface::Error> {
    let place = dvec3(6.0, -12.0, -2.0);
    let size = dvec2(3.2, 1.7);
    let mut pen = Pen::new(dvec2(1.07e-3, -1.07e-3) / size, dvec2(0.064, 0.67));
    for (width, outlines) in LETTERS {
        for outline in TrimLoop::from_svg_path(outlines)? {
            pen.move_to(outline.segments()[0].start());
            for segment in outline.segments() {
                let points = segment.points();
                pen.draw(["l", "q", "c"][points.len() - 2], points[1..].iter().copied());
            }
            pen.close();
        }
        pen.map.translation.x += width * pen.map.matrix2.x_axis.x;
    }
    let y = [0.1, 0.6, -0.3, 0.2, 0.1, 0.5, -0.3, 0.2, 0.1, 0.5, -0.3, 0.1, 0.0, 0.5, -0.3, 0.1];
    let waved = Surface::new(sheet(size, y), [0.04, 0.27, 0.43], "outside", pen.data);
    Ok(Scene {
        name: "lettering",
        about: "A waved sheet cut by lettering: lines, quadratics, cubics, islands in the letters.",
        place,
        camera: [dvec3(0.1, 3.9, 1.9), dvec3(0.0, 0.0, 0.0)],
        background: [0.95, 0.92, 0.86, 1.0],
        surfaces: vec![waved.shadow(place, -0.15, [0.86, 0.82, 0.75]), waved],
    })
}

fn gear() -> Scene {
    const TEETH: usize = 24;
    const SPOKES: usize = 6;
    let polar = |radius: f64, turn: f64| radius * DVec2::from_angle(turn * TAU);
    let mut pen = Pen::new(DVec2::splat(0.5), DVec2::splat(0.5));
    let [root, tip] = [0.85, 0.97];
    // Teeth with round corners, and round bottoms between them.
    pen.move_to(polar(root, -0.28 / TEETH as f64));
    for tooth in 0..TEETH {
        let at = |radius: f64, part: f64| polar(radius, (tooth as f64 + part) / TEETH as f64);
        pen.draw("l", [at(tip - 0.02, -0.19)]);
        pen.arc(0.024, false, at(tip, -0.11));
        pen.arc(tip, false, at(tip, 0.11));
        pen.arc(0.024, false, at(tip - 0.02, 0.19));
        pen.draw("l", [at(root, 0.28)]);
        pen.arc(-0.055, false, at(root, 0.72));
        pen.data.push('\n');
    }
    pen.close();
    // Windows between the spokes: rounded by `corner`, with edges at a distance of `half` from the spokes'
    // axes.
    let [inner, outer, corner, half]: [f64; 4] = [0.3, 0.68, 0.05, 0.045];
    for spoke in 0..SPOKES {
        let turn = spoke as f64 / SPOKES as f64;
        // Beside the first spoke (0) or the next one (1), as mirror images.
        let at = |side: usize, at: DVec2| {
            let axis = polar(1.0, (spoke + side) as f64 / SPOKES as f64);
            axis.rotate(dvec2(at.x, [at.y, -at.y][side]))
        };
        let along = |distance: f64| (distance.powi(2) - (half + corner).powi(2)).sqrt();
        pen.move_to(at(0, dvec2(along(inner + corner), half)));
        for (side, radius, middle) in [(0, outer, outer - corner), (1, -inner, inner + corner)] {
            let edge = dvec2(along(middle), half);
            let end = radius.abs() / middle * dvec2(edge.x, half + corner);
            pen.draw("l", [at(side, edge)]);
            pen.arc(corner, false, at(side, end));
            pen.arc(radius, false, at(1 - side, end));
            pen.arc(corner, false, at(1 - side, edge));
        }
        pen.close();
        pen.circle(polar(0.76, turn), 0.032);
        pen.circle(polar(0.23, turn), 0.026);
    }
    // The hub's hole with its keyway.
    let [bore, key]: [f64; 2] = [0.14, 0.036];
    let side = (bore * bore - key * key).sqrt();
    pen.move_to(dvec2(-key, side));
    pen.arc(bore, true, dvec2(key, side));
    pen.draw("l", [dvec2(key, bore + 0.04)]);
    pen.draw("l", [dvec2(-key, bore + 0.04)]);
    pen.close();
    let place = dvec3(4.5, -9.0, -4.0);
    let y = std::array::from_fn(|i| -0.28 * (SQUARE[i % 4] + SQUARE[i / 4]));
    let dome = Surface::new(sheet(DVec2::splat(2.0), y), [0.58, 0.36, 0.13], "inside", pen.data);
    Scene {
        name: "gear",
        about: "A dome whose border is a gear: lines and arcs, with holes inside the border.",
        place,
        camera: [dvec3(0.0, 2.4, 2.27), dvec3(0.0, -0.3, 0.12)],
        background: [0.36, 0.4, 0.44, 1.0],
        surfaces: vec![dome.shadow(place, -0.45, [0.25, 0.28, 0.31]), dome],
    }
}

/// The two control points of a quarter of a hole between (1, 0) and (0, 1).
type Quarter = [DVec2; 2];
const ROUND: Quarter = [dvec2(1.0, 0.5523), dvec2(0.5523, 1.0)];
const POINTED: Quarter = [dvec2(0.7, 0.45), dvec2(0.4, 1.0)];
const HOLLOW: Quarter = [dvec2(0.5, 0.15), dvec2(0.15, 0.5)];

/// Draws a hole around `middle` with an outer and an inner end; `half` is half its length and half its breadth.
fn hole(pen: &mut Pen, middle: DVec2, outwards: DVec2, half: DVec2, ends: [Quarter; 2]) {
    let [[a, b], [c, d]] = ends;
    pen.move_to(middle + outwards.rotate(half * DVec2::X));
    for (first, second, end, side) in [
        (a, b, DVec2::Y, dvec2(1.0, 1.0)),
        (d, c, DVec2::X, dvec2(-1.0, 1.0)),
        (c, d, DVec2::Y, dvec2(-1.0, -1.0)),
        (b, a, DVec2::X, dvec2(1.0, -1.0)),
    ] {
        let at = |point: DVec2| middle + outwards.rotate(point * side * half);
        pen.draw("c", [first, second, end].map(at));
    }
    pen.close();
}

/// Holes around a centre: their number, their distance from it, half their length and breadth, and their ends.
type Ring = (usize, f64, DVec2, [Quarter; 2]);

/// Draws the holes whose centre is in a square from the origin.
fn rings(pen: &mut Pen, rings: &[Ring], center: DVec2, square: f64) {
    for &(count, radius, half, ends) in rings {
        for number in 0..count {
            let outwards = DVec2::from_angle((number as f64 + 0.5) / count as f64 * TAU);
            let middle = center + radius * outwards;
            if middle.min_element() > 0.0 && middle.max_element() < square {
                hole(pen, middle, outwards, half, ends);
            }
        }
    }
}

fn lace() -> Scene {
    /// Flowers along a side, each 2 × 2.
    const FLOWERS: usize = 5;
    let flowers: [[Ring; 4]; 2] = [
        [
            (8, 0.215, dvec2(0.125, 0.056), [POINTED, POINTED]),
            (16, 0.435, dvec2(0.085, 0.06), [ROUND, POINTED]),
            (24, 0.63, dvec2(0.085, 0.068), [HOLLOW, HOLLOW]),
            (32, 0.835, dvec2(0.1, 0.06), [ROUND, POINTED]),
        ],
        [
            (8, 0.215, dvec2(0.125, 0.056), [ROUND, POINTED]),
            (16, 0.45, dvec2(0.1, 0.06), [POINTED, POINTED]),
            (24, 0.65, dvec2(0.085, 0.055), [POINTED, ROUND]),
            (32, 0.845, dvec2(0.09, 0.068), [HOLLOW, HOLLOW]),
        ],
    ];
    // The ornament between the flowers; at the hem, a half or a quarter of it.
    let knot = [
        (8, 0.14, dvec2(0.09, 0.036), [ROUND, POINTED]),
        (12, 0.34, dvec2(0.085, 0.055), [HOLLOW, HOLLOW]),
    ];
    let side = 2.0 * FLOWERS as f64;
    let mut pen = Pen::new(DVec2::splat(0.95 / side), DVec2::splat(0.025));
    for place in 0..(FLOWERS + 1).pow(2) {
        let [column, row] = [place % (FLOWERS + 1), place / (FLOWERS + 1)];
        let corner = 2.0 * dvec2(column as f64, row as f64);
        rings(&mut pen, &knot, corner, side);
        if column.max(row) < FLOWERS {
            rings(&mut pen, &flowers[(column + row) % 2], corner + 1.0, side);
        }
    }
    assert_eq!(["m", "c"].map(|letter| pen.data.matches(letter).count()), [2_500, 10_000]);
    let y = [0.3, -0.3, 0.6, 0.0, 0.0, 0.9, -0.4, 0.3, 0.0, 0.9, -0.4, 0.3, -0.6, 1.2, -1.2, 0.2];
    let cloth = Surface::new(sheet(dvec2(3.1, 2.4), y), [0.74, 0.7, 0.62], "outside", pen.data);
    Scene {
        name: "lace",
        about: "A draped lace of 2,500 holes, 10,000 cubic segments.",
        place: dvec3(9.5, -3.5, -3.5),
        camera: [dvec3(0.3, 3.7, 3.4), dvec3(0.0, 0.0, 0.12)],
        background: [0.3, 0.07, 0.12, 1.0],
        surfaces: vec![cloth],
    }
}

fn shell() -> Scene {
    const SAILS: usize = 8;
    // A saddle: x² rises outwards and z² falls sideways. Neighbouring saddles meet where both have the same
    // height.
    let foot = 1.15 * dvec2(1.0, (0.5 * TAU / SAILS as f64).tan());
    let [size, top, rise, fall] = [1.45, 0.36, 0.42, 1.44];
    let points = |sail: usize, lift: f64| {
        let out = DVec2::from_angle((sail as f64 + 0.5) / SAILS as f64 * TAU);
        std::array::from_fn(|i| {
            let [x, z] = [(i % 4) as f64 / 3.0, (i / 4) as f64 / 3.0 - 0.5];
            let level = size * out.rotate(dvec2(x, z));
            let y = top + rise * [0.0, 0.0, 1.0 / 3.0, 1.0][i % 4] - fall * SQUARE[i / 4];
            dvec3(level.x, y + lift, level.y)
        })
    };
    let border = |window: bool| {
        let mut pen = Pen::new(DVec2::splat(1.0 / size), dvec2(0.0, 0.5));
        // Slightly beyond the groin, so that no gap is left there.
        let more = dvec2(0.0, 0.002);
        pen.move_to(-more);
        pen.draw("l", [foot * dvec2(1.0, -1.0) - more]);
        pen.draw("c", [dvec2(1.5, -0.2), dvec2(1.5, 0.2), foot + more]);
        pen.draw("l", [more]);
        pen.close();
        if window {
            hole(&mut pen, dvec2(0.86, 0.0), DVec2::X, dvec2(0.35, 0.15), [ROUND, POINTED]);
        } else {
            for x in [0.5, 0.65, 0.82, 1.01, 1.22] {
                pen.circle(dvec2(x, 0.0), 0.08 * x);
            }
        }
        pen.data
    };
    let place = dvec3(2.5, -9.0, -8.0);
    let surfaces = (0..SAILS).flat_map(|sail| {
        let path = border(sail % 2 == 0);
        let sail = |lift, color| Surface::new(points(sail, lift), color, "inside", path.clone());
        let roof = sail(0.0, [0.62, 0.6, 0.55]);
        [roof.shadow(place, -0.02, [0.33, 0.42, 0.45]), roof, sail(-0.02, [0.6, 0.27, 0.1])]
    });
    Scene {
        name: "shell",
        about: "A roof of eight saddles, each trimmed by its own border, that meet on the groins.",
        place,
        camera: [dvec3(0.6, 2.5, 3.7), dvec3(0.0, 0.19, 0.0)],
        background: [0.55, 0.66, 0.68, 1.0],
        surfaces: surfaces.collect(),
    }
}
