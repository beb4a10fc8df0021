//! A table and pictures to tune by: `cargo test --release --lib charts::tests::measure -- --ignored --nocapture`.

use std::time::Instant;

use glam::DVec2;

use super::super::*;
use crate::mesh::Mesh;

/// A surface by the name of a built-in mesh, or by a file's.
fn open(name: &str) -> Surface {
    let mesh = if name == "potato" {
        potato(6)
    } else if name.ends_with(".glb") {
        Mesh::load(name).unwrap()
    } else {
        Mesh::builtin(name).unwrap()
    };
    Surface::build(&[(&mesh, 1.0)])
}

/// A lumpy ball.
fn potato(subdivisions: u32) -> Mesh {
    let mut mesh = Mesh::builtin(&format!("icosphere?subdivisions={subdivisions}")).unwrap();
    for position in &mut mesh.positions {
        let p = *position;
        let lump = 0.12 * ((5.0 * p.x).sin() * (4.0 * p.y).cos() + (6.0 * p.z + 2.0 * p.x).sin());
        *position = p * (1.0 + lump) * glam::Vec3::new(1.3, 0.8, 1.0);
    }
    mesh
}

fn percentile(sorted: &[(f64, f64)], share: f64) -> f64 {
    let all: f64 = sorted.iter().map(|s| s.1).sum();
    let mut sum = 0.0;
    for &(value, weight) in sorted {
        sum += weight;
        if sum >= share * all {
            return value;
        }
    }
    f64::NAN
}

#[test]
#[ignore = "measures"]
fn table() {
    let names = std::env::var("MESHES").unwrap_or_else(|_| {
        "cube cube?divisions=4 icosphere?subdivisions=2 torus?major=24&minor=16 icosphere torus capsule \
         suzanne trefoil gyroid /work/shared/assets/hand_animated.glb potato icosphere?subdivisions=6 \
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
        let charts = flat_charts(&surface, &Control::default()).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        let metric = Metric::new(&surface);
        let (mut areas, mut skews) = (Vec::new(), Vec::new());
        let mut border = 0.0;
        let total = metric.area(&(0..surface.corners.len() as u32).collect::<Vec<_>>());
        let mut tiny = 0;
        for chart in &charts {
            let area = metric.area(&chart.triangles);
            tiny += usize::from(area < 0.1 * total / charts.len() as f64);
            for (&t, corners) in chart.triangles.iter().zip(&chart.corners) {
                let shape = &metric.shapes[t as usize];
                let p = (corners[1] - corners[0]) / shape.ab;
                let h = (corners[2] - corners[0] - shape.cp * p) / shape.ch;
                let growth = p.perp_dot(h);
                let half = 0.5 * (p.length_squared() + h.length_squared()) / growth;
                areas.push((growth, shape.area()));
                skews.push((half + (half * half - 1.0).max(0.0).sqrt(), shape.area()));
                for h in 3 * t..3 * t + 3 {
                    let twin = surface.halfedges[h as usize].twin;
                    if twin == NONE || chart.triangles.binary_search(&(twin / 3)).is_err() {
                        border += metric.length(h);
                    }
                }
            }
        }
        areas.sort_by(|a, b| a.0.total_cmp(&b.0));
        skews.sort_by(|a, b| a.0.total_cmp(&b.0));
        println!(
            "{:30} {:>8} {:>6} {:>6} | {:.3} {:.3} {:.3} | {:.3} {:.3} {:.3} | {:.2} | {:.3}",
            name.rsplit('/').next().unwrap(),
            surface.corners.len(),
            charts.len(),
            tiny,
            percentile(&areas, 0.05),
            percentile(&areas, 0.5),
            percentile(&areas, 0.95),
            percentile(&skews, 0.5),
            percentile(&skews, 0.95),
            percentile(&skews, 0.99),
            border / total.sqrt(),
            seconds
        );
        picture(name, &charts);
    }
}

/// All charts in rows, each in a colour of its own.
fn picture(name: &str, charts: &[FlatChart]) {
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
    picture
        .save(format!("/work/out/charts-{name}.png"))
        .unwrap();
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
