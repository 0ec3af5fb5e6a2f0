//! Patches of different degree that meet along one curve. The edge of one patch may be the edge of the other, raised to
//! a higher degree. Both patches then get that degree along the edge, so that they are neighbours like any others:
//! their control points on the edge are equal bit for bit.

use glam::DVec4;

use super::disjoint_sets::DisjointSets;
use super::edges::{EdgeSource, SIDES, SideOfPatch};
use crate::bezier::{Degree, elevate, elevate_curve, homogeneous};

/// The patches of a surface at a higher degree than its own.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Raised {
    pub(crate) degree: Degree,
    /// Control points (x, y, z, weight) of all patches.
    pub(crate) points: Vec<DVec4>,
}

/// One side of a patch that another patch may share.
#[derive(Debug, Clone, Copy)]
struct Side {
    source: usize,
    patch: usize,
    side: usize,
    group: u32,
    /// The positions of its ends, bit for bit, the smaller one first.
    ends: [[u64; 3]; 2],
}

impl Side {
    fn degree(&self, sources: &[EdgeSource<'_>]) -> usize {
        SideOfPatch::new(sources[self.source].degree, self.side).count - 1
    }

    /// The surface and the direction of the side's parameter: an index of what is raised together.
    const fn direction(&self) -> usize {
        2 * self.source + (self.side + 1) % 2
    }

    /// The control points of the side, given the degree and the control points of its surface's patches.
    fn points(&self, degree: Degree, points: &[DVec4]) -> Vec<DVec4> {
        let place = SideOfPatch::new(degree, self.side);
        let patch = &points[self.patch * degree.points()..][..degree.points()];
        (0..place.count).map(|i| patch[place.index(i)]).collect()
    }
}

/// Sides along one curve, those of the highest degree first.
struct Common {
    /// The control points of the first side.
    curve: Vec<DVec4>,
    /// The sides, and whether each runs the other way than the first.
    sides: Vec<(Side, bool)>,
}

/// For each source, its patches at a higher degree, if one of them meets a patch of another degree along the same
/// curve. The curves are the same if their control points differ by no more than rounding once they have the same
/// degree.
pub(crate) fn raised(sources: &[EdgeSource<'_>]) -> Vec<Option<Raised>> {
    let mut degrees = sources.iter().flat_map(|source| [source.degree.u(), source.degree.v()]);
    let first = degrees.next();
    if degrees.all(|degree| Some(degree) == first) {
        return vec![None; sources.len()];
    }
    let mut sides = sides_of(sources);
    sides.sort_by_key(|side| {
        (side.group, side.ends, std::cmp::Reverse(side.degree(sources)), side.source, side.patch)
    });
    let own = |side: &Side| side.points(sources[side.source].degree, sources[side.source].points);
    let mut together = DisjointSets::new(2 * sources.len());
    let mut of_two_degrees: Vec<Common> = Vec::new();
    for same_ends in sides.chunk_by(|a, b| (a.group, a.ends) == (b.group, b.ends)) {
        let mut curves: Vec<Common> = Vec::new();
        for side in same_ends {
            let points = own(side);
            let known = curves.iter_mut().find_map(|common| {
                is_same(&points, &common.curve).map(|is_reversed| (common, is_reversed))
            });
            if let Some((common, is_reversed)) = known {
                together.join(common.sides[0].0.direction(), side.direction());
                common.sides.push((*side, is_reversed));
            } else {
                curves.push(Common { curve: points, sides: vec![(*side, false)] });
            }
        }
        let has_two = |common: &Common| {
            let count = common.curve.len();
            common.sides.iter().any(|(side, _)| side.degree(sources) + 1 < count)
        };
        of_two_degrees.extend(curves.into_iter().filter(has_two));
    }
    if of_two_degrees.is_empty() {
        return vec![None; sources.len()];
    }
    let mut all = raise_together(sources, &mut together);
    for Common { curve, sides } in of_two_degrees {
        let [(first, _), others @ ..] = &sides[..] else { continue };
        let curve = match &all[first.source] {
            Some(raised) => first.points(raised.degree, &raised.points),
            None => curve,
        };
        for (side, is_reversed) in others {
            // Those of the highest degree stay as they are.
            if side.degree(sources) < first.degree(sources)
                && let Some(raised) = &mut all[side.source]
            {
                raised.write(side, &curve, *is_reversed);
            }
        }
    }
    all
}

/// The sides of all patches along which other patches may lie. Those between the patches of one NURBS surface and those
/// that are one point are left out.
fn sides_of(sources: &[EdgeSource<'_>]) -> Vec<Side> {
    let mut sides = Vec::new();
    for (number, source) in sources.iter().enumerate() {
        for (patch, points) in source.points.chunks_exact(source.degree.points()).enumerate() {
            for side in 0..SIDES {
                if source.grid.is_some_and(|grid| grid.continues(patch, side)) {
                    continue;
                }
                let place = SideOfPatch::new(source.degree, side);
                let position = |i: usize| points[place.index(i)].truncate();
                if (1..place.count).all(|i| position(i) == position(0)) {
                    continue;
                }
                // Adding 0 turns −0 into 0.
                let bits = |i: usize| (position(i) + 0.0).to_array().map(f64::to_bits);
                let mut ends = [bits(0), bits(place.count - 1)];
                ends.sort_unstable();
                sides.push(Side { source: number, patch, side, group: source.group, ends });
            }
        }
    }
    sides
}

/// Whether a curve is another one of the same or a higher degree, and whether it runs the other way. Curves of one
/// degree are the same if they are equal.
fn is_same(curve: &[DVec4], of: &[DVec4]) -> Option<bool> {
    /// Relative to the largest coordinate, and of a weight.
    const ROUNDING: f64 = 1e-12;
    let raised = elevate_curve(curve, of.len());
    let last = of.len() - 1;
    let size = of.iter().map(|point| point.truncate().abs().max_element()).fold(0.0, f64::max);
    let rounding = if curve.len() == of.len() { 0.0 } else { ROUNDING };
    [false, true].into_iter().find(|reversed| {
        let other = |i: usize| if *reversed { of[last - i] } else { of[i] };
        // The ends belong to the neighbours on other sides, too, so they must be equal.
        let scale = raised[0].w / other(0).w;
        let is_end = |i: usize| {
            raised[i].truncate() == other(i).truncate() && raised[i].w == other(i).w * scale
        };
        let is_near = |i: usize| {
            let off = (homogeneous(raised[i]) / scale - homogeneous(other(i))).abs();
            off.truncate().max_element() <= rounding * size * other(i).w
                && off.w <= rounding * other(i).w
        };
        scale == scale.log2().round().exp2() && is_end(0) && is_end(last) && (1..last).all(is_near)
    })
}

/// All patches whose degree along u or v is less than that of another one of the same set.
fn raise_together(sources: &[EdgeSource<'_>], together: &mut DisjointSets) -> Vec<Option<Raised>> {
    let mut highest = vec![0; 2 * sources.len()];
    for (number, source) in sources.iter().enumerate() {
        for (direction, degree) in [source.degree.u(), source.degree.v()].into_iter().enumerate() {
            let set = together.least(2 * number + direction);
            highest[set] = highest[set].max(degree);
        }
    }
    let raise = |(number, source): (usize, &EdgeSource<'_>)| {
        let [u, v] = [0, 1].map(|direction| highest[together.least(2 * number + direction)]);
        let degree = Degree::new(u, v).ok().filter(|degree| *degree != source.degree)?;
        let patches = source.points.chunks_exact(source.degree.points());
        let points = patches.flat_map(|points| elevate(source.degree, points, degree)).collect();
        Some(Raised { degree, points })
    };
    sources.iter().enumerate().map(raise).collect()
}

impl Raised {
    /// Writes a curve over the inner points of a side. The curve may run the other way.
    fn write(&mut self, side: &Side, curve: &[DVec4], is_reversed: bool) {
        let place = SideOfPatch::new(self.degree, side.side);
        let patch = &mut self.points[side.patch * self.degree.points()..][..self.degree.points()];
        let last = curve.len() - 1;
        let other = |i: usize| if is_reversed { curve[last - i] } else { curve[i] };
        let scale = patch[place.index(0)].w / other(0).w;
        for i in 1..last {
            patch[place.index(i)] = other(i).truncate().extend(other(i).w * scale);
        }
    }

    /// Makes one patch again, of which control points have moved. Points that do not depend on them stay as they are.
    pub(crate) fn update(&mut self, patch: usize, degree: Degree, before: &[DVec4], now: &[DVec4]) {
        let points = &mut self.points[patch * self.degree.points()..][..self.degree.points()];
        let [before, now] = [before, now].map(|points| elevate(degree, points, self.degree));
        for (point, (before, now)) in points.iter_mut().zip(before.iter().zip(&now)) {
            if before != now {
                *point = *now;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degree(u: usize, v: usize) -> Degree {
        Degree::new(u, v).unwrap()
    }

    fn source(degree: Degree, points: &[DVec4]) -> EdgeSource<'_> {
        EdgeSource { degree, points, group: 0, grid: None }
    }

    /// A patch with some shape, that begins at x.
    fn patch(degree: Degree, x: f64) -> Vec<DVec4> {
        let at = |i: usize| {
            let (column, row) = (i % degree.columns(), i / degree.columns());
            let (u, v) = (column as f64 / degree.u() as f64, row as f64 / degree.v() as f64);
            DVec4::new(x + u, v, (3.0 * (x + u) + 2.0 * v).sin(), 1.0 + (u + v + x).fract())
        };
        (0..degree.points()).map(at).collect()
    }

    /// The same surface with its parameters exchanged or reversed.
    fn turned(degree: Degree, points: &[DVec4], turn: usize) -> (Degree, Vec<DVec4>) {
        let (columns, rows) = (degree.columns(), degree.rows());
        let to = if turn & 1 == 1 { self::degree(degree.v(), degree.u()) } else { degree };
        let at = |i: usize| {
            let (column, row) = (i % to.columns(), i / to.columns());
            let (column, row) = if turn & 1 == 1 { (row, column) } else { (column, row) };
            let column = if turn & 2 == 2 { columns - 1 - column } else { column };
            let row = if turn & 4 == 4 { rows - 1 - row } else { row };
            points[row * columns + column]
        };
        (to, (0..to.points()).map(at).collect())
    }

    #[test]
    fn edges_of_two_degrees_become_equal_in_all_orientations() {
        for turn in 0..8 {
            let low = patch(degree(2, 2), 0.0);
            let edge: Vec<DVec4> = [2, 5, 8].map(|i| low[i]).to_vec();
            let mut high = patch(degree(3, 5), 1.0);
            for (row, point) in elevate_curve(&edge, 6).into_iter().enumerate() {
                // Rounding of another program, and other weights; the ends are the same.
                let off = if row % 5 == 0 { 0.0 } else { 1e-14 };
                high[4 * row] = (point.truncate() + off).extend(4.0 * point.w);
            }
            let (to, low) = turned(degree(2, 2), &low, turn);
            // Another patch of the first one's degree, which has to follow it.
            let far: Vec<DVec4> = patch(degree(2, 2), -1.0);
            let mut far = turned(degree(2, 2), &far, turn).1;
            let (left, right) = match turn {
                0 | 4 => ([2, 5, 8], [0, 3, 6]),
                2 | 6 => ([0, 3, 6], [2, 5, 8]),
                1 | 3 => ([6, 7, 8], [0, 1, 2]),
                _ => ([0, 1, 2], [6, 7, 8]),
            };
            let swap = [5, 3].contains(&turn);
            let (left, right) = if swap { (right, left) } else { (left, right) };
            for (own, common) in left.into_iter().zip(right) {
                far[own] = low[common];
            }
            let sources = [source(to, &low), source(degree(3, 5), &high), source(to, &far)];
            let found = raised(&sources);
            let expected = if turn & 1 == 1 { degree(5, 2) } else { degree(2, 5) };
            let degrees = found.iter().map(|raised| raised.as_ref().map(|raised| raised.degree));
            assert!(degrees.eq([Some(expected), None, Some(expected)]), "{turn}");
            let sources: Vec<EdgeSource<'_>> = sources
                .iter()
                .zip(&found)
                .map(|(own, raised)| {
                    raised.as_ref().map_or(*own, |raised| source(raised.degree, &raised.points))
                })
                .collect();
            let table = super::super::EdgeTable::new(&sources);
            assert_eq!(table.count(), 10, "{turn}: two common edges");
        }
    }

    #[test]
    fn other_curves_between_the_same_points_are_left_alone() {
        let low = patch(degree(2, 2), 0.0);
        let mut high = patch(degree(3, 3), 1.0);
        let edge = elevate_curve(&[low[2], low[5], low[8]], 4);
        for (row, point) in edge.iter().enumerate() {
            high[4 * row] = *point;
        }
        let is_raised = |low: &[DVec4], high: &[DVec4]| {
            let sources = [source(degree(2, 2), low), source(degree(3, 3), high)];
            raised(&sources)[0].is_some()
        };
        assert!(is_raised(&low, &high));
        let mut other = high.clone();
        other[4].z += 1e-9;
        assert!(!is_raised(&low, &other));
        let mut other = high.clone();
        other[4].w *= 1.0 + 1e-9;
        assert!(!is_raised(&low, &other));
        // A factor that rounds.
        let other: Vec<DVec4> = high.iter().map(|p| p.truncate().extend(3.0 * p.w)).collect();
        assert!(!is_raised(&low, &other));
        let groups =
            [source(degree(2, 2), &low), EdgeSource { group: 1, ..source(degree(3, 3), &high) }];
        assert_eq!(raised(&groups), [None, None]);
    }

    #[test]
    fn points_that_do_not_move_keep_their_bits() {
        let own = patch(degree(2, 2), 0.0);
        let mut raised =
            Raised { degree: degree(3, 3), points: elevate(degree(2, 2), &own, degree(3, 3)) };
        raised.points[4].x += 1e-15;
        let kept = raised.points[4];
        let mut moved = own.clone();
        moved[8].z += 1.0;
        raised.update(0, degree(2, 2), &own, &moved);
        assert_eq!(raised.points[4], kept);
        assert_eq!(raised.points[15], moved[8]);
    }
}
