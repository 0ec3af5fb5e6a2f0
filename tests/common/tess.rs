//! What the tests of the tessellation share: frames that are measured, and patches by chance.

use freeform_surface::inspect::DrawnVertex;
use freeform_surface::inspect::measure::{Measurement, measure};
use freeform_surface::inspect::programs::Sources;
use freeform_surface::inspect::reference::coverage;
use freeform_surface::{
    Aovs, Degree, FloatTarget, Frame, Framebuffer, Image, Method, Normals, PreparedScene,
    RenderSettings, Renderer, Scene, Surface, TessLevel, Tessellation, Tolerance, ViewProjection,
};
use glam::{DVec3, DVec4, UVec2};

use super::{Checked, backends};

/// A context with a target that scenes are drawn in, one after the other.
pub struct Stage {
    target: Framebuffer,
    numbers: FloatTarget,
    pub renderer: Renderer,
    pub size: UVec2,
    _context: Checked,
}

impl Stage {
    pub fn new(size: UVec2) -> Self {
        Self::with_sources(size, Sources::default())
    }

    pub fn with_sources(size: UVec2, sources: Sources) -> Self {
        let context = Checked::new(backends()[0]);
        let renderer = Renderer::with_sources(context.gl(), sources).unwrap();
        Self {
            target: Framebuffer::new(context.gl(), size.x, size.y).unwrap(),
            numbers: FloatTarget::for_aovs(&renderer, (size.x, size.y)).unwrap(),
            renderer,
            size,
            _context: context,
        }
    }

    pub fn prepared(&self, scene: &Scene) -> PreparedScene {
        PreparedScene::new(&self.renderer, scene).unwrap()
    }

    /// A frame of the scene's own camera or of the one that frames it.
    pub fn frame(&self, scene: &Scene) -> Frame {
        Frame::new(self.projection(scene), self.size, scene.settings)
    }

    pub fn projection(&self, scene: &Scene) -> ViewProjection {
        scene.projection(self.size.x, self.size.y)
    }

    pub fn aspect(&self) -> f64 {
        f64::from(self.size.x) / f64::from(self.size.y)
    }

    pub fn aovs(&mut self, prepared: &mut PreparedScene, frame: &Frame) -> Aovs {
        prepared.aovs(&mut self.renderer, &self.numbers, frame).unwrap()
    }

    pub fn triangles(&mut self, prepared: &mut PreparedScene, frame: &Frame) -> Vec<DrawnVertex> {
        self.target.bind();
        prepared.triangles(&mut self.renderer, frame).unwrap()
    }

    /// How far a frame is off.
    pub fn measured(
        &mut self,
        scene: &Scene,
        prepared: &mut PreparedScene,
        frame: &Frame,
    ) -> Measurement {
        let aovs = self.aovs(prepared, frame);
        let method = frame.settings.method;
        let reference = coverage(scene, &frame.camera, self.size, method).unwrap();
        measure(scene, &frame.camera, &aovs, &reference)
    }

    pub fn picture(&mut self, prepared: &mut PreparedScene, frame: &Frame) -> Image {
        self.target.bind();
        let _ = prepared.draw(&mut self.renderer, frame).unwrap();
        self.target.read()
    }
}

/// The exact method within so many pixels, with normals of every pixel, before nothing.
pub fn within(pixels: f64) -> RenderSettings {
    RenderSettings {
        background: [0.0; 4],
        method: Method::Exact,
        tessellation: Tessellation::Within(Tolerance::new(pixels).unwrap()),
        normals: Normals::Pixel,
        ..RenderSettings::default()
    }
}

/// Whether everything is tested that there is, however long it takes.
pub fn is_long() -> bool {
    std::env::var_os("FREEFORM_TEST_LONG").is_some()
}

/// The same at one level.
pub fn at_level(level: i64) -> RenderSettings {
    let tessellation = Tessellation::Level(TessLevel::new(level).unwrap());
    RenderSettings { tessellation, ..within(0.5) }
}

pub fn scene_of(surfaces: Vec<Surface>) -> Scene {
    let settings = within(0.5);
    Scene { up: DVec3::Z, settings, surfaces, ..Scene::default() }
}

/// A bicubic field of `side` × `side` patches over squares of size 1: control points at every third,
/// their heights from a function of column and row.
pub fn field(side: usize, height: impl Fn(usize, usize) -> f64) -> Vec<DVec4> {
    let mut points = Vec::with_capacity(16 * side * side);
    for patch in 0..side * side {
        for i in 0..16 {
            let (column, row) = (3 * (patch % side) + i % 4, 3 * (patch / side) + i / 4);
            let (x, y) = (column as f64 / 3.0, row as f64 / 3.0);
            points.push(DVec4::new(x, y, height(column, row), 1.0));
        }
    }
    points
}

/// The net of a patch turned by quarters, and mirrored from 4 on.
pub fn turned(degree: Degree, points: &[DVec4], turn: usize) -> Vec<DVec4> {
    let n = degree.side();
    (0..n * n)
        .map(|i| {
            let (mut column, mut row) = (i % n, i / n);
            for _ in 0..turn % 4 {
                (column, row) = (n - 1 - row, column);
            }
            if turn >= 4 {
                (column, row) = (row, column);
            }
            points[row * n + column]
        })
        .collect()
}

/// Pixels of a picture that show something, if its background is transparent.
pub fn count_drawn(picture: &Image) -> usize {
    picture.pixels().filter(|pixel| pixel.0[3] > 0).count()
}

/// SplitMix64.
pub struct Random(pub u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// `low` … `high`.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.next() >> 11) as f64 / (1_u64 << 53) as f64)
    }
}
