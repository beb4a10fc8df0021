//! Writing with progress, which another thread can cancel.

use std::io::{self, Seek, SeekFrom, Write};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The written bytes of a file, and whether it was cancelled.
#[derive(Debug, Default)]
pub struct Watch {
    cancelled: AtomicBool,
    written: AtomicU64,
}

impl Watch {
    /// Cancels the file: writing fails with the next block, and leaves no file.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// Was it cancelled?
    #[must_use]
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// Bytes so far.
    #[must_use]
    pub fn written(&self) -> u64 {
        self.written.load(Ordering::Relaxed)
    }
}

/// A file that is watched.
pub(super) struct Watched<'a, W> {
    inner: W,
    watch: &'a Watch,
}

impl<'a, W> Watched<'a, W> {
    pub(super) fn new(inner: W, watch: &'a Watch) -> Self {
        Self { inner, watch }
    }

    pub(super) fn into_inner(self) -> W {
        self.inner
    }
}

impl<W: Write> Write for Watched<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.watch.is_cancelled() {
            return Err(io::Error::other("it was cancelled"));
        }
        let count = self.inner.write(bytes)?;
        self.watch
            .written
            .fetch_add(count as u64, Ordering::Relaxed);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<W: Seek> Seek for Watched<'_, W> {
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        self.inner.seek(position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_counted_until_it_is_cancelled() {
        let watch = Watch::default();
        let mut file = Watched::new(io::Cursor::new(Vec::new()), &watch);
        file.write_all(b"twelve bytes").unwrap();
        assert_eq!((watch.written(), watch.is_cancelled()), (12, false));
        watch.cancel();
        let error = file.write_all(b"more").unwrap_err();
        assert!(error.to_string().contains("cancelled"), "{error}");
        assert_eq!(file.into_inner().into_inner(), b"twelve bytes");
    }
}
