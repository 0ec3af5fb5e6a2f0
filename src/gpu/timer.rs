//! How long the driver's device works, by its own clock.

use std::sync::Arc;
use std::time::Duration;

use glow::HasContext;

use super::create;
use crate::Result;

/// A clock of the device for what it is told between two moments.
pub struct Timer {
    gl: Arc<glow::Context>,
    raw: glow::Query,
}

impl std::fmt::Debug for Timer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Timer").field("raw", &self.raw).finish_non_exhaustive()
    }
}

impl Timer {
    /// A clock that stands.
    ///
    /// # Errors
    /// The driver has no query.
    pub fn new(gl: &Arc<glow::Context>) -> Result<Self> {
        // SAFETY: the context is current (see the module); the query is new and ours.
        let raw = unsafe { create("timer", gl.create_query())? };
        Ok(Self { gl: Arc::clone(gl), raw })
    }

    /// Does something, waits for the device, and tells how long the device was at it. No other timer
    /// may run meanwhile.
    ///
    /// # Errors
    /// That of `work`.
    pub fn time(&self, work: impl FnOnce() -> Result<()>) -> Result<Duration> {
        // SAFETY: the context is current (see the module); the query is ended before it is asked, and
        // asking waits for the answer.
        unsafe {
            self.gl.begin_query(glow::TIME_ELAPSED, self.raw);
            let done = work();
            self.gl.end_query(glow::TIME_ELAPSED);
            done?;
            let nanoseconds = self.gl.get_query_parameter_u64(self.raw, glow::QUERY_RESULT);
            Ok(Duration::from_nanos(nanoseconds))
        }
    }
}

impl Drop for Timer {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); nothing else owns the query.
        unsafe { self.gl.delete_query(self.raw) }
    }
}
