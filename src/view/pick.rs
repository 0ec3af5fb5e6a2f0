//! Picking of control points under the cursor, and their places while they are dragged.

use freeform_surface::{Scene, Surface, ViewProjection};
use glam::{DVec2, DVec3, DVec4, Vec3Swizzles as _, Vec4Swizzles as _, dvec2};

/// The largest distance in pixels between the cursor and a control point that it picks.
pub(crate) const PICK_PX: f64 = 10.0;

/// A control point of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PointId {
    /// The surface's number.
    pub(crate) surface: usize,
    /// The point's number among the surface's control points.
    pub(crate) index: usize,
}

/// The place of a point of the world in the picture: pixels from the upper left corner, and the depth, −1 to 1.
/// It is `None` for points behind the eye.
pub(crate) fn on_screen(projection: &ViewProjection, size: DVec2, point: DVec3) -> Option<DVec3> {
    let clip = projection.projection * projection.view * point.extend(1.0);
    (clip.w > 0.0).then(|| {
        let ndc = clip.xyz() / clip.w;
        DVec3::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y, ndc.z) * size.extend(1.0)
    })
}

/// The point of the world at a place of the picture.
pub(crate) fn in_world(projection: &ViewProjection, size: DVec2, place: DVec3) -> DVec3 {
    let part = place.xy() / size;
    let ndc = dvec2(2.0 * part.x - 1.0, 1.0 - 2.0 * part.y).extend(place.z);
    (projection.projection * projection.view).inverse().project_point3(ndc)
}

/// The control point nearest to the cursor, if it is close enough. Those of faces of CAD models cannot be moved and
/// are not picked.
pub(crate) fn pick(
    scene: &Scene,
    projection: &ViewProjection,
    size: DVec2,
    cursor: DVec2,
) -> Option<PointId> {
    let mut nearest = (PICK_PX, None);
    let movable = |surface: &Surface| surface.face.is_none() && !surface.hidden;
    for (number, surface) in
        scene.surfaces.iter().enumerate().filter(|(_, surface)| movable(surface))
    {
        for (index, point) in surface.world_points().enumerate() {
            let Some(place) = on_screen(projection, size, point) else { continue };
            let distance = place.xy().distance(cursor);
            if distance <= nearest.0 && place.z.abs() <= 1.0 {
                nearest = (distance, Some(PointId { surface: number, index }));
            }
        }
    }
    nearest.1
}

/// A control point in world space.
pub(crate) fn world_point(scene: &Scene, id: PointId) -> Option<DVec3> {
    let surface = scene.surfaces.get(id.surface)?;
    let point = surface.control_points().get(id.index)?;
    Some(surface.transform.transform_point3(point.truncate()))
}

/// The control point moved under the cursor, in the plane through it that faces the viewer; it keeps its
/// weight.
pub(crate) fn dragged(
    scene: &Scene,
    id: PointId,
    projection: &ViewProjection,
    size: DVec2,
    cursor: DVec2,
) -> Option<DVec4> {
    let place = on_screen(projection, size, world_point(scene, id)?)?;
    let world = in_world(projection, size, cursor.extend(place.z));
    let Surface { transform, .. } = scene.surfaces.get(id.surface)?;
    let point = transform.inverse().transform_point3(world);
    let weight = scene.surfaces[id.surface].control_points()[id.index].w;
    point.is_finite().then(|| point.extend(weight))
}

#[cfg(test)]
mod tests {
    use super::*;
    use freeform_surface::{Camera, Lens};
    use glam::{DMat4, DQuat, dvec3};

    const SIZE: DVec2 = dvec2(640.0, 480.0);

    fn scenes() -> Vec<Scene> {
        let mut turned = Scene::listing16();
        turned.surfaces[0].transform = DMat4::from_scale_rotation_translation(
            dvec3(2.0, -1.0, 0.5),
            DQuat::from_rotation_x(0.7),
            dvec3(3.0, 1.0, 2.0),
        );
        let mut flat = Scene::listing16();
        let lens = Lens::Orthographic { height: 2.0 };
        let camera = Camera::new(dvec3(1.0, 3.0, 2.0), dvec3(0.0, 1.0, 0.0), DVec3::Y, lens);
        flat.camera = Some(camera.unwrap());
        vec![Scene::listing16(), turned, flat]
    }

    #[test]
    fn points_are_picked_within_ten_pixels() {
        for scene in scenes() {
            let projection = scene.projection(640, 480);
            for index in 0..16 {
                let id = PointId { surface: 0, index };
                let point = world_point(&scene, id).unwrap();
                let place = on_screen(&projection, SIZE, point).unwrap().xy();
                assert_eq!(pick(&scene, &projection, SIZE, place), Some(id));
            }
            assert_eq!(pick(&scene, &projection, SIZE, dvec2(-50.0, -50.0)), None);
        }
    }

    #[test]
    fn a_dragged_point_is_where_the_cursor_is() {
        for mut scene in scenes() {
            let projection = scene.projection(640, 480);
            for (index, cursor) in [(5, dvec2(100.0, 50.0)), (10, dvec2(500.5, 470.0))] {
                let id = PointId { surface: 0, index };
                let before = world_point(&scene, id).unwrap();
                let depth = |point| projection.view.transform_point3(point).z;
                let point = dragged(&scene, id, &projection, SIZE, cursor).unwrap();
                scene.surfaces[0].set_control_point(point, index).unwrap();
                let after = world_point(&scene, id).unwrap();
                let place = on_screen(&projection, SIZE, after).unwrap().xy();
                assert!(place.distance(cursor) < 1e-6, "{place} {cursor}");
                assert!((depth(after) - depth(before)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn what_is_behind_the_eye_has_no_place() {
        let mut scene = Scene::listing16();
        let lens = Lens::Perspective { fov_y_radians: 1.0 };
        let camera = Camera::new(dvec3(0.0, 1.1, 0.0), dvec3(0.0, 1.1, -1.0), DVec3::Y, lens);
        scene.camera = Some(camera.unwrap());
        let projection = scene.projection(640, 480);
        assert!(on_screen(&projection, SIZE, dvec3(0.0, 1.1, 1.0)).is_none());
        assert!(on_screen(&projection, SIZE, dvec3(0.0, 1.1, -1.0)).is_some());
    }
}
