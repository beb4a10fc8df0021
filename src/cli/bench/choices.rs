//! The suite `choices`: what else could have been built, beside what was, on the same particles in the same run.

mod differences;
mod ways;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

use myxo::gpu::{Frames, Timings};
use myxo::mesh::atlas::Control;
use myxo::scene::settings::Start;
use myxo::scene::{Scene, Settings};
use myxo::sim::{Simulation, memory};
use myxo::{Error, Result};

use super::bars::{Bar, Bars};
use super::measure::{Budget, Rig};
use super::suite::{Extent, Point, Skipped};
use super::suites::{SORTED, scene};
use crate::cli::host::Watch;
use crate::cli::interrupt;
use crate::cli::progress::Progress;
use crate::cli::report::{KernelTime, Times};
use ways::{Binding, Reach, Walking, Way, Ways, missing};

/// What was found out about a way besides its time.
pub type Found = BTreeMap<&'static str, f64>;

/// Rounds that are not measured: the first compiles.
const UNTIMED: u32 = 2;
/// Rounds that are measured at least.
const FEWEST: u32 = 3;
/// The steps after which particles that have begun at one place are still crowded there.
const CROWDED: u32 = 1;

/// Ways that do the same; the first is the program's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Comparison {
    Walks(Reach),
    Deposits,
    Readings,
}

const WALKINGS: [(Walking, &str); 3] = [
    (Walking::Exact, "exact edge test"),
    (Walking::Corrected, "corrected afterwards"),
    (Walking::CorrectedOnce, "corrected once"),
];
const READINGS: [Binding; 5] = [
    Binding::Texels,
    Binding::Block,
    Binding::StorageTexels,
    Binding::Image,
    Binding::Sampler,
];

impl Comparison {
    const ALL: [Self; 4] = [
        Self::Walks(Reach::Step),
        Self::Walks(Reach::Sensor),
        Self::Deposits,
        Self::Readings,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Walks(Reach::Step) => "step",
            Self::Walks(Reach::Sensor) => "way to a sensor",
            Self::Deposits => "deposits",
            Self::Readings => "readings",
        }
    }

    /// With what people call them.
    fn ways(self) -> Vec<(Way, &'static str)> {
        match self {
            Self::Walks(reach) => WALKINGS
                .map(|(walking, name)| (Way::Walk(reach, walking), name))
                .to_vec(),
            Self::Deposits => vec![(Way::Count, "atomic adds"), (Way::Draw, "drawn points")],
            Self::Readings => {
                let names = [
                    "texel buffer",
                    "storage block",
                    "storage texels",
                    "image",
                    "sampler",
                ];
                let all = READINGS.into_iter().zip(names);
                all.map(|(binding, name)| (Way::Read(binding), name))
                    .collect()
            }
        }
    }
}

/// A state on which ways are compared, and what was measured.
struct Compared {
    name: &'static str,
    settings: Settings,
    /// Steps before.
    warmup: u32,
    comparisons: &'static [Comparison],
    timings: Timings,
    /// For each kernel the median of each run.
    runs_ms: BTreeMap<&'static str, Vec<f64>>,
    found: BTreeMap<&'static str, Found>,
    points: Vec<Point>,
    skipped: Option<String>,
}

fn compared(extent: &Extent) -> Result<Vec<Compared>> {
    let many = extent.of("particles.count=100000", "particles.count=500000");
    let of = |name, scene_name, own: &str, warmup, comparisons| {
        Ok::<_, Error>(Compared {
            name,
            settings: scene(scene_name, &[own], extent)?,
            warmup,
            comparisons,
            timings: Timings::default(),
            runs_ms: BTreeMap::new(),
            found: BTreeMap::new(),
            points: Vec::new(),
            skipped: None,
        })
    };
    let few = "particles.count=30000";
    let deposits = &[Comparison::Deposits];
    let mut crowd = of("crowd", "torus", few, CROWDED, deposits)?;
    crowd.settings.particles.start = Start::Point;
    Ok(vec![
        of("torus", "torus", many, SORTED, &Comparison::ALL)?,
        of("cube", "cube", many, SORTED, &Comparison::ALL)?,
        of("even", "torus", few, CROWDED, deposits)?,
        crowd,
    ])
}

/// Where the scenes stand on the axis: how many particles they have.
pub fn places(extent: &Extent) -> Result<Vec<f64>> {
    let count = |case: &Compared| f64::from(case.settings.particles.count);
    Ok(compared(extent)?.iter().map(count).collect())
}

/// Measures all of them in turn. What was measured before Ctrl-C or an error is kept.
pub fn measure(
    rig: &Rig,
    extent: &Extent,
    runs: u32,
    budget: &Budget,
    watch: &mut Watch,
) -> Result<(Vec<Point>, Vec<Skipped>, Result<()>)> {
    let mut all = compared(extent)?;
    all.retain(|case| f64::from(case.settings.particles.count) <= extent.up_to);
    let count = all.len() as u64 * u64::from(runs);
    let mut progress = Progress::counting(count, "choices", "cases");
    let mut ended = Ok(());
    'all: for _ in 0..runs {
        for case in &mut all {
            if interrupt::requested() {
                break 'all;
            }
            progress.doing(case.name);
            ended = case.run(rig, budget, watch);
            if ended.is_err() {
                break 'all;
            }
            progress.step();
        }
    }
    progress.finish();
    let skipped = all.iter().filter_map(|case| {
        Some(Skipped {
            case: case.name.to_owned(),
            why: case.skipped.clone()?,
        })
    });
    let skipped = skipped.collect();
    let points = all.into_iter().flat_map(|case| case.points).collect();
    Ok((points, skipped, ended))
}

impl Compared {
    fn ways(&self) -> impl Iterator<Item = (Comparison, Way, &'static str)> {
        let all = self.comparisons.iter();
        all.flat_map(|&of| of.ways().into_iter().map(move |(way, how)| (of, way, how)))
    }

    /// Measures all ways in turn, again and again, on what the scene comes to.
    fn run(&mut self, rig: &Rig, budget: &Budget, watch: &mut Watch) -> Result<()> {
        let scene =
            Scene::from_settings(self.name.to_owned(), self.settings.clone(), PathBuf::new())?;
        memory::check(rig.ctx.info(), &scene)?;
        if let Err(error) = rig.check_room(&scene) {
            self.skipped = Some(error.to_string());
            return Ok(());
        }
        let control = Control {
            cancelled: Some(interrupt::flag()),
            cache: rig.cache.as_deref(),
            ..Control::default()
        };
        let mut simulation = Simulation::with_control(&rig.ctx, &scene, &control)?;
        self.skipped = missing(&rig.ctx, simulation.setup().atlas.density.len());
        if self.skipped.is_some() {
            return Ok(());
        }
        let mut frames = Frames::new(&rig.ctx, 2)?;
        for _ in 0..self.warmup {
            let mut rec = frames.begin()?;
            simulation.record_step(&mut rec);
            frames.submit(rec)?;
        }
        frames.wait_idle()?;
        let ways = Ways::new(&rig.ctx, &simulation)?;
        let mut all: Vec<Way> = self.ways().map(|(_, way, _)| way).collect();
        let mut rounds = |fewest: u32, most: u32| {
            let begun = Instant::now();
            let mut done = 0;
            while done < fewest || (done < most && begun.elapsed() < budget.time) {
                if interrupt::requested() {
                    break;
                }
                let mut rec = frames.begin()?;
                rec.scope("round", |rec| {
                    all.iter().for_each(|way| ways.record(rec, *way))
                });
                frames.submit(rec)?;
                // Forwards and backwards in turn, and from the next one each time: none always comes after the same other one,
                // nor last while the machine becomes slower.
                all.reverse();
                done += 1;
                if done.is_multiple_of(2) {
                    all.rotate_left(1);
                }
            }
            frames.wait_idle()?;
            if done <= UNTIMED {
                frames.timings_mut().clear();
            }
            Ok::<u32, Error>(done)
        };
        rounds(UNTIMED, UNTIMED)?;
        watch.begin();
        let done = rounds(FEWEST, budget.steps);
        watch.end();
        if done? < FEWEST {
            return Ok(());
        }
        if self.found.is_empty() {
            self.find(&ways, &simulation)?;
        }
        self.take(frames.timings());
        self.points = self.points(&simulation);
        Ok(())
    }

    /// How what comes out differs.
    fn find(&mut self, ways: &Ways<'_>, simulation: &Simulation) -> Result<()> {
        let setup = simulation.setup();
        for &comparison in self.comparisons {
            let found = match comparison {
                Comparison::Walks(reach) => differences::of_walks(ways, setup, reach)?.to_vec(),
                Comparison::Deposits => differences::of_counts(ways, setup)?.to_vec(),
                Comparison::Readings => {
                    let mut readings: [Vec<f32>; READINGS.len()] = Default::default();
                    for (values, binding) in readings.iter_mut().zip(READINGS) {
                        *values = ways.read_alone(binding)?;
                    }
                    differences::of_readings(&readings)?.to_vec()
                }
            };
            let kernels = comparison.ways().into_iter().map(|(way, _)| way.kernel());
            self.found.extend(kernels.zip(found));
        }
        Ok(())
    }

    /// Adds a run.
    fn take(&mut self, timings: &Timings) {
        for row in timings.report("round").rows {
            let way = self.ways().find(|(_, way, _)| way.kernel() == row.name);
            if let Some((_, way, _)) = way {
                let runs = self.runs_ms.entry(way.kernel()).or_default();
                runs.push(row.time.median_ms);
            }
        }
        let mut timings = timings.clone();
        timings.prepend(&self.timings);
        self.timings = timings;
    }

    fn points(&self, simulation: &Simulation) -> Vec<Point> {
        let setup = simulation.setup();
        let report = self.timings.report("round");
        let particles = setup.particles.len() as u64;
        let point = |(comparison, way, how): (Comparison, Way, &str)| {
            let row = report.rows.iter().find(|row| row.name == way.kernel())?;
            let runs_ms = self.runs_ms.get(way.kernel())?.clone();
            let mut time = Times::from(&row.time);
            runs_ms.iter().for_each(|median| time.include(*median));
            let mut found = self.found.get(way.kernel()).cloned().unwrap_or_default();
            found.insert("ns a particle", 1e6 * row.time.median_ms / particles as f64);
            Some(Point {
                series: format!("{}, {}: {how}", self.name, comparison.name()),
                x: particles as f64,
                particles,
                atlas_size: setup.atlas.size,
                triangles: setup.surface.triangles.len() as u64,
                objects: setup.poses.len(),
                memory_bytes: memory::size_in_bytes(setup, simulation.settings()),
                warmup: self.warmup,
                steps: report.steps,
                runs_ms,
                time,
                parts: vec![KernelTime {
                    name: way.kernel().to_owned(),
                    dispatches_per_step: 1.0,
                    time,
                    ..KernelTime::default()
                }],
                found,
                ..Point::default()
            })
        };
        self.ways().filter_map(point).collect()
    }
}

/// One picture for walks, one for deposits, one for readings.
pub fn bars(points: &[Point]) -> Vec<Bars> {
    let of = |name: &str, title: &str, comparisons: &[Comparison]| {
        let mut bars = Vec::new();
        for comparison in comparisons {
            for (color, (_, how)) in comparison.ways().into_iter().enumerate() {
                let ending = format!(", {}: {how}", comparison.name());
                let own = points
                    .iter()
                    .filter(|point| point.series.ends_with(&ending));
                bars.extend(own.map(|point| bar(point, color)));
            }
        }
        // Ways to do the same stand together.
        let group = |bar: &Bar| bar.name.split(':').next().map(str::to_owned);
        bars.sort_by_key(group);
        Bars {
            name: format!("choices_{name}"),
            title: title.to_owned(),
            label: "median, ns a particle".to_owned(),
            bars,
        }
    };
    vec![
        of(
            "walks",
            "Straight walks by two edge tests, and how far off they end",
            &[
                Comparison::Walks(Reach::Step),
                Comparison::Walks(Reach::Sensor),
            ],
        ),
        of(
            "deposits",
            "Particles counted in texels",
            &[Comparison::Deposits],
        ),
        of(
            "readings",
            "Three bilinear readings, with the trail bound in five ways",
            &[Comparison::Readings],
        ),
    ]
}

fn bar(point: &Point, color: usize) -> Bar {
    let whole = point.whole();
    let each = 1e6 / point.x;
    let value = each * whole.y;
    let of = |what: &str| point.found.get(what).copied();
    let also = of("off: p95")
        .map(|off| format!(", {} off (95 %)", percent(off)))
        .or_else(|| of("most in a texel").map(|most| format!(", up to {most} in a texel")))
        .or_else(|| {
            Some(format!(
                ", {} off",
                percent(of("differs: p95").filter(|d| *d > 0.0)?)
            ))
        });
    Bar {
        name: point.series.clone(),
        color,
        value,
        low: each * whole.low,
        high: each * whole.high,
        note: format!("{value:.1}{}", also.unwrap_or_default()),
    }
}

fn percent(part: f64) -> String {
    match 100.0 * part {
        0.0 => "0 %".to_owned(),
        part if part < 0.01 => format!("{part:.0e} %"),
        part => format!("{part:.2} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_way_has_its_own_name_and_a_bar() {
        let all: Vec<(Comparison, Way, &str)> = Comparison::ALL
            .into_iter()
            .flat_map(|of| of.ways().into_iter().map(move |(way, how)| (of, way, how)))
            .collect();
        let mut kernels: Vec<&str> = all.iter().map(|(_, way, _)| way.kernel()).collect();
        kernels.sort_unstable();
        kernels.dedup();
        assert_eq!(kernels.len(), 13);
        let time = Times {
            median_ms: Some(2.0),
            median_low_ms: Some(1.0),
            median_high_ms: Some(3.0),
            ..Times::default()
        };
        let point = |(of, _, how): &(Comparison, Way, &str)| Point {
            series: format!("torus, {}: {how}", of.name()),
            x: 1e6,
            time,
            found: Found::from([("off: p95", 0.01)]),
            ..Point::default()
        };
        let points: Vec<Point> = all.iter().map(point).collect();
        let bars = bars(&points);
        let counts: Vec<usize> = bars.iter().map(|bars| bars.bars.len()).collect();
        assert_eq!(counts, [6, 2, 5]);
        let first = &bars[0].bars[0];
        assert_eq!(first.name, "torus, step: exact edge test");
        assert_eq!((first.value, first.low, first.high), (2.0, 1.0, 3.0));
        assert_eq!(first.note, "2.0, 1.00 % off (95 %)");
    }

    #[test]
    fn small_parts_have_their_power_of_ten() {
        let texts = [0.0, 3e-7, 0.0123].map(percent);
        assert_eq!(texts, ["0 %", "3e-5 %", "1.23 %"]);
    }
}
