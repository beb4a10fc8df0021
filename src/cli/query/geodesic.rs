//! `myxo query geodesic`: straight walks on one mesh.
//!
//! Rows speak of the file's triangles, corners in file order and directions in space; walks speak of our triangles,
//! `uv` and headings in the tangent frame. This file translates both ways, in double precision, and leaves the walking
//! to an engine.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use glam::{DVec2, DVec3};
use myxo::gpu::{Context, ContextOptions};
use myxo::mesh::Mesh;
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{BorderRule, Frame, SurfacePoint, WalkEnd, WalkQuery, WalkStatus};
use myxo::sim::queries::walk_queries;
use myxo::{Error, Result};

use super::open_mesh;
use super::table::{Row, Table};
use crate::cli::files::Sink;
use crate::cli::options::DeviceOptions;
use crate::cli::{Outcome, console};

/// Walk straight on a mesh from given points in given directions
///
/// In:  id,face,b0,b1,b2,dx,dy,dz,length
/// Out: id,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status
///
/// Faces and corners are counted as in the file.
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
    /// A model (.obj, .glb, .gltf), or builtin:NAME
    #[arg(long, value_name = "FILE")]
    mesh: PathBuf,
    /// The walks; - for the standard input
    #[arg(long = "in", value_name = "FILE", default_value = "-")]
    input: PathBuf,
    /// Where their ends go; - for the standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    #[command(flatten)]
    device: DeviceOptions,
}

/// Answers each query in order, stopping at open borders, with as many crossings as it takes.
pub type Engine<'a> = &'a dyn Fn(&Surface, &[WalkQuery]) -> Result<Vec<WalkEnd>>;

const COLUMNS: &[&str] = &["id", "face", "b0", "b1", "b2", "dx", "dy", "dz", "length"];
const HEADER: &str = "id,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status";

/// Weights are taken for rounded ones and made to sum to 1 up to here; beyond, something else is meant by them.
const WEIGHTS_MAY_BE_OFF: f64 = 1e-5;

/// Longest walk, in diagonals of the mesh: minutes of work, and far more than float32 can follow.
const LONGEST: f64 = 1e6;

/// Rows that cannot be answered are told of one by one up to this many.
const MESSAGES: usize = 5;

impl Geodesic {
    /// Reads, walks, writes.
    pub fn run(&self) -> Result<Outcome> {
        self.run_with(&|surface, queries| on_device(&self.device, surface, queries))
    }

    fn run_with(&self, engine: Engine<'_>) -> Result<Outcome> {
        let sink = Sink::create(&self.out)?;
        let mesh = open_mesh(&self.mesh)?;
        let table = Table::read(&self.input, COLUMNS)?;
        let answers = answer(&mesh, &table, engine)?;
        for message in answers.refused.iter().take(MESSAGES) {
            console::message(message);
        }
        if answers.refused.len() > MESSAGES {
            console::message(&format!(
                "and {} more rows with status 2",
                answers.refused.len() - MESSAGES
            ));
        }
        sink.write(&answers.text)?;
        Ok(Outcome::Done)
    }
}

/// The engine that the program uses: the kernel that walks as particles do, in float32.
fn on_device(
    options: &DeviceOptions,
    surface: &Surface,
    queries: &[WalkQuery],
) -> Result<Vec<WalkEnd>> {
    let ctx = Context::new(&ContextOptions {
        device: options.device.clone(),
        validation: options.validate,
        ..ContextOptions::default()
    })?;
    let ends = walk_queries(&ctx, surface, queries, BorderRule::Stop)?;
    let messages = ctx.take_messages();
    if !messages.is_empty() {
        return Err(Error::Invalid(format!(
            "Vulkan's validation complains: {}",
            messages.join("\n")
        )));
    }
    Ok(ends)
}

/// The rows of the answer, and what was said about those that could not be answered.
#[derive(Debug)]
struct Answers {
    text: String,
    refused: Vec<String>,
}

/// Answers every row of a table by one call of the engine.
fn answer(mesh: &Mesh, table: &Table, engine: Engine<'_>) -> Result<Answers> {
    let surface = Surface::build(&[(mesh, 1.0)]);
    let (low, high) = mesh.bounds();
    let longest = LONGEST * low.as_dvec3().distance(high.as_dvec3());
    let mut queries = Vec::new();
    let mut starts = Vec::new();
    for row in table.rows() {
        let start = Start::read(row)?;
        let query = start.query(mesh, &surface, longest);
        queries.extend(query.as_ref().ok());
        starts.push((row, start, query.err()));
    }
    let mut ends = engine(&surface, &queries)?.into_iter();
    let mut answers = Answers {
        text: format!("{HEADER}\n"),
        refused: Vec::new(),
    };
    for (row, start, refusal) in starts {
        let end = match refusal {
            Some(reason) => Err(reason),
            None => match ends.next().expect("the engine answers every query") {
                end if end.status == WalkStatus::OutOfAttempts => {
                    Err("the walk turns round a vertex and gets no further".to_owned())
                }
                end => Ok(end),
            },
        };
        match end {
            Ok(end) => write_end(&mut answers.text, row.text(0), mesh, &surface, &end),
            Err(reason) => {
                answers
                    .refused
                    .push(format!("{}: {reason}; the row gets status 2", row.place()));
                start.write_back(&mut answers.text, row.text(0));
            }
        }
    }
    Ok(answers)
}

/// A row as it was read.
#[derive(Clone, Copy, Debug)]
struct Start {
    /// As it was asked for, whether there is such a face or not.
    face: i64,
    weights: DVec3,
    direction: DVec3,
    length: f64,
}

impl Start {
    fn read(row: Row<'_>) -> Result<Self> {
        let vector = |column| {
            Ok::<_, myxo::Error>(DVec3::new(
                row.number(column)?,
                row.number(column + 1)?,
                row.number(column + 2)?,
            ))
        };
        Ok(Self {
            face: row.integer(1)?,
            weights: vector(2)?,
            direction: vector(5)?,
            length: row.number(8)?,
        })
    }

    /// The walk that the row asks for, up to a length, or why there is none.
    fn query(&self, mesh: &Mesh, surface: &Surface, longest: f64) -> Result<WalkQuery, String> {
        let sum = self.weights.element_sum();
        if self.weights.min_element() < -WEIGHTS_MAY_BE_OFF
            || (sum - 1.0).abs() > WEIGHTS_MAY_BE_OFF
        {
            return Err("b0, b1, b2 are not weights that sum to 1".to_owned());
        }
        if self.length < 0.0 {
            return Err("the length is negative".to_owned());
        }
        if self.length > longest {
            return Err(format!(
                "the length is over {LONGEST:e} times the mesh's diagonal: walk {longest:e} at most"
            ));
        }
        let weights = self.weights.max(DVec3::ZERO);
        let weights = weights / weights.element_sum();
        let start = u32::try_from(self.face)
            .ok()
            .and_then(|face| mesh.point_from_file(face, weights.to_array()))
            .ok_or_else(|| format!("the mesh has no face {} to walk on", self.face))?;
        let frame = Frame::of(surface, start.triangle);
        // Scaled first, so that squares of tiny components do not vanish.
        let direction = self.direction / self.direction.abs().max_element();
        let heading =
            DVec2::new(direction.dot(frame.p), direction.dot(frame.h)).normalize_or_zero();
        if heading == DVec2::ZERO {
            return Err("the direction has no part in the plane of its face".to_owned());
        }
        Ok(WalkQuery {
            start,
            heading,
            length: self.length,
        })
    }

    /// The row as it was, for a walk that cannot be.
    fn write_back(&self, text: &mut String, id: &str) {
        let (b, d) = (self.weights, self.direction);
        let _ = writeln!(
            text,
            "{id},{},{},{},{},0,0,0,{},{},{},0,2",
            self.face, b.x, b.y, b.z, d.x, d.y, d.z
        );
    }
}

fn write_end(text: &mut String, id: &str, mesh: &Mesh, surface: &Surface, end: &WalkEnd) {
    let SurfacePoint { triangle, u, v } = end.point;
    let corners = surface.corners[triangle as usize];
    let [a, b, c] = corners.map(|corner| surface.positions[corner as usize].as_dvec3());
    let position = a + u * (b - a) + v * (c - a);
    let frame = Frame::of(surface, triangle);
    let direction = (end.heading.x * frame.p + end.heading.y * frame.h).normalize();
    let status = if end.status == WalkStatus::Border {
        1
    } else {
        0
    };
    let (face, [b0, b1, b2]) = mesh.point_to_file(end.point);
    let _ = write!(text, "{id},{face}");
    for number in [
        b0,
        b1,
        b2,
        position.x,
        position.y,
        position.z,
        direction.x,
        direction.y,
        direction.z,
        end.travelled,
    ] {
        // Shortest text that reads back as the same double.
        let _ = write!(text, ",{number}");
    }
    let _ = writeln!(text, ",{status}");
}

#[cfg(test)]
mod tests;
