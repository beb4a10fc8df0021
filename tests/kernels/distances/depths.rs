//! The four mappings of distances to depths: order, range, and how many different depths they have.

use crate::common::gpu;
use myxo::scene::settings::DepthMapping;
use myxo::sim::depth_queries::depth_queries;
use myxo::sim::twin::depth::depth_of;

/// All floats from `low` to `high`, each `step`-th, in order; -0 comes before 0.
fn consecutive(low: f32, high: f32, step: usize) -> Vec<f32> {
    let key = |x: f32| {
        let bits = x.to_bits() as i32;
        if bits < 0 { i32::MIN - bits - 1 } else { bits }
    };
    let value = |key: i32| {
        let bits = if key < 0 { i32::MIN - key - 1 } else { key };
        f32::from_bits(bits as u32)
    };
    (key(low)..=key(high)).step_by(step).map(value).collect()
}

/// 65,536 floats from `centre - half` to `centre + half`, evenly.
fn even(centre: f32, half: f32) -> Vec<f32> {
    let at = |i: u32| f64::from(centre) + f64::from(half) * (f64::from(i) / 32_767.5 - 1.0);
    (0..65_536).map(|i| at(i) as f32).collect()
}

fn distinct(mut depths: Vec<f32>) -> usize {
    depths.dedup();
    depths.len()
}

fn by_twin(mapping: DepthMapping, reach: f32, distances: &[f32]) -> Vec<f32> {
    let depths = distances.iter();
    depths
        .map(|&d| depth_of(mapping as u32, d, reach))
        .collect()
}

/// Sorted inputs of every kind.
fn inputs(reach: f32) -> Vec<Vec<f32>> {
    let mut lists = vec![
        consecutive(f32::MIN, f32::MAX, 65_521),
        consecutive(f32::from_bits(0x8000_4000), f32::from_bits(0x4000), 1),
        even(0.0, 3.0 * reach),
        vec![
            f32::NEG_INFINITY,
            f32::MIN,
            -0.0,
            0.0,
            f32::MAX,
            f32::INFINITY,
        ],
    ];
    // Round reach, the joints of the curves, and where they are steep.
    for share in [0.01, 0.1, 0.103_553, 0.25, 0.603_553, 1.0, 2.0, 4.0, 4.16] {
        let at = share * reach;
        let near = |by: i32| f32::from_bits((at.to_bits() as i32 + by) as u32);
        lists.push(consecutive(near(-20_000), near(20_000), 1));
        lists.push(consecutive(-near(20_000), -near(-20_000), 1));
    }
    lists
}

#[test]
fn depths_keep_the_order_of_distances_and_lie_below_one() {
    let Some(gpu) = gpu() else { return };
    for &mapping in DepthMapping::ALL {
        for reach in [1.0, 0.2, 3.7e-3, 812.0] {
            for distances in inputs(reach) {
                let twin = by_twin(mapping, reach, &distances);
                let kernel = depth_queries(&gpu.ctx, mapping, reach, &distances).unwrap();
                for depths in [&twin, &kernel] {
                    let wrong = depths.windows(2).position(|pair| pair[1] < pair[0]);
                    if let Some(i) = wrong {
                        panic!(
                            "{mapping:?}, reach {reach}: {} becomes {}, and {} {}",
                            distances[i],
                            depths[i],
                            distances[i + 1],
                            depths[i + 1]
                        );
                    }
                    assert!(
                        depths.iter().all(|depth| (0.0..1.0).contains(depth)),
                        "{mapping:?}, reach {reach}"
                    );
                }
                // Divisions may be rounded otherwise; numbers below the smallest normal one may count as 0.
                let bound = match mapping {
                    DepthMapping::Ordered => f32::MIN_POSITIVE,
                    _ => 5e-7,
                };
                let differ = twin.iter().zip(&kernel);
                let differ = differ.filter(|(a, b)| (*a - *b).abs() > bound).count();
                assert_eq!(differ, 0, "{mapping:?}, reach {reach}");
            }
        }
    }
    gpu.finish();
}

/// How far the curves are from what they are named after.
#[test]
fn depths_are_those_of_the_named_functions() {
    for distance in even(0.0, 5.0).into_iter().step_by(7) {
        let x = f64::from(distance) / 2.0;
        let near = |mapping: DepthMapping, expected: f64| {
            let depth = f64::from(depth_of(mapping as u32, distance, 2.0));
            assert!(
                (depth - expected).abs() < 2.5e-7,
                "{mapping:?} of {distance}: {depth}, {expected}"
            );
        };
        near(DepthMapping::Clip, 0.5 + 0.5 * x.clamp(-1.0, 1.0));
        near(DepthMapping::Logistic, 1.0 / (1.0 + (-4.0 * x).exp()));
        near(
            DepthMapping::Arctangent,
            0.5 + (4.0 * x).atan() / std::f64::consts::PI,
        );
    }
    // The bits of 1: 3f800000, flipped bf800000, shifted 2fe00000, halved 2f600000. Of -1: bf800000, 407fffff, 101fffff,
    // 0f9fffff.
    let ordered = |distance: f32| depth_of(DepthMapping::Ordered as u32, distance, 1.0).to_bits();
    assert_eq!(ordered(1.0), 0x2f60_0000);
    assert_eq!(ordered(-1.0), 0x0f9f_ffff);
    assert_eq!(ordered(0.0), 0x1f80_0000);
}

/// How many depths 65,536 distances become, as the table in `src/sim/raster.rs` says it.
#[test]
fn how_many_distances_each_mapping_distinguishes() {
    let (reach, all) = (1.0, 65_536);
    let lists = [
        (
            "neighbours of 0",
            consecutive(f32::from_bits(0x8000_7fff), f32::from_bits(0x7fff), 1),
        ),
        ("neighbours of reach", {
            let bits = 1.0_f32.to_bits();
            (bits - 32_768..bits + 32_768).map(f32::from_bits).collect()
        }),
        ("within 0.001 of 0", even(0.0, 1e-3)),
        ("within 0.001 of reach", even(1.0, 1e-3)),
        ("from -reach to reach", even(0.0, 1.0)),
    ];
    let mut counts = Vec::new();
    for (name, distances) in &lists {
        assert_eq!(distances.len(), all, "{name}");
        let row: Vec<usize> = DepthMapping::ALL
            .iter()
            .map(|&mapping| distinct(by_twin(mapping, reach, distances)))
            .collect();
        println!("{name}: {row:?}, of {}", distinct(distances.clone()));
        counts.push(row);
    }
    // Columns: ordered, clip, logistic, arctangent. Bits lose two of them wherever they are; the others have 2^24 depths
    // for everything, and half of them above 0.
    let expected = [
        [16_384, 1, 1, 1],
        [16_384, 16_384, 3_588, 6_538],
        [65_536, 25_167, 33_388, 54_130],
        [6_293, 8_388, 1_231, 2_235],
        [65_536, 65_536, 65_536, 65_536],
    ];
    assert_eq!(counts, expected);
}
