//! Motion of objects: its settings, and the pose of an object at a time.
//!
//! Everything is computed from the time itself, in double precision, and nothing is accumulated from step to step: after an hour a gear is
//! exactly where a scene that starts there has it. An object's pose is rigid, and composed as
//!
//! `orbit * position * keyframe * rotation * (swing * spin about the pivot)`, the last of them first,
//!
//! where `position` has what `slide` adds, and a keyframe turns and moves the object from where it stands. A model's own
//! animation, where it is used, takes the keyframe's place.

use glam::{Affine3A, DAffine3, DQuat, DVec3, Vec3};
use serde::Serialize;
use std::f64::consts::TAU;

use super::settings::{Easing, ModelAnimation, ObjectSettings, Repeat};
use crate::mesh::RigidTrack;
use crate::portable::{log10, power_of_ten, sin, turn_about, turn_about_axes, turn_between};

/// `motion` of an `[[object]]`. The default stands still.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionSettings {
    /// Degrees a second about each of the object's own axes; together they are one turn about one axis.
    pub spin: [f32; 3],
    /// Degrees a second about axes through `orbit_center`, along the world's.
    pub orbit: [f32; 3],
    /// World units.
    pub orbit_center: [f64; 3],
    /// Degrees to either side, about the object's own axes.
    pub swing: [f32; 3],
    /// Seconds there and back.
    pub swing_period: f32,
    /// Turns of the swing's cycle that it is ahead: 0.25 begins at the end of the swing.
    pub swing_phase: f32,
    /// World units to either side.
    pub slide: [f32; 3],
    /// Seconds there and back.
    pub slide_period: f32,
    /// Turns of the slide's cycle that it is ahead.
    pub slide_phase: f32,
    /// The centre of spin and swing, from the object's origin, along its own axes, in world units.
    pub pivot: [f64; 3],
    /// Does the object follow the animation in its model?
    pub model: ModelAnimation,
    /// Behaviour after the last keyframe.
    pub repeat: Repeat,
    /// How it goes from keyframe to keyframe.
    pub easing: Easing,
    /// Seconds after which keyframes begin again; the last keyframe's time where that is later.
    pub period: f32,
    /// Poses at some times, relative to the object's pose at rest; their times ascend.
    pub keyframes: Vec<Keyframe>,
}

impl Default for MotionSettings {
    fn default() -> Self {
        Self {
            spin: [0.0; 3],
            orbit: [0.0; 3],
            orbit_center: [0.0; 3],
            swing: [0.0; 3],
            swing_period: 4.0,
            swing_phase: 0.0,
            slide: [0.0; 3],
            slide_period: 4.0,
            slide_phase: 0.0,
            pivot: [0.0; 3],
            model: ModelAnimation::Still,
            repeat: Repeat::Loop,
            easing: Easing::Linear,
            period: 0.0,
            keyframes: Vec::new(),
        }
    }
}

impl MotionSettings {
    /// Is the object at rest at all times?
    #[must_use]
    pub fn is_still(&self) -> bool {
        let zero = |vector: &[f32; 3]| *vector == [0.0; 3];
        [&self.spin, &self.orbit, &self.swing, &self.slide]
            .into_iter()
            .all(zero)
            && self.model == ModelAnimation::Still
            && self.keyframes.is_empty()
    }

    /// Is it the default? Then files leave it out.
    #[must_use]
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The pose of an object at one time, relative to its pose at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Keyframe {
    /// Seconds from the beginning; not negative.
    pub time: f32,
    /// World units.
    pub position: [f32; 3],
    /// Degrees about the world's X axis, then Y, then Z.
    pub rotation: [f32; 3],
}

/// Origins of an object's coordinates and of the world's, chosen so that single precision is enough for both, wherever they are. Both are
/// zero unless something small is far from its origin.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Origins {
    /// The origin of computations in world space, in world coordinates.
    pub world: DVec3,
    /// The origin of the object's surface, in its scaled coordinates.
    pub surface: DVec3,
}

impl Origins {
    /// Maps a place in the coordinates of a mesh's file to the scaled surface.
    #[must_use]
    pub fn from_file(&self, place: [f64; 3], scale: f32) -> Vec3 {
        let scale_up = f64::from(scale);
        scale * (DVec3::from_array(place) - self.surface / scale_up).as_vec3()
    }

    /// Maps a place on the scaled surface to the coordinates of the mesh's file.
    #[must_use]
    pub fn to_file(&self, place: DVec3, scale: f32) -> DVec3 {
        (place + self.surface) / f64::from(scale)
    }

    /// A pose from scaled coordinates to world coordinates as one between those that are counted from these origins.
    #[must_use]
    pub fn to_origins(&self, pose: DAffine3) -> DAffine3 {
        let translation = pose.translation - self.world + pose.matrix3 * self.surface;
        DAffine3 {
            translation,
            ..pose
        }
    }

    /// A pose between coordinates that are counted from these origins as one from scaled to world coordinates.
    #[must_use]
    pub fn to_world(&self, pose: DAffine3) -> DAffine3 {
        let translation = pose.translation + self.world - pose.matrix3 * self.surface;
        DAffine3 {
            translation,
            ..pose
        }
    }
}

/// A place rounded to decimals, down to a ten-millionth of the scene's radius: what single precision holds of it.
#[must_use]
pub fn in_decimals(place: DVec3, radius: f32) -> [f64; 3] {
    let digits = (7.0 - log10(radius.into()).floor()).clamp(-30.0, 15.0) as i32;
    let up = power_of_ten(digits.unsigned_abs());
    place.to_array().map(|x| {
        if digits >= 0 {
            (x * up).round() / up
        } else {
            (x / up).round() * up
        }
    })
}

/// The pose of an object at a time in seconds: maps its scaled coordinates to world coordinates. `track` is its model's
/// animation, if it has one and follows it. Position, pivot and centre of the orbit are taken in single precision, as in a
/// scene near the origin; see [`pose_from`].
#[must_use]
pub fn pose_at(object: &ObjectSettings, track: Option<&RigidTrack>, time: f64) -> DAffine3 {
    pose_from(object, track, time, &Origins::default())
}

/// As [`pose_at`], from surface coordinates to world coordinates, both counted from `origins`. Large offsets are subtracted before
/// any rotation, so that they do not cost precision.
#[must_use]
pub fn pose_from(
    object: &ObjectSettings,
    track: Option<&RigidTrack>,
    time: f64,
    origins: &Origins,
) -> DAffine3 {
    let motion = &object.motion;
    // With the object's own origin the surface is near the world's origin, so single precision is enough; a scene that is moved far away
    // then keeps its bits, despite the rounding of its coordinates there.
    let near = |place: DVec3| {
        if origins.surface == DVec3::ZERO {
            place.as_vec3().as_dvec3()
        } else {
            place
        }
    };
    let keyframe = match track {
        Some(track) => {
            let (rotation, translation) = track.at(time);
            let translation = f64::from(object.scale) * translation;
            // A model is animated in its own coordinates, which position and rotation take to the world.
            let stands = DAffine3::from_rotation_translation(euler(object.rotation), DVec3::ZERO);
            stands * DAffine3::from_rotation_translation(rotation, translation)
        }
        None => {
            let (rotation, translation) = between_keyframes(motion, time);
            DAffine3::from_rotation_translation(rotation * euler(object.rotation), translation)
        }
    };
    let keyframe = keyframe * DAffine3::from_translation(origins.surface);
    let slid = wide(motion.slide) * sin(cycle(time, motion.slide_period, motion.slide_phase));
    let position = near(DVec3::from_array(object.position) - origins.world);
    let place = DAffine3::from_translation(position + slid);
    let swung = sin(cycle(time, motion.swing_period, motion.swing_phase));
    let turned = turn(swung * wide(motion.swing)) * turn_for(motion.spin, time);
    let pivot = near(DVec3::from_array(motion.pivot) - origins.surface);
    let own = DAffine3::from_rotation_translation(turned, pivot - turned * pivot);
    let orbit = turn_for(motion.orbit, time);
    let center = near(DVec3::from_array(motion.orbit_center) - origins.world);
    let round = DAffine3::from_rotation_translation(orbit, center - orbit * center);
    round * place * keyframe * own
}

/// A pose in single precision, for devices.
#[must_use]
pub fn single(pose: DAffine3) -> Affine3A {
    Affine3A::from_cols_array(&pose.to_cols_array().map(|value| value as f32))
}

/// A pose in double precision.
#[must_use]
pub fn double(pose: &Affine3A) -> DAffine3 {
    DAffine3::from_cols_array(&pose.to_cols_array().map(f64::from))
}

/// The rotation that scene files mean: about X, then Y, then Z, each about the world's axis.
pub(super) fn euler(degrees: [f32; 3]) -> DQuat {
    turn_about_axes(wide(degrees).map(f64::to_radians))
}

fn wide(vector: [f32; 3]) -> DVec3 {
    DVec3::from_array(vector.map(f64::from))
}

/// The phase in a cycle, in radians; exact for any time, because whole cycles are subtracted first.
fn cycle(time: f64, period: f32, phase: f32) -> f64 {
    ((time / f64::from(period)).fract() + f64::from(phase)) * TAU
}

/// A rotation by a vector of degrees: about its direction, by its length.
fn turn(degrees: DVec3) -> DQuat {
    let angle = degrees.length();
    if angle == 0.0 {
        return DQuat::IDENTITY;
    }
    turn_about(degrees / angle, angle.to_radians())
}

/// The rotation of a turning rate, degrees per second, after a time; whole turns are subtracted first, to keep precision.
fn turn_for(rate: [f32; 3], time: f64) -> DQuat {
    let rate = wide(rate);
    let speed = rate.length();
    if speed == 0.0 {
        return DQuat::IDENTITY;
    }
    let degrees = (speed * time) % 360.0;
    turn_about(rate / speed, degrees.to_radians())
}

/// Between two keyframes the rotation takes the shorter way round, at an even rate.
fn between_keyframes(motion: &MotionSettings, time: f64) -> (DQuat, DVec3) {
    let frames = &motion.keyframes;
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else {
        return (DQuat::IDENTITY, DVec3::ZERO);
    };
    let (begin, end) = (f64::from(first.time), f64::from(last.time));
    let length = end.max(f64::from(motion.period));
    let time = match motion.repeat {
        Repeat::Once => time.clamp(begin, end),
        Repeat::Loop if length > 0.0 => time.rem_euclid(length),
        Repeat::Mirror if end > 0.0 => {
            let there_and_back = time.rem_euclid(2.0 * end);
            there_and_back.min(2.0 * end - there_and_back).max(begin)
        }
        Repeat::Loop | Repeat::Mirror => begin,
    };
    let next = frames.partition_point(|frame| f64::from(frame.time) <= time);
    // Only a loop has a time before the first keyframe or after the last: the way from the last to the first.
    let (from, from_time) = match next {
        0 => (last, end - length),
        next => (&frames[next - 1], f64::from(frames[next - 1].time)),
    };
    let (to, to_time) = match frames.get(next) {
        Some(frame) => (frame, f64::from(frame.time)),
        None if motion.repeat == Repeat::Loop => (first, begin + length),
        None => (last, end),
    };
    let way = to_time - from_time;
    let share = if way > 0.0 {
        (time - from_time) / way
    } else {
        0.0
    };
    let share = match motion.easing {
        Easing::Linear => share,
        Easing::Smooth => share * share * (3.0 - 2.0 * share),
    };
    let rotation = turn_between(euler(from.rotation), euler(to.rotation), share);
    let position = wide(from.position).lerp(wide(to.position), share);
    (rotation, position)
}
