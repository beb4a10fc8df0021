//! The tool for pulses: a click sends a wave from the place under the pointer.

use egui::{RichText, Slider, Ui};
use myxo::scene::parameters::{Kind, PULSE_PARAMETERS, Scale};
use myxo::scene::settings::PulseSettings;

use crate::lab::command::{Command, ToolRequest};
use crate::lab::desk::Desk;
use crate::lab::facts::Under;
use crate::lab::places::{Marked as _, note_value};
use crate::lab::theme;
use crate::lab::tools::{Tool, Tools};
use crate::lab::widgets::{parse_number, reader};

/// The values that the bar can change.
const KEYS: [&str; 4] = ["speed", "width", "reach", "strength"];

impl Tools {
    /// The tool for pulses, or none.
    pub fn toggle_pulse(&mut self) {
        let tool = match self.tool {
            Tool::Pulse => Tool::Look,
            _ => Tool::Pulse,
        };
        self.take(tool);
    }

    /// Sends a pulse from there, if there is a surface.
    pub(super) fn send_pulse(&self, under: Option<&Under>, desk: &mut Desk<'_>) {
        let Some(under) = under else {
            return;
        };
        self.note_changes(desk.document);
        desk.document.undo.note_lasting();
        desk.commands.push(Command::Tool(ToolRequest::Pulse {
            center: under.position,
            pulse: self.pulse.clone(),
        }));
    }

    pub(super) fn pulse_controls(&mut self, ui: &mut Ui, width: f32, desk: &Desk<'_>) {
        ui.spacing_mut().slider_width = width - 50.0;
        ui.spacing_mut().interact_size.x = 42.0;
        for key in KEYS {
            pulse_control(ui, key, &mut self.pulse);
        }
        note_value(ui.ctx(), "pulses", || desk.facts.pulses.to_string());
    }
}

/// A slider for one value, with the range that scene files allow when it is typed.
fn pulse_control(ui: &mut Ui, key: &str, pulse: &mut PulseSettings) {
    let row = PULSE_PARAMETERS.iter().find(|row| row.key == key);
    let Some((row, number)) = row.and_then(|row| match &row.kind {
        Kind::Number(number) => Some((row, number)),
        _ => None,
    }) else {
        return;
    };
    ui.label(RichText::new(key).small().color(theme::weak(ui)));
    let mut value = (number.get)(pulse);
    let slider = Slider::new(&mut value, number.slider.0..=number.slider.1)
        .logarithmic(number.scale == Scale::Logarithmic)
        .max_decimals(3)
        .clamping(egui::SliderClamping::Never)
        .custom_parser(reader(ui, parse_number))
        .update_while_editing(false);
    let hint = match row.unit {
        "" => row.help.to_owned(),
        unit => format!("{} In {unit}.", row.help),
    };
    let id = format!("pulse.{key}");
    ui.add(slider).on_hover_text(hint).marked(&id);
    let (least, most) = number.range;
    (number.set)(pulse, value.clamp(least, most));
    note_value(ui.ctx(), &id, || format!("{}", (number.get)(pulse) as f32));
}
