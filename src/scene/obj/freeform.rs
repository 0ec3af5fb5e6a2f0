//! Free-form surfaces of OBJ files: Bézier surfaces of any degree.

use std::collections::BTreeMap;

use glam::{DVec3, DVec4};

use crate::bezier::Degree;
use crate::scene::Surface;

/// State of the free-form statements that were read.
#[derive(Debug, Default)]
pub(super) struct FreeForm {
    /// From `cstype`: whether weights are used, and the kind of the curves.
    rational: bool,
    kind: String,
    /// From `deg`.
    degrees: [usize; 2],
    /// The indices of the control points of the current surface.
    points: Option<Vec<i64>>,
    /// The numbers of parameters of `parm u` and `parm v`.
    parameters: [usize; 2],
    patches: Vec<Patch>,
    /// Unsupported elements, with their counts.
    left_out: BTreeMap<String, usize>,
}

/// A patch. Its control points are indices from 0, row by row, with u along a row.
#[derive(Debug)]
struct Patch {
    line: usize,
    degree: Degree,
    rational: bool,
    points: Vec<u32>,
}

impl FreeForm {
    /// Reads a statement. Returns whether it is a free-form statement. `count` is the number of positions above it.
    ///
    /// # Errors
    /// A surface whose number of control points does not match its degrees and parameters.
    pub(super) fn statement<'a>(
        &mut self,
        name: &str,
        words: &mut impl Iterator<Item = &'a str>,
        count: usize,
        line: usize,
    ) -> Result<bool, String> {
        match name {
            "cstype" => {
                let kind = words.next().unwrap_or_default();
                self.rational = kind == "rat";
                let kind = if self.rational { words.next().unwrap_or_default() } else { kind };
                self.kind = kind.to_owned();
            }
            "deg" => {
                let mut degree =
                    || words.next().map_or(Ok(0), str::parse).map_err(|_| "deg has no degrees");
                self.degrees = [degree()?, degree()?];
            }
            "surf" => {
                // The ends of the two parameter ranges, four values, come first.
                let corners = words.skip(4).map(|word| {
                    let index = word.split('/').next().unwrap_or_default();
                    let index: i64 =
                        index.parse().map_err(|_| format!("\"{index}\" is no index"))?;
                    Ok(if index < 0 { count as i64 + index } else { index - 1 })
                });
                self.points = Some(corners.collect::<Result<_, String>>()?);
                self.parameters = [0; 2];
            }
            "parm" => {
                let axis = usize::from(words.next() == Some("v"));
                self.parameters[axis] = words.count();
            }
            "curv" | "curv2" => self.leave_out("curve"),
            "trim" | "hole" | "scrv" if self.points.is_some() => {
                self.leave_out("trimming statement")
            }
            "trim" | "hole" | "scrv" | "sp" | "vp" | "bmat" | "step" | "con" | "ctech"
            | "stech" | "bzp" | "bsp" | "cdc" | "cdp" | "res" => {}
            "end" => {
                if let Some(points) = self.points.take() {
                    self.surface(points, line)?;
                }
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn leave_out(&mut self, what: impl Into<String>) {
        *self.left_out.entry(what.into()).or_default() += 1;
    }

    /// Cuts a surface into its patches.
    fn surface(&mut self, points: Vec<i64>, line: usize) -> Result<(), String> {
        let [u, v] = self.degrees;
        if self.kind != "bezier" {
            self.leave_out(format!("{} surface", self.kind));
            return Ok(());
        }
        let Ok(degree) = Degree::new(u, v) else {
            self.leave_out(format!("Bézier surface of degrees {u} and {v}"));
            return Ok(());
        };
        let patches = self.parameters.map(|count| count.saturating_sub(1).max(1));
        let [columns, rows] = [patches[0] * u + 1, patches[1] * v + 1];
        if points.len() != columns * rows {
            return Err(format!(
                "the surface has {} control points; its degrees and parameters expect {columns}×{rows}",
                points.len()
            ));
        }
        let points: Vec<u32> =
            points.into_iter().map(|point| u32::try_from(point).unwrap_or(u32::MAX)).collect();
        let side = degree.columns();
        for (row, column) in
            (0..patches[1]).flat_map(|row| (0..patches[0]).map(move |column| (row, column)))
        {
            let at = |i: usize| points[(row * v + i / side) * columns + column * u + i % side];
            let points = (0..degree.points()).map(at).collect();
            self.patches.push(Patch { line, degree, rational: self.rational, points });
        }
        Ok(())
    }

    /// How many patches there are.
    pub(super) fn patches(&self) -> usize {
        self.patches.len()
    }

    /// The unsupported elements in words: "2 bspline surfaces".
    pub(super) fn left_out(&self) -> Vec<String> {
        let mut what = Vec::new();
        for (name, count) in &self.left_out {
            what.push(super::counted(*count, name));
        }
        what
    }

    /// Takes the patches as surfaces, one surface for each degree that occurs.
    ///
    /// # Errors
    /// A control point that does not exist, or whose weight is not above 0: the line and a message.
    pub(super) fn take_surfaces(
        &mut self,
        positions: &[DVec3],
        weights: &[f64],
    ) -> Result<Vec<Surface>, (usize, String)> {
        let mut points: BTreeMap<Degree, Vec<DVec4>> = BTreeMap::new();
        for Patch { line, degree, rational, points: indices } in std::mem::take(&mut self.patches) {
            for index in indices {
                let position = positions.get(index as usize).ok_or_else(|| {
                    let expected = format!("expected 1 to {}", positions.len());
                    (line, format!("a control point of the surface is no position; {expected}"))
                })?;
                let weight = if rational {
                    weights.get(index as usize).copied().unwrap_or(1.0)
                } else {
                    1.0
                };
                if weight.is_nan() || weight <= 0.0 {
                    let number = index + 1;
                    return Err((
                        line,
                        format!("the weight of position {number} is {weight}; expected above 0"),
                    ));
                }
                points.entry(degree).or_default().push(position.extend(weight));
            }
        }
        let surface =
            |(degree, points)| Surface::new(degree, points).map_err(|error| (1, error.to_string()));
        points.into_iter().map(surface).collect()
    }
}
