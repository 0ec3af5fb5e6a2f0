//! Boxes along the axes.

use glam::{DVec2, DVec3};

/// A point that has a box: componentwise minimum and maximum.
pub(crate) trait Point: Copy {
    /// A box of no points.
    const EMPTY: [Self; 2];
    fn min(self, other: Self) -> Self;
    fn max(self, other: Self) -> Self;
}

impl Point for DVec2 {
    const EMPTY: [Self; 2] = [Self::INFINITY, Self::NEG_INFINITY];
    fn min(self, other: Self) -> Self {
        self.min(other)
    }
    fn max(self, other: Self) -> Self {
        self.max(other)
    }
}

impl Point for DVec3 {
    const EMPTY: [Self; 2] = [Self::INFINITY, Self::NEG_INFINITY];
    fn min(self, other: Self) -> Self {
        self.min(other)
    }
    fn max(self, other: Self) -> Self {
        self.max(other)
    }
}

/// The smallest box that holds all points: its minimum and maximum corner. Without points the minimum is +∞ and
/// the maximum −∞.
pub(crate) fn bounding_box<P: Point>(points: impl IntoIterator<Item = P>) -> [P; 2] {
    points.into_iter().fold(P::EMPTY, |[min, max], point| [min.min(point), max.max(point)])
}
