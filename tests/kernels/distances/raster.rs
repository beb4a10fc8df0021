//! The method `raster`: against its twin, against the search in trees, and how much each mapping costs in precision.

use super::{TORUS, both, scene, scenes};
use crate::common::{Gpu, gpu};
use myxo::mesh::surface::NONE;
use myxo::scene::Scene;
use myxo::scene::settings::{AtlasMethod, DepthMapping, DistanceMethod, SignRule};
use myxo::sim::raster::{MOST_IN_A_DRAW, RasterLayout};
use myxo::sim::{Setup, Simulation};

/// The distances after one step by a method.
fn fields(gpu: &Gpu, scene: &Scene) -> (Vec<f32>, Vec<u32>) {
    fields_from(gpu, scene, &Setup::new(scene).unwrap())
}

/// As [`fields`], of what is set up: methods and mappings differ in nothing there.
fn fields_from(gpu: &Gpu, scene: &Scene, setup: &Setup) -> (Vec<f32>, Vec<u32>) {
    let mut simulation = Simulation::from_setup(&gpu.ctx, scene, setup.clone()).unwrap();
    gpu.run(|rec| simulation.record_step(rec));
    (
        gpu.ctx
            .download(&simulation.state().near.distances)
            .unwrap(),
        gpu.ctx.download(&simulation.state().near.nearest).unwrap(),
    )
}

/// Pairs of small meshes in contact, three objects, an open sheet, and atlases of odd sizes.
fn pairs() -> Vec<(String, Scene)> {
    let ball = "builtin:icosphere?subdivisions=2";
    let cube = "builtin:cube?divisions=3";
    let meshes = [
        (cube, ball, 128),
        (TORUS, cube, 131),
        (ball, TORUS, 256),
        ("builtin:plane?columns=7&rows=5", ball, 161),
        (TORUS, TORUS, 200),
    ];
    let pairs = meshes.map(|(a, b, size)| {
        let place = [0.7, 0.3, 0.2];
        let pair = scene(
            &[(a, [0.0; 3], [0.0; 3]), (b, place, [40.0, 10.0, 25.0])],
            |s| {
                s.atlas.size = size;
                s.distance.reach = 0.3;
                if size == 256 {
                    s.atlas.method = AtlasMethod::Grid;
                }
            },
        );
        (format!("{a} and {b}"), pair)
    });
    let named = scenes().into_iter();
    pairs
        .into_iter()
        .chain(named.map(|(name, scene)| (name.to_owned(), scene)))
        .collect()
}

/// What a mapping makes of a scene, compared with the search in trees.
#[derive(Clone, Copy, Debug, Default)]
struct Differences {
    /// Owned texels within reach.
    within: usize,
    /// Those that name another triangle.
    other_triangle: usize,
    /// Of these, those that name a triangle which has no corner in common with the nearest.
    stranger: usize,
    /// Those with another sign.
    other_sign: usize,
    /// Largest difference of distances, in scene radii.
    error: f32,
}

impl Differences {
    fn add(
        &mut self,
        setup: &Setup,
        radius: f32,
        bvh: &(Vec<f32>, Vec<u32>),
        raster: &(Vec<f32>, Vec<u32>),
    ) {
        for sample in &setup.distance.samples {
            let t = sample.texel as usize;
            let (a, b) = (bvh.0[t], raster.0[t]);
            self.within += usize::from(bvh.1[t] != NONE);
            self.other_triangle += usize::from(bvh.1[t] != raster.1[t]);
            self.stranger += usize::from(!are_neighbours(setup, bvh.1[t], raster.1[t]));
            self.other_sign += usize::from((a < 0.0) != (b < 0.0));
            self.error = self.error.max((a - b).abs() / radius);
        }
    }
}

/// Have two triangles a corner in common, or is neither one?
fn are_neighbours(setup: &Setup, a: u32, b: u32) -> bool {
    if a == NONE || b == NONE {
        return a == b;
    }
    let [a, b] = [a, b].map(|triangle| setup.surface.corners[triangle as usize]);
    a.iter().any(|corner| b.contains(corner))
}

/// Of each mapping, over all pairs, or over some that are wholly within a larger reach.
fn differences(gpu: &Gpu, reach: Option<f32>) -> Vec<(DepthMapping, Differences)> {
    let of = |&mapping| (mapping, Differences::default());
    let mut sums: Vec<_> = DepthMapping::ALL.iter().map(of).collect();
    let mut pairs = pairs();
    if reach.is_some() {
        pairs.truncate(3);
    }
    for (_, mut scene) in pairs {
        scene.settings.distance.reach = reach.unwrap_or(scene.settings.distance.reach);
        let setup = Setup::new(&scene).unwrap();
        let bvh = fields_from(gpu, &scene, &setup);
        scene.settings.distance.method = DistanceMethod::Raster;
        for (mapping, sum) in &mut sums {
            scene.settings.distance.depth = *mapping;
            let raster = fields_from(gpu, &scene, &setup);
            sum.add(&setup, scene.radius, &bvh, &raster);
        }
    }
    sums
}

/// The bounds stand in the table in `src/sim/raster.rs`, which is taken from what this prints.
#[test]
fn what_each_mapping_confuses_is_bounded() {
    let Some(gpu) = gpu() else { return };
    let of_reach = |reach| {
        differences(&gpu, reach)
            .into_iter()
            .map(move |of| (reach, of))
    };
    for (reach, (mapping, found)) in [None, Some(20.0)].into_iter().flat_map(of_reach) {
        println!("{mapping:?}, {reach:?}: {found:?}");
        assert!(found.within > 20_000, "{found:?}");
        // A projection confuses what is far from its eye, the more the farther. Its slope is near / z^2, and depths below 1 are 2^-24 from
        // each other and rounded twice, so distances that differ by up to 2^-23 z^2 / near may have one: 5e-5 scene radii at z = 2, 0.02
        // at 40. The bounds are higher: with another sign a distance is off by twice its own length.
        if mapping == DepthMapping::Clip {
            let most_error = if reach.is_some() { 0.05 } else { 2e-4 };
            assert!(found.error < most_error, "{found:?}");
            assert!(found.other_sign * 1000 <= found.within || reach.is_some());
            continue;
        }
        assert_eq!(found.other_sign, 0, "{mapping:?}: {found:?}");
        let (most_others, most_strangers, most_error) = match (mapping, reach) {
            (_, None) => (0.06, 1e-4, 1e-6),
            (DepthMapping::Ordered, _) => (0.1, 1e-4, 1e-6),
            _ => (0.1, 1e-4, 5e-6),
        };
        let share = |count: usize| count as f64 / found.within as f64;
        assert!(
            share(found.other_triangle) < most_others,
            "{mapping:?}: {found:?}"
        );
        assert!(
            share(found.stranger) < most_strangers,
            "{mapping:?}: {found:?}"
        );
        assert!(found.error < most_error, "{mapping:?}: {found:?}");
    }
    gpu.finish();
}

/// A mesh so large that a draw of it for all triangles of the other is one of several.
#[test]
fn large_meshes_are_drawn_in_pieces() {
    let Some(gpu) = gpu() else { return };
    let ball = "builtin:icosphere?subdivisions=2";
    let place = [1.1, 0.1, 0.2];
    let meshes = [
        ("builtin:torus", [0.0; 3], [0.0; 3]),
        (ball, place, [0.0; 3]),
    ];
    let mut scene = scene(&meshes, |s| {
        s.atlas.size = 256;
        s.distance.reach = 0.1;
    });
    let [torus, ball] = [0, 1].map(|object: usize| {
        let (first, end) = scene.surface.objects[object].triangles;
        end - first
    });
    assert!(3 * torus * ball > MOST_IN_A_DRAW);
    let setup = Setup::new(&scene).unwrap();
    let bvh = fields_from(&gpu, &scene, &setup);
    scene.settings.distance.method = DistanceMethod::Raster;
    let raster = fields_from(&gpu, &scene, &setup);
    let mut sum = Differences::default();
    sum.add(&setup, scene.radius, &bvh, &raster);
    assert!(sum.within > 2000, "{sum:?}");
    assert_eq!((sum.stranger, sum.other_sign), (0, 0), "{sum:?}");
    assert!(sum.error < 1e-6, "{sum:?}");
    gpu.finish();
}

#[test]
fn drawn_distances_are_those_of_the_twin() {
    let Some(gpu) = gpu() else { return };
    for (name, mut scene) in scenes() {
        let setup = Setup::new(&scene).unwrap();
        for &mapping in DepthMapping::ALL {
            scene.settings.distance.method = DistanceMethod::Raster;
            scene.settings.distance.depth = mapping;
            let (kernel, twin) = both(&gpu, &scene, &setup);
            let again = fields_from(&gpu, &scene, &setup);
            assert!(kernel == again, "{name}, {mapping:?}: two runs differ");
            let differ = kernel.1.iter().zip(&twin.1).filter(|(a, b)| a != b).count();
            // The curves divide, which devices may round otherwise.
            let most = match mapping {
                DepthMapping::Ordered | DepthMapping::Linear => 0,
                _ => kernel.1.len() / 1000,
            };
            assert!(
                differ <= most,
                "{name}, {mapping:?}: {differ} other triangles"
            );
            let most = if mapping == DepthMapping::Clip {
                2e-4
            } else {
                2e-6
            };
            for (a, b) in kernel.0.iter().zip(&twin.0) {
                assert!(
                    (a - b).abs() < most * scene.radius,
                    "{name}, {mapping:?}: {a}, {b}"
                );
            }
        }
    }
    gpu.finish();
}

/// Other rules of signs do not care how the nearest triangle was found.
#[test]
fn drawn_distances_have_the_signs_of_every_rule() {
    let Some(gpu) = gpu() else { return };
    for (name, mut scene) in scenes() {
        let setup = Setup::new(&scene).unwrap();
        for sign in [SignRule::Winding, SignRule::Facing] {
            scene.settings.distance.sign = sign;
            scene.settings.distance.method = DistanceMethod::Bvh;
            let bvh = fields_from(&gpu, &scene, &setup);
            scene.settings.distance.method = DistanceMethod::Raster;
            let raster = fields_from(&gpu, &scene, &setup);
            let mut sum = Differences::default();
            sum.add(&setup, scene.radius, &bvh, &raster);
            assert!(
                sum.other_sign * 2000 <= sum.within,
                "{name}, {sign:?}: {sum:?}"
            );
        }
    }
    gpu.finish();
}

/// Deep inside of a closed object is inside, however far from its triangles, and its hole is outside.
#[test]
fn deep_inside_is_inside() {
    let Some(gpu) = gpu() else { return };
    let ball = "builtin:icosphere?subdivisions=2";
    let mut all = scene(
        &[
            (ball, [0.0; 3], [0.0; 3]),
            ("builtin:cube", [0.1, 0.0, 0.0], [0.0; 3]),
            (TORUS, [0.1, 0.0, 0.0], [0.0; 3]),
        ],
        |s| s.distance.reach = 0.01,
    );
    for object in 1..3 {
        all.settings.objects[object].scale = if object == 1 { 0.2 } else { 4.0 };
    }
    let mut all = Scene::from_settings("test".to_owned(), all.settings, ".".into()).unwrap();
    let bvh = fields(&gpu, &all);
    let reach = all.settings.distance.reach * all.radius;
    let setup = Setup::new(&all).unwrap();
    let deep = setup
        .distance
        .samples
        .iter()
        .filter(|s| bvh.0[s.texel as usize] == -reach);
    assert!(deep.count() > 20, "the cube lies in the ball");
    all.settings.distance.method = DistanceMethod::Raster;
    for &mapping in DepthMapping::ALL {
        all.settings.distance.depth = mapping;
        let raster = fields(&gpu, &all);
        let mut sum = Differences::default();
        sum.add(&setup, all.radius, &bvh, &raster);
        // A projection confuses a few.
        let (most_signs, most) = if mapping == DepthMapping::Clip {
            (sum.within / 1000, 2e-4)
        } else {
            (0, 1e-5)
        };
        assert!(sum.other_sign <= most_signs, "{mapping:?}: {sum:?}");
        assert!(sum.error < most, "{mapping:?}: {sum:?}");
    }
    gpu.finish();
}

/// The method may change while it runs; what is drawn into is there only while it is used, and nothing is drawn where
/// nothing moves.
#[test]
fn the_method_changes_while_it_runs() {
    let Some(gpu) = gpu() else { return };
    let scene = scenes().remove(0).1;
    let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let mut settings = scene.settings.clone();
    let mut seen = Vec::new();
    for method in [
        DistanceMethod::Bvh,
        DistanceMethod::Raster,
        DistanceMethod::Raster,
        DistanceMethod::Brute,
    ] {
        settings.distance.method = method;
        simulation.apply(&settings).unwrap();
        let uses_it = method == DistanceMethod::Raster;
        assert_eq!(simulation.state().raster.is_some(), uses_it);
        let names = recorded(&gpu, &mut simulation);
        let drawn = names
            .iter()
            .filter(|name| *name == "distance_raster")
            .count();
        let merged = names
            .iter()
            .filter(|name| *name == "distance_merge")
            .count();
        seen.push((drawn, merged));
    }
    // One pass and one merge for both objects; then nothing moves.
    assert_eq!(seen, [(0, 0), (1, 1), (0, 0), (0, 0)]);
    let distances = gpu
        .ctx
        .download(&simulation.state().near.distances)
        .unwrap();
    assert_eq!(
        distances,
        fields(&gpu, &scene).0,
        "by brute force after all, as by trees"
    );
    gpu.finish();
}

/// The names of what a step records.
fn recorded(gpu: &Gpu, simulation: &mut Simulation) -> Vec<String> {
    let mut frames = myxo::gpu::Frames::new(&gpu.ctx, 1).unwrap();
    frames.run(|rec| simulation.record_step(rec)).unwrap();
    let frame = frames.timings().frames().next().unwrap();
    frame.iter().map(|span| span.name.clone()).collect()
}

/// Outlines hold every texel that their triangle owns, with room for rounding, in charts and in cells.
#[test]
fn outlines_hold_what_triangles_own() {
    let (mut laid_out, mut texels) = (0, 0);
    for method in AtlasMethod::ALL {
        for size in [37, 128, 256] {
            let objects = [
                (TORUS, [0.0; 3], [0.0; 3]),
                (
                    "builtin:icosphere?subdivisions=3",
                    [2.0, 0.0, 0.0],
                    [0.0; 3],
                ),
            ];
            let scene = scene(&objects, |s| {
                s.atlas.size = size;
                s.atlas.method = *method;
            });
            // Not every method has room at every size.
            let Ok(setup) = Setup::new(&scene) else {
                continue;
            };
            laid_out += 1;
            let layout = RasterLayout::new(&setup);
            texels += layout.texels.len();
            assert_eq!(layout.texels.len(), setup.distance.samples.len());
            assert_eq!(layout.outlines.len(), layout.owned.len());
            for (outline, &(first, end)) in layout.outlines.iter().zip(&layout.owned) {
                let [a, b, c] = outline.corners;
                let side = (b - a).perp_dot(c - a).signum();
                for &texel in &layout.texels[first as usize..end as usize] {
                    assert_eq!(setup.atlas.owner[texel as usize], outline.triangle);
                    let p = setup.atlas.centre_of(texel);
                    for (from, to) in [(a, b), (b, c), (c, a)] {
                        let within = side * (to - from).normalize().perp_dot(p - from);
                        assert!(within > 0.02, "texel {texel} of {outline:?}: {within}");
                    }
                }
            }
        }
    }
    // Charts at two sizes and cells at one, at least.
    assert!(laid_out >= 3 && texels > 20_000, "{laid_out}, {texels}");
}
