//! `myxo query transfer`: walks whose folds can be worked out.

use std::path::Path;
use std::process::{Command, Output};

use glam::{DAffine3, DMat4, DQuat, DVec2, DVec3};

fn run(folder: &Path, input: &str) -> Output {
    std::fs::write(folder.join("in.csv"), input).unwrap();
    Command::new(env!("CARGO_BIN_EXE_myxo"))
        .current_dir(folder)
        .args(["query", "transfer", "--validate", "--scene", "scene.json"])
        .args(["--in", "in.csv"])
        .output()
        .unwrap()
}

const HEADER: &str = "id,face,b0,b1,b2,dx,dy,dz,length\n";

/// `None` without a device, where that is allowed.
fn answers(folder: &Path, rows: &str) -> Option<Vec<Vec<f64>>> {
    let output = run(folder, &format!("{HEADER}{rows}"));
    let messages = String::from_utf8_lossy(&output.stderr);
    if messages.contains("no Vulkan") && std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() {
        eprintln!("skipped: {messages}");
        return None;
    }
    assert!(output.status.success(), "{messages}");
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("id,mesh,face,b0,b1,b2,px,py,pz,dx,dy,dz,travelled,status")
    );
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

fn write_scene(folder: &Path, meshes: [&str; 2], poses: [DAffine3; 2]) {
    let scene = serde_json::json!({
        "mesh_a": meshes[0],
        "mesh_b": meshes[1],
        "a_transform_row_major": rows(poses[0]),
        "b_transform_row_major": rows(poses[1]),
    });
    std::fs::write(folder.join("scene.json"), scene.to_string()).unwrap();
}

/// A square of 2 x 2 in X and Y with its normal along Z, in 8 x 8 quads, and the same far from the origin.
fn write_square(path: &Path, middle: DVec3) {
    let mut obj = String::new();
    for y in 0..9 {
        for x in 0..9 {
            let v = middle + DVec3::new(f64::from(x) / 4.0 - 1.0, f64::from(y) / 4.0 - 1.0, 0.0);
            obj += &format!("v {} {} {}\n", v.x, v.y, v.z);
        }
    }
    for y in 0..8 {
        for x in 0..8 {
            let first = 9 * y + x + 1;
            obj += &format!("f {} {} {} {}\n", first, first + 1, first + 10, first + 9);
        }
    }
    std::fs::write(path, obj).unwrap();
}

fn place(row: &[f64]) -> DVec3 {
    DVec3::new(row[6], row[7], row[8])
}

fn direction(row: &[f64]) -> DVec3 {
    DVec3::new(row[9], row[10], row[11])
}

/// Two squares that cross in a line at an angle, somewhere in the world, one of them far from its own origin: the part
/// of the direction along the line stays, and the rest climbs on the side that A's normal points to.
#[test]
fn walks_fold_about_the_line_in_which_squares_meet() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let far = DVec3::new(512.0, -256.0, 128.0);
    write_square(&folder.join("a.obj"), DVec3::ZERO);
    write_square(&folder.join("b.obj"), far);
    let anywhere = DAffine3::from_rotation_translation(
        DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 1.1),
        DVec3::new(3.0, -1.0, 0.2),
    );
    let line = DVec3::new(0.6, 0.8, 0.0);
    // The first quad of the fifth row and fifth column begins in the middle; its first triangle is face 2 * 36.
    let face = 2 * (4 * 8 + 4);
    let corner = DVec3::new(0.0, 0.0, 0.0);
    for angle in [30.0_f64, 60.0, 90.0, 120.0, -45.0] {
        let turn = DQuat::from_axis_angle(line, angle.to_radians());
        let offset = DVec3::new(0.3, -0.2, 0.0);
        let from_b = DAffine3::from_translation(offset) * DAffine3::from_quat(turn);
        let pose_b = anywhere * from_b * DAffine3::from_translation(-far);
        write_scene(folder, ["a.obj", "b.obj"], [anywhere, pose_b]);
        let [b0, b1, b2] = [0.5, 0.3, 0.2];
        // Corners of that triangle: (0, 0), (0.25, 0), (0.25, 0.25).
        let start = corner + DVec3::new(0.25 * (b1 + b2), 0.25 * b2, 0.0);
        let mut text = String::new();
        let mut expected = Vec::new();
        let own_up = DVec3::Z;
        let up = turn * DVec3::Z.cross(line);
        let up = up * up.dot(own_up).signum();
        let across = line.cross(own_up);
        for k in 0..16 {
            let way = DQuat::from_rotation_z(0.1 + f64::from(k) * 0.39) * DVec3::X;
            let d = anywhere.matrix3 * way;
            text += &format!("{k},{face},{b0},{b1},{b2},{},{},{},0.7\n", d.x, d.y, d.z);
            let reach = (offset - start).dot(across) / way.dot(across);
            let (end, out) = if (0.0..0.7).contains(&reach) {
                let along = way.dot(line);
                let out = along * line + (1.0 - along * along).sqrt() * up;
                (start + reach * way + (0.7 - reach) * out, out)
            } else {
                (start + 0.7 * way, way)
            };
            expected.push((reach, end, out));
        }
        let Some(answers) = answers(folder, &text) else {
            return;
        };
        let mut changed = 0;
        for (row, (reach, end, out)) in answers.iter().zip(expected) {
            assert_eq!(row[13], 0.0, "{row:?}");
            assert_eq!(
                row[1] == 1.0,
                (0.0..0.7).contains(&reach),
                "{reach} {row:?}"
            );
            changed += u32::from(row[1] == 1.0);
            let end = anywhere.transform_point3(end);
            assert!(place(row).distance(end) < 1e-6, "{angle}: {end} {row:?}");
            let out = anywhere.matrix3 * out;
            let off = direction(row).angle_between(out).to_degrees();
            assert!(off < 0.001, "{angle}: {off} degrees");
            assert!((row[12] - 0.7).abs() < 1e-6);
            assert!((row[3] + row[4] + row[5] - 1.0).abs() < 1e-9);
        }
        assert!((4..16).contains(&changed), "{changed} of 16");
    }
}

/// A ball on a floor that it sinks into: walks on the floor climb the ball, walks on the ball step onto the floor, and
/// none goes where it is covered.
#[test]
fn walks_end_where_they_are_not_covered() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_square(&folder.join("floor.obj"), DVec3::ZERO);
    let raised = DAffine3::from_translation(DVec3::new(0.0, 0.0, 0.6));
    let ball = "builtin:icosphere?subdivisions=3";
    // Towards the middle from a quad of the first row, and down along meridians.
    let mut text = String::new();
    for k in 0..5 {
        text += &format!("{k},{},0.4,0.3,0.3,0,1,0,1\n", 2 * (k + 2));
    }
    write_scene(folder, ["floor.obj", ball], [DAffine3::IDENTITY, raised]);
    let Some(on_ball) = answers(folder, &text) else {
        return;
    };
    let met = on_ball.iter().filter(|row| row[1] == 1.0).count();
    assert!(met >= 3, "{on_ball:?}");
    for row in on_ball.iter().filter(|row| row[1] == 1.0) {
        assert!(place(row).z > 0.0 && direction(row).z > 0.0, "{row:?}");
        let radius = place(row).distance(DVec3::new(0.0, 0.0, 0.6));
        assert!((0.98..1.001).contains(&radius), "{row:?}");
    }
    write_scene(folder, [ball, "floor.obj"], [raised, DAffine3::IDENTITY]);
    let text: String = (0..200)
        .map(|k| format!("{k},{},0.4,0.3,0.3,0.1,0.2,-1,1.6\n", 6 * k))
        .collect();
    let on_floor = answers(folder, &text).unwrap();
    let met: Vec<_> = on_floor.iter().filter(|row| row[1] == 1.0).collect();
    assert!(met.len() > 50, "{}", met.len());
    for row in met {
        // The ball's circle in the floor has a radius of 0.8. A walk that comes up from below meets the floor from there.
        assert!(place(row).z.abs() < 1e-6, "{row:?}");
        let radius = place(row).length();
        assert!(radius > 0.79, "{row:?}");
    }
}

/// A mesh that is too far away to be met has no effect, however far it is.
#[test]
fn walks_stay_where_the_other_mesh_is_far_away() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let ball = "builtin:icosphere?subdivisions=3";
    let text: String = (0..200)
        .map(|k| format!("{k},{},0.4,0.3,0.3,0.1,0.2,-1,1.6\n", 6 * k))
        .collect();
    let mut all = Vec::new();
    for distance in [10.0, 1e6, 1e15, 1e25, 1e160] {
        let away = DAffine3::from_translation(distance * DVec3::new(0.6, 0.0, 0.8));
        write_scene(folder, [ball, ball], [DAffine3::IDENTITY, away]);
        let Some(answers) = answers(folder, &text) else {
            return;
        };
        assert_eq!(answers.len(), 200);
        assert!(answers.iter().all(|row| row[1] == 0.0 && row[13] == 0.0));
        all.push(answers);
    }
    assert!(all.iter().all(|answers| *answers == all[0]));
}

/// A bar along Y with a slot in it, as a letter U in X and Z: the arm at X = 0 has this thickness, the slot and the other arm have fixed
/// ones. Side `k` of its outline has the faces `2 k` and `2 k + 1`.
struct Slotted {
    outline: [[f64; 2]; 10],
}

impl Slotted {
    const SLOT: f64 = 0.2;
    const OTHER_ARM: f64 = 0.6;
    const FLOOR: f64 = 0.25;
    const TOP: f64 = 2.0;

    fn new(arm: f64) -> Self {
        let (far, end) = (arm + Self::SLOT, arm + Self::SLOT + Self::OTHER_ARM);
        let (floor, top) = (Self::FLOOR, Self::TOP);
        Self {
            outline: [
                [0.0, 0.0],
                [end, 0.0],
                [end, floor],
                [end, top],
                [far, top],
                [far, floor],
                [arm, floor],
                [arm, top],
                [0.0, top],
                [0.0, floor],
            ],
        }
    }

    fn write(&self, path: &Path) {
        let mut obj = String::new();
        for y in [-1, 1] {
            for [x, z] in self.outline {
                obj += &format!("v {x} {y} {z}\n");
            }
        }
        for i in 0..10 {
            // Vertices are numbered from 1; those at Y = 1 follow the others.
            let (a, b) = (i + 1, (i + 1) % 10 + 1);
            obj += &format!("f {} {} {b}\nf {} {b} {a}\n", a + 10, b + 10, a + 10);
        }
        let caps = [
            [0, 1, 2],
            [0, 2, 5],
            [0, 5, 6],
            [0, 6, 9],
            [2, 3, 4],
            [2, 4, 5],
            [6, 7, 8],
            [6, 8, 9],
        ];
        for [a, b, c] in caps {
            obj += &format!("f {} {} {}\n", a + 1, b + 1, c + 1);
            obj += &format!("f {} {} {}\n", c + 11, b + 11, a + 11);
        }
        std::fs::write(path, obj).unwrap();
    }

    /// The signed distance of a place that is not beyond the bar's ends.
    fn distance(&self, place: DVec3) -> f64 {
        let at = DVec2::new(place.x, place.z);
        let mut nearest = f64::INFINITY;
        let mut is_inside = false;
        for (i, &a) in self.outline.iter().enumerate() {
            let a = DVec2::from_array(a);
            let b = DVec2::from_array(self.outline[(i + 1) % 10]);
            let share = (at - a).dot(b - a) / a.distance_squared(b);
            nearest = nearest.min(at.distance(a.lerp(b, share.clamp(0.0, 1.0))));
            // From a point inside, a line to the right crosses the outline an odd number of times.
            let crosses = (a.y > at.y) != (b.y > at.y);
            is_inside ^= crosses && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x);
        }
        assert!(place.y.abs() < 1.0);
        if is_inside {
            -nearest.min(1.0 - place.y.abs())
        } else {
            nearest
        }
    }
}

/// A bar with a slot, and walks up the wall of the slot onto a square that cuts through all of it. One that continues
/// outwards crosses the slot and gets into the other arm; one that continues inwards comes out of a thin wall behind. The
/// walk takes the side whose end is less covered by the bar, whichever that is.
#[test]
fn walks_go_inwards_where_the_way_out_is_more_covered() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_square(&folder.join("square.obj"), DVec3::ZERO);
    let anywhere = DAffine3::from_rotation_translation(
        DQuat::from_axis_angle(DVec3::new(-0.3, 1.0, 0.7).normalize(), 0.8),
        DVec3::new(-0.4, 0.9, 1.3),
    );
    // On the first of the two triangles between the slot and the arm.
    let (face, [b0, b1, b2]) = (12, [0.5625, 0.0875, 0.35]);
    let (mut inwards, mut outwards, mut both_covered) = (0, 0, 0);
    for (arm, angle) in [(0.1, 0.0_f64), (0.1, 25.0), (0.5, -20.0), (0.5, 10.0)] {
        let bar = Slotted::new(arm);
        bar.write(&folder.join("bar.obj"));
        let start = DVec3::new(
            arm,
            b0 + b1 - b2,
            b0 * Slotted::FLOOR + (b1 + b2) * Slotted::TOP,
        );
        let middle = DVec3::new(arm, 0.25, 1.3);
        let turn = DQuat::from_rotation_y(angle.to_radians());
        let pose = anywhere * DAffine3::from_rotation_translation(turn, middle);
        write_scene(folder, ["bar.obj", "square.obj"], [anywhere, pose]);
        let normal = turn * DVec3::Z;
        let line = DVec3::X.cross(normal).normalize();
        let up = line.cross(normal);
        let up = up * up.x.signum();
        let mut text = String::new();
        let mut expected = Vec::new();
        for k in 0..48 {
            let way = DVec3::new(0.0, 0.2 * f64::from(k % 3 - 1), 1.0).normalize();
            let reach = (middle - start).dot(normal) / way.dot(normal);
            let rest = 0.03 + 0.018 * f64::from(k);
            let d = anywhere.matrix3 * way;
            let length = reach + rest;
            text += &format!(
                "{k},{face},{b0},{b1},{b2},{},{},{},{length}\n",
                d.x, d.y, d.z
            );
            let along = way.dot(line);
            let across = (1.0 - along * along).sqrt();
            let end = |side: f64| start + reach * way + rest * (along * line + side * across * up);
            let ends = [1.0, -1.0].map(end);
            expected.push((ends, ends.map(|end| bar.distance(end))));
        }
        let Some(answers) = answers(folder, &text) else {
            return;
        };
        for (row, ([outer, inner], [outer_distance, inner_distance])) in
            answers.iter().zip(expected)
        {
            if (inner_distance - outer_distance).abs() < 1e-4 {
                continue;
            }
            let goes_in = inner_distance > outer_distance;
            let (end, other) = if goes_in {
                (inner, outer)
            } else {
                (outer, inner)
            };
            inwards += u32::from(goes_in);
            outwards += u32::from(!goes_in);
            both_covered += u32::from(goes_in && inner_distance < 0.0);
            let what = format!(
                "{arm}, {angle}: {outer_distance} outwards, {inner_distance} inwards, {row:?}"
            );
            assert_eq!((row[1], row[13]), (1.0, 0.0), "{what}");
            let place = anywhere.inverse().transform_point3(place(row));
            assert!(place.distance(end) < 1e-5, "{what}: {place} and not {end}");
            assert!(place.distance(other) > 0.05, "{what}");
        }
    }
    assert!(
        inwards > 30 && outwards > 30 && both_covered > 5,
        "{inwards} inwards, {both_covered} of them covered, {outwards} outwards"
    );
}

/// Walks that stop at a border of either mesh, that meet nothing, and rows that make no walk.
#[test]
fn borders_and_bad_rows_have_their_status() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write_square(&folder.join("a.obj"), DVec3::ZERO);
    let upright = DAffine3::from_rotation_translation(
        DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        DVec3::new(0.0, 0.5, 0.3),
    );
    write_scene(folder, ["a.obj", "a.obj"], [DAffine3::IDENTITY, upright]);
    let rows = "0,72,1,0,0,0,1,0,9\n1,72,1,0,0,0,-1,0,9\n2,72,1,0,0,0,0,1,1\n3,999,1,0,0,1,0,0,1\n";
    let Some(answers) = answers(folder, rows) else {
        return;
    };
    let status: Vec<_> = answers.iter().map(|row| (row[1], row[13])).collect();
    assert_eq!(status, [(1.0, 1.0), (0.0, 1.0), (0.0, 2.0), (0.0, 2.0)]);
    // Half a unit to the upright square, and up to its border.
    assert!(place(&answers[0]).distance(DVec3::new(0.0, 0.5, 1.3)) < 1e-6);
    assert!((answers[0][12] - 1.8).abs() < 1e-6);
    assert!((answers[1][12] - 1.0).abs() < 1e-6);
}

#[test]
fn scenes_that_are_not_two_meshes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let refused = |text: &str| {
        std::fs::write(folder.join("scene.json"), text).unwrap();
        let output = run(folder, HEADER);
        assert_eq!(output.status.code(), Some(1));
        String::from_utf8(output.stderr).unwrap()
    };
    let identity = "[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]";
    let b = format!("\"mesh_b\":\"builtin:cube\",\"b_transform_row_major\":{identity}");
    assert_eq!(
        refused(&format!("{{{b}}}")),
        "myxo: scene.json: mesh_a is missing\n"
    );
    assert_eq!(
        refused(&format!("{{\"mesh_a\":\"builtin:cube\",{b}}}")),
        "myxo: scene.json: a_transform_row_major is missing\n"
    );
    let stretched = identity.replacen('1', "2", 1);
    assert_eq!(
        refused(&format!(
            "{{\"mesh_a\":\"builtin:cube\",\"a_transform_row_major\":{stretched},{b}}}"
        )),
        "myxo: scene.json: a_transform_row_major is not a rotation and a translation\n"
    );
}
