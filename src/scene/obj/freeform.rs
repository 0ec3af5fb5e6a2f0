//! Free-form surfaces of OBJ files: Bézier and B-spline surfaces with their trimming curves.
//!
//! A curve or surface is a statement `surf`, `curv2` or `curv`, followed by statements about it up to `end`. These are
//! checked here as they come. Control points may be defined further down in the file, so surfaces are made at the end:
//! see `surfaces.rs`.

mod style;
mod surfaces;

use std::collections::BTreeMap;

use glam::DVec3;

use super::counted;
use super::reader::{finite, index, out_of_range};
use crate::bezier::Degree;
use crate::error::shortened;

use style::Style;
use surfaces::{Curve, FreeSurface, Loop, NurbsParts, Part, SAME_END};

/// State of the free-form statements that were read.
#[derive(Debug, Default)]
pub(super) struct FreeForm {
    style: Style,
    /// From `vp`: (u, v, weight). Where v was not given it is NaN.
    vertices: Vec<DVec3>,
    element: Option<Element>,
    /// By number; `None` for curves of an unsupported kind.
    curves: Vec<Option<Curve>>,
    surfaces: Vec<FreeSurface>,
    /// Unsupported elements, with their counts.
    left_out: BTreeMap<String, usize>,
}

/// A curve or surface whose `end` was not read yet.
#[derive(Debug)]
struct Element {
    /// The line where it begins.
    line: usize,
    content: Content,
    /// The numbers of `parm u` and `parm v`.
    parameters: [Vec<f64>; 2],
}

#[derive(Debug)]
enum Content {
    /// A curve in space.
    SpaceCurve,
    /// The indices of the parameter vertices of a trimming curve.
    Curve(Vec<u32>),
    Surface {
        /// The indices of the control points.
        points: Vec<u32>,
        /// The first and the last parameter along u and along v.
        range: [[f64; 2]; 2],
        loops: Vec<Loop>,
        /// Whether a `trim` was left out.
        lacks_border: bool,
    },
}

impl FreeForm {
    /// Reads a statement; others than those of free-form curves and surfaces are ignored. `count` is the number of
    /// positions above it.
    ///
    /// # Errors
    /// Statements that are malformed, or that do not fit the curve or surface that they belong to.
    pub(super) fn statement<'a>(
        &mut self,
        name: &str,
        words: &mut impl Iterator<Item = &'a str>,
        count: usize,
        line: usize,
    ) -> Result<(), String> {
        match name {
            "vp" => self.vertices.push(vertex(words)?),
            "cstype" => self.style.set_kind(words)?,
            "deg" => self.style.set_degrees(words)?,
            "surf" => {
                let range = [range("u", words)?, range("v", words)?];
                let points = words.map(|word| {
                    let position = word.split('/').next().unwrap_or_default();
                    index(position, "position", count)
                });
                let points = points.collect::<Result<_, _>>()?;
                self.begin(
                    Content::Surface { points, range, loops: Vec::new(), lacks_border: false },
                    line,
                )?;
            }
            "curv2" => {
                let count = self.vertices.len();
                let points = words.map(|word| index(word, "parameter vertex", count));
                let points = points.collect::<Result<_, _>>()?;
                self.begin(Content::Curve(points), line)?;
            }
            "curv" => {
                self.leave_out("curve in space");
                self.begin(Content::SpaceCurve, line)?;
            }
            "parm" => self.parameters(words)?,
            "trim" | "hole" => self.trimming(name, words, line)?,
            "end" => {
                let element = self.element.take();
                let element = element.ok_or("end is here without surf, curv2 or curv before it")?;
                self.end(element)?;
            }
            "scrv" | "sp" | "con" | "ctech" | "stech" | "bmat" | "step" | "bzp" | "bsp" | "cdc"
            | "cdp" | "res" => self.leave_out(format!("{name} statement")),
            _ => {}
        }
        Ok(())
    }

    /// Checks that no curve or surface is left without its end: the line and a message.
    pub(super) fn finish(&self) -> Result<(), (usize, String)> {
        match &self.element {
            Some(element) => Err((element.line, format!("{} has no end", element.content.name()))),
            None => Ok(()),
        }
    }

    fn leave_out(&mut self, what: impl Into<String>) {
        *self.left_out.entry(what.into()).or_default() += 1;
    }

    fn begin(&mut self, content: Content, line: usize) -> Result<(), String> {
        if let Some(before) = &self.element {
            let (name, line) = (before.content.name(), before.line);
            return Err(format!("{} before the end of {name} of line {line}", content.name()));
        }
        self.element = Some(Element { line, content, parameters: [Vec::new(), Vec::new()] });
        Ok(())
    }

    fn parameters<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let element = self.element.as_mut();
        let element =
            element.ok_or("parm outside of a curve or surface, which goes up to its end")?;
        let axis = match words.next() {
            Some("u") => 0,
            Some("v") => 1,
            other => {
                let other = shortened(other.unwrap_or_default());
                return Err(format!("parm begins with \"{other}\"; expected u or v"));
            }
        };
        element.parameters[axis] = words.map(finite).collect::<Result<_, _>>()?;
        Ok(())
    }

    /// Adds a trimming loop to the current surface.
    fn trimming<'a>(
        &mut self,
        name: &str,
        mut words: impl Iterator<Item = &'a str>,
        line: usize,
    ) -> Result<(), String> {
        let Some(Content::Surface { loops, lacks_border, .. }) =
            self.element.as_mut().map(|it| &mut it.content)
        else {
            return Err(format!("{name} outside of a surface; expected between surf and its end"));
        };
        let mut parts = Vec::new();
        let mut is_left_out = false;
        while let Some(first) = words.next() {
            let (Some(last), Some(number)) = (words.next(), words.next()) else {
                return Err(format!("{name} ends in the middle of a part; expected {PARTS}"));
            };
            let ends = [finite(first)?, finite(last)?];
            let count = self.curves.len();
            let curve = index(number, "trimming curve", count)?;
            match self.curves.get(curve as usize) {
                None => {
                    // Unlike control points, trimming curves are defined before they are used.
                    return Err(out_of_range(i64::from(curve) + 1, "trimming curve", count));
                }
                Some(None) => is_left_out = true,
                Some(Some(known)) => {
                    known.check_part(ends).map_err(|problem| format!("{name}: {problem}"))?;
                }
            }
            parts.push(Part { ends, curve });
        }
        if parts.is_empty() {
            return Err(format!("{name} has no part; expected {PARTS}"));
        }
        let is_hole = name == "hole";
        if is_left_out {
            *lacks_border |= !is_hole;
            self.leave_out(format!("{name} statement with unsupported curves"));
        } else {
            loops.push(Loop { line, is_hole, parts });
        }
        Ok(())
    }

    fn end(&mut self, element: Element) -> Result<(), String> {
        let Element { line, content, parameters } = element;
        match content {
            Content::SpaceCurve => {}
            Content::Curve(points) => {
                let curve = self.curve(points, &parameters[0], line)?;
                self.curves.push(curve);
            }
            Content::Surface { points, range, mut loops, lacks_border } => {
                if lacks_border {
                    // Without it, the first of the others would be the border of all.
                    loops.retain(|one| one.is_hole);
                }
                let surface = self.surface(points, &parameters, range, loops, line)?;
                self.surfaces.extend(surface);
            }
        }
        Ok(())
    }

    /// The curve of a `curv2`; `None` if its kind or degree is not supported.
    fn curve(
        &mut self,
        points: Vec<u32>,
        parameters: &[f64],
        line: usize,
    ) -> Result<Option<Curve>, String> {
        let Style { rational, degrees: [degree, _], .. } = self.style;
        if let Some(unsupported) = self.style.unsupported("curve", &[degree])? {
            self.leave_out(unsupported);
            return Ok(None);
        }
        let expected = self.style.points_along("u", degree, parameters)?;
        if points.len() != expected {
            return Err(format!(
                "the curve has {} parameter vertices; its degree and parameters expect {expected}",
                points.len()
            ));
        }
        let knots = self.style.knots("u", degree, parameters, expected)?;
        Ok(Some(Curve { line, rational, degree, knots, points }))
    }

    /// The surface of a `surf`; `None` if its kind or degrees are not supported.
    fn surface(
        &mut self,
        points: Vec<u32>,
        parameters: &[Vec<f64>; 2],
        range: [[f64; 2]; 2],
        loops: Vec<Loop>,
        line: usize,
    ) -> Result<Option<FreeSurface>, String> {
        let Style { rational, degrees: [u, v], .. } = self.style;
        let style = &self.style;
        if let Some(unsupported) = style.unsupported("surface", &[u, v])? {
            self.leave_out(unsupported);
            return Ok(None);
        }
        let degree = Degree::new(u, v).map_err(|error| error.to_string())?;
        let columns = style.points_along("u", u, &parameters[0])?;
        let rows = style.points_along("v", v, &parameters[1])?;
        if columns.checked_mul(rows) != Some(points.len()) {
            return Err(format!(
                "the surface has {} control points; its degrees and parameters expect {columns}×{rows}",
                points.len()
            ));
        }
        let knots = [
            style.knots("u", u, &parameters[0], columns)?,
            style.knots("v", v, &parameters[1], rows)?,
        ];
        let limits = [
            limits("u", [knots[0][u], knots[0][columns]], range[0])?,
            limits("v", [knots[1][v], knots[1][rows]], range[1])?,
        ];
        let is_unit = |parameters: &Vec<f64>| matches!(parameters[..], [] | [0.0, 1.0]);
        let is_patch = style.is_bezier()
            && parameters.iter().all(is_unit)
            && limits == [[None; 2]; 2]
            && loops.is_empty();
        let nurbs = (!is_patch).then(|| Box::new(NurbsParts { knots, limits, loops }));
        Ok(Some(FreeSurface { line, degree, rational, points, nurbs }))
    }

    /// How many Bézier patches there are without trims.
    pub(super) fn patches(&self) -> usize {
        self.surfaces.len() - self.nurbs_surfaces()
    }

    /// How many other surfaces there are.
    pub(super) fn nurbs_surfaces(&self) -> usize {
        self.surfaces.iter().filter(|surface| surface.nurbs.is_some()).count()
    }

    /// The unsupported elements in words: "2 cardinal surfaces".
    pub(super) fn left_out(&self) -> Vec<String> {
        let counted = |(name, count): (&String, &usize)| {
            // The noun comes before these words.
            let end = [" in ", " with ", " of "].iter().filter_map(|words| name.find(words)).min();
            let (noun, rest) = name.split_at(end.unwrap_or(name.len()));
            format!("{}{rest}", counted(*count, noun))
        };
        self.left_out.iter().map(counted).collect()
    }
}

/// What the words after `trim` and `hole` are.
const PARTS: &str =
    "the first and the last parameter and the number of a curve, once for each curve";

impl Content {
    const fn name(&self) -> &'static str {
        match self {
            Self::SpaceCurve => "curv",
            Self::Curve(_) => "curv2",
            Self::Surface { .. } => "surf",
        }
    }
}

/// The numbers of `vp`.
fn vertex<'a>(words: impl Iterator<Item = &'a str>) -> Result<DVec3, String> {
    let mut vertex = DVec3::new(0.0, f64::NAN, 1.0);
    let mut count = 0;
    for word in words {
        let value = finite(word)?;
        if count < 3 {
            vertex[count] = value;
        }
        count += 1;
    }
    match count {
        1..=3 => Ok(vertex),
        _ => Err(format!("the parameter vertex has {count} numbers; expected u v, or u v weight")),
    }
}

/// The next two numbers of `surf`: the first and the last parameter along an axis.
fn range<'a>(axis: &str, words: &mut impl Iterator<Item = &'a str>) -> Result<[f64; 2], String> {
    let mut end = || finite(words.next().unwrap_or_default());
    let range = [end()?, end()?];
    if range[0] < range[1] {
        return Ok(range);
    }
    let [first, last] = range;
    Err(format!("the range along {axis} is {first} to {last}; expected first < last"))
}

/// Where a range ends within a domain.
fn limits(
    axis: &str,
    [first, last]: [f64; 2],
    range: [f64; 2],
) -> Result<[Option<f64>; 2], String> {
    if range[0] >= last || range[1] <= first {
        let [low, high] = range;
        return Err(format!(
            "the range along {axis} of the surface is {low} to {high}; expected a part of {first} to {last}"
        ));
    }
    let slack = SAME_END * (last - first);
    Ok([
        Some(range[0]).filter(|end| *end > first + slack),
        Some(range[1]).filter(|end| *end < last - slack),
    ])
}
