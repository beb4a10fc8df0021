//! Objects that are added, duplicated, removed or scaled while the state of the others stays.

use myxo::scene::Scene;
use myxo::scene::motion::in_decimals;
use myxo::scene::settings::{ObjectSettings, ParticleSettings, Settings};

use super::super::objects::{
    beside, places_of, short_name, way_beside, with_copy, with_object, without_object,
};
use crate::lab::command::{Command, Ticket, ToolRequest, Which};
use crate::lab::edits::Coming;
use crate::lab::loading::Origin;
use crate::lab::objects::NEW_OBJECT;
use crate::lab::renewal::{place_among, renewed};
use crate::lab::waiting::Waiting;
use crate::lab::window::Lab;

impl Lab {
    /// Begins to load the objects that are edited; what has grown stays.
    pub(crate) fn renew(&mut self) {
        self.interface.document.end_morph();
        let from = self.where_they_run(&self.interface.document.edited.objects);
        let document = &self.interface.document;
        let settings = renewed(&document.live_settings(), &document.edited);
        self.restart_as(settings.clone());
        // Edits that wait for a restart continue to wait.
        self.interface.document.asked = Some(settings);
        self.edits.carry = Some(from);
    }

    /// Hides and locks running objects as the interface marks them.
    pub(crate) fn follow_marks(&mut self) {
        let document = &self.interface.document;
        if let Some(stage) = &mut self.runner.stage {
            stage.follow(document.marks.of_running(&document.running.objects));
        }
    }

    /// Which of the objects that run each of these is. While others are on their way those that are edited are not they.
    fn where_they_run(&self, objects: &[ObjectSettings]) -> Vec<Option<usize>> {
        let running = &self.interface.document.running.objects;
        let objects = objects.iter();
        objects.map(|object| place_among(running, object)).collect()
    }

    /// One mesh more, at the right side of the others as the camera sees them.
    pub(crate) fn add_object(&mut self, mesh: String, ticket: Ticket) {
        let Some(stage) = &self.runner.stage else {
            self.interface.tools.answer(ticket, None);
            return;
        };
        let radius = stage.scene.radius;
        let origins = stage.scene.origins.clone();
        let points = places_of(stage).into_iter().flatten();
        let place = beside(
            &self.interface.document.view.camera,
            points,
            NEW_OBJECT * radius,
        );
        let settings = self.interface.document.live_settings();
        let asked = settings.clone();
        let (name, folder) = self.interface.document.name_and_folder();
        let mut from = self.where_they_run(&settings.objects);
        let what = short_name(&mesh).to_owned();
        let again = Command::Tool(ToolRequest::Add(mesh.clone(), ticket));
        self.load(name.clone(), Origin::Shown, move || {
            let alone = Settings {
                objects: vec![ObjectSettings {
                    mesh: mesh.clone(),
                    // Errors in the file are reported under this name.
                    name: short_name(&mesh).to_owned(),
                    ..ObjectSettings::default()
                }],
                radius: 0.0,
                // Food and a start may name objects that are not there.
                foods: Vec::new(),
                particles: ParticleSettings::default(),
                ..settings.clone()
            };
            let alone = Scene::from_settings(mesh.clone(), alone, folder.clone())?;
            let scale = NEW_OBJECT * radius / alone.radius;
            // From where both scenes count to where the object's own origin goes.
            let [here, there] = [&origins, &alone.origins].map(|origins| origins[0].world);
            let middle = there + alone.center.as_dvec3();
            let position = here + place.as_dvec3() - f64::from(scale) * middle;
            let position = in_decimals(position, radius);
            let settings = with_object(&settings, &mesh, scale, position);
            Ok(Scene::from_settings(name, settings, folder)?)
        });
        from.push(None);
        // Edits that wait for a restart continue to wait.
        self.interface.document.asked = Some(asked);
        self.edits.carry = Some(from);
        self.edits.coming = Some(Coming {
            what,
            again: Some(Waiting::Command(again, [0; 2])),
            ticket: Some(ticket),
        });
    }

    /// The object as it is edited, if it is there.
    pub(crate) fn object(&self, which: Which) -> Option<&ObjectSettings> {
        let objects = &self.interface.document.edited.objects;
        match which {
            Which::Object(place) => objects.get(place),
            Which::Asked(ticket) => {
                let name = self.edits.name_of(ticket)?;
                objects.iter().find(|object| object.name == name)
            }
        }
    }

    /// Was it asked for, and is neither there nor given up?
    pub(crate) fn is_to_come(&self, which: Which) -> bool {
        let Which::Asked(ticket) = which else {
            return false;
        };
        let coming = self.edits.coming.as_ref();
        let is_coming = coming.is_some_and(|coming| coming.ticket == Some(ticket));
        is_coming
            || self
                .waiting
                .iter()
                .any(|left| left.ticket() == Some(ticket))
    }

    /// The scene on its way is shown, or not: what is to be done with the object that came with it can be done now.
    pub(crate) fn has_come(&mut self, is_shown: bool) {
        let coming = self.edits.coming.take();
        let Some(ticket) = coming.and_then(|coming| coming.ticket) else {
            return;
        };
        // Objects that come are the last.
        let last = self
            .interface
            .document
            .running
            .objects
            .last()
            .filter(|_| is_shown);
        let place =
            last.and_then(|last| place_among(&self.interface.document.edited.objects, last));
        self.interface.tools.answer(ticket, place);
        if let Some(last) = last {
            self.edits.come.push((ticket, last.name.clone()));
        }
    }

    /// Once more an object that runs, beside it. Objects that are on their way come first; with another scene it goes.
    pub(crate) fn duplicate_object(&mut self, object: Box<ObjectSettings>, ticket: Ticket) {
        if let Some(loading) = &self.jobs.loading {
            if loading.origin == Origin::Shown {
                self.waiting.push(Waiting::Copy(object, ticket));
            } else {
                let text = format!(
                    "{} was not duplicated: another scene is on its way",
                    object.name
                );
                self.notify(text, false);
                let place = place_among(&self.interface.document.edited.objects, &object);
                self.interface.tools.answer(ticket, place);
            }
            return;
        }
        let asked = self.interface.document.live_settings();
        let (Some(stage), Some(place)) = (&self.runner.stage, place_among(&asked.objects, &object))
        else {
            self.interface.tools.answer(ticket, None);
            return;
        };
        let moves = !asked.objects[place].motion.is_still();
        let camera = &self.interface.document.view.camera;
        let way = way_beside(camera, &places_of(stage), place, moves);
        let settings = with_copy(&asked, place, way, stage.simulation.time());
        let mut from = self.where_they_run(&asked.objects);
        from.push(None);
        // The copy has the meshes in memory, even if their files have changed.
        let mut meshes = stage.scene.meshes.clone();
        meshes.push(meshes[place].clone());
        let (name, folder) = self.interface.document.name_and_folder();
        self.load(name.clone(), Origin::Shown, move || {
            Ok(Scene::from_meshes(name, settings, meshes, folder)?)
        });
        self.interface.document.asked = Some(asked);
        self.edits.carry = Some(from);
        let what = format!("the copy of {}", object.name);
        self.edits.coming = Some(Coming {
            what,
            again: Some(Waiting::Copy(object, ticket)),
            ticket: Some(ticket),
        });
    }

    /// Removes an object, after earlier requests for objects.
    pub(crate) fn remove_object(&mut self, object: Box<ObjectSettings>) {
        let loading = self.jobs.loading.as_ref();
        if loading.is_some_and(|loading| loading.origin == Origin::Shown) {
            self.waiting.push(Waiting::Removal(object));
            return;
        }
        let asked = self.interface.document.live_settings();
        let settings = &asked;
        let Some(place) = place_among(&settings.objects, &object) else {
            return;
        };
        if settings.objects.len() < 2 {
            let text = format!("{} stays: a scene has at least one object", object.name);
            self.notify(text, false);
            return;
        }
        let settings = without_object(settings, place);
        let from = self.where_they_run(&settings.objects);
        let (name, folder) = self.interface.document.name_and_folder();
        self.load(name.clone(), Origin::Shown, move || {
            Ok(Scene::from_settings(name, settings, folder)?)
        });
        self.interface.document.asked = Some(asked);
        self.edits.carry = Some(from);
        let what = format!("the removal of {}", object.name);
        self.edits.coming = Some(Coming {
            what,
            again: Some(Waiting::Removal(object)),
            ticket: None,
        });
    }
}
