//! Nearest points, signs and crossings on one mesh: the kernel against its twin and against double precision.

use glam::{DVec3, Vec3};
use myxo::mesh::surface::{NONE, Surface};
use myxo::mesh::trees::Trees;
use myxo::mesh::trees::sides::Sides;
use myxo::mesh::{Mesh, suite};
use myxo::rng::{Purpose, random, unit};
use myxo::scene::settings::SignRule;
use myxo::sim::kernels::TreeQueriesParams;
use myxo::sim::tree_queries::{Question, tree_queries};
use myxo::sim::twin;
use myxo::sim::types::TreeQuery;

use super::reference::{Model, to_triangle};
use crate::common::{Gpu, gpu};

/// Closed meshes, those with spikes, knife edges and needles among them.
fn closed() -> Vec<Mesh> {
    let mut meshes: Vec<Mesh> = [
        "cube?divisions=3",
        "torus?major=24&minor=16",
        "icosphere?subdivisions=2",
    ]
    .map(|name| Mesh::builtin(name).unwrap())
    .into();
    meshes.extend(suite::closed());
    meshes.push(spike(0.02));
    meshes.push(spike(0.3));
    meshes.push(star());
    meshes
}

/// A needle: a pyramid that is much higher than wide.
fn spike(width: f32) -> Mesh {
    let v = Vec3::new;
    suite::mesh(
        "spike",
        &[
            v(width, 0.0, 0.0),
            v(0.0, 0.0, -width),
            v(-width, 0.0, 0.0),
            v(0.0, 0.0, width),
            v(0.1, 1.0, 0.05),
        ],
        &[
            [0, 1, 4],
            [1, 2, 4],
            [2, 3, 4],
            [3, 0, 4],
            [0, 2, 1],
            [0, 3, 2],
        ],
    )
}

/// A ball with every other vertex drawn out: spikes with creases between them.
fn star() -> Mesh {
    let mut mesh = Mesh::builtin("icosphere?subdivisions=1").unwrap();
    for (i, position) in mesh.positions.iter_mut().enumerate() {
        *position *= if i % 3 == 0 { 2.5 } else { 0.4 };
    }
    suite::mesh("star", &mesh.positions, &mesh.corners)
}

/// A corner that lies lower, along its own normal, than one beside it: the side is right only if it is computed from the
/// nearest corner itself.
fn crooked() -> Mesh {
    let v = Vec3::new;
    suite::mesh(
        "crooked",
        &[
            v(0.0, 0.0, 0.0),
            v(0.23, 0.58, -0.49),
            v(0.04, 0.94, -0.26),
            v(-0.04, 0.96, 0.42),
            v(-0.19, 1.06, -0.16),
            v(0.27, 0.52, -0.28),
        ],
        &[[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1]],
    )
}

/// Places in and round a mesh: anywhere, and close over faces, edges and corners, in any direction.
fn places(mesh: &Mesh, model: &Model, count: u32) -> Vec<Vec3> {
    (0..count)
        .map(|i| {
            let [a, b, c, _] = random(3, i, 0, Purpose::Start).map(|w| f64::from(unit(w)));
            let [d, e, f, g] = random(3, i, 1, Purpose::Start).map(|w| f64::from(unit(w)));
            let anywhere = 2.0 * DVec3::new(a, b, c) - 1.0;
            if i % 3 == 0 {
                return (model.centre + 1.2 * model.radius * anywhere).as_vec3();
            }
            let triangle = model.triangles[(d * mesh.corners.len() as f64) as usize];
            let [p, q, r] = triangle;
            let on = match i % 4 {
                0 => p,
                1 => p.lerp(q, e),
                _ => p + 0.5 * e * (q - p) + 0.5 * f * (r - p),
            };
            let away = [0.5, 0.1, 0.01, 1e-4][i as usize / 4 % 4] * g;
            (on + away * model.radius * anywhere.normalize_or_zero()).as_vec3()
        })
        .collect()
}

fn by_kernel(gpu: &Gpu, mesh: &Mesh, question: Question, queries: &mut [TreeQuery]) -> Trees {
    let surface = Surface::build(&[(mesh, 1.0)]);
    let trees = Trees::build(&surface);
    tree_queries(&gpu.ctx, &surface, &trees, question, queries).unwrap();
    trees
}

fn by_twin(mesh: &Mesh, question: Question, queries: &mut [TreeQuery]) {
    let surface = Surface::build(&[(mesh, 1.0)]);
    let trees = Trees::build(&surface);
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
        query_count: queries.len() as u32,
        root: trees.objects[0].first_node,
        first_vertex_normal,
    };
    twin::tree_queries(&question.constants(), &params, &sides, queries);
}

const RULES: [SignRule; 3] = [SignRule::Pseudonormal, SignRule::Winding, SignRule::Facing];

/// The twin answers the same to the bit.
#[test]
fn tree_queries_agrees_with_its_twin() {
    let Some(gpu) = gpu() else { return };
    let meshes = closed().into_iter().chain(suite::open());
    for mesh in meshes.chain([crooked()]) {
        let model = Model::of(&mesh);
        let places = places(&mesh, &model, 1021);
        let ends = places.iter().rev();
        let crossings = places
            .iter()
            .zip(ends)
            .map(|(&a, &b)| TreeQuery::crossing(a, b));
        let crossings: Vec<TreeQuery> = crossings.collect();
        let nearest: Vec<TreeQuery> = places.iter().map(|&p| TreeQuery::nearest(p)).collect();
        let mut questions = vec![(Question::Crossing, crossings)];
        questions.extend(RULES.map(|rule| (Question::Nearest(rule), nearest.clone())));
        for (question, asked) in questions {
            // At all sizes at which kernels break.
            for count in [0, 1, 63, 65, asked.len()] {
                let (mut kernel, mut twin) = (asked[..count].to_vec(), asked[..count].to_vec());
                by_kernel(&gpu, &mesh, question, &mut kernel);
                by_twin(&mesh, question, &mut twin);
                for (a, b) in kernel.iter().zip(&twin) {
                    assert_eq!(
                        bytemuck::bytes_of(a),
                        bytemuck::bytes_of(b),
                        "{}, {question:?}: {a:?} and {b:?}",
                        mesh.name
                    );
                }
            }
        }
    }
    gpu.finish();
}

/// Nearest triangles, distances and signs against double precision, where spikes and creases are too.
#[test]
fn distances_are_right_on_closed_meshes() {
    let Some(gpu) = gpu() else { return };
    let mut most_by_faces = 0.0_f64;
    for mesh in closed() {
        let model = Model::of(&mesh);
        let places = places(&mesh, &model, 3000);
        let truth = places.iter().map(|place| {
            let p = place.as_dvec3();
            (p, model.distance(p), model.winding(p))
        });
        let truth: Vec<(DVec3, f64, f64)> = truth.collect();
        for rule in [SignRule::Pseudonormal, SignRule::Winding] {
            let mut queries: Vec<TreeQuery> =
                places.iter().map(|&p| TreeQuery::nearest(p)).collect();
            let trees = by_kernel(&gpu, &mesh, Question::Nearest(rule), &mut queries);
            let mut errors = Vec::new();
            let (mut wrong, mut wrong_by_face, mut all) = (0, 0_u32, 0_u32);
            for (query, &(p, distance, winding)) in queries.iter().zip(&truth) {
                let got = f64::from(query.result);
                errors.push((got.abs() - distance).abs() / model.radius);
                let triangle = trees.faces[query.slot as usize].triangle;
                let of_triangle = to_triangle(p, model.triangles[triangle as usize]);
                assert!(
                    of_triangle - distance < 1e-6 * model.radius,
                    "{}: {p} has the nearest triangle at {of_triangle} and not {distance}",
                    mesh.name
                );
                let decided = (winding - winding.round()).abs() < 1e-3;
                if distance > 2e-6 * model.radius && decided {
                    let is_inside = winding.round() != 0.0;
                    let [a, b, c] = model.triangles[triangle as usize];
                    let is_behind_face = (b - a).cross(c - a).dot(p - a) < 0.0;
                    wrong += usize::from(is_inside != (got < 0.0));
                    wrong_by_face += u32::from(is_inside != is_behind_face);
                    all += 1;
                }
            }
            most_by_faces = most_by_faces.max(f64::from(wrong_by_face) / f64::from(all));
            errors.sort_by(f64::total_cmp);
            let at_99 = errors[errors.len() * 99 / 100];
            assert!(at_99 < 1e-5 / 3.0, "{}: {at_99}", mesh.name);
            assert_eq!(wrong, 0, "{}, {rule:?}: wrong signs", mesh.name);
        }
    }
    // The places are such that the nearest face alone would give wrong signs.
    assert!(most_by_faces > 0.1, "{most_by_faces}");
    gpu.finish();
}

/// Near the centre of a fine ball all faces are about as near, so a search looks at most of them, for longer than some
/// devices let a loop run. The answers are right all the same, whichever other places share the subgroup.
#[test]
fn distances_are_right_in_the_middle_of_fine_meshes() {
    let Some(gpu) = gpu() else { return };
    for subdivisions in [5, 6] {
        let mesh = Mesh::builtin(&format!("icosphere?subdivisions={subdivisions}")).unwrap();
        let model = Model::of(&mesh);
        let places: Vec<Vec3> = (0..16)
            .map(|i| {
                let [x, y, z, _] = random(9, i, 0, Purpose::Start).map(|word| unit(word) - 0.5);
                0.12 * (i as f32 / 15.0) * Vec3::new(x, y, z).normalize_or_zero()
            })
            .collect();
        for rule in RULES {
            let question = Question::Nearest(rule);
            let mut together: Vec<TreeQuery> =
                places.iter().map(|&p| TreeQuery::nearest(p)).collect();
            let trees = by_kernel(&gpu, &mesh, question, &mut together);
            for query in &together {
                let p = query.place.as_dvec3();
                let distance = model.distance(p);
                let got = f64::from(query.result);
                assert!(
                    (got + distance).abs() < 1e-6 * model.radius,
                    "{subdivisions}, {rule:?}, {p}: {got} and not {}",
                    -distance
                );
                let triangle = trees.faces[query.slot as usize].triangle;
                let of_triangle = to_triangle(p, model.triangles[triangle as usize]);
                assert!(of_triangle - distance < 1e-6 * model.radius);
            }
            let mut alone = [TreeQuery::nearest(places[9])];
            by_kernel(&gpu, &mesh, question, &mut alone);
            assert_eq!(alone[0].slot, together[9].slot);
            assert_eq!(alone[0].result, together[9].result);
        }
    }
    gpu.finish();
}

/// What other rules get wrong, so that it is clear why they are not the default.
#[test]
fn facing_is_wrong_in_creases_and_winding_right_beside_holes() {
    let Some(gpu) = gpu() else { return };
    let wrong_signs = |mesh: &Mesh, whole: &Mesh, rule, from: f64| {
        let model = Model::of(whole);
        let places = places(whole, &model, 3000);
        let mut queries: Vec<TreeQuery> = places.iter().map(|&p| TreeQuery::nearest(p)).collect();
        by_kernel(&gpu, mesh, Question::Nearest(rule), &mut queries);
        let wrong = queries.iter().filter(|query| {
            let p = query.place.as_dvec3();
            model.distance(p) > from * model.radius
                && (model.winding(p) > 0.5) != (query.result < 0.0)
        });
        wrong.count()
    };
    let star = star();
    assert_eq!(wrong_signs(&star, &star, SignRule::Pseudonormal, 1e-5), 0);
    assert!(wrong_signs(&star, &star, SignRule::Facing, 1e-5) > 0);
    // A ball without one of its triangles.
    let ball = Mesh::builtin("icosphere?subdivisions=3").unwrap();
    let holed = suite::mesh("holed", &ball.positions, &ball.corners[1..]);
    // In the hole, inside and outside are undefined.
    assert_eq!(wrong_signs(&holed, &ball, SignRule::Winding, 0.06), 0);
    gpu.finish();
}

/// Segments that cross nothing, one triangle or many, against double precision.
#[test]
fn first_crossings_are_right() {
    let Some(gpu) = gpu() else { return };
    let meshes = closed().into_iter().chain(suite::open());
    // The planes of needles are known to too few digits.
    for mesh in meshes.filter(|mesh| mesh.name != "slivers") {
        let model = Model::of(&mesh);
        let places = places(&mesh, &model, 4000);
        let segments = places.chunks_exact(2);
        let mut queries: Vec<TreeQuery> = segments
            .map(|ends| TreeQuery::crossing(ends[0], ends[1]))
            .collect();
        by_kernel(&gpu, &mesh, Question::Crossing, &mut queries);
        let mut crossed = 0;
        let mut doubtful = 0;
        for query in &queries {
            let (from, to) = (query.place.as_dvec3(), query.end.as_dvec3());
            let (expected, doubt) = model.crossing(from, to);
            if doubt < 1e-5 {
                doubtful += 1;
                continue;
            }
            let found = (query.slot != NONE).then_some(f64::from(query.result));
            match (expected, found) {
                (None, None) => (),
                (Some((t, sine)), Some(s)) => {
                    crossed += 1;
                    // Off the plane, not along it.
                    let off = sine * (t - s).abs() * from.distance(to) / model.radius;
                    assert!(off < 1e-5, "{}: {t}, {s}, off by {off}", mesh.name);
                }
                _ => panic!("{}: {expected:?}, found {found:?}", mesh.name),
            }
        }
        assert!(crossed > 50, "{}: {crossed} crossings", mesh.name);
        assert!(doubtful * 4 < queries.len(), "{}: {doubtful}", mesh.name);
    }
    gpu.finish();
}
