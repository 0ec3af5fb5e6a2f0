//! Converts SVG path data in (u, v) to loops.
//!
//! svgtypes parses the text, and kurbo converts arcs to cubics. (kurbo's own parser treats everything that it does
//! not know as the end of the path, and its arcs are off by 2.7·10⁻⁴ of the radius.)

use glam::DVec2;
use kurbo::{Arc, PathEl, SvgArc};
use svgtypes::{PathParser, PathSegment};

use super::{
    ParameterSizes, SNAP, Segment, TrimLoop, Trims, check_count, check_counts, check_finite,
};
use crate::error::{Error, Result};

/// The maximum distance between an arc and its cubics, if the smallest patch has a size of 1 to 2. (For radii from
/// about 1e8 on, `f64` is not precise enough for this.)
const ARC_TOLERANCE: f64 = 1e-8;

impl Trims {
    /// Adds the loops of SVG path data: see [`TrimLoop::from_svg_path`].
    ///
    /// # Errors
    /// As there, and more than 1,000,000 segments in all loops together. Errors number the loops as if they were
    /// already in these trims. The trims stay as they were.
    pub fn add_svg_path(&mut self, data: &str) -> Result<()> {
        self.add_svg_path_over(data, &ParameterSizes::default())
    }

    /// The same for a surface with any parameters.
    ///
    /// # Errors
    /// As [`Trims::add_svg_path`].
    pub fn add_svg_path_over(&mut self, data: &str, parameters: &ParameterSizes) -> Result<()> {
        let before = self.loops.len();
        let loops = read(data, before, parameters)?;
        check_counts(&loops, before, self.segment_count())?;
        self.loops.extend(loops);
        Ok(())
    }
}

impl TrimLoop {
    /// The loops of SVG path data in (u, v). All commands of SVG are supported, absolute and relative. Arcs become
    /// cubics with an error of at most 1e-8 of the domain. Each subpath is a loop. As when SVG fills a path, a
    /// subpath that does not end where it began is closed by a line, and a subpath without segments is ignored.
    ///
    /// # Errors
    /// Text that is not path data, with the position of the error; a path without any segment; a number that is not
    /// finite, with the numbers of the loop and the segment.
    pub fn from_svg_path(data: &str) -> Result<Vec<Self>> {
        Self::from_svg_path_over(data, &ParameterSizes::default())
    }

    /// The same for a surface with any parameters. The error of arcs is relative to its smallest patch.
    ///
    /// # Errors
    /// As [`TrimLoop::from_svg_path`].
    pub fn from_svg_path_over(data: &str, parameters: &ParameterSizes) -> Result<Vec<Self>> {
        read(data, 0, parameters)
    }
}

/// Reads the loops of a path. Errors number the loops from `first` on.
fn read(data: &str, first: usize, parameters: &ParameterSizes) -> Result<Vec<TrimLoop>> {
    let mut reader =
        Reader { first, sizes: sizes(data)?, parameters: *parameters, ..Reader::default() };
    for segment in PathParser::from(data) {
        reader.take(segment.map_err(|error| unreadable_path(data, &error))?)?;
    }
    let loops = reader.finish()?;
    if loops.is_empty() {
        return Err(Error::invalid("path", "empty", "at least one subpath with a segment"));
    }
    Ok(loops)
}

/// The loops of a path's segments. Subpaths are treated as in [`TrimLoop::from_svg_path`].
#[cfg(feature = "svg")]
pub(super) fn loops_of(segments: impl Iterator<Item = PathSegment>) -> Result<Vec<TrimLoop>> {
    let mut reader = Reader::default();
    for segment in segments {
        reader.take(segment)?;
    }
    reader.finish()
}

/// The number of commands of each subpath, so that its memory is allocated only once.
fn sizes(data: &str) -> Result<Vec<usize>> {
    let mut sizes = Vec::new();
    let mut open = false;
    for segment in PathParser::from(data) {
        let segment = segment.map_err(|error| unreadable_path(data, &error))?;
        if !open || matches!(segment, PathSegment::MoveTo { .. }) {
            sizes.push(0);
        }
        open = !matches!(segment, PathSegment::ClosePath { .. });
        if let Some(size) = sizes.last_mut() {
            *size += 1;
        }
    }
    Ok(sizes)
}

/// The error for text that is not path data.
pub(super) fn unreadable_path(data: &str, error: &svgtypes::Error) -> Error {
    const SHOWN: usize = 24;
    let start: String = data.trim().chars().take(SHOWN).collect();
    let more = if data.trim().chars().nth(SHOWN).is_some() { "…" } else { "" };
    Error::invalid("path", format!("\"{start}{more}\""), format!("SVG path data ({error})"))
}

/// The state of a path that is read command by command.
#[derive(Default)]
struct Reader {
    parameters: ParameterSizes,
    first: usize,
    sizes: Vec<usize>,
    loops: Vec<TrimLoop>,
    segments: Vec<Segment>,
    /// The number of segments of the finished loops.
    closed: usize,
    start: DVec2,
    current: DVec2,
    /// The last control point, for the smooth commands of its degree.
    last_control: Option<Control>,
    /// Whether a subpath has begun that is not closed yet.
    open: bool,
}

#[derive(Clone, Copy)]
enum Control {
    Quadratic(DVec2),
    Cubic(DVec2),
}

impl Reader {
    fn take(&mut self, segment: PathSegment) -> Result<()> {
        let from = if segment.is_abs() { DVec2::ZERO } else { self.current };
        let at = |x: f64, y: f64| from + DVec2::new(x, y);
        let mut control = None;
        match segment {
            PathSegment::MoveTo { x, y, .. } => {
                self.end_loop()?;
                self.start = at(x, y);
                self.current = self.start;
                self.open = true;
            }
            PathSegment::LineTo { x, y, .. } => self.line(at(x, y)),
            PathSegment::HorizontalLineTo { x, .. } => {
                self.line(DVec2::new(from.x + x, self.current.y));
            }
            PathSegment::VerticalLineTo { y, .. } => {
                self.line(DVec2::new(self.current.x, from.y + y));
            }
            PathSegment::Quadratic { x1, y1, x, y, .. } => {
                control = Some(self.quadratic(at(x1, y1), at(x, y)));
            }
            PathSegment::SmoothQuadratic { x, y, .. } => {
                let first = match self.last_control {
                    Some(Control::Quadratic(last)) => 2.0 * self.current - last,
                    _ => self.current,
                };
                control = Some(self.quadratic(first, at(x, y)));
            }
            PathSegment::CurveTo { x1, y1, x2, y2, x, y, .. } => {
                control = Some(self.cubic(at(x1, y1), at(x2, y2), at(x, y)));
            }
            PathSegment::SmoothCurveTo { x2, y2, x, y, .. } => {
                let first = match self.last_control {
                    Some(Control::Cubic(last)) => 2.0 * self.current - last,
                    _ => self.current,
                };
                control = Some(self.cubic(first, at(x2, y2), at(x, y)));
            }
            PathSegment::EllipticalArc {
                rx, ry, x_axis_rotation, large_arc, sweep, x, y, ..
            } => {
                let radii = DVec2::new(rx, ry);
                self.arc(radii, x_axis_rotation.to_radians(), [large_arc, sweep], at(x, y))?;
            }
            PathSegment::ClosePath { .. } => {
                self.end_loop()?;
                self.current = self.start;
            }
        }
        self.last_control = control;
        Ok(())
    }

    fn push(&mut self, segment: Segment) {
        if self.segments.is_empty() {
            self.segments.reserve_exact(self.sizes.get(self.loops.len()).copied().unwrap_or(1));
        }
        self.current = segment.end();
        self.segments.push(segment);
        self.open = true;
    }

    fn line(&mut self, to: DVec2) {
        self.push(Segment::Line([self.current, to]));
    }

    fn quadratic(&mut self, control: DVec2, to: DVec2) -> Control {
        self.push(Segment::Quadratic([self.current, control, to]));
        Control::Quadratic(control)
    }

    fn cubic(&mut self, first: DVec2, second: DVec2, to: DVec2) -> Control {
        self.push(Segment::Cubic([self.current, first, second, to]));
        Control::Cubic(second)
    }

    fn arc(&mut self, radii: DVec2, rotation: f64, flags: [bool; 2], to: DVec2) -> Result<()> {
        // The values must be finite, because their size decides the number of cubics.
        let number = self.segments.len();
        for (name, point) in [("radii", radii), ("end", to), ("start", self.current)] {
            check_finite(&format!("{name} of the arc in segment {number}"), point)
                .map_err(|error| self.blame(error))?;
        }
        check_finite(&format!("rotation of the arc in segment {number}"), DVec2::splat(rotation))
            .map_err(|error| self.blame(error))?;
        let point = |p: DVec2| kurbo::Point::new(p.x, p.y);
        let svg_arc = SvgArc {
            from: point(self.current),
            to: point(to),
            radii: kurbo::Vec2::new(radii.x, radii.y),
            x_rotation: rotation,
            large_arc: flags[0],
            sweep: flags[1],
        };
        // An arc without a radius or a length is a line, as SVG requires.
        if let Some(arc) = Arc::from_svg_arc(&svg_arc) {
            let tolerance = ARC_TOLERANCE * self.parameters.unit().min_element();
            for element in arc.append_iter(tolerance) {
                if let PathEl::CurveTo(a, b, c) = element {
                    let [a, b, c] = [a, b, c].map(|p| DVec2::new(p.x, p.y));
                    self.cubic(a, b, c);
                }
            }
            // A short text can produce many cubics.
            check_count(self.first + self.loops.len(), self.segments.len(), self.closed)?;
        }
        match self.segments[number..].last_mut() {
            Some(Segment::Cubic(points)) => points[3] = to,
            _ => self.line(to),
        }
        self.current = to;
        Ok(())
    }

    fn end_loop(&mut self) -> Result<()> {
        if std::mem::take(&mut self.open) && !self.segments.is_empty() {
            let domain = self.parameters.domain;
            if ((self.current - self.start) / domain).length() >= SNAP {
                self.line(self.start);
            }
            self.open = false;
            let segments = std::mem::take(&mut self.segments);
            let trim_loop =
                TrimLoop::closed(segments, domain).map_err(|error| self.blame(error))?;
            self.closed += trim_loop.segments.len();
            self.loops.push(trim_loop);
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Vec<TrimLoop>> {
        self.end_loop()?;
        Ok(self.loops)
    }

    /// The same error with the number of the loop.
    fn blame(&self, error: Error) -> Error {
        error.within(format!("loop {}", self.first + self.loops.len()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;

    fn points(data: &str) -> Vec<Vec<Vec<DVec2>>> {
        let loops = TrimLoop::from_svg_path(data).unwrap_or_else(|error| panic!("{error}"));
        loops
            .iter()
            .map(|trim_loop| {
                trim_loop.segments().iter().map(|segment| segment.points().to_vec()).collect()
            })
            .collect()
    }

    #[test]
    fn absolute_and_relative_commands_make_the_same_loops() {
        let absolute =
            "M.2 .2 L.4 .2 H.6 V.4 Q.7 .5 .6 .6 T.5 .8 C.4 .9 .3 .9 .3 .7 S.2 .5 .2 .4 Z";
        let relative =
            "m.2 .2 l.2 0 h.2 v.2 q.1 .1 0 .2 t-.1 .2 c-.1 .1-.2 .1-.2-.1 s-.1-.2-.1-.3 z";
        let [a, b] = [absolute, relative].map(points);
        assert_eq!(a.len(), 1);
        assert_eq!(a[0].iter().map(Vec::len).collect::<Vec<_>>(), [2, 2, 2, 3, 3, 4, 4, 2]);
        for (a, b) in a[0].iter().flatten().zip(b[0].iter().flatten()) {
            assert!(a.distance(*b) < 1e-15, "{a} {b}");
        }
        // The smooth commands mirror the last control point.
        assert!(a[0][4][1].distance(dvec2(0.5, 0.7)) < 1e-15);
        assert!(a[0][6][1].distance(dvec2(0.3, 0.5)) < 1e-15);
    }

    #[test]
    fn smooth_commands_mirror_only_their_own_degree() {
        let mixed = points("M0 0 C.1 .1 .2 .1 .3 0 T.6 .1 S.8 .3 .9 0 Z");
        assert_eq!(mixed[0][1][1], dvec2(0.3, 0.0));
        assert_eq!(mixed[0][2][1], dvec2(0.6, 0.1));
    }

    #[test]
    fn several_subpaths_are_several_loops_and_z_returns_to_the_start() {
        let loops =
            points("M0 0 L1 0 L1 1 Z l.5 0 0 .5 z m.1 .1 h.1 v.1 z M.2 .2L.3 .2L.3 .3L.2 .2");
        assert_eq!(loops.iter().map(Vec::len).collect::<Vec<_>>(), [3, 3, 3, 3]);
        assert_eq!(loops[1][0][0], DVec2::ZERO);
        assert_eq!(loops[2][0][0], dvec2(0.1, 0.1));
    }

    #[test]
    fn open_subpaths_are_closed_and_empty_ones_are_nothing() {
        let closed = points("M.1 .2 L.3 .2 L.3 .4 Z");
        for same in [
            "M.1 .2 L.3 .2 L.3 .4",
            "M.1 .2 L.3 .2 L.3 .4 z z",
            "M0 0 M.1 .2 L.3 .2 L.3 .4 Z M.9 .9",
            "M0 0 Z M.1 .2 L.3 .2 L.3 .4 M.5 .5 z",
            "M.1 .2 L.3 .2 L.3 .4 L.1 .2",
        ] {
            assert_eq!(points(same), closed, "{same}");
        }
        // The next subpath begins where the open one ended, or where the closed one began.
        let open = points("M.1 .2 L.3 .2 L.3 .4 m.1 0 h.1 v.1");
        assert!(open[1][0][0].distance(dvec2(0.4, 0.4)) < 1e-15);
        let begun = points("M.1 .2 L.3 .2 L.3 .4 z h.1 v.1");
        assert_eq!(begun[1][0][0], dvec2(0.1, 0.2));
        assert_eq!(begun[1].len(), 3);
        let arc = points("M.1 .5 A.4 .4 0 0 1 .9 .5");
        assert_eq!(arc[0].last().unwrap(), &[dvec2(0.9, 0.5), dvec2(0.1, 0.5)]);
    }

    #[test]
    fn arcs_are_as_close_as_stated() {
        // A circle in two arcs, one with the flags run together as SVG allows.
        let data = "M.1 .5 A.4 .4 0 0 1 .9 .5 a.4 .4 0 01-.8 0 Z";
        let loops = TrimLoop::from_svg_path(data).unwrap();
        let mut furthest: f64 = 0.0;
        for segment in loops[0].segments() {
            for step in 0..=100 {
                let point = segment.point(f64::from(step) / 100.0);
                furthest = furthest.max((point.distance(dvec2(0.5, 0.5)) - 0.4).abs());
            }
        }
        assert!(furthest > 1e-12 && furthest <= ARC_TOLERANCE, "{furthest:e}");
        // No radius: a line.
        assert_eq!(points("M0 0 A0 1 0 0 1 1 1 L1 0 Z")[0][0].len(), 2);
    }

    #[test]
    fn faults_are_named() {
        for (data, words) in [
            ("", &["path", "empty"][..]),
            ("M0 0 L1 0 x", &["path", "position 11"]),
            ("L0 0", &["path", "SVG path data"]),
            ("M0 0", &["path", "empty", "subpath with a segment"]),
            ("M0 0 Z z M1 1", &["path", "empty"]),
            ("M0 0 L1e999 0 Z", &["path", "position 7"]),
            ("M0 0 L1e16 0 Z", &["loop 0", "segment 0", "finite"]),
            ("M0 0 A1e16 1 0 0 1 1 1 Z", &["loop 0", "radii of the arc in segment 0", "finite"]),
            ("M0 0 L1 0 Z M0 0 A1 1 1e18 0 1 1 1 Z", &["loop 1", "rotation of the arc"]),
        ] {
            let text = TrimLoop::from_svg_path(data).unwrap_err().to_string();
            assert!(words.iter().all(|word| text.contains(word)), "{data}: {text}");
        }
    }
}
