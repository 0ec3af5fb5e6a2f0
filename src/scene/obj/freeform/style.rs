//! What kind of curves and surfaces follow: the statements `cstype` and `deg`.

use super::super::counted;
use crate::bezier::{Degree, check_knots, knots_of_bezier_curves};
use crate::error::{Error, shortened};

/// What `cstype` and `deg` say about the curves and surfaces after them.
#[derive(Debug, Default, Clone)]
pub(super) struct Style {
    /// Whether the weights of control points count.
    pub(super) rational: bool,
    kind: Kind,
    /// Along u and v; 0 where none was given.
    pub(super) degrees: [usize; 2],
}

#[derive(Debug, Default, Clone)]
enum Kind {
    /// No `cstype` was read.
    #[default]
    Missing,
    Bezier,
    BSpline,
    /// Another kind, which is not supported.
    Other(String),
}

impl Style {
    /// Takes the words of `cstype`: `rat` if weights count, and the kind.
    pub(super) fn set_kind<'a>(
        &mut self,
        mut words: impl Iterator<Item = &'a str>,
    ) -> Result<(), String> {
        let mut word = words.next();
        self.rational = word == Some("rat");
        if self.rational {
            word = words.next();
        }
        self.kind = match word {
            None => return Err("cstype has no kind; expected bezier or bspline".into()),
            Some("bezier") => Kind::Bezier,
            Some("bspline") => Kind::BSpline,
            Some(other) => Kind::Other(shortened(other)),
        };
        Ok(())
    }

    /// Takes the degrees of `deg`: along u, and along v unless it is for curves.
    pub(super) fn set_degrees<'a>(
        &mut self,
        mut words: impl Iterator<Item = &'a str>,
    ) -> Result<(), String> {
        let mut degree = || match words.next().map(|word| (word, word.parse())) {
            None => Ok(0),
            Some((_, Ok(degree @ 1..))) => Ok(degree),
            Some((word, _)) => {
                Err(format!("\"{}\" is no degree; expected 1 to 15", shortened(word)))
            }
        };
        self.degrees = [degree()?, degree()?];
        match self.degrees {
            [0, _] => Err("deg has no degree; expected one for curves, two for surfaces".into()),
            _ => Ok(()),
        }
    }

    pub(super) const fn is_bezier(&self) -> bool {
        matches!(self.kind, Kind::Bezier)
    }

    /// Words for a curve or surface that is not supported.
    ///
    /// # Errors
    /// Neither a kind nor a degree was given.
    pub(super) fn unsupported(
        &self,
        what: &str,
        degrees: &[usize],
    ) -> Result<Option<String>, String> {
        let kind = match &self.kind {
            Kind::Missing => {
                return Err(format!(
                    "the {what} has no cstype; expected bezier or bspline above it"
                ));
            }
            Kind::Other(kind) => return Ok(Some(format!("{kind} {what}"))),
            Kind::Bezier => "Bézier",
            Kind::BSpline => "B-spline",
        };
        if degrees.contains(&0) {
            let count = if degrees.len() == 1 { "one degree" } else { "two degrees" };
            return Err(format!("the {what} has no degree; expected deg with {count} above it"));
        }
        let is_supported = degrees.iter().all(|degree| *degree <= Degree::MAX);
        let words: Vec<String> = degrees.iter().map(usize::to_string).collect();
        let unsupported = || format!("{kind} {what} of degree {}", words.join("×"));
        Ok((!is_supported).then(unsupported))
    }

    /// The number of control points that the parameters along an axis ask for.
    pub(super) fn points_along(
        &self,
        axis: &str,
        degree: usize,
        parameters: &[f64],
    ) -> Result<usize, String> {
        let count = parameters.len();
        let is_bezier = self.is_bezier();
        let least = if is_bezier { 2 } else { 2 * (degree + 1) };
        match (is_bezier, count) {
            // One Bézier curve.
            (true, 0) => Ok(degree + 1),
            _ if count < least => Err(format!(
                "parm {axis} has {}; expected at least {least} for degree {degree}",
                counted(count, "number")
            )),
            (true, _) => Ok((count - 1) * degree + 1),
            (false, _) => Ok(count - degree - 1),
        }
    }

    /// The knots along an axis, checked.
    pub(super) fn knots(
        &self,
        axis: &str,
        degree: usize,
        parameters: &[f64],
        points: usize,
    ) -> Result<Vec<f64>, String> {
        let knots = match (&self.kind, parameters) {
            (Kind::Bezier, []) => knots_of_bezier_curves(degree, &[0.0, 1.0]),
            (Kind::Bezier, breaks) => knots_of_bezier_curves(degree, breaks),
            _ => parameters.to_vec(),
        };
        let within = |error: Error| error.within(format!("parm {axis}")).to_string();
        check_knots(degree, &knots, points).map_err(within)?;
        Ok(knots)
    }
}
