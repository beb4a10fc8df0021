//! Options of a context.

use std::path::PathBuf;
use std::time::Duration;

use raw_window_handle::RawDisplayHandle;

/// Options of a [`Context`](super::Context).
#[derive(Clone, Debug)]
pub struct ContextOptions {
    /// Index or part of the name of the device; `None` takes the best.
    pub device: Option<String>,
    /// Switches on the validation layer with synchronization validation; see [`Context::messages`](super::Context::messages).
    pub validation: bool,
    /// The display that a window will be opened on.
    pub window: Option<RawDisplayHandle>,
    /// Panics if a kernel binds one buffer twice and writes it; the check runs on the host for everything that is recorded. `None` checks
    /// if `validation` is on, or the environment variable `MYXO_CHECK` is set, as tests do.
    pub hazard_check: Option<bool>,
    /// Leaves out the barrier of this number in every recording, counted from 0, to test that the validation layer detects it.
    pub leave_out: Option<u32>,
    /// Timeout of waits for the device.
    pub timeout: Duration,
    /// Leaves a mark before each work, so that errors after a hang can name the kernel.
    pub breadcrumbs: bool,
    /// The folder for compiled pipelines; see
    /// [`default_cache_folder`](super::default_cache_folder). `None` caches nothing.
    pub cache_folder: Option<PathBuf>,
    /// Values that `debug_value` may write in a frame.
    pub debug_capacity: u32,
    /// Lowers the device's limits, so that tests of large sizes can be small.
    pub limits: Option<Limits>,
    /// Run kernels in their form for graphics cards, if the device supports it: they read tables as storage blocks, and subgroups
    /// append to lists together. `None`: on devices that are not CPUs and have storage blocks of 2 GiB, unless the environment
    /// variable `MYXO_CARD_FORMS` is 0 or 1. Results do not depend on it.
    pub card_forms: Option<bool>,
    /// Requests the driver's reports on compiled kernels, for [`Context::compiled`](super::Context::compiled), if it has the extension for
    /// that.
    pub compiler_reports: bool,
}

/// Limits of a device beyond which large buffers are accessed in other ways.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of one storage-buffer binding.
    pub storage_buffer_range: u64,
    /// Elements of one texel buffer.
    pub texel_buffer_elements: u32,
}

impl Default for ContextOptions {
    fn default() -> Self {
        Self {
            device: None,
            validation: false,
            window: None,
            hazard_check: None,
            leave_out: None,
            timeout: Duration::from_secs(60),
            breadcrumbs: true,
            cache_folder: None,
            debug_capacity: 65_536,
            limits: None,
            card_forms: None,
            compiler_reports: false,
        }
    }
}
