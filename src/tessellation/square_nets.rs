//! Square control nets. The bound of `bound.rs` is compiled for nets of a few square sizes, so patches of other
//! degrees are raised to the next of them, once. The raised net describes the same patch, and its bound is no larger.

use glam::DVec4;

use crate::bezier::{Degree, elevate};

/// Calls a function with the constant `N` for the number of points along a side of a square net.
macro_rules! with_side {
    ($side:expr, $n:ident => $call:expr) => {
        with_side!(@match $side, $n => $call; 2 3 4 5 6 8 12 16)
    };
    (@match $side:expr, $n:ident => $call:expr; $($size:literal)*) => {
        match $side {
            $($size => {
                const $n: usize = $size;
                $call
            })*
            other => unreachable!("a net of {other} points a side"),
        }
    };
}
pub(crate) use with_side;

/// The sizes that `with_side` knows.
const NET_SIDES: [usize; 8] = [2, 3, 4, 5, 6, 8, 12, 16];

/// The square nets of the patches of a surface.
#[derive(Debug, Clone)]
pub(crate) struct SquareNets {
    degree: Degree,
    side: usize,
    /// The degree of the nets.
    square: Degree,
    /// None if the control points are such nets themselves.
    raised: Option<Vec<DVec4>>,
}

impl SquareNets {
    /// From the control points of all patches.
    pub(crate) fn new(degree: Degree, points: &[DVec4]) -> Self {
        let longest = degree.columns().max(degree.rows());
        let side = NET_SIDES.into_iter().find(|side| *side >= longest);
        let side = side.expect("the largest net has a point more than the largest degree");
        let square = Degree::new(side - 1, side - 1).expect("a square net has a valid degree");
        let raised = (degree.points() != side * side).then(|| {
            let patches = points.chunks_exact(degree.points());
            patches.flat_map(|points| elevate(degree, points, square)).collect()
        });
        Self { degree, side, square, raised }
    }

    /// The number of points along a side.
    pub(crate) const fn side(&self) -> usize {
        self.side
    }

    /// The points of all nets; `points` are the control points.
    pub(crate) fn all<'a>(&'a self, points: &'a [DVec4]) -> &'a [DVec4] {
        self.raised.as_deref().unwrap_or(points)
    }

    /// Makes the net of one patch again; `points` are its control points.
    pub(crate) fn update(&mut self, patch: usize, points: &[DVec4]) {
        let size = self.side * self.side;
        if let Some(raised) = &mut self.raised {
            raised[patch * size..][..size].copy_from_slice(&elevate(
                self.degree,
                points,
                self.square,
            ));
        }
    }
}
