//! Steps that take longer than a hand waits: they go to the device in slices, and between these the window answers over the
//! picture that is there.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use myxo::Result;
use myxo::gpu::Recorder;

use super::interface::Command;
use super::show::Shot;
use super::stage::Stage;
use super::window::Lab;

/// The system's events are taken in as often, if no single kernel takes longer.
const LONGEST_SLICES: Duration = Duration::from_millis(25);
/// From one answer to the next at the least, or a pointer that moves would keep the steps from coming.
const BETWEEN_ANSWERS: Duration = Duration::from_millis(50);

/// Steps that the device has been given a part of. Until it has all of them nobody else may touch the simulation.
pub(super) struct UnderWay {
    rec: Recorder,
    steps: u32,
    /// When the window last showed something new.
    shown: Instant,
}

/// What is left to the frame that comes after the steps.
#[derive(Default)]
pub(super) struct Left {
    /// What the interface asked for.
    pub commands: Vec<Command>,
    /// Files that were dropped onto the window.
    pub files: Vec<PathBuf>,
    /// The time that answers have taken.
    pub time: Duration,
}

impl Lab {
    /// Steps have been recorded in slices; they begin.
    pub(super) fn set_out(&mut self, rec: Recorder, steps: u32) {
        self.under_way = Some(UnderWay {
            rec,
            steps,
            shown: Instant::now(),
        });
    }

    /// Goes on with the steps that are under way, and answers if something was asked. False where there are none.
    pub(super) fn go_on(&mut self) -> Result<bool> {
        let Some(under_way) = &mut self.under_way else {
            return Ok(false);
        };
        let is_asked = !self.egui.egui_input().events.is_empty();
        if is_asked && under_way.shown.elapsed() >= BETWEEN_ANSWERS {
            under_way.shown = Instant::now();
            self.answer()?;
        }
        let began = Instant::now();
        while began.elapsed() < LONGEST_SLICES
            && let Some(under_way) = &mut self.under_way
        {
            if !self.frames.run_slice(&mut under_way.rec)? {
                self.finish_steps()?;
            }
        }
        Ok(true)
    }

    /// Brings the steps that are under way to their end, if there are any.
    pub(super) fn finish_steps(&mut self) -> Result<()> {
        let Some(UnderWay { rec, steps, .. }) = self.under_way.take() else {
            return Ok(());
        };
        self.frames.submit(rec)?;
        self.frames.wait_idle()?;
        self.have_stepped(steps)?;
        self.report_messages();
        Ok(())
    }

    /// The interface as it is now, over the picture that is there. What it asks for has to wait.
    fn answer(&mut self) -> Result<()> {
        self.left.time += self.clocks.tick();
        let Some(seen) = self.run_interface()? else {
            return Ok(());
        };
        self.left.commands.extend(seen.shown.commands);
        let shot = Shot {
            view: self.interface.view,
            answers: true,
            is_between: true,
            picture: seen.picture,
            beside: seen.beside,
            is_moving: false,
            primitives: &seen.primitives,
            pixels_per_point: seen.pixels_per_point,
        };
        let has_picture = |stage: &Stage| stage.has_picture(shot.sizes());
        if !self.stage.as_ref().is_some_and(has_picture) {
            // The window has another size; its picture comes with the next frame.
            self.forget_places();
            return Ok(());
        }
        let rec = self.answers.begin()?;
        let Some(image) = self.swapchain.acquire()? else {
            self.forget_places();
            return Ok(());
        };
        self.draw(rec, image, &shot)?;
        self.answers.wait_idle()?;
        self.clocks.facts.answers_within_steps += 1;
        self.tell_places(&seen.context, seen.pixels_per_point)
    }
}
