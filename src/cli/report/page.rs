//! The report as one self-contained page.

use std::io::Cursor;

use crate::io::{Error, Result};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use freeform_surface::Image;
use image::ImageFormat;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::row::{NOISY, Row};
use super::{Figure, Section};

const STYLE: &str = "
body { font: 16px/1.5 system-ui, sans-serif; margin: 0 auto; max-width: 62rem; padding: 1rem; color: #222 }
h1, h2, h3 { line-height: 1.2 }
.scroll { overflow-x: auto }
table { border-collapse: collapse; font-size: .8rem }
th, td { padding: .15rem .5rem; text-align: right; border-bottom: 1px solid #ddd; white-space: nowrap }
th:first-child, td:first-child, td:nth-child(2) { text-align: left }
svg, img { max-width: 100%; height: auto }
figure { margin: 0 } figcaption { font-size: .8rem; overflow-wrap: anywhere }
.figures { display: grid; gap: .8rem; grid-template-columns: repeat(auto-fit, minmax(min(15rem, 100%), 1fr)) }
.noisy { color: #a40 } code { overflow-wrap: anywhere }
@media print { .scroll { overflow: visible } table { font-size: 5pt } .by-hand { display: none } }
";

/// The text of a table's cell, if the row has the value.
type Cell = fn(&Row) -> Option<String>;

/// The columns of the tables: the title, and the text of a row's cell.
const COLUMNS: [(&str, Cell); 21] = [
    ("scene", |row| Some(row.scene.clone())),
    ("method", |row| Some(row.method.clone())),
    ("level", |row| row.level.map(|v| v.to_string())),
    ("tolerance", |row| row.tolerance.map(|v| v.to_string())),
    ("iterations", |row| row.iterations.map(|v| v.to_string())),
    ("epsilon", |row| row.epsilon.map(|v| v.to_string())),
    ("segments", |row| row.segments.map(|v| v.to_string())),
    ("patches", |row| row.patches.map(|v| v.to_string())),
    ("triangles", |row| row.triangles.map(|v| v.to_string())),
    ("ms", |row| row.ms.map(|v| format!("{v:.2}"))),
    ("spread", |row| row.spread.map(|v| format!("{:.0} %", 100.0 * v))),
    ("largest error, px", |row| row.max_error_px.map(|v| format!("{v:.3}"))),
    ("RMS error, px", |row| row.rms_error_px.map(|v| format!("{v:.4}"))),
    ("normals off, °", |row| row.normal_error_deg.map(|v| format!("{v:.2}"))),
    ("wrong pixels", |row| row.wrong_pixels.map(|v| v.to_string())),
    ("of pixels", |row| row.pixels.map(|v| v.to_string())),
    ("silhouette pixels", |row| row.silhouette_pixels.map(|v| v.to_string())),
    ("distance", |row| row.max_error.map(|v| format!("{v:.6}"))),
    ("memory, MB", |row| row.memory.map(|v| format!("{:.1}", v as f64 / 1e6))),
    ("what went wrong", |row| row.note.clone()),
    ("furthest wrong, px", |row| row.max_wrong_distance.map(|v| format!("{v:.1}"))),
];

/// The head of the page, above all sections.
#[derive(Debug, Default)]
pub(super) struct Head {
    pub(super) version: String,
    pub(super) driver: String,
    pub(super) machine: String,
    /// The clock that measures the times.
    pub(super) clock: &'static str,
    pub(super) size: (u32, u32),
    pub(super) summary: Vec<String>,
    pub(super) command: String,
}

/// The whole page.
///
/// # Errors
/// A picture cannot be encoded.
pub(super) fn page(head: &Head, sections: &[Section]) -> Result<String> {
    let mut bodies = Vec::new();
    for section in sections {
        bodies.push(body(section)?);
    }
    Ok(html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                link rel="icon" href="data:,";
                title { "freeform: speed against error" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Speed against error" }
                ul { @for line in &head.summary { li { (line) } } }
                p {
                    "freeform " (head.version) ", " (head.driver) ", " (head.machine) ". Pictures of "
                    (head.size.0) "×" (head.size.1) " pixels. Times are medians, taken in turns, of " (head.clock)
                    "; their spread is the distance between the quartiles, over the median. Made by " code { (head.command) } "."
                }
                @for body in bodies { (body) }
            }
        }
    }
    .into_string())
}

fn body(section: &Section) -> Result<Markup> {
    let mut figures = Vec::new();
    for Figure { caption, image } in &section.figures {
        figures.push(html! {
            figure {
                img src=(data_url(image)?) alt=(caption) width=(image.width())
                    height=(image.height()) loading="lazy";
                figcaption { (caption) }
            }
        });
    }
    let noisy = section.rows.iter().filter(|row| row.is_noisy()).count();
    Ok(html! {
        section id=(section.name) {
            h2 { (section.title) }
            p { (section.meaning) }
            @if !section.findings.is_empty() {
                ul { @for finding in &section.findings { li { (finding) } } }
            }
            @for (title, svg) in &section.plots {
                figure {
                    (PreEscaped(responsive(svg, title)))
                    figcaption { (title) }
                }
            }
            @if !figures.is_empty() { div.figures { @for figure in figures { (figure) } } }
            @if noisy > 0 {
                p.noisy {
                    (noisy) " rows, marked, have a spread above " (100.0 * NOISY)
                    " %: the machine was busy."
                }
            }
            (table(&section.rows))
        }
    })
}

/// A table with the columns for which at least one row has a value.
fn table(rows: &[Row]) -> Markup {
    let columns: Vec<_> =
        COLUMNS.iter().filter(|(_, cell)| rows.iter().any(|row| cell(row).is_some())).collect();
    html! {
        div.scroll {
            table {
                thead { tr { @for (title, _) in &columns { th { (title) } } th.by-hand { "by hand" } } }
                tbody {
                    @for row in rows {
                        tr.noisy[row.is_noisy()] {
                            @for (_, cell) in &columns { td { (cell(row).unwrap_or_default()) } }
                            td.by-hand { code { (row.command) } }
                        }
                    }
                }
            }
        }
    }
}

/// A plot that scales down with the page and has a label for screen readers.
fn responsive(svg: &str, title: &str) -> String {
    let label = html! { (title) }.into_string();
    svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{label}\" "), 1)
}

fn data_url(image: &Image) -> Result<String> {
    let mut png = Cursor::new(Vec::new());
    image
        .write_to(&mut png, ImageFormat::Png)
        .map_err(|error| Error::file("make", "a picture of the report", error))?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(png.into_inner())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_has_rows_plots_and_pictures() {
        let mut section = Section::new("trimming", "Trims & more", "What <it> means.");
        section.rows.push(Row {
            ms: Some(1.5),
            spread: Some(0.5),
            ..Row::new("trimming", "a", "exact")
        });
        section.plots.push(("a plot".into(), "<svg width=\"1\"></svg>".into()));
        let image = Image::from_pixel(2, 1, image::Rgba([1, 2, 3, 255]));
        section.figures.push(Figure { caption: "a \"picture\"".into(), image });
        let head = Head {
            version: "0".into(),
            driver: "d".into(),
            machine: "m".into(),
            clock: "c",
            size: (1, 1),
            summary: vec!["use exact".into()],
            command: "freeform report".into(),
        };
        let text = page(&head, &[section]).unwrap();
        for words in [
            "Trims &amp; more",
            "What &lt;it&gt; means.",
            "<svg role=\"img\" aria-label=\"a plot\" width=\"1\">",
            "alt=\"a &quot;picture&quot;\"",
            "data:image/png;base64,",
            "<td>1.50</td>",
            "1 rows, marked",
            "<li>use exact</li>",
        ] {
            assert!(text.contains(words), "{words}: {text}");
        }
        assert!(!text.contains("<script") && !text.contains("wrong pixels"));
    }
}
