//! Charts in pictures: the unwrapped atlas shows what the layout's own picture shows, and surfaces wear the colours.

use crate::common::{gpu, scene};
use glam::{Vec2, Vec3};
use myxo::mesh::surface::NONE;
use myxo::render::colormap::{linear_from_srgb, srgb_from_linear};
use myxo::render::exposure::Exposure;
use myxo::render::{Offscreen, Renderer, View, charts, offscreen, pick};
use myxo::scene::settings::{AtlasMethod, Settings, Show};
use myxo::sim::Simulation;

const SIZE: [u32; 2] = [240, 240];

fn size() -> Vec2 {
    Vec2::new(SIZE[0] as f32, SIZE[1] as f32)
}

fn with_charts(settings: &mut Settings) {
    settings.atlas.method = AtlasMethod::Charts;
    settings.atlas.size = 120;
    settings.camera.azimuth = 20.0;
    settings.picture.charts = 1.0;
}

fn seen(light: Vec3) -> [f32; 3] {
    light.to_array().map(|x| 255.0 * srgb_from_linear(x))
}

fn light(color: [u8; 3]) -> Vec3 {
    Vec3::from_array(color.map(|c| linear_from_srgb(f32::from(c) / 255.0)))
}

#[test]
fn the_atlas_view_shows_the_picture_of_the_layout() {
    let Some(gpu) = gpu() else { return };
    let scene = scene("builtin:cube?divisions=3", |settings| {
        with_charts(settings);
        settings.picture.show = Show::Atlas;
    });
    let simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let setup = simulation.setup();
    let expected = charts::picture(&setup.surface, &setup.atlas, 1);
    let mut renderer = Renderer::new(&gpu.ctx, setup, offscreen::FORMAT).unwrap();
    let canvas = Offscreen::new(&gpu.ctx, SIZE).unwrap();
    let mut view = View::of(&scene, size());
    crate::pictures::bare(&mut view);
    view.exposure = Exposure::Fixed(1.0);
    // A trail everywhere: charts alone hide it.
    let trail = vec![5.0; setup.atlas.texel_count()];
    gpu.ctx
        .upload(&simulation.state().trail.front, &trail)
        .unwrap();
    // Two pixels a texel.
    view.atlas.zoom = 2.0 * view.atlas.texels_per_pixel(setup.atlas.size, size());
    assert!((view.atlas.texels_per_pixel(setup.atlas.size, size()) - 0.5).abs() < 1e-4);
    let mut shoot = |view: &View| {
        gpu.run(|rec| {
            renderer.draw(rec, simulation.state(), view, canvas.canvas());
            canvas.record_readback(rec);
        });
        canvas.image()
    };
    let picture = shoot(&view);
    for (x, y, pixel) in expected.enumerate_pixels() {
        let shown = picture.get_pixel(2 * x + 1, 2 * y + 1);
        for channel in 0..3 {
            let off = pixel.0[channel].abs_diff(shown.0[channel]);
            assert!(off <= 1, "texel {x} {y}: {shown:?} and not {pixel:?}");
        }
    }

    // Half-way, the trail lies over the charts: where it is as bright as can be, it alone is seen.
    view.charts = 0.5;
    let picture = shoot(&view);
    let brightest = seen(view.color_map.color(1.0));
    let mut owned = 0;
    for (x, y, pixel) in expected.enumerate_pixels() {
        let shown = picture.get_pixel(2 * x + 1, 2 * y + 1);
        if setup.atlas.owner[(y * setup.atlas.pitch + x) as usize] == NONE {
            assert_eq!(
                shown.0[..3],
                pixel.0[..3],
                "texel {x} {y} is beside the charts"
            );
            continue;
        }
        owned += 1;
        for channel in 0..3 {
            let off = (f32::from(shown.0[channel]) - brightest[channel]).abs();
            assert!(off <= 1.5, "texel {x} {y}: {shown:?} and not {brightest:?}");
        }
    }
    assert!(owned > 3000);
    gpu.finish();
}

#[test]
fn surfaces_wear_the_colours_of_their_charts() {
    let Some(gpu) = gpu() else { return };
    let scene = scene("builtin:icosphere?subdivisions=3", with_charts);
    let simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
    let setup = simulation.setup();
    let (surface, atlas) = (&setup.surface, &setup.atlas);
    let colors = charts::chart_colors(surface, atlas);
    let mut renderer = Renderer::new(&gpu.ctx, setup, offscreen::FORMAT).unwrap();
    let canvas = Offscreen::new(&gpu.ctx, SIZE).unwrap();
    let mut view = View::of(&scene, size());
    crate::pictures::bare(&mut view);
    gpu.run(|rec| {
        renderer.draw(rec, simulation.state(), &view, canvas.canvas());
        canvas.record_readback(rec);
    });
    let picture = canvas.image();
    let poses = scene.world_from_object();
    let (mut inside, mut seams, mut worn) = (0, 0, std::collections::BTreeSet::new());
    for (x, y, pixel) in picture.enumerate_pixels() {
        let ray = view.camera.ray(Vec2::new(x as f32, y as f32) + 0.5, size());
        let Some(hit) = pick::pick(surface, &poses, &ray) else {
            continue;
        };
        // Places where the rim light, at grazing angles, or the highlight of the key light outshines the colours.
        let normal = hit.position.normalize();
        let to_eye = (view.camera.eye() - hit.position).normalize();
        let halfway = (view.light.direction(&view.camera) + to_eye).normalize();
        if normal.dot(to_eye) < 0.4 || normal.dot(halfway) > 0.97 {
            continue;
        }
        let shown = light([pixel.0[0], pixel.0[1], pixel.0[2]]);
        let weights = [hit.v, 1.0 - hit.u - hit.v, hit.u];
        let seam = (0..3).find(|&k| atlas.is_seam(surface, 3 * hit.triangle + k));
        match seam {
            // Half of a triangle away from its seam.
            None => {
                let chart = atlas.chart[hit.triangle as usize];
                let color = light(colors[chart as usize]);
                let alike = shown.normalize().dot(color.normalize());
                // Pixels at edges take a little from beside.
                let at_edge = weights.into_iter().any(|w| w < 0.15);
                assert!(at_edge || alike > 0.985, "{x} {y}: {pixel:?} for {color}");
                inside += 1;
                worn.insert(chart);
            }
            Some(k) if weights[k as usize] < 0.02 => {
                let gray = shown.normalize().dot(Vec3::ONE.normalize());
                assert!(gray > 0.97, "{x} {y}: {pixel:?} is on a seam");
                seams += 1;
            }
            Some(_) => {}
        }
    }
    assert!(
        inside > 5000 && seams > 10 && worn.len() >= 2,
        "{inside} {seams} {worn:?}"
    );
    gpu.finish();
}
