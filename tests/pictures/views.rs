//! Views show what they say where they say it.

use crate::common::{self, Gpu, gpu, scene, scene_of_several};
use glam::{DAffine3, Mat3, Vec2, Vec3, Vec3A};
use image::{Rgba, RgbaImage};
use myxo::render::colormap::linear_from_srgb;
use myxo::render::exposure::Exposure;
use myxo::render::hues::object_light;
use myxo::render::view::Light;
use myxo::render::{Offscreen, Prepared, Quality, Renderer, View, offscreen, pick};
use myxo::scene::Scene;
use myxo::scene::settings::{ColorMap, Settings, Show};
use myxo::sim::Simulation;

const SIZE: [u32; 2] = [160, 120];

fn size() -> Vec2 {
    Vec2::new(SIZE[0] as f32, SIZE[1] as f32)
}

/// A scene on the device, seen from the front.
struct Stage<'a> {
    gpu: &'a Gpu,
    scene: Scene,
    simulation: Simulation,
    renderer: Renderer,
    canvas: Offscreen,
    view: View,
}

impl<'a> Stage<'a> {
    fn new(gpu: &'a Gpu, scene: Scene) -> Self {
        let simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let mut view = View::of(&scene, size());
        crate::pictures::bare(&mut view);
        view.exposure = Exposure::Fixed(1.0);
        (view.camera.yaw, view.camera.pitch) = (0.0, 0.0);
        Self {
            gpu,
            renderer: Renderer::new(&gpu.ctx, simulation.setup(), offscreen::FORMAT).unwrap(),
            canvas: Offscreen::new(&gpu.ctx, SIZE).unwrap(),
            scene,
            simulation,
            view,
        }
    }

    fn of(gpu: &'a Gpu, mesh: &str, change: impl FnOnce(&mut Settings)) -> Self {
        Self::new(gpu, scene(mesh, change))
    }

    fn step(&mut self) {
        self.gpu.run(|rec| self.simulation.record_step(rec));
    }

    fn picture(&mut self, show: Show) -> RgbaImage {
        self.view.show = show;
        let (state, canvas) = (self.simulation.state(), self.canvas.canvas());
        self.gpu.run(|rec| {
            self.renderer.draw(rec, state, &self.view, canvas);
            self.canvas.record_readback(rec);
        });
        self.canvas.image()
    }

    fn hit(&self, x: u32, y: u32) -> Option<pick::Hit> {
        let pixel = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
        let ray = self.view.camera.ray(pixel, size());
        let poses = self.simulation.world_from_object();
        pick::pick(&self.scene.surface, &poses, &ray)
    }

    /// A value for every texel: of the place in object space that its centre shows, 0 where there is none.
    fn texels(&self, value_at: impl Fn(Vec3) -> f32) -> Vec<f32> {
        let setup = self.simulation.setup();
        let corner = |v: u32| setup.surface.positions[v as usize];
        let value = |texel: u32| {
            let (triangle, u, v) = setup.atlas.surface_point_of(texel)?;
            let [a, b, c] = setup.surface.corners[triangle as usize].map(corner);
            Some(value_at(a + u * (b - a) + v * (c - a)))
        };
        let count = setup.atlas.texel_count() as u32;
        (0..count)
            .map(|texel| value(texel).unwrap_or(0.0))
            .collect()
    }
}

fn rgb(pixel: &Rgba<u8>) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|c| f32::from(pixel.0[c])))
}

/// The mean colour of a part of a picture, ends in shares of its sides.
fn mean(picture: &RgbaImage, x: (f32, f32), y: (f32, f32)) -> Vec3 {
    let range = |(low, high): (f32, f32), side: u32| {
        (low * side as f32) as u32..(high * side as f32) as u32
    };
    let (mut sum, mut count) = (Vec3::ZERO, 0.0);
    for py in range(y, picture.height()) {
        for px in range(x, picture.width()) {
            sum += rgb(picture.get_pixel(px, py));
            count += 1.0;
        }
    }
    sum / count
}

const MIDDLE: (f32, f32) = (0.4, 0.6);
const TORUS: &str = "builtin:torus?major=48&minor=24";

#[test]
fn no_two_views_look_alike() {
    let Some(gpu) = gpu() else { return };
    let pair = scene_of_several(&common::TRIO, |settings| {
        settings.particles.count = 9000;
        settings.atlas.size = 256;
    });
    let mut stage = Stage::new(&gpu, pair);
    for _ in 0..20 {
        stage.step();
    }
    let pictures: Vec<RgbaImage> = Show::ALL.iter().map(|&show| stage.picture(show)).collect();
    for (i, a) in pictures.iter().enumerate() {
        for (k, b) in pictures.iter().enumerate().skip(i + 1) {
            let differ = a.pixels().zip(b.pixels()).filter(|(a, b)| a != b).count();
            assert!(
                differ > 1500,
                "{:?} and {:?}: {differ}",
                Show::ALL[i],
                Show::ALL[k]
            );
        }
    }
    gpu.finish();
}

#[test]
fn distances_and_nearest_objects_have_the_colours_that_they_should() {
    let Some(gpu) = gpu() else { return };
    let ball = "icosphere?subdivisions=3";
    let balls = [(ball, [-0.95, 0.0, 0.0]), (ball, [0.95, 0.0, 0.0])];
    let pair = scene_of_several(&balls, |settings| {
        settings.particles.count = 500;
        settings.atlas.size = 512;
        settings.distance.reach = 0.4;
    });
    let mut stage = Stage::new(&gpu, pair);
    stage.view.occlusion = 0.0;
    // Before the first step no distance is known, and the trail is shown.
    assert_eq!(stage.picture(Show::Distance), stage.picture(Show::Surface));
    stage.step();
    let reach = 0.4 * stage.scene.radius;
    let [distance, nearest] = [Show::Distance, Show::Nearest].map(|show| stage.picture(show));
    let (mut near, mut far) = (0, 0);
    for (x, y) in (0..SIZE[0]).flat_map(|x| (0..SIZE[1]).map(move |y| (x, y))) {
        let Some(hit) = stage.hit(x, y) else { continue };
        let own = usize::from(hit.position.x > 0.0);
        let other = Vec3::new(if own == 1 { -0.95 } else { 0.95 }, 0.0, 0.0);
        let apart = hit.position.distance(other) - 1.0;
        let from_rim = (hit.position - Vec3::new(-other.x, 0.0, 0.0)).z;
        if from_rim < 0.3 {
            continue;
        }
        let [tone, name] = [&distance, &nearest].map(|p| rgb(p.get_pixel(x, y)));
        let light = |object: usize| {
            let color = object_light(object);
            color / color.max_element()
        };
        // Of equal brightness, seen as light, which name is it?
        let name = name
            .to_array()
            .map(|c| myxo::render::colormap::linear_from_srgb(c / 255.0));
        let name = Vec3::from_array(name);
        let name = name / name.max_element();
        let is = |object: usize| name.distance(light(object)) < name.distance(light(1 - object));
        if apart > 0.35 * reach && apart < 0.7 * reach {
            near += 1;
            assert!(tone.z > tone.x + 12.0, "({x}, {y}) is blue: {tone}");
            assert!(is(1 - own), "({x}, {y}) is the other's: {name}");
        } else if apart > 1.1 * reach {
            far += 1;
            assert!((tone.z - tone.x).abs() < 25.0, "({x}, {y}) is grey: {tone}");
            assert!(is(own), "({x}, {y}) is its own: {name}");
        }
    }
    assert!(near > 50 && far > 500, "{near} near, {far} far");
    gpu.finish();
}

/// Catches what is drawn of hidden objects, in every view of the surface, and pictures that change what runs.
#[test]
fn hidden_objects_are_not_drawn_and_run_on() {
    let Some(gpu) = gpu() else { return };
    let meshes = [
        ("icosphere?subdivisions=3", [-1.5, 0.0, 0.0]),
        ("icosphere?subdivisions=3", [1.5, 0.0, 0.0]),
    ];
    let begun = || {
        let scene = scene_of_several(&meshes, |settings| {
            settings.particles.count = 5000;
            settings.atlas.size = 128;
            settings.objects[1].motion.spin = [0.0, 30.0, 0.0];
        });
        let mut stage = Stage::new(&gpu, scene);
        let mut snapshot = stage.simulation.snapshot().unwrap();
        snapshot.bias = vec![200.0; snapshot.trail.len()];
        snapshot.trail.fill(0.3);
        stage.simulation.restore(&snapshot).unwrap();
        stage.step();
        stage
    };
    let [mut stage, mut plain] = [begun(), begun()];
    let hash = |stage: &Stage| stage.simulation.snapshot().unwrap().hash();
    let [left, right] = [0.3, 0.7].map(|x| (x - 0.05, x + 0.05));
    let seen = |picture: &RgbaImage, x| mean(picture, x, MIDDLE);
    let views = Show::ALL.iter().copied();
    for show in views.filter(|show| !show.is_flat()) {
        let word = show.word();
        let all = stage.picture(show);
        assert_eq!(plain.picture(show), all, "{word}");
        stage.renderer.hide(&[true, true]);
        let none = stage.picture(show);
        stage.renderer.hide(&[true]);
        let one = stage.picture(show);
        assert!(seen(&all, left).distance(seen(&none, left)) > 5.0, "{word}");
        assert!(seen(&one, left).distance(seen(&none, left)) < 1.0, "{word}");
        assert!(
            seen(&one, right).distance(seen(&all, right)) < 1.0,
            "{word}"
        );
        stage.renderer.hide(&[]);
        assert_eq!(stage.picture(show), all, "{word}");
        // What moves continues from where it is.
        stage.renderer.hide(&[true, true]);
        stage.picture(show);
        stage.step();
        plain.step();
        assert_eq!(hash(&stage), hash(&plain), "{word}");
        stage.renderer.hide(&[]);
    }
    gpu.finish();
}

/// Relative luminance of a colour in sRGB, 0 to 255 each.
fn luminance(color: Vec3) -> f32 {
    let linear = (color / 255.0).to_array().map(linear_from_srgb);
    Vec3::from(linear).dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

#[test]
fn painted_areas_are_seen_unless_they_are_hidden() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::of(&gpu, "builtin:plane", |s| s.particles.count = 10);
    stage.view.camera.pitch = 1.2;
    let bare = stage.picture(Show::Surface);
    let mut snapshot = stage.simulation.snapshot().unwrap();
    let tinted = [200.0, -200.0, -1e9].map(|bias| {
        snapshot.bias = vec![bias; snapshot.trail.len()];
        stage.simulation.restore(&snapshot).unwrap();
        stage.view.shows_areas = false;
        assert_eq!(stage.picture(Show::Surface), bare, "hidden");
        stage.view.shows_areas = true;
        let middle = |from: &RgbaImage| mean(from, (0.45, 0.55), (0.45, 0.55));
        middle(&stage.picture(Show::Surface)) - middle(&bare)
    });
    let [attracts, repels, no_go] = tinted;
    // Both are as bright, so that they stand out as much by their contrast; and neither is lost over bright trail.
    for trail in [0.0, 0.1, 0.3, 1.0] {
        snapshot.trail.fill(trail);
        let [below, tinted @ ..] = [0.0, 200.0, -200.0].map(|bias| {
            snapshot.bias.fill(bias);
            stage.simulation.restore(&snapshot).unwrap();
            mean(&stage.picture(Show::Surface), (0.45, 0.55), (0.45, 0.55))
        });
        let [green, violet] = tinted.map(|color| 0.05 + luminance(color));
        assert!(
            (green / violet - 1.0).abs() < 0.1,
            "{trail}: {green} {violet}"
        );
        let apart = tinted.map(|color| color.distance(below));
        assert!(
            apart.iter().all(|apart| *apart > 40.0),
            "{trail}: {apart:?}"
        );
    }
    assert!(attracts.y > attracts.x + 30.0 && attracts.y > attracts.z + 30.0);
    assert!(repels.z > repels.y + 30.0 && repels.x > repels.y + 30.0);
    assert!(no_go.x > no_go.y + 30.0 && no_go.x > no_go.z + 30.0);
    gpu.finish();
}

#[test]
fn hues_show_where_particles_head() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::of(&gpu, "builtin:cube?divisions=2", |settings| {
        settings.particles.count = 20_000;
    });
    let setup = stage.simulation.setup().clone();
    let mut seen = Vec::new();
    for way in [Vec3::X, Vec3::Y, Vec3::NEG_X, Vec3::NEG_Y] {
        let mut motions = setup.motions.clone();
        let particles = (gpu.ctx)
            .download(&stage.simulation.state().particles)
            .unwrap();
        for (motion, particle) in motions.iter_mut().zip(&particles) {
            let [a, b, c] = setup.surface.corners[particle.triangle as usize]
                .map(|v| setup.surface.positions[v as usize]);
            let p = (b - a).normalize();
            let h = (b - a).cross(c - a).normalize().cross(p);
            (motion.heading_p, motion.heading_h) = (way.dot(p), way.dot(h));
        }
        let state = stage.simulation.state();
        gpu.ctx.upload(&state.motions, &motions).unwrap();
        seen.push(mean(&stage.picture(Show::Headings), MIDDLE, MIDDLE));
    }
    let [right, up, left, down] = seen[..] else {
        panic!("four ways")
    };
    let of = |color: Vec3| color / color.max_element();
    assert!(of(right).x == 1.0 && of(right).z < 0.9, "{right}");
    assert!(of(up).y == 1.0 && of(up).z < 0.85, "{up}");
    assert!(of(left).z == 1.0 && of(left).x < 0.8, "{left}");
    assert!(of(down).z == 1.0 && of(down).x > of(left).x + 0.1, "{down}");
    gpu.finish();
}

#[test]
fn crowds_are_bright() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::of(&gpu, "builtin:cube?divisions=2", |_| {});
    let counts = stage.texels(|place| if place.x > 0.0 { 9.0 } else { 0.0 });
    let counts: Vec<u32> = counts.into_iter().map(|count| count as u32).collect();
    let state = stage.simulation.state();
    gpu.ctx.upload(&state.deposits.back, &counts).unwrap();
    let picture = stage.picture(Show::Density);
    let [left, right] = [(0.35, 0.45), (0.55, 0.65)].map(|x| mean(&picture, x, MIDDLE));
    assert!(right.x > left.x + 60.0, "{left} and {right}");
    gpu.finish();
}

#[test]
fn a_relief_is_lit_on_the_side_of_the_light() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::of(&gpu, "builtin:cube?divisions=2", |settings| {
        settings.atlas.size = 512;
    });
    stage.view.color_map = ColorMap::Grayscale;
    // A vein from top to bottom.
    let trail = stage.texels(|place| (-(place.x / 0.08).powi(2)).exp());
    let state = stage.simulation.state();
    gpu.ctx.upload(&state.trail.front, &trail).unwrap();
    let slopes = |stage: &mut Stage<'_>, show, azimuth| {
        stage.view.light = Light {
            azimuth,
            elevation: 0.0,
        };
        let picture = stage.picture(show);
        let [left, right] = [(0.46, 0.49), (0.51, 0.54)].map(|x| mean(&picture, x, MIDDLE).x);
        right - left
    };
    let mut gain = |show| slopes(&mut stage, show, 60.0) - slopes(&mut stage, show, -60.0);
    let (raised, flat) = (gain(Show::Relief), gain(Show::Surface));
    assert!(raised > 40.0 && flat.abs() < 8.0, "{raised}, {flat}");
    gpu.finish();
}

#[test]
fn hollows_are_darker_and_the_light_comes_from_where_it_is() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::of(&gpu, TORUS, |_| {});
    stage.view.camera.pitch = 0.8;
    let mut of = |occlusion: f32, azimuth: f32| {
        stage.view.occlusion = occlusion;
        stage.view.light.azimuth = azimuth;
        stage.picture(Show::Charts)
    };
    let (open, closed) = (of(0.0, 0.0), of(1.0, 0.0));
    let darker = |x: u32, y: u32| {
        let [open, closed] = [&open, &closed].map(|p| rgb(p.get_pixel(x, y)).element_sum());
        closed / open
    };
    let column: Vec<f32> = (0..SIZE[1]).map(|y| darker(SIZE[0] / 2, y)).collect();
    let (least, most) = column
        .iter()
        .fold((f32::MAX, 0.0_f32), |(a, b), &c| (a.min(c), b.max(c)));
    assert!(least < 0.95 && most > 0.98, "{least} to {most}");
    let [from_left, from_right] = [-80.0, 80.0].map(|azimuth| of(0.0, azimuth));
    let ends = [(0.1, 0.25), (0.75, 0.9)];
    let [left, right] = ends.map(|x| {
        let [a, b] = [&from_left, &from_right].map(|p| mean(p, x, MIDDLE).element_sum());
        a - b
    });
    assert!(left > 10.0 && right < -10.0, "{left}, {right}");
    gpu.finish();
}

#[test]
fn pictures_side_by_side_are_those_drawn_alone() {
    let Some(gpu) = gpu() else { return };
    let mut stage = Stage::of(&gpu, TORUS, |settings| settings.particles.count = 5000);
    for _ in 0..5 {
        stage.step();
    }
    let alone = [Show::Relief, Show::Atlas].map(|show| stage.picture(show));
    let canvases = [(); 2].map(|()| Offscreen::new(&gpu.ctx, SIZE).unwrap());
    let [mut relief, mut atlas] = [stage.view; 2];
    (relief.show, atlas.show) = (Show::Relief, Show::Atlas);
    gpu.run(|rec| {
        let pictures = [
            (relief, canvases[0].canvas()),
            (atlas, canvases[1].canvas()),
        ];
        stage
            .renderer
            .draw_beside(rec, stage.simulation.state(), &pictures);
        canvases
            .iter()
            .for_each(|canvas| canvas.record_readback(rec));
    });
    assert!(alone == canvases.map(|canvas| canvas.image()));
    gpu.finish();
}

/// Pictures leave out what turns its back where it cannot be seen: the same picture as with an open object behind the eye,
/// which forbids that. Inside of an object its walls are seen, also of one that has only just come round the eye.
#[test]
fn backs_that_are_hidden_are_not_missed_and_walls_are_there() {
    let Some(gpu) = gpu() else { return };
    let meshes = ["icosphere?subdivisions=1", "plane?columns=1&rows=1"];
    let mut stages = meshes.map(|behind| {
        let knot = ("torus?major=24&minor=16", [0.0; 3]);
        let scene = scene_of_several(&[knot, (behind, [0.0, 0.0, 40.0])], |settings| {
            settings.particles.count = 500;
            settings.atlas.size = 128;
        });
        let mut stage = Stage::new(&gpu, scene);
        (stage.view.camera.target, stage.view.camera.scene_radius) = (Vec3::ZERO, 1.0);
        stage.view.camera.shift = Vec2::ZERO;
        stage.view.is_transparent = true;
        stage
    });
    let turn = stages[0].simulation.world_from_object()[0].matrix3;
    let in_tube = turn * Vec3A::X;
    // In front of the torus; beside it, in its box; in its tube, where the eye comes to it or it comes to the eye.
    for (eye_at, torus_at, distance, is_inside) in [
        (Vec3A::ZERO, Vec3A::ZERO, 4.0, false),
        (Vec3A::ZERO, Vec3A::ZERO, 0.5, false),
        (in_tube, Vec3A::ZERO, 0.05, true),
        (Vec3A::ZERO, -in_tube, 0.05, true),
        (in_tube, -in_tube, 4.0, false),
    ] {
        for show in [Show::Surface, Show::Relief, Show::Wireframe] {
            let [all_closed, one_open] = [0, 1].map(|i| {
                let stage = &mut stages[i];
                stage.view.camera.target = eye_at.into();
                stage.view.camera.distance = distance;
                let turn = Mat3::from(turn).as_dmat3();
                let pose = DAffine3::from_mat3_translation(turn, Vec3::from(torus_at).as_dvec3());
                stage.simulation.set_pose(0, Some(pose)).unwrap();
                stage.gpu.run(|rec| stage.simulation.record_poses(rec));
                stage.picture(show)
            });
            let pixels = all_closed.pixels().zip(one_open.pixels());
            let differ = pixels.filter(|(a, b)| a != b).count();
            let what = format!("{show:?} from {distance}, torus at {torus_at}");
            // At the outline a pixel may have seen the back alone.
            assert!(
                differ * 2000 <= all_closed.pixels().len(),
                "{what}: {differ}"
            );
            let filled = all_closed
                .pixels()
                .filter(|pixel| pixel.0[3] == 255)
                .count();
            let all = all_closed.pixels().len();
            assert!(filled > all / 50, "{what}: {filled}");
            assert_eq!(filled == all, is_inside, "{what}: {filled} of {all}");
        }
    }
    gpu.finish();
}

/// With one sample a pixel, surfaces with neither relief nor charts are drawn from vertices that triangles share: the same
/// picture as from corners, which a trace of charts' colours asks for, and nearly that of several samples. Also from afar, where
/// a pixel covers more texels than a chart is wide: there is nothing on the torus, and light on the cube beside it in the atlas.
#[test]
fn shared_vertices_show_what_corners_do() {
    let Some(gpu) = gpu() else { return };
    let objects = [
        ("torus?major=48&minor=24", [0.0; 3]),
        // Three faces meet at a corner, and each has a normal of its own.
        ("cube?divisions=4", [0.9, 0.0, 0.0]),
    ];
    let scene = scene_of_several(&objects, |settings| {
        settings.atlas.size = 256;
        settings.particles.count = 1;
    });
    let mut stage = Stage::new(&gpu, scene);
    let prepared = Prepared::for_quick(stage.simulation.setup());
    let setup = stage.simulation.setup();
    stage.renderer =
        Renderer::from_prepared(&gpu.ctx, setup, &prepared, offscreen::FORMAT).unwrap();
    stage.view.light = Light {
        azimuth: 60.0,
        elevation: 30.0,
    };
    let waves = stage.texels(|place| 0.5 + 0.5 * (9.0 * place.x).sin() * (9.0 * place.y).cos());
    let (first, end) = setup.surface.objects[1].triangles;
    let owners = setup.atlas.owner.iter();
    let on_cube = owners
        .map(|owner| f32::from((first..end).contains(owner)))
        .collect();
    let near = stage.view.camera.distance;
    for (trail, distance, bounds) in [
        (waves, near, [(0.4, 0.002), (2.5, 0.03)]),
        (on_cube, 12.0 * near, [(0.1, 0.0), (0.5, 0.005)]),
    ] {
        stage.view.camera.distance = distance;
        let state = stage.simulation.state();
        gpu.ctx.upload(&state.trail.front, &trail).unwrap();
        // Fills the gutters.
        stage.step();
        let mut picture = |quality, charts| {
            stage.canvas = Offscreen::with_quality(&gpu.ctx, SIZE, quality).unwrap();
            stage.view.charts = charts;
            stage.picture(Show::Surface)
        };
        let shared = picture(Quality::Quick, 0.0);
        let others = [
            picture(Quality::Quick, 1.0e-9),
            picture(Quality::Smooth, 0.0),
        ];
        for (other, (most_mean, most_far)) in others.iter().zip(bounds) {
            let off: Vec<f32> = (shared.pixels().zip(other.pixels()))
                .map(|(a, b)| (rgb(a) - rgb(b)).abs().max_element())
                .collect();
            let mean_off = off.iter().sum::<f32>() / off.len() as f32;
            let far = off.iter().filter(|&&off| off > 20.0).count() as f32 / off.len() as f32;
            println!("from {distance}: off by {mean_off} on average, {far} of the pixels far");
            assert!(
                mean_off <= most_mean && far <= most_far,
                "from {distance}: {mean_off}, {far}"
            );
        }
        let lit = shared.pixels().filter(|pixel| rgb(pixel).x > 100.0).count();
        assert!(lit > 10, "{lit}");
    }
    gpu.finish();
}
