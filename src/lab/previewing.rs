//! Previews of looks on the running scene: it runs with the look for a while and is then what it was before, to the bit.

use myxo::Result;
use myxo::scene::parameters::PARAMETERS;
use myxo::scene::presets::is_look;
use myxo::scene::settings::Settings;

use crate::lab::stage::Stage;
use crate::lab::state_copy::StateCopy;

/// States of more bytes are not copied, because a copy takes time: of their looks only the colours are previewed.
pub const MOST_BYTES: u64 = 128 << 20;

/// A preview under way.
pub struct Previewing {
    /// The state from which it began, and to which it returns.
    before: StateCopy,
    /// Seconds of the objects' motion then, if any moves.
    seconds: Option<f64>,
    /// The look as it was asked for.
    look: Settings,
}

impl Previewing {
    /// Runs a stage with another look from now on. Food stays as it is, because other food has to be measured first. No step may be
    /// under way.
    pub fn begin(stage: &mut Stage, look: &Settings) -> Result<Self> {
        let previewing = Self {
            before: StateCopy::of(stage)?,
            seconds: stage.seconds(),
            look: look.clone(),
        };
        run_with(stage, look)?;
        Ok(previewing)
    }

    /// Another look, which begins from the same state.
    pub fn change(&mut self, stage: &mut Stage, look: &Settings) -> Result<()> {
        if self.look == *look {
            return Ok(());
        }
        self.before.put(stage)?;
        self.look.clone_from(look);
        run_with(stage, look)
    }

    /// Everything is as it was.
    pub fn end(&self, stage: &mut Stage) -> Result<()> {
        self.before.put(stage)
    }

    /// The settings to which it returns.
    pub fn settings(&self) -> &Settings {
        &self.before.settings
    }

    /// Does it run with this look?
    pub fn has(&self, look: &Settings) -> bool {
        self.look == *look
    }

    /// The step at which the scene is without the preview, and the time of its objects.
    pub fn stands_at(&self) -> (u64, Option<f64>) {
        (self.before.snapshot.step, self.seconds)
    }
}

fn run_with(stage: &mut Stage, look: &Settings) -> Result<()> {
    let live = with_look(stage.simulation.settings(), look);
    stage.simulation.apply(&live)?;
    stage.forget_picture();
    Ok(())
}

/// The settings that run, with another look but for its food.
pub fn with_look(runs: &Settings, look: &Settings) -> Settings {
    let mut live = runs.clone();
    let parts = PARAMETERS.iter().filter(|parameter| is_look(parameter));
    for parameter in parts.filter(|parameter| !parameter.restarts(runs, look)) {
        parameter.copy(look, &mut live);
    }
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
    /// second look, on objects that touch each other, and with food that is eaten.
    #[test]
    fn a_preview_leaves_the_state_and_what_becomes_of_it_as_they_were() {
        let Some(ctx) = context() else { return };
        let food = "physarum.deposit=5";
        for (name, set) in [("trio", "transfer.threshold=0.01"), ("oats", food)] {
            let set = [&SMALL[..], &[set]].concat();
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
                if previews {
                    let mut previewing = Previewing::begin(&mut stage, &look("cells")).unwrap();
                    for name in ["cells", "waves"] {
                        previewing.change(&mut stage, &look(name)).unwrap();
                        assert_eq!(hash(&stage), before, "each begins from the same state");
                        let angle = look(name).physarum.rotation_angle;
                        assert_eq!(stage.simulation.settings().physarum.rotation_angle, angle);
                        run(&mut frames, &mut stage.simulation, 4);
                        // The same look does not begin again.
                        previewing.change(&mut stage, &look(name)).unwrap();
                        assert_eq!(hash(&stage).0, 11);
                        assert_ne!(hash(&stage).1, before.1);
                    }
                    assert_eq!(previewing.stands_at().0, 7);
                    previewing.end(&mut stage).unwrap();
                }
                assert_eq!(*stage.simulation.settings(), settings);
                assert_eq!(hash(&stage), before);
                run(&mut frames, &mut stage.simulation, 9);
                hash(&stage)
            });
            assert_eq!(ends[0], ends[1], "{name}");
        }
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
