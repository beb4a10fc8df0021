//! `myxo query sdf`: signed distances of places to a mesh.
//!
//! Places come in world space in double precision; the kernel answers in the mesh's own space, about its middle, so
//! that far from the origin no digits are lost.

use std::fmt::Write as _;

use clap::Args;
use glam::DVec3;
use myxo::mesh::surface::Surface;
use myxo::mesh::trees::Trees;
use myxo::mesh::walk::SurfacePoint;
use myxo::sim::tree_queries::{Question, tree_queries};
use myxo::sim::types::TreeQuery;
use myxo::{Error, Result};

use super::pair::{PairOptions, PlacedMesh};
use super::{about_its_middle, with_device};
use crate::cli::Outcome;
use crate::cli::files::Sink;

/// Tell the signed distance from given places to a mesh
///
/// In:  id,px,py,pz
/// Out: id,sd,face,qx,qy,qz
///
/// The scene is JSON: mesh_a, mesh_b (paths relative to it), a_transform_row_major and
/// b_transform_row_major (16 numbers each). Places are in world space; distances are to mesh B,
/// negative inside. Faces are counted as in the file, and (qx, qy, qz) is the nearest point in
/// world space.
#[derive(Clone, Debug, Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  myxo query sdf --scene two.json --in places.csv --out distances.csv
  myxo query sdf --scene two.json --sign winding < places.csv | head"
)]
pub struct Sdf {
    #[command(flatten)]
    pair: PairOptions,
}

const COLUMNS: &[&str] = &["id", "px", "py", "pz"];

impl Sdf {
    /// Reads, asks, writes.
    pub fn run(&self) -> Result<Outcome> {
        let sink = Sink::create(&self.pair.out)?;
        let b = PlacedMesh::read_b(&self.pair.scene)?;
        let table = self.pair.questions(COLUMNS)?;
        let (centre, centred) = about_its_middle(&b.mesh);
        let surface = Surface::build(&[(&centred, 1.0)]);
        let trees = Trees::build(&surface);
        let b_from_world = b.world_from_mesh.inverse();
        let tree = &trees.objects[0];
        let (low, high) = (tree.low.as_dvec3(), tree.high.as_dvec3());
        let farthest = FARTHEST * low.distance(high);
        let mut queries = Vec::new();
        for row in table.rows() {
            let place = DVec3::new(row.number(1)?, row.number(2)?, row.number(3)?);
            let place = b_from_world.transform_point3(place) - centre;
            if place.length() > farthest {
                return Err(Error::Invalid(format!(
                    "{}: the place is farther than {farthest:.1e} away from the mesh, too far to tell what is nearest",
                    row.place()
                )));
            }
            queries.push(TreeQuery::nearest(place.as_vec3()));
        }
        with_device(&self.pair.device, |ctx| {
            let question = Question::Nearest(self.pair.sign.into());
            tree_queries(ctx, &surface, &trees, question, &mut queries)
        })?;

        let mut text = "id,sd,face,qx,qy,qz\n".to_owned();
        for (row, answer) in table.rows().zip(&queries) {
            let point = SurfacePoint {
                triangle: trees.faces[answer.slot as usize].triangle,
                u: answer.u.into(),
                v: answer.v.into(),
            };
            let (face, _) = b.mesh.point_to_file(point);
            let corners = surface.corners[point.triangle as usize];
            let [first, second, third] =
                corners.map(|corner| surface.positions[corner as usize].as_dvec3());
            let nearest = first + point.u * (second - first) + point.v * (third - first) + centre;
            let q = b.world_from_mesh.transform_point3(nearest);
            // From afar, rounding makes all faces equally near; but beyond the box is outside.
            let beyond = answer.place.cmplt(tree.low).any() || answer.place.cmpgt(tree.high).any();
            let sd = match f64::from(answer.result) {
                sd if beyond && tree.is_closed => sd.abs(),
                sd => sd,
            };
            let _ = writeln!(text, "{},{sd},{face},{},{},{}", row.text(0), q.x, q.y, q.z);
        }
        sink.write(&text)?;
        Ok(Outcome::Done)
    }
}

/// In diagonals of the mesh. Squares of what is farther are all alike in float32.
const FARTHEST: f64 = 1e5;
