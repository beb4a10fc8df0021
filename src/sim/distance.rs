//! Decides which objects' distances a step must update, and to which other objects: those that have moved towards one
//! another since the last update, by more than rounding, and only where their boxes come within reach.

use glam::DAffine3;

pub use super::moved::KeptPair;
use super::moved::{KeptPairs, is_within_rounding, most_moved};
pub use super::samples::TILE_SAMPLES;
use super::samples::{owned_texels, tile_of};
use super::types::{DistanceJob, ObjectPair, Pose, SampleTile, SurfaceSample};
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::Surface;
use crate::mesh::trees::{Tree, Trees};
use crate::scene::settings::{DepthMapping, DistanceMethod, DistanceSettings, SignRule};

/// Invocations of a group of the kernels; a job begins with one.
pub(super) const GROUP: u32 = 64;

/// The number of faces that may be nearest for which a tile has room.
pub const TILE_CANDIDATES: u32 = 32;

/// Most hints of a tile. If more other objects are within reach, the rest of them are searched sample by sample.
pub(super) const MOST_HINTS: u32 = 16;

/// Data for distances between objects, on the host; empty for a single object.
#[derive(Clone, Debug)]
pub struct DistanceSetup {
    /// The surface points under owned texels, object by object.
    pub samples: Vec<SurfaceSample>,
    /// The triangle of each sample.
    pub owners: Vec<u32>,
    /// First sample of each object, and one past the last.
    pub ranges: Vec<(u32, u32)>,
    /// Balls round the samples of each object, [`TILE_SAMPLES`] in each; the last of an object may have fewer.
    pub tiles: Vec<SampleTile>,
    /// First tile of each object.
    pub first_tiles: Vec<u32>,
    /// Trees for searches of nearest triangles.
    pub trees: Trees,
    /// For each object, which others count for it.
    pub others: Vec<Vec<u32>>,
}

impl DistanceSetup {
    /// The data of all objects of a surface; `others` lists for each object those that count for it.
    #[must_use]
    pub fn new(surface: &Surface, atlas: &Atlas, others: Vec<Vec<u32>>) -> Self {
        let mut samples: Vec<SurfaceSample> = Vec::new();
        let mut owners = Vec::new();
        let mut ranges = Vec::new();
        let mut tiles = Vec::new();
        let mut first_tiles = Vec::new();
        if surface.objects.len() > 1 {
            for own in owned_texels(surface, atlas) {
                let first = samples.len() as u32;
                samples.extend(own.iter().map(|owned| owned.sample));
                owners.extend(own.iter().map(|owned| owned.triangle));
                ranges.push((first, samples.len() as u32));
                first_tiles.push(tiles.len() as u32);
                let own = samples[first as usize..].chunks(TILE_SAMPLES as usize);
                tiles.extend(own.map(tile_of));
            }
        }
        let trees = if ranges.is_empty() {
            Trees::default()
        } else {
            Trees::build(surface)
        };
        Self {
            samples,
            owners,
            ranges,
            tiles,
            first_tiles,
            trees,
            others,
        }
    }

    /// The first node of each object's tree.
    #[must_use]
    pub fn roots(&self) -> Vec<u32> {
        let trees = self.trees.objects.iter();
        trees.map(|tree| tree.first_node).collect()
    }

    /// How many tiles the jobs of one update may have.
    #[must_use]
    pub fn tiles_len(&self) -> usize {
        let ranges = self.ranges.iter();
        let threads: u32 = ranges
            .map(|(first, end)| (end - first).next_multiple_of(GROUP))
            .sum();
        (threads / TILE_SAMPLES) as usize
    }

    /// How many margins the tiles of all objects have, with `hint_count` of each.
    #[must_use]
    pub fn margins_len(&self) -> usize {
        self.tiles.len() * self.hint_count() as usize
    }

    /// How many other objects the tiles of one have hints for.
    #[must_use]
    pub fn hint_count(&self) -> u32 {
        let most = self.others.iter().map(Vec::len).max().unwrap_or(0);
        MOST_HINTS.min(most as u32)
    }

    /// Are there no distances to compute?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }
}

/// The update of distances in a step; without jobs there is none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DistanceUpdate {
    /// The objects whose distances are computed.
    pub jobs: Vec<DistanceJob>,
    /// The other objects within their reach.
    pub pairs: Vec<ObjectPair>,
    /// The object of each job.
    pub objects: Vec<u32>,
    /// For each pair: the world length beyond which the other object's triangles do not matter. That is the reach, or the largest
    /// distance that a place inside of the object can have from all of them.
    pub farthest: Vec<f32>,
    /// For each pair: upper bound on the movement of the one object's places in the other's space since the last update; [`UNKNOWN_MOVE`]
    /// if unknown.
    pub moves: Vec<f32>,
    /// The number of invocations.
    pub thread_count: u32,
    /// Are all distances computed, also those that were known?
    pub is_first: bool,
}

/// Keeps the poses for which the objects' distances were last computed.
#[derive(Clone, Debug, Default)]
pub struct DistancePlanner {
    /// For each object: its pairs then. `None` before the first time.
    last: Vec<Option<Vec<NearPair>>>,
    /// The poses then.
    poses: Vec<Pose>,
    /// Pairs of objects that have moved by no more than rounding since theirs were computed, with the poses of that time.
    kept: KeptPairs,
    /// The settings that they were computed with.
    rules: Option<DistanceRules>,
}

/// The lengths that mappings from distances to depths are of, besides the longest distance; world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthLengths {
    /// How far before the near plane of a projection the eye is; positive.
    pub near: f32,
    /// What the curves take as 1; 0 for a quarter of the longest distance.
    pub scale: f32,
}

impl DepthLengths {
    /// The lengths in a scene of this radius.
    #[must_use]
    pub fn new(distance: &DistanceSettings, radius: f32) -> Self {
        Self {
            near: distance.depth_near * radius,
            scale: distance.depth_scale * radius,
        }
    }

    /// What the curves take as 1 where no distance is longer than this.
    #[must_use]
    pub fn scale_within(self, longest: f32) -> f32 {
        match self.scale > 0.0 {
            true => self.scale,
            false => 0.25 * longest,
        }
    }
}

/// The settings for computing distances; when they change, all distances are computed again.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceRules {
    /// A world length.
    pub reach: f32,
    /// The kernel.
    pub method: DistanceMethod,
    /// The mapping from distances to depths, for the method `raster`.
    pub depth: DepthMapping,
    /// The lengths that this mapping is of.
    pub depths: DepthLengths,
    /// The rule that decides whether a place is inside of an object.
    pub sign: SignRule,
    /// World length: places with a smaller signed distance are covered.
    pub threshold: f32,
    /// World length: how far behind a crossing places on the other object are found.
    pub farthest: f32,
    /// World length: a step from a place with a smaller distance may lead to a covered place.
    pub near: f32,
    /// World length: sensors that walk from a place with a smaller distance may get to a covered place.
    pub sight: f32,
    /// Are places behind crossings found at all?
    pub sees_across: bool,
    /// Edge crossings of a walk, and whether it is reflected at open borders.
    pub walk: (u32, bool),
}

impl DistancePlanner {
    /// For a run that is resumed: all distances are unknown. They were last computed with `poses`, except those of the `kept` pairs. Before
    /// the first time there are no poses.
    #[must_use]
    pub fn resumed(poses: &[Pose], kept: &[KeptPair]) -> Self {
        Self {
            poses: poses.to_vec(),
            kept: KeptPairs::from(kept),
            ..Self::default()
        }
    }

    /// The poses for which distances were last computed; none before the first time, and none with a single object.
    #[must_use]
    pub fn poses(&self) -> &[Pose] {
        &self.poses
    }

    /// The pairs of objects whose distances were last computed with other poses, which differ from those by rounding.
    #[must_use]
    pub fn kept(&self) -> Vec<KeptPair> {
        self.kept.to_vec()
    }

    /// Have any distances been computed since it was made?
    #[must_use]
    pub fn has_taken(&self) -> bool {
        !self.last.is_empty()
    }

    /// The update that these poses need, which then counts as done. Moved objects wait until an update is due. Until then, distances
    /// that are unknown for other reasons are computed with the poses of the last update.
    pub fn update(
        &mut self,
        setup: &DistanceSetup,
        poses: &[Pose],
        rules: DistanceRules,
        is_due: bool,
    ) -> DistanceUpdate {
        let mut update = DistanceUpdate::default();
        if setup.is_empty() {
            return update;
        }
        let moves = (is_due || self.poses.len() != poses.len()) && self.poses != poses;
        let before = if moves {
            std::mem::replace(&mut self.poses, poses.to_vec())
        } else {
            Vec::new()
        };
        if self.last.len() != poses.len() || self.rules != Some(rules) {
            self.last = vec![None; poses.len()];
            self.rules = Some(rules);
            update.is_first = true;
        } else if !moves {
            return update;
        }
        let poses: Vec<Placed> = self.poses.iter().map(Placed::new).collect();
        let near = (0..poses.len()).map(|object| pairs_of(setup, &poses, object, rules));
        let mut near: Vec<Vec<NearPair>> = near.collect();
        if moves {
            let before: Vec<Placed> = before.iter().map(Placed::new).collect();
            self.kept = kept_pairs(setup, &self.kept, &before, &poses, &near);
        }
        for (object, pairs) in near.iter_mut().enumerate() {
            for near in pairs {
                if let Some(kept) = self.kept.get(object as u32, near.other) {
                    near.pair = near.pair.with(*kept);
                }
            }
        }
        for (object, (last, pairs)) in self.last.iter_mut().zip(near).enumerate() {
            if last.as_ref() == Some(&pairs) {
                continue;
            }
            let own = &setup.trees.objects[object];
            let last_pairs = last.as_deref().unwrap_or_default();
            let moves = pairs.iter().enumerate().map(|(p, pair)| {
                // The kernel keeps its results by the place in the list of pairs.
                let before = last_pairs.get(p).filter(|last| last.other == pair.other);
                before.map_or(UNKNOWN_MOVE, |before| {
                    most_moved(own, &before.pair.pose(), &pair.pair.pose())
                })
            });
            update.add(
                object as u32,
                setup.ranges[object],
                setup.first_tiles[object],
                &pairs,
                moves,
            );
            *last = Some(pairs);
        }
        update
    }
}

impl DistanceUpdate {
    /// Tiles of the samples of all jobs.
    #[must_use]
    pub fn tile_count(&self) -> u32 {
        self.thread_count / TILE_SAMPLES
    }

    /// How many rounds `raster` takes: in each, every job has one of its pairs. The first one clears the old distances.
    #[must_use]
    pub fn rounds(&self) -> u32 {
        let most = self.jobs.iter().map(|job| job.pair_count).max();
        most.map_or(0, |most| most.max(1))
    }

    fn add(
        &mut self,
        object: u32,
        (first, end): (u32, u32),
        first_tile: u32,
        pairs: &[NearPair],
        moves: impl Iterator<Item = f32>,
    ) {
        if first == end {
            return;
        }
        self.jobs.push(DistanceJob {
            first_thread: self.thread_count,
            first_sample: first,
            sample_count: end - first,
            first_pair: self.pairs.len() as u32,
            pair_count: pairs.len() as u32,
            first_tile,
        });
        self.objects.push(object);
        self.moves.extend(moves);
        self.pairs.extend(pairs.iter().map(|near| near.pair));
        self.farthest.extend(pairs.iter().map(|near| near.farthest));
        self.thread_count += (end - first).next_multiple_of(GROUP);
    }
}

/// A pair of objects, and the distance up to which the other object's triangles matter.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NearPair {
    /// The other object.
    other: u32,
    pair: ObjectPair,
    farthest: f32,
}

/// More than any place moves.
pub const UNKNOWN_MOVE: f32 = 1e30;

/// Bound on the depth of places inside of a closed object: half of the shortest side of its box, plus a margin for rounding.
fn farthest(tree: &Tree, rules: DistanceRules) -> f32 {
    let sides = tree.high - tree.low;
    let deepest = if tree.is_closed {
        0.5 * sides.min_element()
    } else if rules.sign == SignRule::Winding {
        sides.length()
    } else {
        0.0
    };
    1.001 * deepest.max(rules.reach)
}

/// The pairs of an object with those others whose boxes come within reach of its own.
fn pairs_of(
    setup: &DistanceSetup,
    poses: &[Placed],
    object: usize,
    rules: DistanceRules,
) -> Vec<NearPair> {
    let own = &setup.trees.objects[object];
    let others = setup.others[object].iter();
    others
        .map(|&other| (other as usize, &setup.trees.objects[other as usize]))
        .filter_map(|(index, other)| {
            // Distances of exactly the reach are clamped; the factor is a margin for rounding.
            let apart = f64::from(rules.reach) * 1.001;
            let (centre, radius) = own.sphere();
            let (other_centre, other_radius) = other.sphere();
            let between = poses[object].world_from_object.transform_point3(centre)
                - poses[index]
                    .world_from_object
                    .transform_point3(other_centre);
            if between.length() > radius + other_radius + apart {
                return None;
            }
            let other_from_object = poses[index].places_of(&poses[object]);
            if boxes_are_apart(own, other, &other_from_object, apart) {
                return None;
            }
            let Pose { x, y, z } = rows(other_from_object);
            let pair = ObjectPair {
                x,
                y,
                z,
                first_face: other.first_face,
                face_count: other.face_count,
                first_node: other.first_node,
                // By winding numbers, a place may be inside of an open object that encloses most of it.
                is_closed: u32::from(other.is_closed || rules.sign == SignRule::Winding),
            };
            Some(NearPair {
                other: index as u32,
                pair,
                farthest: farthest(other, rules),
            })
        })
        .collect()
}

/// The near pairs whose relative pose has moved by no more than rounding since they were taken, and the pose that they
/// were taken with: that of the pair that was kept until now, otherwise the one of `before`, which is empty at first.
fn kept_pairs(
    setup: &DistanceSetup,
    kept: &KeptPairs,
    before: &[Placed],
    now: &[Placed],
    near: &[Vec<NearPair>],
) -> KeptPairs {
    let mut still_kept = KeptPairs::default();
    if before.len() != now.len() {
        return still_kept;
    }
    for (object, pairs) in near.iter().enumerate() {
        for NearPair { other, pair, .. } in pairs {
            let (own, index) = (object as u32, *other as usize);
            let taken = kept.get(own, *other).copied();
            let taken = taken.unwrap_or_else(|| rows(before[index].places_of(&before[object])));
            let far = now[object].distance_from_origin() + now[index].distance_from_origin();
            let is_there = pair.pose();
            if taken != is_there
                && is_within_rounding(&setup.trees.objects[object], &taken, &is_there, far)
            {
                still_kept.insert(own, *other, taken);
            }
        }
    }
    still_kept
}

/// In the precision that devices work with.
fn rows(pose: DAffine3) -> Pose {
    let rows = glam::DMat4::from(pose).transpose().as_mat4();
    Pose::of_rows([rows.x_axis, rows.y_axis, rows.z_axis])
}

impl ObjectPair {
    fn pose(&self) -> Pose {
        let Self { x, y, z, .. } = *self;
        Pose { x, y, z }
    }

    fn with(self, Pose { x, y, z }: Pose) -> Self {
        Self { x, y, z, ..self }
    }
}

/// An object with its pose.
struct Placed {
    world_from_object: DAffine3,
    object_from_world: DAffine3,
}

impl Placed {
    fn new(pose: &Pose) -> Self {
        let world_from_object = DAffine3::from(pose);
        Self {
            world_from_object,
            object_from_world: world_from_object.inverse(),
        }
    }

    /// Takes places of the other object to this one's space.
    fn places_of(&self, other: &Self) -> DAffine3 {
        self.object_from_world * other.world_from_object
    }

    fn distance_from_origin(&self) -> f64 {
        self.world_from_object.translation.length()
    }
}

/// Is some face of either box a plane that keeps the boxes further apart than `reach`? Boxes that only edges keep apart count as near,
/// which only costs time.
fn boxes_are_apart(own: &Tree, other: &Tree, other_from_own: &DAffine3, reach: f64) -> bool {
    let apart = |from: &Tree, to: &Tree, to_from: &DAffine3| {
        let centre = 0.5 * (from.low.as_dvec3() + from.high.as_dvec3());
        let half = from.high.as_dvec3() - centre;
        let centre = to_from.transform_point3(centre);
        let matrix = to_from.matrix3;
        let extent = half.x * matrix.x_axis.abs()
            + half.y * matrix.y_axis.abs()
            + half.z * matrix.z_axis.abs();
        let gap = (centre - extent - to.high.as_dvec3()).max(to.low.as_dvec3() - centre - extent);
        gap.max_element() > reach
    };
    apart(own, other, other_from_own) || apart(other, own, &other_from_own.inverse())
}
