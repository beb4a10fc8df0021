//! Tests with broken models: each is refused with a helpful message, and none makes a reader panic.
//!
//! They call the readers directly, because [`super::load`] catches panics.

use std::path::Path;
use std::process::Command;

use super::error::MeshProblem;
use super::load::{Extent, parse};
use super::text_files::{self, Encoding};
use super::{Mesh, suite};

pub(super) fn try_mesh(
    path: impl AsRef<Path>,
    bytes: &[u8],
    extent: Extent,
) -> Result<Mesh, MeshProblem> {
    Mesh::from_soup("test", parse(path.as_ref(), bytes, extent)?)
}

/// The error message for a model.
fn problem_of(path: &str, bytes: &[u8]) -> String {
    match try_mesh(path, bytes, Extent::Scene) {
        Ok(mesh) => format!("nothing: {}", mesh.report),
        Err(problem) => problem.to_string(),
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

#[test]
fn bad_obj_files_are_explained() {
    let with = |text: &str| format!("{TRIANGLE}{text}");
    for (text, words) in [
        (String::new(), "neither vertices nor faces"),
        ("# nothing\n".to_owned(), "neither vertices nor faces"),
        (
            "\u{0}\u{1}\u{fffd}PNG\n".to_owned(),
            "neither vertices nor faces",
        ),
        (with(""), "the file holds only 3 vertices. Export"),
        (
            with("l 1 2\nl 1 2 3\np 1\n"),
            "only 3 vertices, 2 lines, 1 point",
        ),
        (with("f 1 2\nf 3\n"), "only 3 vertices, 1 line, 1 point"),
        (
            with("f 1 2 3\nf 1 2 4\n"),
            "face 1 (line 5) names vertex 4, and the file has 1 to 3",
        ),
        (
            with("f 0 1 2\n"),
            "face 0 (line 4) names vertex 0, and the file has 1 to 3",
        ),
        (with("f -1 -2 -4\n"), "face 0 (line 4) names vertex -4"),
        (with("f 1 2 99999999999\n"), "names vertex 99999999999"),
        (
            "f 1 2 3\n".to_owned(),
            "names vertex 1, and the file has none",
        ),
        (
            with("f 1 2 -9223372036854775808\n"),
            "names vertex -9223372036854775808",
        ),
        (with("f 1 2 9999999999999999999\n"), "line 4 cannot be read"),
        (
            with("vt 0 0\nf 1/1 2/1 3/2\n"),
            "(line 5) names texture coordinate 2, and the file has 1 to 1",
        ),
        (
            with("f 1 2 three\n"),
            "line 4 cannot be read, a face is made of VERTEX/TEXTURE/NORMAL",
        ),
        (with("f 1/1/1/1 2 3\n"), "line 4 cannot be read"),
        (with("f /1 2 3\n"), "line 4 cannot be read"),
        (
            with("f\n"),
            "line 4 cannot be read, a face needs three corners",
        ),
        (
            "v 0 0 0\nv 1 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
            "line 2 cannot be read, a vertex needs three numbers: `v 1 0`",
        ),
        ("v 0 0 zero\n".to_owned(), "line 1 cannot be read"),
        ("v\n".to_owned(), "line 1 cannot be read"),
        (
            "curv 0 1 1 2\n".to_owned(),
            "the file holds only 1 line of curves or free-form surfaces",
        ),
        (
            "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
            "vertex 1 (line 2) is not finite: [NaN, 0.0, 0.0], used by face 0",
        ),
        (
            "v 0 0 0\nv 0 inf 0\nv 0 1 0\n\nf 1 2 3\n".to_owned(),
            "vertex 1 (line 2) is not finite",
        ),
        (
            "v 0 0 0\nv 0 1 1e400\nv 0 1 0\nf 1 2 3\n".to_owned(),
            "vertex 1 (line 2) is not finite: [0.0, 1.0, inf]",
        ),
        (
            format!("v 0 0 0\nv 0 -{} 0\nv 0 1 0\nf 1 2 3\n", "9".repeat(400)),
            "vertex 1 (line 2) is not finite: [0.0, -inf, 0.0]",
        ),
        (
            format!("v 0 0 0\nv 4{} 0 0\nv 0 1 0\nf 1 2 3\n", "0".repeat(38)),
            "vertex 1 (line 2) is not finite: [inf, 0.0, 0.0]",
        ),
        (
            with("f 1,5 2 3\n"),
            "line 4 cannot be read, a face is made of VERTEX/TEXTURE/NORMAL numbers: `f 1,5 2 3`",
        ),
        (with("f 1 1 2\n"), "of 1 triangles none has an area"),
        (
            "v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n".to_owned(),
            "none has an area",
        ),
        (
            "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nf 1 2 3\n".to_owned(),
            "coordinates reach 1.0000000150474662e30",
        ),
        (
            "v 0 0 0\nv 1e-30 0 0\nv 0 1e-30 0\nf 1 2 3\n".to_owned(),
            "scale it up",
        ),
        (
            "v 0 0 0\nv 1e-40 0 0\nv 0 1e-40 0\nf 1 2 3\n".to_owned(),
            "scale it up",
        ),
        (
            "v 0 0 0\nv 1,5 0 0\nv 0 1 0\nf 1 2 3\n".to_owned(),
            "line 2 cannot be read, `1,5` needs a decimal point, not a comma: `v 1,5 0 0`",
        ),
        (
            "v 0 0 0\nv 1 0 0\nv 0 -1.0D+05 0\nf 1 2 3\n".to_owned(),
            "line 3 cannot be read, `-1.0D+05` needs an exponent with E, not D",
        ),
        (
            with("f 1 \\\r\n 2 \\\r\n x\r\n"),
            "line 4 cannot be read, a face is made of",
        ),
        (
            with("vt 0 0\nf 1/-1 2/-1 3/-2\n"),
            "(line 5) names texture coordinate -2, and the file has 1 to 1",
        ),
        (
            format!("v 0 0 {}\n", "9x".repeat(1000)),
            "9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x9x`",
        ),
        (
            "v 0 0 0\rv 1 0\rv 0 1 0\rf 1 2 3\r".to_owned(),
            "line 2 cannot be read, a vertex needs three numbers: `v 1 0`",
        ),
        (
            "v 0 0 \u{7}\n".to_owned(),
            "a vertex needs three numbers: `v 0 0 \u{fffd}`",
        ),
    ] {
        let problem = problem_of("bad.obj", text.as_bytes());
        assert!(
            problem.contains(words),
            "{text}\n  {problem}\n  should have: {words}"
        );
    }
}

#[test]
fn sloppy_obj_files_are_read() {
    for text in [
        "\u{feff}v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
        "v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 2\nf 1 2 3 # the face\n",
        "mtllib ../../etc/passwd\nv 0 0 0\nv 1 0 0\ng\nv 0 1 0\nusemtl\ng a b\nf 1 \\\n 2 3\n",
        "f 1//9 2//9 3//9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan nan nan\nf -4/7 -3/7 -2/7\n",
    ] {
        let mesh = try_mesh("sloppy.obj", text.as_bytes(), Extent::Scene);
        assert_eq!(mesh.unwrap().report.triangles, 1, "{text}");
    }
    let latin = b"# Fl\xe4che\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    assert!(try_mesh("latin.OBJ", latin, Extent::Scene).is_ok());
}

/// Fails unless the problem with a file is put into these words, in one sentence of a sensible length.
fn assert_explained(name: &str, bytes: &[u8], words: &str) {
    let problem = problem_of(name, bytes);
    assert!(
        problem.contains(words) && problem.len() < 300,
        "{}\n  {problem}\n  should have: {words}",
        String::from_utf8_lossy(&bytes[..bytes.len().min(400)])
    );
}

/// STL files that are cut off, miscounted or no STL files are refused with counts, lines and bytes.
#[test]
fn bad_stl_files_are_explained() {
    let cube = Mesh::builtin("cube").unwrap();
    let good = text_files::stl(&cube, "solid cube");
    let with_count = |count: u32| {
        let mut bytes = good.clone();
        bytes[80..84].copy_from_slice(&count.to_le_bytes());
        bytes
    };
    let with_float = |value: f32| {
        let mut bytes = good.clone();
        bytes[84 + 12..84 + 16].copy_from_slice(&value.to_le_bytes());
        bytes
    };
    for (bytes, words) in [
        (Vec::new(), "this is no STL file: it has 0 bytes"),
        (good[..83].to_vec(), "it has 83 bytes"),
        (b"Hello".to_vec(), "this is no STL file: it has 5 bytes"),
        (
            good[..84].to_vec(),
            "the STL header counts 12 triangles, which is 684 bytes, and the file has 84 bytes, room for 0. The file is",
        ),
        (
            good[..400].to_vec(),
            "counts 12 triangles, which is 684 bytes, and the file has 400 bytes, room for 6",
        ),
        (
            with_count(u32::MAX),
            "counts 4294967295 triangles, which is 214748364834 bytes, and the file has 684 bytes, room for 12",
        ),
        (
            with_count(0)[..84].to_vec(),
            "there are no triangles: the STL file holds no facets",
        ),
        (with_float(f32::NAN), "vertex 0 is not finite: [NaN, "),
        (with_float(f32::INFINITY), "vertex 0 is not finite: [inf, "),
        (with_float(1e30), "coordinates reach"),
    ] {
        assert_explained("bad.stl", &bytes, words);
    }

    let text = text_files::stl_text(&cube);
    let vertex = text.lines().nth(3).unwrap();
    let edited = |line: &str| text.replacen(vertex, line, 1);
    for (text, words) in [
        (
            "solid\nendsolid\n".to_owned(),
            "the STL file holds no facets",
        ),
        (
            edited("vertex 1 2"),
            "line 4 cannot be read, a vertex needs three numbers: `vertex 1 2`",
        ),
        (
            edited("vertex 1 2 z"),
            "line 4 cannot be read, a vertex needs three numbers",
        ),
        (
            edited("vertex 1,5 2 3"),
            "line 4 cannot be read, `1,5` needs a decimal point",
        ),
        (
            edited("vertex nan 2 3"),
            "vertex 0 (line 4) is not finite: [NaN, 2.0, 3.0], used by face 0",
        ),
        (edited("vertex 1 1e39 3"), "vertex 0 (line 4) is not finite"),
        (
            edited(""),
            "line 7 cannot be read, a facet needs three vertices",
        ),
        (
            text.replacen("endloop", "", 1).replacen("endfacet", "", 1),
            "line 9 cannot be read, the facet before has no `endloop`",
        ),
        (
            text[..text.rfind("endloop").unwrap()].to_owned(),
            "the STL text ends within a facet, after 11 whole ones. The file is damaged or cut off",
        ),
        (
            text[..text.find("outer").unwrap()].to_owned(),
            "the STL text ends within a facet, after 0 whole ones",
        ),
        (
            text[..text.rfind("endfacet").unwrap()].to_owned(),
            "the STL text ends within a facet, after 12 whole ones",
        ),
    ] {
        assert_explained("bad.stl", text.as_bytes(), words);
    }
}

/// No count or type in a PLY header is trusted, and errors have their place.
#[test]
fn bad_ply_files_are_explained() {
    for encoding in [Encoding::Ascii, Encoding::Little, Encoding::Big] {
        let good = text_files::cube_ply(encoding);
        // The header is text, so it can be edited as such.
        let edited = |from: &str, to: &str| {
            let at = good
                .windows(from.len())
                .position(|bytes| bytes == from.as_bytes())
                .unwrap();
            let mut bytes = good.clone();
            bytes.splice(at..at + from.len(), to.bytes());
            bytes
        };
        let cut = |from_end: usize| good[..good.len() - from_end].to_vec();
        for (bytes, words) in [
            (
                cut(12),
                "the header counts 6 elements `face`, and the file ends in number 5, at byte",
            ),
            (good[..100].to_vec(), "the PLY header ends in line"),
            (
                edited("vertex 8", "vertex 18446744073709551615"),
                "18446744073709551615 elements `vertex`, and the file ends in number",
            ),
            (
                edited("face 6", "face 7"),
                "the header counts 7 elements `face`, and the file ends in number 6",
            ),
            (
                edited("element vertex", "element x"),
                "names vertex 0, and the file has none",
            ),
            (
                edited(
                    "element face 6",
                    "element x 1\nproperty list int double y\nelement face 9999999999",
                ),
                "The file is damaged",
            ),
            (
                edited("vertex_indices", "vertices"),
                "the elements `face` of the PLY file have no list `vertex_indices`",
            ),
            (
                edited("property float y", "property float why"),
                "the vertices of the PLY file have no `y`",
            ),
            (
                edited("element face", "element edge"),
                "there are no triangles: the file is a cloud of 8 points, with 6 lines. Export",
            ),
            (
                edited("float y", "float128 y"),
                "line 5 cannot be read, a property needs types (char to double) and a name: `property float128 y`",
            ),
            (
                edited("element vertex 8", "element vertex -8"),
                "line 3 cannot be read, an element needs a name and a count",
            ),
            (
                edited("element face 6", "element vertex 6"),
                "line 7 cannot be read, this element is there already",
            ),
            (
                edited("element vertex 8", "comment"),
                "line 4 cannot be read, there is no `element` line above",
            ),
            (
                edited("format", "comment"),
                "line 9 cannot be read, there is no `format` line above",
            ),
            (
                edited(" 1.0\n", "x 1.0\n"),
                "line 2 cannot be read, the format is ascii or binary",
            ),
            (
                edited("element face 6", "Blah blah"),
                "line 7 cannot be read, it is not a line of a PLY header: `Blah blah`",
            ),
            (
                edited("ply\n", "plx\n"),
                "this is no PLY file: its first line should be `ply`, and it begins with `plx",
            ),
            (
                edited("element face 6", "element 1,5 x"),
                "cannot be read, an element needs a name and a count: `element 1,5 x`",
            ),
            (Vec::new(), "this is no PLY file"),
        ] {
            assert_explained("bad.ply", &bytes, words);
        }

        let xyz = "property float x\nproperty float y\nproperty float z\n";
        let header =
            format!("element vertex 3\n{xyz}element face 1\nproperty list char int vertex_index\n");
        let file = |values: [f64; 3], length: f64, corners: [f64; 3]| {
            let rows = [
                ("f", vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0]),
                ("f", values.to_vec()),
                ("b", vec![length]),
                ("i", corners.to_vec()),
            ];
            text_files::ply(encoding, &header, &rows)
        };
        let good = [0.0, 1.0, 0.0];
        let (negative, nan) = (-1.0_f64, f64::NAN);
        for (bytes, words) in [
            (
                file(good, 3.0, [0.0, 1.0, 2.0]),
                "nothing: 1 triangle, 3 vertices",
            ),
            (
                file(good, 3.0, [0.0, 1.0, 3.0]),
                "face 0 names vertex 3, and the file has 0 to 2",
            ),
            (
                file(good, 3.0, [0.0, negative, 2.0]),
                "face 0 names vertex -1, and the file has 0 to 2",
            ),
            (
                file([0.0, nan, 0.0], 3.0, [0.0, 1.0, 2.0]),
                "vertex 2 is not finite: [0.0, NaN, 0.0], used by face 0",
            ),
            (
                file([f64::INFINITY, 1.0, 0.0], 3.0, [0.0, 1.0, 2.0]),
                "vertex 2 is not finite: [inf, 1.0, 0.0], used by face 0",
            ),
            (
                file(good, 2.0, [0.0, 1.0, 2.0]),
                "there are no triangles: the file is a cloud of 3 points, with 1 line.",
            ),
            (
                file(good, 127.0, [0.0, 1.0, 2.0]),
                "and the file ends in number 0",
            ),
            (
                file([0.0; 3], 3.0, [0.0, 1.0, 2.0]),
                "of 1 triangles none has an area",
            ),
        ] {
            assert_explained("bad.ply", &bytes, words);
        }
    }

    let point_cloud = "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\n\
        end_header\n0 0 0\n1 0 0\n";
    assert_explained(
        "cloud.ply",
        point_cloud.as_bytes(),
        "there are no triangles: the file is a cloud of 2 points. Export the model with its faces",
    );
    for (word, words) in [
        (
            "1,5",
            "line 9 cannot be read, `1,5` needs a decimal point, not a comma",
        ),
        ("one", "line 9 cannot be read, not a number: `one`"),
        (
            &"9x".repeat(5000),
            "line 9 cannot be read, not a number: `9x9x",
        ),
    ] {
        let text = point_cloud.replace("1 0 0", &format!("1 {word} 0"));
        assert_explained("cloud.ply", text.as_bytes(), words);
    }
    // Every element has its own name, however many there are.
    let mut many = "ply\nformat ascii 1.0\n".to_owned();
    for element in 0..100_000 {
        many += &format!("element e{element} 0\n");
    }
    many += "element e99999 0\n";
    assert_explained(
        "many.ply",
        many.as_bytes(),
        "line 100003 cannot be read, this element is there already",
    );
    let wide: Vec<u8> = "ply\nformat binary_little_endian 1.0\nend_header\n"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    assert_explained("wide.ply", &wide, "is UTF-16 text and announces binary");
    let no_number = String::from_utf8(text_files::cube_ply(Encoding::Ascii)).unwrap();
    assert_explained(
        "corner.ply",
        no_number.replace("4 4 5 7 6", "4 4 5.5 7 6").as_bytes(),
        "face 1 names vertex 5.5, which is no whole number",
    );
    // Lists of a negative length, or of one that is no whole number.
    for (length, value) in [("-1", "-1"), ("0.5", "0.5"), ("nan", "NaN")] {
        let text = format!(
            "ply\nformat ascii 1.0\nelement face 1\nproperty list int int vertex_indices\nend_header\n{length} 0 1 2\n"
        );
        let words = format!("a list of element `face` number 0 has the length {value}");
        assert_explained("list.ply", text.as_bytes(), &words);
    }
}

#[test]
fn bad_glb_files_are_explained() {
    let (json, binary) = suite::glb_parts(&suite::triangle());
    let good = suite::glb(&json, &binary);
    assert!(try_mesh("good.glb", &good, Extent::Scene).is_ok());

    let edited = |at: usize, word: u32| {
        let mut bytes = good.clone();
        bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
        bytes
    };
    let binary_chunk = 20 + json.len().next_multiple_of(4);
    for (bytes, words) in [
        (good[..3].to_vec(), "cannot be read"),
        (good[..10].to_vec(), "the GLB header is cut off"),
        (
            good[..100].to_vec(),
            "the JSON chunk of the GLB should have 420 bytes, and 80 follow. The file is damaged or cut off",
        ),
        (
            edited(4, 1),
            "this is GLB version 1, and only version 2 can be read",
        ),
        (good[..16].to_vec(), "has no JSON chunk"),
        (
            good[..good.len() - 4].to_vec(),
            "buffers[0] should have 48 bytes, and has 44",
        ),
        (
            edited(12, u32::MAX),
            "the JSON chunk of the GLB should have 4294967295 bytes",
        ),
        (edited(16, 7), "has no JSON chunk"),
        (edited(binary_chunk + 4, 7), "buffers[0] has no data"),
        (
            edited(good.len() - 4, 3),
            "face 0 names vertex 3, and the file has 0 to 2",
        ),
        (
            edited(good.len() - 12 - 36, 0x7fc0_0000),
            "vertex 0 is not finite: [NaN",
        ),
    ] {
        let problem = problem_of("bad.glb", &bytes);
        assert!(problem.contains(words), "{problem}\n  should have: {words}");
    }
}

#[test]
fn bad_gltf_descriptions_are_explained() {
    let (json, binary) = suite::glb_parts(&suite::triangle());
    for (from, to, words) in [
        (
            "{\"asset\"",
            "{\"asset",
            "the glTF description cannot be read",
        ),
        (
            "\"2.0\"",
            "\"1.0\"",
            "this is glTF 1.0, and only glTF 2 can be read",
        ),
        (
            "\"scene\":0",
            "\"scene\":9",
            "scene names scene 9, and the file has 1",
        ),
        (
            "\"nodes\":[0]",
            "\"nodes\":[5]",
            "scenes[0].nodes[0] names node 5, and the file has 1",
        ),
        (
            "\"nodes\":[0]",
            "\"nodes\":[]",
            "shows none, of 1 meshes in the file",
        ),
        (
            "{\"mesh\":0}",
            "{\"mesh\":1}",
            "nodes[0].mesh names mesh 1, and the file has 1",
        ),
        (
            "\"meshes\"",
            "\"mushes\"",
            "nodes[0].mesh names mesh 0, and the file has 0",
        ),
        ("{\"mesh\":0}", "{}", "shows none"),
        (
            "{\"mesh\":0}",
            "{\"mesh\":0,\"scale\":[1e38,1,1],\"children\":[0]}",
            "coordinates reach",
        ),
        (
            "{\"mesh\":0}",
            "{\"matrix\":[1e999,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1],\"mesh\":0}",
            "number out of range",
        ),
        (
            "\"POSITION\":0",
            "\"POSITION\":2",
            "meshes[0].primitives[0].attributes.POSITION names accessor 2, and the file has 2",
        ),
        (
            "\"POSITION\":0",
            "\"POSITION\":1",
            "meshes[0].primitives[0].attributes.POSITION (accessors[1]) should hold floats",
        ),
        (
            "\"indices\":1",
            "\"indices\":0",
            "meshes[0].primitives[0].indices (accessors[0]) should hold whole numbers",
        ),
        (
            "\"indices\":1",
            "\"indices\":1,\"mode\":9",
            "meshes[0].primitives[0].mode is 9, not 0 to 6",
        ),
        (
            "\"indices\":1",
            "\"indices\":1,\"mode\":0",
            "only lines and points (0 and 3)",
        ),
        (
            "\"indices\":1",
            "\"indices\":1,\"mode\":3",
            "only lines and points (2 and 0)",
        ),
        (
            "5125",
            "5126",
            "(accessors[1]) should hold whole numbers without a sign, and its component type is 5126",
        ),
        (
            "5126",
            "5125",
            "(accessors[0]) should hold floats, or whole numbers of one or two bytes, and its component type is 5125",
        ),
        ("5126", "77", "accessors[0].componentType is 77, not one of"),
        (
            "\"VEC3\"",
            "\"VEC9\"",
            "(accessors[0]) should be of the type VEC3, and is `VEC9`",
        ),
        (
            "\"count\":3,\"type\":\"SCALAR\"",
            "\"count\":2,\"type\":\"SCALAR\"",
            "shows none, of 1 meshes in the file",
        ),
        (
            "\"count\":3,\"type\":\"VEC3\"",
            "\"count\":1000000000000,\"type\":\"VEC3\"",
            "(accessors[0]) has 1000000000000 elements of 12 bytes, more than bufferViews[0] holds",
        ),
        (
            "\"count\":3,\"type\":\"VEC3\"",
            "\"count\":18446744073709551615,\"type\":\"VEC3\"",
            "more than bufferViews[0] holds",
        ),
        (
            "\"count\":3,\"type\":\"VEC3\"",
            "\"count\":-1,\"type\":\"VEC3\"",
            "accessors[0].count is -1, not a whole number from 0",
        ),
        (
            "\"bufferView\":0,\"componentType\"",
            "\"componentType\"",
            "meshes[0].primitives[0].attributes.POSITION names an accessor without data",
        ),
        (
            "\"bufferView\":0,\"componentType\"",
            "\"bufferView\":8,\"componentType\"",
            "accessors[0].bufferView names buffer view 8, and the file has 2",
        ),
        (
            "\"bufferView\":0,\"componentType\"",
            "\"bufferView\":0,\"byteOffset\":18446744073709551615,\"componentType\"",
            "more than bufferViews[0] holds",
        ),
        (
            "\"byteLength\":36}",
            "\"byteLength\":36,\"byteStride\":4}",
            "elements that overlap",
        ),
        (
            "\"byteLength\":36}",
            "\"byteLength\":36,\"byteStride\":18446744073709551615}",
            "more than bufferViews[0] holds",
        ),
        (
            "\"byteLength\":36}",
            "\"byteLength\":9000,\"byteOffset\":18446744073709551600}",
            "more than bufferViews[0] holds",
        ),
        (
            "{\"buffer\":0,\"byteLength\":36}",
            "{\"buffer\":3,\"byteLength\":36}",
            "bufferViews[0].buffer names buffer 3, and the file has 1",
        ),
        (
            "\"buffers\":[{",
            "\"buffers\":[{\"uri\":\"data:;base64,AAAA\",",
            "buffers[0] should have 48 bytes, and has 3",
        ),
        (
            "\"buffers\":[{",
            "\"buffers\":[{\"uri\":\"data:;base64,A!\",",
            "a damaged data URI",
        ),
        (
            "\"buffers\":[{",
            "\"buffers\":[{\"uri\":\"data:text/plain,AAAA\",",
            "buffers[0] should have 48 bytes, and has 4",
        ),
        (
            "{\"asset\"",
            "{\"extensionsRequired\":[\"KHR_draco_mesh_compression\"],\"asset\"",
            "requires the extension KHR_draco_mesh_compression, which is not supported: export the model without compression",
        ),
        (
            "{\"asset\"",
            "{\"extensionsRequired\":[\"EXT_bends\"],\"asset\"",
            "requires the extension EXT_bends, which is not supported: export the model without it",
        ),
        (
            "\"type\":\"VEC3\"",
            "\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":1,\"byteOffset\":8,\"componentType\":5125},\"values\":{\"bufferView\":0,\"byteOffset\":28}}",
            "more than bufferViews[0] holds",
        ),
        (
            "\"bufferView\":0,\"componentType\":5126,\"count\":3",
            "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":1,\"componentType\":5125},\"values\":{\"bufferView\":0}},\"componentType\":5126,\"count\":4000000000",
            "claims 4000000000 elements without data",
        ),
        (
            "\"bufferView\":0,\"componentType\":5126,\"count\":3",
            "\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":1,\"byteOffset\":8,\"componentType\":5125},\"values\":{\"bufferView\":0}},\"componentType\":5126,\"count\":2",
            "sparse value for element 2, of 2",
        ),
    ] {
        assert!(json.contains(from), "{from} is not in {json}");
        let problem = problem_of("bad.glb", &suite::glb(&json.replacen(from, to, 1), &binary));
        assert!(
            problem.contains(words),
            "{to}\n  {problem}\n  should have: {words}"
        );
    }
}

#[test]
fn models_name_only_files_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let inside = folder.path().join("models");
    std::fs::create_dir_all(inside.join("data")).unwrap();
    let (json, binary) = suite::glb_parts(&suite::triangle());
    std::fs::write(folder.path().join("secret.bin"), &binary).unwrap();
    std::fs::write(inside.join("data/A..B c.bin"), &binary).unwrap();
    std::fs::write(inside.join("part 10%.bin"), &binary).unwrap();
    std::fs::write(inside.join("a%20b.bin"), &binary).unwrap();
    std::fs::write(inside.join("both%20.bin"), &binary[..20]).unwrap();
    std::fs::write(inside.join("both .bin"), &binary).unwrap();
    std::fs::write(inside.join("short.bin"), &binary[..20]).unwrap();
    std::os::unix::fs::symlink(folder.path().join("secret.bin"), inside.join("link.bin")).unwrap();
    std::os::unix::fs::symlink("/dev/zero", inside.join("zero.bin")).unwrap();

    let pipe = Command::new("mkfifo").arg(inside.join("pipe")).status();
    assert!(pipe.unwrap().success());

    let absolute = folder.path().join("secret.bin");
    let absolute = absolute.to_str().unwrap();
    let outside = "is outside of its folder";
    for (uri, words) in [
        ("data/A..B%20c.bin", ""),
        ("data/../data/./A..B c.bin", ""),
        ("../models/data/A..B c.bin", ""),
        // Names that were not escaped; they are unescaped first.
        ("part 10%.bin", ""),
        ("a%20b.bin", ""),
        ("both%20.bin", ""),
        ("../secret.bin", outside),
        ("..%2fsecret.bin", outside),
        ("data/../../secret.bin", outside),
        ("link.bin", outside),
        ("zero.bin", outside),
        (absolute, outside),
        ("/etc/hostname", outside),
        ("file:///etc/hostname", "which is not the path of a file"),
        (
            "http://localhost/secret.bin",
            "which is not the path of a file",
        ),
        ("data", "no regular file"),
        ("", "no regular file"),
        ("short.bin", "buffers[0] should have 48 bytes, and has 20"),
        ("nothing.bin", "put the file beside the model"),
        ("%ff.bin", "put the file beside the model"),
        ("a%00b", "put the file beside the model"),
        ("pipe", "no regular file"),
    ] {
        let uri = format!("\"buffers\":[{{\"uri\":\"{uri}\",");
        let json = json.replace("\"buffers\":[{", &uri);
        let path = inside.join("model.gltf");
        let result = try_mesh(&path, json.as_bytes(), Extent::Scene);
        match result {
            Ok(_) => assert_eq!(words, "", "{uri}"),
            Err(problem) => {
                let problem = problem.to_string();
                let expected = !words.is_empty() && problem.contains(words);
                assert!(expected, "{uri}\n  {problem}\n  should have: {words}");
            }
        }
    }
}

#[test]
fn what_is_no_model_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (name, words) in [
        (
            "model.step",
            "no OBJ, STL, PLY, glTF or GLB file: its name ends in `.step`",
        ),
        ("model", "its name has no ending"),
        ("cut.glb", "the GLB header is cut off"),
    ] {
        let path = folder.path().join(name);
        std::fs::write(
            &path,
            "glTF".get(..if name == "cut.glb" { 4 } else { 1 }).unwrap(),
        )
        .unwrap();
        let message = Mesh::load(&path).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
        assert!(message.contains(name), "{message}");
    }
    for (path, words) in [
        (folder.path().to_owned(), "this is a folder"),
        ("/dev/zero".into(), "not a regular file"),
        (folder.path().join("absent.obj"), "cannot read"),
    ] {
        let message = Mesh::load(&path).unwrap_err().to_string();
        assert!(message.contains(words), "{message}");
    }
}
