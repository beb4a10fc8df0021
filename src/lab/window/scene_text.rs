//! The scene as it is edited and looked at, as the text of a scene file that can be opened.

use std::path::{Path, PathBuf};

use myxo::mesh::Mesh;
use myxo::plain_text::Shown as _;
use myxo::scene::Scene;
use myxo::scene::settings::{AreaSettings, Settings};
use myxo::sim::Simulation;
use myxo::sim::areas::{AreaMap, keep_beside};
use myxo::sim::start::Masks;
use myxo::{Error, Result};

use crate::lab::document::put_look;
use crate::lab::objects::begin_on_food_that_is;
use crate::lab::window::Lab;

/// The remark on a second look that was painted, for which scene files have no place.
pub(crate) const WITHOUT_LOOK: &str =
    ", without the second look that was painted: checkpoints have it";

/// A scene file on its way.
#[derive(Debug, Default)]
pub(crate) struct SceneText {
    /// The text.
    pub text: String,
    /// The map of areas that was written beside it.
    map: Option<PathBuf>,
    /// Why areas are missing that were painted.
    lacks: Option<Error>,
    /// Why what waits for a restart is missing.
    waits: Option<Error>,
    /// A second look that was painted is missing.
    lacks_look: bool,
}

impl SceneText {
    /// The remark on areas for a notice.
    pub fn remark(&self) -> String {
        let map = self.map.as_ref().and_then(|map| map.file_name());
        let with = map.map(|map| format!(", with painted areas in {}", Path::new(map).shown()));
        with.unwrap_or_default() + &self.lacking()
    }

    /// The remark on what is missing.
    pub fn lacking(&self) -> String {
        let lacks = self.lacks.as_ref();
        let lacks = lacks.map(|error| format!(", without the areas that were painted: {error}"));
        let waits = self.waits.as_ref().map(|error| {
            format!(", without the changes that wait for a restart, which would not work: {error}")
        });
        let look = if self.lacks_look { WITHOUT_LOOK } else { "" };
        lacks.unwrap_or_default() + look + &waits.unwrap_or_default()
    }

    /// Does it have everything?
    pub fn has_all(&self) -> bool {
        self.lacks.is_none() && self.waits.is_none() && !self.lacks_look
    }
}

/// Has it a second look that was painted? Weights that cannot be read count as painted.
pub(crate) fn has_painted_look(simulation: &Simulation) -> bool {
    match simulation.looks() {
        Ok(looks) => are_painted(&looks, &simulation.setup().looks),
        Err(_) => true,
    }
}

/// Are these weights of a second look painted, and not those of the scene's map? Where there are none, all are 0.
fn are_painted(looks: &[f32], of_map: &[f32]) -> bool {
    let are_zero = |weights: &[f32]| weights.iter().all(|weight| *weight == 0.0);
    looks != of_map && !(are_zero(looks) && are_zero(of_map))
}

impl Lab {
    /// The scene as it is edited and looked at; none before there is one.
    pub(crate) fn scene_text(&self) -> Option<SceneText> {
        let (settings, waits) = self.settings_that_work();
        Some(SceneText {
            text: self.text_of(settings, None)?,
            waits,
            ..SceneText::default()
        })
    }

    /// The text for a file of this path, with the present areas in a map beside it.
    pub(crate) fn scene_text_at(&self, file: &Path) -> Result<SceneText> {
        let (settings, waits) = self.settings_that_work();
        let only = |settings| SceneText {
            text: self.text_of(settings, None).unwrap_or_default(),
            ..SceneText::default()
        };
        let Some(stage) = &self.runner.stage else {
            let text = only(settings);
            return Ok(SceneText { waits, ..text });
        };
        let (simulation, setup) = (&stage.simulation, stage.simulation.setup());
        let lacks_look = has_painted_look(simulation);
        let (bias, lacks) = match simulation.areas() {
            Ok(bias) => (bias, None),
            Err(error) => (setup.bias.clone(), Some(error)),
        };
        // Another map that waits for a restart is wanted, unless it costs what was painted.
        let has_other_map = settings.areas != simulation.settings().areas;
        if has_other_map && bias == setup.bias {
            let text = only(settings);
            return Ok(SceneText {
                lacks,
                waits,
                lacks_look,
                ..text
            });
        }
        let (areas, map) = keep_beside(file, &bias, &setup.atlas)?;
        Ok(SceneText {
            text: self.text_of(settings, Some(&areas)).unwrap_or_default(),
            map,
            lacks,
            waits,
            lacks_look,
        })
    }

    fn text_of(&self, settings: Settings, areas: Option<&AreaSettings>) -> Option<String> {
        let mut scene = self.runner.scene()?.clone();
        scene.settings = settings;
        put_look(
            &self.interface.document.view,
            scene.center,
            &mut scene.settings,
        );
        Some(match areas {
            Some(areas) => scene.to_toml_beside(areas),
            None => scene.to_toml(),
        })
    }

    /// The settings as they are edited. If no scene could start with the edits that wait for a restart, it returns the settings
    /// without them, and the error.
    pub(crate) fn settings_that_work(&self) -> (Settings, Option<Error>) {
        let mut edited = self.interface.document.edited.clone();
        // Food comes and goes while the scene runs, and where it began no longer matters.
        begin_on_food_that_is(&mut edited);
        if !self.interface.document.is_pending() {
            return (edited, None);
        }
        match self.try_to_begin(edited.clone()) {
            Ok(()) => (edited, None),
            Err(error) => {
                let mut live = self.interface.document.live_settings();
                begin_on_food_that_is(&mut live);
                (live, Some(error))
            }
        }
    }

    /// Does what a scene needs to begin with these settings, short of the layout of its texture, which may take minutes.
    fn try_to_begin(&self, settings: Settings) -> Result<()> {
        let (name, folder) = self.interface.document.name_and_folder();
        let map = settings.areas.map.clone();
        let strength = settings.areas.strength;
        let scene = match self.meshes_for(&settings) {
            Some(meshes) => Scene::from_meshes(name, settings, meshes, folder),
            None => Scene::from_settings(name, settings, folder),
        }?;
        // The running scene has started, so its pictures are right.
        let runs = self.runner.scene().map(|scene| &scene.settings);
        if runs.is_none_or(|runs| runs.starts() != scene.settings.starts()) {
            Masks::open(&scene)?;
        }
        if map.is_empty() || runs.is_some_and(|runs| runs.areas == scene.settings.areas) {
            return Ok(());
        }
        let map = AreaMap::open(scene.settings.areas.map.as_ref(), scene.settings.atlas.size)?;
        let stage = self.runner.stage.as_ref();
        if let Some(stage) =
            stage.filter(|stage| stage.scene.settings.atlas == scene.settings.atlas)
        {
            map.bias(&stage.simulation.setup().atlas, strength)?;
        }
        Ok(())
    }

    /// The meshes in memory, if these settings need no others.
    pub(crate) fn meshes_for(&self, settings: &Settings) -> Option<Vec<Mesh>> {
        let scene = self.runner.scene()?;
        let there = scene.settings.objects.iter().map(|object| &object.mesh);
        let wanted = settings.objects.iter().map(|object| &object.mesh);
        there.eq(wanted).then(|| scene.meshes.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Would catch: a painted second look that a scene file is said to have, and one that is said to be painted once all of it is
    /// undone or erased.
    #[test]
    fn a_second_look_that_was_painted_is_missing_in_scene_files() {
        for (looks, of_map, wanted) in [
            (&[0.0, 0.5][..], &[0.0, 0.5_f32][..], false),
            (&[], &[], false),
            (&[0.0, 0.5], &[], true),
            (&[0.0, 0.0], &[], false),
            (&[0.0, 0.0], &[0.0, 0.5], true),
            (&[], &[0.0, 0.5], true),
        ] {
            assert_eq!(are_painted(looks, of_map), wanted, "{looks:?}, {of_map:?}");
        }
        let has_all = SceneText::default();
        assert!(has_all.has_all() && has_all.lacking().is_empty());
        let lacks = SceneText {
            lacks_look: true,
            ..SceneText::default()
        };
        assert!(!lacks.has_all());
        assert_eq!(lacks.remark(), WITHOUT_LOOK);
    }
}
