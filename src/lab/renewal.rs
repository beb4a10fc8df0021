//! What the hand has changed while the scene it works on was on its way once more: that is kept when the scene is there.

use myxo::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS};
use myxo::scene::settings::Settings;

use super::hands::place_among;

/// The settings that have arrived, with what differs between those that they were `asked` by and those that are `edited` now.
/// What belongs to an object that has not come, or has gone, is left.
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

#[cfg(test)]
mod tests {
    use super::super::hands::{with_object, without_object};
    use super::*;
    use glam::Vec3;
    use myxo::scene::settings::FoodSettings;

    fn food(object: &str) -> FoodSettings {
        FoodSettings {
            object: object.to_owned(),
            ..FoodSettings::default()
        }
    }

    #[test]
    fn what_the_hand_has_changed_meanwhile_is_kept() {
        let mut asked = with_object(&Settings::default(), "builtin:cube", 0.5, Vec3::X);
        for (object, name) in asked.objects.iter_mut().zip(["ring", "box"]) {
            object.name = name.to_owned();
        }
        asked.foods.push(food("box"));
        let mut arrived = with_object(&asked, "builtin:icosphere", 0.5, Vec3::Y);
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
        // What lies on an object that goes goes with it.
        let gone = without_object(&asked, 1);
        let kept = with_changes_since(&asked, &edited, &gone);
        assert_eq!(kept.foods, [food("ring")]);
        assert_eq!(kept.objects, gone.objects);
        assert!(kept.particles.start_object.is_empty());
    }
}
