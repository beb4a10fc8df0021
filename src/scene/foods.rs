//! Checks of food and markers besides the ranges of their keys.

use super::error::SceneError;
use super::problems::{Problem, listed};
use super::settings::{MOST_FOODS, Settings, Start};

/// Fills in the name of the only object if it is left out, so that it stays right when objects are added.
pub(super) fn name(settings: &mut Settings) {
    if let [only] = &settings.objects[..] {
        let foods = settings.foods.iter_mut();
        for food in foods.filter(|food| food.object.is_empty()) {
            food.object.clone_from(&only.name);
        }
    }
}

/// Checks that each lies on an object, that there are not too many, and that their trail can be counted. Objects must have names.
pub(super) fn check(scene: &str, settings: &Settings) -> Result<(), SceneError> {
    let mut messages = problems(settings);
    messages.extend(start_problem(settings));
    SceneError::unless_empty(scene, messages.into_iter().map(Problem::from).collect())
}

/// All violations, one sentence each. The start is checked only if particles are about to begin.
#[must_use]
pub fn problems(settings: &Settings) -> Vec<String> {
    let mut messages = Vec::new();
    let count = settings.food_count();
    if count > MOST_FOODS {
        // With so many, the checks of single ones are skipped.
        messages.push(format!(
            "the scene has {count} foods and markers, and there may be {MOST_FOODS}: \
             take some out, or lower feeding.scattered"
        ));
    }
    let few = if count > MOST_FOODS {
        &[][..]
    } else {
        &settings.foods
    };
    for (i, food) in few.iter().enumerate() {
        if settings.object_of(food).is_some() {
            continue;
        }
        let names = settings.objects.iter().map(|object| object.name.as_str());
        let known = listed(names);
        messages.push(if food.object.is_empty() {
            format!("food.{i}.object is empty: name the object that it lies on; there is {known}")
        } else {
            format!(
                "food.{i}.object: there is no object \"{}\"; there is {known}",
                food.object
            )
        });
    }
    let most = u64::from(settings.slots()) * u64::from(settings.feeding.fed_deposit);
    if count > 0 && most > u64::from(u32::MAX) {
        messages.push(format!(
            "{} particles that each count as {} are more than a texel can count: lower feeding.fed_deposit",
            settings.slots(),
            settings.feeding.fed_deposit
        ));
    }
    messages
}

/// Is there no such food to begin on?
fn start_problem(settings: &Settings) -> Option<String> {
    let count = settings.food_count();
    let start = &settings.particles;
    if start.start != Start::Food || (start.start_food as usize) < count {
        return None;
    }
    Some(match count {
        0 => "particles.start = \"food\", and the scene has no food: add a [[food]], or raise feeding.scattered"
            .to_owned(),
        _ => format!(
            "particles.start_food = {}, and the scene has {count} foods and markers, counted from 0",
            start.start_food
        ),
    })
}
