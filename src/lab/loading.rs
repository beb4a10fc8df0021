//! A scene that is made ready on another thread, while the window goes on.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use std::path::PathBuf;

use myxo::gpu::{DeviceInfo, DeviceKind};
use myxo::mesh::atlas::{AtlasError, Control};
use myxo::plain_text::Shown as _;
use myxo::render::Prepared;
use myxo::scene::{Overrides, Scene};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::{Setup, Simulation};
use myxo::{Error, Result};

use crate::lab::facts::Waiting;
use crate::lab::saving::SceneFile;
use crate::lab::worker::joined;
use crate::room;

/// The shares of all work that are done when meshes are read, and when the scene is set up: as with `gears` on two cores.
const READ: f32 = 0.02;
const SET_UP: f32 = 0.82;

/// What is to be shown.
pub struct Opened {
    /// With its meshes.
    pub scene: Scene,
    /// It goes on from here.
    pub from: Option<(PathBuf, Arc<Checkpoint>)>,
    /// The scene file that it was read from.
    pub file: Option<SceneFile>,
}

impl From<Scene> for Opened {
    fn from(scene: Scene) -> Self {
        Self {
            scene,
            from: None,
            file: None,
        }
    }
}

impl Opened {
    /// What was written into a checkpoint, by its own scene.
    pub fn resumed(path: PathBuf, overrides: &Overrides) -> Result<Self> {
        let checkpoint = Checkpoint::read(&path)?;
        Ok(Self {
            scene: checkpoint.own_scene(&path, overrides)?,
            from: Some((path, Arc::new(checkpoint))),
            file: None,
        })
    }
}

/// What a device needs to begin.
pub struct Loaded {
    /// With its meshes.
    pub scene: Scene,
    /// Atlas, particles, tables.
    pub setup: Setup,
    /// What pictures need of it.
    pub prepared: Prepared,
    /// The state that it goes on from, and what differs since.
    pub from: Option<(Arc<Checkpoint>, Vec<String>)>,
    /// The scene file that it was read from.
    pub file: Option<SceneFile>,
}

/// Where a scene on its way comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The one that is shown, from the beginning, as it is edited.
    Shown,
    /// Another one, with a view of its own, that lies in a file or is built in.
    File,
    /// Another one that no file has.
    NoFile,
}

/// A scene on its way. Dropping it lets the thread end by itself, as soon as it looks.
pub struct Loading {
    /// What the user calls it.
    pub name: String,
    /// Where it comes from.
    pub origin: Origin,
    /// What is being done, and the share of all that is done, 0 to 1.
    told: Arc<Mutex<(&'static str, f32)>>,
    cancelled: Arc<AtomicBool>,
    worker: Option<JoinHandle<Result<Loaded>>>,
}

impl Loading {
    /// Begins to load; `load` reads the scene's files. Layouts that take long to make are kept in `atlases`.
    pub fn begin<T: Into<Opened>>(
        name: String,
        origin: Origin,
        info: &DeviceInfo,
        atlases: Option<PathBuf>,
        load: impl FnOnce() -> Result<T> + Send + 'static,
    ) -> Self {
        let told = Arc::new(Mutex::new(("reading meshes", 0.0)));
        let cancelled = Arc::new(AtomicBool::new(false));
        let (tell, stop, info) = (Arc::clone(&told), Arc::clone(&cancelled), info.clone());
        let worker = thread::spawn(move || {
            let Opened { scene, from, file } = load()?.into();
            room::check(&info, &scene)?;
            let control = Control {
                progress: Some(&|doing, done| {
                    *tell.lock().unwrap_or_else(PoisonError::into_inner) = (doing, done);
                }),
                cancelled: Some(&stop),
                cache: atlases.as_deref(),
            };
            let setup = control.part(READ..SET_UP, |control| {
                Simulation::set_up(&info, &scene, control)
            })?;
            if stop.load(Ordering::Relaxed) {
                return Err(AtlasError::Cancelled.into());
            }
            let from = from.map(|(path, checkpoint)| {
                let fits = checkpoint.check(&scene, &setup);
                let changes = fits.map_err(|problem| {
                    Error::Invalid(format!("cannot resume from {}: {problem}", path.shown()))
                })?;
                Ok::<_, Error>((checkpoint, changes))
            });
            let from = from.transpose()?;
            let prepared = control.part(SET_UP..1.0, |control| {
                Prepared::with_control(&setup, control)
            })?;
            let prepared = match info.kind {
                DeviceKind::Cpu => prepared.quick(&setup),
                _ => prepared,
            };
            Ok(Loaded {
                scene,
                setup,
                prepared,
                from,
                file,
            })
        });
        Self {
            name,
            origin,
            told,
            cancelled,
            worker: Some(worker),
        }
    }

    /// How far it is, for the interface.
    pub fn told(&self) -> Waiting {
        let (doing, done) = *self.told.lock().unwrap_or_else(PoisonError::into_inner);
        Waiting {
            name: self.name.clone(),
            doing,
            done,
            is_cancelled: self.cancelled.load(Ordering::Relaxed),
        }
    }

    /// Asks the thread to end; it does with [`AtlasError::Cancelled`].
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// What came of it, once, when it has ended.
    pub fn take(&mut self) -> Option<Result<Loaded>> {
        let worker = self.worker.take_if(|worker| worker.is_finished())?;
        Some(joined(&format!("loading {}", self.name), worker))
    }
}

impl Drop for Loading {
    fn drop(&mut self) {
        self.cancel();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::gpu::{Context, ContextOptions, Frames};
    use std::path::Path;
    use std::sync::mpsc;
    use std::time::{Duration, Instant};

    fn ended(loading: &mut Loading) -> Result<Loaded> {
        let begun = Instant::now();
        let mut done = 0.0;
        loop {
            let now = loading.told().done;
            assert!(now >= done, "{done} is followed by {now}");
            done = now;
            if let Some(result) = loading.take() {
                assert!(result.is_err() || loading.told().done == 1.0);
                return result;
            }
            assert!(begun.elapsed() < Duration::from_secs(120), "it hangs");
            thread::sleep(Duration::from_millis(2));
        }
    }

    fn context() -> Option<Arc<Context>> {
        match Context::new(&ContextOptions::default()) {
            Ok(ctx) => Some(ctx),
            Err(error) if std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() => {
                eprintln!("skipped: {error}");
                None
            }
            Err(error) => panic!("{error}"),
        }
    }

    #[test]
    fn a_panic_on_the_way_is_an_error() {
        let Some(ctx) = context() else { return };
        let name = "knot".to_owned();
        let load = || -> Result<Scene> { panic!("there is a knot in it") };
        let mut loading = Loading::begin(name, Origin::File, ctx.info(), None, load);
        let error = ended(&mut loading).err().expect("it has failed");
        let error = error.to_string();
        assert!(
            error.contains("loading knot has failed: there is a knot in it"),
            "{error}"
        );
    }

    #[test]
    fn a_checkpoint_goes_on_with_its_own_scene_or_says_why_not() {
        let Some(ctx) = context() else { return };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grown.ckpt");
        let overrides = |set: &[&str]| Overrides {
            set: set.iter().map(|text| (*text).to_owned()).collect(),
            ..Overrides::default()
        };
        let small = overrides(&["particles.count=500", "atlas.size=64"]);
        let scene = Scene::load(Path::new("cube"), &small).unwrap();
        let control = Control::default();
        let mut simulation = Simulation::with_control(&ctx, &scene, &control).unwrap();
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let mut rec = frames.begin().unwrap();
        (0..3).for_each(|_| simulation.record_step(&mut rec));
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        let snapshot = simulation.snapshot().unwrap();
        let checkpoint = Checkpoint::new(&scene, simulation.setup(), snapshot);
        checkpoint.write(&path).unwrap();
        assert!(Checkpoint::is_one(&path) && !Checkpoint::is_one(folder.path()));
        let opened = |set: &[&str]| {
            let opened = Opened::resumed(path.clone(), &overrides(set)).unwrap();
            assert_eq!(opened.scene.name, "grown");
            let name = opened.scene.name.clone();
            let load = move || Ok(opened);
            ended(&mut Loading::begin(
                name,
                Origin::File,
                ctx.info(),
                None,
                load,
            ))
        };
        let loaded = opened(&["trail.decay=0.5"]).unwrap();
        assert_eq!(loaded.scene.settings.particles.count, 500);
        let (checkpoint, changes) = loaded.from.expect("it goes on");
        assert_eq!(checkpoint.snapshot.step, 3);
        assert_eq!(changes.len(), 1);
        assert!(changes[0].starts_with("trail.decay = 0.5"), "{changes:?}");
        let error = opened(&["atlas.size=128"]).err().expect("it is another");
        let error = error.to_string();
        assert!(
            error.contains("cannot resume from") && error.contains("grown.ckpt"),
            "{error}"
        );
    }

    #[test]
    fn scenes_arrive_or_are_cancelled() {
        let Some(ctx) = context() else { return };
        let load = || {
            let set = ["particles.count=500", "atlas.size=64"].map(str::to_owned);
            let overrides = Overrides {
                set: set.into(),
                ..Overrides::default()
            };
            Ok(Scene::load(Path::new("cube"), &overrides)?)
        };
        let begin = |load| Loading::begin("cube".to_owned(), Origin::File, ctx.info(), None, load);
        let loaded = ended(&mut begin(Box::new(load) as Box<dyn FnOnce() -> _ + Send>)).unwrap();
        assert_eq!(loaded.setup.particles.len(), 500);

        // The thread is held until the wish to end is known.
        let (go, wait) = mpsc::channel::<()>();
        let mut loading = begin(Box::new(move || {
            wait.recv().expect("it is let go");
            load()
        }));
        assert!(loading.take().is_none() && !loading.told().is_cancelled);
        loading.cancel();
        assert!(loading.told().is_cancelled);
        go.send(()).expect("it waits");
        assert!(matches!(
            ended(&mut loading),
            Err(Error::Atlas(AtlasError::Cancelled))
        ));
    }
}
