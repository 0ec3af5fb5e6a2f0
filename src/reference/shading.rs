//! Lighting in `f64`: the twin of `glsl/common/phong.glsl` and `glsl/common/studio.glsl`. Keep them in step.

use glam::DVec3;

use crate::camera::ViewProjection;
use crate::scene::{Light, Shading};

const AMBIENT: f64 = 0.1;
const SHININESS: f64 = 150.0;
/// Height of the thesis' lamps above and below the world's origin.
const LIGHT_HEIGHT: f64 = 10.0;

/// The lamps of a picture, in view space.
#[derive(Debug, Clone, Copy)]
pub(super) enum Lamps {
    /// The thesis' two, at the world's (0, ±10, 0).
    Thesis([DVec3; 2]),
    /// The studio's, which are the same in every picture.
    Studio {
        /// Whether the eye is at the origin. Otherwise it is far away, along the z axis.
        is_perspective: bool,
    },
}

impl Lamps {
    pub(super) fn new(light: Light, camera: &ViewProjection) -> Self {
        match light {
            Light::Thesis => Self::Thesis(
                [1.0, -1.0]
                    .map(|side| camera.view.transform_point3(DVec3::Y * (side * LIGHT_HEIGHT))),
            ),
            Light::Studio => Self::Studio { is_perspective: camera.projection.row(3).z != 0.0 },
        }
    }
}

/// Colour of a point of a surface. All vectors are in view space; `upright` is upright on the triangle, towards the eye,
/// or 0 on a line. With the thesis' lamps, the normal is used
/// as the triangles interpolate it, without normalising it again, as in listing 13.
pub(super) fn color(
    shading: Shading,
    paint: DVec3,
    position: DVec3,
    normal: DVec3,
    upright: DVec3,
    lamps: Lamps,
) -> DVec3 {
    match (shading, lamps) {
        (Shading::Unlit, _) => paint,
        (Shading::Normals, _) => normal.normalize_or_zero() * 0.5 + 0.5,
        (Shading::Phong, Lamps::Thesis(lights)) => lights
            .into_iter()
            .fold(paint * AMBIENT, |sum, light| sum + from_light(light, paint, position, normal)),
        (Shading::Phong, Lamps::Studio { is_perspective }) => {
            let to_eye = if is_perspective { -position.normalize() } else { DVec3::Z };
            let upright = if upright == DVec3::ZERO { to_eye } else { upright };
            let side = if normal.dot(upright) < 0.0 { -1.0 } else { 1.0 };
            in_studio(paint, to_eye, normal.normalize_or_zero() * side)
        }
    }
}

fn from_light(light: DVec3, paint: DVec3, position: DVec3, normal: DVec3) -> DVec3 {
    let to_light = (light - position).normalize();
    let eye = (-position).normalize();
    let reflection = (-to_light + 2.0 * normal.dot(to_light) * normal).normalize();
    let diffuse = normal.dot(to_light).max(0.0);
    let specular = reflection.dot(eye).max(0.0).powf(SHININESS);
    diffuse * paint + DVec3::splat(specular)
}

/// The light of the studio on a point whose normal has length 1, or 0 where there is none, and is on the eye's side.
fn in_studio(paint: DVec3, to_eye: DVec3, normal: DVec3) -> DVec3 {
    let key = DVec3::new(-2.0, 3.0, 3.0).normalize();
    let fill = DVec3::new(3.0, 0.5, 2.0).normalize();
    let rim = DVec3::new(1.0, 2.0, -1.5).normalize();
    let light = 0.13
        + 0.06 * normal.y
        + 0.74 * (0.8 * normal.dot(key) + 0.2).max(0.0)
        + 0.12 * normal.dot(fill).max(0.0)
        + 0.12 * normal.dot(rim).max(0.0);
    let gloss = 0.3 * normal.dot((key + to_eye).normalize()).max(0.0).powi(64);
    let linear = DVec3::from_array(paint.to_array().map(linear_of)) * light;
    let shown = linear.lerp(DVec3::ONE, gloss);
    DVec3::from_array(shown.to_array().map(srgb_of))
}

/// The linear value of a channel in sRGB, by the standard's formula (IEC 61966-2-1).
fn linear_of(srgb: f64) -> f64 {
    if srgb <= 0.04045 { srgb / 12.92 } else { ((srgb + 0.055) / 1.055).powf(2.4) }
}

/// The channel in sRGB of a linear value.
fn srgb_of(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use glam::DMat4;

    use super::*;

    #[test]
    fn light_from_above_on_a_level_surface() {
        // The eye at height 2 looks straight down, so the world's y is the view's z.
        let view = glam::dcamera::rh::view::look_at_mat4(2.0 * DVec3::Y, DVec3::ZERO, -DVec3::Z);
        let position = DVec3::new(0.0, 0.0, -2.0);
        let camera = ViewProjection { view, projection: DMat4::IDENTITY };
        let lamps = Lamps::new(Light::Thesis, &camera);
        let lit =
            |normal| color(Shading::Phong, DVec3::splat(0.5), position, normal, DVec3::Z, lamps);
        // Ambient 0.05, diffuse 0.5, and both reflections point exactly towards the eye or away from it.
        assert!((lit(DVec3::Z) - DVec3::splat(0.05 + 0.5 + 1.0)).length() < 1e-12);
        // The two lights together light both sides of a surface alike.
        assert!((lit(-DVec3::Z) - lit(DVec3::Z)).length() < 1e-12);
        // At a right angle to the light there is no diffuse term, but the lower light's reflection points to
        // the eye.
        assert!((lit(DVec3::X) - DVec3::splat(0.05 + 1.0)).length() < 1e-9);
    }

    #[test]
    fn unlit_is_the_paint_and_normals_show_themselves() {
        let paint = DVec3::new(0.1, 0.2, 0.3);
        let lamps = Lamps::Studio { is_perspective: true };
        let of = |shading| color(shading, paint, -DVec3::Z, 0.5 * DVec3::X, DVec3::Z, lamps);
        assert_eq!(of(Shading::Unlit), paint);
        assert_eq!(of(Shading::Normals), DVec3::new(1.0, 0.5, 0.5));
    }

    /// The values are those of the standard's own tables.
    #[test]
    fn srgb_is_the_standards() {
        for (srgb, linear) in [(0.0, 0.0), (0.04045, 0.003_130_8), (0.5, 0.214_041_14), (1.0, 1.0)]
        {
            assert!((linear_of(srgb) - linear).abs() < 1e-7, "{srgb}");
            assert!((srgb_of(linear) - srgb).abs() < 1e-6, "{linear}");
        }
        for step in 0..=255 {
            let srgb = f64::from(step) / 255.0;
            assert!((srgb_of(linear_of(srgb)) - srgb).abs() < 1e-6, "{srgb}");
        }
    }

    /// For every normal that the eye sees, and every direction to the eye in a picture that is up to 120° wide.
    #[test]
    fn the_studio_neither_clips_nor_leaves_black_and_is_two_sided() {
        let lamps = Lamps::Studio { is_perspective: true };
        let white = |to_eye: DVec3, normal| {
            color(Shading::Phong, DVec3::ONE, -to_eye, normal, DVec3::ZERO, lamps).x
        };
        let directions = |steps: i32| {
            (0..=steps).flat_map(move |i| {
                (0..2 * steps).map(move |j| {
                    let [tilt, turn] =
                        [i, j].map(|k| f64::from(k) * std::f64::consts::PI / f64::from(steps));
                    DVec3::new(
                        f64::sin(tilt) * f64::cos(turn),
                        f64::sin(tilt) * f64::sin(turn),
                        f64::cos(tilt),
                    )
                })
            })
        };
        let (mut darkest, mut brightest) = (f64::MAX, 0.0_f64);
        for to_eye in directions(24).filter(|direction| direction.z >= 0.5) {
            for normal in directions(48) {
                let shown = white(to_eye, normal);
                let is_turned = normal.dot(to_eye).abs() > 1e-9;
                assert!(!is_turned || shown == white(to_eye, -normal), "{to_eye} {normal}");
                (darkest, brightest) = (darkest.min(shown), brightest.max(shown));
            }
        }
        println!("{darkest} {brightest}");
        assert!(darkest > 0.25 && brightest < 0.99, "{darkest} {brightest}");
    }
}
