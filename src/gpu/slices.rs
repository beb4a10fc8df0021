//! Slices of a recording: how dispatches are divided, and how the time between slices is subtracted.

use std::collections::{HashMap, VecDeque};

use ash::vk;

use super::error::GpuError;

/// The slices of a recording.
#[derive(Default)]
pub(crate) struct Slices {
    /// Every kernel ends one.
    pub(crate) is_on: bool,
    /// The number of slices of each slow kernel.
    pub(crate) parts: HashMap<String, u32>,
    /// Number of ended slices.
    pub(crate) count: usize,
    /// Slices that are not submitted yet.
    pub(crate) waiting: VecDeque<vk::CommandBuffer>,
    /// For each gap between slices the first of its two queries. The time between them is not the recording's.
    pub(crate) gaps: Vec<u32>,
    /// A slice was submitted and may still be running.
    pub(crate) is_running: bool,
    /// Why the recording cannot be submitted.
    pub(crate) failed: Option<GpuError>,
}

/// Parts of about the same size, in whole rows if there are several rows: kernels count their invocations by the width.
pub(crate) fn parts_of([width, rows]: [u32; 2], parts: u32) -> impl Iterator<Item = [[u32; 2]; 2]> {
    let whole = if rows > 1 { rows } else { width };
    let parts = parts.clamp(1, whole.max(1));
    let cut = move |part: u32| (u64::from(whole) * u64::from(part) / u64::from(parts)) as u32;
    (0..parts).map(move |part| {
        let (first, count) = (cut(part), cut(part + 1) - cut(part));
        if rows > 1 {
            [[0, first], [width, count]]
        } else {
            [[first, 0], [count, rows]]
        }
    })
}

/// Subtracts gaps from times; each gap has two queries. A time is reduced by the length of all gaps that ended before it.
pub(crate) fn without_gaps(ticks: &mut [u64], gaps: &[u32], mask: u64) {
    let Some(&start) = ticks.first() else {
        return;
    };
    // Counters wrap: count from the frame's own start.
    let since_start = |tick: u64| tick.wrapping_sub(start) & mask;
    // Slices follow each other, so gaps are in order.
    let mut ends = Vec::with_capacity(gaps.len());
    let mut sum = 0;
    for &gap in gaps {
        let [from, to] = [gap, gap + 1].map(|query| since_start(ticks[query as usize]));
        sum += to.saturating_sub(from);
        ends.push((to, sum));
    }
    for tick in ticks {
        let time = since_start(*tick);
        let before = ends.partition_point(|&(end, _)| end <= time);
        let sum = before.checked_sub(1).map_or(0, |last| ends[last].1);
        *tick = tick.wrapping_sub(sum);
    }
}

#[cfg(test)]
mod tests {
    use super::{parts_of, without_gaps};

    #[test]
    fn parts_are_all_of_a_dispatch_once() {
        for (groups, wanted) in [
            ([1, 1], 3),
            ([5, 1], 1),
            ([5, 1], 3),
            ([65_535, 1], 7),
            ([40_000, 3], 2),
            ([40_000, 3], 9),
        ] {
            let parts: Vec<_> = parts_of(groups, wanted).collect();
            let most = if groups[1] > 1 { groups[1] } else { groups[0] };
            assert_eq!(parts.len() as u32, wanted.min(most));
            let mut next = 0;
            for [[x, y], [width, height]] in &parts {
                assert!(*width > 0 && *height > 0);
                // Kernels count groups in whole rows of a dispatch with a known width.
                assert!(*y == 0 || *width == groups[0]);
                assert_eq!(y * width + x, next);
                next += width * height;
            }
            assert_eq!(next, groups[0] * groups[1]);
        }
    }

    #[test]
    fn time_between_slices_is_not_counted() {
        // Queries of a frame 0 and 1, a step 2 and 3, then kernels of 10 ticks each with gaps of 100 and 1000 after them.
        // The counter has eight bits more than it keeps, and wraps on the way.
        let mask = 0xfff;
        let times = [
            0, 1150, 2, 1148, 5, 15, 17, 117, 119, 129, 131, 1131, 1134, 1144,
        ];
        let mut ticks: Vec<u64> = times.map(|time: u64| (time + 3500) & mask).into();
        without_gaps(&mut ticks, &[6, 10], mask);
        let left: Vec<u64> = ticks.iter().map(|t| t.wrapping_sub(3500) & mask).collect();
        assert_eq!(left, [0, 50, 2, 48, 5, 15, 17, 17, 19, 29, 31, 31, 34, 44]);
        let mut none: [u64; 0] = [];
        without_gaps(&mut none, &[], mask);
        let mut without = [7, 9];
        without_gaps(&mut without, &[], mask);
        assert_eq!(without, [7, 9]);
    }
}
