fn main() {
    use freeform_surface::*;
    let path = std::env::args().nth(1).unwrap();
    let backend: Backend = std::env::args().nth(3).unwrap_or("egl".into()).parse().unwrap();
    let scene = Scene::load(std::path::Path::new(&path)).unwrap();
    let t = std::time::Instant::now();
    let h = Headless::new(backend).unwrap();
    eprintln!("{:?} {:?}", h, t.elapsed());
    let fb = gpu::Framebuffer::new(h.gl(), 1000, 600).unwrap();
    let mut r = Renderer::new(h.gl()).unwrap();
    let mut p = PreparedScene::new(&r, &scene).unwrap();
    fb.bind();
    for _ in 0..3 {
        let t = std::time::Instant::now();
        p.draw(&mut r, &Frame { projection: scene.projection(1000, 600), settings: scene.settings }).unwrap();
        gpu::finish(h.gl());
        eprintln!("{:?}", t.elapsed());
    }
    fb.read().save(std::env::args().nth(2).unwrap()).unwrap();
    eprintln!("{:?}", h.debug_log().take_errors());
}
