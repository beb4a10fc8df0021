//! Painted areas when a scene restarts: they stay if nothing else takes their place, and particles can start on them.

use myxo::Result;
use myxo::plain_text::Shown as _;
use myxo::scene::settings::{AreaSettings, ObjectStart, Start};
use myxo::sim::Setup;
use myxo::sim::areas::write_mask;
use myxo::sim::carry::{carried, carried_bias, carried_looks};
use myxo::sim::paint::{PaintedField, Repainted};

use crate::lab::lost::is_loss;
use crate::lab::names::Reserved;
use crate::lab::saving::whole;
use crate::lab::stage::Stage;
use crate::lab::window::Lab;
use crate::lab::window::scene_text::has_painted_look;

/// Why particles cannot start on painted areas.
const NOTHING_ATTRACTS: &str =
    "Nothing attracts yet: paint where particles are to begin, then press it again";
/// Why not now: the mask would be one of another layout.
const WAITS: &str = "Changes wait for a restart: Reset or discard them first, then press it again";

/// A scene that is set up, and what it says of areas.
#[derive(Clone, Copy)]
struct Areas<'a> {
    setup: &'a Setup,
    settings: &'a AreaSettings,
}

impl<'a> Areas<'a> {
    fn of(stage: &'a Stage) -> Self {
        Self {
            setup: stage.simulation.setup(),
            settings: &stage.simulation.settings().areas,
        }
    }

    /// Are its texels those of another scene, one by one?
    fn has_texels_of(self, other: Areas<'_>) -> bool {
        let (here, there) = (&self.setup.atlas, &other.setup.atlas);
        (here.pitch, &here.owner) == (there.pitch, &there.owner)
    }
}

/// The areas that a restarted scene keeps: none if it takes those of its own map, because nothing was painted, or because the
/// map is another one.
fn kept(bias: &[f32], left: Areas<'_>, next: Areas<'_>) -> Option<Vec<f32>> {
    if bias == left.setup.bias || left.settings != next.settings {
        return None;
    }
    if next.has_texels_of(left) {
        return Some(bias.to_vec());
    }
    let objects = left.setup.poses.len();
    let from: Vec<_> = (0..objects).map(Some).collect();
    carried_bias(bias, left.setup, next.setup, &from)
}

/// Do two scenes have other maps of the second look?
fn have_other_looks(left: &Stage, next: &Stage) -> bool {
    let [left, next] = [left, next].map(|stage| &stage.simulation.settings().second_look.map);
    left != next
}

/// The weights of the second look that a restarted scene keeps, as [`kept`] areas.
fn kept_looks(looks: &[f32], left: &Stage, next: &Stage) -> Option<Vec<f32>> {
    let (here, there) = (left.simulation.setup(), next.simulation.setup());
    if looks == here.looks || have_other_looks(left, next) {
        return None;
    }
    let from: Vec<_> = (0..here.poses.len()).map(Some).collect();
    carried_looks(looks, here, there, &from)
}

/// The data that a stage keeps of the one before it.
#[derive(Clone, Copy, Default)]
pub struct CarriedOver {
    /// All that has grown.
    pub state: bool,
    /// Strokes can still be undone, because texels and areas are the same.
    pub strokes: bool,
}

impl Lab {
    /// Would what was painted be gone with this stage, because it brings another map?
    pub(crate) fn loses_areas_to(&self, next: &Stage) -> bool {
        self.runner.stage.as_ref().is_some_and(|left| {
            let (here, there) = (Areas::of(left), Areas::of(next));
            // Areas that cannot be read are lost in any case.
            let bias = left.simulation.areas().unwrap_or_default();
            let has_other_map = here.settings != there.settings;
            // A continued state has areas of its own, so the present state is kept.
            let begins = next.resumed.is_none();
            begins && has_other_map && !bias.is_empty() && bias != here.setup.bias
        })
    }

    /// Would a second look that was painted be gone with this stage, because it brings another map of it? No scene file can have it.
    pub(crate) fn loses_look_to(&self, next: &Stage) -> bool {
        self.runner.stage.as_ref().is_some_and(|left| {
            let begins = next.resumed.is_none();
            begins && have_other_looks(left, next) && has_painted_look(&left.simulation)
        })
    }

    /// Carries the state of the old stage over to the next one, if it fits there, or only its areas. A continued state has its
    /// own.
    pub(crate) fn carry_over(&mut self, next: &mut Stage) -> Result<CarriedOver> {
        let carry = self.edits.carry.take();
        let mut carried_over = CarriedOver::default();
        let Some(left) = &self.runner.stage else {
            return Ok(carried_over);
        };
        let (here, there) = (Areas::of(left), Areas::of(next));
        let has_other_map = here.settings != there.settings;
        let Some(from) = carry else {
            let bias = left.simulation.areas()?;
            let has_texels = there.has_texels_of(here);
            if next.resumed.is_some() {
                carried_over.strokes = has_texels && bias == next.simulation.areas()?;
                return Ok(carried_over);
            }
            let kept = kept(&bias, here, there);
            let are_same = kept.is_some() || bias == there.setup.bias;
            carried_over.strokes = are_same && has_texels;
            if let Some(bias) = kept {
                next.simulation.set_areas(&bias)?;
            }
            let looks = left.simulation.looks()?;
            if let Some(looks) = kept_looks(&looks, left, next) {
                next.simulation.set_looks(&looks)?;
            }
            return Ok(carried_over);
        };
        let state = left.simulation.snapshot()?;
        let (old, new) = (here.setup, there.setup);
        match carried(&state, old, new, &from) {
            Some(mut state) => {
                if has_other_map {
                    state.bias.clone_from(&new.bias);
                }
                next.simulation.restore(&state)?;
                carried_over.state = true;
            }
            None if has_other_map => {}
            None => {
                let bias = carried_bias(&state.bias, old, new, &from);
                let looks = carried_looks(&state.looks, old, new, &from);
                if let Some(bias) = bias {
                    next.simulation.set_areas(&bias)?;
                }
                if let Some(looks) = looks {
                    next.simulation.set_looks(&looks)?;
                }
            }
        }
        Ok(carried_over)
    }

    /// All particles begin on what attracts, which is taken away for it: a mask of it becomes the scene's start.
    pub(crate) fn start_on_painted(&mut self) -> Result<()> {
        let begun = self.begin_on_painted();
        match begun {
            Err(error) if is_loss(&error) => Err(error),
            Err(error) => {
                self.notify(error.to_string(), true);
                Ok(())
            }
            Ok(()) => Ok(()),
        }
    }

    fn begin_on_painted(&mut self) -> Result<()> {
        if self.interface.document.is_pending() {
            self.notify(WAITS, false);
            return Ok(());
        }
        self.paint_now()?;
        let folder = self.export_folder();
        let Some(stage) = &mut self.runner.stage else {
            return Ok(());
        };
        let bias = stage.simulation.areas()?;
        let name = Reserved::next(
            &folder,
            &format!("{}_start", self.interface.document.name),
            "png",
        )?;
        let atlas = &stage.simulation.setup().atlas;
        let Some(texels) = write_mask(name.path(), &bias, atlas)? else {
            self.notify(NOTHING_ATTRACTS, false);
            return Ok(());
        };
        let taken = texels.into_iter().map(|texel| Repainted {
            field: PaintedField::Bias,
            texel,
            before: bias[texel as usize],
            after: 0.0,
        });
        self.take_away(taken.collect())?;
        let particles = &mut self.interface.document.edited.particles;
        particles.start = Start::Mask;
        particles.start_object.clear();
        particles.start_mask = whole(name.path()).to_string_lossy().into_owned();
        for object in &mut self.interface.document.edited.objects {
            object.start.place = ObjectStart::Scene;
        }
        let text = format!("All begin where it attracted: {}", name.path().shown());
        self.notify(text, false);
        self.restart();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::scene::Scene;
    use myxo::scene::settings::Settings;
    use myxo::sim::paint::NO_GO;

    fn setup(size: u32, areas: &AreaSettings) -> Setup {
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.size = size;
        "builtin:plane".clone_into(&mut settings.objects[0].mesh);
        settings.areas = areas.clone();
        let scene = Scene::from_settings("plane".to_owned(), settings, "".into());
        Setup::new(&scene.unwrap()).unwrap()
    }

    #[test]
    fn painted_areas_stay_and_drawn_maps_are_read_again() {
        let none = AreaSettings::default();
        let maze = AreaSettings {
            map: "builtin:maze".to_owned(),
            ..none.clone()
        };
        let stronger = AreaSettings {
            strength: 99.0,
            ..maze.clone()
        };
        let (bare, walls, larger) = (setup(64, &none), setup(64, &maze), setup(97, &maze));
        let of = |setup, settings| Areas { setup, settings };
        // Nothing was painted: the map's file may have changed.
        for (setup, settings) in [(&bare, &none), (&walls, &maze)] {
            let areas = of(setup, settings);
            assert_eq!(kept(&setup.bias, areas, areas), None);
        }
        let owned = |setup: &Setup| -> Vec<usize> {
            let owners = setup.atlas.owner.iter().enumerate();
            let owned = owners.filter(|(_, owner)| **owner != u32::MAX);
            owned.map(|(texel, _)| texel).collect()
        };
        let mut painted = walls.bias.clone();
        for texel in owned(&walls).into_iter().take(300) {
            painted[texel] = 7.5;
        }
        let here = of(&walls, &maze);
        assert_eq!(kept(&painted, here, here), Some(painted.clone()));
        // All erased is painted, too.
        assert_eq!(kept(&[], here, here), Some(Vec::new()));
        // Another map takes their place; another layout does not.
        assert_eq!(kept(&painted, here, of(&walls, &stronger)), None);
        assert_eq!(kept(&painted, here, of(&bare, &none)), None);
        let carried = kept(&painted, here, of(&larger, &maze)).unwrap();
        assert_eq!(carried.len(), larger.atlas.texel_count());
        let values = owned(&larger).into_iter().map(|texel| carried[texel]);
        let values: Vec<f32> = values.collect();
        assert!(values.contains(&7.5) && values.contains(&NO_GO));
        let known = [0.0, 7.5, NO_GO];
        assert!(values.iter().all(|value| known.contains(value)));
    }
}
