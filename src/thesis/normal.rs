//! The thesis' normal, in `f64`: the twin of `glsl/thesis/surface.tese`. Keep both in step.

use glam::{DVec3, DVec4};

use crate::bezier::{Degree, Patch, de_casteljau};

/// Listings 4 to 6: the tangent along v at (u, v), crossed with the tangent along u **of the last row**, because the
/// listing's second variable still holds that tangent. Zero where a tangent vanishes.
///
/// It is correct on the border v = 1. Inside the patch it points in a wrong direction.
#[must_use]
pub fn thesis_normal(patch: &Patch<'_>, u: f64, v: f64) -> DVec3 {
    let (columns, rows) = (patch.degree().columns(), patch.degree().rows());
    let mut along_u = DVec3::ZERO;
    let mut column = [DVec4::ZERO; Degree::MAX + 1];
    for (row, point) in column.iter_mut().enumerate().take(rows) {
        let end = de_casteljau(&patch.homogeneous_row(row)[..columns], u);
        along_u = direction(end.last);
        *point = end.point;
    }
    let along_v = direction(de_casteljau(&column[..rows], v).last);
    along_v.cross(along_u).normalize_or_zero()
}

fn direction([from, to]: [DVec4; 2]) -> DVec3 {
    (to.truncate() / to.w - from.truncate() / from.w).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::default_control_points;

    /// Angles in degrees between the thesis' normal and the true one (Sv × Su), over a grid.
    fn turned(points: &[DVec4]) -> Vec<f64> {
        let patch = Patch::new(Degree::CUBIC, points);
        (0..=20 * 21)
            .map(|i| (f64::from(i % 21) / 20.0, f64::from(i / 21) / 20.0))
            .filter_map(|(u, v)| {
                let right = -patch.normal(u, v)?;
                Some(thesis_normal(&patch, u, v).angle_between(right).to_degrees())
            })
            .collect()
    }

    #[test]
    fn a_plane_has_no_wrong_normals() {
        assert!(turned(&default_control_points()).iter().all(|angle| *angle < 1e-5));
    }

    #[test]
    fn a_bump_has_normals_turned_by_many_degrees() {
        let mut points = default_control_points();
        for index in [5, 6, 9, 10] {
            points[index].y = 0.5;
        }
        let angles = turned(&points);
        let mean = angles.iter().sum::<f64>() / angles.len() as f64;
        let max = angles.iter().copied().fold(0.0, f64::max);
        assert!((15.0..22.0).contains(&mean), "mean {mean}");
        assert!((40.0..55.0).contains(&max), "most {max}");
    }

    #[test]
    fn the_last_row_is_right() {
        let mut points = default_control_points();
        for index in [5, 6, 9, 10, 13, 14] {
            points[index].y = 0.4;
        }
        let patch = Patch::new(Degree::CUBIC, &points);
        for step in 0..=10 {
            let u = f64::from(step) / 10.0;
            let right = -patch.normal(u, 1.0).unwrap();
            assert!(thesis_normal(&patch, u, 1.0).distance(right) < 1e-12);
        }
    }

    #[test]
    fn a_collapsed_last_row_leaves_a_zero_normal() {
        let mut points = default_control_points();
        for i in 12..16 {
            points[i] = points[12];
        }
        let patch = Patch::new(Degree::CUBIC, &points);
        assert_eq!(thesis_normal(&patch, 0.3, 0.4), DVec3::ZERO);
    }
}
