//! The handle of an OpenGL context.

use std::any::Any;
use std::ops::Deref;
use std::rc::Rc;
use std::sync::Arc;

use glow::HasContext;

/// The handle of an OpenGL context. Every object created in the context holds a clone of it.
///
/// The handle is not `Send`, and neither is anything that holds it. A context of `Headless` lives
/// until its last handle is dropped.
///
/// ```compile_fail
/// fn is_sent<T: Send>() {}
/// is_sent::<freeform_surface::Renderer>();
/// ```
#[derive(Clone)]
pub struct Gl {
    functions: Arc<glow::Context>,
    /// Keeps the context alive; `None` if the caller does.
    _owner: Option<Rc<dyn Any>>,
}

impl Gl {
    /// The handle of a context that the caller owns.
    ///
    /// # Safety
    /// The context must be current on the calling thread now, and whenever the handle, or anything
    /// created with it, is used or dropped.
    #[must_use]
    pub unsafe fn new(functions: impl Into<Arc<glow::Context>>) -> Self {
        Self { functions: functions.into(), _owner: None }
    }

    /// The handle of a context that lives as long as `owner`, which the handle keeps alive.
    #[cfg(feature = "headless")]
    pub(crate) fn owned(functions: glow::Context, owner: Rc<dyn Any>) -> Self {
        Self { functions: functions.into(), _owner: Some(owner) }
    }

    /// Waits until the driver has finished all calls.
    #[allow(unsafe_code, reason = "calls of OpenGL are unsafe in glow")]
    pub fn finish(&self) {
        // SAFETY: the context is current (see `new`).
        unsafe { self.functions.finish() }
    }

    /// The OpenGL functions in the type that other crates, such as egui's painter, take.
    #[must_use]
    pub const fn functions(&self) -> &Arc<glow::Context> {
        &self.functions
    }
}

impl Deref for Gl {
    type Target = glow::Context;

    fn deref(&self) -> &glow::Context {
        &self.functions
    }
}

impl std::fmt::Debug for Gl {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gl").finish_non_exhaustive()
    }
}
