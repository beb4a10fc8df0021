//! Text from files and file names in messages: without control characters, which a terminal would execute, and at most a line long.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::path::Path;

/// Words up to this many letters are quoted whole; no file name is longer.
const LONGEST_WORD: usize = 300;
/// Quoted letters of a long word or a long text.
const KEPT_OF_WORD: usize = 60;
/// Texts up to this many letters are quoted whole.
const LONGEST_LINE: usize = 2000;

/// May a terminal execute the character, or show its neighbours in another order? C0 and C1 control characters, DEL, and
/// those that override the direction of text.
#[must_use]
pub fn is_control(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// With every control character written as `\u{1b}`, line breaks too.
///
/// ```
/// use myxo::plain_text::escaped;
///
/// assert_eq!(escaped("a name\u{1b}[2J"), "a name\\u{1b}[2J");
/// assert_eq!(escaped("two\nlines"), "two\\nlines");
/// ```
#[must_use]
pub fn escaped(text: &str) -> Cow<'_, str> {
    replaced(text, is_control, |text, c| match c {
        '\n' => text.push_str("\\n"),
        '\r' => text.push_str("\\r"),
        '\t' => text.push_str("\\t"),
        c => drop(write!(text, "\\u{{{:x}}}", c as u32)),
    })
}

/// As [`escaped`], but with line breaks as they are: for whole messages.
#[must_use]
pub fn escaped_lines(text: &str) -> Cow<'_, str> {
    let is_inside = |c| c != '\n' && is_control(c);
    replaced(text, is_inside, |text, c| {
        let _ = write!(text, "\\u{{{:x}}}", c as u32);
    })
}

/// Paths in messages: on one line, without control characters.
pub trait Shown {
    /// The path, [escaped]; a byte that is not Unicode becomes a replacement character.
    ///
    /// ```
    /// use std::path::Path;
    ///
    /// use myxo::plain_text::Shown as _;
    ///
    /// assert_eq!(Path::new("a\nb.toml").shown(), "a\\nb.toml");
    /// ```
    fn shown(&self) -> Cow<'_, str>;
}

impl Shown for Path {
    fn shown(&self) -> Cow<'_, str> {
        match self.to_string_lossy() {
            Cow::Borrowed(text) => escaped(text),
            Cow::Owned(text) => Cow::Owned(escaped(&text).into_owned()),
        }
    }
}

/// For data that people and programs read: line breaks and tabs as they are, and other control characters as `\u001b`, which
/// JSON and TOML read back as the character.
#[must_use]
pub fn escaped_data(text: &str) -> Cow<'_, str> {
    let is_inside = |c| c != '\n' && c != '\t' && is_control(c);
    replaced(text, is_inside, |text, c| {
        let _ = write!(text, "\\u{:04x}", c as u32);
    })
}

/// As [`escaped`], with long words and long texts shortened to their beginnings: for names and values that come
/// from files.
#[must_use]
pub fn quoted(text: &str) -> Cow<'_, str> {
    // Most texts are short.
    if text.len() <= LONGEST_WORD {
        return escaped(text);
    }
    let mut line = String::new();
    let words = text.split_inclusive(char::is_whitespace);
    for word in words {
        let bare = word.trim_end_matches(char::is_whitespace);
        match bare.char_indices().nth(LONGEST_WORD) {
            None => line.push_str(bare),
            Some(_) => line.push_str(&beginning(bare, KEPT_OF_WORD)),
        }
        line.push_str(&word[bare.len()..]);
        if line.len() > 4 * LONGEST_LINE {
            break;
        }
    }
    match line.char_indices().nth(LONGEST_LINE) {
        None => Cow::Owned(escaped(&line).into_owned()),
        Some((end, _)) => Cow::Owned(escaped(&line[..end]).into_owned() + "..."),
    }
}

fn beginning(text: &str, letters: usize) -> String {
    let end = text.char_indices().nth(letters);
    let (kept, rest) = text.split_at(end.map_or(text.len(), |(at, _)| at));
    format!("{kept}... ({} letters more)", rest.chars().count())
}

fn replaced(
    text: &str,
    is_replaced: impl Fn(char) -> bool,
    write: impl Fn(&mut String, char),
) -> Cow<'_, str> {
    if !text.contains(&is_replaced) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if is_replaced(c) {
            write(&mut plain, c);
        } else {
            plain.push(c);
        }
    }
    Cow::Owned(plain)
}

/// A text as a field of a row of comma-separated values: in quotes if it would be read as several fields, as several rows, or as a
/// comment.
///
/// ```
/// use myxo::plain_text::in_csv;
///
/// assert_eq!(in_csv("a b"), "a b");
/// assert_eq!(in_csv("a, \"b\""), "\"a, \"\"b\"\"\"");
/// assert_eq!(in_csv("#1"), "\"#1\"");
/// ```
#[must_use]
pub fn in_csv(text: &str) -> Cow<'_, str> {
    if text.contains(['"', ',', '\n', '\r']) || text.starts_with('#') {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

/// 1234567 as `1,234,567`, without a fraction.
#[must_use]
pub fn with_commas(value: f64) -> String {
    let digits = format!("{:.0}", value.abs());
    let mut text = String::from(if value < 0.0 { "-" } else { "" });
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A count with its noun.
///
/// ```
/// use myxo::plain_text::counted;
///
/// assert_eq!(counted(1, "edge", "edges"), "1 edge");
/// assert_eq!(counted(1234, "edge", "edges"), "1,234 edges");
/// ```
#[must_use]
pub fn counted(count: usize, one: &str, many: &str) -> String {
    let noun = if count == 1 { one } else { many };
    format!("{} {noun}", with_commas(count as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Catches a range of control characters that is left out: C0, DEL, C1 with its one-character CSI, and overrides of the
    /// direction, by which a name looks like another one.
    #[test]
    fn no_control_character_is_left() {
        let all: String = (0..0x3000).filter_map(char::from_u32).collect();
        for plain in [escaped(&all), escaped_lines(&all), escaped_data(&all)] {
            let left: Vec<char> = plain.chars().filter(|&c| is_control(c)).collect();
            assert!(left.iter().all(|c| ['\n', '\t'].contains(c)), "{left:?}");
        }
        assert!(!escaped(&all).contains(['\n', '\t']));
        for (c, expected) in [
            ('\u{1b}', "\\u{1b}"),
            ('\u{7f}', "\\u{7f}"),
            ('\u{9b}', "\\u{9b}"),
            ('\u{202e}', "\\u{202e}"),
            ('\u{2066}', "\\u{2066}"),
            ('é', "é"),
        ] {
            assert_eq!(escaped_lines(&c.to_string()), expected);
        }
    }

    /// Catches data that is changed by its escapes: a program reads the name that the file has.
    #[test]
    fn escapes_of_data_are_read_back_by_json() {
        let name = "a\u{1b}[31m\u{7f}\u{9b}\u{202e}é\n\t\"\\";
        let json = serde_json::to_string(name).unwrap();
        let plain = escaped_data(&json);
        assert!(!plain.contains(is_control), "{plain}");
        assert_eq!(serde_json::from_str::<String>(&plain).unwrap(), name);
    }

    /// Catches words of a million letters, and texts of a million words, that fill the terminal.
    #[test]
    fn long_texts_are_quoted_by_their_beginning() {
        let text = "line 3: there is no key `radios`, did you mean `radius`?";
        assert_eq!(quoted(text), text);
        let long = format!("there is no key `{}é`: see below", "x".repeat(100_000));
        let expected = format!(
            "there is no key `{}... (99944 letters more) see below",
            "x".repeat(59)
        );
        assert_eq!(quoted(&long), expected);
        let words = "a b\n".repeat(1_000_000);
        let line = quoted(&words);
        assert!(line.len() < 2 * LONGEST_LINE && line.ends_with("..."));
        assert!(!line.contains('\n'));
    }
}
