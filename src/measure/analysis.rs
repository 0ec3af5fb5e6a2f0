//! Whether the pixels of an analysis show what the true surfaces show there.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, dvec2};

use image::Rgba;

use crate::aov::Aovs;
use crate::bezier::CurvedPoint;
use crate::camera::ViewProjection;
use crate::parallel;
use crate::reference::{Rays, Shown};
use crate::scene::{Analysis, Image, Scene, Surface};

/// The pixels of a picture of an analysis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AnalysisErrors {
    /// Pixels that were compared.
    pub compared: usize,
    /// Pixels of another colour than the true surface has at the pixel's centre: by more than one of 255 levels in a
    /// channel.
    pub wrong: usize,
    /// Pixels that were not compared because the border of a stripe passes within about [`NEAR_PX`] of their centre.
    pub at_borders: usize,
    /// Pixels that are drawn, but at whose centre there is no surface, or none with a normal.
    pub beside: usize,
}

/// How near to the border of a stripe pixels are not compared.
pub const NEAR_PX: f64 = 0.1;

/// The steps of Newton's method until a point of the surface is at the centre of a pixel.
const STEPS: usize = 30;
/// How far it may be off, in pixels.
const OFF_PX: f64 = 1e-7;

impl AnalysisErrors {
    /// The sums of both.
    #[must_use]
    pub const fn merge(&self, other: &Self) -> Self {
        Self {
            compared: self.compared + other.compared,
            wrong: self.wrong + other.wrong,
            at_borders: self.at_borders + other.at_borders,
            beside: self.beside + other.beside,
        }
    }
}

/// Compares the picture of an analysis with the true surfaces of the scene, in `f64`. `aovs` tell which surface each pixel
/// shows, and about where; the picture and they have one sample per pixel. `limit` is the curvature at the end of the
/// scale. Also returns the picture as it should be; pixels without a surface are transparent in it.
///
/// # Panics
/// If the pictures have different sizes.
#[must_use]
pub fn measure_analysis(
    scene: &Scene,
    camera: &ViewProjection,
    (analysis, limit): (&Analysis, f64),
    aovs: &Aovs,
    image: &Image,
) -> (AnalysisErrors, Image) {
    assert_eq!(aovs.size, image.dimensions(), "sizes of the picture and its AOVs");
    let judge = Judge::new(scene, camera, analysis, limit, aovs);
    let (width, height) = aovs.size;
    let rows = parallel::map(height as usize, |row| {
        let mut errors = AnalysisErrors::default();
        let mut colors = vec![[0; 4]; width as usize];
        for (column, color) in colors.iter_mut().enumerate() {
            let i = row * width as usize + column;
            if aovs.uv[i][3] == 0.0 {
                continue;
            }
            let center = dvec2(column as f64 + 0.5, row as f64 + 0.5);
            let Some(Look { color: [red, green, blue], at_border }) = judge.look(i, center) else {
                errors.beside += 1;
                continue;
            };
            *color = [red, green, blue, 255];
            let pixel = image.get_pixel(column as u32, row as u32).0;
            let is_off = pixel.iter().zip(*color).any(|(a, b)| a.abs_diff(b) > 1);
            errors.at_borders += usize::from(at_border);
            errors.compared += usize::from(!at_border);
            errors.wrong += usize::from(!at_border && is_off);
        }
        (errors, colors)
    });
    let mut all = AnalysisErrors::default();
    let mut expected = Image::new(width, height);
    for (row, (errors, colors)) in rows.iter().enumerate() {
        all = all.merge(errors);
        for (column, color) in colors.iter().enumerate() {
            expected.put_pixel(column as u32, row as u32, Rgba(*color));
        }
    }
    (all, expected)
}

/// What the true surface shows at a pixel.
struct Look {
    color: [u8; 3],
    /// Whether a stripe ends there.
    at_border: bool,
}

struct Judge<'a> {
    scene: &'a Scene,
    camera: &'a ViewProjection,
    analysis: &'a Analysis,
    limit: f64,
    aovs: &'a Aovs,
    /// From the clip space of the picture to pixels from its upper left corner.
    half: DVec2,
    /// The number of the first patch of each surface.
    firsts: Vec<usize>,
    rays: Rays<'a>,
}

impl<'a> Judge<'a> {
    fn new(
        scene: &'a Scene,
        camera: &'a ViewProjection,
        analysis: &'a Analysis,
        limit: f64,
        aovs: &'a Aovs,
    ) -> Self {
        let firsts = scene.surfaces.iter().scan(0, |next, surface| {
            *next += surface.patches().len();
            Some(*next - surface.patches().len())
        });
        let half = 0.5 * dvec2(aovs.size.0.into(), aovs.size.1.into());
        let (firsts, rays) = (firsts.collect(), Rays::new(scene));
        Self { scene, camera, analysis, limit, aovs, half, firsts, rays }
    }

    /// `None` if no surface with a normal is there.
    fn look(&self, i: usize, center: DVec2) -> Option<Look> {
        let shown = self.shown(i, center)?;
        let at_border = match shown {
            Shown::Scale(_) => false,
            Shown::Stripes(place) => {
                let is_other = |other: Option<Shown>| {
                    let same = |other| matches!(other, Shown::Stripes(other) if other.floor() == place.floor());
                    !other.is_some_and(same)
                };
                let steps = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
                steps.into_iter().any(|step| is_other(self.shown(i, center + NEAR_PX * step)))
            }
        };
        Some(Look { color: shown.color(self.analysis), at_border })
    }

    /// What is shown at a place of the picture, near the centre of a pixel.
    fn shown(&self, i: usize, place: DVec2) -> Option<Shown> {
        let patch = self.aovs.uv[i][2].round() as usize;
        let number = self.firsts.partition_point(|first| *first <= patch).checked_sub(1)?;
        let patch = patch - self.firsts[number];
        let surface = &self.scene.surfaces[number];
        let [low, high] = surface.patch_domain(patch);
        let [u, v] = self.aovs.patch_uv[i].map(f64::from);
        let uv = low + dvec2(u, v) * (high - low);
        let point = match self.meet(surface, patch, uv, place) {
            Some((uv, point)) if !surface.trims.cut(uv) => point,
            _ => self.cast(place)?,
        };
        Shown::at(self.analysis, self.limit, self.camera, &point)
    }

    /// The point of a surface that is seen at a place of the picture, and its parameters, from parameters nearby.
    fn meet(
        &self,
        surface: &Surface,
        patch: usize,
        mut uv: DVec2,
        place: DVec2,
    ) -> Option<(DVec2, CurvedPoint)> {
        let to_clip = self.camera.projection * self.camera.view;
        let [low, high] = surface.domain();
        for _ in 0..STEPS {
            let point = in_world(surface, patch, uv);
            let clip = to_clip * point.at.position.extend(1.0);
            let seen = self.seen(clip);
            let off = place - seen;
            let is_inside = uv.cmpge(low).all() && uv.cmple(high).all();
            if off.length() < OFF_PX {
                return is_inside.then_some((uv, point));
            }
            let along = |derivative: DVec3| self.moved(clip, to_clip * derivative.extend(0.0));
            let grid = surface.patch_grid().map_or(patch, |grid| grid.patch_at(uv));
            let [first, last] = surface.patch_domain(grid);
            let (a, b) = (along(point.at.du), along(point.at.dv));
            let step = dvec2(off.perp_dot(b), a.perp_dot(off)) / a.perp_dot(b) * (last - first);
            if !step.is_finite() {
                return None;
            }
            uv += step;
            // A little outside, so that a place beyond the border is noticed.
            let margin = 1e-3 * (high - low);
            uv = uv.clamp(low - margin, high + margin);
        }
        None
    }

    /// The place of a point in the picture, in pixels from its upper left corner.
    fn seen(&self, clip: DVec4) -> DVec2 {
        (DVec2::ONE + dvec2(clip.x, -clip.y) / clip.w) * self.half
    }

    /// How the place of a point changes.
    fn moved(&self, clip: DVec4, change: DVec4) -> DVec2 {
        let moved = (change.truncate().truncate() - clip.truncate().truncate() * change.w / clip.w)
            / clip.w;
        dvec2(moved.x, -moved.y) * self.half
    }

    /// The nearest surface at a place of the picture.
    fn cast(&self, place: DVec2) -> Option<CurvedPoint> {
        let ndc = dvec2(place.x, self.aovs.size.1 as f64 - place.y) / self.half - DVec2::ONE;
        let to_world: DMat4 = (self.camera.projection * self.camera.view).inverse();
        let [near, far] = [-1.0, 0.9].map(|depth| to_world.project_point3(ndc.extend(depth)));
        let hit = self.rays.cast(near, far - near)?;
        Some(in_world(&self.scene.surfaces[hit.surface], hit.patch, hit.uv))
    }
}

/// A point of a surface, in world space.
fn in_world(surface: &Surface, patch: usize, uv: DVec2) -> CurvedPoint {
    let mut point = surface.curved_at(patch, uv).mapped(&DMat3::from_mat4(surface.transform));
    point.at.position = surface.transform.transform_point3(point.at.position);
    point
}
