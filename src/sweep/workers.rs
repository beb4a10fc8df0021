//! How many runs are done at once.

use std::thread;

use serde_json::{Value, json};

use super::row::Row;
use crate::gpu::{DeviceInfo, DeviceKind, Free};
use crate::render::Offscreen;
use crate::scene::Scene;
use crate::sim::memory;

/// Parameters by which the memory of a run grows.
const SIZES: &[&str] = &[
    "particles.count",
    "atlas.size",
    "population.capacity",
    "population.frequency",
];

/// Of some points, the largest value of each parameter that decides how much memory a run takes.
pub fn largest<'a>(points: impl IntoIterator<Item = &'a Row>) -> Row {
    let mut largest = Row::default();
    for point in points {
        for name in SIZES {
            let of = |row: &Row| row.get(name).and_then(Value::as_u64);
            if let Some(value) = of(point).max(of(&largest)) {
                largest.set(name, json!(value));
            }
        }
    }
    largest
}

/// How many processes a sweep takes, whose largest run is this scene, and whose runs have pictures of this size, if any: on a driver that
/// computes on the processor one for each of its cores, if their memory suffices; on a graphics card, which runs one kernel at a time, one.
#[must_use]
pub fn processes(info: &DeviceInfo, scene: &Scene, picture: Option<[u32; 2]>) -> usize {
    let needed = memory::needed(scene) + picture.map_or(0, Offscreen::bytes);
    number(info.kind, cores(), needed, Free::on(info))
}

/// How many threads each of so many processes takes, so that all cores are busy.
#[must_use]
pub fn threads(processes: usize) -> usize {
    (cores() / processes.max(1)).max(1)
}

fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

fn number(kind: DeviceKind, cores: usize, on_device: u64, free: Option<Free>) -> usize {
    if kind != DeviceKind::Cpu {
        return 1;
    }
    let room = free.map_or(usize::MAX, |free| {
        let each = memory::in_all(on_device, kind).max(1);
        usize::try_from(free.at_ease() / each).unwrap_or(usize::MAX)
    });
    cores.min(room).max(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catches more processes than fit into memory.
    #[test]
    fn there_are_as_many_as_cores_or_memory_allow() {
        let free = |memory| Some(Free { memory, swap: 0 });
        let gib = 1 << 30;
        assert_eq!(number(DeviceKind::Cpu, 8, gib, free(64 * gib)), 8);
        assert_eq!(number(DeviceKind::Cpu, 8, gib, free(5 * gib)), 2);
        assert_eq!(number(DeviceKind::Cpu, 8, gib, free(gib)), 1);
        assert_eq!(number(DeviceKind::Cpu, 8, gib, None), 8);
        assert_eq!(number(DeviceKind::Discrete, 8, gib, free(64 * gib)), 1);
        // A pixel has 36 bytes in images of four samples and their resolved one, 4 in the developed one, 8 in words, 4 that are read, and
        // between 1 and 2 in cells of the bloom. All is counted twice, and of 64 GiB a tenth stays free.
        let drawn = Offscreen::bytes([8192; 2]);
        let pixels = 8192 * 8192;
        assert!((53 * pixels..54 * pixels).contains(&drawn), "{drawn}");
        assert_eq!(number(DeviceKind::Cpu, 8, gib + drawn, free(64 * gib)), 6);
        assert_eq!(threads(usize::MAX), 1);
        assert_eq!(threads(1), cores());
    }

    /// Catches a number of processes by the first and smallest of the runs.
    #[test]
    fn the_largest_run_counts() {
        let row = |text: &str| serde_json::from_str(text).expect("it is JSON");
        let points: [Row; 5] = [
            row(r#"{"particles.count":100,"trail.decay":0.9}"#),
            row(r#"{"particles.count":3000}"#),
            row(r#"{"particles.count":7,"atlas.size":64}"#),
            row(r#"{"population.capacity":9000,"population.frequency":0}"#),
            row(r#"{"population.capacity":500,"population.frequency":5}"#),
        ];
        let found = largest(&points);
        let expected = r#"{"particles.count":3000,"atlas.size":64,"population.capacity":9000,"population.frequency":5}"#;
        assert_eq!(found, row(expected));
    }
}
