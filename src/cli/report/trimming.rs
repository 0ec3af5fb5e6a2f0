//! Section 2: wrong decisions and cost of trims, and the thesis' claims about Newton's method.

use crate::io::Result;
use freeform_surface::{Method, Newton, Scene};

use super::bench::{Bench, difference};
use super::plot::{Line, plot};
use super::row::{Row, name, trims};
use super::{Figure, Section};

const FIGURES: std::ops::RangeInclusive<u32> = 22..=26;
const DEFECTS: std::ops::RangeInclusive<u32> = 28..=34;
const ITERATIONS: [u32; 13] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 20];
const EPSILONS: [f64; 6] = [1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

fn path(figure: u32) -> String {
    format!("scenes/thesis/fig{figure}.toml")
}

fn with(scene: &Scene, method: Method, newton: Newton) -> Scene {
    let mut scene = scene.clone();
    scene.settings.method = method;
    scene.settings.newton = newton;
    scene
}

pub(super) fn section(bench: &mut Bench) -> Result<Section> {
    let mut section = Section::new(
        "trimming",
        "Trimming: wrong pixels against time",
        "A pixel is wrong if it is drawn and the loops cut the (u, v) that it shows, in f64, or if it is \
         missing and they keep what the same triangles show there uncut. The distance is from the \
         furthest wrong pixel to the nearest one on the other side of the loops' border. Figure 26 is \
         figure 25 in lines: it is timed, and its pixels are not counted again.",
    );
    bench.begin(FIGURES.count() + DEFECTS.count());
    for figure in FIGURES {
        bench.step(format!("trimming: figure {figure}"));
        rows_of(bench, figure, &mut section)?;
    }
    section.findings = claims(&section.rows);
    for figure in DEFECTS {
        bench.step(format!("trimming: figure {figure}"));
        pictures_of(bench, figure, &mut section)?;
    }
    Ok(section)
}

/// The rows of one figure: the exact method, and the thesis' with all numbers of iterations and all epsilons.
fn rows_of(bench: &mut Bench, figure: u32, section: &mut Section) -> Result<()> {
    let scene = bench.scene(&path(figure))?;
    let usual = Newton::default();
    let mut ways = vec![(Method::Exact, usual)];
    let iterations: &[u32] = if bench.quick { &[5, 10, 20] } else { &ITERATIONS };
    let epsilons: &[f64] = if bench.quick { &[1e-3, 1e-4] } else { &EPSILONS };
    for iterations in iterations {
        ways.push((Method::Thesis, Newton::new(*iterations, usual.epsilon())?));
    }
    for epsilon in epsilons.iter().filter(|epsilon| **epsilon != usual.epsilon()) {
        ways.push((Method::Thesis, Newton::new(usual.iterations(), *epsilon)?));
    }
    let scenes: Vec<Scene> =
        ways.iter().map(|(method, newton)| with(&scene, *method, *newton)).collect();
    let timings = bench.time(&scenes)?;
    let scene_name = format!("figure {figure}");
    let mut by_iterations = Vec::new();
    let mut exact_ms = 0.0;
    for (((method, newton), scene), timing) in ways.iter().zip(&scenes).zip(timings) {
        let is_thesis = *method == Method::Thesis;
        let in_lines = scene.settings.wireframe;
        let wrong = if in_lines { None } else { Some(bench.wrong(scene)?) };
        if is_thesis && newton.epsilon() == usual.epsilon() {
            by_iterations.push((f64::from(newton.iterations()), timing.ms));
        } else if !is_thesis {
            exact_ms = timing.ms;
        }
        let row = Row {
            iterations: is_thesis.then(|| newton.iterations()),
            epsilon: is_thesis.then(|| newton.epsilon()),
            segments: Some(scene.surfaces[0].trims.segment_count()),
            wrong_pixels: wrong.map(|wrong| wrong.pixels),
            max_wrong_distance: wrong.and_then(|wrong| wrong.distance),
            command: bench.report_command("trimming"),
            ..Row::new("trimming", &scene_name, name(*method))
        };
        section.rows.push(row.timed(timing));
    }
    let lines = [
        Line { name: "thesis".into(), points: by_iterations.clone() },
        Line {
            name: "exact, no iterations".into(),
            points: by_iterations.iter().map(|(x, _)| (*x, exact_ms)).collect(),
        },
    ];
    let title = format!("Figure {figure}: what iterations cost");
    section.plots.push((title, plot("Newton iterations", "milliseconds a frame", &lines, None)?));
    Ok(())
}

/// A defect of the thesis, the exact picture beside it, and the difference of the two.
fn pictures_of(bench: &mut Bench, figure: u32, section: &mut Section) -> Result<()> {
    let thesis = bench.scene(&path(figure))?;
    let exact = with(&thesis, Method::Exact, thesis.settings.newton);
    let (wrong, exact_wrong) = (bench.wrong(&thesis)?, bench.wrong(&exact)?);
    let pictures = [bench.picture(&thesis)?, bench.picture(&exact)?];
    let newton = thesis.settings.newton;
    let how = format!("{} iterations, epsilon {}", newton.iterations(), newton.epsilon());
    for (method, wrong) in [(Method::Thesis, wrong), (Method::Exact, exact_wrong)] {
        let is_thesis = method == Method::Thesis;
        section.rows.push(Row {
            iterations: is_thesis.then(|| newton.iterations()),
            epsilon: is_thesis.then(|| newton.epsilon()),
            wrong_pixels: Some(wrong.pixels),
            max_wrong_distance: wrong.distance,
            command: bench.report_command("trimming"),
            ..Row::new("trimming", &format!("figure {figure}"), name(method))
        });
    }
    let differ = difference(&pictures[1], &pictures[0]);
    let [thesis_picture, exact_picture] = pictures;
    for (what, image) in [
        (format!("thesis: {how}, {} wrong pixels", wrong.pixels), thesis_picture),
        (format!("exact: {} wrong pixels", exact_wrong.pixels), exact_picture),
        ("where they differ, in red".into(), differ),
    ] {
        section.figures.push(Figure { caption: format!("Figure {figure}, {what}"), image });
    }
    Ok(())
}

/// The thesis' claims about its method, and the verdict of the rows on each.
fn claims(rows: &[Row]) -> Vec<String> {
    let rows: Vec<&Row> = rows.iter().collect();
    let mut findings = Vec::new();
    if let Some((wrong, _)) = trims(&rows, None) {
        findings.push(format!("Exact trims leave {wrong} wrong pixels in figures 22–25."));
    }
    let by_iterations: Vec<String> = ITERATIONS
        .into_iter()
        .filter_map(|n| Some(format!("{n}: {}", trims(&rows, Some((n, 1e-3)))?.0)))
        .collect();
    if !by_iterations.is_empty() {
        let list = by_iterations.join(", ");
        findings.push(format!("Wrong pixels there by the thesis' iterations: {list}."));
    }
    // More effort counts as better if it leaves fewer wrong pixels by more than a twentieth.
    let compare = |claim: &str, [few, many]: [(u32, f64); 2], holds_if_better: bool| {
        let ((few_wrong, few_ms), (many_wrong, many_ms)) =
            (trims(&rows, Some(few))?, trims(&rows, Some(many))?);
        let is_better = (many_wrong as f64) < 0.95 * few_wrong as f64;
        let verdict = if is_better == holds_if_better { "holds" } else { "does not hold" };
        Some(format!(
            "“{claim}” {verdict} here: {} iterations with epsilon {} leave {few_wrong} wrong pixels in \
             {few_ms:.1} ms, {} with {} leave {many_wrong} in {many_ms:.1} ms.",
            few.0, few.1, many.0, many.1
        ))
    };
    findings.extend(compare("At least ten iterations", [(5, 1e-3), (10, 1e-3)], true));
    findings.extend(compare("0.001 is enough", [(10, 1e-3), (10, 1e-4)], false));
    findings.extend(compare("0.0001 is not worth it", [(10, 1e-3), (10, 1e-4)], false));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn claims_are_checked_by_the_rows() {
        let row = |method: &str, iterations: Option<u32>, epsilon, pixels| Row {
            iterations,
            epsilon: iterations.map(|_| epsilon),
            wrong_pixels: Some(pixels),
            ms: Some(2.0),
            ..Row::new("trimming", "figure 22", method)
        };
        let rows = [
            row("exact", None, 0.0, 0),
            row("thesis", Some(5), 1e-3, 40),
            row("thesis", Some(10), 1e-3, 39),
            row("thesis", Some(10), 1e-4, 3),
        ];
        let claims = claims(&rows);
        assert!(claims[0].contains("leave 0 wrong"));
        assert!(claims[1].contains("5: 40, 10: 39."), "{}", claims[1]);
        assert!(claims[2].contains("does not hold") && claims[2].contains("leave 39"));
        assert!(claims[3].contains("enough” does not hold") && claims[3].contains("leave 3 in"));
        assert_eq!(super::claims(&rows[..2]).len(), 2, "what was not measured is not claimed");
    }
}
