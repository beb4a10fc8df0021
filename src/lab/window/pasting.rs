//! Scenes from the clipboard: the running scene takes over one that differs only in settings that can change while it runs; any
//! other is loaded and starts at step 0.

use std::path::{Path, PathBuf};

use myxo::Result;
use myxo::scene::file::Reader;
use myxo::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS};
use myxo::scene::settings::{ObjectSettings, Settings};
use myxo::scene::{Scene, SceneError, foods};

use crate::lab::loading::Origin;
use crate::lab::saving::whole;
use crate::lab::window::Lab;

impl Lab {
    /// Takes a scene from text. An error in it is shown in a notice and changes nothing.
    pub(crate) fn paste(&mut self, text: &str) {
        let settings = match read_scene(text) {
            Ok(settings) => settings,
            Err(error) => return self.notify(error.to_string(), true),
        };
        // A scene on its way cannot be compared with.
        let stage = self
            .runner
            .stage
            .as_ref()
            .filter(|_| self.jobs.loading.is_none());
        let live = stage.and_then(|stage| {
            let runs = stage.simulation.settings();
            let settings = as_it_runs(runs, &settings, &self.interface.document.folder)?;
            Some(Scene {
                settings,
                ..stage.scene.clone()
            })
        });
        if let Some(scene) = live {
            let before = self.interface.clone();
            self.interface.continue_as(&scene);
            if self.apply() {
                // It is another scene, and the one before has its file.
                self.interface.document.file = None;
                let text = format!(
                    "{} continues as pasted (R restarts)",
                    self.interface.document.name
                );
                self.notify(text, false);
            } else {
                self.interface.put_back(before);
                let wanted = self.interface.document.live_settings();
                if let Some(stage) = &self.runner.stage {
                    self.jobs.food.want(&stage.simulation, &wanted);
                }
            }
            return;
        }
        let (name, folder) = self.interface.document.name_and_folder();
        self.load(name.clone(), Origin::NoFile, move || {
            Ok(Scene::from_settings(name, settings, folder)?)
        });
    }
}

/// The settings that were read, with the names of the running scene, if that can take them over without a restart. Relative
/// paths of meshes start at `folder`.
fn as_it_runs(running: &Settings, read: &Settings, folder: &Path) -> Option<Settings> {
    if read.objects.len() != running.objects.len() {
        return None;
    }
    let mut settings = read.clone();
    if settings.radius == 0.0 {
        // The radius of the running scene was measured.
        settings.radius = running.radius;
    }
    let pairs = settings.objects.iter_mut().zip(&running.objects);
    for (object, runs) in pairs {
        if mesh_file(object, folder) != mesh_file(runs, folder) {
            return None;
        }
        object.mesh.clone_from(&runs.mesh);
        if object.name.is_empty() {
            object.name.clone_from(&runs.name);
        }
        let restarts = OBJECT_PARAMETERS.iter().any(|p| p.restarts(runs, object));
        let is_as_it_was = object.name == runs.name
            && object.distance_to == runs.distance_to
            && object.glue == runs.glue;
        if restarts || !is_as_it_was {
            return None;
        }
    }
    if let [only] = &running.objects[..] {
        for food in settings.foods.iter_mut().filter(|f| f.object.is_empty()) {
            food.object.clone_from(&only.name);
        }
    }
    let restarts = PARAMETERS.iter().any(|p| p.restarts(running, &settings));
    // The loader reports what is wrong with food.
    (!restarts && foods::problems(&settings).is_empty()).then_some(settings)
}

/// The path of a mesh, also if it is relative.
fn mesh_file(object: &ObjectSettings, folder: &Path) -> PathBuf {
    if object.mesh.starts_with("builtin:") {
        return PathBuf::from(&object.mesh);
    }
    whole(&folder.join(&object.mesh))
}

/// A scene's settings from text.
fn read_scene(text: &str) -> Result<Settings> {
    let mut reader = Reader::new(Settings::default());
    reader.text("clipboard", text);
    Ok(reader.finish().map_err(|problems| SceneError::Problems {
        scene: "clipboard".into(),
        problems,
    })?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_settings_that_can_change_while_it_runs_are_taken_over() {
        let folder = Path::new("scenes");
        let read = |text: &str| read_scene(text).expect("it is a scene");
        let mut running = read("[[object]]\nname = \"ball\"\nmesh = \"ball.obj\"\n");
        running.radius = 2.5;
        let mesh = std::path::absolute("scenes/ball.obj").expect("there is a folder");
        let object = format!("[[object]]\nmesh = '{}'\n", mesh.display());
        let pasted = |text: &str| as_it_runs(&running, &read(text), folder);
        // Wherever its mesh is named from, and however it is looked at.
        let live = "[trail]\ndecay = 0.5\n[picture]\nshow = \"glow\"\n[camera]\ndistance = 9\n";
        let taken = pasted(&format!("{live}{object}position = [1, 0, 0]\n")).expect("it is live");
        assert_eq!(taken.objects[0].mesh, "ball.obj");
        assert_eq!(taken.objects[0].name, "ball");
        assert_eq!(taken.objects[0].position, [1.0, 0.0, 0.0]);
        assert_eq!((taken.radius, taken.trail.decay), (2.5, 0.5));
        assert_eq!(taken.camera.distance, 9.0);
        // Everything else needs a restart.
        for text in [
            format!("[particles]\ncount = 7000\n{object}"),
            format!("[atlas]\nsize = 64\n{object}"),
            format!("seed = 8\n{object}"),
            format!("radius = 3\n{object}"),
            format!("{object}scale = 2\n"),
            format!("{object}name = \"other\"\n"),
            format!("{object}{object}"),
            "[[object]]\nmesh = \"other.obj\"\n".to_owned(),
            "[[object]]\nmesh = \"builtin:cube\"\n".to_owned(),
        ] {
            assert_eq!(pasted(&text), None, "{text}");
        }
    }
}
