//! Stripes and colours by which the shape of surfaces is judged.

use glam::DVec3;

use crate::bezier::SurfaceCurvature;
use crate::error::{Error, Result};

/// What a picture shows of surfaces in place of their light and colour, by the exact method. Each pixel, or each sample
/// of a pixel, shows the true surface there, if the triangles are within about a pixel of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Analysis {
    /// The reflection of a striped sphere that is infinitely far away, as in a mirror: where it bends, the surface is
    /// curved, and where it breaks, so does the curvature.
    Zebra(Stripes),
    /// Stripes between lines of equal angle between the normal and a direction.
    Isophotes(Stripes),
    /// The curvature as a colour between blue (at −limit), grey (0) and red (at the limit). Beyond the limits the
    /// colour stays the same. Meshes have no curvature; they are lit.
    Curvature {
        /// Which curvature.
        of: CurvatureKind,
        /// The curvature at the end of the scale, in 1/unit of length, or for the Gaussian one 1/unit². `None`: one
        /// that suits the scene (`PreparedScene::curvature_limit`).
        limit: Option<CurvatureLimit>,
    },
    /// The draft angle as a colour between red (at −limit), yellow (0°) and green (at the limit).
    Draft(Draft),
}

/// The kinds of [`Analysis`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AnalysisKind {
    /// [`Analysis::Zebra`].
    Zebra,
    /// [`Analysis::Isophotes`].
    Isophotes,
    /// [`Analysis::Curvature`].
    Curvature,
    /// [`Analysis::Draft`].
    Draft,
}

impl AnalysisKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Zebra, Self::Isophotes, Self::Curvature, Self::Draft];

    /// The name in scenes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Zebra => "zebra",
            Self::Isophotes => "isophotes",
            Self::Curvature => "curvature",
            Self::Draft => "draft",
        }
    }

    /// The analysis with its default settings.
    #[must_use]
    pub const fn with_defaults(self) -> Analysis {
        let stripes = Stripes { count: StripeCount::DEFAULT, direction: None };
        match self {
            Self::Zebra => Analysis::Zebra(stripes),
            Self::Isophotes => Analysis::Isophotes(stripes),
            Self::Curvature => Analysis::Curvature { of: CurvatureKind::Gaussian, limit: None },
            Self::Draft => {
                Analysis::Draft(Draft { pull: Direction(DVec3::Z), limit: DraftLimit::DEFAULT })
            }
        }
    }
}

impl std::str::FromStr for AnalysisKind {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let expected = "\"zebra\", \"isophotes\", \"curvature\" or \"draft\"";
        (Self::ALL.into_iter().find(|kind| kind.name() == name))
            .ok_or_else(|| Error::invalid("shading", format!("\"{name}\""), expected))
    }
}

/// Some settings of an analysis. `None` leaves one as it is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AnalysisChange {
    /// [`Stripes::count`].
    pub stripes: Option<StripeCount>,
    /// [`Stripes::direction`] or [`Draft::pull`].
    pub direction: Option<Direction>,
    /// The kind of curvature.
    pub curvature: Option<CurvatureKind>,
    /// The curvature at the end of the scale.
    pub limit: Option<CurvatureLimit>,
    /// [`Draft::limit`].
    pub limit_degrees: Option<DraftLimit>,
}

/// The colours of a scale: at its lower end, in the middle and at its upper end; red, green and blue, each 0 … 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScaleColors([[f32; 3]; 3]);

impl Analysis {
    /// The analysis with some other settings.
    ///
    /// # Errors
    /// A setting that this kind of analysis does not have.
    pub fn changed(mut self, change: &AnalysisChange) -> Result<Self> {
        let AnalysisChange { stripes, direction, curvature, limit, limit_degrees } = *change;
        match &mut self {
            Self::Zebra(own) | Self::Isophotes(own) => {
                own.count = stripes.unwrap_or(own.count);
                own.direction = direction.or(own.direction);
            }
            Self::Curvature { of, limit: own } => {
                *of = curvature.unwrap_or(*of);
                *own = limit.or(*own);
            }
            Self::Draft(own) => {
                own.pull = direction.unwrap_or(own.pull);
                own.limit = limit_degrees.unwrap_or(own.limit);
            }
        }
        let kind = self.kind();
        let has_stripes = matches!(self, Self::Zebra(_) | Self::Isophotes(_));
        let is_curvature = kind == AnalysisKind::Curvature;
        let given = [
            ("stripes", stripes.is_some(), has_stripes),
            ("direction", direction.is_some(), !is_curvature),
            ("curvature", curvature.is_some(), is_curvature),
            ("limit", limit.is_some(), is_curvature),
            ("limit_degrees", limit_degrees.is_some(), kind == AnalysisKind::Draft),
        ];
        match given.into_iter().find(|(_, is_given, has_it)| *is_given && !has_it) {
            Some((name, ..)) => {
                let found = format!("given with {}", kind.name());
                Err(Error::invalid(name, found, "a kind of shading that has it"))
            }
            None => Ok(self),
        }
    }

    /// Its kind.
    #[must_use]
    pub const fn kind(&self) -> AnalysisKind {
        match self {
            Self::Zebra(_) => AnalysisKind::Zebra,
            Self::Isophotes(_) => AnalysisKind::Isophotes,
            Self::Curvature { .. } => AnalysisKind::Curvature,
            Self::Draft(_) => AnalysisKind::Draft,
        }
    }

    /// From blue to grey to red. Keep in step with `glsl/common/analysis.glsl`.
    pub(crate) const CURVATURE_COLORS: ScaleColors =
        ScaleColors([[0.23, 0.3, 0.75], [0.87, 0.87, 0.87], [0.71, 0.02, 0.15]]);
    /// From red to yellow to green. Keep in step with `glsl/common/analysis.glsl`.
    pub(crate) const DRAFT_COLORS: ScaleColors =
        ScaleColors([[0.8, 0.15, 0.15], [0.98, 0.88, 0.4], [0.15, 0.6, 0.25]]);

    /// The colours of its scale, if it has one.
    #[must_use]
    pub const fn scale_colors(&self) -> Option<ScaleColors> {
        match self {
            Self::Zebra(_) | Self::Isophotes(_) => None,
            Self::Curvature { .. } => Some(Self::CURVATURE_COLORS),
            Self::Draft(_) => Some(Self::DRAFT_COLORS),
        }
    }
}

impl ScaleColors {
    /// The colour of a value between −1 and 1, the ends of the scale. Beyond them it stays the same.
    #[must_use]
    pub fn at(&self, value: f64) -> [f32; 3] {
        let [low, middle, high] = self.0;
        let (end, share) = (if value < 0.0 { low } else { high }, value.abs().min(1.0) as f32);
        std::array::from_fn(|i| middle[i] + share * (end[i] - middle[i]))
    }
}

/// The stripes of [`Analysis::Zebra`] and [`Analysis::Isophotes`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stripes {
    /// How many there are.
    ///
    /// Zebra: on the whole sphere, between planes at equal distances, so all have the same area. Isophotes: between a
    /// right angle to the direction and the direction itself, at equal steps of the cosine.
    pub count: StripeCount,
    /// The axis of the striped sphere, or the direction that angles are measured from, in world space. `None`: what is
    /// upright in the picture.
    pub direction: Option<Direction>,
}

/// A number of stripes: from 1 to 1000.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StripeCount(u32);

impl StripeCount {
    /// The largest number.
    pub const MAX: Self = Self(1000);
    /// Thirty.
    const DEFAULT: Self = Self(30);

    /// A number of stripes.
    ///
    /// # Errors
    /// Anything outside 1 … 1000.
    pub fn new(count: i64) -> Result<Self> {
        match u32::try_from(count) {
            Ok(count @ 1..=1000) => Ok(Self(count)),
            _ => Err(Error::invalid("number of stripes", count, "a whole number from 1 to 1000")),
        }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

/// A direction in world space, of length 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Direction(DVec3);

impl Direction {
    /// The direction of a vector of any length.
    ///
    /// # Errors
    /// A vector that is not finite, or without a direction.
    pub fn new(vector: DVec3) -> Result<Self> {
        // What is written of a direction is read back as the same one.
        if (vector.length_squared() - 1.0).abs() <= 4.0 * f64::EPSILON {
            return Ok(Self(vector));
        }
        // First by the largest component, so that squares neither overflow nor vanish.
        let scaled = vector / vector.abs().max_element();
        match scaled.try_normalize() {
            Some(unit) => Ok(Self(unit)),
            None => Err(Error::invalid(
                "direction",
                format!("{:?}", vector.to_array()),
                "three finite numbers that are not all 0",
            )),
        }
    }

    /// The vector of length 1.
    #[must_use]
    pub const fn get(self) -> DVec3 {
        self.0
    }
}

/// Which curvature of a surface. k₁ and k₂ are the principal curvatures.
///
/// In pictures, k₁ and k₂ are above 0 where the side that is seen bends towards the eye, as in a bowl, and below 0 where
/// it bulges. The parameters of the surface do not matter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum CurvatureKind {
    /// k₁ k₂: above 0 on bowls and bulges, below 0 on saddles, 0 where the surface can be unrolled.
    #[default]
    Gaussian,
    /// (k₁ + k₂) / 2.
    Mean,
    /// The one of larger magnitude. Its reciprocal is the smallest radius.
    Largest,
}

impl CurvatureKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Gaussian, Self::Mean, Self::Largest];

    /// The name in scenes.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gaussian => "gaussian",
            Self::Mean => "mean",
            Self::Largest => "largest",
        }
    }

    /// Its value at a point whose visible side is that of Su × Sv (1) or the other one (−1).
    pub(crate) fn of(self, curvature: &SurfaceCurvature, side: f64) -> f64 {
        match self {
            Self::Gaussian => curvature.gaussian,
            Self::Mean => side * curvature.mean,
            Self::Largest => side * curvature.largest(),
        }
    }
}

impl std::str::FromStr for CurvatureKind {
    type Err = Error;

    fn from_str(name: &str) -> Result<Self> {
        let expected = "\"gaussian\", \"mean\" or \"largest\"";
        (Self::ALL.into_iter().find(|kind| kind.name() == name))
            .ok_or_else(|| Error::invalid("curvature", format!("\"{name}\""), expected))
    }
}

/// The curvature at the end of a scale: from 1e-30 to 1e30.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct CurvatureLimit(f64);

impl CurvatureLimit {
    /// A limit, in 1/unit of length, or for the Gaussian curvature 1/unit².
    ///
    /// # Errors
    /// Anything outside 1e-30 … 1e30.
    pub fn new(limit: f64) -> Result<Self> {
        if (1e-30..=1e30).contains(&limit) {
            Ok(Self(limit))
        } else {
            Err(Error::invalid("limit of curvature", limit, "a number from 1e-30 to 1e30"))
        }
    }

    /// The number.
    #[must_use]
    pub const fn get(self) -> f64 {
        self.0
    }
}

/// The draft angle: that between the surface and a direction in which it is pulled from a mould, in degrees. On the side
/// that is seen it is above 0 where the normal points with the direction, 0 on a wall along it, and below 0 where the
/// normal points against it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Draft {
    /// The direction of the pull.
    pub pull: Direction,
    /// The angle at the end of the scale.
    pub limit: DraftLimit,
}

/// The draft angle at the end of a scale: above 0° and up to 90°.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct DraftLimit(f64);

impl DraftLimit {
    /// Ten degrees.
    const DEFAULT: Self = Self(10.0);

    /// A limit in degrees.
    ///
    /// # Errors
    /// Anything outside 0.001 … 90.
    pub fn new(degrees: f64) -> Result<Self> {
        if (0.001..=90.0).contains(&degrees) {
            Ok(Self(degrees))
        } else {
            Err(Error::invalid("limit of draft", degrees, "a number of degrees from 0.001 to 90"))
        }
    }

    /// The number of degrees.
    #[must_use]
    pub const fn degrees(self) -> f64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_and_others_refused() {
        for kind in AnalysisKind::ALL {
            assert_eq!(kind.name().parse::<AnalysisKind>().unwrap(), kind);
            assert_eq!(kind.with_defaults().kind(), kind);
        }
        for kind in CurvatureKind::ALL {
            assert_eq!(kind.name().parse::<CurvatureKind>().unwrap(), kind);
        }
        let text = "Zebra".parse::<AnalysisKind>().unwrap_err().to_string();
        assert!(text.contains("\"Zebra\"") && text.contains("isophotes"), "{text}");
        let text = "max".parse::<CurvatureKind>().unwrap_err().to_string();
        assert!(text.contains("\"max\"") && text.contains("largest"), "{text}");
    }

    #[test]
    fn settings_belong_to_their_kinds() {
        let none = AnalysisChange::default();
        let change =
            |kind: AnalysisKind, change: AnalysisChange| kind.with_defaults().changed(&change);
        let upright = Direction::new(3.0 * DVec3::Y).unwrap();
        let changes = [
            AnalysisChange { stripes: StripeCount::new(7).ok(), ..none },
            AnalysisChange { direction: Some(upright), ..none },
            AnalysisChange { curvature: Some(CurvatureKind::Mean), ..none },
            AnalysisChange { limit: CurvatureLimit::new(0.5).ok(), ..none },
            AnalysisChange { limit_degrees: DraftLimit::new(3.0).ok(), ..none },
        ];
        for (kind, has) in [
            (AnalysisKind::Zebra, [true, true, false, false, false]),
            (AnalysisKind::Isophotes, [true, true, false, false, false]),
            (AnalysisKind::Curvature, [false, false, true, true, false]),
            (AnalysisKind::Draft, [false, true, false, false, true]),
        ] {
            assert_eq!(change(kind, none).unwrap(), kind.with_defaults());
            for (one, has) in changes.iter().zip(has) {
                match change(kind, *one) {
                    Ok(changed) => assert!(has && changed != kind.with_defaults(), "{changed:?}"),
                    Err(error) => {
                        assert!(!has && error.to_string().contains(kind.name()), "{error}")
                    }
                }
            }
        }
        let stripes = Stripes { count: StripeCount::new(7).unwrap(), direction: Some(upright) };
        let both = AnalysisChange { direction: Some(upright), ..changes[0] };
        assert_eq!(change(AnalysisKind::Zebra, both).unwrap(), Analysis::Zebra(stripes));
        let limit = CurvatureLimit::new(0.5).ok();
        let both = AnalysisChange { limit, ..changes[2] };
        let expected = Analysis::Curvature { of: CurvatureKind::Mean, limit };
        assert_eq!(change(AnalysisKind::Curvature, both).unwrap(), expected);
    }

    #[test]
    fn limits_are_limits() {
        assert!(StripeCount::new(0).is_err() && StripeCount::new(1001).is_err());
        assert_eq!(StripeCount::new(1000).unwrap(), StripeCount::MAX);
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(CurvatureLimit::new(bad).is_err() && DraftLimit::new(bad).is_err(), "{bad}");
        }
        assert!(DraftLimit::new(90.0).is_ok() && DraftLimit::new(90.1).is_err());
        for bad in [DVec3::ZERO, DVec3::NAN, DVec3::INFINITY, DVec3::new(1.0, f64::INFINITY, 0.0)] {
            assert!(Direction::new(bad).is_err(), "{bad}");
        }
        for size in [1e-300, 1.0, 1e300] {
            let unit = Direction::new(size * DVec3::new(3.0, 0.0, -4.0)).unwrap().get();
            assert!((unit - DVec3::new(0.6, 0.0, -0.8)).length() < 1e-15, "{size}");
        }
    }
}
