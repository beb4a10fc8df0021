//! Progress reports while an atlas is made; the work can be stopped at each of them.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use super::*;

/// Makes the atlas of three models and cancels at the first report equal to `last`. Returns all reports, too.
fn reports_until(
    options: &AtlasOptions,
    last: Option<(&'static str, f32)>,
) -> (Result<Atlas, AtlasError>, Vec<(&'static str, f32)>) {
    let reports = Mutex::new(Vec::new());
    let cancelled = AtomicBool::new(false);
    let progress = |doing: &'static str, done: f32| {
        reports.lock().unwrap().push((doing, done));
        if last == Some((doing, done)) {
            cancelled.store(true, Ordering::Relaxed);
        }
    };
    let control = Control {
        progress: Some(&progress),
        cancelled: Some(&cancelled),
        cache: None,
    };
    let atlas = Atlas::build_with(
        &surface(&[
            "torus?major=24&minor=16",
            "cube",
            "capsule?segments=9&rings=3",
        ]),
        options,
        &control,
    );
    (atlas, reports.into_inner().unwrap())
}

#[test]
fn every_part_is_named_and_can_be_stopped() {
    let common = ["giving out texels", "filling gutters", "joining seams"];
    for (method, first) in [
        (
            AtlasMethod::Charts,
            &["cutting into charts", "packing"] as &[_],
        ),
        (AtlasMethod::Grid, &[]),
    ] {
        let options = AtlasOptions {
            method,
            ..options(128, 1)
        };
        let (atlas, all) = reports_until(&options, None);
        assert!(atlas.is_ok());
        assert!(all.is_sorted_by_key(|(_, done)| *done), "{all:?}");
        assert_eq!(all.last(), Some(&("joining seams", 1.0)));
        let mut names: Vec<&str> = all.iter().map(|(doing, _)| *doing).collect();
        names.dedup();
        assert_eq!(names, [first, &common].concat());
        for (k, &last) in all.iter().enumerate() {
            // If pieces are cut in parallel, a report may come more than once.
            if all[..k].contains(&last) {
                continue;
            }
            let (atlas, reported) = reports_until(&options, Some(last));
            assert_eq!(atlas.err(), Some(AtlasError::Cancelled), "{last:?}");
            let end = reported.iter().position(|one| *one == last);
            assert!(end.is_some(), "{last:?} in {reported:?}");
            assert!(
                reported
                    .iter()
                    .all(|(doing, _)| names.iter().position(|name| name == doing)
                        <= names.iter().position(|name| *name == last.0)),
                "after {last:?}: {reported:?}"
            );
        }
    }
}
