//! `myxo query transfer`: straight walks on one mesh that change to another one where they meet it.
//!
//! Both meshes are moved to their middles, in a frame in which B is at rest, so that far from the origin no digits are lost.

use std::iter::once;

use clap::Args;
use glam::{Affine3A, DAffine3};
use myxo::Result;
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::WalkQuery;
use myxo::sim::transfer_queries::transfer_queries;
use myxo::sim::types::Pose;

use super::pair::{PairOptions, PlacedMesh};
use super::walks::{COLUMNS, Ground, Question};
use super::{about_its_middle, shortened, with_device, write_answer};
use crate::cli::files::{Sink, check_unread};
use crate::cli::{Command, Outcome};

/// Walk straight on a mesh, and continue on another one where they meet
///
/// In:  id,face,b0,b1,b2,dx,dy,dz,length
/// Out: id,mesh,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status
///
/// The scene is JSON: mesh_a and mesh_b (paths relative to it),
/// a_transform_row_major and b_transform_row_major (16 numbers each).
/// Walks begin on mesh A. If one meets mesh B, it is folded about the line in
/// which the two faces meet, into B's face, and continues there, to the side that
/// is less covered by A; it does not come back.
/// Directions and places are in world space. Faces are counted from 0 in the
/// order of the file, polygons cut into triangles. b0, b1 and b2 are the weights
/// of a face's first, second and third corner in the file; they sum to 1.
/// Mesh: 0 for A, 1 for B.
/// Status: 0 the whole length, 1 stopped at an open border, 2 no such walk.
#[derive(Clone, Debug, Args)]
#[command(
    verbatim_doc_comment,
    after_help = "\
Examples:
  myxo query transfer --scene two.json --in walks.csv --out ends.csv
  myxo query transfer --scene two.json < walks.csv | head"
)]
pub struct Transfer {
    #[command(flatten)]
    pair: PairOptions,
}

const HEADER: &str = "id,mesh,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status";

/// Squares of larger numbers do not fit a float32.
const FARTHEST: f64 = 1e18;

impl Command for Transfer {
    /// Reads, walks, writes.
    fn run(&self) -> Result<Outcome> {
        Sink::check(&self.pair.out)?;
        let placed = PlacedMesh::read_both(&self.pair.scene)?;
        let table = self.pair.questions(COLUMNS)?;
        check_unread(once(&self.pair.out), "")?;
        let [(a_centre, a), (b_centre, b)] =
            [0, 1].map(|k: usize| about_its_middle(&placed[k].mesh));
        let surface = Surface::build(&[(&a, 1.0), (&b, 1.0)]);
        let [world_from_a, world_from_b] = [(0, a_centre), (1, b_centre)].map(|(k, centre)| {
            let pose: DAffine3 = placed[k].world_from_mesh;
            pose * DAffine3::from_translation(centre)
        });
        let mut b_from_a = world_from_b.inverse() * world_from_a;
        // At this distance the meshes do not meet, so the exact place does not matter.
        b_from_a.translation = shortened(b_from_a.translation, FARTHEST);
        let poses = [b_from_a, DAffine3::IDENTITY].map(|pose| {
            let (x, y, z) = (
                pose.matrix3.x_axis,
                pose.matrix3.y_axis,
                pose.matrix3.z_axis,
            );
            let [x, y, z, at] = [x, y, z, pose.translation].map(|axis| axis.as_vec3());
            Pose::from(Affine3A::from_cols(x.into(), y.into(), z.into(), at.into()))
        });
        let question = Question {
            header: HEADER,
            surface: &surface,
            grounds: &[
                Ground {
                    mesh: &placed[0].mesh,
                    first_triangle: 0,
                    world_from_surface: world_from_a,
                },
                Ground {
                    mesh: &placed[1].mesh,
                    first_triangle: surface.objects[1].triangles.0,
                    world_from_surface: world_from_b,
                },
            ],
        };
        let on_device = |surface: &Surface, queries: &[WalkQuery]| {
            with_device(&self.pair.device, |ctx| {
                transfer_queries(ctx, surface, poses, self.pair.sign.into(), queries)
            })
        };
        write_answer(
            &self.pair.out,
            &question.answer(&table, &on_device)?.into_table(),
        )?;
        Ok(Outcome::Done)
    }
}
