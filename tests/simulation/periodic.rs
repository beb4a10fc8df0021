//! Planes without borders and glued edges: particles, trail and cells go over them as over any other edge, on both engines.

use glam::DVec3;

use crate::advance;
use crate::common::{by_id, gpu, scene};
use crate::program::{Folder, failed, path};
use myxo::mesh::Mesh;
use myxo::mesh::atlas::{Atlas, AtlasOptions};
use myxo::mesh::surface::{NONE, Surface};
use myxo::mesh::walk::Frame;
use myxo::scene::Scene;
use myxo::scene::file::Reader;
use myxo::scene::settings::{Heading, Model, ObjectSettings, Settings};
use myxo::sim::beside::first_difference;
use myxo::sim::cells::{homes, sharing_count};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::diffusion::Diffusion;
use myxo::sim::types::{Motion, Particle};
use myxo::sim::{Setup, Simulation, twin};

const PERIODIC: &str = "builtin:plane?columns=8&rows=8&periodic=true";
const BORDERED: &str = "builtin:plane?columns=8&rows=8";

/// Length of a step of particles that go straight on. The sides of the plane are 2 long.
const STEP: f64 = 0.05;

/// Particles that never turn, all in one direction.
fn straight(mesh: &str, direction: [f32; 3]) -> Scene {
    scene(mesh, |settings| {
        settings.radius = 1.0;
        settings.particles.count = 400;
        settings.particles.start_heading = Heading::Aligned;
        settings.particles.start_direction = direction;
        settings.physarum.rotation_angle = 0.0;
        settings.physarum.speed = STEP as f32;
        settings.physarum.edge_crossing_attempts = 64;
        settings.atlas.size = 64;
    })
}

/// Places and headings in the plane's own space, by id.
fn places_of(twin: &twin::Simulation) -> Vec<(DVec3, DVec3)> {
    let surface = &twin.setup().surface;
    let both = by_id(&twin.snapshot()).into_iter();
    both.map(|(particle, motion): (Particle, Motion)| {
        let frame = Frame::of(surface, particle.triangle);
        let corner = surface.corners[particle.triangle as usize][0];
        let corner = surface.positions[corner as usize].as_dvec3();
        let inside = frame.position(f64::from(particle.u), f64::from(particle.v));
        let heading = [motion.heading_p, motion.heading_h].map(f64::from);
        (
            corner + inside.x * frame.p + inside.y * frame.h,
            heading[0] * frame.p + heading[1] * frame.h,
        )
    })
    .collect()
}

/// The way between two places, the shorter way round.
fn way_round(from: DVec3, to: DVec3) -> DVec3 {
    let way = to - from;
    way - 2.0 * (0.5 * way).round()
}

/// Catches a walk that comes in at another place of the opposite side than it left, in another direction, or with a part of its length
/// lost; and a plane that is not as wide one way as the other.
#[test]
fn straight_walks_round_a_periodic_plane_end_where_they_began() {
    for (direction, steps) in [([1.0, 0.0, 0.0], 40), ([-0.6, 0.0, 0.8], 200)] {
        let scene = straight(PERIODIC, direction);
        let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings.clone());
        let begun = places_of(&twin);
        let along = DVec3::from_array(direction.map(f64::from)).normalize();
        let mut crossings = 0;
        for step in 1..=steps {
            twin.step();
            if step % 10 != 1 && step != steps {
                continue;
            }
            for ((from, _), (to, heading)) in begun.iter().zip(places_of(&twin)) {
                let expected = *from + f64::from(step) * STEP * along;
                let off = way_round(expected, to).length();
                assert!(off < 1e-3, "{direction:?}, step {step}: {off} beside it");
                assert!(heading.dot(along) > 1.0 - 1e-5, "{heading}");
                crossings += u32::from(expected.abs().max_element() > 1.0);
            }
        }
        assert!(crossings > 400, "{crossings} are beyond a side");
        for ((from, _), (to, _)) in begun.iter().zip(places_of(&twin)) {
            assert!(
                way_round(*from, to).length() < 1e-3,
                "{to} is where it began"
            );
        }
    }
}

/// The opposite of the test above: with borders walks come back mirrored.
#[test]
fn without_it_walks_are_reflected() {
    let scene = straight(BORDERED, [1.0, 0.0, 0.0]);
    let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings.clone());
    let begun = places_of(&twin);
    for _ in 0..40 {
        twin.step();
    }
    for ((from, _), (to, heading)) in begun.iter().zip(places_of(&twin)) {
        let mirrored = DVec3::new(-from.x, from.y, from.z);
        assert!(to.distance(mirrored) < 1e-3, "{to} and not {mirrored}");
        assert!(heading.x < -0.999, "{heading}");
    }
}

/// Would alone catch: a particle that counts as far from all other objects because it is at the other side of the plane, so that it walks
/// over the side into a ball and stays on the plane. With borders no particle gets there.
#[test]
fn particles_enter_a_ball_over_a_glued_side() {
    for (mesh, is_periodic) in [(PERIODIC, true), (BORDERED, false)] {
        let mut settings = straight(mesh, [1.0, 0.0, 0.0]).settings;
        settings.objects.push(ObjectSettings {
            mesh: "builtin:icosphere?subdivisions=3".to_owned(),
            position: [-1.22, 0.0, 0.0],
            scale: 0.3,
            ..ObjectSettings::default()
        });
        settings.particles.count = 40_000;
        settings.atlas.size = 256;
        let scene = Scene::from_settings("both".to_owned(), settings, ".".into()).unwrap();
        let mut twin = twin::Simulation::new(Setup::new(&scene).unwrap(), scene.settings.clone());
        let objects = |twin: &twin::Simulation| -> Vec<u32> {
            let triangles = &twin.setup().surface.triangles;
            let both = by_id(&twin.snapshot()).into_iter();
            both.map(|(particle, _)| triangles[particle.triangle as usize].object)
                .collect()
        };
        let (places, before) = (places_of(&twin), objects(&twin));
        twin.step();
        let after = objects(&twin);
        let mut count = 0;
        for (id, (from, _)) in places.iter().enumerate() {
            // A step from here ends inside the ball, 0.03 to 0.1 deep, where places on it are found, and two texels beyond the side: nearer
            // to it, distances that are read between texels are mixed with those at the other side.
            if before[id] == 0 && from.x > 0.97 && from.z.abs() < 0.1 {
                assert_eq!(after[id], u32::from(is_periodic), "{from}");
                count += 1;
            }
        }
        assert!(count > 25, "{count}");
    }
}

/// The texel in a column and a row of the plane.
fn texel(atlas: &Atlas, x: usize, y: usize) -> usize {
    let gutter = atlas.gutter as usize;
    (y + gutter) * atlas.pitch as usize + x + gutter
}

/// Mixes each cell of a torus with the mean of the nine round it.
fn mixed(cells: &[f64], side: usize, diffusion: f64) -> Vec<f64> {
    let at = |x: usize, y: usize| cells[y % side * side + x % side];
    let mean = |x: usize, y: usize| {
        let around = (0..3).flat_map(|j| (0..3).map(move |i| (x + side + i - 1, y + side + j - 1)));
        around.map(|(x, y)| at(x, y)).sum::<f64>() / 9.0
    };
    (0..side * side)
        .map(|i| cells[i] + diffusion * (mean(i % side, i / side) - cells[i]))
        .collect()
}

/// Catches conductances over the glued sides that are not those inside, in any of the eight directions, and mass that a side or a corner
/// keeps.
#[test]
fn a_deposit_in_a_corner_spreads_as_on_a_torus() {
    const SIDE: usize = 200;
    const STEPS: u64 = 120;
    let Some(gpu) = gpu() else { return };
    let of = |name: &str| {
        let mesh = Mesh::builtin(name).unwrap();
        let surface = Surface::build(&[(&mesh, 1.0)]);
        let options = AtlasOptions {
            size: SIDE as u32,
            gutter: 1,
            ..AtlasOptions::default()
        };
        let atlas = Atlas::build(&surface, &options).unwrap();
        atlas.validate(&surface).unwrap();
        atlas
    };
    let spread = |atlas: &Atlas, from: usize, rate: f32| {
        let mut trail = vec![0.0; atlas.texel_count()];
        trail[from] = 1000.0;
        let mut diffusion = Diffusion::new(&gpu.ctx, atlas, rate).unwrap();
        diffusion.set(&trail).unwrap();
        diffusion.run(STEPS, |_| true).unwrap();
        diffusion.values().unwrap()
    };
    let atlas = of("plane?periodic=true");
    for rate in [0.5, 1.0] {
        let found = spread(&atlas, texel(&atlas, SIDE - 1, 0), rate);
        let mut expected = vec![0.0; SIDE * SIDE];
        expected[SIDE - 1] = 1000.0;
        for _ in 0..STEPS {
            expected = mixed(&expected, SIDE, f64::from(rate));
        }
        let most = expected.iter().copied().fold(0.0, f64::max);
        let mut sum = 0.0;
        for (i, expected) in expected.iter().enumerate() {
            let value = f64::from(found[texel(&atlas, i % SIDE, i / SIDE)]);
            sum += value;
            assert!(
                (value - expected).abs() < 1e-5 * most,
                "{value} and not {expected} in column {}, row {}",
                i % SIDE,
                i / SIDE
            );
        }
        assert!((sum / 1000.0 - 1.0).abs() < 1e-5, "{sum}");
        // All four corners of the texture have got a quarter.
        let opposite = f64::from(found[texel(&atlas, 0, SIDE - 1)]);
        assert!(opposite > 0.9 * most, "{opposite} of {most}");
    }

    let bordered = of("plane");
    let from = (0..bordered.texel_count()).find(|&texel| bordered.owner[texel] != NONE);
    let from = from.unwrap();
    let pitch = bordered.pitch as usize;
    for (texel, &value) in spread(&bordered, from, 0.5).iter().enumerate() {
        let away = (texel % pitch).abs_diff(from % pitch);
        let away = away.max((texel / pitch).abs_diff(from / pitch));
        assert!(value < 1e-3 || away < 60, "no side is glued: {away}");
    }
    gpu.finish();
}

/// Catches an engine that finds another way over a glued edge, or reads other cells beyond one, also with one particle a cell: all
/// 40,000 cells are ones; and a run that ends in another state when it is resumed.
#[test]
fn both_engines_have_the_same_bits_on_a_periodic_plane() {
    let Some(gpu) = gpu() else { return };
    let jones = |settings: &mut Settings| {
        settings.physarum.model = Model::Jones;
        settings.physarum.speed = 0.008;
        settings.physarum.sensor_offset = 0.06;
        settings.particles.count = 6000;
        settings.atlas.size = 200;
    };
    let thesis = |settings: &mut Settings| {
        settings.physarum.speed = 0.03;
        settings.physarum.sensor_offset = 0.2;
        settings.trail.diffusion_distance = 2;
        settings.atlas.size = 121;
    };
    for scene in [scene(PERIODIC, jones), scene(PERIODIC, thesis)] {
        let setup = Setup::new(&scene).unwrap();
        let owned = setup.atlas.owned_count;
        assert_eq!(owned, scene.settings.atlas.size.pow(2));
        let found = first_difference(&gpu.ctx, &scene, &setup, 4, 3, &[]).unwrap();
        assert!(found.is_none(), "{}", found.unwrap());
        let mut device = Simulation::from_setup(&gpu.ctx, &scene, setup.clone()).unwrap();
        let mut host = twin::Simulation::new(setup, scene.settings.clone());
        advance(&gpu, &mut device, 15);
        let half = device.snapshot().unwrap();
        advance(&gpu, &mut device, 15);
        for _ in 0..30 {
            host.step();
        }
        let state = device.snapshot().unwrap();
        assert_eq!(state.hash(), host.snapshot().hash());
        let setup = device.setup();
        state.validate(setup).unwrap();
        let mut resumed = Simulation::from_setup(&gpu.ctx, &scene, setup.clone()).unwrap();
        resumed.restore(&half).unwrap();
        advance(&gpu, &mut resumed, 15);
        assert_eq!(resumed.snapshot().unwrap().hash(), state.hash());
        if scene.settings.physarum.model == Model::Jones {
            let homes = homes(&setup.atlas);
            assert_eq!(sharing_count(&state.particles, &setup.atlas, &homes), 0);
        }
    }
    let full = scene(PERIODIC, |settings| {
        jones(settings);
        settings.particles.count = 40_001;
    });
    let message = Setup::new(&full).unwrap_err().to_string();
    assert!(
        message.contains("the texture has 40,000 cells"),
        "{message}"
    );
    gpu.finish();
}

/// The pairs that make a periodic plane of one with borders, of two rows and two columns.
const GLUE: &str = "glue = [[0, 0, 3, 1], [4, 0, 7, 1], [1, 2, 4, 1], [3, 2, 6, 1]]";

/// The settings of a scene file.
fn read(text: &str) -> Settings {
    let mut reader = Reader::new(Settings::default());
    reader.text("", text);
    reader.finish().unwrap()
}

/// Catches a list of edges that is read in another order, gets lost when a scene is saved, is glued only in the built-in mesh, or is
/// missing from the mesh's report.
#[test]
fn a_list_of_edges_makes_the_same_of_a_plane_with_borders() {
    let built_in = scene("builtin:plane?columns=2&rows=2&periodic=true", |_| ());
    let text = format!("[[object]]\nmesh = \"builtin:plane?columns=2&rows=2\"\n{GLUE}\n");
    let settings = read(&text);
    let listed = Scene::from_settings("listed".to_owned(), settings, ".".into()).unwrap();
    assert_eq!(listed.surface.halfedges, built_in.surface.halfedges);
    assert_eq!(listed.surface.glued, built_in.surface.glued);
    let pairs = |scene: &Scene| scene.meshes[0].report.glued_pairs;
    assert_eq!((pairs(&listed), pairs(&built_in)), (4, 4));
    let again = read(&listed.to_toml());
    assert_eq!(again.objects[0].glue, listed.settings.objects[0].glue);
    let plain = scene("builtin:plane?columns=2&rows=2", |_| ());
    assert!(!plain.to_toml().contains("glue"));
    assert_eq!(pairs(&plain), 0);
    // The meshes of a scene may go on in one that glues nothing.
    let mut unglued = listed.settings;
    unglued.objects[0].glue.clear();
    let unglued = Scene::from_meshes("unglued".to_owned(), unglued, listed.meshes, ".".into());
    assert_eq!(pairs(&unglued.unwrap()), 0);
}

/// Catches a plane whose places can be inside of it because every edge has a neighbour: what lies below it would count as covered.
#[test]
fn a_periodic_plane_has_no_inside() {
    let surface_of = |name: &str| Surface::build(&[(&Mesh::builtin(name).unwrap(), 1.0)]);
    let surface = surface_of("plane?columns=8&rows=8&periodic=true");
    assert!(surface.halfedges.iter().all(|half| half.twin != NONE));
    assert!(!surface.is_closed(0));
    assert!(surface_of("cube").is_closed(0));
}

/// Catches a checkpoint that does not contain which edges are glued: that alone differs here, and particles would meet a border or a way
/// over it that they did not have.
#[test]
fn a_checkpoint_with_glue_does_not_load_without() {
    let of = |glue: &str| {
        let atlas = "[atlas]\nsize = 64\nmethod = \"grid\"\n[particles]\ncount = 500\n";
        let object = "[[object]]\nmesh = \"builtin:plane?columns=2&rows=2\"\n";
        let settings = read(&format!("{atlas}{object}{glue}\n"));
        let scene = Scene::from_settings("sheet".to_owned(), settings, ".".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let mut twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
        twin.step();
        let checkpoint = Checkpoint::new(&scene, &setup, twin.snapshot());
        (scene, setup, checkpoint)
    };
    let (glued, plain) = (of(GLUE), of(""));
    assert!(glued.1.atlas.maps == plain.1.atlas.maps, "one layout");
    for ((scene, setup, own), (_, _, other)) in [(&glued, &plain), (&plain, &glued)] {
        assert_eq!(own.check(scene, setup), Ok(Vec::new()));
        let message = other.check(scene, setup).unwrap_err();
        assert!(message.contains("other meshes or scales"), "{message}");
    }
}

/// Each mistake has one message that says where it is and what to do.
#[test]
fn wrong_lists_of_edges_are_refused() {
    let folder = Folder::new();
    for (glue, words) in [
        (
            "[[0, 0, 3, 1, 2]]",
            "object.0.glue: a list of pairs of edges, each [face, edge, other face, other edge]",
        ),
        ("[[0, 0.5, 3, 1]]", "in whole numbers, is expected"),
        ("7", "is expected, not 7"),
        (
            "[[0, 0, 3, 1], [4, 0, 9, 1]]",
            "glued pair 1: there is no face 9: the faces are 0 to 7",
        ),
        (
            "[[0, 0, 3, 0]]",
            "glued pair 0: edge 0 of face 3 is no border: face 2 lies beyond it",
        ),
        (
            "[[0, 0, 3, 1], [3, 1, 4, 0]]",
            "glued pair 1: edge 1 of face 3 is glued already, in pair 0",
        ),
    ] {
        let text = format!(
            "[[object]]\nname = \"sheet\"\nmesh = \"builtin:plane?columns=2&rows=2\"\nglue = {glue}\n"
        );
        let file = folder.with("glued.toml", text);
        let message = failed(&["atlas", path(&file)]);
        assert!(message.contains(words), "{words} in {message}");
    }
}
