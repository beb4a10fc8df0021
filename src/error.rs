//! The library's error: one variant a layer, each with what failed, where, and what to do.

/// Anything that the caller could not foresee. Programmer mistakes panic instead.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("cannot {action} {path}: {source}", path = path.display())]
    Io {
        /// What was tried: `read`, `write`, `create`.
        action: &'static str,
        /// The file or folder.
        path: std::path::PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Vulkan: no device, no memory, a device that was lost.
    #[error(transparent)]
    Gpu(#[from] crate::gpu::GpuError),
    /// A scene cannot be had as asked for.
    #[error(transparent)]
    Scene(#[from] crate::scene::SceneError),
    /// Something asked for cannot be done; the text says what and what to do.
    #[error("{0}")]
    Invalid(String),
}

/// The library's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;
