//! Contexts from OSMesa, Mesa's off-screen library. It is loaded at run time, because few machines
//! have it, and it is not needed where EGL works.

use std::cell::UnsafeCell;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::sync::OnceLock;

use libloading::Library;

// The values of GL/osmesa.h.
const OSMESA_RGBA: c_int = 0x1908;
const OSMESA_FORMAT: c_int = 0x22;
const OSMESA_DEPTH_BITS: c_int = 0x30;
const OSMESA_PROFILE: c_int = 0x33;
const OSMESA_CORE_PROFILE: c_int = 0x34;
const OSMESA_CONTEXT_MAJOR_VERSION: c_int = 0x36;
const OSMESA_CONTEXT_MINOR_VERSION: c_int = 0x37;
const GL_UNSIGNED_BYTE: c_uint = 0x1401;

/// The names under which distributions install the library.
const NAMES: [&str; 3] = ["libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"];

type RawContext = *mut c_void;
type Proc = Option<unsafe extern "C" fn()>;

/// OSMesa's functions. The library stays loaded until the process ends, because all OpenGL function
/// pointers point into it.
struct Functions {
    create: unsafe extern "C" fn(*const c_int, RawContext) -> RawContext,
    destroy: unsafe extern "C" fn(RawContext),
    make_current: unsafe extern "C" fn(RawContext, *mut c_void, c_uint, c_int, c_int) -> u8,
    get_proc_address: unsafe extern "C" fn(*const c_char) -> Proc,
    _library: Library,
}

fn functions() -> Result<&'static Functions, String> {
    static FUNCTIONS: OnceLock<Result<Functions, String>> = OnceLock::new();
    FUNCTIONS.get_or_init(load).as_ref().map_err(Clone::clone)
}

fn load() -> Result<Functions, String> {
    let library = NAMES
        .iter()
        // SAFETY: Mesa's library has no initialiser that could conflict with this process.
        .find_map(|name| unsafe { Library::new(*name) }.ok())
        .ok_or_else(|| format!("OSMesa: none of {} is installed", NAMES.join(", ")))?;
    // SAFETY: the four signatures are those of GL/osmesa.h.
    unsafe {
        let missing = |error: libloading::Error| format!("OSMesa: {error}");
        Ok(Functions {
            create: *library.get(b"OSMesaCreateContextAttribs\0").map_err(missing)?,
            destroy: *library.get(b"OSMesaDestroyContext\0").map_err(missing)?,
            make_current: *library.get(b"OSMesaMakeCurrent\0").map_err(missing)?,
            get_proc_address: *library.get(b"OSMesaGetProcAddress\0").map_err(missing)?,
            _library: library,
        })
    }
}

/// A context, made current by [`Context::new`]. After it is dropped, no context is current.
pub(super) struct Context {
    functions: &'static Functions,
    raw: RawContext,
    /// The colour buffer, without which OSMesa makes no context current. It is the default
    /// framebuffer; pictures are drawn into framebuffer objects instead.
    pixel: Box<UnsafeCell<[u8; 4]>>,
}

impl Context {
    pub(super) fn new() -> Result<(Self, glow::Context), String> {
        let functions = functions()?;
        let attributes = [
            (OSMESA_FORMAT, OSMESA_RGBA),
            (OSMESA_DEPTH_BITS, 24),
            (OSMESA_PROFILE, OSMESA_CORE_PROFILE),
            (OSMESA_CONTEXT_MAJOR_VERSION, 4),
            (OSMESA_CONTEXT_MINOR_VERSION, 5),
        ];
        let mut list: Vec<c_int> =
            attributes.iter().flat_map(|(key, value)| [*key, *value]).collect();
        list.push(0);
        // SAFETY: the list consists of pairs of key and value, and ends with a 0.
        let raw = unsafe { (functions.create)(list.as_ptr(), std::ptr::null_mut()) };
        if raw.is_null() {
            return Err("OSMesa: it gives no OpenGL 4.5 core context".into());
        }
        let context = Self { functions, raw, pixel: Box::new(UnsafeCell::new([0; 4])) };
        context.make_current()?;
        // SAFETY: the context is current, so OSMesa returns its functions.
        let gl =
            unsafe { glow::Context::from_loader_function_cstr(|name| context.proc_address(name)) };
        Ok((context, gl))
    }

    pub(super) fn make_current(&self) -> Result<(), String> {
        let pixel = self.pixel.get().cast();
        // SAFETY: the buffer holds one RGBA pixel, lives as long as the context, and only
        // OSMesa accesses it.
        let made =
            unsafe { (self.functions.make_current)(self.raw, pixel, GL_UNSIGNED_BYTE, 1, 1) };
        if made == 0 {
            return Err("OSMesa: the context cannot be made current".into());
        }
        Ok(())
    }

    pub(super) fn proc_address(&self, name: &CStr) -> *const c_void {
        // SAFETY: the name ends in a 0 byte, as the library expects.
        unsafe { (self.functions.get_proc_address)(name.as_ptr()) }
            .map_or(std::ptr::null(), |function| function as *const c_void)
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        // SAFETY: the context came from this library and is destroyed once. Making
        // a null context current first releases the current one.
        unsafe {
            (self.functions.make_current)(std::ptr::null_mut(), std::ptr::null_mut(), 0, 0, 0);
            (self.functions.destroy)(self.raw);
        }
    }
}
