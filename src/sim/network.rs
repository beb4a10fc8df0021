//! Measures of a grown network: the length of its lines, its components, and the regions that it encloses.
//!
//! The network is where the trail is more than [`THRESHOLD`] times its mean. All measures are computed on the host, from a [`Snapshot`],
//! and do not depend on the charts: parts that touch across a seam are connected.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::setup::Setup;
use super::snapshot::Snapshot;
use crate::mesh::atlas::Atlas;
use crate::mesh::surface::{NONE, Surface};

/// The network begins at this many times the mean trail.
pub const THRESHOLD: f64 = 1.5;

/// The multiples of the mean trail for [`Network::below`].
pub const TIMES: [f64; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

/// Pieces and regions of fewer texels are noise, and are not counted.
const SMALLEST: u32 = 9;

/// The measures of a network.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Network {
    /// Particles that are alive.
    #[serde(default)]
    pub particles: u64,
    /// Mean trail over the surface, trail units.
    pub mean_trail: f64,
    /// Share of the surface that the network covers, 0 to 1.
    pub covered: f64,
    /// Share of the particles that are on the network, 0 to 1.
    pub on_network: f64,
    /// Half of the network's outline, scene radii: for thin lines, their length. An open border is no outline, so that a line along one
    /// counts half.
    pub length: f64,
    /// Connected components of the network.
    pub pieces: u32,
    /// Regions of bare surface between its lines.
    pub regions: u32,
    /// Shares of the surface with a trail below each of [`TIMES`] times the mean, 0 to 1.
    pub below: [f64; 5],
    /// The measures of each object.
    #[serde(skip)]
    pub objects: Vec<Part>,
}

/// An object's part of a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// Particles on it.
    pub particles: u64,
    /// Mean trail on it, trail units.
    pub mean_trail: f64,
    /// Share of its surface that the network covers, 0 to 1.
    pub covered: f64,
    /// As [`Network::length`].
    pub length: f64,
}

impl Network {
    /// The measures of a state.
    #[must_use]
    pub fn of(snapshot: &Snapshot, setup: &Setup) -> Self {
        let (surface, atlas) = (&setup.surface, &setup.atlas);
        let radius = f64::from(setup.radius);
        let mut network = Self::of_trail(&snapshot.trail, surface, atlas, radius);
        let most = (THRESHOLD * network.mean_trail) as f32;
        let mut on_network = 0;
        let both = snapshot.particles.iter().zip(&snapshot.motions);
        let living = both.filter(|(_, motion)| !motion.is_dead());
        for (particle, _) in living {
            let texel = atlas.texel_of(particle.triangle, particle.u, particle.v);
            on_network += u64::from(snapshot.trail[texel as usize] > most);
            let object = surface.triangles[particle.triangle as usize].object;
            network.objects[object as usize].particles += 1;
        }
        network.particles = network.objects.iter().map(|part| part.particles).sum();
        network.on_network = on_network as f64 / (network.particles as f64).max(1.0);
        network
    }

    /// The measures of a trail, gutters filled, without particles. `radius` is the scene's, in world units.
    #[must_use]
    pub fn of_trail(trail: &[f32], surface: &Surface, atlas: &Atlas, radius: f64) -> Self {
        let owned: Vec<u32> = (0..trail.len() as u32)
            .into_par_iter()
            .filter(|&texel| atlas.owner[texel as usize] != NONE)
            .collect();
        let area = |texel: u32| f64::from(atlas.area[texel as usize]);
        let whole: f64 = owned.iter().map(|&texel| area(texel)).sum();
        let mass = |texel: u32| area(texel) * f64::from(trail[texel as usize]);
        let mean_trail = owned.iter().map(|&texel| mass(texel)).sum::<f64>() / whole;
        let below = TIMES.map(|times| {
            let most = (times * mean_trail) as f32;
            let under = owned.iter().filter(|&&t| trail[t as usize] < most);
            under.map(|&texel| area(texel)).sum::<f64>() / whole
        });
        let most = (THRESHOLD * mean_trail) as f32;
        let covered: Vec<bool> = trail.par_iter().map(|&value| value > most).collect();

        let mut parts = vec![Sums::default(); surface.objects.len()];
        let object_of = |texel: u32| {
            let triangle = atlas.owner[texel as usize] as usize;
            surface.triangles[triangle].object as usize
        };
        for &texel in &owned {
            let part = &mut parts[object_of(texel)];
            part.area += area(texel);
            part.mass += mass(texel);
            if covered[texel as usize] {
                part.covered += area(texel);
            }
            part.outline += outline_at(&covered, texel, atlas) * area(texel).sqrt();
        }
        let [regions, pieces] = counted(&covered, &owned, atlas);
        let share = |part: f64, of: f64| if of > 0.0 { part / of } else { 0.0 };
        Self {
            particles: 0,
            mean_trail,
            covered: share(parts.iter().map(|part| part.covered).sum(), whole),
            on_network: 0.0,
            length: 0.5 * parts.iter().map(|part| part.outline).sum::<f64>() / radius,
            pieces,
            regions,
            below,
            objects: (parts.iter())
                .map(|part| Part {
                    particles: 0,
                    mean_trail: share(part.mass, part.area),
                    covered: share(part.covered, part.area),
                    length: 0.5 * part.outline / radius,
                })
                .collect(),
        }
    }
}

/// The measures of one object, in world units.
#[derive(Clone, Default)]
struct Sums {
    area: f64,
    mass: f64,
    covered: f64,
    outline: f64,
}

/// The eight neighbours, in circular order, beginning with the one above.
pub(super) const AROUND: [(i64, i64); 8] = [
    (0, -1),
    (1, -1),
    (1, 0),
    (1, 1),
    (0, 1),
    (-1, 1),
    (-1, 0),
    (-1, -1),
];

/// What the border of the network adds to its outline at a texel, texel sides: how many of the ways to its eight neighbours
/// cross it, by Cauchy and Crofton's formula for four directions (Serra, "Image Analysis and Mathematical Morphology", 1982),
/// whose error is about 5 % at most, and zero in the mean over all directions. Each way is examined from both ends, and counts half from
/// each. Gutters hold the values across seams.
fn outline_at(covered: &[bool], texel: u32, atlas: &Atlas) -> f64 {
    let pitch = i64::from(atlas.pitch);
    let rows = covered.len() as i64 / pitch;
    let (x, y) = (i64::from(texel) % pitch, i64::from(texel) / pitch);
    let crosses = |&(dx, dy): &(i64, i64)| {
        let (x, y) = (x + dx, y + dy);
        let is_inside = (0..pitch).contains(&x) && (0..rows).contains(&y);
        is_inside && covered[(y * pitch + x) as usize] != covered[texel as usize]
    };
    let weight = |&(dx, dy): &(i64, i64)| if dx * dy == 0 { 1.0 } else { FRAC_1_SQRT_2 };
    let ways = AROUND.iter().filter(|way| crosses(way));
    0.5 * PI / 8.0 * ways.map(weight).sum::<f64>()
}

/// The number of connected parts of bare texels, and of covered ones. Covered texels are connected also by corners, bare texels are not, so
/// that a line of texels separates its two sides (Rosenfeld, "Connectivity in digital pictures", 1970).
fn counted(covered: &[bool], owned: &[u32], atlas: &Atlas) -> [u32; 2] {
    let pitch = i64::from(atlas.pitch);
    let rows = covered.len() as i64 / pitch;
    let next = |texel: u32, (dx, dy): (i64, i64)| {
        let (x, y) = (i64::from(texel) % pitch + dx, i64::from(texel) / pitch + dy);
        let other = (y * pitch + x) as usize;
        ((0..pitch).contains(&x) && (0..rows).contains(&y) && atlas.owner[other] != NONE)
            .then_some(other as u32)
    };
    let chart = |texel: u32| atlas.chart[atlas.owner[texel as usize] as usize];
    let is_covered = |texel: u32| covered[texel as usize];
    // Every second one of AROUND shares a side with the texel, the others share a corner.
    let reach = |texel: u32| AROUND.iter().step_by(if is_covered(texel) { 1 } else { 2 });

    let mut sets = Sets::new(covered.len());
    for &texel in owned {
        for &to in reach(texel) {
            let Some(other) = next(texel, to) else {
                continue;
            };
            if other > texel
                && is_covered(other) == is_covered(texel)
                && chart(other) == chart(texel)
            {
                sets.unite(texel, other);
            }
        }
    }
    // A gutter texel stands for the texel across the seam.
    for seam in &atlas.seams {
        let across = seam.main_source();
        for &to in reach(across) {
            if let Some(beside) = next(seam.texel, to)
                && is_covered(beside) == is_covered(across)
            {
                sets.unite(beside, across);
            }
        }
    }
    let mut sizes = vec![0; covered.len()];
    for &texel in owned {
        sizes[sets.root(texel) as usize] += 1;
    }
    [false, true].map(|of| {
        let parts = sizes.iter().zip(covered);
        parts
            .filter(|&(&size, &covered)| size >= SMALLEST && covered == of)
            .count() as u32
    })
}

/// Disjoint sets of numbers (Tarjan, "Efficiency of a good but not linear set union algorithm", 1975).
struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    fn new(count: usize) -> Self {
        Self {
            parent: (0..count as u32).collect(),
        }
    }

    fn root(&mut self, mut of: u32) -> u32 {
        while self.parent[of as usize] != of {
            let above = self.parent[of as usize];
            self.parent[of as usize] = self.parent[above as usize];
            of = self.parent[above as usize];
        }
        of
    }

    fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;
    use crate::mesh::Mesh;
    use crate::mesh::atlas::AtlasOptions;
    use crate::scene::Scene;
    use crate::scene::settings::{ObjectSettings, Settings};

    /// The network of lines on a ball; `distance` gives the distance of a place from the nearest line.
    fn on_ball(turn: u64, gutter: u32, distance: impl Fn(Vec3) -> f32) -> Network {
        let ball = Mesh::builtin("icosphere?subdivisions=4").unwrap();
        let surface = Surface::build(&[(&ball, 1.0)]);
        let atlas = Atlas::build(
            &surface,
            &AtlasOptions {
                size: 512,
                gutter,
                turn,
                ..AtlasOptions::default()
            },
        )
        .unwrap();
        let mut trail = vec![0.0; atlas.owner.len()];
        for (texel, &owner) in atlas.owner.iter().enumerate() {
            if owner != NONE {
                let (triangle, u, v) = atlas.surface_point_of(texel as u32).unwrap();
                let [a, b, c] =
                    surface.corners[triangle as usize].map(|k| surface.positions[k as usize]);
                let place = (a + u * (b - a) + v * (c - a)).normalize();
                trail[texel] = (-(distance(place) / 0.02).powi(2)).exp();
            }
        }
        for seam in &atlas.seams {
            let sources = seam.source.iter().zip(seam.weights());
            trail[seam.texel as usize] = sources.map(|(&s, w)| w * trail[s as usize]).sum();
        }
        Network::of_trail(&trail, &surface, &atlas, 2.0)
    }

    #[test]
    fn lines_on_a_ball_are_measured_and_counted_across_seams() {
        for (turn, gutter) in [(0, 1), (1, 2), (2, 1)] {
            // Two rings that do not meet: the ball's radius is half of the scene's.
            let height = 0.5_f32.asin();
            let rings = on_ball(turn, gutter, |p| (p.y.asin().abs() - height).abs());
            let expected = 4.0 * PI * 0.75_f64.sqrt() / 2.0;
            assert!(
                (rings.length / expected - 1.0).abs() < 0.02,
                "{turn}: {rings:?}, not {expected}"
            );
            assert_eq!((rings.pieces, rings.regions), (2, 3), "{turn}: {rings:?}");
            // Three great circles, each across the others: eight octants between them. Each of six crossings takes away
            // twice the lines' width.
            let circles = on_ball(turn, gutter, |p| p.abs().min_element().asin());
            let width = rings.covered * 4.0 / (4.0 * 0.75_f64.sqrt());
            let expected = (6.0 * PI - 12.0 * width) / 2.0;
            assert!(
                (circles.length / expected - 1.0).abs() < 0.02,
                "{turn}: {circles:?}, not {expected}"
            );
            assert_eq!(
                (circles.pieces, circles.regions),
                (1, 8),
                "{turn}: {circles:?}"
            );
            assert_eq!(circles.objects[0].length, circles.length);
            assert!(rings.covered < circles.covered && rings.below[0] > circles.below[0]);
        }
    }

    #[test]
    fn each_object_has_its_own_part() {
        let settings = Settings {
            objects: [("cube", [0.0; 3]), ("icosphere", [5.0, 0.0, 0.0])]
                .map(|(mesh, position)| ObjectSettings {
                    mesh: format!("builtin:{mesh}"),
                    position,
                    ..ObjectSettings::default()
                })
                .into(),
            ..Settings::default()
        };
        let scene = Scene::from_settings("two".to_owned(), settings, ".".into()).unwrap();
        let setup = Setup::new(&scene).unwrap();
        let (atlas, surface) = (&setup.atlas, &setup.surface);
        let area = |object: u32| -> f64 {
            let owned = (0..atlas.owner.len()).filter(|&texel| atlas.owner[texel] != NONE);
            let of =
                |&texel: &usize| surface.triangles[atlas.owner[texel] as usize].object == object;
            owned
                .filter(of)
                .map(|texel| f64::from(atlas.area[texel]))
                .sum()
        };
        // On one of them, all over it.
        for covered in [0, 1_u32] {
            let mut snapshot = Snapshot::start(&setup);
            for (texel, &owner) in atlas.owner.iter().enumerate() {
                let is_on = |owner: u32| surface.triangles[owner as usize].object == covered;
                snapshot.trail[texel] = f32::from(u8::from(owner != NONE && is_on(owner)));
            }
            let network = Network::of(&snapshot, &setup);
            let share = area(covered) / (area(0) + area(1));
            assert!(share < 0.66, "{share}: it is above the threshold");
            assert!((network.mean_trail - share).abs() < 1e-6, "{network:?}");
            assert!((network.covered - share).abs() < 1e-6, "{network:?}");
            let particles = network.objects.iter().map(|part| part.particles);
            assert_eq!(particles.sum::<u64>(), setup.particles.len() as u64);
            for (object, part) in (0..).zip(&network.objects) {
                let all = f64::from(u8::from(object == covered));
                assert_eq!((part.mean_trail, part.covered), (all, all), "{network:?}");
                let own = setup.particles.iter().filter(|particle| {
                    surface.triangles[particle.triangle as usize].object == object
                });
                assert_eq!(part.particles, own.count() as u64);
            }
            let on = network.objects[covered as usize].particles;
            let share = on as f64 / setup.particles.len() as f64;
            assert!((network.on_network - share).abs() < 0.01, "{network:?}");
        }
    }

    #[test]
    fn an_even_trail_is_no_network() {
        let even = on_ball(0, 2, |_| 0.01);
        assert!((even.mean_trail - f64::from((-0.25_f32).exp())).abs() < 1e-6);
        assert_eq!(even.below, [0.0, 0.0, even.below[2], 1.0, 1.0]);
        assert_eq!((even.covered, even.length), (0.0, 0.0));
        assert_eq!((even.pieces, even.regions), (0, 1));
        // An empty trail has no network either.
        let none = on_ball(0, 2, |_| 9.0);
        assert_eq!(
            (none.mean_trail, none.length, none.covered),
            (0.0, 0.0, 0.0)
        );
    }
}
