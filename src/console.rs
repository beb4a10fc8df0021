//! Text to people and programs: data to the standard output, messages to the standard error.
//!
//! All output to a terminal goes through here: names and values from files may hold control characters, which become visible text.

use std::io::{IsTerminal as _, Write};

use myxo::plain_text::{escaped_data, escaped_lines};
use myxo::{Error, Result};

/// The name of the standard output in errors.
pub const STDOUT: &str = "the standard output";
/// Moves to the beginning of the line and clears it.
const CLEAR_LINE: &str = "\r\x1b[2K";

/// Prints a text or JSON, or a part of it that ends with a line.
pub fn print(text: impl AsRef<str>) -> Result<()> {
    write_all(escaped_data(text.as_ref()).as_bytes())
}

/// Writes a file's content to the standard output, unchanged unless that is a terminal, where control characters are escaped.
pub fn write(content: &[u8]) -> Result<()> {
    if std::io::stdout().is_terminal() {
        print(String::from_utf8_lossy(content))
    } else {
        write_all(content)
    }
}

fn write_all(bytes: &[u8]) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    stdout
        .write_all(bytes)
        .and_then(|()| stdout.flush())
        .map_err(Error::io("write to", STDOUT))
}

/// Writes a line to the terminal. Failures, such as a closed terminal, are ignored.
pub fn message(text: &str) {
    let _ = write_line(&mut std::io::stderr().lock(), text);
}

/// As [`message`], but replaces the terminal's current line.
pub fn message_over_line(text: &str) {
    let mut stderr = std::io::stderr().lock();
    if stderr.is_terminal() {
        let _ = stderr.write_all(CLEAR_LINE.as_bytes());
    }
    let _ = write_line(&mut stderr, text);
}

fn write_line(to: &mut impl Write, text: &str) -> std::io::Result<()> {
    writeln!(to, "{}", escaped_lines(text.trim_end()))
}

/// Sends log lines to the standard error, warnings and worse unless `RUST_LOG` says otherwise.
pub fn log() {
    let environment = env_logger::Env::default().default_filter_or("warn,winit=error");
    env_logger::Builder::from_env(environment)
        .format(|to, record| {
            let style = to.default_level_style(record.level());
            let (level, from) = (record.level(), record.target());
            let text = record.args().to_string();
            writeln!(
                to,
                "[{style}{level:<5}{style:#} {from}] {}",
                escaped_lines(&text)
            )
        })
        .init();
}
