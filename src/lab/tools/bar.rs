//! The bar of tools over the picture.

use egui::{Align2, Rect, RichText, Slider, Ui, vec2};
use myxo::mesh::builtin::BUILTINS;
use myxo::scene::settings::SECOND_LOOKS;
use myxo::scene::settings::Show;

use crate::lab::actions::{Action, PICK_FIRST};
use crate::lab::command::{Command, ToolRequest};
use crate::lab::desk::Desk;
use crate::lab::opening::{ONLY_MESHES, OPEN_MESH};
use crate::lab::places::{Marked as _, note_value};
use crate::lab::theme;
use crate::lab::tools::{RADII, Tool, Tools};
use crate::lab::widgets::{hint_beside, parse_number, reader};

/// The second look that the brush takes if the scene has none.
const USUAL_SECOND_LOOK: &str = "felt";
/// Width of the bar's contents, points.
const WIDTH: f32 = 108.0;
/// The width of the contents if the bar has signs only, points.
const NARROW: f32 = 24.0;
/// A picture narrower than this would lose too much to names.
const HAS_ROOM: f32 = 620.0;

/// Between the bar and the edge of the picture, points.
const BESIDE: f32 = 10.0;

/// Is a picture so small that it is only for looking? So is the atlas.
fn has_no_tools(picture: Rect, show: Show) -> bool {
    picture.width() < 260.0 || picture.height() < 330.0 || show.is_flat()
}

/// How much of a picture the tools cover on its right side, points. In a narrow one it does not depend on the tool that is taken, so that
/// the scene stays where it is.
pub fn covered(ctx: &egui::Context, picture: Rect, show: Show) -> f32 {
    if has_no_tools(picture, show) {
        return 0.0;
    }
    let contents = match picture.width() < HAS_ROOM {
        true => NARROW,
        false => WIDTH,
    };
    let frame = egui::Frame::popup(&ctx.global_style()).total_margin();
    BESIDE + contents + frame.sum().x
}

impl Tools {
    /// Shows the bar at the right side of the picture, and gives where it is; none in a picture that is small, or flat.
    pub(in super::super) fn show_tools(
        &mut self,
        ctx: &egui::Context,
        picture: Rect,
        desk: &mut Desk<'_>,
    ) -> Option<Rect> {
        if has_no_tools(picture, desk.document.view.show) {
            return None;
        }
        let has_controls = self.tool != Tool::Look;
        let is_narrow = picture.width() < HAS_ROOM && !has_controls;
        let shown = egui::Area::new("tools".into())
            .pivot(Align2::RIGHT_TOP)
            .fixed_pos(picture.right_top() + vec2(-BESIDE, 10.0))
            .show(ctx, |ui| {
                egui::Frame::popup(ui.style()).show(ui, |ui| {
                    ui.set_width(if is_narrow { NARROW } else { WIDTH });
                    ui.spacing_mut().item_spacing.y = 2.0;
                    self.tools(ui, is_narrow);
                    if self.tool.is_brush() {
                        ui.separator();
                        self.brush_controls(ui, desk);
                    }
                    if self.tool == Tool::Food {
                        ui.separator();
                        self.food_controls(ui, WIDTH, desk);
                    }
                    if self.tool == Tool::Pulse {
                        ui.separator();
                        self.pulse_controls(ui, WIDTH, desk);
                    }
                    ui.separator();
                    self.object_controls(ui, is_narrow, desk);
                });
            });
        Some(shown.response.rect)
    }

    fn tools(&mut self, ui: &mut Ui, is_narrow: bool) {
        let size = vec2(ui.available_width(), 20.0);
        let text = |sign: &str, word: &str| match is_narrow {
            true => sign.to_owned(),
            false => format!("{sign} {word}"),
        };
        let in_full = |word: &str, hint: &str| match is_narrow {
            true => format!("{word}: {hint}"),
            false => hint.to_owned(),
        };
        for tool in Tool::ALL {
            let is_taken = self.tool == tool;
            let word = tool.word();
            let button = egui::Button::selectable(is_taken, text(sign(tool), word)).min_size(size);
            let button = hint_beside(ui.add(button), &in_full(word, tool.hint()), "");
            if button.marked(&format!("tool={}", tool.word())).clicked() {
                self.take(tool);
            }
        }
        note_value(ui.ctx(), "tool", || self.tool.word().to_owned());
        let probe = text("🔍", "probe");
        let probe = egui::Button::selectable(self.probe, probe).min_size(size);
        let hint =
            "Shows triangle, uv, texel, trail and the distance to other objects under the pointer";
        let hint = Action::Probe.hint(hint);
        let probe = hint_beside(ui.add(probe), &in_full("probe", &hint), "");
        if probe.marked("probe").clicked() {
            self.toggle_probe();
        }
    }

    fn brush_controls(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        ui.spacing_mut().slider_width = WIDTH - 50.0;
        ui.spacing_mut().interact_size.x = 42.0;
        let (least, most) = RADII;
        ui.label(RichText::new("radius").small().color(theme::weak(ui)));
        let slider = Slider::new(&mut self.radius, least..=most)
            .logarithmic(true)
            .max_decimals(3)
            .custom_parser(reader(ui, parse_number))
            .update_while_editing(false);
        ui.add(slider)
            .on_hover_text("Of the brush, scene radii (Shift and the wheel)")
            .marked("brush.radius");
        note_value(ui.ctx(), "brush.radius", || format!("{:.3}", self.radius));
        let has_strength = self.tool != Tool::NoGo;
        ui.label(RichText::new("strength").small().color(theme::weak(ui)));
        let slider = Slider::new(&mut self.strength, 0.1..=30.0)
            .logarithmic(true)
            .max_decimals(1)
            .custom_parser(reader(ui, parse_number))
            .update_while_editing(false);
        ui.add_enabled(has_strength, slider)
            .on_hover_text(
                "How much in a second: for trail, attraction and repulsion in tenfold means of the trail; \
                 for blending, erasing and particles, how quickly it goes",
            )
            .on_disabled_hover_text("A place is no-go or is not")
            .marked("brush.strength");
        if self.tool == Tool::Attract {
            self.start_control(ui, desk);
        }
        if self.tool == Tool::Blend {
            second_look_control(ui, desk);
        }
        note_value(ui.ctx(), "brush.strength", || {
            format!("{:.1}", self.strength)
        });
    }

    fn start_control(&self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let size = vec2(ui.available_width(), 20.0);
        let start = egui::Button::new("⟲ Start here").min_size(size);
        let hint = "All particles restart on the green areas, which are removed for it. A mask of them, a PNG in the folder for \
             files, becomes the scene's start";
        let start = hint_beside(ui.add(start), hint, "");
        if start.marked("start.painted").clicked() {
            desk.commands
                .push(Command::Tool(ToolRequest::StartOnPainted));
        }
    }

    fn object_controls(&mut self, ui: &mut Ui, is_narrow: bool, desk: &mut Desk<'_>) {
        let [add, duplicate, remove] = match is_narrow {
            true => ["📦", "🗐", "🗑"],
            false => ["+ object", "🗐 duplicate", "− object"],
        };
        let menu = ui.menu_button(add, |ui| {
            ui.set_min_width(150.0);
            for (name, hint) in BUILTINS {
                let entry = ui.button(*name).on_hover_text(*hint);
                if entry.marked(&format!("add={name}")).clicked() {
                    let ticket = self.ask();
                    let mesh = format!("builtin:{name}");
                    desk.commands
                        .push(Command::Tool(ToolRequest::Add(mesh, ticket)));
                    ui.close();
                }
            }
            ui.separator();
            let file = ui.button("Open…").on_hover_text(OPEN_MESH);
            if file.marked("add.file").clicked() {
                desk.opening.begin(ui.ctx(), ONLY_MESHES);
                ui.close();
            }
        });
        let hint = "Puts a mesh into the scene; files of meshes can be dropped onto the window";
        hint_beside(menu.response, hint, "").marked("add");
        let has_picked = self.picked().is_some();
        let duplicate = egui::Button::new(duplicate);
        let hint = "A copy of the picked object beside it, with its parameters and its motion";
        let hint = Action::Duplicate.hint(hint);
        let duplicate = ui.add_enabled(has_picked, duplicate);
        let duplicate = hint_beside(duplicate, &hint, PICK_FIRST).marked("duplicate");
        if duplicate.clicked() {
            let ctx = ui.ctx().clone();
            self.duplicate_selected(&ctx, desk);
        }
        let remove = egui::Button::new(remove);
        let hint = "Takes the picked object out of the scene (Delete)";
        let remove = ui.add_enabled(has_picked, remove);
        let remove = hint_beside(remove, hint, PICK_FIRST).marked("remove");
        if remove.clicked() {
            let ctx = ui.ctx().clone();
            self.remove_selected(&ctx, desk);
        }
        let selected = self
            .selected
            .and_then(|i| desk.document.edited.objects.get(i));
        note_value(ui.ctx(), "picked", || {
            selected.map_or(String::new(), |object| object.name.clone())
        });
        let running = self
            .selected
            .and_then(|i| desk.document.running.objects.get(i));
        note_value(ui.ctx(), "objects", || {
            desk.document.running.objects.len().to_string()
        });
        note_value(ui.ctx(), "picked.scale", || {
            running.map_or(String::new(), |object| object.scale.to_string())
        });
    }
}

/// The second look; the brush takes one if there is none.
fn second_look_control(ui: &mut Ui, desk: &mut Desk<'_>) {
    let mut chosen = desk.document.edited.second_look.preset.clone();
    if !desk.document.edited.second_look.is_some() {
        USUAL_SECOND_LOOK.clone_into(&mut chosen);
    }
    ui.label(RichText::new("second look").small().color(theme::weak(ui)));
    let list = egui::ComboBox::from_id_salt("second look")
        .selected_text(&chosen)
        .width(ui.available_width());
    let list = list.show_ui(ui, |ui| {
        for name in SECOND_LOOKS.iter().skip(1) {
            let entry = ui.selectable_label(chosen == *name, *name);
            if entry.marked(&format!("second={name}")).clicked() {
                chosen = (*name).to_owned();
            }
        }
    });
    let hint = "The preset that particles follow where this brush paints. Erase takes it away";
    list.response.on_hover_text(hint).marked("second");
    note_value(ui.ctx(), "second", || chosen.clone());
    note_value(ui.ctx(), "second.painted", || {
        desk.facts.has_looks.to_string()
    });
    let preset = &mut desk.document.edited.second_look.preset;
    if *preset != chosen {
        *preset = chosen;
        desk.commands.push(Command::Apply);
    }
}

fn sign(tool: Tool) -> &'static str {
    match tool {
        Tool::Look => "👁",
        Tool::Trail => "✏",
        Tool::Erase => "✖",
        Tool::Attract => "➕",
        Tool::Repel => "➖",
        Tool::NoGo => "🚫",
        Tool::Blend => "🎨",
        Tool::Particles => "✨",
        Tool::Food => "🌾",
        Tool::Pulse => "◎",
    }
}
