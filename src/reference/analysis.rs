//! Stripes and colours of analyses in `f64`: the twin of `glsl/common/analysis.glsl`. Keep them in step.

use glam::{DMat3, DVec3};

use crate::bezier::CurvedPoint;
use crate::camera::ViewProjection;
use crate::scene::{Analysis, CurvatureKind, Direction, Draft, Stripes};

/// What an analysis shows at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shown {
    /// A place among the stripes, from 0 to their number. The whole part is the number of a stripe.
    Stripes(f64),
    /// A value on the scale, whose ends are −1 and 1.
    Scale(f64),
}

impl Shown {
    /// What an analysis shows at a point in world space that is seen by a camera. `limit` is the curvature at the end of
    /// the scale. `None` where the surface has no normal.
    #[must_use]
    pub fn at(
        analysis: &Analysis,
        limit: f64,
        camera: &ViewProjection,
        point: &CurvedPoint,
    ) -> Option<Self> {
        let to_view = DMat3::from_mat4(camera.view);
        let position = camera.view.transform_point3(point.at.position);
        let is_perspective = camera.projection.row(3).z != 0.0;
        let to_eye = if is_perspective { -position.normalize() } else { DVec3::Z };
        let cross = to_view * point.at.du.cross(point.at.dv);
        let normal = cross.try_normalize()?;
        let side = if normal.dot(to_eye) < 0.0 { -1.0 } else { 1.0 };
        let upright = |own: Option<Direction>| own.map_or(DVec3::Y, |own| to_view * own.get());
        Some(match *analysis {
            Analysis::Zebra(Stripes { count, direction }) => {
                let mirrored = 2.0 * normal.dot(to_eye) * normal - to_eye;
                let share = 0.5 + 0.5 * mirrored.dot(upright(direction));
                Self::Stripes(share * f64::from(count.get()))
            }
            Analysis::Isophotes(Stripes { count, direction }) => {
                Self::Stripes(normal.dot(upright(direction)).abs() * f64::from(count.get()))
            }
            Analysis::Curvature { of, .. } => {
                let curvature = point.curvature()?;
                let value = match of {
                    CurvatureKind::Gaussian => curvature.gaussian,
                    CurvatureKind::Mean => side * curvature.mean,
                    CurvatureKind::Largest => side * curvature.largest(),
                };
                Self::Scale(value / limit)
            }
            Analysis::Draft(Draft { pull, limit }) => {
                let sine = side * normal.dot(to_view * pull.get());
                Self::Scale(sine.clamp(-1.0, 1.0).asin().to_degrees() / limit.degrees())
            }
        })
    }

    /// The colour in a picture, of 8 bits for each channel.
    #[must_use]
    pub fn color(&self, analysis: &Analysis) -> [u8; 3] {
        const DARK: f32 = 0.1;
        const BRIGHT: f32 = 0.95;
        let rgb = match self {
            Self::Stripes(place) => [if place.floor() % 2.0 == 0.0 { DARK } else { BRIGHT }; 3],
            Self::Scale(value) => {
                analysis.scale_colors().map_or([0.0; 3], |colors| colors.at(*value))
            }
        };
        rgb.map(|channel| (channel * 255.0).round() as u8)
    }
}
