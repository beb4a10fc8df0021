//! One table of the parameters of particles, for the whole scene and for single objects.

use serde::Serialize;

use super::choices::{Border, Model, Preference, Sensing, StepOrder, Turning};

/// Gives all parameters to a macro, in their order. Objects may have their own values of those marked `own`. Those marked `restart` change
/// with a new simulation only. Each has its type and its
/// default and, for the parameter tables, the kind of value with its range, that of its slider and its scale, then name, unit and help.
macro_rules! physarum {
    ($use:ident) => {
        $use! {
            own {
                /// Length walked in a step, in scene radii.
                speed: f32 = 0.004, real((0.0, 10.0), (0.0, 0.03), Logarithmic),
                "Particle speed", "scene radii per step",
                "Length walked in a step."
            }
            own {
                /// How far a particle turns in a step, in degrees.
                rotation_angle: f32 = 25.0, real((-360.0, 360.0), (-60.0, 120.0), Linear),
                "Rotation angle", "degrees per step",
                "How far a particle turns towards the better of its outer sensors."
            }
            own {
                /// Between the middle sensor and the outer ones, in degrees.
                sensor_angle: f32 = 30.0, real((0.0, 180.0), (0.0, 120.0), Linear),
                "Sensor angle", "degrees",
                "Between the middle sensor and the outer ones."
            }
            own {
                /// How far ahead sensors read, in scene radii.
                sensor_offset: f32 = 0.03, real((0.0, 10.0), (0.0, 0.2), Logarithmic),
                "Sensor offset", "scene radii",
                "How far ahead the sensors read. Larger values give a coarser network."
            }
            own {
                /// Standard deviation of the Gaussian noise added to each sensor, in trail units.
                sensor_noise: f32 = 0.0, real((0.0, 1e6), (0.0, 20.0), Logarithmic),
                "Sensor noise", "trail units",
                "Standard deviation of the Gaussian noise added to each sensor. 0 for none."
            }
            own {
                /// Trail that one particle leaves in a step, where texels have the mean size.
                deposit: f32 = 1.0, real((0.0, 1e6), (0.0, 10.0), Logarithmic),
                "Deposit amount", "trail units",
                "Trail that one particle leaves in a step, where texels have the mean size."
            }
            scene {
                /// Particles per texel in use that deposit and decrowding weight are meant for; 0 for any.
                reference_density: f32 = 0.0, real((0.0, 1e6), (0.0, 10.0), Logarithmic),
                "Reference density", "particles per texel",
                "The density of particles that the look was made for: with twice the density, each particle leaves half as much trail, and the decrowding weight is half, so that the look stays. 0 takes both as they are."
            }
            scene {
                /// What happens at the open border of a surface.
                border: Border = Border::Reflect, word(),
                "Border rule", "",
                "At the open border of a surface particles are reflected, or stop there."
            }
            own {
                /// Edges that one walk may cross in a step; the rest is walked in the next.
                edge_crossing_attempts: u32 = 10, whole((0.0, 1_000.0), (0.0, 64.0), Linear),
                "Edge-crossing attempts", "edges per walk",
                "How many edges one walk may cross in a step. The rest of the walk comes first in the next step."
            }
            scene {
                /// The path of a sensor to the place that it reads.
                sensing: Sensing = Sensing::Auto, word(),
                "Sensing", "",
                "Sensors read straight ahead in the atlas where their way stays in one chart (auto), or always walk."
            }
            own {
                /// Trail that particles like best; 0 for the more the better, unless `preference` says otherwise.
                favourite_density: f32 = 0.0, real((0.0, 1e6), (0.0, 100.0), Logarithmic),
                "Favourite trail density", "trail units",
                "Particles seek this much trail and avoid more. 0: the more the better, unless the trail preference is favourite."
            }
            scene {
                /// Whether particles seek more trail or the favourite density.
                preference: Preference = Preference::Auto, word(),
                "Trail preference", "",
                "more: the more trail the better. favourite: particles seek the favourite trail density, and with 0 they avoid all trail. auto: favourite where the favourite trail density is above 0, otherwise more."
            }
            own {
                /// Trail units added to a sensor per scene radius of height; positive climbs.
                gravity_weight: f32 = 0.0, real((-1e6, 1e6), (-500.0, 500.0), Linear),
                "Gravity weight", "trail units per scene radius",
                "Added to a sensor for its height (+Y). Positive values climb, negative ones sink, 0 is off."
            }
            own {
                /// Trail units taken from a sensor per particle counted at its texel in the last step.
                decrowding_weight: f32 = 0.0, real((-1e6, 1e6), (0.0, 20.0), Logarithmic),
                "Decrowding weight", "trail units per particle",
                "Taken from a sensor for each particle that its texel counted in the last step. 0 is off."
            }
            own {
                /// Trail units added to a sensor per scene radius of signed distance to other objects; positive keeps away.
                distance_weight: f32 = 0.0, real((-1e6, 1e6), (-500.0, 500.0), Linear),
                "Distance weight", "trail units per scene radius",
                "Added to a sensor for the signed distance to other objects. Positive values keep away from them, negative ones seek them, 0 is off."
            }
            restart {
                /// The rules that particles follow, but for those below.
                model: Model = Model::Thesis, word(),
                "Model", "",
                "The rules that particles follow, but for those set below. thesis: they may share places, and nothing is random but noise. jones: one particle a cell, and the other rules of Jones (2010)."
            }
            restart {
                /// The order of the stages of a step.
                order: StepOrder = StepOrder::Model, word(),
                "Order of a step", "",
                "sense_first: in each step particles sense and turn, then walk. move_first: as that, but in the first step they do not turn. model: as the model has it, thesis the first, jones the second."
            }
            restart {
                /// Rounds in which particles claim cells, one particle a cell; 0 as in the model.
                occupancy_rounds: u32 = 0, whole((0.0, 14.0), (0.0, 14.0), Linear),
                "Occupancy rounds", "rounds",
                "One particle a cell of the texture: of particles in a row, each of which would go to the cell of the next, at most so many move in a step. Those that win no cell stay. 0: as the model has it, thesis without any such rule, jones 3."
            }
            scene {
                /// Where a particle turns.
                turning: Turning = Turning::Model, word(),
                "Turning", "",
                "better: to the better side, if it is better than the middle. random: to a random side where both are better than the middle, as in Jones (2010). model: as the model has it, thesis the first, jones the second."
            }
            scene {
                /// Probability of a turn to any direction, a step.
                random_turn: f32 = 0.0, real((0.0, 1.0), (0.0, 0.5), Linear),
                "Random turn", "",
                "The probability with which a particle turns to any direction in a step."
            }
            scene {
                /// Trail below which a sensor reads nothing.
                sensitivity: f32 = 0.0, real((0.0, 1e6), (0.0, 20.0), Logarithmic),
                "Sensitivity threshold", "trail units",
                "Trail weaker than this is not sensed: the sensor reads 0. 0 senses everything."
            }
            restart {
                /// Width of what a sensor reads, in cells; 0 as in the model.
                sensor_width: u32 = 0, whole((0.0, 9.0), (0.0, 9.0), Linear),
                "Sensor width", "cells",
                "A sensor reads the cell of the texture that it is in (1), or the mean of 3 by 3 (3), up to 9 by 9; even numbers count as the next odd one. 0: as the model has it, thesis between four texels, jones 1."
            }
        }
    };
}
pub(in crate::scene) use physarum;

/// Gives the rows marked `own` to a macro.
macro_rules! only_own {
    ($use:ident [$($kept:tt)*]) => { $use! { $($kept)* } };
    ($use:ident [$($kept:tt)*] own $row:tt $($rest:tt)*) => { only_own! { $use [$($kept)* $row] $($rest)* } };
    ($use:ident [$($kept:tt)*] scene $row:tt $($rest:tt)*) => { only_own! { $use [$($kept)*] $($rest)* } };
    ($use:ident [$($kept:tt)*] restart $row:tt $($rest:tt)*) => { only_own! { $use [$($kept)*] $($rest)* } };
}
pub(in crate::scene) use only_own;

macro_rules! settings {
    ($($for:ident {
        $(#[$doc:meta])* $field:ident: $type:ty = $default:expr, $kind:ident $range:tt, $name:literal, $unit:literal, $help:literal
    })*) => {
        /// `[physarum]`
        #[derive(Clone, Debug, PartialEq, Serialize)]
        pub struct PhysarumSettings {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl Default for PhysarumSettings {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }
    };
}
physarum!(settings);

macro_rules! own_settings {
    ($($for:ident $row:tt)*) => { only_own! { own_fields [] $($for $row)* } };
}
macro_rules! own_fields {
    ($({ $(#[$doc:meta])* $field:ident: $type:ty = $($row:tt)* })*) => {
        /// `physarum` of an `[[object]]`: values that override the scene's while a particle is on this object. Other values are the
        /// scene's.
        #[derive(Clone, Debug, Default, PartialEq, Serialize)]
        pub struct OwnPhysarum {
            $(
                #[doc = concat!("As [`PhysarumSettings::", stringify!($field), "`].")]
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $field: Option<$type>,
            )*
        }

        impl OwnPhysarum {
            /// The scene's values with these over them.
            #[must_use]
            pub fn over(&self, scene: &PhysarumSettings) -> PhysarumSettings {
                PhysarumSettings {
                    $($field: self.$field.unwrap_or(scene.$field),)*
                    ..*scene
                }
            }
        }
    };
}
physarum!(own_settings);

impl OwnPhysarum {
    /// Does any of its values concern what particles do? What they leave concerns the trail alone.
    #[must_use]
    pub fn concerns_particles(&self) -> bool {
        let but_deposit = Self {
            deposit: None,
            ..self.clone()
        };
        !but_deposit.is_empty()
    }

    /// Does it share everything with the scene?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}
