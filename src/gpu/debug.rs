//! The driver's debug messages: they are logged, and errors are also recorded.

use std::sync::{Arc, Mutex, PoisonError};

use glow::HasContext;

/// The debug messages of a context. Errors and undefined behaviour are recorded; all messages are
/// logged.
#[derive(Debug, Clone, Default)]
pub struct DebugLog {
    errors: Arc<Mutex<Vec<String>>>,
}

impl DebugLog {
    /// Installs the message callback on a context whose functions nobody else holds yet.
    #[must_use]
    pub fn install(gl: &mut glow::Context) -> Self {
        let log = Self::default();
        let errors = Arc::clone(&log.errors);
        // SAFETY: the context is current (see the module); the callback owns what it touches.
        unsafe {
            gl.enable(glow::DEBUG_OUTPUT);
            gl.enable(glow::DEBUG_OUTPUT_SYNCHRONOUS);
            gl.debug_message_callback(move |_source, kind, _id, severity, message| {
                let message = message.trim();
                if matches!(kind, glow::DEBUG_TYPE_ERROR | glow::DEBUG_TYPE_UNDEFINED_BEHAVIOR) {
                    log::error!("OpenGL: {message}");
                    errors.lock().unwrap_or_else(PoisonError::into_inner).push(message.to_owned());
                } else if severity == glow::DEBUG_SEVERITY_HIGH {
                    log::warn!("OpenGL: {message}");
                } else {
                    log::debug!("OpenGL: {message}");
                }
            });
        }
        log
    }

    /// Runs `work` without debug messages, so that they take no time and are not recorded. Clears
    /// the OpenGL errors of `work`, and leaves debug output switched on.
    pub fn unheard<T>(gl: &glow::Context, work: impl FnOnce() -> T) -> T {
        // SAFETY: the context is current (see the module).
        unsafe {
            gl.disable(glow::DEBUG_OUTPUT);
            let done = work();
            // A lost context may report errors without end.
            for _ in 0..8 {
                if gl.get_error() == glow::NO_ERROR {
                    break;
                }
            }
            gl.enable(glow::DEBUG_OUTPUT);
            done
        }
    }

    /// Removes and returns the recorded errors.
    #[must_use]
    pub fn take_errors(&self) -> Vec<String> {
        std::mem::take(&mut *self.errors.lock().unwrap_or_else(PoisonError::into_inner))
    }
}
