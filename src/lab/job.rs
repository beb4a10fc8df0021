//! Work on another thread: how far it is, a way to cancel it, and what came of it. Everything that the window waits for is one
//! of these: a scene that loads, distances to food, files that are written.

use std::any::Any;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};

use myxo::mesh::atlas::Control;
use myxo::{Error, Result};

/// How far a job is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// What it does now, as "reading"; empty where it does not say.
    pub doing: &'static str,
    /// The share that is done, 0 to 1.
    pub done: f32,
    /// It was asked to end.
    pub is_cancelled: bool,
}

/// What the thread and the window share.
#[derive(Default)]
struct Shared {
    progress: Mutex<(&'static str, f32)>,
    cancelled: AtomicBool,
}

/// The thread's end of a job.
pub struct Handle(Arc<Shared>);

impl Handle {
    /// Says what is being done, and the share of the job that is done, 0 to 1.
    pub fn report(&self, doing: &'static str, done: f32) {
        *(self.0.progress.lock()).unwrap_or_else(PoisonError::into_inner) = (doing, done);
    }

    /// Was the job cancelled? Then it should end soon; its result is dropped.
    pub fn is_cancelled(&self) -> bool {
        self.0.cancelled.load(Ordering::Relaxed)
    }

    /// Does `work` with the control that the library's long computations take, which report and are cancelled by it.
    pub fn control<T>(&self, cache: Option<&Path>, work: impl FnOnce(&Control<'_>) -> T) -> T {
        work(&Control {
            progress: Some(&|doing, done| self.report(doing, done)),
            cancelled: Some(&self.0.cancelled),
            cache,
        })
    }
}

/// Work on another thread. Dropping a job cancels it, and does not wait.
pub struct Job<T> {
    /// What it is, as "loading torus", for the error of a panic.
    name: String,
    shared: Arc<Shared>,
    /// None once the result was taken.
    thread: Option<JoinHandle<Result<T>>>,
}

impl<T: Send + 'static> Job<T> {
    /// Begins to work on a thread of its own; `name` stands in the message if the work panics.
    pub fn begin(
        name: impl Into<String>,
        work: impl FnOnce(&Handle) -> Result<T> + Send + 'static,
    ) -> Self {
        let shared = Arc::new(Shared::default());
        let handle = Handle(Arc::clone(&shared));
        Self {
            name: name.into(),
            shared,
            thread: Some(thread::spawn(move || work(&handle))),
        }
    }
}

impl<T> Job<T> {
    /// How far it is.
    pub fn progress(&self) -> Progress {
        let (doing, done) = *(self.shared.progress.lock()).unwrap_or_else(PoisonError::into_inner);
        Progress {
            doing,
            done,
            is_cancelled: self.is_cancelled(),
        }
    }

    /// Asks the thread to end; it does so when it looks next.
    pub fn cancel(&self) {
        self.shared.cancelled.store(true, Ordering::Relaxed);
    }

    /// Was it cancelled?
    pub fn is_cancelled(&self) -> bool {
        self.shared.cancelled.load(Ordering::Relaxed)
    }

    /// Has the thread ended? The result may be taken then.
    pub fn has_ended(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// The result, once, when the thread has ended. A panic is an error that names the job.
    pub fn take(&mut self) -> Option<Result<T>> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        Some(joined(&self.name, thread))
    }

    /// Waits for the result, which is given once; none where it was taken before.
    pub fn wait(&mut self) -> Option<Result<T>> {
        let thread = self.thread.take()?;
        Some(joined(&self.name, thread))
    }
}

impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        self.cancel();
    }
}

/// What a thread has made; where it has panicked, an error that names the work.
fn joined<T>(name: &str, thread: JoinHandle<Result<T>>) -> Result<T> {
    thread.join().unwrap_or_else(|panic| {
        Err(Error::Invalid(format!(
            "{name} has failed: {}; this is a bug in myxo, please report it; nothing else is affected",
            message_of(&*panic)
        )))
    })
}

/// The message of a panic.
fn message_of(panic: &(dyn Any + Send)) -> &str {
    match (panic.downcast_ref::<&str>(), panic.downcast_ref::<String>()) {
        (Some(text), _) => text,
        (_, Some(text)) => text,
        _ => "it does not say why",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;
    use std::time::{Duration, Instant};

    fn ended<T>(job: &mut Job<T>) -> Result<T> {
        let begun = Instant::now();
        loop {
            if let Some(result) = job.take() {
                return result;
            }
            assert!(begun.elapsed() < Duration::from_secs(60), "it hangs");
            thread::sleep(Duration::from_millis(1));
        }
    }

    #[test]
    fn a_job_reports_is_cancelled_and_gives_its_result_once() {
        let (go, wait) = mpsc::channel::<()>();
        let (reached, at) = mpsc::channel::<()>();
        let mut job = Job::begin("the work", move |handle| {
            handle.control(None, |control| {
                control.progress.expect("it is asked for")("sorting", 0.5);
                reached.send(()).unwrap();
                wait.recv().unwrap();
                let cancelled = control.cancelled.expect("it can be cancelled");
                Ok(cancelled.load(Ordering::Relaxed) && handle.is_cancelled())
            })
        });
        at.recv().unwrap();
        let progress = job.progress();
        assert_eq!((progress.doing, progress.done), ("sorting", 0.5));
        assert!(!progress.is_cancelled && !job.has_ended() && job.take().is_none());
        job.cancel();
        assert!(job.progress().is_cancelled);
        go.send(()).unwrap();
        assert!(ended(&mut job).unwrap(), "the thread has seen it");
        assert!(job.has_ended() && job.take().is_none() && job.wait().is_none());
    }

    #[test]
    fn dropping_a_job_cancels_it() {
        let (saw, seen) = mpsc::channel::<bool>();
        let (go, wait) = mpsc::channel::<()>();
        let job = Job::begin("the work", move |handle| {
            wait.recv().unwrap();
            saw.send(handle.is_cancelled()).unwrap();
            Ok(())
        });
        drop(job);
        go.send(()).unwrap();
        assert!(seen.recv().unwrap());
    }

    #[test]
    fn a_panic_is_an_error_that_names_the_job() {
        let mut refused = Job::<u32>::begin("the work", |_| Err(Error::Invalid("no".to_owned())));
        assert_eq!(refused.wait().unwrap().unwrap_err().to_string(), "no");
        for work in [(|| panic!("no room")) as fn() -> u32, || {
            panic!("{} room", "no")
        }] {
            let mut job = Job::begin("the work", move |_| Ok(work()));
            let said = ended(&mut job).unwrap_err().to_string();
            assert!(said.contains("the work has failed: no room;"), "{said}");
        }
        let mut job = Job::<u32>::begin("the work", |_| std::panic::panic_any(7));
        let said = job.wait().unwrap().unwrap_err().to_string();
        assert!(said.contains("does not say why"), "{said}");
    }
}
