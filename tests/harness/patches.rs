//! Settings and surfaces for the tests of the tessellation.

use freeform_surface::{
    Degree, Image, Method, Normals, RenderSettings, Scene, Surface, TessLevel, Tessellation,
    Tolerance,
};
use glam::{DVec3, DVec4};

/// The exact method within a tolerance in pixels, with normals per pixel and a transparent background.
pub fn within(pixels: f64) -> RenderSettings {
    RenderSettings {
        background: [0.0; 4],
        method: Method::Exact,
        tessellation: Tessellation::Within(Tolerance::new(pixels).unwrap()),
        normals: Normals::Pixel,
        ..RenderSettings::default()
    }
}

/// Whether the long tests run too, which leave out nothing.
pub fn is_long() -> bool {
    std::env::var_os("FREEFORM_TEST_LONG").is_some()
}

/// The same settings with one level.
pub fn at_level(level: i64) -> RenderSettings {
    let tessellation = Tessellation::Level(TessLevel::new(level).unwrap());
    RenderSettings { tessellation, ..within(0.5) }
}

pub fn scene_of(surfaces: Vec<Surface>) -> Scene {
    let settings = within(0.5);
    Scene { up: DVec3::Z, settings, surfaces, ..Scene::default() }
}

/// A bicubic field of `side` × `side` patches over squares of size 1. Its control points are a third apart, and
/// their heights are a function of column and row.
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

/// A patch rotated by quarter turns, and mirrored from turn 4 on: its degree and its net.
pub fn turned(degree: Degree, points: &[DVec4], turn: usize) -> (Degree, Vec<DVec4>) {
    let is_swapped = (turn % 2 == 1) != (turn >= 4);
    let result = if is_swapped { Degree::new(degree.v(), degree.u()).unwrap() } else { degree };
    let net = (0..degree.points()).map(|i| {
        let (mut columns, mut rows) = (result.columns(), result.rows());
        let (mut column, mut row) = (i % columns, i / columns);
        for _ in 0..turn % 4 {
            (column, row) = (rows - 1 - row, column);
            (columns, rows) = (rows, columns);
        }
        if turn >= 4 {
            (column, row) = (row, column);
        }
        points[row * degree.columns() + column]
    });
    (result, net.collect())
}

/// Pixels of a picture that show something, if its background is transparent.
pub fn count_drawn(picture: &Image) -> usize {
    picture.pixels().filter(|pixel| pixel.0[3] > 0).count()
}
