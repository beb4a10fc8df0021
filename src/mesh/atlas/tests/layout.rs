//! Room, cells, maps, ownership and areas.

use std::collections::{HashMap, HashSet};

use glam::{DVec3, Vec2};

use super::super::grid::{Grid, Half};
use super::*;
use crate::mesh::soup::Soup;

#[test]
fn all_sorts_of_surfaces_and_sizes_hold_together() {
    let suite: [(&[&str], &[u32]); 5] = [
        (&["cube"], &[16, 64, 129, 1000]),
        (&["torus?major=24&minor=16"], &[100, 777, 1023]),
        (&["icosphere?subdivisions=2"], &[64, 333]),
        (
            &["plane?columns=5&rows=3", "cube", "icosphere?subdivisions=1"],
            &[101, 512],
        ),
        (&["capsule?segments=9&rings=3"], &[61, 250]),
    ];
    for (names, sizes) in suite {
        let surface = surface(names);
        for &size in sizes {
            // The slowest sizes have one gutter each.
            let gutters: &[u32] = match size {
                1000 => &[1],
                777 => &[2],
                1023 => &[3],
                _ => &[1, 2, 3],
            };
            for &gutter in gutters {
                let Ok(grid) = Grid::new(&surface, &options(size, gutter)) else {
                    assert!(size < 110, "{names:?} at {size}, gutter {gutter}");
                    continue;
                };
                let atlas = build(&surface, size, gutter);
                assert_eq!(atlas.chart_count as usize, grid.cells().len());
                assert_eq!(atlas.pitch, size.div_ceil(4) * 4);
            }
        }
    }
    build(&crooked_plane(), 500, 2);
}

#[test]
fn cells_do_not_overlap_and_leave_no_room_for_larger_ones() {
    let surface = surface(&["torus?major=24&minor=16", "icosphere?subdivisions=2"]);
    for size in [256, 777, 1000] {
        let atlas = build(&surface, size, 1);
        let c = atlas.cell_size;
        let cell_of = |t: u32, u, v| atlas.position_of(t, u, v).as_uvec2() / c;
        let mut chart_at = HashMap::new();
        for t in 0..surface.corners.len() as u32 {
            let cell = cell_of(t, 0.0, 0.0);
            assert_eq!(cell, cell_of(t, 1.0, 0.0));
            assert_eq!(cell, cell_of(t, 0.0, 1.0));
            let chart = atlas.chart[t as usize];
            assert_eq!(*chart_at.entry(cell).or_insert(chart), chart, "cell {cell}");
        }
        assert_eq!(chart_at.len(), atlas.chart_count as usize);
        let fits = |c: u32| (size / c).pow(2) >= atlas.chart_count;
        assert!(fits(c) && !fits(c + 1), "cells of {c} at {size}");
    }
}

#[test]
fn quads_share_a_cell_along_their_diagonal() {
    for (name, count) in [
        ("torus", 13_824),
        ("cube", 6),
        ("plane?columns=7&rows=4", 28),
    ] {
        let surface = surface(&[name]);
        let grid = Grid::new(&surface, &options(1024, 1)).unwrap();
        assert_eq!(grid.cells().len(), count, "{name}");
        for (cell, pair) in grid.cells().iter().enumerate() {
            assert_eq!(pair[0] / 2, pair[1] / 2, "{name}: {pair:?} is no quad");
            let maps = [Half::Lower, Half::Upper].map(|half| grid.map_of(cell, half));
            // Both put the two shared vertices in the same places.
            let at = |half: usize| {
                let map = maps[half];
                let texels = [map.origin, map.origin + map.du, map.origin + map.dv];
                let corners = surface.corners[pair[half] as usize];
                (0..3).map(move |k| (corners[k], texels[k].to_array().map(f32::to_bits)))
            };
            let lower: HashSet<_> = at(0).collect();
            assert_eq!(at(1).filter(|corner| lower.contains(corner)).count(), 2);
            assert!(
                maps.iter().all(|map| map.du.perp_dot(map.dv) > 0.0),
                "mirrored"
            );
        }
    }
    let icosphere = surface(&["icosphere"]);
    let cells = Grid::new(&icosphere, &options(2048, 1))
        .unwrap()
        .cells()
        .len();
    assert!(cells < icosphere.corners.len() * 11 / 20, "{cells} cells");
}

#[test]
fn deposits_never_fall_on_a_gutter_texel() {
    // Rounding by one unit in the last place either way, fused or not, and weights wrong by 1e-6.
    let slack = [
        (0.0, 0.0),
        (-1e-6, 0.0),
        (0.0, -1e-6),
        (1e-6, 0.0),
        (0.0, 1e-6),
    ];
    for name in ["cube", "plane?columns=3&rows=1", "icosphere?subdivisions=2"] {
        let surface = surface(&[name]);
        for size in [64, 100, 777, 1000, 1023, 1024, 4096, 8191, 16_384, 32_768] {
            let Ok(grid) = Grid::new(&surface, &options(size, 1)) else {
                assert_eq!((name, size), ("icosphere?subdivisions=2", 64));
                continue;
            };
            for (cell, &[lower, upper]) in grid.cells().iter().enumerate() {
                for (half, t) in [(Half::Lower, lower), (Half::Upper, upper)] {
                    if t == NONE {
                        continue;
                    }
                    let map = grid.map_of(cell, half);
                    for ((u, v), (du, dv)) in points_of(t).flat_map(|uv| slack.map(|s| (uv, s))) {
                        let (u, v) = (u + du, v + dv);
                        let fused = |o: f32, a: f32, b: f32| v.mul_add(b, u.mul_add(a, o));
                        let other = Vec2::new(
                            fused(map.origin.x, map.du.x, map.dv.x),
                            fused(map.origin.y, map.du.y, map.dv.y),
                        );
                        for p in [position(&map, u, v), other] {
                            for p in [p, p.map(f32::next_up), p.map(f32::next_down)] {
                                let owner = grid.owner_at(p.x as u32, p.y as u32);
                                assert!(
                                    owner != NONE && (owner == lower || owner == upper),
                                    "{name} at {size}: triangle {t} at ({u}, {v}) is {p}"
                                );
                            }
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn too_small_a_texture_names_the_size_that_works() {
    let torus = surface(&["torus"]);
    for (gutter, cell_size) in [(1, 0), (2, 0), (5, 0), (1, 9), (1, 37)] {
        let with = |size| AtlasOptions {
            cell_size,
            ..options(size, gutter)
        };
        let error = Atlas::build(&torus, &with(300)).unwrap_err();
        let AtlasError::NoRoom {
            triangles, needed, ..
        } = error
        else {
            panic!("{error}");
        };
        assert_eq!(triangles, 27_648);
        let text = error.to_string();
        assert!(
            text.contains("27,648 triangles") && text.contains(&needed.to_string()),
            "{text}"
        );
        Grid::new(&torus, &with(needed as u32)).unwrap();
        assert!(Grid::new(&torus, &with(needed as u32 - 1)).is_err());
    }
    let error = Atlas::build(&torus, &options(300, 1000)).unwrap_err();
    assert!(error.to_string().contains("fewer triangles"), "{error}");
    let small = AtlasOptions {
        cell_size: 5,
        ..options(1024, 2)
    };
    let AtlasError::CellTooSmall { needed, .. } = Atlas::build(&torus, &small).unwrap_err() else {
        panic!();
    };
    assert_eq!(needed, 6);
    for size in [0, MAX_SIZE + 1] {
        assert_eq!(
            Atlas::build(&torus, &options(size, 1)).unwrap_err(),
            AtlasError::Size(size)
        );
    }
    let nothing = Surface::build(&[]);
    assert_eq!(
        Atlas::build(&nothing, &options(64, 1)).unwrap_err(),
        AtlasError::Empty
    );
}

#[test]
fn texels_know_their_share_of_the_surface() {
    // Two objects, one with a quarter of the other's edges: its texels cover 1/16 of the area each.
    let mesh = Mesh::builtin("cube").unwrap();
    let surface = Surface::build(&[(&mesh, 1.0), (&mesh, 0.25)]);
    let atlas = build(&surface, 128, 1);
    let side = (atlas.cell_size - 2) as f32;
    let large = 4.0 / (side * side);
    let mean = 24.0 * (1.0 + 1.0 / 16.0) / (12.0 * side * side);
    for (texel, &owner) in atlas.owner.iter().enumerate().filter(|o| *o.1 != NONE) {
        let expected = if owner < 12 { large } else { large / 16.0 };
        assert!((atlas.area[texel] / expected - 1.0).abs() < 1e-5);
        assert!((atlas.density[texel] * expected / mean - 1.0).abs() < 1e-5);
    }
    // A triangle alone: its hypotenuse halves the texels there.
    let soup = Soup {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
        triangles: vec![[0, 1, 2]],
        ..Soup::default()
    };
    let lone = Mesh::from_soup("lone", soup).unwrap();
    let surface = Surface::build(&[(&lone, 1.0)]);
    let atlas = build(&surface, 12, 1);
    assert_eq!(atlas.owned_count, 55);
    // Its longest edge is the hypotenuse, so A is in the cell's corner.
    assert!(atlas.maps[0].origin.distance(Vec2::ONE) < 0.01);
    let areas: Vec<f32> = atlas.area.iter().copied().filter(|&a| a > 0.0).collect();
    assert_eq!(areas.iter().filter(|&&a| a == 0.005).count(), 10);
    assert_eq!(areas.iter().filter(|&&a| a == 0.01).count(), 45);
}

#[test]
fn an_atlas_depends_on_nothing_but_its_arguments() {
    let surface = surface(&["icosphere?subdivisions=3", "torus?major=24&minor=16"]);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap().install(|| build(&surface, 600, 2))
    };
    let (one, three) = (with_threads(1), with_threads(3));
    assert_eq!(one.owner, three.owner);
    assert_eq!(one.maps, three.maps);
    assert_eq!(one.density, three.density);
    assert_eq!(one.exchange, three.exchange);
    assert_eq!(
        bytemuck::cast_slice::<_, u8>(&one.seams),
        bytemuck::cast_slice::<_, u8>(&three.seams)
    );
}

#[test]
fn validation_notices_what_is_broken() {
    let surface = surface(&["torus?major=12&minor=8"]);
    let sound = build(&surface, 200, 1);
    let owned = sound.owner.iter().position(|&t| t != NONE).unwrap();
    let last = sound.seams.len() - 1;
    let gutter_texel = sound.seams[0].texel;
    type Break<'a> = &'a dyn Fn(&mut Atlas);
    let breaks: [(&str, Break); 8] = [
        ("outside its owner", &|a| a.owner[owned] += 1),
        ("owned texels", &|a| a.owned_count += 1),
        ("weights", &|a| a.seams[last].weight[0] -= 1),
        ("reads", &|a| a.seams[last].source[0] = gutter_texel),
        ("order", &|a| a.seams.swap(0, last)),
        ("gutter", &|a| {
            a.seams.pop();
            a.gutter_texels.pop();
        }),
        ("add up", &|a| a.area[owned] *= 1.5),
        ("chart", &|a| a.maps[3].origin.x += 1.0),
    ];
    for (word, damage) in breaks {
        let mut broken = sound.clone();
        damage(&mut broken);
        let problem = broken.validate(&surface).expect_err(word);
        assert!(problem.contains(word), "{word}: {problem}");
    }
}
