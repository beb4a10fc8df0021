//! What sensors see that read straight ahead in the atlas, against what they would see at the end of a walk.

use std::f32::consts::TAU;

use crate::common::{gpu, scene, set_up};
use glam::Vec3;
use myxo::gpu::Kernel as _;
use myxo::mesh::surface::NONE;
use myxo::rng::{Purpose, random, unit};
use myxo::scene::Scene;
use myxo::scene::settings::{ObjectSettings, Sensing, Settings};
use myxo::sim::behaviour::physarums;
use myxo::sim::field::{texel_at, weights_at};
use myxo::sim::kernels::Advance;
use myxo::sim::plan::{Means, Plan};
use myxo::sim::step::advance::Form;
use myxo::sim::twin::{AdvanceInputs, straight_places};
use myxo::sim::types::Walker;
use myxo::sim::walker::walk;
use myxo::sim::{Setup, Simulation};

/// A place on the surface, as its object has it.
fn world(setup: &Setup, triangle: u32, u: f32, v: f32) -> Vec3 {
    let [a, b, c] = [0, 1, 2].map(|k| {
        let vertex = setup.corners[3 * triangle as usize + k];
        setup.vertices[vertex as usize].position
    });
    a + u * (b - a) + v * (c - a)
}

/// How far a sensor that reads straight ahead is from where it would have walked to, in parts of the way, in ascending
/// order; and which share of particles has all sensors straight ahead.
fn errors(mesh: &str, size: u32) -> (Vec<f32>, f64) {
    let mut settings = Settings::default();
    settings.particles.count = 4000;
    settings.atlas.size = size;
    settings.objects = vec![ObjectSettings {
        mesh: format!("builtin:{mesh}"),
        ..ObjectSettings::default()
    }];
    let scene = Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap();
    let setup = Setup::new(&scene).unwrap();
    let plan = Plan::new(&scene.settings, &setup, 0, Means::of_host(false, 1));
    let params = plan.advance(plan.terms(), Form::All).params;
    let own = physarums(&scene.settings, &setup)[0];
    let inputs = AdvanceInputs::of_surface(&setup, std::slice::from_ref(&own));
    let (mut errors, mut straight) = (Vec::new(), 0);
    for (i, particle) in setup.particles.iter().enumerate() {
        let turn = TAU * unit(random(3, i as u32, 0, Purpose::Start)[0]);
        let towards = [turn - 0.5, turn, turn + 0.5].map(|a| [a.cos(), a.sin()]);
        let Some(places) = straight_places(&params, &inputs, &own, particle, towards) else {
            continue;
        };
        straight += 1;
        for (heading, place) in towards.into_iter().zip(places) {
            let [u, v] = [particle.u, particle.v];
            let mut w = Walker::at(particle.triangle, u, v, heading, own.sensor_offset);
            w.entered_by = NONE;
            walk::<false>(
                &setup.surface.triangles,
                &setup.surface.halfedges,
                &mut w,
                64,
                true,
            );
            // A walk that ends beside a seam may have crossed it, where the line ends before: it is places on the surface
            // that are compared, not in the texture.
            let [u, v] = w.uv();
            let walked = world(&setup, w.triangle, u, v);
            let texel = texel_at(place, setup.atlas.pitch) as usize;
            let triangle = setup.atlas.owner[texel];
            let chart = |triangle: u32| setup.atlas.chart[triangle as usize];
            assert_eq!(chart(triangle), chart(particle.triangle), "{mesh}");
            let [u, v] = weights_at(&setup.atlas.maps[triangle as usize], place);
            let read = world(&setup, triangle, u, v);
            errors.push(read.distance(walked) / own.sensor_offset);
        }
    }
    errors.sort_by(f32::total_cmp);
    (errors, f64::from(straight) / setup.particles.len() as f64)
}

/// Charts keep angles and, nearly, sizes, so that what sensors read straight ahead lies where they would have walked to,
/// within a few per cent of the way. On a cube nothing is bent.
#[test]
fn sensors_that_read_straight_ahead_are_where_they_would_have_walked() {
    for (mesh, size, median, most, farthest, least_share) in [
        // Beside its corners a line may cut one, by a texel.
        ("cube", 512, 1e-4, 1e-3, 0.15, 0.5),
        ("torus", 1024, 0.02, 0.05, 0.1, 0.5),
        ("icosphere", 1024, 0.02, 0.05, 0.1, 0.5),
        ("suzanne", 1024, 0.05, 0.15, 0.5, 0.3),
    ] {
        let (errors, share) = errors(mesh, size);
        let at = |part: f64| errors[((errors.len() - 1) as f64 * part) as usize];
        let row = format!(
            "{mesh}: {:.1} % of the particles have all sensors straight ahead; off by {:.4} of the way (median), \
             {:.4} (95 %), {:.4} (99 %), {:.4} (most)",
            100.0 * share,
            at(0.5),
            at(0.95),
            at(0.99),
            at(1.0)
        );
        println!("{row}");
        assert!(
            at(0.5) < median && at(0.95) < most && at(1.0) < farthest && share > least_share,
            "{row}"
        );
    }
}

/// On a mesh of small triangles most sensors read straight ahead; those near seams walk, and so do all that have to.
#[test]
fn sensors_walk_where_seams_are_near() {
    let Some(gpu) = gpu() else { return };
    let share = |change: fn(&mut Settings)| {
        let scene = scene("builtin:torus", |s| {
            s.particles.count = 2000;
            s.atlas.size = 512;
            change(s);
        });
        let setup = set_up(&gpu.ctx, &scene);
        let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup).unwrap();
        // Twice, because the list restarts in each step.
        for _ in 0..2 {
            gpu.run(|rec| simulation.record_step(rec));
        }
        let walkers = gpu.ctx.download(&simulation.state().walkers.slots).unwrap();
        let count = gpu.ctx.download(&simulation.state().walkers.count).unwrap()[0];
        let mut slots = walkers[..count as usize].to_vec();
        slots.sort_unstable();
        slots.dedup();
        assert_eq!(slots.len(), count as usize, "no slot is listed twice");
        let groups = gpu
            .ctx
            .download(&simulation.state().walkers.groups)
            .unwrap()[0];
        let invocations = groups.y * groups.x * Advance::GROUP_SIZE;
        assert!(invocations >= count, "{groups:?} for {count}");
        f64::from(count) / 2000.0
    };
    let near = share(|s| s.physarum.sensor_offset = 0.01);
    let far = share(|s| s.physarum.sensor_offset = 0.05);
    assert!(
        near > 0.0 && near < 0.3 && far > 1.5 * near && far < 1.0,
        "{near}, {far}"
    );
    // Particles with a pending rest walk it first, and sense from there.
    let with_rests = share(|s| {
        s.physarum.sensor_offset = 0.01;
        s.physarum.edge_crossing_attempts = 0;
    });
    assert!(with_rests > near + 0.2, "{near}, {with_rests}");
    assert_eq!(share(|s| s.physarum.sensing = Sensing::Walk), 0.0);
    assert_eq!(share(|s| s.physarum.gravity_weight = 1.0), 0.0);
    gpu.finish();
}
