//! Frames while steps or a picture are under way in slices, and what has to wait for their end.

use crate::lab::answers::Answers;
use crate::lab::command::Command;
use crate::lab::runner::Sliced;
use crate::lab::show::{Seen, Shot};
use crate::lab::stage::Stage;
use crate::lab::waiting::Waiting;
use crate::lab::window::Lab;
use myxo::Result;
use myxo::gpu::Recorder;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Slices that are shorter together are run before input is looked for again.
const LONGEST_SLICES: Duration = Duration::from_millis(4);

impl Lab {
    /// Steps or a picture have been recorded in slices; they begin. The window does not show what was seen.
    pub(super) fn begin_slices(&mut self, rec: Recorder, steps: u32, draws: bool, seen: &Seen) {
        self.runner.begin_slices(rec, steps, draws);
        self.answers = Answers::begin(seen.is_asked, seen.repaint);
        self.forget_places();
    }

    /// Advances the slices under way, and answers if there was input. Returns false if there are none.
    pub(super) fn advance_slices(&mut self) -> Result<bool> {
        if !self.runner.is_within_slices() {
            return Ok(false);
        }
        if (self.answers).is_due(self.host.has_input(), self.awaits_colors()) {
            let begun = Instant::now();
            let repaint = self.answer(false)?;
            self.answers.given(begun, repaint);
        }
        let sliced = (self.runner).run_slices(LONGEST_SLICES, &mut self.clocks)?;
        self.slices_have_run(sliced);
        if sliced.has_drawn {
            self.answer(true)?;
            self.count_picture();
        }
        Ok(true)
    }

    /// Is a picture in other colours to come at once?
    fn awaits_colors(&self) -> bool {
        let colors = self.interface.shown_view().color_map;
        let has_others = |stage: &Stage| stage.has_other_colors(colors);
        self.runner.stage.as_ref().is_some_and(has_others)
    }

    /// Does the rest of the slices at once.
    pub(super) fn finish_steps(&mut self) -> Result<()> {
        let sliced = (self.runner).run_slices(Duration::MAX, &mut self.clocks)?;
        self.slices_have_run(sliced);
        Ok(())
    }

    fn slices_have_run(&mut self, sliced: Sliced) {
        if sliced.is_checked {
            self.host.request_redraw();
        }
        if sliced.has_stepped {
            // However long that took, what is drawn next is of something that moves.
            self.moved = self.host.now();
        }
        if !self.runner.is_within_slices() {
            self.report_messages();
        }
    }

    /// Does what had to wait. If something fails, the rest continues to wait.
    pub(super) fn run_waiting(&mut self) -> Result<()> {
        let mut all = VecDeque::from(std::mem::take(&mut self.waiting));
        while let Some(next) = all.pop_front() {
            let done = match next {
                Waiting::Command(command, size) => self.obey(command, size),
                Waiting::File(path) => {
                    self.take_file(path);
                    Ok(())
                }
                Waiting::Copy(object, ticket) => {
                    self.duplicate_object(object, ticket);
                    Ok(())
                }
                Waiting::Removal(object) => {
                    self.remove_object(object);
                    Ok(())
                }
            };
            if let Err(error) = done {
                self.waiting.extend(all);
                return Err(error);
            }
        }
        Ok(())
    }

    /// Shows the present interface over the last picture; its commands have to wait. If it needs another picture, the next
    /// frame draws that, unless the last one `is_new`. Returns the time until the interface wants to be shown again.
    fn answer(&mut self, is_new: bool) -> Result<Option<Duration>> {
        let seen = self.run_interface()?;
        let size = seen.picture.size;
        self.closing |= seen.shown.commands.contains(&Command::Quit);
        let commands = seen.shown.commands.iter().cloned();
        self.waiting
            .extend(commands.map(|command| Waiting::Command(command, size)));
        self.look_under_pointer(size);
        let shot = Shot {
            view: self.interface.shown_view(),
            answers: true,
            is_between: true,
            picture: seen.picture,
            beside: seen.beside,
            is_moving: false,
            refines: false,
            primitives: seen.primitives,
            pixels_per_point: seen.pixels_per_point,
        };
        let will_do = |stage: &Stage| match is_new {
            true => stage.has_sizes(shot.sizes()),
            false => stage.has_drawn(&shot.view, shot.sizes()),
        } || stage.stands_in(&shot.view, shot.sizes());
        let fits = self.runner.stage.as_ref().is_some_and(will_do);
        if !fits {
            self.forget_places();
            return Ok(seen.repaint);
        }
        let Some(image) = self.next_image()? else {
            self.forget_places();
            return Ok(seen.repaint);
        };
        self.runner.order.has_been_answered();
        let rec = self.runner.answers.begin()?;
        self.clocks.catch_up();
        self.draw(rec, image, shot)?;
        self.runner.answers.wait_idle()?;
        self.clocks.facts.answers_within_steps += u64::from(!is_new);
        self.report_places(seen.pixels_per_point, false)?;
        Ok(seen.repaint)
    }
}
