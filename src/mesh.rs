//! Triangle meshes, and smooth surfaces over them: curved PN triangles and Phong tessellation.
//!
//! A [`Mesh`] is plain data in `f64`. [`HalfedgeMesh`] adds the connectivity, and subdivides every triangle into
//! nine. The new points lie on [`PnTriangle`]s or [`PhongTriangle`]s. Only positions decide which triangles are
//! connected. Normals and texture coordinates may differ from corner to corner, which makes creases and seams.

mod half_edge;
mod normals;
mod phong;
mod pn;
mod step;
mod vectors;
mod weld;

use glam::{DVec2, DVec3};

use crate::bezier::check_coordinates;
use crate::error::{Error, Result};

pub use half_edge::{HalfedgeMesh, SharedBorders, SmoothTriangle};
pub use phong::PhongTriangle;
pub use pn::PnTriangle;
pub use step::{CurvedTriangle, smooth};
pub(crate) use weld::weld;

/// How a mesh becomes a smooth surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Smoothing {
    /// No smoothing: flat triangles, shaded by interpolated normals.
    #[default]
    None,
    /// Curved PN triangles (Vlachos, Peters, Boyd, Mitchell 2001).
    Pn,
    /// Phong tessellation (Boubekeur, Alexa 2008).
    Phong(Alpha),
}

/// How far Phong tessellation moves points towards the tangent planes: from 0, not at all, to 1.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Alpha(f64);

impl Alpha {
    /// Not at all: the mesh stays as it is.
    pub const NONE: Self = Self(0.0);

    /// A factor.
    ///
    /// # Errors
    /// Anything outside 0 … 1.
    pub fn new(alpha: f64) -> Result<Self> {
        if (0.0..=1.0).contains(&alpha) {
            Ok(Self(alpha))
        } else {
            Err(Error::invalid("alpha", alpha, "a number from 0 to 1"))
        }
    }

    /// The factor.
    #[must_use]
    pub const fn get(self) -> f64 {
        self.0
    }
}

impl Default for Alpha {
    /// Three quarters, as in the paper.
    fn default() -> Self {
        Self(0.75)
    }
}

/// The crease angle in degrees, from 0 to 180. If the angle between the normals of two triangles is larger, their
/// common edge is a crease, and computed normals differ on its two sides.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct CreaseAngle(f64);

impl CreaseAngle {
    /// 180 degrees: no crease anywhere.
    pub const NONE: Self = Self(180.0);

    /// An angle in degrees.
    ///
    /// # Errors
    /// Anything outside 0 … 180.
    pub fn new(degrees: f64) -> Result<Self> {
        if (0.0..=180.0).contains(&degrees) {
            Ok(Self(degrees))
        } else {
            Err(Error::invalid("crease_degrees", degrees, "a number of degrees from 0 to 180"))
        }
    }

    /// The angle in degrees.
    #[must_use]
    pub const fn degrees(self) -> f64 {
        self.0
    }
}

impl Default for CreaseAngle {
    /// 30 degrees: a cube keeps its edges, and round shapes stay smooth.
    fn default() -> Self {
        Self(30.0)
    }
}

/// One corner of a triangle: indices, from 0, into the lists of its mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Corner {
    /// The position. Triangles whose corners have the same position are connected.
    pub position: u32,
    /// The normal, or [`Corner::NONE`] in the arguments of [`Mesh::new`].
    pub normal: u32,
    /// The texture coordinates, or [`Corner::NONE`].
    pub coordinate: u32,
}

impl Corner {
    /// No normal, or no texture coordinates.
    pub const NONE: u32 = u32::MAX;
}

/// Triangles over lists of positions, unit normals and texture coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    coordinates: Vec<DVec2>,
    triangles: Vec<[Corner; 3]>,
    colors: Vec<[f32; 3]>,
}

impl Mesh {
    /// The maximum number of triangles of a mesh; their indices and half-edges take 3 GiB.
    pub const MAX_TRIANGLES: usize = 50_000_000;

    /// A mesh. Normals are normalized. A zero normal stays zero; edges are straight there. A corner without a normal
    /// gets the direction of the angle-weighted sum of the face normals around its position, up to creases and
    /// borders. Corners without texture coordinates get (0, 0) if other corners have some.
    ///
    /// # Errors
    /// No triangle or more than [`Mesh::MAX_TRIANGLES`], an index out of range, a triangle that has the same position
    /// twice, a number that is not finite, a position beyond 1e15. Indices in errors begin at 0.
    pub fn new(
        positions: Vec<DVec3>,
        normals: Vec<DVec3>,
        coordinates: Vec<DVec2>,
        triangles: Vec<[Corner; 3]>,
        crease: CreaseAngle,
    ) -> Result<Self> {
        if triangles.is_empty() || triangles.len() > Self::MAX_TRIANGLES {
            let expected = format!("1 to {}", Self::MAX_TRIANGLES);
            return Err(Error::invalid("number of triangles", triangles.len(), expected));
        }
        // The limit ensures that the indices after a smoothing step fit in 32 bits.
        let longest = positions.len().max(normals.len()).max(coordinates.len());
        if longest > 3 * Self::MAX_TRIANGLES {
            let expected = format!("at most {}", 3 * Self::MAX_TRIANGLES);
            return Err(Error::invalid("number of vertices", longest, expected));
        }
        for (index, position) in positions.iter().enumerate() {
            // The name is built only if there is an error.
            check_coordinates("", *position)
                .or_else(|_| check_coordinates(format!("position {index}"), *position))?;
        }
        let mut mesh = Self { positions, normals, coordinates, triangles, colors: Vec::new() };
        mesh.check_indices()?;
        for (index, normal) in mesh.normals.iter_mut().enumerate() {
            *normal = vectors::unit(*normal)
                .ok_or_else(|| Error::invalid(format!("normal {index}"), *normal, "finite"))?;
        }
        for (index, coordinate) in mesh.coordinates.iter().enumerate() {
            if !coordinate.is_finite() {
                let name = format!("texture coordinates {index}");
                return Err(Error::invalid(name, coordinate, "finite numbers"));
            }
        }
        normals::complete(&mut mesh, crease);
        mesh.complete_coordinates();
        Ok(mesh)
    }

    /// The mesh with a colour at each position: red, green and blue from 0 to 1. The paint is multiplied by this
    /// colour. An empty list leaves the paint as it is.
    ///
    /// # Errors
    /// A number of colours that differs from the number of positions, a value outside 0 … 1.
    pub fn with_colors(mut self, colors: Vec<[f32; 3]>) -> Result<Self> {
        if !colors.is_empty() && colors.len() != self.positions.len() {
            let expected = format!("{}, one for each position", self.positions.len());
            return Err(Error::invalid("number of colors", colors.len(), expected));
        }
        let good = |color: &[f32; 3]| color.iter().all(|value| (0.0..=1.0).contains(value));
        if let Some(bad) = colors.iter().position(|color| !good(color)) {
            let value = format!("{:?}", colors[bad]);
            return Err(Error::invalid(format!("color {bad}"), value, "numbers from 0 to 1"));
        }
        self.colors = colors;
        Ok(self)
    }

    fn check_indices(&self) -> Result<()> {
        let check = |name: &str, triangle: usize, index: u32, count: usize| {
            if (index as usize) < count {
                return Ok(());
            }
            let name = format!("index of a {name} of triangle {triangle}");
            Err(Error::invalid(name, index, format!("a number below {count}")))
        };
        for (triangle, corners) in self.triangles.iter().enumerate() {
            for corner in corners {
                check("position", triangle, corner.position, self.positions.len())?;
                if corner.normal != Corner::NONE {
                    check("normal", triangle, corner.normal, self.normals.len())?;
                }
                if corner.coordinate != Corner::NONE {
                    check(
                        "texture coordinate",
                        triangle,
                        corner.coordinate,
                        self.coordinates.len(),
                    )?;
                }
            }
            let [a, b, c] = corners.map(|corner| corner.position);
            if a == b || b == c || c == a {
                let name = format!("positions of triangle {triangle}");
                return Err(Error::invalid(name, format!("{a}, {b}, {c}"), "three different ones"));
            }
        }
        Ok(())
    }

    /// Gives (0, 0) to corners without texture coordinates, unless no corner has any.
    fn complete_coordinates(&mut self) {
        let corners = || self.triangles.iter().flatten();
        if corners().all(|corner| corner.coordinate == Corner::NONE) {
            self.coordinates.clear();
        } else if corners().any(|corner| corner.coordinate == Corner::NONE) {
            let zero = self.coordinates.len() as u32;
            self.coordinates.push(DVec2::ZERO);
            for corner in self.triangles.iter_mut().flatten() {
                if corner.coordinate == Corner::NONE {
                    corner.coordinate = zero;
                }
            }
        }
    }

    /// The positions.
    #[must_use]
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// The normals: unit vectors, or zero.
    #[must_use]
    pub fn normals(&self) -> &[DVec3] {
        &self.normals
    }

    /// The texture coordinates; empty if no corner has any.
    #[must_use]
    pub fn coordinates(&self) -> &[DVec2] {
        &self.coordinates
    }

    /// The colours of the positions; empty if the mesh has none.
    #[must_use]
    pub fn colors(&self) -> &[[f32; 3]] {
        &self.colors
    }

    /// The triangles, counter-clockwise from outside. Every corner has a normal, and texture
    /// coordinates unless the mesh has none.
    #[must_use]
    pub fn triangles(&self) -> &[[Corner; 3]] {
        &self.triangles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn corner(position: u32) -> Corner {
        Corner { position, normal: Corner::NONE, coordinate: Corner::NONE }
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        for alpha in [-0.1, 1.1, f64::NAN] {
            assert!(Alpha::new(alpha).unwrap_err().to_string().contains("0 to 1"));
        }
        for degrees in [-1.0, 180.1, f64::NAN] {
            assert!(CreaseAngle::new(degrees).unwrap_err().to_string().contains("0 to 180"));
        }
        assert_eq!((Alpha::default().get(), CreaseAngle::default().degrees()), (0.75, 30.0));
    }

    #[test]
    fn bad_meshes_are_refused_by_name() {
        let points = || vec![DVec3::ZERO, DVec3::X, DVec3::Y];
        let face = || vec![[corner(0), corner(1), corner(2)]];
        let with = |k: usize, corner: Corner| {
            let mut faces = face();
            faces[0][k] = corner;
            faces
        };
        let far = vec![DVec3::ZERO, DVec3::X, DVec3::Y * 1e16];
        let nan = vec![DVec3::ZERO, DVec3::NAN, DVec3::Y];
        let infinite = vec![DVec3::Z, DVec3::INFINITY];
        let normal = with(1, Corner { normal: 2, ..corner(1) });
        let coordinate = with(2, Corner { coordinate: 1, ..corner(2) });
        for ((positions, normals, coordinates, triangles), words) in [
            ((points(), vec![], vec![], vec![]), "number of triangles is 0"),
            ((far, vec![], vec![], face()), "position 2 is"),
            ((nan, vec![], vec![], face()), "position 1 is"),
            ((points(), infinite, vec![], face()), "normal 1 is"),
            ((points(), vec![], vec![DVec2::NAN], face()), "coordinates 0 is"),
            ((points(), vec![], vec![], with(1, corner(3))), "below 3"),
            ((points(), vec![], vec![], with(1, corner(2))), "0, 2, 2"),
            ((points(), vec![DVec3::Z; 2], vec![], normal), "below 2"),
            ((points(), vec![], vec![DVec2::ZERO], coordinate), "below 1"),
        ] {
            let mesh =
                Mesh::new(positions, normals, coordinates, triangles, CreaseAngle::default());
            let text = mesh.unwrap_err().to_string();
            assert!(text.contains(words), "{text}");
        }
    }
}
