//! Tests with small glTF files that are made here: everything that affects the shape is applied, everything else is ignored, and errors
//! have their place.
//!
//! Expected values are derived by hand from boxes: the file's mesh is the cube from -1 to 1, of 12 triangles, area 24
//! and volume 8. A box of the sides a, b and c has the area 2(ab + bc + ca). The volume is signed: it is positive where
//! triangles face outwards, before repairs.

use std::path::Path;
use std::time::{Duration, Instant};

use glam::DVec3;
use serde_json::{Value, json};

use super::reader::Reader;
use super::resource::Buffers;
use super::{animation, glb, read_track};
use crate::mesh::error::MeshProblem;
use crate::mesh::load::{Extent, parse};
use crate::mesh::random_files::mutate;
use crate::mesh::soup::Soup;
use crate::mesh::suite;
use crate::rng::{Purpose, random};

/// A glTF file that is being made.
struct Model {
    json: Value,
    binary: Vec<u8>,
}

/// The corners of the cube: bit 0 of the number is X, bit 1 is Y, bit 2 is Z.
fn corners() -> Vec<[f64; 3]> {
    let side = |number: usize, bit: usize| if number >> bit & 1 == 1 { 1.0 } else { -1.0 };
    (0..8)
        .map(|number| [side(number, 0), side(number, 1), side(number, 2)])
        .collect()
}

/// The six sides of the cube, each as two triangles that face outwards.
const SIDES: [u8; 36] = [
    0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5,
    7, 4, 7, 6,
];

impl Model {
    /// The cube, on a node of its own. Its positions are accessor 0, its indices accessor 1.
    fn cube() -> Self {
        let mut model = Self {
            json: json!({
                "asset": {"version": "2.0"},
                "scene": 0,
                "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
                "accessors": [],
                "bufferViews": [],
            }),
            binary: Vec::new(),
        };
        model.floats(&corners());
        model.accessor("SCALAR", 5121, 36, &SIDES);
        model
    }

    /// The cube with its JSON changed by a function.
    fn with(change: impl FnOnce(&mut Value)) -> Self {
        let mut model = Self::cube();
        change(&mut model.json);
        model
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend_from_slice(bytes);
        let views = self.json["bufferViews"].as_array_mut().unwrap();
        views.push(json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}));
        views.len() - 1
    }

    fn accessor(&mut self, kind: &str, component: u32, count: usize, bytes: &[u8]) -> usize {
        let view = self.view(bytes);
        self.push_accessor(json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind,
        }))
    }

    fn push_accessor(&mut self, accessor: Value) -> usize {
        let accessors = self.json["accessors"].as_array_mut().unwrap();
        accessors.push(accessor);
        accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, rows: &[[f64; N]]) -> usize {
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"].get(N);
        let bytes = float_bytes(rows.as_flattened());
        self.accessor(kind.unwrap_or(&"MAT4"), 5126, rows.len(), &bytes)
    }

    fn bytes<const N: usize>(&mut self, component: u32, rows: &[[i8; N]]) -> usize {
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        // Elements are padded to four bytes, as glTF requires.
        let padded = rows.iter().flat_map(|row| {
            let mut bytes = row.map(i8::cast_unsigned).to_vec();
            bytes.resize(4, 0x55);
            bytes
        });
        let bytes: Vec<u8> = padded.collect();
        let accessor = self.accessor(kind, component, rows.len(), &bytes);
        let view = self.json["bufferViews"].as_array_mut().unwrap().last_mut();
        view.unwrap()["byteStride"] = json!(4);
        accessor
    }

    fn text(&self) -> String {
        let mut json = self.json.clone();
        if json.get("buffers").is_none() {
            json["buffers"] = json!([{"byteLength": self.binary.len()}]);
        }
        json.to_string()
    }

    fn glb(&self) -> Vec<u8> {
        suite::glb(&self.text(), &self.binary)
    }

    /// A target of the cube's mesh.
    fn add_target(&mut self, positions: usize) {
        let targets = &mut self.json["meshes"][0]["primitives"][0]["targets"];
        if targets.is_null() {
            *targets = json!([]);
        }
        let target = json!({ "POSITION": positions });
        targets.as_array_mut().unwrap().push(target);
    }

    /// A target that lifts the upper corners by so much.
    fn add_lift(&mut self, by: f64) {
        let lift = |[_, y, _]: [f64; 3]| [0.0, if y > 0.0 { by } else { 0.0 }, 0.0];
        let offsets: Vec<[f64; 3]> = corners().into_iter().map(lift).collect();
        let offsets = self.floats(&offsets);
        self.add_target(offsets);
    }

    /// A skin of two joints, nodes 1 and 2: the lower corners follow the first, the upper ones the second.
    fn skinned(weight: f64) -> Self {
        let mut model = Self::cube();
        let joint = |[_, y, _]: [f64; 3]| [i8::from(y > 0.0), 0, 0, 0];
        let joints: Vec<[i8; 4]> = corners().into_iter().map(joint).collect();
        let joints = model.bytes(5121, &joints);
        let weights = model.floats(&[[weight, 0.0, 0.0, 0.0]; 8]);
        let attributes = &mut model.json["meshes"][0]["primitives"][0]["attributes"];
        attributes["JOINTS_0"] = json!(joints);
        attributes["WEIGHTS_0"] = json!(weights);
        model.json["nodes"] = json!([
            {"mesh": 0, "skin": 0, "translation": [70, 0, 0]},
            {}, {"translation": [0, 4, 0]},
        ]);
        model.json["scenes"] = json!([{"nodes": [0, 1, 2]}]);
        model.json["skins"] = json!([{"joints": [1, 2]}]);
        model
    }
}

fn float_bytes(values: &[f64]) -> Vec<u8> {
    let bytes = values.iter().flat_map(|&v| (v as f32).to_le_bytes());
    bytes.collect()
}

fn soup(bytes: &[u8]) -> Soup {
    let parsed = parse(Path::new("model.gltf"), bytes, Extent::Scene);
    parsed.unwrap_or_else(|problem| panic!("{problem}"))
}

fn problem(bytes: &[u8]) -> String {
    match parse(Path::new("model.gltf"), bytes, Extent::Scene) {
        Ok(_) => "nothing".to_owned(),
        Err(problem) => problem.to_string(),
    }
}

/// Measures of a shape.
#[derive(Debug, PartialEq)]
struct Measures {
    triangles: usize,
    area: f64,
    volume: f64,
    low: DVec3,
    high: DVec3,
}

fn measures(soup: &Soup) -> Measures {
    let triangles = soup.triangles.iter();
    let points = triangles.map(|corners| corners.map(|vertex| soup.positions[vertex as usize]));
    let points: Vec<[DVec3; 3]> = points.collect();
    // Volumes are measured from one of the points: far away the sum would lose its digits.
    let origin = soup.positions[0];
    let areas = points
        .iter()
        .map(|&[a, b, c]| (b - a).cross(c - a).length() / 2.0);
    let volumes = points.iter().map(|&[a, b, c]| {
        let [a, b, c] = [a - origin, b - origin, c - origin];
        a.dot(b.cross(c)) / 6.0
    });
    let all = points.iter().flatten().copied();
    Measures {
        triangles: points.len(),
        area: areas.sum(),
        volume: volumes.sum(),
        low: all.clone().reduce(DVec3::min).unwrap(),
        high: all.reduce(DVec3::max).unwrap(),
    }
}

fn box_of(boxes: usize, low: [f64; 3], high: [f64; 3], area: f64, volume: f64) -> Measures {
    Measures {
        triangles: 12 * boxes,
        area,
        volume,
        low: low.into(),
        high: high.into(),
    }
}

/// One box between two corners.
fn one_box(low: [f64; 3], high: [f64; 3]) -> Measures {
    let [a, b, c] = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    box_of(1, low, high, 2.0 * (a * b + b * c + c * a), a * b * c)
}

fn cube() -> Measures {
    one_box([-1.0; 3], [1.0; 3])
}

/// The cube's upper corners lifted.
fn column(top: f64) -> Measures {
    one_box([-1.0; 3], [1.0, top, 1.0])
}

fn assert_measures(name: &str, soup: &Soup, expected: &Measures) {
    let found = measures(soup);
    let near = |a: f64, b: f64| (a - b).abs() < 1e-5 * b.abs().max(1.0);
    assert!(
        found.triangles == expected.triangles
            && near(found.area, expected.area)
            && near(found.volume, expected.volume)
            && found.low.abs_diff_eq(expected.low, 1e-6)
            && found.high.abs_diff_eq(expected.high, 1e-6),
        "{name}: {found:?}, not {expected:?}"
    );
}

/// A chunk of a GLB, and bytes behind it that its length leaves out.
fn chunk(kind: &[u8], bytes: &[u8], padding: usize) -> Vec<u8> {
    let mut chunk = (bytes.len() as u32).to_le_bytes().to_vec();
    chunk.extend_from_slice(kind);
    chunk.extend_from_slice(bytes);
    chunk.resize(chunk.len() + padding, 0);
    chunk
}

/// A GLB whose header states a length.
fn container(length: u32, chunks: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend_from_slice(&length.to_le_bytes());
    bytes.extend_from_slice(&chunks.concat());
    bytes
}

/// Unused parts may be invalid. Each line tests another defect.
#[test]
fn what_the_shape_does_not_need_is_not_looked_at() {
    let deep = "[".repeat(100_000) + &"]".repeat(100_000);
    let plain = Model::cube().text();
    let replaced = |from: &str, to: &str| {
        assert!(plain.contains(from), "{from} is not in {plain}");
        plain.replace(from, to)
    };
    let beside = |more: &str| plain.replacen('{', &format!("{{{more},"), 1);
    for text in [
        format!("\u{feff}{plain}"),
        format!("{plain}\0\0\0"),
        format!("{plain}\n\u{1}]]"),
        replaced("5126", "5126.0"),
        replaced("\"count\":8", "\"count\":8.0"),
        replaced("\"indices\":1", "\"indices\":1e0"),
        replaced("{\"version\":\"2.0\"}", "{\"version\":2.0}"),
        replaced("\"asset\"", "\"other\""),
        replaced("\"mesh\":0", "\"mesh\":0,\"skin\":null,\"children\":null"),
        replaced("\"mesh\":0", "\"mesh\":7,\"mesh\":0"),
        replaced(
            "\"mesh\":0",
            "\"mesh\":0,\"name\":\"\\ud800\",\"camera\":-1",
        ),
        replaced("\"mesh\":0", &format!("\"mesh\":0,\"extras\":{deep}")),
        replaced(
            "\"count\":8",
            "\"count\":8,\"min\":[1e999],\"max\":\"none\"",
        ),
        replaced("\"indices\":1", "\"indices\":1,\"material\":-7"),
        replaced(
            "\"POSITION\":0",
            "\"POSITION\":0,\"NORMAL\":99,\"COLOR_0\":-1,\"_OWN\":null",
        ),
        beside("\"extras\":1e999"),
        beside(&format!("\"extensions\":{{\"X\":{deep}}}")),
        beside("\"materials\":[{\"alphaMode\":\"GLASS\",\"pbrMetallicRoughness\":7}]"),
        beside("\"samplers\":[{\"magFilter\":1,\"wrapS\":\"x\"}],\"textures\":9,\"images\":[{}]"),
        beside("\"cameras\":[{\"type\":\"fisheye\"}]"),
        beside(
            "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"path\":\"rotation\"}}]}]",
        ),
        beside("\"animations\":[{\"channels\":[{\"target\":{\"path\":\"pointer\"}}]},null,5]"),
        beside("\"extensionsUsed\":[\"EXT_never_heard_of\",5]"),
        beside("\"skins\":[{\"joints\":\"none\"}]"),
        plain.replace(
            "\"nodes\":[{\"mesh\":0}]",
            "\"nodes\":[{\"mesh\":0},{\"mesh\":-5,\"matrix\":[1]},null]",
        ),
        plain.replace(
            "\"type\":\"SCALAR\"}]",
            "\"type\":\"SCALAR\"},{\"componentType\":9,\"count\":1e300},8]",
        ),
    ] {
        let model = Model::cube();
        let name: String = text.chars().take(300).collect();
        assert_measures(&name, &soup(&suite::glb(&text, &model.binary)), &cube());
    }
    // A name in Latin-1: its byte is no UTF-8.
    let named = plain.replacen('{', "{\"extras\":\"~\",", 1).into_bytes();
    let named = named
        .into_iter()
        .map(|byte| if byte == b'~' { 0xe4 } else { byte });
    let named: Vec<u8> = named.collect();
    let binary = chunk(b"BIN\0", &Model::cube().binary, 0);
    let bytes = container(0, &[chunk(b"JSON", &named, 0), binary]);
    assert_measures("a name in Latin-1", &soup(&bytes), &cube());
}

/// The container may have defects as long as both chunks can be found.
#[test]
fn glb_containers_are_read_by_their_chunks() {
    let model = Model::cube();
    let mut text = model.text();
    while text.len() % 4 != 1 {
        text.push(' ');
    }
    let json = |padding| chunk(b"JSON", text.as_bytes(), padding);
    let binary = chunk(b"BIN\0", &model.binary, 0);
    let other = chunk(b"WHAT", &[1; 8], 0);
    let nul_padded = chunk(b"JSON", format!("{text}\0\0\0").as_bytes(), 0);
    for (name, length, chunks) in [
        ("length of zero", 0, vec![json(3), binary.clone()]),
        ("length beyond", u32::MAX, vec![json(3), binary.clone()]),
        ("padding not counted", 0, vec![json(3), binary.clone()]),
        ("no padding", 0, vec![json(0), binary.clone()]),
        (
            "padding of NUL",
            0,
            vec![nul_padded.clone(), binary.clone()],
        ),
        (
            "unknown chunks",
            0,
            vec![
                other.clone(),
                nul_padded,
                other.clone(),
                binary.clone(),
                other,
            ],
        ),
        ("rest", 0, vec![json(3), binary.clone(), vec![7; 5]]),
        ("long rest", 0, vec![json(3), binary, vec![0xff; 50]]),
    ] {
        assert_measures(name, &soup(&container(length, &chunks)), &cube());
    }
    // The missing bytes belong to no triangle.
    let mut model = Model::cube();
    model.view(&[9; 1000]);
    let glb = model.glb();
    let cut = &glb[..glb.len() - 500];
    assert_measures("cut picture", &soup(cut), &cube());
}

/// Morph targets: each line names the feature that only it tests.
#[test]
fn morph_targets_have_their_default_weights() {
    let lifted = |change: &dyn Fn(&mut Model)| {
        let mut model = Model::cube();
        model.add_lift(4.0);
        change(&mut model);
        model
    };
    let mut models = vec![
        ("no weights: no change", lifted(&|_| {}), cube()),
        (
            // 2 x 6 x 2: area 56.
            "weights of the mesh",
            lifted(&|model| model.json["meshes"][0]["weights"] = json!([1])),
            column(5.0),
        ),
        (
            "weights of the node come before those of the mesh",
            lifted(&|model| {
                model.json["meshes"][0]["weights"] = json!([1]);
                model.json["nodes"][0]["weights"] = json!([0.5]);
            }),
            column(3.0),
        ),
        (
            "a node's weight of zero is a weight",
            lifted(&|model| {
                model.json["meshes"][0]["weights"] = json!([1]);
                model.json["nodes"][0]["weights"] = json!([0]);
            }),
            cube(),
        ),
        (
            "weights of the mesh without any node",
            lifted(&|model| {
                model.json["meshes"][0]["weights"] = json!([1]);
                model.json["nodes"] = json!([]);
            }),
            column(5.0),
        ),
        (
            "targets add up, and missing weights are zero",
            lifted(&|model| {
                model.add_lift(1.0);
                model.add_lift(100.0);
                model.json["meshes"][0]["weights"] = json!([1, 2]);
            }),
            column(7.0),
        ),
        (
            "targets without positions or data, and a broken one without a weight",
            lifted(&|model| {
                let zeros = json!({"componentType": 5126, "count": 8, "type": "VEC3"});
                let zeros = model.push_accessor(zeros);
                let targets = &mut model.json["meshes"][0]["primitives"][0]["targets"];
                *targets =
                    json!([{"NORMAL": 0}, {"POSITION": 99}, targets[0], {"POSITION": zeros}]);
                model.json["meshes"][0]["weights"] = json!([1, 0, 1, 1]);
            }),
            column(5.0),
        ),
    ];

    // Sparse offsets for the corners 2, 3, 6 and 7, with nothing below.
    let mut sparse = Model::cube();
    let places = sparse.view(&[2, 3, 6, 7]);
    let values = sparse.view(&float_bytes(&[0.0, 4.0, 0.0].repeat(4)));
    let accessor = sparse.push_accessor(json!({
        "componentType": 5126, "count": 8, "type": "VEC3",
        "sparse": {"count": 4, "indices": {"bufferView": places, "componentType": 5121},
            "values": {"bufferView": values}},
    }));
    sparse.add_target(accessor);
    sparse.json["meshes"][0]["weights"] = json!([1]);
    models.push(("a sparse target without a base", sparse, column(5.0)));

    // Bytes of 127 are 1 where they are normalized, and 127 where they are not.
    for (name, normalized, weight) in [
        ("a normalized target", true, 4.0),
        ("a target of plain bytes", false, 4.0 / 127.0),
    ] {
        let mut model = Model::cube();
        let lift = |[_, y, _]: [f64; 3]| [0, if y > 0.0 { 127 } else { 0 }, 0];
        let offsets: Vec<[i8; 3]> = corners().into_iter().map(lift).collect();
        let offsets = model.bytes(5120, &offsets);
        model.json["accessors"][offsets]["normalized"] = json!(normalized);
        model.add_target(offsets);
        model.json["meshes"][0]["weights"] = json!([weight]);
        models.push((name, model, column(5.0)));
    }
    for (name, model, expected) in models {
        assert_measures(name, &soup(&model.glb()), &expected);
    }
}

/// Skins: each line names the feature that only it tests. Joint 1 takes the upper corners 4 up, in most of them.
#[test]
fn skins_have_the_pose_of_the_nodes() {
    let mirror = |model: &mut Model| {
        model.json["nodes"][1] = json!({"scale": [-1, 1, 1]});
        model.json["nodes"][2] = json!({"scale": [-1, 1, 1], "translation": [0, 4, 0]});
    };
    let matrix = |x: f64, y: f64, z: f64| {
        [
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, x, y, z, 1.0,
        ]
    };
    let changed = |change: &dyn Fn(&mut Model)| {
        let mut model = Model::skinned(1.0);
        change(&mut model);
        model
    };
    for (name, model, expected) in [
        (
            "the node of the mesh does not count, and missing matrices are identities",
            Model::skinned(1.0),
            column(5.0),
        ),
        (
            "inverse bind matrices: 4 up and 3 back",
            changed(&|model| {
                let matrices = model.floats(&[matrix(0.0, 0.0, 0.0), matrix(0.0, -3.0, 0.0)]);
                model.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
            }),
            column(2.0),
        ),
        (
            // The order matters: the scale of the joint is applied to what the matrix has moved. y: 2 (1 - 3) = -4.
            "a joint's transform comes after its matrix",
            changed(&|model| {
                let matrices = model.floats(&[matrix(0.0, 0.0, 0.0), matrix(0.0, -3.0, 0.0)]);
                model.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
                model.json["nodes"][1]["scale"] = json!([2, 2, 2]);
                model.json["nodes"][2] = json!({"scale": [2, 2, 2], "translation": [0, 9, 0]});
            }),
            one_box([-2.0; 3], [2.0, 5.0, 2.0]),
        ),
        (
            "joints below other nodes: 2 and 2 up",
            changed(&|model| {
                let nodes = model.json["nodes"].as_array_mut().unwrap();
                nodes[2] = json!({"translation": [0, 2, 0]});
                nodes.push(json!({"translation": [0, 2, 0], "children": [2]}));
                model.json["scenes"][0]["nodes"] = json!([0, 1, 3]);
            }),
            column(5.0),
        ),
        (
            "joints outside of the scene, below others",
            changed(&|model| {
                let nodes = model.json["nodes"].as_array_mut().unwrap();
                nodes[2] = json!({"translation": [0, 2, 0]});
                nodes.push(json!({"translation": [0, 2, 0], "children": [2]}));
                model.json["scenes"][0]["nodes"] = json!([0]);
            }),
            column(5.0),
        ),
        (
            // As in Khronos' viewer, which divides by the fourth coordinate.
            "weights that add up to a half are made whole",
            Model::skinned(0.5),
            column(5.0),
        ),
        (
            // As in Khronos' viewer.
            "without any weight there is no transform",
            Model::skinned(0.0),
            cube(),
        ),
        (
            // Half of 4 up, and half of nothing.
            "a second set of joints",
            changed(&|model| {
                let joints = model.bytes(5121, &[[0, 0, 0, 0]; 8]);
                let weights = model.bytes(5121, &[[64, 64, 127, 0]; 8]);
                model.json["accessors"][weights]["normalized"] = json!(true);
                let first = model.bytes(5121, &[[-1, 0, 0, 0]; 8]);
                model.json["accessors"][first]["normalized"] = json!(true);
                let attributes = &mut model.json["meshes"][0]["primitives"][0]["attributes"];
                attributes["JOINTS_1"] = json!(joints);
                attributes["WEIGHTS_1"] = json!(weights);
                attributes["WEIGHTS_0"] = json!(first);
            }),
            column(3.0),
        ),
        (
            // Lifted to 5, then halved.
            "targets come before joints",
            changed(&|model| {
                model.add_lift(4.0);
                model.json["meshes"][0]["weights"] = json!([1]);
                model.json["nodes"][1] = json!({"scale": [0.5, 0.5, 0.5]});
                model.json["nodes"][2] = json!({"scale": [0.5, 0.5, 0.5]});
            }),
            one_box([-0.5; 3], [0.5, 2.5, 0.5]),
        ),
        (
            "joints that mirror do not turn the winding",
            changed(&mirror),
            Measures {
                volume: -24.0,
                ..column(5.0)
            },
        ),
        (
            "a node that mirrors turns it, though its transform does not count",
            changed(&|model| {
                mirror(model);
                model.json["nodes"][0]["scale"] = json!([3, 3, -3]);
            }),
            column(5.0),
        ),
        (
            "without joints in the primitive the node places it",
            changed(&|model| {
                model.json["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
            }),
            one_box([69.0, -1.0, -1.0], [71.0, 1.0, 1.0]),
        ),
    ] {
        assert_measures(name, &soup(&model.glb()), &expected);
    }
}

/// Nodes: each line names the feature that only it tests.
#[test]
fn nodes_place_hide_and_repeat_meshes() {
    let mut models = vec![
        (
            "a mirror turns the winding",
            Model::with(|json| json["nodes"][0]["scale"] = json!([-1, 1, 1])),
            cube(),
        ),
        (
            "two mirrors do not",
            Model::with(|json| {
                json["nodes"] = json!([
                    {"scale": [1, -1, 1], "children": [1]}, {"mesh": 0, "scale": [-1, 1, 1]},
                ]);
            }),
            cube(),
        ),
        (
            "without a default scene the first counts",
            Model::with(|json| {
                json["scene"] = Value::Null;
                json["scenes"] = json!([{"nodes": [1]}, {"nodes": [0]}]);
                json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "translation": [9, 0, 0]}]);
            }),
            one_box([8.0, -1.0, -1.0], [10.0, 1.0, 1.0]),
        ),
        (
            "meshes without nodes",
            Model::with(|json| {
                json["nodes"] = Value::Null;
                json["meshes"] = json!([json["meshes"][0], json["meshes"][0]]);
            }),
            box_of(2, [-1.0; 3], [1.0; 3], 48.0, 16.0),
        ),
        (
            "hidden nodes, and what is below them",
            Model::with(|json| {
                let hides = |visible: bool| json!({"KHR_node_visibility": {"visible": visible}});
                json["nodes"] = json!([
                    {"children": [1, 2, 4]},
                    {"mesh": 0, "extensions": hides(true)},
                    {"children": [3], "extensions": hides(false)},
                    {"mesh": 0, "translation": [9, 0, 0], "extensions": hides(true)},
                    {"mesh": 0, "translation": [5, 0, 0], "extensions": hides(false)},
                ]);
                json["extensionsRequired"] = json!(["KHR_node_visibility"]);
            }),
            cube(),
        ),
    ];

    // Copies at 0, 4 and 8 along X and at 4 and 8 along Y.
    let mut five = Model::cube();
    let places = [
        [0.0; 3],
        [4.0, 0.0, 0.0],
        [8.0, 0.0, 0.0],
        [0.0, 4.0, 0.0],
        [0.0, 8.0, 0.0],
    ];
    let places = five.floats(&places);
    five.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": places}}});
    five.json["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let expected = box_of(5, [-1.0; 3], [9.0, 9.0, 1.0], 120.0, 40.0);
    models.push(("copies by translation", five, expected));

    // Scaled by (1, 2, 3), turned by 90 degrees about Z (equal Z and W), moved by 10; then all of it doubled and moved
    // by 100. Half sides are 2 (2, 1, 3); the middle is at 100 + 2 * 10.
    let mut turned = Model::cube();
    let translations = turned.bytes(5120, &[[10_i8, 0, 0]]);
    let rotations = turned.bytes(5120, &[[0_i8, 0, 90, 90]]);
    turned.json["accessors"][rotations]["normalized"] = json!(true);
    let scales = turned.floats(&[[1.0, 2.0, 3.0]]);
    turned.json["nodes"][0] = json!({
        "mesh": 0, "scale": [2, 2, 2], "translation": [100, 0, 0],
        "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {
            "TRANSLATION": translations, "ROTATION": rotations, "SCALE": scales,
        }}},
    });
    let expected = one_box([116.0, -2.0, -6.0], [124.0, 2.0, 6.0]);
    models.push(("copies by quantized numbers", turned, expected));

    // Positions of bytes: plain ones are 1, normalized ones 127.
    for (name, one, normalized) in [
        ("positions of plain bytes", 1, false),
        ("positions of normalized bytes", 127, true),
    ] {
        let mut model = Model::cube();
        let positions: Vec<[i8; 3]> = corners()
            .into_iter()
            .map(|corner| corner.map(|c| if c > 0.0 { one } else { -one }))
            .collect();
        let positions = model.bytes(5120, &positions);
        model.json["accessors"][positions]["normalized"] = json!(normalized);
        model.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(positions);
        models.push((name, model, cube()));
    }
    for (name, model, expected) in models {
        assert_measures(name, &soup(&model.glb()), &expected);
    }
}

/// Nodes are read in double precision: at map coordinates single precision is half a metre off.
#[test]
fn far_nodes_keep_their_places() {
    let model = Model::with(|json| {
        json["nodes"] = json!([
            {"mesh": 0, "translation": [4_500_000.25, 0, -5_400_000.125]},
            {"matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1e9, 0.125, 0, 1], "children": [0]},
        ]);
        json["scenes"] = json!([{"nodes": [1]}]);
    });
    let found = measures(&soup(&model.glb()));
    assert_eq!(
        found.low,
        DVec3::new(1_004_499_999.25, -0.875, -5_400_001.125)
    );
    assert_eq!(found.high - found.low, DVec3::splat(2.0));
}

/// The report names ignored parts.
#[test]
fn what_is_not_applied_is_in_the_report() {
    let extensions = |names: &[&str]| {
        let members = names.iter().map(|&name| (name.to_owned(), json!({})));
        Value::Object(members.collect())
    };
    let long = "X".repeat(100_000);
    let model = Model::with(|json| {
        json["nodes"][0]["extensions"] =
            extensions(&["MSFT_lod", "KHR_lights_punctual", "B_bends", long.as_str()]);
        json["meshes"][0]["extensions"] = extensions(&["A_places", "B_bends"]);
        let primitive = json["meshes"][0]["primitives"][0].clone();
        json["meshes"][0]["primitives"] = json!([primitive, {"attributes": {}}]);
        json["meshes"][0]["primitives"][0]["extensions"] =
            extensions(&["KHR_materials_variants", "C_hides"]);
        let hidden = json!({"KHR_node_visibility": {"visible": false}, "D_hidden": {}});
        json["nodes"][0]["children"] = json!([1]);
        let nodes = json["nodes"].as_array_mut().unwrap();
        nodes.push(json!({"mesh": 0, "extensions": hidden}));
    });
    let said = soup(&model.glb()).seen.oddities();
    let long = format!("the extension {}… is not applied", "X".repeat(60));
    assert_eq!(
        said,
        [
            "1 mesh that the file hides, left out",
            "1 part of a mesh without positions, ignored",
            "the extension A_places is not applied",
            "the extension B_bends is not applied",
            "the extension C_hides is not applied",
            &long,
        ]
    );

    // Extensions that change no shape are allowed to be required, and need no note.
    let names = [
        "ADOBE_materials_clearcoat_tint",
        "CESIUM_RTC",
        "EXT_materials_bump",
        "KHR_technique_webgl",
        "KHR_techniques_webgl",
        "NV_materials_mdl",
    ];
    let model = Model::with(|json| {
        json["extensionsRequired"] = json!(names);
        json["nodes"][0]["extensions"] = extensions(&names);
        json["meshes"][0]["extensions"] = extensions(&names);
    });
    let harmless = soup(&model.glb());
    assert_measures("extensions that change no shape", &harmless, &cube());
    assert!(harmless.seen.oddities().is_empty());

    // Copies of a skinned mesh: there is one, at its joints.
    let mut model = Model::skinned(1.0);
    model.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}});
    let soup = soup(&model.glb());
    assert_measures("copies of a skin", &soup, &column(5.0));
    let said = soup.seen.oddities();
    assert_eq!(
        said,
        ["the extension EXT_mesh_gpu_instancing is not applied"]
    );
}

/// Unreadable texture coordinates and incomplete triangles do not change the shape.
#[test]
fn damage_that_leaves_the_shape_is_noted() {
    let uvs = |change: &dyn Fn(&mut Model, usize)| {
        let mut model = Model::cube();
        let uvs = model.floats(&[[0.5, 0.25]; 8]);
        model.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
        change(&mut model, uvs);
        soup(&model.glb())
    };
    let good = uvs(&|_, _| {});
    assert_eq!(good.uvs.map(|uvs| uvs.len()), Some(12));
    assert_eq!(good.seen.oddities(), [""; 0]);
    let attribute = |model: &mut Model, value: Value| {
        model.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = value;
    };
    for (name, odd) in [
        ("number", uvs(&|model, _| attribute(model, json!(99)))),
        ("text", uvs(&|model, _| attribute(model, json!("none")))),
        ("positions", uvs(&|model, _| attribute(model, json!(0)))),
        (
            "component type",
            uvs(&|model, uvs| model.json["accessors"][uvs]["componentType"] = json!(5125)),
        ),
        (
            "buffer view",
            uvs(&|model, uvs| model.json["accessors"][uvs]["bufferView"] = json!(99)),
        ),
        (
            "no data",
            uvs(&|model, uvs| model.json["accessors"][uvs]["bufferView"] = Value::Null),
        ),
        (
            "too many",
            uvs(&|model, uvs| model.json["accessors"][uvs]["count"] = json!(9)),
        ),
        (
            "too few",
            uvs(&|model, uvs| model.json["accessors"][uvs]["count"] = json!(7)),
        ),
    ] {
        assert_measures(name, &odd, &cube());
        assert!(odd.uvs.is_none(), "{name}");
        let said = odd.seen.oddities();
        let words = "texture coordinates that are incomplete or not finite, ignored";
        assert_eq!(said, [words], "{name}");
    }

    // 32 corners are 10 triangles and 2 corners.
    let model = Model::with(|json| json["accessors"][1]["count"] = json!(32));
    let cut = soup(&model.glb());
    assert_eq!(cut.triangles.len(), 10);
    assert_eq!(
        cut.seen.oddities(),
        ["1 triangle that lacks corners, ignored"]
    );
    // Lists of corners in order, without indices: 8 corners are 2 triangles and 2 corners.
    let model = Model::with(|json| {
        json["meshes"][0]["primitives"][0]["indices"] = Value::Null;
    });
    let cut = soup(&model.glb());
    assert_eq!(cut.triangles, [[0, 1, 2], [3, 4, 5]]);
    assert_eq!(cut.seen.incomplete_triangles, 1);
}

/// Compressed data is refused by the name of its extension, unless it is also there uncompressed.
#[test]
fn compression_is_named() {
    let draco = |json: &mut Value| {
        json["meshes"][0]["primitives"][0]["extensions"] =
            json!({"KHR_draco_mesh_compression": {"bufferView": 0}});
    };
    let meshopt = |json: &mut Value| {
        json["bufferViews"][0]["extensions"] = json!({"EXT_meshopt_compression": {"buffer": 0}});
    };
    let with = |changes: &[&dyn Fn(&mut Value)]| {
        let mut model = Model::cube();
        for change in changes {
            change(&mut model.json);
        }
        model.glb()
    };
    // Both with their uncompressed data.
    assert_measures("both", &soup(&with(&[&draco, &meshopt])), &cube());

    let no_positions = |json: &mut Value| json["accessors"][0]["bufferView"] = Value::Null;
    let no_attribute = |json: &mut Value| {
        json["meshes"][0]["primitives"][0]["attributes"] = json!({});
    };
    let no_buffer = |json: &mut Value| {
        json["buffers"] = json!([{"byteLength": 999}, {"byteLength": 999}]);
        json["bufferViews"][0]["buffer"] = json!(1);
    };
    let of_draco = "meshes[0].primitives[0] is compressed with KHR_draco_mesh_compression, which is not supported: \
                    export the model without compression";
    let of_meshopt =
        "bufferViews[0] is compressed with EXT_meshopt_compression, which is not supported";
    for (bytes, words) in [
        (with(&[&draco, &no_positions]), of_draco),
        (with(&[&draco, &no_attribute]), of_draco),
        (with(&[&meshopt, &no_buffer]), of_meshopt),
        (with(&[&no_buffer]), "buffers[1] has no data"),
    ] {
        let problem = problem(&bytes);
        assert!(problem.contains(words), "{problem}\n  should have: {words}");
    }
}

/// Errors have their place and are one short sentence.
#[test]
fn problems_are_named_by_their_places() {
    let long = "n".repeat(100_000);
    let deep = "[".repeat(100_000) + &"]".repeat(100_000);
    let plain = Model::cube().text();
    let skinned = |change: &dyn Fn(&mut Value)| {
        let mut model = Model::skinned(1.0);
        change(&mut model.json);
        model.glb()
    };
    let changed = |change: &dyn Fn(&mut Value)| {
        let mut model = Model::cube();
        change(&mut model.json);
        model.glb()
    };
    let copies = |scales: usize| {
        let mut model = Model::cube();
        model.floats(&[[1.0, 1.0, 1.0]; 2]);
        model.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {
            "attributes": {"TRANSLATION": 0, "SCALE": scales},
        }});
        model.glb()
    };
    for (bytes, words) in [
        (
            plain.as_bytes()[..200].to_vec(),
            "the glTF description cannot be read: EOF",
        ),
        (b"[]".to_vec(), "expected a JSON object"),
        (format!("\"{long}\"").into_bytes(), "invalid type: string"),
        (
            plain.replace("[{\"mesh\":0}]", &deep).into_bytes(),
            "recursion limit exceeded",
        ),
        (
            changed(&|json| json["nodes"] = json!({"0": {"mesh": 0}})),
            "nodes is an object, not a list",
        ),
        (
            changed(&|json| json["nodes"][0]["mesh"] = json!("first")),
            "nodes[0].mesh is `first`, not a whole number from 0",
        ),
        (
            changed(&|json| json["nodes"][0]["mesh"] = json!(long.as_str())),
            "nodes[0].mesh is `nnn",
        ),
        (
            changed(&|json| json["nodes"][0]["mesh"] = json!(1e300)),
            "nodes[0].mesh names mesh 18446744073709551615, and the file has 1",
        ),
        (
            changed(&|json| json["nodes"][0]["translation"] = json!([1, 2])),
            "nodes[0].translation is a list of 2, not 3 numbers",
        ),
        (
            changed(&|json| json["nodes"][0]["rotation"] = json!([0, 0, null, 1])),
            "nodes[0].rotation[2] is null, not a number",
        ),
        (
            changed(&|json| {
                json["nodes"] = json!([
                    {"scale": [1e300, 1, 1], "children": [1]}, {"scale": [1e300, 1, 1], "mesh": 0},
                ]);
            }),
            "the transform of nodes[1] is not finite",
        ),
        (
            changed(&|json| json["accessors"][0]["count"] = Value::Null),
            "accessors[0].count is missing",
        ),
        (
            changed(&|json| json["accessors"][0]["type"] = json!(long.as_str())),
            "should be of the type VEC3, and is `nnn",
        ),
        (
            changed(&|json| {
                json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 1}]);
                json["meshes"][0]["weights"] = json!([1]);
            }),
            "meshes[0].primitives[0].targets[0].POSITION (accessors[1]) should be of the type VEC3",
        ),
        (
            changed(&|json| json["extensionsRequired"] = json!([long.as_str()])),
            "requires the extension nnn",
        ),
        (
            changed(&|json| json["buffers"] = json!([{"byteLength": 8, "uri": long.as_str()}])),
            "the model refers to `nnn",
        ),
        (
            changed(&|json| {
                json["buffers"] = json!([{"byteLength": 1e300}]);
                json["bufferViews"][0]["byteLength"] = json!(1e300);
                json["accessors"][0]["count"] = json!(1e18);
            }),
            "buffers[0] should have 18446744073709551615 bytes, and has 132",
        ),
        (
            copies(99),
            "attributes.SCALE names accessor 99, and the file has 3",
        ),
        (
            copies(2),
            "nodes[0].extensions.EXT_mesh_gpu_instancing.attributes have different counts: [8, 2]",
        ),
        (
            skinned(&|json| json["skins"][0]["joints"] = json!([1])),
            "attributes.JOINTS_0 names joint 1 at vertex 2, and skins[0] has 1",
        ),
        (
            skinned(&|json| json["skins"][0]["joints"] = json!([1, 9])),
            "skins[0].joints[1] names node 9, and the file has 3",
        ),
        (
            skinned(&|json| json["nodes"][0]["skin"] = json!(4)),
            "nodes[0].skin names skin 4, and the file has 1",
        ),
        (
            skinned(&|json| {
                json["scenes"] = json!([{"nodes": [0]}]);
                json["nodes"][1] = json!({"children": [2]});
                json["nodes"][2] = json!({"children": [1]});
            }),
            "nodes[1] is its own ancestor",
        ),
        (
            skinned(&|json| json["accessors"][3]["count"] = json!(7)),
            "attributes.WEIGHTS_0 has 7 elements for 8 vertices",
        ),
    ] {
        let begin = Instant::now();
        let problem = problem(&bytes);
        assert!(problem.contains(words), "{problem}\n  should have: {words}");
        assert!(problem.chars().count() < 300, "{problem}");
        assert!(begin.elapsed() < Duration::from_secs(5), "{words}");
    }
}

/// Damage to a file that has nearly everything makes no reader panic.
#[test]
fn no_mutation_of_a_rich_file_panics() {
    let mut model = Model::skinned(1.0);
    model.add_lift(4.0);
    model.json["meshes"][0]["weights"] = json!([1]);
    let sparse = json!({
        "count": 1, "indices": {"bufferView": 1, "componentType": 5121}, "values": {"bufferView": 0},
    });
    model.json["accessors"][0]["sparse"] = sparse;
    let times = model.floats(&[[0.0], [2.0]]);
    let moves = model.floats(&[[0.0, 0.0, 0.0], [6.0, 0.0, 0.0]]);
    model.json["animations"] = json!([{
        "samplers": [{"input": times, "output": moves}],
        "channels": [{"sampler": 0, "target": {"node": 3, "path": "translation"}}],
    }]);
    let copies = json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": moves}}});
    let nodes = model.json["nodes"].as_array_mut().unwrap();
    nodes.push(json!({"mesh": 0, "extensions": copies}));
    model.json["scenes"] = json!([{"nodes": [0, 1, 2, 3]}]);
    let (text, binary) = (model.text(), model.binary.clone());
    assert_eq!(soup(&suite::glb(&text, &binary)).triangles.len(), 36);
    let mut refused = 0;
    for round in 0..4000 {
        // The damage is in the JSON, not in the container, which has tests of its own.
        let mut damaged = text.clone().into_bytes();
        mutate(&mut damaged, random(11, round, 1, Purpose::Start));
        let damaged = String::from_utf8_lossy(&damaged);
        let glb = suite::glb(&damaged, &binary);
        refused += usize::from(problem(&glb) != "nothing");
        let _ = read_track(&glb, Path::new(""));
    }
    assert!((500..3500).contains(&refused), "{refused} of 4000 refused");
}

/// An unusable animation is skipped for the next one that moves a node.
#[test]
fn the_first_animation_that_moves_a_node_is_followed() {
    let mut model = Model::cube();
    let times = model.floats(&[[0.0], [2.0]]);
    let moves = model.floats(&[[0.0, 0.0, 0.0], [6.0, 0.0, 0.0]]);
    let samplers = json!([{"input": times, "output": moves}]);
    model.json["animations"] = json!([
        {"samplers": samplers, "channels": [{"sampler": 0, "target": {"path": "rotation"}}]},
        {"channels": [{"target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {}}}}]},
        {"channels": [{"sampler": 7, "target": {"node": 0, "path": "weights"}}]},
        {"samplers": samplers, "channels": [
            {"sampler": 9, "target": {"node": 0, "path": "pointer"}},
            {"sampler": 0, "target": {"node": 0, "path": "translation"}},
        ]},
    ]);
    let track = read_track(&model.glb(), Path::new("")).unwrap();
    assert_eq!(track.duration(), 2.0);
    assert!(track.at(0.5).1.abs_diff_eq(DVec3::new(1.5, 0.0, 0.0), 1e-9));

    let mut animations = model.json["animations"].as_array().unwrap().clone();
    for (left, words) in [
        (3, "changes the shape of node 0"),
        (2, "no animation that moves a node, of 2"),
        (0, "the model has no animation"),
    ] {
        animations.truncate(left);
        model.json["animations"] = json!(animations);
        let problem = read_track(&model.glb(), Path::new("")).unwrap_err();
        assert!(problem.to_string().contains(words), "{problem}");
    }
}

/// Reads a file that may cost only so much work, once for its triangles or once for its animation.
fn read_within(work: u64, model: &Model, is_track: bool) -> Result<(), MeshProblem> {
    let bytes = model.glb();
    let (json, blob) = glb::split(&bytes)?;
    let json = super::json::parse(json)?;
    let mut buffers = Buffers::new(&json, blob, Path::new(""));
    buffers.work_left = work;
    if is_track {
        animation::track(&mut buffers).map(|_| ())
    } else {
        let mut reader = Reader::new(buffers, u64::MAX);
        reader.add_scene()
    }
}

const TOO_OFTEN: &str = "the file names the same data too often";

impl Model {
    /// An accessor of zeros that takes no bytes.
    fn zeros(&mut self, kind: &str, count: usize) -> usize {
        self.push_accessor(json!({
            "componentType": 5126, "count": count, "type": kind,
            "sparse": {"count": 0, "indices": {"bufferView": 1, "componentType": 5121},
                "values": {"bufferView": 0}},
        }))
    }

    /// Replaces the nodes, all at the top of the scene.
    fn set_nodes(&mut self, nodes: Vec<Value>) {
        self.json["scenes"] = json!([{"nodes": (0..nodes.len()).collect::<Vec<_>>()}]);
        self.json["nodes"] = Value::Array(nodes);
    }

    /// A primitive with these attributes and no indices.
    fn set_primitives(&mut self, count: usize, attributes: &Value) {
        let primitive = json!({ "attributes": attributes });
        self.json["meshes"][0]["primitives"] = Value::Array(vec![primitive; count]);
    }

    /// An animation whose sampler of a number moves the node of that number.
    fn animate(&mut self, samplers: &[[usize; 2]], path: &str) {
        let sampler = |&[input, output]: &[usize; 2]| json!({"input": input, "output": output});
        let samplers: Vec<Value> = samplers.iter().map(sampler).collect();
        let channel = |node| json!({"sampler": node, "target": {"node": node, "path": path}});
        let channels: Vec<Value> = (0..samplers.len()).map(channel).collect();
        self.json["animations"] = json!([{"samplers": samplers, "channels": channels}]);
    }
}

/// A small file can refer to data many times, nested. Each line is a file with a number of such references: with a few it is read, with
/// many it is refused.
#[test]
fn work_that_a_small_file_multiplies_is_refused() {
    type Make = fn(&mut Model, usize);
    let lines: [(&str, usize, bool, Make); 14] = [
        ("nodes and empty primitives", 300, false, |model, many| {
            model.set_primitives(many, &json!({}));
            model.set_nodes(vec![json!({"mesh": 0}); many]);
        }),
        ("nodes and extensions", 100, false, |model, many| {
            let names = (0..many).map(|i| (format!("KHR_materials_{i}"), json!({})));
            model.json["meshes"][0]["extensions"] = Value::Object(names.collect());
            model.set_primitives(0, &json!({}));
            model.set_nodes(vec![json!({"mesh": 0}); many]);
        }),
        ("nodes and weights of zero", 1500, false, |model, many| {
            model.json["meshes"][0]["weights"] = json!(vec![0; many]);
            model.set_primitives(0, &json!({}));
            model.set_nodes(vec![json!({"mesh": 0}); many]);
        }),
        ("targets of one accessor", 100, false, |model, many| {
            let zeros = model.zeros("VEC3", 10_000);
            model.set_primitives(1, &json!({ "POSITION": zeros }));
            (0..many).for_each(|_| model.add_target(zeros));
            model.json["meshes"][0]["weights"] = json!(vec![1; many]);
        }),
        (
            "nodes and targets without positions",
            100,
            false,
            |model, many| {
                let target = json!({ "NORMAL": 0 });
                model.json["meshes"][0]["primitives"][0]["targets"] = json!(vec![target; many]);
                model.json["meshes"][0]["weights"] = json!(vec![1; many]);
                model.set_nodes(vec![json!({"mesh": 0}); many]);
            },
        ),
        ("many values for one element", 40, false, |model, many| {
            let sparse = sparse_of_one(model, 10_000);
            model.set_primitives(many, &json!({ "POSITION": sparse }));
        }),
        ("many places without values", 100, false, |model, many| {
            let sparse = sparse_of_one(model, 10_000);
            model.json["accessors"][sparse]["type"] = json!("VEC2");
            model.json["accessors"][sparse]["sparse"]["values"] = json!({"bufferView": 99});
            model.set_primitives(many, &json!({"POSITION": 0, "TEXCOORD_0": sparse}));
        }),
        ("copies by one accessor", 100, false, |model, many| {
            let zeros = model.zeros("VEC3", 1000);
            model.set_primitives(0, &json!({}));
            model.set_nodes(vec![instanced(zeros); many]);
        }),
        ("copies of nothing", 100, false, |model, many| {
            let zeros = model.zeros("VEC3", 1000);
            let empty = model.zeros("VEC3", 0);
            model.set_primitives(many, &json!({ "POSITION": empty }));
            model.set_nodes(vec![instanced(zeros)]);
        }),
        ("sets of joints", 3000, false, |model, many| {
            *model = Model::skinned(1.0);
            let attributes = &mut model.json["meshes"][0]["primitives"][0]["attributes"];
            for set in 1..many {
                attributes[format!("JOINTS_{set}")] = attributes["JOINTS_0"].clone();
                attributes[format!("WEIGHTS_{set}")] = attributes["WEIGHTS_0"].clone();
            }
        }),
        ("skins of one accessor", 100, false, |model, many| {
            *model = Model::skinned(1.0);
            let zeros = model.zeros("MAT4", 1000);
            let skin = json!({"joints": [0], "inverseBindMatrices": zeros});
            model.json["skins"] = Value::Array(vec![skin; many]);
            model.set_primitives(0, &json!({}));
            let node = |skin| json!({"mesh": 0, "skin": skin});
            model.set_nodes((0..many).map(node).collect());
        }),
        ("damaged texture coordinates", 100, false, |model, many| {
            let zeros = model.zeros("VEC2", 10_000);
            let far = model.view(&[0xff; 4]);
            let sparse = &mut model.json["accessors"][zeros]["sparse"];
            sparse["count"] = json!(1);
            sparse["indices"] = json!({"bufferView": far, "componentType": 5125});
            model.set_primitives(many, &json!({"POSITION": 0, "TEXCOORD_0": zeros}));
        }),
        ("keys of one sampler", 30, true, |model, many| {
            let times: Vec<[f64; 1]> = (0..1000).map(|key| [f64::from(key)]).collect();
            let times = model.floats(&times);
            let zeros = model.zeros("VEC3", 1000);
            model.animate(&[[times, zeros]], "translation");
            // All but the first move a node without a mesh, so they have no values to be checked.
            model.set_nodes(vec![json!({"mesh": 0}), json!({})]);
            let channels = &mut model.json["animations"][0]["channels"];
            let mut channel = channels[0].clone();
            channel["target"]["node"] = json!(1);
            channels.as_array_mut().unwrap().resize(many, channel);
        }),
        ("keys and nodes", 100, true, |model, many| {
            let zeros = model.zeros("VEC3", 10);
            let times = |sampler: usize| -> Vec<[f64; 1]> {
                (0..10).map(|key| [(10 * sampler + key) as f64]).collect()
            };
            let samplers: Vec<[usize; 2]> = (0..many)
                .map(|sampler| [model.floats(&times(sampler)), zeros])
                .collect();
            model.animate(&samplers, "translation");
            model.set_nodes(vec![json!({"mesh": 0}); many]);
        }),
    ];
    for (name, many, is_track, make) in lines {
        for (many, is_read) in [(3, true), (many, false)] {
            let mut model = Model::cube();
            make(&mut model, many);
            assert!(model.glb().len() < 200_000, "{name}");
            let begin = Instant::now();
            match read_within(1 << 20, &model, is_track) {
                Ok(()) => assert!(is_read, "{name}: {many} are read"),
                Err(problem) => {
                    let is_refused = !is_read && problem.to_string().contains(TOO_OFTEN);
                    assert!(is_refused, "{name}, {many}: {problem}");
                }
            }
            assert!(begin.elapsed() < Duration::from_secs(5), "{name}");
        }
    }
}

/// An accessor of one element that has so many values, all but the last of them unused.
fn sparse_of_one(model: &mut Model, values: usize) -> usize {
    let places = model.view(&vec![0; values]);
    let values_view = model.view(&vec![0; 12 * values]);
    let accessor = model.zeros("VEC3", 1);
    model.json["accessors"][accessor]["sparse"] = json!({
        "count": values,
        "indices": {"bufferView": places, "componentType": 5121},
        "values": {"bufferView": values_view},
    });
    accessor
}

/// A node that shows copies of the mesh.
fn instanced(translations: usize) -> Value {
    let attributes = json!({ "TRANSLATION": translations });
    json!({"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}}})
}

/// The bytes of every buffer count, also if several name one file.
#[test]
fn buffers_that_name_one_file_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("points.bin"), vec![0; 1 << 20]).unwrap();
    let read = |buffers: usize| {
        let mut model = Model::cube();
        let buffer = json!({"uri": "points.bin", "byteLength": 1 << 20});
        model.json["buffers"] = Value::Array(vec![buffer; buffers]);
        let view = |buffer| json!({"buffer": buffer, "byteLength": 96});
        model.json["bufferViews"] = (0..buffers).map(view).collect();
        let accessor =
            |view| json!({"bufferView": view, "componentType": 5126, "count": 8, "type": "VEC3"});
        model.json["accessors"] = (0..buffers).map(accessor).collect();
        let primitive = |accessor| json!({"attributes": {"POSITION": accessor}});
        model.json["meshes"][0]["primitives"] = (0..buffers).map(primitive).collect();
        let json = super::json::parse(model.text().as_bytes()).unwrap();
        let mut buffers = Buffers::new(&json, None, folder.path());
        buffers.bytes_left = 5 << 19;
        Reader::new(buffers, u64::MAX).add_scene()
    };
    assert_eq!(read(2), Ok(()));
    let problem = read(3).unwrap_err().to_string();
    assert!(problem.contains(TOO_OFTEN), "{problem}");
}

/// Chains of nodes and objects with many members are read in a time that grows as the file does.
#[test]
fn deep_chains_and_wide_objects_are_read_at_once() {
    let begin = Instant::now();
    let mut model = Model::cube();
    let times = model.floats(&[[0.0], [2.0]]);
    let moves = model.floats(&[[0.0, 0.0, 0.0], [6.0, 0.0, 0.0]]);
    let depth = 30_000;
    let node = |index| json!({"mesh": 0, "children": [index + 1]});
    let mut nodes: Vec<Value> = (0..depth).map(node).collect();
    nodes.push(json!({"mesh": 0}));
    model.json["nodes"] = Value::Array(nodes);
    model.animate(&[[times, moves]], "translation");
    let track = read_track(&model.glb(), Path::new("")).unwrap();
    assert!(track.at(1.0).1.abs_diff_eq(DVec3::new(3.0, 0.0, 0.0), 1e-9));
    assert!(begin.elapsed() < Duration::from_secs(5));

    let begin = Instant::now();
    let mut model = Model::cube();
    for member in 0..100_000 {
        model.json["accessors"][0][format!("{member}")] = json!(0);
    }
    let points = json!({"attributes": {"POSITION": 0}, "mode": 0});
    let primitives = model.json["meshes"][0]["primitives"]
        .as_array_mut()
        .unwrap();
    primitives.resize(50_000, points);
    assert_measures("many members", &soup(&model.glb()), &cube());
    assert!(begin.elapsed() < Duration::from_secs(5));
}

/// Nodes that move below others that move or stand still. The first turns by 90 degrees about Y in two seconds.
#[test]
fn animations_of_several_nodes_are_followed_where_meshes_move_alike() {
    let half = 0.5_f64.sqrt();
    let animated = |nodes: Value, path: &str| {
        let mut model = Model::cube();
        let times = model.floats(&[[0.0], [2.0]]);
        let turns = model.floats(&[[0.0, 0.0, 0.0, 1.0], [0.0, half, 0.0, half]]);
        let moves = model.floats(&[[0.0, 0.0, 0.0], [6.0, 0.0, 0.0]]);
        model.animate(&[[times, turns], [times, moves]], "rotation");
        model.json["animations"][0]["channels"][1]["target"]["path"] = json!(path);
        model.json["nodes"] = nodes;
        // Without scenes, all nodes are shown.
        model.json["scenes"] = Value::Null;
        model.json["scene"] = Value::Null;
        read_track(&model.glb(), Path::new("")).map_err(|problem| problem.to_string())
    };
    // Node 1 moves along X of node 0, which has turned X to -Z; the scale between them doubles the way.
    let below = |more: Value| {
        json!([
            {"children": [2]},
            {"children": [3, 4]},
            {"children": [1], "scale": [2, 2, 2], "translation": [0, 5, 0]},
            {"mesh": 0, "scale": [1, 2, 3]},
            more,
        ])
    };
    for more in [
        json!({}),
        json!({"mesh": 0}),
        json!({"mesh": 0, "translation": [9, 9, 9]}),
    ] {
        let track = animated(below(more), "translation").unwrap();
        assert_eq!(track.duration(), 2.0);
        let (turn, moved) = track.at(1.0);
        let expected = DVec3::new(6.0 * half, 0.0, -6.0 * half);
        assert!(moved.abs_diff_eq(expected, 1e-6), "{moved}");
        let x = turn * DVec3::X;
        assert!(x.abs_diff_eq(DVec3::new(half, 0.0, -half), 1e-6), "{x}");
    }
    // A mesh above the node that moves, and one that stands still.
    let mut above = below(json!({}));
    above[2]["mesh"] = json!(0);
    for (nodes, path, words) in [
        (above, "translation", "its parts have moved differently"),
        (
            json!([{"mesh": 0}, {"mesh": 0}]),
            "translation",
            "its parts have moved differently",
        ),
        (
            json!([{}, {"mesh": 0}, {"mesh": 0}]),
            "translation",
            "its parts have moved differently",
        ),
        (
            json!([{"mesh": 0}, {"mesh": 0}]),
            "scale",
            "scales or skews the model",
        ),
        (
            json!([{}, {}, {"mesh": 0}]),
            "translation",
            "moves none of the nodes that have a mesh",
        ),
    ] {
        let problem = animated(nodes, path).unwrap_err();
        assert!(problem.contains(words), "{problem}\n  should have: {words}");
    }
}

/// Catches a file of some kilobytes that shows the same triangles again and again, until memory is full.
#[test]
fn triangles_for_which_there_is_no_room_are_counted_and_not_kept() {
    let model = Model::with(|json| {
        let cube = json["meshes"][0]["primitives"][0].clone();
        json["meshes"][0]["primitives"] = json!(vec![cube; 50]);
        json["nodes"] = json!(vec![json!({"mesh": 0}); 20]);
        json["scenes"] = json!([{"nodes": (0..20).collect::<Vec<_>>()}]);
    });
    let glb = model.glb();
    let read = |most| super::read(&glb, Path::new(""), Extent::Scene, most);
    let whole = read(12_000).expect("there is room");
    assert_eq!(whole.triangles.len(), 12_000);
    match read(11_999) {
        Err(MeshProblem::NoRoom { count, most }) => assert_eq!((count, most), (12_000, 11_999)),
        other => panic!("{:?}", other.map(|soup| soup.triangles.len())),
    }
}

/// Catches unused vertices that are stored repeatedly, and corners that lose their vertex.
#[test]
fn vertices_that_no_triangle_uses_are_left_out_where_they_are_many() {
    let mut model = Model::cube();
    let mut positions = vec![[9.0; 3]; 1000];
    positions.extend(corners());
    let many = model.floats(&positions);
    let moved: Vec<u8> = SIDES
        .iter()
        .flat_map(|&vertex| (1000 + u16::from(vertex)).to_le_bytes())
        .collect();
    let indices = model.accessor("SCALAR", 5123, 36, &moved);
    model.json["meshes"][0]["primitives"][0] =
        json!({"attributes": {"POSITION": many}, "indices": indices});
    let read = super::read(&model.glb(), Path::new(""), Extent::Scene, u64::MAX);
    let soup = read.expect("it is whole");
    assert_eq!((soup.positions.len(), soup.triangles.len()), (8, 12));
    let volume: f64 = (soup.triangles.iter())
        .map(|t| t.map(|vertex| soup.positions[vertex as usize]))
        .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
        .sum();
    assert!((volume - 8.0).abs() < 1e-9, "{volume}");
}
