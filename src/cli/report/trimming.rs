//! Section 2: what trims decide wrongly and cost, and the thesis' claims about Newton's method.

use freeform_surface::{Method, Newton, Result, Scene};

use super::lab::{Lab, Wrong, difference};
use super::plot::{Line, plot};
use super::row::{Row, name};
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

pub(super) fn section(lab: &mut Lab) -> Result<Section> {
    let mut section = Section::new(
        "trimming",
        "Trimming: wrong pixels against time",
        "A pixel is wrong if it is drawn and the loops cut the (u, v) that it shows, in f64, or if it is \
         missing among pixels that they keep. The distance is that of the furthest wrong pixel from \
         the loops' border, in pixels.",
    );
    lab.begin(FIGURES.count() + DEFECTS.count());
    for figure in FIGURES {
        lab.step(format!("trimming: figure {figure}"));
        rows_of(lab, figure, &mut section)?;
    }
    section.findings = claims(&section.rows);
    for figure in DEFECTS {
        lab.step(format!("trimming: figure {figure}"));
        pictures_of(lab, figure, &mut section)?;
    }
    Ok(section)
}

/// The rows of one figure: exact, and the thesis with all iterations and all epsilons.
fn rows_of(lab: &mut Lab, figure: u32, section: &mut Section) -> Result<()> {
    let scene = lab.scene(&path(figure))?;
    let usual = Newton::default();
    let mut ways = vec![(Method::Exact, usual)];
    let iterations: &[u32] = if lab.quick { &[5, 10, 20] } else { &ITERATIONS };
    let epsilons: &[f64] = if lab.quick { &[1e-2, 1e-3] } else { &EPSILONS };
    for iterations in iterations {
        ways.push((Method::Thesis, Newton::new(*iterations, usual.epsilon())?));
    }
    for epsilon in epsilons.iter().filter(|epsilon| **epsilon != usual.epsilon()) {
        ways.push((Method::Thesis, Newton::new(usual.iterations(), *epsilon)?));
    }
    let scenes: Vec<Scene> =
        ways.iter().map(|(method, newton)| with(&scene, *method, *newton)).collect();
    let timings = lab.time(&scenes)?;
    let scene_name = format!("figure {figure}");
    // The first is exact, all others are the thesis'.
    let kept = [lab.kept(&scenes[0])?, lab.kept(&scenes[1])?];
    let mut by_iterations = Vec::new();
    let mut exact_ms = 0.0;
    for (((method, newton), scene), timing) in ways.iter().zip(&scenes).zip(timings) {
        let is_thesis = *method == Method::Thesis;
        let Wrong { pixels, distance } = lab.wrong(scene, &kept[usize::from(is_thesis)])?;
        if is_thesis && newton.epsilon() == usual.epsilon() {
            by_iterations.push((f64::from(newton.iterations()), timing.ms));
        } else if !is_thesis {
            exact_ms = timing.ms;
        }
        let row = Row {
            iterations: is_thesis.then(|| newton.iterations()),
            epsilon: is_thesis.then(|| newton.epsilon()),
            segments: Some(scene.surfaces[0].trims.loops.iter().map(|l| l.segments().len()).sum()),
            wrong_pixels: Some(pixels),
            max_wrong_distance: Some(distance),
            command: "freeform report --only trimming".into(),
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

/// A defect of the thesis beside the exact picture, and where they differ.
fn pictures_of(lab: &mut Lab, figure: u32, section: &mut Section) -> Result<()> {
    let thesis = lab.scene(&path(figure))?;
    let exact = with(&thesis, Method::Exact, thesis.settings.newton);
    let kept = [lab.kept(&thesis)?, lab.kept(&exact)?];
    let wrong = lab.wrong(&thesis, &kept[0])?;
    let exact_wrong = lab.wrong(&exact, &kept[1])?;
    let pictures = [lab.picture(&thesis)?, lab.picture(&exact)?];
    let newton = thesis.settings.newton;
    let how = format!("{} iterations, epsilon {}", newton.iterations(), newton.epsilon());
    for (method, wrong) in [(Method::Thesis, wrong), (Method::Exact, exact_wrong)] {
        let is_thesis = method == Method::Thesis;
        section.rows.push(Row {
            iterations: is_thesis.then(|| newton.iterations()),
            epsilon: is_thesis.then(|| newton.epsilon()),
            wrong_pixels: Some(wrong.pixels),
            max_wrong_distance: Some(wrong.distance),
            command: format!(
                "freeform render {} --method {}",
                lab.path(&path(figure)).display(),
                name(method)
            ),
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

/// The thesis' claims about its method, by the rows.
fn claims(rows: &[Row]) -> Vec<String> {
    let total = |iterations: u32, epsilon: f64| {
        let rows = rows
            .iter()
            .filter(|row| row.iterations == Some(iterations) && row.epsilon == Some(epsilon));
        rows.fold(None, |sum: Option<(usize, f64)>, row| {
            let (pixels, ms) = sum.unwrap_or_default();
            Some((pixels + row.wrong_pixels?, ms + row.ms?))
        })
    };
    let exact = rows.iter().filter(|row| row.method == "exact");
    let wrong: usize = exact.clone().filter_map(|row| row.wrong_pixels).sum();
    let mut findings = vec![format!(
        "Exact trimming decides {} wrongly in figures 22–26.",
        if wrong == 0 { "no pixel".into() } else { format!("{wrong} pixels") }
    )];
    let compare = |claim: &str, [a, b]: [(u32, f64); 2]| {
        let ((few, few_ms), (many, many_ms)) = (total(a.0, a.1)?, total(b.0, b.1)?);
        Some(format!(
            "“{claim}”: in all, {} iterations with epsilon {} leave {few} wrong pixels in {few_ms:.1} \
             ms, {} with {} leave {many} in {many_ms:.1} ms.",
            a.0, a.1, b.0, b.1
        ))
    };
    findings.extend(compare("At least ten iterations", [(5, 1e-3), (10, 1e-3)]));
    findings.extend(compare("Ten are enough", [(10, 1e-3), (20, 1e-3)]));
    findings.extend(compare("0.001 is enough", [(10, 1e-2), (10, 1e-3)]));
    findings.extend(compare("0.0001 is not worth it", [(10, 1e-3), (10, 1e-4)]));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn claims_are_checked_by_the_rows() {
        let row = |method: &str, iterations, epsilon, pixels| Row {
            iterations,
            epsilon,
            wrong_pixels: Some(pixels),
            ms: Some(2.0),
            ..Row::new("trimming", "figure 22", method)
        };
        let rows = [
            row("exact", None, None, 0),
            row("thesis", Some(5), Some(1e-3), 40),
            row("thesis", Some(10), Some(1e-3), 3),
        ];
        let claims = claims(&rows);
        assert!(claims[0].contains("no pixel"));
        assert!(claims[1].contains("40 wrong pixels") && claims[1].contains("leave 3"));
        assert_eq!(claims.len(), 2, "what was not measured is not claimed");
    }
}
