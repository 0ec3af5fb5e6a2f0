//! The end of a scale of curvature that suits the surfaces.

use glam::{DMat3, DVec2, DVec3};

use super::PreparedSurface;
use crate::scene::CurvatureKind;

/// The number of places that are looked at, roughly.
const PLACES: usize = 20_000;
/// Places along a side of a patch.
const SIDE: usize = 4;
/// Curvature times the size of the surfaces below this counts as none.
const FLAT: f64 = 1e-6;
/// The share of the area of what is curved that has at most the curvature of the limit.
const SHARE: f64 = 0.8;

/// 1, 2 or 5 times a power of ten that is at least as large as the curvature of most of what is curved.
/// `None` if no surface is shown.
pub(super) fn automatic_limit(surfaces: &[PreparedSurface], kind: CurvatureKind) -> Option<f64> {
    let patches = || {
        let shown = surfaces.iter().map(PreparedSurface::surface).filter(|own| !own.hidden);
        shown.flat_map(|own| own.patches().enumerate().map(move |patch| (own, patch)))
    };
    let stride = (patches().count() * SIDE * SIDE / PLACES).max(1);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    // Curvature and area.
    let mut found: Vec<(f64, f64)> = Vec::new();
    for (surface, (number, patch)) in patches().step_by(stride) {
        let to_world = DMat3::from_mat4(surface.transform);
        let [first, last] = surface.patch_domain(number);
        for i in 0..SIDE * SIDE {
            let share = (DVec2::new((i % SIDE) as f64, (i / SIDE) as f64) + 0.5) / SIDE as f64;
            if surface.trims.cut(first + share * (last - first)) {
                continue;
            }
            let here = patch.curved(share.x, share.y);
            let position = surface.transform.transform_point3(here.at.position);
            (low, high) = (low.min(position), high.max(position));
            let here = here.mapped(&to_world);
            let Some(curvature) = here.curvature() else { continue };
            found.push((kind.of(&curvature, 1.0).abs(), here.at.du.cross(here.at.dv).length()));
        }
    }
    let size = (high - low).length();
    if size <= 0.0 || !size.is_finite() {
        return None;
    }
    let least = match kind {
        CurvatureKind::Gaussian => FLAT / (size * size),
        CurvatureKind::Mean | CurvatureKind::Largest => FLAT / size,
    };
    found.retain(|(value, _)| *value > least);
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let area: f64 = found.iter().map(|(_, area)| area).sum();
    let mut passed = 0.0;
    let reached = found.iter().find(|(_, own)| {
        passed += own;
        passed >= SHARE * area
    });
    Some(rounded_up(reached.map_or(least / FLAT, |(value, _)| *value)))
}

/// The next number of the form 1, 2 or 5 times a power of ten.
fn rounded_up(value: f64) -> f64 {
    /// What rounding may add.
    const ALMOST: f64 = 1.0 + 1e-9;
    let power = 10_f64.powi(value.log10().floor() as i32);
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power * ALMOST >= value);
    (factor.unwrap_or(10.0) * power).clamp(1e-30, 1e30)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_round() {
        for (value, limit) in [
            (1.0, 1.0),
            (1.1, 2.0),
            (2.0, 2.0),
            (3.0, 5.0),
            (7.0, 10.0),
            (0.041, 0.05),
            (1e300, 1e30),
        ] {
            let found = rounded_up(value);
            assert!((found / limit - 1.0).abs() < 1e-12, "{value} {found}");
        }
    }
}
