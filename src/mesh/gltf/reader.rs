//! The triangles of meshes and their primitives.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use glam::{DMat4, DVec3, Vec2};
use gltf::json::mesh::{
    LINE_LOOP, LINE_STRIP, LINES, POINTS, TRIANGLE_FAN, TRIANGLE_STRIP, TRIANGLES,
};

use super::json::Part;
use super::resource::{Buffers, LOOKUP};
use super::scene::{INSTANCING, Scene, Shown, copies};
use super::skin::Skin;
use super::{accessor, damaged, is_compression, note_unapplied};
use crate::mesh::error::MeshProblem;
use crate::mesh::origin::{bounds, steps_across};
use crate::mesh::soup::{MOST_TRIANGLES, Soup};

/// Collects the triangles of one file.
pub(super) struct Reader<'a> {
    buffers: Buffers<'a>,
    /// The most triangles; more are only counted.
    most: u64,
    triangle_count: usize,
    /// Skins that were needed, by their number.
    skins: BTreeMap<usize, Skin>,
    soup: Soup,
    /// The box round all positions as the file stores them.
    stored: (DVec3, DVec3),
    uvs: Vec<[Vec2; 3]>,
    some_primitive_has_uvs: bool,
    every_corner_has_uv: bool,
}

/// A primitive's triangles in the mesh's own coordinates.
struct Triangles {
    positions: Vec<DVec3>,
    corners: Vec<[u32; 3]>,
    uvs: Option<Vec<[f64; 2]>>,
}

impl Triangles {
    /// Leaves out unused vertices if there are far more vertices than corners use: a small file can show a mesh any number of
    /// times, and each time all its vertices would be kept.
    fn leave_out_unused(&mut self) {
        if self.positions.len() <= 3 * self.corners.len() {
            return;
        }
        let mut used: Vec<u32> = self.corners.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let kept = |vertex: &u32| *vertex as usize;
        if let Some(uvs) = self.uvs.take() {
            // Damaged indices are not changed.
            let is_whole = uvs.len() == self.positions.len();
            self.uvs = is_whole.then(|| used.iter().map(|vertex| uvs[kept(vertex)]).collect());
        }
        self.positions = used
            .iter()
            .map(|vertex| self.positions[kept(vertex)])
            .collect();
        for vertex in self.corners.iter_mut().flatten() {
            *vertex = used.partition_point(|other| other < vertex) as u32;
        }
    }
}

/// The placement of a mesh.
struct Places<'s> {
    /// Weights of its morph targets.
    weights: Vec<f64>,
    /// One for each copy that is shown.
    world_from_mesh: Vec<DMat4>,
    /// Instead of these places, for primitives with joints.
    skin: Option<&'s Skin>,
    /// Does the node mirror? That also flips the winding of a skinned mesh (glTF 2.0, 3.7.2.1): files with mirrored positions and mirroring
    /// joints rely on it.
    is_node_mirrored: bool,
}

impl<'a> Reader<'a> {
    pub(super) fn new(buffers: Buffers<'a>, most: u64) -> Self {
        Self {
            buffers,
            most,
            triangle_count: 0,
            skins: BTreeMap::new(),
            soup: Soup::default(),
            stored: bounds([]),
            uvs: Vec::new(),
            some_primitive_has_uvs: false,
            every_corner_has_uv: true,
        }
    }

    /// Adds the first primitive of the first mesh, as it is.
    pub(super) fn add_first_primitive(&mut self) -> Result<(), MeshProblem> {
        let Some(mesh) = self.buffers.root.item("meshes", 0)? else {
            return Ok(());
        };
        match mesh.item("primitives", 0)? {
            Some(primitive) => self.add_primitive(&primitive, &Places::as_it_is()),
            None => Ok(()),
        }
    }

    /// Adds the meshes of the default scene; without nodes, all meshes.
    pub(super) fn add_scene(&mut self) -> Result<(), MeshProblem> {
        let root = self.buffers.root.clone();
        if root.count("nodes")? == 0 {
            for mesh in root.items("meshes")? {
                let places = Places {
                    weights: mesh.numbers("weights")?,
                    ..Places::as_it_is()
                };
                self.add_mesh(&mesh, &places)?;
            }
            return Ok(());
        }
        let mut scene = Scene::new(&root, &mut self.soup.seen)?;
        for shown in std::mem::take(&mut scene.shown) {
            self.add_node(&shown, &mut scene)?;
        }
        Ok(())
    }

    fn add_node(&mut self, shown: &Shown<'_>, scene: &mut Scene<'_>) -> Result<(), MeshProblem> {
        let Shown { node, mesh, .. } = shown;
        let weights = match node.numbers("weights")? {
            none if none.is_empty() => mesh.numbers("weights")?,
            weights => weights,
        };
        self.buffers.spend(weights.len() as u64)?;
        let world_from_mesh = copies(&mut self.buffers, node)?
            .into_iter()
            .map(|node_from_copy| shown.world_from_node * node_from_copy)
            .collect();
        let mut skins = std::mem::take(&mut self.skins);
        let skin = match node.get("skin") {
            Some(reference) => {
                let (index, skin) = self.buffers.root.named("skins", &reference)?;
                // Copies of a skinned mesh would all be at its joints, so only one is added.
                if node.at(&["extensions", INSTANCING]).is_some() {
                    let seen = &mut self.soup.seen;
                    seen.unapplied_extensions.insert(INSTANCING.to_owned());
                }
                let skin = match skins.entry(index) {
                    Entry::Occupied(entry) => entry.into_mut(),
                    Entry::Vacant(entry) => {
                        entry.insert(Skin::new(&skin, scene, &mut self.buffers)?)
                    }
                };
                Some(&*skin)
            }
            None => None,
        };
        let places = Places {
            weights,
            world_from_mesh,
            skin,
            is_node_mirrored: shown.world_from_node.determinant() < 0.0,
        };
        self.add_mesh(mesh, &places)?;
        self.skins = skins;
        Ok(())
    }

    fn add_mesh(&mut self, mesh: &Part<'_>, places: &Places<'_>) -> Result<(), MeshProblem> {
        self.visit(mesh)?;
        for primitive in mesh.items("primitives")? {
            self.visit(&primitive)?;
            self.add_primitive(&primitive, places)?;
        }
        Ok(())
    }

    /// Notes the extensions of a mesh or primitive, and counts the cost of reading it.
    fn visit(&mut self, part: &Part<'_>) -> Result<(), MeshProblem> {
        let extensions = part.get("extensions");
        let count = extensions.map_or(0, |extensions| extensions.keys().count());
        self.buffers.spend(LOOKUP * (1 + count as u64))?;
        note_unapplied(part, &mut self.soup.seen);
        Ok(())
    }

    fn add_primitive(
        &mut self,
        primitive: &Part<'_>,
        places: &Places<'_>,
    ) -> Result<(), MeshProblem> {
        let Some(reference) = primitive.at(&["attributes", "POSITION"]) else {
            if let Some(name) = compression(primitive) {
                return Err(compressed(primitive, name));
            }
            self.soup.seen.without_positions += 1;
            return Ok(());
        };
        let indices = primitive.get("indices");
        let mode = primitive.get("mode");
        let number = mode.as_ref().map_or(Ok(TRIANGLES.into()), Part::as_whole)?;
        let mode = match u32::try_from(number) {
            Ok(mode @ (POINTS | LINES | LINE_LOOP | LINE_STRIP)) => {
                let drawn = indices.as_ref().unwrap_or(&reference);
                return self.count_points_or_lines(mode, drawn, places.world_from_mesh.len());
            }
            Ok(mode @ (TRIANGLES | TRIANGLE_STRIP | TRIANGLE_FAN)) => mode,
            _ => return Err(mode.as_ref().unwrap_or(primitive).should_be("0 to 6")),
        };
        for data in [Some(&reference), indices.as_ref()].into_iter().flatten() {
            if !accessor::has_data(&self.buffers.root, data)? {
                return Err(match compression(primitive) {
                    Some(name) => compressed(primitive, name),
                    None => damaged(format!("{} names an accessor without data", data.place)),
                });
            }
        }

        let mut shape = self.read_triangles(primitive, &reference, indices.as_ref(), mode)?;
        self.morph(primitive, &places.weights, &mut shape.positions)?;

        let attributes = primitive.needed("attributes")?;
        let posed = match places.skin {
            Some(skin) => skin.pose(&mut self.buffers, &attributes, &shape.positions)?,
            None => None,
        };
        let is_posed = posed.is_some();
        if let Some(posed) = posed {
            shape.positions = posed;
        }
        shape.leave_out_unused();
        if is_posed {
            return self.append(&shape, DMat4::IDENTITY, places.is_node_mirrored);
        }
        for &world_from_mesh in &places.world_from_mesh {
            let is_mirrored = world_from_mesh.determinant() < 0.0;
            self.append(&shape, world_from_mesh, is_mirrored)?;
        }
        Ok(())
    }

    /// Counts what a primitive of points or lines would draw: none of it becomes a part of the surface.
    fn count_points_or_lines(
        &mut self,
        mode: u32,
        drawn: &Part<'_>,
        copies: usize,
    ) -> Result<(), MeshProblem> {
        let corners = accessor::count(&self.buffers.root, drawn)?;
        let corners = usize::try_from(corners).unwrap_or(usize::MAX);
        let seen = &mut self.soup.seen;
        let (sum, count) = match mode {
            POINTS => (&mut seen.points, corners),
            LINES => (&mut seen.lines, corners / 2),
            LINE_LOOP => (&mut seen.lines, corners),
            _ => (&mut seen.lines, corners.saturating_sub(1)),
        };
        *sum = sum.saturating_add(count.saturating_mul(copies));
        Ok(())
    }

    /// Reads a primitive's triangles, before morph targets and skins move them. `positions` and `indices` name accessors.
    fn read_triangles(
        &mut self,
        primitive: &Part<'_>,
        positions: &Part<'_>,
        indices: Option<&Part<'_>>,
        mode: u32,
    ) -> Result<Triangles, MeshProblem> {
        let positions: Vec<DVec3> = accessor::vectors::<3>(&mut self.buffers, positions)?
            .into_iter()
            .map(DVec3::from_array)
            .collect();
        let (low, high) = &mut self.stored;
        let own = bounds(&positions);
        (*low, *high) = (low.min(own.0), high.max(own.1));
        self.soup.seen.stored_steps = steps_across(*low, *high);
        let indices: Vec<u32> = match indices {
            Some(indices) => accessor::whole_numbers::<1>(&mut self.buffers, indices)?
                .into_iter()
                .map(|[index]| index)
                .collect(),
            None => (0..positions.len() as u32).collect(),
        };
        if mode == TRIANGLES && !indices.len().is_multiple_of(3) {
            self.soup.seen.incomplete_triangles += 1;
        }
        let corners = triangles(mode, &indices);
        check_indices(&corners, self.triangle_count, positions.len())?;
        let uvs = match primitive.at(&["attributes", "TEXCOORD_0"]) {
            Some(reference) => {
                self.some_primitive_has_uvs = true;
                // The shape does not need them, so damaged ones are left out.
                accessor::vectors(&mut self.buffers, &reference).ok()
            }
            None => None,
        };
        Ok(Triangles {
            positions,
            corners,
            uvs,
        })
    }

    /// Moves positions by morph targets. Targets without a weight are not read.
    fn morph(
        &mut self,
        primitive: &Part<'_>,
        weights: &[f64],
        positions: &mut [DVec3],
    ) -> Result<(), MeshProblem> {
        for (index, &weight) in weights.iter().enumerate() {
            if weight == 0.0 {
                continue;
            }
            self.buffers.spend(LOOKUP)?;
            let Some(target) = primitive.item("targets", index)? else {
                break;
            };
            let Some(reference) = target.get("POSITION") else {
                continue;
            };
            // Offsets without data are zeros.
            if !accessor::has_data(&self.buffers.root, &reference)? {
                continue;
            }
            let offsets = accessor::vectors::<3>(&mut self.buffers, &reference)?;
            if offsets.len() != positions.len() {
                return Err(damaged(format!(
                    "{} has {} elements for {} vertices",
                    reference.place,
                    offsets.len(),
                    positions.len()
                )));
            }
            for (position, offset) in positions.iter_mut().zip(offsets) {
                *position += weight * DVec3::from_array(offset);
            }
        }
        Ok(())
    }

    fn append(
        &mut self,
        shape: &Triangles,
        world_from_mesh: DMat4,
        is_mirrored: bool,
    ) -> Result<(), MeshProblem> {
        self.buffers.spend(16 + shape.positions.len() as u64)?;
        self.triangle_count += shape.corners.len();
        let count = self.triangle_count;
        let first = self.soup.positions.len();
        for (what, count, most) in [
            ("triangles", count, MOST_TRIANGLES),
            (
                "vertices",
                first + shape.positions.len(),
                3 * MOST_TRIANGLES,
            ),
        ] {
            if count > most {
                return Err(MeshProblem::TooMany {
                    what,
                    count: count as u64,
                    most: most as u64,
                });
            }
        }
        if count as u64 > self.most {
            self.soup.positions = Vec::new();
            self.soup.triangles = Vec::new();
            self.uvs = Vec::new();
            return Ok(());
        }
        // Mirroring flips the winding, so that the outside stays outside.
        let wound = |[a, b, c]: [u32; 3]| if is_mirrored { [a, c, b] } else { [a, b, c] };
        let corners = shape.corners.iter().map(|&corners| wound(corners));
        let uvs = shape.uvs.as_ref().filter(|uvs| {
            uvs.len() == shape.positions.len() && uvs.iter().flatten().all(|c| c.is_finite())
        });
        match uvs {
            Some(uvs) => {
                let uv = |vertex: u32| uvs[vertex as usize].map(|c| c as f32).into();
                let uvs = corners.clone().map(|corners| corners.map(uv));
                self.uvs.extend(uvs);
            }
            None => self.every_corner_has_uv = false,
        }
        let positions = shape.positions.iter();
        let placed = positions.map(|&position| world_from_mesh.transform_point3(position));
        self.soup.positions.extend(placed);
        let moved = corners.map(|corners| corners.map(|vertex| first as u32 + vertex));
        self.soup.triangles.extend(moved);
        Ok(())
    }

    pub(super) fn finish(mut self) -> Result<Soup, MeshProblem> {
        let count = self.triangle_count as u64;
        if count > self.most {
            return Err(MeshProblem::NoRoom {
                count,
                most: self.most,
            });
        }
        if self.soup.triangles.is_empty() {
            return Err(MeshProblem::NoTriangles {
                found: self.what_there_is()?,
            });
        }
        if self.every_corner_has_uv {
            self.soup.uvs = Some(self.uvs);
        } else {
            self.soup.seen.incomplete_uvs = self.some_primitive_has_uvs;
        }
        Ok(self.soup)
    }

    fn what_there_is(&self) -> Result<String, MeshProblem> {
        let seen = &self.soup.seen;
        let meshes = self.buffers.root.count("meshes")?;
        let mut text = match (meshes, seen.lines, seen.points) {
            (0, ..) => "the file holds no meshes".to_owned(),
            (_, 0, 0) => format!("the file's scene shows none, of {meshes} meshes in the file"),
            (_, lines, points) => {
                format!("the file holds only lines and points ({lines} and {points})")
            }
        };
        if seen.hidden_meshes > 0 {
            text += &format!(" ({} of them are hidden)", seen.hidden_meshes);
        }
        let names: Vec<&str> = seen
            .unapplied_extensions
            .iter()
            .take(3)
            .map(String::as_str)
            .collect();
        if !names.is_empty() {
            text += &format!(", and extensions are not applied: {}", names.join(", "));
        }
        Ok(text)
    }
}

impl Places<'_> {
    fn as_it_is() -> Self {
        Self {
            weights: Vec::new(),
            world_from_mesh: vec![DMat4::IDENTITY],
            skin: None,
            is_node_mirrored: false,
        }
    }
}

/// The extension that has a primitive's data in a packed form.
fn compression<'a>(primitive: &Part<'a>) -> Option<&'a str> {
    let mut names = primitive.get("extensions")?.keys();
    names.find(|name| is_compression(name))
}

fn compressed(primitive: &Part<'_>, name: &str) -> MeshProblem {
    MeshProblem::Unsupported(format!(
        "{} is compressed with {}, which is not supported: export the model without compression",
        primitive.place,
        super::shortened(name, 60)
    ))
}

/// The corners of the whole triangles that a primitive of a mode has.
fn triangles(mode: u32, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        TRIANGLE_STRIP => indices
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
        TRIANGLE_FAN => indices
            .windows(2)
            .skip(1)
            .map(|w| [w[0], w[1], indices[0]])
            .collect(),
        _ => indices.as_chunks().0.to_vec(),
    }
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
