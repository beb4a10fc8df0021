//! One row for each parameter of the table: name, unit, slider, what it does, whether it restarts, and its default.

use std::ops::RangeInclusive;

use egui::{
    Align, Id, Label, Layout, RichText, Sense, Slider, SliderClamping, Ui, UiBuilder, vec2,
};
use myxo::plain_text::with_commas;
use myxo::scene::parameters::{Effect, Kind, Number, Own, Parameter, Scale};
use myxo::scene::settings::{ObjectSettings, Settings};

use crate::lab::opening::OPEN_MASK;
use crate::lab::places::{Marked as _, note_value};
use crate::lab::theme;
use crate::lab::widgets::{parse_number, parse_whole, reader, refuse, wide_slider};

/// The key of the object that all particles begin on, and the label without one.
const START_OBJECT: &str = "particles.start_object";
const ALL: &str = "all objects";

/// The key under which egui keeps the row whose picture is to be chosen, until the window asks for it.
const WANTED: &str = "wanted mask";

/// The context of a row besides its parameter.
#[derive(Clone, Copy)]
pub struct RowContext<'a, T> {
    /// The scene as it was loaded: what a reset returns to.
    pub loaded: &'a T,
    /// The default for scenes without the key.
    pub default: &'a T,
    /// The values that the simulation runs with.
    pub running: &'a T,
    /// The scene, whose values objects share unless they have their own.
    pub shared: &'a Settings,
    /// The objects that a row can name.
    pub objects: &'a [ObjectSettings],
    /// The prefix of the controls' names, for tests.
    pub prefix: &'a str,
    /// The reason why a key has no effect at present, if it has none.
    pub idle: &'a dyn Fn(&str) -> Option<&'static str>,
}

/// Shows a parameter and lets it be changed; true if it was.
pub fn row<T>(
    ui: &mut Ui,
    parameter: &Parameter<T>,
    value: &mut T,
    context: &RowContext<'_, T>,
) -> bool {
    let key = format!("{}{}", context.prefix, parameter.key);
    row_with(ui, parameter, value, context, |ui, value| {
        editor(ui, &key, parameter, value, context)
    })
}

/// A row with a line of its own below the name; `edit` returns whether that line has changed the value.
pub fn row_with<T>(
    ui: &mut Ui,
    parameter: &Parameter<T>,
    value: &mut T,
    context: &RowContext<'_, T>,
    edit: impl FnOnce(&mut Ui, &mut T) -> bool,
) -> bool {
    let mut changed = false;
    let modified = parameter.differs(value, context.loaded);
    let pending = parameter.restarts(context.running, value);
    let idle = (context.idle)(parameter.key);
    let key = format!("{}{}", context.prefix, parameter.key);
    // The id does not depend on rows that come and go above, because a number that is being typed would lose the keyboard.
    let builder = UiBuilder::new().id(Id::new(("row", &key)));
    let shown = ui.scope_builder(builder.sense(Sense::click()), |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 5.0;
            let name = RichText::new(parameter.name);
            let name = match (idle, pending, modified) {
                (Some(_), ..) => name.color(theme::weak(ui)),
                (None, true, _) => name.color(theme::pending(ui)),
                (None, false, true) => name.color(theme::accent(ui)),
                _ => name,
            };
            // A label that can be selected would take the click from the row.
            ui.add(Label::new(name).selectable(false))
                .marked(&format!("{key}:name"))
                .on_hover_ui(|ui| explain(ui, parameter, context, idle));
            if !parameter.unit.is_empty() {
                let unit = RichText::new(parameter.unit).small();
                let unit = unit.color(theme::weak(ui));
                ui.add(Label::new(unit).selectable(false));
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if modified {
                    let reset = ui
                        .small_button("↺")
                        .on_hover_text(format!("Back to {}", parameter.value(context.loaded)))
                        .marked(&format!("{key}:reset"));
                    if reset.clicked() {
                        parameter.copy(context.loaded, value);
                        changed = true;
                    }
                }
                if parameter.effect != Effect::Live {
                    let color = if pending {
                        theme::pending(ui)
                    } else {
                        theme::weak(ui)
                    };
                    let mark = RichText::new("restarts").small().color(color);
                    ui.label(mark)
                        .on_hover_text("A change restarts the simulation.");
                }
            });
        });
        let editor = ui.add_enabled_ui(idle.is_none(), |ui| edit(ui, value));
        changed |= editor.inner;
        note_value(ui.ctx(), &key, || parameter.value(value));
        if let Some(why) = idle {
            editor.response.on_disabled_hover_text(why);
        }
        ui.add_space(1.0);
    });
    shown.response.context_menu(|ui| {
        let ways = [
            ("As in the scene", "scene", context.loaded),
            ("Default", "default", context.default),
        ];
        for (what, name, from) in ways {
            let text = format!("{what} ({})", shown_value(parameter, from));
            let way = ui.add_enabled(parameter.differs(value, from), egui::Button::new(text));
            if way.marked(&format!("{key}:{name}")).clicked() {
                parameter.copy(from, value);
                changed = true;
            }
        }
    });
    changed
}

/// A value as people read it.
fn shown_value<T>(parameter: &Parameter<T>, of: &T) -> String {
    let value = parameter.value(of);
    if value.is_empty() {
        "empty".to_owned()
    } else {
        value
    }
}

/// The line below the name, by what the parameter holds.
pub fn editor<T>(
    ui: &mut Ui,
    key: &str,
    parameter: &Parameter<T>,
    value: &mut T,
    context: &RowContext<'_, T>,
) -> bool {
    match &parameter.kind {
        Kind::Number(number) => slider(ui, key, parameter, number, value),
        Kind::Own(own) => {
            let before = (own.get)(value);
            let shared = (own.shared)(context.shared);
            let after = own_slider(ui, key, own, before, shared);
            let after = after.map(|now| within(ui, parameter, now, own.range));
            if after != before {
                (own.set)(value, after);
            }
            after != before
        }
        Kind::Choice { words, get, set } => {
            let mut chosen = get(value);
            choose_word(ui, key, words, &mut chosen);
            let changed = chosen != get(value);
            if changed {
                set(value, chosen);
            }
            changed
        }
        Kind::Text { get, set, .. } if names_an_object(key) => {
            let mut chosen = get(value).to_owned();
            // A name that is typed would be refused until it is whole.
            choose_object(ui, key, context.objects, &mut chosen);
            let changed = chosen != get(value);
            if changed {
                set(value, chosen);
            }
            changed
        }
        Kind::Text { what, get, set, .. } => {
            let mut text = get(value).to_owned();
            let changed = text_field(ui, key, what, &mut text);
            if changed {
                set(value, text);
            }
            changed
        }
        Kind::Vector {
            range,
            is_double,
            get,
            set,
        } => {
            let before = get(value);
            let mut components = before;
            component_fields(ui, key, *range, *is_double, &mut components);
            if components != before {
                set(value, components);
            }
            // A value kept in single precision may be unchanged.
            get(value) != before
        }
    }
}

/// A number as usual, or where that would lose digits, with all it has: egui writes as many as single precision has.
fn in_full(number: f64, decimals: RangeInclusive<usize>) -> String {
    let usual = egui::emath::format_with_decimals_in_range(number, decimals);
    match usual.parse::<f64>() {
        Ok(read) if read == number => usual,
        _ => format!("{number}"),
    }
}

/// The number, or the end of the range that it lies beyond; a notice says that it was changed.
pub fn within<T>(ui: &Ui, parameter: &Parameter<T>, number: f64, range: (f64, f64)) -> f64 {
    let taken = number.clamp(range.0, range.1);
    if taken != number {
        let (name, allowed) = (parameter.name, parameter.allowed());
        let text = format!("{name} is {allowed}: {number} became {taken}");
        refuse(ui.ctx(), text);
    }
    taken
}

/// A button for each word of a list, of which one is chosen.
fn choose_word(ui: &mut Ui, key: &str, words: &[&str], chosen: &mut usize) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        for (i, word) in words.iter().enumerate() {
            ui.selectable_value(chosen, i, *word)
                .marked(&format!("{key}={word}"));
        }
    });
}

/// Does a row hold the name of an object?
fn names_an_object(key: &str) -> bool {
    key == START_OBJECT || key.starts_with("food.") && key.ends_with(".object")
}

fn choose_object(ui: &mut Ui, key: &str, objects: &[ObjectSettings], chosen: &mut String) {
    let all = (key == START_OBJECT).then_some("");
    let names = objects.iter().map(|object| object.name.as_str());
    let called = |name: &str| if name.is_empty() { ALL } else { name }.to_owned();
    egui::ComboBox::from_id_salt(key)
        .width(ui.available_width())
        .truncate()
        .selected_text(called(chosen))
        .show_ui(ui, |ui| {
            for name in all.into_iter().chain(names) {
                let item = ui.selectable_label(chosen == name, called(name));
                if item.marked(&format!("{key}={name}")).clicked() {
                    name.clone_into(chosen);
                }
            }
        })
        .response
        .marked(key);
}

/// A field for a text, with a button that opens a dialog where it is the path of a picture. Returns true if it was changed.
fn text_field(ui: &mut Ui, key: &str, what: &'static str, text: &mut String) -> bool {
    let mut edit = |ui: &mut Ui| {
        let editor = egui::TextEdit::singleline(text)
            .hint_text(what)
            .desired_width(f32::INFINITY);
        ui.add(editor).marked(key).changed()
    };
    if !names_a_mask(key) {
        return edit(ui);
    }
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    let layout = Layout::right_to_left(Align::Center);
    let both = |ui: &mut Ui| {
        let open = ui.button("Open…").on_hover_text(OPEN_MASK);
        if open.marked(&format!("{key}:open")).clicked() {
            ui.data_mut(|data| data.insert_temp(Id::new(WANTED), key.to_owned()));
        }
        edit(ui)
    };
    ui.allocate_ui_with_layout(size, layout, both).inner
}

/// Does a row hold the path of a picture that is laid over the texture?
fn names_a_mask(key: &str) -> bool {
    let maps = ["areas.map", "second_look.map"];
    key.ends_with("start_mask") || key.ends_with("start.mask") || maps.contains(&key)
}

/// The row whose picture is to be chosen, once.
pub fn take_wanted(ctx: &egui::Context) -> Option<String> {
    ctx.data_mut(|data| data.remove_temp(Id::new(WANTED)))
}

/// A field for each component of a vector.
fn component_fields(
    ui: &mut Ui,
    key: &str,
    range: (f64, f64),
    is_double: bool,
    components: &mut [f64; 3],
) {
    ui.horizontal(|ui| {
        let axes = ["x", "y", "z"];
        let labels = match key {
            "picture.background" => ["r ", "g ", "b "],
            _ => ["x ", "y ", "z "],
        };
        for ((component, axis), label) in components.iter_mut().zip(axes).zip(labels) {
            ui.add(
                egui::DragValue::new(component)
                    .range(range.0..=range.1)
                    .speed(0.01)
                    .custom_formatter(|number, decimals| match is_double {
                        true => in_full(number, decimals),
                        false => egui::emath::format_with_decimals_in_range(number, decimals),
                    })
                    .custom_parser(reader(ui, parse_number))
                    .update_while_editing(false)
                    .prefix(label),
            )
            .marked(&format!("{key}.{axis}"));
        }
    });
}

fn slider<T>(
    ui: &mut Ui,
    key: &str,
    parameter: &Parameter<T>,
    number: &Number<T>,
    value: &mut T,
) -> bool {
    let mut now = (number.get)(value);
    let (low, high) = number.slider;
    let slider = Slider::new(&mut now, low..=high)
        .logarithmic(number.scale == Scale::Logarithmic)
        .clamping(SliderClamping::Never);
    let (slider, parse) = with_steps(slider, number.integer, number.slider);
    let changed = wide_slider(ui, slider, parse).marked(key).changed();
    if changed {
        let now = within(ui, parameter, now, number.range);
        (number.set)(value, now);
    }
    changed
}

/// A switch for a value of an object's own, and its slider. Without one the `shared` value holds. Returns the own value, if any.
fn own_slider<T>(
    ui: &mut Ui,
    key: &str,
    own: &Own<T>,
    before: Option<f64>,
    shared: f64,
) -> Option<f64> {
    let mut has = before.is_some();
    let (low, high) = own.slider;
    // An own value begins as the value in effect.
    let mut now = before.unwrap_or(shared);
    theme::switch(ui, &mut has, "of its own")
        .on_hover_text("Otherwise the scene's value holds here too.")
        .marked(&format!("{key}:own"));
    if has {
        let slider = Slider::new(&mut now, low..=high)
            .logarithmic(own.scale == Scale::Logarithmic)
            .clamping(SliderClamping::Never);
        let (slider, parse) = with_steps(slider, own.integer, own.slider);
        wide_slider(ui, slider, parse).marked(key);
    }
    has.then_some(now)
}

/// A slider that stops at whole numbers, or at any, and how its text is read.
fn with_steps(
    slider: Slider<'_>,
    integer: bool,
    (low, high): (f64, f64),
) -> (Slider<'_>, fn(&str) -> Option<f64>) {
    if !integer {
        let slider = slider
            .max_decimals(6)
            .smallest_positive(smallest_positive(low, high));
        return (slider, parse_number);
    }
    let slider = slider.integer();
    if high > 10_000.0 {
        let slider = slider.custom_formatter(|value, _| with_commas(value));
        return (slider, parse_whole);
    }
    (slider, parse_whole)
}

/// The end of a logarithmic slider that begins at 0: four decades below its other end.
fn smallest_positive(low: f64, high: f64) -> f64 {
    if low > 0.0 { low } else { high * 1e-4 }
}

fn explain<T>(
    ui: &mut Ui,
    parameter: &Parameter<T>,
    context: &RowContext<'_, T>,
    idle: Option<&str>,
) {
    ui.set_max_width(300.0);
    if let Some(why) = idle {
        let text = format!("No effect as it is. {why}");
        ui.label(RichText::new(text).color(theme::pending(ui)));
    }
    ui.label(parameter.help);
    ui.add_space(4.0);
    let line = |ui: &mut Ui, what: &str, text: &str| {
        ui.horizontal(|ui| {
            ui.label(RichText::new(what).small().color(theme::weak(ui)));
            ui.label(RichText::new(text).small());
        });
    };
    line(ui, "allowed", &parameter.allowed());
    line(ui, "in the scene", &shown_value(parameter, context.loaded));
    line(ui, "default", &shown_value(parameter, context.default));
    line(ui, "key", parameter.key);
    if parameter.effect == Effect::Restart {
        ui.label(
            RichText::new("A change restarts the simulation.")
                .small()
                .color(theme::pending(ui)),
        );
    }
    if matches!(parameter.kind, Kind::Number(_)) {
        ui.label(
            RichText::new("Click the number to type one.")
                .small()
                .color(theme::weak(ui)),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_numbers_are_written_with_commas() {
        assert_eq!(with_commas(500_000.0), "500,000");
        assert_eq!(with_commas(999.0), "999");
        assert_eq!(with_commas(-1_234_567.0), "-1,234,567");
    }
}
