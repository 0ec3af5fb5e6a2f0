//! Surfaces of a scene: patches with their transform, style and trims.

use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4};

use super::Image;
use crate::bezier::{Degree, Patch, check_control_point, check_coordinates};
use crate::error::{Error, Result};
use crate::trim::Trims;

/// How a surface is lit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Shading {
    /// The thesis' Phong model with its two lights.
    #[default]
    Phong,
    /// The picture or colour alone, as in the report.
    Unlit,
    /// The view-space normal n as the colour (n + 1) / 2.
    Normals,
}

/// Colour of a surface before lighting.
#[derive(Debug, Clone, PartialEq)]
pub enum Paint {
    /// Red, green and blue, each 0 … 1.
    Color([f32; 3]),
    /// A picture over the domain; surfaces may share it. Where its alpha is below one half, there is a hole.
    Texture(Arc<Image>),
}

impl Default for Paint {
    fn default() -> Self {
        Self::Color([0.8, 0.8, 0.8])
    }
}

/// Which sides of a surface need not be drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Cull {
    /// Both sides are drawn.
    #[default]
    None,
    /// Patches that show only their back are left out; this is meant for closed surfaces. The back is the side from
    /// which the turn from u to v is clockwise. Only the exact method does this.
    Back,
}

/// One or more patches of one degree that share transform, paint and trims. Every patch has its own
/// domain [0, 1]², so every patch is painted and trimmed alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    degree: Degree,
    control_points: Arc<Vec<DVec4>>,
    /// Model space to world space.
    pub transform: DMat4,
    /// Colour before lighting.
    pub paint: Paint,
    /// Lighting.
    pub shading: Shading,
    /// Its trims.
    pub trims: Trims,
    /// Which patches are left out because of their orientation.
    pub cull: Cull,
}

impl Surface {
    /// Patches of one degree from their control points (x, y, z, weight), patch after patch.
    ///
    /// # Errors
    /// No point, a number that is not a multiple of the patch size, a point that is not finite, a weight that is not
    /// above 0. Points are numbered from 0.
    pub fn new(degree: Degree, control_points: Vec<DVec4>) -> Result<Self> {
        if control_points.is_empty() || !control_points.len().is_multiple_of(degree.points()) {
            return Err(Error::invalid(
                "number of control points",
                control_points.len(),
                format!("{} for each patch", degree.points()),
            ));
        }
        for (index, point) in control_points.iter().enumerate() {
            check_control_point(*point, index)?;
        }
        Ok(Self {
            degree,
            control_points: Arc::new(control_points),
            transform: DMat4::IDENTITY,
            paint: Paint::default(),
            shading: Shading::default(),
            trims: Trims::default(),
            cull: Cull::default(),
        })
    }

    /// One patch.
    ///
    /// # Errors
    /// A number of points that is not that of the degree, and as [`Surface::new`].
    pub fn of_patch(degree: Degree, control_points: Vec<DVec4>) -> Result<Self> {
        if control_points.len() != degree.points() {
            let (columns, rows) = (degree.columns(), degree.rows());
            return Err(Error::invalid(
                "number of control points",
                control_points.len(),
                format!("{}, {columns} along u times {rows} along v", degree.points()),
            ));
        }
        Self::new(degree, control_points)
    }

    /// The degree of all patches.
    #[must_use]
    pub const fn degree(&self) -> Degree {
        self.degree
    }

    /// The control points of all patches.
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        &self.control_points
    }

    /// Moves one control point; `index` counts through all patches.
    ///
    /// # Errors
    /// An index out of range, a point that is not finite, a weight that is not above 0. The surface
    /// stays as it was.
    pub fn set_control_point(&mut self, point: DVec4, index: usize) -> Result<()> {
        let count = self.control_points.len();
        if index >= count {
            return Err(Error::invalid(
                "index of a control point",
                index,
                format!("0 to {}", count - 1),
            ));
        }
        check_control_point(point, index)?;
        self.points_mut()[index] = point;
        Ok(())
    }

    /// The control points, for changes that keep them valid.
    pub(super) fn points_mut(&mut self) -> &mut [DVec4] {
        Arc::make_mut(&mut self.control_points).as_mut_slice()
    }

    /// The patches in order.
    pub fn patches(&self) -> impl ExactSizeIterator<Item = Patch<'_>> + '_ {
        self.control_points
            .chunks_exact(self.degree.points())
            .map(|points| Patch::new(self.degree, points))
    }

    /// Points of the surface in world space, `side` × `side` of each patch.
    pub(super) fn samples(&self, side: usize) -> impl Iterator<Item = DVec3> + Clone + '_ {
        let at = move |i: usize| i as f64 / (side - 1) as f64;
        self.control_points
            .chunks_exact(self.degree.points())
            .flat_map(move |points| (0..side * side).map(move |i| (points, i)))
            .map(move |(points, i)| {
                let patch = Patch::new(self.degree, points);
                let point = patch.at(at(i % side), at(i / side)).position;
                self.transform.transform_point3(point)
            })
    }

    /// Control points in world space, without their weights. The surface lies in their convex hull.
    pub fn world_points(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.control_points.iter().map(|point| self.transform.transform_point3(point.truncate()))
    }
}

/// The 16 control points of a new surface: the grid of listing 16, flat in y = 0, row by row from
/// the front (z = 0.5) to the back, every row from left to right.
#[must_use]
pub fn default_control_points() -> Vec<DVec4> {
    const PLACES: [f64; 4] = [-0.5, -0.17, 0.17, 0.5];
    PLACES
        .iter()
        .rev()
        .flat_map(|z| PLACES.iter().map(move |x| DVec4::new(*x, 0.0, *z, 1.0)))
        .collect()
}

/// Checks a matrix from model space to world space.
pub(crate) fn check_transform(matrix: &DMat4) -> Result<()> {
    for column in [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis] {
        check_coordinates("model matrix", column.truncate())?;
    }
    if matrix.row(3) != DVec4::W {
        return Err(Error::invalid("last row of the model matrix", matrix.row(3), "0 0 0 1"));
    }
    Ok(())
}
