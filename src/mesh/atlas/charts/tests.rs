//! Tests of cutting and flattening: properties of every chart over the suite of meshes, and cases with a known answer.

mod exact;
mod layout;
mod measure;

use glam::DVec2;

use super::*;
use crate::mesh::Mesh;

fn builtin(name: &str) -> Surface {
    let mesh = Mesh::builtin(name).unwrap();
    Surface::build(&[(&mesh, 1.0)])
}

fn charts(surface: &Surface) -> Vec<FlatChart> {
    flat_charts(surface, &Control::default()).unwrap()
}

/// The growth of a flattened triangle's area, and its larger stretch over the smaller one.
fn distortion(metric: &Metric, triangle: u32, corners: &[DVec2; 3]) -> (f64, f64) {
    let shape = &metric.shapes[triangle as usize];
    let p = (corners[1] - corners[0]) / shape.ab;
    let h = (corners[2] - corners[0] - shape.cp * p) / shape.ch;
    let growth = p.perp_dot(h);
    let half = 0.5 * (p.length_squared() + h.length_squared()) / growth;
    (growth, half + (half * half - 1.0).max(0.0).sqrt())
}

/// Values with their weights, by which percentiles are counted.
struct Weighted(Vec<(f64, f64)>);

impl Weighted {
    fn new(mut values: Vec<(f64, f64)>) -> Self {
        values.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(values)
    }

    fn percentile(&self, percent: f64) -> f64 {
        let all: f64 = self.0.iter().map(|value| value.1).sum();
        let mut sum = 0.0;
        for &(value, weight) in &self.0 {
            sum += weight;
            if sum >= 0.01 * percent * all {
                return value;
            }
        }
        f64::NAN
    }
}

/// Growth of areas and stretch, of all triangles of some charts.
fn distortions(surface: &Surface, charts: &[FlatChart]) -> (Weighted, Weighted) {
    let metric = Metric::new(surface);
    let (mut areas, mut skews) = (Vec::new(), Vec::new());
    for chart in charts {
        for (&t, corners) in chart.triangles.iter().zip(&chart.corners) {
            let weight = metric.shapes[t as usize].area();
            let (growth, skew) = distortion(&metric, t, corners);
            areas.push((growth, weight));
            skews.push((skew, weight));
        }
    }
    (Weighted::new(areas), Weighted::new(skews))
}
