//! The autopilot: from look to look, round the scene, in the picture alone, until something comes in.

use egui::{Event, Pos2};

/// A change from one look to the next takes so many seconds, and the look then stays for so many.
pub const MORPH: f64 = 8.0;
const HOLDS: f64 = 10.0;
/// The camera turns by this share of a turn a second.
const TURNS: f32 = 1.0 / 90.0;
/// A frame that took longer than this many seconds is no reason to jump.
const LONGEST: f64 = 0.2;
/// The time at which it begins becomes a number below this, which leads to a first look.
const PRIME: u64 = 1_000_003;
/// A pointer that moves less far does not end it, points: tables shake.
const SHAKES: f32 = 8.0;

/// On its way, or not.
#[derive(Clone, Debug, Default)]
pub struct Autopilot {
    drift: Option<Drift>,
}

#[derive(Clone, Debug)]
struct Drift {
    /// The picture was alone before.
    was_alone: bool,
    last: f64,
    /// When the next look comes.
    next: f64,
    pointer: Option<Pos2>,
    /// Looks that were taken so far.
    looks: u64,
}

/// What it does in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Drifted {
    /// The share of a turn by which the camera goes on.
    pub turns: f32,
    /// Another look is due, the one of this number.
    pub look: Option<u64>,
}

impl Autopilot {
    /// Is it on its way?
    pub fn is_on(&self) -> bool {
        self.drift.is_some()
    }

    /// Begins, at a time in seconds; the first look comes at once.
    pub fn begin(&mut self, now: f64, was_alone: bool) {
        self.drift = Some(Drift {
            was_alone,
            last: now,
            next: now,
            pointer: None,
            looks: now.to_bits() % PRIME,
        });
    }

    /// Ends if one of these events is the user's. Says whether the picture was alone before.
    pub fn end_by(&mut self, events: &[Event], pointer: Option<Pos2>) -> Option<bool> {
        let drift = self.drift.as_mut()?;
        let moved = match (drift.pointer, pointer) {
            (Some(before), Some(now)) => before.distance(now) > SHAKES,
            _ => false,
        };
        drift.pointer = drift.pointer.or(pointer);
        let is_users = |event: &Event| {
            matches!(
                event,
                Event::Key {
                    pressed: true,
                    repeat: false,
                    ..
                } | Event::PointerButton { pressed: true, .. }
                    | Event::MouseWheel { .. }
                    | Event::Touch { .. }
                    | Event::Paste(_)
                    | Event::Copy
            )
        };
        if !moved && !events.iter().any(is_users) {
            return None;
        }
        self.drift.take().map(|drift| drift.was_alone)
    }

    /// Ends, and says whether the picture was alone before; none where it is off.
    pub fn end(&mut self) -> Option<bool> {
        self.drift.take().map(|drift| drift.was_alone)
    }

    /// A frame, at a time in seconds; none where it is off.
    pub fn advance(&mut self, now: f64) -> Option<Drifted> {
        let drift = self.drift.as_mut()?;
        let seconds = (now - drift.last).clamp(0.0, LONGEST);
        drift.last = now;
        let is_due = now >= drift.next;
        if is_due {
            drift.next = now + MORPH + HOLDS;
            drift.looks = drift.looks.wrapping_add(1);
        }
        Some(Drifted {
            turns: TURNS * seconds as f32,
            look: is_due.then_some(drift.looks),
        })
    }
}

/// Another one of so many than the present one, by a number.
pub fn another(count: usize, present: Option<usize>, number: u64) -> Option<usize> {
    // The golden ratio leads to each of them, and to no two neighbours.
    let share = (number as f64 * 0.618_033_988_749_895).fract();
    match present {
        Some(present) if count > 1 => {
            let step = 1 + (share * (count - 1) as f64) as usize;
            Some((present + step.min(count - 1)) % count)
        }
        Some(_) => None,
        None => (count > 0).then(|| ((share * count as f64) as usize).min(count - 1)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    /// Would catch: looks that do not change, or change before they are there; a camera that jumps after a pause; and an input that
    /// does not end it.
    #[test]
    fn it_drifts_until_something_comes_in() {
        let mut pilot = Autopilot::default();
        assert_eq!(pilot.advance(0.0), None);
        pilot.begin(1.0, true);
        let first = pilot.advance(1.0).expect("it is on");
        assert!(first.look.is_some() && first.turns == 0.0);
        let mut due = Vec::new();
        for tenth in 1..=400 {
            let now = 1.0 + f64::from(tenth) / 10.0;
            let drifted = pilot.advance(now).expect("it is on");
            assert!((drifted.turns - TURNS * 0.1).abs() < 1e-6);
            due.extend(drifted.look.map(|_| now.round()));
        }
        assert_eq!(due, [19.0, 37.0]);
        let jump = pilot.advance(90.0).expect("it is on").turns;
        assert!(jump <= TURNS * LONGEST as f32 + 1e-6, "{jump}");
        // A table that shakes, and keys that come up.
        assert_eq!(pilot.end_by(&[], Some(pos2(10.0, 10.0))), None);
        assert_eq!(pilot.end_by(&[], Some(pos2(13.0, 10.0))), None);
        assert!(pilot.is_on());
        assert_eq!(pilot.end_by(&[], Some(pos2(30.0, 10.0))), Some(true));
        assert!(!pilot.is_on());
        pilot.begin(2.0, false);
        let key = |repeat| Event::Key {
            key: egui::Key::A,
            physical_key: None,
            pressed: true,
            repeat,
            modifiers: egui::Modifiers::NONE,
        };
        assert_eq!(pilot.end_by(&[key(true)], None), None, "the key is held");
        assert_eq!(pilot.end_by(&[key(false)], None), Some(false));
        // From any beginning all looks come.
        for begun in [0.1_f64, 12.3, 4321.7] {
            let (mut present, mut seen) = (Some(0), std::collections::HashSet::new());
            pilot.begin(begun, true);
            for turn in 0..80 {
                let now = begun + 20.0 * f64::from(turn);
                let look = pilot.advance(now).and_then(|drifted| drifted.look);
                present = another(7, present, look.expect("it is due"));
                seen.insert(present);
            }
            assert_eq!(seen.len(), 7, "{begun}: {seen:?}");
        }
    }

    /// Would catch: the same look twice, and a list of one or of none.
    #[test]
    fn another_look_is_another_one() {
        for count in 2..30 {
            for present in 0..count {
                for number in 0..50 {
                    let next = another(count, Some(present), number).expect("there are more");
                    assert!(next < count && next != present);
                }
            }
        }
        let from_first: std::collections::BTreeSet<_> =
            (0..200).filter_map(|n| another(20, Some(0), n)).collect();
        assert_eq!(from_first.len(), 19, "all of them come");
        assert_eq!(another(1, Some(0), 3), None);
        assert_eq!(another(0, None, 3), None);
        assert!(another(3, None, 5).is_some_and(|first| first < 3));
    }
}
