//! Free-form surfaces of OBJ files: B-spline and Bézier surfaces with trimming curves. What was read is compared with
//! the definition of B-splines by Cox and de Boor, and trims with shapes that are known.

use std::fmt::Write as _;
use std::path::Path;

use freeform_surface::{LoadOptions, Result, Scene, Surface, Trims};
use glam::{DVec2, DVec3, DVec4, dvec2, dvec3, dvec4};

pub(super) fn scene(text: &str) -> Result<Scene> {
    // The text decides that it is OBJ; it begins with a statement.
    Scene::from_text(text, Path::new("x.obj"), &LoadOptions::default())
}

pub(super) fn read(text: &str) -> Scene {
    scene(text).unwrap_or_else(|error| panic!("{error}"))
}

/// The B-spline basis function by its recursive definition. The last span includes its end.
fn basis(i: usize, degree: usize, knots: &[f64], t: f64) -> f64 {
    if degree == 0 {
        let is_last = knots[i + 1..].iter().all(|knot| *knot == knots[i + 1]);
        let is_in = knots[i] <= t && (t < knots[i + 1] || (is_last && t == knots[i + 1]));
        return f64::from(u8::from(is_in && knots[i] < knots[i + 1]));
    }
    let share = |from: usize, to: usize, over: f64| {
        if knots[to] > knots[from] { over / (knots[to] - knots[from]) } else { 0.0 }
    };
    share(i, i + degree, t - knots[i]) * basis(i, degree - 1, knots, t)
        + share(i + 1, i + degree + 1, knots[i + degree + 1] - t)
            * basis(i + 1, degree - 1, knots, t)
}

/// The point of a surface of control points (x, y, z, weight), with u along a row.
fn point(
    degrees: [usize; 2],
    [along_u, along_v]: [&[f64]; 2],
    points: &[DVec4],
    u: f64,
    v: f64,
) -> DVec3 {
    let columns = along_u.len() - degrees[0] - 1;
    let mut sum = DVec4::ZERO;
    for (i, point) in points.iter().enumerate() {
        let factor = basis(i % columns, degrees[0], along_u, u)
            * basis(i / columns, degrees[1], along_v, v)
            * point.w;
        sum += point.truncate().extend(1.0) * factor;
    }
    sum.truncate() / sum.w
}

/// The point of a curve of control points (u, v, weight).
fn curve_point(degree: usize, knots: &[f64], points: &[DVec3], t: f64) -> DVec2 {
    let sum: DVec3 = (0..points.len())
        .map(|i| {
            let factor = basis(i, degree, knots, t) * points[i].z;
            points[i].truncate().extend(1.0) * factor
        })
        .sum();
    sum.truncate() / sum.z
}

/// Compares the patches of a surface, which are what is drawn, at 8 × 8 places each.
fn assert_is(
    surface: &Surface,
    degrees: [usize; 2],
    knots: [&[f64]; 2],
    points: &[DVec4],
    spans: usize,
) {
    assert_eq!(surface.patches().len(), spans);
    assert_eq!([surface.degree().u(), surface.degree().v()], degrees);
    for (number, patch) in surface.patches().enumerate() {
        let [low, high] = surface.patch_domain(number);
        for i in 0..64 {
            // Knots lie between spans, where the definition may take either.
            let share = dvec2(f64::from(i % 8), f64::from(i / 8)) / 7.001;
            let place = low + share * (high - low);
            let expected = point(degrees, knots, points, place.x, place.y);
            let found = patch.at(share.x, share.y).position;
            assert!(
                found.distance(expected) < 1e-13,
                "patch {number}, {share}: {found} {expected}"
            );
        }
    }
}

/// Checks where a surface is cut, at 101 × 101 places of its domain that are further from a border than 1e-6.
fn assert_cut(surface: &Surface, is_kept: impl Fn(DVec2) -> bool) {
    let [low, high] = surface.domain();
    let [mut kept, mut cut] = [0, 0];
    for i in 0..101 * 101 {
        let share = (dvec2(f64::from(i % 101), f64::from(i / 101)) + 0.123) / 101.2;
        let place = low + share * (high - low);
        let expected = is_kept(place);
        let near = [(1, 0), (-1, 0), (0, 1), (0, -1)]
            .map(|(x, y)| place + 1e-6 * dvec2(f64::from(x), f64::from(y)));
        if near.iter().any(|near| is_kept(*near) != expected) {
            continue;
        }
        assert_eq!(surface.trims.cut(place), !expected, "{place}");
        if expected { kept += 1 } else { cut += 1 }
    }
    assert!(kept > 50 && cut > 50, "{kept} kept, {cut} cut");
}

pub(super) fn words(values: &[f64]) -> String {
    values.iter().map(|value| format!(" {value:?}")).collect()
}

/// A net whose height is not planar, as statements and as points; u varies fastest.
fn net(columns: usize, rows: usize, weight: impl Fn(usize) -> f64) -> (String, Vec<DVec4>) {
    let mut text = String::new();
    let mut points = Vec::new();
    for i in 0..columns * rows {
        let (x, y) = ((i % columns) as f64, (i / columns) as f64);
        let point = dvec4(x, y, (x * 1.3).sin() + 0.2 * y * x, weight(i));
        writeln!(text, "v{}", words(&point.to_array())).unwrap();
        points.push(point);
    }
    (text, points)
}

fn numbers(range: std::ops::RangeInclusive<usize>) -> String {
    range.map(|i| i.to_string()).collect::<Vec<_>>().join(" ")
}

/// A circle as a rational B-spline curve of degree 2 over [0, 4].
fn circle(center: DVec2, radius: f64) -> Vec<DVec3> {
    let corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)];
    let corner = |(i, (x, y)): (usize, (i32, i32))| {
        let weight = if i % 2 == 0 { 1.0 } else { std::f64::consts::FRAC_1_SQRT_2 };
        (center + radius * dvec2(f64::from(x), f64::from(y))).extend(weight)
    };
    corners.into_iter().enumerate().map(corner).collect()
}

const CIRCLE_KNOTS: [f64; 12] = [0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0, 4.0, 4.0, 4.0];
const ON_CIRCLE: &str = "parm u 0 0 0 1 1 2 2 3 3 4 4 4\nend\n";

fn vertices(points: &[DVec3]) -> String {
    points.iter().map(|point| format!("vp{}\n", words(&point.to_array()))).collect()
}

/// A flat surface over [0, 1]², without `end`, after which trims may follow. Its points are the last four.
pub(super) const SHEET: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\ncstype bspline\ndeg 1 1\nsurf 0 1 0 1 -4 -3 -2 -1\n\
    parm u 0 0 1 1\nparm v 0 0 1 1\n";

#[test]
fn a_b_spline_surface_with_a_border_and_a_hole() {
    // As Rhino writes it: curves of lines for the border, a rational curve for the hole, texture and normals in surf.
    let (net, points) = net(6, 5, |_| 1.0);
    let u = [0.0, 0.0, 0.0, 0.0, 4.0, 7.0, 10.0, 10.0, 10.0, 10.0];
    let v = [-2.0, -2.0, -2.0, -2.0, 0.5, 3.0, 3.0, 3.0, 3.0];
    let corners = [dvec2(1.0, -1.5), dvec2(9.0, -1.0), dvec2(8.0, 2.5), dvec2(2.0, 2.0)];
    let mut text = format!("# Rhino\n\n{net}vt 0 0\nvn 0 0 1\ncstype bspline\ndeg 1\n");
    for (i, corner) in corners.iter().enumerate() {
        let next = corners[(i + 1) % 4];
        let line = [*corner, next].map(|end| end.extend(1.0));
        text += &format!("{}curv2 -2 -1\nparm u 0 0 2.5 2.5\nend\n", vertices(&line));
    }
    let center = dvec2(5.0, 0.5);
    text += &vertices(&circle(center, 1.0));
    text += &format!("cstype rat bspline\ndeg 2\ncurv2 {}\n{ON_CIRCLE}", numbers(9..=17));
    let corner =
        |i: usize| ["", "/1", "//1", "/1/1"].map(|rest| format!("{i}{rest}"))[i % 4].clone();
    let indices: Vec<String> = (1..=30).map(corner).collect();
    text += &format!(
        "cstype bspline\ndeg 3 3\nsurf 0 10 -2 3 {}\nparm u{}\nparm v{}\n",
        indices.join(" "),
        words(&u),
        words(&v)
    );
    text += "trim 0 2.5 1 0 2.5 2 \\\n0 2.5 3 0 2.5 4\nhole 0 4 5\nend\n";
    let scene = read(&text[8..]);
    let [surface] = &scene.surfaces[..] else { panic!("{} surfaces", scene.surfaces.len()) };
    assert_eq!(surface.domain(), [dvec2(0.0, -2.0), dvec2(10.0, 3.0)]);
    assert_is(surface, [3, 3], [&u, &v], &points, 6);
    let in_border = |place: DVec2| {
        (0..4).all(|i| (corners[(i + 1) % 4] - corners[i]).perp_dot(place - corners[i]) > 0.0)
    };
    assert_cut(surface, |place| in_border(place) && place.distance(center) > 1.0);
}

#[test]
fn rational_surfaces_beside_polygons() {
    // As Maya writes it: negative indices, groups, continued lines; a quarter of a cylinder and one of a cone.
    let weight = std::f64::consts::FRAC_1_SQRT_2;
    let quarter = |radii: [f64; 2]| -> String {
        let rows = radii.iter().zip([0.0, 2.0]);
        rows.map(|(r, z)| format!("v {r} 0 {z} 1\nv {r} {r} {z} {weight}\nv 0 {r} {z} 1\n"))
            .collect()
    };
    let surf = "cstype rat bspline\ndeg 2 1\nsurf 0 1 0 2 -6 -5 -4 \\\n-3 -2 -1\nparm u 0 0 0 \\\n1 1 1\n\
        parm v 0 0 2 2\nend\n";
    let text = format!(
        "g cylinder\n{}{surf}g square\nv 5 0 0\nv 6 0 0\nv 6 1 0\nv 5 1 0\nusemtl lambert1\nf -4 -3 -2 -1\n\
         g cone\n{}{surf}f 13 14 15\n",
        quarter([1.0, 1.0]),
        quarter([1.0, 0.5])
    );
    let scene = read(&text);
    assert_eq!((scene.surfaces.len(), scene.meshes.len()), (2, 1));
    assert_eq!(scene.meshes[0].mesh().mesh().triangles().len(), 3);
    for (surface, end) in scene.surfaces.iter().zip([1.0, 0.5]) {
        let nurbs = surface.nurbs().unwrap();
        assert_eq!(surface.trims, Trims::default());
        for i in 0..121 {
            let (u, v) = (f64::from(i % 11) / 10.0, f64::from(i / 11) / 5.0);
            let on = nurbs.at(u, v).position;
            let radius = 1.0 + (end - 1.0) * v / 2.0;
            assert!((on.truncate().length() - radius).abs() < 1e-14 && (on.z - v).abs() < 1e-14);
        }
    }
    // Weights do not count where the surface is not rational.
    let plain = read(&text.replace("rat bspline", "bspline"));
    assert!(
        plain.surfaces.iter().all(|one| one.control_points().iter().all(|point| point.w == 1.0))
    );
}

#[test]
fn unclamped_surfaces_and_many_weights() {
    let (net, points) = net(7, 5, |i| 1.0 + (i % 3) as f64);
    let u: Vec<f64> = (0..11).map(f64::from).collect();
    let v = [0.0, 0.1, 0.1, 0.5, 0.5, 0.75, 1.0, 2.0];
    let text = format!(
        "{net}cstype rat bspline\ndeg 3 2\nsurf 3 7 0.1 0.75 {}\nparm v{}\nparm u{}\nend\n",
        numbers(1..=35),
        words(&v),
        words(&u)
    );
    let scene = read(&text);
    assert_is(&scene.surfaces[0], [3, 2], [&u, &v], &points, 4 * 2);
    assert_eq!(scene.surfaces[0].trims, Trims::default());
}

#[test]
fn bezier_surfaces_of_several_patches_have_their_parameters() {
    let (net, points) = net(7, 3, |i| 1.0 + (i % 4) as f64);
    let text = format!(
        "{net}cstype rat bezier\ndeg 3 2\nsurf -1 5 0 1 {}\nparm u -1 0.5 5\nparm v 0 1\nend\n",
        numbers(1..=21)
    );
    let scene = read(&text);
    let surface = &scene.surfaces[0];
    assert_eq!(surface.domain(), [dvec2(-1.0, 0.0), dvec2(5.0, 1.0)]);
    let u = [-1.0, -1.0, -1.0, -1.0, 0.5, 0.5, 0.5, 5.0, 5.0, 5.0, 5.0];
    assert_is(surface, [3, 2], [&u, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]], &points, 2);
}

#[test]
fn a_bezier_patch_is_a_nurbs_surface_only_if_it_must_be() {
    let patch =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\ncstype bezier\ndeg 1 1\nsurf 0 1 0 1 1 2 3 4\n";
    let vertices =
        "vp 0 0\nvp 1 0\nvp 0 1\ncstype bezier\ndeg 1\ncurv2 1 2 3 1\nparm u 0 1 2 3\nend\n";
    for (text, is_nurbs) in [
        (format!("{patch}end\n"), false),
        (format!("{patch}parm u 0 1\nparm v 0 1\nend\n"), false),
        (format!("{patch}parm u 0 2\nparm v 0 1\nend\n"), true),
        (format!("{}end\n", patch.replace("surf 0 1", "surf 0 0.5")), true),
        (format!("{vertices}{patch}trim 0 3 1\nend\n"), true),
    ] {
        let scene = read(&text);
        assert_eq!(scene.surfaces[0].nurbs().is_some(), is_nurbs, "{text}");
        assert_eq!(scene.surfaces[0].patches().len(), 1);
    }
    let trimmed = read(&format!("{vertices}{patch}trim 0 3 1\nend\n"));
    assert_cut(&trimmed.surfaces[0], |place| place.x + place.y < 1.0);
    // Patches share a surface and come first; other surfaces are in the order of the file.
    let many = read(&format!("{patch}parm u 0 2\nend\n{}{}", &patch[32..], "end\n").repeat(3));
    let counts: Vec<usize> = many.surfaces.iter().map(|surface| surface.patches().len()).collect();
    assert_eq!(counts, [3, 1, 1, 1]);
}

#[test]
fn parts_of_curves_are_taken_in_either_direction() {
    let center = dvec2(0.5, 0.4);
    let round = circle(center, 0.3);
    let at = |t: f64| curve_point(2, &CIRCLE_KNOTS, &round, t);
    let start = vertices(&round)
        + "cstype rat bspline\ndeg 2\ncurv2 -9 -8 -7 -6 -5 -4 -3 -2 -1\n"
        + ON_CIRCLE;
    for [from, to] in [[0.0, 2.0], [0.5, 2.75], [1.0, 1.625], [3.25, 3.75], [0.0, 4.0 - 1e-9]] {
        let chord = [at(to), at(from)].map(|end| end.extend(1.0));
        let line = vertices(&chord) + "cstype bspline\ndeg 1\ncurv2 -2 -1\nparm u 0 0 1 1\nend\n";
        let is_kept = |place: DVec2| {
            let [a, b] = [at(from), at(to)];
            place.distance(center) < 0.3 && (b - a).perp_dot(place - a) < 1e-9
        };
        for trim in [
            format!("trim {from} {to} 1 0 1 2"),
            format!("trim {to} {from} 1 1 0 2"),
            format!("trim 1 0 -1 {to} {from} -2"),
        ] {
            let scene = read(&format!("{start}{line}{SHEET}{trim}\nend\n"));
            if to - from > 0.6 {
                assert_cut(&scene.surfaces[0], is_kept);
            }
            // The middle of the arc, just within and just beyond.
            let middle = at(0.5 * (from + to)) - center;
            for (by, cut) in [(1.0 - 1e-6, false), (1.0 + 1e-6, true)] {
                assert_eq!(scene.surfaces[0].trims.cut(center + by * middle), cut, "{trim}");
            }
        }
    }
    // Of a curve that is neither clamped nor closed, between knots.
    let knots: Vec<f64> = (0..12).map(|i| f64::from(i) * 0.5).collect();
    let points: Vec<DVec3> = (0..8)
        .map(|i| dvec3(0.1 * f64::from(i) + 0.1, 0.5 + 0.3 * (f64::from(i) * 1.9).sin(), 1.0))
        .collect();
    let (from, to) = (1.7, 3.8);
    let at = |t: f64| curve_point(3, &knots, &points, t);
    let below = [at(to), dvec2(at(to).x, 0.0), dvec2(at(from).x, 0.0), at(from)];
    let text = format!(
        "{}cstype bspline\ndeg 3\ncurv2 {}\nparm u{}\nend\n{}deg 1\ncurv2 9 10 11 12\nparm u 0 0 1 2 3 3\nend\n{SHEET}\
         trim {from} {to} 1 0 3 2\nend\n",
        vertices(&points),
        numbers(1..=8),
        words(&knots),
        vertices(&below.map(|end| end.extend(1.0)))
    );
    let scene = read(&text);
    assert_cut(&scene.surfaces[0], |place| {
        // u rises along the curve, so that its height over a u is found by bisection.
        let [mut low, mut high] = [from, to];
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if at(middle).x < place.x { low = middle } else { high = middle }
        }
        at(from).x < place.x && place.x < at(to).x && place.y < at(low).y
    });
}

#[test]
fn holes_alone_leave_the_border_and_several_borders_are_several_regions() {
    let mut text = String::from("cstype bezier\ndeg 1\n");
    let boxes = [[0.1, 0.1, 0.5], [0.6, 0.1, 0.3], [0.2, 0.2, 0.2]];
    for [u, v, size] in boxes {
        // The weight 0 does not count, because the curve is not rational.
        text += &format!(
            "vp {u} {v} 0\nvp {} {v} 0\nvp {} {} 0\nvp {u} {} 0\ncurv2 -4 -3 -2 -1 -4\nparm u 0 1 2 3 4\nend\n",
            u + size,
            u + size,
            v + size,
            v + size
        );
    }
    let inside = |i: usize, place: DVec2| {
        let [u, v, size] = boxes[i];
        place.x > u && place.x < u + size && place.y > v && place.y < v + size
    };
    let surface = |trims: &str| read(&format!("{text}{SHEET}{trims}\nend\n")).surfaces.remove(0);
    assert_cut(&surface("hole 0 4 1\nhole 0 4 2"), |at| !inside(0, at) && !inside(1, at));
    assert_cut(&surface("trim 0 4 1\nhole 0 4 3\ntrim 0 4 2"), |at| {
        (inside(0, at) && !inside(2, at)) || inside(1, at)
    });
    // A hole before the first border is cut out of the whole domain; a border in it is an island.
    assert_cut(&surface("hole 0 4 1\ntrim 0 4 3"), |at| !inside(0, at) || inside(2, at));
    // Where a border is left out, holes are cut out of the whole domain.
    let unsupported = "cstype cardinal\ndeg 3\ncurv2 1 2 3 4\nparm u 0 1\nend\ncstype bezier\n";
    let trims = "trim 0 1 4\nhole 0 4 3\ntrim 0 4 2";
    let text = format!("{text}{unsupported}{SHEET}{trims}\nend\n");
    assert_cut(&read(&text).surfaces[0], |at| !inside(2, at));
}

#[test]
fn a_smaller_range_leaves_that_part() {
    let text = |range: &str, trims: &str| {
        let knots = "parm u 0 0 1 2 4 4\nparm v 1 1 2 2";
        format!(
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 4 0 0\nv 0 1 0\nv 1 1 0\nv 2 1 0\nv 4 1 0\nvp 0.5 1\nvp 3.5 1\nvp 0.5 2\n\
             cstype bspline\ndeg 1\ncurv2 1 2 3 1\nparm u 0 0 1 2 3 3\nend\n\
             deg 1 1\nsurf {range} 1 2 3 4 5 6 7 8\n{knots}\n{trims}end\n"
        )
    };
    for trims in ["", "trim 0 3 1\n"] {
        let scene = read(&text("0.75 2 1.25 3", trims));
        let surface = &scene.surfaces[0];
        let in_trim = |at: DVec2| trims.is_empty() || at.x < 0.5 + 3.0 * (2.0 - at.y);
        assert_cut(surface, |at| at.x > 0.75 && at.x < 2.0 && at.y > 1.25 && in_trim(at));
        assert!(
            !surface.trims.shapes_cut(dvec2(0.75, 1.25))
                && !surface.trims.shapes_cut(dvec2(2.0, 2.0))
        );
    }
    // The domain's ends with few digits, and beyond.
    for range in ["0 4 1 2", "0.000001 3.999999 1 2", "-10 10 0.5 7"] {
        assert_eq!(read(&text(range, "")).surfaces[0].trims, Trims::default(), "{range}");
    }
}

#[test]
fn small_gaps_between_trimming_curves_are_closed() {
    let border = |gap: f64| {
        format!(
            "vp 0.2 0.2\nvp 0.8 0.2\nvp 0.8 {}\nvp 0.2 0.8\ncstype bezier\ndeg 1\ncurv2 1 2\nend\ncurv2 3 4\nend\n\
             curv2 4 1\nend\n{SHEET}trim 0 1 1 0 1 2 0 1 3\nend\n",
            0.2 + gap
        )
    };
    for (gap, segments) in [(0.0, 3), (9e-7, 3), (1e-5, 4), (9e-4, 4)] {
        let scene = read(&border(gap));
        let [trim_loop] = &scene.surfaces[0].trims.loops[..] else { panic!("one loop") };
        assert_eq!(trim_loop.segments().len(), segments, "{gap}");
        let edge = |at: DVec2| at.y - 0.2 - gap < (0.6 - gap) * (0.8 - at.x) / 0.6;
        assert_cut(&scene.surfaces[0], |at| at.x > 0.2 && at.y > 0.2 && at.x < 0.8 && edge(at));
    }
    let text = scene(&border(1.1e-3)).unwrap_err().to_string();
    assert!(
        text.starts_with(
            "x.obj:22: trim: gap between the end of curve 0 and the start of curve 1 is 0.001099"
        ),
        "{text}"
    );
}

#[test]
fn surfaces_that_do_not_fit_in_a_scene_are_written_as_obj_files() {
    let folder = tempfile::tempdir().unwrap();
    let uneven = |i: usize| 1.0 / (1.0 + (i % 7) as f64);
    let (patches, _) = net(4, 8, uneven);
    let surf = "surf 0 1 0 1";
    let patches = format!(
        "{patches}cstype rat bezier\ndeg 3 3\n{surf} {}\nend\n{surf} {}\nend\n",
        numbers(1..=16),
        numbers(17..=32)
    );
    let large = |weight: fn(usize) -> f64| {
        let side = 100;
        let (net, _) = net(side, side, weight);
        let knots: Vec<f64> = (0..side + 4).map(|i| (i as f64).sqrt() / 3.0).collect();
        let range = format!("{:?} {:?}", knots[3], knots[side]);
        format!(
            "{net}cstype rat bspline\ndeg 3 3\nsurf {range} {range} {}\nparm u{knots}\nparm v{knots}\n",
            numbers(1..=side * side),
            knots = words(&knots)
        )
    };
    let triangle =
        "vp 1 1\nvp 2 1\nvp 1 2\ncstype bezier\ndeg 1\ncurv2 1 2 3 1\nparm u 0 1 2 3\nend\n";
    let trimmed = format!("{triangle}{}trim 0 3 1\nend\n", large(uneven));
    let all =
        [patches, format!("{}end\n", large(uneven)), format!("{}end\n", large(|_| 1.0)), trimmed];
    for (i, text) in all.iter().enumerate() {
        let scene = read(text);
        let path = folder.path().join(format!("written{i}.toml"));
        let written = scene.to_toml(&path).unwrap();
        let [(name, bytes)] = &written.files[..] else { panic!("{} files", written.files.len()) };
        assert!(name.ends_with(format!("written{i}-1.obj")), "{name:?}");
        std::fs::write(name, bytes).unwrap();
        let again = Scene::from_toml(&written.text, &path).unwrap();
        assert!(again.surfaces == scene.surfaces, "{i}");
        // The file that was written is named when the scene is written again.
        let twice = again.to_toml(&path).unwrap();
        assert_eq!((&twice.text, twice.files.len()), (&written.text, 0));
    }
    // A file that has trims of its own is not named: they are written beside their surface.
    let path = folder.path().join("trimmed.obj");
    std::fs::write(&path, &all[3]).unwrap();
    assert_eq!(Scene::load(&path).unwrap().to_toml(&path).unwrap().files.len(), 1);
}
