//! The thesis' listings 14 to 17 as a program: make a surface, place it, pull its control points,
//! cut a circle, then a loop of Bézier curves, and draw.
//!
//! `cargo run --release --example listing16` writes `listing16.png` and `listing17.png`.

use std::rc::Rc;

use freeform_surface::gpu::{Framebuffer, Texture};
use freeform_surface::{
    Backend, Frame, FreeFormSurface, Headless, RenderSettings, Renderer, Scene, load_texture,
};
use glam::{DMat4, dvec2, dvec3};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let context = Headless::new(Backend::Auto)?;
    let target = Framebuffer::new(context.gl(), 1000, 600)?;
    let mut renderer = Renderer::new(context.gl())?;

    // Listings 14 and 15.
    let mut freeform = FreeFormSurface::new(&renderer)?;
    let bricks = load_texture(
        concat!(env!("CARGO_MANIFEST_DIR"), "/resources/textures/brick.png").as_ref(),
    )?;
    freeform.set_texture(Rc::new(Texture::new(context.gl(), "bricks", &bricks)?));

    // Listing 16. The camera is the one that frames the scene of the same listing.
    let frame = Frame {
        projection: Scene::listing16().projection(1000, 600),
        settings: RenderSettings::default(),
    };
    freeform.set_model_matrix(DMat4::from_translation(dvec3(0.0, 1.0, 0.0)))?;
    freeform.set_specific_control_point(dvec3(-0.17, 0.5, 0.17), 5)?;
    freeform.set_specific_control_point(dvec3(0.17, 0.5, 0.17), 6)?;
    freeform.set_specific_control_point(dvec3(-0.17, 0.5, -0.17), 9)?;
    freeform.set_specific_control_point(dvec3(0.17, 0.5, -0.17), 10)?;
    freeform.enable_circular_trimming();
    freeform.circular_trimming(0.2, dvec2(0.5, 0.5))?;
    target.bind();
    renderer.clear(frame.settings.background);
    let _ = freeform.render(&mut renderer, &frame)?;
    freeform.disable_circular_trimming();
    target.read().save("listing16.png")?;

    // Listing 17: clockwise from the left, the two ends on one row.
    let [left, top, right, bottom] =
        [dvec2(0.2, 0.5), dvec2(0.5, 1.38), dvec2(0.8, 0.5), dvec2(0.5, -0.38)];
    freeform.set_bezier_curve_trimming(left, top, right, bottom)?;
    renderer.clear(frame.settings.background);
    let _ = freeform.render(&mut renderer, &frame)?;
    target.read().save("listing17.png")?;
    println!("wrote listing16.png and listing17.png");
    Ok(())
}
