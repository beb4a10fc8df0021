//! Undo and redo of what was changed in the panel: whole settings and looks, one entry for each thing that the hand did.

use glam::Vec3;
use myxo::render::View;
use myxo::render::exposure::Exposure;
use myxo::render::view::Light;
use myxo::scene::settings::{ColorMap, Settings, Show};

/// Entries that are kept.
const MOST: usize = 200;

/// What the picture looks like, but for where it is taken from.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    show: Show,
    color_map: ColorMap,
    exposure: Exposure,
    particle_size: f32,
    charts: f32,
    light: Light,
    occlusion: f32,
    background: Vec3,
    shows_food: bool,
    /// Degrees.
    field_of_view: f32,
}

impl Look {
    fn of(view: &View) -> Self {
        Self {
            show: view.show,
            color_map: view.color_map,
            exposure: view.exposure,
            particle_size: view.particle_size,
            charts: view.charts,
            light: view.light,
            occlusion: view.occlusion,
            background: view.background,
            shows_food: view.shows_food,
            field_of_view: view.camera.vertical_fov.to_degrees(),
        }
    }

    fn put(self, view: &mut View) {
        view.show = self.show;
        view.color_map = self.color_map;
        view.exposure = self.exposure;
        view.particle_size = self.particle_size;
        view.charts = self.charts;
        view.light = self.light;
        view.occlusion = self.occlusion;
        view.background = self.background;
        view.shows_food = self.shows_food;
        if view.camera.vertical_fov.to_degrees() != self.field_of_view {
            view.camera
                .set_field_of_view(self.field_of_view.to_radians());
        }
    }
}

/// Everything that can be undone.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    settings: Settings,
    look: Look,
}

impl State {
    /// As it is now.
    pub fn of(settings: &Settings, view: &View) -> Self {
        Self {
            settings: settings.clone(),
            look: Look::of(view),
        }
    }
}

/// What was, what is, and what was undone.
#[derive(Clone, Debug)]
pub struct Undo {
    past: Vec<State>,
    now: State,
    future: Vec<State>,
    /// What a file has; none has what was never in one.
    saved: Option<State>,
}

impl Undo {
    /// Nothing has been changed.
    pub fn new(settings: &Settings, view: &View) -> Self {
        let now = State::of(settings, view);
        Self {
            past: Vec::new(),
            saved: Some(now.clone()),
            now,
            future: Vec::new(),
        }
    }

    /// The hand has let go: if anything is different from before, that is one more entry.
    pub fn note(&mut self, settings: &Settings, view: &View) {
        let look = Look::of(view);
        if self.now.settings == *settings && self.now.look == look {
            return;
        }
        let settings = settings.clone();
        let before = std::mem::replace(&mut self.now, State { settings, look });
        self.past.push(before);
        if self.past.len() > MOST {
            self.past.remove(0);
        }
        self.future.clear();
    }

    /// Goes back by one entry, if there is one.
    pub fn undo(&mut self, settings: &mut Settings, view: &mut View) -> bool {
        // What has not been noted yet is what is undone.
        self.note(settings, view);
        let Some(before) = self.past.pop() else {
            return false;
        };
        self.future.push(std::mem::replace(&mut self.now, before));
        self.put(settings, view);
        true
    }

    /// Goes forward again, if something was undone and nothing changed since.
    pub fn redo(&mut self, settings: &mut Settings, view: &mut View) -> bool {
        self.note(settings, view);
        let Some(after) = self.future.pop() else {
            return false;
        };
        self.past.push(std::mem::replace(&mut self.now, after));
        self.put(settings, view);
        true
    }

    /// What was refused was never there: wherever this food stands, there is what runs instead. Else undo would lead back
    /// to it for ever.
    pub fn forget_food(&mut self, refused: &Settings, runs: &Settings) {
        let all = self.past.iter_mut().chain(&mut self.future);
        for State { settings, .. } in all.chain([&mut self.now]) {
            if (&settings.foods, &settings.feeding) == (&refused.foods, &refused.feeding) {
                settings.foods.clone_from(&runs.foods);
                settings.feeding = runs.feeding.clone();
            }
        }
        self.past.dedup();
        self.future.dedup();
        self.past.pop_if(|last| *last == self.now);
        self.future.pop_if(|next| *next == self.now);
    }

    /// A file has it as it was then; with none, no file has anything of it.
    pub fn saved(&mut self, then: Option<State>) {
        self.saved = then;
    }

    /// Is something different from what a file has?
    pub fn is_unsaved(&self, settings: &Settings, view: &View) -> bool {
        self.saved != Some(State::of(settings, view))
    }

    /// Is there something to undo?
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// Was something undone that can come back?
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    fn put(&self, settings: &mut Settings, view: &mut View) {
        settings.clone_from(&self.now.settings);
        self.now.look.put(view);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use myxo::scene::Scene;
    use myxo::scene::settings::FoodSettings;

    #[test]
    fn changes_go_back_and_come_again() {
        let mut settings = Settings::default();
        let scene = Scene::from_settings("torus".to_owned(), settings.clone(), ".".into()).unwrap();
        let mut view = View::of(&scene, Vec2::ONE);
        let mut undo = Undo::new(&settings, &view);
        assert!(!undo.can_undo() && !undo.undo(&mut settings, &mut view));
        assert!(!undo.is_unsaved(&settings, &view));
        for decay in [0.5, 0.6] {
            settings.trail.decay = decay;
            undo.note(&settings, &view);
            undo.note(&settings, &view);
        }
        view.charts = 1.0;
        let camera = view.camera;
        // Not noted yet, and undone all the same.
        assert!(undo.undo(&mut settings, &mut view));
        assert_eq!((view.charts, settings.trail.decay), (0.0, 0.6));
        assert!(undo.undo(&mut settings, &mut view));
        assert_eq!(settings.trail.decay, 0.5);
        assert!(undo.redo(&mut settings, &mut view) && undo.redo(&mut settings, &mut view));
        assert_eq!((view.charts, settings.trail.decay), (1.0, 0.6));
        assert!(!undo.can_redo());
        assert!(undo.undo(&mut settings, &mut view) && undo.undo(&mut settings, &mut view));
        // A new change ends what could have come again.
        settings.trail.decay = 0.7;
        undo.note(&settings, &view);
        assert!(!undo.redo(&mut settings, &mut view));
        assert_eq!(settings.trail.decay, 0.7);
        assert!(undo.undo(&mut settings, &mut view) && undo.undo(&mut settings, &mut view));
        assert_eq!(settings, Settings::default());
        assert_eq!(view.camera, camera, "the camera stays");
        // Food that was refused is no entry, whatever was changed since.
        for later in [false, true] {
            undo = Undo::new(&settings, &view);
            let runs = settings.clone();
            settings.foods.push(FoodSettings::default());
            let refused = settings.clone();
            undo.note(&settings, &view);
            if later {
                settings.trail.decay = 0.4;
                undo.note(&settings, &view);
            }
            undo.forget_food(&refused, &runs);
            settings.foods.clone_from(&runs.foods);
            undo.note(&settings, &view);
            assert_eq!(undo.can_undo(), later);
            assert_eq!(undo.undo(&mut settings, &mut view), later);
            assert_eq!(settings, runs);
            assert!(!undo.can_undo());
            // Undone before it was refused, it does not come again.
            undo = Undo::new(&settings, &view);
            settings.foods.push(FoodSettings::default());
            let refused = settings.clone();
            undo.note(&settings, &view);
            assert!(undo.undo(&mut settings, &mut view) && undo.can_redo());
            undo.forget_food(&refused, &runs);
            assert!(!undo.can_redo() && settings == runs);
        }
        for i in 0..2 * MOST {
            settings.seed = i as u64;
            undo.note(&settings, &view);
        }
        assert_eq!(undo.past.len(), MOST);
    }
}
