//! Faces with known areas and edges, in many places and sizes, with their seams anywhere.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat3, DVec2, DVec3, DVec4, dvec2, dvec3};

use super::*;

/// A place and a size in which faces are made.
#[derive(Debug, Clone, Copy)]
struct Setting {
    scale: f64,
    /// In sizes.
    moved: f64,
    /// By which surfaces are turned about their axis.
    seam: f64,
}

const SETTINGS: [Setting; 6] = [
    Setting { scale: 1.0, moved: 0.0, seam: 0.0 },
    Setting { scale: 1.0, moved: 0.0, seam: 1.1 },
    Setting { scale: 1.0, moved: 0.3, seam: PI },
    Setting { scale: 1e-6, moved: 0.0, seam: -2.0 },
    Setting { scale: 1e6, moved: 1.0, seam: 0.4 },
    Setting { scale: 1.0, moved: 1e6, seam: 3.0 },
];

impl Setting {
    /// A coordinate system at a height above the origin. Its x axis goes through the seam if `angle` is that of it.
    fn frame(self, height: f64, angle: f64) -> Frame {
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, -0.7, 1.9);
        let (sin, cos) = angle.sin_cos();
        let origin = turn * dvec3(0.0, 0.0, height) + self.moved * dvec3(0.6, -0.5, 0.8);
        Frame {
            origin: self.scale * origin,
            x: turn * dvec3(cos, sin, 0.0),
            y: turn * dvec3(-sin, cos, 0.0),
            z: turn * dvec3(0.0, 0.0, 1.0),
        }
    }

    fn of_surface(self) -> Frame {
        self.frame(0.0, self.seam)
    }

    fn point(self, x: f64, y: f64, z: f64) -> DVec3 {
        let frame = self.frame(0.0, 0.0);
        frame.origin + self.scale * (x * frame.x + y * frame.y + z * frame.z)
    }

    /// A circle about the axis, from an angle to another one.
    fn circle(self, radius: f64, height: f64, range: [f64; 2]) -> Option<BoundedCurve> {
        let curve = Curve::Circle { frame: self.frame(height, 0.0), radius: self.scale * radius };
        Some(BoundedCurve { curve, range })
    }

    fn line(self, from: DVec3, to: DVec3) -> Option<BoundedCurve> {
        let [from, to] = [from, to].map(|p| self.point(p.x, p.y, p.z));
        let curve = Curve::Line { origin: from, direction: (to - from).normalize() };
        Some(BoundedCurve { curve, range: [0.0, from.distance(to)] })
    }

    /// A circle of the tube of a torus at an angle around the axis.
    fn tube(self, major: f64, minor: f64, angle: f64) -> Option<BoundedCurve> {
        let frame = self.frame(0.0, angle);
        let frame = Frame {
            origin: frame.origin + self.scale * major * frame.x,
            y: frame.z,
            z: -frame.y,
            ..frame
        };
        let curve = Curve::Circle { frame, radius: self.scale * minor };
        Some(BoundedCurve { curve, range: [0.0, TAU] })
    }
}

type Uses<'a> = &'a [&'a [(usize, bool)]];

fn model(
    surface: FaceSurface,
    edges: Vec<Option<BoundedCurve>>,
    loops: Uses<'_>,
    bounds: [f64; 4],
) -> Model {
    let coedge =
        |(edge, forward): &(usize, bool)| Coedge { edge: *edge, forward: *forward, pcurve: None };
    let face = Face {
        name: String::new(),
        tolerance: 0.0,
        color: None,
        reversed: false,
        surface,
        bounds: [dvec2(bounds[0], bounds[2]), dvec2(bounds[1], bounds[3])],
        loops: loops.iter().map(|one| one.iter().map(coedge).collect()).collect(),
    };
    Model {
        name: String::new(),
        unit: 0.001,
        edges: edges.into_iter().map(|curve| Edge { tolerance: 0.0, curve }).collect(),
        faces: vec![face],
        products: vec![Product {
            name: String::new(),
            color: None,
            faces: [0, 1],
            uses: Vec::new(),
        }],
    }
}

/// The distance of a point from a curve, by formula and search.
fn distance(curve: &BoundedCurve, point: DVec3) -> f64 {
    let at = |t: f64| match &curve.curve {
        Curve::Line { origin, direction } => *origin + t * *direction,
        Curve::Circle { frame, radius } => {
            frame.origin + *radius * (t.cos() * frame.x + t.sin() * frame.y)
        }
        Curve::Ellipse { frame, radii } => {
            frame.origin + radii[0] * t.cos() * frame.x + radii[1] * t.sin() * frame.y
        }
        Curve::Nurbs(curve) => curve.at(t)[0],
    };
    const STEPS: u32 = 400;
    let [low, high] = curve.range;
    let place = |i: f64| low + (high - low) * (i / f64::from(STEPS)).clamp(0.0, 1.0);
    let of = |t: f64| at(t).distance(point);
    let best =
        (0..=STEPS).min_by(|a, b| of(place(f64::from(*a))).total_cmp(&of(place(f64::from(*b)))));
    let best = f64::from(best.unwrap());
    let [mut low, mut high] = [place(best - 1.0), place(best + 1.0)];
    for _ in 0..60 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if of(a) < of(b) { high = b } else { low = a }
    }
    of(low.midpoint(high))
}

/// Checks the area of the only face, given for the scale 1, and that its edges lie where they should: up to `off` from
/// their curves.
fn check(model: &Model, setting: Setting, area: f64, off: f64) {
    let diagonal = model.diagonal();
    let face = model.drawn_face(0, diagonal).unwrap();
    let rounding = 1e-15 * setting.moved * setting.scale;
    let found = face.area() / (setting.scale * setting.scale);
    let accuracy = 2e-7 + 1e-14 * setting.moved;
    assert!(
        (found - area).abs() <= accuracy * area,
        "{setting:?}: {found} is not {area}\n{:?}",
        face.trims.loops
    );
    // The trims as the renderer reads them, by samples.
    const SIDE: u32 = 60;
    let [low, high] = face.surface.domain();
    let (mut all, mut kept) = (0.0, 0.0);
    for i in 0..SIDE * SIDE {
        let share = (dvec2(f64::from(i % SIDE), f64::from(i / SIDE)) + 0.5) / f64::from(SIDE);
        let place = low + share * (high - low);
        let at = face.surface.at(place.x, place.y);
        let part = at.du.cross(at.dv).length() * (high - low).element_product();
        all += part / f64::from(SIDE * SIDE);
        kept += if face.trims.cut(place) { 0.0 } else { part / f64::from(SIDE * SIDE) };
    }
    let [all, kept] = [all, kept].map(|sum| sum / (setting.scale * setting.scale));
    assert!((kept - area).abs() < 0.01 * all, "{setting:?}: {kept} is not {area}");
    for edge in &face.edges {
        let curve = model.edges[edge.edge].curve.as_ref().unwrap();
        for segment in &edge.segments {
            for i in 0..=20 {
                let place = segment.point(f64::from(i) / 20.0);
                let point = face.point(place);
                let distance = distance(curve, point);
                let most = off * setting.scale + 1e-7 * diagonal + 10.0 * rounding;
                assert!(distance <= most, "{setting:?}: {distance} > {most} at {place}, {edge:?}");
            }
        }
    }
    // A reversed face has the same trims.
    let mut reversed = model.clone();
    reversed.faces[0].reversed = true;
    assert_eq!(reversed.drawn_face(0, diagonal).unwrap(), face);
}

const TURN: [f64; 2] = [0.0, TAU];

#[test]
fn cylinders() {
    for setting in SETTINGS {
        let surface =
            FaceSurface::Cylinder { frame: setting.of_surface(), radius: 2.0 * setting.scale };
        let s = setting.scale;
        let bounds = [0.0, TAU, 0.0, 3.0 * s];
        let quarter = [0.2, 0.2 + FRAC_PI_2];
        let at = |angle: f64, height: f64| dvec3(2.0 * angle.cos(), 2.0 * angle.sin(), height);
        let edges = vec![
            setting.circle(2.0, 0.0, quarter),
            setting.circle(2.0, 3.0, quarter),
            setting.line(at(quarter[0], 0.0), at(quarter[0], 3.0)),
            setting.line(at(quarter[1], 0.0), at(quarter[1], 3.0)),
        ];
        let loops: Uses<'_> = &[&[(0, true), (3, true), (1, false), (2, false)]];
        check(&model(surface.clone(), edges, loops, bounds), setting, 3.0 * PI, 0.0);

        // Whole, with a seam at the edge's start, and without one.
        let edges = || {
            vec![
                setting.circle(2.0, 0.0, TURN),
                setting.circle(2.0, 3.0, TURN),
                setting.line(at(0.0, 0.0), at(0.0, 3.0)),
            ]
        };
        let loops: Uses<'_> = &[&[(0, true), (2, true), (1, false), (2, false)]];
        check(&model(surface.clone(), edges(), loops, bounds), setting, 12.0 * PI, 0.0);
        let loops: Uses<'_> = &[&[(2, false), (0, true), (2, true), (1, false)]];
        check(&model(surface.clone(), edges(), loops, bounds), setting, 12.0 * PI, 0.0);
        let loops: Uses<'_> = &[&[(0, true)], &[(1, false)]];
        check(&model(surface.clone(), edges(), loops, bounds), setting, 12.0 * PI, 0.0);
        let loops: Uses<'_> = &[&[(1, false)], &[(0, true)]];
        check(&model(surface.clone(), edges(), loops, bounds), setting, 12.0 * PI, 0.0);

        // Cut by an oblique plane z = 3 + x / 2.
        let frame = setting.frame(3.0, 0.0);
        let tilt = (frame.x + 0.5 * frame.z).normalize();
        let ellipse = Curve::Ellipse {
            frame: Frame { x: tilt, y: frame.y, z: tilt.cross(frame.y), ..frame },
            radii: [2.0 * 1.25_f64.sqrt() * s, 2.0 * s],
        };
        let oblique = || BoundedCurve { curve: ellipse.clone(), range: TURN };
        let edges = vec![setting.circle(2.0, 0.0, TURN), Some(oblique())];
        let loops: Uses<'_> = &[&[(0, true)], &[(1, false)]];
        check(&model(surface.clone(), edges, loops, bounds), setting, 12.0 * PI, 0.0);
        // The part above it, up to 5.
        let edges = vec![setting.circle(2.0, 5.0, TURN), Some(oblique())];
        let loops: Uses<'_> = &[&[(0, false)], &[(1, true)]];
        check(&model(surface, edges, loops, bounds), setting, 8.0 * PI, 0.0);
    }
}

#[test]
fn a_hole_across_the_seam_of_a_cylinder() {
    for setting in SETTINGS {
        let s = setting.scale;
        let surface = FaceSurface::Cylinder { frame: setting.of_surface(), radius: 2.0 * s };
        // A circle of radius 0.5 beside the cylinder, in front of any angle; it is projected.
        for angle in [setting.seam, setting.seam + 0.1, 0.0, 2.0] {
            let radial = setting.frame(1.5, angle);
            let frame = Frame {
                origin: radial.origin + 2.0 * s * radial.x,
                x: radial.y,
                y: radial.z,
                z: radial.x,
            };
            let hole = Curve::Circle { frame, radius: 0.5 * s };
            let edges = vec![
                setting.circle(2.0, 0.0, TURN),
                setting.circle(2.0, 3.0, TURN),
                Some(BoundedCurve { curve: hole, range: TURN }),
            ];
            let loops: Uses<'_> = &[&[(0, true)], &[(1, false)], &[(2, false)]];
            // 2 ∮ v du = 2 ∫ 0.5 sin t · du/dt dt, with u = atan(0.5 cos t / 2).
            const STEPS: u32 = 4000;
            let cut: f64 = (0..STEPS)
                .map(|i| {
                    let t = TAU * f64::from(i) / f64::from(STEPS);
                    let x = 0.25 * t.cos();
                    2.0 * 0.5 * t.sin() * 0.25 * t.sin() / (1.0 + x * x) * TAU / f64::from(STEPS)
                })
                .sum();
            let bounds = [0.0, TAU, 0.0, 3.0 * s];
            let mut model = model(surface.clone(), edges, loops, bounds);
            model.edges[2].tolerance = 0.062 * s;
            check(&model, setting, 12.0 * PI - cut, 0.062);
            assert!(model.drawn_face(0, model.diagonal()).unwrap().trims.loops.len() >= 2);
        }
    }
}

#[test]
fn spheres() {
    for setting in SETTINGS {
        let s = setting.scale;
        let surface = FaceSurface::Sphere { frame: setting.of_surface(), radius: 2.0 * s };
        let bounds = [0.0, TAU, -FRAC_PI_2, FRAC_PI_2];
        for (height, forward) in
            [(0.0, true), (0.0, false), (1.2, true), (-0.5, true), (1.9, false)]
        {
            let radius = (4.0_f64 - height * height).sqrt();
            let edges = vec![setting.circle(radius, height, TURN)];
            let high = if forward { 2.0 - height } else { 2.0 + height };
            let loops: Uses<'_> = &[&[(0, forward)]];
            check(&model(surface.clone(), edges, loops, bounds), setting, 4.0 * PI * high, 0.0);
        }
        // Seam and poles: a whole sphere, and its upper half.
        let meridian = |from: f64, angle: f64| {
            let frame = setting.frame(0.0, angle);
            let frame = Frame { y: frame.z, z: -frame.y, ..frame };
            let curve = Curve::Circle { frame, radius: 2.0 * s };
            Some(BoundedCurve { curve, range: [from, FRAC_PI_2] })
        };
        let edges = vec![meridian(-FRAC_PI_2, 0.7), None, None];
        let loops: Uses<'_> = &[&[(0, true), (1, true), (0, false), (2, true)]];
        check(&model(surface.clone(), edges.clone(), loops, bounds), setting, 16.0 * PI, 0.0);
        let loops: Uses<'_> = &[&[(0, true), (0, false)]];
        check(&model(surface.clone(), edges, loops, bounds), setting, 16.0 * PI, 0.0);
        check(&model(surface.clone(), Vec::new(), &[], bounds), setting, 16.0 * PI, 0.0);
        let edges = vec![setting.circle(2.0, 0.0, TURN), meridian(0.0, 0.0), None];
        let loops: Uses<'_> = &[&[(0, true), (1, true), (2, true), (1, false)]];
        check(&model(surface.clone(), edges, loops, bounds), setting, 8.0 * PI, 0.0);
        // An eighth.
        let edges = vec![
            setting.circle(2.0, 0.0, [0.5, 0.5 + FRAC_PI_2]),
            meridian(0.0, 0.5 + FRAC_PI_2),
            meridian(0.0, 0.5),
        ];
        let loops: Uses<'_> = &[&[(0, true), (1, true), (2, false)]];
        check(&model(surface.clone(), edges, loops, bounds), setting, 2.0 * PI, 0.0);
        // Half of it, cut along its axis: the edge goes through both poles.
        for forward in [true, false] {
            let frame = setting.frame(0.0, 0.9);
            let frame = Frame { y: frame.z, z: -frame.y, ..frame };
            let curve = Curve::Circle { frame, radius: 2.0 * s };
            let edges = vec![Some(BoundedCurve { curve, range: [0.3, 0.3 + TAU] })];
            let loops: Uses<'_> = &[&[(0, forward)]];
            check(&model(surface.clone(), edges, loops, bounds), setting, 8.0 * PI, 0.0);
        }
        // All but a cap around a place on the equator, and that cap.
        for angle in [setting.seam, 1.0] {
            for (forward, height) in [(true, 0.5), (false, 3.5)] {
                let radial = setting.frame(0.0, angle);
                let frame = Frame {
                    origin: radial.origin + 1.5 * s * radial.x,
                    x: radial.y,
                    y: radial.z,
                    z: radial.x,
                };
                let radius = (4.0_f64 - 2.25).sqrt() * s;
                let curve = Curve::Circle { frame, radius };
                let edges = vec![Some(BoundedCurve { curve, range: TURN })];
                let loops: Uses<'_> = &[&[(0, forward)]];
                let turned = FaceSurface::Revolution {
                    origin: setting.of_surface().origin,
                    axis: setting.of_surface().z,
                    curve: meridian(-FRAC_PI_2, setting.seam).unwrap(),
                };
                for surface in [surface.clone(), turned] {
                    let model = model(surface, edges.clone(), loops, bounds);
                    check(&model, setting, 4.0 * PI * height, 0.0);
                }
            }
        }
    }
}

#[test]
fn tori() {
    for setting in SETTINGS {
        let s = setting.scale;
        let (major, minor) = (3.0, 1.0);
        let surface = FaceSurface::Torus {
            frame: setting.of_surface(),
            major_radius: major * s,
            minor_radius: minor * s,
        };
        let bounds = [0.0, TAU, 0.0, TAU];
        for from in [0.0, 0.9, 5.0] {
            // Half around the axis.
            let edges =
                vec![setting.tube(major, minor, from), setting.tube(major, minor, from + PI)];
            let loops: Uses<'_> = &[&[(0, false)], &[(1, true)]];
            check(&model(surface.clone(), edges, loops, bounds), setting, 6.0 * PI * PI, 0.0);
            // Half around the tube.
            let rim = |v: f64| setting.circle(major + minor * v.cos(), minor * v.sin(), TURN);
            let area = TAU * (major * PI + (from + PI).sin() - from.sin());
            let loops: Uses<'_> = &[&[(0, true)], &[(1, false)]];
            let edges = vec![rim(from), rim(from + PI)];
            check(&model(surface.clone(), edges, loops, bounds), setting, area, 0.0);
        }
        check(&model(surface, Vec::new(), &[], bounds), setting, 12.0 * PI * PI, 0.0);
        // The inner part of a torus that touches itself, between the places where it does: cos v = −1/2.
        let surface = FaceSurface::Torus {
            frame: setting.of_surface(),
            major_radius: 0.5 * s,
            minor_radius: s,
        };
        let v = [PI - 0.5, PI + 0.5];
        let rim = |v: f64| setting.circle(-(0.5 + v.cos()), v.sin(), [PI, PI + TAU]);
        let loops: Uses<'_> = &[&[(0, true)], &[(1, false)]];
        // On the other side of the axis, the circle's angle is half a turn off.
        let area = -TAU * (0.5 + v[1].sin() - v[0].sin());
        check(&model(surface, v.map(rim).to_vec(), loops, bounds), setting, area, 0.0);
    }
}

#[test]
fn cones() {
    for setting in SETTINGS {
        let s = setting.scale;
        // From radius 2 at height 0 to the apex at height 3.
        let half_angle = -(2.0_f64 / 3.0).atan();
        let surface =
            FaceSurface::Cone { frame: setting.of_surface(), radius: 2.0 * s, half_angle };
        let length = 13.0_f64.sqrt();
        let bounds = [0.0, TAU, 0.0, length * s];
        let edges = || {
            vec![
                setting.circle(2.0, 0.0, TURN),
                setting.line(dvec3(2.0, 0.0, 0.0), dvec3(0.0, 0.0, 3.0)),
                None,
            ]
        };
        let area = PI * 2.0 * length;
        for loops in [
            &[&[(0, true)][..]][..],
            &[&[(0, true), (1, true), (2, true), (1, false)]],
            &[&[(0, true), (1, true), (1, false)]],
        ] {
            check(&model(surface.clone(), edges(), loops, bounds), setting, area, 0.0);
        }
        let edges = vec![setting.circle(2.0, 0.0, TURN), setting.circle(1.0, 1.5, TURN)];
        let loops: Uses<'_> = &[&[(0, true)], &[(1, false)]];
        check(&model(surface, edges, loops, bounds), setting, 0.75 * area, 0.0);
    }
}

#[test]
fn planes() {
    for setting in SETTINGS {
        let s = setting.scale;
        let surface = FaceSurface::Plane(setting.of_surface());
        let corners =
            [[-2.0, -1.0], [3.0, -1.0], [3.0, 2.0], [-2.0, 2.0]].map(|[x, y]| dvec3(x, y, 0.0));
        let mut edges: Vec<_> =
            (0..4).map(|i| setting.line(corners[i], corners[(i + 1) % 4])).collect();
        edges.push(setting.circle(0.7, 0.0, TURN));
        let loops: Uses<'_> = &[&[(4, false)], &[(0, true), (1, true), (2, true), (3, true)]];
        let model = model(surface, edges, loops, [-3.0 * s, 3.0 * s, -3.0 * s, 3.0 * s]);
        check(&model, setting, 15.0 - 0.49 * PI, 0.0);
    }
}

/// A B-spline curve near an arc, and the same turned or moved as a surface, give the areas of Guldin's rule.
#[test]
fn revolutions_and_extrusions() {
    for setting in SETTINGS {
        let s = setting.scale;
        let frame = setting.frame(0.0, 0.0);
        let points = [[1.0, 0.0], [2.0, 0.5], [1.5, 2.0], [2.5, 3.0], [2.0, 4.0]];
        let knots = vec![0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0];
        let place = |[x, z]: [f64; 2]| setting.point(x, 0.0, z).extend(1.0);
        let curve = NurbsCurve::new(3, knots, points.map(place).to_vec()).unwrap();
        let bounded = BoundedCurve { curve: Curve::Nurbs(curve.clone()), range: [0.0, 1.0] };
        const STEPS: u32 = 20_000;
        let (mut length, mut turned) = (0.0, 0.0);
        for i in 0..STEPS {
            let t = (f64::from(i) + 0.5) / f64::from(STEPS);
            let [at, slope] = curve.at(t);
            let part = slope.length() / f64::from(STEPS) / s;
            length += part;
            turned += part * (at - frame.origin).dot(frame.x) / s;
        }
        let surface =
            FaceSurface::Revolution { origin: frame.origin, axis: frame.z, curve: bounded.clone() };
        let edges = || {
            vec![
                setting.circle(1.0, 0.0, TURN),
                setting.circle(2.0, 4.0, TURN),
                Some(bounded.clone()),
            ]
        };
        let bounds = [0.0, TAU, 0.0, 1.0];
        let loops: Uses<'_> = &[&[(0, true)], &[(1, false)]];
        check(&model(surface.clone(), edges(), loops, bounds), setting, TAU * turned, 0.0);
        let loops: Uses<'_> = &[&[(0, true), (2, true), (1, false), (2, false)]];
        check(&model(surface, edges(), loops, bounds), setting, TAU * turned, 0.0);

        let direction = frame.y;
        let surface = FaceSurface::Extrusion { direction, curve: bounded.clone() };
        let moved: Vec<DVec4> =
            curve.control_points().iter().map(|p| *p + (2.0 * s * direction).extend(0.0)).collect();
        let top = NurbsCurve::new(3, curve.knots().to_vec(), moved).unwrap();
        let edges = vec![
            Some(bounded),
            Some(BoundedCurve { curve: Curve::Nurbs(top), range: [0.0, 1.0] }),
            setting.line(dvec3(1.0, 0.0, 0.0), dvec3(1.0, 2.0, 0.0)),
            setting.line(dvec3(2.0, 0.0, 4.0), dvec3(2.0, 2.0, 4.0)),
        ];
        let loops: Uses<'_> = &[&[(0, true), (3, true), (1, false), (2, false)]];
        let model = model(surface, edges, loops, [0.0, 1.0, 0.0, 2.0 * s]);
        check(&model, setting, 2.0 * length, 0.0);
    }
}

/// The drawn form of an analytic surface as a surface of its own: its edges are found by search, not by formula.
#[test]
fn closed_nurbs_surfaces() {
    for setting in SETTINGS {
        let s = setting.scale;
        let cylinder = FaceSurface::Cylinder { frame: setting.of_surface(), radius: 2.0 * s };
        let edges = || {
            vec![
                setting.circle(2.0, 0.0, TURN),
                setting.circle(2.0, 3.0, TURN),
                setting.line(dvec3(2.0, 0.0, 0.0), dvec3(2.0, 0.0, 3.0)),
            ]
        };
        let bounds = [0.0, TAU, 0.0, 3.0 * s];
        let loops: Uses<'_> = &[&[(0, true)], &[(1, false)]];
        let analytic = model(cylinder, edges(), loops, [0.0, TAU, 0.0, 3.0 * s]);
        let drawn = analytic.drawn_face(0, analytic.diagonal()).unwrap().surface;
        for loops in [
            &[&[(0, true)][..], &[(1, false)]][..],
            &[&[(0, true), (2, true), (1, false), (2, false)]],
        ] {
            let model = model(FaceSurface::Nurbs(drawn.clone()), edges(), loops, bounds);
            check(&model, setting, 12.0 * PI, 0.0);
        }
        let half = [setting.seam + 1.0, setting.seam + 1.0 + PI];
        for shift in [0.0, 2.0, 4.0] {
            let half = half.map(|angle| angle + shift);
            let at = |angle: f64, z: f64| dvec3(2.0 * angle.cos(), 2.0 * angle.sin(), z);
            let edges = vec![
                setting.circle(2.0, 1.0, half),
                setting.circle(2.0, 2.0, half),
                setting.line(at(half[0], 1.0), at(half[0], 2.0)),
                setting.line(at(half[1], 1.0), at(half[1], 2.0)),
            ];
            let loops: Uses<'_> = &[&[(0, true), (3, true), (1, false), (2, false)]];
            let model = model(FaceSurface::Nurbs(drawn.clone()), edges, loops, bounds);
            check(&model, setting, 2.0 * PI, 0.0);
        }
    }
}

/// The parameters of a drawn surface at those of the face: arcs by the formula of rational quadratic curves.
fn drawn_parameter(own: f64, [low, high]: [f64; 2]) -> f64 {
    let count = ((high - low) / FRAC_PI_2 - 1e-9).ceil();
    let step = (high - low) / count;
    let arc = ((own - low) / step).floor().min(count - 1.0);
    let middle = low + (arc + 0.5) * step;
    middle + 0.5 * step * (0.5 * (own - middle)).tan() / (0.25 * step).tan()
}

#[test]
fn drawn_surfaces_are_the_surfaces() {
    let setting = SETTINGS[1];
    let frame = setting.of_surface();
    let left_handed = Frame { z: -frame.z, ..frame };
    for frame in [frame, left_handed] {
        for (surface, bounds, angles) in [
            (FaceSurface::Plane(frame), [-1.0, 2.0, 0.5, 3.0], [false, false]),
            (FaceSurface::Cylinder { frame, radius: 1.5 }, [0.3, 5.0, -1.0, 2.0], [true, false]),
            (
                FaceSurface::Cone { frame, radius: 1.5, half_angle: 0.4 },
                [-2.0, 2.0, -1.0, 2.0],
                [true, false],
            ),
            (
                FaceSurface::Sphere { frame, radius: 1.5 },
                [0.0, TAU, -FRAC_PI_2, FRAC_PI_2],
                [true; 2],
            ),
            (
                FaceSurface::Torus { frame, major_radius: 2.0, minor_radius: 0.5 },
                [1.0, 3.0, 2.0, 2.0 + TAU],
                [true; 2],
            ),
            (
                FaceSurface::Torus { frame, major_radius: 0.2, minor_radius: 0.5 },
                [1.0, 3.0, 2.0, 4.0],
                [true; 2],
            ),
        ] {
            let model = model(surface.clone(), Vec::new(), &[], bounds);
            let drawn = model.drawn_face(0, model.diagonal()).unwrap();
            assert!(drawn.trims.loops.is_empty());
            for i in 0..=20 {
                for j in 0..=20 {
                    let share = dvec2(f64::from(i), f64::from(j)) / 20.0;
                    let low = dvec2(bounds[0], bounds[2]);
                    let own: DVec2 = low + share * (dvec2(bounds[1], bounds[3]) - low);
                    let place = |axis: usize| {
                        let range = [bounds[2 * axis], bounds[2 * axis + 1]];
                        if angles[axis] { drawn_parameter(own[axis], range) } else { own[axis] }
                    };
                    let found = drawn.surface.at(place(0), place(1)).position;
                    let expected = surface.at(own.x, own.y).position;
                    assert!(found.distance(expected) < 1e-12, "{surface:?} at {own}");
                }
            }
        }
    }
}

#[test]
fn units_have_their_usual_names() {
    let of = |unit: f64| Model {
        unit,
        ..model(FaceSurface::Plane(Frame::WORLD), Vec::new(), &[], [0.0, 1.0, 0.0, 1.0])
    };
    assert_eq!([0.001, 0.0254, 0.5].map(|unit| of(unit).unit_name()), ["mm", "in", "(0.5 m)"]);
}
