//! The kernel of `myxo query transfer` against its twin.

use glam::{DAffine3, DQuat, DVec2, DVec3};
use myxo::mesh::surface::Surface;
use myxo::mesh::trees::sides::Sides;
use myxo::mesh::walk::{SurfacePoint, WalkEnd, WalkQuery, WalkStatus};
use myxo::mesh::{Mesh, trees::Trees};
use myxo::scene::settings::SignRule;
use myxo::sim::crossing::Terrain;
use myxo::sim::ground::Ground;
use myxo::sim::kernels::TransferQueriesParams;
use myxo::sim::queries::{end_of, walker_of};
use myxo::sim::transfer_queries::transfer_queries;
use myxo::sim::transfer_walk::{PHASE_DONE, PHASE_ON_SOURCE};
use myxo::sim::twin::transfer_queries as twin;
use myxo::sim::types::{Pose, Vertex, Walker};

use super::{pose, word};
use crate::common::{Gpu, gpu};

fn queries(count: usize, triangles: u32, length: f64) -> Vec<WalkQuery> {
    let number = |i, k| f64::from(word(i, k));
    (0..count)
        .map(|i| {
            let u = number(i, 1);
            WalkQuery {
                start: SurfacePoint {
                    triangle: (number(i, 0) * f64::from(triangles)) as u32,
                    u,
                    v: (1.0 - u) * number(i, 2),
                },
                heading: DVec2::from_angle(std::f64::consts::TAU * number(i, 3)),
                length: length * number(i + count, 0),
            }
        })
        .collect()
}

/// Few attempts at a time, so that walks of the twin stop and continue in every phase. How many have changed objects.
fn agree(gpu: &Gpu, surface: &Surface, poses: [Pose; 2], queries: &[WalkQuery]) -> usize {
    let trees = Trees::build(surface);
    let first = surface.objects[1].triangles.0;
    let count = queries.len();
    let ends = transfer_queries(&gpu.ctx, surface, poses, SignRule::Pseudonormal, queries).unwrap();

    let vertices = Vertex::of(surface);
    let roots: Vec<u32> = trees.objects.iter().map(|tree| tree.first_node).collect();
    let corners = surface.corners.as_flattened();
    let terrain = Terrain {
        ground: Ground {
            triangles: &surface.triangles,
            corners,
            vertices: &vertices,
            poses: &poses,
        },
        halfedges: &surface.halfedges,
        sides: Sides {
            faces: &trees.faces,
            nodes: &trees.nodes,
            dipoles: &trees.dipoles,
            pseudonormals: &trees.pseudonormals,
            corners,
            first_vertex_normal: surface.halfedges.len() as u32,
        },
        roots: &roots,
        sign_rule: 0,
        reflects: false,
    };
    let params = TransferQueriesParams {
        query_count: count as u32,
        attempts: 3,
        first_vertex_normal: surface.halfedges.len() as u32,
    };
    let mut walkers: Vec<Walker> = queries.iter().flat_map(|q| [walker_of(q); 2]).collect();
    let mut phases = vec![PHASE_ON_SOURCE; count];
    let mut dispatches = 0;
    while phases.iter().any(|&phase| phase != PHASE_DONE) {
        twin::transfer_queries(&params, &terrain, &mut phases, &mut walkers);
        dispatches += 1;
        assert!(dispatches < 1000, "{phases:?}");
    }
    let of_twin = walkers.iter().step_by(2).zip(queries);
    let of_twin: Vec<WalkEnd> = of_twin.map(|(w, query)| end_of(w, query)).collect();
    assert_eq!(ends, of_twin);
    let has_ended = |end: &WalkEnd| end.status != WalkStatus::OutOfAttempts;
    assert!(ends.iter().all(has_ended));
    let has_changed = |end: &&WalkEnd| end.point.triangle >= first;
    ends.iter().filter(has_changed).count()
}

#[test]
fn walks_that_change_objects_agree_with_the_twin() {
    let Some(gpu) = gpu() else { return };
    let turn = DQuat::from_axis_angle(DVec3::new(0.3, 1.0, -0.2).normalize(), 0.8);
    for (a, b, count) in [
        ("torus?major=12&minor=8", "icosphere?subdivisions=2", 1021),
        ("plane?columns=4&rows=3", "torus?major=12&minor=8", 65),
        ("icosphere?subdivisions=3", "plane?columns=4&rows=3", 64),
        ("cube?divisions=2", "cube", 1),
    ] {
        let [a, b] = [a, b].map(|name| Mesh::builtin(name).unwrap());
        let surface = Surface::build(&[(&a, 1.0), (&b, 1.0)]);
        let first = surface.objects[1].triangles.0;
        let queries = queries(count, first, 3.0);
        let at = DAffine3::from_rotation_translation(turn, DVec3::new(0.5, 0.3, 0.1));
        let poses = [pose(DAffine3::IDENTITY), pose(at)];
        let changed = agree(&gpu, &surface, poses, &queries);
        assert!(
            count < 2 || changed * 10 > count,
            "{changed} of {count} changed"
        );
    }
    gpu.finish();
}

/// Walks end in the middle of the fine ball that they come from, where all faces are about equally near, and some devices end
/// the search before its end.
#[test]
fn walks_that_end_in_the_middle_of_a_fine_ball_agree_with_the_twin() {
    let Some(gpu) = gpu() else { return };
    let ball = Mesh::builtin("icosphere?subdivisions=6").unwrap();
    let mut plane = Mesh::builtin("plane?columns=4&rows=3").unwrap();
    for position in &mut plane.positions {
        *position *= 3.0;
    }
    let surface = Surface::build(&[(&ball, 1.0), (&plane, 1.0)]);
    let height = |corners: &[u32; 3]| {
        let heights = corners.map(|corner| ball.positions[corner as usize].y);
        heights.iter().sum::<f32>()
    };
    let tops = ball.corners.iter().map(height).enumerate();
    let (top, _) = tops.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap();
    // Down to the plane and on to the middle.
    let queries: Vec<WalkQuery> = (0..16)
        .map(|i| WalkQuery {
            start: SurfacePoint {
                triangle: top as u32,
                u: 0.3,
                v: 0.3,
            },
            heading: DVec2::from_angle(std::f64::consts::TAU * f64::from(i) / 16.0),
            length: std::f64::consts::FRAC_PI_2 + 0.97 + 0.004 * f64::from(i),
        })
        .collect();
    let stands = pose(DAffine3::IDENTITY);
    let changed = agree(&gpu, &surface, [stands, stands], &queries);
    assert_eq!(changed, queries.len(), "all of them meet the plane");
    gpu.finish();
}
