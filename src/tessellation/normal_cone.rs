//! What is known of a patch's normals before anything is drawn: whether one may vanish, and a cone
//! that holds them all.

use glam::{DVec3, DVec4, Vec3};

use crate::bezier::Degree;

/// How often a patch is halved to find out.
const MOST_HALVINGS: u32 = 3;

/// Normals of a patch, in the space of its control points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NormalCone {
    /// All normals Su × Sv turn away from this direction by at most the angle below; zero if that is
    /// not known, because one may vanish or the patch is rational.
    axis: Vec3,
    /// Sine of the angle.
    sine: f32,
}

/// Where a surface is seen from, in the space of its control points.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Eye {
    /// From a place.
    At(DVec3),
    /// From infinitely far: the direction towards the eye.
    Towards(DVec3),
}

impl NormalCone {
    const UNKNOWN: Self = Self { axis: Vec3::ZERO, sine: 1.0 };

    pub(crate) fn new(degree: Degree, points: &[DVec4]) -> Self {
        if points.iter().any(|point| point.w != 1.0) {
            return Self::UNKNOWN;
        }
        let side = degree.side();
        let net: Vec<DVec3> = points.iter().map(|point| point.truncate()).collect();
        let sum =
            |step: usize, from: usize| -> DVec3 { (0..side).map(|i| net[from + i * step]).sum() };
        let along_u = sum(side, side - 1) - sum(side, 0);
        let along_v = sum(1, net.len() - side) - sum(1, 0);
        let Some(axis) = along_u.cross(along_v).try_normalize() else { return Self::UNKNOWN };
        let longest = |step: usize, skip: fn(usize, usize) -> bool| {
            (0..net.len())
                .filter(|i| !skip(*i, side))
                .map(|i| (net[i + step] - net[i]).length_squared())
                .fold(0.0, f64::max)
                .sqrt()
        };
        let tangents = Longest {
            u: longest(1, |i, side| i % side == side - 1),
            v: longest(side, |i, side| i / side == side - 1),
        };
        match least_cosine(side, &net, axis, tangents, 0) {
            Some(cosine) => {
                let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
                // Rounded to the safe side.
                Self { axis: axis.as_vec3(), sine: sine as f32 + 1e-5 }
            }
            None => Self::UNKNOWN,
        }
    }

    /// Whether a normal may vanish somewhere, as far as is known: of rational patches nothing is.
    pub(crate) fn may_degenerate(&self) -> bool {
        self.axis == Vec3::ZERO
    }

    /// Whether the whole patch shows its back to the eye: the side from which u and v turn clockwise.
    /// `sign` is −1 if the model's matrix mirrors.
    pub(crate) fn faces_away(&self, points: &[DVec4], eye: Eye, sign: f64) -> bool {
        if self.may_degenerate() {
            return false;
        }
        let (axis, sine) = (self.axis.as_dvec3() * sign, f64::from(self.sine));
        let away = |to_eye: DVec3| to_eye.dot(axis) < -sine * to_eye.length();
        match eye {
            Eye::Towards(direction) => away(direction),
            Eye::At(place) => points.iter().all(|point| away(place - point.truncate())),
        }
    }
}

/// The longest differences of control points along u and v.
#[derive(Clone, Copy)]
struct Longest {
    u: f64,
    v: f64,
}

/// The least cosine between the axis and any normal; none if a normal may vanish or turn further than
/// the halvings can tell.
fn least_cosine(
    side: usize,
    net: &[DVec3],
    axis: DVec3,
    longest: Longest,
    halvings: u32,
) -> Option<f64> {
    // Shaders take tangents that are so much shorter than the longest for none.
    const SHORT: f64 = 2e-3;
    const LEAST: f64 = 0.02;
    let differences = |step: usize, rows: usize, columns: usize| {
        (0..rows * columns).map(move |i| {
            let at = i / columns * side + i % columns;
            net[at + step] - net[at]
        })
    };
    let mut least = 1.0_f64;
    let mut long = true;
    for a in differences(1, side, side - 1) {
        long &= a.length() > SHORT * longest.u;
        for b in differences(side, side - 1, side) {
            let normal = a.cross(b);
            least = least.min(normal.dot(axis) / (a.length() * b.length()));
        }
    }
    long &= differences(side, side - 1, side).all(|b| b.length() > SHORT * longest.v);
    // A cosine of the sum of two angles' worth: the cross product's own length is left out, which
    // makes it smaller.
    if long && least > LEAST {
        return Some(least);
    }
    if halvings == MOST_HALVINGS {
        return None;
    }
    let mut least = 1.0_f64;
    for half in halves(side, net, true) {
        for quarter in halves(side, &half, false) {
            let longest = Longest { u: 0.5 * longest.u, v: 0.5 * longest.v };
            least = least.min(least_cosine(side, &quarter, axis, longest, halvings + 1)?);
        }
    }
    Some(least)
}

/// De Casteljau's algorithm at ½, along u or v.
fn halves(side: usize, net: &[DVec3], along_u: bool) -> [Vec<DVec3>; 2] {
    let (mut low, mut high) = (net.to_vec(), net.to_vec());
    let place = |line: usize, i: usize| if along_u { line * side + i } else { i * side + line };
    for line in 0..side {
        for step in 1..side {
            for i in 0..side - step {
                high[place(line, i)] = 0.5 * (high[place(line, i)] + high[place(line, i + 1)]);
            }
            low[place(line, step)] = high[place(line, 0)];
        }
    }
    [low, high]
}
