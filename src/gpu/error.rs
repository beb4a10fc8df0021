//! Errors of a device, each with what failed and where. Layers above add advice that depends on the scene, such as which
//! setting needs less memory.

use std::path::PathBuf;

use ash::vk;

/// The result of everything in `gpu`.
pub type GpuResult<T> = Result<T, GpuError>;

/// Anything about Vulkan that the caller could not foresee.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// No loader, or a loader without a driver.
    #[error(
        "no Vulkan: {reason}; install a loader and a driver (Debian: apt install libvulkan1 mesa-vulkan-drivers), \
         or point VK_DRIVER_FILES at a driver's .json file"
    )]
    NoVulkan {
        /// The loader's message.
        reason: String,
    },
    /// Validation was requested, but its layer is not installed.
    #[error(
        "the layer VK_LAYER_KHRONOS_validation is not installed (Debian: apt install vulkan-validationlayers), or run without validation"
    )]
    NoValidation,
    /// Not one device can run the kernels.
    #[error(
        "no device can run the kernels:\n{devices}install a Vulkan 1.2 driver (Debian: apt install mesa-vulkan-drivers)"
    )]
    NoSuitableDevice {
        /// One line a device, with what it lacks.
        devices: String,
    },
    /// `--device` names none.
    #[error(
        "no device is called {asked:?}; give an index or a part of a name of these:\n{devices}"
    )]
    UnknownDevice {
        /// The requested name.
        asked: String,
        /// One line a device.
        devices: String,
    },
    /// The requested device cannot run the kernels.
    #[error(
        "the device {device:?} cannot run the kernels: it lacks {missing}; choose another:\n{devices}"
    )]
    UnsuitableDevice {
        /// Its name.
        device: String,
        /// The missing features.
        missing: String,
        /// One line a device.
        devices: String,
    },
    /// The device lacks something that only this call needs.
    #[error(
        "{what} needs {missing}, which the device {device:?} lacks; choose another by --device"
    )]
    Unsupported {
        /// The operation that failed.
        what: String,
        /// Feature, extension or limit.
        missing: String,
        /// Its name.
        device: String,
    },
    /// A buffer or image that is too large for this device.
    #[error(
        "{object:?} would take {size} bytes ({len} elements); {limit_name} is {limit} on this device: use at most {largest} elements"
    )]
    TooLarge {
        /// Name of the object.
        object: String,
        /// Elements asked for.
        len: u64,
        /// Bytes asked for.
        size: u64,
        /// The limit's name in Vulkan.
        limit_name: &'static str,
        /// Its value.
        limit: u64,
        /// Elements that fit.
        largest: u64,
    },
    /// A file of the folder `MYXO_SPIRV` that should hold a shader's module.
    #[error(
        "{path} cannot be run as a shader: {problem}; replace it with a SPIR-V module, or unset MYXO_SPIRV"
    )]
    Module {
        /// The file.
        path: PathBuf,
        /// Why not.
        problem: String,
    },
    /// No memory for a buffer or an image.
    #[error("no memory for {object:?} ({size} bytes): {source}")]
    OutOfMemory {
        /// Name of the object.
        object: String,
        /// Bytes asked for.
        size: u64,
        /// The allocator's error.
        source: gpu_allocator::AllocationError,
    },
    /// The device stopped working; nothing on it can be used any more.
    #[error("the device was lost in {call}; {last}. Everything on it is gone")]
    DeviceLost {
        /// The Vulkan call that reported it.
        call: &'static str,
        /// The last kernel begun, as far as it is known.
        last: String,
    },
    /// The device did not finish in time.
    #[error("the device did not finish within {seconds} s; {last}")]
    Timeout {
        /// The limit.
        seconds: u64,
        /// The last kernel begun, as far as it is known.
        last: String,
        /// The name of that kernel, where it is known.
        kernel: Option<String>,
    },
    /// Any other failing call.
    #[error("{call} failed for {object:?}: {source}")]
    Vulkan {
        /// The Vulkan call.
        call: &'static str,
        /// Name of the object.
        object: String,
        /// The result of the call.
        source: vk::Result,
    },
}

/// Turns `Err(vk::Result)` into an error with its call and its object.
pub(crate) trait Check<T> {
    fn check(self, call: &'static str, object: &str) -> GpuResult<T>;
}

impl<T> Check<T> for Result<T, vk::Result> {
    fn check(self, call: &'static str, object: &str) -> GpuResult<T> {
        self.map_err(|source| match source {
            vk::Result::ERROR_DEVICE_LOST => GpuError::DeviceLost {
                call,
                last: format!("{object:?} was in use"),
            },
            source => GpuError::Vulkan {
                call,
                object: object.to_owned(),
                source,
            },
        })
    }
}
