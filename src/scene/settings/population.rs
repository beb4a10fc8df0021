//! Populations that grow and shrink.

use serde::Serialize;

use super::Settings;

/// The most slots that a population may have for particles.
pub const MOST_POPULATION: u32 = 1 << 27;

/// `[population]`: particles divide and die by how crowded it is round them. The rules, and the defaults but for the frequency, are those
/// of Jones, "From Pattern Formation to Material Computation", Springer 2015; hunger is an addition.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PopulationSettings {
    /// Steps from one time for births and deaths to the next; 0 if the number of particles is constant.
    pub frequency: u32,
    /// Side of the window round a particle that decides whether it divides, in cells.
    pub division_window: u32,
    /// The fewest particles in that window, itself included, with which it divides.
    pub division_least: u32,
    /// The most particles with which it divides.
    pub division_most: u32,
    /// The probability with which it then divides.
    pub division_probability: f32,
    /// Side of the window that decides whether it stays alive, in cells.
    pub survival_window: u32,
    /// The fewest particles in that window, itself included, with which it stays alive.
    pub survival_least: u32,
    /// The most particles with which it stays alive.
    pub survival_most: u32,
    /// The probability with which it dies where there are fewer or more.
    pub death_probability: f32,
    /// Steps for which a hungry particle lives; 0 if none dies of hunger.
    pub hunger: u32,
    /// The most particles that may be alive; at least as many as there are at the start.
    pub capacity: u32,
}

impl Default for PopulationSettings {
    fn default() -> Self {
        Self {
            frequency: 0,
            division_window: 9,
            division_least: 1,
            division_most: 10,
            division_probability: 1.0,
            survival_window: 5,
            survival_least: 0,
            survival_most: 24,
            death_probability: 1.0,
            hunger: 0,
            capacity: 2_000_000,
        }
    }
}

impl PopulationSettings {
    /// Does the number of particles change?
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.frequency > 0
    }

    /// Are there births and deaths in this step, counted from 0? In the first one no particle has moved yet.
    #[must_use]
    pub fn is_due(&self, step: u64) -> bool {
        self.is_on() && step > 0 && step.is_multiple_of(self.frequency.into())
    }

    /// How many cells windows reach from a particle's in each direction; 0 if there are none.
    #[must_use]
    pub fn reach(&self) -> u32 {
        match self.is_on() {
            true => self.division_window.max(self.survival_window) / 2,
            false => 0,
        }
    }
}

impl Settings {
    /// Do particles die if they have been hungry for long? Where there is no food, none does.
    #[must_use]
    pub fn starves(&self) -> bool {
        self.population.is_on() && self.population.hunger > 0 && self.food_count() > 0
    }

    /// How many particles there is room for, living and dead ones.
    #[must_use]
    pub fn slots(&self) -> u32 {
        match self.population.is_on() {
            true => self.population.capacity.max(self.particles.count),
            false => self.particles.count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: hunger in scenes without food, or with a constant number of particles, whose bits it would change.
    #[test]
    fn particles_starve_where_there_is_food() {
        let mut settings = Settings::default();
        settings.population.frequency = 5;
        settings.population.hunger = 100;
        assert!(!settings.starves());
        settings.feeding.scattered = 1;
        assert!(settings.starves());
        let changes: [fn(&mut Settings); 2] = [
            |settings| settings.population.hunger = 0,
            |settings| settings.population.frequency = 0,
        ];
        for change in changes {
            let mut other = settings.clone();
            change(&mut other);
            assert!(!other.starves());
        }
    }

    /// Would catch: births in the first step, or one step late; room that is less than the particles at the start, or more than these where
    /// their number is constant.
    #[test]
    fn populations_change_every_so_many_steps() {
        let mut settings = Settings::default();
        settings.particles.count = 3_000_000;
        let due = |settings: &Settings| {
            let steps = (0..12).filter(|&step| settings.population.is_due(step));
            steps.collect::<Vec<u64>>()
        };
        assert_eq!((due(&settings), settings.slots()), (Vec::new(), 3_000_000));
        assert_eq!(settings.population.reach(), 0);
        settings.population.frequency = 5;
        assert_eq!((due(&settings), settings.slots()), (vec![5, 10], 3_000_000));
        settings.particles.count = 100;
        assert_eq!(
            (settings.population.reach(), settings.slots()),
            (4, 2_000_000)
        );
        settings.population.frequency = 1;
        assert_eq!(due(&settings).len(), 11);
    }
}
