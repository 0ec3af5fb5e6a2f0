//! Times on the clock of the device that draws (GPU time).

use std::time::Duration;

use glow::HasContext;

use super::Gl;
use super::create;
use crate::error::Result;

/// Two timestamp queries, between which the device's time is measured. (Not a `GL_TIME_ELAPSED`
/// query: for that, Mesa's software driver returns the reading of its clock instead of a
/// difference.)
pub struct Timer {
    gl: Gl,
    moments: [glow::Query; 2],
}

impl std::fmt::Debug for Timer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Timer").field("moments", &self.moments).finish_non_exhaustive()
    }
}

impl Timer {
    /// Creates the queries.
    ///
    /// # Errors
    /// The driver cannot create a query.
    pub fn new(gl: &Gl) -> Result<Self> {
        // SAFETY: the context is current (see the module); the queries are new and ours.
        let moments =
            unsafe { [create("timer", gl.create_query())?, create("timer", gl.create_query())?] };
        Ok(Self { gl: gl.clone(), moments })
    }

    /// Runs `work`, waits for the device, and returns the time that the device took for it.
    ///
    /// # Errors
    /// The error of `work`.
    pub fn time<E>(&self, work: impl FnOnce() -> Result<(), E>) -> Result<Duration, E> {
        // SAFETY: the context is current (see the module); both queries were issued, and
        // reading their results waits for them.
        unsafe {
            self.gl.query_counter(self.moments[0], glow::TIMESTAMP);
            work()?;
            self.gl.query_counter(self.moments[1], glow::TIMESTAMP);
            let [start, end] = self
                .moments
                .map(|moment| self.gl.get_query_parameter_u64(moment, glow::QUERY_RESULT));
            Ok(Duration::from_nanos(end.saturating_sub(start)))
        }
    }
}

impl Drop for Timer {
    fn drop(&mut self) {
        for moment in self.moments {
            // SAFETY: the context is current (see the module); nothing else owns the query.
            unsafe { self.gl.delete_query(moment) }
        }
    }
}
