//! `myxo query sdf`: what comes out for places whose distances are known.

use std::path::Path;
use std::process::{Command, Output};

use glam::{DAffine3, DMat4, DQuat, DVec3};

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

#[test]
fn what_is_wrong_with_a_scene_is_named() {
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
        DAffine3::from_scale(DVec3::new(1.0, 1.0, 2.0)),
    );
    assert!(refusal().contains("b_transform_row_major is not a rotation"));
}
