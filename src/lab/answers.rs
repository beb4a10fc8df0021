//! Answers to input while steps are under way, over the picture that is there.

use std::time::{Duration, Instant};

/// From one answer to the next at the least, or a pointer that moves would keep the steps from coming.
const BETWEEN_ANSWERS: Duration = Duration::from_millis(20);

/// When the window answers next, while steps are under way.
pub struct Answers {
    /// There was input that the window does not show yet.
    owed: bool,
    /// When the interface wants to be shown again.
    repaint: Option<Instant>,
    /// Before that there is no answer.
    rests_until: Instant,
}

impl Answers {
    /// The steps begin; `owed` says that there was input, `repaint` when the interface wants to be shown again.
    pub fn begin(owed: bool, repaint: Option<Duration>) -> Self {
        let now = Instant::now();
        Self {
            owed,
            repaint: repaint.and_then(|delay| now.checked_add(delay)),
            rests_until: now,
        }
    }

    /// Is an answer due? If the picture is `awaited`, what the interface shows without input can wait for it, too.
    pub fn is_due(&self, has_input: bool, awaited: bool) -> bool {
        let now = Instant::now();
        let repaints = !awaited && self.repaint.is_some_and(|due| due <= now);
        (self.owed || has_input || repaints) && self.rests_until <= now
    }

    /// Notes an answer that was begun at this time. The steps then have as much time as it took.
    pub fn given(&mut self, begun: Instant, repaint: Option<Duration>) {
        let took = begun.elapsed();
        *self = Self::begin(false, repaint);
        self.rests_until += BETWEEN_ANSWERS.max(took);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_due_when_there_is_input_and_leave_the_steps_as_much_time() {
        let quiet = Answers::begin(false, None);
        assert!(!quiet.is_due(false, false) && quiet.is_due(true, false));
        assert!(
            Answers::begin(true, None).is_due(false, false),
            "it is owed"
        );
        let repaints = Answers::begin(false, Some(Duration::ZERO));
        assert!(repaints.is_due(false, false) && !repaints.is_due(false, true));
        assert!(repaints.is_due(true, true), "input never waits");
        let far = Duration::from_secs(3600);
        assert!(!Answers::begin(false, Some(far)).is_due(false, false));
        assert!(!Answers::begin(false, Some(Duration::MAX)).is_due(false, false));
        let mut answers = Answers::begin(true, None);
        let long = Instant::now()
            .checked_sub(far)
            .expect("the machine runs longer");
        answers.given(long, None);
        assert!(!answers.is_due(true, false), "an hour is the steps' now");
        answers.given(Instant::now(), None);
        answers.rests_until -= BETWEEN_ANSWERS;
        assert!(!answers.is_due(false, false), "it was given");
    }
}
