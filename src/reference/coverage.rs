//! Which pixels a scene covers, in `f64` and independent of a tessellation level: patches are subdivided as
//! finely as the picture needs.
//!
//! In clip space, a patch is a patch of four coordinates, even if it is rational. Second differences of its
//! control points bound how far the triangles between its points deviate from it. Each sub-patch gets the
//! number of triangles that keeps this below [`TOLERANCE_PX`].

mod cut;
mod rows;
mod sub_patch;

use glam::{DMat4, DVec2, DVec4, UVec2};

use super::raster::owns;
use crate::camera::ViewProjection;
use crate::error::Result;
use crate::scene::{Method, Scene};
use cut::{Cut, Decision};
use sub_patch::SubPatch;

/// The largest distance of triangles from the surface, in pixels.
const TOLERANCE_PX: f64 = 0.03;

/// How a scene covers a pixel. Pixels off the picture do not count as neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Cover {
    /// No surface at any pixel's centre within 1.5 pixels.
    #[default]
    Background,
    /// No surface at the centre, but one at another centre within 1.5 pixels.
    Beside,
    /// A surface at the centre. But at another centre within 1.5 pixels there is no surface or trims cut one,
    /// or trims may cut the surface within this pixel.
    Border,
    /// A surface at every pixel's centre within 1.5 pixels. Trims cut no surface at these centres, and do not
    /// cut the surface within this pixel.
    Inside,
}

impl Cover {
    /// Whether a surface is at the pixel's centre.
    #[must_use]
    pub const fn covered(self) -> bool {
        matches!(self, Self::Border | Self::Inside)
    }
}

/// Which pixels of a picture a scene covers.
#[derive(Debug, Clone, PartialEq)]
pub struct Coverage {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// The pixels row by row from the top.
    pub pixels: Vec<Cover>,
    /// The distance along the view axis, in world units, of the nearest surface at each pixel's centre that
    /// trims do not cut there; infinite if there is none.
    pub distances: Vec<f64>,
}

/// Finds the pixels of a picture of `size` pixels that a scene covers, accurate to 0.03 pixels. At every
/// centre, the oracle of the method decides the trims. Of the scene's settings, only Newton's matter.
///
/// # Errors
/// The thesis' method is requested and cannot cut one of the loops.
pub fn coverage(
    scene: &Scene,
    projection: &ViewProjection,
    size: UVec2,
    method: Method,
) -> Result<Coverage> {
    let mut canvas = Canvas::new(size);
    let depth = Depth::of(scene, projection);
    let own_clip = depth.clip(&projection.projection);
    let near_w = match depth {
        Depth::Perspective { nearest } => nearest,
        Depth::Parallel { .. } => 1.0,
    };
    for surface in scene.surfaces.iter().filter(|surface| !surface.hidden) {
        let mut cut = Cut::new(surface, scene.settings.newton, method)?;
        let to_clip = own_clip * projection.view * surface.transform;
        for (number, patch) in surface.patches().enumerate() {
            cut.patch = number;
            let whole = SubPatch::whole(&patch, &to_clip, near_w);
            whole.cut_up(size, &mut |sub_patch, cells| canvas.sub_patch(sub_patch, cells, &cut));
        }
    }
    Ok(canvas.into_coverage(&depth))
}

/// The mapping of depth that is used here: it begins at the eye, independent of the picture's clip planes.
#[derive(Debug, Clone, Copy)]
enum Depth {
    /// z / w is 1 − 2 · nearest / distance.
    Perspective { nearest: f64 },
    /// z / w goes from −1 at the minimum distance to 1 at the maximum distance.
    Parallel { min: f64, max: f64 },
}

impl Depth {
    fn of(scene: &Scene, projection: &ViewProjection) -> Self {
        /// Relative to the maximum distance: points nearer to the eye's plane are not visible.
        const EYE: f64 = 2e-8;
        let distances = scene.surfaces.iter().flat_map(|surface| {
            let to_view = projection.view * surface.transform;
            let points = surface.control_points().iter();
            points.map(move |point| -to_view.transform_point3(point.truncate()).z)
        });
        let (min, max) = distances
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), distance| {
                (min.min(distance), max.max(distance))
            });
        if projection.projection.row(3).z == 0.0 {
            let margin = (max - min).max(1.0);
            return Self::Parallel { min: min - margin, max: max + margin };
        }
        Self::Perspective { nearest: EYE * max.abs().max(f64::MIN_POSITIVE) }
    }

    /// The projection with this depth instead of its own.
    fn clip(&self, projection: &DMat4) -> DMat4 {
        let mut rows = projection.transpose();
        rows.z_axis = match self {
            Self::Perspective { nearest } => rows.w_axis - DVec4::W * (2.0 * nearest),
            Self::Parallel { min, max } => {
                let size = max - min;
                DVec4::new(0.0, 0.0, -2.0 / size, -(max + min) / size)
            }
        };
        rows.transpose()
    }

    /// The distance along the view axis for a value of z / w.
    fn distance(&self, z: f64) -> f64 {
        match self {
            Self::Perspective { nearest } => 2.0 * nearest / (1.0 - z),
            Self::Parallel { min, max } => 0.5 * ((max - min) * z + max + min),
        }
    }
}

/// Whether a scene has a gap within `radius_px` pixels of a pixel's centre, even one narrower than a pixel. To
/// find it, a window around the centre is magnified.
///
/// # Errors
/// The same as of [`coverage`].
pub fn has_gap_near(
    scene: &Scene,
    projection: &ViewProjection,
    size: UVec2,
    [x, y]: [u32; 2],
    radius_px: f64,
    method: Method,
) -> Result<bool> {
    const SIDE: u32 = 512;
    let center = (UVec2::new(x, y).as_dvec2() + 0.5) / size.as_dvec2() * 2.0 - 1.0;
    let zoom = size.as_dvec2() * (0.5 / radius_px);
    let mut window = DMat4::from_scale(zoom.extend(1.0));
    window.w_axis = DVec4::new(-center.x * zoom.x, center.y * zoom.y, 0.0, 1.0);
    let seen = ViewProjection { projection: window * projection.projection, ..*projection };
    let shown = coverage(scene, &seen, UVec2::splat(SIDE), method)?;
    Ok(shown.pixels.iter().any(|cover| !cover.covered()))
}

/// A corner of a triangle.
#[derive(Clone, Copy)]
struct Corner {
    clip: DVec4,
    uv: DVec2,
}

impl Corner {
    /// How far it is in front of the near plane, z ≥ −w.
    fn in_front(&self) -> f64 {
        self.clip.z + self.clip.w
    }
}

/// A pixel while the picture is made.
#[derive(Clone, Copy)]
struct Spot {
    covered: bool,
    /// Whether trims do not cut the surface within the pixel.
    whole: bool,
    /// Whether trims cut any surface at the centre, one in front or behind.
    cut: bool,
    /// The number of a sub-patch that comes closer to the centre than the tolerance but does not cover it.
    /// Sub-patches count from 1.
    beside: u32,
    /// z / w of the nearest surface at the centre.
    nearest: f64,
}

impl Default for Spot {
    fn default() -> Self {
        Self { covered: false, whole: false, cut: false, beside: 0, nearest: 1.0 }
    }
}

/// The picture while it is made.
///
/// Where sub-patches with different numbers of cells meet, gaps open that the surface does not have. They are
/// at most as wide as the tolerance. So a centre that is this close to two sub-patches counts as covered.
struct Canvas {
    size: UVec2,
    spots: Vec<Spot>,
    sub_patches: u32,
    /// The corners of the current sub-patch, kept to reuse their memory.
    corners: Vec<Corner>,
}

impl Canvas {
    fn new(size: UVec2) -> Self {
        let spots = vec![Spot::default(); size.x as usize * size.y as usize];
        Self { size, spots, sub_patches: 0, corners: Vec::new() }
    }

    fn sub_patch(&mut self, sub_patch: &SubPatch, cells: usize, cut: &Cut<'_>) {
        self.sub_patches += 1;
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        corners.extend(sub_patch.corners(cells));
        for j in 0..cells {
            for i in 0..cells {
                let a = j * (cells + 1) + i;
                let c = a + cells + 1;
                self.triangle([corners[a], corners[a + 1], corners[c + 1]], sub_patch, cut);
                self.triangle([corners[a], corners[c + 1], corners[c]], sub_patch, cut);
            }
        }
        self.corners = corners;
    }

    fn triangle(&mut self, corners: [Corner; 3], sub_patch: &SubPatch, cut: &Cut<'_>) {
        let in_front = corners.map(|corner| corner.in_front() > 0.0);
        if in_front == [true; 3] {
            self.clipped_triangle(corners, sub_patch, cut);
            return;
        }
        // The part of the triangle in front of the near plane has three or four corners, or is empty.
        let mut polygon = [corners[0]; 4];
        let mut count = 0;
        for i in 0..3 {
            let (from, to) = (corners[i], corners[(i + 1) % 3]);
            if in_front[i] {
                polygon[count] = from;
                count += 1;
            }
            if in_front[i] != in_front[(i + 1) % 3] {
                let t = from.in_front() / (from.in_front() - to.in_front());
                polygon[count] =
                    Corner { clip: from.clip.lerp(to.clip, t), uv: from.uv.lerp(to.uv, t) };
                count += 1;
            }
        }
        for i in 2..count {
            self.clipped_triangle([polygon[0], polygon[i - 1], polygon[i]], sub_patch, cut);
        }
    }

    fn clipped_triangle(&mut self, mut corners: [Corner; 3], sub_patch: &SubPatch, cut: &Cut<'_>) {
        let size = self.size.as_dvec2();
        let mut places = corners.map(|corner| {
            let ndc = corner.clip.truncate().truncate() / corner.clip.w;
            DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size
        });
        // The range of columns and rows whose centres the triangle may reach.
        let low = places[0].min(places[1]).min(places[2]) - 0.5 - TOLERANCE_PX;
        let high = places[0].max(places[1]).max(places[2]) - 0.5 + TOLERANCE_PX;
        let low = low.ceil().max(DVec2::ZERO);
        let high = (high.floor() + 1.0).min(size);
        if !low.cmplt(high).all() {
            return;
        }
        if (places[1] - places[0]).perp_dot(places[2] - places[0]) >= 0.0 {
            corners.swap(1, 2);
            places.swap(1, 2);
        }
        let triangle = Triangle::new(corners, places);
        if triangle.area == 0.0 || !triangle.area.is_finite() {
            return;
        }
        for y in low.y as usize..high.y as usize {
            for x in low.x as usize..high.x as usize {
                let spot = &mut self.spots[y * self.size.x as usize + x];
                let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                triangle.meet(spot, center, (self.sub_patches, sub_patch), cut);
            }
        }
    }

    fn into_coverage(self, depth: &Depth) -> Coverage {
        let (width, height) = (self.size.x as usize, self.size.y as usize);
        let pixels = (0..width * height)
            .map(|i| {
                let (x, y) = (i % width, i / width);
                let mut around = (y.saturating_sub(1)..(y + 2).min(height))
                    .flat_map(|y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| (x, y)))
                    .map(|(x, y)| &self.spots[y * width + x]);
                let spot = &self.spots[i];
                if !spot.covered {
                    if around.any(|spot| spot.covered) { Cover::Beside } else { Cover::Background }
                } else if spot.whole && around.all(|spot| spot.covered && !spot.cut) {
                    Cover::Inside
                } else {
                    Cover::Border
                }
            })
            .collect();
        let distance = |spot: &Spot| {
            if spot.covered { depth.distance(spot.nearest) } else { f64::INFINITY }
        };
        let distances = self.spots.iter().map(distance).collect();
        Coverage { size: self.size.into(), pixels, distances }
    }
}

/// A triangle in the picture whose corners turn counter-clockwise on the screen.
struct Triangle {
    corners: [Corner; 3],
    places: [DVec2; 3],
    /// Twice the area, below 0.
    area: f64,
}

impl Triangle {
    fn new(corners: [Corner; 3], places: [DVec2; 3]) -> Self {
        let area = (places[1] - places[0]).perp_dot(places[2] - places[0]);
        Self { corners, places, area }
    }

    /// The edge that faces a corner.
    const fn edge(&self, corner: usize) -> [DVec2; 2] {
        [self.places[(corner + 1) % 3], self.places[(corner + 2) % 3]]
    }

    /// The weights of the corners at a place of the picture.
    fn weights(&self, place: DVec2) -> [f64; 3] {
        [0, 1, 2].map(|i| {
            let [from, to] = self.edge(i);
            (from - place).perp_dot(to - place) / self.area
        })
    }

    /// Perspective-correct (u, v).
    fn uv(&self, weights: [f64; 3]) -> DVec2 {
        let over_w = [0, 1, 2].map(|i| weights[i] / self.corners[i].clip.w);
        let sum: DVec2 = (0..3).map(|i| self.corners[i].uv * over_w[i]).sum();
        sum / over_w.iter().sum::<f64>()
    }

    /// Updates `spot` with what the triangle shows at a pixel's centre.
    fn meet(
        &self,
        spot: &mut Spot,
        center: DVec2,
        (number, sub_patch): (u32, &SubPatch),
        cut: &Cut<'_>,
    ) {
        let mut weights = self.weights(center);
        let covers = (0..3).all(|i| {
            let [from, to] = self.edge(i);
            owns(weights[i], from, to)
        });
        if !covers {
            let is_close = |i: usize| {
                let [from, to] = self.edge(i);
                weights[i] * self.area.abs() >= -TOLERANCE_PX * from.distance(to)
            };
            if spot.covered || spot.beside == number || !(0..3).all(is_close) {
                return;
            }
            weights = weights.map(|weight| weight.max(0.0));
            let sum: f64 = weights.iter().sum();
            weights = weights.map(|weight| weight / sum);
        }
        let depth: f64 =
            (0..3).map(|i| weights[i] * self.corners[i].clip.z / self.corners[i].clip.w).sum();
        if !(-1.0..1.0).contains(&depth) {
            return;
        }
        let uv = self.uv(weights);
        // The depth of the surface itself is used: in depth, the triangles may be far from it.
        let depth = sub_patch.depth(uv).clamp(-1.0, 1.0);
        let may_be_cut = cut.is_possible();
        if spot.covered && depth >= spot.nearest && (spot.cut || !may_be_cut) {
            return;
        }
        if may_be_cut && cut.cuts(uv) {
            spot.cut = true;
            return;
        }
        if covers || spot.beside != 0 {
            spot.nearest = spot.nearest.min(depth);
        }
        if spot.covered {
            return;
        }
        if covers || spot.beside != 0 {
            spot.covered = true;
            spot.whole = !cut.is_possible() || !self.is_cut_around(center, cut);
        } else {
            spot.beside = number;
        }
    }

    /// Whether trims may cut the surface within a pixel. The corners and the middles of the edges are tested.
    /// For the exact method, something smaller is possible unless the grid rules it out.
    fn is_cut_around(&self, center: DVec2, cut: &Cut<'_>) -> bool {
        const AROUND: [f64; 3] = [-0.5, 0.0, 0.5];
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for offset in AROUND.iter().flat_map(|y| AROUND.iter().map(|x| DVec2::new(*x, *y))) {
            let uv = self.uv(self.weights(center + offset));
            if offset != DVec2::ZERO && cut.cuts(uv) {
                return true;
            }
            (low, high) = (low.min(uv), high.max(uv));
        }
        match &cut.decision {
            Decision::Exact(_, trims) => {
                trims.cut_throughout(cut.patch, low.as_vec2(), high.as_vec2()) != Some(false)
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::Degree;
    use crate::camera::{Camera, Lens};
    use crate::reference::{Pixel, render};
    use crate::scene::{Surface, TessLevel, Tessellation};
    use glam::{DVec3, dvec2, dvec3};

    /// A flat patch over x and y from `low` to `high`, with z = 0.
    fn plane(low: DVec2, high: DVec2) -> Surface {
        let points = (0..16).map(|i| dvec2(f64::from(i % 4), f64::from(i / 4)) / 3.0);
        let points = points.map(|uv| (low + (high - low) * uv).extend(0.0).extend(1.0)).collect();
        Surface::new(Degree::CUBIC, points).unwrap()
    }

    fn scene(surface: Surface, eye: DVec3, target: DVec3, up: DVec3, lens: Lens) -> Scene {
        let camera = Camera::new(eye, target, up, lens).unwrap();
        Scene { surfaces: vec![surface], camera: Some(camera), ..Scene::listing16() }
    }

    fn seen(scene: &Scene, size: UVec2) -> Coverage {
        coverage(scene, &scene.projection(size.x, size.y), size, Method::Exact).unwrap()
    }

    #[test]
    fn a_square_and_what_is_near_its_border() {
        let mut surface = plane(DVec2::ZERO, DVec2::ONE);
        // A slot between two columns of centres affects only the pixels beside it.
        let slot = crate::trim::Rect::new(dvec2(0.499, 0.501), dvec2(0.0, 1.0)).unwrap();
        surface.trims.rects.push(slot);
        let middle = dvec3(0.5, 0.5, 0.0);
        let lens = Lens::Orthographic { height: 2.0 };
        let scene = scene(surface, middle + DVec3::Z, middle, DVec3::Y, lens);
        let coverage = seen(&scene, UVec2::splat(40));
        // One unit is 20 pixels: the square covers 10 … 30, the slot lies between 19 and 20.
        for (i, pixel) in coverage.pixels.iter().enumerate() {
            let (x, y) = (i % 40, i / 40);
            let within = |low, high| (low..high).contains(&x) && (low..high).contains(&y);
            let expected = if within(11, 29) && x != 19 && x != 20 {
                Cover::Inside
            } else if within(10, 30) {
                Cover::Border
            } else if within(9, 31) {
                Cover::Beside
            } else {
                Cover::Background
            };
            assert_eq!(*pixel, expected, "({x}, {y})");
        }
    }

    #[test]
    fn a_plain_that_passes_under_the_eye_ends_at_its_far_border() {
        let surface = plane(DVec2::splat(-100.0), DVec2::splat(100.0));
        let lens = Lens::Perspective { fov_y_radians: 1.0 };
        let eye = DVec3::Z;
        let scene = scene(surface, eye, dvec3(1.0, 0.2, 0.98), DVec3::Z, lens);
        let size = UVec2::new(120, 90);
        let projection = scene.projection(size.x, size.y);
        let to_world = (projection.projection * projection.view).inverse();
        let hits = |x: f64, y: f64| {
            let ndc = dvec2(x, y) / size.as_dvec2() * dvec2(2.0, -2.0) + dvec2(-1.0, 1.0);
            let near = to_world.project_point3(ndc.extend(-1.0));
            let far = to_world.project_point3(ndc.extend(1.0));
            let t = near.z / (near.z - far.z);
            let place = near.lerp(far, t);
            (0.0..1.0).contains(&t) && place.abs().max_element() <= 100.0
        };
        let coverage = seen(&scene, size);
        let mut counts = [0; 2];
        for (i, pixel) in coverage.pixels.iter().enumerate() {
            let (x, y) = ((i % 120) as f64 + 0.5, (i / 120) as f64 + 0.5);
            let expected = hits(x, y);
            let sure = [-0.05, 0.05].iter().all(|d| hits(x + d, y + d) == expected);
            assert!(!sure || pixel.covered() == expected, "({x}, {y})");
            counts[usize::from(pixel.covered())] += 1;
        }
        assert!(counts.iter().all(|count| *count > 3_000), "{counts:?}");
    }

    #[test]
    fn shapes_and_holes_are_where_the_renderer_has_them() {
        for (file, method) in [
            ("surfaces/teapot.bpt", Method::Exact),
            ("scenes/thesis/fig29.toml", Method::Thesis),
            ("scenes/gallery/lettering.toml", Method::Exact),
        ] {
            let mut scene = Scene::load(format!("resources/{file}").as_ref()).unwrap();
            scene.settings.tessellation = Tessellation::Level(TessLevel::MAX);
            let size = UVec2::new(160, 100);
            let picture = render(&scene, size, method).unwrap();
            let projection = scene.projection(size.x, size.y);
            let coverage = coverage(&scene, &projection, size, method).unwrap();
            let mut wrong = 0;
            for (cover, pixel) in coverage.pixels.iter().zip(&picture.pixels) {
                let drawn = matches!(pixel, Pixel::Surface(_));
                wrong += usize::from(drawn != cover.covered());
                assert!(drawn || *cover != Cover::Inside);
                assert!(!drawn || *cover != Cover::Background);
            }
            let inside = coverage.pixels.iter().filter(|cover| **cover == Cover::Inside).count();
            assert!(wrong <= 8 && inside > 1_000, "{file}: {wrong} {inside}");
        }
    }

    #[test]
    fn parts_of_different_fineness_leave_no_holes() {
        // A hill seen from close above that hides no part of itself: only its border has a background.
        let mut surface = plane(DVec2::ZERO, DVec2::ONE);
        surface.set_control_point(DVec4::new(0.35, 0.3, 0.6, 1.0), 5).unwrap();
        let lens = Lens::Perspective { fov_y_radians: 1.2 };
        let size = UVec2::new(240, 160);
        let mut covered = 0;
        for i in 0..36 {
            let eye = dvec3(f64::from(i % 6) * 0.13 + 0.2, f64::from(i / 6) * 0.13 + 0.2, 0.35);
            let target = dvec3(0.5, 0.45, 0.0);
            let scene = scene(surface.clone(), eye, target, dvec3(1.0, 0.3, 0.0), lens);
            let coverage = seen(&scene, size);
            let at = |x: usize, y: usize| coverage.pixels[y * 240 + x].covered();
            for (x, y) in (1..159).flat_map(|y| (1..239).map(move |x| (x, y))) {
                let around = [at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1)];
                assert!(at(x, y) || around != [true; 4], "view {i}, ({x}, {y})");
                covered += usize::from(at(x, y));
            }
        }
        assert!(covered > 500_000, "{covered}");
    }

    #[test]
    fn loops_that_the_thesis_cannot_cut_are_refused() {
        let path = "resources/scenes/stability/trim-keep-inside.toml";
        let scene = Scene::load(path.as_ref()).unwrap();
        let projection = scene.projection(8, 8);
        let refused = |method| coverage(&scene, &projection, UVec2::splat(8), method).is_err();
        assert!(refused(Method::Thesis) && !refused(Method::Exact));
    }
}
