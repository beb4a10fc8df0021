//! What OBJ and glTF files may contain, and what becomes of it.

use glam::{Affine3A, DVec3, Vec2, Vec3};
use myxo::mesh::{Mesh, suite};
use myxo::scene::Scene;
use myxo::scene::settings::Settings;

/// Loads a file of the given name and content.
fn load(name: &str, bytes: &[u8]) -> Mesh {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    Mesh::load(&path).unwrap_or_else(|error| panic!("{error}"))
}

/// The corners of every triangle, as points.
fn corner_points(mesh: &Mesh) -> Vec<[Vec3; 3]> {
    let points = |corners: &[u32; 3]| corners.map(|vertex| mesh.positions[vertex as usize]);
    mesh.corners.iter().map(points).collect()
}

/// A glTF file of a unit square's vertices in a strip's order, with more bytes behind them, and some JSON.
fn gltf(more: &[u8], primitive: &str, accessors: &str, rest: &str) -> Mesh {
    let mut binary: Vec<u8> = bytemuck::cast_slice(&SQUARE).to_vec();
    binary.extend_from_slice(more);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{{primitive}}}]}}],
"bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":{}}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}}{accessors}],
"buffers":[{{"byteLength":{}}}]{rest}}}"#,
        more.len(),
        binary.len()
    );
    load("square.glb", &suite::glb(&json, &binary))
}

const SQUARE: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [1.0, 1.0, 0.0],
];

fn points(corners: &[[usize; 3]]) -> Vec<[Vec3; 3]> {
    let point = |corner: usize| Vec3::from_array(SQUARE[corner]);
    corners.iter().map(|corners| corners.map(point)).collect()
}

/// The two triangles of the strip, in the order that glTF 2.0 (3.7.2.1) gives their corners.
const TWO: &[[usize; 3]] = &[[0, 1, 2], [1, 3, 2]];

/// What a triangle's corners have, in the order of the file.
fn in_file_order<T: Copy>(mesh: &Mesh, triangle: usize, ours: [T; 3]) -> [T; 3] {
    let mut file = ours;
    for (value, corner) in ours.into_iter().zip(mesh.file_corners[triangle]) {
        file[corner as usize] = value;
    }
    file
}

/// A model in map coordinates has the triangles that it has about the origin, and an object that is moved back
/// stands at the origin. Would catch: positions that are rounded before they are counted from somewhere near.
#[test]
fn models_far_from_the_origin_lose_nothing() {
    let near = Mesh::builtin("builtin:torus").unwrap();
    let far = DVec3::new(512_352.0, 224.0, 5_412_352.0);
    let mut text = String::new();
    for position in &near.positions {
        let [x, y, z] = (position.as_dvec3() + far).to_array();
        text += &format!("v {x} {y} {z}\n");
    }
    for corners in &near.corners {
        let [a, b, c] = corners.map(|corner| corner + 1);
        text += &format!("f {a} {b} {c}\n");
    }
    let mesh = load("map.obj", text.as_bytes());
    assert_eq!(mesh.origin, far);
    let counts = |mesh: &Mesh| {
        (
            mesh.report.triangles,
            mesh.report.vertices,
            mesh.report.border_edges,
        )
    };
    assert_eq!(counts(&mesh), counts(&near));
    // Double precision has steps of 1e-9 there.
    let points = |mesh: &Mesh| corner_points(mesh).into_iter().flatten();
    let both = points(&mesh).zip(points(&near));
    let off = both.map(|(a, b)| a.distance(b)).fold(0.0, f32::max);
    assert!(off < 2e-7, "{off}");
    assert_eq!(mesh.report.stored_steps, None);

    let mut settings = Settings::default();
    settings.objects[0].position = (-2.0 * far).to_array();
    settings.objects[0].scale = 2.0;
    let scene = Scene::from_meshes("back".to_owned(), settings, vec![mesh], ".".into()).unwrap();
    assert_eq!(scene.origins[0].world, DVec3::ZERO);
    assert_eq!(scene.world_from_object(), [Affine3A::IDENTITY]);
}

/// Would catch: no word about details that a file in single precision has lost already.
#[test]
fn coordinates_stored_too_coarsely_are_reported() {
    let near = Mesh::builtin("builtin:cube").unwrap();
    let at = |x: f32| {
        let mut file = vec![0; 80];
        file.extend((near.corners.len() as u32).to_le_bytes());
        for corners in &near.corners {
            file.extend([0; 12]);
            for corner in corners {
                let position = near.positions[*corner as usize] + x * Vec3::X;
                file.extend(position.to_array().map(f32::to_le_bytes).as_flattened());
            }
            file.extend([0; 2]);
        }
        load("cube.stl", &file).report
    };
    assert_eq!(at(10.0).stored_steps, None);
    let report = at(2_000_000.0);
    // 2 across, in steps of 1/8.
    assert_eq!((report.stored_steps, report.triangles), (Some(16), 12));
    assert!(
        report
            .to_string()
            .contains("single precision far from the origin, 16 steps across")
    );
}

#[test]
fn polygons_are_fans_in_file_order() {
    let text = "v 0 0 0\nv 1 0 0\nv 2 0 1\nv 2 1 1\nv 1 2 0\no a\nf 1 2 4 5\ng b\nf 2 3 4\nf -5 -1 1\nf 1 5 -5 2\n";
    let mesh = load("fan.obj", text.as_bytes());
    // The last two faces: a corner twice, and a quad of which one half is degenerate and the other there already.
    assert_eq!(mesh.report.file_triangles, 6);
    assert_eq!(mesh.file_triangle, [0, 1, 2]);
    let corners: Vec<_> = (0..3)
        .map(|triangle| in_file_order(&mesh, triangle, mesh.corners[triangle]))
        .collect();
    assert_eq!(corners, [[0, 1, 2], [0, 2, 3], [1, 4, 2]]);
    assert_eq!(mesh.positions[3], Vec3::new(1.0, 2.0, 0.0));
    assert_eq!(mesh.positions[4], Vec3::new(2.0, 0.0, 1.0));
}

#[test]
fn texture_coordinates_follow_their_corners() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                f 1/1 2/2 3/3\nf 1/4 4/2 3/1\nf 4/1 3/1 1/1\n";
    let mesh = load("uv.obj", text.as_bytes());
    let uv = |x: f32, y: f32| Vec2::new(x, y);
    // The second face agrees with the first; the third is there already.
    let uvs = mesh.uvs.as_ref().expect("every corner has one");
    let uvs: Vec<_> = (0..2)
        .map(|triangle| in_file_order(&mesh, triangle, uvs[triangle]))
        .collect();
    assert_eq!(
        uvs,
        [
            [uv(0.0, 0.0), uv(1.0, 0.0), uv(1.0, 1.0)],
            [uv(0.0, 1.0), uv(1.0, 0.0), uv(0.0, 0.0)],
        ]
    );
    assert!(!mesh.is_flipped(0) && mesh.is_flipped(1));

    let text = text.replace("f 1/4 4/2 3/1", "f 1/4 4/2 3");
    let mesh = load("uv.obj", text.as_bytes());
    assert_eq!(mesh.uvs, None);
    assert!(mesh.report.to_string().contains("texture coordinates"));
}

#[test]
fn corners_come_as_lists_strips_and_fans() {
    for (indices, mode, corners) in [
        (&[0_u8, 1, 2, 1, 3, 2][..], 4, TWO),
        (&[0, 1, 2, 3], 5, TWO),
        (&[0, 1, 3, 2], 6, &[[1, 3, 0], [3, 2, 0]]),
    ] {
        let primitive = format!(r#""attributes":{{"POSITION":0}},"indices":1,"mode":{mode}"#);
        let count = indices.len();
        for (kind, bytes) in [
            (5121, indices.to_vec()),
            (
                5123,
                indices
                    .iter()
                    .flat_map(|&i| u16::from(i).to_le_bytes())
                    .collect(),
            ),
            (
                5125,
                indices
                    .iter()
                    .flat_map(|&i| u32::from(i).to_le_bytes())
                    .collect(),
            ),
        ] {
            let accessor = format!(
                r#",{{"bufferView":1,"componentType":{kind},"count":{count},"type":"SCALAR"}}"#
            );
            let mesh = gltf(&bytes, &primitive, &accessor, "");
            assert_eq!(
                corner_points(&mesh),
                points(corners),
                "mode {mode}, type {kind}"
            );
        }
    }
    let without_indices = gltf(&[0], r#""attributes":{"POSITION":0},"mode":5"#, "", "");
    assert_eq!(corner_points(&without_indices), points(TWO));
}

#[test]
fn texture_coordinates_may_be_fractions_of_integers() {
    let primitive = r#""attributes":{"POSITION":0,"TEXCOORD_0":1},"mode":5"#;
    let floats: Vec<u8> = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 1.0]
        .iter()
        .flat_map(|value| value.to_le_bytes())
        .collect();
    for (kind, bytes) in [
        (5126, floats),
        (5121, vec![0, 0, 255, 0, 0, 255, 255, 255]),
        (
            5123,
            [0_u16, 0, 65_535, 0, 0, 65_535, 65_535, 65_535]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect(),
        ),
    ] {
        let accessor = format!(
            r#",{{"bufferView":1,"componentType":{kind},"normalized":true,"count":4,"type":"VEC2"}}"#
        );
        let uvs = gltf(&bytes, primitive, &accessor, "").uvs.unwrap();
        assert_eq!(uvs[1], [Vec2::X, Vec2::ONE, Vec2::Y], "type {kind}");
    }
}

#[test]
fn positions_may_be_interleaved_sparse_or_quantized() {
    // Three bytes and one of padding for each vertex: a stride, and the quantization extension.
    let quantized = r#""attributes":{"POSITION":1},"mode":5"#;
    let accessor = r#",{"bufferView":2,"componentType":5120,"normalized":true,"count":4,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteLength":1},{"buffer":0,"byteOffset":48,"byteLength":15,"byteStride":4}"#;
    let bytes = [0, 0, 0, 9, 127, 0, 0, 9, 0, 127, 0, 9, 127, 127, 0];
    let json_rest = r#","extensionsRequired":["KHR_mesh_quantization"]"#;
    let mut binary: Vec<u8> = bytemuck::cast_slice(&SQUARE).to_vec();
    binary.extend_from_slice(&bytes);
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"meshes":[{{"primitives":[{{{quantized}}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"}}{accessor}],
"buffers":[{{"byteLength":63}}]{json_rest}}}"#
    );
    let mesh = load("quantized.glb", &suite::glb(&json, &binary));
    assert_eq!(corner_points(&mesh), points(TWO));

    // Vertex 3 is replaced, vertices without a base are zeros.
    let mut more = vec![3, 0, 0, 0];
    more.extend(
        [5.0_f32, 6.0, 7.0]
            .iter()
            .flat_map(|value| value.to_le_bytes()),
    );
    let sparse = r#""count":1,"indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":1,"byteOffset":4}"#;
    let accessor = format!(
        r#",{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","sparse":{{{sparse}}}}}"#
    );
    let mesh = gltf(
        &more,
        r#""attributes":{"POSITION":1},"mode":5"#,
        &accessor,
        "",
    );
    assert_eq!(mesh.positions[3], Vec3::new(5.0, 6.0, 7.0));
    assert_eq!(mesh.positions[2], Vec3::Y);
}

#[test]
fn nodes_place_their_meshes() {
    let primitive = r#""attributes":{"POSITION":0},"mode":5"#;
    let place = |nodes: &str| gltf(&[0], primitive, "", nodes);

    // Parent and child: first the child's turn by 90 degrees about Z, then the parent's scale and shift.
    let nested = place(
        r#","scene":1,"scenes":[{"nodes":[]},{"nodes":[2]}],"nodes":[
        {"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476]},{"mesh":0},
        {"children":[0],"scale":[2,2,2],"translation":[10,0,0]}]"#,
    );
    assert_eq!(nested.report.triangles, 2);
    let expected = [
        [10.0, 0.0, 0.0],
        [10.0, 2.0, 0.0],
        [8.0, 0.0, 0.0],
        [8.0, 2.0, 0.0],
    ];
    for (position, expected) in nested.positions.iter().zip(expected) {
        assert!((*position - Vec3::from_array(expected)).length() < 1e-5);
    }

    // A mirror turns the winding; the matrix is listed by columns.
    let mirrored = place(r#","nodes":[{"mesh":0,"matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 3,0,0,1]}]"#);
    let [a, b, c] = corner_points(&mirrored)[0];
    assert_eq!(a, Vec3::new(3.0, 0.0, 0.0));
    assert!((b - a).cross(c - a).z > 0.0);
    assert_eq!(mirrored.report.mended_triangles, 0);

    // A turn by 90 degrees below an uneven scale: that is no length along the mesh's own axes any more.
    let uneven = place(
        r#","nodes":[{"mesh":0,"rotation":[0,0,0.7071067811865476,0.7071067811865476]},
        {"children":[0],"scale":[1,3,0.5]}],"scenes":[{"nodes":[1]}]"#,
    );
    let (low, high) = uneven.bounds();
    assert!(low.distance(Vec3::new(-1.0, 0.0, 0.0)) < 1e-5, "{low}");
    assert!(high.distance(Vec3::new(0.0, 3.0, 0.0)) < 1e-5, "{high}");
    assert_eq!(uneven.report.mended_triangles, 0);

    // Two nodes with one mesh; a circle; a node that is named twice.
    let twice = place(
        r#","scenes":[{"nodes":[0,1,0]}],"nodes":[{"mesh":0,"children":[2]},
        {"mesh":0,"translation":[0,0,5],"children":[0]},{"children":[0,2]}]"#,
    );
    assert_eq!(twice.report.parts, 2);
    assert_eq!(twice.report.repeated_nodes, 4);

    // A skin moves what has joints; without them the node places the mesh, as in Khronos' viewer.
    let skinned =
        place(r#","skins":[{"joints":[0]}],"nodes":[{"mesh":0,"skin":0,"translation":[7,0,0]}]"#);
    let expected = (Vec3::new(7.0, 0.0, 0.0), Vec3::new(8.0, 1.0, 0.0));
    assert_eq!(skinned.bounds(), expected);
}

#[test]
fn a_raw_mesh_is_the_first_primitive_where_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let (json, binary) = suite::glb_parts(&Mesh::builtin("cube").unwrap());
    let json = json.replace("{\"mesh\":0}", "{\"mesh\":0,\"translation\":[5,0,0]}");
    let path = folder.path().join("cube.glb");
    std::fs::write(&path, suite::glb(&json, &binary)).unwrap();
    let low = |mesh: Mesh| mesh.bounds().0;
    assert_eq!(low(Mesh::load_raw(&path).unwrap()), Vec3::NEG_ONE);
    assert_eq!(low(Mesh::load(&path).unwrap()), Vec3::new(4.0, -1.0, -1.0));
}

#[test]
fn very_deep_scenes_load() {
    let depth = 100_000;
    let mut nodes = String::new();
    for node in 0..depth {
        nodes += &format!(r#"{{"children":[{}]}},"#, node + 1);
    }
    let rest = format!(r#","nodes":[{nodes}{{"mesh":0}}]"#);
    let mesh = gltf(&[0], r#""attributes":{"POSITION":0},"mode":5"#, "", &rest);
    assert_eq!(corner_points(&mesh), points(TWO));
}

#[test]
fn names_come_from_the_file_and_the_builtin() {
    let mesh = load("my model.v2.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(mesh.name, "my model.v2");
    let folder = std::path::Path::new("/nowhere");
    assert_eq!(
        Mesh::open("builtin:torus?major=9", folder).unwrap().name,
        "torus"
    );
    let error = Mesh::open("model.obj", folder).unwrap_err().to_string();
    assert!(
        error.starts_with("cannot read /nowhere/model.obj"),
        "{error}"
    );
}
