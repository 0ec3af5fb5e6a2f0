//! A still scene costs only its draw calls: nothing is built, uploaded or allocated again. The test is alone in
//! its process, because it counts the allocations of the whole process.
#![allow(unsafe_code, reason = "allocations and OpenGL's uploads are counted on their way")]

#[path = "harness/mod.rs"]
mod harness;

use std::alloc::{GlobalAlloc, Layout, System};
use std::ffi::{CString, c_void};
use std::sync::atomic::{AtomicPtr, AtomicUsize, Ordering::Relaxed};

use freeform_surface::inspect::TrimGrid;
use freeform_surface::{
    CreaseAngle, Edges, Frame, Framebuffer, Gl, Mesh, MeshModel, PreparedScene, Renderer, Scene,
    Segment, Smoothing, TessLevel, Tessellation, Tolerance, TrimLoop,
};
use glam::{DMat4, DVec2, DVec4, dvec2, dvec3};

use harness::{Checked, backends, load, root};

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

/// Counts what Rust allocates; the driver has its own allocator.
struct Counting;

// SAFETY: every call is handed on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Relaxed);
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

static UPLOADS: AtomicUsize = AtomicUsize::new(0);
/// The bytes of the uploads, and the number of uploads that allocate a buffer.
static BYTES: AtomicUsize = AtomicUsize::new(0);
static ROOMS: AtomicUsize = AtomicUsize::new(0);
static BUFFER_DATA: AtomicPtr<c_void> = AtomicPtr::new(std::ptr::null_mut());
static BUFFER_SUB_DATA: AtomicPtr<c_void> = AtomicPtr::new(std::ptr::null_mut());

type BufferData = unsafe extern "C" fn(u32, isize, *const c_void, u32);
type BufferSubData = unsafe extern "C" fn(u32, isize, isize, *const c_void);

unsafe extern "C" fn buffer_data(buffer: u32, size: isize, data: *const c_void, usage: u32) {
    UPLOADS.fetch_add(1, Relaxed);
    ROOMS.fetch_add(1, Relaxed);
    // SAFETY: the address is that of the driver's function of this type.
    unsafe {
        std::mem::transmute::<*mut c_void, BufferData>(BUFFER_DATA.load(Relaxed))(
            buffer, size, data, usage,
        );
    }
}

unsafe extern "C" fn buffer_sub_data(buffer: u32, at: isize, size: isize, data: *const c_void) {
    UPLOADS.fetch_add(1, Relaxed);
    BYTES.fetch_add(size as usize, Relaxed);
    // SAFETY: the address is that of the driver's function of this type.
    unsafe {
        std::mem::transmute::<*mut c_void, BufferSubData>(BUFFER_SUB_DATA.load(Relaxed))(
            buffer, at, size, data,
        );
    }
}

/// The context's functions, with those that upload replaced by functions that count.
fn counted(context: &Checked) -> Gl {
    let find = |name: &str| {
        let name = CString::new(name).unwrap();
        let address = context.proc_address(&name).cast_mut();
        match name.to_str() {
            Ok("glNamedBufferData") => {
                BUFFER_DATA.store(address, Relaxed);
                buffer_data as *const c_void
            }
            Ok("glNamedBufferSubData") => {
                BUFFER_SUB_DATA.store(address, Relaxed);
                buffer_sub_data as *const c_void
            }
            _ => address.cast_const(),
        }
    };
    // SAFETY: the context and its functions are current; the context outlives the objects of the test.
    unsafe { Gl::new(glow::Context::from_loader_function(find)) }
}

/// A loop of four cubics.
fn hole(center: DVec2, radius: f64) -> TrimLoop {
    let corners = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)].map(|(x, y)| dvec2(x, y));
    let quarter = |i: usize| {
        let (from, to) = (corners[i], corners[(i + 1) % 4]);
        let points = [from, from + 0.55 * to, to + 0.55 * from, to];
        Segment::Cubic(points.map(|point| center + radius * point))
    };
    TrimLoop::new((0..4).map(quarter).collect()).unwrap()
}

#[test]
fn a_still_scene_of_a_thousand_trimmed_surfaces_and_a_mesh_builds_uploads_and_allocates_nothing() {
    let context = Checked::new(backends()[0]);
    let gl = counted(&context);
    let mut scene = Scene::listing16();
    scene.settings.tessellation = Tessellation::Level(TessLevel::new(4).unwrap());
    let surface = scene.surfaces.remove(0);
    for i in 0..1000 {
        let mut surface = surface.clone();
        let place = dvec3(f64::from(i % 40), 0.0, -f64::from(i / 40));
        surface.transform = DMat4::from_translation(place);
        let off = 0.0001 * f64::from(i);
        for center in [dvec2(0.3 + off, 0.3), dvec2(0.6, 0.6 + off)] {
            surface.trims.add_loop(hole(center, 0.1)).unwrap();
        }
        scene.surfaces.push(surface);
    }
    // A mesh too, whose triangles have levels of their own.
    let torus = Mesh::load_obj(&root().join("resources/meshes/torus.obj"), CreaseAngle::NONE);
    scene.meshes.push(MeshModel::new(torus.unwrap(), Smoothing::Pn));
    let target = Framebuffer::new(&gl, 64, 64).unwrap();
    let mut renderer = Renderer::new(&gl).unwrap();
    let mut prepared = PreparedScene::new(&renderer, &scene).unwrap();
    let frame = Frame::of(&scene, (64, 64));
    target.bind();
    let mut draw = |prepared: &mut PreparedScene| {
        let before = [&ALLOCATIONS, &UPLOADS].map(|count| count.load(Relaxed));
        let _ = prepared.draw(&mut renderer, &frame).unwrap();
        [ALLOCATIONS.load(Relaxed) - before[0], UPLOADS.load(Relaxed) - before[1]]
    };
    let [allocations, uploads] = draw(&mut prepared);
    // The uploads are the grids of all surfaces; the sub-patches of all surfaces and their matrices, with one
    // call that allocates memory for them; and the levels of the mesh.
    assert!(allocations > 10_000 && uploads == 1 + 3 + 1, "{allocations} {uploads}");
    // All sub-patches that trims may cut share a program, whichever surface they belong to.
    assert!(prepared.stats().draws < 100, "{}", prepared.stats().draws);
    for _ in 0..3 {
        assert_eq!(draw(&mut prepared), [0, 0]);
    }
    // One change uploads one surface's grid and its sub-patches.
    let changed = &mut prepared.surfaces_mut()[500];
    let mut trims = changed.surface().trims.clone();
    trims.add_loop(hole(dvec2(0.5, 0.2), 0.05)).unwrap();
    changed.set_trims(trims).unwrap();
    let [_, uploads] = draw(&mut prepared);
    assert_eq!(uploads, 2);
    assert_eq!(draw(&mut prepared), [0, 0]);
    // A dragged point uploads 16 bytes. At one level its patch is tessellated as before. No buffer is
    // allocated.
    let rooms = ROOMS.load(Relaxed);
    let mut point = scene.surfaces[7].control_points()[5];
    for _ in 0..20 {
        point.y += 0.01;
        let bytes = BYTES.load(Relaxed);
        prepared.surfaces_mut()[7].set_control_point(point, 5).unwrap();
        assert_eq!(draw(&mut prepared)[1], 0);
        assert_eq!(BYTES.load(Relaxed) - bytes, 16);
    }
    assert_eq!(ROOMS.load(Relaxed), rooms);
    // Within a tolerance, the point's patch may be tessellated anew, together with the adjacent patches. This
    // uploads 32 bytes for each of these patches, and nothing for the others.
    let mut teapot = load(&root().join("resources/scenes/gallery/teapot.toml"));
    teapot.settings.tessellation = Tessellation::Within(Tolerance::new(0.5).unwrap());
    let frame = Frame::of(&teapot, (64, 64));
    let mut pulled = PreparedScene::new(&renderer, &teapot).unwrap();
    let _ = pulled.draw(&mut renderer, &frame).unwrap();
    let mut max = 0;
    for (patch, points) in teapot.surfaces[0].control_points().chunks(16).enumerate() {
        for height in [0.3, 0.0] {
            let bytes = BYTES.load(Relaxed);
            let point = points[5] + height * DVec4::Y;
            pulled.surfaces_mut()[0].set_control_point(point, 16 * patch + 5).unwrap();
            let _ = pulled.draw(&mut renderer, &frame).unwrap();
            max = max.max(BYTES.load(Relaxed) - bytes);
        }
    }
    assert!((16 + 32..=16 + 5 * 32).contains(&max), "{max}");
    // Within a tolerance, the patch may be tessellated more finely than before. Still no buffer is allocated.
    let mut scene = Scene::listing16();
    scene.settings.tessellation = Tessellation::Within(Tolerance::new(0.1).unwrap());
    let mut pulled = PreparedScene::new(&renderer, &scene).unwrap();
    let frame = Frame::of(&scene, (64, 64));
    let mut triangles = |pulled: &mut PreparedScene| {
        let _ = pulled.draw(&mut renderer, &frame).unwrap();
        pulled.stats().triangles
    };
    let first = triangles(&mut pulled);
    let rooms = ROOMS.load(Relaxed);
    let mut point = scene.surfaces[0].control_points()[5];
    for _ in 0..20 {
        point.y += 0.6;
        pulled.surfaces_mut()[0].set_control_point(point, 5).unwrap();
        assert!(triangles(&mut pulled) > first);
    }
    assert!(triangles(&mut pulled) > 2 * first, "{first}");
    assert_eq!(ROOMS.load(Relaxed), rooms);
    // The strokes and lines along the edges of a CAD model are uploaded for a new view only.
    let mut model = load(&root().join("resources/models/bracket.ffm"));
    model.settings.edges = Some(Edges::default());
    let mut lined = PreparedScene::new(&renderer, &model).unwrap();
    let mut of_view = |lined: &mut PreparedScene, size: u32| {
        let before = [&ALLOCATIONS, &UPLOADS].map(|count| count.load(Relaxed));
        let _ = lined.draw(&mut renderer, &Frame::of(&model, (size, 64))).unwrap();
        [ALLOCATIONS.load(Relaxed) - before[0], UPLOADS.load(Relaxed) - before[1]]
    };
    let _ = of_view(&mut lined, 64);
    let [_, uploads] = of_view(&mut lined, 64);
    assert_eq!(uploads, 0);
    // Sub-patches, matrices, strokes, lines.
    let [_, uploads] = of_view(&mut lined, 60);
    assert!((3..=4).contains(&uploads), "{uploads}");
    let [_, uploads] = of_view(&mut lined, 60);
    assert_eq!(uploads, 0);
    assert!(TrimGrid::new(&prepared.surfaces_mut()[500].surface().trims).pieces().len() >= 12);
}
