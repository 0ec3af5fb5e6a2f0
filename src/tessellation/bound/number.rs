//! Numbers of one patch, or of two that are worked on side by side.

use std::ops::{Add, Div, Mul, Sub};

use wide::f64x2;

/// A number of each of one or more patches, called lanes. An operation does the same to each lane, and
/// a lane's bits do not depend on the others.
pub(crate) trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// How many: one or two.
    const LANES: usize;

    /// A number for each lane.
    fn each(of: impl Fn(usize) -> f64) -> Self;

    /// One number for all lanes.
    #[inline]
    fn all(value: f64) -> Self {
        Self::each(|_| value)
    }

    fn lane(self, lane: usize) -> f64;

    fn abs(self) -> Self;

    fn sqrt(self) -> Self;

    /// The larger of two numbers, neither of which is NaN: what processors do in one step.
    fn most(self, other: Self) -> Self;

    /// The smaller.
    fn least(self, other: Self) -> Self;
}

impl Number for f64 {
    const LANES: usize = 1;

    #[inline]
    fn each(of: impl Fn(usize) -> Self) -> Self {
        of(0)
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
    fn most(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline]
    fn least(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
}

impl Number for f64x2 {
    const LANES: usize = 2;

    #[inline]
    fn each(of: impl Fn(usize) -> f64) -> Self {
        Self::new([of(0), of(1)])
    }

    #[inline]
    fn lane(self, lane: usize) -> f64 {
        self.to_array()[lane]
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
    fn most(self, other: Self) -> Self {
        self.fast_max(other)
    }

    #[inline]
    fn least(self, other: Self) -> Self {
        self.fast_min(other)
    }
}
