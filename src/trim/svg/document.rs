//! Prepares an SVG document for usvg: removes elements that are not filled and that could take usvg very long.
//!
//! usvg follows references between masks, clips, filters, patterns and markers to any depth, and a small file can
//! make this endless. Those elements are removed, and paints become plain colours, before usvg reads the document.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::ops::Range;

use svgtypes::PathParser;
use usvg::roxmltree::{Document, Node, ParsingOptions};

use crate::error::{Error, Result};
use crate::trim::path::unreadable_path;

const NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// Overrides the styles of the document, so that elements do not vanish when the elements that they refer to are
/// removed.
pub(super) const STYLE: &str = "* { clip-path: none !important; mask: none !important; \
    filter: none !important; marker: none !important; overflow: visible !important }";

/// Elements that are removed, and their names in warnings. The first list has elements that others refer to, the
/// second has elements that are drawn in place.
const REFERRED: [(&str, &str); 4] =
    [("clipPath", "clips"), ("filter", "filters"), ("marker", "markers"), ("mask", "masks")];
const DRAWN: [(&str, &str); 3] =
    [("foreignObject", "foreign objects"), ("image", "pictures"), ("text", "text")];
/// Elements that become a plain colour.
const PAINTS: [&str; 3] = ["linearGradient", "pattern", "radialGradient"];

/// The maximum number of bytes that the entities of a document may expand to.
const MAX_ENTITY_BYTES: usize = 64 << 20;
const MAX_NODES: u32 = 2_000_000;

/// A document without the elements that usvg must not follow.
pub(super) struct ReducedDocument {
    pub(super) text: String,
    /// Names of the removed elements.
    pub(super) removed: BTreeSet<&'static str>,
}

impl ReducedDocument {
    /// # Errors
    /// Text that is not XML, or too large once its entities are replaced; invalid path data, with its
    /// line.
    pub(super) fn new(text: &str) -> Result<Self> {
        let bytes = entity_bytes(text);
        if bytes > MAX_ENTITY_BYTES {
            let expected = format!("entities of at most {MAX_ENTITY_BYTES} bytes");
            return Err(Error::invalid("SVG document", "larger than it looks", expected));
        }
        let options =
            ParsingOptions { allow_dtd: true, nodes_limit: MAX_NODES, ..ParsingOptions::default() };
        let document = Document::parse_with_options(text, options).map_err(|error| {
            Error::invalid("SVG document", "not readable", format!("valid SVG ({error})"))
        })?;
        let mut removed = BTreeSet::new();
        let mut edits: Vec<(Range<usize>, String)> = Vec::new();
        for node in document.descendants().filter(Node::is_element) {
            let name = node.tag_name();
            if name.namespace() != Some(NAMESPACE) {
                continue;
            }
            let is = |(element, _): &&(&str, &str)| *element == name.name();
            if let Some((_, called)) = REFERRED.iter().find(is) {
                removed.insert(*called);
                edits.push((node.range(), String::new()));
            } else if let Some((_, called)) = DRAWN.iter().find(is) {
                if !node.ancestors().any(|node| node.has_tag_name((NAMESPACE, "defs"))) {
                    removed.insert(*called);
                }
                edits.push((node.range(), String::new()));
            } else if PAINTS.contains(&name.name()) {
                edits.push((node.range(), plain_paint(node.attribute("id").unwrap_or_default())));
            } else if let ("path", Some(data)) = (name.name(), node.attribute("d")) {
                check_path(data).map_err(|error| {
                    error.within(format!("line {}", document.text_pos_at(node.range().start).row))
                })?;
            }
        }
        Ok(Self { text: edited(text, edits), removed })
    }
}

/// A paint with the given id that fills every shape that refers to it.
fn plain_paint(id: &str) -> String {
    let mut escaped = String::new();
    for char in id.chars() {
        // Writing to a string cannot fail.
        let _ = write!(escaped, "&#{};", u32::from(char));
    }
    format!("<linearGradient xmlns='{NAMESPACE}' id='{escaped}'><stop/></linearGradient>")
}

fn check_path(data: &str) -> Result<()> {
    PathParser::from(data)
        .try_for_each(|segment| segment.map(|_| ()))
        .map_err(|error| unreadable_path(data, &error))
}

/// The text with ranges replaced. An edit that lies inside the range of another edit is dropped.
fn edited(text: &str, mut edits: Vec<(Range<usize>, String)>) -> String {
    edits.sort_by_key(|(range, _)| (range.start, std::cmp::Reverse(range.end)));
    let mut result = String::with_capacity(text.len());
    let mut at = 0;
    for (range, replacement) in edits {
        if range.start >= at {
            result.push_str(&text[at..range.start]);
            result.push_str(&replacement);
            at = range.end;
        }
    }
    result.push_str(&text[at..]);
    result
}

/// An upper bound of the number of bytes that the entities of a document expand to. Each reference expands to the
/// longest declared value at most, and the XML parser follows up to 255 more references inside it.
fn entity_bytes(text: &str) -> usize {
    let values = || text.split("<!ENTITY").skip(1).filter_map(quoted);
    let longest = values().map(str::len).max().unwrap_or(0);
    let nested = if values().any(|value| value.contains('&')) { 256 } else { 1 };
    text.matches('&').count().saturating_mul(longest).saturating_mul(nested)
}

/// The first text in quotes.
fn quoted(text: &str) -> Option<&str> {
    let start = text.find(['"', '\''])?;
    let (quote, value) = text[start..].split_at(1);
    Some(value.split(quote).next().unwrap_or(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_not_filled_is_taken_out() {
        let text = "<svg xmlns='http://www.w3.org/2000/svg' xmlns:o='other'><defs>\
            <mask id='a'><text>unseen</text></mask><pattern id='p&lt;'><path d='M0 0'/></pattern>\
            </defs><o:mask/><rect fill='url(#p)'/><image/><text/></svg>";
        let ReducedDocument { text, removed } = ReducedDocument::new(text).unwrap();
        assert_eq!(Vec::from_iter(removed), ["masks", "pictures", "text"]);
        let paint = plain_paint("p<");
        assert_eq!(
            text,
            format!(
                "<svg xmlns='http://www.w3.org/2000/svg' xmlns:o='other'><defs>{paint}</defs>\
                 <o:mask/><rect fill='url(#p)'/></svg>"
            )
        );
        assert_eq!(Document::parse(&paint).unwrap().root_element().attribute("id"), Some("p<"));
    }

    #[test]
    fn entities_are_bounded_before_they_are_replaced() {
        let document = |value: &str, body: &str| {
            // A false end of the declarations, and a true end with a space in it.
            format!(
                "<!DOCTYPE svg [<!ENTITY a ']>'><!ENTITY e '{value}'>] ><svg xmlns='{NAMESPACE}'>\
                 {body}</svg>"
            )
        };
        assert!(ReducedDocument::new(&document("word", "&e;&e;")).is_ok());
        let large = document(&"x".repeat(100_000), &"&e;".repeat(1_000));
        let error = ReducedDocument::new(&large).err().unwrap().to_string();
        assert!(error.contains("larger than it looks"), "{error}");
        let nested = document(&"&f;".repeat(200), &"&e;".repeat(1_000));
        assert!(entity_bytes(&nested) > MAX_ENTITY_BYTES);
    }
}
