//! A scene that is made ready on another thread, while the window goes on.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use std::path::PathBuf;

use myxo::Result;
use myxo::gpu::{DeviceInfo, DeviceKind};
use myxo::mesh::atlas::{AtlasError, Control};
use myxo::render::Prepared;
use myxo::scene::Scene;
use myxo::sim::{Setup, Simulation};

use super::interface::Waiting;
use super::worker::joined;

/// What a device needs to begin.
pub struct Loaded {
    /// With its meshes.
    pub scene: Scene,
    /// Atlas, particles, tables.
    pub setup: Setup,
    /// What pictures need of it.
    pub prepared: Prepared,
}

/// Where a scene on its way comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The one that is shown, from the beginning, as it is edited.
    Shown,
    /// Another one, with a view of its own, that lies in a file or is built in.
    File,
    /// Another one that no file has.
    Clipboard,
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
    pub fn begin(
        name: String,
        origin: Origin,
        info: &DeviceInfo,
        atlases: Option<PathBuf>,
        load: impl FnOnce() -> Result<Scene> + Send + 'static,
    ) -> Self {
        let told = Arc::new(Mutex::new(("reading", 0.0)));
        let cancelled = Arc::new(AtomicBool::new(false));
        let (tell, stop, info) = (Arc::clone(&told), Arc::clone(&cancelled), info.clone());
        let worker = thread::spawn(move || {
            let scene = load()?;
            let control = Control {
                progress: Some(&|doing, done| {
                    *tell.lock().unwrap_or_else(PoisonError::into_inner) = (doing, done);
                }),
                cancelled: Some(&stop),
                cache: atlases.as_deref(),
            };
            let setup = Simulation::set_up(&info, &scene, &control)?;
            if stop.load(Ordering::Relaxed) {
                return Err(AtlasError::Cancelled.into());
            }
            *tell.lock().unwrap_or_else(PoisonError::into_inner) = ("light", 1.0);
            let prepared = match info.kind {
                DeviceKind::Cpu => Prepared::for_quick(&setup),
                _ => Prepared::new(&setup),
            };
            Ok(Loaded {
                scene,
                setup,
                prepared,
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
    use myxo::Error;
    use myxo::gpu::{Context, ContextOptions};
    use myxo::scene::Overrides;
    use std::path::Path;
    use std::sync::mpsc;
    use std::time::{Duration, Instant};

    fn ended(loading: &mut Loading) -> Result<Loaded> {
        let begun = Instant::now();
        loop {
            if let Some(result) = loading.take() {
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
        let load = || panic!("there is a knot in it");
        let mut loading = Loading::begin(name, Origin::File, ctx.info(), None, load);
        let error = ended(&mut loading).err().expect("it has failed");
        let error = error.to_string();
        assert!(
            error.contains("loading knot has failed: there is a knot in it"),
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
