//! Values of parameters between Python and TOML, in which scenes are written.

use pyo3::IntoPyObjectExt as _;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyString};
use toml::Value;

/// A value of Python as one of TOML: numbers and truth values, also NumPy's, texts, sequences, and dictionaries with texts as keys.
pub fn to_toml(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(truth) = value.cast::<PyBool>() {
        return Ok(Value::Boolean(truth.is_true()));
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::String(text.to_str()?.to_owned()));
    }
    if let Ok(table) = value.cast::<PyDict>() {
        let mut all = toml::Table::new();
        for (key, value) in table {
            all.insert(key.extract()?, to_toml(&value)?);
        }
        return Ok(Value::Table(all));
    }
    if let Ok(whole) = value.extract::<i64>() {
        return Ok(Value::Integer(whole));
    }
    if let Ok(number) = value.extract::<f64>() {
        return Ok(Value::Float(number));
    }
    // Truth values of NumPy are none of Python's.
    if let Ok(truth) = value.extract::<bool>() {
        return Ok(Value::Boolean(truth));
    }
    if let Ok(items) = value.try_iter() {
        let items = items.map(|item| to_toml(&item?));
        return Ok(Value::Array(items.collect::<PyResult<_>>()?));
    }
    Err(PyTypeError::new_err(format!(
        "a {} is no value of a parameter: use a number, a text, True or False, a list of these, or a dictionary",
        value.get_type().name()?
    )))
}

/// A value as scene files have it, for Python. A text that is no TOML stays a text.
pub fn from_text<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    let table: Result<toml::Table, _> = toml::from_str(&format!("value = {text}"));
    match table.ok().and_then(|mut table| table.remove("value")) {
        Some(value) => from_toml(py, &value),
        None => text.into_bound_py_any(py),
    }
}

fn from_toml<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Boolean(truth) => truth.into_bound_py_any(py),
        Value::Integer(whole) => whole.into_bound_py_any(py),
        Value::Float(number) => number.into_bound_py_any(py),
        Value::Array(items) => {
            let items: Vec<_> = items
                .iter()
                .map(|item| from_toml(py, item))
                .collect::<PyResult<_>>()?;
            items.into_bound_py_any(py)
        }
        Value::String(text) => text.into_bound_py_any(py),
        other => other.to_string().into_bound_py_any(py),
    }
}
