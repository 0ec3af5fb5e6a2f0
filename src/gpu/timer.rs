//! How long the driver's device works, by its own clock.

use std::time::Duration;

use glow::HasContext;

use super::Gl;
use super::create;
use crate::error::Result;

/// A clock of the device for what it is told between two moments. (Timestamps, because Mesa's software
/// driver mistakes its clock's reading for the time that elapsed.)
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
    /// A clock that stands.
    ///
    /// # Errors
    /// The driver has no query.
    pub fn new(gl: &Gl) -> Result<Self> {
        // SAFETY: the context is current (see the module); the queries are new and ours.
        let moments =
            unsafe { [create("timer", gl.create_query())?, create("timer", gl.create_query())?] };
        Ok(Self { gl: gl.clone(), moments })
    }

    /// Does something, waits for the device, and tells how long the device was at it.
    ///
    /// # Errors
    /// That of `work`.
    pub fn time<E>(&self, work: impl FnOnce() -> Result<(), E>) -> Result<Duration, E> {
        // SAFETY: the context is current (see the module); what is asked for was queried, and asking waits
        // for the answer.
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
