//! Meshes for tests: simple ones and known difficult ones. Geometry tests use a suite, not a file.

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::Mesh;
use super::soup::Soup;
use crate::portable::sin_cos;
use crate::rng::{Purpose, random, unit};

/// Closed meshes without an oddity.
#[must_use]
pub fn closed() -> Vec<Mesh> {
    vec![
        builtin("cube"),
        builtin("cube?divisions=4"),
        builtin("torus?major=24&minor=16"),
        builtin("icosphere?subdivisions=2"),
        builtin("capsule?segments=12&rings=4"),
        bipyramid(1000),
        slivers(),
        potato(),
        two_parts(),
    ]
}

/// Open meshes without an oddity.
#[must_use]
pub fn open() -> Vec<Mesh> {
    vec![
        builtin("plane?columns=5&rows=3"),
        triangle(),
        fan(1000),
        tube(12, 5),
    ]
}

/// Meshes that need repair.
#[must_use]
pub fn odd() -> Vec<Mesh> {
    vec![
        moebius(30),
        book(3),
        book(5),
        mixed_cube(),
        inside_out(),
        hollow(),
        bow_tie(),
    ]
}

/// All of them.
#[must_use]
pub fn all() -> Vec<Mesh> {
    [closed(), open(), odd()].into_iter().flatten().collect()
}

/// A mesh from vertices and triangles, as if it had been read from a file.
///
/// # Panics
/// When it is not a mesh to walk on.
#[must_use]
pub fn mesh(name: &str, positions: &[Vec3], triangles: &[[u32; 3]]) -> Mesh {
    let soup = Soup {
        positions: positions
            .iter()
            .map(|position| position.as_dvec3())
            .collect(),
        triangles: triangles.to_vec(),
        ..Soup::default()
    };
    Mesh::from_soup(name, soup).expect("the suite's meshes can be walked on")
}

fn builtin(name: &str) -> Mesh {
    let mut mesh = Mesh::builtin(name).expect("the suite's names are right");
    name.clone_into(&mut mesh.name);
    mesh
}

/// One triangle, scalene and tilted, its shortest edge first.
#[must_use]
pub fn triangle() -> Mesh {
    let corners = [
        Vec3::new(1.4, 0.3, 0.2),
        Vec3::new(0.9, 1.1, 0.7),
        Vec3::new(0.1, 0.2, -0.3),
    ];
    mesh("triangle", &corners, &[[0, 1, 2]])
}

/// A cone without its base: one vertex with very many triangles, inside an open border.
#[must_use]
pub fn fan(spokes: u32) -> Mesh {
    let mut positions = vec![Vec3::new(0.0, 0.5, 0.0)];
    positions.extend((0..spokes).map(|i| circle(i, spokes, 1.0, 0.0)));
    let triangles: Vec<_> = (0..spokes)
        .map(|i| [0, 1 + (i + 1) % spokes, 1 + i])
        .collect();
    mesh(&format!("fan {spokes}"), &positions, &triangles)
}

/// Two cones on one base: closed, with two vertices of very many triangles.
#[must_use]
pub fn bipyramid(spokes: u32) -> Mesh {
    let mut positions = vec![Vec3::new(0.0, 0.5, 0.0), Vec3::new(0.0, -0.7, 0.0)];
    positions.extend((0..spokes).map(|i| circle(i, spokes, 1.0, 0.0)));
    let rim = |i: u32| 2 + i % spokes;
    let triangles: Vec<_> = (0..spokes)
        .flat_map(|i| [[0, rim(i + 1), rim(i)], [1, rim(i), rim(i + 1)]])
        .collect();
    mesh(&format!("bipyramid {spokes}"), &positions, &triangles)
}

/// An open tube about the Y axis: two border loops.
#[must_use]
pub fn tube(segments: u32, rings: u32) -> Mesh {
    let positions: Vec<_> = (0..=rings)
        .flat_map(|j| (0..segments).map(move |i| circle(i, segments, 0.5, 0.3 * j as f32)))
        .collect();
    let at = |i: u32, j: u32| j * segments + i % segments;
    let mut triangles = Vec::new();
    for j in 0..rings {
        for i in 0..segments {
            let quad = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            triangles.extend(halves(quad));
        }
    }
    mesh("tube", &positions, &triangles)
}

/// A torus with a vertex put just beside one edge of each triangle: a third of its triangles are a few ten-thousandths
/// of their length high.
#[must_use]
pub fn slivers() -> Mesh {
    let torus = builtin("torus?major=18&minor=12");
    let mut positions = torus.positions.clone();
    let mut triangles = Vec::new();
    for &[a, b, c] in &torus.corners {
        let [pa, pb, pc] = [a, b, c].map(|vertex| torus.positions[vertex as usize]);
        let beside = (0.5 * (pa + pb)).lerp(pc, 2e-4);
        let d = positions.len() as u32;
        positions.push(beside);
        triangles.extend([[a, b, d], [b, c, d], [c, a, d]]);
    }
    mesh("slivers", &positions, &triangles)
}

/// A sphere with bumps: no two triangles alike.
#[must_use]
pub fn potato() -> Mesh {
    let sphere = builtin("icosphere?subdivisions=3");
    let bump = |(vertex, &position): (usize, &Vec3)| {
        let [word, ..] = random(5, vertex as u32, 0, Purpose::Start);
        position * (0.9 + 0.2 * unit(word)) * Vec3::new(1.3, 0.8, 1.0)
    };
    let positions: Vec<_> = sphere.positions.iter().enumerate().map(bump).collect();
    mesh("potato", &positions, &sphere.corners)
}

/// Two closed parts of different genus.
#[must_use]
pub fn two_parts() -> Mesh {
    let torus = builtin("torus?major=12&minor=8");
    let cube = builtin("cube");
    joined("two parts", &[(&torus, 1.0, 0.0), (&cube, 0.5, 3.0)])
}

/// A Moebius band of `segments` quads: it must be cut, along one line across the band.
#[must_use]
pub fn moebius(segments: u32) -> Mesh {
    let mut positions = Vec::new();
    for i in 0..segments {
        let turn = f64::from(i) / f64::from(segments);
        for across in [-0.3, 0.0, 0.3] {
            let (sin_half, cos_half) = sin_cos(turn * PI);
            let (sin, cos) = sin_cos(turn * TAU);
            let out = 1.0 + across * cos_half;
            positions.push(DVec3::new(out * cos, across * sin_half, out * sin).as_vec3());
        }
    }
    let mut triangles = Vec::new();
    for i in 0..segments {
        for k in 0..2 {
            // The last row meets the first one upside down.
            let at = |k: u32| {
                if i + 1 < segments {
                    3 * (i + 1) + k
                } else {
                    2 - k
                }
            };
            triangles.extend(halves([3 * i + k, 3 * i + k + 1, at(k + 1), at(k)]));
        }
    }
    mesh(&format!("moebius {segments}"), &positions, &triangles)
}

/// Pages that share one edge, wound at random.
#[must_use]
pub fn book(pages: u32) -> Mesh {
    let mut positions = vec![Vec3::ZERO, Vec3::Z];
    let mut triangles = Vec::new();
    for page in 0..pages {
        let outer = positions.len() as u32;
        let corner = circle(page, pages, 1.0, 0.0);
        positions.extend([corner, corner + Vec3::Z]);
        let mut page_triangles = halves([0, 1, outer + 1, outer]);
        if page % 3 == 2 {
            for [_, b, c] in &mut page_triangles {
                std::mem::swap(b, c);
            }
        }
        triangles.extend(page_triangles);
    }
    mesh(&format!("book of {pages}"), &positions, &triangles)
}

/// A cube of which some triangles face inwards.
#[must_use]
pub fn mixed_cube() -> Mesh {
    let cube = builtin("cube?divisions=3");
    let mut triangles = cube.corners.clone();
    for [_, b, c] in triangles.iter_mut().step_by(5) {
        std::mem::swap(b, c);
    }
    mesh("mixed cube", &cube.positions, &triangles)
}

/// A sphere that faces inwards.
#[must_use]
pub fn inside_out() -> Mesh {
    let sphere = builtin("icosphere?subdivisions=2");
    let triangles: Vec<_> = sphere.corners.iter().map(|&[a, b, c]| [a, c, b]).collect();
    mesh("inside out", &sphere.positions, &triangles)
}

/// A sphere with a hollow in it, whose wall rightly faces the hollow.
#[must_use]
pub fn hollow() -> Mesh {
    nested(&[true, false])
}

/// Spheres in each other, each half as large as the one round it, from the largest one on. Each faces outwards or inwards.
#[must_use]
pub fn nested(outwards: &[bool]) -> Mesh {
    let sphere = builtin("icosphere?subdivisions=2");
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut size = 1.0;
    for &outwards in outwards {
        let first = positions.len() as u32;
        positions.extend(sphere.positions.iter().map(|&position| size * position));
        triangles.extend(sphere.corners.iter().map(|corners| {
            let [a, b, c] = corners.map(|vertex| first + vertex);
            if outwards { [a, b, c] } else { [a, c, b] }
        }));
        size *= 0.5;
    }
    mesh("hollow", &positions, &triangles)
}

/// Two tetrahedra that touch in one vertex.
#[must_use]
pub fn bow_tie() -> Mesh {
    let mut positions = vec![Vec3::ZERO];
    let mut triangles = Vec::new();
    for side in [1.0, -1.0] {
        let first = positions.len() as u32;
        positions.extend((0..3).map(|i| side * circle(i, 3, 1.0, 1.0)));
        let [a, b, c] = [first, first + 1, first + 2];
        triangles.extend([[0, a, b], [0, b, c], [0, c, a], [a, c, b]]);
    }
    mesh("bow tie", &positions, &triangles)
}

fn joined(name: &str, parts: &[(&Mesh, f32, f32)]) -> Mesh {
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for &(part, scale, x) in parts {
        let first = positions.len() as u32;
        let moved = |&position: &Vec3| scale * position + Vec3::new(x, 0.0, 0.0);
        positions.extend(part.positions.iter().map(moved));
        triangles.extend(
            part.corners
                .iter()
                .map(|corners| corners.map(|v| first + v)),
        );
    }
    mesh(name, &positions, &triangles)
}

fn circle(i: u32, n: u32, radius: f32, height: f32) -> Vec3 {
    let (sin, cos) = sin_cos(TAU * f64::from(i) / f64::from(n));
    Vec3::new(radius * cos as f32, height, radius * sin as f32)
}

fn halves([a, b, c, d]: [u32; 4]) -> [[u32; 3]; 2] {
    [[a, b, c], [a, c, d]]
}

/// The text of an OBJ file with a mesh's triangles; each triangle has its own three vertices if `unwelded`.
#[must_use]
pub fn obj_text(mesh: &Mesh, unwelded: bool) -> String {
    let vertex = |position: Vec3| format!("v {} {} {}\n", position.x, position.y, position.z);
    let mut text = String::new();
    if unwelded {
        for (triangle, corners) in mesh.corners.iter().enumerate() {
            for &corner in corners {
                text += &vertex(mesh.positions[corner as usize]);
            }
            let first = 3 * triangle + 1;
            text += &format!("f {} {} {}\n", first, first + 1, first + 2);
        }
    } else {
        text.extend(mesh.positions.iter().map(|&position| vertex(position)));
        for corners in &mesh.corners {
            let [a, b, c] = corners.map(|corner| corner + 1);
            text += &format!("f {a} {b} {c}\n");
        }
    }
    text
}

/// A GLB file from its JSON and the binary chunk.
#[must_use]
pub fn glb(json: &str, binary: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with: u8| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, binary) = (padded(json.as_bytes(), b' '), padded(binary, 0));
    let length = 12 + 8 + json.len() + 8 + binary.len();
    let mut file = b"glTF".to_vec();
    for (words, chunk) in [
        (vec![2, length as u32, json.len() as u32, 0x4e4f_534a], json),
        (vec![binary.len() as u32, 0x004e_4942], binary),
    ] {
        file.extend(words.iter().flat_map(|word: &u32| word.to_le_bytes()));
        file.extend(chunk);
    }
    file
}

/// A GLB file with one indexed primitive: the JSON, and the binary chunk that it describes.
#[must_use]
pub fn glb_parts(mesh: &Mesh) -> (String, Vec<u8>) {
    let mut binary: Vec<u8> = bytemuck::cast_slice(&mesh.positions).to_vec();
    let split = binary.len();
    binary.extend_from_slice(bytemuck::cast_slice(&mesh.corners));
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
"accessors":[{{"bufferView":0,"componentType":5126,"count":{vertices},"type":"VEC3"}},
{{"bufferView":1,"componentType":5125,"count":{corners},"type":"SCALAR"}}],
"bufferViews":[{{"buffer":0,"byteLength":{split}}},{{"buffer":0,"byteOffset":{split},"byteLength":{rest}}}],
"buffers":[{{"byteLength":{all}}}]}}"#,
        vertices = mesh.positions.len(),
        corners = 3 * mesh.corners.len(),
        rest = binary.len() - split,
        all = binary.len(),
    );
    (json, binary)
}
