//! A box that is cut into equal cells. The `f32` arithmetic is that of the shaders, so every sample has exactly one
//! cell.

use glam::{UVec2, Vec2};

/// The largest coordinate of a sample: the largest `f32` below 1. The far borders of the domain belong to the cells
/// before them.
pub(super) const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

/// A box cut into columns along u and rows along v.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct UniformGrid {
    /// Minimum corner.
    pub(crate) min: Vec2,
    /// Maximum corner.
    pub(crate) max: Vec2,
    /// Cells per unit of the domain, chosen so that no sample of the box lies beyond the last cell.
    pub(crate) scale: Vec2,
    /// Columns and rows.
    pub(crate) size: UVec2,
}

/// Lower and upper bound of every sample of a column or row.
pub(super) type Bounds = [f32; 2];

impl UniformGrid {
    /// The uniform grid over the domain. The shader needs to know only its number of columns.
    pub(super) fn of_domain(side: u32) -> Self {
        Self::new(Vec2::ZERO, Vec2::ONE, side)
    }

    pub(super) fn new(min: Vec2, max: Vec2, side: u32) -> Self {
        let scale = |axis: usize| {
            let extent = max[axis] - min[axis];
            let mut scale = side as f32 / extent;
            while (max[axis].next_down() - min[axis]) * scale >= side as f32 {
                scale = scale.next_down();
            }
            // A box too thin to be cut is one column or row.
            if scale.is_finite() { (scale, side) } else { (0.0, 1) }
        };
        let [(scale_u, columns), (scale_v, rows)] = [scale(0), scale(1)];
        let (scale, size) = (Vec2::new(scale_u, scale_v), UVec2::new(columns, rows));
        Self { min, max, scale, size }
    }

    /// The number of words of a uniform grid in the shader's buffer.
    pub(super) const WORDS: usize = 5;

    pub(super) fn words(&self) -> [u32; Self::WORDS] {
        let [u, v] = self.min.to_array().map(f32::to_bits);
        let [scale_u, scale_v] = self.scale.to_array().map(f32::to_bits);
        [u, v, scale_u, scale_v, self.size.x]
    }

    /// The uniform grid that such words store. Its maximum corner and its number of rows are not stored.
    pub(super) fn from_words(words: &[u32]) -> Self {
        let point = |i: usize| Vec2::new(f32::from_bits(words[i]), f32::from_bits(words[i + 1]));
        let size = UVec2::new(words[4], 0);
        Self { min: point(0), max: Vec2::INFINITY, scale: point(2), size }
    }

    pub(super) fn count(&self) -> usize {
        (self.size.x * self.size.y) as usize
    }

    /// Column and row of a sample in the box: twin of `cellAt` in `glsl/common/trim.glsl`.
    pub(super) fn cell(&self, uv: Vec2) -> UVec2 {
        ((uv - self.min) * self.scale).as_uvec2()
    }

    /// The number of a sample's cell; cells are numbered row by row.
    pub(super) fn cell_of(&self, uv: Vec2) -> usize {
        let cell = self.cell(uv);
        (cell.y * self.size.x + cell.x) as usize
    }

    /// Bounds of the columns (`axis` 0) or rows (1). Neighbours overlap by some ulps, because the
    /// border between them is wherever `cell_of` rounds.
    pub(super) fn bounds(&self, axis: usize) -> Vec<Bounds> {
        let (min, max) = (self.min[axis], self.max[axis]);
        let (scale, count) = (self.scale[axis], self.size[axis]);
        let place = |x: f32| (x - min) * scale;
        let border = |cell: u32| min + (f64::from(cell) / f64::from(scale)) as f32;
        (0..count)
            .map(|cell| {
                let mut low = border(cell);
                while low > min && place(low) >= cell as f32 {
                    low = low.next_down();
                }
                let mut high = border(cell + 1);
                while high < max && place(high) < (cell + 1) as f32 {
                    high = high.next_up();
                }
                [
                    if cell == 0 { min } else { low.max(min) },
                    if cell + 1 == count { max } else { high.min(max) },
                ]
            })
            .collect()
    }
}

/// The columns or rows that the closed range from `min` to `max` touches.
pub(super) fn touched(bounds: &[Bounds], [min, max]: [f32; 2]) -> std::ops::Range<usize> {
    let first = count_before(bounds, min, |[_, high]| *high < min);
    let end = count_before(bounds, max, |[low, _]| *low <= max);
    first..end.max(first)
}

/// The number of columns or rows for which `is_before` holds. All have equal size, and it holds for those up to about
/// `x`.
pub(super) fn count_before(
    bounds: &[Bounds],
    x: f32,
    is_before: impl Fn(&Bounds) -> bool,
) -> usize {
    let [Some([low, _]), Some([_, high])] = [bounds.first(), bounds.last()] else { return 0 };
    let guess = (x - low) / (high - low) * bounds.len() as f32;
    let mut count = (guess as usize).min(bounds.len());
    while count > 0 && !is_before(&bounds[count - 1]) {
        count -= 1;
    }
    while count < bounds.len() && is_before(&bounds[count]) {
        count += 1;
    }
    count
}
