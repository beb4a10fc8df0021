//! `myxo query sdf`: signed distances of places to a mesh.
//!
//! Places come in world space in double precision; the kernel answers in the mesh's own space, about its middle, so
//! that far from the origin no digits are lost.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use glam::DVec3;
use myxo::gpu::{Context, ContextOptions};
use myxo::mesh::Mesh;
use myxo::mesh::surface::Surface;
use myxo::mesh::trees::Trees;
use myxo::mesh::walk::SurfacePoint;
use myxo::scene::settings::SignRule;
use myxo::sim::tree_queries::{Question, tree_queries};
use myxo::sim::types::TreeQuery;
use myxo::{Error, Result};

use super::pair::MeshPair;
use super::table::Table;
use crate::cli::Outcome;
use crate::cli::files::Sink;
use crate::cli::options::DeviceOptions;

/// Tell the signed distance from given places to a mesh
///
/// In:  id,px,py,pz
/// Out: id,sd,face,qx,qy,qz
///
/// The scene is JSON: mesh_a, mesh_b (paths relative to it), a_transform_row_major and b_transform_row_major (16
/// numbers each). Places are in world space; distances are to mesh B, negative inside. Faces are counted as in the
/// file, and (qx, qy, qz) is the nearest point in world space.
#[derive(Clone, Debug, Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  myxo query sdf --scene two.json --in places.csv --out distances.csv
  myxo query sdf --scene two.json --sign winding < places.csv | head"
)]
pub struct Sdf {
    /// Two meshes and their transforms
    #[arg(long, value_name = "FILE")]
    scene: PathBuf,
    /// The places; - for the standard input
    #[arg(long = "in", value_name = "FILE", default_value = "-")]
    input: PathBuf,
    /// Where the distances go; - for the standard output
    #[arg(long, value_name = "FILE", default_value = "-")]
    out: PathBuf,
    /// How it is told whether a place is inside
    #[arg(long, value_name = "RULE", default_value = "pseudonormal")]
    sign: Sign,
    #[command(flatten)]
    device: DeviceOptions,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Sign {
    /// By the normal of the nearest face, edge or vertex
    Pseudonormal,
    /// By the winding number, also right where the mesh has holes
    Winding,
    /// Outside if any of equally near faces looks towards the place
    Facing,
}

const COLUMNS: &[&str] = &["id", "px", "py", "pz"];

impl Sdf {
    /// Reads, asks, writes.
    pub fn run(&self) -> Result<Outcome> {
        let sink = Sink::create(&self.out)?;
        let pair = MeshPair::read(&self.scene)?;
        let table = Table::read(&self.input, COLUMNS)?;
        let (centre, surface) = about_its_middle(&pair.b);
        let trees = Trees::build(&surface);
        let b_from_world = pair.world_from_b.inverse();
        let mut queries = Vec::new();
        for row in table.rows() {
            let place = DVec3::new(row.number(1)?, row.number(2)?, row.number(3)?);
            let place = b_from_world.transform_point3(place) - centre;
            if place.abs().max_element() > FARTHEST {
                return Err(Error::Invalid(format!(
                    "{}: the place is farther than {FARTHEST:e} away",
                    row.place()
                )));
            }
            queries.push(TreeQuery::nearest(place.as_vec3()));
        }
        let ctx = Context::new(&ContextOptions {
            device: self.device.device.clone(),
            validation: self.device.validate,
            ..ContextOptions::default()
        })?;
        let question = Question::Nearest(match self.sign {
            Sign::Pseudonormal => SignRule::Pseudonormal,
            Sign::Winding => SignRule::Winding,
            Sign::Facing => SignRule::Facing,
        });
        tree_queries(&ctx, &surface, &trees, question, &mut queries)?;
        let messages = ctx.take_messages();
        if !messages.is_empty() {
            return Err(Error::Invalid(format!(
                "Vulkan's validation complains: {}",
                messages.join("\n")
            )));
        }

        let mut text = "id,sd,face,qx,qy,qz\n".to_owned();
        for (row, answer) in table.rows().zip(&queries) {
            let point = SurfacePoint {
                triangle: trees.faces[answer.slot as usize].triangle,
                u: answer.u.into(),
                v: answer.v.into(),
            };
            let (face, _) = pair.b.point_to_file(point);
            let corners = surface.corners[point.triangle as usize];
            let [a, b, c] = corners.map(|corner| surface.positions[corner as usize].as_dvec3());
            let nearest = a + point.u * (b - a) + point.v * (c - a) + centre;
            let q = pair.world_from_b.transform_point3(nearest);
            let sd = f64::from(answer.result);
            let _ = writeln!(text, "{},{sd},{face},{},{},{}", row.text(0), q.x, q.y, q.z);
        }
        sink.write(&text)?;
        Ok(Outcome::Done)
    }
}

/// Squares of more do not fit a float32.
const FARTHEST: f64 = 1e18;

/// A mesh as a surface whose box has its middle in the origin, and where that is.
fn about_its_middle(mesh: &Mesh) -> (DVec3, Surface) {
    let (low, high) = mesh.bounds();
    let centre = 0.5 * (low.as_dvec3() + high.as_dvec3());
    let mut mesh = mesh.clone();
    for position in &mut mesh.positions {
        *position = (position.as_dvec3() - centre).as_vec3();
    }
    (centre, Surface::build(&[(&mesh, 1.0)]))
}
