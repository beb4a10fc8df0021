//! The trail spreads over the line in which two surfaces meet, if a scene says so.

use crate::advance;
use crate::common::{TRIO, gpu, scene_of_several};
use glam::{DAffine3, DVec3};
use myxo::scene::Scene;
use myxo::scene::settings::{DistanceMethod, Settings, Strategy, TrailAcross};
use myxo::sim::beside::first_difference;
use myxo::sim::spread::passes;
use myxo::sim::{Setup, Simulation, twin};

/// Two cubes that stand in each other at a right angle. The upper face of the first, y = 0, and the right one of the second, x = 0, meet in
/// the line x = y = 0, and are open where the other coordinate is above 0. A reflection at x = y takes the one to the other. The trail alone
/// changes.
fn two_cubes(across: TrailAcross, change: impl FnOnce(&mut Settings)) -> Scene {
    let cubes = [("cube", [-0.3, -1.0, 0.0]), ("cube", [-1.0, -0.3, 0.1])];
    scene_of_several(&cubes, |s| {
        for object in &mut s.objects {
            object.rotation = [0.0; 3];
        }
        s.radius = 1.0;
        s.particles.count = 1;
        s.physarum.deposit = 0.0;
        s.atlas.size = 256;
        s.trail.decay = 1.0;
        s.trail.across = across;
        change(s);
    })
}

/// For each texel of an object on the face that the line bounds: the texel, how far from the line it is, positive outside of the other
/// object, and its place along the line.
fn beside_the_line(setup: &Setup, object: usize) -> Vec<(usize, f64, f64)> {
    let pose = DAffine3::from(&setup.poses[object]);
    let (first, end) = setup.distance.ranges[object];
    let samples = &setup.distance.samples[first as usize..end as usize];
    let places = samples.iter().map(|sample| {
        let place: DVec3 = pose.transform_point3(sample.position.as_dvec3()) + setup.origin();
        (sample.texel as usize, place)
    });
    places
        .filter_map(|(texel, place)| {
            let (height, away) = match object {
                0 => (place.y, place.x),
                _ => (place.x, place.y),
            };
            (height.abs() < 1e-5).then_some((texel, away, place.z))
        })
        .collect()
}

/// A twin of the scene, with this trail at each place beside the line, by object, distance from the line and place along it.
fn with_trail(scene: Scene, trail: impl Fn(usize, f64, f64) -> f64) -> twin::Simulation {
    let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings);
    let mut state = twin.snapshot();
    for object in [0, 1] {
        for (texel, away, along) in beside_the_line(twin.setup(), object) {
            state.trail[texel] = trail(object, away, along) as f32;
        }
    }
    twin.restore(&state);
    twin
}

/// The trail of each object where nothing covers it, times the area.
fn open_mass(twin: &twin::Simulation) -> [f64; 2] {
    let (setup, trail) = (twin.setup(), &twin.arrays().trail);
    let (distances, _) = twin.distances();
    [0, 1].map(|object: usize| {
        let (first, end) = setup.distance.ranges[object];
        let samples = &setup.distance.samples[first as usize..end as usize];
        let texels = samples.iter().map(|sample| sample.texel as usize);
        let open = texels.filter(|&texel| distances[texel] >= 0.0);
        open.map(|texel| f64::from(trail[texel]) * f64::from(setup.atlas.area[texel]))
            .sum()
    })
}

/// The share of a normal distribution beyond so many standard deviations.
fn share_beyond(from: f64) -> f64 {
    const PARTS: u32 = 4000;
    let width = (8.0 - from) / f64::from(PARTS);
    let middles = (0..PARTS).map(|part| from + (f64::from(part) + 0.5) * width);
    let sum: f64 = middles.map(|x| (-0.5 * x * x).exp()).sum();
    sum * width / std::f64::consts::TAU.sqrt()
}

/// Would alone catch: trail that does not reach the other object, or reaches it with the key off; that comes to another place of it, too
/// fast or too slowly, also where its texels have another size; that crosses one way only; and trail that is made or lost at the line.
///
/// A spot on one object, 8 texel sides from the line, spreads until its standard deviation is 8 texel sides. On one plane a share of 0.159
/// would be beyond the line then. Places are read to within a texel, and texels count as a whole on one side of the line, so the line
/// may be off by two texels. What an object gains there and what the other one loses may then differ by the trail on three.
#[test]
fn a_spot_beside_the_line_spreads_as_on_one_plane() {
    const STEPS: u32 = 90;
    // In sides of a texel of mean area.
    const AWAY: f64 = 8.0;
    const FIRST: f64 = 2.0;
    const LAST: f64 = 8.0;
    let spread = |across: TrailAcross, from: usize, weight: f32| {
        let scene = two_cubes(across, |s| {
            // Two passes a step; its variance is two thirds of a texel.
            s.trail.diffusion = 1.0;
            s.objects[1].texel_weight = weight;
        });
        let side = Setup::new(&scene).unwrap().atlas.mean_texel_area.sqrt();
        let mut twin = with_trail(scene, |object, away, along| {
            let [x, z] = [away / side - AWAY, along / side].map(|x| x / FIRST);
            let is_there = object == from && away > 0.0;
            f64::from(u8::from(is_there)) * (-0.5 * (x * x + z * z)).exp()
        });
        let start: f64 = twin.snapshot().trail_mass(twin.setup());
        let largest = f64::from(twin.setup().texel_side) / side;
        for _ in 0..STEPS {
            twin.step();
        }
        let end = open_mass(&twin).map(|mass| mass / start);
        (end[1 - from], end[0] + end[1] - 1.0, largest)
    };
    assert_eq!(FIRST * FIRST + f64::from(STEPS) / 1.5, LAST * LAST);
    // The density of a normal distribution one standard deviation from its middle, a texel.
    let on_a_texel = (-0.5_f64).exp() / std::f64::consts::TAU.sqrt() / LAST;
    let mut crossed = Vec::new();
    for (from, weight) in [(0, 1.0), (1, 1.0), (0, 0.5), (1, 0.5)] {
        let (share, gained, largest) = spread(TrailAcross::On, from, weight);
        println!("from {from}, weight {weight}: {share:.4} has crossed, {gained:+.4} gained");
        let [least, most] = [2.0, -2.0].map(|off| share_beyond((AWAY + off * largest) / LAST));
        assert!(least < share && share < most, "{share}: {least} to {most}");
        let bound = 3.0 * largest * on_a_texel;
        assert!(gained.abs() < bound, "{gained}, more than {bound}");
        crossed.push(share);
    }
    // The mirrored spot: which object it is on does not matter by more than where texels lie.
    assert!((crossed[0] - crossed[1]).abs() < 2.0 * on_a_texel);

    let (share, gained, _) = spread(TrailAcross::Off, 0, 1.0);
    assert_eq!(share, 0.0);
    // What does not cross has gone inside, where it is not seen.
    assert!(gained < -0.5 * share_beyond(1.0), "{gained}");
}

/// Would alone catch: a trail that the blend at the line makes larger or smaller, texels of the gutter or covered ones that it reads, and
/// taps behind the line that get nothing, as those that are texels apart, and those of the second pass.
#[test]
fn a_constant_stays_constant_beside_the_line() {
    const CONSTANT: f32 = 0.7;
    let differing = |across: TrailAcross, diffusion: f32, taps: u32| {
        let scene = two_cubes(across, |s| {
            s.trail.diffusion = diffusion;
            s.trail.diffusion_distance = taps;
            // Sensors find places behind the line no farther away than this; diffusion needs more.
            s.physarum.sensor_offset = 0.001;
        });
        // Nothing is behind the line.
        let mut twin = with_trail(
            scene,
            |_, away, _| {
                if away > 0.0 { f64::from(CONSTANT) } else { 0.0 }
            },
        );
        for _ in 0..2 {
            twin.step();
        }
        let (distances, _) = twin.distances();
        let trail = &twin.arrays().trail;
        let (mut differing, mut near) = (0, 0);
        for object in [0, 1] {
            for (texel, away, along) in beside_the_line(twin.setup(), object) {
                // Other edges are too far away to matter.
                if distances[texel] >= 0.0 && away < 0.2 && along.abs() < 0.3 {
                    near += 1;
                    differing += u32::from(trail[texel] != CONSTANT);
                }
            }
        }
        assert!(near > 100, "{near}");
        differing
    };
    for (diffusion, taps) in [(0.5, 1), (1.0, 1), (0.5, 3)] {
        assert_eq!(differing(TrailAcross::On, diffusion, taps), 0, "{taps}");
        assert!(differing(TrailAcross::Off, diffusion, taps) > 20);
    }
}

/// Three objects, one of which moves, with trail that crosses.
fn crossing_trio(change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_several(&TRIO, |s| {
        s.particles.count = 501;
        s.atlas.size = 129;
        s.trail.across = TrailAcross::On;
        s.time.dt = 0.02;
        s.objects[1].motion.spin = [40.0, 0.0, 90.0];
        change(s);
    })
}

/// Would alone catch: engines that differ where the trail crosses, by a strategy whose sensors do not see other objects, by another method
/// of distances, in several passes; and a run that differs when it is resumed, or when the key has been set to off and back.
#[test]
fn both_engines_cross_alike() {
    let Some(gpu) = gpu() else { return };
    for (strategy, method, diffusion, length) in [
        (Strategy::Parallel, DistanceMethod::Bvh, 1.0, 0.0),
        (Strategy::None, DistanceMethod::Bvh, 0.5, 0.0),
        (Strategy::Respawn, DistanceMethod::Brute, 0.5, 0.0),
        // Several passes, with deposits in the first.
        (Strategy::None, DistanceMethod::Bvh, 0.0, 0.06),
    ] {
        let scene = crossing_trio(|s| {
            s.transfer.strategy = strategy;
            s.distance.method = method;
            s.trail.diffusion = diffusion;
            s.trail.diffusion_length = length;
        });
        let setup = Setup::new(&scene).unwrap();
        assert!(length == 0.0 || passes(&scene.settings, &setup) > 1);
        let found = first_difference(&gpu.ctx, &scene, &setup, 3, 2, &[]).unwrap();
        assert!(found.is_none(), "{strategy:?}: {}", found.unwrap());
    }

    let scene = crossing_trio(|_| ());
    let mut whole = Simulation::new(&gpu.ctx, &scene).unwrap();
    advance(&gpu, &mut whole, 4);
    let half = whole.snapshot().unwrap();
    let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
    resumed.restore(&half).unwrap();
    let mut other = whole.settings().clone();
    for across in [TrailAcross::Off, TrailAcross::On] {
        other.trail.across = across;
        whole.apply(&other).unwrap();
    }
    let mut apart = Simulation::new(&gpu.ctx, &scene).unwrap();
    apart.restore(&half).unwrap();
    other.trail.across = TrailAcross::Off;
    apart.apply(&other).unwrap();
    let [whole, resumed, apart] = [&mut whole, &mut resumed, &mut apart].map(|simulation| {
        advance(&gpu, simulation, 4);
        simulation.snapshot().unwrap().hash()
    });
    assert_eq!(whole, resumed);
    assert_ne!(whole, apart, "it has an effect");
    gpu.finish();
}
