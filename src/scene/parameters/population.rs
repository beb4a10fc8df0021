//! The rows of the parameter table for populations that grow and shrink.

use super::{Effect, Kind, Number, Parameter, Scale};

/// Parameters of births and deaths.
pub(super) const POPULATION: &[Parameter] = &[
    Parameter {
        key: "population.frequency",
        name: "Test frequency",
        unit: "steps",
        help: "Every so many steps particles divide and die by how crowded it is round them; to grow, there must be fewer than the capacity. 0: their number is constant.",
        effect: Effect::Restart,
        kind: whole!(population.frequency: u32, (0.0, 10_000.0), (0.0, 30.0), Linear),
    },
    Parameter {
        key: "population.division_window",
        name: "Division window",
        unit: "cells",
        help: "Side of the square of cells round a particle in which particles are counted to decide whether it divides. An even number counts as the next odd one.",
        effect: Effect::Restart,
        kind: whole!(population.division_window: u32, (1.0, 9.0), (1.0, 9.0), Linear),
    },
    Parameter {
        key: "population.division_least",
        name: "Least to divide",
        unit: "particles",
        help: "A particle that has just moved divides only with so many particles in the division window, itself included.",
        effect: Effect::Live,
        kind: whole!(population.division_least: u32, (0.0, 1e6), (0.0, 81.0), Linear),
    },
    Parameter {
        key: "population.division_most",
        name: "Most to divide",
        unit: "particles",
        help: "It divides only with at most so many particles in the division window, itself included.",
        effect: Effect::Live,
        kind: whole!(population.division_most: u32, (0.0, 1e6), (0.0, 81.0), Linear),
    },
    Parameter {
        key: "population.division_probability",
        name: "Division probability",
        unit: "",
        help: "How probable it is that a particle divides that may.",
        effect: Effect::Live,
        kind: real!(
            population.division_probability,
            (0.0, 1.0),
            (0.0, 1.0),
            Linear
        ),
    },
    Parameter {
        key: "population.survival_window",
        name: "Survival window",
        unit: "cells",
        help: "Side of the square of cells round a particle in which particles are counted to decide whether it dies. An even number counts as the next odd one.",
        effect: Effect::Restart,
        kind: whole!(population.survival_window: u32, (1.0, 9.0), (1.0, 9.0), Linear),
    },
    Parameter {
        key: "population.survival_least",
        name: "Least to survive",
        unit: "particles",
        help: "A particle dies with fewer particles in the survival window, itself included.",
        effect: Effect::Live,
        kind: whole!(population.survival_least: u32, (0.0, 1e6), (0.0, 81.0), Linear),
    },
    Parameter {
        key: "population.survival_most",
        name: "Most to survive",
        unit: "particles",
        help: "A particle dies with more particles in the survival window, itself included.",
        effect: Effect::Live,
        kind: whole!(population.survival_most: u32, (0.0, 1e6), (0.0, 81.0), Linear),
    },
    Parameter {
        key: "population.death_probability",
        name: "Death probability",
        unit: "",
        help: "How probable it is that a particle dies that may.",
        effect: Effect::Live,
        kind: real!(population.death_probability, (0.0, 1.0), (0.0, 1.0), Linear),
    },
    Parameter {
        key: "population.hunger",
        name: "Hunger",
        unit: "steps",
        help: "A particle dies if it has been hungry for so many steps; those that it was fed for do not count. 0: none dies of hunger.",
        effect: Effect::Live,
        kind: whole!(population.hunger: u32, (0.0, 8_000.0), (0.0, 2_000.0), Linear),
    },
    Parameter {
        key: "population.capacity",
        name: "Capacity",
        unit: "particles",
        help: "How many particles may be alive, or as many as there are at the start if these are more. Where there is no room, particles do not divide, and are counted.",
        effect: Effect::Restart,
        kind: whole!(population.capacity: u32, (1.0, 134_217_728.0), (1_000.0, 8_000_000.0), Logarithmic),
    },
];
