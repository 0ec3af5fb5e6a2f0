//! Makes the scenes of `resources/scenes/gallery`: lettering, a gear, a lace and a roof of shells,
//! each cut by exact trims: `cargo run --release --example make_gallery`.
//!
//! The lights stand 10 above and 10 below the world's origin. A scene beside it is lit from its side,
//! so each one is moved away from there as a whole.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use freeform_surface::{Segment, TrimLoop};
use glam::{DAffine2, DVec2, DVec3, I64Vec2, dvec2, dvec3};

type Fallible<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Fallible<()> {
    for scene in [lettering()?, gear(), lace(), shell()] {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/scenes/gallery");
        let path = format!("{folder}/{}.toml", scene.name);
        std::fs::create_dir_all(folder)?;
        std::fs::write(&path, scene.text())?;
        println!("{path}");
    }
    Ok(())
}

// ---------------------------------------------------------------------------------------- scenes

/// One file of the gallery.
struct Scene {
    name: &'static str,
    about: &'static str,
    /// Where the scene stands, seen from the lights' world.
    place: DVec3,
    /// Both from that place.
    eye: DVec3,
    target: DVec3,
    fov_y_degrees: f64,
    background: [f64; 3],
    surfaces: Vec<Surface>,
}

/// One `[[surface]]`.
struct Surface {
    control_points: [DVec3; 16],
    color: [f64; 3],
    keep: &'static str,
    /// Degrees about the vertical.
    turn: f64,
    path: String,
}

impl Scene {
    fn text(&self) -> String {
        let [r, g, b] = self.background;
        let mut text = format!(
            "# {}\n# Made by examples/make_gallery.rs.\n\n[camera]\neye = {}\ntarget = {}\n\
             fov_y_degrees = {:?}\n\n[render]\nmethod = \"exact\"\nsamples = 4\nlevel = 32\n\
             background = [{r:?}, {g:?}, {b:?}, 1.0]\n",
            self.about,
            list(self.place + self.eye),
            list(self.place + self.target),
            self.fov_y_degrees,
        );
        for surface in &self.surfaces {
            surface.append_to(&mut text, self.place);
        }
        text
    }
}

impl Surface {
    fn append_to(&self, text: &mut String, place: DVec3) {
        text.push_str("\n[[surface]]\ncontrol_points = [\n");
        for row in self.control_points.chunks(4) {
            let row: Vec<String> = row.iter().map(|point| list(*point)).collect();
            *text += &format!("    {},\n", row.join(", "));
        }
        *text += &format!("]\ncolor = {:?}\nshading = \"phong\"\n", self.color);
        if self.turn != 0.0 {
            *text += &format!("rotate_degrees = [0.0, {:?}, 0.0]\n", self.turn);
        }
        *text += &format!("translate = {}\nkeep = \"{}\"\n", list(place), self.keep);
        *text += &format!("\n[[surface.trim]]\npath = \"\"\"\n{}\"\"\"\n", self.path);
    }
}

/// A point of a scene, to four decimals.
fn list(point: DVec3) -> String {
    // A zero is added so that none is written as −0.
    let [x, y, z] = point.to_array().map(|value| (value * 1e4).round() / 1e4 + 0.0);
    format!("[{x:?}, {y:?}, {z:?}]")
}

/// Control points over a level rectangle around the origin, `u` to the right and `v` to the back, at
/// the heights of four rows from the front.
fn sheet(size: DVec2, heights: [[f64; 4]; 4]) -> [DVec3; 16] {
    std::array::from_fn(|i| {
        let (column, row) = (i % 4, i / 4);
        let [x, z] = [column, row].map(|number| number as f64 / 3.0 - 0.5);
        dvec3(x * size.x, heights[row][column], -z * size.y)
    })
}

// ----------------------------------------------------------------------------------------- paths

/// Writes SVG path data, relative and in whole steps, so that no rounding adds up.
struct Pen {
    map: DAffine2,
    data: String,
    start: I64Vec2,
    at: I64Vec2,
}

impl Pen {
    const STEPS: f64 = 1e5;

    /// A pen that is given points before `map`; arcs want one that keeps circles round.
    fn new(map: DAffine2) -> Self {
        Self { map, data: String::new(), start: I64Vec2::ZERO, at: I64Vec2::ZERO }
    }

    fn command(&mut self, letter: char, points: &[DVec2]) {
        self.data.push(letter);
        let mut last = self.at;
        for point in points {
            last = (self.map.transform_point2(*point) * Self::STEPS).round().as_i64vec2();
            let [x, y] = (last - self.at).to_array();
            self.number(x);
            self.number(y);
        }
        self.at = last;
    }

    /// Without the zero before the point and those at the end.
    fn number(&mut self, steps: i64) {
        let text = format!("{:.5}", steps.abs() as f64 / Self::STEPS);
        let text = text.trim_start_matches('0').trim_end_matches(['0']).trim_end_matches('.');
        let sign = if steps < 0 { "-" } else { " " };
        let after_letter = self.data.ends_with(|last: char| last.is_ascii_alphabetic());
        let sign = if after_letter { sign.trim() } else { sign };
        let text = if text.is_empty() { "0" } else { text };
        self.data.extend([sign, text]);
    }

    fn move_to(&mut self, to: DVec2) {
        self.command('m', &[to]);
        self.start = self.at;
    }

    fn line(&mut self, to: DVec2) {
        self.command('l', &[to]);
    }

    fn cubic(&mut self, points: [DVec2; 3]) {
        self.command('c', &points);
    }

    /// An arc, counterclockwise if `left`.
    fn arc(&mut self, radius: f64, large: bool, left: bool, to: DVec2) {
        self.data.push('a');
        let radius = self.map.transform_vector2(dvec2(radius, 0.0)).length();
        let steps = (radius * Self::STEPS).round() as i64;
        self.number(steps);
        self.number(steps);
        write!(self.data, " 0 {} {}", u8::from(large), u8::from(left)).expect("a string grows");
        let to = (self.map.transform_point2(to) * Self::STEPS).round().as_i64vec2();
        let [x, y] = (to - self.at).to_array();
        self.number(x);
        self.number(y);
        self.at = to;
    }

    fn close(&mut self) {
        self.data.push_str("z\n");
        self.at = self.start;
    }

    fn circle(&mut self, center: DVec2, radius: f64) {
        let side = dvec2(radius, 0.0);
        self.move_to(center + side);
        self.arc(radius, false, true, center - side);
        self.arc(radius, false, true, center + side);
        self.close();
    }

    /// A polygon whose corners, each with a radius, are rounded by arcs.
    fn rounded(&mut self, corners: &[(DVec2, f64)]) {
        for (i, &(corner, radius)) in corners.iter().enumerate() {
            let before = corners[(i + corners.len() - 1) % corners.len()].0 - corner;
            let after = corners[(i + 1) % corners.len()].0 - corner;
            let tangent = radius / (0.5 * before.angle_to(after).abs()).tan();
            let from = corner + tangent * before.normalize();
            if i == 0 {
                self.move_to(from);
            } else {
                self.line(from);
            }
            let left = after.perp_dot(before) > 0.0;
            self.arc(radius, false, left, corner + tangent * after.normalize());
        }
        self.close();
    }

    fn outline(&mut self, outline: &TrimLoop) {
        self.move_to(outline.segments()[0].start());
        for segment in outline.segments() {
            match segment {
                Segment::Line(points) => self.command('l', &points[1..]),
                Segment::Quadratic(points) => self.command('q', &points[1..]),
                Segment::Cubic(points) => self.command('c', &points[1..]),
            }
        }
        self.close();
    }
}

fn polar(radius: f64, angle: f64) -> DVec2 {
    radius * DVec2::from_angle(angle)
}

// ------------------------------------------------------------------------------------- lettering

/// Widths and outlines of the letters, 500 high without ascenders, and what stands under them.
const LETTERS: [(f64, &str); 6] = [
    (
        575.0,
        "M0 0 V700 H275 C405 700 478 632 478 528 C478 452 437 397 374 372
         C458 350 517 285 517 195 C517 72 428 0 288 0 Z
         M128 412 H262 C318 412 350 446 350 503 C350 561 318 594 262 594 H128 Z
         M128 106 H274 C346 106 386 144 386 208 C386 272 346 310 274 310 H128 Z",
    ),
    (
        545.0,
        "M499 205 H127 C140 134 191 93 266 93 C322 93 364 114 394 154 L479 94
         C431 25 356 -12 262 -12 C105 -12 0 94 0 250 C0 406 104 512 254 512
         C404 512 502 410 502 262 C502 242 501 223 499 205 Z
         M128 299 H376 C363 370 319 410 254 410 C187 410 141 370 128 299 Z
         M196 574 Q262 640 304 742 H446 Q402 644 308 574 Z",
    ),
    (460.0, "M0 0 V92 L258 398 H12 V500 H415 V410 L158 102 H420 V0 Z"),
    (
        190.0,
        "M0 0 V500 H122 V0 Z
         M-12 652 Q-12 725 61 725 Q134 725 134 652 Q134 579 61 579 Q-12 579 -12 652 Z",
    ),
    (
        550.0,
        "M499 205 H127 C140 134 191 93 266 93 C322 93 364 114 394 154 L479 94
         C431 25 356 -12 262 -12 C105 -12 0 94 0 250 C0 406 104 512 254 512
         C404 512 502 410 502 262 C502 242 501 223 499 205 Z
         M128 299 H376 C363 370 319 410 254 410 C187 410 141 370 128 299 Z",
    ),
    (
        300.0,
        "M0 0 V500 H116 V422 C148 480 204 514 275 514 Q290 514 305 511 V394
         Q287 398 266 398 C176 398 122 336 122 232 V0 Z",
    ),
];

fn lettering() -> Fallible<Scene> {
    let size = dvec2(3.4, 1.5);
    let width: f64 = LETTERS.iter().map(|(width, _)| width).sum();
    let scale = 1e-3 / size;
    let mut left = 0.5 - 0.5 * width * scale.x;
    let mut data = String::new();
    let mut at = I64Vec2::ZERO;
    for (width, outlines) in LETTERS {
        let map = DAffine2::from_scale_angle_translation(scale, 0.0, dvec2(left, 0.33));
        let mut pen = Pen { map, data, start: at, at };
        for outline in TrimLoop::from_svg_path(outlines)? {
            pen.outline(&outline);
        }
        (data, at) = (pen.data, pen.at);
        left += width * scale.x;
    }
    let heights = [
        [0.0, 0.5, -0.5, 0.1],
        [0.1, 0.5, -0.4, 0.1],
        [0.1, 0.4, -0.4, 0.0],
        [0.1, 0.4, -0.4, 0.0],
    ];
    Ok(Scene {
        name: "lettering",
        about: "A waved sheet cut by lettering: lines, quadratics and cubics, islands in the letters.",
        place: dvec3(4.0, 0.0, 3.0),
        eye: dvec3(0.0, 3.4, 2.6),
        target: dvec3(0.0, 0.0, 0.0),
        fov_y_degrees: 25.0,
        background: [0.08, 0.12, 0.2],
        surfaces: vec![Surface {
            control_points: sheet(size, heights),
            color: [0.95, 0.72, 0.3],
            keep: "outside",
            turn: 0.0,
            path: data,
        }],
    })
}

// ------------------------------------------------------------------------------------------ gear

fn gear() -> Scene {
    const TEETH: usize = 24;
    const SPOKES: usize = 6;
    let mut pen = Pen::new(DAffine2::from_translation(DVec2::splat(0.5)));

    let mut border = Vec::new();
    for tooth in 0..TEETH {
        // In parts of a tooth and its gap.
        for (part, radius, rounding) in [
            (-0.30, 0.425, 0.008),
            (-0.15, 0.485, 0.007),
            (0.15, 0.485, 0.007),
            (0.30, 0.425, 0.008),
        ] {
            let angle = (tooth as f64 + part) / TEETH as f64 * TAU;
            border.push((polar(radius, angle), rounding));
        }
    }
    pen.rounded(&border);

    // Windows between the spokes: rounded by `corner`, the edges of the spokes `half` off their axes.
    let [inner, outer, corner, half]: [f64; 4] = [0.15, 0.33, 0.022, 0.024];
    for spoke in 0..SPOKES {
        let [angle, next] = [spoke, spoke + 1].map(|i| i as f64 / SPOKES as f64 * TAU);
        let along = |distance: f64| (distance.powi(2) - (half + corner).powi(2)).sqrt();
        let [near, far] = [along(inner + corner), along(outer - corner)];
        // A point seen from the window's first spoke, and its mirror image from the next one.
        let first = |x: f64, y: f64| DVec2::from_angle(angle).rotate(dvec2(x, y));
        let second = |x: f64, y: f64| DVec2::from_angle(next).rotate(dvec2(x, -y));
        let tip = |distance: f64, radius: f64| {
            (dvec2(distance, half + corner).normalize() * radius).to_array()
        };
        let [[x0, y0], [x1, y1]] = [tip(near, inner), tip(far, outer)];
        pen.move_to(first(near, half));
        pen.line(first(far, half));
        pen.arc(corner, false, true, first(x1, y1));
        pen.arc(outer, false, true, second(x1, y1));
        pen.arc(corner, false, true, second(far, half));
        pen.line(second(near, half));
        pen.arc(corner, false, true, second(x0, y0));
        pen.arc(inner, false, false, first(x0, y0));
        pen.arc(corner, false, true, first(near, half));
        pen.close();
        pen.circle(polar(0.372, angle), 0.016);
        pen.circle(polar(0.113, angle + 0.5 * TAU / SPOKES as f64), 0.013);
    }

    // The hub's hole with its keyway.
    let [bore, key, top]: [f64; 3] = [0.07, 0.018, 0.088];
    let side = (bore * bore - key * key).sqrt();
    pen.move_to(dvec2(-key, side));
    pen.arc(bore, true, true, dvec2(key, side));
    pen.line(dvec2(key, top));
    pen.line(dvec2(-key, top));
    pen.close();

    let heights =
        [[0.0, 0.0, 0.0, 0.0], [0.0, 0.9, 0.9, 0.0], [0.0, 0.9, 0.9, 0.0], [0.0, 0.0, 0.0, 0.0]];
    Scene {
        name: "gear",
        about: "A dome whose border is a gear: lines and arcs, with holes inside the border.",
        place: dvec3(4.0, 0.0, 3.0),
        eye: dvec3(0.0, 2.4, 3.2),
        target: dvec3(0.0, 0.2, 0.0),
        fov_y_degrees: 28.0,
        background: [0.1, 0.1, 0.12],
        surfaces: vec![Surface {
            control_points: sheet(DVec2::splat(2.0), heights),
            color: [0.75, 0.45, 0.25],
            keep: "inside",
            turn: 0.0,
            path: pen.data,
        }],
    }
}

// ------------------------------------------------------------------------------------------ lace

/// The two control points of a quarter of a hole between (1, 0) and (0, 1).
type Quarter = [DVec2; 2];
const ROUND: Quarter = [dvec2(1.0, 0.5523), dvec2(0.5523, 1.0)];
const POINTED: Quarter = [dvec2(0.7, 0.45), dvec2(0.4, 1.0)];
const HOLLOW: Quarter = [dvec2(0.5, 0.15), dvec2(0.15, 0.5)];

/// Holes around a centre: how many, how far from it, half their length outwards and half their
/// breadth, the quarters of their outer and inner ends.
struct Ring(usize, f64, DVec2, [Quarter; 2]);

impl Ring {
    /// The holes that `fits` takes by their place.
    fn draw(&self, pen: &mut Pen, center: DVec2, fits: impl Fn(DVec2) -> bool) {
        let &Self(count, radius, half, [out, back]) = self;
        for number in 0..count {
            let direction = DVec2::from_angle((number as f64 + 0.5) / count as f64 * TAU);
            let middle = center + radius * direction;
            if !fits(middle) {
                continue;
            }
            let at = |x: f64, y: f64| middle + direction.rotate(dvec2(x, y) * half);
            let [[a, b], [c, d]] = [out, back];
            pen.move_to(at(1.0, 0.0));
            pen.cubic([at(a.x, a.y), at(b.x, b.y), at(0.0, 1.0)]);
            pen.cubic([at(-d.x, d.y), at(-c.x, c.y), at(-1.0, 0.0)]);
            pen.cubic([at(-c.x, -c.y), at(-d.x, -d.y), at(0.0, -1.0)]);
            pen.cubic([at(b.x, -b.y), at(a.x, -a.y), at(1.0, 0.0)]);
            pen.close();
        }
    }
}

fn lace() -> Scene {
    /// Flowers along a side; each is 2 × 2 and has 80 holes.
    const FLOWERS: usize = 5;
    let flowers = [
        [
            Ring(8, 0.215, dvec2(0.125, 0.056), [POINTED, POINTED]),
            Ring(16, 0.435, dvec2(0.085, 0.06), [ROUND, POINTED]),
            Ring(24, 0.63, dvec2(0.085, 0.068), [HOLLOW, HOLLOW]),
            Ring(32, 0.835, dvec2(0.1, 0.06), [ROUND, POINTED]),
        ],
        [
            Ring(8, 0.215, dvec2(0.125, 0.056), [ROUND, POINTED]),
            Ring(16, 0.45, dvec2(0.1, 0.06), [POINTED, POINTED]),
            Ring(24, 0.65, dvec2(0.085, 0.055), [POINTED, ROUND]),
            Ring(32, 0.845, dvec2(0.09, 0.068), [HOLLOW, HOLLOW]),
        ],
    ];
    // Between four flowers; a quarter of the 20 holes in each corner.
    let knot = [
        Ring(8, 0.14, dvec2(0.09, 0.036), [ROUND, POINTED]),
        Ring(12, 0.34, dvec2(0.085, 0.055), [HOLLOW, HOLLOW]),
    ];
    let side = 2.0 * FLOWERS as f64;
    let margin = 0.025;
    let scale = DVec2::splat((1.0 - 2.0 * margin) / side);
    let mut pen =
        Pen::new(DAffine2::from_scale_angle_translation(scale, 0.0, DVec2::splat(margin)));
    for i in 0..=FLOWERS {
        for j in 0..=FLOWERS {
            let corner = 2.0 * dvec2(i as f64, j as f64);
            for ring in &knot {
                let inside = 0.0..side;
                ring.draw(&mut pen, corner, |at| inside.contains(&at.x) && inside.contains(&at.y));
            }
            if i < FLOWERS && j < FLOWERS {
                for ring in &flowers[(i + j) % 2] {
                    ring.draw(&mut pen, corner + 1.0, |_| true);
                }
            }
        }
    }
    assert_eq!(pen.data.matches('m').count(), 2_500);
    assert_eq!(pen.data.matches('c').count(), 10_000);

    let heights = [
        [-0.4, 0.0, 0.0, -0.4],
        [0.0, 0.5, 0.2, 0.0],
        [0.0, 0.2, 0.5, 0.0],
        [-0.4, 0.0, 0.0, -0.4],
    ];
    Scene {
        name: "lace",
        about: "A draped lace of 2,500 holes, 10,000 cubic segments.",
        place: dvec3(4.0, 0.0, 3.0),
        eye: dvec3(0.0, 2.4, 2.8),
        target: dvec3(0.0, 0.1, 0.0),
        fov_y_degrees: 33.0,
        background: [0.25, 0.06, 0.1],
        surfaces: vec![Surface {
            control_points: sheet(DVec2::splat(2.4), heights),
            color: [0.93, 0.9, 0.84],
            keep: "outside",
            turn: 0.0,
            path: pen.data,
        }],
    }
}

// ----------------------------------------------------------------------------------------- shell

fn shell() -> Scene {
    const SAILS: usize = 8;
    // In a sail's own x, outwards, and z, sideways: a saddle whose neighbours meet it on the groins
    // z = ± x · tan.
    let tan = (0.5 * TAU / SAILS as f64).tan();
    let [length, breadth] = [1.4, 0.6];
    let [top, rise, fall] = [0.55, 0.35, 4.6];
    let control_points = |lift: f64| {
        std::array::from_fn(|i| {
            let [x, z] = [(i % 4) as f64 / 3.0, (i / 4) as f64 / 1.5 - 1.0];
            // Bézier points of x² and z², as a cubic's.
            let x2 = [0.0, 0.0, 1.0 / 3.0, 1.0][i % 4];
            let z2 = [1.0, -1.0 / 3.0, -1.0 / 3.0, 1.0][i / 4];
            let y = top + rise * x2 * length * length - fall * z2 * breadth * breadth;
            dvec3(x * length, y + lift, -z * breadth)
        })
    };
    let map = DAffine2::from_scale_angle_translation(
        dvec2(1.0 / length, 0.5 / breadth),
        0.0,
        dvec2(0.0, 0.5),
    );
    let mut pen = Pen::new(map);
    let foot = dvec2(1.0, tan);
    pen.move_to(DVec2::ZERO);
    pen.line(dvec2(foot.x, -foot.y));
    pen.cubic([dvec2(1.3, -0.2), dvec2(1.3, 0.2), foot]);
    pen.close();
    let path = pen.data;
    let mut surfaces = Vec::new();
    for sail in 0..SAILS {
        let turn = sail as f64 * 360.0 / SAILS as f64;
        for (lift, color) in [(0.0, [0.9, 0.88, 0.82]), (-0.02, [0.8, 0.4, 0.2])] {
            surfaces.push(Surface {
                control_points: control_points(lift),
                color,
                keep: "inside",
                turn,
                path: path.clone(),
            });
        }
    }
    Scene {
        name: "shell",
        about: "A roof of eight saddles, each trimmed by its own border, that meet on the groins.",
        place: dvec3(6.0, 0.0, 5.0),
        eye: dvec3(0.0, 1.6, 3.2),
        target: dvec3(0.0, 0.3, 0.0),
        fov_y_degrees: 33.0,
        background: [0.35, 0.5, 0.65],
        surfaces,
    }
}
