//! Keeps the changes that the user made while the scene was being loaded again.

use myxo::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS};
use myxo::scene::settings::{FoodSettings, ObjectSettings, ParticleSettings, Settings};

/// The settings that have arrived, with what differs between those that they were `asked` by and those that are `edited` now.
/// Changes of an object that has not come, or has gone, are dropped.
pub fn with_changes_since(asked: &Settings, edited: &Settings, arrived: &Settings) -> Settings {
    let mut settings = arrived.clone();
    for parameter in PARAMETERS {
        if parameter.differs(asked, edited) {
            parameter.copy(edited, &mut settings);
        }
    }
    for object in &mut settings.objects {
        let [was, is] = [asked, edited].map(|settings| {
            let place = place_among(&settings.objects, object);
            place.map(|place| &settings.objects[place])
        });
        let (Some(was), Some(is)) = (was, is) else {
            continue;
        };
        for parameter in OBJECT_PARAMETERS {
            if parameter.differs(was, is) {
                parameter.copy(is, object);
            }
        }
    }
    if edited.foods != asked.foods {
        settings.foods.clone_from(&edited.foods);
        let objects = &arrived.objects;
        let is_there = |name: &String| objects.iter().any(|object| object.name == *name);
        settings.foods.retain(|food| is_there(&food.object));
    }
    let start = &settings.particles.start_object;
    if !settings.objects.iter().any(|object| object.name == *start) {
        settings
            .particles
            .start_object
            .clone_from(&arrived.particles.start_object);
    }
    settings
}

/// The settings that run, with the objects that are edited and as large as these, whatever else waits for a restart.
pub fn renewed(live: &Settings, edited: &Settings) -> Settings {
    let mut settings = live.clone();
    settings.objects = as_many_and_as_large(&edited.objects, &live.objects);
    begin_where_they_are(&mut settings, live, &edited.particles);
    settings
}

/// Takes back objects that were to come, go or grow: the edited objects are the running ones again, with all other edits that
/// wait for a restart.
pub fn take_back(edited: &mut Settings, running: &Settings) {
    edited.objects = as_many_and_as_large(&running.objects, &edited.objects);
    let names: Vec<&String> = running.objects.iter().map(|object| &object.name).collect();
    let is_there = |food: &FoodSettings| food.object.is_empty() || names.contains(&&food.object);
    if !edited.foods.iter().all(is_there) {
        edited.foods.clone_from(&running.foods);
    }
    let was = edited.clone();
    begin_where_they_are(edited, &was, &running.particles);
}

/// These objects in these sizes, with all other settings of the others.
fn as_many_and_as_large(
    objects: &[ObjectSettings],
    others: &[ObjectSettings],
) -> Vec<ObjectSettings> {
    let as_others_have = |object: &ObjectSettings| match place_among(others, object) {
        Some(place) => ObjectSettings {
            scale: object.scale,
            ..others[place].clone()
        },
        None => object.clone(),
    };
    objects.iter().map(as_others_have).collect()
}

/// Particles may begin on an object that comes or goes: then they begin where `say` puts them.
fn begin_where_they_are(settings: &mut Settings, before: &Settings, say: &ParticleSettings) {
    let has = |settings: &Settings, name: &String| {
        name.is_empty() || settings.objects.iter().any(|object| object.name == *name)
    };
    let comes_back = !has(before, &say.start_object) && has(settings, &say.start_object);
    if comes_back || !has(settings, &settings.particles.start_object) {
        let start = &mut settings.particles.start_object;
        start.clone_from(&say.start_object);
    }
    if settings.particles.start_food as usize >= settings.food_count() {
        settings.particles.start_food = say.start_food;
    }
}

/// Do these differ only in what can change while they run, or waits for a restart?
pub fn are_built_alike(some: &[ObjectSettings], others: &[ObjectSettings]) -> bool {
    let alike = |(a, b): (&ObjectSettings, &ObjectSettings)| a.mesh == b.mesh && a.scale == b.scale;
    some.len() == others.len() && some.iter().zip(others).all(alike)
}

/// Which of them an object is, by name, if its mesh has not become another one.
pub fn place_among(objects: &[ObjectSettings], object: &ObjectSettings) -> Option<usize> {
    let is_it = |other: &ObjectSettings| other.name == object.name && other.mesh == object.mesh;
    objects.iter().position(is_it)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::objects::{with_object, without_object};

    fn food(object: &str) -> FoodSettings {
        FoodSettings {
            object: object.to_owned(),
            ..FoodSettings::default()
        }
    }

    #[test]
    fn changes_made_meanwhile_are_kept() {
        let mut asked = with_object(&Settings::default(), "builtin:cube", 0.5, [1.0, 0.0, 0.0]);
        for (object, name) in asked.objects.iter_mut().zip(["ring", "box"]) {
            object.name = name.to_owned();
        }
        asked.foods.push(food("box"));
        let mut arrived = with_object(&asked, "builtin:icosphere", 0.5, [0.0, 1.0, 0.0]);
        arrived.trail.decay = 0.25;
        assert_eq!(with_changes_since(&asked, &asked, &arrived), arrived);
        let mut edited = asked.clone();
        edited.physarum.speed *= 2.0;
        edited.particles.count += 1;
        edited.objects[1].position = [3.0, 0.0, 0.0];
        edited.foods.push(food("ring"));
        edited.particles.start_object = "box".to_owned();
        let kept = with_changes_since(&asked, &edited, &arrived);
        let wanted = Settings {
            trail: arrived.trail.clone(),
            objects: [&edited.objects[..], &arrived.objects[2..]].concat(),
            ..edited.clone()
        };
        assert_eq!(kept, wanted);
        // Food on an object that is removed is removed with it.
        let gone = without_object(&asked, 1);
        let kept = with_changes_since(&asked, &edited, &gone);
        assert_eq!(kept.foods, [food("ring")]);
        assert_eq!(kept.objects, gone.objects);
        assert!(kept.particles.start_object.is_empty());
    }

    #[test]
    fn edits_that_need_a_restart_wait_while_objects_come_go_and_grow() {
        let mut live = with_object(&Settings::default(), "builtin:cube", 0.5, [1.0, 0.0, 0.0]);
        for (object, name) in live.objects.iter_mut().zip(["ring", "box"]) {
            object.name = name.to_owned();
        }
        let mut edited = live.clone();
        edited.particles.count += 5;
        edited.objects[0].texel_weight = 4.0;
        edited.objects[1].scale *= 3.0;
        let scaled = edited.objects[1].scale;
        let renewed_to = renewed(&live, &edited);
        let mut wanted = live.clone();
        wanted.objects[1].scale = scaled;
        assert_eq!(renewed_to, wanted);
        // It did not come: only its size is as before.
        take_back(&mut edited, &live);
        assert_eq!(edited.objects[1].scale, live.objects[1].scale);
        assert_eq!(edited.objects[0].texel_weight, 4.0);
        assert_eq!(edited.particles.count, live.particles.count + 5);
        // An object that comes back brings the start on it back.
        let mut before = live.clone();
        before.particles.start_object = "box".to_owned();
        let gone = without_object(&before, 1);
        assert!(gone.particles.start_object.is_empty());
        assert_eq!(renewed(&gone, &before), before);
        let mut undone = before.clone();
        take_back(&mut undone, &gone);
        assert_eq!(undone, gone);
    }
}
