//! Where the surfaces of a scene meet along their borders, without being neighbours by their control points.

mod boxes;
mod rims;

use glam::DVec3;

use self::boxes::{BoxTree, widened};
use self::rims::{Rim, extents, rims};
use super::Surface;
use crate::model::{Border, Joint, JointCurve};
use crate::parallel;

/// The largest distance between borders that meet, as a share of the scene's diagonal.
const MET: f64 = 1e-6;
/// Parameters that differ by less are the same.
const SAME: f64 = 1e-6;
/// Parts of a common curve at whose ends two borders are compared.
const PARTS: u32 = 8;
/// Rims that are compared with an end of a rim at most, so that many that are equal do not cost their square.
const MOST: usize = 64;

/// A joint of two surfaces of a scene.
pub(crate) struct JoinedSurfaces {
    /// In world space.
    pub(crate) joint: Joint,
    /// The patches of the surfaces.
    pub(crate) patches: [usize; 2],
}

/// A place where two rims pass the same point, which is an end of one of them.
#[derive(Debug, Clone, Copy)]
struct Contact {
    rims: [usize; 2],
    at: [f64; 2],
}

/// A part of a rim that is a part of another one, too.
#[derive(Debug, Clone)]
struct Overlap {
    rims: [usize; 2],
    /// On which side of the first rim's direction the surfaces lie.
    sides: [f64; 2],
    /// Parameters of the first rim in ascending order, and those of the other one.
    places: Vec<[f64; 2]>,
    /// The largest distance between the two at these places.
    apart: f64,
}

/// The joints of surfaces whose borders or trims are the same curve in world space, or a part of it. `open` tells of
/// each side of each patch of the scene whether it is no other patch's.
///
/// The curves are the same from one of their ends to another: only rims that pass the ends of each other are compared.
pub(crate) fn joined(surfaces: &[Surface], open: &[[bool; 4]]) -> Vec<JoinedSurfaces> {
    let extents = extents(surfaces);
    let everything = extents
        .iter()
        .map(|extent| extent.bounds)
        .reduce(|[low, high], other| [low.min(other[0]), high.max(other[1])]);
    let Some([low, high]) = everything else { return Vec::new() };
    let diagonal = low.distance(high);
    let tolerance = MET * diagonal;
    let rims = rims(&extents, open, tolerance);
    let contacts = contacts(&rims, tolerance);
    let pairs: Vec<&[Contact]> =
        contacts.chunk_by(|a, b| a.rims == b.rims).filter(|of_pair| of_pair.len() > 1).collect();
    let overlaps = parallel::map(pairs.len(), |number| overlaps(&rims, pairs[number], tolerance));
    let mut overlaps: Vec<Overlap> = overlaps.into_iter().flatten().collect();
    leave_out_covered(&mut overlaps, rims.len());
    parallel::map(overlaps.len(), |number| {
        let Overlap { rims: pair, sides, places, apart } = &overlaps[number];
        let pair = pair.map(|rim| &rims[rim]);
        let border = |i: usize| Border {
            surface: pair[i],
            side: sides[i],
            places: places.iter().map(|at| (at[0], pair[i].uv(at[i]))).collect(),
            gap: if i == 0 { 0.0 } else { *apart },
        };
        let curve = Stretch { rim: pair[0], places };
        let faces = pair.map(|rim| rim.number);
        let joint = Joint::new(number, faces, &curve, [&border(0), &border(1)], diagonal);
        JoinedSurfaces { joint, patches: pair.map(|rim| rim.patch.unwrap_or(0)) }
    })
}

/// Where rims pass ends of others, sorted by pairs and then by the place on the first rim.
fn contacts(rims: &[Rim<'_>], tolerance: f64) -> Vec<Contact> {
    let tree = BoxTree::new(rims.iter().map(|rim| rim.bounds));
    let found = parallel::map(rims.len(), |number| {
        let mut contacts = Vec::new();
        for (end, point) in [0.0, 1.0].into_iter().zip(rims[number].ends) {
            let mut seen = 0;
            tree.any(widened([point; 2], tolerance), |other| {
                if other != number {
                    let at = rims[other].parameters_of(point, tolerance);
                    contacts.extend(at.into_iter().flatten().map(|at| {
                        if number < other {
                            Contact { rims: [number, other], at: [end, at] }
                        } else {
                            Contact { rims: [other, number], at: [at, end] }
                        }
                    }));
                    seen += 1;
                }
                seen >= MOST
            });
        }
        contacts
    });
    let mut contacts: Vec<Contact> = found.into_iter().flatten().collect();
    contacts.sort_unstable_by(|a, b| {
        let by_place = || a.at[0].total_cmp(&b.at[0]).then(a.at[1].total_cmp(&b.at[1]));
        a.rims.cmp(&b.rims).then_with(by_place)
    });
    contacts.dedup_by(|a, b| a.rims == b.rims && (0..2).all(|i| (a.at[i] - b.at[i]).abs() < SAME));
    contacts
}

/// The common parts of two rims, from one contact to the next.
fn overlaps(rims: &[Rim<'_>], contacts: &[Contact], tolerance: f64) -> Vec<Overlap> {
    let is_same_level = |a: &Contact, b: &Contact| (a.at[0] - b.at[0]).abs() < SAME;
    let levels: Vec<&[Contact]> = contacts.chunk_by(is_same_level).collect();
    let mut found = Vec::new();
    for pair in levels.windows(2) {
        let ways = pair[0].iter().flat_map(|from| pair[1].iter().map(move |to| [from, to]));
        let mut ways = ways.filter(|[from, to]| (from.at[1] - to.at[1]).abs() > SAME);
        let whole = ways
            .find_map(|[from, to]| overlap(rims, from.rims, [from.at, to.at], [1.0; 2], tolerance));
        if let Some(whole) = whole {
            kept_parts(rims, whole, tolerance, &mut found);
        }
    }
    found
}

/// The common part of two rims between two places of both, if they are the same there.
fn overlap(
    rims: &[Rim<'_>],
    pair: [usize; 2],
    [from, to]: [[f64; 2]; 2],
    sides: [f64; 2],
    tolerance: f64,
) -> Option<Overlap> {
    let [rim, other] = pair.map(|number| &rims[number]);
    let mut places = vec![from];
    let mut apart = rim.point(from[0]).distance(other.point(from[1]));
    apart = apart.max(rim.point(to[0]).distance(other.point(to[1])));
    for i in 1..PARTS {
        let t = from[0] + f64::from(i) / f64::from(PARTS) * (to[0] - from[0]);
        let last = places[places.len() - 1][1];
        let guess = last + (to[1] - last) / f64::from(PARTS + 1 - i);
        let (at, distance) = other.nearest(rim.point(t), guess);
        apart = apart.max(distance);
        let is_onward =
            (at - last) * (to[1] - from[1]) > 0.0 && (to[1] - at) * (to[1] - from[1]) > 0.0;
        if apart > tolerance || !is_onward {
            return None;
        }
        places.push([t, at]);
    }
    places.push(to);
    (apart <= tolerance).then_some(Overlap { rims: pair, sides, places, apart })
}

/// Appends the parts of a common curve along which both surfaces are there, each on one side.
fn kept_parts(rims: &[Rim<'_>], whole: Overlap, tolerance: f64, found: &mut Vec<Overlap>) {
    const HALVINGS: u32 = 30;
    let [rim, other] = whole.rims.map(|number| &rims[number]);
    let [first, last] = [whole.places[0], whole.places[whole.places.len() - 1]];
    let middle = whole.places[whole.places.len() / 2];
    if rim.is_same_place(other, middle) {
        return;
    }
    let direction = (last[1] - first[1]).signum();
    let kept = |[own, others]: [f64; 2]| Some([rim.kept(own)?, direction * other.kept(others)?]);
    // Ends themselves may be corners, beside which both sides are the same.
    let inner = |at: [[f64; 2]; 2]| [0, 1].map(|i| at[0][i].midpoint(at[1][i]));
    if rim.is_whole() && other.is_whole() {
        found.extend(kept(middle).map(|sides| Overlap { sides, ..whole }));
        return;
    }
    let between = |[low, high]: [[f64; 2]; 2]| {
        let t = low[0].midpoint(high[0]);
        [t, other.nearest(rim.point(t), low[1].midpoint(high[1])).0]
    };
    let spans = whole.places.windows(2).map(|pair| inner([pair[0], pair[1]]));
    let mut probes = vec![first];
    probes.extend(spans);
    probes.push(last);
    let mut start = first;
    let count = probes.len();
    for i in 1..count - 1 {
        let state = kept(probes[i]);
        let next = if i + 2 < count { kept(probes[i + 1]) } else { None };
        if i + 2 < count && next == state {
            continue;
        }
        let mut end = last;
        if i + 2 < count {
            let mut change = [probes[i], probes[i + 1]];
            for _ in 0..HALVINGS {
                let middle = between(change);
                change[usize::from(kept(middle) != state)] = middle;
            }
            end = change[0];
        }
        if let Some(sides) = state
            && (end[0] - start[0]).abs() > SAME
        {
            found.extend(overlap(rims, whole.rims, [start, end], sides, tolerance));
        }
        start = end;
    }
}

/// Leaves out what closes no gap: where both rims are joined to others already, they are joined through these.
fn leave_out_covered(overlaps: &mut Vec<Overlap>, rims: usize) {
    let mut covered: Vec<Vec<[f64; 2]>> = vec![Vec::new(); rims];
    overlaps.retain(|overlap| {
        let ends = [overlap.places[0], overlap.places[overlap.places.len() - 1]];
        let range = |i: usize| {
            let [a, b] = ends.map(|end| end[i]);
            [a.min(b), a.max(b)]
        };
        let is_covered = |i: usize| {
            let [low, high] = range(i);
            let within = |part: &[f64; 2]| part[0] <= low + SAME && high <= part[1] + SAME;
            covered[overlap.rims[i]].iter().any(within)
        };
        let is_new = !(is_covered(0) && is_covered(1));
        if is_new {
            (0..2).for_each(|i| covered[overlap.rims[i]].push(range(i)));
        }
        is_new
    });
}

/// A part of a rim as the curve of a joint.
struct Stretch<'a> {
    rim: &'a Rim<'a>,
    places: &'a [[f64; 2]],
}

impl JointCurve for Stretch<'_> {
    fn breaks(&self) -> Vec<f64> {
        vec![self.places[0][0], self.places[self.places.len() - 1][0]]
    }

    fn point(&self, t: f64) -> DVec3 {
        self.rim.point(t)
    }

    /// The cubic through four points.
    fn cubic(&self, from: f64, to: f64) -> [DVec3; 4] {
        let [a, b, c, d] =
            [0.0, 1.0, 2.0, 3.0].map(|i| self.rim.point(from + i / 3.0 * (to - from)));
        let inner = |near: DVec3, far: DVec3, start: DVec3, end: DVec3| {
            3.0 * near - 1.5 * far - 5.0 / 6.0 * start + end / 3.0
        };
        [a, inner(b, c, a, d), inner(c, b, d, a), d]
    }

    fn distance(&self, point: DVec3, near: f64) -> f64 {
        self.rim.point(near).distance(point)
    }
}

#[cfg(test)]
mod tests;
