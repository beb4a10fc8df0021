//! The network's lines: when they are asked for, and what the interface says of them.

use std::sync::Arc;

use myxo::render::network_lines::{NetworkLines, Sight, Viewpoint};
use myxo::sim::Setup;
use myxo::sim::graph::Measures;

use super::*;
use crate::lab::facts::NetworkFacts;

impl Harness {
    /// Gives the interface a network.
    fn has_a_network(&mut self) {
        let mut settings = Settings::default();
        settings.particles.count = 10;
        settings.atlas.size = 128;
        let scene = Scene::from_settings("torus".to_owned(), settings, ".".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        self.facts.network = Some(Arc::new(NetworkFacts {
            step: 1234,
            replaced: 0,
            measures: Measures {
                nodes: 2,
                edges: 1,
                length: 0.1,
                ..Measures::default()
            },
            lines: NetworkLines::default(),
            sight: Arc::new(Sight::new(&setup)),
            from: Viewpoint::default(),
            visible: Vec::new(),
        }));
    }
}

/// Would catch: a key that is there without being asked for, measures of a network that is not shown, and lines on the flat atlas.
#[test]
fn the_key_has_the_measures_of_the_network_while_its_lines_are_shown() {
    const MEASURES: &str = "step 1,234: 2 nodes, 1 edge of 0.10 radii, 0 cycles";
    let mut harness = Harness::new();
    harness.has_a_network();
    harness.frame(vec![]);
    assert!(!harness.interface.shows_network());
    assert!(harness.places_of(MEASURES).is_empty(), "not asked for");
    harness.press(Key::N);
    harness.frame(vec![]);
    assert!(harness.interface.shows_network());
    assert_eq!(harness.places_of(MEASURES).len(), 1);
    // Flat, it has none, and the key changes nothing but says why.
    harness.press(Key::Num0);
    harness.frame(vec![]);
    assert!(!harness.interface.shows_network());
    harness.press(Key::N);
    let notice = harness.interface.notices.text().expect("it says why");
    assert!(notice.contains("lie on the surface"), "{notice}");
    harness.press(Key::Num1);
    harness.frame(vec![]);
    assert!(harness.interface.shows_network());
    // The scene runs with a look for a while.
    let found = harness.facts.network.take();
    harness.facts.runs_preview = true;
    harness.frame(vec![]);
    assert_eq!(harness.places_of("no lines while a look").len(), 1);
    harness.facts.runs_preview = false;
    harness.facts.network = found;
    harness.frame(vec![]);
    assert_eq!(harness.places_of(MEASURES).len(), 1);
    // Another scene is there, and its network is not found yet.
    harness.facts.network = None;
    harness.frame(vec![]);
    assert!(harness.interface.shows_network());
    assert_eq!(harness.places_of("the network is being found").len(), 1);
    harness.press(Key::N);
    assert!(!harness.interface.shows_network());
}
