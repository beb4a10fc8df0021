//! How far an object has moved relative to another one, and whether that is more than rounding.
//!
//! Poses in the world are kept in single precision. Therefore the relative pose of objects that move together changes by rounding in every
//! step. The pose for which their distances were last computed is kept until they have moved away from it by more than rounding, so that
//! slow motion adds up and counts in the end.

use std::collections::BTreeMap;

use bytemuck::{Pod, Zeroable};
use glam::{DVec3, DVec4};

use super::types::Pose;
use crate::mesh::trees::Tree;

/// Two objects whose relative pose differs, by rounding only, from the one for which their distances were last computed.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct KeptPair {
    /// Takes places of the object to the other one's space.
    pub other_from_object: Pose,
    /// The object that has the distances.
    pub object: u32,
    /// The other object.
    pub other: u32,
    /// Nothing.
    pub pad0: [u32; 2],
}

/// All such pairs, by object and other object.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct KeptPairs(BTreeMap<(u32, u32), Pose>);

impl KeptPairs {
    pub(super) fn get(&self, object: u32, other: u32) -> Option<&Pose> {
        self.0.get(&(object, other))
    }

    pub(super) fn insert(&mut self, object: u32, other: u32, other_from_object: Pose) {
        self.0.insert((object, other), other_from_object);
    }

    /// As snapshots have them.
    pub(super) fn to_vec(&self) -> Vec<KeptPair> {
        let pairs = self.0.iter();
        pairs
            .map(|(&(object, other), &other_from_object)| KeptPair {
                other_from_object,
                object,
                other,
                pad0: [0; 2],
            })
            .collect()
    }
}

impl From<&[KeptPair]> for KeptPairs {
    fn from(pairs: &[KeptPair]) -> Self {
        let pairs = pairs.iter();
        Self(
            pairs
                .map(|pair| ((pair.object, pair.other), pair.other_from_object))
                .collect(),
        )
    }
}

/// Upper bound on the movement of an object's places between two relative poses, with a margin for rounding.
pub(super) fn most_moved(own: &Tree, before: &Pose, now: &Pose) -> f32 {
    let corners = corners(own).map(|corner| {
        let (way, place) = moved(corner, before, now);
        way.length() * 1.0001 + 1e-6 * place.abs().max_element()
    });
    corners.fold(0.0, f64::max) as f32
}

/// May the whole difference between two relative poses be rounding? `far` is the sum of the distances of both objects' world poses from the
/// origin.
///
/// Single precision keeps an entry of a rotation to `2^-25`, so places at a distance `r` from the origin move by
/// `1.5 r * 2^-24` at the most, and a place in the world to `2^-24` of its distance from the origin. A place of the object
/// is at most `r` from its origin and `d` from the other's. Rounding affects the pose of the object (`1.5 r`), that of the other one (`1.5
/// d`), both positions (`far`), and the relative pose that is computed from them (`1.5 r`, and up to `r + d` for its translation): `(4 r +
/// 2.5 d + far) * 2^-24`, and as much in the pose before.
pub(super) fn is_within_rounding(own: &Tree, before: &Pose, now: &Pose, far: f64) -> bool {
    let (mut way, mut r, mut d) = (0.0_f64, 0.0_f64, 0.0_f64);
    for corner in corners(own) {
        let (moved, place) = moved(corner, before, now);
        way = way.max(moved.length());
        r = r.max(corner.length());
        d = d.max(place.length());
    }
    way <= (4.0 * r + 2.5 * d + far) * f64::from(f32::EPSILON)
}

/// Corners of the box round an object, in its own space: they move farthest.
fn corners(own: &Tree) -> impl Iterator<Item = DVec3> {
    let (low, high) = (own.low, own.high);
    (0..8_u32).map(move |k| {
        let of =
            |bit: u32, low: f32, high: f32| f64::from(if k >> bit & 1 == 0 { low } else { high });
        DVec3::new(
            of(0, low.x, high.x),
            of(1, low.y, high.y),
            of(2, low.z, high.z),
        )
    })
}

/// The displacement of a place from one pose to another, and its new position.
fn moved(place: DVec3, before: &Pose, now: &Pose) -> (DVec3, DVec3) {
    let rows = |pose: &Pose| [pose.x, pose.y, pose.z].map(|row| row.as_dvec4());
    let (before, now) = (rows(before), rows(now));
    let place: DVec4 = place.extend(1.0);
    (
        DVec3::from_array([0, 1, 2].map(|i| (now[i] - before[i]).dot(place))),
        DVec3::from_array([0, 1, 2].map(|i| now[i].dot(place))),
    )
}
