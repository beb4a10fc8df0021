//! Why a parameter has no effect in a scene: the panel greys it out and shows the reason.

use std::sync::LazyLock;

use crate::scene::settings::{
    AtlasMethod, DepthMapping, DistanceMethod, Heading, ModelAnimation, ObjectSettings, Part,
    Preference, Settings, Show, Start, Strategy,
};

/// Why rows of the picture have no effect in some views, with the titles of these.
static NO_POINTS: LazyLock<String> = LazyLock::new(|| {
    let views = Show::titles(|show| show.has(Part::Points));
    format!("Only the views {views} draw points.")
});
static NO_CHARTS: LazyLock<String> = LazyLock::new(|| {
    let views = Show::titles(|show| !show.has_charts());
    format!("The views {views} do not have it.")
});
static OWN_COLORS: LazyLock<String> = LazyLock::new(|| {
    let views = Show::titles(|show| show.has(Part::OwnColors));
    format!("The views {views} have colours of their own.")
});
static NO_TRAIL: LazyLock<String> = LazyLock::new(|| {
    let views = Show::titles(|show| !show.has(Part::Trail) && !show.has(Part::OwnColors));
    format!("The views {views} do not show the trail.")
});
static NO_SCALE: LazyLock<String> = LazyLock::new(|| {
    let views = Show::titles(|show| !show.has(Part::Scale) && !show.has(Part::OwnColors));
    format!("The views {views} have no scale of colours.")
});

/// The change that the scene's parameter with this key needs to have an effect; `None` if it has one, and for
/// keys of objects.
#[must_use]
pub fn why_idle(key: &str, settings: &Settings) -> Option<&'static str> {
    let is_alone = settings.objects.len() < 2;
    let start = settings.particles.start;
    let strategy = settings.strategy();
    let because = |idle: bool, why: &'static str| idle.then_some(why);
    match key {
        "particles.start_object" => because(is_alone, ALONE),
        "particles.start_food" => {
            because(start != Start::Food, "Only the start food begins on food.")
        }
        "population.frequency" => None,
        _ if key.starts_with("population.") && !settings.population.is_on() => {
            Some("The number of particles is constant: raise Test frequency from 0.")
        }
        "population.hunger" => because(
            settings.food_count() == 0,
            "There is no food: put some on an object, or raise Scattered food from 0.",
        ),
        "physarum.reference_density" => because(
            settings.population.is_on(),
            "The number of particles changes: set Test frequency to 0.",
        ),
        "feeding.scattered" => None,
        "feeding.radius" | "feeding.strength" | "feeding.amount" | "feeding.size"
        | "feeding.projection" => because(
            settings.feeding.scattered == 0,
            "No food is scattered: raise Scattered food from 0.",
        ),
        "feeding.projection_covered" => because(
            !settings.projects(),
            "No food is projected into the trail: raise the projection of some from 0.",
        ),
        "feeding.scent_across" if is_alone => Some(ALONE),
        "feeding.scent_across" if settings.distance.reach == 0.0 => Some(UNSEEN),
        _ if key.starts_with("feeding.") => because(
            settings.food_count() == 0,
            "There is no food: put some on an object, or raise Scattered food from 0.",
        ),
        _ if key.starts_with("particles.start_") => why_start_idle(
            key.trim_start_matches("particles.start_"),
            start,
            settings.particles.start_heading,
        ),
        "picture.particle_size" => because(!settings.picture.show.has(Part::Points), &NO_POINTS),
        "picture.charts" => because(!settings.picture.show.has_charts(), &NO_CHARTS),
        "picture.color_map" | "picture.brightest" | "picture.darkest"
            if settings.picture.show.has(Part::OwnColors) =>
        {
            Some(&OWN_COLORS)
        }
        "picture.brightest" => because(!settings.picture.show.has(Part::Trail), &NO_TRAIL),
        "picture.darkest" => because(!settings.picture.show.has(Part::Scale), &NO_SCALE),
        "picture.background" | "picture.ground" => because(
            settings.picture.show.is_flat(),
            "The atlas has a ground of its own.",
        ),
        "picture.food" | "picture.areas" if settings.picture.show.is_flat() => {
            Some("The atlas does not show it.")
        }
        _ if key.starts_with("camera.") => because(
            settings.picture.show.is_flat(),
            "The atlas is flat, and seen without a camera.",
        ),
        "picture.light_azimuth"
        | "picture.light_elevation"
        | "picture.occlusion"
        | "picture.bloom"
        | "picture.wetness" => because(
            settings.picture.show.is_flat(),
            "The atlas is flat, and has no light.",
        ),
        "physarum.sensing" => because(
            settings
                .objects
                .iter()
                .any(|object| object.physarum.over(&settings.physarum).gravity_weight != 0.0),
            "With gravity all sensors walk: set the gravity weight to 0, objects' own ones too.",
        ),
        "physarum.favourite_density" => because(seeks_more(settings), SEEKS_MORE),
        "picture.food" => because(
            settings.food_count() == 0,
            "There is no food: put some on an object, or raise Scattered food from 0.",
        ),
        "trail.diffusion" => because(
            settings.holds_for_trails(|trail| trail.diffusion_length > 0.0),
            LENGTH_INSTEAD,
        ),
        "trail.decay" => because(
            settings.holds_for_trails(|trail| trail.half_life > 0.0),
            HALF_LIFE_INSTEAD,
        ),
        "trail.across" if is_alone => Some(ALONE),
        "trail.across" if settings.distance.reach == 0.0 => Some(UNSEEN),
        "trail.diffusion_distance" | "trail.across" => because(
            settings.holds_for_trails(|trail| !trail.spreads()),
            "Nothing diffuses: raise the trail diffusion, or the diffusion length, from 0.",
        ),
        "atlas.cell_size" => because(
            settings.atlas.method != AtlasMethod::Grid,
            "Only the atlas method grid has cells.",
        ),
        "time.dt" | "time.start" => because(
            settings
                .objects
                .iter()
                .all(|object| object.motion.is_still()),
            "No object moves.",
        ),
        "areas.strength" => because(settings.areas.map.is_empty(), "There is no area map."),
        "physarum.distance_weight" => because(is_alone, ALONE),
        "distance.depth" if !is_alone => because(
            settings.distance.method != DistanceMethod::Raster,
            NO_DEPTHS,
        ),
        "distance.depth_near" | "distance.depth_scale" if !is_alone => {
            why_depth_idle(key, settings)
        }
        "transfer.respawn" if !is_alone => because(
            strategy != Strategy::Respawn,
            "Particles do not restart: choose the transfer strategy respawn.",
        ),
        "transfer.threshold" if settings.trail_crosses() => None,
        "transfer.threshold" | "transfer.buffer_size" if !is_alone => because(
            strategy == Strategy::None,
            "Particles do not change objects: choose another transfer strategy.",
        ),
        _ => because(
            is_alone && (key.starts_with("transfer.") || key.starts_with("distance.")),
            ALONE,
        ),
    }
}

const ALONE: &str = "There is only one object.";
const LENGTH_INSTEAD: &str = "The diffusion length takes its place: set that to 0.";
const HALF_LIFE_INSTEAD: &str = "The half-life takes its place: set that to 0.";
const UNSEEN: &str = "Objects do not see each other: raise the distance reach from 0.";
const NO_DEPTHS: &str = "Only the distance method raster has depths.";

/// Why a length of the mapping from distances to depths has no effect.
fn why_depth_idle(key: &str, settings: &Settings) -> Option<&'static str> {
    if settings.distance.method != DistanceMethod::Raster {
        return Some(NO_DEPTHS);
    }
    let depth = settings.distance.depth;
    let is_curve = matches!(depth, DepthMapping::Logistic | DepthMapping::Arctangent);
    let (idle, why) = match key {
        "distance.depth_near" => (
            depth != DepthMapping::Clip,
            "Only the distance depth clip has a near plane.",
        ),
        _ => (
            !is_curve,
            "Only the distance depths logistic and arctangent have a scale.",
        ),
    };
    idle.then_some(why)
}

const SEEKS_MORE: &str =
    "By the trail preference more, no density is a favourite: choose auto or favourite.";

fn seeks_more(settings: &Settings) -> bool {
    settings.physarum.preference == Preference::More
}

/// Why a part of a start has no effect, for a start of this kind.
fn why_start_idle(part: &str, start: Start, heading: Heading) -> Option<&'static str> {
    let is_round = matches!(start, Start::Ring | Start::Disc);
    let has_centre = is_round || start == Start::Point;
    let looks_at_it = matches!(heading, Heading::Radial | Heading::Inward);
    let (idle, why) = match part {
        "at" => (
            !has_centre && !looks_at_it,
            "Only starts at a place have one, or headings away from it: choose the start point, ring or disc.",
        ),
        "radius" => (
            !is_round,
            "Only circles have a radius: choose the start ring or disc.",
        ),
        "mask" => (
            start != Start::Mask,
            "Only the start mask asks for a picture.",
        ),
        "direction" => (
            heading != Heading::Aligned,
            "Only the start heading aligned has a direction.",
        ),
        _ => (false, ""),
    };
    idle.then_some(why)
}

/// Why a key of an object has no effect, if it has none.
#[must_use]
pub fn why_object_idle(
    key: &str,
    object: &ObjectSettings,
    settings: &Settings,
) -> Option<&'static str> {
    let motion = &object.motion;
    let is_zero = |vector: [f32; 3]| vector == [0.0; 3];
    let follows = motion.model == ModelAnimation::Follow;
    let of_start = key.strip_prefix("start.");
    if let Some(part) = of_start.filter(|part| !["place", "share"].contains(part)) {
        let Some(start) = object.start.place.own() else {
            return Some("The object's particles begin as the scene says: choose an own start.");
        };
        return why_start_idle(part, start, object.start.heading);
    }
    let (idle, why) = match key {
        "texel_weight" if settings.objects.len() < 2 => (true, ALONE),
        "start.share" if settings.objects.len() < 2 => (true, ALONE),
        "start.share" => (
            !settings.has_start_shares(),
            "Particles begin at one place or on one object: choose the start uniform and no start object, or an own start.",
        ),
        "texel_weight" => (
            settings.atlas.method != AtlasMethod::Charts,
            "Only the atlas method charts shares texels out by weight.",
        ),
        "physarum.distance_weight" => (settings.objects.len() < 2, ALONE),
        "physarum.favourite_density" => (seeks_more(settings), SEEKS_MORE),
        "trail.diffusion" => (
            settings.trail_on(object).diffusion_length > 0.0,
            LENGTH_INSTEAD,
        ),
        "trail.decay" => (settings.trail_on(object).half_life > 0.0, HALF_LIFE_INSTEAD),
        "motion.orbit_center" => (is_zero(motion.orbit), "The object does not orbit."),
        "motion.swing_period" | "motion.swing_phase" => {
            (is_zero(motion.swing), "The object does not swing.")
        }
        "motion.slide_period" | "motion.slide_phase" => {
            (is_zero(motion.slide), "The object does not slide.")
        }
        "motion.pivot" => (
            is_zero(motion.spin) && is_zero(motion.swing),
            "The object neither spins nor swings.",
        ),
        "motion.repeat" | "motion.easing" | "motion.period" => (
            follows || motion.keyframes.is_empty(),
            "The object has no keyframes to follow.",
        ),
        _ => (false, ""),
    };
    idle.then_some(why)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS};
    use crate::scene::settings::{FoodSettings, ObjectStart, TrailAcross};

    fn idle(settings: &Settings) -> Vec<&'static str> {
        let keys = PARAMETERS.iter().map(|parameter| parameter.key);
        keys.filter(|key| why_idle(key, settings).is_some())
            .collect()
    }

    fn idle_of(object: usize, settings: &Settings) -> Vec<&'static str> {
        let keys = OBJECT_PARAMETERS.iter().map(|parameter| parameter.key);
        let object = &settings.objects[object];
        keys.filter(|key| why_object_idle(key, object, settings).is_some())
            .collect()
    }

    /// Each parameter has an effect after the change that its reason advises.
    #[test]
    fn what_has_no_effect_says_why_and_has_one_after_that() {
        let mut settings = Settings::default();
        let alone = idle(&settings);
        for key in [
            "transfer.strategy",
            "distance.reach",
            "time.dt",
            "atlas.cell_size",
            "feeding.scent_across",
            "trail.across",
        ] {
            assert!(alone.contains(&key), "{key}");
        }
        for key in ["physarum.speed", "trail.decay", "seed", "particles.count"] {
            assert!(!alone.contains(&key), "{key}");
        }
        settings.objects.push(ObjectSettings::default());
        settings.transfer.strategy = Strategy::None;
        let apart = idle(&settings);
        assert!(apart.contains(&"transfer.threshold") && !apart.contains(&"transfer.strategy"));
        assert!(apart.contains(&"transfer.buffer_size"));
        settings.trail.across = TrailAcross::On;
        assert!(!idle(&settings).contains(&"transfer.threshold"));
        settings.trail.across = TrailAcross::Off;
        // Every selected particle takes a place in the list, also with strategies without waiting.
        for strategy in [Strategy::Direct, Strategy::Respawn] {
            settings.transfer.strategy = strategy;
            assert!(!idle(&settings).contains(&"transfer.buffer_size"));
            let restarts = strategy == Strategy::Respawn;
            assert_eq!(idle(&settings).contains(&"transfer.respawn"), !restarts);
        }
        assert!(idle(&settings).contains(&"areas.strength"));
        "walls.png".clone_into(&mut settings.areas.map);
        settings.transfer.strategy = Strategy::Parallel;
        settings.distance.method = DistanceMethod::Raster;
        settings.atlas.method = AtlasMethod::Grid;
        settings.particles.start = Start::Ring;
        settings.particles.start_heading = Heading::Aligned;
        settings.objects[0].motion.spin = [0.0, 90.0, 0.0];
        assert!(idle(&settings).contains(&"population.capacity"));
        settings.population.frequency = 5;
        let waits = idle(&settings);
        assert!(waits.contains(&"population.hunger") && !waits.contains(&"population.capacity"));
        settings.picture.show = Show::Particles;
        settings.foods.push(FoodSettings::default());
        let waits = idle(&settings);
        assert!(waits.contains(&"feeding.size") && !waits.contains(&"feeding.fed_steps"));
        assert!(waits.contains(&"feeding.projection_covered"));
        settings.feeding.projection = 3.0;
        assert!(idle(&settings).contains(&"feeding.projection_covered"));
        settings.feeding.scattered = 2;
        assert_eq!(
            idle(&settings),
            [
                "particles.start_food",
                "particles.start_mask",
                "physarum.reference_density",
                "distance.depth_near",
                "distance.depth_scale",
                "transfer.respawn",
                "picture.brightest",
                "picture.darkest"
            ],
            "all others have an effect"
        );
        settings.particles.start = Start::Mask;
        assert_eq!(
            idle(&settings),
            [
                "particles.start_at",
                "particles.start_radius",
                "particles.start_food",
                "physarum.reference_density",
                "distance.depth_near",
                "distance.depth_scale",
                "transfer.respawn",
                "picture.brightest",
                "picture.darkest"
            ]
        );
        settings.particles.start_heading = Heading::Radial;
        assert_eq!(
            idle(&settings),
            [
                "particles.start_radius",
                "particles.start_food",
                "particles.start_direction",
                "physarum.reference_density",
                "distance.depth_near",
                "distance.depth_scale",
                "transfer.respawn",
                "picture.brightest",
                "picture.darkest"
            ]
        );
        settings.particles.start_heading = Heading::Auto;
        settings.trail.diffusion = 0.0;
        settings.particles.start = Start::Point;
        assert_eq!(
            idle(&settings),
            [
                "particles.start_radius",
                "particles.start_food",
                "particles.start_mask",
                "particles.start_direction",
                "physarum.reference_density",
                "trail.diffusion_distance",
                "trail.across",
                "distance.depth_near",
                "distance.depth_scale",
                "transfer.respawn",
                "picture.brightest",
                "picture.darkest"
            ]
        );
    }

    /// Would catch: a length of a mapping that is greyed out with the mapping that it is for.
    #[test]
    fn mappings_of_depths_have_lengths_of_their_own() {
        let mut settings = Settings::default();
        settings.objects.push(ObjectSettings::default());
        let keys = ["distance.depth_near", "distance.depth_scale"];
        let of = |settings: &Settings| keys.map(|key| why_idle(key, settings));
        assert_eq!(of(&settings), [Some(NO_DEPTHS); 2]);
        settings.distance.method = DistanceMethod::Raster;
        for (depth, near, scale) in [
            (DepthMapping::Ordered, true, true),
            (DepthMapping::Clip, false, true),
            (DepthMapping::Logistic, true, false),
            (DepthMapping::Arctangent, true, false),
            (DepthMapping::Linear, true, true),
        ] {
            settings.distance.depth = depth;
            assert_eq!(of(&settings).map(|why| why.is_some()), [near, scale]);
        }
        settings.objects.pop();
        assert_eq!(of(&settings), [Some(ALONE); 2]);
    }

    #[test]
    fn what_a_view_has_not_is_said_by_the_titles_of_such_views() {
        let why = |key: &str, show: Show| {
            let mut settings = Settings::default();
            settings.picture.show = show;
            why_idle(key, &settings)
        };
        let points = why("picture.particle_size", Show::Glow).unwrap();
        assert!(points.starts_with("Only the views Particles"), "{points}");
        for (key, show, end) in [
            ("charts", Show::Wireframe, "do not have it."),
            ("color_map", Show::Nearest, "have colours of their own."),
            ("brightest", Show::Density, "do not show the trail."),
            ("darkest", Show::Charts, "have no scale of colours."),
        ] {
            let text = why(&format!("picture.{key}"), show).unwrap();
            assert!(text.contains(show.title()), "{text}");
            assert!(!text.contains(Show::Relief.title()), "{text}");
            assert!(
                text.starts_with("The views ") && text.ends_with(end),
                "{text}"
            );
        }
    }

    #[test]
    fn views_and_gravity_leave_some_without_effect() {
        let mut settings = Settings::default();
        let of = |settings: &Settings, keys: [&'static str; 6]| {
            keys.map(|key| why_idle(key, settings).is_some())
        };
        let keys = [
            "picture.color_map",
            "picture.brightest",
            "picture.light_azimuth",
            "picture.light_elevation",
            "picture.occlusion",
            "physarum.sensing",
        ];
        let [no, yes] = [false, true];
        assert_eq!(of(&settings, keys), [no; 6]);
        settings.picture.show = Show::Nearest;
        assert_eq!(of(&settings, keys), [yes, yes, no, no, no, no]);
        settings.picture.show = Show::Density;
        assert_eq!(of(&settings, keys), [no, yes, no, no, no, no]);
        settings.picture.show = Show::Atlas;
        assert_eq!(of(&settings, keys), [no, no, yes, yes, yes, no]);
        let flat = [
            "picture.background",
            "picture.food",
            "picture.areas",
            "camera.azimuth",
            "camera.distance",
            "camera.field_of_view",
        ];
        assert_eq!(of(&settings, flat), [yes; 6]);
        settings.objects[0].physarum.gravity_weight = Some(2.0);
        assert!(of(&settings, keys)[5]);
        settings.physarum.gravity_weight = 2.0;
        settings.objects[0].physarum.gravity_weight = Some(0.0);
        assert!(!of(&settings, keys)[5], "no object has gravity");
    }

    /// Would catch: a favourite density that has no effect and does not say so.
    #[test]
    fn a_favourite_waits_for_a_preference() {
        let mut settings = Settings::default();
        for (preference, is_idle) in [
            (Preference::Auto, false),
            (Preference::More, true),
            (Preference::Favourite, false),
        ] {
            settings.physarum.preference = preference;
            let key = "physarum.favourite_density";
            let reasons = [
                why_idle(key, &settings),
                why_object_idle(key, &settings.objects[0], &settings),
            ];
            assert_eq!(reasons.map(|reason| reason.is_some()), [is_idle; 2]);
        }
    }

    /// Would catch: a scene's value that is greyed out although an object follows it, and an object's that has no effect and says nothing.
    #[test]
    fn trails_of_objects_have_lengths_and_half_lives_of_their_own() {
        let keys = ["trail.diffusion", "trail.decay"];
        let of_scene = |settings: &Settings| keys.map(|key| why_idle(key, settings).is_some());
        let of_object = |settings: &Settings, object: usize| {
            let object = &settings.objects[object];
            keys.map(|key| why_object_idle(key, object, settings).is_some())
        };
        let mut settings = Settings::default();
        settings.objects.push(ObjectSettings::default());
        settings.trail.diffusion_length = 0.01;
        settings.trail.half_life = 9.0;
        assert_eq!(of_scene(&settings), [true; 2]);
        assert_eq!(of_object(&settings, 1), [true; 2]);
        settings.objects[1].trail.diffusion_length = Some(0.0);
        settings.objects[1].trail.half_life = Some(0.0);
        assert_eq!(of_scene(&settings), [false; 2]);
        assert_eq!(of_object(&settings, 0), [true; 2]);
        assert_eq!(of_object(&settings, 1), [false; 2]);
        let distance = |settings: &Settings| why_idle("trail.diffusion_distance", settings);
        settings.trail.diffusion_length = 0.0;
        settings.trail.diffusion = 0.0;
        assert!(distance(&settings).is_some());
        settings.objects[0].trail.diffusion = Some(0.5);
        assert!(distance(&settings).is_none(), "one of them spreads");
    }

    #[test]
    fn parameters_of_objects_wait_for_the_motion_that_they_shape() {
        let mut settings = Settings::default();
        settings.objects.push(ObjectSettings::default());
        let motion = &mut settings.objects[1].motion;
        motion.orbit = [0.0, 1.0, 0.0];
        motion.swing = [1.0, 0.0, 0.0];
        motion.slide = [1.0, 0.0, 0.0];
        settings.objects[1].start.place = ObjectStart::Disc;
        settings.objects[1].start.heading = Heading::Aligned;
        assert_eq!(
            idle_of(1, &settings),
            [
                "start.mask",
                "motion.repeat",
                "motion.easing",
                "motion.period"
            ]
        );
        let still = idle_of(0, &settings);
        assert!(still.contains(&"motion.pivot") && still.contains(&"motion.orbit_center"));
        assert!(!still.contains(&"texel_weight") && !still.contains(&"motion.spin"));
        assert!(still.contains(&"start.at") && !still.contains(&"start.place"));
        // Shares take effect with the scene's start, or with any object's own.
        assert!(!still.contains(&"start.share"));
        settings.particles.start = Start::Ring;
        assert!(!idle_of(0, &settings).contains(&"start.share"));
        settings.objects[1].start.place = ObjectStart::Scene;
        assert!(idle_of(0, &settings).contains(&"start.share"));
    }
}
