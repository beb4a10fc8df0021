//! Tools that work on the scene: brushes on the surface, picking and moving of objects, and the probe.
//!
//! The interface has the tool, the pointer and what lies under it as the window reported it; work that needs the simulation
//! goes out as [`Work`], which `work.rs` does.

mod bar;
pub mod food;
mod gizmo;
mod grips;
pub mod handles;
mod hold;
pub mod overlay;
mod picked;
mod pulse;
mod tool;

use egui::{PointerButton, Response, Ui};
use glam::{Vec2, Vec3};
use myxo::scene::Scene;
use myxo::scene::settings::{FoodSettings, PulseSettings};
use myxo::sim::paint::Brush;

use crate::lab::command::{Command, Ticket, ToolRequest};
use crate::lab::desk::Desk;
use crate::lab::document::Document;
use crate::lab::facts::Under;
use crate::lab::navigation::Drags;
use crate::lab::renewal::place_among;
use crate::lab::wheel::Wheel;
pub use bar::covered;
use grips::{FoodDrag, Grab};
use hold::{Held, Hold, Way};
pub use tool::Tool;

/// Vertices of an object that its outline is drawn round, at the most.
const OUTLINE_VERTICES: usize = 3000;
/// The range of a brush's radius, scene radii.
const RADII: (f32, f32) = (0.01, 1.0);
/// A notch of the wheel changes the radius by this factor.
const RADIUS_PER_POINT: f32 = 0.004;
/// A picture that took longer does not paint more, seconds.
const LONGEST_FRAME: f32 = 0.4;
/// A press that has not moved yet does not paint more either, because its length is unknown.
const LONGEST_PRESS: f32 = 0.1;

/// The state of the tools.
#[derive(Clone, Debug)]
pub struct Tools {
    /// The tool in use.
    pub tool: Tool,
    /// The brush used last.
    last_brush: Tool,
    /// Radius of brushes, scene radii.
    pub radius: f32,
    /// Strength of brushes per second.
    pub strength: f32,
    /// Is the probe shown?
    pub probe: bool,
    /// The object that is picked.
    pub selected: Option<usize>,
    /// The requested object that is picked when it comes; meanwhile no other is.
    pub(super) awaited: Option<Ticket>,
    /// The ticket of the last request.
    asked: Ticket,
    /// The food that is picked.
    pub food: Option<usize>,
    /// The settings of the next food.
    pub next_food: FoodSettings,
    /// The next pulse; its place and step are not used.
    pub pulse: PulseSettings,
    /// The state of a press with the tool for food.
    food_drag: FoodDrag,
    /// A handle of the gizmo that is held.
    grab: Option<Grab>,
    /// The pointer, pixels of the picture, while the tool needs the point under it.
    pub pointer: Option<Vec2>,
    /// A click that waits for the object under it.
    click: Option<Vec2>,
    wheel: Wheel,
    /// The pointer while it is held, and while its other buttons are.
    hold: Hold,
    others: [Hold; 2],
    /// Drags over the picture in this frame.
    pub(super) drags: Drags,
    /// A list or a dialog lies over everything, and a press means that.
    pub(super) is_covered: bool,
    /// The panel is to show the object that was picked.
    pub(super) reveals: Option<usize>,
    /// Points of a new object that the picture should show.
    pub(super) newcomer: Vec<Vec3>,
    /// Points that the camera should show, in the world.
    pub(super) framed: Vec<Vec3>,
    /// Since the press it has painted what undo may take back.
    pub(super) paints_areas: bool,
    /// The number of ended strokes for which it is not known yet whether they have changed anything.
    pub(super) pending_ends: u32,
    /// Some vertices of each object, for its outline.
    pub(super) vertices: Vec<Vec<Vec3>>,
}

impl Tools {
    /// No tool, nothing picked.
    pub fn new() -> Self {
        Self {
            tool: Tool::Look,
            last_brush: Tool::Trail,
            radius: 0.12,
            strength: 3.0,
            probe: false,
            selected: None,
            awaited: None,
            asked: Ticket::default(),
            food: None,
            next_food: FoodSettings::default(),
            pulse: PulseSettings::default(),
            food_drag: FoodDrag::None,
            grab: None,
            pointer: None,
            click: None,
            wheel: Wheel::default(),
            hold: Hold::default(),
            others: Default::default(),
            drags: Drags::default(),
            is_covered: false,
            reveals: None,
            newcomer: Vec::new(),
            framed: Vec::new(),
            paints_areas: false,
            pending_ends: 0,
            vertices: Vec::new(),
        }
    }

    /// A scene starts or restarts, with this number of foods that are not scattered.
    pub fn restarted(&mut self, scene: &Scene, foods: usize) {
        let surface = &scene.surface;
        if surface.objects.len() > self.vertices.len() {
            self.newcomer = last_points(scene);
        }
        self.vertices = (surface.objects.iter())
            .map(|range| {
                let (first, end) = (range.vertices.0 as usize, range.vertices.1 as usize);
                let stride = ((end - first) / OUTLINE_VERTICES).max(1);
                let own = surface.positions[first..end].iter();
                own.step_by(stride).copied().collect()
            })
            .collect();
        self.food_drag = FoodDrag::None;
        self.grab = None;
        self.click = None;
        self.reveals = None;
        self.pending_ends = 0;
        self.selected = self.selected.filter(|object| *object < self.vertices.len());
        self.food = self.food.filter(|food| *food < foods);
    }

    /// Clears the selection, because its index means another object in another scene.
    pub fn leave_scene(&mut self) {
        self.pick(None);
        self.food = None;
    }

    /// Leaves a tool or an object; returns false if there was nothing to leave.
    pub fn back(&mut self) -> bool {
        self.food_drag = FoodDrag::None;
        if self.food.take().is_some() {
            return true;
        }
        if self.tool != Tool::Look {
            self.tool = Tool::Look;
            return true;
        }
        let picked = self.picked();
        self.pick(None);
        picked.is_some()
    }

    /// Takes a tool.
    pub fn take(&mut self, tool: Tool) {
        self.tool = tool;
        self.food = None;
        self.food_drag = FoodDrag::None;
        if tool != Tool::Look {
            self.pick(None);
        }
        if tool.is_brush() {
            self.last_brush = tool;
        }
    }

    /// Whatever is held stays where it is.
    pub fn let_food_go(&mut self) {
        self.food_drag = FoodDrag::None;
    }

    /// Is a food held, or on its way to where it was released?
    pub fn holds_food(&self) -> bool {
        self.food_drag != FoodDrag::None
    }

    /// The brush used last, or none.
    pub fn toggle_brush(&mut self) {
        let tool = if self.tool.is_brush() {
            Tool::Look
        } else {
            self.last_brush
        };
        self.take(tool);
    }

    /// The probe, or no longer. A brush is laid down for it, so that a click does not paint.
    pub fn toggle_probe(&mut self) {
        self.probe = !self.probe;
        if self.probe && self.tool.is_brush() {
            self.take(Tool::Look);
        }
    }

    /// The tool for food, or none.
    pub fn toggle_food(&mut self) {
        let tool = match self.tool {
            Tool::Food => Tool::Look,
            _ => Tool::Food,
        };
        self.take(tool);
    }

    /// The brush for a stroke of this many seconds in all.
    fn brush(&self, seconds: f32, trail_unit: f32) -> Option<Brush> {
        let amount = 10.0 * self.strength * trail_unit * seconds;
        let share = |rate: f32| 1.0 - (-rate * self.strength * seconds).exp();
        match self.tool {
            Tool::Look | Tool::Food | Tool::Pulse => None,
            Tool::Trail => Some(Brush::Trail { amount }),
            Tool::Erase => Some(Brush::Erase { share: share(4.0) }),
            Tool::Attract => Some(Brush::Attract { amount }),
            Tool::Repel => Some(Brush::Attract { amount: -amount }),
            Tool::NoGo => Some(Brush::NoGo),
            Tool::Blend => Some(Brush::Look {
                amount: (self.strength * seconds).min(1.0),
            }),
            Tool::Particles => Some(Brush::Particles { share: share(0.03) }),
        }
    }
}

impl Tools {
    /// Lets the tool in use take the pointer's events. Returns true if it consumed them.
    pub(super) fn use_tools(&mut self, ui: &Ui, response: &Response, desk: &mut Desk<'_>) -> bool {
        let facts = desk.facts;
        let used = self.reach_out(ui, response, desk);
        // Pending work may bring areas, so only the simulation can say whether there are any to erase.
        let paints = desk.commands.iter().any(|command| match command {
            Command::Tool(ToolRequest::Stroke { brush, .. }) => brush.changes_areas(true),
            _ => false,
        });
        self.paints_areas |= paints;
        let lasts = desk.commands.iter().any(|command| match command {
            Command::Tool(ToolRequest::Stroke { brush, .. }) => !brush.changes_areas(false),
            _ => false,
        });
        if lasts && facts.pointer.under.is_some() {
            self.note_changes(desk.document);
            desk.document.undo.note_lasting();
        }
        // A pointer that leaves the picture and comes back continues its stroke.
        let is_held = ui.input(|i| i.pointer.button_down(PointerButton::Primary));
        if !is_held && std::mem::take(&mut self.paints_areas) {
            // Changes until now are noted before the stroke.
            self.note_changes(desk.document);
            self.pending_ends += 1;
            desk.commands.push(Command::Tool(ToolRequest::EndStroke));
        }
        used
    }

    /// Notes changes, so that undo can lead back to the state before them. Changes after a stroke that waits for its end are
    /// noted after it.
    pub(super) fn note_changes(&self, document: &mut Document) {
        if self.pending_ends == 0 {
            document.note();
        }
    }

    fn reach_out(&mut self, ui: &Ui, response: &Response, desk: &mut Desk<'_>) -> bool {
        let facts = desk.facts;
        let scale = ui.ctx().pixels_per_point();
        let to_pixel = |at: egui::Pos2| {
            let from_corner = (at - response.rect.min) * scale;
            Vec2::new(from_corner.x, from_corner.y)
        };
        let held = self.follow_buttons(ui, response);
        let hovered = response.hover_pos();
        let hovered = hovered.filter(|_| !desk.opening.is_open()).map(to_pixel);
        let is_solid = !desk.document.view.show.is_flat();
        let asks = is_solid && (self.tool != Tool::Look || self.probe || self.hold.is_down());
        self.pointer = hovered.filter(|_| asks);
        if facts.pointer.looked != self.pointer && !facts.pointer.poses.is_empty() {
            // The point shown is for an older position of the pointer; one more frame brings it up to date.
            ui.ctx().request_repaint();
        }
        if !is_solid {
            self.food_drag = FoodDrag::None;
            self.grab = None;
            self.click = None;
            return false;
        }
        if self.tool.is_brush() {
            return self.use_brush(ui, response, &held, to_pixel, desk);
        }
        if self.tool == Tool::Look && desk.layout.alone {
            // A picked object would show handles.
            self.grab = None;
            return false;
        }
        if self.tool == Tool::Look && self.use_gizmo(ui, response, &held, desk) {
            return true;
        }
        let drags = self.tool == Tool::Food && self.drag_food(ui, response, &held, desk);
        if response.clicked_by(PointerButton::Primary) {
            // The pointer may be elsewhere already.
            self.click = self.hold.pressed().map(to_pixel);
        }
        if let Some(click) = self.click {
            self.take_click(ui.ctx(), click, desk);
        }
        drags
    }

    /// Takes in what the pointer's buttons have done over the picture, and adds up their drags. Returns the events of the first one.
    fn follow_buttons(&mut self, ui: &Ui, response: &Response) -> Held {
        let is_free = !self.is_covered;
        let held = (self.hold).follow(ui, response, PointerButton::Primary, is_free);
        let others = [PointerButton::Secondary, PointerButton::Middle];
        let others = self.others.iter_mut().zip(others);
        let others = others.map(|(hold, button)| hold.follow(ui, response, button, is_free).drag);
        self.drags = Drags {
            first: held.drag,
            others: others.fold(egui::Vec2::ZERO, |all, drag| all + drag),
            pressed: self.hold.pressed(),
        };
        held
    }

    /// Changes the radius, or paints along the ways of the first button. Returns true if it used the button.
    fn use_brush(
        &mut self,
        ui: &Ui,
        response: &Response,
        held: &Held,
        to_pixel: impl Fn(egui::Pos2) -> Vec2 + Copy,
        desk: &mut Desk<'_>,
    ) -> bool {
        self.change_radius(ui, response);
        if ui.input(|i| i.modifiers.shift) {
            return false;
        }
        for way in &held.ways {
            let most = match way.begins && way.length() == 0.0 {
                true => ui.input(|i| i.stable_dt).min(LONGEST_PRESS),
                false => ui.input(|i| i.unstable_dt).min(LONGEST_FRAME),
            };
            let seconds = most / held.ways.len() as f32;
            self.paint_along(way, seconds, to_pixel, desk);
        }
        let is_held = self.hold.is_down();
        if is_held {
            // A brush that is held still continues to paint.
            ui.ctx().request_repaint();
        }
        is_held || held.release.is_some()
    }

    /// Lets the tool in use take a click on this pixel, once the window has looked there.
    fn take_click(&mut self, ctx: &egui::Context, click: Vec2, desk: &mut Desk<'_>) {
        let facts = desk.facts;
        // A quick click has ended before the window has looked.
        if facts.pointer.looked != Some(click) {
            self.pointer = Some(click);
            ctx.request_repaint();
            return;
        }
        let under = facts.pointer.under.as_ref();
        self.click = None;
        match self.tool {
            Tool::Food => self.feed_at(ctx, under, desk),
            Tool::Pulse => self.send_pulse(under, desk),
            _ => self.pick_under(ctx, under, desk),
        }
    }

    /// Picks the object under a click, which the panel is to show; none where there is none, or a locked one.
    fn pick_under(&mut self, ctx: &egui::Context, under: Option<&Under>, desk: &Desk<'_>) {
        // Seen are the objects that run; the next ones may stand in other places already.
        let running = under.and_then(|under| desk.document.running.objects.get(under.object));
        let place = running.and_then(|object| place_among(&desk.document.edited.objects, object));
        self.pick(place.filter(|place| !desk.document.marks.is_locked(*place)));
        // A click on the only object leaves the panel as it is.
        let is_one_of_several = desk.document.edited.objects.len() > 1;
        self.reveals = (self.selected).filter(|_| desk.layout.panel && is_one_of_several);
        ctx.request_repaint();
    }

    /// Paints along a way that took this many seconds.
    fn paint_along(
        &self,
        way: &Way,
        seconds: f32,
        to_pixel: impl Fn(egui::Pos2) -> Vec2,
        desk: &mut Desk<'_>,
    ) {
        let facts = desk.facts;
        let (length, corners) = (way.length(), way.corners());
        if way.ends && !way.begins && length == 0.0 {
            // The button was released where the pointer was.
            return;
        }
        let mut paint = |from: egui::Pos2, to: egui::Pos2, share: f32| {
            let brush = self.brush(share * seconds, facts.pointer.trail_unit);
            desk.commands.extend(brush.map(|brush| {
                Command::Tool(ToolRequest::Stroke {
                    from: to_pixel(from),
                    to: to_pixel(to),
                    brush,
                    radius: self.radius,
                })
            }));
        };
        if let [point] = corners[..] {
            return paint(point, point, 1.0);
        }
        let parts: f32 = corners.windows(2).map(|c| c[0].distance(c[1])).sum();
        for pair in corners.windows(2) {
            paint(pair[0], pair[1], pair[0].distance(pair[1]) / parts);
        }
    }

    /// Shift and the wheel.
    fn change_radius(&mut self, ui: &Ui, response: &Response) {
        // With Shift, the wheel goes sideways on most systems.
        let delta = self.wheel.turned(ui, response);
        let has_shift = ui.input(|i| i.modifiers.shift);
        let turned = if has_shift { delta.x + delta.y } else { 0.0 };
        if turned != 0.0 {
            let (least, most) = RADII;
            let radius = self.radius * (turned * RADIUS_PER_POINT).exp();
            self.radius = radius.clamp(least, most);
        }
    }
}

/// Some points of the last object at time 0, in the world.
fn last_points(scene: &Scene) -> Vec<Vec3> {
    let poses = scene.world_from_object_at(0.0);
    let (Some(range), Some(pose)) = (scene.surface.objects.last(), poses.last()) else {
        return Vec::new();
    };
    let own = &scene.surface.positions[range.vertices.0 as usize..range.vertices.1 as usize];
    let some = own.iter().step_by((own.len() / OUTLINE_VERTICES).max(1));
    some.map(|place| pose.transform_point3(*place)).collect()
}

#[cfg(test)]
mod tests;
