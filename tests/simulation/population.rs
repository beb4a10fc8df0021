//! Populations that grow and shrink: who divides and who dies, ids, room, and the same bits on both engines.

use std::collections::HashSet;

use crate::advance;
use crate::common::{
    Gpu, TRIO, by_id, gpu, gpu_by_card_forms, scene as scene_of_mesh, scene_of_several, set_up,
};
use myxo::mesh::atlas::Atlas;
use myxo::mesh::surface::NONE;
use myxo::scene::Scene;
use myxo::scene::settings::{
    FoodSettings, Model, PulseSettings, Sensing, Settings, StepOrder, Strategy,
};
use myxo::sim::beside::first_difference;
use myxo::sim::carry::carried;
use myxo::sim::cells::{birthplace, cell_of, check_room, homes, sharing_count};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::paint::{Brush, Dab};
use myxo::sim::types::{Motion, Particle, Population};
use myxo::sim::{Census, Setup, Simulation, Snapshot, twin};

const TORUS: &str = "builtin:torus?major=24&minor=16";

/// A scene whose population has room for more than it begins with.
fn scene(change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_mesh(TORUS, |settings| {
        settings.physarum.model = Model::Jones;
        settings.physarum.rotation_angle = 45.0;
        settings.physarum.sensor_angle = 45.0;
        settings.physarum.deposit = 5.0;
        settings.physarum.speed = 0.02;
        settings.physarum.sensor_offset = 0.15;
        settings.trail.diffusion = 1.0;
        settings.trail.decay = 0.9;
        settings.particles.count = 1000;
        settings.atlas.size = 128;
        settings.population.frequency = 2;
        settings.population.division_most = 40;
        settings.population.capacity = 4000;
        change(settings);
    })
}

fn twin_of(scene: &Scene) -> twin::Simulation {
    twin::Simulation::new(Setup::new(scene).unwrap(), scene.settings.clone())
}

/// The particles that are alive.
fn living(state: &Snapshot) -> Vec<Particle> {
    let both = state.particles.iter().zip(&state.motions);
    let living = both.filter(|(_, motion)| !motion.is_dead());
    living.map(|(particle, _)| *particle).collect()
}

fn counts(state: &Snapshot) -> Population {
    state.population[0]
}

/// Steps, and compares the change of the population with what is counted of births and deaths.
fn watched_step(twin: &mut twin::Simulation) -> Snapshot {
    let (before, step) = (counts(&twin.snapshot()), twin.snapshot().step);
    twin.step();
    let state = twin.snapshot();
    let after = counts(&state);
    assert_eq!(u64::from(after.living), state.living_count(), "step {step}");
    let births = after.births - before.births;
    let deaths = after.deaths - before.deaths;
    assert_eq!(
        i64::from(after.living) - i64::from(before.living),
        i64::from(births) - i64::from(deaths),
        "step {step}"
    );
    if twin.settings().population.is_due(step) {
        assert_eq!((births, deaths), (after.born, after.died), "step {step}");
    } else {
        assert_eq!((births, deaths), (0, 0), "step {step}");
    }
    state
}

/// Would catch: a particle that is lost or doubled, an id that two living ones have, a birth in a step without any, one in a cell that is
/// taken, and a dead particle that leaves a deposit.
#[test]
fn births_minus_deaths_is_the_change_from_a_hundred_to_thousands_and_back() {
    let change = |settings: &mut Settings| {
        settings.particles.count = 100;
        settings.population.capacity = 20_000;
    };
    let mut twin = twin_of(&scene(change));
    let cells = homes(&twin.setup().atlas);
    for _ in 0..120 {
        let state = watched_step(&mut twin);
        let shared = sharing_count(&living(&state), &twin.setup().atlas, &cells);
        assert_eq!(shared, 0, "step {}", state.step);
        if state.step.is_multiple_of(10) {
            state.validate(twin.setup()).unwrap();
            assert_eq!(state.census(), Census::default());
        }
    }
    let grown = twin.snapshot();
    let most = counts(&grown);
    assert!(most.living > 1500 && most.refused == 0, "{most:?}");
    // Now it is too crowded everywhere.
    let mut twin = twin_of(&scene(|settings| {
        change(settings);
        settings.population.survival_most = 0;
        settings.population.death_probability = 0.3;
        settings.population.division_probability = 0.0;
    }));
    twin.restore(&grown);
    while counts(&twin.snapshot()).living > 100 {
        let state = watched_step(&mut twin);
        let now = counts(&state);
        assert!(state.step < 200, "they die: {now:?}");
        if now.died > 0 && now.living > 1000 {
            // A share of 0.3, within five deviations.
            let all = f64::from(now.living + now.died);
            let off = (f64::from(now.died) - 0.3 * all).abs();
            assert!(off < 5.0 * (0.21 * all).sqrt(), "{now:?}");
        }
    }
    twin.snapshot().validate(twin.setup()).unwrap();
}

/// The rule as the papers say it, cell by cell: counts of particles in windows over the texture, whose gutters stand for the cells across
/// seams.
struct Plain<'a> {
    atlas: &'a Atlas,
    homes: Vec<u32>,
    counts: Vec<u32>,
}

impl<'a> Plain<'a> {
    fn of(particles: &[Particle], atlas: &'a Atlas) -> Self {
        let homes = homes(atlas);
        let mut counts = vec![0; homes.len()];
        for particle in particles {
            counts[cell_of(particle, atlas, &homes) as usize] += 1;
        }
        Self {
            atlas,
            homes,
            counts,
        }
    }

    /// The cells of a window, with that in its middle.
    fn window(&self, cell: u32, side: i64) -> Vec<u32> {
        let reach = side / 2;
        let pitch = i64::from(self.atlas.pitch);
        let mut cells = Vec::new();
        for row in -reach..=reach {
            for column in -reach..=reach {
                let texel = i64::from(cell) + row * pitch + column;
                cells.push(self.homes[texel as usize]);
            }
        }
        cells
    }

    fn count(&self, cell: u32, side: i64) -> u32 {
        let cells = self.window(cell, side).into_iter();
        cells.map(|cell| self.counts[cell as usize]).sum()
    }

    /// Does no window round it leave its chart?
    fn is_inside(&self, cell: u32) -> bool {
        let pitch = self.atlas.pitch;
        let reach = -4_i64..=4;
        reach.clone().all(|row| {
            reach.clone().all(|column| {
                let texel = i64::from(cell) + row * i64::from(pitch) + column;
                self.atlas.owner[texel as usize] != NONE
            })
        })
    }
}

/// Would catch: a bound that is one off, a window of another size, the particle itself left out of its window, a birth in a taken cell or
/// farther away, and two births in one cell.
#[test]
fn who_divides_and_who_dies_follows_from_the_windows() {
    // They stand, so that everything else is as it was.
    let mut scene = scene(|settings| {
        settings.physarum.model = Model::Thesis;
        settings.physarum.speed = 0.0;
        settings.particles.count = 1500;
        settings.atlas.size = 192;
    });
    let setup = Setup::new(&scene).unwrap();
    let (start, atlas) = (&setup.particles[..1500], &setup.atlas);
    let homes = homes(atlas);
    let cell = |particle: &Particle| cell_of(particle, atlas, &homes);
    let at_start = Plain::of(start, atlas);
    let most_of = |share: f64, side: i64| {
        let counts = start.iter().map(|p| at_start.count(cell(p), side));
        let mut counts: Vec<u32> = counts.collect();
        counts.sort_unstable();
        counts[(share * 1500.0) as usize]
    };
    let (sparse, crowded) = (most_of(0.2, 9), most_of(0.7, 5));
    let population = &mut scene.settings.population;
    (population.division_least, population.division_most) = (3, sparse);
    (population.survival_least, population.survival_most) = (2, crowded);
    let mut twin = twin_of(&scene);
    twin.step();
    twin.step();
    let before = twin.snapshot();
    twin.step();
    let after = twin.snapshot();

    let old = living(&before);
    let plain = Plain::of(&old, atlas);
    let survives = |p: &Particle| (2..=crowded).contains(&plain.count(cell(p), 5));
    let expected: HashSet<u32> = old.iter().filter(|p| survives(p)).map(|p| p.id).collect();
    // Others with ids of old ones are elsewhere: where there was no particle.
    let cells: HashSet<(u32, u32)> = old.iter().map(|p| (p.id, cell(p))).collect();
    let kept = |p: &&Particle| cells.contains(&(p.id, cell(p)));
    let new = living(&after);
    let found: HashSet<u32> = new.iter().filter(kept).map(|p| p.id).collect();
    assert_eq!(found, expected);
    let died = old.len() - expected.len();
    assert!(died > 50 && expected.len() > 500, "{died} of {}", old.len());
    assert_eq!(counts(&after).died as usize, died);

    let born: Vec<&Particle> = new.iter().filter(|p| !kept(p)).collect();
    assert_eq!(born.len(), counts(&after).born as usize);
    assert!(born.len() > 20, "{}", born.len());
    let nest: Vec<u32> = born.iter().map(|p| cell(p)).collect();
    let distinct: HashSet<u32> = nest.iter().copied().collect();
    assert_eq!(distinct.len(), nest.len(), "one birth a cell");
    let divides = |p: &Particle| {
        survives(p) && (3..=sparse).contains(&plain.count(cell(p), 9)) && {
            let mut beside = plain.window(cell(p), 3).into_iter();
            beside
                .any(|cell| plain.counts[cell as usize] == 0 && setup.nests[cell as usize] != NONE)
        }
    };
    let parents: Vec<u32> = (old.iter().filter(|p| divides(p))).map(cell).collect();
    let beside_parents: HashSet<u32> = (parents.iter())
        .flat_map(|&parent| plain.window(parent, 3))
        .collect();
    for &cell in &nest {
        assert_eq!(plain.counts[cell as usize], 0, "it was free");
        assert!(beside_parents.contains(&cell), "beside one that divides");
    }
    // Claims of those that are alone cannot be lost: each has one birth beside it, unless another one divides nearby.
    let alone = |&&parent: &&u32| {
        let near = parents.iter().filter(|&&other| {
            let window = plain.window(parent, 7);
            window.contains(&other)
        });
        plain.is_inside(parent) && near.count() == 1
    };
    let alone: Vec<u32> = parents.iter().filter(alone).copied().collect();
    assert!(alone.len() > 5, "{}", alone.len());
    for parent in alone {
        let beside = plain.window(parent, 3);
        let births = nest.iter().filter(|cell| beside.contains(cell));
        assert_eq!(births.count(), 1);
    }
}

/// Windows widen the gutters of the atlas, and nothing else of the trail. Would catch: taps as far apart as the gutter is wide, with which
/// rows of texels never spread, and keep their deposits.
#[test]
fn wide_windows_leave_the_trail_as_it_is() {
    let masses = [1_u32, 5, 9].map(|window| {
        let scene = scene(|settings| {
            settings.physarum.model = Model::Thesis;
            settings.particles.count = 2000;
            settings.population.capacity = 2000;
            settings.population.frequency = 10_000;
            settings.population.division_window = window;
            settings.population.survival_window = window;
        });
        let mut twin = twin_of(&scene);
        for _ in 0..20 {
            twin.step();
        }
        let (state, setup) = (twin.snapshot(), twin.setup());
        state.validate(setup).unwrap();
        assert_eq!(
            (setup.atlas.gutter, setup.atlas.taps),
            ((window / 2).max(1), 1)
        );
        // In texels of mean area, of which wider gutters leave fewer.
        state.trail_mass(setup) / setup.atlas.mean_texel_area
    });
    for mass in masses {
        assert!(
            masses[0] > 0.0 && (mass / masses[0] - 1.0).abs() < 1e-4,
            "{masses:?}"
        );
    }
}

/// A test in `src/sim/cells.rs` has which cells these are. Would catch: cells left out where births can be, and kernels that do not ask for
/// the table.
#[test]
fn particles_are_born_where_the_table_has_a_triangle() {
    let torus = scene(|settings| {
        settings.physarum.model = Model::Thesis;
        settings.physarum.speed = 0.0;
        settings.particles.count = 300;
    });
    let mut setup = Setup::new(&torus).unwrap();
    let nests = setup.nests.iter().filter(|&&triangle| triangle != NONE);
    assert!(nests.count() as f64 > 0.99 * f64::from(setup.atlas.owned_count));

    // Every second column has none.
    for nest in setup.nests.iter_mut().skip(1).step_by(2) {
        *nest = NONE;
    }
    let mut twin = twin::Simulation::new(setup.clone(), torus.settings.clone());
    for _ in 0..5 {
        twin.step();
    }
    let mut born = living(&twin.snapshot());
    born.retain(|particle| particle.id >= 300);
    assert!(born.len() > 100, "{}", born.len());
    for particle in &born {
        let cell = cell_of(particle, &setup.atlas, &setup.homes);
        assert!(cell.is_multiple_of(2), "{particle:?}");
    }
    let Some(gpu) = gpu() else { return };
    let found = first_difference(&gpu.ctx, &torus, &setup, 5, 3, &[]).unwrap();
    assert!(found.is_none(), "{}", found.unwrap());
    gpu.finish();
}

/// A population that stands: its first particles are far from each other, and in each of the three cells above the cell of one are two
/// others. Only the first ones divide. With it the cells of these; `spare` ids are free.
fn dividing_apart(spare: u32) -> (twin::Simulation, Vec<u32>) {
    let of = |count: u32, capacity: u32| {
        scene(|settings| {
            settings.physarum.model = Model::Thesis;
            settings.physarum.speed = 0.0;
            settings.atlas.size = 192;
            settings.particles.count = count;
            let population = &mut settings.population;
            population.capacity = capacity;
            (population.division_window, population.survival_window) = (1, 1);
            population.division_most = 1;
            population.survival_most = 1_000_000;
        })
    };
    let setup = Setup::new(&of(1, 1)).unwrap();
    let (atlas, pitch) = (&setup.atlas, setup.atlas.pitch);
    let plain = Plain::of(&[], atlas);
    let mut parents: Vec<u32> = Vec::new();
    let inner = 4..atlas.size - 4;
    for cell in 0..atlas.owner.len() as u32 {
        let is_inner = inner.contains(&(cell % pitch)) && inner.contains(&(cell / pitch));
        if !is_inner || !plain.is_inside(cell) {
            continue;
        }
        let is_far = |&other: &u32| {
            (cell % pitch).abs_diff(other % pitch) > 5 || (cell / pitch).abs_diff(other / pitch) > 5
        };
        let mut window = plain.window(cell, 3).into_iter();
        let has_nests = window.all(|beside| setup.nests[beside as usize] != NONE);
        if has_nests && parents.iter().all(is_far) {
            parents.push(cell);
        }
    }
    let dividing = parents.len() as u32;
    let scene = of(7 * dividing, 7 * dividing + spare);
    let mut twin = twin_of(&scene);
    let mut state = twin.snapshot();
    for particle in &mut state.particles {
        let id = particle.id;
        let cell = if id < dividing {
            parents[id as usize]
        } else {
            let other = id - dividing;
            let parent = parents[(other / 6 % dividing) as usize];
            parent - pitch - 1 + other % 3
        };
        particle.triangle = setup.nests[cell as usize];
        let map = &setup.atlas.maps[particle.triangle as usize];
        [particle.u, particle.v] = birthplace(map, cell, pitch);
    }
    twin.restore(&state);
    (twin, parents)
}

/// The births of the step with this number: of each the number of its parent, the place of its cell among the nine round the parent's, and
/// its id.
fn births_of(twin: &mut twin::Simulation, parents: &[u32], step: u64) -> Vec<(usize, u32, u32)> {
    let before = Snapshot {
        step,
        ..twin.snapshot()
    };
    twin.restore(&before);
    twin.step();
    let (state, setup) = (twin.snapshot(), twin.setup());
    let pitch = setup.atlas.pitch;
    let begun = 7 * parents.len() as u32;
    let born = (living(&state).into_iter()).filter(|particle| particle.id >= begun);
    let of = born.map(|particle| {
        let cell = cell_of(&particle, &setup.atlas, &setup.homes);
        let found = parents.iter().enumerate().find_map(|(number, &parent)| {
            let column = (cell % pitch + 1).checked_sub(parent % pitch)?;
            let row = (cell / pitch + 1).checked_sub(parent / pitch)?;
            (column < 3 && row < 3).then_some((number, 3 * row + column))
        });
        let (number, place) = found.expect("it is beside one that divides");
        (number, place, particle.id)
    });
    let births = of.collect();
    twin.restore(&before);
    births
}

/// Would catch: the first free cell after a taken one that is chosen more often than others, so that populations grow along crowds.
#[test]
fn every_free_cell_beside_a_parent_is_as_likely() {
    let (mut twin, parents) = dividing_apart(4000);
    assert!(parents.len() > 50, "{}", parents.len());
    let mut counts = [0_usize; 9];
    for round in 1..=8 {
        for (_, place, _) in births_of(&mut twin, &parents, 2 * round) {
            counts[place as usize] += 1;
        }
    }
    let all = 8 * parents.len();
    assert_eq!(counts.iter().sum::<usize>(), all);
    assert_eq!([0, 1, 2, 4].map(|place| counts[place]), [0; 4]);
    // A fifth each, within five deviations.
    let most = 5.0 * (0.16 * all as f64).sqrt();
    for place in [3, 5, 6, 7, 8] {
        let off = counts[place] as f64 - 0.2 * all as f64;
        assert!(off.abs() < most, "{counts:?}");
        // The rule by which the place after the taken ones had four of eight chances would be found.
        assert!((0.5 - 0.2) * all as f64 > 2.0 * most);
    }
}

/// Would catch: a cell over a border or a seam that several of the eight places round a parent have, and that is chosen so many times as
/// often as another one.
#[test]
fn no_cell_at_a_border_or_a_seam_is_likelier_than_another() {
    for mesh in ["builtin:plane?columns=8&rows=8", TORUS] {
        let of = |count: u32| {
            scene_of_mesh(mesh, |settings| {
                settings.physarum.speed = 0.0;
                settings.atlas.size = 128;
                settings.particles.count = count;
                let population = &mut settings.population;
                population.frequency = 2;
                population.capacity = 2 * count;
                (population.division_window, population.survival_window) = (1, 1);
                population.division_most = 1;
            })
        };
        let setup = Setup::new(&of(1)).unwrap();
        let (atlas, nests) = (&setup.atlas, &setup.nests);
        let plain = Plain::of(&[], atlas);
        let has_nest = |&cell: &u32| nests[cell as usize] != NONE;
        let mut parents: Vec<u32> = Vec::new();
        let (mut used, mut repeated) = (HashSet::<u32>::new(), HashSet::<u32>::new());
        // Of the births in one step that come to repeated cells: their expected number, its variance, and their number by places.
        let (mut mean, mut variance, mut by_places) = (0.0_f64, 0.0_f64, 0.0_f64);
        for cell in (0..nests.len() as u32).filter(has_nest) {
            let window = plain.window(cell, 3);
            let mut places = window.clone();
            places.retain(|beside| *beside != cell && has_nest(beside));
            let places_of = |cell: u32| places.iter().filter(|&&place| place == cell).count();
            let free: HashSet<u32> = places.iter().copied().collect();
            let several: Vec<u32> = (free.iter().copied())
                .filter(|&beside| places_of(beside) > 1)
                .collect();
            if several.is_empty() || window.iter().any(|beside| used.contains(beside)) {
                continue;
            }
            let share = several.len() as f64 / free.len() as f64;
            let of_several: usize = several.iter().map(|&beside| places_of(beside)).sum();
            mean += share;
            variance += share * (1.0 - share);
            by_places += of_several as f64 / places.len() as f64;
            used.extend(window);
            repeated.extend(several);
            parents.push(cell);
        }
        // So many steps that a choice among places would be off by ten deviations.
        let steps = (100.0 * variance / f64::powi(by_places - mean, 2)).ceil();
        assert!(parents.len() > 10 && steps < 200.0, "{mesh}: {steps}");

        let count = parents.len() as u32;
        let mut twin = twin_of(&of(count));
        let mut state = twin.snapshot();
        for particle in &mut state.particles {
            let cell = parents[(particle.id % count) as usize];
            particle.triangle = nests[cell as usize];
            let map = &atlas.maps[particle.triangle as usize];
            [particle.u, particle.v] = birthplace(map, cell, atlas.pitch);
        }
        let mut found = 0;
        for k in 1..=steps as u64 {
            state.step = 2 * k;
            twin.restore(&state);
            twin.step();
            let mut born = living(&twin.snapshot());
            born.retain(|particle| particle.id >= count);
            assert_eq!(born.len(), parents.len(), "{mesh}: step {k}");
            let cells = (born.iter()).map(|particle| cell_of(particle, atlas, &plain.homes));
            found += cells.filter(|cell| repeated.contains(cell)).count();
        }
        let off = found as f64 - steps * mean;
        let most = 5.0 * (steps * variance).sqrt();
        assert!(off.abs() < most, "{mesh}: {found} are {off} off");
    }
}

/// Would catch: low ids that always divide first where ids are left for some only; two births of one parent, or fewer than there are ids;
/// and parents that are not in the order of ids where there are enough.
#[test]
fn no_id_comes_first_where_a_population_is_full() {
    const LEFT: u32 = 20;
    const STEPS: u64 = 40;
    let (mut twin, parents) = dividing_apart(LEFT);
    assert!(parents.len() > 50, "{}", parents.len());
    let (mut sum, mut with_lowest) = (0, 0);
    for k in 1..=STEPS {
        let births = births_of(&mut twin, &parents, 2 * k);
        let numbers: HashSet<usize> = births.iter().map(|(number, ..)| *number).collect();
        let ids: HashSet<u32> = births.iter().map(|(.., id)| *id).collect();
        assert_eq!([numbers.len(), ids.len()], [LEFT as usize; 2], "step {k}");
        sum += numbers.iter().sum::<usize>();
        with_lowest += u64::from(numbers.contains(&0));
    }
    // The middle one in the mean; no number is farther from it than the first, which bounds the deviation.
    let mean = sum as f64 / (STEPS * u64::from(LEFT)) as f64;
    let middle = (parents.len() - 1) as f64 / 2.0;
    let deviation = middle / (STEPS as f64).sqrt();
    assert!(
        (mean - middle).abs() < 4.0 * deviation,
        "{mean} of {middle}"
    );
    assert!(middle - f64::from(LEFT - 1) / 2.0 > 4.0 * deviation);
    assert!(with_lowest < STEPS, "in each step");

    let (mut twin, parents) = dividing_apart(parents.len() as u32);
    let begun = 7 * parents.len();
    let births = births_of(&mut twin, &parents, 2);
    assert_eq!(births.len(), parents.len());
    for (number, _, id) in births {
        assert_eq!(begun + number, id as usize, "number by number");
    }
}

/// Would catch: a particle that divides in a step in which it was refused its cell.
#[test]
fn particles_that_have_not_moved_do_not_divide() {
    let births = |flags: u32| {
        let scene = scene(|settings| {
            settings.particles.count = 2500;
            settings.population.division_most = 81;
        });
        let mut twin = twin_of(&scene);
        twin.step();
        twin.step();
        let mut state = twin.snapshot();
        for motion in &mut state.motions {
            motion.flags |= flags;
        }
        twin.restore(&state);
        twin.step();
        let now = counts(&twin.snapshot());
        now.born + now.refused
    };
    assert_eq!(births(Motion::STAYED), 0);
    assert!(births(0) > 200);
}

/// Would catch: more living ones than there is room for, a birth that is neither there nor counted, and an id beyond the room.
#[test]
fn a_full_population_leaves_births_out_and_counts_them() {
    let full = scene(|settings| {
        settings.particles.count = 300;
        settings.population.capacity = 333;
    });
    let mut twin = twin_of(&full);
    for _ in 0..60 {
        let state = watched_step(&mut twin);
        assert!(counts(&state).living <= 333);
        assert_eq!(state.particles.len(), 333);
        assert_eq!(state.census(), Census::default());
    }
    let end = counts(&twin.snapshot());
    assert!(end.living == 333 && end.refused > 100, "{end:?}");
    // Room for fewer than there are at the start is room for these.
    let least = scene(|settings| settings.population.capacity = 10);
    let mut twin = twin_of(&least);
    for _ in 0..4 {
        assert_eq!(counts(&watched_step(&mut twin)).living, 1000);
    }
}

/// Compares both engines after each kernel.
fn compare(gpu: &Gpu, what: &str, scene: &Scene, dabs: &[Dab]) {
    let setup = set_up(&gpu.ctx, scene);
    let found = first_difference(&gpu.ctx, scene, &setup, 7, 3, dabs)
        .unwrap_or_else(|error| panic!("{what}: {error}"));
    assert!(found.is_none(), "{what}: {}", found.unwrap());
}

#[test]
fn populations_have_the_same_bits_on_both_engines() {
    type Change = fn(&mut Settings);
    let changes: [(&str, Change); 10] = [
        ("jones", |_| ()),
        ("thesis", |s| s.physarum.model = Model::Thesis),
        ("every step", |s| {
            s.population.frequency = 1;
            s.population.survival_least = 2;
        }),
        ("sense_first", |s| s.physarum.order = StepOrder::SenseFirst),
        ("walking", |s| s.physarum.sensing = Sensing::Walk),
        ("dense", |s| {
            s.particles.count = 2500;
            s.population.survival_most = 14;
            s.population.death_probability = 0.5;
            s.population.division_probability = 0.5;
        }),
        ("full", |s| {
            s.population.capacity = 1003;
            s.population.division_window = 3;
            s.population.division_most = 5;
        }),
        ("food", |s| {
            let plate = FoodSettings {
                amount: 40,
                size: 0.3,
                ..FoodSettings::default()
            };
            s.foods = vec![plate];
            s.feeding.fed_steps = 3;
            s.feeding.fed_deposit = 4;
            s.population.hunger = 3;
        }),
        ("hunger", |s| {
            s.physarum.model = Model::Thesis;
            let plate = FoodSettings {
                size: 0.3,
                ..FoodSettings::default()
            };
            s.foods = vec![plate];
            s.feeding.fed_steps = 2;
            s.population.hunger = 2;
        }),
        ("pulse", |s| {
            s.physarum.model = Model::Thesis;
            s.pulses = vec![PulseSettings::default()];
        }),
    ];
    for (k, gpu) in [gpu(), gpu_by_card_forms()].into_iter().enumerate() {
        let Some(gpu) = gpu else { continue };
        // The forms for graphics cards have the same text but for lists and tables.
        let changes = if k == 0 { &changes[..] } else { &changes[..2] };
        for &(what, change) in changes {
            compare(&gpu, what, &scene(change), &[]);
        }
        let dab = |brush| Dab {
            brush,
            center: [0.9, 0.1, 0.5].into(),
            radius: 0.3,
            eye: None,
            ring: None,
            number: 3,
        };
        let dabs = [dab(Brush::NoGo), dab(Brush::Particles { share: 0.3 })];
        compare(&gpu, "painted", &scene(|_| ()), &dabs);
        // Several objects, which particles stay on, restart on, or leave for others.
        let strategies = [
            Strategy::Parallel,
            Strategy::Sequential,
            Strategy::Respawn,
            Strategy::None,
        ];
        let strategies = &strategies[..if k == 0 { 4 } else { 1 }];
        for &strategy in strategies {
            compare(&gpu, strategy.word(), &trio(strategy, |_| ()), &[]);
        }
        let one_a_cell = trio(Strategy::Parallel, |settings| {
            settings.physarum.model = Model::Jones;
        });
        compare(&gpu, "trio, one a cell", &one_a_cell, &[]);
        gpu.finish();
    }
}

/// Several objects, between which particles go over. Some die where it is crowded, and others are born, often with ids of particles that
/// died on another object.
fn trio(strategy: Strategy, change: impl FnOnce(&mut Settings)) -> Scene {
    scene_of_several(&TRIO, |settings| {
        settings.transfer.strategy = strategy;
        settings.physarum.speed = 0.02;
        settings.particles.count = 1500;
        settings.atlas.size = 192;
        settings.population.frequency = 2;
        settings.population.survival_most = 4;
        settings.population.death_probability = 0.5;
        settings.population.capacity = 3001;
        change(settings);
    })
}

/// Would catch: births and transfers that get in each other's way, windows that a birth on another object does not change, an outcome that
/// depends on how the buffer is kept, and room for too few displaced particles after a change of strategy.
#[test]
fn strategies_end_in_the_same_population() {
    let Some(gpu) = gpu() else { return };
    // Also with lists of transfers that are full.
    for buffer_size in [65_536, 4] {
        let scene_by = |strategy| {
            trio(strategy, |settings| {
                settings.transfer.buffer_size = buffer_size;
            })
        };
        let mut hashes = Vec::new();
        for strategy in [
            Strategy::Scattered,
            Strategy::Direct,
            Strategy::Sequential,
            Strategy::Parallel,
        ] {
            let scene = scene_by(strategy);
            let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
            let mut twin = twin_of(&scene);
            for _ in 0..4 {
                advance(&gpu, &mut simulation, 6);
                (0..6).for_each(|_| twin.step());
                let (state, by_twin) = (simulation.snapshot().unwrap(), twin.snapshot());
                for state in [&state, &by_twin] {
                    state.validate(simulation.setup()).unwrap();
                }
                assert_eq!(state.hash(), by_twin.hash(), "{strategy:?}");
                assert_eq!(state.population, by_twin.population, "{strategy:?}");
                // As from a checkpoint.
                simulation.restore(&state).unwrap();
            }
            let state = simulation.snapshot().unwrap();
            let (now, flow) = (counts(&state), state.transfers.flow);
            assert!(now.births > 200 && now.deaths > 200, "{now:?}");
            assert!(flow.arrived > 20, "{flow:?}");
            assert_eq!(flow.refused > 0, buffer_size == 4, "{flow:?}");
            hashes.push((strategy, state.hash()));
        }
        for &(strategy, hash) in &hashes {
            assert_eq!(hash, hashes[0].1, "{strategy:?}");
        }
        // The strategy may change in between.
        let mut simulation = Simulation::new(&gpu.ctx, &scene_by(Strategy::Direct)).unwrap();
        advance(&gpu, &mut simulation, 11);
        let ordered = scene_by(Strategy::Parallel);
        simulation.apply(&ordered.settings).unwrap();
        advance(&gpu, &mut simulation, 13);
        let state = simulation.snapshot().unwrap();
        state.validate(simulation.setup()).unwrap();
        assert_eq!(state.hash(), hashes[0].1);
        // A population whose particles stay on their objects is another one.
        let mut apart = twin_of(&scene_by(Strategy::None));
        (0..24).for_each(|_| apart.step());
        assert_ne!(apart.snapshot().hash(), hashes[0].1);
    }
    gpu.finish();
}

/// Would catch: births inside of another object, from where particles would leave at its nearest point, or never.
#[test]
fn no_particle_is_born_where_another_object_covers_the_surface() {
    let births = |strategy: Strategy| {
        // They stand and live, so that those with new ids were born where they are.
        let scene = trio(strategy, |settings| {
            settings.physarum.speed = 0.0;
            settings.population.division_most = 81;
            settings.population.survival_most = 1_000_000;
        });
        let mut twin = twin_of(&scene);
        (0..3).for_each(|_| twin.step());
        let setup = twin.setup();
        let mut born = living(&twin.snapshot());
        born.retain(|particle| particle.id >= 1500);
        let (distances, _) = twin.distances();
        let is_covered = |particle: &&Particle| {
            let cell = cell_of(particle, &setup.atlas, &setup.homes);
            distances[cell as usize] < 0.0
        };
        (born.len(), born.iter().filter(is_covered).count())
    };
    let (born, covered) = births(Strategy::Direct);
    assert!(born > 500 && covered == 0, "{covered} of {born}");
    let (born, covered) = births(Strategy::None);
    assert!(covered > 20, "{covered} of {born}");
}

/// Would catch: a count of hungry steps that goes on over a meal, that runs while a particle is fed, or stands still in a step in which it
/// was refused its cell, and a death a step too early or too late.
#[test]
fn particles_die_when_they_have_been_hungry_for_so_long() {
    const HUNGER: u32 = 7;
    for model in [Model::Thesis, Model::Jones] {
        let scene = scene(|settings| {
            settings.physarum.model = model;
            settings.population.frequency = 3;
            settings.population.division_probability = 0.0;
            settings.population.survival_most = 1_000_000;
            settings.population.capacity = 1000;
            settings.population.hunger = HUNGER;
            let plate = FoodSettings {
                size: 0.4,
                ..FoodSettings::default()
            };
            settings.foods = vec![plate];
            settings.feeding.fed_steps = 4;
        });
        let mut twin = twin_of(&scene);
        // Of each id, while it is alive.
        let mut hungry = vec![Some(0); 1000];
        let mut fed = 0;
        for step in 0..40 {
            twin.step();
            for (particle, motion) in by_id(&twin.snapshot()) {
                let count = &mut hungry[particle.id as usize];
                if scene.settings.population.is_due(step) {
                    *count = count.filter(|&steps| steps < HUNGER);
                }
                assert_eq!(motion.is_dead(), count.is_none(), "step {step}");
                let Some(steps) = count else { continue };
                *steps = if motion.fed() > 0 { 0 } else { *steps + 1 };
                assert_eq!(motion.hungry(), *steps, "step {step}");
                fed += u32::from(motion.fed() > 0);
            }
        }
        let state = twin.snapshot();
        state.validate(twin.setup()).unwrap();
        let alive = state.living_count();
        assert!((10..900).contains(&alive) && fed > 100, "{alive} live");
    }
}

/// Would catch: particles that are born as if they had just eaten, so that a population without food lives on as long as it divides; and
/// hunger that is off and counts.
#[test]
fn those_that_are_born_are_as_hungry_as_their_parents() {
    let grown = |hunger: u32| {
        let mut twin = twin_of(&scene(|settings| {
            settings.population.frequency = 1;
            settings.population.hunger = hunger;
            let marker = FoodSettings {
                size: 0.0,
                ..FoodSettings::default()
            };
            settings.foods = vec![marker];
        }));
        for step in 0..10 {
            let state = watched_step(&mut twin);
            let mut alive = (state.motions.iter()).filter(|motion| !motion.is_dead());
            let expected = if hunger > 0 { step + 1 } else { 0 };
            assert!(
                alive.all(|motion| motion.hungry() == expected),
                "step {step}"
            );
        }
        counts(&twin.snapshot())
    };
    let starved = grown(9);
    assert!(starved.births > 100 && starved.living == 0, "{starved:?}");
    let others = grown(0);
    assert!(others.living > 1000, "{others:?}");
}

/// Would catch: particles that starve on food, or live on where it is gone.
#[test]
fn a_population_lives_as_long_as_its_food() {
    const LASTS: u32 = 3;
    let mut twin = twin_of(&scene(|settings| {
        settings.physarum.model = Model::Thesis;
        settings.population.frequency = 1;
        settings.population.division_probability = 0.0;
        settings.population.survival_most = 1_000_000;
        settings.population.hunger = 6;
        // On the whole surface.
        let plate = FoodSettings {
            amount: 3500,
            size: 10.0,
            ..FoodSettings::default()
        };
        settings.foods = vec![plate];
        settings.feeding.fed_steps = LASTS;
    }));
    let mut steps_without = 0;
    let mut steps_with = 0;
    while counts(&twin.snapshot()).living > 0 {
        let state = watched_step(&mut twin);
        // Its last particles eat when they have digested, are hungry, and die the step after.
        assert!(steps_without <= LASTS + 6, "{:?}", counts(&state));
        if state.food.remaining[0] > 0 {
            assert_eq!(counts(&state).living, 1000);
            steps_with += 1;
        } else {
            steps_without += 1;
        }
    }
    assert!(steps_with >= LASTS && steps_without > 6, "{steps_with}");
}

/// Grows a population until it is full and shrinks it by another rule to so many. In each step births minus deaths must be the change, no
/// id may be there twice, and no particle may be lost.
fn grow_and_shrink(gpu: &Gpu, scene: &Scene, back_to: u32) {
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    let capacity = scene.settings.population.capacity;
    let begun = scene.settings.particles.count;
    let watched = |simulation: &mut Simulation, before: Population| {
        advance(gpu, simulation, 1);
        let state = simulation.snapshot().unwrap();
        let (now, step) = (counts(&state), state.step);
        assert_eq!(u64::from(now.living), state.living_count(), "step {step}");
        assert_eq!(
            i64::from(now.living) - i64::from(before.living),
            i64::from(now.births - before.births) - i64::from(now.deaths - before.deaths),
            "step {step}"
        );
        assert_eq!(state.census(), Census::default(), "step {step}");
        assert!(now.living <= capacity, "step {step}: {now:?}");
        if step.is_multiple_of(10) {
            state.validate(simulation.setup()).unwrap();
        }
        now
    };
    let mut now = counts(&simulation.snapshot().unwrap());
    assert_eq!(now.living, begun);
    while now.refused == 0 {
        now = watched(&mut simulation, now);
        assert!(simulation.step() < 500, "it grows: {now:?}");
    }
    // Full, which is counted.
    assert_eq!(now.living, capacity, "{now:?}");
    assert!(now.births >= capacity - begun);
    let mut settings = scene.settings.clone();
    settings.population.division_probability = 0.0;
    settings.population.survival_most = 0;
    settings.population.death_probability = 0.2;
    simulation.apply(&settings).unwrap();
    let full = now;
    while now.living > back_to {
        now = watched(&mut simulation, now);
        assert!(simulation.step() < 1000, "it shrinks: {now:?}");
    }
    assert_eq!(now.births, full.births, "none is born any more");
    let end = simulation.snapshot().unwrap();
    end.validate(simulation.setup()).unwrap();
    assert!(end.transfers.flow.arrived > 0, "particles go over");
}

/// The rules by which it grows as fast as it can.
fn grows_fast(settings: &mut Settings) {
    settings.population.frequency = 1;
    settings.population.division_most = 81;
    settings.population.survival_most = 1_000_000;
}

/// Would catch: what a few hundred particles do not show, on the device: ids beyond the first words of a set, sums over runs of words, and
/// windows of which most slots are dead.
#[test]
fn a_population_grows_a_hundredfold_and_shrinks_again() {
    let Some(gpu) = gpu() else { return };
    let scene = trio(Strategy::Parallel, |settings| {
        grows_fast(settings);
        settings.particles.count = 200;
        settings.population.capacity = 20_000;
        settings.atlas.size = 320;
    });
    grow_and_shrink(&gpu, &scene, 200);
    gpu.finish();
}

#[test]
#[ignore = "takes long: make long"]
fn a_population_grows_to_half_a_million_and_shrinks_again() {
    let Some(gpu) = gpu() else { return };
    for strategy in [Strategy::Direct, Strategy::Parallel] {
        let scene = trio(strategy, |settings| {
            grows_fast(settings);
            settings.particles.count = 1000;
            settings.population.capacity = 500_000;
            settings.atlas.size = 2048;
        });
        grow_and_shrink(&gpu, &scene, 1000);
    }
    gpu.finish();
}

/// Would catch: an outcome that depends on which particle comes first in the buffer, and sorts that part a slot from its id.
#[test]
fn the_order_of_the_buffer_does_not_show_in_births() {
    let Some(gpu) = gpu() else { return };
    let scene = scene(|settings| settings.population.capacity = 2200);
    let mut twin = twin_of(&scene);
    for _ in 0..3 {
        twin.step();
    }
    let before = twin.snapshot();
    let mut other = before.clone();
    other.particles.reverse();
    other.motions.reverse();
    other.particles.rotate_left(777);
    other.motions.rotate_left(777);
    assert_eq!(other.hash(), before.hash());
    // Where a dead particle lies means nothing, either.
    let dead = (other.motions.iter()).position(|motion| motion.is_dead());
    other.particles[dead.unwrap()].u = 0.0;
    assert_eq!(other.hash(), before.hash());
    let ends = [&before, &other].map(|state| {
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        simulation.restore(state).unwrap();
        advance(&gpu, &mut simulation, 20);
        let mut twin = twin_of(&scene);
        twin.restore(state);
        for _ in 0..20 {
            twin.step();
        }
        let end = simulation.snapshot().unwrap();
        end.validate(simulation.setup()).unwrap();
        let living = simulation.living_count().unwrap();
        assert_eq!(living as u64, end.living_count());
        assert_eq!(twin.snapshot().hash(), end.hash());
        assert_eq!(twin.snapshot().population, end.population);
        assert!(counts(&end).refused > 0, "{:?}", counts(&end));
        end.hash()
    });
    assert_eq!(ends[0], ends[1]);
    gpu.finish();
}

/// Would catch: marks of dead particles, or counts, that a checkpoint or a scene laid out again loses.
#[test]
fn populations_go_on_from_checkpoints() {
    let Some(gpu) = gpu() else { return };
    let scene = scene(|_| ());
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    advance(&gpu, &mut simulation, 15);
    let state = simulation.snapshot().unwrap();
    assert!(counts(&state).births > 50, "{:?}", counts(&state));
    let kept = Checkpoint::new(&scene, simulation.setup(), state);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("state");
    kept.write(&file).unwrap();
    let read = Checkpoint::read(&file).unwrap();
    assert_eq!(read.check(&scene, simulation.setup()).unwrap(), [""; 0]);
    assert_eq!(read.snapshot.population, kept.snapshot.population);
    let wider = Setup::new(&crate::population::scene(|settings| {
        settings.atlas.size = 160
    }));
    let wider = wider.unwrap();
    let on_wider = carried(&read.snapshot, simulation.setup(), &wider, &[Some(0)]).unwrap();
    assert_eq!(on_wider.living_count(), read.snapshot.living_count());
    on_wider.validate(&wider).unwrap();
    let mut other = Simulation::new(&gpu.ctx, &scene).unwrap();
    other.restore(&read.snapshot).unwrap();
    advance(&gpu, &mut simulation, 10);
    advance(&gpu, &mut other, 10);
    let [own, other] = [simulation, other].map(|s| s.snapshot().unwrap());
    assert_eq!(own.hash(), other.hash());
    assert_eq!(own.population, other.population);

    // A state of a constant number of particles is none of a population, and the other way round.
    let constant = crate::population::scene(|settings| {
        settings.population.frequency = 0;
        settings.particles.count = 4000;
        settings.atlas.size = 160;
    });
    let mut constant = Simulation::new(&gpu.ctx, &constant).unwrap();
    let message = constant.restore(&on_wider).unwrap_err().to_string();
    assert!(
        message.starts_with("the number of particles changes"),
        "{message}"
    );
    let damaged = Snapshot {
        population: Vec::new(),
        ..read.snapshot
    };
    let problem = damaged.validate(&Setup::new(&scene).unwrap()).unwrap_err();
    assert!(problem.contains("counts of a population"), "{problem}");
    gpu.finish();
}

/// Would catch: a population that is too large, which only fails later.
#[test]
fn what_populations_cannot_be_is_said() {
    // Before any particle is made.
    let mut large = scene(|_| ());
    let setup = Setup::new(&large).unwrap();
    let atlas = &setup.atlas;
    assert!(check_room(&large.settings, atlas).is_ok());
    large.settings.particles.count = 134_217_729;
    let message = check_room(&large.settings, atlas).unwrap_err().to_string();
    assert_eq!(
        message,
        "particles.count = 134,217,729: where their number changes (population.frequency) there may be 134,217,728, at the most"
    );
}

/// With the number of particles constant, nothing of the rest of `[population]` matters. Would catch: windows that widen gutters, and slots for
/// a capacity, where no particle divides or dies.
#[test]
fn other_keys_of_a_constant_population_have_no_effect() {
    let scenes = [(2_000_000, 9), (10, 1)].map(|(capacity, window)| {
        scene(|settings| {
            settings.population.frequency = 0;
            settings.population.capacity = capacity;
            settings.population.division_window = window;
            settings.population.survival_window = window;
        })
    });
    let ends = scenes.map(|scene| {
        let mut twin = twin_of(&scene);
        assert!(twin.setup().population.is_none() && twin.setup().particles.len() == 1000);
        for _ in 0..5 {
            twin.step();
        }
        let state = twin.snapshot();
        assert_eq!((state.living_count(), state.population.len()), (1000, 0));
        assert_eq!(by_id(&state).len(), 1000);
        state.hash()
    });
    assert_eq!(ends[0], ends[1]);
}
