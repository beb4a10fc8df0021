//! Copies of a running state on the host, and the way back to them while the scene stays the same one.

use myxo::Result;
use myxo::scene::settings::Settings;
use myxo::sim::Snapshot;
use myxo::sim::types::{Motion, Particle};

use crate::lab::feeding::Feeder;
use crate::lab::stage::Stage;

/// A state with the settings that it ran with.
pub struct StateCopy {
    /// Particles, trail, and all else that continues.
    pub snapshot: Snapshot,
    /// The settings of its next step.
    pub settings: Settings,
}

impl StateCopy {
    /// Copies the state of a stage of which all recorded steps have been submitted. Waits for them.
    pub fn of(stage: &Stage) -> Result<Self> {
        Ok(Self {
            snapshot: stage.simulation.snapshot()?,
            settings: stage.simulation.settings().clone(),
        })
    }

    /// Brings a stage of the same scene back to this state. Food is what it was if the settings of food are; food that is being measured
    /// is given up, because these settings do not have it.
    pub fn put(&self, stage: &mut Stage, food: &mut Feeder) -> Result<()> {
        let before = stage.simulation.settings().clone();
        stage.simulation.apply(&self.settings)?;
        if let Err(error) = stage.simulation.restore(&self.snapshot) {
            stage.simulation.apply(&before)?;
            return Err(error);
        }
        stage.state_is_replaced();
        food.want(&stage.simulation, &self.settings);
        Ok(())
    }

    /// Its size, bytes.
    pub fn bytes(&self) -> u64 {
        bytes_of(self.snapshot.particles.len(), self.snapshot.trail.len())
    }

    /// The size of a copy of this stage's state, bytes.
    pub fn bytes_of(stage: &Stage) -> u64 {
        let setup = stage.simulation.setup();
        bytes_of(setup.particles.len(), setup.atlas.texel_count())
    }
}

impl StateCopy {
    /// The size of a particle's copy, bytes.
    #[cfg(test)]
    pub fn bytes_of_particles() -> usize {
        bytes_of(1, 0) as usize
    }
}

/// The size of a copy of a state on the host: particles with their states, and trail, deposits, areas and the second
/// look.
pub fn bytes_of(particles: usize, texels: usize) -> u64 {
    let particle = size_of::<Particle>() + size_of::<Motion>();
    let texel = 4 * size_of::<f32>();
    (particles * particle + texels * texel) as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::on_device::{SMALL, context, stage};
    use myxo::scene::settings::FoodSettings;
    use std::time::{Duration, Instant};

    /// Would catch: food that was being measured when the scene went back, and that comes into a state which does not have it.
    #[test]
    fn food_on_its_way_does_not_come_into_an_earlier_state() {
        let Some(ctx) = context() else { return };
        let mut stage = stage(&ctx, "cube", &SMALL);
        let before = StateCopy::of(&stage).unwrap();
        let mut fed = before.settings.clone();
        fed.foods.push(FoodSettings {
            object: fed.objects[0].name.clone(),
            at: [0.0, 1.0, 0.0],
            ..FoodSettings::default()
        });
        let mut food = Feeder::default();
        food.want(&stage.simulation, &fed);
        assert!(food.is_busy());
        before.put(&mut stage, &mut food).unwrap();
        let begun = Instant::now();
        while food.is_busy() {
            let fed = food.take(&stage.simulation);
            assert!(fed.is_none(), "it is not wanted any more");
            assert!(begun.elapsed() < Duration::from_secs(60), "it hangs");
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
