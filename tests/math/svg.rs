//! SVG paths and documents as trims, compared with resvg's pictures of them.

use freeform_surface::inspect::TrimGrid;
use freeform_surface::{FillRule, Scene, Segment, TrimLoop, TrimPath, Trims};
use glam::vec2;
use proptest::prelude::*;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree};

/// Side of resvg's pictures in pixels.
const SIDE: u32 = 96;

/// resvg's coverage of a square document, 0 to 255, top row first.
fn coverage(document: &str) -> Vec<u8> {
    let tree = Tree::from_str(document, &Options::default()).unwrap();
    assert_eq!(tree.size().width(), tree.size().height());
    let mut picture = Pixmap::new(SIDE, SIDE).unwrap();
    let scale = SIDE as f32 / tree.size().width();
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut picture.as_mut());
    picture.pixels().iter().map(|pixel| pixel.alpha()).collect()
}

/// The pixels that a border runs through, and those around them.
fn near_borders(paths: &[TrimPath]) -> Vec<bool> {
    let mut near = vec![false; (SIDE * SIDE) as usize];
    let loops = paths.iter().flat_map(|path| &path.loops);
    for segment in loops.flat_map(TrimLoop::segments) {
        let steps = 20 + (2.0 * f64::from(SIDE) * length(segment)) as u32;
        for step in 0..=steps {
            let pixel = segment.point(f64::from(step) / f64::from(steps)) * f64::from(SIDE);
            let reach =
                |at: f64| (at.floor() as i64 - 1).max(0)..(at.floor() as i64 + 2).min(SIDE.into());
            for (x, y) in reach(pixel.y).flat_map(|y| reach(pixel.x).map(move |x| (x, y))) {
                near[((i64::from(SIDE) - 1 - y) * i64::from(SIDE) + x) as usize] = true;
            }
        }
    }
    near
}

/// An upper bound of the length of a curve.
fn length(segment: &Segment) -> f64 {
    segment.points().windows(2).map(|ends| ends[0].distance(ends[1])).sum()
}

/// Compares paths with resvg's picture wherever no border is near. Returns how many pixels are outside
/// and how many inside.
fn compare(paths: Vec<TrimPath>, document: &str) -> Result<[usize; 2], TestCaseError> {
    let near = near_borders(&paths);
    let grid = TrimGrid::new(&Trims { paths, ..Trims::default() });
    let mut counts = [0; 2];
    for ((i, alpha), near) in (0..).zip(coverage(document)).zip(near) {
        if !near {
            let uv = (vec2((i % SIDE) as f32, (SIDE - 1 - i / SIDE) as f32) + 0.5) / SIDE as f32;
            let is_inside = grid.cut(uv);
            prop_assert_eq!(alpha, if is_inside { 255 } else { 0 }, "{} in {}", uv, document);
            counts[usize::from(is_inside)] += 1;
        }
    }
    Ok(counts)
}

/// A document of one path in the domain's coordinates.
fn document_of(data: &str, rule: &str) -> String {
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1" width="{SIDE}" height="{SIDE}">
        <path transform="matrix(1 0 0 -1 0 1)" fill-rule="{rule}" d="{data}"/></svg>"#
    )
}

fn rule() -> impl Strategy<Value = (FillRule, &'static str)> {
    prop_oneof![Just((FillRule::NonZero, "nonzero")), Just((FillRule::EvenOdd, "evenodd"))]
}

/// A path command with random values, absolute or relative.
fn command() -> impl Strategy<Value = String> {
    let place = || -0.1..1.1;
    let step = || -0.5..0.5;
    prop_oneof![
        (place(), place()).prop_map(|(x, y)| format!("L{x} {y}")),
        (step(), step()).prop_map(|(x, y)| format!("l{x} {y}")),
        place().prop_map(|x| format!("H{x}")),
        step().prop_map(|y| format!("v{y}")),
        (place(), place(), place(), place()).prop_map(|(a, b, x, y)| format!("Q{a} {b} {x} {y}")),
        (step(), step()).prop_map(|(x, y)| format!("t{x} {y}")),
        (place(), place(), place(), place(), place(), place())
            .prop_map(|(a, b, c, d, x, y)| format!("C{a} {b} {c} {d} {x} {y}")),
        (step(), step(), step(), step()).prop_map(|(a, b, x, y)| format!("s{a} {b} {x} {y}")),
        (0.01..0.5, 0.01..0.5, -90.0..90.0, 0..2, 0..2, place(), place()).prop_map(
            |(a, b, turn, large, sweep, x, y)| {
                format!("A{a} {b} {turn} {large} {sweep} {x} {y}")
            }
        ),
        Just("z".to_owned()),
        Just("z z".to_owned()),
        (place(), place()).prop_map(|(x, y)| format!("M{x} {y}")),
        (step(), step()).prop_map(|(x, y)| format!("m{x} {y}")),
    ]
}

fn path_data() -> impl Strategy<Value = String> {
    prop::collection::vec(command(), 2..14)
        .prop_map(|commands| format!("M.2 .3 L.8 .4 {}", commands.join(" ")))
}

/// Transforms such as `scale` and `rotate` that leave the shape visible.
fn transform() -> impl Strategy<Value = String> {
    prop_oneof![
        (-3.0..3.0, -3.0..3.0).prop_map(|(x, y)| format!("translate({x} {y})")),
        (0.3..1.5, -1.5..-0.3).prop_map(|(x, y)| format!("translate(0 10) scale({x} {y})")),
        (-180.0..180.0).prop_map(|turn| format!("rotate({turn} 5 5)")),
        (-40.0..40.0).prop_map(|turn| format!("skewX({turn})")),
        (0.5..1.5, -0.5..0.5, -0.5..0.5, 0.5..1.5, -2.0..2.0, -2.0..2.0)
            .prop_map(|(a, b, c, d, e, f)| format!("matrix({a} {b} {c} {d} {e} {f})")),
    ]
}

/// A shape in a document of 10 × 10.
fn shape() -> impl Strategy<Value = String> {
    let place = || 0.0..8.0;
    let size = || 1.0..6.0;
    prop_oneof![
        (place(), place(), size(), size(), 0.0..2.0).prop_map(|(x, y, w, h, r)| {
            format!(r#"<rect x="{x}" y="{y}" width="{w}" height="{h}" rx="{r}""#)
        }),
        (place(), place(), size())
            .prop_map(|(x, y, r)| format!(r#"<circle cx="{x}" cy="{y}" r="{r}""#)),
        (place(), place(), size(), size())
            .prop_map(|(x, y, a, b)| format!(r#"<ellipse cx="{x}" cy="{y}" rx="{a}" ry="{b}""#)),
        prop::collection::vec(place(), 6..=16).prop_map(|points| {
            let points = points[..points.len() / 2 * 2].iter().map(f64::to_string);
            format!(r#"<polygon points="{}""#, points.collect::<Vec<_>>().join(" "))
        }),
        path_data().prop_map(|data| format!(r#"<path d="{data}" vector-effect="none""#)),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 300, ..ProptestConfig::default() })]

    #[test]
    fn any_path_is_filled_as_resvg_fills_it(data in path_data(), (rule, name) in rule()) {
        let path = TrimPath::from_svg_path(&data, rule).unwrap();
        let [outside, inside] = compare(vec![path], &document_of(&data, name))?;
        prop_assert!(outside + inside > 1000);
    }

    #[test]
    fn any_document_is_filled_as_resvg_fills_it(
        shapes in prop::collection::vec((shape(), transform(), rule()), 1..5),
        group in transform(),
    ) {
        let shapes: String = shapes
            .iter()
            .map(|(shape, transform, (_, rule))| {
                format!(r#"{shape} transform="{transform}" fill-rule="{rule}"/>"#)
            })
            .collect();
        let document = format!(
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10"><g transform="{group}">{shapes}</g></svg>"#
        );
        compare(TrimPath::from_svg(&document).unwrap(), &document)?;
    }

    #[test]
    fn a_document_with_a_piece_replaced_gives_paths_or_one_line(
        start in 0..DOCUMENT.len(), length in 0usize..30, piece in "[-+.0-9a-z<>\"=/#&; ]{0,12}"
    ) {
        let end = (start + length).min(DOCUMENT.len());
        let text = format!("{}{piece}{}", &DOCUMENT[..start], &DOCUMENT[end..]);
        match TrimPath::from_svg(&text) {
            Ok(paths) => prop_assert!(paths.iter().all(|path| !path.loops.is_empty())),
            Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error),
        }
    }
}

const DOCUMENT: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 10 10" width="2cm">
<style>.a { fill-rule: evenodd }</style><defs><g id="g"><rect width="3" height="2" rx=".5"/></g></defs>
<g transform="translate(1 2) rotate(30)"><use href="#g" x="2"/><path class="a" d="M0 0h4v4h-4zM1 1h2v2z"/></g>
<circle cx="5" cy="5" r="2" fill="#fff" opacity=".5"/></svg>"##;

#[test]
fn a_scene_takes_the_documents_paths_and_names_its_file() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("resources/scenes/gallery/badge.toml");
    let scene = Scene::load(&path).unwrap();
    let document = path.with_file_name("../../trims/badge.svg");
    let paths = TrimPath::from_svg(&std::fs::read_to_string(&document).unwrap()).unwrap();
    assert_eq!(paths.len(), 1 + 5 + 5 + 2);
    assert_eq!(scene.surfaces[0].trims, Trims { paths, ..Trims::default() });
    assert_eq!(scene.files, [path, document]);
}

#[test]
fn the_rules_differ_where_they_should() {
    let star = "M.5 1 L.21 .1 L.98 .65 L.02 .65 L.79 .1 Z";
    let inside =
        [(FillRule::NonZero, "nonzero"), (FillRule::EvenOdd, "evenodd")].map(|(rule, name)| {
            let path = TrimPath::from_svg_path(star, rule).unwrap();
            compare(vec![path], &document_of(star, name)).unwrap()[1]
        });
    assert!(inside[0] > inside[1] + 500, "{inside:?}");
}
