//! Tests with random damage: no reader panics, and every accepted mesh can be walked on. Seeds are fixed, so failures are reproducible.

use glam::Vec3;

use super::bad_files::try_mesh;
use super::load::Extent;
use super::soup::Soup;
use super::surface::Surface;
use super::text_files::{self, Encoding};
use super::{Mesh, suite};
use crate::rng::{Purpose, random};

/// Faces before vertices, a strip, and texture coordinates of corners.
const LISTS: &str = "ply\nformat ascii 1.0\nelement face 2\nproperty list uchar int vertex_index\n\
    property list uchar float texcoord\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
    property float s\nproperty float t\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n\
    4 0 1 2 3 8 0 0 1 0 1 1 0 1\n3 0 1 4 6 0 0 1 0 1 1\n0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n0 0 1 1 1\n\
    7 1 2 4 3 -1 0 4\n";

/// Bytes changed, cut, repeated and replaced.
#[test]
fn no_mutation_makes_a_reader_panic() {
    let mesh = Mesh::builtin("cube").unwrap();
    let (json, binary) = suite::glb_parts(&mesh);
    let triangle = suite::glb_parts(&suite::triangle());
    let strip = triangle
        .0
        .replace("\"indices\":1", "\"indices\":1,\"mode\":5");
    let obj = suite::obj_text(&mesh, false).replace("f 1 ", "vt 0 1\nf 1/1 ");
    let originals: [(&str, Vec<u8>); 11] = [
        ("cube.glb", suite::glb(&json, &binary)),
        ("strip.glb", suite::glb(&strip, &triangle.1)),
        ("cube.obj", obj.clone().into_bytes()),
        ("soup.obj", suite::obj_text(&mesh, true).into_bytes()),
        ("u.obj", text_files::U_BLOCK.into()),
        ("lists.ply", LISTS.into()),
        ("cube.stl", text_files::stl(&mesh, "solid")),
        ("text.stl", text_files::stl_text(&mesh).into_bytes()),
        ("text.ply", text_files::cube_ply(Encoding::Ascii)),
        ("little.ply", text_files::cube_ply(Encoding::Little)),
        ("big.ply", text_files::cube_ply(Encoding::Big)),
    ];
    let mut refused = 0;
    for round in 0..11_000_u32 {
        let (name, original) = &originals[round as usize % originals.len()];
        let mut bytes = original.clone();
        let changes = 1 + random(1, round, 0, Purpose::Start)[0] % 3;
        for change in 0..changes {
            mutate(&mut bytes, random(11, round, 1 + change, Purpose::Start));
        }
        // Text formats are read as a whole in either case.
        let extents = match name.ends_with(".glb") {
            true => &[Extent::Scene, Extent::FirstPrimitive][..],
            false => &[Extent::Scene],
        };
        for &extent in extents {
            match try_mesh(name, &bytes, extent) {
                Ok(mesh) => assert_walkable(&mesh, &format!("{name}, round {round}")),
                Err(_) => refused += 1,
            }
        }
    }
    // Neither must all mutations be harmless, nor all be caught by the first check.
    assert!(
        (2000..11_000).contains(&refused),
        "{refused} of 13000 refused"
    );
}

/// Every accepted mesh can be walked on, at any scale that a scene may have.
fn assert_walkable(mesh: &Mesh, what: &str) {
    for scale in [1.0, 1.1, 1e-3, 1e3] {
        let valid = Surface::build(&[(mesh, scale)]).validate();
        assert_eq!(valid, Ok(()), "{what}, scale {scale}");
    }
}

/// Triangles between few vertices at random: every edge has many, and no two agree.
#[test]
fn tangles_become_surfaces() {
    for round in 0..2000_u32 {
        let word = |index: u32| random(3, index, round, Purpose::Start);
        let [vertices, triangles, grid, _] = word(0);
        let (vertices, triangles) = (3 + vertices % 9, 1 + triangles % 40);
        // On a coarse grid many triangles have no area, and many vertices are one.
        let grid = [2, 5, 1 << 20][grid as usize % 3];
        let positions: Vec<Vec3> = (1..=vertices)
            .map(|index| {
                let [x, y, z, _] = word(index).map(|word| (word % grid) as f32 / grid as f32);
                Vec3::new(x, y, z)
            })
            .collect();
        let soup = Soup {
            triangles: (100..100 + triangles)
                .map(|index| {
                    let [a, b, c, _] = word(index).map(|word| word % vertices);
                    [a, b, c]
                })
                .collect(),
            positions: positions
                .iter()
                .map(|position| position.as_dvec3())
                .collect(),
            ..Soup::default()
        };
        let given = soup.triangles.clone();
        let Ok(mesh) = Mesh::from_soup("tangle", soup) else {
            continue;
        };
        assert_walkable(&mesh, &format!("tangle {round}"));
        let report = &mesh.report;
        let dropped = report.repeated_corners + report.without_area + report.duplicates;
        assert_eq!(report.triangles + dropped, triangles as usize);
        assert_eq!(3 * report.triangles, 2 * report.edges - report.border_edges);
        // Each triangle is still the one of the file, its corners in the order that it says.
        for (triangle, &corners) in mesh.corners.iter().enumerate() {
            let file = given[mesh.file_triangle[triangle] as usize];
            let expected =
                mesh.file_corners[triangle].map(|corner| positions[file[corner as usize] as usize]);
            let ours = corners.map(|vertex| mesh.positions[vertex as usize]);
            assert_eq!(ours, expected, "tangle {round}");
        }
    }
}

/// Changes a byte or a few, in one of several ways.
pub(super) fn mutate(bytes: &mut Vec<u8>, [kind, place, length, value]: [u32; 4]) {
    const DIGITS: &[u8] = b"0123456789-.e,:[]{}\" /nv";
    if bytes.is_empty() {
        return;
    }
    let at = place as usize % bytes.len();
    let end = (at + length as usize % 12).min(bytes.len());
    match kind % 8 {
        0 => bytes[at] = value as u8,
        1 => bytes[at] ^= 1 << (value % 8),
        2..=4 => bytes[at] = DIGITS[value as usize % DIGITS.len()],
        5 => drop(bytes.drain(at..end)),
        6 => {
            let copy = bytes[at..end].to_vec();
            let to = value as usize % bytes.len();
            bytes.splice(to..to, copy);
        }
        _ => {
            let digits = DIGITS.iter().cycle().skip(value as usize % DIGITS.len());
            bytes.splice(at..at, digits.take(length as usize % 20).copied());
        }
    }
}
