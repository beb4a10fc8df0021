//! `myxo query atlas`: the rows are read back and checked against the model, without looking at anything else.

use std::path::Path;
use std::process::Command;

use glam::{DVec2, DVec3};
use myxo::mesh::suite;

use super::straight::Model;
use super::{asset, builtin, obj};

/// The place of a face, in texels.
#[derive(Clone, Copy)]
struct Place {
    chart: usize,
    corners: [DVec2; 3],
}

/// The side of the texture, and the rows by face.
fn ask(mesh: &Path, options: &[&str]) -> (usize, Vec<Place>) {
    let run = Command::new(env!("CARGO_BIN_EXE_myxo"))
        .args(["query", "atlas", "--mesh"])
        .arg(mesh)
        .args(options)
        .output()
        .unwrap();
    let messages = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success() && messages.is_empty(), "{messages}");
    let text = String::from_utf8(run.stdout).unwrap();
    let mut lines = text.lines();
    let size: Vec<usize> = lines
        .next()
        .and_then(|line| line.strip_prefix("# "))
        .unwrap()
        .split(' ')
        .map(|x| x.parse().unwrap())
        .collect();
    assert_eq!((size.len(), size[0]), (2, size[1]));
    assert_eq!(lines.next(), Some("face,chart,u0,v0,u1,v1,u2,v2"));
    let places = lines
        .enumerate()
        .map(|(face, line)| {
            let fields: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            assert_eq!((fields.len(), fields[0]), (8, face as f64));
            assert!(
                fields[2..].iter().all(|x| (0.0..=1.0).contains(x)),
                "{line}"
            );
            let corner = |k: usize| size[0] as f64 * DVec2::from_slice(&fields[2 + 2 * k..]);
            Place {
                chart: fields[1] as usize,
                corners: [corner(0), corner(1), corner(2)],
            }
        })
        .collect();
    (size[0], places)
}

fn area([a, b, c]: [DVec2; 3]) -> f64 {
    0.5 * (b - a).perp_dot(c - a)
}

/// Calls `found` with each point of a grid of `fine` points per texel that lies inside of the triangle and not on its border.
fn points_inside(corners: [DVec2; 3], fine: f64, mut found: impl FnMut(DVec2)) {
    let [a, b, c] = corners;
    let (low, high) = (a.min(b).min(c) * fine, a.max(b).max(c) * fine);
    let twice = (b - a).perp_dot(c - a);
    for y in low.y.floor() as i64..=high.y.ceil() as i64 {
        for x in low.x.floor() as i64..=high.x.ceil() as i64 {
            let p = (DVec2::new(x as f64, y as f64) + 0.5) / fine;
            let weights = [(b, c), (c, a), (a, b)].map(|(s, e)| (e - s).perp_dot(p - s) / twice);
            if weights.into_iter().all(|w| w > 1e-6) {
                found(p);
            }
        }
    }
}

/// Checks that nothing overlaps, and that bilinear reads in different charts never touch the same texel.
fn check_apart(name: &str, size: usize, places: &[Place]) {
    const FINE: usize = 4;
    let mut covered = vec![false; (FINE * size).pow(2)];
    let mut reader = vec![usize::MAX; size * size];
    for place in places {
        points_inside(place.corners, FINE as f64, |p| {
            let fine = p * FINE as f64;
            let spot = &mut covered[fine.y as usize * FINE * size + fine.x as usize];
            assert!(!*spot, "{name}: two faces lie at {p}");
            *spot = true;
            let corner = (p - 0.5).floor();
            for tap in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
                let texel = corner + DVec2::from(tap);
                assert!(
                    texel.min_element() >= 0.0 && texel.max_element() < size as f64,
                    "{name}: a read at {p} leaves the texture"
                );
                let reader = &mut reader[texel.y as usize * size + texel.x as usize];
                assert!(
                    *reader == usize::MAX || *reader == place.chart,
                    "{name}: charts {reader} and {} read texel {texel}",
                    place.chart
                );
                *reader = place.chart;
            }
        });
    }
}

/// Checks that charts are numbered from 0 without gaps, and that faces keep their orientation.
fn check_rows(name: &str, model: &Model, places: &[Place]) {
    assert_eq!(places.len(), model.triangles.len(), "{name}");
    let count = places.iter().map(|place| place.chart).max().unwrap() + 1;
    let mut seen = vec![false; count];
    for place in places {
        seen[place.chart] = true;
        assert!(area(place.corners) >= 0.0, "{name}: a face is mirrored");
    }
    assert!(
        seen.into_iter().all(|seen| seen),
        "{name}: charts are missing"
    );
}

/// Texels per area of each face over the mean, with the face's area on the surface.
fn densities(model: &Model, places: &[Place]) -> Vec<(f64, f64)> {
    let areas: Vec<f64> = (0..places.len())
        .map(|face| {
            let [a, b, c]: [DVec3; 3] = model.corners(face);
            0.5 * (b - a).cross(c - a).length()
        })
        .collect();
    let texels: f64 = places.iter().map(|place| area(place.corners)).sum();
    let mean = texels / areas.iter().sum::<f64>();
    places
        .iter()
        .zip(areas)
        .map(|(place, surface)| (area(place.corners) / surface / mean, surface))
        .collect()
}

#[test]
fn cells_of_a_grid_lie_apart() {
    let folder = tempfile::tempdir().unwrap();
    for (mesh, size) in [
        (builtin("cube"), "61"),
        (builtin("torus?major=24&minor=16"), "256"),
        (suite::potato(), "300"),
    ] {
        let (name, path, model) = obj(folder.path(), &mesh);
        let options = ["--atlas-method", "grid", "--atlas-size", size];
        let (side, places) = ask(&path, &options);
        assert_eq!(side.to_string(), size);
        check_rows(&name, &model, &places);
        check_apart(&name, side, &places);
    }
}

#[test]
fn a_model_keeps_its_numbering() {
    let (name, path, model) = asset("suzanne");
    let (size, places) = ask(&path, &["--atlas-method", "grid"]);
    assert_eq!(size, 1024);
    check_rows(&name, &model, &places);
    // If two faces of the file share a chart, they share an edge, whose ends lie at the same place for both.
    let mut of_chart = vec![Vec::new(); places.len()];
    for (face, place) in places.iter().enumerate() {
        of_chart[place.chart].push(face);
    }
    let mut pairs = 0;
    for faces in of_chart {
        let [a, b] = faces[..] else { continue };
        pairs += 1;
        for (k, &vertex) in model.triangles[a].iter().enumerate() {
            if let Some(j) = model.triangles[b].iter().position(|&other| other == vertex) {
                let apart = places[a].corners[k].distance(places[b].corners[j]);
                assert!(apart < 1e-3, "faces {a} and {b}: {apart}");
            }
        }
    }
    assert!(pairs > 6000, "{pairs}");
}

#[test]
fn faces_of_one_size_get_equally_many_texels() {
    let folder = tempfile::tempdir().unwrap();
    let (name, path, model) = obj(folder.path(), &builtin("cube?divisions=4"));
    let (_, places) = ask(&path, &["--atlas-method", "grid", "--atlas-size", "256"]);
    for (density, _) in densities(&model, &places) {
        assert!((density - 1.0).abs() < 0.01, "{name}: {density}");
    }
}

/// Charts of every kind of mesh: closed, open, in several parts, with slivers, from files. Takes long: there are many.
#[test]
fn charts_lie_apart_keep_sizes_and_are_glued() {
    let folder = tempfile::tempdir().unwrap();
    let mut models: Vec<_> = [
        builtin("cube"),
        builtin("torus?major=48&minor=32"),
        builtin("plane"),
        builtin("capsule"),
        suite::potato(),
        suite::slivers(),
        suite::bipyramid(100),
    ]
    .iter()
    .map(|mesh| obj(folder.path(), mesh))
    .collect();
    models.extend(["suzanne", "gyroid_ball"].map(asset));
    for (name, path, model) in &models {
        for turn in ["0", "3"] {
            let options = ["--atlas-method", "charts", "--atlas-size", "512"];
            let (size, places) = ask(path, &[&options[..], &["--turn", turn]].concat());
            check_rows(name, model, &places);
            check_apart(name, size, &places);
            check_glued(name, model, &places);
            check_sizes(name, &densities(model, &places));
        }
    }
}

/// Checks that nearly all of the surface has texels of nearly the mean size.
fn check_sizes(name: &str, densities: &[(f64, f64)]) {
    let all: f64 = densities.iter().map(|(_, area)| area).sum();
    let beyond = |(density, _): &&(f64, f64)| !(0.8..1.25).contains(density);
    let odd: f64 = densities.iter().filter(beyond).map(|(_, area)| area).sum();
    assert!(odd < 0.05 * all, "{name}: {:.3} of the surface", odd / all);
}

/// Checks that faces of a chart are connected by edges whose ends have equal coordinates in both, to the last printed digit.
fn check_glued(name: &str, model: &Model, places: &[Place]) {
    let mut edges = std::collections::HashMap::new();
    for (face, triangle) in model.triangles.iter().enumerate() {
        for k in 0..3 {
            let [a, b] = [triangle[k], triangle[(k + 1) % 3]].map(|v| welded(model, v));
            edges.insert((a, b), (face, k));
        }
    }
    let mut root: Vec<usize> = (0..places.len()).collect();
    fn find(root: &mut [usize], mut face: usize) -> usize {
        while root[face] != face {
            root[face] = root[root[face]];
            face = root[face];
        }
        face
    }
    for (&(a, b), &(face, k)) in &edges {
        let Some(&(other, j)) = edges.get(&(b, a)) else {
            continue;
        };
        let ends = |place: &Place, k: usize| [place.corners[k], place.corners[(k + 1) % 3]];
        let [start, end] = ends(&places[face], k);
        if places[face].chart == places[other].chart && ends(&places[other], j) == [end, start] {
            let (face, other) = (find(&mut root, face), find(&mut root, other));
            root[face] = other;
        }
    }
    let pieces = (0..places.len()).filter(|&face| root[face] == face).count();
    let charts = places.iter().map(|place| place.chart).max().unwrap() + 1;
    assert_eq!(pieces, charts, "{name}: charts that fall into pieces");
}

/// The position itself: vertices at one place are one.
fn welded(model: &Model, vertex: u32) -> [u64; 3] {
    let position = model.positions[vertex as usize];
    position.to_array().map(|x| (x + 0.0).to_bits())
}
