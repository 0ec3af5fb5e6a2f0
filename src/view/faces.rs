//! Surfaces that the user clicks: the facts about a face of a CAD model, its outline, and which surfaces are hidden.

use freeform_surface::inspect::reference::Rays;
use freeform_surface::model::{DrawnFace, Repairs};
use freeform_surface::{Error, Result, Scene, Surface};
use glam::{DMat3, DMat4, DVec2, DVec3};

use super::pick::in_world;
use super::state::{Message, State};
use super::undo::Change;

/// The points of an outline for each segment of a loop, and for each side of a domain.
const PER_SEGMENT: usize = 8;
const PER_SIDE: usize = 32;

/// The surface that was clicked.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Picked {
    /// Its number in the scene.
    pub(crate) surface: usize,
    /// A line about it.
    pub(crate) facts: String,
    /// Where a face of a CAD model ends, in world space: closed lines.
    pub(crate) outline: Vec<Vec<DVec3>>,
}

impl State {
    /// Selects the surface at a place of the picture, or none if nothing is there.
    pub(super) fn pick_surface(&mut self, place: DVec2) {
        let (projection, size) = (self.projection(), self.size());
        let [near, far] = [-1.0, 1.0].map(|depth| in_world(&projection, size, place.extend(depth)));
        let hit = Rays::new(self.scene()).cast(near, far - near);
        self.select(hit.map(|hit| hit.surface));
        self.message = self.picked.as_ref().map(|picked| Message::Done(picked.facts.clone()));
    }

    /// Selects a surface as a click on it does.
    pub(crate) fn select(&mut self, surface: Option<usize>) {
        self.picked = surface.and_then(|surface| Picked::new(self.scene(), surface));
        if let Some(picked) = &self.picked {
            self.selected = picked.surface;
        }
    }

    /// Hides the surface that was clicked.
    ///
    /// # Errors
    /// None was clicked.
    pub(crate) fn hide(&mut self) -> Result<()> {
        let Some(picked) = self.picked.take() else {
            let expected = "a click on a face, which names it";
            return Err(Error::invalid("face to hide", "none", expected));
        };
        self.edit(vec![Change::Hidden(picked.surface, true)])
    }

    /// Shows all hidden surfaces again.
    ///
    /// # Errors
    /// None that are known.
    pub(crate) fn show_all(&mut self) -> Result<()> {
        let surfaces = self.scene().surfaces.iter().enumerate();
        let hidden = surfaces.filter(|(_, surface)| surface.hidden);
        let edits = hidden.map(|(number, _)| Change::Hidden(number, false)).collect();
        self.edit(edits)
    }

    /// The number of hidden surfaces.
    pub(crate) fn hidden_count(&self) -> usize {
        self.scene().surfaces.iter().filter(|surface| surface.hidden).count()
    }
}

/// Leaves out edits that the file of a CAD model could not hold: of its faces, only the colour and whether they are
/// hidden is saved.
///
/// # Errors
/// Nothing is left.
pub(super) fn without_shapes_of_faces(scene: &Scene, edits: Vec<Change>) -> Result<Vec<Change>> {
    let is_face =
        |surface: usize| scene.surfaces.get(surface).is_some_and(|surface| surface.face.is_some());
    let count = edits.len();
    let left: Vec<Change> = edits
        .into_iter()
        .filter(|edit| match edit {
            Change::Point(id, _) => !is_face(id.surface),
            Change::Trims(surface, _) => !is_face(*surface),
            Change::SurfacePaint(surface, paint) => {
                !is_face(*surface) || matches!(paint, freeform_surface::Paint::Color(_))
            }
            Change::MeshPaint(..) | Change::Hidden(..) => true,
        })
        .collect();
    if left.is_empty() && count > 0 {
        let expected = "another surface: a face of a CAD model only takes a colour";
        return Err(Error::invalid("surface", "a face of a CAD model", expected));
    }
    Ok(left)
}

impl Picked {
    fn new(scene: &Scene, number: usize) -> Option<Self> {
        let surface = scene.surfaces.get(number)?;
        let patches = match surface.patches().len() {
            1 => "1 patch".into(),
            count => format!("{count} patches"),
        };
        let degree = surface.degree();
        let net = format!("degrees {} × {}, {patches}", degree.u(), degree.v());
        let Some((face, nurbs)) = surface.face.zip(surface.nurbs()) else {
            let facts = format!("surface {number}: {net}");
            return Some(Self { surface: number, facts, outline: Vec::new() });
        };
        let of = scene.models.get(face.model)?;
        let known = of.model.faces.get(face.face)?;
        let mut title = format!("face {}", face.face);
        if !known.name.is_empty() {
            title += &format!(" {:?}", known.name);
        }
        if face.instance != face.face {
            title += &format!(" (in place {})", face.instance);
        }
        let drawn = DrawnFace {
            surface: nurbs.clone(),
            trims: surface.trims.clone(),
            edges: Vec::new(),
            periods: [None; 2],
            repairs: Repairs::default(),
        };
        // Products are placed with one scale for all directions; the scale of the scene is no part of the model.
        let scale = volume(&surface.transform) / volume(&of.transform);
        let area = four_digits(drawn.area() * scale.abs().powf(2.0 / 3.0));
        let (kind, unit) = (known.surface.kind(), of.model.unit_name());
        let facts = format!("{title}: {kind}, {net}, {area} {unit}²");
        Some(Self { surface: number, facts, outline: outline(surface) })
    }
}

/// By which factor a transform changes volumes.
fn volume(transform: &DMat4) -> f64 {
    DMat3::from_mat4(*transform).determinant()
}

/// A number with four significant digits.
fn four_digits(value: f64) -> String {
    let text = format!("{value:.3e}");
    let exponent = text.split('e').nth(1).and_then(|exponent| exponent.parse::<i32>().ok());
    match (exponent, text.parse::<f64>()) {
        (Some(exponent @ -3..=6), Ok(rounded)) => {
            format!("{rounded:.*}", usize::try_from(3 - exponent).unwrap_or(0))
        }
        _ => text,
    }
}

/// Where the loops of a surface's trims run in world space, or else the border of its domain.
fn outline(surface: &Surface) -> Vec<Vec<DVec3>> {
    let [low, high] = surface.domain();
    let Some(nurbs) = surface.nurbs() else { return Vec::new() };
    let world = |uv: DVec2| {
        let uv = uv.clamp(low, high);
        surface.transform.transform_point3(nurbs.at(uv.x, uv.y).position)
    };
    let share = |i: usize, count: usize| i as f64 / count as f64;
    if !surface.trims.has_loops() {
        let corners = [low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)];
        let side = |i: usize| {
            let (from, to) = (corners[i], corners[(i + 1) % 4]);
            (0..PER_SIDE).map(move |step| from.lerp(to, share(step, PER_SIDE)))
        };
        return vec![(0..4).flat_map(side).map(world).collect()];
    }
    let loops = surface.trims.all_loops();
    loops
        .map(|one| {
            let segments = one.segments().iter();
            let points = segments.flat_map(|segment| {
                (0..PER_SEGMENT).map(move |step| segment.point(share(step, PER_SEGMENT)))
            });
            points.map(world).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests;
