//! What the rows come to: which method to use when, and where a peer is faster.

use super::peers::{LIBGLU, STATIC};
use super::row::Row;

/// Pixels within which most pictures are good enough.
const GOOD_ENOUGH: f64 = 0.5;

/// The report's first lines, as far as the rows tell.
pub(super) fn advice(rows: &[&Row]) -> Vec<String> {
    let mut lines = Vec::new();
    lines.extend(surfaces(rows));
    lines.extend(trims(rows));
    lines.extend(meshes(rows));
    lines.extend(losses(rows));
    lines
}

/// The fastest of some rows.
fn fastest<'a>(rows: impl Iterator<Item = &'a Row>) -> Option<&'a Row> {
    rows.filter(|row| row.ms.is_some())
        .min_by(|a, b| a.ms.unwrap_or(f64::NAN).total_cmp(&b.ms.unwrap_or(f64::NAN)))
}

/// Names in the order of the rows, each once.
fn scenes<'a>(rows: impl Iterator<Item = &'a Row>) -> Vec<&'a str> {
    let mut names: Vec<&str> = Vec::new();
    for row in rows {
        if !names.contains(&row.scene.as_str()) {
            names.push(&row.scene);
        }
    }
    names
}

/// Tolerance against the thesis' best level, scene by scene.
fn surfaces(rows: &[&Row]) -> Option<String> {
    let of = || rows.iter().copied().filter(|row| row.section == "tessellation");
    let good = |row: &&Row| row.max_error_px.is_some_and(|error| error <= GOOD_ENOUGH);
    let (mut ahead, mut behind) = (Vec::new(), Vec::new());
    for scene in scenes(of()) {
        let here = || of().filter(|row| row.scene == scene).filter(good);
        let Some(ours) = fastest(here().filter(|row| row.tolerance.is_some())) else { continue };
        match fastest(here().filter(|row| row.method == "thesis")) {
            Some(thesis) => {
                let ratio = ours.ms? / thesis.ms?;
                let list = if ratio <= 1.0 { &mut ahead } else { &mut behind };
                list.push(format!("{scene} {ratio:.2}"));
            }
            None => ahead.push(format!("{scene}, which no level of it reaches")),
        }
    }
    if ahead.is_empty() && behind.is_empty() {
        return None;
    }
    let worst = |method: &str| {
        let rows = of().filter(|row| row.method == method).filter(good);
        rows.filter_map(|row| row.normal_error_deg).fold(0.0, f64::max)
    };
    let mut line = String::from("Surfaces within half a pixel: ");
    if !ahead.is_empty() {
        line += &format!(
            "use exact with a tolerance, faster than the best level of the thesis that holds it (share \
             of its time: {})",
            ahead.join("; ")
        );
    }
    if !behind.is_empty() {
        line += &format!(
            "{}slower than that level, found by hand, on: {}",
            if ahead.is_empty() { "exact with a tolerance is " } else { "; but " },
            behind.join("; ")
        );
    }
    line += &format!(
        ". There, normals of the thesis are still up to {:.0}° off, those of exact up to {:.1}°.",
        worst("thesis"),
        worst("exact")
    );
    Some(line)
}

/// Wrong pixels and time of exact trims and of the thesis' usual Newton iterations.
fn trims(rows: &[&Row]) -> Option<String> {
    // Pictures of defects are not timed.
    let of = |is_ours: &dyn Fn(&Row) -> bool| {
        let rows = rows.iter().filter(|row| row.section == "trimming" && row.ms.is_some());
        rows.filter(|row| is_ours(row)).fold(None, |sum: Option<(usize, f64)>, row| {
            let (pixels, ms) = sum.unwrap_or_default();
            Some((pixels + row.wrong_pixels?, ms + row.ms?))
        })
    };
    let (wrong, ms) = of(&|row| row.method == "exact")?;
    let (thesis_wrong, thesis_ms) = of(&|row| {
        row.method == "thesis" && row.iterations == Some(10) && row.epsilon == Some(1e-3)
    })?;
    let ratio = ms / thesis_ms;
    Some(format!(
        "Trims: use exact, {wrong} wrong pixels in figures 22–26 at {ratio:.2} of the time of the thesis' \
         ten iterations, which leave {thesis_wrong}. Use the thesis' method to see what it draws."
    ))
}

/// The nearest way to smooth each mesh, and what it costs.
fn meshes(rows: &[&Row]) -> Option<String> {
    let of = || {
        let rows = rows.iter().copied().filter(|row| row.section == "triangles");
        rows.filter(|row| row.method.ends_with("GPU"))
    };
    let told: Vec<String> = scenes(of())
        .into_iter()
        .filter_map(|scene| {
            let here = of().filter(|row| row.scene == scene);
            let error = |row: &Row| row.max_error.unwrap_or(f64::NAN);
            let best = here.min_by(|a, b| error(a).total_cmp(&error(b)))?;
            let way = best.method.trim_end_matches(", GPU");
            Some(format!("{scene}: {way} at level {} ({:.4})", best.level?, error(best)))
        })
        .collect();
    (!told.is_empty()).then(|| format!("Meshes, nearest to the ideal shape: {}.", told.join("; ")))
}

/// How exact stands to each peer at all tolerances, and whether it loses anywhere.
fn losses(rows: &[&Row]) -> Option<String> {
    let of = |method: &'static str| {
        rows.iter().filter(move |row| row.section == "peers" && row.method == method)
    };
    let stands = |peer: &'static str| {
        let mut loses = Vec::new();
        let mut ratios = Vec::new();
        for row in of("exact") {
            let tolerance = row.tolerance?;
            let its = of(peer).find(|other| other.tolerance == row.tolerance)?;
            let ratio = row.ms? / its.ms?;
            ratios.push(format!("{ratio:.2} at {tolerance} px"));
            if ratio > 1.0 {
                loses.push(ratio);
            }
        }
        let how = match loses.len() {
            0 => "wins against",
            all if all == ratios.len() => "loses to",
            _ => "wins and loses against",
        };
        (!ratios.is_empty())
            .then(|| format!("{how} {peer} (share of its time: {})", ratios.join(", ")))
    };
    let stands: Vec<String> = [LIBGLU, STATIC].into_iter().filter_map(stands).collect();
    (!stands.is_empty())
        .then(|| format!("Peers, the teapot at 1920×1080: exact {}.", stands.join("; it ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(section: &'static str, scene: &str, method: &str, ms: f64) -> Row {
        Row { ms: Some(ms), ..Row::new(section, scene, method) }
    }

    #[test]
    fn what_is_faster_is_advised_and_what_is_slower_is_told() {
        let surface = |scene: &str, method: &str, ms, tolerance, error, normals| Row {
            tolerance,
            max_error_px: Some(error),
            normal_error_deg: Some(normals),
            ..row("tessellation", scene, method, ms)
        };
        let rows = [
            surface("a", "exact", 1.0, Some(0.5), 0.3, 0.5),
            surface("a", "thesis", 4.0, None, 0.4, 41.0),
            surface("a", "thesis", 1.0, None, 0.8, 80.0),
            surface("b", "exact", 3.0, Some(0.5), 0.3, 2.25),
            surface("b", "thesis", 2.0, None, 0.4, 10.0),
            surface("c", "exact", 3.0, Some(0.5), 0.3, 1.0),
            surface("c", "thesis", 2.0, None, 0.6, 10.0),
        ];
        let lines = advice(&rows.each_ref());
        assert_eq!(lines.len(), 1, "{lines:?}");
        for words in
            ["a 0.25", "c, which no level of it reaches", "but slower", "on: b 1.50", "41°"]
        {
            assert!(lines[0].contains(words), "{words}: {}", lines[0]);
        }
        assert!(lines[0].contains("2.2°"), "{}", lines[0]);
    }

    #[test]
    fn trims_are_summed_over_the_figures() {
        let trim = |method: &str, iterations, wrong, ms| Row {
            iterations,
            epsilon: iterations.map(|_| 1e-3),
            wrong_pixels: Some(wrong),
            ..row("trimming", "figure", method, ms)
        };
        let rows = [
            trim("exact", None, 0, 3.0),
            trim("exact", None, 1, 3.0),
            trim("thesis", Some(10), 70, 6.0),
            trim("thesis", Some(5), 700, 60.0),
            // A defect's picture.
            Row { ms: None, ..trim("exact", None, 5, 0.0) },
        ];
        let lines = advice(&rows.each_ref());
        assert!(lines[0].contains("1 wrong pixels") && lines[0].contains("leave 70"), "{lines:?}");
        assert!(lines[0].contains("1.00 of the time"), "{lines:?}");
    }

    #[test]
    fn losses_are_told_beside_wins() {
        let peer = |method: &str, tolerance, ms| Row {
            tolerance: Some(tolerance),
            ..row("peers", "teapot", method, ms)
        };
        let rows = [
            peer("exact", 2.0, 2.0),
            peer(STATIC, 2.0, 1.0),
            peer(LIBGLU, 2.0, 1.6),
            peer("exact", 0.5, 3.0),
            peer(STATIC, 0.5, 2.0),
            peer(LIBGLU, 0.5, 6.0),
        ];
        let line = &advice(&rows.each_ref())[0];
        for words in [
            "wins and loses against libGLU (share of its time: 1.25 at 2 px, 0.50 at 0.5 px)",
            "loses to static mesh (share of its time: 2.00 at 2 px, 1.50 at 0.5 px)",
        ] {
            assert!(line.contains(words), "{line}");
        }
        // What was not installed is not compared.
        let line = &advice(&[&rows[0], &rows[1]])[0];
        assert!(!line.contains(LIBGLU), "{line}");
        assert!(advice(&[]).is_empty());
    }

    #[test]
    fn the_nearest_smoothing_is_named() {
        let mesh = |method: &str, level, error| Row {
            level: Some(level),
            max_error: Some(error),
            ..row("triangles", "sphere", method, 1.0)
        };
        let rows = [
            mesh("plain, GPU", 1, 0.2),
            mesh("pn, GPU", 8, 0.01),
            mesh("phong, GPU", 8, 0.03),
            mesh("pn, software, 3 steps", 0, 0.001),
        ];
        assert!(advice(&rows.each_ref())[0].contains("sphere: pn at level 8 (0.0100)"));
    }
}
