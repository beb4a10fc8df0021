//! A table and pictures to tune by: `cargo test --release --lib charts::tests::measure -- --ignored --nocapture`, with
//! `MESHES` and `PICTURES` (a folder) in the environment.

use std::time::Instant;

use glam::Vec3;

use super::*;
use crate::mesh::suite;
use crate::rng::{Purpose, random, unit};

/// A surface by the name of a built-in mesh, or by a file's.
fn open(name: &str) -> Surface {
    let mesh = if name == "potato" {
        potato(6)
    } else if name == "noise" {
        noise(&Mesh::builtin("icosphere?subdivisions=6").unwrap(), 0.01)
    } else if name == "parts" {
        parts(4000)
    } else if name == "soup" {
        soup(60_000)
    } else if name == "web" {
        web(40_000)
    } else if name == "bigfan" {
        suite::bipyramid(30_000)
    } else if name == "slivers" {
        slivers(&Mesh::builtin("torus?major=144&minor=96").unwrap())
    } else if name.ends_with(".glb") {
        Mesh::load(name).unwrap()
    } else {
        Mesh::builtin(name).unwrap()
    };
    Surface::build(&[(&mesh, 1.0)])
}

fn jitter(i: usize) -> Vec3 {
    let words = random(3, i as u32, 0, Purpose::Start);
    Vec3::new(unit(words[0]), unit(words[1]), unit(words[2])) - 0.5
}

/// A mesh whose vertices are off by up to this.
fn noise(mesh: &Mesh, reach: f32) -> Mesh {
    let mut mesh = mesh.clone();
    for (i, position) in mesh.positions.iter_mut().enumerate() {
        *position += reach * jitter(i);
    }
    mesh
}

/// Many cubes.
fn parts(count: usize) -> Mesh {
    let cube = Mesh::builtin("cube").unwrap();
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for i in 0..count {
        let first = positions.len() as u32;
        positions.extend(
            cube.positions
                .iter()
                .map(|&p| p * (0.2 + jitter(i).x.abs()) + 100.0 * jitter(i)),
        );
        triangles.extend(cube.corners.iter().map(|c| c.map(|v| first + v)));
    }
    suite::mesh("parts", &positions, &triangles)
}

/// Triangles between random corners: edges with many triangles, and hardly two triangles that share an edge consistently.
fn soup(count: usize) -> Mesh {
    let positions: Vec<_> = (0..300).map(jitter).collect();
    let pick = |i: usize, k: usize| random(9, i as u32, k as u32, Purpose::Start)[0] % 300;
    let triangles: Vec<_> = (0..count)
        .map(|i| [pick(i, 0), pick(i, 1), pick(i, 2)])
        .collect();
    suite::mesh("soup", &positions, &triangles)
}

/// A strip that twists and turns: every triangle between the last two corners and a random new one.
fn web(count: usize) -> Mesh {
    let positions: Vec<_> = (0..count).map(jitter).collect();
    let triangles: Vec<_> = (0..count as u32 - 2)
        .map(|i| {
            if i % 2 == 0 {
                [i, i + 1, i + 2]
            } else {
                [i + 1, i, i + 2]
            }
        })
        .collect();
    suite::mesh("web", &positions, &triangles)
}

/// The mesh with a thin triangle at an edge of each triangle.
fn slivers(mesh: &Mesh) -> Mesh {
    let (mut positions, mut triangles) = (mesh.positions.clone(), Vec::new());
    for &[a, b, c] in &mesh.corners {
        let [pa, pb, pc] = [a, b, c].map(|vertex| mesh.positions[vertex as usize]);
        let d = positions.len() as u32;
        positions.push((0.5 * (pa + pb)).lerp(pc, 1e-3));
        triangles.extend([[a, b, d], [b, c, d], [c, a, d]]);
    }
    suite::mesh("slivers", &positions, &triangles)
}

/// A lumpy ball.
fn potato(subdivisions: u32) -> Mesh {
    let mut mesh = Mesh::builtin(&format!("icosphere?subdivisions={subdivisions}")).unwrap();
    for position in &mut mesh.positions {
        let p = *position;
        let lump = 0.12 * ((5.0 * p.x).sin() * (4.0 * p.y).cos() + (6.0 * p.z + 2.0 * p.x).sin());
        *position = p * (1.0 + lump) * Vec3::new(1.3, 0.8, 1.0);
    }
    mesh
}

/// CPU time of this process on all processors, which does not depend on other processes.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").unwrap();
    let fields: Vec<&str> = stat
        .rsplit(')')
        .next()
        .unwrap()
        .split_whitespace()
        .collect();
    (fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap()) / 100.0
}

#[test]
#[ignore = "measures"]
fn table() {
    let names = std::env::var("MESHES").unwrap_or_else(|_| {
        "cube cube?divisions=4 icosphere?subdivisions=2 torus?major=24&minor=16 icosphere torus capsule \
         suzanne trefoil gyroid assets/hand_animated.glb potato icosphere?subdivisions=6 \
         torus?major=320&minor=220"
            .to_owned()
    });
    println!(
        "{:30} {:>8} {:>6} {:>6} | area 5 50 95 % | skew 50 95 99 | edge/hull | seconds",
        "mesh", "tris", "charts", "tiny"
    );
    for name in names.split_whitespace() {
        let surface = open(name);
        let start = Instant::now();
        let cpu = processor_seconds();
        let charts = flat_charts(&surface, &Control::default()).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        let cpu = processor_seconds() - cpu;
        let metric = Metric::new(&surface);
        let (areas, skews) = distortions(&surface, &charts);
        let mut border = 0.0;
        let total = metric.area(&(0..surface.corners.len() as u32).collect::<Vec<_>>());
        let mut tiny = 0;
        for chart in &charts {
            let area = metric.area(&chart.triangles);
            tiny += usize::from(area < 0.1 * total / charts.len() as f64);
            for &t in &chart.triangles {
                for h in 3 * t..3 * t + 3 {
                    let twin = surface.halfedges[h as usize].twin;
                    if twin == NONE || chart.triangles.binary_search(&(twin / 3)).is_err() {
                        border += metric.length(h);
                    }
                }
            }
        }
        println!(
            "{:30} {:>8} {:>6} {:>6} | {:.3} {:.3} {:.3} | {:.3} {:.3} {:.3} | {:.2} | {:.3} {:.2}",
            name.rsplit('/').next().unwrap(),
            surface.corners.len(),
            charts.len(),
            tiny,
            areas.percentile(5.0),
            areas.percentile(50.0),
            areas.percentile(95.0),
            skews.percentile(50.0),
            skews.percentile(95.0),
            skews.percentile(99.0),
            border / total.sqrt(),
            seconds,
            cpu
        );
        if let Ok(folder) = std::env::var("PICTURES") {
            picture(&folder, name, &charts);
        }
    }
}

/// All charts in rows, each in a colour of its own.
fn picture(folder: &str, name: &str, charts: &[FlatChart]) {
    let width = 1400_u32;
    let area: f64 = charts
        .iter()
        .flat_map(|c| &c.corners)
        .map(piece::signed_area)
        .sum();
    let scale = 0.55 * f64::from(width) / area.sqrt();
    let mut picture = image::RgbImage::new(width, width + 400);
    let mut sorted: Vec<&FlatChart> = charts.iter().collect();
    let bounds = |chart: &FlatChart| {
        chart
            .corners
            .iter()
            .flatten()
            .fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &p| {
                (low.min(p), high.max(p))
            })
    };
    let height = |chart: &FlatChart| bounds(chart).1.y - bounds(chart).0.y;
    sorted.sort_by(|a, b| height(b).total_cmp(&height(a)));
    let (mut at, mut row) = (DVec2::splat(4.0), 0.0_f64);
    for (k, chart) in sorted.into_iter().enumerate() {
        let (low, high) = bounds(chart);
        let size = scale * (high - low);
        if at.x + size.x + 4.0 > f64::from(width) {
            at = DVec2::new(4.0, at.y + row + 4.0);
            row = 0.0;
        }
        row = row.max(size.y);
        let hue = k as f64 * 0.618;
        let colour = [0.0, 0.33, 0.67]
            .map(|o| 90.0 + 120.0 * (std::f64::consts::TAU * (hue + o)).sin().abs());
        for (i, corners) in chart.corners.iter().enumerate() {
            let shade = if i % 2 == 0 { 1.0 } else { 0.85 };
            let colour = image::Rgb(colour.map(|c| (c * shade) as u8));
            fill(
                &mut picture,
                corners.map(|p| at + scale * (p - low)),
                colour,
            );
        }
        at.x += size.x + 4.0;
    }
    let name: String = name
        .rsplit('/')
        .next()
        .unwrap()
        .chars()
        .map(|c| if c.is_alphanumeric() { c } else { '-' })
        .collect();
    picture.save(format!("{folder}/charts-{name}.png")).unwrap();
}

fn fill(picture: &mut image::RgbImage, [a, b, c]: [DVec2; 3], colour: image::Rgb<u8>) {
    let low = a.min(b).min(c).max(DVec2::ZERO);
    let high = a.max(b).max(c);
    for y in low.y as u32..=(high.y as u32).min(picture.height() - 1) {
        for x in low.x as u32..=(high.x as u32).min(picture.width() - 1) {
            let p = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let inside = |a: DVec2, b: DVec2| (b - a).perp_dot(p - a) >= 0.0;
            if inside(a, b) && inside(b, c) && inside(c, a) {
                picture.put_pixel(x, y, colour);
            }
        }
    }
}
