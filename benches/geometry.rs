//! What comes before the first step, under criterion: loading a model, its half-edges, its atlas.

#![allow(missing_docs, reason = "criterion's macros make a public function")]

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::Path;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use myxo::mesh::Mesh;
use myxo::mesh::atlas::{Atlas, AtlasMethod, AtlasOptions};
use myxo::mesh::surface::Surface;
use myxo::sim::atlas_options;

const MESHES: [&str; 3] = ["cube", "icosphere?subdivisions=4", "torus"];

fn obj(mesh: &Mesh) -> String {
    let mut text = String::new();
    for place in &mesh.positions {
        let _ = writeln!(text, "v {} {} {}", place.x, place.y, place.z);
    }
    for [a, b, c] in &mesh.corners {
        let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
    }
    text
}

fn geometry(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("model.obj");
    for name in MESHES {
        let mesh = Mesh::builtin(name).expect("it is built in");
        std::fs::write(&file, obj(&mesh)).expect("there is room");
        let surface = Surface::build(&[(&mesh, 1.0)]);
        let triangles = mesh.corners.len() as u64;
        let mut group = criterion.benchmark_group("geometry");
        group
            .throughput(Throughput::Elements(triangles))
            .sample_size(10);
        group.bench_function(BenchmarkId::new("load", name), |bencher| {
            let path = file.to_string_lossy();
            bencher.iter(|| Mesh::open(&path, Path::new("")).expect("it was written"));
        });
        group.bench_function(BenchmarkId::new("half-edges", name), |bencher| {
            bencher.iter(|| Surface::build(black_box(&[(&mesh, 1.0)])));
        });
        for (method, of) in [("charts", AtlasMethod::Charts), ("grid", AtlasMethod::Grid)] {
            let options = AtlasOptions {
                method: of,
                size: 1024,
                ..atlas_options(&Default::default())
            };
            group.bench_function(
                BenchmarkId::new(format!("atlas by {method}"), name),
                |bencher| {
                    bencher.iter(|| Atlas::build(&surface, &options).expect("there is room"));
                },
            );
        }
        group.finish();
    }
}

criterion_group!(benches, geometry);
criterion_main!(benches);
