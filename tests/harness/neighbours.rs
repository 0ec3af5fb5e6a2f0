//! Whether the triangles of neighbouring patches have the same vertices.

use std::collections::{BTreeSet, HashMap};

use freeform_surface::inspect::DrawnVertex;
use freeform_surface::{Degree, Scene, Surface};
use glam::DVec4;

/// A patch's side, numbered u = 0, v = 0, u = 1, v = 1.
pub type Side = usize;

/// Whether a place in the domain is on a side.
fn is_on(side: Side, uv: [f32; 2]) -> bool {
    uv[side % 2] == (side / 2) as f32
}

/// The control points of a side, from its lower end.
fn control_points_of(side: Side, degree: Degree, points: &[DVec4]) -> Vec<DVec4> {
    let (columns, rows) = (degree.columns(), degree.rows());
    let at_end = side / 2;
    let (first, step, count) = if side.is_multiple_of(2) {
        (at_end * (columns - 1), columns, rows)
    } else {
        (at_end * (rows - 1) * columns, 1, columns)
    };
    (0..count).map(|i| points[first + i * step]).collect()
}

/// The homogeneous point of a curve, by de Casteljau's algorithm.
fn at(points: &[DVec4], t: f64) -> DVec4 {
    let mut line: Vec<DVec4> = points.iter().map(|p| (p.truncate() * p.w).extend(p.w)).collect();
    while line.len() > 1 {
        line = line.windows(2).map(|pair| pair[0].lerp(pair[1], t)).collect();
    }
    line[0]
}

/// The factor between the weights of `a` and those of `b`, if both are the same curve in either direction and
/// the factor is a power of two, which scales without rounding. Curves of different degree are the same if they agree
/// up to rounding.
fn ratio_of_one_curve(a: &[DVec4], b: &[DVec4]) -> Option<f64> {
    if a.len() != b.len() {
        let same_along = |is_reversed: bool| {
            let of_b = |t: f64| at(b, if is_reversed { 1.0 - t } else { t });
            let ratio = at(a, 0.0).w / of_b(0.0).w;
            let apart = (0..=20).map(|i| f64::from(i) / 20.0).map(|t| at(a, t) - of_b(t) * ratio);
            let is_same = apart.fold(0.0, |max, apart| f64::max(max, apart.length())) < 1e-12;
            (is_same && ratio.log2().fract() == 0.0).then_some(ratio)
        };
        return same_along(false).or_else(|| same_along(true));
    }
    let ratio_along = |b: &mut dyn Iterator<Item = &DVec4>| {
        let pairs: Vec<_> = a.iter().zip(b).collect();
        let ratio = a[0].w / pairs[0].1.w;
        let same = pairs.iter().all(|(a, b)| a.truncate() == b.truncate() && a.w == ratio * b.w);
        (same && ratio.log2().fract() == 0.0).then_some(ratio)
    };
    ratio_along(&mut b.iter()).or_else(|| ratio_along(&mut b.iter().rev()))
}

/// A point in clip space, to the last bit.
type Bits = [u32; 4];
/// The two ends of an edge of a triangle: places and (u, v).
type Ends = [(Bits, [u32; 2]); 2];

/// The segments of a side that belong to drawn triangles, each as a pair of vertices.
pub fn segments(corners: &[&[DrawnVertex; 3]], side: Side, weight: f32) -> BTreeSet<[Bits; 2]> {
    let bits = |vertex: &DrawnVertex| vertex.clip.map(|x| (x * weight).to_bits());
    let mut found = BTreeSet::new();
    for triangle in corners {
        for i in 0..3 {
            let (a, b) = (&triangle[i], &triangle[(i + 1) % 3]);
            let both = is_on(side, a.uv) && is_on(side, b.uv) && a.uv != b.uv;
            if both && is_seen([a, b]) {
                let (a, b) = (bits(a), bits(b));
                found.insert(if a < b { [a, b] } else { [b, a] });
            }
        }
    }
    found
}

/// Whether a line is visible, that is, extends into the view frustum by more than the tolerance. Triangles
/// beside an invisible line do not have to be drawn.
fn is_seen(ends: [&DrawnVertex; 2]) -> bool {
    const MIN: f64 = 1.0 - 2e-3;
    let mut seen = [0.0_f64, 1.0];
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            let [a, b] = ends.map(|end| {
                let [w, x] = [end.clip[3], end.clip[axis]].map(f64::from);
                MIN * w - sign * x
            });
            let crossing = a / (a - b);
            match (a > 0.0, b > 0.0) {
                (true, true) => {}
                (true, false) => seen[1] = seen[1].min(crossing),
                (false, true) => seen[0] = seen[0].max(crossing),
                (false, false) => return false,
            }
        }
    }
    seen[0] < seen[1]
}

/// The triangles of each patch, without those of zero area.
pub fn by_patch(drawn: &[DrawnVertex]) -> HashMap<u32, Vec<&[DrawnVertex; 3]>> {
    let mut patches: HashMap<u32, Vec<&[DrawnVertex; 3]>> = HashMap::new();
    for triangle in drawn.as_chunks::<3>().0 {
        let [a, b, c] = triangle.each_ref().map(|vertex| vertex.uv);
        if a != b && b != c && c != a {
            patches.entry(triangle[0].patch).or_default().push(triangle);
        }
    }
    patches
}

/// The amount of the scene's patches that was compared.
#[derive(Default)]
pub struct Met {
    /// Pairs of sides with visible segments.
    pub pairs: usize,
    /// Segments of sides.
    pub segments: usize,
}

/// Fails unless neighbours have the same vertices on the sides that they share.
pub fn check_neighbours(name: &str, scene: &Scene, drawn: &[DrawnVertex]) -> Met {
    let patches = by_patch(drawn);
    let mut sides: Vec<(usize, Side, Vec<DVec4>)> = Vec::new();
    let all = scene.surfaces.iter().flat_map(Surface::patches);
    let mut met = Met::default();
    for (number, patch) in all.enumerate() {
        for side in 0..4 {
            let points = control_points_of(side, patch.degree(), patch.points());
            for (other, other_side, others) in &sides {
                let Some(ratio) = ratio_of_one_curve(&points, others) else { continue };
                let of = |patch: usize, side: Side, weight: f32| {
                    patches
                        .get(&(patch as u32))
                        .map_or_else(BTreeSet::new, |corners| segments(corners, side, weight))
                };
                let (a, b) = (of(number, side, 1.0), of(*other, *other_side, ratio as f32));
                assert!(
                    a == b,
                    "{name}: side {side} of patch {number} has {} segments, side {other_side} of \
                     patch {other} has {}, of them {} alike",
                    a.len(),
                    b.len(),
                    a.intersection(&b).count()
                );
                met.pairs += usize::from(!a.is_empty());
                met.segments += a.len();
            }
            sides.push((number, side, points));
        }
    }
    met
}

/// Fails unless every edge within a patch belongs to two triangles, so that the patch's sub-patches meet.
pub fn check_insides(name: &str, drawn: &[DrawnVertex]) {
    for (number, triangles) in by_patch(drawn) {
        let mut edges: HashMap<Ends, (usize, bool)> = HashMap::new();
        for triangle in triangles {
            for i in 0..3 {
                let ends = [&triangle[i], &triangle[(i + 1) % 3]];
                let at_border = (0..4).any(|side| ends.iter().all(|end| is_on(side, end.uv)));
                let mut key =
                    ends.map(|end| (end.clip.map(f32::to_bits), end.uv.map(f32::to_bits)));
                key.sort_unstable();
                let edge = edges.entry(key).or_insert((0, at_border || !is_seen(ends)));
                edge.0 += 1;
            }
        }
        for (ends, (count, free)) in edges {
            let uv = ends.map(|(_, uv)| uv.map(f32::from_bits));
            assert!(free || count == 2, "{name}: patch {number}, {uv:?} in {count} triangles");
        }
    }
}
