//! The logical device with its one queue, its extensions and its object names; owns them until the last user is gone.

use std::ffi::CString;
use std::sync::OnceLock;

use ash::{ext, khr, vk};

use super::error::{Check, GpuError, GpuResult};
use super::info::DeviceInfo;
use super::instance::Instance;
use super::options::ContextOptions;

/// Owns the device and, through it, the instance.
pub(crate) struct Device {
    pub(crate) raw: ash::Device,
    pub(crate) push_descriptor: khr::push_descriptor::Device,
    pub(crate) dynamic_rendering: Option<khr::dynamic_rendering::Device>,
    pub(crate) debug_utils: Option<ext::debug_utils::Device>,
    pub(crate) calibrated: Option<ext::calibrated_timestamps::Device>,
    /// The first reading of its clock, from which times count.
    pub(crate) first_ticks: OnceLock<u64>,
    /// Present if the driver's reports on compiled kernels are requested.
    pub(crate) executables: Option<khr::pipeline_executable_properties::Device>,
    pub(crate) features: vk::PhysicalDeviceFeatures,
    pub(crate) instance: Instance,
}

impl Device {
    pub(crate) fn new(
        instance: Instance,
        info: &DeviceInfo,
        options: &ContextOptions,
    ) -> GpuResult<Self> {
        let mut extensions = vec![khr::push_descriptor::NAME];
        let mut optional = vec![
            ext::calibrated_timestamps::NAME,
            khr::portability_subset::NAME,
        ];
        if info.has_dynamic_rendering {
            optional.push(khr::dynamic_rendering::NAME);
        }
        if options.window.is_some() {
            if !info.has_extension(khr::swapchain::NAME) {
                return Err(GpuError::Unsupported {
                    what: "a window".to_owned(),
                    missing: "VK_KHR_swapchain".to_owned(),
                    device: info.name.clone(),
                });
            }
            extensions.push(khr::swapchain::NAME);
        }
        if options.compiler_reports {
            optional.push(khr::pipeline_executable_properties::NAME);
        }
        extensions.extend(optional.into_iter().filter(|name| info.has_extension(name)));
        let names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();

        // SAFETY: the physical device is from this instance.
        let supported = unsafe { instance.raw.get_physical_device_features(info.physical) };
        let features = vk::PhysicalDeviceFeatures {
            // The debug list is written from every stage; points are drawn thicker than one pixel.
            vertex_pipeline_stores_and_atomics: supported.vertex_pipeline_stores_and_atomics,
            fragment_stores_and_atomics: supported.fragment_stores_and_atomics,
            large_points: supported.large_points,
            // More than 16 million vertices are drawn.
            full_draw_index_uint32: supported.full_draw_index_uint32,
            ..Default::default()
        };
        let priorities = [1.0];
        let queues = [vk::DeviceQueueCreateInfo::default()
            .queue_family_index(info.queue_family)
            .queue_priorities(&priorities)];
        let mut rendering =
            vk::PhysicalDeviceDynamicRenderingFeatures::default().dynamic_rendering(true);
        let mut create = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&names)
            .enabled_features(&features);
        if info.has_dynamic_rendering {
            create = create.push_next(&mut rendering);
        }
        let mut addresses =
            vk::PhysicalDeviceBufferDeviceAddressFeatures::default().buffer_device_address(true);
        if info.has_addresses {
            create = create.push_next(&mut addresses);
        }
        let mut executable_info =
            vk::PhysicalDevicePipelineExecutablePropertiesFeaturesKHR::default()
                .pipeline_executable_info(true);
        let reports = extensions.contains(&khr::pipeline_executable_properties::NAME);
        if reports {
            create = create.push_next(&mut executable_info);
        }
        // SAFETY: every pointer in `create` outlives the call; extensions and features were found on the device.
        let raw = unsafe { instance.raw.create_device(info.physical, &create, None) }
            .check("vkCreateDevice", &info.name)?;
        let calibrated = extensions.contains(&ext::calibrated_timestamps::NAME);
        let mut device = Self::of(instance, raw, info, features, calibrated);
        device.executables = reports.then(|| {
            khr::pipeline_executable_properties::Device::new(&device.instance.raw, &device.raw)
        });
        Ok(device)
    }

    /// A device of the caller; `info` has the features that may be used.
    pub(crate) fn of(
        instance: Instance,
        raw: ash::Device,
        info: &DeviceInfo,
        features: vk::PhysicalDeviceFeatures,
        calibrated: bool,
    ) -> Self {
        Self {
            push_descriptor: khr::push_descriptor::Device::new(&instance.raw, &raw),
            dynamic_rendering: info
                .has_dynamic_rendering
                .then(|| khr::dynamic_rendering::Device::new(&instance.raw, &raw)),
            debug_utils: instance
                .has_debug_utils
                .then(|| ext::debug_utils::Device::new(&instance.raw, &raw)),
            calibrated: calibrated
                .then(|| ext::calibrated_timestamps::Device::new(&instance.raw, &raw)),
            first_ticks: OnceLock::new(),
            executables: None,
            features,
            raw,
            instance,
        }
    }

    /// Gives `handle` a name in validation messages and capture tools.
    pub(crate) fn set_name<T: vk::Handle>(&self, handle: T, name: &str) {
        if let Some(debug_utils) = &self.debug_utils {
            let name = c_string(name);
            let info = vk::DebugUtilsObjectNameInfoEXT::default()
                .object_handle(handle)
                .object_name(&name);
            // SAFETY: the handle is from this device. A failure to set a name is ignored.
            let _ = unsafe { debug_utils.set_debug_utils_object_name(&info) };
        }
    }

    pub(crate) fn begin_label(&self, cmd: vk::CommandBuffer, name: &str) {
        if let Some(debug_utils) = &self.debug_utils {
            let name = c_string(name);
            let label = vk::DebugUtilsLabelEXT::default().label_name(&name);
            // SAFETY: `cmd` is being recorded.
            unsafe { debug_utils.cmd_begin_debug_utils_label(cmd, &label) };
        }
    }

    pub(crate) fn end_label(&self, cmd: vk::CommandBuffer) {
        if let Some(debug_utils) = &self.debug_utils {
            // SAFETY: `cmd` is being recorded and a label is open.
            unsafe { debug_utils.cmd_end_debug_utils_label(cmd) };
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        if self.instance.is_own {
            // SAFETY: every object of the device holds it, so none is left.
            unsafe { self.raw.destroy_device(None) };
        }
    }
}

fn c_string(name: &str) -> CString {
    CString::new(name.replace('\0', " ")).unwrap_or_default()
}
