//! Brushes: the kernels against their twins, strokes over seams and on touching objects, and what they do to a run.

use std::sync::Arc;

use crate::common::{Gpu, TRIO, awkward_sizes, gpu, scene, scene_of_several};
use glam::{UVec2, Vec3};
use myxo::gpu::{Buffer, Context, Domain, Pipeline, Texels, Threads};
use myxo::rng::{Purpose, random, unit};
use myxo::scene::Scene;
use myxo::scene::settings::{AtlasMethod, Strategy};
use myxo::sim::kernels::{
    Paint, PaintArgs, PaintConstants, PaintParams, Teleport, TeleportArgs, TeleportParams,
};
use myxo::sim::paint::{
    Brush, Dab, GREATEST, NO_GO, NO_GO_BELOW, Painted, PaintedField, Repainted,
};
use myxo::sim::texel_paths::TexelPaths;
use myxo::sim::types::{Motion, Particle, Triangle};
use myxo::sim::{Areas, Setup, Simulation, Snapshot, Texture, twin};

fn buffer<T: bytemuck::Pod>(ctx: &Arc<Context>, name: &str, data: &[T]) -> Buffer<T> {
    let buffer = Buffer::new(ctx, name, data.len().max(1), Domain::Device).unwrap();
    if !data.is_empty() {
        ctx.upload(&buffer, data).unwrap();
    }
    buffer
}

#[test]
fn paint_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    for count in awkward_sizes(64).into_iter().chain([4_200_001]) {
        let texels = (2 * count as usize + 8).next_multiple_of(4);
        // Each texel once, in no order; some of the field is no-go, some negative.
        let dab: Vec<UVec2> = (0..count)
            .map(|i| {
                let words = random(3, i, 0, Purpose::Paint);
                UVec2::new(2 * (count - 1 - i) + words[1] % 2, unit(words[0]).to_bits())
            })
            .collect();
        let start: Vec<f32> = (0..texels as u32)
            .map(|i| match i % 7 {
                0 => NO_GO,
                1 => 0.5 * NO_GO_BELOW,
                2 => 3.0 * GREATEST,
                _ => 20.0 * unit(random(5, i, 0, Purpose::Paint)[2]) - 10.0,
            })
            .collect();
        for (fade, amount, no_go) in [
            (0.0, 3.7, f32::MIN),
            (0.6, 0.0, NO_GO_BELOW),
            (1.0, 0.0, NO_GO_BELOW),
            (0.0, 2.0 * NO_GO, NO_GO_BELOW),
            (0.3, -1.2, f32::MIN),
        ] {
            let params = PaintParams {
                texel_count: count,
                fade,
                amount,
                lowest: NO_GO,
                highest: GREATEST,
                no_go,
            };
            let mut expected = start.clone();
            twin::paint(&params, &dab, &mut expected);
            // What is more than the bound stays, where more is added.
            let mut pairs = expected.iter().zip(&start);
            let is_lowered = pairs.any(|(after, before)| *before > GREATEST && after < before);
            assert!(!is_lowered || fade > 0.0 || amount < 0.0, "{params:?}");
            // In two parts where there is enough for them.
            let in_parts = texels > 128 && count < 2000;
            let constants = [false, true].map(|in_quads| PaintConstants {
                paths: TexelPaths {
                    in_quads,
                    band: if in_quads { 64 } else { u32::MAX },
                    outgrows_block: false,
                },
            });
            for constants in constants.into_iter().take(1 + usize::from(in_parts)) {
                let field = buffer(&gpu.ctx, "field", &start);
                let field = Texture::by_paths(constants.paths, field).unwrap();
                let pipeline = Pipeline::<Paint>::new(&gpu.ctx, &constants).unwrap();
                gpu.run(|rec| {
                    rec.dispatch(
                        &pipeline,
                        Threads(count),
                        PaintArgs {
                            dab: &buffer(&gpu.ctx, "dab", &dab),
                            field: &field,
                        },
                        params,
                    );
                });
                let painted: Vec<f32> = gpu.ctx.download(&field).unwrap();
                assert!(painted == expected, "{count} texels, {params:?}");
            }
        }
    }
    gpu.finish();
}

#[test]
fn teleport_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let triangles: Vec<Triangle> = (0..9)
        .map(|i| Triangle {
            ab: 1.0,
            cp: 0.5,
            ch: 1.0,
            object: i / 3,
        })
        .collect();
    // The middle object is not touched.
    let ranges = [UVec2::new(0, 5), UVec2::new(5, 0), UVec2::new(5, 97)];
    let places: Vec<Particle> = (0..102)
        .map(|i| Particle {
            triangle: if i < 5 { i % 3 } else { 6 + i % 3 },
            u: 0.001 * i as f32,
            v: 0.25,
            id: u32::MAX,
        })
        .collect();
    let pipeline = Pipeline::<Teleport>::new(&gpu.ctx, &()).unwrap();
    // The last one has more than 65,535 groups, so its dispatch has two dimensions.
    for count in awkward_sizes(64).into_iter().chain([4_200_001]) {
        let mut particles: Vec<Particle> = (0..count)
            .map(|i| Particle {
                triangle: i % 9,
                u: 0.3,
                v: 0.3,
                id: count - 1 - i,
            })
            .collect();
        let mut motions: Vec<Motion> = (0..count)
            .map(|i| Motion {
                heading_p: 1.0,
                heading_h: 0.0,
                pending: 0.5,
                flags: (i % 11 == 3).into(),
            })
            .collect();
        let params = TeleportParams {
            particle_count: count,
            seed: 9,
            dab: 4,
            share: 0.2,
        };
        let particle_buffer = buffer(&gpu.ctx, "particles", &particles);
        let motion_buffer = buffer(&gpu.ctx, "motions", &motions);
        gpu.run(|rec| {
            rec.dispatch(
                &pipeline,
                Threads(count),
                TeleportArgs {
                    places: &buffer(&gpu.ctx, "places", &places),
                    place_ranges: &buffer(&gpu.ctx, "place_ranges", &ranges),
                    triangles: &Texels::new(&buffer(&gpu.ctx, "triangles", &triangles), 4).unwrap(),
                    particles: &Texels::new(&particle_buffer, 4).unwrap(),
                    motions: &Texels::new(&motion_buffer, 4).unwrap(),
                },
                params,
            );
        });
        twin::teleport(
            &params,
            &places,
            &ranges,
            &triangles,
            &mut particles,
            &mut motions,
        );
        let come = motions
            .iter()
            .filter(|motion| motion.pending == 0.0)
            .count();
        if count > 1000 {
            // Two objects of three, and ten particles of eleven, of which a fifth comes.
            let share = come as f64 / f64::from(count);
            assert!(
                (share - 0.2 * 2.0 / 3.0 * 10.0 / 11.0).abs() < 0.04,
                "{share}"
            );
        }
        if count == 0 {
            continue;
        }
        assert_eq!(gpu.ctx.download(&particle_buffer).unwrap(), particles);
        let gpu_motions: Vec<Motion> = gpu.ctx.download(&motion_buffer).unwrap();
        for (a, b) in gpu_motions.iter().zip(&motions) {
            assert_eq!((a.pending, a.flags), (b.pending, b.flags));
            let off = (a.heading_p - b.heading_p).hypot(a.heading_h - b.heading_h);
            assert!(off < 1e-5, "{a:?}, and {b:?}");
        }
    }
    gpu.finish();
}

fn dab(brush: Brush, center: Vec3, radius: f32) -> Dab {
    Dab {
        brush,
        center,
        radius,
        eye: None,
        ring: None,
        number: 1,
    }
}

fn paint(gpu: &Gpu, simulation: &mut Simulation, dab: &Dab) -> Painted {
    let mut painted = Painted::default();
    gpu.run(|rec| painted = simulation.paint(rec, dab).unwrap());
    painted
}

fn steps(gpu: &Gpu, simulation: &mut Simulation, count: u32) {
    for _ in 0..count {
        gpu.run(|rec| simulation.record_step(rec));
    }
}

/// A torus with a cube and a ball that touch it.
fn trio(strategy: Strategy) -> Scene {
    scene_of_several(&TRIO, |settings| {
        settings.particles.count = 4000;
        settings.atlas.size = 256;
        settings.transfer.strategy = strategy;
    })
}

/// All brushes that change fields, and the one that takes particles there.
const BRUSHES: [Brush; 5] = [
    Brush::Trail { amount: 4.0 },
    Brush::Attract { amount: 2.0 },
    Brush::NoGo,
    Brush::Attract { amount: -3.0 },
    Brush::Erase { share: 0.4 },
];
const TELEPORT: Brush = Brush::Particles { share: 0.3 };

/// All brushes, between steps, on the GPU and by twins: both have the same trail, the same bias, and no particle is lost.
#[test]
fn every_brush_agrees_with_the_twins_between_steps() {
    let Some(gpu) = gpu() else { return };
    for strategy in [Strategy::Parallel, Strategy::Direct, Strategy::None] {
        let scene = trio(strategy);
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut twin =
            twin::Simulation::new(Setup::new(&scene).unwrap(), simulation.settings().clone());
        let at = Vec3::new(0.3, 0.5, 0.3);
        for (i, brush) in BRUSHES.into_iter().enumerate() {
            let center = at + 0.05 * Vec3::new(i as f32, 0.0, -(i as f32));
            let dab = dab(brush, center, 0.9);
            let painted = paint(&gpu, &mut simulation, &dab);
            assert_eq!(painted, twin.paint(&dab).unwrap());
            assert!(painted.texels.iter().filter(|count| **count > 0).count() >= 2);
            let (gpu_state, twin_state) = (simulation.snapshot().unwrap(), twin.snapshot());
            assert!(gpu_state.bias == twin_state.bias, "{brush:?}");
            let near = |a: f32, b: f32| (a - b).abs() <= 1e-4 * a.abs().max(b.abs()) + 1e-6;
            let off = gpu_state.trail.iter().zip(&twin_state.trail);
            let off = off.filter(|(a, b)| !near(**a, **b)).count();
            assert_eq!(off, 0, "{brush:?}");
            steps(&gpu, &mut simulation, 1);
            twin.step();
            let state = simulation.snapshot().unwrap();
            state.validate(simulation.setup()).unwrap();
            // From one state again, so that what rounding did to a few particles does not grow.
            twin.restore(&state);
        }
        let teleport = dab(TELEPORT, at, 0.9);
        paint(&gpu, &mut simulation, &teleport);
        twin.paint(&teleport).unwrap();
        let by_id = |state: Snapshot| {
            let mut all: Vec<(u32, u32)> = (state.particles.iter())
                .map(|particle| (particle.id, particle.triangle))
                .collect();
            all.sort_unstable();
            all
        };
        assert_eq!(
            by_id(simulation.snapshot().unwrap()),
            by_id(twin.snapshot())
        );
        steps(&gpu, &mut simulation, 5);
        let state = simulation.snapshot().unwrap();
        state.validate(simulation.setup()).unwrap();
    }
    gpu.finish();
}

/// Every brush while it runs, without pictures between: a dab, a step and the next dab of the same brush are in order by
/// themselves, in one recording, and leave what they leave one by one.
#[test]
fn strokes_go_on_between_steps_without_pictures() {
    let Some(gpu) = gpu() else { return };
    let hash = |in_one_recording: bool| {
        let scene = trio(Strategy::Direct);
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let brushes = BRUSHES.into_iter().chain([TELEPORT]);
        let dabs = brushes.map(|brush| dab(brush, Vec3::new(0.3, 0.5, 0.3), 0.9));
        let dabs: Vec<Dab> = dabs.collect();
        // Each twice, with a step after it.
        let dabs = dabs.iter().flat_map(|dab| [dab, dab]);
        if in_one_recording {
            gpu.run(|rec| {
                for dab in dabs {
                    assert!(simulation.paint(rec, dab).unwrap().count() > 0);
                    simulation.record_step(rec);
                }
            });
        } else {
            for dab in dabs {
                paint(&gpu, &mut simulation, dab);
                steps(&gpu, &mut simulation, 1);
            }
        }
        let state = simulation.snapshot().unwrap();
        state.validate(simulation.setup()).unwrap();
        state.hash()
    };
    assert_eq!(hash(true), hash(false));
    gpu.finish();
}

/// On an edge of a cube where two charts meet: a dab paints both faces, with no gap and no doubled row, and as much trail as its
/// disc has area.
#[test]
fn a_dab_on_a_seam_paints_both_sides_and_adds_what_it_should() {
    let Some(gpu) = gpu() else { return };
    for method in [AtlasMethod::Charts, AtlasMethod::Grid] {
        let scene = scene("builtin:cube?divisions=8", |settings| {
            settings.atlas.size = 512;
            settings.atlas.method = method;
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = simulation.setup().clone();
        let corner = (setup.surface.positions.iter()).fold(0.0_f32, |far, p| far.max(p.x));
        let radius = 0.4 * corner;
        let amount = 2.5;
        // Of two faces, and a little off the middle of the edge between them.
        let centers = [0, 1, 2].into_iter().flat_map(|x| {
            let y = (x + 1) % 3;
            [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(move |signs| {
                let mut center = Vec3::splat(0.05 * corner);
                (center[x], center[y]) = (signs[0] * corner, signs[1] * corner);
                (x, center)
            })
        });
        let is_on_seam = |center: Vec3| {
            (0..setup.surface.halfedges.len() as u32).any(|halfedge| {
                let [a, b] = [halfedge % 3, (halfedge + 1) % 3].map(|corner| {
                    let vertex = setup.surface.corners[halfedge as usize / 3][corner as usize];
                    setup.surface.positions[vertex as usize]
                });
                let along = a.distance(center) + center.distance(b) - a.distance(b);
                along < 1e-4 * corner && setup.atlas.is_seam(&setup.surface, halfedge)
            })
        };
        let mut on_seams = centers.filter(|&(_, center)| is_on_seam(center));
        let (x, center) = on_seams.next().expect("charts meet at some edge");
        paint(
            &gpu,
            &mut simulation,
            &dab(Brush::Trail { amount }, center, radius),
        );
        let state = simulation.snapshot().unwrap();
        let r = f64::from(radius);
        let expected = f64::from(amount) * std::f64::consts::PI * r * r / 3.0;
        let mass = state.trail_mass(&setup);
        assert!(
            (mass / expected - 1.0).abs() < 0.05,
            "{method:?}: {mass}, not {expected}"
        );
        let mut sides = [0.0; 2];
        for (texel, value) in state.trail.iter().enumerate() {
            let Some((triangle, u, v)) = setup.atlas.surface_point_of(texel as u32) else {
                continue;
            };
            let [a, b, c] = setup.surface.corners[triangle as usize]
                .map(|vertex| setup.surface.positions[vertex as usize]);
            let at = a + u * (b - a) + v * (c - a);
            let share = at.distance_squared(center) / (radius * radius);
            let weight = (1.0 - share).max(0.0).powi(2);
            assert!((value - amount * weight).abs() < 1e-3, "{method:?}: {at}");
            let on_x = at[x] * center[x] > 0.999 * corner * corner;
            sides[usize::from(on_x)] += f64::from(*value);
        }
        assert!(
            (sides[0] / sides[1] - 1.0).abs() < 0.1,
            "{method:?}: {sides:?}"
        );
        // What sensors read in the gutter is what lies across the seam.
        let gutters = setup.atlas.seams.iter();
        let filled = gutters.filter(|seam| state.trail[seam.texel as usize] > 0.0);
        assert!(filled.count() > 20, "{method:?}");
    }
    gpu.finish();
}

#[test]
fn a_dab_where_two_objects_touch_paints_both() {
    let Some(gpu) = gpu() else { return };
    let side = ("cube?divisions=4", [0.0; 3]);
    let scene = scene_of_several(&[side, side], |settings| {
        settings.particles.count = 1000;
        settings.atlas.size = 256;
        for object in &mut settings.objects {
            object.rotation = [0.0; 3];
        }
        settings.objects[1].position = [2.0, 0.0, 0.0];
        settings.objects[1].name = "second".to_owned();
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let positions = &simulation.setup().surface.positions;
    let corner = positions.iter().fold(0.0_f32, |far, p| far.max(p.x));
    // On the tops of both, which lie side by side; the sides that touch are turned away from the eye or hidden.
    let touching = Vec3::new(1.0, corner, 0.0);
    let brush = Dab {
        eye: Some(touching + Vec3::new(0.0, 10.0, 0.0)),
        ..dab(Brush::Trail { amount: 1.0 }, touching, 0.6)
    };
    let painted = paint(&gpu, &mut simulation, &brush);
    let [first, second] = painted.texels[..] else {
        panic!("two objects")
    };
    assert!(
        first > 50 && second.abs_diff(first) < first / 10,
        "{painted:?}"
    );
    let nothing = dab(Brush::Trail { amount: 1.0 }, Vec3::splat(50.0), 0.5);
    assert_eq!(paint(&gpu, &mut simulation, &nothing).count(), 0);
    gpu.finish();
}

/// Particles do not enter; those inside leave, and do not come back. Attraction gathers them, repulsion thins them out.
/// Catches brushes that reach objects on which they may change nothing.
#[test]
fn dabs_leave_spared_objects_as_they_are() {
    let Some(gpu) = gpu() else { return };
    for brush in BRUSHES.into_iter().chain([TELEPORT]) {
        let mut simulation = Simulation::new(&gpu.ctx, &trio(Strategy::Direct)).unwrap();
        let dab = dab(brush, Vec3::new(0.3, 0.5, 0.3), 0.9);
        let all = paint(&gpu, &mut simulation, &dab).texels;
        simulation.spare(&[false, true]);
        assert_eq!(
            paint(&gpu, &mut simulation, &dab).texels,
            [all[0], 0, all[2]]
        );
        simulation.spare(&[true; 3]);
        let before = simulation.snapshot().unwrap();
        assert_eq!(paint(&gpu, &mut simulation, &dab).count(), 0);
        assert_eq!(simulation.snapshot().unwrap().hash(), before.hash());
        simulation.spare(&[]);
        assert_eq!(paint(&gpu, &mut simulation, &dab).texels, all);
    }
    gpu.finish();
}

#[test]
fn painted_areas_steer_particles() {
    let Some(gpu) = gpu() else { return };
    let inside = |state: &Snapshot, setup: &Setup, center: Vec3, radius: f32| {
        let count = state.particles.iter().filter(|particle| {
            let [a, b, c] = setup.surface.corners[particle.triangle as usize]
                .map(|vertex| setup.surface.positions[vertex as usize]);
            let at = a + particle.u * (b - a) + particle.v * (c - a);
            at.distance(center) < radius
        });
        count.count()
    };
    let grown = |brush: Option<Brush>| {
        let scene = scene("builtin:icosphere?subdivisions=4", |settings| {
            settings.particles.count = 20_000;
            settings.atlas.size = 256;
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = simulation.setup().clone();
        let radius = 0.4 * setup.radius;
        let center = scene.center + Vec3::new(0.0, 0.0, setup.radius);
        if let Some(brush) = brush {
            paint(&gpu, &mut simulation, &dab(brush, center, radius));
        }
        steps(&gpu, &mut simulation, 250);
        let state = simulation.snapshot().unwrap();
        state.validate(&setup).unwrap();
        inside(&state, &setup, center, 0.9 * radius)
    };
    let free = grown(None);
    assert!(free > 300, "{free}");
    assert_eq!(grown(Some(Brush::NoGo)), 0);
    let attracted = grown(Some(Brush::Attract { amount: 3000.0 }));
    let repelled = grown(Some(Brush::Attract { amount: -3000.0 }));
    assert!(10 * attracted > 13 * free, "{attracted}, not {free}");
    assert!(10 * repelled < 7 * free, "{repelled}, not {free}");
    gpu.finish();
}

/// What was painted comes back with a snapshot, and a run that continues from it ends in the same hash. Without it, the hash is
/// that of a run that was never painted.
#[test]
fn what_was_painted_is_part_of_the_state() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(Strategy::Parallel);
    let new = || Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut simulation = new();
    let radius = simulation.setup().radius;
    let center = scene.center + 0.3 * radius * Vec3::X;
    steps(&gpu, &mut simulation, 3);
    paint(
        &gpu,
        &mut simulation,
        &dab(Brush::NoGo, center, 0.5 * radius),
    );
    let middle = simulation.snapshot().unwrap();
    assert!(middle.bias.contains(&NO_GO));
    steps(&gpu, &mut simulation, 4);
    let end = simulation.snapshot().unwrap();

    let mut resumed = new();
    resumed.restore(&middle).unwrap();
    // Settings that change on the way leave it where it is.
    resumed.apply(&simulation.settings().clone()).unwrap();
    steps(&gpu, &mut resumed, 4);
    assert_eq!(resumed.snapshot().unwrap().hash(), end.hash());

    let mut plain = new();
    steps(&gpu, &mut plain, 7);
    let plain_hash = plain.snapshot().unwrap().hash();
    assert_ne!(plain_hash, end.hash());
    resumed.restore(&new().snapshot().unwrap()).unwrap();
    steps(&gpu, &mut resumed, 7);
    assert_eq!(resumed.snapshot().unwrap().hash(), plain_hash);

    // A brush that is refused has done nothing.
    let bad = dab(
        Brush::Trail {
            amount: f32::INFINITY,
        },
        center,
        radius,
    );
    let mut error = None;
    gpu.run(|rec| error = plain.paint(rec, &bad).err());
    assert!(error.unwrap().to_string().contains("choose 0 to 1000000"));
    assert_eq!(plain.snapshot().unwrap().hash(), plain_hash);
    gpu.finish();
}

/// What a stroke has changed goes back to what it was, and comes again, to the last bit and over seams, whatever was painted
/// before it.
#[test]
fn strokes_go_back_and_come_again() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(Strategy::Parallel);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let radius = simulation.setup().radius;
    let at = |share: f32| scene.center + share * radius * Vec3::X;
    let mut strokes = Vec::new();
    let mut states = vec![simulation.snapshot().unwrap()];
    for (brush, share) in [
        (Brush::Attract { amount: 7.3 }, 0.3),
        (Brush::NoGo, 0.5),
        (Brush::Attract { amount: -0.1 }, 0.4),
        (Brush::Erase { share: 0.7 }, 0.45),
    ] {
        let mut before = None;
        gpu.run(|rec| before = Some(simulation.record_areas(rec).unwrap()));
        let before = before.unwrap();
        assert_eq!(before.is_empty(), strokes.is_empty());
        assert!(simulation.changes_areas(brush));
        let painted = paint(&gpu, &mut simulation, &dab(brush, at(share), 0.5 * radius));
        assert!(painted.span.len() >= painted.count() as usize && painted.count() > 100);
        let changed = simulation.repainted(&before, painted.span).unwrap();
        assert!(changed.len() > 100, "{brush:?}: {}", changed.len());
        strokes.push(changed);
        states.push(simulation.snapshot().unwrap());
    }
    for again in [false, true] {
        for i in 0..strokes.len() {
            let i = if again { i } else { strokes.len() - 1 - i };
            gpu.run(|rec| simulation.put_areas(rec, &strokes[i], again).unwrap());
            let state = simulation.snapshot().unwrap();
            let wanted = &states[i + usize::from(again)];
            let is_none = wanted.bias.is_empty() && state.bias.iter().all(|value| *value == 0.0);
            assert!(is_none || state.bias == wanted.bias, "{i}, {again}");
        }
    }
    // Nothing has changed where nothing was painted, and what was forgotten is as if it had never been.
    let mut now = None;
    gpu.run(|rec| now = Some(simulation.record_areas(rec).unwrap()));
    let texels = simulation.setup().atlas.density.len() as u32;
    assert_eq!(simulation.repainted(&now.unwrap(), 0..texels).unwrap(), []);
    simulation.forget_areas().unwrap();
    assert!(!simulation.changes_areas(Brush::Erase { share: 0.5 }));
    let mut plain = Simulation::new(&gpu.ctx, &scene).unwrap();
    for simulation in [&mut simulation, &mut plain] {
        steps(&gpu, simulation, 3);
    }
    let hashes = [simulation, plain].map(|s| s.snapshot().unwrap().hash());
    assert_eq!(hashes[0], hashes[1]);
    gpu.finish();
}

/// Would catch: texels of another scene, for which a kernel would write behind the end of the areas, and half a stroke that has been
/// recorded when the other half is refused.
#[test]
fn texels_that_the_atlas_lacks_are_refused_before_anything_is_recorded() {
    let Some(gpu) = gpu() else { return };
    let scene = scene("builtin:cube", |settings| {
        settings.particles.count = 100;
        settings.atlas.size = 64;
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let densities = &simulation.setup().atlas.density;
    let texels = densities.len() as u32;
    let owned = densities.iter().position(|density| *density > 0.0);
    let owned = owned.expect("a triangle owns one") as u32;
    let one = |field, texel| Repainted {
        field,
        texel,
        before: 0.0,
        after: 0.5,
    };
    let [last, beyond] = [texels - 1, texels].map(|texel| one(PaintedField::Looks, texel));
    let put = |simulation: &mut Simulation, other: Repainted| {
        let changed = [one(PaintedField::Bias, owned), other];
        let mut ended = None;
        gpu.run(|rec| {
            rec.list();
            let put = simulation.put_areas(rec, &changed, true);
            ended = Some((put.err().map(|e| e.to_string()), rec.listed().len()));
        });
        ended.unwrap()
    };
    let (refused, recorded) = put(&mut simulation, beyond);
    let refused = refused.expect("there is no such texel");
    assert!(
        refused.contains(&format!("there is no texel {texels}")),
        "{refused}"
    );
    assert_eq!(recorded, 0);
    assert!(simulation.areas().unwrap().is_empty());
    let (refused, recorded) = put(&mut simulation, last);
    assert_eq!(refused, None);
    assert!(recorded > 0);
    // As far as the texels go, they can be compared.
    let before = Areas::default();
    let found = simulation.repainted(&before, 0..texels).unwrap();
    assert!(found.contains(&one(PaintedField::Bias, owned)));
    let problem = simulation.repainted(&before, 0..texels + 1).unwrap_err();
    assert!(
        problem.to_string().contains("there is no texel"),
        "{problem}"
    );
    gpu.finish();
}
