//! Where particles restart by the rule of their start: at places where particles of their object began, with the headings that those had.

use glam::{UVec2, UVec4};

use super::setup::Setup;
use crate::scene::settings::{RestartPlace, Settings};

/// The most places of all objects together, if each has many.
const MOST: u32 = 1 << 16;
/// The most places of an object, if there are many objects.
const MOST_OF_ONE: u32 = 256;

/// The places that particles restart at, object by object.
#[derive(Clone, Debug, PartialEq)]
pub struct Restarts {
    /// Two per place: the triangle and the bits of u and v; the bits of the heading.
    pub places: Vec<UVec4>,
    /// One per object: its first place, and the one behind its last. An object on which no particle began has none.
    pub ranges: Vec<UVec2>,
}

impl Restarts {
    /// The places of a scene; a single one of no meaning if none are needed.
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

    /// The lengths of both lists.
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
        self.strategy().respawns() && self.transfer.respawn == RestartPlace::Start
    }
}

/// The number of places on each object; a single 0 if none are needed.
fn counts(setup: &Setup, settings: &Settings) -> Vec<u32> {
    if !settings.restarts_by_rule() {
        return vec![0];
    }
    let objects = setup.surface.objects.len();
    let most = (MOST / objects as u32).max(MOST_OF_ONE);
    let mut counts = vec![0; objects];
    for particle in &setup.particles {
        let object = setup.surface.triangles[particle.triangle as usize].object as usize;
        counts[object] = most.min(counts[object] + 1);
    }
    counts
}
