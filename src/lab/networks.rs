//! The network of the running state, for its lines over the picture: a frame copies the trail from the device, and another thread finds the
//! graph. There is one at a time and no queue, and the state stays as it is.

use std::sync::{Arc, Mutex, PoisonError};
use std::thread::sleep;
use std::time::{Duration, Instant};

use glam::Affine3A;
use myxo::gpu::Recorder;
use myxo::render::network_lines::{NetworkLines, Sight, Viewpoint};
use myxo::sim::TrailCopy;
use myxo::sim::food::FoodPlace;
use myxo::sim::graph::graph_of;
use myxo::{Error, Result};

use crate::lab::facts::NetworkFacts;
use crate::lab::job::{Handle, Job};
use crate::lab::stage::Stage;
use crate::room;

/// From one copy of the trail to the next at the least.
const INTERVAL: Duration = Duration::from_secs(1);
/// How often the window asks whether the network is found, if nothing else happens.
const ASKS_EVERY: Duration = Duration::from_millis(50);
/// How often the thread asks whether the trail has come.
const ARRIVES_WITHIN: Duration = Duration::from_millis(2);
/// Points of lines lie a texel apart. The window draws lines in each frame, and every third point will do: where lines bend the most, that
/// is less than half a texel beside them.
const STRIDE: usize = 3;
/// Lines of more points than about this many are coarser, because a frame draws all that are in the picture.
const MOST_POINTS: usize = 40_000;

/// About what finding a graph takes on the host where the network covers a third of the surface: 14 bytes a texel for its trail and
/// bitmaps, and 200 for each texel of the network, with the list of those beside it.
const BYTES_A_TEXEL: u64 = 80;
/// What finding hidden points takes: corners, two nodes of the tree, and an index.
const BYTES_A_TRIANGLE: u64 = 116;

/// What a graph is found from. A state that goes on, or is painted, has another trail.
#[derive(Clone, Debug, PartialEq)]
struct Source {
    step: u64,
    painted: u64,
    replaced: u64,
    poses: Vec<Affine3A>,
    foods: Vec<FoodPlace>,
}

impl Source {
    fn of(stage: &Stage) -> Self {
        let simulation = &stage.simulation;
        Self {
            step: simulation.step(),
            painted: stage.painted,
            replaced: stage.replaced,
            poses: simulation.world_from_object(),
            foods: simulation.food_places().to_vec(),
        }
    }
}

/// The trail that a thread waits for, or copies to the host. None once it has it there, once it was given up, and once the device was left.
type SharedTrail = Arc<Mutex<Option<TrailCopy>>>;

/// A network that is being found.
struct Finding {
    job: Job<NetworkFacts>,
    trail: SharedTrail,
    begun: Instant,
}

/// Finds the network of a stage's state, one after the other.
#[derive(Default)]
pub struct Networks {
    finding: Option<Finding>,
    /// What the trail was copied of last.
    copied: Option<Source>,
    /// While the state goes on, no other is copied before.
    rests_until: Option<Instant>,
    /// Finds what the scene's objects hide, once it is made.
    sight: Option<Arc<Sight>>,
}

impl Networks {
    /// When the window has to ask again, though nothing else happens. None if the network of the state is found.
    pub fn due(&self, stage: &Stage, now: Instant) -> Option<Instant> {
        if self.finding.is_some() {
            return Some(now + ASKS_EVERY);
        }
        let source = Source::of(stage);
        match &self.copied {
            Some(copied) if *copied == source => None,
            Some(copied) if copied.replaced == source.replaced => Some(
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

    /// Records a copy of the trail as it is now, and begins to find its network, and which of its points are visible from there.
    pub fn begin(
        &mut self,
        rec: &mut Recorder,
        stage: &Stage,
        from: Viewpoint,
        now: Instant,
    ) -> Result<()> {
        let source = Source::of(stage);
        let setup = stage.simulation.shared_setup();
        let sight = self.sight.clone();
        let triangles = match sight {
            Some(_) => 0,
            None => setup.surface.corners.len(),
        };
        let texels = setup.atlas.texel_count();
        room::check_copy(BYTES_A_TEXEL * texels as u64 + BYTES_A_TRIANGLE * triangles as u64)?;
        let copy = stage.simulation.record_trail(rec)?;
        let trail: SharedTrail = Arc::new(Mutex::new(Some(copy)));
        let shared = Arc::clone(&trail);
        let poses = source.poses.clone();
        let (step, replaced) = (source.step, source.replaced);
        let job = Job::begin("finding the network", move |handle| {
            let trail = wait_for(&shared, handle)?;
            let graph = graph_of(&trail, &setup, &poses);
            drop(trail);
            let points: usize = graph.edges.iter().map(|edge| edge.points.len()).sum();
            let stride = STRIDE.max(points.div_ceil(MOST_POINTS));
            let lines = NetworkLines::new(&graph, &setup, &poses, stride);
            let sight = sight.unwrap_or_else(|| Arc::new(Sight::new(&setup)));
            let mut visible = vec![false; lines.count()];
            lines.find_visible(&sight, &from, 0..lines.count(), &mut visible);
            Ok(NetworkFacts {
                step,
                replaced,
                measures: graph.measures_of_lines(),
                lines,
                sight,
                from,
                visible,
            })
        });
        self.finding = Some(Finding {
            job,
            trail,
            begun: now,
        });
        self.copied = Some(source);
        self.rests_until = Some(now + INTERVAL);
        Ok(())
    }

    /// The network, once, when it is found, or why it is not. What was found of a state in whose place another one has come is dropped.
    pub fn take(&mut self, stage: &Stage, now: Instant) -> Option<Result<Arc<NetworkFacts>>> {
        let result = self.finding.as_mut()?.job.take()?;
        let finding = self.finding.take()?;
        if finding.job.is_cancelled() {
            return None;
        }
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

    /// No network is wanted. A thread at work ends by itself, and is not waited for; until then no other begins.
    pub fn give_up(&mut self) {
        self.finding.take_if(|finding| {
            finding.job.cancel();
            finding.job.has_ended()
        });
        (self.copied, self.rests_until) = (None, None);
    }

    /// The stage goes, and its surfaces with it.
    pub fn forget_scene(&mut self) {
        self.give_up();
        self.sight = None;
    }

    /// From then on no thread has anything of the device. Waits for one that copies the trail from there.
    pub fn leave_device(&mut self) {
        self.forget_scene();
        if let Some(finding) = &self.finding {
            let mut trail = (finding.trail.lock()).unwrap_or_else(PoisonError::into_inner);
            *trail = None;
        }
    }
}

/// Waits for the trail. It is an error if it does not come, because it was given up.
fn wait_for(shared: &Mutex<Option<TrailCopy>>, handle: &Handle) -> Result<Vec<f32>> {
    loop {
        let mut copy = shared.lock().unwrap_or_else(PoisonError::into_inner);
        if handle.is_cancelled() {
            // Its buffers are freed here.
            *copy = None;
        }
        let is_there = match &mut *copy {
            Some(copy) => copy.is_there(),
            None => return Err(Error::Invalid("it was given up".to_owned())),
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
    use crate::lab::feeding::Feeder;
    use crate::lab::on_device::{self, SMALL, context, run};
    use crate::lab::state_copy::StateCopy;
    use glam::{DAffine3, DVec3};
    use myxo::gpu::Frames;
    use myxo::scene::settings::FoodSettings;
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
    /// the last, and one of a state whose trail, poses and food have not changed.
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
        // Other colours and other rules are no other network; a painted trail is, and so are other food and objects in other places.
        stage.forget_picture();
        let mut settings = stage.simulation.settings().clone();
        settings.physarum.sensor_angle += 5.0;
        stage.simulation.apply(&settings).unwrap();
        assert_eq!(networks.due(&stage, later), None, "the trail is the same");
        let next = Some(later + 3 * INTERVAL);
        stage.trail_is_painted();
        assert_eq!(networks.due(&stage, later), next);
        networks.copied = Some(Source::of(&stage));
        assert_eq!(networks.due(&stage, later), None);
        settings.foods.push(FoodSettings {
            object: settings.objects[0].name.clone(),
            at: [1.0, 1.0, 1.0],
            ..FoodSettings::default()
        });
        stage.simulation.apply(&settings).unwrap();
        assert_eq!(networks.due(&stage, later), next);
        networks.copied = Some(Source::of(&stage));
        assert_eq!(networks.due(&stage, later), None);
        let up = DAffine3::from_translation(DVec3::Y);
        stage.simulation.set_pose(0, Some(up)).unwrap();
        assert_eq!(networks.due(&stage, later), next);
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
        before.put(&mut stage, &mut Feeder::default()).unwrap();
        assert!(found(&mut networks, &stage, now).is_none());
        assert!(networks.is_due(&stage, now), "the state is another one");
        begin(&mut networks, &mut frames, &mut stage, now, 0);
        let found_now = found(&mut networks, &stage, now).expect("it is found");
        assert_eq!(found_now.step, 20);

        // Their frames are never submitted.
        for leaves_device in [false, true] {
            let mut rec = frames.begin().unwrap();
            let from = Viewpoint::default();
            networks.begin(&mut rec, &stage, from, now).unwrap();
            drop(rec);
            if leaves_device {
                networks.leave_device();
                let has_trail = |finding: &Finding| finding.trail.lock().unwrap().is_some();
                assert!(!networks.finding.as_ref().is_some_and(has_trail));
            } else {
                networks.give_up();
            }
            assert_eq!(networks.sight.is_some(), !leaves_device);
            let begun = Instant::now();
            while networks.finding.is_some() {
                networks.give_up();
                assert!(begun.elapsed() < Duration::from_secs(60), "it hangs");
                sleep(Duration::from_millis(1));
            }
            assert!(networks.is_due(&stage, now), "at once");
        }
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
