//! Pictures have what they should have where they should have it, and look the same every time.

use crate::common::{Gpu, gpu, scene};
use glam::{Vec2, Vec3};
use image::{Rgba, RgbaImage};
use myxo::gpu::{Context, DeviceKind, Frames, Recorder};
use myxo::mesh::surface::NONE;
use myxo::render::colormap::{linear_from_srgb, srgb_from_linear};
use myxo::render::exposure::Exposure;
use myxo::render::mean::Mean;
use myxo::render::{Offscreen, Renderer, View, offscreen, pick};
use myxo::scene::Scene;
use myxo::scene::settings::{ColorMap, Settings, Show};
use myxo::sim::{Setup, Simulation, twin};
use std::sync::Arc;

const SIZE: [u32; 2] = [160, 120];

fn size() -> Vec2 {
    Vec2::new(SIZE[0] as f32, SIZE[1] as f32)
}

/// A scene on the device, and a view of it from the front with a fixed exposure.
pub struct Stage {
    pub scene: Scene,
    pub simulation: Simulation,
    pub renderer: Renderer,
    pub canvas: Offscreen,
    pub view: View,
}

impl Stage {
    pub fn new(gpu: &Gpu, mesh: &str, change: impl FnOnce(&mut Settings)) -> Self {
        let scene = scene(mesh, |settings| {
            settings.camera.azimuth = 0.0;
            settings.camera.elevation = 0.0;
            change(settings);
        });
        let simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut view = View::of(&scene, size());
        view.exposure = Exposure::Fixed(1.0);
        bare(&mut view);
        Self {
            renderer: Renderer::new(&gpu.ctx, simulation.setup(), offscreen::FORMAT).unwrap(),
            canvas: Offscreen::new(&gpu.ctx, SIZE).unwrap(),
            scene,
            simulation,
            view,
        }
    }

    fn setup(&self) -> &Setup {
        self.simulation.setup()
    }

    /// Uploads a trail: `value_at` a place in object space, gutters filled.
    pub fn set_trail(&mut self, ctx: &Arc<Context>, value_at: impl Fn(Vec3) -> f32) {
        let setup = self.setup();
        let atlas = &setup.atlas;
        let mut trail = vec![0.0; atlas.texel_count()];
        for texel in 0..trail.len() as u32 {
            if let Some((triangle, u, v)) = atlas.surface_point_of(texel) {
                trail[texel as usize] = value_at(place(setup, triangle, u, v));
            }
        }
        twin::exchange_seams(&atlas.seams, &mut trail);
        ctx.upload(&self.simulation.state().trail.front, &trail)
            .unwrap();
    }

    /// The surface point that a pixel shows.
    pub fn hit(&self, pixel: Vec2) -> pick::Hit {
        let ray = self.view.camera.ray(pixel, size());
        let poses = self.scene.world_from_object();
        pick::pick(&self.setup().surface, &poses, &ray).expect("an object is there")
    }

    pub fn picture(&mut self, gpu: &Gpu) -> RgbaImage {
        gpu.run(|rec| {
            self.renderer.draw(
                rec,
                self.simulation.state(),
                &self.view,
                self.canvas.canvas(),
            );
            self.canvas.record_readback(rec);
        });
        self.canvas.image()
    }
}

/// A view without what makes pictures beautiful: tests of places and colours need what is drawn and nothing on top.
pub fn bare(view: &mut View) {
    view.bloom = 0.0;
    view.wetness = 0.0;
    view.shows_ground = false;
}

fn place(setup: &Setup, triangle: u32, u: f32, v: f32) -> Vec3 {
    let [a, b, c] = setup.surface.corners[triangle as usize]
        .map(|vertex| setup.surface.positions[vertex as usize]);
    a + u * (b - a) + v * (c - a)
}

/// How bright a pixel is: the sum of its channels.
pub fn brightness(pixel: &Rgba<u8>) -> f32 {
    pixel.0[..3].iter().map(|&channel| f32::from(channel)).sum()
}

/// The mean place of what is brighter than `least`, pixel centres at + 0.5.
fn bright_spot(picture: &RgbaImage, least: f32) -> Vec2 {
    let (mut sum, mut weight) = (Vec2::ZERO, 0.0);
    for (x, y, pixel) in picture.enumerate_pixels() {
        let light = (brightness(pixel) - least).max(0.0);
        sum += light * (Vec2::new(x as f32, y as f32) + 0.5);
        weight += light;
    }
    assert!(weight > 0.0, "nothing is bright");
    sum / weight
}

#[test]
fn a_spot_of_trail_is_where_the_camera_says() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:torus?major=48&minor=24", |settings| {
        settings.atlas.size = 512;
    });
    stage.view.color_map = ColorMap::Grayscale;
    for pixel in [
        Vec2::new(120.0, 55.0),
        Vec2::new(30.0, 66.0),
        Vec2::new(84.0, 72.0),
    ] {
        let hit = stage.hit(pixel);
        stage.set_trail(&gpu.ctx, |at| {
            if at.distance(hit.position) < 0.07 {
                5.0
            } else {
                0.0
            }
        });
        let spot = bright_spot(&stage.picture(&gpu), 500.0);
        assert!(spot.distance(pixel) < 1.5, "{spot}, expected {pixel}");
    }
    gpu.finish();
}

#[test]
fn trail_runs_on_over_every_edge() {
    let Some(gpu) = gpu() else { return };
    // Meshes whose neighbours lie anywhere in the atlas; the field is smooth in space.
    for mesh in [
        "builtin:icosphere?subdivisions=3",
        "builtin:torus?major=40&minor=20",
    ] {
        let mut stage = Stage::new(&gpu, mesh, |settings| settings.atlas.size = 512);
        stage.view.color_map = ColorMap::Grayscale;
        stage.set_trail(&gpu.ctx, |at| 0.4 + 0.2 * (2.0 * at.x).sin() + 0.1 * at.y);
        let smooth = stage.picture(&gpu);
        // A picture without trail on a bright background shows which pixels lie inside of the object by two pixels.
        stage.set_trail(&gpu.ctx, |_| 0.0);
        stage.view.background = Vec3::ONE;
        let bare = stage.picture(&gpu);
        let is_inside = |x: u32, y: u32| {
            (y - 2..=y + 2)
                .flat_map(|y| (x - 2..=x + 2).map(move |x| (x, y)))
                .all(|(x, y)| brightness(bare.get_pixel(x, y)) < 250.0)
        };
        let mut compared = 0;
        for y in 2..SIZE[1] - 2 {
            for x in (2..SIZE[0] - 2).filter(|&x| is_inside(x, y)) {
                // Neighbouring pixels differ little: there are no cracks and no leaks.
                let middle = brightness(smooth.get_pixel(x, y));
                let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)]
                    .map(|(x, y)| brightness(smooth.get_pixel(x, y)));
                let bend = (middle - around.iter().sum::<f32>() / 4.0).abs();
                assert!(
                    bend < 12.0,
                    "{mesh}: ({x}, {y}) is {middle} among {around:?}"
                );
                compared += 1;
            }
        }
        assert!(
            compared > 2000,
            "{mesh}: only {compared} pixels were compared"
        );
    }
    gpu.finish();
}

#[test]
fn a_bright_sphere_hides_all_of_the_background() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere?subdivisions=4", |settings| {
        settings.atlas.size = 512
    });
    stage.view.background = Vec3::new(1.0, 0.0, 1.0);
    stage.set_trail(&gpu.ctx, |_| 5.0);
    let picture = stage.picture(&gpu);
    let at = |place: Vec3| stage.view.camera.pixel(place, size()).unwrap();
    let middle = at(Vec3::ZERO);
    let radius = at(Vec3::Y * 0.97).distance(middle);
    for (x, y, pixel) in picture.enumerate_pixels() {
        let from_middle = (Vec2::new(x as f32, y as f32) + 0.5).distance(middle);
        let Rgba([red, green, blue, alpha]) = *pixel;
        assert_eq!(alpha, 255);
        if from_middle < radius - 2.0 {
            assert!(green > 90, "({x}, {y}) is ({red}, {green}, {blue})");
        } else if from_middle > 1.12 * radius {
            assert!(
                green < 12 && red > 60 && red.abs_diff(blue) < 3,
                "({x}, {y}) is ({red}, {green}, {blue})"
            );
        }
    }
    gpu.finish();
}

#[test]
fn edges_are_smooth_where_the_device_can_multisample() {
    let Some(gpu) = gpu() else { return };
    if gpu.ctx.info().max_samples < 4 {
        assert_ne!(gpu.ctx.info().kind, DeviceKind::Cpu, "a CPU can");
        return eprintln!("skipped: the device cannot multisample");
    }
    let mut stage = Stage::new(&gpu, "builtin:icosphere?subdivisions=4", |settings| {
        settings.atlas.size = 512
    });
    stage.view.background = Vec3::ZERO;
    stage.view.color_map = ColorMap::Grayscale;
    stage.set_trail(&gpu.ctx, |_| 5.0);
    let picture = stage.picture(&gpu);
    // Of the first pixel in each row that shows anything, many are neither black nor as bright as the next two.
    let mut rows = 0;
    let mut soft = 0;
    for y in 0..SIZE[1] {
        let row: Vec<f32> = (0..SIZE[0])
            .map(|x| brightness(picture.get_pixel(x, y)))
            .collect();
        if let Some(first) = row.iter().position(|&light| light > 20.0) {
            rows += 1;
            soft += u32::from(row[first] < 0.85 * row[(first + 2).min(row.len() - 1)]);
        }
    }
    assert!(
        rows > 60 && 2 * soft > rows,
        "{soft} soft edges in {rows} rows"
    );
    gpu.finish();
}

#[test]
fn colours_are_encoded_once() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:plane?columns=2&rows=2", |settings| {
        settings.atlas.size = 64
    });
    stage.view.show = Show::Atlas;
    // Well inside of the first triangle.
    stage.view.atlas.zoom = 8.0;
    stage.view.atlas.middle = stage.setup().atlas.position_of(0, 0.3, 0.3) / 64.0;
    for (map, darkest) in [
        (ColorMap::Viridis, 0.0),
        (ColorMap::Grayscale, 0.0),
        // Equal colours, from another darkest value.
        (ColorMap::Grayscale, 0.3),
        (ColorMap::Inferno, 0.7),
    ] {
        stage.view.color_map = map;
        stage.view.darkest = darkest;
        for value in [0.15, 0.5, 1.0, 7.0] {
            stage.set_trail(&gpu.ctx, |_| value);
            let picture = stage.picture(&gpu);
            // As `tone` in colormap.glsl: 0.45 is the shoulder.
            let tone = |value: f32| (1.45 * value / (value + 0.45)).min(1.0);
            let shown = (tone(value) - tone(darkest)) / (1.0 - tone(darkest));
            let shown = shown.max(0.0);
            // On the bare material, which ever less of shows.
            let light = map.color(shown) + (1.0 - shown) * Vec3::new(0.014, 0.015, 0.017);
            let expected = light
                .to_array()
                .map(|linear| 255.0 * srgb_from_linear(linear));
            let pixel = picture.get_pixel(SIZE[0] / 2, SIZE[1] / 2);
            for channel in 0..3 {
                let off = (f32::from(pixel.0[channel]) - expected[channel]).abs();
                assert!(
                    off <= 1.5,
                    "{map:?} from {darkest} at {value}: {pixel:?}, expected {expected:?}"
                );
            }
        }
    }
    gpu.finish();
}

#[test]
fn the_background_has_the_colour_it_was_given() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere?subdivisions=1", |settings| {
        settings.camera.distance = 20.0
    });
    let color = Vec3::new(0.3, 0.5, 0.7);
    stage.view.background = color;
    let picture = stage.picture(&gpu);
    for (x, y) in [(0, 0), (159, 0), (0, 119), (30, 60), (80, 10)] {
        // The gradient of background.frag.
        let at = (Vec2::new(x as f32, y as f32) + 0.5) / size();
        let from_middle = (at - Vec2::new(0.5, 0.46)) * Vec2::new(size().x / size().y, 1.0);
        let gradient =
            (1.12 - 0.4 * at.y) * (0.5 + 1.5 * (-2.2 * from_middle.length_squared()).exp());
        let pixel = picture.get_pixel(x, y);
        for (channel, light) in stage
            .view
            .background_light()
            .to_array()
            .into_iter()
            .enumerate()
        {
            let expected = 255.0 * srgb_from_linear(light * gradient);
            let off = (f32::from(pixel.0[channel]) - expected).abs();
            assert!(
                off < 2.5,
                "({x}, {y}) is {pixel:?}, channel {channel} should be {expected}"
            );
        }
    }
    gpu.finish();
}

#[test]
fn the_light_comes_from_above_and_from_the_left() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere?subdivisions=4", |settings| {
        settings.atlas.size = 512
    });
    stage.view.color_map = ColorMap::Grayscale;
    stage.set_trail(&gpu.ctx, |_| 0.3);
    let first = stage.picture(&gpu);
    let at = |x: f32, y: f32| {
        let pixel = 0.5 * size() + 0.3 * size().y * Vec2::new(x, y);
        brightness(first.get_pixel(pixel.x as u32, pixel.y as u32))
    };
    let (above, below) = (at(0.0, -1.0), at(0.0, 1.0));
    let (left, right) = (at(-1.0, 0.0), at(1.0, 0.0));
    assert!(
        above > below + 30.0 && left > right + 15.0,
        "{above} {below} {left} {right}"
    );
    // And what faces the eye is lit.
    assert!(at(0.0, 0.0) > 250.0, "{}", at(0.0, 0.0));

    // The light moves with the camera: a sphere looks the same from everywhere, at the same height.
    for turn in [1.0, 2.0, 3.0, 4.0, 5.0] {
        stage.view.camera.yaw = turn;
        let turned = stage.picture(&gpu);
        for (x, y, pixel) in turned.enumerate_pixels() {
            let from_middle = (Vec2::new(x as f32, y as f32) + 0.5).distance(0.5 * size());
            if from_middle < 0.35 * size().y {
                let (now, before) = (brightness(pixel), brightness(first.get_pixel(x, y)));
                assert!(
                    (now - before).abs() < 15.0,
                    "({x}, {y}) is {now} after a turn by {turn}, {before} before"
                );
            }
        }
    }
    gpu.finish();
}

#[test]
fn pictures_are_the_same_every_time() {
    let Some(gpu) = gpu() else { return };
    let all = Show::ALL.iter().map(|show| (show, u32::MAX));
    // Of some particles only, those of the same ids.
    for (show, most_particles) in all.chain([(&Show::Particles, 700), (&Show::Headings, 700)]) {
        let picture = || {
            let mut stage = Stage::new(&gpu, "builtin:torus?major=24&minor=12", |_| {});
            stage.view.show = *show;
            stage.view.most_particles = most_particles;
            stage.view.exposure = Exposure::default();
            for _ in 0..4 {
                gpu.run(|rec| stage.simulation.record_step(rec));
            }
            stage.picture(&gpu)
        };
        let (first, second) = (picture(), picture());
        assert!(first == second, "{show:?} differs");
        let colors: std::collections::HashSet<_> = first.pixels().collect();
        assert!(
            colors.len() > 50,
            "{show:?} has only {} colours",
            colors.len()
        );
    }
    gpu.finish();
}

/// Would catch: colours, a shadow, an exposure or sums of a mean that are taken to be on the device, though the recording that was to bring
/// them there was dropped.
#[test]
fn pictures_after_a_recording_that_was_dropped_are_as_without_it() {
    let Some(gpu) = gpu() else { return };
    let picture = |is_dropped: bool| {
        let mut stage = Stage::new(&gpu, "builtin:torus?major=24&minor=12", |_| {});
        stage.set_trail(&gpu.ctx, |place| place.x.max(0.0));
        stage.view.exposure = Exposure::default();
        stage.view.shows_ground = true;
        let mut mean = Mean::new(&gpu.ctx, SIZE).unwrap();
        let mut draw = |rec: &mut Recorder| {
            let canvas = stage.canvas.canvas();
            let state = stage.simulation.state();
            stage.renderer.draw(rec, state, &stage.view, canvas);
            mean.record(rec, canvas.image());
            stage.canvas.record_readback(rec);
        };
        if is_dropped {
            let mut frames = Frames::new(&gpu.ctx, 1).unwrap();
            draw(&mut frames.begin().unwrap());
        }
        (0..2).for_each(|_| gpu.run(&mut draw));
        assert_eq!(mean.count(), 2);
        stage.canvas.image()
    };
    assert!(picture(true) == picture(false));
    gpu.finish();
}

/// Would catch: points of dead particles. The two pictures are as bright, because both have few points.
#[test]
fn dead_particles_are_not_drawn() {
    let Some(gpu) = gpu() else { return };
    let picture = |count: u32, frequency: u32| {
        let mut stage = Stage::new(&gpu, "builtin:torus?major=24&minor=12", |settings| {
            settings.particles.count = count;
            settings.population.frequency = frequency;
            settings.population.capacity = 60;
        });
        stage.view.show = Show::Particles;
        stage.view.particle_size = 2.0;
        stage.picture(&gpu)
    };
    let alone = picture(3, 0);
    assert!(picture(3, 10_000) == alone);
    assert!(picture(60, 10_000) != alone);
    gpu.finish();
}

#[test]
fn a_particle_is_drawn_where_it_is() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:torus?major=24&minor=12", |settings| {
        settings.particles.count = 3;
    });
    stage.view.show = Show::Particles;
    stage.view.particle_size = 5.0;
    stage.view.color_map = ColorMap::Grayscale;
    for pixel in [Vec2::new(120.5, 55.0), Vec2::new(40.0, 66.5)] {
        let hit = stage.hit(pixel);
        let mut particles = stage.setup().particles.clone();
        for particle in &mut particles {
            (particle.triangle, particle.u, particle.v) = (hit.triangle, hit.u, hit.v);
        }
        gpu.ctx
            .upload(&stage.simulation.state().particles, &particles)
            .unwrap();
        let spot = bright_spot(&stage.picture(&gpu), 520.0);
        assert!(spot.distance(pixel) < 0.8, "{spot}, expected {pixel}");
    }
    // A particle on the far side is hidden.
    let mut particles = stage.setup().particles.clone();
    for particle in &mut particles {
        particle.triangle = farthest_triangle(stage.setup(), stage.view.camera.eye());
    }
    gpu.ctx
        .upload(&stage.simulation.state().particles, &particles)
        .unwrap();
    let picture = stage.picture(&gpu);
    assert!(picture.pixels().all(|pixel| brightness(pixel) < 520.0));
    gpu.finish();
}

/// Would catch: points whose squares cover what is behind a picture without a background, and points that leave all of it uncovered.
#[test]
fn points_cover_as_much_as_they_are_light() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:torus?major=24&minor=12", |settings| {
        settings.particles.count = 400;
    });
    stage.view.is_transparent = true;
    stage.view.bloom = 0.0;
    stage.view.particle_size = 9.0;
    let surface = stage.picture(&gpu);
    for show in [Show::Particles, Show::Headings] {
        stage.view.show = show;
        let picture = stage.picture(&gpu);
        let mut beside = 0;
        for (pixel, surface) in picture.pixels().zip(surface.pixels()) {
            let [r, g, b, alpha] = pixel.0;
            if surface.0[3] > 0 || [r, g, b, alpha] == [0; 4] {
                continue;
            }
            beside += 1;
            let alpha = f32::from(alpha);
            let light = 255.0 * linear_from_srgb(f32::from(r.max(g).max(b)) / 255.0);
            // Each of the points that lie on each other is rounded to bytes, and between hues no channel is as bright as all together.
            let darkest = if show == Show::Headings { 0.3 } else { 0.85 };
            assert!(
                darkest * alpha - 6.0 < light && light < 1.15 * alpha + 6.0,
                "{show:?}: {pixel:?}"
            );
        }
        assert!(beside > 100, "{show:?}: {beside} pixels beside the object");
    }
    gpu.finish();
}

fn farthest_triangle(setup: &Setup, eye: Vec3) -> u32 {
    let distance = |triangle: u32| place(setup, triangle, 0.3, 0.3).distance(eye);
    (0..setup.surface.corners.len() as u32)
        .max_by(|a, b| distance(*a).total_cmp(&distance(*b)))
        .unwrap()
}

#[test]
fn a_texel_is_shown_in_its_place_of_the_atlas() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere?subdivisions=2", |settings| {
        settings.atlas.size = 62
    });
    stage.view.show = Show::Atlas;
    stage.view.color_map = ColorMap::Grayscale;
    let (size_in_texels, pitch) = (stage.setup().atlas.size, stage.setup().atlas.pitch);
    assert_ne!(size_in_texels, pitch);
    let owned: Vec<u32> = (0..pitch * size_in_texels)
        .filter(|&texel| stage.setup().atlas.owner[texel as usize] != NONE)
        .collect();
    for texel in [
        owned[10],
        owned[owned.len() / 2 + 3],
        owned[owned.len() - 5],
    ] {
        let mut trail = vec![0.0; stage.setup().atlas.texel_count()];
        trail[texel as usize] = 9.0;
        gpu.ctx
            .upload(&stage.simulation.state().trail.front, &trail)
            .unwrap();
        let spot = bright_spot(&stage.picture(&gpu), 500.0);
        let window = stage.view.atlas;
        let centre = stage.setup().atlas.centre_of(texel);
        let expected = (centre - window.origin(size_in_texels, size()))
            / window.texels_per_pixel(size_in_texels, size());
        assert!(spot.distance(expected) < 0.6, "{spot}, expected {expected}");
    }
    gpu.finish();
}

#[test]
fn the_exposure_follows_the_trail() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::new(&gpu, "builtin:icosphere?subdivisions=2", |_| {});
    stage.view.exposure = Exposure::default();
    // A pattern looks alike at a thousand times the strength.
    let mut picture = |strength: f32| {
        stage.set_trail(&gpu.ctx, |at| strength * (at.x * 5.0).sin().abs());
        stage.picture(&gpu)
    };
    let (weak, strong) = (picture(0.0625), picture(64.0));
    for (a, b) in weak.pixels().zip(strong.pixels()) {
        assert!((0..4).all(|k| a.0[k].abs_diff(b.0[k]) <= 2), "{a:?} {b:?}");
    }
    gpu.finish();
}

#[test]
fn kernels_are_timed_right_between_pictures() {
    let Some(gpu) = gpu() else { return };
    if !gpu.ctx.info().has_timestamps() {
        assert_ne!(gpu.ctx.info().kind, DeviceKind::Cpu, "a CPU has them");
        return eprintln!("skipped: the device has no timestamps");
    }
    let mut stage = Stage::new(&gpu, "builtin:torus?major=48&minor=24", |settings| {
        settings.particles.count = 60_000;
    });
    let mut frames = Frames::new(&gpu.ctx, 1).unwrap();
    for _ in 0..6 {
        let mut rec = frames.begin().unwrap();
        rec.scope("step", |rec| stage.simulation.record_step(rec));
        stage.renderer.draw(
            &mut rec,
            stage.simulation.state(),
            &stage.view,
            stage.canvas.canvas(),
        );
        frames.submit(rec).unwrap();
    }
    frames.wait_idle().unwrap();
    let report = frames.timings().report("step");
    // Means, because some kernels are not in every step, and their medians are of those that have them.
    let kernels: f64 = report.rows.iter().map(|row| row.time.mean_ms).sum();
    let share = kernels / report.step.mean_ms;
    assert!(
        (0.7..=1.1).contains(&share),
        "kernels take {share} of the step"
    );
    gpu.finish();
}
