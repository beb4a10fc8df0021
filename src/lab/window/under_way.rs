//! Steps in slices, and what has to wait for their end.

use crate::lab::command::Command;
use crate::lab::show::{Seen, Shot};
use crate::lab::stage::Stage;
use crate::lab::under_way::*;
use crate::lab::window::Lab;
use myxo::Result;
use myxo::gpu::Recorder;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// The system's events are taken in as often, or a slice later.
const LONGEST_SLICES: Duration = Duration::from_millis(25);
/// From one answer to the next at the least, or a pointer that moves would keep the steps from coming.
const BETWEEN_ANSWERS: Duration = Duration::from_millis(50);

impl Lab {
    /// Steps have been recorded in slices; they begin. The window does not show what was seen.
    pub(super) fn set_out(&mut self, rec: Recorder, steps: u32, seen: &Seen) {
        let mut under_way = UnderWay {
            rec,
            steps,
            owes_answer: seen.is_asked,
            repaint: None,
            rests_until: Instant::now(),
        };
        under_way.wants(seen.repaint);
        self.under_way = Some(under_way);
        self.forget_places();
    }

    /// Goes on with the steps that are under way, and answers if something was asked. False where there are none.
    pub(super) fn go_on(&mut self) -> Result<bool> {
        // Where something fails they are given up.
        let Some(mut under_way) = self.under_way.take() else {
            return Ok(false);
        };
        let now = Instant::now();
        let is_asked = under_way.owes_answer
            || self.host.has_input()
            || under_way.repaint.is_some_and(|due| due <= now);
        if is_asked && under_way.rests_until <= now {
            self.answer(&mut under_way)?;
            // An answer that takes long leaves the steps as much.
            under_way.rests_until = Instant::now() + BETWEEN_ANSWERS.max(now.elapsed());
        }
        let began = Instant::now();
        while began.elapsed() < LONGEST_SLICES {
            if !self.frames.run_slice(&mut under_way.rec)? {
                self.frames.submit(under_way.rec)?;
                self.frames.wait_idle()?;
                self.have_stepped(under_way.steps)?;
                self.report_messages();
                return Ok(true);
            }
        }
        self.under_way = Some(under_way);
        Ok(true)
    }

    /// Does the rest of the steps at once.
    pub(super) fn finish_steps(&mut self) -> Result<()> {
        let Some(mut under_way) = self.under_way.take() else {
            return Ok(());
        };
        while self.frames.run_slice(&mut under_way.rec)? {}
        self.frames.submit(under_way.rec)?;
        self.frames.wait_idle()?;
        self.have_stepped(under_way.steps)
    }

    /// Does what had to wait. Where something fails the rest goes on waiting.
    pub(super) fn do_what_was_left(&mut self) -> Result<()> {
        let mut left = VecDeque::from(std::mem::take(&mut self.left));
        while let Some(next) = left.pop_front() {
            let done = match next {
                Left::Command(command, size) => {
                    let context = self.host.context().clone();
                    self.obey(&context, command, size)
                }
                Left::File(path) => {
                    self.take_file(path);
                    Ok(())
                }
                Left::Copy(object, ticket) => {
                    self.duplicate_object(object, ticket);
                    Ok(())
                }
                Left::Removal(object) => {
                    self.remove_object(object);
                    Ok(())
                }
            };
            if let Err(error) = done {
                self.left.extend(left);
                return Err(error);
            }
        }
        Ok(())
    }

    /// The interface as it is now, over the picture that is there. What it asks for has to wait.
    fn answer(&mut self, under_way: &mut UnderWay) -> Result<()> {
        let seen = self.run_interface()?;
        under_way.owes_answer = false;
        under_way.wants(seen.repaint);
        let size = seen.picture.size;
        self.closing |= seen.shown.commands.contains(&Command::Quit);
        let commands = seen.shown.commands.iter().cloned();
        self.left
            .extend(commands.map(|command| Left::Command(command, size)));
        self.look_under_hand(size);
        let shot = Shot {
            view: self.interface.document.view,
            answers: true,
            is_between: true,
            picture: seen.picture,
            beside: seen.beside,
            is_moving: false,
            primitives: &seen.primitives,
            pixels_per_point: seen.pixels_per_point,
        };
        let is_there = |stage: &Stage| stage.has_drawn(&shot.view, shot.sizes());
        // Another picture cannot be drawn now; the next frame does.
        if !self.stage.as_ref().is_some_and(is_there) {
            self.forget_places();
            return Ok(());
        }
        let Some(image) = self.front.acquire()? else {
            self.forget_places();
            return Ok(());
        };
        self.order.has_been_answered();
        let rec = self.answers.begin()?;
        self.clocks.catch_up();
        self.draw(rec, image, &shot)?;
        self.answers.wait_idle()?;
        self.clocks.facts.answers_within_steps += 1;
        self.tell_places(&seen.context, seen.pixels_per_point, false)
    }
}
