//! Presets applied to settings: at once or over some seconds, one after the other, or at random.

use myxo::scene::parameters::{Effect, Kind, PARAMETERS, Parameter, Scale, find};
use myxo::scene::presets::is_look;
use myxo::scene::settings::{ColorMap, Preference, Settings, Turning};

/// With several objects, distances between them are computed again whenever these change, which takes longer than a step: on the way from
/// one look to another they change in so many stages.
const STAGES: f64 = 4.0;
const LENGTHS: &[&str] = &[
    "physarum.speed",
    "physarum.sensor_offset",
    "distance.reach",
    "transfer.threshold",
];

/// A look that changes into another.
#[derive(Clone, Debug)]
pub struct Morph {
    from: Settings,
    to: Settings,
    /// The last settings that it has set. If one of its parameters differs from them, the user has changed it, and the morph
    /// ends.
    last: Settings,
    began: f64,
    seconds: f64,
    /// The settings whose kernels it waits for, the next one last, once that was asked.
    kernels: Option<Vec<Settings>>,
}

impl Morph {
    /// Brings settings to what it comes to.
    pub fn end(self, settings: &mut Settings) {
        self.put(&self.to, settings);
    }

    /// From what is to what is to be, beginning at a time in seconds.
    pub fn new(from: &Settings, to: Settings, began: f64, seconds: f64) -> Self {
        Self {
            from: from.clone(),
            to,
            last: from.clone(),
            began,
            seconds,
            kernels: None,
        }
    }

    /// Brings settings to where they should be at this time; returns true if that was the end.
    pub fn advance(&mut self, settings: &mut Settings, time: f64) -> bool {
        let is_touched = PARAMETERS
            .iter()
            .any(|parameter| self.changes(parameter) && parameter.differs(settings, &self.last));
        if is_touched {
            return true;
        }
        let share = (time - self.began) / self.seconds;
        let is_over = share >= 1.0;
        let now = if is_over {
            self.to.clone()
        } else {
            between(&self.from, &self.to, share.max(0.0))
        };
        self.put(&now, settings);
        self.last.clone_from(settings);
        is_over
    }

    /// The next settings whose kernels it needs, from those that run at the first call: half-way, where numbers of both looks have their
    /// effect, and at the end, where words change. Later changes beside the morph do not make it wait again.
    pub fn needs_kernels(&mut self, runs: &Settings) -> Option<&Settings> {
        if self.kernels.is_none() {
            let [mut end, mut half] = [runs.clone(), runs.clone()];
            self.put(&self.to, &mut end);
            self.put(&between(&self.from, &self.to, 0.5), &mut half);
            self.kernels = Some(vec![end, half]);
        }
        self.kernels.as_ref()?.last()
    }

    /// The kernels that it has asked for are there.
    pub fn has_kernels(&mut self) {
        if let Some(kernels) = &mut self.kernels {
            kernels.pop();
        }
    }

    /// Is it on this way from one look to another?
    fn changes(&self, parameter: &Parameter) -> bool {
        parameter.differs(&self.from, &self.to)
    }

    /// Copies the parameters that the morph changes; the user's changes to others stay.
    fn put(&self, look: &Settings, settings: &mut Settings) {
        for parameter in PARAMETERS.iter().filter(|p| self.changes(p)) {
            parameter.copy(look, settings);
        }
    }
}

/// A share of the way from a look to another: numbers in between, by factors where their sliders are; words of the first.
pub fn between(from: &Settings, to: &Settings, share: f64) -> Settings {
    let mut settings = from.clone();
    let whole = share;
    for parameter in PARAMETERS.iter().filter(|parameter| is_look(parameter)) {
        let is_staged = from.objects.len() > 1 && LENGTHS.contains(&parameter.key);
        let share = if is_staged {
            (whole * STAGES).floor() / STAGES
        } else {
            whole
        };
        let Kind::Number(number) = &parameter.kind else {
            continue;
        };
        if parameter.effect != Effect::Live {
            continue;
        }
        // Food is laid out again whenever it changes, so it changes at the end, as words do.
        if parameter.key.starts_with("feeding.") && !parameter.key.starts_with("feeding.fed_") {
            continue;
        }
        let [a, b] = [from, to].map(number.get);
        let by_factors = number.scale == Scale::Logarithmic && a > 0.0 && b > 0.0;
        let value = if by_factors {
            a * (b / a).powf(share)
        } else {
            a + share * (b - a)
        };
        (number.set)(&mut settings, value);
    }
    settings
}

/// The name after or before this one; the first or the last one if it is none of them.
///
/// # Panics
/// Where there are no names.
pub fn neighbour<'n>(names: &'n [String], name: Option<&str>, forward: bool) -> &'n str {
    let count = names.len();
    let place = name.and_then(|name| names.iter().position(|other| other == name));
    let place = match (place, forward) {
        (Some(place), true) => (place + 1) % count,
        (Some(place), false) => (place + count - 1) % count,
        (None, true) => 0,
        (None, false) => count - 1,
    };
    &names[place]
}

/// Parameters of random looks with their bounds: the part of each slider's range in which structures grow.
const BY_CHANCE: &[(&str, f64, f64)] = &[
    ("physarum.speed", 0.002, 0.008),
    ("physarum.rotation_angle", 8.0, 60.0),
    ("physarum.sensor_angle", 10.0, 70.0),
    ("physarum.sensor_offset", 0.008, 0.07),
    ("trail.diffusion", 0.15, 0.9),
    ("trail.decay", 0.82, 0.975),
];

/// How often chance lets particles avoid a crowd, and how often it lets them seek a density: without one most looks come to
/// a few lines.
const SELDOM: f64 = 0.3;
const OFTEN: f64 = 0.75;
/// How often chance takes each of the other rules of turning and sensing, those of `cords`, `bone` and `haze`: they break up networks.
const RARELY: f64 = 0.15;
/// Particles per texel that such looks are meant for.
const REFERENCE_DENSITY: f64 = 0.54;

/// A random look; equal seeds give equal looks. As with presets, a diffusion length and a half-life stay where they are set, and the
/// diffusion and the decay of the look have no effect meanwhile.
pub fn by_chance(settings: &Settings, seed: u64) -> Settings {
    let mut state = seed;
    let mut chance = || {
        // SplitMix64 (Steele, Lea and Flood, 2014).
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64
    };
    let mut settings = settings.clone();
    for &(key, low, high) in BY_CHANCE {
        if let Some(Kind::Number(number)) = find(key).map(|parameter| &parameter.kind) {
            (number.set)(&mut settings, low * (high / low).powf(chance()));
        }
    }
    // The trail's mean where the density is the reference.
    let decay = f64::from(settings.trail.remaining()).min(0.999);
    let mean = REFERENCE_DENSITY * decay / (1.0 - decay);
    let crowds = f64::from(chance() < SELDOM);
    let favours = f64::from(chance() < OFTEN);
    let physarum = &mut settings.physarum;
    physarum.reference_density = REFERENCE_DENSITY as f32;
    physarum.decrowding_weight = (crowds * chance()) as f32;
    physarum.preference = Preference::Auto;
    physarum.favourite_density = (favours * mean * (1.2 + 2.3 * chance())) as f32;
    let colours = ColorMap::ALL;
    settings.picture.color_map =
        colours[(chance() * colours.len() as f64) as usize % colours.len()];
    let [turning, random_turn, sensitivity] = [(); 3].map(|()| chance() < RARELY);
    let [most_random, weakest] = [0.25, 1.2 * mean].map(|most| (most * chance()) as f32);
    let physarum = &mut settings.physarum;
    physarum.turning = if turning {
        Turning::Random
    } else {
        Turning::Model
    };
    physarum.random_turn = if random_turn { most_random } else { 0.0 };
    physarum.sensitivity = if sensitivity { weakest } else { 0.0 };
    settings
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::own_presets::with_preset;
    use std::collections::HashSet;

    use myxo::scene::builtin::{Builtin, PRESETS};
    use myxo::scene::parameters::out_of_range;

    fn with(settings: &Settings, preset: &Builtin) -> Settings {
        with_preset(settings, preset.name, preset.text).expect("those of the program are right")
    }

    #[test]
    fn every_preset_can_be_taken_over_and_changes_nothing_but_the_look() {
        let settings = Settings::default();
        for preset in PRESETS {
            let mut taken = with(&settings, preset);
            assert_eq!(out_of_range(&taken), []);
            let again = with(&taken, preset);
            assert_eq!(taken, again, "{}", preset.name);
            for parameter in PARAMETERS.iter().filter(|p| is_look(p)) {
                assert!(!parameter.restarts(&settings, &taken), "{}", parameter.key);
                parameter.copy(&settings, &mut taken);
            }
            assert_eq!(taken, settings, "{}", preset.name);
        }
        let looks: Vec<Settings> = PRESETS.iter().map(|p| with(&settings, p)).collect();
        for (i, look) in looks.iter().enumerate() {
            assert!(!looks[..i].contains(look), "{}", PRESETS[i].name);
        }
    }

    #[test]
    fn presets_follow_one_another_in_a_ring() {
        let names = ["a", "b", "c"].map(str::to_owned);
        let next = |name| neighbour(&names, name, true);
        let before = |name| neighbour(&names, name, false);
        assert_eq!((next(None), before(None)), ("a", "c"));
        assert_eq!((next(Some("a")), next(Some("c"))), ("b", "a"));
        assert_eq!((before(Some("a")), before(Some("c"))), ("c", "b"));
        assert_eq!(next(Some("gone")), "a");
    }

    #[test]
    fn errors_in_a_preset_are_reported_with_its_name() {
        let settings = Settings::default();
        let error = with_preset(&settings, "mine", "[trail]\ndecay = 2\n").unwrap_err();
        let text = error.to_string();
        assert!(
            text.starts_with("preset mine: line 2: trail.decay = 2"),
            "{text}"
        );
    }

    #[test]
    fn a_morph_goes_all_the_way_and_gives_way_to_the_hand() {
        let from = Settings::default();
        let mut to = from.clone();
        to.trail.decay = 0.55;
        to.physarum.speed = 0.016;
        to.physarum.turning = Turning::Random;
        let mut settings = from.clone();
        let mut morph = Morph::new(&from, to.clone(), 10.0, 4.0);
        assert!(!morph.advance(&mut settings, 10.0));
        assert_eq!(settings, from);
        let half = morph.needs_kernels(&settings).unwrap().clone();
        assert!(!morph.advance(&mut settings, 12.0));
        assert_eq!(half, settings, "two of four seconds");
        let needed = morph.needs_kernels(&Settings::default());
        assert_eq!(needed, Some(&half), "settings of the first call");
        morph.has_kernels();
        assert_eq!(
            morph.needs_kernels(&settings),
            Some(&to),
            "words change at the end"
        );
        morph.has_kernels();
        assert_eq!(morph.needs_kernels(&settings), None, "it waits once");
        assert!((settings.trail.decay - 0.75).abs() < 1e-6);
        // Half way by factors: from 0.004 to 0.016.
        assert!((settings.physarum.speed - 0.008).abs() < 1e-6);
        let mut other = morph.clone();
        assert!(morph.advance(&mut settings, 14.0));
        assert_eq!(settings, to);
        let mut touched = between(&from, &to, 0.5);
        // Parameters that the morph does not change belong to the user.
        for (time, seed) in [(12.5, 2), (13.0, 3)] {
            touched.seed = seed;
            touched.objects[0].position[0] += 1.0;
            let before = touched.clone();
            assert!(!other.advance(&mut touched, time), "it continues");
            assert!(touched.trail.decay < before.trail.decay);
            assert_eq!(touched.seed, seed);
            assert_eq!(touched.objects, before.objects);
        }
        // With several objects, lengths change in stages, and all of them at the end.
        let mut several = from.clone();
        several.objects.push(several.objects[0].clone());
        let speeds = [0.1, 0.2, 0.3].map(|share| between(&several, &to, share).physarum.speed);
        assert!(
            speeds[0] == from.physarum.speed && speeds[1] == speeds[0] && speeds[2] > speeds[1]
        );
        assert_eq!(
            between(&several, &to, 1.0).physarum.speed,
            to.physarum.speed
        );
        touched.trail.decay = 0.1;
        let before = touched.clone();
        assert!(other.advance(&mut touched, 13.0), "it ends");
        assert_eq!(touched, before, "and leaves what the user has set");
    }

    #[test]
    fn chance_stays_within_what_is_allowed_and_can_be_had_again() {
        let mut settings = Settings::default();
        settings.physarum.turning = Turning::Random;
        settings.physarum.random_turn = 0.2;
        settings.physarum.sensitivity = 8.0;
        let (mut seeking, mut others) = (0, [0; 3]);
        for seed in 0..200 {
            let made = by_chance(&settings, seed);
            assert_eq!(made, by_chance(&settings, seed));
            assert_eq!(out_of_range(&made), []);
            for &(key, low, high) in BY_CHANCE {
                let Some(Kind::Number(number)) = find(key).map(|p| &p.kind) else {
                    panic!("{key}");
                };
                let value = (number.get)(&made);
                assert!(
                    (low * 0.999..=high * 1.001).contains(&value),
                    "{key} = {value}"
                );
            }
            seeking += usize::from(made.physarum.favourite_density > 0.0);
            let own = &made.physarum;
            let are_other = [
                own.turning == Turning::Random,
                own.random_turn > 0.0,
                own.sensitivity > 0.0,
            ];
            for (count, is_other) in others.iter_mut().zip(are_other) {
                *count += usize::from(is_other);
            }
        }
        assert!((120..180).contains(&seeking), "{seeking}");
        // Rules of a look before do not stay.
        assert!(
            others.iter().all(|count| (15..50).contains(count)),
            "{others:?}"
        );
        let colours: HashSet<&str> = (0..200)
            .map(|seed| by_chance(&settings, seed).picture.color_map.word())
            .collect();
        assert_eq!(colours.len(), ColorMap::ALL.len());
        assert_ne!(by_chance(&settings, 1), by_chance(&settings, 2));
    }

    /// Would catch: a random look that changes what presets leave, such as a diffusion length or a half-life, which take the place of its
    /// diffusion and its decay; and a favourite density for a decay that has no effect.
    #[test]
    fn chance_changes_no_more_than_presets_do() {
        let with_half_life = |steps: f32| {
            let mut settings = Settings::default();
            settings.trail.diffusion_length = 0.01;
            settings.trail.half_life = steps;
            settings
        };
        let (short, long) = (with_half_life(40.0), with_half_life(80.0));
        let mut seeking = 0;
        for seed in 0..40 {
            let made = by_chance(&short, seed);
            for parameter in PARAMETERS.iter().filter(|parameter| !is_look(parameter)) {
                assert!(!parameter.differs(&short, &made), "{}", parameter.key);
            }
            assert_eq!(made.objects, short.objects);
            // With twice the half-life nearly twice as much trail remains.
            let favourites = [made, by_chance(&long, seed)].map(|m| m.physarum.favourite_density);
            if favourites[0] > 0.0 {
                seeking += 1;
                let ratio = favourites[1] / favourites[0];
                assert!((1.95..2.05).contains(&ratio), "{ratio}");
            }
        }
        assert!(seeking > 10, "{seeking}");
    }
}
