//! A simulation as Python's classes use it. All of its methods may be called from any thread; one runs at a time, and other threads of
//! Python go on meanwhile.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use glam::{DAffine3, DMat4, DVec3, UVec2};
use numpy::ndarray::ArrayView2;
use numpy::{
    Element, PyArray1, PyArray2, PyArray3, PyArrayMethods as _, PyReadonlyArray2,
    PyUntypedArrayMethods as _, ToPyArray as _,
};
use pyo3::IntoPyObjectExt as _;
use pyo3::exceptions::{PyIndexError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arrays::{self, Row};
use super::errors::{exception, no_parameter};
use super::values::{from_text, to_toml};
use crate::export::{self, Colors, Export, ExportFile, Watch};
use crate::gpu::{Context, ContextOptions, Frames, default_cache_folder};
use crate::mesh::Mesh;
use crate::mesh::atlas::Control;
use crate::mesh::surface::NONE;
use crate::render::mean::Mean;
use crate::render::{Offscreen, Renderer, View, offscreen};
use crate::scene::file::Reader;
use crate::scene::parameters::{self, Form};
use crate::scene::settings::{Part, Settings};
use crate::scene::{Overrides, Scene, SceneError};
use crate::sim::areas::{GREATEST, NO_GO};
use crate::sim::checkpoint::Checkpoint;
use crate::sim::field::fill_gutters;
use crate::sim::graph::network_of;
use crate::sim::memory;
use crate::sim::network::Network;
use crate::sim::{Simulation, Snapshot};
use crate::strict::settled;
use crate::{Error, Result};

/// Steps that the host may be ahead of the device.
const FRAMES_IN_FLIGHT: usize = 2;
/// While steps are submitted, Python is asked for signals this often.
const ASKS_EVERY: Duration = Duration::from_millis(50);
/// While a scene is set up, this often.
const ASKS_AT_SET_UP_EVERY: Duration = Duration::from_millis(100);
/// The widest picture, pixels.
const WIDEST: u32 = 65_536;

/// A mesh in memory: vertices and corners of triangles.
pub type Arrays<'py> = (PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, i64>);

/// The measures of an object: particles, mean trail, covered share, length.
type OfObject = (u64, f64, f64, f64);

/// A scene on a device.
struct Running {
    ctx: Arc<Context>,
    scene: Scene,
    simulation: Simulation,
    frames: Frames,
    renderer: Option<Renderer>,
    canvas: Option<Offscreen>,
}

/// A scene on a device, until it is closed.
#[pyclass(module = "myxo._myxo", frozen)]
pub struct Engine {
    running: Mutex<Option<Running>>,
    /// What differs from the checkpoint from which it goes on.
    notes: Vec<String>,
}

/// The process in which the library began its work; 0 before.
static PROCESS: AtomicU32 = AtomicU32::new(0);

/// Notes that this process works. A fork of such a process lacks the threads of the library and of the driver, and would wait for them for
/// ever: it is refused.
pub fn begin_here() -> PyResult<()> {
    let own = std::process::id();
    match PROCESS.compare_exchange(0, own, Ordering::Relaxed, Ordering::Relaxed) {
        Err(first) if first != own => Err(PyRuntimeError::new_err(
            "this process was forked from one in which myxo had begun its work: use multiprocessing.get_context('spawn')",
        )),
        _ => Ok(()),
    }
}

/// Is this process a fork of one in which the library had begun its work?
fn is_forked() -> bool {
    ![0, std::process::id()].contains(&PROCESS.load(Ordering::Relaxed))
}

/// Leaves to the process from which this one was forked what that one has on its device: it cannot be freed here.
fn leave(running: Option<Running>) {
    std::mem::forget(running);
}

impl Drop for Engine {
    fn drop(&mut self) {
        if is_forked() {
            leave(self.lock().take());
        }
    }
}

/// Is it open?
fn opened(running: &mut Option<Running>) -> PyResult<&mut Running> {
    running.as_mut().ok_or_else(|| {
        PyRuntimeError::new_err("the simulation is closed: make another one to go on")
    })
}

impl Engine {
    fn lock(&self) -> MutexGuard<'_, Option<Running>> {
        // After a panic the state is as it was, or the device says what is wrong with it.
        self.running.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does some work without holding up other threads of Python.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Running) -> Result<T> + Send,
    ) -> PyResult<T> {
        begin_here()?;
        py.detach(|| {
            let mut running = self.lock();
            work(opened(&mut running)?).map_err(exception)
        })
    }
}

#[pymethods]
impl Engine {
    /// Puts a scene on a device.
    ///
    /// `scene`: a name or a path; or `text`: a scene file's text, with the objects' meshes in `meshes` where they are in memory. With
    /// `resume`, the path of a checkpoint, a text gives meshes, maps and masks alone, and without both the checkpoint has the scene.
    #[new]
    #[pyo3(signature = (scene, text, meshes, folder, preset, settings, seed, device, resume))]
    #[expect(clippy::too_many_arguments, reason = "the class in Python names them")]
    fn new(
        py: Python<'_>,
        scene: Option<PathBuf>,
        text: Option<&Bound<'_, PyDict>>,
        meshes: Vec<Option<(String, Arrays<'_>)>>,
        folder: PathBuf,
        preset: Option<String>,
        settings: &Bound<'_, PyDict>,
        seed: Option<u64>,
        device: Option<String>,
        resume: Option<PathBuf>,
    ) -> PyResult<Self> {
        begin_here()?;
        let set = assignments(settings)?;
        let begin: Begin = match resume {
            Some(path) if scene.is_none() => {
                let files = text
                    .map(|text| files_of(text, meshes, folder))
                    .transpose()?;
                Box::new(move || resumed(&path, files, &set))
            }
            resume => {
                let overrides = Overrides { preset, set, seed };
                let load = scene_from(scene, text, meshes, folder, overrides)?;
                Box::new(move || {
                    let checkpoint = resume.as_deref().map(Checkpoint::read).transpose()?;
                    Ok((load()?, checkpoint))
                })
            }
        };
        let (running, notes) = py.detach(|| set_up(begin, device))?;
        Ok(Self {
            running: Mutex::new(Some(running)),
            notes,
        })
    }

    /// What differs from the checkpoint from which it goes on, such as `trail.decay = 0.9, which was 0.95`.
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    /// Takes `count` steps, and waits for them. After Ctrl-C, as many as were begun.
    fn step(&self, py: Python<'_>, count: u64) -> PyResult<()> {
        let mut left = count;
        while left > 0 {
            left = self.with(py, |running| {
                let begun = Instant::now();
                while left > 0 && begun.elapsed() < ASKS_EVERY {
                    let mut rec = running.frames.begin()?;
                    let simulation = &mut running.simulation;
                    rec.scope("step", |rec| simulation.record_step(rec));
                    running.frames.submit(rec)?;
                    left -= 1;
                }
                Ok(left)
            })?;
            py.check_signals()?;
        }
        self.with(py, |running| Ok(running.frames.wait_idle()?))
    }

    /// Steps done.
    fn step_count(&self, py: Python<'_>) -> PyResult<u64> {
        self.with(py, |running| Ok(running.simulation.step()))
    }

    /// Seconds of the objects' motion.
    fn time(&self, py: Python<'_>) -> PyResult<f64> {
        self.with(py, |running| Ok(running.simulation.time()))
    }

    /// The name of the scene, of the device and its driver.
    fn names(&self, py: Python<'_>) -> PyResult<(String, String, String)> {
        self.with(py, |running| {
            let info = running.ctx.info();
            let driver = format!("{} {}", info.driver, info.driver_version);
            Ok((running.scene.name.clone(), info.name.clone(), driver))
        })
    }

    /// The scene's radius in world units, and how many triangles and texels a side there are. Does not wait for the device.
    fn sizes(&self, py: Python<'_>) -> PyResult<(f32, usize, u32)> {
        self.with(py, |running| {
            let (scene, simulation) = (&running.scene, &running.simulation);
            let triangles = scene.surface.corners.len();
            let side = simulation.setup().atlas.size;
            Ok((scene.radius, triangles, side))
        })
    }

    /// How many particles are alive. Where their number changes, it waits for all steps.
    fn living_count(&self, py: Python<'_>) -> PyResult<usize> {
        self.with(py, |running| running.simulation.living_count())
    }

    /// The names of the objects.
    fn object_names(&self, py: Python<'_>) -> PyResult<Vec<String>> {
        self.with(py, |running| {
            let objects = running.simulation.settings().objects.iter();
            Ok(objects.map(|object| object.name.clone()).collect())
        })
    }

    /// The scene as the text of a file, with the values of now.
    fn scene_text(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |running| {
            Ok(running.scene.to_toml_as(running.simulation.settings()))
        })
    }

    /// The value of a parameter.
    fn get<'py>(&self, py: Python<'py>, key: &str) -> PyResult<Bound<'py, PyAny>> {
        let value = self.with(py, |running| {
            Ok(value_of(running.simulation.settings(), key))
        })?;
        let value = value?;
        match parameters::form_of(key) {
            Some(Form::Text) => value.into_bound_py_any(py),
            _ => from_text(py, &value),
        }
    }

    /// Changes parameters together, from the next step or picture on.
    fn set(&self, py: Python<'_>, values: &Bound<'_, PyDict>) -> PyResult<()> {
        for key in values.keys() {
            let key: String = key.extract()?;
            self.with(py, |running| {
                Ok(value_of(running.simulation.settings(), &key))
            })??;
        }
        let set = assignments(values)?;
        self.with(py, |running| {
            let settings = changed(&running.scene.name, running.simulation.settings(), &set)?;
            running.simulation.apply(&settings)?;
            running.scene.settings = settings;
            Ok(())
        })
    }

    /// The pose of each object, (objects, 4, 4), from scaled object coordinates to world coordinates.
    fn poses<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let poses = self.with(py, |running| {
            Ok(arrays::poses(&running.scene, &running.simulation))
        })?;
        let count = poses.len();
        let flat = poses.as_flattened().as_flattened().to_pyarray(py);
        flat.reshape([count, 4, 4])
    }

    /// Sets the pose of an object from the next step on, (4, 4); `None` gives it back to the scene.
    fn set_pose(
        &self,
        py: Python<'_>,
        object: usize,
        pose: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<()> {
        let pose = pose.map(|pose| -> PyResult<_> {
            let pose = view_of(&pose)?;
            if pose.shape() != [4, 4] {
                let shape = pose.shape();
                return Err(PyValueError::new_err(format!(
                    "a pose is a matrix of shape (4, 4), not {shape:?}"
                )));
            }
            let columns: [f64; 16] = std::array::from_fn(|i| pose[[i % 4, i / 4]]);
            let matrix = DMat4::from_cols_array(&columns);
            if [3, 7, 11].map(|i| columns[i]) != [0.0; 3] || columns[15] != 1.0 {
                return Err(PyValueError::new_err(
                    "the last row of a pose is 0, 0, 0, 1: it turns and moves, and nothing else",
                ));
            }
            Ok(DAffine3::from_mat4(matrix))
        });
        let pose = pose.transpose()?;
        let count = self.with(py, |running| {
            Ok(running.simulation.settings().objects.len())
        })?;
        if object >= count {
            return Err(PyIndexError::new_err(format!(
                "there is no object {object}: the scene has {count}"
            )));
        }
        self.with(py, |running| running.simulation.set_pose(object, pose))
    }

    /// A picture, (height, width, 4), sRGB with straight alpha.
    #[pyo3(signature = (width, height, settings, transparent, passes))]
    fn render<'py>(
        &self,
        py: Python<'py>,
        width: u32,
        height: u32,
        settings: &Bound<'_, PyDict>,
        transparent: bool,
        passes: u32,
    ) -> PyResult<Bound<'py, PyArray3<u8>>> {
        if [width, height].contains(&0) || width.max(height) > WIDEST {
            return Err(PyValueError::new_err(format!(
                "a picture of {width} x {height} pixels cannot be drawn: each side is 1 or more, and at most {WIDEST}"
            )));
        }
        if !(1..=4096).contains(&passes) {
            return Err(PyValueError::new_err(format!(
                "passes is from 1 to 4096, not {passes}"
            )));
        }
        let set = assignments(settings)?;
        let bytes = self.with(py, |running| {
            draw(running, [width, height], &set, transparent, passes)
        })?;
        let flat = PyArray1::from_vec(py, bytes);
        flat.reshape([height as usize, width as usize, 4])
    }

    /// The trail, (texels, texels).
    fn trail<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        self.texels(py, |running| {
            let simulation = &running.simulation;
            let trail = running.ctx.download(&simulation.state().trail.front)?;
            Ok(arrays::rows_of(simulation.setup(), &trail))
        })
    }

    /// Sets a field of texels, (texels, texels), from the next step on: the trail, the bias or the weights of the second look.
    fn set_field(
        &self,
        py: Python<'_>,
        field: &str,
        values: PyReadonlyArray2<'_, f32>,
    ) -> PyResult<()> {
        let field = Field::named(field)?;
        let values = view_of(&values)?;
        let shape = [values.shape()[0], values.shape()[1]];
        let values: Vec<f32> = values.iter().copied().collect();
        self.with(py, |running| set_field(running, field, shape, &values))
    }

    /// The bias, or the weights of the second look, (texels, texels); zero where nothing was painted.
    fn field<'py>(&self, py: Python<'py>, field: &str) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let field = Field::named(field)?;
        self.texels(py, |running| {
            let simulation = &running.simulation;
            let mut snapshot = simulation.snapshot()?;
            let values = std::mem::take(field.of(&mut snapshot));
            let side = simulation.setup().atlas.size as usize;
            Ok(if values.is_empty() {
                vec![0.0; side * side]
            } else {
                arrays::rows_of(simulation.setup(), &values)
            })
        })
    }

    /// Particles per texel in the last step, (texels, texels).
    fn deposits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        self.texels(py, |running| {
            let simulation = &running.simulation;
            // The counts of the last step are at the back.
            let deposits = running.ctx.download(&simulation.state().deposits.back)?;
            Ok(arrays::rows_of(simulation.setup(), &deposits))
        })
    }

    /// The area of each texel in world units squared, (texels, texels).
    fn texel_areas<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        self.texels(py, |running| {
            let setup = running.simulation.setup();
            Ok(arrays::rows_of(setup, &setup.atlas.area))
        })
    }

    /// The object of each texel, -1 where there is none, (texels, texels).
    fn texel_objects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        self.texels(py, |running| {
            let setup = running.simulation.setup();
            let triangles = &setup.surface.triangles;
            Ok(arrays::of_owners(setup, |t| triangles[t as usize].object))
        })
    }

    /// The triangle of each texel, -1 where there is none, (texels, texels).
    fn texel_triangles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        self.texels(py, |running| {
            Ok(arrays::of_owners(running.simulation.setup(), |t| t))
        })
    }

    /// The place of each texel in world coordinates, not a number where there is none, (texels, texels, 3).
    fn texel_positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let (places, side) = self.with(py, |running| {
            let side = running.simulation.setup().atlas.size as usize;
            Ok((arrays::texel_places(&running.simulation), side))
        })?;
        places
            .as_flattened()
            .to_pyarray(py)
            .reshape([side, side, 3])
    }

    /// Fills the memory of an array of particles: a row of 72 bytes for each that is alive, in the order of their ids.
    fn fill_particles(&self, py: Python<'_>, rows: &Bound<'_, PyArray1<u8>>) -> PyResult<()> {
        let mut rows = rows.readwrite();
        let bytes = rows.as_slice_mut()?;
        let rows: &mut [Row] = bytemuck::try_cast_slice_mut(bytes)
            .map_err(|_| PyValueError::new_err("the array is not one of particles"))?;
        self.with(py, |running| {
            arrays::fill_particles(&running.simulation, rows)
        })
    }

    /// Vertices of the surface in scaled object coordinates, as in files, (vertices, 3), and corners of its triangles, (triangles, 3).
    #[expect(clippy::type_complexity, reason = "two arrays")]
    fn surface<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(
        Bound<'py, PyArray2<f64>>,
        Bound<'py, PyArray2<i32>>,
        Vec<[u32; 2]>,
    )> {
        let (vertices, corners, ranges) = self.with(py, |running| {
            let (surface, origins) = (&running.scene.surface, &running.scene.origins);
            let vertices = surface.objects.iter().zip(origins);
            let vertices = vertices.flat_map(|(range, origins)| {
                let own = range.vertices.0 as usize..range.vertices.1 as usize;
                let own = surface.positions[own].iter();
                own.map(|place| (place.as_dvec3() + origins.surface).to_array())
            });
            let corners = surface.corners.iter();
            let corners = corners.map(|corners| corners.map(|corner| corner as i32));
            let parts = surface.objects.iter();
            let ranges = parts.map(|range| [range.vertices.0, range.vertices.1]);
            let vertices: Vec<[f64; 3]> = vertices.collect();
            let corners: Vec<[i32; 3]> = corners.collect();
            Ok((vertices, corners, ranges.collect()))
        })?;
        let flat = vertices.as_flattened().to_pyarray(py);
        let corner_array = corners.as_flattened().to_pyarray(py);
        Ok((
            flat.reshape([vertices.len(), 3])?,
            corner_array.reshape([corners.len(), 3])?,
            ranges,
        ))
    }

    /// The measures of the network as JSON, and those of each object.
    fn measures(&self, py: Python<'_>) -> PyResult<(String, Vec<OfObject>)> {
        self.with(py, |running| {
            let simulation = &running.simulation;
            let network = Network::of(&simulation.snapshot()?, simulation.setup());
            let objects = network.objects.iter();
            let objects =
                objects.map(|part| (part.particles, part.mean_trail, part.covered, part.length));
            let text = serde_json::to_string(&network)
                .map_err(|error| Error::Invalid(error.to_string()))?;
            Ok((text, objects.collect()))
        })
    }

    /// The network as a graph, as JSON: its measures, nodes and edges.
    fn network(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |running| {
            let simulation = &running.simulation;
            let trail = running.ctx.download(&simulation.state().trail.front)?;
            let poses = simulation.world_from_object();
            let (graph, measures) = network_of(&trail, simulation.setup(), &poses);
            let whole = serde_json::json!({
                "measures": measures,
                "nodes": graph.nodes,
                "edges": graph.edges,
            });
            Ok(whole.to_string())
        })
    }

    /// The measures of that graph as JSON: a list of names and values, those of columns of tables.
    fn network_columns(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |running| {
            let simulation = &running.simulation;
            let trail = running.ctx.download(&simulation.state().trail.front)?;
            let poses = simulation.world_from_object();
            let (_, measures) = network_of(&trail, simulation.setup(), &poses);
            Ok(serde_json::json!(export::network_columns(&measures)).to_string())
        })
    }

    /// The hash of the state, 16 hexadecimal digits.
    fn state_hash(&self, py: Python<'_>) -> PyResult<String> {
        self.with(py, |running| {
            Ok(format!("{:016x}", running.simulation.snapshot()?.hash()))
        })
    }

    /// Checks that no particle is lost and no value impossible.
    fn validate(&self, py: Python<'_>) -> PyResult<()> {
        self.with(py, |running| {
            let simulation = &running.simulation;
            let snapshot = simulation.snapshot()?;
            snapshot
                .validate(simulation.setup())
                .map_err(Error::Invalid)
        })
    }

    /// Writes the state into a checkpoint, and as other files.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        self.with(py, |running| {
            let snapshot = running.simulation.snapshot()?;
            let export = Export::of(&running.scene, &running.simulation, &snapshot)?;
            export::write_checkpoint(export, &path, &Watch::default())?;
            Ok(())
        })
    }

    /// Writes the state as GLB, PLY, NPZ or a scene file, by the ending of the path; the files that were written.
    fn export(&self, py: Python<'_>, path: PathBuf, vertex_colors: bool) -> PyResult<Vec<PathBuf>> {
        let colors = if vertex_colors {
            Colors::Vertex
        } else {
            Colors::Texture
        };
        self.with(py, |running| {
            let file = ExportFile::create(&path)?;
            let snapshot = running.simulation.snapshot()?;
            let export = Export::of(&running.scene, &running.simulation, &snapshot)?;
            Ok(file.write(&export, colors)?.files)
        })
    }

    /// Frees the device. Nothing else can be done afterwards.
    fn close(&self, py: Python<'_>) -> PyResult<()> {
        if is_forked() {
            leave(self.lock().take());
            return Ok(());
        }
        py.detach(|| {
            let Some(mut running) = self.lock().take() else {
                return Ok(());
            };
            let ended = running.frames.wait_idle();
            ended.map_err(|error| exception(error.into()))
        })
    }

    /// Is it closed?
    fn is_closed(&self, py: Python<'_>) -> bool {
        py.detach(|| self.lock().is_none())
    }
}

impl Engine {
    fn texels<'py, T: Element + Copy + Send>(
        &self,
        py: Python<'py>,
        read: impl FnOnce(&mut Running) -> Result<Vec<T>> + Send,
    ) -> PyResult<Bound<'py, PyArray2<T>>> {
        let (values, side) = self.with(py, |running| {
            let side = running.simulation.setup().atlas.size as usize;
            Ok((read(running)?, side))
        })?;
        PyArray1::from_vec(py, values).reshape([side, side])
    }
}

/// A field of texels that can be set.
#[derive(Clone, Copy)]
enum Field {
    Trail,
    Bias,
    SecondLook,
}

impl Field {
    fn named(name: &str) -> PyResult<Self> {
        Ok(match name {
            "trail" => Self::Trail,
            "bias" => Self::Bias,
            "second_look" => Self::SecondLook,
            _ => return Err(PyValueError::new_err(format!("there is no field `{name}`"))),
        })
    }

    fn of(self, snapshot: &mut Snapshot) -> &mut Vec<f32> {
        match self {
            Self::Trail => &mut snapshot.trail,
            Self::Bias => &mut snapshot.bias,
            Self::SecondLook => &mut snapshot.looks,
        }
    }

    /// Is this a possible value?
    fn allows(self, value: f32) -> bool {
        match self {
            Self::Trail => (0.0..=Snapshot::MOST_TRAIL).contains(&value),
            Self::Bias => (-GREATEST..=GREATEST).contains(&value) || value == NO_GO,
            Self::SecondLook => (0.0..=1.0).contains(&value),
        }
    }

    /// Its possible values.
    fn range(self) -> &'static str {
        match self {
            Self::Trail => "the trail is from 0 to 1e29",
            Self::Bias => "a bias is from -1e6 to 1e6, or NO_GO",
            Self::SecondLook => "a weight is from 0 to 1",
        }
    }
}

/// Sets a field on the texels that triangles own; what lies between them follows.
fn set_field(running: &mut Running, field: Field, shape: [usize; 2], values: &[f32]) -> Result<()> {
    let simulation = &mut running.simulation;
    let atlas = &simulation.setup().atlas;
    let (side, pitch) = (atlas.size as usize, atlas.pitch as usize);
    if shape != [side, side] {
        return Err(Error::Invalid(format!(
            "the field has the shape {shape:?}: ({side}, {side}) is needed, as `texel_area` has"
        )));
    }
    let mut snapshot = simulation.snapshot()?;
    let mut whole = vec![0.0; atlas.owner.len()];
    for (texel, _) in atlas
        .owner
        .iter()
        .enumerate()
        .filter(|(_, owner)| **owner != NONE)
    {
        let (row, column) = (texel / pitch, texel % pitch);
        let value = values[row * side + column];
        if !field.allows(value) {
            return Err(Error::Invalid(format!(
                "{value} at [{row}, {column}]: {}",
                field.range()
            )));
        }
        whole[texel] = settled(value);
    }
    fill_gutters(&atlas.seams, &mut whole);
    whole.iter_mut().for_each(|value| *value = settled(*value));
    // What was never painted stays unpainted.
    let is_nothing = !matches!(field, Field::Trail) && whole.iter().all(|value| *value == 0.0);
    if !(is_nothing && field.of(&mut snapshot).is_empty()) {
        *field.of(&mut snapshot) = whole;
    }
    simulation.restore(&snapshot)
}

/// Text of a scene file.
trait AsFile {
    fn to_string_as_file(&self) -> PyResult<String>;
}

impl AsFile for toml::Value {
    fn to_string_as_file(&self) -> PyResult<String> {
        toml::to_string(self).map_err(|error| PyValueError::new_err(format!("the scene: {error}")))
    }
}

/// `KEY=VALUE` for each entry, as the command line has them.
pub fn assignments(values: &Bound<'_, PyDict>) -> PyResult<Vec<String>> {
    let assignments = values.iter().map(|(key, value)| {
        let key: String = key.extract()?;
        Ok(format!("{key}={}", to_toml(&value)?))
    });
    assignments.collect()
}

/// Settings with some changes.
fn changed(name: &str, settings: &Settings, set: &[String]) -> Result<Settings> {
    let mut reader = Reader::new(settings.clone());
    for assignment in set {
        reader.assignment(assignment);
    }
    let changed = reader.finish().map_err(|problems| SceneError::Problems {
        scene: name.into(),
        problems,
    });
    Ok(changed?)
}

/// The value of a parameter, as scene files have it.
fn value_of(settings: &Settings, key: &str) -> PyResult<String> {
    parameters::value_of(settings, key).ok_or_else(|| no_parameter(key))
}

/// The elements of an array. The library for NumPy takes it for granted that they are aligned, and whole elements apart.
fn view_of<'a, T: Element>(array: &'a PyReadonlyArray2<'_, T>) -> PyResult<ArrayView2<'a, T>> {
    let size = size_of::<T>() as isize;
    let mut axes = array.shape().iter().zip(array.strides());
    let is_even = axes.all(|(&length, &stride)| length < 2 || stride % size == 0);
    if !is_even || !array.data().is_aligned() {
        return Err(PyValueError::new_err(
            "the elements of the array are not aligned, or not whole elements apart: use a copy of it, as by `array.copy()`",
        ));
    }
    Ok(array.as_array())
}

/// A mesh in memory.
fn mesh_of(name: &str, (vertices, faces): &Arrays<'_>) -> PyResult<Mesh> {
    let (vertices, faces) = (view_of(vertices)?, view_of(faces)?);
    for (array, what) in [(vertices.shape(), "vertices"), (faces.shape(), "faces")] {
        if array[1] != 3 {
            return Err(PyValueError::new_err(format!(
                "the {what} of `{name}` have the shape {array:?}: (n, 3) is needed"
            )));
        }
    }
    let positions: Vec<DVec3> = vertices
        .rows()
        .into_iter()
        .map(|row| DVec3::new(row[0], row[1], row[2]))
        .collect();
    let count = positions.len();
    let corner = |corner: i64| {
        let is_there = usize::try_from(corner).is_ok_and(|corner| corner < count);
        is_there.then_some(corner as u32).ok_or_else(|| {
            PyValueError::new_err(format!(
                "a face of `{name}` has the corner {corner}: there are {count} vertices, counted from 0"
            ))
        })
    };
    let triangles: Vec<[u32; 3]> = faces
        .rows()
        .into_iter()
        .map(|row| Ok([corner(row[0])?, corner(row[1])?, corner(row[2])?]))
        .collect::<PyResult<_>>()?;
    Mesh::from_triangles(name, positions, triangles).map_err(|error| exception(error.into()))
}

/// Loads a scene.
pub type Load = Box<dyn FnOnce() -> Result<Scene> + Send>;

/// Loads a scene, and the checkpoint from which it goes on, if there is one.
type Begin = Box<dyn FnOnce() -> Result<(Scene, Option<Checkpoint>)> + Send>;

/// The name of a scene that has none, in messages, too.
const UNNAMED: &str = "scene";

/// A scene from Python: a text, the meshes that are in memory, and where relative paths begin.
struct Files {
    text: String,
    meshes: Vec<Option<Mesh>>,
    folder: PathBuf,
}

/// Takes a text with meshes from Python.
fn files_of(
    text: &Bound<'_, PyDict>,
    meshes: Vec<Option<(String, Arrays<'_>)>>,
    folder: PathBuf,
) -> PyResult<Files> {
    let text = to_toml(text)?.to_string_as_file()?;
    let mesh = |mesh: Option<(String, Arrays<'_>)>| {
        mesh.map(|(name, arrays)| mesh_of(&name, &arrays))
            .transpose()
    };
    let meshes: Vec<_> = meshes.into_iter().map(mesh).collect::<PyResult<_>>()?;
    Ok(Files {
        text,
        meshes,
        folder,
    })
}

/// Takes a scene from Python, a name or a path, or a text with meshes; loading it needs Python no more.
pub fn scene_from(
    scene: Option<PathBuf>,
    text: Option<&Bound<'_, PyDict>>,
    meshes: Vec<Option<(String, Arrays<'_>)>>,
    folder: PathBuf,
    overrides: Overrides,
) -> PyResult<Load> {
    if let Some(scene) = scene {
        return Ok(Box::new(move || Ok(Scene::load(&scene, &overrides)?)));
    }
    let text = text.ok_or_else(|| PyValueError::new_err("there is no scene"))?;
    let files = files_of(text, meshes, folder)?;
    Ok(Box::new(move || {
        let settings = Scene::read_text(Path::new(UNNAMED), &files.text, &overrides)?;
        scene_of(UNNAMED.to_owned(), settings, files.meshes, files.folder)
    }))
}

/// Opens a device.
pub fn open_device(device: Option<String>) -> Result<Arc<Context>> {
    Ok(Context::new(&ContextOptions {
        device,
        cache_folder: default_cache_folder(),
        ..ContextOptions::default()
    })?)
}

/// A scene in which some meshes are in memory.
fn scene_of(
    name: String,
    settings: Settings,
    meshes: Vec<Option<Mesh>>,
    folder: PathBuf,
) -> Result<Scene> {
    if meshes.iter().all(Option::is_none) {
        return Ok(Scene::from_settings(name, settings, folder)?);
    }
    let mut all = Vec::new();
    for (object, mesh) in settings.objects.iter().zip(meshes) {
        all.push(match mesh {
            Some(mesh) => mesh,
            None => Mesh::open(&object.mesh, &folder)?,
        });
    }
    if all.len() != settings.objects.len() {
        return Err(Error::Invalid(format!(
            "the scene has {} objects, and meshes for {}",
            settings.objects.len(),
            all.len()
        )));
    }
    Ok(Scene::from_meshes(name, settings, all, folder)?)
}

/// A checkpoint, and the scene with which it goes on: its own values, with those of `set` over them. Of `files` it takes meshes, maps and
/// masks alone.
fn resumed(
    path: &Path,
    files: Option<Files>,
    set: &[String],
) -> Result<(Scene, Option<Checkpoint>)> {
    let mut checkpoint = Checkpoint::read(path)?;
    let mut then = Scene::read_text(path, &checkpoint.scene, &Overrides::default())?;
    let name = path.file_stem().unwrap_or(path.as_os_str());
    let name = name.to_string_lossy().into_owned();
    let (meshes, folder) = match files {
        Some(files) => {
            let unnamed = Path::new(UNNAMED);
            let mut here = Scene::read_text(unnamed, &files.text, &Overrides::default())?;
            Scene::make_paths_whole(&mut here, &files.folder);
            take_files(&here, &mut then)?;
            (files.meshes, files.folder)
        }
        // Its paths are absolute, except those with names that are not Unicode.
        None => {
            let folder = path.parent().map(Path::to_owned).unwrap_or_default();
            (Vec::new(), folder)
        }
    };
    let settings = changed(&name, &then, set)?;
    // In another process, the same picture in memory is a file of the same name elsewhere.
    for (before, now) in [
        (
            &mut then.particles.start_mask,
            &settings.particles.start_mask,
        ),
        (&mut then.areas.map, &settings.areas.map),
        (&mut then.second_look.map, &settings.second_look.map),
    ] {
        if Path::new(&*before).file_name() == Path::new(now).file_name() {
            before.clone_from(now);
        }
    }
    checkpoint.scene = then.to_toml();
    let scene = scene_of(name, settings, meshes, folder)?;
    Ok((scene, Some(checkpoint)))
}

/// Takes the places of meshes, and of maps and masks where there are some, from the settings of a scene with as many objects.
fn take_files(from: &Settings, settings: &mut Settings) -> Result<()> {
    let [here, then] = [from.objects.len(), settings.objects.len()];
    if here != then {
        return Err(Error::Invalid(format!(
            "cannot continue from this checkpoint: the scene here has {here} objects, and it was written with {then}"
        )));
    }
    let take = |file: &String, own: &mut String| {
        if !file.is_empty() {
            own.clone_from(file);
        }
    };
    for (object, own) in from.objects.iter().zip(&mut settings.objects) {
        take(&object.mesh, &mut own.mesh);
        take(&object.start.mask, &mut own.start.mask);
    }
    take(
        &from.particles.start_mask,
        &mut settings.particles.start_mask,
    );
    take(&from.areas.map, &mut settings.areas.map);
    take(&from.second_look.map, &mut settings.second_look.map);
    Ok(())
}

/// Loads a scene, opens a device and puts the scene on it, on another thread, and asks Python for signals meanwhile. After Ctrl-C the work
/// ends where it can be cancelled next. The calling thread is detached from Python.
fn set_up(begin: Begin, device: Option<String>) -> PyResult<(Running, Vec<String>)> {
    let cancelled = Arc::new(AtomicBool::new(false));
    let (working, ended) = mpsc::channel::<()>();
    let flag = Arc::clone(&cancelled);
    let work = move || {
        // It is dropped when the work ends, in whatever way.
        let _working = working;
        open(begin, device, &flag)
    };
    let named = thread::Builder::new().name("myxo set-up".to_owned());
    let thread = named.spawn(work)?;
    while let Err(RecvTimeoutError::Timeout) = ended.recv_timeout(ASKS_AT_SET_UP_EVERY) {
        if let Err(signal) = Python::attach(|py| py.check_signals()) {
            cancelled.store(true, Ordering::Relaxed);
            // What was made until then is dropped.
            drop(thread.join());
            return Err(signal);
        }
    }
    match thread.join() {
        Ok(opened) => opened.map_err(exception),
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

/// Opens a device and puts a scene on it; what differs from its checkpoint.
fn open(
    begin: Begin,
    device: Option<String>,
    cancelled: &AtomicBool,
) -> Result<(Running, Vec<String>)> {
    let (scene, checkpoint) = begin()?;
    let ctx = open_device(device)?;
    memory::check(ctx.info(), &scene)?;
    let cache = default_cache_folder().map(|folder| folder.join("atlases"));
    let control = Control {
        cancelled: Some(cancelled),
        cache: cache.as_deref(),
        ..Control::default()
    };
    let mut simulation = Simulation::with_control(&ctx, &scene, &control)?;
    let mut notes = Vec::new();
    if let Some(checkpoint) = checkpoint {
        notes = (checkpoint.check(&scene, simulation.setup())).map_err(|problem| {
            Error::Invalid(format!("cannot continue from this checkpoint: {problem}"))
        })?;
        simulation.restore(&checkpoint.snapshot)?;
    }
    let running = Running {
        frames: Frames::new(&ctx, FRAMES_IN_FLIGHT)?,
        ctx,
        scene,
        simulation,
        renderer: None,
        canvas: None,
    };
    Ok((running, notes))
}

/// Draws a picture; its bytes.
fn draw(
    running: &mut Running,
    size: [u32; 2],
    set: &[String],
    transparent: bool,
    passes: u32,
) -> Result<Vec<u8>> {
    let Running {
        ctx,
        scene,
        simulation,
        frames,
        renderer,
        canvas,
    } = running;
    let settings = changed(&scene.name, simulation.settings(), set)?;
    if let Some(why) = settings.picture.show.why_not(&settings) {
        return Err(Error::Invalid(format!(
            "the view {} cannot be shown: {why}",
            settings.picture.show.title()
        )));
    }
    if settings.picture.show.has(Part::Distances) && simulation.state().near.reach == 0.0 {
        return Err(Error::Invalid(format!(
            "the view {} cannot be shown yet: distances are taken by a step; call step() first",
            settings.picture.show.title()
        )));
    }
    let kept = std::mem::replace(&mut scene.settings, settings);
    let mut view = View::of(scene, UVec2::from_array(size).as_vec2());
    scene.settings = kept;
    view.is_transparent = transparent;
    if renderer.is_none() {
        *renderer = Some(Renderer::new(ctx, simulation.setup(), offscreen::FORMAT)?);
    }
    let renderer = renderer.as_mut().expect("it was made");
    let too_large = |error| offscreen::too_large(size, "`width` or `height`", error);
    if canvas
        .as_ref()
        .is_none_or(|canvas| canvas.canvas().size() != size)
    {
        *canvas = None;
        *canvas = Some(Offscreen::new(ctx, size).map_err(too_large)?);
    }
    let canvas = canvas.as_ref().expect("it was made");
    let mut mean = match passes {
        1 => None,
        _ => Some(Mean::new(ctx, size).map_err(too_large)?),
    };
    let cameras = std::iter::repeat_n(view.camera, passes as usize);
    for (number, view) in (1..).zip(offscreen::passes(view, cameras, size)) {
        let mut rec = frames.begin()?;
        simulation.record_poses(&mut rec);
        renderer.draw_beside(&mut rec, simulation.state(), &[(view, canvas.canvas())]);
        if let Some(mean) = &mut mean {
            mean.record(&mut rec, canvas.canvas().image());
        }
        if number == passes {
            canvas.record_readback(&mut rec);
        }
        frames.submit(rec)?;
    }
    frames.wait_idle()?;
    let mut picture = canvas.image();
    if transparent {
        offscreen::unmultiply(&mut picture);
    }
    Ok(picture.into_raw())
}
