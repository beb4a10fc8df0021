//! Dispatches: sizes, constants, indirect groups, texel buffers.

use super::selftest::*;
use super::*;

#[test]
fn a_kernel_runs_at_awkward_sizes() {
    let Some(ctx) = context() else { return };
    let scale = Pipeline::<Scale>::new(&ctx, &ScaleConstants::default()).unwrap();
    let mut frames = Frames::new(&ctx, 2).unwrap();
    // The last two need more than 65,535 groups.
    for count in [0, 1, 63, 64, 65, 1000, 65_535 * 64 + 1, 65_536 * 64 + 65] {
        let data: Vec<f32> = (0..count).map(|i| (i % 4096) as f32).collect();
        let source = Buffer::from_slice(&ctx, "source", &data).unwrap();
        // One element more than the kernel may touch.
        let target = Buffer::from_slice(&ctx, "target", &vec![-1.0; count + 1]).unwrap();
        let mut rec = frames.begin().unwrap();
        let params = ScaleParams {
            count: count as u32,
            factor: glam::Vec2::new(2.0, 1.5),
        };
        rec.dispatch(
            &scale,
            Threads::of(count),
            ScaleArgs {
                source: &source,
                target: &target,
            },
            params,
        );
        frames.submit(rec).unwrap();
        let expected = data.iter().map(|x| x * 3.0 + 5.0).chain([-1.0]);
        let found = ctx.download(&target).unwrap();
        let wrong = expected
            .zip(&found)
            .position(|(expected, found)| expected != *found);
        assert_eq!(wrong, None, "{count} elements");
    }
    frames.wait_idle().unwrap();
    assert_silent(&ctx);
}

#[test]
fn constants_reach_the_kernel() {
    let Some(ctx) = context() else { return };
    assert_eq!(
        ScaleConstants::default(),
        ScaleConstants {
            shift: 5,
            negate: false
        }
    );
    let scale = Pipeline::<Scale>::new(
        &ctx,
        &ScaleConstants {
            shift: 100,
            negate: true,
        },
    )
    .unwrap();
    let source = Buffer::from_slice(&ctx, "source", &[1.0_f32]).unwrap();
    let target = Buffer::zeroed(&ctx, "target", 1).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    let params = ScaleParams {
        count: 1,
        factor: glam::Vec2::ONE,
    };
    rec.dispatch(
        &scale,
        Threads(1),
        ScaleArgs {
            source: &source,
            target: &target,
        },
        params,
    );
    frames.submit(rec).unwrap();
    assert_eq!(ctx.download(&target).unwrap(), [-101.0_f32]);
    assert_silent(&ctx);
}

#[test]
fn equal_constants_share_one_pipeline() {
    let Some(ctx) = context() else { return };
    let made = |shift, negate, name| {
        let constants = ScaleConstants { shift, negate };
        let pipeline = Pipeline::<Scale>::named(&ctx, &constants, name).unwrap();
        pipeline.core().handles()
    };
    let first = made(100, true, "scale");
    let again = made(100, true, "scale");
    assert_eq!(again, first, "though it was dropped in between");
    let mut others = vec![
        first.pipeline,
        made(101, true, "scale").pipeline,
        made(100, false, "scale").pipeline,
        made(100, true, "scale_again").pipeline,
    ];
    others.sort_unstable();
    others.dedup();
    assert_eq!(others.len(), 4, "each of its own");
    let at_once = std::thread::scope(|scope| {
        let threads = [(); 4].map(|()| scope.spawn(|| made(7, false, "scale")));
        threads.map(|thread| thread.join().unwrap())
    });
    assert!(at_once.iter().all(|made| *made == at_once[0]));
    let messages = ctx.end().expect("nothing else has the context");
    assert!(
        messages.is_empty(),
        "all are freed:\n{}",
        messages.join("\n")
    );
}

#[test]
fn groups_made_on_the_device_run_every_invocation() {
    let Some(ctx) = context() else { return };
    let size_up = Pipeline::<SizeUp>::new(&ctx, &()).unwrap();
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let groups = Buffer::<DispatchGroups>::zeroed(&ctx, "groups", 1).unwrap();
    for count in [0_u32, 1, 64, 65, 65_535 * 64 + 1] {
        let values = Buffer::<u32>::zeroed(&ctx, "values", count as usize + 1).unwrap();
        let mut rec = frames.begin().unwrap();
        rec.dispatch(
            &size_up,
            Threads(1),
            SizeUpArgs { groups: &groups },
            SizeUpParams {
                count,
                group_size: 64,
            },
        );
        rec.dispatch_indirect(
            &bump,
            (&groups, 0),
            BumpArgs { values: &values },
            BumpParams { count, amount: 3 },
        );
        frames.submit(rec).unwrap();
        let values = ctx.download(&values).unwrap();
        assert!(
            values[..count as usize].iter().all(|v| *v == 3),
            "{count} elements"
        );
        assert_eq!(values[count as usize], 0, "{count} elements");
        let expected = Threads(count).groups(64, 65_535);
        let found = ctx.download(&groups).unwrap()[0];
        assert_eq!(
            expected.unwrap_or_default(),
            [found.x, found.y],
            "{count} elements"
        );
    }
    assert_silent(&ctx);
}

/// In both forms of kernels: in branches, in groups that are not full, and with more than one group.
#[test]
fn what_is_appended_is_listed_once() {
    for for_cards in [false, true] {
        let Some(ctx) = context_with(ContextOptions {
            validation: true,
            card_forms: Some(for_cards),
            ..ContextOptions::default()
        }) else {
            return;
        };
        if for_cards && !ctx.info().has_card_forms {
            assert!(
                std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some(),
                "the device cannot run the forms for graphics cards"
            );
            eprintln!("skipped: the device cannot run the forms for graphics cards");
            continue;
        }
        let append = Pipeline::<Append>::new(&ctx, &()).unwrap();
        let factors = Buffer::from_slice(&ctx, "factors", &[7_u32]).unwrap();
        let factors = Texels::<u32>::new(&factors, 1).unwrap();
        let mut frames = Frames::new(&ctx, 1).unwrap();
        for count in [1_u32, 7, 8, 63, 64, 65, 100_003] {
            let counts = Buffer::<u32>::zeroed(&ctx, "counts", 5).unwrap();
            let listed = Buffer::<u32>::zeroed(&ctx, "listed", 5 * count as usize).unwrap();
            let mut rec = frames.begin().unwrap();
            let args = AppendArgs {
                factors: &factors,
                counts: &counts,
                listed: &listed,
            };
            rec.dispatch(&append, Threads(count), args, AppendParams { count });
            frames.submit(rec).unwrap();
            let (counts, listed) = (
                ctx.download(&counts).unwrap(),
                ctx.download(&listed).unwrap(),
            );
            for (number, list) in (0..).zip(listed.chunks(count as usize)) {
                let is_listed = |i: &u32| match number {
                    0 | 1 => !i.is_multiple_of(7) && i % 2 == number,
                    _ => i / 16 % 3 == number - 2,
                };
                let expected: Vec<u32> = (0..count).filter(is_listed).collect();
                let mut found = list[..counts[number as usize] as usize].to_vec();
                found.sort_unstable();
                assert_eq!(found, expected, "{count} numbers, for cards: {for_cards}");
            }
        }
        assert_silent(&ctx);
    }
}

#[test]
fn texel_buffers_are_read() {
    let Some(ctx) = context() else { return };
    let gather = Pipeline::<Gather>::new(&ctx, &()).unwrap();
    let table: Vec<f32> = (0..12).map(|i| i as f32).collect();
    let table = Buffer::from_slice(&ctx, "table", &table).unwrap();
    let pairs = Buffer::from_slice(&ctx, "pairs", &[[0_u32, 2], [1, 1]]).unwrap();
    let sums = Buffer::zeroed(&ctx, "sums", 2).unwrap();
    let (table_texels, pair_texels) = (
        Texels::<f32>::new(&table, 4).unwrap(),
        Texels::<u32>::new(&pairs, 2).unwrap(),
    );
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    let args = GatherArgs {
        table: &table_texels,
        pairs: &pair_texels,
        sums: &sums,
    };
    rec.dispatch(&gather, Threads(2), args, GatherParams { count: 2 });
    frames.submit(rec).unwrap();
    // Dropped while the frame may still run.
    drop((table_texels, pair_texels, table, pairs));
    let found = ctx.download(&sums).unwrap();
    assert_eq!(
        found,
        [
            glam::Vec4::new(8.0, 10.0, 12.0, 14.0),
            glam::Vec4::new(8.0, 10.0, 12.0, 14.0)
        ]
    );
    assert_silent(&ctx);
}

#[test]
fn groups_take_two_dimensions_only_when_they_must() {
    assert_eq!(Threads(0).groups(64, 65_535), None);
    assert_eq!(Threads(1).groups(64, 65_535), Some([1, 1]));
    assert_eq!(Threads(65_535 * 64).groups(64, 65_535), Some([65_535, 1]));
    assert_eq!(
        Threads(65_535 * 64 + 1).groups(64, 65_535),
        Some([32_768, 2])
    );
    let [x, y] = Threads(u32::MAX).groups(64, 65_535).unwrap();
    assert!(u64::from(x) * u64::from(y) * 64 >= u64::from(u32::MAX) && x <= 65_535 && y <= 65_535);
}
