//! Conclusions from the rows: which method to use when, and where a peer is faster.

use super::models;
use super::peers::{LIBGLU, STATIC};
use super::row::{Row, half_a_pixel, trims};

/// The first lines of the report, as far as the rows allow conclusions.
pub(super) fn advice(rows: &[&Row]) -> Vec<String> {
    let mut lines = Vec::new();
    lines.extend(surfaces(rows));
    lines.extend(trimmed(rows));
    lines.extend(meshes(rows));
    lines.extend(losses(rows));
    lines.extend(models::first_lines(rows));
    lines
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

/// For each scene, an error of half a pixel by tolerance against the thesis' best level.
fn surfaces(rows: &[&Row]) -> Option<String> {
    let (mut ahead, mut behind, mut unreached) = (Vec::new(), Vec::new(), Vec::new());
    let mut normals = [None::<f64>; 2];
    for scene in scenes(rows.iter().copied().filter(|row| row.section == "tessellation")) {
        let both = half_a_pixel(rows, scene);
        for (worst, row) in normals.iter_mut().zip(both) {
            let own = row.and_then(|row| row.normal_error_deg);
            *worst = worst.zip(own).map(|(a, b)| a.max(b)).or(*worst).or(own);
        }
        match both {
            [Some(ours), Some(thesis)] => {
                let ratio = ours.ms? / thesis.ms?;
                let list = if ratio <= 1.0 { &mut ahead } else { &mut behind };
                list.push(format!("{scene} {ratio:.2}"));
            }
            [Some(_), None] => unreached.push(scene),
            _ => {}
        }
    }
    let lists = [
        (
            "faster than the thesis' best level, found by hand (share of its time: ",
            ahead.join(", "),
            ")",
        ),
        ("slower than it on others (", behind.join(", "), ")"),
        ("and the only one to hold that on ", unreached.join(", "), ""),
    ];
    let told = lists.iter().filter(|(_, names, _)| !names.is_empty());
    let told: Vec<String> = told.map(|(how, names, end)| format!("{how}{names}{end}")).collect();
    if told.is_empty() {
        return None;
    }
    let mut line =
        format!("Surfaces within half a pixel: exact with a tolerance is {}", told.join(", "));
    if let [Some(ours), Some(thesis)] = normals {
        line += &format!(
            "; its normals are up to {ours:.1}° off, the thesis' up to {thesis:.0}°. Use exact, and a level \
             by hand where one view's speed is all that counts"
        );
    }
    Some(line + ".")
}

/// Wrong pixels and time of exact trims, compared with the thesis' usual Newton iterations.
fn trimmed(rows: &[&Row]) -> Option<String> {
    let ((wrong, ms), (thesis_wrong, thesis_ms)) =
        (trims(rows, None)?, trims(rows, Some((10, 1e-3)))?);
    let ratio = ms / thesis_ms;
    Some(format!(
        "Trims: use exact, {wrong} wrong pixels in figures 22–25 at {ratio:.2} of the time of the thesis' \
         ten iterations, which leave {thesis_wrong}. Use the thesis' method to see what it draws."
    ))
}

/// For each mesh, the smoothing that comes closest to the ideal surface at the finest measured level.
fn meshes(rows: &[&Row]) -> Option<String> {
    let of = || {
        let rows = rows.iter().copied().filter(|row| row.section == "triangles");
        rows.filter(|row| row.method.ends_with("GPU") && row.max_error.is_some())
    };
    let finest = of().filter_map(|row| row.level).max()?;
    let told: Vec<String> = scenes(of())
        .into_iter()
        .filter_map(|scene| {
            let here = of().filter(|row| row.scene == scene && row.level == Some(finest));
            let error = |row: &Row| row.max_error.unwrap_or(f64::INFINITY);
            let best = here.min_by(|a, b| error(a).total_cmp(&error(b)))?;
            Some(format!("{scene}: {} ({:.4})", best.method.trim_end_matches(", GPU"), error(best)))
        })
        .collect();
    (!told.is_empty()).then(|| {
        format!("Meshes, nearest to the ideal shape at level {finest}: {}.", told.join("; "))
    })
}

/// How the exact method compares with each peer at all tolerances, and whether any peer is faster.
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
    // A peer that is not installed.
    let missing = of(LIBGLU).find_map(|row| Some(format!(" {LIBGLU} was {}.", row.note.as_ref()?)));
    (!stands.is_empty()).then(|| {
        let stands = stands.join("; it ");
        format!("Peers, the teapot at 1920×1080: exact {stands}.{}", missing.unwrap_or_default())
    })
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
            ["time: a 0.25)", "others (b 1.50)", "only one to hold that on c", "41°", "2.2°"]
        {
            assert!(lines[0].contains(words), "{words}: {}", lines[0]);
        }
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
        // A peer that is not installed is named.
        let missing = Row { note: Some("not measured: gone".into()), ..peer(LIBGLU, 0.5, 0.0) };
        let missing = Row { ms: None, tolerance: None, ..missing };
        let line = &advice(&[&rows[0], &rows[1], &missing])[0];
        assert!(
            line.contains("). libGLU was not measured: gone.") && !line.contains("against libGLU")
        );
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
            mesh("phong, GPU", 3, 0.001),
            mesh("pn, GPU", 8, 0.01),
            mesh("phong, GPU", 8, 0.03),
            mesh("pn, software, 3 steps", 0, 0.001),
        ];
        let line = &advice(&rows.each_ref())[0];
        assert!(line.contains("at level 8: sphere: pn (0.0100)"), "{line}");
    }
}
