//! Signed distances between objects: kernels against twins, and both against what can be worked out.

mod common;

use common::{Gpu, gpu};
use myxo::scene::Scene;
use myxo::scene::settings::{DistanceMethod, ObjectSettings, Settings};
use myxo::sim::{Simulation, twin};

/// A scene of several meshes at places, turned about X, Y and Z.
fn scene(objects: &[(&str, [f32; 3], [f32; 3])], change: impl FnOnce(&mut Settings)) -> Scene {
    let mut settings = Settings::default();
    settings.particles.count = 500;
    settings.atlas.size = 128;
    settings.objects = objects
        .iter()
        .map(|&(mesh, position, rotation)| ObjectSettings {
            mesh: mesh.to_owned(),
            position,
            rotation,
            ..ObjectSettings::default()
        })
        .collect();
    change(&mut settings);
    Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap()
}

const TORUS: &str = "builtin:torus?major=24&minor=16";

/// Scenes that touch, lie in one another, are open, and are far apart.
fn scenes() -> Vec<(&'static str, Scene)> {
    vec![
        (
            "two tori",
            scene(
                &[
                    (TORUS, [0.0; 3], [0.0; 3]),
                    (TORUS, [1.1, 0.2, 0.1], [70.0, 10.0, 5.0]),
                ],
                |_| (),
            ),
        ),
        (
            "a cube in a ball, over a plane",
            scene(
                &[
                    ("builtin:icosphere?subdivisions=3", [0.0; 3], [0.0; 3]),
                    (
                        "builtin:cube?divisions=3",
                        [0.1, 0.5, 0.0],
                        [10.0, 20.0, 30.0],
                    ),
                    (
                        "builtin:plane?columns=5&rows=4",
                        [0.0, -0.9, 0.0],
                        [0.0, 0.0, 8.0],
                    ),
                ],
                |s| s.distance.reach = 0.4,
            ),
        ),
        (
            "far apart",
            scene(
                &[
                    ("builtin:cube", [0.0; 3], [0.0; 3]),
                    ("builtin:cube", [9.0, 0.0, 0.0], [0.0; 3]),
                ],
                |s| s.distance.reach = 0.1,
            ),
        ),
    ]
}

/// The distances after one step by the kernels, and by the twins.
type Fields = (Vec<f32>, Vec<u32>);
fn both(gpu: &Gpu, scene: &Scene) -> (Fields, Fields) {
    let mut simulation = Simulation::new(&gpu.ctx, scene).unwrap();
    gpu.run(|rec| simulation.record_step(rec));
    let kernel = (
        gpu.ctx.download(&simulation.state().distances).unwrap(),
        gpu.ctx.download(&simulation.state().nearest).unwrap(),
    );
    let mut twin = twin::Simulation::new(simulation.setup().clone(), scene.settings.clone());
    twin.step();
    let (distances, nearest) = twin.distances();
    (kernel, (distances.to_vec(), nearest.to_vec()))
}

/// Each against its twin, and one against the other, which must find the very same.
#[test]
fn distance_kernels_agree_with_their_twins() {
    let Some(gpu) = gpu() else { return };
    for (name, mut scene) in scenes() {
        let (kernel, twin) = both(&gpu, &scene);
        scene.settings.distance.method = DistanceMethod::Brute;
        let by_brute = both(&gpu, &scene);
        assert!(kernel == by_brute.0 && twin == by_brute.1, "{name}");
        let reach = scene.settings.distance.reach * scene.radius;
        let mut within = 0;
        for texel in 0..kernel.0.len() {
            let (a, b) = (kernel.0[texel], twin.0[texel]);
            assert!((a - b).abs() < 2e-6 * scene.radius, "{name}: {a}, {b}");
            assert_eq!(
                kernel.1[texel], twin.1[texel],
                "{name}: texel {texel}, {a}, {b}"
            );
            within += usize::from(a.abs() < reach && kernel.1[texel] != u32::MAX);
        }
        assert_eq!(
            within > 0,
            name != "far apart",
            "{name}: {within} within reach"
        );
    }
    gpu.finish();
}
