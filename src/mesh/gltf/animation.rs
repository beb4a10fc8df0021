//! The first animation of a glTF file as the motion of the whole model, where it moves all of it alike and rigidly.

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::json::animation::{Interpolation, Property};

use super::json::Part;
use super::resource::Buffers;
use super::scene::{Placement, Scene, parent_from_node, unit};
use super::{accessor, damaged};
use crate::mesh::MeshReport;
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
                Property::Rotation => rotation = unit(value),
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
                let (a, b) = (unit(a), unit(b));
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
    let mut tracks = Vec::new();
    for shown in &scene.shown {
        if shown.node.get("skin").is_some() {
            return Err(refused(
                "its mesh is skinned, so the animation bends it, and only rigid motion can be followed".to_owned(),
            ));
        }
        let mut chain = Vec::new();
        for index in scene.chain(shown.index) {
            if let Some(node) = root.item("nodes", index)? {
                chain.push(link(&node, channels[index].clone())?);
            }
        }
        tracks.push(RigidTrack {
            chain,
            node_from_rest: shown.world_from_node.inverse(),
            duration: 0.0,
        });
    }
    let last = tracks
        .iter()
        .flat_map(RigidTrack::times)
        .fold(0.0, f64::max);
    if last <= 0.0 {
        return Err(refused(
            "its animation moves none of the nodes that have a mesh".to_owned(),
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

fn link(node: &Part<'_>, channels: Vec<Channel>) -> Result<Link, MeshProblem> {
    let Placement {
        scale,
        rotation,
        translation,
    } = Placement::of(node)?;
    Ok(Link {
        rest: parent_from_node(node)?,
        scale,
        rotation,
        translation,
        channels,
    })
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
