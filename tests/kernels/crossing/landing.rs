//! Landing of particles without a crossing: on the nearest point, turned about the line in which the two planes would meet.

use glam::{DAffine3, DQuat, DVec3};
use myxo::gpu::Frames;
use myxo::scene::Scene;
use myxo::scene::settings::Strategy;
use myxo::sim::Simulation;
use myxo::sim::types::{Motion, Particle};

use crate::common::{by_id, gpu, scene_of_several};

/// A plane and a smaller one above it, tilted by this many degrees about X.
fn scene(tilt: f64) -> Scene {
    let meshes = [
        ("plane?columns=3&rows=2", [0.0; 3]),
        ("plane?columns=5&rows=7", [0.0; 3]),
    ];
    scene_of_several(&meshes, |s| {
        s.particles.count = 4000;
        s.atlas.size = 256;
        s.distance.reach = 0.4;
        s.transfer.strategy = Strategy::Direct;
        s.transfer.threshold = 0.4;
        s.physarum.speed = 0.004;
        s.physarum.rotation_angle = 0.0;
        for object in &mut s.objects {
            object.rotation = [0.0; 3];
        }
        s.objects[1].scale = 0.2;
        s.objects[1].position = [0.1, 0.3, -0.05];
        s.objects[1].rotation = [tilt as f32, 0.0, 0.0];
    })
}

#[test]
fn particles_without_a_crossing_land_on_the_nearest_point() {
    let Some(gpu) = gpu() else { return };
    for tilt in [20.0_f64, 60.0, -75.0, 150.0] {
        let scene = scene(tilt);
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let before = by_id(&simulation.snapshot().unwrap());
        let mut frames = Frames::new(&gpu.ctx, 1).unwrap();
        frames.run(|rec| simulation.record_step(rec)).unwrap();
        let after = simulation.snapshot().unwrap();
        assert_eq!(after.transfers.flow.crossed, 0);

        let setup = simulation.setup();
        let surface = &setup.surface;
        let object = |p: &Particle| surface.triangles[p.triangle as usize].object;
        let radius = f64::from(scene.radius);
        let rotation = DQuat::from_rotation_x(tilt.to_radians());
        let middle = DVec3::new(0.1, 0.3, -0.05);
        let world_from_upper = DAffine3::from_rotation_translation(rotation, middle);
        let normals = [DVec3::Y, rotation * DVec3::Y];
        // Place and heading of a particle in world space, by the corners of the triangle.
        let in_world = |(p, m): (Particle, Motion)| {
            let corners = surface.corners[p.triangle as usize];
            let [a, b, c] = corners.map(|v| surface.positions[v as usize].as_dvec3());
            let place = a + f64::from(p.u) * (b - a) + f64::from(p.v) * (c - a);
            let along = (b - a).normalize();
            let across = (b - a).cross(c - a).normalize().cross(along);
            let heading = f64::from(m.heading_p) * along + f64::from(m.heading_h) * across;
            if object(&p) == 0 {
                (place, heading)
            } else {
                let place = world_from_upper.transform_point3(place);
                (place, world_from_upper.transform_vector3(heading))
            }
        };
        let mut landed = [0, 0];
        for (from, to) in before.into_iter().zip(by_id(&after)) {
            let [source, target] = [object(&from.0), object(&to.0)];
            if source == target {
                continue;
            }
            let (start, heading) = in_world(from);
            let (place, turned) = in_world(to);
            let left = start + 0.004 * radius * heading;
            // Particles reflected at the border of a plane have not gone straight on.
            let within = |p: DVec3, half: f64| p.x.abs() < half && p.z.abs() < half;
            let own = if source == 0 {
                left
            } else {
                world_from_upper.inverse().transform_point3(left)
            };
            if !within(own, if source == 0 { 1.0 } else { 0.2 }) {
                continue;
            }
            landed[target as usize] += 1;
            let half = if target == 0 { 1.0 } else { 0.2 };
            let world_from_target = if target == 0 {
                DAffine3::IDENTITY
            } else {
                world_from_upper
            };
            let nearest = world_from_target.inverse().transform_point3(left);
            let nearest = nearest.clamp(DVec3::new(-half, 0.0, -half), DVec3::new(half, 0.0, half));
            let nearest = world_from_target.transform_point3(nearest);
            let off = place.distance(nearest) / radius;
            // Squared distances cannot separate neighbours whose points are nearer to one another than this.
            assert!(off < 1e-4, "{tilt} degrees: {off} from {nearest}: {to:?}");
            let fold = DQuat::from_rotation_arc(normals[source as usize], normals[target as usize]);
            let off = turned.angle_between(fold * heading).to_degrees();
            assert!(off < 0.01, "{tilt} degrees: {off}: {to:?}");
        }
        assert!(landed.iter().all(|&count| count > 20), "{tilt}: {landed:?}");
    }
    gpu.finish();
}
