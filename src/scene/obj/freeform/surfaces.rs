//! Surfaces from the statements of a file, once all control points are known.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3, DVec4};

use super::FreeForm;
use crate::bezier::{Degree, NurbsSurface, check_control_point, check_coordinates, points_between};
use crate::error::Error;
use crate::scene::Surface;
use crate::scene::obj::reader::out_of_range;
use crate::trim::{Keep, ParameterSizes, Rect, TrimCurve, TrimLoop, Trims};

/// The maximum number of control points of all Bézier patches that the NURBS surfaces of a file are cut into: 512 MiB.
/// The text of such a surface may be 500 times as small.
const MAX_PATCH_POINTS: usize = 1 << 24;
/// The maximum number of segments of all trimming loops of a file: 300 MiB. Loops may share curves, so that their text
/// may be short.
const MAX_SEGMENTS: usize = 1 << 22;
/// The maximum number of Bézier curves of a loop, each of which becomes one segment or more.
const MAX_PIECES: usize = 1 << 20;
/// Gaps between consecutive trimming curves up to this share of the domain are closed by a line. Programs join these
/// curves within a tolerance in space, and write them with few digits.
const MAX_GAP: f64 = 1e-3;

/// The ends of a surface's range are ends of its domain if they are this close, as a share of the domain: programs
/// write them with few digits. The same holds for the ends of parts of curves.
pub(super) const SAME_END: f64 = 1e-6;

/// A trimming curve.
#[derive(Debug)]
pub(super) struct Curve {
    pub(super) line: usize,
    pub(super) rational: bool,
    pub(super) degree: usize,
    pub(super) knots: Vec<f64>,
    /// Indices of parameter vertices, from 0.
    pub(super) points: Vec<u32>,
}

/// A surface. Its control points are indices from 0, row by row, with u along a row.
#[derive(Debug)]
pub(super) struct FreeSurface {
    pub(super) line: usize,
    pub(super) degree: Degree,
    pub(super) rational: bool,
    pub(super) points: Vec<u32>,
    /// `None` for a Bézier patch without trims over the domain [0, 1]².
    pub(super) nurbs: Option<Box<NurbsParts>>,
}

#[derive(Debug)]
pub(super) struct NurbsParts {
    pub(super) knots: [Vec<f64>; 2],
    /// The parameters from the first of which to the second the surface is kept, if it does not go on to the end of the
    /// domain: along u, then along v.
    pub(super) limits: [[Option<f64>; 2]; 2],
    pub(super) loops: Vec<Loop>,
}

/// The statement `trim` or `hole`.
#[derive(Debug)]
pub(super) struct Loop {
    pub(super) line: usize,
    pub(super) is_hole: bool,
    pub(super) parts: Vec<Part>,
}

/// A part of a trimming curve, from one parameter to another.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub(super) ends: [f64; 2],
    pub(super) curve: u32,
}

/// A line of the file and what is wrong there.
type Fault = (usize, String);

impl FreeForm {
    /// Takes the surfaces. Bézier patches without trims are one surface for each degree that occurs.
    ///
    /// # Errors
    /// A control point or vertex that does not exist, or whose weight is not from 1e-9 to 1e9; trimming curves that are
    /// no loop; more patches or segments than the limits: the line and a message.
    pub(in crate::scene::obj) fn take_surfaces(
        &mut self,
        positions: &[DVec3],
        weights: &[f64],
    ) -> Result<Vec<Surface>, Fault> {
        for curve in self.curves.iter().flatten() {
            curve.check_points(&self.vertices)?;
        }
        let mut patches: BTreeMap<Degree, Vec<DVec4>> = BTreeMap::new();
        let mut others = Vec::new();
        let mut used = Used::default();
        for FreeSurface { line, degree, rational, points, nurbs } in
            std::mem::take(&mut self.surfaces)
        {
            let at_line = |error: Error| (line, error.to_string());
            let points = points
                .into_iter()
                .map(|index| control_point(index as usize, positions, rational.then_some(weights)));
            let Some(nurbs) = nurbs else {
                let patches = patches.entry(degree).or_default();
                for point in points {
                    patches.push(point.map_err(|message| (line, message))?);
                }
                continue;
            };
            let NurbsParts { knots, limits, loops } = *nurbs;
            used.add_patches(degree, &knots).map_err(|message| (line, message))?;
            let points: Vec<DVec4> =
                points.collect::<Result<_, _>>().map_err(|message| (line, message))?;
            let nurbs = NurbsSurface::new(degree, knots, points).map_err(at_line)?;
            let mut surface = Surface::from_nurbs(nurbs);
            surface.trims = self.trims(&loops, &surface.parameter_sizes(), &mut used)?;
            surface.trims.rects = beyond(limits, surface.domain());
            others.push(surface);
        }
        let mut surfaces = Vec::with_capacity(patches.len() + others.len());
        for (degree, points) in patches {
            surfaces.push(Surface::new(degree, points).map_err(|error| (1, error.to_string()))?);
        }
        surfaces.append(&mut others);
        Ok(surfaces)
    }

    /// The trims of a surface. If its first loop is a hole, its border is that of the domain.
    fn trims(
        &self,
        loops: &[Loop],
        sizes: &ParameterSizes,
        used: &mut Used,
    ) -> Result<Trims, Fault> {
        let begins_with_border = loops.first().is_some_and(|one| !one.is_hole);
        let keep = if begins_with_border { Keep::Inside } else { Keep::Outside };
        let mut trims = Trims { keep, ..Trims::default() };
        let mut segments = 0;
        for Loop { line, is_hole, parts } in loops {
            let name = if *is_hole { "hole" } else { "trim" };
            let fail = |error: Error| (*line, error.within(name).to_string());
            used.pieces_of_loop = 0;
            let mut curves = Vec::with_capacity(parts.len());
            for part in parts {
                let curve = self.curves[part.curve as usize].as_ref();
                let curve = curve.expect("loops with unsupported curves are left out");
                let part = curve.part(part.ends, &self.vertices, used);
                curves.push(part.map_err(fail)?);
            }
            let trim_loop =
                TrimLoop::from_curves_with_gaps(curves, sizes, MAX_GAP).map_err(fail)?;
            let count = trim_loop.segments().len();
            used.add_segments(count).map_err(fail)?;
            trims.add_loop_to(trim_loop, segments).map_err(fail)?;
            segments += count;
        }
        Ok(trims)
    }
}

fn check_count(name: &str, count: usize, max: usize) -> Result<(), Error> {
    if count > max { Err(Error::invalid(name, count, format!("at most {max}"))) } else { Ok(()) }
}

/// How much the surfaces of a file have taken of what is limited.
#[derive(Default)]
struct Used {
    patch_points: usize,
    segments: usize,
    /// Bézier curves of the loop that is being read.
    pieces_of_loop: usize,
}

impl Used {
    fn add_patches(&mut self, degree: Degree, knots: &[Vec<f64>; 2]) -> Result<(), String> {
        let count = NurbsSurface::points_of_patches(degree, knots);
        self.patch_points = self.patch_points.saturating_add(count);
        if self.patch_points > MAX_PATCH_POINTS {
            return Err(format!(
                "up to this surface there are {} control points of Bézier patches; expected at most \
                 {MAX_PATCH_POINTS}",
                self.patch_points
            ));
        }
        Ok(())
    }

    fn add_pieces(&mut self, count: usize) -> Result<(), Error> {
        self.pieces_of_loop += count;
        check_count("number of Bézier curves of the loop", self.pieces_of_loop, MAX_PIECES)
    }

    fn add_segments(&mut self, count: usize) -> Result<(), Error> {
        self.segments += count;
        check_count("number of segments of all loops of the file", self.segments, MAX_SEGMENTS)
    }
}

impl Curve {
    /// The first and the last parameter.
    fn domain(&self) -> [f64; 2] {
        [self.knots[self.degree], self.knots[self.points.len()]]
    }

    /// Checks that a part of the curve exists and is not empty.
    pub(super) fn check_part(&self, ends: [f64; 2]) -> Result<(), String> {
        let [first, last] = self.domain();
        let slack = SAME_END * (last - first);
        if ends.iter().any(|end| *end < first - slack || *end > last + slack) {
            return Err(format!(
                "the part from {} to {} of a curve; expected parameters from {first} to {last}",
                ends[0], ends[1]
            ));
        }
        let [low, high] = ends.map(|end| end.clamp(first, last));
        if low == high {
            return Err(format!(
                "the part from {} to {} of a curve; expected two different parameters",
                ends[0], ends[1]
            ));
        }
        Ok(())
    }

    /// Checks its parameter vertices, so that every part of it can be made.
    fn check_points(&self, vertices: &[DVec3]) -> Result<(), Fault> {
        let fail = |message| Err((self.line, message));
        for index in &self.points {
            let number = i64::from(*index) + 1;
            let Some(vertex) = vertices.get(*index as usize) else {
                return fail(out_of_range(number, "parameter vertex", vertices.len()));
            };
            if vertex.y.is_nan() {
                return fail(format!("parameter vertex {number} has 1 number; expected u and v"));
            }
            let place = vertex.truncate().extend(0.0);
            let checked = check_coordinates(format!("parameter vertex {number}"), place);
            let checked = match self.rational && !(1e-9..=1e9).contains(&vertex.z) {
                true => checked.and(Err(Error::invalid(
                    format!("weight of parameter vertex {number}"),
                    vertex.z,
                    "a number above 0, from 1e-9 to 1e9",
                ))),
                false => checked,
            };
            checked.map_err(|error| (self.line, error.to_string()))?;
        }
        Ok(())
    }

    /// A part of the curve. The work is that of the part, not of the curve.
    fn part(
        &self,
        ends: [f64; 2],
        vertices: &[DVec3],
        used: &mut Used,
    ) -> Result<TrimCurve, Error> {
        let [first, last] = self.domain();
        let ends = ends.map(|end| end.clamp(first, last));
        let there = [ends[0].min(ends[1]), ends[0].max(ends[1])];
        let range = points_between(self.degree, &self.knots, there);
        used.add_pieces(range.len() - self.degree)?;
        let knots = &self.knots[range.start..range.end + self.degree + 1];
        let point = |index: &u32| {
            let vertex = vertices[*index as usize];
            if self.rational { vertex } else { vertex.truncate().extend(1.0) }
        };
        let points: Vec<DVec3> = self.points[range].iter().map(point).collect();
        TrimCurve::nurbs_part(self.degree, knots, &points, ends)
    }
}

/// A control point with its weight; without `weights` this is 1.
fn control_point(
    index: usize,
    positions: &[DVec3],
    weights: Option<&[f64]>,
) -> Result<DVec4, String> {
    let number = index as i64 + 1;
    let Some(position) = positions.get(index) else {
        return Err(out_of_range(number, "position", positions.len()));
    };
    let weight = weights.and_then(|weights| weights.get(index)).copied().unwrap_or(1.0);
    let point = position.extend(weight);
    // The reader has checked the coordinates.
    check_control_point(point, index).map_err(|_| {
        format!("the weight of position {number} is {weight}; expected above 0, from 1e-9 to 1e9")
    })?;
    Ok(point)
}

/// The rectangles of a domain beyond the limits along u and v.
fn beyond(limits: [[Option<f64>; 2]; 2], [low, high]: [DVec2; 2]) -> Vec<Rect> {
    let mut rects = Vec::new();
    for (axis, [first, last]) in limits.into_iter().enumerate() {
        // The limits themselves are kept.
        let before = first.map(|first| [low[axis], first.next_down()]);
        let after = last.map(|last| [last.next_up(), high[axis]]);
        for range in [before, after].into_iter().flatten() {
            let mut bounds = [[low.x, high.x], [low.y, high.y]];
            bounds[axis] = range;
            let [u, v] = bounds.map(DVec2::from_array);
            rects.push(Rect { u, v });
        }
    }
    rects
}
