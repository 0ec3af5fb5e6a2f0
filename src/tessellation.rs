//! How patches are cut into triangles: sizes that the drivers ask for.

use glam::{Vec2, Vec3};

use crate::TessLevel;

/// Vertices that one draw of filled triangles may make. Mesa's software driver numbers the vertices
/// of a draw with 16 bits (more than 65,535 render garbage without an error) and slows down
/// quadratically long before; much smaller draws cost a call each.
const VERTICES_PER_DRAW: u32 = 8_000;

/// The same for lines, where that driver walks over all vertices of a draw every few dozen lines.
const VERTICES_PER_DRAW_OF_LINES: u32 = 1_100;

/// A patch above this level is drawn in four parts if its level is even: a draw is never smaller
/// than a patch, and one of level 64 has 4,225 vertices.
const MAX_WHOLE_LEVEL: u32 = 32;

/// How a patch is handed to the tessellator: `side` × `side` parts of its domain, each at `level`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Parts {
    /// Parts along one side of the patch.
    pub(crate) side: u32,
    /// Level of one part.
    pub(crate) level: u32,
}

impl Parts {
    /// The parts of a patch at a level. Their vertices are those of the whole patch; the diagonals
    /// are those of each part.
    pub(crate) const fn of(level: TessLevel) -> Self {
        let level = level.get();
        if level > MAX_WHOLE_LEVEL && level.is_multiple_of(2) {
            Self { side: 2, level: level / 2 }
        } else {
            Self { side: 1, level }
        }
    }

    /// Where each part begins in the domain, and the length of its side: (u, v, length).
    pub(crate) fn domains(self) -> impl Iterator<Item = Vec3> {
        let length = 1.0 / self.side as f32;
        (0..self.side * self.side).map(move |part| {
            let corner = Vec2::new((part % self.side) as f32, (part / self.side) as f32);
            (corner * length).extend(length)
        })
    }

    /// How many patches one draw of a part takes.
    pub(crate) fn patches_per_draw(self, wireframe: bool) -> usize {
        let most = if wireframe { VERTICES_PER_DRAW_OF_LINES } else { VERTICES_PER_DRAW };
        let vertices = (self.level + 1) * (self.level + 1);
        (most / vertices).max(1) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_draw_makes_more_vertices_than_16_bits_count() {
        for level in 1..=64 {
            for wireframe in [false, true] {
                let parts = Parts::of(TessLevel::new(level).unwrap());
                let vertices = (parts.level + 1) * (parts.level + 1);
                let drawn = parts.patches_per_draw(wireframe) as u32 * vertices;
                assert!(drawn >= vertices && drawn <= VERTICES_PER_DRAW);
                assert_eq!(parts.side * parts.level, level as u32);
            }
        }
    }

    #[test]
    fn parts_tile_the_domain() {
        let whole: Vec<Vec3> = Parts::of(TessLevel::new(32).unwrap()).domains().collect();
        assert_eq!(whole, [Vec3::new(0.0, 0.0, 1.0)]);
        let parts: Vec<Vec3> = Parts::of(TessLevel::MAX).domains().collect();
        assert_eq!(parts.len(), 4);
        assert_eq!(parts[3], Vec3::splat(0.5));
        assert_eq!(Parts::of(TessLevel::new(63).unwrap()).side, 1);
    }
}
