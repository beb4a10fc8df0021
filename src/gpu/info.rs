//! Name, features and limits of a device, and the choice of a device.

use std::ffi::CStr;
use std::fmt::Write;

use ash::{ext, khr, vk};

use super::error::{Check, GpuError, GpuResult};
use super::instance::Instance;
use super::options::Limits;

/// The kind of a device, best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeviceKind {
    /// A card of its own.
    Discrete,
    /// Part of the processor.
    Integrated,
    /// A part of a device, handed to a virtual machine.
    Virtual,
    /// The processor itself, by a software driver.
    Cpu,
    /// The driver does not say.
    Other,
}

impl DeviceKind {
    /// `discrete`, `integrated`, `virtual`, `cpu` or `other`.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            DeviceKind::Discrete => "discrete",
            DeviceKind::Integrated => "integrated",
            DeviceKind::Virtual => "virtual",
            DeviceKind::Cpu => "cpu",
            DeviceKind::Other => "other",
        }
    }
}

/// A memory heap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heap {
    /// Bytes, as the driver reports them (lavapipe says 2 GiB whatever the machine has).
    pub size: u64,
    /// On the device, not in the host's memory.
    pub device_local: bool,
}

/// Facts about one device.
#[derive(Clone, Debug)]
pub struct DeviceInfo {
    /// Place in the driver's list; `--device` takes it.
    pub index: usize,
    /// Name of the device.
    pub name: String,
    /// Kind of device.
    pub kind: DeviceKind,
    /// Name of the driver, such as `llvmpipe`.
    pub driver: String,
    /// The driver's own version text, such as `Mesa 22.3.6 (LLVM 15.0.6)`.
    pub driver_version: String,
    /// Vulkan version of the device, such as `1.3.230`.
    pub api_version: String,
    /// Identifies device and driver build; caches are keyed by it.
    pub cache_key: String,
    /// Nanoseconds a timestamp tick takes.
    pub timestamp_period: f32,
    /// Bits of a timestamp that count; 0 where there are no timestamps.
    pub timestamp_valid_bits: u32,
    /// Bytes of one storage-buffer binding.
    pub max_storage_buffer_range: u64,
    /// Elements of one texel buffer.
    pub max_texel_buffer_elements: u32,
    /// Bytes of one allocation.
    pub max_memory_allocation_size: u64,
    /// Groups along the first axis of a dispatch.
    pub max_group_count: u32,
    /// Invocations of a group.
    pub max_group_invocations: u32,
    /// Storage buffers of one stage.
    pub max_storage_buffers: u32,
    /// Texel buffers that one stage writes to.
    pub max_storage_images: u32,
    /// Texel buffers and images that one stage reads.
    pub max_sampled_images: u32,
    /// Bindings that a kernel may have.
    pub max_push_descriptors: u32,
    /// Bytes of push constants.
    pub max_push_constants: u32,
    /// Side of a two-dimensional image.
    pub max_image_side: u32,
    /// Samples that a pixel of a picture can have, colour and depth.
    pub max_samples: u32,
    /// Invocations that run in lock-step.
    pub subgroup_size: u32,
    /// Kernels can run in their form for graphics cards: subgroups have ballots, and a kernel may use as many storage buffers as it has
    /// bindings.
    pub has_card_forms: bool,
    /// Kernels run in that form, or would if the device were opened: tables are storage blocks.
    pub reads_blocks: bool,
    /// Shaders can be given addresses of buffers.
    pub(crate) has_addresses: bool,
    /// Tables of particles may be larger than a binding, and lie in pages: kernels run in their form for graphics cards, and can be
    /// given addresses.
    pub has_pages: bool,
    /// Memory heaps.
    pub heaps: Vec<Heap>,
    /// The queue draws, too.
    pub has_graphics: bool,
    /// Pictures can be drawn (graphics queue and VK_KHR_dynamic_rendering).
    pub has_dynamic_rendering: bool,
    /// Host and device clocks can be compared.
    pub has_calibrated_timestamps: bool,
    /// Features that the kernels need and this device lacks; empty if it can run them.
    pub missing: Vec<String>,
    pub(crate) extensions: Vec<String>,
    pub(crate) queue_family: u32,
    pub(crate) physical: vk::PhysicalDevice,
}

impl DeviceInfo {
    /// `0: llvmpipe (LLVM 15.0.6, 256 bits) [cpu, llvmpipe Mesa 22.3.6]`
    #[must_use]
    pub fn line(&self) -> String {
        let mut line = format!(
            "{}: {} [{}, {} {}]",
            self.index,
            self.name,
            self.kind.as_str(),
            self.driver,
            self.driver_version
        );
        if !self.missing.is_empty() {
            let _ = write!(line, ", lacks {}", self.missing.join(", "));
        }
        line
    }

    /// Lowers limits that are higher.
    pub(crate) fn lower(&mut self, limits: Limits) {
        let range = &mut self.max_storage_buffer_range;
        *range = limits.storage_buffer_range.min(*range);
        let elements = &mut self.max_texel_buffer_elements;
        *elements = limits.texel_buffer_elements.min(*elements);
    }

    /// Does a context run kernels in their form for graphics cards on this device by default?
    #[must_use]
    pub fn takes_card_forms(&self) -> bool {
        self.has_card_forms
            && match std::env::var("MYXO_CARD_FORMS").as_deref() {
                Ok("0") => false,
                Ok("1") => true,
                // A storage block must hold everything that a texel buffer does: on most cards 2^27 texels of four words.
                _ => self.kind != DeviceKind::Cpu && self.max_storage_buffer_range >= 1 << 31,
            }
    }

    /// Lowers the limit on texel buffers to that of storage blocks, as which they are bound.
    pub(crate) fn read_in_blocks(&mut self) {
        let most = u32::try_from(self.max_storage_buffer_range / 16).unwrap_or(u32::MAX);
        self.max_texel_buffer_elements = self.max_texel_buffer_elements.min(most);
    }

    /// Are times of kernels to be had?
    #[must_use]
    pub fn has_timestamps(&self) -> bool {
        self.timestamp_valid_bits > 0 && self.timestamp_period > 0.0
    }

    pub(crate) fn has_extension(&self, name: &CStr) -> bool {
        has_extension(&self.extensions, name)
    }

    pub(crate) fn read(
        instance: &ash::Instance,
        index: usize,
        physical: vk::PhysicalDevice,
    ) -> GpuResult<Self> {
        let properties = Properties::read(instance, physical)?;
        let device = &properties.device;
        let limits = &device.limits;
        let graphics_family = properties.family(vk::QueueFlags::COMPUTE | vk::QueueFlags::GRAPHICS);
        let family = graphics_family.or_else(|| properties.family(vk::QueueFlags::COMPUTE));
        let mut info = Self {
            index,
            name: text(device.device_name_as_c_str()),
            kind: kind_of(device.device_type),
            driver: text(properties.driver.driver_name_as_c_str()),
            driver_version: text(properties.driver.driver_info_as_c_str()),
            api_version: version_text(device.api_version),
            cache_key: cache_key(device),
            timestamp_period: limits.timestamp_period,
            timestamp_valid_bits: family.map_or(0, |i| properties.families[i].timestamp_valid_bits),
            max_storage_buffer_range: u64::from(limits.max_storage_buffer_range),
            max_texel_buffer_elements: limits.max_texel_buffer_elements,
            max_memory_allocation_size: properties.maintenance.max_memory_allocation_size,
            max_group_count: limits.max_compute_work_group_count[0],
            max_group_invocations: limits.max_compute_work_group_invocations,
            max_storage_buffers: limits.max_per_stage_descriptor_storage_buffers,
            max_storage_images: limits.max_per_stage_descriptor_storage_images,
            max_sampled_images: limits.max_per_stage_descriptor_sampled_images,
            max_push_descriptors: properties.push.max_push_descriptors,
            max_push_constants: limits.max_push_constants_size,
            max_image_side: (limits.max_image_dimension2_d)
                .min(limits.max_framebuffer_width)
                .min(limits.max_framebuffer_height)
                .min(limits.max_viewport_dimensions[0])
                .min(limits.max_viewport_dimensions[1]),
            max_samples: highest_samples(
                limits.framebuffer_color_sample_counts & limits.framebuffer_depth_sample_counts,
            ),
            subgroup_size: properties.subgroup.subgroup_size,
            has_card_forms: properties.has_card_forms(),
            has_addresses: properties.has_addresses,
            reads_blocks: false,
            has_pages: false,
            heaps: properties.heaps(),
            has_graphics: graphics_family.is_some(),
            has_dynamic_rendering: graphics_family.is_some()
                && has_extension(&properties.extensions, khr::dynamic_rendering::NAME),
            has_calibrated_timestamps: has_extension(
                &properties.extensions,
                ext::calibrated_timestamps::NAME,
            ),
            missing: properties.missing(),
            extensions: properties.extensions,
            queue_family: family.unwrap_or(0) as u32,
            physical,
        };
        info.reads_blocks = info.takes_card_forms();
        info.has_pages = info.has_addresses && info.reads_blocks;
        Ok(info)
    }
}

/// Every device in the driver's order, also those that cannot run the kernels.
pub(crate) fn list(instance: &Instance) -> GpuResult<Vec<DeviceInfo>> {
    // SAFETY: the instance is alive.
    let physical =
        unsafe { instance.raw.enumerate_physical_devices() }.map_err(|e| GpuError::NoVulkan {
            reason: format!("the drivers could not be asked for devices ({e})"),
        })?;
    if physical.is_empty() {
        return Err(GpuError::NoVulkan {
            reason: "no driver offers a device".to_owned(),
        });
    }
    physical
        .into_iter()
        .enumerate()
        .map(|(index, physical)| DeviceInfo::read(&instance.raw, index, physical))
        .collect()
}

/// The device that `asked` names by index or by part of its name, or the best one.
pub(crate) fn choose(devices: Vec<DeviceInfo>, asked: Option<&str>) -> GpuResult<DeviceInfo> {
    let lines: String = devices
        .iter()
        .map(|d| format!("  {}\n", d.line()))
        .collect();
    let best = |mut candidates: Vec<DeviceInfo>| {
        candidates.sort_by_key(|d| (!d.missing.is_empty(), d.kind, d.index));
        candidates.into_iter().next()
    };
    let Some(asked) = asked else {
        let chosen = best(devices).filter(|d| d.missing.is_empty());
        return chosen.ok_or(GpuError::NoSuitableDevice { devices: lines });
    };
    let by_index = asked
        .parse::<usize>()
        .ok()
        .and_then(|i| devices.iter().find(|d| d.index == i).cloned());
    let wanted = asked.trim().to_lowercase();
    let by_name = || {
        let matches = devices
            .iter()
            .filter(|d| !wanted.is_empty() && d.name.to_lowercase().contains(&wanted));
        best(matches.cloned().collect())
    };
    match by_index.or_else(by_name) {
        None => Err(GpuError::UnknownDevice {
            asked: asked.to_owned(),
            devices: lines,
        }),
        Some(device) if !device.missing.is_empty() => Err(GpuError::UnsuitableDevice {
            missing: device.missing.join(", "),
            device: device.name,
            devices: lines,
        }),
        Some(device) => Ok(device),
    }
}

pub(super) fn text(name: Result<&CStr, std::ffi::FromBytesUntilNulError>) -> String {
    name.map_or(String::new(), |n| n.to_string_lossy().into_owned())
}

/// Properties of a device as the driver reports them. They were read in one chain, whose pointers must not be followed any more.
struct Properties {
    extensions: Vec<String>,
    device: vk::PhysicalDeviceProperties,
    driver: vk::PhysicalDeviceDriverProperties<'static>,
    maintenance: vk::PhysicalDeviceMaintenance3Properties<'static>,
    subgroup: vk::PhysicalDeviceSubgroupProperties<'static>,
    push: vk::PhysicalDevicePushDescriptorPropertiesKHR<'static>,
    families: Vec<vk::QueueFamilyProperties>,
    memory: vk::PhysicalDeviceMemoryProperties,
    has_addresses: bool,
}

impl Properties {
    fn read(instance: &ash::Instance, physical: vk::PhysicalDevice) -> GpuResult<Self> {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut maintenance = vk::PhysicalDeviceMaintenance3Properties::default();
        let mut subgroup = vk::PhysicalDeviceSubgroupProperties::default();
        let mut push = vk::PhysicalDevicePushDescriptorPropertiesKHR::default();
        // SAFETY: `physical` is from this instance; so below.
        let plain = unsafe { instance.get_physical_device_properties(physical) };
        // SAFETY: as above.
        let extensions: Vec<String> =
            unsafe { instance.enumerate_device_extension_properties(physical) }
                .check("vkEnumerateDeviceExtensionProperties", "a device")?
                .iter()
                .filter_map(|e| e.extension_name_as_c_str().ok())
                .map(|name| name.to_string_lossy().into_owned())
                .collect();
        let mut all = vk::PhysicalDeviceProperties2::default()
            .push_next(&mut maintenance)
            .push_next(&mut subgroup);
        if plain.api_version >= vk::API_VERSION_1_2 {
            all = all.push_next(&mut driver);
        }
        if has_extension(&extensions, khr::push_descriptor::NAME) {
            all = all.push_next(&mut push);
        }
        // SAFETY: as above; the chain holds only structs of Vulkan 1.2 and of extensions that the device has.
        unsafe { instance.get_physical_device_properties2(physical, &mut all) };
        let device = all.properties;
        // SAFETY: as above.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        // SAFETY: as above.
        let memory = unsafe { instance.get_physical_device_memory_properties(physical) };
        let has_addresses = device.api_version >= vk::API_VERSION_1_2 && {
            let mut addresses = vk::PhysicalDeviceBufferDeviceAddressFeatures::default();
            let mut all = vk::PhysicalDeviceFeatures2::default().push_next(&mut addresses);
            // SAFETY: as above.
            unsafe { instance.get_physical_device_features2(physical, &mut all) };
            addresses.buffer_device_address == vk::TRUE
        };
        Ok(Self {
            extensions,
            device,
            driver,
            maintenance,
            subgroup,
            push,
            families,
            memory,
            has_addresses,
        })
    }

    /// The first queue family that can do all of this.
    fn family(&self, flags: vk::QueueFlags) -> Option<usize> {
        self.families
            .iter()
            .position(|f| f.queue_flags.contains(flags))
    }

    /// Features that the kernels need and the device lacks.
    fn missing(&self) -> Vec<String> {
        let mut missing = Vec::new();
        if self.device.api_version < vk::API_VERSION_1_2 {
            missing.push("Vulkan 1.2".to_owned());
        }
        if self.family(vk::QueueFlags::COMPUTE).is_none() {
            missing.push("a queue for compute".to_owned());
        }
        if !has_extension(&self.extensions, khr::push_descriptor::NAME) {
            missing.push("VK_KHR_push_descriptor".to_owned());
        }
        missing
    }

    /// Can kernels run in their form for graphics cards?
    fn has_card_forms(&self) -> bool {
        self.device.limits.max_per_stage_descriptor_storage_buffers
            >= self.push.max_push_descriptors
            && self
                .subgroup
                .supported_stages
                .contains(vk::ShaderStageFlags::COMPUTE)
            && self
                .subgroup
                .supported_operations
                .contains(vk::SubgroupFeatureFlags::BASIC | vk::SubgroupFeatureFlags::BALLOT)
    }

    fn heaps(&self) -> Vec<Heap> {
        self.memory.memory_heaps[..self.memory.memory_heap_count as usize]
            .iter()
            .map(|h| Heap {
                size: h.size,
                device_local: h.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL),
            })
            .collect()
    }
}

fn has_extension(extensions: &[String], name: &CStr) -> bool {
    extensions.iter().any(|e| e.as_bytes() == name.to_bytes())
}

fn kind_of(device_type: vk::PhysicalDeviceType) -> DeviceKind {
    match device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => DeviceKind::Discrete,
        vk::PhysicalDeviceType::INTEGRATED_GPU => DeviceKind::Integrated,
        vk::PhysicalDeviceType::VIRTUAL_GPU => DeviceKind::Virtual,
        vk::PhysicalDeviceType::CPU => DeviceKind::Cpu,
        _ => DeviceKind::Other,
    }
}

fn cache_key(device: &vk::PhysicalDeviceProperties) -> String {
    device
        .pipeline_cache_uuid
        .iter()
        .fold(String::new(), |key, byte| key + &format!("{byte:02x}"))
        + &format!(
            "-{:x}-{:x}-{:x}",
            device.vendor_id, device.device_id, device.driver_version
        )
}

fn highest_samples(counts: vk::SampleCountFlags) -> u32 {
    1 << (31 - counts.as_raw().max(1).leading_zeros())
}

fn version_text(version: u32) -> String {
    let (major, minor, patch) = (
        vk::api_version_major(version),
        vk::api_version_minor(version),
        vk::api_version_patch(version),
    );
    format!("{major}.{minor}.{patch}")
}
