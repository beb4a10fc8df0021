//! The encoder as a process: fed through a pipe, waited for with a time limit, and ended together with its child processes.

use std::collections::{BTreeSet, VecDeque};
use std::io::{self, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStderr, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::plain_text::escaped;
use crate::signals;

/// How many lines of the encoder's output an error quotes.
const LAST_WORDS: usize = 6;
/// The most bytes of each line that are kept.
const LONGEST_LINE: usize = 300;

/// How long to wait for the pipe's end after an encoder has ended or was killed.
const LAST_WORDS_WITHIN: Duration = Duration::from_secs(2);

/// The interval of polling an encoder.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// The process groups of running encoders, by the id of their first process.
static RUNNING: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

/// How long an encoder may make no visible progress: take no bytes, or write none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patience {
    /// Before an interrupt.
    pub idle: Duration,
    /// After an interrupt.
    pub hurried: Duration,
    /// Set by an interrupt.
    pub interrupt: Option<&'static AtomicBool>,
}

impl Patience {
    /// For pictures of this size: large ones take long to encode, and many of them are encoded at once.
    pub(super) fn of((width, height): (u32, u32)) -> Self {
        let megapixels = f64::from(width) * f64::from(height) / 1e6;
        Self {
            idle: Duration::from_secs_f64(60.0 + 10.0 * megapixels),
            hurried: Duration::from_secs_f64(10.0 + 2.0 * megapixels),
            interrupt: None,
        }
    }

    fn now(&self) -> Duration {
        let is_hurried = self
            .interrupt
            .is_some_and(|flag| flag.load(Ordering::Relaxed));
        if is_hurried { self.hurried } else { self.idle }
    }
}

/// A number, and the time since it last changed.
struct Idle {
    seen: u64,
    since: Instant,
}

impl Idle {
    fn new(seen: u64) -> Self {
        Self {
            seen,
            since: Instant::now(),
        }
    }

    /// How long the number has not changed, if that is too long.
    fn too_long(&mut self, now: u64, patience: &Patience) -> Option<Duration> {
        if now != self.seen {
            *self = Self::new(now);
        }
        let limit = patience.now();
        (self.since.elapsed() >= limit).then_some(limit)
    }
}

/// Why an encoder failed.
#[derive(Debug)]
pub(super) enum Stop {
    /// It has ended, or closed its end of the pipe.
    Ended,
    /// It made no progress for so long, and was ended.
    Idle(Duration),
}

/// The running encoder. It is killed if dropped before it has ended.
#[derive(Debug)]
pub(super) struct Encoder {
    child: Child,
    input: Option<ChildStdin>,
    complaints: Option<JoinHandle<VecDeque<String>>>,
    /// Set when it was waited for.
    is_over: bool,
}

impl Encoder {
    pub(super) fn start(mut command: Command) -> io::Result<Self> {
        command
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        // In a process group of its own: Ctrl-C in the terminal is for this program,
        // which then finishes the video, and must not reach the encoder as well.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut running = running();
        let mut child = command.spawn()?;
        running.insert(child.id());
        drop(running);
        let (input, stderr) = (child.stdin.take(), child.stderr.take());
        // Its output is always read, because otherwise an encoder that prints much would block.
        let complaints = std::thread::spawn(move || stderr.map(last_lines).unwrap_or_default());
        Ok(Self {
            child,
            input,
            complaints: Some(complaints),
            is_over: false,
        })
    }

    /// Writes bytes to it. Ends it if it takes none for too long.
    pub(super) fn feed(&mut self, bytes: &[u8], patience: &Patience) -> Result<(), Stop> {
        /// More than a pipe takes at once, to save calls.
        const PART: usize = 1 << 20;
        let Self { child, input, .. } = self;
        let Some(pipe) = input else {
            return Err(Stop::Ended);
        };
        let taken = AtomicU64::new(0);
        std::thread::scope(|scope| {
            let (done, fed) = mpsc::channel::<()>();
            let taken = &taken;
            let watch = scope.spawn(move || {
                let mut idle = Idle::new(0);
                while let Err(RecvTimeoutError::Timeout) = fed.recv_timeout(10 * LOOK_EVERY) {
                    let now = taken.load(Ordering::Relaxed);
                    if let Some(limit) = idle.too_long(now, patience) {
                        // That closes the pipe, so writing to it fails.
                        signals::kill_group(child);
                        return Some(limit);
                    }
                }
                None
            });
            let mut rest = bytes;
            let written = loop {
                if rest.is_empty() {
                    break Ok(());
                }
                match pipe.write(&rest[..rest.len().min(PART)]) {
                    Ok(0) => break Err(()),
                    Ok(count) => {
                        rest = &rest[count..];
                        taken.fetch_add(count as u64, Ordering::Relaxed);
                    }
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(_) => break Err(()),
                }
            };
            drop(done);
            match watch.join().ok().flatten() {
                Some(limit) => Err(Stop::Idle(limit)),
                None => written.map_err(|()| Stop::Ended),
            }
        })
    }

    /// Closes its input and waits until the video is complete, as long as its file grows.
    pub(super) fn wait(&mut self, file: &Path, patience: &Patience) -> Result<ExitStatus, Stop> {
        drop(self.input.take());
        let length = || std::fs::metadata(file).map_or(0, |file| file.len());
        let mut idle = Idle::new(length());
        let mut looks = 0_u32;
        while !signals::has_ended(&mut self.child) {
            std::thread::sleep(LOOK_EVERY);
            looks += 1;
            if looks.is_multiple_of(10)
                && let Some(limit) = idle.too_long(length(), patience)
            {
                self.end();
                return Err(Stop::Idle(limit));
            }
        }
        self.end().ok_or(Stop::Ended)
    }

    /// Closes its input and waits for so long; returns the exit status, or `None` after killing it.
    pub(super) fn wait_at_most(&mut self, patience: Duration) -> Option<ExitStatus> {
        drop(self.input.take());
        let has_ended = holds_within(patience, || signals::has_ended(&mut self.child));
        let status = self.end();
        status.filter(|_| has_ended)
    }

    /// Ends it if it still runs, with its child processes; returns the exit status.
    pub(super) fn end(&mut self) -> Option<ExitStatus> {
        drop(self.input.take());
        if !self.is_over {
            // Until it is waited for, its process id and its group id are not reused.
            let mut running = running();
            signals::kill_group(&mut self.child);
            running.remove(&self.child.id());
            self.is_over = true;
        }
        self.child.wait().ok()
    }

    /// The last lines of its output, after it has ended.
    pub(super) fn last_words(&mut self) -> String {
        // A child process in another group may still hold its end of the pipe.
        let lines = match self.complaints.take() {
            Some(thread) if holds_within(LAST_WORDS_WITHIN, || thread.is_finished()) => {
                thread.join().ok()
            }
            _ => None,
        };
        Vec::from(lines.unwrap_or_default()).join("\n")
    }
}

impl Drop for Encoder {
    fn drop(&mut self) {
        self.end();
    }
}

/// Ends all running encoders, before the program exits at once.
pub(super) fn end_all() {
    let running = running();
    for &group in running.iter() {
        signals::kill_group_of(group);
    }
    // No new encoder can start.
    std::mem::forget(running);
}

/// Ignores poisoning: the value is still valid after a panic elsewhere.
fn running() -> MutexGuard<'static, BTreeSet<u32>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Does the condition become true in time?
fn holds_within(patience: Duration, mut condition: impl FnMut() -> bool) -> bool {
    let deadline = Instant::now() + patience;
    loop {
        if condition() {
            return true;
        }
        if Instant::now() >= deadline {
            return false;
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

/// The last lines, however much it prints; long lines are cut.
fn last_lines(mut stderr: ChildStderr) -> VecDeque<String> {
    let mut lines = VecDeque::new();
    let mut keep = |line: &mut Vec<u8>| {
        if lines.len() == LAST_WORDS {
            lines.pop_front();
        }
        let text = String::from_utf8_lossy(line);
        lines.push_back(escaped(text.trim_end()).into_owned());
        line.clear();
    };
    let mut line = Vec::new();
    let mut part = [0; 8192];
    loop {
        let count = match stderr.read(&mut part) {
            Ok(0) => break,
            Ok(count) => count,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => break,
        };
        for &byte in &part[..count] {
            if byte == b'\n' {
                keep(&mut line);
            } else if line.len() < LONGEST_LINE {
                line.push(byte);
            }
        }
    }
    if !line.is_empty() {
        keep(&mut line);
    }
    lines
}
