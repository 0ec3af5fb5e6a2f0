//! OpenGL contexts without a display: for the program, for tests and for servers.
#![allow(unsafe_code, reason = "contexts are made through EGL and OSMesa")]

mod egl;
mod offscreen;
mod osmesa;

use std::ffi::{CStr, c_void};
use std::fmt;
use std::rc::Rc;
use std::str::FromStr;

pub use offscreen::Offscreen;

use crate::error::{Error, Result};
use crate::gpu::{DebugLog, DriverInfo, Gl, check_context};

/// Where a headless context comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backend {
    /// EGL, or OSMesa if EGL gives no context.
    #[default]
    Auto,
    /// An EGL device; hardware devices are tried before software ones.
    Egl,
    /// OSMesa, Mesa's off-screen library. It always draws on the CPU.
    Osmesa,
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Auto => "auto",
            Self::Egl => "egl",
            Self::Osmesa => "osmesa",
        })
    }
}

impl FromStr for Backend {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        match text {
            "auto" => Ok(Self::Auto),
            "egl" => Ok(Self::Egl),
            "osmesa" => Ok(Self::Osmesa),
            _ => Err(Error::invalid("backend", text, "auto, egl or osmesa")),
        }
    }
}

/// Keeps a context alive; dropping it destroys the context.
enum Owner {
    Egl(egl::Context),
    Osmesa(osmesa::Context),
}

/// An OpenGL 4.5 core context. [`Headless::new`] makes it current on the calling thread.
///
/// A thread with several contexts switches between them with [`Headless::make_current`]. An object
/// must be used and dropped while its own context is current. Dropping a `Headless` makes its
/// context current. The context is destroyed with its last object, and then no context is current.
pub struct Headless {
    gl: Gl,
    debug_log: DebugLog,
    backend: Backend,
    info: DriverInfo,
    owner: Rc<Owner>,
}

impl fmt::Debug for Headless {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Headless")
            .field("backend", &self.backend)
            .field("info", &self.info)
            .finish_non_exhaustive()
    }
}

impl Headless {
    /// Creates a context and makes it current on the calling thread.
    ///
    /// # Errors
    /// No driver gives an OpenGL 4.5 core context. The message names the packages to install.
    pub fn new(backend: Backend) -> Result<Self> {
        let tried = match backend {
            Backend::Egl => Self::egl(),
            Backend::Osmesa => Self::osmesa(),
            Backend::Auto => Self::egl().or_else(|egl| {
                log::debug!("no context through EGL: {egl}");
                Self::osmesa().map_err(|osmesa| format!("{egl}; {osmesa}"))
            }),
        };
        tried.map_err(|reason| {
            Error::Context(format!(
                "no OpenGL 4.5 context without a display ({reason}); install a driver: on Debian and \
                 Ubuntu, apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri (EGL) or libosmesa6 (OSMesa)"
            ))
        })
    }

    fn egl() -> Result<Self, String> {
        let (context, gl) = egl::Context::new()?;
        Self::finish(gl, Backend::Egl, Owner::Egl(context))
    }

    fn osmesa() -> Result<Self, String> {
        let (context, gl) = osmesa::Context::new()?;
        Self::finish(gl, Backend::Osmesa, Owner::Osmesa(context))
    }

    fn finish(mut gl: glow::Context, backend: Backend, owner: Owner) -> Result<Self, String> {
        check_context(&gl).map_err(|error| error.to_string())?;
        let debug_log = DebugLog::install(&mut gl);
        let info = DriverInfo::of(&gl);
        let owner = Rc::new(owner);
        let gl = Gl::owned(gl, owner.clone());
        Ok(Self { gl, debug_log, backend, info, owner })
    }

    /// The handle of the context, for creating objects and calling OpenGL functions.
    #[must_use]
    pub const fn gl(&self) -> &Gl {
        &self.gl
    }

    /// Makes the context current on the calling thread.
    ///
    /// # Errors
    /// The driver's reason for refusing.
    pub fn make_current(&self) -> Result<()> {
        match &*self.owner {
            Owner::Egl(context) => context.make_current(),
            Owner::Osmesa(context) => context.make_current(),
        }
        .map_err(Error::Context)
    }

    /// The address of an OpenGL function, or null; for functions that glow lacks.
    #[must_use]
    pub fn proc_address(&self, name: &CStr) -> *const c_void {
        match &*self.owner {
            Owner::Egl(context) => context.proc_address(name),
            Owner::Osmesa(context) => context.proc_address(name),
        }
    }

    /// The backend that gave the context, never [`Backend::Auto`].
    #[must_use]
    pub const fn backend(&self) -> Backend {
        self.backend
    }

    /// The driver's names and limits.
    #[must_use]
    pub const fn info(&self) -> &DriverInfo {
        &self.info
    }

    /// The driver's debug messages.
    #[must_use]
    pub const fn debug_log(&self) -> &DebugLog {
        &self.debug_log
    }
}

impl Drop for Headless {
    fn drop(&mut self) {
        // Objects of this context that are dropped right after it are then deleted in this context,
        // and not in another one that was current.
        if let Err(error) = self.make_current() {
            log::debug!("a context is dropped without being current: {error}");
        }
    }
}
