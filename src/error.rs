//! The library's error: one variant a layer, each with what failed, where, and what to do.

use crate::plain_text::Shown as _;

/// An error that the caller could not foresee. Programming mistakes panic instead.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read or written.
    #[error("cannot {action} {path}: {source}{}", advice(source), path = path.shown())]
    Io {
        /// The failed operation: `read`, `write`, `create`.
        action: &'static str,
        /// The file or folder.
        path: std::path::PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// The device, or something on it, failed.
    #[error("{0}{advice}", advice = crate::sim::advice::on_device(.0))]
    Gpu(#[from] crate::gpu::GpuError),
    /// A mesh cannot be used.
    #[error(transparent)]
    Mesh(#[from] crate::mesh::MeshError),
    /// The triangles have no room in the texture.
    #[error(transparent)]
    Atlas(#[from] crate::mesh::atlas::AtlasError),
    /// A scene cannot be used.
    #[error(transparent)]
    Scene(#[from] crate::scene::SceneError),
    /// A picture or a video could not be written.
    #[error(transparent)]
    Output(#[from] crate::render::output::OutputError),
    /// Another process is using it; the text says what.
    #[error("{0}")]
    Busy(String),
    /// A request that cannot be fulfilled; the text says what, why and what to do.
    #[error("{0}")]
    Invalid(String),
}

impl Error {
    /// For `map_err`: makes an error of the system's an [`Error::Io`] with this action and this path.
    pub fn io(
        action: &'static str,
        path: impl Into<std::path::PathBuf>,
    ) -> impl Fn(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io {
            action,
            path: path.clone(),
            source,
        }
    }
}

/// The library's result.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Advice on a file that cannot be read or written, to append to the system's message.
pub(crate) fn advice(source: &std::io::Error) -> &'static str {
    use std::io::ErrorKind;
    match source.kind() {
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "; choose a place where you may do that"
        }
        // When a folder is created, the system's error for a file in the way is that it exists.
        ErrorKind::NotADirectory | ErrorKind::AlreadyExists => {
            "; a part of the path is a file and not a folder"
        }
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "; free some space, or choose another disk"
        }
        ErrorKind::FileTooLarge => {
            "; raise the limit of file sizes (`ulimit -f`), or choose another disk"
        }
        _ => "",
    }
}
