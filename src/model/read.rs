//! Reads models in the text format, in one pass over the file.

mod words;

use std::io::BufRead;
use std::path::Path;

use glam::{DAffine3, DMat3, DVec2, DVec3, DVec4};

use super::check::{
    check_color, check_loop, check_number, check_parameters, check_size, check_tolerance,
    check_unit,
};
use super::{
    BoundedCurve, Coedge, Curve, Edge, Face, FaceSurface, Frame, Model, NurbsCurve, Product,
    ProductUse,
};
use crate::bezier::{Degree, NurbsSurface, check_control_point, check_knots};
use crate::error::{Error, Result};
use words::Words;

/// The length of a unit in metres, if a file does not say it.
const MILLIMETRE: f64 = 0.001;

/// The description of a number in errors.
const NUMBER: &str = "a finite number of at most 1e15";
const WHOLE: &str = "a whole number from 0";

impl Model {
    /// Whether a text begins as a model does, perhaps after comments.
    pub(crate) fn is_text_of_one(text: &str) -> bool {
        let lines = text.lines().map(str::trim);
        let mut told = lines.filter(|line| !line.is_empty() && !line.starts_with('#'));
        told.next().is_some_and(|line| line.starts_with("freeform-model"))
    }

    /// Reads a model from a text; `path` names it in errors.
    ///
    /// # Errors
    /// As [`Model::read`].
    pub fn from_text(text: &str, path: &Path) -> Result<Self> {
        Self::read(text.as_bytes(), path)
    }

    /// Reads a model in one pass; `path` names it in errors. The time grows in proportion to the text, and the memory
    /// stays below 20 times the part of the text that was read.
    ///
    /// # Errors
    /// A text that the grammar does not describe, with its line; values that [`Model::check`] refuses; a version other
    /// than 1; a word above 4,096 bytes; errors of `text`.
    pub fn read(text: impl BufRead, path: &Path) -> Result<Self> {
        let model = Self {
            name: String::new(),
            unit: MILLIMETRE,
            edges: Vec::new(),
            faces: Vec::new(),
            products: Vec::new(),
        };
        let mut reader = Reader { words: Words::new(text, path), model };
        reader.header()?;
        reader.records()?;
        Ok(reader.model)
    }
}

struct Reader<'a, R> {
    words: Words<'a, R>,
    /// What was read so far.
    model: Model,
}

impl<R: BufRead> Reader<'_, R> {
    fn header(&mut self) -> Result<()> {
        // Some editors begin a text with a byte order mark, perhaps before a comment or white space.
        if !self.words.accept("\u{feff}freeform-model")? {
            self.words.accept("\u{feff}")?;
            self.words.expect("freeform-model")?;
        }
        if !self.words.accept("1")? {
            return Err(self.words.unexpected("version 1 of the format"));
        }
        self.model.name = self.name()?;
        if self.words.accept("unit")? {
            self.model.unit = self.number("unit")?;
            self.checked(check_unit(self.model.unit))?;
        }
        Ok(())
    }

    fn records(&mut self) -> Result<()> {
        loop {
            self.words.place = None;
            if self.words.accept("edge")? {
                self.words.place = Some(("edge", self.model.edges.len()));
                let edge = self.edge()?;
                push(&mut self.model.edges, usize::MAX, edge);
            } else if self.words.accept("face")? {
                self.words.place = Some(("face", self.model.faces.len()));
                let face = self.face()?;
                push(&mut self.model.faces, usize::MAX, face);
            } else if self.words.accept("product")? {
                self.words.place = Some(("product", self.model.products.len()));
                let product = self.product()?;
                push(&mut self.model.products, usize::MAX, product);
            } else if self.words.accept("end")? {
                self.checked(self.model.check_counts())?;
                return self.words.expect_end();
            } else {
                return Err(self.words.unexpected("edge, face, product or end"));
            }
        }
    }

    fn edge(&mut self) -> Result<Edge> {
        let tolerance = self.tolerance()?;
        if self.words.accept("point")? {
            return Ok(Edge { tolerance, curve: None });
        }
        if !self.words.is("range")? {
            return Err(self.words.unexpected("point or range"));
        }
        Ok(Edge { tolerance, curve: Some(self.curve()?) })
    }

    fn curve(&mut self) -> Result<BoundedCurve> {
        self.words.expect("range")?;
        let range = [
            self.number("first parameter of the curve")?,
            self.number("last parameter of the curve")?,
        ];
        let curve = if self.words.accept("line")? {
            let origin = self.vector("origin of the line")?;
            Curve::Line { origin, direction: self.vector("direction of the line")? }
        } else if self.words.accept("circle")? {
            Curve::Circle { frame: self.frame()?, radius: self.number("radius of the circle")? }
        } else if self.words.accept("ellipse")? {
            let frame = self.frame()?;
            let radii = [
                self.number("first radius of the ellipse")?,
                self.number("second radius of the ellipse")?,
            ];
            Curve::Ellipse { frame, radii }
        } else if self.words.accept("nurbs")? {
            Curve::Nurbs(self.nurbs_curve(|values, index| {
                let point = DVec4::from_array(values);
                check_control_point(point, index).map(|()| point)
            })?)
        } else {
            return Err(self.words.unexpected("line, circle, ellipse or nurbs"));
        };
        let curve = BoundedCurve { curve, range };
        self.checked(curve.check())?;
        Ok(curve)
    }

    /// A curve from its degree on. `point` makes and checks a control point, whose index it gets.
    fn nurbs_curve<P, const N: usize>(
        &mut self,
        point: impl Fn([f64; N], usize) -> Result<P>,
    ) -> Result<NurbsCurve<P>> {
        self.words.expect("degree")?;
        let degree = self.whole("degree")?;
        let knots = self.knots()?;
        let points = self.points_of(degree, &knots)?;
        self.words.expect("points")?;
        let announced = self.whole("number of control points")?;
        if announced != points {
            let expected = format!("{points}, the number of knots - degree - 1");
            return self.checked(Err(Error::invalid(
                "number of control points",
                announced,
                expected,
            )));
        }
        let points = self.points(announced, point)?;
        self.checked(NurbsCurve::new(degree, knots, points))
    }

    fn knots(&mut self) -> Result<Vec<f64>> {
        self.words.expect("knots")?;
        let count = self.whole("number of knots")?;
        let mut knots = Vec::new();
        for index in 0..count {
            let knot = self.number_of(format_args!("knot {index}"))?;
            push(&mut knots, count, knot);
        }
        Ok(knots)
    }

    /// The number of control points along knots that have just been read.
    fn points_of(&self, degree: usize, knots: &[f64]) -> Result<usize> {
        let points = knots.len().saturating_sub(degree.saturating_add(1));
        self.checked(check_knots(degree, knots, points))?;
        Ok(points)
    }

    fn points<P, const N: usize>(
        &mut self,
        count: usize,
        point: impl Fn([f64; N], usize) -> Result<P>,
    ) -> Result<Vec<P>> {
        let mut points = Vec::new();
        for index in 0..count {
            let mut values = [0.0; N];
            for value in &mut values {
                *value = self.number_of(format_args!("control point {index}"))?;
            }
            let point = self.checked(point(values, index))?;
            push(&mut points, count, point);
        }
        Ok(points)
    }

    fn frame(&mut self) -> Result<Frame> {
        self.words.expect("origin")?;
        let origin = self.vector("origin")?;
        self.words.expect("x")?;
        let x = self.vector("x axis")?;
        self.words.expect("y")?;
        let y = self.vector("y axis")?;
        self.words.expect("z")?;
        Ok(Frame { origin, x, y, z: self.vector("z axis")? })
    }

    fn face(&mut self) -> Result<Face> {
        let name = self.name()?;
        let tolerance = self.tolerance()?;
        let color = self.color()?;
        let reversed = self.words.accept("reversed")?;
        if !reversed && !self.words.accept("forward")? {
            return Err(self.words.unexpected("forward or reversed"));
        }
        self.words.expect("bounds")?;
        let [low_u, high_u, low_v, high_v] = self.numbers("number of the bounds")?;
        let bounds = [DVec2::new(low_u, low_v), DVec2::new(high_u, high_v)];
        // The surface comes after the bounds, so they are checked first.
        let mut face = Face {
            name,
            tolerance,
            color,
            reversed,
            surface: FaceSurface::Plane(Frame::WORLD),
            bounds,
            loops: Vec::new(),
        };
        self.checked(face.check_bounds())?;
        face.surface = self.surface()?;
        self.checked(face.surface.check())?;
        self.checked(face.check_turns())?;
        while self.words.accept("loop")? {
            let coedges = self.coedges()?;
            push(&mut face.loops, usize::MAX, coedges);
        }
        Ok(face)
    }

    fn surface(&mut self) -> Result<FaceSurface> {
        let words = &mut self.words;
        Ok(if words.accept("plane")? {
            FaceSurface::Plane(self.frame()?)
        } else if words.accept("cylinder")? {
            let frame = self.frame()?;
            FaceSurface::Cylinder { frame, radius: self.number("radius of the cylinder")? }
        } else if words.accept("cone")? {
            let frame = self.frame()?;
            let radius = self.number("radius of the cone")?;
            FaceSurface::Cone { frame, radius, half_angle: self.number("half angle of the cone")? }
        } else if words.accept("sphere")? {
            let frame = self.frame()?;
            FaceSurface::Sphere { frame, radius: self.number("radius of the sphere")? }
        } else if words.accept("torus")? {
            let frame = self.frame()?;
            let major_radius = self.number("major radius of the torus")?;
            let minor_radius = self.number("minor radius of the torus")?;
            FaceSurface::Torus { frame, major_radius, minor_radius }
        } else if words.accept("revolution")? {
            self.words.expect("origin")?;
            let origin = self.vector("origin of the revolution")?;
            self.words.expect("axis")?;
            let axis = self.vector("axis of the revolution")?;
            FaceSurface::Revolution { origin, axis, curve: self.curve()? }
        } else if words.accept("extrusion")? {
            self.words.expect("direction")?;
            let direction = self.vector("direction of the extrusion")?;
            FaceSurface::Extrusion { direction, curve: self.curve()? }
        } else if words.accept("nurbs")? {
            FaceSurface::Nurbs(self.nurbs_surface()?)
        } else {
            return Err(words.unexpected(
                "plane, cylinder, cone, sphere, torus, revolution, extrusion or nurbs",
            ));
        })
    }

    fn nurbs_surface(&mut self) -> Result<NurbsSurface> {
        self.words.expect("degree")?;
        let (u, v) = (self.whole("degree along u")?, self.whole("degree along v")?);
        let degree = self.checked(Degree::new(u, v))?;
        let knots_u = self.knots()?;
        let columns = self.points_of(u, &knots_u)?;
        let knots_v = self.knots()?;
        let rows = self.points_of(v, &knots_v)?;
        self.words.expect("points")?;
        for (name, expected) in [("columns", columns), ("rows", rows)] {
            let found = self.whole(name)?;
            if found != expected {
                let expected = format!("{expected}, the number of knots - degree - 1");
                let name = format!("number of {name} of control points");
                return self.checked(Err(Error::invalid(name, found, expected)));
            }
        }
        let points = self.points(columns.saturating_mul(rows), |values, index| {
            let point = DVec4::from_array(values);
            check_control_point(point, index).map(|()| point)
        })?;
        self.checked(NurbsSurface::new(degree, [knots_u, knots_v], points))
    }

    fn coedges(&mut self) -> Result<Vec<Coedge>> {
        let count = self.whole("number of edges of the loop")?;
        self.checked(check_loop(count))?;
        let mut coedges = Vec::new();
        for _ in 0..count {
            let forward = self.words.accept("+")?;
            if !forward && !self.words.accept("-")? {
                let expected = format!("+ or - before edge {} of {count}", coedges.len());
                return Err(self.words.unexpected(expected));
            }
            let edge = self.whole("edge")?;
            self.checked(check_number("edge", edge, self.model.edges.len()))?;
            let pcurve = if self.words.accept("pcurve")? {
                Some(self.nurbs_curve(|values, index| {
                    let point = DVec3::from_array(values);
                    check_parameters(point, index).map(|()| point)
                })?)
            } else {
                None
            };
            push(&mut coedges, count, Coedge { edge, forward, pcurve });
        }
        Ok(coedges)
    }

    fn product(&mut self) -> Result<Product> {
        let name = self.name()?;
        let color = self.color()?;
        self.words.expect("faces")?;
        let faces = [self.whole("first face")?, self.whole("number of faces")?];
        let mut product = Product { name, color, faces, uses: Vec::new() };
        self.checked(product.check_faces(self.model.faces.len()))?;
        while self.words.accept("use")? {
            let used = self.product_use()?;
            push(&mut product.uses, usize::MAX, used);
        }
        Ok(product)
    }

    fn product_use(&mut self) -> Result<ProductUse> {
        let product = self.whole("product")?;
        self.checked(check_number("product", product, self.model.products.len()))?;
        let color = self.color()?;
        self.words.expect("columns")?;
        let x_axis = self.vector("x axis of the placement")?;
        let y_axis = self.vector("y axis of the placement")?;
        let z_axis = self.vector("z axis of the placement")?;
        let translation = self.vector("translation of the placement")?;
        let matrix3 = DMat3 { x_axis, y_axis, z_axis };
        let used = ProductUse { product, placement: DAffine3 { matrix3, translation }, color };
        self.checked(used.check_placement())?;
        Ok(used)
    }

    /// A name; empty if there is none.
    fn name(&mut self) -> Result<String> {
        if self.words.accept("name")? { self.words.text("name") } else { Ok(String::new()) }
    }

    fn tolerance(&mut self) -> Result<f64> {
        self.words.expect("tolerance")?;
        let tolerance = self.number("tolerance")?;
        self.checked(check_tolerance(tolerance))?;
        Ok(tolerance)
    }

    fn color(&mut self) -> Result<Option<[f32; 3]>> {
        if !self.words.accept("color")? {
            return Ok(None);
        }
        let mut color = [0.0; 3];
        for value in &mut color {
            *value = self.words.parse("color", "three numbers from 0 to 1")?;
        }
        self.checked(check_color(Some(color)))?;
        Ok(Some(color))
    }

    fn vector(&mut self, name: &str) -> Result<DVec3> {
        Ok(DVec3::from_array(self.numbers(name)?))
    }

    fn numbers<const N: usize>(&mut self, name: &str) -> Result<[f64; N]> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.number(name)?;
        }
        Ok(values)
    }

    fn number(&mut self, name: &str) -> Result<f64> {
        self.number_of(format_args!("{name}"))
    }

    /// A number with a name that is only formatted for an error.
    fn number_of(&mut self, name: std::fmt::Arguments<'_>) -> Result<f64> {
        let value = self.words.parse(name, NUMBER)?;
        if check_size("", value).is_err() {
            self.checked(check_size(&name.to_string(), value))?;
        }
        Ok(value)
    }

    fn whole(&mut self, name: &str) -> Result<usize> {
        self.words.parse(name, WHOLE)
    }

    /// The error of a check with the place in the file.
    fn checked<T>(&self, result: Result<T>) -> Result<T> {
        result.map_err(|error| self.words.fault(&error))
    }
}

/// Appends to a list of at most `announced` values. The list grows by a half at a time, whatever was announced, so that
/// it takes memory only for what is in the file.
fn push<T>(list: &mut Vec<T>, announced: usize, value: T) {
    if list.len() == list.capacity() {
        list.reserve_exact((list.len() / 2).max(1).min(announced - list.len()));
    }
    list.push(value);
}
