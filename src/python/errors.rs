//! Errors of the library as exceptions, with the same sentences.

use pyo3::exceptions::{PyFileNotFoundError, PyKeyError, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

use crate::Error;
use crate::mesh::MeshError;
use crate::render::output::OutputError;
use crate::scene::SceneError;
use crate::scene::parameters::PARAMETERS;
use crate::scene::suggest::nearest;

pyo3::create_exception!(
    myxo,
    DeviceError,
    PyRuntimeError,
    "The device, or something on it, failed: no device, no memory, a device that was lost."
);

/// The exception for an error.
pub fn exception(error: Error) -> PyErr {
    let text = error.to_string();
    match error {
        Error::Io { source, .. } => of_system(&source, text),
        Error::Scene(SceneError::Read { source, .. } | SceneError::ReadPreset { source, .. }) => {
            of_system(&source, text)
        }
        Error::Scene(SceneError::Object {
            source: MeshError::Read { source, .. },
            ..
        })
        | Error::Mesh(MeshError::Read { source, .. }) => of_system(&source, text),
        Error::Gpu(_) => DeviceError::new_err(text),
        Error::Busy(_) => PyRuntimeError::new_err(text),
        Error::Output(OutputError::File { source, .. }) => of_system(&source, text),
        _ => PyValueError::new_err(text),
    }
}

fn of_system(source: &std::io::Error, text: String) -> PyErr {
    match source.kind() {
        std::io::ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
        _ => PyOSError::new_err(text),
    }
}

/// The exception for a parameter that does not exist.
pub fn no_parameter(key: &str) -> PyErr {
    let keys = PARAMETERS.iter().map(|parameter| parameter.key);
    let text = match nearest(key, keys) {
        Some(near) => format!("there is no parameter `{key}`; do you mean `{near}`?"),
        None => format!("there is no parameter `{key}`: `myxo.parameters()` lists them all"),
    };
    PyKeyError::new_err(text)
}
