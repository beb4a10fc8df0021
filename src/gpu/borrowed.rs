//! A device that a host program has made for itself, on which a [`Context`](super::Context) computes as a guest.

use std::ffi::CStr;

use ash::{ext, khr, vk};

use super::device::Device;
use super::error::{GpuError, GpuResult};
use super::info::DeviceInfo;
use super::instance::Instance;

/// A Vulkan device with a queue, made and owned by the caller; see [`Context::borrow`](super::Context::borrow).
///
/// All handles belong together: the device is of the physical device, this of the instance, the instance of the entry,
/// and the queue is the device's, of the family named. The instance was made for Vulkan 1.2 or later.
#[derive(Clone)]
pub struct BorrowedDevice {
    /// The loader.
    pub entry: ash::Entry,
    /// The instance.
    pub instance: ash::Instance,
    /// The physical device of the device.
    pub physical_device: vk::PhysicalDevice,
    /// The device.
    pub device: ash::Device,
    /// A family that computes.
    pub queue_family: u32,
    /// A queue of that family.
    pub queue: vk::Queue,
    /// The extensions that device and instance were made with. `VK_KHR_push_descriptor` is needed. With
    /// `VK_KHR_dynamic_rendering`, its feature switched on, and a queue for graphics, pictures can be drawn; with
    /// `VK_EXT_debug_utils` objects have names.
    pub extensions: Vec<&'static CStr>,
    /// The features that the device was made with; none is needed.
    pub features: vk::PhysicalDeviceFeatures,
}

impl BorrowedDevice {
    fn has(&self, name: &CStr) -> bool {
        self.extensions.contains(&name)
    }

    /// The device as the rest of `gpu` uses it, and the facts about it.
    pub(super) fn take(self) -> GpuResult<(Device, DeviceInfo)> {
        let info = self.info()?;
        let instance = Instance::borrowed(
            self.entry.clone(),
            self.instance.clone(),
            self.has(ext::debug_utils::NAME),
        );
        let calibrated = info.has_calibrated_timestamps;
        let device = Device::of(instance, self.device, &info, self.features, calibrated);
        Ok((device, info))
    }

    fn info(&self) -> GpuResult<DeviceInfo> {
        let mut info = DeviceInfo::read(&self.instance, 0, self.physical_device)?;
        // SAFETY: the physical device is of this instance.
        let families = unsafe {
            self.instance
                .get_physical_device_queue_family_properties(self.physical_device)
        };
        let family = families.get(self.queue_family as usize);
        let flags = family.map_or(vk::QueueFlags::empty(), |family| family.queue_flags);
        if !flags.contains(vk::QueueFlags::COMPUTE) {
            info.missing.push("a queue for compute".to_owned());
        }
        if !self.has(khr::push_descriptor::NAME) {
            info.missing.push(
                "VK_KHR_push_descriptor among the extensions that it was made with".to_owned(),
            );
        }
        if !info.missing.is_empty() {
            return Err(GpuError::UnsuitableDevice {
                missing: info.missing.join(", "),
                devices: format!("  {}\n", info.line()),
                device: info.name,
            });
        }
        // It is not known whether the device was made with that feature.
        info.has_addresses = false;
        info.queue_family = self.queue_family;
        info.timestamp_valid_bits = family.map_or(0, |family| family.timestamp_valid_bits);
        info.has_graphics = flags.contains(vk::QueueFlags::GRAPHICS);
        info.has_dynamic_rendering =
            flags.contains(vk::QueueFlags::GRAPHICS) && self.has(khr::dynamic_rendering::NAME);
        info.has_calibrated_timestamps = self.has(ext::calibrated_timestamps::NAME);
        info.extensions.retain(|name| {
            self.extensions
                .iter()
                .any(|own| own.to_bytes() == name.as_bytes())
        });
        Ok(info)
    }
}
