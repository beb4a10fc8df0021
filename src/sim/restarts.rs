//! Where particles restart by the rule of their start: at places where particles of their object began, with the headings that those had.
//! The places are a part of the state: where particles would begin by the present settings may be elsewhere, once an object has been moved.

use glam::{UVec2, UVec4};

use super::setup::Setup;
use crate::mesh::surface::Surface;
use crate::scene::settings::{RestartPlace, Settings};

/// The most places of all objects together, if each has many.
const MOST: u32 = 1 << 16;
/// The most places of an object, if there are many objects.
const MOST_OF_ONE: u32 = 256;

/// The places that particles restart at, object by object. Both lists are empty in a state of a scene that never needs them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Restarts {
    /// Two per place: the triangle and the bits of u and v; the bits of the heading.
    pub places: Vec<UVec4>,
    /// One per object: its first place, and the one behind its last. An object on which no particle began has none.
    pub ranges: Vec<UVec2>,
}

impl Restarts {
    /// Those of a state; the places of its scene if it has none.
    #[must_use]
    pub fn of_state(state: &Self, setup: &Setup, settings: &Settings) -> Self {
        if settings.keeps_restarts() && state.are_kept() {
            return state.clone();
        }
        Self::of(setup, settings)
    }

    /// The part of them that snapshots hold.
    #[must_use]
    pub fn kept(&self) -> Self {
        if self.are_kept() {
            self.clone()
        } else {
            Self::default()
        }
    }

    /// Is there a range for each of several objects?
    fn are_kept(&self) -> bool {
        self.ranges.len() > 1
    }

    /// The places of a scene; a single one of no meaning if none are ever needed.
    #[must_use]
    pub fn of(setup: &Setup, settings: &Settings) -> Self {
        let mut next = 0;
        let mut ranges = Vec::new();
        let counts = counts(setup, settings);
        for &count in &counts {
            ranges.push(UVec2::splat(next));
            next += count;
        }
        let mut places = vec![UVec4::ZERO; 2 * next.max(1) as usize];
        if next > 0 {
            for (particle, motion) in setup.particles.iter().zip(&setup.motions) {
                let object = setup.surface.triangles[particle.triangle as usize].object as usize;
                let range = &mut ranges[object];
                if range.y - range.x == counts[object] {
                    continue;
                }
                let at = 2 * range.y as usize;
                let [u, v] = [particle.u, particle.v].map(f32::to_bits);
                let [p, h] = [motion.heading_p, motion.heading_h].map(f32::to_bits);
                places[at] = UVec4::new(particle.triangle, u, v, 0);
                places[at + 1] = UVec4::new(p, h, 0, 0);
                range.y += 1;
            }
        }
        Self { places, ranges }
    }

    /// Checks that the places are on the surface, object by object, with headings. A state may have none.
    ///
    /// # Errors
    /// Names the first place that is wrong.
    pub(super) fn validate(&self, surface: &Surface) -> Result<(), String> {
        let Self { places, ranges } = self;
        if places.is_empty() && ranges.is_empty() {
            return Ok(());
        }
        let objects = surface.objects.len();
        let most = most_of_each(objects);
        let mut next = 0;
        let mut are_sound = ranges.len() == objects;
        for range in ranges {
            are_sound &= range.x == next && range.y >= next && range.y - next <= most;
            next = range.y;
        }
        if !are_sound || places.len() as u64 != 2 * u64::from(next.max(1)) {
            return Err(format!(
                "its places to restart at are damaged, or those of another number of objects than {objects}"
            ));
        }
        for (object, range) in ranges.iter().enumerate() {
            for place in range.x..range.y {
                let [start, heading] = [0, 1].map(|k| places[2 * place as usize + k]);
                let triangle = surface.triangles.get(start.x as usize);
                let is_own = triangle.is_some_and(|triangle| triangle.object as usize == object);
                let [u, v, p, h] = [start.y, start.z, heading.x, heading.y].map(f32::from_bits);
                let is_inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
                let is_unit = ((p * p + h * h).sqrt() - 1.0).abs() < 1e-5;
                if !(is_own && is_inside && is_unit) {
                    return Err(format!(
                        "place {place} to restart at is not on object {object}, or its heading has not length 1"
                    ));
                }
            }
        }
        Ok(())
    }

    /// The lengths of both lists, for a simulation that begins.
    #[must_use]
    pub fn lengths(setup: &Setup, settings: &Settings) -> (u64, u64) {
        let counts = counts(setup, settings);
        let places: u32 = counts.iter().sum();
        (2 * u64::from(places.max(1)), counts.len() as u64)
    }
}

impl Settings {
    /// Do particles that go into another object restart by the rule of their start?
    #[must_use]
    pub fn restarts_by_rule(&self) -> bool {
        self.strategy().respawns() && self.keeps_restarts()
    }

    /// May they do so now or later? The strategy may change while a simulation runs, and the rule may not.
    #[must_use]
    pub fn keeps_restarts(&self) -> bool {
        self.objects.len() > 1 && self.transfer.respawn == RestartPlace::Start
    }
}

/// The most places of each of so many objects.
fn most_of_each(objects: usize) -> u32 {
    (MOST / objects as u32).max(MOST_OF_ONE)
}

/// The number of places on each object; a single 0 if none are ever needed.
fn counts(setup: &Setup, settings: &Settings) -> Vec<u32> {
    if !settings.keeps_restarts() {
        return vec![0];
    }
    let objects = setup.surface.objects.len();
    let most = most_of_each(objects);
    let mut counts = vec![0; objects];
    for particle in &setup.particles {
        let object = setup.surface.triangles[particle.triangle as usize].object as usize;
        counts[object] = most.min(counts[object] + 1);
    }
    counts
}
