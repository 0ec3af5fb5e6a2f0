//! SVG documents into paths.
//!
//! usvg reads them: styles, references, shapes and transforms are resolved there. It keeps numbers in
//! `f32`, and its arcs and circles are cubics that are off by up to 2.8·10⁻⁴ of the radius.

use std::collections::BTreeSet;

use glam::{DVec2, dvec2};
use svgtypes::PathSegment;
use usvg::roxmltree::{Document, ParsingOptions};
use usvg::tiny_skia_path::{PathSegment as UsvgSegment, Point};
use usvg::{Group, ImageHrefResolver, Node, Options, Path, Transform, Tree};

use super::path::loops_of;
use super::{FillRule, TrimPath};
use crate::{Error, Result};

impl TrimPath {
    /// What an SVG document fills, with its transforms and its own rules. Its picture (the view box) is
    /// fitted into the domain: the longer side from 0 to 1, the shorter one in the middle; upwards is
    /// towards v = 1.
    ///
    /// Strokes, text, pictures, clips, masks and filters are not taken.
    ///
    /// # Errors
    /// Text that is no SVG document; one that fills nothing; more segments than a surface may have.
    pub fn from_svg(text: &str) -> Result<Vec<Self>> {
        read(text).map(|(paths, _)| paths)
    }
}

/// The paths, and the names of what was not taken.
pub(crate) fn read(text: &str) -> Result<(Vec<TrimPath>, Vec<&'static str>)> {
    let options = Options {
        // Nothing but the document itself is read.
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..Options::default()
    };
    let unreadable = |error: &dyn std::fmt::Display| {
        Error::invalid("SVG document", "not readable", format!("valid SVG ({error})"))
    };
    let xml_options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let xml =
        Document::parse_with_options(text, xml_options).map_err(|error| unreadable(&error))?;
    let tree = Tree::from_xmltree(&xml, &options).map_err(|error| unreadable(&error))?;
    let size = dvec2(tree.size().width().into(), tree.size().height().into());
    let mut reader = Reader { size, paths: Vec::new(), ignored: BTreeSet::new() };
    // usvg leaves text out without a word.
    if xml.descendants().any(|node| node.has_tag_name((SVG_NAMESPACE, "text"))) {
        reader.ignored.insert("text");
    }
    reader.group(tree.root())?;
    if reader.paths.is_empty() {
        return Err(Error::invalid("SVG document", "without a filled shape", "at least one"));
    }
    Ok((reader.paths, reader.ignored.into_iter().collect()))
}

const SVG_NAMESPACE: &str = "http://www.w3.org/2000/svg";

struct Reader {
    /// Of the picture, in its own unit.
    size: DVec2,
    paths: Vec<TrimPath>,
    ignored: BTreeSet<&'static str>,
}

impl Reader {
    fn group(&mut self, group: &Group) -> Result<()> {
        for (is_there, name) in [
            (group.clip_path().is_some(), "clips"),
            (group.mask().is_some(), "masks"),
            (!group.filters().is_empty(), "filters"),
        ] {
            if is_there {
                self.ignored.insert(name);
            }
        }
        for node in group.children() {
            match node {
                Node::Group(group) => self.group(group)?,
                Node::Path(path) if path.is_visible() => self.path(path)?,
                Node::Path(_) => {}
                Node::Image(_) => {
                    self.ignored.insert("pictures");
                }
                Node::Text(_) => {
                    self.ignored.insert("text");
                }
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

    /// A segment in the domain.
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

    fn trims(document: &str) -> crate::Trims {
        let paths = TrimPath::from_svg(document).unwrap_or_else(|error| panic!("{error}"));
        crate::Trims { paths, ..crate::Trims::default() }
    }

    /// Places inside, on a lattice of `N` × `N`, from v = 1 downwards.
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
    fn what_is_not_taken_is_named() {
        let document = r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 4 4">
            <clipPath id="c"><rect width="1" height="1"/></clipPath>
            <text>word</text><rect width="3" height="3" stroke="red" clip-path="url(#c)"/></svg>"#;
        let (paths, ignored) = read(document).unwrap();
        assert_eq!((paths.len(), ignored), (1, vec!["clips", "strokes", "text"]));
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
            (huge, "path 1: loop 0: segment 0: a point"),
        ] {
            let text = TrimPath::from_svg(document).unwrap_err().to_string();
            assert!(text.contains(words), "{document}: {text}");
        }
    }
}
