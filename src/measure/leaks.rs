//! Leaks: samples that see through a closed model where two of its faces meet.
//!
//! Each face is drawn within the tolerance, so two faces that share an edge may leave a crack between them in which a
//! sample shows the background, or what the model hides, such as its inside.
//!
//! **What a leak is.** The eye sees the first point of the true surfaces along its ray: it crosses no surface before.
//! What a sample shows is right if it is the first point of any ray within the tolerance on the screen, because
//! points may move by the tolerance. A sample is a leak if it is right for none of these rays: each of them meets the
//! model, and the sample shows nothing, or a point that lies deeper than the first points of all of them. (A back side
//! that shows through a crack has crossed the surface an odd number of times and is deeper than the first crossing.)
//! A sample whose rays meet the model only in part lies at a silhouette, which may move, or at an open edge, and is not
//! judged. Nor is one whose face is seen within the tolerance and goes on behind what hides it: that silhouette may move. The rays are those on circles of the tolerance and of half of it, and the one through the very point that
//! the sample shows.
//!
//! **Gaps of the data.** The borders of two faces meet only as far as the model's data do, so that a ray at a shared
//! edge may pass between the true faces. Rays that are no further from a shared edge than the gap along it decide
//! nothing, and the circles around a sample at the edge are larger by twice the gap: the rays beyond it decide.
//!
//! **Which samples are looked at.** A crack lies between what is drawn on both sides of it, and is no wider than twice
//! the tolerance and the gap together. Along one of four directions (rows, columns and diagonals), which are at most
//! 22.5° off the direction across the crack, a leak therefore has samples on both sides that are nearer to the eye, no
//! further away than the crack is wide. Only such samples are suspects; the others would be leaks only where a face is
//! drawn so narrow that no sample beside the crack shows it. The border of the picture counts as nearer.

use glam::{DVec2, DVec3, IVec2, UVec2};

use super::random::Random;
use super::screen::Screen;
use super::solids::{Segment, SharedEdge, Solids};
use super::views::close_up;
use crate::aov::Aovs;
use crate::camera::{Camera, ViewProjection};
use crate::parallel;
use crate::reference::Rays;
use crate::scene::Scene;

/// The rays on each circle around a sample.
const AROUND: u32 = 16;
/// How many rays of the outer circle have to decide.
const DECIDING: usize = 6;
/// The driver places vertices on a grid of 1/256 of a pixel; this is more than enough for that and the rounding.
const ROUNDING_PX: f64 = 1.0 / 16.0;
/// Rounding of a depth, as a share of it: the picture is drawn in `f32`.
const ROUNDING: f64 = 1e-6;
/// In gaps of the data that are wider than this, in pixels, leaks may be missed.
const WIDEST_GAP_PX: f64 = 16.0;
/// How far a face goes on behind a silhouette that moved by the tolerance, as a multiple of the tolerance: the steepest
/// face that is followed.
const STEEPEST: f64 = 8.0;
/// A point is drawn again so often if it is hidden.
const TRIES: usize = 16;

/// A sample of a picture that sees through a closed model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Leak {
    /// The pixel, from the upper left corner.
    pub pixel: UVec2,
    /// What it shows.
    pub kind: LeakKind,
    /// The distance of what it shows from the eye along the view axis, in world units; infinite for the background.
    pub depth: f64,
    /// The shared edge of what should be seen there that is the nearest on the screen.
    pub edge: Option<LeakingEdge>,
}

/// What a leak shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum LeakKind {
    /// Nothing.
    Background,
    /// A face from the inside of its solid.
    BackSide,
    /// A face from outside that is hidden.
    Hidden,
}

/// The edge beside a leak.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeakingEdge {
    /// The number of the model in the scene.
    pub model: usize,
    /// The number of the edge in the model.
    pub edge: usize,
    /// The distance on the screen, in pixels.
    pub distance_px: f64,
}

/// The leaks of a picture.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Leaks {
    /// The leaks, row by row.
    pub found: Vec<Leak>,
    /// An upper bound of the largest gap of the data along a shared edge in the picture, in pixels: the distance
    /// between the borders of the faces that share it.
    pub gap_px: f64,
    /// The samples that were looked at.
    pub suspects: usize,
}

/// Which samples are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Suspects {
    /// Those between two that are nearer to the eye.
    #[default]
    Between,
    /// All samples, which takes long: to check the choice.
    All,
}

/// Finds the leaks in pictures of a scene.
pub struct LeakFinder<'a> {
    scene: &'a Scene,
    rays: Rays<'a>,
    solids: Solids<'a>,
    /// The number of the first patch of each surface, and that behind the last one.
    first_patches: Vec<usize>,
}

impl std::fmt::Debug for LeakFinder<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("LeakFinder").field("rays", &self.rays).finish_non_exhaustive()
    }
}

impl<'a> LeakFinder<'a> {
    /// Looks for the shared edges of the models in a scene and measures their gaps.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        let mut first_patches = vec![0];
        for surface in &scene.surfaces {
            first_patches.push(first_patches[first_patches.len() - 1] + surface.patches().len());
        }
        Self { scene, rays: Rays::new(scene), solids: Solids::new(scene), first_patches }
    }

    /// The number of edges of the models that their faces use an odd number of times, and of faces that end without
    /// an edge. Faces that are hidden or left out do not count. Products with such edges are not closed: they are not
    /// judged.
    #[must_use]
    pub const fn open_edges(&self) -> usize {
        self.solids.open_edges
    }

    /// Whether the scene has a closed product.
    #[must_use]
    pub fn has_closed(&self) -> bool {
        self.solids.is_closed.contains(&true)
    }

    /// A close-up of a random point of a random shared edge, which is in the middle of the picture: the camera of the
    /// scene, from a random direction, narrowed so that 1/`zoom` of the height of the framed scene is seen. Points that
    /// the scene hides are avoided. The same `seed` and `index` always give the same camera. `None` without a shared
    /// edge.
    #[must_use]
    pub fn close_up(&self, seed: u64, index: u64, aspect: f64, zoom: f64) -> Option<Camera> {
        let mut random = Random(Random(seed).next().wrapping_add(index));
        let own = self.scene.camera.unwrap_or_else(|| self.scene.framed(aspect));
        let mut chosen = None;
        for _ in 0..TRIES {
            let edge = self.solids.edges.get(random.below(self.solids.edges.len().max(1)))?;
            let [low, high] = edge.range()?;
            let point = edge.at(random.between(low, high));
            let back = random.direction() * own.eye().distance(own.target());
            let turned = Camera::new(own.target() + back, own.target(), own.up(), own.lens());
            let framed = self.scene.fitted(&turned.unwrap_or(own), aspect);
            let camera = close_up(&framed, point, zoom).unwrap_or(framed);
            chosen = Some(camera);
            if self.shows(&camera, point, aspect) {
                break;
            }
        }
        chosen
    }

    /// Whether nothing hides a point in the middle of the picture.
    fn shows(&self, camera: &Camera, point: DVec3, aspect: f64) -> bool {
        /// As a share of the distance between the clip planes.
        const BEFORE: f64 = 1e-6;
        let points = self.scene.surfaces.iter().flat_map(|surface| surface.world_points());
        let screen = Screen::new(&camera.projection(points, aspect), (2, 2));
        let [origin, direction] = screen.ray(DVec2::ONE);
        let distance = (point - origin).dot(direction) / direction.length_squared();
        self.rays.cast(origin, direction).is_none_or(|hit| hit.distance > distance - BEFORE)
    }

    /// The leaks of a picture of the scene, seen through `projection`. `tolerance` is how far its points may be off on
    /// the screen, in pixels.
    #[must_use]
    pub fn find(
        &self,
        projection: &ViewProjection,
        aovs: &Aovs,
        tolerance: f64,
        which: Suspects,
    ) -> Leaks {
        let screen = Screen::new(projection, aovs.size);
        let radius = tolerance + ROUNDING_PX;
        let segments = self.solids.segments(&screen, radius + 3.0 * WIDEST_GAP_PX);
        let gap_px = segments.iter().map(|segment| segment.gap_px).fold(0.0, f64::max);
        let widest = gap_px.min(WIDEST_GAP_PX);
        let picture = Picture { finder: self, aovs, screen, segments, radius, gap_px: widest };
        let reach = (1.1 * (2.0 * radius + widest)).ceil() as i32 + 2;
        let (width, height) = aovs.size;
        let rows = parallel::map(height as usize, |y| {
            let pixels = (0..width).map(|x| UVec2::new(x, y as u32));
            let chosen =
                |pixel: &UVec2| which == Suspects::All || picture.is_between(*pixel, reach);
            pixels.filter(chosen).collect::<Vec<_>>()
        });
        let suspects: Vec<UVec2> = rows.into_iter().flatten().collect();
        let found = parallel::map(suspects.len(), |i| picture.judge(suspects[i]));
        Leaks { found: found.into_iter().flatten().collect(), gap_px, suspects: suspects.len() }
    }

    /// The point of a surface that a pixel shows, by its (u, v) in its patch, and the number of the surface.
    fn shown(&self, aovs: &Aovs, pixel: usize) -> Option<(DVec3, usize)> {
        let number = aovs.uv[pixel][2].round() as usize;
        let surface =
            self.first_patches.partition_point(|first| *first <= number).checked_sub(1)?;
        let own = self.scene.surfaces.get(surface)?;
        let [u, v] = aovs.patch_uv[pixel].map(f64::from);
        let point = own.at(number - self.first_patches[surface], u, v).position;
        Some((own.transform.transform_point3(point), surface))
    }

    /// Whether a pixel's face is seen from the inside of its solid.
    fn is_inside(&self, aovs: &Aovs, pixel: usize, surface: usize, sight: DVec3) -> bool {
        let own = &self.scene.surfaces[surface];
        let reversed = own.face.is_some_and(|of| {
            let face = self.scene.models.get(of.model).and_then(|m| m.model.faces.get(of.face));
            face.is_some_and(|face| face.reversed)
        });
        let [x, y, z, _] = aovs.normal[pixel].map(f64::from);
        // Su × Sv of the placed surface; a mirror turns it to the other side of the solid.
        let is_turned = reversed != (own.transform.determinant() < 0.0);
        (DVec3::new(x, y, z).dot(sight) > 0.0) != is_turned
    }
}

/// A picture that is judged.
struct Picture<'a> {
    finder: &'a LeakFinder<'a>,
    aovs: &'a Aovs,
    screen: Screen,
    segments: Vec<Segment>,
    /// Up to which distance on the screen rays decide what a sample may show, in pixels.
    radius: f64,
    /// The largest gap of the data along a shared edge, at most [`WIDEST_GAP_PX`].
    gap_px: f64,
}

impl Picture<'_> {
    fn number(&self, pixel: UVec2) -> usize {
        (pixel.y * self.aovs.size.0 + pixel.x) as usize
    }

    /// The depth that is drawn, infinite for the background.
    fn drawn(&self, number: usize) -> f64 {
        let [depth, .., alpha] = self.aovs.depth[number];
        if alpha == 0.0 { f64::INFINITY } else { f64::from(depth) }
    }

    /// How much a depth has to differ to be another.
    fn margin(&self, point: DVec3) -> f64 {
        self.radius * self.screen.pixel_at(point) + ROUNDING * self.screen.depth(point).abs()
    }

    /// Whether samples on two opposite sides, at most `reach` steps away, are nearer to the eye.
    fn is_between(&self, pixel: UVec2, reach: i32) -> bool {
        let own = self.drawn(self.number(pixel));
        let limit = if own.is_finite() {
            let [x, y, z, _] = self.aovs.position[self.number(pixel)].map(f64::from);
            own - self.margin(DVec3::new(x, y, z))
        } else {
            f64::MAX
        };
        let size = UVec2::from(self.aovs.size).as_ivec2();
        let is_nearer = |step: IVec2| {
            (1..=reach).any(|i| {
                let place = pixel.as_ivec2() + i * step;
                let is_outside = place.min_element() < 0 || place.cmpge(size).any();
                is_outside || self.drawn(self.number(place.as_uvec2())) < limit
            })
        };
        [(1, 0), (0, 1), (1, 1), (1, -1)]
            .map(IVec2::from)
            .into_iter()
            .any(|step| is_nearer(step) && is_nearer(-step))
    }

    /// Whether a sample is a leak; `None` if it is right or cannot be judged.
    fn judge(&self, pixel: UVec2) -> Option<Leak> {
        let number = self.number(pixel);
        let center = pixel.as_dvec2() + 0.5;
        let shown = if self.drawn(number).is_finite() {
            Some(self.finder.shown(self.aovs, number)?)
        } else {
            None
        };
        let [_, sight] = self.screen.ray(center);
        let kind = shown.map_or(LeakKind::Background, |(_, surface)| {
            let is_inside = self.finder.is_inside(self.aovs, number, surface, sight);
            if is_inside { LeakKind::BackSide } else { LeakKind::Hidden }
        });
        // Only a face seen from outside may go on behind a silhouette.
        let seen = shown.filter(|_| kind == LeakKind::Hidden);
        let limit =
            shown.map_or(f64::INFINITY, |(point, _)| self.screen.depth(point) - self.margin(point));
        let gap = |segment: &Segment| segment.gap_px.min(WIDEST_GAP_PX);
        let farthest = self.radius + 3.0 * self.gap_px;
        let near = |segment: &&Segment| segment.nearest(center).0 <= farthest;
        let near: Vec<&Segment> = self.segments.iter().filter(near).collect();
        // A sample in a crack is no further from the edge than this. On a circle that is twice as large, there are rays
        // on both sides that are further away.
        let beside = near.iter().filter(|of| of.nearest(center).0 <= self.radius + gap(of));
        let radius = self.radius + 2.0 * beside.map(|segment| gap(segment)).fold(0.0, f64::max);
        let is_in_gap =
            |place| near.iter().any(|segment| segment.nearest(place).0 <= segment.gap_px);
        let mut deepest = f64::NEG_INFINITY;
        let mut decided = 0;
        for (circle, radius) in [radius, 0.5 * radius].into_iter().enumerate() {
            for i in 0..AROUND {
                let turn = f64::from(i) * (std::f64::consts::TAU / f64::from(AROUND));
                let place = center + radius * DVec2::from_angle(turn);
                if !is_in_gap(place) {
                    deepest = deepest.max(self.first(place, limit, seen)?);
                    decided += usize::from(circle == 0);
                }
            }
        }
        if decided < DECIDING {
            return None;
        }
        if let Some((point, _)) = shown {
            let (place, _) = self.screen.place(point)?;
            if place.distance(center) <= radius && !is_in_gap(place) {
                let _ = self.first(place, limit, seen)?;
            }
        }
        let depth = shown.map_or(f64::INFINITY, |(point, _)| self.screen.depth(point));
        Some(Leak { pixel, kind, depth, edge: self.edge(center, deepest) })
    }

    /// The depth of the first point at a place, if it belongs to a closed product and lies before a limit. `None` also
    /// if the face that the sample shows is seen there, and goes on from there to what it shows.
    fn first(&self, place: DVec2, limit: f64, seen: Option<(DVec3, usize)>) -> Option<f64> {
        let [origin, direction] = self.screen.ray(place);
        let hit = self.finder.rays.cast(origin, direction)?;
        let point = origin + hit.distance * direction;
        let depth = self.screen.depth(point);
        let goes_on = seen.is_some_and(|(shown, surface)| {
            let reach = STEEPEST * self.radius * self.screen.pixel_at(shown);
            surface == hit.surface && shown.distance(point) <= reach
        });
        let is_before = self.finder.solids.is_closed[hit.surface] && depth < limit;
        (is_before && !goes_on).then_some(depth)
    }

    /// The shared edge nearest to a place, if possible of those that are not deeper than `depth`.
    fn edge(&self, place: DVec2, depth: f64) -> Option<LeakingEdge> {
        let [origin, direction] = self.screen.ray(place);
        let [near, far] = [origin, origin + direction].map(|point| self.screen.depth(point));
        let limit = depth + self.margin(origin + (depth - near) / (far - near) * direction);
        let nearest = |is_chosen: &dyn Fn(f64) -> bool| {
            let all = self.segments.iter().map(|segment| (segment.nearest(place), segment.edge));
            all.filter(|((_, depth), _)| is_chosen(*depth)).min_by(|a, b| a.0.0.total_cmp(&b.0.0))
        };
        let ((distance_px, _), edge) =
            nearest(&|depth| depth <= limit).or_else(|| nearest(&|_| true))?;
        let SharedEdge { model, edge, .. } = self.finder.solids.edges[edge];
        Some(LeakingEdge { model, edge, distance_px })
    }
}
