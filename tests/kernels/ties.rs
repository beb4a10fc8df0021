//! Exact ties: two answers are equally good to the last bit, and a rule takes one of them, by kernel and twin alike.

use glam::{DVec2, DVec3, Vec3};
use myxo::gpu::{Buffer, Pipeline, Texels, Threads};
use myxo::mesh::surface::{NONE, Surface};
use myxo::mesh::trees::Trees;
use myxo::mesh::trees::sides::Sides;
use myxo::mesh::walk::{Frame, SurfacePoint, WalkQuery};
use myxo::mesh::{Mesh, primitive, suite};
use myxo::scene::Scene;
use myxo::scene::settings::{DistanceMethod, ObjectSettings, Sensing, Settings, SignRule};
use myxo::sim::behaviour::physarums;
use myxo::sim::kernels::{
    TreeQueriesParams, WalkQueries, WalkQueriesArgs, WalkQueriesConstants, WalkQueriesParams,
};
use myxo::sim::queries::walker_of;
use myxo::sim::tree_queries::{Question, tree_queries};
use myxo::sim::types::{Motion, Particle, TreeQuery};
use myxo::sim::{Setup, Simulation, Snapshot, twin};

use crate::bits::assert_same_bits;
use crate::common::{Gpu, gpu, scene};

/// Squares of 1 about the origin, two triangles each, whose numbers lie in no order of places: the first found is not the smallest.
fn grid() -> Mesh {
    const SIDE: u32 = 6;
    let at = |i: u32, j: u32| j * (SIDE + 1) + i;
    let half = 0.5 * SIDE as f32;
    let vertices = (0..=SIDE).flat_map(|j| (0..=SIDE).map(move |i| (i, j)));
    let positions: Vec<Vec3> = vertices
        .map(|(i, j)| Vec3::new(i as f32 - half, 0.0, j as f32 - half))
        .collect();
    let squares = (0..SIDE).flat_map(|j| (0..SIDE).map(move |i| (i, j)));
    let triangles: Vec<[u32; 3]> = squares
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            [[a, b, c], [a, c, d]]
        })
        .collect();
    // 29 and the number of triangles, 72, have no common divisor.
    let shuffled: Vec<[u32; 3]> = (0..triangles.len())
        .map(|i| triangles[29 * i % triangles.len()])
        .collect();
    suite::mesh("grid", &positions, &shuffled)
}

/// Places of the grid that lie on its vertices and on the middles of its edges.
fn shared_places() -> Vec<DVec3> {
    let steps = || (-6..=6).map(|k| 0.5 * f64::from(k));
    let all = steps().flat_map(|x| steps().map(move |z| DVec3::new(x, 0.0, z)));
    all.collect()
}

/// The triangles that a place belongs to, edges and corners included, in the order of their numbers.
fn owners(surface: &Surface, place: DVec3) -> Vec<u32> {
    let contains = |triangle: u32| {
        let corners = surface.corners[triangle as usize];
        let [a, b, c] = corners.map(|v| surface.positions[v as usize].as_dvec3());
        let normal = (b - a).cross(c - a);
        [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(from, to)| normal.dot((to - from).cross(place - from)) >= 0.0)
    };
    let all = 0..surface.triangles.len() as u32;
    all.filter(|&triangle| contains(triangle)).collect()
}

/// What the queries find on the grid, equal bits by kernel and twin; how many of them have several triangles to choose from.
#[track_caller]
fn assert_smallest(gpu: &Gpu, question: Question, ask: impl Fn(Vec3) -> TreeQuery) -> usize {
    let surface = Surface::build(&[(&grid(), 1.0)]);
    let trees = Trees::build(&surface);
    let places = shared_places();
    let mut kernel: Vec<TreeQuery> = places.iter().map(|p| ask(p.as_vec3())).collect();
    let mut twin = kernel.clone();
    tree_queries(&gpu.ctx, &surface, &trees, question, &mut kernel).unwrap();
    let first_vertex_normal = surface.halfedges.len() as u32;
    let sides = Sides {
        faces: &trees.faces,
        nodes: &trees.nodes,
        dipoles: &trees.dipoles,
        pseudonormals: &trees.pseudonormals,
        corners: surface.corners.as_flattened(),
        first_vertex_normal,
    };
    let params = TreeQueriesParams {
        query_count: twin.len() as u32,
        root: trees.objects[0].first_node,
        first_vertex_normal,
    };
    twin::tree_queries(&question.constants(), &params, &sides, &mut twin);
    assert_same_bits("ties", &kernel, &twin);
    let mut ties = 0;
    for (place, query) in places.iter().zip(&kernel) {
        let owners = owners(&surface, *place);
        assert_ne!(query.slot, NONE, "{place}");
        let found = trees.faces[query.slot as usize].triangle;
        assert_eq!(found, owners[0], "{place}: of {owners:?}");
        ties += usize::from(owners.len() > 1);
    }
    ties
}

/// Would alone catch: a search whose answer is the triangle that it looks at first, or last, where several are equally near, as a
/// device that rounds otherwise takes another one.
#[test]
fn of_equal_distances_it_is_the_smallest_triangle() {
    let Some(gpu) = gpu() else { return };
    for height in [0.25, 0.0, -0.5] {
        let question = Question::Nearest(SignRule::Pseudonormal);
        let ask = |place: Vec3| TreeQuery::nearest(place + height * Vec3::Y);
        let ties = assert_smallest(&gpu, question, ask);
        assert!(ties > 140, "{ties}");
    }
    gpu.finish();
}

/// Would alone catch: a segment through a vertex or an edge that crosses the triangle which the tree has first.
#[test]
fn of_equal_crossings_it_is_the_smallest_triangle() {
    let Some(gpu) = gpu() else { return };
    for side in [1.0, -1.0] {
        let ask = |place: Vec3| TreeQuery::crossing(place + side * Vec3::Y, place - side * Vec3::Y);
        let ties = assert_smallest(&gpu, Question::Crossing, ask);
        assert!(ties > 140, "{ties}");
    }
    gpu.finish();
}

/// Two cubes in one place beside a ball: its places are equally far from either.
///
/// Would alone catch: a comparison of objects, not of triangles of one tree, by which the later one wins where both are equally far.
#[test]
fn of_two_objects_in_one_place_the_first_is_the_nearest() {
    let Some(gpu) = gpu() else { return };
    let object = |mesh: &str, x: f64| ObjectSettings {
        mesh: format!("builtin:{mesh}"),
        position: [x, 0.0, 0.0],
        rotation: [20.0, 30.0, 40.0],
        ..ObjectSettings::default()
    };
    for method in [DistanceMethod::Bvh, DistanceMethod::Brute] {
        let mut settings = Settings::default();
        settings.particles.count = 65;
        settings.atlas.size = 128;
        settings.distance.reach = 1.0;
        settings.distance.method = method;
        settings.objects = vec![
            object("icosphere?subdivisions=2", 0.0),
            object("cube?divisions=2", 1.5),
            object("cube?divisions=2", 1.5),
        ];
        let scene = Scene::from_settings("test".to_owned(), settings, ".".into()).unwrap();
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        gpu.run(|rec| simulation.record_step(rec));
        let near = &simulation.state().near;
        let nearest: Vec<u32> = gpu.ctx.download(&near.nearest).unwrap();
        let distances: Vec<f32> = gpu.ctx.download(&near.distances).unwrap();
        let setup = simulation.setup().clone();
        let mut twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
        twin.step();
        let by_twin = twin.distances();
        assert_same_bits("distances", &distances, by_twin.0);
        assert_same_bits("nearest", &nearest, by_twin.1);
        let object_of = |triangle: u32| setup.surface.triangles[triangle as usize].object;
        let mut counts = [[0; 3]; 3];
        for (texel, &triangle) in nearest.iter().enumerate() {
            let owner = setup.atlas.owner[texel];
            if triangle != NONE && owner != NONE {
                counts[object_of(owner) as usize][object_of(triangle) as usize] += 1;
            }
        }
        assert!(counts[0][1] > 100, "{method:?}: {counts:?}");
        assert_eq!(counts[0][2], 0, "{method:?}: {counts:?}");
    }
    gpu.finish();
}

/// Walks straight to the corner B of right-angled triangles: both edges there are equally far.
///
/// Would alone catch: a walk that takes another half-edge where it goes through a vertex.
#[test]
fn of_equally_far_edges_a_walk_crosses_the_first() {
    let Some(gpu) = gpu() else { return };
    let surface = Surface::build(&[(&primitive::plane(4, 4), 1.0)]);
    let is_inner = |triangle: u32| {
        let first = 3 * triangle as usize;
        let edges = &surface.halfedges[first..first + 3];
        let shape = surface.triangles[triangle as usize];
        shape.cp == shape.ab && shape.ch == shape.ab && edges.iter().all(|e| e.twin != NONE)
    };
    let all = 0..surface.triangles.len() as u32;
    let triangles: Vec<u32> = all.filter(|&triangle| is_inner(triangle)).collect();
    assert!(triangles.len() > 5, "{triangles:?}");
    let start: Vec<_> = triangles
        .iter()
        .map(|&triangle| {
            walker_of(&WalkQuery {
                start: SurfacePoint {
                    triangle,
                    u: 0.5,
                    v: 0.25,
                },
                heading: DVec2::new(1.0, -1.0).normalize(),
                length: 0.3,
            })
        })
        .collect();
    let constants = WalkQueriesConstants {
        border_reflects: true,
    };
    let pipeline = Pipeline::<WalkQueries>::new(&gpu.ctx, &constants).unwrap();
    let table = |name: &str, words: &[u32]| {
        Texels::new(&Buffer::from_slice(&gpu.ctx, name, words).unwrap(), 4).unwrap()
    };
    let table_of_triangles = table("triangles", bytemuck::cast_slice(&surface.triangles));
    let halfedges = table("halfedges", bytemuck::cast_slice(&surface.halfedges));
    for attempts in [1, 100] {
        let params = WalkQueriesParams {
            walk_count: start.len() as u32,
            attempts,
        };
        let mut twin = start.clone();
        let (t, h) = (&surface.triangles, &surface.halfedges);
        twin::walk_queries(&constants, &params, t, h, &mut twin);
        let walkers = Buffer::from_slice(&gpu.ctx, "walkers", &start).unwrap();
        gpu.run(|rec| {
            let args = WalkQueriesArgs {
                triangles: &table_of_triangles,
                halfedges: &halfedges,
                walkers: &walkers,
            };
            rec.dispatch(&pipeline, Threads::of(start.len()), args, params);
        });
        let kernel = gpu.ctx.download(&walkers).unwrap();
        assert_same_bits("walks through a vertex", &kernel, &twin);
        for (&triangle, walker) in triangles.iter().zip(&kernel).filter(|_| attempts == 1) {
            let [ab, bc] = [0, 1].map(|k| surface.halfedges[3 * triangle as usize + k].twin / 3);
            assert_ne!(ab, bc);
            assert_eq!(walker.triangle, ab, "from {triangle}: {bc} is behind BC");
        }
    }
    gpu.finish();
}

/// One step of one particle from a state, by kernels and twins: equal bits.
#[track_caller]
fn stepped(gpu: &Gpu, scene: &Scene, setup: &Setup, state: &Snapshot) -> (Particle, Motion) {
    let mut simulation = Simulation::from_setup(&gpu.ctx, scene, setup.clone()).unwrap();
    simulation.restore(state).unwrap();
    gpu.run(|rec| simulation.record_step(rec));
    let kernel = simulation.snapshot().unwrap();
    let mut twin = twin::Simulation::new(setup.clone(), scene.settings.clone());
    twin.restore(state);
    twin.step();
    let twin = twin.snapshot();
    assert_same_bits("particles", &kernel.particles, &twin.particles);
    assert_same_bits("motions", &kernel.motions, &twin.motions);
    assert_same_bits("trail", &kernel.trail, &twin.trail);
    (kernel.particles[0], kernel.motions[0])
}

/// Would alone catch: a strip that continues behind another edge where the way runs along one edge and through its end.
#[test]
fn a_way_along_an_edge_goes_through_its_end_as_ruled() {
    let Some(gpu) = gpu() else { return };
    let scene = scene("builtin:plane?columns=3&rows=5", |s| {
        s.particles.count = 1;
        s.atlas.size = 64;
        s.physarum.sensing = Sensing::Walk;
        s.physarum.edge_crossing_attempts = 1;
        s.physarum.speed = 0.8;
    });
    let setup = Setup::new(&scene).unwrap();
    let mut state = twin::Simulation::new(setup.clone(), scene.settings.clone()).snapshot();
    let mut walks = 0;
    for triangle in 0..setup.surface.triangles.len() as u32 {
        // To B, over BC; and to A, over CA.
        for (heading_p, halfedge) in [(1.0, 1), (-1.0, 2)] {
            let twin = setup.surface.halfedges[3 * triangle as usize + halfedge].twin;
            if twin == NONE {
                continue;
            }
            (state.particles[0].triangle, state.particles[0].u) = (triangle, 0.375);
            state.particles[0].v = 0.0;
            state.motions[0] = Motion {
                heading_p,
                heading_h: 0.0,
                pending: 0.0,
                flags: 0,
            };
            let (particle, _) = stepped(&gpu, &scene, &setup, &state);
            assert_eq!(particle.triangle, twin / 3, "from {triangle}: {particle:?}");
            walks += 1;
        }
    }
    assert!(walks > 20, "{walks}");
    gpu.finish();
}

/// Sensors at right angles to the way, over areas of one value each: what they read is exact.
///
/// Would alone catch: a particle that turns where left and right are equal and more than the middle, or where the middle is as
/// good as the better side.
#[test]
fn of_equal_sensor_readings_no_side_is_better() {
    let Some(gpu) = gpu() else { return };
    // Left, middle and right; which way it turns.
    let cases = [
        ([1.0, 0.0, 1.0], 0.0),
        ([1.0, 1.0, 1.0], 0.0),
        ([0.0, 0.0, 0.0], 0.0),
        ([1.0, 1.0, 0.0], 0.0),
        ([0.0, 1.0, 1.0], 0.0),
        ([1.0, 0.0, 0.0], 1.0),
        ([0.0, 0.0, 1.0], -1.0),
    ];
    for sensing in [Sensing::Auto, Sensing::Walk] {
        let scene = scene("builtin:plane?columns=2&rows=2", |s| {
            s.particles.count = 1;
            s.atlas.size = 128;
            s.physarum.sensing = sensing;
            s.physarum.sensor_offset = 0.4;
            s.physarum.sensor_angle = 90.0;
            s.physarum.rotation_angle = 90.0;
            s.physarum.speed = 0.01;
        });
        let setup = Setup::new(&scene).unwrap();
        let offset = f64::from(physarums(&scene.settings, &setup)[0].sensor_offset);
        let start = twin::Simulation::new(setup.clone(), scene.settings.clone()).snapshot();
        let place_of = |triangle: u32, u: f32, v: f32| {
            let corners = setup.surface.corners[triangle as usize];
            let [a, b, c] = corners.map(|v| setup.surface.positions[v as usize].as_dvec3());
            a + f64::from(u) * (b - a) + f64::from(v) * (c - a)
        };
        // About the middle of the plane.
        let triangle = (0..setup.surface.triangles.len() as u32)
            .find(|&t| place_of(t, 0.0, 0.0).length() < 1e-6)
            .expect("some triangle begins in the middle");
        let (u, v) = (0.0625, 0.0625);
        let here = place_of(triangle, u, v);
        let frame = Frame::of(&setup.surface, triangle);
        for (heading, along, left) in [
            ([1.0, 0.0], frame.p, frame.h),
            ([0.0, 1.0], frame.h, -frame.p),
            ([-1.0, 0.0], -frame.p, -frame.h),
        ] {
            for (values, turn) in cases {
                let mut state = start.clone();
                for (texel, value) in state.trail.iter_mut().enumerate() {
                    let Some((t, u, v)) = setup.atlas.surface_point_of(texel as u32) else {
                        continue;
                    };
                    let way = place_of(t, u, v) - here;
                    *value = if way.dot(along) > 0.5 * offset {
                        values[1]
                    } else if way.dot(left) > 0.0 {
                        values[0]
                    } else {
                        values[2]
                    };
                }
                twin::exchange_seams(&setup.atlas.seams, &mut state.trail);
                state.particles[0] = Particle {
                    triangle,
                    u,
                    v,
                    id: 0,
                };
                state.motions[0] = Motion {
                    heading_p: heading[0],
                    heading_h: heading[1],
                    pending: 0.0,
                    flags: 0,
                };
                let (particle, motion) = stepped(&gpu, &scene, &setup, &state);
                assert_eq!(particle.triangle, triangle, "the step is short");
                let what = format!("{sensing:?}, {heading:?}, {values:?}: {motion:?}");
                let [p, h] = heading;
                let expected = if turn == 0.0 {
                    [p, h]
                } else {
                    [-turn * h, turn * p]
                };
                let off = [
                    motion.heading_p - expected[0],
                    motion.heading_h - expected[1],
                ];
                if turn == 0.0 {
                    assert_eq!(off, [0.0; 2], "{what}");
                } else {
                    assert!(off.iter().all(|off| off.abs() < 1e-6), "{what}");
                }
            }
        }
    }
    gpu.finish();
}
