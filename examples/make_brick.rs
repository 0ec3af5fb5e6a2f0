//! Makes `resources/textures/brick.png`, the texture of the thesis' figures: `cargo run --release --example
//! make_brick`.

use image::{Rgb, RgbImage};

const SIZE: u32 = 256;
const COURSES: f64 = 8.0;
const BRICKS_PER_COURSE: f64 = 4.0;
/// Half the joint's width and the softness of its edge, in courses. With soft edges, the picture depends little
/// on the texture's level of detail, which drivers may choose slightly differently.
const JOINT: f64 = 0.03;
const SOFT: f64 = 0.09;

/// A pseudo-random number in 0 … 1 for two integers (the mixing steps of Murmur3's finaliser).
fn hash(x: i64, y: i64) -> f64 {
    let mut bits = (x as u32).wrapping_mul(0x9e37_79b1) ^ (y as u32).wrapping_mul(0x85eb_ca77);
    bits = (bits ^ (bits >> 16)).wrapping_mul(0x85eb_ca6b);
    bits = (bits ^ (bits >> 13)).wrapping_mul(0xc2b2_ae35);
    f64::from(bits ^ (bits >> 16)) / f64::from(u32::MAX)
}

fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Hashes on a grid with smooth interpolation; a period of `period` cells makes the noise tile.
fn noise(x: f64, y: f64, period: i64) -> f64 {
    let cell = |x: f64, y: f64| hash((x as i64).rem_euclid(period), (y as i64).rem_euclid(period));
    let (left, top) = (x.floor(), y.floor());
    let (u, v) = (smoothstep(0.0, 1.0, x - left), smoothstep(0.0, 1.0, y - top));
    let upper = cell(left, top) * (1.0 - u) + cell(left + 1.0, top) * u;
    let lower = cell(left, top + 1.0) * (1.0 - u) + cell(left + 1.0, top + 1.0) * u;
    upper * (1.0 - v) + lower * v
}

fn color(x: f64, y: f64) -> [f64; 3] {
    let course = (y * COURSES).floor();
    let along = x * BRICKS_PER_COURSE + 0.5 * (course as i64).rem_euclid(2) as f64;
    let brick = along.floor().rem_euclid(BRICKS_PER_COURSE);
    // Distance from the nearest joint, in courses; a brick is twice as long as high.
    let across = 0.5 - (y * COURSES - course - 0.5).abs();
    let lengthwise = (0.5 - (along - along.floor() - 0.5).abs()) * COURSES / BRICKS_PER_COURSE;
    let clay = smoothstep(JOINT, JOINT + SOFT, across.min(lengthwise));

    let tint = hash(brick as i64, course as i64);
    let grain =
        0.85 + 0.3 * (0.6 * noise(x * 32.0, y * 32.0, 32) + 0.4 * noise(x * 64.0, y * 64.0, 64));
    let red = [0.55 + 0.2 * tint, 0.24 + 0.12 * tint, 0.17 + 0.08 * tint];
    let mortar = [0.68, 0.63, 0.57];
    std::array::from_fn(|i| (mortar[i] * (1.0 - clay) + red[i] * clay) * grain)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let picture = RgbImage::from_fn(SIZE, SIZE, |x, y| {
        let place = |i: u32| (f64::from(i) + 0.5) / f64::from(SIZE);
        Rgb(color(place(x), place(y))
            .map(|channel| (channel.clamp(0.0, 1.0) * 255.0).round() as u8))
    });
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/resources/textures/brick.png");
    picture.save(path)?;
    println!("{path}");
    Ok(())
}
