//! `myxo query`: questions in CSV, answers in CSV, answered by the code that the simulation runs.

mod atlas;
mod diffuse;
mod geodesic;
mod pair;
mod sdf;
mod table;

use std::path::Path;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use myxo::Result;
use myxo::mesh::Mesh;
use myxo::mesh::atlas::AtlasOptions;
use myxo::scene::settings::{AtlasMethod, Settings};
use myxo::sim::atlas_options;

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

/// The ways to lay triangles out, by the words that scene files use.
fn atlas_method() -> impl TypedValueParser<Value = AtlasMethod> {
    PossibleValuesParser::new(AtlasMethod::WORDS).map(|word| {
        let mut methods = AtlasMethod::ALL.iter().copied();
        let method = methods.find(|method| method.word() == word);
        method.expect("clap lets only words through")
    })
}

/// What an atlas of a single mesh is made from.
fn options_of(method: AtlasMethod, size: u32, gutter: u32, turn: u64) -> AtlasOptions {
    let mut settings = Settings::default();
    settings.atlas.method = method;
    settings.atlas.size = size;
    AtlasOptions {
        gutter,
        turn,
        ..atlas_options(&settings)
    }
}
