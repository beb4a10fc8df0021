//! The measures of the network that `--measure-every` takes along the way.

use myxo::scene::settings::ObjectSettings;
use myxo::sim::network::{Network, Part};
use serde::{Deserialize, Serialize};

/// Measures of the network after a step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Measure {
    /// Steps done.
    pub step: u64,
    /// On all objects together.
    #[serde(flatten)]
    pub network: Network,
    /// On each object.
    pub objects: Vec<ObjectMeasure>,
}

/// Measures on one object.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ObjectMeasure {
    /// Its name.
    pub name: String,
    /// Its measures.
    #[serde(flatten)]
    pub part: Part,
}

impl Measure {
    /// The measures after so many steps.
    pub fn new(step: u64, mut network: Network, objects: &[ObjectSettings]) -> Self {
        let parts = objects.iter().zip(std::mem::take(&mut network.objects));
        let named = |(object, part): (&ObjectSettings, Part)| ObjectMeasure {
            name: object.name.clone(),
            part,
        };
        Self {
            step,
            objects: parts.map(named).collect(),
            network,
        }
    }

    /// As a line of text.
    pub fn line(&self) -> String {
        let Network {
            length,
            covered,
            pieces,
            regions,
            ..
        } = self.network;
        format!(
            "step {}: the network is {length:.1} radii long and covers {:.1} %, in {pieces} pieces, with {regions} regions \
             between its lines",
            self.step,
            100.0 * covered
        )
    }
}
