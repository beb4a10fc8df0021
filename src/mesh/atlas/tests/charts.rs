//! Layouts of charts: packing, ownership, areas and gutter on surfaces of all sorts.

use super::*;
use crate::mesh::suite;

fn with_charts(size: u32, gutter: u32) -> AtlasOptions {
    AtlasOptions {
        method: AtlasMethod::Charts,
        ..options(size, gutter)
    }
}

/// Builds and validates; `None` where the error says that there is no room, and a size that works.
fn sound(name: &str, surface: &Surface, options: &AtlasOptions) -> Option<Atlas> {
    match Atlas::build(surface, options) {
        Ok(atlas) => {
            if let Err(problem) = atlas.validate(surface) {
                panic!("{name}, gutter {}, {atlas}: {problem}", options.gutter);
            }
            Some(atlas)
        }
        Err(AtlasError::NoRoomForCharts { needed, .. }) => {
            let larger = AtlasOptions {
                size: needed as u32,
                ..options.clone()
            };
            let atlas = Atlas::build(surface, &larger);
            assert!(
                atlas.is_ok(),
                "{name}, gutter {}: {atlas:?}",
                options.gutter
            );
            None
        }
        Err(error) => panic!("{name}: {error}"),
    }
}

#[test]
fn all_sorts_of_surfaces_hold_together() {
    for mesh in suite::all() {
        let surface = Surface::build(&[(&mesh, 1.0)]);
        for (size, gutter) in [(37, 1), (64, 2), (250, 3), (250, 4), (1024, 1)] {
            let atlas = sound(&mesh.name, &surface, &with_charts(size, gutter));
            assert!(atlas.is_some() || size < 1024, "{} at {size}", mesh.name);
        }
    }
}
