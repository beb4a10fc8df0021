//! Buffers in pages: a buffer that is larger than one binding, or one allocation, lies in several Vulkan buffers of the same size, and
//! shaders reach them by their addresses. A buffer that fits has one page, and can be bound like any other, too.

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::allocation::allocate;
use super::context::Context;
use super::error::GpuResult;
use super::info::DeviceInfo;

/// Bytes of an element of a buffer in pages, as `PAGED_READS` in `shaders/include/tables.glsl` declares it.
pub const PAGED_ELEMENT: u64 = 16;

/// Most pages of a buffer. The build gives shaders an equal constant.
pub const MOST_PAGES: u64 = include!("../shader_build/most_pages.txt");

/// The Vulkan buffers that hold a buffer's bytes. They have one size, except the last one, which may be shorter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Extent {
    buffers: Vec<vk::Buffer>,
    /// Bytes of each.
    page: u64,
}

/// A part of a copy that lies in one buffer on either side.
struct Stretch {
    from: vk::Buffer,
    to: vk::Buffer,
    copy: vk::BufferCopy,
}

impl Extent {
    /// An extent without buffers, in pages of so many bytes; `u64::MAX` for a single page.
    pub(crate) fn in_pages(page: u64) -> Self {
        let buffers = Vec::new();
        Self { buffers, page }
    }

    /// The extent of a buffer in one stretch.
    pub(crate) fn whole(buffer: vk::Buffer) -> Self {
        let buffers = vec![buffer];
        let page = u64::MAX;
        Self { buffers, page }
    }

    pub(crate) fn add(&mut self, buffer: vk::Buffer) {
        self.buffers.push(buffer);
    }

    pub(crate) fn first(&self) -> vk::Buffer {
        self.buffers[0]
    }

    pub(crate) fn is_whole(&self) -> bool {
        self.buffers.len() == 1
    }

    pub(crate) fn buffers(&self) -> &[vk::Buffer] {
        &self.buffers
    }

    /// Records that all of it is filled with a 32-bit value.
    ///
    /// # Safety
    /// `cmd` is being recorded, outside of a pass; the buffers live until it has finished, and have a multiple of 4 bytes.
    pub(crate) unsafe fn fill(&self, device: &ash::Device, cmd: vk::CommandBuffer, value: u32) {
        for &page in &self.buffers {
            // SAFETY: the caller's.
            unsafe { device.cmd_fill_buffer(cmd, page, 0, vk::WHOLE_SIZE, value) };
        }
    }

    /// The buffer that a byte lies in, the offset in it, and the number of bytes from there on.
    fn find(&self, at: u64) -> (vk::Buffer, u64, u64) {
        let offset = at % self.page;
        let buffer = self.buffers[(at / self.page) as usize];
        (buffer, offset, self.page - offset)
    }
}

/// Records a copy of so many bytes, from a byte of one buffer to a byte of another.
///
/// # Safety
/// `cmd` is being recorded, outside of a pass; the buffers live until it has finished, and the bytes lie in them.
pub(crate) unsafe fn copy_bytes(
    device: &ash::Device,
    cmd: vk::CommandBuffer,
    from: (&Extent, u64),
    to: (&Extent, u64),
    size: u64,
) {
    for Stretch { from, to, copy } in stretches(from, to, size) {
        // SAFETY: the caller's.
        unsafe { device.cmd_copy_buffer(cmd, from, to, &[copy]) };
    }
}

/// Cuts a copy of so many bytes where either side has a new page.
fn stretches(
    (from, from_at): (&Extent, u64),
    (to, to_at): (&Extent, u64),
    size: u64,
) -> impl Iterator<Item = Stretch> {
    let mut done = 0;
    std::iter::from_fn(move || {
        if done == size {
            return None;
        }
        let (source, src_offset, source_has) = from.find(from_at + done);
        let (target, dst_offset, target_has) = to.find(to_at + done);
        let size = (size - done).min(source_has).min(target_has);
        done += size;
        Some(Stretch {
            from: source,
            to: target,
            copy: vk::BufferCopy {
                src_offset,
                dst_offset,
                size,
            },
        })
    })
}

/// Bytes that a buffer in pages has at the most.
#[must_use]
pub fn most_in_pages(info: &DeviceInfo) -> u64 {
    MOST_PAGES * page_size(info)
}

/// Bytes of a page on a device: as many as a binding, a texel buffer of four words and an allocation hold, and a power of two.
pub(crate) fn page_size(info: &DeviceInfo) -> u64 {
    let most = (PAGED_ELEMENT * u64::from(info.max_texel_buffer_elements))
        .min(info.max_storage_buffer_range)
        .min(info.max_memory_allocation_size);
    1 << most.max(PAGED_ELEMENT).ilog2()
}

/// The address table for shaders: log2 of a page's elements, the mask of an element's number within its page, and the address of
/// each page.
pub(crate) fn address_table(
    ctx: &Context,
    name: &str,
    extent: &Extent,
) -> GpuResult<(vk::Buffer, Allocation)> {
    let elements = page_size(ctx.info()) / PAGED_ELEMENT;
    let mut words = vec![elements.ilog2(), (elements - 1) as u32];
    for &buffer in extent.buffers() {
        let info = vk::BufferDeviceAddressInfo::default().buffer(buffer);
        // SAFETY: the buffer is alive and was made for this; the feature is on where there are pages.
        let address = unsafe { ctx.device.raw.get_buffer_device_address(&info) };
        words.extend([address as u32, (address >> 32) as u32]);
    }
    words.resize(2 + 2 * MOST_PAGES as usize, 0);
    let bytes: &[u8] = bytemuck::cast_slice(&words);
    let mut table = allocate(
        ctx,
        name,
        bytes.len() as u64,
        vk::BufferUsageFlags::STORAGE_BUFFER,
        MemoryLocation::CpuToGpu,
    )?;
    let mapped = table.1.mapped_slice_mut().expect("the host writes it");
    mapped[..bytes.len()].copy_from_slice(bytes);
    ctx.device.set_name(table.0, &format!("{name}.pages"));
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ash::vk::Handle;

    #[test]
    fn copies_are_cut_where_either_side_has_a_new_page() {
        let extent = |first: u64, count: u64, page| Extent {
            buffers: (first..first + count).map(vk::Buffer::from_raw).collect(),
            page,
        };
        let (from, to) = (extent(1, 4, 100), Extent::whole(vk::Buffer::from_raw(9)));
        let cut = |from, to, size| -> Vec<(u64, u64, u64, u64, u64)> {
            stretches(from, to, size)
                .map(|Stretch { from, to, copy }| {
                    let (from, to) = (from.as_raw(), to.as_raw());
                    (from, copy.src_offset, to, copy.dst_offset, copy.size)
                })
                .collect()
        };
        let expected = [(1, 90, 9, 5, 10), (2, 0, 9, 15, 100), (3, 0, 9, 115, 1)];
        assert_eq!(cut((&from, 90), (&to, 5), 111), expected);
        let other = extent(5, 2, 64);
        let expected = [(1, 60, 5, 0, 40), (2, 0, 5, 40, 24), (2, 24, 6, 0, 36)];
        assert_eq!(cut((&from, 60), (&other, 0), 100), expected);
        assert_eq!(cut((&from, 60), (&other, 0), 0), []);
    }
}
