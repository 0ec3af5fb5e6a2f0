//! The thesis' listings 14 to 17 as a program: make a surface, place it, pull its control points,
//! cut a circle, then a loop of Bézier curves, and draw.
//!
//! `cargo run --release --example listing16` writes `listing16.png` and `listing17.png`.

use std::rc::Rc;

use freeform_surface::{
    Frame, FreeFormSurface, Light, Offscreen, RenderSettings, Scene, Texture, load_texture,
};
use glam::{DMat4, dvec2, dvec3};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut offscreen = Offscreen::new(1000, 600)?;
    offscreen.target().bind();
    let renderer = offscreen.renderer_mut();

    // Listings 14 and 15.
    let mut freeform = FreeFormSurface::new(renderer)?;
    let bricks = load_texture(
        concat!(env!("CARGO_MANIFEST_DIR"), "/resources/textures/brick.png").as_ref(),
    )?;
    freeform.set_texture(Rc::new(Texture::new(renderer.gl(), "bricks", &bricks)?));

    // Listing 16. The camera is the one that frames the scene of the same listing.
    let size = (1000, 600);
    let camera = Scene::listing16().projection(size.0, size.1);
    let settings = RenderSettings { light: Light::Thesis, ..RenderSettings::default() };
    let frame = Frame::new(camera, size, settings);
    freeform.set_model_matrix(DMat4::from_translation(dvec3(0.0, 1.0, 0.0)))?;
    freeform.set_specific_control_point(dvec3(-0.17, 0.5, 0.17), 5)?;
    freeform.set_specific_control_point(dvec3(0.17, 0.5, 0.17), 6)?;
    freeform.set_specific_control_point(dvec3(-0.17, 0.5, -0.17), 9)?;
    freeform.set_specific_control_point(dvec3(0.17, 0.5, -0.17), 10)?;
    freeform.enable_circular_trimming();
    freeform.circular_trimming(0.2, dvec2(0.5, 0.5))?;
    renderer.clear(frame.settings.background);
    let _ = freeform.render(renderer, &frame)?;
    freeform.disable_circular_trimming();
    offscreen.target().read().save("listing16.png")?;

    // Listing 17: clockwise from the left, the two ends on one row.
    let [left, top, right, bottom] =
        [dvec2(0.2, 0.5), dvec2(0.5, 1.38), dvec2(0.8, 0.5), dvec2(0.5, -0.38)];
    freeform.set_bezier_curve_trimming(left, top, right, bottom)?;
    let renderer = offscreen.renderer_mut();
    renderer.clear(frame.settings.background);
    let _ = freeform.render(renderer, &frame)?;
    offscreen.target().read().save("listing17.png")?;
    println!("wrote listing16.png and listing17.png");
    Ok(())
}
