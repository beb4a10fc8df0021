//! The tool for food and markers: puts them on a surface, picks, drags, changes and removes them.

use egui::{CursorIcon, Key, Pos2, Response, RichText, Slider, SliderClamping, Ui};
use glam::{Affine3A, Vec2, Vec3};
use myxo::scene::motion::{Origins, in_decimals};
use myxo::scene::parameters::{FOOD_PARAMETERS, Kind};
use myxo::scene::settings::{FoodSettings, MOST_FOODS, Settings};
use myxo::sim::types::Mark;

use super::super::objects::remove_food;
use crate::lab::actions::Action;
use crate::lab::command::Command;
use crate::lab::desk::Desk;
use crate::lab::document::Document;
use crate::lab::facts::Under;
use crate::lab::places::{Marked as _, note_value};
use crate::lab::renewal::place_among;
use crate::lab::theme;
use crate::lab::tools::grips::FoodDrag;
use crate::lab::tools::{Held, Tools};
use crate::lab::widgets::{parse_number, reader};

/// A click picks food that is so far from it for its size.
const NEAR: f32 = 1.5;
/// A marker that is not there yet is drawn so large, scene radii.
const LEAST_SIZE: f32 = 0.02;
/// The label of meals that never end.
const ENDLESS: &str = "∞";

/// A value of a food that the bar can change: key, name, description, and the range of its slider.
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
        "How far along the surface it is eaten, scene radii; 0 makes it a marker, which is not eaten",
        (0.0, 0.3),
    ),
    (
        "amount",
        "meals",
        "How many meals it is; ∞, typed as 0: it never ends",
        (0.0, 1e6),
    ),
];

impl Tools {
    /// A drag with the tool for food moves the food that it begins on. Returns true if the drag is used, so that the picture
    /// does not turn.
    pub(super) fn drag_food(
        &mut self,
        ui: &Ui,
        response: &Response,
        held: &Held,
        desk: &mut Desk<'_>,
    ) -> bool {
        let facts = desk.facts;
        let scale = ui.ctx().pixels_per_point();
        let to_pixel = |at: Pos2| {
            let from_corner = (at - response.rect.min) * scale;
            Vec2::new(from_corner.x, from_corner.y)
        };
        let release = held.release.filter(|at| response.rect.contains(*at));
        let release = release.map(to_pixel);
        let (is_drag, is_down) = (self.hold.is_drag(), self.hold.is_down());
        let under = facts.pointer.under.as_ref();
        let food = under.and_then(|under| nearest(&facts.pointer.foods, under.position));
        let food = food.filter(|food| *food < desk.document.edited.foods.len());
        if let Some(at) = held.press {
            let means_another = ui.input(|i| i.modifiers.shift || i.key_down(Key::L));
            self.food_drag = match means_another {
                true => FoodDrag::None,
                false => FoodDrag::Asks {
                    at: to_pixel(at),
                    waits: egui::Vec2::ZERO,
                    released: None,
                },
            };
        }
        if let FoodDrag::Asks {
            at,
            waits,
            released,
        } = self.food_drag
        {
            let waits = waits + self.drags.first;
            let released = released.or(release);
            if facts.pointer.looked != Some(at) {
                self.food_drag = FoodDrag::Asks {
                    at,
                    waits,
                    released,
                };
                self.pointer = Some(at);
                ui.ctx().request_repaint();
                return is_drag;
            }
            self.food_drag = match (food, released) {
                (Some(food), None) if is_down => FoodDrag::Holds(food),
                (Some(food), Some(to)) if is_drag => FoodDrag::Released(food, to),
                _ => FoodDrag::None,
            };
            if self.food_drag == FoodDrag::None {
                // The picture turns by all of it.
                self.drags.first = waits;
            }
        } else if let FoodDrag::Holds(food) = self.food_drag
            && !is_down
        {
            self.food_drag = match release {
                Some(to) if is_drag => FoodDrag::Released(food, to),
                _ => FoodDrag::None,
            };
        }
        match self.food_drag {
            FoodDrag::Holds(food) if is_drag => {
                ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
                self.put_food(food, under, desk);
            }
            FoodDrag::Released(food, to) if facts.pointer.looked == Some(to) => {
                self.put_food(food, under, desk);
                self.food_drag = FoodDrag::None;
                return true;
            }
            FoodDrag::Released(_, to) => {
                self.pointer = Some(to);
                ui.ctx().request_repaint();
            }
            FoodDrag::Holds(_) => ui.ctx().set_cursor_icon(CursorIcon::Grab),
            FoodDrag::None if food.is_some() && response.hovered() && !is_down => {
                ui.ctx().set_cursor_icon(CursorIcon::Grab);
            }
            _ => {}
        }
        is_drag && self.food_drag != FoodDrag::None
    }

    /// This food is picked, and lies where the pointer is.
    fn put_food(&mut self, food: usize, under: Option<&Under>, desk: &mut Desk<'_>) {
        let place = under.and_then(|under| self.place_under(under, desk));
        // The food may have been removed or undone since it was picked up.
        let (Some((object, at)), Some(held)) = (place, desk.document.edited.foods.get_mut(food))
        else {
            return;
        };
        if (&held.object, held.at) != (&object, at) {
            (held.object, held.at) = (object, at);
            desk.commands.push(Command::Apply);
        }
        self.next_food = held.clone();
        self.food = Some(food);
    }

    /// The object under the pointer, and the place on it in the coordinates of food.
    fn place_under(&self, under: &Under, desk: &Desk<'_>) -> Option<(String, [f64; 3])> {
        let facts = desk.facts;
        let object = desk.document.running.objects.get(under.object)?;
        let origins = facts.pointer.origins.get(under.object).copied();
        let at = under.in_object.as_dvec3();
        let at = origins.unwrap_or_default().to_file(at, object.scale);
        let at = in_decimals(at, facts.pointer.radius / object.scale);
        Some((object.name.clone(), at))
    }

    /// A click with the tool for food.
    pub(super) fn feed_at(
        &mut self,
        ctx: &egui::Context,
        under: Option<&Under>,
        desk: &mut Desk<'_>,
    ) {
        let facts = desk.facts;
        let Some(under) = under else {
            self.food = None;
            return;
        };
        let near = nearest(&facts.pointer.foods, under.position);
        if let Some(food) = near {
            if food < desk.document.edited.foods.len() {
                self.food = Some(food);
                self.next_food = desk.document.edited.foods[food].clone();
            } else {
                let text =
                    "This one is scattered: Scattered food, in the panel, says how many there are";
                desk.notices.say(ctx, text, false);
            }
            return;
        }
        if desk.document.edited.food_count() >= MOST_FOODS {
            let text = format!("There may be {MOST_FOODS} foods and markers: take some away first");
            desk.notices.say(ctx, text, false);
            return;
        }
        let Some((object, at)) = self.place_under(under, desk) else {
            return;
        };
        self.food = Some(desk.document.edited.foods.len());
        desk.document.edited.foods.push(FoodSettings {
            object,
            at,
            ..self.next_food.clone()
        });
        desk.commands.push(Command::Apply);
    }

    /// The picked food goes.
    pub(super) fn remove_food(&mut self, ctx: &egui::Context, desk: &mut Desk<'_>) {
        // Another one has its place then.
        self.let_food_go();
        let picked = self.food.take();
        let Some(food) = picked.filter(|food| *food < desk.document.edited.foods.len()) else {
            desk.notices.say(ctx, "Pick food first: click on it", false);
            return;
        };
        remove_food(&mut desk.document.edited, food);
        desk.commands.push(Command::Apply);
    }

    /// The foods were others `before`: the picked one stays picked, wherever it now stands in the list, or none is.
    pub fn follow_food(&mut self, before: &[FoodSettings], now: &[FoodSettings]) {
        let picked = self.food.filter(|food| *food < before.len());
        self.food = picked.and_then(|picked| {
            let lay = &before[picked];
            let lies_there = |food: &FoodSettings| (&food.object, food.at) == (&lay.object, lay.at);
            // Two may lie at one place. Of as many foods it is the one that has moved.
            let stays = now.get(picked).is_some_and(lies_there).then_some(picked);
            let place = || now.iter().position(lies_there);
            let moved = || (now.len() == before.len()).then_some(picked);
            stays.or_else(place).or_else(moved)
        });
    }

    /// The simulation refuses this food: the running food is set again, unless the user has set other food since.
    pub fn take_food_back(&mut self, refused: &Settings, document: &mut Document) {
        document.undo.forget_food(refused, &document.running);
        let Settings { foods, feeding, .. } = &mut document.edited;
        if (&*foods, &*feeding) != (&refused.foods, &refused.feeding) {
            return;
        }
        foods.clone_from(&document.running.foods);
        *feeding = document.running.feeding.clone();
        self.food = self.food.filter(|food| *food < foods.len());
        if let Some(food) = self.food {
            // Or the next one would be refused, too.
            self.next_food = foods[food].clone();
        }
    }

    /// Controls of the picked food, or of the next one.
    pub(super) fn food_controls(&mut self, ui: &mut Ui, width: f32, desk: &mut Desk<'_>) {
        ui.spacing_mut().slider_width = width - 50.0;
        ui.spacing_mut().interact_size.x = 42.0;
        // Undo may have taken it away.
        self.food = self
            .food
            .filter(|food| *food < desk.document.edited.foods.len());
        // A change takes a moment to arrive in the simulation.
        let is_coming = desk.document.edited.foods != desk.document.running.foods;
        let title = match self.food {
            Some(food) if is_coming => format!("food {food} …"),
            Some(food) => format!("food {food}"),
            None => "next food".to_owned(),
        };
        ui.label(RichText::new(&title).small().strong());
        let picked = self.food.map(|food| food.to_string());
        note_value(ui.ctx(), "picked.food", || picked.unwrap_or_default());
        note_value(ui.ctx(), "foods", || {
            desk.document.edited.foods.len().to_string()
        });
        note_value(ui.ctx(), "foods.there", || {
            let there = if is_coming { "coming" } else { "all" };
            there.to_owned()
        });
        let food = match self.food {
            Some(food) => &mut desk.document.edited.foods[food],
            None => &mut self.next_food,
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
                .custom_parser(reader(ui, |text| match text.trim() {
                    ENDLESS => Some(0.0),
                    text => parse_number(text),
                }))
                .update_while_editing(false);
            let slider = match is_whole {
                true => slider.custom_formatter(|value, _| meals(value)),
                false => slider,
            };
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
        if *food != before && self.food.is_some() {
            self.next_food = food.clone();
            desk.commands.push(Command::Apply);
        }
        let remove = egui::Button::new("− food");
        let remove = ui
            .add_enabled(self.food.is_some(), remove)
            .on_hover_text(Action::Remove.hint("Takes the picked food away"))
            .on_disabled_hover_text("Pick food first: click on it")
            .marked("food.remove");
        if remove.clicked() {
            let ctx = ui.ctx().clone();
            self.remove_food(&ctx, desk);
        }
    }
}

/// A number of meals as people read it.
fn meals(value: f64) -> String {
    match value {
        0.0 => ENDLESS.to_owned(),
        value => format!("{value:.0}"),
    }
}

/// A typed value may lie outside the allowed range.
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

/// Positions in world space and drawn sizes of the foods: those of `edited`, which need not be there yet, then the scattered
/// ones. `marks` begin with the foods that run, and `poses` are those that are drawn.
pub fn placed(
    edited: &Settings,
    running: &Settings,
    marks: &[Mark],
    origins: &[Origins],
    poses: &[Affine3A],
    radius: f32,
) -> Vec<(Vec3, f32)> {
    let at_mark = |mark: &Mark| {
        let pose = poses.get(mark.object as usize);
        let place = pose.map_or(mark.position, |pose| pose.transform_point3(mark.position));
        (place, mark.radius)
    };
    let by_hand = edited.foods.iter().enumerate().map(|(i, food)| {
        let same = |other: &FoodSettings| (other.at, &other.object) == (food.at, &food.object);
        let there = match running.foods.get(i) {
            Some(other) if same(other) => Some(i),
            _ => running.foods.iter().position(same),
        };
        if let Some(mark) = there.and_then(|there| marks.get(there)) {
            return at_mark(mark);
        }
        // An object that is being added has no place yet, and no pose.
        let object = edited.objects.get(edited.object_of(food).unwrap_or(0));
        let object = object
            .and_then(|object| place_among(&running.objects, object))
            .unwrap_or(usize::MAX);
        let scale = running.objects.get(object).map_or(1.0, |o| o.scale);
        let origins = origins.get(object).copied().unwrap_or_default();
        let place = origins.from_file(food.at, scale);
        let pose = poses.get(object);
        let place = pose.map_or(place, |pose| pose.transform_point3(place));
        (place, food.size.max(LEAST_SIZE) * radius)
    });
    let scattered = marks.iter().skip(running.foods.len());
    by_hand.chain(scattered.map(at_mark)).collect()
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

    #[test]
    fn meals_that_never_end_are_no_zero() {
        assert_eq!((meals(0.0), meals(500.0)), ("∞".into(), "500".into()));
    }

    /// Food that was put, removed or refused may differ from the simulation's: an index always means the edited food.
    #[test]
    fn indices_are_those_of_edited_food_while_food_is_on_its_way() {
        let mut edited = Settings::default();
        edited.objects[0].scale = 2.0;
        let mut running = edited.clone();
        // A larger one is on its way, and drawn as large already.
        edited.objects[0].scale = 3.0;
        let food = |x: f32| FoodSettings {
            at: [x.into(), 0.0, 0.0],
            size: 0.1,
            ..FoodSettings::default()
        };
        let mark = |x: f32| Mark {
            position: x * Vec3::X,
            object: 0,
            normal: Vec3::X,
            radius: 0.25,
            is_food: 1,
            pad0: 0,
            pad1: 0,
            pad2: 0,
        };
        let poses = [Affine3A::from_translation(Vec3::Y)];
        running.foods = vec![food(1.0), food(2.0)];
        let marks = [mark(2.1), mark(4.1), mark(7.0)];
        let mut places = |foods: &[FoodSettings]| {
            edited.foods = foods.to_vec();
            placed(&edited, &running, &marks, &[], &poses, 3.0)
        };
        let at = |x: f32, size: f32| (Vec3::new(x, 1.0, 0.0), size);
        assert_eq!(places(&running.foods), [2.1, 4.1, 7.0].map(|x| at(x, 0.25)));
        // The first is taken away, one is put: scattered ones come after those.
        assert_eq!(
            places(&[food(2.0), food(3.0)]),
            [at(4.1, 0.25), at(6.0, 0.3), at(7.0, 0.25)]
        );
        assert_eq!(places(&[]), [at(7.0, 0.25)]);
    }
}
