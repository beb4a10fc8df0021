//! A thin layer over Vulkan, without meshes or particles.
//!
//! A [`Context`] is an open device. [`Buffer`]s are typed and named; [`Pipeline`]s are made from the handles that the
//! build generates for every shader. [`Frames`] gives out a [`Recorder`], which times, labels and checks all that is
//! recorded, and takes it back to submit it. `unsafe` and raw Vulkan stay in this layer; the one exception is `render::gui`,
//! which passes raw handles to egui's painter.
//!
//! Files use each other one way. From the bottom: `error`, `options`, `instance`, `info` and `device`; `context`; buffers and
//! images; `kernel`; `recorder`; what it records, in `waits`, `work`, `dispatch`, `copy` and `pass`; `frame`.
//!
//! **Invariant:** dropping an object never waits. The deletion queue keeps its Vulkan handles until all frames that were begun
//! before the drop are over.
//!
//! **Invariant:** between a write of a buffer and its next use there is a barrier. The recorder finds the barriers that are
//! needed, and records no others.
//!
//! **Invariant:** binding numbers, group sizes and element types are written in the shaders only.

mod access;
mod allocation;
mod alone;
mod bandwidth;
mod blocking_copy;
mod borrowed;
mod breadcrumbs;
mod buffer;
mod buffer_core;
mod cache;
mod clock;
mod compiled;
mod context;
mod copy;
mod debug;
mod debug_list;
mod deletion_queue;
mod device;
mod dispatch;
mod draws;
mod error;
mod fate;
mod frame;
mod frame_resources;
mod free;
mod image;
mod info;
mod instance;
mod kernel;
mod listing;
mod manifests;
mod module;
mod options;
mod pages;
mod part;
mod pass;
mod pipelines;
mod placeholder;
mod readback;
mod recorder;
mod report;
mod sampled;
mod slices;
mod slicing;
mod staging;
mod swapchain;
mod texels;
mod timer;
mod trace;
mod waits;
mod window_surface;
mod work;

pub use access::Access;
pub use ash;
pub use bandwidth::CopyBandwidth;
pub use borrowed::BorrowedDevice;
pub use buffer::{AnyBuffer, Buffer, Mapped};
pub use buffer_core::{BufferCore, Domain};
pub use cache::default_cache_folder;
pub use clock::Calibration;
pub use compiled::{Compiled, Statistic};
pub use context::{Context, LockedQueue, Patience, devices};
pub use debug::{DebugEntries, DebugEntry, DebugValue};
#[cfg(feature = "app")]
pub(crate) use draws::no_rendering;
pub use draws::{Blend, DepthTest, RasterOptions, RasterPipeline, Topology};
pub use error::{GpuError, GpuResult};
pub(crate) use fate::{Fate, Fates};
pub use frame::Frames;
pub use free::Free;
pub use image::{Format, Image};
pub use info::{DeviceInfo, DeviceKind, Heap};
pub use kernel::{
    Absent, Binding, BindingAccess, BindingKind, Constants, DispatchGroups, Draw, Interface,
    Kernel, Params, Pipeline, Resource, Tables, Threads,
};
pub use listing::{Listed, Reason};
pub use module::Module;
pub use options::{ContextOptions, Limits};
pub use pages::most_in_pages;
pub use part::Alone;
pub(crate) use pass::reaches_by_index;
pub use pass::{PassRecorder, Targets};
pub use readback::{Readback, ReadbackImage};
pub use recorder::{Commands, Recorder};
pub use report::{Node, Report, Row, Statistics};
pub use sampled::Sampled;
pub use swapchain::{Swapchain, WindowImage};
pub use texels::{PART, TexelScalar, Texels, TexelsCore};
pub use timer::{Span, SpanKind, Timings};
pub use trace::{HostSpan, Trace};

#[cfg(test)]
mod tests;
