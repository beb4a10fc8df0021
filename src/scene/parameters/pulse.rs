//! The rows of the parameter table for one `[[pulse]]`.

use super::{Effect, Kind, Number, Parameter, Scale};
use crate::scene::settings::PulseSettings;

/// The parameters of one `[[pulse]]`. A change counts for pulses that begin after it.
pub static PULSE_PARAMETERS: &[Parameter<PulseSettings>] = &[
    Parameter {
        key: "at",
        name: "Place",
        unit: "scene radii",
        help: "Where it begins, counted from the scene's centre; on a surface or not. It stays there when objects move.",
        effect: Effect::Live,
        kind: vector!(at, (-100.0, 100.0)),
    },
    Parameter {
        key: "step",
        name: "First step",
        unit: "steps",
        help: "The step that it begins with, counted from 0.",
        effect: Effect::Live,
        kind: whole!(step: u32, (0.0, 1e9), (0.0, 5_000.0), Linear),
    },
    Parameter {
        key: "every",
        name: "Every",
        unit: "steps",
        help: "It begins again every so many steps. 0: once.",
        effect: Effect::Live,
        kind: whole!(every: u32, (0.0, 1e9), (0.0, 1_000.0), Linear),
    },
    Parameter {
        key: "speed",
        name: "Pulse speed",
        unit: "scene radii per step",
        help: "How far its front goes in a step. Faster than the particles it is a wave, slower it only turns them.",
        effect: Effect::Live,
        kind: real!(speed, (0.0001, 1.0), (0.002, 0.05), Logarithmic),
    },
    Parameter {
        key: "width",
        name: "Pulse width",
        unit: "scene radii",
        help: "How wide the front is.",
        effect: Effect::Live,
        kind: real!(width, (0.001, 10.0), (0.02, 1.0), Logarithmic),
    },
    Parameter {
        key: "reach",
        name: "Pulse reach",
        unit: "scene radii",
        help: "How far from its beginning it ends. In the last three tenths it becomes weaker.",
        effect: Effect::Live,
        kind: real!(reach, (0.001, 100.0), (0.1, 4.0), Logarithmic),
    },
    Parameter {
        key: "strength",
        name: "Pulse strength",
        unit: "",
        help: "How far particles in the front turn away from its beginning, and how much of its speed they take: with 0.6 they are up to two and a half times as dense there, with 1 the front takes along all that it meets.",
        effect: Effect::Live,
        kind: real!(strength, (0.0, 1.0), (0.0, 1.0), Linear),
    },
];
