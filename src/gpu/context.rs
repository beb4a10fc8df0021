//! An open device, which everything else in `gpu` needs.

use std::collections::BTreeMap;
use std::mem::ManuallyDrop;
use std::ops::Deref;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use ash::vk;
use gpu_allocator::vulkan::{Allocation, Allocator, AllocatorCreateDesc};

use super::access::Recordings;
use super::borrowed::BorrowedDevice;
use super::cache::PipelineCache;
use super::compiled::Compiled;
use super::debug::DebugEntries;
use super::deletion_queue::{Deletion, DeletionQueue};
use super::device::Device;
use super::error::{Check, GpuError, GpuResult};
use super::info::{self, DeviceInfo};
use super::instance::Instance;
use super::options::ContextOptions;
use super::pipelines::Pipelines;
use super::staging::Staging;

/// Once a wait has timed out, the device has so long to finish before its objects are freed. Else they stay.
const LAST_WAIT: Duration = Duration::from_secs(10);

/// A device, its queue, its memory, and its deletion queue.
pub struct Context {
    pub(crate) deletion_queue: DeletionQueue,
    /// Command buffer, fence and buffers of blocking transfers.
    pub(crate) staging: Mutex<Staging>,
    pub(crate) hazard_check: bool,
    /// Do kernels of an unordered group still wait for each other, for the validation layer?
    pub(crate) orders_groups: bool,
    /// Kernels run in their form for graphics cards.
    pub(crate) card_forms: bool,
    pub(crate) leave_out: Option<u32>,
    recordings: Mutex<Recordings>,
    /// The timeout without any [`Patience`].
    timeout: Duration,
    /// The sum of all present [`Patience`]s, added to the timeout, nanoseconds.
    patience: AtomicU64,
    pub(crate) breadcrumbs: bool,
    pub(crate) debug_capacity: u32,
    /// Some draw includes `debug.glsl`, so passes have to be announced in the debug list.
    pub(crate) draws_debug: AtomicBool,
    /// Submits so far, of frames and of uploads.
    pub(crate) submits: AtomicU64,
    /// The device is lost, or taken for lost: everything fails.
    is_lost: AtomicBool,
    /// A wait has timed out: the device may never finish.
    has_timed_out: AtomicBool,
    pub(crate) debug: Mutex<DebugEntries>,
    pipeline_cache: PipelineCache,
    pub(crate) pipelines: Pipelines,
    /// The driver's reports on them, if requested.
    pub(crate) compiled: Mutex<Vec<Compiled>>,
    info: DeviceInfo,
    queue: Mutex<vk::Queue>,
    /// Freed by `drop` before the device goes, unless the device still works.
    allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    /// Freed by `drop` at last, unless it still works.
    pub(crate) device: ManuallyDrop<Device>,
}

/// The queue, while no other thread can use it.
#[must_use = "the queue is locked only while this is kept"]
pub struct LockedQueue<'a>(MutexGuard<'a, vk::Queue>);

impl Deref for LockedQueue<'_> {
    type Target = vk::Queue;

    fn deref(&self) -> &vk::Queue {
        &self.0
    }
}

/// While it is kept, the device may take longer.
pub struct Patience {
    ctx: Arc<Context>,
    ns: u64,
}

impl Drop for Patience {
    fn drop(&mut self) {
        self.ctx.patience.fetch_sub(self.ns, Ordering::Relaxed);
    }
}

impl Context {
    /// Opens a device.
    ///
    /// # Errors
    /// No loader or driver, no layer (with `validation`), an unknown or unsuitable device, no memory.
    pub fn new(options: &ContextOptions) -> GpuResult<Arc<Self>> {
        let instance = Instance::new(options)?;
        let mut info = info::choose(info::list(&instance)?, options.device.as_deref())?;
        if let Some(limits) = options.limits {
            info.lower(limits);
        }
        let device = Device::new(instance, &info, options)?;
        // SAFETY: the family has one queue, which `Device::new` asked for.
        let queue = unsafe { device.raw.get_device_queue(info.queue_family, 0) };
        Self::on(device, info, queue, options)
    }

    /// Uses a device that the caller has made, and one of its queues. Dropping the context does not destroy the device.
    ///
    /// The options that choose or make a device are ignored: `device`, `validation`, `window`.
    ///
    /// # Errors
    /// When the device lacks something that kernels need, or has no memory left.
    ///
    /// # Safety
    /// The conditions of [`BorrowedDevice`] on its handles must hold. The device must outlive the context and everything made
    /// on it. While others use the queue they must hold [`Context::queue`]; while [`Context::wait_idle`] runs or the
    /// context is dropped, no other code may use any queue of the device. If a wait has timed out and the device does not
    /// finish, the context's objects stay on it.
    pub unsafe fn borrow(device: BorrowedDevice, options: &ContextOptions) -> GpuResult<Arc<Self>> {
        let queue = device.queue;
        let (device, mut info) = device.take()?;
        if let Some(limits) = options.limits {
            info.lower(limits);
        }
        Self::on(device, info, queue, options)
    }

    /// The driver's reports on all kernels compiled so far, in the order of compilation; `None` if the driver gives none,
    /// or none were requested: see [`ContextOptions::compiler_reports`].
    #[must_use]
    pub fn compiled(&self) -> Option<Vec<Compiled>> {
        self.device.executables.as_ref()?;
        let compiled = self.compiled.lock();
        Some(compiled.unwrap_or_else(PoisonError::into_inner).clone())
    }

    /// Adds reports to [`Self::compiled`].
    pub(crate) fn note_compiled(&self, more: Vec<Compiled>) {
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        compiled.extend(more);
    }

    /// Builds the context on a device.
    fn on(
        device: Device,
        mut info: DeviceInfo,
        queue: vk::Queue,
        options: &ContextOptions,
    ) -> GpuResult<Arc<Self>> {
        let asked = options.card_forms;
        let card_forms = info.has_card_forms && asked.unwrap_or_else(|| info.takes_card_forms());
        if card_forms {
            info.read_in_blocks();
        }
        info.reads_blocks = card_forms;
        info.has_pages = card_forms && info.has_addresses;
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: device.instance.raw.clone(),
            device: device.raw.clone(),
            physical_device: info.physical,
            debug_settings: Default::default(),
            buffer_device_address: info.has_addresses,
            allocation_sizes: Default::default(),
        })
        .map_err(|source| GpuError::OutOfMemory {
            object: "the allocator".to_owned(),
            size: 0,
            source,
        })?;
        Ok(Arc::new(Self {
            deletion_queue: DeletionQueue::default(),
            staging: Mutex::default(),
            recordings: Mutex::default(),
            hazard_check: (options.hazard_check)
                .unwrap_or_else(|| options.validation || std::env::var_os("MYXO_CHECK").is_some()),
            orders_groups: options.validation,
            card_forms,
            leave_out: options.leave_out,
            timeout: options.timeout,
            patience: AtomicU64::new(0),
            breadcrumbs: options.breadcrumbs,
            debug_capacity: options.debug_capacity,
            draws_debug: AtomicBool::new(false),
            submits: AtomicU64::new(0),
            is_lost: AtomicBool::new(false),
            has_timed_out: AtomicBool::new(false),
            debug: Mutex::default(),
            pipeline_cache: PipelineCache::open(
                &device.raw,
                &info,
                options.cache_folder.as_deref(),
            ),
            pipelines: Pipelines::default(),
            compiled: Mutex::default(),
            info,
            queue: Mutex::new(queue),
            allocator: ManuallyDrop::new(Arc::new(Mutex::new(allocator))),
            device: ManuallyDrop::new(device),
        }))
    }

    /// Facts about the device.
    #[must_use]
    pub fn info(&self) -> &DeviceInfo {
        &self.info
    }

    /// The validation layer's messages so far, oldest first; empty is good.
    #[must_use]
    pub fn messages(&self) -> Vec<String> {
        self.device.instance.messages.all()
    }

    /// As [`Context::messages`], and forgets them.
    #[must_use]
    pub fn take_messages(&self) -> Vec<String> {
        self.device.instance.messages.take()
    }

    /// Takes the values that kernels wrote by `debug_value` in frames that have been waited for.
    #[must_use]
    pub fn debug_entries(&self) -> DebugEntries {
        std::mem::take(&mut *self.debug.lock().unwrap_or_else(|e| e.into_inner()))
    }

    /// Number of submissions so far: one per frame, and one per upload or download.
    #[must_use]
    pub fn submits(&self) -> u64 {
        self.submits.load(Ordering::Relaxed)
    }

    /// Extends the timeout of waits by this time, by a year at most, until the returned value is dropped. Use it for known long work.
    #[must_use]
    pub fn wait_longer(self: &Arc<Self>, by: Duration) -> Patience {
        const A_YEAR: u128 = 365 * 86_400 * 1_000_000_000;
        let ns = by.as_nanos().min(A_YEAR) as u64;
        self.patience.fetch_add(ns, Ordering::Relaxed);
        Patience {
            ctx: self.clone(),
            ns,
        }
    }

    /// The present timeout of waits for the device.
    pub(crate) fn timeout(&self) -> Duration {
        let patience = Duration::from_nanos(self.patience.load(Ordering::Relaxed));
        self.timeout.saturating_add(patience)
    }

    /// Lets everything that is submitted or waited for from now on fail as if the device had been lost, so that tests see how a program
    /// handles it.
    pub fn pretend_lost(&self) {
        self.is_lost.store(true, Ordering::Relaxed);
    }

    /// Was the device lost? Pending readbacks then never arrive.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::Relaxed)
    }

    /// An error where the device is lost, or taken for lost.
    pub(crate) fn is_there(&self) -> Result<(), vk::Result> {
        if self.is_lost() {
            return Err(vk::Result::ERROR_DEVICE_LOST);
        }
        Ok(())
    }

    /// Remembers a result that says that the device is lost.
    pub(crate) fn heard<T>(&self, answer: Result<T, vk::Result>) -> Result<T, vk::Result> {
        if matches!(answer, Err(vk::Result::ERROR_DEVICE_LOST)) {
            self.is_lost.store(true, Ordering::Relaxed);
        }
        answer
    }

    /// Waits for a fence, for as long as the context allows.
    pub(crate) fn wait_for(&self, fence: vk::Fence, what: &str) -> GpuResult<()> {
        let timeout = self.timeout();
        self.has_come(self.wait_at_most(timeout, fence), timeout, what)
    }

    /// The outcome of a wait of so long.
    fn has_come(
        &self,
        waited: Result<(), vk::Result>,
        timeout: Duration,
        what: &str,
    ) -> GpuResult<()> {
        match self.heard(self.is_there().and(waited)) {
            Err(vk::Result::TIMEOUT) => {
                self.has_timed_out.store(true, Ordering::Relaxed);
                Err(GpuError::Timeout {
                    seconds: timeout.as_secs(),
                    last: format!("it was busy with {what}"),
                    kernel: None,
                })
            }
            other => other.check("vkWaitForFences", what),
        }
    }

    fn wait_at_most(&self, timeout: Duration, fence: vk::Fence) -> Result<(), vk::Result> {
        let nanoseconds = u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX);
        // SAFETY: the fence is this device's.
        unsafe { self.device.raw.wait_for_fences(&[fence], true, nanoseconds) }
    }

    /// Waits so long for all that was submitted to the queue so far.
    fn wait_for_all(&self, queue: &LockedQueue<'_>, timeout: Duration) -> Result<(), vk::Result> {
        let device = &self.device.raw;
        // SAFETY: the device is alive.
        let fence = unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }?;
        // SAFETY: the queue is locked, and the fence was made just now.
        if let Err(error) = unsafe { device.queue_submit(**queue, &[], fence) } {
            // SAFETY: nothing uses it.
            unsafe { device.destroy_fence(fence, None) };
            return Err(error);
        }
        let waited = self.wait_at_most(timeout, fence);
        match waited {
            // SAFETY: it was waited for, and no other code has it.
            Ok(()) => unsafe { device.destroy_fence(fence, None) },
            // The device may still use it.
            Err(_) => {
                let ticket = self.deletion_queue.begin();
                self.deletion_queue.submitted(ticket);
                self.deletion_queue.watch(ticket, fence);
                self.deletion_queue.add(Deletion::Frame {
                    pool: vk::CommandPool::null(),
                    queries: vk::QueryPool::null(),
                    fence,
                });
            }
        }
        waited
    }

    /// Waits until the device has nothing to do, before something is freed at once that it may use. False if it still works, long after
    /// a wait has timed out: then that must stay, and so must the context.
    pub(crate) fn finishes(&self) -> bool {
        let queue = self.queue();
        if self.has_timed_out.load(Ordering::Relaxed)
            && self.wait_for_all(&queue, LAST_WAIT) == Err(vk::Result::TIMEOUT)
        {
            log::error!(
                "{} still works after {} s more: its memory is not freed",
                self.info.name,
                LAST_WAIT.as_secs()
            );
            return false;
        }
        // An error means that the device is lost, and then it uses nothing either.
        // SAFETY: the queue is locked, so no other thread submits meanwhile.
        let _ = unsafe { self.device.raw.device_wait_idle() };
        true
    }

    /// Destroys the device. Returns the messages of the validation layer that were not taken yet.
    ///
    /// # Errors
    /// Returns the context if other references to it exist.
    pub fn end(self: Arc<Self>) -> Result<Vec<String>, Arc<Self>> {
        let messages = Arc::clone(&self.device.instance.messages);
        let alone = Arc::try_unwrap(self)?;
        drop(alone);
        Ok(messages.take())
    }

    /// Waits until the device has nothing to do.
    ///
    /// # Errors
    /// The device was lost, or did not finish in time.
    pub fn wait_idle(&self) -> GpuResult<()> {
        let queue = self.queue();
        let timeout = self.timeout();
        let waited = self.wait_for_all(&queue, timeout);
        self.has_come(waited, timeout, "what was submitted before")?;
        // Little is left to wait for: a window's pictures are in no fence.
        // SAFETY: the queue is locked, so no other thread submits meanwhile.
        let waited = unsafe { self.device.raw.device_wait_idle() };
        self.heard(self.is_there().and(waited))
            .check("vkDeviceWaitIdle", &self.info.name)
    }

    /// The raw device, for crates that draw by themselves (the interface).
    #[must_use]
    pub fn raw_device(&self) -> &ash::Device {
        &self.device.raw
    }

    /// The raw instance, for surfaces.
    #[must_use]
    pub fn raw_instance(&self) -> &ash::Instance {
        &self.device.instance.raw
    }

    /// The Vulkan loader, for surfaces.
    #[must_use]
    pub fn entry(&self) -> &ash::Entry {
        &self.device.instance.entry
    }

    /// The physical device, for surfaces.
    #[must_use]
    pub fn physical_device(&self) -> vk::PhysicalDevice {
        self.info.physical
    }

    /// The family of the one queue.
    #[must_use]
    pub fn queue_family(&self) -> u32 {
        self.info.queue_family
    }

    /// The queue, locked: a queue is used by one thread at a time.
    pub fn queue(&self) -> LockedQueue<'_> {
        LockedQueue(self.queue.lock().unwrap_or_else(|e| e.into_inner()))
    }

    /// The memory allocator, for the painter of the interface. What shares it must be gone before the context is.
    #[cfg(feature = "app")]
    pub(crate) fn allocator(&self) -> Arc<Mutex<Allocator>> {
        Arc::clone(&self.allocator)
    }

    /// Bytes of memory that objects of the device take now, by their names.
    #[must_use]
    pub fn allocated(&self) -> BTreeMap<String, u64> {
        let mut allocated = BTreeMap::new();
        for allocation in self.lock_allocator().generate_report().allocations {
            *allocated.entry(allocation.name).or_default() += allocation.size;
        }
        allocated
    }

    /// Every recording so far.
    pub(crate) fn recordings(&self) -> MutexGuard<'_, Recordings> {
        self.recordings.lock().unwrap_or_else(|e| e.into_inner())
    }

    pub(crate) fn pipeline_cache(&self) -> vk::PipelineCache {
        self.pipeline_cache.raw()
    }

    pub(crate) fn lock_allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(|e| e.into_inner())
    }

    pub(crate) fn free(&self, allocation: Allocation) {
        // The allocator only refuses what it did not hand out.
        let _ = self.lock_allocator().free(allocation);
    }

    /// Frees what no frame uses any more.
    pub(crate) fn collect_garbage(&self) {
        for deletion in self.deletion_queue.take_unused(&self.device.raw) {
            self.destroy(deletion);
        }
    }

    fn destroy(&self, deletion: Deletion) {
        let raw = &self.device.raw;
        // SAFETY: the deletion queue alone owned the object, and no submitted work uses it any more.
        unsafe {
            match deletion {
                Deletion::Buffer(buffer, allocation) => {
                    raw.destroy_buffer(buffer, None);
                    self.free(allocation);
                }
                Deletion::Semaphore(semaphore) => raw.destroy_semaphore(semaphore, None),
                Deletion::Swapchain(loader, swapchain) => loader.destroy_swapchain(swapchain, None),
                Deletion::Surface(loader, surface) => loader.destroy_surface(surface, None),
                Deletion::BufferView(view) => raw.destroy_buffer_view(view, None),
                Deletion::Sampler(sampler) => raw.destroy_sampler(sampler, None),
                Deletion::Image(view, image, allocation) => {
                    raw.destroy_image_view(view, None);
                    raw.destroy_image(image, None);
                    allocation
                        .into_iter()
                        .for_each(|allocation| self.free(allocation));
                }
                Deletion::Pipeline(pipeline, layout, set_layout) => {
                    raw.destroy_pipeline(pipeline, None);
                    raw.destroy_pipeline_layout(layout, None);
                    raw.destroy_descriptor_set_layout(set_layout, None);
                }
                Deletion::Frame {
                    pool,
                    queries,
                    fence,
                } => {
                    raw.destroy_command_pool(pool, None);
                    raw.destroy_query_pool(queries, None);
                    raw.destroy_fence(fence, None);
                }
            }
        }
    }
}

impl Drop for Context {
    fn drop(&mut self) {
        if !self.finishes() {
            return;
        }
        let staging = std::mem::take(&mut *self.staging.lock().unwrap_or_else(|e| e.into_inner()));
        for deletion in staging.deletions() {
            self.destroy(deletion);
        }
        std::mem::take(&mut self.pipeline_cache).close(&self.device.raw);
        for made in self.pipelines.take_all() {
            self.destroy(made.deletion());
        }
        for deletion in self.deletion_queue.take_all() {
            self.destroy(deletion);
        }
        // SAFETY: each is dropped once, here, the device last, and nothing uses them after that.
        unsafe {
            ManuallyDrop::drop(&mut self.allocator);
            ManuallyDrop::drop(&mut self.device);
        }
    }
}

impl std::fmt::Debug for Context {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Context({})", self.info.line())
    }
}

/// Every device that the drivers offer, also those that cannot run the kernels.
///
/// # Errors
/// No loader or no driver.
pub fn devices() -> GpuResult<Vec<DeviceInfo>> {
    info::list(&Instance::new(&ContextOptions::default())?)
}
