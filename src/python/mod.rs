//! The extension module `myxo._myxo` of the Python package: a thin layer, without opinions, over the library. `python/myxo/` has the
//! classes that people use, with their documentation.

mod arrays;
mod engine;
mod errors;
mod sweep;
mod values;

use numpy::PyReadonlyArray3;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::scene::builtin;
use crate::scene::parameters::{Effect, Form, PARAMETERS, Parameter, form_of};
use values::from_text;

/// The compiled part of the package `myxo`.
#[pymodule]
#[pyo3(name = "_myxo")]
fn extension(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_class::<engine::Engine>()?;
    module.add("DeviceError", module.py().get_type::<errors::DeviceError>())?;
    module.add("NO_GO", crate::sim::areas::NO_GO)?;
    module.add("version", env!("CARGO_PKG_VERSION"))?;
    module.add("arithmetic", crate::sim::arithmetic::VERSION)?;
    module.add("LONGEST_SIDE", crate::sweep::LONGEST_SIDE)?;
    module.add_function(wrap_pyfunction!(commit, module)?)?;
    module.add_function(wrap_pyfunction!(scenes, module)?)?;
    module.add_function(wrap_pyfunction!(presets, module)?)?;
    module.add_function(wrap_pyfunction!(parameters, module)?)?;
    module.add_function(wrap_pyfunction!(is_whole, module)?)?;
    module.add_function(wrap_pyfunction!(encode_png, module)?)?;
    module.add_class::<sweep::Folder>()?;
    module.add_function(wrap_pyfunction!(sweep::read_study, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::run_key, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::contents, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::check_keys, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::identity, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::largest, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::processes, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::threads, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::picture_size, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::check_pictures, module)?)?;
    Ok(())
}

/// The commit of the checkout that the package was built in, 12 digits, if it is known.
#[pyfunction]
fn commit() -> Option<String> {
    crate::commit()
}

/// The names of the built-in scenes.
#[pyfunction]
fn scenes() -> Vec<&'static str> {
    builtin::SCENES.iter().map(|scene| scene.name).collect()
}

/// The names of the built-in presets.
#[pyfunction]
fn presets() -> Vec<&'static str> {
    builtin::PRESETS.iter().map(|preset| preset.name).collect()
}

/// All parameters: key, unit, what is allowed, help, the default, and whether it can change while the simulation runs.
#[pyfunction]
fn parameters(py: Python<'_>) -> PyResult<Vec<Bound<'_, PyDict>>> {
    let usual = crate::scene::Settings::default();
    let row = |parameter: &Parameter| {
        let row = PyDict::new(py);
        row.set_item("key", parameter.key)?;
        row.set_item("unit", parameter.unit)?;
        row.set_item("allowed", parameter.allowed())?;
        row.set_item("help", parameter.help)?;
        row.set_item("default", from_text(py, &parameter.value(&usual))?)?;
        row.set_item("live", parameter.effect == Effect::Live)?;
        Ok(row)
    };
    PARAMETERS.iter().map(row).collect()
}

/// Are the values of a key whole numbers?
#[pyfunction]
fn is_whole(key: &str) -> bool {
    form_of(key) == Some(Form::Whole)
}

/// A picture, (height, width, 4), as a PNG file.
#[pyfunction]
fn encode_png<'py>(
    py: Python<'py>,
    picture: PyReadonlyArray3<'_, u8>,
) -> PyResult<Bound<'py, PyBytes>> {
    let picture = picture.as_array();
    let &[height, width, 4] = picture.shape() else {
        let shape = picture.shape();
        return Err(PyValueError::new_err(format!(
            "a picture has the shape (height, width, 4), not {shape:?}"
        )));
    };
    let bytes: Vec<u8> = picture.iter().copied().collect();
    let picture = image::RgbaImage::from_raw(width as u32, height as u32, bytes)
        .ok_or_else(|| PyValueError::new_err("the picture is too large"))?;
    let mut file = std::io::Cursor::new(Vec::new());
    (picture.write_to(&mut file, image::ImageFormat::Png))
        .map_err(|error| PyValueError::new_err(error.to_string()))?;
    Ok(PyBytes::new(py, file.get_ref()))
}
