//! Consequences of the transfer strategy, the distance method and what crosses contacts for a step.

use super::settings::{DistanceMethod, Settings, Strategy, TrailAcross};

impl Settings {
    /// The strategy of transfer that takes effect: with a single object there is nothing to change to.
    #[must_use]
    pub fn strategy(&self) -> Strategy {
        if self.objects.len() > 1 {
            self.transfer.strategy
        } else {
            Strategy::None
        }
    }

    /// Does the trail spread over the lines in which surfaces of two objects meet?
    #[must_use]
    pub fn trail_crosses(&self) -> bool {
        self.trail.across == TrailAcross::On
            && !self.holds_for_trails(|trail| !trail.spreads())
            && self.objects.len() > 1
    }

    /// Are distances computed by the graphics pipeline?
    #[must_use]
    pub fn uses_raster(&self) -> bool {
        self.objects.len() > 1 && self.distance.method == DistanceMethod::Raster
    }
}

impl Strategy {
    /// Do sensors see other objects? They do if particles can change to them.
    #[must_use]
    pub fn sees_across(self) -> bool {
        !matches!(self, Self::None | Self::Respawn)
    }

    /// Do particles that go into another object restart anywhere on their own?
    #[must_use]
    pub fn respawns(self) -> bool {
        self == Self::Respawn
    }

    /// May particles be sorted? With one strategy each keeps its slot.
    #[must_use]
    pub fn may_sort(self) -> bool {
        self != Self::Scattered
    }

    /// Do objects have windows of the particle buffer?
    #[must_use]
    pub fn has_windows(self) -> bool {
        matches!(self, Self::Sequential | Self::Parallel)
    }
}
