//! The axes of the world in the corner of the picture: a click on an end looks along it, a drag turns the camera.

use egui::{Align2, Area, Color32, Pos2, Rect, Response, Sense, Stroke, Ui, pos2, vec2};
use glam::{Vec2, Vec3};
use myxo::render::Camera;
use myxo::render::camera::Side;

use crate::lab::desk::Desk;
use crate::lab::places::Marked as _;
use crate::lab::theme;

/// Half of its size, and the length of the axes, points.
const HALF: f32 = 40.0;
const LENGTH: f32 = 28.0;
/// The radii of the ends, points.
const END: f32 = 8.0;
const FAR_END: f32 = 5.0;
/// A drag turns the camera as one so many times as long in the picture.
const FASTER: f32 = 2.0;

/// The ends of the axes: the direction, the side that is looked from, the letter, and the name.
static ENDS: [(Vec3, Side, &str, &str); 6] = [
    (Vec3::X, Side::Right, "X", "x"),
    (Vec3::NEG_X, Side::Left, "", "-x"),
    (Vec3::Y, Side::Top, "Y", "y"),
    (Vec3::NEG_Y, Side::Bottom, "", "-y"),
    (Vec3::Z, Side::Front, "Z", "z"),
    (Vec3::NEG_Z, Side::Back, "", "-z"),
];

/// What was done with the axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turned {
    /// The drag of this frame, points of the picture.
    pub drag: Vec2,
    /// The side to look from.
    pub side: Option<Side>,
}

/// Shows the axes as `camera` sees them, if the picture has room for them.
pub fn show_axes(ui: &Ui, picture: Rect, camera: &Camera, desk: &Desk<'_>) -> Turned {
    let mut turned = Turned::default();
    let is_small = picture.width() < 260.0 || picture.height() < 330.0;
    if is_small || desk.document.view.show.is_flat() {
        return turned;
    }
    let size = vec2(2.0 * HALF, 2.0 * HALF);
    let area = Area::new("axes".into())
        .order(egui::Order::Background)
        .fixed_pos(picture.right_bottom() - size - vec2(8.0, 8.0));
    area.show(ui.ctx(), |ui| {
        let (rect, ground) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let is_near = ground.contains_pointer() || ground.dragged();
        if is_near {
            let fill = theme::panel(ui).gamma_multiply(0.7);
            ui.painter().circle_filled(rect.center(), HALF, fill);
        }
        if ground.dragged() {
            let by = FASTER * ground.drag_delta();
            turned.drag = Vec2::new(by.x, by.y);
        }
        let ground = ground.marked("axes");
        let mut is_on_end = false;
        for end in in_order(camera) {
            let shown = show_end(ui, rect.center(), camera, end);
            is_on_end |= shown.hovered();
            if shown.clicked() {
                turned.side = Some(end.1);
            }
        }
        if !is_on_end {
            ground.on_hover_text("Drag to turn the camera; click an end to look along its axis");
        }
    });
    turned
}

/// The ends, the farthest first.
fn in_order(camera: &Camera) -> [&'static (Vec3, Side, &'static str, &'static str); 6] {
    let mut ends = ENDS.each_ref();
    let depth = |end: &(Vec3, Side, &str, &str)| end.0.dot(camera.backward());
    ends.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
    ends
}

/// Shows an end.
fn show_end(
    ui: &mut Ui,
    middle: Pos2,
    camera: &Camera,
    (axis, side, letter, name): &(Vec3, Side, &str, &str),
) -> Response {
    let at = pos2(
        middle.x + LENGTH * axis.dot(camera.right()),
        middle.y - LENGTH * axis.dot(camera.up()),
    );
    let is_named = !letter.is_empty();
    let radius = if is_named { END } else { FAR_END };
    let rect = Rect::from_center_size(at, 2.0 * vec2(radius, radius));
    let end = ui.interact(rect, ui.id().with(name), Sense::click());
    let strength = 0.55 + 0.45 * axis.dot(camera.backward());
    let color = color_of(*axis).lerp_to_gamma(theme::panel(ui), 0.6 * (1.0 - strength).max(0.0));
    let painter = ui.painter();
    if is_named {
        painter.line_segment([middle, at], Stroke::new(2.0, color));
        painter.circle_filled(at, radius, color);
        let font = egui::FontId::proportional(11.0);
        painter.text(at, Align2::CENTER_CENTER, letter, font, Color32::BLACK);
    } else {
        painter.circle_filled(at, radius, color.gamma_multiply(0.5));
    }
    if end.hovered() {
        let line = Stroke::new(1.5, ui.visuals().strong_text_color());
        painter.circle_stroke(at, radius, line);
    }
    let titles = Side::ALL.iter().find(|(known, _)| known == side);
    let title = titles.map_or("", |(_, title)| title).to_lowercase();
    let end = end.on_hover_text(format!("From the {title}"));
    end.marked(&format!("axis={name}"))
}

fn color_of(axis: Vec3) -> Color32 {
    match axis.abs() {
        Vec3::X => Color32::from_rgb(0xe8, 0x6a, 0x5c),
        Vec3::Y => Color32::from_rgb(0x7f, 0xc2, 0x5a),
        _ => Color32::from_rgb(0x5c, 0x9c, 0xf0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: an end that leads to another side than the one that it points to.
    #[test]
    fn each_end_looks_along_its_axis() {
        for (axis, side, ..) in &ENDS {
            let (axis, side) = (*axis, *side);
            let mut camera = Camera::default();
            camera.look_from(side);
            assert!(camera.backward().dot(axis) > 0.999, "{side:?}");
            let (nearest, ..) = in_order(&camera)[5];
            assert_eq!(*nearest, axis);
        }
    }
}
