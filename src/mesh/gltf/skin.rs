//! Skinned meshes in the pose that the file's nodes have at rest.

use glam::{DMat4, DVec3};

use super::json::Part;
use super::resource::Buffers;
use super::scene::Scene;
use super::{accessor, damaged};
use crate::mesh::error::MeshProblem;

/// The joints of one skin.
pub(super) struct Skin {
    /// Its place in the file.
    place: String,
    /// From the mesh as it was bound to where each joint takes it.
    world_from_bound: Vec<DMat4>,
}

impl Skin {
    pub(super) fn new(
        skin: &Part<'_>,
        scene: &mut Scene<'_>,
        buffers: &mut Buffers<'_>,
    ) -> Result<Self, MeshProblem> {
        let bound_from_mesh = match skin.get("inverseBindMatrices") {
            Some(reference) => Some((
                accessor::vectors::<16>(buffers, &reference)?,
                reference.place,
            )),
            None => None,
        };
        let mut world_from_bound = Vec::new();
        for (index, joint) in skin.items("joints")?.enumerate() {
            let mut transform = scene.world_from(&joint)?;
            if let Some((matrices, place)) = &bound_from_mesh {
                let Some(matrix) = matrices.get(index) else {
                    return Err(damaged(format!(
                        "{place} has {} matrices, and {} joints need one each",
                        matrices.len(),
                        skin.count("joints")?
                    )));
                };
                transform *= DMat4::from_cols_array(matrix);
                if !transform.is_finite() {
                    return Err(damaged(format!("matrix {index} of {place} is not finite")));
                }
            }
            world_from_bound.push(transform);
        }
        Ok(Self {
            place: skin.place.clone(),
            world_from_bound,
        })
    }

    /// The vertices of a primitive where its joints take them; `None` where the primitive has no joints.
    ///
    /// Khronos' glTF-Sample-Renderer shows them so: the sum of weighted joint matrices, divided by the sum of the
    /// weights (`primitive.vert` divides by `w`), and no transform where that is zero (`animation.glsl`).
    pub(super) fn pose(
        &self,
        buffers: &mut Buffers<'_>,
        attributes: &Part<'_>,
        bound: &[DVec3],
    ) -> Result<Option<Vec<DVec3>>, MeshProblem> {
        let mut sums = vec![(DVec3::ZERO, 0.0); bound.len()];
        let mut sets = 0;
        while let (Some(joints), Some(weights)) = (
            attributes.get(&format!("JOINTS_{sets}")),
            attributes.get(&format!("WEIGHTS_{sets}")),
        ) {
            sets += 1;
            let all_joints = accessor::whole_numbers::<4>(buffers, &joints)?;
            let all_weights = accessor::vectors::<4>(buffers, &weights)?;
            for (part, count) in [(&joints, all_joints.len()), (&weights, all_weights.len())] {
                if count != bound.len() {
                    return Err(damaged(format!(
                        "{} has {count} elements for {} vertices",
                        part.place,
                        bound.len()
                    )));
                }
            }
            for (vertex, four) in all_joints.iter().zip(&all_weights).enumerate() {
                let (sum, total) = &mut sums[vertex];
                for (&joint, &weight) in four.0.iter().zip(four.1) {
                    if weight == 0.0 {
                        continue;
                    }
                    if !weight.is_finite() {
                        return Err(damaged(format!(
                            "{} is not finite at vertex {vertex}",
                            weights.place
                        )));
                    }
                    let Some(transform) = self.world_from_bound.get(joint as usize) else {
                        return Err(damaged(format!(
                            "{} names joint {joint} at vertex {vertex}, and {} has {}",
                            joints.place,
                            self.place,
                            self.world_from_bound.len()
                        )));
                    };
                    *sum += weight * transform.transform_point3(bound[vertex]);
                    *total += weight;
                }
            }
        }
        if sets == 0 {
            return Ok(None);
        }
        let positions = sums
            .iter()
            .zip(bound)
            .map(|(&(sum, total), &bound)| if total == 0.0 { bound } else { sum / total })
            .collect();
        Ok(Some(positions))
    }
}
