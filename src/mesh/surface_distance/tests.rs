//! Distances along surfaces, compared with closed forms.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, Vec3};

use super::*;
use crate::mesh::Mesh;

fn surface(name: &str) -> Surface {
    Surface::build(&[(&Mesh::builtin(name).unwrap(), 1.0)])
}

fn place(surface: &Surface, point: SurfacePoint) -> DVec3 {
    let [a, b, c] = surface.corners[point.triangle as usize]
        .map(|vertex| surface.positions[vertex as usize].as_dvec3());
    a + point.u * (b - a) + point.v * (c - a)
}

/// Places all over a surface, some on edges and corners.
fn points(surface: &Surface) -> Vec<SurfacePoint> {
    let weights = [(0.2, 0.3), (0.5, 0.5), (0.0, 0.0), (0.9, 0.05), (0.0, 0.4)];
    let triangles = 0..surface.corners.len() as u32;
    triangles
        .flat_map(|triangle| weights.map(|(u, v)| SurfacePoint { triangle, u, v }))
        .collect()
}

#[test]
fn on_a_plane_it_is_the_straight_line() {
    for name in ["plane?columns=1&rows=1", "plane?columns=7&rows=2"] {
        let surface = surface(name);
        let all = points(&surface);
        for source in [all[1], all[4], all[7]] {
            let distance = SurfaceDistance::new(&surface, &[source], f64::INFINITY);
            for &point in &all {
                let found = distance.at(point.triangle, point.u, point.v);
                let straight = place(&surface, point).distance(place(&surface, source));
                assert!((found - straight).abs() < 1e-6, "{found} for {straight}");
            }
        }
    }
}

/// Distances on a cube, by all unfoldings that may be shortest from the middle of a face.
#[test]
fn on_a_cube_it_is_that_of_the_best_unfolding() {
    for name in ["cube", "cube?divisions=5"] {
        let surface = surface(name);
        let all = points(&surface);
        let half = f64::from(surface.positions[0].x.abs());
        let top = all.iter().copied().find(|&point| {
            let at = place(&surface, point) / half;
            at.y > 0.999 && at.x.abs() < 0.7 && at.z.abs() < 0.7
        });
        let source = top.expect("some place is on top");
        let distance = SurfaceDistance::new(&surface, &[source], f64::INFINITY);
        let from = place(&surface, source) / half;
        let mut sides = 0;
        for &point in &all {
            let to = place(&surface, point) / half;
            let found = distance.at(point.triangle, point.u, point.v) / half;
            if to.y > 0.999 {
                let straight = from.distance(to);
                assert!((found - straight).abs() < 1e-5, "{found} for {straight}");
            } else if to.x > 0.999 && to.y > -0.999 {
                // Straight over the edge, or round by either neighbouring face.
                sides += 1;
                let over = DVec2::new(1.0 - from.x + 1.0 - to.y, to.z - from.z).length();
                let round = [1.0, -1.0].map(|side| {
                    let (a, b) = (1.0 - side * from.z, 1.0 - side * to.z);
                    // The side face laid out, its corner at the origin: down, and towards the source.
                    DVec2::new((1.0 - to.y) + a, b + (1.0 - from.x)).length()
                });
                let best = round.into_iter().fold(over, f64::min);
                assert!((found - best).abs() < 1e-5, "{found} for {best}");
            }
        }
        assert!(sides > 5);
    }
}

#[test]
fn on_a_ball_it_is_the_great_circle() {
    let surface = surface("icosphere?subdivisions=4");
    let all = points(&surface);
    let radius = f64::from(surface.positions[0].length());
    let source = all[1233];
    let from = place(&surface, source).normalize();
    let distance = SurfaceDistance::new(&surface, &[source], f64::INFINITY);
    for &point in &all {
        let found = distance.at(point.triangle, point.u, point.v);
        let circle = radius * from.angle_between(place(&surface, point).normalize());
        assert!(
            (found - circle).abs() < 0.01 * circle + 1e-3,
            "{found} for {circle}"
        );
    }
}

/// Paths go around a missing part, and turn at its corners.
#[test]
fn paths_turn_at_corners_of_the_border() {
    // An L of three unit squares.
    let corners: Vec<Vec3> = [
        (0, 0),
        (1, 0),
        (2, 0),
        (0, 1),
        (1, 1),
        (2, 1),
        (0, 2),
        (1, 2),
    ]
    .iter()
    .map(|&(x, z)| Vec3::new(x as f32, 0.0, z as f32))
    .collect();
    let squares = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6]];
    let text: String = corners
        .iter()
        .map(|c| format!("v {} {} {}\n", c.x, c.y, c.z))
        .chain(squares.iter().map(|s| {
            let [a, b, c, d] = s.map(|k: i32| k + 1);
            format!("f {a} {d} {c} {b}\n")
        }))
        .collect();
    let folder = std::env::temp_dir().join(format!("myxo-l-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("l.obj");
    std::fs::write(&path, text).unwrap();
    let mesh = Mesh::load(&path).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    let surface = Surface::build(&[(&mesh, 1.0)]);
    let all = points(&surface);
    let position = |p: &SurfacePoint| place(&surface, *p);
    let source = *all.iter().find(|p| position(p).x > 1.4).unwrap();
    let from = position(&source);
    let distance = SurfaceDistance::new(&surface, &[source], f64::INFINITY);
    let inner = DVec3::new(1.0, 0.0, 1.0);
    let mut round = 0;
    for point in &all {
        let to = position(point);
        let found = distance.at(point.triangle, point.u, point.v);
        let way = to - from;
        // Does the straight line pass the missing square?
        let expected = if to.z > 1.0 && (from.x + (1.0 - from.z) / way.z * way.x) > 1.0 {
            round += 1;
            from.distance(inner) + inner.distance(to)
        } else {
            from.distance(to)
        };
        assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
    }
    assert!(round > 2, "some paths turn");
}

#[test]
fn several_places_and_a_reach() {
    let surface = surface("torus?major=24&minor=12");
    let all = points(&surface);
    let sources = [all[3], all[1000]];
    let each = sources.map(|s| SurfaceDistance::new(&surface, &[s], f64::INFINITY));
    let both = SurfaceDistance::new(&surface, &sources, f64::INFINITY);
    let near = SurfaceDistance::new(&surface, &sources, 0.4);
    let (mut inside, mut outside) = (0, 0);
    for p in &all {
        let least = each.iter().map(|d| d.at(p.triangle, p.u, p.v));
        let least = least.fold(f64::INFINITY, f64::min);
        let found = both.at(p.triangle, p.u, p.v);
        assert!((found - least).abs() < 1e-6, "{found} for {least}");
        let cut = near.at(p.triangle, p.u, p.v);
        if least < 0.4 - 1e-6 {
            inside += 1;
            assert!((cut - least).abs() < 1e-6, "{cut} for {least}");
        } else if least > 0.4 + 1e-6 {
            outside += 1;
            assert_eq!(cut, f64::INFINITY);
        }
    }
    assert!(inside > 50 && outside > 50);
}

/// Triangle inequality and symmetry, on a surface with saddles.
#[test]
fn there_and_back_is_equally_far() {
    let surface = surface("suzanne");
    let all = points(&surface);
    let few: Vec<_> = all.iter().step_by(all.len() / 6).copied().collect();
    let from: Vec<_> = few
        .iter()
        .map(|&p| SurfaceDistance::new(&surface, &[p], f64::INFINITY))
        .collect();
    let at = |a: usize, b: usize| from[a].at(few[b].triangle, few[b].u, few[b].v);
    let mut reached = 0;
    for a in 0..few.len() {
        for b in 0..few.len() {
            let (there, back) = (at(a, b), at(b, a));
            if there.is_finite() {
                reached += usize::from(a != b);
                assert!((there - back).abs() < 1e-5, "{there} and {back}");
                let line = place(&surface, few[a]).distance(place(&surface, few[b]));
                assert!(there >= line - 1e-5, "{there} for {line}");
            } else {
                assert!(back.is_infinite());
            }
            for c in 0..few.len() {
                assert!(at(a, b) <= at(a, c) + at(c, b) + 1e-5);
            }
        }
    }
    assert!(reached > 4);
}

/// Found with and without cutting windows; how many windows there were of each.
fn both_ways<'a>(
    surface: &'a Surface,
    sources: &[SurfacePoint],
    reach: f64,
) -> [(SurfaceDistance<'a>, usize); 2] {
    [true, false].map(|cuts| {
        let mut search = Search::new(surface, sources, reach);
        search.cuts = cuts;
        search.run(&Control::default()).unwrap();
        let count = search.found.windows.iter().map(Vec::len).sum();
        (search.done(), count)
    })
}

/// Cut parts of windows are nowhere the nearest: with saddles, handles, borders, sharp edges, several places, some on edges.
#[test]
fn cut_windows_change_no_distance() {
    for name in [
        "suzanne",
        "plane?columns=9&rows=6",
        "torus?major=36&minor=24",
        "gear?teeth=12",
        "capsule",
        "cube?divisions=7",
    ] {
        let surface = surface(name);
        let all = points(&surface);
        let many: Vec<_> = all
            .iter()
            .step_by(all.len() / 4 + 1)
            .skip(1)
            .copied()
            .collect();
        for (sources, reach) in [
            (&many[..1], f64::INFINITY),
            (&many[..], f64::INFINITY),
            (&many[1..2], 0.7),
        ] {
            let [(cut, fewer), (whole, more)] = both_ways(&surface, sources, reach);
            assert!(fewer <= more, "{name}: {fewer} of {more} windows");
            for p in &all {
                let [found, expected] = [&cut, &whole].map(|d| d.at(p.triangle, p.u, p.v));
                let is_out = found.min(expected) > reach - 1e-6;
                assert!(
                    found == expected || (found - expected).abs() < 1e-8 || is_out,
                    "{name}, {p:?}: {found} for {expected}"
                );
            }
        }
    }
}

/// On a torus whole families of ways cross everywhere behind its hole; only the nearest are propagated.
#[test]
fn there_are_few_windows_however_far_it_reaches() {
    let count = |name: &str| {
        let surface = surface(name);
        let source = points(&surface)[51];
        let distance = SurfaceDistance::new(&surface, &[source], f64::INFINITY);
        let count: usize = distance.windows.iter().map(Vec::len).sum();
        count as f64 / distance.windows.len() as f64
    };
    let small = count("torus?major=36&minor=24");
    let large = count("torus?major=144&minor=96");
    assert!(small < 5.0, "{small} an edge");
    // As the root of how many triangles there are: these are 16 times as many.
    assert!(
        large < 4.5 * small,
        "{large} an edge, {small} where it is coarse"
    );
}

#[test]
fn it_reports_progress_and_stops() {
    let surface = surface("torus?major=144&minor=96");
    let source = points(&surface)[51];
    let run = |stop_at: f32, reach: f64| {
        let shares = Mutex::new(Vec::new());
        let stop = AtomicBool::new(false);
        let progress = |_: &'static str, share: f32| {
            shares.lock().unwrap().push(share);
            stop.store(share >= stop_at, Ordering::Relaxed);
        };
        let control = Control {
            progress: Some(&progress),
            cancelled: Some(&stop),
            cache: None,
        };
        let found = SurfaceDistance::with_control(&surface, &[source], reach, &control);
        (found.map(|_| ()), shares.into_inner().unwrap())
    };
    for reach in [0.9, f64::INFINITY] {
        let (found, shares) = run(2.0, reach);
        assert_eq!(found, Ok(()));
        assert!(shares.len() > 5 && shares.is_sorted(), "{shares:?}");
        assert!(
            shares[0] < 0.1 && shares[shares.len() - 1] > 0.8,
            "{shares:?}"
        );
    }
    let (found, shares) = run(0.5, f64::INFINITY);
    assert_eq!(found, Err(AtlasError::Cancelled));
    assert!(shares.iter().filter(|share| **share >= 0.5).count() == 1);
}

/// Catches glued edges that no path crosses, and paths that cross them at another place: on a flat torus the distance is the shortest
/// straight line to any of the places that the sides' translations make of one.
#[test]
fn on_a_periodic_plane_it_is_the_straight_line_over_the_sides() {
    for name in [
        "plane?columns=1&rows=1&periodic=true",
        "plane?columns=7&rows=2&periodic=true",
    ] {
        let surface = surface(name);
        let all = points(&surface);
        let mut over = 0;
        for source in [all[0], all[2], all[7]] {
            let distance = SurfaceDistance::new(&surface, &[source], f64::INFINITY);
            let from = place(&surface, source);
            for &point in &all {
                let found = distance.at(point.triangle, point.u, point.v);
                let way = place(&surface, point) - from;
                // The sides are 2 long.
                let nearest = way - 2.0 * (0.5 * way).round();
                over += u32::from(nearest.length() < way.length() - 0.1);
                assert!(
                    (found - nearest.length()).abs() < 1e-6,
                    "{found} for {}, from {from}",
                    nearest.length()
                );
            }
        }
        assert!(over > 3, "{over} of the paths cross a side");
    }
}
