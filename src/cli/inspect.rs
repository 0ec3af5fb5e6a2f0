//! `freeform inspect`: how the faces of a CAD model meet along their edges, as a table or as JSON.

use std::cmp::Ordering;

use freeform_surface::model::{
    Continuity, EdgeContinuity, GAP, Model, RELATIVE_JUMP, SMOOTH_DEGREES, Worst,
};
use serde_json::{Map, Value, json};

use super::{InspectArguments, InspectFormat};
use crate::io::{Result, say};

/// Without --all, the table has no more edges than this.
const MOST: usize = 20;

/// Reads the model and prints how its faces meet.
///
/// # Errors
/// The model cannot be read.
pub(super) fn run(arguments: &InspectArguments) -> Result<()> {
    let model = Model::load(&arguments.file, &arguments.load.options())?;
    let edges = model.continuity()?;
    match arguments.format {
        InspectFormat::Table => table(&model, edges, arguments.all),
        InspectFormat::Json => {
            let text = serde_json::to_string_pretty(&object(&model, &edges));
            say(text.expect("strings and numbers"))
        }
    }
}

/// How many edges each class has.
fn count(edges: &[EdgeContinuity], class: Continuity) -> usize {
    edges.iter().filter(|edge| edge.class == class).count()
}

/// The edge with the largest of some values.
fn worst(
    edges: &[EdgeContinuity],
    of: impl Fn(&EdgeContinuity) -> Option<Worst>,
) -> Option<(&EdgeContinuity, Worst)> {
    let values = edges.iter().filter_map(|edge| Some((edge, of(edge)?)));
    values.max_by(|a, b| a.1.value.total_cmp(&b.1.value))
}

/// Prints a line of totals, what is worst, and the worst edges.
fn table(model: &Model, mut edges: Vec<EdgeContinuity>, all: bool) -> Result<()> {
    let unit = model.unit_name();
    let classes = Continuity::ALL
        .iter()
        .rev()
        .map(|class| format!("{} {}", class.name(), count(&edges, *class)));
    let classes = classes.collect::<Vec<_>>().join(", ");
    let at = |name: &str, unit: &str, found: Option<(&EdgeContinuity, Worst)>| {
        found.map_or_else(String::new, |(edge, worst)| {
            let value = digits(Some(worst));
            let faces = join(&edge.faces);
            format!("; largest {name} {value}{unit} at edge {} (faces {faces})", edge.edge)
        })
    };
    let gap = at("gap", &format!(" {unit}"), worst(&edges, |edge| edge.gap));
    let angle = at("angle", "°", worst(&edges, |edge| edge.angle));
    say(format_args!("{} edges: {classes}{gap}{angle}", edges.len()))?;
    let diagonal = model.diagonal();
    say(format_args!(
        "gap: above {:.2e} {unit}; G1: angle at most {SMOOTH_DEGREES}°; G2: jump of curvature at most {}%",
        GAP * diagonal,
        100.0 * RELATIVE_JUMP,
    ))?;
    if edges.is_empty() {
        return Ok(());
    }
    edges.sort_by(worse_first);
    let shown = if all { edges.len() } else { edges.len().min(MOST) };
    say(format_args!(
        "\n{:>7} {:12} {:>13} {:>10} {:>10} {:>10} {:>10} {:>7}  at (x, y, z)",
        "edge",
        "class",
        "faces",
        format!("gap/{unit}"),
        format!("off/{unit}"),
        "angle/°",
        format!("jump·{unit}"),
        "jump/%",
    ))?;
    for edge in &edges[..shown] {
        let percent = edge.relative_jump.map(|jump| Worst { value: 100.0 * jump.value, ..jump });
        let point = key(edge).point;
        say(format_args!(
            "{:>7} {:12} {:>13} {:>10} {:>10} {:>10} {:>10} {:>7}  {:.6} {:.6} {:.6}",
            edge.edge,
            edge.class.name(),
            join(&edge.faces),
            digits(edge.gap),
            digits(Some(edge.off_edge)),
            digits(edge.angle),
            digits(edge.curvature),
            digits(percent),
            point.x,
            point.y,
            point.z,
        ))?;
    }
    if shown < edges.len() {
        say(format_args!("{} more edges; --all lists them", edges.len() - shown))?;
    }
    Ok(())
}

/// The value that decides about the order of edges within a class.
fn key(edge: &EdgeContinuity) -> Worst {
    let value = match edge.class {
        Continuity::Gap | Continuity::NonManifold => edge.gap,
        Continuity::Open => None,
        Continuity::G0 => edge.angle,
        Continuity::G1 | Continuity::G2 => edge.curvature,
    };
    value.unwrap_or(edge.off_edge)
}

fn worse_first(a: &EdgeContinuity, b: &EdgeContinuity) -> Ordering {
    a.class.cmp(&b.class).then(key(b).value.total_cmp(&key(a).value))
}

fn join(faces: &[usize]) -> String {
    faces.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")
}

/// Three digits of a value.
fn digits(worst: Option<Worst>) -> String {
    match worst.map(|worst| worst.value) {
        None => "–".into(),
        Some(0.0) => "0".into(),
        Some(value) if (0.001..1e5).contains(&value) => {
            let before = value.log10().floor() as i32 + 1;
            format!("{value:.*}", (3 - before).max(0) as usize)
        }
        Some(value) => format!("{value:.1e}"),
    }
}

/// The JSON that `docs/continuity.md` describes.
fn object(model: &Model, edges: &[EdgeContinuity]) -> Value {
    let classes: Map<String, Value> = Continuity::ALL
        .iter()
        .map(|class| (class.name().to_owned(), count(edges, *class).into()))
        .collect();
    let at = |worst: Option<Worst>| {
        worst.map(|Worst { value, point }| json!({ "value": value, "point": point.to_array() }))
    };
    let of_edge = |edge: &EdgeContinuity| {
        json!({
            "edge": edge.edge,
            "class": edge.class.name(),
            "faces": edge.faces,
            "gap": at(edge.gap),
            "off_edge": at(Some(edge.off_edge)),
            "angle_degrees": at(edge.angle),
            "curvature_jump": at(edge.curvature),
            "relative_curvature_jump": at(edge.relative_jump),
        })
    };
    let diagonal = model.diagonal();
    json!({
        "model": model.name,
        "unit_metres": model.unit,
        "diagonal": diagonal,
        "limits": {
            "gap": GAP * diagonal,
            "angle_degrees": SMOOTH_DEGREES,
            "relative_curvature_jump": RELATIVE_JUMP,
        },
        "classes": classes,
        "edges": edges.iter().map(of_edge).collect::<Vec<_>>(),
    })
}
