//! Writes models in the text format.

use std::fmt::{self, Display, Formatter, Write as _};
use std::io;

use glam::DVec3;

use super::{
    BoundedCurve, Coedge, Curve, Edge, Face, FaceSurface, Frame, Model, NurbsCurve, Product,
    ProductUse,
};

/// Lines break before words that would reach beyond this column.
const WIDTH: usize = 120;

impl Model {
    /// Writes the model in the text format: first all edges, then all faces, then all products. Every number has the
    /// fewest characters that give the same number again. A model that [`Model::check`] refuses is written, but cannot
    /// be read.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: &mut impl io::Write) -> io::Result<()> {
        let mut lines = Lines { out, line: String::new(), indent: 0 };
        lines.begin(0)?;
        lines.words("freeform-model 1")?;
        if !self.name.is_empty() {
            lines.begin(0)?;
            lines.name(&self.name)?;
        }
        lines.begin(0)?;
        lines.words(format_args!("unit {}", Short(self.unit)))?;
        self.edges.iter().try_for_each(|edge| lines.edge(edge))?;
        self.faces.iter().try_for_each(|face| lines.face(face))?;
        self.products.iter().try_for_each(|product| lines.product(product))?;
        lines.begin(0)?;
        lines.words("end")?;
        lines.begin(0)
    }
}

/// A number in the fewest characters that give the same number again.
#[derive(Debug, Clone, Copy)]
pub(super) struct Short<T>(pub(super) T);

impl<T: Display + fmt::LowerExp> Display for Short<T> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        /// Counts what is written.
        struct Length(usize);
        impl fmt::Write for Length {
            fn write_str(&mut self, text: &str) -> fmt::Result {
                self.0 += text.len();
                Ok(())
            }
        }
        let (mut plain, mut exponent) = (Length(0), Length(0));
        write!(plain, "{}", self.0)?;
        write!(exponent, "{:e}", self.0)?;
        if plain.0 <= exponent.0 { write!(f, "{}", self.0) } else { write!(f, "{:e}", self.0) }
    }
}

/// Numbers with spaces between them.
pub(super) fn shorts(numbers: &[f64]) -> String {
    let mut text = String::new();
    for (i, number) in numbers.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{}{}", if i > 0 { " " } else { "" }, Short(*number));
    }
    text
}

/// Lines of limited width.
struct Lines<'a, W> {
    out: &'a mut W,
    /// The current line.
    line: String,
    /// The spaces before it; a line that continues it has two more.
    indent: usize,
}

impl<W: io::Write> Lines<'_, W> {
    /// Ends the current line and begins the next.
    fn begin(&mut self, indent: usize) -> io::Result<()> {
        self.next_line()?;
        self.indent = indent;
        Ok(())
    }

    fn next_line(&mut self) -> io::Result<()> {
        if !self.line.is_empty() {
            self.line.push('\n');
            self.out.write_all(self.line.as_bytes())?;
            self.line.clear();
        }
        Ok(())
    }

    /// Appends words that stay on one line.
    fn words(&mut self, words: impl Display) -> io::Result<()> {
        let start = self.line.len();
        let (separator, spaces) = if start == 0 { ("", self.indent) } else { (" ", 0) };
        let _ = write!(self.line, "{separator}{:spaces$}{words}", "");
        if self.line.len() <= WIDTH || start == 0 {
            return Ok(());
        }
        let moved = self.line.split_off(start);
        self.next_line()?;
        let spaces = self.indent + 2;
        let _ = write!(self.line, "{:spaces$}{}", "", &moved[1..]);
        Ok(())
    }

    fn name(&mut self, name: &str) -> io::Result<()> {
        if name.is_empty() {
            return Ok(());
        }
        let text = name.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
        self.words(format_args!("name \"{text}\""))
    }

    fn color(&mut self, color: Option<[f32; 3]>) -> io::Result<()> {
        match color {
            None => Ok(()),
            Some(color) => {
                let [red, green, blue] = color.map(Short);
                self.words(format_args!("color {red} {green} {blue}"))
            }
        }
    }

    /// Words with a vector after them.
    fn vector(&mut self, words: &str, vector: DVec3) -> io::Result<()> {
        let space = if words.is_empty() { "" } else { " " };
        self.words(format_args!("{words}{space}{}", shorts(&vector.to_array())))
    }

    fn edge(&mut self, edge: &Edge) -> io::Result<()> {
        self.begin(0)?;
        self.words(format_args!("edge tolerance {}", Short(edge.tolerance)))?;
        match &edge.curve {
            None => self.words("point"),
            Some(curve) => self.curve(curve),
        }
    }

    fn curve(&mut self, curve: &BoundedCurve) -> io::Result<()> {
        self.words(format_args!("range {}", shorts(&curve.range)))?;
        match &curve.curve {
            Curve::Line { origin, direction } => {
                self.vector("line", *origin)?;
                self.vector("", *direction)
            }
            Curve::Circle { frame, radius } => self.frame("circle", frame, &[*radius]),
            Curve::Ellipse { frame, radii } => self.frame("ellipse", frame, radii),
            Curve::Nurbs(curve) => {
                self.words("nurbs")?;
                self.nurbs(curve, |point| shorts(&point.to_array()))
            }
        }
    }

    fn nurbs<P>(&mut self, curve: &NurbsCurve<P>, point: impl Fn(&P) -> String) -> io::Result<()> {
        self.words(format_args!("degree {}", curve.degree()))?;
        self.knots(curve.knots())?;
        self.words(format_args!("points {}", curve.control_points().len()))?;
        curve.control_points().iter().try_for_each(|p| self.words(point(p)))
    }

    fn knots(&mut self, knots: &[f64]) -> io::Result<()> {
        self.words(format_args!("knots {}", knots.len()))?;
        knots.iter().try_for_each(|knot| self.words(Short(*knot)))
    }

    /// A shape with its frame and its numbers.
    fn frame(&mut self, shape: &str, frame: &Frame, numbers: &[f64]) -> io::Result<()> {
        self.words(shape)?;
        self.vector("origin", frame.origin)?;
        self.vector("x", frame.x)?;
        self.vector("y", frame.y)?;
        self.vector("z", frame.z)?;
        if numbers.is_empty() { Ok(()) } else { self.words(shorts(numbers)) }
    }

    fn face(&mut self, face: &Face) -> io::Result<()> {
        self.begin(0)?;
        self.words("face")?;
        self.name(&face.name)?;
        self.words(format_args!("tolerance {}", Short(face.tolerance)))?;
        self.color(face.color)?;
        self.words(if face.reversed { "reversed" } else { "forward" })?;
        let [low, high] = face.bounds;
        self.words(format_args!("bounds {}", shorts(&[low.x, high.x, low.y, high.y])))?;
        self.begin(2)?;
        self.surface(&face.surface)?;
        for coedges in &face.loops {
            self.begin(2)?;
            self.words(format_args!("loop {}", coedges.len()))?;
            coedges.iter().try_for_each(|coedge| self.coedge(coedge))?;
        }
        Ok(())
    }

    fn surface(&mut self, surface: &FaceSurface) -> io::Result<()> {
        match surface {
            FaceSurface::Plane(frame) => self.frame("plane", frame, &[]),
            FaceSurface::Cylinder { frame, radius } => self.frame("cylinder", frame, &[*radius]),
            FaceSurface::Cone { frame, radius, half_angle } => {
                self.frame("cone", frame, &[*radius, *half_angle])
            }
            FaceSurface::Sphere { frame, radius } => self.frame("sphere", frame, &[*radius]),
            FaceSurface::Torus { frame, major_radius, minor_radius } => {
                self.frame("torus", frame, &[*major_radius, *minor_radius])
            }
            FaceSurface::Revolution { origin, axis, curve } => {
                self.words("revolution")?;
                self.vector("origin", *origin)?;
                self.vector("axis", *axis)?;
                self.curve(curve)
            }
            FaceSurface::Extrusion { direction, curve } => {
                self.words("extrusion")?;
                self.vector("direction", *direction)?;
                self.curve(curve)
            }
            FaceSurface::Nurbs(surface) => {
                let degree = surface.degree();
                self.words(format_args!("nurbs degree {} {}", degree.u(), degree.v()))?;
                surface.knots().iter().try_for_each(|knots| self.knots(knots))?;
                self.words(format_args!("points {} {}", surface.columns(), surface.rows()))?;
                let mut points = surface.control_points().iter();
                points.try_for_each(|point| self.words(shorts(&point.to_array())))
            }
        }
    }

    fn coedge(&mut self, coedge: &Coedge) -> io::Result<()> {
        let sign = if coedge.forward { '+' } else { '-' };
        self.words(format_args!("{sign} {}", coedge.edge))?;
        let Some(curve) = &coedge.pcurve else { return Ok(()) };
        self.words("pcurve")?;
        self.nurbs(curve, |point| shorts(&point.to_array()))
    }

    fn product(&mut self, product: &Product) -> io::Result<()> {
        self.begin(0)?;
        self.words("product")?;
        self.name(&product.name)?;
        self.color(product.color)?;
        let [first, count] = product.faces;
        self.words(format_args!("faces {first} {count}"))?;
        product.uses.iter().try_for_each(|used| self.product_use(used))
    }

    fn product_use(&mut self, used: &ProductUse) -> io::Result<()> {
        self.begin(2)?;
        self.words(format_args!("use {}", used.product))?;
        self.color(used.color)?;
        let [x, y, z] = [
            used.placement.matrix3.x_axis,
            used.placement.matrix3.y_axis,
            used.placement.matrix3.z_axis,
        ];
        self.vector("columns", x)?;
        [y, z, used.placement.translation]
            .into_iter()
            .try_for_each(|column| self.vector("", column))
    }
}

#[cfg(test)]
mod tests {
    use super::Short;

    #[test]
    fn numbers_have_the_fewest_characters() {
        let mut numbers = vec![
            0.0,
            -0.0,
            5e-324,
            f64::MAX,
            f64::MIN_POSITIVE,
            1.0 / 3.0,
            f64::NAN,
            f64::INFINITY,
        ];
        for digits in [1.0, 1.2, 1.25, 1.234_567_89, std::f64::consts::PI] {
            numbers.extend((-30..30).map(|power| -digits * 10_f64.powi(power)));
        }
        for number in numbers {
            let (plain, with_exponent) = (format!("{number}"), format!("{number:e}"));
            let shorter = if plain.len() <= with_exponent.len() { plain } else { with_exponent };
            assert_eq!(Short(number).to_string(), shorter);
        }
        assert_eq!(Short(0.1_f32).to_string(), "0.1");
    }
}
