//! How far a picture deviates from the surfaces that it shows, pixel by pixel in `f64`.
//!
//! A picture's [`Aovs`] state for each pixel which point of which patch it shows. [`measure()`] evaluates that
//! point. It reports how far the point lies from the pixel's centre on the screen and how far the normal is
//! off. It also compares which pixels are drawn with the scene's [`Coverage`]. [`LeakFinder`] finds the samples
//! that see through a closed model between two of its faces. [`random_view`] makes random cameras;
//! [`in_turns`] measures the cost of drawing on a noisy machine.

mod analysis;
mod interleave;
mod leaks;
mod random;
mod screen;
mod solids;
mod views;

use glam::{DMat3, DMat4, DVec2, DVec3};

use crate::aov::Aovs;
use crate::camera::ViewProjection;
use crate::reference::{Cover, Coverage, has_gap_near};
use crate::scene::{Scene, Surface, Tessellation};

pub use analysis::{AnalysisErrors, NEAR_PX, measure_analysis};
pub use interleave::{Timing, in_turns, in_turns_by};
pub use leaks::{Leak, LeakFinder, LeakKind, LeakingEdge, Leaks, Suspects};
pub use random::Random;
pub use views::random_view;

/// The normal counts as undefined where the sine of the angle between the tangents is below this.
const PARALLEL: f64 = 1e-3;
/// It also counts as undefined where a tangent is shorter than this, relative to the patch's longest control
/// tangent.
const SHORT: f64 = 1e-4;

/// The errors of one or more pictures of their scenes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measurement {
    /// The largest distance on the screen between a pixel's centre and the point of the surface that it claims
    /// to show, in pixels. Infinite if a point is behind the eye, or if its patch or place is invalid; 0 where
    /// nothing is drawn.
    pub max_error_px: f64,
    /// The mean of these distances over the covered pixels.
    pub mean_error_px: f64,
    /// The root of the mean of their squares.
    pub rms_error_px: f64,
    /// The largest angle between a pixel's normal and the surface's, in degrees. Places where the surface's
    /// normal is not well defined are left out: those where |Su × Sv| ≤ 10⁻³ |Su| |Sv|, or where Su or Sv is
    /// shorter than 10⁻⁴ of the longest difference of neighbouring control points times the degree, all in
    /// world space. A normal of length 0 or with a NaN counts as 180°.
    pub normal_error_deg: f64,
    /// Pixels that are drawn and should not be, or that are missing.
    pub silhouette_pixels: usize,
    /// Pixels that are not drawn although they are [`Cover::Inside`] and the surface has no gap, however
    /// narrow, within 1.5 pixels or the scene's tolerance. They are also counted in
    /// [`Measurement::silhouette_pixels`].
    pub crack_pixels: usize,
    /// Pixels that show a point which a nearer surface hides. The point must lie behind the nearest surface at
    /// all pixels around it, two on each side. The difference must exceed the range of that surface's distances
    /// at these pixels plus a ten-thousandth of the distance.
    pub hidden_pixels: usize,
    /// NaN and infinite values in all AOVs, and numbers of patches that do not exist.
    pub bad_values: usize,
    /// Pixels that are drawn.
    pub covered: usize,
    /// Pixels that should be drawn.
    pub expected: usize,
}

impl Measurement {
    /// Combines the results of two sets of pictures: the larger of the maxima, the means over all covered
    /// pixels, and the sums of the counts.
    #[must_use]
    pub fn merge(&self, other: &Self) -> Self {
        let covered = self.covered + other.covered;
        let mean = |of: fn(&Self) -> f64| {
            let sum =
                |one: &Self| if one.covered == 0 { 0.0 } else { of(one) * one.covered as f64 };
            (sum(self) + sum(other)) / covered.max(1) as f64
        };
        Self {
            max_error_px: self.max_error_px.max(other.max_error_px),
            mean_error_px: mean(|one| one.mean_error_px),
            rms_error_px: mean(|one| one.rms_error_px * one.rms_error_px).sqrt(),
            normal_error_deg: self.normal_error_deg.max(other.normal_error_deg),
            silhouette_pixels: self.silhouette_pixels + other.silhouette_pixels,
            crack_pixels: self.crack_pixels + other.crack_pixels,
            hidden_pixels: self.hidden_pixels + other.hidden_pixels,
            bad_values: self.bad_values + other.bad_values,
            covered,
            expected: self.expected + other.expected,
        }
    }
}

/// Measures a picture of a scene, seen through `projection`. `reference` is the scene's
/// [`crate::reference::coverage`] of the same size. Pixels are drawn where the alpha of
/// [`Aovs::uv`] is not 0.
///
/// # Panics
/// If the pictures have different sizes.
#[must_use]
pub fn measure(
    scene: &Scene,
    projection: &ViewProjection,
    aovs: &Aovs,
    reference: &Coverage,
) -> Measurement {
    assert_eq!(aovs.size, reference.size, "sizes of the measured picture and the reference");
    let mut distances = vec![f64::NEG_INFINITY; aovs.uv.len()];
    let mut all = measure_points(scene, projection, aovs, |i, distance| distances[i] = distance);
    for (i, (cover, uv)) in reference.pixels.iter().zip(&aovs.uv).enumerate() {
        let drawn = uv[3] != 0.0;
        all.expected += usize::from(cover.covered());
        all.silhouette_pixels += usize::from(drawn != cover.covered());
        let pixel = [i as u32 % aovs.size.0, i as u32 / aovs.size.0];
        all.crack_pixels += usize::from(
            !drawn && *cover == Cover::Inside && !shows_a_gap(scene, projection, aovs.size, pixel),
        );
        all.hidden_pixels += usize::from(drawn && is_hidden(reference, distances[i], pixel));
    }
    all
}

/// Whether the point that a pixel shows lies behind the nearest surface at all pixels around it, two on each
/// side. The difference must exceed the range of that surface's distances at these pixels.
fn is_hidden(reference: &Coverage, shown: f64, [x, y]: [u32; 2]) -> bool {
    /// Relative to the distance: surfaces that are closer together than this may swap their order by rounding.
    const MARGIN: f64 = 1e-4;
    let (width, height) = reference.size;
    let at = |x: u32, y: u32| (y * width + x) as usize;
    let around = (y.saturating_sub(2)..(y + 3).min(height))
        .flat_map(|y| (x.saturating_sub(2)..(x + 3).min(width)).map(move |x| (x, y)));
    let (min, max) = around
        .map(|(x, y)| reference.distances[at(x, y)])
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), distance| {
            (min.min(distance), max.max(distance))
        });
    shown - max > max - min + MARGIN * max.abs()
}

/// Measures what is drawn in a picture of a scene, as [`measure()`] does, but not what is missing: without a
/// reference, it reports no errors of silhouettes and no cracks.
#[must_use]
pub fn measure_drawn(scene: &Scene, projection: &ViewProjection, aovs: &Aovs) -> Measurement {
    measure_points(scene, projection, aovs, |_, _| {})
}

/// Measures what is drawn, and passes on the distance along the view axis of the point that each pixel claims
/// to show.
fn measure_points(
    scene: &Scene,
    projection: &ViewProjection,
    aovs: &Aovs,
    mut with_distance: impl FnMut(usize, f64),
) -> Measurement {
    let patches: Vec<Seen<'_>> =
        scene.surfaces.iter().flat_map(|surface| Seen::of(surface, projection)).collect();
    let mut all = Measurement { bad_values: count_bad(aovs), ..Measurement::default() };
    let size = DVec2::new(f64::from(aovs.size.0), f64::from(aovs.size.1));
    let (mut total_px, mut total_squares) = (0.0, 0.0);
    for (i, uv) in aovs.uv.iter().enumerate().filter(|(_, uv)| uv[3] != 0.0) {
        all.covered += 1;
        let [.., number, _] = uv.map(f64::from);
        let [u, v] = aovs.patch_uv[i].map(f64::from);
        let patch = (number >= 0.0).then(|| patches.get(number.round() as usize)).flatten();
        let (error_px, normal_error_deg) = if let Some(patch) = patch {
            let width = aovs.size.0 as usize;
            let center = DVec2::new((i % width) as f64 + 0.5, (i / width) as f64 + 0.5);
            let [x, y, z, _] = aovs.normal[i].map(f64::from);
            with_distance(i, patch.distance(u, v));
            patch.errors(u, v, (center, size), DVec3::new(x, y, z))
        } else {
            all.bad_values += usize::from(number.is_finite());
            (f64::INFINITY, None)
        };
        total_px += error_px;
        total_squares += error_px * error_px;
        all.max_error_px = all.max_error_px.max(error_px);
        all.normal_error_deg = all.normal_error_deg.max(normal_error_deg.unwrap_or(0.0));
    }
    all.mean_error_px = total_px / all.covered.max(1) as f64;
    all.rms_error_px = (total_squares / all.covered.max(1) as f64).sqrt();
    all
}

/// Whether the surface itself has a gap that may show at this pixel: one within 1.5 pixels or the scene's
/// tolerance.
fn shows_a_gap(
    scene: &Scene,
    projection: &ViewProjection,
    size: (u32, u32),
    pixel: [u32; 2],
) -> bool {
    let settings = &scene.settings;
    let radius_px = match settings.tessellation {
        Tessellation::Within(tolerance) => tolerance.pixels().max(1.5),
        Tessellation::Level(_) => 1.5,
    };
    has_gap_near(scene, projection, size.into(), pixel, radius_px, settings.method).unwrap_or(false)
}

fn count_bad(aovs: &Aovs) -> usize {
    crate::aov::AovKind::ALL
        .iter()
        .flat_map(|kind| aovs.channel(*kind).as_flattened())
        .filter(|value| !value.is_finite())
        .count()
}

/// A patch as seen in a picture.
struct Seen<'a> {
    surface: &'a Surface,
    /// The number of the patch in the surface.
    patch: usize,
    to_view: DMat4,
    to_clip: DMat4,
    /// Model space to world space, for tangents.
    to_world: DMat3,
    /// The longest tangent of the control net in world space.
    tangent: f64,
}

impl<'a> Seen<'a> {
    fn of(surface: &'a Surface, projection: &ViewProjection) -> impl Iterator<Item = Self> {
        let to_view = projection.view * surface.transform;
        let to_clip = projection.projection * to_view;
        let to_world = DMat3::from_mat4(surface.transform);
        surface.patches().enumerate().map(move |(number, patch)| {
            let columns = patch.degree().columns();
            let steps = patch.degree().u().max(patch.degree().v());
            let points = patch.points();
            let step = |from: usize, to: usize| {
                (to_world * (points[to] - points[from]).truncate()).length()
            };
            let longest = (0..points.len())
                .flat_map(|i| {
                    let along_u = (i % columns + 1 < columns).then(|| step(i, i + 1));
                    let along_v = (i + columns < points.len()).then(|| step(i, i + columns));
                    along_u.into_iter().chain(along_v)
                })
                .fold(0.0, f64::max);
            let tangent = longest * steps as f64;
            Self { surface, patch: number, to_view, to_clip, to_world, tangent }
        })
    }

    /// The distance of a point along the view axis.
    fn distance(&self, u: f64, v: f64) -> f64 {
        -self.to_view.transform_point3(self.surface.at(self.patch, u, v).position).z
    }

    /// The distance of the point from a pixel's centre, in pixels, and the angle between its normal and
    /// `normal` in degrees, if it has a normal.
    fn errors(
        &self,
        u: f64,
        v: f64,
        (center, size): (DVec2, DVec2),
        normal: DVec3,
    ) -> (f64, Option<f64>) {
        let point = self.surface.at(self.patch, u, v);
        let clip = self.to_clip * point.position.extend(1.0);
        let ndc = clip.truncate().truncate() / clip.w;
        let place = DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size;
        let distance = place.distance(center);
        let error_px = if clip.w > 0.0 && distance.is_finite() { distance } else { f64::INFINITY };

        let (du, dv) = (self.to_world * point.du, self.to_world * point.dv);
        let cross = du.cross(dv);
        let has_normal = cross.length() > PARALLEL * du.length() * dv.length()
            && du.length().min(dv.length()) >= SHORT * self.tangent;
        (error_px, has_normal.then(|| angle_deg(normal, cross)))
    }
}

/// The angle between two vectors in degrees; 180 if one of them has no direction.
fn angle_deg(a: DVec3, b: DVec3) -> f64 {
    let (sine, cosine) = (a.cross(b).length(), a.dot(b));
    // The result is also 180 if one of the vectors contains a NaN.
    if sine > 0.0 || cosine > 0.0 { sine.atan2(cosine).to_degrees() } else { 180.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::Degree;
    use crate::camera::{Camera, Lens};
    use crate::reference::coverage;
    use crate::scene::Method;
    use glam::{DVec4, UVec2, dvec2, dvec3};

    const SIDE: usize = 40;

    /// A unit square in z = 0 with x = u and y = v, seen from above at 20 pixels per unit. The square covers
    /// pixels 10 … 30.
    fn square() -> (Scene, ViewProjection) {
        let points = (0..16)
            .map(|i| DVec4::new(f64::from(i % 4) / 3.0, f64::from(i / 4) / 3.0, 0.0, 1.0))
            .collect();
        let middle = dvec3(0.5, 0.5, 0.0);
        let lens = Lens::Orthographic { height: 2.0 };
        let camera = Camera::new(middle + DVec3::Z, middle, DVec3::Y, lens).unwrap();
        let scene = Scene {
            surfaces: vec![Surface::new(Degree::CUBIC, points).unwrap()],
            camera: Some(camera),
            ..Scene::listing16()
        };
        let projection = scene.projection(SIDE as u32, SIDE as u32);
        (scene, projection)
    }

    fn aovs_of_square() -> Aovs {
        let mut aovs = Aovs::empty((SIDE as u32, SIDE as u32));
        for i in 0..SIDE * SIDE {
            let place = |pixel: usize| (pixel as f32 + 0.5 - 10.0) / 20.0;
            let (u, v) = (place(i % SIDE), 1.0 - place(i / SIDE));
            if (0.0..1.0).contains(&u) && (0.0..1.0).contains(&v) {
                aovs.uv[i] = [u, v, 0.0, 1.0];
                aovs.patch_uv[i] = [u, v];
                aovs.position[i] = [u, v, 0.0, 1.0];
                aovs.normal[i] = [0.0, 0.0, 1.0, 1.0];
                aovs.depth[i] = [1.0; 4];
            }
        }
        aovs
    }

    fn measured(aovs: &Aovs) -> Measurement {
        let (scene, projection) = square();
        let reference =
            coverage(&scene, &projection, UVec2::splat(SIDE as u32), Method::Exact).unwrap();
        measure(&scene, &projection, aovs, &reference)
    }

    #[test]
    fn a_perfect_picture_has_no_errors() {
        let all = measured(&aovs_of_square());
        assert!(all.max_error_px < 1e-5 && all.normal_error_deg < 1e-5, "{all:?}");
        let none = Measurement { covered: 400, expected: 400, ..Measurement::default() };
        let counts = Measurement {
            max_error_px: 0.0,
            mean_error_px: 0.0,
            rms_error_px: 0.0,
            normal_error_deg: 0.0,
            ..all
        };
        assert_eq!(counts, none);
    }

    #[test]
    fn what_is_hidden_by_a_nearer_surface_is_found() {
        let (mut scene, projection) = square();
        // A copy of the square's lower half, at half the distance from the eye.
        let mut nearer = scene.surfaces[0].clone();
        nearer.transform =
            DMat4::from_translation(dvec3(0.0, 0.0, 0.5)) * DMat4::from_scale(dvec3(1.0, 0.5, 1.0));
        scene.surfaces.push(nearer);
        let size = UVec2::splat(SIDE as u32);
        // In this perspective, one unit is 20 pixels at distance 1.
        let eye = dvec3(0.5, 0.5, 1.0);
        let lens = Lens::Perspective { fov_y_radians: 2.0 * 1_f64.atan() };
        let camera = Camera::new(eye, eye - DVec3::Z, DVec3::Y, lens).unwrap();
        let perspective =
            camera.projection(scene.surfaces.iter().flat_map(Surface::world_points), 1.0);
        // The copy covers 20 columns and 10 rows of the square. Those within two pixels of the border do not
        // count. In perspective, the copy extends beyond the square except at its upper border.
        for (seen, expected) in [(projection, 16 * 6), (perspective, 20 * 8)] {
            let reference = coverage(&scene, &seen, size, Method::Exact).unwrap();
            let found = measure(&scene, &seen, &aovs_of_square(), &reference);
            assert_eq!(found.hidden_pixels, expected);
        }
        assert_eq!(measured(&aovs_of_square()).hidden_pixels, 0);
    }

    #[test]
    fn a_shifted_place_is_so_many_pixels_off() {
        let mut aovs = aovs_of_square();
        let drawn = aovs.uv.iter().map(|uv| uv[3] != 0.0);
        for (i, (uv, _)) in
            aovs.patch_uv.iter_mut().zip(drawn).enumerate().filter(|(_, (_, on))| *on)
        {
            // 3 pixels to the right, and in the left half also 4 pixels up.
            uv[0] += 0.15;
            uv[1] += if i % SIDE < 20 { 0.2 } else { 0.0 };
        }
        let all = measured(&aovs);
        assert!((all.max_error_px - 5.0).abs() < 1e-5, "{all:?}");
        assert!((all.mean_error_px - 4.0).abs() < 1e-5, "{all:?}");
        // Half of the pixels are 3 pixels off, the others 5.
        assert!((all.rms_error_px - 17.0_f64.sqrt()).abs() < 1e-5, "{all:?}");
    }

    #[test]
    fn the_normal_that_is_turned_most_is_found() {
        let mut aovs = aovs_of_square();
        let degrees = |angle: f32| {
            let (sine, cosine) = angle.to_radians().sin_cos();
            [0.0, sine, cosine, 1.0]
        };
        aovs.normal[15 * SIDE + 15] = degrees(7.0);
        aovs.normal[15 * SIDE + 16] = degrees(-20.0);
        assert!((measured(&aovs).normal_error_deg - 20.0).abs() < 1e-4);
        aovs.normal[15 * SIDE + 17] = [0.0, 0.0, -1.0, 1.0];
        assert!((measured(&aovs).normal_error_deg - 180.0).abs() < 1e-4);
        aovs.normal[15 * SIDE + 17] = [0.0, 0.0, 0.0, 1.0];
        assert_eq!(measured(&aovs).normal_error_deg, 180.0);
    }

    #[test]
    fn normals_follow_transforms_and_are_left_out_at_poles() {
        let (mut scene, _) = square();
        // Mirrored and sheared: Su = (−2, 0, 0), Sv = (0, 1, 1).
        scene.surfaces[0].transform = DMat4::from_cols(
            DVec4::new(-2.0, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 1.0, 1.0, 0.0),
            DVec4::new(0.0, 0.0, 1.0, 0.0),
            DVec4::W,
        );
        let projection = scene.projection(8, 8);
        let place = (DVec2::ZERO, DVec2::ONE);
        let expected = dvec3(-2.0, 0.0, 0.0).cross(dvec3(0.0, 1.0, 1.0)).normalize();
        let error = |scene: &Scene, v: f64| {
            let seen = Seen::of(&scene.surfaces[0], &projection).next().unwrap();
            seen.errors(0.5, v, place, expected).1
        };
        assert!(error(&scene, 0.5).unwrap() < 1e-6);
        for i in 0..4 {
            scene.surfaces[0].set_control_point(DVec4::W, i).unwrap();
        }
        assert!(error(&scene, 0.0).is_none() && error(&scene, 0.5).is_some());
        // Right beside the pole Su is too short, but not further away from it.
        assert!(error(&scene, 1e-5).is_none() && error(&scene, 1e-3).is_some());
    }

    #[test]
    fn a_hole_inside_is_a_crack_and_one_at_the_border_is_not() {
        for (x, y, cracks) in [(20, 20, 1), (11, 28, 1), (10, 20, 0), (29, 29, 0)] {
            let mut aovs = aovs_of_square();
            aovs.uv[y * SIDE + x] = [0.0; 4];
            let all = measured(&aovs);
            assert_eq!((all.silhouette_pixels, all.crack_pixels), (1, cracks), "({x}, {y})");
            assert_eq!((all.covered, all.expected), (399, 400));
        }
        let mut aovs = aovs_of_square();
        aovs.uv[9 * SIDE + 20] = [0.525, 1.0, 0.0, 1.0];
        aovs.patch_uv[9 * SIDE + 20] = [0.525, 1.0];
        let all = measured(&aovs);
        assert_eq!((all.silhouette_pixels, all.crack_pixels), (1, 0));
        assert!((all.max_error_px - 0.5).abs() < 1e-5);
    }

    #[test]
    fn numbers_that_are_none_are_counted() {
        let mut aovs = aovs_of_square();
        aovs.depth[0][1] = f32::NAN;
        aovs.position[20 * SIDE + 20] = [f32::INFINITY; 4];
        aovs.normal[20 * SIDE + 20][0] = f32::NAN;
        let all = measured(&aovs);
        assert_eq!((all.bad_values, all.normal_error_deg), (6, 180.0));
        assert!(all.max_error_px < 1e-5);
        for number in [-1.0, 1.0, f32::NAN] {
            aovs.uv[20 * SIDE + 20][2] = number;
            let all = measured(&aovs);
            assert_eq!((all.bad_values, all.max_error_px), (7, f64::INFINITY), "{number}");
        }
    }

    #[test]
    fn points_behind_the_eye_are_infinitely_far_off() {
        let (scene, _) = square();
        let lens = Lens::Perspective { fov_y_radians: 1.0 };
        let eye = dvec3(0.5, 0.5, 1.0);
        for (target, behind) in [(dvec3(0.5, 0.5, 0.0), false), (dvec3(0.5, 0.5, 2.0), true)] {
            let projection = Camera::new(eye, target, DVec3::Y, lens)
                .unwrap()
                .projection([DVec3::ZERO, DVec3::Z * 5.0].into_iter(), 1.0);
            let seen = Seen::of(&scene.surfaces[0], &projection).next().unwrap();
            let (error_px, _) =
                seen.errors(0.5, 0.5, (dvec2(5.0, 5.0), dvec2(10.0, 10.0)), DVec3::Z);
            assert_eq!(error_px.is_infinite(), behind);
            assert!(behind || error_px < 1e-12);
        }
    }

    #[test]
    fn pictures_merge_by_their_pixels() {
        let one = Measurement {
            max_error_px: 2.0,
            mean_error_px: 1.0,
            rms_error_px: 1.0,
            normal_error_deg: 3.0,
            silhouette_pixels: 4,
            crack_pixels: 1,
            hidden_pixels: 3,
            bad_values: 2,
            covered: 100,
            expected: 101,
        };
        let other = Measurement {
            max_error_px: 1.0,
            mean_error_px: 0.5,
            rms_error_px: 15.0,
            normal_error_deg: 9.0,
            covered: 300,
            ..one
        };
        let expected = Measurement {
            max_error_px: 2.0,
            mean_error_px: 0.625,
            rms_error_px: 13.0,
            normal_error_deg: 9.0,
            silhouette_pixels: 8,
            crack_pixels: 2,
            hidden_pixels: 6,
            bad_values: 4,
            covered: 400,
            expected: 202,
        };
        assert_eq!(one.merge(&other), expected);
        assert_eq!(one.merge(&Measurement::default()), one);
        assert_eq!(Measurement::default().merge(&Measurement::default()), Measurement::default());
    }
}
