//! Undo and redo of what was changed in the panel and painted: whole settings and looks, and the number of the last stroke of a
//! brush, one entry for each action of the user. The texels that strokes have changed are in `strokes.rs`.

use glam::Vec3;
use myxo::render::exposure::Exposure;
use myxo::render::view::Light;
use myxo::render::{Camera, View};
use myxo::scene::settings::{ColorMap, Settings};

/// Entries that are kept.
const MOST: usize = 200;

/// The look of the picture. The view shown is not part of it, and the camera has entries of its own: the undo of a parameter must not
/// move it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    color_map: ColorMap,
    exposure: Exposure,
    darkest: f32,
    particle_size: f32,
    charts: f32,
    light: Light,
    occlusion: f32,
    bloom: f32,
    wetness: f32,
    background: Vec3,
    shows_ground: bool,
    shows_food: bool,
    shows_areas: bool,
    /// Degrees.
    field_of_view: f32,
}

impl Look {
    fn of(view: &View) -> Self {
        Self {
            color_map: view.color_map,
            exposure: view.exposure,
            darkest: view.darkest,
            particle_size: view.particle_size,
            charts: view.charts,
            light: view.light,
            occlusion: view.occlusion,
            bloom: view.bloom,
            wetness: view.wetness,
            background: view.background,
            shows_ground: view.shows_ground,
            shows_food: view.shows_food,
            shows_areas: view.shows_areas,
            field_of_view: view.camera.vertical_fov.to_degrees(),
        }
    }

    fn put(self, view: &mut View) {
        view.color_map = self.color_map;
        view.exposure = self.exposure;
        view.darkest = self.darkest;
        view.particle_size = self.particle_size;
        view.charts = self.charts;
        view.light = self.light;
        view.occlusion = self.occlusion;
        view.bloom = self.bloom;
        view.wetness = self.wetness;
        view.background = self.background;
        view.shows_ground = self.shows_ground;
        view.shows_food = self.shows_food;
        view.shows_areas = self.shows_areas;
        if view.camera.vertical_fov.to_degrees() != self.field_of_view {
            view.camera
                .set_field_of_view(self.field_of_view.to_radians());
        }
    }
}

/// Everything that can be undone.
#[derive(Clone, Debug, PartialEq)]
struct Edited {
    settings: Settings,
    look: Look,
}

impl Edited {
    fn of(settings: &Settings, view: &View) -> Self {
        Self {
            settings: settings.clone(),
            look: Look::of(view),
        }
    }
}

/// A state that undo and redo lead to, or that a file has.
#[derive(Clone, Debug)]
pub struct Entry {
    state: Edited,
    /// The last stroke; 0 for none.
    strokes: u64,
    /// The preset that was taken last. It alone makes no entry.
    preset: Option<String>,
    /// The camera, which no file has to have.
    camera: Camera,
    /// It fits the scene into the picture, whatever size that has.
    fits: bool,
    /// The user went back to a kept state: the numbers of the state that was left, if it is kept, and of this one.
    came: Option<(Option<u64>, u64)>,
}

impl Entry {
    /// Does it look at the same from the same direction?
    fn sees_as(&self, camera: &Camera, fits: bool) -> bool {
        match self.fits && fits {
            true => (self.camera.yaw, self.camera.pitch) == (camera.yaw, camera.pitch),
            false => self.camera == *camera,
        }
    }

    /// Does it lead to the same as this one?
    fn is_same(&self, other: &Self) -> bool {
        let stays = self.came.is_none() && other.came.is_none();
        stays && self == other && self.sees_as(&other.camera, other.fits)
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        (&self.state, self.strokes) == (&other.state, other.strokes)
    }
}

/// The history: past entries, the present one, and undone ones.
#[derive(Clone, Debug)]
pub struct Undo {
    past: Vec<Entry>,
    now: Entry,
    future: Vec<Entry>,
    /// The last number given to a stroke; no two strokes share a number.
    last_number: u64,
    /// The entry that the file has; none if it was never in one.
    saved: Option<Entry>,
    /// Something was painted last that undo does not take back.
    lasts: bool,
    /// The last undo or redo has moved the camera, to one that fits the scene or not.
    moved_camera: Option<bool>,
    /// And it leads to this kept state.
    state: Option<u64>,
    /// The next change comes with a camera of its own.
    brings_camera: bool,
}

impl Undo {
    /// Nothing has been changed.
    pub fn new(settings: &Settings, view: &View) -> Self {
        let state = Edited::of(settings, view);
        let now = Entry {
            state,
            strokes: 0,
            preset: None,
            camera: view.camera,
            fits: false,
            came: None,
        };
        Self {
            past: Vec::new(),
            saved: Some(now.clone()),
            now,
            future: Vec::new(),
            last_number: 0,
            lasts: false,
            moved_camera: None,
            state: None,
            brings_camera: false,
        }
    }

    /// Something was painted that undo does not take back: trail or particles.
    pub fn note_lasting(&mut self) {
        self.lasts = true;
    }

    /// Was that the last action? After this was said once, undo continues with the action before it.
    pub fn take_lasting(&mut self) -> bool {
        std::mem::take(&mut self.lasts)
    }

    /// An action has ended: if anything is different from before, that is one more entry.
    pub fn note(&mut self, settings: &Settings, view: &View) {
        let look = Look::of(view);
        if self.now.state.settings == *settings && self.now.state.look == look {
            return;
        }
        let settings = settings.clone();
        // A field of view comes with its distance.
        let opens = self.now.state.look.field_of_view != look.field_of_view;
        let brings = std::mem::take(&mut self.brings_camera);
        let camera = match opens || brings {
            true => view.camera,
            false => self.now.camera,
        };
        self.push(Entry {
            state: Edited { settings, look },
            strokes: self.now.strokes,
            preset: None,
            camera,
            fits: self.now.fits,
            came: None,
        });
    }

    /// The user has gone back to a kept state, which had these settings and this look; `came` has the numbers of the state that was
    /// left, if it is kept, and of that one.
    pub fn go_to_state(&mut self, settings: &Settings, view: &View, came: (Option<u64>, u64)) {
        self.push(Entry {
            state: Edited::of(settings, view),
            came: Some(came),
            ..self.now.clone()
        });
    }

    /// The kept state that the last undo or redo leads to.
    pub fn state(&self) -> Option<u64> {
        self.state
    }

    /// The camera has come to rest. If it is another one than before, that is one more entry, unless something that was undone can
    /// come back: looking around must not end that.
    pub fn note_camera(&mut self, view: &View, fits: bool) {
        if self.can_redo() {
            return;
        }
        if self.now.sees_as(&view.camera, fits) {
            (self.now.camera, self.now.fits) = (view.camera, fits);
            return;
        }
        self.push(Entry {
            camera: view.camera,
            fits,
            came: None,
            ..self.now.clone()
        });
    }

    /// The next change of settings or look comes with a camera, and they are one entry.
    pub fn bring_camera(&mut self) {
        self.brings_camera = true;
    }

    /// The camera was moved from one place to another, not by the user: that is no entry.
    pub fn follow_camera(&mut self, from: &Camera, to: &Camera, fits: bool) {
        if self.now.camera == *from {
            (self.now.camera, self.now.fits) = (*to, fits);
        }
    }

    /// Did undo or redo move the camera just now? Then it says whether that one fits the scene into the picture.
    pub fn moved_camera(&self) -> Option<bool> {
        self.moved_camera
    }

    /// Adds an entry for a finished stroke that has changed painted areas, and returns its number. The rest is as it was noted
    /// last, because a look may be changing slowly, and the steps between are no entries.
    pub fn stroke(&mut self) -> u64 {
        self.last_number += 1;
        self.push(Entry {
            strokes: self.last_number,
            came: None,
            ..self.now.clone()
        });
        self.last_number
    }

    /// The last stroke that is there, not undone; 0 for none.
    pub fn strokes(&self) -> u64 {
        self.now.strokes
    }

    /// Some strokes cannot be undone any more: `known` gives for each the last one up to it that can.
    pub fn keep_strokes(&mut self, known: impl Fn(u64) -> u64) {
        // A stroke that the file lacks is still there, though it cannot be undone any more.
        let is_saved = |undo: &Self| {
            let saved = undo.saved.as_ref();
            saved.is_some_and(|saved| saved.strokes == undo.now.strokes)
        };
        let was_saved = is_saved(self);
        for entry in self.all() {
            entry.strokes = known(entry.strokes);
        }
        if let Some(saved) = &mut self.saved {
            saved.strokes = known(saved.strokes);
        }
        if !was_saved && is_saved(self) {
            self.saved = None;
        }
        self.join();
    }

    fn push(&mut self, entry: Entry) {
        self.lasts = false;
        let before = std::mem::replace(&mut self.now, entry);
        self.past.push(before);
        if self.past.len() > MOST {
            self.past.remove(0);
        }
        self.future.clear();
    }

    /// Goes back by one entry, if there is one.
    pub fn undo(&mut self, settings: &mut Settings, view: &mut View) -> bool {
        // Changes that are not noted yet are undone first.
        self.note(settings, view);
        let Some(before) = self.past.pop() else {
            return false;
        };
        let left = std::mem::replace(&mut self.now, before);
        self.put(&left, settings, view);
        self.state = left.came.and_then(|(from, _)| from);
        self.future.push(left);
        true
    }

    /// Goes forward again, if something was undone and nothing changed since.
    pub fn redo(&mut self, settings: &mut Settings, view: &mut View) -> bool {
        self.note(settings, view);
        let Some(after) = self.future.pop() else {
            return false;
        };
        let left = std::mem::replace(&mut self.now, after);
        self.put(&left, settings, view);
        self.state = self.now.came.map(|(_, to)| to);
        self.past.push(left);
        true
    }

    /// Replaces refused food by the running food in all entries. Otherwise undo would lead back to it for ever.
    pub fn forget_food(&mut self, refused: &Settings, runs: &Settings) {
        for entry in self.all() {
            let settings = &mut entry.state.settings;
            if (&settings.foods, &settings.feeding) == (&refused.foods, &refused.feeding) {
                settings.foods.clone_from(&runs.foods);
                settings.feeding = runs.feeding.clone();
            }
        }
        self.join();
    }

    fn all(&mut self) -> impl Iterator<Item = &mut Entry> {
        let all = self.past.iter_mut().chain(&mut self.future);
        all.chain([&mut self.now])
    }

    /// Entries that are no longer different are one.
    fn join(&mut self) {
        self.past.dedup_by(|a, b| a.is_same(b));
        self.future.dedup_by(|a, b| a.is_same(b));
        self.past.pop_if(|last| last.is_same(&self.now));
        self.future.pop_if(|next| next.is_same(&self.now));
    }

    /// All that a file may have, as it is now.
    pub fn to_save(&self, settings: &Settings, view: &View) -> Entry {
        Entry {
            state: Edited::of(settings, view),
            strokes: self.now.strokes,
            preset: None,
            camera: view.camera,
            fits: false,
            came: None,
        }
    }

    /// Notes that a file has this state; with none, no file has any of it.
    pub fn saved(&mut self, then: Option<Entry>) {
        self.saved = then;
    }

    /// Is something different from what a file has?
    pub fn is_unsaved(&self, settings: &Settings, view: &View) -> bool {
        self.saved != Some(self.to_save(settings, view))
    }

    /// The preset that goes with what is there now.
    pub fn preset(&self) -> Option<&str> {
        self.now.preset.as_deref()
    }

    /// The present entry has this preset.
    pub fn set_preset(&mut self, preset: Option<&str>) {
        self.now.preset = preset.map(str::to_owned);
    }

    /// Is there something to undo?
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// Was something undone that can come back?
    pub fn can_redo(&self) -> bool {
        !self.future.is_empty()
    }

    /// The present entry is there again; the camera moves only if it does between this entry and the one that is left.
    fn put(&mut self, left: &Entry, settings: &mut Settings, view: &mut View) {
        settings.clone_from(&self.now.state.settings);
        self.now.state.look.put(view);
        let moves = !left.sees_as(&self.now.camera, self.now.fits);
        self.moved_camera = moves.then_some(self.now.fits);
        if moves {
            view.camera = self.now.camera;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use myxo::scene::Scene;
    use myxo::scene::settings::{FoodSettings, Show};

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
        view.show = Show::Relief;
        let camera = view.camera;
        // A change is undone even if it is not noted yet.
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
        assert_eq!(view.show, Show::Relief, "and so does the view");
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
        // The camera has entries of its own. Looking around does not end what can come again, and moves with no other change.
        undo = Undo::new(&settings, &view);
        let home = view.camera;
        let turn = |view: &mut View, undo: &mut Undo, yaw| {
            view.camera.yaw = yaw;
            undo.note_camera(view, false);
        };
        turn(&mut view, &mut undo, 1.0);
        settings.trail.decay = 0.3;
        undo.note(&settings, &view);
        assert!(undo.undo(&mut settings, &mut view) && undo.moved_camera().is_none());
        turn(&mut view, &mut undo, 2.0);
        assert!(undo.redo(&mut settings, &mut view), "it can come again");
        assert_eq!((settings.trail.decay, view.camera.yaw), (0.3, 2.0));
        turn(&mut view, &mut undo, 3.0);
        for yaw in [1.0, 1.0, home.yaw] {
            assert!(undo.undo(&mut settings, &mut view));
            assert_eq!(view.camera.yaw, yaw);
        }
        assert!(view.camera == home && !undo.can_undo());
        // A picture of another size is no entry, and neither is a file that lacks the camera.
        undo = Undo::new(&settings, &view);
        let wide = Camera {
            distance: 2.0 * home.distance,
            ..home
        };
        undo.follow_camera(&home, &wide, true);
        view.camera = wide;
        undo.note_camera(&view, true);
        view.camera.distance *= 3.0;
        undo.note_camera(&view, true);
        assert!(!undo.can_undo());
        view.camera.yaw += 1.0;
        undo.note_camera(&view, true);
        assert!(undo.can_undo() && !undo.is_unsaved(&settings, &view));
        assert!(undo.undo(&mut settings, &mut view));
        assert_eq!(undo.moved_camera(), Some(true));
        // The way back to a kept state is an entry, also where nothing else is different; other entries lead to no state.
        undo = Undo::new(&settings, &view);
        undo.go_to_state(&settings, &view, (Some(7), 3));
        settings.trail.decay = 0.2;
        undo.note(&settings, &view);
        let mut lead = |again: bool, undo: &mut Undo| {
            let lead = if again { Undo::redo } else { Undo::undo };
            assert!(lead(undo, &mut settings, &mut view));
            undo.state()
        };
        let way = [false, false, true, true].map(|again| lead(again, &mut undo));
        assert_eq!(way, [None, Some(7), Some(3), None]);
        for i in 0..2 * MOST {
            settings.seed = i as u64;
            undo.note(&settings, &view);
        }
        assert_eq!(undo.past.len(), MOST);
    }

    #[test]
    fn strokes_stand_in_order_with_other_changes() {
        let mut settings = Settings::default();
        let scene = Scene::from_settings("torus".to_owned(), settings.clone(), ".".into()).unwrap();
        let mut view = View::of(&scene, Vec2::ONE);
        let mut undo = Undo::new(&settings, &view);
        assert_eq!(undo.stroke(), 1);
        settings.trail.decay = 0.5;
        undo.note(&settings, &view);
        assert_eq!([undo.stroke(), undo.stroke()], [2, 3]);
        let mut back = |undo: &mut Undo| {
            assert!(undo.undo(&mut settings, &mut view));
            (undo.strokes(), settings.trail.decay)
        };
        let decay = Settings::default().trail.decay;
        let way = [(2, 0.5), (1, 0.5), (1, decay), (0, decay)];
        assert_eq!([(); 4].map(|()| back(&mut undo)), way);
        assert!(!undo.undo(&mut settings, &mut view));
        for (strokes, decay) in [(1, decay), (1, 0.5), (2, 0.5), (3, 0.5)] {
            assert!(undo.redo(&mut settings, &mut view));
            assert_eq!((undo.strokes(), settings.trail.decay), (strokes, decay));
        }
        assert!(undo.undo(&mut settings, &mut view));
        // The undone strokes are gone, and their numbers are not used again.
        assert_eq!(undo.stroke(), 4);
        assert!(!undo.can_redo());
        // The last is too large, and the first is forgotten.
        undo.keep_strokes(|number| if number >= 2 { 2 } else { 0 });
        assert_eq!(undo.strokes(), 2);
        assert!(undo.undo(&mut settings, &mut view));
        assert_eq!((undo.strokes(), settings.trail.decay), (0, 0.5));
        assert!(undo.undo(&mut settings, &mut view));
        assert_eq!((undo.strokes(), settings.trail.decay), (0, decay));
        assert!(!undo.can_undo());
        // A scene that is built again has none of the strokes.
        assert!(undo.redo(&mut settings, &mut view) && undo.redo(&mut settings, &mut view));
        undo.keep_strokes(|_| 0);
        assert_eq!(undo.past.len(), 1, "the parameter's");
        // A stroke is something that a file has or has not, also once it is forgotten.
        let settings = Settings::default();
        assert!(undo.is_unsaved(&settings, &view));
        undo.saved(Some(undo.to_save(&settings, &view)));
        undo.stroke();
        assert!(undo.is_unsaved(&settings, &view));
        undo.saved(Some(undo.to_save(&settings, &view)));
        assert!(!undo.is_unsaved(&settings, &view));
        // Forgotten, and yet not in the file.
        let mut other = undo.clone();
        other.stroke();
        other.keep_strokes(|_| 0);
        assert!(other.is_unsaved(&settings, &view));
        let mut other = undo.clone();
        other.keep_strokes(|_| 0);
        assert!(!other.is_unsaved(&settings, &view), "the file has it");
        // The parameter, and then the stroke.
        let mut now = settings.clone();
        for is_unsaved in [false, true] {
            assert!(undo.undo(&mut now, &mut view));
            assert_eq!(undo.is_unsaved(&settings, &view), is_unsaved);
        }
    }

    #[test]
    fn a_stroke_leaves_no_look_that_is_only_on_its_way() {
        let mut settings = Settings::default();
        let scene = Scene::from_settings("torus".to_owned(), settings.clone(), ".".into()).unwrap();
        let mut view = View::of(&scene, Vec2::ONE);
        let mut undo = Undo::new(&settings, &view);
        view.charts = 0.3;
        undo.stroke();
        view.charts = 1.0;
        undo.note(&settings, &view);
        for (charts, strokes) in [(0.0, 1), (0.0, 0)] {
            assert!(undo.undo(&mut settings, &mut view));
            assert_eq!((view.charts, undo.strokes()), (charts, strokes));
        }
        assert!(!undo.can_undo());
    }
}
