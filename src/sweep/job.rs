//! One run of a sweep.

use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::picture::{Picture, drawn};
use super::row::Row;
use crate::error::{Error, Result};
use crate::export::network_columns;
use crate::gpu::{Context, Frames, default_cache_folder};
use crate::mesh::atlas::Control;
use crate::plain_text::escaped;
use crate::scene::parameters::{self, PARAMETERS};
use crate::scene::suggest::nearest;
use crate::scene::{Overrides, Scene};
use crate::sim::graph::network_of;
use crate::sim::network::Network;
use crate::sim::{Simulation, memory};

/// Steps that the host may be ahead of the device.
const FRAMES_IN_FLIGHT: usize = 2;

/// A run: a scene with the values of a point, for some steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Job {
    /// The number of the point.
    pub number: usize,
    /// Names the run: 16 hexadecimal digits of all that its result depends on.
    pub key: String,
    /// A built-in name or a path.
    pub scene: String,
    /// Steps to run.
    pub steps: u64,
    /// A preset's name or file.
    pub preset: Option<String>,
    /// Parameters of all runs.
    pub settings: Row,
    /// Parameters of this one, over those of all.
    pub point: Row,
    /// The seed.
    pub seed: u64,
    /// Width and height of its picture, pixels; none without one.
    pub picture: Option<[u32; 2]>,
    /// Does its row have measures of the network as a graph?
    #[serde(default)]
    pub network: bool,
}

/// What a run leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Finished {
    /// Its row.
    pub row: Row,
    /// Its picture, if it is to have one and did not fail.
    pub picture: Option<Picture>,
}

impl Job {
    /// The scene at this point.
    ///
    /// # Errors
    /// When a key is unknown, a value is not allowed, or a file cannot be read.
    pub fn scene(&self) -> Result<Scene> {
        let mut values = self.settings.clone();
        values.extend(&self.point);
        // JSON's values are also TOML's.
        let set = values.0.iter().map(|(key, value)| format!("{key}={value}"));
        let overrides = Overrides {
            preset: self.preset.clone(),
            set: set.collect(),
            seed: Some(self.seed),
        };
        Ok(Scene::load(self.scene.as_ref(), &overrides)?)
    }

    /// Does the run on a device, and returns its whole row, and its picture. An error is a row, too; one of the picture alone is none.
    #[must_use]
    pub fn run(&self, ctx: &Arc<Context>) -> Finished {
        let begun = Instant::now();
        let (mut found, error, picture) = match self.measured(ctx) {
            Ok((measures, picture)) => (measures, Value::Null, picture),
            Err(error) => (Row::default(), error.to_string().into(), None),
        };
        found.set("error", error);
        let milliseconds = begun.elapsed().as_millis() as f64;
        found.set("seconds", milliseconds / 1000.0);
        Finished {
            row: self.whole(&found),
            picture,
        }
    }

    /// A row for a run without a result.
    #[must_use]
    pub fn lost(&self, error: &str) -> Row {
        let mut found = Row::default();
        found.set("error", error);
        found.set("seconds", Value::Null);
        self.whole(&found)
    }

    /// A row with what was found: number, seed and point before it, the program's commit and the run's key after it.
    fn whole(&self, found: &Row) -> Row {
        let mut row = Row::default();
        row.set("run", self.number);
        row.set("seed", self.seed);
        row.extend(&self.point);
        row.extend(found);
        row.set("commit", json!(crate::commit()));
        row.set("key", &*self.key);
        row
    }

    /// The measures of the run, and its picture.
    fn measured(&self, ctx: &Arc<Context>) -> Result<(Row, Option<Picture>)> {
        let scene = self.scene()?;
        memory::check(ctx.info(), &scene)?;
        let cache = default_cache_folder().map(|folder| folder.join("atlases"));
        let control = Control {
            cache: cache.as_deref(),
            ..Control::default()
        };
        let mut simulation = Simulation::with_control(ctx, &scene, &control)?;
        let mut frames = Frames::new(ctx, FRAMES_IN_FLIGHT)?;
        for _ in 0..self.steps {
            let mut rec = frames.begin()?;
            rec.scope("step", |rec| simulation.record_step(rec));
            frames.submit(rec)?;
        }
        frames.wait_idle()?;
        let snapshot = simulation.snapshot()?;
        let mut row = Row::default();
        row.set("step", simulation.step());
        row.set("state_hash", format!("{:016x}", snapshot.hash()));
        let network = json!(Network::of(&snapshot, simulation.setup()));
        for name in [
            "particles",
            "mean_trail",
            "covered",
            "on_network",
            "length",
            "pieces",
            "regions",
        ] {
            row.set(name, network[name].clone());
        }
        if self.network {
            let poses = simulation.world_from_object();
            let (_, measures) = network_of(&snapshot.trail, simulation.setup(), &poses);
            for (name, value) in network_columns(&measures) {
                row.set(&format!("graph_{name}"), value);
            }
        }
        let info = ctx.info();
        let device = format!("{}, {} {}", info.name, info.driver, info.driver_version);
        row.set("device", device);
        let picture = self.picture.map(|size| {
            let drawn = drawn(ctx, &scene, &simulation, size);
            drawn.map_err(|error| error.to_string())
        });
        Ok((row, picture))
    }
}

/// Refuses parameters that do not exist; those of objects, foods and pulses are checked when a scene is read. `list` says what lists all.
///
/// # Errors
/// Names the first that does not exist, and the nearest that does.
pub fn check_keys<'a>(keys: impl IntoIterator<Item = &'a str>, list: &str) -> Result<()> {
    for key in keys {
        if key == "seed" {
            return Err(Error::Invalid(
                "`seed` is none of the parameters of a sweep: use `seeds`".to_owned(),
            ));
        }
        let of_list = ["object.", "food.", "pulse."]
            .iter()
            .any(|list| key.starts_with(list));
        if of_list || parameters::find(key).is_some() {
            continue;
        }
        let keys = PARAMETERS.iter().map(|parameter| parameter.key);
        let hint = match nearest(key, keys) {
            Some(near) => format!("; do you mean `{near}`?"),
            None => format!(": {list} lists them all"),
        };
        let key = escaped(key);
        return Err(Error::Invalid(format!(
            "there is no parameter `{key}`{hint}"
        )));
    }
    Ok(())
}
