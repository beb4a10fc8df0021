//! How the trail spreads and decays: in the whole scene, and on single objects.

use serde::Serialize;

use super::{ObjectSettings, Settings, TrailAcross};
use crate::portable;

/// The longest half-life, steps. The share that remains after a step is so near 1 that single precision rounds what is lost: here by up to
/// 0.43 %, and with a half-life of a million steps by up to 4.3 %.
pub const MOST_HALF_LIFE: f64 = 1e5;

/// `[trail]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrailSettings {
    /// The share of a texel that is replaced by the mean of its neighbourhood in a step, 0 to 1.
    pub diffusion: f32,
    /// How far the trail spreads in a step: the standard deviation in every direction, scene radii; 0 as `diffusion` says.
    pub diffusion_length: f32,
    /// Reach of that neighbourhood, in texels.
    pub diffusion_distance: u32,
    /// Does it spread over the lines in which two surfaces meet?
    pub across: TrailAcross,
    /// Share of the trail that remains after a step, deposits included, 0 to 1.
    pub decay: f32,
    /// Steps after which half of the trail remains, at most [`MOST_HALF_LIFE`]; 0 as `decay` says.
    pub half_life: f32,
}

impl TrailSettings {
    /// Does it spread?
    #[must_use]
    pub fn spreads(&self) -> bool {
        self.diffusion > 0.0 || self.diffusion_length > 0.0
    }

    /// The share of the trail that remains after a step, by the half-life if there is one.
    #[must_use]
    pub fn remaining(&self) -> f32 {
        match self.half_life > 0.0 {
            true => portable::exp(-std::f64::consts::LN_2 / f64::from(self.half_life)) as f32,
            false => self.decay,
        }
    }
}

impl Default for TrailSettings {
    fn default() -> Self {
        Self {
            diffusion: 0.5,
            diffusion_length: 0.0,
            diffusion_distance: 1,
            across: TrailAcross::Off,
            decay: 0.95,
            half_life: 0.0,
        }
    }
}

/// `trail` of an `[[object]]`: values that override the scene's for the trail on this object. Other values are the scene's.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OwnTrail {
    /// As [`TrailSettings::diffusion`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diffusion: Option<f32>,
    /// As [`TrailSettings::diffusion_length`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diffusion_length: Option<f32>,
    /// As [`TrailSettings::decay`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decay: Option<f32>,
    /// As [`TrailSettings::half_life`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub half_life: Option<f32>,
}

impl OwnTrail {
    /// The scene's values with these over them.
    #[must_use]
    pub fn over(&self, scene: &TrailSettings) -> TrailSettings {
        TrailSettings {
            diffusion: self.diffusion.unwrap_or(scene.diffusion),
            diffusion_length: self.diffusion_length.unwrap_or(scene.diffusion_length),
            diffusion_distance: scene.diffusion_distance,
            across: scene.across,
            decay: self.decay.unwrap_or(scene.decay),
            half_life: self.half_life.unwrap_or(scene.half_life),
        }
    }

    /// Does it share everything with the scene?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl Settings {
    /// How the trail on an object spreads and decays.
    #[must_use]
    pub fn trail_on(&self, object: &ObjectSettings) -> TrailSettings {
        object.trail.over(&self.trail)
    }

    /// The trail that a particle leaves on an object in a step.
    #[must_use]
    pub fn deposit_on(&self, object: &ObjectSettings) -> f32 {
        object.physarum.deposit.unwrap_or(self.physarum.deposit)
    }

    /// Do objects differ in how much trail particles leave on them, or in how it spreads or decays?
    #[must_use]
    pub fn has_own_rates(&self) -> bool {
        let mut rates = self.objects.iter().map(|object| {
            let trail = self.trail_on(object);
            let spread = match trail.diffusion_length > 0.0 {
                true => (trail.diffusion_length, 0.0),
                false => (0.0, trail.diffusion),
            };
            (spread, trail.remaining(), self.deposit_on(object))
        });
        let first = rates.next();
        first.is_some_and(|first| rates.any(|other| other != first))
    }

    /// Does this hold for the trail of the scene, and for that on every object?
    pub(in crate::scene) fn holds_for_trails(&self, holds: fn(&TrailSettings) -> bool) -> bool {
        let mut objects = self.objects.iter();
        holds(&self.trail) && objects.all(|object| holds(&self.trail_on(object)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parameters::out_of_range;

    /// Would catch: a range that has half-lives of which a step's share of what is lost is rounded by more than half a percent.
    #[test]
    fn half_of_the_trail_remains_after_the_half_life() {
        let off_by = |steps: f32| {
            let trail = TrailSettings {
                half_life: steps,
                ..TrailSettings::default()
            };
            let found = -std::f64::consts::LN_2 / f64::from(trail.remaining()).ln();
            (found / f64::from(steps) - 1.0).abs()
        };
        let longest = MOST_HALF_LIFE as f32;
        for k in 1..=2000 {
            let steps = longest * k as f32 / 2000.0;
            // Half of the last bit below 1, as a part of what is lost.
            let rounding = 0.5_f64.powi(25) * f64::from(steps) / std::f64::consts::LN_2;
            let off = off_by(steps);
            assert!(off <= 1.02 * rounding && off < 0.005, "{steps}: {off}");
        }
        let beyond = (1..=100).map(|k| off_by(longest * (9.0 + 0.01 * k as f32)));
        assert!(beyond.fold(0.0, f64::max) > 0.02, "rounding matters there");
        let mut settings = Settings::default();
        let problems = |settings: &Settings| out_of_range(settings).len();
        settings.trail.half_life = longest;
        settings.objects[0].trail.half_life = Some(longest);
        assert_eq!(problems(&settings), 0);
        settings.trail.half_life = longest.next_up();
        settings.objects[0].trail.half_life = Some(longest.next_up());
        assert_eq!(problems(&settings), 2);
    }

    /// Would catch: scenes that pay for rates of single objects although all agree, by whatever key, and objects that differ unnoticed.
    #[test]
    fn rates_are_own_where_objects_differ_in_effect() {
        let mut settings = Settings::default();
        settings.objects.push(ObjectSettings::default());
        assert!(!settings.has_own_rates());
        let changes: [fn(&mut ObjectSettings); 5] = [
            |object| object.trail.diffusion = Some(0.25),
            |object| object.trail.diffusion_length = Some(0.01),
            |object| object.trail.decay = Some(0.25),
            |object| object.trail.half_life = Some(9.0),
            |object| object.physarum.deposit = Some(0.25),
        ];
        for change in changes {
            let mut both = settings.clone();
            change(&mut both.objects[1]);
            assert!(both.has_own_rates(), "{:?}", both.objects[1]);
            change(&mut both.objects[0]);
            assert!(!both.has_own_rates(), "all have it");
        }
        // The half-life and the diffusion length of the scene take the place of these.
        settings.trail.half_life = 5.0;
        settings.trail.diffusion_length = 0.01;
        settings.objects[1].trail.decay = Some(0.25);
        settings.objects[1].trail.diffusion = Some(0.25);
        assert!(!settings.has_own_rates());
        settings.objects[1].trail.half_life = Some(0.0);
        assert!(settings.has_own_rates());
    }
}
