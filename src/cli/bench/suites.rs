//! The suites: which scenes they are made of, and what their plots show.

use std::collections::BTreeMap;

use myxo::Result;
use myxo::scene::settings::{DistanceMethod, ObjectSettings, Sensing, Strategy};
use myxo::scene::{Overrides, Scene, Settings};
use myxo::sim::FORMS_OF_ADVANCE;

use super::plot::{Axis, Dot, Plot};
use super::suite::{Case, Extent, Point, Suite, Work, lines};

/// All of them, in the order in which they run.
pub static SUITES: [Suite; 7] = [
    Suite {
        name: "particles",
        about: "how the time of a step grows with the number of particles, on `torus`",
        axis: "particles",
        whole: "step",
        parts: &["advance", "walk_sensors", "diffuse"],
        warmup: SORTED,
        work: Work::Scenes(particles),
        plots: particles_plots,
    },
    Suite {
        name: "texture",
        about: "how it grows with the side of the texture, on `torus`",
        axis: "texels a side",
        whole: "step",
        parts: &[
            "advance",
            "walk_sensors",
            "diffuse",
            "diffuse_seams",
            "exchange_seams",
        ],
        warmup: SORTED,
        work: Work::Scenes(texture),
        plots: texture_plots,
    },
    Suite {
        name: "edges",
        about: "what edge-crossing attempts cost, on a coarse mesh (`cube`) and a fine one (`torus`)",
        axis: "attempts",
        whole: "step",
        parts: &["advance", "walk_sensors"],
        warmup: SORTED,
        work: Work::Scenes(edges),
        plots: edges_plots,
    },
    Suite {
        name: "objects",
        about: "what it costs to have the same surface and particles in more objects, which stand still",
        axis: "objects",
        whole: "step",
        parts: &MOVING,
        warmup: SORTED,
        work: Work::Scenes(objects),
        plots: objects_plots,
    },
    Suite {
        name: "transfer",
        about: "how strategies compare as objects and their motion grow",
        axis: "objects",
        whole: "step",
        parts: &MOVING_AND_DISTANCE,
        warmup: SORTED,
        work: Work::Scenes(transfer),
        plots: transfer_plots,
    },
    Suite {
        name: "distance",
        about: "what distances between two tori that touch cost, by each method, moving and not",
        axis: "triangles",
        whole: "step",
        parts: &DISTANCE_KERNELS,
        warmup: 4,
        work: Work::Scenes(distance),
        plots: distance_plots,
    },
    Suite {
        name: "mesh",
        about: "what loading a model, its half-edges and its atlas cost on the host",
        axis: "triangles",
        whole: "all three",
        parts: &super::meshes::PARTS,
        warmup: 0,
        work: Work::Meshes,
        plots: mesh_plots,
    },
];

/// Steps until particles have been sorted three times and networks begin to form, which changes the times of later steps.
const SORTED: u32 = 34;

/// The kernels that move particles, also from object to object.
const MOVING: [&str; 5] = {
    let [a, b, c, d] = FORMS_OF_ADVANCE;
    [a, b, c, d, "transfer_out"]
};
const MOVING_AND_DISTANCE: [&str; 7] = {
    let [a, b, c, d, e] = MOVING;
    [a, b, c, d, e, "distance_tiles", "distance"]
};

/// The kernels that take distances.
const DISTANCE_KERNELS: [&str; 6] = [
    "distance_tiles",
    "distance",
    "distance_brute",
    "distance_raster",
    "distance_merge",
    "unfold",
];

/// A scene with the suite's settings and, over them, those of the command line.
fn scene(name: &str, own: &[&str], extent: &Extent) -> Result<Settings> {
    let own = own.iter().map(|text| (*text).to_owned());
    let overrides = Overrides {
        set: own.chain(extent.set.iter().cloned()).collect(),
        ..Overrides::default()
    };
    Ok(Scene::read(name.as_ref(), &overrides)?.1)
}

fn case(series: &str, x: f64, effort: f64, settings: Settings) -> Case {
    Case {
        series: series.to_owned(),
        x,
        also: BTreeMap::new(),
        settings,
        effort,
    }
}

fn particles(extent: &Extent) -> Result<Vec<Case>> {
    let counts: &[u32] = extent.of(
        &[10_000, 30_000, 100_000, 300_000, 1_000_000],
        &[
            10_000,
            30_000,
            100_000,
            300_000,
            1_000_000,
            3_000_000,
            10_000_000,
            30_000_000,
            64_000_000,
            100_000_000,
            300_000_000,
            1_000_000_000,
        ],
    );
    let mut cases = Vec::new();
    for &sensing in Sensing::ALL {
        for &count in counts {
            let mut settings = scene("torus", &[], extent)?;
            settings.particles.count = count;
            settings.physarum.sensing = sensing;
            cases.push(case(sensing.word(), count.into(), count.into(), settings));
        }
    }
    Ok(cases)
}

fn particles_plots(points: &[Point]) -> Vec<Plot> {
    let of = |sensing: &'static str, name: &'static str, value: fn(&Point) -> Dot| {
        lines(points, |p| p.series == sensing, |_| name.to_owned(), value)
    };
    let together = Plot {
        name: "particles".to_owned(),
        title: "Time of a step by the number of particles".to_owned(),
        x: Axis::log("particles"),
        y: Axis::log("median, ms"),
        lines: [
            of("auto", "step, sensing auto", Point::whole),
            of("walk", "step, sensing walk", Point::whole),
            of("auto", "advance (auto)", |p| p.parts(&["advance"])),
            of("auto", "walk_sensors (auto)", |p| {
                p.parts(&["walk_sensors"])
            }),
            of("auto", "the trail's kernels", |p| {
                p.parts(&["diffuse", "diffuse_seams", "exchange_seams"])
            }),
        ]
        .concat(),
    };
    let each = |point: &Point| {
        let Dot { x, y, low, high } = point.whole();
        let [y, low, high] = [y, low, high].map(|ms| 1e6 * ms / x);
        Dot { x, y, low, high }
    };
    vec![
        together,
        Plot {
            name: "particles_each".to_owned(),
            title: "Time of a step for each particle".to_owned(),
            x: Axis::log("particles"),
            y: Axis::log("median, ns a particle"),
            lines: lines(points, |_| true, |p| format!("sensing {}", p.series), each),
        },
    ]
}

fn texture(extent: &Extent) -> Result<Vec<Case>> {
    let sizes: &[u32] = extent.of(
        &[256, 512, 1024, 2048],
        &[256, 512, 1024, 2048, 4096, 8192, 16_384],
    );
    let count = extent.of("particles.count=200000", "particles.count=500000");
    let mut cases = Vec::new();
    for &size in sizes {
        let mut settings = scene("torus", &[count], extent)?;
        settings.atlas.size = size;
        let effort = f64::from(size).powi(2);
        cases.push(case("torus", size.into(), effort, settings));
    }
    Ok(cases)
}

fn texture_plots(points: &[Point]) -> Vec<Plot> {
    let of = |name: &'static str, value: &dyn Fn(&Point) -> Dot| {
        lines(points, |_| true, |_| name.to_owned(), value)
    };
    let mut all = of("step", &Point::whole);
    for kernel in [
        "advance",
        "walk_sensors",
        "diffuse",
        "diffuse_seams",
        "exchange_seams",
    ] {
        all.extend(of(kernel, &|p| p.parts(&[kernel])));
    }
    vec![Plot {
        name: "texture".to_owned(),
        title: "Time of a step by the side of the texture".to_owned(),
        x: Axis::log("texels a side"),
        y: Axis::log("median, ms"),
        lines: all,
    }]
}

fn edges(extent: &Extent) -> Result<Vec<Case>> {
    let attempts: &[u32] = extent.of(&[1, 3, 10, 20], &[1, 2, 3, 5, 7, 10, 15, 20]);
    let count = extent.of("particles.count=100000", "particles.count=500000");
    let mut cases = Vec::new();
    for mesh in ["cube", "torus"] {
        for &sensing in Sensing::ALL {
            for &attempts in attempts {
                let mut settings = scene(mesh, &[count], extent)?;
                settings.physarum.sensing = sensing;
                settings.physarum.edge_crossing_attempts = attempts;
                let series = format!("{mesh}, {}", sensing.word());
                cases.push(case(&series, attempts.into(), attempts.into(), settings));
            }
        }
    }
    Ok(cases)
}

fn edges_plots(points: &[Point]) -> Vec<Plot> {
    vec![Plot {
        name: "edges".to_owned(),
        title: "Time of a step by edge-crossing attempts".to_owned(),
        x: Axis::linear("edge-crossing attempts"),
        y: Axis::linear("median, ms"),
        lines: lines(points, |_| true, |p| p.series.clone(), Point::whole),
    }]
}

/// Balls that reach a little into their neighbours, in rows and layers, with the surface of one ball of radius 1 together.
/// Each slides to and fro so many times a second, neighbours in opposite directions.
fn balls(settings: &mut Settings, count: u32, subdivisions: u32, rate: f32) {
    let radius = f64::from(count).sqrt().recip() as f32;
    let side = (1..).find(|side: &u32| side.pow(3) >= count).unwrap_or(1);
    let spacing = 1.9 * radius;
    let place = |i: u32| (i as f32 - 0.5 * (side - 1) as f32) * spacing;
    let ball = |i: u32| {
        let cell = [i % side, i / side % side, i / (side * side)];
        let mut object = ObjectSettings {
            mesh: format!("builtin:icosphere?subdivisions={subdivisions}"),
            position: cell.map(|i| f64::from(place(i))),
            scale: radius,
            ..ObjectSettings::default()
        };
        if rate > 0.0 {
            object.motion.slide[(i % 3) as usize] = 0.15 * radius;
            object.motion.slide_period = rate.recip();
            object.motion.slide_phase = 0.5 * (cell.iter().sum::<u32>() % 2) as f32;
        }
        object
    };
    settings.objects = (0..count).map(ball).collect();
    // Lengths are those of the one ball, whatever the scene's size.
    settings.radius = 1.0;
}

fn objects(extent: &Extent) -> Result<Vec<Case>> {
    let own = extent.of(
        [
            "particles.count=50000",
            "atlas.size=512",
            "distance.reach=0.06",
        ],
        [
            "particles.count=500000",
            "atlas.size=1024",
            "distance.reach=0.06",
        ],
    );
    // With as many triangles together: four times the balls, each of a quarter.
    let counts = [(1, 6), (4, 5), (16, 4), (64, 3), (256, 2)];
    let strategies = [
        Strategy::None,
        Strategy::Scattered,
        Strategy::Parallel,
        Strategy::Direct,
    ];
    let mut cases = Vec::new();
    for strategy in strategies {
        for (count, subdivisions) in counts {
            let mut settings = scene("torus", &own, extent)?;
            balls(&mut settings, count, subdivisions, 0.0);
            settings.transfer.strategy = strategy;
            cases.push(case(strategy.word(), count.into(), count.into(), settings));
        }
    }
    Ok(cases)
}

fn objects_plots(points: &[Point]) -> Vec<Plot> {
    vec![Plot {
        name: "objects".to_owned(),
        title: "Time of a step by the number of objects, the same surface and particles".to_owned(),
        x: Axis::log("objects"),
        y: Axis::log("median, ms"),
        lines: lines(points, |_| true, |p| p.series.clone(), Point::whole),
    }]
}

const MOTION: &str = "cycles/s";

fn transfer(extent: &Extent) -> Result<Vec<Case>> {
    let own = extent.of(
        [
            "particles.count=50000",
            "atlas.size=384",
            "distance.reach=0.05",
        ],
        [
            "particles.count=200000",
            "atlas.size=768",
            "distance.reach=0.05",
        ],
    );
    let counts: &[u32] = extent.of(&[2, 8], &[2, 4, 8, 16, 32, 64]);
    let rates: &[f32] = extent.of(&[0.0, 0.2, 1.0], &[0.0, 0.1, 0.3, 1.0, 3.0]);
    let mut cases = Vec::new();
    for &strategy in Strategy::ALL {
        for &rate in rates {
            for &count in counts {
                let mut settings = scene("torus", &own, extent)?;
                balls(&mut settings, count, 4, rate);
                settings.transfer.strategy = strategy;
                let mut case = case(strategy.word(), count.into(), count.into(), settings);
                // As written: 0.2, and not the nearest float.
                let rate = (f64::from(rate) * 1000.0).round() / 1000.0;
                case.also.insert(MOTION, rate);
                cases.push(case);
            }
        }
    }
    Ok(cases)
}

fn transfer_plots(points: &[Point]) -> Vec<Plot> {
    let most = |of: &dyn Fn(&Point) -> f64| points.iter().map(of).fold(0.0, f64::max);
    let rate = |point: &Point| point.also.get(MOTION).copied().unwrap_or_default();
    let (fastest, largest) = (most(&rate), most(&|point| point.x));
    let name = |point: &Point| point.series.clone();
    let by_rate = |point: &Point| Dot {
        x: rate(point),
        ..point.whole()
    };
    vec![
        Plot {
            name: "transfer".to_owned(),
            title: format!("Strategies by the number of objects, sliding at {fastest} cycles/s"),
            x: Axis::log("objects"),
            y: Axis::linear("median of the step, ms"),
            lines: lines(points, |p| rate(p) == fastest, name, Point::whole),
        },
        Plot {
            name: "transfer_motion".to_owned(),
            title: format!("Strategies by motion, {largest} objects"),
            x: Axis::linear("motion, cycles/s"),
            y: Axis::linear("median of the step, ms"),
            lines: lines(points, |p| p.x == largest, name, by_rate),
        },
    ]
}

fn distance(extent: &Extent) -> Result<Vec<Case>> {
    let own = extent.of(
        ["particles.count=1000", "atlas.size=256"],
        ["particles.count=1000", "atlas.size=1024"],
    );
    let shapes: &[(u32, u32)] = extent.of(
        &[(18, 12), (36, 24), (72, 48), (144, 96)],
        &[(18, 12), (36, 24), (72, 48), (144, 96), (288, 192)],
    );
    let mut cases = Vec::new();
    for &method in DistanceMethod::ALL {
        for moves in [true, false] {
            for &(major, minor) in shapes {
                let mut settings = scene("torus", &own, extent)?;
                let mesh = format!("builtin:torus?major={major}&minor={minor}");
                let torus = |x: f32| ObjectSettings {
                    mesh: mesh.clone(),
                    position: [x.into(), 0.0, 0.0],
                    ..ObjectSettings::default()
                };
                settings.objects = vec![torus(0.0), torus(2.68)];
                if moves {
                    settings.objects[1].motion.swing = [0.0, 0.0, 2.0];
                    settings.objects[1].motion.swing_period = 2.0;
                }
                settings.distance.method = method;
                let moving = if moves { "moving" } else { "still" };
                let series = format!("{}, {moving}", method.word());
                // Two triangles a quad, of either torus.
                let triangles = f64::from(4 * major * minor);
                let effort = match method {
                    // Each of the one is drawn for each of the other.
                    DistanceMethod::Raster if moves => triangles.powi(2),
                    _ => triangles,
                };
                cases.push(case(&series, triangles, effort, settings));
            }
        }
    }
    Ok(cases)
}

fn distance_plots(points: &[Point]) -> Vec<Plot> {
    vec![Plot {
        name: "distance".to_owned(),
        title: "Distances between two tori, one of which moves (0 where none does)".to_owned(),
        x: Axis::log("triangles of both"),
        y: Axis::log("median of the kernels of distances, ms"),
        lines: lines(
            points,
            |p| p.series.ends_with("moving"),
            |p| p.series.clone(),
            |p| p.parts(&DISTANCE_KERNELS),
        ),
    }]
}

fn mesh_plots(points: &[Point]) -> Vec<Plot> {
    let of = |part: &'static str| {
        lines(
            points,
            |_| true,
            |_| part.to_owned(),
            move |p| p.parts(&[part]),
        )
    };
    vec![Plot {
        name: "mesh".to_owned(),
        title: "Work on the host before the first step, by triangles".to_owned(),
        x: Axis::log("triangles"),
        y: Axis::log("median, ms"),
        lines: super::meshes::PARTS.into_iter().flat_map(of).collect(),
    }]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn extent(is_quick: bool) -> Extent {
        Extent {
            is_quick,
            up_to: f64::INFINITY,
            set: vec!["particles.count=777".to_owned()],
        }
    }

    #[test]
    fn axes_ascend_in_every_series_and_settings_are_allowed() {
        for suite in &SUITES {
            let Work::Scenes(cases) = suite.work else {
                continue;
            };
            let [quick, whole] =
                [true, false].map(|is_quick| cases(&extent(is_quick)).expect("they are made"));
            assert!(
                quick.len() > 3 && quick.len() <= whole.len(),
                "{}",
                suite.name
            );
            for pair in quick.windows(2).chain(whole.windows(2)) {
                let is_same = pair[0].series == pair[1].series && pair[0].also == pair[1].also;
                assert!(!is_same || pair[0].x < pair[1].x, "{}", pair[1].name());
            }
            for case in quick.iter().chain(&whole) {
                let wrong = myxo::scene::parameters::out_of_range(&case.settings);
                assert!(wrong.is_empty(), "{}: {wrong:?}", case.name());
                let set = case.settings.particles.count == 777;
                assert_eq!(set, suite.name != "particles", "{}", case.name());
            }
        }
    }

    #[test]
    fn balls_have_the_surface_of_one() {
        let mut settings = Settings::default();
        for count in [1, 2, 8, 64, 256] {
            balls(&mut settings, count, 2, 1.0);
            assert_eq!(settings.objects.len(), count as usize);
            let surface: f32 = settings.objects.iter().map(|ball| ball.scale.powi(2)).sum();
            assert!((surface - 1.0).abs() < 1e-4, "{surface}");
            let mut places: Vec<String> = settings
                .objects
                .iter()
                .map(|ball| format!("{:?}", ball.position))
                .collect();
            places.sort();
            places.dedup();
            assert_eq!(places.len(), count as usize, "each has its place");
            assert!(settings.objects.iter().all(|ball| !ball.motion.is_still()));
        }
        balls(&mut settings, 8, 2, 0.0);
        assert!(settings.objects.iter().all(|ball| ball.motion.is_still()));
    }

    #[test]
    fn wrong_settings_are_refused_as_in_other_commands() {
        let extent = Extent {
            set: vec!["particles.cuont=5".to_owned()],
            ..extent(true)
        };
        let error = texture(&extent)
            .expect_err("there is no such key")
            .to_string();
        assert!(error.contains("particles.count"), "{error}");
    }
}
