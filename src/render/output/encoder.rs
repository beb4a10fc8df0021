//! The program that encodes, as a process: fed through a pipe, waited for with a limit, and ended with all that it has started.

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

/// How many lines of the encoder's complaints an error quotes.
const LAST_WORDS: usize = 6;
/// Bytes of each of them that are kept, whatever it prints.
const LONGEST_LINE: usize = 300;

/// How long an encoder that has ended, or is to be ended, may keep its end of the pipe.
const LAST_WORDS_WITHIN: Duration = Duration::from_secs(2);

/// Between looks at an encoder that is waited for.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// The groups of encoders that run, by the number of their first process.
static RUNNING: Mutex<BTreeSet<u32>> = Mutex::new(BTreeSet::new());

/// How long an encoder may do nothing that can be seen: take no bytes, or write none.
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

/// What has not changed for how long.
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

    /// Has this number been the same for too long? Then how long that is.
    fn too_long(&mut self, now: u64, patience: &Patience) -> Option<Duration> {
        if now != self.seen {
            *self = Self::new(now);
        }
        let limit = patience.now();
        (self.since.elapsed() >= limit).then_some(limit)
    }
}

/// Why an encoder takes no more frames, or has made no video.
#[derive(Debug)]
pub(super) enum Stop {
    /// It has ended, or closed its end of the pipe.
    Ended,
    /// It did nothing for so long, and was ended.
    Idle(Duration),
}

/// The running encoder. Dropped before it has ended, it is ended.
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
        // Read all the time, or an encoder with much to say would wait for ever.
        let complaints = std::thread::spawn(move || stderr.map(last_lines).unwrap_or_default());
        Ok(Self {
            child,
            input,
            complaints: Some(complaints),
            is_over: false,
        })
    }

    /// Gives it bytes. Ends it if it takes none for too long.
    pub(super) fn feed(&mut self, bytes: &[u8], patience: &Patience) -> Result<(), Stop> {
        /// More than a pipe takes at once, so that a part is not a matter of many calls.
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
                        // The pipe is closed by that, and writing to it fails.
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

    /// No more frames: waits until the video is made, as long as the file that it writes grows.
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

    /// No more frames: how it ended within the time; if it did not, it is ended and there is no status.
    pub(super) fn wait_at_most(&mut self, patience: Duration) -> Option<ExitStatus> {
        drop(self.input.take());
        let has_ended = holds_within(patience, || signals::has_ended(&mut self.child));
        let status = self.end();
        status.filter(|_| has_ended)
    }

    /// Ends it if it still runs, with what it has started; how it ended.
    pub(super) fn end(&mut self) -> Option<ExitStatus> {
        drop(self.input.take());
        if !self.is_over {
            // Until it is waited for, its number is no other process's, and its group has no other one's.
            let mut running = running();
            signals::kill_group(&mut self.child);
            running.remove(&self.child.id());
            self.is_over = true;
        }
        self.child.wait().ok()
    }

    /// What it said last, once it has ended.
    pub(super) fn last_words(&mut self) -> String {
        // A program that it has left behind in another group may still hold its end of the pipe.
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

/// Ends all encoders that run, for a program that ends at once.
pub(super) fn end_all() {
    let running = running();
    for &group in running.iter() {
        signals::kill_group_of(group);
    }
    // No other one begins.
    std::mem::forget(running);
}

/// What a panic elsewhere has left is still good.
fn running() -> MutexGuard<'static, BTreeSet<u32>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the condition comes true in time.
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

/// The last lines, however much it prints: of a line without an end, the beginning.
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
