//! Overlays of the tools over the picture: the brush as a ring on the surface, the outline of the picked object, the probe.

use std::time::Duration;

use egui::{Pos2, Rect, RichText, Stroke, Ui, vec2};
use glam::Vec3;

use myxo::plain_text::with_commas;
use myxo::sim::paint::NO_GO_BELOW;

use crate::lab::desk::Desk;
use crate::lab::facts::Under;
use crate::lab::places::note_value;
use crate::lab::theme;
use crate::lab::tools::gizmo::Screen;
use crate::lab::tools::{Tool, Tools};

const PARTS: u32 = 64;
/// How often the probe looks again while nothing else happens.
const PROBE_INTERVAL: Duration = Duration::from_millis(50);

impl Tools {
    /// Draws it over the picture.
    pub(crate) fn show(&mut self, ui: &Ui, picture: Rect, desk: &Desk<'_>) {
        let facts = desk.facts;
        // Nothing of it has a place on the atlas.
        if desk.document.view.show.is_flat() {
            return;
        }
        let screen = Screen::of(ui, picture);
        if desk.layout.alone {
            self.brush_alone(ui, screen, desk);
            return;
        }
        self.outline_picked(ui, screen, desk);
        if let Some((at, size)) = self.food.and_then(|food| facts.pointer.foods.get(food)) {
            let to_eye = (desk.document.view.camera.eye() - *at).normalize_or(Vec3::Z);
            self.ring(ui, screen, *at, to_eye, 1.3 * size, desk);
        }
        self.brush_alone(ui, screen, desk);
        if self.pointer.is_none() {
            return;
        }
        let Some(under) = &facts.pointer.under else {
            return;
        };
        if self.tool == Tool::Food {
            let size = self.next_food.size.max(0.01) * facts.pointer.radius;
            self.ring(ui, screen, under.position, under.normal, size, desk);
        }
        if self.tool == Tool::Pulse {
            // The front where it begins.
            let radius = 0.5 * self.pulse.width * facts.pointer.radius;
            self.ring(ui, screen, under.position, under.normal, radius, desk);
        }
        if self.probe {
            self.probe(ui, picture, desk, under);
        }
    }

    /// The ring where a brush would paint. While the panel is hidden, nothing else is shown.
    fn brush_alone(&self, ui: &Ui, screen: Screen, desk: &Desk<'_>) {
        let facts = desk.facts;
        let under = facts.pointer.under.as_ref();
        let under = under.filter(|_| self.pointer.is_some() && self.tool.is_brush());
        if let Some(under) = under {
            let radius = self.radius * facts.pointer.radius;
            self.ring(ui, screen, under.position, under.normal, radius, desk);
        }
    }

    fn ring(
        &self,
        ui: &Ui,
        screen: Screen,
        middle: Vec3,
        normal: Vec3,
        radius: f32,
        desk: &Desk<'_>,
    ) {
        let side = normal.any_orthonormal_vector();
        let other = normal.cross(side);
        let points = (0..=PARTS).filter_map(|i| {
            let angle = i as f32 / PARTS as f32 * std::f32::consts::TAU;
            let (sin, cos) = angle.sin_cos();
            let place = middle + radius * (cos * side + sin * other);
            screen.point(&desk.document.view.camera, place)
        });
        let points: Vec<Pos2> = points.collect();
        let painter = ui.painter_at(screen.rect);
        let color = match self.tool {
            Tool::Repel | Tool::NoGo => theme::error(ui),
            Tool::Erase => egui::Color32::WHITE,
            _ => theme::accent(ui),
        };
        // Seen on light and on dark.
        let dark = egui::Color32::from_black_alpha(140);
        painter.line(points.clone(), Stroke::new(3.5, dark));
        painter.line(points, Stroke::new(1.5, color));
        if let Some(middle) = screen.point(&desk.document.view.camera, middle) {
            painter.circle_filled(middle, 2.0, color);
        }
    }

    /// A line round the picked object, and its name.
    fn outline_picked(&self, ui: &Ui, screen: Screen, desk: &Desk<'_>) {
        let facts = desk.facts;
        let Some(object) = self.selected else {
            return;
        };
        let (Some(pose), Some(vertices)) =
            (facts.pointer.poses.get(object), self.vertices.get(object))
        else {
            return;
        };
        let scale = self.scaled() * desk.document.pending_scale(object);
        let seen = vertices.iter().filter_map(|vertex| {
            let place = pose.transform_point3(scale * *vertex);
            screen.point(&desk.document.view.camera, place)
        });
        let hull = hull(seen.collect());
        let painter = ui.painter_at(screen.rect);
        let Some(top) = hull.iter().copied().min_by(|a, b| a.y.total_cmp(&b.y)) else {
            return;
        };
        // Lines on the picture are not those of the interface: it is dark in both.
        let color = egui::Color32::WHITE;
        let dark = egui::Color32::from_black_alpha(150);
        for stroke in [Stroke::new(4.5, dark), Stroke::new(1.5, color)] {
            painter.add(egui::Shape::closed_line(hull.clone(), stroke));
        }
        let name = desk
            .document
            .edited
            .objects
            .get(object)
            .map(|object| object.name.as_str());
        let font = egui::TextStyle::Small.resolve(ui.style());
        let text = painter.layout_no_wrap(name.unwrap_or_default().to_owned(), font, color);
        // Read over any trail, and in the picture.
        let size = text.size() + vec2(10.0, 4.0);
        let corner = top - vec2(0.5 * size.x, 6.0 + size.y);
        let last = screen.rect.max - size;
        let corner = corner.max(screen.rect.min).min(last.max(screen.rect.min));
        let rect = Rect::from_min_size(corner, size);
        painter.rect_filled(rect, 3.0, egui::Color32::from_black_alpha(190));
        painter.galley(corner + vec2(5.0, 2.0), text, color);
    }

    fn probe(&self, ui: &Ui, picture: Rect, desk: &Desk<'_>, under: &Under) {
        let facts = desk.facts;
        let Some(at) = ui.input(|i| i.pointer.latest_pos()) else {
            return;
        };
        // Values from the device arrive with the next frames.
        ui.ctx().request_repaint_after(PROBE_INTERVAL);
        let name =
            (desk.document.running.objects.get(under.object)).map(|object| object.name.clone());
        let number = |value: Option<f32>| match value {
            Some(value) => format!("{value:.4}"),
            None => "...".to_owned(),
        };
        let mut lines = vec![
            ("object", name.unwrap_or_default()),
            ("triangle", with_commas(f64::from(under.triangle))),
            ("uv", format!("{:.3}  {:.3}", under.uv[0], under.uv[1])),
            ("texel", format!("{}  {}", under.texel[0], under.texel[1])),
            ("trail", number(under.trail)),
        ];
        if desk.document.running.objects.len() > 1 {
            let is_far =
                (under.distance).is_some_and(|away| away.abs() > 0.999 * facts.pointer.reach);
            let away = match under.distance {
                Some(_) if is_far => format!("over {}", facts.pointer.reach),
                away => number(away),
            };
            lines.push(("to others", format!("{away} radii")));
        }
        if let Some(bias) = under.bias {
            let painted = match bias {
                bias if bias < NO_GO_BELOW => "no-go".to_owned(),
                0.0 => "nothing".to_owned(),
                bias => format!("{bias:+.3}"),
            };
            lines.push(("painted", painted));
        }
        for (what, value) in &lines {
            note_value(ui.ctx(), &format!("probe.{what}"), || value.clone());
        }
        let room = vec2(190.0, 130.0);
        let right = at.x + 18.0 + room.x < picture.right();
        let below = at.y + 18.0 + room.y < picture.bottom();
        let corner = vec2(
            if right { 18.0 } else { -room.x },
            if below { 18.0 } else { -room.y },
        );
        egui::Area::new("probe".into())
            .fixed_pos(at + corner)
            .interactable(false)
            .show(ui.ctx(), |ui| {
                egui::Frame::popup(ui.style()).show(ui, |ui| {
                    egui::Grid::new("probe")
                        .num_columns(2)
                        .spacing(vec2(10.0, 2.0))
                        .show(ui, |ui| {
                            for (what, value) in lines {
                                ui.label(RichText::new(what).small().color(theme::weak(ui)));
                                ui.label(RichText::new(value).small().monospace());
                                ui.end_row();
                            }
                        });
                });
            });
    }
}

impl super::Tools {
    /// How many times as large the selected object becomes by the handle that is held.
    pub fn scaled(&self) -> f32 {
        self.grab.as_ref().map_or(1.0, |grab| grab.scaled)
    }
}

/// The convex hull of points, in order round it (Andrew's monotone chain, 1979).
fn hull(mut points: Vec<Pos2>) -> Vec<Pos2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let mut chain: Vec<Pos2> = Vec::new();
    let turns_right = |chain: &[Pos2], next: Pos2| {
        let [.., a, b] = chain else { return false };
        let (ab, ac) = (*b - *a, next - *a);
        ab.x * ac.y - ab.y * ac.x <= 0.0
    };
    let half = |chain: &mut Vec<Pos2>, points: &mut dyn Iterator<Item = Pos2>| {
        let first = chain.len();
        for point in points {
            while chain.len() > first + 1 && turns_right(&chain[first..], point) {
                chain.pop();
            }
            chain.push(point);
        }
        // The last point is the first of the other half.
        chain.pop();
    };
    half(&mut chain, &mut points.iter().copied());
    half(&mut chain, &mut points.iter().rev().copied());
    chain
}

/// A triangle's normal, turned to the eye.
pub(crate) fn normal_towards(corners: [Vec3; 3], eye: Vec3) -> Vec3 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize_or(Vec3::Y);
    if normal.dot(eye - a) < 0.0 {
        -normal
    } else {
        normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::pos2;

    #[test]
    fn a_hull_goes_round_all_points_once() {
        let mut points: Vec<Pos2> = (0..60)
            .map(|i| {
                let angle = i as f32 * 0.7;
                pos2(angle.cos(), angle.sin()) + vec2(3.0, -2.0)
            })
            .collect();
        points.extend([pos2(3.0, -2.0), pos2(3.1, -2.2)]);
        let round = hull(points.clone());
        assert_eq!(round.len(), 60);
        let square = [
            pos2(0.0, 0.0),
            pos2(1.0, 1.0),
            pos2(1.0, 0.0),
            pos2(0.0, 1.0),
        ];
        let inside = pos2(0.4, 0.6);
        let round = hull(square.into_iter().chain([inside]).collect());
        assert_eq!(round.len(), 4);
        assert!(!round.contains(&inside));
    }
}
