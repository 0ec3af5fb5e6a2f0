//! Cuts polygons of a file into triangles that keep every edge of the polygon.

use glam::{DVec2, DVec3};

use crate::bezier::bounding_box;

/// A corner whose angle has a sine below this is treated as straight, because its turn may come from rounding.
const STRAIGHT: f64 = 1e-12;

/// The n − 2 triangles of a polygon of n ≥ 3 corners, as indices of its corners, with the orientation of the polygon.
/// A convex polygon becomes a fan around its first corner; any other polygon is triangulated by ear clipping. The
/// polygon may be slightly non-planar and concave, have corners on its straight edges, and be connected to its holes
/// by an edge that runs there and back. The triangles of a self-intersecting polygon also keep its edges, but they
/// overlap.
pub(super) fn triangles(corners: &[DVec3]) -> Vec<[usize; 3]> {
    let flat = flattened(corners);
    if corners.len() == 3 || is_convex(&flat) {
        return (2..corners.len()).map(|last| [0, last - 1, last]).collect();
    }
    Ears::new(&flat).cut()
}

/// The corners projected along the coordinate axis that is nearest to the polygon's normal (Newell's method), so that
/// the polygon turns left. The projection is exact. In a planar polygon, it does not change whether a corner is
/// convex.
fn flattened(corners: &[DVec3]) -> Vec<DVec2> {
    let first = corners[0];
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let normal: DVec3 = sides.map(|(a, b)| (*a - first).cross(*b - first)).sum();
    let size = normal.abs();
    let (x, y, along) = if size.x > size.y.max(size.z) {
        (1, 2, normal.x)
    } else if size.y > size.z {
        (2, 0, normal.y)
    } else {
        (0, 1, normal.z)
    };
    let turned = if along < 0.0 { -1.0 } else { 1.0 };
    corners.iter().map(|corner| DVec2::new(turned * corner[x], corner[y])).collect()
}

/// Twice the signed area of a triangle; above 0 if the triangle turns left.
fn turn([a, b, c]: [DVec2; 3]) -> f64 {
    (b - a).perp_dot(c - b)
}

/// Whether a corner turns left by more than rounding.
fn is_clear(triangle @ [a, b, c]: [DVec2; 3]) -> bool {
    turn(triangle) > STRAIGHT * a.distance(b) * b.distance(c)
}

/// Whether all corners turn left and the polygon goes around only once.
fn is_convex(corners: &[DVec2]) -> bool {
    let count = corners.len();
    let at = |i: usize| corners[i % count];
    // In one turn around, the direction of the sides changes once from left to right and once from right to left.
    let to_right =
        |i: usize| at(i + 1).x > at(i).x || at(i + 1).x == at(i).x && at(i + 1).y < at(i).y;
    let changes = (0..count).filter(|i| to_right(*i) != to_right(i + 1)).count();
    changes == 2 && (0..count).all(|i| is_clear([at(i), at(i + 1), at(i + 2)]))
}

/// Which corners may be cut off as ears, from strict to permissive.
#[derive(Clone, Copy, PartialEq)]
enum Rule {
    /// A corner that turns left, with nothing in its triangle.
    Clear,
    /// A straight corner, for a remaining polygon that has no area or is not planar.
    Straight,
    /// Any corner, for a remaining polygon that intersects itself.
    Any,
}

/// The state of ear clipping: the polygon that remains.
struct Ears<'a> {
    corners: &'a [DVec2],
    before: Vec<usize>,
    after: Vec<usize>,
    /// The remaining corners that do not turn left: only these can lie in an ear.
    blockers: Blockers,
}

impl<'a> Ears<'a> {
    fn new(corners: &'a [DVec2]) -> Self {
        let count = corners.len();
        let mut ears = Self {
            corners,
            before: (0..count).map(|i| (i + count - 1) % count).collect(),
            after: (0..count).map(|i| (i + 1) % count).collect(),
            blockers: Blockers::new(corners),
        };
        for (corner, place) in corners.iter().enumerate() {
            if !is_clear(ears.triangle(corner)) {
                ears.blockers.add(corner, *place);
            }
        }
        ears
    }

    fn triangle(&self, corner: usize) -> [DVec2; 3] {
        [self.before[corner], corner, self.after[corner]].map(|corner| self.corners[corner])
    }

    fn is_ear(&self, corner: usize, rule: Rule) -> bool {
        let triangle @ [a, b, c] = self.triangle(corner);
        match rule {
            Rule::Clear => is_clear(triangle) && !self.blockers.any_in(triangle),
            Rule::Straight => turn(triangle).abs() <= STRAIGHT * a.distance(b) * b.distance(c),
            Rule::Any => true,
        }
    }

    fn cut(mut self) -> Vec<[usize; 3]> {
        let mut triangles = Vec::with_capacity(self.corners.len() - 2);
        let (mut left, mut corner) = (self.corners.len(), 0);
        let (mut rule, mut since_last) = (Rule::Clear, 0);
        while left > 3 {
            let (before, after) = (self.before[corner], self.after[corner]);
            if !self.is_ear(corner, rule) {
                corner = after;
                since_last += 1;
                if since_last > left {
                    since_last = 0;
                    rule = if rule == Rule::Clear { Rule::Straight } else { Rule::Any };
                }
                continue;
            }
            triangles.push([before, corner, after]);
            self.blockers.remove(corner, self.corners[corner]);
            (self.after[before], self.before[after]) = (after, before);
            for changed in [before, after] {
                let place = self.corners[changed];
                self.blockers.remove(changed, place);
                if !is_clear(self.triangle(changed)) {
                    self.blockers.add(changed, place);
                }
            }
            left -= 1;
            (rule, since_last) = (Rule::Clear, 0);
            // The next corner is skipped: ears all around the polygon make better triangles than a fan.
            corner = self.after[after];
        }
        triangles.push([self.before[corner], corner, self.after[corner]]);
        triangles
    }
}

/// Corners that may lie in ears, sorted into the cells of a grid.
struct Blockers {
    low: DVec2,
    /// Cells per unit.
    scale: DVec2,
    columns: usize,
    cells: Vec<Vec<(usize, DVec2)>>,
}

impl Blockers {
    fn new(corners: &[DVec2]) -> Self {
        let [low, high] = bounding_box(corners.iter().copied());
        let columns = (corners.len() / 4).isqrt().clamp(1, 512);
        let scale = columns as f64 / (high - low).max(DVec2::splat(f64::MIN_POSITIVE.sqrt()));
        Self { low, scale, columns, cells: vec![Vec::new(); columns * columns] }
    }

    fn place(&self, at: DVec2) -> [usize; 2] {
        let place = (at - self.low) * self.scale;
        [place.x, place.y].map(|place| (place.max(0.0) as usize).min(self.columns - 1))
    }

    fn cell(&mut self, at: DVec2) -> &mut Vec<(usize, DVec2)> {
        let [x, y] = self.place(at);
        &mut self.cells[y * self.columns + x]
    }

    fn add(&mut self, corner: usize, at: DVec2) {
        self.cell(at).push((corner, at));
    }

    fn remove(&mut self, corner: usize, at: DVec2) {
        self.cell(at).retain(|(other, _)| *other != corner);
    }

    /// Whether any of these corners lies in a triangle or on its border. Corners at the positions of the triangle's
    /// own corners do not count.
    fn any_in(&self, [a, b, c]: [DVec2; 3]) -> bool {
        let [low_x, low_y] = self.place(a.min(b).min(c));
        let [high_x, high_y] = self.place(a.max(b).max(c));
        let blocks = |(_, at): &(usize, DVec2)| {
            let at = *at;
            at != a
                && at != b
                && at != c
                && [[a, b, at], [b, c, at], [c, a, at]].into_iter().all(|side| turn(side) >= 0.0)
        };
        (low_y..=high_y).any(|y| {
            self.cells[y * self.columns + low_x..=y * self.columns + high_x]
                .iter()
                .flatten()
                .any(blocks)
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use glam::{DMat3, dvec2, dvec3};
    use proptest::prelude::*;

    use super::*;

    /// Twice the signed area, by the shoelace formula.
    fn area(corners: &[DVec2]) -> f64 {
        (0..corners.len()).map(|i| corners[i].perp_dot(corners[(i + 1) % corners.len()])).sum()
    }

    /// Checks the triangles of a simple polygon that turns left and is placed in space by a matrix.
    fn check(corners: &[DVec2], to_space: &DMat3) {
        let in_space: Vec<DVec3> =
            corners.iter().map(|corner| *to_space * corner.extend(0.0)).collect();
        let count = corners.len();
        let found = triangles(&in_space);
        assert_eq!(found.len(), count - 2);
        let whole = area(corners);
        let mut sum = 0.0;
        let mut edges: HashMap<(usize, usize), usize> = HashMap::new();
        for triangle in &found {
            let part = area(&triangle.map(|corner| corners[corner]));
            assert!(part > -1e-9 * whole, "{triangle:?} turns right by {part} of {whole}");
            sum += part;
            for k in 0..3 {
                *edges.entry((triangle[k], triangle[(k + 1) % 3])).or_default() += 1;
            }
        }
        // As all triangles turn left, this shows that nothing overlaps.
        assert!((sum - whole).abs() < 1e-9 * whole, "{sum} {whole}");
        for ((from, to), times) in &edges {
            let inner = edges.contains_key(&(*to, *from));
            assert!(*times == 1 && (inner || (from + 1) % count == *to), "edge {from} {to}");
        }
        for corner in 0..count {
            assert!(
                edges.contains_key(&(corner, (corner + 1) % count)),
                "edge at {corner} is lost"
            );
        }
    }

    fn anywhere() -> impl Strategy<Value = DMat3> {
        (0.0..std::f64::consts::TAU, 0.0..std::f64::consts::PI, 0.0..6.0, any::<bool>()).prop_map(
            |(a, b, c, plain)| {
                if plain {
                    return DMat3::IDENTITY;
                }
                DMat3::from_rotation_z(a) * DMat3::from_rotation_x(b) * DMat3::from_rotation_y(c)
            },
        )
    }

    /// Adds the given numbers of corners to the straight edges of a polygon.
    fn with_straight_corners(corners: &[DVec2], on_each: &[usize]) -> Vec<DVec2> {
        let mut all = Vec::new();
        for (i, corner) in corners.iter().enumerate() {
            let next = corners[(i + 1) % corners.len()];
            let count = on_each[i % on_each.len()];
            all.extend((0..=count).map(|k| corner.lerp(next, k as f64 / (count + 1) as f64)));
        }
        all
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn stars(radii in prop::collection::vec(0.05..1.0, 3..40), to_space in anywhere()) {
            let step = std::f64::consts::TAU / radii.len() as f64;
            let corner = |(i, radius): (usize, &f64)| *radius * DVec2::from_angle(step * i as f64);
            check(&radii.iter().enumerate().map(corner).collect::<Vec<_>>(), &to_space);
        }

        #[test]
        fn combs(
            teeth in prop::collection::vec((0.1..3.0, 0.1..0.9), 1..30),
            on_each in prop::collection::vec(0_usize..3, 1..5),
            to_space in anywhere(),
        ) {
            let mut corners = vec![dvec2(0.0, 0.0), dvec2(teeth.len() as f64, 0.0)];
            for (i, (height, width)) in teeth.iter().enumerate().rev() {
                let x = i as f64;
                let top = [dvec2(x + width, 1.0 + height), dvec2(x, 1.0 + height)];
                corners.extend([dvec2(x + 1.0, 1.0), dvec2(x + width, 1.0)]);
                corners.extend(top);
            }
            corners.push(dvec2(0.0, 0.5));
            corners.dedup();
            check(&with_straight_corners(&corners, &on_each), &to_space);
        }

        #[test]
        fn spirals(turns in 1.0..4.0, count in 8_usize..80, to_space in anywhere()) {
            let arm = |i: usize, off: f64| {
                let t = i as f64 / (count - 1) as f64;
                (0.3 + t * turns + off) * DVec2::from_angle(t * turns * std::f64::consts::TAU)
            };
            // Sides that are too long would cross the next turn.
            prop_assume!(count as f64 > 12.0 * turns);
            let outer = (0..count).map(|i| arm(i, 0.4));
            let corners: Vec<DVec2> = outer.chain((0..count).rev().map(|i| arm(i, 0.0))).collect();
            check(&corners, &to_space);
        }
    }

    #[test]
    fn corners_on_straight_edges_stay() {
        // An L with many corners on each side, at coordinates that are not exact.
        let l = [(0.0, 0.0), (0.3, 0.0), (0.3, 0.1), (0.1, 0.1), (0.1, 0.7), (0.0, 0.7)];
        let l = l.map(|(x, y)| dvec2(x, y));
        for on_each in 0..12 {
            check(&with_straight_corners(&l, &[on_each, on_each / 2]), &DMat3::IDENTITY);
            check(&with_straight_corners(&l, &[on_each]), &DMat3::from_rotation_x(0.7));
        }
        check(&with_straight_corners(&l[..3], &[3, 0, 5]), &DMat3::from_rotation_y(1.1));
    }

    #[test]
    fn a_hole_is_reached_by_an_edge_that_runs_there_and_back() {
        let outer = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (0.0, 0.0)];
        let hole = [(1.0, 1.0), (1.0, 3.0), (3.0, 3.0), (3.0, 1.0), (1.0, 1.0)];
        let corners: Vec<DVec2> = outer.iter().chain(&hole).map(|(x, y)| dvec2(*x, *y)).collect();
        let found = triangles(&corners.iter().map(|corner| corner.extend(1.0)).collect::<Vec<_>>());
        let areas = found.iter().map(|triangle| area(&triangle.map(|corner| corners[corner])));
        let (min, sum) = areas.fold((1.0, 0.0), |(min, sum), area| (area.min(min), sum + area));
        assert!(min >= 0.0 && sum == 24.0, "{min} {sum}");
    }

    #[test]
    fn convex_polygons_are_fans_and_bent_ones_do_not_matter() {
        let bent = [
            dvec3(0.0, 0.0, 0.0),
            dvec3(1.0, 0.0, 0.1),
            dvec3(1.0, 1.0, 0.0),
            dvec3(0.0, 1.0, 0.1),
        ];
        assert_eq!(triangles(&bent), [[0, 1, 2], [0, 2, 3]]);
        let mut back = bent;
        back.reverse();
        assert_eq!(triangles(&back), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn what_is_no_polygon_gets_triangles_all_the_same() {
        let star: Vec<DVec3> = (0..5)
            .map(|i| DVec2::from_angle(f64::from(i) * 0.8 * std::f64::consts::PI).extend(0.0))
            .collect();
        assert_eq!(triangles(&star).len(), 3);
        assert_eq!(triangles(&[DVec3::ONE; 7]).len(), 5);
        let line: Vec<DVec3> = (0..9).map(|i| DVec3::X * f64::from(i)).collect();
        assert_eq!(triangles(&line).len(), 7);
    }

    #[test]
    fn many_corners_take_no_time() {
        // A comb of 100,000 corners: it would take seconds if each ear test visited every corner.
        let mut corners = vec![DVec3::ZERO, dvec3(25_000.0, 0.0, 0.0)];
        for i in (0..25_000).rev() {
            let x = f64::from(i);
            for (x, y) in [(x + 1.0, 1.0), (x + 0.5, 1.0), (x + 0.5, 3.0), (x, 3.0)] {
                corners.push(dvec3(x, y, 0.0));
            }
        }
        assert_eq!(triangles(&corners).len(), corners.len() - 2);
    }
}
