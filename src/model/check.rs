//! Checks of models. The reader calls them record by record, [`Model::check`] for a model that was made in code.

use glam::{DVec3, DVec4};

use super::write::{Short, shorts};
use super::{BoundedCurve, Curve, Edge, Face, FaceSurface, Frame, Model, NurbsCurve, Product};
use crate::bezier::{MAX_COORDINATE, check_control_point};
use crate::error::{Error, Result};

/// The maximum length of a word and of a name in bytes.
pub(super) const MAX_WORD: usize = 4096;

/// How far the length of a direction may be from 1, the product of two axes from 0, and the range of a curve beyond
/// its domain, as a share of the domain.
const EXACTNESS: f64 = 1e-9;

impl Model {
    /// Checks everything that the reader of the text format checks. A model that passes is read back as it was
    /// written.
    ///
    /// # Errors
    /// The first fault, with the number of its edge, face or product: numbers that are not finite or above 1e15,
    /// values outside the ranges that the types document, directions whose length is not 1 within 1e-9, axes that are
    /// not perpendicular within 1e-9, numbers of edges, faces and products that do not exist, names above 4,096 bytes;
    /// a model without faces or without products.
    pub fn check(&self) -> Result<()> {
        check_name(&self.name)?;
        check_unit(self.unit)?;
        for (number, edge) in self.edges.iter().enumerate() {
            edge.check().map_err(|error| error.within(format!("edge {number}")))?;
        }
        for (number, face) in self.faces.iter().enumerate() {
            face.check(self.edges.len()).map_err(|error| error.within(format!("face {number}")))?;
        }
        for (number, product) in self.products.iter().enumerate() {
            product
                .check(number, self.faces.len())
                .map_err(|error| error.within(format!("product {number}")))?;
        }
        self.check_counts()
    }

    /// Refuses a model that shows nothing.
    pub(super) fn check_counts(&self) -> Result<()> {
        for (name, count) in [("faces", self.faces.len()), ("products", self.products.len())] {
            if count == 0 {
                return Err(Error::invalid(format!("number of {name}"), 0, "at least 1"));
            }
        }
        Ok(())
    }
}

impl Edge {
    pub(super) fn check(&self) -> Result<()> {
        check_tolerance(self.tolerance)?;
        self.curve.as_ref().map_or(Ok(()), BoundedCurve::check)
    }
}

impl BoundedCurve {
    pub(super) fn check(&self) -> Result<()> {
        rising("range of the curve", self.range)?;
        match &self.curve {
            Curve::Line { origin, direction } => {
                point("origin of the line", *origin)?;
                unit("direction of the line", *direction)
            }
            Curve::Circle { frame, radius } => {
                frame.check("circle")?;
                at_most_a_turn("range of the circle", self.range)?;
                above_zero("radius of the circle", *radius)
            }
            Curve::Ellipse { frame, radii } => {
                frame.check("ellipse")?;
                at_most_a_turn("range of the ellipse", self.range)?;
                radii.iter().try_for_each(|radius| above_zero("radius of the ellipse", *radius))
            }
            Curve::Nurbs(curve) => {
                for (index, point) in curve.control_points().iter().enumerate() {
                    check_control_point(*point, index)?;
                }
                let [first, last] = curve.domain();
                let room = EXACTNESS * (last - first);
                if self.range[0] < first - room || self.range[1] > last + room {
                    let expected = format!("a part of its domain, {}", shorts(&[first, last]));
                    return Err(Error::invalid(
                        "range of the curve",
                        shorts(&self.range),
                        expected,
                    ));
                }
                Ok(())
            }
        }
    }
}

impl Face {
    /// Checks a face of a model that has so many `edges`.
    pub(super) fn check(&self, edges: usize) -> Result<()> {
        check_name(&self.name)?;
        check_tolerance(self.tolerance)?;
        check_color(self.color)?;
        self.check_bounds()?;
        self.surface.check()?;
        self.check_turns()?;
        for (number, coedges) in self.loops.iter().enumerate() {
            let check = || {
                check_loop(coedges.len())?;
                for coedge in coedges {
                    check_number("edge", coedge.edge, edges)?;
                    coedge.pcurve.as_ref().map_or(Ok(()), check_pcurve)?;
                }
                Ok(())
            };
            check().map_err(|error: Error| error.within(format!("loop {number}")))?;
        }
        Ok(())
    }

    pub(super) fn check_bounds(&self) -> Result<()> {
        let [low, high] = self.bounds;
        rising("u of the bounds", [low.x, high.x])?;
        rising("v of the bounds", [low.y, high.y])
    }

    /// Refuses bounds that go around an axis more than once.
    pub(super) fn check_turns(&self) -> Result<()> {
        let [low, high] = self.bounds;
        let (along_u, along_v) = match self.surface {
            FaceSurface::Cylinder { .. }
            | FaceSurface::Cone { .. }
            | FaceSurface::Sphere { .. }
            | FaceSurface::Revolution { .. } => (true, false),
            FaceSurface::Torus { .. } => (true, true),
            _ => (false, false),
        };
        if along_u {
            at_most_a_turn("u of the bounds", [low.x, high.x])?;
        }
        if along_v {
            at_most_a_turn("v of the bounds", [low.y, high.y])?;
        }
        Ok(())
    }
}

impl FaceSurface {
    pub(super) fn check(&self) -> Result<()> {
        match self {
            Self::Plane(frame) => frame.check("plane"),
            Self::Cylinder { frame, radius } => {
                frame.check("cylinder")?;
                above_zero("radius of the cylinder", *radius)
            }
            Self::Cone { frame, radius, half_angle } => {
                frame.check("cone")?;
                from_zero("radius of the cone", *radius)?;
                if half_angle.abs() < std::f64::consts::FRAC_PI_2 && *half_angle != 0.0 {
                    return Ok(());
                }
                let expected = "a number between −π/2 and π/2, not 0";
                Err(Error::invalid("half angle of the cone", Short(*half_angle), expected))
            }
            Self::Sphere { frame, radius } => {
                frame.check("sphere")?;
                above_zero("radius of the sphere", *radius)
            }
            Self::Torus { frame, major_radius, minor_radius } => {
                frame.check("torus")?;
                from_zero("major radius of the torus", *major_radius)?;
                above_zero("minor radius of the torus", *minor_radius)
            }
            Self::Revolution { origin, axis, curve } => {
                point("origin of the revolution", *origin)?;
                unit("axis of the revolution", *axis)?;
                curve.check()
            }
            Self::Extrusion { direction, curve } => {
                unit("direction of the extrusion", *direction)?;
                curve.check()
            }
            // Checked when it was made.
            Self::Nurbs(_) => Ok(()),
        }
    }
}

impl Frame {
    /// `of` names the curve or surface in errors.
    fn check(&self, of: &str) -> Result<()> {
        let Self { origin, x, y, z } = *self;
        point(&format!("origin of the {of}"), origin)?;
        for (name, axis) in [("x", x), ("y", y), ("z", z)] {
            unit(&format!("{name} axis of the {of}"), axis)?;
        }
        for (names, product) in
            [("x and y", x.dot(y)), ("y and z", y.dot(z)), ("z and x", z.dot(x))]
        {
            if product.abs() > EXACTNESS {
                let name = format!("product of the axes {names} of the {of}");
                return Err(Error::invalid(name, Short(product), "0 (perpendicular) within 1e-9"));
            }
        }
        Ok(())
    }
}

impl Product {
    /// Checks the product with a number in a model that has so many `faces`.
    pub(super) fn check(&self, number: usize, faces: usize) -> Result<()> {
        check_name(&self.name)?;
        check_color(self.color)?;
        self.check_faces(faces)?;
        for (index, used) in self.uses.iter().enumerate() {
            let check = || {
                check_number("product", used.product, number)?;
                check_color(used.color)?;
                used.check_placement()
            };
            check().map_err(|error| error.within(format!("use {index}")))?;
        }
        Ok(())
    }

    pub(super) fn check_faces(&self, faces: usize) -> Result<()> {
        let [first, count] = self.faces;
        if first.checked_add(count).is_some_and(|end| end <= faces) {
            return Ok(());
        }
        let expected = format!("a run of the {faces} faces before, which are numbered from 0");
        Err(Error::invalid("faces (first, count)", format!("{first} {count}"), expected))
    }
}

impl super::ProductUse {
    pub(super) fn check_placement(&self) -> Result<()> {
        let placement = self.placement;
        for (name, column) in [
            ("x axis of the placement", placement.matrix3.x_axis),
            ("y axis of the placement", placement.matrix3.y_axis),
            ("z axis of the placement", placement.matrix3.z_axis),
            ("translation of the placement", placement.translation),
        ] {
            point(name, column)?;
        }
        let determinant = placement.matrix3.determinant();
        if determinant == 0.0 {
            let expected = "another number: independent axes";
            return Err(Error::invalid("determinant of the placement", 0, expected));
        }
        Ok(())
    }
}

/// Refuses a range of angles that is longer than a circle, except by rounding.
fn at_most_a_turn(name: &str, [first, last]: [f64; 2]) -> Result<()> {
    const ROUNDING: f64 = 1e-6;
    if last - first <= std::f64::consts::TAU * (1.0 + ROUNDING) {
        return Ok(());
    }
    Err(Error::invalid(name, shorts(&[first, last]), "at most one turn, 2π"))
}

pub(super) fn check_name(name: &str) -> Result<()> {
    if name.len() <= MAX_WORD {
        return Ok(());
    }
    let length = format!("{} bytes", name.len());
    Err(Error::invalid("length of the name", length, format!("at most {MAX_WORD} bytes")))
}

pub(super) fn check_unit(metres: f64) -> Result<()> {
    above_zero("unit", metres)
}

pub(super) fn check_tolerance(tolerance: f64) -> Result<()> {
    from_zero("tolerance", tolerance)
}

pub(super) fn check_color(color: Option<[f32; 3]>) -> Result<()> {
    let is_outside = |value: &f32| !(0.0..=1.0).contains(value);
    match color.iter().flatten().find(|value| is_outside(value)) {
        None => Ok(()),
        Some(value) => Err(Error::invalid("color", value, "three numbers from 0 to 1")),
    }
}

pub(super) fn check_loop(coedges: usize) -> Result<()> {
    if coedges > 0 {
        return Ok(());
    }
    Err(Error::invalid("number of edges of the loop", coedges, "at least 1"))
}

/// Checks the number of an edge or product; `before` of them stand earlier in the file.
pub(super) fn check_number(what: &str, number: usize, before: usize) -> Result<()> {
    match before {
        _ if number < before => Ok(()),
        0 => Err(Error::invalid(what, number, format!("an earlier {what}, but there is none"))),
        _ => Err(Error::invalid(what, number, format!("an earlier {what}, 0 to {}", before - 1))),
    }
}

fn check_pcurve(curve: &NurbsCurve<DVec3>) -> Result<()> {
    for (index, point) in curve.control_points().iter().enumerate() {
        check_parameters(*point, index)?;
    }
    Ok(())
}

/// Checks a control point (u, v, weight).
pub(super) fn check_parameters(point: DVec3, index: usize) -> Result<()> {
    check_control_point(DVec4::new(point.x, point.y, 0.0, point.z), index)
}

/// Refuses a number that is not finite or too large.
pub(super) fn check_size(name: &str, value: f64) -> Result<()> {
    if value.abs() <= MAX_COORDINATE {
        return Ok(());
    }
    Err(Error::invalid(name, Short(value), "a finite number of at most 1e15"))
}

fn above_zero(name: &str, value: f64) -> Result<()> {
    if value > 0.0 {
        return check_size(name, value);
    }
    Err(Error::invalid(name, Short(value), "a number above 0"))
}

fn from_zero(name: &str, value: f64) -> Result<()> {
    if value >= 0.0 {
        return check_size(name, value);
    }
    Err(Error::invalid(name, Short(value), "a number of at least 0"))
}

fn rising(name: &str, [first, last]: [f64; 2]) -> Result<()> {
    check_size(name, first)?;
    check_size(name, last)?;
    if first < last {
        return Ok(());
    }
    Err(Error::invalid(name, shorts(&[first, last]), "two numbers, the first less than the last"))
}

fn point(name: &str, point: DVec3) -> Result<()> {
    point.to_array().into_iter().try_for_each(|value| check_size(name, value))
}

fn unit(name: &str, direction: DVec3) -> Result<()> {
    if (direction.length() - 1.0).abs() <= EXACTNESS {
        return Ok(());
    }
    let value = shorts(&direction.to_array());
    Err(Error::invalid(name, value, "a direction of length 1 within 1e-9"))
}
