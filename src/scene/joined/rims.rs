//! Rims: where a surface may meet another one. They are the open sides of its patches and the borders of its trims.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use super::boxes::{Bounds, BoxTree, widened};
use crate::bezier::{SurfacePoint, bounding_box};
use crate::model::JointSurface;
use crate::parallel;
use crate::scene::Surface;
use crate::trim::{Segment, Trims};

/// How far beside a border it is decided whether the surface is there, as a share of the domain.
const BESIDE: f64 = 1e-7;
/// Parts of a rim whose ends are looked at.
const PARTS: u32 = 8;

/// A curve on a surface in world space. Its parameter goes from 0 to 1.
pub(super) struct Rim<'a> {
    /// The number of the surface in the scene.
    pub(super) number: usize,
    surface: &'a Surface,
    /// The patch to which the curve belongs; `None`: any of a NURBS surface.
    pub(super) patch: Option<usize>,
    path: Path,
    /// For a side of a patch, where the patch lies: 1 to the left of the curve in the plane of (u, v), −1 to the right.
    side: Option<f64>,
    pub(super) ends: [DVec3; 2],
    /// A box that contains it.
    pub(super) bounds: Bounds,
    /// Points at even steps of the parameter; none for a side of a patch.
    samples: Vec<DVec3>,
}

/// A curve in (u, v).
#[derive(Debug, Clone, Copy)]
enum Path {
    Segment(Segment),
    /// A quarter of an ellipse, from an angle on.
    Quarter {
        center: DVec2,
        radii: DVec2,
        from: f64,
    },
}

impl Path {
    fn point(&self, t: f64) -> DVec2 {
        match self {
            Self::Segment(segment) => segment.point(t),
            Self::Quarter { center, radii, from } => {
                *center + *radii * DVec2::from_angle(from + t * FRAC_PI_2)
            }
        }
    }

    fn slope(&self, t: f64) -> DVec2 {
        const STEP: f64 = 1e-5;
        let [low, high] = [(t - STEP).max(0.0), (t + STEP).min(1.0)];
        (self.point(high) - self.point(low)) / (high - low)
    }
}

/// A surface, or a Bézier patch of it, in its place.
pub(super) struct Extent<'a> {
    number: usize,
    surface: &'a Surface,
    patch: Option<usize>,
    /// The number of its first patch among those of all surfaces.
    first: usize,
    pub(super) bounds: Bounds,
}

/// The surfaces that may meet others. Faces of CAD models have joints of their own.
pub(super) fn extents(surfaces: &[Surface]) -> Vec<Extent<'_>> {
    let mut extents = Vec::new();
    let mut first = 0;
    for (number, surface) in surfaces.iter().enumerate() {
        let patches = surface.patches().len();
        if surface.join && surface.face.is_none() {
            let count = if surface.nurbs().is_some() { surface.patch_points().len() } else { 0 };
            let points = surface.patch_points().chunks(count.max(surface.degree().points()));
            extents.extend(points.enumerate().map(|(patch, points)| {
                let place =
                    |point: &glam::DVec4| surface.transform.transform_point3(point.truncate());
                let patch = surface.nurbs().is_none().then_some(patch);
                let bounds = bounding_box(points.iter().map(place));
                Extent { number, surface, patch, first: first + patch.unwrap_or(0), bounds }
            }));
        }
        first += patches;
    }
    extents
}

/// The rims of surfaces that are longer than a tolerance. `open` tells of each side of each patch of the scene whether
/// it is no other patch's.
pub(super) fn rims<'a>(extents: &[Extent<'a>], open: &[[bool; 4]], tolerance: f64) -> Vec<Rim<'a>> {
    let tree = BoxTree::new(extents.iter().map(|extent| extent.bounds));
    let of_extents = parallel::map(extents.len(), |number| {
        let extent = &extents[number];
        let mut rims = Vec::new();
        let patches = extent.patch.map_or(extent.surface.patches().len(), |_| 1);
        for patch in 0..patches {
            for side in (0..4).filter(|side| open[extent.first + patch][*side]) {
                rims.push(extent.side(extent.patch.unwrap_or(patch), side));
            }
        }
        let meets = |bounds| tree.any(widened(bounds, tolerance), |other| other != number);
        // A NURBS surface may meet itself.
        if extent.patch.is_some() {
            rims.retain(|rim| meets(rim.bounds));
        }
        if !extent.surface.trims.is_empty() && meets(extent.bounds) {
            let borders = paths(&extent.surface.trims).filter_map(|path| extent.border(path));
            rims.extend(borders.filter(|rim| meets(rim.bounds)));
        }
        rims.retain(|rim| rim.bounds[0].distance(rim.bounds[1]) > tolerance);
        rims
    });
    of_extents.into_iter().flatten().collect()
}

/// The borders of the trims that are switched on.
fn paths(trims: &Trims) -> impl Iterator<Item = Path> + '_ {
    let quarters = |center, radii| {
        (0..4).map(move |i| Path::Quarter { center, radii, from: f64::from(i) * FRAC_PI_2 })
    };
    let circles = trims.circles.iter().filter(|_| trims.circles_on);
    let circles = circles.map(|circle| (circle.center, DVec2::splat(circle.radius)));
    let ellipses = trims.ellipses.iter().filter(|_| trims.ellipses_on);
    let round = circles.chain(ellipses.map(|ellipse| (ellipse.center, ellipse.radii)));
    let rects = trims.rects.iter().filter(|_| trims.rects_on).flat_map(|rect| {
        let corner =
            |i: usize| DVec2::new(rect.u[usize::from(i % 4 == 1 || i % 4 == 2)], rect.v[i / 2 % 2]);
        (0..4).map(move |i| Path::Segment(Segment::Line([corner(i), corner(i + 1)])))
    });
    let loops = trims.all_loops().filter(|_| trims.loops_on);
    let segments = loops.flat_map(|of| of.segments()).map(|segment| Path::Segment(*segment));
    round.flat_map(move |(center, radii)| quarters(center, radii)).chain(rects).chain(segments)
}

impl<'a> Extent<'a> {
    /// A side of a patch: u = 0, v = 0, u = 1, v = 1.
    fn side(&self, patch: usize, side: usize) -> Rim<'a> {
        let [low, high] = self.surface.patch_domain(patch);
        let (along, at_end) = ((side + 1) % 2, side / 2);
        let [mut start, mut end] = [low, high];
        start[1 - along] = [low, high][at_end][1 - along];
        end[1 - along] = start[1 - along];
        let degree = self.surface.degree();
        let (columns, rows) = (degree.columns(), degree.rows());
        let (first, step, count) = match side {
            0 | 2 => (at_end * degree.u(), columns, rows),
            _ => (at_end * columns * degree.v(), 1, columns),
        };
        let points = &self.surface.patch_points()[patch * degree.points()..];
        let place =
            |i: usize| self.surface.transform.transform_point3(points[first + i * step].truncate());
        // Along u, the patch above the side lies to the left; along v, the one before it.
        let is_left = (side == 1) || (side == 2);
        Rim {
            number: self.number,
            surface: self.surface,
            patch: Some(patch),
            path: Path::Segment(Segment::Line([start, end])),
            side: Some(if is_left { 1.0 } else { -1.0 }),
            ends: [place(0), place(count - 1)],
            bounds: bounding_box((0..count).map(place)),
            samples: Vec::new(),
        }
    }

    /// The border of a trim; `None` if it lies on or beyond the border of the domain.
    fn border(&self, path: Path) -> Option<Rim<'a>> {
        let [low, high] = self.surface.domain();
        let slack = BESIDE * (high - low);
        let places = (0..=PARTS).map(|i| path.point(f64::from(i) / f64::from(PARTS)));
        let [least, most] = bounding_box(places.clone());
        if least.cmpge(high - slack).any() || most.cmple(low + slack).any() {
            return None;
        }
        let mut rim = Rim {
            number: self.number,
            surface: self.surface,
            patch: self.patch,
            path,
            side: None,
            ends: [DVec3::ZERO; 2],
            bounds: [DVec3::ZERO; 2],
            samples: Vec::new(),
        };
        rim.samples = places.map(|uv| rim.at(uv).position).collect();
        rim.ends = [rim.samples[0], rim.samples[rim.samples.len() - 1]];
        let [low, high] = bounding_box(rim.samples.iter().copied());
        // It bends between these points.
        rim.bounds = widened([low, high], 0.25 * low.distance(high));
        Some(rim)
    }
}

impl Rim<'_> {
    /// (u, v) at a parameter.
    pub(super) fn uv(&self, t: f64) -> DVec2 {
        self.path.point(t)
    }

    /// The point at a parameter.
    pub(super) fn point(&self, t: f64) -> DVec3 {
        self.at(self.uv(t)).position
    }

    /// Whether the surface lies on one side of the curve, and on which: 1 to the left in the plane of (u, v), −1 to the
    /// right.
    pub(super) fn kept(&self, t: f64) -> Option<f64> {
        if self.is_whole() {
            return self.side;
        }
        let [low, high] = self.surface.domain();
        let slope = self.path.slope(t) / (high - low);
        let beside = BESIDE * slope.perp().normalize_or_zero() * (high - low);
        let is_kept = |side: f64| {
            let uv = self.uv(t) + side * beside;
            uv.cmpge(low).all() && uv.cmple(high).all() && !self.surface.trims.cut(uv)
        };
        match self.side {
            Some(side) => is_kept(side).then_some(side),
            None => match [1.0, -1.0].map(is_kept) {
                [true, false] => Some(1.0),
                [false, true] => Some(-1.0),
                _ => None,
            },
        }
    }

    /// Whether [`Rim::kept`] is the same everywhere.
    pub(super) fn is_whole(&self) -> bool {
        self.side.is_some() && self.surface.trims.is_empty()
    }

    /// Whether two rims are the same place of one surface at given parameters.
    pub(super) fn is_same_place(&self, other: &Self, [own, others]: [f64; 2]) -> bool {
        let [low, high] = self.surface.domain();
        let is_one_patch =
            self.patch == other.patch || self.patch.is_none() || other.patch.is_none();
        let off = (self.uv(own) - other.uv(others)) / (high - low);
        self.number == other.number && is_one_patch && off.length() < 10.0 * BESIDE
    }

    /// The parameters at which the curve passes a point within a tolerance: an end, or both, or else one between them.
    pub(super) fn parameters_of(&self, point: DVec3, tolerance: f64) -> [Option<f64>; 2] {
        let at_ends =
            [0, 1].map(|i| (self.ends[i].distance(point) <= tolerance).then_some(i as f64));
        if at_ends != [None; 2] {
            return at_ends;
        }
        let computed: Vec<DVec3>;
        let samples = if self.samples.is_empty() {
            computed = (0..=PARTS).map(|i| self.point(f64::from(i) / f64::from(PARTS))).collect();
            &computed
        } else {
            &self.samples
        };
        // Between two samples the curve does not leave their line by more than half of its length.
        let near = samples.windows(2).zip(0..).filter_map(|(ends, part)| {
            let line = ends[1] - ends[0];
            let share = (point - ends[0]).dot(line) / line.length_squared();
            let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.5 };
            let distance = point.distance(ends[0].lerp(ends[1], share));
            let is_near = distance <= 0.5 * line.length() + tolerance;
            is_near.then_some((distance, (f64::from(part) + share) / f64::from(PARTS)))
        });
        let Some((_, start)) = near.min_by(|a, b| a.0.total_cmp(&b.0)) else { return [None; 2] };
        let (t, distance) = self.nearest(point, start);
        [(distance <= tolerance).then_some(t), None]
    }

    /// The parameter of the nearest point, from one nearby, and its distance.
    pub(super) fn nearest(&self, point: DVec3, mut t: f64) -> (f64, f64) {
        const STEPS: u32 = 12;
        let mut here = self.at(self.uv(t));
        for _ in 0..STEPS {
            let slope = self.path.slope(t);
            let slope = here.du * slope.x + here.dv * slope.y;
            let step = (point - here.position).dot(slope) / slope.length_squared();
            let next = (t + step).clamp(0.0, 1.0);
            if !next.is_finite() || (next - t).abs() <= 1e-12 {
                break;
            }
            let there = self.at(self.uv(next));
            if there.position.distance_squared(point) >= here.position.distance_squared(point) {
                break;
            }
            (t, here) = (next, there);
        }
        (t, here.position.distance(point))
    }
}

impl JointSurface for Rim<'_> {
    fn at(&self, uv: DVec2) -> SurfacePoint {
        let [low, high] = self.surface.domain();
        let uv = uv.clamp(low, high);
        let patch = self.patch.unwrap_or_else(|| self.surface.patch_at(uv));
        let [low, high] = self.surface.patch_domain(patch);
        let size = high - low;
        let share = (uv - low) / size;
        let SurfacePoint { position, du, dv } = self.surface.at(patch, share.x, share.y);
        let to_world = self.surface.transform;
        SurfacePoint {
            position: to_world.transform_point3(position),
            du: to_world.transform_vector3(du / size.x),
            dv: to_world.transform_vector3(dv / size.y),
        }
    }

    fn share(&self, uv: DVec2, _: DVec2) -> DVec2 {
        let [low, high] = self.surface.domain();
        (uv - low) / (high - low)
    }
}
