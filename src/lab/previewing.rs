//! Previews of looks on the running scene: it runs with the look for a while and is then what it was before, to the bit. The state from
//! before stays on the device meanwhile, so neither the beginning nor the end waits for a copy to the host.

use std::sync::Arc;

use myxo::Result;
use myxo::gpu::Frames;
use myxo::scene::parameters::PARAMETERS;
use myxo::scene::presets::is_look;
use myxo::scene::settings::Settings;
use myxo::sim::StateAside;

use crate::lab::facts::NetworkFacts;
use crate::lab::stage::Stage;

/// States of more bytes are not copied, because a copy takes memory and time: of their looks only the colours are previewed.
pub const MOST_BYTES: u64 = 128 << 20;

/// A preview under way.
pub struct Previewing {
    /// The state from which it began, and to which it returns.
    before: StateAside,
    /// The settings that ran then.
    settings: Settings,
    /// Steps taken then, and seconds of the objects' motion, if any moves.
    stands_at: (u64, Option<f64>),
    /// The look as it was asked for.
    look: Settings,
    /// The network of that state, whose lines are shown again then.
    pub network: Option<Arc<NetworkFacts>>,
}

impl Previewing {
    /// Runs a stage with another look from now on. Food stays as it is, because other food has to be measured first. No step may be
    /// under way.
    pub fn begin(stage: &mut Stage, frames: &mut Frames, look: &Settings) -> Result<Self> {
        let stands_at = (stage.simulation.step(), stage.seconds());
        let settings = stage.simulation.settings().clone();
        let mut rec = frames.begin()?;
        let before = stage.simulation.record_aside(&mut rec)?;
        frames.submit(rec)?;
        // The picture stays: so far nothing has changed but what steps do.
        stage.simulation.apply(&with_look(&settings, look))?;
        Ok(Self {
            before,
            settings,
            stands_at,
            look: look.clone(),
            network: None,
        })
    }

    /// Everything is as it was. No step may be under way.
    pub fn end(&self, stage: &mut Stage, frames: &mut Frames) -> Result<()> {
        stage.simulation.apply(&self.settings)?;
        let mut rec = frames.begin()?;
        stage.simulation.record_back(&mut rec, &self.before)?;
        frames.submit(rec)?;
        stage.owe_picture();
        Ok(())
    }

    /// Does it run with this look?
    pub fn has(&self, look: &Settings) -> bool {
        self.look == *look
    }

    /// Has it taken steps?
    pub fn has_stepped(&self, stage: &Stage) -> bool {
        stage.simulation.step() > self.stands_at.0
    }

    /// The step at which the scene is without the preview, and the time of its objects.
    pub fn stands_at(&self) -> (u64, Option<f64>) {
        self.stands_at
    }
}

/// The settings that run, with another look but for its colours, which no step needs, and its food.
pub fn with_look(runs: &Settings, look: &Settings) -> Settings {
    let mut live = runs.clone();
    let parts = PARAMETERS.iter().filter(|parameter| is_look(parameter));
    for parameter in parts.filter(|parameter| !parameter.restarts(runs, look)) {
        parameter.copy(look, &mut live);
    }
    live.picture.color_map = runs.picture.color_map;
    live.foods.clone_from(&runs.foods);
    live.feeding = runs.feeding.clone();
    live
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::on_device::{SMALL, context, run, stage};
    use crate::own_presets::with_preset;

    use myxo::gpu::Frames;
    use myxo::scene::builtin::preset;

    fn look(name: &str) -> Settings {
        let text = preset(name).unwrap().text;
        with_preset(&Settings::default(), name, text).unwrap()
    }

    /// Would catch: a preview that leaves anything behind: in the state, in the settings, or in what follows from them, also after a
    /// second look, on objects that touch each other, with food that is eaten, and with particles that are born and die; and a look that
    /// begins from the state in which the one before has ended.
    #[test]
    fn a_preview_leaves_the_state_and_what_becomes_of_it_as_they_were() {
        let Some(ctx) = context() else { return };
        let contacts: &[&str] = &["transfer.threshold=0.01"];
        let food: &[&str] = &["physarum.deposit=5"];
        let births: &[&str] = &[
            "physarum.model=jones",
            "population.frequency=2",
            "population.division_most=40",
            "population.capacity=4000",
        ];
        for (name, set) in [("trio", contacts), ("oats", food), ("cube", births)] {
            let set = [&SMALL[..], set].concat();
            let ends = [false, true].map(|previews| {
                let mut stage = stage(&ctx, name, &set);
                let mut frames = Frames::new(&ctx, 1).unwrap();
                run(&mut frames, &mut stage.simulation, 7);
                let hash = |stage: &Stage| {
                    let state = stage.simulation.snapshot().unwrap();
                    (state.step, state.hash())
                };
                let before = hash(&stage);
                let settings = stage.simulation.settings().clone();
                for look in previews
                    .then(|| [look("cells"), look("waves")])
                    .iter()
                    .flatten()
                {
                    let begun = Previewing::begin(&mut stage, &mut frames, look);
                    let previewing = begun.unwrap();
                    assert!(previewing.has(look) && !previewing.has_stepped(&stage));
                    let angle = look.physarum.rotation_angle;
                    assert_eq!(stage.simulation.settings().physarum.rotation_angle, angle);
                    run(&mut frames, &mut stage.simulation, 4);
                    assert!(previewing.has_stepped(&stage));
                    assert_eq!(hash(&stage).0, 11);
                    assert_ne!(hash(&stage).1, before.1);
                    assert_eq!(previewing.stands_at().0, 7);
                    previewing.end(&mut stage, &mut frames).unwrap();
                    assert_eq!(*stage.simulation.settings(), settings);
                    assert_eq!(hash(&stage), before, "{name}");
                }
                run(&mut frames, &mut stage.simulation, 9);
                hash(&stage)
            });
            assert_eq!(ends[0], ends[1], "{name}");
        }
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
