//! Helpers that the tests share: pictures from the GPU, and comparisons that report the differences.
#![allow(dead_code, unreachable_pub, reason = "each crate of tests uses a part of it")]

pub mod meshes;
pub mod neighbours;
pub mod oracle;
pub mod patches;
#[cfg(feature = "cli")]
pub mod program;
pub mod stage;
pub mod trim_text;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock};

use freeform_surface::inspect::programs::Sources;
use freeform_surface::inspect::reference::{Picture, Pixel, TrimDecision};
use freeform_surface::{
    Backend, Frame, Framebuffer, Headless, Image, Method, PreparedScene, Renderer, Scene,
};
use glam::UVec2;

pub use stage::Stage;

/// The root of the project.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The scenes of the thesis' figures and of the report: names and files.
pub fn figures() -> Vec<(String, PathBuf)> {
    let thesis = (14..=34).map(|number| format!("thesis/fig{number}"));
    let report = ["textured", "wireframe"].map(|name| format!("report/{name}"));
    thesis
        .chain(report)
        .map(|name| {
            let path = root().join("resources/scenes").join(&name).with_extension("toml");
            (name.replace('/', "-"), path)
        })
        .collect()
}

pub fn load(path: &Path) -> Scene {
    Scene::load(path).unwrap_or_else(|error| panic!("{error}"))
}

/// The backends to test: those that `FREEFORM_TEST_BACKENDS` names, as `check.sh` and continuous integration
/// set it. Otherwise EGL, and OSMesa where it works; newer distributions do not contain OSMesa.
pub fn backends() -> Vec<Backend> {
    static BACKENDS: OnceLock<Vec<Backend>> = OnceLock::new();
    let find = || {
        if let Ok(names) = std::env::var("FREEFORM_TEST_BACKENDS") {
            return names.split(',').map(|name| name.parse().expect("a backend's name")).collect();
        }
        // On a thread of its own: a new context would replace the caller's current one.
        let probe = std::thread::spawn(|| Headless::new(Backend::Osmesa).map(drop));
        match probe.join().expect("a probe") {
            Ok(()) => vec![Backend::Egl, Backend::Osmesa],
            Err(error) => {
                eprintln!("OSMesa is left out: {error}");
                vec![Backend::Egl]
            }
        }
    };
    BACKENDS.get_or_init(find).clone()
}

/// A context that fails the test when the driver complained of anything.
pub struct Checked(Headless);

impl Checked {
    pub fn new(backend: Backend) -> Self {
        Self(Headless::new(backend).unwrap_or_else(|error| panic!("{error}")))
    }
}

impl std::ops::Deref for Checked {
    type Target = Headless;

    fn deref(&self) -> &Headless {
        &self.0
    }
}

impl Drop for Checked {
    fn drop(&mut self) {
        check_complaints(&self.0);
    }
}

/// Fails if the driver has complained of anything.
fn check_complaints(context: &Headless) {
    let errors = context.debug_log().take_errors();
    if !std::thread::panicking() {
        assert!(errors.is_empty(), "the driver complained: {errors:#?}");
    }
}

/// Renders a scene in a context of its own.
pub fn render(scene: &Scene, size: UVec2, backend: Backend) -> Image {
    render_with(scene, size, backend, Sources::default())
}

/// Renders a scene with other shaders.
pub fn render_with(scene: &Scene, size: UVec2, backend: Backend, sources: Sources) -> Image {
    Stage::with_sources(backend, size, sources).render(scene)
}

/// Draws a prepared scene into a target.
pub fn draw(
    scene: &Scene,
    prepared: &mut PreparedScene,
    renderer: &mut Renderer,
    target: &Framebuffer,
) {
    target.bind();
    let frame = Frame::of(scene, target.size());
    let _ = prepared.draw(renderer, &frame).unwrap_or_else(|error| panic!("{error}"));
}

/// The differences of two pictures, without the pixels that are left out.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Difference {
    /// Pixels with a channel off by more than the tolerance.
    pub wrong: usize,
    /// Pixels that were compared.
    pub compared: usize,
    /// The largest difference of a channel.
    pub max: u8,
    /// Pixels off by more than 0, 2, 4, 16 and 64.
    pub above: [usize; 5],
    /// The first wrong pixel.
    pub first: Option<(u32, u32)>,
}

/// Compares all four channels of two pictures of one size.
///
/// # Errors
/// Pictures of different sizes.
pub fn difference(
    expected: &Image,
    actual: &Image,
    left_out: &[bool],
    tolerance: u8,
) -> Result<Difference, String> {
    if expected.dimensions() != actual.dimensions() {
        let (a, b) = (expected.dimensions(), actual.dimensions());
        return Err(format!("sizes differ: expected {a:?}, actual {b:?}"));
    }
    let mut result = Difference::default();
    for (i, (x, y, pixel)) in expected.enumerate_pixels().enumerate() {
        if left_out.get(i).copied().unwrap_or(false) {
            continue;
        }
        let other = actual.get_pixel(x, y);
        let off = (0..4).map(|c| pixel.0[c].abs_diff(other.0[c])).max().unwrap_or(0);
        result.compared += 1;
        result.max = result.max.max(off);
        for (count, threshold) in result.above.iter_mut().zip([0, 2, 4, 16, 64]) {
            *count += usize::from(off > threshold);
        }
        if off > tolerance {
            result.wrong += 1;
            result.first.get_or_insert((x, y));
        }
    }
    Ok(result)
}

/// Fails, leaving expected, difference and actual side by side in `target/test-failures`.
pub fn assert_same(name: &str, expected: &Image, actual: &Image, left_out: &[bool], tolerance: u8) {
    let found = difference(expected, actual, left_out, tolerance);
    if matches!(&found, Ok(found) if found.wrong == 0 && found.compared > 0) {
        return;
    }
    let mut message = format!("{name}: tolerance {tolerance}, {found:?} (above 0, 2, 4, 16, 64)");
    match write_failure(name, expected, actual, left_out) {
        Ok(path) => {
            let _ = write!(message, "\nexpected | difference | actual: {}", path.display());
        }
        Err(error) => {
            let _ = write!(message, "\nthe pictures could not be written: {error}");
        }
    }
    panic!("{message}");
}

fn write_failure(
    name: &str,
    expected: &Image,
    actual: &Image,
    left_out: &[bool],
) -> Result<PathBuf, Box<dyn std::error::Error>> {
    let folder = root().join("target/test-failures");
    std::fs::create_dir_all(&folder)?;
    let (width, height) =
        (expected.width().max(actual.width()), expected.height().max(actual.height()));
    let mut sheet = Image::new(3 * width, height);
    image::imageops::replace(&mut sheet, expected, 0, 0);
    image::imageops::replace(&mut sheet, actual, 2 * i64::from(width), 0);
    if expected.dimensions() == actual.dimensions() {
        for (i, (x, y, pixel)) in expected.enumerate_pixels().enumerate() {
            let other = actual.get_pixel(x, y);
            let off = (0..4).map(|c| pixel.0[c].abs_diff(other.0[c])).max().unwrap_or(0);
            let grey = if left_out.get(i).copied().unwrap_or(false) { 60 } else { 0 };
            let shown = image::Rgba([off.saturating_mul(8), grey, grey, 255]);
            sheet.put_pixel(width + x, y, shown);
        }
    }
    let path = folder.join(format!("{name}.png"));
    sheet.save(&path)?;
    Ok(path)
}

/// Width of the band around edges in which the exact place of a sample decides, in pixels.
pub const BAND_PX: f64 = 1.5;

/// Leaves out wrong pixels that a speckle between pixels explains; returns their number.
pub fn excuse_speckles(
    scene: &Scene,
    picture: &Picture,
    actual: &Image,
    left_out: &mut [bool],
    tolerance: u8,
) -> usize {
    let decisions: Vec<TrimDecision<'_>> = scene
        .surfaces
        .iter()
        .map(|surface| {
            TrimDecision::new(&surface.trims, scene.settings.newton, Method::Thesis).unwrap()
        })
        .collect();
    let mut excused = 0;
    for (i, (expected, actual)) in picture.image.pixels().zip(actual.pixels()).enumerate() {
        let off = (0..4).map(|c| expected.0[c].abs_diff(actual.0[c])).max().unwrap_or(0);
        if left_out[i] || off <= tolerance {
            continue;
        }
        if let Pixel::Surface(fragment) | Pixel::Hole(fragment) = &picture.pixels[i]
            && !scene.surfaces[fragment.surface].trims.loops.is_empty()
            && decisions[fragment.surface].changes_near(fragment, BAND_PX)
        {
            left_out[i] = true;
            excused += 1;
        }
    }
    excused
}

/// The stored reference picture of that name. With `UPDATE_REFERENCES=1` it is written first.
pub fn stored_reference(name: &str, picture: &Image) -> Image {
    // Tests of both backends read files that one of the tests may be writing.
    static TURN: Mutex<()> = Mutex::new(());
    let _turn = TURN.lock();
    let path = root().join("tests/references").join(name).with_extension("png");
    if std::env::var_os("UPDATE_REFERENCES").is_some_and(|value| value == "1") {
        picture.save(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    }
    read_reference(&path)
}

/// Reads a reference; a missing one is a failure.
pub fn read_reference(path: &Path) -> Image {
    image::open(path)
        .unwrap_or_else(|error| {
            panic!(
                "{}: {error}; run the test with UPDATE_REFERENCES=1 and look at what it wrote",
                path.display()
            )
        })
        .into_rgba8()
}
