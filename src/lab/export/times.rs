//! GPU times as files: the report and the trace that `myxo profile` writes.

use std::path::{Path, PathBuf};

use myxo::whole_file::write_whole;
use myxo::{Error, Result};

use crate::lab::names::Reserved;
use crate::measured::recent::RecentTimes;

/// Writes `times_000001.json` and `times_000001.trace.json`, or the next number that is free. Gives the first one's path.
pub fn save_times(folder: &Path, times: &RecentTimes) -> Result<PathBuf> {
    let mut taken = Vec::new();
    let (name, trace) = loop {
        let name = Reserved::next(folder, "times", "json")?;
        let trace = name.path().with_extension("trace.json");
        if !trace.exists() {
            break (name, trace);
        }
        // Held until a free number is found, so that it is not tried again.
        taken.push(name);
    };
    let report = name.path();
    write_whole(&trace, times.trace()?).map_err(Error::io("write", &trace))?;
    write_whole(report, times.report()).map_err(Error::io("write", report))?;
    Ok(report.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measured::report::Report;
    use myxo::gpu::{Context, ContextOptions, Span, SpanKind, Timings};
    use myxo::scene::{Overrides, Scene};
    use myxo::sim::Simulation;
    use serde_json::Value;

    #[test]
    fn the_files_have_the_kernels_and_are_numbered() {
        let ctx = match Context::new(&ContextOptions::default()) {
            Ok(ctx) => ctx,
            Err(error) if std::env::var_os("MYXO_ALLOW_NO_DEVICE").is_some() => {
                return eprintln!("skipped: {error}");
            }
            Err(error) => panic!("{error}"),
        };
        let overrides = Overrides {
            set: ["particles.count=500", "atlas.size=64"]
                .map(str::to_owned)
                .into(),
            ..Overrides::default()
        };
        let scene = Scene::load(Path::new("cube"), &overrides).unwrap();
        let simulation = Simulation::new(&ctx, &scene).unwrap();
        let mut timings = Timings::default();
        assert!(RecentTimes::new(&ctx, &scene, &simulation, &timings, 0.0).is_none());
        let span = |name: &str, kind, parent, begin_ms: f64, end_ms: f64| Span {
            name: name.to_owned(),
            kind,
            parent,
            begin_ns: 1e6 * begin_ms,
            end_ns: 1e6 * end_ms,
        };
        for begun in [100.0, 200.0] {
            timings.push(vec![
                span("frame", SpanKind::Frame, None, begun, begun + 9.0),
                span("step", SpanKind::Scope, Some(0), begun, begun + 8.0),
                span("advance", SpanKind::Kernel, Some(1), begun, begun + 5.0),
                span(
                    "diffuse",
                    SpanKind::Kernel,
                    Some(1),
                    begun + 5.0,
                    begun + 7.0,
                ),
            ]);
        }
        let recent = RecentTimes::new(&ctx, &scene, &simulation, &timings, 50.0).unwrap();

        let folder = tempfile::tempdir().unwrap();
        let path = save_times(folder.path(), &recent).unwrap();
        assert_eq!(path, folder.path().join("times_000001.json"));
        let report = Report::read(&path).unwrap();
        assert_eq!((report.scene.as_str(), report.particles), ("cube", 500));
        assert_eq!(report.settings["atlas"]["size"], 64);
        assert_eq!(
            (report.samples, report.wall_ms_per_step),
            (Some(2), Some(20.0))
        );
        assert_eq!(
            (report.gpu_ms_per_step, report.gpu_ms_between_kernels),
            (Some(8.0), Some(1.0))
        );
        let kernels = report.kernels.iter();
        let kernels: Vec<_> = kernels
            .map(|one| (one.name.as_str(), one.time.mean_ms))
            .collect();
        assert_eq!(kernels, [("advance", Some(5.0)), ("diffuse", Some(2.0))]);
        assert_eq!((report.counters, report.state_hash), (None, String::new()));

        let trace = std::fs::read(folder.path().join("times_000001.trace.json")).unwrap();
        let trace: Value = serde_json::from_slice(&trace).unwrap();
        let events = trace["traceEvents"].as_array().unwrap().iter();
        let kernels: Vec<_> = events
            .filter(|event| event["cat"] == "kernel")
            .map(|event| {
                let begun = event["ts"].as_f64().unwrap();
                (event["name"].as_str().unwrap(), begun.round())
            })
            .collect();
        let expected = [
            ("advance", 0.0),
            ("diffuse", 5e3),
            ("advance", 1e5),
            ("diffuse", 1.05e5),
        ];
        assert_eq!(kernels, expected);

        // A trace whose report is gone is kept.
        let old = folder.path().join("times_000002.trace.json");
        std::fs::write(&old, "old").unwrap();
        let path = save_times(folder.path(), &recent).unwrap();
        assert_eq!(path, folder.path().join("times_000003.json"));
        assert_eq!(std::fs::read_to_string(old).unwrap(), "old");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 5);
    }
}
