//! Rasterises triangles, lines and squares, with perspective-correct values and a depth buffer.

use glam::{DMat4, DVec2, DVec3, DVec4, UVec2};

use super::{Fragment, Picture, Pixel, to_bytes};
use crate::scene::Image;

/// A vertex in clip space with the values that are interpolated over triangles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    clip: DVec4,
    position: DVec3,
    normal: DVec3,
    uv: DVec2,
}

impl Vertex {
    pub(super) const fn new(clip: DVec4, position: DVec3, normal: DVec3, uv: DVec2) -> Self {
        Self { clip, position, normal, uv }
    }

    pub(super) const fn position(&self) -> DVec3 {
        self.position
    }

    pub(super) const fn normal(&self) -> DVec3 {
        self.normal
    }

    pub(super) const fn uv(&self) -> DVec2 {
        self.uv
    }

    pub(super) fn depth(&self) -> f64 {
        self.clip.z / self.clip.w
    }

    /// Σ weightᵢ · vertexᵢ.
    fn sum<const N: usize>(vertices: &[Self; N], weights: [f64; N]) -> Self {
        let mut sum = Self::new(DVec4::ZERO, DVec3::ZERO, DVec3::ZERO, DVec2::ZERO);
        for (vertex, weight) in vertices.iter().zip(weights) {
            sum.clip += vertex.clip * weight;
            sum.position += vertex.position * weight;
            sum.normal += vertex.normal * weight;
            sum.uv += vertex.uv * weight;
        }
        sum
    }
}

/// The point of a triangle or line at a pixel's centre.
pub(super) struct Sample {
    /// The interpolated values.
    pub(super) vertex: Vertex,
    /// The change of (u, v) to the next pixel on the right and to the next pixel below.
    pub(super) uv_per_px: [DVec2; 2],
    /// Distance from the nearest edge of the triangle, in pixels.
    pub(super) edge_px: f64,
    /// Upright on the triangle in view space, towards the eye, of any length; 0 on a line.
    pub(super) upright: DVec3,
    /// Whether the triangle turns counter-clockwise on the screen.
    pub(super) front: bool,
}

/// Returns a sample's description, and its colour unless it is cut.
type Shade<'a> = dyn FnMut(&Sample) -> (Option<DVec3>, Fragment) + 'a;

/// A picture while it is drawn.
pub(super) struct Raster {
    size: UVec2,
    colors: Vec<DVec4>,
    depths: Vec<f64>,
    pixels: Vec<Pixel>,
}

impl Raster {
    pub(super) fn new(size: UVec2, background: [f32; 4]) -> Self {
        let count = (size.x * size.y) as usize;
        Self {
            size,
            colors: vec![DVec4::from(background.map(f64::from)); count],
            depths: vec![1.0; count],
            pixels: vec![Pixel::Background; count],
        }
    }

    pub(super) fn into_picture(self, projection: DMat4) -> Picture {
        let bytes = self.colors.iter().flat_map(|color| to_bytes(*color)).collect();
        Picture {
            image: Image::from_raw(self.size.x, self.size.y, bytes).expect("four bytes a pixel"),
            pixels: self.pixels,
            projection,
        }
    }

    /// Clip space to pixels, x to the right, y downwards.
    fn window(&self, clip: DVec4) -> DVec2 {
        let ndc = clip.truncate().truncate() / clip.w;
        DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * self.size.as_dvec2()
    }

    fn put(
        &mut self,
        [x, y]: [usize; 2],
        depth: f64,
        shaded: impl FnOnce() -> (Option<DVec3>, Fragment),
    ) {
        let place = y * self.size.x as usize + x;
        if !(-1.0..self.depths[place]).contains(&depth) {
            return;
        }
        let (color, fragment) = shaded();
        if let Some(color) = color {
            self.depths[place] = depth;
            self.colors[place] = color.extend(1.0);
            self.pixels[place] = Pixel::Surface(fragment);
        } else if matches!(self.pixels[place], Pixel::Background) {
            self.pixels[place] = Pixel::Hole(fragment);
        }
    }

    /// Fills a triangle; pixels whose centre lies on an edge belong to its upper or left side.
    pub(super) fn triangle(&mut self, corners: [Vertex; 3], shade: &mut Shade<'_>) {
        let polygon = clipped_to_near(&corners);
        for i in 2..polygon.len() {
            self.clipped_triangle([polygon[0], polygon[i - 1], polygon[i]], shade);
        }
    }

    fn clipped_triangle(&mut self, mut corners: [Vertex; 3], shade: &mut Shade<'_>) {
        let mut places = corners.map(|corner| self.window(corner.clip));
        let area = |[a, b, c]: [DVec2; 3]| (b - a).perp_dot(c - a);
        // Counter-clockwise on the screen is clockwise in pixels, whose y points down.
        let front = area(places) < 0.0;
        if !front {
            corners.swap(1, 2);
            places.swap(1, 2);
        }
        let whole = area(places);
        if whole == 0.0 || !whole.is_finite() {
            return;
        }
        let low = places[0].min(places[1]).min(places[2]).floor().max(DVec2::ZERO);
        let high = places[0].max(places[1]).max(places[2]).ceil().min(self.size.as_dvec2());
        let weights_at = |pixel: DVec2| {
            let linear = [
                area([pixel, places[1], places[2]]) / whole,
                area([places[0], pixel, places[2]]) / whole,
                area([places[0], places[1], pixel]) / whole,
            ];
            let over_w = [0, 1, 2].map(|i| linear[i] / corners[i].clip.w);
            let sum: f64 = over_w.iter().sum();
            (linear, over_w.map(|weight| weight / sum))
        };
        let [to_second, to_third] = [1, 2].map(|i| corners[i].position - corners[0].position);
        // The corners turn counter-clockwise on the screen now.
        let upright = to_second.cross(to_third);
        let edge = |i: usize| places[(i + 1) % 3].distance(places[(i + 2) % 3]);
        let heights = [0, 1, 2].map(|i| whole.abs() / edge(i));
        for y in low.y as usize..high.y as usize {
            for x in low.x as usize..high.x as usize {
                let center = DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let (linear, weights) = weights_at(center);
                if !(0..3).all(|i| owns(linear[i], places[(i + 1) % 3], places[(i + 2) % 3])) {
                    continue;
                }
                let depth = (0..3).map(|i| linear[i] * corners[i].depth()).sum();
                self.put([x, y], depth, || {
                    let vertex = Vertex::sum(&corners, weights);
                    let uv_per_px = [DVec2::X, DVec2::Y].map(|step| {
                        let (_, weights) = weights_at(center + step);
                        Vertex::sum(&corners, weights).uv - vertex.uv
                    });
                    let edges_px = [0, 1, 2].map(|i| linear[i] * heights[i]);
                    shade(&Sample {
                        vertex,
                        uv_per_px,
                        edge_px: edges_px.into_iter().fold(f64::INFINITY, f64::min),
                        upright,
                        front,
                    })
                });
            }
        }
    }

    /// Draws a line, one pixel for each column or row of its longer axis.
    pub(super) fn line(&mut self, ends: [Vertex; 2], shade: &mut Shade<'_>) {
        let inside = ends.map(|end| end.clip.z + end.clip.w);
        let ends = match inside.map(|distance| distance > 0.0) {
            [true, true] => ends,
            [false, false] => return,
            [first, _] => {
                let t = inside[0] / (inside[0] - inside[1]);
                let at_near = Vertex::sum(&ends, [1.0 - t, t]);
                if first { [ends[0], at_near] } else { [at_near, ends[1]] }
            }
        };
        let [from, to] = ends.map(|end| self.window(end.clip));
        let length = to - from;
        let axis = if length.x.abs() >= length.y.abs() { DVec2::X } else { DVec2::Y };
        let (start, end) = (from.dot(axis), to.dot(axis));
        let last = self.size.as_dvec2().dot(axis);
        let first_center = (start.min(end) - 0.5).ceil().max(0.0);
        let mut center = first_center + 0.5;
        while center < start.max(end) && center < last {
            let t = (center - start) / (end - start);
            let place = from + length * t;
            if place.cmpge(DVec2::ZERO).all() && place.cmplt(self.size.as_dvec2()).all() {
                let over_w = [(1.0 - t) / ends[0].clip.w, t / ends[1].clip.w];
                let sum = over_w[0] + over_w[1];
                let vertex = Vertex::sum(&ends, over_w.map(|weight| weight / sum));
                let depth = (1.0 - t) * ends[0].depth() + t * ends[1].depth();
                let uv_per_px = (ends[1].uv - ends[0].uv) / length.length();
                self.put([place.x as usize, place.y as usize], depth, || {
                    shade(&Sample {
                        vertex,
                        uv_per_px: [uv_per_px; 2],
                        edge_px: 0.0,
                        upright: DVec3::ZERO,
                        front: true,
                    })
                });
            }
            center += 1.0;
        }
    }

    /// Draws a square of `side` pixels around a point, over everything.
    pub(super) fn square(&mut self, clip: DVec4, side: f64, color: DVec3) {
        if clip.w <= 0.0 || clip.z.abs() > clip.w {
            return;
        }
        let middle = self.window(clip);
        // OpenGL drops a point whose centre is outside the picture.
        if !(middle.cmpge(DVec2::ZERO).all() && middle.cmple(self.size.as_dvec2()).all()) {
            return;
        }
        let low = (middle - side / 2.0 - 0.5).ceil().max(DVec2::ZERO);
        let high = (middle + side / 2.0 - 0.5).ceil().min(self.size.as_dvec2());
        for y in low.y as usize..high.y as usize {
            for x in low.x as usize..high.x as usize {
                let place = y * self.size.x as usize + x;
                self.colors[place] = color.extend(1.0);
                self.pixels[place] = Pixel::ControlPoint;
            }
        }
    }
}

/// Whether a pixel at barycentric `weight` from the edge `a`–`b` is inside, or on an edge that belongs to its
/// triangle: a left edge, or a horizontal edge at the top (y points down, corners turn clockwise).
pub(super) fn owns(weight: f64, a: DVec2, b: DVec2) -> bool {
    let edge = b - a;
    weight > 0.0 || (weight == 0.0 && (edge.y < 0.0 || (edge.y == 0.0 && edge.x > 0.0)))
}

/// The part of a triangle in front of the near plane, z ≥ −w: three or four corners, or none.
fn clipped_to_near(corners: &[Vertex; 3]) -> Vec<Vertex> {
    let inside = |vertex: &Vertex| vertex.clip.z + vertex.clip.w;
    let mut polygon = Vec::with_capacity(4);
    for i in 0..3 {
        let (from, to) = (corners[i], corners[(i + 1) % 3]);
        let (a, b) = (inside(&from), inside(&to));
        if a > 0.0 {
            polygon.push(from);
        }
        if (a > 0.0) != (b > 0.0) {
            let t = a / (a - b);
            polygon.push(Vertex::sum(&[from, to], [1.0 - t, t]));
        }
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vertex(x: f64, y: f64, w: f64) -> Vertex {
        // Window coordinates of a picture of 8×8 pixels, y downwards.
        let ndc = DVec3::new(x / 4.0 - 1.0, 1.0 - y / 4.0, 0.0);
        Vertex::new((ndc * w).extend(w), DVec3::ZERO, DVec3::Z, DVec2::new(x, y))
    }

    fn fragment(sample: &Sample) -> Fragment {
        Fragment {
            surface: 0,
            patch: 0,
            uv: sample.vertex.uv(),
            uv_per_px: sample.uv_per_px,
            position: sample.vertex.position(),
            depth: sample.vertex.depth(),
            edge_px: sample.edge_px,
            front: sample.front,
        }
    }

    fn drawn(sample: &Sample) -> (Option<DVec3>, Fragment) {
        (Some(DVec3::ONE), fragment(sample))
    }

    #[test]
    fn two_triangles_of_a_square_share_no_pixel_and_miss_none() {
        // The diagonal passes through pixel centres.
        let corners =
            [(1.0, 1.0), (6.0, 1.0), (6.0, 6.0), (1.0, 6.0)].map(|(x, y)| vertex(x, y, 1.0));
        let mut counts = [0; 64];
        for triangle in [[0, 1, 2], [0, 2, 3], [3, 2, 1], [3, 1, 0]] {
            let mut raster = Raster::new(UVec2::splat(8), [0.0; 4]);
            raster.triangle(triangle.map(|i| corners[i]), &mut drawn);
            for (count, pixel) in counts.iter_mut().zip(&raster.pixels) {
                *count += i32::from(*pixel != Pixel::Background);
            }
        }
        for (i, count) in counts.iter().enumerate() {
            let inside = (1..6).contains(&(i % 8)) && (1..6).contains(&(i / 8));
            assert_eq!(*count, if inside { 2 } else { 0 }, "pixel {i}");
        }
    }

    #[test]
    fn values_are_perspective_correct() {
        let mut raster = Raster::new(UVec2::splat(8), [0.0; 4]);
        let corners = [vertex(0.0, 0.0, 1.0), vertex(8.0, 0.0, 3.0), vertex(0.0, 8.0, 1.0)];
        raster.triangle(corners, &mut drawn);
        let Pixel::Surface(fragment) = raster.pixels[2 * 8 + 3] else {
            panic!("the pixel is inside")
        };
        // Weights ½ᵢ/wᵢ normalised, at (3.5, 2.5).
        let linear = [1.0 - 6.0 / 8.0, 3.5 / 8.0, 2.5 / 8.0];
        let sum = linear[0] + linear[1] / 3.0 + linear[2];
        let expected = DVec2::new(8.0 * linear[1] / 3.0, 8.0 * linear[2]) / sum;
        assert!(fragment.uv.distance(expected) < 1e-12 && !fragment.front);
        // The nearest edge is x + y = 8.
        assert!((fragment.edge_px - 2.0 / 2f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_is_behind_the_near_plane_is_cut_off() {
        let [a, b] = [vertex(1.0, 1.0, 1.0), vertex(6.0, 1.0, 1.0)];
        let mut behind = vertex(3.0, 6.0, 1.0);
        behind.clip.z = -3.0;
        let polygon = clipped_to_near(&[a, b, behind]);
        assert_eq!(polygon.len(), 4);
        assert!(polygon.iter().all(|v| v.clip.z + v.clip.w > -1e-12));
        assert!(clipped_to_near(&[behind, behind, behind]).is_empty());
    }

    #[test]
    fn nearer_wins_and_cut_fragments_leave_no_depth() {
        let at = |z: f64| {
            [(0.0, 0.0), (8.0, 0.0), (0.0, 8.0)].map(|(x, y)| {
                let mut v = vertex(x, y, 1.0);
                v.clip.z = z;
                v
            })
        };
        let mut raster = Raster::new(UVec2::splat(8), [0.0; 4]);
        raster.triangle(at(-0.5), &mut |sample| (None, fragment(sample)));
        assert!(matches!(raster.pixels[0], Pixel::Hole(_)));
        raster.triangle(at(0.5), &mut drawn);
        raster.triangle(at(0.7), &mut |_| panic!("hidden"));
        let Pixel::Surface(fragment) = raster.pixels[0] else { panic!("the pixel is inside") };
        assert!((fragment.depth - 0.5).abs() < 1e-12);
    }

    #[test]
    fn lines_have_a_pixel_a_step_and_squares_their_side() {
        let mut raster = Raster::new(UVec2::splat(8), [0.0; 4]);
        raster.line([vertex(0.0, 1.0, 1.0), vertex(8.0, 5.0, 1.0)], &mut drawn);
        let drawn = raster.pixels.iter().filter(|pixel| **pixel != Pixel::Background).count();
        assert_eq!(drawn, 8);
        raster.square(vertex(4.0, 4.0, 1.0).clip, 3.0, DVec3::Z);
        let blue = raster.pixels.iter().filter(|pixel| **pixel == Pixel::ControlPoint).count();
        assert_eq!(blue, 9);
    }
}
