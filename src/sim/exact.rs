//! Exact sums and products, as pairs of the rounded value and its rounding error. Twin of
//! `shaders/include/exact.glsl`.

/// The sum of two numbers (Knuth 1969).
#[must_use]
pub fn exact_sum(a: f32, b: f32) -> [f32; 2] {
    let sum = a + b;
    let b_in_sum = sum - a;
    let dropped = (a - (sum - b_in_sum)) + (b - b_in_sum);
    [sum, dropped]
}

/// A number as the sum of two that have half as many digits each (Veltkamp 1968).
fn halves(a: f32) -> [f32; 2] {
    let scaled = 4097.0 * a;
    let high = scaled - (scaled - a);
    [high, a - high]
}

/// The product of two numbers (Dekker 1971).
#[must_use]
pub fn exact_product(a: f32, b: f32) -> [f32; 2] {
    let product = a * b;
    let [a_high, a_low] = halves(a);
    let [b_high, b_low] = halves(b);
    let dropped = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    [product, dropped]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{Purpose, random, unit};

    #[test]
    fn nothing_is_lost() {
        for i in 0..10_000 {
            let [a, b, ..] = random(3, i, 0, Purpose::Start).map(|word| 2.0 * unit(word) - 1.0);
            let b = b * [1.0, 1e-3, 1e-8][i as usize % 3];
            let value = |[rounded, dropped]: [f32; 2]| f64::from(rounded) + f64::from(dropped);
            assert_eq!(value(exact_sum(a, b)), f64::from(a) + f64::from(b));
            assert_eq!(value(exact_product(a, b)), f64::from(a) * f64::from(b));
        }
    }
}
