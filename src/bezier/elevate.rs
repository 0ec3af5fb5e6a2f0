//! Degree elevation: the same curve or patch with more control points.

use glam::DVec4;

use super::{Degree, homogeneous};

/// Control points of a patch raised to degree `side − 1` along u and v: `side` × `side` points (x, y, z, weight).
/// `side` is at least the number of columns and of rows.
pub(crate) fn elevate_to_square(degree: Degree, points: &[DVec4], side: usize) -> Vec<DVec4> {
    let mut line = Vec::with_capacity(side);
    let mut rows = Vec::with_capacity(side * degree.rows());
    for row in points.chunks_exact(degree.columns()) {
        line.clear();
        line.extend(row.iter().map(|point| homogeneous(*point)));
        elevate(&mut line, side);
        rows.extend_from_slice(&line);
    }
    let mut square = vec![DVec4::ZERO; side * side];
    for column in 0..side {
        line.clear();
        line.extend(rows.iter().skip(column).step_by(side));
        elevate(&mut line, side);
        for (row, point) in line.iter().enumerate() {
            square[row * side + column] = (point.truncate() / point.w).extend(point.w);
        }
    }
    square
}

/// Raises the degree of a curve until it has `count` control points.
fn elevate(points: &mut Vec<DVec4>, count: usize) {
    while let (Some(last), true) = (points.last().copied(), points.len() < count) {
        let degree = points.len() as f64;
        for i in (1..points.len()).rev() {
            let share = i as f64 / degree;
            points[i] = points[i - 1] * share + points[i] * (1.0 - share);
        }
        points.push(last);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::Patch;

    #[test]
    fn an_elevated_patch_is_the_same_patch() {
        for (u, v, side) in [(1, 1, 2), (2, 1, 3), (1, 3, 8), (7, 2, 8), (15, 9, 16)] {
            let degree = Degree::new(u, v).unwrap();
            let points: Vec<DVec4> = (0..degree.points())
                .map(|i| {
                    let x = i as f64;
                    DVec4::new(x.sin(), (1.7 * x).cos(), (0.3 * x).sin(), 1.5 + (2.9 * x).sin())
                })
                .collect();
            let raised = elevate_to_square(degree, &points, side);
            let square = Degree::new(side - 1, side - 1).unwrap();
            let [patch, raised] = [Patch::new(degree, &points), Patch::new(square, &raised)];
            for i in 0..=10 {
                let (u, v) = (f64::from(i) / 10.0, f64::from(i * 3 % 11) / 10.0);
                let apart = patch.at(u, v).position.distance(raised.at(u, v).position);
                assert!(apart < 1e-12, "{degree} at ({u}, {v}): {apart}");
            }
        }
    }
}
