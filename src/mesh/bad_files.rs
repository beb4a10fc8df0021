//! Tests with broken models: each is refused with words that help, and none makes a reader panic.
//!
//! They call the readers without the second wall of [`super::load`], which would hide a panic.

use std::path::Path;
use std::process::Command;

use super::error::MeshProblem;
use super::load::{Extent, parse};
use super::{Mesh, suite};

pub(super) fn try_mesh(
    path: impl AsRef<Path>,
    bytes: &[u8],
    extent: Extent,
) -> Result<Mesh, MeshProblem> {
    Mesh::from_soup("test", parse(path.as_ref(), bytes, extent)?)
}

/// What is wrong with a model, in words.
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
            with("vt a b\nf 1 2 3\n"),
            "line 4 cannot be read, texture coordinates",
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
        (edited(4, 1), "this is GLB version 1, and version 2 is read"),
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
        ("\"2.0\"", "\"1.0\"", "this is glTF 1.0, and glTF 2 is read"),
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
            "has 2 corners, not a multiple of 3",
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
    let outside = "lies outside of its folder";
    for (uri, words) in [
        ("data/A..B%20c.bin", ""),
        ("data/../data/./A..B c.bin", ""),
        ("../models/data/A..B c.bin", ""),
        // Names that were not escaped; the escaped reading comes first.
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
        ("file:///etc/hostname", "which is no file beside it"),
        ("http://localhost/secret.bin", "which is no file beside it"),
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
            "model.stl",
            "no OBJ, glTF or GLB file: its name ends in `.stl`",
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
