//! Pulses that a scene begins by itself.

use serde::Serialize;

/// Entries of pulses that a scene may have.
pub const MOST_PULSE_ENTRIES: usize = 256;

/// `[[pulse]]`: a wave that begins at a step, and sweeps particles along.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PulseSettings {
    /// Where it begins, in scene radii from the scene's centre; on a surface or not.
    pub at: [f32; 3],
    /// The step that it begins with, counted from 0.
    pub step: u32,
    /// It begins again every so many steps; 0 for once.
    pub every: u32,
    /// How far it goes in a step, in scene radii.
    pub speed: f32,
    /// How wide it is, in scene radii.
    pub width: f32,
    /// How far from its beginning it ends, in scene radii.
    pub reach: f32,
    /// How far particles turn with it, and how much of its speed they take, 0 to 1.
    pub strength: f32,
}

impl Default for PulseSettings {
    fn default() -> Self {
        Self {
            at: [0.0, 1.0, 0.0],
            step: 0,
            every: 0,
            speed: 0.01,
            width: 0.25,
            reach: 2.0,
            strength: 0.6,
        }
    }
}

impl PulseSettings {
    /// Does it begin, or begin again, in this step?
    #[must_use]
    pub fn begins_in(&self, step: u64) -> bool {
        let after = step.checked_sub(u64::from(self.step));
        after.is_some_and(|after| match self.every {
            0 => after == 0,
            every => after.is_multiple_of(u64::from(every)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a pulse that begins a step late, once too often, or never again.
    #[test]
    fn pulses_begin_at_their_steps() {
        let begins = |step, every| {
            let pulse = PulseSettings {
                step,
                every,
                ..PulseSettings::default()
            };
            (0..20)
                .filter(|at| pulse.begins_in(*at))
                .collect::<Vec<u64>>()
        };
        assert_eq!(begins(0, 0), [0]);
        assert_eq!(begins(7, 0), [7]);
        assert_eq!(begins(3, 8), [3, 11, 19]);
        assert_eq!(begins(18, 1), [18, 19]);
        assert!(begins(20, 1).is_empty());
    }
}
