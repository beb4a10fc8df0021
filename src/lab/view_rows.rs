//! Rows of the panel for what `[picture]` and `[camera]` hold. The view changes with the mouse, so each row shows it as a scene
//! file would have it, and a change in the row goes back into the view.

use egui::Ui;
use glam::Vec3;
use myxo::render::camera::MAX_PITCH;
use myxo::render::exposure::Exposure;
use myxo::scene::parameters::{Kind, PARAMETERS, Parameter, why_idle};
use myxo::scene::settings::Settings;

use crate::lab::desk::Desk;
use crate::lab::document::{Document, put_look};
use crate::lab::places::Marked as _;
use crate::lab::rows::{RowContext, editor, row_with, within};
use crate::lab::widgets::{color_map_picker, parse_number, wide_slider};

/// Rows of the section Picture.
pub(super) const COLOR_ROWS: &[&str] =
    &["picture.color_map", "picture.brightest", "picture.darkest"];
/// Rows of the section below it, which begins closed, so that Physarum is visible in a small window.
pub(super) const DETAIL_ROWS: &[&str] = &[
    "picture.particle_size",
    "picture.charts",
    "picture.food",
    "picture.areas",
    "picture.background",
    "picture.ground",
];
/// Rows of the section Camera.
pub(super) const CAMERA_ROWS: &[&str] = &[
    "camera.field_of_view",
    "camera.azimuth",
    "camera.elevation",
    "camera.distance",
    "camera.target",
];
/// Rows of the section Light.
pub(super) const LIGHT_ROWS: &[&str] = &[
    "picture.light_azimuth",
    "picture.light_elevation",
    "picture.occlusion",
    "picture.bloom",
    "picture.wetness",
];

/// The parameter that a row shows.
fn parameter(key: &str) -> &'static Parameter {
    let found = PARAMETERS.iter().find(|parameter| parameter.key == key);
    found.expect("the table has what rows show")
}

/// The rows whose key or name contains the searched text.
pub(super) fn found<'a>(rows: &'a [&'a str], filter: &str) -> Vec<&'a str> {
    let filter = filter.trim().to_lowercase();
    let is_found =
        |key: &&&str| key.contains(&filter) || parameter(key).name.to_lowercase().contains(&filter);
    rows.iter().filter(is_found).copied().collect()
}

/// Why areas cannot be hidden.
const NO_AREAS: &str = "Nothing is painted, and there is no area map: brushes paint areas (B).";

/// The trail with the brightest colour when automatic exposure is turned off, trail units.
const BRIGHTEST: f32 = 50.0;

impl Document {
    /// The settings with what is seen, as a scene file would have them. A camera that fits the scene has no distance of its
    /// own.
    fn as_seen(&self) -> Settings {
        let mut seen = self.edited.clone();
        put_look(&self.view, self.outline.0, &mut seen);
        if self.is_fitted() {
            seen.camera.distance = 0.0;
        }
        seen
    }

    /// The values of the scene as it was loaded, to which resets return.
    fn as_loaded(&self) -> Settings {
        let mut loaded = self.loaded.clone();
        let fits = loaded.camera.distance <= 0.0;
        loaded.camera = self.home.to_settings(self.outline.0);
        if fits {
            loaded.camera.distance = 0.0;
        }
        loaded
    }

    /// Takes over what differs.
    fn look_as(&mut self, before: &Settings, seen: &Settings) {
        if seen.picture != before.picture {
            let show = self.view.show;
            self.view.take(&seen.picture);
            self.view.show = show;
            if matches!(self.view.exposure, Exposure::Auto { .. }) {
                self.view.exposure = Exposure::following();
            }
        }
        let (was, is) = (&before.camera, &seen.camera);
        let center = self.outline.0;
        let camera = &mut self.view.camera;
        if is.azimuth != was.azimuth {
            camera.yaw = is.azimuth.to_radians();
        }
        if is.elevation != was.elevation {
            camera.pitch = is.elevation.to_radians().clamp(-MAX_PITCH, MAX_PITCH);
        }
        if is.target != was.target {
            camera.target = center + camera.scene_radius * Vec3::from_array(is.target);
        }
        if is.field_of_view != was.field_of_view {
            camera.set_field_of_view(is.field_of_view.to_radians());
        }
        if is.distance != was.distance {
            if is.distance > 0.0 {
                camera.distance = is.distance * camera.scene_radius;
            } else {
                self.refit();
            }
        } else if was.distance == 0.0 && is != was {
            // The camera continues to fit the scene, from another side.
            self.refit();
        }
    }
}

/// One row for each of these keys.
pub(super) fn view_rows(ui: &mut Ui, keys: &[&str], desk: &mut Desk<'_>) {
    let (before, loaded) = (desk.document.as_seen(), desk.document.as_loaded());
    let mut seen = before.clone();
    let default = Settings::default();
    let context = RowContext {
        loaded: &loaded,
        default: &default,
        running: &before,
        shared: &before,
        objects: &before.objects,
        prefix: "",
        idle: &|key| match key {
            "picture.areas" if !desk.facts.has_areas => Some(NO_AREAS),
            // The atlas beside the picture has the trail's colours, whatever the picture shows.
            "picture.color_map" | "picture.brightest" | "picture.darkest" if desk.layout.split => {
                None
            }
            _ => why_idle(key, &before),
        },
    };
    for key in keys {
        let parameter = parameter(key);
        row_with(
            ui,
            parameter,
            &mut seen,
            &context,
            |ui, settings| match *key {
                "picture.color_map" => {
                    let before = settings.picture.color_map;
                    color_map_picker(ui, &mut settings.picture.color_map);
                    settings.picture.color_map != before
                }
                "picture.brightest" => brightest(ui, parameter, settings),
                "picture.background" => {
                    ui.horizontal(|ui| {
                        let changed = color(ui, &mut settings.picture.background);
                        editor(ui, key, parameter, settings, &context) || changed
                    })
                    .inner
                }
                _ => editor(ui, key, parameter, settings, &context),
            },
        );
    }
    desk.document.look_as(&before, &seen);
}

/// The trail that gets the brightest colour, 0 for as much as there is; true if it was changed.
fn brightest(ui: &mut Ui, parameter: &Parameter, settings: &mut Settings) -> bool {
    let Kind::Number(number) = &parameter.kind else {
        unreachable!("the brightest trail is a number")
    };
    let value = &mut settings.picture.brightest;
    let before = *value;
    let automatic = *value <= 0.0;
    ui.horizontal(|ui| {
        if !automatic {
            ui.set_max_width(ui.available_width() - 44.0);
            let slider = egui::Slider::new(value, 0.01..=10_000.0);
            let slider = slider.clamping(egui::SliderClamping::Never);
            wide_slider(ui, slider.logarithmic(true).max_decimals(6), parse_number)
                .marked("picture.brightest");
            *value = within(ui, parameter, f64::from(*value), number.range) as f32;
        }
        let auto = ui
            .selectable_label(automatic, "auto")
            .on_hover_text("Follow the picture's own range");
        if auto.marked("auto").clicked() {
            *value = if automatic { BRIGHTEST } else { 0.0 };
        }
    });
    *value != before
}

/// A colour to be clicked; true if another one was chosen.
fn color(ui: &mut Ui, value: &mut [f32; 3]) -> bool {
    let bytes = value.map(|part| (255.0 * part).round() as u8);
    let mut chosen = bytes;
    ui.color_edit_button_srgb(&mut chosen)
        .on_hover_text("Click to choose a colour")
        .marked("picture.background=color");
    if chosen == bytes {
        return false;
    }
    *value = chosen.map(|part| f32::from(part) / 255.0);
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::document::Room;
    use myxo::scene::Scene;

    fn document(distance: f32) -> Document {
        let mut settings = Settings::default();
        settings.camera.distance = distance;
        let scene = Scene::from_settings("torus".to_owned(), settings, ".".into()).unwrap();
        let mut document = Document::new(&scene);
        document.see_as(&scene);
        document.restarted(&scene);
        document
    }

    fn all() -> impl Iterator<Item = &'static str> {
        let rows = [COLOR_ROWS, DETAIL_ROWS, CAMERA_ROWS, LIGHT_ROWS];
        rows.into_iter().flatten().copied()
    }

    #[test]
    fn every_key_of_a_picture_has_a_row_or_buttons() {
        let of_view = PARAMETERS
            .iter()
            .filter(|p| matches!(p.section(), "picture" | "camera"));
        let mut keys: Vec<_> = of_view.map(|parameter| parameter.key).collect();
        keys.retain(|key| *key != "picture.show");
        let mut rows: Vec<_> = all().collect();
        keys.sort_unstable();
        rows.sort_unstable();
        assert_eq!(keys, rows);
    }

    #[test]
    fn nothing_is_marked_before_it_is_changed() {
        for distance in [0.0, 3.0, 3.281_736_4] {
            let mut document = document(distance);
            for size in [[800.0, 600.0], [300.0, 900.0]] {
                let room = Room {
                    size: size.into(),
                    covered: 0.0,
                };
                document.keep_fitting(room, Vec::new(), false);
                let (seen, loaded) = (document.as_seen(), document.as_loaded());
                assert_eq!((seen.camera, seen.picture), (loaded.camera, loaded.picture));
            }
        }
    }

    #[test]
    fn typed_values_are_seen() {
        for key in all() {
            let mut document = document(0.0);
            let before = document.as_seen();
            let mut wanted = before.clone();
            match &parameter(key).kind {
                Kind::Number(number) => {
                    let (low, high) = number.slider;
                    (number.set)(&mut wanted, low + 0.4 * (high - low));
                }
                Kind::Vector { set, .. } => set(&mut wanted, [0.25, 0.5, 0.75]),
                Kind::Choice { get, set, .. } => {
                    let other = usize::from(get(&wanted) == 0);
                    set(&mut wanted, other);
                }
                _ => unreachable!("pictures have neither texts nor values of objects"),
            }
            assert_ne!(wanted, before, "{key}");
            document.look_as(&before, &wanted);
            let seen = document.as_seen();
            assert_eq!(seen.picture, wanted.picture, "{key}");
            assert_eq!(seen.camera, wanted.camera, "{key}");
            // And back.
            document.look_as(&seen, &before);
            let back = document.as_seen();
            assert_eq!(back.picture, before.picture, "{key}");
            assert_eq!(back.camera, before.camera, "{key}");
        }
    }
}
