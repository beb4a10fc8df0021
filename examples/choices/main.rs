//! What else could have been built, beside what was: walks, deposits and how the trail is bound, timed on the same particles in
//! the same run. Prints a table, and leaves it as choices.txt, choices.json and SVGs in a folder.
//!
//! `cargo run --release --example choices -- --help`
//!
//! The kernels are in `shaders/choices/`, their twins in `twins.rs`; `tests/kernels/choices.rs` compares the two.

mod bars;
mod differences;
mod tables;
mod ways;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use clap::Parser;
// What the build generates names `crate::gpu`.
use myxo::gpu::{Context, ContextOptions, Format, Frames, Timings};
use myxo::scene::settings::Start;
use myxo::scene::{Overrides, Scene};
use myxo::sim::{Setup, Simulation};
use myxo::{Error, Result, gpu};
use serde_json::{Value, json};

use bars::Bar;
use differences::Found;
use ways::{DEPOSITS, READINGS, STEP, State, TO_A_SENSOR, WAYS, Way, Ways};

/// Rounds that are not measured: the first compiles.
const UNTIMED: u32 = 2;
/// Rounds that are measured: at most, and however long they take.
const ROUNDS: u32 = 64;
const FEWEST: u32 = 3;
/// Steps until particles have been sorted three times, and networks begin to form.
const SORTED: u32 = 34;
/// The steps after which particles that have begun at one place are still crowded there.
const CROWDED: u32 = 1;

/// Times other ways to walk, to deposit and to read the trail beside the program's own, and says how their results differ
#[derive(Parser)]
#[command(name = "choices")]
struct Options {
    /// Fewer particles and rounds: half a minute on two cores
    #[arg(long)]
    quick: bool,
    /// The folder for the table and the plots
    #[arg(long, value_name = "DIR", default_value = "bench-results")]
    out: PathBuf,
    /// Measures each case so many times, in turn with the others: 3, with --quick 2
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: Option<u32>,
    /// Sets a key of all scenes; `myxo scenes --keys` lists them. May be repeated
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Computes on this device: its number or a part of its name, as `myxo info` lists them
    #[arg(long, value_name = "N|NAME")]
    device: Option<String>,
}

/// A state on which ways are compared, and what was measured.
struct Case {
    name: &'static str,
    warmup: u32,
    setup: Setup,
    state: State,
    ways: Ways,
    compared: Vec<Measured>,
    timings: Timings,
}

/// A way, and what is known of it.
struct Measured {
    way: &'static Way,
    found: Found,
    /// The median of each run.
    runs_ms: Vec<f64>,
}

fn main() {
    if let Err(error) = run(&Options::parse()) {
        eprintln!("choices: {error}");
        std::process::exit(1);
    }
}

fn run(options: &Options) -> Result<()> {
    let ctx = Context::new(&ContextOptions {
        device: options.device.clone(),
        timeout: Duration::from_secs(900),
        ..ContextOptions::default()
    })?;
    let name = &ctx.info().name;
    if !ctx.info().has_timestamps() || !Format::R32Float.blends(&ctx) {
        return Err(Error::Invalid(format!(
            "{name} has no timestamps or cannot blend 32-bit floats: choose another device by --device"
        )));
    }
    let runs = options.runs.unwrap_or(if options.quick { 2 } else { 3 });
    let seconds = Duration::from_secs_f64(if options.quick { 0.5 } else { 5.0 });
    let mut cases = cases(&ctx, options)?;
    for number in 0..runs {
        for case in &mut cases {
            eprintln!("run {} of {runs}: {}", number + 1, case.name);
            case.measure(&ctx, seconds)?;
        }
    }
    let points: Vec<Point> = cases.iter().flat_map(Case::points).collect();
    let command: Vec<String> = std::env::args().skip(1).collect();
    let head = json!({
        "suite": "choices",
        "command": format!("choices {}", command.join(" ")).trim_end(),
        "version": env!("CARGO_PKG_VERSION"),
        "commit": myxo::commit(),
        "device": name,
        "driver": format!("{} {}", ctx.info().driver, ctx.info().driver_version),
        "quick": options.quick,
        "runs": runs,
        "method": format!(
            "{runs} runs of each case, in turn with the others: all ways in turn, up to {ROUNDS} times ({:.1} s at most), by the \
             device's timestamps; medians of all rounds; intervals by ranks, and at least from the lowest to the highest median \
             of a run; off: how far, straight through space, from where a walk in double precision ends, in parts of the way; \
             differs: from readings by the program's own way, in parts of the mean reading",
            seconds.as_secs_f64()
        ),
    });
    let text = text(&head, &points);
    print!("{text}");
    fs::create_dir_all(&options.out).map_err(|source| failure("create", &options.out, source))?;
    let write = |name: &str, content: &str| {
        let file = options.out.join(name);
        fs::write(&file, content).map_err(|source| failure("write", &file, source))
    };
    write("choices.txt", &text)?;
    for (name, title, all) in PICTURES {
        write(
            &format!("choices_{name}.svg"),
            &bars::svg(title, "median, ns a particle", &bars_of(&points, all)),
        )?;
    }
    let mut json = head;
    json["plots"] = PICTURES
        .map(|(name, _, _)| format!("choices_{name}.svg"))
        .into();
    json["points"] = points.iter().map(Point::json).collect();
    write("choices.json", &format!("{json}\n"))
}

fn failure(action: &'static str, path: &Path, source: std::io::Error) -> Error {
    Error::Io {
        action,
        path: path.to_owned(),
        source,
    }
}

/// What each scene comes to, with the ways that are compared on it.
fn cases(ctx: &Arc<Context>, options: &Options) -> Result<Vec<Case>> {
    let many = if options.quick { 100_000 } else { 500_000 };
    let all = [STEP, TO_A_SENSOR, DEPOSITS, READINGS];
    let own = [
        ("torus", "torus", many, SORTED, &all[..]),
        ("cube", "cube", many, SORTED, &all),
        ("even", "torus", 30_000, CROWDED, &[DEPOSITS]),
        ("crowd", "torus", 30_000, CROWDED, &[DEPOSITS]),
    ];
    let case = |(name, scene, count, warmup, of): (&'static str, &str, u32, u32, &[&str])| {
        let set = [format!("particles.count={count}")].into_iter();
        let overrides = Overrides {
            set: set.chain(options.set.iter().cloned()).collect(),
            ..Overrides::default()
        };
        let mut settings = Scene::read(scene.as_ref(), &overrides)?.1;
        if name == "crowd" {
            settings.particles.start = Start::Point;
        }
        let scene = Scene::from_settings(name.to_owned(), settings, PathBuf::new())?;
        let mut simulation = Simulation::new(ctx, &scene)?;
        let mut frames = Frames::new(ctx, 2)?;
        for _ in 0..warmup {
            let mut rec = frames.begin()?;
            simulation.record_step(&mut rec);
            frames.submit(rec)?;
        }
        frames.wait_idle()?;
        let snapshot = simulation.snapshot()?;
        let state = State {
            particles: snapshot.particles,
            motions: snapshot.motions,
            trail: snapshot.trail,
        };
        let setup = simulation.setup().clone();
        let ways = Ways::new(ctx, simulation.settings(), &setup, &state)?;
        let compared = WAYS.iter().filter(|way| of.contains(&way.of));
        let compared = compared.map(|way| {
            Ok(Measured {
                way,
                found: differences::of(way, &ways, &setup, &state)?,
                runs_ms: Vec::new(),
            })
        });
        Ok(Case {
            name,
            warmup,
            compared: compared.collect::<Result<_>>()?,
            setup,
            state,
            ways,
            timings: Timings::default(),
        })
    };
    own.into_iter().map(case).collect()
}

impl Case {
    /// Measures all ways in turn, again and again.
    fn measure(&mut self, ctx: &Arc<Context>, seconds: Duration) -> Result<()> {
        let mut frames = Frames::new(ctx, 2)?;
        let mut all: Vec<&Way> = self.compared.iter().map(|measured| measured.way).collect();
        let mut begun = Instant::now();
        for round in 0..UNTIMED + ROUNDS {
            if round == UNTIMED {
                frames.wait_idle()?;
                frames.timings_mut().clear();
                begun = Instant::now();
            }
            if round >= UNTIMED + FEWEST && begun.elapsed() > seconds {
                break;
            }
            let mut rec = frames.begin()?;
            rec.scope("round", |rec| {
                all.iter().for_each(|way| self.ways.record(rec, way.does));
            });
            frames.submit(rec)?;
            // Forwards and backwards in turn, and from the next one each time: none always comes after the same other one,
            // nor last while the machine becomes slower.
            all.reverse();
            if round.is_multiple_of(2) {
                all.rotate_left(1);
            }
        }
        frames.wait_idle()?;
        let report = frames.timings().report("round");
        for measured in &mut self.compared {
            let row = row(&report, measured.way);
            measured.runs_ms.extend(row.map(|row| row.time.median_ms));
        }
        let mut timings = frames.timings().clone();
        timings.prepend(&self.timings);
        self.timings = timings;
        Ok(())
    }

    fn points(&self) -> Vec<Point> {
        let report = self.timings.report("round");
        let point = |measured: &Measured| {
            let mut time = row(&report, measured.way)?.time;
            for &median in &measured.runs_ms {
                time.median_low_ms = time.median_low_ms.min(median);
                time.median_high_ms = time.median_high_ms.max(median);
            }
            Some(Point {
                way: measured.way,
                series: format!("{}, {}: {}", self.name, measured.way.of, measured.way.how),
                particles: self.state.particles.len(),
                atlas_size: self.setup.atlas.size,
                triangles: self.setup.surface.triangles.len(),
                warmup: self.warmup,
                rounds: report.steps,
                runs_ms: measured.runs_ms.clone(),
                time,
                found: measured.found.clone(),
            })
        };
        self.compared.iter().filter_map(point).collect()
    }
}

fn row<'a>(report: &'a gpu::Report, way: &Way) -> Option<&'a gpu::Row> {
    report.rows.iter().find(|row| row.name == way.kernel)
}

/// What was measured of a way on a state.
struct Point {
    way: &'static Way,
    series: String,
    particles: usize,
    /// Texels along a side.
    atlas_size: u32,
    triangles: usize,
    warmup: u32,
    /// Of all runs together.
    rounds: usize,
    runs_ms: Vec<f64>,
    time: gpu::Statistics,
    found: Found,
}

impl Point {
    /// Nanoseconds a particle: the median, and from where to where it may lie.
    fn each(&self) -> [f64; 3] {
        let time = &self.time;
        [time.median_ms, time.median_low_ms, time.median_high_ms]
            .map(|ms| 1e6 * ms / self.particles as f64)
    }

    fn json(&self) -> Value {
        let found = self.found.iter();
        let mut found: serde_json::Map<String, Value> = found
            .map(|(what, value)| ((*what).to_owned(), json!(value)))
            .collect();
        found.insert("ns a particle".to_owned(), json!(self.each()[0]));
        json!({
            "series": self.series,
            "particles": self.particles,
            "atlas_size": self.atlas_size,
            "triangles": self.triangles,
            "warmup": self.warmup,
            "steps": self.rounds,
            "runs_ms": self.runs_ms,
            "time": {
                "mean_ms": self.time.mean_ms,
                "median_ms": self.time.median_ms,
                "p95_ms": self.time.p95_ms,
                "std_ms": self.time.std_ms,
                "min_ms": self.time.min_ms,
                "max_ms": self.time.max_ms,
                "median_low_ms": self.time.median_low_ms,
                "median_high_ms": self.time.median_high_ms,
            },
            "found": found,
        })
    }
}

/// For people: what was measured where, and the table.
fn text(head: &Value, points: &[Point]) -> String {
    let word = |key: &str| head[key].as_str().unwrap_or("unknown").to_owned();
    let mut text = format!(
        "choices: what else could have been built, beside what was\ndevice {}, driver {}\nversion {}, commit {}, command {}\n{}\n\n",
        word("device"),
        word("driver"),
        word("version"),
        word("commit"),
        word("command"),
        word("method").replace("; ", "\n")
    );
    text += &format!(
        "{:<45}{:>10}{:>11}{:>22}{:>8}  found\n",
        "way", "particles", "median ms", "ns a particle", "rounds"
    );
    for point in points {
        let [each, low, high] = point.each();
        let found = point.found.iter();
        let found: Vec<String> = found
            .map(|(what, value)| format!("{what} {}", digits(*value)))
            .collect();
        text += &format!(
            "{:<45}{:>10}{:>11.3}{:>22}{:>8}  {}\n",
            point.series,
            point.particles,
            point.time.median_ms,
            format!("{each:.1} ({low:.1}-{high:.1})"),
            point.rounds,
            found.join(", ")
        );
    }
    text
}

fn digits(value: f64) -> String {
    match value {
        0.0 => "0".to_owned(),
        small if small < 1e-3 => format!("{small:.1e}"),
        part if part < 1.0 => format!("{part:.4}"),
        whole => format!("{}", (10.0 * whole).round() / 10.0),
    }
}

/// One picture for walks, one for deposits, one for readings: name, title, what is compared.
const PICTURES: [(&str, &str, &[&str]); 3] = [
    (
        "walks",
        "Straight walks by two edge tests, and how far off they end",
        &[STEP, TO_A_SENSOR],
    ),
    ("deposits", "Particles counted in texels", &[DEPOSITS]),
    (
        "readings",
        "Three bilinear readings, with the trail bound in five ways",
        &[READINGS],
    ),
];

fn bars_of(points: &[Point], all: &[&str]) -> Vec<Bar> {
    let own = points.iter().filter(|point| all.contains(&point.way.of));
    own.map(|point| {
        let [value, low, high] = point.each();
        let notes = [
            ("off: p95", " off (95 %)"),
            ("most in a texel", " in a texel at most"),
            ("differs: p95", " of the mean off (95 %)"),
        ];
        let note = point.found.iter().find_map(|(what, value)| {
            let (_, words) = notes.iter().find(|(of, _)| of == what)?;
            (*value > 0.0).then(|| format!(", {}{words}", digits(*value)))
        });
        let kin = WAYS.iter().filter(|way| way.of == point.way.of);
        Bar {
            name: point.series.clone(),
            color: (kin.map(|way| way.kernel))
                .position(|kernel| kernel == point.way.kernel)
                .unwrap_or_default(),
            value,
            low,
            high,
            note: format!("{value:.1}{}", note.unwrap_or_default()),
        }
    })
    .collect()
}
