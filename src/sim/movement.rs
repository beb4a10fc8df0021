//! The pose of every object, step by step: by the scene's motion, or set from outside.
//!
//! The host computes poses in double precision and sends them along with the step's own commands, so a queued step keeps the poses that it
//! was recorded with, and neither host nor device waits for the other.

use glam::{Affine3A, DAffine3, DMat3, DQuat};

use super::types::Pose;
use crate::error::{Error, Result};
use crate::mesh::RigidTrack;
use crate::scene::motion::{Origins, pose_from, single};
use crate::scene::settings::{ObjectSettings, Settings};

/// Numbers of steps are exact in double precision up to here.
pub(super) const MOST_STEPS: u64 = 1 << 53;

/// The largest time in a checkpoint, seconds: at a thousand steps a second it is beyond the last step.
const MOST_SECONDS: f64 = 1e14;

/// The largest world coordinate of objects: the squares of greater ones exceed single precision, and distances become infinite.
pub(super) const FARTHEST: f64 = 1e15;

/// How far the rows of a pose from outside may be from orthonormal.
const RIGID_WITHIN: f64 = 1e-3;

/// The objects' time, and the poses that were set from outside. It is part of the state: a checkpoint keeps it.
#[derive(Clone, Debug, PartialEq)]
pub struct Movement {
    /// The step that `time` belongs to.
    step: u64,
    /// Seconds of motion at that step.
    time: f64,
    /// Seconds a step from there on.
    dt: f64,
    /// The poses that replace the scene's, one per object.
    outside: Vec<Option<DAffine3>>,
}

/// The form for checkpoints: numbers as bits, because text would round them.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SavedMovement {
    step: u64,
    time: u64,
    dt: u64,
    outside: Vec<Option<[u64; 12]>>,
}

impl Movement {
    /// The movement at step 0, at the time in the settings.
    #[must_use]
    pub fn new(settings: &Settings) -> Self {
        Self {
            step: 0,
            time: settings.time.start,
            dt: f64::from(settings.time.dt),
            outside: vec![None; settings.objects.len()],
        }
    }

    /// Seconds of motion at a step: the step times the time step, if that has never changed.
    #[must_use]
    pub fn time_at(&self, step: u64) -> f64 {
        let steps = i128::from(step) - i128::from(self.step);
        self.time + steps as f64 * self.dt
    }

    /// Changes the time step from `step` on; the time is continuous.
    pub fn set_dt(&mut self, dt: f32, step: u64) {
        let dt = f64::from(dt);
        if dt != self.dt {
            self.time = self.time_at(step);
            self.step = step;
            self.dt = dt;
        }
    }

    /// Sets the pose of an object from the next step on, in place of the scene's; `None` restores the scene's. A pose takes the object's
    /// scaled coordinates to world coordinates, both as in files.
    ///
    /// # Errors
    /// When there is no such object, or the pose is not rigid: only rotations and translations keep lengths.
    pub fn set_pose(&mut self, object: usize, world_from_object: Option<DAffine3>) -> Result<()> {
        let count = self.outside.len();
        let Some(outside) = self.outside.get_mut(object) else {
            return Err(Error::Invalid(format!(
                "there is no object {object}: the scene has {count}, counted from 0"
            )));
        };
        if let Some(pose) = &world_from_object {
            check_rigid(pose).map_err(|problem| {
                Error::Invalid(format!("the pose of object {object} {problem}"))
            })?;
        }
        // Kernels invert rotations by the transpose.
        *outside = world_from_object.map(|pose| {
            let rotation = DQuat::from_mat3(&pose.matrix3).normalize();
            DAffine3::from_rotation_translation(rotation, pose.translation)
        });
        Ok(())
    }

    /// The pose that was set from outside, if one was.
    #[must_use]
    pub fn set_pose_of(&self, object: usize) -> Option<DAffine3> {
        *self.outside.get(object)?
    }

    /// The pose of every object at a step, counted from its origins.
    #[must_use]
    pub fn world_from_object(
        &self,
        objects: &[ObjectSettings],
        tracks: &[Option<RigidTrack>],
        origins: &[Origins],
        step: u64,
    ) -> Vec<Affine3A> {
        let time = self.time_at(step);
        let objects = objects.iter().zip(tracks).zip(origins).zip(&self.outside);
        objects
            .map(|(((object, track), origins), outside)| {
                single(match outside {
                    Some(pose) => origins.to_origins(*pose),
                    None => pose_from(object, track.as_ref(), time, origins),
                })
            })
            .collect()
    }

    /// The poses in the layout of kernels.
    #[must_use]
    pub fn poses(
        &self,
        objects: &[ObjectSettings],
        tracks: &[Option<RigidTrack>],
        origins: &[Origins],
        step: u64,
    ) -> Vec<Pose> {
        let poses = self.world_from_object(objects, tracks, origins, step);
        poses.into_iter().map(Pose::from).collect()
    }

    /// The form for checkpoints.
    #[must_use]
    pub fn save(&self) -> SavedMovement {
        SavedMovement {
            step: self.step,
            time: self.time.to_bits(),
            dt: self.dt.to_bits(),
            outside: self
                .outside
                .iter()
                .map(|pose| pose.map(|pose| pose.to_cols_array().map(f64::to_bits)))
                .collect(),
        }
    }
}

impl SavedMovement {
    /// The saved movement, to continue from this step; `None` if it is damaged.
    #[must_use]
    pub(super) fn restore(&self, from: u64) -> Option<Movement> {
        let outside = self
            .outside
            .iter()
            .map(|pose| pose.map(|pose| DAffine3::from_cols_array(&pose.map(f64::from_bits))));
        let movement = Movement {
            step: self.step,
            time: f64::from_bits(self.time),
            dt: f64::from_bits(self.dt),
            outside: outside.collect(),
        };
        let poses = movement.outside.iter().flatten();
        // Times are computed from these as step times dt, which must not overflow; settings keep them much smaller.
        let is_sound = movement.step.max(from) <= MOST_STEPS
            && movement.time.abs() <= MOST_SECONDS
            && (0.0..=MOST_SECONDS).contains(&movement.dt)
            && movement.time_at(from).abs() <= MOST_SECONDS
            && poses.into_iter().all(|pose| check_rigid(pose).is_ok());
        is_sound.then_some(movement)
    }

    /// The movement for other objects: each was one of these, or is new and has no pose from outside.
    #[must_use]
    pub(super) fn of_objects(&self, from: &[Option<usize>]) -> Self {
        let outside = from.iter().map(|was| *self.outside.get((*was)?)?);
        Self {
            outside: outside.collect(),
            ..self.clone()
        }
    }

    /// Objects that it was saved for.
    #[must_use]
    pub fn object_count(&self) -> usize {
        self.outside.len()
    }
}

/// Is this a rotation and a translation?
pub(super) fn is_rigid(pose: &Pose) -> bool {
    check_rigid(&DAffine3::from(pose)).is_ok()
}

fn check_rigid(pose: &DAffine3) -> Result<(), &'static str> {
    if !pose.is_finite() {
        return Err("is not finite");
    }
    if pose.translation.abs().max_element() > FARTHEST {
        return Err(
            "is farther away than 1e15, and squares of distances leave single precision there",
        );
    }
    let turn: DMat3 = pose.matrix3;
    if turn.determinant() < 0.0 {
        return Err("mirrors it: mirror the mesh instead");
    }
    let off = turn.transpose() * turn - DMat3::IDENTITY;
    if !off.abs_diff_eq(DMat3::ZERO, RIGID_WITHIN) {
        return Err(
            "is not rigid: only rotations and translations keep the lengths that particles walk",
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    const ZERO: [Origins; 1] = [Origins {
        world: DVec3::ZERO,
        surface: DVec3::ZERO,
    }];

    #[test]
    fn time_goes_on_from_where_it_is_when_the_step_changes() {
        let mut settings = Settings::default();
        settings.time.dt = 0.25;
        let mut movement = Movement::new(&settings);
        assert_eq!(movement.time_at(8), 2.0);
        movement.set_dt(0.5, 8);
        assert_eq!((movement.time_at(8), movement.time_at(10)), (2.0, 3.0));
        // The step before has the time of the new rate; nothing later depends on that.
        movement.set_dt(0.0, 10);
        assert_eq!(movement.time_at(1_000_000), 3.0);
    }

    /// Would catch: numbers of steps that are taken for negative ones, with an overflow on the way to the time.
    #[test]
    fn no_movement_continues_from_a_step_that_is_never_reached() {
        let mut settings = Settings::default();
        settings.time.dt = 0.0;
        let mut movement = Movement::new(&settings);
        movement.step = 7;
        let saved = movement.save();
        assert_eq!(saved.restore(MOST_STEPS), Some(movement.clone()));
        for step in [MOST_STEPS + 1, 1 << 63, u64::MAX] {
            assert_eq!(saved.restore(step), None);
            assert_eq!(movement.time_at(step), 0.0);
        }
        movement.step = u64::MAX;
        assert_eq!(movement.save().restore(3), None);
        assert_eq!(movement.time_at(3), 0.0);
    }

    #[test]
    fn poses_from_outside_stand_until_they_are_taken_back() {
        let mut settings = Settings::default();
        settings.objects[0].motion.spin = [0.0, 90.0, 0.0];
        let mut movement = Movement::new(&settings);
        let scene = movement.poses(&settings.objects, &[None], &ZERO, 60);
        let set = DAffine3::from_rotation_translation(DQuat::from_rotation_x(0.3), DVec3::Y);
        movement.set_pose(0, Some(set)).unwrap();
        for step in [0, 60] {
            let poses = movement.poses(&settings.objects, &[None], &ZERO, step);
            assert_eq!(poses, [Pose::from(single(set))]);
        }
        let saved = movement.save().restore(61).unwrap();
        assert_eq!(
            saved.poses(&settings.objects, &[None], &ZERO, 61),
            movement.poses(&settings.objects, &[None], &ZERO, 61)
        );
        movement.set_pose(0, None).unwrap();
        assert_eq!(movement.poses(&settings.objects, &[None], &ZERO, 60), scene);
    }

    #[test]
    fn poses_that_are_not_rigid_are_refused() {
        let mut movement = Movement::new(&Settings::default());
        let scaled = |x, y, z| DAffine3::from_scale(DVec3::new(x, y, z));
        for (object, pose, words) in [
            (
                1,
                DAffine3::IDENTITY,
                "there is no object 1: the scene has 1",
            ),
            (0, scaled(2.0, 2.0, 2.0), "is not rigid"),
            (0, scaled(1.0, 1.1, 1.0), "is not rigid"),
            (0, scaled(0.0, 0.0, 0.0), "is not rigid"),
            (0, scaled(-1.0, 1.0, 1.0), "mirrors it"),
            (0, scaled(f64::NAN, 1.0, 1.0), "is not finite"),
            (
                0,
                DAffine3::from_translation(DVec3::X * -1e16),
                "is farther away",
            ),
        ] {
            let error = movement
                .set_pose(object, Some(pose))
                .unwrap_err()
                .to_string();
            assert!(error.contains(words), "{error}");
            assert_eq!(movement.set_pose_of(0), None);
        }
    }
}
