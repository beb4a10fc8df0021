//! Food and markers: the kernels against their twins, how far sensors read them along the surface, eating and its effects,
//! and what is refused.

use crate::advance;
use std::sync::Arc;

use crate::common::{Gpu, TRIO, awkward_sizes, gpu, scene, scene_of_several};
use glam::{DAffine3, DVec2, DVec3, UVec2, Vec3};
use myxo::gpu::{Buffer, Context, DispatchGroups, Domain, Pipeline, Threads};
use myxo::mesh::atlas::Control;
use myxo::mesh::surface_distance::SurfaceDistance;
use myxo::mesh::walk::{BorderRule, walk};
use myxo::rng::{Purpose, random, unit};
use myxo::scene::Scene;
use myxo::scene::settings::{AtlasMethod, DistanceMethod, FoodSettings, Settings, Start, Strategy};
use myxo::sim::beside::first_difference;
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::field::{atlas_position, trail_at};
use myxo::sim::food::{FoodPlace, FoodSet, LEVELS, MOST_AMOUNT, nearest_on_object};
use myxo::sim::ground::Ground;
use myxo::sim::kernels::{
    Digest, DigestArgs, DigestParams, Project, ProjectArgs, ProjectConstants, ProjectParams, Scent,
    ScentArgs, ScentConstants, ScentParams,
};
use myxo::sim::step::scent_across::ScentAcrossInputs;
use myxo::sim::texel_paths::TexelPaths;
use myxo::sim::types::{Meal, Particle};
use myxo::sim::{Means, Plan, Setup, Simulation, Snapshot, Texture, twin};

fn buffer<T: bytemuck::Pod>(ctx: &Arc<Context>, name: &str, data: &[T]) -> Buffer<T> {
    let buffer = Buffer::new(ctx, name, data.len().max(1), Domain::Device).unwrap();
    if !data.is_empty() {
        ctx.upload(&buffer, data).unwrap();
    }
    buffer
}

/// Some whole, some half eaten, some gone, some without end; some are eaten more of than there is.
fn some_meals(count: u32) -> Vec<Meal> {
    let meal = |i: u32| {
        let words = random(11, i, 0, Purpose::Food);
        let amount = [0, 1, 63, 64, 1000, MOST_AMOUNT][words[0] as usize % 6];
        let remaining = match amount {
            0 => 1,
            _ => words[1] % (amount + 1),
        };
        let strength = 40.0 * unit(words[2]) - 20.0;
        let level = if amount == 0 {
            LEVELS
        } else {
            (LEVELS * remaining).div_ceil(amount)
        };
        Meal {
            remaining,
            eaten: [0, 1, words[3] % 700, MOST_AMOUNT][words[3] as usize % 4],
            amount,
            level,
            strength,
            scent: strength * (level as f32 / LEVELS as f32),
            projection: 10.0 * unit(words[3]),
            pad0: 0,
        }
    };
    (0..count).map(meal).collect()
}

#[test]
fn digest_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let pipeline = Pipeline::<Digest>::new(&gpu.ctx, &()).unwrap();
    let mut dues = 0;
    for count in awkward_sizes(64).into_iter().chain([2]) {
        // The second time nothing is eaten, and nothing changes.
        for is_hungry in [true, false] {
            let mut meals = some_meals(count);
            if !is_hungry {
                meals.iter_mut().for_each(|meal| meal.eaten = 0);
            }
            let params = DigestParams {
                food_count: count,
                scented_count: 70_000 * 64,
                scent_group: 64,
            };
            let on_device = buffer(&gpu.ctx, "meals", &meals);
            let groups: Buffer<DispatchGroups> = Buffer::zeroed(&gpu.ctx, "groups", 1).unwrap();
            gpu.run(|rec| {
                let args = DigestArgs {
                    meals: &on_device,
                    groups: &groups,
                };
                rec.dispatch(&pipeline, Threads(count), args, params);
            });
            let due = twin::digest(&params, &mut meals);
            let kernel: Vec<Meal> = gpu.ctx.download(&on_device).unwrap();
            assert_eq!(&kernel[..count as usize], &meals[..], "{count} foods");
            let groups = gpu.ctx.download(&groups).unwrap()[0];
            let expected = if due { (35_000, 2) } else { (0, 0) };
            assert_eq!((groups.x, groups.y), expected, "{count} foods");
            dues += u32::from(due);
            assert!(!due || is_hungry);
        }
    }
    assert!(dues > 3, "smells change");
    gpu.finish();
}

#[test]
fn scent_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    for count in awkward_sizes(64) {
        let texels = (2 * count as usize + 8).next_multiple_of(4);
        let meals = some_meals(9);
        // None, one or several at a texel.
        let mut falloffs = Vec::new();
        let mut scented = Vec::new();
        for i in 0..count {
            let words = random(3, i, 0, Purpose::Food);
            scented.push(UVec2::new(2 * i + words[0] % 2, falloffs.len() as u32));
            falloffs.extend((0..words[1] % 4).map(|k| {
                let words = random(5, i, k, Purpose::Food);
                UVec2::new(words[0] % 9, unit(words[1]).to_bits())
            }));
        }
        scented.push(UVec2::new(0, falloffs.len() as u32));
        let params = ScentParams {
            scented_count: count,
        };
        let start = vec![-3.5_f32; texels];
        let mut expected = start.clone();
        twin::scent(&params, &scented, &falloffs, &meals, &mut expected);
        for in_parts in [false, true]
            .into_iter()
            .take(1 + usize::from(texels > 128))
        {
            let constants = ScentConstants {
                paths: TexelPaths {
                    in_quads: in_parts,
                    band: if in_parts { 64 } else { u32::MAX },
                    outgrows_block: false,
                },
            };
            let field = buffer(&gpu.ctx, "field", &start);
            let field = Texture::by_paths(constants.paths, field).unwrap();
            let pipeline = Pipeline::<Scent>::new(&gpu.ctx, &constants).unwrap();
            gpu.run(|rec| {
                let args = ScentArgs {
                    scented: &buffer(&gpu.ctx, "scented", &scented),
                    falloffs: &buffer(&gpu.ctx, "falloffs", &falloffs),
                    meals: &buffer(&gpu.ctx, "meals", &meals),
                    field: &field,
                };
                rec.dispatch(&pipeline, Threads(count), args, params);
            });
            let summed: Vec<f32> = gpu.ctx.download(&field).unwrap();
            assert!(summed == expected, "{count} texels");
        }
    }
    gpu.finish();
}

/// Would catch: a kernel that adds another share of a projection than its twin, damps other texels, or writes beside its texels.
#[test]
fn project_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    const PITCH: u32 = 64;
    const A_ROW: u32 = 60;
    for count in awkward_sizes(64) {
        // Rows above and below, and columns on both sides, are read only.
        let texels = PITCH * (count / A_ROW + 3);
        let word = |i: u32, k: u32| random(17, i, k, Purpose::Food)[0];
        let meals = some_meals(9);
        let projected: Vec<UVec2> = (0..count)
            .map(|i| UVec2::new(PITCH * (1 + i / A_ROW) + 2 + i % A_ROW, word(i, 0) % 9))
            .collect();
        let start: Vec<f32> = (0..texels).map(|i| unit(word(i, 1))).collect();
        let deposits: Vec<u32> = (0..texels)
            .map(|i| u32::from(word(i, 2) % 9 == 0))
            .collect();
        for (covered, in_parts) in [(1.0, false), (0.25, false), (0.25, true)] {
            let params = ProjectParams {
                projected_count: count,
                pitch: PITCH,
                covered,
            };
            let mut expected = start.clone();
            twin::project(&params, &projected, &meals, &deposits, &mut expected);
            assert!(count < 2 || expected != start, "{count} texels");
            let paths = TexelPaths {
                in_quads: in_parts,
                band: if in_parts { 64 } else { u32::MAX },
                outgrows_block: false,
            };
            let trail = buffer(&gpu.ctx, "trail", &start);
            let trail = Texture::by_paths(paths, trail).unwrap();
            let counts = buffer(&gpu.ctx, "deposits", &deposits);
            let counts = Texture::by_paths(paths, counts).unwrap();
            let pipeline = Pipeline::<Project>::new(&gpu.ctx, &ProjectConstants { paths }).unwrap();
            gpu.run(|rec| {
                let args = ProjectArgs {
                    projected: &buffer(&gpu.ctx, "projected", &projected),
                    meals: &buffer(&gpu.ctx, "meals", &meals),
                    deposits: &counts,
                    trail: &trail,
                };
                rec.dispatch(&pipeline, Threads(count), args, params);
            });
            let kernel: Vec<f32> = gpu.ctx.download(&trail).unwrap();
            assert!(kernel == expected, "{count} texels, covered {covered}");
        }
    }
    gpu.finish();
}

/// Everything of a food_set with one place that kernels read: the smell of a food that is whole.
fn field_of(setup: &Setup, food_set: &FoodSet) -> Vec<f32> {
    let mut field = vec![0.0; setup.atlas.density.len()];
    let params = ScentParams {
        scented_count: food_set.scented_count(),
    };
    let meals = food_set.meals(None);
    twin::scent(
        &params,
        &food_set.scented,
        &food_set.falloffs,
        &meals,
        &mut field,
    );
    field
}

/// What sensors read is a distance along the surface, within 3 % of the exact one: at texels, and between texels at the
/// ends of straight walks over edges and seams. Every third texel is tested, with an offset from row to row.
#[test]
fn smells_are_distances_along_the_surface() {
    for mesh in [
        "cube?divisions=4",
        "torus?major=36&minor=24",
        "icosphere?subdivisions=3",
        "plane?columns=9&rows=6",
        "capsule",
        "gear?teeth=12",
        "suzanne",
        "gyroid",
        "trefoil",
    ] {
        for method in [AtlasMethod::Charts, AtlasMethod::Grid] {
            // Those with the most triangles, by charts only: a grid treats all triangles alike.
            if method == AtlasMethod::Grid && ["gyroid", "trefoil"].contains(&mesh) {
                continue;
            }
            let scene = scene(&format!("builtin:{mesh}"), |s| {
                s.particles.count = 10;
                // A grid needs more room for as many triangles.
                s.atlas.size = if method == AtlasMethod::Grid {
                    640
                } else {
                    320
                };
                s.atlas.method = method;
                s.feeding.scattered = 2;
                s.feeding.radius = 0.5;
            });
            let setup = Setup::new(&scene).unwrap_or_else(|error| panic!("{mesh}: {error}"));
            for &place in &setup.food_set.places {
                let what = format!("{mesh} by {method:?}");
                check_smell(&scene, &setup, place, &what);
            }
        }
    }
}

fn check_smell(scene: &Scene, setup: &Setup, place: FoodPlace, what: &str) {
    let (surface, atlas) = (&scene.surface, &setup.atlas);
    let place = FoodPlace {
        strength: 1.0,
        amount: 0,
        ..place
    };
    let food_set = FoodSet::new(surface, atlas, vec![place], None, &Control::default()).unwrap();
    let field = field_of(setup, &food_set);
    let exact = SurfaceDistance::new(surface, &[place.point], 1.01 * place.radius);
    let distance_of = |smell: f32| place.radius * (1.0 - f64::from(smell).sqrt());
    let mut reached = 0;
    for texel in (0..field.len() as u32).step_by(3) {
        let Some((triangle, u, v)) = atlas.surface_point_of(texel) else {
            continue;
        };
        let distance = exact.at(triangle, u.into(), v.into());
        let smell = field[texel as usize];
        if distance >= place.radius {
            assert_eq!(smell, 0.0, "{what}, texel {texel}");
            continue;
        }
        reached += 1;
        let off = (distance_of(smell) - distance).abs();
        // Floats hold a square within 1e-7 of its greatest value.
        let bound = 0.03 * distance + 1e-3 * place.radius;
        assert!(off <= bound, "{what}, texel {texel}: {off} of {distance}");
        let is_plate = food_set.plates[texel as usize] == 1;
        let slack = 1e-5 * place.radius;
        assert!(is_plate == (distance < place.size) || (distance - place.size).abs() < slack);
    }
    assert!(reached > 100, "{what}: only {reached} texels are reached");
    // As sensors read it: bilinear, in gutters, too.
    let texel_length = setup.atlas.mean_texel_area.sqrt();
    let (mut looked_at, mut wrong) = (0, 0);
    for i in 0..400 {
        let words = random(2, i, 0, Purpose::Food);
        let (sin, cos) = (std::f64::consts::TAU * f64::from(unit(words[0]))).sin_cos();
        let length = place.radius * 0.98 * f64::from(unit(words[1]));
        let heading = DVec2::new(cos, sin);
        let end = walk(
            surface,
            place.point,
            heading,
            length,
            None,
            BorderRule::Reflect,
        )
        .point;
        let distance = exact.at(end.triangle, end.u, end.v);
        assert!(
            distance <= length + 1e-5,
            "a walk is no shorter than the shortest"
        );
        if distance < 4.0 * texel_length {
            continue;
        }
        let map = &atlas.maps[end.triangle as usize];
        let position = atlas_position(map, end.u as f32, end.v as f32);
        let smell = trail_at(&field, position, atlas.pitch).clamp(0.0, 1.0);
        looked_at += 1;
        let off = (distance_of(smell) - distance).abs();
        wrong += u32::from(off > 0.03 * distance);
    }
    assert!(looked_at > 100, "{what}: {looked_at}");
    // Where shortest paths around an obstacle meet there is a crest, which is flatter between texels.
    assert!(
        wrong * 50 <= looked_at,
        "{what}: {wrong} of {looked_at} are off by more than 3 %"
    );
}

fn food(object: &str, at: [f32; 3], change: impl FnOnce(&mut FoodSettings)) -> FoodSettings {
    let mut food = FoodSettings {
        object: object.to_owned(),
        at: at.map(f64::from),
        radius: 0.6,
        strength: 12.0,
        amount: 0,
        size: 0.12,
        projection: 0.0,
    };
    change(&mut food);
    food
}

/// Three that touch, with food that ends, food that does not, and a marker that repels.
fn trio(strategy: Strategy) -> Scene {
    scene_of_several(&TRIO, |s| {
        s.particles.count = 3000;
        s.atlas.size = 256;
        s.physarum.speed = 0.02;
        s.transfer.strategy = strategy;
        s.feeding.fed_steps = 20;
        s.feeding.fed_deposit = 3;
        s.foods = vec![
            food("torus", [1.0, 0.3, 0.0], |f| f.amount = 400),
            food("cube", [0.0, 1.0, 0.0], |_| ()),
            food("icosphere", [0.0, 0.0, 1.0], |f| f.amount = 90),
            food("torus", [-1.0, 0.3, 0.0], |f| {
                f.strength = -6.0;
                f.size = 0.0;
            }),
        ];
    })
}

fn run(gpu: &Gpu, scene: &Scene, steps: u32) -> Snapshot {
    run_from(gpu, scene, Setup::new(scene).unwrap(), steps)
}

fn run_from(gpu: &Gpu, scene: &Scene, setup: Setup, steps: u32) -> Snapshot {
    let mut simulation = Simulation::from_setup(&gpu.ctx, scene, setup).unwrap();
    for _ in 0..steps / 5 {
        advance(gpu, &mut simulation, 5);
        let state = simulation.snapshot().unwrap();
        state.validate(simulation.setup()).unwrap();
    }
    simulation.snapshot().unwrap()
}

/// Whatever the order of particles in a step, the same particles are fed, as much food is left, and no particle is lost.
#[test]
fn food_is_eaten_alike_by_every_strategy_that_transfers() {
    let Some(gpu) = gpu() else { return };
    let strategies = [
        Strategy::Scattered,
        Strategy::Sequential,
        Strategy::Parallel,
        Strategy::Parallel,
    ];
    // Strategies differ in nothing that is set up.
    let setup = Setup::new(&trio(Strategy::None)).unwrap();
    let run = |strategy, steps| run_from(&gpu, &trio(strategy), setup.clone(), steps);
    let ends = strategies.map(|strategy| run(strategy, 60));
    for end in &ends {
        assert_eq!(end.hash(), ends[0].hash());
        assert_eq!(end.food, ends[0].food);
    }
    let left = &ends[0].food.remaining;
    assert!(left[0] < 400 && left[2] < 90, "{left:?}");
    assert_eq!(
        (left[1], left[3]),
        (1, 1),
        "of what never ends there is enough"
    );
    assert!(ends[0].motions.iter().any(|motion| motion.fed() > 0));
    for strategy in [Strategy::Direct, Strategy::Respawn, Strategy::None] {
        let end = run(strategy, 20);
        assert!(end.food.remaining[0] < 400);
    }
    gpu.finish();
}

/// Each meal feeds one particle, and the last one is the last.
#[test]
fn as_many_eat_as_there_are_meals() {
    let scene = scene("builtin:icosphere?subdivisions=2", |s| {
        s.particles.count = 2000;
        s.feeding.fed_steps = 60_000;
        s.foods = vec![
            food("", [1.0, 0.0, 0.0], |f| f.amount = 37),
            food("", [-1.0, 0.0, 0.0], |f| f.amount = 1_000_000),
        ];
    });
    let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings.clone());
    let mut before = twin.snapshot();
    for _ in 0..40 {
        twin.step();
        let now = twin.snapshot();
        now.validate(twin.setup()).unwrap();
        // Fed for longer than this takes, so no particle eats twice.
        let fed = |state: &Snapshot| state.motions.iter().filter(|m| m.fed() > 0).count() as u32;
        let [first, second] = [0, 1].map(|i| before.food.remaining[i] - now.food.remaining[i]);
        let more = fed(&now) - fed(&before);
        if now.food.remaining[0] > 0 {
            assert_eq!(more, first + second);
        } else {
            // More may come in the step of the last meal than it feeds.
            assert!(more >= first + second);
        }
        before = now;
    }
    assert_eq!(before.food.remaining[0], 0, "it is gone");
    assert!(before.food.remaining[1] > 900_000);
}

#[test]
fn resumed_food_is_what_was_left() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(Strategy::Parallel);
    let whole = run(&gpu, &scene, 60);
    let half = run(&gpu, &scene, 25);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.ckpt");
    let mut resumed = Simulation::new(&gpu.ctx, &scene).unwrap();
    let checkpoint = Checkpoint::new(&scene, resumed.setup(), half);
    checkpoint.write(&path).unwrap();
    let read = Checkpoint::read(&path).unwrap();
    assert_eq!(read, checkpoint);
    read.check(&scene, resumed.setup()).unwrap();
    resumed.restore(&read.snapshot).unwrap();
    advance(&gpu, &mut resumed, 35);
    let end = resumed.snapshot().unwrap();
    assert_eq!(end.food, whole.food);
    assert_eq!(end.hash(), whole.hash());
    // Without food there is nothing to continue with.
    let bare = scene_of_several(&TRIO, |s| {
        s.particles.count = 3000;
        s.atlas.size = 256;
    });
    let mut other = Simulation::new(&gpu.ctx, &bare).unwrap();
    let error = other.restore(&read.snapshot).unwrap_err().to_string();
    assert!(
        error.contains("4 foods") && error.contains("has 0"),
        "{error}"
    );
    gpu.finish();
}

/// Food that stays keeps its amount; food that is removed feeds no particle; the twins agree.
#[test]
fn food_comes_and_goes_while_it_runs() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(Strategy::Parallel);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    advance(&gpu, &mut simulation, 30);
    let before = simulation.snapshot().unwrap();
    let mut twin = twin::Simulation::new(simulation.setup().clone(), simulation.settings().clone());
    twin.restore(&before);
    let mut settings = simulation.settings().clone();
    settings.foods.remove(1);
    settings.foods[0].strength = 3.0;
    settings
        .foods
        .push(food("cube", [0.0, 0.0, 1.0], |f| f.amount = 77));
    simulation.apply(&settings).unwrap();
    twin.put_food(&settings).unwrap();
    let left = [before.food.remaining[0], before.food.remaining[2], 1, 77];
    assert_eq!(simulation.remaining().unwrap(), left);
    assert_eq!(twin.snapshot().food.remaining, left);
    assert_eq!(simulation.food_places().len(), 4);
    advance(&gpu, &mut simulation, 1);
    twin.step();
    let (kernel, by_twin) = (simulation.snapshot().unwrap(), twin.snapshot());
    kernel.validate(simulation.setup()).unwrap();
    let apart = kernel.food.remaining.iter().zip(&by_twin.food.remaining);
    assert!(apart.map(|(a, b)| a.abs_diff(*b)).sum::<u32>() <= 3);
    // All food is removed: no particle is fed any more, and all particles deposit alike.
    settings.foods.clear();
    simulation.apply(&settings).unwrap();
    advance(&gpu, &mut simulation, 1);
    let end = simulation.snapshot().unwrap();
    end.validate(simulation.setup()).unwrap();
    assert!(end.motions.iter().all(|motion| motion.fed() == 0));
    assert_eq!(end.deposits.iter().sum::<u32>(), 3000);
    // What cannot be leaves everything as it was.
    let mut wrong = settings.clone();
    wrong.foods = vec![food("moon", [0.0; 3], |_| ())];
    let error = simulation.apply(&wrong).unwrap_err().to_string();
    assert!(error.contains("no object \"moon\""), "{error}");
    assert_eq!(simulation.settings(), &settings);
    gpu.finish();
}

/// Hungry particles come to food, fed ones do not stay for it, and repelling markers keep all particles away.
#[test]
fn food_draws_and_markers_repel() {
    let near = |state: &Snapshot, setup: &Setup, at: Vec3, radius: f32| {
        let count = state.particles.iter().filter(|particle| {
            let [a, b, c] = setup.surface.corners[particle.triangle as usize]
                .map(|vertex| setup.surface.positions[vertex as usize]);
            let place = a + particle.u * (b - a) + particle.v * (c - a);
            place.distance(at) < radius
        });
        count.count() as f32
    };
    let grown = |foods: Vec<FoodSettings>, attraction: f32| {
        let scene = scene("builtin:icosphere?subdivisions=3", |s| {
            s.particles.count = 4000;
            s.atlas.size = 512;
            s.physarum.speed = 0.01;
            s.physarum.deposit = 0.05;
            s.feeding.fed_steps = 30;
            s.feeding.fed_attraction = attraction;
            s.foods = foods;
        });
        let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings);
        for _ in 0..100 {
            twin.step();
        }
        [0.3, 0.1].map(|radius| near(&twin.snapshot(), twin.setup(), Vec3::X, radius))
    };
    let at = |strength: f32, size: f32| {
        vec![food("", [1.0, 0.0, 0.0], |f| {
            f.strength = strength;
            f.size = size;
            f.radius = 1.0;
        })]
    };
    let [nothing, _] = grown(Vec::new(), 0.0);
    let [marker, close] = grown(at(40.0, 0.0), 0.0);
    let [repelled, _] = grown(at(-40.0, 0.0), 0.0);
    let [food, beside] = grown(at(40.0, 0.05), 0.0);
    let [_, greedy] = grown(at(40.0, 0.05), 1.0);
    assert!(marker > 4.0 * nothing, "{marker} beside {nothing}");
    assert!(repelled < 0.5 * nothing, "{repelled} beside {nothing}");
    assert!(food > 4.0 * nothing, "{food} beside {nothing}");
    // Fed particles walk on until they are hungry again, unless their appetite is set to draw them still.
    assert!(beside < 0.7 * close, "{beside} beside {close}");
    assert!(greedy > beside, "{greedy} beside {beside}");
}

#[test]
fn particles_begin_on_food() {
    let scene = scene_of_several(&TRIO, |s| {
        s.particles.count = 3000;
        s.atlas.size = 256;
        s.particles.start = Start::Food;
        s.particles.start_food = 1;
        s.foods = vec![
            food("torus", [1.0, 0.3, 0.0], |_| ()),
            food("cube", [0.0, 0.9, 0.2], |f| f.size = 0.1),
        ];
    });
    let setup = Setup::new(&scene).unwrap();
    let place = setup.food_set.places[1];
    let distance = SurfaceDistance::new(&setup.surface, &[place.point], f64::INFINITY);
    let mut far = 0.0_f64;
    for particle in &setup.particles {
        let found = distance.at(particle.triangle, particle.u.into(), particle.v.into());
        assert!(found <= place.size + 1e-4, "{found}");
        far = far.max(found);
    }
    assert!(far > 0.9 * place.size, "all over it");
}

/// Scattered food is far apart, and more of it leaves what is there where it is.
#[test]
fn scattered_food_is_far_apart_and_stays() {
    let places = |count: u32| {
        let scene = scene("builtin:torus?major=36&minor=24", |s| {
            s.particles.count = 10;
            s.feeding.scattered = count;
        });
        let setup = Setup::new(&scene).unwrap();
        let all = setup.food_set.places.clone();
        (setup, all)
    };
    let (_, few) = places(5);
    let (setup, many) = places(12);
    assert_eq!(few[..], many[..5]);
    let at = |place: &FoodPlace| {
        let [a, b, c] = setup.surface.corners[place.point.triangle as usize]
            .map(|vertex| setup.surface.positions[vertex as usize].as_dvec3());
        a + place.point.u * (b - a) + place.point.v * (c - a)
    };
    for (i, place) in many.iter().enumerate() {
        for other in &many[..i] {
            let apart = at(place).distance(at(other));
            assert!(apart > 0.35 * f64::from(setup.radius), "{apart}");
        }
    }
}

/// Would catch: food that is projected elsewhere than where it is eaten, with another factor, after the trail has spread or more than once
/// in a step of several passes, or in one engine only; and a mass that does not grow by the projection and shrink by the decay.
#[test]
fn food_is_projected_into_the_trail() {
    let Some(gpu) = gpu() else { return };
    for diffusion in [0.0, 0.5, 1.0] {
        let scene = scene("builtin:torus?major=36&minor=24", |s| {
            s.particles.count = 1;
            s.physarum.deposit = 0.0;
            s.trail.diffusion = diffusion;
            s.trail.decay = 0.9;
            s.foods = vec![
                food("", [1.0, 0.3, 0.0], |f| f.projection = 5.0),
                food("", [-1.0, 0.3, 0.0], |_| ()),
            ];
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = simulation.setup().clone();
        let mut by_twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
        let atlas = &setup.atlas;
        let owned: Vec<usize> = (0..atlas.density.len())
            .filter(|&texel| atlas.density[texel] > 0.0)
            .collect();
        let on_food = |texel: usize| setup.food_set.plates[texel] == 1;
        let plate: Vec<usize> = owned.iter().copied().filter(|&t| on_food(t)).collect();
        assert!(plate.len() > 30, "{} texels", plate.len());
        let area = |texel: usize| f64::from(atlas.area[texel]);
        let area_of_plate: f64 = plate.iter().map(|&texel| area(texel)).sum();
        let (mut value, mut mass) = (0.0_f32, 0.0_f64);
        for step in 1..=5 {
            advance(&gpu, &mut simulation, 1);
            by_twin.step();
            let trail = simulation.snapshot().unwrap().trail;
            assert!(trail == by_twin.snapshot().trail, "step {step}");
            value = (value + 5.0) * 0.9;
            mass = (mass + 5.0 * area_of_plate) * 0.9;
            if diffusion == 0.0 {
                for &texel in &owned {
                    let expected = if on_food(texel) { value } else { 0.0 };
                    assert_eq!(trail[texel], expected, "texel {texel}, step {step}");
                }
            }
            let parts = owned.iter().map(|&t| f64::from(trail[t]) * area(t));
            let found: f64 = parts.sum();
            // Diffusion keeps the mass but for rounding.
            let most = if diffusion == 0.0 { 1e-5 } else { 1e-4 };
            assert!(
                (found / mass - 1.0).abs() < most,
                "diffusion {diffusion}, step {step}: {found}, not {mass}"
            );
        }
    }
    gpu.finish();
}

/// Would catch: a projection that does not fall with what is left of the food, or goes on when none is left.
#[test]
fn eaten_food_is_projected_no_more() {
    const AMOUNT: u32 = 60;
    let scene = scene("builtin:icosphere?subdivisions=2", |s| {
        s.particles.count = 2000;
        s.physarum.speed = 0.02;
        s.physarum.deposit = 0.0;
        s.trail.diffusion = 0.0;
        s.trail.decay = 0.5;
        s.foods = vec![food("", [1.0, 0.0, 0.0], |f| {
            f.amount = AMOUNT;
            f.projection = 8.0;
        })];
    });
    let setup = Setup::new(&scene).unwrap();
    let texel = setup.food_set.projected[0].x as usize;
    let mut twin = twin::Simulation::new(setup, scene.settings);
    let (mut value, mut levels, mut steps_without) = (0.0_f32, Vec::new(), 0);
    for _ in 0..300 {
        twin.step();
        let state = twin.snapshot();
        let level = (LEVELS * state.food.remaining[0]).div_ceil(AMOUNT);
        value = (value + 8.0 * (level as f32 / LEVELS as f32)) * 0.5;
        assert_eq!(state.trail[texel], value, "level {level}");
        levels.push(level);
        steps_without += u32::from(level == 0);
        if steps_without == 20 {
            break;
        }
    }
    levels.dedup();
    assert!(levels.len() > 3, "{levels:?}");
    assert_eq!(steps_without, 20, "it is eaten up: {levels:?}");
    assert!(value < 1e-4, "{value}");
}

/// Would catch: damping everywhere or nowhere, by particles farther away than the next texel, or by none but those on the texel itself.
#[test]
fn covered_food_is_projected_less() {
    let scene = scene("builtin:icosphere?subdivisions=2", |s| {
        s.particles.count = 3000;
        s.physarum.speed = 0.0;
        s.physarum.deposit = 0.0;
        s.trail.diffusion = 0.0;
        s.trail.decay = 1.0;
        s.feeding.projection_covered = 0.25;
        s.foods = vec![food("", [1.0, 0.0, 0.0], |f| {
            f.size = 0.4;
            f.projection = 4.0;
        })];
    });
    let setup = Setup::new(&scene).unwrap();
    let mut twin = twin::Simulation::new(setup.clone(), scene.settings);
    twin.step();
    let state = twin.snapshot();
    let pitch = setup.atlas.pitch;
    let mut counts = [0, 0];
    for entry in &setup.food_set.projected {
        let corner = entry.x - pitch - 1;
        let mut around = (0..3).flat_map(|row| (0..3).map(move |column| (row, column)));
        let is_covered = around
            .any(|(row, column)| state.deposits[(corner + row * pitch + column) as usize] > 0);
        let expected = if is_covered { 1.0 } else { 4.0 };
        assert_eq!(state.trail[entry.x as usize], expected);
        counts[usize::from(is_covered)] += 1;
    }
    assert!(counts[0] > 100 && counts[1] > 100, "{counts:?}");
}

/// Would catch: a projection that sensors do not read as trail. The food has no scent, and the control differs by the projection alone.
#[test]
fn particles_gather_at_projected_food() {
    let near = |projection: f32| {
        let scene = scene("builtin:icosphere?subdivisions=3", |s| {
            s.particles.count = 4000;
            s.atlas.size = 512;
            s.physarum.speed = 0.01;
            s.physarum.deposit = 0.05;
            s.trail.diffusion = 1.0;
            s.trail.decay = 0.98;
            s.feeding.fed_deposit = 1;
            s.foods = vec![food("", [1.0, 0.0, 0.0], |f| {
                f.strength = 0.0;
                f.projection = projection;
            })];
        });
        let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings);
        for _ in 0..150 {
            twin.step();
        }
        let setup = twin.setup();
        let place = |particle: &Particle| {
            let [a, b, c] = setup.surface.corners[particle.triangle as usize]
                .map(|vertex| setup.surface.positions[vertex as usize]);
            a + particle.u * (b - a) + particle.v * (c - a)
        };
        let state = twin.snapshot();
        let particles = state.particles.iter();
        particles
            .filter(|particle| place(particle).distance(Vec3::X) < 0.3)
            .count()
    };
    let [gathered, control] = [20.0, 0.0].map(near);
    assert!(
        gathered > 2 * control && gathered > 100,
        "{gathered} beside {control}"
    );
}

/// A ball with all particles, and a ball with a marker to the right of it, which lies beside the place where they touch if there is no gap.
fn two_balls(gap: f64, across: f32, change: impl FnOnce(&mut Settings)) -> Scene {
    let ball = ("icosphere?subdivisions=3", [0.0; 3]);
    scene_of_several(&[ball, ball], |s| {
        for (object, name) in s.objects.iter_mut().zip(["left", "right"]) {
            object.name = name.to_owned();
            object.rotation = [0.0; 3];
        }
        s.objects[1].position = [2.0 + gap, 0.0, 0.0];
        s.radius = 1.0;
        s.particles.count = 2000;
        s.particles.start_object = "left".to_owned();
        s.atlas.size = 256;
        s.distance.reach = 0.5;
        s.feeding.scent_across = across;
        s.foods = vec![food("right", [-0.9, 0.4, 0.0], |f| {
            f.radius = 1.0;
            f.strength = 40.0;
            f.size = 0.0;
        })];
        change(s);
    })
}

/// The trio with a scent that crosses, and food that is eaten on two of its objects and more.
fn crossing_trio(method: DistanceMethod) -> Scene {
    let mut scene = trio(Strategy::Parallel);
    let settings = &mut scene.settings;
    settings.particles.count = 500;
    settings.atlas.size = 128;
    settings.feeding.scent_across = 0.5;
    settings.distance.method = method;
    scene
}

/// What crosses must be the same bits as by the twin from the device's own distances.
fn assert_crosses_by_its_distances(gpu: &Gpu, scene: &Scene) {
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    advance(gpu, &mut simulation, 1);
    let (setup, state) = (simulation.setup(), simulation.state());
    let food = state.food();
    let [scent, found] =
        [&food.scent, food.around()].map(|field| gpu.ctx.download::<f32>(field).unwrap());
    let distances: Vec<f32> = gpu.ctx.download(&state.near.distances).unwrap();
    let nearest: Vec<u32> = gpu.ctx.download(&state.near.nearest).unwrap();
    let inputs = ScentAcrossInputs {
        samples: &setup.distance.samples,
        owners: &setup.distance.owners,
        distances: &distances,
        nearest: &nearest,
        ground: Ground::of(setup, &setup.poses),
        atlas_maps: &setup.atlas.maps,
        scent: &scent,
    };
    let plan = Plan::new(&scene.settings, setup, 0, Means::of_host(false, 1));
    let mut expected = vec![0.0; scent.len()];
    twin::scent_across(&plan.scent_across().params, &inputs, &mut expected);
    let mut crossed = 0;
    for sample in &setup.distance.samples {
        let texel = sample.texel as usize;
        assert_eq!(found[texel].to_bits(), expected[texel].to_bits(), "{texel}");
        crossed += u32::from(found[texel] != scent[texel]);
    }
    assert!(crossed > 0, "none crosses");
}

/// Would catch: scent of another place of the other object, in the wrong pose, from beyond the reach or with another share; what crosses
/// coming back to its own object; engines that differ, also in gutters, by any method of distances; and a run that
/// differs when it is resumed, or when the key has been 0 and is not any more.
#[test]
fn scents_cross_contacts() {
    let Some(gpu) = gpu() else { return };
    const SHARE: f32 = 0.5;
    let scene = two_balls(-0.05, SHARE, |s| {
        s.time.dt = 0.02;
        s.objects[1].motion.spin = [40.0, 0.0, 90.0];
    });
    let reach = f64::from(scene.settings.distance.reach);
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let setup = simulation.setup().clone();
    let mut by_twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
    advance(&gpu, &mut simulation, 1);
    by_twin.step();

    // The first step has the first poses.
    let arrays = by_twin.arrays();
    let place = setup.food_set.places[0];
    let on_right = SurfaceDistance::new(&setup.surface, &[place.point], 1.01 * place.radius);
    let [left, right] = [0, 1].map(|object: usize| DAffine3::from(&setup.poses[object]));
    let right_from_left = right.inverse() * left;
    let samples_of = |object: usize| {
        let (first, end) = setup.distance.ranges[object];
        setup.distance.samples[first as usize..end as usize].iter()
    };
    let (mut crossed, mut beyond) = (0, 0);
    for sample in samples_of(0).step_by(23) {
        let at = right_from_left.transform_point3(sample.position.as_dvec3());
        let (point, nearest) = nearest_on_object(&setup.surface, at.as_vec3(), 1);
        let away = nearest.distance(at) / reach;
        let found = arrays.around[sample.texel as usize];
        if away > 1.001 {
            assert_eq!(found, 0.0, "{at}");
            beyond += 1;
            continue;
        }
        let near = (1.0 - away).max(0.0);
        let smelled = f64::from(place.strength)
            * place.falloff(on_right.at(point.triangle, point.u, point.v));
        let expected = f64::from(SHARE) * near * near * smelled;
        let off = (f64::from(found) - expected).abs();
        assert!(off < 0.6, "{at}: {found}, not {expected}");
        crossed += u32::from(expected > 1.0);
    }
    assert!(crossed > 20 && beyond > 100, "{crossed}, {beyond}");
    for sample in samples_of(1) {
        let texel = sample.texel as usize;
        assert_eq!(arrays.around[texel], arrays.scent[texel], "its own alone");
    }

    for _ in 0..5 {
        advance(&gpu, &mut simulation, 1);
        by_twin.step();
    }
    let around = simulation.state().food().around();
    let around: Vec<f32> = gpu.ctx.download(around).unwrap();
    assert!(around == by_twin.arrays().around, "engines agree");
    let half = simulation.snapshot().unwrap();
    assert_eq!(half.hash(), by_twin.snapshot().hash());

    let mut resumed = Simulation::from_setup(&gpu.ctx, &scene, setup).unwrap();
    resumed.restore(&half).unwrap();
    let mut settings = simulation.settings().clone();
    for across in [0.0, SHARE] {
        settings.feeding.scent_across = across;
        simulation.apply(&settings).unwrap();
        let crosses = simulation.state().food().around.is_some();
        assert_eq!(crosses, across > 0.0);
    }
    let [whole, resumed] = [&mut simulation, &mut resumed].map(|simulation| {
        advance(&gpu, simulation, 4);
        simulation.snapshot().unwrap().hash()
    });
    assert_eq!(whole, resumed);

    for method in [DistanceMethod::Bvh, DistanceMethod::Brute] {
        let scene = crossing_trio(method);
        let setup = Setup::new(&scene).unwrap();
        let found = first_difference(&gpu.ctx, &scene, &setup, 2, 2, &[]).unwrap();
        assert!(found.is_none(), "{method:?}: {}", found.unwrap());
    }
    // Drawn distances need not be those of the twin.
    let drawn = crossing_trio(DistanceMethod::Raster);
    assert_crosses_by_its_distances(&gpu, &drawn);

    gpu.finish();
}

/// Executes a step. Did it sum up the scents that cross contacts?
fn step_crosses(twin: &mut twin::Simulation) -> bool {
    let step = twin.next_step();
    let mut crosses = false;
    for work in step.works() {
        crosses |= work.kernels().contains(&"scent_across");
        twin.run_work(work.as_ref());
    }
    crosses
}

/// Would catch: scents that cross contacts and are summed up in each step although nothing has changed, and scents that stay where
/// something has: a pose, distances, the food, or the whole state.
#[test]
fn crossing_scents_are_summed_up_again_where_something_has_changed() {
    let scene = two_balls(-0.05, 0.5, |_| ());
    let setup = Setup::new(&scene).unwrap();
    let mut twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
    let check = |twin: &mut twin::Simulation, expected: &[bool]| {
        for (step, &crosses) in expected.iter().enumerate() {
            assert_eq!(step_crosses(twin), crosses, "step {step} of {expected:?}");
            let (arrays, setup) = (twin.arrays(), twin.setup());
            let inputs = ScentAcrossInputs {
                samples: &setup.distance.samples,
                owners: &setup.distance.owners,
                distances: &arrays.distances,
                nearest: &arrays.nearest,
                ground: Ground::of(setup, &arrays.poses),
                atlas_maps: &setup.atlas.maps,
                scent: &arrays.scent,
            };
            let plan = Plan::new(twin.settings(), setup, 0, Means::of_host(false, 1));
            let mut around = vec![0.0; arrays.scent.len()];
            twin::scent_across(&plan.scent_across().params, &inputs, &mut around);
            let mut texels = (setup.distance.samples.iter()).map(|s| s.texel as usize);
            assert!(
                texels.all(|texel| around[texel] == arrays.around[texel]),
                "step {step} of {expected:?}"
            );
        }
    };
    let once = [true, false, false];
    check(&mut twin, &once);
    let before = twin.snapshot();
    let aside = DAffine3::from_translation(DVec3::new(1.95, 0.1, 0.0));
    twin.set_pose(1, Some(aside)).unwrap();
    check(&mut twin, &once);
    let mut settings = twin.settings().clone();
    settings.foods[0].strength = 20.0;
    settings.feeding.scent_across = 0.25;
    twin.put_food(&settings).unwrap();
    check(&mut twin, &once);
    twin.restore(&before);
    check(&mut twin, &once);

    // What is eaten, or moves, is seen in each step.
    let changes: [fn(&mut Settings); 2] = [
        |s| (s.foods[0].size, s.foods[0].amount) = (0.3, 1000),
        |s| (s.time.dt, s.objects[1].motion.spin) = (0.02, [40.0, 0.0, 90.0]),
    ];
    for change in changes {
        let other = two_balls(-0.05, 0.5, change);
        let mut twin = twin::Simulation::new(Setup::new(&other).unwrap(), other.settings);
        assert!((0..5).all(|_| step_crosses(&mut twin)));
    }

    let Some(gpu) = gpu() else { return };
    let found = first_difference(&gpu.ctx, &scene, &setup, 3, 2, &[]).unwrap();
    assert!(found.is_none(), "{}", found.unwrap());
    gpu.finish();
}

/// Would catch: sensors that read the scent of their own object's food only, scents that cross a gap beyond the reach, or cross with the
/// key at 0. No particle changes objects, and sensors do not see across, so nothing else draws them.
#[test]
fn particles_sense_food_on_an_object_that_touches() {
    let run = |gap: f64, across: f32| {
        let scene = two_balls(gap, across, |s| {
            s.transfer.strategy = Strategy::None;
            s.physarum.speed = 0.01;
            s.physarum.deposit = 0.05;
        });
        let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings);
        for _ in 0..100 {
            twin.step();
        }
        let setup = twin.setup();
        let state = twin.snapshot();
        let beside = |particle: &&Particle| {
            let [a, b, c] = setup.surface.corners[particle.triangle as usize]
                .map(|vertex| setup.surface.positions[vertex as usize]);
            let place = a + particle.u * (b - a) + particle.v * (c - a);
            place.distance(Vec3::new(0.93, 0.37, 0.0)) < 0.3
        };
        let count = state.particles.iter().filter(beside).count();
        (count, state.hash())
    };
    let [touching, off] = [1.0, 0.0].map(|across| run(-0.05, across));
    let [apart, apart_off] = [1.0, 0.0].map(|across| run(0.6, across));
    assert!(
        touching.0 > 2 * off.0 && touching.0 > 100,
        "{} beside {}",
        touching.0,
        off.0
    );
    assert_eq!(apart, apart_off, "beyond the reach nothing crosses");
    assert_eq!(off.0, apart.0, "without the key, contacts do not matter");
}
