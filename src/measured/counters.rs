//! What is counted at the end of a run, for its report: particles, trail, transfers.

use myxo::scene::parameters::grouped;
use myxo::scene::settings::ObjectSettings;
use myxo::sim::transfers::count_text;
use myxo::sim::{Setup, Snapshot};
use serde::{Deserialize, Serialize};

/// What was counted at the end of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Counters {
    /// Particles that are alive.
    #[serde(default)]
    pub population: u64,
    /// Where the number of particles changes: particles that were born so far.
    #[serde(default)]
    pub births: u64,
    /// Particles that died so far.
    #[serde(default)]
    pub deaths: u64,
    /// How many times so far a particle did not divide because as many were alive as there may be.
    #[serde(default)]
    pub births_refused: u64,
    /// Particle ids that no particle has; always 0.
    pub lost: u64,
    /// Particles whose id another one has too; always 0.
    pub doubled: u64,
    /// Sum over all texels of trail times area, in world units.
    pub trail_mass: f64,
    /// Particles that went into another object and were selected to change, the refused ones among them.
    #[serde(default)]
    pub selected: u64,
    /// Particles that have arrived: on another object, or back on their own (`returned`); with the strategy `respawn`, that restarted.
    #[serde(default)]
    pub transferred: u64,
    /// Particles that left for their own object, because they turned round at a no-go area, the surrounding texels had no nearest
    /// triangle of another one, or, with one particle a cell, the cell where they would have landed was taken.
    #[serde(default)]
    pub returned: u64,
    /// Particles that continued from the place where their walk met the other object; the others went to its nearest point, or turned
    /// round at a no-go area.
    #[serde(default)]
    pub crossed: u64,
    /// How many times a particle stayed on its object because the transfer buffer was full.
    #[serde(default)]
    pub transfer_overflow: u64,
    /// The transfer buffer size that would have done so far.
    #[serde(default)]
    pub transfer_buffer_wanted: u64,
    /// With one particle a cell: particles that were refused one in the last step and stayed where they were. Those that were refused
    /// one on another object count as `returned`.
    #[serde(default)]
    pub stayed: u64,
    /// How many times so far a particle stayed that would have moved with one more round of claims.
    #[serde(default)]
    pub left_over: u64,
    /// How many particles have left each object for each other one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flux: Vec<Flux>,
}

/// Particles from one object to another.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Flux {
    /// The object that they left.
    pub from: String,
    /// The object that they went to.
    pub to: String,
    /// How many.
    pub particles: u64,
}

impl Counters {
    /// Counts a state.
    #[must_use]
    pub fn of(snapshot: &Snapshot, setup: &Setup, objects: &[ObjectSettings]) -> Self {
        let census = snapshot.census();
        let population = snapshot.population.first().copied().unwrap_or_default();
        let transfers = &snapshot.transfers;
        let flow = &transfers.flow;
        let pairs = transfers.flux.iter().enumerate();
        let changed = |&(pair, count): &(usize, &u32)| {
            *count > 0 && pair / objects.len() != pair % objects.len()
        };
        // Transfers from an object to itself.
        let returned = transfers.flux.iter().step_by(objects.len() + 1);
        let flux = |(pair, &particles): (usize, &u32)| Flux {
            from: objects[pair / objects.len()].name.clone(),
            to: objects[pair % objects.len()].name.clone(),
            particles: particles.into(),
        };
        Self {
            population: snapshot.living_count(),
            births: population.births.into(),
            deaths: population.deaths.into(),
            births_refused: population.refused.into(),
            lost: census.lost,
            doubled: census.doubled,
            trail_mass: snapshot.trail_mass(setup),
            selected: flow.selected.into(),
            transferred: flow.arrived.into(),
            returned: returned.map(|&count| u64::from(count)).sum(),
            crossed: flow.crossed.into(),
            transfer_overflow: flow.refused.into(),
            transfer_buffer_wanted: flow.most_wanted.into(),
            stayed: snapshot.stayed_count(),
            left_over: flow.left_over.into(),
            flux: pairs.filter(changed).map(flux).collect(),
        }
    }

    /// What to do about particles that could not divide for want of room, if there were any.
    #[must_use]
    pub fn full(&self, slots: u32) -> Option<String> {
        (self.births_refused > 0).then(|| {
            format!(
                "the population reached its capacity: {} times a particle did not divide because as many were alive as there may be; raise \
                 population.capacity from {}",
                count_text(self.births_refused),
                grouped(slots.into()),
            )
        })
    }

    /// What to do about particles that were refused, if any were.
    #[must_use]
    pub fn overflow(&self, buffer_size: u32) -> Option<String> {
        let Self {
            transfer_overflow,
            transfer_buffer_wanted,
            ..
        } = *self;
        (transfer_overflow > 0).then(|| {
            format!(
                "transfers overflowed: {} times a particle found the transfer buffer full and stayed on its object; \
                 raise transfer.buffer_size from {} to {}",
                count_text(transfer_overflow),
                grouped(buffer_size.into()),
                grouped(transfer_buffer_wanted as f64)
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_population_says_what_to_raise() {
        let mut counters = Counters::default();
        assert_eq!(counters.full(4000), None);
        counters.births_refused = 12_345;
        let text = counters.full(4000).unwrap_or_default();
        assert!(
            text.contains("12,345 times") && text.ends_with("raise population.capacity from 4000"),
            "{text}"
        );
    }

    #[test]
    fn an_overflow_says_which_size_would_have_done() {
        let mut counters = Counters::default();
        assert_eq!(counters.overflow(16), None);
        counters.transfer_overflow = 12_345;
        counters.transfer_buffer_wanted = 812;
        let text = counters.overflow(16).unwrap_or_default();
        assert!(
            text.contains("12,345 times") && text.ends_with("from 16 to 812"),
            "{text}"
        );
    }
}
