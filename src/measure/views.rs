//! Random cameras that are the same in every run.

use glam::{DVec2, DVec3};

use super::random::Random;
use crate::bezier::bounding_box;
use crate::camera::{Camera, Lens};
use crate::error::Result;
use crate::scene::{Scene, Surface};

/// How many times a point is drawn again because trims cut it.
const TRIES: usize = 16;

/// A random camera for a scene, with a vertical angle of view of 45° and any side up.
/// The same `seed` and `index` always give the same camera.
///
/// The size of a model is half the diagonal of its box. The box is that of all control points in world space.
/// The size is 1 if they are all one point. `index` modulo 4 selects where the camera is:
///
/// | | the eye | looks at |
/// |---|---|---|
/// | 0, far | 2 to 20 sizes off the box's middle | the middle |
/// | 1, inside | anywhere in the box, which is grown by a tenth of a size | any direction |
/// | 2, very near | 0.02 to 0.2 sizes off a point of the surface, any direction | that point |
/// | 3, grazing | 0.3 to 2 sizes off a point, 0.5° to 5° out of its tangent plane | that point |
///
/// Points of the surface are chosen uniformly over patches and (u, v), if possible where trims do not cut. If
/// the values overflow and no such camera can be made, it is [`Scene::framed`] for `aspect` (width over
/// height).
#[must_use]
pub fn random_view(scene: &Scene, seed: u64, index: u64, aspect: f64) -> Camera {
    let mut random = Random(Random(seed).next().wrapping_add(index));
    let [low, high] = bounding_box(scene.surfaces.iter().flat_map(Surface::world_points));
    let [low, high] = if low.cmple(high).all() { [low, high] } else { [DVec3::ZERO; 2] };
    let size = match 0.5 * low.distance(high) {
        0.0 => 1.0,
        size => size,
    };
    let (eye, target) = match index % 4 {
        0 => {
            let middle = 0.5 * (low + high);
            (middle + random.direction() * (size * random.between(2.0, 20.0)), middle)
        }
        1 => {
            // The box is grown because a flat model has no inside: seen from within its plane it would be
            // invisible.
            let (low, high) = (low - 0.1 * size, high + 0.1 * size);
            let eye = low + (high - low) * DVec3::from_array([(); 3].map(|()| random.unit()));
            (eye, eye + random.direction() * size)
        }
        2 => {
            let (point, _) = random.surface_point(scene);
            (point + random.direction() * (size * random.between(0.02, 0.2)), point)
        }
        _ => {
            let (point, normal) = random.surface_point(scene);
            let normal = normal.unwrap_or_else(|| random.direction());
            let side = if random.unit() < 0.5 { normal } else { -normal };
            let angle = random.between(0.5, 5.0).to_radians();
            let (along, across) = normal.any_orthonormal_pair();
            let turn = random.between(0.0, std::f64::consts::TAU);
            let tangent = along * turn.cos() + across * turn.sin();
            let direction = tangent * angle.cos() + side * angle.sin();
            (point + direction * (size * random.between(0.3, 2.0)), point)
        }
    };
    let lens = Lens::Perspective { fov_y_radians: std::f64::consts::FRAC_PI_4 };
    let up = random.direction();
    let sight = (target - eye).normalize_or(DVec3::Z);
    let up = if sight.cross(up).length() > 1e-3 { up } else { sight.any_orthonormal_vector() };
    Camera::new(eye, target, up, lens).unwrap_or_else(|_| scene.framed(aspect))
}

/// A camera that looks the same way with a point in the middle of its picture, which shows 1/`zoom` of what the camera
/// shows: without perspective the camera moves, with perspective it turns.
///
/// # Errors
/// As [`Camera::new`]: a lens out of range.
pub(super) fn close_up(camera: &Camera, point: DVec3, zoom: f64) -> Result<Camera> {
    let (eye, up) = (camera.eye(), camera.up());
    match camera.lens() {
        Lens::Orthographic { height } => {
            let sight = (camera.target() - eye).normalize();
            let off = (point - eye).reject_from_normalized(sight);
            Camera::new(eye + off, point, up, Lens::Orthographic { height: height / zoom })
        }
        Lens::Perspective { fov_y_radians } => {
            let half = ((0.5 * fov_y_radians).tan() / zoom).atan();
            Camera::new(eye, point, up, Lens::Perspective { fov_y_radians: 2.0 * half })
        }
    }
}

impl Random {
    /// A random point of the scene in world space, and the unit normal there if it is defined.
    fn surface_point(&mut self, scene: &Scene) -> (DVec3, Option<DVec3>) {
        let counts = scene.surfaces.iter().map(|surface| surface.patches().len());
        let count: usize = counts.sum();
        if count == 0 {
            return (DVec3::ZERO, None);
        }
        for left in (0..TRIES).rev() {
            let number = (self.unit() * count as f64) as usize;
            let uv = DVec2::new(self.unit(), self.unit());
            let mut patches = scene.surfaces.iter().flat_map(|surface| {
                (0..surface.patches().len()).map(move |patch| (surface, patch))
            });
            let (surface, patch) = patches.nth(number).expect("one of all patches");
            let [low, high] = surface.patch_domain(patch);
            if left == 0 || !surface.trims.cut(low + uv * (high - low)) {
                let point = surface.at(patch, uv.x, uv.y);
                let tangent = |vector: DVec3| surface.transform.transform_vector3(vector);
                let normal = tangent(point.du).cross(tangent(point.dv)).try_normalize();
                return (surface.transform.transform_point3(point.position), normal);
            }
        }
        unreachable!("the last try returns")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::Degree;
    use crate::trim::Circle;
    use glam::{DMat4, DVec4, dvec2, dvec3};

    /// The eye, and the unit vector of the view direction.
    fn sight(camera: &Camera) -> (DVec3, DVec3) {
        let view = camera.projection([DVec3::ZERO].into_iter(), 1.5).view;
        (camera.eye(), -view.row(2).truncate())
    }

    /// A square of 3 × 4 units in z = 1, so that its size is 2.5.
    fn flat() -> Scene {
        let points = (0..16)
            .map(|i| DVec4::new(f64::from(i % 4), f64::from(i / 4) * 4.0 / 3.0, 1.0, 1.0))
            .collect();
        let surface = Surface::new(Degree::CUBIC, points).unwrap();
        Scene { surfaces: vec![surface], ..Scene::listing16() }
    }

    #[test]
    fn cameras_are_where_their_family_says() {
        let mut scene = flat();
        let hole = Circle::new(dvec2(0.5, 0.5), 0.4).unwrap();
        scene.surfaces[0].trims.circles.push(hole);
        let mut sides = [0; 2];
        for index in 0..400 {
            let (eye, direction) = sight(&random_view(&scene, 5, index, 1.5));
            // The distance at which the view direction meets the square's plane, unless it lies in the plane.
            let distance = (1.0 - eye.z) / direction.z;
            let hit = eye + direction * distance;
            let on_square = (0.0..=3.0).contains(&hit.x)
                && (0.0..=4.0).contains(&hit.y)
                && !hole.cuts(dvec2(hit.x / 3.0, hit.y / 4.0));
            let degrees = direction.z.abs().asin().to_degrees();
            match index % 4 {
                0 => {
                    let to_middle = dvec3(1.5, 2.0, 1.0) - eye;
                    assert!((5.0..=50.0).contains(&to_middle.length()), "{index}");
                    assert!(to_middle.normalize().distance(direction) < 1e-9, "{index}");
                }
                1 => {
                    let grown = DVec3::splat(0.25);
                    let within = eye.cmpge(dvec3(0.0, 0.0, 1.0) - grown)
                        & eye.cmple(dvec3(3.0, 4.0, 1.0) + grown);
                    assert!(within.all(), "{index}: {eye}");
                }
                2 => assert!(on_square && (0.05..=0.5).contains(&distance), "{index}"),
                _ => {
                    assert!(on_square && (0.75..=5.0).contains(&distance), "{index}: {distance}");
                    assert!((0.499..5.001).contains(&degrees), "{index}: {degrees}");
                    sides[usize::from(eye.z > 1.0)] += 1;
                }
            }
        }
        assert!(sides.iter().all(|count| *count > 20), "{sides:?}");
    }

    #[test]
    fn close_ups_show_a_share_of_the_height_around_the_point() {
        let (eye, target, point) = (dvec3(5.0, -4.0, 3.0), dvec3(0.5, 0.0, 0.2), DVec3::ONE);
        for lens in [Lens::Perspective { fov_y_radians: 0.9 }, Lens::Orthographic { height: 4.0 }] {
            let camera = Camera::new(eye, target, DVec3::Z, lens).unwrap();
            let near = close_up(&camera, point, 10_000.0).unwrap();
            let [before, after] = [&camera, &near].map(|camera| {
                let seen = camera.projection([DVec3::ZERO, point].into_iter(), 1.5);
                seen.projection * seen.view
            });
            let ndc = after.project_point3(point);
            assert!(ndc.truncate().length() < 1e-9 && ndc.z.abs() < 1.0, "{ndc}");
            // A step across the view is 10,000 times as long on the screen.
            let (_, sight) = sight(&near);
            let step = 1e-7 * sight.any_orthonormal_vector();
            let length = |seen: DMat4| {
                let [a, b] = [point, point + step].map(|point| seen.project_point3(point));
                ((b - a).truncate() * dvec2(1.5, 1.0)).length()
            };
            // The perspective turns, so that the point was seen at another angle before.
            let ratio = length(after) / length(before);
            let exact = matches!(lens, Lens::Orthographic { .. });
            let slack = if exact { 1e-3 } else { 0.2 };
            assert!((ratio / 1e4 - 1.0).abs() < slack, "{ratio}");
        }
    }

    #[test]
    fn views_repeat_and_differ() {
        let scene = flat();
        let eyes = |seed: u64| {
            (0..40).map(|index| random_view(&scene, seed, index, 1.0).eye()).collect::<Vec<_>>()
        };
        assert_eq!(eyes(1), eyes(1));
        let both = [eyes(1), eyes(2)].concat();
        for (i, eye) in both.iter().enumerate() {
            assert!(!both[..i].contains(eye), "view {i}");
        }
    }

    #[test]
    fn points_and_models_at_the_end_of_numbers_have_views() {
        let mut point = flat();
        point.surfaces[0].transform = DMat4::from_scale(DVec3::ZERO);
        let mut far = flat();
        far.surfaces[0].transform = DMat4::from_scale(DVec3::splat(2e14));
        let mut tiny_and_far = flat();
        tiny_and_far.surfaces[0].transform =
            DMat4::from_translation(DVec3::splat(1e9)) * DMat4::from_scale(DVec3::splat(1e-9));
        let nothing = Scene { surfaces: Vec::new(), ..flat() };
        for scene in [point, far, tiny_and_far, nothing] {
            for index in 0..40 {
                let camera = random_view(&scene, 9, index, 1.5);
                let points = scene.surfaces.iter().flat_map(Surface::world_points);
                let seen = camera.projection(points, 1.5);
                assert!(seen.view.is_finite() && seen.projection.is_finite(), "{index}");
            }
        }
    }
}
