//! An exported model, read by our own importer and lit on the host, is the picture that the renderer draws of the scene.

use std::path::{Path, PathBuf};

use glam::{Affine3A, Vec2, Vec3};
use image::{Rgb, RgbImage};
use myxo::export::{Colors, ExportFile};
use myxo::mesh::Mesh;
use myxo::mesh::surface::Surface;
use myxo::render::colormap::{linear_from_srgb, srgb_from_linear};
use myxo::render::exposure::Exposure;
use myxo::render::normals::{CREASE_ANGLE, corner_normals};
use myxo::render::{Offscreen, Renderer, View, offscreen, pick};
use myxo::scene::settings::ColorMap;

use super::{Run, moving_trio, parts, texture_of};
use crate::common::{gpu, scene};

const SIZE: [u32; 2] = [200, 150];

// The light that pictures are lit by, from shaders/include/shading.glsl.

const KEY: Vec3 = Vec3::new(1.00, 0.89, 0.74);
const ABOVE: Vec3 = Vec3::new(0.27, 0.32, 0.40);
const BELOW: Vec3 = Vec3::new(0.085, 0.075, 0.068);
const RIM: Vec3 = Vec3::new(0.34, 0.50, 0.80);

fn diffuse_light(normal: Vec3, key_direction: Vec3) -> Vec3 {
    let key = ((normal.dot(key_direction) + 0.25) / 1.25).max(0.0);
    KEY * key * key + BELOW.lerp(ABOVE, 0.5 + 0.5 * normal.y)
}

fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn grazing_share(normal: Vec3, to_eye: Vec3) -> f32 {
    (1.0 - normal.dot(to_eye).clamp(0.0, 1.0)).powi(5)
}

/// Of a dry surface.
fn specular_light(normal: Vec3, to_eye: Vec3, key_direction: Vec3) -> Vec3 {
    let fresnel = 0.015 + 0.55 * grazing_share(normal, to_eye);
    let mirrored = 2.0 * normal.dot(to_eye) * normal - to_eye;
    let rim = Vec3::new(-key_direction.x, 0.55, -key_direction.z).normalize();
    let up = 0.5 + 0.5 * mirrored.y;
    let blurred = BELOW.lerp(ABOVE, up) + 0.5 * RIM * normal.dot(rim).max(0.0);
    let beside = mirrored.dot(key_direction);
    let softbox = smoothstep(0.78, 0.95, beside) * (0.55 + 0.45 * smoothstep(0.85, 1.0, beside));
    let strip = smoothstep(0.55, 0.90, mirrored.dot(rim));
    let room = 2.6 * softbox * KEY + 1.3 * strip * RIM + (0.25 * BELOW).lerp(0.8 * ABOVE, up * up);
    fresnel * blurred.lerp(room, 0.35)
}

fn film(light: Vec3) -> Vec3 {
    let most = light.max_element();
    let over = (most - 0.6).max(0.0) / 0.4;
    let pressed = if most > 0.6 {
        0.6 + 0.4 * over / (1.0 + over)
    } else {
        most
    };
    let white = 1.0 - 1.0 / (0.30 * (most - pressed).max(0.0) + 1.0);
    (light * (pressed / most.max(1e-6))).lerp(Vec3::splat(pressed), white)
}

/// A texture between its texels, as light.
fn sample(texture: &RgbImage, place: Vec2) -> Vec3 {
    let last = Vec2::new(texture.width() as f32, texture.height() as f32) - 1.0;
    let at = place * (last + 1.0) - 0.5;
    let low = at.floor();
    let light = |x: f32, y: f32| {
        let texel = Vec2::new(x, y).clamp(Vec2::ZERO, last);
        let Rgb(bytes) = texture.get_pixel(texel.x as u32, texel.y as u32);
        Vec3::from_array(bytes.map(|byte| linear_from_srgb(f32::from(byte) / 255.0)))
    };
    let f = at - low;
    let top = light(low.x, low.y).lerp(light(low.x + 1.0, low.y), f.x);
    let bottom = light(low.x, low.y + 1.0).lerp(light(low.x + 1.0, low.y + 1.0), f.x);
    top.lerp(bottom, f.y)
}

/// The model, read by our own importer and lit on the host: colours of pixels that it covers.
fn picture_of_model(glb: &Path, view: &View, key: Vec3) -> Vec<Option<Vec3>> {
    let (model, binary) = parts(&std::fs::read(glb).unwrap());
    let texture = texture_of(&model, &binary, false);
    let glowing = texture_of(&model, &binary, true);
    let material = model.materials().next().expect("there is a material");
    let glow = material.emissive_factor()[0];

    let mesh = Mesh::load(glb).unwrap();
    let uvs = mesh.uvs.clone().expect("it has texture coordinates");
    let surface = Surface::build(&[(&mesh, 1.0)]);
    let normals = corner_normals(&surface, CREASE_ANGLE);
    let size = Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    let shade = |(x, y)| {
        let ray = view.camera.ray(Vec2::new(x as f32, y as f32) + 0.5, size);
        let hit = pick::pick(&surface, &[Affine3A::IDENTITY], &ray)?;
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let t = hit.triangle as usize;
        let place: Vec2 = (0..3).map(|k| weights[k] * uvs[t][k]).sum();
        let normal: Vec3 = (0..3).map(|k| weights[k] * normals[3 * t + k]).sum();
        let to_eye = -ray.direction;
        let normal = normal.normalize() * if normal.dot(to_eye) < 0.0 { -1.0 } else { 1.0 };
        let base = sample(&texture, place);
        let under = 1.0 - 0.85 * grazing_share(normal, to_eye);
        Some(film(
            under * (base * diffuse_light(normal, key) + glow * sample(&glowing, place))
                + specular_light(normal, to_eye, key),
        ))
    };
    pixels.map(shade).collect()
}

fn save_for_looking(name: &str, picture: &image::RgbaImage) {
    if let Some(folder) = std::env::var_os("MYXO_TEST_PICTURES") {
        picture.save(Path::new(&folder).join(name)).unwrap();
    }
}

/// The scene as its renderer draws it, and the exported model as drawn by the few lines above: the same picture.
#[test]
fn a_model_looks_as_the_picture_of_its_scene() {
    let Some(gpu) = gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    // Texels about as large as pixels: where they are smaller, renderers mix them each in its own way.
    let still = scene("builtin:torus?major=36&minor=20", |settings| {
        settings.particles.count = 10_000;
        settings.atlas.size = 192;
        settings.picture.color_map = ColorMap::Viridis;
    });
    for (name, run) in [
        ("trio", moving_trio(&gpu)),
        ("torus", Run::of(&gpu, still, 60)),
    ] {
        let glb: PathBuf = folder.path().join(format!("{name}.glb"));
        let file = ExportFile::create(&glb).unwrap();
        file.write(&run.export(), Colors::Texture).unwrap();

        let size = Vec2::new(SIZE[0] as f32, SIZE[1] as f32);
        let mut view = View::of(&run.scene, size);
        view.exposure = Exposure::default();
        // Models have no bloom, and no water on them.
        (view.bloom, view.wetness) = (0.0, 0.0);
        let mut renderer =
            Renderer::new(&gpu.ctx, run.simulation.setup(), offscreen::FORMAT).unwrap();
        let canvas = Offscreen::new(&gpu.ctx, SIZE).unwrap();
        view.is_transparent = true;
        gpu.run(|rec| {
            renderer.draw(rec, run.simulation.state(), &view, canvas.canvas());
            canvas.record_readback(rec);
        });
        let mut picture = canvas.image();
        offscreen::unmultiply(&mut picture);
        save_for_looking(&format!("{name}_scene.png"), &picture);

        let camera = &view.camera;
        let key = -0.55 * camera.right() + 0.75 * camera.up() + 0.65 * camera.backward();
        let model = picture_of_model(&glb, &view, key.normalize());
        let drawn = image::RgbaImage::from_fn(SIZE[0], SIZE[1], |x, y| {
            match model[(y * SIZE[0] + x) as usize] {
                Some(light) => {
                    let [r, g, b] = light
                        .to_array()
                        .map(|light| (255.0 * srgb_from_linear(light)).round() as u8);
                    image::Rgba([r, g, b, 255])
                }
                None => image::Rgba([0; 4]),
            }
        });
        save_for_looking(&format!("{name}_model.png"), &drawn);

        let (mut covered, mut differences, mut other_shape) = (0, Vec::new(), 0);
        let (mut brightest, mut darkest) = (0, 255);
        for (scene, model) in picture.pixels().zip(drawn.pixels()) {
            let is_inside = [scene.0[3], model.0[3]];
            match is_inside {
                [255, 255] => {
                    covered += 1;
                    brightest = brightest.max(scene.0[0]);
                    darkest = darkest.min(scene.0[0]);
                    differences.push((0..3).map(|k| scene.0[k].abs_diff(model.0[k])).max());
                }
                [255, 0] | [0, 255] => other_shape += 1,
                _ => {}
            }
        }
        assert!(covered > 5000, "{name}: {covered} pixels");
        assert!(brightest > 200 && darkest < 60, "{name} has a picture");
        assert!(other_shape <= covered / 500, "{name}: {other_shape} pixels");
        let differences: Vec<u8> = differences.into_iter().flatten().collect();
        let sum: f64 = differences.iter().map(|&off| f64::from(off)).sum();
        let mean = sum / f64::from(covered);
        let mut sorted = differences;
        sorted.sort_unstable();
        let half = sorted[sorted.len() / 2];
        eprintln!("{name}: {mean:.1} of 255 on an average, half of all by {half} at the most");
        // A texture in another orientation is 80 off.
        assert!(half <= 4 && mean < 9.0, "{name}: {half}, {mean}");
    }
    gpu.finish();
}
