//! The host that a measurement runs on: its processor, the command line, and its load by other programs.

use std::time::Instant;

use serde::{Deserialize, Serialize};

/// If other programs take more than this part of all processors, times are not worth comparing.
const BUSY: f64 = 0.1;
/// The load per core above which times are not worth comparing, on systems that do not report processor time.
const BUSY_LOAD: f64 = 0.6;

/// How busy the host's processors were during a measurement. Parts of all cores, 0 to 1; `null` if the system does not report them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HostLoad {
    /// The load average of the minute before, per core.
    pub before_per_core: Option<f64>,
    /// Taken by this program; software drivers compute within it.
    pub own: Option<f64>,
    /// Taken by all other programs.
    pub others: Option<f64>,
    /// Time that the hypervisor of a virtual machine has kept (steal).
    pub stolen: Option<f64>,
    /// Was the host so busy that times are not worth comparing? Other programs took more than a tenth; or, if that is not known, the load
    /// before was above 0.6 per core.
    pub is_busy: bool,
}

impl HostLoad {
    /// A warning about a busy host.
    pub fn warning(&self) -> Option<String> {
        let (what, part) = match (self.others, self.stolen, self.before_per_core) {
            _ if !self.is_busy => return None,
            (Some(others), Some(stolen), _) if stolen > others => {
                ("the machine below has kept", stolen)
            }
            (Some(others), ..) => ("other programs have taken", others),
            (None, _, load) => {
                let load = load.unwrap_or_default();
                return Some(format!(
                    "the machine was busy: its load was {load:.1} a core; these times are not worth comparing"
                ));
            }
        };
        Some(format!(
            "the machine was busy: {what} {:.0} % of its processors; these times are not worth comparing",
            100.0 * part
        ))
    }
}

/// Processor time so far, in ticks of the system's clock, summed over all cores.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Ticks {
    /// Of all programs.
    busy: u64,
    idle: u64,
    stolen: u64,
    own: u64,
}

/// Watches the host while times are taken.
pub struct Watch {
    before_per_core: Option<f64>,
    sums: Ticks,
    since: Option<Ticks>,
    begun: Instant,
}

impl Watch {
    /// Create it before the warm-up, which adds load of its own.
    pub fn new() -> Self {
        Self {
            before_per_core: load_average().map(|[minute, ..]| minute / cores()),
            sums: Ticks::default(),
            since: None,
            begun: Instant::now(),
        }
    }

    /// The measurement begins.
    pub fn begin(&mut self) {
        self.since = ticks();
        self.begun = Instant::now();
    }

    /// The measurement ends.
    pub fn end(&mut self) {
        // The clock ticks a hundred times a second, which is too coarse for shorter measurements.
        if self.begun.elapsed().as_millis() < 100 {
            self.since = None;
        }
        if let (Some(since), Some(now)) = (self.since.take(), ticks()) {
            self.sums.busy += now.busy.saturating_sub(since.busy);
            self.sums.idle += now.idle.saturating_sub(since.idle);
            self.sums.stolen += now.stolen.saturating_sub(since.stolen);
            self.sums.own += now.own.saturating_sub(since.own);
        }
    }

    /// The load so far.
    pub fn load(&self) -> HostLoad {
        load(self.before_per_core, self.sums)
    }
}

fn load(before_per_core: Option<f64>, sums: Ticks) -> HostLoad {
    // Systems that sample busy cores at each tick, but time every thread exactly, may report less for the whole than for a part.
    let busy = sums.busy.max(sums.own);
    let all = (busy + sums.idle + sums.stolen) as f64;
    let part = |ticks: u64| (all > 0.0).then(|| ticks as f64 / all);
    let others = part(busy - sums.own);
    let stolen = part(sums.stolen);
    let is_busy = match (others, stolen) {
        (Some(others), Some(stolen)) => others + stolen > BUSY,
        _ => before_per_core.is_some_and(|load| load > BUSY_LOAD),
    };
    HostLoad {
        before_per_core,
        own: part(sums.own),
        others,
        stolen,
        is_busy,
    }
}

fn ticks() -> Option<Ticks> {
    let system = std::fs::read_to_string("/proc/stat").ok()?;
    let own = std::fs::read_to_string("/proc/self/stat").ok()?;
    parse(&system, &own)
}

/// From the texts of `/proc/stat` and `/proc/self/stat`.
fn parse(system: &str, own: &str) -> Option<Ticks> {
    // user nice system idle iowait irq softirq steal
    let line = system.lines().find(|line| line.starts_with("cpu "))?;
    let words = line.split_whitespace().skip(1).take(8);
    let all: Vec<u64> = words.map_while(|word| word.parse().ok()).collect();
    let [user, nice, kernel, idle, wait, irq, soft, stolen] = all[..] else {
        return None;
    };
    // The program's name stands in brackets and may hold blanks; state is the first word behind it, utime the twelfth.
    let (_, behind) = own.rsplit_once(')')?;
    let mut words = behind.split_whitespace().skip(11);
    let mut next = || words.next()?.parse::<u64>().ok();
    let (utime, stime) = (next()?, next()?);
    let busy = user + nice + kernel + irq + soft;
    (busy > 0).then_some(Ticks {
        busy,
        idle: idle + wait,
        stolen,
        own: utime + stime,
    })
}

fn cores() -> f64 {
    std::thread::available_parallelism().map_or(1.0, |cores| cores.get() as f64)
}

/// The command line, quoted so that a shell takes it back.
pub fn command() -> String {
    let words: Vec<String> = std::env::args_os()
        .map(|word| {
            let word = word.to_string_lossy().into_owned();
            let plain = |c: char| c.is_ascii_alphanumeric() || "-_=+./:,@%".contains(c);
            if !word.is_empty() && word.chars().all(plain) {
                word
            } else {
                format!("'{}'", word.replace('\'', "'\\''"))
            }
        })
        .collect();
    words.join(" ")
}

/// The processor's name and how many threads it runs.
pub fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let name = |key: &str| {
        text.lines()
            .find(|line| line.starts_with(key))?
            .split_once(':')
            .map(|(_, name)| name.trim())
    };
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let model = name("model name").or_else(|| name("Model"))?;
    Some(format!("{model} ({cores} threads)"))
}

/// Over 1, 5 and 15 minutes.
pub fn load_average() -> Option<[f64; 3]> {
    let text = std::fs::read_to_string("/proc/loadavg").ok()?;
    let numbers: Vec<f64> = text
        .split_whitespace()
        .take(3)
        .map_while(|word| word.parse().ok())
        .collect();
    numbers.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_read_as_the_system_writes_them() {
        let system = "cpu  100 20 30 400 50 6 7 8 0 0\ncpu0 1 1 1 1 1 1 1 1 0 0\n";
        let own = "7108 (a (b) c) R 1 2 3 0 -1 4194304 102 0 0 0 11 22 0 0 20 0 1";
        let ticks = parse(system, own).expect("it is well formed");
        let expected = Ticks {
            busy: 163,
            idle: 450,
            stolen: 8,
            own: 33,
        };
        assert_eq!(ticks, expected);
        assert_eq!(parse("cpu 1 2\n", own), None);
        assert_eq!(parse(system, "7108 (x) R"), None);
        let zeros = "cpu  0 0 0 0 0 0 0 0 0 0\n";
        assert_eq!(parse(zeros, own), None, "some systems hide it");
    }

    #[test]
    fn others_make_a_host_busy_and_own_work_does_not() {
        let sums = |busy, own, stolen| Ticks {
            busy,
            idle: 1000 - busy - stolen,
            stolen,
            own,
        };
        let alone = load(Some(3.0), sums(900, 890, 0));
        assert!(!alone.is_busy && alone.warning().is_none());
        assert_eq!(alone.others, Some(0.01));
        let shared = load(None, sums(900, 500, 0));
        let warning = shared.warning().expect("it is busy");
        assert!(
            warning.contains("other programs have taken 40 % of its"),
            "{warning}"
        );
        let below = load(None, sums(500, 500, 300)).warning();
        let below = below.expect("it is busy");
        assert!(below.contains("below has kept 30 %"), "{below}");
        // Own time is counted more finely than that of the whole.
        let fine = load(
            None,
            Ticks {
                busy: 29,
                idle: 0,
                stolen: 0,
                own: 30,
            },
        );
        assert_eq!((fine.own, fine.others), (Some(1.0), Some(0.0)));
        // Only the load before is known.
        assert!(!load(Some(0.5), Ticks::default()).is_busy);
        let loaded = load(Some(1.5), Ticks::default()).warning();
        let loaded = loaded.expect("it is busy");
        assert!(loaded.contains("load was 1.5 a core"), "{loaded}");
    }

    #[test]
    fn a_watch_counts_only_between_begin_and_end() {
        let mut watch = Watch::new();
        watch.end();
        assert_eq!(watch.sums, Ticks::default());
        watch.begin();
        let begun = Instant::now();
        let mut sum = 0.0_f64;
        while begun.elapsed().as_millis() < 150 {
            sum += sum.cos();
        }
        assert!(sum.is_finite());
        watch.end();
        let load = watch.load();
        if let (Some(own), Some(others)) = (load.own, load.others) {
            assert!(own > 0.0 && own + others <= 1.0 + 1e-9, "{load:?}");
        }
    }
}
