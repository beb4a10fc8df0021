//! `myxo query sdf`: its answers for places whose distances are known.

use std::path::Path;
use std::process::{Command, Output};

use glam::{DAffine3, DMat4, DQuat, DVec3};
use myxo::mesh::Mesh;
use myxo::rng::{Purpose, random, unit};

fn run(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_myxo"))
        .current_dir(folder)
        .args(["query", "sdf", "--validate", "--scene", "scene.json"])
        .args(arguments)
        .output()
        .unwrap()
}

/// `None` without a device, where that is allowed.
fn answers(folder: &Path, arguments: &[&str]) -> Option<Vec<Vec<f64>>> {
    let output = run(folder, arguments);
    let messages = String::from_utf8_lossy(&output.stderr);
    if messages.contains("no Vulkan") && std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() {
        eprintln!("skipped: {messages}");
        return None;
    }
    assert!(output.status.success(), "{messages}");
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("id,sd,face,qx,qy,qz"));
    let numbers = |line: &str| {
        line.split(',')
            .map(|field| field.parse().unwrap())
            .collect()
    };
    Some(lines.map(numbers).collect())
}

fn rows(transform: DAffine3) -> Vec<f64> {
    DMat4::from(transform).transpose().to_cols_array().to_vec()
}

fn write_scene(folder: &Path, mesh_b: &str, world_from_b: DAffine3) {
    let scene = serde_json::json!({
        "mesh_a": "builtin:cube",
        "mesh_b": mesh_b,
        "a_transform_row_major": rows(DAffine3::IDENTITY),
        "b_transform_row_major": rows(world_from_b),
        "remark": "passed over",
    });
    std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
}

/// A box of 2 x 2 x 2 far from the origin, turned and moved: distance, side, face and nearest point.
#[test]
fn distances_to_a_box_are_those_of_the_box() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let far = DVec3::new(4096.0, -2048.0, 1024.0);
    let mut obj = String::new();
    for i in 0..8 {
        let corner = |bit: i32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let v = far + DVec3::new(corner(0), corner(1), corner(2));
        obj += &format!("v {} {} {}\n", v.x, v.y, v.z);
    }
    // Quads by their outward normals: -z, +z, -y, +y, -x, +x; each makes two triangles.
    obj += "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::write(folder.join("box.obj"), obj).unwrap();
    let rotation = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 1.1);
    let world_from_b = DAffine3::from_rotation_translation(rotation, DVec3::new(0.3, 0.1, -0.2));
    write_scene(folder, "box.obj", world_from_b);

    let mut places = Vec::new();
    for x in -4..=4 {
        for y in -4..=4 {
            for z in -4..=4 {
                let step = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                places.push(0.413 * step + DVec3::new(0.01, -0.02, 0.03));
            }
        }
    }
    let mut text = "py,id,px,pz,face\n".to_owned();
    for (id, place) in places.iter().enumerate() {
        let p = world_from_b.transform_point3(far + *place);
        text += &format!("{},{id},{},{},0\n", p.y, p.x, p.z);
    }
    std::fs::write(folder.join("in.csv"), text).unwrap();
    for rule in ["pseudonormal", "winding"] {
        let Some(answers) = answers(folder, &["--in", "in.csv", "--sign", rule]) else {
            return;
        };
        assert_eq!(answers.len(), places.len());
        for (answer, place) in answers.iter().zip(&places) {
            let outside = place.abs() - DVec3::ONE;
            let expected = outside.max(DVec3::ZERO).length() + outside.max_element().min(0.0);
            assert!(
                (answer[1] - expected).abs() < 1e-6,
                "{place}: {answer:?}, {expected}"
            );
            let q = DVec3::new(answer[3], answer[4], answer[5]);
            let q = world_from_b.inverse().transform_point3(q) - far;
            assert!((q.distance(*place) - expected.abs()).abs() < 1e-5);
            // The face's normal is the axis on which the nearest point is farthest out.
            let (axis, sign) = [
                (2, -1.0),
                (2, 1.0),
                (1, -1.0),
                (1, 1.0),
                (0, -1.0),
                (0, 1.0),
            ][answer[2] as usize / 2];
            assert!(
                (sign * q[axis] - 1.0).abs() < 1e-5,
                "{place}: face {}, {q}",
                answer[2]
            );
        }
    }
}

/// Would catch: an id that needs quotes and is written without them, so that its row has other columns or becomes a comment.
#[test]
fn ids_are_read_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_scene(folder, "builtin:cube", DAffine3::IDENTITY);
    let ids = ["\"a,\"\"b\"\"\"", "\"#1\"", "c d"];
    let rows = ids.map(|id| format!("{id},0,0,9\n")).concat();
    std::fs::write(folder.join("in.csv"), format!("id,px,py,pz\n{rows}")).unwrap();
    let output = run(folder, &["--in", "in.csv"]);
    let messages = String::from_utf8_lossy(&output.stderr);
    if messages.contains("no Vulkan") && std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() {
        eprintln!("skipped: {messages}");
        return;
    }
    assert!(output.status.success(), "{messages}");
    let text = String::from_utf8(output.stdout).unwrap();
    let lines: Vec<&str> = text.lines().skip(1).collect();
    assert_eq!(lines.len(), ids.len(), "{text}");
    for (line, id) in lines.iter().zip(ids) {
        let rest = line.strip_prefix(id).unwrap_or_default();
        assert_eq!(rest.matches(',').count(), 5, "{line}");
    }
}

fn to_triangle(place: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_segment = |a: DVec3, b: DVec3| {
        let t = ((place - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        place.distance(a + t * (b - a))
    };
    let normal = (b - a).cross(c - a).normalize();
    let is_over = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|&(from, to)| normal.cross(to - from).dot(place - from) >= 0.0);
    if is_over {
        return (place - a).dot(normal).abs();
    }
    to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a))
}

/// Every place gets its row, in the same order, however far away it is; and as many digits as double precision has.
#[test]
fn places_are_answered_from_however_far() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Inside of the facets, or outside of the ball that they approximate.
    let is_within = |radius: f64, inner: f64, outer: f64| match radius {
        radius if radius < inner => Some(true),
        radius if radius > outer => Some(false),
        _ => None,
    };
    for name in [
        "builtin:torus?major=24&minor=16",
        "builtin:icosphere?subdivisions=2",
        "builtin:plane?columns=5&rows=3",
    ] {
        let mesh = Mesh::builtin(name).unwrap();
        let position = |corner: u32| mesh.positions[corner as usize].as_dvec3();
        let triangles: Vec<_> = mesh.corners.iter().map(|c| c.map(position)).collect();
        let (low, high) = mesh.bounds();
        let diagonal = low.as_dvec3().distance(high.as_dvec3());
        let rotation = DQuat::from_axis_angle(DVec3::new(-1.0, 0.4, 0.7).normalize(), 2.3);
        let world_from_b =
            DAffine3::from_rotation_translation(rotation, DVec3::new(5.0, 3.0, -1.0));
        write_scene(folder, name, world_from_b);

        let mut places = Vec::new();
        for i in 0..40 {
            let [a, b, c, _] = random(8, i, 0, Purpose::Start).map(|w| f64::from(unit(w)) - 0.5);
            let direction = DVec3::new(a, b, c).normalize();
            for far in [
                0.05, 0.2, 0.25, 0.7, 3.9, 4.1, 30.0, 1e3, 1e5, 1.1e5, 1e6, 1e7, 1e12, 1e16, 1e100,
            ] {
                places.push((far, diagonal * far * direction));
            }
        }
        let mut text = "id,px,py,pz\n".to_owned();
        for (id, (_, place)) in places.iter().enumerate() {
            let p = world_from_b.transform_point3(*place);
            text += &format!("{id},{},{},{}\n", p.x, p.y, p.z);
        }
        std::fs::write(folder.join("in.csv"), text).unwrap();
        for rule in ["pseudonormal", "winding"] {
            let Some(answers) = answers(folder, &["--in", "in.csv", "--sign", rule]) else {
                return;
            };
            assert_eq!(answers.len(), places.len());
            for (id, (answer, &(far, place))) in answers.iter().zip(&places).enumerate() {
                assert_eq!(answer[0], id as f64);
                let distances = triangles
                    .iter()
                    .map(|&triangle| to_triangle(place, triangle));
                let distance = distances.fold(f64::INFINITY, f64::min);
                // The rounding of the answer itself, of the faces' single precision, and of such large coordinates.
                let rounding = diagonal * (1e-6 + 1e-15 * far);
                assert!(
                    (answer[1].abs() - distance).abs() < rounding,
                    "{name}, {far} diagonals, {rule}: {answer:?}, {distance}"
                );
                let is_inside = match name.split(['?', ':']).nth(1) {
                    Some("icosphere") => is_within(place.length(), 0.9, 1.0),
                    Some("torus") => {
                        let to_ring = place.x.hypot(place.z) - 1.0;
                        is_within(to_ring.hypot(place.y), 0.36, 0.4)
                    }
                    // A sheet has a lower side: pseudonormals find it from far away, winding numbers do not.
                    _ => Some(rule == "pseudonormal" && place.y < 0.0),
                };
                assert!(
                    is_inside.is_none_or(|is_inside| is_inside == (answer[1] < 0.0)),
                    "{name}, {far} diagonals, {rule}: {answer:?}"
                );
                // The point lies on the named face, and no point is nearer.
                let q = DVec3::new(answer[3], answer[4], answer[5]);
                let q = world_from_b.inverse().transform_point3(q);
                assert!(to_triangle(q, triangles[answer[2] as usize]) < rounding);
                assert!((q.distance(place) - distance).abs() < rounding);
            }
        }
    }
}

#[test]
fn errors_of_a_scene_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("in.csv"), "id,px,py,pz\n0,0,0,0\n").unwrap();
    let refusal = || {
        let output = run(folder, &["--in", "in.csv"]);
        assert!(!output.status.success());
        String::from_utf8(output.stderr).unwrap()
    };
    assert!(refusal().contains("scene.json"));
    std::fs::write(folder.join("scene.json"), "{\"mesh_a\": \"a.obj\"}").unwrap();
    assert!(refusal().contains("mesh_b"));
    write_scene(folder, "nowhere.obj", DAffine3::IDENTITY);
    assert!(refusal().contains("nowhere.obj"));
    write_scene(
        folder,
        "builtin:cube",
        DAffine3::from_rotation_x(0.25 * std::f64::consts::PI),
    );
    std::fs::write(
        folder.join("in.csv"),
        "id,px,py,pz\n0,0,0,0\n1,0,-1.7e308,1.7e308\n",
    )
    .unwrap();
    assert!(
        refusal()
            .contains("in.csv: line 3: the place is too far away for its distance to be a number")
    );
    write_scene(
        folder,
        "builtin:cube",
        DAffine3::from_scale(DVec3::new(1.0, 1.0, 2.0)),
    );
    assert!(refusal().contains("b_transform_row_major is not a rotation"));
}
