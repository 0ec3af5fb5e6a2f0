//! Free-form surfaces as the text of an OBJ file.

use std::fmt::Write as _;

use super::reader::MAX_LINE;
use crate::error::{Error, Result};
use crate::scene::Surface;

/// The text of a file with the patches or the NURBS surface of a surface. It reads back as exactly the same numbers.
/// Transform, paint and trims are not in it.
///
/// # Errors
/// A NURBS surface of more control points than a line of OBJ can name.
pub(in crate::scene) fn surface_text(surface: &Surface) -> Result<String> {
    let points = surface.control_points();
    let is_rational = points.iter().any(|point| point.w != 1.0);
    let degree = surface.degree();
    let mut text = String::new();
    // Writing to a string cannot fail.
    for point in points {
        let _ = write!(text, "v {:?} {:?} {:?}", point.x, point.y, point.z);
        let _ = if is_rational { writeln!(text, " {:?}", point.w) } else { writeln!(text) };
    }
    let rational = if is_rational { "rat " } else { "" };
    let kind = if surface.nurbs().is_some() { "bspline" } else { "bezier" };
    let _ = writeln!(text, "cstype {rational}{kind}\ndeg {} {}", degree.u(), degree.v());
    let Some(nurbs) = surface.nurbs() else {
        let count = degree.points();
        for first in (1..=points.len()).step_by(count) {
            let _ = writeln!(text, "surf 0 1 0 1{}\nend", words(first..first + count));
        }
        return Ok(text);
    };
    let [low, high] = surface.domain();
    let range = format!("{:?} {:?} {:?} {:?}", low.x, high.x, low.y, high.y);
    let surf = format!("surf {range}{}", words(1..=points.len()));
    let [u, v] = nurbs.knots().each_ref().map(words);
    for (what, count, line) in [
        ("number of control points", points.len(), &surf),
        ("number of knots along u", nurbs.knots()[0].len(), &u),
        ("number of knots along v", nurbs.knots()[1].len(), &v),
    ] {
        // With the name of its statement and the end of the line.
        if line.len() + 16 > MAX_LINE {
            let expected = "few enough for one line of OBJ, of 1 MiB";
            return Err(Error::invalid(what, count, expected));
        }
    }
    let _ = writeln!(text, "{surf}\nparm u{u}\nparm v{v}\nend");
    Ok(text)
}

fn words<T: std::fmt::Debug>(values: impl IntoIterator<Item = T>) -> String {
    values.into_iter().fold(String::new(), |mut text, value| {
        let _ = write!(text, " {value:?}");
        text
    })
}
