//! `freeform report`: measures speed against error of every method on this machine.

mod advice;
#[cfg(test)]
mod answers;
mod bench;
mod models;
mod page;
mod peers;
mod plot;
mod row;
mod scaling;
mod shading;
mod stability;
mod summary;
mod tessellation;
mod triangles;
mod trimming;

use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::io::{Error, Result};
use clap::ValueEnum;
use freeform_surface::inspect::programs::Sources;
use freeform_surface::{Backend, Cause, Headless, Image};
use indicatif::{ProgressBar, ProgressStyle};

use super::ReportArguments;
use crate::io::output::replace;
use crate::io::say;
use bench::{Bench, check_resources};
use page::{Head, page};
use row::Row;

/// The sections, which can be measured separately.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Topic {
    /// Levels and tolerances.
    Tessellation,
    /// Trims by both methods.
    Trimming,
    /// Smoothed meshes.
    Triangles,
    /// Growth with size.
    Scaling,
    /// The hard cases.
    Stability,
    /// Other tessellators.
    Peers,
    /// CAD models.
    Models,
    /// Zebra on surfaces and meshes.
    Shading,
}

impl Topic {
    fn measure(self, bench: &mut Bench) -> Result<Section> {
        match self {
            Self::Tessellation => tessellation::section(bench),
            Self::Trimming => trimming::section(bench),
            Self::Triangles => triangles::section(bench),
            Self::Scaling => scaling::section(bench),
            Self::Stability => stability::section(bench),
            Self::Peers => peers::section(bench),
            Self::Models => models::section(bench),
            Self::Shading => shading::section(bench),
        }
    }
}

/// The output of the report.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum ReportFormat {
    /// A page, with the data in files beside it.
    Html,
    /// The data alone, on standard output.
    Json,
}

/// A picture with its caption.
#[derive(Debug)]
struct Figure {
    caption: String,
    image: Image,
}

/// One section of the report.
#[derive(Debug)]
struct Section {
    name: &'static str,
    title: &'static str,
    meaning: &'static str,
    /// Conclusions from the rows, in sentences.
    findings: Vec<String>,
    /// The title and the SVG text of each plot.
    plots: Vec<(String, String)>,
    figures: Vec<Figure>,
    rows: Vec<Row>,
}

impl Section {
    const fn new(name: &'static str, title: &'static str, meaning: &'static str) -> Self {
        Self {
            name,
            title,
            meaning,
            findings: Vec::new(),
            plots: Vec::new(),
            figures: Vec::new(),
            rows: Vec::new(),
        }
    }
}

/// Measures the requested sections and writes the report.
///
/// # Errors
/// There is no context or no folder of scenes, a scene cannot be drawn, or a file cannot be written.
pub(super) fn run(arguments: &ReportArguments) -> Result<()> {
    check_resources(&arguments.resources)?;
    let topics: Vec<Topic> = if arguments.only.is_empty() {
        Topic::value_variants().to_vec()
    } else {
        arguments.only.clone()
    };
    let bar = ProgressBar::no_length();
    let template = "{prefix} {bar:20} {pos}/{len} {elapsed} {msg}";
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style);
    }
    let context = Headless::new(arguments.backend)?;
    let mut bench = Bench::new(
        context,
        Sources::default(),
        arguments.resources.clone(),
        arguments.quick,
        bar.clone(),
    )?;
    bench.models.clone_from(&arguments.models);
    let mut sections = Vec::with_capacity(topics.len());
    for (number, topic) in topics.iter().enumerate() {
        bar.set_prefix(format!("section {} of {}", number + 1, topics.len()));
        sections.push(topic.measure(&mut bench)?);
        bench.check_driver()?;
    }
    bar.finish_and_clear();
    let rows: Vec<&Row> = sections.iter().flat_map(|section| &section.rows).collect();
    let json = serde_json::to_string_pretty(&rows).expect("strings and numbers");
    if arguments.format == ReportFormat::Json {
        return say(json);
    }
    let head = Head {
        version: env!("CARGO_PKG_VERSION").into(),
        driver: bench.driver(),
        machine: machine(),
        clock: bench.clock(),
        size: bench.size,
        summary: advice::advice(&rows),
        command: command(arguments),
    };
    let folder = &arguments.out;
    std::fs::create_dir_all(folder)
        .map_err(|error| unwritable("make the folder", folder, error))?;
    write(&folder.join("report.json"), json.as_bytes())?;
    for section in &sections {
        write(&folder.join(format!("{}.csv", section.name)), &csv(&section.rows)?)?;
    }
    write(&folder.join("summary.md"), summary::summary(&head, &rows).as_bytes())?;
    if let Some((_, svg)) = sections.iter().flat_map(|section| &section.plots).next() {
        write(&folder.join("summary.svg"), svg.as_bytes())?;
    }
    let index = folder.join("index.html");
    write(&index, page(&head, &sections)?.as_bytes())?;
    for line in &head.summary {
        say(line)?;
    }
    say(format_args!("wrote {}", index.display()))
}

/// The command line that reproduces this report.
fn command(arguments: &ReportArguments) -> String {
    let mut command = format!("freeform report --out {}", arguments.out.display());
    if arguments.quick {
        command.push_str(" --quick");
    }
    if arguments.backend != Backend::default() {
        command.push_str(&format!(" --backend {}", arguments.backend));
    }
    if arguments.resources != default_resources() {
        command.push_str(&format!(" --resources {}", arguments.resources.display()));
    }
    for model in &arguments.models {
        command.push_str(&format!(" --model {}", model.display()));
    }
    for topic in &arguments.only {
        let name = topic.to_possible_value();
        command.push_str(" --only ");
        command.push_str(name.as_ref().map_or("", |name| name.get_name()));
    }
    command
}

/// The processor and the number of cores that the program can use.
fn machine() -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_owned())
    });
    let system = std::env::consts::OS;
    format!("{} with {cores} cores, {system}", model.unwrap_or_else(|| "a processor".into()))
}

fn csv(rows: &[Row]) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).map_err(|error| unwritable("make", Path::new("a table"), error))?;
    }
    writer
        .into_inner()
        .map_err(|error| unwritable("make", Path::new("a table"), error.into_error()))
}

fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    replace(path, |file| file.write_all(bytes)).map_err(|error| unwritable("write", path, error))
}

fn unwritable(action: &'static str, path: &Path, error: impl Into<Cause>) -> Error {
    Error::file(action, path, error)
}

/// The project's folder of scenes: in the current folder, or where the program was built.
pub(super) fn default_resources() -> PathBuf {
    let here = PathBuf::from("resources");
    if here.is_dir() { here } else { Path::new(env!("CARGO_MANIFEST_DIR")).join("resources") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_a_table_with_all_columns() {
        let row = Row { level: Some(8), ..Row::new("tessellation", "a, b", "exact") };
        let text = String::from_utf8(csv(&[row]).unwrap()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("section,scene,method,level,tolerance,iterations,epsilon,"));
        assert!(lines[1].starts_with("tessellation,\"a, b\",exact,8,,,"));
    }
}
