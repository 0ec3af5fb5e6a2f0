//! How patches are cut into triangles: sizes that the drivers ask for.

use crate::TessLevel;

/// Vertices that one draw may make. Mesa's software driver numbers the vertices of a draw with 16
/// bits (more than 65,535 render garbage without an error) and slows down quadratically long before;
/// much smaller draws cost a call each.
const VERTICES_PER_DRAW: u32 = 8_000;

/// Vertices that the tessellator makes of one patch at a uniform level.
const fn vertices_per_patch(level: TessLevel) -> u32 {
    (level.get() + 1) * (level.get() + 1)
}

/// How many patches one draw takes.
#[must_use]
pub(crate) fn patches_per_draw(level: TessLevel) -> usize {
    (VERTICES_PER_DRAW / vertices_per_patch(level)).max(1) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_draw_makes_more_vertices_than_16_bits_count() {
        for level in 1..=64 {
            let level = TessLevel::new(level).unwrap();
            let patches = patches_per_draw(level);
            let vertices = patches as u32 * vertices_per_patch(level);
            assert!(patches >= 1 && vertices <= VERTICES_PER_DRAW);
        }
        assert_eq!(patches_per_draw(TessLevel::new(1).unwrap()), 2000);
        assert_eq!(patches_per_draw(TessLevel::MAX), 1);
    }
}
