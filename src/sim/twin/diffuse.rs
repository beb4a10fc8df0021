//! Twin of `shaders/diffuse.comp`, a texel at a time.

use crate::sim::kernels::{DiffuseConstants, DiffuseParams};

/// Spreads, deposits and decays the trail of owned texels into `next_trail`, and clears `previous_deposits`.
pub fn diffuse(
    constants: &DiffuseConstants,
    params: &DiffuseParams,
    trail: &[f32],
    deposits: &[u32],
    density: &[f32],
    next_trail: &mut [f32],
    previous_deposits: &mut [u32],
) {
    let pitch = 4 * params.quads_a_row as usize;
    let rows = params.rows as usize;
    let distance = constants.distance as usize;
    // Taps beyond the buffer's ends belong to texels that nobody owns; the kernel repeats the wide load there.
    let row_sum = |row: usize, x: usize| {
        let quad = |quad: isize| quad.clamp(0, params.quad_count as isize - 1) as usize;
        let here = (row * pitch + x) / 4;
        let before = 4 * quad(here as isize - 1);
        let after = 4 * quad(here as isize + 1);
        let lane = x % 4;
        let left = if lane >= distance {
            trail[4 * here + lane - distance]
        } else {
            trail[before + 4 + lane - distance]
        };
        let right = if lane + distance < 4 {
            trail[4 * here + lane + distance]
        } else {
            trail[after + lane + distance - 4]
        };
        (left + trail[4 * here + lane]) + right
    };
    for quad in 0..params.quad_count as usize {
        if density[4 * quad..4 * quad + 4].iter().all(|&d| d == 0.0) {
            continue;
        }
        for texel in 4 * quad..4 * quad + 4 {
            let (row, x) = (texel / pitch, texel % pitch);
            let up = row - row.min(distance);
            let down = row + (rows - 1 - row).min(distance);
            let mean = ((row_sum(up, x) + row_sum(row, x)) + row_sum(down, x)) * (1.0 / 9.0);
            let spread = trail[texel] + params.diffusion * (mean - trail[texel]);
            let value = (spread + (params.deposit * deposits[texel] as f32) * density[texel])
                * params.decay;
            next_trail[texel] = if value >= params.tiny && density[texel] > 0.0 {
                value
            } else {
                0.0
            };
            previous_deposits[texel] = 0;
        }
    }
}
