//! The first animation of a glTF file as the motion of the whole model, where it moves all of it alike and rigidly.

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::json::animation::{Interpolation, Property};

use super::json::Part;
use super::resource::Buffers;
use super::scene::{Placement, Scene, parent_from_node, unit};
use super::{accessor, damaged};
use crate::mesh::MeshReport;
use crate::mesh::error::MeshProblem;
use crate::portable::turn_between;

/// Tolerance for rigid transforms: far above the rounding of animations in float32, and below visible deformation.
const RIGID_WITHIN: f64 = 1e-3;

/// Cost of a key, in numbers decoded; more than that of decoding, because it is kept.
const KEY: u64 = 64;

/// Cost of evaluating a channel at a time, in numbers decoded.
const EVALUATION: u64 = 16;

/// A model's animation: the motion of the model relative to its rest pose, in the model's own coordinates. It repeats after its last key.
#[derive(Clone, Debug)]
pub struct RigidTrack {
    /// The animated nodes from the scene's root down to the last one above a mesh.
    chain: Vec<Link>,
    /// Maps from the model's rest pose to the chain's last node.
    node_from_rest: DMat4,
    /// Seconds.
    duration: f64,
}

/// An animated node and what animates it.
#[derive(Clone, Debug)]
struct Link {
    /// From the node's parent to the animated node above, or to the scene's root; nodes between them are at rest.
    above_from_parent: DMat4,
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
}

impl Link {
    fn new(
        node: &Part<'_>,
        above_from_parent: DMat4,
        channels: Vec<Channel>,
    ) -> Result<Self, MeshProblem> {
        let Placement {
            scale,
            rotation,
            translation,
        } = Placement::of(node)?;
        Ok(Self {
            above_from_parent,
            scale,
            rotation,
            translation,
            channels,
        })
    }

    /// From the node to the animated node above.
    fn at(&self, time: f64) -> DMat4 {
        let (mut scale, mut rotation, mut translation) =
            (self.scale, self.rotation, self.translation);
        for channel in &self.channels {
            let value = channel.at(time);
            let vector = DVec3::new(value[0], value[1], value[2]);
            match channel.property {
                Property::Translation => translation = vector,
                Property::Scale => scale = vector,
                Property::Rotation => rotation = unit(value),
                Property::MorphTargetWeights => {}
            }
        }
        self.above_from_parent
            * DMat4::from_scale_rotation_translation(scale, rotation, translation)
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
                let (a, b) = (unit(a), unit(b));
                turn_between(a, b, share).to_array()
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

fn refused(problem: String) -> MeshProblem {
    MeshProblem::Animation(problem)
}

/// A channel that can be followed, and the node that it moves.
struct Target<'a> {
    node: usize,
    property: Property,
    channel: Part<'a>,
}

/// The channels of an animation that animate nodes. Channels without a node, or of an unknown kind, animate something
/// else, by an extension or not at all.
fn targets<'a>(root: &Part<'a>, animation: &Part<'a>) -> Result<Vec<Target<'a>>, MeshProblem> {
    let mut targets = Vec::new();
    for channel in animation.items("channels")? {
        let (Some(reference), Some(path)) = (
            channel.at(&["target", "node"]),
            channel.at(&["target", "path"]),
        ) else {
            continue;
        };
        let property = match path.as_text() {
            Ok("translation") => Property::Translation,
            Ok("rotation") => Property::Rotation,
            Ok("scale") => Property::Scale,
            Ok("weights") => Property::MorphTargetWeights,
            _ => continue,
        };
        targets.push(Target {
            node: root.named("nodes", &reference)?.0,
            property,
            channel,
        });
    }
    Ok(targets)
}

/// The first animation of the file that moves nodes; without one, the first that animates a node at all.
fn first_animation<'a>(
    root: &Part<'a>,
) -> Result<Option<(Part<'a>, Vec<Target<'a>>)>, MeshProblem> {
    let mut of_shapes = None;
    for animation in root.items("animations")? {
        let targets = targets(root, &animation)?;
        let moves = |target: &Target<'_>| target.property != Property::MorphTargetWeights;
        if targets.iter().any(moves) {
            return Ok(Some((animation, targets)));
        }
        if !targets.is_empty() && of_shapes.is_none() {
            of_shapes = Some((animation, targets));
        }
    }
    Ok(of_shapes)
}

/// The first animation of the file that moves nodes.
pub(super) fn track(buffers: &mut Buffers<'_>) -> Result<RigidTrack, MeshProblem> {
    let root = buffers.root.clone();
    let Some((animation, targets)) = first_animation(&root)? else {
        return Err(refused(match root.count("animations")? {
            0 => "the model has no animation".to_owned(),
            count => format!("the model has no animation that moves a node, of {count}"),
        }));
    };
    let mut channels: Vec<Vec<Channel>> = vec![Vec::new(); root.count("nodes")?];
    for target in targets {
        if target.property == Property::MorphTargetWeights {
            return Err(refused(format!(
                "its animation changes the shape of node {}, and only rigid motion can be followed",
                target.node
            )));
        }
        let reference = target.channel.needed("sampler")?;
        let (_, sampler) = animation.named("samplers", &reference)?;
        channels[target.node].push(read(buffers, &sampler, target.property)?);
    }
    let scene = Scene::new(&root, &mut MeshReport::default())?;
    let mut motion = Motion::new(&scene, channels);
    for shown in &scene.shown {
        if shown.node.get("skin").is_some() {
            return Err(refused(
                "its mesh is skinned, so the animation bends it, and only rigid motion can be followed".to_owned(),
            ));
        }
        motion.add(&root, shown.index)?;
    }
    let keys = motion.keys();
    let last = keys.last().copied().unwrap_or(0.0);
    if last <= 0.0 {
        return Err(refused(
            "its animation moves none of the nodes that have a mesh".to_owned(),
        ));
    }
    motion.check(buffers, &keys)?;
    Ok(motion.track(last))
}

/// The animated nodes of a scene that move meshes.
struct Motion<'s> {
    scene: &'s Scene<'s>,
    /// Channels of each node, until it is added.
    channels: Vec<Vec<Channel>>,
    /// Movers of each node, once it is added.
    below: Vec<Option<Below>>,
    /// Each after those above it.
    movers: Vec<Mover>,
    /// The nearest mover above each mesh, without repetition; `None` for meshes at rest.
    of_meshes: Vec<Option<usize>>,
    has_still_mesh: bool,
}

/// An animated node.
struct Mover {
    /// The next one above it.
    above: Option<usize>,
    link: Link,
    /// Brings the model back from where the file puts it to this node.
    node_from_rest: DMat4,
    has_mesh: bool,
}

/// The nearest mover of a node, which may be the node itself.
#[derive(Clone, Copy)]
struct Below {
    mover: Option<usize>,
    mover_from_node: DMat4,
}

impl<'s> Motion<'s> {
    fn new(scene: &'s Scene<'s>, channels: Vec<Vec<Channel>>) -> Self {
        Self {
            scene,
            below: vec![None; channels.len()],
            channels,
            movers: Vec::new(),
            of_meshes: Vec::new(),
            has_still_mesh: false,
        }
    }

    /// Adds a node with a mesh, and those above it that are not there yet.
    fn add(&mut self, root: &Part<'_>, index: usize) -> Result<(), MeshProblem> {
        let mut chain = Vec::new();
        let mut above = Some(index);
        while let Some(index) = above.filter(|&index| self.below[index].is_none()) {
            chain.push(index);
            above = self.scene.parent(index);
        }
        let mut below = above.and_then(|index| self.below[index]).unwrap_or(Below {
            mover: None,
            mover_from_node: DMat4::IDENTITY,
        });
        for index in chain.into_iter().rev() {
            if let Some(node) = root.item("nodes", index)? {
                let channels = std::mem::take(&mut self.channels[index]);
                if channels.is_empty() {
                    below.mover_from_node *= parent_from_node(&node)?;
                } else {
                    self.movers.push(Mover {
                        above: below.mover,
                        link: Link::new(&node, below.mover_from_node, channels)?,
                        node_from_rest: self.scene.world(index).inverse(),
                        has_mesh: false,
                    });
                    below = Below {
                        mover: Some(self.movers.len() - 1),
                        mover_from_node: DMat4::IDENTITY,
                    };
                }
            }
            self.below[index] = Some(below);
        }
        let is_there = match below.mover {
            Some(mover) => &mut self.movers[mover].has_mesh,
            None => &mut self.has_still_mesh,
        };
        if !std::mem::replace(is_there, true) {
            self.of_meshes.push(below.mover);
        }
        Ok(())
    }

    /// The times of all keys, each once, in order.
    fn keys(&self) -> Vec<f64> {
        let channels = self.movers.iter().flat_map(|mover| &mover.link.channels);
        let mut keys: Vec<f64> = channels
            .flat_map(|channel| channel.times.iter().copied())
            .collect();
        keys.sort_by(f64::total_cmp);
        keys.dedup();
        keys
    }

    /// Makes sure that every node with a mesh moves rigidly, and that all move alike.
    fn check(&self, buffers: &mut Buffers<'_>, keys: &[f64]) -> Result<(), MeshProblem> {
        let between = keys
            .windows(2)
            .flat_map(|w| [0.3, 0.6].map(|share| w[0] + share * (w[1] - w[0])));
        let channels = self.movers.iter().map(|mover| mover.link.channels.len());
        let channels = channels.sum::<usize>() as u64;
        buffers.spend((3 * keys.len() as u64).saturating_mul(EVALUATION * channels))?;
        let mut worlds = vec![DMat4::IDENTITY; self.movers.len()];
        for time in between.chain(keys.iter().copied()) {
            for (index, mover) in self.movers.iter().enumerate() {
                let above = mover.above.map_or(DMat4::IDENTITY, |above| worlds[above]);
                worlds[index] = above * mover.link.at(time);
            }
            let mut first = None;
            for &mover in &self.of_meshes {
                let moved = mover.map_or(DMat4::IDENTITY, |mover| {
                    worlds[mover] * self.movers[mover].node_from_rest
                });
                let turn = DMat3::from_mat4(moved);
                let off = turn.transpose() * turn - DMat3::IDENTITY;
                let is_rigid =
                    off.abs_diff_eq(DMat3::ZERO, RIGID_WITHIN) && turn.determinant() > 0.0;
                if !is_rigid {
                    return Err(refused(format!(
                        "at {time:.3} s its animation scales or skews the model, and only rigid motion can be followed: \
                         take the scale out of the animation"
                    )));
                }
                let near = RIGID_WITHIN * moved.w_axis.length().max(1.0);
                if !moved.abs_diff_eq(*first.get_or_insert(moved), near) {
                    return Err(refused(format!(
                        "at {time:.3} s its parts have moved differently, and an object moves as a whole: export each \
                         part as a model of its own"
                    )));
                }
            }
        }
        Ok(())
    }

    /// The motion of the first mesh.
    fn track(self, duration: f64) -> RigidTrack {
        let last = self.of_meshes.first().copied().flatten();
        let mut chain: Vec<Link> = std::iter::successors(last, |&mover| self.movers[mover].above)
            .map(|mover| self.movers[mover].link.clone())
            .collect();
        chain.reverse();
        RigidTrack {
            chain,
            node_from_rest: last.map_or(DMat4::IDENTITY, |last| self.movers[last].node_from_rest),
            duration,
        }
    }
}

fn read(
    buffers: &mut Buffers<'_>,
    sampler: &Part<'_>,
    property: Property,
) -> Result<Channel, MeshProblem> {
    let (input, output) = (sampler.needed("input")?, sampler.needed("output")?);
    let interpolation = match sampler.get("interpolation") {
        None => Interpolation::Linear,
        Some(part) => match part.as_text()? {
            "LINEAR" => Interpolation::Linear,
            "STEP" => Interpolation::Step,
            "CUBICSPLINE" => Interpolation::CubicSpline,
            _ => return Err(part.should_be("LINEAR, STEP or CUBICSPLINE")),
        },
    };
    let times = accessor::vectors::<1>(buffers, &input)?;
    let times: Vec<f64> = times.into_iter().map(|[time]| time).collect();
    buffers.spend(KEY * times.len() as u64)?;
    let ascend = times.windows(2).all(|w| w[0] < w[1]);
    if times.is_empty() || !ascend || times[0] < 0.0 || !times.iter().all(|time| time.is_finite()) {
        return Err(damaged(format!(
            "the times of {} do not ascend from 0",
            input.place
        )));
    }
    let values: Vec<[f64; 4]> = if property == Property::Rotation {
        accessor::vectors::<4>(buffers, &output)?
    } else {
        let values = accessor::vectors::<3>(buffers, &output)?;
        values.into_iter().map(|[x, y, z]| [x, y, z, 0.0]).collect()
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
            "{} does not have {a_key} finite values for each of {} keys",
            output.place,
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
