//! Finds boxes at a place among many.

use glam::DVec3;

/// The least and the largest corner.
pub(super) type Bounds = [DVec3; 2];

/// A box that is larger by `by` on every side.
pub(super) fn widened([low, high]: Bounds, by: f64) -> Bounds {
    [low - by, high + by]
}

/// Boxes, each half of which has a box of its own, again and again.
pub(super) struct BoxTree {
    /// Node i has the children 2i + 1 and 2i + 2; the leaves are the last ones.
    nodes: Vec<Bounds>,
    /// The boxes of the leaves, `LEAF` each, with their numbers.
    boxes: Vec<(Bounds, usize)>,
}

/// Boxes of a leaf.
const LEAF: usize = 4;
/// A box that nothing meets.
const EMPTY: Bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];

impl BoxTree {
    pub(super) fn new(boxes: impl Iterator<Item = Bounds>) -> Self {
        let mut boxes: Vec<(Bounds, usize)> = boxes.zip(0..).collect();
        let leaves = boxes.len().div_ceil(LEAF).next_power_of_two();
        boxes.resize(leaves * LEAF, (EMPTY, usize::MAX));
        let mut tree = Self { nodes: vec![EMPTY; 2 * leaves - 1], boxes };
        tree.build(0, 0, leaves * LEAF);
        tree
    }

    fn build(&mut self, node: usize, first: usize, count: usize) {
        let own = &mut self.boxes[first..first + count];
        let bounds = own.iter().fold(EMPTY, |[low, high], ([own_low, own_high], _)| {
            [low.min(*own_low), high.max(*own_high)]
        });
        self.nodes[node] = bounds;
        if count == LEAF {
            return;
        }
        let size = bounds[1] - bounds[0];
        let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
        // Padding comes last: its middle is not a number.
        let middle = |([low, high], _): &(Bounds, usize)| low[axis] + high[axis];
        own.select_nth_unstable_by(count / 2, |a, b| {
            let (a, b) = (middle(a), middle(b));
            a.is_nan().cmp(&b.is_nan()).then(a.total_cmp(&b))
        });
        for (child, first) in [(2 * node + 1, first), (2 * node + 2, first + count / 2)] {
            self.build(child, first, count / 2);
        }
    }

    /// Calls a function with the numbers of the boxes that meet another one, until it returns true; returns whether it
    /// did.
    pub(super) fn any(&self, bounds: Bounds, mut is_it: impl FnMut(usize) -> bool) -> bool {
        let meets =
            |[low, high]: &Bounds| low.cmple(bounds[1]).all() && high.cmpge(bounds[0]).all();
        let leaves = self.nodes.len() / 2;
        // A path through the tree leaves one node behind at each level.
        let mut open = [0; usize::BITS as usize];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let node = open[count];
            if !meets(&self.nodes[node]) {
                continue;
            }
            if node < leaves {
                open[count..count + 2].copy_from_slice(&[2 * node + 2, 2 * node + 1]);
                count += 2;
                continue;
            }
            let leaf = &self.boxes[(node - leaves) * LEAF..][..LEAF];
            if leaf.iter().any(|(own, number)| meets(own) && is_it(*number)) {
                return true;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_boxes_at_a_place_are_found_and_no_others() {
        for count in [0, 1, 4, 5, 300] {
            let at = |i: usize| {
                let place = DVec3::new((i * 7 % 31) as f64, (i * 11 % 17) as f64, (i % 3) as f64);
                [place, place + 2.5]
            };
            let tree = BoxTree::new((0..count).map(at));
            for query in (0..40).map(|i| widened(at(13 * i + 5), -0.3 * (i % 4) as f64)) {
                let mut found = Vec::new();
                assert!(!tree.any(query, |number| {
                    found.push(number);
                    false
                }));
                found.sort_unstable();
                let meets =
                    |[low, high]: Bounds| low.cmple(query[1]).all() && high.cmpge(query[0]).all();
                let expected: Vec<usize> = (0..count).filter(|i| meets(at(*i))).collect();
                assert_eq!(found, expected, "{count}");
            }
        }
    }
}
