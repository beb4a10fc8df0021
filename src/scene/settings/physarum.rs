//! Parameters of particles, for the whole scene and for single objects, and their rows in the
//! parameter tables.

use serde::Serialize;

use super::choices::{Border, Sensing};

/// `[physarum]`
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PhysarumSettings {
    /// Length walked in a step, in scene radii.
    pub speed: f32,
    /// How far a particle turns in a step, in degrees.
    pub rotation_angle: f32,
    /// Between the middle sensor and the outer ones, in degrees.
    pub sensor_angle: f32,
    /// How far ahead sensors read, in scene radii.
    pub sensor_offset: f32,
    /// Standard deviation of the Gaussian noise added to each sensor, in trail units.
    pub sensor_noise: f32,
    /// Trail that one particle leaves in a step, where texels have the mean size.
    pub deposit: f32,
    /// Particles per texel in use that deposit and decrowding weight are meant for; 0 for any.
    pub reference_density: f32,
    /// Behaviour at the open border of a surface.
    pub border: Border,
    /// Edges that one walk may cross in a step; the rest is walked in the next.
    pub edge_crossing_attempts: u32,
    /// How a sensor gets to where it reads.
    pub sensing: Sensing,
    /// Trail that particles like best; 0 for the more the better.
    pub favourite_density: f32,
    /// Trail units added to a sensor per scene radius of height; positive climbs.
    pub gravity_weight: f32,
    /// Trail units taken from a sensor per particle counted at its texel in the last step.
    pub decrowding_weight: f32,
    /// Trail units added to a sensor per scene radius of signed distance to other objects; positive keeps away.
    pub distance_weight: f32,
}

impl Default for PhysarumSettings {
    fn default() -> Self {
        Self {
            speed: 0.004,
            rotation_angle: 25.0,
            sensor_angle: 30.0,
            sensor_offset: 0.03,
            sensor_noise: 0.0,
            deposit: 1.0,
            reference_density: 0.0,
            border: Border::Reflect,
            edge_crossing_attempts: 10,
            sensing: Sensing::Auto,
            favourite_density: 0.0,
            gravity_weight: 0.0,
            decrowding_weight: 0.0,
            distance_weight: 0.0,
        }
    }
}

/// `physarum` of an `[[object]]`: values that stand over the scene's while a particle is on this object. What an object
/// does not name, it shares with the scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OwnPhysarum {
    /// As [`PhysarumSettings::speed`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed: Option<f32>,
    /// As [`PhysarumSettings::rotation_angle`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rotation_angle: Option<f32>,
    /// As [`PhysarumSettings::sensor_angle`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_angle: Option<f32>,
    /// As [`PhysarumSettings::sensor_offset`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_offset: Option<f32>,
    /// As [`PhysarumSettings::sensor_noise`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor_noise: Option<f32>,
    /// As [`PhysarumSettings::favourite_density`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub favourite_density: Option<f32>,
    /// As [`PhysarumSettings::gravity_weight`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gravity_weight: Option<f32>,
    /// As [`PhysarumSettings::decrowding_weight`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decrowding_weight: Option<f32>,
    /// As [`PhysarumSettings::distance_weight`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub distance_weight: Option<f32>,
}

impl OwnPhysarum {
    /// Does it share everything with the scene?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The scene's values with these over them.
    #[must_use]
    pub fn over(&self, scene: &PhysarumSettings) -> PhysarumSettings {
        let mut own = scene.clone();
        for (own, value) in [
            (&mut own.speed, self.speed),
            (&mut own.rotation_angle, self.rotation_angle),
            (&mut own.sensor_angle, self.sensor_angle),
            (&mut own.sensor_offset, self.sensor_offset),
            (&mut own.sensor_noise, self.sensor_noise),
            (&mut own.favourite_density, self.favourite_density),
            (&mut own.gravity_weight, self.gravity_weight),
            (&mut own.decrowding_weight, self.decrowding_weight),
            (&mut own.distance_weight, self.distance_weight),
        ] {
            *own = value.unwrap_or(*own);
        }
        own
    }
}

/// The rows of the scene's parameters, for the table of all.
macro_rules! physarum_parameters {
    () => {
        &[
            Parameter {
                key: "physarum.speed",
                name: "Particle speed",
                unit: "scene radii per step",
                help: "Length walked in a step.",
                effect: Effect::Live,
                kind: real!(physarum.speed, (0.0, 10.0), (0.0, 0.03), Logarithmic),
            },
            Parameter {
                key: "physarum.rotation_angle",
                name: "Rotation angle",
                unit: "degrees per step",
                help: "How far a particle turns towards the better of its outer sensors.",
                effect: Effect::Live,
                kind: real!(
                    physarum.rotation_angle,
                    (-360.0, 360.0),
                    (-60.0, 120.0),
                    Linear
                ),
            },
            Parameter {
                key: "physarum.sensor_angle",
                name: "Sensor angle",
                unit: "degrees",
                help: "Between the middle sensor and the outer ones.",
                effect: Effect::Live,
                kind: real!(physarum.sensor_angle, (0.0, 180.0), (0.0, 120.0), Linear),
            },
            Parameter {
                key: "physarum.sensor_offset",
                name: "Sensor offset",
                unit: "scene radii",
                help: "How far ahead the sensors read. Larger values give a coarser network.",
                effect: Effect::Live,
                kind: real!(physarum.sensor_offset, (0.0, 10.0), (0.0, 0.2), Logarithmic),
            },
            Parameter {
                key: "physarum.sensor_noise",
                name: "Sensor noise",
                unit: "trail units",
                help: "Standard deviation of the Gaussian noise added to each sensor. 0 for none.",
                effect: Effect::Live,
                kind: real!(physarum.sensor_noise, (0.0, 1e6), (0.0, 20.0), Logarithmic),
            },
            Parameter {
                key: "physarum.deposit",
                name: "Deposit amount",
                unit: "trail units",
                help: "Trail that one particle leaves in a step, where texels have the mean size.",
                effect: Effect::Live,
                kind: real!(physarum.deposit, (0.0, 1e6), (0.0, 10.0), Logarithmic),
            },
            Parameter {
                key: "physarum.reference_density",
                name: "Reference density",
                unit: "particles per texel",
                help: "How many particles the look was made for: where there are twice as many, each leaves half as much trail, and the decrowding weight is half, so that the look stays. 0 takes both as they are.",
                effect: Effect::Live,
                kind: real!(
                    physarum.reference_density,
                    (0.0, 1e6),
                    (0.0, 10.0),
                    Logarithmic
                ),
            },
            Parameter {
                key: "physarum.border",
                name: "Border rule",
                unit: "",
                help: "At the open border of a surface particles are reflected, or stop there.",
                effect: Effect::Live,
                kind: word!(physarum.border: Border),
            },
            Parameter {
                key: "physarum.edge_crossing_attempts",
                name: "Edge-crossing attempts",
                unit: "edges per walk",
                help: "How many edges one walk may cross in a step. What is left of it is walked first in the next step.",
                effect: Effect::Live,
                kind: whole!(physarum.edge_crossing_attempts: u32, (0.0, 1_000.0), (0.0, 64.0), Linear),
            },
            Parameter {
                key: "physarum.sensing",
                name: "Sensing",
                unit: "",
                help: "Sensors read straight ahead in the atlas where their way stays in one chart (auto), or always walk.",
                effect: Effect::Live,
                kind: word!(physarum.sensing: Sensing),
            },
            Parameter {
                key: "physarum.favourite_density",
                name: "Favourite trail density",
                unit: "trail units",
                help: "Particles seek this much trail and avoid more. 0: the more the better.",
                effect: Effect::Live,
                kind: real!(
                    physarum.favourite_density,
                    (0.0, 1e6),
                    (0.0, 100.0),
                    Logarithmic
                ),
            },
            Parameter {
                key: "physarum.gravity_weight",
                name: "Gravity weight",
                unit: "trail units per scene radius",
                help: "Added to a sensor for its height (+Y). Positive values climb, negative ones sink, 0 is off.",
                effect: Effect::Live,
                kind: real!(physarum.gravity_weight, (-1e6, 1e6), (-500.0, 500.0), Linear),
            },
            Parameter {
                key: "physarum.decrowding_weight",
                name: "Decrowding weight",
                unit: "trail units per particle",
                help: "Taken from a sensor for each particle that its texel counted in the last step. 0 is off.",
                effect: Effect::Live,
                kind: real!(
                    physarum.decrowding_weight,
                    (-1e6, 1e6),
                    (0.0, 20.0),
                    Logarithmic
                ),
            },
            Parameter {
                key: "physarum.distance_weight",
                name: "Distance weight",
                unit: "trail units per scene radius",
                help: "Added to a sensor for the signed distance to other objects. Positive values keep away from them, negative ones seek them, 0 is off.",
                effect: Effect::Live,
                kind: real!(physarum.distance_weight, (-1e6, 1e6), (-500.0, 500.0), Linear),
            },
        ]
    };
}
pub(in crate::scene) use physarum_parameters;

/// The rows of those that an object may have for itself.
macro_rules! own_physarum_parameters {
    () => {
        &[
            Parameter {
                key: "physarum.speed",
                name: "Particle speed",
                unit: "scene radii per step",
                help: "For particles on this object, over the scene's physarum.speed.",
                effect: Effect::Live,
                kind: own!(speed, (0.0, 10.0), (0.0, 0.03), Logarithmic),
            },
            Parameter {
                key: "physarum.rotation_angle",
                name: "Rotation angle",
                unit: "degrees per step",
                help: "For particles on this object, over the scene's physarum.rotation_angle.",
                effect: Effect::Live,
                kind: own!(rotation_angle, (-360.0, 360.0), (-60.0, 120.0), Linear),
            },
            Parameter {
                key: "physarum.sensor_angle",
                name: "Sensor angle",
                unit: "degrees",
                help: "For particles on this object, over the scene's physarum.sensor_angle.",
                effect: Effect::Live,
                kind: own!(sensor_angle, (0.0, 180.0), (0.0, 120.0), Linear),
            },
            Parameter {
                key: "physarum.sensor_offset",
                name: "Sensor offset",
                unit: "scene radii",
                help: "For particles on this object, over the scene's physarum.sensor_offset.",
                effect: Effect::Live,
                kind: own!(sensor_offset, (0.0, 10.0), (0.0, 0.2), Logarithmic),
            },
            Parameter {
                key: "physarum.sensor_noise",
                name: "Sensor noise",
                unit: "trail units",
                help: "For particles on this object, over the scene's physarum.sensor_noise.",
                effect: Effect::Live,
                kind: own!(sensor_noise, (0.0, 1e6), (0.0, 20.0), Logarithmic),
            },
            Parameter {
                key: "physarum.favourite_density",
                name: "Favourite trail density",
                unit: "trail units",
                help: "For particles on this object, over the scene's physarum.favourite_density.",
                effect: Effect::Live,
                kind: own!(favourite_density, (0.0, 1e6), (0.0, 100.0), Logarithmic),
            },
            Parameter {
                key: "physarum.gravity_weight",
                name: "Gravity weight",
                unit: "trail units per scene radius",
                help: "For particles on this object, over the scene's physarum.gravity_weight.",
                effect: Effect::Live,
                kind: own!(gravity_weight, (-1e6, 1e6), (-500.0, 500.0), Linear),
            },
            Parameter {
                key: "physarum.decrowding_weight",
                name: "Decrowding weight",
                unit: "trail units per particle",
                help: "For particles on this object, over the scene's physarum.decrowding_weight.",
                effect: Effect::Live,
                kind: own!(decrowding_weight, (-1e6, 1e6), (0.0, 20.0), Logarithmic),
            },
            Parameter {
                key: "physarum.distance_weight",
                name: "Distance weight",
                unit: "trail units per scene radius",
                help: "For particles on this object, over the scene's physarum.distance_weight.",
                effect: Effect::Live,
                kind: own!(distance_weight, (-1e6, 1e6), (-500.0, 500.0), Linear),
            },
        ]
    };
}
pub(in crate::scene) use own_physarum_parameters;
