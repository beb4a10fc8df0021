//! glTF and GLB files: which triangles there are, and where the scene puts them.
//!
//! Models come from strangers, so of the `gltf` crate only the JSON types are used: its own import panics on damaged
//! files and reads any path that a model names. Every index is looked up with a check here, every size is computed with
//! checked arithmetic in [`accessor`], and only files beside the model are opened in [`resource`].

mod accessor;
mod animation;
mod glb;
mod resource;

use glam::{DMat4, DQuat, DVec3, Vec2, Vec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Node, Root};
use std::path::Path;

use super::error::MeshProblem;
use super::load::Extent;
use super::soup::{MOST_TRIANGLES, Soup};
pub use animation::RigidTrack;
pub(crate) use glb::is_glb;
use resource::Buffers;

/// Extensions that a file may require, because they do not change where its triangles are.
const HARMLESS: &[&str] = &[
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_mesh_quantization",
    "KHR_animation_pointer",
    "KHR_xmp",
    "EXT_texture_",
    "EXT_lights_",
    "MSFT_texture_",
];

/// Reads a `.glb`, or a `.gltf` whose buffers are data URIs or files in the given folder.
pub(crate) fn read(bytes: &[u8], folder: &Path, extent: Extent) -> Result<Soup, MeshProblem> {
    let (json, blob) = glb::split(bytes)?;
    let root: Root = serde_json::from_slice(json)
        .map_err(|error| damaged(format!("the glTF description cannot be read: {error}")))?;
    check_version(&root)?;
    let mut reader = Reader {
        buffers: Buffers::new(&root, blob, folder),
        root: &root,
        soup: Soup::default(),
        every_corner_has_uv: true,
        some_corner_has_uv: false,
        uvs: Vec::new(),
    };
    match extent {
        Extent::Scene => reader.add_scene()?,
        Extent::FirstPrimitive => reader.add_first_primitive()?,
    }
    reader.finish()
}

/// Reads the first animation of a file, as [`read`] reads its triangles.
pub(crate) fn read_track(bytes: &[u8], folder: &Path) -> Result<RigidTrack, MeshProblem> {
    let (json, blob) = glb::split(bytes)?;
    let root: Root = serde_json::from_slice(json)
        .map_err(|error| damaged(format!("the glTF description cannot be read: {error}")))?;
    check_version(&root)?;
    animation::track(&root, &mut Buffers::new(&root, blob, folder))
}

fn damaged(problem: String) -> MeshProblem {
    MeshProblem::Damaged(problem)
}

/// Looks up one of a file's numbered things.
fn get<'a, T>(list: &'a [T], index: usize, what: &str) -> Result<&'a T, MeshProblem> {
    list.get(index).ok_or_else(|| {
        let count = list.len();
        damaged(format!("{what} {index} is named, and the file has {count}"))
    })
}

fn check_version(root: &Root) -> Result<(), MeshProblem> {
    let version = &root.asset.version;
    if !version.starts_with("2.") {
        let version: String = version.chars().take(20).collect();
        return Err(MeshProblem::Unsupported(format!(
            "this is glTF {version}, and glTF 2 is read: export the model anew"
        )));
    }
    let foreign = |name: &&String| !HARMLESS.iter().any(|harmless| name.starts_with(harmless));
    if let Some(name) = root.extensions_required.iter().find(foreign) {
        let name: String = name.chars().take(60).collect();
        let hint = if name.contains("draco") || name.contains("meshopt") {
            "export the model without compression"
        } else {
            "export the model without it"
        };
        return Err(MeshProblem::Unsupported(format!(
            "the model requires the extension {name}, which is not supported: {hint}"
        )));
    }
    Ok(())
}

struct Reader<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    soup: Soup,
    uvs: Vec<[Vec2; 3]>,
    some_corner_has_uv: bool,
    every_corner_has_uv: bool,
}

impl Reader<'_> {
    fn add_first_primitive(&mut self) -> Result<(), MeshProblem> {
        let primitive = self
            .root
            .meshes
            .first()
            .and_then(|mesh| mesh.primitives.first());
        match primitive {
            Some(primitive) => self.add_primitive(0, 0, primitive, DMat4::IDENTITY),
            None => Ok(()),
        }
    }

    fn add_scene(&mut self) -> Result<(), MeshProblem> {
        for (mesh_index, world_from_mesh) in self.instances()? {
            let mesh = get(&self.root.meshes, mesh_index, "mesh")?;
            for (index, primitive) in mesh.primitives.iter().enumerate() {
                self.add_primitive(mesh_index, index, primitive, world_from_mesh)?;
            }
        }
        Ok(())
    }

    /// The meshes that the default scene shows, with their transforms, each node once.
    fn instances(&mut self) -> Result<Vec<(usize, DMat4)>, MeshProblem> {
        let root = self.root;
        if root.nodes.is_empty() {
            return Ok((0..root.meshes.len())
                .map(|mesh| (mesh, DMat4::IDENTITY))
                .collect());
        }
        let mut stack: Vec<(usize, DMat4)> = top_nodes(root)?
            .into_iter()
            .rev()
            .map(|node| (node, DMat4::IDENTITY))
            .collect();
        // A list and not a recursion: models may be nested as deep as they like, or in circles.
        let mut visited = vec![false; root.nodes.len()];
        let mut instances = Vec::new();
        while let Some((index, world_from_parent)) = stack.pop() {
            let node = get(&root.nodes, index, "node")?;
            if std::mem::replace(&mut visited[index], true) {
                self.soup.seen.repeated_nodes += 1;
                continue;
            }
            let world_from_node = world_from_parent * parent_from_node(node);
            if !world_from_node.is_finite() {
                return Err(damaged(format!(
                    "the transform of node {index} is not finite"
                )));
            }
            if let Some(mesh) = node.mesh {
                // A skinned mesh is placed by its joints: its own node's transform does not count.
                let placed = match node.skin {
                    Some(_) => DMat4::IDENTITY,
                    None => world_from_node,
                };
                instances.push((mesh.value(), placed));
            }
            let children = node.children.iter().flatten().rev();
            stack.extend(children.map(|child| (child.value(), world_from_node)));
        }
        Ok(instances)
    }

    fn add_primitive(
        &mut self,
        mesh: usize,
        index: usize,
        primitive: &Primitive,
        world_from_mesh: DMat4,
    ) -> Result<(), MeshProblem> {
        let place = format!("primitive {index} of mesh {mesh}");
        let Checked::Valid(mode) = primitive.mode else {
            return Err(damaged(format!("{place} has an unknown mode")));
        };
        let accessor_of = |semantic| {
            let accessor = primitive.attributes.get(&Checked::Valid(semantic))?;
            Some(accessor.value())
        };
        let Some(positions) = accessor_of(Semantic::Positions) else {
            // Nothing is drawn where positions are left to an extension.
            return Ok(());
        };
        let positions: Vec<[f32; 3]> = accessor::vectors(&mut self.buffers, positions)?;
        let indices = match primitive.indices {
            Some(indices) => accessor::indices(&mut self.buffers, indices.value())?,
            None => (0..positions.len() as u32).collect(),
        };
        match mode {
            Mode::Points => self.soup.seen.points += indices.len(),
            Mode::Lines => self.soup.seen.lines += indices.len() / 2,
            Mode::LineLoop => self.soup.seen.lines += indices.len(),
            Mode::LineStrip => self.soup.seen.lines += indices.len().saturating_sub(1),
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => {
                let mut triangles = triangles(mode, &indices, &place)?;
                check_indices(&triangles, self.soup.triangles.len(), positions.len())?;
                if world_from_mesh.determinant() < 0.0 {
                    // A mirror turns the winding, so that the outside stays outside.
                    for [_, b, c] in &mut triangles {
                        std::mem::swap(b, c);
                    }
                }
                let uvs = match accessor_of(Semantic::TexCoords(0)) {
                    Some(accessor) => Some(accessor::vectors(&mut self.buffers, accessor)?),
                    None => None,
                };
                self.append(&positions, &triangles, uvs, world_from_mesh)?;
            }
        }
        Ok(())
    }

    fn append(
        &mut self,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        uvs: Option<Vec<[f32; 2]>>,
        world_from_mesh: DMat4,
    ) -> Result<(), MeshProblem> {
        let count = self.soup.triangles.len() + triangles.len();
        let vertices = self.soup.positions.len() + positions.len();
        for (what, count, most) in [
            ("triangles", count, MOST_TRIANGLES),
            ("vertices", vertices, 3 * MOST_TRIANGLES),
        ] {
            if count > most {
                return Err(MeshProblem::TooMany {
                    what,
                    count: count as u64,
                    most: most as u64,
                });
            }
        }
        let uvs = uvs.filter(|uvs| {
            uvs.len() == positions.len() && uvs.iter().flatten().all(|c| c.is_finite())
        });
        match uvs {
            Some(uvs) => {
                self.some_corner_has_uv = true;
                let uv = |vertex: u32| Vec2::from_array(uvs[vertex as usize]);
                self.uvs
                    .extend(triangles.iter().map(|corners| corners.map(uv)));
            }
            None => self.every_corner_has_uv = false,
        }
        let first = self.soup.positions.len() as u32;
        self.soup
            .positions
            .extend(positions.iter().map(|&position| {
                let position = Vec3::from_array(position).as_dvec3();
                world_from_mesh.transform_point3(position)
            }));
        let moved = |corners: &[u32; 3]| corners.map(|vertex| first + vertex);
        self.soup.triangles.extend(triangles.iter().map(moved));
        Ok(())
    }

    fn finish(mut self) -> Result<Soup, MeshProblem> {
        if self.soup.triangles.is_empty() {
            return Err(MeshProblem::NoTriangles {
                found: self.what_there_is(),
            });
        }
        if self.every_corner_has_uv {
            self.soup.uvs = Some(self.uvs);
        } else {
            self.soup.seen.incomplete_uvs = self.some_corner_has_uv;
        }
        Ok(self.soup)
    }

    fn what_there_is(&self) -> String {
        let seen = &self.soup.seen;
        let meshes = self.root.meshes.len();
        match (meshes, seen.lines, seen.points) {
            (0, ..) => "the file holds no meshes".to_owned(),
            (_, 0, 0) => format!("the file's scene shows none, of {meshes} meshes in the file"),
            (_, lines, points) => {
                format!("the file holds only lines and points ({lines} and {points})")
            }
        }
    }
}

/// The nodes that the default scene begins with; without scenes, those that are nobody's child.
fn top_nodes(root: &Root) -> Result<Vec<usize>, MeshProblem> {
    if !root.scenes.is_empty() {
        let index = root.scene.map_or(0, |scene| scene.value());
        let scene = get(&root.scenes, index, "scene")?;
        return Ok(scene.nodes.iter().map(|node| node.value()).collect());
    }
    let mut is_child = vec![false; root.nodes.len()];
    for child in root
        .nodes
        .iter()
        .flat_map(|node| node.children.iter().flatten())
    {
        if let Some(is_child) = is_child.get_mut(child.value()) {
            *is_child = true;
        }
    }
    Ok((0..root.nodes.len())
        .filter(|&node| !is_child[node])
        .collect())
}

/// A node's transform. Rotations are made unit, and one that is zero is none.
fn parent_from_node(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let scale = DVec3::from_array(node.scale.unwrap_or([1.0; 3]).map(f64::from));
    let translation = DVec3::from_array(node.translation.unwrap_or([0.0; 3]).map(f64::from));
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |rotation| {
        let rotation = DQuat::from_array(rotation.0.map(f64::from));
        if rotation.length_squared() > 0.0 && rotation.is_finite() {
            rotation.normalize()
        } else {
            DQuat::IDENTITY
        }
    });
    DMat4::from_scale_rotation_translation(scale, rotation, translation)
}

fn triangles(mode: Mode, indices: &[u32], place: &str) -> Result<Vec<[u32; 3]>, MeshProblem> {
    Ok(match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| {
                if i % 2 == 0 {
                    [w[0], w[1], w[2]]
                } else {
                    [w[0], w[2], w[1]]
                }
            })
            .collect(),
        Mode::TriangleFan => indices
            .windows(2)
            .skip(1)
            .map(|w| [w[0], w[1], indices[0]])
            .collect(),
        _ => {
            let (triangles, rest) = indices.as_chunks();
            if !rest.is_empty() {
                let count = indices.len();
                return Err(damaged(format!(
                    "{place} has {count} corners, not a multiple of 3"
                )));
            }
            triangles.to_vec()
        }
    })
}

fn check_indices(
    triangles: &[[u32; 3]],
    first_triangle: usize,
    vertices: usize,
) -> Result<(), MeshProblem> {
    for (triangle, corners) in triangles.iter().enumerate() {
        if let Some(&index) = corners.iter().find(|&&index| index as usize >= vertices) {
            return Err(MeshProblem::IndexOutOfRange {
                face: (first_triangle + triangle) as u64,
                line: None,
                what: "vertex",
                index: i64::from(index),
                first: 0,
                count: vertices as u64,
            });
        }
    }
    Ok(())
}
