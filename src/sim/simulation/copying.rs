//! Copies without stopping the simulation: of the whole state or of the trail to the host, recorded in a frame and read by any thread when
//! the frame has finished; and of the state on the device, for the way back.

use super::super::buffers;
use super::super::kept::{BufferCopy, Copies, DeviceCopies, copy_on_device};
use super::super::snapshot::{Distances, Snapshot};
use super::Simulation;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Recorder};
use crate::scene::settings::Settings;

/// A state being copied to the host.
pub struct SnapshotCopy {
    /// The parts on the host.
    host: Snapshot,
    parts: Copies,
    /// None before the first were computed.
    distances: Option<(BufferCopy<f32>, BufferCopy<u32>)>,
}

impl Simulation {
    /// Records a copy of the state after everything recorded so far, as [`snapshot`](Self::snapshot) and [`distances`](Self::distances)
    /// return it, but without waiting.
    ///
    /// # Errors
    /// No memory.
    pub fn record_snapshot(&self, rec: &mut Recorder) -> Result<SnapshotCopy> {
        let near = &self.state.near;
        Ok(SnapshotCopy {
            host: self.course.snapshot(),
            parts: Copies::record(rec, &self.state)?,
            distances: if self.course.has_distances() {
                Some((
                    BufferCopy::record(rec, &buffers::DISTANCES, &near.distances)?,
                    BufferCopy::record(rec, &buffers::NEAREST, &near.nearest)?,
                ))
            } else {
                None
            },
        })
    }
}

/// A trail being copied to the host.
pub struct TrailCopy(BufferCopy<f32>);

impl Simulation {
    /// Records a copy of the trail after everything recorded so far, gutters included, without waiting.
    ///
    /// # Errors
    /// No memory.
    pub fn record_trail(&self, rec: &mut Recorder) -> Result<TrailCopy> {
        let trail = &self.state.trail.front;
        let copy = BufferCopy::record(rec, &buffers::TRAIL_FRONT, trail)?;
        Ok(TrailCopy(copy))
    }
}

impl TrailCopy {
    /// Has the frame finished? Does not wait.
    pub fn is_there(&mut self) -> bool {
        self.0.is_there()
    }

    /// The trail of each texel, once [`is_there`](Self::is_there) has returned true.
    ///
    /// # Panics
    /// If it has not.
    #[must_use]
    pub fn take(mut self) -> Vec<f32> {
        assert!(self.is_there(), "the trail is still on its way");
        self.0.take()
    }
}

/// A state that was copied on the device, and to which its simulation can go back.
pub struct StateAside {
    /// The settings that it ran with.
    settings: Settings,
    /// The parts on the host.
    host: Snapshot,
    parts: DeviceCopies,
    /// The sum of all scents, if there is food. It follows from the amounts that are left, and takes long to find on the host.
    scent: Option<Buffer<f32>>,
}

impl Simulation {
    /// Records a copy of the state after everything recorded so far, for [`record_back`](Self::record_back). It stays on the device, so
    /// nothing waits for it.
    ///
    /// # Errors
    /// No memory.
    pub fn record_aside(&self, rec: &mut Recorder) -> Result<StateAside> {
        let food = self.state.food.as_ref();
        let scent = food
            .map(|food| copy_on_device(rec, &food.scent))
            .transpose()?;
        Ok(StateAside {
            settings: self.settings().clone(),
            host: self.course.snapshot(),
            parts: DeviceCopies::record(rec, &self.state)?,
            scent,
        })
    }

    /// How many bytes of the device's memory [`record_aside`](Self::record_aside) takes.
    #[must_use]
    pub fn bytes_aside(&self) -> u64 {
        let food = self.state.food.as_ref();
        let scent = food.map_or(0, |food| food.scent.size_in_bytes());
        DeviceCopies::bytes_of(&self.state) + scent
    }

    /// Records the way back to a state of this simulation. All recorded steps must have been submitted, and the settings of that time
    /// be [applied](Self::apply), but for names of objects; steps then continue as they would have from there. Areas and a second look
    /// that were painted for the first time since then stay.
    ///
    /// # Errors
    /// When the settings are not those of that time, or buffers have other sizes than then. Then nothing has changed. When the device
    /// cannot run a kernel.
    pub fn record_back(&mut self, rec: &mut Recorder, aside: &StateAside) -> Result<()> {
        let mut settings = aside.settings.clone();
        let objects = &self.settings().objects;
        if objects.len() == settings.objects.len() {
            // Nothing depends on names.
            let names: Vec<String> = objects.iter().map(|object| object.name.clone()).collect();
            settings.rename_objects(&names);
        }
        if *self.settings() != settings {
            return Err(Error::Invalid(
                "the simulation cannot go back to the state that was copied on the device: its settings have changed since then; apply \
                 those of that time first"
                    .to_owned(),
            ));
        }
        let scent = self.state.food.as_ref().map(|food| &*food.scent);
        let scent_fits = scent.map(Buffer::len) == aside.scent.as_ref().map(Buffer::len);
        if !scent_fits || !aside.parts.fits(&self.state) {
            return Err(Error::Invalid(
                "the simulation cannot go back to the state that was copied on the device: its buffers have other sizes than then; \
                 restore a snapshot instead"
                    .to_owned(),
            ));
        }
        let mut course = self.course.clone();
        let are_distances_known = course.restore(&aside.host).map_err(Error::Invalid)?;
        // Pulses may be live again.
        let every = course.of_every_kernel(self.settings(), self.means());
        every.prepare(&mut self.pipelines)?;
        self.course = course;
        if !are_distances_known {
            self.state.near.reach = 0.0;
        }
        aside.parts.record_back(rec, &self.state);
        if let (Some(before), Some(food)) = (&aside.scent, &self.state.food) {
            rec.copy(before, &food.scent);
        }
        self.record_poses(rec);
        Ok(())
    }
}

impl SnapshotCopy {
    /// Has the frame finished? Does not wait. Copied parts are kept.
    pub fn is_there(&mut self) -> bool {
        self.parts.are_there()
            && (self.distances.as_mut())
                .is_none_or(|(signed, nearest)| signed.is_there() && nearest.is_there())
    }

    /// The copy, once [`is_there`](Self::is_there) has returned true.
    ///
    /// # Panics
    /// If it has not.
    #[must_use]
    pub fn take(mut self) -> (Snapshot, Option<Distances>) {
        assert!(self.is_there(), "the state is still on its way");
        let mut snapshot = self.host;
        self.parts.take(&mut snapshot);
        let distances = self.distances.map(|(signed, nearest)| Distances {
            signed: signed.take(),
            nearest: nearest.take(),
        });
        (snapshot, distances)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use glam::Vec3;

    use super::*;
    use crate::gpu::{Context, ContextOptions, Frames};
    use crate::scene::settings::Strategy;
    use crate::scene::{Overrides, Scene};
    use crate::sim::paint::{Brush, Dab};
    use crate::sim::pulse::Pulse;

    /// A simulation with scents that cross from object to object, and its frames.
    fn simulation(ctx: &Arc<Context>) -> (Simulation, Frames) {
        let set = [
            "particles.count=3000",
            "atlas.size=128",
            "second_look.preset=cells",
            "object.0.mesh=builtin:torus?tube=0.36&major=36&minor=24",
            "object.1.mesh=builtin:icosphere?subdivisions=3",
            "object.1.scale=0.75",
            "feeding.scent_across=0.5",
            "feeding.amount=0",
        ];
        let overrides = Overrides {
            set: set.map(str::to_owned).to_vec(),
            ..Overrides::default()
        };
        let scene = Scene::load(Path::new("oats"), &overrides).unwrap();
        let simulation = Simulation::new(ctx, &scene).unwrap();
        (simulation, Frames::new(ctx, 1).unwrap())
    }

    fn run(simulation: &mut Simulation, frames: &mut Frames, steps: u32) {
        let run = frames.run(|rec| (0..steps).for_each(|_| simulation.record_step(rec)));
        run.unwrap();
    }

    /// Paints over all objects.
    fn paint(simulation: &mut Simulation, frames: &mut Frames, brush: Brush) {
        let dab = Dab {
            brush,
            center: simulation.setup().center,
            radius: simulation.setup().radius,
            eye: None,
            ring: None,
            number: 1,
        };
        let painted = frames.run(|rec| simulation.paint(rec, &dab));
        painted.unwrap().unwrap();
    }

    fn pulse(simulation: &mut Simulation, at: Vec3) {
        let radius = simulation.setup().radius;
        let pulse = Pulse {
            center: radius * at,
            speed: 0.01 * radius,
            width: 0.25 * radius,
            reach: 2.0 * radius,
            strength: 0.6,
        };
        simulation.pulse(&pulse).unwrap();
    }

    fn hash(simulation: &Simulation) -> (u64, u64) {
        let state = simulation.snapshot().unwrap();
        (state.step, state.hash())
    }

    /// Would catch: a way back that leaves out painted areas, a second look, live pulses or scents that cross; one with other settings, or
    /// that changes something before it is refused; one that is refused for other names of objects; and a number of bytes that leaves out
    /// a part.
    #[test]
    fn a_simulation_goes_back_to_what_was_copied_on_the_device_and_continues_from_there() {
        let options = ContextOptions {
            validation: true,
            ..ContextOptions::default()
        };
        let ctx = match Context::new(&options) {
            Ok(ctx) => ctx,
            Err(error) if std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() => {
                return eprintln!("skipped: {error}");
            }
            Err(error) => panic!("{error}"),
        };
        let ends = [false, true].map(|goes_back| {
            let (mut simulation, mut frames) = simulation(&ctx);
            let simulation = &mut simulation;
            let setup = simulation.setup();
            let texels = size_of::<f32>() * setup.atlas.density.len();
            let particles = setup.particles.len();
            let plain = simulation.bytes_aside() as usize;
            // Particles with their headings; trail, deposits and scents.
            assert!(plain >= 32 * particles + 3 * texels, "{plain}");
            paint(simulation, &mut frames, Brush::Attract { amount: 3.0 });
            paint(simulation, &mut frames, Brush::Look { amount: 0.6 });
            assert_eq!(simulation.bytes_aside() as usize, plain + 2 * texels);
            run(simulation, &mut frames, 4);
            pulse(simulation, Vec3::X);
            run(simulation, &mut frames, 3);
            let before = hash(simulation);
            if goes_back {
                let aside = frames.run(|rec| simulation.record_aside(rec));
                let aside = aside.unwrap().unwrap();
                let settings = simulation.settings().clone();
                paint(simulation, &mut frames, Brush::Erase { share: 0.7 });
                pulse(simulation, Vec3::NEG_X);
                run(simulation, &mut frames, 4);
                let mut other_food = settings.clone();
                other_food.feeding.scattered = 5;
                let mut other_strategy = settings.clone();
                other_strategy.transfer.strategy = Strategy::None;
                let mut other_angle = settings.clone();
                other_angle.physarum.sensor_angle += 5.0;
                for other in [other_angle, other_strategy, other_food] {
                    simulation.apply(&other).unwrap();
                    let gone = hash(simulation);
                    let back = frames.run(|rec| simulation.record_back(rec, &aside));
                    let refused = back.unwrap().unwrap_err().to_string();
                    assert!(refused.contains("settings have changed"), "{refused}");
                    assert_eq!(hash(simulation), gone);
                    assert_eq!(simulation.pulses().len(), 2);
                    run(simulation, &mut frames, 1);
                }
                simulation.apply(&settings).unwrap();
                let objects = settings.objects.iter();
                let names: Vec<String> = objects
                    .map(|object| format!("other {}", object.name))
                    .collect();
                simulation.rename_objects(&names);
                let back = frames.run(|rec| simulation.record_back(rec, &aside));
                back.unwrap().unwrap();
                assert_eq!(hash(simulation), before);
                assert_eq!(simulation.pulses().len(), 1);
            }
            run(simulation, &mut frames, 9);
            hash(simulation)
        });
        assert_eq!(ends[0], ends[1]);
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
