//! `.bpt` files: a count of patches, then for each patch two integers and its points, row by row.
//!
//! There are several dialects. The integers are degrees (`3 3` before 16 points) or numbers of points (`4 4` before
//! 16 points), and they stand before each patch or once before all patches. Only the number of the values that follow
//! shows which dialect a file uses.

use std::path::Path;

use glam::DVec4;

use super::Surface;
use super::file::line_of;
use crate::bezier::Degree;
use crate::error::{Error, Result, shortened};

/// The meaning of the two integers before patches, and how often they are given.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Dialect {
    counts: bool,
    once: bool,
}

/// In the order in which they are tried.
const DIALECTS: [Dialect; 4] = [
    Dialect { counts: false, once: false },
    Dialect { counts: true, once: false },
    Dialect { counts: false, once: true },
    Dialect { counts: true, once: true },
];

/// An error, and the number of the value where it was found.
struct Fault {
    value: usize,
    message: String,
    /// The number of values that the last patch lacks, if it has most of its values; otherwise that of no patch.
    missing: usize,
}

/// The surfaces of the patches in file order. Consecutive patches of the same degree share a surface.
pub(super) fn parse(text: &str, path: &Path) -> Result<Vec<Surface>> {
    numbers(text).and_then(|values| surfaces(&values)).map_err(|fault| Error::Scene {
        path: path.to_owned(),
        line: line_of_value(text, fault.value),
        message: fault.message,
    })
}

fn numbers(text: &str) -> Result<Vec<f64>, Fault> {
    text.split_whitespace()
        .enumerate()
        .map(|(value, word)| {
            word.parse().map_err(|_| Fault {
                value,
                message: format!("\"{}\" is no number", shortened(word)),
                missing: 0,
            })
        })
        .collect()
}

fn line_of_value(text: &str, value: usize) -> usize {
    let start = text
        .split_whitespace()
        .nth(value)
        .map_or(text.trim_end().len(), |word| word.as_ptr() as usize - text.as_ptr() as usize);
    line_of(text, start)
}

fn surfaces(values: &[f64]) -> Result<Vec<Surface>, Fault> {
    let mut best: Option<Fault> = None;
    let mut patches = None;
    for dialect in DIALECTS {
        match walk(values, dialect) {
            Ok(found) => {
                patches = Some(found);
                break;
            }
            // If no dialect fits, the error is that of the dialect that reads furthest, or that lacks the fewest
            // values of the last patch. Most files have integers before each patch, so the errors of these dialects
            // are preferred.
            Err(fault) if dialect.once && best.is_some() => drop(fault),
            Err(fault) => {
                let reach = |fault: &Fault| (fault.value, std::cmp::Reverse(fault.missing));
                if best.as_ref().is_none_or(|best| reach(&fault) > reach(best)) {
                    best = Some(fault);
                }
            }
        }
    }
    let patches = match (patches, best) {
        (Some(patches), _) => patches,
        (None, Some(fault)) => return Err(fault),
        (None, None) => Vec::new(),
    };
    let mut surfaces: Vec<(Degree, Vec<DVec4>)> = Vec::new();
    for PatchValues { degree, start } in patches {
        let points = &values[start..start + 3 * degree.points()];
        if let Some(bad) = points.iter().position(|value| !value.is_finite()) {
            return Err(Fault {
                value: start + bad,
                message: format!("a coordinate is {}; expected a finite number", points[bad]),
                missing: 0,
            });
        }
        if surfaces.last().is_none_or(|(last, _)| *last != degree) {
            surfaces.push((degree, Vec::new()));
        }
        let (_, all) = surfaces.last_mut().expect("one was just pushed");
        all.extend(points.chunks_exact(3).map(|p| DVec4::new(p[0], p[1], p[2], 1.0)));
    }
    surfaces
        .into_iter()
        .map(|(degree, points)| {
            Surface::new(degree, points).map_err(|error| Fault {
                value: 0,
                message: error.to_string(),
                missing: 0,
            })
        })
        .collect()
}

/// A patch's degree and the number of its first coordinate.
struct PatchValues {
    degree: Degree,
    start: usize,
}

/// The patches, if the whole file can be read in this dialect.
fn walk(values: &[f64], dialect: Dialect) -> Result<Vec<PatchValues>, Fault> {
    let fault = |value, message: String| Err(Fault { value, message, missing: 0 });
    let Some(count) = values.first().copied().and_then(whole) else {
        return fault(0, "expected the number of patches, a whole number above 0".into());
    };
    let mut patches: Vec<PatchValues> = Vec::new();
    let mut next = 1;
    for patch in 0..count {
        if let Some(PatchValues { degree, .. }) = patches.last().filter(|_| dialect.once) {
            let (degree, start) = (*degree, next);
            next += 3 * degree.points();
            if next > values.len() {
                let message = format!("{count} patches announced, but the file ends after {patch}");
                return fault(values.len(), message);
            }
            patches.push(PatchValues { degree, start });
            continue;
        }
        let Some(header) = values.get(next..next + 2) else {
            return fault(
                next,
                format!("{count} patches announced, but the file ends after {patch}"),
            );
        };
        let (Some(first), Some(second)) = (whole(header[0]), whole(header[1])) else {
            return fault(
                next,
                format!("patch {patch} begins with {header:?}; expected two degrees"),
            );
        };
        let extra = usize::from(!dialect.counts);
        let sides = [first.saturating_add(extra), second.saturating_add(extra)];
        let [u, v] = sides;
        let Ok(degree) = Degree::new(u - 1, v - 1) else {
            let message = format!("patch {patch} has {u}×{v} points; expected 2×2 to 16×16");
            return fault(next, message);
        };
        let start = next + 2;
        let coordinates = 3 * degree.points();
        let there = values.len() - start;
        if coordinates > there {
            let message = format!(
                "patch {patch} has {} points, but the file ends after {there} of its {coordinates} \
                 coordinates",
                degree.points(),
            );
            let missing = coordinates - there;
            let missing = if 4 * missing <= coordinates { missing } else { usize::MAX };
            return Err(Fault { value: values.len(), message, missing });
        }
        patches.push(PatchValues { degree, start });
        next = start + coordinates;
    }
    if next < values.len() {
        let rest = values.len() - next;
        return fault(next, format!("{rest} more values after the last of {count} patches"));
    }
    Ok(patches)
}

/// The value as an index, if it is a whole number of at least 1 and not too large.
fn whole(value: f64) -> Option<usize> {
    (value >= 1.0 && value.fract() == 0.0 && value < 2f64.powi(48)).then_some(value as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(header: &str, patches: &[(&str, usize)]) -> String {
        let mut text = format!("{header}\n");
        for (head, points) in patches {
            text += &format!("{head}\n");
            for i in 0..*points {
                text += &format!("{} {} {}\n", i % 4, i / 4, 0.5);
            }
        }
        text
    }

    fn patches(text: &str) -> Vec<(Degree, usize)> {
        parse(text, Path::new("x.bpt"))
            .unwrap()
            .iter()
            .map(|surface| (surface.degree(), surface.patches().len()))
            .collect()
    }

    fn error(text: &str) -> String {
        parse(text, Path::new("x.bpt")).unwrap_err().to_string()
    }

    #[test]
    fn both_dialects_are_told_apart_by_the_number_of_values() {
        let (cubic, quartic) = (Degree::CUBIC, Degree::QUARTIC);
        assert_eq!(patches(&text("2", &[("3 3", 16), ("3 3", 16)])), [(cubic, 2)]);
        assert_eq!(patches(&text("2", &[("4 4", 16), ("4 4", 16)])), [(cubic, 2)]);
        assert_eq!(patches(&text("1", &[("4 4", 25)])), [(quartic, 1)]);
        assert_eq!(patches(&text("1", &[("5 5", 25)])), [(quartic, 1)]);
        assert_eq!(
            patches(&text("3", &[("3 3", 16), ("4 4", 25), ("3 3", 16)])),
            [(cubic, 1), (quartic, 1), (cubic, 1)]
        );
        assert_eq!(patches(&text("2", &[("4 4", 16), ("5 5", 25)])), [(cubic, 1), (quartic, 1)]);
    }

    #[test]
    fn degrees_may_stand_once_before_all_patches() {
        let (cubic, quartic) = (Degree::CUBIC, Degree::QUARTIC);
        assert_eq!(patches(&text("2\n3 3", &[("", 16), ("", 16)])), [(cubic, 2)]);
        assert_eq!(patches(&text("3\n4 4", &[("", 25), ("", 25), ("", 25)])), [(quartic, 3)]);
        // Numbers of points once.
        assert_eq!(patches(&text("2\n4 4", &[("", 16), ("", 16)])), [(cubic, 2)]);
        let points = parse(&text("2\n3 3", &[("", 16), ("", 16)]), Path::new("x.bpt")).unwrap();
        assert_eq!(points[0].control_points()[16], DVec4::new(0.0, 0.0, 0.5, 1.0));
        let short = error(&text("2\n3 3", &[("", 16), ("", 15)]));
        assert!(short.contains("x.bpt:"), "{short}");
    }

    #[test]
    fn faults_name_the_line_and_what_was_expected() {
        for (text, words) in [
            ("32 3 3 1 2", ["x.bpt:1:", "ends after 2 of its 48"]),
            ("1073741824\n3 3\n", ["x.bpt:2:", "ends after 0 of its 48"]),
            (&text("1073741824", &[("3 3", 16)]), ["x.bpt:18:", "ends after 1"]),
            (&text("1", &[("3 3", 17)]), ["x.bpt:19:", "3 more values"]),
            ("1\n3 3\n0 0 zero", ["x.bpt:3:", "\"zero\" is no number"]),
            ("0", ["x.bpt:1:", "above 0"]),
            ("-3", ["x.bpt:1:", "above 0"]),
            ("1.5", ["x.bpt:1:", "whole"]),
            (&text("1", &[("20 20", 4)]), ["x.bpt:2:", "21×21 points; expected 2×2 to 16×16"]),
            (&text("1", &[("4 4", 15)]), ["x.bpt:17:", "ends after 45 of its 48"]),
            (&text("1", &[("4 4", 24)]), ["x.bpt:26:", "ends after 72 of its 75"]),
            (&text("1", &[("3 3", 16)]).replace("3 3 0.5", "3 nan 0.5"), ["x.bpt:18:", "NaN"]),
            ("1 1e300 1e300 1", ["x.bpt:1:", "two degrees"]),
        ] {
            let message = error(text);
            assert!(words.iter().all(|word| message.contains(word)), "{message}");
        }
    }
}
