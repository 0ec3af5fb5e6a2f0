//! The trims of surfaces in the driver's memory, in one form for each method.

use std::collections::HashMap;

use crate::bezier::PatchGrid;
use crate::error::{Error, Result};
use crate::gpu::{Gl, TexelBuffer};
use crate::parallel;
use crate::programs::{TRIM_WORDS_UNIT, TrimFeatures};
use crate::scene::{Method, RenderSettings, Surface, Tessellation, first_alike};
use crate::tessellation::SurfaceTrims;
use crate::thesis::trims::ThesisTrims;
use crate::trim::{TrimGrid, Trims};

use super::surface::{PreparedSurface, new_number};

/// The trims in the forms that the two methods need. A form is made when its method first draws the surface, and is
/// discarded when the trims change.
#[derive(Debug, Default)]
pub(crate) struct UploadedTrims {
    pub(crate) thesis: Option<ThesisTrims>,
    pub(crate) exact: Option<ExactTrims>,
}

impl UploadedTrims {
    /// Makes what the method of the settings needs, if it is not made yet. `patches` are those of a NURBS surface.
    pub(super) fn prepare(
        &mut self,
        gl: &Gl,
        trims: &Trims,
        patches: Option<&PatchGrid>,
        settings: &RenderSettings,
    ) -> Result<()> {
        match settings.method {
            Method::Thesis if self.thesis.is_none() => {
                self.thesis = Some(ThesisTrims::new(gl, trims)?);
            }
            Method::Exact => {
                let exact = self.exact.get_or_insert_with(|| ExactTrims::new(trims, patches));
                if let Tessellation::Level(level) = settings.tessellation {
                    exact.surface.fix(level);
                }
            }
            Method::Thesis => {}
        }
        Ok(())
    }
}

/// The exact method's grids of a surface, and the results of trimming sub-patches with them.
#[derive(Debug, Clone)]
pub(crate) struct ExactTrims {
    pub(super) surface: SurfaceTrims,
    /// Trims with the same number have the same grids.
    number: u64,
}

impl ExactTrims {
    fn new(trims: &Trims, patches: Option<&PatchGrid>) -> Self {
        Self { surface: SurfaceTrims::new(trims, patches), number: new_number() }
    }

    /// The number of words of all grids.
    fn size(&self) -> usize {
        self.surface.grids().map(size_of).sum()
    }
}

/// Makes the exact grids of the surfaces that lack them, by several threads. Surfaces that are alike share them.
pub(super) fn make_exact(surfaces: &mut [PreparedSurface]) {
    let lacking: Vec<usize> = (0..surfaces.len())
        .filter(|number| surfaces[*number].uploaded_trims().exact.is_none())
        .collect();
    let of_each: Vec<&Surface> = lacking.iter().map(|number| surfaces[*number].surface()).collect();
    let first = first_alike(of_each.iter().copied().map(Some));
    let made = parallel::map_alike(&first, |i| {
        ExactTrims::new(&of_each[i].trims, of_each[i].patch_grid())
    });
    for (number, exact) in lacking.into_iter().zip(made) {
        surfaces[number].set_exact_trims(exact);
    }
}

/// The parts of the trim code that a grid needs.
pub(super) fn features(grid: &TrimGrid) -> TrimFeatures {
    TrimFeatures {
        grid_loops: grid.loop_columns().is_some(),
        finer_loops: grid.has_finer_cells(),
        long_lists: grid.has_long_lists(),
        fill_rules: grid.has_rules(),
        shape_grid: grid.has_shapes(),
        ..TrimFeatures::NONE
    }
}

/// A grid begins at a multiple of this number of words.
const ALIGNMENT: usize = 8;

/// The number of words of a grid, rounded up to where the next one begins.
fn size_of(grid: &TrimGrid) -> usize {
    grid.words().len().next_multiple_of(ALIGNMENT)
}

/// The exact method's grids of all surfaces in one buffer, in the form that the shaders read. Only grids that changed
/// are uploaded.
#[derive(Debug, Default)]
pub(super) struct TrimWords {
    buffer: Option<TexelBuffer>,
    /// The number of words that the buffer has room for.
    room: usize,
    /// The number of words from the beginning that are used, or were.
    used: usize,
    /// For each surface.
    slots: Vec<Slot>,
}

/// The words of a surface in the buffer.
#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    /// That of the trims.
    number: Option<u64>,
    first: usize,
    /// The number of words that other trims may take the place of: 0 if surfaces share them.
    room: usize,
}

impl TrimWords {
    /// Uploads the trims that changed.
    ///
    /// # Errors
    /// More trims than the driver has memory for, or than the shaders can address.
    pub(super) fn update(&mut self, gl: &Gl, surfaces: &[PreparedSurface]) -> Result<()> {
        self.slots.resize(surfaces.len(), Slot::default());
        for (number, surface) in surfaces.iter().enumerate() {
            let Some(exact) = &surface.uploaded_trims().exact else { continue };
            let slot = &mut self.slots[number];
            if slot.number == Some(exact.number) {
                continue;
            }
            let size = exact.size();
            if size > slot.room {
                if self.used + size > self.room {
                    // If this fails, nothing is uploaded.
                    let uploaded = self.upload_all(gl, surfaces);
                    return uploaded.inspect_err(|_| *self = Self::default());
                }
                *slot = Slot { first: self.used, room: size, ..*slot };
                self.used += size;
            }
            slot.number = Some(exact.number);
            if let Some(buffer) = &self.buffer {
                for (first, grid) in grids_from(slot.first, exact) {
                    buffer.buffer().write(first, grid.words());
                }
            }
        }
        Ok(())
    }

    /// Makes the buffer again, with some room for trims that grow.
    fn upload_all(&mut self, gl: &Gl, surfaces: &[PreparedSurface]) -> Result<()> {
        /// The places that [`place`] can name.
        const MOST: usize = ALIGNMENT << 24;
        self.buffer = None;
        self.used = 0;
        let mut known = HashMap::new();
        for (i, surface) in surfaces.iter().enumerate() {
            self.slots[i] = Slot::default();
            let Some(exact) = &surface.uploaded_trims().exact else { continue };
            let own = *known.entry(exact.number).or_insert(i);
            if own == i {
                let (number, room) = (Some(exact.number), exact.size());
                self.slots[i] = Slot { number, first: self.used, room };
                self.used += room;
            } else {
                self.slots[own].room = 0;
                self.slots[i] = self.slots[own];
            }
        }
        if self.used > MOST {
            return Err(Error::Driver {
                what: "trim grids".to_owned(),
                reason: format!("{} words of all surfaces; at most {MOST} fit", self.used),
            });
        }
        self.room = (self.used + self.used / 8).next_multiple_of(ALIGNMENT).min(MOST);
        let mut words = vec![0; self.room];
        for (slot, surface) in self.slots.iter().zip(surfaces) {
            let exact = surface.uploaded_trims().exact.as_ref();
            for (first, grid) in exact.into_iter().flat_map(|exact| grids_from(slot.first, exact)) {
                words[first..][..grid.words().len()].copy_from_slice(grid.words());
            }
        }
        self.buffer = Some(TexelBuffer::of_words(gl, "trim grids", &words)?);
        Ok(())
    }

    /// The grids of a surface, in the order of their indices: where the shaders find each
    /// ([`crate::tessellation::TrimmedList::place`]), and the parts of the trim code that it needs.
    pub(super) fn places<'a>(
        &self,
        number: usize,
        trims: &'a ExactTrims,
    ) -> impl Iterator<Item = (u32, TrimFeatures)> + use<'a> {
        grids_from(self.slots[number].first, trims)
            .map(|(first, grid)| (place(first, grid), features(grid)))
    }

    /// Binds the grids for the shaders' trim code.
    pub(super) fn bind(&self) {
        if let Some(words) = &self.buffer {
            words.bind(TRIM_WORDS_UNIT);
        }
    }
}

/// The grids of a surface, and the index of the first word of each, if those of the surface begin at `first`.
fn grids_from(first: usize, trims: &ExactTrims) -> impl Iterator<Item = (usize, &TrimGrid)> {
    trims.surface.grids().scan(first, |next, grid| {
        let first = *next;
        *next += size_of(grid);
        Some((first, grid))
    })
}

fn place(first: usize, grid: &TrimGrid) -> u32 {
    let columns = grid.loop_columns().map_or(0, |columns| columns.get().trailing_zeros());
    (first / ALIGNMENT) as u32 | columns << 24
}
