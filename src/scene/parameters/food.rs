//! The rows of the parameter table for one `[[food]]`.

use super::{Effect, Kind, Number, Parameter, Scale};
use crate::scene::settings::FoodSettings;

/// The parameters of one `[[food]]`. All change while a simulation runs; the remaining amount of a food stays.
pub static FOOD_PARAMETERS: &[Parameter<FoodSettings>] = &[
    Parameter {
        key: "object",
        name: "On object",
        unit: "",
        help: "The name of the object that the food lies on and moves with. May be empty if there is only one.",
        effect: Effect::Live,
        kind: text!(object, "the name of an object", false),
    },
    Parameter {
        key: "at",
        name: "Place",
        unit: "mesh units",
        help: "Where it lies: the nearest point of the object's surface to this place, in the coordinates of the object's mesh, before its scale, rotation and position.",
        effect: Effect::Live,
        kind: place!(at),
    },
    Parameter {
        key: "radius",
        name: "Radius",
        unit: "scene radii",
        help: "The distance along the surface up to which sensors read it. Its scent falls off with the square of the remaining distance, to 0 there.",
        effect: Effect::Live,
        kind: real!(radius, (0.001, 10.0), (0.05, 2.0), Logarithmic),
    },
    Parameter {
        key: "strength",
        name: "Strength",
        unit: "trail units",
        help: "Added to a sensor's reading at its place. Less than 0 repels.",
        effect: Effect::Live,
        kind: real!(strength, (-1e6, 1e6), (-100.0, 100.0), Linear),
    },
    Parameter {
        key: "amount",
        name: "Amount",
        unit: "meals",
        help: "How many meals it is: each hungry particle that comes to it takes one, its scent becomes weaker, and in the end it is gone. 0: it never ends.",
        effect: Effect::Live,
        kind: whole!(amount: u32, (0.0, 60_000_000.0), (0.0, 1e6), Logarithmic),
    },
    Parameter {
        key: "size",
        name: "Size",
        unit: "scene radii",
        help: "How far along the surface it is eaten. 0 makes it a marker, which is not eaten.",
        effect: Effect::Live,
        kind: real!(size, (0.0, 10.0), (0.0, 0.2), Linear),
    },
    Parameter {
        key: "projection",
        name: "Projection",
        unit: "trail units",
        help: "Added in each step to the trail, before it spreads, on the texel that holds its place and on every texel that is nearer to it along the surface than its size; of several that are projected there, the nearest counts. Less as its amount falls. 0 is off.",
        effect: Effect::Live,
        kind: real!(projection, (0.0, 1e6), (0.0, 20.0), Logarithmic),
    },
];
