//! Free memory, of a device or of the host.

use std::path::Path;

use super::info::{DeviceInfo, DeviceKind};

/// Free bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Free {
    /// Of memory.
    pub memory: u64,
    /// Of swap space, which is slow.
    pub swap: u64,
}

impl Free {
    /// The host's for drivers that compute there. Of other devices all memory counts, because what programs have taken of it is not known.
    /// `None` if nothing is known.
    #[must_use]
    pub fn on(info: &DeviceInfo) -> Option<Self> {
        if info.kind == DeviceKind::Cpu {
            return Self::on_host();
        }
        let heaps = info.heaps.iter().filter(|heap| heap.device_local);
        let memory = heaps.map(|heap| heap.size).sum();
        (memory > 0).then_some(Self { memory, swap: 0 })
    }

    /// The host's; `None` if it is not known.
    #[must_use]
    pub fn on_host() -> Option<Self> {
        on_host(Path::new("/"))
    }

    /// How much may be taken without slowing down other programs.
    #[must_use]
    pub fn at_ease(self) -> u64 {
        self.memory / 10 * 9
    }
}

/// The host's free memory; `root` holds the system's files.
fn on_host(root: &Path) -> Option<Free> {
    let read = |path: &str| std::fs::read_to_string(root.join(path)).ok();
    let mut free = system(&read("proc/meminfo")?)?;
    // Containers and jobs may have less than the machine.
    for (folder, names) in groups(&read("proc/self/cgroup").unwrap_or_default()) {
        let file = |name: &str| read(&format!("{folder}/{name}"));
        let [limit, usage] = names.map(file);
        let stat = file("memory.stat").unwrap_or_default();
        let left = limit.and_then(|limit| left_in_group(&limit, &usage.unwrap_or_default(), &stat));
        if let Some(left) = left.filter(|left| *left < free.memory) {
            // These files do not say whether a group may swap.
            free = Free {
                memory: left,
                swap: 0,
            };
        }
    }
    Some(free)
}

/// The folders of all control groups that a process is in, from the text of its `/proc/self/cgroup`, and what the files of
/// limit and usage are called there: by version 2 of control groups, and by version 1.
fn groups(own: &str) -> Vec<(String, [&'static str; 2])> {
    let second = ("sys/fs/cgroup", ["memory.max", "memory.current"]);
    let first = (
        "sys/fs/cgroup/memory",
        ["memory.limit_in_bytes", "memory.usage_in_bytes"],
    );
    let mut groups: Vec<_> = [second, first]
        .map(|(mount, names)| (mount.to_owned(), names))
        .into();
    for line in own.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else {
            continue;
        };
        let (mount, names) = match controllers {
            "" => second,
            _ if controllers.split(',').any(|name| name == "memory") => first,
            _ => continue,
        };
        // Each is within those above it.
        let mut path = path.trim_matches('/');
        while !path.is_empty() {
            groups.push((format!("{mount}/{path}"), names));
            path = path.rsplit_once('/').map_or("", |(above, _)| above);
        }
    }
    groups
}

/// From the text of `/proc/meminfo`.
fn system(meminfo: &str) -> Option<Free> {
    let bytes = |key: &str| {
        let line = meminfo.lines().find(|line| line.starts_with(key))?;
        let kibibytes: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
        Some(kibibytes * 1024)
    };
    Some(Free {
        memory: bytes("MemAvailable:")?,
        swap: bytes("SwapFree:").unwrap_or(0),
    })
}

/// What a control group may still take, from the texts of its limit, its usage and its statistics; `None` without a limit.
/// The page cache counts as used, but the system frees it when needed.
fn left_in_group(limit: &str, usage: &str, stat: &str) -> Option<u64> {
    let limit: u64 = limit.trim().parse().ok()?;
    let used: u64 = usage.trim().parse().unwrap_or(0);
    // Version 1 has sums over the groups below beside the group's own.
    let is_total = stat.lines().any(|line| line.starts_with("total_"));
    let files = ["inactive_file", "active_file"].map(|name| {
        let mut lines = stat.lines().filter_map(|line| line.split_once(' '));
        let found = lines.find(|(key, _)| {
            let own = if is_total {
                key.strip_prefix("total_")
            } else {
                Some(*key)
            };
            own == Some(name)
        });
        let bytes: Option<u64> = found.and_then(|(_, bytes)| bytes.trim().parse().ok());
        bytes.unwrap_or(0)
    });
    let kept = used.saturating_sub(files.iter().sum());
    Some(limit.saturating_sub(kept))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GIB: u64 = 1 << 30;
    const MEMINFO: &str = "MemTotal:       24576000 kB\nMemFree:  2000 kB\nMemAvailable:   16777216 kB\n\
                           SwapTotal: 5 kB\nSwapFree:        1048576 kB\n";

    #[test]
    fn what_is_free_is_read_as_the_system_writes_it() {
        let free = Free {
            memory: 16 * GIB,
            swap: GIB,
        };
        assert_eq!(system(MEMINFO), Some(free));
        assert_eq!(system("MemTotal: 5 kB\n"), None, "an old system");
        let without_swap = system("MemAvailable: 1024 kB\n");
        assert_eq!(
            without_swap.map(|free| (free.memory, free.swap)),
            Some((1 << 20, 0))
        );
    }

    #[test]
    fn groups_have_what_their_limit_leaves_but_for_files() {
        let stat = "anon 5\ninactive_file 1000\nactive_file 200\nfile 9999\n";
        assert_eq!(left_in_group("8000\n", "3000\n", stat), Some(6200));
        assert_eq!(left_in_group("8000\n", "", ""), Some(8000));
        assert_eq!(left_in_group("8000\n", "9500\n", ""), Some(0));
        assert_eq!(left_in_group("max\n", "3000\n", stat), None);
        let first = "cache 7\ninactive_file 1\nactive_file 2\ntotal_inactive_file 1000\ntotal_active_file 200\n";
        assert_eq!(left_in_group("8000\n", "3000\n", first), Some(6200));
    }

    #[test]
    fn the_least_of_all_limits_counts() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let write = |path: &str, text: &str| {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().expect("it has one")).expect("there is room");
            std::fs::write(path, text).expect("there is room");
        };
        let free = || on_host(folder.path()).map(|free| (free.memory, free.swap));
        assert_eq!(free(), None, "not known");
        write("proc/meminfo", MEMINFO);
        assert_eq!(free(), Some((16 * GIB, GIB)));
        // No limit, as either version writes it.
        write("sys/fs/cgroup/memory.max", "max\n");
        write(
            "sys/fs/cgroup/memory/memory.limit_in_bytes",
            "9223372036854771712\n",
        );
        assert_eq!(free(), Some((16 * GIB, GIB)));
        write("sys/fs/cgroup/memory/memory.limit_in_bytes", "8589934592\n");
        assert_eq!(free(), Some((8 * GIB, 0)));
        write("sys/fs/cgroup/memory.max", "4294967296\n");
        write("sys/fs/cgroup/memory.current", "1073741824\n");
        assert_eq!(free(), Some((3 * GIB, 0)));
        // The limits of a job, by either version, and of the groups around it.
        write("proc/self/cgroup", "0::/jobs/job_7/step\n");
        write("sys/fs/cgroup/jobs/job_7/memory.max", "2147483648\n");
        assert_eq!(free(), Some((2 * GIB, 0)));
        write(
            "proc/self/cgroup",
            "3:cpu:/other\n4:memory,hugetlb:/job_8\n",
        );
        write("sys/fs/cgroup/memory/other/memory.limit_in_bytes", "5\n");
        write(
            "sys/fs/cgroup/memory/job_8/memory.limit_in_bytes",
            "1073741824\n",
        );
        assert_eq!(free(), Some((GIB, 0)));
    }
}
