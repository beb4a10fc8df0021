//! The meshes of the default scene, and their transforms by nodes.

use glam::{DMat4, DQuat, DVec3};

use super::json::Part;
use super::resource::Buffers;
use super::{accessor, damaged, note_unapplied};
use crate::mesh::MeshReport;
use crate::mesh::error::MeshProblem;

/// The extension with which a node shows copies of its mesh.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// The default scene, each of its nodes once.
pub(super) struct Scene<'a> {
    root: Part<'a>,
    /// The nodes that show a mesh, in the order of the scene.
    pub(super) shown: Vec<Shown<'a>>,
    /// The node above each node.
    parents: Vec<Option<usize>>,
    /// World transforms of the nodes reached so far.
    worlds: Vec<Option<DMat4>>,
}

/// A node that shows a mesh.
pub(super) struct Shown<'a> {
    pub(super) index: usize,
    pub(super) node: Part<'a>,
    pub(super) mesh: Part<'a>,
    pub(super) world_from_node: DMat4,
}

/// A node still to be visited.
struct Step {
    index: usize,
    parent: Option<usize>,
    is_hidden: bool,
}

impl<'a> Scene<'a> {
    /// Walks the default scene, and reports oddities.
    pub(super) fn new(root: &Part<'a>, seen: &mut MeshReport) -> Result<Self, MeshProblem> {
        let mut scene = Self {
            root: root.clone(),
            shown: Vec::new(),
            parents: parents(root)?,
            worlds: vec![None; root.count("nodes")?],
        };
        // A list and not a recursion: models may be nested arbitrarily deep, or in circles.
        let mut stack: Vec<Step> = Vec::new();
        for index in scene.top_nodes()?.into_iter().rev() {
            stack.push(Step {
                index,
                parent: None,
                is_hidden: false,
            });
        }
        while let Some(step) = stack.pop() {
            let index = step.index;
            if scene.worlds[index].is_some() {
                seen.repeated_nodes += 1;
                continue;
            }
            scene.parents[index] = step.parent;
            let world_from_node = scene.put(index)?;
            let Some(node) = root.item("nodes", index)? else {
                continue;
            };
            let is_hidden = step.is_hidden || is_hidden(&node);
            if !is_hidden {
                note_unapplied(&node, seen);
            }
            for child in node.items("children")?.rev() {
                stack.push(Step {
                    index: root.named("nodes", &child)?.0,
                    parent: Some(index),
                    is_hidden,
                });
            }
            match node.get("mesh") {
                Some(_) if is_hidden => seen.hidden_meshes += 1,
                Some(mesh) => scene.shown.push(Shown {
                    index,
                    mesh: root.named("meshes", &mesh)?.1,
                    node,
                    world_from_node,
                }),
                None => {}
            }
        }
        Ok(scene)
    }

    /// The nodes that the default scene begins with; without scenes, those that are no node's child.
    fn top_nodes(&self) -> Result<Vec<usize>, MeshProblem> {
        let scene = match self.root.get("scene") {
            Some(reference) => Some(self.root.named("scenes", &reference)?.1),
            None => self.root.item("scenes", 0)?,
        };
        match scene {
            Some(scene) => scene
                .items("nodes")?
                .map(|node| Ok(self.root.named("nodes", &node)?.0))
                .collect(),
            None => {
                let is_top = |&index: &usize| self.parents[index].is_none();
                Ok((0..self.parents.len()).filter(is_top).collect())
            }
        }
    }

    /// Computes where a node is; its parent is done.
    fn put(&mut self, index: usize) -> Result<DMat4, MeshProblem> {
        let above = self.parents[index].and_then(|parent| self.worlds[parent]);
        let mut world_from_node = above.unwrap_or(DMat4::IDENTITY);
        if let Some(node) = self.root.item("nodes", index)? {
            world_from_node *= parent_from_node(&node)?;
            check_finite(world_from_node, &node)?;
        }
        self.worlds[index] = Some(world_from_node);
        Ok(world_from_node)
    }

    /// World transform of a node that need not be in the default scene, such as a joint.
    pub(super) fn world_from(&mut self, reference: &Part<'_>) -> Result<DMat4, MeshProblem> {
        let (index, node) = self.root.named("nodes", reference)?;
        let mut chain = Vec::new();
        let mut above = Some(index);
        while let Some(index) = above.filter(|&index| self.worlds[index].is_none()) {
            if chain.len() == self.worlds.len() {
                return Err(damaged(format!("{} is its own ancestor", node.place)));
            }
            chain.push(index);
            above = self.parents[index];
        }
        for index in chain.into_iter().rev() {
            self.put(index)?;
        }
        Ok(self.world(index))
    }

    /// The node above a node.
    pub(super) fn parent(&self, index: usize) -> Option<usize> {
        self.parents[index]
    }

    /// The world transform of a node of the scene.
    pub(super) fn world(&self, index: usize) -> DMat4 {
        self.worlds[index].unwrap_or(DMat4::IDENTITY)
    }
}

/// The node above each node: the first that names it as a child.
fn parents(root: &Part<'_>) -> Result<Vec<Option<usize>>, MeshProblem> {
    let mut parents = vec![None; root.count("nodes")?];
    for (index, node) in root.items("nodes")?.enumerate() {
        // Unreadable lists matter only if the scene reaches them.
        for child in node.items("children").into_iter().flatten() {
            let Ok(child) = child.as_whole() else {
                continue;
            };
            let child = usize::try_from(child).unwrap_or(usize::MAX);
            if let Some(parent @ None) = parents.get_mut(child) {
                *parent = Some(index);
            }
        }
    }
    Ok(parents)
}

/// Whether a node hides itself and what is below it (`KHR_node_visibility`).
fn is_hidden(node: &Part<'_>) -> bool {
    let visible = node.at(&["extensions", "KHR_node_visibility", "visible"]);
    visible.is_some_and(|visible| visible.is_false())
}

fn check_finite(transform: DMat4, part: &Part<'_>) -> Result<(), MeshProblem> {
    if transform.is_finite() {
        return Ok(());
    }
    Err(damaged(format!(
        "the transform of {} is not finite",
        part.place
    )))
}

/// A node's transform.
pub(super) fn parent_from_node(node: &Part<'_>) -> Result<DMat4, MeshProblem> {
    if let Some(matrix) = node.array("matrix")? {
        return Ok(DMat4::from_cols_array(&matrix));
    }
    let Placement {
        scale,
        rotation,
        translation,
    } = Placement::of(node)?;
    Ok(DMat4::from_scale_rotation_translation(
        scale,
        rotation,
        translation,
    ))
}

/// The three steps of a node's transform.
pub(super) struct Placement {
    pub(super) scale: DVec3,
    pub(super) rotation: DQuat,
    pub(super) translation: DVec3,
}

impl Placement {
    pub(super) fn of(node: &Part<'_>) -> Result<Self, MeshProblem> {
        Ok(Self {
            scale: node.array("scale")?.map_or(DVec3::ONE, DVec3::from_array),
            rotation: node.array("rotation")?.map_or(DQuat::IDENTITY, unit),
            translation: node
                .array("translation")?
                .map_or(DVec3::ZERO, DVec3::from_array),
        })
    }
}

/// A rotation made unit; one that is zero is none.
pub(super) fn unit(rotation: [f64; 4]) -> DQuat {
    let rotation = DQuat::from_array(rotation);
    if rotation.length_squared() > 0.0 && rotation.is_finite() {
        rotation.normalize()
    } else {
        DQuat::IDENTITY
    }
}

/// The transforms of copies of a node's mesh, relative to the node.
pub(super) fn copies(
    buffers: &mut Buffers<'_>,
    node: &Part<'_>,
) -> Result<Vec<DMat4>, MeshProblem> {
    let Some(attributes) = node.at(&["extensions", INSTANCING, "attributes"]) else {
        return Ok(vec![DMat4::IDENTITY]);
    };
    let mut counts = Vec::new();
    let translations = match attributes.get("TRANSLATION") {
        Some(reference) => accessor::vectors::<3>(buffers, &reference)?,
        None => Vec::new(),
    };
    let rotations = match attributes.get("ROTATION") {
        Some(reference) => accessor::vectors::<4>(buffers, &reference)?,
        None => Vec::new(),
    };
    let scales = match attributes.get("SCALE") {
        Some(reference) => accessor::vectors::<3>(buffers, &reference)?,
        None => Vec::new(),
    };
    for (name, count) in [
        ("TRANSLATION", translations.len()),
        ("ROTATION", rotations.len()),
        ("SCALE", scales.len()),
    ] {
        if attributes.get(name).is_some() {
            counts.push(count);
        }
    }
    // Without any of the three, the extension moves nothing.
    let Some(&count) = counts.first() else {
        return Ok(vec![DMat4::IDENTITY]);
    };
    if counts.iter().any(|&other| other != count) {
        return Err(damaged(format!(
            "{} have different counts: {counts:?}",
            attributes.place
        )));
    }
    buffers.spend(16 * count as u64)?;
    (0..count)
        .map(|copy| {
            let scale = scales.get(copy).map_or(DVec3::ONE, |&s| s.into());
            let rotation = rotations.get(copy).map_or(DQuat::IDENTITY, |&r| unit(r));
            let translation = translations.get(copy).map_or(DVec3::ZERO, |&t| t.into());
            let node_from_copy =
                DMat4::from_scale_rotation_translation(scale, rotation, translation);
            check_finite(node_from_copy, &attributes)?;
            Ok(node_from_copy)
        })
        .collect()
}
