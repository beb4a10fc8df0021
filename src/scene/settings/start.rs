//! Start places of particles: a scene's settings, and an object's own that override them.

use serde::Serialize;

use super::choices::{Heading, ObjectStart, Start};
use super::{ParticleSettings, Settings};

/// `start` of an `[[object]]`: where the particles of its share of the area begin, and where they head.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OwnStart {
    /// The start place; with `scene` they begin with the scene's start, and the other keys have no effect.
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
