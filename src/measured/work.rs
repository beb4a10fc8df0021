//! The work of kernels: the number of particles or texels in a step, and the bytes that they must read and write.
//!
//! Bytes are those that every layout of the same buffers needs, each counted once per particle or texel, regardless of caches: a particle's
//! record and its motion are read and written, one texel of trail is read for each of the three sensors, one count is read and written for
//! the deposit. Tables of triangles, which many particles share, are not counted, nor texels that only bilinear reads touch. Therefore the
//! rate shows how much of the memory's speed is used for necessary data, not the whole traffic.

use myxo::sim::Setup;
use myxo::sim::sorting::Segments;
use myxo::sim::types::{ExchangeEntry, ExchangeRow, Motion, Particle, Seam};

/// A texel of trail, a count, a density.
const TEXEL: u64 = size_of::<f32>() as u64;
const RECORD: u64 = (size_of::<Particle>() + size_of::<Motion>()) as u64;
const SENSORS: u64 = 3;

/// What a kernel gets through in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// How many there are.
    pub count: f64,
    /// What is counted.
    pub of: &'static str,
    /// Bytes read and written.
    pub bytes: f64,
}

/// The work of a kernel in a step with so many dispatches of it. Each living particle advances once;
/// `advancing` of them were measured, if that is known. `None` if only the device has the number. Dead ones are sorted as all others.
pub fn work_of(
    kernel: &str,
    dispatches: f64,
    setup: &Setup,
    segments: Segments,
    advancing: Option<u64>,
) -> Option<Work> {
    let atlas = &setup.atlas;
    // Of a segment, in the mean.
    let sorted = setup.particles.len() as u64 / u64::from(segments.count());
    let rows = atlas.exchange.rows.len() as u64;
    let entries = atlas.exchange.entries.len() as u64;
    let gutters = atlas.seams.len() as u64;
    let texels = u64::from(atlas.owned_count);
    let (count, of, bytes) = match kernel {
        // Particles are read and written; sensors read, and deposits are read and written. By `wish` what is written of a particle is half as
        // much more, and goals and bids take the place of deposits.
        "advance" | "wish" => {
            let count = advancing?;
            let each = match kernel {
                "advance" => 2 * RECORD + SENSORS * TEXEL + 2 * TEXEL,
                _ => 2 * RECORD + RECORD / 2 + SENSORS * TEXEL + 4 * TEXEL,
            };
            return Some(Work {
                count: count as f64,
                of: "particles",
                bytes: (count * each) as f64,
            });
        }
        // Trail, deposits and density are read; the next trail is written, and the deposits are cleared.
        "diffuse" => (texels, "texels", texels * 5 * TEXEL),
        // The same of the texel itself, but for the clearing, and trail and deposits of each that it exchanges with.
        "diffuse_seams" => (
            rows,
            "seam texels",
            rows * (size_of::<ExchangeRow>() as u64 + 4 * TEXEL)
                + entries * (size_of::<ExchangeEntry>() as u64 + 2 * TEXEL),
        ),
        // One of the up to four texels that it takes its value from.
        "exchange_seams" => (
            gutters,
            "gutter texels",
            gutters * (size_of::<Seam>() as u64 + 2 * TEXEL),
        ),
        // Particles are copied, and their bins' counts are read and written.
        "sort_count" | "sort_scatter" => (sorted, "particles", sorted * (2 * RECORD + 2 * TEXEL)),
        _ => return None,
    };
    Some(Work {
        count: count as f64 * dispatches,
        of,
        bytes: bytes as f64 * dispatches,
    })
}
