//! Choosing a device, its limits, its memory, and what is kept on disk.

use ash::vk;

use super::selftest::*;
use super::*;

#[test]
fn an_unknown_device_is_an_error_that_lists_the_devices() {
    let Some(ctx) = context() else { return };
    for asked in ["no such device", "999", ""] {
        let error = Context::new(&ContextOptions {
            device: Some(asked.to_owned()),
            ..ContextOptions::default()
        });
        let text = error.expect_err(asked).to_string();
        assert!(
            text.contains(&format!("{asked:?}")) && text.contains(&ctx.info().name),
            "{text}"
        );
    }
}

#[test]
fn a_device_is_chosen_by_index_or_by_part_of_its_name() {
    let Some(ctx) = context() else { return };
    let name = ctx.info().name.to_uppercase();
    for asked in [ctx.info().index.to_string(), name[..5].to_owned()] {
        let options = ContextOptions {
            device: Some(asked.clone()),
            ..ContextOptions::default()
        };
        assert_eq!(
            Context::new(&options).expect(&asked).info().name,
            ctx.info().name
        );
    }
    assert!(devices().unwrap().iter().any(|d| d.name == ctx.info().name));
}

#[test]
fn a_buffer_past_a_limit_is_an_error_that_says_what_fits() {
    let Some(ctx) = context() else { return };
    let limit = ctx.info().max_storage_buffer_range;
    let error =
        Buffer::<[f32; 4]>::new(&ctx, "trail.front", limit as usize / 16 + 1, Domain::Device)
            .unwrap_err();
    let text = error.to_string();
    for part in [
        "\"trail.front\"",
        "maxStorageBufferRange",
        &limit.to_string(),
        &(limit / 16).to_string(),
    ] {
        assert!(text.contains(part), "{part:?} is not in: {text}");
    }
    let error =
        Buffer::<[u32; 4]>::new(&ctx, "endless", usize::MAX / 2, Domain::Device).unwrap_err();
    assert!(matches!(error, GpuError::TooLarge { .. }), "{error}");
    let far = ctx.info().max_memory_allocation_size as usize / 4 + 1;
    let error = Buffer::<u32>::new(&ctx, "far", far, Domain::Upload).unwrap_err();
    assert!(
        error.to_string().contains("maxMemoryAllocationSize"),
        "{error}"
    );
    assert_silent(&ctx);
}

/// Of what outgrows a binding, whole groups of four words are bound.
#[test]
fn the_first_part_of_a_buffer_fits_a_binding() {
    let limits = Limits {
        storage_buffer_range: 1000,
        texel_buffer_elements: 4096,
    };
    let Some(ctx) = context_with(ContextOptions {
        limits: Some(limits),
        ..ContextOptions::default()
    }) else {
        return;
    };
    for (words, part) in [
        (4, vk::WHOLE_SIZE),
        (250, vk::WHOLE_SIZE),
        (252, 992),
        (4096, 992),
    ] {
        let buffer = Buffer::<u32>::new(&ctx, "texture", words, Domain::Texels).unwrap();
        assert_eq!(buffer.core().first_part(), part, "{words} words");
    }
}

#[test]
fn transfers_move_whole_ranges_and_nothing_else() {
    let Some(ctx) = context() else { return };
    // More than one chunk of staging memory.
    let count = (8 << 20) / 4 * 2 + 77;
    let buffer = Buffer::<u32>::zeroed(&ctx, "values", count).unwrap();
    let data: Vec<u32> = (0..count as u32 - 2)
        .map(|i| i.wrapping_mul(0x9e37_79b9))
        .collect();
    ctx.upload_at(&buffer, 1, &data).unwrap();
    let found = ctx.download(&buffer).unwrap();
    assert_eq!((found[0], found[count - 1]), (0, 0));
    assert!(found[1..count - 1] == data[..]);
    assert_eq!(ctx.download_range(&buffer, 5..7).unwrap(), data[4..6]);
    ctx.fill(&buffer, 3).unwrap();
    assert!(ctx.download(&buffer).unwrap().iter().all(|v| *v == 3));

    let empty = Buffer::<u32>::from_slice(&ctx, "empty", &[]).unwrap();
    assert!(empty.is_empty() && ctx.download(&empty).unwrap().is_empty());
    let text = panic_text(|| ctx.upload(&empty, &[1]).unwrap());
    assert_eq!(text, "`empty` has 0 elements: 1 from 0 on do not fit");
    assert_silent(&ctx);
}

#[test]
fn frames_copy_update_and_use_mapped_memory() {
    let Some(ctx) = context() else { return };
    let mut up = Buffer::<u32>::new(&ctx, "up", 4, Domain::Upload).unwrap();
    up.as_mut_slice().copy_from_slice(&[1, 2, 3, 4]);
    let values = Buffer::<u32>::zeroed(&ctx, "values", 6).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    rec.copy_range(&up, 1..3, &values, 2);
    rec.update(&values, 5, &[9]);
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    assert_eq!(up.as_slice()[..], [1, 2, 3, 4]);
    assert_eq!(ctx.download(&values).unwrap(), [0, 0, 2, 3, 0, 9]);
    assert_silent(&ctx);
}

#[test]
fn compiled_pipelines_are_kept_and_damage_is_survived() {
    let folder = tempfile::tempdir().unwrap();
    let options = ContextOptions {
        cache_folder: Some(folder.path().join("cache")),
        validation: true,
        ..Default::default()
    };
    for damage in [false, true, false] {
        let Some(ctx) = context_with(options.clone()) else {
            return;
        };
        Pipeline::<Scale>::new(&ctx, &ScaleConstants::default()).unwrap();
        assert_silent(&ctx);
        drop(ctx);
        let files: Vec<_> = std::fs::read_dir(folder.path().join("cache"))
            .unwrap()
            .map(|f| f.unwrap().path())
            .collect();
        assert_eq!(files.len(), 1, "{files:?}");
        assert!(files[0].to_string_lossy().contains("pipelines-"));
        if damage {
            std::fs::write(&files[0], b"MYXOPC01 and nonsense").unwrap();
        }
    }
}

#[test]
fn a_lost_device_ends_when_nothing_refers_to_it() {
    let Some(mut ctx) = context() else { return };
    let mut frames = Frames::new(&ctx, 2).unwrap();
    let bump = Pipeline::<Bump>::new(&ctx, &()).unwrap();
    let values = Buffer::<u32>::zeroed(&ctx, "values", 64).unwrap();
    let mut readback = Readback::<u32>::new(&ctx, "copies", 64, 2).unwrap();
    let record = |rec: &mut Recorder, readback: &mut Readback<u32>| {
        let params = BumpParams {
            count: 64,
            amount: 5,
        };
        rec.dispatch(&bump, Threads(64), BumpArgs { values: &values }, params);
        readback.record(rec, &values, 0);
    };
    let mut rec = frames.begin().unwrap();
    record(&mut rec, &mut readback);
    frames.submit(rec).unwrap();
    assert!(!ctx.is_lost());
    ctx.pretend_lost();
    assert!(ctx.is_lost());
    let is_loss = |error: GpuError| matches!(error, GpuError::DeviceLost { .. });
    assert!(frames.wait_idle().is_err_and(is_loss));
    assert!(ctx.upload(&values, &[1; 64]).is_err_and(is_loss));
    assert!(readback.poll().is_none(), "it never arrives");
    drop((frames, readback, bump));
    ctx = match ctx.end() {
        Err(held) => held,
        Ok(_) => panic!("the buffer has it"),
    };
    drop(values);
    match ctx.end() {
        Ok(messages) => assert_eq!(messages, [""; 0]),
        Err(_) => panic!("there is another reference"),
    }
}
