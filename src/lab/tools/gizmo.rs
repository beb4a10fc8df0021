//! Handles on the picked object: arrows move it along the world's axes, rings turn it, the box in the middle moves it in
//! the plane of the picture, and the one beside it scales it.

use egui::{Color32, Pos2, Rect, Response, Stroke, Ui, vec2};
use glam::{Vec2, Vec3};
use myxo::render::Camera;
use myxo::scene::settings::ObjectSettings;

use crate::lab::command::{Command, ToolRequest};
use crate::lab::desk::Desk;
use crate::lab::facts::PointerFacts;
use crate::lab::places::{Marked as _, are_asked_for, note_value};
use crate::lab::theme;
use crate::lab::tools::grips::{Grab, Handle};
use crate::lab::tools::handles::{
    along_axis, angle_round, keep_in_place, length_of_pixel, on_plane, shift, turn,
};
use crate::lab::tools::{Held, Tools};

/// Points from the middle to the end of an arrow.
const ARROW: f32 = 84.0;
/// Radius of the rings, points.
const RING: f32 = 60.0;
/// From the middle to the box that scales.
const SCALE_AT: egui::Vec2 = vec2(30.0, -30.0);
/// As near as this a handle is meant, points.
const NEAR: f32 = 8.0;
const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];
const COLORS: [Color32; 3] = [
    Color32::from_rgb(0xf0, 0x5a, 0x4e),
    Color32::from_rgb(0x7e, 0xc8, 0x4a),
    Color32::from_rgb(0x5a, 0x9c, 0xf4),
];
const NAMES: [&str; 3] = ["x", "y", "z"];
const PARTS: usize = 48;

/// The places of the gizmo's parts.
struct Shape {
    /// Points of the window.
    middle: Pos2,
    /// Ends of the arrows.
    ends: [Option<Pos2>; 3],
    /// The rings.
    rings: [Vec<Pos2>; 3],
    scale: Pos2,
}

/// From pixels of the picture to points of the window, and back.
#[derive(Clone, Copy)]
pub(super) struct Screen {
    pub(super) rect: Rect,
    pub(super) pixels_per_point: f32,
}

impl Screen {
    pub(super) fn of(ui: &Ui, rect: Rect) -> Self {
        Self {
            rect,
            pixels_per_point: ui.ctx().pixels_per_point(),
        }
    }

    /// Size of the picture, pixels.
    pub(super) fn size(self) -> Vec2 {
        Vec2::new(self.rect.width(), self.rect.height()) * self.pixels_per_point
    }

    /// The point of the screen at which a place in the world is seen.
    pub(super) fn point(self, camera: &Camera, place: Vec3) -> Option<Pos2> {
        let pixel = camera.pixel(place, self.size())?;
        let at = pixel / self.pixels_per_point;
        Some(self.rect.min + vec2(at.x, at.y))
    }

    /// The world length at a place that one point of the window covers.
    fn length_of_point(self, camera: &Camera, place: Vec3) -> f32 {
        let points = Vec2::new(self.rect.width(), self.rect.height());
        length_of_pixel(camera, points, place)
    }
}

impl Shape {
    fn of(screen: Screen, camera: &Camera, middle: Vec3) -> Option<Self> {
        let unit = screen.length_of_point(camera, middle);
        let at = screen.point(camera, middle)?;
        let ends = AXES.map(|axis| screen.point(camera, middle + ARROW * unit * axis));
        let rings = AXES.map(|axis| {
            let side = axis.any_orthonormal_vector();
            let other = axis.cross(side);
            let along = (0..=PARTS).filter_map(|i| {
                let angle = i as f32 / PARTS as f32 * std::f32::consts::TAU;
                let (sin, cos) = angle.sin_cos();
                screen.point(camera, middle + RING * unit * (cos * side + sin * other))
            });
            along.collect()
        });
        Some(Self {
            middle: at,
            ends,
            rings,
            scale: at + SCALE_AT,
        })
    }

    /// The handle that the pointer is on. Boxes lie on arrows, arrows on rings.
    fn handle_at(&self, at: Pos2) -> Option<Handle> {
        if at.distance(self.scale) < NEAR {
            return Some(Handle::Scale);
        }
        if at.distance(self.middle) < NEAR {
            return Some(Handle::Plane);
        }
        let arrows = self.ends.iter().enumerate().filter_map(|(axis, end)| {
            let end = (*end)?;
            // An arrow that points at the eye has no length to be held by.
            (end.distance(self.middle) > 2.0 * NEAR)
                .then(|| (to_segment(at, self.middle, end), Handle::Move(axis)))
        });
        let rings = self.rings.iter().enumerate().map(|(axis, ring)| {
            let near = ring.windows(2).map(|ends| to_segment(at, ends[0], ends[1]));
            // A little farther, so that arrows come first.
            (near.fold(f32::MAX, f32::min) + 2.0, Handle::Turn(axis))
        });
        let nearest = arrows.chain(rings).min_by(|a, b| a.0.total_cmp(&b.0));
        nearest
            .filter(|(away, _)| *away < NEAR)
            .map(|(_, handle)| handle)
    }
}

fn to_segment(at: Pos2, from: Pos2, to: Pos2) -> f32 {
    let way = to - from;
    let share = ((at - from).dot(way) / way.length_sq().max(1e-9)).clamp(0.0, 1.0);
    at.distance(from + share * way)
}

impl Tools {
    /// Draws the gizmo and lets it use the pointer. Returns true if a handle is held.
    pub(super) fn use_gizmo(
        &mut self,
        ui: &Ui,
        response: &Response,
        held: &Held,
        desk: &mut Desk<'_>,
    ) -> bool {
        let facts = desk.facts;
        let Some(object) = self.selected else {
            self.grab = None;
            return false;
        };
        // While objects come or go, those that are seen are not those that are edited.
        let settings =
            (desk.document.edited.objects.get(object)).filter(|_| !desk.document.is_renewed());
        let marks = &desk.document.marks;
        let settings = settings.filter(|_| !marks.is_locked(object) && !marks.is_hidden(object));
        let (Some(pose), Some(settings)) = (facts.pointer.poses.get(object), settings) else {
            self.grab = None;
            return false;
        };
        let screen = Screen::of(ui, response.rect);
        let camera = desk.document.view.camera;
        let middle = pose.transform_point3(facts.pointer.middle_of(object));
        let Some(shape) = Shape::of(screen, &camera, middle) else {
            return false;
        };
        let pointer = ui.input(|i| i.pointer.latest_pos());
        let hovered = pointer.filter(|_| response.hovered() || self.grab.is_some());
        let to_pixel = |at: Pos2| {
            let at = (at - response.rect.min) * screen.pixels_per_point;
            Vec2::new(at.x, at.y)
        };
        let over = hovered.and_then(|at| shape.handle_at(at));
        // The place of the press: in a slow frame the pointer has moved since.
        let pressed = held.press.filter(|_| self.grab.is_none());
        if let Some((at, handle)) = pressed.and_then(|at| Some((at, shape.handle_at(at)?))) {
            self.grab = Some(Grab {
                handle,
                object: settings.clone(),
                pivot: facts.pointer.pivot_of(object),
                middle,
                from: to_pixel(at),
                ring: RING * screen.length_of_point(&camera, middle),
                scaled: 1.0,
                is_given_up: false,
            });
        }
        let to = held.release.or(pointer);
        let in_steps = ui.input(|i| i.modifiers.command);
        let step = in_steps.then(|| step_of(facts.pointer.radius));
        let mut label = None;
        let held = self.grab.as_mut().filter(|grab| !grab.is_given_up);
        if let (Some(grab), Some(at)) = (held, to) {
            let to = to_pixel(at);
            if grab.handle == Handle::Scale {
                let grown = (to.x - grab.from.x - (to.y - grab.from.y)) / screen.pixels_per_point;
                grab.scaled = (0.01 * grown).exp().clamp(0.05, 20.0);
                if in_steps {
                    grab.scaled = rounded(grab.scaled, 0.1).max(0.1);
                }
                label = Some((at, format!("× {:.2}", grab.scaled)));
            } else {
                let (moved, way) = grab.moved(&camera, screen.size(), &facts.pointer, to, step);
                if desk.document.edited.objects[object] != moved {
                    desk.document.edited.objects[object] = moved;
                    desk.commands.push(Command::Apply);
                }
                label = Some((at, way));
            }
        }
        if !self.hold.is_down()
            && let Some(grab) = self.grab.take()
        {
            if grab.scaled != 1.0 {
                desk.commands
                    .push(Command::Tool(ToolRequest::Scale(object, grab.scaled)));
            }
            // The release is not a click.
            self.draw_gizmo(ui, &shape, None, screen);
            return true;
        }
        let active = self.grab.as_ref().map(|grab| grab.handle);
        self.draw_gizmo(ui, &shape, active.or(over), screen);
        if let Some((at, text)) = label {
            label_beside(ui, screen, at, text);
        }
        active.is_some()
    }

    /// Puts an object whose handle is held back where it was. Returns false if no handle is held.
    pub(in super::super) fn give_up_grab(&mut self, desk: &mut Desk<'_>) -> bool {
        let grab = self.grab.as_mut().filter(|grab| !grab.is_given_up);
        let (Some(grab), Some(object)) = (grab, self.selected) else {
            return false;
        };
        grab.is_given_up = true;
        grab.scaled = 1.0;
        if let Some(edited) = desk.document.edited.objects.get_mut(object)
            && *edited != grab.object
        {
            edited.clone_from(&grab.object);
            desk.commands.push(Command::Apply);
        }
        true
    }

    fn draw_gizmo(&self, ui: &Ui, shape: &Shape, active: Option<Handle>, screen: Screen) {
        let painter = ui.painter_at(screen.rect);
        let stroke = |handle: Handle, color: Color32| {
            let is_active = active == Some(handle);
            Stroke::new(
                if is_active { 3.5 } else { 2.0 },
                if is_active { theme::accent(ui) } else { color },
            )
        };
        // Seen on light and on dark.
        let under =
            |stroke: Stroke| Stroke::new(stroke.width + 3.0, Color32::from_black_alpha(150));
        for (axis, ring) in shape.rings.iter().enumerate() {
            let stroke = stroke(Handle::Turn(axis), COLORS[axis]);
            painter.line(ring.clone(), under(stroke));
            painter.line(ring.clone(), stroke);
        }
        for (axis, end) in shape.ends.iter().enumerate() {
            if let Some(end) = end {
                let stroke = stroke(Handle::Move(axis), COLORS[axis]);
                painter.arrow(shape.middle, *end - shape.middle, under(stroke));
                painter.arrow(shape.middle, *end - shape.middle, stroke);
            }
        }
        let boxes = [(Handle::Plane, shape.middle), (Handle::Scale, shape.scale)];
        for (handle, at) in boxes {
            let rect = Rect::from_center_size(at, vec2(10.0, 10.0));
            let color = stroke(handle, ui.visuals().strong_text_color()).color;
            painter.rect_filled(rect.expand(1.5), 2.0, Color32::from_black_alpha(150));
            painter.rect_filled(rect, 2.0, color);
        }
        for (name, end) in NAMES.into_iter().zip(shape.ends) {
            if let Some(end) = end {
                mark(ui, &format!("gizmo={name}"), end);
            }
        }
        mark(ui, "gizmo=plane", shape.middle);
        mark(ui, "gizmo=scale", shape.scale);
        if !are_asked_for(ui.ctx()) {
            return;
        }
        for (axis, name) in NAMES.into_iter().enumerate() {
            // The place must be away from all others.
            let away = |at: &Pos2| {
                let ends = shape.ends.iter().flatten();
                let arrows = ends.map(|end| to_segment(*at, shape.middle, *end));
                let others = (0..3).filter(|other| *other != axis);
                let others = others.flat_map(|other| &shape.rings[other]);
                let others = others.map(|other| at.distance(*other));
                arrows
                    .chain(others)
                    .fold(at.distance(shape.scale), f32::min)
            };
            let ring = shape.rings[axis].iter().copied();
            if let Some(at) = ring.max_by(|a, b| away(a).total_cmp(&away(b))) {
                mark(ui, &format!("gizmo=turn.{name}"), at);
            }
        }
    }
}

/// Shows the distance of a move beside the pointer.
fn label_beside(ui: &Ui, screen: Screen, at: Pos2, text: String) {
    let painter = ui.painter_at(screen.rect);
    let font = egui::TextStyle::Body.resolve(ui.style());
    let words = painter.layout_no_wrap(text.clone(), font, Color32::WHITE);
    let at = at + vec2(18.0, 14.0);
    let behind = Rect::from_min_size(at, words.size()).expand2(vec2(6.0, 3.0));
    painter.rect_filled(behind, 4.0, Color32::from_black_alpha(190));
    painter.galley(at, words, Color32::WHITE);
    note_value(ui.ctx(), "gizmo.way", || text);
}

/// A step of ways in a scene of this radius: 1, 0.1 and so on, a fiftieth to a fifth of it.
fn step_of(radius: f32) -> f32 {
    let step = 10.0_f32.powf((0.2 * radius).log10().floor());
    if step.is_normal() { step } else { 0.1 }
}

fn rounded(value: f32, step: f32) -> f32 {
    (value / step).round() * step
}

/// Notes for tests where a handle is.
fn mark(ui: &Ui, name: &str, at: Pos2) {
    let rect = Rect::from_center_size(at, vec2(4.0, 4.0));
    let id = ui.id().with(name);
    let _ = ui.interact(rect, id, egui::Sense::hover()).marked(name);
}

/// The step of rings, degrees.
const TURN_STEP: f32 = 15.0;

impl Grab {
    /// The object as moved by the pointer, and the label of the move; in steps of this length, or smoothly.
    fn moved(
        &self,
        camera: &Camera,
        size: Vec2,
        pointer: &PointerFacts,
        to: Vec2,
        step: Option<f32>,
    ) -> (ObjectSettings, String) {
        let (time, radius) = (pointer.time, pointer.radius);
        let mut object = self.object.clone();
        let label = match self.handle {
            Handle::Move(axis) => {
                let [from, to] = [self.from, to]
                    .map(|pixel| along_axis(camera, size, pixel, self.middle, AXES[axis]));
                let way = to - from;
                let way = step.map_or(way, |step| rounded(way, step));
                shift(&mut object, time, (way * AXES[axis]).as_dvec3(), radius);
                format!("{} {way:+.2}", NAMES[axis])
            }
            Handle::Plane => {
                let [from, to] =
                    [self.from, to].map(|pixel| on_plane(camera, size, pixel, self.middle));
                let mut way = to - from;
                if let Some(step) = step {
                    way = way.to_array().map(|way| rounded(way, step)).into();
                }
                shift(&mut object, time, way.as_dvec3(), radius);
                format!("{:+.2} {:+.2} {:+.2}", way.x, way.y, way.z)
            }
            Handle::Turn(axis) => {
                let pixels = [self.from, to];
                let angle = angle_round(camera, size, pixels, self.middle, AXES[axis], self.ring);
                let mut angle = angle.to_degrees();
                if step.is_some() {
                    angle = rounded(angle, TURN_STEP);
                }
                let radians = f64::from(angle).to_radians();
                turn(&mut object, time, AXES[axis].as_dvec3(), radians);
                keep_in_place(&mut object, &self.object, time, [self.pivot; 2], radius);
                format!("{} {angle:+.0}°", NAMES[axis])
            }
            Handle::Scale => String::new(),
        };
        (object, label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round_numbers() {
        for (radius, step) in [(1.0, 0.1), (0.4, 0.01), (5.0, 1.0), (30.0, 1.0), (0.0, 0.1)] {
            let found = step_of(radius);
            assert!((found / step - 1.0).abs() < 1e-5, "{radius}: {found}");
        }
        assert!((rounded(-0.27, 0.1) + 0.3).abs() < 1e-6);
    }
}
