//! Text to people and programs: data to the standard output, messages to the standard error.

use std::io::Write as _;

use myxo::{Error, Result};

/// What errors call the standard output.
pub const STDOUT: &str = "the standard output";

/// Prints data, which is a whole text or a part of it that ends with a line.
pub fn print(data: impl AsRef<[u8]>) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    stdout
        .write_all(data.as_ref())
        .and_then(|()| stdout.flush())
        .map_err(|source| Error::Io {
            action: "write to",
            path: STDOUT.into(),
            source,
        })
}

/// Tells people something, in a line of its own. Nobody listening is no reason to stop.
pub fn message(text: &str) {
    let _ = writeln!(std::io::stderr().lock(), "{}", text.trim_end());
}
