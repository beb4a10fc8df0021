//! `myxo query geodesic`: straight walks on one mesh.
//!
//! Rows use the file's triangles, corners in file order and directions in space; walks use the surface's triangles, `uv` and headings in
//! the tangent frame. This file converts both ways, in double precision, and leaves the walking to an engine.

use std::iter::once;
use std::path::PathBuf;

use clap::Args;
use glam::DAffine3;
use myxo::Result;
use myxo::mesh::Mesh;
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{BorderRule, WalkQuery};
use myxo::sim::queries::walk_queries;

use super::table::Table;
use super::walks::{Answers, COLUMNS, Engine, Ground, Question};
use super::{open_mesh, with_device, write_answer};
use crate::cli::files::{Sink, check_unread};
use crate::cli::options::DeviceOptions;
use crate::cli::{Command, Outcome};

/// Walk straight on a mesh from given points in given directions
///
/// In:  id,face,b0,b1,b2,dx,dy,dz,length
/// Out: id,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status
///
/// Faces are counted from 0 in the order of the file, polygons cut into
/// triangles. b0, b1 and b2 are the weights of a face's first, second and third
/// corner in the file: they sum to 1, and the point is b0 v0 + b1 v1 + b2 v2.
/// (px, py, pz) is the end, and (dx, dy, dz) the direction there.
/// Status: 0 the whole length, 1 stopped at an open border, 2 no such walk.
#[derive(Clone, Debug, Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  myxo query geodesic --mesh fish.obj --in walks.csv --out ends.csv
  myxo query geodesic --mesh builtin:torus < walks.csv | head"
)]
pub struct Geodesic {
    /// A model (.obj, .stl, .ply, .glb, .gltf), or builtin:NAME
    #[arg(long, value_name = "FILE")]
    mesh: PathBuf,
    /// The walks; - for the standard input
    #[arg(long = "in", value_name = "FILE", default_value = "-")]
    input: PathBuf,
    /// The file for their ends; - for the standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    #[command(flatten)]
    device: DeviceOptions,
}

const HEADER: &str = "id,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status";

impl Command for Geodesic {
    /// Reads, walks, writes.
    fn run(&self) -> Result<Outcome> {
        Sink::check(&self.out)?;
        let mesh = open_mesh(&self.mesh)?;
        let table = Table::read(&self.input, COLUMNS)?;
        check_unread(once(&self.out), "")?;
        let on_device = |surface: &Surface, queries: &[WalkQuery]| {
            with_device(&self.device, |ctx| {
                walk_queries(ctx, surface, queries, BorderRule::Stop)
            })
        };
        write_answer(&self.out, &answer(&mesh, &table, &on_device)?.into_table())?;
        Ok(Outcome::Done)
    }
}

/// Answers every row of a table by one call of the engine: the kernel that walks as particles do, in float32, or the
/// reference.
fn answer(mesh: &Mesh, table: &Table, engine: Engine<'_>) -> Result<Answers> {
    let question = Question {
        header: HEADER,
        surface: &Surface::build(&[(mesh, 1.0)]),
        grounds: &[Ground {
            mesh,
            first_triangle: 0,
            world_from_surface: DAffine3::from_translation(mesh.origin),
        }],
    };
    question.answer(table, engine)
}

#[cfg(test)]
mod tests;
