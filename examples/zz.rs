use freeform_surface::*;
use freeform_surface::gpu::*;
use glam::*;
fn main(){
    let a: Vec<String>=std::env::args().collect();
    let lines = a[1]=="lines"; let side: usize=a[2].parse().unwrap(); let level: i64=a[3].parse().unwrap();
    let mut scene=Scene::from_toml("surface = [{ control_points = \"default\" }]","x".as_ref()).unwrap();
    scene.settings.wireframe=lines; scene.settings.level=TessLevel::new(level).unwrap();
    let mut pts=vec![];
    for p in 0..side*side { let (x,z)=((p%side) as f64,(p/side) as f64); for i in 0..16 { pts.push(DVec4::new((x+(i%4) as f64/3.)/side as f64-0.5,0.,0.5-(z+(i/4) as f64/3.)/side as f64,1.0)); } }
    scene.surfaces=vec![Surface::new(Degree::Cubic,pts).unwrap()];
    let h=Headless::new(Backend::Egl).unwrap();
    let t=Framebuffer::new(h.gl(),1024,1024).unwrap();
    let mut r=Renderer::new(h.gl()).unwrap();
    let mut p=PreparedScene::new(&r,&scene).unwrap();
    t.bind();
    let f=Frame{projection:scene.projection(1024,1024),settings:scene.settings};
    let mut v=vec![];
    for _ in 0..60 { let s=std::time::Instant::now(); p.draw(&mut r,&f).unwrap(); finish(h.gl()); v.push(s.elapsed()); }
    v.sort(); println!("{a:?} {:?}", v[30]);
}
