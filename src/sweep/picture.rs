//! The picture of a run: whether it can be drawn, and how.

use std::sync::Arc;

use glam::UVec2;

use crate::error::{Error, Result};
use crate::gpu::{Context, Frames};
use crate::render::offscreen::{FORMAT, too_large};
use crate::render::output::write_png;
use crate::render::{Offscreen, Renderer, View};
use crate::scene::Scene;
use crate::scene::settings::Part;
use crate::sim::Simulation;

/// The longest side of a picture, also for `myxo render`; a device may have a lower limit.
pub const LONGEST_SIDE: u32 = 16_384;

/// Width and height of pictures from a text such as `240x240`; none if it has another form, or a side that no picture may have.
#[must_use]
pub fn picture_size(text: &str) -> Option<[u32; 2]> {
    let side = |text: &str| {
        let side = text.trim().parse::<u32>().ok();
        side.filter(|side| (1..=LONGEST_SIDE).contains(side))
    };
    let (width, height) = text.split_once(['x', 'X', '×'])?;
    Some([side(width)?, side(height)?])
}

/// The picture of a run, a PNG; or why there is none.
pub type Picture = Result<Vec<u8>, String>;

/// Checks before any run that pictures can be drawn: that the device has room for this size, and that the scene has what its view shows
/// after so many steps. Without a device, because others do the runs, or without a scene, because each run has another view or the scene
/// cannot be loaded, the rest is checked. `option` names what says the size.
///
/// # Errors
/// When no picture can be drawn.
pub fn check_pictures(
    ctx: Option<&Arc<Context>>,
    scene: Option<&Scene>,
    steps: u64,
    size: [u32; 2],
    option: &str,
) -> Result<()> {
    if let Some(scene) = scene {
        check_view(scene, steps)?;
    }
    if let Some(ctx) = ctx {
        Offscreen::new(ctx, size).map_err(|error| too_large(size, option, error))?;
    }
    Ok(())
}

/// Why a scene cannot be shown in its view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unseen {
    /// The scene lacks what the view shows; in words.
    Lacks(&'static str),
    /// The view shows distances, which are taken by a step, and there is none.
    BeforeSteps,
}

impl Unseen {
    /// In words.
    #[must_use]
    pub fn why(self) -> &'static str {
        match self {
            Self::Lacks(why) => why,
            Self::BeforeSteps => "distances are taken by a step, and there is none",
        }
    }
}

/// Why a scene cannot be shown in its view after so many steps; none if it can.
#[must_use]
pub fn unseen(scene: &Scene, steps: u64) -> Option<Unseen> {
    let show = scene.settings.picture.show;
    if let Some(why) = show.why_not(&scene.settings) {
        return Some(Unseen::Lacks(why));
    }
    (steps == 0 && show.has(Part::Distances)).then_some(Unseen::BeforeSteps)
}

/// Can the scene be shown in its view after so many steps?
fn check_view(scene: &Scene, steps: u64) -> Result<()> {
    let Some(unseen) = unseen(scene, steps) else {
        return Ok(());
    };
    let why = unseen.why();
    Err(Error::Invalid(format!(
        "the view {} cannot be shown: {why}: choose another `picture.show`",
        scene.settings.picture.show.word()
    )))
}

/// The picture of a state in the view of its scene, as a PNG.
pub(super) fn drawn(
    ctx: &Arc<Context>,
    scene: &Scene,
    simulation: &Simulation,
    size: [u32; 2],
) -> Result<Vec<u8>> {
    check_view(scene, simulation.step())?;
    let mut renderer = Renderer::new(ctx, simulation.setup(), FORMAT)?;
    let canvas = Offscreen::new(ctx, size)?;
    let view = View::of(scene, UVec2::from_array(size).as_vec2());
    Frames::new(ctx, 1)?.run(|rec| {
        renderer.draw(rec, simulation.state(), &view, canvas.canvas());
        canvas.record_readback(rec);
    })?;
    let mut png = Vec::new();
    write_png(&mut png, &canvas.image()).map_err(|error| Error::Invalid(error.to_string()))?;
    Ok(png)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Overrides;

    /// Would catch: sizes of studies and of `--size` that are read in two ways.
    #[test]
    fn sizes_are_width_and_height() {
        for (text, size) in [
            ("240x240", Some([240, 240])),
            (" 40 × 30 ", Some([40, 30])),
            ("16384X1", Some([LONGEST_SIDE, 1])),
            ("16385x1", None),
            ("0x30", None),
            ("1x2x3", None),
            ("240", None),
        ] {
            assert_eq!(picture_size(text), size, "{text}");
        }
    }

    /// Would catch: a view that is drawn without what it shows, and one that is refused although a step has taken it.
    #[test]
    fn distances_need_a_second_object_and_a_step() {
        let scene = |name: &str, show: &str| {
            let overrides = Overrides {
                set: vec![format!("picture.show={show}")],
                ..Overrides::default()
            };
            Scene::load(name.as_ref(), &overrides).expect("it is built in")
        };
        let alone = unseen(&scene("cube", "distance"), 5);
        assert!(matches!(alone, Some(Unseen::Lacks(_))), "{alone:?}");
        let pair = scene("pair", "distance");
        assert_eq!(unseen(&pair, 0), Some(Unseen::BeforeSteps));
        assert_eq!(unseen(&pair, 1), None);
        assert_eq!(unseen(&scene("cube", "surface"), 0), None);
        let error = check_view(&pair, 0).expect_err("there is no step");
        assert_eq!(
            error.to_string(),
            "the view distance cannot be shown: distances are taken by a step, and there is none: choose another `picture.show`"
        );
    }
}
