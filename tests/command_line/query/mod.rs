//! `myxo query geodesic` and `myxo query atlas`: accuracy against double precision and closed forms, and the numbering of files.

mod atlas;
mod sdf;
mod straight;
mod transfer;

use std::f64::consts::{FRAC_PI_2, TAU};
use std::path::{Path, PathBuf};
use std::process::Command;

use glam::{DMat3, DQuat, DVec2, DVec3, Vec3};
use myxo::mesh::{Mesh, suite};
use myxo::rng::{Purpose, random};
use straight::Model;

/// A row of the input.
#[derive(Clone, Copy)]
struct Walk {
    face: usize,
    weights: [f64; 3],
    direction: DVec3,
    length: f64,
}

/// A row of the output.
#[derive(Debug)]
struct Answer {
    face: usize,
    weights: [f64; 3],
    position: DVec3,
    direction: DVec3,
    travelled: f64,
    status: u32,
}

/// Runs the program. `None` without a device, where that is allowed.
fn ask(mesh: &Path, walks: &[Walk]) -> Option<Vec<Answer>> {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in.csv"), folder.path().join("out.csv"));
    let mut text = "id,face,b0,b1,b2,dx,dy,dz,length\n".to_owned();
    for (id, walk) in walks.iter().enumerate() {
        let ([b0, b1, b2], d) = (walk.weights, walk.direction);
        text += &format!(
            "{id},{},{b0},{b1},{b2},{},{},{},{}\n",
            walk.face, d.x, d.y, d.z, walk.length
        );
    }
    std::fs::write(&input, text).unwrap();
    let run = Command::new(env!("CARGO_BIN_EXE_myxo"))
        .args(["query", "geodesic", "--validate"])
        .args(["--mesh".as_ref(), mesh.as_os_str()])
        .args(["--in".as_ref(), input.as_os_str()])
        .args(["--out".as_ref(), output.as_os_str()])
        .output()
        .unwrap();
    let messages = String::from_utf8_lossy(&run.stderr);
    if messages.contains("no Vulkan") && std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() {
        eprintln!("skipped: {messages}");
        return None;
    }
    assert!(run.status.success(), "{messages}");
    assert_eq!(messages, "", "nothing is refused");
    let text = std::fs::read_to_string(output).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("id,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status")
    );
    let answers: Vec<Answer> = lines
        .enumerate()
        .map(|(id, line)| {
            let fields: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
            assert!(fields.len() == 13 && fields.iter().all(|x| x.is_finite()));
            assert_eq!(fields[0], id as f64);
            Answer {
                face: fields[1] as usize,
                weights: [fields[2], fields[3], fields[4]],
                position: DVec3::from_slice(&fields[5..]),
                direction: DVec3::from_slice(&fields[8..]),
                travelled: fields[11],
                status: fields[12] as u32,
            }
        })
        .collect();
    assert_eq!(answers.len(), walks.len());
    Some(answers)
}

/// Random places, uniform over the triangles, and directions.
fn random_walks(model: &Model, count: u32, length: f64) -> Vec<Walk> {
    let walk = |id| {
        let words = random(1234, id, 0, Purpose::Start).map(|w| f64::from(w) / 4_294_967_296.0);
        let face = (words[0] * model.triangles.len() as f64) as usize;
        let (mut u, mut v) = (words[1], words[2]);
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        let [a, b, _] = model.corners(face);
        let along = (b - a).normalize();
        let (sin, cos) = (TAU * words[3]).sin_cos();
        Walk {
            face,
            weights: [1.0 - u - v, u, v],
            direction: cos * along + sin * model.normal(face).cross(along),
            length,
        }
    };
    (0..count).map(walk).collect()
}

/// The results for one model, errors in radii and degrees.
struct Measured {
    errors: Vec<f64>,
    /// The walks that come near no vertex.
    worst: f64,
    worst_angle: f64,
    wrong_faces: Vec<String>,
    near_vertex: usize,
    crossings: u64,
}

fn measure(model: &Model, walks: &[Walk], answers: &[Answer]) -> Measured {
    let radius = model.radius();
    let mut measured = Measured {
        errors: Vec::new(),
        worst: 0.0,
        worst_angle: 0.0,
        wrong_faces: Vec::new(),
        near_vertex: 0,
        crossings: 0,
    };
    for (id, (walk, answer)) in walks.iter().zip(answers).enumerate() {
        let end = model.walk(walk.face, walk.weights, walk.direction, walk.length);
        let sum: f64 = answer.weights.iter().sum();
        assert!((sum - 1.0).abs() < 1e-9 && answer.weights.iter().all(|&w| w >= 0.0));
        let rounding = 1e-9 * answer.position.length().max(radius);
        assert!(
            model
                .point(answer.face, answer.weights)
                .distance(answer.position)
                < rounding,
            "walk {id}: the weights and the position are not of one point"
        );
        let error = answer.position.distance(end.position) / radius;
        measured.errors.push(error);
        measured.crossings += u64::from(end.crossings);
        if end.nearest_vertex < 1e-3 {
            measured.near_vertex += 1;
            continue;
        }
        measured.worst = measured.worst.max(error);
        assert_eq!(answer.status == 1, end.at_border, "walk {id}");
        assert!(
            (answer.travelled - end.travelled).abs() < 2e-5 * radius,
            "walk {id}: {} travelled, and {} is right",
            answer.travelled,
            end.travelled
        );
        assert!((answer.direction.length() - 1.0).abs() < 1e-9);
        assert!(answer.direction.dot(model.normal(answer.face)).abs() < 1e-6);
        if answer.face == end.face {
            // Not by the dot product, which is inexact for small angles.
            let angle = answer.direction.cross(end.direction).length().asin();
            measured.worst_angle = measured.worst_angle.max(angle.to_degrees());
            assert!(answer.direction.dot(end.direction) > 0.0, "walk {id}");
        } else if model.to_edge(end.face, end.position) > 1.01 * error * radius + 1e-12 * radius {
            measured.wrong_faces.push(format!(
                "walk {id}: face {} for {}, {error:e} radii off",
                answer.face, end.face
            ));
        }
    }
    measured.errors.sort_by(f64::total_cmp);
    measured
}

/// A mesh as an OBJ file in a folder, and its triangles.
fn obj(folder: &Path, mesh: &Mesh) -> (String, PathBuf, Model) {
    let path = folder.join(format!("{}.obj", mesh.name.replace(['?', '&', '/'], " ")));
    std::fs::write(&path, suite::obj_text(mesh, mesh.name.contains("sphere"))).unwrap();
    let model = Model::new(&mesh.positions, mesh.corners.clone());
    (mesh.name.clone(), path, model)
}

/// A model of the repository, with the triangles as in its file.
fn asset(name: &str) -> (String, PathBuf, Model) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("assets/{name}.glb"));
    let mesh = Mesh::load_raw(&path).unwrap();
    assert!((0..).zip(&mesh.file_triangle).all(|(t, &file)| t == file));
    let corners = mesh.corners.iter().zip(&mesh.file_corners);
    let in_file_order = |(ours, file): (&[u32; 3], &[u8; 3])| {
        let mut corners = [0; 3];
        for k in 0..3 {
            corners[usize::from(file[k])] = ours[k];
        }
        corners
    };
    let triangles = corners.map(in_file_order).collect();
    (
        name.to_owned(),
        path,
        Model::new(&mesh.positions, triangles),
    )
}

fn builtin(name: &str) -> Mesh {
    let mut mesh = Mesh::builtin(name).unwrap();
    name.clone_into(&mut mesh.name);
    mesh
}

/// A small, bumpy sphere that is far from the origin relative to its size.
fn far_potato() -> Mesh {
    let mesh = suite::potato();
    let positions: Vec<_> = mesh
        .positions
        .iter()
        .map(|&p| 1e-3 * p + Vec3::new(0.3, -0.1, 0.2))
        .collect();
    suite::mesh("far potato", &positions, &mesh.corners)
}

#[test]
fn walks_of_three_radii_agree_with_double_precision() {
    let folder = tempfile::tempdir().unwrap();
    let mut models: Vec<_> = [
        builtin("cube"),
        builtin("torus"),
        builtin("icosphere"),
        suite::potato(),
        far_potato(),
        builtin("torus?major=350&minor=200"),
        suite::slivers(),
        suite::bipyramid(1000),
        suite::tube(12, 5),
        builtin("torus?major=3&minor=2000"),
        builtin("torus?major=4000&minor=3&tube=0.1"),
    ]
    .iter()
    .map(|mesh| obj(folder.path(), mesh))
    .collect();
    models.extend(["suzanne", "beaded_trefoil", "gyroid_ball", "hand_animated"].map(asset));
    let mut problems = Vec::new();
    for (name, path, model) in &models {
        let walks = random_walks(model, 1000, 3.0 * model.radius());
        let Some(answers) = ask(path, &walks) else {
            return;
        };
        let m = measure(model, &walks, &answers);
        let (median, p99) = (m.errors[500], m.errors[990]);
        println!(
            "{name:34} {:7} triangles, skewness {:7.1}, {:5} crossings: median {median:.1e}, 99 % {p99:.1e}, \
             max {:.1e}; {} pass a vertex, of the others max {:.1e}, {:.1e} degrees, {} wrong faces",
            model.triangles.len(),
            model.skewness(),
            m.crossings / 1000,
            m.errors[999],
            m.near_vertex,
            m.worst,
            m.worst_angle,
            m.wrong_faces.len(),
        );
        if !(median < 1e-6 && p99 < 2e-5 && m.worst_angle < 0.01 && m.wrong_faces.is_empty()) {
            problems.push(format!(
                "{name}: median {median:e}, 99 % {p99:e}, directions {} degrees, wrong faces {:?}",
                m.worst_angle, m.wrong_faces
            ));
        }
    }
    assert!(problems.is_empty(), "{}", problems.join("\n"));
}

/// The worked example of the format.
#[test]
fn the_square_is_walked_as_by_hand() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("square.obj");
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
    std::fs::write(&path, text).unwrap();
    let lengths = [0.45, 0.6, 2.0];
    let walks = lengths.map(|length| Walk {
        face: 0,
        weights: [0.25, 0.5, 0.25],
        direction: DVec3::Y,
        length,
    });
    let Some(answers) = ask(&path, &walks) else {
        return;
    };
    let expected = [
        (0, [0.25, 0.05, 0.7], 0.7, 0.45, 0),
        (1, [0.15, 0.75, 0.1], 0.85, 0.6, 0),
        (1, [0.0, 0.75, 0.25], 1.0, 0.75, 1),
    ];
    for (answer, (face, weights, y, travelled, status)) in answers.iter().zip(expected) {
        assert_eq!((answer.face, answer.status), (face, status));
        for (found, weight) in answer.weights.into_iter().zip(weights) {
            assert!((found - weight).abs() < 2e-7, "{answer:?}");
        }
        assert!(answer.position.distance(DVec3::new(0.75, y, 0.0)) < 2e-7);
        assert!(answer.direction.distance(DVec3::Y) < 1e-9);
        assert!((answer.travelled - travelled).abs() < 2e-7);
    }
    assert_eq!(answers[2].weights[0], 0.0, "it stops on the border itself");
}

/// On a plane, however it is cut into triangles, a straight walk is a straight line.
#[test]
fn walks_on_a_plane_are_straight_lines() {
    let folder = tempfile::tempdir().unwrap();
    let plane = builtin("plane?columns=40&rows=30");
    let tilt = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, 1.1, -0.6);
    let inside = |p: Vec3| p.x.abs() < 0.99 && p.z.abs() < 0.99;
    let moved = |(vertex, &p): (u32, &Vec3)| {
        let [x, z, ..] = random(8, vertex, 0, Purpose::Start).map(|w| f64::from(w) / 4.3e9 - 0.5);
        let shift = if inside(p) { 0.02 } else { 0.0 };
        (tilt * (p.as_dvec3() + shift * DVec3::new(x, 0.0, z))).as_vec3()
    };
    let positions: Vec<_> = (0..).zip(&plane.positions).map(moved).collect();
    let mesh = suite::mesh("plane", &positions, &plane.corners);
    let (_, path, model) = obj(folder.path(), &mesh);
    let walks = random_walks(&model, 500, 1.0);
    let Some(answers) = ask(&path, &walks) else {
        return;
    };
    let mut stopped = 0;
    for (id, (walk, answer)) in walks.iter().zip(&answers).enumerate() {
        let start = model.point(walk.face, walk.weights);
        let expected = start + answer.travelled * walk.direction;
        // Rounding the corners to float32 leaves the plane a little rough.
        assert!(answer.position.distance(expected) < 2e-6, "walk {id}");
        assert!(
            answer.direction.distance(walk.direction) < 1e-4,
            "walk {id}"
        );
        let flat = tilt.inverse() * answer.position;
        let to_border = 1.0 - flat.x.abs().max(flat.z.abs());
        assert_eq!(answer.status == 1, answer.travelled < 1.0, "walk {id}");
        if answer.status == 1 {
            stopped += 1;
            assert!(to_border.abs() < 1e-6, "walk {id} stops {to_border} inside");
        }
    }
    assert!((100..400).contains(&stopped), "{stopped} of 500 stop");
}

/// Walks along edges: rounding must not make them alternate between the two triangles forever.
#[test]
fn walks_along_edges_get_to_their_ends() {
    let folder = tempfile::tempdir().unwrap();
    for mesh in [suite::potato(), suite::slivers(), suite::bipyramid(100)] {
        let (_, path, model) = obj(folder.path(), &mesh);
        let walk = |halfedge: usize| {
            let (face, k) = (halfedge / 3, halfedge % 3);
            let corners = model.corners(face);
            let along = corners[(k + 1) % 3] - corners[k];
            let mut weights = [0.0; 3];
            (weights[k], weights[(k + 1) % 3]) = (0.75, 0.25);
            Walk {
                face,
                weights,
                direction: along.normalize(),
                length: 0.5 * along.length(),
            }
        };
        let walks: Vec<Walk> = (0..3 * model.triangles.len()).map(walk).collect();
        let Some(answers) = ask(&path, &walks) else {
            return;
        };
        for (id, (walk, answer)) in walks.iter().zip(&answers).enumerate() {
            let start = model.point(walk.face, walk.weights);
            let off = answer
                .position
                .distance(start + walk.length * walk.direction);
            assert!(
                answer.status == 0 && off < 1e-6,
                "{}, walk {id}: {off} from its end, status {}",
                mesh.name,
                answer.status
            );
        }
    }
}

/// A straight walk on a cube is the trace of rolling the cube over a plane.
#[test]
fn walks_on_a_cube_are_rolling_it() {
    let folder = tempfile::tempdir().unwrap();
    let (_, path, model) = obj(folder.path(), &builtin("cube?divisions=3"));
    let from = DVec2::new(0.11, 0.23);
    let weights_at = |face: usize| {
        let [a, b, c] = model.corners(face).map(DVec3::truncate);
        let area = (b - a).perp_dot(c - a);
        let v = (b - a).perp_dot(from - a) / area;
        let u = (from - a).perp_dot(c - a) / area;
        [1.0 - u - v, u, v]
    };
    let on_top = |face: &usize| model.corners(*face).iter().all(|p| p.z == 1.0);
    let holds_it = |face: &usize| weights_at(*face).iter().all(|&w| w >= 0.0);
    let mut top = (0..model.triangles.len()).filter(on_top);
    let face = top.find(holds_it).unwrap();
    let walks: Vec<Walk> = (0..300)
        .map(|id| Walk {
            face,
            weights: weights_at(face),
            direction: DVec2::from_angle(TAU * f64::from(id) / 300.0 + 0.001).extend(0.0),
            length: 0.3 + 0.05 * f64::from(id),
        })
        .collect();
    let Some(answers) = ask(&path, &walks) else {
        return;
    };
    for (walk, answer) in walks.iter().zip(&answers) {
        let mut cube_from_plane = DMat3::IDENTITY;
        let mut centre = DVec2::ZERO;
        let heading = walk.direction.truncate();
        loop {
            let exits = [DVec2::X, -DVec2::X, DVec2::Y, -DVec2::Y].map(|side| {
                let speed = heading.dot(side);
                let way = (1.0 - (from - centre).dot(side)) / speed;
                (if speed > 0.0 { way } else { f64::INFINITY }, side)
            });
            let (way, side) = exits
                .into_iter()
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .unwrap();
            if way >= walk.length {
                break;
            }
            // The plane lies on the cube: rolling to one side brings that side's face up.
            let axis = DVec3::new(side.y, -side.x, 0.0);
            cube_from_plane *= DMat3::from_axis_angle(axis, -FRAC_PI_2);
            centre += 2.0 * side;
        }
        let flat = from + walk.length * heading - centre;
        let expected = cube_from_plane * flat.extend(1.0);
        let off = answer.position.distance(expected);
        assert!(off < 3e-6, "length {}: {off}", walk.length);
        let turned = answer.direction.distance(cube_from_plane * walk.direction);
        assert!(turned < 1e-6, "length {}: {turned}", walk.length);
    }
}
