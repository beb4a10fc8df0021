//! Start places of particles: a scene's settings, and an object's own that override them.

use serde::Serialize;

use super::choices::{Heading, ObjectStart, Start};
use super::{ParticleSettings, Settings};

/// `start` of an `[[object]]`: how many particles it has for its area, where they begin, and where they head.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OwnStart {
    /// Particles for its area, relative to the other objects, where objects have shares: if particles begin everywhere, and on objects with
    /// a start of their own.
    pub share: f32,
    /// The start place; with `scene` they begin with the scene's start, and the keys below have no effect.
    pub place: ObjectStart,
    /// As [`ParticleSettings::start_at`], on this object.
    pub at: [f32; 3],
    /// As [`ParticleSettings::start_radius`].
    pub radius: f32,
    /// As [`ParticleSettings::start_mask`].
    pub mask: String,
    /// As [`ParticleSettings::start_heading`].
    pub heading: Heading,
    /// As [`ParticleSettings::start_direction`].
    pub direction: [f32; 3],
}

impl Default for OwnStart {
    fn default() -> Self {
        let scene = ParticleSettings::default();
        Self {
            share: 1.0,
            place: ObjectStart::Scene,
            at: scene.start_at,
            radius: scene.start_radius,
            mask: scene.start_mask,
            heading: scene.start_heading,
            direction: scene.start_direction,
        }
    }
}

impl OwnStart {
    /// Is it the default?
    #[must_use]
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// One start, of the scene or of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct StartSettings<'a> {
    /// What its keys begin with: `particles.start_` or `object.0.start.`.
    pub prefix: String,
    /// The start place.
    pub place: Start,
    /// The only object, by its index; `None` for all.
    pub object: Option<usize>,
    /// The centre, in scene radii from the scene's centre.
    pub at: [f32; 3],
    /// Scene radii.
    pub radius: f32,
    /// A path relative to the scene file.
    pub mask: &'a str,
    /// Their headings.
    pub heading: Heading,
    /// A direction in the world.
    pub direction: [f32; 3],
}

impl Settings {
    /// For each object its particles for its area, relative to the others; none if all are equal, so that starts do not depend on their
    /// value.
    #[must_use]
    pub fn start_shares(&self) -> Vec<f32> {
        let shares = self.objects.iter().map(|object| object.start.share);
        let shares: Vec<f32> = shares.collect();
        if shares.iter().all(|share| *share == shares[0]) {
            return Vec::new();
        }
        shares
    }

    /// Do objects have shares of the particles, by area? They do if particles begin everywhere, or on some object by a rule of its own.
    #[must_use]
    pub fn has_start_shares(&self) -> bool {
        let particles = &self.particles;
        let is_everywhere = particles.start == Start::Uniform && particles.start_object.is_empty();
        let mut objects = self.objects.iter();
        is_everywhere || objects.any(|object| object.start.place.own().is_some())
    }

    /// The scene's start, and each object's own, where it has one. `particles.start_object` must be the name of an
    /// object, or empty.
    #[must_use]
    pub fn starts(&self) -> (StartSettings<'_>, Vec<Option<StartSettings<'_>>>) {
        let particles = &self.particles;
        let named = |object: &&super::ObjectSettings| object.name == particles.start_object;
        let scene = StartSettings {
            prefix: "particles.start_".to_owned(),
            place: particles.start,
            object: self.objects.iter().position(|object| named(&object)),
            at: particles.start_at,
            radius: particles.start_radius,
            mask: &particles.start_mask,
            heading: particles.start_heading,
            direction: particles.start_direction,
        };
        let own = self.objects.iter().enumerate().map(|(i, object)| {
            let start = &object.start;
            Some(StartSettings {
                prefix: format!("object.{i}.start."),
                place: start.place.own()?,
                object: Some(i),
                at: start.at,
                radius: start.radius,
                mask: &start.mask,
                heading: start.heading,
                direction: start.direction,
            })
        });
        (scene, own.collect())
    }
}
