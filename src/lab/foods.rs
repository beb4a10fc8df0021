//! Sections of the panel for foods and markers.

use egui::Ui;
use myxo::scene::parameters::FOOD_PARAMETERS;
use myxo::scene::settings::{FoodSettings, Settings};

use crate::lab::document::Document;
use crate::lab::rows::{RowContext, row};
use crate::lab::widgets::section;

/// One for each food and marker that has a `[[food]]`; true if one was changed.
pub(super) fn food_sections(
    ui: &mut Ui,
    document: &mut Document,
    before: &Settings,
    filter: &str,
) -> bool {
    let mut changed = false;
    let new = FoodSettings::default();
    let foods = &document.edited.foods;
    let loaded: Vec<_> = (0..foods.len())
        .map(|i| as_loaded(&document.loaded.foods, i, foods))
        .collect();
    for (i, food) in document.edited.foods.iter_mut().enumerate() {
        let parameters = FOOD_PARAMETERS.iter();
        let wanted = parameters.filter(|p| {
            filter.is_empty()
                || p.name.to_lowercase().contains(filter)
                || format!("food.{i}.{}", p.key).contains(filter)
        });
        let parameters: Vec<_> = wanted.collect();
        if parameters.is_empty() {
            continue;
        }
        let what = if food.is_marker() { "Marker" } else { "Food" };
        let title = format!("{what} {i}: {}", food.object);
        section(ui, &title, false, !filter.is_empty(), |ui| {
            let context = RowContext {
                loaded: &loaded[i],
                default: &new,
                running: document.running.foods.get(i).unwrap_or(&new),
                shared: before,
                objects: &before.objects,
                prefix: &format!("food.{i}."),
                idle: &|_| None,
            };
            for parameter in parameters {
                changed |= row(ui, parameter, food, &context);
            }
        });
    }
    changed
}

/// The food that a reset returns to: the scene's food in this place, or the one there before it was moved. For a food that the
/// user has put, it is the default food in its place.
fn as_loaded(loaded: &[FoodSettings], i: usize, foods: &[FoodSettings]) -> FoodSettings {
    let food = &foods[i];
    let lie_together = |a: &FoodSettings, b: &FoodSettings| a.object == b.object && a.at == b.at;
    let there = loaded.iter().find(|old| lie_together(old, food));
    // If none lies there, it is the food of the same index, provided that the number of foods is unchanged and no other food
    // matches that one.
    let same = loaded.get(i).filter(|old| {
        loaded.len() == foods.len() && !foods.iter().any(|food| lie_together(old, food))
    });
    there.or(same).cloned().unwrap_or_else(|| FoodSettings {
        object: food.object.clone(),
        at: food.at,
        ..FoodSettings::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foods_go_back_to_where_they_lay_and_not_to_where_others_did() {
        let at = |x: f32| FoodSettings {
            at: [x.into(), 0.0, 0.0],
            strength: 10.0 * x,
            ..FoodSettings::default()
        };
        let loaded = [at(1.0), at(2.0)];
        let mut moved = at(1.0);
        moved.at[1] = 5.0;
        assert_eq!(as_loaded(&loaded, 0, &[moved, at(2.0)]), loaded[0]);
        // The first is removed; then the user puts one, so that their number is the same as before.
        assert_eq!(as_loaded(&loaded, 0, &[at(2.0)]), loaded[1]);
        let foods = [at(2.0), at(3.0)];
        assert_eq!(as_loaded(&loaded, 0, &foods), loaded[1]);
        let put = as_loaded(&loaded, 1, &foods);
        let usual = FoodSettings::default().strength;
        assert_eq!((put.at, put.strength), ([3.0, 0.0, 0.0], usual));
    }
}
