//! The list of the scene's objects: their names, which of them are seen, and which of them tools may touch.

use egui::{Align, Button, Id, Key, Layout, RichText, ScrollArea, TextEdit, Ui};

use crate::lab::command::Command;
use crate::lab::desk::Desk;
use crate::lab::places::{Marked as _, note_value};
use crate::lab::theme;
use crate::lab::tools::Tools;

/// Height of a row, points.
const ROW: f32 = 24.0;
/// More rows than these are scrolled.
const ROWS_SHOWN: f32 = 10.0;

/// The section of the panel.
#[derive(Clone, Debug, Default)]
pub struct Outliner {
    /// The object that gets another name, and that name as it is typed.
    renaming: Option<(usize, String)>,
    /// The field has just come.
    has_begun: bool,
}

impl Outliner {
    /// A row for each object.
    pub fn show(&mut self, ui: &mut Ui, tools: &mut Tools, desk: &mut Desk<'_>) {
        let count = desk.document.edited.objects.len();
        note_value(ui.ctx(), "objects.list", || listed(desk));
        // The object to be renamed may be gone.
        self.renaming.take_if(|(object, _)| *object >= count);
        ScrollArea::vertical()
            .id_salt("objects")
            .max_height(ROWS_SHOWN * (ROW + ui.spacing().item_spacing.y))
            .auto_shrink([false, true])
            .show_rows(ui, ROW, count, |ui, shown| {
                // Room for the bar, if there is one.
                if count as f32 > ROWS_SHOWN {
                    ui.set_max_width(ui.available_width() - theme::SCROLL_BAR);
                }
                for object in shown {
                    self.row(ui, object, count, tools, desk);
                }
            });
    }

    fn row(
        &mut self,
        ui: &mut Ui,
        object: usize,
        count: usize,
        tools: &mut Tools,
        desk: &mut Desk<'_>,
    ) {
        ui.horizontal(|ui| {
            ui.set_height(ROW);
            ui.spacing_mut().item_spacing.x = 2.0;
            let marks = &desk.document.marks;
            let (is_hidden, is_locked) = (marks.is_hidden(object), marks.is_locked(object));
            let weak = theme::weak(ui);
            let sign = |sign: &str, is_on: bool| {
                let sign = RichText::new(sign);
                let sign = if is_on { sign } else { sign.color(weak) };
                Button::new(sign).frame(false).min_size(egui::vec2(20.0, ROW))
            };
            if count > 1 || is_hidden {
                let eye = ui
                    .add(sign(if is_hidden { "–" } else { "👁" }, !is_hidden))
                    .on_hover_text(
                        "Hides the object, or shows it. A hidden one is still simulated, and others meet it. \
                         Scene files don't have it",
                    );
                if eye.marked(&format!("objects.eye={object}")).clicked() {
                    desk.document.marks.hide(object, !is_hidden);
                    if tools.selected == Some(object) {
                        tools.pick(None);
                    }
                }
            }
            let lock = ui
                .add(sign(if is_locked { "🔒" } else { "🔓" }, is_locked))
                .on_hover_text(
                    "Locks the object, or frees it. A locked one is not selected by clicks, moved, painted or removed",
                );
            if lock.marked(&format!("objects.lock={object}")).clicked() {
                desk.document.marks.lock(object, !is_locked);
            }
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if count > 1 {
                    let is_alone = desk.document.marks.is_isolated(object);
                    let alone = ui.add(sign("◎", is_alone)).on_hover_text(if is_alone {
                        "Shows all objects again"
                    } else {
                        "Shows this object alone"
                    });
                    if alone.marked(&format!("objects.alone={object}")).clicked() {
                        desk.document.marks.isolate(object);
                        let marks = &desk.document.marks;
                        if tools.selected.is_some_and(|selected| marks.is_hidden(selected)) {
                            tools.pick(None);
                        }
                    }
                }
                // Objects on their way have the names with which they were requested.
                let can_rename = !desk.document.is_renewed() && desk.document.asked.is_none();
                let rename = ui
                    .add_enabled(can_rename, sign("✏", false))
                    .on_hover_text("Renames the object")
                    .on_disabled_hover_text("The scene is on its way: rename it when it is there");
                if rename.marked(&format!("objects.rename={object}")).clicked() {
                    self.begin(object, desk);
                }
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
                    if self.renaming.as_ref().is_some_and(|(of, _)| *of == object) {
                        return self.field(ui, desk);
                    }
                    let name = RichText::new(&desk.document.edited.objects[object].name);
                    let name = if is_hidden { name.color(weak) } else { name };
                    let label = Button::selectable(tools.selected == Some(object), name).truncate();
                    let label = ui
                        .add(label)
                        .on_hover_text("Selects the object; a double click renames it");
                    let label = label.marked(&format!("objects.name={object}"));
                    if label.double_clicked() && can_rename {
                        self.begin(object, desk);
                    } else if label.clicked() {
                        tools.pick(Some(object));
                    }
                });
            });
        });
    }

    fn begin(&mut self, object: usize, desk: &Desk<'_>) {
        let name = desk.document.edited.objects[object].name.clone();
        self.renaming = Some((object, name));
        self.has_begun = true;
    }

    /// The field for a name: Enter takes it, Escape leaves the old one.
    fn field(&mut self, ui: &mut Ui, desk: &mut Desk<'_>) {
        let Some((object, typed)) = &mut self.renaming else {
            return;
        };
        let object = *object;
        let field = TextEdit::singleline(typed)
            .id(Id::new("name of an object"))
            .desired_width(ui.available_width());
        let field = ui.add(field).marked("objects.typed");
        if std::mem::take(&mut self.has_begun) {
            field.request_focus();
            return;
        }
        if !field.lost_focus() {
            return;
        }
        let is_left = ui.input(|input| input.key_pressed(Key::Escape));
        let typed = self.renaming.take().map(|(_, typed)| typed);
        let Some(name) = typed.filter(|_| !is_left) else {
            return;
        };
        let mut names = desk.document.names();
        let name = name.trim();
        if name.is_empty() || names[object] == name {
            return;
        }
        if names.iter().any(|other| other == name) {
            let text = format!("Another object is called {name}: choose a name of its own");
            return desk.notices.say(ui.ctx(), text, true);
        }
        name.clone_into(&mut names[object]);
        desk.document.edited.rename_objects(&names);
        desk.commands.push(Command::Apply);
    }
}

/// All objects as tests read them: hidden ones in parentheses, locked ones with an exclamation mark.
fn listed(desk: &Desk<'_>) -> String {
    let marks = &desk.document.marks;
    let names = desk.document.edited.objects.iter().enumerate();
    let names = names.map(|(i, object)| {
        let name = match marks.is_hidden(i) {
            true => format!("({})", object.name),
            false => object.name.clone(),
        };
        name + if marks.is_locked(i) { "!" } else { "" }
    });
    names.collect::<Vec<_>>().join(" ")
}
