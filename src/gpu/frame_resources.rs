//! The Vulkan objects that one frame records into, and its breadcrumbs.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use ash::vk;

use super::breadcrumbs::Breadcrumbs;
use super::context::Context;
use super::debug_list::DebugList;
use super::deletion_queue::Deletion;
use super::error::{Check, GpuResult};
use super::placeholder::Placeholder;

/// The Vulkan objects that one frame records into.
pub(crate) struct FrameResources {
    pub(crate) ctx: Arc<Context>,
    pub(crate) pool: vk::CommandPool,
    pub(crate) cmd: vk::CommandBuffer,
    pub(crate) fence: vk::Fence,
    pub(crate) queries: vk::QueryPool,
    pub(crate) query_capacity: u32,
    pub(crate) breadcrumbs: Option<Mutex<Breadcrumbs>>,
    /// Dummy buffers for absent arguments.
    pub(crate) placeholder: Placeholder,
    debug: OnceLock<DebugList>,
    /// Command buffers of slices, made as they are needed.
    slices: Mutex<Vec<vk::CommandBuffer>>,
    /// The recorder was dropped while a slice was running. Nothing is recorded into these any more.
    pub(crate) is_abandoned: AtomicBool,
}

impl FrameResources {
    pub(crate) fn new(ctx: &Arc<Context>, queries: u32) -> GpuResult<Self> {
        const WHAT: &str = "a frame";
        let mut this = Self {
            ctx: Arc::clone(ctx),
            pool: vk::CommandPool::null(),
            cmd: vk::CommandBuffer::null(),
            fence: vk::Fence::null(),
            queries: vk::QueryPool::null(),
            query_capacity: 0,
            breadcrumbs: if ctx.breadcrumbs {
                Some(Mutex::new(Breadcrumbs::new(ctx)?))
            } else {
                None
            },
            placeholder: Placeholder::new(ctx)?,
            debug: OnceLock::new(),
            slices: Mutex::new(Vec::new()),
            is_abandoned: AtomicBool::new(false),
        };
        let device = &ctx.device.raw;
        // SAFETY: the device is alive; `this` owns each handle as soon as it exists.
        unsafe {
            let info = vk::CommandPoolCreateInfo::default().queue_family_index(ctx.queue_family());
            this.pool = device
                .create_command_pool(&info, None)
                .check("vkCreateCommandPool", WHAT)?;
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(this.pool)
                .command_buffer_count(1);
            this.cmd = device
                .allocate_command_buffers(&info)
                .check("vkAllocateCommandBuffers", WHAT)?[0];
            this.fence = device
                .create_fence(&vk::FenceCreateInfo::default(), None)
                .check("vkCreateFence", WHAT)?;
            if ctx.info().has_timestamps() {
                let info = vk::QueryPoolCreateInfo::default()
                    .query_type(vk::QueryType::TIMESTAMP)
                    .query_count(queries);
                this.queries = device
                    .create_query_pool(&info, None)
                    .check("vkCreateQueryPool", WHAT)?;
                this.query_capacity = queries;
            }
        }
        ctx.device.set_name(this.cmd, "frame");
        Ok(this)
    }

    /// The debug list, made on the first dispatch of a shader that includes `debug.glsl`.
    pub(crate) fn debug_list(&self) -> &DebugList {
        self.debug.get_or_init(|| {
            let list = DebugList::new(&self.ctx, self.ctx.debug_capacity);
            list.unwrap_or_else(|error| panic!("no memory for the debug list: {error}"))
        })
    }

    pub(crate) fn works_begun(&self) -> usize {
        self.breadcrumbs.as_ref().map_or(0, |c| {
            c.lock().unwrap_or_else(PoisonError::into_inner).begun()
        })
    }

    /// Begins to record, and resets the first `unset` queries: the others are still unwritten since their last reset.
    pub(crate) fn start(&self, unset: u32) -> GpuResult<()> {
        if let Some(breadcrumbs) = &self.breadcrumbs {
            breadcrumbs
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .clear();
        }
        let device = &self.ctx.device.raw;
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the last frame in this place has finished, and no recorder has it.
        unsafe {
            device
                .reset_command_pool(self.pool, vk::CommandPoolResetFlags::empty())
                .check("vkResetCommandPool", "a frame")?;
            device
                .begin_command_buffer(self.cmd, &begin)
                .check("vkBeginCommandBuffer", "a frame")?;
            let unset = unset.min(self.query_capacity);
            if unset > 0 {
                device.cmd_reset_query_pool(self.cmd, self.queries, 0, unset);
            }
        }
        Ok(())
    }

    /// Begins to record into the command buffer of a slice.
    pub(crate) fn slice(&self, index: usize) -> GpuResult<vk::CommandBuffer> {
        const WHAT: &str = "a slice of a frame";
        let mut cmds = self.slices.lock().unwrap_or_else(PoisonError::into_inner);
        let device = &self.ctx.device.raw;
        if index == cmds.len() {
            let info = vk::CommandBufferAllocateInfo::default()
                .command_pool(self.pool)
                .command_buffer_count(1);
            // SAFETY: the pool is this frame's, which one recorder has.
            let made = unsafe { device.allocate_command_buffers(&info) };
            let made = made.check("vkAllocateCommandBuffers", WHAT)?[0];
            self.ctx.device.set_name(made, "slice");
            cmds.push(made);
        }
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool was reset when the frame began, and each index is asked for once.
        unsafe { device.begin_command_buffer(cmds[index], &begin) }
            .check("vkBeginCommandBuffer", WHAT)?;
        Ok(cmds[index])
    }
}

impl Drop for FrameResources {
    fn drop(&mut self) {
        self.ctx.deletion_queue.add(Deletion::Frame {
            pool: self.pool,
            queries: self.queries,
            fence: self.fence,
        });
    }
}
