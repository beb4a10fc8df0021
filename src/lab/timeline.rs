//! States of the running scene that are kept from time to time, in memory, for the way back to them. Older ones get fewer.

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::ColorImage;
use myxo::scene::settings::ColorMap;

use crate::lab::facts::KeptFacts;
use crate::lab::state_copy::StateCopy;

/// All kept states together have at most so many bytes, and each that is kept by itself a quarter of it.
pub const MOST_BYTES: u64 = 256 << 20;
/// States that are kept.
pub const MOST: usize = 24;
/// Before this step nothing has grown that would be missed.
const GROWN_AT: u64 = 60;
/// From one state that is kept by itself to the next.
pub const INTERVAL: Duration = Duration::from_secs(10);

/// A state that is kept.
pub struct KeptState {
    /// What continues.
    pub copy: StateCopy,
    /// The colours of its trail.
    pub colors: ColorMap,
    facts: KeptFacts,
}

impl KeptState {
    /// No two states of a window share it.
    pub fn number(&self) -> u64 {
        self.facts.number
    }
}

/// All of them, the first one first.
#[derive(Default)]
pub struct Timeline {
    states: Vec<Arc<KeptState>>,
    last_number: u64,
    /// When one could not be kept.
    failed: Option<Instant>,
}

impl Timeline {
    /// Is it time to keep a state of so many bytes at this step?
    pub fn is_due(&self, now: Instant, step: u64, bytes: u64) -> bool {
        let last = self.states.last().map(|last| &last.facts);
        // If those of the user leave no room, none is kept by itself: it would go at once, and be due again in the next frame.
        let by_user = || self.states.iter().filter(|kept| kept.facts.by_user);
        let taken: u64 = by_user().map(|kept| kept.copy.bytes()).sum();
        let is_full = by_user().count() >= MOST || taken + bytes > MOST_BYTES;
        let is_new = last.is_none_or(|last| last.step != step && now >= last.since + INTERVAL);
        let has_failed = self.failed.is_some_and(|failed| now < failed + INTERVAL);
        is_new && !is_full && !has_failed && step >= GROWN_AT && 4 * bytes <= MOST_BYTES
    }

    /// A state could not be kept; the next one has its turn later.
    pub fn fail(&mut self, now: Instant) {
        self.failed = Some(now);
    }

    /// Is there room for a state of so many bytes at all?
    pub fn has_room(bytes: u64) -> bool {
        bytes <= MOST_BYTES
    }

    /// Keeps a state with a small picture, and returns it. It has gone again if those of the user leave no room.
    pub fn keep(
        &mut self,
        copy: StateCopy,
        (colors, picture): (ColorMap, ColorImage),
        now: Instant,
        by_user: bool,
    ) -> Arc<KeptState> {
        self.last_number += 1;
        let facts = KeptFacts {
            number: self.last_number,
            step: copy.snapshot.step,
            since: now,
            by_user,
            picture: Arc::new(picture),
        };
        let kept = Arc::new(KeptState {
            copy,
            colors,
            facts,
        });
        self.states.push(Arc::clone(&kept));
        self.thin(now);
        kept
    }

    /// The state of this number, if it is still kept.
    pub fn find(&self, number: u64) -> Option<Arc<KeptState>> {
        let found = self.states.iter().find(|kept| kept.number() == number);
        found.cloned()
    }

    /// A state that may have gone comes back to its place; undo has its number.
    pub fn keep_again(&mut self, kept: &Arc<KeptState>) {
        let number = kept.number();
        if self.find(number).is_none() {
            let place = (self.states).partition_point(|other| other.number() < number);
            self.states.insert(place, Arc::clone(kept));
        }
    }

    /// What the interface shows of them.
    pub fn facts(&self) -> Vec<KeptFacts> {
        self.states.iter().map(|kept| kept.facts.clone()).collect()
    }

    /// Another scene comes, or another device.
    pub fn forget(&mut self) {
        self.states.clear();
    }

    fn bytes(&self) -> u64 {
        self.states.iter().map(|kept| kept.copy.bytes()).sum()
    }

    /// Those go that are missed least: kept by themselves, between neighbours that are near for their age; in the end the oldest.
    fn thin(&mut self, now: Instant) {
        while self.states.len() > MOST || self.bytes() > MOST_BYTES {
            let at = |i: usize| self.states[i].facts.since;
            let last = self.states.len() - 1;
            let missed = |&i: &usize| {
                let before = i - 1;
                let gap = at(i + 1)
                    .saturating_duration_since(at(before))
                    .as_secs_f64();
                let age = now.saturating_duration_since(at(i)).as_secs_f64();
                gap / age.max(1e-3)
            };
            let is_free = |i: &usize| !self.states[*i].facts.by_user;
            let free = (1..last).filter(is_free);
            let least = free.min_by(|a, b| missed(a).total_cmp(&missed(b)));
            // Then the first one goes that the user has not kept, and only then those of the user.
            let first = || (0..=last).find(is_free);
            self.states.remove(least.or_else(first).unwrap_or(0));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::scene::settings::Settings;
    use myxo::sim::Snapshot;
    use myxo::sim::types::Particle;

    fn copy(step: u64, particles: usize) -> StateCopy {
        StateCopy {
            snapshot: Snapshot {
                step,
                particles: vec![bytemuck::Zeroable::zeroed(); particles],
                ..Snapshot::default()
            },
            settings: Settings::default(),
        }
    }

    fn keep(
        timeline: &mut Timeline,
        copy: StateCopy,
        now: Instant,
        by_user: bool,
    ) -> Arc<KeptState> {
        let picture = ColorImage::filled([1, 1], egui::Color32::BLACK);
        timeline.keep(copy, (ColorMap::default(), picture), now, by_user)
    }

    /// Would catch: a list that grows without a bound, that forgets the beginning or what the user has kept, and that keeps the same
    /// state again and again.
    #[test]
    fn older_states_get_fewer_and_those_of_the_user_stay() {
        let begun = Instant::now();
        let mut timeline = Timeline::default();
        let at = |i: u64| begun + Duration::from_secs(10 * i);
        assert!(
            !timeline.is_due(at(0), GROWN_AT - 1, 1),
            "nothing has grown"
        );
        let mut own = 0;
        for i in 1..=200 {
            assert!(timeline.is_due(at(i), 100 * i, 1));
            let kept = keep(&mut timeline, copy(100 * i, 1), at(i), i == 50);
            own = if i == 50 { kept.number() } else { own };
            assert!(!timeline.is_due(at(i), 100 * i + 1, 1), "too soon");
            assert!(!timeline.is_due(at(i + 1), 100 * i, 1), "paused");
        }
        let facts = timeline.facts();
        assert_eq!(facts.len(), MOST);
        assert!(timeline.find(own).is_some() && timeline.find(999).is_none());
        assert_eq!(facts.last().map(|last| last.step), Some(20_000));
        assert!(facts[0].step < 4000, "{}", facts[0].step);
        let late = facts.iter().filter(|kept| kept.step > 10_000).count();
        assert!((MOST / 2..MOST - 3).contains(&late), "{late}");
        assert!(facts.is_sorted_by_key(|kept| kept.number));
    }

    /// Would catch: a bound that counts states and not what they take.
    #[test]
    fn large_states_are_kept_within_the_memory_that_is_said() {
        let mut timeline = Timeline::default();
        let now = Instant::now();
        let particles = (MOST_BYTES / 5) as usize / StateCopy::bytes_of_particles();
        for i in 1..=9 {
            keep(
                &mut timeline,
                copy(i, particles),
                now + i as u32 * INTERVAL,
                true,
            );
            assert!(timeline.bytes() <= MOST_BYTES);
        }
        assert_eq!(timeline.facts().len(), 5);
        timeline.forget();
        assert!(timeline.facts().is_empty());
        let later = now + 20 * INTERVAL;
        assert!(timeline.is_due(later, 99, MOST_BYTES / 4));
        assert!(!timeline.is_due(later, 99, MOST_BYTES / 4 + 1));
        timeline.fail(later);
        assert!(!timeline.is_due(later, 99, 1) && timeline.is_due(later + INTERVAL, 99, 1));
        assert!(Timeline::has_room(MOST_BYTES) && !Timeline::has_room(MOST_BYTES + 1));
        assert!(size_of::<Particle>() < StateCopy::bytes_of_particles());
    }

    /// Would catch: a copy of the state in every frame once those of the user take all room, by their number or their size; and a state
    /// that was left, and that undo does not find.
    #[test]
    fn those_of_the_user_may_take_all_room() {
        let now = Instant::now();
        let later = now + 2 * INTERVAL;
        let large = (MOST_BYTES / 5) as usize / StateCopy::bytes_of_particles();
        for (count, particles) in [(MOST as u64, 1), (5, large)] {
            let mut timeline = Timeline::default();
            for step in 1..count {
                keep(&mut timeline, copy(step, particles), now, true);
            }
            let bytes = copy(0, particles).bytes();
            assert!(timeline.is_due(later, 99, bytes), "there is room for one");
            keep(&mut timeline, copy(count, particles), now, true);
            assert!(!timeline.is_due(later, 99, bytes));
            // The state that the user leaves for another one.
            let left = keep(&mut timeline, copy(99, particles), later, false);
            assert!(timeline.find(left.number()).is_none());
            timeline.keep_again(&left);
            assert!(timeline.find(left.number()).is_some());
            assert!(!timeline.is_due(later + INTERVAL, 100, bytes), "it stays");
        }
    }
}
