//! How what comes out of the ways differs: ends of walks from a reference in double precision, counts, readings.

use glam::{DVec2, DVec3};
use myxo::mesh::surface::Surface;
use myxo::mesh::walk::{BorderRule, SurfacePoint, walk};
use myxo::sim::Setup;
use myxo::sim::types::{Motion, Particle};
use myxo::{Error, Result};
use rayon::prelude::*;

use super::ways::{Binding, Does, Reach, State, Walking, Way, Ways};

/// What was found out about a way besides its time.
pub type Found = Vec<(&'static str, f64)>;

/// Walkers that are followed.
const WALKERS: usize = 20_000;

/// What one way's results differ by.
pub fn of(way: &Way, ways: &Ways, setup: &Setup, state: &State) -> Result<Found> {
    match way.does {
        Does::Walk(reach, walking) => of_walks(ways, setup, state, reach, walking),
        Does::Count => of_counts(way, &ways.counts()?[0], setup, state),
        Does::Draw => of_counts(way, &ways.counts()?[1], setup, state),
        Does::Read(binding) => of_readings(
            way,
            &ways.readings(Binding::Texels)?,
            &ways.readings(binding)?,
        ),
    }
}

/// How far walks end from where straight ones do, after many of them: about as far either way.
fn of_walks(
    ways: &Ways,
    setup: &Setup,
    state: &State,
    reach: Reach,
    walking: Walking,
) -> Result<Found> {
    let times = match reach {
        Reach::Step => 100,
        Reach::Sensor => 12,
    };
    let stride = state.particles.len().div_ceil(WALKERS).max(1);
    let particles: Vec<Particle> = state.particles.iter().step_by(stride).copied().collect();
    let motions: Vec<Motion> = state.motions.iter().step_by(stride).copied().collect();
    let walk = ways.walk(reach, walking);
    let (walked, _) = ways.walked(walk, times, &particles, &motions)?;
    let length = f64::from(walk.length) * f64::from(times);
    let ends = errors(&setup.surface, &particles, &motions, length, &walked);
    let elsewhere = ends.iter().filter(|end| end.is_elsewhere).count();
    let [median, p95, most] = percentiles(ends.iter().map(|end| end.off).collect());
    Ok(vec![
        ("walks", f64::from(times)),
        ("off: median", median),
        ("off: p95", p95),
        ("off: most", most),
        (
            "wrong triangle",
            elsewhere as f64 / walked.len().max(1) as f64,
        ),
    ])
}

/// The end of a walk, and its right end.
pub struct End {
    /// Distance straight through space, in parts of the way.
    pub off: f64,
    /// On another triangle.
    pub is_elsewhere: bool,
}

/// Compares ends with those of walks in double precision of this length and what is pending.
pub fn errors(
    surface: &Surface,
    particles: &[Particle],
    motions: &[Motion],
    length: f64,
    walked: &[Particle],
) -> Vec<End> {
    let end = |((particle, motion), walked): ((&Particle, &Motion), &Particle)| {
        let heading = DVec2::new(motion.heading_p.into(), motion.heading_h.into()).normalize();
        let way = length + f64::from(motion.pending);
        let start = point_of(particle);
        let straight = walk(surface, start, heading, way, None, BorderRule::Reflect).point;
        let place = place_of(surface, &point_of(walked));
        End {
            off: place.distance(place_of(surface, &straight)) / way,
            is_elsewhere: walked.triangle != straight.triangle,
        }
    };
    let all = particles.par_iter().zip(motions).zip(walked);
    all.map(end).collect()
}

fn point_of(particle: &Particle) -> SurfacePoint {
    SurfacePoint {
        triangle: particle.triangle,
        u: particle.u.into(),
        v: particle.v.into(),
    }
}

/// In object space, which has world lengths.
fn place_of(surface: &Surface, point: &SurfacePoint) -> DVec3 {
    let corners = surface.corners[point.triangle as usize];
    let [a, b, c] = corners.map(|i| surface.positions[i as usize].as_dvec3());
    a + point.u * (b - a) + point.v * (c - a)
}

/// Counts, which must be those of the atlas.
fn of_counts(way: &Way, counts: &[u32], setup: &Setup, state: &State) -> Result<Found> {
    let mut expected = vec![0; counts.len()];
    for particle in &state.particles {
        let texel = (setup.atlas).texel_of(particle.triangle, particle.u, particle.v);
        expected[texel as usize] += 1;
    }
    let wrong = counts.iter().zip(&expected).filter(|(a, b)| a != b).count();
    if wrong > 0 {
        return Err(Error::Invalid(format!(
            "{} counts {wrong} of {} texels wrong: report this, with the driver's version",
            way.kernel,
            counts.len()
        )));
    }
    let most = expected.iter().max().copied().unwrap_or_default();
    Ok(vec![("most in a texel", f64::from(most))])
}

/// By how much readings differ from those of the program's own way, in parts of the mean reading.
fn of_readings(way: &Way, own: &[f32], others: &[f32]) -> Result<Found> {
    let mean = own.iter().copied().map(f64::from).sum::<f64>() / own.len().max(1) as f64;
    let mean = if mean > 0.0 { mean } else { 1.0 };
    let differences = own.iter().zip(others);
    let differences = differences.map(|(a, b)| f64::from((a - b).abs()) / mean);
    let [median, p95, most] = percentiles(differences.collect());
    if most > 0.0 && way.does != Does::Read(Binding::Sampler) {
        return Err(Error::Invalid(format!(
            "{} reads otherwise than read_texels, by up to {most:.2e} of the mean: report this, with the driver's version",
            way.kernel
        )));
    }
    Ok(vec![
        ("differs: median", median),
        ("differs: p95", p95),
        ("differs: most", most),
    ])
}

/// Median, 95th percentile, most.
pub fn percentiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let at = |part: f64| {
        let last = values.len().saturating_sub(1);
        values.get((part * last as f64).round() as usize).copied()
    };
    [0.5, 0.95, 1.0].map(|part| at(part).unwrap_or_default())
}
