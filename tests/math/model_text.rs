//! The text format of models: what is written is read back, and faults are named with their lines.

use std::path::Path;

use freeform_surface::glam::{DAffine3, DMat3, DVec2, DVec3, DVec4};
use freeform_surface::model::{
    BoundedCurve, Coedge, Curve, Edge, Face, FaceSurface, Frame, Model, NurbsCurve, Product,
    ProductUse,
};
use freeform_surface::{Degree, NurbsSurface};
use proptest::prelude::*;

/// A model with every kind of record, as it is written.
const SAMPLE: &str = include_str!("../harness/every_record.ffm");

/// The sheet of `docs/model-format.md`.
const SHEET: &str = "freeform-model 1
edge tolerance 1e-7 range 0 2 line 0 0 0  1 0 0
edge tolerance 1e-7 range 0 1 line 2 0 0  0 1 0
edge tolerance 1e-7 range 0 2 line 0 1 0  1 0 0
edge tolerance 1e-7 range 0 1 line 0 0 0  0 1 0
face tolerance 1e-7 forward bounds 0 2 0 1
  plane origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1
  loop 4 + 0 + 1 - 2 - 3
product name \"sheet\" faces 0 1
end
";

fn read(text: &str) -> Model {
    Model::from_text(text, Path::new("x.ffm")).unwrap()
}

fn error(text: &str) -> String {
    Model::from_text(text, Path::new("x.ffm")).unwrap_err().to_string()
}

fn write(model: &Model) -> String {
    let mut text = Vec::new();
    model.write(&mut text).unwrap();
    String::from_utf8(text).unwrap()
}

#[test]
fn the_example_of_the_document_is_read() {
    let document = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/model-format.md");
    assert!(std::fs::read_to_string(document).unwrap().contains(SHEET));
    let model = read(SHEET);
    assert_eq!((model.edges.len(), model.faces.len(), model.products.len()), (4, 1, 1));
    assert_eq!((model.name.as_str(), model.unit), ("", 0.001));
    let line = Curve::Line { origin: DVec3::new(2.0, 0.0, 0.0), direction: DVec3::Y };
    let curve = Some(BoundedCurve { curve: line, range: [0.0, 1.0] });
    assert_eq!(model.edges[1], Edge { tolerance: 1e-7, curve });
    let face = &model.faces[0];
    assert_eq!(face.surface, FaceSurface::Plane(Frame::WORLD));
    assert_eq!(face.bounds, [DVec2::ZERO, DVec2::new(2.0, 1.0)]);
    let uses: Vec<_> = face.loops[0].iter().map(|coedge| (coedge.edge, coedge.forward)).collect();
    assert_eq!(uses, [(0, true), (1, true), (2, false), (3, false)]);
    assert_eq!(model.products[0].name, "sheet");
}

#[test]
fn every_record_is_written_as_it_was_read() {
    let model = read(SAMPLE);
    assert_eq!(write(&model), SAMPLE);
    assert_eq!(read(&write(&model)), model);
    assert_eq!(model.name, "every record: \"a\" \\ b\nc");
    assert!(SAMPLE.lines().all(|line| line.len() <= 120));
    model.check().unwrap();
    // White space, comments and line ends make no difference.
    let other = SAMPLE.replace('\n', "\r\n\t# \"a comment\n \r\n");
    assert_eq!(read(&other), model);
    assert_eq!(read(&format!("\u{feff}{SAMPLE}")), model);
    assert_eq!(read(&format!("\u{feff}# a comment\n{SAMPLE}")), model);
    assert_eq!(read(&format!("# a comment\n{}", SAMPLE.trim_end())), model);
}

#[test]
fn records_may_be_mixed() {
    let sheet = SHEET.trim_end().strip_suffix("end").unwrap();
    let (header, records) = sheet.split_once('\n').unwrap();
    let mixed = format!("{header}\n{records}{}end", records.replace("faces 0 1", "faces 1 1"));
    let model = read(&mixed);
    assert_eq!((model.edges.len(), model.faces.len(), model.products.len()), (8, 2, 2));
    assert_eq!(model.faces[0], model.faces[1]);
}

#[test]
fn a_reader_that_gives_one_byte_at_a_time_is_enough() {
    let slow = std::io::BufReader::with_capacity(1, SAMPLE.as_bytes());
    assert_eq!(Model::read(slow, Path::new("x.ffm")).unwrap(), read(SAMPLE));
}

/// The sheet with a part replaced, which must occur in it.
fn with(old: &str, new: &str) -> String {
    assert!(SHEET.contains(old), "{old}");
    SHEET.replacen(old, new, 1)
}

#[test]
fn faults_name_the_line_the_record_and_what_was_expected() {
    for (text, message) in [
        (String::new(), "1: the file ends; expected freeform-model"),
        ("\n\n  \n".into(), "4: the file ends; expected freeform-model"),
        ("solid part".into(), "1: \"solid\" found; expected freeform-model"),
        ("freeform-model\n2".into(), "2: \"2\" found; expected version 1 of the format"),
        ("freeform-model 1\n".into(), "2: the file ends; expected edge, face, product or end"),
        ("freeform-model 1 end".into(), "1: number of faces is 0; expected at least 1"),
        (
            with("product name \"sheet\" faces 0 1\n", ""),
            "9: number of products is 0; expected at least 1",
        ),
        (with("end", "end\nend"), "11: \"end\" found; expected nothing after the word end"),
        (with("1\n", "1 unit 0\n"), "1: unit is 0; expected a number above 0"),
        (with("1\n", "1 unit 1e16\n"), "1: unit is 1e16; expected a finite number of at most 1e15"),
        (with("1\n", "1 unit\n"), "2: unit is \"edge\"; expected a finite number of at most 1e15"),
        (with("1\n", "1 name x\n"), "1: \"x\" found; expected name, a text in double quotes"),
        (
            with("1\n", "1 name \"x\n"),
            "1: the line ends within a text; expected a double quote, or \\n for a line feed",
        ),
        (
            with("1\n", "1 name \"\\t\"\n"),
            "1: a backslash in a text stands alone; expected \\\\, \\\" or \\n",
        ),
        (
            with("1\n", "1 name \"x\"edge\n"),
            "1: a text is followed by another word; expected white space",
        ),
        (
            "freeform-model 1 name \"x".into(),
            "1: the file ends within a text; expected a double quote",
        ),
        (
            with("tolerance 1e-7", "tolerance -1"),
            "2: edge 0: tolerance is -1; expected a number of at least 0",
        ),
        (
            with("range 0 2", "range 0 nan"),
            "2: edge 0: last parameter of the curve is NaN; expected a finite number of at most 1e15",
        ),
        (
            with("range 0 2", "range 2 2"),
            "2: edge 0: range of the curve is 2 2; expected two numbers, the first less than the last",
        ),
        (
            with("range 0 2 line", "range 0 2 lime"),
            "2: edge 0: \"lime\" found; expected line, circle, ellipse or nurbs",
        ),
        (
            with("range", "\"range\""),
            "2: edge 0: the text \"range\" found; expected point or range",
        ),
        (
            with("0 0 0  1 0 0", "0 0 0  1 0 1e-4"),
            "2: edge 0: direction of the line is 1 0 1e-4; expected a direction of length 1 within 1e-9",
        ),
        (
            with("2 0 0  0 1 0", "2 0 \"0\"  0 1 0"),
            "3: edge 1: origin of the line is the text \"0\"; expected a finite number of at most 1e15",
        ),
        (
            with("forward", "color 1 1 2 forward"),
            "6: face 0: color is 2; expected three numbers from 0 to 1",
        ),
        (
            with("forward", "backward"),
            "6: face 0: \"backward\" found; expected forward or reversed",
        ),
        (
            with("bounds 0 2 0 1\n  plane", "bounds 0 7 0 1\n  cylinder")
                .replace("z 0 0 1", "z 0 0 1 3"),
            "7: face 0: u of the bounds is 0 7; expected at most one turn, 2π",
        ),
        (
            with("bounds 0 2 0 1", "bounds 0 2 1 0"),
            "6: face 0: v of the bounds is 1 0; expected two numbers, the first less than the last",
        ),
        (
            with("plane", "sphre"),
            "7: face 0: \"sphre\" found; expected plane, cylinder, cone, sphere, torus, revolution, extrusion or nurbs",
        ),
        (
            with("y 0 1 0", "y 0.6 0.8 0"),
            "7: face 0: product of the axes x and y of the plane is 0.6; expected 0 (perpendicular) within 1e-9",
        ),
        (
            with("loop 4", "loop 0"),
            "8: face 0: number of edges of the loop is 0; expected at least 1",
        ),
        (
            with("loop 4", "loop -4"),
            "8: face 0: number of edges of the loop is \"-4\"; expected a whole number from 0",
        ),
        (
            with("loop 4", "loop 5"),
            "9: face 0: \"product\" found; expected + or - before edge 4 of 5",
        ),
        (with("loop 4", "loop 3"), "8: \"-\" found; expected edge, face, product or end"),
        (with("- 3", "- 4"), "8: face 0: edge is 4; expected an earlier edge, 0 to 3"),
        (
            with("faces 0 1", "faces 0 2"),
            "9: product 0: faces (first, count) is 0 2; expected a run of the 1 faces before, which are numbered from 0",
        ),
        (
            with("faces 0 1", "faces 1 18446744073709551615"),
            "9: product 0: faces (first, count) is 1 18446744073709551615; expected a run of the 1 faces before, \
             which are numbered from 0",
        ),
        (
            with("faces 0 1", "faces 0 1 use 0 columns 1 0 0 0 1 0 0 0 1 0 0 0"),
            "9: product 0: product is 0; expected an earlier product, but there is none",
        ),
        (SHEET[..SHEET.len() - 4].into(), "10: the file ends; expected edge, face, product or end"),
        (
            SHEET[..60].into(),
            "2: edge 0: the file ends; expected direction of the line, a finite number of at most 1e15",
        ),
    ] {
        assert_eq!(error(&text), format!("x.ffm:{message}"));
    }
}

#[test]
fn faults_of_shapes_are_named() {
    let frame = "origin 0 0 0 x 1 0 0 y 0 1 0 z 0 0 1";
    let square = "degree 1 1 knots 4 0 0 1 1 knots 4 0 0 1 1";
    for (surface, message) in [
        (format!("cylinder {frame} -1"), "radius of the cylinder is -1; expected a number above 0"),
        (format!("cone {frame} -1 1"), "radius of the cone is -1; expected a number of at least 0"),
        (format!("cone {frame} 1 0"), "half angle of the cone is 0; expected a number between −π/2 and π/2, not 0"),
        (format!("cone {frame} 1 1.6"), "half angle of the cone is 1.6; expected a number between −π/2 and π/2, not 0"),
        (format!("sphere {frame} 0"), "radius of the sphere is 0; expected a number above 0"),
        (format!("torus {frame} 1 0"), "minor radius of the torus is 0; expected a number above 0"),
        (
            "revolution origin 0 0 0 axis 0 0 2 range 0 1 line 1 0 0 0 0 1".into(),
            "axis of the revolution is 0 0 2; expected a direction of length 1 within 1e-9",
        ),
        (
            format!("extrusion direction 0 0 1 range 0 1 circle {frame} 0"),
            "radius of the circle is 0; expected a number above 0",
        ),
        (
            format!("extrusion direction 0 0 1 range 0 1 ellipse {frame} 1 -0"),
            "radius of the ellipse is -0; expected a number above 0",
        ),
        (
            format!("extrusion direction 0 0 1 range 0 7 circle {frame} 1"),
            "range of the circle is 0 7; expected at most one turn, 2π",
        ),
        (
            "extrusion direction 0 0 1 range 0 2 nurbs degree 1 knots 4 0 0 1 1 points 2 0 0 0 1 1 0 0 1".into(),
            "range of the curve is 0 2; expected a part of its domain, 0 1",
        ),
        (
            "extrusion direction 0 0 1 range 0 1 nurbs degree 1 knots 4 0 0 1 1 points 3 ".into(),
            "number of control points is 3; expected 2, the number of knots - degree - 1",
        ),
        ("nurbs degree 0 1".into(), "degree along u is 0; expected 1 to 15"),
        ("nurbs degree 1 1 knots 4 0 0 1 -1".into(), "knot 3 is -1; expected at least 1, the knot before it"),
        ("nurbs degree 1 1 knots 4 0 0 1 1 knots 0".into(), "number of points is 0; expected at least 2 for degree 1"),
        (
            format!("nurbs {square} points 2 3"),
            "number of rows of control points is 3; expected 2, the number of knots - degree - 1",
        ),
        (
            format!("nurbs {square} points 2 2 0 0 0 1  1 0 0 0"),
            "weight of control point 1 is 0; expected a number above 0, from 1e-9 to 1e9",
        ),
    ] {
        let text = with(&format!("plane {frame}"), &surface);
        assert_eq!(error(&text), format!("x.ffm:7: face 0: {message}"));
    }
}

#[test]
fn long_words_and_bytes_that_are_no_text_are_refused() {
    let long = "x".repeat(1 << 20);
    let too_long = "a word of more than 4096 bytes; expected a shorter one";
    assert_eq!(error(&long), format!("x.ffm:1: {too_long}"));
    assert_eq!(error(&with("sheet", &long)), format!("x.ffm:9: product 0: {too_long}"));
    // Comments and white space may have any length.
    read(&with("end", &format!("{}#{long}\nend", " ".repeat(10_000))));
    read(&with("sheet", &long[..4096]));
    let bytes: Vec<u8> = (0..=255).cycle().skip(128).take(1000).collect();
    let error = Model::read(bytes.as_slice(), Path::new("x.ffm")).unwrap_err().to_string();
    assert!(
        error.starts_with("x.ffm:1: ") && error.ends_with("is not text; expected UTF-8"),
        "{error}"
    );
}

#[test]
fn a_check_finds_what_the_reader_finds() {
    let sheet = read(SHEET);
    let fault = |change: &dyn Fn(&mut Model)| {
        let mut model = sheet.clone();
        change(&mut model);
        let error = model.check().unwrap_err().to_string();
        // The reader refuses the same model.
        assert!(Model::from_text(&write(&model), Path::new("x.ffm")).is_err(), "{error}");
        error
    };
    let name = "x".repeat(4097);
    for (change, message) in [
        (
            &|model: &mut Model| model.unit = f64::INFINITY,
            "unit is inf; expected a finite number of at most 1e15",
        ),
        (
            &|model: &mut Model| model.name = name.clone(),
            "length of the name is 4097 bytes; expected at most 4096 bytes",
        ),
        (
            &|model: &mut Model| model.edges[2].tolerance = -1.0,
            "edge 2: tolerance is -1; expected a number of at least 0",
        ),
        (
            &|model: &mut Model| model.faces[0].loops[0][3].edge = 4,
            "face 0: loop 0: edge is 4; expected an earlier edge, 0 to 3",
        ),
        (
            &|model: &mut Model| model.faces[0].loops.push(Vec::new()),
            "face 0: loop 1: number of edges of the loop is 0; expected at least 1",
        ),
        (
            &|model: &mut Model| model.faces.clear(),
            "product 0: faces (first, count) is 0 1; expected a run of the 0 faces before, which are numbered from 0",
        ),
        (
            &|model: &mut Model| model.products.clear(),
            "number of products is 0; expected at least 1",
        ),
        (
            &|model: &mut Model| {
                let placement = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
                let used = ProductUse { product: 0, placement, color: None };
                let product =
                    Product { name: String::new(), color: None, faces: [0, 0], uses: vec![used] };
                model.products.push(product);
            },
            "product 1: use 0: determinant of the placement is 0; expected another number: independent axes",
        ),
    ] as [(&dyn Fn(&mut Model), &str); 8]
    {
        assert_eq!(fault(change), message);
    }
}

#[test]
fn numbers_have_the_fewest_characters() {
    let text = with("1\n", "1 unit 0.000001\n")
        .replace("0 2 line 0 0 0", "-0.5 2000000 line 1e3 12e-1 1e-3");
    let text = write(&read(&text));
    assert!(text.starts_with("freeform-model 1\nunit 1e-6\nedge tolerance 1e-7 range -0.5 2e6 line 1e3 1.2 1e-3 1 0 0\n"), "{text}");
}

/// Numbers of all sizes that a model may have.
fn number() -> BoxedStrategy<f64> {
    prop_oneof![
        -1e15..1e15,
        -10.0..10.0,
        any::<f64>()
            .prop_map(|x| if x.abs() <= 1e15 { x } else { x.recip() })
            .prop_map(|x| if x.is_finite() { x } else { -0.0 }),
        (-1000..1000_i32).prop_map(f64::from),
    ]
    .boxed()
}

fn positive() -> impl Strategy<Value = f64> {
    number().prop_map(|x| x.abs().max(f64::MIN_POSITIVE))
}

fn point() -> impl Strategy<Value = DVec3> {
    [number(), number(), number()].prop_map(DVec3::from_array)
}

fn direction() -> impl Strategy<Value = DVec3> {
    [-1.0..1.0, -1.0..1.0, 0.1..1.0].prop_map(|v| DVec3::from_array(v).normalize())
}

fn frame() -> BoxedStrategy<Frame> {
    (point(), direction(), any::<bool>())
        .prop_map(|(origin, z, left)| {
            let (x, y) = z.any_orthonormal_pair();
            Frame { origin, x, y: if left { -y } else { y }, z }
        })
        .boxed()
}

fn name() -> BoxedStrategy<String> {
    prop_oneof![Just(String::new()), "[a-z \"\\\\\n#é]{1,12}", "\\PC{0,300}"].boxed()
}

fn color() -> impl Strategy<Value = Option<[f32; 3]>> {
    prop::option::of([0.0..=1.0_f32, 0.0..=1.0_f32, 0.0..=1.0_f32])
}

fn rising() -> impl Strategy<Value = [f64; 2]> {
    (number(), number()).prop_map(|(a, b)| match a.partial_cmp(&b) {
        Some(std::cmp::Ordering::Less) => [a, b],
        Some(std::cmp::Ordering::Greater) => [b, a],
        _ => [-1.0, 1.0],
    })
}

/// A degree and a knot vector for it.
fn knots() -> impl Strategy<Value = (usize, Vec<f64>)> {
    (1..=15_usize, prop::collection::vec(0.0..10.0, 2..20)).prop_map(|(degree, mut inner)| {
        inner.sort_by(f64::total_cmp);
        let ends = |value: f64| std::iter::repeat_n(value, degree);
        (degree, ends(-1.0).chain([-1.0]).chain(inner).chain([11.0]).chain(ends(11.0)).collect())
    })
}

fn weighted(count: usize) -> impl Strategy<Value = Vec<DVec4>> {
    let weight = prop_oneof![Just(1.0), 1e-9..1e9, 0.1..2.0];
    let point = (point(), weight).prop_map(|(point, weight)| point.extend(weight));
    prop::collection::vec(point, count)
}

fn nurbs_curve() -> BoxedStrategy<NurbsCurve<DVec4>> {
    knots()
        .prop_flat_map(|(degree, knots)| {
            weighted(knots.len() - degree - 1)
                .prop_map(move |points| NurbsCurve::new(degree, knots.clone(), points).unwrap())
        })
        .boxed()
}

/// A range of angles that begins with the same number.
fn within_a_turn([first, last]: [f64; 2]) -> [f64; 2] {
    [first, first + (last - first).min(6.0)]
}

fn curve() -> BoxedStrategy<BoundedCurve> {
    let line =
        (point(), direction()).prop_map(|(origin, direction)| Curve::Line { origin, direction });
    let circle = (frame(), positive()).prop_map(|(frame, radius)| Curve::Circle { frame, radius });
    let ellipse = (frame(), [positive(), positive()])
        .prop_map(|(frame, radii)| Curve::Ellipse { frame, radii });
    let nurbs = nurbs_curve()
        .prop_map(|curve| BoundedCurve { range: curve.domain(), curve: Curve::Nurbs(curve) });
    prop_oneof![
        (line, rising()).prop_map(|(curve, range)| BoundedCurve { curve, range }),
        (prop_oneof![circle, ellipse], rising())
            .prop_map(|(curve, range)| BoundedCurve { curve, range: within_a_turn(range) }),
        nurbs,
    ]
    .boxed()
}

fn surface() -> BoxedStrategy<FaceSurface> {
    let nurbs = (knots(), knots()).prop_flat_map(|((u, knots_u), (v, knots_v))| {
        weighted((knots_u.len() - u - 1) * (knots_v.len() - v - 1)).prop_map(move |points| {
            let knots = [knots_u.clone(), knots_v.clone()];
            FaceSurface::Nurbs(
                NurbsSurface::new(Degree::new(u, v).unwrap(), knots, points).unwrap(),
            )
        })
    });
    prop_oneof![
        frame().prop_map(FaceSurface::Plane),
        (frame(), positive()).prop_map(|(frame, radius)| FaceSurface::Cylinder { frame, radius }),
        (frame(), positive(), 0.001..1.57).prop_map(|(frame, radius, half_angle)| {
            FaceSurface::Cone { frame, radius, half_angle }
        }),
        (frame(), positive()).prop_map(|(frame, radius)| FaceSurface::Sphere { frame, radius }),
        (frame(), positive(), positive()).prop_map(|(frame, major_radius, minor_radius)| {
            FaceSurface::Torus { frame, major_radius, minor_radius }
        }),
        (point(), direction(), curve()).prop_map(|(origin, axis, curve)| FaceSurface::Revolution {
            origin,
            axis,
            curve
        }),
        (direction(), curve())
            .prop_map(|(direction, curve)| FaceSurface::Extrusion { direction, curve }),
        nurbs,
    ]
    .boxed()
}

fn face(edges: usize) -> BoxedStrategy<Face> {
    let pcurve = nurbs_curve().prop_map(|curve| {
        let points = curve.control_points().iter().map(|p| DVec3::new(p.x, p.y, p.w)).collect();
        NurbsCurve::new(curve.degree(), curve.knots().to_vec(), points).unwrap()
    });
    let coedge = (0..edges, any::<bool>(), prop::option::weighted(0.2, pcurve))
        .prop_map(|(edge, forward, pcurve)| Coedge { edge, forward, pcurve });
    let loops = prop::collection::vec(prop::collection::vec(coedge, 1..5), 0..3);
    (name(), positive(), color(), any::<bool>(), surface(), rising(), rising(), loops)
        .prop_map(|(name, tolerance, color, reversed, surface, u, v, loops)| {
            let is_flat = matches!(
                surface,
                FaceSurface::Plane(_) | FaceSurface::Extrusion { .. } | FaceSurface::Nurbs(_)
            );
            let is_torus = matches!(surface, FaceSurface::Torus { .. });
            let u = if is_flat { u } else { within_a_turn(u) };
            let v = if is_torus { within_a_turn(v) } else { v };
            let bounds = [DVec2::new(u[0], v[0]), DVec2::new(u[1], v[1])];
            Face { name, tolerance, color, reversed, surface, bounds, loops }
        })
        .boxed()
}

fn products(faces: usize) -> BoxedStrategy<Vec<Product>> {
    let used = (any::<prop::sample::Index>(), frame(), color());
    let product = (name(), color(), 0..=faces, 0..=faces, prop::collection::vec(used, 0..3));
    prop::collection::vec(product, 1..5)
        .prop_map(|products| {
            let product = |(number, (name, color, a, b, uses)): (
                usize,
                (String, _, usize, usize, Vec<_>),
            )| {
                let used = |(index, frame, color): (prop::sample::Index, Frame, _)| {
                    let matrix3 = DMat3::from_cols(frame.x, frame.y, frame.z);
                    let placement = DAffine3 { matrix3, translation: frame.origin };
                    ProductUse { product: index.index(number), placement, color }
                };
                let uses =
                    if number == 0 { Vec::new() } else { uses.into_iter().map(used).collect() };
                Product { name, color, faces: [a.min(b), a.abs_diff(b)], uses }
            };
            products.into_iter().enumerate().map(product).collect()
        })
        .boxed()
}

fn model() -> BoxedStrategy<Model> {
    let edge = (positive(), prop::option::weighted(0.9, curve()))
        .prop_map(|(tolerance, curve)| Edge { tolerance, curve })
        .boxed();
    prop::collection::vec(edge, 1..6)
        .prop_flat_map(|edges| {
            prop::collection::vec(face(edges.len()), 1..4).prop_flat_map(move |faces| {
                let edges = edges.clone();
                (name(), positive(), products(faces.len())).prop_map(
                    move |(name, unit, products)| Model {
                        name,
                        unit,
                        edges: edges.clone(),
                        faces: faces.clone(),
                        products,
                    },
                )
            })
        })
        .boxed()
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 64, ..ProptestConfig::default() })]

    #[test]
    fn a_model_is_read_back_as_it_was_written(model in model()) {
        model.check().unwrap();
        let text = write(&model);
        let back = read(&text);
        prop_assert_eq!(&back, &model);
        prop_assert_eq!(write(&back), text);
        // Debug shows the sign of a zero, which equality ignores.
        prop_assert_eq!(format!("{back:?}"), format!("{model:?}"));
    }
}
