//! A renderer on the CPU in `f64` that makes the pictures with which the tests compare. It shares no
//! evaluation, trimming, lighting or rasterisation with the shaders. It shares with the GPU's renderer only the
//! input of both: the scene, the camera's matrices, the sorting of loops into the thesis' forms, and the number
//! of sub-patches that a patch is cut into.
//!
//! It cuts patches into the same triangles at the same level, because a picture at a level shows these
//! triangles. OpenGL leaves open which diagonal a cell of the tessellation gets; here it is the one of
//! Direct3D's reference tessellator, which Mesa's drivers contain. Lines are drawn by stepping along their
//! longer axis; OpenGL leaves the choice of their pixels to the driver.

mod analysis;
mod coverage;
mod raster;
mod rays;
mod sampler;
mod shading;

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4, UVec2};

use crate::bezier::{Patch, homogeneous};
use crate::camera::ViewProjection;
use crate::error::Result;
use crate::scene::{CONTROL_POINT_PX, Image, Method, RenderSettings, Scene, Surface, TessLevel};
use crate::tessellation::{Split, SurfaceTrims};
use crate::thesis::newton::{Newton, NewtonTrims};
use crate::trim::Trims;
use raster::{Raster, Sample, Vertex};
use sampler::Sampler;

pub use crate::thesis::normal::thesis_normal;
pub use analysis::Shown;
pub use coverage::{Cover, Coverage, coverage, has_gap_near};
pub use rays::{Hit, Rays};

/// The content of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Pixel {
    /// Nothing.
    #[default]
    Background,
    /// Nothing, because the surface is cut at this point.
    Hole(Fragment),
    /// A point of a surface or of its wireframe.
    Surface(Fragment),
    /// The square of a control point.
    ControlPoint,
}

/// A point of a surface that a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// Number of the surface in the scene.
    pub surface: usize,
    /// Number of the patch in the surface.
    pub patch: usize,
    /// Place in the domain of the surface.
    pub uv: DVec2,
    /// The change of (u, v) to the next pixel on the right and to the next pixel below.
    pub uv_per_px: [DVec2; 2],
    /// Place in view space.
    pub position: DVec3,
    /// Depth in the window, −1 (near) to 1.
    pub depth: f64,
    /// Distance of the pixel's centre from the nearest edge of its triangle, in pixels.
    pub edge_px: f64,
    /// Whether u and v turn counter-clockwise on the screen.
    pub front: bool,
}

/// A picture and the content of its pixels, both row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// The colours, rounded to 8 bits.
    pub image: Image,
    /// The content of each pixel.
    pub pixels: Vec<Pixel>,
    projection: DMat4,
}

/// Renders a scene.
///
/// # Errors
/// The thesis' method is requested and cannot cut one of the loops.
pub fn render(scene: &Scene, size: UVec2, method: Method) -> Result<Picture> {
    let projection = scene.projection(size.x, size.y);
    let settings = &scene.settings;
    let mut raster = Raster::new(size, settings.background);
    let is_shown = |surface: &&Surface| !surface.hidden;
    for (number, surface) in scene.surfaces.iter().enumerate().filter(|(_, own)| is_shown(own)) {
        let view = SurfaceView::new(surface, &projection, settings, method)?;
        let report = view.is_report();
        for (patch_number, patch) in surface.patches().enumerate() {
            let level = settings.tessellation.level().get() as usize;
            let vertices = view.vertices(&patch, level);
            let Some(split) = view.split(patch_number) else { continue };
            let [low, high] = surface.patch_domain(patch_number);
            for triangle in triangles(split) {
                let corners = triangle.map(|corner| vertices[corner]);
                let mut shade = |sample: &Sample| {
                    let vertex = &sample.vertex;
                    let fragment = Fragment {
                        surface: number,
                        patch: patch_number,
                        uv: low + vertex.uv() * (high - low),
                        uv_per_px: sample.uv_per_px.map(|step| step * (high - low)),
                        position: vertex.position(),
                        depth: vertex.depth(),
                        edge_px: sample.edge_px,
                        front: sample.front,
                    };
                    let (own, alpha) = view.color(sample, &fragment);
                    let color = if view.trims.cut(fragment.uv) || alpha < 0.5 {
                        None
                    } else if settings.wireframe && (report || settings.red_lines) {
                        Some(DVec3::X)
                    } else {
                        Some(own)
                    };
                    (color, fragment)
                };
                if settings.wireframe {
                    for edge in 0..3 {
                        raster.line([corners[edge], corners[(edge + 1) % 3]], &mut shade);
                    }
                } else {
                    raster.triangle(corners, &mut shade);
                }
            }
        }
    }
    if settings.control_points {
        for surface in scene.surfaces.iter().filter(is_shown) {
            let to_clip = projection.projection * projection.view * surface.transform;
            for point in surface.control_points() {
                let clip = to_clip * homogeneous(*point);
                raster.square(clip, f64::from(CONTROL_POINT_PX), DVec3::new(0.0, 0.5, 1.0));
            }
        }
    }
    Ok(raster.into_picture(projection.projection))
}

/// The trims of a surface, as one method decides them.
#[derive(Debug, Clone)]
pub struct TrimDecision<'a> {
    trims: &'a Trims,
    /// The thesis' loops; `None` if loops are decided exactly.
    newton: Option<(Newton, NewtonTrims)>,
}

impl<'a> TrimDecision<'a> {
    /// How a method decides these trims.
    ///
    /// # Errors
    /// The thesis' method is requested and cannot cut one of the loops.
    pub fn new(trims: &'a Trims, newton: Newton, method: Method) -> Result<Self> {
        let newton = match method {
            Method::Thesis => Some((newton, NewtonTrims::of(trims)?)),
            Method::Exact => None,
        };
        Ok(Self { trims, newton })
    }

    /// Whether `uv` is cut.
    #[must_use]
    pub fn cut(&self, uv: DVec2) -> bool {
        match &self.newton {
            None => self.trims.cut(uv),
            Some((newton, loops)) => {
                self.trims.shapes_cut(uv) || (self.trims.loops_on && loops.cut(newton, uv))
            }
        }
    }

    /// Whether the decision changes within `radius_px` of a fragment. It is sampled 32 times per pixel, and
    /// around the fragment itself about as finely as `f32` can resolve. This finds an edge that runs between
    /// the pixels' centres, and a sliver of Newton's method that only rounding hits.
    #[must_use]
    pub fn changes_near(&self, fragment: &Fragment, radius_px: f64) -> bool {
        const STEPS_PER_PX: f64 = 32.0;
        const ROUNDING: f64 = 5e-8;
        let here = self.cut(fragment.uv);
        let differs = |offset: DVec2| self.cut(fragment.uv + offset) != here;
        let rounds =
            (-20..=20).flat_map(|y| (-20..=20).map(move |x| DVec2::new(x.into(), y.into())));
        let reach = (radius_px * STEPS_PER_PX).floor() as i32;
        let [right, down] = fragment.uv_per_px;
        let around = (-reach..=reach)
            .flat_map(|y| (-reach..=reach).map(move |x| DVec2::new(x.into(), y.into())))
            .map(|offset| offset / STEPS_PER_PX)
            .filter(|offset| offset.length() <= radius_px)
            .map(|offset| right * offset.x + down * offset.y);
        rounds.map(|offset| offset * ROUNDING).chain(around).any(differs)
    }
}

/// A surface with the matrices and settings of one picture.
struct SurfaceView<'a> {
    surface: &'a Surface,
    to_view: DMat4,
    projection: &'a ViewProjection,
    lamps: shading::Lamps,
    trims: TrimDecision<'a>,
    sampler: Sampler<'a>,
    method: Method,
    level: TessLevel,
    /// The exact method's trims, for the sub-patches into which it cuts a patch.
    sub_patches: Option<SurfaceTrims>,
}

impl<'a> SurfaceView<'a> {
    fn new(
        surface: &'a Surface,
        projection: &'a ViewProjection,
        settings: &RenderSettings,
        method: Method,
    ) -> Result<Self> {
        let level = settings.tessellation.level();
        let sub_patches = match method {
            Method::Thesis => {
                surface.check_for_thesis()?;
                None
            }
            Method::Exact => {
                let mut trims = SurfaceTrims::new(&surface.trims, surface.patch_grid());
                trims.fix(level);
                Some(trims)
            }
        };
        Ok(Self {
            surface,
            to_view: projection.view * surface.transform,
            projection,
            lamps: shading::Lamps::new(settings.light, projection),
            trims: TrimDecision::new(&surface.trims, settings.newton, method)?,
            sampler: Sampler::new(&surface.paint),
            method,
            level,
            sub_patches,
        })
    }

    /// The sub-patches into which a patch is cut; `None` if nothing of it is drawn.
    fn split(&self, patch: usize) -> Option<Split> {
        match &self.sub_patches {
            None => Some(Split::of(self.level)),
            Some(trims) => trims.fixed(patch).map(|fixed| fixed.split),
        }
    }

    /// Whether the report's program draws the surface, as `programs::Pipeline::ported` decides.
    fn is_report(&self) -> bool {
        self.method == Method::Thesis
            && self.surface.degree() == crate::bezier::Degree::QUARTIC
            && self.surface.shading == crate::scene::Shading::Unlit
    }

    /// The vertices of a patch at a level, row by row.
    fn vertices(&self, patch: &Patch<'_>, level: usize) -> Vec<Vertex> {
        let normal_matrix = DMat3::from_mat4(self.to_view).inverse().transpose();
        (0..(level + 1) * (level + 1))
            .map(|i| {
                let u = (i % (level + 1)) as f64 / level as f64;
                let v = (i / (level + 1)) as f64 / level as f64;
                let normal = match self.method {
                    Method::Thesis => thesis_normal(patch, u, v),
                    // The thesis computes Sv × Su.
                    Method::Exact => -true_normal(patch, u, v),
                };
                let position = self.to_view.transform_point3(patch.at(u, v).position);
                let clip = self.projection.projection * position.extend(1.0);
                let normal = (normal_matrix * normal).normalize_or_zero()
                    * DMat3::from_mat4(self.to_view).determinant().signum();
                Vertex::new(clip, position, normal, DVec2::new(u, v))
            })
            .collect()
    }

    /// The colour, and the alpha of the paint.
    fn color(&self, sample: &Sample, fragment: &Fragment) -> (DVec3, f64) {
        let vertex = &sample.vertex;
        let [low, high] = self.surface.domain();
        let place = (fragment.uv - low) / (high - low);
        let steps = fragment.uv_per_px.map(|step| step / (high - low));
        let paint = self.sampler.sample(place, steps);
        let (position, normal) = (vertex.position(), vertex.normal());
        let (shading, lamps) = (self.surface.shading, self.lamps);
        (
            shading::color(shading, paint.truncate(), position, normal, sample.upright, lamps),
            paint.w,
        )
    }
}

/// The normal. At a pole, where the tangents do not define it, its limit from the middle of the patch.
fn true_normal(patch: &Patch<'_>, u: f64, v: f64) -> DVec3 {
    const STEP: f64 = 1e-6;
    let inwards = |t: f64| t + (0.5 - t) * STEP;
    patch.normal(u, v).or_else(|| patch.normal(inwards(u), inwards(v))).unwrap_or(DVec3::ZERO)
}

/// The triangles of a square domain, as indices into rows of `level + 1` vertices. Each sub-patch has its own
/// diagonals.
fn triangles(split: Split) -> impl Iterator<Item = [usize; 3]> {
    let part = split.level as usize;
    let level = part * split.side as usize;
    let index = move |u: usize, v: usize| v * (level + 1) + u;
    (0..level * level).flat_map(move |cell| {
        let (u, v) = (cell % level, cell / level);
        let [a, b] = [index(u, v), index(u + 1, v)];
        let [c, d] = [index(u, v + 1), index(u + 1, v + 1)];
        if rises(u % part, v % part, part) {
            [[a, b, d], [a, d, c]]
        } else {
            [[a, b, c], [b, d, c]]
        }
    })
}

/// Whether the diagonal of a cell runs from its minimum (u, v) to its maximum. Diagonals point to the middle of
/// the patch. At odd levels they rise in the middle column and fall in the middle row.
fn rises(u: usize, v: usize, level: usize) -> bool {
    let middle = level / 2;
    if level.is_multiple_of(2) {
        (u < middle) == (v < middle)
    } else {
        v != middle && (u == middle || (u < middle) == (v < middle))
    }
}

impl Picture {
    /// Width and height.
    #[must_use]
    pub fn size(&self) -> UVec2 {
        UVec2::from(self.image.dimensions())
    }

    /// Which pixels lie within `radius_px` of an edge in the picture: a silhouette, or the edge of a trim, of a
    /// line or of a control point's square. There the exact place of a sample decides what is visible.
    #[must_use]
    pub fn edge_band(&self, radius_px: f64) -> Vec<bool> {
        let (width, height) = (self.image.width() as i32, self.image.height() as i32);
        let reach = radius_px.floor() as i32;
        let offsets: Vec<(i32, i32)> = (-reach..=reach)
            .flat_map(|y| (-reach..=reach).map(move |x| (x, y)))
            .filter(|(x, y)| f64::from(x * x + y * y) <= radius_px * radius_px)
            .collect();
        let at = |x: i32, y: i32| self.pixels[(y * width + x) as usize];
        (0..width * height)
            .map(|i| {
                let (x, y) = (i % width, i / width);
                offsets.iter().any(|(dx, dy)| {
                    let (x2, y2) = (x + dx, y + dy);
                    (0..width).contains(&x2)
                        && (0..height).contains(&y2)
                        && self.differ(&at(x, y), &at(x2, y2))
                })
            })
            .collect()
    }

    /// Whether two close pixels show different things: different kinds, different sides, or places further
    /// apart than a surface at a grazing angle explains.
    fn differ(&self, a: &Pixel, b: &Pixel) -> bool {
        const GRAZING: f64 = 12.0;
        match (a, b) {
            (Pixel::Background | Pixel::Hole(_), Pixel::Background | Pixel::Hole(_))
            | (Pixel::ControlPoint, Pixel::ControlPoint) => false,
            (Pixel::Surface(a), Pixel::Surface(b)) => {
                let clip_w = (self.projection * a.position.extend(1.0)).w;
                let pixel = 2.0 * clip_w / (self.projection.y_axis.y * f64::from(self.size().y));
                a.surface != b.surface
                    || a.front != b.front
                    || a.position.distance(b.position) > GRAZING * pixel.abs()
            }
            _ => true,
        }
    }
}

/// Converts 0 … 1 to 8 bits, as OpenGL does.
fn to_bytes(color: DVec4) -> [u8; 4] {
    color.to_array().map(|channel| (channel.clamp(0.0, 1.0) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::TessLevel;

    #[test]
    fn triangles_cover_every_cell_once_without_turning() {
        for level in (1..=9).chain([63, 64]) {
            let corner = |i: usize| DVec2::new((i % (level + 1)) as f64, (i / (level + 1)) as f64);
            let areas: Vec<f64> = triangles(Split::of(TessLevel::new(level as i64).unwrap()))
                .map(|[a, b, c]| (corner(b) - corner(a)).perp_dot(corner(c) - corner(a)))
                .collect();
            assert_eq!(areas.len(), 2 * level * level);
            assert!(areas.iter().all(|area| *area == 1.0));
        }
    }

    #[test]
    fn diagonals_point_to_the_middle() {
        assert!(!rises(0, 0, 1));
        assert!(rises(0, 0, 2) && rises(1, 1, 2) && !rises(0, 1, 2) && !rises(1, 0, 2));
        assert!(rises(1, 0, 3) && rises(1, 2, 3) && !rises(0, 1, 3) && !rises(2, 1, 3));
        assert!(!rises(1, 1, 3));
    }

    #[test]
    fn a_square_seen_from_above_has_the_right_pixels() {
        let text = "
            [camera]
            eye = [0.0, 2.0, 0.0]
            target = [0.0, 0.0, 0.0]
            up = [0.0, 0.0, -1.0]
            orthographic_height = 2.0
            [render]
            background = [0.0, 0.0, 0.0, 0.0]
            [[surface]]
            control_points = \"default\"
            color = [1.0, 0.5, 0.0]
            shading = \"flat\"
            [[surface.trim]]
            interval = { u = [0.5, 1.0], v = [0.5, 1.0] }";
        let scene = Scene::from_toml(text, std::path::Path::new("square.toml")).unwrap();
        let picture = render(&scene, UVec2::new(40, 40), Method::Exact).unwrap();
        // One unit is 20 pixels: the square covers 10 … 30, its upper right quarter is cut.
        for (x, y, pixel) in picture.image.enumerate_pixels() {
            let covered = (10..30).contains(&x) && (10..30).contains(&y) && !(x >= 20 && y < 20);
            let expected = if covered { [255, 128, 0, 255] } else { [0; 4] };
            assert_eq!(pixel.0, expected, "({x}, {y})");
        }
        let band = picture.edge_band(1.5);
        assert!(band[10 * 40 + 10] && band[9 * 40 + 9] && band[19 * 40 + 21]);
        assert!(!band[8 * 40 + 15] && !band[12 * 40 + 15] && !band[25 * 40 + 15]);
    }
}
