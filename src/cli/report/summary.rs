//! The report shortened to half a page for a README: a table in Markdown.

use std::fmt::Write as _;

use super::page::Head;
use super::peers::{LIBGLU, STATIC};
use super::row::{Row, half_a_pixel, trims};

/// Every method and peer for the teapot at an error of half a pixel, and the trims of the thesis' figures
/// 22–25, and frames of CAD models, as far as the rows contain them.
pub(super) fn summary(head: &Head, rows: &[&Row]) -> String {
    let mut text = format!(
        "Measured by `freeform report` {} on {}, {}.\n\n\
         | what | ms a frame | triangles | largest error, px | normals off, ° | wrong pixels |\n\
         |---|--:|--:|--:|--:|--:|\n",
        head.version, head.driver, head.machine
    );
    let mut line = |what: String, row: &Row| {
        let cell = |text: Option<String>| text.unwrap_or_else(|| "–".into());
        writeln!(
            text,
            "| {what} | {} | {} | {} | {} | {} |",
            cell(row.ms.map(|v| format!("{v:.1}"))),
            cell(row.triangles.map(|v| v.to_string())),
            cell(row.max_error_px.map(|v| format!("{v:.2}"))),
            cell(row.normal_error_deg.map(|v| format!("{v:.1}"))),
            cell(row.wrong_pixels.map(|v| v.to_string())),
        )
        .expect("a string takes all");
    };
    let half = |row: &&&Row| row.tolerance == Some(0.5);
    let peers = rows.iter().filter(|row| row.section == "peers").filter(half);
    for row in peers.clone() {
        let what = match row.method.as_str() {
            LIBGLU => "libGLU, tessellated for each frame, to 0.5 px",
            STATIC => "a static mesh of exact's triangles",
            _ => "**exact, to 0.5 px**",
        };
        line(format!("teapot, 1920×1080: {what}"), row);
    }
    for row in rows.iter().filter(|row| row.section == "models").filter(half) {
        let what = match row.method.as_str() {
            "exact" => "**exact, to 0.5 px**",
            STATIC => "a static mesh of exact's triangles, without trims",
            _ => continue,
        };
        line(format!("{}: {what}", row.scene), row);
    }
    let [ours, thesis] = half_a_pixel(rows, "teapot");
    if let Some(row) = ours {
        line("teapot from nearer, 1000×600: **exact, to 0.5 px**".into(), row);
    }
    if let Some((row, level)) = thesis.and_then(|row| Some((row, row.level?))) {
        line(format!("teapot from nearer, 1000×600: thesis, level {level}, found by hand"), row);
    }
    for (newton, what) in
        [(None, "**exact**"), (Some((10, 1e-3)), "thesis, 10 iterations, epsilon 0.001")]
    {
        if let Some((wrong, ms)) = trims(rows, newton) {
            let all = Row { ms: Some(ms), wrong_pixels: Some(wrong), ..Row::default() };
            line(format!("trims, figures 22–25 together: {what}"), &all);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_summed_up_as_a_table() {
        let row = |section, scene: &str, method: &str, ms| Row {
            ms: Some(ms),
            ..Row::new(section, scene, method)
        };
        let at_half = |row| Row { tolerance: Some(0.5), max_error_px: Some(0.25), ..row };
        let level = |level, error| Row {
            level: Some(level),
            max_error_px: Some(error),
            ..row("tessellation", "teapot", "thesis", 2.0)
        };
        let trim =
            |wrong, ms| Row { wrong_pixels: Some(wrong), ..row("trimming", "figure", "exact", ms) };
        let rows = [
            at_half(row("peers", "teapot", "exact", 1.5)),
            at_half(row("peers", "teapot", LIBGLU, 3.0)),
            at_half(row("models", "flange", "exact", 4.5)),
            at_half(row("models", "a.stp", "OCCT mesh", 9.5)),
            Row { ms: Some(7.0), ..level(64, 0.1) },
            level(32, 0.4),
            level(16, 0.9),
            trim(1, 1.0),
            trim(2, 2.5),
            Row { ms: None, ..trim(9, 0.0) },
        ];
        let head = Head { driver: "a driver".into(), ..Head::default() };
        let text = summary(&head, &rows.each_ref());
        for words in [
            "on a driver",
            "| teapot, 1920×1080: **exact, to 0.5 px** | 1.5 | – | 0.25 | – | – |",
            "libGLU, tessellated for each frame, to 0.5 px | 3.0",
            "| flange: **exact, to 0.5 px** | 4.5 | – | 0.25",
            "thesis, level 32, found by hand | 2.0 | – | 0.40",
            "**exact** | 3.5 | – | – | – | 3 |",
        ] {
            assert!(text.contains(words), "{words}: {text}");
        }
        assert_eq!(text.lines().count(), 9, "{text}");
    }
}
