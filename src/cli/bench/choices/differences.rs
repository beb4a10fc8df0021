//! How what comes out of the ways differs: ends of walks from a reference in double precision, counts, readings.

use glam::{DVec2, DVec3};
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{BorderRule, SurfacePoint, walk};
use myxo::sim::Setup;
use myxo::sim::types::{Motion, Particle};
use myxo::{Error, Result};
use rayon::prelude::*;

use super::ways::{Binding, Reach, Walking, Way, Ways};
use super::{Found, READINGS};

/// Walkers that are followed.
const WALKERS: usize = 20_000;

impl Reach {
    /// Walks, one after the other, after which ends are compared: about as far either way.
    pub fn walks(self) -> u32 {
        match self {
            Self::Step => 100,
            Self::Sensor => 12,
        }
    }
}

/// Where a walk ends, and how far it was.
struct End {
    place: DVec3,
    triangle: u32,
    way: f64,
}

/// What walks of each kind differ by from straight ones.
pub fn of_walks(ways: &Ways<'_>, setup: &Setup, reach: Reach) -> Result<[Found; 3]> {
    let all = ways.snapshot.particles.len();
    let stride = all.div_ceil(WALKERS).max(1);
    let chosen = (0..all).step_by(stride);
    let particles: Vec<Particle> = chosen.clone().map(|i| ways.snapshot.particles[i]).collect();
    let motions: Vec<Motion> = chosen.map(|i| ways.snapshot.motions[i]).collect();
    let times = reach.walks();
    let length = f64::from(ways.length(reach)) * f64::from(times);
    let ends = straight_ends(&setup.surface, &particles, &motions, length);
    let found = |walking| {
        let walked = ways.walked(reach, walking, &particles, &motions, times)?;
        let errors: Vec<f64> = walked
            .iter()
            .zip(&ends)
            .map(|(particle, end)| {
                let place = place_of(&setup.surface, &point_of(particle));
                place.distance(end.place) / end.way
            })
            .collect();
        let elsewhere = walked
            .iter()
            .zip(&ends)
            .filter(|(p, e)| p.triangle != e.triangle);
        let elsewhere = elsewhere.count() as f64 / walked.len().max(1) as f64;
        let [median, p95, most] = percentiles(errors);
        Ok::<_, Error>(Found::from([
            ("walks", f64::from(times)),
            ("off: median", median),
            ("off: p95", p95),
            ("off: most", most),
            ("wrong triangle", elsewhere),
        ]))
    };
    Ok([
        found(Walking::Exact)?,
        found(Walking::Corrected)?,
        found(Walking::CorrectedOnce)?,
    ])
}

fn point_of(particle: &Particle) -> SurfacePoint {
    SurfacePoint {
        triangle: particle.triangle,
        u: particle.u.into(),
        v: particle.v.into(),
    }
}

fn straight_ends(
    surface: &Surface,
    particles: &[Particle],
    motions: &[Motion],
    length: f64,
) -> Vec<End> {
    let end = |(particle, motion): (&Particle, &Motion)| {
        let heading = DVec2::new(motion.heading_p.into(), motion.heading_h.into());
        let way = length + f64::from(motion.pending);
        let end = walk(
            surface,
            point_of(particle),
            heading.normalize(),
            way,
            None,
            BorderRule::Reflect,
        );
        End {
            place: place_of(surface, &end.point),
            triangle: end.point.triangle,
            way,
        }
    };
    particles.par_iter().zip(motions).map(end).collect()
}

/// In object space, which has world lengths.
fn place_of(surface: &Surface, point: &SurfacePoint) -> DVec3 {
    let corners = surface.corners[point.triangle as usize];
    let [a, b, c] = corners.map(|i| surface.positions[i as usize].as_dvec3());
    a + point.u * (b - a) + point.v * (c - a)
}

/// Median, 95th percentile, most.
fn percentiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let at = |part: f64| {
        let last = values.len().saturating_sub(1);
        values.get((part * last as f64).round() as usize).copied()
    };
    [0.5, 0.95, 1.0].map(|part| at(part).unwrap_or_default())
}

/// Counts and drawn counts, which must be those of the atlas.
pub fn of_counts(ways: &Ways<'_>, setup: &Setup) -> Result<[Found; 2]> {
    let [counted, drawn] = ways.counts()?;
    let mut expected = vec![0; counted.len()];
    for particle in &ways.snapshot.particles {
        let texel = (setup.atlas).texel_of(particle.triangle, particle.u, particle.v);
        expected[texel as usize] += 1;
    }
    let crowd = f64::from(expected.iter().max().copied().unwrap_or_default());
    let of = |way: Way, counts: &[u32]| {
        let wrong = counts.iter().zip(&expected).filter(|(a, b)| a != b).count();
        if wrong > 0 {
            return Err(Error::Invalid(format!(
                "{} counts {wrong} of {} texels wrong: report this, with the driver's version",
                way.kernel(),
                counts.len()
            )));
        }
        Ok(Found::from([
            ("most in a texel", crowd),
            ("wrong texels", wrong as f64),
        ]))
    };
    Ok([of(Way::Count, &counted)?, of(Way::Draw, &drawn)?])
}

/// By how much readings differ from those of the program's own way, in parts of the mean reading.
pub fn of_readings(readings: &[Vec<f32>; READINGS.len()]) -> Result<[Found; READINGS.len()]> {
    let own = &readings[0];
    let mean = own.iter().copied().map(f64::from).sum::<f64>() / own.len().max(1) as f64;
    let mean = if mean > 0.0 { mean } else { 1.0 };
    let mut all: [Found; READINGS.len()] = Default::default();
    for ((found, others), binding) in all.iter_mut().zip(readings).zip(READINGS) {
        let differences = own.iter().zip(others);
        let differences = differences.map(|(a, b)| f64::from((a - b).abs()) / mean);
        let [median, p95, most] = percentiles(differences.collect());
        if most > 0.0 && binding != Binding::Sampler {
            return Err(Error::Invalid(format!(
                "{} reads otherwise than read_texels, by up to {most:.2e} of the mean: report this, with the driver's version",
                Way::Read(binding).kernel()
            )));
        }
        *found = Found::from([
            ("differs: median", median),
            ("differs: p95", p95),
            ("differs: most", most),
        ]);
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_values_of_the_list() {
        let values = (0..=100).rev().map(f64::from).collect();
        assert_eq!(percentiles(values), [50.0, 95.0, 100.0]);
        assert_eq!(percentiles(vec![3.0]), [3.0; 3]);
        assert_eq!(percentiles(Vec::new()), [0.0; 3]);
    }

    #[test]
    fn readings_that_should_be_equal_and_are_not_are_refused() {
        let mut readings: [Vec<f32>; READINGS.len()] = Default::default();
        readings.fill(vec![1.0, 3.0]);
        readings[4][1] = 3.5;
        let found = of_readings(&readings).expect("samplers may round");
        assert_eq!(found[4]["differs: most"], 0.25);
        assert_eq!(found[1]["differs: most"], 0.0);
        readings[1][0] = 1.5;
        let error = of_readings(&readings).expect_err("blocks may not");
        assert!(error.to_string().starts_with("read_block reads otherwise"));
    }
}
