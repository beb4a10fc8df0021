//! The network of the running state, for its lines over the picture: a frame copies the trail from the device, and another thread finds the
//! graph. There is one at a time and no queue, and the state stays as it is.

use std::sync::{Arc, Mutex, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use myxo::gpu::Recorder;
use myxo::render::network_lines::{NetworkLines, Sight, Viewpoint};
use myxo::sim::TrailCopy;
use myxo::sim::graph::graph_of;
use myxo::{Error, Result};

use crate::lab::facts::NetworkFacts;
use crate::lab::job::{Handle, Job};
use crate::lab::stage::Stage;
use crate::room;

/// From one copy of the trail to the next at the least.
const INTERVAL: Duration = Duration::from_secs(1);
/// How often the window looks whether the network is found, if nothing else happens.
const LOOKS_AGAIN: Duration = Duration::from_millis(50);
/// How often the thread looks whether the trail has come.
const ARRIVES_WITHIN: Duration = Duration::from_millis(2);
/// Points of lines lie a texel apart. The window draws lines in each frame, and every third point will do: where lines bend the most, that
/// is less than half a texel beside them.
const STRIDE: usize = 3;

/// About what finding a graph takes on the host where the network covers a third of the surface: 14 bytes a texel for its trail and
/// bitmaps, and 200 for each texel of the network, with the list of those beside it.
const BYTES_A_TEXEL: u64 = 80;

/// Which state it is of those that a stage goes through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct State {
    step: u64,
    changes: u64,
    replaced: u64,
}

impl State {
    fn of(stage: &Stage) -> Self {
        Self {
            step: stage.simulation.step(),
            changes: stage.changes,
            replaced: stage.replaced,
        }
    }
}

/// A trail on its way to the thread. None once the thread has it on the host, and once it was given up.
type Coming = Arc<Mutex<Option<TrailCopy>>>;

/// A network that is being found.
struct Finding {
    job: Job<NetworkFacts>,
    coming: Coming,
    begun: Instant,
    is_wanted: bool,
}

impl Finding {
    /// What comes of it is not wanted any more. The thread has nothing of the device from then on.
    fn give_up(&mut self) {
        self.is_wanted = false;
        self.job.cancel();
        let mut coming = self.coming.lock().unwrap_or_else(PoisonError::into_inner);
        *coming = None;
    }
}

/// Finds the network of a stage's state, one after the other.
#[derive(Default)]
pub struct Networks {
    finding: Option<Finding>,
    /// The state whose trail was copied last.
    copied: Option<State>,
    /// While the state goes on, no other is copied before.
    rests_until: Option<Instant>,
    /// Finds what the scene's objects hide, once it is made.
    sight: Option<Arc<Sight>>,
}

impl Networks {
    /// When the window has to look again, though nothing else happens. None if the network of the state is found.
    pub fn due(&self, stage: &Stage, now: Instant) -> Option<Instant> {
        if self.finding.is_some() {
            return Some(now + LOOKS_AGAIN);
        }
        let state = State::of(stage);
        match self.copied {
            Some(copied) if copied == state => None,
            Some(copied) if copied.replaced == state.replaced => Some(
                self.rests_until
                    .map_or(now, |rests_until| rests_until.max(now)),
            ),
            // It has just been asked for, or another state has come.
            _ => Some(now),
        }
    }

    /// Is the trail to be copied now?
    pub fn is_due(&self, stage: &Stage, now: Instant) -> bool {
        self.finding.is_none() && self.due(stage, now).is_some_and(|due| due <= now)
    }

    /// Records a copy of the trail as it is now, and begins to find its network. Its lines are first looked at from there.
    pub fn begin(
        &mut self,
        rec: &mut Recorder,
        stage: &Stage,
        from: Viewpoint,
        now: Instant,
    ) -> Result<()> {
        let state = State::of(stage);
        let setup = stage.simulation.shared_setup();
        room::check_copy(BYTES_A_TEXEL * setup.atlas.texel_count() as u64)?;
        let copy = stage.simulation.record_trail(rec)?;
        let coming: Coming = Arc::new(Mutex::new(Some(copy)));
        let poses = stage.simulation.world_from_object();
        let (sight, taken) = (self.sight.clone(), Arc::clone(&coming));
        let job = Job::begin("finding the network", move |handle| {
            let trail = arrived(&taken, handle)?;
            let graph = graph_of(&trail, &setup, &poses);
            drop(trail);
            let lines = NetworkLines::new(&graph, &setup, &poses, STRIDE);
            let sight = sight.unwrap_or_else(|| Arc::new(Sight::new(&setup)));
            let mut seen = vec![false; lines.count()];
            lines.look(&sight, &from, 0..lines.count(), &mut seen);
            Ok(NetworkFacts {
                step: state.step,
                replaced: state.replaced,
                measures: graph.measures_of_lines(),
                lines,
                sight,
                from,
                seen,
            })
        });
        self.finding = Some(Finding {
            job,
            coming,
            begun: now,
            is_wanted: true,
        });
        self.copied = Some(state);
        self.rests_until = Some(now + INTERVAL);
        Ok(())
    }

    /// The network, once, when it is found, or why it is not. What was found of a state in whose place another one has come is dropped.
    pub fn take(&mut self, stage: &Stage, now: Instant) -> Option<Result<Arc<NetworkFacts>>> {
        let result = self.finding.as_mut()?.job.take()?;
        let finding = self.finding.take().filter(|finding| finding.is_wanted)?;
        // One that takes long leaves as much time to everything else.
        let took = now.saturating_duration_since(finding.begun);
        self.rests_until = self.rests_until.max(Some(now + took));
        let found = match result {
            Ok(found) => found,
            Err(error) => return Some(Err(error)),
        };
        self.sight = Some(Arc::clone(&found.sight));
        (found.replaced == stage.replaced).then(|| Ok(Arc::new(found)))
    }

    /// No network is wanted, or the stage or the device goes. A thread at work ends by itself; until then no other begins.
    pub fn rest(&mut self) {
        self.finding.take_if(|finding| {
            finding.give_up();
            finding.job.has_ended()
        });
        (self.copied, self.rests_until, self.sight) = (None, None, None);
    }
}

/// Waits for the trail. It is an error if it does not come, because it was given up.
fn arrived(coming: &Mutex<Option<TrailCopy>>, handle: &Handle) -> Result<Vec<f32>> {
    loop {
        let mut copy = coming.lock().unwrap_or_else(PoisonError::into_inner);
        let is_there = match &mut *copy {
            Some(copy) if !handle.is_cancelled() => copy.is_there(),
            _ => return Err(Error::Invalid("it was given up".to_owned())),
        };
        // It stays locked until its buffers are free.
        if let Some(copy) = copy.take_if(|_| is_there) {
            return Ok(copy.take());
        }
        drop(copy);
        sleep(ARRIVES_WITHIN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::on_device::{self, SMALL, context, run};
    use crate::lab::state_copy::StateCopy;
    use myxo::gpu::Frames;
    use myxo::sim::graph::{Measures, network_of};

    /// Keys of a scene that has a network after 60 steps.
    const GROWN: [&str; 2] = ["particles.count=20000", "atlas.size=192"];

    /// Begins to find a network in a frame that also takes some steps.
    fn begin(
        networks: &mut Networks,
        frames: &mut Frames,
        stage: &mut Stage,
        now: Instant,
        steps: u32,
    ) {
        let mut rec = frames.begin().unwrap();
        let from = Viewpoint::default();
        networks.begin(&mut rec, stage, from, now).unwrap();
        (0..steps).for_each(|_| stage.simulation.record_step(&mut rec));
        frames.submit(rec).unwrap();
        // The copy counts as there once the ring has waited for its frame.
        frames.wait_idle().unwrap();
    }

    /// Waits until a network is found, or nothing is under way any more.
    fn found(networks: &mut Networks, stage: &Stage, now: Instant) -> Option<Arc<NetworkFacts>> {
        let begun = Instant::now();
        while networks.finding.is_some() {
            if let Some(found) = networks.take(stage, now) {
                return Some(found.unwrap());
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "it hangs");
            sleep(Duration::from_millis(1));
        }
        None
    }

    /// Would catch: the network of another step than it says, a copy that disturbs the state, two at once, one that comes too soon after
    /// the last, and one of a state that has not changed.
    #[test]
    fn networks_are_those_of_their_states_which_stay_as_they_are() {
        let Some(ctx) = context() else { return };
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let mut plain = on_device::stage(&ctx, "cube", &GROWN);
        run(&mut frames, &mut plain.simulation, 61);
        let mut stage = on_device::stage(&ctx, "cube", &GROWN);
        run(&mut frames, &mut stage.simulation, 60);
        let state = stage.simulation.snapshot().unwrap();
        let poses = stage.simulation.world_from_object();
        let (graph, measures) = network_of(&state.trail, stage.simulation.setup(), &poses);
        assert!(measures.edges > 3, "there is a network: {measures:?}");

        let mut networks = Networks::default();
        let now = Instant::now();
        assert!(networks.is_due(&stage, now));
        begin(&mut networks, &mut frames, &mut stage, now, 1);
        assert!(
            !networks.is_due(&stage, now + 2 * INTERVAL),
            "one at a time"
        );
        let first = found(&mut networks, &stage, now).expect("it is found");
        assert_eq!((first.step, &first.measures), (60, &measures));
        let setup = stage.simulation.setup();
        assert_eq!(
            first.lines,
            NetworkLines::new(&graph, setup, &poses, STRIDE)
        );
        let states = [&stage, &plain].map(|stage| stage.simulation.snapshot().unwrap());
        assert_eq!(states[0].step, 61);
        assert_eq!(states[0].hash(), states[1].hash());

        // The next one is of the next state, a second later, and keeps what finds hidden points.
        assert!(!networks.is_due(&stage, now + INTERVAL / 2));
        assert_eq!(networks.due(&stage, now), Some(now + INTERVAL));
        let now = now + INTERVAL;
        assert!(networks.is_due(&stage, now));
        begin(&mut networks, &mut frames, &mut stage, now, 0);
        // It took three seconds, and rests as long.
        let later = now + 3 * INTERVAL;
        let second = found(&mut networks, &stage, later).expect("it is found");
        assert_eq!(second.step, 61);
        assert!(Arc::ptr_eq(&first.sight, &second.sight));
        assert_eq!(networks.due(&stage, later), None, "nothing has changed");
        stage.forget_picture();
        assert_eq!(networks.due(&stage, later), Some(later + 3 * INTERVAL));
        assert_eq!(ctx.messages(), [""; 0]);
    }

    /// Would catch: lines of a state that is no longer there, buffers of a device that a thread still holds, and a thread that waits for
    /// ever for a frame that does not come.
    #[test]
    fn what_is_no_longer_wanted_is_dropped() {
        let Some(ctx) = context() else { return };
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let mut stage = on_device::stage(&ctx, "cube", &SMALL);
        run(&mut frames, &mut stage.simulation, 20);
        let before = StateCopy::of(&stage).unwrap();
        run(&mut frames, &mut stage.simulation, 20);
        let mut networks = Networks::default();
        let now = Instant::now();
        begin(&mut networks, &mut frames, &mut stage, now, 0);
        before.put(&mut stage).unwrap();
        assert!(found(&mut networks, &stage, now).is_none());
        assert!(networks.is_due(&stage, now), "the state is another one");
        begin(&mut networks, &mut frames, &mut stage, now, 0);
        let found_now = found(&mut networks, &stage, now).expect("it is found");
        assert_eq!(found_now.step, 20);

        // Its frame is never submitted.
        let mut rec = frames.begin().unwrap();
        let from = Viewpoint::default();
        networks.begin(&mut rec, &stage, from, now).unwrap();
        drop(rec);
        networks.rest();
        assert!(networks.finding.as_ref().is_none_or(|finding| {
            let coming = finding.coming.lock().unwrap();
            coming.is_none() && !finding.is_wanted
        }));
        let begun = Instant::now();
        while networks.finding.is_some() {
            networks.rest();
            assert!(begun.elapsed() < Duration::from_secs(60), "it hangs");
            sleep(Duration::from_millis(1));
        }
        assert!(networks.is_due(&stage, now), "at once");
        assert_eq!(ctx.messages(), [""; 0]);
    }

    /// Would catch: a panic where there is no network.
    #[test]
    fn trails_without_a_network_have_no_lines() {
        let Some(ctx) = context() else { return };
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let mut stage = on_device::stage(&ctx, "cube", &SMALL);
        let mut networks = Networks::default();
        let now = Instant::now();
        begin(&mut networks, &mut frames, &mut stage, now, 0);
        let empty = found(&mut networks, &stage, now).expect("it is found");
        assert_eq!((empty.step, empty.lines.count()), (0, 0));
        assert_eq!(empty.measures, Measures::default());
        // One over everything, and numbers that are none.
        let (setup, poses) = (
            stage.simulation.setup(),
            stage.simulation.world_from_object(),
        );
        for value in [1.0, f32::INFINITY, f32::NAN] {
            let trail = vec![value; setup.atlas.texel_count()];
            let (graph, measures) = network_of(&trail, setup, &poses);
            assert_eq!(measures, Measures::default(), "{value}");
            let lines = NetworkLines::new(&graph, setup, &poses, STRIDE);
            assert_eq!(lines.count(), 0, "{value}");
        }
    }
}
