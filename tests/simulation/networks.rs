//! The networks that grow are the same whether sensors read straight ahead in the atlas or all of them walk: not texel by texel, because a
//! network amplifies every difference, but by the measures of networks.
//!
//! The ignored test compares ten seeds statistically; `make long` runs it. The other one tests whether two seeds are roughly equal.

use crate::common::{Gpu, gpu, scene, set_up};
use myxo::mesh::surface::NONE;
use myxo::scene::settings::Sensing;
use myxo::sim::behaviour::physarums;
use myxo::sim::field::{atlas_position, trail_at};
use myxo::sim::network::{Network, THRESHOLD};
use myxo::sim::plan::{Means, Plan};
use myxo::sim::step::advance::Form;
use myxo::sim::twin::{AdvanceInputs, straight_places};
use myxo::sim::{Simulation, Snapshot};

/// How much is grown.
struct Size {
    seeds: u64,
    steps: u32,
    atlas: u32,
    particles: u32,
}

const LONG: Size = Size {
    seeds: 10,
    steps: 250,
    atlas: 384,
    particles: 30_000,
};

/// With as many particles a texel.
const SHORT: Size = Size {
    seeds: 2,
    steps: 150,
    atlas: 256,
    particles: 13_333,
};

/// Of a two-sided test at 1 in 1,000, with 18 degrees of freedom (Student 1908).
const LARGEST_T: f64 = 3.92;
/// Half of the interval in which a difference lies with 95 %, in standard errors, by the same.
const INTERVAL_T: f64 = 2.10;

/// What is said of a network.
#[derive(Clone, Debug)]
struct Grown {
    network: Network,
    /// Texels of its skeleton where three or more branches meet.
    junctions: f64,
}

impl Grown {
    fn of(snapshot: &Snapshot, simulation: &Simulation) -> Self {
        let (trail, atlas) = (&snapshot.trail, &simulation.setup().atlas);
        let owned = || (0..trail.len()).filter(|&t| atlas.owner[t] != NONE);
        let count = owned().count() as f64;
        let mean = owned().map(|t| f64::from(trail[t])).sum::<f64>() / count;
        // Gutters hold what lies across seams, so branches do not end there.
        let threshold = (THRESHOLD * mean) as f32;
        let mut bits: Vec<bool> = trail.iter().map(|&value| value > threshold).collect();
        thin(&mut bits, atlas.pitch as usize);
        let junctions =
            owned().filter(|&t| bits[t] && branches(&bits, atlas.pitch as usize, t) > 2);
        Self {
            network: Network::of(snapshot, simulation.setup()),
            junctions: junctions.count() as f64,
        }
    }
}

/// The eight neighbours, round about from the one above; outside there is nothing.
fn neighbours(bits: &[bool], pitch: usize, texel: usize) -> [bool; 8] {
    let (x, y) = ((texel % pitch) as i64, (texel / pitch) as i64);
    let rows = (bits.len() / pitch) as i64;
    [
        (0, -1),
        (1, -1),
        (1, 0),
        (1, 1),
        (0, 1),
        (-1, 1),
        (-1, 0),
        (-1, -1),
    ]
    .map(|(dx, dy)| {
        let (x, y) = (x + dx, y + dy);
        (0..pitch as i64).contains(&x)
            && (0..rows).contains(&y)
            && bits[y as usize * pitch + x as usize]
    })
}

/// How often nothing is followed by something, round about.
fn branches(bits: &[bool], pitch: usize, texel: usize) -> usize {
    let around = neighbours(bits, pitch, texel);
    (0..8)
        .filter(|&k| !around[k] && around[(k + 1) % 8])
        .count()
}

/// Takes texels off the border of what is set until lines remain (Zhang and Suen, "A fast parallel algorithm for thinning
/// digital patterns", 1984).
fn thin(bits: &mut [bool], pitch: usize) {
    loop {
        let mut changed = false;
        for pass in [[0, 2, 4, 2, 4, 6], [0, 2, 6, 0, 4, 6]] {
            let gone: Vec<usize> = (0..bits.len())
                .filter(|&texel| {
                    if !bits[texel] {
                        return false;
                    }
                    let around = neighbours(bits, pitch, texel);
                    let set = around.iter().filter(|&&bit| bit).count();
                    let [a, b, c, d, e, f] = pass.map(|k: usize| around[k]);
                    (2..=6).contains(&set)
                        && branches(bits, pitch, texel) == 1
                        && !(a && b && c)
                        && !(d && e && f)
                })
                .collect();
            changed |= !gone.is_empty();
            for texel in gone {
                bits[texel] = false;
            }
        }
        if !changed {
            return;
        }
    }
}

/// The difference of two means, and its standard error (Welch 1947).
pub fn welch(a: &[f64], b: &[f64]) -> (f64, f64) {
    let moments = |values: &[f64]| {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, variance / n)
    };
    let ((mean_a, error_a), (mean_b, error_b)) = (moments(a), moments(b));
    (mean_a - mean_b, (error_a + error_b).sqrt())
}

/// The mean of values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Grows networks of one size.
struct Garden<'a> {
    gpu: &'a Gpu,
    size: Size,
}

impl Garden<'_> {
    /// Sensors are so many times as far away as by default.
    fn grow(&self, seed: u64, sensing: Sensing, offset: f32) -> Grown {
        let scene = scene("builtin:torus", |s| {
            s.seed = seed;
            s.particles.count = self.size.particles;
            s.atlas.size = self.size.atlas;
            s.physarum.sensing = sensing;
            s.physarum.sensor_offset *= offset;
        });
        let ctx = &self.gpu.ctx;
        let setup = set_up(ctx, &scene);
        let mut simulation = Simulation::from_setup(ctx, &scene, setup).unwrap();
        for _ in 0..self.size.steps {
            self.gpu.run(|rec| simulation.record_step(rec));
        }
        let snapshot = simulation.snapshot().unwrap();
        if seed == 1 && sensing == Sensing::Auto {
            print_readings(&simulation, &snapshot);
        }
        Grown::of(&snapshot, &simulation)
    }

    /// All seeds, straight ahead and walking.
    fn both_ways(&self) -> [Vec<Grown>; 2] {
        [Sensing::Auto, Sensing::Walk].map(|sensing| {
            let seeds = 1..=self.size.seeds;
            seeds.map(|seed| self.grow(seed, sensing, 1.0)).collect()
        })
    }

    /// One of sensors that are half as far away.
    fn other(&self) -> Grown {
        self.grow(7, Sensing::Auto, 0.5)
    }
}

type Measure = (&'static str, fn(&Grown) -> f64);

const MEASURES: [Measure; 9] = [
    ("length", |n| n.network.length),
    ("junctions", |n| n.junctions),
    ("regions", |n| f64::from(n.network.regions)),
    ("share of particles on it", |n| n.network.on_network),
    ("share below 1/4 of the mean trail", |n| n.network.below[0]),
    ("share below 1/2 of the mean trail", |n| n.network.below[1]),
    ("share below 1 of the mean trail", |n| n.network.below[2]),
    ("share below 2 of the mean trail", |n| n.network.below[3]),
    ("share below 4 of the mean trail", |n| n.network.below[4]),
];

/// Shares by which means of two seeds may differ, as wide as seeds by themselves make them. Of regions there are too few for
/// two seeds to say anything.
const MOST_APART: [f64; 9] = [0.15, 0.5, f64::INFINITY, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1];

/// Two seeds: the means of measures with little scatter are alike, and sensors that are half as far away grow a different network.
/// The long test finds smaller differences.
#[test]
fn both_ways_of_sensing_grow_networks_that_are_alike() {
    let Some(gpu) = gpu() else { return };
    let garden = Garden {
        gpu: &gpu,
        size: SHORT,
    };
    let [auto, walk] = garden.both_ways();
    let other = [garden.other()];
    let mut is_sensitive = false;
    for ((name, of), most) in MEASURES.iter().zip(MOST_APART) {
        let [a, b, c] =
            [&auto[..], &walk, &other].map(|all| mean(&all.iter().map(of).collect::<Vec<f64>>()));
        let row = format!("{name}: {a:.4} straight ahead, {b:.4} walking, {c:.4} from nearby");
        println!("{row}");
        assert!((a - b).abs() <= most * b, "{row}");
        is_sensitive |= (a - c).abs() > most * a;
    }
    assert!(is_sensitive, "{other:?} of {auto:?}");
    assert!(
        auto.iter().all(|n| n.junctions > 10.0),
        "there is a network"
    );
    gpu.finish();
}

/// Takes long: it is a proof by statistics, over ten seeds.
#[test]
#[ignore = "takes two minutes: make long"]
fn long_both_ways_of_sensing_grow_the_same_networks() {
    let Some(gpu) = gpu() else { return };
    let garden = Garden {
        gpu: &gpu,
        size: LONG,
    };
    let [auto, walk] = garden.both_ways();
    let mut different = Vec::new();
    // That no difference shows is not enough: it must also lie, with 95 %, within a share of what is compared.
    let mut compare = |name: &str, most: f64, of: &fn(&Grown) -> f64| {
        let [a, b] = [&auto, &walk].map(|all| all.iter().map(of).collect::<Vec<f64>>());
        let (difference, error) = welch(&a, &b);
        let t = difference / error.max(f64::MIN_POSITIVE);
        let at_most = (difference.abs() + INTERVAL_T * error) / mean(&b);
        let row = format!(
            "{name}: {:.4} straight ahead, {:.4} walking, t = {t:.2}, at most {:.1} % apart",
            mean(&a),
            mean(&b),
            100.0 * at_most
        );
        println!("{row}");
        if t.abs() > LARGEST_T || at_most > most {
            different.push(row);
        }
    };
    // There are four regions on average, so one more or less is much.
    let most_apart = [0.1, 0.3, 0.75, 0.05, 0.05, 0.05, 0.05, 0.05, 0.05];
    for ((name, of), most) in MEASURES.iter().zip(most_apart) {
        compare(name, most, of);
    }
    assert!(different.is_empty(), "{}", different.join("\n"));
    assert!(
        mean(&auto.iter().map(|n| n.junctions).collect::<Vec<_>>()) > 10.0,
        "there is a network"
    );
    // The test is sensitive: other sensors grow a network that it finds to be different.
    let other = garden.other();
    let far_off = |of: &dyn Fn(&Grown) -> f64| {
        let values: Vec<f64> = auto.iter().map(of).collect();
        let variance = values
            .iter()
            .map(|x| (x - mean(&values)).powi(2))
            .sum::<f64>()
            / (LONG.seeds - 1) as f64;
        (of(&other) - mean(&values)).abs() > 4.0 * variance.sqrt()
    };
    let is_sensitive = far_off(&|n| n.network.length)
        || far_off(&|n| n.junctions)
        || (0..5).any(|k| far_off(&|n| n.network.below[k]));
    assert!(is_sensitive, "{other:?} of {auto:?}");
    gpu.finish();
}

/// Prints how many particles have a sensor that walks, and how far readings straight ahead are from those at the end of a
/// walk, in parts of the mean trail.
fn print_readings(simulation: &Simulation, snapshot: &Snapshot) {
    let setup = simulation.setup();
    let plan = Plan::new(simulation.settings(), setup, 0, Means::of_host(false, 1));
    let params = plan.advance(plan.terms(), Form::All).params;
    let own = physarums(simulation.settings(), setup)[0];
    let inputs = AdvanceInputs {
        trail: &snapshot.trail,
        ..AdvanceInputs::of_surface(setup, std::slice::from_ref(&own))
    };
    let mean = snapshot.trail.iter().map(|&v| f64::from(v)).sum::<f64>()
        / f64::from(setup.atlas.owned_count);
    let mut off = Vec::new();
    let mut walking = 0;
    for (particle, motion) in snapshot.particles.iter().zip(&snapshot.motions) {
        let heading = [motion.heading_p, motion.heading_h];
        let turned = |s: f32| {
            let c = own.sensor_cos;
            [
                c * heading[0] - s * heading[1],
                s * heading[0] + c * heading[1],
            ]
        };
        let towards = [turned(own.sensor_sin), heading, turned(-own.sensor_sin)];
        let Some(places) = straight_places(&params, &inputs, &own, particle, towards) else {
            walking += 1;
            continue;
        };
        for (heading, place) in towards.into_iter().zip(places) {
            let mut w = myxo::sim::strip_walk::StripWalk {
                triangle: particle.triangle,
                u: particle.u,
                v: particle.v,
                heading,
                remaining: own.sensor_offset,
                status: 0,
            };
            w.walk(&setup.strips, u32::MAX, true);
            let walked = atlas_position(&setup.atlas.maps[w.triangle as usize], w.u, w.v);
            let [here, there] =
                [place, walked].map(|p| f64::from(trail_at(&snapshot.trail, p, params.pitch)));
            off.push((here - there).abs() / mean);
        }
    }
    let share =
        |most: f64| 100.0 * off.iter().filter(|&&x| x < most).count() as f64 / off.len() as f64;
    println!(
        "{:.1} % of the particles have a sensor that walks; of the other readings {:.1} % are within 1 % of the mean trail, \
         {:.1} % within 3 %, {:.1} % within 10 %, {:.1} % within 30 %",
        100.0 * f64::from(walking) / snapshot.particles.len() as f64,
        share(0.01),
        share(0.03),
        share(0.1),
        share(0.3)
    );
}
