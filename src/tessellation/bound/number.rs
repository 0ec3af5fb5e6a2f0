//! Numbers for computing one patch at a time (`f64`), or several at once in the lanes of SIMD
//! registers ([`Lanes`]). The instruction set, and with it the number of lanes, is chosen at run
//! time.

use std::ops::{Add, Div, Mul, Sub};

use fearless_simd::{ExtractToken, Select, Simd, SimdBase, SimdFloat};

/// The largest number of lanes of any supported instruction set.
pub(super) const MAX_LANES: usize = 8;

/// One number for each of one or more patches; the patches are called lanes. An operation does the
/// same in each lane. The bits of a result do not depend on the other lanes or on the number of
/// lanes, except where [`Number::larger`] or [`Number::smaller`] compares NaN or zeros of two signs.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Needed to make numbers: proof that the processor has the instruction set.
    type Token: Copy;

    /// The number of lanes.
    const LANES: usize;

    fn token(self) -> Self::Token;

    /// The number `of(lane)` in each lane.
    fn each(token: Self::Token, of: impl Fn(usize) -> f64) -> Self;

    /// The same number in all lanes.
    fn all(token: Self::Token, value: f64) -> Self;

    fn lane(self, lane: usize) -> f64;

    fn abs(self) -> Self;

    fn sqrt(self) -> Self;

    fn ceil(self) -> Self;

    /// The larger of two numbers; either of them if one is NaN. This is a single instruction.
    fn larger(self, other: Self) -> Self;

    /// The smaller of two numbers; either of them if one is NaN.
    fn smaller(self, other: Self) -> Self;

    /// In each lane the first choice if this number is at most the other; the second if it is not,
    /// or if one of the two is NaN.
    fn choose_at_most(self, other: Self, choices: [Self; 2]) -> Self;
}

impl Number for f64 {
    type Token = ();

    const LANES: usize = 1;

    #[inline]
    fn token(self) -> Self::Token {}

    #[inline]
    fn each((): Self::Token, of: impl Fn(usize) -> Self) -> Self {
        of(0)
    }

    #[inline]
    fn all((): Self::Token, value: f64) -> Self {
        value
    }

    #[inline]
    fn lane(self, _: usize) -> Self {
        self
    }

    #[inline]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline]
    fn ceil(self) -> Self {
        self.ceil()
    }

    #[inline]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline]
    fn smaller(self, other: Self) -> Self {
        if self < other { self } else { other }
    }

    #[inline]
    fn choose_at_most(self, other: Self, [yes, no]: [Self; 2]) -> Self {
        if self <= other { yes } else { no }
    }
}

/// One number for each of as many patches as a SIMD register has lanes.
///
/// All functions that use lanes are inlined into the `dispatch!` that chooses the instruction set,
/// because only code in there is compiled for it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lanes<S: Simd>(S::f64s);

impl<S: Simd> Number for Lanes<S> {
    type Token = S;

    const LANES: usize = S::f64s::LEN;

    #[inline(always)]
    fn token(self) -> S {
        ExtractToken::token(&self.0)
    }

    #[inline(always)]
    fn each(token: S, of: impl Fn(usize) -> f64) -> Self {
        Self(S::f64s::from_fn(token, of))
    }

    #[inline(always)]
    fn all(token: S, value: f64) -> Self {
        Self(S::f64s::splat(token, value))
    }

    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane]
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    #[inline(always)]
    fn ceil(self) -> Self {
        Self(self.0.ceil())
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }

    #[inline(always)]
    fn choose_at_most(self, other: Self, [yes, no]: [Self; 2]) -> Self {
        Self(self.0.simd_le(other.0).select(yes.0, no.0))
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }
}

impl<S: Simd> Div for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}
