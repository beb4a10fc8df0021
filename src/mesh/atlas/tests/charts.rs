//! Layouts of charts: packing, ownership, areas and gutter on surfaces of all sorts.

use std::time::{Duration, Instant};

use glam::Vec3;

use super::*;
use crate::mesh::suite;

fn with_charts(size: u32, gutter: u32) -> AtlasOptions {
    AtlasOptions {
        method: AtlasMethod::Charts,
        ..options(size, gutter)
    }
}

/// Builds and validates; `None` if the error says that there is no room, and has a size that works.
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
        let mut largest = None;
        for (size, gutter) in [(37, 1), (64, 2), (250, 4), (250, 3)] {
            largest = sound(&mesh.name, &surface, &with_charts(size, gutter));
        }
        if largest.is_none() {
            let atlas = sound(&mesh.name, &surface, &with_charts(1024, 1));
            assert!(atlas.is_some(), "{} at 1024", mesh.name);
        }
    }
}

#[test]
fn charts_depend_on_nothing_but_their_arguments() {
    let surface = surface(&["suzanne", "icosphere?subdivisions=3"]);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let build = || sound("two", &surface, &with_charts(600, 2)).unwrap();
        pool.unwrap().install(build)
    };
    let (one, three) = (with_threads(1), with_threads(3));
    assert_eq!(one.owner, three.owner);
    assert_eq!(one.maps, three.maps);
    assert_eq!(one.area, three.area);
    assert_eq!(one.density, three.density);
    assert_eq!(one.blocks, three.blocks);
    assert_eq!(one.exchange, three.exchange);
    assert_eq!(
        bytemuck::cast_slice::<_, u8>(&one.seams),
        bytemuck::cast_slice::<_, u8>(&three.seams)
    );
}

/// Texels of each object's triangles per surface area.
fn densities(atlas: &Atlas, surface: &Surface) -> Vec<f64> {
    let objects = surface.objects.iter();
    objects
        .map(|range| {
            let (mut texels, mut area) = (0.0, 0.0);
            for t in range.triangles.0..range.triangles.1 {
                let map = atlas.maps[t as usize];
                texels += 0.5 * f64::from(map.du.perp_dot(map.dv).abs());
                area += surface.area(t);
            }
            texels / area
        })
        .collect()
}

#[test]
fn objects_get_texels_by_their_weights() {
    let meshes = ["cube", "icosphere?subdivisions=3", "capsule"].map(|n| Mesh::builtin(n).unwrap());
    let surface = Surface::build(&[(&meshes[0], 1.0), (&meshes[1], 0.3), (&meshes[2], 2.0)]);
    for weights in [vec![], vec![4.0], vec![1.0, 3.0, 0.5]] {
        let options = AtlasOptions {
            weights: weights.clone(),
            ..with_charts(700, 1)
        };
        let atlas = sound("weights", &surface, &options).unwrap();
        let densities = densities(&atlas, &surface);
        let weight = |object: usize| weights.get(object).map_or(1.0, |&w| f64::from(w));
        for object in 1..3 {
            let ratio = densities[object] / densities[0] * weight(0) / weight(object);
            assert!(
                (ratio - 1.0).abs() < 0.01,
                "{weights:?}, object {object}: {ratio}"
            );
        }
    }
}

#[test]
fn turned_charts_are_sound_and_lie_otherwise() {
    let surface = surface(&["suzanne"]);
    let build = |turn| {
        let options = AtlasOptions {
            turn,
            ..with_charts(512, 1)
        };
        sound("turned", &surface, &options).unwrap()
    };
    let atlases = [0, 1, 2, 1].map(build);
    assert_eq!(atlases[1].maps, atlases[3].maps);
    assert_ne!(atlases[1].maps, atlases[2].maps);
    let angle = |atlas: &Atlas| atlas.maps[0].du.to_angle();
    assert!((angle(&atlases[1]) - angle(&atlases[2])).abs() > 1e-3);
}

/// Triangles that touch nothing, on a line and far smaller than a texel or far longer than wide.
fn scattered_triangles(count: u32, shape: [[f32; 2]; 3]) -> Surface {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for k in 0..count {
        let words = random(3, k, 0, Purpose::Start);
        let size = 0.2 + unit(words[0]);
        let place = Vec3::new(3.0 * k as f32, 0.0, 0.0);
        positions.extend(shape.map(|[x, y]| place + size * Vec3::new(x, y, 0.0)));
        triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
    }
    Surface::build(&[(&suite::mesh("scattered", &positions, &triangles), 1.0)])
}

#[test]
fn thousands_of_parts_and_slivers_have_a_place() {
    let round = [[0.0, 0.0], [1.0, 0.0], [0.4, 0.8]];
    let sliver = [[0.0, 0.0], [1.0, 0.0], [0.6, 1e-4]];
    for (name, surface) in [
        ("parts", scattered_triangles(2000, round)),
        ("slivers", scattered_triangles(300, sliver)),
        (
            "both",
            scattered_triangles(40, [[0.0, 0.0], [1.0, 0.0], [0.9, 3e-6]]),
        ),
    ] {
        for (size, gutter) in [(64, 1), (300, 2), (640, 1)] {
            let atlas = sound(name, &surface, &with_charts(size, gutter));
            assert!(atlas.is_some() || size < 640, "{name} at {size}");
        }
    }
}

/// Its gutter is thousands of texels long, and all of it is filled from one texel.
#[test]
fn a_single_sliver_takes_no_longer_than_its_gutter_is_long() {
    let corners = [Vec3::ZERO, 1000.0 * Vec3::X, Vec3::new(500.0, 1e-4, 0.0)];
    let mesh = suite::mesh("sliver", &corners, &[[0, 1, 2]]);
    let surface = Surface::build(&[(&mesh, 1.0)]);
    let begun = Instant::now();
    let atlas = sound("sliver", &surface, &with_charts(4096, 1)).unwrap();
    assert!(begun.elapsed() < Duration::from_secs(20));
    assert_eq!(atlas.owned_count, 1);
    assert!(atlas.seams.len() > 4096, "{atlas}");
    let owned = atlas.owner.iter().position(|&t| t != NONE).unwrap() as u32;
    assert!(atlas.seams.iter().all(|seam| seam.source == [owned; 4]));
}

#[test]
fn validation_notices_what_is_broken_in_charts() {
    let surface = surface(&["suzanne"]);
    let sound = sound("suzanne", &surface, &with_charts(300, 1)).unwrap();
    let owned = sound.owner.iter().position(|&t| t != NONE).unwrap();
    let owner = sound.owner[owned];
    let other = (0..sound.chart.len()).find(|&t| sound.chart[t] != sound.chart[owner as usize]);
    let empty = (0..sound.owner.len() as u32)
        .find(|&texel| {
            let in_gutter = sound.gutter_texels.iter().any(|g| g.texel == texel);
            sound.owner[texel as usize] == NONE && !in_gutter
        })
        .unwrap();
    type Break<'a> = &'a dyn Fn(&mut Atlas);
    let breaks: [(&str, Break); 8] = [
        ("outside its owner", &|a| {
            a.owner[owned] = other.unwrap() as u32
        }),
        ("owned texels", &|a| a.owner[owned] = NONE),
        ("has area", &|a| a.area[empty as usize] = 0.1),
        ("owns no texel", &|a| a.chart_count += 1),
        ("add up", &|a| a.area[owned] *= 40.0),
        ("want the same texel", &|a| a.gutter = 3),
        ("chart", &|a| {
            let gutter_texel = a.gutter_texels[5];
            a.gutter_texels[5] = GutterTexel {
                triangle: (0..a.chart.len() as u32)
                    .find(|&t| a.chart[t as usize] != a.chart[gutter_texel.triangle as usize])
                    .unwrap(),
                ..gutter_texel
            };
        }),
        ("gutter", &|a| {
            a.seams.remove(7);
            a.gutter_texels.remove(7);
        }),
    ];
    for (word, damage) in breaks {
        let mut broken = sound.clone();
        damage(&mut broken);
        let problem = broken.validate(&surface).expect_err(word);
        assert!(problem.contains(word), "{word}: {problem}");
    }
}
