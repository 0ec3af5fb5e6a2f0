//! Trims: the regions that are cut out of a surface, as plain data over its (u, v) domain.
//!
//! Each circle, rectangle and ellipse cuts its inside. Loops are combined by the even-odd rule: a loop inside a loop
//! is an island that stays. Each path has its own fill rule.

mod by_patch;
mod curve;
mod exact;
mod fill;
mod grid;
mod inside;
mod path;
mod pieces;
mod shapes;
#[cfg(feature = "svg")]
mod svg;
mod uniform_grid;

use glam::DVec2;

pub(crate) use by_patch::{PatchTrims, trims_by_patch};
pub use curve::TrimCurve;
pub use exact::TrimGrid;
pub use fill::{FillRule, TrimPath};
pub use inside::{inside_loops, ray_crossings, winding_number};
#[cfg(feature = "svg")]
pub(crate) use svg::read as read_svg;

use crate::bezier::{MAX_COORDINATE, bounding_box, check_coordinates};
use crate::error::{Error, Result};

/// Ends of neighbouring curves that are closer than this, as a share of the domain, are merged into one point.
const SNAP: f64 = 1e-6;

/// Sizes along u and v of the parameters of a surface, to which tolerances of its trims are relative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterSizes {
    /// Of the domain.
    pub domain: DVec2,
    /// Of the smallest patch.
    pub patch: DVec2,
}

impl Default for ParameterSizes {
    /// Those of Bézier patches, whose domains are [0, 1]².
    fn default() -> Self {
        Self { domain: DVec2::ONE, patch: DVec2::ONE }
    }
}

impl ParameterSizes {
    /// The largest powers of two that are not above the sizes of a patch. Scaling by them does not round.
    fn unit(&self) -> DVec2 {
        self.patch.to_array().map(|size| size.log2().floor().exp2()).into()
    }
}

/// The maximum number of segments in all loops of one surface.
const MAX_SEGMENTS: usize = 1_000_000;

/// Checks the number of segments of a loop; the loops before it have `others` segments.
fn check_count(number: usize, count: usize, others: usize) -> Result<()> {
    if others + count > MAX_SEGMENTS {
        let segment = MAX_SEGMENTS - others;
        return Err(Error::invalid(
            format!("loop {number}, segment {segment}"),
            "one too many",
            format!("at most {MAX_SEGMENTS} in all loops of a surface"),
        ));
    }
    Ok(())
}

/// Checks the number of segments of each loop in order. The first loop has the number `first`; the loops before it
/// have `others` segments.
fn check_counts(loops: &[TrimLoop], first: usize, mut others: usize) -> Result<()> {
    for (number, trim_loop) in (first..).zip(loops) {
        check_count(number, trim_loop.segments.len(), others)?;
        others += trim_loop.segments.len();
    }
    Ok(())
}

fn check_finite(name: &str, point: DVec2) -> Result<()> {
    check_coordinates(name, point.extend(0.0))
        .map_err(|_| Error::invalid(name, point, "finite coordinates of at most 1e15"))
}

fn check_radius(name: &str, radius: f64) -> Result<()> {
    if (0.0..=MAX_COORDINATE).contains(&radius) {
        Ok(())
    } else {
        Err(Error::invalid(name, radius, "a finite number, 0 or above, at most 1e15"))
    }
}

/// Cuts every (u, v) closer to `center` than `radius` (thesis, section 3.1.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Centre in the domain.
    pub center: DVec2,
    /// Radius in the domain's unit; 0 cuts nothing.
    pub radius: f64,
}

impl Circle {
    /// A circle in the domain.
    ///
    /// # Errors
    /// A centre or radius that is not finite or above 1e15, a negative radius.
    pub fn new(center: DVec2, radius: f64) -> Result<Self> {
        check_finite("circle center", center)?;
        check_radius("circle radius", radius)?;
        Ok(Self { center, radius })
    }

    /// Whether `uv` is cut.
    #[must_use]
    pub fn cuts(&self, uv: DVec2) -> bool {
        uv.distance(self.center) < self.radius
    }
}

/// Cuts the closed rectangle `u` × `v` (thesis, section 3.1.1).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rect {
    /// Lower and upper bound of u.
    pub u: DVec2,
    /// Lower and upper bound of v.
    pub v: DVec2,
}

impl Rect {
    /// A rectangle in the domain.
    ///
    /// # Errors
    /// A bound that is not finite or above 1e15, or a first bound above its last.
    pub fn new(u: DVec2, v: DVec2) -> Result<Self> {
        for (name, range) in [("interval u", u), ("interval v", v)] {
            check_finite(name, range)?;
            if range.x > range.y {
                return Err(Error::invalid(name, range, "[first, last] with first ≤ last"));
            }
        }
        Ok(Self { u, v })
    }

    /// Whether `uv` is cut.
    #[must_use]
    pub fn cuts(&self, uv: DVec2) -> bool {
        (self.u.x..=self.u.y).contains(&uv.x) && (self.v.x..=self.v.y).contains(&uv.y)
    }
}

/// Cuts the closed ellipse with axes along u and v (thesis, section 3.1.3, formula 14).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ellipse {
    /// Centre in the domain.
    pub center: DVec2,
    /// Semi-axes along u and v; if one of them is 0, the ellipse cuts nothing.
    pub radii: DVec2,
}

impl Ellipse {
    /// An ellipse in the domain.
    ///
    /// # Errors
    /// A centre or radius that is not finite or above 1e15, a negative radius.
    pub fn new(center: DVec2, radii: DVec2) -> Result<Self> {
        check_finite("ellipse center", center)?;
        check_radius("ellipse radius along u", radii.x)?;
        check_radius("ellipse radius along v", radii.y)?;
        Ok(Self { center, radii })
    }

    /// Whether `uv` is cut.
    #[must_use]
    pub fn cuts(&self, uv: DVec2) -> bool {
        let d = uv - self.center;
        let r = self.radii;
        r.cmpgt(DVec2::ZERO).all() && (d * d / (r * r)).element_sum() <= 1.0
    }
}

/// One curve of a loop in Bézier form.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Segment {
    /// From the first point straight to the second.
    Line([DVec2; 2]),
    /// Quadratic Bézier curve.
    Quadratic([DVec2; 3]),
    /// Cubic Bézier curve.
    Cubic([DVec2; 4]),
}

impl Segment {
    /// A line, quadratic or cubic from 2, 3 or 4 control points.
    ///
    /// # Errors
    /// Another number of points.
    pub fn new(points: &[DVec2]) -> Result<Self> {
        match *points {
            [a, b] => Ok(Self::Line([a, b])),
            [a, b, c] => Ok(Self::Quadratic([a, b, c])),
            [a, b, c, d] => Ok(Self::Cubic([a, b, c, d])),
            _ => Err(Error::invalid(
                "number of points of a segment",
                points.len(),
                "2 (line), 3 (quadratic) or 4 (cubic)",
            )),
        }
    }

    /// The control points.
    #[must_use]
    pub const fn points(&self) -> &[DVec2] {
        match self {
            Self::Line(points) => points,
            Self::Quadratic(points) => points,
            Self::Cubic(points) => points,
        }
    }

    pub(crate) const fn points_mut(&mut self) -> &mut [DVec2] {
        match self {
            Self::Line(points) => points,
            Self::Quadratic(points) => points,
            Self::Cubic(points) => points,
        }
    }

    pub(crate) fn map(&self, to: impl Fn(DVec2) -> DVec2) -> Self {
        match self {
            Self::Line(points) => Self::Line(points.map(to)),
            Self::Quadratic(points) => Self::Quadratic(points.map(to)),
            Self::Cubic(points) => Self::Cubic(points.map(to)),
        }
    }

    /// The point at the parameter `t`, which is 0 at the start and 1 at the end.
    #[must_use]
    pub fn point(&self, t: f64) -> DVec2 {
        let s = 1.0 - t;
        match *self {
            Self::Line([a, b]) => a * s + b * t,
            Self::Quadratic([a, b, c]) => a * (s * s) + b * (2.0 * s * t) + c * (t * t),
            Self::Cubic([a, b, c, d]) => {
                a * (s * s * s) + b * (3.0 * s * s * t) + c * (3.0 * s * t * t) + d * (t * t * t)
            }
        }
    }

    /// First point of the curve.
    #[must_use]
    pub const fn start(&self) -> DVec2 {
        self.points()[0]
    }

    /// Last point of the curve.
    #[must_use]
    pub const fn end(&self) -> DVec2 {
        let points = self.points();
        points[points.len() - 1]
    }
}

/// A closed chain of segments: each starts where the one before it ends, and the first starts where the last ends.
#[derive(Debug, Clone, PartialEq)]
pub struct TrimLoop {
    segments: Vec<Segment>,
}

impl TrimLoop {
    /// Closes the chain in the domain [0, 1]²: gaps below 1e-6 are snapped shut.
    ///
    /// # Errors
    /// No segment or more than 1,000,000, a point that is not finite or has coordinates above 1e15, a gap of 1e-6 or
    /// more. Segments are numbered from 0.
    pub fn new(segments: Vec<Segment>) -> Result<Self> {
        Self::closed(segments, DVec2::ONE)
    }

    /// The same in a domain of the given size. Gaps are relative to it.
    pub(crate) fn closed(mut segments: Vec<Segment>, domain: DVec2) -> Result<Self> {
        if segments.is_empty() {
            return Err(Error::invalid("loop", "empty", "at least one segment"));
        }
        for (i, segment) in segments.iter().enumerate() {
            for point in segment.points() {
                check_finite("a point", *point)
                    .map_err(|error| error.within(format!("segment {i}")))?;
            }
        }
        let count = segments.len();
        if count > MAX_SEGMENTS {
            let segment = format!("segment {MAX_SEGMENTS}");
            return Err(Error::invalid(segment, "one too many", format!("at most {MAX_SEGMENTS}")));
        }
        for i in 0..count {
            let next = (i + 1) % count;
            let (end, start) = (segments[i].end(), segments[next].start());
            if ((end - start) / domain).length() >= SNAP {
                let most = if domain == DVec2::ONE { "" } else { " of the domain" };
                return Err(Error::invalid(
                    format!("gap between the end of segment {i} and the start of segment {next}"),
                    end.distance(start),
                    format!("less than 0.000001{most}: a closed loop"),
                ));
            }
            segments[next].points_mut()[0] = end;
        }
        Ok(Self { segments })
    }

    /// The segments in order.
    #[must_use]
    pub fn segments(&self) -> &[Segment] {
        &self.segments
    }

    /// The loop with every control point replaced.
    pub(crate) fn map(&self, to: impl Fn(DVec2) -> DVec2) -> Self {
        Self { segments: self.segments.iter().map(|segment| segment.map(&to)).collect() }
    }

    /// Bounding box of the control points: minimum and maximum (u, v). The loop lies inside.
    #[must_use]
    pub fn control_box(&self) -> [DVec2; 2] {
        bounding_box(self.segments.iter().flat_map(Segment::points).copied())
    }
}

/// Which side of the loops is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Keep {
    /// The outside: the loops are holes, and a loop in a hole is an island.
    #[default]
    Outside,
    /// The inside: the outermost loop is the border of the surface, and a loop in it is a hole.
    Inside,
}

/// All trims of one surface, and which kinds are switched on.
#[derive(Debug, Clone, PartialEq)]
pub struct Trims {
    /// Circles, cut while [`Trims::circles_on`].
    pub circles: Vec<Circle>,
    /// Rectangles, cut while [`Trims::rects_on`].
    pub rects: Vec<Rect>,
    /// Ellipses, cut while [`Trims::ellipses_on`].
    pub ellipses: Vec<Ellipse>,
    /// Loops, combined by even-odd while [`Trims::loops_on`].
    pub loops: Vec<TrimLoop>,
    /// Paths, each filled by its own rule while [`Trims::loops_on`]. A point inside any path is inside, regardless of
    /// the loops and the other paths.
    pub paths: Vec<TrimPath>,
    /// Which side of the loops and paths is kept, if there are any.
    pub keep: Keep,
    /// Whether the circles are switched on.
    pub circles_on: bool,
    /// Whether the rectangles are switched on.
    pub rects_on: bool,
    /// Whether the ellipses are switched on.
    pub ellipses_on: bool,
    /// Whether the loops and paths are switched on.
    pub loops_on: bool,
}

impl Default for Trims {
    /// No trims, every kind switched on.
    fn default() -> Self {
        Self {
            circles: Vec::new(),
            rects: Vec::new(),
            ellipses: Vec::new(),
            loops: Vec::new(),
            paths: Vec::new(),
            keep: Keep::Outside,
            circles_on: true,
            rects_on: true,
            ellipses_on: true,
            loops_on: true,
        }
    }
}

impl Trims {
    /// Adds a loop.
    ///
    /// # Errors
    /// More than 1,000,000 segments in all loops together; the error names the loop and the segment. The trims stay
    /// as they were.
    pub fn add_loop(&mut self, trim_loop: TrimLoop) -> Result<()> {
        self.add_loop_to(trim_loop, self.segment_count())
    }

    /// The same as [`Trims::add_loop`], for callers that know the number of existing segments.
    pub(crate) fn add_loop_to(&mut self, trim_loop: TrimLoop, segments: usize) -> Result<()> {
        check_count(self.loops.len(), trim_loop.segments.len(), segments)?;
        self.loops.push(trim_loop);
        Ok(())
    }

    /// The number of segments in all loops together.
    #[must_use]
    pub fn segment_count(&self) -> usize {
        self.all_loops().map(|trim_loop| trim_loop.segments.len()).sum()
    }

    /// Checks every shape as its constructor does, because the fields are public.
    ///
    /// # Errors
    /// The first shape that its constructor refuses, too many segments.
    pub fn check(&self) -> Result<()> {
        let mut segments = 0;
        for (number, trim_loop) in self.all_loops().enumerate() {
            check_count(number, trim_loop.segments.len(), segments)?;
            segments += trim_loop.segments.len();
        }
        for circle in &self.circles {
            Circle::new(circle.center, circle.radius)?;
        }
        for rect in &self.rects {
            Rect::new(rect.u, rect.v)?;
        }
        for ellipse in &self.ellipses {
            Ellipse::new(ellipse.center, ellipse.radii)?;
        }
        Ok(())
    }

    /// Whether there are no trims, switched on or off.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        let shapes = self.circles.len() + self.rects.len() + self.ellipses.len();
        shapes == 0 && !self.has_loops()
    }

    /// Whether a circle, rectangle or ellipse that is switched on cuts `uv`.
    #[must_use]
    pub fn shapes_cut(&self, uv: DVec2) -> bool {
        (self.circles_on && self.circles.iter().any(|circle| circle.cuts(uv)))
            || (self.rects_on && self.rects.iter().any(|rect| rect.cuts(uv)))
            || (self.ellipses_on && self.ellipses.iter().any(|ellipse| ellipse.cuts(uv)))
    }

    /// Whether `uv` is cut, decided exactly.
    #[must_use]
    pub fn cut(&self, uv: DVec2) -> bool {
        let loops_cut = || self.inside(uv) != (self.keep == Keep::Inside);
        self.shapes_cut(uv) || (self.loops_on && self.has_loops() && loops_cut())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;

    #[test]
    fn shapes_have_the_borders_of_the_listing() {
        let circle = Circle::new(dvec2(0.5, 0.5), 0.25).unwrap();
        assert!(circle.cuts(dvec2(0.5, 0.74)) && !circle.cuts(dvec2(0.5, 0.75)));
        let interval = Rect::new(dvec2(0.25, 0.5), dvec2(0.25, 0.75)).unwrap();
        assert!(interval.cuts(dvec2(0.25, 0.75)) && !interval.cuts(dvec2(0.51, 0.5)));
        let ellipse = Ellipse::new(dvec2(0.5, 0.5), dvec2(0.5, 0.25)).unwrap();
        assert!(ellipse.cuts(dvec2(1.0, 0.5)) && !ellipse.cuts(dvec2(0.5, 0.76)));
        assert!(!Ellipse::new(dvec2(0.5, 0.5), DVec2::ZERO).unwrap().cuts(dvec2(0.5, 0.5)));
    }

    #[test]
    fn bad_shapes_are_refused_with_name_value_and_range() {
        let nan = dvec2(f64::NAN, 0.0);
        for (error, words) in [
            (Circle::new(DVec2::ZERO, -0.5).unwrap_err(), ["circle radius", "-0.5", "0 or above"]),
            (
                Circle::new(DVec2::ZERO, f64::INFINITY).unwrap_err(),
                ["circle radius", "inf", "finite"],
            ),
            (Circle::new(nan, 0.1).unwrap_err(), ["circle center", "NaN", "finite"]),
            (
                Rect::new(dvec2(0.7, 0.2), DVec2::ZERO).unwrap_err(),
                ["interval u", "0.7", "first ≤ last"],
            ),
            (Rect::new(DVec2::ZERO, nan).unwrap_err(), ["interval v", "NaN", "finite"]),
            (
                Ellipse::new(DVec2::ZERO, dvec2(0.1, -1.0)).unwrap_err(),
                ["ellipse radius along v", "-1", "0 or above"],
            ),
        ] {
            let text = error.to_string();
            assert!(words.iter().all(|word| text.contains(word)), "{text}");
        }
    }

    #[test]
    fn small_gaps_snap_and_large_ones_are_refused_by_number() {
        let chain = |gap: f64| {
            TrimLoop::new(vec![
                Segment::Line([dvec2(0.2, 0.2), dvec2(0.8, 0.2)]),
                Segment::Quadratic([dvec2(0.8, 0.2 + gap), dvec2(0.8, 0.8), dvec2(0.2, 0.2)]),
            ])
        };
        let joined = chain(9e-7).unwrap();
        assert_eq!(joined.segments()[0].end(), joined.segments()[1].start());
        let text = chain(1.1e-6).unwrap_err().to_string();
        assert!(text.contains("segment 0") && text.contains("segment 1"), "{text}");
        assert!(TrimLoop::new(Vec::new()).is_err());
        assert!(Segment::new(&[DVec2::ZERO; 5]).is_err());
        let corner = Segment::Line([DVec2::ZERO, DVec2::ZERO]);
        let text = TrimLoop::new(vec![corner; 1_000_001]).unwrap_err().to_string();
        assert!(text.contains("segment 1000000") && text.contains("at most 1000000"), "{text}");
        let mut trims = Trims::default();
        trims.add_loop(TrimLoop::new(vec![corner; 600_000]).unwrap()).unwrap();
        let text = trims.add_loop(trims.loops[0].clone()).unwrap_err().to_string();
        assert!(text.contains("loop 1, segment 400000"), "{text}");
        assert_eq!(trims.loops.len(), 1);
        let infinite = Segment::Line([DVec2::ZERO, DVec2::INFINITY]);
        assert!(TrimLoop::new(vec![infinite]).unwrap_err().to_string().contains("segment 0"));
    }
}
