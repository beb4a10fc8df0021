//! Long runs of the built-in scenes by every strategy: equal hashes, twice and after an interruption, and no particle lost.
//!
//! Ignored tests take long; `make long` runs them, and one writes `benches/results/strategies.md`. The other tests do the same
//! with few steps, and with the validation layers on.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use crate::common::{COARSE_TRIO, coarse_crowd, gpu, set_up};
use crate::program::{Folder, done, no_device, path, report, small_pair};
use myxo::gpu::{Context, ContextOptions, Frames, default_cache_folder};
use myxo::scene::settings::Strategy;
use myxo::scene::{Overrides, Scene};
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::types::Flow;
use myxo::sim::{Setup, Simulation, Snapshot, twin};

/// How much is run.
#[derive(Clone, Copy)]
struct Length {
    steps: u64,
    particles: u32,
    atlas: u32,
    /// What else of the scene is changed.
    set: &'static [&'static str],
    /// Whether `trio` and `crowd` have coarse meshes, which are laid out in a moment.
    is_coarse: bool,
    /// Whether strategies that must end as another one did run twice as well: that they end alike says it already.
    all_twice: bool,
}

const SHORT: Length = Length {
    steps: 8,
    particles: 3000,
    atlas: 192,
    // Otherwise hardly any particle would change objects so soon.
    set: &["transfer.threshold=0.002"],
    is_coarse: true,
    all_twice: false,
};

/// Of 64 objects.
const SHORT_CROWD: Length = Length { steps: 4, ..SHORT };

const LONG: Length = Length {
    steps: 1000,
    particles: 20_000,
    atlas: 512,
    set: &[],
    is_coarse: false,
    all_twice: true,
};

/// For the check that no particle is lost in ten thousand steps, for which a small atlas suffices.
const LONGEST: Length = Length {
    steps: 10_000,
    atlas: 256,
    ..LONG
};

/// Enough particles on the wheels that a buffer of 16 overflows without changes of the scene, too.
const FULL: Length = Length {
    steps: 1000,
    particles: 80_000,
    ..LONGEST
};

/// Of 64 objects, all of which move.
const CROWD: Length = Length { steps: 100, ..LONG };

/// They differ in how they keep the buffer, and end alike.
const THAT_TRANSFER: [Strategy; 4] = [
    Strategy::Scattered,
    Strategy::Sequential,
    Strategy::Parallel,
    Strategy::Direct,
];

/// A built-in scene with these settings and others.
fn scene(name: &str, length: Length, strategy: Strategy, others: &[&str]) -> Scene {
    let mut set = vec![
        format!("particles.count={}", length.particles),
        format!("atlas.size={}", length.atlas),
        format!("transfer.strategy={}", strategy.word()),
    ];
    set.extend(match name {
        "trio" if length.is_coarse => COARSE_TRIO.map(str::to_owned).to_vec(),
        "crowd" if length.is_coarse => coarse_crowd(1),
        _ => Vec::new(),
    });
    let others = length.set.iter().chain(others);
    set.extend(others.map(|&other| other.to_owned()));
    let overrides = Overrides {
        set,
        ..Overrides::default()
    };
    Scene::load(Path::new(name), &overrides).unwrap()
}

/// Runs up to a step and checks everything after each one.
fn advance(ctx: &Arc<Context>, simulation: &mut Simulation, to: u64) -> Snapshot {
    let mut frames = Frames::new(ctx, 2).unwrap();
    while simulation.step() < to {
        frames.run(|rec| simulation.record_step(rec)).unwrap();
        let state = simulation.snapshot().unwrap();
        state.validate(simulation.setup()).unwrap();
    }
    frames.wait_idle().unwrap();
    simulation.snapshot().unwrap()
}

/// What one strategy did on a scene.
struct Row {
    strategy: Strategy,
    /// Of the first run.
    hash: u64,
    /// Of a second run, and of one that was resumed from a file half way.
    again: [Option<u64>; 2],
    flow: Flow,
    flux: Vec<u32>,
}

fn row(ctx: &Arc<Context>, scene: &Scene, setup: &Setup, length: Length) -> Row {
    let start = || Simulation::from_setup(ctx, scene, setup.clone()).unwrap();
    let Length { steps, .. } = length;
    let strategy = scene.settings.transfer.strategy;
    let mut run = start();
    let half = advance(ctx, &mut run, steps / 2);
    let first = advance(ctx, &mut run, steps);
    drop(run);

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("half.state");
    let checkpoint = Checkpoint::new(scene, setup, half);
    checkpoint.write(&file).unwrap();
    let mut resumed = start();
    let checkpoint = Checkpoint::read(&file).unwrap();
    checkpoint.check(scene, setup).unwrap();
    resumed.restore(&checkpoint.snapshot).unwrap();

    let resumed = advance(ctx, &mut resumed, steps);
    let twice = length.all_twice || !THAT_TRANSFER[1..].contains(&strategy);
    let second = twice.then(|| advance(ctx, &mut start(), steps));
    let again = [second, Some(resumed)].map(|end| {
        end.map(|end| {
            assert_eq!(end.transfers.flux, first.transfers.flux, "{strategy:?}");
            end.hash()
        })
    });
    Row {
        strategy,
        hash: first.hash(),
        again,
        flow: first.transfers.flow,
        flux: first.transfers.flux,
    }
}

/// Runs all strategies on a scene, and asserts what must be equal.
fn rows(ctx: &Arc<Context>, name: &str, length: Length) -> Vec<Row> {
    let strategies = Strategy::ALL.iter();
    // It is the same for all strategies.
    let setup = set_up(ctx, &scene(name, length, Strategy::None, &[]));
    let rows: Vec<Row> = strategies
        .map(|&strategy| {
            let row = row(ctx, &scene(name, length, strategy, &[]), &setup, length);
            let (first, [second, resumed]) = (row.hash, row.again);
            assert_eq!(
                second.unwrap_or(first),
                first,
                "{name}, {strategy:?}: two runs"
            );
            assert_eq!(resumed, Some(first), "{name}, {strategy:?}: resumed");
            assert_eq!(row.flow.refused, 0, "{name}, {strategy:?}");
            eprintln!("{name}, {}: {first:016x}", strategy.word());
            row
        })
        .collect();
    let alike: Vec<&Row> = rows
        .iter()
        .filter(|row| THAT_TRANSFER.contains(&row.strategy))
        .collect();
    assert_eq!(alike.len(), 4);
    for row in &alike {
        assert_eq!(row.hash, alike[0].hash, "{:?}", row.strategy);
        assert_eq!(row.flux, alike[0].flux, "{:?}", row.strategy);
        assert!(row.flow.arrived > 0);
    }
    rows
}

/// The hashes of a scene's strategies, and the transfers between its objects.
fn section(name: &str, length: Length, rows: &[Row]) -> String {
    let objects = scene(name, length, Strategy::None, &[]).settings.objects;
    let mut text = format!(
        "\n## `{name}`, {} steps\n\n\
         | strategy | first run | second run | interrupted at {}, resumed | selected | arrived |\n\
         | --- | --- | --- | --- | --: | --: |\n",
        length.steps,
        length.steps / 2
    );
    for row in rows {
        let first = row.hash;
        let [second, resumed] = row.again.map(|hash| hash.unwrap_or(first));
        let Flow {
            selected, arrived, ..
        } = row.flow;
        writeln!(
            text,
            "| `{}` | `{first:016x}` | `{second:016x}` | `{resumed:016x}` | {selected} | {arrived} |",
            row.strategy.word()
        )
        .unwrap();
    }
    for row in rows.iter().filter(|row| row.strategy == Strategy::Parallel) {
        if objects.len() > MOST_COLUMNS {
            writeln!(text, "\n{}", in_words(row, objects.len())).unwrap();
            continue;
        }
        let names: Vec<&str> = objects.iter().map(|object| object.name.as_str()).collect();
        writeln!(
            text,
            "\nParticles that left, `{}`, from (rows) to (columns):\n\n| | {} |\n| --- |{}",
            row.strategy.word(),
            names.join(" | "),
            " --: |".repeat(names.len())
        )
        .unwrap();
        for (name, counts) in names.iter().zip(row.flux.chunks(names.len())) {
            let counts: Vec<String> = counts.iter().map(u32::to_string).collect();
            writeln!(text, "| {name} | {} |", counts.join(" | ")).unwrap();
        }
    }
    text
}

/// Most objects in a table of transfers.
const MOST_COLUMNS: usize = 12;

/// The transfers between objects as text, where there are too many pairs for a table.
fn in_words(row: &Row, objects: usize) -> String {
    let pairs = row.flux.iter().enumerate();
    let pairs = || pairs.clone().filter(|(_, count)| **count > 0);
    let most = pairs().map(|(_, count)| *count).max().unwrap_or(0);
    let both = pairs().filter(|(pair, _)| row.flux[pair % objects * objects + pair / objects] > 0);
    format!(
        "By `{}` {} particles left, over {} of {} ordered pairs of objects, {most} over one at the most; {} of these pairs \
         were used both ways.",
        row.strategy.word(),
        row.flux.iter().sum::<u32>(),
        pairs().count(),
        objects * (objects - 1),
        both.count()
    )
}

/// With these settings, a buffer of 16 transfers is often full. In the unchanged scene few teeth of wheels touch at once, and it is seldom
/// full.
const CROWDED: [&str; 2] = ["transfer.threshold=0.002", "transfer.buffer_size=16"];

/// The unchanged scene with another buffer: sometimes more particles are selected than it holds.
const FULL_AT_TIMES: [&str; 1] = [CROWDED[1]];

/// Counts lost and doubled particles, also with a full buffer: `gears` by strategy and other settings.
fn populations(ctx: &Arc<Context>, length: Length, cases: &[(Strategy, &[&str])]) -> String {
    let mut text = format!(
        "\n## `gears`, {} steps, {} particles: census\n\n\
         | strategy | `transfer.threshold` | `transfer.buffer_size` | lost | doubled | selected | refused | size that would have done |\n\
         | --- | --: | --: | --: | --: | --: | --: | --: |\n",
        length.steps, length.particles
    );
    let setup = set_up(ctx, &scene("gears", length, Strategy::None, &[]));
    for &(strategy, others) in cases {
        let scene = scene("gears", length, strategy, others);
        let transfer = &scene.settings.transfer;
        let mut simulation = Simulation::from_setup(ctx, &scene, setup.clone()).unwrap();
        let end = advance(ctx, &mut simulation, length.steps);
        let census = end.census();
        assert_eq!((census.lost, census.doubled), (0, 0));
        let Flow {
            selected,
            refused,
            most_wanted,
            ..
        } = end.transfers.flow;
        let overflows = !others.is_empty();
        assert_eq!(
            refused > 0,
            overflows,
            "{strategy:?}: {refused} of {selected}"
        );
        assert_eq!(most_wanted > transfer.buffer_size, overflows);
        writeln!(
            text,
            "| `{}` | {} | {} | {} | {} | {selected} | {refused} | {most_wanted} |",
            strategy.word(),
            transfer.threshold,
            transfer.buffer_size,
            census.lost,
            census.doubled
        )
        .unwrap();
    }
    text
}

/// The scene as it is, and with a buffer that is full time and again.
const POPULATIONS: [(Strategy, &[&str]); 2] =
    [(Strategy::Parallel, &[]), (Strategy::Parallel, &CROWDED)];

/// In ten thousand steps it is full as the scene is, too, with as few particles.
const LONGEST_POPULATIONS: [(Strategy, &[&str]); 3] = [
    POPULATIONS[0],
    (Strategy::Parallel, &FULL_AT_TIMES),
    POPULATIONS[1],
];

#[test]
fn strategies_agree_on_the_built_in_scenes() {
    let Some(gpu) = gpu() else { return };
    for (name, length) in [("trio", SHORT), ("gears", SHORT), ("crowd", SHORT_CROWD)] {
        rows(&gpu.ctx, name, length);
    }
    gpu.finish();
}

#[test]
fn no_particle_is_lost_where_the_buffer_is_full() {
    let Some(gpu) = gpu() else { return };
    // A quarter of the particles of the long run, and a quarter of its buffer.
    let crowded = [CROWDED[0], "transfer.buffer_size=4"];
    let full_at_times = [crowded[1]];
    let length = Length {
        steps: 10,
        particles: 5_000,
        set: &[],
        ..SHORT
    };
    let as_it_is: &[&str] = &[];
    let cases = [as_it_is, &crowded].map(|others| (Strategy::Parallel, others));
    populations(&gpu.ctx, length, &cases);
    let length = Length {
        particles: FULL.particles / 4,
        ..length
    };
    populations(
        &gpu.ctx,
        length,
        &THAT_TRANSFER.map(|s| (s, &full_at_times[..])),
    );
    gpu.finish();
}

/// The program says what the flow of a state says, so other strategies and scenes need no program.
#[test]
fn a_full_buffer_says_which_size_would_have_done() {
    let Some(gpu) = gpu() else { return };
    let length = Length {
        steps: 20,
        particles: 20_000,
        set: &[CROWDED[0]],
        ..SHORT
    };
    for (name, strategy) in [
        ("gears", Strategy::Scattered),
        ("gears", Strategy::Direct),
        ("trio", Strategy::Parallel),
    ] {
        let setup = set_up(&gpu.ctx, &scene(name, length, strategy, &[]));
        let run = |buffer_size: u32| {
            let set = format!("transfer.buffer_size={buffer_size}");
            let scene = scene(name, length, strategy, &[&set]);
            let mut simulation = Simulation::from_setup(&gpu.ctx, &scene, setup.clone()).unwrap();
            let transfers = advance(&gpu.ctx, &mut simulation, length.steps).transfers;
            let left: u32 = transfers.flux.iter().sum();
            assert_eq!(left, transfers.flow.arrived, "{name}, {strategy:?}");
            transfers.flow
        };
        let full = run(16);
        assert!(full.refused > 0 && full.most_wanted > 16, "{full:?}");
        let wide = run(full.most_wanted);
        assert_eq!(wide.refused, 0, "{name}, {strategy:?}");
    }
    gpu.finish();
}

#[test]
fn the_program_says_which_buffer_size_would_have_done() {
    if no_device() {
        return;
    }
    let folder = Folder::new();
    let pair = small_pair(&folder);
    let [written, state] = ["report.json", "state.npz"].map(|name| folder.file(name));
    let run = |buffer_size: &str| {
        let set = format!("transfer.buffer_size={buffer_size}");
        let crowded = ["--set", CROWDED[0], "--set", &set];
        let strategy = ["--set", "transfer.strategy=parallel"];
        let scene = ["export", path(&pair), "--steps", "10"];
        let many = ["--set", "particles.count=20000"];
        let into = ["--out", path(&state), "--report", path(&written)];
        let messages = done(&[&scene[..], &many, &crowded, &strategy, &into].concat());
        (messages, report(&written)["counters"].clone())
    };
    let (messages, counters) = run("16");
    let (_, advice) = messages
        .split_once("raise transfer.buffer_size from 16 to ")
        .expect(&messages);
    assert!(messages.contains("warning: transfers overflowed: "));
    let size = advice.split_whitespace().next().unwrap().replace(',', "");
    assert!(size.parse::<u32>().expect(advice) > 16);
    // The report has the same size, and the transfers between objects.
    assert_eq!(counters["transfer_buffer_wanted"].to_string(), size);
    assert!(counters["transfer_overflow"].as_u64() > Some(0));
    let flux = counters["flux"].as_array().expect("it is a list");
    assert!(flux.iter().all(|pair| pair["from"] != pair["to"]));
    let (messages, counters) = run(&size);
    assert!(!messages.contains("overflowed"), "{size}: {messages}");
    assert_eq!(counters["transfer_overflow"], 0);
    let flux = counters["flux"].as_array().expect("it is a list");
    let left = flux.iter().filter_map(|pair| pair["particles"].as_u64());
    let count = |key: &str| counters[key].as_u64().expect(key);
    assert_eq!(
        left.sum::<u64>() + count("returned"),
        count("transferred"),
        "what has left has arrived"
    );
}

/// Each part of the long run, in the order of the table: `MYXO_PARTS=crowd,full` takes some of them.
const PARTS: [&str; 5] = ["trio", "gears", "crowd", "population", "full"];

/// Writes what it finds to the file that `MYXO_TABLE` names, after each part. Parts that are not run stay as that file has
/// them.
#[test]
#[ignore = "takes an hour: make long"]
fn long_runs() {
    let ctx = Context::new(&ContextOptions {
        hazard_check: Some(true),
        cache_folder: default_cache_folder(),
        ..ContextOptions::default()
    })
    .unwrap();
    let info = ctx.info();
    let head = format!(
        "# Strategies\n\n\
         `make long` makes this file again, or parts of it (`MYXO_PARTS=crowd,full make long`). {} particles; atlas {} for the\n\
         hashes, {} for the population. `scattered`, `sequential`, `parallel` and `direct` must end in the same hash, and so must\n\
         all runs of one strategy.\n",
        LONG.particles, LONG.atlas, LONGEST.atlas
    );
    let file = std::env::var_os("MYXO_TABLE");
    let before = file.as_ref().map(std::fs::read_to_string);
    let before = before.and_then(Result::ok).unwrap_or_default();
    let mut texts = PARTS.map(|part| part_in(&before, part).to_owned());
    let wanted = std::env::var("MYXO_PARTS").unwrap_or_else(|_| PARTS.join(","));
    for wanted in wanted.split(',') {
        let place = PARTS.iter().position(|part| *part == wanted);
        let place = place.unwrap_or_else(|| panic!("{wanted} is none of {PARTS:?}"));
        let started = Instant::now();
        let part = match wanted {
            "population" => populations(&ctx, LONGEST, &LONGEST_POPULATIONS),
            "full" => populations(&ctx, FULL, &THAT_TRANSFER.map(|s| (s, &FULL_AT_TIMES[..]))),
            "crowd" => section("crowd", CROWD, &rows(&ctx, "crowd", CROWD)),
            name => section(name, LONG, &rows(&ctx, name, LONG)),
        };
        let minutes = started.elapsed().as_secs_f64() / 60.0;
        print!("{part}");
        texts[place] = format!(
            "\n{}{part}\nAll invariants were checked after every step. This took {minutes:.0} minutes on {} ({} {}).\n",
            mark(wanted),
            info.name,
            info.driver,
            info.driver_version
        );
        if let Some(file) = &file {
            std::fs::write(file, head.clone() + &texts.concat()).unwrap();
        }
    }
}

/// The marker of a part in the table.
fn mark(part: &str) -> String {
    format!("<!-- {part} -->")
}

/// A part of a table, with its mark; nothing where the table has none.
fn part_in<'a>(table: &'a str, part: &str) -> &'a str {
    let begin = format!("\n{}", mark(part));
    let Some(start) = table.find(&begin) else {
        return "";
    };
    let rest = &table[start + 1..];
    let end = rest.find("\n<!-- ").map_or(rest.len(), |end| end);
    &table[start..start + 1 + end]
}

#[test]
fn parts_of_the_table_that_are_not_run_stay() {
    let table = "# Head\n\n<!-- trio -->\n## a\n\nb\n\n<!-- crowd -->\n## c\n";
    assert_eq!(part_in(table, "trio"), "\n<!-- trio -->\n## a\n\nb\n");
    assert_eq!(part_in(table, "gears"), "");
    assert_eq!(part_in(table, "crowd"), "\n<!-- crowd -->\n## c\n");
}

/// A thousand steps on the device and by the twins: whatever differs between the two in one step of a thousand shows in the end.
#[test]
#[ignore = "takes ten minutes: make long"]
fn a_thousand_steps_end_in_the_same_bits_by_both_engines() {
    let Some(gpu) = gpu() else { return };
    for name in ["torus", "suzanne", "trio", "crowd"] {
        let overrides = Overrides {
            set: ["particles.count=20000", "atlas.size=512"]
                .map(str::to_owned)
                .to_vec(),
            ..Overrides::default()
        };
        let scene = Scene::load(Path::new(name), &overrides).unwrap();
        let mut simulation = Simulation::new(&gpu.ctx, &scene).unwrap();
        let setup = simulation.setup().clone();
        let mut host = twin::Simulation::new(setup, scene.settings.clone());
        for step in (100..=1000).step_by(100) {
            for _ in 0..100 {
                gpu.run(|rec| simulation.record_step(rec));
                host.step();
            }
            let device = simulation.snapshot().unwrap().hash();
            assert_eq!(device, host.snapshot().hash(), "{name}, step {step}");
        }
    }
    gpu.finish();
}
