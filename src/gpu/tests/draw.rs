//! Drawing into images.

use super::selftest::*;
use super::*;

#[test]
fn a_picture_is_drawn_and_read_back() {
    let Some(ctx) = context() else { return };
    for samples in [1, 4] {
        let options = RasterOptions {
            samples,
            ..RasterOptions::default()
        };
        let pipeline = RasterPipeline::<DiscDraw>::new(&ctx, &(), options).unwrap();
        let size = [37, 21];
        let color = Image::new(&ctx, "color", size, Format::Rgba8Srgb, samples).unwrap();
        let resolve =
            (samples > 1).then(|| Image::new(&ctx, "resolve", size, Format::Rgba8Srgb, 1).unwrap());
        let depth = Image::new(&ctx, "depth", size, Format::Depth32, samples).unwrap();
        // Covers the left half of the row in the middle.
        let centres = Buffer::from_slice(&ctx, "centres", &[glam::Vec2::new(-4.0, 0.0)]).unwrap();
        let mut pixels =
            Buffer::<[u8; 4]>::new(&ctx, "pixels", 37 * 21 + 1, Domain::Readback).unwrap();
        pixels.as_mut_slice()[37 * 21] = [9; 4];
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let mut rec = frames.begin().unwrap();
        let clear = Some([0.0, 0.0, 1.0, 1.0]);
        let targets = Targets {
            color: &color,
            resolve: resolve.as_ref(),
            depth: Some(&depth),
            depth_test: DepthTest::Greatest,
            clear,
        };
        rec.pass("picture", &targets, |pass| {
            let params = DiscParams {
                color: glam::Vec4::new(1.0, 0.215_86, 0.0, 1.0),
                size: 4.0,
            };
            pass.draw(&pipeline, 3, 1, DiscArgs { centres: &centres }, params);
        });
        rec.copy_image(resolve.as_ref().unwrap_or(&color), &pixels);
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        let pixels = pixels.as_slice();
        assert_eq!(
            pixels[10 * 37],
            [255, 128, 0, 255],
            "left, {samples} samples"
        );
        assert_eq!(
            pixels[10 * 37 + 36],
            [0, 0, 255, 255],
            "right, {samples} samples"
        );
        assert_eq!(pixels[37 * 21], [9; 4], "past the end");
        let frame = frames.timings().frames().next().unwrap();
        let names: Vec<_> = frame.iter().map(|s| (s.name.as_str(), s.kind)).collect();
        let expected = [
            ("frame", SpanKind::Frame),
            ("picture", SpanKind::Scope),
            ("disc", SpanKind::Draw),
            ("copy_image", SpanKind::Copy),
        ];
        assert_eq!(names, expected);
    }
    assert_silent(&ctx);
}

#[test]
fn depth_and_blending_do_what_they_say() {
    let Some(ctx) = context() else { return };
    let color = Image::new(&ctx, "color", [8, 8], Format::Rgba32Float, 1).unwrap();
    let add = RasterOptions {
        color: Format::Rgba32Float,
        depth: false,
        blend: Blend::Add,
        ..RasterOptions::default()
    };
    let add = RasterPipeline::<DiscDraw>::new(&ctx, &(), add).unwrap();
    let centres = Buffer::from_slice(&ctx, "centres", &[glam::Vec2::ZERO; 3]).unwrap();
    let pixels = Buffer::<[f32; 4]>::new(&ctx, "pixels", 64, Domain::Readback).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    let params = DiscParams {
        color: glam::Vec4::new(1.0, 2.0, 0.0, 0.5),
        size: 9.0,
    };
    let mut targets = Targets {
        color: &color,
        resolve: None,
        depth: None,
        depth_test: DepthTest::Greatest,
        clear: Some([1.0, 0.0, 0.0, 0.0]),
    };
    rec.pass("first", &targets, |pass| {
        pass.draw(&add, 3, 3, DiscArgs { centres: &centres }, params)
    });
    // A second pass keeps what the first drew.
    targets.clear = None;
    rec.pass("second", &targets, |pass| {
        pass.draw(&add, 3, 1, DiscArgs { centres: &centres }, params)
    });
    rec.copy_image(&color, &pixels);
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    assert_eq!(pixels.as_slice()[0], [5.0, 8.0, 0.0, 2.0]);
    assert_silent(&ctx);
}

#[test]
fn of_equal_depths_one_stays_as_the_test_says() {
    let Some(ctx) = context() else { return };
    let color = Image::new(&ctx, "color", [8, 8], Format::Rgba32Float, 1).unwrap();
    let depth = Image::new(&ctx, "depth", [8, 8], Format::Depth32, 1).unwrap();
    let centres = Buffer::from_slice(&ctx, "centres", &[glam::Vec2::ZERO]).unwrap();
    for (depth_test, stays) in [(DepthTest::Greatest, 2.0), (DepthTest::Smallest, 1.0)] {
        let options = RasterOptions {
            color: Format::Rgba32Float,
            depth_test,
            ..RasterOptions::default()
        };
        let pipeline = RasterPipeline::<DiscDraw>::new(&ctx, &(), options).unwrap();
        let pixels = Buffer::<[f32; 4]>::new(&ctx, "pixels", 64, Domain::Readback).unwrap();
        let mut frames = Frames::new(&ctx, 1).unwrap();
        let mut rec = frames.begin().unwrap();
        let targets = Targets {
            color: &color,
            resolve: None,
            depth: Some(&depth),
            depth_test,
            clear: Some([0.0; 4]),
        };
        rec.pass_as_kernel("discs", &targets, |pass| {
            for red in [1.0, 2.0] {
                let params = DiscParams {
                    color: glam::Vec4::new(red, 0.0, 0.0, 1.0),
                    size: 9.0,
                };
                pass.draw(&pipeline, 3, 1, DiscArgs { centres: &centres }, params);
            }
        });
        rec.copy_image(&color, &pixels);
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        assert_eq!(pixels.as_slice()[27][0], stays, "{depth_test:?}");
        let frame = frames.timings().frames().next().unwrap();
        let names: Vec<_> = frame.iter().map(|s| (s.name.as_str(), s.kind)).collect();
        let expected = [
            ("frame", SpanKind::Frame),
            ("discs", SpanKind::Kernel),
            ("copy_image", SpanKind::Copy),
        ];
        assert_eq!(names, expected, "the draws have no times of their own");
    }
    assert_silent(&ctx);
}

#[test]
fn pictures_are_copied_into_pictures_and_cut_at_the_edge() {
    let Some(ctx) = context() else { return };
    let small = Image::new(&ctx, "small", [4, 4], Format::Rgba8Srgb, 1).unwrap();
    let large = Image::new(&ctx, "large", [8, 8], Format::Rgba8, 1).unwrap();
    let pixels = Buffer::<[u8; 4]>::new(&ctx, "pixels", 64, Domain::Readback).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    let target = |color, red| Targets {
        color,
        resolve: None,
        depth: None,
        depth_test: DepthTest::Greatest,
        clear: Some([red, 0.0, 0.0, 1.0]),
    };
    rec.pass("small", &target(&small, 0.215_86), |_| ());
    rec.pass("large", &target(&large, 1.0), |_| ());
    rec.copy_image_to(&small, &large, [6, 1]);
    rec.copy_image_to(&small, &large, [8, 0]);
    rec.copy_image(&large, &pixels);
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    for (i, pixel) in pixels.as_slice().iter().enumerate() {
        let inside = i % 8 >= 6 && (1..5).contains(&(i / 8));
        assert_eq!(pixel[0], if inside { 128 } else { 255 }, "pixel {i}");
    }
    assert_silent(&ctx);
}

/// Would catch: a picture beside its middle, and columns that are left out where the place is wider.
#[test]
fn the_middle_of_a_picture_covers_a_place_of_another_size() {
    let Some(ctx) = context() else { return };
    let small = Image::new(&ctx, "small", [3, 4], Format::Rgba8, 1).unwrap();
    let large = Image::new(&ctx, "large", [8, 4], Format::Rgba8, 1).unwrap();
    let drawn: Vec<[u8; 4]> = (1..=12).map(|pixel| [pixel; 4]).collect();
    let drawn = Buffer::from_slice(&ctx, "drawn", &drawn).unwrap();
    let pixels = Buffer::<[u8; 4]>::new(&ctx, "pixels", 32, Domain::Readback).unwrap();
    let cleared = Targets {
        color: &large,
        resolve: None,
        depth: None,
        depth_test: DepthTest::Greatest,
        clear: Some([0.0; 4]),
    };
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut over = |place, size| {
        let mut rec = frames.begin().unwrap();
        rec.copy_to_image(&drawn, &small, 3);
        rec.pass("large", &cleared, |_| ());
        rec.copy_image_over(&small, &large, place, size);
        rec.copy_image(&large, &pixels);
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        let pixels: Vec<u8> = pixels.as_slice().iter().map(|pixel| pixel[0]).collect();
        pixels
    };
    let wider = [
        [0, 0, 0, 0, 0, 0, 0, 0],
        [0, 4, 4, 5, 6, 6, 6, 0],
        [0, 7, 7, 8, 9, 9, 9, 0],
        [0, 0, 0, 0, 0, 0, 0, 0],
    ];
    assert_eq!(over([1, 1], [6, 2]), wider.as_flattened());
    let narrower = [
        [0, 0, 0, 0, 0, 0, 2, 0],
        [0, 0, 0, 0, 0, 0, 5, 0],
        [0, 0, 0, 0, 0, 0, 8, 0],
        [0, 0, 0, 0, 0, 0, 11, 0],
    ];
    assert_eq!(over([6, 0], [1, 4]), narrower.as_flattened());
    let cut_off = [
        [0, 0, 0, 0, 0, 0, 1, 1],
        [0, 0, 0, 0, 0, 0, 4, 4],
        [0, 0, 0, 0, 0, 0, 7, 7],
        [0, 0, 0, 0, 0, 0, 10, 10],
    ];
    assert_eq!(over([6, 0], [9, 5]), cut_off.as_flattened());
    assert_silent(&ctx);
}

#[test]
fn what_a_draw_reads_is_made_visible_before_the_pass() {
    let Some(ctx) = context() else { return };
    let color = Image::new(&ctx, "color", [8, 8], Format::Rgba8Srgb, 1).unwrap();
    let options = RasterOptions {
        depth: false,
        ..RasterOptions::default()
    };
    let pipeline = RasterPipeline::<DiscDraw>::new(&ctx, &(), options).unwrap();
    let centres = Buffer::<glam::Vec2>::zeroed(&ctx, "centres", 1).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let mut rec = frames.begin().unwrap();
    rec.update(&centres, 0, &[glam::Vec2::ONE]);
    let targets = Targets {
        color: &color,
        resolve: None,
        depth: None,
        depth_test: DepthTest::Greatest,
        clear: Some([0.0; 4]),
    };
    let text = panic_text(|| {
        rec.pass("picture", &targets, |pass| {
            pass.draw(
                &pipeline,
                3,
                1,
                DiscArgs { centres: &centres },
                DiscParams::default(),
            );
        });
    });
    assert_eq!(
        text,
        "within a pass there are no barriers, and one is needed: centres: update wrote it (copy), disc reads it (draw); call \
         make_visible before the pass"
    );
    drop(rec);
    let mut rec = frames.begin().unwrap();
    rec.update(&centres, 0, &[glam::Vec2::ONE]);
    rec.make_visible(Access::Vertex, &[&centres]);
    rec.pass("picture", &targets, |pass| {
        let args = DiscArgs { centres: &centres };
        pass.draw(&pipeline, 3, 1, args, DiscParams::default());
    });
    // What comes next waits for the draw; the first barrier is for what was dropped.
    rec.update(&centres, 0, &[glam::Vec2::ZERO]);
    assert_eq!(rec.commands().barriers, 3);
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    assert_silent(&ctx);
}

#[test]
fn indices_say_which_vertices_are_drawn() {
    let Some(ctx) = context() else { return };
    let color = Image::new(&ctx, "color", [8, 8], Format::Rgba8Srgb, 1).unwrap();
    let options = RasterOptions {
        depth: false,
        ..RasterOptions::default()
    };
    let pipeline = RasterPipeline::<DiscDraw>::new(&ctx, &(), options).unwrap();
    let centres = Buffer::from_slice(&ctx, "centres", &[glam::Vec2::ZERO]).unwrap();
    let pixels = Buffer::<[u8; 4]>::new(&ctx, "pixels", 64, Domain::Readback).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let targets = Targets {
        color: &color,
        resolve: None,
        depth: None,
        depth_test: DepthTest::Greatest,
        clear: Some([0.0; 4]),
    };
    let draw = |rec: &mut Recorder, indices: &Buffer<u32>| {
        rec.pass("picture", &targets, |pass| {
            let args = DiscArgs { centres: &centres };
            let params = DiscParams {
                color: glam::Vec4::ONE,
                size: 1.0,
            };
            pass.draw_indexed(&pipeline, indices, args, params);
        });
    };
    // Four vertices are the corners of a square, 0 in the picture, 3 to the right of it and below: half a square each without
    // the one or the other.
    let mut covered = |indices: &[u32]| {
        let indices = Buffer::from_slice(&ctx, "indices", indices).unwrap();
        let mut rec = frames.begin().unwrap();
        draw(&mut rec, &indices);
        rec.copy_image(&color, &pixels);
        frames.submit(rec).unwrap();
        frames.wait_idle().unwrap();
        let pixels = pixels.as_slice();
        [(3, 3), (7, 7)].map(|(x, y)| pixels[8 * y + x][0] > 0)
    };
    assert_eq!(covered(&[0, 1, 2]), [true, false]);
    assert_eq!(covered(&[3, 2, 1]), [false, true]);
    assert_eq!(covered(&[3, 2, 1, 2, 0, 1]), [true, true]);
    assert_eq!(covered(&[0, 1, 1]), [false, false]);
    assert_eq!(covered(&[]), [false, false]);
    assert_silent(&ctx);

    let mut rec = frames.begin().unwrap();
    let indices = Buffer::<u32>::zeroed(&ctx, "indices", 3).unwrap();
    rec.update(&indices, 0, &[0, 1, 2]);
    let text = panic_text(|| draw(&mut rec, &indices));
    assert!(
        text.contains("indices: update wrote it (copy), disc reads it (index)"),
        "{text}"
    );
    let another = context().unwrap();
    let indices = Buffer::<u32>::zeroed(&another, "indices", 3).unwrap();
    let text = panic_text(|| draw(&mut rec, &indices));
    assert!(
        text.contains("`indices` belongs to another context"),
        "{text}"
    );
}

#[test]
fn images_that_the_device_cannot_have_are_errors() {
    let Some(ctx) = context() else { return };
    let side = ctx.info().max_image_side + 1;
    let error = Image::new(&ctx, "huge", [side, 1], Format::Rgba8, 1)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("\"huge\"") && error.contains(&ctx.info().max_image_side.to_string()),
        "{error}"
    );
    let error = Image::new(&ctx, "rich", [1, 1], Format::Rgba8, 64)
        .unwrap_err()
        .to_string();
    assert!(error.contains("64 samples"), "{error}");
    assert_silent(&ctx);
}

#[test]
fn equal_options_share_one_pipeline() {
    let Some(ctx) = context() else { return };
    let made = |samples, blend| {
        let options = RasterOptions {
            samples,
            blend,
            ..RasterOptions::default()
        };
        let pipeline = RasterPipeline::<DiscDraw>::new(&ctx, &(), options).unwrap();
        assert_eq!(*pipeline.options(), options);
        pipeline.core.handles()
    };
    let first = made(1, Blend::Opaque);
    assert_eq!(made(1, Blend::Opaque), first);
    assert_ne!(made(4, Blend::Opaque).pipeline, first.pipeline);
    assert_ne!(made(1, Blend::Alpha).pipeline, first.pipeline);
    let messages = ctx.end().expect("nothing else has the context");
    assert!(
        messages.is_empty(),
        "all are freed:\n{}",
        messages.join("\n")
    );
}

/// Would catch: an image that is taken for what a dropped recording would have made of it.
#[test]
fn images_are_as_they_were_before_a_recording_that_was_dropped() {
    let Some(ctx) = context() else { return };
    let color = Image::new(&ctx, "color", [8, 8], Format::Rgba8Srgb, 1).unwrap();
    let pixels = Buffer::<[u8; 4]>::new(&ctx, "pixels", 64, Domain::Readback).unwrap();
    let mut frames = Frames::new(&ctx, 1).unwrap();
    let clear = |rec: &mut Recorder, red: f32| {
        let targets = Targets {
            color: &color,
            resolve: None,
            depth: None,
            depth_test: DepthTest::Greatest,
            clear: Some([red, 0.0, 0.0, 1.0]),
        };
        rec.pass("picture", &targets, |_| ());
    };
    let mut rec = frames.begin().unwrap();
    clear(&mut rec, 1.0);
    frames.submit(rec).unwrap();
    let mut rec = frames.begin().unwrap();
    clear(&mut rec, 0.0);
    rec.copy_image(&color, &pixels);
    drop(rec);
    let mut rec = frames.begin().unwrap();
    rec.copy_image(&color, &pixels);
    frames.submit(rec).unwrap();
    frames.wait_idle().unwrap();
    assert!(*pixels.as_slice() == [[255, 0, 0, 255]; 64]);
    assert_silent(&ctx);
}
