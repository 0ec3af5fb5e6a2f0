//! Lighting in `f64`: the twin of `glsl/thesis/surface.frag`. Keep both in step.

use glam::{DMat4, DVec3};

use crate::scene::{Light, Shading};

const AMBIENT: f64 = 0.1;
const SHININESS: f64 = 150.0;
/// Height of the lights above and below the world's origin.
const LIGHT_HEIGHT: f64 = 10.0;
/// Further away than any scene extends.
const FAR_AWAY: f64 = 1e30;

/// The two lights in view space. They are either the thesis' lights at the world's (0, ±10, 0), or the
/// camera's: one from the upper left, and one from the opposite direction. The camera's lights are so far away
/// that only their direction matters.
pub(super) fn lights(light: Light, view: &DMat4) -> [DVec3; 2] {
    match light {
        Light::World => {
            [1.0, -1.0].map(|side| view.transform_point3(DVec3::Y * (side * LIGHT_HEIGHT)))
        }
        Light::Camera => {
            let to_light = DVec3::new(-0.45, 0.6, (1.0 - 0.45 * 0.45 - 0.6 * 0.6_f64).sqrt());
            [to_light * FAR_AWAY, -to_light * FAR_AWAY]
        }
    }
}

/// Colour of a point of a surface. `position` and `normal` are in view space. The normal is used as the
/// triangles interpolate it, without normalising it again, as in listing 13.
pub(super) fn color(
    shading: Shading,
    paint: DVec3,
    position: DVec3,
    normal: DVec3,
    lights: [DVec3; 2],
) -> DVec3 {
    match shading {
        Shading::Unlit => paint,
        Shading::Normals => normal.normalize_or_zero() * 0.5 + 0.5,
        Shading::Phong => lights
            .into_iter()
            .fold(paint * AMBIENT, |sum, light| sum + from_light(light, paint, position, normal)),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_from_above_on_a_level_surface() {
        // The eye at height 2 looks straight down, so the world's y is the view's z.
        let view = glam::dcamera::rh::view::look_at_mat4(2.0 * DVec3::Y, DVec3::ZERO, -DVec3::Z);
        let position = DVec3::new(0.0, 0.0, -2.0);
        let lights = lights(Light::World, &view);
        let lit = |normal| color(Shading::Phong, DVec3::splat(0.5), position, normal, lights);
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
        let lights = lights(Light::World, &DMat4::IDENTITY);
        let of = |shading| color(shading, paint, -DVec3::Z, 0.5 * DVec3::X, lights);
        assert_eq!(of(Shading::Unlit), paint);
        assert_eq!(of(Shading::Normals), DVec3::new(1.0, 0.5, 0.5));
    }
}
