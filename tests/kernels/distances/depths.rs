//! The mappings of distances to depths: order, range, and how many different depths they have.

use crate::common::gpu;
use myxo::scene::settings::DepthMapping;
use myxo::sim::depth_queries::depth_queries;
use myxo::sim::distance::DepthLengths;
use myxo::sim::twin::depth::depth_of;

/// The lengths of mappings unless a test says others.
const USUAL: DepthLengths = DepthLengths {
    near: 0.01,
    scale: 0.0,
};

/// Floats in order, as whole numbers; -0 comes before 0.
fn key(x: f32) -> i32 {
    let bits = x.to_bits() as i32;
    if bits < 0 { i32::MIN - bits - 1 } else { bits }
}

/// The float with this key.
fn value(key: i32) -> f32 {
    let bits = if key < 0 { i32::MIN - key - 1 } else { key };
    f32::from_bits(bits as u32)
}

/// All floats from `low` to `high`, each `step`-th, in order.
fn consecutive(low: f32, high: f32, step: usize) -> Vec<f32> {
    (key(low)..=key(high)).step_by(step).map(value).collect()
}

/// 65,536 floats from `centre - half` to `centre + half`, evenly.
fn even(centre: f32, half: f32) -> Vec<f32> {
    spread(centre, half, 65_536)
}

fn spread(centre: f32, half: f32, count: u32) -> Vec<f32> {
    let middle = 0.5 * f64::from(count - 1);
    let at = |i: u32| f64::from(centre) + f64::from(half) * (f64::from(i) / middle - 1.0);
    (0..count).map(|i| at(i) as f32).collect()
}

fn distinct(mut depths: Vec<f32>) -> usize {
    depths.dedup();
    depths.len()
}

fn depth(mapping: DepthMapping, distance: f32, reach: f32, lengths: DepthLengths) -> f32 {
    let scale = lengths.scale_within(reach);
    depth_of(mapping as u32, distance, reach, lengths.near, scale)
}

fn by_twin(
    mapping: DepthMapping,
    reach: f32,
    lengths: DepthLengths,
    distances: &[f32],
) -> Vec<f32> {
    let depths = distances.iter();
    depths
        .map(|&distance| depth(mapping, distance, reach, lengths))
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
        for (reach, near, scale) in [
            (1.0, 0.01, 0.0),
            (0.2, 1.0, 0.7),
            (3.7e-3, 0.01, 0.0),
            (812.0, 1e-4, 3.0),
        ] {
            let lengths = DepthLengths { near, scale };
            for distances in inputs(reach) {
                let twin = by_twin(mapping, reach, lengths, &distances);
                let kernel = depth_queries(&gpu.ctx, mapping, reach, lengths, &distances).unwrap();
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
                    // What the division rounds is multiplied if the near plane is far away.
                    DepthMapping::Clip => 5e-7 * (1.0 + near / reach),
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

/// How far the curves are from what they are named after. Would catch: a projection with other planes, and curves whose scale is that of
/// the reach where they have one of their own.
#[test]
fn depths_are_those_of_the_named_functions() {
    let reach = 2.0;
    for (near, scale) in [(0.01, 0.0), (0.5, 1.7), (3.0, 0.125)] {
        let lengths = DepthLengths { near, scale };
        let unit = if scale > 0.0 { scale } else { 0.5 };
        let (near, far) = (f64::from(near), f64::from(near) + 4.0);
        for distance in even(0.0, 5.0).into_iter().step_by(7) {
            let check = |mapping: DepthMapping, expected: f64| {
                let depth = f64::from(depth(mapping, distance, reach, lengths));
                assert!(
                    (depth - expected).abs() < 2.5e-7,
                    "{mapping:?} of {distance}, {lengths:?}: {depth}, {expected}"
                );
            };
            let within = f64::from(distance).clamp(-2.0, 2.0);
            let z = near + within + 2.0;
            check(DepthMapping::Clip, far / (far - near) * (1.0 - near / z));
            check(DepthMapping::Linear, 0.5 + 0.25 * within);
            let x = f64::from(distance) / f64::from(unit);
            check(DepthMapping::Logistic, 1.0 / (1.0 + (-x).exp()));
            let angle = x.atan() / std::f64::consts::PI;
            check(DepthMapping::Arctangent, 0.5 + angle);
        }
    }
    // The bits of 1: 3f800000, flipped bf800000, shifted 2fe00000, halved 2f600000. Of -1: bf800000, 407fffff, 101fffff,
    // 0f9fffff.
    let ordered = |distance: f32| depth(DepthMapping::Ordered, distance, 1.0, USUAL).to_bits();
    assert_eq!(ordered(1.0), 0x2f60_0000);
    assert_eq!(ordered(-1.0), 0x0f9f_ffff);
    assert_eq!(ordered(0.0), 0x1f80_0000);
}

/// How many depths 65,536 distances become, as the table in `src/sim/raster.rs` says it.
#[test]
fn how_many_distances_each_mapping_distinguishes() {
    let reach = 1.0;
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
        ("more of them", spread(0.0, 1.0, 1 << 20)),
    ];
    let mut counts = Vec::new();
    for (name, distances) in &lists {
        let all = if *name == "more of them" {
            1 << 20
        } else {
            65_536
        };
        assert_eq!(distances.len(), all, "{name}");
        let row: Vec<usize> = DepthMapping::ALL
            .iter()
            .map(|&mapping| distinct(by_twin(mapping, reach, USUAL, distances)))
            .collect();
        println!("{name}: {row:?}, of {}", distinct(distances.clone()));
        counts.push(row);
    }
    // Columns: ordered, clip, logistic, arctangent, linear. Bits lose two of them wherever they are; the others have 2^24 depths
    // for everything, and half of them above 0; a projection spends most of them on the smallest distances.
    let expected = [
        [16_384, 1, 1, 1, 1],
        [16_384, 81, 3_588, 6_538, 16_384],
        [65_536, 330, 33_388, 54_130, 25_167],
        [6_293, 41, 1_231, 2_235, 8_388],
        [65_536, 65_535, 65_536, 65_536, 65_536],
        [1_048_576, 504_386, 1_048_576, 1_048_576, 1_048_576],
    ];
    assert_eq!(counts, expected);
}

/// Where each mapping ends, with a scale of 1, as the second table in `src/sim/raster.rs` says it: from there on all distances have one
/// depth. Would catch: a curve that is cut off earlier than its last depths, and a range that does not end at the planes.
#[test]
fn each_mapping_ends_where_it_should() {
    let lengths = DepthLengths {
        near: 0.01,
        scale: 1.0,
    };
    for (mapping, low, high) in [
        // The last two bits are lost.
        (DepthMapping::Ordered, -3.402_822_05e38, 3.402_822_86e38),
        // Far from the eye the last depths are far apart.
        (DepthMapping::Clip, -1.0, 0.999_957_442),
        (DepthMapping::Logistic, -80.0, 16.635_532_4),
        (DepthMapping::Arctangent, -16_777_218.0, 5_592_405.5),
        (DepthMapping::Linear, -1.0, 0.999_999_881),
    ] {
        let of = |key: i64| depth(mapping, value(key as i32), 1.0, lengths);
        let ends = [f32::MIN, f32::MAX].map(|x| i64::from(key(x)));
        let [least, most] = ends.map(of);
        // The first key for which something holds, if it holds from there on.
        let first = |holds: &dyn Fn(i64) -> bool| {
            let [mut low, mut high] = ends;
            while low < high {
                let middle = (low + high).div_euclid(2);
                match holds(middle) {
                    true => high = middle,
                    false => low = middle + 1,
                }
            }
            low
        };
        let found = [
            value((first(&|key| of(key) > least) - 1) as i32),
            value(first(&|key| of(key) >= most) as i32),
        ];
        println!("{mapping:?}: {found:?}, {least:e} to {most}");
        for (found, expected) in found.into_iter().zip([low, high]) {
            let found = f64::from(found);
            let expected: f64 = expected;
            assert!(
                (found - expected).abs() <= 1e-6 * expected.abs(),
                "{mapping:?}: {found}, {expected}"
            );
        }
    }
}
