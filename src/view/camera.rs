//! Camera motion: the camera stays upright and does not pass over the poles.

use std::f64::consts::FRAC_PI_2;

use freeform_surface::{Camera, Lens, Result};
use glam::{DQuat, DVec2, DVec3};

use super::action::Side;

/// The angle of view after switching to perspective, for a camera that was orthographic from the start.
const FOV_Y_RADIANS: f64 = 40.0 * std::f64::consts::PI / 180.0;
/// The range of distances that zooming allows, and of the heights of orthographic pictures.
const DISTANCES: std::ops::RangeInclusive<f64> = 1e-9..=1e12;

/// Turns cameras around their targets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mover {
    /// The up axis.
    up: DVec3,
    /// The angle of view after switching from orthographic to perspective.
    fov_y_radians: f64,
}

impl Mover {
    /// For a scene with this up axis and this first camera.
    pub(crate) fn new(up: DVec3, camera: Option<&Camera>) -> Self {
        let up = up.normalize_or(DVec3::Y);
        // A camera that is rolled has an up axis of its own.
        let up = match camera {
            Some(camera) if View::of(camera).right.dot(up).abs() > 1e-6 => camera.up().normalize(),
            _ => up,
        };
        let fov_y_radians = match camera.map(Camera::lens) {
            Some(Lens::Perspective { fov_y_radians }) => fov_y_radians,
            _ => FOV_Y_RADIANS,
        };
        Self { up, fov_y_radians }
    }

    /// Turns the camera around its target, to the right and up, in radians.
    pub(crate) fn turn(&self, camera: &Camera, by: DVec2) -> Result<Camera> {
        let view = View::of(camera);
        // Horizontal at any pitch.
        let right = (view.right - self.up * view.right.dot(self.up)).normalize_or(view.right);
        let level = right.cross(self.up).normalize_or(view.back);
        let pitch = view.back.dot(self.up).atan2(view.back.dot(level));
        let pitch = (pitch + by.y).clamp(-FRAC_PI_2, FRAC_PI_2);
        self.look(camera, DQuat::from_axis_angle(self.up, by.x) * level, pitch)
    }

    /// The camera at its distance, in a horizontal direction, raised by `pitch` (radians).
    fn look(&self, camera: &Camera, level: DVec3, pitch: f64) -> Result<Camera> {
        let (sin, cos) = pitch.sin_cos();
        let back = level * cos + self.up * sin;
        // At the poles, the top of the picture points to where the camera came from.
        let steep = pitch.abs() > FRAC_PI_2 - 1e-3;
        let up = if steep { self.up * cos - level * sin } else { self.up };
        let eye = camera.target() + back * View::of(camera).distance;
        Camera::new(eye, camera.target(), up, camera.lens())
    }

    /// The camera at its distance, looking at its target from a side.
    pub(crate) fn look_from(&self, camera: &Camera, side: Side) -> Result<Camera> {
        let front = if self.up.z.abs() > self.up.y.abs() { -DVec3::Y } else { DVec3::Z };
        let right = self.up.cross(front).normalize();
        let front = right.cross(self.up);
        match side {
            Side::Front => self.look(camera, front, 0.0),
            Side::Right => self.look(camera, right, 0.0),
            Side::Top => self.look(camera, front, FRAC_PI_2),
        }
    }

    /// Switches between perspective and orthographic; objects at the target keep their size.
    pub(crate) fn other_lens(&mut self, camera: &Camera) -> Result<Camera> {
        let view = View::of(camera);
        let (eye, lens) = match camera.lens() {
            Lens::Perspective { fov_y_radians } => {
                self.fov_y_radians = fov_y_radians;
                (camera.eye(), Lens::Orthographic { height: view.height })
            }
            Lens::Orthographic { height } => {
                let fov_y_radians = self.fov_y_radians;
                let distance = 0.5 * height / (0.5 * fov_y_radians).tan();
                (camera.target() + view.back * distance, Lens::Perspective { fov_y_radians })
            }
        };
        Camera::new(eye, camera.target(), camera.up(), lens)
    }
}

/// Moves the camera to the right and up, in fractions of the picture's height at the target.
pub(crate) fn pan(camera: &Camera, by: DVec2) -> Result<Camera> {
    let view = View::of(camera);
    let by = (view.right * by.x + view.up * by.y) * view.height;
    Camera::new(camera.eye() + by, camera.target() + by, camera.up(), camera.lens())
}

/// Scales the distance of the target by `factor`. The point at the target's distance that lies under the cursor
/// stays in place. The cursor is measured from the centre of the picture, in fractions of its height, upwards.
pub(crate) fn zoom(camera: &Camera, factor: f64, cursor: DVec2) -> Result<Camera> {
    let view = View::of(camera);
    if !DISTANCES.contains(&(view.distance * factor))
        || !DISTANCES.contains(&(view.height * factor))
    {
        return Ok(*camera);
    }
    let fixed = camera.target() + (view.right * cursor.x + view.up * cursor.y) * view.height;
    let nearer = |point: DVec3| fixed + (point - fixed) * factor;
    let lens = match camera.lens() {
        Lens::Orthographic { height } => Lens::Orthographic { height: height * factor },
        perspective @ Lens::Perspective { .. } => perspective,
    };
    Camera::new(nearer(camera.eye()), nearer(camera.target()), camera.up(), lens)
}

/// The view of a camera at its target.
struct View {
    right: DVec3,
    up: DVec3,
    /// From the target to the eye.
    back: DVec3,
    distance: f64,
    /// World units from the lower border to the upper one.
    height: f64,
}

impl View {
    fn of(camera: &Camera) -> Self {
        let back = camera.eye() - camera.target();
        let distance = back.length();
        let back = back / distance;
        let right = camera.up().cross(back).normalize();
        let height = match camera.lens() {
            Lens::Perspective { fov_y_radians } => 2.0 * distance * (0.5 * fov_y_radians).tan(),
            Lens::Orthographic { height } => height,
        };
        Self { right, up: back.cross(right), back, distance, height }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Vec3Swizzles as _, dvec2, dvec3};

    fn camera() -> Camera {
        let lens = Lens::Perspective { fov_y_radians: 0.8 };
        Camera::new(dvec3(1.0, 2.0, 5.0), dvec3(0.5, 0.0, 0.25), DVec3::Y, lens).unwrap()
    }

    /// The place of a point in the picture, from the centre in fractions of its height.
    fn seen(camera: &Camera, point: DVec3) -> DVec2 {
        let matrices = camera.projection([point, camera.target()].into_iter(), 1.0);
        (matrices.projection * matrices.view).project_point3(point).xy() * 0.5
    }

    #[test]
    fn turning_keeps_target_and_distance_and_stops_at_the_poles() {
        let (start, mover) = (camera(), Mover::new(DVec3::Y, Some(&camera())));
        let mut turned = start;
        for step in 0..200 {
            let way = if step < 100 { 0.1 } else { -0.1 };
            turned = mover.turn(&turned, dvec2(0.05, way)).unwrap();
            assert_eq!(turned.target(), start.target());
            let distance = turned.eye().distance(turned.target());
            assert!((distance - start.eye().distance(start.target())).abs() < 1e-9);
            // The camera is upright: its right vector has no component along the axis.
            assert!(View::of(&turned).right.y.abs() < 1e-9);
        }
        let there = mover.turn(&start, dvec2(0.7, 0.2)).unwrap();
        let back = mover.turn(&there, dvec2(-0.7, -0.2)).unwrap();
        assert!(back.eye().distance(start.eye()) < 1e-9);
    }

    #[test]
    fn a_full_turn_over_the_pole_and_back_ends_where_it_began() {
        let mover = Mover::new(DVec3::Y, Some(&camera()));
        let front = mover.look_from(&camera(), Side::Front).unwrap();
        let top = mover.turn(&front, dvec2(0.0, 10.0)).unwrap();
        assert!(View::of(&top).back.distance(DVec3::Y) < 1e-9);
        let again = mover.turn(&top, dvec2(0.0, -FRAC_PI_2)).unwrap();
        assert!(again.eye().distance(front.eye()) < 1e-6);
    }

    #[test]
    fn sides_are_those_of_the_upright_axis() {
        for (up, front) in [(DVec3::Y, DVec3::Z), (DVec3::Z, -DVec3::Y)] {
            let mover = Mover::new(up, None);
            let back = |side| View::of(&mover.look_from(&camera(), side).unwrap()).back;
            assert!(back(Side::Front).distance(front) < 1e-9);
            assert!(back(Side::Right).distance(DVec3::X) < 1e-9);
            assert!(back(Side::Top).distance(up) < 1e-9);
        }
    }

    #[test]
    fn zooming_keeps_what_is_under_the_cursor() {
        let mut mover = Mover::new(DVec3::Y, None);
        let orthographic = mover.other_lens(&camera()).unwrap();
        for camera in [camera(), orthographic] {
            let cursor = dvec2(0.3, -0.2);
            let view = View::of(&camera);
            let under =
                camera.target() + (view.right * cursor.x + view.up * cursor.y) * view.height;
            let nearer = zoom(&camera, 0.25, cursor).unwrap();
            assert!(seen(&camera, under).distance(cursor) < 1e-9);
            assert!(seen(&nearer, under).distance(cursor) < 1e-9);
            assert!((View::of(&nearer).height - 0.25 * view.height).abs() < 1e-9);
            let mut nearest = camera;
            for _ in 0..1000 {
                nearest = zoom(&nearest, 0.5, cursor).unwrap();
            }
            assert!(View::of(&nearest).distance > 0.0);
        }
    }

    #[test]
    fn panning_moves_the_picture_by_as_much() {
        let panned = pan(&camera(), dvec2(0.1, 0.2)).unwrap();
        assert!(seen(&panned, camera().target()).distance(dvec2(-0.1, -0.2)) < 1e-9);
    }

    #[test]
    fn the_other_lens_keeps_the_size_at_the_target() {
        let mut mover = Mover::new(DVec3::Y, None);
        let flat = mover.other_lens(&camera()).unwrap();
        assert!(matches!(flat.lens(), Lens::Orthographic { .. }));
        let back = mover.other_lens(&flat).unwrap();
        assert!(back.eye().distance(camera().eye()) < 1e-9);
        assert_eq!(back.lens(), camera().lens());
    }
}
