//! Layouts on disk: stored whole, found by the hash of their input, removed when damaged or old.

use std::fs;

use super::super::{Atlas, AtlasMethod};
use super::*;
use crate::mesh::Mesh;

fn surface(mesh: &str) -> Surface {
    Surface::build(&[(&Mesh::builtin(mesh).unwrap(), 1.0)])
}

fn options() -> AtlasOptions {
    AtlasOptions {
        method: AtlasMethod::Charts,
        size: 64,
        gutter: 1,
        ..AtlasOptions::default()
    }
}

/// Each triangle in a cell of its own, two per chart.
fn placement(triangles: usize) -> Placement {
    let map = |t: usize| AtlasMap {
        origin: Vec2::new(16.0 * (t % 4) as f32 + 4.0, 16.0 * (t / 4) as f32 + 2.5),
        du: Vec2::new(7.0, 1.0),
        dv: Vec2::new(-0.0, 8.0),
    };
    Placement {
        maps: (0..triangles).map(map).collect(),
        chart: (0..triangles as u32).map(|t| t / 2).collect(),
        chart_count: triangles as u32 / 2,
    }
}

#[test]
fn what_is_kept_is_read_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let slot = Slot::new(&folder.path().join("deep"), &surface("cube"), &options());
    assert_eq!(slot.load(), None, "nothing is there yet");
    slot.store(&placement(12));
    let read = slot.load().unwrap();
    assert_eq!(pack(&read), pack(&placement(12)));
}

#[test]
fn what_is_kept_is_not_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let cube = surface("cube");
    let made = std::cell::Cell::new(0);
    let build = |options: &AtlasOptions, cache| {
        let control = Control {
            cache,
            ..Control::default()
        };
        let make = || {
            made.set(made.get() + 1);
            let Placement {
                maps,
                chart,
                chart_count,
            } = placement(12);
            Ok((maps, chart, chart_count))
        };
        kept(&cube, options, &control, make).unwrap()
    };
    let first = build(&options(), Some(folder.path()));
    assert_eq!(build(&options(), Some(folder.path())), first);
    assert_eq!(made.get(), 1);
    // Without a folder nothing is stored or read.
    build(&options(), None);
    assert_eq!(made.get(), 2);
    let larger = AtlasOptions {
        size: 128,
        ..options()
    };
    build(&larger, Some(folder.path()));
    assert_eq!(made.get(), 3);
    // A damaged file is replaced.
    for entry in fs::read_dir(folder.path()).unwrap() {
        fs::write(entry.unwrap().path(), "nonsense").unwrap();
    }
    assert_eq!(build(&options(), Some(folder.path())), first);
    assert_eq!(build(&options(), Some(folder.path())), first);
    assert_eq!(made.get(), 4);
}

#[test]
fn what_failed_is_not_kept() {
    let folder = tempfile::tempdir().unwrap();
    let control = Control {
        cache: Some(folder.path()),
        ..Control::default()
    };
    let cancelled = kept(&surface("cube"), &options(), &control, || {
        Err(AtlasError::Cancelled)
    });
    assert_eq!(cancelled, Err(AtlasError::Cancelled));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn damaged_files_are_none() {
    let good = pack(&placement(12));
    assert!(unpack(&good, 12, 64).is_some());
    for cut in 0..good.len() {
        assert_eq!(unpack(&good[..cut], 12, 64), None, "cut at {cut}");
    }
    assert_eq!(unpack(&[good, vec![0]].concat(), 12, 64), None);
}

#[test]
fn whole_files_of_something_else_are_none() {
    let of = |change: fn(&mut Placement)| {
        let mut placement = placement(12);
        change(&mut placement);
        unpack(&pack(&placement), 12, 64)
    };
    assert!(of(|_| ()).is_some());
    assert_eq!(of(|p| p.maps[3].origin.x = f32::NAN), None);
    assert_eq!(of(|p| p.maps[3].dv.y = f32::INFINITY), None);
    assert_eq!(of(|p| p.maps[3].du.x = 100.0), None);
    assert_eq!(of(|p| p.maps[3].dv.y = -8.0), None);
    assert_eq!(of(|p| p.chart[11] = 6), None);
    assert_eq!(of(|p| p.chart_count = 13), None);
    assert_eq!(unpack(&pack(&placement(10)), 12, 64), None);
}

/// Catches a layout with a right checksum that no packing would make: with it, particles of two places would share texels without a
/// warning.
#[test]
fn whole_layouts_that_are_wrong_are_made_again() {
    let cube = surface("cube");
    let made = |change: fn(&mut Placement)| {
        let folder = tempfile::tempdir().unwrap();
        let control = Control {
            cache: Some(folder.path()),
            ..Control::default()
        };
        let mut kept_one = placement(12);
        change(&mut kept_one);
        Slot::new(folder.path(), &cube, &options()).store(&kept_one);
        let mut is_made = false;
        let given = kept(&cube, &options(), &control, || {
            is_made = true;
            let Placement {
                maps,
                chart,
                chart_count,
            } = placement(12);
            Ok((maps, chart, chart_count))
        });
        let (maps, chart, chart_count) = given.unwrap();
        assert_eq!(
            Placement {
                maps,
                chart,
                chart_count
            },
            placement(12)
        );
        is_made
    };
    assert!(!made(|_| ()));
    type Change = fn(&mut Placement);
    let wrong: [(&str, Change); 6] = [
        ("the same place", |p| p.maps[3] = p.maps[2]),
        ("one within the other", |p| {
            p.maps[3].origin = p.maps[2].origin + 1.0;
            p.maps[3].du = Vec2::new(1.0, 0.0);
            p.maps[3].dv = Vec2::new(0.0, 1.0);
        }),
        ("no area", |p| p.maps[3].dv = p.maps[3].du),
        ("too near", |p| p.maps[2].origin.x -= 8.5),
        ("off the grid", |p| p.maps[3].origin.x += 1e-5),
        ("an empty chart", |p| p.chart[2..4].fill(0)),
    ];
    for (what, change) in wrong {
        assert!(made(change), "{what}");
    }
}

/// Catches a check that refuses the program's own layouts, which would then be made at each start.
#[test]
fn layouts_that_are_made_are_taken() {
    let meshes = [
        "torus?major=24&minor=16",
        "icosphere?subdivisions=3",
        "gear",
        "cube",
        "icosphere?subdivisions=5",
    ];
    let mut checked = 0;
    for mesh in meshes {
        let surface = surface(mesh);
        for (size, gutter, turn) in [(64, 1, 0), (100, 1, 7), (256, 3, 1), (1024, 1, 0)] {
            let options = AtlasOptions {
                size,
                gutter,
                turn,
                ..options()
            };
            let Ok(atlas) = Atlas::build(&surface, &options) else {
                continue;
            };
            let made = Placement {
                maps: atlas.maps,
                chart: atlas.chart,
                chart_count: atlas.chart_count,
            };
            let problem = made
                .problem(&surface, &options, &Control::default())
                .unwrap();
            assert_eq!(problem, None, "{mesh} at {size}");
            checked += 1;
        }
    }
    // All at the largest size, and most at others.
    assert!(checked >= 10, "{checked} fit");
}

#[test]
fn everything_that_matters_is_in_the_key() {
    let cube = surface("cube");
    let own = key(&cube, &options());
    assert_eq!(own, key(&surface("cube"), &options()));
    let mut keys = vec![own];
    let changes: [fn(&mut AtlasOptions); 6] = [
        |o| o.method = AtlasMethod::Mesh,
        |o| o.size = 65,
        |o| o.cell_size = 1,
        |o| o.gutter = 2,
        |o| o.weights = vec![1.0],
        |o| o.turn = 1,
    ];
    for change in changes {
        let mut options = options();
        change(&mut options);
        keys.push(key(&cube, &options));
    }
    let changes: [fn(&mut Surface); 6] = [
        |s| s.positions[3].x += 1e-6,
        |s| s.corners[0].rotate_left(1),
        |s| s.triangles[4].ch += 1e-6,
        |s| s.halfedges[5].twin = super::super::NONE,
        |s| s.objects[0].triangles.1 = 11,
        |s| s.uvs[0] = Some(vec![[Vec2::ZERO; 3]]),
    ];
    for change in changes {
        let mut surface = surface("cube");
        change(&mut surface);
        keys.push(key(&surface, &options()));
    }
    keys.sort_unstable();
    keys.dedup();
    assert_eq!(keys.len(), 13, "no two are alike");
}

#[test]
fn a_folder_that_cannot_be_written_does_no_harm() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let slot = Slot::new(&file, &surface("cube"), &options());
    slot.store(&placement(12));
    assert_eq!(slot.load(), None);
}

#[test]
fn many_may_write_and_read_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let cube = surface("cube");
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                let slot = Slot::new(folder.path(), &cube, &options());
                for _ in 0..20 {
                    slot.store(&placement(12));
                    assert_eq!(slot.load(), Some(placement(12)), "whole at every moment");
                }
            });
        }
    });
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

/// [`VERSION`] identifies the result of the layout methods. If a layout changes on purpose, raise it and copy the printed numbers;
/// otherwise programs would use cached layouts of another version.
///
/// Per mesh: the number of charts, and a weighted mean of places in the triangles, in texels; corners and triangles have different weights,
/// so that the mean changes if they exchange places. The bits are equal on all machines.
#[test]
fn layouts_of_this_version_are_known() {
    const KNOWN: (u32, [(&str, AtlasMethod, u32, Vec2); 4]) = (
        5,
        [
            (
                "torus?major=24&minor=16",
                AtlasMethod::Grid,
                384,
                Vec2::new(130.69514, 109.59766),
            ),
            (
                "torus?major=24&minor=16",
                AtlasMethod::Charts,
                13,
                Vec2::new(142.91231, 119.2141),
            ),
            (
                "icosphere?subdivisions=3",
                AtlasMethod::Charts,
                13,
                Vec2::new(127.76278, 122.3042),
            ),
            (
                "gear",
                AtlasMethod::Charts,
                57,
                Vec2::new(119.34878, 111.14022),
            ),
        ],
    );
    let found = KNOWN.1.map(|(mesh, method, _, _)| {
        let options = AtlasOptions {
            method,
            size: 256,
            ..options()
        };
        let atlas = Atlas::build(&surface(mesh), &options).unwrap();
        let weighed = atlas.maps.iter().enumerate().map(|(i, map)| {
            let weight = (1 + i % 7) as f64;
            (
                weight,
                weight * (map.origin + 0.2 * map.du + 0.5 * map.dv).as_dvec2(),
            )
        });
        let (weight, sum) = weighed.fold((0.0, glam::DVec2::ZERO), |all, one| {
            (all.0 + one.0, all.1 + one.1)
        });
        let mean = (sum / weight).as_vec2();
        (mesh, method, atlas.chart_count, mean)
    });
    assert!(KNOWN == (VERSION, found), "version {VERSION}: {found:#?}");
}
