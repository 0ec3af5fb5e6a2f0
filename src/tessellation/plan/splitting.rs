//! Splits patches in halves until each sub-patch needs few cells or is out of view.

use super::{MAX_CELLS, Plan, State, raise};
use crate::tessellation::bound::{Bound, ClipNet, Need, Rounding, Screen};

/// A patch that needs more cells along a side is split. Each sub-patch has its own bound and is not
/// drawn if it is out of view, but very small sub-patches cost more than they save. At 0.5 px the
/// teapot has 34,562 triangles if this value is 32, 27,492 if it is 16, and 27,158 if it is 12.
const MAX_WHOLE: f64 = 16.0;
/// A patch has at most 2⁷ sub-patches along a side.
const MAX_DEPTH: u8 = 7;
/// How many times a sub-patch is divided into quarters to bound its error more closely.
const DEEPER: u32 = 6;

/// A sub-patch of a patch that is being split: its depth, its column and row at this depth, and its
/// cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaf {
    depth: [u8; 2],
    place: [u32; 2],
    /// `None` if it is out of view, and until the number of cells is decided.
    cells: Option<[u8; 2]>,
}

impl Plan {
    /// Chooses the tessellation of a patch that may be visible, from its need.
    #[inline]
    pub(super) fn decide<const N: usize>(
        &mut self,
        need: &Need,
        screen: &Screen,
        rounding: &Rounding,
        net: impl Fn() -> ClipNet<N>,
    ) -> State {
        let extent = need.bound.extent as f32;
        let [along_u, along_v] = need.levels;
        if along_u <= MAX_WHOLE && along_v <= MAX_WHOLE && !is_too_deep(&need.bound, screen) {
            let cells = self.settle(need, screen, rounding, net);
            return State { drawn: true, cells, extent, ..State::default() };
        }
        self.leaves.clear();
        self.halve(&net(), screen, rounding, Leaf { depth: [0; 2], place: [0; 2], cells: None });
        State { extent, ..self.gather() }
    }

    /// The numbers of cells that a sub-patch is drawn with: its need, limited to what OpenGL
    /// supports. The bound of the error goes into the statistics.
    #[inline]
    fn settle<const N: usize>(
        &mut self,
        need: &Need,
        screen: &Screen,
        rounding: &Rounding,
        net: impl Fn() -> ClipNet<N>,
    ) -> [u8; 2] {
        let cells = need.levels.map(|level| level.min(MAX_CELLS.into()));
        let mut error = need.error;
        if cells != need.levels || error > screen.tolerance() {
            error = left_over(&net(), &need.bound, cells, screen, rounding, DEEPER);
            if error > screen.tolerance() {
                raise(&mut self.stats.unmet, error);
            }
        }
        raise(&mut self.stats.largest_bound, error);
        cells.map(|cells| cells as u8)
    }

    /// Halves a sub-patch until its parts need few cells or are out of view, and appends these to
    /// the leaves.
    fn halve<const N: usize>(
        &mut self,
        net: &ClipNet<N>,
        screen: &Screen,
        rounding: &Rounding,
        sub_patch: Leaf,
    ) {
        if net.is_outside() {
            self.leaves.push(sub_patch);
            return;
        }
        let need = Need::new(net.bound(screen, rounding), screen);
        let too_deep = is_too_deep(&need.bound, screen);
        let levels = need.levels;
        let may_be_halved = [0, 1].map(|axis| {
            (levels[axis] > MAX_WHOLE || too_deep) && sub_patch.depth[axis] < MAX_DEPTH
        });
        let axis = match may_be_halved {
            [false, false] => {
                let cells = self.settle(&need, screen, rounding, || *net);
                self.leaves.push(Leaf { cells: Some(cells), ..sub_patch });
                return;
            }
            // The direction with more cells; if they are equal, u and v in turn.
            [true, true] => {
                usize::from((levels[1], sub_patch.depth[0]) > (levels[0], sub_patch.depth[1]))
            }
            [along_u, _] => usize::from(!along_u),
        };
        let halves = if axis == 0 { net.halves_along_u() } else { net.halves_along_v() };
        for (i, half) in (0..).zip(&halves) {
            let mut sub_patch = sub_patch;
            sub_patch.depth[axis] += 1;
            sub_patch.place[axis] = 2 * sub_patch.place[axis] + i;
            self.halve(half, screen, rounding, sub_patch);
        }
    }

    /// Distributes the leaves over a regular grid of sub-patches, which is as fine as the deepest
    /// visible leaf in each direction. A larger leaf is divided into several sub-patches, and so
    /// are its cells.
    fn gather(&mut self) -> State {
        let seen = || self.leaves.iter().filter(|leaf| leaf.cells.is_some());
        let max = |axis: usize| seen().map(|leaf| leaf.depth[axis]).max();
        let (Some(along_u), Some(along_v)) = (max(0), max(1)) else { return State::default() };
        let depth = [along_u, along_v];
        let first_cell = self.new_cells(depth);
        for leaf in &self.leaves {
            let Some(cells) = leaf.cells else { continue };
            let more = [0, 1].map(|axis| depth[axis] - leaf.depth[axis]);
            let cells = [0, 1].map(|axis| u32::from(cells[axis]).div_ceil(1 << more[axis]) as u8);
            for v in leaf.place[1] << more[1]..(leaf.place[1] + 1) << more[1] {
                for u in leaf.place[0] << more[0]..(leaf.place[0] + 1) << more[0] {
                    let place = first_cell + ((v << along_u) + u) as usize;
                    self.cells[place] = cells;
                }
            }
        }
        State { drawn: true, depth, first_cell: first_cell as u32, ..State::default() }
    }

    /// Makes room for the cells of a patch's sub-patches; returns the index of the first.
    fn new_cells(&mut self, depth: [u8; 2]) -> usize {
        let first = self.cells.len();
        self.cells.resize(first + (1 << (depth[0] + depth[1])), [0; 2]);
        first
    }

    /// Halves all sub-patches of a patch along one axis, and their numbers of cells, rounded up.
    pub(super) fn refine(&mut self, state: &mut State, axis: usize) {
        let old = *state;
        state.depth[axis] += 1;
        let first = self.new_cells(state.depth);
        let columns = 1 << state.depth[0];
        for i in 0..1_usize << (state.depth[0] + state.depth[1]) {
            let mut place = [i % columns, i / columns];
            place[axis] /= 2;
            let mut cells = self.cells_of(&old, place);
            cells[axis] = cells[axis].div_ceil(2);
            self.cells[first + i] = cells;
        }
        state.first_cell = first as u32;
        state.cells = [0; 2];
    }
}

/// Upper bound of the error of a sub-patch with the given cells. If the bound of the whole
/// sub-patch is above the tolerance, the largest bound of its quarters is used, recursively up to
/// `deeper` times: it may be lower, because quarters that are out of view do not count.
fn left_over<const N: usize>(
    net: &ClipNet<N>,
    bound: &Bound,
    cells: [f64; 2],
    screen: &Screen,
    rounding: &Rounding,
    deeper: u32,
) -> f64 {
    let error = bound.error(cells, screen);
    // The rounding error of quarters is only smaller if the range of depth is large.
    let hopeless = bound.rounding > screen.tolerance() && bound.depth_ratio <= 2.0;
    if error <= screen.tolerance() || deeper == 0 || hopeless {
        return error;
    }
    let halves = net.halves_along_u();
    let quarters = halves.iter().flat_map(ClipNet::halves_along_v);
    quarters
        .filter(|quarter| !quarter.is_outside())
        .map(|quarter| {
            let bound = quarter.bound(screen, rounding);
            let cells = cells.map(|cells| 0.5 * cells);
            left_over(&quarter, &bound, cells, screen, rounding, deeper - 1)
        })
        .fold(0.0, f64::max)
}

/// Whether the bound of a sub-patch's rounding error is considerable and its range of depth large.
/// Its parts then have smaller bounds.
fn is_too_deep(bound: &Bound, screen: &Screen) -> bool {
    bound.rounding > 0.1 * screen.tolerance() && bound.depth_ratio > 2.0
}
