//! Parts of panels that egui does not have: wide sliders, the choice of colours, sections, hints beside tools.

use egui::{Color32, Id, Rect, RectAlign, Response, RichText, Sense, Slider, Tooltip, Ui, vec2};
use myxo::render::colormap::srgb_from_linear;
use myxo::scene::settings::ColorMap;

use crate::lab::places::Marked as _;

/// Width of the number beside a slider, points.
const VALUE_WIDTH: f32 = 74.0;

/// A slider as wide as the panel, its number at the right edge.
pub fn wide_slider(ui: &mut Ui, slider: Slider<'_>, parse: Parser) -> Response {
    ui.scope(|ui| {
        let gap = ui.spacing().item_spacing.x;
        ui.spacing_mut().slider_width = (ui.available_width() - VALUE_WIDTH - gap).max(60.0);
        ui.spacing_mut().interact_size.x = VALUE_WIDTH;
        // Without this 512 could not be typed if 16 is the minimum: 5 would become 16 at once.
        let parser = reader(ui, parse);
        ui.add(slider.custom_parser(parser).update_while_editing(false))
    })
    .inner
}

/// Shows the hint of a tool in the bar to its left, where it covers no other tool; `why_not` if the tool is disabled.
pub fn hint_beside(response: Response, text: &str, why_not: &str) -> Response {
    for (tooltip, text) in [
        (Tooltip::for_enabled(&response), text),
        (Tooltip::for_disabled(&response), why_not),
    ] {
        let mut tooltip = tooltip;
        tooltip.popup = tooltip.popup.align(RectAlign::LEFT_START);
        tooltip.show(|ui| {
            ui.set_max_width(ui.spacing().tooltip_width);
            ui.label(text);
        });
    }
    response
}

/// Shows what the pointer rests on in more detail, to its left, where it covers nothing beside it.
pub fn beside(response: Response, contents: impl FnOnce(&mut Ui)) -> Response {
    let mut tooltip = Tooltip::for_enabled(&response);
    tooltip.popup = tooltip.popup.align(RectAlign::LEFT_START);
    tooltip.show(contents);
    response
}

/// The key under which egui keeps the colour map that the pointer is on.
const POINTED: &str = "colours under the pointer";
/// The least size of a line in the list of colour maps, and the width of names in it, points.
const SWATCH: egui::Vec2 = vec2(220.0, 24.0);
const SWATCH_NAME: f32 = 84.0;

/// The key under which egui keeps the message on refused input.
const REFUSED: &str = "refused number";

/// Refuses typed input with this message.
pub fn refuse(ctx: &egui::Context, text: String) {
    ctx.data_mut(|data| data.insert_temp(Id::new(REFUSED), text));
}

/// Takes the message on refused input, once.
pub fn take_refused(ctx: &egui::Context) -> Option<String> {
    ctx.data_mut(|data| data.remove_temp(Id::new(REFUSED)))
}

/// The key under which egui keeps the pass in which a number was given up.
const GIVEN_UP: &str = "number given up";

/// Escape has left a field: a number that was typed into it is not taken. egui would take it in the next pass, in which the field still
/// counts as one that has just lost the keyboard.
pub fn give_up_number(ctx: &egui::Context) {
    let pass = ctx.cumulative_pass_nr();
    ctx.data_mut(|data| data.insert_temp(Id::new(GIVEN_UP), pass));
}

/// Was a number given up in this pass, or in the one before?
fn is_given_up(ctx: &egui::Context) -> bool {
    let pass = ctx.cumulative_pass_nr();
    let given_up = ctx.data(|data| data.get_temp::<u64>(Id::new(GIVEN_UP)));
    given_up.is_some_and(|given_up| pass <= given_up + 1)
}

/// Reads what is typed into a field of numbers. Other text is refused with a message, and the number stays unchanged.
pub fn reader(
    ui: &Ui,
    parse: impl Fn(&str) -> Option<f64> + 'static,
) -> impl Fn(&str) -> Option<f64> + 'static {
    let ctx = ui.ctx().clone();
    move |text| {
        if is_given_up(&ctx) {
            return None;
        }
        let number = parse(text);
        if number.is_none() && !text.trim().is_empty() {
            refuse(
                &ctx,
                format!("“{}” is no number: it stays as it was", text.trim()),
            );
        }
        number
    }
}

/// Reads what is typed as a number.
pub type Parser = fn(&str) -> Option<f64>;

/// Reads `1,234,567`, `1_234_567`, `2M`, and `0,5`, which some write for a half: one comma that groups no thousands is a
/// decimal point. Other text and infinite numbers are refused.
pub fn parse_number(text: &str) -> Option<f64> {
    parse(text, true)
}

/// Reads a count, for which `500,00` is a slip and not 500.
pub fn parse_whole(text: &str) -> Option<f64> {
    parse(text, false)
}

fn parse(text: &str, has_decimal_commas: bool) -> Option<f64> {
    let text: String = text
        .chars()
        .filter(|c| *c != '_' && !c.is_whitespace())
        .map(|c| if c == '\u{2212}' { '-' } else { c })
        .collect();
    let (digits, factor) = match text.strip_suffix(['k', 'K']) {
        Some(digits) => (digits, 1e3),
        None => text
            .strip_suffix(['m', 'M'])
            .map_or((text.as_str(), 1.0), |digits| (digits, 1e6)),
    };
    let whole = digits.split('.').next().unwrap_or_default();
    let mut groups = whole.split(',');
    let first = groups.next().unwrap_or_default();
    let first = first.trim_start_matches(['-', '+']);
    let are_thousands = !digits[whole.len()..].contains(',')
        && (1..=3).contains(&first.len())
        && !first.starts_with('0')
        && groups.all(|group| group.len() == 3 && group.bytes().all(|c| c.is_ascii_digit()));
    let plain = match digits.matches(',').count() {
        0 => digits.to_owned(),
        _ if are_thousands => digits.replace(',', ""),
        1 if has_decimal_commas && !digits.contains('.') => digits.replace(',', "."),
        _ => return None,
    };
    let number = factor * plain.parse::<f64>().ok()?;
    number.is_finite().then_some(number)
}

/// Every colour map as a strip of its colours.
pub fn color_map_picker(ui: &mut Ui, chosen: &mut ColorMap) {
    egui::ComboBox::from_id_salt("color map")
        .width(ui.available_width())
        .height(420.0)
        .selected_text(chosen.word())
        .show_ui(ui, |ui| {
            for map in ColorMap::ALL {
                let swatch = swatch(ui, *map, *chosen == *map);
                if swatch.hovered() {
                    ui.ctx()
                        .data_mut(|data| data.insert_temp(Id::new(POINTED), *map));
                }
                if swatch.marked(&format!("colors={}", map.word())).clicked() {
                    *chosen = *map;
                }
            }
        })
        .response
        .on_hover_text("Colours of the trail (C for the next)")
        .marked("colors");
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 6.0), Sense::hover());
    color_strip(ui, rect, *chosen);
}

/// Takes the colour map that the pointer was on, once.
pub fn take_pointed(ctx: &egui::Context) -> Option<ColorMap> {
    ctx.data_mut(|data| data.remove_temp(Id::new(POINTED)))
}

/// A line of the list of colour maps: its name, and all its colours.
fn swatch(ui: &mut Ui, map: ColorMap, is_chosen: bool) -> Response {
    let size = vec2(ui.available_width().max(SWATCH.x), SWATCH.y);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::WidgetType::Button, true, is_chosen, map.word())
    });
    let visuals = ui.style().interact_selectable(&response, is_chosen);
    if is_chosen || response.hovered() || response.has_focus() {
        ui.painter().rect_filled(rect, 4.0, visuals.weak_bg_fill);
    }
    let at = rect.left_center() + vec2(6.0, 0.0);
    let font = egui::TextStyle::Button.resolve(ui.style());
    let (left, color) = (egui::Align2::LEFT_CENTER, visuals.text_color());
    ui.painter().text(at, left, map.word(), font, color);
    let mut strip = rect.shrink2(vec2(6.0, 5.0));
    strip.min.x += SWATCH_NAME;
    color_strip(ui, strip, map);
    response
}

fn color_strip(ui: &Ui, rect: Rect, map: ColorMap) {
    let parts = 48;
    let mut mesh = egui::Mesh::default();
    for i in 0..=parts {
        let share = i as f32 / parts as f32;
        let [r, g, b] = map
            .color(share)
            .to_array()
            .map(|c| (255.0 * srgb_from_linear(c)).round() as u8);
        let x = rect.left() + share * rect.width();
        for y in [rect.top(), rect.bottom()] {
            mesh.colored_vertex(egui::pos2(x, y), Color32::from_rgb(r, g, b));
        }
        if i > 0 {
            let k = 2 * i;
            mesh.add_triangle(k - 2, k - 1, k);
            mesh.add_triangle(k - 1, k, k + 1);
        }
    }
    ui.painter().add(mesh);
}

/// A part of the panel under a title that opens and closes it; `found` holds it open, because it has what was looked
/// for, and leaves it afterwards as it was before.
pub fn section(ui: &mut Ui, title: &str, open: bool, found: bool, contents: impl FnOnce(&mut Ui)) {
    section_with(ui, title, open, found, false, contents);
}

/// A section that can also be opened from elsewhere.
pub fn section_with(
    ui: &mut Ui,
    title: &str,
    open: bool,
    found: bool,
    opens: bool,
    contents: impl FnOnce(&mut Ui),
) -> egui::CollapsingResponse<()> {
    let mut shown = egui::CollapsingHeader::new(RichText::new(title).strong())
        .id_salt((title, found))
        .default_open(open)
        .open((found || opens).then_some(true))
        .show_unindented(ui, |ui| {
            ui.add_space(2.0);
            contents(ui);
            ui.add_space(6.0);
        });
    shown.header_response = shown.header_response.marked(&format!("section={title}"));
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_people_write_them_or_not_at_all() {
        for (text, value) in [
            ("500,000", 5e5),
            ("1_000_000", 1e6),
            ("-1,234,567.5", -1_234_567.5),
            ("2M", 2e6),
            ("1.5k", 1500.0),
            ("12", 12.0),
            ("0.25", 0.25),
            ("1e-3", 1e-3),
            ("\u{2212} 3", -3.0),
            ("0,5", 0.5),
            ("0,500", 0.5),
            ("-1,5", -1.5),
            ("12,3456", 12.3456),
            (",25", 0.25),
            ("1,5k", 1500.0),
            ("1,500", 1500.0),
        ] {
            assert_eq!(parse_number(text), Some(value), "{text}");
        }
        for text in ["500,00", "10,0000", "0,5"] {
            assert_eq!(parse_whole(text), None, "{text}");
        }
        assert_eq!(parse_whole("1,500,000"), Some(1.5e6));
        for text in [
            "many",
            "",
            "k",
            "nan",
            "inf",
            "-inf",
            "1e400",
            "2e308k",
            "12,34,567",
            "1.000,5",
            "1,000.5,0",
            "0,5,5",
            ",",
        ] {
            assert_eq!(parse_number(text), None, "{text}");
        }
    }
}
