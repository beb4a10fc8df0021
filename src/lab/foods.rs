//! Sections of the panel for foods and markers.

use egui::Ui;
use myxo::scene::parameters::FOOD_PARAMETERS;
use myxo::scene::settings::{FoodSettings, Settings};

use super::interface::Interface;
use super::panel::section;
use super::rows::{RowContext, row};

impl Interface {
    /// One for each food and marker that has a `[[food]]`; true if one was changed.
    pub(super) fn food_sections(&mut self, ui: &mut Ui, before: &Settings, filter: &str) -> bool {
        let mut changed = false;
        let new = FoodSettings::default();
        let count = self.edited.foods.len();
        for (i, food) in self.edited.foods.iter_mut().enumerate() {
            let loaded = as_loaded(&self.loaded.foods, i, food, count);
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
                    loaded: &loaded,
                    default: &new,
                    running: self.running.foods.get(i).unwrap_or(&new),
                    shared: &before.physarum,
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
}

/// What resets of a food return to: the scene's own one. Where foods have come or gone, that is the one that lay there; where
/// none did, a usual one in the place where it was put.
fn as_loaded(loaded: &[FoodSettings], i: usize, food: &FoodSettings, count: usize) -> FoodSettings {
    let same = if loaded.len() == count {
        loaded.get(i)
    } else {
        let lay_there = |old: &&FoodSettings| old.object == food.object && old.at == food.at;
        loaded.iter().find(lay_there)
    };
    same.cloned().unwrap_or_else(|| FoodSettings {
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
            at: [x, 0.0, 0.0],
            strength: 10.0 * x,
            ..FoodSettings::default()
        };
        let loaded = [at(1.0), at(2.0)];
        let mut moved = at(1.0);
        moved.at[1] = 5.0;
        assert_eq!(as_loaded(&loaded, 0, &moved, 2), loaded[0]);
        // The first has gone.
        assert_eq!(as_loaded(&loaded, 0, &at(2.0), 1), loaded[1]);
        // One was put by hand.
        let put = as_loaded(&loaded, 2, &at(3.0), 3);
        let usual = FoodSettings::default().strength;
        assert_eq!((put.at, put.strength), ([3.0, 0.0, 0.0], usual));
    }
}
