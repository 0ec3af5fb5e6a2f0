//! The colours of strokes along a face.

use glam::{DMat3, DVec2, DVec4, UVec2};

use crate::scene::{Analysis, CurvatureKind, Image, Surface};

/// Where the colours of a face come from.
#[derive(Debug, Clone, Copy)]
pub(crate) enum StrokePaint<'a> {
    /// It has one colour.
    Color([u8; 3]),
    /// A picture over the domain.
    Picture(&'a Image),
    /// The curvature.
    Curvature(CurvaturePaint<'a>),
}

/// A face that shows its curvature.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CurvaturePaint<'a> {
    pub(crate) surface: &'a Surface,
    /// The number in the surface of a patch, for surfaces whose patches have domains of their own.
    pub(crate) patch: usize,
    pub(crate) kind: CurvatureKind,
    /// The curvature at the end of the scale.
    pub(crate) limit: f64,
    /// The picture over the domain, whose holes are holes here too.
    pub(crate) picture: Option<&'a Image>,
    /// The position of the eye in world space, or with w = 0 the direction towards it.
    pub(crate) eye: DVec4,
}

impl StrokePaint<'_> {
    /// Whether the colour changes along the face.
    pub(super) const fn varies(&self) -> bool {
        !matches!(self, Self::Color(_))
    }

    /// The colour at (u, v) as shares of the domain; `None` where the picture has a hole.
    pub(super) fn color_at(&self, share: DVec2) -> Option<[u8; 3]> {
        match self {
            Self::Color(color) => Some(*color),
            Self::Picture(picture) => texel(picture, share),
            Self::Curvature(paint) => {
                let is_kept = paint.picture.is_none_or(|picture| texel(picture, share).is_some());
                is_kept.then(|| paint.color_at(share))
            }
        }
    }
}

impl CurvaturePaint<'_> {
    fn color_at(&self, share: DVec2) -> [u8; 3] {
        let [low, high] = self.surface.domain();
        let transform = self.surface.transform;
        let point = self.surface.curved_at(self.patch, low + share * (high - low));
        let position = transform.transform_point3(point.at.position);
        let mapped = point.mapped(&DMat3::from_mat4(transform));
        let to_eye = self.eye.truncate() - self.eye.w * position;
        let seen = mapped.at.du.cross(mapped.at.dv).dot(to_eye);
        let side = if seen < 0.0 { -1.0 } else { 1.0 };
        let value = mapped.curvature().map_or(0.0, |curvature| self.kind.of(&curvature, side));
        Analysis::CURVATURE_COLORS.at(value / self.limit).map(|c| (c * 255.0).round() as u8)
    }
}

/// The colour of a picture at (u, v) as shares of the domain; `None` in a hole.
fn texel(picture: &Image, share: DVec2) -> Option<[u8; 3]> {
    let size = UVec2::from(picture.dimensions());
    let place = DVec2::new(share.x, 1.0 - share.y) * size.as_dvec2();
    let UVec2 { x, y } = place.as_uvec2().min(size - 1);
    let [red, green, blue, alpha] = picture.get_pixel(x, y).0;
    (alpha >= 128).then_some([red, green, blue])
}
