//! What sweeps of Python and of `myxo sweep` share: study files, names of runs, the folder, and the number of processes.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use pyo3::exceptions::{PyKeyError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

use super::engine::{Arrays, Load, assignments, begin_here, open_device, scene_from};
use super::errors::exception;
use crate::gpu::DeviceKind;
use crate::scene::Overrides;
use crate::sweep::{self, Contents, Row, Shard, Study};
use crate::{Error, Result};

/// Reads a study file: JSON.
#[pyfunction]
pub fn read_study(py: Python<'_>, path: PathBuf) -> PyResult<String> {
    let study = py.detach(|| Study::read(&path)).map_err(exception)?;
    serde_json::to_string(&study).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// The name of a run, 16 digits, for JSON that has all that its result depends on.
#[pyfunction]
pub fn run_key(text: &str) -> PyResult<String> {
    Ok(sweep::key_of(&from_json::<Value>(text)?))
}

/// For each of some points, as JSON, a digest of each file that a value of it names, by the value's key: what its runs also depend on.
#[pyfunction]
pub fn contents(py: Python<'_>, points: &str) -> PyResult<String> {
    begin_here()?;
    let points: Vec<Row> = from_json(points)?;
    let found = py.detach(|| {
        let mut contents = Contents::default();
        let found = points.iter().map(|point| contents.of(point));
        found.collect::<Vec<_>>()
    });
    serde_json::to_string(&found).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// Refuses parameters that do not exist.
#[pyfunction]
pub fn check_keys(keys: Vec<String>) -> PyResult<()> {
    sweep::check_keys(keys.iter().map(String::as_str), "`myxo.parameters()`")
        .map_err(|error| PyKeyError::new_err(error.to_string()))
}

/// What scene a sweep has, and what it sets there: the attributes of `SceneArguments` in `python/myxo/_scene.py`. Each is what the argument
/// of that name is for an `Engine`.
#[derive(FromPyObject)]
pub struct SceneArguments<'py> {
    scene: Option<PathBuf>,
    text: Option<Bound<'py, PyDict>>,
    meshes: Vec<Option<(String, Arrays<'py>)>>,
    folder: PathBuf,
    preset: Option<String>,
    settings: Bound<'py, PyDict>,
}

impl SceneArguments<'_> {
    /// Takes the scene from Python; loading it needs Python no more.
    fn into_load(self) -> PyResult<Load> {
        begin_here()?;
        let overrides = Overrides {
            preset: self.preset,
            set: assignments(&self.settings)?,
            seed: None,
        };
        let text = self.text.as_ref();
        scene_from(self.scene, text, self.meshes, self.folder, overrides)
    }
}

/// What a scene is: its name and a digest of all that it has.
#[pyfunction]
pub fn identity(py: Python<'_>, scene: SceneArguments<'_>) -> PyResult<String> {
    let load = scene.into_load()?;
    py.detach(|| sweep::identity(&load()?)).map_err(exception)
}

/// How many threads each of so many processes takes.
#[pyfunction]
pub fn threads(processes: usize) -> usize {
    sweep::threads(processes)
}

/// The sizes of the largest of some points, as JSON.
#[pyfunction]
pub fn largest(points: &str) -> PyResult<String> {
    let points: Vec<Row> = from_json(points)?;
    serde_json::to_string(&sweep::largest(&points))
        .map_err(|error| PyValueError::new_err(error.to_string()))
}

/// How many processes a sweep takes on this device, whose largest run is this scene, and whose runs have pictures of this size, if any; and
/// whether they compute on the processor.
#[pyfunction]
#[pyo3(signature = (scene, device, picture))]
pub fn processes(
    py: Python<'_>,
    scene: SceneArguments<'_>,
    device: Option<String>,
    picture: Option<[u32; 2]>,
) -> PyResult<(usize, bool)> {
    let load = scene.into_load()?;
    py.detach(|| {
        let ctx = open_device(device)?;
        let info = ctx.info();
        // A scene that cannot be loaded is a row with its error.
        let count = load().map_or(1, |scene| sweep::processes(info, &scene, picture));
        Ok((count, info.kind == DeviceKind::Cpu))
    })
    .map_err(exception)
}

/// Width and height of pictures from a text such as `240x240`; none if it is not such a text.
#[pyfunction]
pub fn picture_size(text: &str) -> Option<[u32; 2]> {
    sweep::picture_size(text)
}

/// Refuses pictures that cannot be drawn, before any run: of a view that the scene cannot show after so many steps, if all runs have one
/// view, or too large for the device, if runs are done on this machine.
#[pyfunction]
#[pyo3(signature = (scene, device, steps, picture, one_view, here))]
pub fn check_pictures(
    py: Python<'_>,
    scene: SceneArguments<'_>,
    device: Option<String>,
    steps: u64,
    picture: [u32; 2],
    one_view: bool,
    here: bool,
) -> PyResult<()> {
    let load = scene.into_load()?;
    py.detach(|| {
        let ctx = here.then(|| open_device(device)).transpose()?;
        // A scene that cannot be loaded is a row with its error.
        let scene = one_view.then(|| load().ok()).flatten();
        sweep::check_pictures(ctx.as_ref(), scene.as_ref(), steps, picture, "`picture`")
    })
    .map_err(exception)
}

/// The folder of a sweep, until it is closed.
#[pyclass(module = "myxo._myxo", frozen)]
pub struct Folder {
    open: Mutex<Option<sweep::Folder>>,
}

impl Folder {
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&sweep::Folder) -> Result<T> + Send,
    ) -> PyResult<T> {
        py.detach(|| {
            let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
            let folder = (open.as_ref())
                .ok_or_else(|| PyRuntimeError::new_err("the folder of the sweep is closed"))?;
            work(folder).map_err(exception)
        })
    }
}

#[pymethods]
impl Folder {
    /// Makes the folder, or checks that it is of this study, as JSON.
    #[new]
    fn new(py: Python<'_>, path: PathBuf, study: &str, shard: (usize, usize)) -> PyResult<Self> {
        let fixed: Value = from_json(study)?;
        let claim = || {
            let shard = Shard::new(shard.0, shard.1)?;
            sweep::Folder::claim(&path, &fixed, shard)
        };
        Ok(Self {
            open: Mutex::new(Some(py.detach(claim).map_err(exception)?)),
        })
    }

    /// Is there a row of this run, and if `picture`, a size, is given, its picture or a note that it could not be drawn? With `retry`, a
    /// row without an error, and a picture?
    #[pyo3(signature = (key, retry, picture))]
    fn is_done(
        &self,
        py: Python<'_>,
        key: &str,
        retry: bool,
        picture: Option<[u32; 2]>,
    ) -> PyResult<bool> {
        self.with(py, |folder| folder.is_done(key, picture, retry))
    }

    /// Writes the picture of a run, a PNG, before its row.
    fn keep_picture(&self, py: Python<'_>, key: &str, png: &[u8]) -> PyResult<()> {
        self.with(py, |folder| folder.keep_picture(key, png))
    }

    /// Writes why the picture of a run could not be drawn in this size, before its row.
    fn keep_undrawn(&self, py: Python<'_>, key: &str, size: [u32; 2], error: &str) -> PyResult<()> {
        self.with(py, |folder| folder.keep_undrawn(key, size, error))
    }

    /// Writes the row of a run, as JSON, after its fields, which are an NPZ file.
    #[pyo3(signature = (key, row, fields))]
    fn keep(&self, py: Python<'_>, key: &str, row: &str, fields: Option<&[u8]>) -> PyResult<()> {
        let row: Row = from_json(row)?;
        self.with(py, |folder| folder.keep(key, &row, fields))
    }

    /// Writes the table of those runs that are done; `runs` has the key of each and the number of its point.
    fn write_table(&self, py: Python<'_>, runs: HashMap<String, usize>) -> PyResult<()> {
        self.with(py, |folder| folder.write_table(&runs).map(drop))
    }

    /// Lets others write into it.
    fn close(&self) {
        *self.open.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

fn from_json<T: serde::de::DeserializeOwned>(text: &str) -> PyResult<T> {
    serde_json::from_str(text).map_err(|error| {
        exception(Error::Invalid(format!(
            "this is not the JSON of a sweep: {error}"
        )))
    })
}
