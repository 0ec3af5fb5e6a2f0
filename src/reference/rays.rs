//! Where a ray meets the surfaces of a scene, in `f64`: by subdivision of the control nets, then Newton's method.

use glam::{DVec2, DVec3, DVec4, dvec2};

use crate::bezier::{Degree, bounding_box, homogeneous};
use crate::scene::Scene;

/// A patch of a scene in world space.
struct WorldPatch {
    surface: usize,
    patch: usize,
    /// The corners of the box around its control points.
    corners: [DVec3; 2],
}

/// The surfaces of a scene, for casting rays.
pub struct Rays<'a> {
    scene: &'a Scene,
    patches: Vec<WorldPatch>,
}

impl std::fmt::Debug for Rays<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Rays").field("patches", &self.patches.len()).finish_non_exhaustive()
    }
}

/// A point where a ray meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The number of the surface in the scene.
    pub surface: usize,
    /// The number of the patch in the surface.
    pub patch: usize,
    /// The place in the domain of the surface.
    pub uv: DVec2,
    /// The distance from the ray's origin, in lengths of its direction.
    pub distance: f64,
}

impl<'a> Rays<'a> {
    /// The surfaces of a scene. Its meshes and hidden surfaces are left out.
    #[must_use]
    pub fn new(scene: &'a Scene) -> Self {
        let mut patches = Vec::new();
        for (surface, own) in scene.surfaces.iter().enumerate().filter(|(_, own)| !own.hidden) {
            for (patch, points) in
                own.patch_points().chunks_exact(own.degree().points()).enumerate()
            {
                let world = |point: &DVec4| own.transform.transform_point3(point.truncate());
                patches.push(WorldPatch {
                    surface,
                    patch,
                    corners: bounding_box(points.iter().map(world)),
                });
            }
        }
        Self { scene, patches }
    }

    /// The first point where a ray meets a surface that the trims keep.
    #[must_use]
    pub fn cast(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let mut ahead: Vec<(f64, &WorldPatch)> = self
            .patches
            .iter()
            .filter_map(|patch| Some((entry(patch.corners, origin, direction)?, patch)))
            .collect();
        ahead.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut nearest: Option<Hit> = None;
        for (entry, patch) in ahead {
            if nearest.is_some_and(|nearest| nearest.distance < entry) {
                break;
            }
            for hit in self.hits(patch, origin, direction) {
                if nearest.is_none_or(|nearest| hit.distance < nearest.distance) {
                    nearest = Some(hit);
                }
            }
        }
        nearest
    }

    /// Where a ray meets a patch in front of its origin, where the trims keep it.
    fn hits(&self, patch: &WorldPatch, origin: DVec3, direction: DVec3) -> Vec<Hit> {
        let surface = &self.scene.surfaces[patch.surface];
        let forwards = direction.normalize();
        let axes = forwards.any_orthonormal_pair();
        let degree = surface.degree();
        let points = &surface.patch_points()[patch.patch * degree.points()..][..degree.points()];
        let seen = |point: &DVec4| {
            let place = surface.transform.transform_point3(point.truncate()) - origin;
            homogeneous(components([axes.0, axes.1, forwards], place).extend(point.w))
        };
        let net = Net { degree, points: points.iter().map(seen).collect() };
        let mut search = Search { roots: Vec::new(), parts_left: MAX_PARTS };
        net.roots([DVec2::ZERO, DVec2::ONE], 0, &mut search);
        let [low, high] = surface.patch_domain(patch.patch);
        let hit = |place: DVec2| {
            let distance = net.at(place)[0].z / direction.length();
            let uv = low + place * (high - low);
            let is_kept = distance > 0.0 && !surface.trims.cut(uv);
            is_kept.then_some(Hit { surface: patch.surface, patch: patch.patch, uv, distance })
        };
        search.roots.into_iter().filter_map(hit).collect()
    }
}

/// The most parts of a patch that are looked at for a ray. Only a ray along the surface needs so many: it meets a whole
/// curve, of which some places are found.
const MAX_PARTS: u32 = 10_000;

/// The places that were found, and how many parts may still be looked at.
struct Search {
    roots: Vec<DVec2>,
    parts_left: u32,
}

/// The components of a vector along three axes.
fn components(axes: [DVec3; 3], of: DVec3) -> DVec3 {
    DVec3::from_array(axes.map(|axis| axis.dot(of)))
}

/// The distance at which a ray enters a box, in lengths of its direction.
fn entry([low, high]: [DVec3; 2], origin: DVec3, direction: DVec3) -> Option<f64> {
    let margin = 1e-9 * (high - low).length();
    let mut range = [0.0, f64::INFINITY];
    for axis in 0..3 {
        let ends = [low[axis] - margin, high[axis] + margin].map(|end| end - origin[axis]);
        if direction[axis] == 0.0 {
            if ends[0] > 0.0 || ends[1] < 0.0 {
                return None;
            }
            continue;
        }
        let at = ends.map(|end| end / direction[axis]);
        range = [range[0].max(at[0].min(at[1])), range[1].min(at[0].max(at[1]))];
    }
    (range[0] <= range[1]).then_some(range[0])
}

/// A patch seen along a ray: homogeneous coordinates across the ray (x, y) and along it (z).
#[derive(Clone)]
struct Net {
    degree: Degree,
    points: Vec<DVec4>,
}

impl Net {
    /// The point (x, y, z) at a place, and its derivatives along u and v, by the quotient rule.
    fn at(&self, place: DVec2) -> [DVec3; 3] {
        let [mut values, mut slopes] = [[DVec4::ZERO; Degree::MAX + 1]; 2];
        for (row, points) in self.points.chunks_exact(self.degree.columns()).enumerate() {
            [values[row], slopes[row]] = curve(points, place.x);
        }
        let rows = self.degree.rows();
        let [[value, dv], [du, _]] = [&values, &slopes].map(|of| curve(&of[..rows], place.y));
        let point = value.truncate() / value.w;
        let derivative = |of: DVec4| (of.truncate() - point * of.w) / value.w;
        [point, derivative(du), derivative(dv)]
    }

    /// Appends the places within a part of the whole patch, given by its corners, where x = y = 0. `self` is the part's
    /// control net.
    fn roots(&self, part: [DVec2; 2], depth: u32, search: &mut Search) {
        /// Below this size a part is a place.
        const MAX_DEPTH: u32 = 80;
        if search.parts_left == 0 || self.is_beside() {
            return;
        }
        search.parts_left -= 1;
        let [start, end] = part;
        let size = end - start;
        if self.is_flat() {
            if let Some(place) = self.newton() {
                let place = start + place * size;
                // A root on the border between two parts belongs to both.
                if search.roots.iter().all(|root| root.distance(place) > 1e-9) {
                    search.roots.push(place);
                }
            }
            return;
        }
        if depth == MAX_DEPTH {
            let place = start.midpoint(end);
            if search.roots.iter().all(|root| root.distance(place) > 1e-6) {
                search.roots.push(place);
            }
            return;
        }
        let along_u = depth.is_multiple_of(2);
        let middle = start.midpoint(end);
        for (half, net) in self.halves(along_u).into_iter().enumerate() {
            let mut part = part;
            let corner = &mut part[1 - half];
            if along_u {
                corner.x = middle.x;
            } else {
                corner.y = middle.y;
            }
            net.roots(part, depth + 1, search);
        }
    }

    /// Whether all control points lie on one side of a line through x = y = 0: along an axis, or along one of two sides
    /// of the net, which may look like a narrow strip.
    fn is_beside(&self) -> bool {
        let point = |i: usize| self.points[i].truncate() / self.points[i].w;
        let (columns, count) = (self.degree.columns(), self.points.len());
        let sides = [columns - 1, count - columns];
        let [along_u, along_v] = sides.map(|i| (point(i) - point(0)).truncate());
        let lines = [DVec2::X, DVec2::Y, along_u, along_v];
        let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; 4];
        let mut farthest: f64 = 0.0;
        for point in (0..count).map(point) {
            farthest = farthest.max(point.abs().max_element());
            for (range, line) in ranges.iter_mut().zip(lines) {
                let off = line.perp_dot(point.truncate());
                *range = [range[0].min(off), range[1].max(off)];
            }
        }
        // A ray through a side must not miss both patches beside it by rounding.
        let rounding = 8.0 * f64::EPSILON * farthest;
        ranges.iter().zip(lines).any(|([low, high], line)| {
            let rounding = rounding * line.length();
            *low > rounding || *high < -rounding
        })
    }

    /// Both halves along u or along v, by de Casteljau's algorithm.
    fn halves(&self, along_u: bool) -> [Self; 2] {
        let [mut before, mut after] = [self.clone(), self.clone()];
        let (columns, rows) = (self.degree.columns(), self.degree.rows());
        let (lines, count, first, step) =
            if along_u { (rows, columns, columns, 1) } else { (columns, rows, 1, columns) };
        for line in 0..lines {
            let index = |i: usize| line * first + i * step;
            for left in (1..count).rev() {
                for i in 0..left {
                    let pair = [i, i + 1].map(|i| after.points[index(i)]);
                    after.points[index(i)] = pair[0].midpoint(pair[1]);
                }
                before.points[index(count - left)] = after.points[index(0)];
            }
        }
        [before, after]
    }

    /// Whether the derivatives are so much alike that x = y = 0 in at most one place.
    fn is_flat(&self) -> bool {
        let [_, du, dv] = self.at(DVec2::splat(0.5)).map(DVec3::truncate);
        let limit = 0.25 * du.perp_dot(dv).abs() / du.length().max(dv.length());
        let place = |i: usize| self.points[i].truncate().truncate() / self.points[i].w;
        let (columns, rows) = (self.degree.columns(), self.degree.rows());
        let is_near = |from: usize, to: usize, degree: usize, expected: DVec2| {
            ((place(to) - place(from)) * degree as f64).distance(expected) < limit
        };
        (0..rows).all(|row| {
            (0..columns).all(|column| {
                let i = row * columns + column;
                (column + 1 == columns || is_near(i, i + 1, self.degree.u(), du))
                    && (row + 1 == rows || is_near(i, i + columns, self.degree.v(), dv))
            })
        })
    }

    /// The place where x = y = 0 in a flat part.
    fn newton(&self) -> Option<DVec2> {
        /// Beyond the part, relative to its size.
        const MARGIN: f64 = 1e-9;
        let mut found = DVec2::splat(0.5);
        for _ in 0..30 {
            let [point, du, dv] = self.at(found).map(DVec3::truncate);
            let step = dvec2(point.perp_dot(dv), du.perp_dot(point)) / du.perp_dot(dv);
            found -= step;
            if step.length() < 1e-14 {
                break;
            }
        }
        let is_inside = found.min_element() >= -MARGIN && found.max_element() <= 1.0 + MARGIN;
        is_inside.then(|| found.clamp(DVec2::ZERO, DVec2::ONE))
    }
}

/// The point of a Bézier curve and its derivative, by de Casteljau's algorithm.
fn curve(of: &[DVec4], t: f64) -> [DVec4; 2] {
    let degree = of.len() - 1;
    let mut points = [DVec4::ZERO; Degree::MAX + 1];
    points[..=degree].copy_from_slice(of);
    for left in (2..=degree).rev() {
        for i in 0..left {
            points[i] = points[i].lerp(points[i + 1], t);
        }
    }
    [points[0].lerp(points[1], t), (points[1] - points[0]) * degree as f64]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::NurbsSurface;
    use crate::scene::Surface;
    use crate::trim::Circle;
    use glam::{DMat4, dvec3};

    /// A whole sphere about the origin as a NURBS surface of 2 × 4 patches.
    fn sphere(radius: f64) -> Surface {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        // A circle in nine points, and a half of one from pole to pole in five.
        let circle = [
            (1.0, 0.0),
            (1.0, 1.0),
            (0.0, 1.0),
            (-1.0, 1.0),
            (-1.0, 0.0),
            (-1.0, -1.0),
            (0.0, -1.0),
            (1.0, -1.0),
            (1.0, 0.0),
        ];
        let arc = [(0.0, -1.0), (1.0, -1.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        let weight = |i: usize| if i.is_multiple_of(2) { 1.0 } else { half };
        let points = arc.iter().enumerate().flat_map(|(row, (r, z))| {
            circle.iter().enumerate().map(move |(column, (x, y))| {
                (radius * dvec3(r * x, r * y, *z)).extend(weight(row) * weight(column))
            })
        });
        let along = |breaks: &[f64]| {
            let inner = breaks.iter().flat_map(|knot| [*knot; 2]);
            [breaks[0]].into_iter().chain(inner).chain([breaks[breaks.len() - 1]]).collect()
        };
        let knots = [along(&[0.0, 1.0, 2.0, 3.0, 4.0]), along(&[0.0, 1.0, 2.0])];
        let degree = Degree::new(2, 2).unwrap();
        Surface::from_nurbs(NurbsSurface::new(degree, knots, points.collect()).unwrap())
    }

    #[test]
    fn a_ray_meets_a_sphere_where_the_formula_says() {
        let mut surface = sphere(2.0);
        surface.transform = DMat4::from_translation(dvec3(3.0, -1.0, 0.5));
        let center = dvec3(3.0, -1.0, 0.5);
        let scene = Scene { surfaces: vec![surface], ..Scene::default() };
        let rays = Rays::new(&scene);
        let (mut hits, mut misses) = (0, 0);
        for i in 0..500 {
            let turn = f64::from(i);
            let origin = center + 5.0 * dvec3(turn.sin(), (1.3 * turn).cos(), (0.7 * turn).sin());
            let aim =
                center + 2.3 * dvec3((2.1 * turn).cos(), (0.9 * turn).sin(), (1.7 * turn).cos());
            let direction = 3.0 * (aim - origin);
            let [a, b] = [direction.dot(direction), direction.dot(origin - center)];
            let root = b * b - a * ((origin - center).length_squared() - 4.0);
            if root.abs() < 1e-3 * b * b {
                continue;
            }
            let expected = (root > 0.0).then(|| {
                let ends = [(-b - root.sqrt()) / a, (-b + root.sqrt()) / a];
                if ends[0] > 0.0 { ends[0] } else { ends[1] }
            });
            let found = rays.cast(origin, direction).map(|hit| hit.distance);
            match (found, expected.filter(|distance| *distance > 0.0)) {
                (Some(found), Some(expected)) => {
                    assert!((found - expected).abs() < 1e-12, "{i}: {found} {expected}");
                    hits += 1;
                }
                (None, None) => misses += 1,
                other => panic!("{i}: {other:?}"),
            }
        }
        assert!(hits > 200 && misses > 50, "{hits} {misses}");
    }

    #[test]
    fn a_ray_along_a_surface_ends() {
        let points = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)];
        let points = points.map(|(x, y)| DVec4::new(x, y, 0.0, 1.0)).to_vec();
        let plane = Surface::of_patch(Degree::new(1, 1).unwrap(), points).unwrap();
        let mut wall = plane.clone();
        wall.transform =
            DMat4::from_rotation_y(0.5) * DMat4::from_translation(dvec3(3.0, 0.0, 0.0));
        let scene = Scene { surfaces: vec![plane, wall], ..Scene::default() };
        let rays = Rays::new(&scene);
        for y in [0.3, 0.5, 1.0 / 3.0] {
            assert!(rays.cast(dvec3(-1.0, y, 0.0), DVec3::X).is_some());
        }
    }

    #[test]
    fn a_ray_goes_through_a_hole() {
        let mut surface = sphere(1.0);
        // A window to the front, at u = 0, and the way out is the other side.
        surface.trims.circles.push(Circle::new(dvec2(2.0, 1.0), 0.4).unwrap());
        let scene = Scene { surfaces: vec![surface], ..Scene::default() };
        let hit = Rays::new(&scene).cast(dvec3(-5.0, 0.1, 0.2), DVec3::X).unwrap();
        assert!((hit.distance - 5.0 - (1.0 - 0.05_f64).sqrt()).abs() < 1e-12, "{hit:?}");
        let point = scene.surfaces[0].nurbs().unwrap().at(hit.uv.x, hit.uv.y).position;
        assert!(point.distance(dvec3(hit.distance - 5.0, 0.1, 0.2)) < 1e-12, "{point}");
    }
}
