//! Bounds many patches with one call, as many at once as a SIMD register has lanes.

use fearless_simd::{Level, Simd, dispatch};

use super::net::{ClipNet, Points, ToClip};
use super::number::{Lanes, MAX_LANES, Number};
use super::{Bound, Rounding, Screen};

/// The number of patches that are bounded with one call. It is large enough that the time of
/// choosing the instruction set does not matter.
pub(crate) const TOGETHER: usize = 64;

/// The levels that a patch needs, and the bound that they follow from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Need<T = f64> {
    pub(crate) bound: Bound<T>,
    /// See [`Bound::levels`].
    pub(crate) levels: [T; 2],
    /// The error bound with these levels, in pixels, see [`Bound::error`]. Meaningless if they are
    /// infinite.
    pub(crate) error: T,
}

impl<T: Number> Need<T> {
    #[inline(always)]
    pub(crate) fn new(bound: Bound<T>, screen: &Screen) -> Self {
        let levels = bound.levels(screen);
        Self { bound, levels, error: bound.error(levels, screen) }
    }

    /// The need of one lane's patch.
    #[inline(always)]
    fn lane(&self, lane: usize) -> Need {
        Need {
            bound: self.bound.lane(lane),
            levels: self.levels.map(|level| level.lane(lane)),
            error: self.error.lane(lane),
        }
    }
}

/// A patch to bound.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate<'a, const N: usize> {
    pub(crate) points: &'a Points<N>,
    /// Whether its weights may differ from 1.
    pub(crate) is_rational: bool,
    /// The index at which its need is written.
    pub(crate) place: usize,
}

/// Computes the needs of patches; writes nothing for those that are out of view.
pub(crate) fn needs_of<const N: usize>(
    processor: Level,
    patches: &[Candidate<'_, N>],
    to_clip: &ToClip,
    rounding: &Rounding,
    screen: &Screen,
    needs: &mut [Option<Need>],
) {
    dispatch!(processor, simd => {
        side_by_side(simd, patches, to_clip, rounding, screen, needs);
    });
}

#[inline(always)]
fn side_by_side<const N: usize, S: Simd>(
    simd: S,
    patches: &[Candidate<'_, N>],
    to_clip: &ToClip,
    rounding: &Rounding,
    screen: &Screen,
    needs: &mut [Option<Need>],
) {
    const { assert!(Lanes::<S>::LANES <= MAX_LANES) };
    for patches in patches.chunks(Lanes::<S>::LANES) {
        // The last patch also fills unused lanes.
        let last = patches.len() - 1;
        let points: [&Points<N>; MAX_LANES] =
            std::array::from_fn(|lane| patches[lane.min(last)].points);
        let is_rational = patches.iter().any(|patch| patch.is_rational);
        let net: ClipNet<N, Lanes<S>> =
            ClipNet::new(simd, |lane| points[lane], is_rational, to_clip);
        let outside = net.outside();
        let is_outside = |lane: usize| outside.lane(lane) > 0.0;
        if (0..patches.len()).all(is_outside) {
            continue;
        }
        let need = Need::new(net.bound(screen, rounding), screen);
        for (lane, patch) in patches.iter().enumerate() {
            if !is_outside(lane) {
                needs[patch.place] = Some(need.lane(lane));
            }
        }
    }
}
