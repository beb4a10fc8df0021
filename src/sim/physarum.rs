//! Parameters of the particles on one object, for kernels.

use bytemuck::{Pod, Zeroable};

use crate::portable::direction;
use crate::scene::settings::PhysarumSettings;

/// The favourite density where more trail is better. A favourite density is 0 or more.
pub const NO_FAVOURITE: f32 = -1.0;

/// A row of the table that has one per object; `shaders/include/types.glsl` declares it for kernels.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Physarum {
    /// World length of a step.
    pub speed: f32,
    /// World length from the particle to each sensor.
    pub sensor_offset: f32,
    /// Cosine of the angle between middle and side sensors.
    pub sensor_cos: f32,
    /// Its sine.
    pub sensor_sin: f32,
    /// Cosine of the angle of one turn.
    pub rotation_cos: f32,
    /// Its sine.
    pub rotation_sin: f32,
    /// Standard deviation, trail units.
    pub sensor_noise: f32,
    /// Trail units; [`NO_FAVOURITE`] for none.
    pub favourite_density: f32,
    /// Trail units a world length of height.
    pub gravity_weight: f32,
    /// Trail units a particle.
    pub decrowding_weight: f32,
    /// Trail units a world length of signed distance.
    pub distance_weight: f32,
    /// Edge crossings that one walk may make.
    pub attempts: u32,
}

impl Physarum {
    /// The parameters in a scene of this radius; decrowding weights are multiplied by `factor`.
    pub(super) fn of(physarum: &PhysarumSettings, radius: f32, factor: f32) -> Self {
        let [sensor, rotation] = [physarum.sensor_angle, physarum.rotation_angle]
            .map(|degrees| direction(f64::from(degrees).to_radians()).as_vec2());
        Self {
            speed: physarum.speed * radius,
            sensor_offset: physarum.sensor_offset * radius,
            sensor_cos: sensor.x,
            sensor_sin: sensor.y,
            rotation_cos: rotation.x,
            rotation_sin: rotation.y,
            sensor_noise: physarum.sensor_noise,
            favourite_density: physarum.favourite().unwrap_or(NO_FAVOURITE),
            gravity_weight: physarum.gravity_weight / radius,
            decrowding_weight: factor * physarum.decrowding_weight,
            distance_weight: physarum.distance_weight / radius,
            attempts: physarum.edge_crossing_attempts,
        }
    }
}
