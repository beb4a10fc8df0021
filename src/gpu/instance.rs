//! The Vulkan instance: loader, layers, extensions, and the messenger that collects validation messages.

use std::borrow::Cow;
use std::ffi::{CStr, c_char, c_void};
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock};

use ash::{ext, vk};
use raw_window_handle::RawDisplayHandle;

use super::error::{Check, GpuError, GpuResult};
use super::manifests;
use super::options::ContextOptions;
use crate::plain_text::Shown as _;

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Messages of the validation layer, oldest first.
#[derive(Debug, Default)]
pub(crate) struct Messages(Mutex<Vec<String>>);

impl Messages {
    pub(crate) fn all(&self) -> Vec<String> {
        self.0.lock().unwrap_or_else(|e| e.into_inner()).clone()
    }

    pub(crate) fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(|e| e.into_inner()))
    }

    fn push(&self, message: String) {
        self.0
            .lock()
            .unwrap_or_else(|e| e.into_inner())
            .push(message);
    }
}

/// Why the loader has no driver, as far as that can be found.
fn no_driver() -> String {
    match manifests::chosen() {
        _ if let Some(problem) = manifests::problem() => problem,
        Some((name, files)) => {
            format!(
                "{name} is {}, and no driver is found there",
                Path::new(&files).shown()
            )
        }
        None => "no driver is installed".to_owned(),
    }
}

/// The loader has failed, mostly because of a broken manifest.
fn loader_failed(call: &'static str) -> impl FnOnce(vk::Result) -> GpuError {
    move |source| match manifests::problem() {
        Some(reason) => GpuError::NoVulkan { reason },
        None => GpuError::Vulkan {
            call,
            object: "the loader".to_owned(),
            source,
        },
    }
}

/// Owns the instance and its messenger.
pub(crate) struct Instance {
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    /// Kept alive for the messenger, which holds a pointer to it.
    pub(crate) messages: Arc<Messages>,
    pub(crate) has_debug_utils: bool,
    /// Was it created here? A borrowed one is not destroyed.
    pub(crate) is_own: bool,
    /// Is it the first one of the process, which is kept to the end?
    stays: bool,
    pub(crate) raw: ash::Instance,
    /// Keeps the loader in memory.
    pub(crate) entry: ash::Entry,
}

impl Instance {
    pub(crate) fn new(options: &ContextOptions) -> GpuResult<Self> {
        let entry = load()?;
        // SAFETY: no preconditions.
        let available = unsafe { entry.enumerate_instance_extension_properties(None) }
            .map_err(loader_failed("vkEnumerateInstanceExtensionProperties"))?;
        let has = |name: &CStr| {
            available
                .iter()
                .any(|e| e.extension_name_as_c_str() == Ok(name))
        };

        let mut layers = Vec::new();
        if options.validation {
            require_validation_layer(&entry)?;
            layers.push(VALIDATION_LAYER.as_ptr());
        }
        // The layer brings debug_utils and validation_features even where the loader has neither.
        let has_debug_utils = options.validation || has(ext::debug_utils::NAME);
        let mut extensions = Vec::new();
        if has_debug_utils {
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        if options.validation {
            extensions.push(ext::validation_features::NAME.as_ptr());
        }
        let mut flags = vk::InstanceCreateFlags::empty();
        if has(ash::khr::portability_enumeration::NAME) {
            extensions.push(ash::khr::portability_enumeration::NAME.as_ptr());
            flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
        }
        if let Some(window) = options.window {
            extensions.extend_from_slice(window_extensions(window, has)?);
        }

        let info = vk::InstanceCreateInfo::default()
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions)
            .flags(flags);
        let raw = create(&entry, info, options.validation)?;
        let mut instance = Self {
            messenger: None,
            messages: Arc::default(),
            has_debug_utils,
            is_own: true,
            stays: is_first(&entry),
            raw,
            entry,
        };
        if options.validation {
            instance.listen()?;
        }
        Ok(instance)
    }

    /// An instance that the caller has made.
    pub(crate) fn borrowed(entry: ash::Entry, raw: ash::Instance, has_debug_utils: bool) -> Self {
        Self {
            messenger: None,
            messages: Arc::default(),
            has_debug_utils,
            is_own: false,
            stays: false,
            raw,
            entry,
        }
    }

    fn listen(&mut self) -> GpuResult<()> {
        let loader = ext::debug_utils::Instance::new(&self.entry, &self.raw);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING
                    | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
            .pfn_user_callback(Some(on_message))
            .user_data(Arc::as_ptr(&self.messages).cast_mut().cast());
        // SAFETY: the messages live as long as the messenger, both being fields of `self`.
        let messenger = unsafe { loader.create_debug_utils_messenger(&info, None) }
            .check("vkCreateDebugUtilsMessengerEXT", "the validation messenger")?;
        self.messenger = Some((loader, messenger));
        Ok(())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some((loader, messenger)) = self.messenger.take() {
            // SAFETY: created from this instance; used by nothing else.
            unsafe { loader.destroy_debug_utils_messenger(messenger, None) };
        }
        if self.is_own && !self.stays {
            // SAFETY: everything that uses the instance holds a reference to it, and this was the last one.
            unsafe { self.raw.destroy_instance(None) };
        }
    }
}

/// The loader, which must not be older than Vulkan 1.2.
fn load() -> GpuResult<ash::Entry> {
    // SAFETY: the loader is a Vulkan loader; nothing of it is used after `entry` is gone.
    let entry = unsafe { ash::Entry::load() }.map_err(|e| GpuError::NoVulkan {
        reason: e.to_string(),
    })?;
    // SAFETY: no preconditions.
    let version = unsafe { entry.try_enumerate_instance_version() }
        .check("vkEnumerateInstanceVersion", "the loader")?;
    if version.is_some_and(|v| v < vk::API_VERSION_1_2) || version.is_none() {
        return Err(GpuError::NoVulkan {
            reason: "the loader is older than Vulkan 1.2".to_owned(),
        });
    }
    Ok(entry)
}

/// Fails if the validation layer is not installed.
fn require_validation_layer(entry: &ash::Entry) -> GpuResult<()> {
    // SAFETY: no preconditions.
    let installed = unsafe { entry.enumerate_instance_layer_properties() }
        .map_err(loader_failed("vkEnumerateInstanceLayerProperties"))?;
    if !installed
        .iter()
        .any(|l| l.layer_name_as_c_str() == Ok(VALIDATION_LAYER))
    {
        return Err(GpuError::NoValidation);
    }
    Ok(())
}

/// The extensions that a window needs, if the loader `has` each of them.
fn window_extensions(
    window: RawDisplayHandle,
    has: impl Fn(&CStr) -> bool,
) -> GpuResult<&'static [*const c_char]> {
    let needed = ash_window::enumerate_required_extensions(window)
        .check("vkEnumerateInstanceExtensionProperties", "the window")?;
    for &name in needed {
        // SAFETY: ash-window returns static strings.
        let name = unsafe { CStr::from_ptr(name) };
        if !has(name) {
            let reason = format!(
                "the loader has no {}, which a window needs",
                name.to_string_lossy()
            );
            return Err(GpuError::NoVulkan { reason });
        }
    }
    Ok(needed)
}

/// Creates an instance with the layers and extensions of `info`, and with synchronization validation if it `validates`.
fn create(
    entry: &ash::Entry,
    info: vk::InstanceCreateInfo<'_>,
    validates: bool,
) -> GpuResult<ash::Instance> {
    let application = vk::ApplicationInfo::default()
        .application_name(c"myxo")
        .api_version(vk::API_VERSION_1_2);
    let features = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut validation =
        vk::ValidationFeaturesEXT::default().enabled_validation_features(&features);
    let mut info = info.application_info(&application);
    if validates {
        info = info.push_next(&mut validation);
    }
    // SAFETY: every pointer in `info` outlives the call.
    unsafe { entry.create_instance(&info, None) }.map_err(|e| match e {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER => GpuError::NoVulkan {
            reason: no_driver(),
        },
        source => loader_failed("vkCreateInstance")(source),
    })
}

/// Is this the first instance of the process? That one stays, and the loader with it, so that drivers are loaded only once: after they had
/// been loaded and unloaded forty times in a process, NVIDIA's (580.159) was no longer found.
fn is_first(entry: &ash::Entry) -> bool {
    static FIRST: OnceLock<ash::Entry> = OnceLock::new();
    FIRST.set(entry.clone()).is_ok()
}

/// Collects a message. Vulkan calls it from any thread and it must not unwind.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    messages: *mut c_void,
) -> vk::Bool32 {
    if !data.is_null() && !messages.is_null() {
        // SAFETY: Vulkan passes valid data, and `messages` is what `listen` registered.
        let (data, messages) = unsafe { (&*data, &*messages.cast::<Messages>()) };
        // SAFETY: both are null or valid for the call.
        let text =
            unsafe { data.message_as_c_str() }.map_or(Cow::Borrowed(""), CStr::to_string_lossy);
        messages.push(text.into_owned());
    }
    vk::FALSE
}
