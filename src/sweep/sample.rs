//! Samples of ranges: at random, by a Latin hypercube, or by Sobol's sequence.

use serde::{Deserialize, Serialize};

use crate::rng::{self, Purpose};
use crate::{Error, Result};

/// A way of sampling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// A Latin hypercube: each range is cut into as many parts as there are points, and each part has one.
    #[default]
    Latin,
    /// Sobol's sequence with Owen's scrambling; best with a power of two of points.
    Sobol,
    /// Independent, uniform.
    Random,
}

/// Sobol's sequence is known for so many dimensions and points.
const SOBOL_DIMENSIONS: usize = sobol_burley::NUM_DIMENSIONS as usize;
const SOBOL_POINTS: usize = 1 << 16;

/// Points in the unit cube, `count` rows of `dimensions` numbers in `[0, 1)`; the same for the same seed.
///
/// # Errors
/// When Sobol's sequence is not known for so many dimensions or points.
pub fn sample(method: Method, count: usize, dimensions: usize, seed: u64) -> Result<Vec<Vec<f64>>> {
    let word = rng::seed_word(seed);
    let uniform = |point: usize, dimension: usize| {
        let words = rng::random(word, point as u32, dimension as u32, Purpose::Sample);
        let high = (u64::from(words[0]) << 21) ^ (u64::from(words[1]) >> 11);
        high as f64 / (1_u64 << 53) as f64
    };
    let mut points = vec![vec![0.0; dimensions]; count];
    match method {
        Method::Random => {
            for (number, point) in points.iter_mut().enumerate() {
                for (dimension, share) in point.iter_mut().enumerate() {
                    *share = uniform(number, dimension);
                }
            }
        }
        Method::Latin => {
            for dimension in 0..dimensions {
                // Where in its part a point lies, and which part it has, are drawn by numbers of their own.
                let mut parts: Vec<usize> = (0..count).collect();
                for last in (1..count).rev() {
                    let drawn = uniform(count + last, dimension) * (last + 1) as f64;
                    parts.swap(last, (drawn as usize).min(last));
                }
                for (number, point) in points.iter_mut().enumerate() {
                    let within = uniform(number, dimension);
                    point[dimension] = (parts[number] as f64 + within) / count as f64;
                }
            }
        }
        Method::Sobol => {
            if dimensions > SOBOL_DIMENSIONS || count > SOBOL_POINTS {
                return Err(Error::Invalid(format!(
                    "Sobol's sequence has at most {SOBOL_DIMENSIONS} parameters and {SOBOL_POINTS} points: \
                     sample by `latin` or `random`"
                )));
            }
            for (number, point) in points.iter_mut().enumerate() {
                for (dimension, share) in point.iter_mut().enumerate() {
                    let value = sobol_burley::sample(number as u32, dimension as u32, word);
                    *share = f64::from(value);
                }
            }
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catches parts without a point, and points that do not depend on the seed.
    #[test]
    fn each_part_of_each_range_has_a_point() {
        for method in [Method::Latin, Method::Sobol, Method::Random] {
            let points = sample(method, 64, 5, 7).expect("it is possible");
            assert_eq!(points, sample(method, 64, 5, 7).expect("it is possible"));
            assert_ne!(points, sample(method, 64, 5, 8).expect("it is possible"));
            for dimension in 0..5 {
                let mut parts: Vec<_> = (points.iter())
                    .map(|point| (64.0 * point[dimension]) as usize)
                    .collect();
                let order = parts.clone();
                parts.sort_unstable();
                let is_even = parts == (0..64).collect::<Vec<_>>();
                assert_eq!(is_even, method != Method::Random, "{method:?}");
                assert_ne!(order, parts, "{method:?} is mixed");
                if dimension > 0 {
                    assert!(points.iter().any(|point| point[0] != point[dimension]));
                }
            }
        }
        let error = sample(Method::Sobol, 4, 1000, 0).expect_err("too many");
        assert!(
            error.to_string().contains("at most 256 parameters"),
            "{error}"
        );
    }
}
