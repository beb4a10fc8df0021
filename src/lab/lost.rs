//! The facts that are kept of a lost device.

use std::path::PathBuf;
use std::time::Instant;

use myxo::Error;
use myxo::gpu::GpuError;
use myxo::scene::Scene;

/// The facts that are kept of a lost device.
#[derive(Default)]
pub struct Lost {
    /// The scene that ran on it, until one runs again.
    pub scene: Option<Scene>,
    /// Remarks on its meshes.
    pub remarks: Vec<String>,
    /// Since when a scene runs again.
    pub runs_since: Option<Instant>,
    /// The text of the kept scene, and its file.
    pub kept: Option<(String, PathBuf)>,
}

/// Is the cause a lost device?
pub fn is_loss(error: &Error) -> bool {
    matches!(error, Error::Gpu(GpuError::DeviceLost { .. }))
}
