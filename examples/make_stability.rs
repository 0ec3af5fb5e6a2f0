//! Makes the two stability scenes that are too long to write by hand: 71 × 71 loops of two cubics spread over
//! the domain, and the same loops inside one cell of the grid, within a large loop.
//!
//! `cargo run --release --example make_stability` writes them to `resources/scenes/stability`.

use std::fmt::Write as _;
use std::path::Path;

/// Loops along a side.
const SIDE: u32 = 71;

const SCENE: &str = r#"
[camera]                      # the patch fills a square picture, one to one
eye = [0.0, 1.0, 0.0]
target = [0.0, 0.0, 0.0]
up = [0.0, 0.0, -1.0]
orthographic_height = 1.0

[render]
method = "exact"
level = 1
background = [0.0, 0.0, 0.0, 0.0]

[[surface]]
control_points = "default"
color = [0.9, 0.6, 0.2]
shading = "flat"
"#;

/// A number with at most eight decimals, as short as SVG allows.
fn short(x: f64) -> String {
    let digits = format!("{x:.8}");
    let digits = digits.trim_end_matches('0').trim_end_matches('.');
    match digits.strip_prefix("-0.") {
        Some(rest) => format!("-.{rest}"),
        None => digits.strip_prefix("0.").map_or_else(|| digits.into(), |rest| format!(".{rest}")),
    }
}

/// A lens of two cubics: from its left end over the upper curve and back below.
fn lens(u: f64, v: f64, half_width: f64, half_height: f64) -> String {
    let n = |x: f64| short(x);
    let (w, h) = (half_width, half_height * 4.0 / 3.0);
    format!(
        "M{} {}c{} {} {} {} {} 0s{} {} {} 0z",
        n(u - w),
        n(v),
        n(0.4 * w),
        n(h),
        n(1.6 * w),
        n(h),
        n(2.0 * w),
        n(-1.6 * w),
        n(-h),
        n(-2.0 * w),
    )
}

/// A trim of lenses over a square of the domain that starts at (`min`, `min`).
fn crowd(min: f64, size: f64) -> String {
    let step = size / f64::from(SIDE);
    let mut trim = String::from("\n[[surface.trim]]\npath = \"\"\"\n");
    for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
        let center = |i: u32| min + (f64::from(i) + 0.5) * step;
        let height = 0.3 * (1.0 + 0.3 * f64::from(column + 2 * row).sin());
        let lens = lens(center(column), center(row), 0.4 * step, height * step);
        let _ = writeln!(trim, "{lens}");
    }
    trim.push_str("\"\"\"\n");
    trim
}

fn main() -> std::io::Result<()> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("resources/scenes/stability");
    let spread = format!(
        "# 10,082 cubics: 71 × 71 loops over the whole domain. Made by examples/make_stability.rs.\n\
         {SCENE}{}",
        crowd(0.0, 1.0)
    );
    std::fs::write(folder.join("trim-10000-segments.toml"), spread)?;
    let around = "\n[[surface.trim]]\nloop = [\n    \
                  [[0.02, 0.5], [0.116, 1.14], [0.884, 1.14], [0.98, 0.5]],\n    \
                  [[0.98, 0.5], [0.884, -0.14], [0.116, -0.14], [0.02, 0.5]],\n]\n";
    let crowded = format!(
        "# 10,082 cubics in one cell of the grid, which has 256 × 256 for so many, and a large loop around\n\
         # them. Made by examples/make_stability.rs.\n{SCENE}{around}{}",
        crowd(0.5197, 0.0035)
    );
    std::fs::write(folder.join("trim-10000-in-one-cell.toml"), crowded)
}
