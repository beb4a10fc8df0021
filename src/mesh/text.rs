//! Models as text: encodings, line ends, and what messages quote.

use std::borrow::Cow;

use super::error::MeshProblem;

/// The text of a file in UTF-8 or, with a byte order mark, in UTF-16. Bytes that are neither become `U+FFFD`: names and
/// comments in other encodings are of no interest.
pub(crate) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let wide = |rest: &[u8], unit: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = rest.as_chunks().0.iter().copied().map(unit).collect();
        Cow::Owned(String::from_utf16_lossy(&units))
    };
    match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest),
        _ => String::from_utf8_lossy(bytes),
    }
}

/// Lines that end in LF, CRLF or CR.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = &str> {
    text.split('\n')
        .flat_map(|line| line.strip_suffix('\r').unwrap_or(line).split('\r'))
}

/// A line that cannot be read, with its beginning. Words that are nearly numbers are named, whatever else the line lacks.
pub(crate) fn bad_line(line: usize, why: &str, text: &str) -> MeshProblem {
    let why = text
        .split_ascii_whitespace()
        .find_map(nearly_number)
        .unwrap_or_else(|| why.to_owned());
    MeshProblem::BadLine {
        line,
        why,
        text: beginning(text),
    }
}

/// The first letters of a text, without control characters.
pub(crate) fn beginning(text: &str) -> String {
    let printable = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    text.chars().take(60).map(printable).collect()
}

/// What is wrong with a number in the style of other countries or of Fortran.
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
