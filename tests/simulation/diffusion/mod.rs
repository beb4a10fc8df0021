//! The trail spreads as heat does on the surface: mass stays, constants stay, and iso-lines know nothing of charts.

mod reference;

use std::sync::LazyLock;

use crate::common::{Gpu, gpu, scene_of};
use crate::places::root;
use glam::DVec3;
use myxo::mesh::atlas::{Atlas, AtlasMethod, AtlasOptions};
use myxo::mesh::surface::{NONE, Surface};
use myxo::mesh::{Mesh, suite};
use myxo::scene::settings;
use myxo::sim::diffusion::Diffusion;
use myxo::sim::kernels::{DiffuseConstants, DiffuseParams};
use myxo::sim::spread::passes;
use myxo::sim::{Simulation, TINY_TRAIL, twin};
use reference::{Elements, narrowness, plane_kernel, sphere_kernel};

/// As `myxo query diffuse` has it.
const DIFFUSION: f32 = 0.5;

/// Standard deviation of a spot at the end, texels.
const SPOT: f64 = 12.0;

/// Standard deviations of a spot at the start, texels; 0 for a single texel's deposit.
const STARTS: [f64; 2] = [5.0, 0.0];

/// The root mean square error of an iso-line's radius, relative, that is allowed on surfaces that charts can keep the
/// angles of.
const SCATTER: f64 = 0.003;

/// The mean error of the values on one side of a seam, relative, that is allowed there.
const BIAS: f64 = 0.003;

struct Case {
    name: String,
    method: AtlasMethod,
    surface: Surface,
    atlas: Atlas,
}

impl Case {
    fn new(mesh: &Mesh, method: AtlasMethod, size: u32, turn: u64) -> Self {
        Self::spreading(mesh, method, size, turn, 1)
    }

    /// With taps so many texels apart.
    fn spreading(mesh: &Mesh, method: AtlasMethod, size: u32, turn: u64, distance: u32) -> Self {
        let surface = Surface::build(&[(mesh, 1.0)]);
        let options = AtlasOptions {
            method,
            size,
            turn,
            gutter: distance,
            ..AtlasOptions::default()
        };
        let atlas = Atlas::build(&surface, &options).unwrap();
        atlas.validate(&surface).unwrap();
        Self {
            name: format!(
                "{} by {method:?} at {size}, turn {turn}, distance {distance}",
                mesh.name
            ),
            method,
            surface,
            atlas,
        }
    }

    /// The place of an owned texel on the surface.
    fn place(&self, texel: u32) -> Option<DVec3> {
        let (t, u, v) = self.atlas.surface_point_of(texel)?;
        let [a, b, c] = self.surface.corners[t as usize]
            .map(|corner| self.surface.positions[corner as usize].as_dvec3());
        Some(a + f64::from(u) * (b - a) + f64::from(v) * (c - a))
    }

    fn owned(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.atlas.texel_count() as u32).filter(|&t| self.atlas.owner[t as usize] != NONE)
    }

    /// The owned texel whose centre is nearest to a place.
    fn nearest(&self, place: DVec3) -> u32 {
        self.owned()
            .min_by(|&a, &b| {
                let distance = |t| self.place(t).unwrap().distance_squared(place);
                distance(a).total_cmp(&distance(b))
            })
            .unwrap()
    }

    /// A trail that is `value` at each place.
    fn trail(&self, value: impl Fn(DVec3) -> f64) -> Vec<f32> {
        (0..self.atlas.texel_count() as u32)
            .map(|texel| self.place(texel).map_or(0.0, |place| value(place) as f32))
            .collect()
    }

    fn spread(&self, gpu: &Gpu, trail: &[f32], steps: u64) -> Vec<f32> {
        let mut diffusion = Diffusion::new(&gpu.ctx, &self.atlas, DIFFUSION).unwrap();
        diffusion.set(trail).unwrap();
        diffusion.run(steps, |_| true).unwrap();
        diffusion.values().unwrap()
    }

    fn mass(&self, trail: &[f32]) -> f64 {
        let masses = trail.iter().zip(&self.atlas.area);
        masses.map(|(&v, &a)| f64::from(v) * f64::from(a)).sum()
    }

    /// Diffusivity times time of some steps: a step's nine taps have a variance of two thirds of a texel's area, times
    /// their distance squared.
    fn time(&self, steps: u64) -> f64 {
        let square = f64::from(self.atlas.taps).powi(2);
        steps as f64 * f64::from(DIFFUSION) / 3.0 * square * self.atlas.mean_texel_area
    }

    /// Steps after which a point has a standard deviation of so many texels.
    fn steps(&self, texels: f64) -> u64 {
        let square = f64::from(self.atlas.taps).powi(2);
        (texels * texels * 1.5 / f64::from(DIFFUSION) / square).round() as u64
    }

    /// How far a trail is from what it should be. The distance of an iso-line from the source follows from the value: of
    /// `exp(-r^2 / 2 s^2)` a change by one part in a hundred moves it by one in a hundred times `s^2 / r^2`.
    fn compare(&self, trail: &[f32], expected: impl Fn(u32) -> Option<f64>) -> Compared {
        let expected: Vec<(u32, f64)> = self
            .owned()
            .filter_map(|texel| Some((texel, expected(texel)?)))
            .collect();
        let most = expected.iter().fold(0.0, |most, e| f64::max(most, e.1));
        let (mut squares, mut texels) = (0.0, 0);
        // From 0.7 to 1.7 standard deviations.
        for &(texel, expected) in &expected {
            let depth = (most / expected).ln();
            if (0.245..1.445).contains(&depth) {
                let error = f64::from(trail[texel as usize]) / expected - 1.0;
                squares += (error / (2.0 * depth)).powi(2);
                texels += 1;
            }
        }
        // Texels that exchange across a seam, chart by chart.
        let mut charts = vec![(0.0, 0); self.atlas.chart_count as usize];
        let rows = &self.atlas.exchange.rows;
        for &(texel, expected) in expected.iter().filter(|e| e.1 > 0.2 * most) {
            let row = rows.binary_search_by_key(&texel, |row| row.texel);
            if row.is_ok_and(|row| rows[row].pair_count > 0) {
                let chart = self.atlas.chart[self.atlas.owner[texel as usize] as usize];
                let (sum, count) = &mut charts[chart as usize];
                *sum += f64::from(trail[texel as usize]) / expected - 1.0;
                *count += 1;
            }
        }
        let bias = charts
            .iter()
            // Of a few texels a mean says nothing.
            .filter(|chart| chart.1 >= 10)
            .map(|&(sum, count)| (sum / f64::from(count)).abs())
            .fold(0.0, f64::max);
        let compared = Compared {
            scatter: (squares / f64::from(texels)).sqrt(),
            bias,
            seams: charts.iter().filter(|chart| chart.1 >= 10).count(),
        };
        println!("{}: {compared:?}, {texels} texels", self.name);
        assert!(texels > 200, "{}: {texels} texels", self.name);
        compared
    }
}

#[derive(Clone, Copy, Debug)]
struct Compared {
    /// Root mean square of the iso-lines' distances from where they should be, relative.
    scatter: f64,
    /// The largest mean error of a chart's seam texels, relative.
    bias: f64,
    /// Charts with seam texels near the source.
    seams: usize,
}

fn builtin(name: &str) -> Mesh {
    Mesh::builtin(name).unwrap()
}

fn hand() -> Mesh {
    Mesh::load(root().join("assets/hand_animated.glb")).unwrap()
}

/// A single texel's deposit.
fn deposit(case: &Case, texel: u32) -> Vec<f32> {
    let mut trail = vec![0.0; case.atlas.texel_count()];
    trail[texel as usize] = 1.0 / case.atlas.area[texel as usize];
    trail
}

/// On a cube the way over an edge, far from corners, is a plane's.
#[test]
fn a_spot_beside_an_edge_of_a_cube_spreads_round() {
    let Some(gpu) = gpu() else { return };
    for (method, turn, distance) in [
        (AtlasMethod::Grid, 0, 1),
        (AtlasMethod::Charts, 0, 1),
        (AtlasMethod::Charts, 1, 1),
        (AtlasMethod::Charts, 2, 2),
        (AtlasMethod::Charts, 3, 4),
    ] {
        // Corners are five standard deviations away.
        let case = Case::spreading(&builtin("cube"), method, 320, turn, distance);
        // Beside the edge x = z = 1, and 4 texels from it.
        let texel = case.atlas.mean_texel_area.sqrt();
        for (beside, start) in [0.5, 4.0].into_iter().flat_map(|b| STARTS.map(|s| (b, s))) {
            // Taps that are texels apart leave those between them alone: only what is smooth spreads as heat does.
            if start == 0.0 && distance > 1 {
                continue;
            }
            let source = case.nearest(DVec3::new(1.0, 0.013, 1.0 - beside * texel));
            // The face z = 1 folded into that of x = 1.
            let unfolded = |p: DVec3| match p {
                p if (p.x - 1.0).abs() < 1e-6 => Some(DVec3::new(p.y, p.z, 0.0)),
                p if (p.z - 1.0).abs() < 1e-6 => Some(DVec3::new(p.y, 2.0 - p.x, 0.0)),
                _ => None,
            };
            let centre = unfolded(case.place(source).unwrap()).unwrap();
            let kernel = |p: DVec3, sigma: f64| {
                let distance = unfolded(p)?.distance(centre);
                Some(plane_kernel(case.time(case.steps(sigma)), distance))
            };
            let first = if start == 0.0 {
                deposit(&case, source)
            } else {
                case.trail(|p| kernel(p, start).unwrap_or(0.0))
            };
            let trail = case.spread(&gpu, &first, case.steps(SPOT) - case.steps(start));
            let compared = case.compare(&trail, |texel| kernel(case.place(texel)?, SPOT));
            assert!(method != AtlasMethod::Grid || compared.seams == 2);
            // Taps far apart see less of the spot's shape.
            let coarser = f64::from(distance);
            assert!(compared.scatter < SCATTER * coarser, "{compared:?}");
            assert!(compared.bias < BIAS * coarser, "{compared:?}");
            assert!((case.mass(&trail) / case.mass(&first) - 1.0).abs() < 1e-6);
        }
    }
    gpu.finish();
}

/// Layouts that the tests of mass run on, which share them.
fn cases() -> &'static [Case] {
    static CASES: LazyLock<Vec<Case>> = LazyLock::new(laid_out);
    &CASES
}

fn laid_out() -> Vec<Case> {
    let mut cases = vec![
        Case::new(&builtin("cube"), AtlasMethod::Grid, 61, 0),
        Case::new(
            &builtin("torus?major=24&minor=16"),
            AtlasMethod::Grid,
            203,
            0,
        ),
        // No two triangles alike, so some texels are very small.
        Case::new(&suite::potato(), AtlasMethod::Grid, 256, 0),
    ];
    for turn in [0, 1] {
        for mesh in [
            builtin("cube"),
            builtin("torus?major=24&minor=16"),
            suite::potato(),
        ] {
            cases.push(Case::new(&mesh, AtlasMethod::Charts, 200, turn));
        }
        for distance in [2, 4] {
            let mesh = suite::potato();
            cases.push(Case::spreading(
                &mesh,
                AtlasMethod::Charts,
                200,
                turn,
                distance,
            ));
        }
    }
    // Its own texture coordinates.
    cases.push(Case::new(&hand(), AtlasMethod::Mesh, 512, 0));
    cases
}

/// On the texel with the most pairs and all over the place for each layout; on the smallest and the largest texel for those
/// by a grid, whose texels differ most.
#[test]
fn mass_stays_where_nothing_decays() {
    mass_stays(250, |case| case.method == AtlasMethod::Grid);
}

/// The smallest and the largest texel of each layout too, and four times as many steps: rounding does not add up.
#[test]
#[ignore = "takes a minute: make long"]
fn long_mass_stays_where_nothing_decays() {
    mass_stays(1000, |_| true);
}

/// May drift by 1e-5 in 1000 steps, and by as little a step in fewer. `every_start` says whether a layout has all starts.
fn mass_stays(steps: u32, every_start: impl Fn(&Case) -> bool) {
    let Some(gpu) = gpu() else { return };
    for case in cases() {
        let rows = &case.atlas.exchange.rows;
        let busiest = rows.iter().max_by_key(|row| row.pair_count).unwrap().texel;
        let by_area = |&a: &u32, &b: &u32| {
            case.atlas.area[a as usize].total_cmp(&case.atlas.area[b as usize])
        };
        let smallest = case.owned().min_by(by_area).unwrap();
        let largest = case.owned().max_by(by_area).unwrap();
        let centre = case.place(busiest).unwrap();
        let sigma = 8.0 * case.atlas.mean_texel_area.sqrt();
        let blob = |p: DVec3| (-0.5 * p.distance_squared(centre) / (sigma * sigma)).exp();
        let mut starts = vec![
            ("busiest", deposit(case, busiest)),
            ("blob", case.trail(blob)),
        ];
        if every_start(case) {
            starts.push(("smallest", deposit(case, smallest)));
            starts.push(("largest", deposit(case, largest)));
        }
        for (name, start) in starts {
            let end = case.spread(&gpu, &start, steps.into());
            let drift = case.mass(&end) / case.mass(&start) - 1.0;
            println!("{}, {name}: {drift:.1e}", case.name);
            let most = 1e-8 * f64::from(steps);
            assert!(drift.abs() < most, "{}, {name}: {drift}", case.name);
        }
    }
    gpu.finish();
}

/// What happens without the symmetric exchange: texels beside seams read filled gutters, and mass comes and goes. If
/// this did not fail, the test above would show nothing.
#[test]
fn gathering_from_gutters_alone_does_not_keep_mass() {
    for case in cases() {
        let atlas = &case.atlas;
        let rows = &atlas.exchange.rows;
        let busiest = rows.iter().max_by_key(|row| row.pair_count).unwrap().texel;
        let start = deposit(case, busiest);
        let constants = DiffuseConstants {
            distance: atlas.taps as i32,
            ..DiffuseConstants::default()
        };
        let params = DiffuseParams {
            lane_count: 4 * atlas.blocks.len() as u32,
            quad_count: atlas.pitch * atlas.size / 4,
            quads_a_row: atlas.pitch / 4,
            diffusion: DIFFUSION,
            most_density: f32::MAX,
            deposit: 0.0,
            decay: 1.0,
            tiny: TINY_TRAIL,
            first_rates: 0,
        };
        let none = vec![0; start.len()];
        let mut cleared = none.clone();
        let (mut trail, mut next) = (start.clone(), start.clone());
        for _ in 0..100 {
            twin::exchange_seams(&atlas.seams, &mut trail);
            twin::diffuse(
                &constants,
                &params,
                &atlas.blocks,
                &trail,
                &none,
                &atlas.density,
                (&[], &[]),
                &mut next,
                &mut cleared,
            );
            std::mem::swap(&mut trail, &mut next);
        }
        let drift = case.mass(&trail) / case.mass(&start) - 1.0;
        println!("{}: {drift:.1e}", case.name);
        assert!(drift.abs() > 1e-3, "{}: {drift}", case.name);
    }
}

/// What survives a step bit by bit survives any number; these are enough to read what each of both textures has filled.
#[test]
fn constants_stay_constant_to_the_last_bit() {
    let Some(gpu) = gpu() else { return };
    for case in cases() {
        for value in [1.0, 0.1, 7.3e-9] {
            let start = case.trail(|_| value);
            let trail = case.spread(&gpu, &start, 40);
            for texel in case.owned() {
                let (now, before) = (trail[texel as usize], start[texel as usize]);
                assert_eq!(now, before, "{}: texel {texel}", case.name);
            }
        }
    }
    gpu.finish();
}

/// At the strongest diffusion of one step no value becomes negative: it would be cut off, and mass would appear.
#[test]
fn no_texel_gives_away_more_than_it_has() {
    let Some(gpu) = gpu() else { return };
    for case in cases() {
        let start = case.trail(|p| f64::from(u8::from((p.dot(DVec3::splat(1e4))).sin() > 0.9)));
        let most = start.iter().copied().fold(0.0, f32::max);
        let mut diffusion = Diffusion::new(&gpu.ctx, &case.atlas, 0.6).unwrap();
        diffusion.set(&start).unwrap();
        for _ in 0..20 {
            diffusion.run(1, |_| true).unwrap();
            let trail = diffusion.values().unwrap();
            let drift = case.mass(&trail) / case.mass(&start) - 1.0;
            assert!(drift.abs() < 2e-6, "{}: {drift}", case.name);
            assert!(trail.iter().all(|&value| value <= most), "{}", case.name);
        }
    }
    gpu.finish();
}

/// Particles leave the same mass wherever they are, also where their texel is a gutter's or a small one; and strong
/// diffusion, which takes two halves of a step, moves it without changing it.
#[test]
fn particles_leave_what_they_should() {
    let Some(gpu) = gpu() else { return };
    for (diffusion, method) in [
        (0.5, settings::AtlasMethod::Grid),
        (0.5, settings::AtlasMethod::Charts),
        (0.9, settings::AtlasMethod::Grid),
        (0.9, settings::AtlasMethod::Charts),
    ] {
        for mesh in [suite::potato(), builtin("torus?major=24&minor=16")] {
            let what = format!("{} by {method:?}, diffusion {diffusion}", mesh.name);
            let scene = scene_of(mesh, |s| {
                s.particles.count = 3000;
                s.atlas.size = 256;
                s.atlas.method = method;
                s.trail.diffusion = diffusion;
                s.trail.decay = 1.0;
                s.physarum.deposit = 0.25;
            });
            let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
            let mut by_twin =
                twin::Simulation::new(simulation.setup().clone(), scene.settings.clone());
            for step in 1..=10 {
                gpu.run(|rec| simulation.record_step(rec));
                by_twin.step();
                for state in [simulation.snapshot().unwrap(), by_twin.snapshot()] {
                    state.validate(simulation.setup()).unwrap();
                    let left = 0.25 * 3000.0 * f64::from(step);
                    let expected = left * simulation.setup().atlas.mean_texel_area;
                    let share = state.trail_mass(simulation.setup()) / expected;
                    assert!((share - 1.0).abs() < 1e-5, "{what}, step {step}: {share}");
                }
            }
        }
    }
    gpu.finish();
}

#[test]
fn strong_diffusion_is_twice_half_of_it() {
    let Some(gpu) = gpu() else { return };
    let scene = scene_of(builtin("torus?major=24&minor=16"), |s| {
        s.particles.count = 1;
        s.atlas.size = 203;
        s.trail.diffusion = 0.8;
        s.trail.decay = 1.0;
        s.physarum.deposit = 0.0;
    });
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut state = simulation.snapshot().unwrap();
    for (texel, value) in state.trail.iter_mut().enumerate() {
        *value = if texel % 13 == 0 { 1.0 } else { 0.0 };
    }
    simulation.restore(&state).unwrap();
    gpu.run(|rec| simulation.record_step(rec));
    let after = simulation.snapshot().unwrap().trail;
    let atlas = &simulation.setup().atlas;
    let mut diffusion = Diffusion::new(&gpu.ctx, atlas, 0.4).unwrap();
    diffusion.set(&state.trail).unwrap();
    diffusion.run(2, |_| true).unwrap();
    let expected = diffusion.values().unwrap();
    for texel in (0..after.len()).filter(|&texel| atlas.density[texel] > 0.0) {
        assert_eq!(after[texel], expected[texel], "texel {texel}");
    }
    gpu.finish();
}

/// Would catch: a length that depends on the texture's size or on the distance of taps, passes that lose mass, are not round or differ from
/// their twins', a half-life that is no half, and a length beyond the greatest that is taken.
#[test]
fn a_diffusion_length_is_the_same_on_every_texture() {
    let Some(gpu) = gpu() else { return };
    const LENGTH: f32 = 0.025;
    const STEPS: u32 = 4;
    for (size, distance) in [(96, 1), (200, 1), (200, 2)] {
        let scene = scene_of(builtin("plane"), |s| {
            s.particles.count = 1;
            s.atlas.size = size;
            s.trail.diffusion_length = LENGTH;
            s.trail.diffusion_distance = distance;
            s.trail.half_life = STEPS as f32;
            s.physarum.deposit = 0.0;
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = simulation.setup().clone();
        let mut by_twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
        let case = Case {
            name: format!("plane at {size}, distance {distance}"),
            method: AtlasMethod::Charts,
            surface: setup.surface.clone(),
            atlas: setup.atlas.clone(),
        };
        let source = case.nearest(DVec3::ZERO);
        let mut state = simulation.snapshot().unwrap();
        state.trail = deposit(&case, source);
        simulation.restore(&state).unwrap();
        by_twin.restore(&state);
        for _ in 0..STEPS {
            gpu.run(|rec| simulation.record_step(rec));
            by_twin.step();
        }
        let trail = simulation.snapshot().unwrap().trail;
        let expected = by_twin.snapshot().trail;
        let (mut mass, mut along, mut across, mut askew) = (0.0, 0.0, 0.0, 0.0);
        let centre = case.place(source).unwrap();
        for texel in case.owned() {
            let value = trail[texel as usize];
            assert_eq!(value, expected[texel as usize], "{texel}");
            let share = f64::from(value) * f64::from(case.atlas.area[texel as usize]);
            let from = case.place(texel).unwrap() - centre;
            mass += share;
            along += share * from.x * from.x;
            across += share * from.z * from.z;
            askew += share * from.x * from.z;
        }
        assert!((mass - 0.5).abs() < 1e-5, "half of it remains: {mass}");
        let length = f64::from(LENGTH) * f64::from(setup.radius);
        let variance = f64::from(STEPS) * length * length;
        for found in [along, across].map(|sum| sum / mass / variance) {
            assert!((found - 1.0).abs() < 0.01, "{}: {found}", case.name);
        }
        assert!((askew / mass / variance).abs() < 0.01, "{}", case.name);
        if (size, distance) == (200, 1) {
            let kernel = |place: DVec3| plane_kernel(0.5 * variance, place.distance(centre));
            let compared = case.compare(&trail, |texel| Some(0.5 * kernel(case.place(texel)?)));
            assert!(compared.scatter < 0.01, "{compared:?}");
            let mut far = scene.settings.clone();
            far.trail.diffusion_length = 0.2;
            let problem = simulation.apply(&far).unwrap_err().to_string();
            let (_, greatest) = problem.split_once("use ").expect("there is advice");
            let (greatest, _) = greatest.split_once(" or less").expect("with a number");
            far.trail.diffusion_length = greatest.parse().expect("it is one");
            simulation.apply(&far).unwrap();
            far.trail.diffusion_length *= 1.01;
            assert!(simulation.apply(&far).is_err(), "it is the greatest");
        }
    }
    gpu.finish();
}

/// Would alone catch: deposits that lie on single texels until the next step, so that sensors read what the texture's size is; and passes that
/// take them twice.
#[test]
fn deposits_spread_by_the_length_in_the_same_step() {
    let Some(gpu) = gpu() else { return };
    const LENGTH: f32 = 0.025;
    for size in [96, 200] {
        let scene = scene_of(builtin("plane"), |s| {
            s.particles.count = 1;
            s.atlas.size = size;
            s.physarum.deposit = 1.0;
            s.trail.decay = 0.5;
            s.trail.diffusion_length = LENGTH;
            s.particles.start = settings::Start::Point;
        });
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = simulation.setup().clone();
        gpu.run(|rec| simulation.record_step(rec));
        let trail = simulation.snapshot().unwrap().trail;
        let case = Case {
            name: format!("plane at {size}"),
            method: AtlasMethod::Charts,
            surface: setup.surface.clone(),
            atlas: setup.atlas.clone(),
        };
        let shares: Vec<(f64, DVec3)> = case
            .owned()
            .map(|texel| {
                let area = f64::from(case.atlas.area[texel as usize]);
                let share = f64::from(trail[texel as usize]) * area;
                (share, case.place(texel).unwrap())
            })
            .collect();
        let mass: f64 = shares.iter().map(|(share, _)| share).sum();
        let half = 0.5 * setup.atlas.mean_texel_area;
        assert!((mass / half - 1.0).abs() < 1e-5, "{}: {mass}", case.name);
        let centre: DVec3 = shares.iter().map(|(share, at)| *share * *at).sum();
        let centre = centre / mass;
        let squares = shares
            .iter()
            .map(|(share, at)| share * at.distance_squared(centre));
        let length = f64::from(LENGTH) * f64::from(setup.radius);
        // By all passes but the first, along both axes.
        let passes = f64::from(passes(&scene.settings, &setup));
        assert!(passes > 4.0, "{passes}");
        let expected = 2.0 * length * length * (1.0 - 1.0 / passes);
        let found = squares.sum::<f64>() / mass / expected;
        assert!((found - 1.0).abs() < 0.01, "{}: {found}", case.name);
    }
    gpu.finish();
}

/// From one texel, on a sphere.
#[test]
fn a_spot_on_a_sphere_spreads_round() {
    let Some(gpu) = gpu() else { return };
    let mesh = builtin("icosphere?subdivisions=4");
    for turn in [0, 1] {
        // A standard deviation at the end is a sixth of its radius.
        let case = Case::new(&mesh, AtlasMethod::Charts, 320, turn);
        let area: f64 = case.atlas.area.iter().map(|&a| f64::from(a)).sum();
        let radius = (area / (4.0 * std::f64::consts::PI)).sqrt();
        // On the texel with the most pairs, and somewhere.
        let rows = &case.atlas.exchange.rows;
        let busiest = rows.iter().max_by_key(|row| row.pair_count).unwrap().texel;
        let elsewhere = case.nearest(DVec3::new(0.3, 0.5, -0.8));
        for (source, start) in [busiest, elsewhere]
            .into_iter()
            .flat_map(|b| STARTS.map(|s| (b, s)))
        {
            let centre = case.place(source).unwrap().normalize();
            let kernel = |p: DVec3, sigma: f64| {
                let angle = p.normalize().dot(centre).clamp(-1.0, 1.0).acos();
                sphere_kernel(radius, case.time(case.steps(sigma)), angle)
            };
            let first = if start == 0.0 {
                deposit(&case, source)
            } else {
                case.trail(|p| kernel(p, start))
            };
            let trail = case.spread(&gpu, &first, case.steps(SPOT) - case.steps(start));
            let compared = case.compare(&trail, |texel| Some(kernel(case.place(texel)?, SPOT)));
            assert!(compared.scatter < SCATTER, "{compared:?}");
            assert!(compared.bias < BIAS, "{compared:?}");
        }
    }
    gpu.finish();
}

/// A blob beside a seam of a surface for which only finite elements know the answer.
#[test]
fn blobs_spread_as_finite_elements_say() {
    let Some(gpu) = gpu() else { return };
    for (mesh, turns, cuts, scatter, bias) in [
        (builtin("torus"), &[0][..], 4, SCATTER, BIAS),
        // Irregular ones: remeshed, and a model.
        (builtin("trefoil"), &[0, 1], 3, SCATTER, BIAS),
        (builtin("suzanne"), &[1], 4, 0.01, 0.005),
        // Triangles of a coarse, bumpy surface cannot keep their angles in a chart, and the stencil ignores stretch.
        (suite::potato(), &[0, 1], 12, 0.015, 0.01),
    ] {
        for &turn in turns {
            let case = Case::new(&mesh, AtlasMethod::Charts, 512, turn);
            let texel = case.atlas.mean_texel_area.sqrt();
            let steps = case.steps(11.0);
            // Of some places beside seams the one with the widest triangles: elements take as many steps as the narrowest asks.
            let rows = &case.atlas.exchange.rows;
            let reach = 70.0 * texel;
            let places =
                [1, 3, 5, 7, 9].map(|k| case.place(rows[rows.len() * k / 10].texel).unwrap());
            let narrowness = |place: &DVec3| narrowness(&case.surface, *place, reach);
            let best = places
                .into_iter()
                .min_by(|a, b| narrowness(a).total_cmp(&narrowness(b)));
            let centre = best.expect("there are places");
            let elements = Elements::new(&case.surface, cuts, centre, reach);
            let blob =
                |p: DVec3| (-0.5 * p.distance_squared(centre) / (25.0 * texel * texel)).exp();
            let expected = elements.spread(blob, case.time(steps));
            let trail = case.spread(&gpu, &case.trail(blob), steps);
            let compared = case.compare(&trail, |texel| {
                let (t, u, v) = case.atlas.surface_point_of(texel)?;
                elements.at(&expected, t, f64::from(u), f64::from(v))
            });
            assert!(compared.scatter < scatter, "{compared:?}");
            assert!(compared.bias < bias, "{compared:?}");
        }
    }
    gpu.finish();
}
