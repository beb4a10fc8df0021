//! The way back to an earlier state: one state that was left, by a reset or for another scene, is kept in memory with
//! everything needed to continue from it.

use std::path::PathBuf;
use std::sync::Arc;

use myxo::Result;
use myxo::mesh::Mesh;
use myxo::render::View;
use myxo::scene::Scene;
use myxo::scene::settings::Settings;
use myxo::sim::Snapshot;
use myxo::sim::checkpoint::Checkpoint;

use crate::lab::document::put_look;
use crate::lab::loading::Opened;
use crate::lab::objects::begin_on_food_that_is;
use crate::lab::saving::SceneFile;
use crate::lab::stage::Stage;
use crate::lab::state_copy::{StateCopy, bytes_of};

/// Before this step nothing has grown that would be missed.
const GROWN_AT: u64 = 100;

/// How the scene was shown when it was left.
#[derive(Clone)]
pub struct Shown {
    /// Which of the scenes of this window it was: to return to it is no change of the scene.
    pub scene: u64,
    pub view: View,
    /// The camera kept the scene fitted into the picture.
    pub fits: bool,
    /// As it was loaded.
    pub loaded: Settings,
    /// The file in which it was saved or from which it was opened.
    pub file: Option<SceneFile>,
    /// No file had all of it.
    pub is_unsaved: bool,
}

/// A state that was left.
#[derive(Clone)]
pub struct Grown {
    pub shown: Shown,
    pub state: Arc<GrownState>,
}

/// Everything needed to continue.
pub struct GrownState {
    pub name: String,
    pub folder: PathBuf,
    /// The settings that it ran with.
    pub settings: Settings,
    pub meshes: Vec<Mesh>,
    pub checkpoint: Arc<Checkpoint>,
}

impl GrownState {
    /// The scene from its beginning, of these meshes.
    fn scene(&self, meshes: Vec<Mesh>) -> Result<Scene> {
        let (name, folder) = (self.name.clone(), self.folder.clone());
        Ok(Scene::from_meshes(
            name,
            self.settings.clone(),
            meshes,
            folder,
        )?)
    }

    pub fn bytes(&self) -> u64 {
        let Snapshot {
            particles, trail, ..
        } = &self.checkpoint.snapshot;
        bytes_of(particles.len(), trail.len())
    }
}

impl Grown {
    /// Takes the state of a stage that is about to go, with its meshes.
    pub fn of(left: &mut Stage, shown: Shown) -> Result<Self> {
        let snapshot = left.simulation.snapshot()?;
        let mut settings = left.simulation.settings().clone();
        // Food comes and goes while the scene runs, and where it began no longer matters.
        begin_on_food_that_is(&mut settings);
        left.scene.settings.clone_from(&settings);
        let checkpoint = Checkpoint::new(&left.scene, left.simulation.setup(), snapshot);
        let state = GrownState {
            name: left.scene.name.clone(),
            folder: left.scene.folder.clone(),
            settings,
            checkpoint: Arc::new(checkpoint),
            meshes: std::mem::take(&mut left.scene.meshes),
        };
        Ok(Self {
            shown,
            state: Arc::new(state),
        })
    }

    /// The size of a copy of this stage's state, bytes.
    pub fn bytes_of(stage: &Stage) -> u64 {
        StateCopy::bytes_of(stage)
    }

    /// The scene that continues from this state; as another scene, it brings its view along.
    pub fn opened(&self, is_another: bool) -> Result<Opened> {
        let state = &self.state;
        let mut scene = state.scene(state.meshes.clone())?;
        if is_another {
            put_look(&self.shown.view, scene.center, &mut scene.settings);
        }
        let from = (PathBuf::from(&state.name), Arc::clone(&state.checkpoint));
        Ok(Opened {
            scene,
            from: Some(from),
            file: self.shown.file.clone(),
        })
    }
}

/// The state that can come back. At most one is kept, because it may be large.
#[derive(Default)]
pub struct Back {
    pub grown: Option<Grown>,
    /// The state that is on its way.
    pub coming: Option<Grown>,
    /// Scenes that were shown before the present one.
    pub scenes: u64,
}

impl Back {
    /// Is the state of this stage kept when it is left? A stage that has hardly grown is kept only if it is left to go back.
    pub fn is_kept(&self, left: &Stage, goes_back: bool) -> bool {
        goes_back || left.simulation.step() >= GROWN_AT
    }

    /// Something else is on its way.
    pub fn stays(&mut self) {
        self.coming = None;
    }

    /// The state that was on its way has arrived.
    pub fn take_coming(&mut self) -> Option<Grown> {
        self.coming.take()
    }

    /// The scene that is shown now is saved, in this file if in one of its own: there, what had grown of it is not.
    pub fn saved(&mut self, file: Option<&SceneFile>) {
        let grown = self.grown.as_mut();
        if let Some(Grown { shown, .. }) = grown.filter(|grown| grown.shown.scene == self.scenes) {
            shown.is_unsaved = true;
            shown.file = file.cloned();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::loading::{Loading, Origin};
    use crate::lab::on_device::{FORMAT, SMALL, context, run, stage};

    use glam::Vec2;
    use myxo::gpu::Frames;
    use myxo::mesh::atlas::Control;

    use myxo::scene::settings::Show;
    use myxo::sim::Simulation;
    use std::path::Path;
    use std::time::{Duration, Instant};

    #[test]
    fn an_earlier_state_continues_as_it_was_left() {
        let Some(ctx) = context() else { return };
        let mut stage = stage(&ctx, "pair", &SMALL);
        // Changes made on the way are part of it.
        let mut settings = stage.simulation.settings().clone();
        settings.trail.decay = 0.77;
        stage.simulation.apply(&settings).unwrap();
        let mut frames = Frames::new(&ctx, 1).unwrap();
        run(&mut frames, &mut stage.simulation, 5);
        let mut bias = vec![0.0; stage.simulation.setup().atlas.texel_count()];
        bias[7] = 2.5;
        stage.simulation.set_areas(&bias).unwrap();
        let state = stage.simulation.snapshot().unwrap();

        let mut view = View::of(&stage.scene, Vec2::ONE);
        view.show = Show::Relief;
        let shown = Shown {
            scene: 0,
            view,
            fits: false,
            loaded: stage.scene.settings.clone(),
            file: Some(SceneFile::saved(Path::new("/pair.toml"))),
            is_unsaved: false,
        };
        let grown = Grown::of(&mut stage, shown).unwrap();
        drop(stage);
        for (is_another, show) in [(false, Show::default()), (true, Show::Relief)] {
            let opened = grown.opened(is_another).unwrap();
            assert_eq!(opened.file, grown.shown.file, "it is saved where it was");
            assert_eq!(opened.scene.settings.trail.decay, 0.77);
            assert_eq!(View::of(&opened.scene, Vec2::ONE).show, show);
            let load = move || Ok(opened);
            let name = "pair".to_owned();
            let mut loading = Loading::begin((name, Origin::Shown), (&ctx, FORMAT), None, load);
            let begun = Instant::now();
            let ready = loop {
                if let Some(ready) = loading.take() {
                    break ready.unwrap();
                }
                assert!(begun.elapsed() < Duration::from_secs(120), "it hangs");
                std::thread::sleep(Duration::from_millis(2));
            };
            let stage = ready.stage;
            assert_eq!(stage.resumed.as_deref(), Some("Continues from step 5"));
            assert_eq!(stage.simulation.snapshot().unwrap(), state);
        }
        // A state of the same scene that is saved meanwhile is another state.
        let mut back = Back {
            grown: Some(grown.clone()),
            ..Back::default()
        };
        let other = SceneFile::saved(Path::new("/other.toml"));
        let kept = |back: &Back| {
            let shown = back.grown.as_ref().map(|grown| &grown.shown);
            shown.map(|shown| (shown.is_unsaved, shown.file.clone()))
        };
        back.scenes = 1;
        back.saved(Some(&other));
        assert_eq!(kept(&back), Some((false, grown.shown.file.clone())));
        back.scenes = 0;
        back.saved(Some(&other));
        assert_eq!(kept(&back), Some((true, Some(other))));
        // Meshes that are others by now are no ground for it.
        let mut others = grown.state.meshes.clone();
        others.swap(0, 1);
        let scene = grown.state.scene(others).unwrap();
        let setup = Simulation::set_up(ctx.info(), &scene, &Control::default()).unwrap();
        assert!(grown.state.checkpoint.check(&scene, &setup).is_err());
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
