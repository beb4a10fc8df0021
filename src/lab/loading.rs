//! A scene that is made ready on another thread while the window continues.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError, Weak};

use myxo::gpu::{Context, DeviceInfo, DeviceKind, Format};
use myxo::mesh::atlas::AtlasError;
use myxo::plain_text::Shown as _;
use myxo::render::Prepared;
use myxo::scene::{Overrides, Scene};
use myxo::sim::Simulation;
use myxo::sim::checkpoint::Checkpoint;
use myxo::{Error, Result};

use crate::lab::facts::LoadingFacts;
use crate::lab::job::{Handle, Job};
use crate::lab::saving::SceneFile;
use crate::lab::stage::{Loaded, Stage};
use crate::room;

/// The shares of all work that are done when meshes are read, when the scene is set up, and when its light is there: as with
/// `gears` on two cores. Pipelines take the rest.
const READ: f32 = 0.02;
const SET_UP: f32 = 0.78;
const LIT: f32 = 0.95;

/// The scene to be shown.
pub struct Opened {
    /// With its meshes.
    pub scene: Scene,
    /// The checkpoint that it continues from.
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
    /// Opens a checkpoint with the scene that is written into it.
    pub fn resumed(path: PathBuf, overrides: &Overrides) -> Result<Self> {
        let checkpoint = Checkpoint::read(&path)?;
        Ok(Self {
            scene: checkpoint.own_scene(&path, overrides)?,
            from: Some((path, Arc::new(checkpoint))),
            file: None,
        })
    }
}

/// A scene on the device, which has not run yet.
pub struct Ready {
    pub stage: Stage,
    /// The scene file that it was read from.
    pub file: Option<SceneFile>,
}

/// The origin of a scene on its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The scene that is shown, from step 0, as it is edited.
    Shown,
    /// Another scene, with a view of its own, from a file or built in.
    File,
    /// Another scene that no file has.
    NoFile,
}

/// The device for a scene on its way. The thread takes it when everything else is ready, and keeps this locked while it uses it.
type Device = Arc<Mutex<Option<Weak<Context>>>>;

/// A scene on its way. Dropping it lets its thread end as soon as it looks.
pub struct Loading {
    /// Its name in the interface.
    pub name: String,
    /// Its origin.
    pub origin: Origin,
    device: Device,
    job: Job<Ready>,
}

impl Loading {
    /// Begins to load a scene and to put it on a device, with pictures of this format; `load` reads the scene's files. Layouts that
    /// take long to make are kept in `atlases`.
    pub fn begin<T: Into<Opened>>(
        (name, origin): (String, Origin),
        (ctx, format): (&Arc<Context>, Format),
        atlases: Option<PathBuf>,
        load: impl FnOnce() -> Result<T> + Send + 'static,
    ) -> Self {
        let info = ctx.info().clone();
        let device: Device = Arc::new(Mutex::new(Some(Arc::downgrade(ctx))));
        let taken = Arc::clone(&device);
        let job = Job::begin(format!("loading {name}"), move |handle| {
            handle.report("reading meshes", 0.0);
            let Opened { scene, from, file } = load()?.into();
            let loaded = set_up(scene, from, &info, atlases.as_deref(), handle)?;
            let mut device = taken.lock().unwrap_or_else(PoisonError::into_inner);
            let ctx = device.take().and_then(|ctx| ctx.upgrade());
            let Some(ctx) = ctx.filter(|_| !handle.is_cancelled()) else {
                return Err(AtlasError::Cancelled.into());
            };
            let stage = Stage::new(&ctx, loaded, format)?;
            if handle.is_cancelled() {
                return Err(AtlasError::Cancelled.into());
            }
            handle.report("building pipelines", 1.0);
            Ok(Ready { stage, file })
        });
        Self {
            name,
            origin,
            device,
            job,
        }
    }

    /// Its progress, for the interface.
    pub fn facts(&self) -> LoadingFacts {
        LoadingFacts {
            name: self.name.clone(),
            progress: self.job.progress(),
            is_shown: self.origin == Origin::Shown,
        }
    }

    /// Was it cancelled?
    pub fn is_cancelled(&self) -> bool {
        self.job.is_cancelled()
    }

    /// Asks the thread to end; it does with [`AtlasError::Cancelled`].
    pub fn cancel(&self) {
        self.job.cancel();
    }

    /// Has its thread ended?
    pub fn has_ended(&self) -> bool {
        self.job.has_ended()
    }

    /// The result, once, when it has ended.
    pub fn take(&mut self) -> Option<Result<Ready>> {
        self.job.take()
    }

    /// Takes the device from the thread, and waits for a thread that uses it. The load then gives no scene.
    pub fn leave_device(&mut self) {
        let mut device = self.device.lock().unwrap_or_else(PoisonError::into_inner);
        if device.take().is_none() {
            drop(device);
            drop(self.job.wait());
        }
    }
}

/// Makes all of a scene that is made without a device.
fn set_up(
    scene: Scene,
    from: Option<(PathBuf, Arc<Checkpoint>)>,
    info: &DeviceInfo,
    atlases: Option<&Path>,
    handle: &Handle,
) -> Result<Loaded> {
    room::check(info, &scene)?;
    let setup = handle.control(atlases, |control| {
        control.part(READ..SET_UP, |control| {
            Simulation::set_up(info, &scene, control)
        })
    })?;
    if handle.is_cancelled() {
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
    let prepared = handle.control(atlases, |control| {
        control.part(SET_UP..LIT, |control| {
            Prepared::with_control(&setup, control)
        })
    })?;
    let prepared = match info.kind {
        DeviceKind::Cpu => prepared.quick(&setup),
        _ => prepared,
    };
    handle.report("building pipelines", LIT);
    Ok(Loaded {
        scene,
        setup,
        prepared,
        from,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::on_device::{FORMAT, context, run, scene};
    use myxo::gpu::Frames;

    use std::sync::mpsc;
    use std::thread;
    use std::time::{Duration, Instant};

    const TINY: [&str; 2] = ["particles.count=500", "atlas.size=64"];

    fn ended(loading: &mut Loading) -> Result<Ready> {
        let begun = Instant::now();
        let mut done = 0.0;
        loop {
            let now = loading.facts().progress.done;
            assert!(now >= done, "{done} is followed by {now}");
            done = now;
            if let Some(result) = loading.take() {
                assert!(result.is_err() || loading.facts().progress.done == 1.0);
                return result;
            }
            assert!(begun.elapsed() < Duration::from_secs(120), "it hangs");
            thread::sleep(Duration::from_millis(2));
        }
    }

    #[test]
    fn a_panic_on_the_way_is_an_error() {
        let Some(ctx) = context() else { return };
        let name = "knot".to_owned();
        let load = || -> Result<Scene> { panic!("there is a knot in it") };
        let mut loading = Loading::begin((name, Origin::File), (&ctx, FORMAT), None, load);
        let error = ended(&mut loading).err().expect("it has failed");
        let error = error.to_string();
        assert!(
            error.contains("loading knot has failed: there is a knot in it"),
            "{error}"
        );
    }

    #[test]
    fn a_checkpoint_continues_with_its_own_scene_or_says_why_not() {
        let Some(ctx) = context() else { return };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grown.ckpt");
        let overrides = |set: &[&str]| Overrides {
            set: set.iter().map(|text| (*text).to_owned()).collect(),
            ..Overrides::default()
        };
        let scene = scene("cube", &TINY);
        let mut simulation = Simulation::new(&ctx, &scene).unwrap();
        let mut frames = Frames::new(&ctx, 1).unwrap();
        run(&mut frames, &mut simulation, 3);
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
                (name, Origin::File),
                (&ctx, FORMAT),
                None,
                load,
            ))
        };
        let Ready { stage, .. } = opened(&["trail.decay=0.5"]).unwrap();
        assert_eq!(stage.scene.settings.particles.count, 500);
        assert_eq!(stage.simulation.step(), 3);
        let resumed = stage.resumed.expect("it continues");
        let start = "Continues from step 3; trail.decay = 0.5";
        assert!(resumed.starts_with(start), "{resumed}");
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
        let load = || Ok(scene("cube", &TINY));
        let begin = |load| {
            let name = "cube".to_owned();
            Loading::begin((name, Origin::File), (&ctx, FORMAT), None, load)
        };
        let loaded = ended(&mut begin(Box::new(load) as Box<dyn FnOnce() -> _ + Send>)).unwrap();
        assert_eq!(loaded.stage.simulation.setup().particles.len(), 500);

        // The thread is held until the wish to end is known.
        let (go, wait) = mpsc::channel::<()>();
        let mut loading = begin(Box::new(move || {
            wait.recv().expect("the thread may continue");
            load()
        }));
        assert!(loading.take().is_none() && !loading.is_cancelled());
        loading.cancel();
        assert!(loading.facts().progress.is_cancelled);
        go.send(()).expect("it waits");
        assert!(matches!(
            ended(&mut loading),
            Err(Error::Atlas(AtlasError::Cancelled))
        ));
    }

    #[test]
    fn a_scene_that_is_given_up_leaves_the_device() {
        let Some(ctx) = context() else { return };
        let tiny = || Ok(scene("cube", &TINY));
        let begin = |load: Box<dyn FnOnce() -> Result<Scene> + Send>| {
            let names = ("cube".to_owned(), Origin::File);
            Loading::begin(names, (&ctx, FORMAT), None, load)
        };
        // Before it has read anything: it is not waited for.
        let (go, wait) = mpsc::channel::<()>();
        let mut loading = begin(Box::new(move || {
            wait.recv().expect("the thread may continue");
            tiny()
        }));
        loading.leave_device();
        go.send(()).expect("it waits");
        let none = ended(&mut loading).err().expect("it has no device");
        assert!(matches!(none, Error::Atlas(AtlasError::Cancelled)));
        // When it is on the device.
        let mut loading = begin(Box::new(tiny));
        let begun = Instant::now();
        while !loading.job.has_ended() {
            assert!(begun.elapsed() < Duration::from_secs(120), "it hangs");
            thread::sleep(Duration::from_millis(2));
        }
        assert!(Arc::strong_count(&ctx) > 1);
        loading.leave_device();
        assert_eq!(Arc::strong_count(&ctx), 1);
    }
}
