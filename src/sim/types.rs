//! The structs that the host and the kernels share; `shaders/include/types.glsl` declares them for the kernels.
//! The build compares every size and offset with the reflected shaders: a mismatch does not compile.

use bytemuck::{Pod, Zeroable};
use glam::{Affine3A, DAffine3, DMat3, DVec3, Vec3, Vec4};

use crate::strict::settled;

pub use super::physarum::Physarum;
pub use crate::mesh::atlas::{ExchangeEntry, ExchangeRow};
pub use crate::mesh::surface::{AtlasMap, HalfEdge, Seam, Triangle};

/// Place and id of a particle.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Particle {
    /// Global triangle id.
    pub triangle: u32,
    /// Barycentric weight of corner B.
    pub u: f32,
    /// Barycentric weight of corner C.
    pub v: f32,
    /// Never changes; random streams are keyed by it.
    pub id: u32,
}

/// Heading and state of a particle's walk.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Motion {
    /// `p` component of the heading, a unit vector in the tangent frame of the particle's triangle.
    pub heading_p: f32,
    /// `h` component of the heading.
    pub heading_h: f32,
    /// World length left when the last walk ran out of edge-crossing attempts; walked first in the next step.
    pub pending: f32,
    /// Bit 0 is set while the particle is selected to leave its object in the present step, and never between steps. Bit 1 is set if it
    /// was refused a cell in the last step. Bit 2 is set while it is dead: then its slot waits for a birth. Bits 3 to 15 are the number of
    /// steps for which it has been hungry, if particles die of hunger; otherwise 0. The upper 16 bits are the number of steps for which
    /// it stays fed; 0 without food.
    pub flags: u32,
}

impl Motion {
    /// The flag of particles that are selected to leave their object in the present step.
    pub const SELECTED: u32 = 1;
    /// The flag of particles that were refused a cell in the last step, and so left no deposit.
    pub const STAYED: u32 = 2;
    /// The flag of particles that are dead: nothing but their ids is of use, to particles that will be born.
    pub const DEAD: u32 = 4;
    /// Position of the lowest bit of the number of steps for which it has been hungry.
    pub const HUNGRY_SHIFT: u32 = 3;
    /// The largest of these numbers: there counting stops.
    pub const MOST_HUNGRY: u32 = 8191;
    /// Position of the lowest bit of the number of steps for which it stays fed.
    pub const FED_SHIFT: u32 = 16;

    /// The number of steps for which the particle stays fed.
    #[must_use]
    pub fn fed(&self) -> u32 {
        self.flags >> Self::FED_SHIFT
    }

    /// The number of steps for which the particle has been hungry, if particles die of hunger.
    #[must_use]
    pub fn hungry(&self) -> u32 {
        self.flags >> Self::HUNGRY_SHIFT & Self::MOST_HUNGRY
    }

    /// Was the particle refused a cell in the last step?
    #[must_use]
    pub fn has_stayed(&self) -> bool {
        self.flags & Self::STAYED != 0
    }

    /// Is the particle dead?
    #[must_use]
    pub fn is_dead(&self) -> bool {
        self.flags & Self::DEAD != 0
    }

    /// Did the particle leave a deposit in the last step? All do that are alive and were not refused a cell.
    #[must_use]
    pub fn has_deposited(&self) -> bool {
        self.flags & (Self::DEAD | Self::STAYED) == 0
    }

    /// Is the particle selected to leave its object?
    #[must_use]
    pub fn is_selected(&self) -> bool {
        self.flags & Self::SELECTED != 0
    }
}

/// A population that grows and shrinks.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Population {
    /// Particles that are alive.
    pub living: u32,
    /// Particles that were born so far. This counter and the next two stop at the largest number.
    pub births: u32,
    /// Particles that died so far.
    pub deaths: u32,
    /// How many times so far a particle did not divide because as many were alive as there may be.
    pub refused: u32,
    /// Particles that were born when it last was time for births and deaths.
    pub born: u32,
    /// Particles that died then.
    pub died: u32,
}

/// The meals left of a food, and its scent.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Meal {
    /// Meals that are left; always 1 for endless food.
    pub remaining: u32,
    /// Meals that were taken in this step.
    pub eaten: u32,
    /// Meals at first; 0 for endless food.
    pub amount: u32,
    /// Level of its scent, in steps of [`LEVELS`](super::food::LEVELS).
    pub level: u32,
    /// Trail units that sensors read at its place while it is uneaten.
    pub strength: f32,
    /// Trail units that sensors read at its place now.
    pub scent: f32,
    /// Trail units that each of its texels adds to the trail in a step while it is uneaten.
    pub projection: f32,
    /// Unused.
    pub pad0: u32,
}

/// Place and size of a food or a marker in pictures.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Mark {
    /// Position in the space of its object, scaled.
    pub position: Vec3,
    /// The object whose pose moves it.
    pub object: u32,
    /// Normal of its triangle, in the space of its object.
    pub normal: Vec3,
    /// Radius while it is uneaten, a world length.
    pub radius: f32,
    /// 1 for food, 0 for a marker.
    pub is_food: u32,
    /// Unused.
    pub pad0: u32,
    /// Unused.
    pub pad1: u32,
    /// Unused.
    pub pad2: u32,
}

/// Changes of a window after transfers.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Border {
    /// Particles that left the object for another one in the present step.
    pub left: u32,
    /// Particles that came from other objects in the present step.
    pub came: u32,
    /// Slots that the window gains in front of those that it keeps.
    pub front: u32,
    /// Slots that it gains, in front and behind.
    pub gained: u32,
    /// Slots that the windows before it gain.
    pub first: u32,
    /// Index of its first entry in the lists.
    pub list: u32,
    /// Its slots that hold another object's particle.
    pub holes: u32,
    /// The object's particles outside of the window.
    pub strays: u32,
}

/// The slots of the particle buffer that hold one object's particles: `count` of them from `start` on, in a ring.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Window {
    /// The first slot.
    pub start: u32,
    /// The number of slots.
    pub count: u32,
}

impl Window {
    /// The slot of particle `i` of a window that begins at `start`, in a ring of `ring` slots.
    #[must_use]
    pub fn slot(start: u32, i: u32, ring: u32) -> u32 {
        let slot = start + i;
        if slot >= ring { slot - ring } else { slot }
    }

    /// How far a slot lies behind `start` in a ring of `ring` slots: the inverse of [`Window::slot`].
    #[must_use]
    pub fn offset(start: u32, slot: u32, ring: u32) -> u32 {
        if slot >= start {
            slot - start
        } else {
            slot + (ring - start)
        }
    }
}

/// A particle's passage from one object to another.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Transfer {
    /// Position in world space.
    pub position: Vec3,
    /// The particle's slot.
    pub particle: u32,
    /// Heading, a unit vector in world space.
    pub heading: Vec3,
    /// The object that it comes from.
    pub source: u32,
    /// Unit normal of the plane that the heading lies in, world space.
    pub normal: Vec3,
    /// The object that it goes to.
    pub target: u32,
    /// The triangle of the target that it goes to.
    pub triangle: u32,
    /// World length that it could not walk on the target because its attempts ran out; pending once it has landed.
    pub rest: f32,
    /// 2 if it continues from a crossing with the target, otherwise 0; with one particle a cell 1 if it stays on its object, because its
    /// place on the target is taken.
    pub stays: u32,
    /// With one particle a cell: the cell that it lands on.
    pub cell: u32,
}

/// Lengths of a step's lists, and counters since the start.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct Flow {
    /// Particles that are selected in the present step; beyond the lists' capacity they are not listed.
    pub wanted: u32,
    /// If more are selected than the lists hold: the largest key with which a particle leaves.
    pub limit: u32,
    /// Particles that leave their objects in the present step: the entries of the lists.
    pub leaving: u32,
    /// The number of leaving particles among those whose keys have the limit's upper half.
    pub rest: u32,
    /// Entries of the list that is made again if more are selected than it holds.
    pub listed: u32,
    /// Slots that windows gain in the present step.
    pub gained: u32,
    /// Cases, one per object and step, of unequally many slots and particles to exchange; always 0.
    pub mismatches: u32,
    /// Entries of the lists of slots and particles that are exchanged.
    pub entries: u32,
    /// With one particle a cell: how many times so far a particle stayed that would have moved with one more round.
    pub left_over: u32,
    /// The capacity that would have sufficed: the most particles that were selected in a step.
    pub most_wanted: u32,
    /// Number of times that a particle stayed because the lists were full. This counter and those below stop at the largest
    /// number.
    pub refused: u32,
    /// Number of selections so far, refused ones included.
    pub selected: u32,
    /// Particles that have arrived so far.
    pub arrived: u32,
    /// Particles so far that continued from a crossing with the other object; the others went to its nearest point.
    pub crossed: u32,
}

impl Flow {
    /// The counters over all steps, without those of one step.
    #[must_use]
    pub fn between_steps(&self) -> Self {
        Self {
            mismatches: self.mismatches,
            left_over: self.left_over,
            most_wanted: self.most_wanted,
            refused: self.refused,
            selected: self.selected,
            arrived: self.arrived,
            crossed: self.crossed,
            ..Self::default()
        }
    }

    /// An error message if the lists of holes and strays ever had unequal lengths, which is a bug.
    #[must_use]
    pub fn mismatch(&self) -> Option<String> {
        (self.mismatches > 0).then(|| {
            format!(
                "particles to be exchanged were not equally many on both sides, {} times: some may be lost",
                self.mismatches
            )
        })
    }
}

/// A walk under way: a place, a heading and what remains to be walked. `u` is `weight_b`, `v` is `weight_c`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Walker {
    /// Global triangle id.
    pub triangle: u32,
    /// Barycentric weight of corner A.
    pub weight_a: f32,
    /// Barycentric weight of corner B.
    pub weight_b: f32,
    /// Barycentric weight of corner C.
    pub weight_c: f32,
    /// `p` component of the unit heading.
    pub heading_p: f32,
    /// `h` component of the unit heading.
    pub heading_h: f32,
    /// World length still to walk.
    pub remaining: f32,
    /// The corner whose half-edge the walk came in by, `NONE` at the start.
    pub entered_by: u32,
    /// 0 walked to the end, 1 stopped at an open border, 2 out of edge-crossing attempts.
    pub status: u32,
    /// Rounding error of `weight_a`; like the others below, only in walks that carry it along.
    pub carry_a: f32,
    /// Rounding error of `weight_b`.
    pub carry_b: f32,
    /// Rounding error of `weight_c`.
    pub carry_c: f32,
    /// Rounding error of `heading_p`.
    pub carry_p: f32,
    /// Rounding error of `heading_h`.
    pub carry_h: f32,
    /// Rounding error of `remaining`.
    pub carry_remaining: f32,
}

/// A vertex and the object that it belongs to.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Vertex {
    /// Position in object space, multiplied by the object's scale.
    pub position: Vec3,
    /// The object whose pose moves it.
    pub object: u32,
}

/// Takes positions of one object to world space: three rows, each of which gives one coordinate.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Pose {
    /// Row of the world's X: rotation in `xyz`, translation in `w`.
    pub x: Vec4,
    /// Row of the world's Y.
    pub y: Vec4,
    /// Row of the world's Z.
    pub z: Vec4,
}

impl Pose {
    /// The same place and direction for an object that is `factor` times as large about its own origin.
    #[must_use]
    pub fn scaled(self, factor: f32) -> Self {
        let scaled = |row: Vec4| (factor * row.truncate()).extend(row.w);
        let Self { x, y, z } = self;
        Self::of_rows([x, y, z].map(scaled))
    }

    /// A pose from rows, with numbers that some devices would flush to zero set to zero.
    pub(super) fn of_rows(rows: [Vec4; 3]) -> Self {
        let [x, y, z] = rows.map(|row| row.map(settled));
        Self { x, y, z }
    }
}

impl From<Affine3A> for Pose {
    fn from(world_from_object: Affine3A) -> Self {
        let rows = glam::Mat4::from(world_from_object).transpose();
        Self::of_rows([rows.x_axis, rows.y_axis, rows.z_axis])
    }
}

impl From<&Pose> for DAffine3 {
    fn from(pose: &Pose) -> Self {
        let rows = [pose.x, pose.y, pose.z].map(|row| row.as_dvec4());
        let matrix = DMat3::from_cols(rows[0].truncate(), rows[1].truncate(), rows[2].truncate());
        Self::from_mat3_translation(
            matrix.transpose(),
            DVec3::new(rows[0].w, rows[1].w, rows[2].w),
        )
    }
}

/// The shell of a pulse in a step.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Shell {
    /// Its middle in world space.
    pub center: Vec3,
    /// Radius of the middle of the shell, a world length.
    pub radius: f32,
    /// One by half its thickness, in world lengths.
    pub narrow: f32,
    /// How far particles turn, and how much of its speed they take, in the middle of the shell: 0 to 1.
    pub strength: f32,
    /// World length by which its radius grows in a step.
    pub speed: f32,
    /// Nothing.
    pub pad0: f32,
}

/// The surface point under the centre of a texel.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SurfaceSample {
    /// Position in the space of its object, scaled.
    pub position: Vec3,
    /// The texel, which is owned.
    pub texel: u32,
}

/// A ball round some samples that lie side by side.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct SampleTile {
    /// Centre in the space of their object, scaled.
    pub center: Vec3,
    /// At least the distance of any sample from the centre.
    pub radius: f32,
}

/// Another object, relative to the one whose distances are computed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ObjectPair {
    /// The map to the other object's space: the row of its X.
    pub x: Vec4,
    /// The row of its Y.
    pub y: Vec4,
    /// The row of its Z.
    pub z: Vec4,
    /// The other object's first face.
    pub first_face: u32,
    /// Its number of faces.
    pub face_count: u32,
    /// The root of its tree.
    pub first_node: u32,
    /// 1 if it has an inside, 0 if it has an open border.
    pub is_closed: u32,
}

/// A question about one object, in its space, and the answer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TreeQuery {
    /// The place asked about.
    pub place: Vec3,
    /// Answer: the face.
    pub slot: u32,
    /// For crossings: the end of the segment from `place`.
    pub end: Vec3,
    /// Answer: the signed distance, or the share of the segment up to the crossing.
    pub result: f32,
    /// Answer: weight of corner B.
    pub u: f32,
    /// Answer: weight of corner C.
    pub v: f32,
    /// Answer: 1 if the search has ended.
    pub ended: u32,
    /// Unused.
    pub pad0: u32,
}

/// One object whose distances are updated.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct DistanceJob {
    /// The number of its first invocation.
    pub first_thread: u32,
    /// Its first sample.
    pub first_sample: u32,
    /// Its number of samples.
    pub sample_count: u32,
    /// Its first pair.
    pub first_pair: u32,
    /// The number of other objects that may be within reach.
    pub pair_count: u32,
    /// The tile of its first sample.
    pub first_tile: u32,
}

/// A tile whose texels are searched.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
pub struct ListedTile {
    /// The tile's index among those of all jobs.
    pub tile: u32,
    /// Its first sample.
    pub first_sample: u32,
    /// Its number of samples.
    pub sample_count: u32,
    /// Its object's first pair.
    pub first_pair: u32,
    /// The number of other objects that may be within reach of its object.
    pub pair_count: u32,
    /// The number of these for which there is a hint.
    pub hinted: u32,
    /// Unused.
    pub pad0: u32,
    /// Unused.
    pub pad1: u32,
}

/// What a pass of a step does to the trail on an object.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct TrailRates {
    /// The share that is spread.
    pub diffusion: f32,
    /// Trail units a particle.
    pub deposit: f32,
    /// The share that stays.
    pub decay: f32,
    /// Unused.
    pub pad0: f32,
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn a_pose_has_the_rows_of_its_transform() {
        let transform = Affine3A::from_rotation_translation(
            Quat::from_rotation_z(0.5) * Quat::from_rotation_x(1.0),
            Vec3::new(1.0, 2.0, 3.0),
        );
        let pose = Pose::from(transform);
        let point = Vec3::new(-0.3, 0.7, 0.2).extend(1.0);
        let rows = Vec3::new(pose.x.dot(point), pose.y.dot(point), pose.z.dot(point));
        assert!(rows.distance(transform.transform_point3(point.truncate())) < 1e-6);
    }
}
