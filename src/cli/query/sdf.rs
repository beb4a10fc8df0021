//! `myxo query sdf`: signed distances of places to a mesh.
//!
//! Places are given in world space in double precision; the kernel answers in the mesh's own space, around its middle, so that far from the
//! origin no digits are lost. For places far from the mesh the nearest point is computed in double precision, and only the sign by the
//! kernel.

use std::fmt::Write as _;
use std::iter::once;

use clap::Args;
use glam::DVec3;
use myxo::mesh::surface::Surface;
use myxo::mesh::trees::Trees;
use myxo::mesh::walk::SurfacePoint;
use myxo::plain_text::in_csv;
use myxo::sim::tree_queries::{Question, tree_queries};
use myxo::sim::types::TreeQuery;
use myxo::{Error, Result};

use super::pair::{PairOptions, PlacedMesh};
use super::{about_its_middle, length, shortened, with_device, write_answer};
use crate::cli::files::{Sink, check_unread};
use crate::cli::{Command, Outcome};

/// Compute the signed distance from given places to a mesh
///
/// In:  id,px,py,pz
/// Out: id,sd,face,qx,qy,qz
///
/// The scene is JSON: mesh_a and mesh_b (paths relative to it),
/// a_transform_row_major and b_transform_row_major (16 numbers each).
/// Places are in world space. Distances are to mesh B, negative inside.
/// Faces are counted from 0 in the order of the file, polygons cut into
/// triangles, and (qx, qy, qz) is the nearest point in world space.
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

impl Command for Sdf {
    /// Reads, asks, writes.
    fn run(&self) -> Result<Outcome> {
        Sink::check(&self.pair.out)?;
        let b = PlacedMesh::read_b(&self.pair.scene)?;
        let table = self.pair.questions(COLUMNS)?;
        check_unread(once(&self.pair.out), "")?;
        let (centre, centred) = about_its_middle(&b.mesh);
        let surface = Surface::build(&[(&centred, 1.0)]);
        let trees = Trees::build(&surface);
        let b_from_world = b.world_from_mesh.inverse();
        let tree = &trees.objects[0];
        let diagonal = tree.low.as_dvec3().distance(tree.high.as_dvec3());
        let mut places = Vec::new();
        for row in table.rows() {
            let [x, y, z] = [1, 2, 3].map(|column| row.number(column));
            let place = b_from_world.transform_point3(DVec3::new(x?, y?, z?)) - centre;
            if !place.is_finite() {
                return Err(Error::Invalid(format!(
                    "{}: the place is too far away for its distance to be a number",
                    row.place()
                )));
            }
            let is_afar = length(place) > AFAR * diagonal;
            let afar = is_afar.then(|| {
                let nearer = shortened(place, EQUALLY_FAR * diagonal);
                let nearest = trees.nearest_in_double(0, nearer);
                let direction = (nearer - nearest.position).normalize();
                (nearest, nearest.position + diagonal * direction)
            });
            places.push((place, afar));
        }
        let mut queries: Vec<TreeQuery> = places
            .iter()
            .map(|&(place, afar)| {
                // A ball around the place touches the mesh at the nearest point. A smaller ball within it touches the mesh at the same
                // point, and its centre lies on the same side.
                let near = afar.map_or(place, |(_, near)| near);
                TreeQuery::nearest(near.as_vec3())
            })
            .collect();
        with_device(&self.pair.device, |ctx| {
            let question = Question::Nearest(self.pair.sign.into());
            tree_queries(ctx, &surface, &trees, question, &mut queries)
        })?;

        let mut text = "id,sd,face,qx,qy,qz\n".to_owned();
        for ((row, &(place, afar)), answer) in table.rows().zip(&places).zip(&queries) {
            let (nearest, distance) = match afar {
                Some((nearest, _)) => (nearest, length(place - nearest.position)),
                None => (
                    trees.point(answer.slot, answer.u.into(), answer.v.into()),
                    answer.result.abs().into(),
                ),
            };
            let (face, _) = b.mesh.point_to_file(SurfacePoint {
                triangle: trees.faces[nearest.slot as usize].triangle,
                u: nearest.u,
                v: nearest.v,
            });
            let q = nearest.position + centre;
            let q = b.world_from_mesh.transform_point3(q);
            // Far away all faces are nearly equally near, and rounding would choose the sign; but everything beyond the box of a closed
            // mesh is outside.
            let is_beyond =
                answer.place.cmplt(tree.low).any() || answer.place.cmpgt(tree.high).any();
            let sd = if is_beyond && tree.is_closed {
                distance
            } else {
                distance.copysign(answer.result.into())
            };
            let id = in_csv(row.text(0));
            let _ = writeln!(text, "{id},{sd},{face},{},{},{}", q.x, q.y, q.z);
        }
        write_answer(&self.pair.out, &text)?;
        Ok(Outcome::Done)
    }
}

/// In diagonals of the mesh: beyond this distance, single precision has too few digits to find the nearest face.
const AFAR: f64 = 4.0;

/// In diagonals of the mesh: beyond this distance, rounding alone changes the nearest point.
const EQUALLY_FAR: f64 = 1e12;
