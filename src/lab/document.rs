//! The document: the settings of the scene as they were loaded, as they run and as they are edited, its look, and the history
//! for undo and redo. Plain data, without a window and without a device.

use std::path::PathBuf;

use glam::{Vec2, Vec3};
use myxo::render::exposure::Exposure;
use myxo::render::{Camera, View, view};
use myxo::scene::parameters::{OBJECT_PARAMETERS, PARAMETERS};
use myxo::scene::settings::{Settings, Show};
use myxo::scene::{Scene, presets};

use crate::lab::marks::Marks;
use crate::lab::presets::Morph;
use crate::lab::renewal::{are_built_alike, place_among, take_back, with_changes_since};
use crate::lab::saving::SceneFile;
use crate::lab::undo::{Entry, Undo};

/// A scene with its settings and its look.
#[derive(Clone, Debug)]
pub struct Document {
    /// The scene's name, or, before there is one, the name of the first that is loaded.
    pub name: String,
    /// The folder that its relative paths start from.
    pub folder: PathBuf,
    /// The file that it was opened from or saved in, if there is one.
    pub file: Option<SceneFile>,
    /// As it was loaded; resets of single values return to it.
    pub loaded: Settings,
    /// The settings that the simulation runs with.
    pub running: Settings,
    /// The settings that the panel shows.
    pub edited: Settings,
    /// The view that the picture shows.
    pub view: View,
    /// The look that the present one is changing into, slowly.
    pub morph: Option<Morph>,
    /// Does the simulation run, or is it paused?
    pub playing: bool,
    /// The preset that was taken last, or whose look the scene had when it was loaded.
    pub preset: Option<String>,
    /// The history for undo and redo.
    pub undo: Undo,
    /// Objects that are hidden or locked.
    pub marks: Marks,
    /// The edited settings with which the scene is being loaded again, while it is on its way.
    pub asked: Option<Settings>,
    /// Objects that come, go or grow are on their way.
    renews: bool,
    /// The points that a fit brings into the picture: the scene's centre and every vertex.
    pub outline: (Vec3, Vec<Vec3>),
    /// The camera of the last fit and its picture. As long as the camera is that one, it keeps fitting.
    pub fitted: Option<(Camera, Room)>,
    /// The scene's own camera.
    pub home: Camera,
    /// The camera was moved at once in this frame, and the picture is to follow slowly.
    pub eases: bool,
}

/// The picture, in points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Room {
    /// Width and height.
    pub size: Vec2,
    /// The width of what covers its right side.
    pub covered: f32,
}

/// The result of undo or redo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    /// Other objects must be loaded; else the running simulation takes the settings over.
    pub renews: bool,
    /// None was on its way yet.
    pub begins_renewal: bool,
    /// Painted areas must be as after this stroke.
    pub stroke: Option<u64>,
    /// The scene must continue from this kept state.
    pub state: Option<u64>,
}

impl Document {
    /// A scene that has just been loaded.
    pub fn new(scene: &Scene) -> Self {
        let settings = &scene.settings;
        let view = View::of(scene, Vec2::ONE);
        Self {
            name: scene.name.clone(),
            folder: scene.folder.clone(),
            file: None,
            loaded: settings.clone(),
            running: settings.clone(),
            edited: settings.clone(),
            view,
            morph: None,
            playing: true,
            preset: None,
            undo: Undo::new(settings, &view),
            asked: None,
            marks: Marks::default(),
            renews: false,
            outline: (Vec3::ZERO, Vec::new()),
            fitted: None,
            home: Camera::default(),
            eases: false,
        }
    }

    /// Another scene has been loaded.
    pub fn open(&mut self, scene: &Scene) {
        self.loaded = scene.settings.clone();
        self.asked = None;
    }

    /// Nothing can be undone, and nothing is unsaved.
    pub fn forget_changes(&mut self) {
        self.undo = Undo::new(&self.edited, &self.view);
        self.undo.set_preset(self.preset.as_deref());
    }

    /// The view that a scene's file asks for.
    pub fn see_as(&mut self, scene: &Scene) {
        self.view = View::of(scene, Vec2::ONE);
        if matches!(self.view.exposure, Exposure::Auto { .. }) {
            self.view.exposure = Exposure::following();
        }
        if self.view.show.why_not(&scene.settings).is_some() {
            self.view.show = Show::default();
        }
        // In the window the camera turns about the middle of the scene.
        self.view.camera = Camera::from_settings(
            &scene.settings.camera,
            scene.center,
            scene.radius,
            Vec2::ONE,
        );
        let camera = self.view.camera;
        self.home = camera;
        // Only the first frame has the size of the picture.
        let is_free = scene.settings.camera.distance <= 0.0;
        self.fitted = is_free.then_some((camera, Room::default()));
    }

    /// The scene runs from step 0, with its settings. Changes made while it was being loaded are kept as edits.
    pub fn restarted(&mut self, scene: &Scene) {
        self.running = scene.settings.clone();
        let asked = self.asked.take();
        let since = asked.map(|asked| with_changes_since(&asked, &self.edited, &self.running));
        self.edited = since.unwrap_or_else(|| self.running.clone());
        self.renews = false;
        self.outline = (scene.center, view::points(scene).collect());
        let points = self.outline.1.iter().copied();
        self.view.ground = view::Ground::under(points, scene.center, scene.radius);
    }

    /// The scene on its way is not shown. Returns true if it would have changed objects: then the running objects are edited
    /// again.
    pub fn not_shown(&mut self) -> bool {
        self.asked = None;
        let renewed = std::mem::take(&mut self.renews);
        if renewed {
            take_back(&mut self.edited, &self.running);
            self.undo.note(&self.edited, &self.view);
        }
        renewed
    }

    /// Are objects that come, go or grow on their way?
    pub fn is_renewed(&self) -> bool {
        self.renews
    }

    /// How many times as large an object will be when what is on its way is there; 1 where nothing is.
    pub fn pending_scale(&self, object: usize) -> f32 {
        let Some(running) = self.running.objects.get(object).filter(|_| self.renews) else {
            return 1.0;
        };
        // While others come or go it is in another place.
        match place_among(&self.edited.objects, running) {
            Some(place) => self.edited.objects[place].scale / running.scale,
            None => 1.0,
        }
    }

    /// The objects that are edited are on their way.
    pub fn begin_renewal(&mut self) {
        self.renews = true;
    }

    /// A look on its way is there at once.
    pub fn end_morph(&mut self) {
        if let Some(morph) = self.morph.take() {
            morph.end(&mut self.edited);
        }
    }

    /// A look on its way is left for another one. It is an entry to undo of its own, as it would have been.
    pub fn note_morph(&mut self) {
        if let Some(morph) = self.morph.take() {
            let mut there = self.edited.clone();
            morph.end(&mut there);
            self.undo.note(&there, &self.view);
            self.undo.set_preset(self.preset.as_deref());
        }
    }

    /// The look that the present one is changing into, or the present one.
    pub fn coming_look(&self) -> Settings {
        let mut look = self.look();
        if let Some(morph) = &self.morph {
            morph.clone().end(&mut look);
            look.picture.color_map = self.view.color_map;
        }
        look
    }

    /// The edited settings with the picture's colours.
    pub fn look(&self) -> Settings {
        let mut look = self.edited.clone();
        look.picture.color_map = self.view.color_map;
        look
    }

    /// The look as it is edited, as the text of a preset; `scene` is where it comes from.
    pub fn look_text(&self, scene: &str) -> String {
        presets::to_toml(&self.look(), &format!("A look of one's own, from {scene}."))
    }

    /// The edited settings, except those that would restart the running simulation.
    pub fn live_settings(&self) -> Settings {
        let mut live = self.running.clone();
        for parameter in PARAMETERS {
            if !parameter.restarts(&self.running, &self.edited) {
                parameter.copy(&self.edited, &mut live);
            }
        }
        for (i, live) in live.objects.iter_mut().enumerate() {
            let running = &self.running.objects[i];
            // While others are on their way they stand in other places.
            let edited = &self.edited.objects;
            let place = if edited.len() == self.running.objects.len() {
                Some(i)
            } else {
                place_among(edited, running)
            };
            let Some(edited) = place.map(|place| &edited[place]) else {
                continue;
            };
            for parameter in OBJECT_PARAMETERS {
                if !parameter.restarts(running, edited) {
                    parameter.copy(edited, live);
                }
            }
        }
        live.foods.clone_from(&self.edited.foods);
        live.pulses.clone_from(&self.edited.pulses);
        // While others are on their way those that run keep their names.
        if !self.renews && are_built_alike(&live.objects, &self.edited.objects) {
            live.rename_objects(&self.names());
        }
        live
    }

    /// The scene's name, and the folder of its files.
    pub fn name_and_folder(&self) -> (String, PathBuf) {
        (self.name.clone(), self.folder.clone())
    }

    /// The names of the objects as they are edited.
    pub fn names(&self) -> Vec<String> {
        let objects = self.edited.objects.iter();
        objects.map(|object| object.name.clone()).collect()
    }

    /// Are there edits that the running simulation does not have, because they wait for a restart or are on their way?
    pub fn is_pending(&self) -> bool {
        self.has_parameters_that_wait() || self.running.objects != self.edited.objects
    }

    /// Are there edits that wait for the user to restart? Objects that are on their way come by themselves.
    pub fn waits_for_restart(&self) -> bool {
        match self.renews {
            true => self.has_parameters_that_wait(),
            false => self.is_pending(),
        }
    }

    fn has_parameters_that_wait(&self) -> bool {
        let mut parameters = PARAMETERS.iter();
        parameters.any(|p| p.restarts(&self.running, &self.edited))
    }

    /// Does something differ from the file that it was saved in last, or from what was loaded if it was not?
    pub fn is_unsaved(&self) -> bool {
        self.undo.is_unsaved(&self.edited, &self.view)
    }

    /// Everything as it is now, for [`Self::saved`] once a file has it.
    pub fn state_to_save(&self) -> Entry {
        self.undo.to_save(&self.edited, &self.view)
    }

    /// A file has everything as it was then; with none, no file has anything of it.
    pub fn saved(&mut self, then: Option<Entry>) {
        self.undo.saved(then);
    }

    /// If anything is different from before, that is one more entry to undo; not while a look is on its way, which is one entry when it
    /// is there.
    pub fn note(&mut self) {
        if self.morph.is_some() {
            return;
        }
        self.undo.note(&self.edited, &self.view);
        self.undo.set_preset(self.preset.as_deref());
    }

    /// The camera has come to rest: if it is another one than before, that is one more entry to undo.
    pub fn note_camera(&mut self) {
        self.undo.note_camera(&self.view, self.is_fitted());
    }

    /// Undo, or redo with `again`; none if there is nothing to undo.
    pub fn lead(&mut self, again: bool) -> Option<Change> {
        let waited = !are_built_alike(&self.running.objects, &self.edited.objects);
        let before = self.undo.strokes();
        self.note_camera();
        let lead = if again { Undo::redo } else { Undo::undo };
        if !lead(&mut self.undo, &mut self.edited, &mut self.view) {
            return None;
        }
        self.preset = self.undo.preset().map(str::to_owned);
        if let Some(fits) = self.undo.moved_camera() {
            self.eases = true;
            if fits {
                // The picture may have another size by now.
                self.refit();
            }
        }
        let strokes = self.undo.strokes();
        // Added, removed or scaled objects changed at once, and change back at once; other meshes and scales that waited for a
        // restart continue to wait. While such objects are on their way, the running objects are not the ones seen last.
        let are_others = !are_built_alike(&self.running.objects, &self.edited.objects);
        let renews = self.renews || (!waited && are_others);
        let begins_renewal = renews && !self.renews;
        self.renews = renews;
        Some(Change {
            renews,
            begins_renewal,
            stroke: (strokes != before).then_some(strokes),
            state: self.undo.state().filter(|_| !renews),
        })
    }
}

/// Puts the part of the look that a scene file holds into settings.
pub fn put_look(view: &View, center: Vec3, settings: &mut Settings) {
    settings.camera = view.camera.to_settings(center);
    view.write_to(&mut settings.picture);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lab::objects::{with_object, without_object};

    /// Would catch: a larger object's factor on the object that stands in its place in the other list.
    #[test]
    fn pending_scales_belong_to_the_objects_that_run() {
        let mut settings = with_object(&Settings::default(), "builtin:cube", 0.5, [1.0, 0.0, 0.0]);
        settings = with_object(&settings, "builtin:icosphere", 0.5, [0.0, 1.0, 0.0]);
        for (object, name) in settings.objects.iter_mut().zip(["ring", "box", "ball"]) {
            object.name = name.to_owned();
        }
        let scene = Scene::from_settings("three".to_owned(), settings, ".".into()).unwrap();
        let mut document = Document::new(&scene);
        document.edited.objects[2].scale *= 3.0;
        let factors = |document: &Document| [0, 1, 2, 3].map(|i| document.pending_scale(i));
        assert_eq!(factors(&document), [1.0; 4], "it waits for a restart");
        document.begin_renewal();
        assert_eq!(factors(&document), [1.0, 1.0, 3.0, 1.0]);
        // The first one goes; the others are in other places of the list.
        document.edited = without_object(&document.edited, 0);
        assert_eq!(factors(&document), [1.0, 1.0, 3.0, 1.0]);
        // Another mesh with the same name is another object, and has no factor.
        document.edited.objects[1].mesh = "builtin:cube".to_owned();
        assert_eq!(factors(&document), [1.0; 4]);
        // What is on its way is given up.
        document.edited.objects[0].scale *= 2.0;
        assert_eq!(factors(&document), [1.0, 2.0, 1.0, 1.0]);
        assert!(document.not_shown());
        assert_eq!(factors(&document), [1.0; 4]);
    }

    /// Would catch: an undo of an added object that waits with something else for a restart, and one of a scale in the panel that does not.
    #[test]
    fn added_objects_go_by_undo_whatever_else_waits_for_a_restart() {
        let settings = Settings::default();
        let scene = Scene::from_settings("torus".to_owned(), settings, ".".into()).unwrap();
        let mut document = Document::new(&scene);
        document.edited.particles.count += 1;
        document.note();
        document.edited = with_object(&document.edited, "builtin:cube", 0.5, [1.0, 0.0, 0.0]);
        document.note();
        // It came at once, and the count waits.
        document.running.objects = document.edited.objects.clone();
        assert!(document.is_pending());
        let change = document.lead(false).expect("it can be undone");
        assert!(change.renews && change.begins_renewal && document.is_renewed());
        assert_eq!(document.edited.objects.len(), 1);

        let mut document = Document::new(&scene);
        for scale in [2.0, 3.0] {
            document.edited.objects[0].scale = scale;
            document.note();
        }
        let change = document.lead(false).expect("it can be undone");
        assert!(!change.renews && document.waits_for_restart());
    }
}
