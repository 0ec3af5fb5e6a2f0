//! Buffer objects that hold plain values, such as control points, vertices and trims.

use bytemuck::Pod;
use glow::HasContext;

use super::{Gl, check_memory, create, size_i32};
use crate::error::{Error, Result};

/// A buffer object that holds plain values.
pub struct Buffer {
    gl: Gl,
    raw: glow::Buffer,
    bytes: usize,
}

impl std::fmt::Debug for Buffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Buffer").field("raw", &self.raw).field("bytes", &self.bytes).finish()
    }
}

impl Buffer {
    /// A buffer that holds `values`, which must not be empty.
    ///
    /// # Errors
    /// The driver is out of memory, or the values take 2 GiB or more.
    pub fn new<T: Pod>(gl: &Gl, label: &str, values: &[T]) -> Result<Self> {
        let data: &[u8] = bytemuck::cast_slice(values);
        size_i32(label, data.len())?;
        // SAFETY: the context is current (see the module); the buffer is new and ours.
        unsafe {
            let raw = create(label, gl.create_named_buffer())?;
            // From here on, `drop` deletes it.
            let buffer = Self { gl: gl.clone(), raw, bytes: data.len() };
            gl.named_buffer_data_u8_slice(raw, data, glow::DYNAMIC_DRAW);
            check_memory(gl, label, data.len() as u64)?;
            gl.object_label(glow::BUFFER, raw.0.get(), Some(label));
            Ok(buffer)
        }
    }

    /// A buffer of `count` values, which an iterator yields; `count` must not be 0. Values are
    /// uploaded in blocks, so that no second copy of all values is in memory.
    ///
    /// # Errors
    /// As [`Buffer::new`].
    pub(crate) fn of_values<T: Pod>(
        gl: &Gl,
        label: &str,
        count: usize,
        mut values: impl Iterator<Item = T>,
    ) -> Result<Self> {
        const AT_ONCE: usize = 1 << 14;
        let bytes = count.saturating_mul(size_of::<T>());
        let size = size_i32(label, bytes)?;
        // SAFETY: the context is current (see the module); the buffer is new and ours.
        let buffer = unsafe {
            let raw = create(label, gl.create_named_buffer())?;
            let buffer = Self { gl: gl.clone(), raw, bytes };
            gl.named_buffer_data_size(raw, size, glow::DYNAMIC_DRAW);
            check_memory(gl, label, bytes as u64)?;
            gl.object_label(glow::BUFFER, raw.0.get(), Some(label));
            buffer
        };
        let mut some = Vec::with_capacity(AT_ONCE.min(count));
        for first in (0..count).step_by(AT_ONCE) {
            some.clear();
            some.extend(values.by_ref().take(AT_ONCE));
            buffer.write(first, &some);
        }
        Ok(buffer)
    }

    /// A buffer for [`Buffer::bind_storage`]; `values` must not be empty.
    ///
    /// # Errors
    /// As [`Buffer::new`], or more bytes than the driver allows in a shader storage block.
    pub fn for_storage<T: Pod>(gl: &Gl, label: &str, values: &[T]) -> Result<Self> {
        // SAFETY: the context is current (see the module).
        let max = unsafe { gl.get_parameter_i64(glow::MAX_SHADER_STORAGE_BLOCK_SIZE) };
        let bytes = size_of_val(values);
        if i64::try_from(bytes).map_or(true, |bytes| bytes > max) {
            return Err(Error::Driver {
                what: label.to_owned(),
                reason: format!("{bytes} bytes; its storage buffers hold at most {max}"),
            });
        }
        Self::new(gl, label, values)
    }

    /// The size in bytes.
    #[must_use]
    pub const fn bytes(&self) -> usize {
        self.bytes
    }

    /// Overwrites the values from index `first` on.
    ///
    /// # Panics
    /// If the values reach beyond the end of the buffer.
    pub fn write<T: Pod>(&self, first: usize, values: &[T]) {
        let offset = first * size_of::<T>();
        let data: &[u8] = bytemuck::cast_slice(values);
        assert!(offset + data.len() <= self.bytes, "written beyond the end of a buffer");
        // SAFETY: the context is current (see the module); the range was just checked, and the
        // buffer's size fits an i32, as was checked when it was created.
        unsafe { self.gl.named_buffer_sub_data_u8_slice(self.raw, offset as i32, data) }
    }

    /// Makes this the shader storage buffer of a binding point.
    pub fn bind_storage(&self, binding: u32) {
        // SAFETY: the context is current (see the module); the buffer lives as long as `self`.
        unsafe {
            self.gl.bind_buffer_base(glow::SHADER_STORAGE_BUFFER, binding, Some(self.raw));
        }
    }

    /// Makes this the buffer that transform feedback writes to.
    pub fn bind_feedback(&self) {
        // SAFETY: the context is current (see the module); the buffer lives as long as `self`.
        unsafe { self.gl.bind_buffer_base(glow::TRANSFORM_FEEDBACK_BUFFER, 0, Some(self.raw)) }
    }

    /// Reads the first `count` values.
    ///
    /// # Panics
    /// If the buffer holds fewer.
    #[must_use]
    pub fn read<T: Pod>(&self, count: usize) -> Vec<T> {
        assert!(count * size_of::<T>() <= self.bytes, "read beyond the end of a buffer");
        let mut values = vec![T::zeroed(); count];
        // SAFETY: the context is current (see the module); the range was just checked.
        unsafe {
            // glow 0.17 lacks `glGetNamedBufferSubData`.
            self.gl.bind_buffer(glow::COPY_READ_BUFFER, Some(self.raw));
            let bytes = bytemuck::cast_slice_mut(&mut values);
            self.gl.get_buffer_sub_data(glow::COPY_READ_BUFFER, 0, bytes);
            self.gl.bind_buffer(glow::COPY_READ_BUFFER, None);
        }
        values
    }

    pub(super) const fn raw(&self) -> glow::Buffer {
        self.raw
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: the context is current (see the module); nothing else owns the buffer.
        unsafe { self.gl.delete_buffer(self.raw) }
    }
}
