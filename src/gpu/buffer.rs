//! Typed, named buffers.

use std::marker::PhantomData;
use std::sync::Arc;

use bytemuck::Pod;

use super::buffer_core::{BufferCore, Domain};
use super::context::Context;
use super::error::GpuResult;

/// `len` elements of `T` on the device.
///
/// Device buffers start with whatever the memory held; see [`Buffer::zeroed`] and [`Buffer::from_slice`].
pub struct Buffer<T> {
    core: Arc<BufferCore>,
    element: PhantomData<T>,
}

/// The elements of a mapped buffer, which no frame can write meanwhile.
pub struct Mapped<'a, T> {
    elements: &'a [T],
    core: &'a BufferCore,
}

impl<T> std::ops::Deref for Mapped<'_, T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        self.elements
    }
}

impl<T> Drop for Mapped<'_, T> {
    fn drop(&mut self) {
        self.core.lock().readers -= 1;
    }
}

/// A buffer of any element type, as barriers and arguments take it.
pub trait AnyBuffer {
    /// The part without the element type.
    fn core(&self) -> &BufferCore;
}

impl<T: Pod> Buffer<T> {
    /// Allocates `len` elements; the name appears in errors, in the checker's messages and in capture tools.
    ///
    /// # Errors
    /// More than one binding or one allocation of this device can hold, or no memory.
    pub fn new(ctx: &Arc<Context>, name: &str, len: usize, domain: Domain) -> GpuResult<Self> {
        const {
            assert!(
                align_of::<T>() <= 16,
                "mapped memory is aligned to 16 bytes"
            )
        };
        const {
            assert!(
                size_of::<T>() > 0 && size_of::<T>().is_multiple_of(4),
                "elements have a multiple of 4 bytes"
            )
        };
        Ok(Self {
            core: BufferCore::new(ctx, name, len, size_of::<T>() as u64, domain)?,
            element: PhantomData,
        })
    }

    /// The mapped elements of an `Upload` or `Readback` buffer.
    ///
    /// # Panics
    /// If a frame that uses the buffer has not finished.
    #[must_use]
    pub fn as_slice(&self) -> Mapped<'_, T> {
        let core = &self.core;
        let data = core.mapped("download").cast();
        core.lock_for_host("read").readers += 1;
        // SAFETY: the memory holds `len` elements of plain data and lives as long as `self`. Nothing writes it: no frame
        // that uses the buffer is unfinished, recording one that writes it panics while `readers` counts this, and
        // writing on the host needs the buffer exclusively.
        let elements = unsafe { std::slice::from_raw_parts(data, self.len()) };
        Mapped { elements, core }
    }

    /// As [`Buffer::as_slice`], to write.
    ///
    /// # Panics
    /// If a frame that uses the buffer has not finished.
    #[must_use]
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        let core = &self.core;
        core.lock_for_host("write").has_content = true;
        // SAFETY: as in `as_slice`; and there is no other reference to the buffer, since texel views are of device buffers only.
        unsafe { std::slice::from_raw_parts_mut(core.mapped("upload").cast(), self.len()) }
    }
}

impl<T> Buffer<T> {
    /// Elements.
    #[must_use]
    pub fn len(&self) -> usize {
        (self.core.size / size_of::<T>() as u64) as usize
    }

    /// Has it no elements?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.core.size == 0
    }

    /// Bytes that the elements take.
    #[must_use]
    pub fn size_in_bytes(&self) -> u64 {
        self.core.size
    }

    /// The name it was made with.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.core.name
    }

    /// Panics unless so many elements from `start` on lie in it.
    pub(crate) fn assert_fits(&self, start: usize, count: usize) {
        let fits = start
            .checked_add(count)
            .is_some_and(|end| end <= self.len());
        assert!(
            fits,
            "`{}` has {} elements: {count} from {start} on do not fit",
            self.name(),
            self.len()
        );
    }

    /// Panics unless the range lies in it.
    pub(crate) fn assert_has(&self, range: &std::ops::Range<usize>) {
        let fits = range.start <= range.end && range.end <= self.len();
        assert!(
            fits,
            "`{}` has {} elements, not {range:?}",
            self.name(),
            self.len()
        );
    }

    /// Does an unfinished frame use it?
    #[must_use]
    pub fn is_in_use(&self) -> bool {
        self.core.is_in_use()
    }
}

impl<T: Pod> Buffer<T> {
    /// A view of this device memory with elements of another type, such as four floats as one vector, so that a kernel
    /// can use wide loads. Costs nothing.
    ///
    /// # Panics
    /// If the buffer is mapped, or its size is no multiple of the other type's.
    #[must_use]
    pub fn cast<U: Pod>(&self) -> Buffer<U> {
        let core = &self.core;
        assert!(
            core.domain.is_on_device() && core.size.is_multiple_of(size_of::<U>() as u64),
            "`{}` has {} bytes and cannot be seen as elements of {}",
            core.name,
            core.size,
            size_of::<U>()
        );
        Buffer {
            core: Arc::clone(core),
            element: PhantomData,
        }
    }
}

impl<T> AnyBuffer for Buffer<T> {
    fn core(&self) -> &BufferCore {
        &self.core
    }
}

impl<T> std::fmt::Debug for Buffer<T> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "Buffer({:?}, {} x {})",
            self.core.name,
            self.len(),
            std::any::type_name::<T>()
        )
    }
}
