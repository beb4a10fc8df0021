//! The simulation that a window runs: its steps, in one go or in slices, its pace, the checks of its invariants, the state
//! that one can go back to, and what is left when the device is lost. No window and no interface is needed for it.

use std::sync::Arc;
use std::time::{Duration, Instant};

use myxo::gpu::{Context, Format, Frames, Recorder};
use myxo::scene::Scene;
use myxo::scene::settings::Settings;
use myxo::{Error, Result};

use crate::lab::back::{Back, Grown, Shown};
use crate::lab::checks::Checks;
use crate::lab::clocks::Clocks;
use crate::lab::facts::Before;
use crate::lab::feeding::Fed;
use crate::lab::lost::{Lost, is_loss};
use crate::lab::order::{Asked, Order, Task};
use crate::lab::pacing::Pacer;
use crate::lab::previewing::{MOST_BYTES, Previewing};
use crate::lab::stage::Stage;
use crate::room;

/// Kernels that take longer are divided.
const LONGEST_SLICE: Duration = Duration::from_millis(8);
/// A device that is lost again before the scene has run for so long is not replaced, or that would never end.
const RUNS_FOR: Duration = Duration::from_secs(10);

/// Steps, or a picture, of which the device has been given a part. Until it has all of it nothing else may use the simulation.
struct Slices {
    rec: Recorder,
    steps: u32,
    /// The stage's next picture is drawn by it.
    draws: bool,
}

/// What came of some slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sliced {
    /// The stage has a new picture.
    pub has_drawn: bool,
    /// Steps are over.
    pub has_stepped: bool,
    /// Invariants were checked, which is to be shown.
    pub is_checked: bool,
}

/// What runs on one device. Fields are dropped in this order: what lies on the device before the device.
pub struct Runner {
    /// The scene and its pictures; none before the first scene is ready.
    pub stage: Option<Stage>,
    slices: Option<Slices>,
    /// A part of a step was never submitted.
    is_torn: bool,
    /// What steps and pictures are recorded into.
    pub frames: Frames,
    /// For what is shown while steps are under way.
    pub answers: Frames,
    pub pacer: Pacer,
    pub order: Order,
    /// Steps that were asked for one by one.
    pub single_steps: u32,
    /// The state that one can go back to.
    pub back: Back,
    /// A look that is previewed, and the state from before.
    pub previewing: Option<Previewing>,
    /// Where the validation layers are on.
    pub checks: Option<Checks>,
    /// What is left of a device that was lost.
    pub lost: Option<Lost>,
    /// The format of pictures.
    pub format: Format,
    pub ctx: Arc<Context>,
}

impl Runner {
    /// Nothing runs yet. With `checks` the invariants are checked now and then.
    pub fn new(
        ctx: Arc<Context>,
        format: Format,
        [frames, answers]: [Frames; 2],
        checks: bool,
    ) -> Self {
        Self {
            stage: None,
            slices: None,
            is_torn: false,
            frames,
            answers,
            pacer: Pacer::default(),
            order: Order::default(),
            single_steps: 0,
            back: Back::default(),
            previewing: None,
            checks: checks.then(Checks::new),
            lost: None,
            format,
            ctx,
        }
    }

    /// The scene that runs, or that ran on a device that was lost and does not run again yet.
    pub fn scene(&self) -> Option<&Scene> {
        let runs = self.stage.as_ref().map(|stage| &stage.scene);
        runs.or_else(|| self.lost.as_ref()?.scene.as_ref())
    }

    /// The remarks on the meshes of [`Self::scene`].
    pub fn remarks(&self) -> &[String] {
        let runs = self.stage.as_ref().map(|stage| &stage.remarks);
        let remarks = runs.or_else(|| Some(&self.lost.as_ref()?.remarks));
        remarks.map_or(&[], Vec::as_slice)
    }

    /// Runs another scene, or the same one from the beginning; it draws into the canvas of the one before.
    pub fn take_stage(&mut self, mut stage: Stage, clocks: &mut Clocks) {
        stage.take_canvases(self.stage.take());
        clocks.restart(&mut self.frames, &stage);
        self.stage = Some(stage);
        self.previewing = None;
        self.is_torn = false;
        if let Some(lost) = &mut self.lost {
            lost.scene = None;
            lost.remarks.clear();
            lost.runs_since.get_or_insert_with(Instant::now);
        }
        if let Some(checks) = &mut self.checks {
            checks.restart();
        }
        self.pacer.restart();
    }

    /// What the next frame does, `since_last` after the one before. The simulation `runs`, or takes the single steps that were
    /// asked for unless it is `held`. Where frames `can_split`, steps, answers and pictures have frames of their own.
    pub fn next_task(
        &mut self,
        (runs, held): (bool, bool),
        can_split: bool,
        since_last: Duration,
        asked: Asked,
    ) -> Task {
        if runs && let Some(stage) = &self.stage {
            let cap = stage.simulation.settings().time.steps_per_second;
            return (self.order).next(&mut self.pacer, can_split, since_last, cap, asked);
        }
        self.order.rest();
        self.pacer.restart();
        let steps = match held {
            true => 0,
            false => std::mem::take(&mut self.single_steps),
        };
        Task {
            steps,
            // The window shows them in the frame after.
            only_steps: can_split && self.pacer.are_long(steps),
            ..Task::default()
        }
    }

    /// Records so many steps.
    pub fn record_steps(&mut self, rec: &mut Recorder, steps: u32) {
        if let Some(stage) = &mut self.stage {
            for _ in 0..steps {
                rec.scope("step", |rec| stage.simulation.record_step(rec));
            }
        }
    }

    /// What is recorded next is submitted in slices, each of about [`LONGEST_SLICE`].
    pub fn divide(&self, rec: &mut Recorder) {
        rec.slice(LONGEST_SLICE, self.frames.timings());
    }

    /// Steps have been recorded in slices, or the stage's next picture; [`Self::run_slices`] submits them.
    pub fn begin_slices(&mut self, rec: Recorder, steps: u32, draws: bool) {
        self.slices = Some(Slices { rec, steps, draws });
    }

    /// Is a part of some steps or of a picture still to be submitted?
    pub fn is_within_slices(&self) -> bool {
        self.slices.is_some()
    }

    /// Submits slices until `at_most` has gone by, or all of them. Where something fails they are given up.
    pub fn run_slices(&mut self, at_most: Duration, clocks: &mut Clocks) -> Result<Sliced> {
        let Some(slices) = self.slices.take() else {
            return Ok(Sliced::default());
        };
        let sliced = self.run_some_of(slices, at_most, clocks);
        self.is_torn |= sliced.is_err();
        sliced
    }

    fn run_some_of(
        &mut self,
        mut slices: Slices,
        at_most: Duration,
        clocks: &mut Clocks,
    ) -> Result<Sliced> {
        let began = Instant::now();
        while began.elapsed() < at_most {
            if !self.frames.run_slice(&mut slices.rec)? {
                self.frames.submit(slices.rec)?;
                self.frames.wait_idle()?;
                if let Some(stage) = self.stage.as_mut().filter(|_| slices.draws) {
                    stage.show_next();
                }
                return Ok(Sliced {
                    has_drawn: slices.draws,
                    has_stepped: slices.steps > 0,
                    is_checked: self.have_stepped(slices.steps, clocks)?,
                });
            }
        }
        self.slices = Some(slices);
        Ok(Sliced::default())
    }

    /// What was not submitted of a step never is. Nothing can be drawn or copied from then on, because buffers are not what the host
    /// takes them for.
    pub fn give_up_slices(&mut self) {
        self.is_torn |= self.slices.take().is_some();
    }

    /// Can the state be drawn now? Not while a part of a step is still to be submitted, nor when that was given up.
    pub fn can_draw(&self) -> bool {
        !self.is_torn && self.slices.is_none()
    }

    /// So many steps have been submitted. Was something checked that is to be shown?
    pub fn have_stepped(&mut self, steps: u32, clocks: &mut Clocks) -> Result<bool> {
        let Some(stage) = &mut self.stage else {
            return Ok(false);
        };
        clocks.submitted(steps, &self.ctx, &self.frames, stage, &mut self.pacer);
        stage.follow_times(clocks.facts.times.draw_ms);
        if let Some(previewing) = &self.previewing {
            // Steps of a preview do not count.
            (clocks.facts.step, clocks.facts.seconds) = previewing.stands_at();
        }
        let Some(checks) = &mut self.checks else {
            return Ok(false);
        };
        let is_checked = checks.look(&mut self.frames, &stage.simulation)?;
        if is_checked {
            clocks.facts.check.clone_from(&checks.last);
            if let Some(problem) = checks.problem() {
                log::error!("{problem}");
            }
        }
        Ok(is_checked)
    }

    /// Lets the running simulation take over what can change while it runs, but for food, which has to be measured first. Gives
    /// the settings that run.
    pub fn apply(&mut self, wanted: &Settings) -> Result<Option<Settings>> {
        let Some(stage) = &mut self.stage else {
            return Ok(None);
        };
        let runs = stage.simulation.settings();
        let mut live = wanted.clone();
        live.foods.clone_from(&runs.foods);
        live.feeding = runs.feeding.clone();
        // Names change nothing, and so they come first: what names objects need not restart.
        let names: Vec<String> = (live.objects.iter())
            .map(|object| object.name.clone())
            .collect();
        stage.simulation.rename_objects(&names);
        stage.scene.settings.rename_objects(&names);
        stage.simulation.apply(&live)?;
        stage.forget_picture();
        Ok(Some(live))
    }

    /// Lets food be there that was measured. What was refused comes back with the reason; only a lost device is an error.
    pub fn feed(&mut self, fed: Fed) -> Result<Option<(Box<Settings>, Error)>> {
        let Some(stage) = &mut self.stage else {
            return Ok(None);
        };
        let refused = match fed {
            Fed::Ready(food) => {
                let mut settings = stage.simulation.settings().clone();
                food.put_into(&mut settings);
                let asked = settings.clone();
                let served = stage.simulation.apply_with_food(&settings, *food);
                served.err().map(|error| (Box::new(asked), error))
            }
            Fed::Refused(asked, error) => Some((asked, error)),
        };
        // What was eaten and what lies there is drawn without a step.
        stage.forget_picture();
        match refused {
            // The next device begins with it.
            Some((_, error)) if is_loss(&error) => Err(error),
            refused => Ok(refused),
        }
    }

    /// Can looks be previewed on the running state? It must be small enough to be copied.
    pub fn can_preview(&self) -> bool {
        (self.stage.as_ref()).is_some_and(|stage| stage.simulation.bytes_aside() <= MOST_BYTES)
    }

    /// Runs with another look until [`Self::end_preview`]. There is no preview yet.
    pub fn preview(&mut self, look: &Settings) -> Result<()> {
        if let Some(stage) = &mut self.stage {
            self.previewing = Some(Previewing::begin(stage, &mut self.frames, look)?);
        }
        Ok(())
    }

    /// Has a preview taken steps?
    pub fn has_preview_stepped(&self) -> bool {
        let both = self.previewing.as_ref().zip(self.stage.as_ref());
        both.is_some_and(|(previewing, stage)| previewing.has_stepped(stage))
    }

    /// Ends the preview: everything is as before it. Returns the preview, if there was one.
    pub fn end_preview(&mut self) -> Result<Option<Previewing>> {
        let (Some(previewing), Some(stage)) = (&self.previewing, &mut self.stage) else {
            return Ok(None);
        };
        previewing.end(stage, &mut self.frames)?;
        Ok(self.previewing.take())
    }

    /// Keeps the state that is about to be left, as it was `shown`; also one that has hardly grown, if it is left to go back to
    /// the one before. Says what can come back, where that is another state than before.
    pub fn keep_grown(&mut self, shown: Shown, goes_back: bool) -> Result<Option<Before>> {
        let Some(left) = &mut self.stage else {
            return Ok(None);
        };
        if !self.back.is_kept(left, goes_back) {
            return Ok(None);
        }
        // The one before makes room, if that is enough.
        let room = (self.back.grown.as_ref()).map_or(0, |grown| grown.state.bytes());
        room::check_copy(Grown::bytes_of(left).saturating_sub(room))?;
        self.back.grown = None;
        let grown = Grown::of(left, shown)?;
        let before = Before {
            name: grown.state.name.clone(),
            step: grown.state.checkpoint.snapshot.step,
        };
        self.back.grown = Some(grown);
        Ok(Some(before))
    }

    /// Can another device take the place of one that was lost with this error? Not where there is no scene yet, nor where a
    /// device was lost a moment before.
    pub fn can_change_device(&self, error: &Error) -> bool {
        let is_first = || match &self.lost {
            None => true,
            Some(lost) => lost.runs_since.is_some_and(|t| t.elapsed() >= RUNS_FOR),
        };
        is_loss(error) && self.scene().is_some() && is_first()
    }

    /// Drops what is on the device but the device itself; the scene stays.
    pub fn leave_device(&mut self) {
        // Where other calls failed than those that notice, threads that wait for the device learn it here.
        self.ctx.pretend_lost();
        (self.slices, self.previewing) = (None, None);
        // The state before may be the one that the device was lost by.
        self.back = Back::default();
        let lost = self.lost.get_or_insert_default();
        lost.runs_since = None;
        if let Some(stage) = self.stage.take() {
            lost.remarks = stage.remarks;
            lost.scene = Some(stage.scene);
        }
        self.single_steps = 0;
        self.pacer = Pacer::default();
        self.order = Order::default();
        if let Some(checks) = &mut self.checks {
            checks.restart();
        }
    }

    /// Drops everything but a device that was lost, and what is known of it.
    pub fn end(self) -> (Arc<Context>, Option<Lost>) {
        (Arc::clone(&self.ctx), self.lost)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::on_device::{FORMAT, SMALL, context, stage};

    use glam::Vec2;

    use myxo::render::View;

    fn runner(ctx: &Arc<Context>) -> (Runner, Clocks) {
        let mut frames = Frames::new(ctx, 1).unwrap();
        let answers = Frames::new(ctx, 1).unwrap();
        let clocks = Clocks::new(ctx, &mut frames);
        let runner = Runner::new(Arc::clone(ctx), FORMAT, [frames, answers], true);
        (runner, clocks)
    }

    fn shown(stage: &Stage) -> Shown {
        Shown {
            scene: 0,
            view: View::of(&stage.scene, Vec2::ONE),
            fits: false,
            loaded: stage.scene.settings.clone(),
            file: None,
            is_unsaved: false,
        }
    }

    #[test]
    fn steps_in_slices_end_in_the_same_state() {
        let Some(ctx) = context() else { return };
        let states = [false, true].map(|in_slices| {
            let (mut runner, mut clocks) = runner(&ctx);
            runner.take_stage(stage(&ctx, "pair", &SMALL), &mut clocks);
            for steps in [1, 4] {
                let mut rec = runner.frames.begin().unwrap();
                if in_slices {
                    runner.divide(&mut rec);
                }
                runner.record_steps(&mut rec, steps);
                if in_slices {
                    runner.begin_slices(rec, steps, false);
                    assert!(runner.is_within_slices());
                    while runner.is_within_slices() {
                        // No time at all, and time for all.
                        runner.run_slices(Duration::ZERO, &mut clocks).unwrap();
                        assert!(runner.is_within_slices(), "nothing was submitted");
                        runner.run_slices(Duration::MAX, &mut clocks).unwrap();
                    }
                } else {
                    runner.frames.submit(rec).unwrap();
                    runner.frames.wait_idle().unwrap();
                    runner.have_stepped(steps, &mut clocks).unwrap();
                }
            }
            assert_eq!(clocks.facts.step, 5);
            let check = clocks.facts.check.clone().expect("it was checked");
            assert_eq!(check.problem, None);
            runner.stage.unwrap().simulation.snapshot().unwrap().hash()
        });
        assert_eq!(states[0], states[1], "the state depends on the slices");
        assert_eq!(ctx.messages(), [""; 0]);
    }

    #[test]
    fn single_steps_wait_while_a_film_holds_the_simulation() {
        let Some(ctx) = context() else { return };
        let (mut runner, mut clocks) = runner(&ctx);
        let frame = Duration::from_millis(100);
        let task = |runner: &mut Runner, runs, held| {
            runner.next_task((runs, held), false, frame, Asked::default())
        };
        assert_eq!(task(&mut runner, true, false).steps, 0, "there is no scene");
        runner.take_stage(stage(&ctx, "pair", &SMALL), &mut clocks);
        runner.pacer.measured(Duration::from_millis(1));
        assert!(task(&mut runner, true, false).steps > 1);
        runner.single_steps = 3;
        assert_eq!(task(&mut runner, false, true).steps, 0);
        assert_eq!(task(&mut runner, false, false).steps, 3);
        assert_eq!(task(&mut runner, false, false).steps, 0);
    }

    #[test]
    fn a_lost_device_leaves_its_scene_and_is_replaced_once_in_a_while() {
        let Some(ctx) = context() else { return };
        let lost = Error::Gpu(myxo::gpu::GpuError::DeviceLost {
            call: "vkQueueSubmit",
            last: "no kernel".to_owned(),
        });
        let (mut before, mut clocks) = runner(&ctx);
        assert!(!before.can_change_device(&lost), "there is no scene yet");
        before.take_stage(stage(&ctx, "pair", &SMALL), &mut clocks);
        let shown = shown(before.stage.as_ref().unwrap());
        assert!(before.can_change_device(&lost));
        assert!(!before.can_change_device(&Error::Invalid("no".to_owned())));
        // A state that has hardly grown is kept only to go back.
        assert!(before.keep_grown(shown.clone(), false).unwrap().is_none());
        let kept = before.keep_grown(shown, true).unwrap();
        assert_eq!(kept.map(|before| before.step), Some(0));
        before.stage = Some(stage(&ctx, "pair", &SMALL));
        before.single_steps = 2;
        before.leave_device();
        assert!(before.stage.is_none() && before.back.grown.is_none());
        assert_eq!(before.single_steps, 0);
        assert_eq!(
            before.scene().map(|scene| scene.name.as_str()),
            Some("pair")
        );
        let (ended, left) = before.end();
        assert!(Arc::ptr_eq(&ended, &ctx));

        drop(ended);
        let Some(ctx) = context() else { return };
        let (mut runner, mut clocks) = self::runner(&ctx);
        runner.lost = left;
        assert!(runner.scene().is_some());
        assert!(!runner.can_change_device(&lost), "it does not run yet");
        runner.take_stage(stage(&ctx, "pair", &SMALL), &mut clocks);
        assert!(!runner.can_change_device(&lost), "it has run for a moment");
        let since = Instant::now()
            .checked_sub(RUNS_FOR)
            .expect("the machine runs longer");
        runner.lost.as_mut().unwrap().runs_since = Some(since);
        assert!(runner.can_change_device(&lost));
        assert_eq!(ctx.messages(), [""; 0]);
    }
}
