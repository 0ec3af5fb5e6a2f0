//! A picture's screen: from world space to places in pixels, and back as rays.

use glam::{DMat4, DVec2, DVec3, DVec4};

use crate::camera::ViewProjection;

/// A picture of a camera. Places are in pixels from the upper left corner; depths are distances along the view axis.
pub(super) struct Screen {
    pub(super) size: DVec2,
    to_clip: DMat4,
    from_clip: DMat4,
    /// The height of the projection matrix: how many half pictures high a unit at w = 1 is.
    height: f64,
    /// The row of the matrix from world space to clip space that gives w, and the one that gives the depth.
    depth: DVec4,
}

impl Screen {
    pub(super) fn new(projection: &ViewProjection, size: (u32, u32)) -> Self {
        let to_clip = projection.projection * projection.view;
        Self {
            size: DVec2::new(f64::from(size.0), f64::from(size.1)),
            to_clip,
            from_clip: to_clip.inverse(),
            height: projection.projection.y_axis.y,
            depth: -projection.view.row(2),
        }
    }

    /// The place of a point and its depth; `None` if it is not in front of the eye.
    pub(super) fn place(&self, point: DVec3) -> Option<(DVec2, f64)> {
        let clip = self.to_clip * point.extend(1.0);
        let ndc = clip.truncate().truncate() / clip.w;
        let place = DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * self.size;
        (clip.w > 0.0 && place.is_finite()).then(|| (place, self.depth(point)))
    }

    pub(super) fn depth(&self, point: DVec3) -> f64 {
        self.depth.dot(point.extend(1.0))
    }

    /// The ray through a place: its origin on the near clip plane, and the vector from there to the far one.
    pub(super) fn ray(&self, place: DVec2) -> [DVec3; 2] {
        let ndc = DVec2::new(2.0, -2.0) * place / self.size + DVec2::new(-1.0, 1.0);
        let [near, far] = [-1.0, 1.0].map(|z| self.from_clip.project_point3(ndc.extend(z)));
        [near, far - near]
    }

    /// The size of a pixel at the depth of a point, in world space.
    pub(super) fn pixel_at(&self, point: DVec3) -> f64 {
        2.0 * self.to_clip.row(3).dot(point.extend(1.0)) / (self.height * self.size.y)
    }

    /// Whether a ball may reach into the picture or come within `margin` pixels of it.
    pub(super) fn may_show(&self, center: DVec3, radius: f64, margin: f64) -> bool {
        let w = self.to_clip.row(3);
        (0..2).all(|axis| {
            let across = self.to_clip.row(axis);
            let wide = w * (1.0 + 2.0 * margin / self.size[axis]);
            [wide + across, wide - across]
                .iter()
                .all(|plane| plane.dot(center.extend(1.0)) >= -radius * plane.truncate().length())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::{Camera, Lens};
    use glam::{dvec2, dvec3};

    #[test]
    fn places_rays_and_pixels_agree_with_each_other() {
        let (eye, target) = (dvec3(3.0, -4.0, 2.0), dvec3(0.1, 0.2, -0.3));
        for lens in [Lens::Perspective { fov_y_radians: 0.7 }, Lens::Orthographic { height: 2.5 }] {
            let camera = Camera::new(eye, target, DVec3::Z, lens).unwrap();
            let points = [DVec3::splat(-1.0), DVec3::splat(1.0)];
            let projection = camera.projection(points.into_iter(), 1.5);
            let screen = Screen::new(&projection, (300, 200));
            let (middle, depth) = screen.place(target).unwrap();
            assert!(middle.distance(dvec2(150.0, 100.0)) < 1e-9);
            assert!((depth - eye.distance(target)).abs() < 1e-12);
            let place = dvec2(37.5, 151.25);
            let [origin, direction] = screen.ray(place);
            let point = origin + 0.4 * direction;
            assert!(screen.place(point).unwrap().0.distance(place) < 1e-9);
            // A step of a pixel's size across the view moves the place by a pixel.
            let across = (target - eye).cross(DVec3::Z).normalize();
            let moved = screen.place(point + across * screen.pixel_at(point)).unwrap().0;
            assert!((moved.distance(place) - 1.0).abs() < 1e-9, "{moved}");
            // Beside the picture by 50 pixels.
            let beside = target + 200.0 * across * screen.pixel_at(target);
            let pixel = screen.pixel_at(target);
            assert!(!screen.may_show(beside, 30.0 * pixel, 0.0));
            assert!(screen.may_show(beside, 60.0 * pixel, 0.0));
            assert!(screen.may_show(beside, 0.0, 51.0) && !screen.may_show(beside, 0.0, 49.0));
        }
    }
}
