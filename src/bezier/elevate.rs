//! Degree elevation: the same curve or patch with more control points.

use glam::DVec4;

use super::{Degree, homogeneous};

/// Control points (x, y, z, weight) of a patch raised to a degree that is at least its own along u and along v. The
/// ends of rows and of columns stay bit for bit what they are, and the direction of a row or column makes no difference
/// to its other points.
pub(crate) fn elevate(degree: Degree, points: &[DVec4], to: Degree) -> Vec<DVec4> {
    let mut rows = Vec::with_capacity(to.columns() * degree.rows());
    for row in points.chunks_exact(degree.columns()) {
        rows.extend(elevate_curve(row, to.columns()));
    }
    let mut raised = vec![DVec4::ZERO; to.points()];
    let mut line = Vec::with_capacity(degree.rows());
    for column in 0..to.columns() {
        line.clear();
        line.extend(rows.iter().skip(column).step_by(to.columns()));
        for (row, point) in elevate_curve(&line, to.rows()).into_iter().enumerate() {
            raised[row * to.columns() + column] = point;
        }
    }
    raised
}

/// The control points of a curve raised to `count` control points.
pub(crate) fn elevate_curve(points: &[DVec4], count: usize) -> Vec<DVec4> {
    let [Some(first), Some(last)] = [points.first().copied(), points.last().copied()] else {
        return Vec::new();
    };
    if points.len() == count {
        return points.to_vec();
    }
    let mut raised: Vec<DVec4> = points.iter().copied().map(homogeneous).collect();
    while raised.len() < count {
        let degree = raised.len();
        let end = raised[degree - 1];
        for i in (1..degree).rev() {
            let shares = [i as f64, (degree - i) as f64];
            raised[i] = (raised[i - 1] * shares[0] + raised[i] * shares[1]) / degree as f64;
        }
        raised.push(end);
    }
    for point in &mut raised {
        *point = (point.truncate() / point.w).extend(point.w);
    }
    raised[0] = first;
    raised[count - 1] = last;
    raised
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::Patch;

    #[test]
    fn the_direction_of_a_curve_makes_no_difference() {
        let points: Vec<DVec4> = (0..4)
            .map(f64::from)
            .map(|x| DVec4::new(x.sin(), (1.7 * x).cos(), 1e-3 * x, 1.5 + (2.9 * x).sin()))
            .collect();
        let reversed: Vec<DVec4> = points.iter().rev().copied().collect();
        for count in [4, 5, 7, 16] {
            let raised = elevate_curve(&points, count);
            let mut other = elevate_curve(&reversed, count);
            other.reverse();
            assert_eq!(raised, other);
            assert_eq!([raised[0], raised[count - 1]], [points[0], points[3]]);
        }
    }

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
            let square = Degree::new(side - 1, side - 1).unwrap();
            let raised = elevate(degree, &points, square);
            let [patch, raised] = [Patch::new(degree, &points), Patch::new(square, &raised)];
            for i in 0..=10 {
                let (u, v) = (f64::from(i) / 10.0, f64::from(i * 3 % 11) / 10.0);
                let apart = patch.at(u, v).position.distance(raised.at(u, v).position);
                assert!(apart < 1e-12, "{degree} at ({u}, {v}): {apart}");
            }
        }
    }
}
