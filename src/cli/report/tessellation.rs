//! Section 1: speed against error of both methods, by levels and by tolerance.

use crate::io::Result;
use freeform_surface::{Method, Scene, TessLevel, Tessellation, Tolerance};

use super::Section;
use super::bench::Bench;
use super::plot::{Line, plot};
use super::row::{Row, half_a_pixel, name};

const SCENES: [(&str, &str); 4] = [
    ("teapot", "surfaces/teapot.bpt"),
    ("thesis surface", "scenes/thesis/fig14.toml"),
    ("5×5 surface", "scenes/stability/tess-quartic.toml"),
    ("rational sphere", "scenes/stability/tess-rational-sphere.toml"),
];

/// How a scene is drawn for a row.
#[derive(Debug, Clone, Copy)]
struct Way {
    method: Method,
    tessellation: Tessellation,
}

impl Way {
    fn apply(self, scene: &Scene) -> Scene {
        let mut scene = scene.clone();
        scene.settings.method = self.method;
        scene.settings.tessellation = self.tessellation;
        scene
    }

    fn option(self) -> String {
        match self.tessellation {
            Tessellation::Level(level) => format!("--level {}", level.get()),
            Tessellation::Within(tolerance) => format!("--tolerance {}", tolerance.pixels()),
        }
    }

    /// The line of the plot that it belongs to.
    fn line(self) -> &'static str {
        match (self.method, self.tessellation) {
            (Method::Thesis, _) => "thesis, levels",
            (Method::Exact, Tessellation::Level(_)) => "exact, levels",
            (Method::Exact, Tessellation::Within(_)) => "exact, tolerances",
        }
    }
}

fn ways(quick: bool) -> Result<Vec<Way>> {
    let levels: &[i64] =
        if quick { &[4, 8, 16, 32, 64] } else { &[1, 2, 4, 8, 12, 16, 24, 32, 48, 64] };
    let tolerances: &[f64] =
        if quick { &[2.0, 0.5, 0.1] } else { &[4.0, 2.0, 1.0, 0.5, 0.25, 0.1] };
    let mut ways = Vec::new();
    for method in [Method::Thesis, Method::Exact] {
        for level in levels {
            let tessellation = Tessellation::Level(TessLevel::new(*level)?);
            ways.push(Way { method, tessellation });
        }
    }
    for tolerance in tolerances {
        let tessellation = Tessellation::Within(Tolerance::new(*tolerance)?);
        ways.push(Way { method: Method::Exact, tessellation });
    }
    Ok(ways)
}

pub(super) fn section(bench: &mut Bench) -> Result<Section> {
    let ways = ways(bench.quick)?;
    let mut section = Section::new(
        "tessellation",
        "Tessellation: error against time",
        "Milliseconds of a frame whose camera moves, and how far what each pixel shows is from the \
         surface's own point on the screen, in f64. Thesis normals are wrong within a patch; the \
         last columns show by how much.",
    );
    bench.begin(SCENES.len());
    for (scene_name, path) in SCENES {
        bench.step(format!("tessellation: {scene_name}"));
        let mut scene = bench.scene(path)?;
        scene.settings.samples = Default::default();
        let scenes: Vec<Scene> = ways.iter().map(|way| way.apply(&scene)).collect();
        let timings = bench.time(&scenes)?;
        let file = bench.path(path).display().to_string();
        let mut lines: Vec<Line> = Vec::new();
        for ((way, scene), timing) in ways.iter().zip(&scenes).zip(timings) {
            let (errors, stats) = bench.errors(scene)?;
            let (level, tolerance) = match way.tessellation {
                Tessellation::Level(level) => (Some(level.get()), None),
                Tessellation::Within(tolerance) => (None, Some(tolerance.pixels())),
            };
            let options = format!("--method {} {}", name(way.method), way.option());
            let row = Row {
                level,
                tolerance,
                patches: Some(scene.surfaces.iter().map(|surface| surface.patches().len()).sum()),
                command: bench.command(&file, &options),
                ..Row::new("tessellation", scene_name, name(way.method))
            };
            section.rows.push(row.timed(timing).measured(&errors, stats.triangles));
            let point = (timing.ms, errors.max_error_px);
            match lines.iter_mut().find(|line| line.name == way.line()) {
                Some(line) => line.points.push(point),
                None => lines.push(Line { name: way.line().into(), points: vec![point] }),
            }
        }
        let title = format!("{scene_name}: largest error over time; the line across is 0.5 px");
        let svg = plot("milliseconds a frame", "largest error, pixels", &lines, Some(0.5))?;
        section.plots.push((title, svg));
    }
    section.findings = findings(&section.rows);
    Ok(section)
}

/// For each scene, the cost of an error of half a pixel: by tolerance, and by the thesis' best level.
fn findings(rows: &[Row]) -> Vec<String> {
    let rows: Vec<&Row> = rows.iter().collect();
    let cost = |row: &Row| {
        let (ms, triangles) = (row.ms.unwrap_or(f64::NAN), row.triangles.unwrap_or(0));
        format!("{ms:.1} ms ({triangles} triangles)")
    };
    let of_scene = |(scene, _): (&str, &str)| {
        let [ours, thesis] = half_a_pixel(&rows, scene);
        let ours = cost(ours?);
        Some(match thesis {
            Some(row) => format!(
                "{scene}: half a pixel costs {ours} by tolerance; the thesis needs level {}, {}, with \
                 normals up to {:.1}° off.",
                row.level.unwrap_or(0),
                cost(row),
                row.normal_error_deg.unwrap_or(f64::NAN),
            ),
            None => format!(
                "{scene}: half a pixel costs {ours} by tolerance; no level of the thesis that was measured \
                 reaches it."
            ),
        })
    };
    SCENES.into_iter().filter_map(of_scene).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_level_is_told_beside_the_tolerance() {
        let row = |method: &str, level, tolerance, ms, error| Row {
            level,
            tolerance,
            ms: Some(ms),
            max_error_px: Some(error),
            triangles: Some(7),
            ..Row::new("tessellation", "teapot", method)
        };
        let rows = [
            row("exact", None, Some(0.5), 3.0, 0.3),
            row("thesis", Some(16), None, 2.0, 0.7),
            row("thesis", Some(32), None, 5.0, 0.4),
        ];
        let text = &findings(&rows)[0];
        assert!(text.contains("3.0 ms (7") && text.contains("level 32, 5.0 ms"), "{text}");
        assert!(findings(&rows[..2])[0].contains("no level of the thesis"));
    }
}
