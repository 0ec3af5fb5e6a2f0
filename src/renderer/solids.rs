//! Solids of CAD models in the places of a scene. From outside, faces that face away are hidden by others, so their
//! patches and their edges need not be drawn.

use std::collections::HashMap;

use glam::{DMat3, DMat4, DVec3};

use super::PreparedSurface;
use crate::bezier::bounding_box;
use crate::camera::ViewProjection;
use crate::model::Outside;
use crate::scene::{FaceOfModel, Paint, Scene};
use crate::tessellation::Eye;

/// The solids of a scene, and which of them the last view shows from outside.
#[derive(Debug, Default)]
pub(crate) struct Solids {
    solids: Vec<Solid>,
    /// For each surface, the number of its solid, and 1 if its ∂u × ∂v points out of it, else −1.
    of_surface: Vec<Option<(usize, f64)>>,
}

/// Surfaces that enclose a solid.
#[derive(Debug)]
struct Solid {
    surfaces: Vec<usize>,
    /// Whether none of its faces is missing.
    is_whole: bool,
    /// The middle and the radius of a ball around it, in model space.
    ball: (DVec3, f64),
    /// The viewpoint in model space, if the solid is seen from outside and as it was made.
    eye: Option<Eye>,
}

impl Solids {
    /// `places` are the faces that the scene's surfaces are.
    pub(crate) fn new(scene: &Scene, places: &[Option<FaceOfModel>]) -> Self {
        let mut faces_of: HashMap<(usize, usize), usize> = HashMap::new();
        for (number, model) in scene.models.iter().enumerate() {
            for Outside { solid, .. } in model.outsides.iter().flatten() {
                *faces_of.entry((number, *solid)).or_default() += 1;
            }
        }
        let mut numbers = HashMap::new();
        let mut members: Vec<Vec<usize>> = Vec::new();
        let mut expected = Vec::new();
        let mut of_surface = vec![None; scene.surfaces.len()];
        for (number, place) in places.iter().enumerate() {
            let Some(FaceOfModel { model, face, instance }) = *place else { continue };
            let outside = scene.models.get(model).and_then(|model| model.outsides.get(face));
            let Some(Outside { solid, sign }) = outside.copied().flatten() else { continue };
            // The faces of a product are numbered alike in all of its places.
            let place = (model, solid, instance.wrapping_sub(face));
            let own = *numbers.entry(place).or_insert(members.len());
            if own == members.len() {
                members.push(Vec::new());
                expected.push(faces_of[&(model, solid)]);
            }
            members[own].push(number);
            of_surface[number] = Some((own, sign));
        }
        let solids = members.into_iter().zip(expected).map(|(surfaces, expected)| {
            let points = surfaces.iter().flat_map(|number| scene.surfaces[*number].patch_points());
            let [low, high] = bounding_box(points.map(|point| point.truncate()));
            let ball = (low.midpoint(high), 0.5 * low.distance(high));
            Solid { is_whole: surfaces.len() == expected, surfaces, ball, eye: None }
        });
        Self { solids: solids.collect(), of_surface }
    }

    /// Finds which solids a view shows from outside. In a `see_through` picture there are none.
    pub(super) fn update(
        &mut self,
        surfaces: &[PreparedSurface],
        camera: &ViewProjection,
        see_through: bool,
    ) {
        for solid in &mut self.solids {
            let transform = surfaces[solid.surfaces[0]].surface().transform;
            let is_as_made = |number: &usize| {
                let surface = &surfaces[*number];
                let is_opaque = surface.texture().is_none()
                    && matches!(surface.surface().paint, Paint::Color(_))
                    && !surface.surface().hidden;
                is_opaque && !surface.is_reshaped() && surface.surface().transform == transform
            };
            let is_seen = solid.is_whole
                && !see_through
                && solid.surfaces.iter().all(is_as_made)
                && solid.is_in_front(surfaces, &transform, camera);
            solid.eye = is_seen.then(|| eye_in_model(camera, &transform));
        }
    }

    /// The viewpoint in the model of a surface that encloses a solid seen from outside, the number of the solid, and 1 if
    /// the surface's ∂u × ∂v points out of it, else −1.
    pub(super) fn seen(&self, surface: usize) -> Option<(Eye, usize, f64)> {
        let (solid, sign) = self.of_surface.get(surface).copied().flatten()?;
        Some((self.solids[solid].eye?, solid, sign))
    }
}

impl Solid {
    /// Whether all of it lies beyond the near plane.
    fn is_in_front(
        &self,
        surfaces: &[PreparedSurface],
        transform: &DMat4,
        camera: &ViewProjection,
    ) -> bool {
        let to_view = camera.view * *transform;
        let linear = DMat3::from_mat4(to_view);
        let axes = [linear.x_axis, linear.y_axis, linear.z_axis];
        let stretch = axes.iter().map(|axis| axis.length_squared()).sum::<f64>().sqrt();
        let nearest = camera.nearest();
        let depth = |point: DVec3| -to_view.transform_point3(point).z;
        let (middle, radius) = self.ball;
        if depth(middle) - stretch * radius > nearest {
            return true;
        }
        // The near plane is often close to the scene.
        let own = self.surfaces.iter().map(|number| surfaces[*number].surface());
        let mut points = own.flat_map(|surface| surface.patch_points());
        points.all(|point| depth(point.truncate()) > nearest)
    }
}

/// The position of the eye, or the direction towards it, in model space.
pub(super) fn eye_in_model(camera: &ViewProjection, model: &DMat4) -> Eye {
    let from_view = (camera.view * *model).inverse();
    // Lines of sight are parallel where clip w does not depend on the depth.
    if camera.projection.row(3).z == 0.0 {
        Eye::Towards(from_view.transform_vector3(DVec3::Z))
    } else {
        Eye::At(from_view.transform_point3(DVec3::ZERO))
    }
}
