//! The camera of a scene. View space is right-handed: the camera looks along −z, and y points up on the screen. Clip
//! space is that of OpenGL (depth −1 … 1).

mod path;

use glam::dcamera::rh::proj::opengl;
use glam::dcamera::rh::view::look_at_mat4;
use glam::{DMat4, DVec2, DVec3, DVec4};

use crate::bezier::{MAX_COORDINATE, bounding_box, check_coordinates};
use crate::error::{Error, Result};
pub use path::{CameraKey, CameraPath, Turntable};

/// The margin between a framed scene and the border of the picture, as a factor: with 1, the scene touches the
/// border.
const FRAME_MARGIN: f64 = 1.06;
/// The maximum distance of the near clip plane, as a fraction of the distance of the far plane, if the eye is inside
/// the scene. A nearer plane costs triangles; a farther plane cuts off near objects.
const NEAR_WITHIN: f64 = 1e-4;
/// The minimum distance of the near clip plane, as a fraction of the distance of the far plane.
const NEAR_AT_LEAST: f64 = 1e-9;
/// If the far clip plane is more than this many times as far away as the near one, depth is written as the distance
/// itself, because the usual depth is not precise enough.
const FAR_OVER_NEAR: f64 = 30.0;

/// The projection of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lens {
    /// Perspective with a vertical angle of view in radians, inside (0, π).
    Perspective {
        /// The whole angle from the picture's lower border to its upper one.
        fov_y_radians: f64,
    },
    /// Orthographic, `height` world units from the picture's lower border to its upper one.
    Orthographic {
        /// World units, above 0.
        height: f64,
    },
}

impl Default for Lens {
    /// Perspective with 45 degrees from the lower border to the upper one.
    fn default() -> Self {
        Self::Perspective { fov_y_radians: 45_f64.to_radians() }
    }
}

/// An eye, its target, its vertical direction, and its lens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    eye: DVec3,
    target: DVec3,
    up: DVec3,
    lens: Lens,
}

/// View and projection matrix of one picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewProjection {
    /// World space to view space.
    pub view: DMat4,
    /// View space to clip space.
    pub projection: DMat4,
}

impl ViewProjection {
    /// The factor that turns the distance along the view axis into a depth from 0 to 1. Only perspectives whose clip
    /// planes are far apart need it; for all others it is `None`, and depth is the usual one of OpenGL.
    pub(crate) fn depth_scale(&self) -> Option<f64> {
        let (z, w) = (self.projection.row(2), self.projection.row(3));
        if (w.z, w.w) != (-1.0, 0.0) {
            return None;
        }
        let (nearest, farthest) = (z.w / (z.z - 1.0), z.w / (z.z + 1.0));
        let is_far = nearest > 0.0 && farthest > FAR_OVER_NEAR * nearest;
        (is_far && farthest.is_finite()).then(|| 1.0 / farthest)
    }

    /// The distance along the view axis, before the eye, at which the picture begins.
    pub(crate) fn nearest(&self) -> f64 {
        // Where z = −w.
        let (z, w) = (self.projection.row(2), self.projection.row(3));
        (z.w + w.w) / (z.z + w.z)
    }

    /// The eye in view space, homogeneous and of length 1: (0, 0, 0, 1) in perspective, and in parallel projections the
    /// direction towards it, (0, 0, 1, 0).
    pub(crate) fn eye_in_view(&self) -> DVec4 {
        // The point that is everywhere in the picture.
        let eye = self.projection.inverse() * DVec4::NEG_Z;
        let eye = eye.normalize_or(DVec4::W);
        if eye.w < 0.0 || eye.w == 0.0 && eye.z < 0.0 { -eye } else { eye }
    }

    /// The projection that the driver gets. If depth is written as the distance, its far plane is at infinity, so
    /// that rounding to `f32` cannot move the plane in front of an object.
    pub(crate) fn for_driver(&self) -> DMat4 {
        let mut projection = self.projection;
        if self.depth_scale().is_some() {
            let nearest = projection.w_axis.z / (projection.z_axis.z - 1.0);
            (projection.z_axis.z, projection.w_axis.z) = (-1.0, -2.0 * nearest);
        }
        projection
    }
}

impl Camera {
    /// A camera at `eye` that sees `target` in the middle of its picture.
    ///
    /// # Errors
    /// A vector that is not finite, `eye` equal to `target`, an `up` along the line of sight, an
    /// angle outside (0, π), a height that is not above 0.
    pub fn new(eye: DVec3, target: DVec3, up: DVec3, lens: Lens) -> Result<Self> {
        for (name, vector) in [("camera eye", eye), ("camera target", target), ("camera up", up)] {
            check_coordinates(name, vector)?;
        }
        let sight = target - eye;
        if sight == DVec3::ZERO {
            return Err(Error::invalid("camera eye", eye, "a place other than the target"));
        }
        if sight.normalize().cross(up.normalize_or_zero()).length() < 1e-9 {
            return Err(Error::invalid("camera up", up, "a direction off the line of sight"));
        }
        match lens {
            Lens::Perspective { fov_y_radians } => {
                if !(fov_y_radians > 0.0 && fov_y_radians < std::f64::consts::PI) {
                    let degrees = fov_y_radians.to_degrees();
                    return Err(Error::invalid(
                        "camera fov_y",
                        format!("{degrees} degrees"),
                        "more than 0 and less than 180 degrees",
                    ));
                }
            }
            Lens::Orthographic { height } => {
                if !(1.0 / MAX_COORDINATE..=MAX_COORDINATE).contains(&height) {
                    return Err(Error::invalid(
                        "camera orthographic_height",
                        height,
                        "a number above 0, from 1e-15 to 1e15",
                    ));
                }
            }
        }
        Ok(Self { eye, target, up, lens })
    }

    /// A camera that sees all `points` from the front, a little from the right and from above, as
    /// large as a picture of `aspect` (width over height) allows. `up` is the axis that is
    /// vertical, `+y` or `+z`; the front is `+z` or `−y` accordingly.
    #[must_use]
    pub fn framing(points: impl Iterator<Item = DVec3> + Clone, up: DVec3, aspect: f64) -> Self {
        let [up, front, right] = upright_axes(up);
        let back = (front + 0.85 * up + 0.4 * right).normalize();
        let lens = Lens::Perspective { fov_y_radians: 40_f64.to_radians() };
        Self { eye: back, target: DVec3::ZERO, up, lens }.fitted(points, aspect)
    }

    /// A camera without perspective that sees all `points` from the front, the right and above at equal angles, as
    /// large as a picture of `aspect` (width over height) allows. `up` and the front are those of [`Camera::framing`].
    #[must_use]
    pub fn isometric(points: impl Iterator<Item = DVec3> + Clone, up: DVec3, aspect: f64) -> Self {
        let [up, front, right] = upright_axes(up);
        let lens = Lens::Orthographic { height: 1.0 };
        Self { eye: front + up + right, target: DVec3::ZERO, up, lens }.fitted(points, aspect)
    }

    /// A camera that looks the same way with the same kind of lens and sees all `points`, as large as a
    /// picture of `aspect` (width over height) allows.
    #[must_use]
    pub fn fitted(&self, points: impl Iterator<Item = DVec3> + Clone, aspect: f64) -> Self {
        let back = (self.eye - self.target).normalize();
        let screen_x = self.up.cross(back).normalize();
        let screen_y = back.cross(screen_x);

        let onto_screen = |p: DVec3| DVec3::new(p.dot(screen_x), p.dot(screen_y), p.dot(back));
        let [mut min, mut max] = bounding_box(points.clone().map(onto_screen));
        if !(min.is_finite() && max.is_finite()) {
            [min, max] = [DVec3::NEG_ONE, DVec3::ONE];
        }
        let mut middle = (min + max) * 0.5;
        let mut lens = self.lens;
        let mut distance: f64 = 0.0;
        match &mut lens {
            Lens::Orthographic { height } => {
                let size = max - min;
                let needed = FRAME_MARGIN * size.y.max(size.x / aspect);
                if needed > 0.0 {
                    *height = needed;
                }
                distance = size.z + *height;
            }
            Lens::Perspective { fov_y_radians } => {
                let slope_y = (*fov_y_radians * 0.5).tan() / FRAME_MARGIN;
                let slope_x = slope_y * aspect;
                // Perspective moves the middle of the picture off the middle of the points; a few
                // steps bring it back.
                for _ in 0..4 {
                    let from_middle = points.clone().map(|point| onto_screen(point) - middle);
                    distance = from_middle
                        .clone()
                        .map(|p| p.z + (p.x.abs() / slope_x).max(p.y.abs() / slope_y))
                        .fold(0.0, f64::max);
                    let seen = from_middle.map(|p| p.truncate() / (distance - p.z));
                    let [low, high] = bounding_box(seen);
                    let off = (low + high) * (0.5 * distance);
                    if off.is_finite() {
                        middle += off.extend(0.0);
                    }
                }
            }
        }
        let target = middle.x * screen_x + middle.y * screen_y + middle.z * back;
        let distance = if distance > 0.0 { distance } else { 1.0 };
        Self { eye: target + distance * back, target, up: self.up, lens }
    }

    /// The eye in world space.
    #[must_use]
    pub const fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The point in the middle of the picture, in world space.
    #[must_use]
    pub const fn target(&self) -> DVec3 {
        self.target
    }

    /// The vertical direction of the picture.
    #[must_use]
    pub const fn up(&self) -> DVec3 {
        self.up
    }

    /// The projection.
    #[must_use]
    pub const fn lens(&self) -> Lens {
        self.lens
    }

    /// The matrices for a picture of `aspect` (width over height), with clip planes that enclose all `points` in
    /// front of the eye.
    #[must_use]
    pub fn projection(&self, points: impl Iterator<Item = DVec3>, aspect: f64) -> ViewProjection {
        let view = look_at_mat4(self.eye, self.target, self.up);
        let (mut nearest, mut farthest) = (f64::INFINITY, f64::NEG_INFINITY);
        // The depth of the nearest point that may lie in the picture or close beside it.
        let mut nearest_seen = f64::INFINITY;
        let slopes = match self.lens {
            Lens::Perspective { fov_y_radians } => {
                DVec2::new(aspect, 1.0) * (2.0 * (0.5 * fov_y_radians).tan())
            }
            Lens::Orthographic { .. } => DVec2::INFINITY,
        };
        for point in points {
            let seen = view.transform_point3(point);
            let depth = -seen.z;
            nearest = nearest.min(depth);
            farthest = farthest.max(depth);
            if depth > 0.0 && seen.truncate().abs().cmple(slopes * depth).all() {
                nearest_seen = nearest_seen.min(depth);
            }
        }
        if !(nearest.is_finite() && farthest.is_finite()) {
            (nearest, farthest) = (0.1, 10.0);
        }
        // Even a flat scene needs some distance between its clip planes.
        let min = match self.lens {
            Lens::Perspective { .. } => farthest.abs().max(f64::from(f32::MIN_POSITIVE)),
            Lens::Orthographic { height } => farthest.abs().max(height),
        };
        let size = (farthest - nearest).max(1e-3 * min);
        let in_front = nearest;
        let (nearest, farthest) = (nearest - 0.01 * size, farthest + 0.01 * size);
        let projection = match self.lens {
            Lens::Perspective { fov_y_radians } => {
                let farthest = if farthest > 0.0 { farthest } else { 1.0 };
                let nearest = if in_front > 0.0 {
                    nearest.max(0.99 * in_front)
                } else {
                    (0.5 * nearest_seen).min(NEAR_WITHIN * farthest)
                };
                let nearest = nearest.max(farthest * NEAR_AT_LEAST);
                opengl::perspective(fov_y_radians, aspect, nearest, farthest)
            }
            Lens::Orthographic { height } => {
                let (half_width, half_height) = (0.5 * height * aspect, 0.5 * height);
                opengl::orthographic(
                    -half_width,
                    half_width,
                    -half_height,
                    half_height,
                    nearest,
                    farthest,
                )
            }
        };
        ViewProjection { view, projection }
    }
}

/// Unit vectors upwards, to the front and to the right.
fn upright_axes(up: DVec3) -> [DVec3; 3] {
    let up = up.normalize_or(DVec3::Y);
    let front = if up.z.abs() > up.y.abs() { -DVec3::Y } else { DVec3::Z };
    [up, front, up.cross(front).normalize()]
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    fn corners() -> Vec<DVec3> {
        (0..8)
            .map(|i| dvec3(f64::from(i & 1) * 4.0, f64::from(i >> 1 & 1), f64::from(i >> 2) * 2.0))
            .collect()
    }

    #[test]
    fn framing_shows_every_point_and_fills_the_picture() {
        for up in [DVec3::Y, DVec3::Z] {
            for aspect in [0.3, 1.0, 2.5] {
                let points = corners();
                let camera = Camera::framing(points.iter().copied(), up, aspect);
                let seen = camera.projection(points.iter().copied(), aspect);
                let largest = points
                    .iter()
                    .map(|p| (seen.projection * seen.view).project_point3(*p))
                    .map(|ndc| {
                        assert!(ndc.z.abs() <= 1.0);
                        ndc.x.abs().max(ndc.y.abs())
                    })
                    .fold(0.0, f64::max);
                assert!((0.9..1.0).contains(&largest), "{up} {aspect}: {largest}");
            }
        }
    }

    #[test]
    fn framing_survives_no_points_and_one_point() {
        for points in [Vec::new(), vec![dvec3(3.0, 4.0, 5.0)]] {
            let camera = Camera::framing(points.iter().copied(), DVec3::Y, 1.0);
            let seen = camera.projection(points.iter().copied(), 1.0);
            assert!(seen.view.is_finite() && seen.projection.is_finite());
        }
    }

    #[test]
    fn an_orthographic_height_is_the_pictures_height() {
        let camera =
            Camera::new(DVec3::Z, DVec3::ZERO, DVec3::Y, Lens::Orthographic { height: 3.0 })
                .unwrap();
        let seen = camera.projection([DVec3::ZERO].into_iter(), 2.0);
        let ndc = (seen.projection * seen.view).project_point3(dvec3(3.0, -1.5, 0.0));
        assert!((ndc.x - 1.0).abs() < 1e-12 && (ndc.y + 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_scene_in_the_plane_of_an_orthographic_eye_has_depth() {
        let lens = Lens::Orthographic { height: 4.0 };
        let camera = Camera::new(DVec3::ZERO, -DVec3::Z, DVec3::Y, lens).unwrap();
        let points = [DVec3::ZERO, DVec3::X];
        let seen = camera.projection(points.into_iter(), 1.0);
        for point in points {
            let ndc = (seen.projection * seen.view).project_point3(point);
            assert!(ndc.is_finite() && ndc.z.abs() < 1.0, "{ndc}");
        }
    }

    #[test]
    fn impossible_cameras_are_refused() {
        let lens = Lens::Perspective { fov_y_radians: 0.8 };
        let eye = dvec3(0.0, 1.0, 2.0);
        assert!(Camera::new(eye, DVec3::ZERO, DVec3::Y, lens).is_ok());
        for (camera, word) in [
            (Camera::new(eye, eye, DVec3::Y, lens), "target"),
            (Camera::new(eye, DVec3::ZERO, eye, lens), "line of sight"),
            (Camera::new(eye, DVec3::ZERO, DVec3::ZERO, lens), "up"),
            (Camera::new(eye * f64::NAN, DVec3::ZERO, DVec3::Y, lens), "eye"),
            (Camera::new(eye * 1e200, DVec3::ZERO, DVec3::Y, lens), "eye"),
            (
                Camera::new(eye, DVec3::ZERO, DVec3::Y, Lens::Perspective { fov_y_radians: 3.2 }),
                "180",
            ),
            (Camera::new(eye, DVec3::ZERO, DVec3::Y, Lens::Orthographic { height: 0.0 }), "height"),
        ] {
            let text = camera.unwrap_err().to_string();
            assert!(text.contains(word), "{text}");
        }
    }
}
