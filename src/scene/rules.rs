//! The rules that particles follow: those of the model, but for those that a scene names.

use super::settings::{Model, PhysarumSettings, Preference, StepOrder, Turning};

/// Rounds of the model `jones`.
const ROUNDS: u32 = 3;
/// The width of sensors of the model `jones`, in cells.
const WIDTH: u32 = 1;

/// The rules of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rules {
    /// Do particles walk before they sense? Then they do not turn in the first step.
    pub moves_first: bool,
    /// Rounds in which particles claim cells; 0 if any number of them may share one.
    pub rounds: u32,
    /// Does a particle turn to a random side where both are better than the middle?
    pub random_ties: bool,
    /// How many cells a sensor reads in each direction from the one that it is in; none if sensors read between texels.
    pub reach: Option<u32>,
}

impl Rules {
    /// Is there one particle a cell?
    #[must_use]
    pub fn is_crowded(&self) -> bool {
        self.rounds > 0
    }

    /// Do kernels need to know the cell of each texel?
    #[must_use]
    pub fn has_cells(&self) -> bool {
        self.is_crowded() || self.reach.is_some()
    }
}

impl PhysarumSettings {
    /// The rules of particles.
    #[must_use]
    pub fn rules(&self) -> Rules {
        let is_jones = self.model == Model::Jones;
        let or = |own: u32, jones: u32| match own {
            0 if is_jones => jones,
            own => own,
        };
        let width = or(self.sensor_width, WIDTH);
        Rules {
            moves_first: match self.order {
                StepOrder::Model => is_jones,
                StepOrder::SenseFirst => false,
                StepOrder::MoveFirst => true,
            },
            rounds: or(self.occupancy_rounds, ROUNDS),
            random_ties: match self.turning {
                Turning::Model => is_jones,
                Turning::Better => false,
                Turning::Random => true,
            },
            reach: (width > 0).then_some(width / 2),
        }
    }

    /// The trail that particles seek; `None` if more is better.
    #[must_use]
    pub fn favourite(&self) -> Option<f32> {
        let has_one = match self.preference {
            Preference::Auto => self.favourite_density > 0.0,
            Preference::More => false,
            Preference::Favourite => true,
        };
        has_one.then_some(self.favourite_density)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a density of 0 that is read as none where it is asked for, or as one where it never was.
    #[test]
    fn a_favourite_of_none_differs_from_no_favourite() {
        let found = Preference::ALL.iter().map(|preference| {
            [0.0, 3.0].map(|density| {
                let physarum = PhysarumSettings {
                    preference: *preference,
                    favourite_density: density,
                    ..PhysarumSettings::default()
                };
                physarum.favourite()
            })
        });
        let expected = [[None, Some(3.0)], [None, None], [Some(0.0), Some(3.0)]];
        assert_eq!(found.collect::<Vec<_>>(), expected);
    }

    /// Would catch: a rule that a model lacks, or a key that the model overrules.
    #[test]
    fn models_set_the_rules_that_a_scene_leaves_out() {
        let mut physarum = PhysarumSettings::default();
        let thesis = Rules {
            moves_first: false,
            rounds: 0,
            random_ties: false,
            reach: None,
        };
        assert_eq!(physarum.rules(), thesis);
        assert!(!thesis.has_cells());
        physarum.model = Model::Jones;
        let jones = Rules {
            moves_first: true,
            rounds: ROUNDS,
            random_ties: true,
            reach: Some(0),
        };
        assert_eq!(physarum.rules(), jones);
        // Rule by rule from one to the other.
        physarum.model = Model::Thesis;
        physarum.order = StepOrder::MoveFirst;
        physarum.occupancy_rounds = ROUNDS;
        physarum.turning = Turning::Random;
        physarum.sensor_width = 1;
        assert_eq!(physarum.rules(), jones);
        physarum.model = Model::Jones;
        physarum.order = StepOrder::SenseFirst;
        physarum.turning = Turning::Better;
        physarum.occupancy_rounds = 9;
        for (width, reach) in [(1, 0), (2, 1), (3, 1), (4, 2), (9, 4)] {
            physarum.sensor_width = width;
            let rules = physarum.rules();
            assert_eq!(rules.reach, Some(reach));
            assert!(!rules.moves_first && !rules.random_ties && rules.rounds == 9);
        }
    }
}
