//! The first animation of a glTF file as the motion of the whole model, where it moves all of it alike and rigidly.

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::json::animation::{Interpolation, Property};
use gltf::json::validation::Checked;
use gltf::json::{Node, Root};

use super::resource::Buffers;
use super::{accessor, damaged, get, parent_from_node, top_nodes};
use crate::mesh::error::MeshProblem;

/// How far a transform may be from rigid: rounding of animations in float32 is far below, what can be seen above.
const RIGID_WITHIN: f64 = 1e-3;

/// A model's animation: where it takes the model, from where the file puts it, in the model's own coordinates. It begins
/// again when its last key is over.
#[derive(Clone, Debug)]
pub struct RigidTrack {
    /// From the scene's root to a node with a mesh.
    chain: Vec<Link>,
    /// Brings the model back from where the file puts it to the chain's last node.
    node_from_rest: DMat4,
    /// Seconds.
    duration: f64,
}

/// A node and what animates it.
#[derive(Clone, Debug)]
struct Link {
    rest: DMat4,
    scale: DVec3,
    rotation: DQuat,
    translation: DVec3,
    channels: Vec<Channel>,
}

#[derive(Clone, Debug)]
struct Channel {
    property: Property,
    interpolation: Interpolation,
    times: Vec<f64>,
    /// Vectors in their first three components, quaternions in all.
    values: Vec<[f64; 4]>,
}

impl RigidTrack {
    /// Rotation and translation at a time in seconds.
    #[must_use]
    pub fn at(&self, time: f64) -> (DQuat, DVec3) {
        let moved = self.moved(time.rem_euclid(self.duration));
        let rotation = DQuat::from_mat3(&DMat3::from_mat4(moved));
        (rotation.normalize(), moved.w_axis.truncate())
    }

    /// Seconds after which it begins again.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    fn moved(&self, time: f64) -> DMat4 {
        let chain = self.chain.iter().map(|link| link.at(time));
        chain.product::<DMat4>() * self.node_from_rest
    }

    /// All keys, and times between them.
    fn times(&self) -> Vec<f64> {
        let channels = self.chain.iter().flat_map(|link| &link.channels);
        let mut keys: Vec<f64> = channels.flat_map(|channel| channel.times.clone()).collect();
        keys.sort_by(f64::total_cmp);
        let between = keys
            .windows(2)
            .flat_map(|w| [0.3, 0.6].map(|share| w[0] + share * (w[1] - w[0])));
        let mut times: Vec<f64> = between.collect();
        times.extend(keys);
        times
    }
}

impl Link {
    fn at(&self, time: f64) -> DMat4 {
        if self.channels.is_empty() {
            return self.rest;
        }
        let (mut scale, mut rotation, mut translation) =
            (self.scale, self.rotation, self.translation);
        for channel in &self.channels {
            let value = channel.at(time);
            let vector = DVec3::new(value[0], value[1], value[2]);
            match channel.property {
                Property::Translation => translation = vector,
                Property::Scale => scale = vector,
                Property::Rotation => rotation = unit(DQuat::from_array(value)),
                Property::MorphTargetWeights => {}
            }
        }
        DMat4::from_scale_rotation_translation(scale, rotation, translation)
    }
}

impl Channel {
    fn at(&self, time: f64) -> [f64; 4] {
        let next = self.times.partition_point(|&key| key <= time);
        let cubic = self.interpolation == Interpolation::CubicSpline;
        // A cubic spline has three values a key: the tangent in, the value, the tangent out.
        let value = |key: usize| {
            if cubic {
                self.values[3 * key + 1]
            } else {
                self.values[key]
            }
        };
        if next == 0 {
            return value(0);
        }
        if next == self.times.len() {
            return value(next - 1);
        }
        let length = self.times[next] - self.times[next - 1];
        let share = (time - self.times[next - 1]) / length;
        let (a, b) = (value(next - 1), value(next));
        match (self.interpolation, self.property) {
            (Interpolation::Step, _) => a,
            (Interpolation::Linear, Property::Rotation) => {
                let (a, b) = (unit(DQuat::from_array(a)), unit(DQuat::from_array(b)));
                a.slerp(b, share).to_array()
            }
            (Interpolation::Linear, _) => std::array::from_fn(|i| a[i] + share * (b[i] - a[i])),
            (Interpolation::CubicSpline, _) => {
                // Hermite's form, glTF 2.0, appendix C.
                let (out, into) = (self.values[3 * (next - 1) + 2], self.values[3 * next]);
                let (s, s2, s3) = (share, share * share, share * share * share);
                std::array::from_fn(|i| {
                    (2.0 * s3 - 3.0 * s2 + 1.0) * a[i]
                        + length * (s3 - 2.0 * s2 + s) * out[i]
                        + (3.0 * s2 - 2.0 * s3) * b[i]
                        + length * (s3 - s2) * into[i]
                })
            }
        }
    }
}

fn unit(rotation: DQuat) -> DQuat {
    if rotation.length_squared() > 0.0 && rotation.is_finite() {
        rotation.normalize()
    } else {
        DQuat::IDENTITY
    }
}

fn refused(problem: String) -> MeshProblem {
    MeshProblem::Animation(problem)
}

/// The first animation of the file.
pub(super) fn track(root: &Root, buffers: &mut Buffers<'_>) -> Result<RigidTrack, MeshProblem> {
    let Some(animation) = root.animations.first() else {
        return Err(refused("the model has no animation".to_owned()));
    };
    let mut channels: Vec<Vec<Channel>> = vec![Vec::new(); root.nodes.len()];
    for channel in &animation.channels {
        let node = channel.target.node.value();
        get(&root.nodes, node, "node")?;
        let sampler = get(&animation.samplers, channel.sampler.value(), "sampler")?;
        let (Checked::Valid(property), Checked::Valid(interpolation)) =
            (channel.target.path, sampler.interpolation)
        else {
            return Err(damaged(format!(
                "a channel of node {node} is of no known kind"
            )));
        };
        if property == Property::MorphTargetWeights {
            return Err(refused(format!(
                "its animation changes the shape of node {node}, and only rigid motion can be followed"
            )));
        }
        channels[node].push(read(
            buffers,
            sampler.input.value(),
            sampler.output.value(),
            property,
            interpolation,
        )?);
    }
    let tracks = chains(root)?
        .into_iter()
        .map(|(chain, is_skinned)| {
            if is_skinned {
                return Err(refused(
                    "its mesh is skinned, so the animation bends it, and only rigid motion can be followed".to_owned(),
                ));
            }
            let links = chain.iter().map(|&node| link(&root.nodes[node], channels[node].clone()));
            let chain: Vec<Link> = links.collect();
            let rest: DMat4 = chain.iter().map(|link| link.rest).product();
            Ok(RigidTrack {
                chain,
                node_from_rest: rest.inverse(),
                duration: 0.0,
            })
        })
        .collect::<Result<Vec<_>, _>>()?;
    let last = tracks
        .iter()
        .flat_map(RigidTrack::times)
        .fold(0.0, f64::max);
    if last <= 0.0 {
        return Err(refused(
            "its first animation moves none of the nodes that have a mesh".to_owned(),
        ));
    }
    check(&tracks)?;
    let first = tracks.into_iter().next();
    let mut track = first.ok_or_else(|| refused("its scene shows no mesh".to_owned()))?;
    track.duration = last;
    Ok(track)
}

/// Makes sure that every node with a mesh moves rigidly, and that all move alike.
fn check(tracks: &[RigidTrack]) -> Result<(), MeshProblem> {
    for time in tracks.iter().flat_map(RigidTrack::times) {
        let moved: Vec<DMat4> = tracks.iter().map(|track| track.moved(time)).collect();
        for transform in &moved {
            let turn = DMat3::from_mat4(*transform);
            let off = turn.transpose() * turn - DMat3::IDENTITY;
            let is_rigid = off.abs_diff_eq(DMat3::ZERO, RIGID_WITHIN) && turn.determinant() > 0.0;
            if !is_rigid {
                return Err(refused(format!(
                    "at {time:.3} s its animation scales or skews the model, and only rigid motion can be followed: \
                     take the scale out of the animation"
                )));
            }
            if !transform.abs_diff_eq(moved[0], RIGID_WITHIN * transform.w_axis.length().max(1.0)) {
                return Err(refused(format!(
                    "at {time:.3} s its parts have moved differently, and an object moves as a whole: export each \
                     part as a model of its own"
                )));
            }
        }
    }
    Ok(())
}

fn link(node: &Node, channels: Vec<Channel>) -> Link {
    let triple = |vector: Option<[f32; 3]>, none: f32| {
        DVec3::from_array(vector.unwrap_or([none; 3]).map(f64::from))
    };
    Link {
        rest: parent_from_node(node),
        scale: triple(node.scale, 1.0),
        rotation: node.rotation.map_or(DQuat::IDENTITY, |rotation| {
            unit(DQuat::from_array(rotation.0.map(f64::from)))
        }),
        translation: triple(node.translation, 0.0),
        channels,
    }
}

/// The way from the root to each node with a mesh, and whether the mesh is skinned.
fn chains(root: &Root) -> Result<Vec<(Vec<usize>, bool)>, MeshProblem> {
    let mut parents = vec![None; root.nodes.len()];
    let mut visited = vec![false; root.nodes.len()];
    let mut stack: Vec<(usize, Option<usize>)> = top_nodes(root)?
        .into_iter()
        .rev()
        .map(|node| (node, None))
        .collect();
    let mut chains = Vec::new();
    while let Some((index, parent)) = stack.pop() {
        let node = get(&root.nodes, index, "node")?;
        if std::mem::replace(&mut visited[index], true) {
            continue;
        }
        parents[index] = parent;
        if node.mesh.is_some() {
            let mut chain: Vec<usize> =
                std::iter::successors(Some(index), |&node| parents[node]).collect();
            chain.reverse();
            chains.push((chain, node.skin.is_some()));
        }
        let children = node.children.iter().flatten().rev();
        stack.extend(children.map(|child| (child.value(), Some(index))));
    }
    Ok(chains)
}

fn read(
    buffers: &mut Buffers<'_>,
    input: usize,
    output: usize,
    property: Property,
    interpolation: Interpolation,
) -> Result<Channel, MeshProblem> {
    let times = accessor::vectors::<1>(buffers, input)?;
    let times: Vec<f64> = times.into_iter().map(|[time]| f64::from(time)).collect();
    let ascend = times.windows(2).all(|w| w[0] < w[1]);
    if times.is_empty() || !ascend || times[0] < 0.0 || !times.iter().all(|time| time.is_finite()) {
        return Err(damaged(format!(
            "the times in accessor {input} do not ascend from 0"
        )));
    }
    let values: Vec<[f64; 4]> = if property == Property::Rotation {
        let values = accessor::vectors::<4>(buffers, output)?;
        values
            .into_iter()
            .map(|value| value.map(f64::from))
            .collect()
    } else {
        let values = accessor::vectors::<3>(buffers, output)?;
        let widened = |[x, y, z]: [f32; 3]| [x, y, z, 0.0].map(f64::from);
        values.into_iter().map(widened).collect()
    };
    let a_key = if interpolation == Interpolation::CubicSpline {
        3
    } else {
        1
    };
    if values.len() != a_key * times.len()
        || !values.iter().flatten().all(|value| value.is_finite())
    {
        return Err(damaged(format!(
            "accessor {output} does not have {a_key} finite values for each of {} keys",
            times.len()
        )));
    }
    Ok(Channel {
        property,
        interpolation,
        times,
        values,
    })
}
