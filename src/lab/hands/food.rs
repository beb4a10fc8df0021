//! Food and markers by hand: put on a surface, picked, changed and taken away.

use egui::{RichText, Slider, SliderClamping, Ui};
use glam::Vec3;
use myxo::scene::parameters::{FOOD_PARAMETERS, Kind};
use myxo::scene::settings::{FoodSettings, MOST_FOODS};

use super::super::interface::{Command, Facts, Interface};
use super::super::places::{Marked as _, note_value};
use super::super::theme;
use super::Under;

/// A click picks food that is so far from it for its size.
const NEAR: f32 = 1.5;

/// What the bar lets be changed of a food: key, name, what it is, and what its slider offers.
type Control = (&'static str, &'static str, &'static str, (f64, f64));
const CONTROLS: [Control; 4] = [
    (
        "strength",
        "strength",
        "What a sensor reads more where it lies, trail units; less than 0 repels",
        (-100.0, 100.0),
    ),
    (
        "radius",
        "reach",
        "How far along the surface sensors read it, scene radii",
        (0.02, 3.0),
    ),
    (
        "size",
        "size",
        "How far along the surface it is eaten, scene radii; 0 makes it a marker, which nobody eats",
        (0.0, 0.3),
    ),
    (
        "amount",
        "meals",
        "How many meals it is; 0: it never ends",
        (0.0, 1e6),
    ),
];

impl Interface {
    /// A click with the tool for food.
    pub(super) fn feed_at(
        &mut self,
        ctx: &egui::Context,
        under: Option<&Under>,
        facts: &Facts,
        commands: &mut Vec<Command>,
    ) {
        let Some(under) = under else {
            self.hands.food = None;
            return;
        };
        let near = nearest(&facts.hand.foods, under.position);
        if let Some(food) = near {
            if food < self.edited.foods.len() {
                self.hands.food = Some(food);
                self.hands.next_food = self.edited.foods[food].clone();
            } else {
                let text =
                    "This one is scattered: Scattered food, in the panel, says how many there are";
                self.notice(ctx, text, false);
            }
            return;
        }
        if self.edited.food_count() >= MOST_FOODS {
            let text = format!("There may be {MOST_FOODS} foods and markers: take some away first");
            self.notice(ctx, text, true);
            return;
        }
        let (Some(object), Some(pose)) = (
            self.running.objects.get(under.object),
            facts.hand.poses.get(under.object),
        ) else {
            return;
        };
        let at = pose.inverse().transform_point3(under.position) / object.scale;
        self.hands.food = Some(self.edited.foods.len());
        self.edited.foods.push(FoodSettings {
            object: object.name.clone(),
            at: at.to_array(),
            ..self.hands.next_food.clone()
        });
        commands.push(Command::Apply);
    }

    /// The picked food goes.
    pub(super) fn remove_food(&mut self, ctx: &egui::Context, commands: &mut Vec<Command>) {
        let picked = self.hands.food.take();
        let Some(food) = picked.filter(|food| *food < self.edited.foods.len()) else {
            self.notice(ctx, "Pick food first: click on it", false);
            return;
        };
        self.edited.foods.remove(food);
        commands.push(Command::Apply);
    }

    /// What the picked food is like, or the next one will be.
    pub(super) fn food_controls(&mut self, ui: &mut Ui, width: f32, commands: &mut Vec<Command>) {
        ui.spacing_mut().slider_width = width - 50.0;
        ui.spacing_mut().interact_size.x = 42.0;
        // Undo may have taken it away.
        self.hands.food = self
            .hands
            .food
            .filter(|food| *food < self.edited.foods.len());
        let title = match self.hands.food {
            Some(food) => format!("food {food}"),
            None => "next food".to_owned(),
        };
        ui.label(RichText::new(&title).small().strong());
        let picked = self.hands.food.map(|food| food.to_string());
        note_value(ui.ctx(), "picked.food", || picked.unwrap_or_default());
        note_value(ui.ctx(), "foods", || self.edited.foods.len().to_string());
        let food = match self.hands.food {
            Some(food) => &mut self.edited.foods[food],
            None => &mut self.hands.next_food,
        };
        let before = food.clone();
        for (key, name, hint, (least, most)) in CONTROLS {
            ui.label(RichText::new(name).small().color(theme::weak(ui)));
            let mut value = match key {
                "strength" => f64::from(food.strength),
                "radius" => f64::from(food.radius),
                "size" => f64::from(food.size),
                _ => f64::from(food.amount),
            };
            let is_whole = key == "amount";
            let slider = Slider::new(&mut value, least..=most)
                .logarithmic(is_whole || key == "radius")
                .smallest_positive(if is_whole { 1.0 } else { 0.001 })
                .max_decimals(if is_whole { 0 } else { 3 })
                .clamping(SliderClamping::Never)
                .update_while_editing(false);
            ui.add(slider)
                .on_hover_text(hint)
                .marked(&format!("food.{key}"));
            note_value(ui.ctx(), &format!("food.{key}"), || format!("{value}"));
            match key {
                "strength" => food.strength = value as f32,
                "radius" => food.radius = value as f32,
                "size" => food.size = value as f32,
                _ => food.amount = value.round() as u32,
            }
            keep_in_range(food, key);
        }
        if *food != before && self.hands.food.is_some() {
            self.hands.next_food = food.clone();
            commands.push(Command::Apply);
        }
        let remove = egui::Button::new("− food");
        let remove = ui
            .add_enabled(self.hands.food.is_some(), remove)
            .on_hover_text("Takes the picked food away (Delete)")
            .on_disabled_hover_text("Pick food first: click on it")
            .marked("food.remove");
        if remove.clicked() {
            let ctx = ui.ctx().clone();
            self.remove_food(&ctx, commands);
        }
    }
}

/// What was typed may lie beyond what is allowed.
fn keep_in_range(food: &mut FoodSettings, key: &str) {
    let parameter = FOOD_PARAMETERS
        .iter()
        .find(|parameter| parameter.key == key);
    if let Some(Kind::Number(number)) = parameter.map(|parameter| &parameter.kind) {
        let (least, most) = number.range;
        let value = (number.get)(food);
        if !number.allows(value) {
            (number.set)(food, value.clamp(least, most));
        }
    }
}

/// The food that lies at a place, if any does.
fn nearest(foods: &[(Vec3, f32)], place: Vec3) -> Option<usize> {
    let near = foods.iter().enumerate().filter_map(|(i, (at, size))| {
        let away = at.distance(place);
        (away <= NEAR * size).then_some((away, i))
    });
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_click_picks_the_nearest_food_that_it_touches() {
        let foods = [(Vec3::X, 0.1), (1.1 * Vec3::X, 0.1), (Vec3::Y, 0.02)];
        assert_eq!(nearest(&foods, 1.02 * Vec3::X), Some(0));
        assert_eq!(nearest(&foods, 1.08 * Vec3::X), Some(1));
        assert_eq!(nearest(&foods, 1.04 * Vec3::Y), None);
        assert_eq!(nearest(&[], Vec3::ZERO), None);
    }
}
