//! The parts of the panel that say what the picture shows, from where, and in which light.

use egui::{Align, Color32, Layout, Pos2, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};
use glam::{Vec2, Vec3};
use myxo::render::camera::Side;
use myxo::render::colormap::{above, srgb_from_linear};
use myxo::render::exposure::tone;
use myxo::render::hues::{hue_light, object_light};
use myxo::render::network_lines::{AT_FOOD, LINES, NODES};
use myxo::render::view::Light;
use myxo::scene::settings::{Legend, Show};

use crate::lab::actions::{Action, NO_LINES};
use crate::lab::desk::Desk;
use crate::lab::document::Document;
use crate::lab::facts::Facts;
use crate::lab::navigation::Navigation;
use crate::lab::network_overlay::color_of;
use crate::lab::places::{Marked as _, note_value};
use crate::lab::theme;
use crate::lab::view_rows::{CAMERA_ROWS, LIGHT_ROWS, view_rows};

/// Size of the ball that moves the light, points.
const BALL: f32 = 72.0;
/// What the network's lines are.
const LINES_HINT: &str = "The graph of the network over the picture: its lines, and where they meet or end, found once a second";
/// Objects that are named in the legend.
const NAMED: usize = 8;

/// Shows another view, if the scene has it.
pub(super) fn choose_view(ctx: &egui::Context, show: Show, desk: &mut Desk<'_>) {
    match show.why_not(&desk.document.running) {
        None => desk.document.view.show = show,
        Some(why) => {
            let text = format!("{} cannot be shown: {why}", show.title());
            desk.notices.say(ctx, text, false);
        }
    }
}

/// The list of views, the atlas beside the picture, the network's lines over it, and the legend of colours.
pub(super) fn views_list(ui: &mut Ui, desk: &mut Desk<'_>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(3.0, 3.0);
        for &show in Show::ALL {
            let why_not = show.why_not(&desk.document.running);
            let label = egui::Button::selectable(desk.document.view.show == show, show.title());
            let button = ui
                .add_enabled(why_not.is_none(), label)
                .on_hover_text(in_words(show));
            let button = match why_not {
                Some(why) => {
                    button.on_disabled_hover_text(format!("{}. Not here: {why}", in_words(show)))
                }
                None => button,
            };
            if button.marked(&format!("show={}", show.word())).clicked() {
                desk.document.view.show = show;
            }
        }
    });
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        let can_split = !desk.document.view.show.is_flat();
        let split = egui::Button::selectable(desk.layout.split, "Atlas beside");
        let split = ui
            .add_enabled(can_split, split)
            .on_hover_text(Action::Split.hint("The texture, unwrapped, beside the picture"))
            .on_disabled_hover_text("The picture is the atlas already.")
            .marked("split");
        if split.clicked() {
            desk.layout.split = !desk.layout.split;
        }
        let lines = egui::Button::selectable(desk.layout.network, "Network lines");
        let lines = ui
            .add_enabled(can_split, lines)
            .on_hover_text(Action::Network.hint(LINES_HINT))
            .on_disabled_hover_text(NO_LINES)
            .marked("network");
        if lines.clicked() {
            desk.layout.network = !desk.layout.network;
        }
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui
                .button("Fit")
                .on_hover_text(
                    Action::Fit.hint("The selected object, or the whole scene, into the picture"),
                )
                .marked("fit")
                .clicked()
            {
                desk.actions.push(Action::Fit);
            }
        });
    });
    legend(ui, desk.document, desk.facts);
    if desk.layout.network && !desk.document.view.show.is_flat() {
        network_key(ui, desk.facts);
    }
}

/// Squares in these colours, and what they mean.
fn key_line(ui: &mut Ui, colors: impl IntoIterator<Item = Color32>, text: &str) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for color in colors {
            let (rect, _) = ui.allocate_exact_size(vec2(12.0, 10.0), Sense::hover());
            ui.painter().rect_filled(rect, 2.0, color);
            // Pale colours are seen on a pale ground.
            let line = Stroke::new(1.0, theme::weak(ui));
            (ui.painter()).rect_stroke(rect, 2.0, line, egui::StrokeKind::Inside);
        }
        ui.add_space(3.0);
        ui.label(RichText::new(text).small().color(theme::weak(ui)));
    });
}

/// The key of the network's lines, and the measures of their graph.
fn network_key(ui: &mut Ui, facts: &Facts) {
    let at_food = (AT_FOOD, "at food");
    let has_food = !facts.pointer.foods.is_empty();
    let key = [(LINES, "edges"), (NODES, "nodes")];
    ui.horizontal(|ui| {
        for (color, text) in key.into_iter().chain(has_food.then_some(at_food)) {
            key_line(ui, [color_of(color)], text);
        }
    });
    let text = match &facts.network {
        Some(found) => found.text(),
        None if facts.runs_preview => "no lines while a look is previewed".to_owned(),
        None => "the network is being found".to_owned(),
    };
    ui.label(RichText::new(text).small().color(theme::weak(ui)))
        .on_hover_text(
            "Of the state at that step, as `myxo network` measures it. Lengths are in scene radii.",
        );
}

/// The legend of colours.
fn legend(ui: &mut Ui, document: &Document, facts: &Facts) {
    let line = |ui: &mut Ui, colors: &[Vec3], text: &str| {
        key_line(ui, colors.iter().map(|color| seen(*color)), text);
    };
    let map = document.view.color_map;
    match document.view.show.legend() {
        // The rows below keep their places.
        Legend::None => line(ui, &[], ""),
        Legend::Trail => {
            let Some(brightest) = facts.brightest else {
                return;
            };
            let trails = [0.0, 0.1, 0.3, 1.0].map(|share: f32| share * brightest);
            let colors =
                trails.map(|trail| map.color(above(tone(trail, brightest), document.view.darkest)));
            let levels = trails.map(three_digits);
            note_value(ui.ctx(), "brightest", || levels[3].clone());
            line(
                ui,
                &colors,
                &format!("trail {} and more", levels.join(", ")),
            );
        }
        Legend::Hues(ways, hint) => {
            ui.horizontal(|ui| {
                for (turn, text) in ways {
                    line(ui, &[hue_light(*turn)], text);
                }
            })
            .response
            .on_hover_text(hint);
        }
        Legend::Scale(shares, text) => {
            let colors: Vec<Vec3> = shares.iter().map(|share| map.color(*share)).collect();
            line(ui, &colors, text);
        }
        Legend::Lights(lights) => {
            let reach = document.running.distance.reach.to_string();
            for (light, text) in lights {
                line(ui, &[(*light).into()], &text.replace("{reach}", &reach));
            }
        }
        Legend::Objects(last) => {
            let objects = document.running.objects.iter().enumerate();
            for (i, object) in objects.take(NAMED) {
                line(ui, &[object_light(i)], &object.name);
            }
            let more = document.running.objects.len().saturating_sub(NAMED);
            if more > 0 {
                line(ui, &[], &format!("and {more} more"));
            }
            line(ui, &[], last);
        }
    }
}

/// Notes the camera and the view for programs that drive the window.
pub(super) fn note_view(ctx: &egui::Context, document: &Document, navigation: &Navigation) {
    let camera = || document.view.camera.to_settings(Vec3::ZERO);
    note_value(ctx, "camera", || {
        let at = camera();
        format!("{:.0} {:.0}", at.azimuth, at.elevation)
    });
    note_value(ctx, "camera.target", || format!("{:.3?}", camera().target));
    note_value(ctx, "atlas", || format!("{:.3?}", document.view.atlas));
    if let Some(flying) = &navigation.flying {
        let modifiers = ctx.input(|input| input.modifiers);
        note_value(ctx, "fly.speed", || {
            flying.speed_with(modifiers).to_string()
        });
    }
    let light = document.view.light;
    note_value(ctx, "light", || {
        format!("{:.0} {:.0}", light.azimuth, light.elevation)
    });
    note_value(ctx, "shows_food", || document.view.shows_food.to_string());
    note_value(ctx, "shows_areas", || document.view.shows_areas.to_string());
}

/// Sides to look from, how wide the camera opens, flight.
pub(super) fn camera_section(ui: &mut Ui, navigation: &Navigation, desk: &mut Desk<'_>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing = vec2(3.0, 3.0);
        let home = ui
            .button("Home")
            .on_hover_text(Action::Home.hint("Where the scene's file puts the camera"));
        if home.marked("view=home").clicked() {
            desk.actions.push(Action::Home);
        }
        for (side, title) in Side::ALL {
            let word = title.to_lowercase();
            let button = ui
                .button(*title)
                .on_hover_text(format!("Looks at the same place from the {word}"));
            if button.marked(&format!("view={word}")).clicked() {
                desk.document.eases = true;
                desk.document.view.camera.look_from(*side);
            }
        }
    });
    ui.horizontal(|ui| {
        let mut flies = navigation.is_flying();
        let hint = "Fly: W A S D, E up, Q down, Shift faster, drag to look, wheel for the speed";
        let hint = Action::Fly.hint(hint);
        let toggle = ui.toggle_value(&mut flies, "✈ Fly");
        if toggle.on_hover_text(hint).marked("fly").clicked() {
            desk.actions.push(Action::Fly);
        }
        if let Some(flying) = &navigation.flying {
            let speed = flying.speed_with(ui.input(|input| input.modifiers));
            let text = format!("{speed:.2} scene radii a second");
            ui.label(RichText::new(text).small().color(theme::weak(ui)));
        }
        theme::switch(ui, &mut desk.layout.glides, "goes on after a drag")
            .on_hover_text("The camera slows down for half a second after a drag; not while the window is recorded")
            .marked("glides");
    });
    note_value(ui.ctx(), "glides", || desk.layout.glides.to_string());
    view_rows(ui, CAMERA_ROWS, desk);
}

/// The direction of the light, and the darkness of hollows.
pub(super) fn light_section(ui: &mut Ui, desk: &mut Desk<'_>) {
    ui.horizontal_top(|ui| {
        let (rect, response) = ui.allocate_exact_size(vec2(BALL, BALL), Sense::click_and_drag());
        let radius = 0.5 * BALL - 2.0;
        if let Some(at) = response.interact_pointer_pos() {
            let place = (at - rect.center()) / radius;
            desk.document.view.light = light_on_ball(Vec2::new(place.x, -place.y));
        }
        ball(ui, rect.center(), radius, desk.document.view.light);
        response
            .on_hover_text("The light: drag the spot over the ball. In the picture: L and drag.")
            .marked("light");
        ui.vertical(|ui| view_rows(ui, LIGHT_ROWS, desk));
    });
}

/// A trail value with enough digits to compare two runs.
fn three_digits(value: f32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let decimals = 2 - value.abs().log10().floor() as i32;
    format!("{value:.*}", decimals.clamp(0, 6) as usize)
}

/// A view's description and its key.
fn in_words(show: Show) -> String {
    let help = show.help();
    let (first, rest) = help.split_at(1);
    let help = format!("{}{rest}", first.to_uppercase());
    match show.key() {
        Some((key, _)) => format!("{help} ({key})"),
        None => help,
    }
}

/// The light for which this place of the ball, right and up of its middle, faces the light.
fn light_on_ball(place: Vec2) -> Light {
    let place = place.clamp_length_max(1.0);
    let towards = (1.0 - place.length_squared()).max(0.0).sqrt();
    Light {
        azimuth: place.x.atan2(towards).to_degrees(),
        elevation: place.y.asin().to_degrees(),
    }
}

/// A ball in the light.
fn ball(ui: &Ui, middle: Pos2, radius: f32, light: Light) {
    let from = light.from_eye();
    let painter = ui.painter();
    let rings = 12;
    let mut mesh = egui::Mesh::default();
    let steps = 48_u32;
    let mut corner = |place: Vec2| {
        let normal = place.extend((1.0 - place.length_squared()).max(0.0).sqrt());
        let shade = 0.06 + 0.55 * normal.dot(from).max(0.0);
        let at = pos2(middle.x + radius * place.x, middle.y - radius * place.y);
        mesh.colored_vertex(at, seen(Vec3::splat(shade)));
    };
    for ring in 0..=rings {
        let out = ring as f32 / rings as f32;
        for step in 0..=steps {
            let angle = std::f32::consts::TAU * step as f32 / steps as f32;
            corner(out * Vec2::from_angle(angle));
        }
    }
    for ring in 0..rings {
        for step in 0..steps {
            let here = ring * (steps + 1) + step;
            let out = here + steps + 1;
            mesh.add_triangle(here, here + 1, out);
            mesh.add_triangle(here + 1, out, out + 1);
        }
    }
    painter.add(Shape::mesh(mesh));
    let at = pos2(middle.x + radius * from.x, middle.y - radius * from.y);
    let color = theme::accent(ui);
    // Behind the ball it is a ring.
    if from.z < 0.0 {
        painter.circle_stroke(at, 4.0, Stroke::new(1.5, color));
    } else {
        painter.circle_filled(at, 4.0, color);
    }
}

/// Light as a colour of the interface.
fn seen(light: Vec3) -> Color32 {
    let [r, g, b] = light
        .to_array()
        .map(|c| (255.0 * srgb_from_linear(c)).round() as u8);
    Color32::from_rgb(r, g, b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_light_is_where_the_ball_is_touched() {
        for place in [Vec2::ZERO, Vec2::new(0.5, -0.3), Vec2::new(-0.7, 0.6)] {
            let from = light_on_ball(place).from_eye();
            assert!(
                from.truncate().distance(place) < 1e-4 && from.z > 0.0,
                "{from}"
            );
        }
        // Beside the ball is its rim.
        let from = light_on_ball(Vec2::new(30.0, 0.0)).from_eye();
        assert!((from - Vec3::X).length() < 1e-3, "{from}");
    }

    #[test]
    fn every_view_says_what_it_shows_and_its_key() {
        assert_eq!(
            in_words(Show::Glow),
            "The trail as the only light, in the dark (3)"
        );
        assert_eq!(in_words(Show::Charts).find('('), None);
    }
}
