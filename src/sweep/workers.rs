//! How many runs are done at once.

use std::thread;

use crate::gpu::{DeviceInfo, DeviceKind, Free};
use crate::scene::Scene;
use crate::sim::memory;

/// How many processes a sweep takes for runs of this scene: on a driver that computes on the processor one for each of its cores, as long as
/// their memory suffices; on a graphics card, which runs one kernel at a time, one.
#[must_use]
pub fn processes(info: &DeviceInfo, scene: &Scene) -> usize {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    number(info.kind, cores, memory::needed(scene), Free::on(info))
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

    /// Catches as many processes as there are cores for a scene of which the memory holds two.
    #[test]
    fn there_are_as_many_as_cores_or_memory_allow() {
        let free = |memory| Some(Free { memory, swap: 0 });
        let gib = 1 << 30;
        assert_eq!(number(DeviceKind::Cpu, 8, gib, free(64 * gib)), 8);
        assert_eq!(number(DeviceKind::Cpu, 8, gib, free(5 * gib)), 2);
        assert_eq!(number(DeviceKind::Cpu, 8, gib, free(gib)), 1);
        assert_eq!(number(DeviceKind::Cpu, 8, gib, None), 8);
        assert_eq!(number(DeviceKind::Discrete, 8, gib, free(64 * gib)), 1);
    }
}
