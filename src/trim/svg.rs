//! Converts SVG documents to paths.
//!
//! usvg reads them and resolves styles, references, shapes and transforms. It keeps coordinates in
//! `f32`, and its arcs and circles are cubics that are off by up to 2.8·10⁻⁴ of the radius.

mod document;

use std::collections::BTreeSet;

use glam::{DVec2, dvec2};
use svgtypes::PathSegment;
use usvg::tiny_skia_path::{PathSegment as UsvgSegment, Point};
use usvg::{Group, Node, Options, Path, Transform, Tree};

use super::fill::check_paths;
use super::path::loops_of;
use super::{FillRule, TrimPath};
use crate::error::{Error, Result};
use document::{ReducedDocument, STYLE};

/// Elements may be nested 1,024 deep. The stack of the calling thread may be too small for that.
const STACK_BYTES: usize = 64 << 20;

impl TrimPath {
    /// The filled shapes of an SVG document, with its transforms and fill rules.
    ///
    /// The picture of the document is fitted into the domain: its longer side goes from 0 to 1, its shorter side is
    /// centred, and its top is towards v = 1. The size of the picture is `width` by `height`, or else that of the
    /// view box. Without either, the picture ends where the shapes end.
    ///
    /// Strokes, markers, text, pictures, clips, masks and filters are ignored.
    ///
    /// # Errors
    /// Text that is not an SVG document; invalid path data; a document that fills nothing; more than
    /// 1,000,000 segments in all paths together.
    pub fn from_svg(text: &str) -> Result<Vec<Self>> {
        read(text).map(|(paths, _)| paths)
    }
}

/// The paths, and the names of the features that were ignored.
pub(crate) fn read(text: &str) -> Result<(Vec<TrimPath>, Vec<&'static str>)> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_BYTES);
        match thread.spawn_scoped(scope, || read_on_this_stack(text)).map(|thread| thread.join()) {
            Ok(Ok(read)) => read,
            Ok(Err(panic)) => std::panic::resume_unwind(panic),
            Err(error) => {
                Err(Error::invalid("SVG document", "not read", format!("a thread ({error})")))
            }
        }
    })
}

fn read_on_this_stack(text: &str) -> Result<(Vec<TrimPath>, Vec<&'static str>)> {
    let ReducedDocument { text, removed } = ReducedDocument::new(text)?;
    let options = Options { style_sheet: Some(STYLE.to_owned()), ..Options::default() };
    let tree = Tree::from_str(&text, &options).map_err(|error| {
        Error::invalid("SVG document", "not readable", format!("valid SVG ({error})"))
    })?;
    let size = dvec2(tree.size().width().into(), tree.size().height().into());
    let mut reader = Reader { size, paths: Vec::new(), ignored: removed };
    reader.group(tree.root())?;
    if reader.paths.is_empty() {
        return Err(Error::invalid("SVG document", "without a filled shape", "at least one"));
    }
    check_paths(&reader.paths, 0, 0)?;
    Ok((reader.paths, reader.ignored.into_iter().collect()))
}

struct Reader {
    /// The size of the picture in its own unit.
    size: DVec2,
    paths: Vec<TrimPath>,
    /// Names of the ignored features.
    ignored: BTreeSet<&'static str>,
}

impl Reader {
    fn group(&mut self, group: &Group) -> Result<()> {
        if group.opacity().get() == 0.0 {
            return Ok(());
        }
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group)?,
                Node::Path(path) if path.is_visible() => self.path(path)?,
                // The reduced document has neither pictures nor text.
                Node::Path(_) | Node::Image(_) | Node::Text(_) => {}
            }
        }
        Ok(())
    }

    fn path(&mut self, path: &Path) -> Result<()> {
        if path.stroke().is_some() {
            self.ignored.insert("strokes");
        }
        let Some(fill) = path.fill().filter(|fill| fill.opacity().get() > 0.0) else {
            return Ok(());
        };
        let rule = match fill.rule() {
            usvg::FillRule::EvenOdd => FillRule::EvenOdd,
            usvg::FillRule::NonZero => FillRule::NonZero,
        };
        let number = self.paths.len();
        let segments =
            path.data().segments().map(|segment| self.placed(segment, path.abs_transform()));
        let loops = loops_of(segments).map_err(|error| error.within(format!("path {number}")))?;
        if !loops.is_empty() {
            self.paths.push(TrimPath { loops, rule });
        }
        Ok(())
    }

    /// A segment, transformed into the domain.
    fn placed(&self, segment: UsvgSegment, transform: Transform) -> PathSegment {
        let Transform { sx, kx, ky, sy, tx, ty } = transform;
        let [x_axis, y_axis, origin] =
            [[sx, ky], [kx, sy], [tx, ty]].map(|[x, y]| dvec2(x.into(), y.into()));
        let at = |point: Point| -> DVec2 {
            let place = x_axis * f64::from(point.x) + y_axis * f64::from(point.y) + origin;
            let from_middle = (place - 0.5 * self.size) / self.size.max_element();
            0.5 + from_middle * dvec2(1.0, -1.0)
        };
        let abs = true;
        match segment {
            UsvgSegment::MoveTo(to) => {
                let DVec2 { x, y } = at(to);
                PathSegment::MoveTo { abs, x, y }
            }
            UsvgSegment::LineTo(to) => {
                let DVec2 { x, y } = at(to);
                PathSegment::LineTo { abs, x, y }
            }
            UsvgSegment::QuadTo(control, to) => {
                let [DVec2 { x: x1, y: y1 }, DVec2 { x, y }] = [control, to].map(at);
                PathSegment::Quadratic { abs, x1, y1, x, y }
            }
            UsvgSegment::CubicTo(first, second, to) => {
                let [first, second, to] = [first, second, to].map(at);
                let (x1, y1, x2, y2) = (first.x, first.y, second.x, second.y);
                PathSegment::CurveTo { abs, x1, y1, x2, y2, x: to.x, y: to.y }
            }
            UsvgSegment::Close => PathSegment::ClosePath { abs },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trims(document: &str) -> crate::trim::Trims {
        let paths = TrimPath::from_svg(document).unwrap_or_else(|error| panic!("{error}"));
        crate::trim::Trims { paths, ..crate::trim::Trims::default() }
    }

    /// Which points of a uniform grid of `N` × `N` are inside, row by row from v = 1 downwards.
    fn picture<const N: usize>(document: &str) -> Vec<String> {
        let trims = trims(document);
        let middle = |i: usize| (i as f64 + 0.5) / N as f64;
        let row = |i: usize| -> String {
            let inside = |j: usize| trims.inside(dvec2(middle(j), 1.0 - middle(i)));
            (0..N).map(|j| if inside(j) { '#' } else { '.' }).collect()
        };
        (0..N).map(row).collect()
    }

    #[test]
    fn the_view_box_is_fitted_with_its_top_at_the_top() {
        let wide = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="10 20 8 4">
            <rect x="10" y="20" width="4" height="2"/></svg>"#;
        assert_eq!(picture::<4>(wide), ["....", "##..", "....", "...."]);
        let high = r#"<svg xmlns="http://www.w3.org/2000/svg" width="1in" height="2in" viewBox="0 0 2 4">
            <rect y="3" width="1" height="1"/></svg>"#;
        assert_eq!(picture::<4>(high), ["....", "....", "....", ".#.."]);
    }

    #[test]
    fn transforms_styles_and_uses_are_resolved() {
        let document = r##"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"
            viewBox="0 0 4 4"><style>.hole { fill-rule: evenodd } .no { fill: none }</style>
            <defs><rect id="one" width="1" height="1"/></defs>
            <g transform="translate(2 0) scale(2)"><path class="hole"
                d="M0 0H1V1H0Z M.5 .5H1V1H.5Z"/></g>
            <use xlink:href="#one" transform="rotate(90) translate(3 -1)"/>
            <rect class="no" x="1" y="1" width="1" height="3"/>
            <rect visibility="hidden" width="4" height="1"/>
            <rect fill-opacity="0" width="4" height="1"/></svg>"##;
        assert_eq!(picture::<4>(document), ["..##", "..#.", "....", "#..."]);
    }

    #[test]
    fn each_path_has_its_own_rule_and_all_are_united() {
        let square = "M0 0H3V3H0Z M1 1H2V2H1Z";
        let of = |attributes: &str| {
            picture::<4>(&format!(
                r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 4"><path {attributes} d="{square}"/>
                <rect x="2" y="2" width="2" height="2"/></svg>"#
            ))
        };
        assert_eq!(of(""), ["###.", "###.", "####", "..##"]);
        assert_eq!(of(r#"fill-rule="evenodd""#), ["###.", "#.#.", "####", "..##"]);
    }

    #[test]
    fn what_is_not_taken_is_named_and_what_is_filled_stays() {
        let document = r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 4">
            <defs><clipPath id="c"><rect width="1" height="1"/></clipPath><mask id="m"/>
            <marker id="k"><rect width="9" height="9"/></marker><text>unseen</text>
            <pattern id="p" width="1" height="1"><rect width="1" height="1" fill="url(#p)"/></pattern></defs>
            <text>word</text><rect width="3" height="2" stroke="red" clip-path="url(#c)" mask="url(#none)"/>
            <g style="mask: url(#m) !important; marker-start: url(#k)"><path fill="url(#p)" d="M0 3H2V4H0"/></g>
            <g opacity="0"><rect width="4" height="4"/></g>
            <svg width="1" height="1"><rect x="3" width="1" height="1"/></svg></svg>"##;
        assert_eq!(picture::<4>(document), ["####", "###.", "....", "##.."]);
        let (_, ignored) = read(document).unwrap();
        assert_eq!(ignored, ["clips", "markers", "masks", "strokes", "text"]);
    }

    #[test]
    fn the_size_of_the_picture_is_what_is_fitted() {
        let wide = r#"<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20" viewBox="0 0 2 2">
            <rect width="2" height="2"/></svg>"#;
        assert_eq!(picture::<4>(wide), ["....", ".##.", ".##.", "...."]);
        let sizeless = r#"<svg xmlns="http://www.w3.org/2000/svg">
            <rect x="2" width="2" height="2"/></svg>"#;
        assert_eq!(picture::<4>(sizeless), ["....", "..##", "..##", "...."]);
    }

    #[test]
    fn no_reference_is_followed_without_end() {
        let document = |defs: &str| {
            format!(
                r##"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 4"><defs>{defs}</defs>
                <rect width="2" height="4" mask="url(#i0)" clip-path="url(#i0)"/></svg>"##
            )
        };
        let half = vec!["##.."; 4];
        for element in ["mask", "clipPath", "pattern", "linearGradient", "filter"] {
            let link = |i: usize| {
                let next = i + 1;
                format!(
                    r##"<{element} id="i{i}" href="#i{next}" mask="url(#i{next})" clip-path="url(#i{next})"><rect
                    width="1" height="1" fill="url(#i{next})" mask="url(#i{next})"/></{element}>"##
                )
            };
            let chain: String = (0..5_000).map(link).collect();
            assert_eq!(picture::<4>(&document(&chain)), half, "{element}");
            let filled = document(&chain)
                .replace("<rect width=\"2\"", "<rect fill=\"url(#i0)\" width=\"2\"");
            let is_paint = matches!(element, "pattern" | "linearGradient");
            assert_eq!(TrimPath::from_svg(&filled).is_ok(), is_paint, "{element}");
        }
        // References of `use` elements are followed, but only up to a limit.
        let uses: String = (0..3_000)
            .map(|i| format!(r##"<g id="i{i}"><use href="#i{}"/></g>"##, i + 1))
            .collect();
        let error = TrimPath::from_svg(&document(&uses)).unwrap_err().to_string();
        assert!(error.contains("valid SVG"), "{error}");
        let doubled: String = (0..40)
            .map(|i| format!(r##"<g id="i{i}"><use href="#i{0}"/><use href="#i{0}"/></g>"##, i + 1))
            .collect();
        let deep =
            format!("{}<rect width='2' height='4'/>{}", "<g>".repeat(1_000), "</g>".repeat(1_000));
        assert!(TrimPath::from_svg(&document(&deep)).is_ok());
        let error = TrimPath::from_svg(&document(&doubled)).unwrap_err().to_string();
        assert!(error.contains("valid SVG"), "{error}");
    }

    #[test]
    fn faults_are_named() {
        let huge = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 1 1">
            <path d="M0 0H1V1Z"/><path d="M0 0H1e30V1Z"/></svg>"#;
        for (document, words) in [
            ("", "valid SVG"),
            ("<svg", "valid SVG"),
            ("<html/>", "valid SVG"),
            (r#"<svg xmlns="http://www.w3.org/2000/svg" width="-1" height="1"/>"#, "valid SVG"),
            (r#"<svg xmlns="http://www.w3.org/2000/svg"/>"#, "without a filled shape"),
            (r#"<svg xmlns="http://www.w3.org/2000/svg"><path d="M0 0"/></svg>"#, "filled shape"),
            (
                &huge.replace("1e30", "foo"),
                "line 2: path is \"M0 0HfooV1Z\"; expected SVG path data",
            ),
            (huge, "path 1: loop 0: segment 0: a point"),
        ] {
            let text = TrimPath::from_svg(document).unwrap_err().to_string();
            assert!(text.contains(words), "{document}: {text}");
        }
    }
}
