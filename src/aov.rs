//! AOVs (arbitrary output variables): pictures whose pixels hold values instead of a colour.

use std::str::FromStr;

use crate::error::{Error, Result};

/// The AOVs of a picture. Each AOV has four values for each pixel, taken at the pixel's centre. Rows run from top to
/// bottom. The fourth value is alpha: 1 where a surface is drawn. Elsewhere all four values are 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Aovs {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// u and v in the domain of the surface, and the number of the patch. Patches are numbered from 0 through all
    /// surfaces of the scene.
    pub uv: Vec<[f32; 4]>,
    /// u and v from 0 to 1 along the patch. `f32` has more digits for them than for the parameters of a NURBS surface
    /// of many patches.
    pub patch_uv: Vec<[f32; 2]>,
    /// The position in world space.
    pub position: Vec<[f32; 4]>,
    /// The unit normal Su × Sv in world space.
    pub normal: Vec<[f32; 4]>,
    /// The distance from the eye along the view axis in world units, in each of the first three values.
    pub depth: Vec<[f32; 4]>,
    /// For faces of CAD models, and 1 as the fourth value only there: the number of the face in its model, its number
    /// among the faces in all places of the model's products, and the number of the model in the scene.
    pub face: Vec<[f32; 4]>,
    /// The Gaussian curvature, the mean curvature, and the principal curvature of larger magnitude, of the true surface
    /// at the pixel's centre, in the world's unit: 1/unit², 1/unit and 1/unit. The latter two are above 0 where the
    /// surface bends towards Su × Sv. Only surfaces of the exact method have them, and only in targets with room for them
    /// (`FloatTarget::for_aovs_and_curvature`).
    pub curvature: Vec<[f32; 4]>,
}

impl Aovs {
    /// A picture of `size` pixels that shows nothing.
    #[must_use]
    pub fn empty(size: (u32, u32)) -> Self {
        let nothing = vec![[0.0; 4]; size.0 as usize * size.1 as usize];
        Self {
            size,
            uv: nothing.clone(),
            patch_uv: vec![[0.0; 2]; nothing.len()],
            position: nothing.clone(),
            normal: nothing.clone(),
            depth: nothing.clone(),
            face: nothing.clone(),
            curvature: nothing,
        }
    }

    /// The values of one kind.
    #[must_use]
    pub fn channel(&self, kind: AovKind) -> &[[f32; 4]] {
        match kind {
            AovKind::Uv => &self.uv,
            AovKind::Position => &self.position,
            AovKind::Normal => &self.normal,
            AovKind::Depth => &self.depth,
            AovKind::Face => &self.face,
            AovKind::Curvature => &self.curvature,
        }
    }
}

/// One of the [`Aovs`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AovKind {
    /// [`Aovs::uv`].
    Uv,
    /// [`Aovs::position`].
    Position,
    /// [`Aovs::normal`].
    Normal,
    /// [`Aovs::depth`].
    Depth,
    /// [`Aovs::face`].
    Face,
    /// [`Aovs::curvature`].
    Curvature,
}

impl AovKind {
    /// Every kind.
    pub const ALL: [Self; 6] =
        [Self::Uv, Self::Position, Self::Normal, Self::Depth, Self::Face, Self::Curvature];

    /// The name that [`AovKind::from_str`] reads: uv, position, normal, depth, face or curvature.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Uv => "uv",
            Self::Position => "position",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Face => "face",
            Self::Curvature => "curvature",
        }
    }
}

impl FromStr for AovKind {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
            let expected = "uv, position, normal, depth, face or curvature";
            Error::invalid("AOV", format!("\"{name}\""), expected)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_others_refused() {
        for kind in AovKind::ALL {
            assert_eq!(kind.name().parse::<AovKind>().unwrap(), kind);
        }
        for name in ["", "UV", "normals"] {
            let text = name.parse::<AovKind>().unwrap_err().to_string();
            assert!(text.contains(&format!("\"{name}\"")) && text.contains("depth"), "{text}");
        }
    }

    #[test]
    fn a_channel_is_the_one_of_its_kind() {
        let mut aovs = Aovs::empty((3, 2));
        aovs.uv[0][0] = 1.0;
        aovs.position[0][0] = 2.0;
        aovs.normal[0][0] = 3.0;
        aovs.depth[0][0] = 4.0;
        aovs.face[0][0] = 5.0;
        aovs.curvature[0][0] = 6.0;
        let firsts = AovKind::ALL.map(|kind| aovs.channel(kind)[0][0]);
        assert_eq!(firsts, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert!(AovKind::ALL.iter().all(|kind| aovs.channel(*kind).len() == 6));
    }
}
