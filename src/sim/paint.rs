//! Brushes: a dab is a ball in world space, and the part of the surface inside it is painted, over seams and on every object, with trail,
//! with a bias that sensors read, or with particles.
//!
//! The host lists the texels of a dab, so that simulation and twin paint the same ones; the kernels `paint` and `teleport`
//! do the rest.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::{DAffine3, DVec2, DVec3, UVec2, Vec2, Vec3};
use rayon::prelude::*;

pub use super::areas::{GREATEST, NO_GO, NO_GO_BELOW};
use super::kernels::{PaintParams, TeleportParams};
use super::setup::Setup;
use super::types::{Particle, Pose};
use crate::error::{Error, Result};
use crate::mesh::surface::NONE;
use crate::portable::direction;
use crate::rng::{Purpose, random, seed_word, unit};
use crate::scene::settings::Settings;
use crate::strict::settled;

/// The number of places per object to which one dab moves particles.
const PLACES: u32 = 4096;
/// The most depths at which one dab paints besides its own.
pub const MOST_DEPTHS: usize = 3;
/// The number of rays that test the view through a ring.
pub const LOOKS: usize = 12;
/// The largest number of texels of a dab: what a storage block of every device holds.
pub(super) const MOST_TEXELS: usize = 1 << 24;

/// The effect of a dab on the surface inside it. It is full in the middle and falls to zero at the edge, by
/// `(1 - (distance / radius)^2)^2`; for effects without degrees, such as [`Brush::NoGo`], it reaches to the edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Brush {
    /// Adds trail.
    Trail {
        /// Trail units in the middle, 0 to [`GREATEST`].
        amount: f32,
    },
    /// Removes trail, attraction and repulsion; no-go areas are removed entirely wherever it has any effect.
    Erase {
        /// The share that is removed in the middle, 0 to 1.
        share: f32,
    },
    /// Adds to the readings of sensors, so that particles come, or subtracts, so that they avoid the place. It stays until it is erased,
    /// and does not spread.
    Attract {
        /// Trail units in the middle, added to those of earlier dabs; negative to repel. At most [`GREATEST`] either way.
        amount: f32,
    },
    /// Makes a no-go area: particles turn round at it. Particles inside may leave, and transfers from other objects may land in it.
    NoGo,
    /// Makes the place more of the scene's second look. It stays until it is erased, and does not spread.
    Look {
        /// Added to the weight in the middle, 0 to 1; the weight is at most 1.
        amount: f32,
    },
    /// Teleports randomly chosen particles to the dab, from all over the objects that it touches. Each stays on its own object, and
    /// no particles are added.
    Particles {
        /// Share of an object's particles that is moved, 0 to 1.
        share: f32,
    },
}

/// One touch of a brush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dab {
    /// The effect of the dab.
    pub brush: Brush,
    /// The middle of the ball, in world space.
    pub center: Vec3,
    /// Its radius, a world length. Lengths in scene files times the radius of the [`Setup`] are world lengths.
    pub radius: f32,
    /// If given, only triangles whose front faces this place, that of the viewer, are painted, so that a dab does not paint through thin
    /// objects. Objects with open borders or glued edges are painted from either side.
    pub eye: Option<Vec3>,
    /// If given, surfaces that the viewer sees through the dab's ring, nearer or farther than the ball reaches, are painted, too.
    pub ring: Option<Ring>,
    /// Keys the choice of particles of [`Brush::Particles`], together with the scene's seed: each dab should have a different number.
    pub number: u32,
}

/// The circle round a dab's middle in the viewer's picture, and the places of surfaces outside the ball that are seen through it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ring {
    /// Position of the viewer in world space.
    pub eye: Vec3,
    /// Normal of the circle's plane; the radius is the dab's.
    pub normal: Vec3,
    /// Balls that contain these surfaces. There the dab has the strength of the place where the line from the eye meets the plane, and also
    /// falls to zero at the ball's edge.
    pub balls: [Option<Ball>; MOST_DEPTHS],
}

impl Ring {
    /// The points where the rays pass through its plane, from its middle, in radii along [`Ring::axes`]: on two circles, the points of one
    /// between those of the other.
    #[must_use]
    pub fn looks() -> [Vec2; LOOKS] {
        std::array::from_fn(|k| {
            let (circle, place) = (k % 2, k / 2);
            let turn = (place as f32 + 0.5 * circle as f32) / (LOOKS / 2) as f32;
            [0.5, 0.9][circle] * direction(f64::from(turn) * TAU).as_vec2()
        })
    }

    /// Two directions in its plane.
    #[must_use]
    pub fn axes(&self) -> [Vec3; 2] {
        let side = self.normal.any_orthonormal_vector();
        [side, self.normal.cross(side)]
    }
}

/// A ball in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its middle.
    pub center: Vec3,
    /// A world length.
    pub radius: f32,
    /// The rays of [`Ring::looks`] that see a surface in it, one bit each: the surface is painted where one of these rays is the nearest,
    /// and not where another surface hides it.
    pub looks: u32,
}

/// The result of a dab.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Painted {
    /// Texels painted on each object.
    pub texels: Vec<u32>,
    /// From the first of them in the atlas to one past the last.
    pub span: Range<u32>,
}

/// A texel of a dab, and the strength of the dab there, 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DabTexel {
    /// Which one.
    pub texel: u32,
    /// The object that it belongs to.
    pub object: u32,
    /// At its centre.
    pub weight: f32,
}

/// What brushes paint that stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PaintedField {
    /// Trail units that sensors read more.
    Bias,
    /// Weights of the second look.
    Looks,
}

/// A texel of painted areas that has changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repainted {
    /// What was painted.
    pub field: PaintedField,
    /// Which one.
    pub texel: u32,
    /// Its value before.
    pub before: f32,
    /// Its value now.
    pub after: f32,
}

/// Destinations of teleported particles.
#[derive(Clone, Debug, Default)]
pub struct Places {
    /// Object by object; ids are not used.
    pub places: Vec<Particle>,
    /// One per object: its first place, and its number of places.
    pub ranges: Vec<UVec2>,
}

impl Brush {
    /// Does it change areas, if it touches anything? The eraser does if there are any areas.
    #[must_use]
    pub fn changes_areas(self, has_areas: bool) -> bool {
        match self {
            Self::Attract { .. } | Self::NoGo | Self::Look { .. } => true,
            Self::Erase { .. } => has_areas,
            Self::Trail { .. } | Self::Particles { .. } => false,
        }
    }
}

impl Dab {
    /// Makes sure that the numbers are in their ranges.
    ///
    /// # Errors
    /// Names the first that is not, and its range.
    pub fn check(&self) -> Result<()> {
        let within = |what: &str, value: f32, low: f32, high: f32| {
            if (low..=high).contains(&value) {
                return Ok(());
            }
            Err(Error::Invalid(format!(
                "a brush cannot have {what} = {value}: choose {low} to {high}"
            )))
        };
        if !self.center.is_finite() || self.eye.is_some_and(|eye| !eye.is_finite()) {
            return Err(Error::Invalid(
                "a brush must be at a finite place, and looked at from one".to_owned(),
            ));
        }
        within("a radius", self.radius, f32::MIN_POSITIVE, f32::MAX)?;
        if let Some(ring) = &self.ring {
            let balls = || ring.balls.iter().flatten();
            let mut places = [ring.eye, ring.normal].into_iter();
            if !places.all(Vec3::is_finite) || !balls().all(|ball| ball.center.is_finite()) {
                return Err(Error::Invalid(
                    "a brush must be seen through a ring at finite places".to_owned(),
                ));
            }
            for ball in balls() {
                within("a radius", ball.radius, f32::MIN_POSITIVE, f32::MAX)?;
            }
        }
        match self.brush {
            Brush::Trail { amount } => within("an amount of trail", amount, 0.0, GREATEST),
            Brush::Attract { amount } => within("an attraction", amount, -GREATEST, GREATEST),
            Brush::Erase { share } => within("a share", share, 0.0, 1.0),
            Brush::Particles { share } => within("a share of particles", share, 0.0, 1.0),
            Brush::Look { amount } => within("an amount of a look", amount, 0.0, 1.0),
            Brush::NoGo => Ok(()),
        }
    }

    /// The owned texels whose centres lie in the ball, or in one of the ring's balls and seen through the ring, each once and ordered by
    /// triangle and texel.
    ///
    /// # Errors
    /// When a number is out of range, or the ball has more texels than one dab may.
    pub fn texels(&self, setup: &Setup, poses: &[Pose]) -> Result<Vec<DabTexel>> {
        self.texels_on_scaled(setup, poses, &[])
    }

    /// As [`texels`](Self::texels), where each object is shown `scales` times as large about its own origin: one factor an object,
    /// greater than 0; 1 for those beyond the end.
    ///
    /// # Errors
    /// As [`texels`](Self::texels), and when a factor is out of its range.
    pub fn texels_on_scaled(
        &self,
        setup: &Setup,
        poses: &[Pose],
        scales: &[f32],
    ) -> Result<Vec<DabTexel>> {
        self.check()?;
        if let Some(scale) = scales
            .iter()
            .find(|scale| !scale.is_normal() || **scale < 0.0)
        {
            return Err(Error::Invalid(format!(
                "an object cannot be painted {scale} times as large: choose a factor greater than 0"
            )));
        }
        let scales = scales.iter().copied().chain(std::iter::repeat(1.0));
        let objects: Vec<InObject> = (0u32..)
            .zip(poses.iter().zip(scales))
            .map(|(object, (pose, scale))| InObject::new(self, setup, object, pose, scale))
            .collect();
        let triangles = (0..setup.surface.triangles.len() as u32).into_par_iter();
        let texels: Vec<DabTexel> = triangles
            .flat_map_iter(|triangle| {
                let object = setup.surface.triangles[triangle as usize].object;
                objects[object as usize].texels_of(setup, triangle)
            })
            .collect();
        if texels.len() > MOST_TEXELS {
            return Err(Error::Invalid(format!(
                "the brush has {} texels, and one dab may have {MOST_TEXELS}: use a smaller radius",
                texels.len()
            )));
        }
        Ok(texels)
    }

    /// Destinations of particles, drawn by area from the dab's texels.
    #[must_use]
    pub fn places(&self, setup: &Setup, texels: &[DabTexel], seed: u64) -> Places {
        let mut places = Places::default();
        for object in 0..setup.poses.len() as u32 {
            let own: Vec<u32> = (texels.iter().filter(|texel| texel.object == object))
                .map(|texel| texel.texel)
                .collect();
            let mut area = 0.0;
            let ends: Vec<f64> = own
                .iter()
                .map(|texel| {
                    area += 1.0 / f64::from(setup.atlas.density[*texel as usize]);
                    area
                })
                .collect();
            let first = places.places.len() as u32;
            let count = if own.is_empty() { 0 } else { PLACES };
            places.places.extend((0..count).map(|k| {
                let words = random(seed_word(seed), first + k, self.number, Purpose::Paint);
                let [at, x, y] = [0, 1, 2].map(|i| f64::from(unit(words[i])));
                let chosen = ends.partition_point(|end| *end <= at * area);
                let texel = own[chosen.min(own.len() - 1)];
                let point = setup.atlas.surface_point_in(texel, DVec2::new(x, y));
                let (triangle, u, v) = point.expect("texels of dabs are owned");
                // Rounding may put it beyond the edge.
                let v = if u + v > 1.0 { 1.0 - u } else { v };
                Particle {
                    triangle,
                    u: settled(u),
                    v: settled(v),
                    id: NONE,
                }
            }));
            places.ranges.push(UVec2::new(first, count));
        }
        places
    }

    /// Parameters of `paint` for the trail, if the brush changes it.
    #[must_use]
    pub fn of_trail(&self, texel_count: u32) -> Option<PaintParams> {
        let params = PaintParams {
            texel_count,
            fade: 0.0,
            amount: 0.0,
            lowest: 0.0,
            highest: GREATEST,
            no_go: f32::MIN,
        };
        match self.brush {
            Brush::Trail { amount } => Some(PaintParams { amount, ..params }),
            Brush::Erase { share } => Some(PaintParams {
                fade: share,
                ..params
            }),
            _ => None,
        }
    }

    /// Parameters of `paint` for the bias, if the brush changes it.
    #[must_use]
    pub fn of_bias(&self, texel_count: u32) -> Option<PaintParams> {
        let params = PaintParams {
            texel_count,
            fade: 0.0,
            amount: 0.0,
            lowest: -GREATEST,
            highest: GREATEST,
            no_go: NO_GO_BELOW,
        };
        match self.brush {
            // No-go areas stay.
            Brush::Attract { amount } => Some(PaintParams {
                amount,
                lowest: NO_GO,
                ..params
            }),
            Brush::NoGo => Some(PaintParams {
                amount: 2.0 * NO_GO,
                lowest: NO_GO,
                ..params
            }),
            Brush::Erase { share } => Some(PaintParams {
                fade: share,
                lowest: NO_GO,
                ..params
            }),
            Brush::Trail { .. } | Brush::Particles { .. } | Brush::Look { .. } => None,
        }
    }

    /// Parameters of `paint` for the weights of the second look, if the brush changes them.
    #[must_use]
    pub fn of_looks(&self, texel_count: u32) -> Option<PaintParams> {
        let (fade, amount) = match self.brush {
            Brush::Look { amount } => (0.0, amount),
            Brush::Erase { share } => (share, 0.0),
            _ => return None,
        };
        Some(PaintParams {
            texel_count,
            fade,
            amount,
            lowest: 0.0,
            highest: 1.0,
            no_go: f32::MIN,
        })
    }

    /// Parameters of `teleport`, if the brush moves particles.
    #[must_use]
    pub fn of_particles(&self, settings: &Settings) -> Option<TeleportParams> {
        let Brush::Particles { share } = self.brush else {
            return None;
        };
        Some(TeleportParams {
            particle_count: settings.slots(),
            seed: seed_word(settings.seed),
            dab: self.number,
            share,
        })
    }

    /// Does it paint a bias, which sensors read from then on?
    #[must_use]
    pub fn makes_bias(&self) -> bool {
        self.brush.changes_areas(false) && !self.makes_looks()
    }

    /// Does it paint a second look?
    #[must_use]
    pub fn makes_looks(&self) -> bool {
        matches!(self.brush, Brush::Look { .. })
    }
}

impl Painted {
    /// Counts texels by object.
    #[must_use]
    pub fn of(texels: &[DabTexel], objects: usize) -> Self {
        let mut counts = vec![0; objects];
        for texel in texels {
            counts[texel.object as usize] += 1;
        }
        let all = || texels.iter().map(|texel| texel.texel);
        Self {
            texels: counts,
            span: all().min().unwrap_or(0)..all().max().map_or(0, |last| last + 1),
        }
    }

    /// Texels on all objects.
    #[must_use]
    pub fn count(&self) -> u32 {
        self.texels.iter().sum()
    }
}

/// A dab as one object sees it.
struct InObject {
    ball: InBall,
    eye: Option<DVec3>,
    ring: Option<InRing>,
    /// The balls of the ring.
    balls: Vec<(InBall, u32)>,
    /// Is the effect full up to the edge?
    is_hard: bool,
}

#[derive(Clone, Copy)]
struct InBall {
    center: DVec3,
    radius: f64,
}

struct InRing {
    eye: DVec3,
    normal: DVec3,
    axes: [DVec3; 2],
    middle: DVec3,
    radius: f64,
    looks: [DVec2; LOOKS],
}

impl InRing {
    /// The distance from the middle at which a place is seen, as the square of a share of the radius; infinite if none of `looks` is the
    /// nearest there.
    fn share(&self, place: DVec3, looks: u32) -> f64 {
        let way = place - self.eye;
        let along = self.normal.dot(self.middle - self.eye) / self.normal.dot(way);
        let from_middle = (self.eye + along * way - self.middle) / self.radius;
        let seen = DVec2::from_array(self.axes.map(|axis| axis.dot(from_middle)));
        // At the middle itself, the dab's own ball is seen.
        let mut nearest = (seen.length_squared(), false);
        for (k, look) in self.looks.iter().enumerate() {
            let apart = seen.distance_squared(*look);
            if apart < nearest.0 {
                nearest = (apart, looks >> k & 1 == 1);
            }
        }
        if along > 0.0 && nearest.1 {
            seen.length_squared()
        } else {
            f64::INFINITY
        }
    }
}

impl InObject {
    fn new(dab: &Dab, setup: &Setup, object: u32, pose: &Pose, scale: f32) -> Self {
        let object_from_world = DAffine3::from(pose).inverse();
        let scale = f64::from(scale);
        let to_object = |place: Vec3| object_from_world.transform_point3(place.as_dvec3()) / scale;
        let ball = |center, radius| InBall {
            center: to_object(center),
            radius: f64::from(radius) / scale,
        };
        let balls = dab.ring.iter().flat_map(|ring| ring.balls).flatten();
        Self {
            ball: ball(dab.center, dab.radius),
            eye: (dab.eye.map(to_object)).filter(|_| setup.surface.is_closed(object as usize)),
            ring: dab.ring.map(|ring| {
                let turned = |way: Vec3| object_from_world.transform_vector3(way.as_dvec3());
                InRing {
                    eye: to_object(ring.eye),
                    normal: turned(ring.normal),
                    axes: ring.axes().map(turned),
                    middle: to_object(dab.center),
                    radius: f64::from(dab.radius) / scale,
                    looks: Ring::looks().map(Vec2::as_dvec2),
                }
            }),
            balls: balls
                .map(|own| (ball(own.center, own.radius), own.looks))
                .collect(),
            is_hard: dab.brush == Brush::NoGo,
        }
    }

    /// The texels that a triangle owns and the dab touches.
    fn texels_of(&self, setup: &Setup, triangle: u32) -> Vec<DabTexel> {
        let mut texels = self.texels_in(setup, triangle, self.ball, None);
        for &(ball, looks) in &self.balls {
            let ring = self.ring.as_ref().map(|ring| (ring, looks));
            texels.extend(self.texels_in(setup, triangle, ball, ring));
        }
        if !self.balls.is_empty() {
            // If balls overlap, the dab has the strength of one of them.
            texels.sort_by_key(|texel| texel.texel);
            texels.dedup_by(|next, kept| {
                let is_same = next.texel == kept.texel;
                if is_same {
                    kept.weight = kept.weight.max(next.weight);
                }
                is_same
            });
        }
        texels
    }

    /// The texels of a triangle in one ball which, if there is a ring, one of its rays has reached.
    fn texels_in(
        &self,
        setup: &Setup,
        triangle: u32,
        ball: InBall,
        ring: Option<(&InRing, u32)>,
    ) -> Vec<DabTexel> {
        let surface = &setup.surface;
        let corners = surface.corners[triangle as usize];
        let [a, b, c] = corners.map(|vertex| surface.positions[vertex as usize].as_dvec3());
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let outside = ball.center - ball.center.clamp(low, high);
        if outside.length_squared() > ball.radius * ball.radius {
            return Vec::new();
        }
        let (ab, ac) = (b - a, c - a);
        let normal = ab.cross(ac).normalize_or_zero();
        if self.eye.is_some_and(|eye| normal.dot(eye - a) < 0.0) {
            return Vec::new();
        }
        let height = normal.dot(ball.center - a);
        let reach = ball.radius * ball.radius - height * height;
        if reach < 0.0 {
            return Vec::new();
        }
        // The disc that the ball cuts out of the plane, in the atlas: a box round its ellipse.
        let atlas = &setup.atlas;
        let map = &atlas.maps[triangle as usize];
        let shape = &surface.triangles[triangle as usize];
        let (du, dv) = (map.du.as_dvec2(), map.dv.as_dvec2());
        let along = ab.normalize_or_zero();
        let across = normal.cross(along);
        let p = du / f64::from(shape.ab);
        let h = (dv - f64::from(shape.cp) * p) / f64::from(shape.ch);
        let from_a = ball.center - a;
        let origin = map.origin.as_dvec2();
        let middle = origin + from_a.dot(along) * p + from_a.dot(across) * h;
        let extent = reach.sqrt() * (p * p + h * h).map(f64::sqrt);
        let (u_end, v_end) = (origin + du, origin + dv);
        let mut low = origin.min(u_end).min(v_end) - 1.0;
        let mut high = origin.max(u_end).max(v_end) + 1.0;
        if extent.is_finite() && middle.is_finite() {
            low = low.max(middle - extent - 1.0);
            high = high.min(middle + extent + 1.0);
        }
        let last = f64::from(atlas.size - 1);
        let [low, high] =
            [low, high].map(|at| at.clamp(DVec2::ZERO, DVec2::splat(last)).as_uvec2());
        let mut texels = Vec::new();
        for row in low.y..=high.y {
            for column in low.x..=high.x {
                let texel = row * atlas.pitch + column;
                if atlas.owner[texel as usize] != triangle {
                    continue;
                }
                let point = atlas.surface_point_of(texel);
                let (_, u, v) = point.expect("a triangle owns it");
                let place = a + f64::from(u) * ab + f64::from(v) * ac;
                let share = place.distance_squared(ball.center) / (ball.radius * ball.radius);
                let share = ring.map_or(share, |(ring, looks)| share.max(ring.share(place, looks)));
                if share < 1.0 {
                    let weight = if self.is_hard {
                        1.0
                    } else {
                        (1.0 - share) * (1.0 - share)
                    };
                    texels.push(DabTexel {
                        texel,
                        object: shape.object,
                        weight: weight as f32,
                    });
                }
            }
        }
        texels
    }
}

#[cfg(test)]
mod tests;
