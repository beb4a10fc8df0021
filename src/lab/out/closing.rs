//! What is being taken out when the window closes: what can be finished is, and the terminal hears what became of each.

use std::io::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

use myxo::Result;
use myxo::render::output::Written;

use super::Lab;
use super::job::Job;

/// A window that closes waits no longer for a picture to be drawn.
const LAST_PICTURE: Duration = Duration::from_secs(10);

impl Lab {
    /// The window closes: what is being recorded, filmed or written becomes whole files, and so does a picture that does not
    /// take long. What became of each is said on the terminal.
    pub(in super::super) fn end_taking_out(&mut self) {
        let mut told = Vec::new();
        if let Some(mut recording) = self.out.recording.take() {
            if !recording.is_ending() {
                recording.stop();
            }
            let path = recording.path().to_owned();
            told.push(told_of(&path, recording.wait(), false));
        }
        told.extend(self.finish_job());
        for text in told {
            // Nobody listening is no reason to stop.
            let _ = writeln!(std::io::stderr().lock(), "{text}");
        }
    }

    fn finish_job(&mut self) -> Option<String> {
        let job = self.out.job.as_ref()?;
        let (path, is_cancelled) = (job.path().to_owned(), job.is_cancelled());
        let ready = self.make_ready();
        let mut job = self.out.job.take()?;
        let saves = match &mut job {
            Job::Export(export) => export.saves.take(),
            _ => None,
        };
        let ended = match ready {
            Ok(()) => job.close(),
            Err(error) => Some(Err(error)),
        };
        if saves.is_some() && ended.as_ref().is_some_and(Result::is_ok) {
            self.interface.saved(saves);
        }
        Some(told_of(&path, ended, is_cancelled))
    }

    /// Does what needs the device.
    fn make_ready(&mut self) -> Result<()> {
        if matches!(&self.out.job, Some(Job::Export(export)) if export.is_asked()) {
            let mut rec = self.frames.begin()?;
            self.record_asked(&mut rec)?;
            self.frames.submit(rec)?;
            self.frames.wait_idle()?;
        }
        let (Some(job), Some(stage)) = (&mut self.out.job, &mut self.stage) else {
            return Ok(());
        };
        let begun = Instant::now();
        while job.draws() && begun.elapsed() < LAST_PICTURE {
            job.advance(&mut self.frames, stage)?;
        }
        Ok(())
    }
}

/// What became of a file, in a line.
fn told_of(path: &Path, ended: Option<Result<Written>>, is_cancelled: bool) -> String {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let path = whole(path);
    match ended {
        Some(Ok(mut written)) if !written.files.is_empty() => {
            written
                .files
                .iter_mut()
                .for_each(|file| *file = whole(file));
            format!("saved {written}")
        }
        Some(Err(error)) if !is_cancelled => format!("{} was given up: {error}", path.display()),
        _ => format!("{} was given up", path.display()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use myxo::Error;

    #[test]
    fn each_file_is_told_of_by_its_path() {
        let folder = std::env::current_dir().expect("there is one");
        let path = Path::new("film_000001.gif");
        let whole = folder.join(path).display().to_string();
        let written = |files: &[&Path]| {
            let files = files.iter().map(|file| file.to_path_buf()).collect();
            Some(Ok(Written { files, frames: 2 }))
        };
        let failed = || Some(Err(Error::Invalid("no room".to_owned())));
        for (ended, is_cancelled, wanted) in [
            (written(&[path]), false, format!("saved {whole} (2 frames")),
            (written(&[path]), true, format!("saved {whole} (2 frames")),
            (written(&[]), true, format!("{whole} was given up")),
            (failed(), false, format!("{whole} was given up: no room")),
            (failed(), true, format!("{whole} was given up")),
            (None, false, format!("{whole} was given up")),
        ] {
            let told = told_of(path, ended, is_cancelled);
            assert!(told.starts_with(&wanted), "{told}, not {wanted}");
            assert!(!is_cancelled || !told.contains("no room"), "{told}");
        }
    }
}
