//! Painted areas: they stay when the scene restarts, are saved beside it, and particles begin on them.

use myxo::scene::settings::Start;

use crate::tools::SCENE;
use crate::{Lab, with_scene};
use myxo::scene::{Overrides, Scene};

impl Lab {
    /// Waits for what the probe shows of areas under the pointer.
    #[track_caller]
    fn probes(&self, what: &str, is_so: impl Fn(Option<&str>) -> bool) {
        self.wait(what, |seen| {
            let is_told = seen["values"]["probe.trail"].is_string();
            is_told && is_so(seen["values"]["probe.painted"].as_str())
        });
    }
}

fn attracts(painted: Option<&str>) -> bool {
    let value = painted.and_then(|value| value.parse::<f64>().ok());
    value.is_some_and(|value| value > 0.0)
}

#[test]
fn painted_areas_stay_are_saved_and_are_begun_on() {
    let Some((_folder, lab)) = with_scene("pair.toml", SCENE) else {
        return;
    };
    lab.hold();
    lab.point("picture", 0.5);
    lab.key("i");
    lab.probed("trail");
    lab.click("tool=attract");
    // Nothing is painted yet: a notice says so, and nothing happens.
    lab.click("start.painted");
    lab.wait("a notice", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.starts_with("Nothing attracts yet"))
    });
    lab.paint_with("attract");
    lab.probes("it attracts", attracts);

    // The picture can show or hide it.
    let shown = |words: &str| {
        let words = words.to_owned();
        lab.wait("areas", |seen| seen["values"]["shows_areas"] == words);
    };
    lab.find("picture.areas");
    lab.click("picture.areas=hidden");
    shown("false");
    lab.click("undo");
    shown("true");
    lab.point("picture", 0.5);
    lab.probes("it attracts as before", attracts);

    // After a restart it is still there and can still be undone.
    lab.key("period");
    lab.wait("a step", |seen| seen["state"]["step"].as_u64() > Some(0));
    lab.key_until("r", "it restarts", "step", 0);
    lab.probes("it attracts still", attracts);
    lab.key("ctrl+z");
    lab.probes("nothing attracts", |painted| !attracts(painted));
    lab.key("ctrl+shift+z");
    lab.probes("it attracts again", attracts);

    // The saved scene has the painted area.
    let saved = lab.save("pair");
    assert_eq!(saved.areas.map, "pair_000001_areas.png");
    assert!(saved.areas.strength > 0.0);
    let scene = lab.folder.file("pair_000001.toml");
    let scene = Scene::load(&scene, &Overrides::default()).expect("it is a scene");
    let setup = myxo::sim::Setup::new(&scene).expect("its map is there");
    let painted = setup.bias.iter().filter(|value| **value > 0.0).count();
    assert!(painted > 20, "{painted}");

    // All particles begin on it, and the area is removed.
    lab.click("tool=attract");
    lab.click("start.painted");
    lab.wait("a notice", |seen| {
        let notice = seen["state"]["notice"].as_str();
        notice.is_some_and(|text| text.starts_with("All begin where it attracted"))
    });
    lab.wait("it begins", |seen| seen["state"]["step"] == 0);
    lab.point("picture", 0.5);
    lab.probes("it does not attract", |painted| !attracts(painted));
    let saved = lab.save("pair");
    assert_eq!(saved.particles.start, Start::Mask);
    assert!(saved.areas.map.is_empty());
    let scene = lab.folder.file("pair_000001.toml");
    let scene = Scene::load(&scene, &Overrides::default()).expect("it is a scene");
    let begins = myxo::sim::Setup::new(&scene).expect("its mask is there");
    let places = begins.particles.iter();
    let texels = places.map(|p| begins.atlas.texel_of(p.triangle, p.u, p.v) as usize);
    let outside = texels.filter(|texel| setup.bias[*texel] <= 0.0).count();
    // Pixels of the mask and texels meet at edges.
    assert!(outside < 300, "{outside} of 3000 begin elsewhere");

    // Undo reverts the start first, then the removed area.
    lab.key("ctrl+z");
    lab.wait("it waits for a restart", |seen| {
        seen["places"].get("discard").is_some()
    });
    lab.key("ctrl+z");
    lab.point("picture", 0.5);
    lab.probes("it attracts once more", attracts);
    lab.quit();
}
