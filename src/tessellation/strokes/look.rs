//! What a part of an edge looks like: which parabola stands for it on the screen.

use glam::{DVec2, DVec3};

use super::part::{Bow, Part};
use super::segment::{Layout, StrokeSegment};
use super::{LEAST, PlacedJoint, StrokeView, off_edge};
use crate::bezier::Difference;

/// The longest segment in pixels that has one colour, where colours change along the face.
const VARIED: f64 = 4.0;
/// How often a piece of an edge is divided at most.
const MAX_DIVISIONS: u32 = 40;
/// A part is divided into so many at most. More might be out of the picture.
const MOST_PARTS: f64 = 16.0;
/// The sag of a segment as a share of its length, at most: its direction differs by up to 27° from that of the line
/// between its ends, and Newton's method finds the nearest point.
const MOST_SAG: f64 = 0.125;
/// The sag of a segment times its length, at most, in square pixels: beyond this, a division costs less than the pixels
/// that it saves.
const MOST_AREA: f64 = 800.0;
/// A control point is on the line between its ends if it is nearer to it than this, as a share of the coordinates in
/// pixels.
const ROUNDING: f64 = 1e-9;
/// How far a place on a segment may be along the edge from the (u, v) that it shows, as a share of the tolerance.
const MOST_DRIFT: f64 = 0.25;
/// The number of pixels that the segments of a line may be off its edge.
const OFF_LINE: f64 = 1.0 / 32.0;

/// What a part of an edge looks like.
pub(super) enum Look {
    /// It is not in the picture.
    Outside,
    /// A segment with half of this width covers it: a parabola of a shape, or the line between its ends.
    Drawn(f64, Option<(Shape, Layout)>),
    /// It is too bent, or near the eye. So many parts of it may do.
    Divided(u32),
}

/// A parabola on the screen that stands for one in space.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shape {
    /// Its ends in pixels from the middle of the viewport.
    pub(super) ends: [DVec2; 2],
    /// How far its middle is off the middle of its ends.
    pub(super) sag: DVec2,
    /// Upper bound of its distance from the other one as it is seen, in pixels.
    pub(super) off: f64,
    /// The same at equal parameters, apart from `off`.
    pub(super) drift: f64,
}

impl StrokeView {
    /// What a part looks like. After many divisions it counts as straight.
    pub(super) fn look(
        &self,
        joint: &PlacedJoint<'_>,
        faces_error: f64,
        bow: &Bow,
        divisions: u32,
    ) -> Look {
        let Difference { off, drift } = bow.difference;
        let depths = bow.parabola.points.map(|point| -point.z);
        let farthest = depths.into_iter().fold(f64::NEG_INFINITY, f64::max) + off;
        let nearest = depths.into_iter().fold(f64::INFINITY, f64::min) - off;
        if farthest <= self.near {
            return Look::Outside;
        }
        let is_in_front = nearest > self.near;
        let px = self.px_per_unit(if is_in_front { nearest } else { self.near });
        let (off_edge, gap) = match joint.line {
            Some(_) => (OFF_LINE, 0.0),
            None => (off_edge(self.tolerance), joint.gap),
        };
        let half_width = |error: f64| match joint.line {
            Some(line) => line.half_width,
            None => LEAST + faces_error + error + gap * px,
        };
        let error = off * px;
        if is_in_front && self.is_outside(&bow.parabola.points, half_width(off_edge) + error) {
            return Look::Outside;
        }
        // The width is that of the nearest place; far from it, it may be too much.
        let excess = gap * (px - self.px_per_unit(farthest));
        let limit = off_edge - excess;
        let [start, end] = bow.tips();
        let is_varied = joint.line.is_none() && joint.sides.iter().any(|side| side.paint.varies());
        let is_short = !is_varied || start.distance(end) * px <= VARIED;
        let mut count = 2.0;
        let off_line = if is_in_front {
            let shape = self.shape(bow);
            let (off, sag) = (error + shape.off, shape.sag.length());
            let length = shape.ends[0].distance(shape.ends[1]);
            let is_slim = sag <= MOST_SAG * length && sag * length <= MOST_AREA;
            let is_in_step =
                joint.line.is_some() || drift * px + shape.drift <= MOST_DRIFT * self.tolerance;
            if off <= limit && is_in_step && is_short && is_slim {
                let in_middle = || self.layout(self.steps(joint, bow, &shape, 0.5));
                let layout = self.layout_along(joint, bow, &shape);
                let layout = layout.or_else(|| (sag <= off_edge).then(in_middle));
                if let Some(layout) = layout {
                    return Look::Drawn(half_width(off), Some((shape, layout)));
                }
            }
            if is_short && 2.0 * excess <= off_edge {
                count = (off / limit).max(sag * length / MOST_AREA).cbrt().ceil();
            }
            off + sag
        } else {
            error + bow.parabola.sag().length() * px
        };
        if (off_line <= limit && is_short) || divisions >= MAX_DIVISIONS {
            Look::Drawn(half_width(off_line), None)
        } else {
            Look::Divided(count.clamp(2.0, MOST_PARTS) as u32)
        }
    }

    /// How a parabola in front of the near plane looks.
    ///
    /// Let P₀, C and P₂ be the places of its control points, and d₀, d₁ and d₂ their distances. With the parameter s of
    /// the screen, as it is for straight lines, and A = 2 s (1 − s), what is seen differs from the line
    /// L = (1 − s) P₀ + s P₂ by A (d₁ D + δ (M − L)) / ((1 − s) d₂ + s d₀ + A δ), where M is the place of the middle of
    /// the ends in space, D = C − M, and δ = d₁ − (d₀ + d₂)/2. The parabola that has the same middle differs by A (s − ½)
    /// and A (½ − A) times small factors.
    fn shape(&self, bow: &Bow) -> Shape {
        let ends = bow.tips().map(|tip| self.place(tip));
        let [start, control, end] = bow.parabola.points;
        let to_control = self.place(control) - self.place(start.midpoint(end));
        let exact = |sag: DVec2| Shape { ends, sag, off: 0.0, drift: 0.0 };
        if self.is_parallel {
            return exact(0.5 * to_control);
        }
        let largest = ends[0].abs().max(ends[1].abs()).max_element().max(1.0);
        if to_control.length() < ROUNDING * largest {
            return exact(DVec2::ZERO);
        }
        let [d0, d1, d2] = bow.parabola.points.map(|point| -point.z);
        let (mean, bent) = (0.5 * (d0 + d2), d1 - 0.5 * (d0 + d2));
        let middle = ends[0].midpoint(ends[1]);
        let along = bent * (self.place(start.midpoint(end)) - middle);
        let sag = 0.5 * (d1 * to_control + along) / (mean + 0.5 * bent);
        let [nearest, farthest] = [d0.min(d1).min(d2), d0.max(d1).max(d2)];
        let (off, drift) = if farthest < 1.3 * nearest {
            // Along the line, a share of what the middle does not show lies across the slope of the parabola too.
            let off = (0.15 * (d0 - d2).abs() + 0.45 * bent.abs()) * to_control.length();
            (off / nearest, 0.15 * bent.abs() * ends[0].distance(ends[1]) / nearest)
        } else {
            (f64::INFINITY, f64::INFINITY)
        };
        Shape { ends, sag, off, drift }
    }

    /// Appends the segments of a part that is a cubic.
    pub(super) fn add_part(
        &self,
        joint: &PlacedJoint<'_>,
        faces_error: f64,
        part: Part,
        divisions: u32,
        segments: &mut Vec<StrokeSegment>,
    ) {
        let bow = part.bow();
        match self.look(joint, faces_error, &bow, divisions) {
            Look::Outside => {}
            Look::Drawn(half_width, shape) => {
                segments.extend(self.segment(joint, &bow, half_width, shape));
            }
            Look::Divided(count) => {
                for number in 0..count {
                    let [from, to] = [number, number + 1].map(|i| f64::from(i) / f64::from(count));
                    let part = part.between(from, to);
                    self.add_part(joint, faces_error, part, divisions + 1, segments);
                }
            }
        }
    }

    /// Whether all points lie beyond one side of the picture by more than a width in pixels.
    fn is_outside(&self, points: &[DVec3; 3], width: f64) -> bool {
        let limit = 1.0 + width / self.half;
        let places = points.map(|point| self.place(point) / self.half);
        (0..2).any(|axis| {
            places.iter().all(|place| place[axis] > limit[axis])
                || places.iter().all(|place| place[axis] < -limit[axis])
        })
    }
}

#[cfg(test)]
mod tests {
    use glam::{dvec3, uvec2};

    use super::super::part::End;
    use super::*;
    use crate::bezier::Parabola;
    use crate::camera::{Camera, Lens};

    const SIZE: glam::UVec2 = uvec2(1280, 720);

    fn view(lens: Lens) -> StrokeView {
        let eye = dvec3(0.0, 0.0, 5.0);
        let camera = Camera::new(eye, DVec3::ZERO, DVec3::Y, lens).unwrap();
        let points = [DVec3::splat(-1.0), DVec3::ONE];
        StrokeView::new(&camera.projection(points.into_iter(), 16.0 / 9.0), SIZE, 0.5)
    }

    /// A parabola in view space, about 5 away from the eye.
    fn bow(seed: i32) -> Bow {
        let noise = |i: i32| (f64::from(seed * 17 + i) * 12.9898).sin();
        let start = dvec3(noise(0), noise(1), -5.0 + 0.3 * noise(2));
        let end = start + 0.3 * dvec3(1.0, noise(3), noise(4));
        let sag = 0.03 * dvec3(noise(5), noise(6), noise(7));
        let parabola = Parabola::through(start, start.midpoint(end) + sag, end);
        let nowhere = End { normals: [DVec3::ZERO; 2], shares: [DVec2::ZERO; 2] };
        let (difference, middle, is_end) = (Difference::default(), [DVec2::ZERO; 2], [true; 2]);
        Bow { parabola, difference, ends: [nowhere; 2], middle, is_end }
    }

    /// Compares a parabola as it is seen with the one that stands for it on the screen: the largest distances at equal
    /// parameters, as shares of the bounds, and from the nearest point.
    #[test]
    fn on_the_screen_a_parabola_is_near_another_one() {
        let lenses = [Lens::Perspective { fov_y_radians: 0.6 }, Lens::Orthographic { height: 3.0 }];
        for view in lenses.map(view) {
            for seed in 0..200 {
                let bow = bow(seed);
                let shape = view.shape(&bow);
                let [a, _, c] = bow.parabola.points;
                let at = |t: f64| bow.parabola.at(t);
                let on_screen =
                    |s: f64| shape.ends[0].lerp(shape.ends[1], s) + 4.0 * s * (1.0 - s) * shape.sag;
                for i in 0..=20 {
                    let s = f64::from(i) / 20.0;
                    // As exact/stroke.frag has it.
                    let across = c.z + (a.z - c.z) * s;
                    let t = if view.is_parallel { s } else { s * a.z / across };
                    let seen = view.place(at(t));
                    let apart = seen.distance(on_screen(s));
                    assert!(
                        apart <= shape.off + shape.drift + 1e-9,
                        "{seed} {s}: {apart} {shape:?}"
                    );
                    let around = (-200..=200).map(|k| on_screen(s + f64::from(k) * 1e-4));
                    let nearest = around.map(|p| p.distance(seen)).fold(f64::INFINITY, f64::min);
                    assert!(nearest <= shape.off + 1e-3, "{seed} {s}: {nearest} {shape:?}");
                    let sag = 4.0 * s * (1.0 - s) * bow.parabola.sag().z;
                    let depth = if view.is_parallel {
                        a.z + (c.z - a.z) * s + sag
                    } else {
                        a.z * c.z / across * (1.0 + sag / across)
                    };
                    assert!((depth - at(t).z).abs() < 1e-12, "{seed} {s}: {depth} {}", at(t).z);
                }
            }
        }
    }
}
