//! Plans a frame: which sub-patches of which patches are drawn, with how many cells, and in which
//! lists.
//!
//! The triangles of a sub-patch form a regular grid of n × m cells, so the bound of `bound.rs`
//! holds for all of them, however a driver would connect an inside to an edge of another level. An
//! edge has one level: the largest that the patches at the edge need. If the grid of a patch is
//! finer than an edge of it, its vertices on the edge move to the positions that the edge's level
//! gives, towards the middle of the edge, which is where the diagonals of the cells point. All
//! patches at the edge then have the same vertices there, and no triangle reaches further along the
//! edge than 1/level (`glsl/exact/surface.tese`). This assumes that a driver divides a patch of
//! equal levels into a regular grid whose diagonals point to the middle. Direct3D requires it and
//! Mesa does it; OpenGL does not specify the diagonals.
//!
//! A patch that needs more than 16 cells along a side is drawn as 2ⁱ × 2ʲ sub-patches, each with
//! its own bound. So are patches that trims cut, and patches that span a large range of depth. The
//! levels of a patch's edges are multiples of 2ⁱ along u and of 2ʲ along v.

mod splitting;
#[cfg(test)]
mod tests;

use bytemuck::{Pod, Zeroable};
use fearless_simd::Level;
use glam::DVec4;

use super::bound::{
    Candidate, ClipNet, Need, Points, Rounding, Screen, TOGETHER, ToClip, needs_of,
};
use super::edges::{EdgeTable, SIDES};
use super::normal_cone::{Eye, NormalCone, PatchKind};
use super::square_nets::with_side;
use super::sub_patches::{Cut, Tessellated, TrimSplits};
use super::surface_trims::{PatchCut, SurfaceTrims};
use crate::bezier::Degree;
use crate::scene::TessLevel;
use splitting::Leaf;

/// The largest number of cells along a sub-patch that OpenGL supports.
const MAX_CELLS: u32 = 64;

/// One sub-patch of a patch, in the layout that the vertex stage reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct SubPatch {
    /// Texel index of the patch's first control point.
    pub(crate) first_point: u32,
    /// Index of the patch in the scene.
    pub(crate) patch: u32,
    /// Index of the surface's matrices.
    pub(crate) surface: u32,
    /// Column (from bit 0, along u) and row (from bit 16, along v) of the sub-patch.
    pub(crate) place: u32,
    /// Levels of its four edges, 8 bits each in the order of `gl_TessLevelOuter`.
    pub(crate) edges: u32,
    /// From bit 0, 8 bits each: cells along u and v, columns and rows of the patch's control points.
    pub(crate) cells: u32,
    /// Number of the patch's sub-patches along u (from bit 0) and v (from bit 16).
    pub(crate) sub_patches: u32,
    /// Where its trims are, if they may cut it; see [`TrimmedList::place`].
    pub(crate) trims: u32,
}

impl SubPatch {
    const fn cells_along(&self) -> [u32; 2] {
        [self.cells & 0xff, self.cells >> 8 & 0xff]
    }
}

impl Tessellated for SubPatch {
    fn vertices(&self) -> u32 {
        let [along_u, along_v] = self.cells_along();
        (along_u + 1) * (along_v + 1)
    }

    /// Degenerate triangles along coarser edges count too.
    fn triangles(&self) -> u64 {
        let [along_u, along_v] = self.cells_along();
        2 * u64::from(along_u) * u64::from(along_v)
    }
}

/// The indices of the lists that a surface's sub-patches go to. The sub-patches of a list share one
/// program and one set of textures.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Lists {
    /// For sub-patches that the trims keep completely, by [`PatchKind`].
    pub(crate) kept: [u32; PatchKind::ALL.len()],
    /// For sub-patches that a trim may cut, for each grid of the surface's trims.
    pub(crate) trimmed: Vec<TrimmedList>,
}

/// The lists for the sub-patches that one grid of trims may cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TrimmedList {
    /// By [`PatchKind`].
    pub(crate) lists: [u32; PatchKind::ALL.len()],
    /// What the shaders need to find the grid: from bit 0, the index of its first word in the buffer of all grids,
    /// divided by 8; from bit 24, the number of columns of its loops' cells as a power of two.
    pub(crate) place: u32,
}

/// The properties of a surface that planning needs.
#[derive(Debug)]
pub(crate) struct SurfacePatches<'a> {
    pub(crate) degree: Degree,
    /// Points along a side of the patches' square nets.
    pub(crate) net_side: usize,
    /// (x, y, z, weight) of the square nets of all patches ([`super::SquareNets`]).
    pub(crate) nets: &'a [DVec4],
    pub(crate) to_clip: ToClip,
    pub(crate) rounding: Rounding,
    pub(crate) cones: &'a [NormalCone],
    /// For surfaces whose back-facing patches are culled: the viewpoint, and −1 if the front is the
    /// side from which u and v turn clockwise in the surface's own space, otherwise 1.
    pub(crate) back: Option<(Eye, f64)>,
    /// Whether nothing of it is drawn.
    pub(crate) hidden: bool,
    /// The level is fixed if the frame has one.
    pub(crate) trims: &'a mut SurfaceTrims,
    pub(crate) first_point: u32,
    pub(crate) first_patch: u32,
    pub(crate) number: u32,
    pub(crate) lists: &'a Lists,
}

impl SurfacePatches<'_> {
    /// The square nets of all patches.
    fn patches<const N: usize>(&self) -> &[Points<N>] {
        self.nets.as_chunks().0.as_chunks().0
    }

    /// Whether a patch is culled because it faces away.
    fn is_back<const N: usize>(&self, patch: usize) -> bool {
        self.back.is_some_and(|(eye, sign)| {
            let points = self.patches::<N>()[patch].as_flattened();
            self.cones[patch].faces_away(points, eye, sign)
        })
    }

    /// The needs of up to `TOGETHER` patches from `first` on; `None` for those that face away, are
    /// out of view or hidden.
    fn needs<const N: usize>(&self, first: usize, screen: &Screen) -> [Option<Need>; TOGETHER] {
        if self.hidden {
            return [None; TOGETHER];
        }
        let patches = &self.patches::<N>()[first..];
        let none = Candidate { points: &patches[0], is_rational: false, place: 0 };
        let (mut candidates, mut count) = ([none; TOGETHER], 0);
        for (place, points) in patches.iter().enumerate().take(TOGETHER) {
            let patch = first + place;
            if !self.is_back::<N>(patch) {
                let is_rational = self.cones[patch].is_rational();
                candidates[count] = Candidate { points, is_rational, place };
                count += 1;
            }
        }
        let candidates = &candidates[..count];
        let mut needs = [None; TOGETHER];
        let processor = Level::new();
        needs_of(processor, candidates, &self.to_clip, &self.rounding, screen, &mut needs);
        needs
    }

    /// The control net of a patch in clip space.
    fn net<const N: usize>(&self, patch: usize) -> ClipNet<N> {
        let points = &self.patches::<N>()[patch];
        ClipNet::new((), |_| points, self.cones[patch].is_rational(), &self.to_clip)
    }
}

/// Statistics of a frame.
#[must_use = "it says whether the tolerance was met"]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FrameStats {
    /// Number of patches in the scene, including the triangles of its meshes.
    pub patches: usize,
    /// Number of patches of which nothing was drawn: hidden, out of view, cut away by trims, or back-facing if those
    /// are culled.
    pub culled: usize,
    /// Number of triangles drawn.
    pub triangles: u64,
    /// Number of draw calls.
    pub draws: usize,
    /// Upper bound of the distance on the screen between the drawn triangles and the surfaces, in
    /// pixels. Infinite if a patch crosses the near plane and has too few triangles for a bound.
    /// The thesis' method computes no bound.
    pub largest_bound: Option<f64>,
    /// The largest bound that is above the tolerance, if any. A limit was then reached: 2¹³ cells
    /// along a side of a patch, 64 levels for a triangle of a mesh, or the precision of `f32`.
    /// Objects that are drawn at a fixed level do not count.
    pub unmet: Option<f64>,
}

impl FrameStats {
    /// Adds the statistics of other draws.
    pub(crate) fn add(&mut self, other: &Self) {
        self.patches += other.patches;
        self.culled += other.culled;
        self.triangles += other.triangles;
        self.draws += other.draws;
        let bounds = [&mut self.largest_bound, &mut self.unmet];
        for (own, other) in bounds.into_iter().zip([other.largest_bound, other.unmet]) {
            if let Some(other) = other {
                raise(own, other);
            }
        }
    }
}

/// Replaces `max` by `value` if that is larger, or if there is no maximum yet.
pub(crate) fn raise(max: &mut Option<f64>, value: f64) {
    *max = Some(max.map_or(value, |max| max.max(value)));
}

/// The tessellation chosen for a patch.
#[derive(Debug, Clone, Copy, Default)]
struct State {
    /// `false` if nothing of the patch is drawn.
    drawn: bool,
    /// Split depth along u and v: the patch has 2^depth sub-patches in each direction.
    depth: [u8; 2],
    /// Cells along u and v if the patch is not split.
    cells: [u8; 2],
    /// If the patch is split, the index in [`Plan::cells`] of its first sub-patch.
    first_cell: u32,
    /// Diagonal of the patch's possibly visible region on the screen, in pixels.
    extent: f32,
}

/// The level of an edge, and the largest split depth along it of the patches that it belongs to.
#[derive(Debug, Clone, Copy, Default)]
struct Edge {
    level: u32,
    /// As wide as the level, although the values are small: with a narrower field, reading an edge
    /// shortly after it was written would stall.
    depth: u32,
}

impl Edge {
    /// The level, rounded up so that the sub-patches of all patches at the edge have integer
    /// levels.
    const fn rounded(self) -> u32 {
        self.level.next_multiple_of(1 << self.depth)
    }
}

/// The tessellation of a sub-patch: the number of the patch's sub-patches along u and v, its own
/// column and row, and the levels of its edges.
struct Grid {
    sides: [u32; 2],
    place: [u32; 2],
    edges: [u32; SIDES],
}

/// The plan of a frame. Its buffers are reused from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct Plan {
    /// For each patch of all surfaces.
    states: Vec<State>,
    /// For each edge of the table.
    edges: Vec<Edge>,
    /// Cells along u and v of the sub-patches of split patches, row by row; 0 where nothing is
    /// drawn.
    cells: Vec<[u8; 2]>,
    /// Working storage for splitting one patch.
    leaves: Vec<Leaf>,
    lists: Vec<Vec<SubPatch>>,
    stats: FrameStats,
}

impl Plan {
    /// The sub-patches of each list.
    pub(crate) fn lists(&self) -> &[Vec<SubPatch>] {
        &self.lists
    }

    pub(crate) const fn stats(&self) -> FrameStats {
        self.stats
    }

    fn clear(&mut self, lists: usize) {
        self.states.clear();
        self.edges.clear();
        self.cells.clear();
        self.lists.resize_with(lists, Vec::new);
        self.lists.iter_mut().for_each(Vec::clear);
        self.stats = FrameStats::default();
    }

    /// Plans a frame with the same fixed level for all patches.
    pub(crate) fn at_level(
        &mut self,
        surfaces: &[SurfacePatches<'_>],
        lists: usize,
        screen: &Screen,
        level: TessLevel,
    ) {
        self.clear(lists);
        for surface in surfaces {
            with_side!(surface.net_side, N => self.surface_at_level::<N>(surface, screen, level));
        }
    }

    fn surface_at_level<const N: usize>(
        &mut self,
        surface: &SurfacePatches<'_>,
        screen: &Screen,
        level: TessLevel,
    ) {
        let level = f64::from(level.get());
        let count = surface.cones.len();
        let needs = (0..count)
            .step_by(TOGETHER)
            .flat_map(|first| surface.needs::<N>(first, screen))
            .take(count);
        for (patch, need) in needs.enumerate() {
            self.stats.patches += 1;
            let Some(need) = need else {
                self.stats.culled += 1;
                continue;
            };
            raise(&mut self.stats.largest_bound, need.bound.error([level; 2], screen));
            let Some(fixed) = surface.trims.fixed(patch) else {
                self.stats.culled += 1;
                continue;
            };
            let sides = [fixed.split.side; 2];
            for (is_trimmed, places) in [(false, &fixed.kept), (true, &fixed.trimmed)] {
                for place in places {
                    let edges = [fixed.split.level; SIDES];
                    self.push(surface, patch, is_trimmed, &Grid { sides, place: *place, edges });
                }
            }
            self.stats.culled += usize::from(fixed.kept.is_empty() && fixed.trimmed.is_empty());
        }
    }

    /// Plans a frame within the screen's tolerance.
    pub(crate) fn within_tolerance(
        &mut self,
        surfaces: &mut [SurfacePatches<'_>],
        table: &EdgeTable,
        lists: usize,
        screen: &Screen,
    ) {
        self.clear(lists);
        self.edges.resize(table.count(), Edge::default());
        for surface in &mut *surfaces {
            with_side!(surface.net_side, N => self.surface_within::<N>(surface, table, screen));
        }
        self.agree(table);
        for surface in surfaces {
            for patch in 0..surface.cones.len() {
                self.emit(surface, patch, table);
            }
        }
    }

    /// Chooses the tessellation of each patch of a surface regardless of its neighbours, and raises
    /// the levels of the patches' edges to their needs.
    fn surface_within<const N: usize>(
        &mut self,
        surface: &mut SurfacePatches<'_>,
        table: &EdgeTable,
        screen: &Screen,
    ) {
        let count = surface.cones.len();
        for first in (0..count).step_by(TOGETHER) {
            let needs = surface.needs::<N>(first, screen);
            for (patch, need) in (first..count).zip(needs) {
                let state = need.map_or_else(State::default, |need| {
                    self.decide(&need, screen, &surface.rounding, || surface.net::<N>(patch))
                });
                let state = match surface.trims.of(patch) {
                    PatchCut::Kept => state,
                    PatchCut::Gone => State::default(),
                    PatchCut::Grid(grid) => {
                        let splits = surface.trims.splits(grid);
                        self.without_cut_sub_patches(state, splits).unwrap_or_default()
                    }
                };
                self.stats.patches += 1;
                self.stats.culled += usize::from(!state.drawn);
                if state.drawn {
                    self.ask(state, table.of(self.states.len()));
                }
                self.states.push(state);
            }
        }
    }

    /// Cells of the sub-patch in the given column and row.
    fn cells_of(&self, state: &State, [column, row]: [usize; 2]) -> [u8; 2] {
        if state.depth == [0; 2] {
            return state.cells;
        }
        self.cells[state.first_cell as usize + (row << state.depth[0]) + column]
    }

    /// Removes the sub-patches that the trims cut away; returns `None` if nothing remains. If the
    /// trims cut a patch in part and it is large enough on the screen, it is split further first.
    fn without_cut_sub_patches(
        &mut self,
        mut state: State,
        trims: &mut TrimSplits,
    ) -> Option<State> {
        if !state.drawn {
            return None;
        }
        let wanted = trims.depth(state.extent);
        for axis in 0..2 {
            while state.depth[axis] < wanted {
                self.refine(&mut state, axis);
            }
        }
        let cuts = trims.cuts(state.depth);
        if state.depth == [0; 2] {
            return cuts[0].is_drawn().then_some(state);
        }
        let cells = &mut self.cells[state.first_cell as usize..][..cuts.len()];
        for (cells, cut) in cells.iter_mut().zip(cuts) {
            if !cut.is_drawn() {
                *cells = [0; 2];
            }
        }
        cells.iter().any(|cells| *cells != [0; 2]).then_some(state)
    }

    /// Raises the levels and depths of a patch's edges to the patch's needs.
    fn ask(&mut self, state: State, edges: [usize; SIDES]) {
        for (side, edge) in edges.into_iter().enumerate() {
            let axis = axis_of(side);
            let level = self.along_side(&state, side) << state.depth[axis];
            let edge = &mut self.edges[edge];
            edge.level = edge.level.max(level);
            edge.depth = edge.depth.max(state.depth[axis].into());
        }
    }

    /// The largest number of cells along a side of the patch that any sub-patch at this side has.
    fn along_side(&self, state: &State, side: usize) -> u32 {
        let axis = axis_of(side);
        if state.depth == [0; 2] {
            return state.cells[axis].into();
        }
        let last = state.depth.map(|depth| (1_usize << depth) - 1);
        let across = if side < 2 { 0 } else { last[1 - axis] };
        let cells = (0..=last[axis]).map(|i| {
            let place = if axis == 0 { [i, across] } else { [across, i] };
            self.cells_of(state, place)[axis]
        });
        cells.max().unwrap_or(0).into()
    }

    /// Splits patches further until no edge of a sub-patch has more levels than OpenGL supports: a
    /// neighbour may need a higher level than the patch.
    fn agree(&mut self, table: &EdgeTable) {
        if self.edges.iter().all(|edge| edge.level <= MAX_CELLS && edge.depth == 0) {
            return;
        }
        loop {
            let mut changed = false;
            for patch in 0..self.states.len() {
                let mut state = self.states[patch];
                if !state.drawn {
                    continue;
                }
                for (side, edge) in table.of(patch).into_iter().enumerate() {
                    let axis = axis_of(side);
                    while self.edges[edge].rounded() >> state.depth[axis] > MAX_CELLS {
                        self.refine(&mut state, axis);
                        changed = true;
                        self.ask(state, table.of(patch));
                    }
                }
                self.states[patch] = state;
            }
            if !changed {
                break;
            }
        }
    }

    /// Appends the sub-patches of a patch to their lists.
    fn emit(&mut self, surface: &mut SurfacePatches<'_>, patch: usize, table: &EdgeTable) {
        let number = surface.first_patch as usize + patch;
        let state = self.states[number];
        if !state.drawn {
            return;
        }
        let sides = state.depth.map(|depth| 1_u32 << depth);
        let mut borders = [0; SIDES];
        for (side, edge) in table.of(number).into_iter().enumerate() {
            borders[side] = self.edges[edge].rounded() >> state.depth[axis_of(side)];
        }
        let grid = match surface.trims.of(patch) {
            PatchCut::Grid(grid) => Some(grid),
            PatchCut::Kept | PatchCut::Gone => None,
        };
        let is_trimmed = |cut: Option<Cut>| cut.is_some_and(Cut::is_trimmed);
        if state.depth == [0; 2] {
            // Nearly all patches are unsplit. Handling them separately reduces the time of planning
            // by a sixth.
            let cut = grid.map(|grid| surface.trims.splits(grid).cuts([0; 2])[0]);
            let grid = Grid { sides, place: [0; 2], edges: borders };
            self.push(surface, patch, is_trimmed(cut), &grid);
            return;
        }
        let last = sides.map(|sub_patches| sub_patches as usize - 1);
        for row in 0..=last[1] {
            for column in 0..=last[0] {
                let own = self.cells_of(&state, [column, row]);
                if own == [0; 2] {
                    continue;
                }
                let with = |neighbour: Option<[usize; 2]>, border: u32, axis: usize| match neighbour
                {
                    None => border,
                    Some(place) => u32::from(own[axis].max(self.cells_of(&state, place)[axis])),
                };
                let edges = [
                    with(column.checked_sub(1).map(|left| [left, row]), borders[0], 1),
                    with(row.checked_sub(1).map(|below| [column, below]), borders[1], 0),
                    with((column < last[0]).then_some([column + 1, row]), borders[2], 1),
                    with((row < last[1]).then_some([column, row + 1]), borders[3], 0),
                ];
                let cut = grid.map(|grid| {
                    let cuts = surface.trims.splits(grid).cuts(state.depth);
                    cuts[(row << state.depth[0]) + column]
                });
                let place = [column as u32, row as u32];
                self.push(surface, patch, is_trimmed(cut), &Grid { sides, place, edges });
            }
        }
    }

    /// Appends a sub-patch to its list.
    #[inline]
    fn push(&mut self, surface: &SurfacePatches<'_>, patch: usize, is_trimmed: bool, grid: &Grid) {
        let Grid { sides, place, edges } = grid;
        let (lists, trims) = match surface.trims.of(patch) {
            PatchCut::Grid(grid) if is_trimmed => {
                let trimmed = &surface.lists.trimmed[grid as usize];
                (&trimmed.lists, trimmed.place)
            }
            _ => (&surface.lists.kept, 0),
        };
        let list = lists[surface.cones[patch].kind() as usize];
        let mut cells = [edges[1].max(edges[3]), edges[0].max(edges[2])];
        if cells != [1, 1] {
            // If any level is above 1, OpenGL replaces inner levels of 1 by 2.
            cells = cells.map(|cells| cells.max(2));
        }
        let sub_patch = SubPatch {
            first_point: surface.first_point + (patch * surface.degree.points()) as u32,
            patch: surface.first_patch + patch as u32,
            surface: surface.number,
            place: place[0] | place[1] << 16,
            edges: edges[0] | edges[1] << 8 | edges[2] << 16 | edges[3] << 24,
            cells: cells[0]
                | cells[1] << 8
                | (surface.degree.columns() as u32) << 16
                | (surface.degree.rows() as u32) << 24,
            sub_patches: sides[0] | sides[1] << 16,
            trims,
        };
        self.stats.triangles += sub_patch.triangles();
        self.lists[list as usize].push(sub_patch);
    }
}

/// The axis that a side is parallel to, 0 for u and 1 for v: the sides u = 0 and u = 1 run along v.
const fn axis_of(side: usize) -> usize {
    1 - side % 2
}
