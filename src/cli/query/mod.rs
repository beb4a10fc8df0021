//! `myxo query`: questions in CSV, answers in CSV, answered by the code that the simulation runs.

mod diffuse;
mod geodesic;
mod table;

use clap::{Args, Subcommand};
use myxo::Result;

use super::Outcome;

/// Answer questions about meshes, CSV in and CSV out
#[derive(Clone, Debug, Args)]
pub struct Query {
    #[command(subcommand)]
    kind: Kind,
}

#[derive(Clone, Debug, Subcommand)]
enum Kind {
    Diffuse(diffuse::Diffuse),
    Geodesic(geodesic::Geodesic),
}

impl Query {
    /// Answers the questions.
    pub fn run(&self) -> Result<Outcome> {
        match &self.kind {
            Kind::Diffuse(diffuse) => diffuse.run(),
            Kind::Geodesic(geodesic) => geodesic.run(),
        }
    }
}
