//! Surfaces of a scene: patches with their transform, style and trims.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat4, DVec2, DVec3, DVec4};

use super::{FaceOfModel, Image};
use crate::bezier::{
    CurvedPoint, Degree, NurbsSurface, Patch, PatchGrid, SurfacePoint, check_control_point,
    check_coordinates,
};
use crate::error::{Error, Result};
use crate::trim::{ParameterSizes, Trims};

/// How a surface is lit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Shading {
    /// Lit, by the light of the settings ([`Light`](super::Light)).
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

/// Patches of one degree that share transform, paint and trims: either a NURBS surface, whose patches divide its
/// domain, or Bézier patches. Of these, every patch has its own domain [0, 1]², so every patch is painted and trimmed
/// alike.
#[derive(Debug, Clone, PartialEq)]
pub struct Surface {
    degree: Degree,
    patch_points: Arc<Vec<DVec4>>,
    nurbs: Option<Arc<Nurbs>>,
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
    /// The face of a CAD model that it is, if it is one.
    pub face: Option<FaceOfModel>,
    /// Whether it is left out of pictures. Its neighbours stay its neighbours.
    pub hidden: bool,
    /// Whether no gap is left between it and other surfaces that it meets along its borders and trims. Neighbours with
    /// equal control points never have one.
    pub join: bool,
}

/// A NURBS surface and the grid of its patches.
#[derive(Debug, Clone, PartialEq)]
struct Nurbs {
    surface: NurbsSurface,
    grid: PatchGrid,
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
        Ok(Self::with_patches(degree, control_points, None))
    }

    fn with_patches(degree: Degree, patch_points: Vec<DVec4>, nurbs: Option<Arc<Nurbs>>) -> Self {
        Self {
            degree,
            patch_points: Arc::new(patch_points),
            nurbs,
            transform: DMat4::IDENTITY,
            paint: Paint::default(),
            shading: Shading::default(),
            trims: Trims::default(),
            cull: Cull::default(),
            face: None,
            hidden: false,
            join: true,
        }
    }

    /// A NURBS surface. Its trims and the picture over its domain are in its own parameters.
    #[must_use]
    pub fn from_nurbs(surface: NurbsSurface) -> Self {
        let (grid, points) = surface.patches();
        Self::with_patches(surface.degree(), points, Some(Arc::new(Nurbs { surface, grid })))
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

    /// The NURBS surface, if it is one.
    #[must_use]
    pub fn nurbs(&self) -> Option<&NurbsSurface> {
        self.nurbs.as_deref().map(|nurbs| &nurbs.surface)
    }

    /// Whether a patch of a NURBS surface has an edge that another surface may share: on the border of the domain, or
    /// where the surface is torn.
    pub(crate) fn is_outermost(&self, patch: usize) -> bool {
        let Some(grid) = self.patch_grid() else { return true };
        let (columns, rows) = (grid.columns.len(), grid.rows.len());
        let (column, row) = (patch % columns, patch / columns);
        let is_last = |place: usize, count: usize| place == 0 || place + 1 == count;
        is_last(column, columns)
            || is_last(row, rows)
            || (0..4).any(|side| !grid.continues(patch, side))
    }

    /// How the patches of a NURBS surface divide its domain.
    pub(crate) fn patch_grid(&self) -> Option<&PatchGrid> {
        self.nurbs.as_deref().map(|nurbs| &nurbs.grid)
    }

    /// The control points as they were given: those of the NURBS surface, or those of all patches.
    #[must_use]
    pub fn control_points(&self) -> &[DVec4] {
        self.nurbs().map_or(&self.patch_points, |nurbs| nurbs.control_points())
    }

    /// The control points of all Bézier patches, patch after patch.
    #[must_use]
    pub fn patch_points(&self) -> &[DVec4] {
        &self.patch_points
    }

    /// The same, to be kept.
    pub(crate) fn shared_patch_points(&self) -> Arc<Vec<DVec4>> {
        Arc::clone(&self.patch_points)
    }

    /// Refuses surfaces that the thesis' method does not draw.
    ///
    /// # Errors
    /// NURBS surfaces with trims or a picture, which lie over all patches together, and as
    /// [`Degree::check_for_thesis`].
    pub(crate) fn check_for_thesis(&self) -> Result<()> {
        let is_plain = matches!(self.paint, Paint::Color(_)) && self.trims.is_empty();
        if self.nurbs.is_some() && !is_plain {
            let expected = "no trims and no picture on it with the thesis' method";
            return Err(Error::invalid("surface", "a NURBS surface", expected));
        }
        self.degree.check_for_thesis()
    }

    /// Moves one control point; `index` counts through [`Surface::control_points`].
    ///
    /// # Errors
    /// An index out of range, a point that is not finite, a weight that is not above 0. The surface
    /// stays as it was.
    pub fn set_control_point(&mut self, point: DVec4, index: usize) -> Result<()> {
        let count = self.control_points().len();
        if index >= count {
            return Err(Error::invalid(
                "index of a control point",
                index,
                format!("0 to {}", count - 1),
            ));
        }
        check_control_point(point, index)?;
        match &mut self.nurbs {
            None => Arc::make_mut(&mut self.patch_points)[index] = point,
            Some(nurbs) => {
                let nurbs = Arc::make_mut(nurbs);
                nurbs.surface.points_mut()[index] = point;
                let (grid, points) = nurbs.surface.patches();
                nurbs.grid = grid;
                self.patch_points = Arc::new(points);
            }
        }
        Ok(())
    }

    /// Whether it has the same control points, without a comparison of each, and the same trims as another.
    pub(crate) fn has_shape_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.patch_points, &other.patch_points) && self.trims == other.trims
    }

    /// The patches in order.
    pub fn patches(&self) -> impl ExactSizeIterator<Item = Patch<'_>> + '_ {
        self.patch_points
            .chunks_exact(self.degree.points())
            .map(|points| Patch::new(self.degree, points))
    }

    /// The first and the last parameters (u, v) of the surface: [0, 1]² for Bézier patches.
    #[must_use]
    pub fn domain(&self) -> [DVec2; 2] {
        self.nurbs().map_or([DVec2::ZERO, DVec2::ONE], NurbsSurface::domain)
    }

    /// The sizes to which tolerances of its trims are relative.
    #[must_use]
    pub fn parameter_sizes(&self) -> ParameterSizes {
        let Some(grid) = self.patch_grid() else { return ParameterSizes::default() };
        let smallest = |spans: &[[f64; 2]]| {
            spans.iter().map(|[first, last]| last - first).fold(f64::INFINITY, f64::min)
        };
        let [low, high] = self.domain();
        let patch = DVec2::new(smallest(&grid.columns), smallest(&grid.rows));
        ParameterSizes { domain: high - low, patch }
    }

    /// The first and the last parameters (u, v) of a patch.
    ///
    /// # Panics
    /// If there is no such patch.
    #[must_use]
    pub fn patch_domain(&self, patch: usize) -> [DVec2; 2] {
        self.patch_grid().map_or([DVec2::ZERO, DVec2::ONE], |grid| grid.domain_of(patch))
    }

    /// The number of the patch at a place of the domain.
    pub(crate) fn patch_at(&self, place: DVec2) -> usize {
        self.patch_grid().map_or(0, |grid| grid.patch_at(place))
    }

    /// Value and derivatives of a patch where u and v run from 0 to 1 within it. A NURBS surface is evaluated on its
    /// own knots, whatever its patches are.
    ///
    /// # Panics
    /// If there is no such patch.
    #[must_use]
    pub fn at(&self, patch: usize, u: f64, v: f64) -> SurfacePoint {
        let Some(nurbs) = self.nurbs() else {
            let count = self.degree.points();
            let points = &self.patch_points[patch * count..][..count];
            return Patch::new(self.degree, points).at(u, v);
        };
        let [low, high] = self.patch_domain(patch);
        let size = high - low;
        let point = nurbs.at_in([low, high], DVec2::new(u, v));
        SurfacePoint { du: point.du * size.x, dv: point.dv * size.y, ..point }
    }

    /// Value, first and second derivatives at a place of the domain, by parameters from 0 to 1 within the patch there. Of
    /// Bézier patches, each of which has a domain of its own, it is the one of that number.
    ///
    /// # Panics
    /// If there is no such patch.
    #[must_use]
    pub fn curved_at(&self, patch: usize, place: DVec2) -> CurvedPoint {
        let patch = self.patch_grid().map_or(patch, |grid| grid.patch_at(place));
        let [low, high] = self.patch_domain(patch);
        let share = (place - low) / (high - low);
        let count = self.degree.points();
        let points = &self.patch_points[patch * count..][..count];
        Patch::new(self.degree, points).curved(share.x, share.y)
    }

    /// The parameters of the point that is nearest to a point in model space, from parameters nearby: of a Bézier
    /// patch, or of a whole NURBS surface.
    pub(crate) fn nearest(&self, patch: usize, point: DVec3, near: DVec2) -> DVec2 {
        const STEPS: u32 = 8;
        let [low, high] = self.domain();
        let at = |place: DVec2| {
            let patch = self.patch_grid().map_or(patch, |grid| grid.patch_at(place));
            let [low, high] = self.patch_domain(patch);
            let share = (place - low) / (high - low);
            let point = self.at(patch, share.x, share.y);
            SurfacePoint { du: point.du / (high - low).x, dv: point.dv / (high - low).y, ..point }
        };
        let (mut place, mut here) = (near, at(near));
        for _ in 0..STEPS {
            let SurfacePoint { position, du, dv } = here;
            let off = point - position;
            let (a, b, c) = (du.length_squared(), du.dot(dv), dv.length_squared());
            let (along_u, along_v) = (off.dot(du), off.dot(dv));
            let step =
                DVec2::new(c * along_u - b * along_v, a * along_v - b * along_u) / (a * c - b * b);
            let next = (place + step).clamp(low, high);
            if !next.is_finite() {
                break;
            }
            let there = at(next);
            if there.position.distance_squared(point) >= here.position.distance_squared(point) {
                break;
            }
            (place, here) = (next, there);
        }
        place
    }

    /// Points of the surface in world space, `side` × `side` of each patch.
    pub(super) fn samples(&self, side: usize) -> impl Iterator<Item = DVec3> + Clone + '_ {
        let at = move |i: usize| i as f64 / (side - 1) as f64;
        self.patch_points
            .chunks_exact(self.degree.points())
            .flat_map(move |points| (0..side * side).map(move |i| (points, i)))
            .map(move |(points, i)| {
                let patch = Patch::new(self.degree, points);
                let point = patch.at(at(i % side), at(i / side)).position;
                self.transform.transform_point3(point)
            })
    }

    /// [`Surface::control_points`] in world space, without their weights. The surface lies in their convex hull.
    pub fn world_points(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.control_points().iter().map(|point| self.transform.transform_point3(point.truncate()))
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
/// For each surface, the number of an earlier one of the same shape, or its own: the first one that has the same control
/// points is looked at. What is `None` is like nothing else.
pub(crate) fn first_alike<'a>(surfaces: impl Iterator<Item = Option<&'a Surface>>) -> Vec<usize> {
    let mut first_with = HashMap::new();
    let first = |(number, surface): (usize, Option<&'a Surface>)| {
        let Some(surface) = surface else { return number };
        let (first, other) =
            *first_with.entry(surface.patch_points.as_ptr()).or_insert((number, surface));
        if surface.has_shape_of(other) { first } else { number }
    };
    surfaces.enumerate().map(first).collect()
}

pub(crate) fn check_transform(matrix: &DMat4) -> Result<()> {
    for column in [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis] {
        check_coordinates("model matrix", column.truncate())?;
    }
    if matrix.row(3) != DVec4::W {
        return Err(Error::invalid("last row of the model matrix", matrix.row(3), "0 0 0 1"));
    }
    Ok(())
}
