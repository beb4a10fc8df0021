//! Tests with models written by other programs, in `tests/models/`, compared with measurements by other readers.
//!
//! The source of a value, by the word in its line:
//! - `blender`: the surface that Blender 5.0.1 itself shows, before it wrote the file;
//! - `numpy`: the formulas of the glTF specification (nodes, skins, morph targets, instances, quantization, sparse
//!   accessors) in NumPy 1.26.4, written for this table independently of the reader here;
//! - `trimesh`: trimesh 5.2.0, everything in the file as one mesh, without its repairs.
//!
//! Border edges are counted after vertices of equal float32 coordinates have become one (SciPy 1.17.1 for those that only
//! nearly coincide), and triangles without those that have no area.

use glam::Vec3;

use super::bad_files::try_mesh;
use super::load::Extent;

/// A file, and its expected values.
struct Foreign {
    name: &'static str,
    bytes: &'static [u8],
    triangles: usize,
    border_edges: usize,
    area: f64,
    low: [f32; 3],
    high: [f32; 3],
    /// The whole expected report.
    oddities: &'static [&'static str],
}

macro_rules! foreign {
    ($name:literal, $triangles:literal triangles, $border:literal open, area $area:literal, $low:expr, $high:expr, $odd:expr) => {
        Foreign {
            name: $name,
            bytes: include_bytes!(concat!("../../tests/models/", $name)),
            triangles: $triangles,
            border_edges: $border,
            area: $area,
            low: $low,
            high: $high,
            oddities: $odd,
        }
    };
}

/// Each line names the feature that only it tests.
const FILES: &[Foreign] = &[
    // blender: a mirrored node below a stretched one, which together shear; five more nodes with the same mesh.
    foreign!("blender_nodes.glb", 132 triangles, 0 open, area 108.99764,
        [-1.525_197, -1.546_083, -5.604_311], [17.250_7, 5.933_361, 5.118_402], &[]),
    // blender: two scenes, of which the second is the one to show.
    foreign!("blender_scenes.glb", 144 triangles, 0 open, area 14.169335,
        [-1.25, -0.433_012_7, -1.25], [1.25, 0.433_012_7, 1.25], &[]),
    // blender: a morph target at 0.7, then a posed skin whose armature mirrors; it faces outwards by its node alone.
    foreign!("blender_posed.glb", 80 triangles, 0 open, area 27.517546,
        [1.789_854, 2.646_016, -4.675_092], [4.673_692, 7.215_017, -2.058_704],
        &[]),
    // blender: morph targets of weights 1, 0 and 0.5, as sparse accessors without a buffer view beneath.
    foreign!("blender_sparse.glb", 120 triangles, 0 open, area 14.219434,
        [-1.0, -1.0, -1.0], [1.299_038, 2.5, 1.0], &[]),
    // numpy: joints in numbers of 16 bits that scale by a hundred, a skinned node with a transform of its own.
    foreign!("fbx2gltf_posed.glb", 80 triangles, 0 open, area 27.556743,
        [1.789_854, 2.646_018, -4.675_091], [4.673_691, 7.215_017, -2.058_705], &[]),
    // numpy: positions of 16 bits that only the inverse bind matrices bring to size.
    foreign!("gltfpack_posed.glb", 80 triangles, 0 open, area 27.519385,
        [1.79, 2.645_984, -4.675_002], [4.673_734, 7.215_052, -2.058_777],
        &[]),
    // numpy: positions and a morph target as normalized numbers of 16 bits, weights as normalized bytes.
    foreign!("gltf_transform_posed.glb", 80 triangles, 0 open, area 27.520845,
        [1.789_742, 2.645_873, -4.675_061], [4.673_802, 7.215_166, -2.058_65],
        &[]),
    // numpy: instances with scales of their own, one of them mirrored.
    foreign!("gltf_transform_instances.glb", 132 triangles, 0 open, area 123.28862,
        [-3.252_592, -2.512_584, -4.627_43], [17.250_7, 5.933_362, 4.480_143], &[]),
    // numpy: a buffer in the text, matrices, instances below a scaled node, points beside triangles.
    foreign!("three.gltf", 248 triangles, 24 open, area 67.55155,
        [-6.073_848, 0.0, -4.929_725], [10.119_65, 6.531_48, 6.069_689],
        &["4 vertices that no triangle uses, ignored", "12 points, ignored"]),
    // numpy: poles of triangles without area, dropped without holes.
    foreign!("vtk.gltf", 144 triangles, 0 open, area 172.46968,
        [-3.0, -3.0, -3.0], [5.492_404, 3.469_846, 10.0],
        &["16 triangles with a corner twice, dropped"]),
    // numpy: polygons that another program has cut up, so that one triangle has its corners on a line.
    foreign!("obj2gltf_letters.glb", 211 triangles, 3 open, area 3.0778025,
        [0.077, -0.2, -0.682], [1.042, 0.2, 0.009],
        &["1 triangle without area, dropped"]),
    // blender: polygons of up to 29 corners, not convex (fans have an area of 3.7831).
    foreign!("blender_letters.obj", 212 triangles, 0 open, area 3.0778025,
        [0.077, -0.2, -0.682], [1.042, 0.2, 0.009], &[]),
    // blender: these polygons in PLY text.
    foreign!("blender_letters.ply", 212 triangles, 0 open, area 3.0778025,
        [0.077, -0.009, -0.2], [1.042, 0.682, 0.2], &[]),
    // trimesh: positions in double precision, two lists for each face.
    foreign!("meshlab_letters.ply", 212 triangles, 0 open, area 3.0778024,
        [0.077, -0.2, -0.682], [1.042, 0.2, 0.009], &[]),
    // trimesh: a binary header without texture coordinates, a mirrored part.
    foreign!("three.ply", 192 triangles, 24 open, area 51.501562,
        [-6.073_848, 0.0, -1.073_848], [6.217_802, 6.531_48, 6.069_689],
        &["1 closed part that faced inwards, turned"]),
    // blender: seven wedges of a ball, whose 80 borders coincide only within rounding.
    foreign!("blender_wedges.stl", 70 triangles, 0 open, area 18153.274,
        [-29.038_76, -41.997_12, -29.0], [47.0, 35.997_12, 51.0],
        &["32 border vertices that coincide with others within rounding error, made one with these"]),
];

/// Catches misunderstandings of the formats that this reader and its own tests share.
#[test]
fn other_programs_files_are_what_other_readers_measure() {
    for file in FILES {
        let name = file.name;
        let mesh = try_mesh(name, file.bytes, Extent::Scene)
            .unwrap_or_else(|problem| panic!("{name}: {problem}"));
        let report = &mesh.report;
        assert_eq!(report.triangles, file.triangles, "{name}: {report}");
        assert_eq!(report.border_edges, file.border_edges, "{name}: {report}");
        assert_eq!(report.oddities(), file.oddities, "{name}");
        let areas = mesh.corners.iter().map(|corners| {
            let [a, b, c] = corners.map(|vertex| mesh.positions[vertex as usize].as_dvec3());
            (b - a).cross(c - a).length() / 2.0
        });
        let area: f64 = areas.sum();
        assert!((area / file.area - 1.0).abs() < 1e-6, "{name}: {area}");
        let (low, high) = (Vec3::from(file.low), Vec3::from(file.high));
        let (found_low, found_high) = mesh.bounds();
        let most = 1e-6 * low.abs().max(high.abs()).max_element();
        let is_box = found_low.abs_diff_eq(low, most) && found_high.abs_diff_eq(high, most);
        assert!(is_box, "{name}: {found_low} to {found_high}");
    }
}

/// Messages use the names that two programs give to compression, so that users find the option to turn off.
#[test]
fn other_programs_compression_is_named() {
    let files: [(&str, &[u8], &str); 2] = [
        (
            "gltf_transform_draco.glb",
            include_bytes!("../../tests/models/gltf_transform_draco.glb"),
            "KHR_draco_mesh_compression",
        ),
        (
            "gltfpack_meshopt.glb",
            include_bytes!("../../tests/models/gltfpack_meshopt.glb"),
            "EXT_meshopt_compression",
        ),
    ];
    for (name, bytes, extension) in files {
        let problem = try_mesh(name, bytes, Extent::Scene).unwrap_err();
        let expected = format!(
            "the model requires the extension {extension}, which is not supported: export the model without compression"
        );
        assert_eq!(problem.to_string(), expected, "{name}");
    }
}
