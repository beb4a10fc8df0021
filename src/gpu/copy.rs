//! Copies, fills and updates inside a frame.

use ash::vk;
use bytemuck::Pod;

use super::access::Access;
use super::buffer::{AnyBuffer, Buffer};
use super::buffer_core::BufferCore;
use super::image::{Format, Image, ImageState};
use super::pages::copy_bytes;
use super::recorder::Recorder;
use super::sampled::Sampled;
use super::timer::SpanKind;
use super::waits::Touch;

impl Recorder {
    /// Copies all of `source` to the start of `target`.
    ///
    /// # Panics
    /// If `target` is shorter, or both are one.
    pub fn copy<T: Pod>(&mut self, source: &Buffer<T>, target: &Buffer<T>) {
        self.copy_range(source, 0..source.len(), target, 0);
    }

    /// Copies a range of elements of `source` to `target`, from the element `start` on.
    ///
    /// # Panics
    /// If the range does not lie in both, or both are one.
    pub fn copy_range<T: Pod>(
        &mut self,
        source: &Buffer<T>,
        range: std::ops::Range<usize>,
        target: &Buffer<T>,
        start: usize,
    ) {
        if self.skips() {
            return;
        }
        source.assert_has(&range);
        target.assert_fits(start, range.len());
        let (from, to) = (source.core(), target.core());
        assert!(
            from.raw() != to.raw(),
            "`{}` cannot be copied to itself",
            source.name()
        );
        let element = size_of::<T>() as u64;
        let (source, target) = (range.start as u64 * element, start as u64 * element);
        let size = range.len() as u64 * element;
        if size == 0 {
            return;
        }
        self.touch("copy", &[reads(from), writes(to)]);
        self.work("copy", SpanKind::Copy, |rec| {
            let (from, to) = ((from.extent(), source), (to.extent(), target));
            // SAFETY: both buffers are alive and freed only after this frame; the range lies in both.
            unsafe { copy_bytes(rec.device(), rec.raw(), from, to, size) };
        });
    }

    /// Fills a buffer with a 32-bit value.
    pub fn fill(&mut self, buffer: &dyn AnyBuffer, value: u32) {
        if self.skips() {
            return;
        }
        let core = buffer.core();
        if core.size_in_bytes() == 0 {
            return;
        }
        self.touch("fill", &[writes(core)]);
        self.work("fill", SpanKind::Copy, |rec| {
            // SAFETY: the buffer is alive and freed only after this frame; its size is a multiple of 4.
            unsafe { core.extent().fill(rec.device(), rec.raw(), value) };
        });
    }

    /// Writes all of `data` to the start of a buffer, as [`update`](Self::update) does, in as many parts as needed.
    ///
    /// # Panics
    /// If they do not fit the buffer.
    pub fn update_long<T: Pod>(&mut self, buffer: &Buffer<T>, data: &[T]) {
        let most = 65_536 / size_of::<T>();
        let bytes = size_of_val(data);
        assert!(
            bytes <= buffer.size_in_bytes() as usize,
            "`{}` is too short",
            buffer.name()
        );
        for (i, part) in data.chunks(most).enumerate() {
            self.update(buffer, i * most, part);
        }
    }

    /// Writes a few elements, which travel in the command buffer, from the element `start` on.
    ///
    /// # Panics
    /// If they do not fit the buffer or take more than 65,536 bytes.
    pub fn update<T: Pod>(&mut self, buffer: &Buffer<T>, start: usize, data: &[T]) {
        if self.skips() {
            return;
        }
        buffer.assert_fits(start, data.len());
        assert!(
            size_of_val(data) <= 65_536,
            "{} bytes do not fit a command buffer; use an upload buffer",
            size_of_val(data)
        );
        if data.is_empty() {
            return;
        }
        let core = buffer.core();
        self.touch("update", &[writes(core)]);
        self.work("update", SpanKind::Copy, |rec| {
            let offset = (start * size_of::<T>()) as u64;
            // SAFETY: the buffer is alive and freed only after this frame; elements have a multiple of 4 bytes.
            unsafe {
                rec.device().cmd_update_buffer(
                    rec.raw(),
                    core.whole(),
                    offset,
                    bytemuck::cast_slice(data),
                )
            };
        });
    }

    /// Copies the bytes of `source` to `target`, with its upper left corner at `place`; pixels beyond the edge are cut off, and the rest of
    /// `target` is kept.
    ///
    /// # Panics
    /// If the formats do not match, either has several samples, or both are one.
    pub fn copy_image_to(&mut self, source: &Image, target: &Image, place: [u32; 2]) {
        self.copy_regions(source, target, || {
            let [column, row] = [0, 1].map(|axis| Span {
                from: 0,
                to: place[axis],
                count: source.size()[axis],
            });
            vec![(column, row)]
        });
    }

    /// Copies the middle of `source` over `size` pixels of `target` from `place` on. Where it is narrower or lower, its outermost
    /// columns or rows are repeated.
    ///
    /// # Panics
    /// As [`copy_image_to`](Self::copy_image_to).
    pub fn copy_image_over(
        &mut self,
        source: &Image,
        target: &Image,
        place: [u32; 2],
        size: [u32; 2],
    ) {
        self.copy_regions(source, target, || {
            let [columns, rows] =
                [0, 1].map(|axis| middle_over(source.size()[axis], place[axis], size[axis]));
            let of_row = |row: Span| columns.iter().map(move |column| (*column, row));
            rows.into_iter().flat_map(of_row).collect()
        });
    }

    /// Copies parts of an image: columns and rows of each. What lies beyond the target's edge is cut off.
    fn copy_regions(
        &mut self,
        source: &Image,
        target: &Image,
        parts: impl FnOnce() -> Vec<(Span, Span)>,
    ) {
        if self.skips() {
            return;
        }
        assert!(
            source.format().matches(target.format())
                && source.samples() == 1
                && target.samples() == 1,
            "`{}` ({:?}, {} samples) cannot be copied to `{}` ({:?}, {} samples)",
            source.name(),
            source.format(),
            source.samples(),
            target.name(),
            target.format(),
            target.samples()
        );
        assert!(
            source.format() != Format::Depth32 && source.raw() != target.raw(),
            "`{}` cannot be copied",
            source.name()
        );
        let [right, below] = target.size();
        let regions: Vec<vk::ImageCopy> = (parts().into_iter())
            .map(|(column, row)| (column.before(right), row.before(below)))
            .filter(|(column, row)| column.count > 0 && row.count > 0)
            .map(|(column, row)| region(column, row))
            .collect();
        if regions.is_empty() {
            return;
        }
        self.transition(source, ImageState::COPY_SOURCE, true);
        self.transition(target, ImageState::COPY_TARGET, true);
        self.work("copy_image", SpanKind::Copy, |rec| {
            let (from, to) = (
                ImageState::COPY_SOURCE.layout,
                ImageState::COPY_TARGET.layout,
            );
            // SAFETY: both images are alive and freed only after this frame; the regions lie in both.
            unsafe {
                rec.device().cmd_copy_image(
                    rec.raw(),
                    source.raw(),
                    from,
                    target.raw(),
                    to,
                    &regions,
                )
            };
        });
    }

    /// Fills an image that kernels sample with as many elements of a buffer, row by row without gaps. Kernels that come
    /// after it see it.
    ///
    /// # Panics
    /// If an element is not as large as a pixel, or the buffer is too short.
    pub fn copy_to_sampled<T: Pod>(&mut self, buffer: &Buffer<T>, target: &Sampled) {
        if self.skips() {
            return;
        }
        let image = target.image();
        let [width, _] = image.size();
        assert_has_pixels(buffer, image, width);
        self.fill_image("copy_to_sampled", buffer.core(), image, width);
        self.transition(image, ImageState::SAMPLED, true);
    }

    /// Copies an image to the start of a buffer, row by row without gaps.
    ///
    /// # Panics
    /// If an element is not as large as a pixel, the buffer is too short, or the image has several samples or depth.
    pub fn copy_image<T: Pod>(&mut self, image: &Image, buffer: &Buffer<T>) {
        self.copy_image_in_rows(image, buffer, image.size()[0]);
    }

    /// As [`copy_image`](Self::copy_image), with rows that begin `pitch` elements apart.
    ///
    /// # Panics
    /// As [`copy_image`](Self::copy_image), and if rows overlap.
    pub fn copy_image_in_rows<T: Pod>(&mut self, image: &Image, buffer: &Buffer<T>, pitch: u32) {
        if self.skips() {
            return;
        }
        assert_is_plain(image);
        assert_has_pixels(buffer, image, pitch);
        let core = buffer.core();
        self.touch("copy_image", &[writes(core)]);
        self.transition(image, ImageState::COPY_SOURCE, true);
        let region = whole(image).buffer_row_length(pitch);
        self.work("copy_image", SpanKind::Copy, |rec| {
            let layout = ImageState::COPY_SOURCE.layout;
            // SAFETY: image and buffer are alive and freed only after this frame; the region lies in both.
            unsafe {
                rec.device().cmd_copy_image_to_buffer(
                    rec.raw(),
                    image.raw(),
                    layout,
                    core.whole(),
                    &[region],
                );
            }
        });
    }

    /// Fills an image with the elements of a buffer, in rows that begin `pitch` elements apart.
    ///
    /// # Panics
    /// As [`copy_image_in_rows`](Self::copy_image_in_rows).
    pub fn copy_to_image<T: Pod>(&mut self, buffer: &Buffer<T>, image: &Image, pitch: u32) {
        if self.skips() {
            return;
        }
        assert_is_plain(image);
        assert_has_pixels(buffer, image, pitch);
        self.fill_image("copy_to_image", buffer.core(), image, pitch);
    }

    fn fill_image(&mut self, name: &'static str, core: &BufferCore, image: &Image, pitch: u32) {
        self.touch(name, &[reads(core)]);
        self.transition(image, ImageState::COPY_TARGET, false);
        let region = whole(image).buffer_row_length(pitch);
        self.work(name, SpanKind::Copy, |rec| {
            let layout = ImageState::COPY_TARGET.layout;
            // SAFETY: image and buffer are alive and freed only after this frame; the region lies in both.
            unsafe {
                rec.device().cmd_copy_buffer_to_image(
                    rec.raw(),
                    core.whole(),
                    image.raw(),
                    layout,
                    &[region],
                );
            }
        });
    }
}

fn reads(core: &BufferCore) -> Touch<'_> {
    Touch {
        core,
        access: Access::Copy,
        writes: false,
    }
}

fn writes(core: &BufferCore) -> Touch<'_> {
    Touch {
        writes: true,
        ..reads(core)
    }
}

/// A buffer that holds an image has an element for each pixel, and elements are as large as pixels.
fn assert_has_pixels<T: Pod>(buffer: &Buffer<T>, image: &Image, pitch: u32) {
    let [width, height] = image.size();
    let fits = size_of::<T>() == image.format().pixel_size()
        && pitch >= width
        && buffer.len() >= pitch as usize * (height as usize - 1) + width as usize;
    assert!(
        fits,
        "`{}` does not have {width} x {height} pixels of {:?}, in rows of {pitch}",
        buffer.name(),
        image.format()
    );
}

/// Only images with one sample and no depth are copied to buffers and from them.
fn assert_is_plain(image: &Image) {
    assert!(
        image.samples() == 1 && image.format() != Format::Depth32,
        "`{}` cannot be copied",
        image.name()
    );
}

/// Some columns or rows of an image, and their place in another one.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    from: u32,
    to: u32,
    count: u32,
}

impl Span {
    /// Those that end before `end`.
    fn before(self, end: u32) -> Self {
        Self {
            count: self.count.min(end.saturating_sub(self.to)),
            ..self
        }
    }
}

/// The middle of `has` columns over `wants`, from the place `to` on; the outermost ones are repeated where there are fewer.
fn middle_over(has: u32, to: u32, wants: u32) -> Vec<Span> {
    let before = wants.saturating_sub(has) / 2;
    let middle = Span {
        from: has.saturating_sub(wants) / 2,
        to: to + before,
        count: has.min(wants),
    };
    let repeated = |from: u32, to: u32| Span { from, to, count: 1 };
    let first = (0..before).map(|i| repeated(0, to + i));
    let last = (before + middle.count..wants).map(|i| repeated(has - 1, to + i));
    first.chain([middle]).chain(last).collect()
}

fn region(column: Span, row: Span) -> vk::ImageCopy {
    let offset = |x: u32, y: u32| vk::Offset3D {
        x: x as i32,
        y: y as i32,
        z: 0,
    };
    vk::ImageCopy::default()
        .src_subresource(colours())
        .src_offset(offset(column.from, row.from))
        .dst_subresource(colours())
        .dst_offset(offset(column.to, row.to))
        .extent(vk::Extent3D {
            width: column.count,
            height: row.count,
            depth: 1,
        })
}

fn colours() -> vk::ImageSubresourceLayers {
    vk::ImageSubresourceLayers::default()
        .aspect_mask(vk::ImageAspectFlags::COLOR)
        .layer_count(1)
}

/// All pixels of an image and as many elements of a buffer.
fn whole(image: &Image) -> vk::BufferImageCopy {
    let [width, height] = image.size();
    vk::BufferImageCopy::default()
        .image_subresource(colours())
        .image_extent(vk::Extent3D {
            width,
            height,
            depth: 1,
        })
}
