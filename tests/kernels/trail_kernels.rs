//! The kernels of the trail against their twins, by every way to its texels: equal within a stated bound, at awkward sizes.

use crate::common::{awkward_sizes, gpu};
use myxo::gpu::{Buffer, Context, Domain, Pipeline, TexelScalar, Texels, Threads};
use myxo::mesh::atlas::{BLOCK_QUADS, BLOCK_ROWS, Exchange};
use myxo::rng::{Purpose, random, unit};
use myxo::sim::kernels::{
    Diffuse, DiffuseArgs, DiffuseConstants, DiffuseParams, DiffuseSeams, DiffuseSeamsArgs,
    DiffuseSeamsConstants, DiffuseSeamsParams, ExchangeSeams, ExchangeSeamsArgs,
    ExchangeSeamsConstants, ExchangeSeamsParams,
};
use myxo::sim::texel_paths::TexelPaths;
use myxo::sim::types::{ExchangeEntry, ExchangeRow, Seam, TrailRates};
use myxo::sim::{TINY_TRAIL, Texture, twin};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

fn buffer<T: bytemuck::Pod>(ctx: &Arc<Context>, name: &str, data: &[T]) -> Buffer<T> {
    let buffer = Buffer::new(ctx, name, data.len(), Domain::Device).unwrap();
    ctx.upload(&buffer, data).unwrap();
    buffer
}

/// The ways to a texture whose first part has so many texels, or that has one part.
fn in_parts(in_quads: bool, band: u32) -> TexelPaths {
    TexelPaths {
        in_quads,
        band: if in_quads { band } else { u32::MAX },
        outgrows_block: false,
    }
}

fn texture<T: TexelScalar>(
    ctx: &Arc<Context>,
    name: &str,
    data: &[T],
    paths: TexelPaths,
) -> Texture<T> {
    Texture::by_paths(paths, buffer(ctx, name, data)).unwrap()
}

/// Random values in [0, 1), the nasty ones planted first: zero, the largest, a denormal, values about the threshold.
fn trail_values(count: usize, seed: u32) -> Vec<f32> {
    let planted = [
        0.0,
        1e30,
        1e-40,
        TINY_TRAIL,
        0.5 * TINY_TRAIL,
        2.5 * TINY_TRAIL,
    ];
    (0..count)
        .map(|i| {
            planted
                .get(i)
                .copied()
                .unwrap_or_else(|| unit(random(seed, i as u32, 0, Purpose::Start)[0]))
        })
        .collect()
}

fn assert_near(what: &str, kernel: &[f32], twin: &[f32], relative: f32) {
    assert_eq!(kernel.len(), twin.len());
    for (i, (&a, &b)) in kernel.iter().zip(twin).enumerate() {
        // The threshold below which a value becomes zero may fall between two roundings of the same value.
        let bound = relative * a.abs().max(b.abs()) + 1.01 * TINY_TRAIL;
        assert!(
            (a - b).abs() <= bound,
            "{what}, element {i}: kernel {a}, twin {b}"
        );
    }
}

/// Of three objects: in a pass that only spreads, and in the last one.
const RATES: [TrailRates; 6] = {
    const fn rates(diffusion: f32, deposit: f32, decay: f32) -> TrailRates {
        TrailRates {
            diffusion,
            deposit,
            decay,
            pad0: 0.0,
        }
    }
    [
        rates(0.1, 0.0, 1.0),
        rates(0.55, 0.0, 1.0),
        rates(0.0, 0.0, 1.0),
        rates(0.15, 2.5, 0.5),
        rates(0.5, 0.3, 0.99),
        rates(0.0, 1.1, 0.0),
    ]
};

/// Would catch, beside wrong sums: rates of another texel of four, of another object or of another kind of pass.
#[test]
fn diffuse_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    // The last one has more than 65,535 groups, so its dispatch has two dimensions.
    for (width, rows) in [
        (4, 1),
        (4, 7),
        (64, 3),
        (252, 9),
        (256, 16),
        (260, 61),
        (4100, 4093),
    ] {
        let farthest = if rows > 1000 { 1 } else { 4 };
        for distance in 1..=farthest {
            let texels = (width * rows) as usize;
            let trail = trail_values(texels, 3);
            let deposits: Vec<u32> = (0..texels as u32)
                .map(|i| random(5, i, 0, Purpose::Start)[1] % 4)
                .collect();
            // A third of the texels has no owner, some whole groups of four among them.
            let density: Vec<f32> = (0..texels as u32)
                .map(|i| {
                    if (i / 8) % 3 == 0 || i % 7 == 0 {
                        0.0
                    } else {
                        0.5 + (i % 5) as f32 * 0.3
                    }
                })
                .collect();
            let untouched = trail_values(texels, 11);
            // Three objects, texel by texel, of the second kind of pass.
            let objects: Vec<u32> = (0..texels as u32)
                .map(|i| random(7, i, 0, Purpose::Start)[2] % 3)
                .collect();
            let own_rates = (width / 4 + distance as u32).is_multiple_of(2);
            // Every block, or two of three; the last ones may reach beyond the texture.
            let reach = distance as u32 * width / 4;
            let blocks: Vec<u32> = (0..texels as u32 / 4)
                .filter(|quad| {
                    (quad / reach).is_multiple_of(BLOCK_ROWS)
                        && (quad % reach).is_multiple_of(BLOCK_QUADS)
                })
                .filter(|quad| distance == 1 || quad % 3 != 1)
                .collect();
            let previous: Vec<u32> = (0..texels as u32).collect();
            let constants = DiffuseConstants {
                distance,
                own_rates,
                ..DiffuseConstants::default()
            };
            let params = DiffuseParams {
                lane_count: BLOCK_QUADS * blocks.len() as u32,
                quad_count: texels as u32 / 4,
                quads_a_row: width / 4,
                diffusion: 0.37,
                most_density: 1.2,
                deposit: 1.7,
                decay: 0.93,
                tiny: TINY_TRAIL,
                first_rates: 3,
            };
            let (mut twin_trail, mut twin_previous) = (untouched.clone(), previous.clone());
            twin::diffuse(
                &constants,
                &params,
                &blocks,
                &trail,
                &deposits,
                &density,
                (&objects, &RATES),
                &mut twin_trail,
                &mut twin_previous,
            );

            let paths = TexelPaths::default();
            let trail = texture(&gpu.ctx, "trail", &trail, paths);
            let deposits = texture(&gpu.ctx, "deposits", &deposits, paths);
            let density = texture(&gpu.ctx, "density", &density, paths);
            let objects = texture(&gpu.ctx, "objects", &objects, paths);
            let rates = buffer(&gpu.ctx, "rates", &RATES);
            let blocks = buffer(&gpu.ctx, "blocks", &blocks);
            // To storage blocks, and to texel buffers.
            for outgrows_block in [false, true] {
                let constants = DiffuseConstants {
                    paths: TexelPaths {
                        outgrows_block,
                        ..paths
                    },
                    ..constants
                };
                let pipeline = Pipeline::<Diffuse>::new(&gpu.ctx, &constants).unwrap();
                let next_trail = texture(&gpu.ctx, "next_trail", &untouched, paths);
                let previous = texture(&gpu.ctx, "previous_deposits", &previous, paths);
                gpu.run(|rec| {
                    rec.dispatch(
                        &pipeline,
                        Threads(params.lane_count),
                        DiffuseArgs {
                            blocks: &Texels::new(&blocks, 1).unwrap(),
                            trail: &trail,
                            deposits: &deposits,
                            density: &density,
                            next_trail: &next_trail,
                            previous_deposits: &previous,
                            objects: own_rates.then_some(&objects),
                            rates: own_rates.then_some(&rates),
                        },
                        params,
                    );
                });
                let what = format!("{width} x {rows}, distance {distance}, {outgrows_block}");
                assert_eq!(
                    gpu.ctx.download(&previous).unwrap(),
                    twin_previous,
                    "{what}"
                );
                assert_near(
                    &what,
                    &gpu.ctx.download(&next_trail).unwrap(),
                    &twin_trail,
                    1e-6,
                );
            }
        }
    }
    gpu.finish();
}

/// Catches a trail that would be read where it is written.
#[test]
fn what_is_read_is_not_the_texture_that_is_written() {
    let Some(gpu) = gpu() else { return };
    let trail = texture(&gpu.ctx, "trail", &[0.0; 16], TexelPaths::default());
    let deposits = ["deposits", "previous_deposits"]
        .map(|name| texture(&gpu.ctx, name, &[0_u32; 16], TexelPaths::default()));
    let pipeline = Pipeline::<Diffuse>::new(&gpu.ctx, &DiffuseConstants::default()).unwrap();
    let density = texture(&gpu.ctx, "density", &[1.0; 16], TexelPaths::default());
    let blocks = Texels::new(&buffer(&gpu.ctx, "blocks", &[0_u32]), 1).unwrap();
    let refusal = catch_unwind(AssertUnwindSafe(|| {
        gpu.run(|rec| {
            let args = DiffuseArgs {
                blocks: &blocks,
                trail: &trail,
                deposits: &deposits[0],
                density: &density,
                next_trail: &trail,
                previous_deposits: &deposits[1],
                objects: None,
                rates: None,
            };
            rec.dispatch(&pipeline, Threads(1), args, DiffuseParams::default());
        });
    }));
    let refusal = refusal.expect_err("the trail is bound twice");
    assert_eq!(
        refusal.downcast_ref::<String>().map(String::as_str),
        Some(
            "`diffuse` binds the buffer `trail` twice, as trail_quads and as next_trail_block, and writes it"
        )
    );
}

#[test]
fn diffuse_seams_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    for (k, count) in awkward_sizes(64).into_iter().enumerate() {
        let distance = 1 + k as u32 % 4;
        // Rows at the first, the last and random places, with none to eleven pairs, gutter texels and neighbours.
        let pitch = 64;
        let texels = pitch * (2 * distance + 3 + count / pitch);
        let band = 64 * (texels / 128);
        let mut entries = Vec::new();
        let rows: Vec<ExchangeRow> = (0..count)
            .map(|i| {
                let words = random(31, i, k as u32, Purpose::Start);
                let first = entries.len() as u32;
                let (pair_count, deposit_count) = (words[0] % 12, (words[0] >> 8) % 5);
                entries.extend((0..pair_count + deposit_count).map(|e| {
                    let words = random(37, first + e, 1, Purpose::Start);
                    ExchangeEntry {
                        texel: words[0] % texels,
                        weight: 0.1 * unit(words[1]),
                    }
                }));
                let reach = distance * (pitch + 1);
                ExchangeRow {
                    texel: match i {
                        0 => 0,
                        1 => texels - 1,
                        _ => reach + words[1] % (texels - 2 * reach),
                    },
                    first,
                    pair_count,
                    // At the ends of the texture there are no neighbours.
                    counts_and_mask: deposit_count << 8 | if i < 2 { 0 } else { words[2] & 0xff },
                    conductance: 0.11 * unit(words[3]),
                }
            })
            .collect();
        let trail = trail_values(texels as usize, 19);
        let deposits: Vec<u32> = (0..texels)
            .map(|i| random(5, i, 0, Purpose::Start)[1] % 4)
            .collect();
        let density: Vec<f32> = (0..texels).map(|i| 0.2 + (i % 5) as f32 * 0.3).collect();
        let objects: Vec<u32> = (0..texels).map(|i| i / 3 % 3).collect();
        let own_rates = k % 2 == 1;
        let untouched = trail_values(texels as usize, 11);
        let params = DiffuseSeamsParams {
            row_count: count,
            reach_across: distance,
            reach_down: distance * pitch,
            diffusion: 0.37,
            deposit: 1.7,
            decay: 0.93,
            tiny: TINY_TRAIL,
            first_rates: 3,
        };
        // Two rows of one texel differ, and which of them is written last is undefined.
        let mut seen = std::collections::HashSet::new();
        let rows: Vec<ExchangeRow> = rows
            .into_iter()
            .filter(|row| seen.insert(row.texel))
            .collect();
        let params = DiffuseSeamsParams {
            row_count: rows.len() as u32,
            ..params
        };
        let mut expected = untouched.clone();
        let of_twin = DiffuseSeamsConstants {
            own_rates,
            paths: TexelPaths::default(),
        };
        twin::diffuse_seams(
            &of_twin,
            &params,
            &rows,
            &entries,
            &trail,
            &deposits,
            &density,
            (&objects, &RATES),
            &mut expected,
        );
        let packed = Exchange { rows, entries }.packed(&density);
        let rates = buffer(&gpu.ctx, "rates", &RATES);
        let rows = buffer(&gpu.ctx, "rows", &packed.rows);
        let entries = buffer(&gpu.ctx, "entries", &packed.entries);
        for in_quads in [false, true] {
            let paths = in_parts(in_quads, band);
            let constants = DiffuseSeamsConstants { own_rates, paths };
            let pipeline = Pipeline::<DiffuseSeams>::new(&gpu.ctx, &constants).unwrap();
            let next_trail = texture(&gpu.ctx, "next_trail", &untouched, paths);
            let objects = texture(&gpu.ctx, "objects", &objects, paths);
            gpu.run(|rec| {
                rec.dispatch(
                    &pipeline,
                    Threads(params.row_count),
                    DiffuseSeamsArgs {
                        rows: &Texels::new(&rows, 4).unwrap(),
                        entries: &Texels::new(&entries, 4).unwrap(),
                        trail: &texture(&gpu.ctx, "trail", &trail, paths),
                        deposits: &texture(&gpu.ctx, "deposits", &deposits, paths),
                        next_trail: &next_trail,
                        objects: own_rates.then_some(&objects),
                        rates: own_rates.then_some(&rates),
                    },
                    params,
                );
            });
            assert_near(
                &format!("{count} rows, in quads: {in_quads}"),
                &gpu.ctx.download(&next_trail).unwrap(),
                &expected,
                // Of the largest value, which may cancel.
                1e-5,
            );
        }
    }
    gpu.finish();
}

#[test]
fn exchange_seams_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    for count in awkward_sizes(64).into_iter().filter(|&count| count > 0) {
        // The first half of the texels is owned, the second is gutter.
        let trail = trail_values((2 * count as usize).next_multiple_of(4), 17);
        let seams: Vec<Seam> = (0..count)
            .map(|i| {
                let words = random(23, i, 0, Purpose::Start);
                let mut units = words.map(|w| w % 8193);
                units[0] += Seam::UNITS - units.iter().sum::<u32>();
                let source = words.map(|w| (w >> 16) % count);
                Seam::new(2 * count - 1 - i, source, units)
            })
            .collect();
        let mut expected = trail.clone();
        twin::exchange_seams(&seams, &mut expected);
        let seams = buffer(&gpu.ctx, "seams", &seams);
        let band = 64 * (count / 64);
        for in_quads in [false, true] {
            let paths = in_parts(in_quads, band);
            let constants = ExchangeSeamsConstants { paths };
            let pipeline = Pipeline::<ExchangeSeams>::new(&gpu.ctx, &constants).unwrap();
            let filled = texture(&gpu.ctx, "trail", &trail, paths);
            gpu.run(|rec| {
                rec.dispatch(
                    &pipeline,
                    Threads(count),
                    ExchangeSeamsArgs {
                        seams: &Texels::new(&seams, 4).unwrap(),
                        trail: &filled,
                    },
                    ExchangeSeamsParams { seam_count: count },
                );
            });
            assert_near(
                &format!("{count} seams, in quads: {in_quads}"),
                &gpu.ctx.download(&filled).unwrap(),
                &expected,
                1e-6,
            );
        }
    }
    gpu.finish();
}
