//! `myxo query`: questions in CSV, answers in CSV, answered by the code that the simulation runs.

mod atlas;
mod diffuse;
mod geodesic;
mod pair;
mod sdf;
mod table;

use std::path::Path;

use clap::{Args, Subcommand};
use myxo::Result;
use myxo::mesh::Mesh;

use super::Outcome;

/// Answer questions about meshes, CSV in and CSV out
#[derive(Clone, Debug, Args)]
pub struct Query {
    #[command(subcommand)]
    kind: Kind,
}

#[derive(Clone, Debug, Subcommand)]
enum Kind {
    Atlas(atlas::Atlas),
    Diffuse(diffuse::Diffuse),
    Geodesic(geodesic::Geodesic),
    Sdf(sdf::Sdf),
}

impl Query {
    /// Answers the questions.
    pub fn run(&self) -> Result<Outcome> {
        match &self.kind {
            Kind::Atlas(atlas) => atlas.run(),
            Kind::Diffuse(diffuse) => diffuse.run(),
            Kind::Geodesic(geodesic) => geodesic.run(),
            Kind::Sdf(sdf) => sdf.run(),
        }
    }
}

/// The mesh that `--mesh` names, in its own coordinates.
fn open_mesh(name: &Path) -> Result<Mesh> {
    Ok(match name.to_str() {
        Some(builtin) if builtin.starts_with("builtin:") => Mesh::builtin(builtin)?,
        _ => Mesh::load_raw(name)?,
    })
}
