//! Exposure: the trail value that gets the brightest colour, found on the GPU from a histogram of the trail.
//!
//! This file has the CPU twins of its two kernels; [`super::renderer`] records them.

/// Bins of the histogram: eight for each doubling, from 2^-16 to 2^40.
pub const BIN_COUNT: u32 = 448;
const BIN_SHIFT: u32 = 20;
const FIRST_BIN_BITS: u32 = (127 - 16) << 3;

/// A texel of mean area counts as so many, and none as more than the latter: sums of all samples stay below 2^31.
const MEAN_AREA: f32 = 256.0;
const MOST_AREA: f32 = 16_384.0;

/// About how many texels are sampled, whatever the size of the atlas.
const SAMPLES: u32 = 65_536;

/// How the trail's brightness is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// From the picture's own trail.
    Auto {
        /// Share of the trail, by mass, that may be brighter than the brightest colour: 0 to 1.
        clipped_share: f32,
        /// 1 judges each picture alone; less follows the last picture slowly, which keeps a film from flickering.
        adaptation: f32,
    },
    /// This trail value gets the brightest colour.
    Fixed(f32),
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Auto {
            clipped_share: 0.08,
            adaptation: 1.0,
        }
    }
}

impl Exposure {
    /// For sequences of pictures: follows the trail slowly, to avoid flicker.
    #[must_use]
    pub fn following() -> Self {
        Self::Auto {
            clipped_share: 0.08,
            adaptation: 0.12,
        }
    }
}

/// A trail value as a brightness in 0 to 1, where `brightest` gets the brightest colour. Twin of `tone` in
/// `shaders/include/colormap.glsl`.
#[must_use]
pub fn tone(trail: f32, brightest: f32) -> f32 {
    let shoulder = 0.45;
    let x = trail.max(0.0) / brightest;
    ((1.0 + shoulder) * x / (x + shoulder)).min(1.0)
}

/// Distance between sampled texels. Odd, so that it does not align with the rows of the atlas.
#[must_use]
pub fn stride(texel_count: u32) -> u32 {
    (texel_count / SAMPLES) | 1
}

/// Twin of `bin_of` in `exposure.glsl`.
fn bin_of(trail: f32) -> u32 {
    let bits = trail.max(0.0).to_bits() >> BIN_SHIFT;
    bits.clamp(FIRST_BIN_BITS, FIRST_BIN_BITS + BIN_COUNT - 1) - FIRST_BIN_BITS
}

/// Twin of `bin_edge` in `exposure.glsl`.
fn bin_edge(bin: u32) -> f32 {
    f32::from_bits((FIRST_BIN_BITS + bin) << BIN_SHIFT)
}

/// What a texel of this density counts, by the area of the surface that it covers. Twin of `area_of` in `exposure.glsl`.
fn area_of(density: f32) -> u32 {
    (MEAN_AREA / density + 0.5).clamp(1.0, MOST_AREA) as u32
}

/// Twin of `shaders/trail_histogram.comp`.
pub fn trail_histogram(
    sample_count: u32,
    stride: u32,
    trail: &[f32],
    density: &[f32],
    histogram: &mut [u32],
) {
    for i in 0..sample_count {
        let texel = (i * stride) as usize;
        if density[texel] == 0.0 {
            continue;
        }
        histogram[bin_of(trail[texel]) as usize] += area_of(density[texel]);
    }
}

/// Twin of `shaders/expose.comp`.
pub fn expose(
    count: u32,
    clipped_share: f32,
    adaptation: f32,
    histogram: &mut [u32],
    brightest: &mut [f32],
) {
    #[expect(clippy::needless_range_loop, reason = "mirrors the shader")]
    for i in 0..count as usize {
        let bins = i * BIN_COUNT as usize..(i + 1) * BIN_COUNT as usize;
        expose_one(
            clipped_share,
            adaptation,
            &mut histogram[bins],
            &mut brightest[i],
        );
    }
}

fn expose_one(clipped_share: f32, adaptation: f32, histogram: &mut [u32], brightest: &mut f32) {
    let mut mass = 0.0;
    for bin in 0..BIN_COUNT {
        mass += histogram[bin as usize] as f32 * bin_edge(bin);
    }
    let wanted = clipped_share * mass;
    let mut above = 0.0;
    let mut value = bin_edge(0);
    for bin in (0..BIN_COUNT).rev() {
        let here = histogram[bin as usize] as f32 * bin_edge(bin);
        if here > 0.0 && above + here >= wanted {
            let into = (wanted - above) / here;
            value = bin_edge(bin + 1) - into * (bin_edge(bin + 1) - bin_edge(bin));
            break;
        }
        above += here;
    }
    histogram.fill(0);
    *brightest += adaptation * (value - *brightest);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exposed(trail: &[f32], clipped_share: f32) -> f32 {
        let mut histogram = vec![0; BIN_COUNT as usize];
        let density = vec![1.0; trail.len()];
        trail_histogram(trail.len() as u32, 1, trail, &density, &mut histogram);
        let mut brightest = 0.0;
        expose_one(clipped_share, 1.0, &mut histogram, &mut brightest);
        assert!(
            histogram.iter().all(|&count| count == 0),
            "left for the next picture"
        );
        brightest
    }

    #[test]
    fn bins_have_the_values_between_their_edges() {
        for bin in 0..BIN_COUNT {
            assert_eq!(bin_of(bin_edge(bin)), bin);
            assert_eq!(bin_of(bin_edge(bin + 1) * 0.999_999), bin);
        }
        assert_eq!(bin_edge(128), 1.0);
        assert_eq!(bin_edge(129), 1.125);
        for (value, bin) in [
            (0.0, 0),
            (-1.0, 0),
            (1e-30, 0),
            (1e6, 287),
            (1e30, BIN_COUNT - 1),
            (f32::INFINITY, BIN_COUNT - 1),
        ] {
            assert_eq!(bin_of(value), bin, "{value}");
        }
    }

    #[test]
    fn an_even_trail_is_exposed_for_its_value() {
        for value in [0.01, 1.0, 9.5, 300.0, 1e6, 1e11] {
            let brightest = exposed(&vec![value; 1000], 0.08);
            assert!(
                (brightest / value - 1.0).abs() < 0.13,
                "{value} is exposed for {brightest}"
            );
        }
    }

    /// Would catch: fine texels that count as much as coarse ones, so that an object with many of them sets the exposure.
    #[test]
    fn texels_count_by_their_area() {
        // As much surface in each half, of which the second has sixteen times as many texels.
        let (trail, density): (Vec<f32>, Vec<f32>) = (0..1700)
            .map(|i| if i < 100 { (8.0, 0.5) } else { (1.0, 8.0) })
            .unzip();
        let mut histogram = vec![0; BIN_COUNT as usize];
        trail_histogram(1700, 1, &trail, &density, &mut histogram);
        let bins = [8.0, 1.0].map(|value| histogram[bin_of(value) as usize]);
        assert_eq!(bins, [51_200; 2]);
        for (density, area) in [(1.0, 256), (1e9, 1), (1e-9, 16_384)] {
            assert_eq!(area_of(density), area);
        }
        // The most samples.
        let most = (1..1 << 20).map(|count: u32| count.div_ceil(stride(count)));
        let most = u64::from(most.max().unwrap_or(0));
        assert!(most * (MOST_AREA as u64) < 1 << 31, "{most}");
    }

    #[test]
    fn bare_surface_does_not_count() {
        let mut trail = vec![0.0; 10_000];
        trail[..100].fill(40.0);
        let brightest = exposed(&trail, 0.08);
        assert!((36.0..=45.0).contains(&brightest), "{brightest}");
    }

    #[test]
    fn the_clipped_share_is_a_share_of_the_mass() {
        // Values 1 to 1000, one each: values above x have the mass (1000^2 - x^2) / 2 of 1000^2 / 2.
        let trail: Vec<f32> = (1..=1000).map(|i| i as f32).collect();
        for share in [0.05_f32, 0.2, 0.5] {
            let expected = 1000.0 * (1.0 - share).sqrt();
            let brightest = exposed(&trail, share);
            assert!(
                (brightest / expected - 1.0).abs() < 0.05,
                "{share}: {brightest}, expected {expected}"
            );
        }
    }

    #[test]
    fn an_empty_trail_and_an_empty_surface_give_a_positive_exposure() {
        assert!(exposed(&[0.0; 50], 0.08) > 0.0);
        assert!(exposed(&[], 0.08) > 0.0);
    }

    #[test]
    fn adaptation_follows_slowly() {
        let mut histogram = vec![0; BIN_COUNT as usize];
        let mut brightest = 2.0;
        histogram[bin_of(10.0) as usize] = 7;
        expose_one(0.08, 0.25, &mut histogram, &mut brightest);
        assert!(
            (3.9..=4.4).contains(&brightest),
            "a quarter of the way from 2 to about 10: {brightest}"
        );
    }

    #[test]
    fn sampling_visits_different_columns_of_every_row() {
        for (texel_count, samples) in [
            (1024 * 1024, 60_000..70_000),
            (4096 * 4096, 60_000..70_000),
            (900, 900..901),
        ] {
            let stride = stride(texel_count);
            assert_eq!(stride % 2, 1);
            assert!(
                samples.contains(&texel_count.div_ceil(stride)),
                "{texel_count}: {stride}"
            );
        }
    }
}
