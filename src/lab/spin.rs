//! The camera goes on for a moment after a drag, slower and slower.

use glam::Vec2;

/// How quickly it slows down: the share of the speed that is left after a second is `exp(-this)`.
const SLOWS: f32 = 7.0;
/// It stops after this many seconds.
const LONGEST: f64 = 0.6;
/// Slower drags stop where they end, pixels a second.
const LEAST: f32 = 60.0;
/// A pointer that has rested for this many seconds before its release has stopped; so has one that rested for a whole frame.
const RESTED: f64 = 0.08;
/// How much the last frame weighs in the speed of a drag.
const NEWEST: f32 = 0.6;

/// What a drag moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The camera about its target.
    Orbit,
    /// The camera beside it.
    Pan,
}

/// The speed of a drag, and what is left of it afterwards.
#[derive(Clone, Copy, Debug, Default)]
pub struct Spin {
    /// While it is dragged: what, pixels a second, and when it moved last.
    dragged: Option<(Way, Vec2, f64)>,
    /// Afterwards: what, pixels a second, and when it was released.
    free: Option<(Way, Vec2, f64)>,
}

impl Spin {
    /// Everything stops.
    pub fn stop(&mut self) {
        *self = Self::default();
    }

    /// Is the camera going on?
    pub fn is_free(&self) -> bool {
        self.free.is_some()
    }

    /// A frame of a drag, of so many seconds.
    pub fn drag(&mut self, way: Way, pixels: Vec2, seconds: f32, now: f64) {
        let speed = pixels / seconds.max(1e-3);
        let speed = match self.dragged {
            Some((before, old, _)) if before == way => old.lerp(speed, NEWEST),
            _ => speed,
        };
        self.free = None;
        self.dragged = Some((way, speed, now));
    }

    /// A frame without one. Gives what moves, and by how many pixels.
    pub fn go_on(&mut self, is_held: bool, seconds: f32, now: f64) -> Option<(Way, Vec2)> {
        if is_held {
            return None;
        }
        if let Some((way, speed, moved)) = self.dragged.take() {
            let rests = now - moved > RESTED.max(1.5 * f64::from(seconds));
            self.free = (!rests && speed.length() >= LEAST).then_some((way, speed, now));
        }
        let (way, speed, released) = self.free?;
        let left = (-SLOWS * seconds).exp();
        self.free = (now - released < LONGEST).then_some((way, speed * left, released));
        Some((way, speed * ((1.0 - left) / SLOWS)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The way that is gone after a drag of 10 pixels a frame, and how long it takes.
    fn after(frames: f32, rests: f64) -> (f32, f64) {
        let (seconds, mut now) = (1.0 / frames, 10.0);
        let step = f64::from(seconds);
        let mut spin = Spin::default();
        for _ in 0..20 {
            spin.drag(Way::Orbit, Vec2::new(600.0 * seconds, 0.0), seconds, now);
            now += step;
        }
        now += rests;
        let (released, mut gone) = (now, 0.0);
        while let Some((way, by)) = spin.go_on(false, seconds, now) {
            assert_eq!(way, Way::Orbit);
            gone += by.x;
            now += step;
        }
        (gone, now - released)
    }

    /// Would catch: a camera that never stops, that depends on the frame rate, or that goes on after the pointer has rested.
    #[test]
    fn it_slows_down_within_a_moment_and_not_at_all_after_a_rest() {
        let quick = after(120.0, 0.0);
        let slow = after(20.0, 0.0);
        for (gone, seconds) in [quick, slow] {
            assert!((60.0..90.0).contains(&gone), "{gone} pixels");
            assert!(seconds < LONGEST + 0.11, "{seconds} s");
        }
        assert!((quick.0 - slow.0).abs() < 4.0, "{quick:?} {slow:?}");
        assert_eq!(after(60.0, 0.2).0, 0.0);
        let mut spin = Spin::default();
        spin.drag(Way::Pan, Vec2::X, 0.1, 1.0);
        assert!(spin.go_on(false, 0.1, 1.1).is_none(), "it was slow");
        spin.drag(Way::Pan, Vec2::new(50.0, 0.0), 0.1, 2.0);
        assert!(spin.go_on(true, 0.1, 2.1).is_none(), "it is held");
        assert!(spin.go_on(false, 0.1, 2.1).is_some() && spin.is_free());
        spin.stop();
        assert!(spin.go_on(false, 0.1, 2.2).is_none());
    }
}
