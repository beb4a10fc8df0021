//! Start places of particles: everywhere, at a point, on a ring, in a disc or under a mask, with a separate rule for an object that has
//! one; and their headings.
//!
//! Everything is drawn from the particle's id and the seed, so the place where a particle begins does not depend on the number of particles
//! or threads, or on its slot; but with one particle a cell others may be in its way ([`apart`]).

mod apart;
mod mask;
mod rules;
#[cfg(test)]
mod tests;

use std::f64::consts::TAU;
use std::ops::Range;

use bytemuck::Zeroable as _;
use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::types::{Motion, Particle};
use crate::mesh::atlas::{AtlasError, Control};
use crate::mesh::surface::Surface;
use crate::mesh::walk::{BorderRule, Frame, SurfacePoint, walk};
use crate::portable;
use crate::rng::{Purpose, random, unit};
use crate::strict::{settled, within};

pub use apart::apart;
pub use mask::{Mask, MaskTable};
pub use rules::Masks;

/// How far a ring's centre is moved into its triangle, as a share of the way to the centroid: at a vertex exactly,
/// every direction is on an edge.
const INSET: f64 = 1e-6;

/// A walk from a ring's centre ends after so many crossings: in a sliver between open borders it is reflected millions of times.
const MOST_CROSSINGS: u32 = 16_384;

/// If projecting a direction onto the surface shortens it to this share, it counts as upright on the surface.
const UPRIGHT: f64 = 1e-6;

/// Start places of particles.
#[derive(Clone, Debug)]
pub enum StartPlace {
    /// Equally many for equal area.
    Everywhere,
    /// All particles at one point.
    Point(SurfacePoint),
    /// At one distance from a point along the surface.
    Ring {
        /// The point.
        centre: SurfacePoint,
        /// Length of the straight walks from it, world units. Open borders reflect them.
        radius: f64,
    },
    /// At that distance or less. On a plane there are equally many for equal area.
    Disc {
        /// The point.
        centre: SurfacePoint,
        /// Length of the longest of the straight walks from it.
        radius: f64,
    },
    /// With a density proportional to the lightness of a picture.
    Mask(MaskTable),
}

/// Headings of particles. Places and directions are in the space of each object, scaled as the surface is.
#[derive(Clone, Debug)]
pub enum StartHeading {
    /// Inwards from a ring, random for other places.
    Auto,
    /// Everywhere.
    Random,
    /// Along a direction.
    Aligned(Vec<DVec3>),
    /// Away from the place: along the walk that leads to where they begin, if there is one.
    Radial(Vec<DVec3>),
    /// Towards the place.
    Inward(Vec<DVec3>),
}

/// A rule for start places and headings.
#[derive(Clone, Debug)]
pub struct StartRule {
    /// The start places.
    pub place: StartPlace,
    /// The only object; for the place `everywhere`.
    pub object: Option<u32>,
    /// The headings.
    pub heading: StartHeading,
}

/// The start rules of all particles.
#[derive(Clone, Debug)]
pub struct Starts {
    /// The rule for objects without a separate one.
    pub scene: StartRule,
    /// One per object. An object with a separate rule has as many particles as its share of the whole area.
    pub own: Vec<Option<StartRule>>,
    /// One per object: the factor on its area, for shares; none if all are equal.
    pub shares: Vec<f32>,
}

#[cfg(test)]
fn start(
    surface: &Surface,
    starts: &Starts,
    count: u32,
    seed: u32,
) -> (Vec<Particle>, Vec<Motion>) {
    let lots = Lots::new(surface, starts, seed);
    lots.all(count, &Control::default())
        .expect("nothing stops it")
}

/// Draws start places.
pub struct Lots<'a> {
    seed: u32,
    surface: &'a Surface,
    scene: Drawer<'a>,
    own: Vec<Option<Drawer<'a>>>,
    /// By what an object is chosen, if one has a rule of its own.
    whole: Option<AreaTable>,
    /// Does the scene's rule choose objects in the same way?
    stays: bool,
}

impl<'a> Lots<'a> {
    /// Prepares the rules.
    #[must_use]
    pub fn new(surface: &'a Surface, starts: &'a Starts, seed: u32) -> Self {
        let own = starts.own.iter().map(Option::as_ref);
        let own: Vec<Option<Drawer<'_>>> = own
            .map(|rule| rule.map(|rule| Drawer::new(surface, rule, &[])))
            .collect();
        let any_own = own.iter().any(Option::is_some);
        let is_everywhere = matches!(starts.scene.place, StartPlace::Everywhere);
        Self {
            seed,
            surface,
            scene: Drawer::new(surface, &starts.scene, &starts.shares),
            own,
            whole: any_own.then(|| AreaTable::with_shares(surface, None, &starts.shares)),
            stays: is_everywhere && starts.scene.object.is_none(),
        }
    }

    /// Particles 0 to `count` at their initial places, in the order of their ids, and their motions.
    ///
    /// # Errors
    /// [`AtlasError::Cancelled`] when it is to stop.
    ///
    /// # Panics
    /// When the surface has no triangles.
    pub fn all(
        &self,
        count: u32,
        control: &Control<'_>,
    ) -> Result<(Vec<Particle>, Vec<Motion>), AtlasError> {
        let draw = |id| match control.check() {
            Ok(()) => self.draw(id),
            Err(_) => (Particle::zeroed(), Motion::zeroed()),
        };
        let all = (0..count).into_par_iter().map(draw).unzip();
        control.check()?;
        Ok(all)
    }

    /// The start of a particle.
    #[must_use]
    pub fn draw(&self, id: u32) -> (Particle, Motion) {
        let words = self.words(id, 0);
        let Some(whole) = &self.whole else {
            return self.scene.draw(id, words, None);
        };
        let triangle = whole.triangle_at(share(words));
        let object = self.surface.triangles[triangle as usize].object;
        // New random numbers, because those that have chosen the object would favour some places on it.
        match &self.own[object as usize] {
            Some(own) => own.draw(id, self.words(id, 1), None),
            None if self.stays => self.scene.draw(id, words, None),
            None => self.scene.draw(id, self.words(id, 1), None),
        }
    }

    /// Another start of a particle on the object on which it starts, for each attempt from 1 on; none if this one came to another object.
    #[must_use]
    pub fn draw_again(&self, id: u32, object: u32, attempt: u32) -> Option<(Particle, Motion)> {
        let is_second = self.whole.is_some() && !self.stays;
        let words = |is_second| self.words(id, 2 * attempt + u32::from(is_second));
        let (particle, motion) = match &self.own[object as usize] {
            Some(own) => own.draw(id, words(true), Some(object)),
            None => self.scene.draw(id, words(is_second), Some(object)),
        };
        let came_to = self.surface.triangles[particle.triangle as usize].object;
        (came_to == object).then_some((particle, motion))
    }

    fn words(&self, id: u32, number: u32) -> [u32; 4] {
        random(self.seed, id, number, Purpose::Start)
    }
}

/// A rule with the data for drawing by it.
struct Drawer<'a> {
    surface: &'a Surface,
    rule: &'a StartRule,
    areas: AreaTable,
}

impl<'a> Drawer<'a> {
    fn new(surface: &'a Surface, rule: &'a StartRule, shares: &[f32]) -> Self {
        let areas = match rule.place {
            // There is nothing to share on one object.
            StartPlace::Everywhere if rule.object.is_some() => AreaTable::new(surface, rule.object),
            StartPlace::Everywhere => AreaTable::with_shares(surface, None, shares),
            _ => AreaTable::default(),
        };
        Self {
            surface,
            rule,
            areas,
        }
    }

    /// Everywhere on one object, if one is given, by the rule for everywhere.
    fn draw(&self, id: u32, words: [u32; 4], object: Option<u32>) -> (Particle, Motion) {
        let turn = direction(words[3]);
        // Its start place, its random heading, and its heading away from the centre.
        let (particle, by_chance, away) = match &self.rule.place {
            StartPlace::Everywhere => {
                let (u, v) = uniform_in_triangle(words);
                let triangle = match object {
                    None => self.areas.triangle_at(share(words)),
                    Some(object) => {
                        let triangles = triangles_of(self.surface, Some(object));
                        self.areas.triangle_among(triangles, share(words))
                    }
                };
                (Particle { triangle, u, v, id }, turn, None)
            }
            StartPlace::Mask(table) => {
                let (triangle, u, v) = table.place(share(words), uniform_in_triangle(words));
                (Particle { triangle, u, v, id }, turn, None)
            }
            StartPlace::Point(point) => (particle(id, *point), turn, Some(turn)),
            StartPlace::Ring { centre, radius } => {
                let (particle, away) = self.walk(id, *centre, turn, *radius);
                (particle, direction(words[2]), Some(away))
            }
            StartPlace::Disc { centre, radius } => {
                let length = radius * f64::from(unit(words[1])).sqrt();
                let (particle, away) = self.walk(id, *centre, turn, length);
                (particle, direction(words[2]), Some(away))
            }
        };
        let heading = match &self.rule.heading {
            StartHeading::Auto => match (&self.rule.place, away) {
                (StartPlace::Ring { .. }, Some(away)) => -away,
                _ => by_chance,
            },
            StartHeading::Random => by_chance,
            StartHeading::Aligned(directions) => {
                let along = directions[self.object(&particle)];
                self.laid(&particle, along).unwrap_or(by_chance)
            }
            StartHeading::Radial(places) => self.away(&particle, away, places, by_chance),
            StartHeading::Inward(places) => -self.away(&particle, away, places, by_chance),
        };
        (particle, motion(heading))
    }

    fn walk(&self, id: u32, centre: SurfacePoint, turn: DVec2, length: f64) -> (Particle, DVec2) {
        let border = BorderRule::Reflect;
        let most = Some(MOST_CROSSINGS);
        let end = walk(self.surface, inset(centre), turn, length, most, border);
        (particle(id, end.point), end.heading)
    }

    fn object(&self, particle: &Particle) -> usize {
        self.surface.triangles[particle.triangle as usize].object as usize
    }

    /// The heading away from a centre: the one that the walk found, or the straight one in space.
    fn away(
        &self,
        particle: &Particle,
        known: Option<DVec2>,
        places: &[DVec3],
        by_chance: DVec2,
    ) -> DVec2 {
        known.unwrap_or_else(|| {
            let corners = self.surface.corners[particle.triangle as usize];
            let [a, b, c] = corners.map(|i| self.surface.positions[i as usize].as_dvec3());
            let position = a + f64::from(particle.u) * (b - a) + f64::from(particle.v) * (c - a);
            let out = position - places[self.object(particle)];
            self.laid(particle, out).unwrap_or(by_chance)
        })
    }

    /// A direction projected onto the particle's triangle; none if it is upright on it.
    fn laid(&self, particle: &Particle, direction: DVec3) -> Option<DVec2> {
        let frame = Frame::of(self.surface, particle.triangle);
        let laid = DVec2::new(direction.dot(frame.p), direction.dot(frame.h));
        (laid.length() > UPRIGHT * direction.length()).then(|| laid.normalize())
    }
}

fn direction(word: u32) -> DVec2 {
    portable::direction(TAU * f64::from(unit(word)))
}

/// The surface point that is nearest to a place, which is given in the space of each object (scaled, as the surface's
/// positions are); on one object, if one is given.
///
/// # Panics
/// When there are no triangles.
#[must_use]
pub fn nearest_point(
    surface: &Surface,
    place_in_object: &[Vec3],
    object: Option<u32>,
) -> SurfacePoint {
    triangles_of(surface, object)
        .into_par_iter()
        .map(|triangle| {
            let object = surface.triangles[triangle as usize].object;
            let place = place_in_object[object as usize].as_dvec3();
            let corners = surface.corners[triangle as usize];
            let [a, b, c] = corners.map(|i| surface.positions[i as usize].as_dvec3());
            let (u, v) = nearest_in_triangle(place, a, b, c);
            let distance = (a + u * (b - a) + v * (c - a)).distance_squared(place);
            (distance, SurfacePoint { triangle, u, v })
        })
        // The lowest triangle of equally near ones, so that the result does not depend on threads.
        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.triangle.cmp(&b.1.triangle)))
        .map(|(_, point)| point)
        .expect("a surface has triangles")
}

/// The triangles of one object, or of all.
fn triangles_of(surface: &Surface, object: Option<u32>) -> Range<u32> {
    match object {
        Some(object) => {
            let (first, end) = surface.objects[object as usize].triangles;
            first..end
        }
        None => 0..surface.corners.len() as u32,
    }
}

/// A triangle's area, world units squared.
fn area(surface: &Surface, triangle: u32) -> f64 {
    let shape = &surface.triangles[triangle as usize];
    0.5 * f64::from(shape.ab) * f64::from(shape.ch)
}

/// Finds the triangle at a share of the area, with the triangles laid end to end.
#[derive(Clone, Debug, Default)]
pub(super) struct AreaTable {
    first: u32,
    /// Per triangle, from the first: the area of all triangles up to it, itself included.
    up_to: Vec<f64>,
    /// The last triangle with an area, counted from the first.
    last: usize,
}

impl AreaTable {
    pub(super) fn new(surface: &Surface, object: Option<u32>) -> Self {
        Self::with_shares(surface, object, &[])
    }

    /// The table of areas that are multiplied by the shares of their objects, if there are any.
    fn with_shares(surface: &Surface, object: Option<u32>, shares: &[f32]) -> Self {
        let share = |triangle: u32| {
            let object = surface.triangles[triangle as usize].object as usize;
            shares.get(object).map_or(1.0, |share| f64::from(*share))
        };
        let triangles = triangles_of(surface, object);
        let first = triangles.start;
        let mut sum = 0.0;
        let up_to: Vec<f64> = triangles
            .map(|triangle| {
                sum += share(triangle) * area(surface, triangle);
                sum
            })
            .collect();
        let last = up_to.partition_point(|&up_to| up_to < sum);
        Self { first, up_to, last }
    }

    /// For a share in `[0, 1)`.
    pub(super) fn triangle_at(&self, share: f64) -> u32 {
        let area = share * self.up_to[self.last];
        // The product may round up to the whole area.
        let place = self.up_to.partition_point(|&up_to| up_to <= area);
        self.first + place.min(self.last) as u32
    }

    /// For a share in `[0, 1)` of some of the triangles.
    fn triangle_among(&self, triangles: Range<u32>, share: f64) -> u32 {
        let [first, end] = [triangles.start, triangles.end].map(|at| (at - self.first) as usize);
        let before = first.checked_sub(1).map_or(0.0, |at| self.up_to[at]);
        let among = &self.up_to[first..end];
        let whole = among.last().map_or(0.0, |up_to| up_to - before);
        let area = before + share * whole;
        let place = among.partition_point(|&up_to| up_to <= area);
        let last = among.partition_point(|&up_to| up_to < before + whole);
        triangles.start + place.min(last).min(among.len() - 1) as u32
    }
}

/// A number in `[0, 1)` with 53 bits. A scene may have more triangles than 24 bits can share out fairly, so this takes
/// the first word and the low bytes of the others, which [`unit`] leaves.
pub(super) fn share(words: [u32; 4]) -> f64 {
    let low = words[1..]
        .iter()
        .fold(0, |low, word| (low << 8) | u64::from(word & 0xff));
    let bits = (u64::from(words[0]) << 24) | low;
    (bits >> 3) as f64 / (1u64 << 53) as f64
}

/// `u` and `v` are multiples of 2^-24, so folding is exact and `u + v <= 1` holds exactly.
pub(super) fn uniform_in_triangle(words: [u32; 4]) -> (f32, f32) {
    let (u, v) = (unit(words[1]), unit(words[2]));
    if u + v > 1.0 {
        (1.0 - u, 1.0 - v)
    } else {
        (u, v)
    }
}

fn particle(id: u32, point: SurfacePoint) -> Particle {
    let u = within(point.u as f32, 0.0, 1.0);
    Particle {
        triangle: point.triangle,
        u: settled(u),
        v: settled(within(point.v as f32, 0.0, 1.0 - u)),
        id,
    }
}

fn motion(heading: DVec2) -> Motion {
    Motion {
        heading_p: settled(heading.x as f32),
        heading_h: settled(heading.y as f32),
        pending: 0.0,
        flags: 0,
    }
}

fn inset(point: SurfacePoint) -> SurfacePoint {
    let third = 1.0 / 3.0;
    SurfacePoint {
        u: point.u + INSET * (third - point.u),
        v: point.v + INSET * (third - point.v),
        ..point
    }
}

/// Weights of B and C of the point of a triangle that is nearest to a place.
/// Ericson, "Real-Time Collision Detection" (2005), 5.1.5.
fn nearest_in_triangle(place: DVec3, a: DVec3, b: DVec3, c: DVec3) -> (f64, f64) {
    let (ab, ac) = (b - a, c - a);
    let (ap, bp, cp) = (place - a, place - b, place - c);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (0.0, 0.0);
    }
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return (1.0, 0.0);
    }
    let weight_c = d1 * d4 - d3 * d2;
    if weight_c <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (d1 / (d1 - d3), 0.0);
    }
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return (0.0, 1.0);
    }
    let weight_b = d5 * d2 - d1 * d6;
    if weight_b <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (0.0, d2 / (d2 - d6));
    }
    let weight_a = d3 * d6 - d5 * d4;
    if weight_a <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        let along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        return (1.0 - along, along);
    }
    let sum = weight_a + weight_b + weight_c;
    (weight_b / sum, weight_c / sum)
}
