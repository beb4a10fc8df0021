//! The order in which frames step, answer and draw. On a slow device each frame does one of these, so that the user never waits
//! for all three.

use std::time::Duration;

use crate::lab::pacing::Pacer;

/// The user's input in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Asked {
    /// There was input.
    pub is_asked: bool,
    /// The camera is being moved, or the next picture has to come soon.
    pub touched: bool,
    /// A look is about to be previewed, or the picture has other colours than it should: no step begins before the next picture.
    pub soon: bool,
}

/// The work of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Task {
    /// The number of steps.
    pub steps: u32,
    /// The frame only steps: the window stays as it is, because drawing it would make the user wait longer.
    pub only_steps: bool,
    /// Answers at once, over the picture that is there.
    pub answers: bool,
}

impl Task {
    /// Is it a picture alone, which can come in slices? While the camera is moved the picture is the answer, and comes whole. So does one
    /// that has to come soon, because slices take longer together.
    pub fn may_be_sliced(&self, asked: Asked) -> bool {
        *self == Self::default() && !asked.touched
    }
}

/// Work that earlier frames have left to later ones.
#[derive(Clone, Debug, Default)]
pub struct Order {
    /// Something has changed that no picture shows yet.
    owes_picture: bool,
    /// There was input that the window does not show yet.
    owes_answer: bool,
    /// There was an answer since the last steps. Once between steps, or they would never come while the pointer moves.
    has_answered: bool,
}

impl Order {
    /// Returns the work of the next frame while the simulation runs, `since_last` after the one before. A device that `is_slow`
    /// does one thing at a time; `steps_per_second` is the user's cap, 0 for none.
    pub fn next(
        &mut self,
        pacer: &mut Pacer,
        is_slow: bool,
        since_last: Duration,
        steps_per_second: f32,
        asked: Asked,
    ) -> Task {
        let is_asked = asked.is_asked || self.owes_answer;
        let answers = is_slow && is_asked && !self.has_answered;
        let waits = self.owes_picture || answers || is_slow && asked.soon;
        let steps = pacer.steps(since_last, steps_per_second, asked.touched, waits);
        let only_steps = is_slow && pacer.are_notable(steps);
        self.has_answered = steps == 0 && (self.has_answered || answers);
        self.owes_answer = only_steps && is_asked;
        self.owes_picture = only_steps;
        Task {
            steps,
            only_steps,
            answers,
        }
    }

    /// A frame that answers has taken the picture that was there.
    pub fn owe_picture(&mut self) {
        self.owes_picture = true;
    }

    /// The window has shown the effect of the input while steps were under way.
    pub fn has_been_answered(&mut self) {
        self.owes_answer = false;
    }

    /// The simulation does not run.
    pub fn rest(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seconds of each kind of frame.
    const STEP: f64 = 0.070;
    const PICTURE: f64 = 0.045;
    const ANSWER: f64 = 0.020;

    /// Frames of ten seconds; there is input in those for whose begin `asks` is true. Gives for each frame its task, whether it
    /// had input, and when it begins and ends.
    fn run(asks: impl Fn(f64) -> bool) -> Vec<(Task, bool, f64, f64)> {
        let (mut order, mut pacer) = (Order::default(), Pacer::default());
        pacer.measured(Duration::from_secs_f64(STEP));
        let (mut time, mut last, mut frames) = (0.0, 0.0, Vec::new());
        while time < 10.0 {
            let is_asked = asks(time);
            let asked = Asked {
                is_asked,
                ..Asked::default()
            };
            let task = order.next(&mut pacer, true, Duration::from_secs_f64(last), 0.0, asked);
            last = if task.answers {
                order.owe_picture();
                ANSWER
            } else if task.only_steps {
                f64::from(task.steps) * STEP
            } else {
                PICTURE
            };
            frames.push((task, is_asked, time, time + last));
            time += last;
        }
        frames
    }

    #[test]
    fn a_single_key_waits_for_what_has_begun_and_its_answer() {
        let mut longest = 0.0_f64;
        for key in (0..4000).map(|k| 1.0 + f64::from(k) * 0.001) {
            // The first frame that begins after the key takes it in.
            let taken = std::cell::Cell::new(false);
            let frames = run(|time| time >= key && !taken.replace(time >= key));
            let (.., taken, _) = frames.iter().find(|frame| frame.1).expect("it is asked");
            let (.., shown) = frames
                .iter()
                .find(|(task, _, begins, _)| begins >= taken && !task.only_steps)
                .expect("it is shown");
            longest = longest.max(shown - key);
        }
        assert!(longest < STEP + ANSWER + 1e-3, "{longest} s");
    }

    #[test]
    fn steps_and_pictures_come_while_the_pointer_moves() {
        let frames = run(|_| true);
        let count = |is: fn(&Task) -> bool| frames.iter().filter(|(task, ..)| is(task)).count();
        let steps = count(|task| task.only_steps);
        let answers = count(|task| task.answers);
        let pictures = frames.len() - steps - answers;
        let cycles = 10.0 / (STEP + PICTURE + ANSWER);
        for kind in [steps, answers, pictures] {
            assert!(kind as f64 > 0.9 * cycles, "{steps} {answers} {pictures}");
        }
        // Input that comes with steps is answered right after them.
        for pair in frames.windows(2) {
            assert!(!pair[0].0.only_steps || pair[1].0.answers, "{pair:?}");
        }
    }

    #[test]
    fn a_key_that_comes_with_steps_is_answered_though_nothing_follows() {
        let (mut order, mut pacer) = (Order::default(), Pacer::default());
        pacer.measured(Duration::from_secs_f64(STEP));
        let mut next = |order: &mut Order, is_asked| {
            let asked = Asked {
                is_asked,
                ..Asked::default()
            };
            order.next(&mut pacer, true, Duration::from_millis(100), 0.0, asked)
        };
        assert!(next(&mut order, true).answers, "the pointer");
        order.owe_picture();
        assert_eq!(next(&mut order, false), Task::default(), "its picture");
        assert!(next(&mut order, true).only_steps, "the key comes here");
        assert!(next(&mut order, false).answers);
    }

    /// Would catch: steps or slices that come before the colours of a look that is previewed, whatever the frames before did.
    #[test]
    fn a_picture_that_has_to_come_soon_is_next_and_whole() {
        let soon = Asked {
            is_asked: true,
            touched: true,
            soon: true,
        };
        let quiet = Asked::default();
        let frame = Duration::from_millis(100);
        let (mut steps, mut slices) = (0, 0);
        for before in 0..12 {
            let (mut order, mut pacer) = (Order::default(), Pacer::default());
            pacer.measured(Duration::from_secs_f64(STEP));
            for i in 0..before {
                let asked = Asked {
                    is_asked: i % 5 == 2,
                    ..quiet
                };
                let task = order.next(&mut pacer, true, frame, 0.0, asked);
                if task.answers {
                    order.owe_picture();
                }
            }
            let otherwise = order
                .clone()
                .next(&mut pacer.clone(), true, frame, 0.0, quiet);
            steps += otherwise.steps;
            slices += u32::from(otherwise.may_be_sliced(quiet));
            let task = order.next(&mut pacer, true, frame, 0.0, soon);
            assert_eq!((task.steps, task.only_steps), (0, false), "{before}");
            assert!(!task.may_be_sliced(soon), "{before}");
        }
        assert!(steps > 0 && slices > 0, "it makes no difference");
    }

    #[test]
    fn nothing_is_split_on_a_quick_device() {
        let (mut order, mut pacer) = (Order::default(), Pacer::default());
        pacer.measured(Duration::from_millis(30));
        let asked = Asked {
            is_asked: true,
            touched: false,
            ..Asked::default()
        };
        let task = order.next(&mut pacer, false, Duration::from_millis(90), 0.0, asked);
        assert_eq!(
            (task.steps, task.only_steps, task.answers),
            (2, false, false)
        );
    }

    #[test]
    fn who_has_paused_is_answered_as_at_first() {
        let (mut order, mut pacer) = (Order::default(), Pacer::default());
        pacer.measured(Duration::from_secs_f64(STEP));
        let asked = Asked {
            is_asked: true,
            touched: false,
            ..Asked::default()
        };
        let next = |order: &mut Order, pacer: &mut Pacer| {
            order.next(pacer, true, Duration::from_millis(100), 0.0, asked)
        };
        assert!(next(&mut order, &mut pacer).answers);
        order.owe_picture();
        order.rest();
        assert!(next(&mut order, &mut pacer).answers, "not a step first");
    }
}
