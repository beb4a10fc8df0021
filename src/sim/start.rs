//! Where particles begin: everywhere, at a point or on a ring.
//!
//! Everything is drawn from the particle's id and the seed, so a particle begins at the same place whatever the number
//! of particles, of threads, or its slot.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;

use super::types::{Motion, Particle};
use crate::mesh::surface::Surface;
use crate::mesh::walk::{BorderRule, SurfacePoint, walk};
use crate::rng::{Purpose, random, unit};

/// How far a ring's centre is moved into its triangle, as a share of the way to the centroid: at a vertex exactly,
/// every direction is on an edge.
const INSET: f64 = 1e-6;

/// Where particles begin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StartPlace {
    /// On all objects, equally many for equal area, heading everywhere.
    Everywhere,
    /// All at one point, heading everywhere.
    Point(SurfacePoint),
    /// At one distance from a point along the surface, heading back to it.
    Ring {
        /// The point.
        centre: SurfacePoint,
        /// Length of the straight walks from it, world units. Open borders reflect them.
        radius: f64,
    },
}

/// Particles 0 to `count` at their initial places, in the order of their ids, and where they are going.
///
/// # Panics
/// When the surface has no triangles.
#[must_use]
pub fn start(
    surface: &Surface,
    place: StartPlace,
    count: u32,
    seed: u32,
) -> (Vec<Particle>, Vec<Motion>) {
    let areas = match place {
        StartPlace::Everywhere => AreaTable::new(surface),
        _ => AreaTable::default(),
    };
    (0..count)
        .into_par_iter()
        .map(|id| {
            let words = random(seed, id, 0, Purpose::Start);
            let (sin, cos) = (TAU * f64::from(unit(words[3]))).sin_cos();
            let heading = DVec2::new(cos, sin);
            match place {
                StartPlace::Everywhere => {
                    let (u, v) = uniform_in_triangle(words);
                    let triangle = areas.triangle_at(share(words));
                    let particle = Particle { triangle, u, v, id };
                    (particle, motion(heading))
                }
                StartPlace::Point(point) => (particle(id, point), motion(heading)),
                StartPlace::Ring { centre, radius } => {
                    let border = BorderRule::Reflect;
                    let end = walk(surface, inset(centre), heading, radius, None, border);
                    (particle(id, end.point), motion(-end.heading))
                }
            }
        })
        .unzip()
}

/// The surface point that is nearest to a place, which is given in the space of each object (scaled, as the surface's
/// positions are).
///
/// # Panics
/// When the surface has no triangles.
#[must_use]
pub fn nearest_point(surface: &Surface, place_in_object: &[Vec3]) -> SurfacePoint {
    (0..surface.corners.len() as u32)
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
        // The lowest triangle of equally near ones, so that threads do not decide.
        .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.triangle.cmp(&b.1.triangle)))
        .map(|(_, point)| point)
        .expect("a surface has triangles")
}

/// Which triangle holds a share of the surface's area, the triangles laid end to end.
#[derive(Clone, Debug, Default)]
struct AreaTable {
    /// Per triangle: the area of all triangles up to it, itself included.
    up_to: Vec<f64>,
}

impl AreaTable {
    fn new(surface: &Surface) -> Self {
        let mut sum = 0.0;
        let up_to = surface
            .triangles
            .iter()
            .map(|shape| {
                sum += 0.5 * f64::from(shape.ab) * f64::from(shape.ch);
                sum
            })
            .collect();
        Self { up_to }
    }

    /// For a share in `[0, 1)`.
    fn triangle_at(&self, share: f64) -> u32 {
        let last = self.up_to.len() - 1;
        let area = share * self.up_to[last];
        // The product may round up to the whole area.
        self.up_to.partition_point(|&up_to| up_to <= area).min(last) as u32
    }
}

/// A number in `[0, 1)` with 53 bits. A scene may have more triangles than 24 bits can share out fairly, so this takes
/// the first word and the low bytes of the others, which [`unit`] leaves.
fn share(words: [u32; 4]) -> f64 {
    let low = words[1..]
        .iter()
        .fold(0, |low, word| (low << 8) | u64::from(word & 0xff));
    let bits = (u64::from(words[0]) << 24) | low;
    (bits >> 3) as f64 / (1u64 << 53) as f64
}

/// `u` and `v` are multiples of 2^-24, so folding is exact and `u + v <= 1` holds exactly.
fn uniform_in_triangle(words: [u32; 4]) -> (f32, f32) {
    let (u, v) = (unit(words[1]), unit(words[2]));
    if u + v > 1.0 {
        (1.0 - u, 1.0 - v)
    } else {
        (u, v)
    }
}

fn particle(id: u32, point: SurfacePoint) -> Particle {
    let u = (point.u as f32).clamp(0.0, 1.0);
    Particle {
        triangle: point.triangle,
        u,
        v: (point.v as f32).clamp(0.0, 1.0 - u),
        id,
    }
}

fn motion(heading: DVec2) -> Motion {
    Motion {
        heading_p: heading.x as f32,
        heading_h: heading.y as f32,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;

    fn surface(meshes: &[(&str, f32)]) -> Surface {
        let meshes: Vec<(Mesh, f32)> = meshes
            .iter()
            .map(|&(name, scale)| (Mesh::builtin(name).unwrap(), scale))
            .collect();
        let objects: Vec<(&Mesh, f32)> =
            meshes.iter().map(|(mesh, scale)| (mesh, *scale)).collect();
        Surface::build(&objects)
    }

    fn position(surface: &Surface, particle: &Particle) -> Vec3 {
        let corners = surface.corners[particle.triangle as usize];
        let [a, b, c] = corners.map(|i| surface.positions[i as usize]);
        a + particle.u * (b - a) + particle.v * (c - a)
    }

    /// Pearson's statistic, which must lie within four standard deviations of its mean: a fair draw fails once in some
    /// ten thousand seeds, and the seeds here are fixed.
    fn assert_fair(what: &str, observed: &[u32], expected: &[f64]) {
        let statistic: f64 = observed
            .iter()
            .zip(expected)
            .map(|(&o, &e)| (f64::from(o) - e).powi(2) / e)
            .sum();
        let freedom = (observed.len() - 1) as f64;
        let off = (statistic - freedom) / (2.0 * freedom).sqrt();
        assert!(
            off.abs() < 4.0,
            "{what}: chi-square {statistic} for {freedom}, off by {off}"
        );
    }

    #[test]
    fn particles_are_uniform_by_area() {
        // Triangles of a torus differ by their place, those of the second object by a factor of 100 more.
        let surface = surface(&[("torus?major=24&minor=16", 1.0), ("cube", 0.1)]);
        let count = 400_000;
        for seed in [1, 2, 3] {
            let (particles, _) = start(&surface, StartPlace::Everywhere, count, seed);
            let whole: f64 = AreaTable::new(&surface).up_to[surface.corners.len() - 1];
            let expected: Vec<f64> = surface
                .triangles
                .iter()
                .map(|t| 0.5 * f64::from(t.ab * t.ch) / whole * f64::from(count))
                .collect();
            let mut by_triangle = vec![0; expected.len()];
            // The four triangles that the middles of the edges cut a triangle into.
            let mut by_part = [0; 4];
            for (id, p) in particles.iter().enumerate() {
                assert!(p.u >= 0.0 && p.v >= 0.0 && p.u + p.v <= 1.0 && p.id == id as u32);
                by_triangle[p.triangle as usize] += 1;
                let part = [p.u + p.v < 0.5, p.u > 0.5, p.v > 0.5];
                by_part[part.iter().position(|&inside| inside).unwrap_or(3)] += 1;
            }
            assert_fair("triangles", &by_triangle, &expected);
            assert_fair("parts", &by_part, &[f64::from(count) / 4.0; 4]);
        }
    }

    #[test]
    fn headings_are_uniform_wherever_a_particle_begins() {
        let surface = surface(&[("icosphere?subdivisions=1", 1.0)]);
        let count = 200_000;
        let (particles, motions) = start(&surface, StartPlace::Everywhere, count, 4);
        let mut sectors = [0; 64];
        let mut sector_and_part = [0; 32];
        for (p, m) in particles.iter().zip(&motions) {
            assert!((m.heading_p.hypot(m.heading_h) - 1.0).abs() < 2e-7);
            assert_eq!((m.pending, m.flags), (0.0, 0));
            let turn = f64::from(m.heading_h).atan2(f64::from(m.heading_p)) / TAU + 0.5;
            sectors[(64.0 * turn) as usize % 64] += 1;
            let part = [p.u + p.v < 0.5, p.u > 0.5, p.v > 0.5];
            let part = part.iter().position(|&inside| inside).unwrap_or(3);
            sector_and_part[4 * ((8.0 * turn) as usize % 8) + part] += 1;
        }
        assert_fair("sectors", &sectors, &[f64::from(count) / 64.0; 64]);
        assert_fair(
            "sectors by part",
            &sector_and_part,
            &[f64::from(count) / 32.0; 32],
        );
    }

    #[test]
    fn a_seed_and_an_id_decide_alone() {
        let surface = surface(&[("torus?major=24&minor=16", 1.0)]);
        let centre = SurfacePoint {
            triangle: 5,
            u: 0.2,
            v: 0.3,
        };
        let ring = StartPlace::Ring {
            centre,
            radius: 0.7,
        };
        for place in [StartPlace::Everywhere, StartPlace::Point(centre), ring] {
            let with = |threads, count, seed| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                pool.unwrap()
                    .install(|| start(&surface, place, count, seed))
            };
            let (particles, motions) = with(1, 5000, 9);
            let (more_particles, more_motions) = with(3, 7001, 9);
            assert_eq!(particles, more_particles[..5000]);
            assert_eq!(motions, more_motions[..5000]);
            let (_, others) = with(2, 5000, 10);
            let same = motions.iter().zip(&others).filter(|(a, b)| a == b).count();
            assert!(same < 5, "{same} of 5000 are the same with another seed");
        }
        assert_eq!(start(&surface, ring, 0, 9).0.len(), 0);
    }

    #[test]
    fn a_ring_lies_round_its_centre_and_looks_at_it() {
        let surface = surface(&[("plane?columns=9&rows=7", 1.0)]);
        let middle = Vec3::new(0.05, 0.0, -0.1);
        let centre = nearest_point(&surface, &[middle]);
        let (particles, motions) = start(
            &surface,
            StartPlace::Ring {
                centre,
                radius: 0.6,
            },
            3000,
            2,
        );
        let mut sum = Vec3::ZERO;
        for (p, m) in particles.iter().zip(&motions) {
            let out = position(&surface, p) - middle;
            assert!((out.length() - 0.6).abs() < 1e-5, "{}", out.length());
            let frame = crate::mesh::walk::Frame::of(&surface, p.triangle);
            let heading = f64::from(m.heading_p) * frame.p + f64::from(m.heading_h) * frame.h;
            assert!(heading.dot(out.as_dvec3()) < -0.6 + 1e-4);
            sum += out;
        }
        assert!(sum.length() < 0.05 * 3000.0 * 0.6, "lopsided: {sum}");
        let (particles, _) = start(&surface, StartPlace::Point(centre), 10, 2);
        assert!(
            particles
                .iter()
                .all(|p| position(&surface, p).distance(middle) < 1e-6)
        );
    }

    #[test]
    fn the_nearest_point_is_nearest() {
        let surface = surface(&[("icosphere?subdivisions=2", 1.0), ("cube", 0.5)]);
        let (samples, _) = start(&surface, StartPlace::Everywhere, 20_000, 3);
        for k in 0..50 {
            let place = |object| {
                let words = random(6, k, object, Purpose::Start);
                Vec3::from_array([0, 1, 2].map(|axis| 4.0 * unit(words[axis]) - 2.0))
            };
            let places = [place(0), place(1)];
            let distance = |p: &Particle| {
                let object = surface.triangles[p.triangle as usize].object;
                position(&surface, p).distance(places[object as usize])
            };
            let found = distance(&particle(0, nearest_point(&surface, &places)));
            let sampled = samples.iter().map(distance).fold(f32::INFINITY, f32::min);
            assert!(
                found <= sampled + 1e-6 && found > sampled - 0.1,
                "{found}, {sampled}"
            );
        }
    }

    #[test]
    fn every_share_of_the_area_has_a_triangle() {
        let surface = surface(&[("cube", 1.0)]);
        let table = AreaTable::new(&surface);
        assert_eq!(table.triangle_at(0.0), 0);
        assert_eq!(table.triangle_at(1.001 / 12.0), 1);
        assert_eq!(table.triangle_at(share([u32::MAX; 4])), 11);
        assert_eq!(share([0; 4]), 0.0);
        assert_eq!(share([1 << 31, 0, 0, 0]), 0.5);
        assert!(share([0, 8, 0, 0]) > 0.0 && share([u32::MAX; 4]) < 1.0);
    }
}
