//! How the trail spreads in a step: the rates of each object in each pass, and the parameters of the trail's two kernels.

use super::behaviour::deposit_factor;
use super::kernels::{DiffuseParams, DiffuseSeamsParams};
use super::setup::Setup;
use super::spread_length::spread_of;
use super::types::TrailRates;
use crate::mesh::atlas::{Atlas, BLOCK_QUADS, GREATEST_DENSITY, GREATEST_DIFFUSION};
use crate::mesh::surface::NONE;
use crate::scene::settings::Settings;

/// Trail values below this become zero. Decay would turn them into denormal numbers, with which some devices are 4 to 8 times slower, and
/// no picture shows them.
pub const TINY_TRAIL: f32 = 1e-20;

/// Diffusion above the limit of the exchange tables is done in several passes of a step, an equal part of it in each. So are diffusion
/// lengths, whatever the limit is, because several means of nine are more alike in all directions than one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// The first of several. By a diffusion length deposits come with it, so that they spread by the passes that follow: otherwise sensors
    /// would read single texels, and so another trail on every texture. What is missing of the length is less than a texel.
    First,
    /// One that only spreads.
    Spreading,
    /// The last pass, or the whole step: decay and the filling of gutters, which diffusion does not read, and the other deposits.
    Last,
}

impl Pass {
    /// All of them, in the order of the table of rates.
    pub const ALL: [Self; 3] = [Self::First, Self::Spreading, Self::Last];

    /// The passes of a step that has so many.
    pub fn of(passes: u32) -> impl Iterator<Item = Self> {
        (1..=passes).map(move |pass| match pass {
            _ if pass == passes => Self::Last,
            1 => Self::First,
            _ => Self::Spreading,
        })
    }
}

/// The number of passes of a step: as many as the object takes whose trail spreads the most.
#[must_use]
pub fn passes(settings: &Settings, setup: &Setup) -> u32 {
    passes_for(&spreads(settings, setup), greatest(settings, setup))
}

/// How much one pass spreads at the most.
fn greatest(settings: &Settings, setup: &Setup) -> f32 {
    let mut objects = settings.objects.iter();
    if objects.any(|object| settings.trail_on(object).diffusion_length > 0.0) {
        return GREATEST_DIFFUSION;
    }
    setup.atlas.greatest_diffusion
}

/// How much the trail on each object spreads in a step.
fn spreads(settings: &Settings, setup: &Setup) -> Vec<f64> {
    let objects = settings.objects.iter();
    let spreads = objects.map(|object| {
        let trail = settings.trail_on(object);
        spread_of(&trail, setup.radius, &setup.atlas)
    });
    spreads.collect()
}

fn passes_for(spreads: &[f64], greatest: f32) -> u32 {
    let most = spreads.iter().copied().fold(0.0, f64::max);
    (most / f64::from(greatest)).ceil().max(1.0) as u32
}

/// The table of rates: those of each object in each kind of pass.
#[must_use]
pub fn trail_rates(settings: &Settings, setup: &Setup) -> Vec<TrailRates> {
    let spreads = spreads(settings, setup);
    let passes = passes_for(&spreads, greatest(settings, setup));
    let factor = deposit_factor(settings, setup);
    let row = |pass: Pass| {
        let objects = settings.objects.iter().zip(&spreads);
        objects.map(move |(object, spread)| {
            let trail = settings.trail_on(object);
            let deposits_in = match passes > 1 && trail.diffusion_length > 0.0 {
                true => Pass::First,
                false => Pass::Last,
            };
            let deposit = factor * settings.deposit_on(object);
            TrailRates {
                diffusion: (spread / f64::from(passes)) as f32,
                deposit: if pass == deposits_in { deposit } else { 0.0 },
                decay: if pass == Pass::Last {
                    trail.remaining()
                } else {
                    1.0
                },
                pad0: 0.0,
            }
        })
    };
    Pass::ALL.into_iter().flat_map(row).collect()
}

/// The rates of texels in a pass. Twin of `shaders/include/rates.glsl`.
#[derive(Clone, Copy, Debug)]
pub struct RatesOfTexels<'a> {
    /// Those of all texels, unless objects differ.
    pub shared: TrailRates,
    /// If they do: the object of each texel, and the rates of each object in the pass.
    pub own: Option<(&'a [u32], &'a [TrailRates])>,
}

impl RatesOfTexels<'_> {
    /// The rates of a texel.
    #[must_use]
    pub fn at(&self, texel: usize) -> TrailRates {
        match self.own {
            Some((objects, rates)) => rates[objects[texel] as usize],
            None => self.shared,
        }
    }
}

/// The object of each texel; 0 for texels that no triangle owns.
#[must_use]
pub fn texel_objects(setup: &Setup) -> Vec<u32> {
    let triangles = &setup.surface.triangles;
    let owners = setup.atlas.owner.iter();
    let object = owners.map(|&owner| match owner {
        NONE => 0,
        triangle => triangles[triangle as usize].object,
    });
    object.collect()
}

/// The trail's two kernels on an atlas, without deposits, decay and diffusion.
#[must_use]
pub fn spreading(atlas: &Atlas) -> (DiffuseParams, DiffuseSeamsParams) {
    let diffuse = DiffuseParams {
        lane_count: BLOCK_QUADS * atlas.blocks.len() as u32,
        quad_count: atlas.pitch * atlas.size / 4,
        quads_a_row: atlas.pitch / 4,
        diffusion: 0.0,
        most_density: GREATEST_DENSITY,
        deposit: 0.0,
        decay: 1.0,
        tiny: TINY_TRAIL,
        first_rates: 0,
    };
    let diffuse_seams = DiffuseSeamsParams {
        row_count: atlas.exchange.rows.len() as u32,
        reach_across: atlas.taps,
        reach_down: atlas.taps * atlas.pitch,
        diffusion: 0.0,
        deposit: 0.0,
        decay: 1.0,
        tiny: TINY_TRAIL,
        first_rates: 0,
    };
    (diffuse, diffuse_seams)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::scene::settings::{ObjectSettings, OwnPhysarum, OwnTrail};
    use crate::sim::plan::{Means, Plan};
    use crate::sim::spread_length::check_lengths;

    /// Would catch: objects that agree and run other kernels than a scene without own values, or with other numbers; and objects that
    /// differ of which one gives the parameters for all.
    #[test]
    fn objects_that_agree_run_the_plain_kernels() {
        let mut settings = Settings::default();
        settings.atlas.size = 128;
        settings.particles.count = 10;
        let object = |mesh: &str, x: f64| ObjectSettings {
            mesh: format!("builtin:{mesh}"),
            position: [x, 0.0, 0.0],
            ..ObjectSettings::default()
        };
        settings.objects = vec![object("cube", 0.0), object("torus", 5.0)];
        let scene = Scene::from_settings("both".to_owned(), settings, "".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let mut settings = scene.settings;
        for object in &mut settings.objects {
            object.trail.decay = Some(0.25);
            object.trail.diffusion = Some(0.9);
            object.physarum.deposit = Some(3.0);
        }
        let mut shared = settings.clone();
        shared.trail.decay = 0.25;
        shared.trail.diffusion = 0.9;
        shared.physarum.deposit = 3.0;
        for object in &mut shared.objects {
            object.trail = OwnTrail::default();
            object.physarum = OwnPhysarum::default();
        }
        let calls = |settings: &Settings| {
            let plan = Plan::new(settings, &setup, 0, Means::of_host(false, 0));
            Pass::ALL.map(|pass| {
                let call = plan.diffuse(pass);
                let rates = [
                    call.params.diffusion,
                    call.params.deposit,
                    call.params.decay,
                ];
                let seams = plan.diffuse_seams(pass).constants;
                assert_eq!(call.constants.own_rates, seams.own_rates);
                (call.constants.own_rates, rates)
            })
        };
        assert_eq!(calls(&settings), calls(&shared));
        let half = 0.9 / 2.0;
        let only_spreads = (false, [half, 0.0, 1.0]);
        let expected = [only_spreads, only_spreads, (false, [half, 3.0, 0.25])];
        assert_eq!(calls(&settings), expected);
        assert_eq!(passes(&settings, &setup), 2);
        settings.objects[1].trail.diffusion = Some(0.1);
        assert!(calls(&settings).iter().all(|(own, _)| *own));
        let rows = trail_rates(&settings, &setup);
        let diffusions = rows.iter().map(|row| row.diffusion);
        let few = 0.1 / 2.0;
        let expected = [half, few].repeat(Pass::ALL.len());
        assert_eq!(diffusions.collect::<Vec<_>>(), expected);
        // By a length deposits come first, where there are several passes; those of the other object still come last.
        settings.objects[1].trail.diffusion_length =
            Some((setup.atlas.mean_texel_area.sqrt() / f64::from(setup.radius)) as f32);
        assert!(passes(&settings, &setup) > 1);
        let rows = trail_rates(&settings, &setup);
        let deposits = rows.iter().map(|row| row.deposit);
        assert_eq!(deposits.collect::<Vec<_>>(), [0.0, 3.0, 0.0, 0.0, 3.0, 0.0]);
        let objects = texel_objects(&setup);
        assert!(objects.contains(&0) && objects.contains(&1));
    }

    /// Would catch: the mean of nine in two passes of half of it, which is another kernel, where texels allow one; texels that give away more
    /// than they have; and lengths in so few passes that they are less round than they should be.
    #[test]
    fn the_mean_of_nine_is_one_pass_where_texels_are_alike() {
        let passes_on = |mesh: &str, set: fn(&mut Settings)| {
            let mut settings = Settings::default();
            settings.atlas.size = 64;
            settings.particles.count = 10;
            settings.objects[0].mesh = format!("builtin:{mesh}");
            set(&mut settings);
            let scene = Scene::from_settings("one".to_owned(), settings, "".into()).unwrap();
            passes(&scene.settings, &Setup::new(&scene).unwrap())
        };
        let mean = |settings: &mut Settings| settings.trail.diffusion = 1.0;
        assert_eq!(passes_on("plane?periodic=true", mean), 1);
        assert_eq!(passes_on("icosphere", mean), 2);
        // A length of half a texel: its square is 3/8 of that of the mean.
        let length = |settings: &mut Settings| {
            settings.trail.diffusion_length = 0.5 * 2.0 / 64.0 / 2.0_f32.sqrt();
        };
        assert_eq!(passes_on("plane?periodic=true", length), 1);
        let twice = |settings: &mut Settings| {
            settings.trail.diffusion_length = 2.0 / 64.0 / 2.0_f32.sqrt();
        };
        assert_eq!(passes_on("plane?periodic=true", twice), 3);
    }

    /// Would catch: one pass more than forty for the greatest length, for lengths that rounding brings a little beyond it, and passes that
    /// spread more than the exchange tables take.
    #[test]
    fn the_greatest_length_takes_forty_passes() {
        let mut settings = Settings::default();
        settings.atlas.size = 128;
        settings.particles.count = 10;
        settings.objects = vec![ObjectSettings {
            mesh: "builtin:cube".to_owned(),
            ..ObjectSettings::default()
        }];
        let scene = Scene::from_settings("cube".to_owned(), settings, "".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let mut settings = scene.settings;
        let greatest = 4.0 * setup.atlas.mean_texel_area.sqrt() / f64::from(setup.radius);
        let mut length = greatest as f32;
        for _ in 0..4 {
            length = length.next_down();
        }
        let mut beyond = 0;
        for _ in 0..8 {
            settings.trail.diffusion_length = length;
            beyond += u32::from(f64::from(length) > greatest);
            check_lengths(&settings, setup.radius, &setup.atlas).unwrap();
            assert_eq!(passes(&settings, &setup), 40, "{length}");
            let rows = trail_rates(&settings, &setup);
            assert!(rows.iter().all(|row| row.diffusion <= GREATEST_DIFFUSION));
            length = length.next_up();
        }
        assert!((2..7).contains(&beyond), "lengths on both sides: {beyond}");
        // A hundredth shorter is less than forty times what a pass spreads, and more than thirty-nine times.
        settings.trail.diffusion_length = 0.99 * greatest as f32;
        assert_eq!(passes(&settings, &setup), 40);
        settings.trail.diffusion_length = 0.98 * greatest as f32;
        assert_eq!(passes(&settings, &setup), 39);
    }
}
