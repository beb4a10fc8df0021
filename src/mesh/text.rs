//! Models as text: encodings, line ends, and quotes in messages.

use std::borrow::Cow;

use super::error::MeshProblem;

/// The text of a file in UTF-8 or UTF-16. Bytes that are neither become `U+FFFD`: names and comments in other encodings
/// are of no interest.
pub(crate) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    if let Some((rest, unit)) = wide(bytes) {
        let units: Vec<u16> = rest.as_chunks().0.iter().copied().map(unit).collect();
        return Cow::Owned(String::from_utf16_lossy(&units));
    }
    String::from_utf8_lossy(without_mark(bytes))
}

/// Is a file UTF-16? It begins with a byte order mark or with two ASCII characters of two bytes each.
pub(crate) fn is_utf16(bytes: &[u8]) -> bool {
    wide(bytes).is_some()
}

/// The bytes behind a byte order mark in UTF-8.
pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Makes a code unit of two bytes.
type Unit = fn([u8; 2]) -> u16;

/// Of a file in UTF-16, the bytes behind its byte order mark and their order.
fn wide(bytes: &[u8]) -> Option<(&[u8], Unit)> {
    let are_ascii = |a: u8, b: u8| matches!((a, b), (1..=127, 1..=127));
    match *bytes {
        [0xff, 0xfe, ref rest @ ..] => Some((rest, u16::from_le_bytes)),
        [0xfe, 0xff, ref rest @ ..] => Some((rest, u16::from_be_bytes)),
        [a, 0, b, 0, ..] if are_ascii(a, b) => Some((bytes, u16::from_le_bytes)),
        [0, a, 0, b, ..] if are_ascii(a, b) => Some((bytes, u16::from_be_bytes)),
        _ => None,
    }
}

/// Lines that end in LF, CRLF or CR.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n')
        .flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'))
}

/// A line that cannot be read, with its beginning.
pub(crate) fn bad_line(line: usize, why: &str, text: &str) -> MeshProblem {
    MeshProblem::BadLine {
        line,
        why: why.to_owned(),
        text: beginning(text),
    }
}

/// A line that lacks numbers, with its beginning. A word that is nearly a number is named instead.
pub(crate) fn bad_number(line: usize, why: &str, text: &str) -> MeshProblem {
    let hint = text.split_ascii_whitespace().find_map(nearly_number);
    bad_line(line, hint.as_deref().unwrap_or(why), text)
}

/// The first letters of a text, without control characters.
pub(crate) fn beginning(text: &str) -> String {
    let printable = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    text.chars().take(60).map(printable).collect()
}

/// The problem of a number in the style of other countries or of Fortran.
fn nearly_number(word: &str) -> Option<String> {
    if word.len() > 40 || word.parse::<f64>().is_ok() {
        return None;
    }
    let is_number = |word: String| word.parse::<f64>().is_ok();
    if is_number(word.replacen(',', ".", 1)) {
        return Some(format!("`{word}` needs a decimal point, not a comma"));
    }
    if is_number(word.replace(['d', 'D'], "e")) {
        return Some(format!("`{word}` needs an exponent with E, not D"));
    }
    None
}
