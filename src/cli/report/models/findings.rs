//! Conclusions from the rows of models: parts of first pictures, and who loses where.

use super::{
    EXACT, F3D, F3D_FIRST, FIRST, FIRST_OWN, HALF, OCCT, PARTS, PROGRAM, PROGRAM_OWN, STATIC,
};
use crate::cli::report::row::Row;

/// The longest time from the large model's file to its first draw call, in milliseconds.
const FIRST_DRAW_MS: f64 = 300.0;

/// What is compared with what. Both are sums over rows of the same scene.
struct Comparison {
    /// The ratio in words.
    what: &'static str,
    /// The same with the other's name, for the first lines.
    short: &'static str,
    ours: &'static [&'static str],
    theirs: &'static str,
    value: fn(&Row) -> Option<f64>,
    /// The ratio should be at most this.
    aim: Option<f64>,
}

fn ms(row: &Row) -> Option<f64> {
    row.ms
}

const COMPARISONS: [Comparison; 8] = [
    Comparison {
        what: "The first picture against F3D's, both from the same file",
        short: "F3D's first picture from the same file",
        ours: &[FIRST],
        theirs: F3D_FIRST,
        value: ms,
        aim: None,
    },
    Comparison {
        what: "The first picture from .ffm against F3D's from the original file",
        short: "F3D's first picture, with .ffm on this side",
        ours: &[FIRST_OWN],
        theirs: F3D_FIRST,
        value: ms,
        aim: Some(0.4),
    },
    Comparison {
        what: "A frame at half a pixel against F3D's",
        short: "F3D's frame",
        ours: &[EXACT],
        theirs: F3D,
        value: ms,
        aim: None,
    },
    Comparison {
        what: "Memory of the whole program from the file against F3D's",
        short: "F3D's memory",
        ours: &[PROGRAM],
        theirs: F3D_FIRST,
        value: |row| row.memory.map(|bytes| bytes as f64),
        aim: Some(2.0),
    },
    Comparison {
        what: "Memory of the whole program from .ffm against F3D's from the original file",
        short: "F3D's memory, with .ffm on this side",
        ours: &[PROGRAM_OWN],
        theirs: F3D_FIRST,
        value: |row| row.memory.map(|bytes| bytes as f64),
        aim: Some(2.0),
    },
    Comparison {
        what: "Projection and upload against OCCT's meshing for half a pixel",
        short: "OCCT's meshing",
        ours: &["first picture: projection", "first picture: upload"],
        theirs: OCCT,
        value: ms,
        aim: None,
    },
    Comparison {
        what: "Triangles at half a pixel against those of OCCT's mesh",
        short: "OCCT's triangles",
        ours: &[EXACT],
        theirs: OCCT,
        value: |row| row.triangles.map(|count| count as f64),
        aim: None,
    },
    Comparison {
        what: "A frame at half a pixel against a static mesh of the same triangles",
        short: "a static mesh's frame",
        ours: &[EXACT],
        theirs: STATIC,
        value: ms,
        aim: Some(1.4),
    },
];

/// The row of a method of a scene; of those of several tolerances, that of half a pixel.
fn find<'a>(rows: &[&'a Row], scene: &str, method: &str) -> Option<&'a Row> {
    let is_it = |row: &&&Row| {
        row.scene == scene
            && row.method == method
            && row.tolerance.is_none_or(|tolerance| tolerance == HALF)
    };
    rows.iter().find(is_it).copied()
}

fn scenes<'a>(rows: &[&'a Row]) -> Vec<&'a str> {
    let mut names: Vec<&str> = rows.iter().map(|row| row.scene.as_str()).collect();
    names.dedup();
    names
}

impl Comparison {
    /// The ratios by scene.
    fn ratios<'a>(&self, rows: &[&'a Row]) -> Vec<(&'a str, f64)> {
        let ratio = |scene: &'a str| {
            let value = |method: &str| (self.value)(find(rows, scene, method)?);
            let ours = self.ours.iter().map(|method| value(method)).sum::<Option<f64>>()?;
            Some((scene, ours / value(self.theirs)?))
        };
        scenes(rows).into_iter().filter_map(ratio).collect()
    }

    fn finding(&self, rows: &[&Row]) -> Option<String> {
        let ratios = self.ratios(rows);
        if ratios.is_empty() {
            return None;
        }
        let mut text = format!("{}: {}.", self.what, list(&ratios));
        if let Some(aim) = self.aim {
            text += &format!(" The aim is at most {aim}");
            let missed: Vec<&str> =
                ratios.iter().filter(|(_, ratio)| *ratio > aim).map(|(scene, _)| *scene).collect();
            text += &match missed.len() {
                0 => ": met.".into(),
                _ => format!(": missed by {}.", missed.join(", ")),
            };
        }
        Some(text)
    }
}

fn list(ratios: &[(&str, f64)]) -> String {
    let one = |(scene, ratio): &(&str, f64)| format!("{scene} {ratio:.2}");
    ratios.iter().map(one).collect::<Vec<_>>().join(", ")
}

/// Findings of the section.
pub(super) fn findings(rows: &[Row]) -> Vec<String> {
    let rows: Vec<&Row> = rows.iter().collect();
    let mut found: Vec<String> =
        COMPARISONS.iter().filter_map(|comparison| comparison.finding(&rows)).collect();
    for scene in scenes(&rows) {
        found.extend(parts(&rows, scene));
        found.extend(mesh(&rows, scene));
    }
    found.extend(first_draw(&rows));
    found
}

/// The parts of a first picture.
fn parts(rows: &[&Row], scene: &str) -> Option<String> {
    let all = find(rows, scene, FIRST)?.ms?;
    let part = |name: &&str| {
        let ms = find(rows, scene, &format!("{FIRST}: {name}"))?.ms?;
        Some(format!("{name} {ms:.1}"))
    };
    let parts: Vec<String> = PARTS.iter().filter_map(part).collect();
    Some(format!("{scene}: first picture after {all:.0} ms ({}).", parts.join(", ")))
}

/// The largest errors of OCCT's mesh and of the exact method.
fn mesh(rows: &[&Row], scene: &str) -> Option<String> {
    let (ours, theirs) = (find(rows, scene, EXACT)?, find(rows, scene, OCCT)?);
    Some(format!(
        "{scene}: OCCT's mesh for half a pixel has {} triangles and is up to {:.2} px off; exact draws {} and is up to \
         {:.2} px off.",
        theirs.triangles?, theirs.max_error_px?, ours.triangles?, ours.max_error_px?
    ))
}

/// The models on which OCCT's mesh is further off than it should be.
fn beyond(rows: &[&Row]) -> Option<String> {
    let mut off = Vec::new();
    for row in rows.iter().filter(|row| row.method == OCCT) {
        if let Some(error) = row.max_error_px.filter(|error| *error > HALF) {
            off.push(format!("{} ({error:.2} px)", row.scene));
        }
    }
    (!off.is_empty())
        .then(|| format!(" OCCT's mesh for half a pixel is further off on {}.", off.join(", ")))
}

/// The time from the large model's file to its first draw call, without shaders. It is the scene that is named after
/// its faces.
fn first_draw(rows: &[&Row]) -> Option<String> {
    let scene = scenes(rows).into_iter().find(|scene| scene.ends_with(" faces"))?;
    let part = |name: &&str| find(rows, scene, &format!("{FIRST}: {name}"))?.ms;
    let ms: f64 = PARTS[..3].iter().map(part).sum::<Option<f64>>()?;
    let how = if ms <= FIRST_DRAW_MS { "met" } else { "missed" };
    Some(format!(
        "{scene}: {ms:.0} ms from the file to the first draw call, without shaders. The aim is at most {FIRST_DRAW_MS} ms: {how}."
    ))
}

/// Wins and losses, for the first lines of the report.
pub(in crate::cli::report) fn first_lines(rows: &[&Row]) -> Option<String> {
    let rows: Vec<&Row> = rows.iter().copied().filter(|row| row.section == "models").collect();
    let (mut wins, mut losses) = (Vec::new(), Vec::new());
    for comparison in &COMPARISONS {
        let (ahead, behind): (Vec<_>, Vec<_>) =
            comparison.ratios(&rows).into_iter().partition(|(_, ratio)| *ratio <= 1.0);
        for (ratios, told) in [(ahead, &mut wins), (behind, &mut losses)] {
            if !ratios.is_empty() {
                told.push(format!("{} ({})", comparison.short, list(&ratios)));
            }
        }
    }
    let told: Vec<String> = [("loses to", losses), ("wins against", wins)]
        .into_iter()
        .filter(|(_, names)| !names.is_empty())
        .map(|(how, names)| format!("{how} {}", names.join(", ")))
        .collect();
    if told.is_empty() {
        return None;
    }
    let missing = rows.iter().filter(|row| row.scene == "all");
    let missing: String = missing
        .filter_map(|row| Some(format!(" {} was {}.", row.method, row.note.as_ref()?)))
        .collect();
    Some(format!(
        "Models at half a pixel (shares of the other's value): exact {}.{}{missing}",
        told.join("; it "),
        beyond(&rows).unwrap_or_default()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(scene: &str, method: &str, ms: f64) -> Row {
        Row { ms: Some(ms), ..Row::new("models", scene, method) }
    }

    #[test]
    fn wins_losses_and_aims_are_told() {
        let half = |row| Row { tolerance: Some(HALF), ..row };
        let meshed = Row { triangles: Some(50), ..half(row("a.stp", OCCT, 10.0)) };
        let rows = [
            Row { tolerance: Some(2.0), ..row("a.stp", EXACT, 1.0) },
            Row { max_error_px: Some(0.3), triangles: Some(40), ..half(row("a.stp", EXACT, 6.0)) },
            half(row("a.stp", STATIC, 4.0)),
            row("a.stp", FIRST, 100.0),
            row("a.stp", "first picture: reading", 70.0),
            row("a.stp", "first picture: projection", 20.0),
            row("a.stp", "first picture: upload", 5.0),
            row("a.stp", F3D_FIRST, 400.0),
            Row { max_error_px: Some(1.5), ..meshed },
            half(row("9 faces", EXACT, 6.0)),
            half(row("9 faces", STATIC, 6.0)),
            row("9 faces", "first picture: reading", 70.0),
            row("9 faces", "first picture: projection", 20.0),
            row("9 faces", "first picture: upload", 5.0),
            Row { ms: None, note: Some("not measured: gone".into()), ..row("all", F3D, 0.0) },
        ];
        let line = first_lines(&rows.each_ref()).unwrap();
        for words in [
            "exact loses to OCCT's meshing (a.stp 2.50), a static mesh's frame (a.stp 1.50)",
            "it wins against F3D's first picture from the same file (a.stp 0.25)",
            "OCCT's triangles (a.stp 0.80), a static mesh's frame (9 faces 1.00).",
            "OCCT's mesh for half a pixel is further off on a.stp (1.50 px). F3D",
            "F3D was not measured: gone.",
        ] {
            assert!(line.contains(words), "{words}: {line}");
        }
        let found = findings(&rows).join("\n");
        for words in [
            "same triangles: a.stp 1.50, 9 faces 1.00. The aim is at most 1.4: missed by a.stp.",
            "a.stp: first picture after 100 ms (reading 70.0, projection 20.0, upload 5.0).",
            "has 50 triangles and is up to 1.50 px off; exact draws 40 and is up to 0.30 px off.",
            "9 faces: 95 ms from the file to the first draw call, without shaders. The aim is at most 300 ms: met.",
        ] {
            assert!(found.contains(words), "{words}: {found}");
        }
        assert!(first_lines(&[]).is_none() && findings(&[]).is_empty());
    }
}
