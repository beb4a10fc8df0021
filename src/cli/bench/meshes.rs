//! The suite `mesh`: the host's times of loading a model, building its half-edges, and laying it out.

use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::Path;
use std::time::Instant;

use myxo::gpu::Statistics;
use myxo::mesh::Mesh;
use myxo::mesh::atlas::{Atlas, AtlasOptions, Control};
use myxo::mesh::surface::Surface;
use myxo::sim::atlas_options;
use myxo::{Error, Result};

use super::suite::{Extent, Point};
use crate::cli::interrupt;
use crate::cli::report::{KernelTime, Times};

/// What is timed, in order.
pub const PARTS: [&str; 3] = ["load", "half-edges", "atlas"];

/// A ball of so many subdivisions, and its times.
pub struct Model {
    mesh: Mesh,
    /// Milliseconds, one for each run.
    times: [Vec<f64>; 3],
}

/// Subdivisions of the balls.
pub fn sizes(extent: &Extent) -> RangeInclusive<u32> {
    2..=extent.of(6, 8)
}

/// How many triangles a ball has.
pub fn triangles(subdivisions: u32) -> f64 {
    20.0 * 4_f64.powi(subdivisions as i32)
}

/// The balls, coarse to fine, up to the end of the axis.
pub fn models(extent: &Extent) -> Result<Vec<Model>> {
    sizes(extent)
        .filter(|&subdivisions| triangles(subdivisions) <= extent.up_to)
        .map(|subdivisions| {
            Ok(Model {
                mesh: Mesh::builtin(&format!("icosphere?subdivisions={subdivisions}"))?,
                times: Default::default(),
            })
        })
        .collect()
}

impl Model {
    /// Triangles.
    pub fn len(&self) -> usize {
        self.mesh.corners.len()
    }

    /// Times all three once, with a file in this folder.
    pub fn run(&mut self, folder: &Path) -> Result<()> {
        let file = folder.join(format!("{}.obj", self.len()));
        std::fs::write(&file, obj(&self.mesh)).map_err(Error::io("write", &file))?;
        let options = AtlasOptions {
            size: 1024,
            ..atlas_options(&Default::default())
        };
        let begun = Instant::now();
        let mesh = Mesh::open(&file.to_string_lossy(), Path::new(""))?;
        let loaded = Instant::now();
        let surface = Surface::build(&[(&mesh, 1.0)]);
        let built = Instant::now();
        let control = Control {
            cancelled: Some(interrupt::flag()),
            ..Control::default()
        };
        let atlas = Atlas::build_with(&surface, &options, &control)?;
        let laid_out = Instant::now();
        assert!(atlas.owned_count > 0);
        let ends = [begun, loaded, built, laid_out];
        for (times, pair) in self.times.iter_mut().zip(ends.windows(2)) {
            times.push(1e3 * (pair[1] - pair[0]).as_secs_f64());
        }
        Ok(())
    }

    /// The results, if there are any.
    pub fn point(&self) -> Option<Point> {
        let [load, halfedges, atlas] = &self.times;
        if atlas.is_empty() {
            return None;
        }
        let sums = load.iter().zip(halfedges).zip(atlas);
        let sums: Vec<f64> = sums.map(|((a, b), c)| a + b + c).collect();
        let part = |(name, times): (&str, &Vec<f64>)| KernelTime {
            name: name.to_owned(),
            dispatches_per_step: 1.0,
            time: Times::from(&Statistics::of(times.clone())),
            ..KernelTime::default()
        };
        Some(Point {
            series: "icosphere".to_owned(),
            x: self.len() as f64,
            atlas_size: 1024,
            triangles: self.len() as u64,
            objects: 1,
            steps: sums.len(),
            time: Times::from(&Statistics::of(sums.clone())),
            runs_ms: sums,
            parts: PARTS.into_iter().zip(&self.times).map(part).collect(),
            ..Point::default()
        })
    }
}

/// An OBJ file as most programs write it.
fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    for place in &mesh.positions {
        let _ = writeln!(text, "v {} {} {}", place.x, place.y, place.z);
    }
    for corners in &mesh.corners {
        let [a, b, c] = corners.map(|corner| corner + 1);
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_is_loaded_as_it_was_written_and_timed() {
        let extent = Extent {
            is_quick: true,
            up_to: 400.0,
            set: Vec::new(),
        };
        let mut models = models(&extent).expect("they are built in");
        let sizes: Vec<usize> = models.iter().map(Model::len).collect();
        assert_eq!(sizes, [320]);
        assert!(models[0].point().is_none());
        let folder = tempfile::tempdir().expect("a temporary folder");
        models[0].run(folder.path()).expect("it runs");
        let point = models[0].point().expect("it was measured");
        let parts: f64 = point.parts(&PARTS).y;
        let whole = point.time.median_ms.expect("it was measured");
        assert!((parts - whole).abs() < 1e-9 && whole > 0.0);
        let file = folder.path().join("320.obj");
        let mesh = Mesh::open(&file.to_string_lossy(), Path::new("")).expect("it is a model");
        assert_eq!(mesh.corners.len(), 320);
    }
}
