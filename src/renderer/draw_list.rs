//! What the exact method keeps from frame to frame about surfaces that are drawn together: which
//! patches are neighbours, which sub-patches are drawn, and their division into draws. If nothing
//! has changed since the last frame, only the draw calls are made.

use std::collections::{BTreeMap, HashMap};
use std::ops::Range;
use std::rc::Rc;

use bytemuck::Pod;
use glam::{DMat3, DMat4, DVec4, Vec4};

use super::curvature::automatic_limit;
use super::draws::{Draw, PlanKey, divide_into_instances};
use super::solids::{Solids, eye_in_model};
use super::surface::{PreparedSurface, Revision, to_bytes};
use super::trims::{TrimWords, make_exact};
use super::{Frame, RED, Renderer, in_lines};
use crate::bezier::Degree;
use crate::camera::ViewProjection;
use crate::error::Result;
use crate::gpu::{Buffer, TexelBuffer};
use crate::programs::{Output, Painting, TrimFeatures};
use crate::scene::{
    Analysis, Cull, CurvatureKind, Isolines, RenderSettings, Shading, Tessellation,
};
use crate::tessellation::{
    EdgeSource, EdgeTable, FrameStats, Lists, PatchKind, Plan, Rounding, Screen, SubPatch,
    SurfacePatches, TrimmedList, kept_for_strokes,
};

/// Spare bytes in a new buffer of sub-patches. A patch whose control points are dragged may need
/// more sub-patches; the frame should then not have to wait for a new buffer.
const ROOM_FOR_SUB_PATCHES: usize = 1 << 16;
/// Texels that the matrices of a surface take.
const MATRIX_TEXELS: usize = 12;

/// Surfaces that are drawn together.
#[derive(Debug, Default)]
pub(crate) struct DrawList {
    revisions: Vec<Revision>,
    /// The revisions of the borders from which `table` was made.
    borders: Vec<u64>,
    table: EdgeTable,
    /// A batch has one program and one set of textures. Batch i draws list i of the plan.
    batches: Vec<Batch>,
    /// For each surface, the lists of the plan that its sub-patches go to.
    lists: Vec<Lists>,
    /// The frame that everything is up to date with.
    key: Option<DrawKey>,
    /// The grids of all surfaces' trims.
    trims: TrimWords,
    plan: Plan,
    /// The sub-patches of all lists, one list after the other, about to be uploaded.
    staged: Vec<SubPatch>,
    /// The contents of the buffer `sub_patches`.
    uploaded: Vec<SubPatch>,
    sub_patches: Option<TexelBuffer>,
    /// For each surface, the columns of its matrices as `f32` ([`matrices`]), the last of which is its colour.
    columns: Vec<Vec4>,
    /// The same in a buffer, if a draw needs those of several surfaces.
    matrices: Option<TexelBuffer>,
    /// For each patch, where its domain lies in that of its surface, if a picture or isolines are drawn over the latter.
    domains: Option<TexelBuffer>,
    draws: Vec<Draw>,
    /// Whether surfaces meet along joints, whose strokes need a share of the tolerance.
    has_joints: bool,
    solids: Solids,
    /// The curvatures at the ends of scales that suit the surfaces, once they were asked for.
    limits: Vec<(CurvatureKind, f64)>,
    /// Counts the changes of anything above.
    state: u64,
}

/// What a list of draws depends on, besides the surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
struct DrawKey {
    plan: PlanKey,
    /// Whether the lines of a wireframe are red.
    in_red: bool,
    /// Whether what is behind is seen too.
    see_through: bool,
    /// Whether there are isolines.
    isolines: bool,
    /// Whether control points are needed relative to their patches.
    local_points: bool,
}

/// The properties that all sub-patches of a list share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Batch {
    /// The first surface of the batch. Its texture and control points' buffer are bound; other
    /// surfaces of the batch share them.
    pub(crate) surface: usize,
    /// `None`: any, which each sub-patch states.
    pub(crate) degree: Option<Degree>,
    pub(crate) shading: Shading,
    pub(crate) patches: PatchKind,
    /// Whether other surfaces belong to the batch too. Each has its own matrices and colour.
    pub(crate) shared: bool,
    pub(crate) painting: Painting,
    pub(crate) trims: TrimFeatures,
}

/// Sub-patches of two surfaces share a draw if these are equal.
#[derive(PartialEq, Eq, Hash)]
struct BatchKey {
    points: *const TexelBuffer,
    texture: Option<*const crate::gpu::Texture>,
    degree: Option<Degree>,
    shading: Shading,
    patches: PatchKind,
    painting: Painting,
    trims: TrimFeatures,
}

impl DrawList {
    /// An empty list, with the table of the surfaces' edges already made.
    pub(crate) fn of_neighbours(
        table: EdgeTable,
        surfaces: &[PreparedSurface],
        has_joints: bool,
        solids: Solids,
    ) -> Self {
        let borders = surfaces.iter().map(|surface| surface.revision().borders).collect();
        Self { table, borders, has_joints, solids, ..Self::default() }
    }

    /// The solids, as the last view shows them.
    pub(crate) const fn solids(&self) -> &Solids {
        &self.solids
    }

    /// A number that changes with everything that the list depends on.
    pub(crate) const fn state(&self) -> u64 {
        self.state
    }

    /// Brings everything up to date with the surfaces and the frame, and uploads trims that are not
    /// uploaded yet.
    pub(crate) fn update(
        &mut self,
        renderer: &Renderer,
        surfaces: &mut [PreparedSurface],
        frame: &Frame,
    ) -> Result<()> {
        make_exact(surfaces);
        for surface in &mut *surfaces {
            surface.upload_trims(renderer.gl(), &frame.settings)?;
        }
        self.trims.update(renderer.gl(), surfaces)?;
        let shown = frame.settings.shown_analysis();
        self.find_limit(surfaces, shown);
        let key = DrawKey {
            plan: PlanKey::new(frame, frame.settings.tessellation),
            in_red: in_lines(&frame.settings, Output::Picture),
            see_through: frame.settings.wireframe,
            isolines: isolines(&frame.settings).is_some(),
            local_points: shown.is_some(),
        };
        let same = self.note_revisions(surfaces);
        if same && self.key == Some(key) {
            return Ok(());
        }
        // If the update fails, the next one starts again.
        self.key = None;
        self.state += 1;
        if shown.is_some() {
            surfaces.iter_mut().for_each(PreparedSurface::write_local_points);
        }
        self.solids.update(surfaces, &key.plan.camera, key.see_through);
        self.plan(surfaces, &key.plan);
        self.upload(renderer, surfaces, &key)?;
        self.key = Some(key);
        Ok(())
    }

    /// The curvature at the end of the scale of an analysis, if it shows curvature: its own, or one that suits the
    /// surfaces as they were when it was first asked for.
    pub(crate) fn curvature_limit(&self, analysis: Option<Analysis>) -> Option<f64> {
        match analysis? {
            Analysis::Curvature { limit: Some(limit), .. } => Some(limit.get()),
            Analysis::Curvature { of, limit: None } => {
                self.limits.iter().find(|(kind, _)| *kind == of).map(|(_, limit)| *limit)
            }
            _ => None,
        }
    }

    fn find_limit(&mut self, surfaces: &[PreparedSurface], analysis: Option<Analysis>) {
        if let Some(Analysis::Curvature { of, .. }) = analysis
            && self.curvature_limit(analysis).is_none()
        {
            self.limits.extend(automatic_limit(surfaces, of).map(|limit| (of, limit)));
        }
    }

    pub(super) fn draws(&self) -> &[Draw] {
        &self.draws
    }

    pub(super) fn batches(&self) -> &[Batch] {
        &self.batches
    }

    /// The batches that have draws, in the order of the draws.
    pub(super) fn drawn_batches(&self) -> impl Iterator<Item = &Batch> {
        let of_each = self.draws.chunk_by(|a, b| a.batch == b.batch);
        of_each.map(|draws| &self.batches[draws[0].batch])
    }

    pub(crate) const fn sub_patches(&self) -> Option<&TexelBuffer> {
        self.sub_patches.as_ref()
    }

    pub(crate) const fn matrices(&self) -> Option<&TexelBuffer> {
        self.matrices.as_ref()
    }

    /// The matrices of a surface, column by column, and its colour.
    pub(super) fn columns(&self, surface: usize) -> &[Vec4] {
        &self.columns[surface * MATRIX_TEXELS..][..MATRIX_TEXELS]
    }

    pub(super) const fn domains(&self) -> Option<&TexelBuffer> {
        self.domains.as_ref()
    }

    pub(super) const fn trims(&self) -> &TrimWords {
        &self.trims
    }

    pub(crate) fn stats(&self) -> FrameStats {
        FrameStats { draws: self.draws.len(), ..self.plan.stats() }
    }

    /// Takes over the surfaces' revisions. If any changed since the last frame, updates the edges
    /// and the batches, and returns `false`.
    fn note_revisions(&mut self, surfaces: &[PreparedSurface]) -> bool {
        let now = surfaces.iter().map(PreparedSurface::revision);
        if self.revisions.iter().copied().eq(now.clone()) {
            return true;
        }
        let borders = now.clone().map(|revision| revision.borders);
        if !self.borders.iter().copied().eq(borders.clone()) {
            self.table = EdgeTable::new(&edge_sources(surfaces));
            self.borders.clear();
            self.borders.extend(borders);
        }
        self.revisions.clear();
        self.revisions.extend(now);
        self.sort(surfaces);
        false
    }

    /// Finds the batches, and for each surface the lists that its sub-patches go to.
    fn sort(&mut self, surfaces: &[PreparedSurface]) {
        self.batches.clear();
        self.lists.clear();
        self.domains = None;
        let mut known: HashMap<BatchKey, u32> = HashMap::new();
        let common = common_degrees(surfaces);
        for (number, surface) in surfaces.iter().enumerate() {
            let degree = Some(surface.drawn_degree()).filter(|degree| common.contains(degree));
            let painting = match surface.texture() {
                None => Painting::Color,
                Some(_) if surface.surface().nurbs().is_some() => Painting::PictureOverDomain,
                Some(_) => Painting::Picture,
            };
            let batches = &mut self.batches;
            let mut list = |patches: PatchKind, trims: TrimFeatures| {
                // The program of any degree is the most general one.
                let patches = if degree.is_some() { patches } else { PatchKind::Degenerate };
                let key = BatchKey {
                    points: Rc::as_ptr(surface.uploaded_drawn_points().texels()),
                    texture: surface.texture().map(Rc::as_ptr),
                    degree,
                    shading: surface.shading(),
                    patches,
                    painting,
                    trims,
                };
                let batch = *known.entry(key).or_insert_with(|| {
                    batches.push(Batch {
                        surface: number,
                        degree,
                        shading: surface.shading(),
                        patches,
                        shared: false,
                        painting,
                        trims,
                    });
                    batches.len() as u32 - 1
                });
                let known = &mut batches[batch as usize];
                known.shared |= known.surface != number;
                batch
            };
            let kept = PatchKind::ALL.map(|patches| list(patches, TrimFeatures::NONE));
            let exact = surface.uploaded_trims().exact.as_ref();
            let places = exact.into_iter().flat_map(|exact| self.trims.places(number, exact));
            let trimmed = places.map(|(place, features)| TrimmedList {
                lists: PatchKind::ALL.map(|patches| list(patches, features)),
                place,
            });
            self.lists.push(Lists { kept, trimmed: trimmed.collect() });
        }
    }

    /// Plans the frame: the sub-patches of each list.
    fn plan(&mut self, surfaces: &mut [PreparedSurface], key: &PlanKey) {
        let tolerance = match key.tessellation {
            Tessellation::Within(tolerance) if self.has_joints => {
                tolerance.pixels() - kept_for_strokes(tolerance.pixels())
            }
            Tessellation::Within(tolerance) => tolerance.pixels(),
            Tessellation::Level(_) => 1.0,
        };
        let screen = Screen::new(&key.camera, key.size, tolerance);
        let to_clip = key.camera.projection * key.camera.view;
        let mut first_patch = 0;
        let mut patches: Vec<SurfacePatches<'_>> = Vec::with_capacity(surfaces.len());
        for (number, surface) in surfaces.iter_mut().enumerate() {
            let model = surface.surface().transform;
            let back = match surface.surface().cull {
                Cull::Back => {
                    let sign = DMat3::from_mat4(model).determinant().signum();
                    Some((eye_in_model(&key.camera, &model), sign))
                }
                Cull::None => self.solids.seen(number).map(|(eye, _, sign)| (eye, sign)),
            };
            let hidden = surface.surface().hidden;
            let degree = surface.drawn_degree();
            let rounding = Rounding::new(
                &(to_clip * surface.points_to_world()),
                surface.uploaded_drawn_points().extent(),
            )
            .of_degree(degree);
            let first_point = surface.uploaded_drawn_points().first() as u32;
            let (net_side, nets, cones, trims) = surface.for_plan();
            // They were made when the trims were uploaded.
            let Some(trims) = &mut trims.exact else { continue };
            patches.push(SurfacePatches {
                degree,
                net_side,
                nets,
                to_clip: (to_clip * model).into(),
                rounding,
                cones,
                back,
                hidden,
                trims: &mut trims.surface,
                first_point,
                first_patch,
                number: number as u32,
                lists: &self.lists[number],
            });
            first_patch += cones.len() as u32;
        }
        let lists = self.batches.len();
        match key.tessellation {
            Tessellation::Within(_) => {
                self.plan.within_tolerance(&mut patches, &self.table, lists, &screen);
            }
            Tessellation::Level(level) => self.plan.at_level(&patches, lists, &screen, level),
        }
    }

    /// Uploads the sub-patches and the matrices, and divides the sub-patches into draws.
    fn upload(
        &mut self,
        renderer: &Renderer,
        surfaces: &[PreparedSurface],
        key: &DrawKey,
    ) -> Result<()> {
        let gl = renderer.gl();
        self.draws.clear();
        let count: usize = self.plan.lists().iter().map(Vec::len).sum();
        if count == 0 {
            return Ok(());
        }
        let bytes = count * size_of::<SubPatch>();
        if self.sub_patches.as_ref().is_none_or(|texels| texels.buffer().bytes() < bytes) {
            let texels = (bytes + ROOM_FOR_SUB_PATCHES).next_power_of_two() / size_of::<[u32; 4]>();
            self.sub_patches = Some(TexelBuffer::of_texels(gl, "sub-patches", texels)?);
            self.uploaded.clear();
        }
        self.staged.clear();
        for sub_patches in self.plan.lists() {
            self.staged.extend_from_slice(sub_patches);
        }
        if let Some(sub_patches) = &self.sub_patches {
            write_changed(sub_patches.buffer(), &self.uploaded, &self.staged);
        }
        std::mem::swap(&mut self.uploaded, &mut self.staged);
        let max_vertices = renderer.draw_size().vertices();
        let mut first = 0;
        for (batch, sub_patches) in self.plan.lists().iter().enumerate() {
            divide_into_instances(sub_patches, first, batch, max_vertices, &mut self.draws);
            first += sub_patches.len();
        }
        let texels: Vec<Vec4> = surfaces
            .iter()
            .flat_map(|surface| {
                let mut columns = matrices(&surface.points_to_world(), &key.plan.camera);
                let color = if key.in_red { RED } else { surface.color() };
                let [r, g, b] = to_bytes(color).map(|channel| f32::from(channel) * (1.0 / 255.0));
                columns[MATRIX_TEXELS - 1] = Vec4::new(r, g, b, 1.0);
                columns
            })
            .collect();
        match &self.matrices {
            // Where no batch has several surfaces, the matrices are uniforms.
            _ if !self.batches.iter().any(|batch| batch.shared) => self.matrices = None,
            Some(matrices) if matrices.buffer().bytes() == size_of_val(texels.as_slice()) => {
                write_changed(matrices.buffer(), &self.columns, &texels);
            }
            _ => self.matrices = Some(TexelBuffer::of_vectors(gl, "surfaces", &texels)?),
        }
        self.columns = texels;
        let is_over_domain = |batch: &Batch| batch.painting == Painting::PictureOverDomain;
        let over_domains = key.isolines || self.batches.iter().any(is_over_domain);
        if over_domains && self.domains.is_none() {
            self.domains = Some(TexelBuffer::of_vectors(gl, "domains", &domains_of(surfaces))?);
        }
        Ok(())
    }
}

/// The isolines of pictures: wireframes have none.
pub(super) fn isolines(settings: &RenderSettings) -> Option<Isolines> {
    settings.isolines.filter(|_| !settings.wireframe)
}

/// The degrees whose patches are drawn by programs of their own: all, unless there are many. Of many, all but the most
/// frequent ones share a program. With Mesa's software driver it takes as long to compile as 8 others, and 15 times as
/// long for a vertex.
fn common_degrees(surfaces: &[PreparedSurface]) -> Vec<Degree> {
    /// The largest number of degrees that all have programs of their own, besides 4×4 and 5×5 points.
    const FEW: usize = 12;
    /// How many have their own if there are more.
    const OF_MANY: usize = 4;
    let mut counts: BTreeMap<Degree, usize> = BTreeMap::new();
    for surface in surfaces {
        *counts.entry(surface.drawn_degree()).or_default() += surface.cones().len();
    }
    let is_usual = |degree: &Degree| [Degree::CUBIC, Degree::QUARTIC].contains(degree);
    let (mut common, mut others): (Vec<_>, Vec<_>) =
        counts.into_iter().partition(|(degree, _)| is_usual(degree));
    // The order of degrees with equal counts must not depend on anything else.
    others.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let own = if others.len() > FEW { OF_MANY } else { FEW };
    common.extend(others.into_iter().take(own));
    common.into_iter().map(|(degree, _)| degree).collect()
}

/// Writes the values that differ from the contents `old` of a buffer: each run of changed values
/// separately if there are few runs, otherwise everything from the first change to the last.
fn write_changed<T: Pod + PartialEq>(buffer: &Buffer, old: &[T], new: &[T]) {
    const FEW: usize = 16;
    if changed_runs(old, new).nth(FEW).is_none() {
        for run in changed_runs(old, new) {
            buffer.write(run.start, &new[run]);
        }
    } else if let Some(whole) = changed_runs(old, new).reduce(|first, last| first.start..last.end) {
        buffer.write(whole.start, &new[whole]);
    }
}

/// The runs of new values that differ from the old ones. Values beyond the end of the old ones
/// count as changed.
fn changed_runs<T: PartialEq>(old: &[T], new: &[T]) -> impl Iterator<Item = Range<usize>> {
    let differs = |i: &usize| old.get(*i) != Some(&new[*i]);
    let mut at = 0;
    std::iter::from_fn(move || {
        let start = (at..new.len()).find(differs)?;
        at = (start..new.len()).find(|i| !differs(i)).unwrap_or(new.len());
        Some(start..at)
    })
}

/// The patches in which to look for shared edges. Surfaces are in one group if they have the same
/// matrix from the driver's control points to world space: the same transform and the same
/// centring.
pub(crate) fn edge_sources(surfaces: &[PreparedSurface]) -> Vec<EdgeSource<'_>> {
    let mut groups: HashMap<[u64; 16], u32> = HashMap::new();
    surfaces
        .iter()
        .map(|surface| {
            let bits = surface.points_to_world().to_cols_array().map(f64::to_bits);
            let next = groups.len() as u32;
            EdgeSource {
                degree: surface.drawn_degree(),
                points: surface.drawn_points(),
                group: *groups.entry(bits).or_insert(next),
                grid: surface.surface().patch_grid(),
            }
        })
        .collect()
}

/// For each patch, the first u and v and the lengths along u and v of its domain, if that of its surface is [0, 1]².
fn domains_of(surfaces: &[PreparedSurface]) -> Vec<Vec4> {
    let of_patches = surfaces.iter().flat_map(|surface| {
        let [low, high] = surface.surface().domain();
        (0..surface.cones().len()).map(move |patch| {
            let [first, last] = surface.surface().patch_domain(patch);
            let [place, size] = [(first - low) / (high - low), (last - first) / (high - low)];
            DVec4::new(place.x, place.y, size.x, size.y).as_vec4()
        })
    });
    of_patches.collect()
}

/// The columns of three matrices, in the order of `exact/surface.tese`: from the driver's points to
/// clip space, from these to view space, and from the cross product of two tangents to the normal
/// in view space. The last one is scaled, because only the direction of a normal matters, and has
/// three columns; a zero column follows.
pub(super) fn matrices(points_to_world: &DMat4, camera: &ViewProjection) -> [Vec4; MATRIX_TEXELS] {
    let to_view = camera.view * *points_to_world;
    let to_clip = camera.for_driver() * to_view;
    let [x, y, z] = [to_view.x_axis, to_view.y_axis, to_view.z_axis].map(DVec4::truncate);
    // The cross product of transformed tangents is the cofactor matrix times the cross product of
    // the tangents.
    let cofactors = [y.cross(z), z.cross(x), x.cross(y)];
    let size = cofactors.iter().map(|column| column.abs().max_element()).fold(0.0, f64::max);
    let size = if size > 0.0 { size } else { 1.0 };
    let [a, b, c] = cofactors.map(|column| (column / size).as_vec3().extend(0.0));
    let columns = |matrix: &DMat4| {
        [matrix.x_axis, matrix.y_axis, matrix.z_axis, matrix.w_axis].map(|column| column.as_vec4())
    };
    let ([d, e, f, g], [h, i, j, k]) = (columns(&to_clip), columns(&to_view));
    [d, e, f, g, h, i, j, k, a, b, c, Vec4::ZERO]
}
