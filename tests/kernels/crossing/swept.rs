//! Objects that move over particles in a step: those cross where that happened, whether they walk or not.

use glam::{DAffine3, DQuat, DVec3};
use myxo::sim::Setup;
use myxo::sim::ground::Ground;
use myxo::sim::kernels::TransferOutConstants;
use myxo::sim::texel_paths::TexelPaths;
use myxo::sim::types::{Motion, Particle};

use super::{Case, heading, of_speed, pose, scene, word};
use crate::common::gpu;

/// One plane lies, another one stands on it at right angles and goes along it from its own -0.5 to 0.5, and sinks or rises
/// by more than the rest of a walk that meets it. Particles at rest are overtaken where they are; walking particles meet it on the
/// way, at a time that can be worked out.
#[test]
fn overtaken_particles_go_on_from_their_place() {
    let Some(gpu) = gpu() else { return };
    let meshes = [
        ("plane?columns=3&rows=2", [0.0; 3]),
        ("plane?columns=5&rows=7", [0.0; 3]),
    ];
    let scene = scene(&meshes, |s| s.particles.count = 400);
    let setup = Setup::new(&scene).unwrap();
    let half = f64::from(setup.surface.positions[0].abs().max_element());
    let anywhere = DAffine3::from_rotation_translation(
        DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 2.2),
        DVec3::new(0.7, -0.3, 1.9),
    );
    // The first one moves as well: only what is relative counts.
    let earlier = DAffine3::from_translation(DVec3::new(0.1, 0.2, -0.3)) * anywhere;
    // The second plane stands upright on X of the first one, and goes along it.
    let at = |x: f64, y: f64| {
        DAffine3::from_translation(DVec3::new(x, y, 0.0) * half)
            * DAffine3::from_quat(DQuat::from_rotation_z(0.25 * std::f64::consts::TAU))
    };
    let poses = [pose(anywhere), pose(anywhere * at(0.5, 0.0))];
    let first = setup.surface.objects[1].triangles.0;
    let nearest = vec![first; setup.atlas.texel_count()];
    let particles: Vec<Particle> = setup
        .particles
        .iter()
        .copied()
        .filter(|p| p.triangle < first)
        .collect();
    let motions: Vec<Motion> = (0..particles.len())
        .map(|i| heading(word(i, 2), 0.0))
        .collect();
    let ground = Ground::of(&setup, &poses);
    // The second look alone lets them walk.
    let looks = vec![1.0; setup.atlas.texel_count()];
    for (speed, risen) in [
        (0.0, 0.0),
        (0.0, -0.2),
        (0.2, 0.0),
        (0.2, -0.35),
        (0.2, 0.35),
    ] {
        let speed = speed * half;
        let poses_before = [pose(earlier), pose(earlier * at(-0.5, -risen))];
        let case = Case {
            setup: &setup,
            poses: &poses,
            poses_before: &poses_before,
            nearest: &nearest,
            particles: &particles,
            motions: &motions,
            physarums: &[0.0, 0.0, speed as f32].map(of_speed),
            bias: &[],
            looks: &looks,
            constants: TransferOutConstants {
                border_reflects: true,
                sign_rule: 0,
                own_physarum: false,
                painted: false,
                looks: true,
                paths: TexelPaths::default(),
            },
            counted: 0,
        };
        let (transfers, _, crossed) = case.by_kernel(&gpu);
        let mut swept = 0;
        for transfer in &transfers[..particles.len()] {
            let slot = transfer.particle as usize;
            let flight = ground.flight(&particles[slot], &motions[slot]);
            let place = anywhere
                .inverse()
                .transform_point3(flight.position.as_dvec3())
                / half;
            let way = anywhere.matrix3.transpose() * flight.heading.as_dvec3() * speed / half;
            let start = place - way;
            // At time t it is at start + t way, and the other plane at t - 0.5.
            let time = (start.x + 0.5) / (1.0 - way.x);
            let met = start + time * way;
            let is_sure = (0.01..0.99).contains(&time)
                && [place, start].iter().all(|p| p.abs().max_element() < 0.95);
            if !is_sure {
                continue;
            }
            swept += 1;
            // What is left of the way continues along the line or away from the first plane, to its upper side.
            let rest = (1.0 - time) * way.length();
            let along = if speed == 0.0 {
                0.0
            } else {
                way.z / way.length()
            };
            let expected = DVec3::new(0.5, 0.0, met.z + rest * along);
            // Meanwhile the second one takes it along.
            let up = (1.0 - time) * risen + rest * (1.0 - along * along).sqrt();
            let off = anywhere
                .inverse()
                .transform_point3(transfer.position.as_dvec3())
                / half
                - DVec3::Y * up
                - expected;
            assert!(
                off.length() < 2e-5,
                "{speed}, {risen}: {off} of {transfer:?}"
            );
        }
        assert!(swept > 40 && crossed >= swept, "{swept}, {crossed}");
    }
    gpu.finish();
}
