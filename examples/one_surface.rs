//! The smallest headless picture: a scene in, a PNG out.
//!
//! `cargo run --release --example one_surface` writes `one_surface.png`.

use freeform_surface::gpu::Framebuffer;
use freeform_surface::{Backend, Frame, Headless, PreparedScene, Renderer, Scene};

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
    let context = Headless::new(Backend::Auto)?;
    let target = Framebuffer::new(context.gl(), 800, 600)?;
    let mut renderer = Renderer::new(context.gl())?;
    let frame = Frame { projection: scene.projection(800, 600), settings: scene.settings };
    target.bind();
    let figures = PreparedScene::new(&renderer, &scene)?.draw(&mut renderer, &frame)?;
    target.read().save("one_surface.png")?;
    let (triangles, driver) = (figures.triangles, &context.info().renderer);
    println!("wrote one_surface.png: {triangles} triangles, drawn by {driver}");
    Ok(())
}
