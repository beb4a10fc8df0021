//! The traits of generated shader handles, and the compute pipeline made from one.

use std::marker::PhantomData;
use std::sync::Arc;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use super::buffer::AnyBuffer;
use super::buffer_core::BufferCore;
use super::compiled;
use super::context::Context;
use super::error::{Check, GpuError, GpuResult};
use super::info::{DeviceInfo, DeviceKind};
use super::module::Module;
use super::pages::page_size;
use super::pipelines::{Form, PipelineHandles, PipelineKey};
use super::sampled::Sampled;
use super::texels::TexelsCore;

/// Access of a shader to a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingAccess {
    /// `readonly`
    Read,
    /// `writeonly`
    Write,
    /// Neither.
    ReadWrite,
}

/// The kind of a binding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BindingKind {
    /// A storage block.
    Storage,
    /// A texel buffer that is read.
    Texels,
    /// A texel buffer that is written, with so many components a texel.
    StorageTexels {
        /// 1 or 4.
        components: u32,
    },
    /// An image that is sampled.
    Sampled,
}

/// One binding of set 0.
#[derive(Clone, Copy, Debug)]
pub struct Binding {
    /// Number in the shader.
    pub number: u32,
    /// Name in the shader.
    pub name: &'static str,
    /// Name of the host's field. Bindings of one field are ways into one buffer.
    pub argument: &'static str,
    /// Access, from `readonly` and `writeonly`.
    pub access: BindingAccess,
    /// Storage block, texel buffer or image.
    pub kind: BindingKind,
    /// May the table lie in pages?
    pub is_paged: bool,
    /// Elements or texels that each invocation needs; 0 if the shader does not declare it.
    pub each: u32,
    /// Bytes of an element of a storage block.
    pub element: usize,
}

/// The argument of a [`Binding`].
#[derive(Clone, Copy)]
pub enum Resource<'a> {
    /// A whole buffer.
    Buffer(&'a dyn AnyBuffer),
    /// The first part of a buffer, as much as a storage block holds. If that is not all, the shader has another access path.
    FirstPart(&'a dyn AnyBuffer),
    /// A texel view.
    Texels(&'a TexelsCore),
    /// An image.
    Sampled(&'a Sampled),
    /// Nothing: with these constants the shader does not access the binding.
    Absent(Absent),
}

/// The kind of dummy buffer for an absent argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Absent {
    /// A storage block.
    Block,
    /// A texel buffer of floats.
    Floats,
    /// A texel buffer of words.
    Words,
}

impl<'a> Resource<'a> {
    /// The buffer, unless it is absent or an image; sampled images change only when they are filled.
    pub(crate) fn core(self) -> Option<&'a BufferCore> {
        match self {
            Resource::Buffer(buffer) | Resource::FirstPart(buffer) => Some(buffer.core()),
            Resource::Texels(texels) => Some(texels.core()),
            Resource::Sampled(_) | Resource::Absent(_) => None,
        }
    }
}

/// Push constants, written at the shader's offsets.
pub trait Params {
    /// Bytes.
    const SIZE: usize;
    /// Writes every field to its place in `bytes`, which has [`Params::SIZE`] bytes.
    fn write(&self, bytes: &mut [u8]);
}

impl Params for () {
    const SIZE: usize = 0;
    fn write(&self, _bytes: &mut [u8]) {}
}

/// Specialization constants.
pub trait Constants {
    /// Number and bits of each.
    fn values(&self) -> Vec<(u32, [u8; 4])>;
}

impl Constants for () {
    fn values(&self) -> Vec<(u32, [u8; 4])> {
        Vec::new()
    }
}

/// The common interface of kernels and draws; the build implements it for every shader.
pub trait Interface {
    /// The shader's file name without its ending; times and messages carry it.
    const NAME: &'static str;
    /// The bindings, by number.
    const BINDINGS: &'static [Binding];
    /// The binding of the debug list, in shaders that include `debug.glsl`.
    const DEBUG_BINDING: Option<u32>;
    /// The arguments.
    type Args<'a>;
    /// Push constants, or `()`.
    type Params: Params;
    /// Specialization constants, or `()`.
    type Constants: Constants;
    /// The resources of `args`, in the order of [`Interface::BINDINGS`].
    fn resources<'a>(args: &Self::Args<'a>) -> Vec<Resource<'a>>;
}

/// A compute shader.
pub trait Kernel: Interface {
    /// The optimised module.
    const SPIRV: Module;
    /// Invocations in a group.
    const GROUP_SIZE: u32;
}

/// A vertex and a fragment shader.
pub trait Draw: Interface {
    /// The optimised vertex module.
    const VERTEX: Module;
    /// The optimised fragment module.
    const FRAGMENT: Module;
}

/// A number of invocations; groups are counted once, by the recorder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Threads(pub u32);

impl Threads {
    /// One invocation for each of `count` things.
    ///
    /// # Panics
    /// Past 4,294,967,295.
    #[must_use]
    pub fn of(count: usize) -> Self {
        Self(
            u32::try_from(count)
                .unwrap_or_else(|_| panic!("{count} invocations do not fit a 32-bit index")),
        )
    }

    /// Groups in x and y, `x * y` of them or a few more than needed; `None` for no invocations.
    pub(crate) fn groups(self, group_size: u32, limit: u32) -> Option<[u32; 2]> {
        let groups = self.0.div_ceil(group_size);
        if groups == 0 {
            return None;
        }
        let rows = groups.div_ceil(limit);
        Some([groups.div_ceil(rows), rows])
    }
}

/// Groups of an indirect dispatch, as kernels write them.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct DispatchGroups {
    /// Along the first axis.
    pub x: u32,
    /// Along the second axis.
    pub y: u32,
    /// Along the third axis; 1, or 0 for no dispatch.
    pub z: u32,
}

impl DispatchGroups {
    /// The groups of an indirect dispatch with `count` invocations. Twin of `dispatch_groups` in `shaders/include/index.glsl`.
    #[must_use]
    pub fn of(count: u32, group_size: u32) -> Self {
        let groups = count.div_ceil(group_size);
        let rows = groups.div_ceil(65_535);
        let x = if rows == 0 { 0 } else { groups.div_ceil(rows) };
        Self { x, y: rows, z: 1 }
    }
}

/// Layout of the tables of [`Domain::Pages`](super::Domain::Pages) that a pipeline accesses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tables {
    /// A table is bound as any other. One that is only written is a storage block, because CPU drivers store faster into blocks.
    #[default]
    InOnePiece,
    /// Tables that are only written are texel buffers, because a storage block does not hold them.
    Large,
    /// Shaders reach them by the addresses of their pages, of which there may be one.
    InPages,
}

impl Tables {
    /// Layout of a table of `bytes` bytes on a device: in pages if the device has them, and one does not hold it. Where kernels run in
    /// their plain form, large if a storage block does not hold it.
    #[must_use]
    pub fn of_size(device: &DeviceInfo, bytes: u64) -> Self {
        if device.has_pages && bytes > page_size(device) {
            Self::InPages
        } else if !device.reads_blocks && bytes > device.max_storage_buffer_range {
            Self::Large
        } else {
            Self::InOnePiece
        }
    }
}

/// A compute pipeline with its layout.
pub struct Pipeline<K> {
    core: PipelineCore,
    kernel: PhantomData<fn() -> K>,
}

impl<K: Kernel> Pipeline<K> {
    /// The pipeline of kernel `K` with these specialization constants. It is compiled the first time that the context is asked
    /// for it.
    ///
    /// # Errors
    /// The kernel binds more than this device can, or the driver refuses it.
    pub fn new(ctx: &Arc<Context>, constants: &K::Constants) -> GpuResult<Self> {
        Self::named(ctx, constants, K::NAME)
    }

    /// As [`new`](Self::new), with another name in times and messages, for a kernel that a step runs in two forms.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn named(
        ctx: &Arc<Context>,
        constants: &K::Constants,
        name: &'static str,
    ) -> GpuResult<Self> {
        Self::over(ctx, constants, name, Tables::InOnePiece)
    }

    /// As [`named`](Self::named), for tables that are large, or lie in pages.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn over(
        ctx: &Arc<Context>,
        constants: &K::Constants,
        name: &'static str,
        tables: Tables,
    ) -> GpuResult<Self> {
        let core = PipelineCore::compute::<K>(ctx, constants, name, tables)?;
        Ok(Self {
            core,
            kernel: PhantomData,
        })
    }

    pub(crate) fn core(&self) -> &PipelineCore {
        &self.core
    }
}

/// Are pipelines of this device made for parts of a dispatch? Where slices are short anyway, they need not be.
pub(crate) fn divides(ctx: &Context) -> bool {
    ctx.info().kind == DeviceKind::Cpu
}

/// The kind of a binding in this form of its shader.
fn bound_as(binding: &Binding, form: Form) -> BindingKind {
    let is_only_written = binding.access == BindingAccess::Write;
    let in_block = binding.is_paged && (form.in_pages || (is_only_written && !form.is_large));
    match binding.kind {
        BindingKind::Texels | BindingKind::StorageTexels { .. } if form.in_blocks || in_block => {
            BindingKind::Storage
        }
        kind => kind,
    }
}

/// A pipeline of either kind with its layouts.
pub(crate) struct PipelineCore {
    pub(crate) ctx: Arc<Context>,
    pub(crate) name: &'static str,
    pub(crate) pipeline: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    /// Files of its modules that come from the folder `MYXO_SPIRV`.
    pub(crate) replaced: [Option<&'static str>; 2],
    form: Form,
    set_layout: vk::DescriptorSetLayout,
    /// The context frees it, in the end.
    is_kept: bool,
}

impl PipelineCore {
    fn compute<K: Kernel>(
        ctx: &Arc<Context>,
        constants: &K::Constants,
        name: &'static str,
        tables: Tables,
    ) -> GpuResult<Self> {
        let limit = ctx.info().max_group_invocations;
        if K::GROUP_SIZE > limit {
            let missing = format!("groups of {} invocations (it has {limit})", K::GROUP_SIZE);
            return Err(unsupported::<K>(ctx, missing));
        }
        let for_pages = (K::SPIRV.for_pages).filter(|_| tables == Tables::InPages);
        let for_cards = K::SPIRV.for_cards.filter(|_| ctx.card_forms);
        let for_large = (K::SPIRV.for_large).filter(|_| tables == Tables::Large);
        let form = Form {
            in_blocks: for_cards.is_some(),
            is_large: for_large.is_some(),
            in_pages: for_pages.is_some(),
        };
        let key = PipelineKey::new(K::NAME, (K::SPIRV, form), constants.values(), name);
        if let Some(made) = ctx.pipelines.get(&key) {
            return Ok(Self::kept(ctx, name, made));
        }
        let mut core = Self::layouts::<K>(ctx, vk::ShaderStageFlags::COMPUTE, form)?;
        core.name = name;
        let module = for_pages.or(for_cards).or(for_large);
        let module = module.unwrap_or(&K::SPIRV);
        let module = ShaderModule::new(ctx, module, name)?;
        core.replaced = [module.replaced, None];
        let specialization = Specialization::new(constants);
        let specialization = specialization.info();
        let stage = vk::PipelineShaderStageCreateInfo::default()
            .stage(vk::ShaderStageFlags::COMPUTE)
            .module(module.raw)
            .name(c"main")
            .specialization_info(&specialization);
        let mut flags = vk::PipelineCreateFlags::empty();
        if divides(ctx) {
            flags |= vk::PipelineCreateFlags::DISPATCH_BASE;
        }
        if ctx.device.executables.is_some() {
            flags |= vk::PipelineCreateFlags::CAPTURE_STATISTICS_KHR;
        }
        let info = [vk::ComputePipelineCreateInfo::default()
            .flags(flags)
            .stage(stage)
            .layout(core.layout)];
        // SAFETY: module, layout and constants are alive.
        let made = unsafe {
            ctx.device
                .raw
                .create_compute_pipelines(ctx.pipeline_cache(), &info, None)
        };
        let made = made
            .map_err(|(_, e)| e)
            .check("vkCreateComputePipelines", name)?;
        core.pipeline = made[0];
        ctx.device.set_name(core.pipeline, name);
        if let Some(executables) = &ctx.device.executables {
            ctx.note_compiled(compiled::ask(
                executables,
                core.pipeline,
                name,
                &constants.values(),
            ));
        }
        Ok(core.keep(key))
    }

    /// Adds the pipeline to the context's cache; returns the cached one if another thread was first.
    pub(crate) fn keep(mut self, key: PipelineKey) -> Self {
        let made = self.handles();
        let kept = self.ctx.pipelines.keep(key, made);
        self.is_kept = kept == made;
        Self::kept(&self.ctx, self.name, kept)
    }

    /// One that the context keeps.
    pub(crate) fn kept(ctx: &Arc<Context>, name: &'static str, made: PipelineHandles) -> Self {
        Self {
            ctx: Arc::clone(ctx),
            name,
            pipeline: made.pipeline,
            layout: made.layout,
            set_layout: made.set_layout,
            replaced: made.replaced,
            form: made.form,
            is_kept: true,
        }
    }

    pub(crate) fn handles(&self) -> PipelineHandles {
        PipelineHandles {
            pipeline: self.pipeline,
            layout: self.layout,
            set_layout: self.set_layout,
            replaced: self.replaced,
            form: self.form,
        }
    }

    /// The kind of a binding in this pipeline.
    pub(crate) fn bound_as(&self, binding: &Binding) -> BindingKind {
        bound_as(binding, self.form)
    }

    /// Does the shader reach the argument of this binding by the addresses of its pages?
    pub(crate) fn reaches_pages(&self, binding: &Binding) -> bool {
        self.form.in_pages && binding.is_paged
    }

    /// Set layout and pipeline layout; the pipeline itself is null yet.
    pub(crate) fn layouts<I: Interface>(
        ctx: &Arc<Context>,
        stages: vk::ShaderStageFlags,
        form: Form,
    ) -> GpuResult<Self> {
        let info = ctx.info();
        assert!(
            info.has_pages || !form.in_pages,
            "`{}` is to reach pages, and this device has none",
            I::NAME
        );
        let count = |is: fn(BindingKind) -> bool| {
            I::BINDINGS
                .iter()
                .filter(|binding| is(bound_as(binding, form)))
                .count()
        };
        let debug_blocks = usize::from(I::DEBUG_BINDING.is_some());
        for (needed, what, most) in [
            (
                count(|kind| kind == BindingKind::Storage) + debug_blocks,
                "storage buffers",
                info.max_storage_buffers,
            ),
            (
                count(|kind| matches!(kind, BindingKind::StorageTexels { .. })),
                "texel buffers to write to",
                info.max_storage_images,
            ),
            (
                count(|kind| matches!(kind, BindingKind::Texels | BindingKind::Sampled)),
                "texel buffers and images to read from",
                info.max_sampled_images,
            ),
            (
                count(|_| true) + debug_blocks,
                "bindings",
                info.max_push_descriptors,
            ),
        ] {
            if needed > most as usize {
                return Err(unsupported::<I>(
                    ctx,
                    format!("{needed} {what} (it has {most})"),
                ));
            }
        }
        let device = &ctx.device.raw;
        let debug = I::DEBUG_BINDING.map(|number| (number, BindingKind::Storage));
        let bound = I::BINDINGS.iter().map(|b| (b.number, bound_as(b, form)));
        let bindings: Vec<_> = (bound.chain(debug))
            .map(|(number, kind)| {
                vk::DescriptorSetLayoutBinding::default()
                    .binding(number)
                    .descriptor_type(descriptor_type(kind))
                    .descriptor_count(1)
                    .stage_flags(stages)
            })
            .collect();
        let mut core = Self {
            ctx: Arc::clone(ctx),
            name: I::NAME,
            pipeline: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            replaced: [None; 2],
            form,
            set_layout: vk::DescriptorSetLayout::null(),
            is_kept: false,
        };
        let set = vk::DescriptorSetLayoutCreateInfo::default()
            .flags(vk::DescriptorSetLayoutCreateFlags::PUSH_DESCRIPTOR_KHR)
            .bindings(&bindings);
        // SAFETY: what `set` points to is alive.
        core.set_layout = unsafe { device.create_descriptor_set_layout(&set, None) }
            .check("vkCreateDescriptorSetLayout", I::NAME)?;
        let sets = [core.set_layout];
        let size = <I::Params as Params>::SIZE as u32;
        let ranges = [vk::PushConstantRange::default()
            .stage_flags(stages)
            .size(size)];
        let ranges = if size == 0 { &[][..] } else { &ranges[..] };
        let layout = vk::PipelineLayoutCreateInfo::default()
            .set_layouts(&sets)
            .push_constant_ranges(ranges);
        // SAFETY: as above.
        core.layout = unsafe { device.create_pipeline_layout(&layout, None) }
            .check("vkCreatePipelineLayout", I::NAME)?;
        Ok(core)
    }
}

impl Drop for PipelineCore {
    fn drop(&mut self) {
        if !self.is_kept {
            self.ctx.deletion_queue.add(self.handles().deletion());
        }
    }
}

pub(crate) fn descriptor_type(kind: BindingKind) -> vk::DescriptorType {
    match kind {
        BindingKind::Storage => vk::DescriptorType::STORAGE_BUFFER,
        BindingKind::Texels => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
        BindingKind::StorageTexels { .. } => vk::DescriptorType::STORAGE_TEXEL_BUFFER,
        BindingKind::Sampled => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
    }
}

fn unsupported<I: Interface>(ctx: &Context, missing: String) -> GpuError {
    GpuError::Unsupported {
        what: format!("the kernel {}", I::NAME),
        missing,
        device: ctx.info().name.clone(),
    }
}

/// A module that lives until its pipeline is made.
pub(crate) struct ShaderModule<'a> {
    pub(crate) raw: vk::ShaderModule,
    /// Its file, if that comes from the folder `MYXO_SPIRV`.
    pub(crate) replaced: Option<&'static str>,
    device: &'a ash::Device,
}

impl<'a> ShaderModule<'a> {
    pub(crate) fn new(ctx: &'a Context, module: &Module, name: &str) -> GpuResult<Self> {
        let (words, is_replaced) = module.words()?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the build compiled the module for Vulkan 1.2; modules from MYXO_SPIRV are trusted to be valid.
        let raw = unsafe { ctx.device.raw.create_shader_module(&info, None) }
            .check("vkCreateShaderModule", name)?;
        Ok(Self {
            raw,
            replaced: is_replaced.then_some(module.file),
            device: &ctx.device.raw,
        })
    }
}

impl Drop for ShaderModule<'_> {
    fn drop(&mut self) {
        // SAFETY: a pipeline does not need its module once it is made.
        unsafe { self.device.destroy_shader_module(self.raw, None) };
    }
}

/// Specialization constants as Vulkan takes them.
pub(crate) struct Specialization {
    entries: Vec<vk::SpecializationMapEntry>,
    data: Vec<u8>,
}

impl Specialization {
    pub(crate) fn new(constants: &impl Constants) -> Self {
        let mut this = Self {
            entries: Vec::new(),
            data: Vec::new(),
        };
        for (id, bits) in constants.values() {
            let entry = vk::SpecializationMapEntry::default()
                .constant_id(id)
                .offset(this.data.len() as u32)
                .size(4);
            this.entries.push(entry);
            this.data.extend(bits);
        }
        this
    }

    pub(crate) fn info(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default()
            .map_entries(&self.entries)
            .data(&self.data)
    }
}
