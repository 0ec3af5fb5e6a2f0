//! Paths that each have their own fill rule, as in SVG.

use super::inside::winding_number;
use super::{ParameterSizes, TrimLoop, Trims};
use crate::error::Result;
use glam::DVec2;

/// Decides which points are inside a path, also where its loops wind around a point more than once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum FillRule {
    /// A point is inside if the loops wind around it an odd number of times: a loop in a loop is a hole.
    #[default]
    EvenOdd,
    /// A point is inside if its winding number is not 0. Opposite directions cancel out: a loop in a loop is a hole
    /// if it runs the other way. This is SVG's default.
    NonZero,
}

impl FillRule {
    /// Whether a point with this winding number is inside.
    #[must_use]
    pub const fn fills(self, winding_number: i32) -> bool {
        match self {
            Self::EvenOdd => winding_number % 2 != 0,
            Self::NonZero => winding_number != 0,
        }
    }
}

/// Loops that are filled together, independently of all other loops.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TrimPath {
    /// The loops; the rule decides what is inside them.
    pub loops: Vec<TrimLoop>,
    /// The fill rule.
    pub rule: FillRule,
}

impl TrimPath {
    /// The path of SVG path data in (u, v): see [`TrimLoop::from_svg_path`].
    ///
    /// # Errors
    /// As there.
    pub fn from_svg_path(data: &str, rule: FillRule) -> Result<Self> {
        Self::from_svg_path_over(data, rule, &ParameterSizes::default())
    }

    /// The same for a surface with any parameters: see [`TrimLoop::from_svg_path_over`].
    ///
    /// # Errors
    /// As there.
    pub fn from_svg_path_over(
        data: &str,
        rule: FillRule,
        parameters: &ParameterSizes,
    ) -> Result<Self> {
        Ok(Self { loops: TrimLoop::from_svg_path_over(data, parameters)?, rule })
    }
}

/// Loops that are filled together: [`Trims::loops`], or one of [`Trims::paths`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fill<'a> {
    pub(crate) loops: &'a [TrimLoop],
    pub(crate) rule: FillRule,
}

/// Checks the number of segments of paths that are added to the given numbers of loops and segments.
pub(super) fn check_paths(paths: &[TrimPath], loops: usize, segments: usize) -> Result<()> {
    let (mut loops, mut segments) = (loops, segments);
    for path in paths {
        super::check_counts(&path.loops, loops, segments)?;
        loops += path.loops.len();
        segments += path.loops.iter().map(|one| one.segments.len()).sum::<usize>();
    }
    Ok(())
}

impl Trims {
    /// All fills: the loops together, then each path separately. Their union is inside.
    pub(crate) fn fills(&self) -> impl Iterator<Item = Fill<'_>> + Clone {
        let loops = Fill { loops: &self.loops, rule: FillRule::EvenOdd };
        let paths = self.paths.iter().map(|path| Fill { loops: &path.loops, rule: path.rule });
        std::iter::once(loops).chain(paths).filter(|fill| !fill.loops.is_empty())
    }

    /// Every loop: those of [`Trims::loops`], then those of the paths.
    pub fn all_loops(&self) -> impl Iterator<Item = &TrimLoop> + Clone {
        self.loops.iter().chain(self.paths.iter().flat_map(|path| &path.loops))
    }

    /// Whether there is a loop, in a path or outside of one.
    #[must_use]
    pub fn has_loops(&self) -> bool {
        self.all_loops().next().is_some()
    }

    /// Whether `uv` is inside the loops or any path, even if these are switched off.
    #[must_use]
    pub fn inside(&self, uv: DVec2) -> bool {
        self.fills().any(|fill| fill.rule.fills(winding_number(fill.loops, uv)))
    }

    /// Adds paths.
    ///
    /// # Errors
    /// More than 1,000,000 segments in all loops together; the error names the loop and the segment. The trims stay
    /// as they were.
    pub fn add_paths(&mut self, paths: Vec<TrimPath>) -> Result<()> {
        check_paths(&paths, self.all_loops().count(), self.segment_count())?;
        self.paths.extend(paths);
        Ok(())
    }
}
