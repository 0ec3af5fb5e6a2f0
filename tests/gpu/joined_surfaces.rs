//! Surfaces that meet along a border or a trim without being neighbours: no background shows between them, and nothing
//! grows where they do not meet. What they cover is known from the reference in `f64`.

use freeform_surface::inspect::homogeneous;
use freeform_surface::inspect::reference::{Cover, Coverage, coverage};
use freeform_surface::{
    Camera, Circle, Degree, Image, Keep, Lens, Method, NurbsSurface, Paint, Scene, Segment,
    Surface, TrimLoop,
};
use glam::{DMat4, DVec2, DVec3, DVec4, UVec2, dvec2, dvec3, uvec2};

use crate::harness::Stage;
use crate::harness::patches::{turned, within};

const SIZE: UVec2 = uvec2(320, 240);

/// The common border: a rational cubic that bends in all directions.
fn border() -> [DVec4; 4] {
    [
        DVec4::new(-1.0, 0.0, 0.0, 1.0),
        DVec4::new(-0.4, 0.5, 0.8, 1.5),
        DVec4::new(0.3, -0.6, 0.9, 0.8),
        DVec4::new(1.0, 0.1, -0.1, 1.2),
    ]
}

/// The net over a border of any degree: rows that leave it along y, and sink.
fn net(border: &[DVec4], along_y: f64) -> Vec<DVec4> {
    let row = |j: i32| {
        let j = f64::from(j);
        let step = dvec3(0.05 * j, 0.3 * j * along_y, -0.12 * j * j).extend(0.0);
        border.iter().map(move |point| *point + step)
    };
    (0..4).flat_map(row).collect()
}

fn projected(point: DVec4) -> DVec4 {
    (point.truncate() / point.w).extend(point.w)
}

/// The same curve with a degree more.
fn raised(curve: &[DVec4]) -> Vec<DVec4> {
    let n = curve.len();
    let at = |i: usize| curve.get(i).map_or(DVec4::ZERO, |point| homogeneous(*point));
    let share = |i: usize| i as f64 / n as f64;
    let point = |i: usize| at(i.wrapping_sub(1)) * share(i) + at(i) * (1.0 - share(i));
    (0..=n).map(|i| projected(point(i))).collect()
}

/// The parts of a curve before and behind a parameter.
fn halves(curve: &[DVec4], t: f64) -> [Vec<DVec4>; 2] {
    let mut line: Vec<DVec4> = curve.iter().map(|point| homogeneous(*point)).collect();
    let (mut low, mut high) = (vec![], vec![]);
    while !line.is_empty() {
        low.push(projected(line[0]));
        high.insert(0, projected(line[line.len() - 1]));
        line = line.windows(2).map(|pair| pair[0].lerp(pair[1], t)).collect();
    }
    [low, high]
}

fn patch(border: &[DVec4], along_y: f64) -> Surface {
    let degree = Degree::new(border.len() - 1, 3).unwrap();
    Surface::new(degree, net(border, along_y)).unwrap()
}

/// The surface in the same place with another transform.
fn moved(surface: &Surface, transform: DMat4) -> Surface {
    let back = transform.inverse();
    let points = surface.control_points().iter();
    let points = points.map(|point| back.transform_point3(point.truncate()).extend(point.w));
    let mut result = Surface::new(surface.degree(), points.collect()).unwrap();
    result.trims = surface.trims.clone();
    result.transform = transform;
    result
}

fn scene_of(surfaces: Vec<Surface>, tolerance: f64) -> Scene {
    Scene { surfaces, settings: within(tolerance), ..Scene::default() }
}

/// The scene from several directions.
fn views(scene: &Scene) -> impl Iterator<Item = Scene> + '_ {
    (0..8).map(|i| {
        let angle = 0.3 + f64::from(i) * std::f64::consts::FRAC_PI_4;
        let lens = match i % 2 {
            0 => Lens::Perspective { fov_y_radians: 0.6 },
            _ => Lens::Orthographic { height: 1.0 + 0.2 * f64::from(i) },
        };
        let eye = dvec3(1.5 * angle.cos(), 1.5 * angle.sin(), 3.5);
        let camera = Camera::new(eye, dvec3(0.0, 0.0, 0.2), DVec3::Y, lens).unwrap();
        Scene { camera: Some(camera), ..scene.clone() }
    })
}

fn with_joins(scene: &Scene, join: bool) -> Scene {
    let mut scene = scene.clone();
    scene.surfaces.iter_mut().for_each(|surface| surface.join = join);
    scene
}

fn reference(scene: &Scene) -> Coverage {
    coverage(scene, &scene.projection(SIZE.x, SIZE.y), SIZE, Method::Exact).unwrap()
}

/// Pixels without a surface, though all pixels within three pixels have one.
fn open_pixels(picture: &Image, reference: &Coverage) -> usize {
    const AROUND: i32 = 3;
    let at = |x: i32, y: i32| {
        let is_within = (0..SIZE.x as i32).contains(&x) && (0..SIZE.y as i32).contains(&y);
        !is_within || reference.pixels[(y * SIZE.x as i32 + x) as usize].covered()
    };
    let is_inner =
        |x: i32, y: i32| (-AROUND..=AROUND).all(|j| (-AROUND..=AROUND).all(|i| at(x + i, y + j)));
    let pixels = picture.enumerate_pixels();
    pixels.filter(|(x, y, pixel)| pixel.0[3] == 0 && is_inner(*x as i32, *y as i32)).count()
}

/// Fails unless the background shows between the surfaces without joints and does not with them.
fn check_closed(stage: &mut Stage, name: &str, surfaces: Vec<Surface>) {
    let mut open = [0; 2];
    for view in views(&scene_of(surfaces, 2.0)) {
        let expected = reference(&view);
        for join in [false, true] {
            let picture = stage.render(&with_joins(&view, join));
            open[usize::from(join)] += open_pixels(&picture, &expected);
        }
    }
    assert!(open[0] > 0 && open[1] == 0, "{name}: {open:?} open pixels without and with joints");
}

#[test]
fn borders_that_are_one_curve_are_closed() {
    let mut stage = Stage::new(SIZE);
    let border = border();
    let one = || patch(&border, 1.0);
    let raised = raised(&border);
    let weighted = |factor: f64, points: &[DVec4]| -> Vec<DVec4> {
        points.iter().map(|point| point.truncate().extend(factor * point.w)).collect()
    };
    let [low, high] = halves(&border, 0.3);
    let place = DMat4::from_translation(dvec3(0.3, -0.2, 0.1))
        * DMat4::from_rotation_y(0.7)
        * DMat4::from_scale(DVec3::splat(0.37));
    let knots = |inner: f64| {
        let ends = |value: f64, count: usize| std::iter::repeat_n(value, count);
        ends(0.0, 4).chain(ends(inner, 3)).chain(ends(1.0, 4)).collect::<Vec<f64>>()
    };
    let bezier = vec![0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0];
    // Both halves of the curve as one NURBS surface.
    let factor = low[3].w / high[0].w;
    let joined: Vec<DVec4> = low.iter().copied().chain(weighted(factor, &high[1..])).collect();
    let nurbs = NurbsSurface::new(Degree::CUBIC, [knots(2.0 / 3.0), bezier], net(&joined, -1.0));
    let nurbs = Surface::from_nurbs(nurbs.unwrap());
    let mirrored = DMat4::from_scale(dvec3(-1.0, 1.0, 1.0));
    for (name, others) in [
        ("a factor of the weights", vec![patch(&weighted(3.7, &border), -1.0)]),
        ("another degree and a factor", vec![patch(&weighted(0.31, &raised), -1.0)]),
        ("other knots", vec![nurbs]),
        ("another transform", vec![moved(&patch(&border, -1.0), place)]),
        ("mirrored", vec![moved(&patch(&raised, -1.0), mirrored)]),
        ("two parts", vec![patch(&low, -1.0), moved(&patch(&high, -1.0), place)]),
    ] {
        for turn in [0, 3, 6] {
            let others = others.iter().map(|other| {
                if other.nurbs().is_some() {
                    return other.clone();
                }
                let (degree, points) = turned(other.degree(), other.control_points(), turn);
                let mut turned = Surface::new(degree, points).unwrap();
                turned.transform = other.transform;
                turned
            });
            check_closed(&mut stage, name, std::iter::once(one()).chain(others).collect());
        }
    }
}

/// A hill with a round trim, and what is needed to fill it.
fn hill() -> Surface {
    let height = |i: usize| if [5, 6, 9, 10].contains(&i) { 1.4 } else { 0.1 * (i % 3) as f64 };
    let at = |i: usize| dvec2((i % 4) as f64, (i / 4) as f64) * (2.0 / 3.0) - 1.0;
    let points = (0..16).map(|i| at(i).extend(height(i)).extend(1.0)).collect();
    Surface::new(Degree::CUBIC, points).unwrap()
}

/// A round loop of four cubics, or with (u, v) swapped.
fn round(swapped: bool) -> TrimLoop {
    let corners = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)].map(|(x, y)| dvec2(x, y));
    let quarter = |i: usize| {
        let (from, to): (DVec2, DVec2) = (corners[i], corners[(i + 1) % 4]);
        let points = [from, from + 0.55 * to, to + 0.55 * from, to];
        let place = |point: DVec2| {
            let place = dvec2(0.45, 0.55) + 0.3 * point;
            if swapped { dvec2(place.y, place.x) } else { place }
        };
        Segment::Cubic(points.map(place))
    };
    TrimLoop::new((0..4).map(quarter).collect()).unwrap()
}

#[test]
fn a_disc_fills_a_hole() {
    let mut stage = Stage::new(SIZE);
    let mut with_hole = hill();
    with_hole.trims.add_loop(round(false)).unwrap();
    let (degree, points) = turned(Degree::CUBIC, hill().control_points(), 4);
    let mut disc = Surface::new(degree, points.clone()).unwrap();
    disc.trims.add_loop(round(true)).unwrap();
    disc.trims.keep = Keep::Inside;
    let place = DMat4::from_rotation_x(0.4) * DMat4::from_scale(DVec3::splat(2.3));
    check_closed(&mut stage, "a loop", vec![with_hole, moved(&disc, place)]);
    // An exact circle, and one of cubics.
    let mut with_hole = hill();
    with_hole.trims.circles.push(Circle::new(dvec2(0.5, 0.5), 0.3).unwrap());
    let mut disc = Surface::new(degree, points).unwrap();
    let circle = "M 0.8 0.5 A 0.3 0.3 0 0 1 0.2 0.5 A 0.3 0.3 0 0 1 0.8 0.5 Z";
    for of_path in TrimLoop::from_svg_path(circle).unwrap() {
        disc.trims.add_loop(of_path).unwrap();
    }
    disc.trims.keep = Keep::Inside;
    check_closed(&mut stage, "a circle", vec![with_hole, moved(&disc, place)]);
}

#[test]
fn nothing_grows_where_surfaces_do_not_meet() {
    let mut stage = Stage::new(SIZE);
    let place = DMat4::from_translation(dvec3(0.0, 0.0, 1e-3));
    // Beside each other without touching.
    let mut away = moved(&patch(&border(), -1.0), DMat4::from_rotation_y(0.7));
    away.transform = place * away.transform;
    for view in views(&scene_of(vec![patch(&border(), 1.0), away], 2.0)) {
        let [apart, joined] = [false, true].map(|join| stage.render(&with_joins(&view, join)));
        assert!(apart == joined);
    }
    // Joined along one border: the others end where they did. A hole across the border stays open.
    let mut one = patch(&border(), 1.0);
    one.trims.circles.push(Circle::new(dvec2(0.5, 0.0), 0.2).unwrap());
    let mut other = patch(&border(), -1.0);
    other.trims.circles.push(Circle::new(dvec2(0.5, 0.0), 0.2).unwrap());
    let other = moved(&other, DMat4::from_rotation_y(0.7));
    let mut background = 0;
    for view in views(&scene_of(vec![one, other], 0.5)) {
        let expected = reference(&view);
        let picture = stage.render(&view);
        for (pixel, cover) in picture.pixels().zip(&expected.pixels) {
            assert!(pixel.0[3] == 0 || *cover != Cover::Background);
            background += usize::from(*cover == Cover::Background);
        }
        assert_eq!(open_pixels(&picture, &expected), 0);
    }
    assert!(background > 50_000);
}

#[test]
fn joints_have_the_colours_and_places_of_their_surfaces() {
    let mut stage = Stage::new(SIZE);
    // Two patches of one surface, the second of which is joined, under a picture of one colour.
    let mut points = patch(&border(), 1.0).control_points().to_vec();
    points.iter_mut().for_each(|point| point.x += 5.0);
    points.extend(net(&border(), 1.0));
    let mut one = Surface::new(Degree::CUBIC, points).unwrap();
    one.paint = Paint::Texture(Image::from_pixel(4, 4, image::Rgba([10, 200, 30, 255])).into());
    let mut other = moved(&patch(&border(), -1.0), DMat4::from_rotation_y(0.7));
    other.paint = Paint::Color([10.0 / 255.0, 200.0 / 255.0, 30.0 / 255.0]);
    let mut scene = scene_of(vec![one, other], 2.0);
    scene.surfaces.iter_mut().for_each(|s| s.shading = freeform_surface::Shading::Unlit);
    for view in views(&scene) {
        let picture = stage.render(&view);
        let colors = picture.pixels().filter(|pixel| pixel.0[3] > 0);
        colors.for_each(|pixel| assert_eq!(pixel.0, [10, 200, 30, 255]));
        let mut prepared = stage.prepared(&view);
        let frame = stage.frame(&view);
        let aovs = stage.aovs(&mut prepared, &frame);
        for (uv, position) in aovs.uv.iter().zip(&aovs.position).filter(|(uv, _)| uv[3] > 0.0) {
            let patch = uv[2] as usize;
            let surface = &view.surfaces[patch / 2];
            let point = surface.at(patch % 2, uv[0].into(), uv[1].into()).position;
            let point = surface.transform.transform_point3(point);
            let drawn = DVec3::from_array([0, 1, 2].map(|i| f64::from(position[i])));
            assert!(point.distance(drawn) < 0.03, "{uv:?}: {point} {drawn}");
        }
    }
}
