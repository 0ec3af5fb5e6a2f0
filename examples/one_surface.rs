//! The smallest headless picture: a scene in, a PNG out.
//!
//! `cargo run --release --example one_surface` writes `one_surface.png`.

use freeform_surface::{Offscreen, Scene};

const SCENE: &str = r#"
[[surface]]
control_points = [
    [-1, 0, 1], [-0.3, 0, 1], [0.3, 0, 1], [1, 0, 1],
    [-1, 0, 0.3], [-0.3, 2, 0.3], [0.3, -1, 0.3], [1, 0, 0.3],
    [-1, 0, -0.3], [-0.3, -1, -0.3], [0.3, 2, -0.3], [1, 0, -0.3],
    [-1, 0, -1], [-0.3, 0, -1], [0.3, 0, -1], [1, 0, -1],
]
color = [0.4, 0.6, 0.8]
[[surface.trim]]
ellipse = { center = [0.5, 0.5], radii = [0.3, 0.15] }
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scene = Scene::from_toml(SCENE, "one_surface.toml".as_ref())?;
    let mut offscreen = Offscreen::new(800, 600)?;
    let (picture, stats) = offscreen.render(&scene)?;
    picture.save("one_surface.png")?;
    let driver = &offscreen.context().info().renderer;
    println!("wrote one_surface.png: {} triangles, drawn by {driver}", stats.triangles);
    Ok(())
}
