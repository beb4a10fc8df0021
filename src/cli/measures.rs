//! What `--measure-every` tells of the network along the way.

use myxo::scene::settings::ObjectSettings;
use myxo::sim::network::{Network, TIMES};
use serde::{Deserialize, Serialize};

/// What was measured of the network after a step; [`Network`] explains each number.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measure {
    /// Steps done.
    pub step: u64,
    /// Mean trail over the surface, trail units.
    pub mean_trail: f64,
    /// Share of the surface where the trail is more than 1.5 times that: the network.
    pub covered: f64,
    /// Share of the particles that are there.
    pub on_network: f64,
    /// Half of its outline, scene radii: where it is thin lines, their length.
    pub length: f64,
    /// Pieces of it that do not hang together.
    pub pieces: u32,
    /// Regions of bare surface between its lines.
    pub regions: u32,
    /// Shares of the surface with less than 1/4, 1/2, 1, 2 and 4 times the mean trail.
    pub below: [f64; TIMES.len()],
    /// The same of each object.
    pub objects: Vec<ObjectMeasure>,
}

/// What was measured on one object.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectMeasure {
    /// Its name.
    pub name: String,
    /// Particles on it.
    pub particles: u64,
    /// Mean trail on it, trail units.
    pub mean_trail: f64,
    /// Share of its surface that the network covers.
    pub covered: f64,
    /// As [`Measure::length`].
    pub length: f64,
}

impl Measure {
    /// Of the network after so many steps.
    pub fn new(step: u64, network: &Network, objects: &[ObjectSettings]) -> Self {
        let parts = objects.iter().zip(&network.objects);
        Self {
            step,
            mean_trail: network.mean_trail,
            covered: network.covered,
            on_network: network.on_network,
            length: network.length,
            pieces: network.pieces,
            regions: network.regions,
            below: network.below,
            objects: parts
                .map(|(object, part)| ObjectMeasure {
                    name: object.name.clone(),
                    particles: part.particles,
                    mean_trail: part.mean_trail,
                    covered: part.covered,
                    length: part.length,
                })
                .collect(),
        }
    }

    /// As a line of text.
    pub fn told(&self) -> String {
        format!(
            "step {}: the network is {:.1} radii long and covers {:.1} %, in {} pieces, with {} regions between its lines",
            self.step,
            self.length,
            100.0 * self.covered,
            self.pieces,
            self.regions
        )
    }
}
