//! States that fail a check: the run ends, and the state is saved, marked as damaged.

use std::path::{Path, PathBuf};

use myxo::plain_text::Shown as _;
use myxo::scene::Scene;
use myxo::sim::checkpoint::Checkpoint;
use myxo::sim::{Setup, Snapshot};
use myxo::{Error, Result};

/// Checks a state. A wrong one is saved beside the requested checkpoint, which is not changed.
pub fn check(
    scene: &Scene,
    setup: &Setup,
    snapshot: &Snapshot,
    checkpoint: Option<&Path>,
) -> Result<()> {
    let Err(problem) = snapshot.validate(setup) else {
        return Ok(());
    };
    let kept = checkpoint.map(|path| keep(scene, setup, snapshot, path));
    Err(Error::Invalid(format!(
        "after step {}: {problem}; this is a bug in myxo{}",
        snapshot.step,
        kept.unwrap_or_default()
    )))
}

/// Writes the state beside a checkpoint's name. Returns the part of the message about it.
fn keep(scene: &Scene, setup: &Setup, snapshot: &Snapshot, checkpoint: &Path) -> String {
    let mut name = checkpoint.as_os_str().to_owned();
    name.push(".damaged");
    let damaged = PathBuf::from(name);
    match Checkpoint::new(scene, setup, snapshot.clone()).write(&damaged) {
        Ok(()) => format!(
            "; the damaged state is kept in {}, for a report: no run can continue from it",
            damaged.shown()
        ),
        Err(error) => format!("; {error}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::scene::Overrides;

    fn start() -> (Scene, Setup, Snapshot) {
        let overrides = Overrides {
            set: ["particles.count=100", "atlas.size=64"]
                .map(str::to_owned)
                .into(),
            ..Overrides::default()
        };
        let scene = Scene::load(Path::new("cube"), &overrides).expect("it is built in");
        let setup = Setup::new(&scene).expect("it fits");
        let mut snapshot = Snapshot::start(&setup);
        snapshot.trail[7] = f32::NAN;
        (scene, setup, snapshot)
    }

    /// Catches a failed check that loses the state, or replaces the earlier checkpoint.
    #[test]
    fn a_wrong_state_is_kept_beside_the_checkpoint_and_no_run_goes_on_from_it() {
        let (scene, setup, snapshot) = start();
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("saved.state");
        std::fs::write(&path, "of before").expect("there is room");
        let message = check(&scene, &setup, &snapshot, Some(&path)).expect_err("it is wrong");
        let message = message.to_string();
        let damaged = folder.path().join("saved.state.damaged");
        assert!(message.contains("the trail is NaN at texel 7"), "{message}");
        assert!(message.contains(&*damaged.shown()), "{message}");
        assert_eq!(std::fs::read(&path).expect("it is there"), b"of before");
        let kept = Checkpoint::read(&damaged).expect("it is whole");
        assert_eq!(kept.snapshot.particles, snapshot.particles);
        let refused = kept.check(&scene, &setup).expect_err("it is wrong");
        assert!(refused.contains("the trail is NaN"), "{refused}");
    }

    /// Catches a message that promises a file where none was asked for, or where it could not be written.
    #[test]
    fn what_is_not_kept_is_not_promised() {
        let (scene, setup, snapshot) = start();
        let message = check(&scene, &setup, &snapshot, None).expect_err("it is wrong");
        assert!(
            message.to_string().ends_with("; this is a bug in myxo"),
            "{message}"
        );
        let nowhere = Path::new("/dev/null/saved.state");
        let message = check(&scene, &setup, &snapshot, Some(nowhere)).expect_err("it is wrong");
        assert!(message.to_string().contains("; cannot write"), "{message}");
    }
}
