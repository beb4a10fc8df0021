//! Properties of the charts of any mesh.

use std::collections::HashMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use super::*;
use crate::mesh::atlas::tests::crooked_plane;
use crate::mesh::suite;

/// Checks the properties of charts.
fn check(surface: &Surface, charts: &[FlatChart]) -> Result<(), String> {
    let mut chart_of = vec![NONE; surface.corners.len()];
    for (c, chart) in charts.iter().enumerate() {
        if chart.triangles.len() != chart.corners.len() || chart.triangles.is_empty() {
            return Err(format!("chart {c} has no corners, or no triangles"));
        }
        if !chart.triangles.is_sorted_by(|a, b| a < b) {
            return Err(format!("the triangles of chart {c} do not ascend"));
        }
        for &t in &chart.triangles {
            if chart_of[t as usize] != NONE {
                return Err(format!("triangle {t} lies in two charts"));
            }
            if surface.triangles[t as usize].object != chart.object {
                return Err(format!("chart {c} has triangle {t} of another object"));
            }
            chart_of[t as usize] = c as u32;
        }
    }
    if let Some(t) = chart_of.iter().position(|&c| c == NONE) {
        return Err(format!("triangle {t} lies in no chart"));
    }
    for (c, chart) in charts.iter().enumerate() {
        check_one(surface, chart).map_err(|problem| format!("chart {c}: {problem}"))?;
    }
    Ok(())
}

fn check_one(surface: &Surface, chart: &FlatChart) -> Result<(), String> {
    let at: HashMap<u32, [DVec2; 3]> = chart
        .triangles
        .iter()
        .copied()
        .zip(chart.corners.iter().copied())
        .collect();
    for (t, corners) in &at {
        if !corners.iter().all(|corner| corner.is_finite()) || piece::signed_area(corners) <= 0.0 {
            return Err(format!(
                "triangle {t} is not wound counter-clockwise: {corners:?}"
            ));
        }
        for k in 0..3 {
            let twin = surface.halfedges[3 * *t as usize + k].twin;
            let Some(other) = at.get(&(twin / 3)).filter(|_| twin != NONE) else {
                continue;
            };
            let other_ends = [(twin as usize % 3 + 1) % 3, twin as usize % 3].map(|k| other[k]);
            if other_ends != [corners[k], corners[(k + 1) % 3]] {
                return Err(format!("the edge {k} of triangle {t} is torn"));
            }
        }
    }
    is_disc(surface, &chart.triangles)
}

/// Connected, and of the topology of a disc once holes that are open border all round are closed; counted another way
/// than `Patch` does, by uniting corners over glued edges.
fn is_disc(surface: &Surface, triangles: &[u32]) -> Result<(), String> {
    let place: HashMap<u32, usize> = triangles.iter().enumerate().map(|(i, &t)| (t, i)).collect();
    let mut corner_parent: Vec<usize> = (0..3 * triangles.len()).collect();
    let mut triangle_parent: Vec<usize> = (0..triangles.len()).collect();
    fn root(parents: &mut [usize], mut i: usize) -> usize {
        while parents[i] != i {
            parents[i] = parents[parents[i]];
            i = parents[i];
        }
        i
    }
    let unite = |parents: &mut [usize], a: usize, b: usize| {
        let (a, b) = (root(parents, a), root(parents, b));
        parents[a] = b;
    };
    let mut border = Vec::new();
    let mut glued = 0;
    for (i, &t) in triangles.iter().enumerate() {
        for k in 0..3 {
            let twin = surface.halfedges[3 * t as usize + k].twin;
            let other = place.get(&(twin / 3)).filter(|_| twin != NONE);
            let Some(&j) = other else {
                border.push((3 * i + k, twin == NONE));
                continue;
            };
            let twin_corner = twin as usize % 3;
            glued += 1;
            unite(&mut triangle_parent, i, j);
            unite(&mut corner_parent, 3 * i + k, 3 * j + (twin_corner + 1) % 3);
            unite(&mut corner_parent, 3 * i + (k + 1) % 3, 3 * j + twin_corner);
        }
    }
    if (0..triangles.len()).any(|i| root(&mut triangle_parent, i) != root(&mut triangle_parent, 0))
    {
        return Err("it is not connected".to_owned());
    }
    let count = |parents: &mut [usize]| {
        let roots: std::collections::HashSet<_> =
            (0..parents.len()).map(|i| root(parents, i)).collect();
        roots.len()
    };
    let vertices = count(&mut corner_parent) as i64;
    let mut loop_parent: Vec<usize> = (0..corner_parent.len()).collect();
    for &(h, _) in &border {
        let end = root(&mut corner_parent, 3 * (h / 3) + (h % 3 + 1) % 3);
        let start = root(&mut corner_parent, h);
        unite(&mut loop_parent, start, end);
    }
    let mut closed_loops: HashMap<usize, bool> = HashMap::new();
    for &(h, open) in &border {
        let start = root(&mut corner_parent, h);
        let entry = closed_loops
            .entry(root(&mut loop_parent, start))
            .or_insert(true);
        *entry &= open;
    }
    let loops = closed_loops.len() as i64;
    let cut_loops = closed_loops.values().filter(|open| !**open).count();
    let euler = vertices - (glued / 2 + border.len() as i64) + triangles.len() as i64;
    if euler != 2 - loops || loops == 0 || cut_loops > 1 {
        return Err(format!(
            "Euler's number is {euler}, with {loops} border loops, {cut_loops} of them cut"
        ));
    }
    Ok(())
}

fn checked(name: &str, surface: &Surface) -> Vec<FlatChart> {
    let charts = charts(surface);
    if let Err(problem) = check(surface, &charts) {
        panic!("{name}: {problem}");
    }
    charts
}

fn suite_surfaces() -> Vec<(String, Surface)> {
    let mut all: Vec<_> = suite::all()
        .into_iter()
        .map(|mesh| (mesh.name.clone(), Surface::build(&[(&mesh, 1.0)])))
        .collect();
    all.push(("crooked plane".to_owned(), crooked_plane()));
    all
}

#[test]
fn charts_of_the_suite_are_what_they_promise() {
    for (name, surface) in suite_surfaces() {
        let charts = checked(&name, &surface);
        let (areas, _) = distortions(&surface, &charts);
        let (low, high) = (areas.percentile(5.0), areas.percentile(95.0));
        assert!(
            low >= 0.85 && high <= 1.15,
            "{name}: areas grow by {low} to {high}"
        );
    }
}

/// Several objects, several parts, one of them far larger than the others.
#[test]
fn objects_do_not_share_charts() {
    let meshes = [
        Mesh::builtin("icosphere?subdivisions=3").unwrap(),
        suite::two_parts(),
        suite::hollow(),
    ];
    let objects: Vec<(&Mesh, f32)> = meshes.iter().zip([1.0, 0.01, 20.0]).collect();
    let surface = Surface::build(&objects);
    checked("three objects", &surface);
}

#[test]
fn charts_are_few_and_keep_areas_and_angles() {
    for (name, most) in [
        ("cube", 6),
        ("cube?divisions=8", 6),
        ("icosphere", 16),
        ("torus", 80),
        ("capsule", 20),
        ("suzanne", 60),
        ("trefoil", 50),
        ("plane", 4),
    ] {
        let surface = builtin(name);
        let charts = checked(name, &surface);
        let (areas, skews) = distortions(&surface, &charts);
        let (low, high) = (areas.percentile(5.0), areas.percentile(95.0));
        let skew = skews.percentile(95.0);
        assert!(charts.len() <= most, "{name}: {} charts", charts.len());
        assert!(
            low >= 0.85 && high <= 1.15,
            "{name}: areas grow by {low} to {high}"
        );
        assert!(skew <= 1.15, "{name}: stretch {skew}");
    }
}

/// The checks find errors.
#[test]
fn wrong_charts_are_noticed() {
    let surface = builtin("torus?major=24&minor=16");
    let right = charts(&surface);
    assert_eq!(check(&surface, &right), Ok(()));
    let problem_with = |spoil: &dyn Fn(&mut Vec<FlatChart>)| {
        let mut wrong = right.clone();
        spoil(&mut wrong);
        check(&surface, &wrong).expect_err("it was spoilt")
    };
    let problem = problem_with(&|charts| {
        charts.pop();
    });
    assert!(problem.contains("lies in no chart"), "{problem}");
    let problem = problem_with(&|charts| {
        let last = charts.pop().unwrap();
        let first = &mut charts[0];
        first.corners.extend(last.corners);
        first.triangles.extend(last.triangles);
        let mut all: Vec<_> = first
            .triangles
            .iter()
            .copied()
            .zip(first.corners.clone())
            .collect();
        all.sort_by_key(|(t, _)| *t);
        (first.triangles, first.corners) = all.into_iter().unzip();
    });
    assert!(
        problem.contains("torn") || problem.contains("connected"),
        "{problem}"
    );
    let problem = problem_with(&|charts| charts[0].corners[0].swap(0, 1));
    assert!(
        problem.contains("counter-clockwise") || problem.contains("torn"),
        "{problem}"
    );
    // A whole torus in one chart, whatever its places.
    let everything: Vec<u32> = (0..surface.corners.len() as u32).collect();
    assert!(is_disc(&surface, &everything).is_err());
}

#[test]
fn the_number_of_threads_does_not_show() {
    let with = |threads: usize, surface: &Surface| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| charts(surface))
    };
    for name in ["torus?major=60&minor=40", "suzanne"] {
        let surface = builtin(name);
        let one = with(1, &surface);
        for threads in [2, 3] {
            assert!(
                one == with(threads, &surface),
                "{name} with {threads} threads"
            );
        }
    }
}

#[test]
fn splitting_makes_discs_and_moves_nothing() {
    for (name, surface) in suite_surfaces() {
        for chart in charts(&surface)
            .iter()
            .filter(|chart| chart.triangles.len() > 1)
        {
            let pieces = split(&surface, chart);
            assert!(pieces.len() > 1, "{name}");
            let mut all: Vec<(u32, [DVec2; 3])> = Vec::new();
            for piece in &pieces {
                if let Err(problem) = check_one(&surface, piece) {
                    panic!("{name}, a piece: {problem}");
                }
                assert_eq!(piece.object, chart.object);
                all.extend(
                    piece
                        .triangles
                        .iter()
                        .copied()
                        .zip(piece.corners.iter().copied()),
                );
            }
            all.sort_by_key(|(t, _)| *t);
            let whole: Vec<_> = chart
                .triangles
                .iter()
                .copied()
                .zip(chart.corners.iter().copied())
                .collect();
            assert!(all == whole, "{name}: triangles are lost or moved");
        }
    }
    let surface = builtin("torus");
    for chart in charts(&surface) {
        let largest = split(&surface, &chart)
            .iter()
            .map(|piece| piece.triangles.len())
            .max()
            .unwrap();
        assert!(
            4 * largest < 3 * chart.triangles.len(),
            "halves are uneven: {largest}"
        );
    }
}

/// The teeth of a coarse border do not count as lobes. There are so many balls that the size of a chart is not limited.
#[test]
fn coarse_balls_are_cut_into_few_charts() {
    const BALLS: usize = 16;
    let ball = Mesh::builtin("icosphere?subdivisions=3").unwrap();
    let charts = charts(&Surface::build(&[(&ball, 1.0); BALLS]));
    assert!(charts.len() <= 6 * BALLS, "{} charts", charts.len());
}

#[test]
fn it_stops_when_cancelled() {
    let surface = builtin("suzanne");
    let cancelled = AtomicBool::new(true);
    let control = Control {
        cancelled: Some(&cancelled),
        ..Control::default()
    };
    assert_eq!(flat_charts(&surface, &control), Err(AtlasError::Cancelled));
    // In the middle, at the second progress report.
    cancelled.store(false, Ordering::Relaxed);
    let count = AtomicU32::new(0);
    let progress = |_: &'static str, _: f32| {
        if count.fetch_add(1, Ordering::Relaxed) == 1 {
            cancelled.store(true, Ordering::Relaxed);
        }
    };
    let control = Control {
        progress: Some(&progress),
        cancelled: Some(&cancelled),
        ..Control::default()
    };
    assert_eq!(flat_charts(&surface, &control), Err(AtlasError::Cancelled));
    assert_eq!(count.load(Ordering::Relaxed), 2);
}

#[test]
fn progress_goes_forward() {
    let shares = Mutex::new(Vec::new());
    let progress = |_: &'static str, done: f32| shares.lock().unwrap().push(done);
    let control = Control {
        progress: Some(&progress),
        ..Control::default()
    };
    flat_charts(&builtin("suzanne"), &control).unwrap();
    let shares = shares.into_inner().unwrap();
    assert!(shares.len() > 5);
    assert!(shares.is_sorted(), "{shares:?}");
    assert!(*shares.last().unwrap() <= DONE);
}
