//! Bloom, the film curve, the ground, smooth edges of quick pictures.

use crate::common::{gpu, gpu_within};
use crate::pictures::{Stage, brightness};
use glam::{Vec2, Vec3};
use image::{Rgba, RgbaImage};
use myxo::gpu::Limits;
use myxo::render::mean::Mean;
use myxo::render::{Offscreen, Quality, offscreen};
use myxo::scene::settings::{ColorMap, Show};
use myxo::sim::paint::{Brush, Dab};

/// The mean brightness of a row's pixels.
fn row(picture: &RgbaImage, y: u32) -> f32 {
    let pixels = (0..picture.width()).map(|x| brightness(picture.get_pixel(x, y)));
    pixels.sum::<f32>() / picture.width() as f32
}

/// The mean difference of two pictures, as a share of white.
fn difference(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let all = a.as_raw().iter().zip(b.as_raw());
    let sum: u64 = all.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / (255.0 * a.as_raw().len() as f64)
}

/// Would catch: bloom that stays inside objects, grows with nothing, or is there where it is off.
#[test]
fn bright_trail_shines_beyond_the_edge_of_its_object() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere", |settings| {
        settings.picture.show = Show::Glow;
    });
    stage.view.camera.distance *= 2.0;
    stage.set_trail(&gpu.ctx, |_| 1.0);
    let pictures = [0.0, 0.5, 1.0].map(|bloom| {
        stage.view.bloom = bloom;
        stage.picture(&gpu)
    });
    // Above the sphere, where it does not reach.
    let [without, half, whole] = pictures.each_ref().map(|picture| row(picture, 22));
    assert!(
        half > 1.2 * without + 2.0 && whole > half + 1.0,
        "{without}, {half}, {whole}"
    );
    // Dark trail does not bloom.
    stage.set_trail(&gpu.ctx, |_| 0.0);
    let dark = stage.picture(&gpu);
    stage.view.bloom = 0.0;
    assert!(difference(&dark, &stage.picture(&gpu)) < 1e-3);
    gpu.finish();
}

/// Would catch: bloom that is grey or dim beside objects in pictures without a background, and one that differs on objects.
#[test]
fn bloom_without_a_background_is_over_black_what_it_is_on_black() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere", |settings| {
        settings.picture.show = Show::Glow;
    });
    stage.view.camera.distance *= 2.0;
    stage.view.background = Vec3::ZERO;
    stage.set_trail(&gpu.ctx, |_| 1.0);
    stage.view.bloom = 1.0;
    let black = stage.picture(&gpu);
    stage.view.is_transparent = true;
    let mut clear = stage.picture(&gpu);
    offscreen::unmultiply(&mut clear);
    stage.view.bloom = 0.0;
    let object = stage.picture(&gpu);
    let (mut on_it, mut beside) = (0, 0);
    for ((clear, black), object) in clear.pixels().zip(black.pixels()).zip(object.pixels()) {
        let [colors @ .., alpha] = clear.0;
        match object.0[3] {
            255 => {
                on_it += 1;
                assert_eq!(clear, black, "on the object");
            }
            0 => {
                beside += u32::from((5..250).contains(&alpha));
                let share = f32::from(alpha) / 255.0;
                for (color, black) in colors.iter().zip(&black.0) {
                    let off = share * f32::from(*color) - f32::from(*black);
                    assert!(off.abs() < 8.0, "{clear:?} is {off} from {black}");
                }
            }
            // Its edge.
            _ => {}
        }
    }
    assert!(on_it > 500 && beside > 500, "{on_it}, {beside}");
    gpu.finish();
}

/// Would catch: light that is not a number and gets into the picture, or is not counted; and counts where there is none.
#[test]
fn light_that_is_not_a_number_is_counted_and_not_shown() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere", |_| {});
    stage.set_trail(&gpu.ctx, |_| 0.5);
    let sound = stage.picture(&gpu);
    let flaws = |stage: &Stage| gpu.ctx.download(stage.renderer.flaws()).unwrap()[0];
    assert_eq!(flaws(&stage), 0);
    let mut last = 0;
    for wrong in [f32::NAN, f32::INFINITY] {
        stage.set_trail(&gpu.ctx, |place| if place.y > 0.9 { wrong } else { 0.5 });
        let picture = stage.picture(&gpu);
        assert!(picture.pixels().all(|pixel| pixel.0[3] == 255));
        // Nothing bright has come, and most of the picture is as it was.
        for (a, b) in picture.pixels().zip(sound.pixels()) {
            assert!(brightness(a) <= brightness(b) + 60.0, "{a:?}, {b:?}");
        }
        assert!(difference(&picture, &sound) < 0.05);
        let now = flaws(&stage);
        assert!(now > last + 20, "{wrong}: {now} after {last}");
        last = now;
    }
    gpu.finish();
}

/// Would catch: a window that shows another picture than a still, and jagged edges in it.
#[test]
fn quick_pictures_look_like_smooth_ones() {
    let Some(gpu) = gpu() else { return };
    let size = [320, 200];
    let mut stage = Stage::new(&gpu, "builtin:torus", |settings| {
        settings.camera.elevation = 35.0
    });
    (
        stage.view.bloom,
        stage.view.wetness,
        stage.view.shows_ground,
    ) = (1.0, 0.7, true);
    stage.set_trail(&gpu.ctx, |p| {
        (0.5 + 0.5 * (9.0 * p.x).sin() * (9.0 * p.z).cos()).powi(4)
    });
    let of = Vec2::new(size[0] as f32, size[1] as f32);
    stage.view.camera = myxo::render::View::of(&stage.scene, of).camera;
    let [quick, smooth] = [Quality::Quick, Quality::Smooth].map(|quality| {
        stage.canvas = Offscreen::with_quality(&gpu.ctx, size, quality).unwrap();
        stage.picture(&gpu)
    });
    let apart = difference(&quick, &smooth);
    assert!(apart < 0.01, "{apart}");
    // The edge of the torus against the background: between both there are pixels that are neither.
    let middle: Vec<f32> = (0..size[0])
        .map(|x| brightness(quick.get_pixel(x, size[1] / 2)))
        .collect();
    assert!(middle.iter().any(|&pixel| pixel > 100.0), "{middle:?}");
    // The same without development is farther from it.
    stage.canvas = Offscreen::with_quality(&gpu.ctx, size, Quality::Quick).unwrap();
    stage.view.is_plain = true;
    let plain = stage.picture(&gpu);
    assert!(
        difference(&plain, &smooth) > 1.2 * apart,
        "{}",
        difference(&plain, &smooth)
    );
    gpu.finish();
}

/// Would catch: a ground without shadow, a shadow where nothing stands, and a ground that cannot be switched off.
#[test]
fn objects_cast_a_shadow_on_the_ground() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere", |settings| {
        settings.camera.elevation = 25.0;
    });
    stage.view.camera.distance *= 1.6;
    stage.view.shows_ground = true;
    let with = stage.picture(&gpu);
    assert!(with == stage.picture(&gpu), "the kept shadow is the same");
    stage.view.shows_ground = false;
    let without = stage.picture(&gpu);
    let lit = |picture: &RgbaImage, x: u32, y: u32| brightness(picture.get_pixel(x, y));
    // Just below the sphere, and beside it on the ground.
    let below = (60..118).map(|y| lit(&with, 80, y) - lit(&without, 80, y));
    assert!(below.fold(0.0, f32::min) < -12.0, "a shadow");
    let beside = [with.clone(), without.clone()].map(|picture| lit(&picture, 30, 108));
    assert!(
        beside[0] > beside[1] + 8.0,
        "light on the ground: {beside:?}"
    );
    // In a shifted picture the shadow moves with the sphere.
    let ground_of = |stage: &mut Stage| {
        [true, false].map(|is_seen| {
            stage.view.shows_ground = is_seen;
            stage.picture(&gpu)
        })
    };
    let here = ground_of(&mut stage);
    let unshifted = stage.view.camera.shift;
    stage.view.camera.shift += Vec2::new(2.0 * 12.0 / 160.0, 2.0 * 8.0 / 120.0);
    let there = ground_of(&mut stage);
    stage.view.camera.shift = unshifted;
    let darker = |[with, without]: &[RgbaImage; 2], x, y| lit(with, x, y) - lit(without, x, y);
    let places: Vec<(u32, u32)> = (60..112).map(|y| (40 + y % 70, y)).collect();
    let apart = |(right, down): (i32, i32)| {
        let each = places.iter().map(|&(x, y)| {
            let moved = (
                x.saturating_add_signed(right),
                y.saturating_add_signed(down),
            );
            (darker(&here, x, y) - darker(&there, moved.0, moved.1)).abs()
        });
        each.sum::<f32>() / places.len() as f32
    };
    // What is darker also depends on the gradient behind it, which stays.
    let right = apart((12, -8));
    for wrong in [(0, 0), (12, 0), (0, -8), (12, 8), (-12, -8)] {
        assert!(
            right < 0.7 * apart(wrong),
            "{right}, {wrong:?}: {}",
            apart(wrong)
        );
    }
    // Hidden objects cast none.
    stage.view.shows_ground = true;
    stage.renderer.hide(&[true]);
    let hidden = stage.picture(&gpu);
    let below = (90..118).map(|y| lit(&hidden, 80, y) - lit(&without, 80, y));
    assert!(below.fold(f32::INFINITY, f32::min) > -3.0, "no shadow");
    gpu.finish();
}

/// Would catch: a film curve that clips, turns bright colours into another hue at once, or is not monotonic.
#[test]
fn brighter_trail_is_never_darker_and_turns_white() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere", |settings| {
        settings.picture.show = Show::Glow;
    });
    let mut last = 0.0;
    let mut colors = Vec::new();
    for trail in [0.0, 0.2, 0.5, 1.0, 2.0, 8.0, 100.0] {
        stage.set_trail(&gpu.ctx, |_| trail);
        let picture = stage.picture(&gpu);
        let pixel = *picture.get_pixel(80, 60);
        assert!(brightness(&pixel) > last, "{trail}: {pixel:?} after {last}");
        last = brightness(&pixel);
        colors.push(pixel.0);
    }
    let whiteness = |[r, _, b, _]: [u8; 4]| f32::from(b) / f32::from(r);
    assert!(whiteness(colors[6]) > whiteness(colors[3]), "{colors:?}");
    gpu.finish();
}

/// Would catch: a second look without its colours, over all of the surface, or in a scene that has none.
#[test]
fn the_second_look_has_its_own_colours_where_it_is() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere", |settings| {
        settings.picture.show = Show::Glow;
        settings.picture.color_map = ColorMap::Ice;
        "spots".clone_into(&mut settings.second_look.preset);
    });
    stage.set_trail(&gpu.ctx, |_| 0.4);
    let before = stage.picture(&gpu);
    // A dab on the right half of what is seen.
    let hit = stage.hit(Vec2::new(105.0, 58.0));
    let dab = Dab {
        brush: Brush::Look { amount: 1.0 },
        center: hit.position,
        radius: 0.3 * stage.scene.radius,
        eye: None,
        ring: None,
        number: 0,
    };
    gpu.run(|rec| {
        stage.simulation.paint(rec, &dab).unwrap();
    });
    let after = stage.picture(&gpu);
    let green = |picture: &RgbaImage, x: u32| {
        let [r, g, b, _] = picture.get_pixel(x, 58).0;
        i32::from(g) - i32::from(r.max(b))
    };
    assert!(
        green(&before, 105) < 0 && green(&after, 105) > 5,
        "moss, not ice"
    );
    assert_eq!(
        before.get_pixel(60, 58),
        after.get_pixel(60, 58),
        "ice as it was"
    );

    // The same in the unwrapped texture: mossy where it was painted, and nowhere else.
    stage.view.show = Show::Atlas;
    let painted = stage.picture(&gpu);
    stage.view.second_colors = None;
    let plain = stage.picture(&gpu);
    let pairs = || plain.pixels().zip(painted.pixels());
    let is_green = |pixel: &Rgba<u8>| pixel.0[1] > pixel.0[0].max(pixel.0[2]) + 5;
    let changed = pairs().filter(|(plain, painted)| plain != painted).count();
    let greener = pairs().filter(|(plain, painted)| !is_green(plain) && is_green(painted));
    let greener = greener.count();
    assert!(greener > 20, "{greener}");
    assert!(changed < 4 * greener, "{changed}, and {greener} are green");
    assert!(5 * changed < plain.pixels().len(), "{changed}");
    gpu.finish();
}

/// Would catch: a device without buffers for so many pixels that draws nothing, and one that does not say so.
#[test]
fn a_device_without_room_draws_without_bloom_and_says_so() {
    let limits = Limits {
        texel_buffer_elements: 20_000,
        storage_buffer_range: 1 << 27,
    };
    let Some(gpu) = gpu_within(Some(limits)) else {
        return;
    };
    let mut stage = Stage::new(&gpu, "builtin:plane?columns=2&rows=2", |settings| {
        settings.atlas.size = 64
    });
    stage.view.bloom = 1.0;
    stage.set_trail(&gpu.ctx, |_| 0.5);
    let large = Offscreen::new(&gpu.ctx, [400, 300]).unwrap();
    let small = std::mem::replace(&mut stage.canvas, large);
    assert_eq!(small.canvas().warning(), None);
    let warning = stage.canvas.canvas().warning().expect("120,000 pixels");
    assert!(warning.contains("400 x 300"), "{warning}");
    let picture = stage.picture(&gpu);
    let brightest = picture.pixels().map(brightness).fold(0.0, f32::max);
    assert!(brightest > 100.0, "{brightest}");
    gpu.finish();
}

/// Would catch: a mean for which the sums have to fit into one binding, so that large pictures have none.
#[test]
fn means_need_no_binding_that_is_as_large_as_their_sums() {
    let limits = Limits {
        texel_buffer_elements: 100_000,
        storage_buffer_range: 500_000,
    };
    let Some(gpu) = gpu_within(Some(limits)) else {
        return;
    };
    assert!(Mean::new(&gpu.ctx, [300, 300]).is_ok(), "1.4 MB of sums");
    assert!(Mean::new(&gpu.ctx, [400, 300]).is_err(), "120,000 pixels");
    gpu.finish();
}

/// Would catch: pictures of one pixel, or of one row, that fail.
#[test]
fn the_smallest_pictures_are_drawn() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere", |_| {});
    stage.view.bloom = 1.0;
    for size in [[1, 1], [1, 9], [6, 1]] {
        for quality in [Quality::Quick, Quality::Smooth] {
            stage.canvas = Offscreen::with_quality(&gpu.ctx, size, quality).unwrap();
            let picture = stage.picture(&gpu);
            assert_eq!(picture.dimensions(), size.into());
            assert!(picture.pixels().all(|pixel| pixel.0[3] == 255));
        }
    }
    gpu.finish();
}
